//! Rigid stops along a branch: its end at the grazing of a stop, and nodes that keep clear of impacts.

use crate::branches::branch::BranchEnd;
use crate::branches::curve::engine::CurvePoint;
use crate::branches::orbits::contact_trace::{ContactTrace, Extremum};
use crate::branches::orbits::measure::Measured;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::kind::PointKind;
use crate::branches::tracker::{Node, Tracker};

/// Each step covers this share of the estimated distance to the stop `[1]`. The point then stays on the side without
/// impacts.
const SHARE: f64 = 0.9;

/// Maximum number of steps towards the stop.
const STEPS: usize = 40;

/// Distance from the stop, as a share of the largest one along the orbit, at which the point grazes `[1]`.
const TOUCHES: f64 = 1e-13;

/// Largest distance of a grazing where rounding does not allow a smaller one `[1]`.
const NEARLY: f64 = 1e-10;

/// Maximum length of a step over which impacts may end, as a share of the maximum step `[1]`.
const SHORT: f64 = 1e-3;

/// First step from orbits without the impact towards the stop, as a share of the step that passed the grazing.
const TRIAL: f64 = 1e-3;

/// Least |dp/ds| at which nodes are moved: the sign of dp/ds shows the direction of the curve `[1]`.
pub(crate) const STEEP: f64 = 1e-3;

/// Which edges of each contact are rigid stops.
pub(crate) type Rigid = Vec<[bool; 2]>;

/// The extremes at rigid stops that are impacts (`past`), or those that do not reach their stop.
pub(crate) fn at_stops<'t>(
    rigid: &'t Rigid,
    trace: &'t ContactTrace,
    past: bool,
) -> impl Iterator<Item = &'t Extremum> {
    trace.extremes.iter().filter(move |e| {
        // A maximum at an upper stop, or a minimum at a lower one.
        let (edge, beyond) = if e.lower { (0, e.distance < 0.0) } else { (1, e.distance > 0.0) };
        rigid.get(e.contact).is_some_and(|rigid| rigid[edge]) && beyond == past && e.maximum != e.lower
    })
}

/// What became of the impacts over a step.
pub(crate) enum Impacts {
    /// Their number is the same.
    Same,
    /// It changed over a step that is too long to tell where.
    Unresolved,
    /// The branch ends at the grazing of this contact.
    End(usize),
}

