//! The steps of a branch of orbits: located points within a step, impacts that begin or end.

use crate::branches::border::{Reference, border};
use crate::branches::branch::BranchHead;
use crate::branches::branch_end::BranchEnd;
use crate::branches::branch_error::BranchError;
use crate::branches::continuation::Continuation;
use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::{Curve, CurveError};
use crate::branches::curve::point::CurvePoint;
use crate::branches::orbits::measured::{Measured, chosen_channels};
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::branch_point::BranchPoint;
use crate::branches::points::kind::SpecialPoint;
use crate::branches::steps::node::Node;
use crate::branches::steps::stepper::{CORNER, Followed, Over, Stepper};
use crate::branches::steps::stops::Impacts;
use crate::error::ParameterError;
use crate::model::{Channel, Periodic};

/// Shortest step, as a share of the maximum step, to separate changes that are not explained `[1]`.
pub(crate) const SEPARATE: f64 = 1e-3;

/// Distance of a multiplier from 1 below which the direction of the curve is open: from such a point no step
/// goes on `[1]`.
const BESIDE_CROSSING: f64 = 1e-5;

/// Largest share of the distance of the multiplier at its start. Where a branch turns back at a crossing, the
/// distance falls with the square of the way, over several steps `[1]`.
const SUDDEN: f64 = 1e-3;

/// Whether a step ends so close to a point at which a multiplier is 1, from farther away. A step of another
/// length ends elsewhere.
fn comes_to_a_crossing<S>(last: &Node<S>, reached: &Node<S>) -> bool {
    let nearest = |node: &Node<S>| {
        let all = node.multipliers.as_ref()?.values().iter().map(|m| (m - 1.0).norm());
        all.reduce(f64::min)
    };
    let [Some(from), Some(to)] = [nearest(last), nearest(reached)] else { return false };
    to < BESIDE_CROSSING && to < SUDDEN * from
}

/// Located points with their distance from the last point and what they are.
pub(crate) type LocatedPoints<C> = Vec<(f64, CurvePoint<<C as Curve>::Solution>, SpecialPoint)>;

impl Continuation {
    /// Follows a branch from a point.
    pub(crate) fn follow<'f, C: OrbitMethod>(
        &'f self,
        mut engine: Engine<C>,
        mut point: CurvePoint<C::Solution>,
    ) -> Result<Stepper<'f, C>, BranchError> {
        let model = engine.curve.family().at([point.p])?;
        let channels = chosen_channels(self.channels.as_deref(), &*model)?;
        let rigid = model.offers().rigid_edges(model.contacts());
        let measured = engine.curve.measure(&point, &channels)?;
        let reference = Reference::new(&*model, &measured);
        drop(model);
        engine.curve.accept(&point, &measured);
        engine.rescale(&mut point);
        let [parameter] = engine.curve.family().parameters.clone();
        let head = BranchHead { parameter, channels };
        Ok(Stepper::new(self, engine, (point, measured), head, (reference, rigid), None)?)
    }
}

impl<C: OrbitMethod> Stepper<'_, C> {
    /// The columns of located points.
    pub(crate) fn located(&self, found: LocatedPoints<C>) -> Result<Vec<BranchPoint<C::Orbit>>, CurveError> {
        let columns = |(sigma, point, what): (f64, CurvePoint<C::Solution>, SpecialPoint)| {
            let measured = self.measure(&point)?;
            self.engine.curve.columns(&point, measured, self.arclength + sigma, Some(what))
        };
        found.into_iter().map(columns).collect()
    }

    /// Compares the size of motions without the first orbit, which may be a large one.
    pub(crate) fn starts_anywhere(&mut self) -> Result<(), BranchError> {
        let model = self.engine.curve.family().at([self.last.point.p])?;
        self.reference = Reference::of_any_orbit(&*model, &self.last.measured);
        Ok(())
    }
}

impl<C: OrbitMethod> Followed for C {
    type Point = BranchPoint<C::Orbit>;
    type What = SpecialPoint;
    const FEW: usize = 6;
    const WAITING: usize = 1;

    fn channels(head: &BranchHead) -> &[Channel] {
        &head.channels
    }

    fn model(&self, point: &CurvePoint<C::Solution>) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        self.family().at([point.p])
    }

    fn columns(
        &self,
        point: &CurvePoint<C::Solution>,
        measured: Measured,
        arclength: f64,
        located: Option<SpecialPoint>,
    ) -> Result<BranchPoint<C::Orbit>, CurveError> {
        let (orbit, multipliers) = self.orbit(point)?;
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

    fn over(
        stepper: &mut Stepper<'_, C>,
        reached: &Node<C::Solution>,
        step: f64,
    ) -> Result<Over<Self::Point>, CurveError> {
        let is_long = step > SEPARATE * stepper.settings.max_step;
        if is_long && comes_to_a_crossing(&stepper.last, reached) {
            return Err(CurveError::Unexplained { what: "the point lies beside a crossing or a fold" });
        }
        match stepper.impacts(reached, step) {
            Impacts::Same => {}
            Impacts::Unresolved => {
                return Err(CurveError::Unexplained { what: "impacts on a rigid stop began or ended" });
            }
            Impacts::End(contact) => return Ok(Over::Ends(BranchEnd::Stop { contact })),
        }
        let (found, unexplained) = stepper.between(reached, step)?;
        if let Some(what) = unexplained.first().filter(|_| is_long) {
            return Err(CurveError::Unexplained { what });
        }
        let [low, high] = stepper.settings.low_and_high();
        let leaves = found.iter().any(|(_, point, _)| !(low..=high).contains(&point.p));
        if leaves && step > CORNER {
            let what = "the branch left the range of the parameter and came back";
            return Err(CurveError::Unexplained { what });
        }
        Ok(Over::Passes(stepper.located(found)?, unexplained))
    }

    fn looking_back(
        stepper: &mut Stepper<'_, C>,
        reached: &Node<C::Solution>,
        step: f64,
    ) -> Result<Vec<Self::Point>, CurveError> {
        let start = stepper.before.as_ref().map_or(0.0, |(length, _)| -length);
        let found = stepper.looking_back(reached, step)?;
        stepper.located(found.into_iter().map(|(sigma, point, what)| (start + sigma, point, what)).collect())
    }

    fn border(
        stepper: &Stepper<'_, C>,
        next: &CurvePoint<C::Solution>,
        [before, motion]: [f64; 2],
    ) -> Option<f64> {
        let Engine { curve, unit, .. } = &stepper.engine;
        let (multiple, state) = curve.first_state(next)?;
        let budget = &stepper.settings.budget;
        let border = border(curve.family(), next.p, *unit, multiple, (motion, &state), budget)?;
        // Large motions grow as 1/(p - border).
        let expected = (next.p * motion - stepper.last.point.p * before) / (motion - before);
        ((border - expected).abs() < 0.5 * (border - next.p).abs()).then_some(border)
    }

    fn end_beside(stepper: &mut Stepper<'_, C>) -> Option<BranchEnd> {
        stepper.approach_stop()
    }
}
