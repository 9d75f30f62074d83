//! Gear trains in SI units, with contact forces and Jacobians.

use crate::api::*;

/// A mesh between coordinates: d = Σ_j γ_j q_j - e sin ωt `[m]`, W = K g(d) + C d' `[N]`, g the dead zone of
/// half backlash b.
#[derive(Clone, Copy)]
pub struct Tooth<const N: usize> {
    /// γ_j = ∂d/∂q_j `[m]`.
    pub gradient: [f64; N],
    pub stiffness: f64,
    pub damping: f64,
    pub half_backlash: f64,
    pub error: f64,
}

/// J_j q_j'' = T_j - k_j q_j - Σ_i γ_ij W_i: inertias connected by meshes. A shaft of stiffness k_j connects
/// inertia j to the ground.
pub struct Train<const N: usize, const M: usize> {
    pub teeth: [Tooth<N>; M],
    pub inertia: [f64; N],
    pub torque: [f64; N],
    /// Stiffness k_j of the shafts to the ground.
    pub shaft: [f64; N],
    pub omega: f64,
}

impl<const N: usize, const M: usize> Train<N, M> {
    /// The contact of mesh `i`, on a given piece or, with `None`, on its own.
    fn reading(&self, i: usize, u: &[f64], q: &[f64], v: &[f64], piece: Option<Piece>) -> Contact {
        let tooth = &self.teeth[i];
        let sum = |x: &[f64]| tooth.gradient.iter().zip(x).map(|(g, x)| g * x).sum::<f64>();
        let (d, rate) = (sum(q) - tooth.error * u[0], sum(v) - tooth.error * self.omega * u[1]);
        let b = tooth.half_backlash;
        let contact = Contact { deflection: d, rate, lower: -b, upper: b, ..Contact::default() };
        let elastic = match piece.unwrap_or(contact.piece()) {
            Piece::Lower => d + b,
            Piece::Gap => 0.0,
            Piece::Upper => d - b,
        };
        Contact { force: tooth.stiffness * elastic + tooth.damping * rate, ..contact }
    }

    /// The accelerations, on given pieces or, with `None`, on the contacts' own.
    fn turn(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        for (j, a) in a.iter_mut().enumerate() {
            *a = self.torque[j] - self.shaft[j] * q[j];
        }
        for i in 0..M {
            let force = self.reading(i, u, q, v, pieces.map(|pieces| pieces[i])).force;
            for (a, gradient) in a.iter_mut().zip(&self.teeth[i].gradient) {
                *a -= gradient * force;
            }
        }
        for (a, inertia) in a.iter_mut().zip(&self.inertia) {
            *a /= inertia;
        }
    }
}

impl<const N: usize, const M: usize> Model for Train<N, M> {
    fn dof(&self) -> usize {
        N
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.turn(None, u, q, v, a);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, jacobian: true, ..Offers::default() }
    }
    fn drives(&self) -> usize {
        2
    }
    fn drive(&self, t: f64, _: Side, u: &mut [f64]) {
        (u[0], u[1]) = (self.omega * t).sin_cos();
    }
    fn contacts(&self) -> usize {
        M
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        for (i, out) in out.iter_mut().enumerate() {
            *out = self.reading(i, u, q, v, None);
        }
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.turn(Some(pieces), u, q, v, a);
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        for j in 0..N {
            for k in 0..N {
                let shaft = if j == k { self.shaft[j] } else { 0.0 };
                let (mut by_q, mut by_v) = (-shaft, 0.0);
                for (i, tooth) in self.teeth.iter().enumerate() {
                    let piece =
                        pieces.map_or_else(|| self.reading(i, u, q, v, None).piece(), |pieces| pieces[i]);
                    let both = tooth.gradient[j] * tooth.gradient[k];
                    by_q -= if piece == Piece::Gap { 0.0 } else { both * tooth.stiffness };
                    by_v -= both * tooth.damping;
                }
                (out.q[(j, k)], out.v[(j, k)]) = (by_q / self.inertia[j], by_v / self.inertia[j]);
            }
        }
    }
}

impl<const N: usize, const M: usize> Periodic for Train<N, M> {
    fn period(&self) -> f64 {
        std::f64::consts::TAU / self.omega
    }
}

/// A planetary set of three planets. Coordinates: sun, carrier, planets `[rad]`; the ring is fixed. Contacts:
/// the meshes of the sun, then those of the ring. A torque drives the sun; a shaft holds the carrier.
pub fn planetary() -> Train<5, 6> {
    let (sun, planet) = (0.03, 0.02);
    let carrier = sun + planet;
    let tooth =
        |gradient| Tooth { gradient, stiffness: 2e8, damping: 500.0, half_backlash: 2e-5, error: 0.0 };
    let teeth = std::array::from_fn(|i| {
        let mut gradient = [0.0; 5];
        if i < 3 {
            (gradient[0], gradient[1], gradient[2 + i]) = (sun, -carrier, planet);
        } else {
            (gradient[1], gradient[2 + i - 3]) = (-carrier, -planet);
        }
        tooth(gradient)
    });
    let inertia = [4e-4, 6e-3, 5e-5, 5e-5, 5e-5];
    Train {
        teeth,
        inertia,
        torque: [60.0, 0.0, 0.0, 0.0, 0.0],
        shaft: [0.0, 1e6, 0.0, 0.0, 0.0],
        omega: 3000.0,
    }
}

/// Static equilibrium of the planetary set under its torque.
pub fn planetary_static_start() -> State {
    // Each planet transmits the mesh force T/(3 R_s) from the sun to the ring. The carrier takes both mesh
    // forces of each planet, which is a torque of 2 R_c T/R_s.
    let (sun, planet, carrier, torque) = (0.03, 0.02, 0.05, 60.0);
    let d = 2e-5 + torque / (3.0 * sun) / 2e8;
    let angle = 2.0 * carrier * torque / sun / 1e6;
    let spin = -(d + carrier * angle) / planet;
    let turn = (d + carrier * angle - planet * spin) / sun;
    State::new(0.0, &[turn, angle, spin, spin, spin], &[0.0; 5])
}

/// Two stages: input, intermediate shaft, output `[rad]`. The load of 600 N m on the output balances the
/// input torque of 100 N m.
pub fn two_stage() -> Train<3, 2> {
    let tooth =
        |gradient, stiffness| Tooth { gradient, stiffness, damping: 800.0, half_backlash: 3e-5, error: 4e-6 };
    let teeth = [tooth([0.04, -0.08, 0.0], 3e8), tooth([0.0, 0.03, -0.09], 4e8)];
    Train { teeth, inertia: [2e-3, 1e-2, 4e-2], torque: [100.0, 0.0, -600.0], shaft: [0.0; 3], omega: 2000.0 }
}

/// State of the two stages at the input angle `angle` `[rad]`. `pressed` are the depths past the upper edges
/// `[m]` before the transmission error is subtracted.
pub fn two_stage_turned(angle: f64, pressed: [f64; 2]) -> State {
    let middle = (0.04 * angle - 3e-5 - pressed[0]) / 0.08;
    let output = (0.03 * middle - 3e-5 - pressed[1]) / 0.09;
    State::new(0.3, &[angle, middle, output], &[200.0, 100.0, 100.0 / 3.0])
}
