//! Settling: integration until the state repeats.

use crate::analysis::alone::Alone;
use crate::analysis::changes::{contraction, distance, envelope, shrinks};
use crate::analysis::motion_size::MotionSize;
use crate::analysis::returns::is_own_multiple;
use crate::error::{ParameterError, check};
use crate::linear::LinearError;
use crate::linear::statics::default_start;
use crate::model::equations::early;
use crate::model::period::check_period;
use crate::model::structure::drifts::{Drifts, accelerates};
use crate::model::{Periodic, State};
use crate::ode::{Budget, Exhausted, IntegrateError, Integrator, Observer, Step};
use thiserror::Error;

/// Integrates until the state repeats: settling to a periodic orbit.
///
/// It also finds the smallest period multiple p of the orbit.
/// A start later than 64 periods begins at the same instant of the first period, whose time is not rounded
/// so coarsely.
///
/// The state repeats if max_i |y_i(t) - y_i(t - p T)|/range_i is at most the tolerance p + 1 times in a row,
/// with the coordinates and velocities y_i and the period T of the drives. range_i is max - min of y_i; with
/// each period the ranges so far are halved. Rigid motion is removed from the states and the ranges, and so
/// are places of which only the velocity acts, as the angle of a rotor that a drag holds.
/// Therefore connected bodies may turn and accelerate together. A coordinate that nothing connects to others
/// or to the ground must keep its mean velocity ([`SettleError::Accelerates`]).
///
/// Where the tolerance asks for less than the rounding errors of N steps, they replace it: max(64, 4 √N) of
/// the terms of which y_i is made, and for a velocity the same share of its range as for its coordinate. The
/// run then goes on while the change shrinks by at least a tenth a period, to `max_periods` at most: while
/// the largest of the last four changes is below 0.65 of the largest of the four before. A slower decay ends
/// where these rounding errors are reached, and [`Steady::error`] says how far from the orbit. A decay whose
/// changes rise and fall may end there, too: a motor with a gear pair ended at a change of 2e-8. Rounding
/// errors are those of the last p periods, on the flanks that the motion touches and in steps as short as
/// those that it takes there. A change above 1e-3 is not a rounding error: the motion is then not resolved.
///
/// The tolerance bounds this change, not the distance from the orbit: where a perturbation shrinks by the
/// factor μ in one period of the orbit, the distance is change μ/(1 - μ), for example 99 changes at μ = 0.99.
/// [`Steady::error`] estimates it.
///
/// ```
/// use gear_dynamics::{Dop853, NfgPair, NfgParams, Settle};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let steady = Settle::new().tolerance(1e-7).run(&Dop853::new(), &pair, None)?; // from the static state
/// assert_eq!(steady.period_multiple, 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct Settle {
    tolerance: f64,
    max_periods: usize,
    max_period_multiple: usize,
    budget: Budget,
}

impl Default for Settle {
    fn default() -> Self {
        Settle::new()
    }
}

