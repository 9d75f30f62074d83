//! Ends a step on an edge of a gap.

use crate::numeric::search::bracket::Bracket;
use crate::ode::edges::exit::Exit;
use crate::ode::edges::locate::{Late, Locator};
use crate::ode::integrate_error::IntegrateError;
use crate::ode::step::Crossing;
use crate::ode::stepping::control::shortest;
use crate::ode::stepping::engine::{Engine, Tableau};
use crate::ode::stepping::vector::Vector;

/// Maximum number of corrections of a step that ends on an edge. If it does not suffice, the run fails with
/// [`IntegrateError::EdgeStall`].
const RESTEPS: usize = 40;

/// Repeats the step. This function is not inlined, because repetitions are rare and the stages are large.
#[inline(never)]
fn attempt_again<T: Tableau, V: Vector>(e: &mut Engine<'_, V>) {
    e.attempt::<T, true>();
}

/// Repeats the step so that it ends on the edge at θ of the step.
///
/// On fixed pieces the trajectory is smooth past the edge: one repetition suffices if the acceleration is
/// known to be continuous there. Otherwise the end t1 of the step is corrected until the distance d from the
/// edge is within the slack: t1 ← t1 - d/d', Newton's method within a bracket. Without fixed pieces this is
/// necessary because the kink at the edge makes the dense output inaccurate.
///
/// # Errors
/// [`IntegrateError::EdgeStall`] if the end does not converge.
pub(crate) fn step_to_edge<T: Tableau, V: Vector>(
    e: &mut Engine<'_, V>,
    locator: &Locator,
    theta: f64,
    exit: Exit,
) -> Result<(), IntegrateError> {
    let (start, far) = (e.ends.t, e.ends.t1);
    let stall = Err(IntegrateError::EdgeStall { t: start, contact: exit.contact });
    let t1 = start + theta * e.ends.h();
    if t1 <= start {
        return stall;
    }
    e.aim(t1);
    attempt_again::<T, V>(e);
    e.evaluations += T::EVALUATIONS;
    e.ends.contacts_at_end();
    if e.on_fixed_pieces && locator.jumps[exit.contact] == Some(false) {
        return Ok(());
    }
    // The bracket starts as the full step. `None`: the distance there is not computed.
    let mut bracket = Bracket { lo: start, hi: far };
    let (mut at_lo, mut at_hi) = (None, None);
    for _ in 0..RESTEPS {
        let (value, rate, slack) = locator.miss(&e.ends.pieces, &e.ends.contacts, exit);
        // The distance cannot be smaller than the effect of rounding of the time and of the step.
        if value.abs() <= slack.max(rate.abs() * f64::EPSILON * e.ends.t1.abs().max(e.ends.h())) {
            return Ok(());
        }
        bracket.narrow(e.ends.t1, value > 0.0);
        if value > 0.0 {
            at_lo = Some(value)
        } else {
            at_hi = Some(value)
        }
        let Bracket { lo, hi } = bracket;
        let t1 = match (bracket.newton(e.ends.t1, value, rate), at_lo, at_hi) {
            (Some(newton), ..) => newton,
            (None, Some(a), Some(b)) => lo + (hi - lo) * a / (a - b),
            _ => bracket.middle(),
        };
        // Two neighbouring floating-point times remain: the one with the smaller distance is final.
        let last = t1 <= lo || t1 >= hi;
        let closest = match (at_lo, at_hi) {
            (Some(a), Some(b)) if a > -b => hi,
            (Some(_), _) => lo,
            _ => hi,
        };
        if last && closest == e.ends.t1 {
            return Ok(());
        }
        e.aim(if last { closest } else { t1 });
        attempt_again::<T, V>(e);
        e.evaluations += T::EVALUATIONS;
        e.ends.contacts_at_end();
        if last {
            return Ok(());
        }
    }
    stall
}

/// Shortens the step to the shortest one that ends with a crossing of the edge on which it starts. `stop`:
/// its latest end.
#[cold]
pub(crate) fn step_on_edge<T: Tableau, V: Vector>(e: &mut Engine<'_, V>, late: Late, stop: f64) {
    e.aim(stop.min(e.ends.t + late.after + shortest(e.ends.t, e.ends.h())));
    attempt_again::<T, V>(e);
    if late.strikes {
        e.ends.stand_still();
    }
    e.evaluations += T::EVALUATIONS;
    e.ends.contacts_at_end();
}

/// Compares the derivatives (v, a) on both sides of an edge and notes whether they jump: by more than 1e-7 of
/// their largest component. An edge with a jump is located more closely. `behind`: see
/// [`Engine::derivative_behind`].
pub(crate) fn note_jumps<V: Vector>(
    e: &mut Engine<'_, V>,
    locator: &mut Locator,
    crossings: &[Crossing],
    behind: f64,
) {
    // Without fixed pieces the state may lie on either side.
    if behind > 0.0 {
        e.derivative_behind(-behind);
    }
    let [now, kept, ..] = &mut e.k;
    kept.slice_mut().copy_from_slice(now.slice());
    e.derivative_behind(behind);
    let before = e.k[1].slice();
    let size = before.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let change = before.iter().zip(e.k[0].slice()).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
    for crossing in crossings.iter().filter(|c| !c.rebounds) {
        locator.jumps[crossing.contact] = Some(change > 1e-7 * size);
    }
}
