//! A run of Taylor series, from the start of a step to the start of the next one.

use crate::model::{Model, State};
use crate::ode::edges::exit::{Elapsed, Found};
use crate::ode::edges::passage::Passage;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::stepping::control::{RESOLUTION, shortest};
use crate::ode::stepping::ends::Ends;
use crate::ode::stepping::vector_blocks::Blocks;
use crate::ode::taylor::distances::{Distances, first_exit};
use crate::series::Series;

/// A step this much shorter than one before indicates a singular point `[1]`.
pub(crate) const COLLAPSE: f64 = 1e-6;

/// A step this much longer than the one before is checked `[1]`.
const GROWN: f64 = 1.5;

/// The ends and the lengths of steps and the passage over their edges: all of a run but its series.
pub(crate) struct Course<'m> {
    /// State, contacts and drives at both ends of the step.
    pub(crate) e: Ends<'m, Blocks>,
    pub(crate) passage: Passage,
    /// The time after the start of the step up to which the series of the drives are valid.
    pub(crate) valid: f64,
    /// Length that the tolerances allowed for the last step; 0 before the first.
    pub(crate) last: f64,
    /// Largest finite one of these lengths.
    longest: f64,
    /// Limit of the next step alone, after an impact.
    limit: f64,
    /// Whether the step is the first of the run or the first after a crossing.
    begins: bool,
    /// End and length of the step if no contact leaves its piece.
    aim: [f64; 2],
    /// The first exit in the step.
    found: Found<Elapsed>,
    /// Whether the step serves to report an impact at its start.
    strikes: bool,
}

/// The time up to which the series of the given drives are valid. `drives`: their indices, with columns.
///
/// # Errors
/// [`IntegrateError::DriveWithoutSeries`].
pub(crate) fn valid_until(series: &[Series], drives: &[(usize, usize)]) -> Result<f64, IntegrateError> {
    drives.iter().try_fold(f64::INFINITY, |valid: f64, &(drive, _)| match series[drive].refusal() {
        Some(what) => Err(IntegrateError::DriveWithoutSeries { drive, what }),
        None => Ok(valid.min(series[drive].until())),
    })
}

/// Whether a function in one of the given drives varies, so that a later part of a step may be hidden.
pub(crate) fn are_steep(series: &[Series], drives: &[(usize, usize)]) -> bool {
    drives.iter().any(|&(drive, _)| series[drive].steepness() > 0.0)
}

