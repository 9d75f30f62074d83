//! Why a run ended early.

use crate::error::ParameterError;
use thiserror::Error;

/// Why a run ended early.
///
/// ```
/// use gear_dynamics::{ode::IntegrateError, Integrator, Model, Rk4, State};
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
        exhausted: crate::ode::budget::Exhausted,
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
