//! Grazings within a step.

use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::CurveError;
use crate::branches::curve::locate::Between;
use crate::branches::curve::point::CurvePoint;
use crate::branches::orbits::contact_trace::{ContactTrace, Extremum, NEAR};
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::orbits::sorted_extremes::SortedExtremes;
use crate::branches::points::detect::{SEQUENCE, explain_the_sequence, passed};
use crate::branches::points::test_functions::grazing_dips;

/// A place within a step with the extremes of its orbit.
#[derive(Clone)]
pub(crate) struct Traced {
    /// Distance from the start of the step.
    pub(crate) sigma: f64,
    pub(crate) trace: ContactTrace,
}

/// A located grazing at its distance from the start of the step.
pub(crate) type Grazed<S> = (f64, CurvePoint<S>, Extremum);

/// The search for grazings within one step.
pub(crate) struct Grazings<'w, 'p, C: OrbitMethod> {
    engine: &'w mut Engine<C>,
    between: &'w Between<'p, C::Solution>,
    pub(crate) found: Vec<Grazed<C::Solution>>,
    /// What was not explained or located.
    pub(crate) unexplained: Vec<&'static str>,
}

/// How often a part is halved until its extremes explain the contact sequence.
const MAX_HALVINGS: usize = 12;

/// Distance by which an extremum may move over a distance 1 of the curve, as a share of the largest extremum
/// `[1]`.
const REACH: f64 = 4.0;

/// Accuracy of the place at which extremes vanish, as a share of the step `[1]`.
const VANISHED: f64 = 1e-3;

/// Longest part beside an orbit that nearly turns at an edge, as a share of the step `[1]`.
const FLAT: f64 = 0.2;

/// Distance of two grazings that happen at the same time, as a share of the step `[1]`.
pub(super) const SAME_TIME: f64 = 1e-9;

impl<'w, 'p, C: OrbitMethod> Grazings<'w, 'p, C> {
    pub(crate) fn new(engine: &'w mut Engine<C>, between: &'w Between<'p, C::Solution>) -> Self {
        Grazings { engine, between, found: Vec::new(), unexplained: Vec::new() }
    }

    fn at(&mut self, sigma: f64) -> Result<Traced, CurveError> {
        let point = self.engine.point_at(self.between, sigma)?;
        Ok(Traced { sigma, trace: self.engine.curve.measure(&point, &[])?.trace })
    }

