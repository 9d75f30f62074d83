//! Gear trains from bodies, shafts, bearings, meshes and torques.
//!
//! [`Parts`] collects a train and builds it: [`Body`], [`Bearing`], [`ShaftPart`] and [`MeshPart`] are its
//! parts, a [`Train`] the model. [`SpurPair`] and [`Planetary`] are ready, as are [`idler`], [`two_stage`],
//! [`split_torque`], [`geared_rotor`] and [`robot_joint`]. Speeds and phases of meshes follow from tooth
//! numbers. [`Coordinates`] chooses whether the common rotation is a coordinate, a [`Drawing`] shows the
//! train. The guide has pages on [parts](crate::guide::trains) and on [ready
//! trains](crate::guide::ready_trains).

pub(crate) mod assembly;
pub(crate) mod kinds;
pub(crate) mod parts;
pub(crate) mod plan;
pub(crate) mod ready;
pub(crate) mod shape;
pub(crate) mod train_error;

pub use crate::trains::kinds::ModeKind;
pub use crate::trains::parts::body::{Bearing, Body};
pub use crate::trains::parts::characteristic::InductionMotor;
pub use crate::trains::parts::collection::Parts;
pub use crate::trains::parts::coordinates::Coordinates;
pub use crate::trains::parts::mesh_part::{MeshPart, OfMesh};
pub use crate::trains::parts::shaft_part::ShaftPart;
pub use crate::trains::ready::chains::{geared_rotor, idler, robot_joint, split_torque, two_stage};
pub use crate::trains::ready::nfg::nfg_parts;
pub use crate::trains::ready::planetary::{Members, Planetary};
pub use crate::trains::ready::ring::ring_parts;
pub use crate::trains::ready::spur_pair::{Dimensionless, SpurPair};
pub use crate::trains::shape::drawing::{Drawing, DrawnBody, DrawnLink};
pub use crate::trains::shape::train_shape::{Train, TrainShape};
pub use crate::trains::train_error::{TrainError, Warning};
