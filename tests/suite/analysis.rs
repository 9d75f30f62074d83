//! Spectra, statistics, rattle, sections and settling against closed forms and known orbits.

use crate::api::*;
use crate::data::read;
use gear_dynamics::models::Oscillator;
use proptest::prelude::*;
use std::f64::consts::TAU;

const WINDOWS: [Window; 5] =
    [Window::Rectangular, Window::Hann, Window::Hamming, Window::Blackman, Window::FlatTop];

/// A sine of amplitude 1 gives the amplitude 1 and a constant its own value, with every window and for even
/// and odd lengths.
#[test]
fn amplitudes_are_scaled() {
    for n in [64, 63, 1000] {
        for window in WINDOWS {
            let x: Vec<f64> = (0..n).map(|i| 0.7 + (TAU * 9.0 * i as f64 / n as f64 + 0.4).sin()).collect();
            let s = Spectrum::new(&x, 0.01, window).unwrap();
            assert!((s.amplitudes()[9] - 1.0).abs() < 1e-12, "{window:?}");
            assert!((s.amplitudes()[0] - 0.7).abs() < 1e-12, "{window:?}");
            assert!((s.phases()[9] - (0.4 - TAU / 4.0)).abs() < 1e-12, "{window:?}");
            assert!((s.frequencies()[9] - 9.0 / (n as f64 * 0.01)).abs() < 1e-12);
            assert!((s.orders(s.frequencies()[3]).unwrap()[9] - 3.0).abs() < 1e-12);
        }
    }
    let nyquist: Vec<f64> = (0..16).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
    assert!((Spectrum::new(&nyquist, 1.0, Window::Rectangular).unwrap().amplitudes()[8] - 1.0).abs() < 1e-14);
}

/// Between two lines the flat-top window gives the amplitude to 0.2 %. The other windows lose what their
/// scalloping loss states.
#[test]
fn windows_between_lines() {
    let x: Vec<f64> = (0..512).map(|i| (TAU * 40.5 * f64::from(i) / 512.0).sin()).collect();
    let peak =
        |window| Spectrum::new(&x, 1.0, window).unwrap().amplitudes().iter().copied().fold(0.0, f64::max);
    assert!((peak(Window::FlatTop) - 1.0).abs() < 2e-3);
    assert!((peak(Window::Hann) - 0.8488).abs() < 1e-3); // 1.42 dB: Harris 1978, Table I
    assert!((peak(Window::Rectangular) - 2.0 / std::f64::consts::PI).abs() < 5e-3); // 3.92 dB
}

proptest! {
    /// The transform against the sum of its definition.
    #[test]
    fn against_the_naive_sum(x in prop::collection::vec(-10.0..10.0f64, 2..40)) {
        let n = x.len();
        let s = Spectrum::new(&x, 1.0, Window::Rectangular).unwrap();
        for k in 0..=n / 2 {
            let (mut re, mut im) = (0.0, 0.0);
            for (i, x) in x.iter().enumerate() {
                let angle = TAU * (k * i) as f64 / n as f64;
                re += x * angle.cos();
                im -= x * angle.sin();
            }
            let sided = if k == 0 || 2 * k == n { 1.0 } else { 2.0 };
            prop_assert!((s.amplitudes()[k] - sided * re.hypot(im) / n as f64).abs() < 1e-12);
        }
    }
}

/// x'' + 2 ζ x' + g(x) = Fm + Fah W² cos W t with ζ = 0.05, Fm = 0.1, Fah = 0.05, g the dead zone of half
/// width 1: a spur pair after Kahraman & Singh (1990).
struct Spur {
    w: f64,
}

impl Model for Spur {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = 0.1 + 0.05 * self.w * self.w * (self.w * u[0]).cos() - 0.1 * v[0] - (q[0] - 1.0).max(0.0)
            + (-1.0 - q[0]).max(0.0);
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        out[0] = Contact { deflection: q[0], rate: v[0], lower: -1.0, upper: 1.0, ..Contact::default() };
    }
}

impl Periodic for Spur {
    fn period(&self) -> f64 {
        TAU / self.w
    }
}