impl<C: OrbitMethod> Tracker<'_, C> {
    /// If the step failed because a contact would strike a rigid stop, goes up to the stop and returns that end
    /// of the branch. Beyond it the equations have no solution near this one: their derivative is unbounded.
    pub(crate) fn approach_stop(&mut self) -> Option<BranchEnd> {
        let (length, before) = self.before.as_ref()?;
        let near = |e: &Extremum| {
            let like = before.extremes.iter().filter(|other| other.is_like(e));
            let old = like.min_by(|a, b| a.apart(e.phase).total_cmp(&b.apart(e.phase)))?;
            let rate = (e.distance - old.distance) / length;
            let left = -e.distance / rate;
            (left > 0.0 && left < self.step).then_some((*e, left))
        };
        let candidates = at_stops(&self.rigid, &self.last.measured.trace, false).filter_map(near);
        let (extremum, left) = candidates.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let (at, point, measured) = self.reach_stop(&self.last.point.clone(), &extremum, left)?;
        let rattle = [measured.rattle[extremum.contact]; 2];
        let kind = PointKind::Grazing { contact: extremum.contact, edge: extremum.edge(), rattle };
        let columns = self.columns(&point, measured, self.arclength + at, Some(kind)).ok()?;
        self.waiting.push_back(columns);
        Some(BranchEnd::Stop { contact: extremum.contact })
    }

    /// Compares the impacts of the last point and the next one. Where one of them ends, the branch of orbits with
    /// impacts ends as well: the grazing is located from the orbits without it.
    ///
    /// The equations are smooth up to the grazing as functions of the speed v of the impact, but a correction
    /// converges only if it changes v by less than v itself. The steps of the branch therefore decrease in
    /// proportion to v until one of them passes the grazing.
    pub(crate) fn impacts(&mut self, reached: &Node<C::Solution>, step: f64) -> Impacts {
        let count = |node: &Node<C::Solution>| at_stops(&self.rigid, &node.measured.trace, true).count();
        if self.rigid.is_empty() || count(reached) >= count(&self.last) {
            return Impacts::Same;
        }
        if step > SHORT * self.settings.max_step {
            return Impacts::Unresolved;
        }
        let free = at_stops(&self.rigid, &reached.measured.trace, false);
        let Some(extremum) = free.min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs())).copied()
        else {
            return Impacts::Same;
        };
        let Some((at, point, measured)) = self.reach_stop(&reached.point, &extremum, -TRIAL * step) else {
            return Impacts::Same;
        };
        let contact = extremum.contact;
        let rattle = [&self.last.measured, &reached.measured].map(|measured| measured.rattle[contact]);
        let kind = PointKind::Grazing { contact, edge: extremum.edge(), rattle };
        match self.columns(&point, measured, self.arclength + (step + at).max(0.0), Some(kind)) {
            Ok(columns) => self.waiting.push_back(columns),
            Err(_) => return Impacts::Same,
        }
        Impacts::End(contact)
    }

    /// The grazing of the extremum, from a point whose orbit does not reach the stop, with its distance from that
    /// point. `first`: the first step, with its sign.
    #[allow(clippy::type_complexity, reason = "distance, point and figures")]
    fn reach_stop(
        &mut self,
        base: &CurvePoint<C::Solution>,
        extremum: &Extremum,
        first: f64,
    ) -> Option<(f64, CurvePoint<C::Solution>, Measured)> {
        let (mut at, mut distance, mut left) = (0.0, extremum.distance, first / SHARE);
        let (mut reached, mut size) = (None, 0.0);
        for _ in 0..STEPS {
            let next = at + SHARE * left;
            let (x, p) = base.along(&base.tangent, next);
            let point = self.engine.correct(base, &base.tangent, next, x, p).ok()?;
            let measured = self.engine.curve.measure(&point, &self.branch.channels).ok()?;
            let now = measured.trace.nearest(extremum)?.distance;
            if now * extremum.distance <= 0.0 {
                break;
            }
            let same = measured.trace.extremes.iter().filter(|e| e.contact == extremum.contact);
            size = same.map(|e| e.distance.abs()).filter(|d| d.is_finite()).fold(0.0, f64::max);
            let rate = (now - distance) / (next - at);
            (at, distance, left) = (next, now, -now / rate);
            reached = Some((at, point, measured));
            if distance.abs() <= TOUCHES * size {
                break;
            }
        }
        reached.filter(|_| distance.abs() <= NEARLY * size)
    }

    /// Moves the nodes of the last point if an impact comes near one of them: there the state jumps.
    pub(crate) fn keep_clear_of_impacts(&mut self) {
        let impacts: Vec<f64> =
            at_stops(&self.rigid, &self.last.measured.trace, true).map(|e| e.phase).collect();
        if impacts.is_empty() || self.last.point.slope().abs() < STEEP {
            return;
        }
        let Some(shift) = self.engine.curve.clear_of(&impacts) else { return };
        let Ok(x) = self.engine.curve.shifted(&self.last.point, shift) else { return };
        let first = self.first.as_ref().and_then(|first| self.engine.curve.shifted(first, shift).ok());
        self.engine.curve.shift_nodes(shift, &x);
        let (p, slope) = (self.last.point.p, self.last.point.slope());
        let moved = self.engine.start(x, p).ok().and_then(|mut point| {
            if slope < 0.0 {
                point.turn_round();
            }
            let measured = self.engine.curve.measure(&point, &self.branch.channels).ok()?;
            let multipliers = self.engine.curve.multipliers(&point);
            Some(Node::new(point, measured, multipliers))
        });
        match moved {
            Some(node) => {
                (self.last, self.before) = (node, None);
                self.first = self.first.take().zip(first).map(|(point, x)| CurvePoint { x, ..point });
            }
            None => self.engine.curve.shift_nodes(-shift, &self.last.point.x),
        }
    }
}
