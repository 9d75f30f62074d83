//! Multiple shooting: periodic orbits to the accuracy of the integration.

use crate::error::{ParameterError, check};
use crate::model::{Periodic, State};
use crate::ode::budget::Meter;
use crate::ode::{Budget, Integrator};
use crate::periodic::flow::flow_method::{Chosen, Expansion, FlowMethod, OwnIntegrator};
use crate::periodic::shooting::failure::ShootingError;
use crate::periodic::shooting::guess::{Guess, NodePlan};
use crate::periodic::shooting::neighbour::Neighbour;
use crate::periodic::shooting::segments::Segments;
use crate::periodic::shooting::shooting_orbit::ShootingOrbit;

/// Periodic orbits by multiple shooting.
///
/// φ(x_i; t_i, t_{i+1}) = x_{i+1}, i = 0 .. N-1, with x_N = x_0.
///
/// φ is the flow and x_i are the states at the nodes of an orbit of p periods of the drives. Newton's method
/// finds the x_i. It uses the exact derivative of the flow; tooth edges are located. The natural monotonicity
/// test damps it.
///
/// The guess is a list of states of an approximate orbit at increasing times, or a single state. If the model
/// has rigid modes (a ring), the drift over a period is an unknown, and position and speed of the rigid
/// motion stay those of the guess. Where only the velocity along a direction acts (a rotor that a drag holds,
/// a motor current that is the velocity of a coordinate), the drift of the place is an unknown, too, and the
/// orbit closes in the velocity. A coordinate that nothing connects must gain no velocity over a period
/// ([`ShootingError::Accelerates`]); bodies that are connected may accelerate together. Times of a guess
/// later than 64 periods are reduced by whole periods.
///
/// Source: Deuflhard, Newton Methods for Nonlinear Problems, Sects. 3.3 and 7.1.
///
/// ```
/// use gear_dynamics::{Shooting, State, model::from_fn};
/// // q'' + 0.1 q' + q = cos 2t
/// let swing = from_fn(1, |t, q, v, a| a[0] = (2.0 * t).cos() - 0.1 * v[0] - q[0])?;
/// let swing = swing.with_period(std::f64::consts::PI)?;
/// let cycle = Shooting::new().solve(&swing, &State::at_rest(1))?;
/// assert!((cycle.states()[0].q[0] + 3.0 / 9.04).abs() < 1e-10); // (1 - Ω²)/((1 - Ω²)² + (0.1 Ω)²)
/// # Ok::<(), gear_dynamics::periodic::ShootingError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[must_use = "a setting returns a new value"]
pub struct Shooting {
    pub(crate) period_multiple: usize,
    pub(super) segments: Option<usize>,
    pub(crate) tolerance: f64,
    pub(crate) flow_tolerance: f64,
    pub(crate) max_iterations: usize,
    pub(super) method: Chosen,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) budget: Budget,
}

impl Default for Shooting {
    fn default() -> Self {
        Shooting::new()
    }
}

/// Maximum number of periods and of segments of an orbit.
pub(crate) const MAX_COUNT: usize = 1_000_000;

/// Default of the steps of one call. A start far from every orbit can use all of them.
const STEPS: u64 = 10_000_000;

