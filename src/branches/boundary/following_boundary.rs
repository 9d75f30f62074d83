//! A boundary in progress.

use crate::branches::border::{Reference, border, longest_step};
use crate::branches::boundary::boundary_curve::{Boundary, BoundaryCurve};
use crate::branches::boundary::boundary_line::{BoundaryLine, BoundaryPoint, Turn};
use crate::branches::boundary::grazed_stops::{GRAZES, SOFT, softest_impact};
use crate::branches::boundary::half_orbit::whole;
use crate::branches::branch_end::BranchEnd;
use crate::branches::continuation::Continuation;
use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::CurveError;
use crate::branches::curve::point::CurvePoint;
use crate::branches::following::Steps;
use crate::branches::line::BranchNote;
use crate::branches::orbits::by_shooting::orbit_curve::Passage;
use crate::branches::orbits::contact_trace::{ContactTrace, Extremum, Rigid};
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::stops::STEEP;
use std::collections::VecDeque;

/// Maximum angle by which a boundary may turn over a step `[rad]`. At a cusp the parameters turn back, the
/// orbits do not.
const TURN: f64 = 0.5;

/// Number of corrections up to which the next step is longer.
const FEW: usize = 8;

/// Angle below which the next step is longer `[rad]`.
const STRAIGHT: f64 = 0.2;

/// Largest |dp/ds| at a cusp `[1]`.
const TURNS: f64 = 1e-4;

/// Least number of points of a closed boundary.
const LOOP: usize = 8;

/// A boundary in progress.
pub(crate) struct FollowingBoundary<'f> {
    settings: &'f Continuation,
    engine: Engine<BoundaryCurve<'f>>,
    /// The first point, to notice a closed boundary.
    first: Option<CurvePoint<Passage>>,
    last: CurvePoint<Passage>,
    step: f64,
    arclength: f64,
    rigid: Rigid,
    /// What the size of a motion is compared with, and the size at the last point.
    size: (Reference, f64),
    /// Crossings of the last point, without those of the extremum of the boundary.
    sequence: Vec<[u32; 2]>,
    line: BoundaryLine,
    /// Points that are found and not yet yielded.
    waiting: VecDeque<BoundaryPoint>,
}

impl Steps<BoundaryPoint> for FollowingBoundary<'_> {
    fn next_point(&mut self) -> Option<BoundaryPoint> {
        while self.waiting.is_empty() && self.line.end == BranchEnd::Open {
            self.advance();
        }
        let point = self.waiting.pop_front()?;
        self.line.points.push(point.clone());
        Some(point)
    }
    fn line(&self) -> &BoundaryLine {
        &self.line
    }
    fn into_line(self: Box<Self>) -> BoundaryLine {
        let mut line = self.line;
        line.points.extend(self.waiting);
        line
    }
    fn shift(&mut self, arclength: f64) {
        self.arclength += arclength;
        self.waiting.iter_mut().for_each(|point| point.arclength += arclength);
    }
}

impl<'f> FollowingBoundary<'f> {
    pub(crate) fn new(
        settings: &'f Continuation,
        engine: Engine<BoundaryCurve<'f>>,
        first: CurvePoint<Passage>,
        rigid: Rigid,
        size: (Reference, f64),
        sequence: Vec<[u32; 2]>,
        line: BoundaryLine,
    ) -> Result<Self, CurveError> {
        let (last, step) = (first.clone(), settings.first_step.min(settings.max_step));
        let waiting = VecDeque::new();
        let mut following = FollowingBoundary {
            settings,
            engine,
            first: Some(first),
            last,
            step,
            arclength: 0.0,
            rigid,
            size,
            sequence,
            line,
            waiting,
        };
        let start = following.columns(&following.last, None, 0.0)?;
        following.waiting.push_back(start);
        Ok(following)
    }

    /// The point of the plane with its orbit.
    fn columns(
        &self,
        point: &CurvePoint<Passage>,
        turn: Option<Turn>,
        arclength: f64,
    ) -> Result<BoundaryPoint, CurveError> {
        let at = self.on_orbits(point);
        let orbits = &self.engine.curve.orbits;
        let (mut orbit, mut multipliers) = orbits.orbit(&at)?;
        if orbits.is_over_half() {
            (orbit, multipliers) = whole(orbit, &multipliers);
        }
        Ok(BoundaryPoint { parameters: [at.p, point.p], arclength, turn, multipliers, orbit })
    }

    /// The point as one of the orbits over p, at its λ.
    fn on_orbits(&self, point: &CurvePoint<Passage>) -> CurvePoint<Passage> {
        let n = point.x.len() - 1;
        self.engine.curve.slice.other.set(point.p);
        CurvePoint { x: point.x.rows(0, n).into_owned(), p: point.x[n], ..point.clone() }
    }

