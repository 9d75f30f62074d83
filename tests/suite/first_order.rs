//! Coordinates of which only the velocity acts: rotors that a drag holds, and states of first order.

use crate::api::*;
use gear_dynamics::branches::{Continuation, Family};
use gear_dynamics::linear::static_state;
use gear_dynamics::trains::{Body, MeshPart, Parts, ShaftPart, Train, Warning};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// v' = F + P cos t - c v over the period 2π: v = F/c + P (c cos t + sin t)/(1 + c²).
fn rotor([mean, swing, drag]: [f64; 3]) -> impl Periodic {
    let rotor = from_fn(1, move |t, _, v, a| a[0] = mean + swing * t.cos() - drag * v[0]).unwrap();
    rotor.with_period(TAU).unwrap()
}

#[test]
fn a_rotor_that_a_drag_holds_is_the_closed_form() {
    for [mean, swing, drag] in [[0.3, 0.7, 0.2], [-2.0, 0.1, 1.3], [0.0, 1.0, 0.05], [40.0, 1e-3, 0.4]] {
        let (model, rest) = (rotor([mean, swing, drag]), State::at_rest(1));
        let exact = mean / drag + swing * drag / (1.0 + drag * drag);
        let size = exact.abs().max(swing);
        let orbit = Shooting::new().solve(&model, &rest).unwrap();
        assert!((orbit.states()[0].v[0] - exact).abs() < 1e-10 * size, "{:?}", orbit.states());
        assert!((orbit.drift().0[0] - TAU * mean / drag).abs() < 1e-9 * size.max(TAU * mean.abs() / drag));
        assert_eq!(orbit.drift().1, [0.0]);
        assert_eq!(orbit.multipliers().values().len(), 1);
        assert!((orbit.multipliers().values()[0].re - (-TAU * drag).exp()).abs() < 1e-9);
        let settled = Settle::new().max_periods(400).run(&Dop853::new(), &model, &rest).unwrap();
        assert!((settled.state.v[0] - exact).abs() < 1e-7 * size && settled.period_multiple == 1);
        let lyapunov = Lyapunov::new().count(2).settle(60).align(80).measure(20);
        let exponents = lyapunov.run(&model, &rest).unwrap();
        let [neutral, decay] = exponents.per_period()[..] else { panic!("two exponents") };
        assert!(neutral.abs() < 1e-6 && (decay + TAU * drag).abs() < 1e-6, "{neutral} {decay}");
    }
}

#[test]
fn a_balance_finds_the_mean_speed_of_a_rotor() {
    for [mean, swing, drag] in [[0.3, 0.7, 0.2], [-2.0, 0.1, 1.3], [0.0, 1.0, 0.05], [40.0, 1e-3, 0.4]] {
        let model = rotor([mean, swing, drag]);
        let orbit = Balance::new(Harmonics::up_to(3)).solve(&model, None).unwrap();
        let exact = |t: f64| mean / drag + swing * (drag * t.cos() + t.sin()) / (1.0 + drag * drag);
        assert!((orbit.mean_velocity()[0] - mean / drag).abs() < 1e-12 * (mean / drag).abs().max(1.0));
        for t in [0.0, 1.0, 4.0] {
            assert!((orbit.at(t).v[0] - exact(t)).abs() < 1e-11 * exact(t).abs().max(1.0));
        }
        // ∫ v dt from 0.
        let place = mean / drag * 2.0 + swing * (drag * 2f64.sin() + 1.0 - 2f64.cos()) / (1.0 + drag * drag);
        assert!((orbit.at(2.0).q[0] - orbit.at(0.0).q[0] - place).abs() < 1e-10 * place.abs().max(1.0));
        let multipliers = Balance::new(Harmonics::up_to(3)).multipliers(&model, &orbit).unwrap();
        assert_eq!(multipliers.values().len(), 1);
        assert!((multipliers.values()[0].re - (-TAU * drag).exp()).abs() < 1e-7);
    }
}

