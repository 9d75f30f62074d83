//! Refusals and failures of balances of tori and of invariant circles: every error by name.

use crate::api::*;
use crate::common::two_tones::{
    Forced, PeriodicallyForced, SlippingPair, TwoToneDuffing, duffing, from_rest, round, van_der_pol, within,
};
use std::f64::consts::TAU;

#[test]
fn invalid_settings_and_guesses_of_tori() {
    let balance = TorusBalance::new(within(&[3, 3]));
    let model = duffing([0.0; 2]);
    let parameter = |balance: TorusBalance| match from_rest(&balance, &model, &[0.0]).unwrap_err() {
        TorusError::Parameter(error) => error,
        other => panic!("{other}"),
    };
    assert!(matches!(parameter(balance.clone().oversampling(0)), ParameterError::TooFew { .. }));
    assert!(matches!(parameter(balance.clone().oversampling(65)), ParameterError::TooMany { max: 64, .. }));
    assert!(matches!(parameter(balance.clone().separation(1.0)), ParameterError::OutOfRange { .. }));
    assert!(matches!(parameter(TorusBalance::new(within(&[3]))), ParameterError::Length { .. }));
    assert!(matches!(parameter(TorusBalance::new(within(&[200, 200]))), ParameterError::TooMany { .. }));
    let wrong = from_rest(&balance, &model, &[0.0, 0.0]).unwrap_err();
    assert!(matches!(wrong, TorusError::Parameter(ParameterError::Length { expected: 1, found: 2, .. })));
    assert!(wrong.last().is_none());
    let loose = balance.clone().newton(Newton::new().tolerance(2.0));
    assert!(matches!(
        from_rest(&loose, &model, &[0.0]),
        Err(TorusError::Parameter(ParameterError::OutOfRange { .. }))
    ));
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
    let error = |model: Drives| match from_rest(&TorusBalance::new(within(&[2, 2])), &model, &[0.0]) {
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
    assert!(matches!(none, QuasiPeriodicError::Parameter(ParameterError::Empty { .. })));
    let negative = error(Drives(|_| 0.0, |_| 0.0, vec![1.0, -2.0], None));
    assert!(matches!(negative, QuasiPeriodicError::Parameter(ParameterError::NotPositive { .. })));
}

#[test]
fn commensurate_frequencies_are_refused_by_name() {
    let model =
        Forced { frequencies: vec![1.0, 1.5 + 1e-8], phases: [0.0; 2], law: |q: f64, v: f64| -q - 0.3 * v };
    let balance = TorusBalance::new(within(&[6, 6]));
    let error = from_rest(&balance, &model, &[0.0]).unwrap_err();
    let TorusError::Commensurate { vector, rate, limit } = error else { panic!("{error}") };
    assert_eq!(vector, [3, -2]);
    assert!((rate - 2e-8).abs() < 1e-14 && (limit - 1.5e-6).abs() < 1e-13);
    // Fewer orders, or a smaller separation, accept the frequencies.
    assert!(from_rest(&TorusBalance::new(within(&[4, 4])), &model, &[0.0]).is_ok());
    assert_eq!(from_rest(&balance.separation(0.0), &model, &[0.0]).unwrap().smallest_rate().1, [3, -2]);
}

#[test]
fn iterations_that_fail_keep_the_last_iterate() {
    let balance = TorusBalance::new(within(&[4, 4]));
    let model = duffing([0.0; 2]);
    let one =
        from_rest(&balance.clone().newton(Newton::new().max_iterations(1)), &model, &[0.0]).unwrap_err();
    assert!(matches!(&one, TorusError::NotConverged { last } if last.residuals().len() == 2));
    assert!(one.last().unwrap().amplitude(0, &[1, 0]) > 0.1);

    let spent = from_rest(&balance.clone().budget(Budget::new().steps(2)), &model, &[0.0]).unwrap_err();
    let TorusError::Exhausted { exhausted, last } = spent else { panic!("{spent}") };
    assert_eq!(exhausted, Exhausted::Steps { limit: 2 });
    assert!(last.residuals()[0].is_finite());

    // Nothing restores the mean in the gap.
    let pair = SlippingPair::new(0.45, 0.01);
    assert!(matches!(balance.linearised(&pair, Piece::Gap), Err(TorusError::Singular { .. })));
    let gap = from_rest(&balance, &pair, &[0.0]).unwrap_err();
    assert!(matches!(gap, TorusError::Singular { coordinate: 0, ref vector, .. } if vector == &[0, 0]));

    let law = |q: f64, _: f64| if q.abs() > 1e-3 { f64::NAN } else { -q };
    let nan = Forced { frequencies: model.frequencies.clone(), phases: [0.0; 2], law };
    assert!(matches!(from_rest(&balance, &nan, &[1.0]), Err(TorusError::NotFinite { .. })));

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
        fn offers(&self) -> Offers<'_> {
            Offers { jacobian: true, ..Offers::default() }
        }
        fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
            self.0.drive(t, side, u);
        }
        fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], _: &[f64], _: &[f64], out: &mut Jacobian) {
            out.q[(0, 0)] = f64::NEG_INFINITY;
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
    let error = from_rest(&balance, &steep, &[0.0]).unwrap_err();
    assert!(matches!(error, TorusError::Slope { acceleration: 0, coordinate: 0, .. }), "{error}");
    // A contact without laws on fixed pieces.
    assert_eq!(balance.linearised(&Steep(steep.0, 1), Piece::Lower), Err(TorusError::NoPieces));
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
        fn offers(&self) -> Offers<'_> {
            Offers { stops: &[[true, false]], ..Offers::default() }
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
        fn impact(&self, _: usize, _: Piece, _: &[f64], _: &[f64], v: &mut [f64]) {
            v[0] *= -0.5;
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
    assert_eq!(from_rest(&balance, &Ball, &[1.0]), Err(TorusError::RigidStop { contact: 0 }));
    assert_eq!(balance.linearised(&Ball, Piece::Gap), Err(TorusError::RigidStop { contact: 0 }));
}

#[test]
fn curves_are_checked() {
    let state = |q: f64| State::new(0.0, &[q], &[0.0]);
    let refused = |states: &[State]| ClosedCurve::new(states).unwrap_err();
    assert!(matches!(refused(&[state(0.0), state(1.0)]), ParameterError::TooFew { value: 2, min: 3, .. }));
    assert!(matches!(refused(&[0.0, 1.0, 2.0, 3.0].map(state)), ParameterError::Wrong { .. }));
    let late = State { t: 1.0, ..state(0.0) };
    let error = refused(&[state(0.0), state(1.0), late]);
    assert!(error.to_string().starts_with("time of state 2 is "), "{error}");
    assert!(error.to_string().contains(": it must be "), "{error}");
    assert!(matches!(refused(&[0.0, f64::NAN, 2.0].map(state)), ParameterError::NotFinite { .. }));
    assert!(matches!(refused(&[0, 1, 2].map(|_| State::at_rest(0))), ParameterError::TooFew { .. }));
    assert!(matches!(round(5, 1.0).with_nodes(8), Err(ParameterError::Wrong { .. })));
    let line: Vec<State> = (0..50).map(|k| state(f64::from(k).sin())).collect();
    assert!(matches!(rotation_number(&line), Err(ParameterError::NotPositive { .. })));
    assert!(matches!(rotation_number(&line[..3]), Err(ParameterError::TooFew { min: 16, .. })));
    // Points of period 3 determine 3 nodes and no more.
    let three: Vec<State> = (0..90).map(|k| state((f64::from(k) * TAU / 3.0).cos())).collect();
    let error = ClosedCurve::fit(&three, TAU / 3.0, 0.0, 5).unwrap_err();
    assert!(matches!(error, CircleError::Unspread { points: 90, nodes: 5, .. }));
    assert!(ClosedCurve::fit(&three, TAU / 3.0, 0.0, 3).is_ok());
    let few = ClosedCurve::fit(&three[..4], 1.0, 0.0, 5).unwrap_err();
    assert!(matches!(few, CircleError::Unspread { points: 4, .. }));
    let empty = ClosedCurve::fit(&vec![State::at_rest(0); 9], 1.0, 0.0, 5).unwrap_err();
    assert!(matches!(empty, CircleError::Parameter(ParameterError::TooFew { value: 0, min: 1, .. })));
    let none = ClosedCurve::fit(&[], 1.0, 0.0, 5).unwrap_err();
    assert!(matches!(none, CircleError::Parameter(ParameterError::Empty { .. })));
}

#[test]
fn invalid_settings_and_guesses_of_circles() {
    let guess = round(5, 0.5);
    let parameter = |shooting: CircleShooting| match shooting.solve(&TwoToneDuffing, &guess).unwrap_err() {
        CircleError::Parameter(error) => error,
        other => panic!("{other}"),
    };
    let new = CircleShooting::new;
    assert!(matches!(parameter(new().nodes(4)), ParameterError::Wrong { .. }));
    assert!(matches!(parameter(new().nodes(1)), ParameterError::TooFew { .. }));
    assert!(matches!(parameter(new().nodes(65_535)), ParameterError::TooMany { .. }));
    assert!(matches!(
        parameter(new().strobed_frequency(2)),
        ParameterError::TooMany { value: 2, max: 1, .. }
    ));
    assert!(matches!(parameter(new().between(0.0)), ParameterError::NotPositive { .. }));
    assert!(matches!(parameter(new().flow_tolerance(1.0)), ParameterError::OutOfRange { .. }));
    let loose = new().newton(Newton::new().tolerance(2.0)).solve(&TwoToneDuffing, &guess).unwrap_err();
    assert!(matches!(loose, CircleError::Parameter(ParameterError::OutOfRange { .. })));
    let point = round(5, 0.0);
    let error = new().solve(&TwoToneDuffing, &point).unwrap_err();
    assert!(matches!(error, CircleError::Parameter(ParameterError::NotPositive { .. })));
    let two = ClosedCurve::new(&[0.0, 1.0, 2.0].map(|q| State::new(0.0, &[q, 0.0], &[0.0, 0.0]))).unwrap();
    let error = new().solve(&TwoToneDuffing, &two).unwrap_err();
    assert!(matches!(error, CircleError::Parameter(ParameterError::Length { expected: 1, found: 2, .. })));
    assert!(error.last().is_none());
    let mut three = Forced { frequencies: vec![1.0, 1.5, 2.5], phases: [0.0; 2], law: |q: f64, _: f64| -q };
    let error = new().solve(&three, &guess).unwrap_err();
    assert!(matches!(error, CircleError::Parameter(ParameterError::Length { expected: 2, found: 3, .. })));
    three.frequencies = vec![1.0, f64::NAN];
    let error = new().solve(&three, &guess).unwrap_err();
    assert!(matches!(error, CircleError::Drives(QuasiPeriodicError::Parameter(_))));
    let error = new().solve_free(&van_der_pol(1.0, 0.0, 1.0), &guess, f64::NAN).unwrap_err();
    assert!(matches!(error, CircleError::Parameter(ParameterError::NotFinite { .. })));
    let taylor = new().flow_method(FlowMethod::Taylor).solve(&TwoToneDuffing, &guess).unwrap_err();
    assert!(matches!(
        taylor,
        CircleError::Integrate { node: 0, error: IntegrateError::NoSeries { .. }, last: None }
    ));
}

/// q'' = cos θ_0 - (0.01 + 0.3 cos θ_1) q' - q: no acceleration jumps.
struct GrowingAndDecaying {
    frequencies: [f64; 2],
}

impl Model for GrowingAndDecaying {
    fn dof(&self) -> usize {
        1
    }
    fn drives(&self) -> usize {
        2
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.drive_at(&self.frequencies.map(|frequency| frequency * t), side, u);
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = u[0] - (0.01 + 0.3 * u[1]) * v[0] - q[0];
    }
}

impl QuasiPeriodic for GrowingAndDecaying {
    fn frequencies(&self) -> Vec<f64> {
        self.frequencies.into()
    }
    fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
        (u[0], u[1]) = (angles[0].cos(), angles[1].cos());
    }
}

