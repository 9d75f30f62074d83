//! The figure of an orbit that a design changes.

use crate::analysis::{Statistics, Summary};
use crate::branches::branch_error::BranchError;
use crate::branches::curve::equations::CurveError;
use crate::branches::sensitivity::sensitivity_of_orbit::Sensitivity;
use crate::error::ParameterError;
use crate::model::Periodic;
use crate::ode::{Exhausted, IntegrateError};
use crate::periodic::{ShootingError, ShootingOrbit};
use thiserror::Error;

/// A figure of a channel over a period.
///
/// ```
/// use gear_dynamics::{analysis::Summary, branches::Figure};
/// let summary = Summary::from_samples(&[1.0, 3.0])?;
/// assert_eq!(Figure::PeakToPeak.of(&summary), 2.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Figure {
    /// Mean.
    Mean,
    /// Root mean square.
    Rms,
    /// Maximum less minimum.
    PeakToPeak,
    /// Maximum.
    Max,
    /// Minimum.
    Min,
}

impl Figure {
    /// The figure in a summary.
    pub fn of(self, summary: &Summary) -> f64 {
        match self {
            Figure::Mean => summary.mean,
            Figure::Rms => summary.rms,
            Figure::PeakToPeak => summary.peak_to_peak(),
            Figure::Max => summary.max,
            Figure::Min => summary.min,
        }
    }

    /// Its derivatives with respect to all constants.
    pub(crate) fn slopes(self, of: &Sensitivity, channel: &str) -> Result<Vec<f64>, ParameterError> {
        let slopes = match self {
            Figure::Mean => of.mean(channel),
            Figure::Rms => of.rms(channel),
            Figure::PeakToPeak => of.peak_to_peak(channel),
            Figure::Max => of.max(channel),
            Figure::Min => of.min(channel),
        };
        slopes.map(<[f64]>::to_vec)
    }

    /// The figure of an orbit of `model`.
    pub(crate) fn value(
        self,
        model: &dyn Periodic,
        orbit: &ShootingOrbit,
        channel: &str,
    ) -> Result<f64, DesignError> {
        let mut statistics = Statistics::new(&model, &[channel])?;
        orbit.observe(&model, &mut statistics)?;
        Ok(self.of(&statistics.summary(channel)?))
    }
}

/// Errors of [`Least`](crate::branches::Least) and [`Fit`](crate::branches::Fit).
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, ParameterError, branches::{DesignError, Figure, Least}};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let least = Least::new("deflection", Figure::PeakToPeak).over("load torque", 30.0, 10.0);
/// let error = least.run(&pair, &[pair.static_start()?]).unwrap_err();
/// assert!(matches!(error, DesignError::Parameter(ParameterError::Bounds { low: 30.0, high: 10.0, .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum DesignError {
    /// A setting is not valid, or a channel or a constant does not exist.
    #[error("design: {0}")]
    Parameter(#[from] ParameterError),
    /// No orbit was found.
    #[error("design: {0}")]
    Shooting(#[from] ShootingError),
    /// The derivatives of the orbit were not computed.
    #[error("design: {0}")]
    Branch(BranchError),
    /// An orbit was not measured.
    #[error("design: {0}")]
    Integrate(IntegrateError),
    /// The budget was spent before the first figure was known.
    #[error("design: {0}")]
    Exhausted(#[from] Exhausted),
    /// The optimiser stopped before it converged.
    #[error(
        "the optimiser stopped after {evaluations} evaluations: {reason}; the least value is {value:?} at {constants:?}"
    )]
    NotConverged {
        /// Why it stopped.
        reason: String,
        /// Number of evaluations.
        evaluations: usize,
        /// The least value found.
        value: f64,
        /// The constants of the least value.
        constants: Vec<(String, f64)>,
    },
}

impl From<IntegrateError> for DesignError {
    fn from(error: IntegrateError) -> Self {
        match error {
            IntegrateError::Exhausted { exhausted, .. } => DesignError::Exhausted(exhausted),
            error => DesignError::Integrate(error),
        }
    }
}

impl From<BranchError> for DesignError {
    fn from(error: BranchError) -> Self {
        match error {
            BranchError::Curve(CurveError::Exhausted(exhausted)) => DesignError::Exhausted(exhausted),
            error => DesignError::Branch(error),
        }
    }
}
