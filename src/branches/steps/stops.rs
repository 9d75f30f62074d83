//! Rigid stops along a branch: its end at the grazing of a stop.

use crate::branches::branch_end::BranchEnd;
use crate::branches::curve::equations::Curve;
use crate::branches::curve::point::CurvePoint;
use crate::branches::orbits::contact_trace::Extremum;
use crate::branches::orbits::measured::Measured;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::kind::SpecialPoint;
use crate::branches::steps::node::Node;
use crate::branches::steps::stepper::{Followed, Stepper};

/// Each step covers this share of the estimated distance to the stop `[1]`. The point then stays on the side
/// without impacts.
const STEP_TO_STOP: f64 = 0.9;

/// Maximum number of steps towards the stop.
const STEPS: usize = 40;

/// Distance from the stop, as a share of the largest one along the orbit, at which the point grazes `[1]`.
const TOUCHES: f64 = 1e-13;

/// Distance from the stop of a point beside the grazing `[1]`.
const BESIDE: f64 = 1e-5;

/// Largest distance of a grazing where rounding does not allow a smaller one `[1]`.
const NEARLY: f64 = 1e-10;

/// Maximum length of a step over which impacts may end, as a share of the maximum step `[1]`.
const SHORT: f64 = 1e-3;

/// Distance of the phases of the same impact in neighbouring orbits `[1]`.
const SAME_IMPACT: f64 = 0.1;

/// Largest last correction of a point whose corrections do not pass a stop `[1]`.
const SOLVED: f64 = 1e-12;

/// First step from orbits without the impact towards the stop, as a share of the step that passed the
/// grazing.
const TRIAL: f64 = 1e-3;

/// What became of the impacts over a step.
pub(crate) enum Impacts {
    /// Their number is the same.
    Same,
    /// It changed over a step that is too long to tell where.
    Unresolved,
    /// The branch ends at the grazing of this contact.
    End(usize),
}

/// A point with its distance from another.
type Reached<C> = (f64, Node<<C as Curve>::Solution>);

