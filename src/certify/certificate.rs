//! Certificates of periodic orbits.

use crate::certify::chain::proposal::Proposal;
use crate::certify::contraction::Defect;
use crate::certify::flow::field::Field;
use crate::certify::flow::leg::{Leg, LegCrossing};
use crate::certify::flow::part::Seen;
use crate::certify::images::{CertifiedCrossing, Images, around, field};
use crate::certify::multipliers::{Disc, stability};
use crate::certify::unproved::Unproved;
use crate::contact::Piece;
use crate::contact::edge::Edge;
use crate::interval::number::Interval;
use crate::model::Periodic;
use crate::ode::Budget;
use crate::periodic::Stability;
use std::fmt;

/// A proof that a periodic orbit exists. The page [certificates](crate::guide::certificates) has the theorem
/// and its assumptions.
///
/// In the product of the boxes there is exactly one periodic orbit of the model with this sequence of
/// crossings.
///
/// ```
/// use gear_dynamics::{periodic::Stability, trains::SpurPair, Shooting, State};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.85)?;
/// let orbit = Shooting::new().solve(&pair, &State::new(0.0, &[1.17], &[0.017]))?;
/// let certificate = orbit.certify(&pair)?;
/// assert!(certificate.radius() < 1e-12 && certificate.crossings().is_empty());
/// assert_eq!(certificate.stability(), Stability::Stable);
/// assert!(certificate.to_string().starts_with("orbit of period 7.391982714"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Certificate {
    pub(crate) proposal: Proposal,
    /// Half widths of the boxes.
    pub(crate) radii: Vec<Vec<f64>>,
    pub(crate) constants: Vec<(String, Interval)>,
    pub(crate) period: Interval,
    pub(crate) crossings: Vec<CertifiedCrossing>,
    pub(crate) multipliers: Vec<Disc>,
}

impl fmt::Display for Certificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (period, radius) = (self.period.middle(), self.radius());
        let (count, stability) = (self.crossings.len(), self.stability());
        write!(f, "orbit of period {period:?} within {radius:.1e}, {count} crossings, {stability}")
    }
}

impl Certificate {
    /// Times of the nodes at the centres of the boxes.
    pub fn times(&self) -> Vec<f64> {
        self.proposal.legs.iter().map(|leg| leg.start.middle()).collect()
    }
    /// The box of each node: coordinates, then velocities; [relative](Certificate::relative_to)
    /// ones if the model has a rigid motion.
    pub fn states(&self) -> Vec<Vec<Interval>> {
        self.proposal.nodes.iter().zip(&self.radii).map(|(node, radii)| around(node, radii)).collect()
    }
    /// If the model has a rigid motion r, the coordinate k to which all others are relative: the boxes
    /// contain q_i - (r_i/r_k) q_k for i ≠ k, and their rates. The orbit closes up to the rigid motion.
    pub fn relative_to(&self) -> Option<usize> {
        self.proposal.relative_to
    }
    /// The largest half width of all boxes, in the units of the model.
    pub fn radius(&self) -> f64 {
        self.radii.iter().flatten().fold(0.0, |most, r| most.max(*r))
    }
    /// The constants that the proof takes as intervals, in place of those of the model.
    pub fn constants(&self) -> &[(String, Interval)] {
        &self.constants
    }
    /// The period of the orbit.
    pub fn period(&self) -> Interval {
        self.period
    }
    /// All crossings in one period of the orbit, in the order of time.
    pub fn crossings(&self) -> &[CertifiedCrossing] {
        &self.crossings
    }
    /// Discs that contain the Floquet multipliers; empty if they could not be enclosed.
    pub fn multipliers(&self) -> &[Disc] {
        &self.multipliers
    }
    /// Stable if all multipliers are proved to lie inside the unit circle, unstable if one is proved to lie
    /// outside, otherwise undecided.
    pub fn stability(&self) -> Stability {
        if self.multipliers.is_empty() { Stability::Undecided } else { stability(&self.multipliers) }
    }

    /// Checks the certificate again for a model, with its own [constants](Certificate::constants) in place of
    /// those of the model: encloses the motion of every box by its legs and proves the
    /// inclusion once more, without the search that found the boxes. It needs no budget: it encloses each leg
    /// once.
    ///
    /// # Errors
    /// What does not hold. [`Unproved::Differs`] names what contradicts the model or the rest of the
    /// certificate.
    pub fn check(&self, model: &dyn Periodic) -> Result<(), Unproved> {
        let field = self.field(model)?;
        self.prove(model, &field, &mut |_| {})
    }

