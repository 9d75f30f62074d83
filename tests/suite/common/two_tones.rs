//! Models with two base frequencies, and with one and a motion of two.

use crate::api::*;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// x'' + 0.1 x' + x + 0.2 x³ = 0.3 cos θ_1 + 0.2 cos θ_2, ω = (0.7, 0.7 √3).
pub struct TwoToneDuffing;

impl Model for TwoToneDuffing {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = u[0] - 0.1 * v[0] - q[0] - 0.2 * q[0].powi(3);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { jacobian: true, ..Offers::default() }
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.drive_at(&[0.7 * t, 0.7 * 3f64.sqrt() * t], side, u);
    }
    fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], q: &[f64], _: &[f64], out: &mut Jacobian) {
        (out.q[(0, 0)], out.v[(0, 0)]) = (-1.0 - 0.6 * q[0] * q[0], -0.1);
    }
}

impl QuasiPeriodic for TwoToneDuffing {
    fn frequencies(&self) -> Vec<f64> {
        vec![0.7, 0.7 * 3f64.sqrt()]
    }
    fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
        u[0] = 0.3 * angles[0].cos() + 0.2 * angles[1].cos();
    }
}

/// q_1'' = -3 q_1 + q_2 - 0.2 q_1' + cos θ_1 + 0.5, q_2'' = q_1 - 2 q_2 - 0.3 q_2' + sin θ_2 + sin θ_3 + ...,
/// for any number of angles, without a Jacobian.
pub struct LinearTones {
    pub frequencies: Vec<f64>,
}

impl LinearTones {
    /// Amplitudes c of q = Re(c e^{iωt}) for forces Re(f e^{iωt}).
    pub fn response(omega: f64, force: [Complex64; 2]) -> [Complex64; 2] {
        let a = Complex64::new(3.0 - omega * omega, 0.2 * omega);
        let b = Complex64::new(2.0 - omega * omega, 0.3 * omega);
        let determinant = a * b - 1.0;
        [(force[0] * b + force[1]) / determinant, (a * force[1] + force[0]) / determinant]
    }
}

impl Model for LinearTones {
    fn dof(&self) -> usize {
        2
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = -3.0 * q[0] + q[1] - 0.2 * v[0] + u[0];
        a[1] = q[0] - 2.0 * q[1] - 0.3 * v[1] + u[1];
    }
    fn drives(&self) -> usize {
        2
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        let angles: Vec<f64> = self.frequencies.iter().map(|omega| omega * t).collect();
        self.drive_at(&angles, side, u);
    }
}

impl QuasiPeriodic for LinearTones {
    fn frequencies(&self) -> Vec<f64> {
        self.frequencies.clone()
    }
    fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
        u[0] = angles[0].cos() + 0.5;
        u[1] = angles[1..].iter().map(|angle| angle.sin()).sum();
    }
}

/// q'' = f(q, q') + p cos θ_1 + r cos θ_2, given by closures: for tests of errors and of shifted angles.
pub struct Forced<F> {
    pub frequencies: Vec<f64>,
    pub phases: [f64; 2],
    pub law: F,
}

impl<F: Fn(f64, f64) -> f64> Model for Forced<F> {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = (self.law)(q[0], v[0]) + u[0];
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        let angles: Vec<f64> = self.frequencies.iter().map(|omega| omega * t).collect();
        self.drive_at(&angles, side, u);
    }
}

impl<F: Fn(f64, f64) -> f64> QuasiPeriodic for Forced<F> {
    fn frequencies(&self) -> Vec<f64> {
        self.frequencies.clone()
    }
    fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
        u[0] = 0.3 * (angles[0] + self.phases[0]).cos() + 0.2 * (angles[1] + self.phases[1]).cos();
    }
}

/// The noncircular face gear pair of Liu 2021, Eq. (9) as printed, with the mesh and the instantaneous centre
/// as separate angles θ_e and θ_c.
///
/// q'' + 0.02 q' + F f(q) = -B0 - B1 sin θ_c - B2 sin 2θ_c + B3 sin θ_e, F = (1 + 0.29 cos θ_e)
/// (1 + 0.3846 cos θ_c)²/(1 + 0.3846²/2), f the dead zone of half width 1. Lengths are those of the pair over
/// its half width 6.2e-4.
pub struct SlippingPair {
    /// Mesh frequency ω_e `[1]`.
    pub mesh: f64,
    /// Frequency of the centre ω_c `[1]`.
    pub centre: f64,
    /// Damping coefficient `[1]`.
    pub damping: f64,
    /// B3 over the half width.
    pub error: f64,
}

impl SlippingPair {
    /// B0 of the pair over its half width.
    pub const LOAD: f64 = 1.4e-5 / 6.2e-4;

