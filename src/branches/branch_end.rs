//! Why a branch ends.

use crate::branches::curve::equations::CurveError;
use crate::error::ParameterError;
use crate::ode::Exhausted;
use std::fmt;

/// Why a branch ends.
///
/// ```
/// use gear_dynamics::branches::BranchEnd;
/// assert_eq!(BranchEnd::Bound.to_string(), "a bound of the parameter is reached");
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum BranchEnd {
    /// The branch is still being followed.
    #[default]
    Open,
    /// A bound of the parameter is reached. The last point lies on it.
    Bound,
    /// The branch is closed: its last step passes the first point.
    Closed,
    /// The last point grazes a rigid stop: on one side of it the orbits strike the stop, on the other side
    /// they do not.
    Stop {
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// The boundary approaches a resonant grazing, at which an impact has no speed: at the last point the
    /// squared speed of the impact is below 1e-6 of the largest squared rate of the contact.
    SoftImpact {
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// The motion exceeds the limit of
    /// [`Continuation::max_motion`](crate::branches::Continuation::max_motion). The branch runs to infinity:
    /// at the border of parametric instability no periodic motion is bounded.
    Unbounded {
        /// Size of the motion at the last point, as a multiple of the reference of
        /// [`max_motion`](crate::branches::Continuation::max_motion) `[1]`.
        motion: f64,
        /// The parameter of the border. A large motion is that of the system without gaps, and at the border
        /// this linear system has a multiplier 1 over the period of the orbit (1 or -1 over that of the
        /// model). A boundary ends at the nearest border for the other parameter of its last point. If there
        /// is none, it ends at the tip of an instability tongue beside that point. `None` if the system
        /// without gaps is not linear, if its flanks differ or there is only one, if an edge is a rigid stop,
        /// or if the last points do not tend to such a border.
        border: Option<f64>,
    },
    /// The maximum number of points is reached.
    Points {
        /// The maximum.
        limit: usize,
    },
    /// The step became too short.
    StepUnderflow {
        /// The last step `[1]`.
        step: f64,
        /// Why the step to the next point failed.
        error: CurveError,
    },
    /// There is no model beyond the last point.
    Model {
        /// The first parameter that failed.
        parameter: f64,
        /// The reason.
        error: ParameterError,
    },
    /// A limit of the budget is reached.
    Exhausted(Exhausted),
    /// The branch was read from a file, in which an error or a limit is stored as its text.
    Stored {
        /// The text.
        reason: String,
    },
}

impl fmt::Display for BranchEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BranchEnd::Open => f.write_str("open"),
            BranchEnd::Bound => f.write_str("a bound of the parameter is reached"),
            BranchEnd::Closed => f.write_str("the branch is closed"),
            BranchEnd::Stop { contact } => write!(f, "contact {contact} grazes its rigid stop"),
            BranchEnd::SoftImpact { contact } => {
                write!(f, "the impacts of contact {contact} are too soft: a resonant grazing follows")
            }
            BranchEnd::Unbounded { border: Some(border), .. } => {
                f.write_str(
                    "the motion grows without bound towards the border of parametric instability at ",
                )?;
                border.fmt(f)
            }
            BranchEnd::Unbounded { motion, border: None } => {
                write!(f, "the motion exceeds its limit: it is {motion:.0} times the reference of max_motion")
            }
            BranchEnd::Points { limit } => write!(f, "the maximum of {limit} points is reached"),
            BranchEnd::StepUnderflow { step, error } => {
                write!(f, "the step became too short ({step:e}): {error}")
            }
            BranchEnd::Model { parameter, error } => {
                write!(f, "there is no model with the parameter {parameter}: {error}")
            }
            BranchEnd::Exhausted(exhausted) => exhausted.fmt(f),
            BranchEnd::Stored { reason } => f.write_str(reason),
        }
    }
}
