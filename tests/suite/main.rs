//! The tests of the public interface, in one binary. `cargo test --test suite NAME` runs the tests whose path
//! contains NAME, for example `cargo test --test suite located_edges`. Tests that take longer than half a
//! minute are marked `#[ignore]`: `cargo test --release --test suite -- --ignored` runs them.
//!
//! | what is tested | file |
//! |---|---|
//! | **Models and their parts** | |
//! | excitations and waves: derivatives, edges, fits, comparison | `excitations` |
//! | contact laws: pieces, edges, impacts in closed form | `laws`, `excitations` |
//! | rigid stops and restitution | `impacts` |
//! | shapes, constants, machines; laws and waves of one's own | `machines` |
//! | numbers of the algebra: dual numbers, lanes | `scalar_functions` |
//! | held processes | `held` |
//! | phase laws, runs at varying speed, waterfalls | `phase_laws` |
//! | the face gear pair of Liu 2021 against reference orbits | `reference_nfg` |
//! | the ring of Yao 2020 against reference trajectories | `reference_ring`, `ring_relative` |
//! | `check_model`, `check_periodic`: models of the crate, findings | `consistency`, `slips` |
//! | **Integration in time** | |
//! | order, dense output, tolerances, output times | `solvers` |
//! | location of edges, with a few contacts | `located_edges` |
//! | location of edges in many difficult cases | `torture` |
//! | work that located edges save | `workloads` |
//! | bits do not depend on the number of coordinates | `storage` |
//! | **Results of a run** | |
//! | statistics, spectra, rattle, sections, settling | `analysis` |
//! | statistics, sections and rattle at edges and jumps | `read_off` |
//! | period multiples, tolerance of settling | `returns` |
//! | **Periodic orbits and stability** | |
//! | harmonic balance | `balance` |
//! | harmonic balance: sampling, orders above the kept ones | `balance_resolution` |
//! | harmonic balance: error and its estimates (long) | `balance_truth` |
//! | multiple shooting | `shooting` |
//! | derivative of the flow, saltation matrices | `variation`, `hard_flows`, `impacts` |
//! | multipliers in closed form | `floquet` |
//! | Lyapunov exponents | `lyapunov` |
//! | Newton, Broyden, block matrices | `roots` |
//! | **Sweeps** | |
//! | engines, fingerprints, warm starts, errors of points | `sweeps` |
//! | lanes that models share | `lane_sharing`, `sweeps`, `machines` |
//! | chunks, cancelled and resumed sweeps, monitors | `long_work` |
//! | parameters, rows and orbits stored by `serde` | `stored_results` |
//! | rows and results that are kept after an error | `kept_work` |
//! | bifurcation diagrams, basins of attraction | `bifurcation` |
//! | ensembles, distributions, Sobol indices | `ensembles` |
//! | **Input** | |
//! | errors for invalid input | `bad_input` |
//! | largest counts and ranges of values | `limits` |
//!
//! Helpers: `common` (small models with known solutions), `data` (reference data of tests/data), `benchmarks`
//! (the problems of the benches).

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
mod stored_results;
mod sweeps;
mod torture;
mod variation;
mod workloads;

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
    pub use gear_dynamics::model::*;
    pub use gear_dynamics::models::nfg::*;
    pub use gear_dynamics::models::ring::*;
    pub use gear_dynamics::ode::*;
    pub use gear_dynamics::periodic::*;
    pub use gear_dynamics::roots::*;
    pub use gear_dynamics::sweep::*;
    pub use gear_dynamics::*;
}
