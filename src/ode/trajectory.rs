//! Recorded trajectories.

use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::export::ResultTable;
use crate::model::{Channel, Model, State};
use crate::ode::integrate_error::IntegrateError;
use crate::ode::outcome::{Finish, Stats};
use crate::ode::probe::Probe;
use thiserror::Error;

/// The states of a run, in order of time.
///
/// ```
/// use gear_dynamics::{Integrator, Rk4, State, model::from_fn};
/// let fall = from_fn(1, |_, _, _, a| a[0] = -2.0)?;
/// let run = Rk4::new(0.5).trajectory(&fall, &State::at_rest(1), 1.0)?;
/// assert_eq!(run.times(), [0.0, 0.5, 1.0]);
/// assert!((run.channel(&fall, "q0")?[2] + 1.0).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    dof: usize,
    /// Start time of the run. Channels there take the drives after a jump, at all other times those before
    /// it.
    start: f64,
    times: Vec<f64>,
    states: Vec<f64>,
    stats: Stats,
}

impl Trajectory {
    /// A trajectory without states, for a run from time `start`.
    pub(crate) fn empty(dof: usize, start: f64) -> Self {
        Trajectory { dof, start, times: Vec::new(), states: Vec::new(), stats: Stats::default() }
    }
    pub(crate) fn push_state(&mut self, state: &State) {
        self.times.push(state.t);
        self.states.extend_from_slice(&state.q);
        self.states.extend_from_slice(&state.v);
    }
    pub(crate) fn push(&mut self, t: f64, y: &[f64]) {
        self.times.push(t);
        self.states.extend_from_slice(y);
    }
    /// The trajectory with the counts of the finished run, or [`Failed`] with the error of the run.
    pub(crate) fn or_failed(mut self, run: Result<Finish, IntegrateError>) -> Result<Self, Failed> {
        match run {
            Ok(finish) => {
                self.stats = finish.stats;
                Ok(self)
            }
            Err(error) => Err(Failed { error, trajectory: Box::new(self) }),
        }
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        self.times.len()
    }
    /// Whether there are no states.
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }
    /// The times of all states.
    pub fn times(&self) -> &[f64] {
        &self.times
    }
    /// Coordinates at index `i`.
    ///
    /// # Panics
    /// If `i` is not below [`len`](Trajectory::len).
    pub fn q(&self, i: usize) -> &[f64] {
        &self.states[2 * self.dof * i..][..self.dof]
    }
    /// Velocities at index `i`.
    ///
    /// # Panics
    /// If `i` is not below [`len`](Trajectory::len).
    pub fn v(&self, i: usize) -> &[f64] {
        &self.states[2 * self.dof * i + self.dof..][..self.dof]
    }
    /// The state at index `i`.
    ///
    /// # Panics
    /// If `i` is not below [`len`](Trajectory::len).
    pub fn state(&self, i: usize) -> State {
        State::new(self.times[i], self.q(i), self.v(i))
    }
    /// The last state; `None` if there is none.
    pub fn last(&self) -> Option<State> {
        self.len().checked_sub(1).map(|i| self.state(i))
    }
    /// A named channel of the model over the whole run (see [`Probe`]). At a drive edge it has the value
    /// before the edge; at the start of the run, the value after it.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`], which lists the channels of the model. [`ParameterError::Length`]
    /// for a model with another number of coordinates.
    pub fn channel(&self, model: &dyn Model, name: &str) -> Result<Vec<f64>, ParameterError> {
        check::length("coordinates of the model", model.dof(), self.dof)?;
        let mut probe = Probe::new(model);
        let index = probe.index(name)?;
        Ok((0..self.len()).map(|i| self.read(&mut probe, i)[index]).collect())
    }
    /// The channels of the model at index `i`.
    fn read<'p>(&self, probe: &'p mut Probe<'_>, i: usize) -> &'p [f64] {
        let side = if self.times[i] == self.start { Side::After } else { Side::Before };
        probe.read(self.times[i], side, self.q(i), self.v(i))
    }
    /// A table of the times, in the column `t`, and of named channels of the model; without names, of all its
    /// channels. Its values are those of [`channel`](Trajectory::channel).
    ///
    /// # Errors
    /// As [`channel`](Trajectory::channel); [`ParameterError::Twice`] for two columns of one name.
    pub fn table(&self, model: &dyn Model, names: &[&str]) -> Result<ResultTable, ParameterError> {
        check::length("coordinates of the model", model.dof(), self.dof)?;
        let mut probe = Probe::new(model);
        let chosen = match names {
            [] => (0..probe.channels().len()).collect(),
            _ => probe.indices(names)?,
        };
        let mut columns = vec![Channel::new("t", "")];
        columns.extend(chosen.iter().map(|index| probe.channels()[*index].clone()));
        let mut table = ResultTable::new(columns)?;
        let mut row = vec![0.0; chosen.len() + 1];
        for i in 0..self.len() {
            let values = self.read(&mut probe, i);
            row[0] = self.times[i];
            row[1..].iter_mut().zip(&chosen).for_each(|(out, index)| *out = values[*index]);
            table.push(&row)?;
        }
        Ok(table)
    }
    /// Counts of the work done in the run; zeros if the run failed.
    pub fn stats(&self) -> Stats {
        self.stats
    }
}