    /// Searches a step between the traces of its ends. `before`: length of the step before it and the
    /// extremes at its start.
    pub(crate) fn search(
        &mut self,
        before: Option<(f64, &[Extremum])>,
        a: &ContactTrace,
        b: &ContactTrace,
        step: f64,
    ) -> Result<(), CurveError> {
        let mut places = vec![Traced { sigma: 0.0, trace: a.clone() }];
        let ends = [(0.0, a), (step, b)].map(|(sigma, trace)| Traced { sigma, trace: trace.clone() });
        let [a, b] = ends;
        self.divide(&a, b, [VANISHED, FLAT].map(|share| share * step), &mut places)?;
        for two in places.windows(2) {
            let found = self.found.len();
            self.search_apart(&two[0], &two[1], SAME_TIME * step)?;
            let is_explained = explain_the_sequence(
                self.found[found..].iter().map(|(.., extremum)| extremum),
                &two[0].trace,
                &two[1].trace,
            );
            if !is_explained && self.unexplained.is_empty() {
                self.unexplained.push(SEQUENCE);
            }
        }
        // A grazing bends what the other extremes do: its orbit divides a part.
        let grazed: Vec<(f64, Extremum)> = self.found.iter().map(|(sigma, _, e)| (*sigma, *e)).collect();
        for (sigma, point, _) in &self.found {
            places.push(Traced { sigma: *sigma, trace: self.engine.curve.measure(point, &[])?.trace });
        }
        places.sort_by(|a, b| a.sigma.total_cmp(&b.sigma));
        places.dedup_by(|a, b| a.sigma - b.sigma <= SAME_TIME * step);
        let grazes = |place: &Traced, extremum: &Extremum| {
            let here = grazed.iter().filter(|(sigma, _)| (sigma - place.sigma).abs() <= SAME_TIME * step);
            here.into_iter().any(|(_, e)| e.is_like(extremum) && e.apart(extremum.phase) < NEAR)
        };
        // Extremes that pass their edge twice within a part.
        let first = before.map(|(length, extremes)| (-length, extremes));
        let after = places.iter().map(|place| (place.sigma, place.trace.extremes.as_slice()));
        let all: Vec<(f64, &[Extremum])> = first.into_iter().chain(after).collect();
        for (k, two) in places.windows(2).enumerate() {
            let i = k + usize::from(before.is_some());
            let triples =
                [i.checked_sub(1).map(|h| [h, i, i + 1]), (i + 2 < all.len()).then_some([i + 2, i + 1, i])];
            let mut near: Vec<Extremum> = Vec::new();
            for [h, i, j] in triples.into_iter().flatten() {
                let steps = [(all[i].0 - all[h].0).abs(), (all[j].0 - all[i].0).abs()];
                for extremum in grazing_dips([all[h].1, all[i].1, all[j].1], steps) {
                    if near.iter().all(|e| !e.is_like(&extremum) || e.apart(extremum.phase) > NEAR) {
                        near.push(extremum);
                    }
                }
            }
            near.retain(|extremum| two.iter().all(|place| !grazes(place, extremum)));
            for extremum in near {
                self.search_dip(extremum, &two[0], &two[1])?;
            }
        }
        self.found.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(())
    }

    /// Appends places up to `b` between which no extremum near an edge vanishes or appears, except over
    /// distances below the first of `least`. Where an orbit nearly turns beside an edge, extremes may appear
    /// and vanish again: there the distances are below the second one.
    fn divide(
        &mut self,
        a: &Traced,
        b: Traced,
        least: [f64; 2],
        places: &mut Vec<Traced>,
    ) -> Result<(), CurveError> {
        let part = b.sigma - a.sigma;
        let traces = [&a.trace, &b.trace];
        if (part > least[0] && one_vanishes(traces, part)) || (part > least[1] && one_is_flat(traces, part)) {
            let middle = self.at(0.5 * (a.sigma + b.sigma))?;
            self.divide(a, middle.clone(), least, places)?;
            return self.divide(&middle, b, least, places);
        }
        places.push(b);
        Ok(())
    }

    /// Locates the grazings of a part. Two grazings may hide two others, whose changes of the sequence cancel
    /// each other: places between the grazings that are found divide the part until no more are found.
    fn search_apart(&mut self, a: &Traced, b: &Traced, same: f64) -> Result<(), CurveError> {
        let (first, left) = (self.found.len(), self.unexplained.len());
        self.search_part(a, b, MAX_HALVINGS)?;
        loop {
            let mut sigmas: Vec<f64> = self.found[first..].iter().map(|(sigma, ..)| *sigma).collect();
            sigmas.sort_by(f64::total_cmp);
            sigmas.dedup_by(|after, before| *after - *before <= same);
            if sigmas.len() < 2 || self.unexplained.len() > left {
                return Ok(());
            }
            let mut places = vec![a.clone()];
            for two in sigmas.windows(2) {
                places.push(self.at(0.5 * (two[0] + two[1]))?);
            }
            places.push(b.clone());
            let known = self.found.split_off(first);
            for two in places.windows(2) {
                self.search_part(&two[0], &two[1], MAX_HALVINGS)?;
            }
            if self.found.len() - first <= known.len() {
                self.found.truncate(first);
                self.found.extend(known);
                self.unexplained.truncate(left);
                return Ok(());
            }
        }
    }

