//! Time integration with located edges.

mod adaptive;
mod blocks;
mod control;
mod dop853;
mod driver;
mod engine;
mod exit;
mod first_root;
mod gaps;
mod hermite;
mod inside;
mod locate;
mod rk4;
mod rk45;
mod step;
mod stops;
mod trajectory;
mod vector;

pub use adaptive::Adaptive;
pub use dop853::{Dop853, DormandPrince8};
pub use rk4::Rk4;
pub use rk45::{DormandPrince5, Rk45};
pub use step::{Crossing, Observer, Step, StepView};
pub(crate) use stops::Flight;
pub use trajectory::{Failed, Trajectory, uniform_times};

use crate::error::ParameterError;
use crate::model::{Model, State};
use driver::drive;
use std::ops::ControlFlow;
use thiserror::Error;

/// Advances a model in time. Every solver offers the same five calls; analysis is written against this trait.
///
/// ```
/// use gear_dynamics::{Integrator, Model, Rk4, State};
/// struct Spring;
/// impl Model for Spring {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) { a[0] = -q[0]; }
/// }
/// let run = Rk4::new(0.01).sample(&Spring, &State::new(0.0, &[1.0], &[0.0]), &[0.5, 1.0])?;
/// assert_eq!(run.times(), [0.5, 1.0]);
/// assert!((run.q(1)[0] - 1f64.cos()).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Integrator {
    /// Runs from `start` to `t_end`, which is hit exactly, showing every accepted step to the observer.
    ///
    /// # Errors
    /// [`IntegrateError`]; what the observer has seen until then is still with the observer.
    fn run<M: Model + ?Sized, O: Observer>(
        &self,
        model: &M,
        start: &State,
        t_end: f64,
        observer: &mut O,
    ) -> Result<Finish, IntegrateError>;

    /// The state at `t_end`.
    ///
    /// # Errors
    /// [`IntegrateError`].
    fn end<M: Model + ?Sized>(&self, model: &M, start: &State, t_end: f64) -> Result<State, IntegrateError> {
        self.run(model, start, t_end, &mut |_: &mut Step<'_>| ControlFlow::Continue(()))
            .map(|finish| finish.state)
    }

    /// Every accepted step, the start included.
    ///
    /// # Errors
    /// [`Failed`], which holds the trajectory up to the failure.
    fn trajectory<M: Model + ?Sized>(
        &self,
        model: &M,
        start: &State,
        t_end: f64,
    ) -> Result<Trajectory, Failed> {
        let mut trajectory = Trajectory::empty(model.dof(), start.t);
        if let Err(error) = start.check(model.dof()) {
            return trajectory.or_failed(Err(error.into()));
        }
        trajectory.push_state(start);
        let run = self.run(model, start, t_end, &mut |step: &mut Step<'_>| {
            trajectory.push(step.t1(), step.y1());
            ControlFlow::Continue(())
        });
        trajectory.or_failed(run)
    }

    /// The states at given increasing times, none before the start.
    ///
    /// # Errors
    /// [`Failed`], which holds the states up to the failure.
    fn sample<M: Model + ?Sized>(
        &self,
        model: &M,
        start: &State,
        times: &[f64],
    ) -> Result<Trajectory, Failed> {
        let mut trajectory = Trajectory::empty(model.dof(), start.t);
        if let Err(error) = start
            .check(model.dof())
            .map_err(IntegrateError::from)
            .and_then(|()| trajectory::check_times(start.t, times))
        {
            return trajectory.or_failed(Err(error));
        }
        let mut left = times;
        while let [first, rest @ ..] = left
            && *first == start.t
        {
            trajectory.push_state(start);
            left = rest;
        }
        let Some(&last) = left.last() else {
            return Ok(trajectory);
        };
        let mut y = vec![0.0; 2 * model.dof()];
        let mut keep = |step: &mut Step<'_>| {
            while let [t, rest @ ..] = left
                && *t <= step.t1()
            {
                step.at(*t, &mut y);
                trajectory.push(*t, &y);
                left = rest;
            }
            ControlFlow::Continue(())
        };
        let run = self.run(model, start, last, &mut keep);
        trajectory.or_failed(run)
    }
}

/// How a run ended.
///
/// ```
/// use gear_dynamics::{Finish, State, Stats};
/// let finish = Finish { state: State::new(2.5, &[1.0], &[0.0]), stopped: false, stats: Stats::default() };
/// assert_eq!(finish.state.t, 2.5);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Finish {
    /// The last state.
    pub state: State,
    /// Whether the observer stopped it.
    pub stopped: bool,
    /// What it took.
    pub stats: Stats,
}

/// What a run took.
///
/// ```
/// use gear_dynamics::{Integrator, Model, Rk4, State, Step};
/// use std::ops::ControlFlow;
/// struct Rest;
/// impl Model for Rest {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) { a[0] = 0.0; }
/// }
/// let mut quiet = |_: &mut Step<'_>| ControlFlow::Continue(());
/// let stats = Rk4::new(0.25).run(&Rest, &State::at_rest(1), 1.0, &mut quiet)?.stats;
/// assert_eq!((stats.steps, stats.evaluations), (4, 16));
/// # Ok::<(), gear_dynamics::IntegrateError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected ones.
    pub rejected: u64,
    /// Evaluations of the acceleration.
    pub evaluations: u64,
    /// Tooth edges crossed and rigid stops met; a contact that finds itself on another piece at the start of a step, because its edges jumped or its gap is
    /// zero, is not counted.
    pub crossings: u64,
    /// Jumps of the drives met.
    pub drive_edges: u64,
}

