//! A continuation in progress: steps, location of points, ends.

use crate::branches::border::{Reference, border, longest_step};
use crate::branches::branch::{Branch, BranchHead};
use crate::branches::branch_end::BranchEnd;
use crate::branches::branch_error::BranchError;
use crate::branches::continuation::Continuation;
use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::{Curve, CurveError};
use crate::branches::curve::past::Past;
use crate::branches::curve::point::CurvePoint;
use crate::branches::following::Steps;
use crate::branches::line::{BranchNote, Line};
use crate::branches::orbits::contact_trace::Rigid;
use crate::branches::orbits::measure::{Measured, chosen_channels};
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::branch_point::BranchPoint;
use crate::branches::points::kind::Located;
use crate::branches::points::test_functions::Values;
use crate::periodic::multipliers::Multipliers;
use std::collections::VecDeque;

/// A continuation in progress, by any method.
pub(crate) struct Tracker<'f, C: OrbitMethod> {
    pub(crate) settings: &'f Continuation,
    pub(crate) engine: Engine<C>,
    pub(crate) branch: Branch<C::Orbit>,
    /// The last regular point.
    pub(crate) last: Node<C::Solution>,
    /// The regular point before the last one.
    past: Option<Past>,
    /// Length of the last step and the values of the tests before it.
    pub(crate) before: Option<(f64, Values)>,
    /// The first point, to notice a closed branch.
    pub(crate) first: Option<CurvePoint<C::Solution>>,
    pub(crate) step: f64,
    pub(crate) arclength: f64,
    /// Points that are found and not yet yielded.
    pub(crate) waiting: VecDeque<BranchPoint<C::Orbit>>,
    /// Which edges of each contact are rigid stops.
    pub(crate) rigid: Rigid,
    /// What the size of a motion is compared with.
    reference: Reference,
}

/// A point of the curve with what is measured along its orbit.
pub(crate) struct Node<S> {
    pub(crate) point: CurvePoint<S>,
    pub(crate) measured: Measured,
    pub(crate) multipliers: Option<Multipliers>,
    pub(crate) values: Values,
}

impl<S> Node<S> {
    pub(crate) fn new(point: CurvePoint<S>, measured: Measured, multipliers: Option<Multipliers>) -> Self {
        let values = Values::new(point.slope(), multipliers.as_ref(), &measured.trace);
        Node { point, measured, multipliers, values }
    }
}

/// Maximum angle by which the branch may turn over a step `[rad]`.
const TURN: f64 = 0.5;

/// Angle below which the next step is longer `[rad]`.
const STRAIGHT: f64 = 0.2;

/// Length of a step below which an angle is that of a corner of the branch `[1]`.
const CORNER: f64 = 1e-5;

/// Number of corrections up to which the next step is longer.
const FEW: usize = 6;

impl Continuation {
    /// Follows a curve from a point.
    pub(crate) fn follow<'f, C: OrbitMethod>(
        &'f self,
        mut engine: Engine<C>,
        mut point: CurvePoint<C::Solution>,
    ) -> Result<Tracker<'f, C>, BranchError> {
        let model = engine.curve.family().at(point.p)?;
        let channels = chosen_channels(self.channels.as_deref(), &*model)?;
        let rigid = model.offers().rigid_edges(model.contacts());
        let measured = engine.curve.measure(&point, &channels)?;
        let reference = Reference::new(&*model, &measured);
        drop(model);
        engine.curve.set_units(&measured);
        engine.rescale(&mut point);
        let head = BranchHead { parameter: engine.curve.family().parameter(), channels };
        let branch = Line::new(head, point.slope());
        let multipliers = engine.curve.multipliers(&point);
        let mut tracker = Tracker {
            settings: self,
            branch,
            first: Some(point.clone()),
            step: self.first_step.min(self.max_step),
            arclength: 0.0,
            waiting: VecDeque::new(),
            rigid,
            reference,
            past: None,
            before: None,
            last: Node::new(point, measured, multipliers),
            engine,
        };
        let start = tracker.columns(&tracker.last.point, tracker.last.measured.clone(), 0.0, None)?;
        tracker.waiting.push_back(start);
        Ok(tracker)
    }
}

/// Located points with their distance from the last point and what they are.
pub(crate) type Found<C> = Vec<(f64, CurvePoint<<C as Curve>::Solution>, Located)>;

/// Shortest step, as a share of the maximum step, to separate changes that are not explained `[1]`.
pub(crate) const SEPARATE: f64 = 1e-3;

/// What became of the impacts over a step.
pub(crate) enum Impacts {
    /// Their number is the same.
    Same,
    /// It changed over a step that is too long to tell where.
    Unresolved,
    /// The branch ends at the grazing of this contact.
    End(usize),
}

