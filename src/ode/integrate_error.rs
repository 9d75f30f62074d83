//! Errors of time integration.

use crate::error::ParameterError;
use thiserror::Error;

/// The reason why a time integration failed.
///
/// ```
/// use gear_dynamics::{ode::IntegrateError, Integrator, Rk4, State, model::from_fn};
/// let rest = from_fn(1, |_, _, _, a| a[0] = 0.0)?;
/// let error = Rk4::new(0.1).end(&rest, &State::at_rest(1), -1.0).unwrap_err();
/// assert_eq!(error, IntegrateError::TimeSpan { start: 0.0, end: -1.0 });
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum IntegrateError {
    /// The end time is not after the start time, or its magnitude exceeds 1e50.
    #[error(
        "the time span from {start:?} to {end:?} is not allowed: it must be positive and end within ±1e50"
    )]
    TimeSpan {
        /// Start time.
        start: f64,
        /// End time.
        end: f64,
    },
    /// The output times decrease, lie before the start, or are not finite.
    #[error(
        "output time {index} is {value:?}: times must be finite, not decreasing, not before the start {start:?}"
    )]
    OutputTime {
        /// Index in the list of times, from 0.
        index: usize,
        /// The time given.
        value: f64,
        /// Start time of the run.
        start: f64,
    },
    /// A setting of the solver is outside its range, or the start state does not fit the model.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The model returned a NaN or an infinity, or the motion exceeds 1e100.
    #[error(
        "component {component} of (coordinates, velocities) exceeds 1e100, or its derivative is not finite, \
         after t = {t:?}; components count from 0"
    )]
    NotFinite {
        /// The last time with a valid state.
        t: f64,
        /// Index in (coordinates, velocities), from 0: `dof + i` if the acceleration of coordinate i fails
        /// first.
        component: usize,
    },
    /// An acceleration is NaN although the state is finite: at the start of a run, or at the start of a step
    /// of a Taylor series.
    #[error(
        "acceleration {acceleration} is NaN at t = {t:?}, where the state is finite: check the model and its \
         parameters there (accelerations count from 0)"
    )]
    NotANumber {
        /// The time of the state.
        t: f64,
        /// Index of the acceleration, from 0.
        acceleration: usize,
    },
    /// An entry of ∂a/∂q or ∂a/∂v is not finite, although the motion is finite.
    #[error(
        "the derivative of acceleration {acceleration} with respect to {of} {coordinate} is not finite after \
         t = {t:?}; indices count from 0"
    )]
    Slope {
        /// The last time with a valid state.
        t: f64,
        /// Index of the acceleration, from 0.
        acceleration: usize,
        /// "coordinate" or "velocity".
        of: &'static str,
        /// Index of the coordinate or velocity, from 0.
        coordinate: usize,
    },
    /// The model, or a part of it, has no Taylor series. [`Dop853`](crate::Dop853) integrates any model.
    #[error("{place} has no Taylor series because of {what}: use Dop853")]
    NoSeries {
        /// The acceleration or the edge without a series; the model, if it has none at all.
        place: String,
        /// What has no series.
        what: &'static str,
    },
    /// A drive of the model has no Taylor series. [`Dop853`](crate::Dop853) integrates any model.
    #[error("drive {drive} of the model has no Taylor series because of {what}: use Dop853")]
    DriveWithoutSeries {
        /// Index of the drive, from 0.
        drive: usize,
        /// What has no series.
        what: &'static str,
    },
    /// The acceleration has no Taylor series at an instant, and steps towards it shrink to nothing; or its
    /// coefficients overflow, as those of e^x do above x = 700.
    #[error(
        "the steps of the Taylor series shrink to nothing at t = {t:?}, because of {what} or of coefficients that \
         overflow: use Dop853"
    )]
    NoSeriesAt {
        /// The time reached.
        t: f64,
        /// What has no series there.
        what: &'static str,
    },
    /// The step size is below the resolution of the time, about 4 ε |t| (ε = 2.2e-16): an adaptive solver
    /// cannot meet its tolerance, or the fixed step is too small.
    #[error(
        "the step {h:?} at t = {t:?} is below the resolution of the time: the tolerance cannot be met, or the \
         fixed step is too small"
    )]
    StepUnderflow {
        /// Start time of the step.
        t: f64,
        /// The step size.
        h: f64,
    },
    /// The motion tends to infinity at a finite time: steps shrink to nothing, and a component exceeds 1e12.
    #[error(
        "the motion grows without bound at t = {t:?}, where component {component} of (coordinates, velocities) is \
         {value:?} (components count from 0): check the force at large deflections and its sign"
    )]
    Unbounded {
        /// The time reached.
        t: f64,
        /// Index of the largest component in (coordinates, velocities), from 0.
        component: usize,
        /// Its value.
        value: f64,
    },
    /// An acceleration jumps, and the motion stays on the jump: dry friction that sticks, or forces that push
    /// towards the jump from both sides. Steps of an adaptive solver shrink to its tolerance there.
    #[error(
        "acceleration {acceleration} jumps near t = {t:?} and the motion stays on the jump: it sticks or slides \
         there, which is not modelled; make the force continuous (accelerations count from 0)"
    )]
    Discontinuity {
        /// The time reached.
        t: f64,
        /// Index of the acceleration that jumps, from 0.
        acceleration: usize,
    },
    /// The time is so late that its rounding, ε |t| with ε = 2.2e-16, changes the accelerations through the
    /// drives by more than half of the tolerance of a step: the steps of an adaptive solver stay short. A
    /// model that repeats has the same motion from an earlier start, by whole periods.
    #[error(
        "at t = {t:?} the time is resolved to {resolution:e} only, and the drives change the motion within it by \
         {change:e} tolerances of a step: start whole periods earlier, as `Settle` and `Shooting` do, use fixed \
         steps or `Taylor`, or loosen the tolerance"
    )]
    LateTime {
        /// The time reached.
        t: f64,
        /// Rounding of the time.
        resolution: f64,
        /// Effect of the rounding on a velocity at the end of the step, in tolerances `[1]`.
        change: f64,
    },
    /// The rounding of the coordinates, ε |q| with ε = 2.2e-16, changes a velocity by more than half of its
    /// tolerance and keeps the steps of an adaptive solver below 1 % of the longest one. Such coordinates are
    /// far larger than their motion. An example is a contact on one flank of a wide gap.
    #[error(
        "the rounding of the coordinates near t = {t:?} changes velocity {velocity} by {rounding:e} in a step, which \
         its tolerance {tolerance:e} does not allow: raise atol or rtol (velocities count from 0)"
    )]
    BelowRounding {
        /// The time reached.
        t: f64,
        /// Index of the velocity, from 0.
        velocity: usize,
        /// Its change in a step that was rejected.
        rounding: f64,
        /// Its tolerance in a step, atol + rtol |v|.
        tolerance: f64,
    },
    /// The run reached the maximum number of steps, rejected steps included.
    #[error("the limit of {limit} steps was reached at t = {t:?}: raise max_steps, or loosen the tolerance")]
    TooManySteps {
        /// The time reached.
        t: f64,
        /// The maximum number of steps.
        limit: usize,
    },
    /// The drive edges ahead are more than the run may have steps. A step ends at an edge at the latest.
    #[error(
        "drive edges lie {apart:e} apart after t = {t:?}, more of them until the end than the {max_steps} steps \
         of a run: hold values for longer, shorten the run, or raise max_steps"
    )]
    TooManyEdges {
        /// Start time of the run.
        t: f64,
        /// Mean distance of the next edges.
        apart: f64,
        /// The maximum number of steps.
        max_steps: usize,
    },
    /// [`Model::next_edge`](crate::Model::next_edge) returned a drive edge that is not later than the given
    /// time.
    #[error("the model gives {edge:?} as its next drive edge after t = {t:?}: it must be later than t")]
    DriveEdge {
        /// The time given to `next_edge`.
        t: f64,
        /// The time returned.
        edge: f64,
    },
    /// The lower edge of a gap lies above its upper edge, or one of them is not a number. The backlash is
    /// then negative or not defined.
    #[error(
        "the gap of contact {contact} is negative or not a number at t = {t:?}: its lower edge is {lower:?}, its upper edge {upper:?}"
    )]
    NegativeGap {
        /// Time of the check.
        t: f64,
        /// Index of the contact, from 0.
        contact: usize,
        /// Lower edge of the gap.
        lower: f64,
        /// Upper edge of the gap.
        upper: f64,
    },
    /// The deflection of a contact is not a number, so that its piece is not defined.
    #[error(
        "the deflection of contact {contact} is not a number at t = {t:?}: check the contacts of the model"
    )]
    NoDeflection {
        /// Time of the check.
        t: f64,
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// A segment of an orbit does not end at the node after it: the model is not that of the orbit, or the
    /// orbit was changed by hand.
    #[error(
        "segment {segment} of the orbit ends {miss:.1e} of the range of the motion beside the node after it: give the \
         model of the orbit, or shoot over more segments if it is far from stable (segments count from 0)"
    )]
    OtherOrbit {
        /// Index of the segment, from 0.
        segment: usize,
        /// Largest difference between the end of the segment and the next node in a coordinate or velocity,
        /// as a share of the range of that component `[1]`.
        miss: f64,
    },
    /// The [`Budget`](crate::Budget) of the call is spent, or the call was cancelled.
    #[error("stopped at t = {t:?}: {exhausted}")]
    Exhausted {
        /// The time reached.
        t: f64,
        /// The limit that was reached.
        exhausted: crate::ode::budget::Exhausted,
    },
    /// A contact comes to rest on a rigid stop, after a sequence of ever lower rebounds or immediately. The
    /// motion that follows, with the contact pressed against the stop, is not modelled.
    #[error(
        "contact {contact} comes to rest on its rigid stop at t = {t:?}: motion along a stop is not modelled"
    )]
    RestsOnStop {
        /// Time at which it rests.
        t: f64,
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// A contact rests on an edge of its gap where the stiffness or the damping of the model jumps, so that
    /// the motion has two one-sided derivatives: an unloaded contact without backlash whose flanks differ, or
    /// one that just touches.
    #[error(
        "contact {contact} rests on an edge of its gap from t = {t:?} on, where the slope of the accelerations \
         jumps: the motion has two one-sided derivatives and no multipliers; load the contact, or state flanks of \
         one slope"
    )]
    RestsOnEdge {
        /// Start time.
        t: f64,
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// The small differences of a motion, which give its derivative, keep the steps short: a slope of an
    /// acceleration jumps where the model states no edge, or the differences are lost in rounding. An example
    /// is a motion that grows by orders of magnitude, under central differences of its accelerations.
    #[error(
        "the derivative of the motion is not resolved near t = {t:?}: the slopes of acceleration {acceleration} jump \
         there, or their rounding exceeds the tolerance (accelerations count from 0); state a kink as a contact, give \
         the model a Jacobian, or start nearer to a motion that stays bounded"
    )]
    DerivativeNotResolved {
        /// The time reached.
        t: f64,
        /// Index of the acceleration, from 0.
        acceleration: usize,
    },
    /// An acceleration jumps where the model states no edge, as that of dry friction written with the sign of
    /// a velocity. A run passes such a jump; the derivative of the flow jumps there, too, and needs its edge.
    #[error(
        "acceleration {acceleration} jumps at t = {t:?} where the model states no edge: the derivative of the motion \
         is not known there (accelerations count from 0); make the force continuous, as with tanh, or state the jump \
         as a contact"
    )]
    JumpWithoutEdge {
        /// The time reached.
        t: f64,
        /// Index of the acceleration, from 0.
        acceleration: usize,
    },
    /// The start lies beyond a rigid stop, or a stop jumped past its contact at a drive edge.
    #[error(
        "contact {contact} lies {depth:.3e} beyond its rigid stop at t = {t:?}: give a start with the contact in its gap"
    )]
    BeyondStop {
        /// Time of the check.
        t: f64,
        /// Index of the contact, from 0.
        contact: usize,
        /// Distance beyond the stop, in the unit of the deflection.
        depth: f64,
    },
    /// Impacts follow one another at one instant without end: stops that move towards one another, or very
    /// unequal elastic bodies that touch.
    #[error(
        "too many impacts at one instant, t = {t:?}: more than {limit}, the last on the rigid stop of contact \
         {contact}"
    )]
    TooManyImpacts {
        /// The instant.
        t: f64,
        /// Index of the contact of the last impact, from 0.
        contact: usize,
        /// The most impacts that are allowed.
        limit: usize,
    },
    /// Two contacts strike their rigid stops at one instant and the motion afterwards depends on which one
    /// strikes first. Neighbours of the motion take either order: the flow has no derivative.
    #[error(
        "contacts {contact} and {other} strike their rigid stops at one instant, t = {t:?}, and the motion \
         depends on which one strikes first: the flow has no derivative there"
    )]
    SimultaneousImpacts {
        /// The instant.
        t: f64,
        /// Index of one contact, from 0.
        contact: usize,
        /// Index of the other contact.
        other: usize,
    },
    /// The model has a rigid stop, but the run does not locate edges.
    #[error(
        "contact {contact} has a rigid stop: it requires a solver that locates edges, such as LaneTaylor or Located"
    )]
    StopNotLocated {
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// The absolute tolerance exceeds all motion until a contact meets an edge: steps do not resolve it.
    #[error(
        "the absolute tolerance atol = {atol:e} exceeds the motion, which is of the order of {motion:e} when \
         contact {contact} meets its edge at t = {t:?}: lower atol below the lengths of the model"
    )]
    BelowTolerance {
        /// Time at which it meets its edge.
        t: f64,
        /// Index of the contact, from 0.
        contact: usize,
        /// The smallest absolute tolerance of a coordinate.
        atol: f64,
        /// The largest of the width of the gap and the coordinates.
        motion: f64,
    },
    /// Both rigid stops of a contact lie at one place.
    #[error(
        "both rigid stops of contact {contact} lie at one place at t = {t:?}: no room for motion is left between \
         them; give the gap a width, or join the bodies"
    )]
    NoRoomBetweenStops {
        /// Time at which the contact meets a stop.
        t: f64,
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// A contact crosses its edges repeatedly while the time does not advance, or the location of an edge
    /// does not converge. The usual cause is a motion that slides along the edge or sticks to it: the
    /// accelerations on both sides push it back.
    #[error(
        "contact {contact} stalls on its edge at t = {t:?}: it slides along the edge (the accelerations on both \
         sides push it back, which is not modelled), or the location of the edge does not converge"
    )]
    EdgeStall {
        /// Time of the stall.
        t: f64,
        /// Index of the contact, from 0.
        contact: usize,
    },
}
