//! The flow between two instants of a stroboscope, from any angle.

use crate::drives::{rules::DriveRule, rules::Wrapped};
use crate::excitation::Side;
use crate::model::{Model, Periodic};
use crate::tori::quasi_periodic::QuasiPeriodic;
use std::f64::consts::TAU;

/// The model of a stroboscopic map.
pub(crate) enum Strobed<'m> {
    /// Drives of one period, and the number of periods of the map. The flow from each point of the circle is
    /// the same.
    Periodic(&'m dyn Periodic, usize),
    /// Two base frequencies, and the number of periods of the strobed one. The flow depends on the angle that
    /// is not strobed.
    TwoAngles { model: &'m dyn QuasiPeriodic, frequencies: [f64; 2], strobe: usize, multiple: usize },
}

impl Strobed<'_> {
    pub(crate) fn period(&self) -> f64 {
        match self {
            Strobed::Periodic(model, multiple) => *multiple as f64 * model.period(),
            Strobed::TwoAngles { frequencies, strobe, multiple, .. } => {
                *multiple as f64 * (TAU / frequencies[*strobe])
            }
        }
    }
    pub(crate) fn dof(&self) -> usize {
        match self {
            Strobed::Periodic(model, _) => model.dof(),
            Strobed::TwoAngles { model, .. } => model.dof(),
        }
    }
    /// Rotation over a period, if the drives determine it.
    pub(crate) fn rotation(&self) -> Option<f64> {
        match self {
            Strobed::Periodic(..) => None,
            Strobed::TwoAngles { frequencies, strobe, multiple, .. } => {
                Some(TAU * (*multiple as f64 * (frequencies[1 - strobe] / frequencies[*strobe])).fract())
            }
        }
    }

    /// Calls `run` with the model that has the free angle `theta` at time `t`.
    pub(crate) fn with<R>(&self, theta: f64, t: f64, run: impl FnOnce(&dyn Model) -> R) -> R {
        match self {
            Strobed::Periodic(model, _) => {
                let model: &dyn Model = *model;
                run(model)
            }
            Strobed::TwoAngles { model, frequencies, strobe, .. } => {
                let rule = FromAngle { frequencies: *frequencies, strobe: *strobe, theta, t };
                run(&Wrapped::by_rule(*model, rule))
            }
        }
    }
}

/// The drives of two base frequencies whose free angle is `theta` at time `t`. The strobed angle is ω t at
/// every time.
struct FromAngle {
    frequencies: [f64; 2],
    strobe: usize,
    theta: f64,
    t: f64,
}

impl FromAngle {
    fn angles(&self, t: f64) -> [f64; 2] {
        let mut angles = [0.0; 2];
        angles[self.strobe] = self.frequencies[self.strobe] * t;
        angles[1 - self.strobe] = self.theta + self.frequencies[1 - self.strobe] * (t - self.t);
        angles
    }
}

impl DriveRule<&dyn QuasiPeriodic> for FromAngle {
    fn drive(&self, model: &&dyn QuasiPeriodic, t: f64, side: Side, u: &mut [f64]) {
        model.drive_at(&self.angles(t), side, u);
    }
    fn next_edge(&self, model: &&dyn QuasiPeriodic, t: f64) -> Option<f64> {
        model.edge_after(&self.angles(t)).map(|after| t + after)
    }
    fn next_knot(&self, _: &&dyn QuasiPeriodic, _: f64) -> Option<f64> {
        None
    }
}
