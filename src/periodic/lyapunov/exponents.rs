//! Lyapunov exponents as a result.

use crate::error::ParameterError;
use crate::model::equations::State;
use crate::ode::budget::Exhausted;
use crate::ode::error::IntegrateError;
use crate::periodic::lyapunov::growth::Growth;
use thiserror::Error;

/// Lyapunov exponents with their convergence.
///
/// ```
/// use gear_dynamics::{Lyapunov, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let exponents = Lyapunov::new().count(1).settle(2).align(1).periods(4).run(&pair, &pair.static_start()?)?;
/// assert!(exponents.per_period()[0] < -10.0);
/// assert_eq!(exponents.history(0).len(), 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Exponents {
    pub(crate) span: f64,
    /// One for each direction, the one that grows most first.
    pub(crate) grown: Vec<Growth>,
    /// Least standard error.
    pub(crate) floor: f64,
    pub(crate) state: State,
}

impl Exponents {
    /// The largest first.
    pub(crate) fn in_order(mut self) -> Self {
        self.grown.sort_by(|a, b| b.mean().total_cmp(&a.mean()));
        self
    }

    /// λ per unit of time, the largest first.
    pub fn values(&self) -> Vec<f64> {
        self.per_period().iter().map(|l| l / self.span).collect()
    }
    /// λ per period (or span), the largest first.
    pub fn per_period(&self) -> Vec<f64> {
        self.grown.iter().map(Growth::mean).collect()
    }
    /// Standard error of [`per_period`](Exponents::per_period): two of them hold the exponent in 95 % of all cases. Infinite with fewer than three
    /// periods.
    ///
    /// It is the root of the sum of three squares: the scatter of the growth (up to 16 projections on sine tapers, with Student's t), good if
    /// growth is correlated for less than about 1/16 of the run; where in a turn of the direction the run begins and ends; and 10 times the
    /// tolerance of the flow.
    ///
    /// With complex multipliers whose argument is near a simple fraction of a turn, the direction drifts slowly from period to period. A run
    /// shorter than that drift has bars up to two times too small: 20 periods of a dead zone with μ = -0.32 ± 0.50 i (122°) were held by two
    /// bars in 6 of 10 cases.
    pub fn standard_error(&self) -> Vec<f64> {
        self.grown.iter().map(|growth| growth.error().hypot(self.floor)).collect()
    }
    /// The estimate of exponent `i` per period after each period measured: how it converges.
    ///
    /// # Panics
    /// If there is no exponent `i`.
    pub fn history(&self, i: usize) -> Vec<f64> {
        let running = self.grown[i].periods.iter().scan(0.0, |sum, growth| {
            *sum += growth;
            Some(*sum)
        });
        running.enumerate().map(|(k, sum)| sum / (k + 1) as f64).collect()
    }
    /// Periods that were measured.
    fn measured(&self) -> usize {
        self.grown.first().map_or(0, |growth| growth.periods.len())
    }
    /// Where the motion has come to.
    pub fn state(&self) -> &State {
        &self.state
    }
}

/// Why exponents are missing.
///
/// ```
/// use gear_dynamics::{Lyapunov, NfgPair, NfgParams, periodic::LyapunovError};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let error = Lyapunov::new().count(3).run(&pair, &pair.static_start()?).unwrap_err();
/// assert!(matches!(error, LyapunovError::Parameter(_)) && error.to_string().contains("count is 3"));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LyapunovError {
    /// A setting or a start that cannot be used.
    #[error("Lyapunov exponents: {0}")]
    Parameter(#[from] ParameterError),
    /// The integration ended early.
    #[error("after {} periods: {error}", so_far.measured())]
    Flow {
        /// Why.
        error: IntegrateError,
        /// The exponents over the periods before.
        so_far: Box<Exponents>,
    },
    /// The [`Budget`](crate::Budget) is spent.
    #[error("after {} periods: {exhausted}", so_far.measured())]
    Exhausted {
        /// Which limit.
        exhausted: Exhausted,
        /// The exponents over the periods before.
        so_far: Box<Exponents>,
    },
    /// A direction that vanishes at once: small differences are lost, as where a force sticks, and the exponent is that of no flow.
    #[error("after {} periods: direction {direction} vanishes at t = {t}: the flow is singular there", so_far.measured())]
    Vanished {
        /// Which direction, counted from 1.
        direction: usize,
        /// When.
        t: f64,
        /// The exponents over the periods before.
        so_far: Box<Exponents>,
    },
}
