//! Random processes as functions of time.
//!
//! A [`Process`] is a law with a seed, a member and closed-form statistics; a [`Path`] is one of its
//! functions of time. [`Noisy`](crate::drives::Noisy) adds paths to the drives of a model. Which process
//! serves which purpose: [random loads](crate::guide::random).

pub(crate) mod amplitudes;
pub(crate) mod draws;
pub(crate) mod filtered;
pub(crate) mod held;
pub(crate) mod jittered;
pub(crate) mod markov;
pub(crate) mod ornstein_uhlenbeck;
pub(crate) mod process;
pub(crate) mod shot;
pub(crate) mod spectral;

pub use crate::processes::filtered::FilteredNoise;
pub use crate::processes::held::HeldProcess;
pub use crate::processes::jittered::JitteredOrder;
pub use crate::processes::ornstein_uhlenbeck::OrnsteinUhlenbeck;
pub use crate::processes::process::{Path, Process};
pub use crate::processes::shot::ShotNoise;
pub use crate::processes::spectral::SpectralProcess;
