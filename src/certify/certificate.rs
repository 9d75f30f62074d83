//! Certificates of periodic orbits.

use crate::certify::contraction::Newton;
use crate::certify::flow::field::Field;
use crate::certify::flow::image::image;
use crate::certify::flow::leg::{Event, Leg};
use crate::certify::multipliers::{Disc, discs, stability, within};
use crate::certify::proposal::Proposal;
use crate::certify::square::Square;
use crate::certify::unproved::Unproved;
use crate::contact::Piece;
use crate::interval::number::Interval;
use crate::model::Periodic;
use crate::periodic::{ShootingOrbit, Stability};

/// Order of the Taylor polynomials of a step.
const ORDER: usize = 24;

/// Half widths of the first boxes, and the largest ones that are tried, as shares of the range of motion
/// `[1]`.
const FIRST_RADIUS: f64 = 1e-13;
const LARGEST_RADIUS: f64 = 1e-3;

/// Largest number of Newton steps of the nodes before the proof, and number of widths that are tried.
const POLISHING: usize = 4;
const ATTEMPTS: usize = 8;

/// A correction below this share of the range needs no further one, since each squares the error `[1]`.
const POLISHED: f64 = 1e-10;

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
    /// The time of the crossing: the same interval for crossings that are not ordered.
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
    proposal: Proposal,
    /// Half widths of the boxes.
    radii: Vec<Vec<f64>>,
    constants: Vec<(String, Interval)>,
    period: Interval,
    crossings: Vec<CertifiedCrossing>,
    multipliers: Vec<Disc>,
}

impl Certificate {
    /// Times of the nodes at the centres of the boxes.
    pub fn times(&self) -> Vec<f64> {
        self.proposal.legs.iter().map(|leg| leg.start.middle()).collect()
    }
    /// The box of node `i`: coordinates, then velocities; [relative](Certificate::relative_to) ones if the
    /// model has a rigid motion.
    ///
    /// # Panics
    /// If `i` is not below the number of [`times`](Certificate::times).
    pub fn state(&self, i: usize) -> Vec<Interval> {
        let pairs = self.proposal.nodes[i].iter().zip(&self.radii[i]);
        pairs.map(|(m, r)| Interval::from(*m) + Interval::symmetric(*r)).collect()
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
        let constants: Vec<(&str, Interval)> =
            self.constants.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        let field = field(model, &constants, self.relative_to().is_some())?;
        let differs = |what: &str| Unproved::Differs { what: what.into() };
        let legs = &self.proposal.legs;
        let turns = (self.period / field.drives.period()).middle().round();
        let own = field.drives.period() * turns;
        if legs.is_empty()
            || turns.is_nan()
            || turns < 1.0
            || !own.lies_in(self.period)
            || !self.is_closed(&field, &model.offers().rigid_edges(model.contacts()))
        {
            return Err(differs("period, nodes or pieces"));
        }
        let images = prove(model, &field, &self.proposal, &self.radii)?;
        let bounds = images.bounds()?;
        let proved = images.inclusion(&bounds)?;
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

    /// Whether the legs follow one another in time and on their pieces, over one period.
    fn is_closed(&self, field: &Field<'_>, rigid: &[[bool; 2]]) -> bool {
        let Proposal { legs, nodes, relative_to } = &self.proposal;
        let sizes = nodes.len() == legs.len()
            && *relative_to == field.relative.as_ref().map(|relative| relative.root)
            && self.radii.len() == legs.len()
            && nodes.iter().chain(&self.radii).all(|node| node.len() == 2 * field.n);
        let contacts = field.motion.tape.distances.len();
        let (first, last) = (&legs[0], &legs[legs.len() - 1]);
        let follows = |(leg, next): (&Leg, &Leg)| leg.pieces_after() == next.pieces;
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
            && legs.iter().all(|leg| leg.events.iter().all(|event| impacts(leg, *event)))
            && legs.iter().zip(legs.iter().cycle().skip(1)).all(follows)
            && first.start.low() == first.start.high()
            && (first.start + self.period).lies_in(last.end)
    }
}

/// The equations of a model on intervals.
fn field<'m>(
    model: &'m dyn Periodic,
    constants: &[(&str, Interval)],
    relative: bool,
) -> Result<Field<'m>, Unproved> {
    let none = |what: &str| Unproved::NoEnclosure { what: what.into() };
    let expanded = model.offers().expansion.ok_or_else(|| none("a model that is no `Machine`"))?;
    let drives = expanded.enclosed(constants)?.ok_or_else(|| none("a model that is no `Machine`"))?;
    let tape = expanded.record(&|_| true).0;
    if let Some((place, what)) = tape.kink() {
        return Err(none(&format!("{what}, in {place},")));
    }
    let field = Field::new(tape, drives, ORDER, relative)?;
    let needed = field.motion.tape.needed();
    let period = field.drives.period();
    let inside = field.drive_series(Interval::from(1e-3 * period.middle()), 1e-3 * period.middle(), 2);
    let refused = inside
        .iter()
        .enumerate()
        .find_map(|(d, series)| needed[2 * field.n + d].then(|| series.refusal()).flatten());
    refused.map_or(Ok(field), |what| Err(none(what)))
}

