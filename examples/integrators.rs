//! Error over time of computation of the four solvers, on a rattling pair (workload A of the benches) and on
//! a ring of 16 gears (workload B16).
//!
//! The error is that of the end of the run, against a run of DOP853 with the tolerance 1e-13. The table and
//! the picture show for each solver the best times; `integrators.csv` contains all of them. With `--coarse`
//! the runs are shorter.
//!
//! `cargo run --release --example integrators`; everything is written to target/gallery/integrators/.

mod support;

use gear_dynamics::contact::{Contact, Deflection, PieceChoice};
use gear_dynamics::excitation::{Angle, Fourier, Product, Side, Sum};
use gear_dynamics::model::{Channel, Drives, Scalar, Size};
use gear_dynamics::models::ring::{RingSet, Shaft};
use gear_dynamics::{
    Backlash, Dop853, Integrator, Machine, Model, ParameterError, Ring, Rk4, Rk45, Shape, State, Taylor, Wave,
};
use plotters::prelude::SeriesLabelPosition;
use std::f64::consts::TAU;
use std::time::Instant;
use support::{Csv, Mark, Outcome, Panel, coarse, csv_file, figure, gallery};

/// q'' + 0.02 q' + F(φ) f(q) = r(φ): F and r are waves of the slow angle, f is a dead zone.
#[derive(PartialEq)]
struct Rattling {
    law: Backlash,
    stiffness: Wave,
    forcing: Wave,
}

/// Half width of the dead zone.
const HALF_WIDTH: f64 = 6.2e-4;

impl Rattling {
    fn new() -> Result<Self, ParameterError> {
        let wave = |mean: f64, pairs: &[[f64; 2]]| Fourier::new(mean, pairs).map(Wave::new);
        let norm = 1.0 / (1.0 + 0.3846 * 0.3846 / 2.0);
        let (mesh, radius) = (wave(norm, &[[0.29 * norm, 0.0]])?.per_turn(63)?, wave(1.0, &[[0.3846, 0.0]])?);
        let slow = wave(-1.4e-5, &[[0.0, -5.5e-6], [0.0, 2.2e-6]])?;
        let fast = wave(0.0, &[[0.0, 6.8e-6]])?.per_turn(63)?;
        Ok(Rattling {
            law: Backlash::new(HALF_WIDTH)?,
            stiffness: Wave::new(Product::new(vec![mesh, radius.clone(), radius])),
            forcing: Wave::new(Sum::new(vec![slow, fast])),
        })
    }
}

impl Shape for Rattling {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 2, contacts: 1, constants: 1 }
    }
    fn constants(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u.copy_from_slice(&[self.stiffness.value(angle, side), self.forcing.value(angle, side)]);
    }
    #[inline(always)]
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let ([stiffness, _], b) = (u.waves(), S::from(HALF_WIDTH));
        let force =
            stiffness * law.force(i, &self.law, Deflection { x: q[0], rate: v[0], lower: -b, upper: b });
        Contact { deflection: q[0], rate: v[0], lower: -b, upper: b, force, ..Contact::default() }
    }
    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [_, forcing] = u.waves();
        a[0] = forcing - v[0] * 0.02 - self.contact(law, 0, u, q, v).force;
    }
}

/// The ring of 16 gears with balanced torques.
fn ring() -> Result<Ring, ParameterError> {
    let shaft = Shaft { stiffness: 3e5, damping: 1.0 };
    let set = RingSet {
        gear_inertia: 1.5e-3,
        load_inertia: 0.01,
        base_radius: 0.0564,
        motor_shaft: shaft,
        output_shaft: shaft,
        mesh_stiffness: 1e8,
        stiffness_harmonics: vec![0.2],
        mesh_damping: 2000.0,
        error: 1e-5,
        motor_torque: 16.0 * 20.0,
        load_torque: 20.0,
        ..RingSet::set_a(16, 1000.0)
    };
    Ring::as_printed(&set.params()?)
}

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
    fn compare(&self, csv: &mut Csv) -> Outcome<Panel> {
        println!("{}\n  {:8} {:>9} {:>10} {:>9}", self.name, "solver", "setting", "ms", "error");
        let truth = self.timed(&Dop853::new().rtol(1e-13).atol(1e-18))?.1;
        let panel = Panel::new(self.name, "log10 of the time [ms]", "error at the end")
            .decades()
            .labels_at(SeriesLabelPosition::UpperRight);
        let mut solvers: Vec<(&str, Vec<(f64, f64)>)> = Vec::new();
        let mut keep = |solver: &'static str, setting: f64, (time, end): (f64, State)| {
            let error =
                end.q.iter().zip(&truth.q).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / self.size;
            println!("  {solver:8} {setting:9.1e} {time:10.2} {error:9.1e}");
            let point = (time.log10(), error.max(1e-14).log10());
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
        Ok(solvers.into_iter().fold(panel, |panel, (name, points)| panel.with(name, Mark::Line, points)))
    }
}

fn main() -> Outcome<()> {
    let folder = gallery("integrators")?;
    let mut csv = csv_file(folder.join("integrators.csv"), "run,solver,setting,ms,error")?;
    let share = if coarse() { 0.1 } else { 1.0 };
    let speed = 0.2329 / 63.0;
    let pair = Machine::with_constants(Rattling::new()?, &[("speed", speed)])?;
    let step = TAU / 0.2329 / 64.0;
    let a = Run {
        name: "rattling pair, 20 turns",
        model: &pair,
        start: State::new(0.0, &[-6.4e-4], &[0.0]),
        end: share * 20.0 * TAU / speed,
        steps: [4.0, 2.0, 1.0, 0.25].map(|k| k * step),
        size: 1e-5,
    };
    let ring = ring()?;
    let b = Run {
        name: "ring of 16 gears, 0.2 s",
        model: &ring,
        start: State::at_rest(33),
        end: share * 0.2,
        steps: [8e-6, 4e-6, 2e-6, 5e-7],
        size: 1e-4,
    };
    let panels = [a.compare(&mut csv)?, b.compare(&mut csv)?];
    figure(folder.join("integrators.svg"), 2, &panels)?;
    println!("picture and table: {}", folder.display());
    Ok(())
}
