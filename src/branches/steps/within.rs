//! Bifurcations within a part of a step that has one contact sequence.

use crate::analysis::RattleState;
use crate::branches::curve::crossing::same_parameter;
use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::CurveError;
use crate::branches::curve::locate::{Between, Test};
use crate::branches::curve::point::CurvePoint;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::change::{Change, VERTICAL};
use crate::branches::points::detect::{OUTSIDE, bifurcations};
use crate::branches::points::test_functions::{
    above, at_one, below, is_torus, outside, pairs_change_places, together,
};
use crate::branches::steps::place::{Place, near_zero, test_of, turns_twice, value};
use crate::periodic::Multipliers;

/// The search within one step.
pub(crate) struct Within<'w, 'p, C: OrbitMethod> {
    engine: &'w mut Engine<C>,
    pub(super) between: &'w Between<'p, C::Solution>,
    /// The bifurcations that are found, at their distances from the start of the step.
    pub(crate) found: Vec<(f64, CurvePoint<C::Solution>, Change)>,
    /// What was not explained or located.
    pub(crate) unexplained: Vec<&'static str>,
}

/// Number of parts beside a grazing. Their ends lie at distances that grow quadratically: the multipliers
/// vary as √σ with the distance σ from a grazing, where two crossings more or less appear.
const PARTS_BESIDE: usize = 2;

/// How often a part is divided to separate bifurcations.
pub(super) const MAX_DIVISIONS: usize = 10;

/// Distance from a located point at which the stretch beside it begins, as a share of the step `[1]`. It is
/// above the accuracy of a crossing of branches, at which the equations are singular.
pub(super) const ASIDE: f64 = 1e-3;

/// Two located bifurcations of one kind count as the same point if they are closer than this share of the
/// step `[1]`.
const SAME_PLACE: f64 = 1e-6;

/// A multiplier this close to the unit circle at the end of a step may have passed it twice within the step
/// `[1]`.
const NEAR_CIRCLE: f64 = 0.2;

/// A test of doublings below this value at the end of a step may pass 0 twice within the step `[1]`.
const MAY_DOUBLE: f64 = 0.5;

/// Whether a multiplier at a place lies near the unit circle.
pub(super) fn is_near_circle<S>(place: &Place<S>) -> bool {
    let near = |m: &Multipliers| m.values().iter().any(|m| (m.norm() - 1.0).abs() < NEAR_CIRCLE);
    place.multipliers.as_ref().is_some_and(near)
}

/// What the search for a zero of a test found.
pub(super) enum Zero {
    /// The distance of a point that is kept and, if the branch turns back there though it is not a fold, the
    /// slope dp/ds before it.
    Point(f64, Option<f64>),
    /// A zero of the test of tori without a complex pair on the unit circle.
    Saddle,
    /// No point.
    Nothing,
}

impl<'w, 'p, C: OrbitMethod> Within<'w, 'p, C> {
    pub(crate) fn new(engine: &'w mut Engine<C>, between: &'w Between<'p, C::Solution>) -> Self {
        Within { engine, between, found: Vec::new(), unexplained: Vec::new() }
    }

