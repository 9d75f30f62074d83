//! The equations of multiple shooting over a parameter.

use crate::branches::curve::equations::{Curve, CurveError, Linear, PARAMETER_STEP};
use crate::branches::family::Family;
use crate::branches::orbits::widths::Widths;
use crate::branches::stability_method::StabilityMethod;
use crate::error::check;
use crate::model::drive_slope::DriveSlope;
use crate::model::structure::drifts::Drifts;
use crate::model::{Model, Periodic, State};
use crate::ode::IntegrateError;
use crate::ode::budget::Meter;
use crate::periodic::flow::flow_method::{Chosen, Expansion};
use crate::periodic::flow::walk::SegmentError;
use crate::periodic::shooting::segments::{Purpose, Round, Segments};
use crate::periodic::{FlowMethod, Multipliers, Shooting, ShootingOrbit};
use nalgebra::{DMatrix, DVector};
use std::rc::Rc;

/// φ(x_i; p) - x_{i+1} = 0 at fixed phases of the period T(p), with x_N = x_0 + Φ s and P (x_0 - x_ref) = 0.
///
/// Unknowns: coordinates and velocities at the nodes, one node after the other, then the drifts s along their
/// directions Φ, all in units of the model. P measures the position along these directions in the units
/// of the first orbit. B spans them in units of the motion, which change from point to point.
///
/// Symmetric orbits may be followed over half their period, with x_N = -x_0: all other orbits are then
/// excluded.
pub(crate) struct OrbitCurve<'f> {
    pub(super) family: Family<'f>,
    pub(super) multiple: usize,
    /// Whether the orbits are followed over half their period.
    half: bool,
    pub(super) stability: StabilityMethod,
    /// Times of the nodes over the period of the orbit.
    pub(super) phases: Vec<f64>,
    /// Units of coordinates and velocities, and their ranges of motion.
    pub(super) scale: Vec<f64>,
    pub(super) range: Vec<f64>,
    pub(super) widths: Widths,
    /// Period of the first orbit.
    pub(super) period: f64,
    pub(super) drifts: Drifts,
    /// Drift of the coordinates in one period of the last orbit.
    pub(super) drift: Vec<f64>,
    /// Orthonormal directions Φ of drifts in units of the model: along the coordinates, then along the
    /// velocities.
    pub(super) motions: DMatrix<f64>,
    /// P.
    position: DMatrix<f64>,
    /// The position along the rigid motions, in units of the model.
    pub(super) reference: State,
    pub(super) flow_tolerance: f64,
    pub(super) chosen: Chosen,
    /// Unit of the parameter.
    pub(super) unit: f64,
    /// Step of the differences with respect to a parameter without exact derivative.
    pub(super) difference: f64,
    pub(super) meter: Rc<Meter<'f>>,
}

/// G with its derivatives with respect to x and to several constants.
pub(crate) struct Slopes {
    pub(crate) residual: DVector<f64>,
    pub(crate) by_x: DMatrix<f64>,
    pub(crate) by_c: DMatrix<f64>,
    pub(crate) passage: Passage,
}

/// The segments of one evaluation.
pub(super) struct Evaluated {
    pub(super) round: Round,
    /// Rigid motions in units of `scale`.
    pub(super) rigid: DMatrix<f64>,
    pub(super) method: FlowMethod,
    pub(super) end: f64,
}

/// What one evaluation of the equations computes besides them.
#[derive(Clone)]
pub(crate) struct Passage {
    pub(crate) states: Vec<State>,
    pub(crate) end: f64,
    pub(super) slack: DVector<f64>,
    /// Monodromy matrix in the units `scale`.
    pub(super) monodromy: DMatrix<f64>,
    pub(super) scale: Vec<f64>,
    pub(crate) multipliers: Option<Multipliers>,
    pub(super) crossings: u64,
    pub(super) method: FlowMethod,
}

impl Passage {
    pub(crate) fn method(&self) -> FlowMethod {
        self.method
    }
    /// Number of crossings of edges.
    pub(crate) fn crossings(&self) -> u64 {
        self.crossings
    }
}

