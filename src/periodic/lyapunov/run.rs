//! Lyapunov exponents: the mean growth of small differences along a motion.

use crate::error::{ParameterError, check};
use crate::model::equations::{Model, Periodic, State};
use crate::model::rigid::rigid_modes;
use crate::ode::budget::{Budget, Meter};
use crate::ode::integrator::Integrator;
use crate::ode::step::{Observer, Step};
use crate::periodic::flow::motion_size::Sizes;
use crate::periodic::flow::tangent::Tangent;
use crate::periodic::flow::variation::coarse;
use crate::periodic::lyapunov::directions::{Directions, Failure, Flow};
use crate::periodic::lyapunov::exponents::{Exponents, LyapunovError};
use crate::periodic::lyapunov::growth::Growth;
use std::fmt;
use std::ops::ControlFlow;

/// λ_i = lim 1/t ln(growth of the i-th direction), by QR: small differences follow the variational equations, tooth edges handled, and are
/// made orthonormal again and again; the logarithms of what is divided out are summed.   Source: Benettin et al., Meccanica 15, 9 (1980).
///
/// The first directions are drawn at random from the start, the same for the same start: none lies in a part of the model that others do not
/// reach. Where a direction all but vanishes within a part of a period, that part is halved.
///
/// A rigid mode adds two exponents of zero.
///
/// ```
/// use gear_dynamics::{Lyapunov, Model, Periodic, State};
/// struct Swing; // q'' + 3 q' + 2 q = cos 2t: exponents -1 and -2
/// impl Model for Swing {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) { a[0] = (2.0 * u[0]).cos() - 3.0 * v[0] - 2.0 * q[0]; }
/// }
/// impl Periodic for Swing {
///     fn period(&self) -> f64 { std::f64::consts::PI }
/// }
/// let exponents = Lyapunov::new().periods(20).run(&Swing, &State::at_rest(1))?;
/// assert!((exponents.values()[0] + 1.0).abs() < 1e-7);
/// assert!((exponents.values().iter().sum::<f64>() + 3.0).abs() < 1e-7); // the mean divergence
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, PartialEq)]
pub struct Lyapunov {
    count: Option<usize>,
    settle: usize,
    align: usize,
    periods: usize,
    renormalisations: usize,
    tolerance: f64,
    budget: Budget,
}

impl fmt::Debug for Lyapunov {
    /// What decides the result: all but the budget.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Lyapunov { count, settle, align, periods, renormalisations, tolerance, budget: _ } = self;
        let mut shown = f.debug_struct("Lyapunov");
        shown.field("count", count).field("settle", settle).field("align", align).field("periods", periods);
        shown.field("renormalisations", renormalisations).field("tolerance", tolerance).finish()
    }
}

impl Default for Lyapunov {
    fn default() -> Self {
        Lyapunov::new()
    }
}

