//! Oscillators of the literature, with periodic drives.

use crate::api::*;
use std::f64::consts::TAU;

/// μ q'' + ζ q' + κ q + γ q³ = P cos Ωt with μ = 1, ζ = 0.05, κ = 1, γ = 0.1, P = 0.18.   Source: Krack &
/// Gross (2019), example 01.
pub struct Duffing {
    pub omega: f64,
}

impl Model for Duffing {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = 0.18 * (self.omega * u[0]).cos() - 0.05 * v[0] - q[0] - 0.1 * q[0].powi(3);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { jacobian: true, ..Offers::default() }
    }
    fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], q: &[f64], _: &[f64], out: &mut Jacobian) {
        (out.q[(0, 0)], out.v[(0, 0)]) = (-1.0 - 0.3 * q[0] * q[0], -0.05);
    }
}

impl Periodic for Duffing {
    fn period(&self) -> f64 {
        TAU / self.omega
    }
}

/// x'' + 2 ζ x' + (1 + a cos Ωt) g(x) = F + P cos Ωt, g the dead zone of half width 1.   After Kahraman &
/// Singh (1990).
pub struct DeadZone {
    pub omega: f64,
    pub zeta: f64,
    pub mean: f64,
    pub amplitude: f64,
    pub stiffness: f64,
}

impl DeadZone {
    /// Stiffness 1 + a cos Ωt and force F + P cos Ωt.
    fn forces(&self, t: f64) -> (f64, f64) {
        let wave = (self.omega * t).cos();
        (1.0 + self.stiffness * wave, self.mean + self.amplitude * wave)
    }
}

/// Force of the dead zone of half width 1 on a given piece, and its derivative.
fn tooth(piece: Piece, x: f64) -> (f64, f64) {
    match piece {
        Piece::Lower => (x + 1.0, 1.0),
        Piece::Gap => (0.0, 0.0),
        Piece::Upper => (x - 1.0, 1.0),
    }
}

fn piece_of(x: f64) -> Piece {
    if x > 1.0 {
        Piece::Upper
    } else if x < -1.0 {
        Piece::Lower
    } else {
        Piece::Gap
    }
}

impl Model for DeadZone {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.accel_on_pieces(&[piece_of(q[0])], u, q, v, a);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, jacobian: true, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        out[0] = Contact {
            deflection: q[0],
            rate: v[0],
            lower: -1.0,
            upper: 1.0,
            force: tooth(piece_of(q[0]), q[0]).0,
            ..Contact::default()
        };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let (stiffness, force) = self.forces(u[0]);
        a[0] = force - 2.0 * self.zeta * v[0] - stiffness * tooth(pieces[0], q[0]).0;
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], _: &[f64], out: &mut Jacobian) {
        let piece = pieces.map_or(piece_of(q[0]), |pieces| pieces[0]);
        (out.q[(0, 0)], out.v[(0, 0)]) = (-self.forces(u[0]).0 * tooth(piece, q[0]).1, -2.0 * self.zeta);
    }
}

impl Periodic for DeadZone {
    fn period(&self) -> f64 {
        TAU / self.omega
    }
}

/// Two masses in a chain with cubic springs, excited on the first mass. The model has no Jacobian of its own.
/// Source: Krack & Gross (2019), example 02.
pub struct CubicChain {
    pub omega: f64,
}

impl Model for CubicChain {
    fn dof(&self) -> usize {
        2
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let (x, rate) = (q[0] - q[1], v[0] - v[1]);
        let link = 0.0453 * x + 0.013 * rate + 0.0042 * x.powi(3);
        a[0] = 0.11 * (self.omega * u[0]).cos() - q[0] - q[0].powi(3) - 0.002 * v[0] - link;
        a[1] = link / 0.05;
    }
}

impl Periodic for CubicChain {
    fn period(&self) -> f64 {
        TAU / self.omega
    }
}

/// x'' + 2 ζ x' + (1 + κ cos Ωt) x = 0, the damped Mathieu equation.
pub struct Mathieu {
    pub omega: f64,
    pub zeta: f64,
    pub depth: f64,
}

impl Model for Mathieu {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = -2.0 * self.zeta * v[0] - (1.0 + self.depth * (self.omega * u[0]).cos()) * q[0];
    }
}

impl Periodic for Mathieu {
    fn period(&self) -> f64 {
        TAU / self.omega
    }
}

/// p'' = M⁻¹ (F - w) with w_i = 0.06 p_i' + (1 + a_i cos(Ωt + ψ_i)) g(p_i): an idler gear with two meshes, p
/// their deflections, g the dead zone of half width 1.
pub struct Idler {
    pub omega: f64,
    /// Phase ψ_2 of the second mesh `[rad]`; ψ_1 = 0.
    pub phase: f64,
}

impl Idler {
    fn stiffness(&self, t: f64) -> [f64; 2] {
        [1.0 + 0.2 * (self.omega * t).cos(), 1.0 + 0.15 * (self.omega * t + self.phase).cos()]
    }
    /// M⁻¹ w for the masses 1, 1.5 and 0.8.
    fn inverse(w: [f64; 2]) -> [f64; 2] {
        let (m1, m2, m3) = (1.0, 1.5, 0.8);
        [(1.0 / m1 + 1.0 / m2) * w[0] - w[1] / m2, -w[0] / m2 + (1.0 / m2 + 1.0 / m3) * w[1]]
    }
}

impl Model for Idler {
    fn dof(&self) -> usize {
        2
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.accel_on_pieces(&[piece_of(q[0]), piece_of(q[1])], u, q, v, a);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        2
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        for (i, out) in out.iter_mut().enumerate() {
            *out = Contact { deflection: q[i], rate: v[i], lower: -1.0, upper: 1.0, ..Contact::default() };
        }
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let k = self.stiffness(u[0]);
        let w = [0, 1].map(|i| [0.1, 0.12][i] - 0.06 * v[i] - k[i] * tooth(pieces[i], q[i]).0);
        a.copy_from_slice(&Idler::inverse(w));
    }
}

impl Periodic for Idler {
    fn period(&self) -> f64 {
        TAU / self.omega
    }
}
