//! What lies between two neighbouring points of a branch.

use crate::analysis::RattleState;
use crate::branches::curve::crossing::same_parameter;
use crate::branches::curve::equations::{Curve, CurveError};
use crate::branches::curve::locate::Between;
use crate::branches::curve::point::CurvePoint;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::orbits::symmetries::{differ, reverses};
use crate::branches::points::change::Change;
use crate::branches::points::kind::{PointKind, SpecialPoint};
use crate::branches::points::test_functions::{dips, misses_a_fold};
use crate::branches::steps::grazings::{Grazings, SAME_TIME};
use crate::branches::steps::node::Node;
use crate::branches::steps::of_orbits::{LocatedPoints, SEPARATE};
use crate::branches::steps::place::{Place, is_near_doubling};
use crate::branches::steps::stepper::Stepper;
use crate::branches::steps::within::Within;
use crate::model::State;

/// Distance of a point from the polynomial through the two points before it from which on a step may have
/// jumped, as a share of the step `[1]`.
const OFF: f64 = 1e-3;

/// The same, as a multiple of what the distance over the last step makes expected `[1]`.
const SUDDEN: f64 = 8.0;

/// A located bifurcation with its distance.
type Bifurcation<C> = (f64, CurvePoint<<C as Curve>::Solution>, Change);

