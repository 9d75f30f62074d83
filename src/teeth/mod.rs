//! Teeth of involute gears: geometry, mesh stiffness, deviations.
//!
//! An [`InvoluteGear`] states its teeth, a [`GearPair`] computes the geometry of two gears in mesh. The
//! results are functions of the mesh cycle: one period 2π of an [`Excitation`](crate::excitation::Excitation)
//! is the time from one pair of teeth to the next, φ = 0 the angle at which a pair enters contact.
//! [`Wave::per_turn`](crate::Wave::per_turn) with the number of teeth puts it on a shaft. All quantities are
//! in SI units. The [guide page](crate::guide::teeth) gives equations, sources and a choice of methods.

pub(crate) mod deviations;
pub(crate) mod error;
pub(crate) mod geometry;
pub(crate) mod stiffness;

pub use crate::teeth::deviations::faults::{LossShape, ToothLoss};
pub use crate::teeth::deviations::grade::{QualityGrade, Tolerances};
pub use crate::teeth::deviations::inspected::ToothDeviations;
pub use crate::teeth::deviations::relief::TipRelief;
pub use crate::teeth::deviations::transmission::TransmissionError;
pub use crate::teeth::error::TeethError;
pub use crate::teeth::geometry::blank::Blank;
pub use crate::teeth::geometry::gear::InvoluteGear;
pub use crate::teeth::geometry::pair::GearPair;
pub use crate::teeth::stiffness::iso6336::{MethodB, MethodBNote, MethodBStiffness};
pub use crate::teeth::stiffness::piecewise::Piecewise;
pub use crate::teeth::stiffness::potential::{Foundation, PairStiffness, PotentialEnergy};
pub use crate::teeth::stiffness::tooth::{Reading, RootCurve, ToothModel, ToothStiffness};