impl Settle {
    /// Settling with the defaults: tolerance 1e-9, at most 200 periods, orbits of at most 8 periods, default
    /// [`Budget`].
    pub fn new() -> Self {
        Settle { tolerance: 1e-9, max_periods: 200, max_period_multiple: 8, budget: Budget::new() }
    }
    /// Largest difference of a repeated state, as a share of the range of each coordinate and velocity, above
    /// 0 and below 1. Default: 1e-9.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Settle { tolerance, ..self }
    }
    /// Maximum number of periods. Default: 200.
    pub fn max_periods(self, max_periods: usize) -> Self {
        Settle { max_periods, ..self }
    }
    /// Maximum period multiple of the orbit, 1 to 65536. Default: 8.
    pub fn max_period_multiple(self, max_period_multiple: usize) -> Self {
        Settle { max_period_multiple, ..self }
    }
    /// Limit on steps and time of one call of [`run`](Settle::run), for all periods together.
    pub fn budget(self, budget: Budget) -> Self {
        Settle { budget, ..self }
    }

    /// Integrates from `start` until the state repeats; from the [static state](crate::linear::static_state)
    /// if `start` is `None`.
    ///
    /// # Errors
    /// [`SettleError::NoStaticState`] if no start is given and the model has no static state.
    /// [`SettleError::Aperiodic`] if the state does not repeat within the maximum number of periods (chaos,
    /// quasi-periodicity or slow decay). [`SettleError::Accelerates`] if a coordinate that nothing connects
    /// gains velocity in every period. [`SettleError::Integrate`] if the integration fails,
    /// [`SettleError::Exhausted`] if the budget is spent. [`SettleError::Parameter`] if a setting is outside
    /// its range or the period of the model outside 1e-50 .. 1e50.
    pub fn run<'s>(
        &self,
        integrator: &dyn Integrator,
        model: &dyn Periodic,
        start: impl Into<Option<&'s State>>,
    ) -> Result<Steady, SettleError> {
        self.run_from(integrator, model, start.into())
    }

    fn run_from(
        &self,
        integrator: &dyn Integrator,
        model: &dyn Periodic,
        start: Option<&State>,
    ) -> Result<Steady, SettleError> {
        let mut start = match start {
            Some(start) => start.clone(),
            None => default_start(model)?,
        };
        let period = model.period();
        self.check(period)?;
        start.t = early(start.t, period);
        start.check(model.dof())?;
        check_period(model, &start)?;
        let joined = |state: &State| [&state.q[..], &state.v].concat();
        let mut section: Vec<Vec<f64>> = vec![joined(&start)];
        let (mut last, mut sizes) = (start.clone(), Vec::new());
        // Where all motions are rigid, no relative motion would be left: the state itself has to repeat.
        let drifts = Drifts::of(model, period);
        let mut motion = MotionSize::new(model.dof(), &drifts);
        let mut alone = Alone::new(&drifts.speeds);
        // Number of consecutive periods at which the state has repeated after p = 1, 2, ... periods.
        let mut repeated = vec![0; self.max_period_multiple];
        let mut distances = vec![f64::INFINITY; self.max_period_multiple];
        let mut closest = (f64::INFINITY, f64::INFINITY);
        let (meter, mut run) = (self.budget.begin(), integrator.runs(model));
        for k in 1..=self.max_periods {
            // Halving the ranges each period removes the influence of transients.
            motion.fade();
            alone.begin(&last);
            let mut parts = 0;
            let mut watch = |step: &mut Step<'_>| {
                let (from, to) = step.part(0);
                parts += step.parts();
                motion.see_step(step);
                motion.keep(step.pieces().unwrap_or_default(), to - from, step.t1(), step.q1(), step.v1());
                alone.see(step.v1());
                (&meter).step(step)
            };
            let finish = run(&last, start.t + k as f64 * period, &mut watch);
            let periods = k - 1;
            let state = match finish {
                Ok(finish) => finish.state,
                Err(IntegrateError::Exhausted { exhausted, .. }) => {
                    return Err(SettleError::Exhausted { exhausted, last, periods });
                }
                Err(error) => return Err(SettleError::Integrate { error, last, periods }),
            };
            if let Some(exhausted) = meter.exhausted() {
                return Err(SettleError::Exhausted { exhausted, last, periods });
            }
            last = state;
            motion.steps = parts;
            motion.weigh_kept(model, &last);
            sizes.push(motion.sizes().to_vec());
            section.push(joined(&last));
            for p in 1..=self.max_period_multiple.min(k) {
                // The rounding errors of the last p periods.
                motion.weigh(&sizes[k - p]);
                let apart = motion.distance(&section[k], &section[k - p], self.tolerance);
                distances[p - 1] = apart;
                if p == 1 || apart < closest.0 {
                    closest = (apart, motion.change(&section[k], &section[k - p]));
                }
                repeated[p - 1] = if apart <= self.tolerance && is_own_multiple(&distances[..p]) {
                    repeated[p - 1] + 1
                } else {
                    0
                };
                if repeated[p - 1] > p {
                    let change = |j: usize| motion.change(&section[k - j * p], &section[k - (j + 1) * p]);
                    let history: Vec<f64> = (0..k / p).map(change).collect();
                    let (change, contraction) = (history[0], contraction(&history));
                    let envelope = envelope(&history, contraction);
                    let is_resolved = change <= self.tolerance.max(RESOLVED);
                    let is_last = !shrinks(&history) || k == self.max_periods;
                    if change <= self.tolerance || is_resolved && is_last {
                        let distance = Some(distance(envelope, contraction)).filter(|d| d.is_finite());
                        let distance = distance.unwrap_or(change).max(self.tolerance);
                        if let Some((coordinate, gain)) =
                            alone.accelerates(&section[k], &section[k - p], distance)
                        {
                            return Err(SettleError::Accelerates { coordinate, gain, last, periods: k });
                        }
                        return Ok(Steady {
                            state: last,
                            period_multiple: p,
                            periods: k,
                            change,
                            contraction,
                            envelope,
                        });
                    }
                }
            }
        }
        if drifts.speeds.len() == model.dof()
            && let [.., before, now] = &section[..]
            && let Some((coordinate, gain)) = alone.accelerates(now, before, self.tolerance)
        {
            return Err(SettleError::Accelerates { coordinate, gain, last, periods: self.max_periods });
        }
        Err(SettleError::Aperiodic {
            last,
            periods: self.max_periods,
            closest: closest.1,
            multiple: self.max_period_multiple,
            tolerance: self.tolerance,
        })
    }

    fn check(&self, period: f64) -> Result<(), ParameterError> {
        check::share("tolerance", self.tolerance)?;
        check::at_least("max_periods", self.max_periods, 1)?;
        check::at_least("max_period_multiple", self.max_period_multiple, 1)?;
        check::count("max_period_multiple", &[self.max_period_multiple], LONGEST)?;
        check::scale("period of the model", period).map(drop)
    }
}