impl Shooting {
    /// Defaults: orbits of one period, tolerance 1e-12, flow tolerance 1e-13, 40 iterations, a [`Budget`] of
    /// 10⁷ steps.
    pub fn new() -> Self {
        Shooting {
            period_multiple: 1,
            segments: None,
            tolerance: 1e-12,
            flow_tolerance: 1e-13,
            max_iterations: 40,
            method: Chosen::ByModel,
            budget: Budget::new().steps(STEPS),
        }
    }
    /// Number of periods of the drives in one period of the orbit, 1 to 10⁶. Default: 1.
    pub fn period_multiple(self, period_multiple: usize) -> Self {
        Shooting { period_multiple, ..self }
    }
    /// Number of segments, 1 to 10⁶. Default: one segment for each state of the guess; for a single state,
    /// one segment per 32 integration steps, at most 128.
    ///
    /// Very unstable orbits need more segments. A longer list of states is thinned to this number; a shorter
    /// list is used as it is.
    pub fn segments(self, segments: usize) -> Self {
        Shooting { segments: Some(segments), ..self }
    }
    /// Largest accepted last correction, as a share of the range of each coordinate and velocity, in (0, 1)
    /// `[1]`. Default: 1e-12.
    ///
    /// If the noise of the flow is larger, an orbit is also accepted when the corrections are below 1e-9 and
    /// no longer decrease. [`ShootingOrbit::accuracy`] returns the last correction.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Shooting { tolerance, ..self }
    }
    /// Local error of the integration, as a share of the same ranges `[1]`. Default: 1e-13. The rounding
    /// error of a component replaces it where that is larger.
    pub fn flow_tolerance(self, flow_tolerance: f64) -> Self {
        Shooting { flow_tolerance, ..self }
    }
    /// The method of the integration. Default: Taylor series for a model that can be expanded, DOP853 for
    /// any other.
    pub fn flow_method(self, method: FlowMethod) -> Self {
        Shooting { method: self.method.with(method), ..self }
    }
    /// Replaces the method: see [`Variation::integrator`](crate::periodic::Variation::integrator).
    pub fn integrator(self, integrator: impl Integrator + Send + Sync + 'static) -> Self {
        Shooting { method: Chosen::Own(OwnIntegrator::new(integrator)), ..self }
    }
    /// Maximum number of Newton iterations. Default: 40.
    pub fn max_iterations(self, max_iterations: usize) -> Self {
        Shooting { max_iterations, ..self }
    }

    /// Maximum number of steps and maximum time of one call, over all its integrations. Default: 10⁷ steps,
    /// which take half a minute for one degree of freedom. A solution near its guess takes far fewer.
    ///
    /// ```
    /// use gear_dynamics::{Budget, NfgPair, NfgParams, Shooting, State, ode::Exhausted, periodic::ShootingError};
    /// let pair = NfgPair::new(&NfgParams::table1())?; // its deflections are some 10⁻⁵
    /// let shooting = Shooting::new().budget(Budget::new().steps(1000));
    /// let far = shooting.solve(&pair, &State::new(0.0, &[1.0], &[0.0]));
    /// let limit = Exhausted::Steps { limit: 1000 };
    /// assert!(matches!(far, Err(ShootingError::Exhausted { exhausted, .. }) if exhausted == limit));
    /// # Ok::<(), gear_dynamics::ParameterError>(())
    /// ```
    pub fn budget(self, budget: Budget) -> Self {
        Shooting { budget, ..self }
    }

    /// Finds an orbit from a guess: a state, or several at increasing times within one period of the orbit.
    /// `None`: from the [static state](crate::linear::static_state).
    ///
    /// # Errors
    /// [`ShootingError`]; after the first integration it holds the last iterate and the corrections
    /// so far.
    pub fn solve<'g>(
        &self,
        model: &dyn Periodic,
        guess: impl IntoIterator<Item = &'g State>,
    ) -> Result<ShootingOrbit, ShootingError> {
        let guess: Vec<State> = guess.into_iter().cloned().collect();
        self.find(model, &guess, &self.budget.begin())
    }

    /// Finds the orbit near a known motion: the orbit of a neighbouring model, or a Fourier series. Its
    /// states keep their phases; the velocities are scaled with the frequency. The period multiple is that of
    /// the neighbour.
    ///
    /// From a series of the same model it finds the orbit of the equation itself. The first correction then
    /// measures the error of the series. If it exceeds 0.1, there is no orbit of the equation near the
    /// series.
    ///
    /// # Errors
    /// [`ShootingError`].
    pub fn solve_from(
        &self,
        model: &dyn Periodic,
        neighbour: &dyn Neighbour,
    ) -> Result<ShootingOrbit, ShootingError> {
        self.find_near(model, neighbour, &self.budget.begin())
    }

    /// [`solve_from`](Shooting::solve_from) with the rest of a budget.
    pub(crate) fn find_near(
        &self,
        model: &dyn Periodic,
        neighbour: &dyn Neighbour,
        meter: &Meter<'_>,
    ) -> Result<ShootingOrbit, ShootingError> {
        let period_multiple = neighbour.period_multiple();
        let stretch = period_multiple as f64 * model.period() / neighbour.period();
        let mut guess = neighbour.nodes()?;
        for state in &mut guess {
            state.t *= stretch;
            state.v.iter_mut().for_each(|v| *v /= stretch);
        }
        Shooting { period_multiple, ..self.clone() }.find(model, &guess, meter)
    }

    /// The plan of an orbit in one segment from a nearly closed motion.
    ///
    /// # Errors
    /// Those of the settings, and of the run that measures the ranges of motion.
    pub(crate) fn one_segment<'m>(
        &self,
        model: &'m dyn Periodic,
        start: &State,
        meter: &Meter<'_>,
    ) -> Result<Segments<'m>, ShootingError> {
        self.check(model.dof())?;
        let plan = NodePlan { segments: Some(1), ..self.plan() };
        let guess = Guess::of(model, &plan, std::slice::from_ref(start), meter)?;
        Ok(Segments::new(model, guess.scales, &guess.drifts, guess.end, Vec::new(), Expansion::none()))
    }
    pub(super) fn plan(&self) -> NodePlan {
        NodePlan {
            multiple: self.period_multiple,
            segments: self.segments,
            flow_tolerance: self.flow_tolerance,
            method: self.method.clone(),
        }
    }
    /// The work of one call, which is cancelled once `go_on` returns `false`.
    pub(crate) fn meter<'b>(&'b self, go_on: &'b dyn Fn() -> bool) -> Meter<'b> {
        self.budget.begin_while(go_on)
    }
    pub(crate) fn method(&self) -> &Chosen {
        &self.method
    }

    /// Whether an orbit in one segment, along Taylor series, is what the settings ask for.
    pub(crate) fn suits_lanes(&self) -> bool {
        self.segments.is_none_or(|segments| segments == 1) && self.method.allows_series()
    }

    /// Checks the settings in a sweep, which measures the period multiple of each motion.
    pub(crate) fn check_of_sweep(&self) -> Result<(), ParameterError> {
        check::count("period_multiple of the shooting in a sweep", &[self.period_multiple], 1)?;
        self.check(1)
    }

    pub(super) fn check(&self, dof: usize) -> Result<(), ParameterError> {
        let segments = self.segments.unwrap_or(1);
        let counts = [
            ("period_multiple", self.period_multiple),
            ("segments", segments),
            ("max_iterations", self.max_iterations),
            ("degrees of freedom", dof),
        ];
        if let Some(&(name, value)) = counts.iter().find(|(_, value)| *value == 0) {
            return Err(ParameterError::TooFew { name: name.into(), value, min: 1 });
        }
        check::count("period_multiple", &[self.period_multiple], MAX_COUNT)?;
        check::count("segments", &[segments], MAX_COUNT)?;
        check::share("tolerance", self.tolerance)?;
        check::tolerance("flow_tolerance", self.flow_tolerance).map(drop)
    }
}
