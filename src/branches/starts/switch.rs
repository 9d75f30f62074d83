//! Switching onto the branches that cross at a located point.

use crate::branches::branch_error::BranchError;
use crate::branches::continuation::Continuation;
use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::CurveError;
use crate::branches::curve::point::CurvePoint;
use crate::branches::family::Family;
use crate::branches::following::Following;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::branch_point::BranchPoint;
use crate::branches::points::kind::PointKind;
use crate::branches::starts::start::Start;
use crate::branches::steps::stepper::Stepper;
use crate::error::ParameterError;
use crate::model::State;
use crate::numeric::norms::right_vectors;
use crate::periodic::{FourierOrbit, ShootingOrbit};
use nalgebra::{DMatrix, DVector};

/// The branch that crosses at a point, as a [`Start`]: at a period doubling the orbits of twice the period,
/// at a branch point or a symmetry breaking the other branch. The first point of the result lies at the
/// distance [`first_step`](Continuation::first_step) from the crossing.
///
/// The first direction is the vector of the null space of the equations without a change of the parameter,
/// which is the tangent at a period doubling and at a symmetry breaking.
///
/// On a branch by harmonic balance the harmonics of [`Continuation::balance`] are those of the branch at a
/// branch point or a symmetry breaking, and those of twice the period multiple
/// ([`Harmonics::with_period_multiple`](crate::Harmonics::with_period_multiple)) at a period doubling. A
/// doubling of such a branch is that of the equation along the series. The doubled balance branches off
/// nearby.
///
/// # Errors
/// [`BranchError::Kind`] for a point that is no crossing of branches; [`BranchError::Curve`] if no point of
/// the other branch is found; [`ParameterError::Wrong`] for harmonics over another number of periods.
///
/// ```
/// use gear_dynamics::{State, branches::{Continuation, Family, PointKind, Switch}, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.025, 0.5, &[-0.5], &[])?.parts()?.build("driver", 2.4)?;
/// let family = Family::over(&pair, ["speed"])?;
/// let range = Continuation::new(2.4, 1.7).max_points(40);
/// let branch = range.run(&family, &State::new(0.0, &[1.5], &[0.0]))?;
/// let range = range.max_points(3);
/// let doubled = range.run(&family, Switch::of_point(branch.of_kind(PointKind::PeriodDoubling)[0]))?;
/// assert_eq!(doubled.points()[0].orbit.period_multiple(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Switch<'p, O = ShootingOrbit> {
    point: &'p BranchPoint<O>,
    /// Sign of the direction.
    way: f64,
}

impl<'p, O> Switch<'p, O> {
    /// The branch that crosses at a point, in one direction.
    pub fn of_point(point: &'p BranchPoint<O>) -> Self {
        Switch { point, way: 1.0 }
    }
    /// The same branch in the opposite direction. At a period doubling it has the same orbits, half a period
    /// apart.
    pub fn reversed(self) -> Self {
        Switch { way: -self.way, ..self }
    }
    /// The number of periods of the other branch in one of this branch.
    fn times(&self) -> Result<usize, BranchError> {
        match self.point.kind() {
            Some(PointKind::PeriodDoubling) => Ok(2),
            Some(PointKind::Branch | PointKind::SymmetryBreaking) => Ok(1),
            kind => Err(BranchError::Kind { kind, wanted: HAVE_CROSSING }),
        }
    }
}

impl Start for Switch<'_> {
    type Point = BranchPoint;

    fn begin<'f>(
        self,
        settings: &'f Continuation,
        family: &'f Family<'f>,
    ) -> Result<Following<'f>, BranchError> {
        let Switch { point, way } = self;
        let orbit = if self.times()? == 2 { doubled(&point.orbit) } else { point.orbit.clone() };
        let engine = settings.shooting_engine(family, point.parameter, &orbit)?;
        let x = engine.curve.unknowns(&orbit);
        settings.cross(engine, x, point.parameter, way).map(Following::new)
    }
    fn goes_both_ways(&self) -> bool {
        false
    }
}

impl Start for Switch<'_, FourierOrbit> {
    type Point = BranchPoint<FourierOrbit>;

    fn begin<'f>(
        self,
        settings: &'f Continuation,
        family: &'f Family<'f>,
    ) -> Result<Following<'f, Self::Point>, BranchError> {
        let Switch { point, way } = self;
        let (times, balance) = (self.times()?, settings.balance_of(&point.orbit)?);
        let (periods, needed) =
            (balance.harmonics().period_multiple(), times * point.orbit.harmonics().period_multiple());
        if periods != needed {
            let why =
                if times == 2 { "twice those of the orbit that doubles" } else { "as those of the orbit" };
            let (name, must) = ("number of periods of the harmonics".into(), format!("be {needed}, {why}"));
            return Err(ParameterError::Wrong { name, value: periods as f64, must }.into());
        }
        let orbit = point.orbit.on(balance.harmonics());
        let engine = settings.balance_engine(family, &balance, point.parameter, &orbit)?;
        let x = engine.curve.unknowns(&orbit);
        settings.cross(engine, x, point.parameter, way).map(Following::new)
    }
    fn goes_both_ways(&self) -> bool {
        false
    }
}

impl Continuation {
    /// Starts on the branch that crosses at a solution (x, p).
    fn cross<'f, C: OrbitMethod>(
        &'f self,
        mut engine: Engine<C>,
        x: DVector<f64>,
        p: f64,
        way: f64,
    ) -> Result<Stepper<'f, C>, BranchError> {
        let linear = engine.curve.linearise(&x, p)?;
        let (n, units) = (x.len(), engine.units());
        let matrix = DMatrix::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
            (true, true) => linear.by_x[(i, j)] * units[j],
            (true, false) => linear.by_p[i] * units[n],
            (false, _) => 0.0,
        });
        let direction = pitchfork(matrix).ok_or(CurveError::Singular)? * way;
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

/// Kinds of points at which a branch crosses.
const HAVE_CROSSING: &str = "a period doubling, a branch point or a symmetry breaking";

/// The orbit over twice its period.
fn doubled(orbit: &ShootingOrbit) -> ShootingOrbit {
    let mut twice = orbit.clone();
    let period = orbit.period();
    let later = orbit.states().iter().map(|state| State { t: state.t + period, ..state.clone() });
    twice.parts.states.extend(later);
    twice.parts.end += period;
    twice.parts.multiple *= 2;
    // The drift along rigid motions over n periods: Δq grows with the sum of the velocity drifts.
    let [of_q, of_v] = &mut twice.parts.drift;
    of_q.iter_mut().zip(&*of_v).for_each(|(q, v)| *q = 2.0 * *q + v * period);
    of_v.iter_mut().for_each(|v| *v *= 2.0);
    twice
}

/// The unit vector in the plane of the two smallest singular values whose last component is 0.
fn pitchfork(matrix: DMatrix<f64>) -> Option<DVector<f64>> {
    let n = matrix.nrows();
    let right = right_vectors(matrix)?;
    let (a, b) = (right.row(n - 1).transpose(), right.row(n - 2).transpose());
    let direction = &a * b[n - 1] - &b * a[n - 1];
    let length = direction.norm();
    // Both vectors without a change of the parameter: the one that is determined least.
    if length > 1e-12 { Some(direction / length) } else { Some(a) }
}
