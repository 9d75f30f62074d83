//! Lyapunov exponents against closed forms, multipliers, the divergence and independent results. The long
//! tests: `cargo test --release --test suite lyapunov -- --ignored`.

use crate::api::*;
use crate::common::oscillators::{DeadZone, Duffing};
use crate::common::stored;
use std::f64::consts::TAU;

/// x'' + 3 x' + 2 x = 0: exponents -1 and -2.
struct Overdamped;

impl Model for Overdamped {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = -3.0 * v[0] - 2.0 * q[0];
    }
}

#[test]
fn overdamped_oscillator() {
    let exponents = Lyapunov::new()
        .settle(0)
        .align(30)
        .measure(50)
        .run_over(&Overdamped, &State::at_rest(1), 1.0)
        .unwrap();
    let values = exponents.values();
    println!("{values:?} {:?}", exponents.standard_error());
    assert!((values[0] + 1.0).abs() < 1e-8 && (values[1] + 2.0).abs() < 1e-8);
}

/// On a periodic orbit the exponents are ln|μ|/T.
#[test]
fn of_a_periodic_orbit() {
    let model = DeadZone { omega: 0.85, zeta: 0.05, mean: 0.1, amplitude: 0.0, stiffness: -0.2 };
    let cycle = Shooting::new().solve(&model, &State::new(0.0, &[1.17], &[0.02])).unwrap();
    let growth = cycle.multipliers().growth(cycle.period());
    let exponents =
        Lyapunov::new().settle(0).align(50).measure(1000).run(&model, &cycle.states()[0]).unwrap();
    println!("{:?} {growth:?} {:?}", exponents.values(), exponents.standard_error());
    for (ours, exact) in exponents.values().iter().zip(&growth) {
        // For a complex pair the mean converges as 1/periods.
        assert!((ours - exact).abs() < 1e-4, "{ours} {exact}");
    }
    let duffing = Duffing { omega: 1.25 };
    let cycle = Shooting::new().solve(&duffing, &State::new(0.0, &[-0.98292], &[3.00552])).unwrap();
    assert_eq!(cycle.stability(), Stability::Unstable);
    let growth = cycle.multipliers().growth(cycle.period());
    let exponents = Lyapunov::new()
        .settle(0)
        .align(8)
        .measure(12)
        .flow_tolerance(1e-12)
        .run(&duffing, &cycle.states()[0])
        .unwrap();
    println!("{:?} {growth:?}", exponents.values());
    for (ours, exact) in exponents.values().iter().zip(&growth) {
        assert!((ours - exact).abs() < 1e-3, "{ours} {exact}");
    }
}

fn reading_a(speed: f64) -> NfgPair {
    NfgPair::of_reading(&NfgParams { speed, ..NfgParams::table1() }, NfgReading::published_on_base_radius())
        .unwrap()
}

/// Exponents of reading A (docs/models.md) per turn of the face gear, by speed: `bifurcation_modelA` of
/// tests/data/nfg.json.
fn published() -> Vec<(f64, f64)> {
    let file = crate::data::read("nfg.json");
    let all = file["bifurcation_modelA"]["lyapunov_per_carrier_period"].as_object().unwrap();
    all.iter().map(|(speed, theirs)| (speed.parse().unwrap(), theirs.as_f64().unwrap())).collect()
}

