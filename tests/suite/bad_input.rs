//! Invalid input gives a typed error that contains the name of the quantity and its value.

use crate::api::*;
use crate::common::oscillators::DeadZone;
use gear_dynamics::ParameterError as P;
use gear_dynamics::contact::{Contact, Deflection, PieceChoice};
use gear_dynamics::linear::{LinearError, static_state};
use gear_dynamics::random::{NoiseError, NoisySteps, WhiteNoise};
use proptest::prelude::*;
use std::f64::consts::PI;

fn set() -> RingSet {
    RingSet::set_a(4, 1000.0)
}

fn ring(change: impl FnOnce(&mut RingParams)) -> P {
    let mut params = set().params().unwrap();
    change(&mut params);
    Ring::new(&params).unwrap_err()
}

fn pair(change: impl FnOnce(&mut NfgParams)) -> P {
    let mut params = NfgParams::table1();
    change(&mut params);
    let one = NfgPair::new(&params).unwrap_err();
    assert_eq!(one.to_string(), NfgPair2::new(&params, 0.01).unwrap_err().to_string());
    one
}

fn not_positive(name: &str, value: f64) -> P {
    P::NotPositive { name: name.into(), value }
}

#[test]
fn non_positive_inertia_stiffness_radius() {
    assert_eq!(ring(|p| p.motor.inertia = 0.0), not_positive("motor.inertia", 0.0));
    assert_eq!(ring(|p| p.gears[2].inertia = -1.0), not_positive("gears[2].inertia", -1.0));
    assert_eq!(ring(|p| p.gears[1].load.inertia = 0.0), not_positive("gears[1].load.inertia", 0.0));
    assert_eq!(ring(|p| p.gears[3].base_radius = -0.05), not_positive("gears[3].base_radius", -0.05));
    assert_eq!(
        RingSet { mesh_stiffness: 0.0, ..set() }.params().unwrap_err(),
        not_positive("mesh_stiffness", 0.0)
    );
    assert_eq!(pair(|p| p.inertia = -0.014), not_positive("inertia", -0.014));
    assert_eq!(pair(|p| p.stiffness = 0.0), not_positive("stiffness", 0.0));
    assert_eq!(pair(|p| p.module = 0.0), not_positive("module", 0.0));
    assert_eq!(InstantCentre::new(0.2).unwrap().radius(-1.0).unwrap_err(), not_positive("mean radius", -1.0));
    assert_eq!(NfgPair2::new(&NfgParams::table1(), 0.0).unwrap_err(), not_positive("pinion inertia", 0.0));
}

#[test]
fn negative_backlash_damping_hold_time() {
    let negative = |name: &str, value: f64| P::Negative { name: name.into(), value };
    assert_eq!(Backlash::new(-1e-6).unwrap_err(), negative("half backlash b", -1e-6));
    assert_eq!(SmoothedBacklash::new(-1.0, 0.1).unwrap_err(), negative("half backlash b", -1.0));
    assert_eq!(
        AsymmetricBacklash::new(1.0, 0.5).unwrap_err(),
        negative("gap between lower and upper edge", -0.5)
    );
    assert_eq!(RingSet { mesh_damping: -1.0, ..set() }.params().unwrap_err(), negative("mesh_damping", -1.0));
    assert_eq!(ring(|p| p.gears[0].load.shaft.damping = -0.1), negative("gears[0].load.shaft.damping", -0.1));
    assert_eq!(ring(|p| p.motor.shaft.stiffness = -1.0), negative("motor.shaft.stiffness", -1.0));
    assert_eq!(pair(|p| p.half_backlash = -5e-5), negative("half_backlash", -5e-5));
    assert_eq!(pair(|p| p.damping_ratio = -0.01), negative("damping_ratio", -0.01));
    assert_eq!(pair(|p| p.load_torque = -30.0), negative("load_torque", -30.0));
    assert_eq!(HeldProcess::of_values(-0.1, &[1.0]).unwrap_err(), not_positive("hold time", -0.1));
    assert_eq!(HeldProcess::of_values(0.0, &[1.0]).unwrap_err(), not_positive("hold time", 0.0));
}

#[test]
fn models_of_a_formula_without_coordinates_or_period() {
    let fall = |dof: usize| from_fn(dof, |_, _, _, a| a.fill(-1.0));
    let name = || "degrees of freedom".to_owned();
    assert_eq!(fall(0).err(), Some(P::TooFew { name: name(), value: 0, min: 1 }));
    assert_eq!(fall(1 << 30).err(), Some(P::TooMany { name: name(), value: 1 << 30, max: 1 << 25 }));
    let timed = |period: f64| fall(1).unwrap().with_period(period).err();
    assert_eq!(timed(0.0), Some(not_positive("period", 0.0)));
    assert!(matches!(timed(f64::NAN), Some(P::NotFinite { .. })));
    assert!(timed(1e51).is_some() && timed(1.0).is_none());
}

#[test]
fn contact_laws_with_impossible_numbers() {
    let negative = |name: &str, value: f64| P::Negative { name: name.into(), value };
    let outside =
        |name: &str, value: f64, allowed: &'static str| P::OutOfRange { name: name.into(), value, allowed };
    assert_eq!(PowerLaw::new(-1.0, 1.5, 1.0).unwrap_err(), negative("half backlash b", -1.0));
    assert_eq!(PowerLaw::new(1.0, 0.9, 1.0).unwrap_err(), outside("exponent", 0.9, "[1, 100]"));
    assert_eq!(PowerLaw::new(1.0, 101.0, 1.0).unwrap_err(), outside("exponent", 101.0, "[1, 100]"));
    assert_eq!(PowerLaw::new(1.0, 1.5, 0.0).unwrap_err(), not_positive("reference depth", 0.0));
    assert_eq!(
        PowerLaw::new(1.0, 1.5, 1e-60).unwrap_err(),
        outside("reference depth", 1e-60, "[1e-50, 1e50]")
    );
    let power = PowerLaw::new(1.0, 1.5, 1.0).unwrap();
    assert_eq!(power.with_edges(1.0, 0.5).unwrap_err(), negative("gap between lower and upper edge", -0.5));
    assert!(matches!(power.with_edges(f64::NEG_INFINITY, f64::INFINITY), Err(P::NotFinite { .. })));
    let gap = Backlash::new(1.0).unwrap();
    assert_eq!(Damped::by_stiffness(gap, -1.0).unwrap_err(), negative("damping time", -1.0));
    assert_eq!(Damped::by_stiffness_always(gap, -1.0).unwrap_err(), negative("damping time", -1.0));
    assert_eq!(Damped::by_force(gap, -0.5).unwrap_err(), negative("loss factor", -0.5));
    assert_eq!(NoPullBacklash::new(-1.0, 0.1).unwrap_err(), negative("half backlash b", -1.0));
    assert_eq!(NoPullBacklash::new(1.0, 0.0).unwrap_err(), not_positive("damping time", 0.0));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let all = [
            PowerLaw::new(bad, 1.5, 1.0).unwrap_err(),
            PowerLaw::new(1.0, bad, 1.0).unwrap_err(),
            PowerLaw::new(1.0, 1.5, bad).unwrap_err(),
            Damped::by_stiffness(gap, bad).unwrap_err(),
            Damped::by_force(gap, bad).unwrap_err(),
            NoPullBacklash::new(1.0, bad).unwrap_err(),
            AsymmetricBacklash::stop_above(bad).unwrap_err(),
            AsymmetricBacklash::stop_below(bad).unwrap_err(),
        ];
        assert!(all.iter().all(|error| matches!(error, P::NotFinite { .. })), "{all:?}");
    }
}