/// A drive edge between the nodes of a leg: the drives have no series over it.
fn edge_within(model: &dyn Periodic, field: &Field<'_>, leg: &Leg) -> Option<f64> {
    let mut from = leg.start.high();
    // The first edge may be that of the node itself, found again by rounding.
    for _ in 0..2 {
        let edge = model.next_edge(from)?;
        let at = field.drives.edge(edge);
        if at.common(leg.start).is_none() {
            return (at.high() < leg.end.low()).then_some(edge);
        }
        from = edge.max(at.high()).next_up();
    }
    None
}

/// All images of a chain of boxes.
struct Images<'p> {
    proposal: &'p Proposal,
    radii: &'p [Vec<f64>],
    defects: Vec<Vec<Interval>>,
    slopes: Vec<Square>,
    crossings: Vec<CertifiedCrossing>,
}

fn prove<'p>(
    model: &dyn Periodic,
    field: &Field<'_>,
    proposal: &'p Proposal,
    radii: &'p [Vec<f64>],
) -> Result<Images<'p>, Unproved> {
    let count = proposal.legs.len();
    let (mut defects, mut slopes, mut crossings) = (Vec::new(), Vec::new(), Vec::new());
    for (i, leg) in proposal.legs.iter().enumerate() {
        if let Some(t) = edge_within(model, field, leg) {
            return Err(Unproved::Together { t, after: leg.end.middle() });
        }
        let m = &proposal.nodes[i];
        let x: Vec<Interval> =
            m.iter().zip(&radii[i]).map(|(m, r)| Interval::from(*m) + Interval::symmetric(*r)).collect();
        let image = image(field, leg, &x, m)?;
        let next = &proposal.nodes[(i + 1) % count];
        defects.push(image.middle.iter().zip(next).map(|(x, next)| *x - Interval::from(*next)).collect());
        slopes.push(image.slope);
        let of = |time: Interval| {
            leg.events.iter().map(move |event| CertifiedCrossing {
                contact: event.contact,
                to: event.to,
                time,
            })
        };
        crossings.extend(image.crossing.into_iter().flat_map(of));
    }
    Ok(Images { proposal, radii, defects, slopes, crossings })
}

