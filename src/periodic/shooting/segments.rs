//! The segments of multiple shooting: integration over all segments, and norms of the corrections.

use crate::model::drive_slope::DriveSlope;
use crate::model::structure::drifts::{Drifts, unconnected};
use crate::model::{Model, State};
use crate::numeric::norms::right_vectors;
use crate::ode::budget::Meter;
use crate::periodic::flow::flow_method::{Expansion, FlowMethod};
use crate::periodic::flow::tangent::Tangent;
use crate::periodic::flow::variation::transition;
use crate::periodic::flow::walk::{SegmentError, segments};
use crate::periodic::multipliers::Multipliers;
use crate::periodic::shooting::failure::{Iterate, ShootingError};
use nalgebra::DMatrix;
use nalgebra::DVector;

/// Ratio of the flow tolerances of the two runs that estimate the error of the multipliers.
pub(crate) const LOOSER: f64 = 100.0;

/// Largest gain of a rigid velocity that is rounding, as a share of its range `[1]`.
const GAINS: f64 = 1e-9;

/// If the corrections do not become small, a multiplier of the last iterate within this distance of 1 is that
/// of a fold or a branch point `[1]`.
const FOLD: f64 = 1e-2;

/// The multipliers of an iterate say whether an orbit is at a fold if its last correction is below this share
/// of the range `[1]`. An iterate with a larger correction is far from an orbit.
const NEAR: f64 = 0.1;

/// The equations of an iterate far from an orbit are singular if a multiplier of it is within this distance
/// of 1 `[1]`.
const SINGULAR: f64 = 1e-4;

/// What the flow over the segments is integrated for.
#[derive(Clone, Copy)]
pub(crate) enum Purpose {
    Orbit,
    /// A second run whose distance is the error of the derivatives: with a looser tolerance, or by DOP853
    /// instead of an integrator of one's own.
    Comparison,
}

/// Data that stay fixed during the iterations of one shooting run.
pub(crate) struct Segments<'m> {
    model: &'m dyn Model,
    /// Units of coordinates and velocities: the ranges, or larger units where rounding requires them.
    scale: Vec<f64>,
    /// Ranges of motion; corrections are reported as shares of them.
    range: Vec<f64>,
    /// Rigid modes in units of `scale`, orthonormal: along the coordinates, then along the velocities.
    rigid: DMatrix<f64>,
    /// Rigid modes in units of `range`, orthonormal.
    rigid_of_range: DMatrix<f64>,
    /// The coordinates that are a rigid mode each alone.
    unconnected: Vec<usize>,
    end: f64,
    /// Slopes of the drives with respect to parameters.
    forced: Vec<DriveSlope>,
    expansion: Expansion,
}

/// Result of one integration over all segments; transitions, defects and slack in units of `scale`.
pub(crate) struct Round {
    pub(crate) states: Vec<State>,
    pub(crate) slack: DVector<f64>,
    pub(crate) transitions: Vec<DMatrix<f64>>,
    /// Defects x_{i+1} - φ(x_i): the right-hand sides of the Newton equations.
    pub(crate) defects: Vec<DVector<f64>>,
    /// ∂φ(x_i)/∂p at fixed phases, one column for each parameter.
    pub(crate) by_parameters: Vec<DMatrix<f64>>,
    pub(crate) crossings: u64,
}

impl Round {
    /// Monodromy matrix: the product X_{N-1} ... X_1 X_0 of all transition matrices.
    pub(crate) fn monodromy(&self) -> DMatrix<f64> {
        let m = 2 * self.states[0].q.len();
        self.transitions.iter().fold(DMatrix::identity(m, m), |product, x| x * product)
    }
}

impl<'m> Segments<'m> {
    pub(crate) fn new(
        model: &'m dyn Model,
        [scale, range]: [Vec<f64>; 2],
        drifts: &Drifts,
        end: f64,
        forced: Vec<DriveSlope>,
        expansion: Expansion,
    ) -> Self {
        let [rigid, rigid_of_range] = [&scale, &range].map(|unit| drifts.basis(unit));
        let unconnected = unconnected(&drifts.speeds);
        Segments { model, scale, range, rigid, rigid_of_range, unconnected, end, forced, expansion }
    }