/// The load of a drag, a ripple and a mesh that jumps: the mean loads of 414 intervals balance on the teeth.
#[test]
fn a_ripple_and_a_drag_leave_the_mean_loads_on_the_teeth() {
    let mut parts = Parts::new();
    for (name, drag) in [("p0", 0.0), ("w0", 0.02), ("p1", 0.0), ("w1", 0.0)] {
        parts.body(name, Body::new(1e-3).drag(drag));
    }
    let jumping = Wave::new(RectangularWave::of_contact_ratio(1.5, 1.6e8, 2.4e8).unwrap());
    for (name, [first, second], [z1, z2], stiffness) in [
        ("first", ["p0", "w0"], [23, 102], Wave::constant(2e8).unwrap()),
        ("second", ["p1", "w1"], [27, 107], jumping),
    ] {
        let mesh = MeshPart::external([z1, z2], [1e-3 * f64::from(z1), 1e-3 * f64::from(z2)], stiffness);
        parts.mesh(name, first, second, mesh.half_backlash(2e-5));
    }
    parts.shaft("shaft", "w0", "p1", ShaftPart::new(1e4).damping(1.0));
    let ripple =
        [[0.0965, -0.3626], [0.2916, -0.4513], [0.3211, -0.3781], [0.321, -0.022], [0.1844, -0.3261]];
    parts.torque("drive", "p0", 10.0).load("w1");
    parts.torque_of_angle("ripple", "p0", 40.0, Wave::new(Fourier::new(0.0, &ripple).unwrap()));
    let rest = static_state(&parts.build("p0", 100.0).unwrap(), None).unwrap();
    assert_eq!(rest.instant, None);
    // T/r of the first mesh, and T z₂/(z₁ r) of the second.
    for (contact, force) in rest.contacts.iter().zip([10.0 / 0.023, 10.0 / 0.023 * 0.102 / 0.027]) {
        assert!((contact.force / force - 1.0).abs() < 1e-7, "{} {force}", contact.force);
    }
}

/// A train on which a drive, a load and a drag act: its mean speed is that at which they balance.
fn train(drag: f64) -> Train {
    let mut parts = Parts::new();
    let stiffness = Wave::new(Fourier::new(2e8, &[[0.2e8, 0.0]]).unwrap());
    let mesh = MeshPart::external([20, 40], [0.03, 0.06], stiffness).half_backlash(5e-5).damping(2000.0);
    parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(4e-3).drag(drag));
    parts.mesh("mesh", "pinion", "wheel", mesh);
    parts.torque("drive", "pinion", 30.0).torque("load", "wheel", -10.0);
    parts.accept(Warning::Unbalanced).build("pinion", 100.0).unwrap()
}

#[test]
fn a_train_with_a_drag_has_orbits_branches_and_multipliers() {
    let model = train(0.5);
    // 30 N m times 2, less 10 N m, over 0.5 N m s.
    let speed = 100.0;
    let orbit = Shooting::new().solve(&model, None).unwrap();
    let period = orbit.period();
    let [of_pinion, of_wheel] = orbit.drift().0[..] else { panic!("two bodies") };
    assert!((of_wheel / period - speed).abs() < 1e-8, "{}", of_wheel / period);
    assert!((of_pinion / period - 2.0 * speed).abs() < 1e-8);
    // The rotation decays with c/(J_wheel + 4 J_pinion); it is the slowest of three.
    let slowest = orbit.multipliers().values()[0];
    assert_eq!(orbit.multipliers().values().len(), 3);
    assert!((slowest.re - (-0.5 / 8e-3 * period).exp()).abs() < 1e-3, "{slowest}");

    let sweep = Sweep::new(Axis::of_values("drive", &[25.0, 35.0]).unwrap())
        .settle(400)
        .measure(4)
        .channels(&["v1"])
        .multipliers(Shooting::new());
    let rows = sweep.over(&LaneTaylor::new(Taylor::new()), &model).unwrap().run().unwrap();
    for (row, drive) in rows.iter().zip([25.0, 35.0]) {
        assert_eq!(row.period_multiple(), Some(1));
        assert!((row.channel("v1").unwrap().mean - (2.0 * drive - 10.0) / 0.5).abs() < 1e-6);
        assert!((row.multipliers().unwrap().values()[0] - slowest).norm() < 1e-9);
    }

    let family = Family::over(&model, ["drive"]).unwrap();
    let branch = Continuation::new(30.0, 60.0).run(&family, &orbit.states()[0]).unwrap();
    assert!(branch.points().len() < 100, "{}", branch.points().len());
    assert!(branch.points().iter().all(|point| point.stability() == Stability::Stable));
    let last = &branch.points()[branch.points().len() - 1];
    assert_eq!(last.parameter, 60.0);

    let series = Balance::new(Harmonics::up_to(12)).solve(&model, None).unwrap();
    assert!((series.mean_velocity()[1] - speed).abs() < 1e-9, "{:?}", series.mean_velocity());
    let State { q, v, .. } = &orbit.states()[0];
    let of_mesh = |y: &[f64]| 0.03 * y[0] - 0.06 * y[1];
    let at_first = series.at(0.0);
    assert!((of_mesh(&at_first.q) - of_mesh(q)).abs() < 1e-9 * of_mesh(q).abs());
    assert!((0..2).all(|i| (at_first.v[i] - v[i]).abs() < 1e-8));
    let by_balance = Continuation::new(30.0, 60.0).run(&family, &series);
    let points = by_balance.unwrap().points().len();
    assert!(points < 200, "{points}");
}

