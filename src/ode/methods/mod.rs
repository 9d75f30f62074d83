//! The Runge-Kutta methods.

pub(crate) mod adaptive;
pub(crate) mod dop853;
pub(crate) mod rk4;
pub(crate) mod rk45;
