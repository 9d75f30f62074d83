//! Engine with located edges: every run by an integrator.

use crate::analysis::{Rattle, Statistics};
use crate::model::{Periodic, State};
use crate::ode::{Integrator, Step};
use crate::sweep::engines::periods::{RunOfPeriods, each_job, run};
use crate::sweep::engines::sweep_engine::{Source, SweepEngine};
use crate::sweep::engines::track::Plan;
use crate::sweep::sweep_error::{PointError, SweepError};
use std::ops::ControlFlow;

/// Engine for any periodic model: the runs are made by an [`Integrator`]. Edges are located, extremes are
/// found inside the steps, and the tolerance of the integrator controls the error.
///
/// ```
/// use gear_dynamics::{sweep::{Axis, Located}, Dop853, NfgPair, NfgParams, Sweep};
/// let sweep = Sweep::new(Axis::of_values("speed", &[100.0])?).settle(2).measure(1);
/// let rows = sweep.channels(&["q0"]).of(
///     &Located(Dop853::new().rtol(1e-8).atol(1e-13)),
///     |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
/// ).run()?;
/// assert_eq!(rows.get(0)?.period_multiple(), Some(1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "an engine runs in a sweep"]
pub struct Located<I>(pub I);

impl<I: Integrator + Sync, M: Periodic> SweepEngine<M> for Located<I> {
    fn accepts(&self, _: &M, _: &[usize]) -> Result<(), SweepError> {
        Ok(())
    }
    fn finer(&self) -> Option<Self> {
        None
    }

    fn work(&self, plan: &Plan, channels: &[usize], source: &mut dyn Source<M>) {
        each_job(source, |job, cancelled| one(&self.0, plan, channels, (&job.model, &job.start), cancelled));
    }
}

/// The row and the last state of a run; `None` if cancelled.
fn one(
    integrator: &dyn Integrator,
    plan: &Plan,
    channels: &[usize],
    (model, start): (&dyn Periodic, &State),
    cancelled: &dyn Fn() -> bool,
) -> Result<RunOfPeriods, PointError> {
    let mut rattle = Rattle::new(model);
    let mut counted = rattle.contacts().to_vec();
    let mut rebounded = false;
    let mut by_integrator = integrator.runs(model);
    run((plan, &[]), model, start, cancelled, &mut |state, period| {
        let (end, measured, ranging) = (period.end(), period.is_measured(), period.wants_states());
        let mut look = |step: &mut Step<'_>| {
            let rebounds = step.crossings().iter().any(|crossing| crossing.rebounds);
            if std::mem::replace(&mut rebounded, rebounds) && ranging {
                period.see(&[step.q0(), step.v0()].concat());
            }
            if ranging {
                period.see(step.y1());
            }
            if cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let finish = if measured {
            let mut statistics = Statistics::of_channels(model, channels);
            let mut measures = (&mut statistics, &mut rattle);
            let finish = by_integrator(state, end, &mut (&mut look, &mut measures))?;
            if finish.stopped {
                return Ok(());
            }
            for i in 0..channels.len() {
                let summary =
                    statistics.summary_of(i).map_err(|_| PointError::Diverged { period: period.number() })?;
                period.add_channel(i, &summary);
            }
            for (i, counted) in counted.iter_mut().enumerate().take(plan.layout.contacts) {
                period.contact_since(i, rattle.contacts()[i], counted);
            }
            finish
        } else {
            by_integrator(state, end, &mut look)?
        };
        period.steps(finish.stats.steps);
        *state = finish.state;
        Ok(())
    })
}