#[test]
fn nan_and_infinity_anywhere() {
    let not_finite = |error: P, place: &str| {
        assert!(matches!(&error, P::NotFinite { name, .. } if name == place), "{error}")
    };
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        not_finite(ring(|p| p.motor.torque = bad), "motor.torque");
        not_finite(ring(|p| p.gears[3].load.torque = bad), "gears[3].load.torque");
        not_finite(ring(|p| p.gears[0].inertia = bad), "gears[0].inertia");
        not_finite(ring(|p| p.omega = bad), "omega");
        not_finite(RingSet { error: bad, ..set() }.params().unwrap_err(), "error");
        not_finite(RingSet { phases: vec![0.0, bad, 0.0, 0.0], ..set() }.params().unwrap_err(), "phases[1]");
        not_finite(pair(|p| p.speed = bad), "speed");
        not_finite(pair(|p| p.error = bad), "error");
        not_finite(pair(|p| p.pressure_angle = bad), "pressure_angle");
        not_finite(pair(|p| p.stiffness_harmonics.push([0.0, bad])), "stiffness_harmonics[1][1]");
        not_finite(pair(|p| p.error_harmonics = vec![[bad, 0.0]]), "error_harmonics[0][0]");
        not_finite(Constant::new(bad).unwrap_err(), "constant excitation");
        not_finite(Fourier::new(bad, &[]).unwrap_err(), "mean");
        not_finite(Fourier::of_amplitudes(0.0, &[[1.0, bad]]).unwrap_err(), "phase of order 1");
        not_finite(Table::new(&[0.0, bad, 1.0]).unwrap_err(), "samples[1]");
        not_finite(RectangularWave::new(bad, 1.0, 0.5).unwrap_err(), "low level");
        not_finite(Scaled::new(bad, Wave::new(Constant::new(1.0).unwrap())).unwrap_err(), "factor");
        not_finite(Cubic::new(1.0, bad).unwrap_err(), "cubic coefficient");
        not_finite(HeldProcess::of_values(1.0, &[0.0, bad]).unwrap_err(), "held values[1]");
        not_finite(Spectrum::new(&[0.0, bad], 1.0, Window::Hann).unwrap_err(), "samples[1]");
    }
}

#[test]
fn empty_and_mismatched_lists() {
    assert_eq!(
        HeldProcess::of_values(1.0, &[]).unwrap_err(),
        P::Empty { name: "held values".into(), min: 1 }
    );
    assert_eq!(Summary::of_samples(&[]).unwrap_err(), P::Empty { name: "samples".into(), min: 1 });
    assert_eq!(ring(|p| drop(p.meshes.pop())), P::Length { name: "meshes".into(), expected: 4, found: 3 });
    assert_eq!(
        RingSet { phases: vec![0.0], ..set() }.params().unwrap_err(),
        P::Length { name: "phases".into(), expected: 4, found: 1 }
    );
    assert_eq!(Table::new(&[1.0]).unwrap_err(), P::TooFew { name: "samples".into(), value: 1, min: 3 });
    assert_eq!(
        Fourier::fit(&[1.0; 4], 2).unwrap_err(),
        P::TooFew { name: "samples".into(), value: 4, min: 5 }
    );
    let held = Noisy::new(NfgPair::new(&NfgParams::table1()).unwrap());
    let process = HeldProcess::of_values(1.0, &[1.0]).unwrap();
    assert_eq!(held.clone().add(&[(99, 1.0)], &process).unwrap_err(), P::NoSuchSlot { slot: 99, drives: 13 });
    assert!(matches!(held.add(&[(1, f64::NAN)], &process), Err(P::NotFinite { .. })));
}

#[test]
fn ratios_and_teeth() {
    let outside = |error: P, place: &str, x: f64| {
        let (P::OutOfRange { name, value, .. } | P::Wrong { name, value, .. }) = &error else {
            panic!("{error}")
        };
        assert!(name == place && *value == x, "{error}");
    };
    outside(pair(|p| p.eccentric_ratio = 1.0), "eccentric_ratio", 1.0);
    outside(pair(|p| p.eccentric_ratio = -0.1), "eccentric_ratio", -0.1);
    outside(InstantCentre::new(1.5).unwrap_err(), "eccentric ratio", 1.5);
    outside(pair(|p| p.ratio = 3.51), "face gear teeth", 3.51 * 18.0);
    outside(RectangularWave::of_contact_ratio(0.9, 1.0, 2.0).unwrap_err(), "contact ratio", 0.9);
    outside(RectangularWave::of_contact_ratio(160.0, 1.0, 2.0).unwrap_err(), "contact ratio", 160.0);
    outside(RectangularWave::new(1.0, 2.0, 1.0).unwrap_err(), "duty", 1.0);
    assert_eq!(pair(|p| p.pinion_teeth = 0), P::TooFew { name: "pinion_teeth".into(), value: 0, min: 1 });
    assert_eq!(
        RingSet { teeth: 0, ..set() }.params().unwrap_err(),
        P::TooFew { name: "teeth".into(), value: 0, min: 1 }
    );
    let two = ring(|p| (p.gears.truncate(2), p.meshes.truncate(2)).0);
    assert_eq!(two, P::TooFew { name: "gears of a closed ring".into(), value: 2, min: 3 });
}

