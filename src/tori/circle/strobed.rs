//! The flow between two instants of a stroboscope, from any angle.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::excitation::side::Side;
use crate::model::equations::{Jacobian, Model, Periodic};
use crate::model::offers::Offers;
use crate::model::terms::Terms;
use crate::tori::quasi_periodic::QuasiPeriodic;
use std::f64::consts::TAU;

/// The model of a stroboscopic map.
pub(crate) enum Strobed<'m> {
    /// Drives of one period. The flow from each point of the circle is the same.
    Periodic(&'m dyn Periodic),
    /// Two base frequencies. The flow depends on the angle that is not strobed.
    TwoAngles { model: &'m dyn QuasiPeriodic, frequencies: [f64; 2], strobe: usize },
}

impl Strobed<'_> {
    pub(crate) fn period(&self) -> f64 {
        match self {
            Strobed::Periodic(model) => model.period(),
            Strobed::TwoAngles { frequencies, strobe, .. } => TAU / frequencies[*strobe],
        }
    }
    pub(crate) fn dof(&self) -> usize {
        match self {
            Strobed::Periodic(model) => model.dof(),
            Strobed::TwoAngles { model, .. } => model.dof(),
        }
    }
    /// Rotation over a period, if the drives determine it.
    pub(crate) fn rotation(&self) -> Option<f64> {
        match self {
            Strobed::Periodic(_) => None,
            Strobed::TwoAngles { frequencies, strobe, .. } => {
                Some(TAU * (frequencies[1 - strobe] / frequencies[*strobe]).fract())
            }
        }
    }

    /// Calls `run` with the model that has the free angle `theta` at time `t`.
    pub(crate) fn with<R>(&self, theta: f64, t: f64, run: impl FnOnce(&dyn Model) -> R) -> R {
        match self {
            Strobed::Periodic(model) => {
                let model: &dyn Model = *model;
                run(model)
            }
            Strobed::TwoAngles { model, frequencies, strobe } => {
                run(&FromAngle { model: *model, frequencies: *frequencies, strobe: *strobe, theta, t })
            }
        }
    }
}

/// A model of two base frequencies whose free angle is `theta` at time `t`. The strobed angle is ω t at every
/// time.
struct FromAngle<'m> {
    model: &'m dyn QuasiPeriodic,
    frequencies: [f64; 2],
    strobe: usize,
    theta: f64,
    t: f64,
}

impl FromAngle<'_> {
    fn angles(&self, t: f64) -> [f64; 2] {
        let mut angles = [0.0; 2];
        angles[self.strobe] = self.frequencies[self.strobe] * t;
        angles[1 - self.strobe] = self.theta + self.frequencies[1 - self.strobe] * (t - self.t);
        angles
    }
}

impl Model for FromAngle<'_> {
    fn dof(&self) -> usize {
        self.model.dof()
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.model.accel(u, q, v, a);
    }
    fn offers(&self) -> Offers<'_> {
        self.model.offers()
    }
    fn drives(&self) -> usize {
        self.model.drives()
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.model.drive_at(&self.angles(t), side, u);
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.model.edge_after(&self.angles(t)).map(|after| t + after)
    }
    fn contacts(&self) -> usize {
        self.model.contacts()
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.model.contact(u, q, v, out);
    }
    fn impact(&self, contact: usize, on: Piece, u: &[f64], q: &[f64], v: &mut [f64]) {
        self.model.impact(contact, on, u, q, v);
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.model.accel_on_pieces(pieces, u, q, v, a);
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        self.model.jacobian(pieces, u, q, v, out);
    }
    fn terms(&self) -> Option<&dyn Terms> {
        self.model.terms()
    }
}
