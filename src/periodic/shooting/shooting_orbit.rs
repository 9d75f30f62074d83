//! A periodic orbit to the accuracy of the integration.

use crate::model::{Model, State};
use crate::ode::budget::Meter;
use crate::ode::{Budget, IntegrateError, Observer, Stats, Step};
use crate::periodic::flow::flow_method::FlowMethod;
use crate::periodic::flow::walk::{SegmentError, Walk};
use crate::periodic::multipliers::{Multipliers, Stability};
use crate::periodic::shooting::failure::{Iterate, ShootingError};
use crate::periodic::shooting::segments::Segments;
use nalgebra::DMatrix;
use std::ops::ControlFlow;

/// An orbit whose state repeats within this share of its range after fewer periods has the smaller period.
const REPEATS: f64 = 1e-8;

/// A periodic orbit found by [`Shooting`](crate::Shooting): states at the nodes, monodromy matrix, Floquet
/// multipliers, and the corrections of the iteration.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, Periodic, Shooting, Statistics, periodic::Stability};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let cycle = Shooting::new().solve(&pair, &[pair.on_drive_flank()?])?;
/// assert_eq!((cycle.crossing_count(), cycle.stability()), (0, Stability::Stable));
///
/// let mut statistics = Statistics::new(&pair, &["q0"])?;
/// cycle.observe(&pair, &mut statistics)?;
/// let later = cycle.at(&pair, 3.25 * pair.period())?;
/// assert!(statistics.summary("q0")?.min <= later.q[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ShootingOrbit {
    pub(crate) parts: OrbitParts,
    pub(crate) budget: Budget,
}

/// Distance of the end of a segment from the node after it, as a share of the range of the motion, from which
/// on the model is not that of the orbit `[1]`.
const OTHER: f64 = 1e-3;

/// All of an orbit but its budget, in the stored form.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename = "ShootingOrbit"))]
pub(crate) struct OrbitParts {
    pub(crate) states: Vec<State>,
    /// Time at the end of the orbit.
    pub(crate) end: f64,
    pub(crate) multiple: usize,
    pub(crate) least: usize,
    /// Units of the coordinates and velocities in the integration.
    pub(crate) scale: Vec<f64>,
    pub(crate) range: Vec<f64>,
    pub(crate) drift: [Vec<f64>; 2],
    #[cfg_attr(feature = "serde", serde(with = "crate::numeric::not_finite::square"))]
    pub(crate) monodromy: DMatrix<f64>,
    pub(crate) multipliers: Multipliers,
    #[cfg_attr(feature = "serde", serde(with = "crate::numeric::not_finite::number"))]
    pub(crate) first: f64,
    #[cfg_attr(feature = "serde", serde(with = "crate::numeric::not_finite::list"))]
    pub(crate) corrections: Vec<f64>,
    pub(crate) crossings: u64,
    pub(crate) flow: f64,
    pub(crate) method: FlowMethod,
}

