//! Symmetries in time of an orbit.

use crate::excitation::Side;
use crate::model::{Model, State};
use crate::ode::{Observer, Step};
use std::ops::ControlFlow;

/// Observer that measures how far an orbit is from having a symmetry in time: a shorter period, or
/// x(t + T/2) = -x(t). Only velocities are compared: coordinates may drift along rigid motions.
pub(crate) struct Symmetries {
    /// Time of each comparison, and the sign of the velocities there.
    places: Vec<(f64, f64)>,
    first: Vec<f64>,
    /// Velocities at the places.
    later: Vec<Vec<f64>>,
    y: Vec<f64>,
}

/// Share of the unit of a velocity below which an orbit has a symmetry `[1]`.
const SYMMETRIC: f64 = 1e-6;

/// Ratio of the distances from a symmetry of an orbit without it and of one with it from which on a step
/// between them has gained or lost it `[1]`. The distance of large motions falls slowly through
/// [`SYMMETRIC`].
const SUDDEN: f64 = 100.0;

/// Whether one of two neighbouring orbits has a symmetry that the other one lacks, by their
/// [distances](Symmetries::distances) from each.
pub(crate) fn differ(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).any(|(a, b)| {
        let (with, without) = (a.min(*b), a.max(*b));
        with <= SYMMETRIC && without > SYMMETRIC && without > SUDDEN * with
    })
}

/// Distances of the states that show whether a model has the symmetry of its orbit, as shares of the ranges
/// of motion `[1]`.
const ASIDE: [f64; 3] = [0.37, -0.71, 1.3];

/// Whether the accelerations of a model have the symmetry a(t + T/2, -q, -v) = -a(t, q, v). They are compared
/// in three states around `state`. An orbit may have x(t + T/2) = -x(t) by chance, without this symmetry of
/// its model. `half`: T/2; `ranges`: of coordinates and velocities.
pub(crate) fn reverses(model: &dyn Model, state: &State, half: f64, ranges: &[f64]) -> bool {
    let n = model.dof();
    let accelerations = |t: f64, y: &[f64]| {
        let (mut u, mut a) = (vec![0.0; model.drives()], vec![0.0; n]);
        model.drive(t, Side::After, &mut u);
        model.accel(&u, &y[..n], &y[n..], &mut a);
        a
    };
    ASIDE.iter().all(|share| {
        let values = state.q.iter().chain(&state.v).zip(ranges).enumerate();
        // Unequal distances of all components.
        let y: Vec<f64> = values.map(|(i, (y, range))| y + share * range / (1.0 + 0.3 * i as f64)).collect();
        let reversed: Vec<f64> = y.iter().map(|y| -y).collect();
        let (here, later) = (accelerations(state.t, &y), accelerations(state.t + half, &reversed));
        let size = here.iter().fold(0.0, |m: f64, a| m.max(a.abs()));
        here.iter().zip(&later).all(|(a, b)| (a + b).abs() <= SYMMETRIC * size)
    })
}

impl Symmetries {
    /// For orbits from `start` over `period`, which is `multiple` periods of the model.
    pub(crate) fn new(dof: usize, start: f64, period: f64, multiple: usize) -> Self {
        let is_prime = |p: &usize| (2..*p).all(|d| !p.is_multiple_of(d));
        let shorter = (2..=multiple).filter(|p| multiple.is_multiple_of(*p)).filter(is_prime);
        let mut places: Vec<(f64, f64)> =
            shorter.map(|p| (start + period * (1.0 - 1.0 / p as f64), 1.0)).collect();
        places.push((start + 0.5 * period, -1.0));
        let later = vec![Vec::with_capacity(dof); places.len()];
        Symmetries { places, first: Vec::with_capacity(dof), later, y: vec![0.0; 2 * dof] }
    }

    /// How far the orbit is from each of the symmetries, as a share of the unit of a velocity `[1]`. `units`:
    /// units of coordinates and velocities.
    pub(crate) fn distances(&self, units: &[f64]) -> Vec<f64> {
        let dof = self.y.len() / 2;
        let distance = |((_, sign), later): (&(f64, f64), &Vec<f64>)| match later.len() == dof {
            true => {
                (0..dof).map(|i| (sign * later[i] - self.first[i]).abs() / units[dof + i]).fold(0.0, f64::max)
            }
            false => f64::INFINITY,
        };
        self.places.iter().zip(&self.later).map(distance).collect()
    }
}

impl Observer for Symmetries {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        let dof = self.y.len() / 2;
        if self.first.is_empty() {
            step.at(step.t0(), &mut self.y);
            self.first.extend_from_slice(&self.y[dof..]);
        }
        for (i, (time, _)) in self.places.iter().enumerate() {
            if self.later[i].is_empty() && *time <= step.t1() {
                step.at(time.max(step.t0()), &mut self.y);
                self.later[i].extend_from_slice(&self.y[dof..]);
            }
        }
        ControlFlow::Continue(())
    }
}
