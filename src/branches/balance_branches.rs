//! Continuation by harmonic balance.

use crate::branches::branch::{Branch, BranchError};
use crate::branches::branch_end::BranchEnd;
use crate::branches::continuation::Continuation;
use crate::branches::curve::engine::Engine;
use crate::branches::family::{ByFunction, Family};
use crate::branches::following::Following;
use crate::branches::orbits::by_balance::balance_curve::BalanceCurve;
use crate::branches::orbits::by_balance::balance_family::{BalanceFamily, Plain, Truncating};
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::error::ParameterError;
use crate::model::equations::Periodic;
use crate::model::machine::Machine;
use crate::model::shape::Shape;
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::settings::Balance;
use std::rc::Rc;

/// Largest last correction of a point, if the corrections do not converge quadratically `[1]`.
const TOLERANCE: f64 = 1e-10;

/// By harmonic balance.
///
/// The points of such a branch are [`FourierOrbit`]s: solutions of the balance with its orders and integrals.
/// Folds and branch points are those of the balance. With few orders the balance may have folds that the
/// equation has not; with sampled integrals of contacts it has spurious ones, so that exact integrals should
/// be used. Period doublings, Neimark-Sacker points and the stability are those of the equation linearised
/// along the series ([`FourierOrbit::multipliers`]).
///
/// The derivative of the residual with respect to a named constant is exact. With respect to the parameter of
/// a closure, and if accelerations jump at switches, it is computed by one-sided differences; they affect the
/// number of corrections, not the points that are found.
///
/// The number of samples of the integrals is that of the first point.
impl Continuation {
    /// Follows a branch of the balance from the orbit near a guess at the parameter `from`.
    ///
    /// [`shooting`](Continuation::shooting) has no effect. The budget counts one step for each evaluation of
    /// the equations and each step of the multipliers.
    ///
    /// ```
    /// use gear_dynamics::branches::{ByConstant, Continuation};
    /// use gear_dynamics::{Balance, Harmonics, contact::Piece, trains::SpurPair};
    /// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
    /// let family = ByConstant::new(&pair, "speed")?;
    /// let balance = Balance::new(Harmonics::up_to(12));
    /// let guess = balance.linearised(&pair, Piece::Upper)?;
    /// let branch = Continuation::new(0.6, 0.7).measure(&["q1"]).balance(&family, &balance, &guess)?;
    /// let last = branch.points().last().ok_or("a point")?;
    /// assert_eq!(last.parameter, 0.7);
    /// assert!((last.peak_to_peak() - last.orbit.peak_to_peak(0)).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`BranchError`]: settings out of range, or no orbit near the guess. What fails later ends the branch,
    /// see [`Branch::end`].
    pub fn balance(
        &self,
        family: &dyn Family,
        balance: &Balance,
        guess: &FourierOrbit,
    ) -> Result<Branch<FourierOrbit>, BranchError> {
        self.balance_all(Rc::new(Plain(family)), balance, guess)
    }

