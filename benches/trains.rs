//! Gear trains from parts beside the ring: cost of the general algebra, and planetary maps in lanes.
//!
//! `cargo bench --bench trains` prints the ratios that docs/trains.md and CHANGELOG.md state.

mod common;

use common::{ratio, ring};
use gear_dynamics::excitation::Side;
use gear_dynamics::sweep::{Axis, InstructionSet, LaneRk4, Points, SweepEngine};
use gear_dynamics::trains::{Train, Warning, ring_parts};
use gear_dynamics::{Model, ParameterError, Periodic, State, Sweep};
use std::hint::black_box;

/// A ring of n gears by its constructor and from parts.
fn rings(gears: usize) -> (gear_dynamics::Ring, Train) {
    let params = common::ring_params(gears, 1.5e-3, 2.0);
    let mut parts = ring_parts(&params, 20).expect("all gears are equal");
    let train = parts.accept(Warning::Unbalanced).build("gear 1", params.omega / 20.0).expect("it is a ring");
    (ring(gears, 2.0), train)
}

/// Evaluates the accelerations `count` times in states that change.
fn evaluate<M: Model>(model: &M, count: usize) {
    let n = model.dof();
    let (mut u, mut a) = (vec![0.0; model.drives()], vec![0.0; n]);
    model.drive(1e-4, Side::After, &mut u);
    let mut q: Vec<f64> = (0..n).map(|i| 1e-5 * (i as f64 * 0.618).fract()).collect();
    let v = vec![1e-3; n];
    for _ in 0..count {
        model.accel(&u, black_box(&q), &v, &mut a);
        q[0] += 1e-20 * a[0];
    }
    black_box(q);
}

/// Runs 64 speeds in lanes.
fn lanes<M: Periodic + Sync>(sample: &M, with: impl Fn(f64) -> Result<M, ParameterError> + Sync)
where
    LaneRk4<8>: SweepEngine<M>,
{
    let torques = Axis::linear("torque", 40.0, 50.0, 64).expect("the range is in order");
    let rows = Sweep::new(Points::on_axis(torques))
        .settle(0)
        .measure(20)
        .channels(&["deflection 1"])
        .run(
            &LaneRk4::<8>::new(64).instructions(InstructionSet::Best),
            |p| with(p["torque"]),
            |_, model| Ok::<_, ParameterError>(State::at_rest(model.dof())),
        )
        .expect("the ring runs");
    black_box((rows, sample.dof()));
}

fn main() {
    let mut each = [0.0; 2];
    for gears in [3, 16, 1024] {
        let (ring, train) = rings(gears);
        let count = 3_000_000 / gears;
        let [median, least, most] = ratio(15, || evaluate(&train, count), || evaluate(&ring, count));
        println!("ratio train ring accel n={gears} {median:.3} ({least:.3} .. {most:.3})");
        let start = std::time::Instant::now();
        evaluate(&train, count);
        let ns = start.elapsed().as_secs_f64() * 1e9 / (count * gears) as f64;
        println!("train n={gears}: {ns:.2} ns per gear");
        each = [each[1], ns];
    }
    println!("ratio per gear 1024 over 16 {:.3}", each[1] / each[0]);
    for gears in [3, 16] {
        let (ring, train) = rings(gears);
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("threads start");
        let [median, least, most] = alone.install(|| {
            let general = || lanes(&train, |torque| train.with("motor torque", torque));
            ratio(11, general, || lanes(&ring, |torque| ring.with("motor torque", torque)))
        });
        println!("ratio train ring lanes n={gears} {median:.3} ({least:.3} .. {most:.3})");
    }
}