    /// Proves the inclusion once more. `seen` receives every enclosed part of the motion.
    pub(crate) fn prove(
        &self,
        model: &dyn Periodic,
        field: &Field<'_>,
        seen: &mut Seen<'_>,
    ) -> Result<(), Unproved> {
        let differs = |what: &str| Unproved::Differs { what: what.into() };
        let rigid = model.offers().rigid_edges(model.contacts());
        if let Some(what) = self.contradiction(field, &rigid) {
            return Err(differs(what));
        }
        let budget = Budget::new();
        let meter = budget.begin();
        let proved = Images::new(model, field, &self.proposal, &self.radii, &meter, seen)?;
        proved.inclusion(&proved.bounds(Defect::Whole)?)?;
        let agree = self.crossings.len() == proved.crossings.len()
            && self.crossings.iter().zip(&proved.crossings).all(|(own, proved)| {
                (own.contact, own.to) == (proved.contact, proved.to) && proved.time.lies_in(own.time)
            });
        if !agree {
            return Err(differs("the crossings"));
        }
        // Each disc of this certificate contains one of those that are proved: none counts for two.
        let multipliers = proved.multipliers();
        let same = self.multipliers.len() == multipliers.len()
            && self.multipliers.iter().zip(&multipliers).all(|(own, proved)| own.contains(proved));
        match self.multipliers.is_empty() || same {
            true => Ok(()),
            false => Err(differs("the multipliers")),
        }
    }

    /// The equations of a model with the constants of the certificate.
    pub(crate) fn field<'m>(&self, model: &'m dyn Periodic) -> Result<Field<'m>, Unproved> {
        let constants: Vec<(&str, Interval)> =
            self.constants.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        field(model, &constants, self.relative_to().is_some())
    }

    /// What contradicts the model or the rest, if anything does: the legs follow one another in time and on
    /// their pieces, over one period. The checks are made in this order, since one relies on those before it.
    fn contradiction(&self, field: &Field<'_>, rigid: &[[bool; 2]]) -> Option<&'static str> {
        let Proposal { legs, nodes, relative_to } = &self.proposal;
        let (contacts, width) = (field.motion.tape.distances.len(), 2 * field.n);
        // A contact stands on a flank that it has, and not beyond a rigid stop.
        let stands = |(contact, piece): (usize, &Piece)| {
            Edge::of(*piece).is_none_or(|edge| {
                field.motion.tape.distances[contact][edge as usize].is_some() && !edge.is_stop(rigid, contact)
            })
        };
        // A contact that leaves the gap rebounds at a rigid stop, and nowhere else.
        let crosses = |leg: &Leg, crossing: &LegCrossing| {
            let flank = Edge::of(crossing.to);
            let leaves_gap = leg.pieces.get(crossing.contact).map(|from| *from == Piece::Gap);
            leaves_gap == Some(flank.is_some())
                && crossing.rebounds == flank.is_some_and(|edge| edge.is_stop(rigid, crossing.contact))
        };
        let checks: [(&str, &dyn Fn() -> bool); 9] = [
            ("the multiples of the period", &|| {
                let turns = (self.period / field.drives.period()).middle().round();
                turns >= 1.0 && (field.drives.period() * turns).lies_in(self.period)
            }),
            ("the numbers of legs, nodes and half widths", &|| {
                let mut all = nodes.iter().chain(&self.radii);
                !legs.is_empty()
                    && [nodes.len(), self.radii.len()] == [legs.len(); 2]
                    && all.all(|node| node.len() == width)
            }),
            ("the coordinates to which others are relative", &|| {
                *relative_to == field.relative.as_ref().map(|relative| relative.root)
            }),
            ("the half widths of the boxes", &|| {
                self.radii.iter().flatten().all(|radius| *radius > 0.0 && radius.is_finite())
            }),
            ("the pieces of the contacts", &|| {
                legs.iter()
                    .all(|leg| leg.pieces.len() == contacts && leg.pieces.iter().enumerate().all(stands))
            }),
            ("the crossings on the legs", &|| {
                legs.iter().all(|leg| leg.crossings.iter().all(|crossing| crosses(leg, crossing)))
            }),
            ("the pieces of legs that follow each other", &|| {
                let mut pairs = legs.iter().zip(legs.iter().cycle().skip(1));
                pairs.all(|(leg, next)| leg.pieces_after() == next.pieces)
            }),
            ("the times of legs that follow each other", &|| {
                legs.windows(2).all(|pair| pair[0].end == pair[1].start)
            }),
            ("the times of the first and the last node", &|| {
                let (start, end) = (legs[0].start, legs[legs.len() - 1].end);
                start.low() == start.high()
                    && (0.0..=2.0 * self.period.low()).contains(&start.low())
                    && (start + self.period).lies_in(end)
            }),
        ];
        checks.iter().find(|(_, holds)| !holds()).map(|(what, _)| *what)
    }
}