impl<'m> Course<'m> {
    /// # Errors
    /// Those of [`Passage::begin`].
    pub(crate) fn begin(
        model: &'m (dyn Model + 'm),
        start: &State,
        t_end: f64,
    ) -> Result<Self, IntegrateError> {
        let mut e = Ends::<Blocks>::new(model, start, 1, 1);
        let passage = Passage::begin(&mut e, t_end, true)?;
        Ok(Course {
            e,
            passage,
            valid: f64::INFINITY,
            last: 0.0,
            longest: 0.0,
            limit: f64::INFINITY,
            begins: true,
            aim: [0.0; 2],
            found: Found::Nothing,
            strikes: false,
        })
    }

    /// Starts again from an earlier state.
    ///
    /// # Errors
    /// Those of [`Passage::begin`].
    pub(crate) fn go_back(&mut self, to: &State, t_end: f64) -> Result<(), IntegrateError> {
        let sliding = std::mem::take(&mut self.passage.sliding);
        *self = Course { longest: self.longest, ..Course::begin(self.e.model, to, t_end)? };
        self.passage.sliding = sliding;
        Ok(())
    }

    /// Whether the time advances by a step of this length.
    pub(crate) fn advances(&self, h: f64) -> bool {
        h > RESOLUTION * self.e.t.abs()
    }
    /// Whether the last terms of the series, which allow a step of the length `full`, may miss others: the
    /// motion begins anew, or the step is much longer than the one before. From rest, the series of a power
    /// of the motion has terms of some orders only.
    pub(crate) fn may_miss(&self, full: f64) -> bool {
        self.begins || full > GROWN * self.last
    }
    /// Whether steps have become so short that the motion tends to a singular point.
    pub(crate) fn has_shrunk(&self, h: f64) -> bool {
        h < COLLAPSE * self.longest
    }

    /// Aims at the end of a step for which the tolerances allow the length `full` and the settings the length
    /// `longest`. Returns its length.
    ///
    /// # Errors
    /// [`IntegrateError::StepUnderflow`].
    pub(crate) fn aim(&mut self, full: f64, longest: f64) -> Result<f64, IntegrateError> {
        let (t, stop) = (self.e.t, self.passage.stop);
        // The last digits of the time are kept at drive edges and at the end of the run.
        let valid = self.valid.max(2.0 * RESOLUTION * t.abs());
        let reach = full.min(self.limit).min(longest).min(valid);
        let aim = if t + reach * (1.0 + 1e-10) >= stop { stop } else { t + reach };
        let h = aim - t;
        if aim < stop && h <= RESOLUTION * t.abs() {
            return Err(self.e.underflow(h));
        }
        self.passage.crossings.clear();
        self.aim = [aim, h];
        Ok(h)
    }

    /// Ends the step at its first exit, or at its aim without one. Returns its length; `None` if a contact
    /// changed its piece at the start: the step must be repeated. `moves`: as in [`first_exit`].
    ///
    /// # Errors
    /// Those of [`first_exit`] and [`Passage::leave`].
    pub(crate) fn meet(
        &mut self,
        distances: &impl Distances,
        moves: impl Fn(usize) -> [f64; 2],
    ) -> Result<Option<f64>, IntegrateError> {
        let (t, [aim, h]) = (self.e.t, self.aim);
        self.found = first_exit(distances, &mut self.e, &mut self.passage.locator, moves, h)?;
        match self.found {
            Found::Nothing => {
                self.e.aim(aim);
                Ok(Some(h))
            }
            Found::AtOnce(exit) => {
                if let Some(late) = self.passage.locator.crosses_late(&mut self.e, exit) {
                    self.e.aim(self.passage.stop.min(t + late.after + shortest(t, h)));
                    self.strikes = late.strikes;
                    self.found = Found::At(Elapsed(self.e.h()), exit);
                    return Ok(Some(self.e.h()));
                }
                self.passage.leave(&mut self.e, exit)?;
                self.passage.stats.rejected += 1;
                Ok(None)
            }
            Found::At(Elapsed(root), _) => {
                self.e.aim(if root < h { t + root } else { aim });
                Ok(Some(root))
            }
        }
    }

    /// Ends the step already after the time `h`, before its first exit.
    pub(crate) fn shorten(&mut self, h: f64) {
        (self.found, self.strikes) = (Found::Nothing, false);
        self.e.aim(self.e.t + h);
        self.passage.stats.rejected += 1;
    }

    /// Takes the crossings at the end of the step. `full`: the length that the tolerances allowed. Returns
    /// whether the end is a drive edge.
    ///
    /// # Errors
    /// Those of [`Passage::cross`].
    pub(crate) fn cross(&mut self, full: f64) -> Result<bool, IntegrateError> {
        if std::mem::take(&mut self.strikes) {
            self.e.stand_still();
        }
        if let Found::At(_, exit) = self.found {
            self.e.drive_end();
            self.e.contacts_at_end();
            self.passage.cross(&mut self.e, exit)?;
        }
        self.passage.stats.steps += 1;
        self.last = full;
        if full.is_finite() {
            self.longest = self.longest.max(full);
        }
        Ok(self.passage.is_drive_edge(self.e.t1))
    }

    /// Prepares the next step: velocities after impacts, pieces, drive edges. Returns whether pieces may have
    /// changed.
    ///
    /// # Errors
    /// Those of [`Passage::pass`].
    pub(crate) fn pass(&mut self, at_edge: bool) -> Result<bool, IntegrateError> {
        let Course { e, passage, .. } = self;
        e.move_on();
        passage.locator.advance();
        self.limit = f64::INFINITY;
        self.begins = !passage.crossings.is_empty();
        if passage.crossings.is_empty() && !at_edge {
            return Ok(false);
        }
        if !passage.crossings.is_empty() {
            passage.locator.accept(e);
        }
        self.limit = passage.pass::<_, true>(e, at_edge)?;
        Ok(true)
    }
}
