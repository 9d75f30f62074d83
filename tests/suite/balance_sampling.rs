//! Drives with orders far above those that a balance keeps. The balance resolves them if it chooses the
//! samples, and notes them if the user chooses too few.

use crate::api::*;
use std::f64::consts::TAU;

/// x'' + 0.1 x' + 2 x + γ sin 100 x = cos t + A cos 63 t + square wave. Time is the only drive, so that the
/// jumps of the square wave are not announced.
struct Oscillator {
    fast: f64,
    law: f64,
    square: f64,
}

impl Model for Oscillator {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let t = u[0];
        let square = if (t + 0.1).rem_euclid(TAU) < 0.5 * TAU { self.square } else { 0.0 };
        a[0] = t.cos() + self.fast * (63.0 * t).cos() + square
            - 0.1 * v[0]
            - 2.0 * q[0]
            - self.law * (100.0 * q[0]).sin();
    }
}

impl Periodic for Oscillator {
    fn period(&self) -> f64 {
        TAU
    }
}

fn coarse(orbit: &FourierOrbit) -> Option<f64> {
    orbit.notes().iter().find_map(|note| match note {
        BalanceNote::Coarse { share, .. } => Some(*share),
        _ => None,
    })
}

fn guess(harmonics: &Harmonics) -> FourierOrbit {
    FourierOrbit::new(&Harmonics::up_to(1), TAU, &[vec![0.1, 0.5, 0.1]]).unwrap().on(harmonics)
}

/// Ten kept orders need 64 samples. On 64 samples order 63 appears as order 1.
#[test]
fn drives_do_not_fold_onto_kept_orders() -> Result<(), BalanceError> {
    let model = Oscillator { fast: 5.0, law: 0.0, square: 0.0 };
    let balance = Balance::new(Harmonics::up_to(10));
    let orbit = balance.solve(&model, &guess(balance.harmonics()))?;
    // Order 1: (2 - 1 + 0.1 i) Q = 1.
    let exact = num_complex::Complex64::ONE / num_complex::Complex64::new(1.0, 0.1);
    assert!(
        (orbit.coefficients(0)[1] - exact.re).abs() < 1e-10
            && (orbit.coefficients(0)[2] + exact.im).abs() < 1e-10
    );
    assert_eq!(coarse(&orbit), None);
    // 64 samples chosen by the user alias it; a note states the share.
    let sampled = balance.integrals(Integrals::Sampled { samples: 64 });
    let folded = sampled.solve(&model, &guess(sampled.harmonics()))?;
    let share = coarse(&folded).expect("a note");
    println!("{share}: {:?}", folded.notes());
    assert!(share > 0.1);
    assert!(folded.is_doubtful());
    // 5 of the amplitude 6 are aliased: 5/12 of the peak-to-peak value.
    assert!((sampled.error_estimate(&model, &folded)?.aliasing - 5.0 / 12.0).abs() < 1e-3);
    Ok(())
}

/// Bases of two and three periods of the drives.
#[test]
fn subharmonic_bases_see_the_drives_too() -> Result<(), BalanceError> {
    let model = Oscillator { fast: 5.0, law: 0.0, square: 0.0 };
    for periods in [2, 3] {
        let balance = Balance::new(Harmonics::up_to(10).with_period_multiple(periods)?);
        let orbit = balance.solve(&model, &guess(&Harmonics::up_to(10)).on(balance.harmonics()))?;
        assert!((orbit.amplitude(0, periods) - 1.0 / 1.01f64.sqrt()).abs() < 1e-10);
        assert_eq!(coarse(&orbit), None);
    }
    Ok(())
}

/// A law that generates high orders, and a drive that jumps without announcing it: neither can be resolved,
/// and both are noted.
#[test]
fn unresolved_forces_are_noted() -> Result<(), BalanceError> {
    for model in
        [Oscillator { fast: 0.0, law: 1e-3, square: 0.0 }, Oscillator { fast: 0.0, law: 0.0, square: 0.3 }]
    {
        let balance = Balance::new(Harmonics::up_to(5));
        let orbit = balance.solve(&model, &guess(balance.harmonics()))?;
        let share = coarse(&orbit).expect("a note");
        println!("{share:.1e}");
        assert!(share > 1e-6 && share < 0.1);
    }
    Ok(())
}

