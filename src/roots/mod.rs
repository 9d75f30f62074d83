//! Roots of nonlinear equations of one's own.
//!
//! A [`Residual`] states the equations; [`Equations`] makes one from a closure. [`Newton`] uses their
//! Jacobian; [`Broyden`] corrects a first one and needs fewer evaluations. Both are a [`RootFinder`], as are
//! methods of one's own. A [`Root`] has the history of its iteration, as has a [`RootError`].

pub(crate) mod blocks;
pub(crate) mod broyden;
pub(crate) mod elimination;
pub(crate) mod factors;
pub(crate) mod matrix;
pub(crate) mod newton;
pub(crate) mod residual;
pub(crate) mod root;
pub(crate) mod root_finder;

pub use crate::roots::broyden::{Broyden, FirstJacobian};
pub use crate::roots::matrix::Matrix;
pub use crate::roots::newton::Newton;
pub use crate::roots::residual::{Equations, Residual, differences};
pub use crate::roots::root::{Root, RootError};
pub use crate::roots::root_finder::RootFinder;
