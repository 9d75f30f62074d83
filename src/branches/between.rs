//! What lies between two neighbouring points of a branch.

use crate::analysis::contacts::rattle::RattleState;
use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::CurveError;
use crate::branches::curve::locate::Between;
use crate::branches::curve::point::CurvePoint;
use crate::branches::orbits::contact_trace::Extremum;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::change::Change;
use crate::branches::points::detect::{SEQUENCE, explain_the_sequence, grazings};
use crate::branches::points::kind::PointKind;
use crate::branches::points::test_functions::{dips, grazing_dips};
use crate::branches::tracker::{Found, Node, SEPARATE, Tracker};
use crate::branches::within::{Place, Within};

/// Distance of two grazings that happen at the same time, as a share of the step `[1]`.
const SAME: f64 = 1e-9;

/// A located grazing at its distance from the last point.
type Grazed<C> = (f64, CurvePoint<C>, Extremum);

impl<C: OrbitMethod> Tracker<'_, C> {
    /// The located points between the last point and `reached`, in order, and what was not explained or located.
    ///
    /// Grazings are located first. They divide the step into parts with one contact sequence each, in which the
    /// multipliers are smooth. Each part is searched for bifurcations.
    pub(crate) fn between(
        &mut self,
        reached: &Node<C::Solution>,
        step: f64,
    ) -> Result<(Found<C>, Vec<&'static str>), CurveError> {
        let mut unexplained = Vec::new();
        let grazed = self.grazed(reached, step, &mut unexplained)?;
        let is_long = step > SEPARATE * self.settings.max_step;
        if !unexplained.is_empty() && is_long {
            return Ok((Vec::new(), unexplained));
        }
        // Grazings at the same time stand side by side: no part lies between them.
        let mut places = vec![self.last.place(0.0)];
        for (sigma, point, _) in &grazed {
            if places.last().is_none_or(|last| last.sigma == 0.0 || sigma - last.sigma > SAME * step) {
                let multipliers = self.engine.curve.multipliers(point);
                places.push(Place { sigma: *sigma, point: point.clone(), multipliers, grazes: true });
            }
        }
        places.push(reached.place(step));
        let between = Between::new(&self.last.point, &reached.point, step);
        let mut within = Within::new(&mut self.engine, &between);
        let mut rattles = vec![self.last.measured.rattle.clone()];
        for two in places.windows(2) {
            within.search(&two[0], &two[1])?;
            if two[0].grazes && two[1].grazes {
                rattles.push(within.rattle_between(&two[0], &two[1])?);
            }
        }
        if let (true, Some((length, before))) = (grazed.is_empty(), &self.before) {
            let dips = dips([before, &self.last.values, &reached.values], [*length, step]);
            within.search_dips(&dips, &places[0], &places[1])?;
        }
        let Within { found, unexplained: left, .. } = within;
        unexplained.extend(left);
        rattles.push(reached.measured.rattle.clone());
        let mut all: Found<C> = Vec::new();
        for (sigma, point, change) in found {
            let kind = match change {
                Change::Fold => PointKind::Fold,
                Change::Branch if self.engine.curve.is_symmetric(&point) => PointKind::SymmetryBreaking,
                Change::Branch => PointKind::Branch,
                Change::PeriodDoubling => PointKind::PeriodDoubling,
                Change::NeimarkSacker => PointKind::NeimarkSacker,
            };
            all.push((sigma, point, kind));
        }
        for (sigma, point, extremum) in grazed {
            let contact = extremum.contact;
            let passed =
                places.iter().filter(|place| place.grazes && place.sigma < sigma + SAME * step).count();
            let rattle: [RattleState; 2] = [passed - 1, passed].map(|part| rattles[part][contact]);
            all.push((sigma, point, PointKind::Grazing { contact, edge: extremum.edge(), rattle }));
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok((all, unexplained))
    }

    /// The located grazings between the last point and `reached`, in order.
    fn grazed(
        &mut self,
        reached: &Node<C::Solution>,
        step: f64,
        unexplained: &mut Vec<&'static str>,
    ) -> Result<Vec<Grazed<C::Solution>>, CurveError> {
        let (a, b) = (&self.last, reached);
        let between = Between::new(&a.point, &b.point, step);
        let mut located = Vec::new();
        let passed = grazings(&a.measured.trace, &b.measured.trace);
        for extremum in &passed {
            let point = self.engine.locate(&a.point, &b.point, step, &mut distance_of(*extremum));
            match point {
                Err(CurveError::Exhausted(exhausted)) => return Err(exhausted.into()),
                Ok(Some(point)) => located.push((self.engine.distance(&a.point, &point), point, *extremum)),
                _ => unexplained.push("a contact grazed an edge"),
            }
        }
        let near = match &self.before {
            Some((length, before)) => grazing_dips([before, &a.values, &b.values], [*length, step]),
            None => Vec::new(),
        };
        for extremum in near.into_iter().filter(|extremum| !passed.contains(extremum)) {
            let test = &mut distance_of(extremum);
            let [Some(from), Some(to)] = [&a.point, &b.point].map(|point| test(&mut self.engine, point))
            else {
                continue;
            };
            match self.engine.locate_dip(&between, [[0.0, from], [step, to]], test) {
                Err(CurveError::Exhausted(exhausted)) => return Err(exhausted.into()),
                Err(_) => {} // the distance was not found everywhere; nothing shows that its sign changes
                Ok(points) => located.extend(points.into_iter().map(|point| {
                    let sigma = self.engine.distance(&a.point, &point);
                    (sigma, point, extremum)
                })),
            }
        }
        located.sort_by(|a, b| a.0.total_cmp(&b.0));
        let extremes: Vec<Extremum> = located.iter().map(|(.., extremum)| *extremum).collect();
        if unexplained.is_empty() && !explain_the_sequence(&extremes, &a.measured.trace, &b.measured.trace) {
            unexplained.push(SEQUENCE);
        }
        Ok(located)
    }
}

/// The distance of an extremum from its edge.
fn distance_of<C: OrbitMethod>(
    extremum: Extremum,
) -> impl FnMut(&mut Engine<C>, &CurvePoint<C::Solution>) -> Option<f64> {
    move |engine, point| {
        let measured = engine.curve.measure(point, &[]).ok()?;
        measured.trace.nearest(&extremum).map(|at| at.distance)
    }
}

impl<S: Clone> Node<S> {
    fn place(&self, sigma: f64) -> Place<S> {
        let (point, multipliers) = (self.point.clone(), self.multipliers.clone());
        Place { sigma, point, multipliers, grazes: false }
    }
}
