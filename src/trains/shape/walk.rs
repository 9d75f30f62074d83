//! The accelerations of a plain train, which consists of shafts, constant torques and meshes of two coordinates each.

use crate::contact::deflection::Deflection;
use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::mesh::ContactDamping;
use crate::contact::piece_choice::PieceChoice;
use crate::model::shape::Drives;
use crate::scalar::{Scalar, keep_rolled};
use crate::trains::shape::elements::Spring;
use crate::trains::shape::train_shape::TrainShape;

/// The meshes of a plain train in their order, each with one shaft of its first coordinate.
///
/// Plain numbers carry the second coordinate of a mesh over to the next one, which often starts there.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Walk<N> {
    steps: Vec<Step<N>>,
    /// Shafts that belong to no step.
    shafts: Vec<Spring>,
}

/// A mesh, and one shaft of its first coordinate: the numbers that an evaluation reads, next to each other in memory.
#[derive(Clone, Debug, PartialEq)]
struct Step<N> {
    at: [u32; 2],
    /// Places of stiffness and error among the waves.
    stiffness: u32,
    error: u32,
    /// The other end of the shaft; [`NONE`] without a shaft.
    end: u32,
    levers: [f64; 2],
    pulls: [f64; 2],
    /// Stiffness and damping of the shaft, and its pulls on the first coordinate and on the other end.
    shaft: [f64; 2],
    shaft_pulls: [f64; 2],
    law: N,
}

/// The end of a shaft that does not exist.
const NONE: u32 = u32::MAX;

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

/// Returns the index. For lanes it keeps the compiler from unrolling the loop: see [`keep_rolled`].
#[inline(always)]
fn kept<S>(index: usize) -> usize {
    if const { size_of::<S>() == size_of::<f64>() } { index } else { keep_rolled(index) }
}

impl<N: Nonlinearity + Clone> Walk<N> {
    /// The walk of a plain train; `None` if it has anything but shafts between two coordinates, constant torques and
    /// meshes of at most two coordinates whose damping always acts.
    pub(crate) fn of(shape: &TrainShape<N>) -> Option<Self> {
        let plain = shape.springs.iter().all(|spring| spring.levers == [1.0, -1.0])
            && shape.rests.iter().all(|rest| rest.more_levers.is_empty() && rest.more_pulls.is_empty())
            && shape.rests.iter().all(|rest| rest.mesh.contact_damping() == ContactDamping::Always)
            && shape.varying.is_empty()
            && shape.uneven.is_empty()
            && shape.row_springs.is_empty()
            && shape.rotating.is_empty()
            && shape.frictions.is_empty()
            && shape.journals.is_empty()
            && shape.motors.is_empty()
            && shape.torque_waves.is_empty();
        if !plain {
            return None;
        }
        let mut shafts = shape.springs.clone();
        let steps = shape.teeth.iter().map(|tooth| {
            let found = shafts.iter().position(|shaft| shaft.ends.contains(&tooth.at[0]));
            let (end, shaft, shaft_pulls) = match found.map(|place| shafts.remove(place)) {
                Some(Spring { ends: [_, end], pulls, stiffness, damping, .. }) if end != tooth.at[0] => {
                    (end, [stiffness, damping], pulls)
                }
                // Seen from its other end, the shaft has the opposite deflection.
                Some(Spring { ends, pulls, stiffness, damping, .. }) => {
                    (ends[0], [stiffness, damping], [-pulls[1], -pulls[0]])
                }
                None => (NONE, [0.0; 2], [0.0; 2]),
            };
            Step {
                at: tooth.at,
                stiffness: tooth.stiffness,
                error: tooth.error,
                end,
                levers: tooth.levers,
                pulls: tooth.pulls,
                shaft,
                shaft_pulls,
                law: tooth.law.clone(),
            }
        });
        Some(Walk { steps: steps.collect(), shafts })
    }
}

