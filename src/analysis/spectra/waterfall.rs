//! Amplitudes by order of the shaft, for runs with varying speed.

use crate::analysis::spectra::spectrum::Spectrum;
use crate::analysis::spectra::window::Window;
use crate::drives::{SpeedLaw, VaryingSpeed};
use crate::error::{ParameterError, check};
use crate::model::{Model, Shape, State};
use crate::ode::integrator::sample;
use crate::ode::probe::Probe;
use crate::ode::{Budget, Failed, Integrator};
use std::f64::consts::TAU;

/// Amplitudes by order of the body that follows the speed law, window after window of a run.
///
/// The body is the reference body of a train, unless [`VaryingSpeed::of_body`] names another one. The channel
/// is sampled at equal steps of its angle. An order then remains one line while its frequency
/// varies.
///
/// Where the channel jumps, a sample is the value before the jump. Orders above half the number of samples in
/// a turn appear as lower orders. Amplitudes are not extremes of the channel;
/// [`Statistics`](crate::analysis::Statistics) have these, on both sides of a jump.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, Rk4, drives::{SpeedLaw, VaryingSpeed}, analysis::Waterfall};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let (start, speed, turn) = (pair.on_drive_flank()?, pair.speed(), 2718.68);
/// let run_up = VaryingSpeed::new(pair, SpeedLaw::ramp(speed, 1.05 * speed, 6.0 * turn)?);
/// let lines = Waterfall::new(2, 256)?.run(&Rk4::new(1.0), &run_up, &start, 6.0 * turn, "deflection")?;
/// assert_eq!(lines.len(), 3);
/// assert!(lines[2].speed > lines[0].speed && lines[1].order(63.0) > 1e-7); // [m], of the mesh
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct Waterfall {
    turns: usize,
    samples: usize,
    budget: Budget,
}

/// The amplitudes of one window.
///
/// ```
/// use gear_dynamics::analysis::WaterfallLine;
/// let (orders, amplitudes) = (vec![0.0, 0.5, 1.0], vec![0.0, 1.0, 4.0]);
/// let line = WaterfallLine { t: 0.0, speed: 10.0, orders, amplitudes };
/// assert_eq!(line.order(0.9), 4.0); // the nearest order is 1
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct WaterfallLine {
    /// Middle of the window, in the model's time unit.
    pub t: f64,
    /// Mean speed of the body in the window, in rad per unit of time.
    pub speed: f64,
    /// Orders of the body `[1]`, increasing from 0.
    pub orders: Vec<f64>,
    /// Amplitudes of the orders, in the unit of the channel.
    pub amplitudes: Vec<f64>,
}

impl WaterfallLine {
    /// The amplitude of the order nearest to a given order; NaN if there are no orders.
    pub fn order(&self, order: f64) -> f64 {
        let near = |i: &usize, j: &usize| {
            (self.orders[*i] - order).abs().total_cmp(&(self.orders[*j] - order).abs())
        };
        (0..self.orders.len().min(self.amplitudes.len()))
            .min_by(near)
            .map_or(f64::NAN, |i| self.amplitudes[i])
    }
}

impl Waterfall {
    /// Windows of `turns` turns of the body with `samples` samples a turn. The orders are 0, 1/`turns`, ...,
    /// `samples`/2.
    ///
    /// # Errors
    /// No turns; fewer than four samples a turn; more than 2²⁶ samples in a window.
    pub fn new(turns: usize, samples: usize) -> Result<Self, ParameterError> {
        for (name, value, least) in [("turns", turns, 1), ("samples per turn", samples, 4)] {
            check::at_least(name, value, least)?;
        }
        check::count("samples in a window", &[turns, samples], check::NUMBERS)?;
        Ok(Waterfall { turns, samples, budget: Budget::new() })
    }
    /// Maximum number of steps and maximum time of a run. Default: the default [`Budget`].
    pub fn budget(self, budget: Budget) -> Self {
        Waterfall { budget, ..self }
    }

    /// Integrates from `start`, at time 0, to `end`, and returns a line for each complete window. A Hann
    /// window weights the samples.
    ///
    /// # Errors
    /// [`Failed`] for an `end` that is not positive, a channel that the model does not have, or a run of more
    /// than 2²⁶ numbers, a state and a time for each sample; if the integration fails or the budget is spent,
    /// with the states before the failure.
    pub fn run<G: Shape>(
        &self,
        solver: &dyn Integrator,
        model: &VaryingSpeed<G>,
        start: &State,
        end: f64,
        channel: &str,
    ) -> Result<Vec<WaterfallLine>, Failed> {
        check::positive("end of the run", end)?;
        let law = model.rule().law();
        let step = TAU / self.samples as f64;
        // A whole number of turns may be rounded down.
        let count = (law.angle(end) / step + 1e-9).floor() as usize;
        self.lines(solver, model, law, (start, count), channel)
    }

    /// The lines of a run over `count` samples.
    fn lines(
        &self,
        solver: &dyn Integrator,
        model: &dyn Model,
        law: &SpeedLaw,
        (start, count): (&State, usize),
        channel: &str,
    ) -> Result<Vec<WaterfallLine>, Failed> {
        let step = TAU / self.samples as f64;
        let window = self.turns * self.samples;
        // An unknown channel is reported before the run.
        Probe::new(model).index(channel)?;
        let count = count / window * window;
        check::count(
            "numbers of the run, a state and a time for each sample",
            &[count, 2 * model.dof() + 1],
            check::NUMBERS,
        )?;
        let times: Vec<f64> = (0..count).map(|k| law.time(k as f64 * step)).collect();
        let run = sample(solver, model, start, &times, Some(&self.budget.begin()))?;
        let values = run.channel(model, channel)?;
        times
            .chunks_exact(window)
            .zip(values.chunks_exact(window))
            .map(|(times, values)| {
                let spectrum = Spectrum::new(values, 1.0 / self.samples as f64, Window::Hann)?;
                let (first, last) = (times[0], times[window - 1]);
                let speed = (window - 1) as f64 * step / (last - first);
                let orders = spectrum.orders(1.0)?;
                Ok(WaterfallLine {
                    t: 0.5 * (first + last),
                    speed,
                    orders,
                    amplitudes: spectrum.amplitudes().to_vec(),
                })
            })
            .collect()
    }
}
