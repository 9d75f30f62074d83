//! Every figure, table and conclusion of Liu 2021 and Yao 2020 whose numbers can be computed: the tables of
//! docs/reproduction.md, and pictures.
//!
//! Three columns for Liu 2021:
//!
//! - *P*: its balance, with 15 unknowns, M = 1024 samples, and the force truncated to the kept orders before it is
//!   multiplied by the stiffness;
//! - *published*: converged motions of the same equations;
//! - *exact*: converged motions of the corrected equations.
//!
//! Converged motions are orbits polished by shooting, for Figs. 8-10 after a balance with many orders. If no
//! stable orbit is found, the statistics are those of a run in time. Sweeps begin each point at the result of the
//! previous one, upwards and downwards. Yao 2020 omits some parameters: sets A and E of docs/models.md.
//!
//! `cargo run --release -p examples --example reproduce`, with `-- --only WORDS` for the parts whose names contain the
//! words; everything is written to target/gallery/reproduce/. The program compares its tables with those of
//! docs/reproduction.md and fails if one differs. A short run, `-- --coarse`, takes few points, starts, draws and turns; it
//! compares the rows that do not depend on them.

#[path = "reproduce/liu2021/mod.rs"]
mod liu2021;
#[path = "reproduce/report.rs"]
mod report;
mod support;
#[path = "reproduce/yao2020/mod.rs"]
mod yao2020;

use liu2021::{from_rest, orders, outcomes, parameters, portraits, roots, table2};
use report::Report;
use support::{Outcome, coarse};
use yao2020::{forces, ring};

pub(crate) fn main() -> Outcome<()> {
    if coarse() {
        println!(
            "a short run: few points of each figure, few random starts and draws, a tenth of the turns to settle"
        );
    }
    let mut report = Report::new("target/gallery/reproduce");
    report.part("Liu 2021, Figs. 8-10 and 13b", portraits::figures);
    report.part("Liu 2021, Table 2, Figs. 17 and 18", table2::figures);
    report.part("Liu 2021, roots of its balance", |report| {
        roots::roots(report, if coarse() { &[160.0] } else { &[140.0, 160.0, 180.0] })
    });
    report.part("Liu 2021, load limits of its balance", roots::load_limits);
    report.part("Liu 2021, two degrees of freedom", from_rest::two_degrees_of_freedom);
    report.part("Liu 2021, orders of a balance", orders::figures);
    report.part("Yao 2020, natural frequencies", ring::modes);
    report.part("Yao 2020, Figs. 5-7", ring::transmission_error);
    report.part("Yao 2020, Fig. 8", ring::spectrum);
    report.part("Yao 2020, Figs. 9 and 10", ring::over_speed);
    report.part("Yao 2020, Figs. 11-13", forces::figures);
    report.part("Liu 2021, motions from random starts", outcomes::figures);
    report.part("Liu 2021, Fig. 11 from rest", from_rest::figures);
    report.part("Liu 2021, Figs. 11-15", parameters::figures);
    report.close()
}