/// A direct-current motor drives a fan: the speeds vibrate about a mean that no place restores, and the motion
/// repeats but for the angle.
#[test]
fn a_motor_and_a_fan_repeat_but_for_their_angle() {
    let mut parts = Parts::new();
    let stiffness = Wave::new(Fourier::new(2e8, &[[4e7, 0.0]]).unwrap());
    let error = Wave::new(Fourier::new(0.0, &[[0.0, 3e-6]]).unwrap());
    let mesh = MeshPart::external([20, 40], [0.02, 0.04], stiffness).error(error).damping(900.0);
    parts.body("motor", Body::new(8e-3)).body("wheel", Body::new(2e-2));
    parts.mesh("mesh", "motor", "wheel", mesh.half_backlash(3e-5));
    parts.torque_of_speed("dc", "motor", 20.0, &[2.0, -0.01]);
    parts.torque_of_speed("fan", "wheel", -40.0, &[0.0, 0.0, 4e-4]);
    let train = parts.build("motor", 100.0).unwrap();
    let settled = Settle::new().tolerance(1e-8).run(&Dop853::new(), &train, None).unwrap();
    assert_eq!(settled.period_multiple, 1);
    let orbit = Shooting::new().solve(&train, &settled.state).unwrap();
    assert_eq!(orbit.stability(), Stability::Stable);
    // The fan takes the mean of Ω², which is above the square of the mean: the rotor turns slower.
    let mean = orbit.drift().0[0] / orbit.period();
    assert!((-2e-4..-1e-5).contains(&mean), "{mean}");
    let rows = Sweep::new(Axis::of_values("dc", &[20.0]).unwrap()).settle(300).measure(2).channels(&["v0"]);
    let rows = rows.over(&LaneTaylor::new(Taylor::new()), &train).unwrap().run().unwrap();
    let row = rows.get(0).unwrap();
    assert_eq!(row.period_multiple(), Some(1));
    assert!((row.channel("v0").unwrap().mean - mean).abs() < 1e-8);
}

/// At rest a drag has no torque: the bodies share the load as without it.
#[test]
fn static_states_do_not_feel_a_drag() {
    let [with, without] = [0.5, 0.0].map(|drag| static_state(&train(drag), 1e-4).unwrap());
    assert!((with.contacts[0].force / without.contacts[0].force - 1.0).abs() < 1e-12);
    assert!(with.acceleration.iter().zip(&without.acceleration).all(|(a, b)| (a / b - 1.0).abs() < 1e-9));
}

/// q'' + 0.1 q' + g(q) = 0.5 i, i' = 0.4 + 0.6 cos t - 0.3 i - 0.5 q': a mass in a gap, driven by a current.
fn driven(t: f64, [q, v, i]: [f64; 3]) -> [f64; 3] {
    let force = (q - 1.0).max(0.0) - (-q - 1.0).max(0.0);
    [v, 0.5 * i - 0.1 * v - force, 0.4 + 0.6 * t.cos() - 0.3 * i - 0.5 * v]
}

#[test]
fn a_current_beside_a_gap_is_that_of_a_system_of_first_order() {
    // The reference integrates (q, q', i) itself, without a coordinate of the current.
    let (steps, mut y) = (20_000, [0.0; 3]);
    let h = TAU / steps as f64;
    for step in 0..60 * steps {
        let t = step as f64 * h;
        let at = |k: [f64; 3], part: f64| std::array::from_fn(|j| y[j] + part * h * k[j]);
        let k1 = driven(t, y);
        let k2 = driven(t + 0.5 * h, at(k1, 0.5));
        let k3 = driven(t + 0.5 * h, at(k2, 0.5));
        let k4 = driven(t + h, at(k3, 1.0));
        y = std::array::from_fn(|j| y[j] + h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]));
    }
    let model = from_fn(2, |t, q, v, a| {
        let [_, of_v, of_i] = driven(t, [q[0], v[0], v[1]]);
        (a[0], a[1]) = (of_v, of_i);
    });
    let model = model.unwrap().with_period(TAU).unwrap();
    let settled = Settle::new().tolerance(1e-6).run(&Dop853::new(), &model, None).unwrap();
    let orbit = Shooting::new().solve(&model, &settled.state).unwrap();
    let State { q, v, .. } = &orbit.states()[0];
    let apart = [q[0] - y[0], v[0] - y[1], v[1] - y[2]].map(f64::abs);
    assert!(apart.iter().all(|apart| *apart < 1e-6), "{apart:?}");
    // ∫ (0.4 + 0.6 cos t - 0.3 i) dt = 0 over a period: the mean current is 4/3.
    assert!((orbit.drift().0[1] - TAU * 4.0 / 3.0).abs() < 1e-8);
    // The determinant of the flow is exp(-0.4 T).
    let product: Complex64 = orbit.multipliers().values().iter().product();
    assert_eq!(orbit.multipliers().values().len(), 3);
    assert!((product.re / (-0.4 * TAU).exp() - 1.0).abs() < 1e-6, "{product}");
}