/// The pair of Liu 2021, reading A: exponents per turn of the face gear. They are compared with
/// tests/data/nfg.json if the motion is chaotic, with the multipliers of the orbit if not. Their sum is -2 ζ.
fn rattling_pair(periods: usize, speeds: impl Fn(f64) -> bool) {
    for (speed, theirs) in published().into_iter().filter(|(speed, _)| speeds(*speed)) {
        let pair = reading_a(speed);
        let exponents = Lyapunov::new()
            .settle(40)
            .align(5)
            .measure(periods)
            .run(&pair, &pair.on_drive_flank().unwrap())
            .unwrap();
        let (ours, error) = (exponents.per_period()[0], exponents.standard_error()[0]);
        println!("{speed}: {ours:.2} ± {error:.2}, reference {theirs}");
        if theirs > 0.0 {
            // The reference is one sample, accurate to 15 %, and the result has its own standard error. The
            // test over a thousand turns has narrower bounds.
            assert!((ours - theirs).abs() < 0.15 * theirs + 2.0 * error, "{speed}: {ours} {theirs}");
        } else {
            let start = exponents.state();
            let cycle = Shooting::new().solve(&pair, &[State { t: 0.0, ..start.clone() }]).unwrap();
            let exact = cycle.multipliers().growth(cycle.period())[0] * pair.period();
            println!("    multipliers {exact:.4}");
            assert_eq!(cycle.least_period_multiple(), 1);
            assert!((ours - exact).abs() < 1e-3 * exact.abs() + 2.0 * error, "{speed}: {ours} {exact}");
            // At 180 rad/s the multipliers are a complex pair with the exponent -ζ T = -15.1. The reference
            // is a short run that varies with the phase of the pair.
            assert!(speed > 165.0 || (ours - theirs).abs() < 0.15 * theirs.abs(), "{speed}: {ours} {theirs}");
        }
        let sum: f64 = exponents.values().iter().sum();
        assert!((sum + 2.0 * NfgParams::table1().damping_ratio).abs() < 1e-9, "{speed}: {sum}");
    }
}

#[test]
fn of_the_rattling_pair() {
    rattling_pair(10, |speed| speed == 180.0);
}

#[test]
#[ignore = "a minute: cargo test --release --test suite lyapunov -- --ignored"]
fn of_the_rattling_pair_at_all_speeds() {
    rattling_pair(150, |_| true);
}

/// Over 1000 turns all exponents of chaotic motions are within 15 % of the reference, except at 160 rad/s.
/// There bursts scatter the samples: 1000 turns give 5.00 ± 0.18 (5.08 ± 0.29 at tolerance 1e-7), and the
/// reference must lie in the range of the samples of 100 turns.
#[test]
#[ignore = "minutes: cargo test --release --test suite lyapunov -- --ignored"]
fn of_the_rattling_pair_over_a_thousand_turns() {
    for (speed, theirs) in published().into_iter().filter(|(_, theirs)| *theirs > 0.0) {
        let pair = reading_a(speed);
        let exponents = Lyapunov::new()
            .count(1)
            .settle(60)
            .measure(1000)
            .run(&pair, &pair.on_drive_flank().unwrap())
            .unwrap();
        let (ours, error) = (exponents.per_period()[0], exponents.standard_error()[0]);
        println!(
            "{speed}: {ours:.3} ± {error:.3}, reference {theirs}, {:.1} %",
            100.0 * (ours / theirs - 1.0)
        );
        let (running, turns) = (exponents.running(0), 100);
        let sum = |turn: usize| if turn == 0 { 0.0 } else { running[turn - 1] * turn as f64 };
        let samples =
            (0..running.len() / turns).map(|i| (sum((i + 1) * turns) - sum(i * turns)) / turns as f64);
        let (least, most) =
            samples.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)));
        println!("    samples of {turns} turns: {least:.2} .. {most:.2}");
        let close = (ours - theirs).abs() < 0.15 * theirs;
        assert!(close || (speed == 160.0 && (least..=most).contains(&theirs)), "{speed}: {ours} {theirs}");
    }
}

