//! The first contact that leaves its piece in a step.

use crate::contact::Contact;
use crate::contact::edge::Edge;
use crate::ode::edges::exit::{Elapsed, Exit, Found, is_wide, scale};
use crate::ode::edges::locate::{Locator, PLAIN};
use crate::ode::integrate_error::IntegrateError;
use crate::ode::stepping::control::RESOLUTION;
use crate::ode::stepping::ends::Ends;
use crate::ode::stepping::vector_blocks::Blocks;
use crate::ode::taylor::expansion::coefficients::ORDERS;
use crate::ode::taylor::expansion::plan::EdgeColumn;
use crate::ode::taylor::positive::{Fall, Polynomial};

/// A distance at the start of a step below this share of its range counts as near `[1]`.
const NEAR_START: f64 = 1e-9;

/// The distances of contacts from their edges as polynomials over a step.
pub(crate) trait Distances {
    /// The edges, with the columns of their distances.
    fn edges(&self) -> &[EdgeColumn];
    /// Highest order.
    fn degree(&self) -> usize;
    /// Coefficient n of a distance.
    fn coefficient(&self, n: usize, column: usize) -> f64;
    /// A time in [0, h] up to which the distance d in this column, times `sign`, is above `least` for
    /// certain. At the start d is above `least`.
    fn above_until(&self, column: usize, sign: f64, least: f64, h: f64) -> f64;
    /// A time in [0, h] up to which the distance d in this column, times `sign`, is above its value at the
    /// start for certain. The time is less than h if d is not above `least` at the end.
    fn risen_until(&self, column: usize, sign: f64, least: f64, h: f64) -> f64;
}

/// The first exit of a contact from its piece within a step of length `h`. `moves`: bounds of d(s) - d(0) in
/// the step for the distance d in a column.
///
/// # Errors
/// [`IntegrateError::NegativeGap`] if a gap is negative at the start of the step and a contact is on its edge
/// or comes near it.
pub(crate) fn first_exit(
    c: &impl Distances,
    e: &mut Ends<'_, Blocks>,
    locator: &mut Locator,
    moves: impl Fn(usize) -> [f64; 2],
    h: f64,
) -> Result<Found<Elapsed>, IntegrateError> {
    let (mut found, mut limit, mut read) = (Found::Nothing, h, false);
    for own in c.edges() {
        let &EdgeColumn { contact, edge, column: i, sign: reversed } = own;
        // A contact on a flank leaves it at one edge, a contact in the gap at both.
        let piece = e.pieces[contact];
        if !Edge::around(piece).contains(&edge) {
            continue;
        }
        let sign = reversed * piece.gap_sign();
        let start = sign * c.coefficient(0, i);
        if start == f64::INFINITY {
            continue; // the law has no such edge
        }
        let [least, most] = moves(i);
        let (range, lowest) = (most.max(-least), start + if sign > 0.0 { least } else { -most });
        // The bound of a long step exceeds its way by orders, which matters in wide gaps alone.
        let scale = scale(&e.contacts[contact]);
        let wide = is_wide(scale, c.coefficient(1, i).abs() * h);
        locator.goes(contact, if wide { range.min(way(c, i, h)) } else { range });
        let near = (NEAR_START * (start + range)).max(locator.slack_of(contact, scale));
        if lowest > near {
            continue;
        }
        let apart = start > near;
        let into_gap = |edge: &EdgeColumn| edge.sign * c.coefficient(0, edge.column);
        let gap = |other: &EdgeColumn| into_gap(own) + into_gap(other);
        let mut others = c.edges().iter().filter(|other| other.is_opposite(own));
        if !apart && !read && others.any(|other| gap(other) < 0.0) {
            read = contacts_at_start(e)?;
        }
        let above = if apart { c.above_until(i, sign, near, h) } else { c.risen_until(i, sign, near, h) };
        if above >= limit {
            continue;
        }
        let mut distance = Polynomial { c: [0.0; ORDERS], degree: c.degree() };
        for (n, coefficient) in distance.c[..=c.degree()].iter_mut().enumerate() {
            *coefficient = sign * c.coefficient(n, i);
        }
        // Most distances stay well above 0: the size of the contact is not needed.
        distance.c[0] = start - near;
        let fall = if apart { distance.first_fall(above, limit) } else { None };
        if apart && fall.is_none() {
            continue;
        }
        distance.c[0] = start;
        if !read {
            read = contacts_at_start(e)?;
        }
        let exit = Exit { contact, edge };
        // The slack is that at the start or on the edge, whichever is larger: a long step may start at a
        // deflection of 0.
        let at_start = &e.contacts[contact];
        let on_edge = Contact { deflection: edge.position(at_start), ..*at_start };
        let near_edge = locator.slack(contact, &on_edge);
        let slack = locator.slack(contact, at_start).max(near_edge);
        let root = match fall {
            // The distance falls past the edge without a turn: it has one root, and none before.
            Some(Fall { before: [a, from], after: [b, to], steady: true })
                if start > slack && to + near <= -slack =>
            {
                let fall = Fall { before: [a, from + near], after: [b, to + near], steady: true };
                Some(distance.root_in(&fall))
            }
            // A start within the slack counts as on the edge: the search begins at 0.
            Some(_) if start <= slack => leaves(&distance, slack, 0.0, limit),
            Some(fall) => leaves(&distance, slack, fall.before[0], limit),
            None => leaves(&distance, slack, above, limit),
        };
        match root {
            Some(root) if root <= RESOLUTION * e.t.abs() => return Ok(Found::AtOnce(exit)),
            Some(root) => {
                limit = root;
                found = Found::At(Elapsed(root), exit);
            }
            None if limit == h && matches!(found, Found::Nothing) => {
                // The contact reaches the edge at the end of the step. A run from there must find it on the
                // edge, whatever its deflection was at the start of this step.
                let (value, rate) = distance.with_slope(h);
                let has_risen = start > slack || distance.c[1] * h > PLAIN * slack;
                if has_risen && (-slack..=near_edge).contains(&value) && rate * h < -PLAIN * slack {
                    found = Found::At(Elapsed(h), exit);
                }
            }
            None => {}
        }
    }
    Ok(found)
}

