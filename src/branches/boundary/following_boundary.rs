//! A boundary in progress.

use crate::branches::boundary::boundary_curve::{Boundary, BoundaryCurve};
use crate::branches::boundary::boundary_line::{BoundaryLine, BoundaryPoint, Turn};
use crate::branches::branch::{BranchEnd, BranchNote};
use crate::branches::continuation::Continuation;
use crate::branches::curve::engine::{CurvePoint, Engine};
use crate::branches::curve::equations::CurveError;
use crate::branches::orbits::by_shooting::orbit_curve::Passage;
use crate::branches::orbits::measure::Measured;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::stops::{Rigid, STEEP, at_stops};
use std::collections::VecDeque;

/// Maximum angle by which a boundary may turn over a step `[rad]`. At a cusp the parameters turn back, the
/// orbits do not.
const TURN: f64 = 0.5;

/// Number of corrections up to which the next step is longer.
const FEW: usize = 8;

/// Angle below which the next step is longer `[rad]`.
const STRAIGHT: f64 = 0.2;

/// Squared speed of an impact, over the square of the largest velocity, below which a boundary ends `[1]`.
const SOFT: f64 = 1e-6;

/// The least squared speed of an impact over the square of the largest velocity; 1 without impacts.
pub(crate) fn softest_impact(rigid: &Rigid, measured: &Measured) -> f64 {
    let largest = measured.ranges.iter().skip(measured.ranges.len() / 2).fold(0.0, |m: f64, r| m.max(*r));
    let squares = at_stops(rigid, &measured.trace, true).map(|e| e.distance.abs() / (largest * largest));
    squares.fold(1.0, f64::min)
}

/// Least number of points of a closed boundary.
const LOOP: usize = 8;

/// A boundary that yields its points one by one, from
/// [`Continuation::begin_boundary`](crate::branches::Continuation::begin_boundary).
///
/// ```
/// use gear_dynamics::branches::{BranchEnd, ByConstant, ByConstants, Continuation};
/// use gear_dynamics::{State, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[], &[0.05])?.parts()?.build("driver", 0.7)?;
/// let family = ByConstant::new(&pair, "speed")?;
/// let branch = Continuation::new(0.7, 0.85).run(&family, &[State::new(0.0, &[1.1], &[0.0])])?;
/// let plane = ByConstants::new(&pair, ["speed", "mesh damping"])?;
/// let range = Continuation::new(0.1, 0.12);
/// let mut following = range.begin_boundary(&plane, branch.of_kind("grazing")[0])?;
/// following.by_ref().take_while(|point| point.parameters[1] < 0.105).for_each(drop);
/// let first = following.into_line(); // stopped
/// let rest = range.resume_boundary(&plane, &first)?.finish();
/// assert_eq!((rest.points().last().ok_or("a point")?.parameters[1], rest.end()), (0.12, &BranchEnd::Bound));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct FollowingBoundary<'f> {
    settings: &'f Continuation,
    engine: Engine<BoundaryCurve<'f>>,
    /// The first point, to notice a closed boundary.
    first: Option<CurvePoint<Passage>>,
    last: CurvePoint<Passage>,
    step: f64,
    arclength: f64,
    /// Bounds of the first parameter.
    across: [f64; 2],
    rigid: Rigid,
    /// Crossings of the last point, without those of the extremum of the boundary.
    sequence: Vec<[u32; 2]>,
    line: BoundaryLine,
    /// Points that are found and not yet yielded.
    waiting: VecDeque<BoundaryPoint>,
}

impl Iterator for FollowingBoundary<'_> {
    type Item = BoundaryPoint;

    fn next(&mut self) -> Option<BoundaryPoint> {
        while self.waiting.is_empty() && self.line.end == BranchEnd::Open {
            self.advance();
        }
        let point = self.waiting.pop_front()?;
        self.line.points.push(point.clone());
        Some(point)
    }
}

