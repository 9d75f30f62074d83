//! Following a boundary.

use crate::branches::boundary::boundary_curve::{Boundary, BoundaryCurve};
use crate::branches::boundary::boundary_line::{BoundaryLine, BoundaryPoint, Turn};
use crate::branches::boundary::plane::{Plane, Slice};
use crate::branches::branch::{BranchEnd, BranchError, BranchNote};
use crate::branches::continuation::Continuation;
use crate::branches::curve::engine::{CurvePoint, Engine};
use crate::branches::curve::equations::CurveError;
use crate::branches::orbits::measure::measure;
use crate::branches::orbits::orbit_curve::{OrbitCurve, Passage};
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::branch_point::BranchPoint;
use crate::branches::points::kind::PointKind;
use crate::contact::piece::Piece;
use std::cell::Cell;
use std::rc::Rc;

/// Maximum angle by which a boundary may turn over a step `[rad]`. At a cusp the parameters turn back, the
/// orbits do not.
const TURN: f64 = 0.5;

/// Number of corrections up to which the next step is longer.
const FEW: usize = 8;

/// Angle below which the next step is longer `[rad]`.
const STRAIGHT: f64 = 0.2;

impl Continuation {
    /// Follows a located point of a branch over p (a fold, a period doubling, a Neimark-Sacker point or a grazing,
    /// the onset of contact loss among them) along a second parameter λ, from the start of this continuation
    /// towards its end. The point was located at λ = `from`.
    ///
    /// The line passes extremes of λ and cusps. It ends at a bound of λ or p, where the extremum of the contact or
    /// the pair of multipliers ceases to exist, or at the maximum of points. A closed line is not noticed.   Source: Govaerts (2000), Ch. 4 and 8;
    /// for grazing, Dercole & Kuznetsov, ACM Trans. Math. Softw. 31, 95 (2005).
    ///
    /// # Errors
    /// [`BranchError`]: settings out of range; a point of a kind that has no boundary; a point that does not lie
    /// on the boundary at λ = `from`.
    pub fn boundary(&self, plane: &dyn Plane, point: &BranchPoint) -> Result<BoundaryLine, BranchError> {
        self.check()?;
        let forward = self.boundary_one_way(plane, point, self.heading())?;
        if !self.is_both_ways() || matches!(forward.end, BranchEnd::Closed | BranchEnd::Exhausted(_)) {
            return Ok(forward);
        }
        match self.boundary_one_way(plane, point, -self.heading()) {
            Ok(back) => Ok(back.reversed_before(forward)),
            Err(_) => Ok(forward),
        }
    }

    fn boundary_one_way(
        &self,
        plane: &dyn Plane,
        point: &BranchPoint,
        heading: f64,
    ) -> Result<BoundaryLine, BranchError> {
        let across = self.across(point.parameter)?;
        let kind = point.kind.clone().ok_or(BranchError::NoPoint { what: "the point was not located" })?;
        let slice = Slice { plane, other: Cell::new(self.from) };
        let meter = Rc::new(self.budget.begin());
        let unit = if point.parameter == 0.0 { 1.0 } else { point.parameter.abs() };
        let p = point.parameter;
        let orbits = OrbitCurve::new(&slice, (p, unit), &point.orbit, &self.shooting, meter)?;
        let x = orbits.unknowns(&point.orbit);
        let model = orbits.model(p)?;
        let passage = orbits.pass(&*model, &x)?;
        drop(model);
        let measured = measure(&orbits, p, &passage, &[])?;
        let boundary = match &kind {
            PointKind::Fold => Boundary::Fold,
            PointKind::PeriodDoubling => Boundary::PeriodDoubling,
            PointKind::NeimarkSacker => Boundary::NeimarkSacker,
            PointKind::Grazing { contact, edge, .. } => {
                let lower = *edge == Piece::Lower;
                let of = measured.trace.extremes.iter().filter(|e| e.contact == *contact && e.lower == lower);
                let nearest = of.min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()));
                let none = BranchError::NoPoint { what: "the contact has no extremum at this edge" };
                Boundary::Grazing(*nearest.ok_or(none)?)
            }
            _ => {
                return Err(BranchError::NoPoint {
                    what: "points of this kind are followed in one parameter",
                });
            }
        };
        let range = measured.ranges.iter().take(measured.ranges.len() / 2).fold(0.0, |m: f64, r| m.max(*r));
        let sequence = boundary.sequence(&measured.trace);
        let other_unit = self.unit();
        let curve = BoundaryCurve { slice: &slice, orbits, boundary, unit, other_unit, range };
        let tolerance = self.shooting.correction_tolerance();
        let mut engine =
            Engine { curve, unit: other_unit, tolerance, max_corrections: 12, at_crossing: false };
        let n = x.len();
        let mut first = engine.start(x.insert_row(n, p), self.from)?;
        if heading < 0.0 {
            first.tangent.neg_mut();
        }
        let line = BoundaryLine {
            parameters: plane.parameters(),
            kind,
            points: Vec::new(),
            notes: Vec::new(),
            end: BranchEnd::Open,
        };
        let mut follower = Follower {
            settings: self,
            engine,
            last: first,
            step: self.first_step.min(self.max_step),
            across,
            sequence,
            line,
        };
        follower.keep(None)?;
        while follower.line.end == BranchEnd::Open {
            follower.advance();
        }
        Ok(follower.line)
    }
}

