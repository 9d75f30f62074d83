//! The accelerations of a train.

use crate::contact::{Nonlinearity, PieceChoice};
use crate::model::Drives;
use crate::scalar::{Scalar, keep_rolled};
use crate::trains::shape::contacts::At;
use crate::trains::shape::elements::Shaft;
use crate::trains::shape::train_shape::TrainShape;
use std::ops::Range;

/// A coordinate, its velocity and the sum of its accelerations so far.
#[derive(Clone, Copy)]
struct Turning<S> {
    at: usize,
    q: S,
    v: S,
    a: S,
}

impl<S: Scalar> Turning<S> {
    #[inline(always)]
    fn of(at: usize, q: &[S], v: &[S], a: &[S]) -> Self {
        Turning { at, q: q[at], v: v[at], a: a[at] }
    }
}

/// Whether the second coordinate of a mesh is carried over to the next mesh.
const fn carries<const PLAIN: bool, S>() -> bool {
    PLAIN && size_of::<S>() == size_of::<f64>()
}
/// Returns the index. In lanes it keeps the compiler from unrolling the loop: see [`keep_rolled`].
#[inline(always)]
fn rolled<const PLAIN: bool, S>(index: usize) -> usize {
    if carries::<PLAIN, S>() { index } else { keep_rolled(index) }
}

