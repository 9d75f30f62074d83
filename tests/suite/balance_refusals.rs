//! Balances that are refused or fail, and what their errors say.

use crate::api::*;
use crate::balance::{pair, projected};
use crate::common::oscillators::CubicChain;
use num_complex::Complex64;
use std::f64::consts::TAU;

#[test]
fn empty_or_repeated_orders_are_refused() {
    assert!(matches!(Harmonics::of_orders(&[]), Err(ParameterError::Empty { .. })));
    assert!(matches!(Harmonics::of_orders(&[0, 2, 1, 2]), Err(ParameterError::Wrong { value: 2.0, .. })));
    assert!(matches!(Harmonics::bands(0, 1, 2), Err(ParameterError::TooFew { .. })));
    assert!(matches!(Harmonics::up_to(3).with_period_multiple(0), Err(ParameterError::TooFew { .. })));
}

#[test]
fn too_few_samples_are_refused() {
    let pair = pair(120.0);
    let balance = Balance::new(Harmonics::bands(63, 1, 2).unwrap());
    let flank = balance.linearised(&pair, Piece::Lower).unwrap();
    let error =
        balance.clone().integrals(Integrals::Sampled { samples: 130 }).solve(&pair, &flank).unwrap_err();
    assert_eq!(error, BalanceError::Samples { samples: 130, highest: 65 });
}

#[test]
fn start_in_the_gap_is_explained() {
    let pair = pair(120.0);
    let gap = FourierOrbit::new(&Harmonics::up_to(0), pair.period(), &[vec![0.0]]).unwrap();
    for balance in
        [Balance::new(Harmonics::up_to(70)), Balance::new(Harmonics::up_to(70)).root_finder(Broyden::new())]
    {
        let error = balance.solve(&pair, &gap).unwrap_err();
        assert!(matches!(error, BalanceError::StartInGap { contact: 0 }));
        assert!(error.to_string().contains("nothing restores the mean"));
    }
    assert!(matches!(
        Balance::new(Harmonics::up_to(70)).linearised(&pair, Piece::Gap),
        Err(BalanceError::StartInGap { contact: 0 })
    ));
}

#[test]
fn floating_coordinate_is_named() {
    /// No force acts on the coordinate but that of time.
    struct Loose;
    impl Model for Loose {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = 0.5 * u[0].cos();
        }
    }
    impl Periodic for Loose {
        fn period(&self) -> f64 {
            TAU
        }
    }
    let guess = FourierOrbit::new(&Harmonics::up_to(1), TAU, &[vec![0.1, 0.0, 1.0]]).unwrap();
    let error = Balance::new(Harmonics::up_to(3)).solve(&Loose, &guess).unwrap_err();
    assert!(matches!(error, BalanceError::Singular { coordinate: 0, .. }), "{error}");
    assert!(error.to_string().contains("neither a stiffness nor a drag acts on its mean"), "{error}");
}

/// A motor, q_0' its speed and q_1' its current i: 0.01 q_0'' = 0.5 i - 0.1 q_0', 0.05 i' = U + cos t - i - 0.5 q_0'.
#[test]
fn a_current_is_found_by_every_solver() {
    for mean in [12.0, 0.0] {
        let motor = from_fn(2, move |t, _, v, a| {
            a[0] = (0.5 * v[1] - 0.1 * v[0]) / 0.01;
            a[1] = (mean + t.cos() - v[1] - 0.5 * v[0]) / 0.05;
        });
        let motor = motor.unwrap().with_period(TAU).unwrap();
        let balance = Balance::new(Harmonics::up_to(3));
        let guess = balance.linearised(&motor, Piece::Upper).unwrap();
        let series = balance.solve(&motor, &guess).unwrap();
        // (1 + 0.05 s) i + 0.5 w = U and (0.1 + 0.01 s) w = 0.5 i: i and w at the order s = i of the drive.
        let s = Complex64::i();
        let slip = 0.5 / (0.1 + 0.01 * s);
        let current = 1.0 / (1.0 + 0.05 * s + 0.5 * slip);
        let exact = [(slip * current).re + mean * 5.0 / 3.5, current.re + mean / 3.5];
        let state = Dop853::new().rtol(1e-10).atol(1e-12).end(&motor, &State::at_rest(2), 5.0 * TAU).unwrap();
        assert!((state.v[0] - exact[0]).abs() < 1e-6 && (state.v[1] - exact[1]).abs() < 1e-6, "{state:?}");
        let settled = Settle::new().tolerance(1e-6).run(&Dop853::new(), &motor, &State::at_rest(2)).unwrap();
        let orbit = Shooting::new().solve(&motor, &State::at_rest(2)).unwrap();
        for (state, most) in [(&settled.state, 1e-5), (&orbit.states()[0], 1e-9), (&series.at(0.0), 1e-11)] {
            let apart = [state.v[0] - exact[0], state.v[1] - exact[1]].map(f64::abs);
            assert!(apart.iter().all(|apart| *apart < most), "{apart:?}");
        }
    }
}

