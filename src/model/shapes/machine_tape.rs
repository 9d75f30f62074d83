//! Machines as tapes.

use crate::contact::Piece;
use crate::error::ParameterError;
use crate::excitation::Side;
use crate::interval::number::Interval;
use crate::model::expansion::expand::{Enclosed, Expand, Recorded};
use crate::model::shapes::compiled::{Code, Compiled, own_drives};
use crate::model::shapes::dual_jacobian::{Way, slopes};
use crate::model::shapes::enclosed::EnclosedMachine;
use crate::model::shapes::shape::{Drives, Shape, Size};
use crate::series::Series;

impl<G: Shape> Compiled<G> {
    /// Records the algebra. `constant(d)`: the value of drive d, if it is constant.
    pub(crate) fn record_with(&self, constant: &dyn Fn(usize) -> Option<f64>) -> Recorded {
        let (Size { dof, waves, contacts, .. }, drives) = (self.size(), self.size().drives());
        let (shape, varies) = (self.shape(), constant(waves + 1).is_none());
        Recorded::of(dof, drives, constant, |every, u, q, v, a| {
            let u = Drives::new(waves, u);
            shape.accel(every, u, q, v, a);
            if varies {
                a.iter_mut().zip(shape.inertia()).for_each(|(a, by)| *a = *a + u.acceleration() * *by);
            }
            (0..contacts).map(|i| shape.contact(every, i, u, q, v)).collect()
        })
    }
}

impl<G: Shape> Expand for Compiled<G> {
    fn record(&self, moving: &dyn Fn(usize) -> bool) -> Recorded {
        let (waves, constants) = (self.size().waves, own_drives(self));
        self.record_with(&|d| (d >= waves && !moving(d)).then(|| constants[d - waves]))
    }

    fn drive_series(&self, t: f64, coefficients: usize, u: &mut [Series]) {
        let speed = self.speed();
        if let Some(series) = self.wave_series() {
            let (waves, rest) = u.split_at_mut(self.size().waves);
            series.expand(speed * t, speed, coefficients, &[], waves);
            return self.write_rest(speed.into(), 0.0.into(), rest);
        }
        let angle = Series::variable(speed * t, speed, coefficients);
        self.drive_at(angle, Side::After, [speed.into(), 0.0.into()], u);
    }
    fn redrive_series(&self, t: f64, coefficients: usize, needed: &[bool], u: &mut [Series]) {
        let (speed, waves) = (self.speed(), self.size().waves);
        if let Some(series) = self.wave_series() {
            return series.expand(speed * t, speed, coefficients, needed, &mut u[..waves]);
        }
        let angle = Series::variable(speed * t, speed, coefficients);
        self.shape().waves_again(angle, Side::After, &mut u[..waves]);
    }
    fn entries(
        &self,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        entry: &mut dyn FnMut(usize, usize, f64),
    ) -> bool {
        let columns = self.columns();
        if let Some(columns) = columns {
            slopes(self.shape(), pieces, u, q, v, Way::Grouped(columns, entry));
        }
        columns.is_some()
    }
    fn enclosed(&self, given: &[(&str, Interval)]) -> Result<Option<Box<dyn Enclosed + '_>>, ParameterError> {
        Ok(Some(Box::new(EnclosedMachine::new(self, given)?)))
    }
}
