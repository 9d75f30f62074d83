//! Counts above their maximum and values outside their range: typed errors that name the bound, before memory
//! is allocated.

use crate::api::*;
use gear_dynamics::ParameterError as P;
use rand_distr::StandardNormal;

struct Swing;

impl Model for Swing {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = u[0].cos() - 0.1 * v[0] - 3.0 * q[0];
    }
}

impl Periodic for Swing {
    fn period(&self) -> f64 {
        std::f64::consts::TAU
    }
}

const HUGE: [usize; 4] = [1 << 33, 1 << 53, usize::MAX - 1, usize::MAX];

#[track_caller]
fn too_many<T>(what: &str, result: Result<T, P>) {
    let error = result.err().unwrap_or_else(|| panic!("{what} is accepted"));
    assert!(matches!(&error, P::TooMany { value, max, .. } if value > max), "{what}: {error}");
}

#[test]
fn counts_without_bound_are_refused_by_name() {
    for count in HUGE {
        too_many("axis", Axis::linear("x", 0.0, 1.0, count));
        too_many("times", uniform_times(0.0, 1.0, count));
        too_many("spans of an ensemble", Ensemble::new(1, 1.0, count));
        too_many("members", Ensemble::new(count as u64, 1.0, 1));
        too_many("histogram", Distribution::of_samples([1.0, 2.0]).histogram(count));
        let uncertain = RandomParameters::new(1).with("x", StandardNormal).with("y", StandardNormal);
        too_many("samples", uncertain.points(count));
        too_many("samples of a Sobol design", uncertain.sobol(count));
        too_many("window", Window::Hann.coefficients(count));
        too_many("waterfall", Waterfall::new(count, 4));
        too_many("waterfall", Waterfall::new(1, count));
        too_many("ring", RingSet::set_a(count, 1000.0).params());
        too_many("ring", RingSet::set_e(count, 1000.0).params());
        let wave = RectangularWave::new(1.0, 2.0, 0.5).unwrap();
        too_many("series of a wave", wave.series(count));
        too_many("series of the centre", InstantCentre::new(0.2).unwrap().rotation_series(count));
        // Runs are refused before they begin.
        let solver = Dop853::new();
        let unsettled =
            Settle::new().max_period_multiple(count).run(&solver, &Swing, &State::at_rest(1)).unwrap_err();
        assert!(matches!(unsettled, SettleError::Parameter(ParameterError::TooMany { .. })));
        let sweep = Sweep::new(Axis::of_values("x", &[1.0]).unwrap()).measure(count).strobe(count);
        let rows = sweep.of(&TableRk4::new(64), |_| Ok::<_, P>(Swing)).start(|_, _| State::at_rest(1)).run();
        assert!(matches!(rows, Err(SweepError::Parameter(P::TooMany { .. }))), "{rows:?}");
    }
    too_many("waterfall", Waterfall::new(1 << 32, 1 << 32));
    assert_eq!(
        Waterfall::new(1 << 13, 1 << 14).unwrap_err().to_string(),
        "samples in a window is 134217728: at most 67108864 are allowed"
    );
    assert!(uniform_times(0.0, 1.0, 0).is_err() && Distribution::new().histogram(3).is_err());
}

/// Only the rows of a chunk are in memory, not the grid.
#[test]
fn a_grid_too_large_for_memory_is_run_in_chunks() {
    let axis = |name| Axis::linear(name, 0.0, 1.0, 1 << 15).unwrap();
    let sweep = Sweep::new(Points::grid(vec![axis("a"), axis("b")]).unwrap()).settle(0).measure(1);
    let run = |chunks| {
        sweep.of(&TableRk4::new(8), |_| Ok::<_, P>(Swing)).start(|_, _| State::at_rest(1)).chunk(1, chunks)
    };
    assert!(matches!(run(2), Err(SweepError::Parameter(P::TooMany { max: 268_435_456, .. }))));
    assert_eq!(run(1 << 22).unwrap().iter().count(), 256);
}

