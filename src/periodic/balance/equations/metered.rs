//! Equations that count against a budget.

use crate::ode::budget::Meter;
use crate::roots::matrix::Matrix;
use crate::roots::residual::Residual;

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
    fn jacobian(&mut self, x: &[f64], out: &mut Matrix) -> bool {
        self.equations.jacobian(x, out)
    }
}
