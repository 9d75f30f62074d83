//! Taylor series against DOP853 at equal error, on workloads A, B3 and B16; shooting and Lyapunov exponents by
//! both; time for a step of rings of many gears.

use crate::common::{Pair, RING_END, ring_with_load};
use crate::ring::least_times;
use gear_dynamics::ode::Step;
use gear_dynamics::periodic::FlowMethod;
use gear_dynamics::{
    Dop853, Integrator, Lyapunov, Model, NfgPair, NfgParams, Settle, Shooting, State, Taylor,
};
use std::ops::ControlFlow;

/// Error at which the times are compared.
const ERROR: f64 = 1e-9;

/// End of a run and its number of steps.
fn run<I: Integrator, M: Model>(solver: &I, model: &M, start: &State, end: f64) -> (State, u64) {
    let finish = solver
        .run(model, start, end, &mut |_: &mut Step<'_>| ControlFlow::Continue(()))
        .expect("the workload runs");
    (finish.state, finish.stats.steps)
}

/// Relative tolerances, the coarsest first, in steps of √10. The absolute ones are 1e-4 of them.
fn tolerances() -> impl Iterator<Item = (f64, f64)> {
    (10..=26).map(|k| 10f64.powf(-0.5 * f64::from(k))).map(|rtol| (rtol, 1e-4 * rtol))
}

/// Prints the ratio of the times of DOP853 and Taylor at an error of at most 1e-9, and a table of both.
fn compare<D: Model, T: Model>(
    name: &str,
    models: (&D, &T),
    start: &State,
    end: f64,
    error: impl Fn(&State, &State) -> f64,
) {
    let (plain, machine) = models;
    let truth = run(&Dop853::new().rtol(1e-13).atol(1e-18), plain, start, end).0;
    let dop853 = |(rtol, atol): (f64, f64)| Dop853::new().rtol(rtol).atol(atol);
    let taylor = |(rtol, atol): (f64, f64)| Taylor::new().rtol(rtol).atol(atol);
    let error_of = |state: State| error(&state, &truth);
    println!("\n{name}: least time of 5, error at the end");
    for wanted in [1e-6, ERROR, 1e-11] {
        let first = |error: &dyn Fn((f64, f64)) -> f64| tolerances().find(|t| error(*t) <= wanted);
        let Some(of_dop853) = first(&|t| error_of(run(&dop853(t), plain, start, end).0)) else { continue };
        let Some(of_taylor) = first(&|t| error_of(run(&taylor(t), machine, start, end).0)) else { continue };
        let (by_dop853, by_taylor) = (dop853(of_dop853), taylor(of_taylor));
        let times = least_times(
            5,
            &[&|| usize::from(run(&by_dop853, plain, start, end).1 > 0), &|| {
                usize::from(run(&by_taylor, machine, start, end).1 > 0)
            }],
        );
        let errors =
            [run(&by_dop853, plain, start, end).0, run(&by_taylor, machine, start, end).0].map(error_of);
        println!(
            "error {wanted:.0e}: DOP853 rtol {:.0e} {:.2} ms {:.1e}, Taylor rtol {:.0e} {:.2} ms {:.1e}",
            of_dop853.0,
            1e3 * times[0],
            errors[0],
            of_taylor.0,
            1e3 * times[1],
            errors[1],
        );
        if wanted == ERROR {
            println!("ratio {name} taylor dop853 {:.3}", times[0] / times[1]);
        }
    }
}

/// The three workloads (A with its drives by formulas for DOP853, then with the same waves for both), shooting and exponents, then rings of many gears.
pub fn ratios() {
    let pair = Pair::new();
    let of_pair = |a: &State, b: &State| (a.q[0] - b.q[0]).abs() / 1e-5;
    let machine = pair.machine_of_waves();
    compare("A", (&pair, &machine), &Pair::start(), pair.end(), of_pair);
    compare("A-as-shape", (&machine, &machine), &Pair::start(), pair.end(), of_pair);
    let of_ring = |a: &State, b: &State| {
        let largest = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        (largest(&a.q, &b.q) / 1e-4).max(largest(&a.v, &b.v))
    };
    for (name, gears) in [("B3", 3), ("B16", 16)] {
        let ring = ring_with_load(gears, 0.01, 20.0);
        compare(name, (&ring, &ring), &State::at_rest(ring.dof()), RING_END, of_ring);
    }
    orbits();
    for gears in [16, 64, 256, 1024] {
        let ring = ring_with_load(gears, 0.01, 20.0);
        let (start, end) = (State::at_rest(ring.dof()), RING_END * 0.01);
        let steps = run(&Taylor::new(), &ring, &start, end).1;
        // The times are those of one step.
        let per_step = least_times(3, &[&|| run(&Taylor::new(), &ring, &start, end).1 as usize])[0];
        println!("ring of {gears}: {:.3} μs a step and mesh, {steps} steps", 1e6 * per_step / gears as f64);
    }
}

/// Shooting with multipliers (16 segments) and Lyapunov exponents of the pair at 180 rad/s, by both methods.
fn orbits() {
    let pair =
        NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() }).expect("the speed is positive");
    let start = pair.on_drive_flank().expect("the load is in range");
    let settled = Settle::new().run(&Dop853::new(), &pair, &start).expect("the motion settles");
    let multiple = settled.period_multiple;
    let shoot = |method: FlowMethod| {
        let shooting = Shooting::new().period_multiple(multiple).segments(16).flow_method(method);
        usize::from(shooting.solve(&pair, &settled.state).is_ok())
    };
    let exponents = |method: FlowMethod| {
        let lyapunov = Lyapunov::new().settle(0).measure(1000).flow_method(method);
        usize::from(lyapunov.run(&pair, &settled.state).is_ok())
    };
    let [dop853, taylor] = [FlowMethod::Dop853, FlowMethod::Taylor];
    let times = least_times(5, &[&|| shoot(dop853), &|| shoot(taylor)]);
    println!("\nshooting, 16 segments: DOP853 {:.1} ms, Taylor {:.1} ms", 1e3 * times[0], 1e3 * times[1]);
    println!("ratio shooting taylor dop853 {:.3}", times[0] / times[1]);
    let times = least_times(1, &[&|| exponents(dop853), &|| exponents(taylor)]);
    println!("exponents, 1000 turns: DOP853 {:.2} s, Taylor {:.2} s", times[0], times[1]);
    println!("ratio exponents taylor dop853 {:.3}", times[0] / times[1]);
}
