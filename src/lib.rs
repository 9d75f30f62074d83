//! Nonlinear gear dynamics.
/// x
pub mod analysis;
mod channel;
mod check;
mod error;
pub mod excitation;
mod held;
mod mesh;
mod model;
/// m
pub mod models;
pub mod nonlinearity;
pub mod ode;
mod scalar;

pub use analysis::*;
pub use channel::Probe;
pub use check::{Finding, check_generic, check_model, check_periodic};
pub use error::ParameterError;
pub use excitation::*;
pub use held::*;
pub use mesh::*;
pub use model::*;
pub use models::*;
pub use nonlinearity::*;
pub use ode::*;
pub use scalar::{Dual, Scalar};