#[test]
fn searches_that_fail_keep_the_last_iterate() {
    let new = CircleShooting::new;
    let model = van_der_pol(1.0, 0.0, TAU / 2.0);
    let one =
        new().newton(Newton::new().max_iterations(1)).solve_free(&model, &round(21, 2.0), 1.9).unwrap_err();
    assert!(
        matches!(&one, CircleError::NotConverged { last, tolerance: 1e-10 } if last.residuals().len() == 2)
    );
    assert!(one.last().is_some_and(|last| last.curve().nodes() == 21 && last.residual_between().is_nan()));

    let early = new().budget(Budget::new().steps(10)).solve_free(&model, &round(21, 2.0), 1.9).unwrap_err();
    assert!(matches!(
        early,
        CircleError::Exhausted { exhausted: Exhausted::Steps { limit: 10 }, last: None }
    ));
    let late = new().budget(Budget::new().steps(2000)).solve_free(&model, &round(21, 2.0), 1.9).unwrap_err();
    assert!(matches!(late, CircleError::Exhausted { last: Some(_), .. }), "{late}");

    // Nothing restores the mean of a free mass.
    let free = Forced { frequencies: vec![1.0, 3f64.sqrt()], phases: [0.0; 2], law: |_: f64, _: f64| 0.0 };
    let error = new().solve(&free, &round(5, 0.5)).unwrap_err();
    assert!(matches!(error, CircleError::Singular { .. }), "{error}");

    // During one slow period the motion grows by e^70 and decays again: its derivative by central differences is lost.
    let grows = GrowingAndDecaying { frequencies: [1.3, 1.3 * 3.71e-3] };
    let error = new().strobed_frequency(1).solve(&grows, &round(21, 1.0)).unwrap_err();
    let lost = |error: &IntegrateError| {
        matches!(error, IntegrateError::DerivativeNotResolved { acceleration: 0, .. })
    };
    assert!(matches!(&error, CircleError::Integrate { error, .. } if lost(error)), "{error}");

    // A damped linear oscillator has no circle, only a periodic orbit.
    let damped = PeriodicallyForced { amplitude: 1.0, omega: 2.3, law: |q: f64, v: f64| -q - 0.2 * v };
    let error = new().solve_free(&damped, &round(9, 1.0), 1.0).unwrap_err();
    assert!(matches!(error, CircleError::Collapsed { share, .. } if share < 1e-9), "{error}");

    let wall = PeriodicallyForced {
        amplitude: 0.0,
        omega: 1.0,
        law: |q: f64, _: f64| if q > 1.0 { f64::NAN } else { -q },
    };
    let error = new().solve_free(&wall, &round(9, 2.0), 1.0).unwrap_err();
    assert!(matches!(error, CircleError::Integrate { node: 0, last: None, .. }), "{error}");

    // An overdamped orbit has real multipliers.
    let over = PeriodicallyForced { amplitude: 1.0, omega: 1.0, law: |q: f64, v: f64| -q - 3.0 * v };
    let orbit = Shooting::new().solve(&over, &State::at_rest(1)).unwrap();
    let error = ClosedCurve::about(&orbit, 0.1, 11).unwrap_err();
    assert!(matches!(error, CircleError::NoPair { largest } if largest < 1.0));
    assert!(matches!(ClosedCurve::about(&orbit, 0.0, 11), Err(CircleError::Parameter(_))));
}
