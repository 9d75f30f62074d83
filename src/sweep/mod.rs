//! Many runs of one family, reduced on the fly.

mod engine;
mod error;
mod located;
mod points;
mod rows;
mod run;
mod tables;
mod track;

pub use engine::{Job, Source, SweepEngine};
pub use error::{PointError, SweepError};
pub use located::Located;
pub use points::{Axis, Point, Points};
pub use rows::{Row, Rows};
pub use run::{Carry, Sweep, Watch};
pub use tables::{LaneRk4, TableRk4};
pub use track::Plan;
