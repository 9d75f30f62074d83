//! Time of random loads, on one thread: a ring with a coloured torque over the same ring with held values, and a step of
//! white noise in a lane. `cargo bench --bench random`.

mod common;

use common::{RING_END, RING_OMEGA, ratio, ring};
use gear_dynamics::drives::Noisy;
use gear_dynamics::models::Oscillator;
use gear_dynamics::ode::Step;
use gear_dynamics::processes::{FilteredNoise, HeldProcess, OrnsteinUhlenbeck, Process};
use gear_dynamics::random::{NoisySteps, WhiteNoise};
use gear_dynamics::{Dop853, Integrator, Model, Ring, State};
use rand_distr::Uniform;
use std::f64::consts::TAU;
use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::Instant;

/// Spacing of the grids, and hold time, in seconds: 32 in a mesh period. A cell takes some two steps.
const SPACING: f64 = TAU / RING_OMEGA / 32.0;
/// Standard deviation of the motor torque [N m].
const TORQUE: f64 = 0.5;

/// B3 with a random motor torque.
fn loaded(process: &dyn Process) -> Noisy<Ring> {
    let ring = ring(3, 2.0);
    let slot = ring.slot("motor torque").expect("the ring has this constant");
    Noisy::new(ring).add(&[(slot, TORQUE)], process).expect("the ring has this slot")
}

/// Prints the time of a run under a process over that under held values of the same variance.
fn report(name: &str, process: &dyn Process) {
    let side = 3f64.sqrt();
    let values = Uniform::new(-side, side).expect("the range is in order");
    let held = HeldProcess::new(SPACING, values).expect("the hold time is positive");
    let models = [loaded(process), loaded(&held)];
    let solver = Dop853::new().rtol(1e-7).atol(1e-11);
    let run = |model: &Noisy<Ring>| {
        let start = State::at_rest(model.dof());
        let none = &mut |_: &mut Step<'_>| ControlFlow::Continue(());
        solver.run(model, &start, RING_END, none).expect("the ring runs")
    };
    let steps = models.each_ref().map(|model| run(model).stats.steps);
    let [coloured, held] = models.each_ref().map(|model| move || drop(black_box(run(model))));
    let [median, least, most] = ratio(15, coloured, held);
    println!("{name}: {} steps, {} with held values", steps[0], steps[1]);
    println!("ratio coloured held, {name} {median:.2} ({least:.2} .. {most:.2})");
}

/// Prints the time of a step of a dead zone in a bath, in one of W lanes, without the start of a run.
fn report_white<const W: usize>() {
    const STEPS: usize = 40;
    const MEMBERS: usize = 64;
    let pair = Oscillator::new(&[("speed", 1.0), ("mesh stiffness", 1.0), ("half backlash", 0.5)])
        .expect("the constants are in range");
    let bath = WhiteNoise::bath(0, 0.2, 0.2).expect("damping and intensity are positive");
    let solver = NoisySteps::new(STEPS, &[bath]).lanes::<W>();
    let time = |periods: f64| {
        let timed = (0..20).map(|_| {
            let start = Instant::now();
            drop(black_box(solver.ends(&pair, &State::at_rest(1), periods, MEMBERS).expect("the pair runs")));
            start.elapsed().as_secs_f64()
        });
        timed.fold(f64::INFINITY, f64::min)
    };
    let each = (time(300.0) - time(100.0)) / (200 * STEPS * MEMBERS) as f64;
    println!("white noise, dead zone, W = {W:2}: {:.1} ns per step and lane", 1e9 * each);
}

fn main() {
    let coloured = OrnsteinUhlenbeck::new(1.0, 10.0 * SPACING, SPACING).expect("the grid resolves it");
    report("Ornstein-Uhlenbeck", &coloured);
    let filtered = FilteredNoise::new(1.0, 0.2 / SPACING, 0.2, SPACING).expect("the grid resolves it");
    report("filtered", &filtered);
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread starts");
    one_thread.install(|| {
        report_white::<8>();
        report_white::<16>();
        report_white::<32>();
    });
}
