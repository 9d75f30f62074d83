//! Proofs: periodic motions with tooth contacts, shown to exist.
//!
//! [`ShootingOrbit::certify`](crate::periodic::ShootingOrbit::certify) makes a [`Certificate`] in interval
//! arithmetic ([`Interval`]), or says what is [`Unproved`]. The [guide page](crate::guide::certificates) has
//! the theorem.

pub(crate) mod certificate;
pub(crate) mod chain;
pub(crate) mod contraction;
pub(crate) mod derived;
pub(crate) mod flow;
pub(crate) mod images;
pub(crate) mod multipliers;
pub(crate) mod rigid;
pub(crate) mod search;
pub(crate) mod slots;
pub(crate) mod square;
pub(crate) mod unproved;

pub use crate::certify::certificate::Certificate;
pub use crate::certify::derived::figures::{CertifiedContact, CertifiedFigures};
pub use crate::certify::derived::range::CertifiedRange;
pub use crate::certify::images::CertifiedCrossing;
pub use crate::certify::multipliers::Disc;
pub use crate::certify::unproved::Unproved;
pub use crate::interval::number::Interval;