impl<C: OrbitMethod> Stepper<'_, C> {
    /// The located points between the last point and `reached`, in order, and what was not explained or
    /// located.
    ///
    /// Grazings are located first. They divide the step into parts with one contact sequence each, in which
    /// the multipliers are smooth. Each part is searched for bifurcations.
    pub(crate) fn between(
        &mut self,
        reached: &Node<C::Solution>,
        step: f64,
    ) -> Result<(LocatedPoints<C>, Vec<&'static str>), CurveError> {
        let between = Between::new(&self.last.point, &reached.point, step);
        let before = self.before.as_ref().map(|(length, values)| (*length, values.extremes.as_slice()));
        let mut grazings = Grazings::new(&mut self.engine, &between);
        grazings.search(before, &self.last.measured.trace, &reached.measured.trace, step)?;
        let Grazings { found: grazed, mut unexplained, .. } = grazings;
        if differ(&self.last.measured.symmetries, &reached.measured.symmetries) {
            unexplained.push("the orbit gained or lost a symmetry in time");
        }
        let is_long = step > SEPARATE * self.settings.max_step;
        if !unexplained.is_empty() && is_long {
            return Ok((Vec::new(), unexplained));
        }
        // Grazings at the same time stand side by side: no part lies between them.
        let mut places = vec![self.last.place(0.0)];
        for (sigma, point, _) in &grazed {
            if places.last().is_none_or(|last| last.sigma == 0.0 || sigma - last.sigma > SAME_TIME * step) {
                let multipliers = self.engine.curve.multipliers(point);
                places.push(Place { sigma: *sigma, point: point.clone(), multipliers, grazes: true });
            }
        }
        places.push(reached.place(step));
        if grazed.is_empty() && self.may_have_jumped(reached, step) {
            self.engine.is_continuous(&self.last.point, &reached.point, step)?;
        }
        let mut within = Within::new(&mut self.engine, &between);
        let mut rattles = vec![self.last.measured.rattle.clone()];
        for two in places.windows(2) {
            within.search(&two[0], &two[1])?;
            if two[0].grazes && two[1].grazes {
                rattles.push(within.rattle_between(&two[0], &two[1])?);
            }
        }
        match &self.before {
            Some((length, before)) if grazed.is_empty() => {
                let dips = dips([before, &self.last.values, &reached.values], [*length, step]);
                within.search_dips(&dips, &places[0], &places[1])?;
                within.search_turned(&dips, &places[0], &places[1])?;
                if within.found.is_empty() && places.iter().all(is_near_doubling) {
                    within.search_middle(&places[0], &places[1])?;
                }
            }
            None if grazed.is_empty() && within.found.is_empty() => {
                within.search_middle(&places[0], &places[1])?;
            }
            _ => {}
        }
        let Within { found, unexplained: left, .. } = within;
        unexplained.extend(left);
        rattles.push(reached.measured.rattle.clone());
        let mut all = self.bifurcations(self.arclength, found);
        for (sigma, point, extremum) in grazed {
            let contact = extremum.contact;
            let passed =
                places.iter().filter(|place| place.grazes && place.sigma < sigma + SAME_TIME * step).count();
            let rattle: [RattleState; 2] = [passed - 1, passed].map(|part| rattles[part][contact]);
            all.push((sigma, point, SpecialPoint::Grazing { contact, flank: extremum.edge.flank(), rattle }));
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok((all, unexplained))
    }

    /// Whether the step may have jumped to another branch: a multiplier would have passed 1, or the point
    /// lies beside the polynomial through the two points before it.
    fn may_have_jumped(&self, reached: &Node<C::Solution>, step: f64) -> bool {
        let Some((length, before)) = &self.before else { return false };
        if misses_a_fold([before, &self.last.values, &reached.values], [*length, step]) {
            return true;
        }
        let Some(off) = self.off_prediction(&reached.point, step) else { return false };
        // The distance grows with the fourth power of the step.
        let expected = self.off_before.map_or(0.0, |before| before * (step / length).powi(4));
        self.back.is_some() && off > OFF * step && off > SUDDEN * expected
    }

    /// What the point after the last one tells of the step before it, in which nothing was located: a test
    /// that falls and rises again may pass 0 twice, and the end of the rise shows the curvature. The
    /// bifurcations that are found, at their distances from the start of that step.
    pub(crate) fn looking_back(
        &mut self,
        reached: &Node<C::Solution>,
        step: f64,
    ) -> Result<LocatedPoints<C>, CurveError> {
        let (Some(start), Some((length, before))) = (&self.back, &self.before) else { return Ok(Vec::new()) };
        let dips = dips([&reached.values, &self.last.values, before], [step, *length]);
        let between = Between::new(&start.point, &self.last.point, *length);
        let mut within = Within::new(&mut self.engine, &between);
        within.search_dips(&dips, start, &self.last.place(*length))?;
        let Within { mut found, .. } = within;
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let from = self.arclength - *length;
        Ok(self.bifurcations(from, found))
    }

    /// The kinds of located bifurcations. Their distances count from the arclength `from`. A crossing at
    /// which the branch turns back may be located a second time as a fold. The parameter hardly changes near
    /// such a crossing, so that rounding moves the fold far along the branch. A fold is left out if it lies
    /// within a maximum step of a located crossing and has the same parameter.
    fn bifurcations(&mut self, from: f64, mut found: Vec<Bifurcation<C>>) -> LocatedPoints<C> {
        let is_crossing = |change: Change| matches!(change, Change::Branch | Change::Branches(_));
        if let Some((sigma, point, _)) = found.iter().rev().find(|(.., change)| is_crossing(*change)) {
            self.crossing = Some([from + sigma, point.p]);
        }
        if let Some([at, p]) = self.crossing {
            found.retain(|(sigma, point, change)| {
                let is_near = (from + sigma - at).abs() < self.settings.max_step;
                let at_crossing = is_near && same_parameter(point.p, p);
                *change != Change::Fold || !at_crossing
            });
        }
        let kind = |point: &CurvePoint<C::Solution>, change| match change {
            Change::Fold => PointKind::Fold,
            _ if is_crossing(change) && self.is_symmetric(point) => PointKind::SymmetryBreaking,
            Change::Branch | Change::Branches(_) => PointKind::Branch,
            Change::PeriodDoubling | Change::PeriodDoublings(_) => PointKind::PeriodDoubling,
            Change::NeimarkSacker => PointKind::NeimarkSacker,
        };
        let special = |(sigma, point, change)| {
            let kind = kind(&point, change);
            (sigma, point, SpecialPoint::Bifurcation(kind))
        };
        found.into_iter().map(special).collect()
    }
}

impl<C: OrbitMethod> Stepper<'_, C> {
    /// Whether the orbit of a point has the symmetry x(t + T/2) = -x(t), and its model as well.
    fn is_symmetric(&self, point: &CurvePoint<C::Solution>) -> bool {
        let curve = &self.engine.curve;
        let has = |(multiple, state): (usize, State)| {
            let model = curve.family().at([point.p]).ok()?;
            let half = 0.5 * multiple as f64 * model.period();
            Some(reverses(&*model, &state, half, &self.last.measured.ranges))
        };
        curve.is_symmetric(point) && curve.first_state(point).and_then(has).unwrap_or(false)
    }
}

impl<S: Clone> Node<S> {
    pub(crate) fn place(&self, sigma: f64) -> Place<S> {
        let (point, multipliers) = (self.point.clone(), self.multipliers.clone());
        Place { sigma, point, multipliers, grazes: false }
    }
}