impl Lyapunov {
    /// The full spectrum over 200 periods, after 100 to settle and 10 more for the directions to align, made orthonormal 16 times a
    /// period, the flow held to 1e-9.
    pub fn new() -> Self {
        Lyapunov {
            count: None,
            settle: 100,
            align: 10,
            periods: 200,
            renormalisations: 16,
            tolerance: 1e-9,
            budget: Budget::new(),
        }
    }
    /// Only the largest `count`: 1 costs least.
    pub fn count(self, count: usize) -> Self {
        Lyapunov { count: Some(count), ..self }
    }
    /// Periods to settle before anything is measured.
    pub fn settle(self, settle: usize) -> Self {
        Lyapunov { settle, ..self }
    }
    /// Periods for the directions to align.
    pub fn align(self, align: usize) -> Self {
        Lyapunov { align, ..self }
    }
    /// Periods to measure.
    pub fn periods(self, periods: usize) -> Self {
        Lyapunov { periods, ..self }
    }
    /// How often the directions are made orthonormal in a period, at the least; up to 65536.
    pub fn renormalisations(self, renormalisations: usize) -> Self {
        Lyapunov { renormalisations, ..self }
    }
    /// Local error of the flow, as a share of the range of each coordinate and velocity.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Lyapunov { tolerance, ..self }
    }
    /// How many steps and how much time it may take; settling counts.
    pub fn budget(self, budget: Budget) -> Self {
        Lyapunov { budget, ..self }
    }

    /// Along the motion from `start`.
    ///
    /// # Errors
    /// [`LyapunovError`], with the exponents over the periods that succeeded.
    pub fn run<M: Periodic + ?Sized>(&self, model: &M, start: &State) -> Result<Exponents, LyapunovError> {
        self.run_over(model, start, model.period())
    }

    /// The same for a model that does not repeat: `span` takes the place of the period.
    ///
    /// # Errors
    /// [`LyapunovError`], with the exponents over the spans that succeeded.
    pub fn run_over<M: Model + ?Sized>(
        &self,
        model: &M,
        start: &State,
        span: f64,
    ) -> Result<Exponents, LyapunovError> {
        self.run_while(model, start, span, &|| true)
    }

    /// The same as long as `go_on` says so; afterwards the exponents are those of the spans that are done.
    pub(crate) fn run_while<M: Model + ?Sized>(
        &self,
        model: &M,
        start: &State,
        span: f64,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Exponents, LyapunovError> {
        self.run_any(&model, start, span, go_on)
    }

    fn run_any(
        &self,
        model: &dyn Model,
        start: &State,
        span: f64,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Exponents, LyapunovError> {
        let components = 2 * model.dof();
        let count = self.count.unwrap_or(components);
        self.check(count, components, start, span)?;
        let meter = self.budget.begin();
        let mut exponents = Exponents {
            span,
            grown: vec![Growth::new(self.renormalisations); count],
            floor: 0.0,
            state: start.clone(),
        };
        let mut sizes = Sizes::new(model.dof(), &rigid_modes(model, span));
        if let Err(failure) = self.settle_down(model, span, &mut sizes, &mut exponents.state, &meter) {
            return Err(failure.with(exponents));
        }
        let scale = sizes.ranges();
        let tangent = Tangent::new(model, count, &scale, self.tolerance);
        exponents.floor = FLOOR * self.tolerance;
        let mut flow = Flow {
            tangent: &tangent,
            tolerance: self.tolerance,
            meter: &meter,
            directions: Directions::new(count, &scale),
            halvings: 0,
        };
        let (from, mut all) = (exponents.state.t, tangent.start(&exponents.state));
        flow.directions.draw(start, &mut all);
        let parts = self.renormalisations as f64;
        let aligning = (0..self.align).map(|period| (period as f64, false));
        let measuring = (0..self.periods).map(|period| (self.align as f64 + period as f64, true));
        for (period, measured) in aligning.chain(measuring) {
            for part in 1..=self.renormalisations {
                if !go_on() {
                    return Ok(exponents.in_order());
                }
                if let Err(failure) = flow.part(&mut all, from + span * (period + part as f64 / parts)) {
                    return Err(failure.with(exponents.in_order()));
                }
                for (all, grown) in exponents.grown.iter_mut().zip(&flow.directions.growth) {
                    match measured {
                        true => all.measure(*grown),
                        false if period >= (self.align / 2) as f64 => all.align(*grown),
                        false => {}
                    }
                }
            }
            if measured {
                exponents.grown.iter_mut().for_each(Growth::period);
            }
            exponents.state = tangent.motion(&all);
        }
        Ok(exponents.in_order())
    }

    /// Runs to where the motion has settled; `state` is always the last one reached. The sizes are those of the last period, or of the first
    /// one if nothing is to settle.
    fn settle_down(
        &self,
        model: &dyn Model,
        span: f64,
        sizes: &mut Sizes,
        state: &mut State,
        meter: &Meter<'_>,
    ) -> Result<(), Failure> {
        let settled = state.t + self.settle as f64 * span;
        if self.settle > 1 {
            let start = state.clone();
            let mut last = Last { state, meter };
            let finish = coarse(&start).run(model, &start, settled - span, &mut last)?;
            *state = finish.state;
            meter.left()?;
        }
        sizes.see(state.t, &state.q, &state.v);
        let start = state.clone();
        let mut ahead = start.clone();
        let mut last = Last { state: &mut ahead, meter };
        let finish = coarse(&start).run(model, &start, start.t + span, &mut (sizes, &mut last));
        if self.settle > 0 {
            *state = ahead;
        }
        let finish = finish?;
        meter.left()?;
        if self.settle > 0 {
            *state = finish.state;
        }
        Ok(())
    }

    /// What can be told without a model.
    pub(crate) fn check_settings(&self) -> Result<(), ParameterError> {
        let count = self.count.unwrap_or(1);
        for (name, value) in
            [("count", count), ("periods", self.periods), ("renormalisations", self.renormalisations)]
        {
            if value == 0 {
                return Err(ParameterError::TooFew { name: name.into(), value, least: 1 });
            }
        }
        if self.renormalisations > MOST {
            let (name, value) = ("renormalisations".into(), self.renormalisations as f64);
            return Err(ParameterError::OutOfRange { name, value, allowed: "1 to 65536 a period" });
        }
        check::tolerance("tolerance", self.tolerance).map(drop)
    }

    fn check(&self, count: usize, components: usize, start: &State, span: f64) -> Result<(), LyapunovError> {
        self.check_settings()?;
        if components == 0 {
            return Err(
                ParameterError::TooFew { name: "degrees of freedom".into(), value: 0, least: 1 }.into()
            );
        }
        if count > components {
            let allowed = "1 to the number of coordinates and velocities";
            return Err(
                ParameterError::OutOfRange { name: "count".into(), value: count as f64, allowed }.into()
            );
        }
        check::scale("span", span)?;
        Ok(start.check(components / 2)?)
    }
}

/// Most renormalisations in a period.
const MOST: usize = 1 << 16;

/// The flow is off by local errors of its own, which scatter does not show: the standard error per period is this share of its tolerance at least.
const FLOOR: f64 = 10.0;

/// Keeps the last state and counts steps.
struct Last<'s> {
    state: &'s mut State,
    meter: &'s Meter<'s>,
}

impl Observer for Last<'_> {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        self.state.t = step.t1();
        self.state.q.copy_from_slice(step.q1());
        self.state.v.copy_from_slice(step.v1());
        let mut meter = self.meter;
        meter.step(step)
    }
}
