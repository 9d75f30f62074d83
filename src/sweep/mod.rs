//! Sweeps and ensembles: many runs of one family of models.
//!
//! A [`Sweep`] runs one model at each of its [`Points`] and reduces each run to a [`Row`]. Its engine is
//! [`LaneRk4`] for a first map, [`LaneTaylor`] for an accurate one, [`TableRk4`] for any periodic model
//! with fixed steps, [`Located`] for any solver,
//! [`ByPeriods`] for an engine of one's own. [`Bifurcation`] draws a diagram, [`Attractors`] sorts the
//! rows of many starts. An [`Ensemble`] runs random models, [`RandomParameters`] gives tolerances and Sobol
//! indices. The [guide page](crate::guide::sweeps) shows each.

pub(crate) mod engines;
pub(crate) mod ensembles;
pub(crate) mod lanes;
pub(crate) mod readings;
pub(crate) mod rows;
pub(crate) mod schedule;
pub(crate) mod settings;
pub(crate) mod sweep_error;
pub(crate) mod taylor;
pub(crate) mod watch;

pub use crate::sweep::engines::lane_rk4::LaneRk4;
pub use crate::sweep::engines::located::Located;
pub use crate::sweep::engines::periods::{ByPeriods, EnginePeriod, PeriodEngine};
pub use crate::sweep::engines::table_rk4::TableRk4;
pub use crate::sweep::ensembles::bands::{Bands, FailedMember, MeanAfter};
pub use crate::sweep::ensembles::confidence::Proportion;
pub use crate::sweep::ensembles::distribution::{Distribution, HistogramSpan};
pub use crate::sweep::ensembles::members::{Ensemble, EnsembleError};
pub use crate::sweep::ensembles::sobol::{RandomParameters, SobolDesign, SobolIndex};
pub use crate::sweep::lanes::drive_table::TableError;
pub use crate::sweep::lanes::instructions::InstructionSet;
pub use crate::sweep::readings::basins::{Attractor, Attractors};
pub use crate::sweep::readings::bifurcation::{Bifurcation, Diagram, DiagramPoint};
pub use crate::sweep::rows::collection::Rows;
pub use crate::sweep::rows::merge::RowsError;
pub use crate::sweep::rows::row::Row;
pub use crate::sweep::schedule::runner::Runner;
pub use crate::sweep::settings::points::{Axis, Point, Points};
pub use crate::sweep::settings::sweep::{Sweep, WarmStart};
pub use crate::sweep::sweep_error::{FamilyError, PointError, SweepError};
pub use crate::sweep::taylor::lane_taylor::LaneTaylor;
pub use crate::sweep::watch::Watch;

/// Names in the bounds of the interface. A program names them only where it is generic over engines or over
/// functions that return a start, or runs a shape on the numbers of several lanes.
pub mod bounds {
    pub use crate::sweep::engines::sweep_engine::SweepEngine;
    pub use crate::sweep::lanes::number::Lanes;
    pub use crate::sweep::schedule::start::IntoStart;
}