    /// Starts a continuation by balance that yields its points one by one. It can be stopped at any point;
    /// see [`resume_balance`](Continuation::resume_balance).
    ///
    /// # Errors
    /// As [`balance`](Continuation::balance).
    pub fn begin_balance<'f>(
        &'f self,
        family: &'f dyn Family,
        balance: &Balance,
        guess: &FourierOrbit,
    ) -> Result<Following<'f, FourierOrbit>, BranchError> {
        self.balance_begin(Rc::new(Plain(family)), balance, guess)
    }

    /// Continues a branch of the balance from its last point in the direction in which it was followed. The
    /// result begins with that point.
    ///
    /// # Errors
    /// As [`balance`](Continuation::balance); also for a branch without points.
    pub fn resume_balance<'f>(
        &'f self,
        family: &'f dyn Family,
        balance: &Balance,
        branch: &Branch<FourierOrbit>,
    ) -> Result<Following<'f, FourierOrbit>, BranchError> {
        self.check()?;
        let last = branch.points.last().ok_or(BranchError::NoPoints)?;
        self.check_within(last.parameter)?;
        let family = Rc::new(Plain(family));
        let mut following =
            self.balance_from(family, balance, last.parameter, &last.orbit, branch.heading)?;
        following.tracker.shift(last.arclength);
        Ok(following)
    }

    /// [`balance`](Continuation::balance) with the contact forces truncated to the kept orders before they are
    /// multiplied by the stiffness, see [`Balance::solve_truncating_forces`].   Source: Liu 2021.
    ///
    /// Folds, branch points and grazings are located. The multipliers of the points are those of the equation
    /// along the series; changes of them are not located.
    ///
    /// ```
    /// use gear_dynamics::branches::{ByFunction, Continuation};
    /// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, contact::Piece, models::nfg::NfgReading};
    /// let at = |speed| NfgPair::with_reading(&NfgParams { speed, ..NfgParams::table1() }, NfgReading::published());
    /// let family = ByFunction::new("speed", "rad/s", at);
    /// let balance = Balance::new(Harmonics::bands(63, 1, 2)?); // the 15 unknowns of Liu 2021
    /// let guess = balance.linearised(&at(179.0)?, Piece::Lower)?;
    /// let continuation = Continuation::new(179.0, 190.0).max_points(20);
    /// let branch = continuation.balance_truncating_forces(&family, &balance, &guess)?;
    /// assert!((branch.of_kind("fold")[0].parameter - 179.9259).abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`balance`](Continuation::balance).
    pub fn balance_truncating_forces<G, F>(
        &self,
        family: &ByFunction<F>,
        balance: &Balance,
        guess: &FourierOrbit,
    ) -> Result<Branch<FourierOrbit>, BranchError>
    where
        G: Shape + 'static,
        F: Fn(f64) -> Result<Machine<G>, ParameterError>,
    {
        self.balance_all(Rc::new(Truncating(family)), balance, guess)
    }

    fn balance_all<'f, M: Periodic + ?Sized + 'f>(
        &'f self,
        family: Rc<dyn BalanceFamily<M> + 'f>,
        balance: &Balance,
        guess: &FourierOrbit,
    ) -> Result<Branch<FourierOrbit>, BranchError> {
        let forward = self.balance_begin(family.clone(), balance, guess)?.finish();
        if !self.is_both_ways() || matches!(forward.end, BranchEnd::Closed | BranchEnd::Exhausted(_)) {
            return Ok(forward);
        }
        let (start, heading) = (&forward.points[0], -self.heading());
        // What fails in the second direction does not lose the first.
        match self.balance_from(family, balance, start.parameter, &start.orbit, heading) {
            Ok(back) => Ok(back.finish().reversed_before(forward)),
            Err(_) => Ok(forward),
        }
    }

    fn balance_begin<'f, M: Periodic + ?Sized + 'f>(
        &'f self,
        family: Rc<dyn BalanceFamily<M> + 'f>,
        balance: &Balance,
        guess: &FourierOrbit,
    ) -> Result<Following<'f, FourierOrbit>, BranchError> {
        self.check()?;
        let orbit = family.solve(balance, &*family.at(self.from)?, guess)?;
        self.balance_from(family, balance, self.from, &orbit, self.heading())
    }

    /// A continuation from an orbit. `heading`: sign of the first change of the parameter.
    fn balance_from<'f, M: Periodic + ?Sized + 'f>(
        &'f self,
        family: Rc<dyn BalanceFamily<M> + 'f>,
        balance: &Balance,
        p: f64,
        orbit: &FourierOrbit,
        heading: f64,
    ) -> Result<Following<'f, FourierOrbit>, BranchError> {
        let mut engine = self.balance_engine(family, balance, p, orbit)?;
        let x = engine.curve.unknowns(orbit);
        let point = engine.start_towards(x, p, heading)?;
        Ok(Following { tracker: Box::new(self.follow(engine, point)?) })
    }

    pub(crate) fn balance_engine<'f, M: Periodic + ?Sized + 'f>(
        &'f self,
        family: Rc<dyn BalanceFamily<M> + 'f>,
        balance: &Balance,
        p: f64,
        orbit: &FourierOrbit,
    ) -> Result<Engine<BalanceCurve<'f, M>>, BranchError> {
        let (meter, unit) = (Rc::new(self.budget.begin()), self.unit());
        let curve = BalanceCurve::new(family, balance, (p, unit), orbit, meter)?;
        let curve = curve.with_stability(self.stability);
        Ok(Engine { curve, unit, tolerance: TOLERANCE, max_corrections: 10, at_crossing: false })
    }
}
