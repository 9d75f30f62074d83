//! Floquet multipliers against closed forms.

use crate::api::*;
use crate::common::oscillators::Mathieu;
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

#[test]
fn damped_mathieu() {
    let file = crate::data::read("periodic_orbits.json");
    let theirs = &file["extra"]["mathieu_z0.05_k0.2_Om2.0"];
    let model = Mathieu { omega: 2.0, zeta: 0.05, depth: 0.2 };
    let cycle = Shooting::new().solve(&model, &State::at_rest(1)).unwrap();
    let (multipliers, estimate) = (cycle.multipliers().values(), cycle.multipliers().value_error());
    for ours in multipliers {
        let nearest = |z: &serde_json::Value| {
            (ours - Complex64::new(z[0].as_f64().unwrap(), z[1].as_f64().unwrap())).norm()
        };
        let error =
            theirs["multipliers"].as_array().unwrap().iter().map(nearest).fold(f64::INFINITY, f64::min);
        println!("{ours}: {error:.1e}, estimate {estimate:.1e}");
        assert!(error < 1e-10);
    }
    // Liouville: the determinant is exp(-2 ζ T) with T = π.
    assert!((cycle.monodromy().determinant() - (-0.1 * PI).exp()).abs() < 1e-11);
    assert_eq!(cycle.stability(), Stability::Stable); // max |μ| is 9e-5 below 1
}

/// The multipliers of q'' + 2 ζ q' + q = cos Ωt are e^{λT}, with ζ = 0.1 and Ω = 0.7.
#[test]
fn damped_oscillator() {
    struct Forced;
    impl Model for Forced {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            a[0] = (0.7 * u[0]).cos() - 0.2 * v[0] - q[0];
        }
    }
    impl Periodic for Forced {
        fn period(&self) -> f64 {
            TAU / 0.7
        }
    }
    let cycle = Shooting::new().solve(&Forced, &State::new(0.0, &[5.0], &[-1.0])).unwrap();
    let exact = (Complex64::new(-0.1, 0.99f64.sqrt()) * Forced.period()).exp();
    for ours in cycle.multipliers().values() {
        assert!((ours - exact).norm().min((ours - exact.conj()).norm()) < 1e-10, "{ours} {exact}");
    }
    for growth in cycle.multipliers().growth(cycle.period()) {
        assert!((growth + 0.1).abs() < 1e-10);
    }
}

/// x'' + 2 ζ x' + (δ ± ε) x = 0, the Meissner equation: the sign changes every half period π.
struct Meissner {
    delta: f64,
    epsilon: f64,
    zeta: f64,
}

impl Meissner {
    /// Trace of the monodromy matrix without damping: 2 cos a cos b - (w1/w2 + w2/w1) sin a sin b.
    fn trace(&self) -> f64 {
        let (w1, w2) = ((self.delta + self.epsilon).sqrt(), (self.delta - self.epsilon).sqrt());
        let (a, b) = (PI * w1, PI * w2);
        2.0 * a.cos() * b.cos() - (w1 / w2 + w2 / w1) * a.sin() * b.sin()
    }
}

impl Model for Meissner {
    fn dof(&self) -> usize {
        1
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        let turns = t / PI;
        let half = if side == Side::After { turns.floor() } else { turns.ceil() - 1.0 };
        u[0] = if half.rem_euclid(2.0) == 0.0 { self.epsilon } else { -self.epsilon };
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        let next = ((t / PI).floor() + 1.0) * PI;
        Some(if next > t { next } else { next + PI })
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = -2.0 * self.zeta * v[0] - (self.delta + u[0]) * q[0];
    }
}

impl Periodic for Meissner {
    fn period(&self) -> f64 {
        TAU
    }
}

/// A stiffness that jumps: the trace in closed form, and the stability on both sides of a boundary.
#[test]
fn meissner() {
    for delta in [0.3, 0.9, 1.4, 2.6] {
        let model = Meissner { delta, epsilon: 0.2, zeta: 0.0 };
        let turn = Variation::new().flow_tolerance(1e-13).run(&model, &State::at_rest(1), TAU).unwrap();
        assert!(
            (turn.matrix.trace() - model.trace()).abs() < 1e-10,
            "{delta}: {} {}",
            turn.matrix.trace(),
            model.trace()
        );
        let expected = if model.trace().abs() > 2.0 { Stability::Unstable } else { Stability::Undecided };
        assert_eq!(Multipliers::of_monodromy(&turn.matrix, 1e-9).unwrap().stability(), expected);
    }
    // The boundary near δ = 1/4, where the trace is -2, by bisection on the closed form.
    let trace = |delta: f64| Meissner { delta, epsilon: 0.2, zeta: 0.0 }.trace();
    let (mut lo, mut hi) = (0.26, 0.45);
    assert!(trace(lo) < -2.0 && trace(hi) > -2.0);
    for _ in 0..60 {
        let middle = 0.5 * (lo + hi);
        if trace(middle) < -2.0 { lo = middle } else { hi = middle }
    }
    for (delta, expected) in [(lo - 1e-6, Stability::Unstable), (lo + 1e-6, Stability::Undecided)] {
        let turn = Variation::new()
            .flow_tolerance(1e-13)
            .run(&Meissner { delta, epsilon: 0.2, zeta: 0.0 }, &State::at_rest(1), TAU)
            .unwrap();
        assert_eq!(Multipliers::of_monodromy(&turn.matrix, 1e-9).unwrap().stability(), expected, "{delta}");
    }
    // With damping the orbit is stable.
    let damped = Shooting::new()
        .solve(&Meissner { delta: lo + 1e-3, epsilon: 0.2, zeta: 1e-3 }, &State::at_rest(1))
        .unwrap();
    assert_eq!(damped.stability(), Stability::Stable);
}

#[test]
fn multipliers_of_anything() {
    assert!(Multipliers::of_monodromy(&nalgebra::DMatrix::from_element(2, 2, f64::NAN), 0.0).is_err());
    assert!(Multipliers::of_monodromy(&nalgebra::DMatrix::zeros(2, 3), 0.0).is_err());
    let none = Multipliers::new(Vec::new(), 0.0);
    assert_eq!((none.largest(), none.stability()), (0.0, Stability::Stable));
    let close = |error| Multipliers::new(vec![Complex64::new(0.0, 0.999), Complex64::new(-0.5, 0.0)], error);
    assert_eq!(close(1e-2).stability(), Stability::Undecided);
    assert_eq!(close(1e-4).stability(), Stability::Stable);
}