impl<N: Nonlinearity> Walk<N> {
    /// Writes the accelerations of the train `shape`.
    #[inline(always)]
    pub(crate) fn accelerate<S: Scalar, L: PieceChoice<S>>(
        &self,
        shape: &TrainShape<N>,
        law: &L,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
        a: &mut [S],
    ) {
        let carried = const { size_of::<S>() == size_of::<f64>() };
        let (n, steps) = (shape.per_inertia.len(), &self.steps[..]);
        let (q, v, a) = (&q[..n], &v[..n], &mut a[..n]);
        let (single, rest) = u.all_waves().split_at(shape.single.len());
        let (jets, edges) = rest.split_at(2 * shape.jets.len());
        let (jets, edges) = (jets.as_chunks::<2>().0, edges.as_chunks::<4>().0);
        let (net, rest) = u.all_constants().split_at(n);
        let per_inertia = &shape.per_inertia[..n];
        let (damping, rest) = rest.split_at(steps.len());
        let (half, speed) = (&rest[..steps.len()], u.speed());
        let places = &shape.places.of_laws()[..steps.len()];
        for j in 0..n {
            let j = kept::<S>(j);
            a[j] = net[j] * per_inertia[j];
        }
        for shaft in &self.shafts {
            let [j, k] = shaft.ends.map(|end| kept::<S>(end as usize));
            let force = (q[j] - q[k]) * shaft.stiffness + (v[j] - v[k]) * shaft.damping;
            a[j] = a[j] - force * shaft.pulls[0];
            a[k] = a[k] - force * shaft.pulls[1];
        }
        let Some(first) = steps.first() else { return };
        let mut gear = Turning::of(first.at[0] as usize, q, v, a);
        for i in 0..steps.len() {
            let step = &steps[kept::<S>(i)];
            let [j, k] = step.at.map(|at| at as usize);
            if !carried || gear.at != j {
                if carried {
                    a[gear.at] = gear.a;
                }
                gear = Turning::of(j, q, v, a);
            }
            if step.end != NONE {
                let end = step.end as usize;
                let force = (gear.q - q[end]) * step.shaft[0] + (gear.v - v[end]) * step.shaft[1];
                gear.a = gear.a - force * step.shaft_pulls[0];
                a[end] = a[end] - force * step.shaft_pulls[1];
            }
            let [e, rate] = jets[step.error as usize];
            let x = gear.q * step.levers[0] + q[k] * step.levers[1] - e;
            let rate = gear.v * step.levers[0] + v[k] * step.levers[1] - speed * rate;
            let [lower, upper] = if N::HALF_WIDTH { [-half[i], half[i]] } else { [edges[i][0], edges[i][1]] };
            let deflection = Deflection { x, rate, lower, upper };
            let elastic = law.force(places[i], &step.law, deflection);
            let w = single[step.stiffness as usize] * elastic + damping[i] * rate;
            a[j] = gear.a - w * step.pulls[0];
            gear = Turning::of(k, q, v, a);
            gear.a = gear.a - w * step.pulls[1];
            if !carried {
                a[k] = gear.a;
            }
        }
        a[gear.at] = gear.a;
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
    use crate::model::shape::Drives;
    use crate::sweep::lanes::number::{Lanes, Number};
    use crate::trains::parts::body::Body;
    use crate::trains::parts::collection::{Coordinates, Parts};
    use crate::trains::parts::mesh_part::MeshPart;
    use crate::trains::shape::train_shape::TrainShape;
    use crate::trains::{Train, Warning};

    fn mesh(teeth: [u32; 2], error: f64) -> MeshPart {
        let wave = |mean, a| Wave::new(Fourier::new(mean, &[[a, 0.3 * a]]).unwrap());
        let radii = teeth.map(|teeth| 1.5e-3 * f64::from(teeth));
        let part = MeshPart::external(teeth, radii, wave(2e8, 3e7)).error(wave(0.0, error));
        part.damping(800.0).half_backlash(2e-5)
    }

    /// The walk and the general algebra agree in contact and in the gap, and the walk gives the same bits in lanes.
    fn agree(parts: &Parts, reference: &str) {
        let train = parts.build(reference, 90.0).unwrap();
        let walk = train.shape().walk.as_ref().unwrap();
        let general: Train = train.clone().reshaped(TrainShape { walk: None, ..train.shape().clone() });
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
            walk.accelerate(train.shape(), &ByDeflection, drives, &lanes(&q), &lanes(&v), &mut a);
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

    /// A wheel between two shafts drives two pinions. One of them drives a further gear, and over a shaft one more;
    /// another shaft joins two bodies of which neither comes first in a mesh.
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
        parts.shaft("input", "motor", "wheel", 2e5, 3.0).shaft("output", "load", "wheel", 1e5, 2.0);
        parts.shaft("side", "far", "right", 4e4, 1.0).shaft("end", "last", "drum", 3e4, 1.0);
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
