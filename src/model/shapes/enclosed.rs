//! Machines with enclosed drives.

use crate::contact::Piece;
use crate::error::ParameterError;
use crate::excitation::{EnclosedAngle, Side};
use crate::interval::number::Interval;
use crate::model::equations::Constants;
use crate::model::expansion::expand::{Enclosed, Recorded};
use crate::model::shapes::compiled::Compiled;
use crate::model::shapes::shape::{Drives, Shape, Size};
use crate::series::PowerSeries;
use std::f64::consts::TAU;

/// Rounding of a drive edge, as a share of its angle and a turn: of its angle by
/// [`Wave::next_edge`](crate::Wave::next_edge) and of the division by the speed.
const EDGE_ROUNDING: f64 = 32.0 * f64::EPSILON;

/// A machine with constants that are intervals.
pub(crate) struct EnclosedMachine<'m, G: Shape> {
    machine: &'m Compiled<G>,
    /// Constants as the algebra reads them; the first one is φ'.
    constants: Vec<Interval>,
}

impl<'m, G: Shape> EnclosedMachine<'m, G> {
    /// # Errors
    /// A name that the machine does not have.
    pub(crate) fn new(machine: &'m Compiled<G>, given: &[(&str, Interval)]) -> Result<Self, ParameterError> {
        let mut constants: Vec<Interval> = machine.values().iter().map(|x| Interval::from(*x)).collect();
        for (name, value) in given {
            constants[machine.index(name)?] = *value;
        }
        Ok(EnclosedMachine { machine, constants: machine.shape().prepare(&constants) })
    }
}

impl<G: Shape> Enclosed for EnclosedMachine<'_, G> {
    fn period(&self) -> Interval {
        Interval::PI * 2.0 / (self.constants[0] * f64::from(self.machine.shape().repeats()))
    }
    fn drives(&self, time: Interval, inside: f64, coefficients: usize, u: &mut [PowerSeries<Interval>]) {
        let (speed, waves) = (self.constants[0], self.machine.size().waves);
        let angle = EnclosedAngle::new(speed * time, speed, speed.middle() * inside, coefficients);
        let (of_angle, rest) = u.split_at_mut(waves);
        self.machine.shape().waves(angle, Side::After, of_angle);
        let constants = [speed, Interval::from(0.0)].into_iter().chain(self.constants[1..].iter().copied());
        rest.iter_mut().zip(constants).for_each(|(u, constant)| *u = PowerSeries::constant(constant));
    }
    fn edge(&self, time: f64) -> Interval {
        let angle = self.machine.speed() * time;
        // The edge of the excitation and the phase of the wave are rounded in a turn, also for a small angle.
        let rounding = Interval::symmetric((angle.abs() + TAU) * EDGE_ROUNDING);
        (Interval::from(angle) + rounding) / self.constants[0]
    }
    fn impact(&self, contact: usize, on: Piece) -> Recorded {
        let Size { dof, waves, .. } = self.machine.size();
        Recorded::of(dof, self.machine.size().drives(), &|_| None, |_, u, q, v, after| {
            after.copy_from_slice(v);
            self.machine.shape().impact(contact, on, Drives::new(waves, u), q, after);
            Vec::new()
        })
    }
}
