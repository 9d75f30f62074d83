//! Certificates of periodic orbits.

use crate::certify::contraction::Defect;
use crate::certify::images::{Images, around, field};
use crate::certify::leg::{Event, Leg, Seen};
use crate::certify::multipliers::{Disc, stability};
use crate::certify::proposal::Proposal;
use crate::certify::stretch::Field;
use crate::certify::unproved::Unproved;
use crate::contact::Piece;
use crate::interval::number::Interval;
use crate::model::Periodic;
use crate::ode::Budget;
use crate::periodic::Stability;

/// A crossing of the certified orbit.
///
/// ```
/// use gear_dynamics::{certify::{CertifiedCrossing, Interval}, contact::Piece};
/// let crossing = CertifiedCrossing { contact: 0, to: Piece::Gap, time: Interval::new(1.0, 1.1)? };
/// assert!(crossing.time.contains(1.05));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CertifiedCrossing {
    /// Index of the contact, from 0.
    pub contact: usize,
    /// The piece that the contact enters; at a rigid stop the flank of the stop.
    pub to: Piece,
    /// The time of the crossing.
    pub time: Interval,
}

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
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Certificate {
    pub(super) proposal: Proposal,
    /// Half widths of the boxes.
    pub(super) radii: Vec<Vec<f64>>,
    pub(super) constants: Vec<(String, Interval)>,
    pub(super) period: Interval,
    pub(super) crossings: Vec<CertifiedCrossing>,
    pub(super) multipliers: Vec<Disc>,
}

impl Certificate {
    /// Times of the nodes at the centres of the boxes.
    pub fn times(&self) -> Vec<f64> {
        self.proposal.legs.iter().map(|leg| leg.start.middle()).collect()
    }
    /// The box of each node: coordinates, then velocities.
    pub fn states(&self) -> Vec<Vec<Interval>> {
        self.proposal.nodes.iter().zip(&self.radii).map(|(node, radii)| around(node, radii)).collect()
    }
    /// The largest half width of all boxes, in the units of the model.
    pub fn radius(&self) -> f64 {
        self.radii.iter().flatten().fold(0.0, |most, r| most.max(*r))
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

    /// Checks the certificate again for a model: encloses the motion of every box by its legs and proves the
    /// inclusion once more, without the search that found the boxes.
    ///
    /// # Errors
    /// What does not hold.
    pub fn check(&self, model: &dyn Periodic) -> Result<(), Unproved> {
        let field = self.field(model)?;
        self.prove(model, &field, &mut |_, _, _| {})
    }

    /// The proof once more. `seen` receives every stretch of the motion.
    pub(super) fn prove(
        &self,
        model: &dyn Periodic,
        field: &Field<'_>,
        seen: &mut Seen<'_>,
    ) -> Result<(), Unproved> {
        let differs = |what: &str| Unproved::Differs { what: what.into() };
        let legs = &self.proposal.legs;
        let turns = (self.period / field.drives.period()).middle().round();
        let own = field.drives.period() * turns;
        if legs.is_empty()
            || turns.is_nan()
            || turns < 1.0
            || !own.lies_in(self.period)
            || !self.is_closed(field, &model.offers().rigid_edges(model.contacts()))
        {
            return Err(differs("period, nodes or pieces"));
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
            return Err(differs("crossings"));
        }
        // Each disc of this certificate contains one of those that are proved: none counts for two.
        let multipliers = proved.multipliers();
        let same = self.multipliers.len() == multipliers.len()
            && self.multipliers.iter().zip(&multipliers).all(|(own, proved)| own.contains(proved));
        match self.multipliers.is_empty() || same {
            true => Ok(()),
            false => Err(differs("multipliers")),
        }
    }

    /// The equations of a model with the constants of the certificate.
    pub(super) fn field<'m>(&self, model: &'m dyn Periodic) -> Result<Field<'m>, Unproved> {
        let constants: Vec<(&str, Interval)> =
            self.constants.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        field(model, &constants)
    }

    /// Whether the legs follow one another in time and on their pieces, over one period.
    fn is_closed(&self, field: &Field<'_>, rigid: &[[bool; 2]]) -> bool {
        let Proposal { legs, nodes } = &self.proposal;
        let sizes = nodes.len() == legs.len()
            && self.radii.len() == legs.len()
            && nodes.iter().chain(&self.radii).all(|node| node.len() == 2 * field.n);
        let contacts = field.motion.tape.distances.len();
        let (first, last) = (&legs[0], &legs[legs.len() - 1]);
        let follows = |(leg, next): (&Leg, &Leg)| {
            let mut pieces = leg.pieces.clone();
            if let Some(event) = leg.event.filter(|event| !event.rebounds) {
                pieces[event.contact] = event.to;
            }
            pieces == next.pieces
        };
        // A contact that leaves the gap rebounds at a rigid stop, and nowhere else.
        let impacts = |leg: &Leg, event: Event| {
            let side = usize::from(event.to == Piece::Upper);
            let stop = rigid.get(event.contact).is_some_and(|sides| sides[side]);
            let enters = event.to != Piece::Gap;
            event.contact < contacts
                && leg.pieces.get(event.contact).is_some_and(|from| (*from == Piece::Gap) == enters)
                && event.rebounds == (stop && enters)
        };
        let in_time = legs.windows(2).all(|pair| pair[0].end == pair[1].start);
        sizes
            && in_time
            && self.radii.iter().flatten().all(|radius| *radius > 0.0 && radius.is_finite())
            && legs.iter().all(|leg| leg.pieces.len() == contacts)
            && legs.iter().all(|leg| leg.event.is_none_or(|event| impacts(leg, event)))
            && legs.iter().zip(legs.iter().cycle().skip(1)).all(follows)
            && first.start.low() == first.start.high()
            && (0.0..=2.0 * self.period.low()).contains(&first.start.low())
            && (first.start + self.period).lies_in(last.end)
    }
}