/// The waterfall checks its channel and the number of its samples before the run begins.
#[test]
fn a_waterfall_looks_at_its_channel_and_its_samples_before_it_runs() {
    struct NoRun;
    impl Integrator for NoRun {
        fn run(
            &self,
            _: &dyn Model,
            _: &State,
            _: f64,
            _: &mut dyn Observer,
        ) -> Result<Finish, IntegrateError> {
            panic!("the run began");
        }
    }
    let pair = NfgPair::new(&NfgParams::table1()).unwrap();
    let (start, speed) = (pair.on_drive_flank().unwrap(), pair.speed());
    let run_up = VaryingSpeed::new(pair, SpeedLaw::constant(speed).unwrap());
    let run = |end, channel| {
        Waterfall::new(2, 256).unwrap().run(&NoRun, &run_up, &start, end, channel).unwrap_err().error
    };
    assert!(matches!(
        run(1e5, "deflexion"),
        IntegrateError::Parameter(P::NoSuchChannel { name, .. }) if name == "deflexion"
    ));
    for end in [1e12, 1e50] {
        assert!(matches!(run(end, "deflection"), IntegrateError::Parameter(P::TooMany { .. })), "{end}");
    }
    for end in [1e100, f64::MAX] {
        assert!(matches!(run(end, "deflection"), IntegrateError::Parameter(P::OutOfRange { .. })), "{end}");
    }
}

#[test]
fn a_time_that_the_bands_do_not_have_is_an_error() {
    let family = |_: u64| Ok::<_, P>((Swing, State::at_rest(1)));
    let bands =
        Ensemble::new(2, 1.0, 4).unwrap().channels(&["q0", "v0"]).run(&Rk4::new(0.1), family).unwrap();
    for i in [5, 1 << 62, 1 << 63, usize::MAX / 2, usize::MAX] {
        for channel in ["q0", "v0"] {
            assert!(matches!(bands.at(channel, i), Err(P::Length { found: 5, .. })), "{channel} {i}");
        }
    }
    assert!(bands.at("q0", 4).is_ok());
}

/// An ensemble with more distributions than the maximum is refused before a member runs.
#[test]
fn an_ensemble_bounds_its_distributions() {
    let family = |_: u64| -> Result<(Swing, State), P> { panic!("a member ran") };
    let bands = Ensemble::new(2, 1.0, 1 << 18).unwrap().channels(&["q0", "v0"]).run(&Rk4::new(0.1), family);
    assert!(matches!(bands, Err(EnsembleError::Parameter(P::TooMany { max: 262_144, .. }))));
}

/// Every accepted pair has a finite period, finite drives and finite accelerations.
#[test]
fn a_pair_that_is_accepted_can_be_evaluated() {
    let (mut accepted, mut refused) = (0, 0);
    let hostile = [5e-324, 1e-308, 1e-200, 1e-100, 1e-30, 1e-3, 1.0, 1e30, 1e100, 1e160, 1e308, f64::MAX];
    type Set = fn(&mut NfgParams, f64);
    let sets: [Set; 12] = [
        |p, x| p.inertia = x,
        |p, x| p.module = x,
        |p, x| (p.ratio, p.pinion_teeth) = (x, 1),
        |p, x| p.stiffness = x,
        |p, x| p.speed = x,
        |p, x| p.load_torque = x,
        |p, x| p.damping_ratio = x,
        |p, x| p.half_backlash = x,
        |p, x| p.error = x,
        |p, x| p.error_harmonics = vec![[0.0, x], [x, x]],
        |p, x| p.stiffness_harmonics = vec![[x, -x]],
        |p, x| p.eccentric_ratio = 1.0 - x.min(1.0),
    ];
    let readings = [
        NfgReading::exact(),
        NfgReading::published(),
        NfgReading { centre_forcing: CentreForcing::Series(50), ..NfgReading::exact() },
    ];
    fn look<M: Periodic>(model: &M, of: &str) {
        let period = model.period();
        assert!(period.is_finite() && period > 0.0, "{of}: period {period}");
        let mut u = vec![0.0; model.drives()];
        for i in 0..64 {
            model.drive(period * f64::from(i) / 64.0, Side::After, &mut u);
            assert!(u.iter().all(|x| x.is_finite()), "{of}: {u:?}");
            let (n, mut a) = (model.dof(), vec![0.0; model.dof()]);
            model.accel(&u, &vec![0.0; n], &vec![0.0; n], &mut a);
            assert!(a.iter().all(|x| x.is_finite()), "{of}: {u:?} {a:?}");
        }
    }
    for (i, first) in sets.iter().enumerate() {
        for (j, second) in sets.iter().enumerate().filter(|(j, _)| *j >= i) {
            for (x, y) in hostile.iter().flat_map(|x| hostile.iter().map(move |y| (*x, *y))) {
                let mut params = NfgParams::table1();
                first(&mut params, x);
                second(&mut params, y);
                let of = format!("{i}: {x:e}, {j}: {y:e}");
                for reading in readings {
                    match NfgPair::of_reading(&params, reading) {
                        Ok(pair) => {
                            accepted += 1;
                            look(&pair, &of);
                        }
                        Err(_) => refused += 1,
                    }
                }
                if let Ok(pair) = NfgPair2::new(&params, 0.01) {
                    look(&pair, &of);
                }
            }
        }
    }
    assert!(accepted > 1000 && refused > 1000, "{accepted} {refused}");
    let inertia = NfgParams { inertia: 5e-324, ..NfgParams::table1() };
    assert!(matches!(NfgPair::new(&inertia), Err(P::OutOfRange { name, .. }) if name == "inertia"));
    let reading = NfgReading { centre_forcing: CentreForcing::Series(u32::MAX), ..NfgReading::exact() };
    too_many("centre forcing", NfgPair::of_reading(&NfgParams::table1(), reading));
    too_many("centre forcing", NfgPair2::of_reading(&NfgParams::table1(), 0.01, reading));
}

