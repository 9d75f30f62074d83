//! Modes of stiffness and inertia over many orders of magnitude: against closed forms and eigenvalues of 60
//! digits.

use crate::api::*;
use crate::common::random::Random;
use gear_dynamics::Wave;
use gear_dynamics::linear::{Campbell, Modes};
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
        let stated = modes.damped()[0];
        let exact = num_complex::Complex64::new(-0.05, (2.0 - 0.05f64.powi(2)).sqrt());
        assert!((soft - exact).norm() <= stated.rounding * soft.norm(), "{light}: {soft}");
        assert!(stated.is_resolved(), "{light}: {}", stated.rounding);
        if light > 1e-10 {
            assert!((soft.re + 0.05).abs() < 1e-8 && (soft.norm() - 2f64.sqrt()).abs() < 1e-8, "{soft}");
        }
    }
}

/// Chains of masses over 12 and of springs over 14 orders, with the drag 2 d on each mass: λ² + 2 d λ + ω² = 0 for
/// every ω of the undamped list.
#[test]
fn errors_of_damped_modes_are_stated() {
    let mut random = Random(48);
    let mut resolved = 0;
    for case in 0..400 {
        let n = 2 + (random.next() * 4.0) as usize;
        let masses: Vec<f64> = (0..n).map(|_| 10f64.powf(-12.0 * random.next())).collect();
        let springs: Vec<f64> = (1..n).map(|_| 10f64.powf(14.0 * random.next() - 2.0)).collect();
        let (held, soft) = (random.next() < 0.5, 10f64.powf(6.0 * random.next() - 5.0));
        let grounds: Vec<f64> = (0..n).map(|i| if i == 0 && held { soft } else { 0.0 }).collect();
        let drag = if random.next() < 0.5 { 0.0 } else { 2.0 * 10f64.powf(4.0 * random.next() - 3.0) };
        let modes = modes(&masses, &springs, &grounds, drag);
        let damped: Vec<_> = modes.eigenvalues().iter().zip(modes.damped()).collect();
        for mode in modes.all().iter().filter(|mode| mode.is_resolved() && mode.frequency() > 0.5 * drag) {
            let exact = num_complex::Complex64::new(-0.5 * drag, (mode.square() - 0.25 * drag * drag).sqrt());
            // ω itself has an error of half of that of its square.
            let of_square = 0.5 * mode.rounding() * mode.square() / exact.norm();
            let off = damped.iter().map(|(value, damped)| {
                (**value - exact).norm() / (damped.rounding * value.norm() + of_square)
            });
            let off = off.fold(f64::INFINITY, f64::min);
            assert!(off <= 1.0, "{case}: {exact} is {off:.1e} errors from the next one of {damped:?}");
        }
        resolved += damped.iter().filter(|(_, mode)| mode.is_resolved()).count();
    }
    assert!(resolved > 600, "{resolved}");
    // Gears that a soft shaft couples: rounding of the mesh stiffness hides the shaft.
    for (shaft, hidden) in [(1e-9, true), (1e4, false)] {
        let mut parts = Parts::new();
        for name in ["motor", "wheel", "pinion", "load"] {
            parts.body(name, Body::new(1e-4));
        }
        for (name, first, second, teeth) in
            [("one", "motor", "wheel", [19, 41]), ("two", "pinion", "load", [23, 67])]
        {
            let radii = teeth.map(|teeth| 1.1e-3 * f64::from(teeth));
            parts.mesh(name, first, second, MeshPart::external(teeth, radii, Wave::constant(1e12).unwrap()));
        }
        parts.shaft("soft", "wheel", "pinion", ShaftPart::new(shaft));
        let modes = Modes::in_contact(&parts.build("motor", 100.0).unwrap(), 0.0).unwrap();
        let of_all = modes.all().iter().filter(|mode| mode.is_resolved()).count();
        let of_damped = modes.damped().iter().filter(|mode| mode.is_resolved()).count();
        let expected = if hidden { (3, 2) } else { (4, 3) };
        assert_eq!((of_all, of_damped), expected, "{:?} {:?}", modes.all(), modes.damped());
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

/// Masses with springs to the ground, 0 for none, and between two of them, stated as an algebra for all
/// number types.
#[derive(Clone, PartialEq)]
struct Sprung {
    masses: Vec<f64>,
    grounds: Vec<f64>,
    springs: Vec<(usize, usize, f64)>,
}

impl Shape for Sprung {
    fn size(&self) -> Size {
        Size { dof: self.masses.len(), constants: 1, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1")]
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, _: Drives<'_, S>, q: &[S], _: &[S], a: &mut [S]) {
        for (a, (q, ground)) in a.iter_mut().zip(q.iter().zip(&self.grounds)) {
            *a = *q * -*ground;
        }
        for (i, j, k) in &self.springs {
            let force = (q[*j] - q[*i]) * *k;
            (a[*i], a[*j]) = (a[*i] + force, a[*j] - force);
        }
        a.iter_mut().zip(&self.masses).for_each(|(a, mass)| *a = *a / S::from(*mass));
    }
}

impl Sprung {
    fn machine(&self) -> Machine<Sprung> {
        Machine::of_constants(self.clone(), &[("speed", 1.0)]).unwrap()
    }
    /// The modes of the same masses as a train.
    fn of_parts(&self) -> Modes {
        let mut parts = Parts::new();
        for (i, (mass, ground)) in self.masses.iter().zip(&self.grounds).enumerate() {
            let body = Body::new(*mass);
            parts.body(&format!("b{i}"), if *ground > 0.0 { body.restrained(*ground, 0.0) } else { body });
        }
        for (i, (from, to, k)) in self.springs.iter().enumerate() {
            parts.shaft(&format!("s{i}"), &format!("b{from}"), &format!("b{to}"), ShaftPart::new(*k));
        }
        let parts = parts.accept(Warning::UnusualValue);
        Modes::in_contact(&parts.build("b0", 100.0).unwrap(), 0.0).unwrap()
    }
}

/// 1 - 1 - 1 - 1 on springs K, k, K. ω² = 0, 2 K and the roots of ω⁴ - 2 (K + k) ω² + 2 K k = 0.
#[test]
fn a_soft_spring_between_stiff_ones_is_no_rigid_motion() {
    for stiff in [1e8, 1e10, 1e12, 1e14] {
        for soft in [100.0, 1.0, 0.01, 1e-4] {
            let (b, c) = (stiff + soft, 2.0 * stiff * soft);
            let high = b + (b * b - c).sqrt();
            let exact = [0.0, c / high, 2.0 * stiff, high];
            let springs = vec![(0, 1, stiff), (1, 2, soft), (2, 3, stiff)];
            let sprung = Sprung { masses: vec![1.0; 4], grounds: vec![0.0; 4], springs };
            let machine = sprung.machine();
            let of_shape = Modes::about(&machine, &State::at_rest(4), None).unwrap();
            let of_parts = sprung.of_parts();
            let mean = Modes::mean_in_contact(&machine).unwrap();
            // Differences of sums in double precision.
            let formula = from_fn(4, move |_, q, _, a| {
                a.fill(0.0);
                for &(i, j, k) in &sprung.springs {
                    let force = k * (q[j] - q[i]);
                    (a[i], a[j]) = (a[i] + force, a[j] - force);
                }
            });
            let differenced = Modes::about(&formula.unwrap(), &State::at_rest(4), None).unwrap();
            let written = modes(&[1.0; 4], &[stiff, soft, stiff], &[0.0; 4], 0.0);
            let ways = ["shape", "parts", "mean", "Jacobian", "formula"];
            for (way, modes) in ways.into_iter().zip([of_shape, of_parts, mean, written, differenced]) {
                let text = format!("{way} {stiff} {soft}: {:?}", modes.all());
                assert_eq!(modes.rigid_count(), 1, "{text}");
                assert!(modes.all()[0].rounding() == 0.0 && modes.all()[0].square() == 0.0, "{text}");
                for (mode, exact) in modes.all().iter().zip(exact).skip(1) {
                    let off = (mode.square() - exact).abs();
                    assert!(off <= mode.rounding() * mode.square().abs(), "{text}");
                }
                assert!(modes.all()[2..].iter().all(|mode| mode.rounding() < 1e-9), "{text}");
                let (resolved, ratio) = (modes.all()[1].is_resolved(), stiff / soft);
                assert!(!resolved || ratio < 1e14, "{text}");
                assert!(resolved || ratio > 0.9e12, "{text}");
            }
        }
    }
}

/// A spring g to the ground beside one of K between two masses of 1: the lower root of ω⁴ - (2 K + g) ω² + K g.
/// Either it is found, or the rigid motion in its place says that such a frequency may be hidden. What may be
/// hidden is little beside the other mode.
#[test]
fn a_rigid_motion_says_what_may_hide_behind_it() {
    for stiff in [1e6, 1e10, 1e12, 1e14, 1e16] {
        for soft in [0.0, 1e-6, 1e-3, 1.0, 1e3] {
            let formula = from_fn(2, move |_, q, _, a| {
                let force = stiff * (q[1] - q[0]);
                (a[0], a[1]) = (force - soft * q[0], -force);
            });
            let differenced = Modes::about(&formula.unwrap(), &State::at_rest(2), None).unwrap();
            let written = modes(&[1.0; 2], &[stiff], &[soft, 0.0], 0.0);
            for modes in [differenced, written] {
                let lowest = &modes.all()[0];
                let (sum, product) = (2.0 * stiff + soft, stiff * soft);
                let square = 2.0 * product / (sum + (sum * sum - 4.0 * product).sqrt());
                let text = format!("{stiff} {soft}: {:?}", modes.all());
                if modes.rigid_count() == 1 {
                    assert!(lowest.hidden_frequency().powi(2) >= square, "{text}");
                    assert!(stiff != 1e14 || (0.5..1.0).contains(&lowest.hidden_frequency()), "{text}");
                    assert!(lowest.hidden_frequency() < 1e-6 * modes.all()[1].frequency(), "{text}");
                } else {
                    assert!(soft > 0.0 && lowest.hidden_frequency() == 0.0, "{text}");
                    assert!(
                        (lowest.square() - square).abs() <= lowest.rounding() * lowest.square(),
                        "{text}"
                    );
                }
            }
        }
    }
}

/// Number of ω² below `square` of a tree of springs: of negative dynamic stiffnesses, from the leaves to the
/// roots. A part of stiffness D behind a spring k is one of k D/(k + D): its error is that of the given
/// numbers.
fn below(square: f64, inertias: &[f64], grounds: &[f64], parents: &[Option<(usize, f64)>]) -> usize {
    let mut count = 0;
    let mut stiffness: Vec<f64> = inertias.iter().zip(grounds).map(|(m, g)| g - square * m).collect();
    for (i, parent) in parents.iter().enumerate().rev() {
        let own = stiffness[i];
        match *parent {
            None => count += usize::from(own < 0.0),
            Some((parent, k)) => {
                count += usize::from(k + own < 0.0);
                stiffness[parent] += k * own / (k + own);
            }
        }
    }
    count
}

#[test]
fn random_trees_of_springs_over_twelve_orders() {
    let mut seed = 7u64;
    let mut draw = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    for case in 0..60 {
        let n = 3 + (draw() * 8.0) as usize;
        let inertias: Vec<f64> = (0..n).map(|_| 10f64.powf(2.0 * draw() - 1.0)).collect();
        let (mut parents, mut springs, mut part) = (vec![None], Vec::new(), vec![0]);
        for i in 1..n {
            let parent = if case % 2 == 0 { i - 1 } else { (draw() * i as f64) as usize };
            let k = 10f64.powf(12.0 * draw() - 2.0);
            // A train is connected.
            let joined = case % 4 < 2 || draw() < 0.8;
            parents.push(joined.then_some((parent, k)));
            part.push(if joined { part[parent] } else { i });
            if joined {
                springs.push((parent, i, k));
            }
        }
        let share = if case % 3 == 0 { 0.0 } else { 0.2 };
        let to_ground = |_| if draw() < share { 10f64.powf(12.0 * draw() - 2.0) } else { 0.0 };
        let grounds: Vec<f64> = (0..n).map(to_ground).collect();
        let free =
            (0..n).filter(|&i| part[i] == i && (0..n).all(|j| part[j] != i || grounds[j] == 0.0)).count();
        let text = format!("{case}: {inertias:?} {grounds:?} {parents:?}");
        let sprung = Sprung { masses: inertias.clone(), grounds: grounds.clone(), springs };
        let modes = match case % 4 < 2 {
            true => sprung.of_parts(),
            false => Modes::about(&sprung.machine(), &State::at_rest(n), None).unwrap(),
        };
        assert_eq!(modes.rigid_count(), free, "{text}");
        for (index, mode) in modes.all().iter().enumerate().skip(free) {
            let (mut low, mut high) = (1e-12f64, 1e16f64);
            while high / low > 1.0 + 1e-15 && low < (low * high).sqrt() && (low * high).sqrt() < high {
                let middle = (low * high).sqrt();
                if below(middle, &inertias, &grounds, &parents) > index {
                    high = middle
                } else {
                    low = middle
                }
            }
            let off = (mode.square() / low - 1.0).abs();
            assert!(off <= mode.rounding() + 1e-13, "{off} {mode:?}; {text}");
        }
    }
}

/// q0'' = -q0 - speed q0' stops to oscillate at the speed 2. The other mode of q1'' = -6.25 q1 meets the order 1 at 2.5.
#[test]
fn a_campbell_diagram_across_the_speed_at_which_a_mode_stops_to_oscillate() {
    #[derive(PartialEq)]
    struct Damped;
    impl Shape for Damped {
        fn size(&self) -> Size {
            Size { dof: 2, constants: 1, ..Size::default() }
        }
        fn names(&self) -> Vec<Channel> {
            vec![Channel::new("speed", "rad/s")]
        }
        fn accel<S: Scalar, L: PieceChoice<S>>(
            &self,
            _: &L,
            u: Drives<'_, S>,
            q: &[S],
            v: &[S],
            a: &mut [S],
        ) {
            a[0] = -q[0] - u.speed() * v[0];
            a[1] = q[1] * -6.25;
        }
    }
    let model = Machine::of_constants(Damped, &[("speed", 1.0)]).unwrap();
    for speeds in [&[1.0, 1.9, 2.6, 3.0][..], &[1.0, 3.0], &[1.0, 2.2, 2.4, 2.7, 3.0]] {
        let diagram = Campbell::of(&model, speeds, &[1.0]).unwrap();
        let at: Vec<f64> = diagram.resonances().iter().map(|resonance| resonance.speed).collect();
        assert!(at.iter().any(|speed| (speed - 2.5).abs() < 1e-9), "{speeds:?}: {at:?}");
    }
}

/// Coordinates x = T y of a chain, with lengths and angles in any units: y'' = T⁻¹ A T y has the modes of the
/// chain, and the stated error holds the difference.
#[test]
fn modes_of_relative_coordinates_do_not_depend_on_units() {
    let mut random = Random(417);
    for case in 0..60 {
        let n = 3 + case % 6;
        let mut draw = |low: f64, high: f64| (0..n).map(|_| low * (high / low).powf(random.next())).collect();
        let (masses, springs, mut grounds): (Vec<f64>, Vec<f64>, Vec<f64>) =
            (draw(1e-3, 1e2), draw(1e2, 1e7), draw(1e2, 1e5));
        if case % 3 == 0 {
            grounds.fill(0.0);
        }
        let exact = modes(&masses, &springs[..n - 1], &grounds, 0.0);
        let chain = Chain { masses: &masses, springs: &springs[..n - 1], grounds: &grounds, drag: 0.0 };
        let mut absolute = Jacobian::new(n);
        chain.jacobian(None, &[], &[0.0; 8][..n], &[0.0; 8][..n], &mut absolute);
        // y0 = x0 and y_i = x_i - x_(i-1), each in its unit, a power of 2.
        for exponent in [0, -20, 20, -40] {
            let unit: Vec<f64> = (0..n).map(|i| if i % 2 == 1 { 2f64.powi(exponent) } else { 1.0 }).collect();
            // Row i of A over the columns from j on: springs between these bodies cancel.
            let sum = |i: usize, j: usize| match j {
                0 => -grounds[i] / masses[i],
                _ => (j..n).map(|k| absolute.q[(i, k)]).sum(),
            };
            let relative = |i: usize, j: usize| {
                (sum(i, j) - if i > 0 { sum(i - 1, j) } else { 0.0 }) * (unit[j] / unit[i])
            };
            let own = from_fn(n, |_, q, _, a| {
                for (i, a) in a.iter_mut().enumerate() {
                    *a = (0..n).map(|j| relative(i, j) * q[j]).sum();
                }
            })
            .unwrap();
            let found = Modes::about(&own, &State::at_rest(n), None).unwrap();
            assert_eq!(found.rigid_count(), exact.rigid_count(), "{case} 2^{exponent}");
            assert_eq!(found.all().len(), n, "{case} 2^{exponent}");
            for (found, exact) in found.all().iter().zip(exact.all()) {
                let off = (found.square() - exact.square()).abs();
                assert!(
                    off <= (found.rounding() + exact.rounding()) * exact.square(),
                    "{case} 2^{exponent}: {} for {}, stated {:e}",
                    found.frequency(),
                    exact.frequency(),
                    found.rounding()
                );
            }
        }
    }
}

/// q'' = -A q with the Jacobian -A.
struct Stiffness<'a>(usize, &'a [f64]);

impl Model for Stiffness<'_> {
    fn dof(&self) -> usize {
        self.0
    }
    fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
        for (row, a) in self.1.chunks(self.0).zip(a) {
            *a = -row.iter().zip(q).map(|(k, q)| k * q).sum::<f64>();
        }
    }
    fn offers(&self) -> Offers<'_> {
        Offers { jacobian: true, ..Offers::default() }
    }
    fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], _: &[f64], _: &[f64], out: &mut Jacobian) {
        out.q = -nalgebra::DMatrix::from_row_slice(self.0, self.0, self.1);
        out.v.fill(0.0);
    }
}

