//! Modes of stiffness and inertia over many orders of magnitude: against closed forms and eigenvalues of 60 digits.

use crate::api::*;
use gear_dynamics::Wave;
use gear_dynamics::linear::Modes;
use gear_dynamics::model::{Jacobian, Offers};
use gear_dynamics::trains::{Body, MeshPart, Parts, ShaftPart, Warning};

/// Masses in a row: springs between neighbours, springs to the ground, and drag per mass.
struct Chain<'c> {
    masses: &'c [f64],
    springs: &'c [f64],
    grounds: &'c [f64],
    drag: f64,
}

impl Model for Chain<'_> {
    fn dof(&self) -> usize {
        self.masses.len()
    }
    fn accel(&self, _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let mut j = Jacobian::new(q.len());
        self.jacobian(None, &[], q, v, &mut j);
        for (i, a) in a.iter_mut().enumerate() {
            *a = (0..q.len()).map(|k| j.q[(i, k)] * q[k] + j.v[(i, k)] * v[k]).sum();
        }
    }
    fn offers(&self) -> Offers<'_> {
        Offers { jacobian: true, ..Offers::default() }
    }
    fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], _: &[f64], _: &[f64], out: &mut Jacobian) {
        out.q.fill(0.0);
        out.v.fill(0.0);
        for (i, m) in self.masses.iter().enumerate() {
            out.q[(i, i)] -= self.grounds[i] / m;
            out.v[(i, i)] = -self.drag;
        }
        for (i, k) in self.springs.iter().enumerate() {
            for [a, b] in [[i, i + 1], [i + 1, i]] {
                out.q[(a, a)] -= k / self.masses[a];
                out.q[(a, b)] += k / self.masses[a];
            }
        }
    }
}

fn modes(masses: &[f64], springs: &[f64], grounds: &[f64], drag: f64) -> Modes {
    let chain = Chain { masses, springs, grounds, drag };
    Modes::about(&chain, &State::at_rest(masses.len()), None).unwrap()
}

/// Two masses on a spring k between them and one of g on the first: ω² are the roots of
/// m1 m2 ω⁴ - (m2 (k + g) + m1 k) ω² + k g.
#[test]
fn two_masses_with_stiffnesses_over_twelve_orders() {
    for (k, g) in [(1e12, 1.0), (1e12, 1e-1), (1e10, 3.0), (1.0, 1e12)] {
        for [m1, m2] in [[1.0, 1.0], [1e-9, 2.0], [3.0, 1e-9]] {
            let modes = modes(&[m1, m2], &[k], &[g, 0.0], 0.0);
            let (b, c) = (m2 * (k + g) + m1 * k, k * g);
            let high = (b + (b * b - 4.0 * m1 * m2 * c).sqrt()) / (2.0 * m1 * m2);
            let low = c / (m1 * m2) / high;
            assert_eq!((modes.rigid_count(), modes.unstable_count()), (0, 0), "{k} {g} {m1} {m2}");
            for (mode, exact) in modes.all().iter().zip([low, high]) {
                // k + g keeps g to ε k/g.
                let error = (mode.square() / exact - 1.0).abs();
                assert!(error <= mode.rounding(), "{k} {g} {m1} {m2}: {error} {}", mode.rounding());
                assert!(mode.is_resolved() && mode.rounding() < 2e-14 * (k / g).max(g / k).max(1.0));
            }
            assert_eq!(modes.eigenvalues().len(), 2, "both oscillate");
        }
    }
}

#[test]
fn a_body_of_small_inertia_leaves_its_neighbours_their_digits() {
    // Free: 1 - light - 1 on springs 2: ω² = 0, 2 and 2 (2/m + 1).
    for light in [1e-3, 1e-9, 1e-13, 1e-20] {
        let modes = modes(&[1.0, light, 1.0], &[2.0, 2.0], &[0.0; 3], 0.1);
        assert_eq!(modes.rigid_count(), 1);
        let exact = [0.0, 2.0, 2.0 * (2.0 / light + 1.0)];
        for (mode, exact) in modes.all().iter().zip(exact) {
            assert!((mode.square() - exact).abs() <= 1e-13 * exact, "{light}: {} {exact}", mode.square());
        }
        // λ² + 0.1 λ + 2 = 0 of the soft mode. Its eigenvalue has an error of ε of the largest one.
        let soft = modes.eigenvalues()[0];
        if light > 1e-10 {
            assert!((soft.re + 0.05).abs() < 1e-8 && (soft.norm() - 2f64.sqrt()).abs() < 1e-8, "{soft}");
        }
    }
}

#[test]
fn rigid_motions_are_counted_whatever_the_stiffness_is() {
    for k in [1e-12, 1.0, 1e12] {
        let pairs = modes(&[1.0, 2.0, 3.0, 1e-9], &[k, 0.0, 1.0], &[0.0; 4], 0.0);
        assert_eq!((pairs.rigid_count(), pairs.eigenvalues().len()), (2, 2));
    }
    // What double precision does not hold is said: 1e12 + 1e-9 = 1e12.
    let lost = modes(&[1.0, 1.0], &[1e12], &[1e-9, 0.0], 0.0);
    assert!(lost.rigid_count() == 1 || !lost.all()[0].is_resolved());
    let weak = modes(&[1.0, 1.0], &[1e12], &[5e-2, 0.0], 0.0);
    assert!(weak.rigid_count() == 0 && weak.all()[0].rounding() > 0.01);
}

/// A motor on a shaft with a pinion of small inertia, whose teeth are stiff, and a load on a soft shaft.
#[test]
fn a_train_with_a_light_pinion_and_stiff_teeth() {
    let mut parts = Parts::new();
    parts.body("motor", Body::new(0.02)).body("pinion", Body::new(1e-10));
    parts.body("wheel", Body::new(3e-3)).body("load", Body::new(40.0));
    parts.shaft("input", "motor", "pinion", ShaftPart::new(50.0));
    let teeth = MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(1e12).unwrap());
    parts.mesh("mesh", "pinion", "wheel", teeth).shaft("output", "wheel", "load", ShaftPart::new(20.0));
    let parts = parts.accept(Warning::UnusualValue);
    let modes = Modes::in_contact(&parts.build("motor", 100.0).unwrap(), 0.0).unwrap();
    assert_eq!(modes.rigid_count(), 1);
    // By mpmath with 60 digits.
    let exact = [14.861_970_011_173_396, 274.978_074_690_243_4];
    for (mode, exact) in modes.all()[1..].iter().zip(exact) {
        assert!((mode.frequency() / exact - 1.0).abs() < 1e-9 + mode.rounding(), "{}", mode.frequency());
        assert!(mode.is_resolved());
    }
    let error = {
        let mut parts = Parts::new();
        parts.body("pinion", Body::new(0.0)).body("wheel", Body::new(1.0));
        let teeth = MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(1e8).unwrap());
        parts.mesh("mesh", "pinion", "wheel", teeth);
        parts.build("pinion", 1.0).unwrap_err()
    };
    assert!(error.to_string().contains("has no inertia") && error.to_string().contains("k1 k2/(k1 + k2)"));
}
