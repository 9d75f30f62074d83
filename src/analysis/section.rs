//! Poincaré sections.

use super::GAUSS;
use crate::channel::Probe;
use crate::error::{ParameterError, check};
use crate::model::{Model, Periodic, State};
use crate::ode::{Failed, IntegrateError, Integrator, Observer, Step, Trajectory};
use crate::piece::Side;
use std::ops::ControlFlow;

/// The Poincaré section of the forcing: `count` states, one period of the drives apart, the first after one period.
///
/// ```
/// use gear_dynamics::{Dop853, NfgPair, NfgParams, strobe};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let section = strobe(&Dop853::new(), &pair, &pair.static_start()?, 3)?;
/// assert_eq!(section.len(), 3);
/// assert!((section.q(2)[0] - section.q(1)[0]).abs() < 1e-9); // nearly periodic after two turns
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`Failed`], with the part that succeeded; more states than 2²⁶ numbers hold are refused before the run.
pub fn strobe<I: Integrator, M: Periodic + ?Sized>(integrator: &I, model: &M, start: &State, count: usize) -> Result<Trajectory, Failed> {
    let width = 2 * model.dof() + 1;
    if check::count("states", &[count, width], check::NUMBERS).is_err() {
        let error =
            IntegrateError::Setting { name: "count", value: count as f64, allowed: "at most 2^26 numbers, a state and a time each" };
        return Err(Failed { error, trajectory: Box::new(Trajectory::empty(model.dof(), start.t)) });
    }
    let times: Vec<f64> = (1..=count).map(|k| start.t + k as f64 * model.period()).collect();
    integrator.sample(model, start, &times)
}

/// In which direction a section is crossed.
///
/// ```
/// assert_ne!(gear_dynamics::Direction::Rising, gear_dynamics::Direction::Falling);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From below the level.
    Rising,
    /// From above.
    Falling,
    /// Either.
    Both,
}

/// Observes a run and keeps the states at which a channel crosses a level, located on the dense output.
///
/// ```
/// use gear_dynamics::{Direction, Dop853, Integrator, Model, Section, State};
/// struct Spring;
/// impl Model for Spring {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) { a[0] = -q[0]; }
/// }
/// let mut section = Section::new(&Spring, "q1", 0.0, Direction::Rising)?;
/// Dop853::new().run(&Spring, &State::new(0.0, &[1.0], &[0.0]), 10.0, &mut section)?;
/// assert_eq!(section.states().len(), 1);
/// assert!((section.states()[0].t - 1.5 * std::f64::consts::PI).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Section<'m, M: ?Sized> {
    probe: Probe<'m, M>,
    channel: usize,
    level: f64,
    direction: Direction,
    states: Vec<State>,
    y: Vec<f64>,
}

impl<'m, M: Model + ?Sized> Section<'m, M> {
    /// Where `channel` crosses `level`.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`], and a level that is not finite.
    pub fn new(model: &'m M, channel: &str, level: f64, direction: Direction) -> Result<Self, ParameterError> {
        let probe = Probe::new(model);
        let channel = probe.index(channel)?;
        check::finite("level", level)?;
        Ok(Section { probe, channel, level, direction, states: Vec::new(), y: vec![0.0; 2 * model.dof()] })
    }

    /// The states found.
    pub fn states(&self) -> &[State] {
        &self.states
    }

    fn height(&mut self, step: &mut Step<'_>, t: f64) -> f64 {
        step.at(t, &mut self.y);
        let (q, v) = self.y.split_at(self.y.len() / 2);
        let side = if t == step.t1() { Side::Before } else { Side::After };
        self.probe.read(t, side, q, v)[self.channel] - self.level
    }
}

impl<M: Model + ?Sized> Observer for Section<'_, M> {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        // Looked at between seven points of the step, so that a level crossed up and down inside it is seen.
        let (t0, t1) = (step.t0(), step.t1());
        let inside = GAUSS.map(|[x, _]| 0.5 * (t0 + t1) + 0.5 * (t1 - t0) * x);
        let (mut from, mut a) = (t0, self.height(step, t0));
        for to in inside.into_iter().chain([t1]) {
            let b = self.height(step, to);
            let (rising, falling) = (a < 0.0 && b >= 0.0, a > 0.0 && b <= 0.0);
            let wanted = match self.direction {
                Direction::Rising => rising,
                Direction::Falling => falling,
                Direction::Both => rising || falling,
            };
            if wanted {
                let (mut lo, mut hi) = (from, to);
                loop {
                    let middle = 0.5 * (lo + hi);
                    if middle <= lo || middle >= hi {
                        break;
                    }
                    if (self.height(step, middle) < 0.0) == rising { lo = middle } else { hi = middle }
                }
                self.height(step, hi);
                let (q, v) = self.y.split_at(self.y.len() / 2);
                self.states.push(State::new(hi, q, v));
            }
            (from, a) = (to, b);
        }
        ControlFlow::Continue(())
    }
}