/// Coordinates that drive others and are not driven, rigid motions in mixed units and equal modes: each mode is there, and
/// its error is stated.
#[test]
fn stiffnesses_that_couple_one_way() {
    let cases: [(usize, Vec<f64>, Vec<f64>); 5] = [
        (2, vec![1.0, 0.0, 2f64.powi(24), 2.0], vec![1.0, 2.0]),
        (2, vec![1.0, 0.0, 2f64.powi(30), 2.0], vec![1.0, 2.0]),
        (3, vec![1.0, 0.0, 0.0, 2f64.powi(24), 2.0, 0.0, 0.0, 2f64.powi(24), 3.0], vec![1.0, 2.0, 3.0]),
        (
            3,
            in_units(
                &[0.0, 0.0, 0.0, -489_472.0, 256.0, 163_328.0, -245_760.0, 0.0, 81_920.0],
                &[2f64.powi(-30), 1024.0, 2f64.powi(-12)],
            ),
            vec![0.0, 256.0, 81_920.0],
        ),
        (
            4,
            in_units(
                &[30.0, 0.0, -10.0, 0.0, 0.0, 0.0, 0.0, 0.0, 60.0, 0.0, -20.0, 0.0, 0.0, -10.0, 0.0, 10.0],
                &[16.0, 0.5, 0.25, 4.0],
            ),
            vec![0.0, 0.0, 10.0, 10.0],
        ),
    ];
    for (n, rows, exact) in cases {
        let found = Modes::about(&Stiffness(n, &rows), &State::at_rest(n), None).unwrap();
        let squares: Vec<f64> = found.all().iter().map(|mode| mode.square()).collect();
        assert_eq!(squares.len(), n, "{squares:?} for {exact:?}");
        for (mode, exact) in found.all().iter().zip(&exact) {
            let (off, stated) = ((mode.square() - exact).abs(), mode.rounding() * mode.square().abs());
            assert!(off <= stated, "{squares:?} for {exact:?}: {off:e}, stated {stated:e}");
            assert!(mode.rounding() < 1e-3, "{squares:?} for {exact:?}: stated {:e}", mode.rounding());
        }
        let elastic: Vec<f64> = exact.iter().copied().filter(|square| *square > 0.0).collect();
        let damped = found.damped();
        assert_eq!(damped.len(), elastic.len());
        for (mode, exact) in damped.iter().zip(elastic) {
            let off = (std::f64::consts::TAU * mode.hertz / exact.sqrt() - 1.0).abs();
            assert!(off <= mode.rounding + 4e-16 && mode.rounding < 1e-3, "{off:e} {:e}", mode.rounding);
        }
    }
}

/// Rows times u_i/u_j.
fn in_units(rows: &[f64], u: &[f64]) -> Vec<f64> {
    let n = u.len();
    rows.iter().enumerate().map(|(at, x)| x * (u[at / n] / u[at % n])).collect()
}