    /// Locates the grazings that explain the contact sequences at both ends of a part.
    fn search_part(&mut self, a: &Traced, b: &Traced, left: usize) -> Result<(), CurveError> {
        let passed = passed(&a.trace, &b.trace);
        if !explain_the_sequence(passed.iter().map(|[_, after]| after), &a.trace, &b.trace) && left > 0 {
            return self.search_halves(a, b, left - 1);
        }
        let mut located = Vec::new();
        for [before, after] in passed {
            let ends = [[a.sigma, before.distance], [b.sigma, after.distance]];
            match self.engine.locate_between(self.between, ends, &mut distance_of(after)) {
                Err(CurveError::Exhausted(exhausted)) => return Err(exhausted.into()),
                Ok(Some(point)) => located.push((point, after)),
                // The extremum of the other orbit is another one.
                _ if left > 0 => return self.search_halves(a, b, left - 1),
                _ => self.unexplained.push("a contact grazed an edge"),
            }
        }
        located.into_iter().for_each(|(point, after)| self.keep(point, after));
        Ok(())
    }

    fn search_halves(&mut self, a: &Traced, b: &Traced, left: usize) -> Result<(), CurveError> {
        let middle = self.at(0.5 * (a.sigma + b.sigma))?;
        self.search_part(a, &middle, left)?;
        self.search_part(&middle, b, left)
    }

    fn search_dip(&mut self, extremum: Extremum, a: &Traced, b: &Traced) -> Result<(), CurveError> {
        let [Some(from), Some(to)] = [a, b].map(|at| at.trace.nearest(&extremum)) else { return Ok(()) };
        if from.distance * to.distance <= 0.0 {
            return Ok(());
        }
        let [from, to] = [[a.sigma, from.distance], [b.sigma, to.distance]];
        let test = &mut distance_of(extremum);
        let inside = match self.engine.dip_between(self.between, [from, to], None, test) {
            Err(CurveError::Exhausted(exhausted)) => return Err(exhausted.into()),
            Err(_) | Ok(None) => return Ok(()), // nothing shows that the sign of the distance changes
            Ok(Some(inside)) => inside,
        };
        for ends in [[from, inside], [inside, to]] {
            match self.engine.locate_between(self.between, ends, test) {
                Err(CurveError::Exhausted(exhausted)) => return Err(exhausted.into()),
                Ok(Some(point)) => self.keep(point, extremum),
                _ => self.unexplained.push("a contact grazed an edge"),
            }
        }
        Ok(())
    }

    fn keep(&mut self, point: CurvePoint<C::Solution>, extremum: Extremum) {
        self.found.push((self.engine.distance(self.between.start(), &point), point, extremum));
    }
}

/// Whether one of two orbits has an extremum near its edge that vanishes in the other orbit. `part`: distance
/// of the two orbits.
fn one_vanishes(orbits: [&ContactTrace; 2], part: f64) -> bool {
    let [a, b] = orbits.map(|orbit| SortedExtremes::of(&orbit.extremes));
    [(&a, &b), (&b, &a)].into_iter().zip(orbits).any(|((own, other), orbit)| {
        let is_near = near_an_edge(orbit, part);
        orbit.extremes.iter().any(|e| is_near(e) && other.same(e, own).is_none())
    })
}

/// Whether a contact in one of two orbits comes close to turning back near an edge of its gap.
fn one_is_flat(orbits: [&ContactTrace; 2], part: f64) -> bool {
    orbits.into_iter().any(|orbit| orbit.flats.iter().any(near_an_edge(orbit, part)))
}

/// Whether an extremum of an orbit may reach its edge within the distance `part`.
fn near_an_edge(orbit: &ContactTrace, part: f64) -> impl Fn(&Extremum) -> bool {
    let farthest: Vec<f64> = (0..orbit.crossings.len()).map(|contact| orbit.farthest(contact)).collect();
    move |e| e.distance.abs() < REACH * part * farthest[e.contact]
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