/// The stable orbits at W = 0.75 and 0.8: extremes, mean, deviation, contact loss and crossings.
#[test]
fn coexisting_orbits_of_a_spur_pair() {
    let data = read("classics.json");
    let mut orbits = 0;
    for (w, list) in data["sdof_A"]["solutions_at_W"].as_object().unwrap() {
        for known in list.as_array().unwrap().iter().filter(|k| k["stable"] == true) {
            orbits += 1;
            let number = |key: &str| known[key].as_f64().unwrap();
            let model = Spur { w: w.parse().unwrap() };
            let solver = Dop853::new().rtol(1e-11).atol(1e-13);
            let start = State::new(0.0, &[number("x0")], &[number("v0")]);
            let steady = Settle::new().tolerance(1e-9).run(&solver, &model, &start).unwrap();
            assert_eq!(steady.period_multiple, 1);
            assert!(
                (steady.state.q[0] - number("x0")).abs() < 1e-8
                    && (steady.state.v[0] - number("v0")).abs() < 1e-8
            );
            let (mut statistics, mut rattle) =
                (Statistics::new(&model, &["q0"]).unwrap(), Rattle::new(&model));
            let end = steady.state.t + model.period();
            let mut both = (&mut statistics, &mut rattle);
            let finish = solver.run(&model, &steady.state, end, &mut both).unwrap();
            let q = statistics.summary("q0").unwrap();
            for (ours, key) in [(q.mean, "mean"), (q.deviation, "rms_about_mean")] {
                assert!((ours - number(key)).abs() < 1e-8, "W = {w}: {key} {ours}");
            }
            // The reference took its extremes from 4000 samples of a period. The true extremes lie outside by
            // up to h²/8 times the acceleration.
            let outside = [q.max - number("max"), number("min") - q.min];
            assert!(outside.iter().all(|d| (-1e-10..1e-7).contains(d)), "W = {w}: {outside:?}");
            let contact = rattle.contacts()[0];
            assert!((contact.loss_fraction() - number("gap_fraction")).abs() < 1e-8);
            assert_eq!(finish.stats.crossings as f64, number("crossings"));
            let expected =
                if number("crossings") > 0.0 { RattleState::Unilateral } else { RattleState::None };
            assert_eq!(contact.rattle_state(), expected);
            assert_eq!(2 * contact.impact_count(), finish.stats.crossings);
        }
    }
    assert!(orbits >= 4);
}

/// Without located edges the rattle is the same to the resolution of a step.
#[test]
fn rattle_without_located_edges() {
    let model = Spur { w: 0.75 };
    let start = State::new(0.0, &[0.833_843_012_540_731_5], &[0.164_078_751_799_494_74]);
    let mut rattle = Rattle::new(&model);
    Rk4::new(model.period() / 1000.0)
        .plain()
        .run(&model, &start, 10.0 * model.period(), &mut rattle)
        .unwrap();
    let contact = rattle.contacts()[0];
    assert_eq!((contact.rattle_state(), contact.impact_count()), (RattleState::Unilateral, 10));
    assert!((contact.loss_fraction() - 0.541_751_5).abs() < 1e-3);
}

#[test]
fn settling_finds_the_period_multiple() {
    /// A Duffing oscillator with two wells.
    struct Duffing {
        force: f64,
    }
    impl Model for Duffing {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            a[0] = self.force * (1.2 * u[0]).cos() - 0.3 * v[0] + q[0] - q[0] * q[0] * q[0];
        }
    }
    impl Periodic for Duffing {
        fn period(&self) -> f64 {
            TAU / 1.2
        }
    }
    let solver = Dop853::new();
    let start = State::new(0.0, &[1.0], &[0.0]);
    let multiple = |force: f64| {
        Settle::new()
            .tolerance(1e-7)
            .max_periods(500)
            .run(&solver, &Duffing { force }, &start)
            .map(|s| s.period_multiple)
    };
    // Period at each amplitude of the force: 1 at 0.20, 2 at 0.28, 4 at 0.29, chaos at 0.50, 2 at 0.65.
    // Source: Jordan & Smith, Sect. 13.3.
    assert_eq!(multiple(0.20), Ok(1));
    assert_eq!(multiple(0.28), Ok(2));
    assert_eq!(multiple(0.29), Ok(4));
    assert!(matches!(multiple(0.50), Err(SettleError::Aperiodic { periods: 500, .. })));
    assert_eq!(multiple(0.65), Ok(2));
    // Without excitation the motion decays to rest in a well, which has period 1.
    assert_eq!(multiple(0.0), Ok(1));
    assert!(matches!(
        Settle::new().tolerance(0.0).run(&solver, &Duffing { force: 0.2 }, &start),
        Err(SettleError::Parameter(_))
    ));
}

