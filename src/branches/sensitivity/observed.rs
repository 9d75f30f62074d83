//! Quantities along an orbit and their derivatives at one instant.

use crate::branches::sensitivity::quantity::Quantity;
use crate::contact::Piece;
use crate::excitation::Side;
use crate::ode::Step;
use crate::ode::probe::Probe;

/// Step of the differences of a quantity along the derivative of the orbit, in units of the constants.
pub(super) const STEP_ALONG_ORBIT: f64 = 2e-4;

/// Steps of the differences as shares of the usual one: a smaller one where neighbours lie on other pieces.
pub(super) const STEPS: [f64; 3] = [1.0, 1e-2, 1e-4];

/// Values of a quantity over a period and their derivatives with respect to the constants, in the units of
/// the constants.
#[derive(Clone, Debug)]
pub(crate) struct Derivatives {
    pub(crate) mean: f64,
    pub(crate) square: f64,
    pub(crate) by_mean: Vec<f64>,
    pub(crate) by_square: Vec<f64>,
    /// Maximum and minimum, each with its time, and their derivatives.
    pub(crate) extremes: [(f64, f64, Vec<f64>); 2],
    /// Derivatives at the wanted instant.
    pub(crate) at: Vec<f64>,
}

/// Place, weight and ratio of the periods of a neighbour, and its probe.
pub(super) type Placed<'g> = ([f64; 3], Probe<'g>);

/// Observer of the tangent flow.
pub(super) struct Gather<'g> {
    pub(super) quantities: &'g [Quantity],
    pub(super) base: Probe<'g>,
    /// For each of [`STEPS`] and each constant the places, weights and ratios of the periods of its
    /// neighbours, with their probes.
    pub(super) probes: Vec<Vec<Vec<Placed<'g>>>>,
    /// -T'/T for each constant.
    pub(super) speeds: Vec<f64>,
    pub(super) n: usize,
    pub(super) period: f64,
    pub(super) y: Vec<f64>,
    pub(super) moved: Vec<f64>,
    pub(super) out: Vec<Derivatives>,
    /// Scratch: derivatives at one instant.
    pub(super) slopes: Vec<f64>,
    /// An instant at which the derivatives are wanted.
    pub(super) instant: Option<f64>,
    /// The pieces of the current step; empty if it has none.
    pub(super) pieces: Vec<Piece>,
    /// The crossing at which the last step ended.
    pub(super) passed: Option<Passed>,
}

/// A crossing or an impact.
pub(super) struct Passed {
    /// Derivative of its time, at a fixed phase, by each constant.
    pub(super) times: Vec<f64>,
    /// Value of each quantity before it.
    pub(super) before: Vec<f64>,
}

impl Gather<'_> {
    /// Derivatives of quantity j at the state in `y`, at the time `t`, by neighbours on the pieces of the
    /// step.
    ///
    /// At a grazing there are none, and the usual neighbours decide. A distance is the same on all pieces.
    pub(super) fn along(&mut self, j: usize, t: f64, side: Side, out: &mut [f64]) {
        let quantity = self.quantities[j];
        let is_one = matches!(quantity, Quantity::Distance { .. });
        for (k, out) in out.iter_mut().enumerate() {
            let (usual, is_on_pieces) = self.along_one(quantity, k, t, side, 0);
            *out = usual;
            if is_one || is_on_pieces {
                continue;
            }
            for which in 1..STEPS.len() {
                let (slope, is_on_pieces) = self.along_one(quantity, k, t, side, which);
                if is_on_pieces {
                    *out = slope;
                    break;
                }
            }
        }
    }

    /// The derivative of a quantity by constant k with one of [`STEPS`], and whether all neighbours lie on
    /// the pieces of the step of the run.
    pub(super) fn along_one(
        &mut self,
        quantity: Quantity,
        k: usize,
        t: f64,
        side: Side,
        which: usize,
    ) -> (f64, bool) {
        let n = self.n;
        let (half, unit) = (self.y.len() / 2, STEPS[which] * STEP_ALONG_ORBIT);
        let (mut slope, mut is_on_pieces) = (0.0, true);
        for ([place, weight, ratio], probe) in &mut self.probes[which][k] {
            let step = *place * unit;
            for i in 0..n {
                let (q, v) = (self.y[i], self.y[half + i]);
                let (dq, dv) = (self.y[n * (1 + k) + i], self.y[half + n * (1 + k) + i]);
                self.moved[i] = q + step * dq;
                self.moved[n + i] = v + step * (dv + self.speeds[k] * v);
            }
            let (q, v) = self.moved.split_at(n);
            slope += *weight * quantity.read(probe, t * *ratio, side, q, v) / unit;
            let pieces = self.pieces.iter().zip(probe.contacts());
            is_on_pieces &= pieces.into_iter().all(|(piece, contact)| *piece == contact.piece());
        }
        (slope, is_on_pieces)
    }

    pub(super) fn value(&mut self, j: usize, t: f64, side: Side) -> f64 {
        let half = self.y.len() / 2;
        let (q, v) = (&self.y[..self.n], &self.y[half..half + self.n]);
        self.quantities[j].read(&mut self.base, t, side, q, v)
    }

    pub(super) fn look(&mut self, step: &mut Step<'_>, t: f64) -> Side {
        step.at(t, &mut self.y);
        if t == step.t1() { Side::Before } else { Side::After }
    }
}
