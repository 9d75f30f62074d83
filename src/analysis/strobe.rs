//! Strobed states: a Poincaré section at a fixed phase of the drives.

use crate::error::check;
use crate::model::{Periodic, State};
use crate::ode::integrator::sample;
use crate::ode::{Budget, Failed, Integrator, Trajectory};

/// Strobed states of a run: the states at the times start + k T, k = 1 .. `count`, with the period T of the
/// drives.
///
/// ```
/// use gear_dynamics::{Dop853, NfgPair, NfgParams, analysis::Strobe};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let section = Strobe::new(3).run(&Dop853::new(), &pair, &pair.static_start()?)?;
/// assert_eq!(section.len(), 3);
/// assert!((section.q(2)[0] - section.q(1)[0]).abs() < 1e-9); // nearly periodic after two turns
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Strobe {
    count: usize,
    budget: Budget,
}

impl Strobe {
    /// `count` states, with the default [`Budget`].
    pub fn new(count: usize) -> Self {
        Strobe { count, budget: Budget::new() }
    }
    /// Limit on steps and time of a run. Default: the default [`Budget`].
    pub fn budget(self, budget: Budget) -> Self {
        Strobe { budget, ..self }
    }

    /// Integrates from `start` and keeps the strobed states.
    ///
    /// # Errors
    /// [`Failed`], which contains the states before the failure or the end of the budget. A count with
    /// count (2 dof + 1) > 2²⁶ or a period outside 1e-50 .. 1e50 fails before the run.
    pub fn run<I: Integrator, M: Periodic + ?Sized>(
        &self,
        integrator: &I,
        model: &M,
        start: &State,
    ) -> Result<Trajectory, Failed> {
        check::count("numbers of the states", &[self.count, 2 * model.dof() + 1], check::NUMBERS)?;
        let period = check::scale("period of the model", model.period())?;
        let times: Vec<f64> = (1..=self.count).map(|k| start.t + k as f64 * period).collect();
        sample(integrator, model, start, &times, Some(&self.budget.begin()))
    }
}
