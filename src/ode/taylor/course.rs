//! A run of Taylor series, from the start of a step to the start of the next one.

use crate::model::{Model, State};
use crate::ode::edges::exit::{Elapsed, Found};
use crate::ode::edges::passage::Passage;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::stepping::control::RESOLUTION;
use crate::ode::stepping::ends::Ends;
use crate::ode::stepping::vector_blocks::Blocks;

/// The ends of the current step and the passage over its edges: all of a run but its series.
pub(crate) struct Course<'m> {
    /// State, contacts and drives at both ends of the step.
    pub(crate) e: Ends<'m, dyn Model + 'm, Blocks>,
    pub(crate) passage: Passage,
}

impl<'m> Course<'m> {
    /// # Errors
    /// Those of [`Passage::begin`].
    pub(crate) fn begin(
        model: &'m (dyn Model + 'm),
        start: &State,
        t_end: f64,
    ) -> Result<Self, IntegrateError> {
        let mut e = Ends::<dyn Model, Blocks>::new(model, start, 1, 1);
        let passage = Passage::begin(&mut e, t_end, true)?;
        Ok(Course { e, passage })
    }

    /// The shortest step in which a series of limited validity counts: the last digits of the time are kept
    /// at drive edges and at the end of the run.
    pub(crate) fn shortest(&self) -> f64 {
        2.0 * RESOLUTION * self.e.t.abs()
    }

    /// End and length of a step of at most the length `reach`.
    ///
    /// # Errors
    /// [`IntegrateError::StepUnderflow`].
    pub(crate) fn aim(&self, reach: f64) -> Result<[f64; 2], IntegrateError> {
        let (t, stop) = (self.e.t, self.passage.stop);
        let aim = if t + reach * (1.0 + 1e-10) >= stop { stop } else { t + reach };
        let h = aim - t;
        if aim < stop && h <= RESOLUTION * t.abs() {
            return Err(IntegrateError::StepUnderflow { t, h });
        }
        Ok([aim, h])
    }

    /// Ends the step at its exit, or at its aim without one. Returns its length; `None` if a contact changed
    /// its piece at the start: the step must be repeated.
    ///
    /// # Errors
    /// Those of [`Passage::leave`].
    pub(crate) fn meet(
        &mut self,
        found: Found<Elapsed>,
        [aim, h]: [f64; 2],
    ) -> Result<Option<f64>, IntegrateError> {
        let t = self.e.t;
        match found {
            Found::Nothing => {
                self.e.aim(aim);
                Ok(Some(h))
            }
            Found::AtOnce(exit) => {
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

    /// Takes the crossings at the end of the step. Returns whether it is a drive edge.
    ///
    /// # Errors
    /// Those of [`Passage::cross`].
    pub(crate) fn cross(&mut self, found: Found<Elapsed>) -> Result<bool, IntegrateError> {
        if let Found::At(_, exit) = found {
            self.e.drive_end();
            self.e.contacts_at_end();
            self.passage.cross(&mut self.e, exit)?;
        }
        self.passage.stats.steps += 1;
        Ok(self.passage.is_drive_edge(self.e.t1))
    }

    /// Prepares the next step: velocities after impacts, pieces, drive edges. Returns the longest next step
    /// and whether pieces may have changed.
    ///
    /// # Errors
    /// Those of [`Passage::pass`].
    pub(crate) fn pass(&mut self, at_edge: bool) -> Result<(f64, bool), IntegrateError> {
        let Course { e, passage } = self;
        e.move_on();
        passage.locator.still.fill(0);
        if passage.crossings.is_empty() && !at_edge {
            return Ok((f64::INFINITY, false));
        }
        if !passage.crossings.is_empty() {
            passage.locator.accept(e);
        }
        Ok((passage.pass::<_, _, true>(e, at_edge)?, true))
    }
}