#[test]
fn an_odd_ring_is_refused_with_the_reason() {
    let params = RingSet::set_a(3, 1000.0).params().unwrap();
    let error = Ring::new(&params).unwrap_err();
    assert_eq!(error, P::OddRing { gears: 3 });
    assert!(error.to_string().contains("locks") && error.to_string().contains("as_printed"));
    assert_eq!(Ring::as_printed(&params).unwrap().gears(), 3);
}

#[test]
fn unknown_channels_are_listed() {
    let pair = NfgPair::new(&NfgParams::table1()).unwrap();
    let error = Statistics::new(&pair, &["q1"]).err().unwrap();
    assert!(error.to_string().contains("q0, v0, deflection, mesh force, contact, base radius"), "{error}");
}

struct Broken(f64);

impl Model for Broken {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = if u[0] < self.0 { -q[0] } else { f64::NAN };
    }
}

fn start() -> State {
    State::new(0.0, &[1.0], &[0.0])
}

/// Runs the model with every solver; each run fails and returns the trajectory up to the failure.
fn failing(model: &impl Model, end: f64) -> Vec<Failed> {
    vec![
        Rk4::new(0.01).trajectory(model, &start(), end).unwrap_err(),
        Rk45::new().trajectory(model, &start(), end).unwrap_err(),
        Dop853::new().trajectory(model, &start(), end).unwrap_err(),
    ]
}

#[test]
fn a_model_that_returns_nan_midway() {
    for failed in failing(&Broken(0.5), 1.0) {
        let last = failed.trajectory.last().unwrap();
        assert!(
            matches!(failed.error, IntegrateError::NotFinite { t, .. } if t == last.t),
            "{}",
            failed.error
        );
        assert!(last.t > 0.48 && last.t < 0.5 && failed.trajectory.len() > 2, "{}", last.t);
        assert!((last.q[0] - last.t.cos()).abs() < 1e-8);
    }
    for failed in failing(&Broken(-1.0), 1.0) {
        assert_eq!(failed.error, IntegrateError::NotANumber { t: 0.0, acceleration: 0 });
    }
}

/// The error names the acceleration that is not finite: in small and large models, during a run and at its
/// start.
#[test]
fn the_component_that_is_not_finite() {
    struct Fails {
        dof: usize,
        component: usize,
        from: f64,
    }
    impl Model for Fails {
        fn dof(&self) -> usize {
            self.dof
        }
        fn accel(&self, u: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            for (a, q) in a.iter_mut().zip(q) {
                *a = -q;
            }
            if u[0] >= self.from {
                a[self.component] = f64::NAN;
            }
        }
    }
    for dof in 1..=4 {
        let start = State::new(0.0, &vec![1.0; dof], &vec![0.0; dof]);
        for (component, from) in (0..dof).flat_map(|c| [(c, 0.5), (c, 0.0)]) {
            let model = Fails { dof, component, from };
            for failed in [
                Rk4::new(0.01).trajectory(&model, &start, 1.0).unwrap_err(),
                Rk45::new().trajectory(&model, &start, 1.0).unwrap_err(),
                Dop853::new().trajectory(&model, &start, 1.0).unwrap_err(),
            ] {
                let named = match failed.error {
                    IntegrateError::NotFinite { component: found, .. } => {
                        from > 0.0 && found == dof + component
                    }
                    IntegrateError::NotANumber { t, acceleration } => {
                        from == 0.0 && t == 0.0 && acceleration == component
                    }
                    _ => false,
                };
                assert!(named, "{}", failed.error);
            }
        }
    }
}

/// NaN at the start of a run is told as such: in the state by its name, in the model by its acceleration.
#[test]
fn nan_at_the_start_is_named() {
    let spring = from_fn(2, |_, q, _, a| a.copy_from_slice(&[-q[0], -q[1]])).unwrap();
    let broken = from_fn(2, |_, q, _, a| a.copy_from_slice(&[-q[0], (q[1] - 1.0).sqrt()])).unwrap();
    let text = |error: IntegrateError| error.to_string();
    let rest = State::at_rest(2);
    let nan = State::new(0.0, &[0.0; 2], &[0.0, f64::NAN]);
    for end in [
        [Rk4::new(0.1).end(&spring, &nan, 1.0), Rk4::new(0.1).end(&broken, &rest, 1.0)],
        [Rk45::new().end(&spring, &nan, 1.0), Rk45::new().end(&broken, &rest, 1.0)],
        [Dop853::new().end(&spring, &nan, 1.0), Dop853::new().end(&broken, &rest, 1.0)],
    ] {
        let [of_state, of_model] = end.map(|end| text(end.unwrap_err()));
        assert!(of_state.contains("start.v[1] is NaN"), "{of_state}");
        assert!(of_model.contains("acceleration 1 is NaN at t = 0.0"), "{of_model}");
    }
}

/// q'' = q³ from q = 1 at rest is infinite at t = K(1/√2) = Γ(1/4)²/(4 √π): the error shows how large the
/// state is.
#[test]
fn a_motion_without_bound_shows_its_size() {
    let blow_up = from_fn(1, |_, q, _, a| a[0] = q[0] * q[0] * q[0]).unwrap();
    let start = State::new(0.0, &[1.0], &[0.0]);
    for end in [Rk45::new().end(&blow_up, &start, 3.0), Dop853::new().end(&blow_up, &start, 3.0)] {
        let error = end.unwrap_err();
        // Near the pole q = √2/(t* - t) and q' = q²/√2.
        assert!(
            matches!(error, IntegrateError::Unbounded { t, component: 1, value }
                if (t - 1.854_074_677_301_372).abs() < 1e-6 && value > 1e20),
            "{error:?}"
        );
        assert!(error.to_string().contains("grows without bound at t = 1.854"), "{error}");
    }
}

/// q'' = q + cos t grows like e^t: what starts again from the motion itself names the motion, not a start.
#[test]
fn a_growing_motion_is_no_wrong_start() {
    let growing = from_fn(1, |t, q, _, a| a[0] = q[0] + t.cos()).unwrap().with_period(2.0 * PI).unwrap();
    let start = State::at_rest(1);
    for error in [
        Settle::new().max_periods(1000).run(&Dop853::new(), &growing, &start).unwrap_err().to_string(),
        Lyapunov::new().settle(100).run(&growing, &start).unwrap_err().to_string(),
        Dop853::new().end(&growing, &start, 200.0).map(|_| ()).unwrap_err().to_string(),
        Rk4::new(0.01).end(&growing, &start, 200.0).map(|_| ()).unwrap_err().to_string(),
    ] {
        assert!(
            !error.contains("start.")
                && (error.contains("grows without bound") || error.contains("exceeds 1e100")),
            "{error}"
        );
    }
}

