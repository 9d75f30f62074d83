//! Engine with located edges: every run by an integrator.

use crate::analysis::{Rattle, Statistics};
use crate::model::{Periodic, State};
use crate::ode::{IntegrateError, Integrator, Step};
use crate::sweep::engines::sweep_engine::{Job, Source, SweepEngine};
use crate::sweep::engines::track::{Next, Plan, Track, WithModel};
use crate::sweep::lanes::flanks::ContactMeter;
use crate::sweep::lanes::meter::ChannelMeter;
use crate::sweep::sweep_error::{PointError, SweepError};
use std::collections::VecDeque;
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
pub struct Located<I>(pub I);

impl<I: Integrator + Sync, M: Periodic> SweepEngine<M> for Located<I> {
    fn accepts(&self, _: &M, _: &[usize]) -> Result<(), SweepError> {
        Ok(())
    }
    fn finer(&self) -> Option<Self> {
        None
    }

    fn work(&self, plan: &Plan, channels: &[usize], source: &mut dyn Source<M>) {
        let mut next = VecDeque::new();
        while !source.is_cancelled() {
            let Some(Job { index, model, start }) = next.pop_front().or_else(|| source.next(None)) else {
                return;
            };
            let cancelled = || source.is_cancelled();
            match one(&self.0, plan, channels, &model, &start, &cancelled) {
                Ok(None) => return,
                Ok(Some((row, state))) => {
                    source.put(index, Ok((row, &state)));
                    next.extend(source.next(Some((index, &state))));
                }
                Err(error) => {
                    source.put(index, Err(error));
                    next.extend(source.next(Some((index, &[]))));
                }
            }
        }
    }
}

type RowAndState = Option<(Vec<f64>, Vec<f64>)>;

/// The row and the last state of a run; `None` if cancelled.
fn one(
    integrator: &dyn Integrator,
    plan: &Plan,
    channels: &[usize],
    model: &dyn Periodic,
    start: &State,
    cancelled: &dyn Fn() -> bool,
) -> Result<RowAndState, PointError> {
    let mut track = Track::new(plan, &start.q, &start.v);
    let mut rattle = Rattle::new(model);
    let mut counted = rattle.contacts().to_vec();
    let mut state = start.clone();
    let period = model.period();
    let mut rebounded = false;
    let with_model: &WithModel<'_> = &|read| read(model);
    let mut run = integrator.runs(model);
    loop {
        let end = start.t + (track.periods + 1) as f64 * period;
        let (measuring, ranging) = (track.measuring(), track.ranging());
        let mut look = |step: &mut Step<'_>| {
            let rebounds = step.crossings().iter().any(|crossing| crossing.rebounds);
            if std::mem::replace(&mut rebounded, rebounds) && ranging {
                track.see_state(step.q0().iter().chain(step.v0()).copied());
            }
            if ranging {
                track.see_state(step.y1().iter().copied());
            }
            if cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let finish = if measuring {
            let mut statistics = Statistics::of_channels(model, channels);
            let mut measures = (&mut statistics, &mut rattle);
            let finish = run(&state, end, &mut (&mut look, &mut measures))?;
            if finish.stopped {
                return Ok(None);
            }
            for i in 0..channels.len() {
                let x = statistics
                    .summary_of(i)
                    .map_err(|_| PointError::Diverged { period: track.periods + 1 })?;
                track.add_channel(i, &ChannelMeter::of(&x, period), period);
            }
            for (i, counted) in counted.iter_mut().enumerate().take(plan.layout.contacts) {
                let (meter, time) = ContactMeter::since(rattle.contacts()[i], counted);
                track.add_contact(i, &meter, time);
            }
            finish
        } else {
            run(&state, end, &mut look)?
        };
        if finish.stopped {
            return Ok(None);
        }
        let steps = finish.stats.steps;
        state = finish.state;
        match track.period(steps, period, state.q.iter().chain(&state.v).copied(), with_model) {
            Next::Done => return Ok(Some(track.finish(with_model))),
            Next::Diverged => return Err(IntegrateError::NotFinite { t: state.t, component: 0 }.into()),
            _ => {}
        }
    }
}
