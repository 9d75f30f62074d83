//! Multiple shooting: periodic orbits to the accuracy of the flow.

use crate::error::{ParameterError, check};
use crate::model::equations::{Model, Periodic, State};
use crate::ode::budget::{Budget, Meter};
use crate::ode::error::IntegrateError;
use crate::periodic::shooting::cyclic::Cyclic;
use crate::periodic::shooting::failure::{Iterate, ShootingError};
use crate::periodic::shooting::guess::{Guess, Plan};
use crate::periodic::shooting::orbit::ShootingOrbit;
use crate::periodic::shooting::segments::{Round, Segments};

/// φ(x_i; t_i, t_{i+1}) = x_{i+1} around an orbit of p periods of the drives, x_N = x_0: Newton's method on the states at the nodes, with
/// the exact derivative of the flow, tooth edges located. Damped by the natural monotonicity test.
///
/// The guess may be any orbit, known at a few instants or many, or a single state. Where the model turns freely (a ring) the drift over a
/// period is an unknown, and position and speed of the rigid motion stay those of the guess.   Source: Deuflhard, Newton Methods for
/// Nonlinear Problems, Sects. 3.3 and 7.1.
///
/// ```
/// use gear_dynamics::{Model, Periodic, Shooting, State};
/// struct Swing; // q'' + 0.1 q' + q = cos 2t
/// impl Model for Swing {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) { a[0] = (2.0 * u[0]).cos() - 0.1 * v[0] - q[0]; }
/// }
/// impl Periodic for Swing {
///     fn period(&self) -> f64 { std::f64::consts::PI }
/// }
/// let cycle = Shooting::new().run(&Swing, &[State::at_rest(1)])?;
/// assert!((cycle.states()[0].q[0] + 3.0 / 9.04).abs() < 1e-10); // (1 - Ω²)/((1 - Ω²)² + (0.1 Ω)²)
/// # Ok::<(), gear_dynamics::periodic::ShootingError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Shooting {
    multiple: usize,
    segments: Option<usize>,
    tolerance: f64,
    flow_tolerance: f64,
    max_iterations: usize,
    budget: Budget,
}

impl Default for Shooting {
    fn default() -> Self {
        Shooting::new()
    }
}

/// Periods and segments of an orbit at most.
const MOST: usize = 1_000_000;

/// Damping below this is given up.
const LEAST_DAMPING: f64 = 1.0 / 1024.0;

/// A correction below this that no longer falls is the noise of the flow: rounding, and edges met as closely as they can be.
const NOISE: f64 = 1e-9;

/// The second flow, from which errors are estimated, is this much looser.
const LOOSER: f64 = 100.0;

