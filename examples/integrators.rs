//! Error over time of computation of the four solvers, on a rattling pair (workload A of the benches) and on
//! a ring of 16 gears (workload B16).
//!
//! The error is that of the end of the run, against a run of DOP853 with the tolerance 1e-13. The table and
//! the picture show for each solver the best times; `integrators.csv` contains all of them. With `--coarse`
//! the runs are shorter.
//!
//! `cargo run --release -p examples --example integrators`; everything is written to
//! target/gallery/integrators/.

#[path = "../benches/common/mod.rs"]
mod benchmarks;
mod support;

use benchmarks::{Pair, RING_END, ring_with_load};
use gear_dynamics::{Dop853, Integrator, Model, Rk4, Rk45, State, Taylor};
use gear_dynamics_plots::{Mark, Panel, Picture};
use std::time::Instant;
use support::{Csv, Outcome, coarse, csv_file, gallery};

/// One run to be compared.
struct Run<'r, M> {
    name: &'static str,
    model: &'r M,
    start: State,
    end: f64,
    /// Fixed steps of RK4.
    steps: [f64; 4],
    /// Size of a coordinate, to which errors are relative.
    size: f64,
}

impl<M: Model> Run<'_, M> {
    /// Least time of three runs [ms] and the end of the run.
    fn timed<I: Integrator>(&self, solver: &I) -> Outcome<(f64, State)> {
        let mut least = f64::INFINITY;
        let mut end = self.start.clone();
        for _ in 0..3 {
            let begun = Instant::now();
            end = solver.end(self.model, &self.start, self.end)?;
            least = least.min(1e3 * begun.elapsed().as_secs_f64());
        }
        Ok((least, end))
    }

    /// Error over time of every solver.
    fn compare(&self, csv: &mut Csv) -> Outcome<Vec<Solver>> {
        println!("{}\n  {:8} {:>9} {:>10} {:>9}", self.name, "solver", "setting", "ms", "error");
        let truth = self.timed(&Dop853::new().rtol(1e-13).atol(1e-18))?.1;
        let mut solvers: Vec<Solver> = Vec::new();
        let mut keep = |solver: &'static str, setting: f64, (time, end): (f64, State)| {
            let error =
                end.q.iter().zip(&truth.q).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / self.size;
            println!("  {solver:8} {setting:9.1e} {time:10.2} {error:9.1e}");
            let point = (time, error.max(1e-14));
            match solvers.iter_mut().find(|(name, _)| *name == solver) {
                Some((_, points)) => points.push(point),
                None => solvers.push((solver, vec![point])),
            }
            csv.row(&[&self.name, &solver, &setting, &time, &error])
        };
        for step in self.steps {
            keep("Rk4", step, self.timed(&Rk4::new(step))?)?;
        }
        for digits in [5, 7, 9, 11] {
            let rtol = 10f64.powi(-digits);
            keep("Rk45", rtol, self.timed(&Rk45::new().rtol(rtol).atol(1e-4 * rtol))?)?;
        }
        for digits in [5, 7, 8, 9, 10, 11, 12] {
            let rtol = 10f64.powi(-digits);
            keep("Dop853", rtol, self.timed(&Dop853::new().rtol(rtol).atol(1e-4 * rtol))?)?;
        }
        for digits in [5, 7, 8, 9, 10, 11, 12] {
            let rtol = 10f64.powi(-digits);
            keep("Taylor", rtol, self.timed(&Taylor::new().rtol(rtol).atol(1e-4 * rtol))?)?;
        }
        Ok(solvers)
    }
}

/// Name of a solver and its points: time [ms] and error.
type Solver = (&'static str, Vec<(f64, f64)>);

/// Both panels with the same axes, of whole decades.
fn panels(runs: [(&str, Vec<Solver>); 2]) -> Outcome<Vec<Panel>> {
    let points = || runs.iter().flat_map(|(_, solvers)| solvers).flat_map(|(_, points)| points);
    let decades = |of: fn(&(f64, f64)) -> f64| {
        let low = points().map(of).fold(f64::INFINITY, f64::min);
        let high = points().map(of).fold(0.0, f64::max);
        [10f64.powf(low.log10().floor()), 10f64.powf(high.log10().ceil())]
    };
    let ([left, right], [below, above]) = (decades(|point| point.0), decades(|point| point.1));
    let panel = |(title, solvers): &(&str, Vec<Solver>)| {
        let mut panel = Panel::new(*title, "time of computation [ms]", "relative error at the end [1]")?;
        for (name, points) in solvers {
            let end = points[points.len() - 1];
            panel = panel.series(name, Mark::Joined, points.clone())?.note(end, name)?;
        }
        let panel = panel.logarithmic_x()?.logarithmic_y()?;
        Ok(panel.x_range(left, right)?.y_range(below, above)?)
    };
    runs.iter().map(panel).collect()
}

pub(crate) fn main() -> Outcome<()> {
    let folder = gallery("integrators")?;
    let mut csv = csv_file(folder.join("integrators.csv"), "run,solver,setting,ms,error")?;
    let share = if coarse() { 0.1 } else { 1.0 };
    let pair = Pair::new();
    let machine = pair.machine_of_waves();
    let a = Run {
        name: "rattling pair, 20 turns",
        model: &machine,
        start: Pair::start(),
        end: share * pair.end(),
        steps: [4.0, 2.0, 1.0, 0.25].map(|k| k * pair.step()),
        size: 1e-5,
    };
    let ring = ring_with_load(16, 0.01, 20.0);
    let b = Run {
        name: "ring of 16 gears, 0.2 s",
        model: &ring,
        start: State::at_rest(33),
        end: share * RING_END,
        steps: [8e-6, 4e-6, 2e-6, 5e-7],
        size: 1e-4,
    };
    let panels = panels([(a.name, a.compare(&mut csv)?), (b.name, b.compare(&mut csv)?)])?;
    Picture::new(panels).columns(2).panel_size(350.0, 330.0).save(folder.join("integrators.svg"))?;
    println!("picture and table: {}", folder.display());
    Ok(())
}
