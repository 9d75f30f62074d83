//! Switching onto the branches that cross at a located point.

use crate::branches::branch::{Branch, BranchError};
use crate::branches::continuation::Continuation;
use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::CurveError;
use crate::branches::curve::point::CurvePoint;
use crate::branches::family::Family;
use crate::branches::following::Following;
use crate::branches::orbits::by_balance::balance_family::Plain;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::branch_point::BranchPoint;
use crate::branches::points::kind::PointKind;
use crate::branches::tracker::Tracker;
use crate::error::ParameterError;
use crate::model::equations::State;
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::settings::Balance;
use crate::periodic::shooting::shooting_orbit::ShootingOrbit;
use nalgebra::{DMatrix, DVector};
use std::rc::Rc;

impl Continuation {
    /// Follows the branch that crosses at a point: at a period doubling the orbits of twice the period, at a
    /// branch point or a symmetry breaking the other branch. The first point of the result lies at the
    /// distance [`first_step`](Continuation::first_step) from the crossing.
    ///
    /// The two directions away from a period doubling are the same orbits, half a period apart. At a
    /// branch point, `way` is the direction: 1 or -1.
    ///
    /// The first direction is the vector of the null space of the equations without a change of the
    /// parameter, which is the tangent at a period doubling and at a symmetry breaking.
    ///
    /// # Errors
    /// [`BranchError::Kind`] for a point that is no crossing of branches; [`BranchError::Curve`] if no point
    /// of the other branch is found.
    pub fn switch(&self, family: &dyn Family, point: &BranchPoint, way: f64) -> Result<Branch, BranchError> {
        Ok(self.begin_switch(family, point, way)?.finish())
    }

    /// [`switch`](Continuation::switch) point by point.
    ///
    /// # Errors
    /// As [`switch`](Continuation::switch).
    pub fn begin_switch<'f>(
        &'f self,
        family: &'f dyn Family,
        point: &BranchPoint,
        way: f64,
    ) -> Result<Following<'f>, BranchError> {
        self.check()?;
        check_way(way)?;
        let orbit = match point.kind {
            Some(PointKind::PeriodDoubling) => doubled(&point.orbit),
            Some(PointKind::Branch | PointKind::SymmetryBreaking) => point.orbit.clone(),
            ref kind => {
                return Err(BranchError::Kind { kind: kind.clone(), wanted: WANTED });
            }
        };
        let engine = self.shooting_engine(family, point.parameter, &orbit)?;
        let x = engine.curve.unknowns(&orbit);
        Ok(Following { tracker: Box::new(self.cross(engine, x, point.parameter, way)?) })
    }

    /// [`switch`](Continuation::switch) for a branch by [`balance`](Continuation::balance). `harmonics` of the
    /// balance: those of the branch at a branch point or a symmetry breaking; at a period doubling harmonics over
    /// twice as many periods ([`Harmonics::over_periods`](crate::Harmonics::over_periods)).
    ///
    /// A doubling of such a branch is that of the equation along the series. The doubled balance branches off nearby.
    ///
    /// # Errors
    /// As [`switch`](Continuation::switch); [`ParameterError::OutOfRange`] for harmonics over another number of
    /// periods.
    pub fn switch_balance(
        &self,
        family: &dyn Family,
        balance: &Balance,
        point: &BranchPoint<FourierOrbit>,
        way: f64,
    ) -> Result<Branch<FourierOrbit>, BranchError> {
        self.check()?;
        check_way(way)?;
        let times = match &point.kind {
            Some(PointKind::PeriodDoubling) => 2,
            Some(PointKind::Branch | PointKind::SymmetryBreaking) => 1,
            kind => return Err(BranchError::Kind { kind: kind.clone(), wanted: WANTED }),
        };
        let (periods, needed) = (balance.harmonics().periods(), times * point.orbit.harmonics().periods());
        if periods != needed {
            let (name, allowed) = (
                "periods of the harmonics".into(),
                if times == 2 {
                    "the set of twice those of the orbit, at a period doubling"
                } else {
                    "the set of those of the orbit"
                },
            );
            return Err(ParameterError::OutOfRange { name, value: periods as f64, allowed }.into());
        }
        let orbit = point.orbit.on(balance.harmonics());
        let engine = self.balance_engine(Rc::new(Plain(family)), balance, point.parameter, &orbit)?;
        let x = engine.curve.unknowns(&orbit);
        let tracker = self.cross(engine, x, point.parameter, way)?;
        Ok(Following { tracker: Box::new(tracker) }.finish())
    }

    /// Starts on the branch that crosses at a solution (x, p).
    fn cross<'f, C: OrbitMethod>(
        &'f self,
        mut engine: Engine<C>,
        x: DVector<f64>,
        p: f64,
        way: f64,
    ) -> Result<Tracker<'f, C>, BranchError> {
        let linear = engine.curve.linearise(&x, p)?;
        let (n, units) = (x.len(), engine.units());
        let matrix = DMatrix::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
            (true, true) => linear.by_x[(i, j)] * units[j],
            (true, false) => linear.by_p[i] * units[n],
            (false, _) => 0.0,
        });
        let direction = pitchfork(matrix).ok_or(CurveError::Singular)? * way.signum();
        let corrections = Vec::new();
        let base = CurvePoint {
            x,
            p,
            tangent: direction.clone(),
            units,
            sign: 1.0,
            logarithm: 0.0,
            corrections,
            solution: linear.solution,
        };
        let step = self.first_step;
        let (x, p) = base.along(&direction, step);
        let start = engine.correct(&base, &direction, step, x, p)?;
        self.follow(engine, start)
    }
}

fn check_way(way: f64) -> Result<(), ParameterError> {
    let name = || "way".into();
    let allowed = "the set of 1 and -1";
    if way.abs() == 1.0 {
        Ok(())
    } else {
        Err(ParameterError::OutOfRange { name: name(), value: way, allowed })
    }
}

/// Kinds of points at which a branch crosses.
const WANTED: &str = "a period doubling, a branch point or a symmetry breaking";

/// The orbit over twice its period.
fn doubled(orbit: &ShootingOrbit) -> ShootingOrbit {
    let mut twice = orbit.clone();
    let period = orbit.period();
    let later = orbit.states().iter().map(|state| State { t: state.t + period, ..state.clone() });
    twice.states.extend(later);
    twice.end += period;
    twice.multiple *= 2;
    // The drift along rigid motions over n periods: Δq grows with the sum of the velocity drifts.
    let [of_q, of_v] = &mut twice.drift;
    of_q.iter_mut().zip(&*of_v).for_each(|(q, v)| *q = 2.0 * *q + v * period);
    of_v.iter_mut().for_each(|v| *v *= 2.0);
    twice
}

/// The unit vector in the plane of the two smallest singular values whose last component is 0.
fn pitchfork(matrix: DMatrix<f64>) -> Option<DVector<f64>> {
    let n = matrix.nrows();
    let right = matrix.svd(false, true).v_t?;
    let (a, b) = (right.row(n - 1).transpose(), right.row(n - 2).transpose());
    let direction = &a * b[n - 1] - &b * a[n - 1];
    let length = direction.norm();
    // Both vectors without a change of the parameter: the one that is determined least.
    if length > 1e-12 { Some(direction / length) } else { Some(a) }
}