/// A level just below the maximum of a motion that the solver takes in one step: the section finds both
/// crossings.
#[test]
fn sections_inside_a_step() {
    struct Throw;
    impl Model for Throw {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = -1.0;
        }
    }
    let mut section = Section::new(&Throw, "q0", 0.4, Direction::Both).unwrap();
    let run = Dop853::new()
        .first_step(2.0)
        .run(&Throw, &State::new(0.0, &[0.0], &[1.0]), 2.0, &mut section)
        .unwrap();
    assert_eq!(run.stats.steps, 1);
    let times: Vec<f64> = section.states().iter().map(|s| s.t).collect();
    let expected = [1.0 - 0.2f64.sqrt(), 1.0 + 0.2f64.sqrt()];
    assert!(times.len() == 2 && times.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{times:?}");
    assert!(Section::new(&Throw, "q0", f64::NAN, Direction::Both).is_err());
}

/// x'' + 0.1 x' + x = cos 2t has one periodic motion, with the period of its drive. On the way to it the
/// motion returns closer after two periods than after one; it must not be taken for a motion of period 2.
#[test]
fn winding_into_an_orbit_is_no_subharmonic() {
    struct Swing;
    impl Model for Swing {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            a[0] = (2.0 * u[0]).cos() - 0.1 * v[0] - q[0];
        }
    }
    impl Periodic for Swing {
        fn period(&self) -> f64 {
            std::f64::consts::PI
        }
    }
    let solver = Dop853::new().rtol(1e-10).atol(1e-12);
    let steady = Settle::new().run(&solver, &Swing, &State::at_rest(1)).unwrap();
    assert_eq!(steady.period_multiple, 1);
    let points = Points::from(Axis::of_values("settle", &[0.0]).unwrap());
    for settle in [60, 90, 120, 150] {
        let sweep = Sweep::new(points.clone()).settle(settle).measure(20).channels(&["q0"]);
        let start = |_: &Point<'_>, _: &Swing| -> Result<State, ParameterError> { Ok(State::at_rest(1)) };
        let rows = sweep
            .of(&Located(solver.clone()), |_: &Point<'_>| Ok::<_, ParameterError>(Swing))
            .start(start)
            .run()
            .unwrap();
        let multiple = rows.get(0).unwrap().period_multiple();
        assert!(multiple.is_none() || multiple == Some(1), "{settle}: {multiple:?}");
    }
}

/// A long step whose highest point lies between the points at which it is read, and hardly above an earlier
/// extremum: by steps of `Taylor` and by the short ones of `Dop853` at tight tolerances.
#[test]
fn extremes_between_the_points_of_a_long_step() {
    let constants = [
        ("speed", 1.3303108478454686),
        ("damping", 0.17827903394339276),
        ("mesh stiffness", 1.82387326915872),
        ("mean force", -0.4263213655027467),
        ("force", 0.28792385595548975),
        ("half backlash", 0.5981619544103949),
    ];
    let pair = Oscillator::new(&constants).unwrap();
    let start = State::new(0.0, &[0.9224658404710873], &[-0.975898773178477]);
    let highest = |observe: &dyn Fn(&mut Statistics<'_>)| {
        let mut statistics = Statistics::new(&pair, &["v0"]).unwrap();
        observe(&mut statistics);
        let summary = statistics.summary("v0").unwrap();
        [summary.min, summary.max]
    };
    let end = 14.727637513083152;
    let found = highest(&|observer| drop(Taylor::new().run(&pair, &start, end, observer).unwrap()));
    let by_short_steps = Dop853::new().rtol(1e-12).atol(1e-14).max_step(0.05);
    let expected = highest(&|observer| drop(by_short_steps.run(&pair, &start, end, observer).unwrap()));
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-10, "{found} {expected}");
    }
}