#[test]
fn step_underflow() {
    /// v' = v² + 1, so that v = tan t: no step is short enough at the pole t = π/2.
    struct Pole;
    impl Model for Pole {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], _: &[f64], v: &[f64], a: &mut [f64]) {
            a[0] = v[0] * v[0] + 1.0 + 0.0 * u[0];
        }
    }
    for failed in [
        Rk45::new().trajectory(&Pole, &start(), 2.0).unwrap_err(),
        Dop853::new().trajectory(&Pole, &start(), 2.0).unwrap_err(),
    ] {
        // The pole of tan t.
        let place = std::f64::consts::FRAC_PI_2;
        assert!(
            matches!(failed.error, IntegrateError::Unbounded { t, .. } if (t - place).abs() < 1e-6),
            "{}",
            failed.error
        );
        assert!(failed.trajectory.len() > 10);
    }
}

#[test]
fn too_many_steps() {
    let failed = Rk4::new(0.1).max_steps(5).trajectory(&Broken(9.0), &start(), 1.0).unwrap_err();
    assert!(matches!(failed.error, IntegrateError::TooManySteps { limit: 5, t } if (t - 0.5).abs() < 1e-12));
    assert_eq!(failed.trajectory.len(), 6);
    let failed =
        Dop853::new().max_step(0.1).max_steps(5).trajectory(&Broken(9.0), &start(), 1.0).unwrap_err();
    assert!(matches!(failed.error, IntegrateError::TooManySteps { limit: 5, .. }));
}

#[test]
fn time_spans_tolerances_and_starts() {
    let model = Broken(9.0);
    for end in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = Dop853::new().end(&model, &start(), end).unwrap_err();
        assert!(
            matches!(error, IntegrateError::TimeSpan { start: 0.0, end: e } if e.to_bits() == end.to_bits()),
            "{error}"
        );
    }
    let setting = |error: IntegrateError, place: &str| {
        assert!(matches!(error, IntegrateError::Parameter(_)), "{error}");
        assert!(error.to_string().starts_with(&format!("{place} is ")), "{error}");
    };
    for bad in [0.0, -1e-9, f64::NAN] {
        setting(Dop853::new().rtol(bad).end(&model, &start(), 1.0).unwrap_err(), "rtol");
        setting(Dop853::new().atol(bad).end(&model, &start(), 1.0).unwrap_err(), "atol");
        setting(Rk45::new().atol_each(&[1e-9, bad]).end(&model, &start(), 1.0).unwrap_err(), "atol");
        setting(Rk45::new().max_step(bad).end(&model, &start(), 1.0).unwrap_err(), "max_step");
        setting(Rk45::new().first_step(bad).end(&model, &start(), 1.0).unwrap_err(), "first_step");
        setting(Rk4::new(bad).end(&model, &start(), 1.0).unwrap_err(), "step");
    }
    setting(Dop853::new().rtol(f64::INFINITY).end(&model, &start(), 1.0).unwrap_err(), "rtol");
    setting(Rk4::new(f64::INFINITY).end(&model, &start(), 1.0).unwrap_err(), "step");
    setting(Rk45::new().pi_beta(0.5).end(&model, &start(), 1.0).unwrap_err(), "pi_beta");
    let error = Rk45::new().atol_each(&[1e-9; 3]).end(&model, &start(), 1.0).unwrap_err();
    assert_eq!(error, P::Length { name: "atol".into(), expected: 2, found: 3 }.into());
    let error = Rk45::new().end(&model, &State::at_rest(3), 1.0).unwrap_err();
    assert_eq!(error, IntegrateError::Parameter(P::Length { name: "start.q".into(), expected: 1, found: 3 }));
    let error = Rk45::new().end(&model, &State::new(0.0, &[0.0], &[f64::NAN]), 1.0).unwrap_err();
    assert!(matches!(error, IntegrateError::Parameter(P::NotFinite { name, .. }) if name == "start.v[0]"));
    for times in [&[0.5, 0.4][..], &[-0.1], &[f64::NAN]] {
        let failed = Rk45::new().sample(&model, &start(), times).unwrap_err();
        assert!(matches!(failed.error, IntegrateError::OutputTime { .. }), "{}", failed.error);
    }
}

#[test]
fn a_model_whose_edges_do_not_lie_ahead() {
    struct Behind;
    impl Model for Behind {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = 0.0;
        }
        fn next_edge(&self, t: f64) -> Option<f64> {
            Some((t * 2.0).ceil() / 2.0)
        }
    }
    let failed = Rk4::new(0.1).trajectory(&Behind, &State::new(0.2, &[0.0], &[0.0]), 3.0).unwrap_err();
    assert_eq!(failed.error, IntegrateError::DriveEdge { t: 0.5, edge: 0.5 });
    assert_eq!(failed.trajectory.last().unwrap().t, 0.5);
}

/// A ring whose backlash is 2e-5 (1 + a cos ωt).
fn ring_of_backlash(a: f64) -> Ring<VaryingBacklash> {
    let width = Wave::new(Fourier::new(1e-5, &[[a * 1e-5, 0.0]]).unwrap());
    let mesh =
        Mesh::new(Wave::constant(2e8).unwrap(), Wave::constant(0.0).unwrap(), VaryingBacklash::new(width));
    let RingParams { motor, gears, mesh_damping, omega, teeth, .. } = set().params().unwrap();
    let params = RingParams { meshes: vec![mesh; 4], motor, gears, mesh_damping, omega, teeth };
    Ring::of_laws(&params, Frame::Inertial).unwrap()
}

#[test]
fn a_backlash_that_becomes_negative() {
    let ring = ring_of_backlash(2.0);
    let failed = Dop853::new().trajectory(&ring, &State::at_rest(9), 0.01).unwrap_err();
    // 1 + 2 cos ωt is negative from one third of the period on.
    let third = ring.period() / 3.0;
    assert!(
        matches!(failed.error, IntegrateError::NegativeGap { t, contact: 0, .. } if t >= third),
        "{}",
        failed.error
    );
}