    fn advance(&mut self) {
        if self.line.points.len() >= self.settings.max_points {
            self.line.end = BranchEnd::Points { limit: self.settings.max_points };
            return;
        }
        match self.make_step() {
            Ok(()) => {}
            Err(CurveError::Exhausted(exhausted)) => self.line.end = BranchEnd::Exhausted(exhausted),
            Err(error) => {
                self.step *= 0.5;
                if self.step < self.settings.min_step {
                    self.line.end = match error {
                        CurveError::Model { parameter, error } => BranchEnd::Model { parameter, error },
                        CurveError::Strikes { contact } => BranchEnd::Stop { contact },
                        error => BranchEnd::StepUnderflow { step: self.step, error },
                    };
                }
            }
        }
    }

    /// The point after a step, with the length of the step and whether it lies on a bound. `None` if the last point
    /// lies on the bound already.
    fn next_point(&mut self) -> Result<Option<(CurvePoint<Passage>, f64, bool)>, CurveError> {
        let (step, n) = (self.step, self.last.x.len() - 1);
        let [low, high] = self.settings.low_and_high();
        let beyond = |value: f64, [low, high]: [f64; 2]| {
            (!(low..=high).contains(&value)).then(|| value.clamp(low, high))
        };
        let (_, ahead) = self.last.along(&self.last.tangent, step);
        let next = match self.engine.advance(None, &self.last, step) {
            // There may be no model beyond the bound.
            Err(CurveError::Model { .. }) if !(low..=high).contains(&ahead) => {
                let bound = ahead.clamp(low, high);
                if bound == self.last.p {
                    return Ok(None);
                }
                let next = self.engine.at_bound(&self.last, step, bound)?;
                let length = self.engine.distance(&self.last, &next);
                return Ok(Some((next, length, true)));
            }
            next => next?,
        };
        let bounds = [beyond(next.x[n], self.line.head.across), beyond(next.p, [low, high])];
        if bounds == [None, None] {
            return Ok(Some((next, step, false)));
        }
        // The bound that is reached first.
        let mut first: Option<(CurvePoint<Passage>, f64)> = None;
        for (k, bound) in bounds.into_iter().enumerate() {
            let Some(bound) = bound else { continue };
            if [self.last.x[n], self.last.p][k] == bound {
                return Ok(None);
            }
            let mut past = |_: &mut Engine<BoundaryCurve<'_>>, point: &CurvePoint<Passage>| {
                Some([point.x[n], point.p][k] - bound)
            };
            let Some(mut at) = self.engine.locate(&self.last, &next, step, &mut past)? else {
                return Ok(None);
            };
            *(if k == 0 { &mut at.x[n] } else { &mut at.p }) = bound;
            let length = self.engine.distance(&self.last, &at);
            if first.as_ref().is_none_or(|(_, least)| length < *least) {
                first = Some((at, length));
            }
        }
        Ok(first.map(|(at, length)| (at, length, true)))
    }

    /// Whether the orbits pass a stop that was left out.
    fn strikes(&self, trace: &ContactTrace) -> Option<usize> {
        let (left_out, range) = (self.engine.curve.slice.left_out.borrow(), self.engine.curve.range);
        let past = |e: &&Extremum| {
            let beyond = if e.lower { -e.distance } else { e.distance };
            e.maximum != e.lower && beyond > GRAZES * range && left_out.contains(&(e.contact, e.edge()))
        };
        trace.extremes.iter().find(past).map(|e| e.contact)
    }

    fn make_step(&mut self) -> Result<(), CurveError> {
        let Some((mut next, step, on_bound)) = self.next_point()? else {
            self.line.end = BranchEnd::Bound; // the last point lies on the bound
            return Ok(());
        };
        let mut end = on_bound.then_some(BranchEnd::Bound);
        let angle = Engine::<BoundaryCurve<'_>>::angle(&self.last, &next);
        if angle > TURN {
            return Err(CurveError::Turned { angle, step });
        }
        let turn = self.turn(&next, step)?;
        let at = self.on_orbits(&next);
        let measured = self.engine.curve.orbits.measure(&at, &[])?;
        if let Some(contact) = self.strikes(&measured.trace) {
            return Err(CurveError::Strikes { contact });
        }
        let mut boundary = self.engine.curve.boundary;
        if let Boundary::Grazing(extremum) = &mut boundary {
            *extremum = *measured.trace.nearest(extremum).ok_or(CurveError::BoundaryEnds)?;
        }
        let columns = self.columns(&next, None, self.arclength + step)?;
        // From here on nothing fails: the step is not made again.
        let points = self.line.points.len() + self.waiting.len();
        let first = self.first.as_ref().filter(|_| points >= LOOP);
        if end.is_none() && first.is_some_and(|first| first.is_passed(&self.last, &next, step)) {
            end = Some(BranchEnd::Closed);
        }
        let softest = softest_impact(&self.rigid, &measured.trace);
        if let Some((share, contact)) = softest.filter(|_| end.is_none())
            && share < SOFT
            && share < self.engine.curve.softest
        {
            end = Some(BranchEnd::SoftImpact { contact });
        }
        let motion = self.size.0.motion(&measured);
        if end.is_none() && motion > self.settings.max_motion && motion > self.size.1 {
            end = Some(BranchEnd::Unbounded { motion, border: self.border(&at, motion) });
        }
        self.size.1 = motion;
        let impacts: Vec<f64> = measured.trace.at_stops(&self.rigid, true).map(|e| e.phase).collect();
        let sequence = boundary.sequence(&measured.trace);
        if sequence != self.sequence {
            let parameters = [self.last.p, next.p];
            self.line.notes.push(BranchNote { parameters, what: "the contact sequence changed".into() });
        }
        self.sequence = sequence;
        self.waiting.extend(turn);
        self.waiting.push_back(columns);
        self.arclength += step;
        // The differences of the test functions make the corrections converge linearly.
        let few = next.corrections.len() <= FEW;
        let curve = &mut self.engine.curve;
        (curve.boundary, curve.softest) = (boundary, softest.map_or(1.0, |(share, _)| share));
        curve.unit = at.p.abs().max(curve.least_unit);
        curve.orbits.set_units(&measured);
        self.engine.rescale(&mut next);
        self.line.heading = next.slope();
        self.last = next;
        self.keep_clear_of_impacts(&impacts);
        if few && angle < STRAIGHT {
            self.step = (1.5 * self.step).min(longest_step(self.settings.max_step, motion));
        }
        if let Some(end) = end {
            self.line.end = end;
        }
        Ok(())
    }

    /// The border of parametric instability over p at the λ of a point.
    fn border(&self, at: &CurvePoint<Passage>, motion: f64) -> Option<f64> {
        let BoundaryCurve { slice, orbits, unit, .. } = &self.engine.curve;
        let (multiple, state) = orbits.first_state(at)?;
        border(&**slice, at.p, *unit, multiple, (motion, &state), &self.settings.budget)
    }

    /// Moves the nodes of the last point if an impact comes near one of them.
    fn keep_clear_of_impacts(&mut self, impacts: &[f64]) {
        let (n, slope) = (self.last.x.len() - 1, self.last.slope());
        if impacts.is_empty() || slope.abs() < STEEP {
            return;
        }
        let Some(shift) = self.engine.curve.orbits.clear_of(impacts) else { return };
        let later = |this: &Self, point: &CurvePoint<Passage>| {
            let x = this.engine.curve.orbits.shifted(&this.on_orbits(point), shift).ok()?;
            Some(x.insert_row(n, point.x[n]))
        };
        let Some(x) = later(self, &self.last) else { return };
        let first = self.first.take();
        let first_x = first.as_ref().and_then(|first| later(self, first));
        let before = self.engine.curve.boundary;
        let curve = &mut self.engine.curve;
        curve.orbits.shift_nodes(shift, &x);
        if let Boundary::Grazing(extremum) = &mut curve.boundary {
            extremum.phase = (extremum.phase - shift).rem_euclid(1.0);
        }
        let Ok(moved) = self.engine.start_towards(x, self.last.p, slope) else {
            self.engine.curve.boundary = before;
            self.engine.curve.orbits.shift_nodes(-shift, &self.last.x);
            self.first = first;
            return;
        };
        self.last = moved;
        self.first = first
            .zip(first_x)
            .and_then(|(first, x)| self.engine.start_towards(x, first.p, first.slope()).ok());
    }

    /// The turning point between the last point and `next`, if λ turns back.
    fn turn(&mut self, next: &CurvePoint<Passage>, step: f64) -> Result<Option<BoundaryPoint>, CurveError> {
        let n = next.x.len() - 1;
        let slopes = [&self.last, next].map(|point| [point.tangent[n], point.slope()]);
        if slopes[0][1] * slopes[1][1] >= 0.0 {
            return Ok(None);
        }
        let both = slopes[0][0] * slopes[1][0] < 0.0;
        let found = self.engine.locate(&self.last, next, step, &mut |_, point| Some(point.slope()))?;
        let columns = |at: CurvePoint<Passage>| {
            let along = self.arclength + self.engine.distance(&self.last, &at);
            // At a cusp p turns back at the same point.
            let turn = if both && at.tangent[n].abs() < TURNS { Turn::Cusp } else { Turn::Extremum };
            self.columns(&at, Some(turn), along)
        };
        found.map(columns).transpose()
    }
}
