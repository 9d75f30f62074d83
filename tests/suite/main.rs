//! The tests of the public interface, in one binary. CONTRIBUTING.md states the commands, the long tests among
//! them.
//!
//! ARCHITECTURE.md says which file guards which promise.
//!
//! Helpers: `common` (small models with known solutions), `data` (reference data of tests/data), `benchmarks`
//! (the problems of the benches).

mod analysis;
mod bad_input;
mod balance;
mod balance_error_estimates;
mod balance_refusals;
mod balance_sampling;
mod bifurcation;
mod branch_boundaries;
mod branch_impacts;
mod branch_sensitivities;
mod branches;
mod branches_beside_grazings;
mod branches_by_balance;
mod branches_to_infinity;
mod branches_within_steps;
mod cancelling_waves;
mod certificates;
mod check_findings;
mod check_own_models;
mod chunks_and_resuming;
mod closed_forms;
mod coordinate_storage;
mod densities;
mod doubled_tori;
mod edges_at_step_ends;
mod edges_beside_edges;
mod ensembles;
mod error_texts;
mod excitations;
mod exports;
mod extremes_at_jumps;
mod first_order;
mod floquet;
mod fourier_waves;
mod held_processes;
mod impact_lists;
mod impacts;
mod impacts_at_step_ends;
mod inner_kinks;
mod input_ranges;
mod intervals;
mod invariant_circles;
mod lane_exponents;
mod lane_orbits;
mod lane_sharing;
mod lane_taylor;
mod laws;
mod located_edges;
mod located_edges_hard_cases;
mod located_edges_work;
mod lyapunov;
mod mesh_phases;
mod modes;
mod noncircular;
mod pages;
mod populations;
mod printed_by_pages;
mod process_spectra;
mod processes;
mod random_densities;
mod random_moments;
mod rare_events;
mod reference_nfg;
mod reference_ring;
mod resting_on_edges;
mod results_at_edges;
mod ring_relative;
mod roots;
mod rotating_sets;
mod rows_after_errors;
mod run_ups;
mod scalar_functions;
mod setters;
mod settling;
mod shapes_and_machines;
mod shooting;
mod simultaneous_impacts;
mod solvers;
mod speed_laws;
mod static_states;
mod static_trees;
mod steep_forces;
mod stiff_models;
mod stored_mutations;
mod stored_results;
mod sweeps;
mod symmetric_trains;
mod tables;
mod taylor;
mod teeth;
mod teeth_limits;
mod tori;
mod tori_errors;
mod train_refusals;
mod trains;
mod variation;
mod variation_hard_cases;
mod white_noise;
mod wide_gaps;

#[path = "../../benches/common/mod.rs"]
mod benchmarks;
mod common;
mod data;

/// All public names of the crate.
mod api {
    pub use gear_dynamics::analysis::*;
    pub use gear_dynamics::check::*;
    pub use gear_dynamics::contact::*;
    pub use gear_dynamics::drives::rules::*;
    pub use gear_dynamics::drives::*;
    pub use gear_dynamics::excitation::*;
    pub use gear_dynamics::export::*;
    pub use gear_dynamics::model::*;
    pub use gear_dynamics::models::nfg::*;
    pub use gear_dynamics::models::ring::*;
    pub use gear_dynamics::ode::*;
    pub use gear_dynamics::periodic::*;
    pub use gear_dynamics::processes::*;
    pub use gear_dynamics::roots::*;
    pub use gear_dynamics::sweep::bounds::*;
    pub use gear_dynamics::sweep::*;
    pub use gear_dynamics::teeth::*;
    pub use gear_dynamics::tori::*;
    pub use gear_dynamics::*;
}