#[test]
fn laws_and_phases_that_overflow_are_refused() {
    for rounding in [5e-324, 1e-200, 1e160, f64::MAX] {
        assert!(SmoothedBacklash::new(1.0, rounding).is_err(), "{rounding}");
    }
    assert!(SmoothedBacklash::new(1e160, 1.0).is_err());
    let law = SmoothedBacklash::new(1e50, 1e-50).unwrap();
    assert!([0.0, 1e-100, 1e100].iter().all(|x| law.at(*x).is_finite() && law.slope(*x).is_finite()));
    for bad in [5e-324, 1e-200, 1e160, f64::MAX] {
        assert!(SpeedLaw::constant(bad).is_err(), "{bad}");
        assert!(
            SpeedLaw::fluctuation(bad, 0.9, 1.0).is_err() && SpeedLaw::fluctuation(1.0, 0.9, bad).is_err(),
            "{bad}"
        );
        assert!(SpeedLaw::ramp(bad, 1.0, 1.0).is_err() && SpeedLaw::ramp(1.0, bad, 1.0).is_err(), "{bad}");
    }
    assert!(SpeedLaw::ramp(1e49, 1e50, 1e300).is_err(), "the phase overflows");
    assert!(SpeedLaw::ramp(1.0, 2.0, 5e-324).is_err(), "the acceleration overflows");
    let law = SpeedLaw::fluctuation(1e50, 0.999, 1e-50).unwrap();
    assert!([0.0, 1.0, 1e100].iter().all(|t| law.angle(*t).is_finite() && law.speed(*t).is_finite()));
}

#[test]
fn figures_that_overflow_are_errors() {
    let overflows = |what: &str, error: Option<P>| {
        assert!(matches!(error, Some(P::Overflow { .. })), "{what}: {error:?}")
    };
    overflows("mean", Summary::of_samples(&[f64::MAX, f64::MAX]).err());
    overflows("mean square", Summary::of_samples(&[1e200, -1e200]).err());
    overflows(
        "amplitude",
        Spectrum::new(&[f64::MAX, f64::MAX, -f64::MAX, f64::MAX], 1.0, Window::Rectangular).err(),
    );
    let beyond = |what: &str, error: Option<P>| {
        assert!(matches!(error, Some(P::OutOfRange { .. })), "{what}: {error:?}")
    };
    beyond("series", Fourier::new(0.0, &[[1e200, 0.0]]).err());
    beyond("series", Fourier::new(f64::MAX, &[[f64::MAX, 0.0]]).err());
    beyond("fit", Fourier::fit(&[f64::MAX; 9], 2).err());
    beyond("table", Table::new(&[1e100, -1e100].repeat(10_000)).err());
    beyond("wave", RectangularWave::new(-f64::MAX, f64::MAX, 0.5).err());
    assert!(
        Spectrum::new(&[1.0, 2.0], 5e-324, Window::Hann).is_err()
            && Spectrum::new(&[1.0, 2.0], f64::MAX, Window::Hann).is_err()
    );
    // Values of any size have a mean and its standard error; their variance may overflow.
    for values in [[f64::MAX, -f64::MAX, f64::MAX, f64::MAX], [1.0, 2.0, 1e160, -1e160], [f64::MAX; 4]] {
        let all = Distribution::of_samples(values);
        let exact = values.iter().map(|x| x / 4.0).sum::<f64>();
        assert!((all.mean() - exact).abs() <= 1e-12 * all.max().abs(), "{values:?}: {}", all.mean());
        let squares: f64 = values.iter().map(|x| (x / 1e200 - exact / 1e200).powi(2)).sum();
        let error = 1e200 * (squares / 12.0).sqrt();
        assert!(
            (all.standard_error() - error).abs() <= 1e-12 * error,
            "{values:?}: {} {error}",
            all.standard_error()
        );
        assert!(all.quantile(0.4).unwrap().is_finite());
    }
    overflows("variance", Distribution::of_samples([1e160, -1e160]).variance().err());
    let small = Distribution::of_samples([1.0, 2.0, 4.0]);
    assert!((small.variance().unwrap() - 7.0 / 3.0).abs() < 1e-15);
}