/// The chaotic window of reading A ends between 163 and 163.5 rad/s, where the motion has period 2; from 164
/// rad/s it has period 1. Chaotic motions have periodic windows beside them at arbitrarily close speeds, and which of
/// them a finite run shows may depend on rounding. Two things are promised there: no row contradicts itself, since a
/// motion that repeats has no positive exponent and a positive exponent makes a row sensitive; and nine of ten rows are
/// chaotic.
fn window(speeds: &[f64]) {
    let points = Points::from(Axis::of_values("speed", speeds).unwrap());
    let sweep = Sweep::new(points)
        .settle(60)
        .measure(40)
        .lyapunov(Lyapunov::new().align(5).measure(40).flow_tolerance(1e-7));
    let family = |p: &Point<'_>| Ok::<_, ParameterError>(reading_a(p["speed"]));
    let solver = Dop853::new().rtol(1e-9).atol_each(&[1e-14, 1e-15]);
    let rows = sweep.of(&Located(solver), family).start(|_, pair| pair.on_drive_flank()).run().unwrap();
    assert!(rows.errors().is_empty());
    let (mut within, mut chaotic) = (0, 0);
    for row in rows.iter() {
        let (speed, exponent, error) =
            (row.point()["speed"], row.lyapunov().unwrap(), row.lyapunov_standard_error().unwrap());
        println!("{speed}: {exponent:.3} ± {error:.3}, period {:?}", row.period_multiple());
        let grows = exponent > 2.0 * error;
        assert!(
            !grows || row.period_multiple().is_none() && row.is_sensitive(),
            "{speed}: {exponent} ± {error}"
        );
        match speed {
            150.0..=163.0 => (within, chaotic) = (within + 1, chaotic + usize::from(grows)),
            163.5 => assert_eq!((row.period_multiple(), exponent < 0.0), (Some(2), true)),
            164.0.. => {
                assert_eq!((row.period_multiple(), exponent < 0.0), (Some(1), true), "{speed}: {exponent}")
            }
            _ => {}
        }
    }
    assert!(10 * chaotic >= 9 * within, "{chaotic} of {within} rows are chaotic");
}

#[test]
#[ignore = "minutes: cargo test --release --test suite lyapunov -- --ignored"]
fn the_chaotic_window_every_half_step() {
    window(&(0..=80).map(|i| 150.0 + 0.5 * f64::from(i)).collect::<Vec<_>>());
}

/// x'' + c x' + 2 x = cos 2t, period π. For c = 3 the exponents are -1 and -2.
struct Driven(f64);

impl Model for Driven {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = (2.0 * u[0]).cos() - self.0 * v[0] - 2.0 * q[0];
    }
}

impl Periodic for Driven {
    fn period(&self) -> f64 {
        std::f64::consts::PI
    }
}

/// In a sweep the exponent per period has its closed form, with either engine and with warm starts: for c = 3
/// it is -T and for c = 4 it is (√2 - 2) T.
#[test]
fn the_largest_exponent_is_a_measure_of_sweeps() {
    let family = |p: &Point<'_>| Ok::<_, ParameterError>(Driven(p["damping"]));
    let start = |_: &Point<'_>, _: &Driven| Ok::<_, ParameterError>(State::at_rest(1));
    let points = Points::from(Axis::of_values("damping", &[3.0, 4.0]).unwrap());
    let sweep = Sweep::new(points).settle(4).measure(2).strobe(1).warm_start(WarmStart::Up);
    let asked = sweep.clone().lyapunov(Lyapunov::new().align(10).measure(20));
    let period = Driven(0.0).period();
    for rows in [
        asked.of(&TableRk4::new(64), family).start(start).run().unwrap(),
        asked.of(&Located(Dop853::new()), family).start(start).run().unwrap(),
    ] {
        for (row, rate) in rows.iter().zip([-1.0, 2f64.sqrt() - 2.0]) {
            let (ours, error) = (row.lyapunov().unwrap(), row.lyapunov_standard_error().unwrap());
            assert!((ours - rate * period).abs() < 1e-7 && error < 1e-7, "{ours} ± {error} {rate}");
        }
        assert_eq!(stored(&rows), rows);
    }
    let without = sweep.of(&TableRk4::new(64), family).start(start).run().unwrap();
    assert!(without.iter().all(|row| row.lyapunov().is_none() && row.lyapunov_standard_error().is_none()));
    for bad in [
        Lyapunov::new().measure(0),
        Lyapunov::new().renormalisations(0),
        Lyapunov::new().flow_tolerance(f64::NAN),
        Lyapunov::new().count(2),
    ] {
        assert!(matches!(
            sweep.clone().lyapunov(bad).of(&TableRk4::new(64), family).start(start).run(),
            Err(SweepError::Parameter(_))
        ));
    }
}

