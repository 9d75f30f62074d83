//! The deterministic part of a step: where the states of the grid come from.

use crate::Dop853;
use crate::model::{Model, State};
use crate::ode::{Finish, IntegrateError, Integrator, Step};
use crate::random::density::grid::Grid;
use crate::random::density::steps::reversed::Reversed;
use rayon::prelude::*;
use std::ops::ControlFlow;

/// For each node of a grid the state one step earlier and the factor of the density on the way:
/// p(x, v, t) = factor · p(X, V, t - h).
#[derive(Clone, Debug)]
pub(crate) struct Arrivals {
    from: Vec<[f64; 3]>,
}

impl Arrivals {
    /// Follows the motions that arrive at the nodes of the grid at `end` back over `duration`.
    pub(crate) fn new<const N: usize>(
        grid: &Grid<N>,
        model: &(dyn Model + Sync),
        damping: f64,
        end: f64,
        duration: f64,
    ) -> Result<Self, IntegrateError> {
        let size = |axis: &[f64]| axis[axis.len() - 1] - axis[0];
        let (x_size, v_size) = (size(&grid.x.nodes), size(&grid.v.nodes));
        let reversed = Reversed { base: model, end, damping, width: 1e-4 * v_size };
        let scales = [x_size, duration, v_size, 1.0].map(|scale| TOLERANCE * scale);
        let solver = Dop853::new().rtol(TOLERANCE).atol_each(&scales).max_steps(MOST_STEPS);
        let far = |axis: &[f64], size: f64, at: f64| at < axis[0] - size || at > axis[axis.len() - 1] + size;
        let follow = |x: f64, v: f64| {
            let start = State::new(0.0, &[x, 0.0], &[-v, 0.0]);
            // Backwards in time damped motions grow, some without bound in finite time: out there the
            // density is 0.
            let mut leave = |step: &mut Step<'_>| {
                let (x, v) = (step.q1()[0], -step.v1()[0]);
                let gone = far(&grid.x.nodes, x_size, x) || far(&grid.v.nodes, v_size, v);
                if gone { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let Finish { state, stopped, .. } =
                solver.run(&reversed as &dyn Model, &start, duration, &mut leave)?;
            let factor = if stopped { 0.0 } else { libm::exp(state.v[1]) };
            Ok([state.q[0], -state.v[0], factor])
        };
        let width = grid.v.len();
        let arrive = |node: usize| follow(grid.x.nodes[node / width], grid.v.nodes[node % width]);
        let from = (0..grid.len()).into_par_iter().map(arrive).collect::<Result<_, IntegrateError>>()?;
        Ok(Arrivals { from })
    }

    /// Writes the density after the step to `to`.
    pub(crate) fn apply<const N: usize>(&self, grid: &Grid<N>, from: &[f64], to: &mut [f64]) {
        let width = grid.v.len();
        to.par_chunks_mut(width).zip(self.from.par_chunks(width)).for_each(|(to, states)| {
            for (to, [x, v, factor]) in to.iter_mut().zip(states) {
                *to = factor * grid.value(from, *x, *v);
            }
        });
    }
}

/// Local error of the motions, as a share of the ranges.
const TOLERANCE: f64 = 1e-10;

/// Maximum number of steps of one motion. A step of the density is a fifth of the natural time: some ten are
/// needed.
const MOST_STEPS: usize = 10_000;
