//! The images of a chain of boxes, and what they prove.

use crate::certify::chain::proposal::Proposal;
use crate::certify::contraction::{Defect, Newton};
use crate::certify::flow::field::Field;
use crate::certify::flow::image::image;
use crate::certify::flow::leg::Leg;
use crate::certify::flow::part::Seen;
use crate::certify::multipliers::{Disc, discs, stability, within};
use crate::certify::square::Square;
use crate::certify::unproved::Unproved;
use crate::contact::Piece;
use crate::interval::number::Interval;
use crate::model::Periodic;
use crate::ode::budget::Meter;
use crate::periodic::Stability;

/// Order of the Taylor polynomials of a step.
const ORDER: usize = 20;

/// Largest number of drive edges that are looked at for a leg, some of them found twice by rounding.
const MOST_EDGES: usize = 64;

/// The model does not look for edges so close behind a time, as a share of a period `[1]`.
const NEAR: f64 = 1e-12;

/// The equations of a model on intervals.
pub(crate) fn field<'m>(
    model: &'m dyn Periodic,
    constants: &[(&str, Interval)],
    relative: bool,
) -> Result<Field<'m>, Unproved> {
    let none = |what: &str| Unproved::NoEnclosure { what: what.into() };
    let expanded = model.offers().expansion.ok_or_else(|| none("a model that is not a `Machine`"))?;
    let drives = expanded.enclosed(constants)?.ok_or_else(|| none("a model that is not a `Machine`"))?;
    let tape = expanded.record(&|_| true).0;
    if let Some((place, what)) = tape.kink() {
        return Err(none(&format!("{what}, in {place}")));
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

/// A drive edge that may lie between the nodes of a leg, over which the drives have no series. An edge whose
/// enclosure lies in that of a node is the node.
fn edge_within(model: &dyn Periodic, field: &Field<'_>, leg: &Leg, turn_ends: Interval) -> Option<f64> {
    // The model finds its edges at its own constants, those of the proof may differ and be intervals: begin
    // so early that no edge of the leg is passed over. Times are not negative.
    let start = leg.start.low();
    let reach = 2.0 * (field.drives.edge(start) - Interval::from(start)).magnitude();
    let mut from = start - reach - NEAR * field.drives.period().magnitude();
    // Each node stands for one edge at most, and the end of the turn for none.
    let mut of_nodes: [Option<Interval>; 2] = [None, (leg.end == turn_ends).then_some(Interval::LINE)];
    for _ in 0..MOST_EDGES {
        let edge = model.next_edge(from)?;
        let at = field.drives.edge(edge);
        if at.low() >= leg.end.high() {
            return None;
        }
        if at.high() > start {
            let node = [leg.start, leg.end].iter().position(|node| at.lies_in(*node));
            let Some(node) = node else { return Some(edge) };
            match of_nodes[node] {
                Some(other) if other.common(at).is_none() || !other.is_bounded() => return Some(edge),
                _ => of_nodes[node] = Some(at),
            }
        }
        from = edge.max(from.next_up());
    }
    Some(from)
}

/// The box with this middle and these half widths.
pub(crate) fn around(middle: &[f64], radii: &[f64]) -> Vec<Interval> {
    middle.iter().zip(radii).map(|(m, r)| Interval::from(*m) + Interval::symmetric(*r)).collect()
}

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

/// All images of a chain of boxes.
pub(crate) struct Images<'p> {
    proposal: &'p Proposal,
    radii: &'p [Vec<f64>],
    defects: Vec<Vec<Interval>>,
    slopes: Vec<Square>,
    pub(crate) crossings: Vec<CertifiedCrossing>,
}

impl<'p> Images<'p> {
    /// Encloses all legs. `seen` receives every enclosed part of the motion.
    pub(crate) fn new(
        model: &dyn Periodic,
        field: &Field<'_>,
        proposal: &'p Proposal,
        radii: &'p [Vec<f64>],
        meter: &Meter<'_>,
        seen: &mut Seen<'_>,
    ) -> Result<Self, Unproved> {
        let count = proposal.legs.len();
        let (mut defects, mut slopes, mut crossings) = (Vec::new(), Vec::new(), Vec::new());
        for (i, leg) in proposal.legs.iter().enumerate() {
            meter.spend_slowly()?;
            if let Some(t) = edge_within(model, field, leg, proposal.legs[count - 1].end) {
                return Err(Unproved::Together { t, after: leg.end.middle() });
            }
            let m = &proposal.nodes[i];
            let image = image(field, leg, &around(m, &radii[i]), m, seen)?;
            let next = &proposal.nodes[(i + 1) % count];
            defects.push(image.middle.iter().zip(next).map(|(x, next)| *x - Interval::from(*next)).collect());
            slopes.push(image.slope);
            let of = |time: Interval| {
                leg.crossings.iter().map(move |crossing| CertifiedCrossing {
                    contact: crossing.contact,
                    to: crossing.to,
                    time,
                })
            };
            crossings.extend(image.crossing.into_iter().flat_map(of));
        }
        Ok(Images { proposal, radii, defects, slopes, crossings })
    }

    pub(crate) fn newton(&self) -> Newton<'_> {
        Newton::new(&self.defects, &self.slopes)
    }
    /// The half widths of the images of all boxes.
    pub(crate) fn bounds(&self, defect: Defect) -> Result<Vec<Vec<f64>>, Unproved> {
        self.newton().bounds(self.radii, defect).map_err(|node| Unproved::NotContracting {
            t: self.proposal.legs[node].start.middle(),
            needed: f64::INFINITY,
        })
    }
    /// The proof that the Newton operator maps the boxes into themselves.
    pub(crate) fn inclusion(&self, bounds: &[Vec<f64>]) -> Result<(), Unproved> {
        // A NaN counts as not proved.
        let ratio = |(bound, radius): (&f64, &f64)| {
            Some(bound / radius).filter(|x| !x.is_nan()).unwrap_or(f64::INFINITY)
        };
        let needed =
            |(bounds, radii): (&Vec<f64>, &Vec<f64>)| bounds.iter().zip(radii).map(ratio).fold(0.0, f64::max);
        let all = bounds.iter().zip(self.radii).map(needed).enumerate();
        let worst = all.fold((0, 0.0), |worst, node| if node.1 > worst.1 { node } else { worst });
        match worst.1 < 1.0 {
            true => Ok(()),
            false => Err(Unproved::NotContracting {
                t: self.proposal.legs[worst.0].start.middle(),
                needed: worst.1,
            }),
        }
    }
    pub(crate) fn multipliers(&self) -> Vec<Disc> {
        let apart = discs(&self.slopes, &self.newton().turn()).unwrap_or_default();
        // Multipliers that are not separated may still be bounded together.
        match apart.is_empty() || stability(&apart) == Stability::Undecided {
            true => within(&self.slopes).unwrap_or(apart),
            false => apart,
        }
    }
}