impl<'f> OrbitCurve<'f> {
    /// The curve through an orbit of the model with the parameter `p`. `unit`: unit of the parameter.
    pub(crate) fn new(
        family: Family<'f>,
        (p, unit): (f64, f64),
        orbit: &ShootingOrbit,
        shooting: &Shooting,
        meter: Rc<Meter<'f>>,
    ) -> Result<Self, CurveError> {
        let model = family.at([p]).map_err(|error| CurveError::Model { parameter: p, error })?;
        check::length("coordinates and velocities of the orbit", orbit.parts.scale.len(), 2 * model.dof())
            .map_err(|error| CurveError::Model { parameter: p, error })?;
        let period = orbit.period();
        let drifts = Drifts::of(&*model, period);
        drop(model);
        let motions = drifts.basis(&vec![1.0; orbit.parts.scale.len()]);
        let mut position = drifts.basis(&orbit.parts.scale).transpose();
        position.column_iter_mut().zip(&orbit.parts.scale).for_each(|(mut column, s)| column /= *s);
        Ok(OrbitCurve {
            family,
            multiple: orbit.period_multiple(),
            half: false,
            stability: StabilityMethod::Multipliers,
            phases: orbit.states().iter().map(|state| state.t / period).collect(),
            scale: orbit.parts.scale.clone(),
            range: orbit.parts.range.clone(),
            widths: Widths::new(&drifts.widened(&orbit.parts.range, &orbit.parts.drift[0], period)),
            period,
            drifts,
            drift: orbit.parts.drift[0].clone(),
            motions,
            position,
            reference: orbit.states()[0].clone(),
            flow_tolerance: orbit.parts.flow,
            chosen: shooting.method().clone(),
            unit,
            difference: PARAMETER_STEP * unit.max(p.abs()),
            meter,
        })
    }

    /// The same curve for symmetric orbits over half their period; the orbit of [`new`](OrbitCurve::new) is
    /// that half.
    pub(crate) fn over_half(self) -> Self {
        OrbitCurve { half: true, ..self }
    }
    pub(crate) fn with_stability(self, stability: StabilityMethod) -> Self {
        OrbitCurve { stability, ..self }
    }
    pub(crate) fn is_over_half(&self) -> bool {
        self.half
    }
    /// The time over which orbits of the model are followed.
    pub(crate) fn period_of(&self, model: &dyn Periodic) -> f64 {
        self.multiple as f64 * model.period() * if self.half { 0.5 } else { 1.0 }
    }

    /// The unknowns of an orbit on the same nodes.
    pub(crate) fn unknowns_of(&self, orbit: &ShootingOrbit) -> DVector<f64> {
        let [of_q, of_v] = &orbit.parts.drift;
        let drift: Vec<f64> = of_q.iter().chain(of_v).copied().collect();
        let slack = self.motions.tr_mul(&DVector::from_vec(drift));
        let nodes = orbit.states().iter().flat_map(|state| state.q.iter().chain(&state.v).copied());
        let all: Vec<f64> = nodes.chain(slack.iter().copied()).collect();
        DVector::from_vec(all)
    }

    pub(crate) fn chosen(&self) -> &Chosen {
        &self.chosen
    }
    /// Size of drift k: the drift in one period at a typical velocity, or that of the last orbit if its mean
    /// speed is its own. The velocity along a rigid motion is given at the first node only, so that the orbit
    /// may drift.
    fn drift_size(&self, k: usize) -> f64 {
        let (q, v) = self.range.split_at(self.range.len() / 2);
        let ratios = q.iter().zip(v).filter(|(q, _)| **q > 0.0).map(|(q, v)| v * self.period / q);
        let share = |i: usize| self.motions[(i, k)].abs() / self.scale[i];
        let typical = ratios.fold(1.0, f64::max) / (0..self.scale.len()).map(share).fold(0.0, f64::max);
        if self.drifts.has_own_speeds() && k < self.drifts.places.len() {
            let along = self.drift.iter().enumerate().map(|(i, drift)| self.motions[(i, k)] * drift);
            return typical.max(along.sum::<f64>().abs());
        }
        typical
    }