/// Largest difference of a repeated state that rounding errors explain, as a share of the ranges `[1]`. A
/// motion whose rounding errors are larger is not resolved.
const RESOLVED: f64 = 1e-3;

/// Largest allowed value of `max_period_multiple`.
const LONGEST: usize = 1 << 16;

/// The steady state that [`Settle`] found.
///
/// ```
/// use gear_dynamics::{Dop853, Settle, State, model::from_fn};
/// // q'' + q' + q = cos t, with the steady state q = sin t
/// let forced = from_fn(1, |t, q, v, a| a[0] = t.cos() - v[0] - q[0])?;
/// let forced = forced.with_period(std::f64::consts::TAU)?;
/// let steady = Settle::new().tolerance(1e-7).run(&Dop853::new(), &forced, &State::at_rest(1))?;
/// assert_eq!(steady.period_multiple, 1);
/// assert!(steady.state.q[0].abs() < 1e-5 && (steady.state.v[0] - 1.0).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Steady {
    /// A state on the orbit, a whole number of periods of the drives after the start.
    pub state: State,
    /// Period multiple: number of periods of the drives in one period of the orbit.
    pub period_multiple: usize,
    /// Number of periods of the drives that were integrated.
    pub periods: usize,
    /// Difference of the last repetition, as a share of the ranges. It exceeds the tolerance where rounding
    /// errors replace the tolerance.
    pub change: f64,
    /// The factor μ by which the difference shrank from one period of the orbit to the next `[1]`: from the
    /// largest of the last four to the largest of the four before, as a mean over four periods, or over the
    /// last eight between which it shrank. Differences that are made of rounding errors shrink and grow. The
    /// factor is at least the mean factor over the last 24 differences, because a transient that turns slowly
    /// from period to period shrinks faster in some periods. NaN where the state did not change at all.
    pub contraction: f64,
    /// The largest of the last four differences, each times its decay since.
    envelope: f64,
}

