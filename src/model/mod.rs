//! Models: the equations of motion q'' = a(t, q, q').
//!
//! [`Model`] is the trait that all solvers take, [`Periodic`] adds the period. [`from_fn`] makes a model from
//! one formula. A [`Shape`] is an algebra for all number types ([`Scalar`]); with named constants it is a
//! [`Machine`], which gives Jacobians, series and lanes. [`Offers`] lists what a model can do beyond the
//! trait. A [`State`] is a time with coordinates and velocities. The [guide page](crate::guide::own_model)
//! has an example.

pub(crate) mod channel;
pub(crate) mod drive_slope;
pub(crate) mod equations;
pub(crate) mod expansion;
pub(crate) mod formula;
pub(crate) mod jacobian;
pub(crate) mod laws;
pub(crate) mod period;
pub(crate) mod reference;
pub(crate) mod shapes;
pub(crate) mod state;
pub(crate) mod structure;
pub(crate) mod terms;

pub use crate::dual::Dual;
pub use crate::model::channel::Channel;
pub use crate::model::equations::{Model, Offers, Periodic};
pub use crate::model::formula::{Formula, from_fn};
pub use crate::model::jacobian::Jacobian;
pub use crate::model::shapes::machine::Machine;
pub use crate::model::shapes::shape::{Drives, Shape, Size};
pub use crate::model::state::State;
pub use crate::scalar::{Scalar, keep_rolled};
pub use crate::series::{PowerSeries, Series};

/// What a machine knows about its algebra beyond its values: a tape of it, named constants, the terms of
/// its equations, the values of its contact laws. A model of your own needs none of it, unless
/// [`Taylor`](crate::Taylor) shall run it without a [`Shape`].
pub mod recording {
    pub use crate::model::drive_slope::DriveSlope;
    pub use crate::model::equations::Constants;
    pub use crate::model::expansion::every_piece::EveryPiece;
    pub use crate::model::expansion::expand::{Enclosed, Expand, Recorded};
    pub use crate::model::laws::Laws;
    pub use crate::model::terms::{Terms, TermsScratch};
    pub use crate::tape::node::Node;
}
