//! Basins of attraction: where a pair with a dead zone ends, start by start, where two motions live side by side.
//!
//! `cargo run --release --example basins`

mod support;

use gear_dynamics::*;
use std::f64::consts::TAU;
use support::{Csv, Map, Outcome, gallery, maps};

/// x'' + 0.1 x' + g(x) = 0.25 + 0.25 cos(Ω t), g the dead zone of half width 1: a spur pair under a pulsating torque. Below its resonance
/// a motion in contact and a rattling one live side by side.
struct SpurPair {
    omega: f64,
    law: Backlash,
}

impl Generic for SpurPair {
    #[inline(always)]
    fn accel_on<S: Scalar, L: Law<S>>(&self, law: &L, u: &[S], q: &[S], v: &[S], a: &mut [S]) {
        let b = S::from(self.law.half_width());
        a[0] = u[0] - v[0] * 0.1 - law.force(0, &self.law, q[0], v[0], -b, b);
    }
    fn phases(&self) -> usize {
        1
    }
    fn phase_drives(&self, phase: f64, _: Side, u: &mut [f64]) {
        u[0] = 0.25 + 0.25 * libm::cos(phase);
    }
    fn constants(&self, _: &mut [f64]) {}
    fn shares_lanes_with(&self, other: &Self) -> bool {
        self.law.same_as(&other.law)
    }
}

impl Model for SpurPair {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.accel_on(&AsIs, u, q, v, a);
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.phase_drives(self.omega * t, side, u);
    }
}

impl Periodic for SpurPair {
    fn period(&self) -> f64 {
        TAU / self.omega
    }
}

fn main() -> Outcome<()> {
    const SIDE: usize = 200;
    let folder = gallery("basins")?;
    let mut csv = Csv::new(folder.join("basins.csv"), "omega,attractor,period,q,v,share")?;
    let mut pictures = Vec::new();
    for omega in [0.66, 0.69, 0.72, 0.75] {
        let starts = Points::grid(vec![Axis::linear("q", -4.0, 4.0, SIDE)?, Axis::linear("v", -4.0, 4.0, SIDE)?])?;
        let rows = Sweep::over(starts).settle(100).measure(20).strobe(16).run(
            &LaneRk4::<16>::new(256),
            |_| Ok::<_, ParameterError>(SpurPair { omega, law: Backlash::new(1.0)? }),
            |p, _| Ok::<_, ParameterError>(State::new(0.0, &[p["q"]], &[p["v"]])),
        )?;
        let attractors = Attractors::of(&rows, 1e-4)?;
        println!("Ω = {omega}: {} motions", attractors.list().len());
        for (i, one) in attractors.list().iter().enumerate() {
            let share = one.rows as f64 / (SIDE * SIDE) as f64;
            let period = one.period.map_or("none".into(), |p| p.to_string());
            let state = one.states.first().cloned().unwrap_or_else(|| vec![f64::NAN; 2]);
            println!("  {i}: period {period:4} at q = {:8.5}, v = {:8.5}, from {:5.1}% of the starts", state[0], state[1], 100.0 * share);
            csv.row(&[&omega, &i, &period, &state[0], &state[1], &share])?;
        }
        let labels = (0..SIDE * SIDE).map(|i| attractors.label(i).map_or(f64::NAN, |label| label as f64)).collect();
        let title = format!("Ω = {omega}: the motion reached, by start");
        pictures.push(Map { title, across: ("q(0)", -4.0, 4.0), up: ("v(0)", -4.0, 4.0), columns: SIDE, values: labels });
    }
    maps(folder.join("basins.svg"), &pictures)?;
    println!("pictures and tables: {}", folder.display());
    Ok(())
}
