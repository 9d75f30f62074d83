//! A mass on a spring of varying stiffness under a varying force.

use gear_dynamics::contact::PieceChoice;
use gear_dynamics::excitation::{Angle, Side, earliest};
use gear_dynamics::model::{Channel, Drives, Machine, Scalar, Shape, Size};
use gear_dynamics::{ParameterError, Wave};

/// x'' = p(φ) + F - c x' - κ(φ) x with the waves p and κ, F and c as constants.
#[derive(Clone, Debug, PartialEq)]
pub struct Driven {
    /// The waves p and κ.
    pub waves: [Wave; 2],
}

impl Driven {
    /// The machine at a speed `[rad per unit of time]` with a force F and a damping c.
    ///
    /// # Errors
    /// A speed that the library refuses.
    pub fn at(self, speed: f64, force: f64, damping: f64) -> Result<Machine<Driven>, ParameterError> {
        Machine::of_constants(self, &[("speed", speed), ("force", force), ("damping", damping)])
    }
}

impl Shape for Driven {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 2, constants: 3, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "force", "damping"].map(|name| Channel::new(name, "1")).into()
    }
    fn repeats(&self) -> u32 {
        Wave::common_order(&self.waves)
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u.iter_mut().zip(&self.waves).for_each(|(u, wave)| *u = wave.value(angle, side));
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        earliest(self.waves.iter().map(|wave| wave.next_edge(angle)))
    }
    fn next_knot(&self, angle: f64) -> Option<f64> {
        earliest(self.waves.iter().map(|wave| wave.next_knot(angle)))
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let ([push, stiffness], [force, damping]) = (u.waves(), u.constants());
        a[0] = push + force - damping * v[0] - stiffness * q[0];
    }
}