impl ShootingOrbit {
    /// States at the nodes, over one period of the orbit.
    pub fn states(&self) -> &[State] {
        &self.parts.states
    }
    /// Period of the orbit.
    pub fn period(&self) -> f64 {
        self.parts.end - self.parts.states[0].t
    }
    /// Number of periods of the drives in one period of the orbit: the setting
    /// [`Shooting::period_multiple`](crate::Shooting::period_multiple).
    pub fn period_multiple(&self) -> usize {
        self.parts.multiple
    }
    /// Minimum number of periods of the drives after which the orbit repeats. It is less than
    /// [`period_multiple`](ShootingOrbit::period_multiple) if shooting converged to an orbit of a smaller
    /// period.
    pub fn least_period_multiple(&self) -> usize {
        self.parts.least
    }
    /// Monodromy matrix ∂x(t0 + period)/∂x(t0) at the first node, in the units of the model; x holds the
    /// coordinates, then the velocities.
    pub fn monodromy(&self) -> &DMatrix<f64> {
        &self.parts.monodromy
    }
    /// Floquet multipliers: eigenvalues of the monodromy matrix without the pair 1, 1 of each rigid mode and
    /// the 1 of each place of which only the velocity acts.
    ///
    /// Their error is the change when the tolerance of the flow is 100 times larger.
    pub fn multipliers(&self) -> &Multipliers {
        &self.parts.multipliers
    }
    /// Stability of the orbit: whether small perturbations decay.
    pub fn stability(&self) -> Stability {
        self.parts.multipliers.stability()
    }
    /// Number of tooth edges crossed in one period of the orbit.
    pub fn crossing_count(&self) -> u64 {
        self.parts.crossings
    }
    /// Units of the corrections: the range of motion of each coordinate, then of each velocity, in the guess,
    /// without rigid motion. If a guess moves ten times as far as the orbit, the last corrections have the
    /// units of the orbit.
    pub fn range(&self) -> &[f64] {
        &self.parts.range
    }
    /// The first Newton correction of the coordinates, as a share of their range `[1]`: a measure of the
    /// error of the guess.
    pub fn first_correction(&self) -> f64 {
        self.parts.first
    }
    /// The method by which the orbit and its multipliers were integrated.
    pub fn flow_method(&self) -> FlowMethod {
        self.parts.method
    }
    /// The Newton correction of each iteration, before damping: the largest one among the coordinates and
    /// velocities of all nodes, without rigid motion, as a share of its [`range`](ShootingOrbit::range) in
    /// the guess `[1]`. The last correction is computed but not applied.
    pub fn corrections(&self) -> &[f64] {
        &self.parts.corrections
    }
    /// The last correction, as a share of the range `[1]`: an estimate of the error of the states.
    pub fn accuracy(&self) -> f64 {
        self.parts.corrections.last().copied().unwrap_or(f64::INFINITY)
    }
    /// Drift of the coordinates and of the velocities in one period of the orbit, along rigid modes and along
    /// places of which only the velocity acts; zeros without these.
    pub fn drift(&self) -> (&[f64], &[f64]) {
        (&self.parts.drift[0], &self.parts.drift[1])
    }
    /// Mean acceleration of each coordinate: the velocity drift along the rigid modes over the period, Δv/T.
    pub fn mean_acceleration(&self) -> Vec<f64> {
        self.parts.drift[1].iter().map(|dv| dv / self.period()).collect()
    }

    /// The same orbit with another limit on the steps and the time of one integration along it: of
    /// [`at`](ShootingOrbit::at), [`observe`](ShootingOrbit::observe) and [`record`](ShootingOrbit::record).
    /// Default: the [`Budget`] of the shooting; after a continuation or reading the default budget.
    pub fn budget(self, budget: Budget) -> Self {
        ShootingOrbit { budget, ..self }
    }

    /// State at any time, integrated from the node before it by DOP853.
    ///
    /// # Errors
    /// [`IntegrateError`]; also for a time that is not finite.
    pub fn at(&self, model: &dyn Model, t: f64) -> Result<State, IntegrateError> {
        self.state_at(model, t, &self.budget.begin())
    }

    /// The smallest number of periods of the drives after which the state repeats.
    pub(crate) fn found_multiple(
        &self,
        model: &dyn Model,
        segments: &Segments<'_>,
        meter: &Meter<'_>,
    ) -> Result<usize, ShootingError> {
        let (multiple, start) = (self.period_multiple(), &self.states()[0]);
        for shorter in (1..multiple).filter(|p| multiple.is_multiple_of(*p)) {
            let t = start.t + self.period() * shorter as f64 / multiple as f64;
            let later = self.state_at(model, t, meter).map_err(|error| {
                let (states, corrections) = (self.states().to_vec(), self.corrections().to_vec());
                ShootingError::of_segment(0, error, Iterate { states, corrections })
            })?;
            if segments.elastic(&segments.difference(&later, start)).amax() <= REPEATS {
                return Ok(shorter);
            }
        }
        Ok(multiple)
    }