/// Every engine of sweeps refuses a backlash that is negative for a third or for a twentieth of the period.
/// A backlash that reaches 0 is allowed.
#[test]
fn a_backlash_that_becomes_negative_in_sweeps() {
    fn each(engine: &impl SweepEngine<Ring<VaryingBacklash>>) -> Vec<Result<f64, PointError>> {
        let points = Points::from(Axis::of_values("a", &[2.0, 1.0 / (PI / 20.0).cos(), 1.0]).unwrap());
        let sweep = Sweep::new(points).settle(1).measure(2).rattle();
        let family = |p: &Point<'_>| Ok::<_, ParameterError>(ring_of_backlash(p["a"]));
        let rows = sweep.of(engine, family).start(|_, _| State::at_rest(9)).run().unwrap();
        (0..3).map(|point| rows.get(point).map(|row| row.contacts()[0].time[1])).collect()
    }
    let sampled = [each(&LaneRk4::new(400).lanes::<4>()), each(&TableRk4::new(400))];
    let located = [each(&Located(Dop853::new())), each(&LaneTaylor::new(Taylor::new()))];
    for shares in sampled.iter().chain(&located) {
        for share in &shares[..2] {
            let error = share.as_ref().unwrap_err();
            assert!(
                matches!(
                    error,
                    PointError::NegativeGap { contact: 0, .. }
                        | PointError::Integrate(IntegrateError::NegativeGap { contact: 0, .. })
                ),
                "{error}"
            );
        }
        assert!((0.0..=1.0).contains(shares[2].as_ref().unwrap()), "{:?}", shares[2]);
    }
}

/// A tooth in a gap whose edges are constants: q'' = load - q' - 100 f(q).
#[derive(Clone, PartialEq)]
struct FreeEdges;

impl Shape for FreeEdges {
    fn size(&self) -> Size {
        Size { dof: 1, contacts: 1, constants: 4, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "load", "lower edge", "upper edge"].map(|name| Channel::new(name, "1")).into()
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let [_, lower, upper] = u.constants();
        let at = Deflection { d: q[0], rate: v[0], lower, upper };
        let force = law.force(i, &Backlash::new(0.0).unwrap(), at) * 100.0;
        Contact { deflection: q[0], rate: v[0], lower, upper, force, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [load] = u.constants();
        a[0] = load - v[0] - self.contact(law, 0, u, q, v).force;
    }
}

/// Constants that put the lower edge above the upper one are refused at the start of a run, also where no contact is
/// measured and no edge is located. A gap of the width 0 is allowed.
#[test]
fn a_gap_that_is_negative_from_the_start() {
    let tooth = |[lower, upper]: [f64; 2]| {
        let constants = [("speed", 6.0), ("load", 1.0), ("lower edge", lower), ("upper edge", upper)];
        Machine::of_constants(FreeEdges, &constants).unwrap()
    };
    let (right, wrong) = (tooth([0.25, 0.25]), tooth([0.25, -0.5]));
    let linear = LinearError::NegativeGap { contact: 0, lower: 0.25, upper: -0.5 };
    for t in [None, Some(0.0)] {
        assert_eq!(static_state(&wrong, t).unwrap_err(), linear);
        assert!((static_state(&right, t).unwrap().state.q[0] - 0.26).abs() < 1e-12);
    }
    let start = State::at_rest(1);
    let integrate = IntegrateError::NegativeGap { t: 0.0, contact: 0, lower: 0.25, upper: -0.5 };
    for solver in
        [&Dop853::new() as &dyn Integrator, &Dop853::new().plain(), &Rk4::new(0.01).plain(), &Taylor::new()]
    {
        assert_eq!(solver.end(&wrong, &start, 1.0).unwrap_err(), integrate);
        assert!(solver.end(&right, &start, 1.0).is_ok());
    }
    fn each(
        engine: &impl SweepEngine<Machine<FreeEdges>>,
        models: [&Machine<FreeEdges>; 2],
    ) -> Vec<Option<PointError>> {
        let sweep =
            Sweep::new(Axis::of_values("model", &[0.0, 1.0]).unwrap()).settle(1).measure(1).channels(&["q0"]);
        let family = |p: &Point<'_>| Ok::<_, ParameterError>(models[p["model"] as usize].clone());
        let rows = sweep.of(engine, family).start(|_, _| State::at_rest(1)).run().unwrap();
        (0..2).map(|point| rows.get(point).err()).collect()
    }
    let refused = [None, Some(PointError::Integrate(integrate))];
    let models = [&right, &wrong];
    assert_eq!(each(&LaneRk4::new(200), models), refused);
    assert_eq!(each(&TableRk4::new(200), models), refused);
    assert_eq!(each(&LaneTaylor::new(Taylor::new()), models), refused);
    assert_eq!(each(&Located(Dop853::new()), models), refused);
    let noisy = NoisySteps::new(200, &[WhiteNoise::bath(0, 0.5, 0.3).unwrap()]);
    let noise = NoiseError::NegativeGap { contact: 0, lower: 0.25, upper: -0.5 };
    assert_eq!(noisy.ends(&wrong, &start, 1.0, 4).unwrap_err(), noise);
    assert!(noisy.ends(&right, &start, 1.0, 4).is_ok());
}

/// A lower edge that is not a number is not a flank without a lower one. A deflection that is not a number lies
/// on no piece.
#[test]
fn an_edge_that_is_not_a_number() {
    #[derive(Clone, PartialEq)]
    struct NoEdge {
        deflection: f64,
        lower: f64,
    }
    impl Shape for NoEdge {
        fn size(&self) -> Size {
            Size { dof: 1, contacts: 1, constants: 1, ..Size::default() }
        }
        fn names(&self) -> Vec<Channel> {
            vec![Channel::new("speed", "1")]
        }
        fn contact<S: Scalar, L: PieceChoice<S>>(
            &self,
            _: &L,
            _: usize,
            _: Drives<'_, S>,
            q: &[S],
            v: &[S],
        ) -> Contact<S> {
            let [lower, upper] = [self.lower, 0.5].map(S::from);
            Contact {
                deflection: q[0] + S::from(self.deflection),
                rate: v[0],
                lower,
                upper,
                ..Contact::default()
            }
        }
        fn accel<S: Scalar, L: PieceChoice<S>>(
            &self,
            _: &L,
            _: Drives<'_, S>,
            q: &[S],
            v: &[S],
            a: &mut [S],
        ) {
            a[0] = S::from(0.1) - v[0] - q[0];
        }
    }
    let machine = |shape: NoEdge| Machine::of_constants(shape, &[("speed", 6.0)]).unwrap();
    let model = machine(NoEdge { deflection: 0.0, lower: f64::NAN });
    let other = machine(NoEdge { deflection: f64::NAN, lower: -0.5 });
    let start = State::at_rest(1);
    let is_nan = |lower: f64| lower.is_nan();
    let of_static = static_state(&model, None).unwrap_err();
    assert!(matches!(of_static, LinearError::NegativeGap { contact: 0, lower, .. } if is_nan(lower)));
    for solver in [&Dop853::new() as &dyn Integrator, &Rk4::new(0.01).plain(), &Taylor::new()] {
        let error = solver.end(&model, &start, 1.0).unwrap_err();
        assert!(matches!(error, IntegrateError::NegativeGap { contact: 0, lower, .. } if is_nan(lower)));
        assert!(error.to_string().contains("not a number at t = 0.0: its lower edge is NaN"), "{error}");
        let error = solver.end(&other, &start, 1.0).unwrap_err();
        assert_eq!(error, IntegrateError::NoDeflection { t: 0.0, contact: 0 });
    }
}

#[test]
fn mesh_stiffness_that_is_not_positive() {
    let error = ring(|p| {
        p.meshes[2] = Mesh::new(
            Wave::constant(-1e8).unwrap(),
            Wave::constant(0.0).unwrap(),
            Backlash::new(0.0).unwrap(),
        );
    });
    assert!(matches!(&error, P::NotPositive { name, .. } if name == "meshes[2]: mean stiffness"), "{error}");
    let pair =
        NfgPair::new(&NfgParams { stiffness_harmonics: vec![[-4e8, 0.0]], ..NfgParams::table1() }).unwrap();
    assert!(matches!(
        pair.on_drive_flank().unwrap_err(),
        P::NotPositive { name, .. } if name == "mesh stiffness at the start"
    ));
}

#[test]
fn a_slot_of_a_mesh_that_does_not_exist() {
    let ring = Ring::new(&set().params().unwrap()).unwrap();
    assert_eq!(ring.clearance_slots(4).unwrap_err(), P::TooMany { name: "mesh".into(), value: 4, max: 3 });
    assert!(matches!(
        ring.slot("mesh damping 4").unwrap_err(),
        P::NoSuchConstant { name, .. } if name == "mesh damping 4"
    ));
}

/// Relative coordinates that do not close the ring are refused.
#[test]
fn inconsistent_relative_state() {
    let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params().unwrap()).unwrap();
    let view = ring.relative(2.65e-5, 1000.0).unwrap();
    let error = view.to_angles(0.0, &[0.0; 7], &[0.0; 7]).unwrap_err();
    assert!(
        matches!(&error, P::Inconsistent { name, .. } if name.contains("sum of the mesh rates")),
        "{error}"
    );
}

