//! What lies between two neighbouring points of a branch.

use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::CurveError;
use crate::branches::curve::point::CurvePoint;
use crate::branches::orbits::measure::Measured;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::change::Change;
use crate::branches::points::detect::{Compared, OUTSIDE, changes};
use crate::branches::points::kind::PointKind;
use crate::branches::points::test_functions::{dips, doubling, torus};
use crate::branches::tracker::{Found, Node, SEPARATE, Tracker};

impl<C: OrbitMethod> Tracker<'_, C> {
    /// The kind of the point at which a change happens.
    fn kind(&self, change: Change, after: &Measured) -> PointKind {
        match change {
            Change::Fold => PointKind::Fold,
            Change::Branch => PointKind::Branch,
            Change::PeriodDoubling => PointKind::PeriodDoubling,
            Change::NeimarkSacker => PointKind::NeimarkSacker,
            Change::Grazing(extremum) => {
                let rattle = [&self.last.measured, after].map(|measured| measured.rattle[extremum.contact]);
                PointKind::Grazing { contact: extremum.contact, edge: extremum.edge(), rattle }
            }
        }
    }

    /// The located points between the last point and `next`, in order, and what was not explained or located.
    pub(crate) fn between(
        &mut self,
        reached: &Node<C::Solution>,
        step: f64,
    ) -> Result<(Found<C>, Vec<&'static str>), CurveError> {
        let (a, next) = (&self.last.point, &reached.point);
        let changes = changes(self.last.compared(), reached.compared());
        let exact = self.engine.curve.multipliers_pass_at_folds();
        let mut unexplained: Vec<&'static str> = Vec::new();
        unexplained.extend(changes.unexplained.filter(|what| exact || *what != OUTSIDE));
        if !unexplained.is_empty() && step > SEPARATE * self.settings.max_step {
            return Ok((Vec::new(), unexplained));
        }
        let mut found = Vec::new();
        for change in &changes.all {
            let located = match *change {
                Change::Branch => self.engine.locate_crossing(a, next, step, &mut test_of(*change)),
                _ => self.engine.locate(a, next, step, &mut test_of(*change)),
            };
            let located = match located {
                Err(CurveError::Exhausted(exhausted)) => return Err(exhausted.into()),
                Ok(Some(point)) => point,
                _ => {
                    unexplained.push(change.unlocated());
                    continue;
                }
            };
            let kind = match self.kind(*change, &reached.measured) {
                PointKind::Branch if self.engine.curve.is_symmetric(&located) => PointKind::SymmetryBreaking,
                kind => kind,
            };
            found.push((self.engine.distance(a, &located), located, kind));
        }
        let dips = match &self.before {
            Some((length, before)) => dips([before, &self.last.values, &reached.values], [*length, step]),
            None => Vec::new(),
        };
        for change in dips.into_iter().filter(|change| !changes.all.contains(change)) {
            match self.engine.locate_dip(a, next, step, &mut test_of(change)) {
                Err(CurveError::Exhausted(exhausted)) => return Err(exhausted.into()),
                Err(_) => {} // the test was not computed everywhere; nothing shows that its sign changes
                Ok(points) => {
                    for located in points {
                        let kind = self.kind(change, &reached.measured);
                        found.push((self.engine.distance(a, &located), located, kind));
                    }
                }
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok((found, unexplained))
    }
}

impl<S> Node<S> {
    fn compared(&self) -> Compared<'_, S> {
        let Node { point, measured, multipliers, .. } = self;
        Compared { point, multipliers: multipliers.as_ref(), trace: &measured.trace }
    }
}

/// The test function of a change.
fn test_of<C: OrbitMethod>(
    change: Change,
) -> impl FnMut(&mut Engine<C>, &CurvePoint<C::Solution>) -> Option<f64> {
    move |engine, point| match change {
        Change::Fold => Some(point.slope()),
        Change::Branch => Some(point.sign * point.logarithm.exp()),
        Change::PeriodDoubling => engine.curve.multipliers(point).as_ref().map(doubling),
        Change::NeimarkSacker => engine.curve.multipliers(point).as_ref().and_then(torus),
        Change::Grazing(extremum) => {
            let measured = engine.curve.measure(point, &[]).ok()?;
            measured.trace.nearest(&extremum).map(|at| at.distance)
        }
    }
}