/// A sweep reads the settling periods of its exponents: more of them start the measurement later.
#[test]
fn exponents_of_sweeps_settle_as_set() {
    let pair = |p: &Point<'_>| Ok::<_, ParameterError>(reading_a(p["speed"]));
    let start = |_: &Point<'_>, pair: &NfgPair| pair.on_drive_flank();
    let lyapunov = Lyapunov::new().align(1).measure(2).flow_tolerance(1e-7).count(1);
    let sweep = Sweep::new(Axis::of_values("speed", &[180.0]).unwrap());
    let sweep = sweep.settle(2).measure(1).strobe(1);
    let of = |lyapunov: Lyapunov| {
        sweep.clone().lyapunov(lyapunov).of(&Located(Dop853::new()), pair).start(start).run()
    };
    let (default, none, some) =
        (of(lyapunov.clone()), of(lyapunov.clone().settle(0)), of(lyapunov.clone().settle(3)));
    let (default, none, some) = (default.unwrap(), none.unwrap(), some.unwrap());
    let end = default.get(0).unwrap().strobes().next().unwrap().to_vec();
    let alone = lyapunov.settle(3).run(&reading_a(180.0), &State::new(0.0, &end[..1], &end[1..])).unwrap();
    let exponent = |rows: &Rows| rows.get(0).unwrap().lyapunov();
    assert_eq!(exponent(&some), Some(alone.per_period()[0]));
    assert_eq!(exponent(&default), exponent(&none));
    assert_ne!(exponent(&default), exponent(&some));
}

/// The exponent of a row is measured from the last state of its run: to the bit the result of [`Lyapunov`]
/// from there, with lanes and in chunks.
#[test]
fn the_exponent_of_a_row_is_that_of_its_own_motion() {
    let pair = |p: &Point<'_>| Ok::<_, ParameterError>(reading_a(p["speed"]));
    let start = |_: &Point<'_>, pair: &NfgPair| pair.on_drive_flank();
    let lyapunov = Lyapunov::new().align(1).measure(4).flow_tolerance(1e-7);
    let speeds = Points::from(Axis::of_values("speed", &[155.0, 180.0]).unwrap());
    let sweep = Sweep::new(speeds).settle(4).measure(1).strobe(1).lyapunov(lyapunov.clone());
    let rows = sweep.of(&LaneRk4::new(4032).lanes::<4>(), pair).start(start).run().unwrap();
    for row in rows.iter() {
        let end = row.strobes().next().unwrap();
        let alone = lyapunov
            .clone()
            .settle(0)
            .count(1)
            .run(&pair(&row.point()).unwrap(), &State::new(0.0, &end[..1], &end[1..]))
            .unwrap();
        assert_eq!(row.lyapunov(), Some(alone.per_period()[0]));
        assert_eq!(row.lyapunov_standard_error(), Some(alone.standard_error()[0]));
    }
    let parts =
        (0..3).map(|i| sweep.of(&LaneRk4::new(4032).lanes::<8>(), pair).start(start).chunk(i, 3).unwrap());
    assert_eq!(Rows::merge(parts.collect()).unwrap().fingerprint(), rows.fingerprint());
}

/// An error contains the periods that were measured before it. Invalid settings are refused by name.
#[test]
fn bad_input() {
    struct Breaks;
    impl Model for Breaks {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            a[0] = if u[0] < 5.5 { -q[0] - 0.1 * v[0] } else { f64::NAN };
        }
    }
    let solve = Lyapunov::new().settle(0).align(0);
    match solve.run_over(&Breaks, &State::new(0.0, &[1.0], &[0.0]), 1.0) {
        Err(LyapunovError::Integrate { last, .. }) => assert_eq!(last.running(0).len(), 5),
        other => panic!("{other:?}"),
    }
    let start = State::at_rest(1);
    let with = |change: fn(Lyapunov) -> Lyapunov| change(solve.clone());
    for lyapunov in [
        with(|l| l.count(0)),
        with(|l| l.count(3)),
        with(|l| l.measure(0)),
        with(|l| l.renormalisations(0)),
        with(|l| l.renormalisations(usize::MAX)),
        with(|l| l.flow_tolerance(f64::NAN)),
    ] {
        assert!(matches!(lyapunov.run_over(&Overdamped, &start, 1.0), Err(LyapunovError::Parameter(_))));
    }
    assert!(matches!(solve.run_over(&Overdamped, &start, f64::NAN), Err(LyapunovError::Parameter(_))));
    assert!(matches!(solve.run_over(&Overdamped, &State::at_rest(2), 1.0), Err(LyapunovError::Parameter(_))));
}

