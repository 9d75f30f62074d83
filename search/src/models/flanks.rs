//! An oscillator on one flank of a contact, whose other flank is far or has a large law.

use crate::draw::Draw;
use gear_dynamics::contact::{Contact, Piece};
use gear_dynamics::model::Offers;
use gear_dynamics::num_complex::Complex64;
use gear_dynamics::{Model, Periodic};
use std::f64::consts::TAU;

/// x'' = F + P cos Ωt - c x' - f(x) with f = x - b above the gap. P is below what lifts the motion off the flank.
#[derive(Clone, Debug)]
pub struct Flanks {
    /// Half width of the gap b.
    pub half_backlash: f64,
    /// F.
    pub load: f64,
    /// P.
    pub pulse: f64,
    /// c.
    pub damping: f64,
    /// Ω.
    pub speed: f64,
    /// The law of the lower flank over its depth y: r y, or (e^{r y} - 1)/r.
    pub far: f64,
    /// Whether that law is exponential.
    pub exponential: bool,
}

impl Flanks {
    /// Draws a model whose motion stays on the upper flank.
    pub fn draw(draw: &mut Draw) -> Self {
        let (load, damping, speed) = (draw.scale(1e-3, 1.0), draw.within(0.02, 0.5), draw.within(0.3, 2.5));
        let exponential = draw.below(2) == 0;
        let half_backlash = if exponential { draw.scale(1e-2, 2.0) } else { load * draw.scale(1e-2, 1e6) };
        let far = if exponential { draw.within(1.0, 8.0) } else { draw.scale(1e-6, 1e6) };
        let mut flanks = Flanks { half_backlash, load, pulse: 1.0, damping, speed, far, exponential };
        // The free motion adds up to half of the forced one, and damps.
        flanks.pulse = load * draw.within(0.02, 0.3) / flanks.response().norm();
        flanks
    }
    /// The place of rest on the upper flank.
    pub fn rest(&self) -> f64 {
        self.half_backlash + self.load
    }
    /// P/(1 - Ω² + i c Ω).
    pub fn response(&self) -> Complex64 {
        self.pulse / Complex64::new(1.0 - self.speed * self.speed, self.damping * self.speed)
    }
    fn piece(&self, x: f64) -> Piece {
        if x < -self.half_backlash {
            Piece::Lower
        } else if x > self.half_backlash {
            Piece::Upper
        } else {
            Piece::Gap
        }
    }
    fn force(&self, piece: Piece, x: f64) -> f64 {
        match piece {
            Piece::Upper => x - self.half_backlash,
            Piece::Gap => 0.0,
            Piece::Lower if self.exponential => {
                ((self.far * (x + self.half_backlash)).exp() - 1.0) / self.far
            }
            Piece::Lower => self.far * (x + self.half_backlash),
        }
    }
}

impl Model for Flanks {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.accel_on_pieces(&[self.piece(q[0])], u, q, v, a);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let (b, force) = (self.half_backlash, self.force(self.piece(q[0]), q[0]));
        out[0] = Contact { deflection: q[0], rate: v[0], lower: -b, upper: b, force, ..Contact::default() };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let pulse = self.pulse * (self.speed * u[0]).cos();
        a[0] = self.load + pulse - self.damping * v[0] - self.force(pieces[0], q[0]);
    }
}

impl Periodic for Flanks {
    fn period(&self) -> f64 {
        TAU / self.speed
    }
}
