//! Linear oscillators with two tones, and with one of an order of a shaft.

use crate::draw::Draw;
use gear_dynamics::contact::PieceChoice;
use gear_dynamics::excitation::{Angle, Fourier, Side};
use gear_dynamics::model::{Channel, Drives, Scalar, Shape, Size};
use gear_dynamics::num_complex::Complex64;
use gear_dynamics::tori::QuasiPeriodic;
use gear_dynamics::{Model, ParameterError, Wave};

/// x'' + c x' + k x = P_1 cos θ_1 + P_2 cos θ_2.
#[derive(Clone, Debug)]
pub struct Tones {
    /// ω_1 and ω_2.
    pub frequencies: [f64; 2],
    /// P_1 and P_2.
    pub amplitudes: [f64; 2],
    /// c, below 0 for a torus that repels.
    pub damping: f64,
    /// k.
    pub stiffness: f64,
}

impl Tones {
    /// Draws a model without a resonance.
    pub fn draw(draw: &mut Draw) -> Self {
        let first = draw.within(0.4, 2.0);
        // The golden mean is as far from all ratios as a number can be.
        let ratio = draw.below(3) as f64 + 0.5 * (5f64.sqrt() - 1.0);
        Tones {
            frequencies: [first, first * ratio],
            amplitudes: [draw.scale(1e-3, 10.0), draw.scale(1e-3, 10.0)],
            damping: draw.one_of(&[-1.0, 1.0]) * draw.within(0.05, 0.4),
            stiffness: draw.within(0.2, 5.0),
        }
    }
    /// P_i/(k - ω_i² + i c ω_i).
    pub fn response(&self, i: usize) -> Complex64 {
        let omega = self.frequencies[i];
        self.amplitudes[i] / Complex64::new(self.stiffness - omega * omega, self.damping * omega)
    }
}

impl Model for Tones {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = u[0] - self.damping * v[0] - self.stiffness * q[0];
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.drive_at(&self.frequencies.map(|omega| omega * t), side, u);
    }
}

impl QuasiPeriodic for Tones {
    fn frequencies(&self) -> Vec<f64> {
        self.frequencies.into()
    }
    fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
        u[0] = self.amplitudes.iter().zip(angles).map(|(p, angle)| p * angle.cos()).sum();
    }
}

/// x'' + c x' + x = cos nφ.
#[derive(Clone, Debug, PartialEq)]
pub struct Forced {
    wave: Wave,
}

impl Forced {
    /// The order n of the shaft.
    pub fn of_order(order: u32) -> Result<Self, ParameterError> {
        Ok(Forced { wave: Wave::new(Fourier::new(0.0, &[[1.0, 0.0]])?).per_turn(order)? })
    }
}

impl Shape for Forced {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, constants: 2, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "damping"].map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.wave.value(angle, side);
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [damping] = u.constants();
        a[0] = u.all_waves()[0] - damping * v[0] - q[0];
    }
}
