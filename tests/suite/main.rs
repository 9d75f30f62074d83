//! Everything the crate promises, in one binary: `cargo test --test suite NAME` runs the tests whose path holds NAME, as in
//! `cargo test --test suite located_edges`.

mod analysis;
mod bad_input;
mod balance;
mod balance_resolution;
mod balance_truth;
mod bifurcation;
mod consistency;
mod ensembles;
mod excitations;
mod floquet;
mod hard_flows;
mod held;
mod impacts;
mod kept_work;
mod lane_sharing;
mod laws;
mod limits;
mod located_edges;
mod long_work;
mod lyapunov;
mod machines;
mod phase_laws;
mod read_off;
mod reference_nfg;
mod reference_ring;
mod returns;
mod ring_relative;
mod roots;
mod scalar_functions;
mod shooting;
mod slips;
mod solvers;
mod storage;
mod sweeps;
mod torture;
mod variation;
mod workloads;

#[path = "../../benches/common/mod.rs"]
mod benchmarks;
mod common;
mod data;

/// All public names.
mod api {
    pub use gear_dynamics::analysis::*;
    pub use gear_dynamics::check::*;
    pub use gear_dynamics::contact::*;
    pub use gear_dynamics::drives::*;
    pub use gear_dynamics::excitation::*;
    pub use gear_dynamics::model::*;
    pub use gear_dynamics::models::nfg::*;
    pub use gear_dynamics::models::ring::*;
    pub use gear_dynamics::ode::*;
    pub use gear_dynamics::periodic::*;
    pub use gear_dynamics::roots::*;
    pub use gear_dynamics::sweep::*;
    pub use gear_dynamics::*;
}
