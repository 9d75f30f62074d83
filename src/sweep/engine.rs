//! The engines: how the runs of a sweep are made.

use super::error::{PointError, SweepError};
use super::track::Plan;
use crate::channel::Probe;
use crate::lanes::Kind;
use crate::model::{Model, State};

/// Makes the runs of a sweep. There are three: [`LaneRk4`](crate::LaneRk4), [`TableRk4`](crate::TableRk4) and
/// [`Located`](crate::Located).
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot run `{M}`",
    note = "every engine asks for a model with a period (`impl Periodic`), lanes for one whose algebra is `Generic` besides: `TableRk4` and \
            `Located` run any periodic model; a model with held random drives has no period: run it in an `Ensemble`"
)]
pub trait SweepEngine<M: Model>: Sync {
    /// Makes runs until the source has no more.
    fn work(&self, plan: &Plan, channels: &[usize], source: &mut dyn Source<M>);
    /// Whether it measures these channels, by their place among those of the first model.
    ///
    /// # Errors
    /// [`SweepError::Channel`], [`SweepError::Setting`].
    fn accepts(&self, model: &M, channels: &[usize]) -> Result<(), SweepError>;
    /// The same with a quarter of the step, for the error estimate; `None` where the engine controls its error itself.
    fn finer(&self) -> Option<Self>
    where
        Self: Sized;
    /// How many runs it makes best at once.
    fn batch(&self) -> usize {
        1
    }
}

/// Runs to be made, and where their rows go.
pub trait Source<M> {
    /// The next run: the one that goes on from the state at which point `after` ended, or any other. `None` when there are no more.
    fn next(&mut self, after: Option<(usize, &[f64])>) -> Option<Job<M>>;
    /// Takes what a run gave: its row and the state in which it ended, coordinates then velocities.
    fn put(&mut self, index: usize, run: Result<(Vec<f64>, &[f64]), PointError>);
    /// Whether to leave all as it is and return.
    fn is_cancelled(&self) -> bool;
    /// Counts points that ran alone.
    fn alone(&mut self, points: usize);
}

/// One run to make.
pub struct Job<M> {
    /// The place of its point in the sweep.
    pub index: usize,
    /// Its model.
    pub model: M,
    /// Where it starts.
    pub start: State,
}

/// The channels that tables measure, by their place among those of a [`Probe`].
pub(crate) fn kinds<M: Model + ?Sized>(model: &M, channels: &[usize]) -> Result<Vec<Kind>, SweepError> {
    let (n, contacts) = (model.dof(), model.contacts());
    let kind = |&channel: &usize| {
        let of_contact = channel.saturating_sub(2 * n);
        match channel {
            c if c < n => Ok(Kind::Coordinate(c)),
            c if c < 2 * n => Ok(Kind::Velocity(c - n)),
            _ if of_contact < 3 * contacts && of_contact % 3 == 0 => Ok(Kind::Deflection(of_contact / 3)),
            _ if of_contact < 3 * contacts && of_contact % 3 == 1 => Ok(Kind::Force(of_contact / 3)),
            _ => Err(SweepError::Channel { name: Probe::new(model).channels().get(channel).map_or_else(String::new, |c| c.name.clone()) }),
        }
    };
    channels.iter().map(kind).collect()
}
