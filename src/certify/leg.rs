//! The motion from one node to the next, with at most one crossing.

use crate::certify::stretch::{Field, Square, Stretch};
use crate::certify::unproved::Unproved;
use crate::contact::Piece;
use crate::interval::number::Interval;
use crate::tape::operations::FormId;

/// A crossing on a leg.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Event {
    pub(super) contact: usize,
    /// The piece that the contact enters; at a rigid stop the flank of the stop.
    pub(super) to: Piece,
    pub(super) rebounds: bool,
    /// Approximate time.
    pub(super) near: f64,
}

/// The motion between two nodes: times, pieces, and the crossing if there is one.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Leg {
    pub(super) start: Interval,
    pub(super) end: Interval,
    /// Pieces of all contacts at the start.
    pub(super) pieces: Vec<Piece>,
    pub(super) event: Option<Event>,
}

/// What a leg makes of a box.
pub(super) struct Image {
    /// The image of the middle of the box.
    pub(super) middle: Vec<Interval>,
    /// The derivative over the box.
    pub(super) slope: Square,
    /// The time of the crossing, over the box.
    pub(super) crossing: Option<Interval>,
}

/// Smallest part of a stretch in which a sign is decided `[1]`.
const SMALLEST_PART: f64 = 1e-7;

/// Number of windows around a crossing that are tried, each a quarter of the one before.
const WINDOWS: usize = 14;

/// Newton steps for the instant of a crossing.
const REFINEMENTS: usize = 6;

/// The edges at which contacts leave their pieces: contact, form of the distance in the tangent tape, sign of
/// the distance on the piece.
fn edges<'t>(
    distances: &'t [[Option<FormId>; 2]],
    pieces: &'t [Piece],
) -> impl Iterator<Item = (usize, usize, FormId, f64)> + 't {
    pieces.iter().enumerate().flat_map(move |(contact, piece)| {
        let sides: &[(usize, f64)] = match piece {
            Piece::Gap => &[(0, 1.0), (1, 1.0)],
            Piece::Lower => &[(0, -1.0)],
            Piece::Upper => &[(1, -1.0)],
        };
        let form = move |&(side, sign): &(usize, f64)| Some((contact, side, distances[contact][side]?, sign));
        sides.iter().filter_map(form)
    })
}

/// Whether a distance keeps its sign over [a, b]; otherwise a time near which it may not.
fn keeps_sign(stretch: &Stretch<'_, '_>, form: FormId, sign: f64, a: f64, b: f64) -> Result<(), f64> {
    let mut open = vec![(a, b)];
    while let Some((a, b)) = open.pop() {
        let part = Interval::of_ends(a, b);
        let middle = part.middle();
        let around = stretch.distance(form, Interval::from(middle))
            + stretch.rate(form, part) * (part - Interval::from(middle));
        let value = around.common(stretch.distance(form, part)).unwrap_or(around) * sign;
        if value.low() > 0.0 {
            continue;
        }
        // A part of two neighbouring numbers has no middle.
        if b - a <= SMALLEST_PART * stretch.length || middle <= a || middle >= b {
            return Err(middle);
        }
        open.push((a, middle));
        open.push((middle, b));
    }
    Ok(())
}

/// Receives an enclosed stretch of the motion with its pieces and the time from its start at which it ends.
pub(super) type Seen<'s> = dyn FnMut(&Stretch<'_, '_>, &[Piece], Interval) + 's;

/// The image of the box `x` with the middle `m` after a leg, with every condition on its contacts proved.
pub(super) fn image(
    field: &Field<'_>,
    leg: &Leg,
    x: &[Interval],
    m: &[f64],
    seen: &mut Seen<'_>,
) -> Result<Image, Unproved> {
    let whole = leg.end - leg.start;
    if whole.low() <= 0.0 || !whole.is_bounded() {
        return Err(Unproved::Differs { what: "the times of the nodes".into() });
    }
    let m: Vec<Interval> = m.iter().map(|m| Interval::from(*m)).collect();
    match &leg.event {
        None => {
            let stretch = stretch(field, &leg.pieces, leg.start, x, whole.high())?;
            stays(field, &stretch, &leg.pieces, whole.high(), None)?;
            seen(&stretch, &leg.pieces, whole);
            let middle = stretch.narrow(leg.start, &m).state(whole);
            Ok(Image { middle, slope: stretch.slope(whole), crossing: None })
        }
        Some(event) => across(field, leg, event, x, &m, seen),
    }
}

