//! A line in progress: steps, bounds, ends.

use crate::branches::border::{Reference, longest_step};
use crate::branches::branch_end::BranchEnd;
use crate::branches::continuation::Continuation;
use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::CurveError;
use crate::branches::curve::locate::Between;
use crate::branches::curve::past::Past;
use crate::branches::curve::point::CurvePoint;
use crate::branches::following::Steps;
use crate::branches::line::{BranchNote, Line, LinePoint};
use crate::branches::orbits::contact_trace::Rigid;
use crate::branches::orbits::measured::Measured;
use crate::branches::orbits::orbit_method::Orbits;
use crate::branches::points::test_functions::Values;
use crate::branches::steps::node::Node;
use crate::branches::steps::place::Place;
use crate::error::ParameterError;
use crate::model::{Channel, Periodic};
use std::collections::VecDeque;

/// A curve with the points and the ends of its line: a branch or a boundary.
pub(crate) trait Followed: Orbits + Sized {
    /// The points of the line.
    type Point: LinePoint + Clone;
    /// What a located point is.
    type What;
    /// Number of corrections up to which the next step is longer.
    const FEW: usize;
    /// Number of regular points that wait until the next one [shows](Self::looking_back) what lies before
    /// them.
    const WAITING: usize;

    /// The channels that are measured.
    fn channels(head: &<Self::Point as LinePoint>::Head) -> &[Channel];
    /// The model of a point.
    fn model(&self, point: &CurvePoint<Self::Solution>) -> Result<Box<dyn Periodic + '_>, ParameterError>;
    /// The columns of a point.
    fn columns(
        &self,
        point: &CurvePoint<Self::Solution>,
        measured: Measured,
        arclength: f64,
        what: Option<Self::What>,
    ) -> Result<Self::Point, CurveError>;
    /// What lies between the last point and the next one.
    fn over(
        stepper: &mut Stepper<'_, Self>,
        reached: &Node<Self::Solution>,
        step: f64,
    ) -> Result<Over<Self::Point>, CurveError>;
    /// Located points of the last step that the next point shows. Default: none.
    fn looking_back(
        stepper: &mut Stepper<'_, Self>,
        reached: &Node<Self::Solution>,
        step: f64,
    ) -> Result<Vec<Self::Point>, CurveError> {
        let _ = (stepper, reached, step);
        Ok(Vec::new())
    }
    /// The border of parametric instability that the last point and the next one tend to, with motions of
    /// these sizes.
    fn border(
        stepper: &Stepper<'_, Self>,
        next: &CurvePoint<Self::Solution>,
        motions: [f64; 2],
    ) -> Option<f64>;
    /// Why the line ends at a point with these figures. Default: it goes on.
    fn end_at(&self, measured: &Measured) -> Option<BranchEnd> {
        let _ = measured;
        None
    }
    /// An end near the last point that explains why a step failed. Default: none.
    fn end_beside(stepper: &mut Stepper<'_, Self>) -> Option<BranchEnd> {
        let _ = stepper;
        None
    }
}

/// What lies between two points.
pub(crate) enum Over<P> {
    /// The line ends before the next point.
    Ends(BranchEnd),
    /// Located points, and what was not located.
    Passes(Vec<P>, Vec<&'static str>),
}

/// A line in progress, by any method.
pub(crate) struct Stepper<'f, C: Followed> {
    pub(crate) settings: &'f Continuation,
    pub(crate) engine: Engine<C>,
    pub(crate) line: Line<C::Point>,
    /// Bounds of the last unknown, if it is a parameter.
    across: Option<[f64; 2]>,
    /// The last regular point.
    pub(crate) last: Node<C::Solution>,
    /// The regular point before the last one.
    past: Option<Past>,
    /// How far the point of the last step was [off its prediction](Self::off_prediction).
    pub(crate) off_before: Option<f64>,
    /// Length of the last step and the values of the tests before it.
    pub(crate) before: Option<(f64, Values)>,
    /// The start of the last step, if nothing was located in it.
    pub(crate) back: Option<Place<C::Solution>>,
    /// Arclength and parameter of the last crossing of branches that was located.
    pub(crate) crossing: Option<[f64; 2]>,
    /// The first point, to notice a closed line.
    first: Option<CurvePoint<C::Solution>>,
    pub(crate) step: f64,
    pub(crate) arclength: f64,
    /// Points that are found and not yet yielded. A step begins with [`Followed::WAITING`] of them.
    pub(crate) waiting: VecDeque<C::Point>,
    /// Which edges of each contact are rigid stops.
    pub(crate) rigid: Rigid,
    /// What the size of a motion is compared with.
    pub(crate) reference: Reference,
}