/// A dead zone with a stiffness of orders 1 and 63; its edges move at order 40.
struct Fast {
    cubic: f64,
    pieces: bool,
}

impl Fast {
    fn edge(t: f64) -> f64 {
        1.0 + 0.01 * (40.0 * t).cos()
    }
}

impl Model for Fast {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let mut contact = [Contact::default()];
        self.contact(u, q, v, &mut contact);
        Fast { pieces: true, ..*self }.accel_on_pieces(&[contact[0].piece()], u, q, v, a);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: self.pieces, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let (edge, rate) = (Fast::edge(u[0]), -0.4 * (40.0 * u[0]).sin());
        out[0] = Contact {
            deflection: q[0],
            rate: v[0],
            lower: -edge,
            upper: edge,
            lower_rate: -rate,
            upper_rate: rate,
            ..Contact::default()
        };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let depth = match pieces[0] {
            Piece::Lower => q[0] + Fast::edge(u[0]),
            Piece::Gap => 0.0,
            Piece::Upper => q[0] - Fast::edge(u[0]),
        };
        let stiffness = 1.0 + 0.2 * u[0].cos() + 0.3 * (63.0 * u[0]).cos();
        a[0] = 0.2 + 0.3 * u[0].cos() - 0.1 * v[0] - stiffness * (depth + self.cubic * depth * depth * depth);
    }
}

impl Periodic for Fast {
    fn period(&self) -> f64 {
        TAU
    }
}

/// Every exact way of integration resolves the drives, also above the kept five orders: it agrees with panels
/// for 200 orders.
#[test]
fn exact_ways_follow_the_drives() -> Result<(), BalanceError> {
    let near = FourierOrbit::new(&Harmonics::up_to(2), TAU, &[vec![0.6, 0.9, 0.4, 0.05, 0.02]])?;
    let residual = |model: &Fast, integrals, highest: usize| -> Result<Vec<f64>, BalanceError> {
        let mut equations =
            Balance::new(Harmonics::up_to(highest)).integrals(integrals).equations(model, &near)?;
        let x = equations.unknowns(&near);
        let mut r = vec![0.0; x.len()];
        equations.residual(&x, &mut r);
        Ok(r[..11].to_vec())
    };
    for cubic in [0.0, 0.1] {
        let model = Fast { cubic, pieces: true };
        let reference = residual(&model, Integrals::Panels, 200)?;
        for integrals in [Integrals::Exact, Integrals::Kinks, Integrals::Panels] {
            let r = residual(&model, integrals, 5)?;
            let apart = r.iter().zip(&reference).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
            println!("{cubic} {integrals:?} {apart:.1e}");
            assert!(apart < 1e-11, "{integrals:?} {apart:e}");
        }
        // For a model without fixed pieces the balance chooses panels.
        let hidden = residual(&Fast { cubic, pieces: false }, Integrals::Exact, 5)?;
        assert!(hidden.iter().zip(&reference).all(|(a, b)| (a - b).abs() < 1e-11));
    }
    Ok(())
}

/// Crossings are located on edges that move faster than the series.
#[test]
fn contact_histories_follow_moving_edges() -> Result<(), BalanceError> {
    let model = Fast { cubic: 0.0, pieces: true };
    let orbit = FourierOrbit::new(&Harmonics::up_to(1), TAU, &[vec![0.6, 0.9, 0.4]])?;
    let contact = &orbit.contacts(&model)?[0];
    assert!(!contact.intervals.is_empty());
    for ContactInterval { start, .. } in &contact.intervals {
        let gap = orbit.at(*start).q[0].abs() - Fast::edge(*start);
        assert!(gap.abs() < 1e-12, "{gap:e}");
    }
    Ok(())
}

