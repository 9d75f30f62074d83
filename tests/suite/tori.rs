//! Balance of tori: a reference torus, closed forms, long runs.

use crate::api::*;
use crate::common::two_tones::{LinearTones, SlippingPair, TwoToneDuffing, duffing, from_rest, within};
use crate::data::read;
use num_complex::Complex64;
use proptest::prelude::*;
use std::f64::consts::TAU;

#[test]
fn duffing_torus_of_the_reference() {
    let reference = &read("periodic_orbits.json")["extra"]["duffing_two_tone_torus"];
    let number = |name: &str| reference[name].as_f64().unwrap();
    let torus = from_rest(&TorusBalance::new(within(&[21, 21])), &TwoToneDuffing, &[0.0]).unwrap();
    let coefficients = reference["coefs"].as_object().unwrap();
    assert_eq!(coefficients.len(), 10);
    for (key, values) in coefficients {
        let k: Vec<i32> = key.split(',').map(|k| k.parse().unwrap()).collect();
        let [a, b] = torus.coefficient(0, &k);
        for (ours, theirs) in [a, b, torus.amplitude(0, &k)].into_iter().zip(values.as_array().unwrap()) {
            assert!((ours - theirs.as_f64().unwrap()).abs() < 1e-12, "{key}: {ours} {theirs}");
        }
    }
    let start = torus.at_angles(&[0.0, 0.0]);
    assert!((start.q[0] - number("x0")).abs() < 1e-10);
    assert!((start.v[0] - number("v0")).abs() < 1e-10);
    assert!((torus.rms(0) - number("rms")).abs() < 1e-14);
    assert!((torus.at(200.0).q[0] - number("x_at_t200")).abs() < 1e-10);
    assert!((torus.at(200.0).q[0] - number("x_at_t200_ode")).abs() < 1e-10);
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
        let torus = from_rest(&TorusBalance::new(within(&[highest; 2])), &TwoToneDuffing, &[0.0]).unwrap();
        assert!((torus.at_angles(&[0.0; 2]).q[0] - x0).abs() < error, "{highest}");
        assert!(
            torus.residual_between() < residual && torus.residual_between() > 0.1 * residual,
            "{highest}"
        );
        assert!(
            torus.outermost_share() < outermost && torus.outermost_share() > 0.1 * outermost,
            "{highest}"
        );
        assert_eq!(torus.residuals().len(), torus.iterations() + 1);
        assert!(torus.evaluations() > torus.iterations());
    }
    // 2 H + 1 points along an angle alias cubic forces.
    let coarse =
        from_rest(&TorusBalance::new(within(&[5, 5])).oversampling(1), &TwoToneDuffing, &[0.0]).unwrap();
    assert!(coarse.aliasing() > 1e-8, "{}", coarse.aliasing());
}

#[test]
fn linear_model_in_closed_form_with_one_two_and_three_angles() {
    for frequencies in [vec![0.8], vec![0.8, 2f64.sqrt()], vec![0.8, 2f64.sqrt(), 3f64.sqrt()]] {
        let (model, count) = (LinearTones { frequencies: frequencies.clone() }, frequencies.len());
        let torus = from_rest(&TorusBalance::new(within(&vec![2; count])), &model, &[0.0, 0.0]).unwrap();
        assert!(torus.iterations() <= 2, "{:?}", torus.residuals());
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
    let torus = from_rest(&TorusBalance::new(within(&[15])), &Hard, &[0.0]).unwrap();
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
        let torus = from_rest(&balance, &pair, &[-1.1]).unwrap();
        assert_eq!(torus.iterations(), 1);
        let fixed = balance.linearised(&pair, Piece::Lower).unwrap();
        assert!((fixed.at_angles(&[1.0, 2.0]).q[0] - torus.at_angles(&[1.0, 2.0]).q[0]).abs() < 1e-13);
        assert!((torus.at(run.t).q[0] - run.q[0]).abs() < error, "{highest:?}");
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
        let miss = states.iter().fold(0.0f64, |m, s| m.max((torus.at(s.t).q[0] - s.q[0]).abs()));
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
        let torus = from_rest(&balance, &duffing([0.0; 2]), &[0.0]).unwrap();
        let shifted = from_rest(&balance, &duffing([a, b]), &[0.0]).unwrap();
        let (here, there) = (shifted.at_angles(&[c, d]), torus.at_angles(&[a + c, b + d]));
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
    let state = large.at_angles(&[0.3, 2.0]);
    assert!((state.q[1] - (-1.0 + 0.25 * 0.3f64.cos() - 2.0 * 0.3f64.sin())).abs() < 1e-15);
    assert!((state.v[1] - (-0.25 * 0.3f64.sin() - 2.0 * 0.3f64.cos())).abs() < 1e-15);
    assert_eq!(large.extremes(0, 5).unwrap(), [0.5, 0.5]);
    let amplitude = 4.0625f64.sqrt();
    // On n points a maximum of A cos x is found to A π²/(2 n²).
    assert!((large.peak_to_peak(1, 1500).unwrap() - 2.0 * amplitude).abs() < 1e-5);
    assert!((large.rms(1) - (1.0 + 0.5 * 4.0625f64).sqrt()).abs() < 1e-15);
    assert_eq!(large.smallest_rate().1, [2, -1]); // 2 - √3
    assert!(large.residual().is_nan() && large.residual_between().is_nan());

    let refused = |result: Result<Torus, ParameterError>| result.unwrap_err();
    assert!(matches!(
        refused(torus.clone().with(2, &[0, 0], [0.0; 2])),
        ParameterError::TooMany { value: 2, .. }
    ));
    assert!(matches!(refused(torus.clone().with(0, &[1, 1], [0.0; 2])), ParameterError::Wrong { .. }));
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
    assert!(matches!(torus.section(0, 4), Err(ParameterError::Wrong { .. })));
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
