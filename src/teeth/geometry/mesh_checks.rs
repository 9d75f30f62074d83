//! What makes a mesh possible.

use crate::teeth::error::TeethError as E;
use crate::teeth::geometry::gear::InvoluteGear;
use crate::teeth::geometry::involute::involute;
use crate::teeth::geometry::pair::GearPair;

/// Jamming up to this share of the module is the rounding of printed profile shifts and centre distances
/// `[1]`.
const ROUNDED: f64 = 1e-3;

impl GearPair {
    /// Whether the gears can mesh: tips, roots, line of contact, contact ratio, backlash.
    pub(crate) fn check(&self) -> Result<(), E> {
        let pair = self;
        let gears = pair.gears();
        let distance = pair.centre_distance();
        for i in 0..2 {
            let (own, mate) = (&gears[i], &gears[1 - i]);
            // The tip of the own gear and the root of its mate lie on the line of centres.
            let clearance = match (own.is_internal(), mate.is_internal()) {
                (false, false) => distance - own.tip_radius() - mate.root_radius(),
                (false, true) => mate.root_radius() - distance - own.tip_radius(),
                (true, _) => own.tip_radius() - distance - mate.root_radius(),
            };
            if clearance <= 0.0 {
                return Err(E::NoClearance { gear: i, clearance });
            }
        }
        if pair.backlash() < -ROUNDED * gears[0].module() {
            return Err(E::NoBacklash { backlash: pair.backlash() });
        }
        if pair.contact_ratio() < 1.0 {
            return Err(E::ContactRatio { value: pair.contact_ratio() });
        }
        for (i, gear) in gears.iter().enumerate() {
            let [start, end] = pair.line_of_contact(i);
            let (contact, involute) = (pair.active_profile(i)[0], gear.form_radius());
            let slack = 1e-12 * involute;
            let beyond =
                if gear.is_internal() { contact > involute + slack } else { contact < involute - slack };
            if start.min(end) <= 0.0 {
                return Err(E::BeyondBaseCircle { gear: i });
            }
            if beyond && !gear.may_be_undercut() {
                return Err(E::Interference { gear: i, contact, involute });
            }
        }
        tips(pair)
    }
}

/// Whether the tips of pinion and internal gear pass each other.
///
/// Both tips reach the intersection of the tip circles. With the angles θ_1 of the pinion and θ_2 of the
/// internal gear there, no overlap requires θ_1 z_1/z_2 + inv α_w - inv α_a2 >= θ_2, θ_1 counted from the
/// pitch point along the flank.   Source: KHK, Gear Technical Reference (trochoid interference).
fn tips(pair: &GearPair) -> Result<(), E> {
    let [a, b] = pair.gears();
    let (pinion, ring) = match (a.is_internal(), b.is_internal()) {
        (false, false) => return Ok(()),
        (true, _) => (b, a),
        (_, true) => (a, b),
    };
    let (r1, r2, distance) = (pinion.tip_radius(), ring.tip_radius(), pair.centre_distance());
    let at_pinion = (r2 * r2 - r1 * r1 - distance * distance) / (2.0 * distance * r1);
    let at_ring = (distance * distance + r2 * r2 - r1 * r1) / (2.0 * distance * r2);
    if at_pinion.abs() >= 1.0 || at_ring.abs() >= 1.0 {
        return Ok(());
    }
    let working = involute(pair.working_pressure_angle());
    let tip = |gear: &InvoluteGear| involute(libm::acos(gear.base_radius() / gear.tip_radius()));
    let turned = libm::acos(at_pinion) + tip(pinion) - working;
    let ratio = f64::from(pinion.teeth()) / f64::from(ring.teeth());
    let gap = turned * ratio + working - tip(ring) - libm::acos(at_ring);
    if gap >= 0.0 { Ok(()) } else { Err(E::TipInterference { overlap: -gap }) }
}
