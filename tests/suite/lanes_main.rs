//! Temporary.
mod lane_taylor;
#[path = "../../benches/common/mod.rs"]
mod benchmarks;
mod common;
mod data;

/// All public names of the crate.
mod api {
    pub use gear_dynamics::analysis::*;
    pub use gear_dynamics::check::*;
    pub use gear_dynamics::contact::*;
    pub use gear_dynamics::drives::*;
    pub use gear_dynamics::excitation::*;
    pub use gear_dynamics::export::*;
    pub use gear_dynamics::model::*;
    pub use gear_dynamics::models::nfg::*;
    pub use gear_dynamics::models::ring::*;
    pub use gear_dynamics::ode::*;
    pub use gear_dynamics::periodic::*;
    pub use gear_dynamics::roots::*;
    pub use gear_dynamics::sweep::*;
    pub use gear_dynamics::teeth::*;
    pub use gear_dynamics::tori::*;
    pub use gear_dynamics::*;
}