    /// The matrix C of B C = D⁻¹ Φ, with the units D of the motion.
    fn coupling(&self, rigid: &DMatrix<f64>) -> DMatrix<f64> {
        let mut scaled = self.motions.clone();
        scaled.row_iter_mut().zip(&self.scale).for_each(|(mut row, s)| row.unscale_mut(*s));
        rigid.tr_mul(&scaled)
    }

    /// Size of each unknown.
    pub(crate) fn sizes(&self) -> DVector<f64> {
        let (widths, count) = (self.widths.units(), self.phases.len());
        let m = widths.len();
        let k = self.drifts.count();
        let size = |i: usize| if i < m * count { widths[i % m] } else { self.drift_size(i - m * count) };
        DVector::from_fn(m * count + k, |i, _| size(i))
    }
    pub(crate) fn flow_tolerance(&self) -> f64 {
        self.flow_tolerance
    }
    pub(crate) fn multiple(&self) -> usize {
        self.multiple
    }
    pub(crate) fn scale(&self) -> &[f64] {
        &self.scale
    }
    pub(crate) fn drifts(&self) -> &Drifts {
        &self.drifts
    }
    pub(crate) fn meter(&self) -> &Meter<'f> {
        &self.meter
    }

    pub(crate) fn model(&self, p: f64) -> Result<Box<dyn Periodic + '_>, CurveError> {
        self.family.at([p]).map_err(|error| CurveError::Model { parameter: p, error })
    }

    pub(crate) fn states(&self, x: &DVector<f64>, period: f64) -> Vec<State> {
        let m = self.scale.len();
        let node = |(i, phase): (usize, &f64)| {
            let node = &x.as_slice()[i * m..(i + 1) * m];
            State::new(phase * period, &node[..m / 2], &node[m / 2..])
        };
        self.phases.iter().enumerate().map(node).collect()
    }

    fn end(&self, period: f64) -> f64 {
        (self.phases[0] + 1.0) * period
    }

    pub(crate) fn segments<'s>(
        &self,
        model: &'s dyn Model,
        period: f64,
        columns: usize,
        forced: Vec<DriveSlope>,
    ) -> Result<Segments<'s>, CurveError> {
        let expansion = Expansion::new(model, columns + forced.len(), &forced, &self.chosen)
            .map_err(|error| CurveError::Integrate { segment: 0, error })?;
        let scales = [self.scale.clone(), self.range.clone()];
        Ok(Segments::new(model, scales, &self.drifts, self.end(period), forced, expansion))
    }

    pub(crate) fn failed(SegmentError { segment, error }: SegmentError) -> CurveError {
        match error {
            IntegrateError::Exhausted { exhausted, .. } => CurveError::Exhausted(exhausted),
            error => CurveError::Integrate { segment, error },
        }
    }

    /// Integrates over all segments of an orbit, with the derivatives with respect to the parameters on which
    /// the drives depend by `forced`.
    pub(super) fn round(
        &self,
        model: &dyn Periodic,
        x: &DVector<f64>,
        forced: Vec<DriveSlope>,
        purpose: Purpose,
    ) -> Result<Evaluated, CurveError> {
        let m = self.scale.len();
        let period = self.period_of(model);
        let segments = self.segments(model, period, m, forced)?;
        let nodes = self.phases.len() * m;
        let slack = self.coupling(segments.rigid()) * x.rows(nodes, x.len() - nodes);
        let (states, tolerance) = (self.states(x, period), self.flow_tolerance);
        let round = segments.round(purpose, &states, Some(&slack), tolerance, &self.meter);
        Ok(Evaluated {
            round: round.map_err(Self::failed)?,
            rigid: segments.rigid().clone(),
            method: segments.method(),
            end: segments.end(),
        })
    }

    /// The residual and its derivative with respect to x.
    fn assemble(&self, x: &DVector<f64>, at: &Evaluated) -> (DVector<f64>, DMatrix<f64>) {
        let (scale, round, rigid) = (&self.scale, &at.round, &at.rigid);
        let (m, count, n, k) = (scale.len(), self.phases.len(), x.len(), rigid.ncols());
        let (mut residual, mut by_x) = (DVector::zeros(n), DMatrix::zeros(n, n));
        for i in 0..count {
            residual.rows_mut(i * m, m).copy_from(&-&round.defects[i]);
            by_x.view_mut((i * m, i * m), (m, m)).copy_from(&round.transitions[i]);
            let next = (i + 1) % count;
            let reversed = self.half && next == 0;
            for j in 0..m {
                by_x[(i * m + j, next * m + j)] += if reversed { 1.0 } else { -1.0 };
                if reversed {
                    residual[i * m + j] += 2.0 * x[j] / scale[j];
                }
            }
        }
        // The position along the rigid motions and the drift of the last node.
        let of = |state: &State, i: usize| if i < m / 2 { state.q[i] } else { state.v[i - m / 2] };
        let off = DVector::from_fn(m, |i, _| x[i] - of(&self.reference, i));
        residual.rows_mut(count * m, k).copy_from(&(&self.position * off));
        let mut position = self.position.clone();
        position.column_iter_mut().zip(scale).for_each(|(mut column, s)| column *= *s);
        by_x.view_mut((count * m, 0), (k, m)).copy_from(&position);
        by_x.view_mut(((count - 1) * m, count * m), (m, k)).copy_from(&-(rigid * self.coupling(rigid)));
        for i in 0..count {
            for (j, scale) in scale.iter().enumerate() {
                by_x.column_mut(i * m + j).unscale_mut(*scale);
            }
        }
        (residual, by_x)
    }

    fn passage(&self, at: Evaluated) -> Passage {
        let monodromy = at.round.monodromy();
        Passage {
            multipliers: Multipliers::without(&monodromy, &at.rigid, 0.0).ok(),
            monodromy,
            slack: at.round.slack,
            states: at.round.states,
            crossings: at.round.crossings,
            end: at.end,
            scale: self.scale.clone(),
            method: at.method,
        }
    }

    /// G, ∂G/∂x and ∂G/∂c for slopes of the drives with respect to constants c, at a model of the family.
    pub(crate) fn slopes(
        &self,
        model: &dyn Periodic,
        x: &DVector<f64>,
        forced: &[DriveSlope],
    ) -> Result<Slopes, CurveError> {
        let at = self.round(model, x, forced.to_vec(), Purpose::Orbit)?;
        let (residual, by_x) = self.assemble(x, &at);
        let m = self.scale.len();
        let mut by_c = DMatrix::zeros(x.len(), forced.len());
        for (i, columns) in at.round.by_parameters.iter().enumerate() {
            by_c.view_mut((i * m, 0), (m, forced.len())).copy_from(columns);
        }
        Ok(Slopes { residual, by_x, by_c, passage: self.passage(at) })
    }

    /// The passage over all segments, at a model of the family.
    pub(crate) fn pass(&self, model: &dyn Periodic, x: &DVector<f64>) -> Result<Passage, CurveError> {
        Ok(self.passage(self.round(model, x, Vec::new(), Purpose::Orbit)?))
    }
}

