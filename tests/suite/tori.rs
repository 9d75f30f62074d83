//! Balance of tori: a reference torus, closed forms, long runs, errors.

use crate::api::*;
use crate::common::two_tones::{Forced, LinearTones, SlippingPair, TwoToneDuffing};
use crate::data::read;
use num_complex::Complex64;
use proptest::prelude::*;
use std::f64::consts::TAU;

fn within(highest: &[usize]) -> WaveVectors {
    WaveVectors::within(highest).unwrap()
}

/// q'' + 0.1 q' + q + 0.2 q³ with two tones.
fn duffing(phases: [f64; 2]) -> Forced<impl Fn(f64, f64) -> f64> {
    Forced {
        frequencies: vec![0.7, 0.7 * 3f64.sqrt()],
        phases,
        law: |q: f64, v: f64| -0.1 * v - q - 0.2 * q * q * q,
    }
}

#[test]
fn duffing_torus_of_the_reference() {
    let reference = &read("periodic_orbits.json")["extra"]["duffing_two_tone_torus"];
    let number = |name: &str| reference[name].as_f64().unwrap();
    let torus = TorusBalance::new(within(&[21, 21])).solve_from(&TwoToneDuffing, &[0.0]).unwrap();
    let coefficients = reference["coefs"].as_object().unwrap();
    assert_eq!(coefficients.len(), 10);
    for (key, values) in coefficients {
        let k: Vec<i32> = key.split(',').map(|k| k.parse().unwrap()).collect();
        let [a, b] = torus.coefficient(0, &k);
        for (ours, theirs) in [a, b, torus.amplitude(0, &k)].into_iter().zip(values.as_array().unwrap()) {
            assert!((ours - theirs.as_f64().unwrap()).abs() < 1e-12, "{key}: {ours} {theirs}");
        }
    }
    let start = torus.at(&[0.0, 0.0]);
    assert!((start.q[0] - number("x0")).abs() < 1e-10);
    assert!((start.v[0] - number("v0")).abs() < 1e-10);
    assert!((torus.rms(0) - number("rms")).abs() < 1e-14);
    assert!((torus.at_time(200.0).q[0] - number("x_at_t200")).abs() < 1e-10);
    assert!((torus.at_time(200.0).q[0] - number("x_at_t200_ode")).abs() < 1e-10);
    // The reference takes its maximum on a grid of 35 by 35 angles.
    assert!((torus.extremes(0, 35).unwrap()[1] - number("max_on_grid")).abs() < 1e-9);
    assert!(torus.residual() < 1e-11 && torus.aliasing() < 1e-14);
    assert!(torus.mean(0).abs() < 1e-15);
}

/// The residual between the nodes and the share of the outermost orders follow the error.
#[test]
fn measures_of_error_follow_the_error() {
    let x0 = read("periodic_orbits.json")["extra"]["duffing_two_tone_torus"]["x0"].as_f64().unwrap();
    // Measured: errors 2.5e-4, 9.1e-7, 3.5e-8, 7.6e-11; residuals 9.1e-5, 2.1e-6, 1.3e-8, 2.5e-10.
    let bounds =
        [(5, 3e-4, 1e-4, 2e-3), (9, 1e-6, 3e-6, 3e-5), (13, 4e-8, 2e-8, 2e-7), (17, 1e-10, 3e-10, 4e-9)];
    for (highest, error, residual, outermost) in bounds {
        let torus = TorusBalance::new(within(&[highest; 2])).solve_from(&TwoToneDuffing, &[0.0]).unwrap();
        assert!((torus.at(&[0.0; 2]).q[0] - x0).abs() < error, "{highest}");
        assert!(
            torus.residual_between() < residual && torus.residual_between() > 0.1 * residual,
            "{highest}"
        );
        assert!(
            torus.outermost_share() < outermost && torus.outermost_share() > 0.1 * outermost,
            "{highest}"
        );
        assert_eq!(torus.history().len(), torus.iterations() + 1);
        assert!(torus.evaluations() > torus.iterations());
    }
    // 2 H + 1 points along an angle alias cubic forces.
    let coarse =
        TorusBalance::new(within(&[5, 5])).oversampling(1).solve_from(&TwoToneDuffing, &[0.0]).unwrap();
    assert!(coarse.aliasing() > 1e-8, "{}", coarse.aliasing());
}

