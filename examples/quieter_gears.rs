//! Quieter gears: the tip relief of a spur pair and its phase for which the peak-to-peak value of the dynamic
//! transmission error is least.
//!
//! The minimum is found with exact gradients and compared with that of a grid of 10^4 points in lanes. The
//! output states both minima, their difference and both times. The pictures show the grid with the minimum,
//! and one mesh cycle without relief and with the best relief; `map.csv` and `cycle.csv` contain the numbers.
//!
//! The minimum is smooth because a part of the profile error cannot be compensated. Where relief and phase
//! can remove the first harmonic entirely, the least peak-to-peak value lies at a kink with several equal
//! maxima, and a gradient method converges slowly.
//!
//! `cargo run --release -p examples --example quieter_gears`; everything is written to
//! target/gallery/quieter_gears/.

mod support;

use gear_dynamics::branches::{Figure, Least};
use gear_dynamics::contact::{Contact, Deflection, PieceChoice};
use gear_dynamics::excitation::{Angle, Fourier, Side};
use gear_dynamics::model::{Channel, Drives, Scalar, Size};
use gear_dynamics::sweep::{Axis, LaneRk4, Point, Points, Row, Rows};
use gear_dynamics::{
    Backlash, Machine, ParameterError, Periodic, Shape, Shooting, State, Statistics, Sweep, Wave,
};
use gear_dynamics_plots::{Mark, Panel, Picture, map};
use std::f64::consts::PI;
use std::time::Instant;
use support::{Outcome, csv_file, gallery};

/// Number of harmonics of the relief.
const ORDERS: usize = 3;

/// x'' + 2 ζ δ' + k(φ) g(δ) = F with the deflection δ = x - e(φ) of the mesh and the dynamic transmission
/// error x. The time is that of the natural frequency, k is k_m over its mean, and F is the load over the mean
/// stiffness. Lengths are in μm.
///
/// Error: e(φ) = p(φ - ψ) + C Σ a_h cos h(φ - ψ) with the profile error p without relief, the tip relief C and
/// the phase ψ of the error relative to the stiffness.
#[derive(PartialEq)]
struct RelievedPair {
    stiffness: Wave,
    /// cos h φ and sin h φ.
    harmonics: [[Wave; 2]; ORDERS],
    /// a_h for a relief of 1 μm `[1]`.
    relief: [f64; ORDERS],
    /// p(φ) = p_c cos φ + p_s sin φ [μm].
    profile: [f64; 2],
    law: Backlash,
}

const NAMES: [(&str, &str); 6] = [
    ("speed", "1"),
    ("load", "μm"),
    ("damping ratio", "1"),
    ("half backlash", "μm"),
    ("tip relief", "μm"),
    ("phase", "rad"),
];

impl RelievedPair {
    /// e and de/dφ.
    #[inline(always)]
    fn error<S: Scalar>(&self, u: &Drives<'_, S>) -> [S; 2] {
        let [_, _, _, c1, s1, c2, s2, c3, s3]: [S; 9] = u.constants();
        let parts = [[c1, s1], [c2, s2], [c3, s3]];
        let (mut e, mut slope) = (S::from(0.0), S::from(0.0));
        for (h, [c, s]) in parts.into_iter().enumerate() {
            let [cos, sin] = u.waves_from::<2>(1 + 2 * h);
            let order = h as f64 + 1.0;
            e = e + c * cos + s * sin;
            slope = slope + (s * cos - c * sin) * order;
        }
        [e, slope]
    }
}