impl Curve for OrbitCurve<'_> {
    type Solution = Passage;

    fn linearise(&mut self, x: &DVector<f64>, p: f64) -> Result<Linear<Passage>, CurveError> {
        let model = self.model(p)?;
        let slope = self.family.constants.zip(model.offers().constants);
        let forced: Vec<DriveSlope> =
            slope.map(|([i], constants)| constants.drive_slope(i).times(self.unit)).into_iter().collect();
        let exact = !forced.is_empty();
        let at = self.round(&*model, x, forced, Purpose::Orbit)?;
        let (residual, by_x) = self.assemble(x, &at);
        let m = self.scale.len();
        let mut by_p = DVector::zeros(x.len());
        if exact {
            for (i, columns) in at.round.by_parameters.iter().enumerate() {
                by_p.rows_mut(i * m, m).copy_from(&(columns.column(0) / self.unit));
            }
        } else {
            for (i, slope) in
                self.differences(x, p, self.difference, &|p| self.family.at([p]))?.iter().enumerate()
            {
                by_p.rows_mut(i * m, m).copy_from(slope);
            }
        }
        drop(model);
        Ok(Linear { residual, by_x, by_p, solution: self.passage(at) })
    }

    fn units(&self) -> DVector<f64> {
        let sizes = self.sizes();
        let share = (sizes.len() as f64).sqrt();
        sizes * share
    }
}