#[test]
fn no_convergence_hands_back_the_last_iterate() {
    let pair = pair(200.0);
    let balance =
        Balance::new(Harmonics::bands(63, 1, 2).unwrap()).root_finder(Newton::new().max_iterations(2));
    let error = balance.solve(&pair, &balance.linearised(&pair, Piece::Lower).unwrap()).unwrap_err();
    let BalanceError::NotConverged { last, residuals } = error else { panic!("{error}") };
    assert_eq!(last.dof(), 1);
    assert_eq!(residuals.len(), last.iterations() + 1);
}

#[test]
fn integrals_that_are_not_offered_are_refused() {
    let model = CubicChain { omega: 1.0 };
    let guess =
        FourierOrbit::new(&Harmonics::up_to(1), model.period(), &[vec![0.0, 0.1, 0.1], vec![0.0, 0.1, 0.1]])
            .unwrap();
    for integrals in [Integrals::Closed, Integrals::Kinks] {
        let error = Balance::new(Harmonics::up_to(3)).integrals(integrals).solve(&model, &guess).unwrap_err();
        assert_eq!(error, BalanceError::NotAvailable { integrals });
    }
    let integrals = Integrals::Panels;
    let error = Balance::new(Harmonics::up_to(70))
        .integrals(integrals)
        .truncated_forces()
        .solve(&pair(120.0), &projected(&pair(120.0), &Harmonics::up_to(3)))
        .unwrap_err();
    assert_eq!(error, BalanceError::NoLaws { integrals });
    // A model without a Jacobian: differences, and a note.
    let orbit = Balance::new(Harmonics::up_to(5)).solve(&model, &guess).unwrap();
    assert_eq!(orbit.notes(), [BalanceNote::Differences]);
}

#[test]
fn orbit_of_another_model_is_refused() {
    let guess =
        FourierOrbit::new(&Harmonics::up_to(1), 1.0, &[vec![0.0, 0.1, 0.1], vec![0.0, 0.1, 0.1]]).unwrap();
    let error = Balance::new(Harmonics::up_to(3)).solve(&pair(120.0), &guess).unwrap_err();
    assert!(matches!(error, BalanceError::Parameter(ParameterError::Length { expected: 1, found: 2, .. })));
    assert!(FourierOrbit::new(&Harmonics::up_to(1), 1.0, &[vec![0.0]]).is_err());
    assert!(FourierOrbit::new(&Harmonics::up_to(0), f64::NAN, &[vec![0.0]]).is_err());
    assert!(FourierOrbit::new(&Harmonics::up_to(0), 1.0, &[vec![f64::NAN]]).is_err());
}

#[test]
fn orbits_of_another_model_are_refused_by_name() {
    let (pair, chain) = (pair(120.0), CubicChain { omega: 1.0 });
    let orbit =
        FourierOrbit::new(&Harmonics::up_to(1), 1.0, &[vec![0.0, 0.1, 0.1], vec![0.0, 0.1, 0.1]]).unwrap();
    assert!(matches!(orbit.contacts(&pair), Err(ParameterError::Length { .. })));
    let multipliers =
        |model: &dyn Periodic| Balance::new(orbit.harmonics().clone()).multipliers(model, &orbit);
    assert!(matches!(
        multipliers(&pair),
        Err(MultiplierError::Parameter(ParameterError::Length { expected: 1, found: 2, .. }))
    ));
    assert!(multipliers(&chain).is_ok());
    assert!(Shooting::new().solve_from(&pair, &orbit).is_err());
    assert!(FourierOrbit::project(&Dop853::new(), &pair, &State::at_rest(2), &Harmonics::up_to(1)).is_err());
    let balance = Balance::new(Harmonics::up_to(3));
    assert!(matches!(
        balance.error_estimate(&pair, &orbit),
        Err(BalanceError::Parameter(ParameterError::Length { expected: 1, found: 2, .. }))
    ));
}

/// The debug text of an error does not contain the coefficients.
#[test]
fn errors_print_shortly() {
    let pair = pair(200.0);
    let balance = Balance::new(Harmonics::up_to(150)).root_finder(Newton::new().max_iterations(2));
    let error = balance.solve(&pair, &balance.linearised(&pair, Piece::Lower).unwrap()).unwrap_err();
    let text = format!("{error:?}");
    assert!(
        matches!(error, BalanceError::NotConverged { .. })
            && text.len() < 600
            && text.contains("highest: 150"),
        "{text}"
    );
}