/// What became of an attempt to make a step.
enum Made {
    Step,
    End(BranchEnd),
    /// The step is too long, with the reason.
    Shorter(CurveError),
}

impl<C: OrbitMethod> Tracker<'_, C> {
    /// The columns of a point.
    pub(crate) fn columns(
        &self,
        point: &CurvePoint<C::Solution>,
        measured: Measured,
        arclength: f64,
        located: Option<Located>,
    ) -> Result<BranchPoint<C::Orbit>, CurveError> {
        let (orbit, multipliers) = self.engine.curve.orbit(point)?;
        Ok(BranchPoint {
            parameter: point.p,
            arclength,
            summaries: measured.summaries,
            rattle: measured.rattle,
            crossings: measured.trace.crossings,
            located,
            multipliers,
            orbit,
        })
    }

    /// The columns of located points.
    pub(crate) fn located(&self, found: Found<C>) -> Result<Vec<BranchPoint<C::Orbit>>, CurveError> {
        let columns = |(sigma, point, what): (f64, CurvePoint<C::Solution>, Located)| {
            let measured = self.measure(&point)?;
            self.columns(&point, measured, self.arclength + sigma, Some(what))
        };
        found.into_iter().map(columns).collect()
    }

    fn measure(&self, point: &CurvePoint<C::Solution>) -> Result<Measured, CurveError> {
        self.engine.curve.measure(point, &self.branch.head.channels)
    }

    /// Makes one step: the next regular point and the located ones before it are put in the queue.
    fn advance(&mut self) -> Result<Made, CurveError> {
        let mut step = self.step;
        let past = self.past.as_ref().filter(|_| self.engine.curve.predicts_from_two_points());
        let [low, high] = self.settings.low_and_high();
        let mut end = None;
        let (_, ahead) = self.last.point.along(&self.last.point.tangent, step);
        let mut next = match self.engine.advance(past, &self.last.point, step) {
            // There may be no model beyond the bound.
            Err(CurveError::Model { .. }) if !(low..=high).contains(&ahead) => {
                let bound = ahead.clamp(low, high);
                if bound == self.last.point.p {
                    return Ok(Made::End(BranchEnd::Bound));
                }
                let next = self.engine.at_bound(&self.last.point, step, bound)?;
                step = self.engine.distance(&self.last.point, &next);
                end = Some(BranchEnd::Bound);
                next
            }
            next => next?,
        };
        let angle = Engine::<C>::angle(&self.last.point, &next);
        if angle > TURN && step > CORNER {
            return Ok(Made::Shorter(CurveError::Turned { angle, step }));
        }
        if !(low..=high).contains(&next.p) {
            let bound = next.p.clamp(low, high);
            let mut beyond = |_: &mut Engine<C>, point: &CurvePoint<C::Solution>| Some(point.p - bound);
            match self.engine.locate(&self.last.point, &next, step, &mut beyond)? {
                Some(mut on_bound) => {
                    step = self.engine.distance(&self.last.point, &on_bound);
                    on_bound.p = bound;
                    next = on_bound;
                }
                None => next = self.last.point.clone(), // the last point lies on the bound
            }
            end = Some(BranchEnd::Bound);
            if next.p == self.last.point.p {
                return Ok(Made::End(BranchEnd::Bound));
            }
        }
        let measured = self.measure(&next)?;
        let multipliers = self.engine.curve.multipliers(&next);
        let reached = Node::new(next, measured, multipliers);
        match self.impacts(&reached, step) {
            Impacts::Same => {}
            Impacts::Unresolved => {
                return Ok(Made::Shorter(CurveError::Unexplained {
                    what: "impacts on a rigid stop began or ended",
                }));
            }
            Impacts::End(contact) => return Ok(Made::End(BranchEnd::Stop { contact })),
        }
        let (found, unexplained) = self.between(&reached, step)?;
        if let Some(what) = unexplained.first().filter(|_| step > SEPARATE * self.settings.max_step) {
            return Ok(Made::Shorter(CurveError::Unexplained { what }));
        }
        let leaves = found.iter().any(|(_, point, _)| !(low..=high).contains(&point.p));
        if leaves && step > CORNER {
            let what = "the branch left the range of the parameter and came back";
            return Ok(Made::Shorter(CurveError::Unexplained { what }));
        }
        let located = self.located(found)?;
        let Node { point: mut next, measured, multipliers, values } = reached;
        let closed = self.closes(&next, step);
        let few = next.corrections.len() <= FEW;
        let columns = self.columns(&next, measured.clone(), self.arclength + step, None)?;
        let [before, motion] =
            [&self.last.measured, &measured].map(|measured| self.reference.motion(measured));
        let motion = if motion > self.settings.max_motion && motion > before && end.is_none() {
            let border = self.border(&next, [before, motion]);
            // A load or a gap that grows along the branch has larger motions.
            if let (None, Ok(model)) = (border, self.engine.curve.family().at(next.p)) {
                self.reference = self.reference.raised(&*model, motion);
            }
            let motion = self.reference.motion(&measured);
            if border.is_some() || motion > self.settings.max_motion {
                end = Some(BranchEnd::Unbounded { motion, border });
            }
            motion
        } else {
            motion
        };
        // From here on nothing fails: the step is not made again.
        let parameters = [self.last.point.p, next.p];
        let note = |what: &str| BranchNote { parameters, what: what.into() };
        self.branch.notes.extend(unexplained.into_iter().map(note));
        if angle > TURN {
            self.branch.notes.push(note("the branch turned by more than 0.5 rad over a shortest step"));
        }
        self.arclength += step;
        self.engine.curve.set_units(&measured);
        self.engine.rescale(&mut next);
        self.waiting.extend(located);
        self.waiting.push_back(columns);
        self.branch.heading = next.slope();
        self.past = Some(Past::new(&self.last.point));
        let last = Node { point: next, measured, multipliers, values };
        self.before = Some((step, std::mem::replace(&mut self.last, last).values));
        self.keep_clear_of_impacts();
        if few && angle < STRAIGHT {
            self.step = (1.5 * self.step).min(longest_step(self.settings.max_step, motion));
        } else if angle > STRAIGHT {
            self.step *= 0.7;
        }
        Ok(match end {
            Some(end) => Made::End(end),
            None if closed => Made::End(BranchEnd::Closed),
            None => Made::Step,
        })
    }

    /// Compares the size of motions without the first orbit, which may be a large one.
    pub(crate) fn starts_anywhere(&mut self) -> Result<(), BranchError> {
        let model = self.engine.curve.family().at(self.last.point.p)?;
        self.reference = Reference::of_any_orbit(&*model, &self.last.measured);
        Ok(())
    }

    /// The border of parametric instability that the last point and `next` tend to, with motions of these sizes.
    fn border(&self, next: &CurvePoint<C::Solution>, [before, motion]: [f64; 2]) -> Option<f64> {
        let curve = &self.engine.curve;
        let (multiple, state) = curve.first_state(next)?;
        let border = border(
            curve.family(),
            next.p,
            self.engine.unit,
            multiple,
            (motion, &state),
            &self.settings.budget,
        )?;
        // Large motions grow as 1/(p - border).
        let expected = (next.p * motion - self.last.point.p * before) / (motion - before);
        ((border - expected).abs() < 0.5 * (border - next.p).abs()).then_some(border)
    }

    /// Whether the branch returns to its first point between the last point and the next one.
    fn closes(&self, next: &CurvePoint<C::Solution>, step: f64) -> bool {
        let far = self.branch.points.len() + self.waiting.len() >= 8;
        let first = self.first.as_ref().filter(|_| far);
        first.is_some_and(|first| first.is_passed(&self.last.point, next, step))
    }
}