    pub(crate) fn method(&self) -> FlowMethod {
        self.expansion.method()
    }
    pub(crate) fn scale(&self) -> &[f64] {
        &self.scale
    }
    pub(crate) fn range(&self) -> &[f64] {
        &self.range
    }
    pub(crate) fn rigid(&self) -> &DMatrix<f64> {
        &self.rigid
    }
    /// The coordinate with the largest gain of velocity in one period, and the gain, among those that nothing
    /// connects, if the gain is no rounding.
    pub(crate) fn accelerates(&self, gains: &[f64]) -> Option<(usize, f64)> {
        let share = |i: usize| gains[i].abs() / self.scale[gains.len() + i];
        let most = self.unconnected.iter().copied().max_by(|&i, &j| share(i).total_cmp(&share(j)))?;
        (share(most) > GAINS).then_some((most, gains[most]))
    }
    /// Time at which the orbit closes.
    pub(crate) fn end(&self) -> f64 {
        self.end
    }

    /// Integrates over all segments. Without a given slack, the slack is the one that makes the rigid part of
    /// the last defect zero.
    pub(crate) fn round(
        &self,
        purpose: Purpose,
        states: &[State],
        slack: Option<&DVector<f64>>,
        tolerance: f64,
        meter: &Meter<'_>,
    ) -> Result<Round, SegmentError> {
        let (expansion, tolerance) = match (purpose, &self.expansion) {
            (Purpose::Comparison, Expansion::Own(_)) => (&Expansion::Dop853, tolerance),
            (Purpose::Comparison, same) => (same, LOOSER * tolerance),
            (Purpose::Orbit, same) => (same, tolerance),
        };
        let count = states.len();
        let (mut transitions, mut defects, mut crossings) =
            (Vec::with_capacity(count), Vec::with_capacity(count), 0);
        let (m, all) = (self.scale.len(), self.scale.len() + self.forced.len());
        let flow = Tangent::new(self.model, all, &self.forced, &self.scale, tolerance, expansion);
        let mut by_parameters = Vec::with_capacity(count);
        for (segment, state, until) in segments(states, self.end) {
            let next = states.get(segment + 1).unwrap_or(&states[0]);
            let (end, matrix, crossed) = transition(&flow, tolerance, state, until, meter)
                .map_err(|error| SegmentError { segment, error })?;
            crossings += crossed;
            by_parameters.push(matrix.columns(m, self.forced.len()).into_owned());
            transitions.push(matrix.resize_horizontally(m, 0.0));
            defects.push(self.difference(next, &end));
        }
        let slack = match (slack, defects.last()) {
            (None, Some(last)) => -self.rigid.tr_mul(last),
            (Some(slack), _) => slack.clone(),
            (None, None) => DVector::zeros(self.rigid.ncols()),
        };
        if let Some(last) = defects.last_mut() {
            *last += &self.rigid * &slack;
        }
        Ok(Round { states: states.to_vec(), slack, transitions, defects, by_parameters, crossings })
    }

    /// The ends of all segments.
    pub(crate) fn ends(
        &self,
        states: &[State],
        tolerance: f64,
        meter: &Meter<'_>,
    ) -> Result<Vec<State>, SegmentError> {
        let flow = Tangent::new(self.model, 0, &[], &self.scale, tolerance, &self.expansion);
        let end = |(segment, state, until): (usize, &State, f64)| {
            let found = transition(&flow, tolerance, state, until, meter);
            found.map(|(end, ..)| end).map_err(|error| SegmentError { segment, error })
        };
        segments(states, self.end).map(end).collect()
    }

    /// The round of one segment that was integrated from `start` to `end`.
    pub(crate) fn closed(
        &self,
        start: State,
        end: &State,
        transition: DMatrix<f64>,
        slack: Option<&DVector<f64>>,
    ) -> Round {
        let mut defect = self.difference(&start, end);
        let slack = slack.cloned().unwrap_or_else(|| -self.rigid.tr_mul(&defect));
        defect += &self.rigid * &slack;
        let (transitions, defects) = (vec![transition], vec![defect]);
        Round { states: vec![start], slack, transitions, defects, by_parameters: Vec::new(), crossings: 0 }
    }