impl Shape for RelievedPair {
    #[inline(always)]
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1 + 2 * ORDERS, contacts: 1, constants: 4 + 2 * ORDERS, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        NAMES.map(|(name, unit)| Channel::new(name, unit)).into()
    }
    /// Relief and phase become the coefficients of cos h φ and sin h φ in the error.
    fn prepare<S: Scalar>(&self, constants: &[S]) -> Vec<S> {
        let (relief, phase) = (constants[4], constants[5]);
        let mut prepared = constants[..4].to_vec();
        for (h, share) in self.relief.iter().enumerate() {
            let [c, s] = if h == 0 { self.profile } else { [0.0; 2] };
            let (c, s) = (relief * *share + S::from(c), S::from(s));
            let (sin, cos) = (phase * (h as f64 + 1.0)).sin_cos();
            prepared.extend([c * cos - s * sin, c * sin + s * cos]);
        }
        prepared
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.stiffness.value(angle, side);
        for (wave, u) in self.harmonics.iter().flatten().zip(&mut u[1..]) {
            *u = wave.value(angle, side);
        }
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
        let [stiffness] = u.waves();
        let [_, _, b] = u.constants();
        let [e, slope] = self.error(&u);
        let (deflection, rate) = (q[0] - e, v[0] - slope * u.speed());
        let force =
            stiffness * law.force(i, &self.law, Deflection { d: deflection, rate, lower: -b, upper: b });
        Contact { deflection, rate, lower: -b, upper: b, force, ..Contact::default() }
    }
    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [load, damping, _] = u.constants();
        let contact = self.contact(law, 0, u, q, v);
        a[0] = load - damping * contact.rate * 2.0 - contact.force;
    }
}

/// A pair of contact ratio 1.6 without relief.
fn pair() -> Result<Machine<RelievedPair>, ParameterError> {
    // Harmonics of a rectangular wave of two pairs of teeth for 0.6 of the cycle, with a jump of 0.4.
    let step = |h: f64| 0.4 * 2.0 / (h * PI) * (0.6 * h * PI).sin();
    let stiffness = Fourier::new(1.0, &[[step(1.0), 0.0], [step(2.0), 0.0], [step(3.0), 0.0]])?;
    let harmonic = |h: usize| -> Result<[Wave; 2], ParameterError> {
        let series = |at: [f64; 2]| {
            let mut list = vec![[0.0; 2]; h];
            list[h - 1] = at;
            Fourier::new(0.0, &list).map(Wave::new)
        };
        Ok([series([1.0, 0.0])?, series([0.0, 1.0])?])
    };
    // Harmonics of a triangle of height 1 and half width w [rad] about the middle of double contact.
    let w = 2.0;
    let triangle = |h: f64| 2.0 / PI * (1.0 - (h * w).cos()) / (h * h * w);
    let shape = RelievedPair {
        stiffness: Wave::new(stiffness),
        harmonics: [harmonic(1)?, harmonic(2)?, harmonic(3)?],
        relief: [triangle(1.0), triangle(2.0), triangle(3.0)],
        profile: [-5.0, -9.0],
        law: Backlash::new(0.0)?,
    };
    let values = [0.7, 20.0, 0.05, 50.0, 0.0, 0.0];
    let constants: Vec<(&str, f64)> =
        NAMES.iter().zip(values).map(|((name, _), value)| (*name, value)).collect();
    Machine::of_constants(shape, &constants)
}

/// Bounds of the relief [μm] and of its phase [rad].
const RELIEF: [f64; 2] = [0.0, 30.0];
const PHASE: [f64; 2] = [0.0, 3.0];

/// Points of the grid along each axis.
const SIDE: usize = 100;

/// Peak-to-peak value and contact loss over a grid of reliefs and phases.
fn grid(pair: &Machine<RelievedPair>) -> Outcome<Rows> {
    let points = Points::grid(vec![
        Axis::linear("relief", RELIEF[0], RELIEF[1], SIDE)?,
        Axis::linear("phase", PHASE[0], PHASE[1], SIDE)?,
    ])?;
    let sweep = Sweep::new(points).settle(100).repeat_tolerance(1e-7).measure(1).channels(&["q0"]).rattle();
    let model = |p: &Point<'_>| pair.with("tip relief", p["relief"])?.with("phase", p["phase"]);
    let start = State::new(0.0, &[70.0], &[0.0]);
    Ok(sweep.of(&LaneRk4::new(256), model).start(|_, _| start.clone()).run()?)
}

/// The peak-to-peak value of x of a row [μm].
fn swing(row: &Row<'_>) -> f64 {
    row.channel("q0").map_or(f64::NAN, |x| x.peak_to_peak())
}

