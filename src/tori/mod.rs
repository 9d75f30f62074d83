//! Quasi-periodic motions: tori and invariant circles.
//!
//! [`TorusBalance`] finds a [`Torus`] of a model with several known base frequencies ([`QuasiPeriodic`]) as a
//! series. [`CircleShooting`] finds an [`InvariantCircle`], with contact loss or with an unknown rotation, as
//! after a Neimark-Sacker point. [`WithShafts`] adds waves of further shafts to a model; [`rotation_number`]
//! measures the rotation of a run. The [guide page](crate::guide::tori) helps to choose.

pub(crate) mod balance;
pub(crate) mod circle;
pub(crate) mod least_squares;
pub(crate) mod quasi_periodic;
pub(crate) mod with_shafts;

pub use crate::tori::balance::settings::TorusBalance;
pub use crate::tori::balance::torus::Torus;
pub use crate::tori::balance::torus_error::TorusError;
pub use crate::tori::balance::wave_vectors::WaveVectors;
pub use crate::tori::circle::circle_error::CircleError;
pub use crate::tori::circle::circle_shooting::CircleShooting;
pub use crate::tori::circle::closed_curve::ClosedCurve;
pub use crate::tori::circle::invariant_circle::InvariantCircle;
pub use crate::tori::circle::rotation::rotation_number;
pub use crate::tori::quasi_periodic::{QuasiPeriodic, QuasiPeriodicError};
pub use crate::tori::with_shafts::{ShaftDrives, WithShafts};
