//! Every example in one program, which is built in a third of the time that all of them take one by one.
//!
//! `cargo run --release -p examples --example every -- --NAME`, with `--coarse` for a short run.

#![allow(clippy::duplicate_mod, reason = "each example has its own module `support`")]

#[path = "basins.rs"]
mod basins;
#[path = "bifurcation.rs"]
mod bifurcation;
#[path = "certified.rs"]
mod certified;
#[path = "custom_model.rs"]
mod custom_model;
#[path = "frequency_response.rs"]
mod frequency_response;
#[path = "gallery.rs"]
mod gallery;
#[path = "gear_train.rs"]
mod gear_train;
#[path = "integrators.rs"]
mod integrators;
#[path = "nfg_branches.rs"]
mod nfg_branches;
#[path = "quieter_gears.rs"]
mod quieter_gears;
#[path = "random_damping.rs"]
mod random_damping;
#[path = "rattle_atlas.rs"]
mod rattle_atlas;
#[path = "rattle_boundary.rs"]
mod rattle_boundary;
#[path = "rattle_map.rs"]
mod rattle_map;
#[path = "reproduce.rs"]
mod reproduce;

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// Name and program.
type Example = (&'static str, fn() -> Outcome);

const EXAMPLES: [Example; 15] = [
    ("basins", basins::main),
    ("bifurcation", bifurcation::main),
    ("certified", certified::main),
    ("custom_model", custom_model::main),
    ("frequency_response", frequency_response::main),
    ("gallery", gallery::main),
    ("gear_train", gear_train::main),
    ("integrators", integrators::main),
    ("nfg_branches", nfg_branches::main),
    ("quieter_gears", quieter_gears::main),
    ("random_damping", random_damping::main),
    ("rattle_atlas", rattle_atlas::main),
    ("rattle_boundary", rattle_boundary::main),
    ("rattle_map", rattle_map::main),
    ("reproduce", reproduce::main),
];

fn main() -> Outcome {
    let asked = |name: &str| std::env::args().any(|arg| arg.strip_prefix("--") == Some(name));
    if let Some((_, example)) = EXAMPLES.iter().find(|(name, _)| asked(name)) {
        return example();
    }
    let names: Vec<String> = EXAMPLES.iter().map(|(name, _)| format!("--{name}")).collect();
    Err(format!("name an example: {}", names.join(", ")).into())
}