/// Numbers of all sizes, among them zero, NaN and infinities.
fn any() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -1e3..1e3f64,
        2 => 0.0..1.0f64,
        1 => prop::num::f64::ANY,
        1 => Just(0.0),
    ]
}

proptest! {
    #[test]
    fn pairs_never_panic(x in prop::collection::vec(any(), 12), teeth in 0u32..100) {
        let params = NfgParams {
            module: x[0], pinion_teeth: teeth, ratio: x[1].round(), eccentric_ratio: x[2],
            pressure_angle: x[3], load_torque: x[4], inertia: x[5], stiffness: x[6],
            stiffness_harmonics: vec![[x[7], x[8]]], damping_ratio: x[9], error: x[10],
            error_harmonics: vec![[x[11], x[0]]], half_backlash: x[1].abs(), speed: x[2].abs(),
        };
        if let Ok(pair) = NfgPair::new(&params) {
            let mut a = [0.0];
            let mut u = vec![0.0; pair.drives()];
            pair.drive(1.0, Side::After, &mut u);
            pair.accel(&u, &[1e-4], &[0.0], &mut a);
            let _ = pair.on_drive_flank();
        }
        if let Ok(pair) = NfgPair2::new(&params, x[3]) {
            let _ = pair.on_drive_flank();
        }
    }

    #[test]
    fn rings_never_panic(x in prop::collection::vec(any(), 14), gears in 0usize..6) {
        let set = RingSet {
            gears, rpm: x[0], motor_inertia: x[1], gear_inertia: x[2], load_inertia: x[3], base_radius: x[4],
            motor_shaft: Shaft { stiffness: x[5], damping: x[6] },
            output_shaft: Shaft { stiffness: x[7].abs(), damping: x[8].abs() },
            mesh_stiffness: x[9], mesh_damping: x[10], half_backlash: x[11], error: x[12],
            motor_torque: x[13],
            ..RingSet::set_a(gears, 1000.0)
        };
        if let Ok(ring) = set.params().and_then(|params| Ring::as_printed(&params)) {
            let n = ring.dof();
            prop_assert!(ring.rigid_acceleration().is_finite());
            prop_assert!(gear_dynamics::linear::Modes::mean_in_contact(&ring).is_ok());
            // A short run ends with a result or a typed error; it does not panic or hang.
            let _ = Dop853::new().max_steps(300).end(&ring, &State::at_rest(n), 1e-3);
        }
    }

    #[test]
    fn excitations_never_panic(x in prop::collection::vec(any(), 5), t in any()) {
        let mut all: Vec<Wave> = Vec::new();
        all.extend(Fourier::new(x[0], &[[x[1], x[2]]]).and_then(|f| Wave::new(f).with_phase(x[4])).ok());
        all.extend(
            RectangularWave::new(x[0], x[1], x[2])
                .and_then(|f| Wave::new(f).with_phase(x[4])?.per_turn(x[3] as u32))
                .ok()
        );
        all.extend(Table::new(&x[..4]).ok().map(Wave::new));
        all.extend(InstantCentre::new(x[0]).ok().map(|c| Wave::new(c.rotation())));
        prop_assume!(t.is_finite() && t.abs() < 1e6);
        for f in all {
            let jet = f.jet(t, Side::Before);
            prop_assert!(jet.value.is_finite(), "{:?} at {}", f, t);
            if let Some(edge) = f.next_edge(t) {
                prop_assert!(edge > t, "{:?} at {}: {}", f, t, edge);
            }
        }
    }

    #[test]
    fn laws_and_processes_never_panic(x in prop::collection::vec(any(), 6), t in any()) {
        let mut laws: Vec<MixedLaw> = Vec::new();
        laws.extend(Backlash::new(x[0]).ok().map(MixedLaw::Backlash));
        laws.extend(
            AsymmetricBacklash::new(x[0], x[1])
                .and_then(|l| l.with_slopes(x[2], x[3]))
                .ok()
                .map(MixedLaw::Asymmetric)
        );
        laws.extend(SmoothedBacklash::new(x[0], x[1]).ok().map(MixedLaw::Smoothed));
        laws.extend(Cubic::new(x[0], x[1]).ok().map(MixedLaw::Cubic));
        laws.extend(
            PowerLaw::new(x[0], x[1], x[2])
                .and_then(|l| l.with_edges(x[3], x[4]))
                .ok()
                .map(MixedLaw::Power)
        );
        laws.extend(NoPullBacklash::new(x[0], x[1]).ok().map(MixedLaw::NoPull));
        for law in laws {
            let _ = (law.at(x[4]), law.slope(x[5]));
            let _ = Damped::by_stiffness(law.clone(), x[2]).map(|l| l.at(x[4]));
            let _ = Damped::by_force(law, x[3]).map(|l| l.slope(x[5]));
        }
        if let Ok(process) = HeldProcess::of_values(x[0], &x[1..]) {
            prop_assert!(process.path(0).at(t, Side::Before).is_finite());
            let pair = NfgPair::new(&NfgParams::table1()).unwrap();
            let slots = [(x[1].abs() as usize) % 20, 3];
            if let Ok(held) = Noisy::new(pair)
                .add(&slots.map(|slot| (slot, x[2])), &process)
                .and_then(|h| h.add(&[(slots[0], -x[3]), (slots[1], x[3])], &process))
            {
                prop_assert!(held.next_edge(t).is_none_or(|edge| edge > t));
                let _ = Dop853::new().max_steps(40).end(&held, &State::at_rest(1), 10.0);
            }
        }
        let constant = |x: f64| Wave::constant(x);
        if let (Ok(k), Ok(e), Ok(law)) = (constant(x[0]), constant(x[1]), Backlash::new(x[2])) {
            let _ = Mesh::new(k.clone(), e, law);
            let _ = Scaled::new(x[4], k);
        }
        let _ = Function::new(|x: Jet| x).with_edges(&x);
        let _ = RectangularWave::of_contact_ratio(x[0], x[1], x[2]);
        let _ = Fourier::of_amplitudes(x[0], &[[x[1], x[2]]]);
        let _ = Fourier::fit(&x, x[0].abs() as usize);
        let _ = Table::new(&x);
        let _ = (Summary::of_samples(&x), Spectrum::new(&x, x[0], Window::Blackman));
    }

    /// Any setting of a solver gives a result or a typed error within the given number of steps.
    #[test]
    fn solver_settings_never_panic(x in prop::collection::vec(any(), 6)) {
        let model = Broken(9.0);
        let solver = Dop853::new()
            .rtol(x[0])
            .atol(x[1])
            .first_step(x[2])
            .max_step(x[3])
            .pi_beta(x[4])
            .max_steps(500);
        let _ = solver.end(&model, &start(), x[5]);
        let _ = Rk45::new().atol_each(&x[..2]).max_steps(500).trajectory(&model, &start(), x[5]);
        let _ = Rk4::new(x[0]).max_steps(500).sample(&model, &start(), &x[1..]);
        let pair = NfgPair::new(&NfgParams::table1()).unwrap();
        let _ = Settle::new()
            .tolerance(x[0])
            .max_periods(1)
            .run(&Dop853::new().max_steps(50), &pair, &State::new(x[1], &[x[2]], &[x[3]]));
    }

    #[test]
    fn relative_views_never_panic(x in prop::collection::vec(any(), 16)) {
        let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params().unwrap()).unwrap();
        if let Ok(view) = ring.relative(x[0], x[1]) {
            let (mut q, mut v) = (x[2..9].to_vec(), x[9..].to_vec());
            let _ = view.to_angles(0.0, &q, &v);
            let _ = view.close(0.0, &mut q, &mut v);
            let _ = view.to_angles(0.0, &q, &v);
            let _ = view.coefficients(&x[..3]);
        }
    }
}