impl<N: Nonlinearity> TrainShape<N> {
    /// The equations of [`Train`](crate::trains::Train). `PLAIN`: see [`TrainShape::plain`].
    #[inline(always)]
    pub(crate) fn accelerate<const PLAIN: bool, S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
        a: &mut [S],
    ) {
        let (n, elements) = (self.elements.per_inertia.len(), &self.elements);
        let (at, q, v, a) = (self.drives::<PLAIN, _>(u), &q[..n], &v[..n], &mut a[..n]);
        let (net, per_inertia) = (&at.net[..n], &elements.per_inertia[..n]);
        for j in 0..n {
            let j = rolled::<PLAIN, S>(j);
            a[j] = net[j] * per_inertia[j];
        }
        for spring in &elements.springs[..self.loose] {
            let ([j, k], [r, s]) = (spring.ends.map(|end| rolled::<PLAIN, S>(end as usize)), spring.levers);
            let [x, rate] =
                if PLAIN { [q[j] - q[k], v[j] - v[k]] } else { [q[j] * r + q[k] * s, v[j] * r + v[k] * s] };
            let force = x * spring.stiffness + rate * spring.damping;
            a[j] = a[j] - force * spring.pulls[0];
            a[k] = a[k] - force * spring.pulls[1];
        }
        self.add_meshes::<PLAIN, _, _>(law, &at, q, v, a);
        if !PLAIN {
            self.others(law, &at, u.acceleration(), q, v, a);
        }
    }

    /// Adds the accelerations by the mesh forces, and by the shafts that meshes of a plain train have.
    ///
    /// In `f64` a plain train carries the second coordinate of a mesh over to the next one.
    #[inline(always)]
    fn add_meshes<const PLAIN: bool, S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        at: &At<S>,
        q: &[S],
        v: &[S],
        a: &mut [S],
    ) {
        let carried = carries::<PLAIN, S>();
        let Some(first) = self.teeth.first() else { return };
        // Slices of one length: their bounds are checked once.
        let teeth = &self.teeth[..];
        let rests = &self.rests[..if PLAIN { 0 } else { teeth.len() }];
        let (damping, half) = (&at.damping[..teeth.len()], &at.half[..teeth.len()]);
        let bounded = At { damping, half, ..*at };
        let mut gear = Turning::of(first.at[0] as usize, q, v, a);
        for i in 0..teeth.len() {
            let tooth = &teeth[rolled::<PLAIN, S>(i)];
            let [j, k] = tooth.at.map(|at| at as usize);
            if !carried || gear.at != j {
                if carried {
                    a[gear.at] = gear.a;
                }
                gear = Turning::of(j, q, v, a);
            }
            if PLAIN && tooth.shaft.end != Shaft::NONE.end {
                let (shaft, end) = (&tooth.shaft, tooth.shaft.end as usize);
                let force = (gear.q - q[end]) * shaft.stiffness + (gear.v - v[end]) * shaft.damping;
                gear.a = gear.a - force * shaft.pulls[0];
                a[end] = a[end] - force * shaft.pulls[1];
            }
            let mut deflection = tooth.deflection(&bounded, [gear.q, q[k]], [gear.v, v[k]]);
            if !PLAIN {
                deflection = self.with_further_levers(deflection, i, &bounded, q, v);
            }
            let w = self.force::<PLAIN, _, _>(law, i, tooth, &bounded, deflection);
            a[j] = gear.a - w * tooth.pulls[0];
            gear = Turning::of(k, q, v, a);
            gear.a = gear.a - w * tooth.pulls[1];
            if !carried {
                a[k] = gear.a;
            }
            if !PLAIN {
                self.pull(rests[i].more_pulls.clone(), w, a);
                if !rests[i].varying.is_empty() {
                    self.varying_pull(i, w, &bounded, a);
                }
            }
        }
        if carried {
            a[gear.at] = gear.a;
        }
    }

    /// [`accelerate`](TrainShape::accelerate) of any train, compiled once and not into each solver.
    #[inline(never)]
    pub(crate) fn accelerate_apart<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
        a: &mut [S],
    ) {
        self.accelerate::<false, _, _>(law, u, q, v, a);
    }

    /// The accelerations of noncircular gears by the force of tooth i, out of the loops of round gears.
    #[inline(never)]
    fn varying_pull<S: Scalar>(&self, i: usize, w: S, at: &At<S>, a: &mut [S]) {
        for lever in &self.elements.varying[self.rests[i].varying.clone()] {
            a[lever.at] = a[lever.at] - w * at.jets[lever.wave][0] * lever.pull;
        }
    }

    /// a -= w pulls.
    #[inline(always)]
    fn pull<S: Scalar>(&self, pulls: Range<usize>, w: S, a: &mut [S]) {
        for entry in &self.elements.entries[pulls] {
            a[entry.at] = a[entry.at] - w * entry.by;
        }
    }

    /// Everything but torques, two-ended springs and mesh forces. It is compiled once for each number type:
    /// inlined into all loops of the lanes it would take minutes to compile.
    #[inline(never)]
    fn others<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        at: &At<S>,
        acceleration: S,
        q: &[S],
        v: &[S],
        a: &mut [S],
    ) {
        for spring in &self.elements.row_springs {
            let [x, rate] = self.row(spring.levers.clone(), q, v);
            self.pull(spring.pulls.clone(), x * spring.stiffness + rate * spring.damping, a);
        }
        let [omega, omega_rate] = [at.speed, acceleration].map(|rate| rate * self.elements.frame_ratio);
        for term in &self.elements.rotating {
            let x =
                q[term.j] * term.damping + v[term.j] * term.gyroscopic + omega * q[term.j] * term.centripetal;
            a[term.i] = a[term.i] - omega * x - omega_rate * q[term.j] * term.euler;
        }
        for entry in &self.elements.outward {
            a[entry.at] = a[entry.at] + omega * omega * entry.by;
        }
        for (friction, mu) in self.elements.frictions.iter().zip(at.friction) {
            let (i, tooth) = (friction.tooth, &self.teeth[friction.tooth]);
            let deflection = self.deflection(i, tooth, at, q, v);
            let w = self.force::<false, _, _>(law, i, tooth, at, deflection);
            self.pull(friction.pulls.clone(), w * *mu * at.single[friction.sign], a);
        }
        for (i, journal) in self.elements.journals.iter().enumerate() {
            let i = self.teeth.len() + i;
            let contact = self.journal_contact(law, i, at, q, v);
            if journal.levers[0].is_empty() {
                let [_, rate] = self.row(journal.levers[1].clone(), q, v);
                self.pull(journal.pulls[1].clone(), contact.force + at.damping[i] * rate, a);
                continue;
            }
            let along = contact.force / contact.deflection;
            for (levers, pulls) in journal.levers.iter().zip(&journal.pulls) {
                let [x, rate] = self.row(levers.clone(), q, v);
                self.pull(pulls.clone(), along * x + at.damping[i] * rate, a);
            }
        }
        for (wave, constant, pulls) in &self.elements.torque_waves {
            self.pull(pulls.clone(), at.single[*wave] * at.torques[*constant], a);
        }
        for motor in &self.elements.motors {
            let kinematic = at.speed * motor.ratio;
            let kinematic = motor.rotation.map_or(kinematic, |wave| kinematic * at.jets[wave][0]);
            let share = motor.characteristic.at(kinematic + v[motor.at]);
            self.pull(motor.pulls.clone(), at.torques[motor.torque] * share, a);
        }
        for uneven in &self.elements.uneven {
            let [rotation, rate] = at.jets[uneven.wave];
            let turning = acceleration * rotation;
            a[uneven.at] = a[uneven.at] - at.speed * at.speed * rate * uneven.ratio - turning * uneven.ratio;
            if let Some(driver) = &uneven.driver {
                a[driver.at] = a[driver.at] + turning * rotation * driver.by;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::contact::piece_choice::ByDeflection;
    use crate::contact::tooth::Contact;
    use crate::excitation::fourier::Fourier;
    use crate::excitation::side::Side;
    use crate::excitation::wave::Wave;
    use crate::model::equations::Model;
    use crate::model::shapes::shape::Drives;
    use crate::sweep::lanes::number::{Lanes, Number};
    use crate::trains::parts::body::Body;
    use crate::trains::parts::collection::Parts;
    use crate::trains::parts::coordinates::Coordinates;
    use crate::trains::parts::mesh_part::MeshPart;
    use crate::trains::shape::train_shape::TrainShape;
    use crate::trains::{ShaftPart, Train, Warning};

    fn mesh(teeth: [u32; 2], error: f64) -> MeshPart {
        let wave = |mean, a| Wave::new(Fourier::new(mean, &[[a, 0.3 * a]]).unwrap());
        let radii = teeth.map(|teeth| 1.5e-3 * f64::from(teeth));
        let part = MeshPart::external(teeth, radii, wave(2e8, 3e7)).error(wave(0.0, error));
        part.damping(800.0).half_backlash(2e-5).phase(0.0)
    }

    /// A plain train and the general algebra agree in contact and in the gap, and the bits are the same in
    /// lanes.
    fn agree(parts: &Parts, reference: &str) {
        let train = parts.build(reference, 90.0).unwrap();
        assert!(train.shape().plain);
        let loose = train.shape().elements.springs.len();
        let general = TrainShape { plain: false, loose, ..train.shape().clone() };
        let general: Train = train.clone().reshaped(general);
        let n = train.dof();
        let mut u = vec![0.0; train.drives()];
        let mut seen = [0; 3];
        for k in 0..40 {
            let at = |i: usize, seed: f64| (seed * (i + n * k + 1) as f64).fract() - 0.5;
            let q: Vec<f64> = (0..n).map(|i| 2e-3 * at(i, 0.618_034)).collect();
            let v: Vec<f64> = (0..n).map(|i| at(i, 0.414_214)).collect();
            train.drive(1e-3 * f64::from(k as u32), Side::After, &mut u);
            let [walked, expected] = [&train, &general].map(|train| {
                let mut a = vec![f64::NAN; n];
                train.accel(&u, &q, &v, &mut a);
                a
            });
            let lanes = |x: &[f64]| x.iter().map(|&x| Lanes::<2>::from(x)).collect::<Vec<_>>();
            let (wide, mut a) = (lanes(&u), lanes(&walked));
            let drives = Drives::new(train.size().waves, &wide);
            train.shape().accelerate::<true, _, _>(&ByDeflection, drives, &lanes(&q), &lanes(&v), &mut a);
            assert!(walked.iter().zip(&a).all(|(x, a)| x.to_bits() == a.lane(1).to_bits()));
            let mut contacts = vec![Contact::default(); train.contacts()];
            train.contact(&u, &q, &v, &mut contacts);
            contacts.iter().for_each(|contact| seen[contact.piece() as usize] += 1);
            let size = expected.iter().fold(0.0_f64, |size, a| size.max(a.abs()));
            for (walked, expected) in walked.iter().zip(&expected) {
                assert!((walked - expected).abs() < 1e-13 * size, "{walked} {expected}");
            }
        }
        assert!(seen.iter().all(|seen| *seen > 0), "{seen:?}");
    }

    /// A wheel between two shafts drives two pinions. One of them drives a further gear, and over a shaft one
    /// more; another shaft joins two bodies of which neither comes first in a mesh.
    #[test]
    fn meshes_that_branch() {
        let mut parts = Parts::new();
        let inertias = [("motor", 2e-2), ("wheel", 8e-3), ("load", 5e-2), ("last", 3e-3), ("drum", 6e-2)];
        for (name, inertia) in inertias {
            parts.body(name, Body::new(inertia));
        }
        for (name, inertia) in [("left", 1e-3), ("right", 2e-3), ("far", 4e-3), ("next", 5e-3)] {
            parts.body(name, Body::new(inertia));
        }
        parts.shaft("input", "motor", "wheel", ShaftPart::new(2e5).damping(3.0)).shaft(
            "output",
            "load",
            "wheel",
            ShaftPart::new(1e5).damping(2.0),
        );
        parts.shaft("side", "far", "right", ShaftPart::new(4e4).damping(1.0)).shaft(
            "end",
            "last",
            "drum",
            ShaftPart::new(3e4).damping(1.0),
        );
        parts.mesh("first", "wheel", "left", mesh([60, 20], 2e-6));
        parts.mesh("second", "wheel", "right", mesh([60, 30], 3e-6));
        parts.mesh("third", "right", "next", mesh([30, 40], 2e-6));
        parts.mesh("fourth", "far", "last", mesh([25, 50], 1e-6));
        parts.torque("drive", "motor", 30.0).torque("brake", "load", -30.0);
        agree(parts.accept(Warning::Unbalanced), "motor");
    }

    /// In relative coordinates, the deflection of a pair depends on one coordinate alone.
    #[test]
    fn meshes_of_one_coordinate() {
        let mut parts = Parts::new();
        parts
            .body("pinion", Body::new(1e-3))
            .body("wheel", Body::new(2e-3))
            .coordinates(Coordinates::Relative);
        parts.mesh("mesh", "pinion", "wheel", mesh([20, 40], 1e-6));
        parts.torque("drive", "pinion", 10.0).torque("brake", "wheel", -20.0);
        agree(&parts, "pinion");
    }
}
