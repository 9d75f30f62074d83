//! Time of the harmonic balance: residual and Jacobian, whole solves and polishing, for the rattling pair, a
//! Duffing oscillator and rings. `cargo bench --bench balance`.

use criterion::{Criterion, criterion_group, criterion_main};
use gear_dynamics::contact::Piece;
use gear_dynamics::excitation::Side;
use gear_dynamics::model::{Jacobian, Offers};
use gear_dynamics::models::nfg::{NfgReading, Radius};
use gear_dynamics::models::ring::{Frame, RingSet};
use gear_dynamics::periodic::{FourierOrbit, Integrals};
use gear_dynamics::roots::{Newton, Residual, RootFinder};
use gear_dynamics::{
    Balance, Dop853, Harmonics, Integrator, Model, NfgPair, NfgParams, Periodic, Ring, Settle, Shooting,
    State,
};
use std::f64::consts::TAU;
use std::hint::black_box;

fn pair(speed: f64) -> NfgPair {
    let reading = NfgReading { radius: Radius::Base, ..NfgReading::published() };
    NfgPair::of_reading(&NfgParams { speed, ..NfgParams::table1() }, reading).expect("valid parameters")
}

fn settled(pair: &NfgPair) -> (Dop853, State) {
    let solver = Dop853::new().rtol(1e-10).atol(1e-15);
    let start = pair.on_drive_flank().expect("a load");
    let steady = Settle::new().tolerance(1e-7).run(&solver, pair, &start).expect("periodic at this speed");
    (solver, steady.state)
}

/// The pair of Liu 2021, reading A, at 180 rad/s with 252 crossings.
fn rattling_pair(c: &mut Criterion) {
    let pair = pair(180.0);
    let (solver, state) = settled(&pair);
    let project = |highest: usize| {
        FourierOrbit::project(&solver, &pair, &state, &Harmonics::up_to(highest)).expect("a settled run")
    };
    let guess = project(500);
    for integrals in [Integrals::Closed, Integrals::Kinks, Integrals::Sampled { samples: 65_536 }] {
        let mut equations =
            Balance::new(Harmonics::up_to(500)).integrals(integrals).equations(&pair, &guess).expect("fits");
        let mut x = equations.unknowns(&guess);
        let (mut r, mut matrix) = (vec![0.0; x.len()], equations.matrix());
        c.bench_function(&format!("pair, H = 500: residual and Jacobian, {integrals:?}"), |b| {
            b.iter(|| {
                x[0] *= 1.0 + f64::EPSILON; // another argument each time
                equations.residual(&x, &mut r);
                equations.jacobian(&x, &mut matrix);
            })
        });
    }
    let (balance, guess) = (Balance::new(Harmonics::up_to(1000)), project(1000));
    c.bench_function("pair, H = 1000: solve from a projected run", |b| {
        b.iter(|| balance.solve(&pair, &guess).expect("converges"))
    });
    let orbit = balance.solve(&pair, &guess).expect("converges");
    c.bench_function("pair, H = 1000: polish by shooting", |b| {
        b.iter(|| Shooting::new().solve_from(&pair, &orbit).expect("converges"))
    });
}

/// The balance of Liu 2021 with 15 unknowns, from the orbit of the linear flank.
fn fifteen_unknowns(c: &mut Criterion) {
    let pair =
        NfgPair::of_reading(&NfgParams { speed: 140.0, ..NfgParams::table1() }, NfgReading::published())
            .expect("valid");
    let balance = Balance::new(Harmonics::bands(63, 1, 2).expect("valid"))
        .integrals(Integrals::Sampled { samples: 1024 })
        .truncated_forces();
    let flank = balance.linearised(&pair, Piece::Lower).expect("regular");
    c.bench_function("pair, 15 unknowns: solve", |b| {
        b.iter(|| balance.solve(&pair, black_box(&flank)).expect("converges"))
    });
}

struct Duffing {
    omega: f64,
}

impl Model for Duffing {
    fn dof(&self) -> usize {
        1
    }
    fn drive(&self, t: f64, _: Side, u: &mut [f64]) {
        u[0] = 0.18 * (self.omega * t).cos();
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = u[0] - 0.05 * v[0] - q[0] - 0.1 * q[0] * q[0] * q[0];
    }
    fn offers(&self) -> Offers<'_> {
        Offers { jacobian: true, ..Offers::default() }
    }
    fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], q: &[f64], _: &[f64], out: &mut Jacobian) {
        (out.q[(0, 0)], out.v[(0, 0)]) = (-1.0 - 0.3 * q[0] * q[0], -0.05);
    }
}

impl Periodic for Duffing {
    fn period(&self) -> f64 {
        TAU / self.omega
    }
}

/// A point of a frequency response from its neighbour, with multipliers; H = 10 orders.
fn duffing(c: &mut Criterion) {
    let balance = Balance::new(Harmonics::up_to(10));
    let (here, next) = (Duffing { omega: 1.195 }, Duffing { omega: 1.2 });
    let guess =
        FourierOrbit::new(&Harmonics::up_to(1), here.period(), &[vec![0.0, 1.35, 2.1]]).expect("finite");
    let orbit = balance.solve(&here, &guess).expect("converges");
    c.bench_function("Duffing, H = 10: point with multipliers", |b| {
        b.iter(|| {
            let point = balance.solve(&next, black_box(&orbit)).expect("converges");
            Balance::new(point.harmonics().clone()).multipliers(&next, &point).expect("finite")
        })
    });
}

/// Rings of n gears, H = 20 orders: residual, Jacobian and factors in one Newton step. The time is nearly
/// proportional to n.
fn rings(c: &mut Criterion) {
    for gears in [8, 16, 64] {
        let params = RingSet { error: 1e-5, ..RingSet::set_a(gears, 3000.0) }.params().expect("valid");
        let (ring, moving) =
            (Ring::new(&params).expect("valid"), Ring::new(&params).expect("valid").with_frame(Frame::Rigid));
        // The guess is the end of a run that has reached every gear. On one flank throughout half of the
        // meshes would pull.
        let (solver, balance) = (Dop853::new(), Balance::new(Harmonics::up_to(20)));
        let end = solver.end(&moving, &State::at_rest(ring.dof()), 400.0 * ring.period()).expect("runs");
        let guess = FourierOrbit::project(&solver, &moving, &end, balance.harmonics()).expect("runs");
        let mut equations = balance.equations(&ring, &guess).expect("fits");
        let x = equations.unknowns(&guess);
        let step = Newton::new().max_iterations(1);
        c.bench_function(&format!("ring, n = {gears}, H = 20: one iteration"), |b| {
            b.iter(|| step.solve(&mut equations, black_box(&x)).is_ok())
        });
    }
}

criterion_group!(benches, rattling_pair, fifteen_unknowns, duffing, rings);
criterion_main!(benches);
