//! Lyapunov exponents: result and errors.

use crate::error::ParameterError;
use crate::linear::LinearError;
use crate::model::State;
use crate::ode::{Exhausted, IntegrateError};
use crate::periodic::flow::flow_method::FlowMethod;
use crate::periodic::lyapunov::growth::Growth;
use crate::periodic::pursuit::PursuitError;
use thiserror::Error;

/// Lyapunov exponents with their standard errors and their convergence.
///
/// ```
/// use gear_dynamics::{Lyapunov, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let exponents = Lyapunov::new().count(1).settle(2).align(1).measure(4).run(&pair, &pair.on_drive_flank()?)?;
/// assert!(exponents.per_period()[0] < -10.0);
/// assert_eq!(exponents.running(0).len(), 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Exponents {
    pub(crate) span: f64,
    /// Growth of each direction; after [`in_order`](Exponents::in_order) the largest mean first.
    pub(crate) grown: Vec<Growth>,
    /// Standard error per period caused by the flow; the minimum of the standard error.
    pub(crate) floor: f64,
    pub(crate) state: State,
    pub(crate) method: FlowMethod,
}

impl Exponents {
    /// Sorts the exponents, the largest first.
    pub(crate) fn in_order(mut self) -> Self {
        self.grown.sort_by(|a, b| b.mean().total_cmp(&a.mean()));
        self
    }

    /// The method of the integration.
    pub fn flow_method(&self) -> FlowMethod {
        self.method
    }
    /// λ per unit of time, the largest first.
    pub fn values(&self) -> Vec<f64> {
        self.per_period().iter().map(|l| l / self.span).collect()
    }
    /// λ per period (or span), the largest first.
    pub fn per_period(&self) -> Vec<f64> {
        self.grown.iter().map(Growth::mean).collect()
    }
    /// Standard error of [`per_period`](Exponents::per_period). The interval of ± two standard errors
    /// contains the exponent in 95 % of all cases. Infinite with fewer than three periods, and if the
    /// direction is still on its first turn: the measured time is then shorter than the time of the motion,
    /// for example with spans far below it. Measure more or longer spans.
    ///
    /// It is √(a² + b² + c²), and at least the difference between the exponent of the second half of the run
    /// and that of all of it, which shows growth with a power of time:
    /// - a: the scatter of the growth, from up to 16 projections on sine tapers, with Student's t. Valid if
    ///   the growth is correlated over less than about 1/16 of the run.
    /// - b: the effect of the angle of a rotating direction at the start and at the end of the run, from
    ///   up to an eighth of the run at each end.
    /// - c: 10 times the tolerance of the flow.
    ///
    /// If complex multipliers have an argument near a simple fraction of 2π, the direction drifts slowly from
    /// period to period. If the run is shorter than this drift, the standard error is up to two times too
    /// small. Example: 20 periods of a dead zone with μ = -0.32 ± 0.50 i (122°); two standard errors
    /// contained the exponent in 6 of 10 cases.
    pub fn standard_error(&self) -> Vec<f64> {
        self.grown.iter().map(|growth| growth.error().hypot(self.floor)).collect()
    }
    /// Estimates of exponent `i` per period after 1, 2, ... measured periods: the convergence of the
    /// exponent.
    ///
    /// # Panics
    /// If there is no exponent `i`.
    pub fn running(&self, i: usize) -> Vec<f64> {
        let running = self.grown[i].periods.iter().scan(0.0, |sum, growth| {
            *sum += growth;
            Some(*sum)
        });
        running.enumerate().map(|(k, sum)| sum / (k + 1) as f64).collect()
    }
    /// Number of measured periods.
    fn measured(&self) -> usize {
        self.grown.first().map_or(0, |growth| growth.periods.len())
    }
    /// State that the motion has reached.
    pub fn state(&self) -> &State {
        &self.state
    }
}

/// Errors of [`Lyapunov`](crate::Lyapunov).
///
/// ```
/// use gear_dynamics::{Lyapunov, NfgPair, NfgParams, periodic::LyapunovError};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let error = Lyapunov::new().count(3).run(&pair, &pair.on_drive_flank()?).unwrap_err();
/// assert!(matches!(error, LyapunovError::Parameter(_)) && error.to_string().contains("count is 3"));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LyapunovError {
    /// A setting or the start is not valid.
    #[error("Lyapunov exponents: {0}")]
    Parameter(#[from] ParameterError),
    /// No start was given, and the model has no static state.
    #[error("Lyapunov exponents: no start, and no static state: {0}")]
    NoStaticState(#[from] LinearError),
    /// The integration failed.
    #[error("the integration failed after {} measured periods: {error}", last.measured())]
    Integrate {
        /// Error of the integration.
        error: IntegrateError,
        /// Exponents over the periods measured before.
        last: Box<Exponents>,
    },
    /// The [`Budget`](crate::Budget) is spent.
    #[error("the run was stopped after {} measured periods: {exhausted}", last.measured())]
    Exhausted {
        /// The limit that was reached.
        exhausted: Exhausted,
        /// Exponents over the periods measured before.
        last: Box<Exponents>,
    },
    /// The length of a direction falls to zero at one instant, for example where a body sticks. The flow is
    /// singular there and the direction has no finite exponent.
    #[error(
        "exponent {direction} is -∞: at t = {t:?}, after {} measured periods, the model erases a small deviation, as a \
         body that sticks does; ask only for the exponents before it (Lyapunov::count), which count from 0",
        last.measured()
    )]
    Vanished {
        /// Index of the direction, from 0.
        direction: usize,
        /// Time at which it vanishes.
        t: f64,
        /// Exponents over the periods measured before.
        last: Box<Exponents>,
    },
}

impl LyapunovError {
    /// The error of a pursuit after the exponents `last` were found.
    pub(crate) fn after(error: PursuitError, last: Exponents) -> Self {
        let last = Box::new(last);
        match error {
            PursuitError::Integrate(error) => LyapunovError::Integrate { error, last },
            PursuitError::Exhausted(exhausted) => LyapunovError::Exhausted { exhausted, last },
            PursuitError::Vanished { direction, t } => LyapunovError::Vanished { direction, t, last },
        }
    }
    /// The exponents over the periods measured before the failure; `None` for a wrong setting or start.
    pub fn last(&self) -> Option<&Exponents> {
        match self {
            LyapunovError::Parameter(_) | LyapunovError::NoStaticState(_) => None,
            LyapunovError::Integrate { last, .. }
            | LyapunovError::Exhausted { last, .. }
            | LyapunovError::Vanished { last, .. } => Some(last),
        }
    }
}
