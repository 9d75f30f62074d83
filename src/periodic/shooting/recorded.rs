//! One period of an orbit, recorded: results of it without another integration.

use crate::contact::Piece;
use crate::error::{ParameterError, check};
use crate::model::{Model, State};
use crate::ode::{Crossing, IntegrateError, Observer, Step, StepView};
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::periodic::balance::series::transform::samples_for;
use crate::periodic::shooting::shooting_orbit::ShootingOrbit;
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// One period of an orbit, with its dense output.
///
/// Statistics, rattle, impacts, spectra, crossings and the Fourier series come from it without
/// another integration: every observer can be [replayed](RecordedOrbit::replay). Between the samples the
/// motion is the polynomial through 13 Chebyshev points of each part of a step.
///
/// ```
/// use gear_dynamics::{Harmonics, Shooting, State, Statistics, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[], &[0.02])?.parts()?.build("driver", 0.7)?;
/// let orbit = Shooting::new().solve(&pair, &State::new(0.0, &[1.1], &[0.0]))?;
/// let recorded = orbit.record(&pair)?;
/// let mut statistics = Statistics::new(&pair, &["deflection"])?;
/// recorded.replay(&mut statistics)?;
/// assert!((statistics.summary("deflection")?.mean - 1.1).abs() < 1e-12);
/// // Teeth stay in contact: one harmonic. The coordinate is the deflection plus the error e cos φ, of the
/// // amplitude e √(1 + (2 ζ W)²)/√((1 - W²)² + (2 ζ W)²).
/// let series = recorded.fourier(&Harmonics::up_to(3))?;
/// let coefficients = series.coefficients(0);
/// let amplitude = coefficients[1].hypot(coefficients[2]);
/// assert!((amplitude - 0.02 * 1f64.hypot(0.07) / 0.51f64.hypot(0.07)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct RecordedOrbit {
    dof: usize,
    /// Number of contacts of the model.
    contacts: usize,
    steps: Vec<RecordedStep>,
    period: f64,
}

/// One step, with its samples.
#[derive(Clone, Debug)]
struct RecordedStep {
    times: (f64, f64),
    parts: usize,
    pieces: Option<Vec<Piece>>,
    crossings: Vec<Crossing>,
    at_drive_edge: bool,
    /// Coordinates, then velocities, at the points of all parts, one after the other.
    samples: Vec<f64>,
}

/// Number of Chebyshev points of a part, both ends included.
const POINTS: usize = 13;

/// Places of the points on 0 .. 1.
fn place(i: usize) -> f64 {
    0.5 - 0.5 * (PI * i as f64 / (POINTS - 1) as f64).cos()
}

impl ShootingOrbit {
    /// Integrates one period and records it.
    ///
    /// # Errors
    /// [`IntegrateError`].
    pub fn record(&self, model: &dyn Model) -> Result<RecordedOrbit, IntegrateError> {
        let dof = model.dof();
        let mut recorded =
            RecordedOrbit { dof, contacts: model.contacts(), steps: Vec::new(), period: self.period() };
        let mut y = vec![0.0; 2 * dof];
        let mut keep = |step: &mut Step<'_>| {
            let mut samples = Vec::with_capacity(step.parts() * POINTS * 2 * dof);
            for part in 0..step.parts() {
                let (from, to) = step.part(part);
                for i in 0..POINTS {
                    let t = if i == POINTS - 1 { to } else { from + (to - from) * place(i) };
                    step.at(t, &mut y);
                    samples.extend_from_slice(&y);
                }
            }
            recorded.steps.push(RecordedStep {
                times: (step.t0(), step.t1()),
                parts: step.parts(),
                pieces: step.pieces().map(<[Piece]>::to_vec),
                crossings: step.crossings().to_vec(),
                at_drive_edge: step.at_drive_edge(),
                samples,
            });
            ControlFlow::Continue(())
        };
        self.observe(model, &mut keep)?;
        Ok(recorded)
    }
}