    /// ω_c = ω_e/(63 + (√5 - 1)/2): the teeth do not repeat with the turn.
    pub fn new(mesh: f64, error: f64) -> Self {
        SlippingPair { mesh, centre: mesh / (63.0 + 0.5 * (5f64.sqrt() - 1.0)), damping: 0.02, error }
    }

    pub fn start() -> State {
        State::new(0.0, &[-1.0 - SlippingPair::LOAD], &[0.0])
    }

    fn piece(q: f64) -> Piece {
        match q {
            q if q < -1.0 => Piece::Lower,
            q if q > 1.0 => Piece::Upper,
            _ => Piece::Gap,
        }
    }

    fn tooth(piece: Piece, q: f64) -> (f64, f64) {
        match piece {
            Piece::Lower => (q + 1.0, 1.0),
            Piece::Gap => (0.0, 0.0),
            Piece::Upper => (q - 1.0, 1.0),
        }
    }
}

impl Model for SlippingPair {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.accel_on_pieces(&[SlippingPair::piece(q[0])], u, q, v, a);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, jacobian: true, ..Offers::default() }
    }
    fn drives(&self) -> usize {
        2
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.drive_at(&[self.mesh * t, self.centre * t], side, u);
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let force = u[0] * SlippingPair::tooth(SlippingPair::piece(q[0]), q[0]).0;
        out[0] =
            Contact { deflection: q[0], rate: v[0], lower: -1.0, upper: 1.0, force, ..Contact::default() };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = u[1] - self.damping * v[0] - u[0] * SlippingPair::tooth(pieces[0], q[0]).0;
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], _: &[f64], out: &mut Jacobian) {
        let piece = pieces.map_or(SlippingPair::piece(q[0]), |pieces| pieces[0]);
        (out.q[(0, 0)], out.v[(0, 0)]) = (-u[0] * SlippingPair::tooth(piece, q[0]).1, -self.damping);
    }
}

impl QuasiPeriodic for SlippingPair {
    fn frequencies(&self) -> Vec<f64> {
        vec![self.mesh, self.centre]
    }
    fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
        let (mesh, centre) = (angles[0], angles[1]);
        let radius = 1.0 + 0.3846 * centre.cos();
        u[0] = (1.0 + 0.29 * mesh.cos()) * radius * radius / (1.0 + 0.5 * 0.3846 * 0.3846);
        let share = 1.0 / 6.2e-4;
        u[1] = -SlippingPair::LOAD - 5.5e-6 * share * centre.sin()
            + 2.2e-6 * share * (2.0 * centre).sin()
            + self.error * mesh.sin();
    }
}

/// q'' = f(q, q') + p cos ωt: a model with one period.
pub struct PeriodicallyForced<F> {
    pub amplitude: f64,
    pub omega: f64,
    pub law: F,
}

impl<F: Fn(f64, f64) -> f64> Model for PeriodicallyForced<F> {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = (self.law)(q[0], v[0]) + self.amplitude * (self.omega * u[0]).cos();
    }
}

impl<F: Fn(f64, f64) -> f64> Periodic for PeriodicallyForced<F> {
    fn period(&self) -> f64 {
        TAU / self.omega
    }
}

/// q'' - ε (1 - q²) q' + q = p cos ωt.
pub fn van_der_pol(epsilon: f64, amplitude: f64, omega: f64) -> PeriodicallyForced<impl Fn(f64, f64) -> f64> {
    PeriodicallyForced { amplitude, omega, law: move |q: f64, v: f64| epsilon * (1.0 - q * q) * v - q }
}

pub fn round(nodes: usize, radius: f64) -> ClosedCurve {
    let angle = |j: usize| TAU * j as f64 / nodes as f64;
    let state = |j| State::new(0.0, &[radius * f64::cos(angle(j))], &[-radius * f64::sin(angle(j))]);
    ClosedCurve::new(&(0..nodes).map(state).collect::<Vec<_>>()).unwrap()
}

pub fn within(highest: &[usize]) -> WaveVectors {
    WaveVectors::within(highest).unwrap()
}

/// q'' + 0.1 q' + q + 0.2 q³ with two tones.
pub fn duffing(phases: [f64; 2]) -> Forced<impl Fn(f64, f64) -> f64> {
    Forced {
        frequencies: vec![0.7, 0.7 * 3f64.sqrt()],
        phases,
        law: |q: f64, v: f64| -0.1 * v - q - 0.2 * q * q * q,
    }
}

/// The torus that a balance finds from a motion at rest.
pub fn from_rest(balance: &TorusBalance, model: &dyn QuasiPeriodic, q: &[f64]) -> Result<Torus, TorusError> {
    balance.solve(model, &balance.at_rest(model, q)?)
}
