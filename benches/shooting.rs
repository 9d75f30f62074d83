//! Time of multiple shooting from a guess near an orbit: `cargo bench --bench shooting`.

use criterion::{Criterion, criterion_group, criterion_main};
use gear_dynamics::models::nfg::NfgReading;
use gear_dynamics::{Dop853, NfgPair, NfgParams, Settle, Shooting, State};
use std::hint::black_box;

/// The pair of Liu 2021, reading A, at 180 rad/s: 252 crossings a turn, 63 segments. Every state of the guess
/// is off by up to 1e-3 of the range.
fn polish(c: &mut Criterion) {
    let params = NfgParams { speed: 180.0, ..NfgParams::table1() };
    let Ok(pair) = NfgPair::of_reading(&params, NfgReading::published_on_base_radius()) else { return };
    let Ok(start) = pair.on_drive_flank() else { return };
    let Ok(settled) = Settle::new().tolerance(1e-6).run(&Dop853::new(), &pair, &start) else { return };
    let Ok(cycle) = Shooting::new().segments(63).solve(&pair, &[settled.state]) else { return };
    let push =
        |i: usize, part: usize| 1e-3 * cycle.range()[part] * if i.is_multiple_of(2) { 1.0 } else { -0.7 };
    let guess: Vec<State> = (cycle.states().iter().enumerate())
        .map(|(i, s)| State::new(s.t, &[s.q[0] + push(i, 0)], &[s.v[0] + push(i / 2, 1)]))
        .collect();
    c.bench_function("polish the pair, 63 segments", |b| {
        b.iter(|| Shooting::new().solve(&pair, black_box(&guess)))
    });
    let one = &guess[..1];
    c.bench_function("the same from one state", |b| b.iter(|| Shooting::new().solve(&pair, black_box(one))));
}

criterion_group! {
    name = orbits;
    config = Criterion::default().sample_size(20);
    targets = polish
}
criterion_main!(orbits);