/// The balance of Liu 2021, which truncates the dead-zone force to the kept orders. For a motion that stays
/// in contact 1024 samples suffice; on 190 samples order 126 of the drives appears as order 64.
#[test]
fn truncated_forces_are_judged_too() -> Result<(), BalanceError> {
    let pair =
        NfgPair::of_reading(&NfgParams { speed: 120.0, ..NfgParams::table1() }, NfgReading::published())?;
    let with = |samples| -> Result<Option<f64>, BalanceError> {
        let balance = Balance::new(Harmonics::bands(63, 1, 2)?).integrals(Integrals::Sampled { samples });
        let balance = balance.truncated_forces();
        let orbit = balance.solve(&pair, &balance.linearised(&pair, Piece::Lower)?)?;
        let estimate = balance.error_estimate(&pair, &orbit)?;
        println!(
            "{samples}: {:?}, aliasing {:.1e}, truncation {:.1e}",
            coarse(&orbit),
            estimate.aliasing,
            estimate.truncation
        );
        assert_eq!(coarse(&orbit).is_some(), estimate.aliasing > 1e-7);
        Ok(coarse(&orbit))
    };
    assert_eq!(with(1024)?, None);
    assert!(with(190)?.is_some_and(|share| share > 1e-6));
    Ok(())
}

/// x'' + 0.1 x' + 2 x = p(t), a pulse of mean 2: smooth, or with jumps that are not announced.
struct Pulse {
    smooth: bool,
    width: f64,
}

impl Model for Pulse {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let y = ((u[0] - 2.345) / TAU + 0.5).rem_euclid(1.0) - 0.5;
        let pulse = match self.smooth {
            true => (-(y / self.width).powi(2)).exp() / std::f64::consts::PI.sqrt(),
            false => f64::from(u8::from(y.abs() < 0.5 * self.width)),
        };
        a[0] = 2.0 * pulse / self.width - 0.1 * v[0] - 2.0 * q[0];
    }
}

impl Periodic for Pulse {
    fn period(&self) -> f64 {
        TAU
    }
}

/// Samples miss a pulse of 1e-5 of the period. The proof reports the aliasing, and panels find the mean of
/// the pulse.
#[test]
fn pulses_between_the_samples_are_found() -> Result<(), BalanceError> {
    let balance = Balance::new(Harmonics::up_to(3));
    let rest = FourierOrbit::new(balance.harmonics(), TAU, &[vec![0.0; 7]])?;
    for (smooth, epsilon) in [(true, 1e-9), (false, 1e-7)] {
        let model = Pulse { smooth, width: 1e-5 };
        let orbit = balance.solve(&model, &rest)?;
        assert!(orbit.mean(0) == 0.0 && balance.error_estimate(&model, &orbit)?.aliasing > 0.1);
        let orbit = balance.clone().integrals(Integrals::Panels).solve(&model, &rest)?;
        // Jumps are known to the rounding of t only.
        assert!((orbit.mean(0) - 1.0).abs() < epsilon, "{}", orbit.mean(0));
    }
    Ok(())
}

/// A model whose Jacobian is NaN for x > 0.5.
struct Torn;

impl Model for Torn {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = u[0].cos() - 0.1 * v[0] - q[0];
    }
    fn offers(&self) -> Offers<'_> {
        Offers { jacobian: true, ..Offers::default() }
    }
    fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], q: &[f64], _: &[f64], out: &mut Jacobian) {
        (out.q[(0, 0)], out.v[(0, 0)]) = (if q[0] > 0.5 { f64::NAN } else { -1.0 }, -0.1);
    }
}

impl Periodic for Torn {
    fn period(&self) -> f64 {
        TAU
    }
}

/// A Jacobian that is not finite has an error of its own, which names the component.
#[test]
fn slopes_that_are_no_numbers_have_an_error_of_their_own() -> Result<(), ParameterError> {
    let balance = Balance::new(Harmonics::up_to(3));
    let guess = FourierOrbit::new(balance.harmonics(), TAU, &[vec![0.1, 0.5, 0.1, 0.0, 0.0, 0.0, 0.0]])?;
    let error = balance.solve(&Torn, &guess).unwrap_err();
    assert!(matches!(error, BalanceError::Slope { acceleration: 0, coordinate: 0, .. }), "{error}");
    let multipliers = Balance::new(guess.harmonics().clone()).multipliers(&Torn, &guess);
    assert!(matches!(multipliers, Err(MultiplierError::Slope { .. })), "{multipliers:?}");
    let error = Variation::new().run(&Torn, &State::new(0.0, &[0.4], &[1.0]), 1.0).unwrap_err();
    assert!(
        matches!(error, IntegrateError::Slope { acceleration: 0, of: "coordinate", coordinate: 0, .. }),
        "{error}"
    );
    Ok(())
}

