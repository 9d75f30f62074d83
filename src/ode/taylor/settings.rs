//! The Taylor integrator and its settings.

use crate::error::ParameterError;
use crate::ode::methods::adaptive::Adaptive;
use crate::ode::stepping::control::StepRule;
use crate::ode::taylor::expansion::coefficients::ORDERS;

/// Integration by Taylor series on fixed pieces, adaptive, with located edges.
///
/// In each step the motion is a polynomial Σ c_n sⁿ. Its coefficients follow from the algebra of the model
/// by recurrences, the step from the last two of them. If the algebra or a drive has functions that may
/// change later in the step (exponentials, powers, divisors), the equation is checked inside the step. Tooth
/// edges are roots of the polynomials of the deflections, found with a bound on their second derivatives, so
/// that no crossing of the polynomial is missed. The polynomial is also the dense output.   Source: Jorba &
/// Zou, Experimental Mathematics 14 (2005).
///
/// It requires a model that can be expanded: a [`Machine`](crate::Machine), also with held processes or
/// varying speed. Any other model, and an algebra with a kink that is no contact, gives
/// [`IntegrateError::NoSeries`](crate::ode::IntegrateError::NoSeries). On the workloads of the benches it
/// takes a third to a quarter of the time of [`Dop853`](crate::Dop853) at an error of 1e-9, and less of it
/// the smaller the error.
///
/// It has no first step and no controller to set: the length of every step follows from its own coefficients.
/// Edges are always located, since the coefficients hold on fixed pieces alone.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, NfgPair, NfgParams, Taylor};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let start = pair.on_drive_flank()?;
/// let end = Taylor::new().end(&pair, &start, 100.0)?;
/// let other = Dop853::new().rtol(1e-12).atol(1e-17).end(&pair, &start, 100.0)?;
/// assert!((end.q[0] - other.q[0]).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Taylor = Adaptive<TaylorSeries>;

/// The order of [`Taylor`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TaylorSeries {
    order: Option<usize>,
}

impl Default for Taylor {
    fn default() -> Self {
        Self::new()
    }
}

/// Smallest and largest order.
const RANGE: [usize; 2] = [4, ORDERS - 4];

/// Smallest and largest relative tolerance. Below the smallest, rounding shortens the steps without end;
/// above the largest, the last coefficients say nothing about the error.
const RTOL: [f64; 2] = [1e-16, 0.1];

impl Taylor {
    /// Defaults: rtol 1e-12, atol 1e-16, order by the tolerance, no maximum step, at most 10⁸ steps.
    pub fn new() -> Self {
        Adaptive::of(TaylorSeries { order: None }, [1e-12, 1e-16], 0.0)
    }
    /// Highest order of the series, in 4 ..= 28. Default: by the relative tolerance, from 21 at 1e-6 to 25
    /// at 1e-10 and below.
    pub fn order(mut self, order: usize) -> Self {
        self.method.order = Some(order);
        self
    }
    /// The default order for a relative tolerance. Above order 25 rounding errors of the last terms limit the
    /// accuracy.
    pub(crate) fn order_for(tolerance: f64) -> usize {
        let digits = -tolerance.clamp(1e-10, 1.0).log10();
        (15.0 + digits).round() as usize
    }

    /// The same settings with all tolerances multiplied by a factor below 1, within their range.
    pub(crate) fn finer(&self, factor: f64) -> Self {
        let mut finer = self.clone();
        finer.tolerances.rtol = (factor * finer.tolerances.rtol).max(RTOL[0]);
        finer.tolerances.atol.iter_mut().for_each(|atol| *atol = (factor * *atol).max(f64::MIN_POSITIVE));
        finer
    }

    /// Checks the relative tolerance of a run without absolute tolerances that are chosen for it.
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`].
    pub(crate) fn check_rtol(&self) -> Result<(), ParameterError> {
        let (name, value) = ("rtol".into(), self.tolerances.rtol);
        let ok = (RTOL[0]..=RTOL[1]).contains(&value);
        ok.then_some(()).ok_or(ParameterError::OutOfRange { name, value, allowed: "[1e-16, 0.1]" })
    }

    /// The order and the absolute tolerance of every component.
    ///
    /// # Errors
    /// A setting outside its range.
    pub(crate) fn check(&self, components: usize) -> Result<(usize, Vec<f64>), ParameterError> {
        let atol = StepRule::Adaptive(&self.tolerances).check(components)?;
        let order = self.method.order.unwrap_or(Taylor::order_for(self.tolerances.rtol));
        if !(RANGE[0]..=RANGE[1]).contains(&order) {
            let (name, value) = ("order".into(), order as f64);
            return Err(ParameterError::OutOfRange { name, value, allowed: "[4, 28]" });
        }
        Ok((order, atol))
    }
}
