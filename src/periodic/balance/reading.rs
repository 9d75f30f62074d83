//! Results of an orbit: time histories, contacts.

use crate::error::{ParameterError, check};
use crate::model::equations::early;
use crate::model::{Periodic, State};
use crate::ode::{Failed, Integrator, Trajectory};
use crate::periodic::balance::crossings::contact_history::ContactHistory;
use crate::periodic::balance::crossings::instants::Crossings;
use crate::periodic::balance::fourier_orbit::{FourierOrbit, hermite_extreme};
use crate::periodic::balance::quadrature::resolution::samples_along;
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::periodic::balance::series::transform::{Transform, samples_for, spread, unpack, write};
use num_complex::Complex64;
use std::f64::consts::TAU;

impl FourierOrbit {
    /// Orbit from a run: integrates one span from `start`, which must lie on a settled orbit, and transforms
    /// it to the given orders. A start later than 64 of its periods begins at the same instant of the first,
    /// whose time is not rounded so coarsely.
    ///
    /// # Errors
    /// [`Failed`] if the integration fails, `start` does not fit the model, or the run would hold more than
    /// 2²⁶ numbers.
    pub fn project(
        integrator: &dyn Integrator,
        model: &dyn Periodic,
        start: &State,
        harmonics: &Harmonics,
    ) -> Result<Self, Failed> {
        let span = model.period() * harmonics.period_multiple() as f64;
        let start = &State { t: early(start.t, span), ..start.clone() };
        let (m, n) = (samples_for(harmonics.highest()), start.q.len());
        harmonics.check()?;
        check::count("numbers of the run", &[m, 2 * n], check::NUMBERS)?;
        let times: Vec<f64> = (0..m).map(|j| start.t + span * j as f64 / m as f64).collect();
        let run = integrator.sample(model, start, &times)?;
        let samples: Vec<f64> =
            (0..n).flat_map(|j| (0..m).map(move |s| (j, s))).map(|(j, s)| run.q(s)[j]).collect();
        Ok(FourierOrbit::of_samples_from(start.t / span, harmonics, span, n, &samples))
    }

    /// The series of `n` coordinates from uniform samples over one span from t = 0, those of one coordinate
    /// after those of the other.
    pub(crate) fn of_samples(harmonics: &Harmonics, span: f64, n: usize, samples: &[f64]) -> Self {
        FourierOrbit::of_samples_from(0.0, harmonics, span, n, samples)
    }

    /// [`of_samples`](FourierOrbit::of_samples) for samples that start at the time `start` over the span.
    fn of_samples_from(start: f64, harmonics: &Harmonics, span: f64, n: usize, samples: &[f64]) -> Self {
        let m = samples.len() / n.max(1);
        let mut transform = Transform::new(m);
        let mut coefficients = vec![0.0; n * harmonics.unknowns()];
        for (j, part) in coefficients.chunks_exact_mut(harmonics.unknowns()).enumerate() {
            let mut buffer: Vec<Complex64> =
                samples[j * m..(j + 1) * m].iter().map(|q| (*q).into()).collect();
            transform.analyse(&mut buffer);
            for (i, &order) in harmonics.orders().iter().enumerate() {
                // The samples start at `start`, the series at t = 0.
                let turn = Complex64::cis(-TAU * (order as f64 * start).fract());
                write(&mut part[harmonics.place(i)..], order, unpack(&buffer, order).0 * turn);
            }
        }
        FourierOrbit::of(harmonics, span, coefficients, n)
    }

    /// Time history: `samples` states at uniform instants over one span, from t = 0. The trajectory also
    /// returns the channels of a model, for example deflections and mesh forces.
    ///
    /// # Errors
    /// [`ParameterError`] for more than 2²⁶ numbers.
    pub fn history(&self, samples: usize) -> Result<Trajectory, ParameterError> {
        let n = self.dof();
        check::count("numbers of the history", &[samples, 2 * n], check::NUMBERS)?;
        if samples == 0 {
            return Ok(Trajectory::empty(n, 0.0));
        }
        let fine = samples.max(2 * self.harmonics.highest() + 1).div_ceil(samples.max(1)) * samples;
        let mut z = vec![vec![Complex64::ZERO; fine]; n];
        let mut transform = Transform::new(fine);
        for (j, z) in z.iter_mut().enumerate() {
            spread(self.coefficients(j), &self.harmonics, self.frequency(), z);
            transform.synthesise(z);
        }
        let mut trajectory = Trajectory::empty(n, 0.0);
        let mut y = vec![0.0; 2 * n];
        for s in 0..samples {
            let (at, t) = (s * (fine / samples), self.period * s as f64 / samples as f64);
            for j in 0..n {
                let (rigid, mean) = (self.mean_acceleration[j], self.mean_velocity[j]);
                y[j] = z[j][at].re + (mean + 0.5 * rigid * t) * t;
                y[n + j] = z[j][at].im + mean + rigid * t;
            }
            trajectory.push(t, &y);
        }
        Ok(trajectory)
    }

    /// Peak-to-peak value of coordinate j: maximum less minimum, with the extremes between samples.
    ///
    /// # Panics
    /// If there is no coordinate j.
    pub fn peak_to_peak(&self, j: usize) -> f64 {
        let mut z = vec![Complex64::ZERO; samples_for(self.harmonics.highest())];
        spread(self.coefficients(j), &self.harmonics, self.frequency(), &mut z);
        Transform::new(z.len()).synthesise(&mut z);
        let h = self.period / z.len() as f64;
        let range = (0..z.len()).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], s| {
            let (a, b) = (z[s], z[(s + 1) % z.len()]);
            let inner = if a.im * b.im < 0.0 { hermite_extreme(a, b, h) } else { a.re };
            [low.min(a.re).min(inner), high.max(a.re).max(inner)]
        });
        range[1] - range[0]
    }

    /// History of each contact over one span: the intervals on its pieces, with located ends.
    ///
    /// # Errors
    /// [`ParameterError`] if the model has another number of coordinates.
    pub fn contacts(&self, model: &dyn Periodic) -> Result<Vec<ContactHistory>, ParameterError> {
        check::length("coordinates of the orbit", self.dof(), model.dof())?;
        let mut grid = Grid::new(model, &self.harmonics, samples_along(model, self));
        grid.set(&self.coefficients, &self.mean_velocity);
        let mut crossings = Crossings::new(model.contacts(), grid.samples());
        crossings.locate(&mut grid);
        let touching = model.offers().touching(model.contacts());
        Ok((0..touching).map(|c| ContactHistory::new(&crossings, c, self.period)).collect())
    }
}