/// Why a run ended early.
///
/// ```
/// use gear_dynamics::{IntegrateError, Integrator, Model, Rk4, State};
/// struct Rest;
/// impl Model for Rest {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) { a[0] = 0.0; }
/// }
/// let error = Rk4::new(0.1).end(&Rest, &State::at_rest(1), -1.0).unwrap_err();
/// assert_eq!(error, IntegrateError::TimeSpan { start: 0.0, end: -1.0 });
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum IntegrateError {
    /// The end does not lie after the start, or beyond 1e50.
    #[error("the time span from {start} to {end} is not positive, or ends beyond 1e50")]
    TimeSpan {
        /// Start time.
        start: f64,
        /// End time.
        end: f64,
    },
    /// Output times out of order, before the start, or not numbers.
    #[error(
        "output time {index} is {value}: times must be finite, increasing, and not before the start at {start}"
    )]
    OutputTime {
        /// Its place in the list.
        index: usize,
        /// What it was.
        value: f64,
        /// Where the run starts.
        start: f64,
    },
    /// A step or a tolerance that cannot be used.
    #[error("{name} is {value}: it must be {allowed}")]
    Setting {
        /// Which one.
        name: &'static str,
        /// What it was.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A list of absolute tolerances that does not fit the model.
    #[error(
        "{found} absolute tolerances for {expected} components: give one, or one for each coordinate and velocity"
    )]
    ToleranceLength {
        /// Components of the state.
        expected: usize,
        /// Tolerances given.
        found: usize,
    },
    /// A start that does not fit the model.
    #[error("start: {0}")]
    Start(#[from] ParameterError),
    /// The model gave a NaN or an infinity, or the motion grew beyond 1e100.
    #[error(
        "component {component} of (coordinates, velocities) is beyond 1e100 or its derivative is not finite after t = {t}; components \
         count from 0"
    )]
    NotFinite {
        /// The last good time.
        t: f64,
        /// Place in (coordinates, velocities), from 0: `dof + i` when the acceleration of coordinate i is the first to fail.
        component: usize,
    },
    /// A model that gave a slope which is not finite, where its motion is.
    #[error("the slope of acceleration {acceleration} in {of} {coordinate} is not finite after t = {t}")]
    Slope {
        /// The last good time.
        t: f64,
        /// Which acceleration, from 0.
        acceleration: usize,
        /// "coordinate" or "velocity".
        of: &'static str,
        /// Which coordinate or velocity, from 0.
        coordinate: usize,
    },
    /// No step is short enough for the tolerance.
    #[error("the step fell to {h} at t = {t}: the tolerance cannot be met")]
    StepUnderflow {
        /// Where.
        t: f64,
        /// The step that would have been needed.
        h: f64,
    },
    /// The limit on the number of steps.
    #[error("{limit} steps were made by t = {t}: raise max_steps, or loosen the tolerance")]
    TooManySteps {
        /// How far it came.
        t: f64,
        /// The limit.
        limit: usize,
    },
    /// A model that announces a jump of its drives that does not lie ahead.
    #[error("the next edge of the drives after t = {t} is said to be at {edge}: it must lie ahead")]
    DriveEdge {
        /// Asked at.
        t: f64,
        /// The answer.
        edge: f64,
    },
    /// A gap whose edges have passed each other: a negative backlash.
    #[error(
        "the gap of contact {contact} reaches from {lower} to {upper} at t = {t}: the half width is negative"
    )]
    NegativeGap {
        /// When it was seen.
        t: f64,
        /// Which contact.
        contact: usize,
        /// Its lower edge.
        lower: f64,
        /// Its upper edge.
        upper: f64,
    },
    /// The budget of the call is spent, or it was cancelled.
    #[error("stopped at t = {t}: {exhausted}")]
    Budget {
        /// How far it came.
        t: f64,
        /// Which limit.
        exhausted: crate::budget::Exhausted,
    },
    /// A contact that comes to rest on a rigid stop, after impacts without number or at once: from there on it would be pressed against the
    /// stop, which is not modelled.
    #[error(
        "contact {contact} comes to rest on its rigid stop at t = {t}: motion along a stop is not modelled"
    )]
    RestsOnStop {
        /// When.
        t: f64,
        /// Which contact.
        contact: usize,
    },
    /// A start beyond a rigid stop, or a stop that jumped past its contact.
    #[error("contact {contact} lies {depth} beyond its rigid stop at t = {t}")]
    BeyondStop {
        /// When it was seen.
        t: f64,
        /// Which contact.
        contact: usize,
        /// How far.
        depth: f64,
    },
    /// A rigid stop in a run that does not locate edges.
    #[error("contact {contact} has a rigid stop, which can be met only where edges are located")]
    StopNotLocated {
        /// Which contact.
        contact: usize,
    },
    /// A contact that changes its piece again and again without time moving.
    #[error("contact {contact} stalls on its edge at t = {t}: it changes its piece without time moving")]
    EdgeStall {
        /// Where.
        t: f64,
        /// Which contact.
        contact: usize,
    },
}
