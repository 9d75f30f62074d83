//! Basins of attraction of a spur pair with a dead zone that has two coexisting motions.
//!
//! The table lists the motions at four frequencies, with the share of the starts that lead to each, and the
//! shares of the rattle states over the amplitude of the torque. The pictures show which motion each start
//! (q, v) reaches; `basins.csv` and `amplitudes.csv` contain the tables.
//!
//! `cargo run --release --example basins`; everything is written to target/gallery/basins/.

mod support;

use gear_dynamics::contact::{Contact, Deflection, PieceChoice};
use gear_dynamics::excitation::{Angle, Side};
use gear_dynamics::model::{Channel, Drives, Scalar, Size};
use gear_dynamics::sweep::{Attractors, Axis, LaneRk4, Points, Row};
use gear_dynamics::{Backlash, Machine, ParameterError, RattleState, Shape, State, Sweep};
use support::{Map, Outcome, csv_file, gallery, maps};

/// x'' + 0.1 x' + g(x) = 0.25 + A cos φ, φ = Ω t, g the dead zone of half width 1: a spur pair under a
/// pulsating torque. Below its resonance a small motion and a large one, which touches both flanks, coexist.
#[derive(PartialEq)]
struct SpurPair {
    law: Backlash,
}

impl Shape for SpurPair {
    #[inline(always)]
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, contacts: 1, constants: 2 }
    }
    fn constants(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1"), Channel::new("amplitude", "1")]
    }
    fn waves<A: Angle>(&self, angle: A, _: Side, u: &mut [A::Number]) {
        u[0] = angle.number().cos();
    }
    #[inline(always)]
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        _: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let b = S::from(self.law.half_width());
        Contact {
            deflection: q[0],
            rate: v[0],
            lower: -b,
            upper: b,
            force: law.force(i, &self.law, Deflection { x: q[0], rate: v[0], lower: -b, upper: b }),
            ..Contact::default()
        }
    }
    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let ([wave], [amplitude]) = (u.waves(), u.constants());
        a[0] = S::from(0.25) + amplitude * wave - v[0] * 0.1 - self.contact(law, 0, u, q, v).force;
    }
}

fn main() -> Outcome<()> {
    const SIDE: usize = 200;
    let folder = gallery("basins")?;
    let mut csv = csv_file(folder.join("basins.csv"), "omega,attractor,period,q,v,share")?;
    let mut pictures = Vec::new();
    let pair = Machine::with_constants(
        SpurPair { law: Backlash::new(1.0)? },
        &[("speed", 0.69), ("amplitude", 0.25)],
    )?;
    for omega in [0.66, 0.69, 0.72, 0.75] {
        let starts =
            Points::grid(vec![Axis::linear("q", -4.0, 4.0, SIDE)?, Axis::linear("v", -4.0, 4.0, SIDE)?])?;
        let rows = Sweep::new(starts).settle(100).measure(20).strobe(16).run(
            &LaneRk4::new(256),
            |_| pair.with("speed", omega),
            |p, _| Ok::<_, ParameterError>(State::new(0.0, &[p["q"]], &[p["v"]])),
        )?;
        let attractors = Attractors::find(&rows, 1e-4)?;
        println!("Ω = {omega}: {} motions", attractors.list().len());
        for (i, one) in attractors.list().iter().enumerate() {
            let share = one.rows as f64 / (SIDE * SIDE) as f64;
            let period = one.period.map_or("none".into(), |p| p.to_string());
            let state = one.states.first().cloned().unwrap_or_else(|| vec![f64::NAN; 2]);
            println!(
                "  {i}: period {period:4} at q = {:8.5}, v = {:8.5}, from {:5.1}% of the starts",
                state[0],
                state[1],
                100.0 * share
            );
            csv.row(&[&omega, &i, &period, &state[0], &state[1], &share])?;
        }
        let labels =
            (0..SIDE * SIDE).map(|i| attractors.label(i).map_or(f64::NAN, |label| label as f64)).collect();
        let title = format!("Ω = {omega}: the motion reached, by start");
        pictures.push(Map {
            title,
            across: ("q(0)", -4.0, 4.0),
            up: ("v(0)", -4.0, 4.0),
            columns: SIDE,
            values: labels,
        });
    }
    maps(folder.join("basins.svg"), &pictures)?;

    // The amplitude is a constant of the machine: one drive table serves all starts at all amplitudes.
    const COARSE: usize = 50;
    let amplitudes = Axis::linear("amplitude", 0.08, 0.32, 13)?;
    let axes = vec![
        amplitudes.clone(),
        Axis::linear("q", -4.0, 4.0, COARSE)?,
        Axis::linear("v", -4.0, 4.0, COARSE)?,
    ];
    let rows = Sweep::new(Points::grid(axes)?).settle(100).measure(20).rattle().run(
        &LaneRk4::new(256),
        |p| pair.with("amplitude", p["amplitude"]),
        |p, _| Ok::<_, ParameterError>(State::new(0.0, &[p["q"]], &[p["v"]])),
    )?;
    println!(
        "Ω = 0.69, {} runs, {} of them without lanes: shares of the rattle states",
        rows.iter().count(),
        rows.alone()
    );
    let mut csv = csv_file(folder.join("amplitudes.csv"), "amplitude,none,unilateral,bilateral")?;
    for amplitude in amplitudes.values() {
        let share = |state: RattleState| {
            let ends = |row: &Row<'_>| row.point()["amplitude"] == *amplitude && row.rattle_state(0) == state;
            100.0 * rows.iter().filter(ends).count() as f64 / (COARSE * COARSE) as f64
        };
        let [none, one, both] =
            [RattleState::None, RattleState::Unilateral, RattleState::Bilateral].map(share);
        println!(
            "  amplitude {amplitude:.2}: no rattle {none:5.1}%, unilateral {one:5.1}%, bilateral {both:5.1}%"
        );
        csv.row(&[amplitude, &none, &one, &both])?;
    }
    println!("pictures and tables: {}", folder.display());
    Ok(())
}