/// q'' = cos t - 4 q: order 2 is at the natural frequency 2, without damping.
#[test]
fn a_resonance_without_damping_is_named() {
    let swing = gear_dynamics::model::from_fn(1, |t, q, _, a| a[0] = t.cos() - 4.0 * q[0]).unwrap();
    let swing = swing.with_period(TAU).unwrap();
    let error = Balance::new(Harmonics::up_to(5)).solve(&swing, None).unwrap_err();
    assert!(matches!(error, BalanceError::Singular { coordinate: 0, order: 2, .. }), "{error}");
    assert!(error.to_string().contains("resonance without damping"), "{error}");
}

/// q'' = cos t + 0.2 cos w t - w² q and two coupled bodies whose slower mode is at w: whether rounding errors make
/// the Jacobian singular differs from order to order. A mode that no drive excites is not determined either. Order 8 is
/// not kept, and a spring that stiffens limits the motion: neither is a resonance.
#[test]
fn a_resonance_at_any_order_is_named() {
    use gear_dynamics::model::from_fn;
    let balance = Balance::new(Harmonics::up_to(7));
    for order in 1..=8 {
        let w = order as f64;
        let (one, two) = (w * w, 1.69 * w * w);
        let swing = from_fn(1, move |t, q, _, a| a[0] = t.cos() + 0.2 * (w * t).cos() - one * q[0]).unwrap();
        let quiet = from_fn(1, move |t, q, _, a| {
            a[0] = (if order == 1 { 2.0 * t } else { t }).cos() - one * q[0];
        });
        let pair = from_fn(2, move |t, q, _, a| {
            let (sum, twist) = (one * (q[0] + q[1]), two * (q[0] - q[1]));
            a[0] = t.cos() + 0.2 * (w * t).sin() - 0.5 * (sum + twist);
            a[1] = -0.5 * (sum - twist);
        });
        let models: [(&str, Result<FourierOrbit, BalanceError>); 3] = [
            ("swing", balance.solve(&swing.with_period(TAU).unwrap(), None)),
            ("quiet", balance.solve(&quiet.unwrap().with_period(TAU).unwrap(), None)),
            ("pair", balance.solve(&pair.unwrap().with_period(TAU).unwrap(), None)),
        ];
        for (name, found) in models {
            match found {
                Ok(orbit) => assert!(order == 8 && orbit.residual() < 1e-9, "{name} {order}"),
                Err(BalanceError::Singular { order: named, .. }) => assert_eq!(named, order, "{name}"),
                Err(error) => panic!("{name} at order {order}: {error}"),
            }
        }
    }
    let stiffening = from_fn(1, |t, q, _, a| a[0] = t.cos() - 4.0 * q[0] - q[0] * q[0] * q[0]).unwrap();
    let found = balance.solve(&stiffening.with_period(TAU).unwrap(), None);
    assert!(!matches!(found, Err(BalanceError::Singular { .. })), "{found:?}");
}

/// q0'' = 1 beside q1'' = cos t - 4 q1 - 0.1 q1': nothing holds q0, and its velocity grows by 2π in every period.
#[test]
fn an_unconnected_body_that_accelerates_is_refused() {
    use gear_dynamics::model::from_fn;
    let balance = Balance::new(Harmonics::up_to(7));
    let beside = |mean: f64| {
        let model = from_fn(2, move |t, q, v, a| {
            (a[0], a[1]) = (mean + (2.0 * t).cos(), t.cos() - 4.0 * q[1] - 0.1 * v[1]);
        });
        balance.solve(&model.unwrap().with_period(TAU).unwrap(), None)
    };
    let error = beside(1.0).unwrap_err();
    let BalanceError::Accelerates { coordinate: 0, gain, .. } = error else { panic!("{error}") };
    assert!((gain - TAU).abs() < 1e-9);
    assert!((beside(0.0).unwrap().at(0.0).q[0] + 0.25).abs() < 1e-9);
}

/// Another period than that of the forces is refused, also if it is off by a thousandth.
#[test]
fn a_wrong_period_is_refused() {
    use gear_dynamics::model::from_fn;
    let forced = |period: f64| {
        let model = from_fn(1, |t, q, v, a| a[0] = (2.0 * t).cos() - 0.1 * v[0] - q[0]).unwrap();
        Balance::new(Harmonics::up_to(10)).solve(&model.with_period(period).unwrap(), None)
    };
    for period in [3.0, 0.5 * std::f64::consts::PI, 3.13, 180.0] {
        let error = forced(period).unwrap_err().to_string();
        assert!(error.starts_with("period of the model is "), "{period}: {error}");
    }
    // Two periods are a period, too.
    assert!(forced(TAU).is_ok());
}
