//! Bifurcations within a part of a step that has one contact sequence.

use crate::analysis::contacts::rattle::RattleState;
use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::CurveError;
use crate::branches::curve::locate::{Between, Turning};
use crate::branches::curve::point::CurvePoint;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::change::Change;
use crate::branches::points::detect::{OUTSIDE, bifurcations};
use crate::branches::points::test_functions::{doubling, may_dip, torus};
use crate::periodic::multipliers::Multipliers;

/// A point within a step.
pub(crate) struct Place<S> {
    /// Distance from the start of the step.
    pub(crate) sigma: f64,
    pub(crate) point: CurvePoint<S>,
    pub(crate) multipliers: Option<Multipliers>,
    /// Whether a contact grazes an edge.
    pub(crate) grazes: bool,
}

/// The search within one step.
pub(crate) struct Within<'w, 'p, C: OrbitMethod> {
    engine: &'w mut Engine<C>,
    between: &'w Between<'p, C::Solution>,
    /// The bifurcations that are found, at their distances from the start of the step.
    pub(crate) found: Vec<(f64, CurvePoint<C::Solution>, Change)>,
    /// What was not explained or located.
    pub(crate) unexplained: Vec<&'static str>,
}

/// Number of parts beside a grazing. Their ends lie at distances that grow quadratically: the multipliers vary as
/// √σ with the distance σ from a grazing, where two crossings more or less appear.
const BESIDE: usize = 2;

/// How often a part is halved to separate bifurcations.
const HALVED: usize = 10;

impl<'w, 'p, C: OrbitMethod> Within<'w, 'p, C> {
    pub(crate) fn new(engine: &'w mut Engine<C>, between: &'w Between<'p, C::Solution>) -> Self {
        Within { engine, between, found: Vec::new(), unexplained: Vec::new() }
    }

    fn at(&mut self, sigma: f64) -> Result<Place<C::Solution>, CurveError> {
        let point = self.engine.point_at(self.between, sigma)?;
        let multipliers = self.engine.curve.multipliers(&point);
        Ok(Place { sigma, point, multipliers, grazes: false })
    }

    /// Searches between two places without a grazing between them.
    pub(crate) fn search(
        &mut self,
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
    ) -> Result<(), CurveError> {
        if !a.grazes && !b.grazes {
            return self.separate(a, b, HALVED);
        }
        if a.grazes && b.grazes {
            let middle = self.at(0.5 * (a.sigma + b.sigma))?;
            self.search(a, &middle)?;
            return self.search(&middle, b);
        }
        let [grazing, far] = if a.grazes { [a, b] } else { [b, a] };
        let mut inner = Vec::with_capacity(BESIDE);
        for k in 1..BESIDE {
            let share = k as f64 / BESIDE as f64;
            inner.push(self.at(grazing.sigma + share * share * (far.sigma - grazing.sigma))?);
        }
        // In order along the branch.
        let mut places: Vec<&Place<C::Solution>> = [grazing].into_iter().chain(&inner).chain([far]).collect();
        if b.grazes {
            places.reverse();
        }
        for k in 0..BESIDE {
            let found = self.found.len();
            self.separate(places[k], places[k + 1], HALVED)?;
            if self.found.len() == found {
                self.search_dips(&near_zero(&places, k), places[k], places[k + 1])?;
            }
        }
        Ok(())
    }

    /// Locates the bifurcations between two places, each in an interval of its own.
    fn separate(
        &mut self,
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
        left: usize,
    ) -> Result<(), CurveError> {
        let (all, unexplained) =
            bifurcations((&a.point, a.multipliers.as_ref()), (&b.point, b.multipliers.as_ref()));
        let exact = self.engine.curve.multipliers_pass_at_folds();
        if let Some(what) = unexplained.filter(|what| exact || *what != OUTSIDE) {
            if left == 0 {
                self.unexplained.push(what);
                return Ok(());
            }
            let middle = self.at(0.5 * (a.sigma + b.sigma))?;
            self.separate(a, &middle, left - 1)?;
            return self.separate(&middle, b, left - 1);
        }
        let mut turns = false;
        for &change in &all {
            // A crossing at which the branch turns back is no fold.
            if change == Change::Fold && turns {
                continue;
            }
            let ends = [a, b].map(|place| value(change, place).map(|value| [place.sigma, value]));
            if let Some((point, turned)) = self.locate(change, ends)? {
                turns |= turned;
                self.search_beside(&point, &all, a, b)?;
            }
        }
        Ok(())
    }

