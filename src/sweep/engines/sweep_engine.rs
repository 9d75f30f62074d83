//! The interface between a sweep and the engine that makes its runs.

use crate::model::{Model, Periodic, State};
use crate::ode::probe::{ChannelKind, Probe};
use crate::periodic::lyapunov::exponents::{Exponents, LyapunovError};
use crate::periodic::lyapunov::run::Lyapunov;
use crate::periodic::multipliers::Multipliers;
use crate::periodic::shooting::failure::ShootingError;
use crate::periodic::shooting::multiple::Shooting;
use crate::sweep::engines::track::Plan;
use crate::sweep::sweep_error::{PointError, SweepError};

/// An engine: makes the runs of a sweep. There are five: [`LaneRk4`](crate::sweep::LaneRk4),
/// [`LaneTaylor`](crate::sweep::LaneTaylor), [`TableRk4`](crate::sweep::TableRk4),
/// [`Located`](crate::sweep::Located), and [`ByPeriods`](crate::sweep::ByPeriods) for an engine of one's own.
/// Other crates cannot implement this trait.
///
/// ```
/// use gear_dynamics::{Dop853, NfgPair, NfgParams, Sweep};
/// use gear_dynamics::sweep::{Axis, LaneRk4, Located, bounds::SweepEngine};
/// fn mean(engine: &impl SweepEngine<NfgPair>) -> Result<f64, Box<dyn std::error::Error>> {
///     let sweep = Sweep::new(Axis::of_values("speed", &[100.0])?).settle(2).measure(1);
///     let rows = sweep.channels(&["q0"]).of(
///         engine,
///         |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
///     ).run()?;
///     Ok(rows.get(0)?.channel("q0")?.mean)
/// }
/// let (lanes, located) =
///     (mean(&LaneRk4::new(63 * 64))?, mean(&Located(Dop853::new().rtol(1e-8).atol(1e-13)))?);
/// assert!((lanes / located - 1.0).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot run `{M}`",
    note = "every engine needs a periodic model (`impl Periodic`); `LaneRk4` and `LaneTaylor` need a `Machine` \
            made of a `Shape`, `TableRk4` and `Located` run any periodic model; a model with a held process has no \
            period: run it in an `Ensemble`"
)]
pub trait SweepEngine<M: Model>: Sync {
    /// Makes runs until the source has no more jobs or is cancelled.
    #[doc(hidden)]
    fn work(&self, plan: &Plan, channels: &[usize], source: &mut dyn Source<M>);
    /// Checks that the engine can measure these channels, given by their index among those of the first
    /// model.
    ///
    /// # Errors
    /// [`SweepError::Channel`] for a channel that the engine does not measure; [`SweepError::Table`] for a
    /// table without steps or larger than the maximum.
    #[doc(hidden)]
    fn accepts(&self, model: &M, channels: &[usize]) -> Result<(), SweepError>;
    /// The engine with a quarter of the step or a hundredth of the tolerances, for the error estimate; `None`
    /// if the engine gives none.
    #[doc(hidden)]
    fn finer(&self) -> Option<Self>
    where
        Self: Sized;
    /// Number of runs that the engine makes side by side. Default: 1.
    #[doc(hidden)]
    fn batch(&self) -> usize {
        1
    }
    /// Computes the exponents of the motion from the start of each job. Default: one after the other.
    #[doc(hidden)]
    fn exponents(&self, lyapunov: &Lyapunov, jobs: &[Job<M>], go_on: &dyn Fn() -> bool) -> Vec<Exponent>
    where
        M: Periodic,
    {
        jobs.iter().map(|job| one_by_one(lyapunov, job, go_on)).collect()
    }
    /// Computes the multipliers of the orbit near the start of each job. Default: one after the other.
    #[doc(hidden)]
    fn multipliers(&self, shooting: &Shooting, jobs: &[OrbitJob<M>], go_on: &dyn Fn() -> bool) -> Vec<Orbit>
    where
        M: Periodic,
    {
        jobs.iter().map(|job| close_one(shooting, job, go_on)).collect()
    }
    /// Number of motions whose exponents or multipliers are computed together. Default: 1.
    #[doc(hidden)]
    fn exponents_at_once(&self) -> usize {
        1
    }
}

/// The exponents of a motion; `None` if cancelled.
pub type Exponent = Option<Result<Exponents, LyapunovError>>;

/// The exponents of one motion.
pub(crate) fn one_by_one<M: Periodic>(
    lyapunov: &Lyapunov,
    job: &Job<M>,
    go_on: &dyn Fn() -> bool,
) -> Exponent {
    let found = lyapunov.run_while(&job.model, &job.start, job.model.period(), go_on);
    go_on().then_some(found)
}

/// The multipliers of an orbit; `None` if cancelled.
pub type Orbit = Option<Result<Multipliers, ShootingError>>;

/// A run, and the period multiple of the motion in which it ended.
pub type OrbitJob<M> = (Job<M>, usize);

/// The multipliers of one orbit.
pub(crate) fn close_one<M: Periodic>(
    shooting: &Shooting,
    (job, multiple): &OrbitJob<M>,
    go_on: &dyn Fn() -> bool,
) -> Orbit {
    let shooting = shooting.clone().period_multiple(*multiple);
    let meter = shooting.meter(go_on);
    let found = shooting.find(&job.model, std::slice::from_ref(&job.start), &meter);
    go_on().then(|| found.map(|orbit| orbit.multipliers().clone()))
}

/// The source of jobs and the destination of their rows.
pub trait Source<M> {
    /// The next job. `after` is a point that is done and its last state, empty after an error: the next point
    /// of its line has precedence and may start from this state. `None` if no job is left or the sweep is
    /// cancelled.
    fn next(&mut self, after: Option<(usize, &[f64])>) -> Option<Job<M>>;
    /// Stores the result of a run: its row and its last state (coordinates, then velocities), or its error.
    fn put(&mut self, index: usize, run: Result<(Vec<f64>, &[f64]), PointError>);
    /// Calls `read` with the model of point `index`.
    fn with_model(&self, index: usize, read: &mut dyn FnMut(&dyn Periodic));
    /// Whether the sweep is cancelled: `work` then returns without further rows.
    fn is_cancelled(&self) -> bool;
    /// Adds to the number of points that ran alone, without other lanes.
    fn alone(&mut self, points: usize);
}

/// A run to make.
#[derive(Debug)]
pub struct Job<M> {
    /// Index of the point in the sweep.
    pub index: usize,
    /// The model.
    pub model: M,
    /// The start of the run.
    pub start: State,
}

/// The channels that all engines but [`Located`](crate::sweep::Located) measure: coordinates, velocities, and
/// deflection and force of each contact. `channels` are indices among the channels of a [`Probe`].
///
/// # Errors
/// [`SweepError::Channel`] for any other channel.
pub(crate) fn kinds(model: &dyn Model, channels: &[usize]) -> Result<Vec<ChannelKind>, SweepError> {
    let probe = Probe::new(model);
    let refuse = |channel: usize| SweepError::Channel {
        name: probe.channels().get(channel).map_or_else(String::new, |c| c.name.clone()),
    };
    channels.iter().map(|&channel| probe.kind(channel).ok_or_else(|| refuse(channel))).collect()
}