#[test]
fn constants_given_twice_are_refused() {
    let pair = gear_dynamics::models::Oscillator::new(&[("speed", 1.0)]).unwrap();
    let error = pair.with_all(&[("speed", 1.1), ("force", 0.2), ("speed", 1.2)]).unwrap_err();
    assert!(matches!(&error, ParameterError::Twice { name } if name == "speed"), "{error}");
    assert_eq!(pair.with_all(&[("speed", 1.1), ("force", 0.2)]).unwrap().constant("speed").unwrap(), 1.1);
}

/// A contact whose upper edge is not a number has no gap.
#[test]
fn an_upper_edge_that_is_not_a_number_is_refused() {
    struct NoUpperEdge;
    impl Model for NoUpperEdge {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            a[0] = 0.1 - v[0] - q[0];
        }
        fn contacts(&self) -> usize {
            1
        }
        fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            out[0] =
                Contact { deflection: q[0], rate: v[0], lower: -1.0, upper: f64::NAN, ..Contact::default() };
        }
    }
    for solver in [&Dop853::new() as &dyn Integrator, &Rk4::new(0.01).plain(), &Rk4::new(0.01)] {
        let error = solver.end(&NoUpperEdge, &State::at_rest(1), 1.0).unwrap_err();
        assert!(
            matches!(error, IntegrateError::NegativeGap { contact: 0, upper, .. } if upper.is_nan()),
            "{error}"
        );
    }
}

/// An acceleration that a formula or a model forgets, or adds to what stands there, is not a number.
#[test]
fn accelerations_that_are_not_written() {
    let forgets = from_fn(2, |_, q, _, a| a[0] = -q[0]).unwrap();
    let adds = from_fn(2, |_, q, _, a| (0..2).for_each(|i| a[i] -= q[i])).unwrap();
    struct Forgets(usize);
    impl Model for Forgets {
        fn dof(&self) -> usize {
            self.0
        }
        fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            a.iter_mut().zip(q).skip(1).for_each(|(a, q)| *a = -q);
        }
    }
    let cases: [(&dyn Model, usize); 5] =
        [(&forgets, 1), (&adds, 0), (&Forgets(1), 0), (&Forgets(2), 0), (&Forgets(3), 0)];
    for (model, acceleration) in cases {
        let start = State::at_rest(model.dof());
        for solver in [&Rk4::new(0.1) as &dyn Integrator, &Rk45::new(), &Dop853::new(), &Rodas::new()] {
            let error = solver.end(model, &start, 1.0).unwrap_err();
            assert_eq!(error, IntegrateError::NotANumber { t: 0.0, acceleration });
        }
    }
    assert!(matches!(
        static_state(&forgets.with_period(1.0).unwrap(), 0.0),
        Err(LinearError::NotFinite { .. })
    ));
}

