//! One oscillator with constants for every term of the classics.

use crate::api::*;
use gear_dynamics::contact::PieceChoice;
use gear_dynamics::excitation::{Angle, Fourier};
use gear_dynamics::model::{Drives, Size};

/// q'' + c q' + k q + γ q³ + s (1 + a cos φ) g(q) = F + P cos φ + A φ'² cos φ, with g a dead zone of half
/// width b.
#[derive(PartialEq)]
pub struct Oscillator {
    cos: Wave,
    law: Backlash,
}

const NAMES: [&str; 10] = [
    "speed",
    "damping",
    "linear",
    "cubic",
    "gap stiffness",
    "depth",
    "mean force",
    "force",
    "inertia force",
    "half backlash",
];

impl Shape for Oscillator {
    #[inline(always)]
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, contacts: 1, constants: NAMES.len() }
    }
    fn constants(&self) -> Vec<Channel> {
        NAMES.map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.cos.value(angle, side);
    }
    #[inline(always)]
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let [cos] = u.waves();
        let [_, _, _, stiffness, depth, _, _, _, b] = u.constants();
        let force = (stiffness + stiffness * depth * cos)
            * law.force(i, &self.law, Deflection { x: q[0], rate: v[0], lower: -b, upper: b });
        Contact { deflection: q[0], rate: v[0], lower: -b, upper: b, force, ..Contact::default() }
    }
    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [cos] = u.waves();
        let [damping, linear, cubic, _, _, mean, force, inertia, _] = u.constants();
        let (x, speed) = (q[0], u.speed());
        let springs = linear * x + cubic * x * x * x + self.contact(law, 0, u, q, v).force;
        a[0] = mean + (force + inertia * speed * speed) * cos - damping * v[0] - springs;
    }
}

/// The oscillator with these constants; speed 1 and half backlash 1 unless given, all others 0.
pub fn oscillator(given: &[(&str, f64)]) -> Machine<Oscillator> {
    let shape = Oscillator {
        cos: Wave::new(Fourier::new(0.0, &[[1.0, 0.0]]).unwrap()),
        law: Backlash::new(1.0).unwrap(),
    };
    let value = |name: &str| {
        let default = if ["speed", "half backlash"].contains(&name) { 1.0 } else { 0.0 };
        given.iter().find(|(other, _)| *other == name).map_or(default, |(_, value)| *value)
    };
    let constants: Vec<(&str, f64)> = NAMES.iter().map(|name| (*name, value(name))).collect();
    Machine::with_constants(shape, &constants).unwrap()
}