fn stretch<'f, 'm>(
    field: &'f Field<'m>,
    pieces: &[Piece],
    time: Interval,
    x: &[Interval],
    length: f64,
) -> Result<Stretch<'f, 'm>, Unproved> {
    Stretch::new(field, pieces, time, x, length).ok_or(Unproved::Wrapping { t: time.middle(), length })
}

/// Proves that all contacts stay on their pieces up to the time `until` after the start. `rising`: a contact
/// that starts on this edge and moves away from it.
fn stays(
    field: &Field<'_>,
    stretch: &Stretch<'_, '_>,
    pieces: &[Piece],
    until: f64,
    rising: Option<(usize, usize)>,
) -> Result<(), Unproved> {
    let start = stretch.start().middle();
    for (contact, side, form, sign) in edges(&field.tangent.tape.distances, pieces) {
        let mut from = 0.0;
        if rising == Some((contact, side)) {
            from = until;
            let rises = |from: f64| (stretch.rate(form, Interval::of_ends(0.0, from)) * sign).low() > 0.0;
            let found = (0..WINDOWS).any(|_| {
                let found = rises(from);
                from *= if found { 1.0 } else { 0.25 };
                found
            });
            if !found {
                return Err(Unproved::NearGrazing { contact, t: start });
            }
        }
        keeps_sign(stretch, form, sign, from, until)
            .map_err(|at| Unproved::Leaves { contact, t: start + at })?;
    }
    Ok(())
}