impl Steady {
    /// Estimate of the distance from the orbit, change μ/(1 - μ), as a share of the ranges `[1]`. The change
    /// is the largest of the last four, the jth before the last one times μ^j: of a transient that beats, the
    /// last one is small by chance. Where a transient turns from period to period (a complex multiplier λ),
    /// the distance is smaller by |1 - λ|/(1 - |λ|).
    ///
    /// The estimate is infinite if the differences did not shrink over any four periods: the motion does not
    /// settle. The errors of the solver are not in it. Nor is a slow mode that changes less in a period than
    /// a faster one: with rates of 0.5 and 1e-4, a motion that settled to 1e-3 was off by 5e-2. A smaller
    /// tolerance waits until the faster mode has decayed.
    pub fn error(&self) -> f64 {
        distance(self.envelope, self.contraction)
    }
}

/// The error of [`Settle::run`]: no steady state was found.
///
/// ```
/// use gear_dynamics::{Dop853, NfgPair, NfgParams, Settle, analysis::SettleError};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let start = pair.on_drive_flank()?;
/// let unsettled = Settle::new().max_periods(1).run(&Dop853::new(), &pair, &start).unwrap_err();
/// assert!(matches!(unsettled, SettleError::Aperiodic { periods: 1, .. }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SettleError {
    /// A setting or the period of the model is outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// No start was given, and the model has no static state.
    #[error("no static state to start from: {0}")]
    NoStaticState(#[from] LinearError),
    /// No period multiple was found within the maximum number of periods. A multiple p counts only if the
    /// state repeats after p periods at more than p periods in a row.
    #[error("{}", aperiodic(*.multiple, *.periods, *.closest, *.tolerance))]
    Aperiodic {
        /// The last state. Statistics of the motion can start from it.
        last: State,
        /// Number of periods of the drives that were integrated.
        periods: usize,
        /// Smallest difference of the last period over all period multiples, as a share of the ranges.
        closest: f64,
        /// Maximum period multiple.
        multiple: usize,
        /// Tolerance of [`Settle::tolerance`] `[1]`.
        tolerance: f64,
    },
    /// A coordinate is connected neither to others nor to the ground, and its mean acceleration is not zero:
    /// its velocity changes in every period, and there is no periodic orbit. All other coordinates repeat.
    #[error("{}", accelerates(.coordinate, .gain))]
    Accelerates {
        /// The coordinate, from 0.
        coordinate: usize,
        /// Its gain of velocity in one period of the motion of the others.
        gain: f64,
        /// The last state.
        last: State,
        /// Number of periods of the drives that were integrated.
        periods: usize,
    },
    /// The integration failed.
    #[error("after {periods} periods: {error}")]
    Integrate {
        /// Error of the integration.
        error: IntegrateError,
        /// State at the end of the last complete period.
        last: State,
        /// Number of complete periods.
        periods: usize,
    },
    /// The [`Budget`] is spent, or the call was cancelled.
    #[error("settling stopped after {periods} periods: {exhausted}")]
    Exhausted {
        /// The limit that was reached.
        exhausted: Exhausted,
        /// State at the end of the last complete period.
        last: State,
        /// Number of complete periods.
        periods: usize,
    },
}

fn aperiodic(multiple: usize, periods: usize, closest: f64, tolerance: f64) -> String {
    let what = format!("no orbit of up to {multiple} periods repeats within {periods} periods");
    if closest <= tolerance {
        return format!(
            "{what}: the last return is within {closest:.1e} of the range of motion, below {tolerance:?}, the \
             tolerance, but too few returns in a row are, or they still approach an orbit of fewer periods: \
             raise max_periods"
        );
    }
    format!(
        "{what}: the closest return is {closest:.1e} of the range of motion; it must be at most {tolerance:?}, the \
         tolerance: raise max_periods for a slow decay, max_period_multiple for a longer period, or the \
         tolerance if it lies below the error of the solver"
    )
}

impl SettleError {
    /// The last state at the end of a period; `None` if the run did not begin.
    pub fn last(&self) -> Option<&State> {
        match self {
            SettleError::Parameter(_) | SettleError::NoStaticState(_) => None,
            SettleError::Aperiodic { last, .. }
            | SettleError::Accelerates { last, .. }
            | SettleError::Integrate { last, .. }
            | SettleError::Exhausted { last, .. } => Some(last),
        }
    }
}