impl Shooting {
    /// Orbits of one period, to corrections of 1e-12 of the range of motion, within 40 iterations, the flow held to 1e-13, within the
    /// default [`Budget`].
    pub fn new() -> Self {
        Shooting {
            multiple: 1,
            segments: None,
            tolerance: 1e-12,
            flow_tolerance: 1e-13,
            max_iterations: 40,
            budget: Budget::new(),
        }
    }
    /// Periods of the drives in one period of the orbit; at most 10⁶.
    pub fn multiple(self, multiple: usize) -> Self {
        Shooting { multiple, ..self }
    }
    /// Number of segments: by default one for each state of the guess, and from a single state as many as the motion asks for. More
    /// segments make orbits that are very unstable reachable. A list of states is thinned to this number, never filled up. At most 10⁶.
    pub fn segments(self, segments: usize) -> Self {
        Shooting { segments: Some(segments), ..self }
    }
    /// Largest correction at the end, as a share of the range of each coordinate and velocity. Where the noise of the flow lies higher, an
    /// orbit is accepted once corrections no longer fall, below 1e-9: [`ShootingOrbit::accuracy`] says how far it came.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Shooting { tolerance, ..self }
    }
    /// Local error of the integration, as a share of the same ranges, or the rounding of what a component is made of, whichever is larger.
    pub fn flow_tolerance(self, flow_tolerance: f64) -> Self {
        Shooting { flow_tolerance, ..self }
    }
    /// Newton iterations before giving up.
    pub fn max_iterations(self, max_iterations: usize) -> Self {
        Shooting { max_iterations, ..self }
    }

    /// The most steps and time of one call, all its flows together.
    pub fn budget(self, budget: Budget) -> Self {
        Shooting { budget, ..self }
    }

    /// From states of a guess at increasing times within one period of the orbit, or from one state.
    ///
    /// # Errors
    /// [`ShootingError`]; once iterations have begun it holds the last iterate and the history of corrections.
    pub fn run<M: Periodic + ?Sized>(
        &self,
        model: &M,
        guess: &[State],
    ) -> Result<ShootingOrbit, ShootingError> {
        self.run_within(&model, guess, &self.budget.begin())
    }

    /// The same within what is left of a budget.
    pub(crate) fn run_within(
        &self,
        model: &dyn Periodic,
        guess: &[State],
        meter: &Meter<'_>,
    ) -> Result<ShootingOrbit, ShootingError> {
        self.check(model.dof())?;
        let plan =
            Plan { multiple: self.multiple, segments: self.segments, flow_tolerance: self.flow_tolerance };
        self.newton(model, Guess::of(model, &plan, guess, meter)?, meter)
    }

    /// The orbit of a neighbouring model, from a known one: nodes at the same phases, velocities in proportion to the frequency.
    ///
    /// # Errors
    /// [`ShootingError`].
    pub fn again<M: Periodic + ?Sized>(
        &self,
        model: &M,
        cycle: &ShootingOrbit,
    ) -> Result<ShootingOrbit, ShootingError> {
        let multiple = cycle.period_multiple();
        let stretch = multiple as f64 * model.period() / cycle.period();
        let moved = |state: &State| State {
            t: state.t * stretch,
            q: state.q.clone(),
            v: state.v.iter().map(|v| v / stretch).collect(),
        };
        let guess: Vec<State> = cycle.states().iter().map(moved).collect();
        Shooting { multiple, ..self.clone() }.run(model, &guess)
    }

    fn check(&self, dof: usize) -> Result<(), ShootingError> {
        let segments = self.segments.unwrap_or(1);
        let counts = [
            ("multiple", self.multiple),
            ("segments", segments),
            ("max_iterations", self.max_iterations),
            ("degrees of freedom", dof),
        ];
        if let Some(&(name, value)) = counts.iter().find(|(_, value)| *value == 0) {
            return Err(ParameterError::TooFew { name: name.into(), value, least: 1 }.into());
        }
        check::count("multiple", &[self.multiple], MOST)?;
        check::count("segments", &[segments], MOST)?;
        check::positive("tolerance", self.tolerance)?;
        check::tolerance("flow_tolerance", self.flow_tolerance)?;
        Ok(())
    }

    fn newton(
        &self,
        model: &dyn Model,
        guess: Guess,
        meter: &Meter<'_>,
    ) -> Result<ShootingOrbit, ShootingError> {
        let segments = Segments::new(model, guess.scales, &guess.rigid, guess.end);
        let mut corrections: Vec<f64> = Vec::new();
        let (mut first, mut before, mut most) = (0.0, f64::INFINITY, (0, f64::NAN));
        let fail = |states: &[State], corrections: &[f64]| Iterate {
            states: states.to_vec(),
            corrections: corrections.to_vec(),
        };
        let not_converged = |(component, share): (usize, f64), last: Iterate| {
            let range = segments.range()[component];
            ShootingError::NotConverged { component, range, correction: share * range, last }
        };
        let mut here = match segments.round(guess.states, None, self.flow_tolerance, meter) {
            Ok(round) => round,
            Err((segment, error, states)) => {
                return Err(ShootingError::Flow { segment, error, last: fail(&states, &corrections) });
            }
        };
        for _ in 0..self.max_iterations {
            let last = |corrections: &[f64]| fail(&here.states, corrections);
            let system = match Cyclic::factor(&here.transitions, segments.rigid()) {
                Ok(system) => system,
                Err(component) => {
                    return Err(ShootingError::Singular { component, last: last(&corrections) });
                }
            };
            let (step, slack) = system.solve(&here.defects);
            let size = segments.norm(&step);
            if corrections.is_empty() {
                first = segments.most(&step, true).1;
            }
            most = segments.most(&step, false);
            let stalled = size > 0.5 * before;
            before = size;
            corrections.push(most.1);
            if size <= self.tolerance || (stalled && size <= NOISE) {
                return self.finish(model, &segments, here, first, corrections, meter);
            }
            // Natural monotonicity: the simplified correction must be smaller than the one just made.
            let mut damping = 1.0;
            let next = loop {
                let (states, slack) = segments.moved(&here, &step, &slack, damping);
                match segments.round(states, Some(&slack), self.flow_tolerance, meter) {
                    Ok(trial) => {
                        let simplified = segments.norm(&system.solve(&trial.defects).0);
                        if simplified <= (1.0 - 0.25 * damping) * size || simplified <= self.tolerance {
                            break Some(trial);
                        }
                    }
                    Err((segment, error @ IntegrateError::Budget { .. }, _)) => {
                        return Err(ShootingError::Flow { segment, error, last: last(&corrections) });
                    }
                    Err(_) => {}
                }
                damping *= 0.5;
                if damping < LEAST_DAMPING || size <= NOISE {
                    break None;
                }
            };
            here = match next {
                Some(round) => round,
                None if size <= NOISE => {
                    return self.finish(model, &segments, here, first, corrections, meter);
                }
                None => return Err(not_converged(most, last(&corrections))),
            };
        }
        Err(not_converged(most, fail(&here.states, &corrections)))
    }

    fn finish(
        &self,
        model: &dyn Model,
        segments: &Segments<'_, dyn Model + '_>,
        round: Round,
        first: f64,
        corrections: Vec<f64>,
        meter: &Meter<'_>,
    ) -> Result<ShootingOrbit, ShootingError> {
        let looser = segments
            .round(round.states.clone(), Some(&round.slack), LOOSER * self.flow_tolerance, meter)
            .ok();
        ShootingOrbit::new(model, segments, round, looser, self, first, corrections)
    }

    pub(crate) fn flow(&self) -> f64 {
        self.flow_tolerance
    }
    pub(crate) fn periods(&self) -> usize {
        self.multiple
    }
}