/// Maximum angle by which the line may turn over a step `[rad]`.
const TURN: f64 = 0.5;

/// Angle below which the next step is longer `[rad]`.
const STRAIGHT: f64 = 0.2;

/// Length of a step below which an angle is that of a corner of the line `[1]`.
pub(crate) const CORNER: f64 = 1e-5;

/// Least number of points of a closed line.
const LOOP: usize = 8;

/// A line is closed if it comes back to its first point within this distance, in the units of the line `[1]`.
const SAME_POINT: f64 = 1e-6;

/// Least |dp/ds| at which nodes are moved: the sign of dp/ds shows the direction of the curve `[1]`.
const STEEP: f64 = 1e-3;

/// The point after a step.
struct Next<S> {
    point: CurvePoint<S>,
    /// Length of the step.
    step: f64,
    /// The angle by which the line turns `[rad]`.
    angle: f64,
    is_on_bound: bool,
}

impl<'f, C: Followed> Stepper<'f, C> {
    /// A line from its first point. `across`: bounds of the last unknown, if it is a parameter.
    pub(crate) fn new(
        settings: &'f Continuation,
        engine: Engine<C>,
        (point, measured): (CurvePoint<C::Solution>, Measured),
        head: <C::Point as LinePoint>::Head,
        (reference, rigid): (Reference, Rigid),
        across: Option<[f64; 2]>,
    ) -> Result<Self, CurveError> {
        let start = engine.curve.columns(&point, measured.clone(), 0.0, None)?;
        let multipliers = engine.curve.multipliers(&point);
        Ok(Stepper {
            settings,
            line: Line::new(head, point.slope()),
            across,
            first: Some(point.clone()),
            step: settings.first_step.min(settings.max_step),
            arclength: 0.0,
            waiting: VecDeque::from([start]),
            rigid,
            reference,
            past: None,
            off_before: None,
            before: None,
            back: None,
            crossing: None,
            last: Node::new(point, measured, multipliers),
            engine,
        })
    }

    pub(crate) fn measure(&self, point: &CurvePoint<C::Solution>) -> Result<Measured, CurveError> {
        self.engine.curve.measure(point, C::channels(&self.line.head))
    }

    /// The next point, on the bound that is reached first. `None` if the last point lies on that bound.
    fn next_on_curve(&mut self) -> Result<Option<Next<C::Solution>>, CurveError> {
        let (last, range) = (&self.last.point, self.settings.low_and_high());
        let past = self.past.as_ref().filter(|_| self.engine.curve.predicts_from_two_points());
        let outside = |value: f64, [low, high]: [f64; 2]| {
            (!(low..=high).contains(&value)).then(|| value.clamp(low, high))
        };
        let (_, ahead) = last.along(&last.tangent, self.step);
        let (point, step, mut is_on_bound) = match self.engine.advance(past, last, self.step) {
            // There may be no model beyond the bound.
            Err(error @ CurveError::Model { .. }) => {
                let Some(bound) = outside(ahead, range) else { return Err(error) };
                if bound == last.p {
                    return Ok(None);
                }
                let point = self.engine.at_bound(last, self.step, bound)?;
                let step = self.engine.distance(last, &point);
                (point, step, true)
            }
            point => (point?, self.step, false),
        };
        let (angle, turn) = (Engine::<C>::angle(last, &point), Engine::<C>::turn(last, &point));
        if turn > TURN && step > CORNER {
            return Err(CurveError::Turned { angle: turn, step });
        }
        let mut first: Option<(CurvePoint<C::Solution>, f64)> = None;
        let n = point.x.len();
        for (k, range) in self.across.map(|across| (n - 1, across)).into_iter().chain([(n, range)]) {
            let Some(bound) = outside(point.value(k), range) else { continue };
            if last.value(k) == bound {
                let inwards = (point.value(k) - bound) * last.tangent[k] < 0.0;
                // From a bound the line leads inside and turns back within the step.
                return if inwards { Err(CurveError::Turned { angle: turn, step }) } else { Ok(None) };
            }
            let mut beyond =
                |_: &mut Engine<C>, point: &CurvePoint<C::Solution>| Some(point.value(k) - bound);
            let Some(mut at) = self.engine.locate(last, &point, step, &mut beyond)? else { return Ok(None) };
            let distance = self.engine.distance(last, &at);
            *at.value_mut(k) = bound;
            if first.as_ref().is_none_or(|(_, least)| distance < *least) {
                first = Some((at, distance));
            }
        }
        is_on_bound |= first.is_some();
        let (point, step) = first.unwrap_or((point, step));
        Ok(Some(Next { point, step, angle, is_on_bound }))
    }