/// x'' + c x' + k x = cos t. The exponents are the real parts of the roots of s² + c s + k.
struct Linear {
    damping: f64,
    stiffness: f64,
}

impl Linear {
    /// Exponents per period, the larger one first.
    fn exact(&self) -> [f64; 2] {
        let root = (self.damping * self.damping / 4.0 - self.stiffness).max(0.0).sqrt();
        // k/fast instead of -c/2 + root, which would cancel.
        let fast = -self.damping / 2.0 - root;
        [if root > 0.0 { self.stiffness / fast } else { fast }, fast].map(|x| x * TAU)
    }
}

impl Model for Linear {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = u[0].cos() - self.damping * v[0] - self.stiffness * q[0];
    }
}

impl Periodic for Linear {
    fn period(&self) -> f64 {
        TAU
    }
}

/// x'' + c x' + k x + x³ = F cos w t: Duffing's oscillator, with k = 0 Ueda's.
struct Cubic {
    damping: f64,
    stiffness: f64,
    force: f64,
    omega: f64,
}

impl Model for Cubic {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = self.force * (self.omega * u[0]).cos()
            - self.damping * v[0]
            - self.stiffness * q[0]
            - q[0].powi(3);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { jacobian: true, ..Offers::default() }
    }
    fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], q: &[f64], _: &[f64], out: &mut Jacobian) {
        (out.q[(0, 0)], out.v[(0, 0)]) = (-self.stiffness - 3.0 * q[0] * q[0], -self.damping);
    }
}

impl Periodic for Cubic {
    fn period(&self) -> f64 {
        TAU / self.omega
    }
}

/// The directions of x'' + 0.05 x' + x = cos t turn once in almost one period, so that strobed directions
/// almost stand still. The standard error must not be too small.
#[test]
fn a_direction_that_turns_with_the_period_is_no_certainty() {
    let model = Linear { damping: 0.05, stiffness: 1.0 };
    let exponents = Lyapunov::new().settle(20).measure(40).run(&model, &State::at_rest(1)).unwrap();
    let (ours, errors, exact) = (exponents.per_period(), exponents.standard_error(), model.exact());
    println!("{ours:?} ± {errors:?}, exact {exact:?}");
    assert!(ours[0] >= ours[1]);
    for i in 0..2 {
        assert!(
            (ours[i] - exact[i]).abs() < 2.0 * errors[i] && errors[i] < 1e-4,
            "{} ± {}",
            ours[i],
            errors[i]
        );
    }
}

/// Share of `count` random starts for which two standard errors contain the exponent: the exact one or, with
/// `None`, the mean of all. Then the mean standard error, over the root mean square of the errors.
fn coverage<M: Periodic>(lyapunov: &Lyapunov, model: &M, count: u32, exact: Option<f64>) -> [f64; 2] {
    let start =
        |i: u32| [1, 2].map(|j| 2.0 * (f64::from(i) * [0.0, 0.754_877_666, 0.569_840_291][j]).fract() - 1.0);
    let runs = (0..count).map(|i| {
        let [q, v] = start(i);
        let exponents = lyapunov.run(model, &State::new(0.0, &[q], &[v])).unwrap();
        (exponents.per_period()[0], exponents.standard_error()[0])
    });
    let runs: Vec<(f64, f64)> = runs.collect();
    let mean = |of: fn(&(f64, f64)) -> f64| runs.iter().map(of).sum::<f64>() / runs.len() as f64;
    let exact = exact.unwrap_or(mean(|run| run.0));
    let held = runs.iter().filter(|(ours, error)| (ours - exact).abs() < 2.0 * error).count();
    let off = (runs.iter().map(|(ours, _)| (ours - exact) * (ours - exact)).sum::<f64>() / runs.len() as f64)
        .sqrt();
    println!(
        "exponent {exact:.6}, scatter {off:.2e}, standard error {:.2e}: {held} of {count} within two errors",
        mean(|run| run.1)
    );
    assert!(mean(|run| run.1) < 1.5 * off, "standard errors are more than 1.5 times the scatter");
    [held as f64 / f64::from(count), mean(|run| run.1) / off]
}

