//! Stationary and periodic densities of one degree of freedom by path integration.

pub(crate) mod density_error;
pub(crate) mod edges;
pub(crate) mod fixed_point;
pub(crate) mod grid;
pub(crate) mod panels;
pub(crate) mod path_integration;
pub(crate) mod periodic_density;
pub(crate) mod run;
pub(crate) mod state_density;
pub(crate) mod steps;