/// A failed run: the error and the trajectory computed before it.
///
/// ```
/// use gear_dynamics::{ode::IntegrateError, Integrator, Rk4, State, model::from_fn};
/// let breaks = from_fn(1, |t, _, _, a| a[0] = if t < 0.6 { 1.0 } else { f64::NAN })?;
/// let failed = Rk4::new(0.25).trajectory(&breaks, &State::at_rest(1), 1.0).unwrap_err();
/// assert!(matches!(failed.error, IntegrateError::NotFinite { t: 0.5, .. }));
/// assert_eq!(failed.trajectory.times(), [0.0, 0.25, 0.5]);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{error} ({} states before the error are kept)", trajectory.len())]
#[non_exhaustive]
pub struct Failed {
    /// The reason of the failure.
    pub error: IntegrateError,
    /// The states computed before the failure.
    pub trajectory: Box<Trajectory>,
}

impl From<ParameterError> for Failed {
    /// A failure before the run: the trajectory is empty.
    fn from(error: ParameterError) -> Self {
        Failed { error: error.into(), trajectory: Box::new(Trajectory::empty(0, 0.0)) }
    }
}

/// t_i = t0 + i (t1 - t0)/count, i = 0 .. count - 1: `count` equally spaced times, without the end t1. Over a
/// period they are the samples of a [`Spectrum`](crate::analysis::Spectrum) with the spacing (t1 - t0)/count.
///
/// ```
/// assert_eq!(gear_dynamics::ode::uniform_times(1.0, 2.0, 4)?, [1.0, 1.25, 1.5, 1.75]);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
///
/// # Errors
/// If `count` is 0 or above 2²⁶; if `t0`, `t1` or t1 - t0 is not finite.
pub fn uniform_times(t0: f64, t1: f64, count: usize) -> Result<Vec<f64>, ParameterError> {
    check::at_least("steps of time", count, 1)?;
    check::count("steps of time", &[count], check::NUMBERS)?;
    check::all_finite("ends of the time", &[t0, t1])?;
    check::representable("distance from start to end of the time", t1 - t0, &[t0, t1])?;
    Ok((0..count).map(|i| t0 + (t1 - t0) * (i as f64 / count as f64)).collect())
}

/// Checks that output times are finite, do not decrease, and do not lie before `start`.
pub(crate) fn check_times(start: f64, times: &[f64]) -> Result<(), IntegrateError> {
    let mut last = start;
    for (index, &value) in times.iter().enumerate() {
        if !(value.is_finite() && value >= last) {
            return Err(IntegrateError::OutputTime { index, value, start });
        }
        last = value;
    }
    Ok(())
}