/// The image of a box over a crossing.
///
/// The derivative of the leg is Φ⁺ S Φ⁻ with S = 1 + (f⁺ - f⁻) ∇h/h', over all states and instants of the
/// crossing.   Source: Leine & Nijmeijer, Sect. 7.4.
fn across(
    field: &Field<'_>,
    leg: &Leg,
    event: &Event,
    x: &[Interval],
    m: &[Interval],
    seen: &mut Seen<'_>,
) -> Result<Image, Unproved> {
    let (n, d) = (field.n, 2 * field.n);
    let &Event { contact, to, rebounds, near } = event;
    let grazing = Unproved::NearGrazing { contact, t: near };
    let length = (leg.end - leg.start).high();
    let about = near - leg.start.middle();
    if about <= 0.0 || about >= length {
        return Err(Unproved::Together { t: leg.start.middle(), after: near });
    }
    let first = stretch(field, &leg.pieces, leg.start, x, about + 0.5 * about.min(length - about))?;
    // The edge: that of the flank which the contact leaves or enters.
    let side = match (leg.pieces[contact], to) {
        (Piece::Lower, _) | (Piece::Gap, Piece::Lower) => 0,
        _ => 1,
    };
    let Some(form) = field.tangent.tape.distances[contact][side] else { return Err(grazing) };
    let own = field.motion.tape.distances[contact][side].unwrap_or(form);
    let sign = if leg.pieces[contact] == Piece::Gap { 1.0 } else { -1.0 };
    // A window in which the distance falls through 0.
    let mut window = 0.5 * about.min(first.length - about);
    let mut found = None;
    for _ in 0..WINDOWS {
        let [a, b] = [about - window, about + window];
        let falls = (first.rate(form, Interval::of_ends(a, b)) * sign).high() < 0.0
            && (first.distance(form, Interval::from(a)) * sign).low() > 0.0
            && (first.distance(form, Interval::from(b)) * sign).high() < 0.0;
        if falls {
            found = Some(Interval::of_ends(a, b));
            break;
        }
        window *= 0.25;
    }
    let mut at = found.ok_or(grazing.clone())?;
    let before = at.low();
    for _ in 0..REFINEMENTS {
        let middle = Interval::from(at.middle());
        let newton = middle - first.distance(form, middle) / first.rate(form, at);
        at = at.common(newton).ok_or(grazing.clone())?;
    }
    keeps_sign(&first, form, sign, 0.0, before)
        .map_err(|s| Unproved::Leaves { contact, t: leg.start.middle() + s })?;
    for (other, other_side, form, sign) in edges(&field.tangent.tape.distances, &leg.pieces) {
        if (other, other_side) != (contact, side) {
            keeps_sign(&first, form, sign, 0.0, at.high())
                .map_err(|s| Unproved::Leaves { contact: other, t: leg.start.middle() + s })?;
        }
    }
    // The instant for the middle of the box.
    let narrow = first.narrow(leg.start, m);
    let rate = first.rate(form, at);
    let mut at_middle = at;
    for _ in 0..REFINEMENTS {
        let middle = Interval::from(at_middle.middle());
        let newton = middle - narrow.distance(own, form, middle) / rate;
        at_middle = at_middle.common(newton).ok_or(grazing.clone())?;
    }
    let (mut state, mut middle) = (first.state(at), narrow.state(at_middle));
    let (time, time_middle) = (leg.start + at, leg.start + at_middle);
    let mut slope = first.slope(at);

    // f⁻, f⁺, ∇h Φ⁻ and the jump.
    let u = field.drive_series(time, near, 2);
    let slopes = field.edge_slopes[contact][side].as_ref().ok_or(grazing)?;
    let columns = field.with_columns(&state, &slope);
    let c = slopes.expand(&leg.pieces, &columns, &u, 0);
    let along: Vec<Interval> =
        (0..d).map(|k| c.form(slopes.tape.accelerations[n * (1 + k)], 0) / rate).collect();
    let accelerations = |pieces: &[Piece], state: &[Interval]| -> Vec<Interval> {
        let c = field.motion.expand(pieces, state, &u, 0);
        field.motion.tape.accelerations.iter().map(|&form| c.form(form, 0)).collect()
    };
    let mut pieces = leg.pieces.clone();
    let jumps_before = accelerations(&pieces, &state);
    if rebounds {
        let impact = field.impact(contact, to)?;
        // Neighbours arrive later by -∇h δ/h': moved to the edge, thrown back, moved to the common instant.
        let moved = Square::from_fn(d, |i, k| {
            let rate = if i < n { state[n + i] } else { jumps_before[i - n] };
            slope.at(i, k) - rate * along[k]
        });
        let thrown = impact.expand(&pieces, &field.with_columns(&state, &moved), &u, 0);
        let velocity = |i: usize, k: usize| thrown.form(impact.tape.accelerations[n * k + i], 0);
        let thrown_middle = impact.expand(&pieces, &field.with_columns(&middle, &Square::identity(d)), &u, 0);
        for i in 0..n {
            state[n + i] = velocity(i, 0);
            middle[n + i] = thrown_middle.form(impact.tape.accelerations[i], 0);
        }
        let after = accelerations(&pieces, &state);
        slope = Square::from_fn(d, |i, k| {
            let (of_row, rate) = match i < n {
                true => (moved.at(i, k), state[n + i]),
                false => (velocity(i - n, 1 + k), after[i - n]),
            };
            of_row + rate * along[k]
        });
    } else {
        pieces[contact] = to;
        let after = accelerations(&pieces, &state);
        slope = Square::from_fn(d, |i, k| match i < n {
            true => slope.at(i, k),
            false => slope.at(i, k) + (after[i - n] - jumps_before[i - n]) * along[k],
        });
    }
    if (leg.end - time).low() <= 0.0 {
        return Err(Unproved::Together { t: near, after: leg.end.middle() });
    }
    let second = stretch(field, &pieces, time, &state, (leg.end - time).high())?;
    stays(field, &second, &pieces, second.length, Some((contact, side)))?;
    seen(&first, &leg.pieces, at);
    seen(&second, &pieces, leg.end - time);
    let middle = second.narrow(time_middle, &middle).state(leg.end - time_middle);
    Ok(Image { middle, slope: second.slope(leg.end - time).times(&slope), crossing: Some(time) })
}
