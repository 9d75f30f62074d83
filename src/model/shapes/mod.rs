//! Shapes and machines: a model written once for all number types, with named constants.

pub(crate) mod checks;
pub(crate) mod compiled;
pub(crate) mod constants;
pub(crate) mod dual_jacobian;
pub(crate) mod enclosed;
pub(crate) mod laws;
pub(crate) mod machine;
pub(crate) mod machine_tape;
pub(crate) mod shape;
pub(crate) mod terms;
pub(crate) mod waves;
