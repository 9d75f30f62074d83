//! Roots of nonlinear equations.

pub(crate) mod blocks;
pub(crate) mod broyden;
pub(crate) mod elimination;
pub(crate) mod factors;
pub(crate) mod matrix;
pub(crate) mod newton;
pub(crate) mod residual;
pub(crate) mod root;

pub use crate::roots::broyden::{Broyden, FirstJacobian};
pub use crate::roots::matrix::Matrix;
pub use crate::roots::newton::Newton;
pub use crate::roots::residual::{Equations, Residual};
pub use crate::roots::root::{Root, RootError};