#[test]
fn linear_model_in_closed_form_with_one_two_and_three_angles() {
    for frequencies in [vec![0.8], vec![0.8, 2f64.sqrt()], vec![0.8, 2f64.sqrt(), 3f64.sqrt()]] {
        let (model, count) = (LinearTones { frequencies: frequencies.clone() }, frequencies.len());
        let torus = TorusBalance::new(within(&vec![2; count])).solve_from(&model, &[0.0, 0.0]).unwrap();
        assert!(torus.iterations() <= 2, "{:?}", torus.history());
        assert!((torus.mean(0) - 0.2).abs() < 1e-11 && (torus.mean(1) - 0.1).abs() < 1e-11);
        for (d, omega) in frequencies.iter().enumerate() {
            let (one, none) = (Complex64::new(1.0, 0.0), Complex64::new(0.0, 0.0));
            let force = if d == 0 { [one, none] } else { [none, -Complex64::i()] };
            let mut k = vec![0; count];
            k[d] = 1;
            for (j, c) in LinearTones::response(*omega, force).into_iter().enumerate() {
                let [a, b] = torus.coefficient(j, &k);
                // Re(c e^{iωt}) = Re c cos ωt - Im c sin ωt. The slopes are differences.
                assert!((Complex64::new(a, -b) - c).norm() < 1e-10, "{d} {j}: {a} {b} {c}");
            }
        }
        assert!(torus.residual_between() < 1e-9);
    }
}

/// With one angle the balance is that of periodic motions.
#[test]
fn one_angle_gives_the_periodic_balance() {
    struct Hard;
    impl Model for Hard {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            a[0] = u[0] - 0.2 * v[0] - q[0] - 0.5 * q[0].powi(3);
        }
        fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
            self.drive_at(&[0.6 * t], side, u);
        }
    }
    impl Periodic for Hard {
        fn period(&self) -> f64 {
            TAU / 0.6
        }
    }
    impl QuasiPeriodic for Hard {
        fn frequencies(&self) -> Vec<f64> {
            vec![0.6]
        }
        fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
            u[0] = 0.4 * angles[0].cos();
        }
    }
    let torus = TorusBalance::new(within(&[15])).solve_from(&Hard, &[0.0]).unwrap();
    let balance = Balance::new(Harmonics::up_to(15));
    let rest = FourierOrbit::new(balance.harmonics(), TAU / 0.6, &[vec![0.0; 31]]).unwrap();
    let orbit = balance.solve(&Hard, &rest).unwrap();
    for k in 0..=15 {
        assert!((torus.amplitude(0, &[k as i32]) - orbit.amplitude(0, k)).abs() < 1e-9, "{k}");
    }
}

/// Teeth in contact: the model is linear, its coefficients vary with both angles.
#[test]
fn gear_pair_in_contact_against_a_long_run() {
    let pair = SlippingPair::new(3.3, 6.8e-6 / 6.2e-4);
    // 40 time constants 1/(0.02/2): transients are below e^-40.
    let run = Dop853::new().rtol(1e-12).atol(1e-15).end(&pair, &SlippingPair::start(), 4000.0).unwrap();
    // Measured: 4.2e-6, 7.3e-7, 1.2e-8, 1.8e-10.
    for (highest, error) in [([2, 20], 5e-6), ([3, 30], 1e-6), ([4, 40], 2e-8), ([5, 60], 3e-10)] {
        let balance = TorusBalance::new(within(&highest));
        let torus = balance.solve_from(&pair, &[-1.1]).unwrap();
        assert_eq!(torus.iterations(), 1);
        let fixed = balance.linearised(&pair, Piece::Lower).unwrap();
        assert!((fixed.at(&[1.0, 2.0]).q[0] - torus.at(&[1.0, 2.0]).q[0]).abs() < 1e-13);
        assert!((torus.at_time(run.t).q[0] - run.q[0]).abs() < error, "{highest:?}");
        assert!(torus.extremes(0, 64).unwrap()[1] < -1.0); // the teeth touch throughout
    }
}

