//! The engines: how the runs of a sweep are made.

use crate::model::equations::{Model, State};
use crate::ode::probe::Probe;
use crate::sweep::engines::track::Plan;
use crate::sweep::error::{PointError, SweepError};
use crate::sweep::lanes::meter::Kind;

/// Makes the runs of a sweep. There are three, and no others can be written: [`LaneRk4`](crate::sweep::LaneRk4), [`TableRk4`](crate::sweep::TableRk4) and
/// [`Located`](crate::sweep::Located).
///
/// ```
/// use gear_dynamics::{Dop853, NfgPair, NfgParams, Sweep};
/// use gear_dynamics::sweep::{Axis, LaneRk4, Located, Points, SweepEngine};
/// fn mean(engine: &impl SweepEngine<NfgPair>) -> Result<f64, Box<dyn std::error::Error>> {
///     let rows = Sweep::over(Points::along(Axis::list("speed", &[100.0])?)).settle(2).measure(1).channels(&["q1"]).run(
///         engine,
///         |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
///         |_, pair| pair.static_start(),
///     )?;
///     Ok(rows.row(0).ok_or("cancelled")?.map_err(Clone::clone)?.channel("q1")?.mean)
/// }
/// let (lanes, located) = (mean(&LaneRk4::<4>::new(63 * 64))?, mean(&Located(Dop853::new().rtol(1e-8).atol(1e-13)))?);
/// assert!((lanes / located - 1.0).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot run `{M}`",
    note = "every engine asks for a model with a period (`impl Periodic`), lanes for a `Machine` made of a `Shape`: `TableRk4` and `Located` run \
            any periodic model; a model with held random drives has no period: run it in an `Ensemble`"
)]
pub trait SweepEngine<M: Model>: Sync {
    /// Makes runs until the source has no more.
    #[doc(hidden)]
    fn work(&self, plan: &Plan, channels: &[usize], source: &mut dyn Source<M>);
    /// Whether it measures these channels, by their place among those of the first model.
    ///
    /// # Errors
    /// [`SweepError::Channel`], [`SweepError::Table`].
    #[doc(hidden)]
    fn accepts(&self, model: &M, channels: &[usize]) -> Result<(), SweepError>;
    /// The same with a quarter of the step, for the error estimate; `None` where the engine controls its error itself.
    #[doc(hidden)]
    fn finer(&self) -> Option<Self>
    where
        Self: Sized;
    /// How many runs it makes best at once.
    #[doc(hidden)]
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
    /// The rigid modes of the model of a point.
    fn rigid(&self, index: usize) -> Vec<Vec<f64>>;
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
            _ => Err(SweepError::Channel {
                name: Probe::new(model).channels().get(channel).map_or_else(String::new, |c| c.name.clone()),
            }),
        }
    };
    channels.iter().map(kind).collect()
}