impl Images<'_> {
    fn newton(&self) -> Newton<'_> {
        Newton::new(&self.defects, &self.slopes)
    }
    /// The half widths of the images of all boxes.
    fn bounds(&self) -> Result<Vec<Vec<f64>>, Unproved> {
        let newton = self.newton();
        let singular = |i: usize| Unproved::NotContracting {
            t: self.proposal.legs[i].start.middle(),
            needed: f64::INFINITY,
        };
        (0..self.slopes.len()).map(|i| newton.bound(i, self.radii).ok_or(singular(i))).collect()
    }
    /// The proof that the Newton operator maps the boxes into themselves.
    fn inclusion(self, bounds: &[Vec<f64>]) -> Result<Self, Unproved> {
        // A NaN counts as not proved.
        let ratio = |(bound, radius): (&f64, &f64)| {
            Some(bound / radius).filter(|x| !x.is_nan()).unwrap_or(f64::INFINITY)
        };
        let needed =
            |(bounds, radii): (&Vec<f64>, &Vec<f64>)| bounds.iter().zip(radii).map(ratio).fold(0.0, f64::max);
        let all = bounds.iter().zip(self.radii).map(needed).enumerate();
        let worst = all.fold((0, 0.0), |worst, node| if node.1 > worst.1 { node } else { worst });
        match worst.1 < 1.0 {
            true => Ok(self),
            false => Err(Unproved::NotContracting {
                t: self.proposal.legs[worst.0].start.middle(),
                needed: worst.1,
            }),
        }
    }
    fn multipliers(&self) -> Vec<Disc> {
        let turn = self.newton().turn_from(0);
        let apart = discs(&self.slopes, &turn).unwrap_or_default();
        // Multipliers that are not separated may still be bounded together.
        match apart.is_empty() || stability(&apart) == Stability::Undecided {
            true => within(&self.slopes).unwrap_or(apart),
            false => apart,
        }
    }
}

impl ShootingOrbit {
    /// Proves that the orbit exists: in small boxes around it there is exactly one periodic orbit of the
    /// model, it makes exactly these crossings, and its multipliers lie in these discs.
    ///
    /// # Errors
    /// [`Unproved`]: what could not be shown.
    pub fn certify(&self, model: &dyn Periodic) -> Result<Certificate, Unproved> {
        self.certify_with(model, &[])
    }

    /// [`certify`](ShootingOrbit::certify) for all values of some constants within intervals: for each of
    /// them there is exactly one orbit in the boxes.
    ///
    /// # Errors
    /// As there; a name that the model does not have.
    pub fn certify_with(
        &self,
        model: &dyn Periodic,
        constants: &[(&str, Interval)],
    ) -> Result<Certificate, Unproved> {
        let field = field(model, constants, self.multipliers().values().len() < 2 * model.dof())?;
        let range: Vec<f64> = match &field.relative {
            None => self.range().to_vec(),
            Some(relative) => self.range().chunks(model.dof()).flat_map(|r| relative.ranges(r)).collect(),
        };
        let range: Vec<f64> = range.iter().map(|r| r.max(f64::MIN_POSITIVE)).collect();
        let mut proposal = Proposal::along(self, model, &field, &range)?;
        let count = proposal.legs.len();
        let boxes = |share: f64| vec![range.iter().map(|r| share * r).collect::<Vec<f64>>(); count];
        for _ in 0..POLISHING {
            let radii = boxes(FIRST_RADIUS);
            let images = prove(model, &field, &proposal, &radii)?;
            let Some(corrections) = images.newton().corrections() else { break };
            let mut largest = 0.0f64;
            for (node, correction) in proposal.nodes.iter_mut().zip(&corrections) {
                for ((x, dx), range) in node.iter_mut().zip(correction).zip(&range) {
                    *x += dx;
                    largest = largest.max(dx.abs() / range);
                }
            }
            if largest <= POLISHED {
                break;
            }
        }
        let mut radii = boxes(FIRST_RADIUS);
        let mut failure = None;
        for _ in 0..ATTEMPTS {
            let images = prove(model, &field, &proposal, &radii)?;
            let bounds = images.bounds()?;
            match images.inclusion(&bounds) {
                Ok(proved) => {
                    let (crossings, multipliers) = (proved.crossings.clone(), proved.multipliers());
                    let constants =
                        constants.iter().map(|(name, value)| (name.to_string(), *value)).collect();
                    let period = field.drives.period() * self.period_multiple() as f64;
                    return Ok(Certificate { proposal, radii, constants, period, crossings, multipliers });
                }
                Err(error) => failure = Some(error),
            }
            let mut share = 0.0f64;
            for (radii, bounds) in radii.iter_mut().zip(&bounds) {
                for ((radius, bound), range) in radii.iter_mut().zip(bounds).zip(&range) {
                    *radius = (2.0 * bound).max(*radius);
                    share = share.max(*radius / range);
                }
            }
            if share.is_nan() || share > LARGEST_RADIUS {
                break;
            }
        }
        Err(failure.unwrap_or(Unproved::NotContracting { t: self.states()[0].t, needed: f64::INFINITY }))
    }
}
