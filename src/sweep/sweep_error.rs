//! Errors of a sweep: of the sweep as a whole and of one point.

use crate::error::ParameterError;
use crate::linear::LinearError;
use crate::ode::IntegrateError;
use crate::periodic::{LyapunovError, ShootingError};
use crate::sweep::lanes::drive_table::TableError;
use std::error::Error as AnyError;
use std::fmt::{self, Display, Formatter};
use std::sync::Arc;
use thiserror::Error;

/// Errors of a [`Sweep`](crate::Sweep) as a whole.
///
/// ```
/// use gear_dynamics::sweep::SweepError;
/// let error = SweepError::Chunk { chunk: 3, chunks: 2 };
/// assert_eq!(error.to_string(), "chunk is 3: it must be below the number of chunks, 2");
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SweepError {
    /// A setting, a parameter, a channel name or a range that is not allowed.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A drive table of this number of steps is not possible.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A channel that is not available in this engine.
    #[error(
        "channel \"{name}\" is not available in this engine: allowed are coordinates, velocities, \
         deflections and mesh forces; the engine Located measures all channels"
    )]
    Channel {
        /// Name of the channel.
        name: String,
    },
    /// A chunk number that is not below the number of chunks.
    #[error("chunk is {chunk}: it must be below the number of chunks, {chunks}")]
    Chunk {
        /// The chunk number, counted from 0.
        chunk: usize,
        /// Number of chunks.
        chunks: usize,
    },
    /// Parts that do not form one sweep, or rows of another sweep.
    #[error("the parts do not form one sweep: row {row} is missing, present twice or of another sweep")]
    Parts {
        /// Index of the first such row.
        row: usize,
    },
}

/// The error of a family of models or of a start function, of any type. Two of them are equal if their texts
/// are. `Error::source` returns the source of the error that it contains.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, ParameterError, Sweep};
/// use gear_dynamics::sweep::{Axis, LaneRk4, PointError};
/// let sweep = Sweep::new(Axis::of_values("speed", &[-1.0])?);
/// let rows = sweep.of(
///     &LaneRk4::new(63 * 16),
///     |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
/// ).run()?;
/// let PointError::Model(error) = &rows.errors()[&0] else { panic!("there is no such pair") };
/// let error = error.get().downcast_ref::<ParameterError>();
/// assert!(matches!(error, Some(ParameterError::NotPositive { value: -1.0, .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct FamilyError(Arc<dyn AnyError + Send + Sync>);

impl FamilyError {
    /// The error of a family: an error of any type, or a text.
    pub fn new(error: impl Into<Box<dyn AnyError + Send + Sync>>) -> Self {
        match error.into().downcast() {
            Ok(already) => *already,
            Err(other) => FamilyError(other.into()),
        }
    }
    /// The error as it was returned.
    pub fn get(&self) -> &(dyn AnyError + Send + Sync + 'static) {
        &*self.0
    }
}

impl AnyError for FamilyError {
    fn source(&self) -> Option<&(dyn AnyError + 'static)> {
        self.0.source()
    }
}

impl Display for FamilyError {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl PartialEq for FamilyError {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_string() == other.0.to_string()
    }
}

/// Errors of one point of a sweep or one member of an ensemble. They do not affect other points or members.
///
/// ```
/// use gear_dynamics::sweep::PointError;
/// let error = PointError::Diverged { period: 3 };
/// assert_eq!(error.to_string(), "the motion becomes infinite or NaN in period 3");
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PointError {
    /// The family returned no model, or the start function no start. Contains its error.
    #[error("no model: {0}")]
    Model(FamilyError),
    /// No start was given, and the model has no static state.
    #[error("no static state to start from: {0}")]
    NoStaticState(#[from] LinearError),
    /// A start or a channel that is not allowed for the model.
    #[error(transparent)]
    Parameter(ParameterError),
    /// A requested result is infinite or NaN although the motion is finite.
    #[error("results of the run: {0}")]
    Value(ParameterError),
    /// A period that is not positive and finite.
    #[error("the period of the model is {period:?}: it must be positive and finite")]
    Period {
        /// The period, in the model's time unit.
        period: f64,
    },
    /// The drive table of the model is not possible.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The integration failed.
    #[error(transparent)]
    Integrate(#[from] IntegrateError),
    /// [`LaneTaylor`](crate::sweep::LaneTaylor) does not run the model.
    #[error("LaneTaylor has no series for {what}: use Located(Taylor::new()), or Located(Dop853::new())")]
    NotInLanes {
        /// What it has no series for.
        what: &'static str,
    },
    /// The Lyapunov exponent failed. The error contains the exponents over the periods that succeeded. It is
    /// stored in [`Rows::exponent_errors`](crate::sweep::Rows::exponent_errors), since the row of the point
    /// contains the other results.
    #[error("Lyapunov exponent: {0}")]
    Lyapunov(#[from] LyapunovError),
    /// The multipliers failed: no orbit closes near the motion. It is stored in
    /// [`Rows::exponent_errors`](crate::sweep::Rows::exponent_errors), too.
    #[error("multipliers: {0}")]
    Multipliers(#[from] ShootingError),
    /// A coordinate or a velocity exceeds 1e100 or is NaN, or a sum of a measured channel is infinite or NaN.
    #[error("the motion becomes infinite or NaN in period {period}")]
    Diverged {
        /// Number of the period, counted from 1.
        period: usize,
    },
    /// The lower edge of a gap lies above its upper edge: the backlash is negative.
    #[error(
        "contact {contact} touches both flanks at once in period {period}: its lower edge lies above its upper edge"
    )]
    NegativeGap {
        /// Index of the contact, from 0.
        contact: usize,
        /// Number of the period, counted from 1.
        period: usize,
    },
    /// An engine of one's own failed: its error.
    #[error("the engine: {0}")]
    Engine(FamilyError),
    /// A model whose number of degrees of freedom or contacts differs from that of the first model.
    #[error("the model has {found:?} degrees of freedom and contacts: the first model has {expected:?}")]
    Shape {
        /// Numbers of degrees of freedom and contacts of this model.
        found: [usize; 2],
        /// Numbers of degrees of freedom and contacts of the first model.
        expected: [usize; 2],
    },
    /// The point has neither a row nor an error.
    #[error("point {index} has no row: it was not run yet, or it belongs to another chunk")]
    NotReached {
        /// Index of the point in the sweep.
        index: usize,
    },
    /// The text of an error in rows that were stored and read.
    #[error("{0}")]
    Text(String),
}

impl PointError {
    /// The error of an engine of one's own ([`PeriodEngine`](crate::sweep::PeriodEngine)): an error of any
    /// type, or a text.
    pub fn of_engine(error: impl Into<Box<dyn AnyError + Send + Sync>>) -> Self {
        PointError::Engine(FamilyError::new(error))
    }
}
