//! The solver of equations with white noise: its steps, its sources of noise, its random numbers.

use crate::error::{ParameterError, check};
use crate::linear::statics::default_start;
use crate::model::structure::gaps::negative_gap;
use crate::model::{Machine, Model, Periodic, Shape, State};
use crate::random::white::error::NoiseError;
use crate::random::white::noise::WhiteNoise;
use crate::random::white::noisy_lanes::{Gauge, Look, NoisyLanes};
use crate::sweep::lanes::drive_table::{DriveTable, TableError};
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::lanes::number::Lanes;
use crate::sweep::watch::Watch;
use std::ops::Range;

/// Solver for a [`Machine`] under white noise: fixed steps, W members side by side in the lanes of the vector
/// registers. Default: 16 lanes, seed 0.
///
/// Each step is half a step of the noise, a step of the classical Runge-Kutta method, and half a step of the
/// noise. Its weak order is 2: distributions, means and rates have an error proportional to h². Edges are
/// crossed without being located. A force with a kink keeps this order; with a force that jumps at the edge,
/// rates and speeds of impacts have order 1 ([white noise](crate::guide::random_white)). Drive edges must
/// fall on whole steps.
///
/// Random numbers are a pure function of (seed, member, number of the source, step). Results have the same
/// bits for any number of lanes and threads and any instruction set.
///
/// ```
/// use gear_dynamics::random::{NoisySteps, WhiteNoise};
/// use gear_dynamics::{models::Oscillator, State};
/// let free = Oscillator::new(&[("speed", 1.0), ("linear stiffness", 1.0)])?;
/// let solver = NoisySteps::new(40, &[WhiteNoise::bath(0, 0.5, 0.3)?]).seed(1);
/// let ends = solver.ends(&free, &State::at_rest(1), 5.0, 4000)?; // after 5 turns of the angle
/// let mean_square = ends.iter().map(|end| end.q[0] * end.q[0]).sum::<f64>() / 4000.0;
/// assert!((mean_square - 0.3).abs() < 0.02); // D/(2 c k) = 0.3, standard error 0.3 √(2/4000)
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct NoisySteps<const W: usize = 16> {
    steps: usize,
    noise: Vec<WhiteNoise>,
    seed: u64,
    set: InstructionSet,
}

/// Maximum number of steps of a run, 2⁵⁰: the time of a step is exact in units of steps.
pub(crate) const MAX_STEPS: f64 = (1u64 << 50) as f64;

/// Steps between two checks for cancellation and for states that are not finite.
pub(crate) const STEPS_UNCHECKED: u64 = 4096;

impl NoisySteps {
    /// A solver with this number of steps in a period of the model, and these sources of noise, independent
    /// of one another.
    pub fn new(steps: usize, noise: &[WhiteNoise]) -> Self {
        NoisySteps { steps, noise: noise.to_vec(), seed: 0, set: InstructionSet::Best }
    }
}

impl<const W: usize> NoisySteps<W> {
    /// The same solver with another number of lanes.
    pub fn lanes<const OTHER: usize>(self) -> NoisySteps<OTHER> {
        NoisySteps { steps: self.steps, noise: self.noise, seed: self.seed, set: self.set }
    }
    /// The instruction set. Default: [`InstructionSet::Best`].
    pub fn instructions(self, set: InstructionSet) -> Self {
        NoisySteps { set, ..self }
    }
    /// The seed, for an independent experiment. Default: 0.
    pub fn seed(self, seed: u64) -> Self {
        NoisySteps { seed, ..self }
    }
    /// Steps per period of the model.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// The states of members 0 .. `members` after a time of `periods` periods (rounded to whole steps) from
    /// one start at time 0.
    ///
    /// # Errors
    /// [`NoiseError`].
    pub fn ends<'s, G: Shape>(
        &self,
        machine: &Machine<G>,
        start: impl Into<Option<&'s State>>,
        periods: f64,
        members: usize,
    ) -> Result<Vec<State>, NoiseError> {
        check::at_least("members", members, 1)?;
        check::count("members × coordinates", &[members, machine.size().dof], check::NUMBERS)?;
        let ready = self.ready(machine, start.into())?;
        let steps = ready.steps_in(periods)?;
        let group = |here: Range<usize>| {
            let group = (here.start / W) as u64;
            let mut lanes = ready.lanes(group);
            ready.advance(&mut lanes, group, steps, &mut Blind, members as u64, &|| true)?;
            let values = |x: &[Lanes<W>], lane: usize| x.iter().map(|x| x.0[lane]).collect();
            let t = steps as f64 * ready.h;
            let state = |lane: usize| State { t, q: values(&lanes.q, lane), v: values(&lanes.v, lane) };
            Ok::<_, NoiseError>(Some((0..here.len()).map(state).collect::<Vec<State>>()))
        };
        let groups = Watch::default().begin(0, members).blocks(0..members, W, group)?;
        Ok(groups.into_iter().flatten().collect())
    }

    /// Checks the model and the start, and computes the table.
    pub(crate) fn ready<'m, G: Shape>(
        &'m self,
        machine: &'m Machine<G>,
        start: Option<&State>,
    ) -> Result<Ready<'m, G, W>, NoiseError> {
        machine.offers().refuse_stops(|contact| NoiseError::StopNotLocated { contact })?;
        let noise = self.noise.iter().map(|noise| Ok((noise.clone(), noise.check(machine)?)));
        let noise = noise.collect::<Result<Vec<_>, ParameterError>>()?;
        let start = match start {
            Some(start) => start.clone(),
            None => default_start(machine)?,
        };
        start.check_at_zero(machine.size().dof)?;
        if let Some((contact, [lower, upper])) = negative_gap(machine, &start) {
            return Err(NoiseError::NegativeGap { contact, lower, upper });
        }
        let table = DriveTable::of_waves(&**machine, self.steps, &|| true)?;
        let table = table.ok_or(TableError::Size { steps: self.steps, drives: machine.size().waves })?;
        let h = machine.period() / self.steps as f64;
        for (noise, _) in &noise {
            check::representable("noise in a step", noise.intensity * h, &[noise.intensity, h])?;
        }
        Ok(Ready { machine, table, noise, start, h, seed: self.seed, set: self.set })
    }
}