/// A Hertzian contact on one flank, force p^1.5, as in docs/contact-laws.md.
#[derive(Clone, PartialEq)]
struct Hertz;

impl Nonlinearity for Hertz {
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
        let p = at.d.max(S::from(0.0));
        p * p.sqrt()
    }
}

/// The slope of √x at 0 is infinite, that of x √x is 0. A ring of such meshes has a finite Jacobian, and its
/// variational flow can be integrated.
#[test]
fn slopes_under_a_root_are_defined() -> Result<(), Box<dyn std::error::Error>> {
    assert_eq!([-1.0, 0.0, 4.0].map(|x| Hertz.slope(x)), [0.0, 0.0, 3.0]);
    let set = RingSet::set_a(4, 12_000.0).params()?;
    let mesh = Mesh::new(Wave::constant(1e10)?, Wave::new(Fourier::new(0.0, &[[1e-6, 0.0]])?), Hertz);
    let meshes = vec![mesh; 4];
    let (motor, gears, omega, teeth) = (set.motor, set.gears, set.omega, set.teeth);
    let params = RingParams { motor, gears, meshes, mesh_damping: vec![100.0; 4], omega, teeth };
    let ring = Ring::of_laws(&params, Frame::Inertial)?;
    let start = State::at_rest(ring.dof());
    Variation::new().run(&ring, &start, 0.1 * ring.period())?;
    let mut jacobian = Jacobian::new(ring.dof());
    let mut u = vec![0.0; ring.drives()];
    ring.drive(0.0, Side::After, &mut u);
    ring.jacobian(None, &u, &start.q, &start.v, &mut jacobian);
    assert!(jacobian.q.iter().chain(jacobian.v.iter()).all(|x| x.is_finite()));
    Ok(())
}

/// Counts that exceed the memory are refused with their bound by every function that takes one.
#[test]
fn counts_of_a_balance_have_bounds() -> Result<(), ParameterError> {
    let too_many = |found: Result<(), ParameterError>| matches!(found, Err(ParameterError::TooMany { .. }));
    for (mesh, count, half) in
        [(usize::MAX, 1, 1), (1, usize::MAX, 1), (1, 1, usize::MAX), (usize::MAX, usize::MAX, usize::MAX)]
    {
        assert!(too_many(Harmonics::bands(mesh, count, half).map(drop)));
    }
    assert!(too_many(Harmonics::of_orders(&[0, usize::MAX]).map(drop)));
    assert!(too_many(Harmonics::up_to(3).with_period_multiple(usize::MAX).map(drop)));
    let far = Harmonics::up_to(usize::MAX);
    assert!(too_many(FourierOrbit::new(&far, 1.0, &[]).map(drop)));
    let orbit = FourierOrbit::new(&Harmonics::up_to(1), TAU, &[vec![0.0; 3]])?;
    assert!(too_many(orbit.states(usize::MAX).map(drop)) && too_many(orbit.history(usize::MAX).map(drop)));
    assert_eq!(orbit.on(&far).at(0.3).q, [0.0]);
    let solve = |balance: Balance| match balance.solve(&Torn, &orbit) {
        Err(BalanceError::Parameter(error)) => Err(error),
        _ => Ok(()),
    };
    assert!(too_many(solve(Balance::new(far))));
    assert!(too_many(solve(Balance::new(Harmonics::up_to(60_000)))));
    assert!(too_many(solve(
        Balance::new(Harmonics::up_to(3)).integrals(Integrals::Sampled { samples: usize::MAX })
    )));
    Ok(())
}
