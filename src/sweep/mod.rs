//! Many runs of one family, reduced on the fly.

mod bands;
mod basins;
mod bifurcation;
mod block;
mod bytes;
mod engine;
mod ensemble;
mod error;
mod hash;
mod located;
mod moments;
mod points;
mod row;
mod rows;
mod run;
mod sobol;
mod tables;
mod track;
mod watch;

pub use bands::Bands;
pub use basins::{Attractor, Attractors};
pub use bifurcation::{Bifurcation, Diagram, DiagramPoint};
pub use engine::SweepEngine;
pub use ensemble::{Ensemble, EnsembleError};
pub use error::{PointError, RowsError, SweepError};
pub use located::Located;
pub use moments::Distribution;
pub use points::{Axis, Point, Points};
pub use row::Row;
pub use rows::Rows;
pub use run::{Sweep, WarmStart};
pub use sobol::{RandomParameters, SobolDesign, SobolIndex};
pub use tables::{LaneRk4, TableRk4};
pub use watch::Monitor;