impl RecordedOrbit {
    /// Period.
    pub fn period(&self) -> f64 {
        self.period
    }
    /// Passes every step of the period to an observer, until it stops.
    ///
    /// # Errors
    /// [`ParameterError::OtherModel`](crate::ParameterError) for an observer of a model of another shape.
    pub fn replay(&self, observer: &mut dyn Observer) -> Result<(), ParameterError> {
        observer.fits(self.dof, self.contacts)?;
        for step in &self.steps {
            let mut view = RecordedView { step, dof: self.dof };
            if observer.step(&mut Step::new(&mut view, step.at_drive_edge, &step.crossings)).is_break() {
                break;
            }
        }
        Ok(())
    }
    /// The crossings of the edges of contacts, each with its instant, in order.
    pub fn crossings(&self) -> Vec<(f64, Crossing)> {
        let of = |step: &RecordedStep| {
            step.crossings.iter().map(|crossing| (step.times.1, *crossing)).collect::<Vec<_>>()
        };
        self.steps.iter().flat_map(of).collect()
    }
    /// The state at a time, one period repeated. Motions along rigid modes drift and are not repeated.
    ///
    /// # Errors
    /// A time that is not finite.
    pub fn at(&self, t: f64) -> Result<State, ParameterError> {
        check::finite("time", t)?;
        let mut y = vec![0.0; 2 * self.dof];
        self.write(t, &mut y);
        Ok(State::new(t, &y[..self.dof], &y[self.dof..]))
    }
    fn write(&self, t: f64, y: &mut [f64]) {
        let start = self.steps.first().map_or(0.0, |step| step.times.0);
        let inside = start + (t - start).rem_euclid(self.period);
        let at = self.steps.partition_point(|step| step.times.1 < inside).min(self.steps.len() - 1);
        let mut view = RecordedView { step: &self.steps[at], dof: self.dof };
        view.at(inside, y);
    }

    /// The Fourier series of the coordinates at the given orders of the orbit. A drift along rigid modes
    /// spoils it.
    ///
    /// # Errors
    /// Orders that are not valid; more than 2²⁶ samples.
    pub fn fourier(&self, harmonics: &Harmonics) -> Result<FourierOrbit, ParameterError> {
        harmonics.check()?;
        let m = samples_for(harmonics.highest());
        check::count("samples of the series", &[m, 2 * self.dof], check::NUMBERS)?;
        let mut samples = vec![0.0; m * self.dof];
        let mut y = vec![0.0; 2 * self.dof];
        for s in 0..m {
            self.write(self.period * (s as f64 / m as f64), &mut y);
            (0..self.dof).for_each(|j| samples[j * m + s] = y[j]);
        }
        Ok(FourierOrbit::of_samples(harmonics, self.period, self.dof, &samples))
    }
}

/// A recorded step as a solver presents one.
struct RecordedView<'s> {
    step: &'s RecordedStep,
    dof: usize,
}

impl StepView for RecordedView<'_> {
    fn times(&self) -> (f64, f64) {
        self.step.times
    }
    fn start(&self) -> &[f64] {
        &self.step.samples[..2 * self.dof]
    }
    fn end(&self) -> &[f64] {
        &self.step.samples[self.step.samples.len() - 2 * self.dof..]
    }
    fn pieces(&self) -> Option<&[Piece]> {
        self.step.pieces.as_deref()
    }
    /// Barycentric interpolation at Chebyshev points of the second kind.   Source: Berrut & Trefethen, SIAM
    /// Rev. 46, 501 (2004).
    fn at(&mut self, t: f64, y: &mut [f64]) {
        let ((t0, t1), n) = (self.step.times, 2 * self.dof);
        let through = ((t - t0) / (t1 - t0) * self.step.parts as f64).clamp(0.0, self.step.parts as f64);
        let part = (through as usize).min(self.step.parts - 1);
        let x = through - part as f64;
        let samples = &self.step.samples[part * POINTS * n..(part + 1) * POINTS * n];
        let mut sum = 0.0;
        y.fill(0.0);
        for i in 0..POINTS {
            let sample = &samples[i * n..(i + 1) * n];
            let apart = x - place(i);
            if apart == 0.0 {
                y.copy_from_slice(sample);
                return;
            }
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            let weight = sign * if i == 0 || i == POINTS - 1 { 0.5 } else { 1.0 } / apart;
            sum += weight;
            y.iter_mut().zip(sample).for_each(|(y, sample)| *y += weight * sample);
        }
        y.iter_mut().for_each(|y| *y /= sum);
    }
    fn parts(&self) -> usize {
        self.step.parts
    }
}