/// x over one mesh cycle of the orbit, over φ/2π, and its peak-to-peak value.
fn cycle(pair: &Machine<RelievedPair>) -> Outcome<(Vec<(f64, f64)>, f64)> {
    let orbit = Shooting::new().solve(pair, &State::new(0.0, &[70.0], &[0.0]))?;
    let mut statistics = Statistics::new(pair, &["q0"])?;
    orbit.observe(pair, &mut statistics)?;
    let at = |k: u32| -> Outcome<(f64, f64)> {
        let share = f64::from(k) / 200.0;
        Ok((share, orbit.at(pair, share * pair.period())?.q[0]))
    };
    Ok(((0..=200).map(at).collect::<Outcome<_>>()?, statistics.summary("q0")?.peak_to_peak()))
}

pub(crate) fn main() -> Outcome<()> {
    let folder = gallery("quieter_gears")?;
    let pair = pair()?;
    let (plain, before) = cycle(&pair)?;
    println!("without relief the peak-to-peak value of the transmission error is {before:.6} μm");

    let began = Instant::now();
    let start = pair.with("tip relief", 5.0)?.with("phase", 1.0)?;
    let least = Least::new("q0", Figure::PeakToPeak)
        .over("tip relief", RELIEF[0], RELIEF[1])
        .over("phase", PHASE[0], PHASE[1]);
    let best = least.run(&start, &State::new(0.0, &[70.0], &[0.0]))?;
    let by_gradient = began.elapsed().as_secs_f64();
    let [relief, phase] = [best.constants[0].1, best.constants[1].1];

    let began = Instant::now();
    let rows = grid(&pair)?;
    let by_grid = began.elapsed().as_secs_f64();
    let least = rows.iter().min_by(|a, b| swing(a).total_cmp(&swing(b))).ok_or("an empty grid")?;
    let (lowest, at) = (swing(&least), least.point());
    println!("\n                relief [μm]  phase [rad]  peak-to-peak [μm]  orbits  time [s]");
    println!(
        "by gradients {relief:14.6} {phase:12.6} {:18.8} {:7} {by_gradient:9.3}",
        best.value, best.evaluations
    );
    println!(
        "by the grid  {:14.6} {:12.6} {:18.8} {:7} {by_grid:9.3}",
        at["relief"],
        at["phase"],
        lowest,
        SIDE * SIDE
    );
    println!(
        "relative difference {:.1e}; share of the time {:.1e}",
        (best.value / lowest - 1.0).abs(),
        by_gradient / by_grid
    );

    let mut csv = csv_file(folder.join("map.csv"), "relief,phase,peak_to_peak,contact_loss")?;
    let loss = |row: &Row<'_>| row.contacts()[0].loss_fraction();
    for row in rows.iter() {
        csv.numbers(&[row.point()["relief"], row.point()["phase"], swing(&row), loss(&row)])?;
    }
    csv.finish()?;
    let (relieved, _) = cycle(&pair.with("tip relief", relief)?.with("phase", phase)?)?;
    let mut csv = csv_file(folder.join("cycle.csv"), "mesh_cycle,without_relief,with_relief")?;
    for (a, b) in plain.iter().zip(&relieved) {
        csv.numbers(&[a.0, a.1, b.1])?;
    }
    csv.finish()?;
    let panel = Panel::new("one mesh cycle", "mesh cycles φ/2π [1]", "dynamic transmission error x [μm]")?
        .series("without relief", Mark::Line, plain)?
        .series("with the best relief", Mark::Line, relieved)?;
    Picture::from(panel).save(folder.join("cycle.svg"))?;
    let axes = ["tip relief C [μm]", "phase ψ [rad]"];
    let panels = [
        map(&rows, axes, "peak-to-peak value of x [μm]", swing)?.title("vibration").logarithmic_colours()?,
        map(&rows, axes, "contact loss, share of the time [1]", loss)?.title("contact loss"),
    ];
    let minimum = |panel: Panel| panel.series("minimum by gradients", Mark::Dots, [(relief, phase)]);
    let panels = panels.map(minimum).into_iter().collect::<Result<Vec<_>, _>>()?;
    Picture::new(panels).columns(2).save(folder.join("map.svg"))?;
    println!("\npictures and tables: {}", folder.display());
    Ok(())
}