/// A model that was checked, with its table.
pub(crate) struct Ready<'m, G, const W: usize> {
    pub(crate) machine: &'m Machine<G>,
    pub(crate) table: DriveTable,
    noise: Vec<(WhiteNoise, bool)>,
    pub(crate) start: State,
    pub(crate) h: f64,
    pub(crate) seed: u64,
    pub(crate) set: InstructionSet,
}

impl<G: Shape, const W: usize> Ready<'_, G, W> {
    /// A number of periods in steps, at least 1.
    pub(crate) fn steps_in(&self, periods: f64) -> Result<u64, ParameterError> {
        check::above_zero("number of periods", periods)?;
        let steps = (periods * self.table.steps() as f64).round().max(1.0);
        if steps > MAX_STEPS {
            let value = usize::try_from(steps as u64).unwrap_or(usize::MAX);
            return Err(ParameterError::TooMany {
                name: "steps of a run".into(),
                value,
                max: MAX_STEPS as usize,
            });
        }
        Ok(steps as u64)
    }

    /// Empty lanes.
    pub(crate) fn empty(&self) -> NoisyLanes<'_, G, W> {
        NoisyLanes::new(self.machine, &self.table, &self.noise, self.h, self.seed)
    }

    /// The members of a group, W in each, at the start.
    pub(crate) fn lanes(&self, group: u64) -> NoisyLanes<'_, G, W> {
        let mut lanes = self.empty();
        for lane in 0..W {
            lanes.load(lane, group * W as u64 + lane as u64, 0, &self.start.q, &self.start.v);
        }
        lanes
    }

    /// Makes steps in all lanes of a group. Returns `false` if cancelled.
    ///
    /// # Errors
    /// [`NoiseError::Diverged`] for a member below `members`.
    pub(crate) fn advance<T: Gauge<G, W>>(
        &self,
        lanes: &mut NoisyLanes<'_, G, W>,
        group: u64,
        steps: u64,
        gauge: &mut T,
        members: u64,
        go_on: &dyn Fn() -> bool,
    ) -> Result<bool, NoiseError> {
        let mut done = 0;
        while done < steps {
            if !go_on() {
                return Ok(false);
            }
            let stretch = STEPS_UNCHECKED.min(steps - done);
            lanes.run(stretch, self.set, gauge);
            done += stretch;
            let first = group * W as u64;
            let here = W.min((members - first) as usize);
            if let Some(lane) = (0..here).find(|&lane| !lanes.is_finite(lane)) {
                let t = lanes.number[lane] as f64 * self.h;
                return Err(NoiseError::Diverged { member: first + lane as u64, t });
            }
        }
        Ok(true)
    }
}

/// Measures nothing.
pub(crate) struct Blind;

impl<G: Shape, const W: usize> Gauge<G, W> for Blind {
    #[inline(always)]
    fn look(&mut self, _: &Look<'_, G, W>) -> bool {
        true
    }
}
