//! Solvers from steps of one's own.

use crate::error::check;
use crate::model::{Model, State};
use crate::ode::driver::drive;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::integrator::Integrator;
use crate::ode::methods::adaptive::Adaptive;
use crate::ode::outcome::Finish;
use crate::ode::step::Observer;
use crate::ode::stepping::control::{Limits, StepRule, Task};
use crate::ode::stepping::engine::{Engine, Tableau};
use crate::ode::stepping::one_step::{OneStep, OwnStep, Slope};
use crate::ode::stepping::vector::Vector;

/// A solver with fixed steps h, which are those of a [`OneStep`]. Edges are located, as by
/// [`Rk4`](crate::Rk4), and steps end on the grid `start.t + k h`.
///
/// Between the ends of a step the motion is the cubic through the states and derivatives at both ends
/// (Hermite): its local error is of h⁴. At a crossing the step is repeated up to the crossing, so that the
/// states at both ends of every step have the order of the method.
///
/// [`OneStep`] has an example with edges.
///
/// ```
/// use gear_dynamics::ode::{OneStep, Slope, Stepped};
/// use gear_dynamics::{Integrator, State, model::from_fn};
/// /// Euler's method.
/// struct Euler;
/// impl OneStep for Euler {
///     fn step(&self, f: &mut Slope<'_>, end: &mut [f64], _: &mut [f64], _: &mut [f64]) {
///         let h = f.h();
///         end.iter_mut().zip(f.start().iter().zip(f.first())).for_each(|(y1, (y, k))| *y1 = y + h * k);
///     }
/// }
/// let rest = from_fn(1, |_, _, _, a| a[0] = -2.0)?;
/// let end = Stepped::new(Euler, 0.25).end(&rest, &State::new(0.0, &[0.0], &[1.0]), 1.0)?;
/// assert_eq!((end.q[0], end.v[0]), (0.25 * (1.0 + 0.5 + 0.0 - 0.5), -1.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct Stepped<S> {
    method: S,
    step: f64,
    limits: Limits,
}

impl<S: OneStep> Stepped<S> {
    /// Fixed step h, in the time unit of the model.
    pub fn new(method: S, step: f64) -> Self {
        Stepped { method, step, limits: Limits::default() }
    }
    /// Does not locate edges of the gaps: steps run across them.
    pub fn plain(mut self) -> Self {
        self.limits.locate = false;
        self
    }
    /// Maximum number of steps. Default: 10⁸.
    pub fn max_steps(mut self, steps: usize) -> Self {
        self.limits.max_steps = steps;
        self
    }
}

impl<S: OneStep> Integrator for Stepped<S> {
    fn run(
        &self,
        model: &dyn Model,
        start: &State,
        t_end: f64,
        observer: &mut dyn Observer,
    ) -> Result<Finish, IntegrateError> {
        let (rule, limits) = (StepRule::Fixed(self.step), self.limits);
        drive::<OwnTableau<false>>(Task {
            rule,
            limits,
            model,
            start,
            t_end,
            observer,
            own: Some(&self.method),
        })
    }
}

/// Steps of one's own, of which [`Adaptive::of_steps`] makes a solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OwnSteps<S>(pub(crate) S);

impl<S: OneStep> Adaptive<OwnSteps<S>> {
    /// A solver whose steps are those of a [`OneStep`] with an error estimate of order q, 1/(q + 1) the
    /// exponent of the control. Edges are located, and between the ends of a step the motion is Hermite's
    /// cubic, as with [`Stepped`]. Defaults: rtol 1e-9, atol 1e-12, no maximum step, at most 10⁸ steps.
    ///
    /// ```
    /// use gear_dynamics::ode::{Adaptive, OneStep, Slope};
    /// use gear_dynamics::{Integrator, State, model::from_fn};
    /// /// Bogacki and Shampine: order 3, with an estimate of order 2.
    /// struct Third;
    /// impl OneStep for Third {
    ///     fn estimate_order(&self) -> u32 {
    ///         2
    ///     }
    ///     fn work(&self, components: usize) -> usize {
    ///         4 * components
    ///     }
    ///     fn step(&self, f: &mut Slope<'_>, end: &mut [f64], error: &mut [f64], work: &mut [f64]) {
    ///         let (h, m) = (f.h(), end.len());
    ///         let [k2, k3, k4, y] = work.get_disjoint_mut([0..m, m..2 * m, 2 * m..3 * m, 3 * m..4 * m]).unwrap();
    ///         (0..m).for_each(|j| y[j] = f.start()[j] + 0.5 * h * f.first()[j]);
    ///         f.at(0.5, y, k2);
    ///         (0..m).for_each(|j| y[j] = f.start()[j] + 0.75 * h * k2[j]);
    ///         f.at(0.75, y, k3);
    ///         let sum = |j: usize, k1: f64| (2.0 * k1 + 3.0 * k2[j] + 4.0 * k3[j]) / 9.0;
    ///         (0..m).for_each(|j| end[j] = f.start()[j] + h * sum(j, f.first()[j]));
    ///         f.at(1.0, end, k4);
    ///         let other = |j: usize, k1: f64| k1 * 7.0 / 24.0 + k2[j] / 4.0 + k3[j] / 3.0 + k4[j] / 8.0;
    ///         (0..m).for_each(|j| error[j] = h * (sum(j, f.first()[j]) - other(j, f.first()[j])));
    ///     }
    /// }
    /// let spring = from_fn(1, |_, q, _, a| a[0] = -q[0])?;
    /// let solver = Adaptive::of_steps(Third).rtol(1e-9).atol(1e-12);
    /// let end = solver.end(&spring, &State::new(0.0, &[1.0], &[0.0]), 1.0)?;
    /// assert!((end.q[0] - 1f64.cos()).abs() < 1e-8);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_steps(method: S) -> Self {
        Adaptive::of(OwnSteps(method), [1e-9, 1e-12], 0.0)
    }
}

