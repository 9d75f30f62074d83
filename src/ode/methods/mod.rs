//! The Runge-Kutta and Rosenbrock methods.

pub(crate) mod adaptive;
pub(crate) mod dop853;
pub(crate) mod rk4;
pub(crate) mod rk45;
pub(crate) mod rodas;
pub(crate) mod stepped;
