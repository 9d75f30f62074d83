//! Contacts of teeth.
//!
//! A [`Nonlinearity`] is the force over the deflection: [`Backlash`] for a gap, [`AsymmetricBacklash`] and
//! [`VaryingBacklash`] for others, [`PowerLaw`] for Hertzian contact, [`NoPullBacklash`] for contact that
//! never pulls, [`Damped`] for losses in contact. A [`Mesh`] joins a law, waves of stiffness and error, and
//! damping ([`ContactDamping`]). A [`Restitution`] makes an edge a rigid stop. A [`Piece`] is the part of a
//! law on one side of an edge; [`PieceChoice`] evaluates a law on the piece of the deflection or on a fixed
//! one. The [guide page](crate::guide::contact_laws) compares the laws.

pub(crate) mod deflection;
pub(crate) mod edge;
pub(crate) mod law_places;
pub(crate) mod laws;
pub(crate) mod mesh;
pub(crate) mod piece;
pub(crate) mod piece_choice;

pub(crate) mod restitution;
pub(crate) mod tooth;

pub use crate::contact::deflection::Deflection;
pub use crate::contact::laws::backlash::{AsymmetricBacklash, Backlash, VaryingBacklash};
pub use crate::contact::laws::damped::Damped;
pub use crate::contact::laws::mixed::MixedLaw;
pub use crate::contact::laws::no_pull::NoPullBacklash;
pub use crate::contact::laws::nonlinearity::{Edges, Nonlinearity};
pub use crate::contact::laws::power::PowerLaw;
pub use crate::contact::laws::smooth::{Cubic, Linear, SmoothedBacklash};
pub use crate::contact::mesh::{ContactDamping, Mesh};
pub use crate::contact::piece::Piece;
pub use crate::contact::piece_choice::{ByDeflection, FixedPieces, PieceChoice, Place};
pub use crate::contact::restitution::Restitution;
pub use crate::contact::tooth::Contact;