impl<C: OrbitMethod> Stepper<'_, C> {
    /// If the step failed because a contact would strike a rigid stop, goes up to the stop and returns that
    /// end of the branch. Beyond it the equations have no solution near this one: their derivative is
    /// unbounded.
    pub(crate) fn approach_stop(&mut self) -> Option<BranchEnd> {
        let (length, before) = self.before.as_ref()?;
        let near = |e: &Extremum| {
            let like = before.extremes.iter().filter(|other| other.is_like(e));
            let old = like.min_by(|a, b| a.apart(e.phase).total_cmp(&b.apart(e.phase)))?;
            let rate = (e.distance - old.distance) / length;
            let left = -e.distance / rate;
            (left > 0.0 && left < self.step).then_some((*e, left))
        };
        let candidates = self.last.measured.trace.at_stops(&self.rigid, false).filter_map(near);
        let (extremum, left) = candidates.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let (beside, (at, node)) =
            self.reach_stop(&self.last.point.clone(), &extremum, STEP_TO_STOP * left)?;
        let mut located = Vec::new();
        if let Some((before, beside)) = beside {
            let (found, unexplained) = self.between(&beside, before).ok()?;
            if !unexplained.is_empty() {
                return None;
            }
            located = self.located(found).ok()?;
        }
        let rattle = [node.measured.rattle[extremum.contact]; 2];
        let grazing =
            SpecialPoint::Grazing { contact: extremum.contact, flank: extremum.edge.flank(), rattle };
        located.push(
            self.engine.curve.columns(&node.point, node.measured, self.arclength + at, Some(grazing)).ok()?,
        );
        self.waiting.extend(located);
        Some(BranchEnd::Stop { contact: extremum.contact })
    }

    /// Compares the impacts of the last point and the next one. Where an impact begins or ends, the branch
    /// ends: the grazing is located from the orbits without it.
    ///
    /// The equations are smooth up to the grazing as functions of the speed v of the impact, but a correction
    /// converges only if it changes v by less than v itself. The steps of a branch of orbits with impacts
    /// therefore decrease in proportion to v until one of them passes the grazing.
    pub(crate) fn impacts(&mut self, reached: &Node<C::Solution>, step: f64) -> Impacts {
        let count = |node: &Node<C::Solution>| node.measured.trace.at_stops(&self.rigid, true).count();
        let counts = [count(&self.last), count(reached)];
        if self.rigid.is_empty() || counts[0] == counts[1] {
            return Impacts::Same;
        }
        if step > SHORT * self.settings.max_step {
            return Impacts::Unresolved;
        }
        let leaves = counts[0] > counts[1];
        let [with, free] = if leaves { [&self.last, reached] } else { [reached, &self.last] };
        let [striking, without] = [&with.measured.trace, &free.measured.trace];
        // The impact that the other orbit lacks, and the extremum that replaces it.
        let alone = striking.at_stops(&self.rigid, true).filter(|e| {
            let same = without.at_stops(&self.rigid, true).filter(|other| other.is_like(e));
            same.map(|other| other.apart(e.phase)).fold(1.0, f64::min) > SAME_IMPACT
        });
        let replaced = |e: &Extremum| {
            let like = without.at_stops(&self.rigid, false).filter(|other| other.is_like(e));
            like.min_by(|a, b| a.apart(e.phase).total_cmp(&b.apart(e.phase))).copied()
        };
        let softest = alone.min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()));
        let Some(extremum) = softest.and_then(replaced) else { return Impacts::Unresolved };
        let (base, from, way) =
            if leaves { (&reached.point, step, -TRIAL) } else { (&self.last.point, 0.0, TRIAL) };
        let Some((_, (at, node))) = self.reach_stop(&base.clone(), &extremum, way * step) else {
            return Impacts::Unresolved;
        };
        let contact = extremum.contact;
        let rattle = [&self.last.measured, &reached.measured].map(|measured| measured.rattle[contact]);
        let grazing = SpecialPoint::Grazing { contact, flank: extremum.edge.flank(), rattle };
        match self.engine.curve.columns(
            &node.point,
            node.measured,
            self.arclength + (from + at).max(0.0),
            Some(grazing),
        ) {
            Ok(columns) => self.waiting.push_back(columns),
            Err(_) => return Impacts::Unresolved,
        }
        Impacts::End(contact)
    }

    /// The grazing of the extremum, from a point whose orbit does not reach the stop, with its distance from
    /// that point, and before it the last point beside it where rounding does not decide about an impact.
    /// `first`: the first step, with its sign.
    fn reach_stop(
        &mut self,
        base: &CurvePoint<C::Solution>,
        extremum: &Extremum,
        first: f64,
    ) -> Option<(Option<Reached<C>>, Reached<C>)> {
        let (mut at, mut distance, mut left) = (0.0, extremum.distance, first / STEP_TO_STOP);
        let (mut reached, mut beside, mut size) = (None, None, 0.0);
        let mut nearest: Option<CurvePoint<C::Solution>> = None;
        for _ in 0..STEPS {
            let step = STEP_TO_STOP * left;
            let far = self.engine.advance(None, base, at + step);
            let is_solved =
                |point: &CurvePoint<C::Solution>| point.corrections.last().is_none_or(|last| *last <= SOLVED);
            // A correction that passes the stop spoils the next ones. From the nearest point the prediction
            // errs by less than the distance that is left.
            let point = match (far, &nearest) {
                (Ok(point), _) if is_solved(&point) => Ok(point),
                (_, Some(nearest)) => self.engine.advance(None, nearest, step),
                (far, None) => far,
            };
            let Ok(point) = point else { break };
            let Ok(measured) = self.measure(&point) else { break };
            let Some(now) = measured.trace.nearest(extremum).map(|e| e.distance) else { break };
            if now * extremum.distance <= 0.0 {
                break;
            }
            size = measured.trace.reach[extremum.contact][extremum.edge as usize];
            let rate = (now - distance) / step;
            (at, distance, left) = (at + step, now, -now / rate);
            nearest = Some(point.clone());
            if distance.abs() > BESIDE * size {
                beside = Some((at, point.clone(), measured.clone()));
            }
            reached = Some((at, point, measured));
            if distance.abs() <= TOUCHES * size {
                break;
            }
        }
        let node = |(at, point, measured): (f64, CurvePoint<C::Solution>, Measured)| {
            let multipliers = self.engine.curve.multipliers(&point);
            (at, Node::new(point, measured, multipliers))
        };
        Some((beside.map(node), node(reached.filter(|_| distance.abs() <= NEARLY * size)?)))
    }
}