/// Short form of the next test.
#[test]
fn bars_cover_a_linear_oscillator() {
    let model = Linear { damping: 0.05, stiffness: 0.81 };
    let lyapunov = Lyapunov::new().count(1).settle(1).align(8).measure(12).flow_tolerance(1e-7);
    let [share, _] = coverage(&lyapunov, &model, 24, Some(model.exact()[0]));
    assert!(share >= 0.85, "{share}");
}

/// Two standard errors contain the exponent for 90 to 98 % of 200 random starts of chaotic motions.
///
/// The errors of a linear oscillator are those of a direction that turns: at most √2 times their root mean
/// square. Two exact standard errors contain all of them, so that their share has no upper limit. The standard
/// error itself is held to within a quarter of the scatter.
#[test]
#[ignore = "minutes: cargo test --release --test suite lyapunov -- --ignored --nocapture"]
fn bars_cover_95_percent_of_200_seeds() {
    let lyapunov = Lyapunov::new().count(1).settle(20).flow_tolerance(1e-8);
    let linear = Linear { damping: 0.05, stiffness: 1.0 };
    let duffing = Cubic { damping: 0.3, stiffness: -1.0, force: 0.5, omega: 1.2 };
    let ueda = Cubic { damping: 0.05, stiffness: 0.0, force: 7.5, omega: 1.0 };
    let measured = [
        coverage(&lyapunov, &linear, 200, Some(linear.exact()[0])),
        coverage(&lyapunov.clone().measure(40), &linear, 200, Some(linear.exact()[0])),
    ];
    for [share, size] in measured {
        assert!(share >= 0.9 && (0.75..=1.25).contains(&size), "{measured:?}");
    }
    for [share, _] in [coverage(&lyapunov, &duffing, 200, None), coverage(&lyapunov, &ueda, 200, None)] {
        assert!((0.90..=0.98).contains(&share), "{share}");
    }
}

/// Spans far below the time of the motion, without alignment: a random direction turns at once to one that stands almost
/// still, and its growth is that of the damping. The errors tell that nothing is known.
#[test]
fn short_spans_without_alignment_have_no_finite_errors() -> Result<(), Box<dyn std::error::Error>> {
    for [damping, stiffness] in [[3.0, 2.0], [0.2, 4.0], [0.01, -1.0]] {
        let model = Linear { damping, stiffness };
        for span in [1e-5, 3e-5, 1e-4, 5e-4] {
            for start in [State::new(0.0, &[0.3], &[-0.2]), State::new(0.0, &[-0.45], &[0.1])] {
                let found = Lyapunov::new().settle(0).align(0).measure(200).run_over(&model, &start, span)?;
                let errors = found.standard_error();
                assert!(
                    errors.iter().all(|e| e.is_infinite()),
                    "{damping} {span} {:?} {errors:?}",
                    found.values()
                );
            }
        }
    }
    Ok(())
}

/// Stiff models: between two renormalisations a direction shrinks by e⁻¹¹⁸, or underflows to zero.
#[test]
fn a_stiff_model_has_its_second_exponent() {
    for damping in [300.0, 1000.0] {
        let model = Linear { damping, stiffness: 1.0 };
        let exponents =
            Lyapunov::new().settle(0).align(0).measure(1).run(&model, &State::at_rest(1)).unwrap();
        let (ours, exact) = (exponents.per_period(), model.exact());
        println!("{ours:?} {exact:?}");
        // One period is too short for the first direction to converge.
        assert!((ours[1] / exact[1] - 1.0).abs() < 1e-2 && ours[0].abs() < 10.0, "{ours:?} {exact:?}");
        assert!((ours[0] + ours[1] + damping * TAU).abs() < 1e-6 * damping, "{ours:?}");
    }
}

/// Two uncoupled oscillators; the first one has the larger damping.
#[test]
fn the_largest_exponent_is_that_of_the_whole_model() {
    struct Two;
    impl Model for Two {
        fn dof(&self) -> usize {
            2
        }
        fn accel(&self, _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            (a[0], a[1]) = (-3.0 * v[0] - 2.0 * q[0], -2.0 * v[1] - 0.75 * q[1]);
        }
    }
    let start = State::new(0.0, &[1.0, 1.0], &[0.0, 0.0]);
    let solve = Lyapunov::new().settle(0).align(40).measure(10);
    let all = solve.run_over(&Two, &start, 1.0).unwrap().values();
    for (ours, exact) in all.iter().zip([-0.5, -1.0, -1.5, -2.0]) {
        assert!((ours - exact).abs() < 1e-6, "{all:?}");
    }
    let first = solve.count(1).run_over(&Two, &start, 1.0).unwrap().values()[0];
    assert!((first + 0.5).abs() < 1e-6, "{first}");
}