    /// [`at`](ShootingOrbit::at) with the rest of a budget.
    pub(crate) fn state_at(
        &self,
        model: &dyn Model,
        t: f64,
        meter: &Meter<'_>,
    ) -> Result<State, IntegrateError> {
        let (start, period) = (self.parts.states[0].t, self.period());
        if !t.is_finite() {
            return Err(IntegrateError::OutputTime { index: 0, value: t, start });
        }
        let turns = ((t - start) / period).floor();
        let inside = (t - turns * period).clamp(start, self.parts.end);
        let node = self.parts.states.partition_point(|state| state.t <= inside).max(1) - 1;
        let mut state = self.parts.states[node].clone();
        if inside > state.t {
            // To prepare a Taylor series takes longer than one segment.
            let walk = Walk::new(model, &self.parts.scale, self.parts.flow, FlowMethod::Dop853);
            let mut quiet = |_: &mut Step<'_>| ControlFlow::Continue(());
            state = walk.run(&state, inside, &mut quiet, meter)?.state;
        }
        // Drift of the rigid motion after n whole periods T, at time τ within the period:
        // q += n Δq + n ((n - 1) T/2 + τ) Δv, v += n Δv.
        let since = inside - start;
        for ((q, v), (dq, dv)) in
            state.q.iter_mut().zip(&mut state.v).zip(self.parts.drift[0].iter().zip(&self.parts.drift[1]))
        {
            *q += turns * (dq + (0.5 * (turns - 1.0) * period + since) * dv);
            *v += turns * dv;
        }
        state.t = t;
        Ok(state)
    }

    /// Integrates one period of the orbit, by the [method](ShootingOrbit::flow_method) that found it, and
    /// passes every step to an observer. Each segment starts from its node, so that the run also stays on an
    /// unstable orbit.
    ///
    /// # Errors
    /// [`IntegrateError`].
    pub fn observe(&self, model: &dyn Model, observer: &mut dyn Observer) -> Result<Stats, IntegrateError> {
        self.observe_within(model, observer, &self.budget.begin())
    }

    /// [`observe`](ShootingOrbit::observe) with the rest of a budget.
    pub(crate) fn observe_within(
        &self,
        model: &dyn Model,
        observer: &mut dyn Observer,
        meter: &Meter<'_>,
    ) -> Result<Stats, IntegrateError> {
        observer.fits(model.dof(), model.contacts())?;
        let OrbitParts { states, end, .. } = &self.parts;
        states[0].check(model.dof())?;
        Walk::new(model, &self.parts.scale, self.parts.flow, self.parts.method)
            .follow(states, *end, observer, meter, &|segment, reached| self.closes(segment, reached))
            .map_err(|SegmentError { error, .. }| error)
    }

    /// Checks that a segment ends at the node after it. With the model of the orbit it does.
    ///
    /// # Errors
    /// [`IntegrateError::OtherOrbit`].
    fn closes(&self, segment: usize, reached: &State) -> Result<(), IntegrateError> {
        let OrbitParts { states, range, drift, .. } = &self.parts;
        let (next, drift) = match states.get(segment + 1) {
            Some(next) => (next, None),
            None => (&states[0], Some(drift)),
        };
        let n = next.q.len();
        let miss = |i: usize| {
            let (half, j) = (i / n, i % n);
            let of = |state: &State| [&state.q, &state.v][half][j];
            let off = of(reached) - of(next) - drift.map_or(0.0, |drift| drift[half][j]);
            // Large positions along a rigid motion have rounding errors of their own.
            off.abs() / (range[i] + 1e-9 * (of(reached).abs() + self.parts.scale[i]))
        };
        let miss = (0..2 * n).map(miss).fold(0.0, f64::max);
        if miss <= OTHER { Ok(()) } else { Err(IntegrateError::OtherOrbit { segment, miss }) }
    }
}