/// The largest change of a distance at the quarters of a step of length `h`.
#[inline]
fn way(c: &impl Distances, column: usize, h: f64) -> f64 {
    let times = [0.25 * h, 0.5 * h, 0.75 * h, h];
    let mut ways = [0.0; 4];
    for n in (1..=c.degree()).rev() {
        let coefficient = c.coefficient(n, column);
        ways = std::array::from_fn(|k| (ways[k] + coefficient) * times[k]);
    }
    ways.into_iter().fold(0.0, |most, way: f64| most.max(way.abs()))
}

/// Computes the contacts at the start of the step. Returns true.
fn contacts_at_start(e: &mut Ends<'_, Blocks>) -> Result<bool, IntegrateError> {
    e.contacts_at_start();
    e.check_gaps(e.t)?;
    Ok(true)
}

/// The first time in (0, h] at which a distance becomes negative by more than the slack; 0 if it is on its
/// edge at the start and leaves at once. Up to the time `above` the distance is positive, or above its value
/// at the start.
fn leaves(distance: &Polynomial, slack: f64, above: f64, h: f64) -> Option<f64> {
    let start = distance.c[0];
    // A distance past its edge by more than the slack counts as on it.
    let slack =
        if start > slack { slack } else { slack.max(-start) * (1.0 + f64::EPSILON) + f64::MIN_POSITIVE };
    let beyond = distance.raised(slack).negative_after(above, h)?;
    if start > slack {
        return distance.first_root_after(above, beyond).or(Some(beyond));
    }
    // A start at rest has a rate of rounding.
    let first = if distance.c[1] > 0.0 { 1 } else { distance.first_term(beyond) };
    if distance.c[first] <= 0.0 {
        return Some(0.0);
    }
    // The contact has just entered and leaves again.
    let other = (0..first).fold(*distance, |d, _| d.without_root_at_zero()).first_root_after(above, beyond);
    Some(other.unwrap_or(beyond).max(f64::MIN_POSITIVE))
}
