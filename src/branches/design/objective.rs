//! The figure of an orbit that a design changes, and what may fail.

use crate::analysis::Statistics;
use crate::branches::branch_error::BranchError;
use crate::branches::curve::equations::CurveError;
use crate::branches::sensitivity::figure::Figure;
use crate::error::ParameterError;
use crate::model::Periodic;
use crate::ode::{Exhausted, IntegrateError};
use crate::periodic::{ShootingError, ShootingOrbit};
use thiserror::Error;

impl Figure {
    /// The figure of an orbit of `model`.
    pub(crate) fn value(
        self,
        model: &dyn Periodic,
        orbit: &ShootingOrbit,
        channel: &str,
    ) -> Result<f64, DesignError> {
        let mut statistics = Statistics::new(model, &[channel])?;
        orbit.observe(model, &mut statistics)?;
        Ok(self.of(&statistics.summary(channel)?))
    }
}

/// Errors of [`Least`](crate::branches::Least) and [`Fit`](crate::branches::Fit).
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, ParameterError, branches::{DesignError, Figure, Least}};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let least = Least::new("deflection", Figure::PeakToPeak).over("load torque", 30.0, 10.0);
/// let error = least.run(&pair, &[pair.on_drive_flank()?]).unwrap_err();
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