    pub(super) fn at(&mut self, sigma: f64) -> Result<Place<C::Solution>, CurveError> {
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
            return self.separate(a, b, MAX_DIVISIONS);
        }
        if a.grazes && b.grazes {
            let middle = self.at(0.5 * (a.sigma + b.sigma))?;
            self.search(a, &middle)?;
            return self.search(&middle, b);
        }
        let [grazing, far] = if a.grazes { [a, b] } else { [b, a] };
        let mut inner = Vec::with_capacity(PARTS_BESIDE);
        for k in 1..PARTS_BESIDE {
            let share = k as f64 / PARTS_BESIDE as f64;
            inner.push(self.at(grazing.sigma + share * share * (far.sigma - grazing.sigma))?);
        }
        // In order along the branch.
        let mut places: Vec<&Place<C::Solution>> = [grazing].into_iter().chain(&inner).chain([far]).collect();
        if b.grazes {
            places.reverse();
        }
        for k in 0..PARTS_BESIDE {
            let found = self.found.len();
            self.separate(places[k], places[k + 1], MAX_DIVISIONS)?;
            if self.found.len() == found {
                self.search_dips(&near_zero(&places, k), places[k], places[k + 1])?;
            }
            // The part beside the far end.
            let inner = match k {
                0 if b.grazes => places[1],
                k if k + 1 == PARTS_BESIDE && a.grazes => places[k],
                _ => continue,
            };
            if self.found.len() == found {
                for (change, lowest) in self.turned(inner, far, &[])? {
                    self.search_dip(change, Some(lowest), places[k], places[k + 1])?;
                }
            }
        }
        Ok(())
    }

    /// The changes whose tests fall towards 0 from `inner` to `far` and rise again before `far`, with a guess
    /// of the place of their least value. Beside the next grazing a test turns over a part of the step, which
    /// no parabola through distant values shows. One orbit beside `far` tells it; only tests that lose half
    /// of their value are asked, and that of doublings where it is small.
    fn turned(
        &mut self,
        inner: &Place<C::Solution>,
        far: &Place<C::Solution>,
        known: &[Change],
    ) -> Result<Vec<(Change, f64)>, CurveError> {
        let falls = |change: &Change| match [inner, far].map(|place| value(*change, place)) {
            [Some(from), Some(to)] => {
                let least = if *change == Change::Fold { VERTICAL } else { 0.0 };
                let may_double = *change == Change::PeriodDoubling && to.abs() < MAY_DOUBLE;
                from * to > 0.0 && (may_double || (least..0.5 * from.abs()).contains(&to.abs()))
            }
            _ => false,
        };
        let several = far.multipliers.as_ref().map_or([None; 2], together);
        let several = several.into_iter().flatten().map(|(change, _)| change);
        let falling: Vec<Change> =
            Change::SINGLE.into_iter().chain(several).filter(|c| !known.contains(c) && falls(c)).collect();
        if falling.is_empty() {
            return Ok(Vec::new());
        }
        let beside = self.at(far.sigma + ASIDE * (inner.sigma - far.sigma))?;
        let lowest = |change: Change| {
            let [from, near, to] = [inner, &beside, far].map(|place| value(change, place));
            let (from, near, to) = (from?.abs(), near?.abs(), to?.abs());
            // The parabola with the values at both ends and the slope at the far one, over the length 1.
            let slope = (to - near) / ASIDE;
            let place = 0.5 * slope / (from - to + slope);
            let is_low =
                to < 0.5 * from || (0.0..1.0).contains(&place) && to - 0.5 * slope * place < 0.5 * from;
            (slope > 0.0 && is_low).then_some((change, far.sigma + place * (inner.sigma - far.sigma)))
        };
        Ok(falling.into_iter().filter_map(lowest).collect())
    }

    /// Locates the bifurcations between two places, each in an interval of its own. The stretches on both
    /// sides of a located point are searched again. `left`: how often a part may still be divided.
    pub(super) fn separate(
        &mut self,
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
        left: usize,
    ) -> Result<(), CurveError> {
        let (mut all, unexplained) =
            bifurcations((&a.point, a.multipliers.as_ref()), (&b.point, b.multipliers.as_ref()));
        let exact = self.engine.curve.multipliers_pass_at_folds();
        let unexplained = unexplained.filter(|what| exact || *what != OUTSIDE);
        // Two zeros of one test hide each other.
        let is_hidden = |change: &Change| match [a, b].map(|place| value(*change, place)) {
            [Some(from), Some(to)] => (from > 0.0) == (to > 0.0),
            _ => true,
        };
        let ends = a.multipliers.as_ref().zip(b.multipliers.as_ref());
        let change_places = ends.is_some_and(|(of_a, of_b)| pairs_change_places(of_a, of_b));
        let hides = all.iter().any(is_hidden) || turns_twice(a, b) || change_places;
        if left > 0 && (unexplained.is_some() || hides) {
            return self.halve(a, b, left);
        }
        if let Some(what) = unexplained
            && !self.locate_together(a, b)?
        {
            self.unexplained.push(what);
        }
        // A zero of the test of tori that is none is known before other points are kept.
        all.sort_by_key(|change| *change != Change::NeimarkSacker);
        let (kept, mut at) = (self.found.len(), Vec::with_capacity(all.len()));
        let (mut turns, mut crossing) = (false, None);
        for &change in &all {
            // A crossing at which the branch turns back is no fold.
            if change == Change::Fold && turns {
                continue;
            }
            let ends = [a, b].map(|place| value(change, place).map(|value| [place.sigma, value]));
            match self.locate(change, ends)? {
                Zero::Point(sigma, turned) => {
                    let p = self.found.last().map(|(_, point, _)| point.p);
                    let near = crossing.zip(p).is_some_and(|(crossing, p)| same_parameter(p, crossing));
                    // Another slope at the start is that of a branch with a fold before the crossing.
                    if turned.is_some_and(|slope| slope * a.point.slope() < 0.0) && left > 0 {
                        self.found.truncate(kept);
                        return self.halve(a, b, left);
                    }
                    turns |= turned.is_some();
                    match change {
                        Change::Branch => crossing = p,
                        // The branch turns back at the crossing.
                        Change::Fold if near => {
                            self.found.pop();
                            turns = true;
                            continue;
                        }
                        _ => {}
                    }
                    at.push(sigma);
                }
                Zero::Saddle if left > 0 => return self.halve(a, b, left),
                Zero::Saddle | Zero::Nothing => self.unexplained.push(change.unlocated()),
            }
        }
        match left {
            0 => Ok(()),
            // Beyond a crossing at which it turns back the branch repeats itself.
            _ if turns => self.search_beside_turn(&at, a, b),
            _ => self.search_beside(at, a, b, left),
        }
    }

    fn halve(
        &mut self,
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
        left: usize,
    ) -> Result<(), CurveError> {
        let middle = self.at(0.5 * (a.sigma + b.sigma))?;
        self.separate(a, &middle, left - 1)?;
        self.separate(&middle, b, left - 1)
    }

    /// Locates a point at which several real multipliers pass -1 or 1 together, as those of equal members do.
    /// Returns whether there is one.
    fn locate_together(
        &mut self,
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
    ) -> Result<bool, CurveError> {
        let (Some(of_a), Some(of_b)) = (&a.multipliers, &b.multipliers) else { return Ok(false) };
        let passed = [below, above].map(|count| [count(of_a), count(of_b)]);
        let of = [Change::PeriodDoublings, Change::Branches];
        let mut found = false;
        for (change, [from, to]) in of.into_iter().zip(passed) {
            if from.abs_diff(to) < 2 {
                continue;
            }
            let change = change(from.min(to));
            let ends = [a, b].map(|place| value(change, place).map(|value| [place.sigma, value]));
            found |= matches!(self.locate(change, ends)?, Zero::Point(..));
        }
        Ok(found)
    }

    /// Locates a bifurcation between two distances with values of its test, and keeps it.
    pub(super) fn locate(&mut self, change: Change, ends: [Option<[f64; 2]>; 2]) -> Result<Zero, CurveError> {
        let [Some(from), Some(to)] = ends else { return Ok(Zero::Nothing) };
        let test: &mut Test<'_, C> = &mut test_of(change);
        let located = if matches!(change, Change::Branch | Change::Branches(_)) {
            self.engine.locate_crossing(self.between, [from, to], test)
        } else {
            let point = match change {
                Change::Fold => self.engine.locate_fold(self.between, [from, to], test),
                _ => self.engine.locate_between(self.between, [from, to], test),
            };
            point.map(|point| point.map(|point| (point, None)))
        };
        match located {
            Err(CurveError::Exhausted(exhausted)) => Err(exhausted.into()),
            Ok(Some((point, turns))) => {
                let multipliers = self.engine.curve.multipliers(&point);
                let is_pair = |m: &Multipliers| change != Change::NeimarkSacker || is_torus(m);
                if !multipliers.as_ref().is_none_or(is_pair) {
                    return Ok(Zero::Saddle);
                }
                let sigma = self.engine.distance(self.between.start(), &point);
                // Two searches of one part may find one point. Where one multiplier rises through 1 and
                // another one falls, the determinant has a double zero.
                let nearer = match change {
                    Change::NeimarkSacker | Change::PeriodDoubling => SAME_PLACE,
                    Change::Branch if multipliers.as_ref().map_or(0, at_one) > 1 => ASIDE,
                    _ => 0.0,
                };
                let same = |(at, _, other): &(f64, _, Change)| {
                    *other == change && (at - sigma).abs() < nearer * self.between.length()
                };
                if !self.found.iter().any(same) {
                    self.found.push((sigma, point, change));
                }
                Ok(Zero::Point(sigma, turns))
            }
            _ => Ok(Zero::Nothing),
        }
    }

    /// Searches for tests that change their sign twice between two places.
    pub(crate) fn search_dips(
        &mut self,
        changes: &[Change],
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
    ) -> Result<(), CurveError> {
        changes.iter().try_for_each(|change| self.search_dip(*change, None, a, b))
    }

    /// Searches for tests that change their sign twice within a step without a grazing and grow again at its
    /// end. The changes in `known` are left out.
    pub(crate) fn search_turned(
        &mut self,
        known: &[Change],
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
    ) -> Result<(), CurveError> {
        if !is_near_circle(b) {
            return Ok(());
        }
        let turned = self.turned(a, b, known)?;
        turned.into_iter().try_for_each(|(change, lowest)| self.search_dip(change, Some(lowest), a, b))
    }

    /// Searches for a test that changes its sign twice. `turned`: a guess of its least value, if it has one
    /// inside.
    pub(super) fn search_dip(
        &mut self,
        change: Change,
        turned: Option<f64>,
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
    ) -> Result<(), CurveError> {
        let [Some(from), Some(to)] = [a, b].map(|place| value(change, place)) else { return Ok(()) };
        let inside = self.found.iter().filter(|(sigma, ..)| (a.sigma..b.sigma).contains(sigma));
        let inside: Vec<Change> = inside.map(|(.., change)| *change).collect();
        // Two located points are the two changes of the sign.
        if from * to <= 0.0 || inside.iter().filter(|other| **other == change).count() > 1 {
            return Ok(());
        }
        let is_new = inside.is_empty();
        let [from, to] = [[a.sigma, from], [b.sigma, to]];
        let (between, sign) = (self.between, from[1].signum());
        let before = a.multipliers.as_ref().filter(|_| is_new).map(outside);
        // Two multipliers that pass the circle together leave the sign of the test as it is.
        let (mut passed, mut of_change) = (None, test_of(change));
        let mut test = |engine: &mut Engine<C>, point: &CurvePoint<C::Solution>| {
            let value = of_change(engine, point)?;
            let now = before.and_then(|_| engine.curve.multipliers(point));
            if sign * value > 0.0 && now.is_some_and(|now| before != Some(outside(&now))) {
                passed = Some(engine.distance(between.start(), point));
                return None;
            }
            Some(value)
        };
        match self.engine.dip_between(between, [from, to], turned, &mut test) {
            Err(CurveError::Exhausted(exhausted)) => return Err(exhausted.into()),
            Err(_) | Ok(None) => {} // nothing shows that the sign of the test changes
            Ok(Some(inside)) => {
                for ends in [[from, inside], [inside, to]] {
                    if let Zero::Nothing = self.locate(change, ends.map(Some))? {
                        self.unexplained.push(change.unlocated());
                    }
                }
            }
        }
        let Some(sigma) = passed else { return Ok(()) };
        let middle = self.at(sigma)?;
        self.separate(a, &middle, MAX_DIVISIONS)?;
        self.separate(&middle, b, MAX_DIVISIONS)
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