/// A stiffness with too many jumps is refused when its mean is computed; a ring has at most 4095 gears.
#[test]
fn a_ring_bounds_jumps_and_gears() {
    let mut params = RingSet::set_a(4, 1000.0).params().unwrap();
    let wave = Wave::new(RectangularWave::new(1e8, 2e8, 0.5).unwrap());
    let mut with = |order: u32| {
        let stiffness = wave.clone().per_turn(order).unwrap();
        params.meshes[1] = Mesh::new(stiffness, Wave::constant(0.0).unwrap(), Backlash::new(1e-5).unwrap());
        Ring::new(&params)
    };
    assert!(with(10).is_ok());
    assert!(matches!(
        with(100_000),
        Err(P::TooMany { name, max: 10_000, .. })
            if name == "jumps of meshes[1].stiffness in a mesh period"
    ));
    assert!(matches!(
        wave.clone().per_turn(1_000_001),
        Err(P::TooMany { name, max: 1_000_000, .. }) if name == "order of a wave"
    ));
    assert!(matches!(
        wave.per_turn(1_000_000),
        Err(P::TooMany { name, .. }) if name == "edges of a wave in a turn"
    ));
    assert!(matches!(RingSet::set_a(4096, 1000.0).params(), Err(P::TooMany { max: 4095, .. })));
}

/// x'' + 0.06 x' - x = cos t from rest grows without limit. The exponents are those of the equation. The
/// rounding of the motion soon exceeds the tolerance at the start and must not reduce the step.
#[test]
fn exponents_of_a_motion_that_grows() {
    struct Growing;
    impl Model for Growing {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            a[0] = u[0].cos() - 0.06 * v[0] + q[0];
        }
    }
    impl Periodic for Growing {
        fn period(&self) -> f64 {
            std::f64::consts::TAU
        }
    }
    let exponents = Lyapunov::new().settle(0).align(3).measure(12).budget(Budget::new().steps(100_000));
    let exponents = exponents.run(&Growing, &State::at_rest(1)).unwrap();
    let root = (1.0f64 + 0.03 * 0.03).sqrt();
    assert!((exponents.values()[0] - (root - 0.03)).abs() < 1e-7, "{exponents:?}");
    assert!((exponents.values()[1] + (root + 0.03)).abs() < 1e-7, "{exponents:?}");
}

#[test]
fn models_without_coordinates_are_refused() {
    struct Nothing;
    impl Model for Nothing {
        fn dof(&self) -> usize {
            0
        }
        fn accel(&self, _: &[f64], _: &[f64], _: &[f64], _: &mut [f64]) {}
    }
    impl Periodic for Nothing {
        fn period(&self) -> f64 {
            1.0
        }
    }
    let none = |error: &P| matches!(error, P::TooFew { name, value: 0, .. } if name == "degrees of freedom");
    let shot = Shooting::new().solve(&Nothing, &State::at_rest(0)).unwrap_err();
    assert!(matches!(&shot, ShootingError::Parameter(error) if none(error)), "{shot}");
    let grown = Lyapunov::new().run(&Nothing, &State::at_rest(0)).unwrap_err();
    assert!(matches!(&grown, LyapunovError::Parameter(error) if none(error)), "{grown}");
    assert!(Variation::new().run(&Nothing, &State::at_rest(0), 1.0).is_err());
    let sweep = Sweep::new(Axis::linear("x", 0.0, 1.0, 2).unwrap());
    let swept = sweep
        .of(&TableRk4::new(8), |_| Ok::<_, P>(Nothing))
        .start(|_, _| State::at_rest(0))
        .run()
        .unwrap_err();
    assert!(matches!(&swept, SweepError::Parameter(error) if none(error)), "{swept}");
}

