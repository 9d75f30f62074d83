//! The tests of the public interface, in one binary. `cargo test --test suite NAME` runs the tests whose path
//! contains NAME, for example `cargo test --test suite located_edges`. Tests that take longer than half a
//! minute are marked `#[ignore]`: `cargo test --release --test suite -- --ignored` runs them.
//!
//! | what is tested | file |
//! |---|---|
//! | **Models and their parts** | |
//! | excitations and waves: derivatives, edges, fits, comparison | `excitations` |
//! | waves that are finite Fourier series, in plain numbers | `fourier_waves` |
//! | contact laws: pieces, edges, impacts in closed form | `laws`, `excitations` |
//! | rigid stops and restitution | `impacts` |
//! | shapes, constants, machines; laws and waves of one's own | `shapes_and_machines` |
//! | numbers of the algebra: dual numbers, lanes | `scalar_functions` |
//! | geometry and stiffness of teeth, deviations | `teeth` |
//! | gear trains: classics, modes, building, refusals | `trains` |
//! | phases of meshes from teeth and places | `mesh_phases` |
//! | noncircular gears in trains | `noncircular` |
//! | equal members in relative coordinates, symmetries that break | `symmetric_trains` |
//! | held processes | `held_processes` |
//! | phase laws, runs at varying speed, waterfalls | `phase_laws` |
//! | the face gear pair of Liu 2021 against reference orbits | `reference_nfg` |
//! | the ring of Yao 2020 against reference trajectories | `reference_ring`, `ring_relative` |
//! | `check_model`, `check_periodic`: models of the crate, findings | `check_own_models`, `check_findings` |
//! | **Integration in time** | |
//! | order, dense output, tolerances, output times | `solvers` |
//! | location of edges, with a few contacts | `located_edges` |
//! | location of edges in many difficult cases | `located_edges_hard_cases` |
//! | work that located edges save | `located_edges_work` |
//! | Taylor series: algebra, contact laws, waves, refusals, derivatives | `taylor` |
//! | bits do not depend on the number of coordinates | `coordinate_storage` |
//! | **Results of a run** | |
//! | statistics, spectra, rattle, sections, settling | `analysis` |
//! | lists of impacts, rattle index | `impact_lists` |
//! | averaged spectra, decibels | `densities` |
//! | tables of results as CSV and NPY | `exports` |
//! | statistics, sections and rattle at edges and jumps | `results_at_edges` |
//! | period multiples, tolerance of settling | `settling` |
//! | **Periodic orbits and stability** | |
//! | harmonic balance | `balance` |
//! | harmonic balance: sampling, orders above the kept ones | `balance_sampling` |
//! | harmonic balance: error and its estimates (long) | `balance_error_estimates` |
//! | multiple shooting | `shooting` |
//! | branches: located points, switching, ends, storing | `branches` |
//! | branches: boundaries over two parameters | `branch_boundaries` |
//! | branches: derivatives, fits, least figures | `branch_sensitivities` |
//! | derivative of the flow, saltation matrices | `variation`, `variation_hard_cases`, `impacts` |
//! | multipliers in closed form | `floquet` |
//! | backbones, describing function, stability boundaries of stiffness waves in closed form | `closed_forms` |
//! | tori: balance in several angles; invariant circles | `tori`, `invariant_circles`, `tori_errors` |
//! | branches of the harmonic balance | `branches_by_balance` |
//! | Lyapunov exponents | `lyapunov` |
//! | Newton, Broyden, block matrices | `roots` |
//! | **Sweeps** | |
//! | engines, fingerprints, warm starts, errors of points | `sweeps` |
//! | lanes that models share | `lane_sharing`, `sweeps`, `shapes_and_machines` |
//! | chunks, cancelled and resumed sweeps, monitors | `chunks_and_resuming` |
//! | parameters, rows and orbits stored by `serde` | `stored_results` |
//! | rows and results that are kept after an error | `rows_after_errors` |
//! | bifurcation diagrams, basins of attraction | `bifurcation` |
//! | ensembles, distributions, Sobol indices | `ensembles` |
//! | **Input** | |
//! | errors for invalid input | `bad_input` |
//! | largest counts and ranges of values | `input_ranges` |
//! | **Documents** | |
//! | tables of ARCHITECTURE.md and CONTRIBUTING.md against the files | `tables` |
//!
//! Helpers: `common` (small models with known solutions), `data` (reference data of tests/data), `benchmarks`
//! (the problems of the benches).

mod analysis;
mod bad_input;
mod balance;
mod balance_error_estimates;
mod balance_sampling;
mod bifurcation;
mod branch_boundaries;
mod branch_impacts;
mod branch_sensitivities;
mod branches;
mod branches_beside_grazings;
mod branches_by_balance;
mod branches_to_infinity;
mod check_findings;
mod check_own_models;
mod chunks_and_resuming;
mod closed_forms;
mod coordinate_storage;
mod densities;
mod ensembles;
mod excitations;
mod exports;
mod floquet;
mod fourier_waves;
mod held_processes;
mod impact_lists;
mod impacts;
mod inner_kinks;
mod input_ranges;
mod invariant_circles;
mod lane_sharing;
mod laws;
mod located_edges;
mod located_edges_hard_cases;
mod located_edges_work;
mod lyapunov;
mod mesh_phases;
mod noncircular;
mod phase_laws;
mod reference_nfg;
mod reference_ring;
mod results_at_edges;
mod ring_relative;
mod roots;
mod rows_after_errors;
mod scalar_functions;
mod settling;
mod shapes_and_machines;
mod shooting;
mod solvers;
mod stored_results;
mod sweeps;
mod symmetric_trains;
mod tables;
mod taylor;
mod teeth;
mod tori;
mod tori_errors;
mod trains;
mod variation;
mod variation_hard_cases;

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