impl<C: OrbitMethod> Steps<BranchPoint<C::Orbit>> for Tracker<'_, C> {
    fn next_point(&mut self) -> Option<BranchPoint<C::Orbit>> {
        let limit = self.settings.max_points;
        while self.waiting.is_empty() && self.branch.end == BranchEnd::Open {
            if self.branch.points.len() >= limit {
                self.branch.end = BranchEnd::Points { limit };
                break;
            }
            match self.advance() {
                Ok(Made::Step) => {}
                Ok(Made::End(end)) => self.branch.end = end,
                Err(CurveError::Exhausted(exhausted)) => self.branch.end = BranchEnd::Exhausted(exhausted),
                Ok(Made::Shorter(error)) | Err(error) => {
                    if let Some(end) = self.approach_stop() {
                        self.branch.end = end;
                        break;
                    }
                    self.step *= 0.5;
                    if self.step < self.settings.min_step {
                        self.branch.end = match error {
                            CurveError::Model { parameter, error } => BranchEnd::Model { parameter, error },
                            error => BranchEnd::StepUnderflow { step: self.step, error },
                        };
                    }
                }
            }
        }
        let point = self.waiting.pop_front()?;
        self.branch.points.push(point.clone());
        Some(point)
    }

    fn line(&self) -> &Branch<C::Orbit> {
        &self.branch
    }
    fn into_line(self: Box<Self>) -> Branch<C::Orbit> {
        let Tracker { mut branch, waiting, .. } = *self;
        branch.points.extend(waiting);
        branch
    }
    fn shift(&mut self, arclength: f64) {
        self.arclength += arclength;
        self.waiting.iter_mut().for_each(|point| point.arclength += arclength);
    }
}
