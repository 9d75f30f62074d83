//! Models: traits of the equations of motion, shapes and machines.

pub(crate) mod constants;
pub(crate) mod couplings;
pub(crate) mod equations;
pub(crate) mod expansion;
pub(crate) mod jacobian;
pub(crate) mod machine;
pub(crate) mod machine_constants;
pub(crate) mod offers;
pub(crate) mod rigid;
pub(crate) mod shape;
pub(crate) mod shape_checks;
pub(crate) mod slopes;
pub(crate) mod terms;

pub use crate::dual::Dual;
pub use crate::model::constants::{Constants, DriveSlope};
pub use crate::model::equations::{Channel, Jacobian, Model, Periodic, State};
pub use crate::model::expansion::every_piece::EveryPiece;
pub use crate::model::expansion::expand::{Expand, Recorded};
pub use crate::model::machine::Machine;
pub use crate::model::offers::Offers;
pub use crate::model::shape::{Drives, Shape, Size};
pub use crate::model::terms::{Terms, TermsRoom};
pub use crate::scalar::{Scalar, keep_rolled};
pub use crate::series::Series;
pub use crate::tape::node::Node;