    /// The error for corrections that do not become small; `largest`: that of
    /// [`largest_change`](Segments::largest_change) for the last one. At a multiplier of 1 the equations are
    /// singular: an error of the flow moves the iterate by its root, and corrections end at that distance.
    /// From an iterate that is itself singular they do not begin.
    pub(crate) fn failure(&self, round: &Round, largest: (usize, f64), last: Iterate) -> ShootingError {
        let monodromy = round.monodromy();
        let multipliers = Multipliers::without(&monodromy, self.rigid(), f64::INFINITY);
        let apart = if largest.1 < NEAR { FOLD } else { SINGULAR };
        let near_one =
            |multipliers: Multipliers| multipliers.values().iter().any(|z| (z - 1.0).norm() < apart);
        if multipliers.is_ok_and(near_one) {
            let (m, k) = self.rigid().shape();
            let mut equations = DMatrix::zeros(m + k, m);
            equations.rows_mut(0, m).copy_from(&(&monodromy - DMatrix::identity(m, m)));
            equations.rows_mut(m, k).copy_from(&self.rigid().transpose());
            let right = right_vectors(equations);
            let component = right.map_or(0, |v| v.row(m - 1).transpose().iamax());
            return ShootingError::Singular { component, last };
        }
        self.not_converged(largest, last)
    }

    /// The same error without a judgement of the multipliers.
    pub(crate) fn not_converged(&self, largest: (usize, f64), last: Iterate) -> ShootingError {
        let ((component, share), range) = (largest, self.range[largest.0]);
        ShootingError::NotConverged { component, range, correction: share * range, last }
    }

    /// a - b in units of `scale`.
    pub(crate) fn difference(&self, a: &State, b: &State) -> DVector<f64> {
        let all = |s: &State, i: usize| if i < s.q.len() { s.q[i] } else { s.v[i - s.q.len()] };
        DVector::from_fn(self.scale.len(), |i, _| (all(a, i) - all(b, i)) / self.scale[i])
    }

    /// States and slack after the share `part` of a Newton step: x_i + part z_i, s + part Δs.
    pub(crate) fn moved(
        &self,
        from: &Round,
        step: &[DVector<f64>],
        slack: &DVector<f64>,
        part: f64,
    ) -> (Vec<State>, DVector<f64>) {
        let (of_q, of_v) = self.scale.split_at(self.scale.len() / 2);
        let shift = |x: &[f64], by: &[f64], scale: &[f64]| {
            x.iter().zip(by).zip(scale).map(|((x, z), s)| x + part * z * s).collect()
        };
        let node = |(state, z): (&State, &DVector<f64>)| {
            let (z_q, z_v) = z.as_slice().split_at(of_q.len());
            State { t: state.t, q: shift(&state.q, z_q, of_q), v: shift(&state.v, z_v, of_v) }
        };
        (from.states.iter().zip(step).map(node).collect(), &from.slack + slack * part)
    }

    /// max |z_i - B Bᵀ z_i| over all nodes and components: the step without rigid motion.
    pub(crate) fn norm(&self, step: &[DVector<f64>]) -> f64 {
        step.iter().fold(0.0, |m: f64, z| m.max(self.elastic(z).amax()))
    }
    /// The component with the largest change as a share of its range, and that share, among the coordinates
    /// or among all components; without rigid motion.
    pub(crate) fn largest_change(&self, step: &[DVector<f64>], coordinates: bool) -> (usize, f64) {
        let count = if coordinates { self.scale.len() / 2 } else { self.scale.len() };
        let mut largest = (0, 0.0);
        for z in step {
            let z = DVector::from_fn(z.len(), |i, _| z[i] * (self.scale[i] / self.range[i]));
            let z = &z - &self.rigid_of_range * self.rigid_of_range.tr_mul(&z);
            for i in 0..count {
                let share = z[i].abs();
                if share > largest.1 || share.is_nan() {
                    largest = (i, share);
                }
            }
        }
        largest
    }
    pub(crate) fn elastic(&self, z: &DVector<f64>) -> DVector<f64> {
        z - &self.rigid * self.rigid.tr_mul(z)
    }
}

/// Drift B s of the coordinates and of the velocities over one period, in the units of the model. `rigid`: B,
/// in units of `scale`; `slack`: s.
pub(crate) fn drift(rigid: &DMatrix<f64>, slack: &DVector<f64>, scale: &[f64]) -> [Vec<f64>; 2] {
    let all = rigid * slack;
    let unscaled: Vec<f64> = all.iter().zip(scale).map(|(z, s)| z * s).collect();
    let (q, v) = unscaled.split_at(unscaled.len() / 2);
    [q.to_vec(), v.to_vec()]
}
