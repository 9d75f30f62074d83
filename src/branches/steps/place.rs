//! The points at which a step is searched, and the test functions whose signs tell of a bifurcation between
//! two of them.

use crate::branches::curve::engine::Engine;
use crate::branches::curve::point::CurvePoint;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::change::{Change, VERTICAL};
use crate::branches::points::test_functions::{doubling, from_above, from_below, nearest_to_doubling, torus};
use crate::numeric::search::parabola::may_dip;
use crate::periodic::Multipliers;

/// A point within a step.
pub(crate) struct Place<S> {
    /// Distance from the start of the step.
    pub(crate) sigma: f64,
    pub(crate) point: CurvePoint<S>,
    pub(crate) multipliers: Option<Multipliers>,
    /// Whether a contact grazes an edge.
    pub(crate) grazes: bool,
}

/// A real multiplier this close to -1 at both ends of a step may have passed it twice within the step `[1]`.
const NEAR_DOUBLING: f64 = 0.1;

/// Whether a real multiplier at a place lies near -1.
pub(crate) fn is_near_doubling<S>(place: &Place<S>) -> bool {
    place.multipliers.as_ref().is_some_and(|m| nearest_to_doubling(m) < NEAR_DOUBLING)
}

/// The bifurcations whose tests may change their sign twice between the places k and k + 1, which lie at
/// equal distances in √σ.
pub(crate) fn near_zero<S>(places: &[&Place<S>], k: usize) -> Vec<Change> {
    let near = |change: &Change| {
        let at = |i: usize| value(*change, places[i]).unwrap_or(f64::NAN);
        let after = k > 0 && may_dip([at(k - 1), at(k), at(k + 1)], [1.0; 2]);
        let before = k + 2 < places.len() && may_dip([at(k + 2), at(k + 1), at(k)], [1.0; 2]);
        after || before
    };
    Change::SINGLE.into_iter().filter(near).collect()
}

/// Whether the branch turns back and turns again between two places: the parameter rises at both, or falls at
/// both, but its change shows that the slope has passed 0. The slope is taken as the parabola with its values
/// at the ends and this change as its integral.
pub(crate) fn turns_twice<S>(a: &Place<S>, b: &Place<S>) -> bool {
    let (from, to) = (a.point.slope(), b.point.slope());
    let change = (b.point.p - a.point.p) / a.point.units[a.point.units.len() - 1];
    let mean = change / (b.sigma - a.sigma);
    if from * to <= 0.0 || from.abs().min(to.abs()) < VERTICAL {
        return false;
    }
    // from + (to - from) t + c t (1 - t) over 0 <= t <= 1, with c of the sign opposite to the slopes.
    let c = 6.0 * (mean - 0.5 * (from + to));
    let lowest = 0.5 * (to - from + c) / c;
    let least = from + (to - from) * lowest + c * lowest * (1.0 - lowest);
    c * from < 0.0 && (0.0..=1.0).contains(&lowest) && least * from < 0.0
}

/// The test function of a bifurcation at a place.
pub(crate) fn value<S>(change: Change, place: &Place<S>) -> Option<f64> {
    value_at(change, &place.point, || place.multipliers.clone())
}

fn value_at<S>(
    change: Change,
    point: &CurvePoint<S>,
    multipliers: impl FnOnce() -> Option<Multipliers>,
) -> Option<f64> {
    match change {
        Change::Fold => Some(point.slope()),
        Change::Branch => Some(point.sign * point.logarithm.exp()),
        Change::PeriodDoubling => multipliers().as_ref().map(doubling),
        Change::NeimarkSacker => multipliers().as_ref().and_then(torus),
        Change::Branches(k) => multipliers().as_ref().and_then(|m| from_above(m, k)),
        Change::PeriodDoublings(k) => multipliers().as_ref().and_then(|m| from_below(m, k)),
    }
}

/// The test function of a bifurcation.
pub(crate) fn test_of<C: OrbitMethod>(
    change: Change,
) -> impl FnMut(&mut Engine<C>, &CurvePoint<C::Solution>) -> Option<f64> {
    move |engine, point| value_at(change, point, || engine.curve.multipliers(point))
}