impl<'f> FollowingBoundary<'f> {
    pub(crate) fn new(
        settings: &'f Continuation,
        engine: Engine<BoundaryCurve<'f>>,
        first: CurvePoint<Passage>,
        (across, rigid): ([f64; 2], Rigid),
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
            across,
            rigid,
            sequence,
            line,
            waiting,
        };
        let start = following.columns(&following.last, None, 0.0)?;
        following.waiting.push_back(start);
        Ok(following)
    }

    /// The boundary so far.
    pub fn line(&self) -> &BoundaryLine {
        &self.line
    }
    /// The boundary so far. [`Continuation::resume_boundary`](crate::branches::Continuation::resume_boundary)
    /// continues it.
    pub fn into_line(mut self) -> BoundaryLine {
        self.line.points.extend(self.waiting);
        self.line
    }
    /// Follows the boundary to its end.
    pub fn finish(mut self) -> BoundaryLine {
        while self.next().is_some() {}
        self.line
    }

    /// Adds to the arclength of all further points.
    pub(crate) fn shift(&mut self, arclength: f64) {
        self.arclength += arclength;
        self.waiting.iter_mut().for_each(|point| point.arclength += arclength);
    }

    /// The point of the plane with its orbit.
    fn columns(
        &self,
        point: &CurvePoint<Passage>,
        turn: Option<Turn>,
        arclength: f64,
    ) -> Result<BoundaryPoint, CurveError> {
        let at = self.on_orbits(point);
        let (orbit, multipliers) = self.engine.curve.orbits.orbit(&at)?;
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
                        error => BranchEnd::StepUnderflow { step: self.step, error },
                    };
                }
            }
        }
    }

    fn make_step(&mut self) -> Result<(), CurveError> {
        let mut step = self.step;
        let mut next = self.engine.advance(None, &self.last, step)?;
        let angle = Engine::<BoundaryCurve<'_>>::angle(&self.last, &next);
        if angle > TURN {
            return Err(CurveError::Turned { angle, step });
        }
        let n = next.x.len() - 1;
        let beyond = |value: f64, [low, high]: [f64; 2]| {
            (!(low..=high).contains(&value)).then(|| value.clamp(low, high))
        };
        let mut end = None;
        let bounds = [beyond(next.x[n], self.across), beyond(next.p, self.settings.low_and_high())];
        if bounds != [None, None] {
            let mut past = |_: &mut Engine<BoundaryCurve<'_>>, point: &CurvePoint<Passage>| {
                let [p, other] = [(bounds[0], point.x[n]), (bounds[1], point.p)];
                other.0.map(|bound| other.1 - bound).or(p.0.map(|bound| p.1 - bound))
            };
            let found = self.engine.locate(&self.last, &next, step, &mut past)?;
            end = Some(BranchEnd::Bound);
            let Some(on_bound) = found else {
                self.line.end = BranchEnd::Bound; // the last point lies on the bound
                return Ok(());
            };
            step = self.engine.distance(&self.last, &on_bound);
            next = on_bound;
            if let Some(bound) = bounds[1] {
                next.p = bound;
            } else if let Some(bound) = bounds[0] {
                next.x[n] = bound;
            }
        }
        let turn = self.turn(&next, step)?;
        let at = self.on_orbits(&next);
        let measured = self.engine.curve.orbits.measure(&at, &[])?;
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
        let softest = softest_impact(&self.rigid, &measured);
        if end.is_none() && softest < SOFT && softest < self.engine.curve.softest {
            let contact = at_stops(&self.rigid, &measured.trace, true).next().map_or(0, |e| e.contact);
            end = Some(BranchEnd::Stop { contact });
        }
        let impacts: Vec<f64> = at_stops(&self.rigid, &measured.trace, true).map(|e| e.phase).collect();
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
        (curve.boundary, curve.softest) = (boundary, softest);
        curve.unit = at.p.abs().max(curve.least_unit);
        curve.orbits.set_ranges(measured.ranges);
        self.engine.rescale(&mut next);
        self.line.heading = next.slope();
        self.last = next;
        self.keep_clear_of_impacts(&impacts);
        if few && angle < STRAIGHT {
            self.step = (1.5 * self.step).min(self.settings.max_step);
        }
        if let Some(end) = end {
            self.line.end = end;
        }
        Ok(())
    }

    /// Moves the nodes of the last point if an impact comes near one of them.
    fn keep_clear_of_impacts(&mut self, impacts: &[f64]) {
        let (n, slope) = (self.last.x.len() - 1, self.last.slope());
        if impacts.is_empty() || slope.abs() < STEEP {
            return;
        }
        let Some(shift) = self.engine.curve.orbits.clear_of(impacts) else { return };
        let Ok(x) = self.engine.curve.orbits.shifted(&self.on_orbits(&self.last), shift) else { return };
        let curve = &mut self.engine.curve;
        curve.orbits.shift_nodes(shift, &x);
        let before = curve.boundary;
        if let Boundary::Grazing(extremum) = &mut curve.boundary {
            extremum.phase = (extremum.phase - shift).rem_euclid(1.0);
        }
        match self.engine.start(x.insert_row(n, self.last.x[n]), self.last.p) {
            Ok(mut moved) => {
                if slope < 0.0 {
                    moved.turn_round();
                }
                (self.last, self.first) = (moved, None);
            }
            Err(_) => {
                let curve = &mut self.engine.curve;
                curve.boundary = before;
                curve.orbits.shift_nodes(-shift, &self.last.x);
            }
        }
    }

    /// The turning point between the last point and `next`, if λ turns back.
    fn turn(&mut self, next: &CurvePoint<Passage>, step: f64) -> Result<Option<BoundaryPoint>, CurveError> {
        let n = next.x.len() - 1;
        let slopes = [&self.last, next].map(|point| [point.tangent[n], point.slope()]);
        if slopes[0][1] * slopes[1][1] >= 0.0 {
            return Ok(None);
        }
        let turn = if slopes[0][0] * slopes[1][0] < 0.0 { Turn::Cusp } else { Turn::Extremum };
        let found = self.engine.locate(&self.last, next, step, &mut |_, point| Some(point.slope()))?;
        let columns = |at: CurvePoint<Passage>| {
            let along = self.arclength + self.engine.distance(&self.last, &at);
            self.columns(&at, Some(turn), along)
        };
        found.map(columns).transpose()
    }
}
