//! The engine with a fixed step for any periodic model: RK4 over a table of drives, one run at a time.

use crate::model::Periodic;
use crate::ode::IntegrateError;
use crate::sweep::engines::batch::{Batch, LaneRun, refuse};
use crate::sweep::engines::sweep_engine::{Job, Source, SweepEngine, kinds};
use crate::sweep::engines::track::Plan;
use crate::sweep::lanes::algebra::Plain;
use crate::sweep::lanes::compiled::Here;
use crate::sweep::lanes::drive_table::DriveTable;
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::sweep_error::SweepError;
use std::collections::VecDeque;

/// Engine for any periodic model: RK4 with a fixed number of steps per period, one run at a time over a table
/// of all drives of the model. Edges are treated as by [`LaneRk4`](crate::sweep::LaneRk4).
///
/// ```
/// use gear_dynamics::sweep::{Axis, TableRk4};
/// use gear_dynamics::{State, Sweep, model::from_fn};
/// // q'' + 3 q' + 2 q = f cos 2t
/// let swing = |f: f64| {
///     let swing = from_fn(1, move |t, q, v, a| a[0] = f * (2.0 * t).cos() - 3.0 * v[0] - 2.0 * q[0])?;
///     swing.with_period(std::f64::consts::PI)
/// };
/// let amplitudes = Axis::of_values("f", &[1.0, 4.0])?;
/// let rows = Sweep::new(amplitudes).settle(20).measure(1).channels(&["q0"]).of(
///     &TableRk4::new(64),
///     |p| swing(p["f"]),
/// )
/// .start(|_, _| State::at_rest(1))
/// .run()?;
/// // Closed form: q = f (3 sin 2t - cos 2t)/20, RMS = f √5/20.
/// assert!((rows.get(1)?.channel("q0")?.rms - 5f64.sqrt() / 5.0).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use = "an engine runs in a sweep"]
pub struct TableRk4 {
    steps: usize,
}

impl TableRk4 {
    /// An engine with this number of steps per period of the model.
    pub fn new(steps: usize) -> Self {
        TableRk4 { steps }
    }
    /// Steps per period of the model.
    pub fn steps(&self) -> usize {
        self.steps
    }
}

impl<M: Periodic> SweepEngine<M> for TableRk4 {
    fn accepts(&self, model: &M, channels: &[usize]) -> Result<(), SweepError> {
        DriveTable::check_size(self.steps, model.drives())?;
        kinds(model, channels).map(|_| ())
    }
    fn finer(&self) -> Option<Self> {
        Some(TableRk4 { steps: self.steps.saturating_mul(4) })
    }

    fn work(&self, plan: &Plan, channels: &[usize], source: &mut dyn Source<M>) {
        let mut waiting = VecDeque::new();
        while !source.is_cancelled() {
            let Some(Job { index, model, start }) = waiting.pop_front().or_else(|| source.next(None)) else {
                return;
            };
            let Ok(kinds) = kinds(&model, channels) else { return };
            let not_located = |contact| IntegrateError::StopNotLocated { contact };
            let admitted = model.offers().refuse_stops(not_located);
            if let Err(error) = admitted.and_then(|()| IntegrateError::of_start(&model, &start)) {
                waiting.extend(refuse(source, index, error.into()));
                continue;
            }
            match DriveTable::of_drives(&model, self.steps, &|| !source.is_cancelled()) {
                Err(error) => waiting.extend(refuse(source, index, error.into())),
                Ok(None) => return,
                Ok(Some(table)) => {
                    let never = |_: &Job<M>| false;
                    let set = InstructionSet::Baseline;
                    let run = LaneRun { index, start, period: model.period(), constants: Vec::new() };
                    let mut batch = Batch {
                        plan,
                        table: &table,
                        kinds: &kinds,
                        set,
                        shares: &never,
                        waiting: &mut waiting,
                        source,
                    };
                    batch.run_plain(&Here(Plain(model.itself().unwrap_or(&model))), &run);
                }
            }
        }
    }
}