/// Teeth that lose contact: q'' has kinks, and the coefficients converge with a power of the orders.
#[test]
fn gear_pair_that_loses_contact_against_a_long_run() {
    let pair = SlippingPair::new(0.45, 6.8e-6 / 6.2e-4);
    let solver = Dop853::new().rtol(1e-9).atol(1e-12);
    let settled = solver.end(&pair, &SlippingPair::start(), 2800.0).unwrap();
    let times: Vec<f64> = (1..700).map(|k| settled.t + 10.123 * f64::from(k)).collect();
    let run = solver.sample(&pair, &settled, &times).unwrap();
    let states: Vec<State> = (0..run.len()).map(|i| run.state(i)).collect();
    // Measured: 1.6e-2 and 3.1e-3, with residuals of the equation between the points of 0.29 and 0.12.
    for (highest, error, residual) in [([5, 10], 0.02, 0.35), ([8, 20], 4e-3, 0.15)] {
        let guess = Torus::fit(&within(&highest), &pair.frequencies(), &states).unwrap();
        let torus = TorusBalance::new(within(&highest)).oversampling(4).solve(&pair, &guess).unwrap();
        let miss = states.iter().fold(0.0f64, |m, s| m.max((torus.at_time(s.t).q[0] - s.q[0]).abs()));
        assert!(miss < error && miss > 0.1 * error, "{miss}");
        assert!(torus.residual_between() < residual && torus.residual_between() > 0.3 * residual);
        assert!(torus.aliasing() > 1e-5 && torus.extremes(0, 64).unwrap()[1] > -0.6);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// Phases φ of the drives shift the torus: x_φ(θ) = x_0(θ + φ).
    #[test]
    fn phases_of_the_drives_shift_the_torus(a in 0.0..TAU, b in 0.0..TAU, c in 0.0..TAU, d in 0.0..TAU) {
        let balance = TorusBalance::new(within(&[6, 6]));
        let torus = balance.solve_from(&duffing([0.0; 2]), &[0.0]).unwrap();
        let shifted = balance.solve_from(&duffing([a, b]), &[0.0]).unwrap();
        let (here, there) = (shifted.at(&[c, d]), torus.at(&[a + c, b + d]));
        prop_assert!((here.q[0] - there.q[0]).abs() < 1e-9 && (here.v[0] - there.v[0]).abs() < 1e-9);
    }
}

#[test]
fn series_on_other_vectors_and_with_other_coefficients() {
    let small = within(&[2, 1]);
    let torus = Torus::constant(&small, &[1.0, 3f64.sqrt()], &[0.5, -1.0]).unwrap();
    let torus = torus.with(1, &[-1, 0], [0.25, 2.0]).unwrap();
    assert_eq!(torus.coefficient(1, &[-1, 0]), [0.25, 2.0]);
    assert_eq!(torus.coefficient(1, &[1, 0]), [0.25, -2.0]);
    assert_eq!(torus.coefficient(1, &[1, 1]), [0.0, 0.0]); // not kept
    assert_eq!((torus.mean(0), torus.mean(1)), (0.5, -1.0));
    let large = torus.on(&WaveVectors::in_box(&[3, 3]).unwrap());
    assert_eq!(large.on(&small).coefficient(1, &[1, 0]), [0.25, -2.0]);
    let state = large.at(&[0.3, 2.0]);
    assert!((state.q[1] - (-1.0 + 0.25 * 0.3f64.cos() - 2.0 * 0.3f64.sin())).abs() < 1e-15);
    assert!((state.v[1] - (-0.25 * 0.3f64.sin() - 2.0 * 0.3f64.cos())).abs() < 1e-15);
    assert_eq!(large.extremes(0, 5).unwrap(), [0.5, 0.5]);
    let amplitude = 4.0625f64.sqrt();
    assert!((large.peak_to_peak(1, 4096).unwrap() - 2.0 * amplitude).abs() < 1e-5);
    assert!((large.rms(1) - (1.0 + 0.5 * 4.0625f64).sqrt()).abs() < 1e-15);
    assert_eq!(large.smallest_rate().1, [2, -1]); // 2 - √3
    assert!(large.residual().is_nan() && large.residual_between().is_nan());

    let refused = |result: Result<Torus, ParameterError>| result.unwrap_err();
    assert!(matches!(
        refused(torus.clone().with(2, &[0, 0], [0.0; 2])),
        ParameterError::TooMany { value: 2, .. }
    ));
    assert!(matches!(refused(torus.clone().with(0, &[1, 1], [0.0; 2])), ParameterError::OutOfRange { .. }));
    assert!(matches!(
        refused(torus.clone().with(0, &[0, 0], [f64::NAN; 2])),
        ParameterError::NotFinite { .. }
    ));
    assert!(matches!(refused(Torus::constant(&small, &[1.0], &[0.0])), ParameterError::Length { .. }));
    assert!(matches!(
        refused(Torus::constant(&small, &[1.0, 0.0], &[0.0])),
        ParameterError::NotPositive { .. }
    ));
    assert!(matches!(refused(Torus::constant(&small, &[1.0, 2.0], &[])), ParameterError::Empty { .. }));
    assert!(matches!(torus.extremes(0, 0), Err(ParameterError::TooFew { .. })));
    assert!(matches!(torus.extremes(0, 1 << 20), Err(ParameterError::TooMany { .. })));
    assert!(matches!(torus.section(2, 5), Err(ParameterError::TooMany { value: 2, .. })));
    assert!(matches!(torus.section(0, 4), Err(ParameterError::OutOfRange { .. })));
}

#[test]
fn wave_vectors_are_counted_and_checked() {
    assert_eq!(within(&[9, 9]).len(), 91); // (2 H² + 2 H + 2)/2
    assert_eq!(WaveVectors::in_box(&[2, 2, 2]).unwrap().len(), 63); // (5³ + 1)/2
    assert_eq!(within(&[7]).len(), 8);
    assert!(!within(&[1]).is_empty() && within(&[3, 4]).highest() == [3, 4] && within(&[3, 4]).angles() == 2);
    assert!(matches!(WaveVectors::within(&[]), Err(ParameterError::Empty { .. })));
    assert!(matches!(WaveVectors::within(&[3, 0]), Err(ParameterError::TooFew { value: 0, .. })));
    assert!(matches!(WaveVectors::in_box(&[usize::MAX, 2]), Err(ParameterError::TooMany { .. })));
}

#[test]
fn invalid_settings_and_guesses() {
    let balance = TorusBalance::new(within(&[3, 3]));
    let model = duffing([0.0; 2]);
    let parameter = |balance: TorusBalance| match balance.solve_from(&model, &[0.0]).unwrap_err() {
        TorusError::Parameter(error) => error,
        other => panic!("{other}"),
    };
    assert!(matches!(parameter(balance.clone().oversampling(0)), ParameterError::TooFew { .. }));
    assert!(matches!(parameter(balance.clone().oversampling(65)), ParameterError::TooMany { max: 64, .. }));
    assert!(matches!(parameter(balance.clone().separation(1.0)), ParameterError::OutOfRange { .. }));
    assert!(matches!(parameter(TorusBalance::new(within(&[3]))), ParameterError::Length { .. }));
    assert!(matches!(parameter(TorusBalance::new(within(&[200, 200]))), ParameterError::TooMany { .. }));
    let wrong = balance.solve_from(&model, &[0.0, 0.0]).unwrap_err();
    assert_eq!(wrong, TorusError::Coordinates { expected: 1, found: 2 });
    assert!(wrong.last().is_none());
    let loose = balance.clone().newton(Newton::new().tolerance(2.0));
    assert!(matches!(loose.solve_from(&model, &[0.0]), Err(TorusError::Root(RootError::Setting { .. }))));
    let states: Vec<State> = (0..20).map(|k| State::new(f64::from(k), &[1.0], &[0.0])).collect();
    let fit = |states: &[State]| Torus::fit(&within(&[3, 3]), &[1.0, 3f64.sqrt()], states).unwrap_err();
    assert_eq!(fit(&states), TorusError::Unspread { states: 20, unknowns: 25 });
    // At times 2πk the first angle is always 0.
    let periodic: Vec<State> = (0..200).map(|k| State::new(TAU * f64::from(k), &[1.0], &[0.0])).collect();
    assert_eq!(fit(&periodic), TorusError::Unspread { states: 200, unknowns: 25 });
    assert!(matches!(fit(&[]), TorusError::Parameter(ParameterError::Empty { .. })));
}

#[test]
fn drives_that_are_no_functions_of_the_angles() {
    struct Drives(fn(&[f64]) -> f64, fn(f64) -> f64, Vec<f64>, Option<f64>);
    impl Model for Drives {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            a[0] = u[0] - q[0] - 0.1 * v[0];
        }
        fn drive(&self, t: f64, _: Side, u: &mut [f64]) {
            u[0] = self.1(t);
        }
        fn next_edge(&self, _: f64) -> Option<f64> {
            self.3
        }
    }
    impl QuasiPeriodic for Drives {
        fn frequencies(&self) -> Vec<f64> {
            self.2.clone()
        }
        fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
            u[0] = self.0(angles);
        }
    }
    let both = vec![1.0, 3f64.sqrt()];
    let error = |model: Drives| match TorusBalance::new(within(&[2, 2])).solve_from(&model, &[0.0]) {
        Err(TorusError::Drives(error)) => error,
        other => panic!("{other:?}"),
    };
    let apart = error(Drives(|angles| angles[0].cos(), f64::sin, both.clone(), None));
    assert!(matches!(apart, QuasiPeriodicError::DriveMismatch { drive: 0, .. }));
    let runs_on = error(Drives(|angles| 0.5 * angles[0], |t| 0.5 * t, both.clone(), None));
    assert!(matches!(
        runs_on,
        QuasiPeriodicError::NotPeriodic { drive: 0, angle: 0, change } if (change - 0.5 * TAU).abs() < 1e-9
    ));
    let edge = error(Drives(|angles| angles[0].cos(), f64::cos, both, Some(1.5)));
    assert_eq!(edge, QuasiPeriodicError::EdgeNotAtAngles { edge: 1.5 });
    let none = error(Drives(|_| 0.0, |_| 0.0, vec![], None));
    assert!(matches!(none, QuasiPeriodicError::Frequency(ParameterError::Empty { .. })));
    let negative = error(Drives(|_| 0.0, |_| 0.0, vec![1.0, -2.0], None));
    assert!(matches!(negative, QuasiPeriodicError::Frequency(ParameterError::NotPositive { .. })));
}