/// An observer that was made for a model of another shape is refused before the first step, by every solver,
/// alone and among others, and by the runs of an orbit.
#[test]
fn observers_of_another_model_are_refused() {
    let own = DeadZone { omega: 0.75, zeta: 0.05, mean: 0.1, amplitude: 0.03, stiffness: 0.0 };
    let spring = from_fn(2, |_, q, _, a| (a[0], a[1]) = (-q[0], -4.0 * q[1])).unwrap();
    let other = P::OtherModel { own: [1, 1], other: [2, 0] };
    let solvers: [&dyn Integrator; 4] = [&Rk4::new(0.01), &Rk45::new(), &Dop853::new(), &Rodas::new()];
    let start = State::new(0.0, &[1.0, 0.0], &[0.0, 0.0]);
    let mut observers: Vec<Box<dyn Observer + '_>> = vec![
        Box::new(Statistics::new(&own, &["q0"]).unwrap()),
        Box::new(Rattle::new(&own)),
        Box::new(Impacts::new(&own)),
        Box::new(Section::new(&own, "q0", 0.0, Direction::Both).unwrap()),
    ];
    for observer in &mut observers {
        for solver in solvers {
            let error = solver.run(&spring, &start, 1.0, observer.as_mut()).unwrap_err();
            assert_eq!(error, IntegrateError::Parameter(other.clone()));
        }
    }
    let (mut fits, mut rattle) = (Statistics::new(&spring, &["q0"]).unwrap(), Rattle::new(&own));
    let solver = Dop853::new();
    assert!(solver.run(&spring, &start, 1.0, &mut (&mut fits, &mut rattle)).is_err());
    assert!(solver.run(&spring, &start, 1.0, &mut [&mut fits as &mut dyn Observer, &mut rattle]).is_err());
    // One with a Taylor series, and the orbits of one with another number of coordinates.
    let pair = NfgPair::new(&NfgParams::table1()).unwrap();
    let mut section = Section::new(&spring, "q0", 0.0, Direction::Both).unwrap();
    let text = "an observer of a model with 2 coordinates and 0 contacts cannot follow one with 1 coordinates and 1 \
                contacts: make the observer of the model of the run";
    let error = Taylor::new().run(&pair, &pair.on_drive_flank().unwrap(), 1.0, &mut section).unwrap_err();
    assert_eq!(error.to_string(), text);
    let orbit = Shooting::new().solve(&own, &State::new(0.0, &[1.0], &[0.25])).unwrap();
    assert_eq!(orbit.observe(&own, &mut section).unwrap_err().to_string(), text);
    assert_eq!(orbit.record(&own).unwrap().replay(&mut section).unwrap_err().to_string(), text);
    assert!(section.states().is_empty() && fits.summary("q0").is_err());
}

/// A period that is not that of the accelerations is refused by all that counts in periods.
#[test]
fn a_wrong_period_is_refused_everywhere() {
    let swing = |period: f64| {
        let formula = from_fn(1, |t: f64, q: &[f64], v: &[f64], a: &mut [f64]| {
            a[0] = t.cos() + 0.5 * (0.5 * t).cos() - q[0] - 0.3 * v[0];
        });
        formula.unwrap().with_period(period).unwrap()
    };
    let (rest, is_period) =
        (State::at_rest(1), |e: &P| matches!(e, P::Wrong { name, .. } if name == "period of the model"));
    // The period is 4π; that of the first term alone and any other number are not.
    for (period, right) in [(4.0 * PI, true), (2.0 * PI, false), (3.0, false)] {
        let model = swing(period);
        let settled = Settle::new().run(&Dop853::new(), &model, &rest);
        let exponents = Lyapunov::new().settle(2).measure(8).run(&model, &rest);
        let row = |rows: Rows| rows.get(0).map(|_| ());
        let sweep = Sweep::new(Axis::of_values("f", &[1.0]).unwrap()).settle(4).measure(1).channels(&["q0"]);
        let family = |_: &Point<'_>| Ok::<_, ParameterError>(swing(period));
        let start = |_: &Point<'_>, _: &_| State::at_rest(1);
        let table = row(sweep.of(&TableRk4::new(200), family).start(start).run().unwrap());
        let located = row(sweep.of(&Located(Dop853::new()), family).start(start).run().unwrap());
        if right {
            assert!(settled.is_ok() && exponents.is_ok() && table.is_ok() && located.is_ok());
            continue;
        }
        assert!(matches!(settled.unwrap_err(), SettleError::Parameter(e) if is_period(&e)));
        assert!(matches!(exponents.unwrap_err(), LyapunovError::Parameter(e) if is_period(&e)));
        for refused in [table, located] {
            assert!(matches!(refused.unwrap_err(), PointError::Parameter(e) if is_period(&e)));
        }
    }
}

/// An orbit is read with its own model only: with that of another speed its segments do not end at their nodes.
#[test]
fn an_orbit_is_not_observed_with_another_model() {
    let model = |omega: f64| DeadZone { omega, zeta: 0.05, mean: 0.1, amplitude: 0.03, stiffness: 0.0 };
    let (own, other) = (model(0.75), model(0.8));
    let orbit = Shooting::new().solve(&own, &State::new(0.0, &[1.0], &[0.25])).unwrap();
    let ppv = |of: &DeadZone| {
        let mut statistics = Statistics::new(of, &["q0"]).unwrap();
        orbit.observe(of, &mut statistics).map(|_| statistics.summary("q0").unwrap().peak_to_peak())
    };
    assert!(ppv(&own).unwrap() > 0.1 && orbit.record(&own).is_ok());
    assert!(
        matches!(ppv(&other).unwrap_err(), IntegrateError::OtherOrbit { segment: 0, miss } if miss > 0.01)
    );
    assert!(matches!(orbit.record(&other).unwrap_err(), IntegrateError::OtherOrbit { .. }));
}
