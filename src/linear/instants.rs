//! Means of accelerations, Jacobians and contacts of a model at rest over a period.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::structure::slopes::{Slopes, accelerate};
use crate::model::{Model, Periodic};
use crate::numeric::gauss::FIVE;
use nalgebra::DMatrix;

/// The drives at some instants, with weights whose sum is 1.
pub(crate) struct Instants {
    drives: usize,
    /// One row of drives for each instant.
    u: Vec<f64>,
    weights: Vec<f64>,
}

impl Instants {
    /// One instant.
    pub(crate) fn at(model: &dyn Model, t: f64) -> Self {
        let mut u = vec![0.0; model.drives()];
        model.drive(t, Side::After, &mut u);
        Instants { drives: u.len(), u, weights: vec![1.0] }
    }

    /// The middles of `count` equal parts of the period.
    pub(crate) fn spread(model: &dyn Periodic, count: usize) -> Self {
        let (drives, period) = (model.drives(), model.period());
        let mut u = vec![0.0; drives * count];
        for k in 0..count {
            let t = period * ((k as f64 + 0.5) / count as f64);
            model.drive(t, Side::After, &mut u[drives * k..][..drives]);
        }
        Instants { drives, u, weights: vec![1.0 / count as f64; count] }
    }

    /// The points of the Gauss rule with 5 points on `panels` equal panels between two `bounds` each.
    pub(crate) fn of(model: &dyn Model, bounds: &[f64], panels: usize) -> Self {
        let (drives, span) = (model.drives(), bounds[bounds.len() - 1] - bounds[0]);
        let count = FIVE.len() * panels * (bounds.len() - 1);
        let mut instants =
            Instants { drives, u: vec![0.0; drives * count], weights: Vec::with_capacity(count) };
        for bound in bounds.windows(2) {
            let h = (bound[1] - bound[0]) / panels as f64;
            for panel in 0..panels {
                for [x, weight] in FIVE {
                    let row = drives * instants.weights.len();
                    let t = bound[0] + h * (panel as f64 + 0.5 + 0.5 * x);
                    model.drive(t, Side::After, &mut instants.u[row..][..drives]);
                    instants.weights.push(0.5 * weight * h / span);
                }
            }
        }
        instants
    }

    /// The weight and the drives of each instant.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (f64, &[f64])> {
        self.weights
            .iter()
            .enumerate()
            .map(|(i, &weight)| (weight, &self.u[self.drives * i..][..self.drives]))
    }
}

/// Means of a model at rest over some instants.
pub(crate) struct Mean<'m> {
    pub(crate) model: &'m dyn Periodic,
    instants: Instants,
    /// Coordinates and velocities of 0.
    pub(crate) rest: Vec<f64>,
}

impl<'m> Mean<'m> {
    pub(crate) fn new(model: &'m dyn Periodic, instants: Instants) -> Self {
        Mean { model, instants, rest: vec![0.0; model.dof()] }
    }

    /// Whether the mean is the value at one instant.
    pub(crate) fn is_of_one_instant(&self) -> bool {
        self.instants.weights.len() == 1
    }

    /// The mean acceleration at rest in a position.
    pub(crate) fn acceleration(&self, pieces: Option<&[Piece]>, q: &[f64]) -> Vec<f64> {
        let (mut mean, mut a) = (self.rest.clone(), self.rest.clone());
        for (weight, u) in self.instants.iter() {
            accelerate(self.model, pieces, u, q, &self.rest, &mut a);
            mean.iter_mut().zip(&a).for_each(|(mean, a)| *mean += weight * a);
        }
        mean
    }

    /// The largest mean size of an acceleration at q = 0.
    pub(crate) fn load(&self, pieces: &[Piece]) -> f64 {
        let (mut mean, mut a) = (self.rest.clone(), self.rest.clone());
        for (weight, u) in self.instants.iter() {
            accelerate(self.model, Some(pieces), u, &self.rest, &self.rest, &mut a);
            mean.iter_mut().zip(&a).for_each(|(mean, a)| *mean += weight * a.abs());
        }
        mean.into_iter().fold(0.0, f64::max)
    }

    /// The mean of ∂a/∂q at rest in a position.
    pub(crate) fn jacobian(
        &self,
        slopes: &mut Slopes<'m>,
        pieces: Option<&[Piece]>,
        q: &[f64],
    ) -> DMatrix<f64> {
        let mut mean = DMatrix::zeros(q.len(), q.len());
        for (weight, u) in self.instants.iter() {
            slopes.at(pieces, u, q, &self.rest);
            mean.zip_apply(&slopes.jacobian.q, |mean, here| *mean += weight * here);
        }
        mean
    }

    /// The mean contacts in a position.
    pub(crate) fn contacts(&self, q: &[f64]) -> Vec<Contact> {
        let mut here = vec![Contact::default(); self.model.contacts()];
        let mut sums = vec![[0.0; 7]; here.len()];
        for (weight, u) in self.instants.iter() {
            self.model.contact(u, q, &self.rest, &mut here);
            for (sums, c) in sums.iter_mut().zip(&here) {
                let Contact { deflection, rate, lower, upper, lower_rate, upper_rate, force } = *c;
                let values = [deflection, rate, lower, upper, lower_rate, upper_rate, force];
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            }
        }
        let mean = |[deflection, rate, lower, upper, lower_rate, upper_rate, force]: [f64; 7]| Contact {
            deflection,
            rate,
            lower,
            upper,
            lower_rate,
            upper_rate,
            force,
        };
        sums.into_iter().map(mean).collect()
    }
}

/// 0, the edges of the drives in the first period, and its end; at most `most` intervals, which then end
/// before the period does.
pub(crate) fn smooth_intervals(model: &dyn Periodic, most: usize) -> Vec<f64> {
    let period = model.period();
    let mut bounds = vec![0.0];
    let mut t = 0.0;
    while t < period && bounds.len() <= most {
        t = model.next_edge(t).filter(|&edge| edge > t && edge < period).unwrap_or(period);
        bounds.push(t);
    }
    bounds
}
