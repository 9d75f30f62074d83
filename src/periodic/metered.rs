//! Roots within a budget, and the reasons why they are not found.

use crate::error::ParameterError;
use crate::ode::Exhausted;
use crate::ode::budget::Meter;
use crate::roots::{Matrix, Residual, Root, RootError};

/// Equations of which every residual counts against a budget. When the budget is spent, the residual is NaN
/// without an evaluation, so that any root finder ends.
pub(crate) struct Metered<'e, 'b, R: ?Sized> {
    pub(crate) equations: &'e mut R,
    pub(crate) meter: &'e Meter<'b>,
}

impl<R: Residual + ?Sized> Residual for Metered<'_, '_, R> {
    fn size(&self) -> usize {
        self.equations.size()
    }
    fn residual(&mut self, x: &[f64], r: &mut [f64]) {
        match self.meter.exhausted().map_or_else(|| self.meter.spend_slowly(), Err) {
            Ok(()) => self.equations.residual(x, r),
            Err(_) => r.fill(f64::NAN),
        }
    }
    fn matrix(&self) -> Matrix {
        self.equations.matrix()
    }
    fn jacobian(&mut self, x: &[f64], out: &mut Matrix) {
        self.equations.jacobian(x, out);
    }
}

/// The reason why a root finder ended before a root.
pub(crate) enum RootFailure {
    /// The budget is spent.
    Exhausted(Exhausted),
    /// A slope of the equations is not finite.
    Slope { equation: usize, unknown: usize },
    /// The equations do not determine an unknown.
    Singular { unknown: usize },
    /// The corrections do not become small.
    NotConverged,
    /// A residual is not finite.
    NotFinite,
}

impl RootFailure {
    /// The failure of equations that count against the budget of `meter`, and the last iterate.
    ///
    /// Error: a setting is not valid.
    pub(crate) fn of(error: RootError, meter: &Meter<'_>) -> Result<(Self, Root), ParameterError> {
        // Residuals after the end of the budget are NaN.
        let spent = |failure| meter.exhausted().map_or(failure, RootFailure::Exhausted);
        let (failure, last) = match error {
            RootError::Parameter(error) => return Err(error),
            RootError::Slope { equation, unknown, last, .. } => {
                (RootFailure::Slope { equation, unknown }, last)
            }
            RootError::Singular { unknown, last } => (spent(RootFailure::Singular { unknown }), last),
            RootError::NotConverged { last } => (spent(RootFailure::NotConverged), last),
            RootError::NotFinite { last, .. } => (spent(RootFailure::NotFinite), last),
        };
        Ok((failure, *last))
    }
}