    /// Distance of a point at the end of a step from the cubic polynomial through the two points before it,
    /// in the units of the line; `None` after the first point.
    pub(crate) fn off_prediction(&self, point: &CurvePoint<C::Solution>, step: f64) -> Option<f64> {
        let (x, p) = self.past.as_ref()?.extrapolate(&self.last.point, step);
        Some((self.last.point.scaled_difference(point) - self.last.point.scaled(&x, p)).norm())
    }

    /// Makes one step: the next regular point and the located ones before it are put in the queue. Returns
    /// the end of the line, if it is reached.
    fn advance(&mut self) -> Result<Option<BranchEnd>, CurveError> {
        let Some(Next { point, step, angle, is_on_bound }) = self.next_on_curve()? else {
            return Ok(Some(BranchEnd::Bound));
        };
        let measured = self.measure(&point)?;
        let multipliers = self.engine.curve.multipliers(&point);
        let mut reached = Node::new(point, measured, multipliers);
        let (located, unexplained) = match C::over(self, &reached, step)? {
            Over::Ends(end) => return Ok(Some(end)),
            Over::Passes(located, unexplained) => (located, unexplained),
        };
        let (next, measured) = (&mut reached.point, &reached.measured);
        let columns = self.engine.curve.columns(next, measured.clone(), self.arclength + step, None)?;
        let [before, mut motion] =
            [&self.last.measured, measured].map(|measured| self.reference.motion(measured));
        let mut unbounded = None;
        if motion > self.settings.max_motion && motion > before && !is_on_bound {
            let border = C::border(self, next, [before, motion]);
            // A load or a gap that grows along the line has larger motions.
            if let (None, Ok(model)) = (border, self.engine.curve.model(next)) {
                self.reference = self.reference.raised(&*model, motion);
            }
            motion = self.reference.motion(measured);
            let is_large = border.is_some() || motion > self.settings.max_motion;
            unbounded = is_large.then_some(BranchEnd::Unbounded { motion, border });
        }
        let end = if is_on_bound {
            Some(BranchEnd::Bound)
        } else if let Some(end) = self.engine.curve.end_at(measured) {
            Some(end)
        } else if unbounded.is_some() {
            unbounded
        } else {
            self.closes(&reached.point, step)?.then_some(BranchEnd::Closed)
        };
        let seen_back = match C::looking_back(self, &reached, step) {
            Err(exhausted @ CurveError::Exhausted(_)) => return Err(exhausted),
            seen => seen.unwrap_or_default(), // a search that fails shows nothing
        };
        // From here on nothing fails: the step is not made again.
        let (next, measured) = (&mut reached.point, &reached.measured);
        let turned = "the branch turned by more than 0.5 rad over a shortest step";
        let notes = unexplained.into_iter().chain((angle > TURN).then_some(turned));
        let parameters = || Between::new(&self.last.point, next, step).parameters(next.p);
        let noted = notes.map(|what| BranchNote { parameters: parameters(), what: what.into() });
        self.line.notes.extend(noted);
        self.arclength += step;
        let few = next.corrections.len() <= C::FEW;
        self.engine.curve.accept(next, measured);
        self.engine.rescale(next);
        let is_plain = located.is_empty();
        seen_back.into_iter().rev().for_each(|point| self.waiting.push_front(point));
        self.waiting.extend(located);
        self.waiting.push_back(columns);
        self.line.heading = next.slope();
        self.off_before = self.off_prediction(&reached.point, step);
        self.past = Some(Past::new(&self.last.point));
        self.back = is_plain.then(|| self.last.place(0.0));
        self.before = Some((step, std::mem::replace(&mut self.last, reached).values));
        self.keep_clear_of_impacts();
        if few && angle < STRAIGHT {
            self.step = (1.5 * self.step).min(longest_step(self.settings.max_step, motion));
        } else if angle > STRAIGHT {
            self.step *= 0.7;
        }
        Ok(end)
    }

