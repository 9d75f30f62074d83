//! Branches of orbits by harmonic balance.

use crate::branches::branch::Branch;
use crate::branches::branch_error::BranchError;
use crate::branches::continuation::Continuation;
use crate::branches::curve::engine::Engine;
use crate::branches::family::Family;
use crate::branches::following::Following;
use crate::branches::orbits::by_balance::balance_curve::BalanceCurve;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::branch_point::BranchPoint;
use crate::branches::starts::start::{Resume, Start};
use crate::periodic::{Balance, FourierOrbit};
use std::rc::Rc;

/// Largest last correction of a point, if the corrections do not converge quadratically `[1]`.
const TOLERANCE: f64 = 1e-10;

impl Start for &FourierOrbit {
    type Point = BranchPoint<FourierOrbit>;

    fn begin<'f>(
        self,
        settings: &'f Continuation,
        family: &'f Family<'f>,
    ) -> Result<Following<'f, Self::Point>, BranchError> {
        let balance = settings.balance_of(self)?;
        let orbit = balance.solve(&*family.at([settings.from])?, self)?;
        settings.follow_balance(family, &balance, settings.from, &orbit, settings.heading())
    }
}

impl Resume for BranchPoint<FourierOrbit> {
    fn resume<'f>(
        &self,
        _: &Branch<FourierOrbit>,
        heading: f64,
        settings: &'f Continuation,
        family: &'f Family<'f>,
    ) -> Result<Following<'f, Self>, BranchError> {
        let balance = settings.balance_of(&self.orbit)?;
        settings.follow_balance(family, &balance, self.parameter, &self.orbit, heading)
    }
}

impl Continuation {
    /// A branch from an orbit. `heading`: sign of the first change of the parameter.
    fn follow_balance<'f>(
        &'f self,
        family: &'f Family<'f>,
        balance: &Balance,
        p: f64,
        orbit: &FourierOrbit,
        heading: f64,
    ) -> Result<Following<'f, BranchPoint<FourierOrbit>>, BranchError> {
        let mut engine = self.balance_engine(family, balance, p, orbit)?;
        let x = engine.curve.unknowns(orbit);
        let point = engine.start_towards(x, p, heading)?;
        self.follow(engine, point).map(Following::new)
    }

    pub(crate) fn balance_engine<'f>(
        &'f self,
        family: &'f Family<'f>,
        balance: &Balance,
        p: f64,
        orbit: &FourierOrbit,
    ) -> Result<Engine<BalanceCurve<'f>>, BranchError> {
        let (meter, unit) = (Rc::new(self.budget.begin()), self.unit());
        let curve = BalanceCurve::new(family, balance, (p, unit), orbit, meter)?;
        let curve = curve.with_stability(self.stability_or_default());
        Ok(Engine { curve, unit, tolerance: TOLERANCE, max_corrections: 10, at_crossing: false })
    }
}
