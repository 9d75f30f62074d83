//! The halves of a symmetric orbit, x(t + T/2) = -x(t).

use crate::model::State;
use crate::periodic::shooting::shooting_orbit::OrbitParts;
use crate::periodic::{Multipliers, ShootingOrbit};
use nalgebra::DMatrix;

/// Share of the period by which a node may lie at its middle by rounding.
const MIDDLE: f64 = 1e-9;

/// The first half of an orbit, as an orbit over half the period.
pub(crate) fn first_half(orbit: &ShootingOrbit) -> ShootingOrbit {
    let (start, period) = (orbit.states()[0].t, orbit.period());
    let mut half = orbit.clone();
    half.parts.states.retain(|state| state.t - start < (0.5 - MIDDLE) * period);
    half.parts.end = start + 0.5 * period;
    half
}

/// The orbit whose first half is given, and its multipliers. A perturbation is reversed in each half: the
/// monodromy matrix is the square of that of the half.
pub(crate) fn whole(half: ShootingOrbit, multipliers: &Multipliers) -> (ShootingOrbit, Multipliers) {
    let time = half.period();
    let states = &half.parts.states;
    let later = states.iter().map(|state| State {
        t: state.t + time,
        q: state.q.iter().map(|q| -q).collect(),
        v: state.v.iter().map(|v| -v).collect(),
    });
    let states = states.iter().cloned().chain(later).collect();
    let monodromy = &half.parts.monodromy * &half.parts.monodromy;
    let error = 2.0 * multipliers.largest().max(1.0) * multipliers.value_error();
    let scaled = DMatrix::from_fn(monodromy.nrows(), monodromy.ncols(), |i, j| {
        monodromy[(i, j)] * half.parts.scale[j] / half.parts.scale[i]
    });
    let none = DMatrix::zeros(scaled.nrows(), 0);
    let found = Multipliers::without(&scaled, &none, error).unwrap_or_else(|_| multipliers.clone());
    let (end, crossings) = (half.parts.end + time, 2 * half.parts.crossings);
    let parts = OrbitParts { states, end, monodromy, multipliers: found.clone(), crossings, ..half.parts };
    (ShootingOrbit { parts, budget: half.budget }, found)
}