/// An error contains the state that was reached, during settling and during measuring.
#[test]
fn a_run_that_ends_early_keeps_its_state() {
    struct Breaks;
    impl Model for Breaks {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            a[0] = if u[0] < 5.5 { -q[0] - 0.1 * v[0] } else { f64::NAN };
        }
    }
    let start = State::new(0.0, &[1.0], &[0.0]);
    // While settling, in its last period, and while measuring.
    for settle in [50, 6, 2] {
        let Err(LyapunovError::Integrate { last, .. }) =
            Lyapunov::new().settle(settle).align(0).run_over(&Breaks, &start, 1.0)
        else {
            panic!("settled although the acceleration is NaN");
        };
        let state = last.state();
        assert!(state.t > 4.0 && state.t < 5.5 && state.q != start.q, "{settle}: {state:?}");
    }
}

/// The budget ends a run with any counts.
#[test]
fn a_budget_ends_any_run() {
    let model = Linear { damping: 0.05, stiffness: 1.0 };
    let start = State::at_rest(1);
    let solve = Lyapunov::new().settle(0).align(0).flow_tolerance(1e-6);
    let most = [
        solve.clone().settle(usize::MAX),
        solve.clone().align(usize::MAX),
        solve.clone().measure(usize::MAX),
    ];
    for lyapunov in most {
        match lyapunov.budget(Budget::new().steps(600)).run(&model, &start) {
            Err(LyapunovError::Exhausted { exhausted: Exhausted::Steps { limit: 600 }, last }) => {
                assert!(last.state().t > TAU)
            }
            other => panic!("{other:?}"),
        }
    }
    let flag = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(true));
    let stopped = solve.budget(Budget::new().cancel(flag)).run(&model, &start);
    assert!(
        matches!(stopped, Err(LyapunovError::Exhausted { exhausted: Exhausted::Cancelled, .. })),
        "{stopped:?}"
    );
}

/// x'' + 0.1 x' + x = 0 has the exponents -0.05, -0.05. Spans far below its time: the bars hold them.
#[test]
fn bars_of_spans_far_below_the_time_of_the_motion() {
    let swing = gear_dynamics::model::from_fn(1, |_, q, v, a| a[0] = -0.1 * v[0] - q[0]).unwrap();
    let (mut finite, mut held, mut count) = (0, 0, 0);
    for span in [1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0] {
        for i in 0..6 {
            let start = State::new(0.0, &[1.0], &[0.4 * f64::from(i) - 1.0]);
            let exponents = Lyapunov::new().count(1).settle(0).run_over(&swing, &start, span).unwrap();
            let error = (exponents.values()[0] + 0.05).abs();
            let bar = exponents.standard_error()[0] / span;
            count += 1;
            held += usize::from(error <= 2.0 * bar);
            finite += usize::from(bar.is_finite());
        }
    }
    // Two standard errors hold 95 %; runs of less than half a turn of the direction are infinite.
    assert!(held * 20 >= count * 19, "{held} of {count}");
    assert!(finite * 3 >= count, "{finite} of {count}");
}

/// A free body: its exponents are 0, and its differences grow like t.
#[test]
fn growth_with_a_power_of_time_is_within_the_bar() {
    let free = gear_dynamics::model::from_fn(1, |_, _, _, a| a[0] = 0.0).unwrap();
    for (start, span) in [(0.0, 1.0), (1.0, 1.0), (0.3, 6.0), (1.0, 0.1)] {
        let exponents = Lyapunov::new().run_over(&free, &State::new(0.0, &[0.0], &[start]), span).unwrap();
        for (value, bar) in exponents.per_period().iter().zip(exponents.standard_error()) {
            assert!(value.abs() <= 2.0 * bar, "{start} {span}: {value} ± {bar}");
        }
    }
}