    /// Locates a bifurcation between two distances with values of its test, and keeps it. Also returns whether the branch
    /// turns back at a crossing.
    fn locate(
        &mut self,
        change: Change,
        ends: [Option<[f64; 2]>; 2],
    ) -> Result<Option<Turning<C::Solution>>, CurveError> {
        let located = match (ends, change) {
            ([Some(from), Some(to)], Change::Branch) => {
                self.engine.locate_crossing(self.between, [from, to], &mut test_of(change))
            }
            ([Some(from), Some(to)], _) => {
                let point = self.engine.locate_within(self.between, [from, to], &mut test_of(change));
                point.map(|point| point.map(|point| (point, false)))
            }
            _ => Ok(None),
        };
        match located {
            Err(CurveError::Exhausted(exhausted)) => Err(exhausted.into()),
            Ok(Some((point, turns))) => {
                self.found.push((self.engine.distance(self.between.start(), &point), point.clone(), change));
                Ok(Some((point, turns)))
            }
            _ => {
                self.unexplained.push(change.unlocated());
                Ok(None)
            }
        }
    }

    /// Searches both sides of a located point for other bifurcations that the ends of the part do not show.
    fn search_beside(
        &mut self,
        point: &CurvePoint<C::Solution>,
        shown: &[Change],
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
    ) -> Result<(), CurveError> {
        let at = self.engine.distance(self.between.start(), point);
        for change in [Change::Fold, Change::PeriodDoubling].into_iter().filter(|c| !shown.contains(c)) {
            let test = &mut test_of(change);
            let values = [value(change, a), test(self.engine, point), value(change, b)];
            let [Some(from), Some(there), Some(to)] = values else { continue };
            if from * to <= 0.0 || from * there >= 0.0 {
                continue;
            }
            self.locate(change, [Some([a.sigma, from]), Some([at, there])])?;
            self.locate(change, [Some([at, there]), Some([b.sigma, to])])?;
        }
        Ok(())
    }

    /// Searches for tests that change their sign twice between two places.
    pub(crate) fn search_dips(
        &mut self,
        changes: &[Change],
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
    ) -> Result<(), CurveError> {
        for change in changes {
            let [Some(from), Some(to)] = [a, b].map(|place| value(*change, place)) else { continue };
            if from * to <= 0.0 {
                continue;
            }
            let [from, to] = [[a.sigma, from], [b.sigma, to]];
            match self.engine.dip_within(self.between, [from, to], &mut test_of(*change)) {
                Err(CurveError::Exhausted(exhausted)) => return Err(exhausted.into()),
                Err(_) | Ok(None) => {} // nothing shows that the sign of the test changes
                Ok(Some(inside)) => {
                    self.locate(*change, [Some(from), Some(inside)])?;
                    self.locate(*change, [Some(inside), Some(to)])?;
                }
            }
        }
        Ok(())
    }

    /// The rattle states between two grazings.
    pub(crate) fn rattle_between(
        &mut self,
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
    ) -> Result<Vec<RattleState>, CurveError> {
        let middle = self.engine.point_at(self.between, 0.5 * (a.sigma + b.sigma))?;
        Ok(self.engine.curve.measure(&middle, &[])?.rattle)
    }
}

/// The bifurcations whose tests may change their sign twice between the places k and k + 1, which lie at equal
/// distances in √σ.
fn near_zero<S>(places: &[&Place<S>], k: usize) -> Vec<Change> {
    let near = |change: &Change| {
        let at = |i: usize| value(*change, places[i]).unwrap_or(f64::NAN);
        let after = k > 0 && may_dip([at(k - 1), at(k), at(k + 1)], [1.0; 2]);
        let before = k + 2 < places.len() && may_dip([at(k + 2), at(k + 1), at(k)], [1.0; 2]);
        after || before
    };
    Change::ALL.into_iter().filter(near).collect()
}

/// The test function of a bifurcation at a place.
fn value<S>(change: Change, place: &Place<S>) -> Option<f64> {
    value_at(change, &place.point, || place.multipliers.clone())
}

fn value_at<S>(
    change: Change,
    point: &CurvePoint<S>,
    multipliers: impl FnOnce() -> Option<Multipliers>,
) -> Option<f64> {
    match change {
        Change::Fold => Some(point.slope()),
        Change::Branch => Some(point.sign * point.logarithm.exp()),
        Change::PeriodDoubling => multipliers().as_ref().map(doubling),
        Change::NeimarkSacker => multipliers().as_ref().and_then(torus),
    }
}

/// The test function of a bifurcation.
fn test_of<C: OrbitMethod>(
    change: Change,
) -> impl FnMut(&mut Engine<C>, &CurvePoint<C::Solution>) -> Option<f64> {
    move |engine, point| value_at(change, point, || engine.curve.multipliers(point))
}