impl<S: OneStep> Integrator for Adaptive<OwnSteps<S>> {
    fn run(
        &self,
        model: &dyn Model,
        start: &State,
        t_end: f64,
        observer: &mut dyn Observer,
    ) -> Result<Finish, IntegrateError> {
        let (rule, limits, own) = (StepRule::Adaptive(&self.tolerances), self.limits, &self.method.0);
        let order = own.estimate_order() as usize;
        check::at_least("estimate_order", order, 1)?;
        check::count("estimate_order", &[order], 100)?;
        drive::<OwnTableau<true>>(Task { rule, limits, model, start, t_end, observer, own: Some(own) })
    }
}

/// The steps of a method of one's own, by their error estimate or of a fixed length.
#[derive(Default)]
struct OwnTableau<const ADAPTIVE: bool>;

impl<const ADAPTIVE: bool> Tableau for OwnTableau<ADAPTIVE> {
    const ADAPTIVE: bool = ADAPTIVE;
    const SLOTS: usize = 3;
    const EVALUATIONS: u64 = 0;
    const END: usize = 2;
    const DENSE: usize = 3;
    const DENSE_EVALUATIONS: u64 = 0;
    /// The method states its own ([`OwnStep::exponent`]).
    const EXPONENT: f64 = 1.0;
    const FACTORS: [f64; 2] = [0.2, 5.0];
    const BETA: f64 = 0.0;
    const NODES: &'static [f64] = &[0.5, 1.0];
    const PROBE: usize = 0;

    fn attempt<V: Vector, const FIXED: bool>(e: &mut Engine<'_, V>) {
        e.drive_nodes::<Self>();
        e.own_step::<FIXED>();
    }
    fn error<V: Vector>(e: &mut Engine<'_, V>) -> f64 {
        e.own_error()
    }
    fn dense<V: Vector, const FIXED: bool>(_: &mut Engine<'_, V>) {}
}

impl<V: Vector> Engine<'_, V> {
    /// Lets the method of one's own make the step.
    fn own_step<const FIXED: bool>(&mut self) {
        let Some(OwnStep { method, error, work }) = &mut self.own else { return };
        let ends = &mut self.ends;
        let mut slope = Slope {
            model: ends.model,
            t: ends.t,
            h: ends.h(),
            edges: ends.edges,
            start: ends.y.slice(),
            first: self.k[0].slice(),
            pieces: FIXED.then_some(&ends.pieces[..]),
            u: &mut ends.u_stage,
            nodes: &ends.nodes,
            evaluations: 0,
        };
        // What the method does not write ends the run.
        ends.y1.slice_mut().fill(f64::NAN);
        error.fill(f64::NAN);
        method.step(&mut slope, ends.y1.slice_mut(), error, work);
        self.evaluations += slope.evaluations;
    }

    /// Root mean square of the errors of the method of one's own, in units of the tolerances.
    fn own_error(&self) -> f64 {
        let Some(OwnStep { error, .. }) = &self.own else { return 0.0 };
        let ends = &self.ends;
        let [y, y1, atol] = [&ends.y, &ends.y1, &ends.atol].map(Vector::slice);
        let share = |j: usize| error[j] / (atol[j] + self.rtol * y[j].abs().max(y1[j].abs()));
        ((0..y.len()).map(|j| share(j).powi(2)).sum::<f64>() / y.len() as f64).sqrt()
    }
}
