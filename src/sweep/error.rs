//! What may go wrong in a sweep, as a whole and at one point.

use crate::error::ParameterError;
use crate::ode::error::IntegrateError;
use crate::periodic::lyapunov::exponents::LyapunovError;
use crate::sweep::lanes::drive_table::TableError;
use thiserror::Error;

/// Why a sweep as a whole cannot be run.
///
/// ```
/// use gear_dynamics::sweep::SweepError;
/// let error = SweepError::Setting { name: "measure", value: 0.0, allowed: "at least 1 period" };
/// assert_eq!(error.to_string(), "measure is 0: it must be at least 1 period");
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SweepError {
    /// A setting that cannot be used.
    #[error("{name} is {value}: it must be {allowed}")]
    Setting {
        /// Which one.
        name: &'static str,
        /// What it was.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A parameter, a channel name or a range that cannot be used.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// No table with this number of steps.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A channel that this engine does not measure.
    #[error(
        "the engine does not measure channel \"{name}\": it knows coordinates, velocities, deflections and mesh forces"
    )]
    Channel {
        /// Which one.
        name: String,
    },
    /// A chunk that is not there.
    #[error("chunk {chunk} of {chunks} does not exist: chunks count from 0")]
    Chunk {
        /// Which one.
        chunk: usize,
        /// How many there are.
        chunks: usize,
    },
    /// Bytes that are not rows of this sweep.
    #[error("the bytes are not rows of this sweep, or cut off: at byte {at}")]
    Bytes {
        /// The first place that does not fit.
        at: usize,
    },
    /// Parts that do not make a whole.
    #[error("the parts do not fit together at row {row}: it is missing, there twice, or of another sweep")]
    Parts {
        /// The first row that does not fit.
        row: usize,
    },
}

/// Why one point of a sweep has no answer; the others stand.
///
/// ```
/// use gear_dynamics::sweep::PointError;
/// assert_eq!(PointError::Diverged { period: 3 }.to_string(), "the motion is not finite any more in period 3");
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PointError {
    /// The family gave no model or no start.
    #[error("no model: {0}")]
    Model(String),
    /// A start that does not fit.
    #[error("start: {0}")]
    Start(ParameterError),
    /// A figure that was asked for is not a number, while the motion is.
    #[error("figures of the run: {0}")]
    Figure(ParameterError),
    /// A period that is not positive and finite.
    #[error("the period of the model is {period}: it must be positive and finite")]
    Period {
        /// What it was.
        period: f64,
    },
    /// No table of its drives.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The integration ended early.
    #[error(transparent)]
    Integrate(#[from] IntegrateError),
    /// No Lyapunov exponent: found among [`Rows::exponent_errors`](crate::sweep::Rows::exponent_errors), since the other figures of the point stand. The
    /// exponents over the periods that succeeded are in the error.
    #[error("Lyapunov exponent: {0}")]
    Lyapunov(#[from] LyapunovError),
    /// The motion grew beyond all bounds.
    #[error("the motion is not finite any more in period {period}")]
    Diverged {
        /// When, counted from 1.
        period: usize,
    },
    /// A model with another number of degrees of freedom or contacts than the first one.
    #[error("the model has {found:?} degrees of freedom and contacts, the first one {expected:?}")]
    Shape {
        /// Degrees of freedom and contacts of this one.
        found: [usize; 2],
        /// Of the first one.
        expected: [usize; 2],
    },
    /// No row and no error yet.
    #[error("point {index} has no row: it was not run yet, or it belongs to another chunk")]
    NotReached {
        /// Which point of the sweep.
        index: usize,
    },
    /// An error read back from bytes.
    #[error("{0}")]
    Told(String),
}
