//! Functions of an angle that excite a model.
//!
//! An [`Excitation`] has the period 2π and exact derivatives: [`Fourier`] is a series, [`RectangularWave`]
//! the number of pairs in contact, [`Table`] a curve through samples, [`Constant`] a number, [`Function`] a
//! closure; [`Sum`], [`Product`] and [`Scaled`] combine them. A [`Wave`] puts one on a shaft, as often a
//! turn as teeth pass, with a phase. [`InstantCentre`] is the motion of the contact of noncircular gears. A
//! [`Side`] says which value counts at a jump.

pub(crate) mod angle;
pub(crate) mod any_excitation;
pub(crate) mod earliest;
pub(crate) mod enclosed_angle;
pub(crate) mod excitation_trait;
pub(crate) mod fourier;
pub(crate) mod functions;
pub(crate) mod jet;
pub(crate) mod side;
pub(crate) mod wave;
pub(crate) mod wave_weights;

pub use crate::excitation::angle::Angle;
pub use crate::excitation::earliest::earliest;
pub use crate::excitation::enclosed_angle::EnclosedAngle;
pub use crate::excitation::excitation_trait::Excitation;
pub use crate::excitation::fourier::Fourier;
pub use crate::excitation::functions::centre::{CentreCurve, InstantCentre};
pub use crate::excitation::functions::combine::{Product, Scaled, Sum};
pub use crate::excitation::functions::constant::Constant;
pub use crate::excitation::functions::function::Function;
pub use crate::excitation::functions::rectangle::RectangularWave;
pub use crate::excitation::functions::table::Table;
pub use crate::excitation::jet::Jet;
pub use crate::excitation::side::Side;
pub use crate::excitation::wave::Wave;