struct Follower<'f> {
    settings: &'f Continuation,
    engine: Engine<BoundaryCurve<'f>>,
    last: CurvePoint<Passage>,
    step: f64,
    /// Bounds of the first parameter.
    across: [f64; 2],
    /// Crossings of the last point, without those of the extremum of the boundary.
    sequence: Vec<[u32; 2]>,
    line: BoundaryLine,
}

impl Follower<'_> {
    /// Adds the last point, or another one, to the line.
    fn keep(&mut self, other: Option<(CurvePoint<Passage>, Turn)>) -> Result<(), CurveError> {
        let turn = other.as_ref().map(|(_, turn)| *turn);
        let point = other.map_or_else(|| self.last.clone(), |(point, _)| point);
        let n = point.x.len() - 1;
        let (x, p) = (point.x.rows(0, n).into_owned(), point.x[n]);
        self.engine.curve.slice.other.set(point.p);
        let at = CurvePoint { x, p, ..point.clone() };
        let (orbit, multipliers) = self.engine.curve.orbits.orbit(&at)?;
        self.line.points.push(BoundaryPoint { parameters: [p, point.p], turn, multipliers, orbit });
        Ok(())
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
        let slopes = [&self.last, &next].map(|point| [point.tangent[n], point.slope()]);
        if slopes[0][1] * slopes[1][1] < 0.0 {
            let turn = if slopes[0][0] * slopes[1][0] < 0.0 { Turn::Cusp } else { Turn::Extremum };
            if let Some(at) =
                self.engine.locate(&self.last, &next, step, &mut |_, point| Some(point.slope()))?
            {
                self.keep(Some((at, turn)))?;
            }
        }
        let (x, p) = (next.x.rows(0, n).into_owned(), next.x[n]);
        self.engine.curve.slice.other.set(next.p);
        let at = CurvePoint { x, p, ..next.clone() };
        let measured = self.engine.curve.orbits.measure(&at, &[])?;
        if let Boundary::Grazing(extremum) = &mut self.engine.curve.boundary {
            *extremum = *measured.trace.nearest(extremum).ok_or(CurveError::BoundaryEnds)?;
        }
        // The differences of the test functions make the corrections converge linearly.
        let sequence = self.engine.curve.boundary.sequence(&measured.trace);
        let changed = sequence != self.sequence;
        let parameters = [self.last.p, next.p];
        self.sequence = sequence;
        let few = next.corrections.len() <= FEW;
        self.engine.curve.unit = if p == 0.0 { self.engine.curve.unit } else { p.abs() };
        self.engine.curve.orbits.set_ranges(measured.ranges);
        self.engine.rescale(&mut next);
        if changed {
            self.line.notes.push(BranchNote { parameters, what: "the contact sequence changed".into() });
        }
        self.last = next;
        self.keep(None)?;
        if few && angle < STRAIGHT {
            self.step = (1.5 * self.step).min(self.settings.max_step);
        }
        if let Some(end) = end {
            self.line.end = end;
        }
        Ok(())
    }
}