#[test]
fn commensurate_frequencies_are_refused_by_name() {
    let model =
        Forced { frequencies: vec![1.0, 1.5 + 1e-8], phases: [0.0; 2], law: |q: f64, v: f64| -q - 0.3 * v };
    let balance = TorusBalance::new(within(&[6, 6]));
    let error = balance.solve_from(&model, &[0.0]).unwrap_err();
    let TorusError::Commensurate { vector, rate, limit } = error else { panic!("{error}") };
    assert_eq!(vector, [3, -2]);
    assert!((rate - 2e-8).abs() < 1e-14 && (limit - 1.5e-6).abs() < 1e-13);
    // Fewer orders, or a smaller separation, accept the frequencies.
    assert!(TorusBalance::new(within(&[4, 4])).solve_from(&model, &[0.0]).is_ok());
    assert_eq!(balance.separation(0.0).solve_from(&model, &[0.0]).unwrap().smallest_rate().1, [3, -2]);
}

#[test]
fn iterations_that_fail_keep_the_last_iterate() {
    let balance = TorusBalance::new(within(&[4, 4]));
    let model = duffing([0.0; 2]);
    let one = balance.clone().newton(Newton::new().max_iterations(1)).solve_from(&model, &[0.0]).unwrap_err();
    assert!(matches!(&one, TorusError::NotConverged { last } if last.history().len() == 2));
    assert!(one.last().unwrap().amplitude(0, &[1, 0]) > 0.1);

    let spent = balance.clone().budget(Budget::new().steps(2)).solve_from(&model, &[0.0]).unwrap_err();
    let TorusError::Budget { exhausted, last } = spent else { panic!("{spent}") };
    assert_eq!(exhausted, Exhausted::Steps { limit: 2 });
    assert!(last.history()[0].is_finite());

    // Nothing restores the mean in the gap.
    let pair = SlippingPair::new(0.45, 0.01);
    assert!(matches!(balance.linearised(&pair, Piece::Gap), Err(TorusError::Undetermined { .. })));
    let gap = balance.solve_from(&pair, &[0.0]).unwrap_err();
    assert!(matches!(gap, TorusError::Undetermined { coordinate: 0, ref vector, .. } if vector == &[0, 0]));

    let law = |q: f64, _: f64| if q.abs() > 1e-3 { f64::NAN } else { -q };
    let nan = Forced { frequencies: model.frequencies.clone(), phases: [0.0; 2], law };
    assert!(matches!(balance.solve_from(&nan, &[1.0]), Err(TorusError::NotFinite { .. })));

    struct Steep(Forced<fn(f64, f64) -> f64>, usize);
    impl Model for Steep {
        fn contacts(&self) -> usize {
            self.1
        }
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            self.0.accel(u, q, v, a);
        }
        fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
            self.0.drive(t, side, u);
        }
        fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], _: &[f64], _: &[f64], out: &mut Jacobian) -> bool {
            out.q[(0, 0)] = f64::NEG_INFINITY;
            true
        }
    }
    impl QuasiPeriodic for Steep {
        fn frequencies(&self) -> Vec<f64> {
            self.0.frequencies()
        }
        fn drive_at(&self, angles: &[f64], side: Side, u: &mut [f64]) {
            self.0.drive_at(angles, side, u);
        }
    }
    let steep = Steep(
        Forced { frequencies: model.frequencies.clone(), phases: [0.0; 2], law: |q, v| -q - 0.1 * v },
        0,
    );
    let error = balance.solve_from(&steep, &[0.0]).unwrap_err();
    assert!(matches!(error, TorusError::Slope { acceleration: 0, coordinate: 0, .. }), "{error}");
    // A contact without laws on fixed pieces.
    assert_eq!(balance.linearised(&Steep(steep.0, 1), Piece::Lower), Err(TorusError::NotAvailable));
}

#[test]
fn rigid_stops_are_refused() {
    struct Ball;
    impl Model for Ball {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = u[0] - 1.0;
        }
        fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
            self.drive_at(&[t, 3f64.sqrt() * t], side, u);
        }
        fn contacts(&self) -> usize {
            1
        }
        fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            out[0] = Contact { deflection: q[0], rate: v[0], lower: 0.0, ..Contact::default() };
        }
        fn impact(&self, _: usize, on: Piece, _: &[f64], _: &[f64], v: &mut [f64]) -> bool {
            v[0] = -0.5 * v[0];
            on == Piece::Lower
        }
    }
    impl QuasiPeriodic for Ball {
        fn frequencies(&self) -> Vec<f64> {
            vec![1.0, 3f64.sqrt()]
        }
        fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
            u[0] = 0.1 * (angles[0].cos() + angles[1].cos());
        }
    }
    let balance = TorusBalance::new(within(&[3, 3]));
    assert_eq!(balance.solve_from(&Ball, &[1.0]), Err(TorusError::RigidStop { contact: 0 }));
    assert_eq!(balance.linearised(&Ball, Piece::Gap), Err(TorusError::RigidStop { contact: 0 }));
}
