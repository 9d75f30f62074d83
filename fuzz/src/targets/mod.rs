//! The targets: one for each part of the crate.

mod branches;
mod build;
pub mod excitations;
mod flows;
pub mod laws;
mod orbits;
mod processes;
mod random;
mod roots;
mod samples;
pub mod shapes;
pub mod sweeps;
mod teeth;
mod tori;
mod trains;

use crate::case::{Case, Run};

/// A target: its name, the number of its cases that run in a block, and the function that runs a case.
pub struct Target {
    pub name: &'static str,
    pub batch: u64,
    pub run: fn(&mut Case) -> Run,
}

const fn target(name: &'static str, batch: u64, run: fn(&mut Case) -> Run) -> Target {
    Target { name, batch, run }
}

/// All targets. A case is named by its target, so that the order may change.
pub const TARGETS: [Target; 50] = [
    target("excitation", 200, excitations::any),
    target("table", 200, excitations::tables),
    target("law", 200, laws::any),
    target("phase", 200, laws::phases),
    target("jet", 200, excitations::jets),
    target("held", 200, laws::held),
    target("processes", 200, processes::processes),
    target("geometry", 200, teeth::geometry),
    target("teeth", 50, teeth::stiffness),
    target("deviation", 200, teeth::deviations),
    target("train", 20, trains::train),
    target("summary", 100, samples::summaries),
    target("spectrum", 50, samples::spectra),
    target("density", 50, samples::densities),
    target("distribution", 100, samples::distributions),
    target("proportion", 100, samples::proportions),
    target("pair", 100, build::pair),
    target("pair2", 100, build::pair2),
    target("ring", 20, build::ring),
    target("held-model", 50, build::held),
    target("noisy", 20, random::noisy),
    target("driven", 20, shapes::driven),
    target("shape", 20, shapes::own),
    target("names", 50, shapes::names),
    target("root", 100, roots::solve),
    target("matrix", 50, roots::matrices),
    target("orders", 20, orbits::orders),
    target("points", 20, sweeps::points),
    target("sobol", 20, sweeps::sobol),
    target("run", 20, flows::runs),
    target("observer", 20, flows::observers),
    target("stop", 20, flows::stopped),
    target("settle", 5, flows::settling),
    target("torus", 5, tori::torus),
    target("circle", 5, tori::circle),
    target("varying", 5, flows::varying),
    target("check", 20, flows::checks),
    target("shooting", 5, orbits::shooting),
    target("variation", 10, orbits::variation),
    target("lyapunov", 5, orbits::lyapunov),
    target("balance", 5, orbits::balance),
    target("truncated", 5, orbits::truncated),
    target("branch", 2, branches::branch),
    target("sweep", 5, sweeps::users),
    target("lanes", 5, sweeps::lanes),
    target("bifurcation", 5, sweeps::bifurcation),
    target("ensemble", 5, sweeps::ensembles),
    target("moments", 20, random::moments),
    target("noise", 20, random::lanes),
    target("path", 2, random::path),
];