/// `time` inverts `phase`, for laws of any speed between their knots.
#[test]
fn times_of_phases_at_any_scale() {
    let laws = [
        SpeedLaw::table(&[0.0, 1e-30, 1.0], &[1e40, 1e-40, 1e40]).unwrap(),
        SpeedLaw::table(&[0.0, 1e20, 2e20], &[1e-50, 1e50, 1.0]).unwrap(),
        SpeedLaw::ramp(1e10, 1e-10, 1e-5).unwrap(),
        SpeedLaw::fluctuation(2e12, 0.57, 1e-50).unwrap(),
        SpeedLaw::fluctuation(1e-50, 0.999, 1e50).unwrap(),
        SpeedLaw::fluctuation(3.0, 0.9, 1e3).unwrap(),
    ];
    for law in &laws {
        for phase in [-1e60, -1.0, -1e-12, 0.0, 1e-300, 1e-12, 1.0, 40.0, 1e60] {
            let again = law.angle(law.time(phase));
            assert!((again - phase).abs() <= 1e-9 * phase.abs().max(1e-9), "{law:?}: {phase:e}, {again:e}");
        }
    }
}

#[test]
fn multipliers_with_an_error_that_is_no_number_are_none() {
    let matrix = nalgebra::DMatrix::identity(2, 2);
    assert!(Multipliers::of_monodromy(&matrix, f64::NAN).is_err());
    assert!(Multipliers::of_monodromy(&matrix, 0.0).is_ok());
    // Entries whose squares overflow: the eigenvalues are 3e200 and -1e200.
    let large = nalgebra::DMatrix::from_row_slice(2, 2, &[1e200, 2e200, 2e200, 1e200]);
    let values = Multipliers::of_monodromy(&large, 0.0).unwrap();
    assert!(
        (values.values()[0].re / 3e200 - 1.0).abs() < 1e-14
            && (values.values()[1].re / 1e200 + 1.0).abs() < 1e-14
    );
}

/// A quantity outside its range is refused by name with the range.
#[test]
fn quantities_have_a_range() {
    for bad in [1e51, -1e51, 1e300, f64::MAX] {
        assert!(matches!(
            Constant::new(bad),
            Err(P::OutOfRange { value, allowed: "[-1e50, 1e50]", .. }) if value == bad
        ));
        assert!(Fourier::new(0.0, &[[bad, 0.0]]).is_err() && Cubic::new(1.0, bad).is_err());
    }
    for bad in [1e51, 1e-51, 5e-324] {
        let params = NfgParams { inertia: bad, ..NfgParams::table1() };
        assert!(matches!(NfgPair::new(&params), Err(P::OutOfRange { allowed: "[1e-50, 1e50]", .. })));
    }
    assert!(Constant::new(1e50).is_ok());
}

/// A run to a time beyond 1e50 is refused: products of its steps and rates would overflow.
#[test]
fn runs_end_within_a_bounded_time() {
    struct Idle;
    impl Model for Idle {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            a[0] = -q[0] - v[0];
        }
    }
    let solver = Dop853::new().rtol(0.5).atol(1e50);
    for end in [1e51, 1e308, f64::INFINITY, f64::NAN] {
        assert!(
            matches!(solver.end(&Idle, &State::at_rest(1), end), Err(IntegrateError::TimeSpan { .. })),
            "{end}"
        );
    }
    assert!(solver.end(&Idle, &State::at_rest(1), 1e50).is_ok());
}

/// x'' + 0.5 x⁹ = cos t. With a large tolerance the steps are so long that the motion diverges.
struct Stiffening;

impl Model for Stiffening {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = u[0].cos() - 0.5 * q[0].powi(9);
    }
}

#[test]
fn steps_that_overflow_inside_show_numbers() {
    let (mut inside, mut largest) = (0, 0f64);
    let mut look = |step: &mut Step<'_>| {
        let mut y = [0.0; 2];
        for i in 1..10 {
            step.at(step.t0() + 0.1 * i as f64 * (step.t1() - step.t0()), &mut y);
            assert!(y.iter().all(|y| y.is_finite()), "{y:?}");
            (inside, largest) = (inside + 1, largest.max(y[0].abs()));
        }
        std::ops::ControlFlow::Continue(())
    };
    let solver = Dop853::new().rtol(0.5).atol(1e160).max_steps(100);
    let end = solver.run(&Stiffening, &State::at_rest(1), 1e3, &mut look);
    assert!(matches!(end, Err(IntegrateError::NotFinite { .. })), "{end:?}");
    assert!(inside > 0 && largest > 1e20, "{inside} {largest:e}");
}
