//! Estimates of the errors of an orbit.

use crate::error::check;
use crate::model::Periodic;
use crate::ode::budget::Meter;
use crate::periodic::balance::balance_error::BalanceError;
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::quadrature::pulses::pulses;
use crate::periodic::balance::quality::coarseness::{MORE, correction};
use crate::periodic::balance::settings::Balance;
use crate::periodic::shooting::multiple::Shooting;
use crate::periodic::shooting::shooting_orbit::ShootingOrbit;

/// Estimates of the errors of an orbit of a [`Balance`](crate::Balance), by [`Balance::error_estimate`].
///
/// ```
/// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let balance = Balance::new(Harmonics::up_to(70));
/// let orbit = balance.solve(&pair, None)?;
/// let estimate = balance.error_estimate(&pair, &orbit)?;
/// assert!((estimate.truncation - 5.469e-6).abs() < 1e-9); // truncation error of 70 orders
/// assert!(estimate.aliasing < 1e-9 && estimate.finer.harmonics().highest() == 91);
/// # Ok::<(), gear_dynamics::periodic::BalanceError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ErrorEstimate {
    /// max |z_H - z_1.3H| over the peak-to-peak value `[1]`: the truncation error of this orbit, if both
    /// balances converged.
    pub truncation: f64,
    /// The orbit with 1.3 H orders.
    pub finer: FourierOrbit,
    /// First Newton correction of the orbit with finer integrals, over the peak-to-peak value `[1]`.
    ///
    /// The finer integrals are panels if the drives have pulses between the samples or panels, exact
    /// integrals if contacts were sampled, and otherwise twice the samples or half the width of the panels.
    /// The residual that the root finder left contributes too.
    pub aliasing: f64,
    /// First correction of multiple shooting, over the range of motion `[1]`.
    ///
    /// A small correction is a few times smaller than the error. If it exceeds 0.1, or is infinite because
    /// shooting failed, there is no orbit of the equation near this one.
    pub shooting: f64,
    /// The orbit of the equation itself, to 1e-12, with its monodromy matrix; `None` if shooting failed.
    pub polished: Option<ShootingOrbit>,
}

impl Balance {
    /// Estimates the errors of an orbit: solves again with 1.3 H orders, computes the correction by finer
    /// integrals, and starts multiple shooting from the orbit.
    ///
    /// # Errors
    /// [`BalanceError`] if the balance with 1.3 H orders finds no orbit from this one: this orbit is then not
    /// reliable.
    pub fn error_estimate(
        &self,
        model: &dyn Periodic,
        orbit: &FourierOrbit,
    ) -> Result<ErrorEstimate, BalanceError> {
        self.estimate(model, orbit, &self.budget.begin())
    }

    /// [`error_estimate`](Balance::error_estimate) with the rest of a budget.
    fn estimate(
        &self,
        model: &dyn Periodic,
        orbit: &FourierOrbit,
        meter: &Meter<'_>,
    ) -> Result<ErrorEstimate, BalanceError> {
        let finer = self.clone().with_harmonics(self.harmonics().extended()).find(model, orbit, meter)?;
        // Truncated forces are compared with those of twice the samples.
        let pulsed = !self.truncated_forces && !pulses(model, orbit, self.harmonics(), meter).is_empty();
        let mut better = match self.integrals {
            _ if pulsed => self.clone().integrals(Integrals::Panels).set_up(model, orbit, 1, meter)?,
            Integrals::Sampled { .. } if model.contacts() > 0 && !self.truncated_forces => {
                Balance::new(self.harmonics().clone()).set_up(model, orbit, 1, meter)?
            }
            _ => self.set_up(model, orbit, MORE, meter)?,
        };
        let aliasing = correction(&mut better, orbit);
        let polished = Shooting::new().find_near(model, orbit, meter).ok();
        if let Some(exhausted) = meter.exhausted() {
            return Err(BalanceError::Exhausted { exhausted, last: Box::new(finer) });
        }
        let shooting = polished.as_ref().map_or(f64::INFINITY, ShootingOrbit::first_correction);
        Ok(ErrorEstimate { truncation: orbit.distance(&finer), finer, aliasing, shooting, polished })
    }

    /// Adds orders, up to order `highest`, until the three errors of the [`ErrorEstimate`] are at most
    /// `accuracy` `[1]`: truncation, correction by finer integrals, correction by shooting.
    ///
    /// The correction by shooting also contains errors that do not appear at any kept order.
    ///
    /// # Errors
    /// [`BalanceError::Accuracy`] with the best orbit if this requires more orders than `highest`, or if no
    /// orbit is found with more orders; another [`BalanceError`] if there is no orbit from the guess.
    pub fn solve_to(
        &self,
        model: &dyn Periodic,
        guess: &FourierOrbit,
        accuracy: f64,
        highest: usize,
    ) -> Result<ErrorEstimate, BalanceError> {
        crate::error::check::positive("accuracy", accuracy)?;
        let least = self.harmonics().highest();
        check::at_least("highest order", highest, least)?;
        let (mut balance, meter) = (self.clone(), self.budget.begin());
        let mut orbit = balance.find(model, guess, &meter)?;
        let mut reached = f64::INFINITY;
        let short = |reached, highest, last, cause| BalanceError::Accuracy {
            wanted: accuracy,
            reached,
            highest,
            last: Box::new(last),
            cause,
        };
        loop {
            let further = balance.harmonics().extended();
            if further.highest() > highest {
                return Err(short(reached, highest, orbit, None));
            }
            let estimate = match balance.estimate(model, &orbit, &meter) {
                Ok(estimate) => estimate,
                Err(error) => {
                    let kept = balance.harmonics().highest();
                    return Err(short(reached, kept, orbit, Some(Box::new(error))));
                }
            };
            reached = estimate.truncation.max(estimate.aliasing).max(estimate.shooting);
            if reached <= accuracy {
                return Ok(estimate);
            }
            balance = balance.with_harmonics(further);
            orbit = estimate.finer;
        }
    }
}