    /// Whether the line returns to its first point between the last point and the next one.
    fn closes(&mut self, next: &CurvePoint<C::Solution>, step: f64) -> Result<bool, CurveError> {
        let is_long = self.line.points.len() + self.waiting.len() >= LOOP;
        let last = &self.last.point;
        let Some(first) = self.first.as_ref().filter(|first| is_long && first.is_passed(last, next, step))
        else {
            return Ok(false);
        };
        // Another part of the line may pass beside its first point.
        let mut along = |engine: &mut Engine<C>, point: &CurvePoint<_>| Some(engine.distance(first, point));
        let at = self.engine.locate(last, next, step, &mut along)?;
        Ok(at.is_some_and(|at| first.scaled_difference(&at).norm() < SAME_POINT))
    }

    /// Moves the nodes of the last point if an impact comes near one of them: there the state jumps.
    fn keep_clear_of_impacts(&mut self) {
        let impacts: Vec<f64> =
            self.last.measured.trace.at_stops(&self.rigid, true).map(|e| e.phase).collect();
        let slope = self.last.point.slope();
        if impacts.is_empty() || slope.abs() < STEEP {
            return;
        }
        let Some(shift) = self.engine.curve.clear_of(&impacts) else { return };
        let Ok(x) = self.engine.curve.shifted(&self.last.point, shift) else { return };
        let first = self.first.take();
        let later = first.as_ref().and_then(|first| self.engine.curve.shifted(first, shift).ok());
        self.engine.curve.shift_nodes(shift, &x);
        let moved = self.engine.start_towards(x, self.last.point.p, slope).ok().and_then(|point| {
            let measured = self.measure(&point).ok()?;
            let multipliers = self.engine.curve.multipliers(&point);
            Some(Node::new(point, measured, multipliers))
        });
        let Some(node) = moved else {
            self.engine.curve.shift_nodes(-shift, &self.last.point.x);
            self.first = first;
            return;
        };
        self.last = node;
        self.before = self.before.take().map(|(length, values)| (length, values.later(shift)));
        self.back = None;
        self.first =
            first.zip(later).and_then(|(first, x)| self.engine.start_towards(x, first.p, first.slope()).ok());
    }
}

impl<C: Followed> Steps<C::Point> for Stepper<'_, C> {
    fn next_point(&mut self) -> Option<C::Point> {
        let limit = self.settings.max_points;
        while self.waiting.len() <= C::WAITING && self.line.end == BranchEnd::Open {
            if self.line.points.len() + self.waiting.len() >= limit {
                self.line.end = BranchEnd::Points { limit };
                break;
            }
            match self.advance() {
                Ok(end) => self.line.end = end.unwrap_or_default(),
                Err(CurveError::Exhausted(exhausted)) => self.line.end = BranchEnd::Exhausted(exhausted),
                Err(error) => {
                    if let Some(end) = C::end_beside(self) {
                        self.line.end = end;
                        break;
                    }
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
        let point = self.waiting.pop_front()?;
        self.line.points.push(point.clone());
        Some(point)
    }

    fn line(&self) -> &Line<C::Point> {
        &self.line
    }
    fn into_line(self: Box<Self>) -> Line<C::Point> {
        let Stepper { mut line, waiting, .. } = *self;
        line.points.extend(waiting);
        line
    }
    fn shift(&mut self, arclength: f64) {
        self.arclength += arclength;
        self.waiting.iter_mut().for_each(|point| point.set_arclength(point.arclength() + arclength));
    }
}
