//! The end of a branch at the grazing of a rigid stop.

use crate::branches::branch::BranchEnd;
use crate::branches::orbits::contact_trace::Extremum;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::kind::PointKind;
use crate::branches::tracker::Tracker;
use crate::model::offers::Offers;

/// Each step covers this share of the estimated distance to the stop `[1]`. The point then stays on the side without
/// impacts.
const SHARE: f64 = 0.9;

/// Maximum number of steps towards the stop.
const STEPS: usize = 40;

/// Distance from the stop, as a share of the first one, at which the point grazes `[1]`.
const TOUCHES: f64 = 1e-10;

impl<C: OrbitMethod> Tracker<'_, C> {
    /// If the step failed because a contact would strike a rigid stop, goes up to the stop and returns that end
    /// of the branch. Beyond it the equations have no solution near this one: their derivative is unbounded.
    pub(crate) fn approach_stop(&mut self) -> Option<BranchEnd> {
        let (length, before) = self.before.as_ref()?;
        let model = self.engine.curve.family().at(self.last.point.p).ok()?;
        let rigid = Offers::of(&*model).rigid_edges();
        drop(model);
        // A maximum below an upper stop, or a minimum above a lower one.
        let free = |e: &&Extremum| {
            let (edge, outside) = if e.lower { (0, e.distance > 0.0) } else { (1, e.distance < 0.0) };
            rigid.get(e.contact).is_some_and(|rigid| rigid[edge]) && outside && e.maximum != e.lower
        };
        let near = |e: &Extremum| {
            let like = before.extremes.iter().filter(|other| other.is_like(e));
            let old = like.min_by(|a, b| a.apart(e.phase).total_cmp(&b.apart(e.phase)))?;
            let rate = (e.distance - old.distance) / length;
            let left = -e.distance / rate;
            (left > 0.0 && left < self.step).then_some((*e, left))
        };
        let candidates = self.last.values.extremes.iter().filter(free).filter_map(near);
        let (first, mut left) = candidates.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let (mut at, mut distance) = (0.0, first.distance);
        let base = self.last.point.clone();
        let mut reached = None;
        for _ in 0..STEPS {
            let next = at + SHARE * left;
            let (x, p) = base.along(&base.tangent, next);
            let point = self.engine.correct(&base, &base.tangent, next, x, p).ok()?;
            let measured = self.engine.curve.measure(&point, &self.branch.channels).ok()?;
            let now = measured.trace.nearest(&first)?.distance;
            if now * first.distance <= 0.0 {
                return None;
            }
            let rate = (now - distance) / (next - at);
            (at, distance, left) = (next, now, -now / rate);
            reached = Some((point, measured));
            if distance.abs() <= TOUCHES * first.distance.abs() {
                break;
            }
        }
        if distance.abs() > TOUCHES * first.distance.abs() {
            return None;
        }
        let (point, measured) = reached?;
        let contact = first.contact;
        let rattle = [measured.rattle[contact]; 2];
        let kind = PointKind::Grazing { contact, edge: first.edge(), rattle };
        let columns = self.columns(&point, measured, self.arclength + at, Some(kind)).ok()?;
        self.waiting.push_back(columns);
        Some(BranchEnd::Stop { contact })
    }
}
