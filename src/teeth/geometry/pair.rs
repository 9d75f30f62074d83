//! Two gears in mesh.

use crate::excitation::RectangularWave;
use crate::excitation::wave::gcd;
use crate::teeth::error::{TeethError, check_spur, within};
use crate::teeth::geometry::checks;
use crate::teeth::geometry::gear::InvoluteGear;
use crate::teeth::geometry::involute::{inverse, involute};
use std::f64::consts::{PI, TAU};

/// The geometry of two involute gears in mesh. Gear 0 drives; either gear may be the internal one.
///
/// The line of contact is the part of the common tangent of the base circles on which the teeth touch. A
/// pair of teeth enters contact where it reaches the tip of the driven gear, and leaves it at the tip of the
/// driving gear.
///
/// ```
/// use gear_dynamics::teeth::{InvoluteGear, GearPair};
/// let gear = InvoluteGear::external(30, 0.004)?.with_profile_shift(0.5047)?.with_face_width(0.01)?;
/// let pair = GearPair::new(&gear, &gear)?;
/// assert!((pair.centre_distance() - 0.12365569882563756).abs() < 1e-15);
/// assert!((pair.contact_ratio() - 1.5195903994888902).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: ISO 21771:2007; DIN 3960:1987 for the signs of internal gears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GearPair {
    gears: [InvoluteGear; 2],
    /// Working transverse pressure angle `[rad]`.
    working_angle: f64,
    centre_distance: f64,
    /// Distances from the points of tangency at the base circles to the start and the end of contact `[m]`,
    /// for each gear.
    reach: [[f64; 2]; 2],
    contact_ratio: f64,
}

impl GearPair {
    /// Two gears at the centre distance of their profile shifts, without backlash:
    /// inv α_wt = inv α_t + 2 tan α_n (x_0 + x_1)/(z_0 + z_1), a = m_t (z_0 + z_1) cos α_t/(2 cos α_wt).
    ///
    /// # Errors
    /// Different modules, pressure angles or helix angles; undercut, pointed or interfering teeth; a contact
    /// ratio below 1; other impossible teeth. See [`TeethError`].
    pub fn new(driver: &InvoluteGear, driven: &InvoluteGear) -> Result<Self, TeethError> {
        let gears = [*driver, *driven];
        checks::match_gears(&gears)?;
        let shifts = driver.profile_shift() + driven.profile_shift();
        let angle = involute(driver.transverse_pressure_angle());
        let tan = libm::tan(driver.pressure_angle());
        let sum = signed_sum(&gears);
        let working = inverse(angle + 2.0 * tan * shifts / sum).ok_or(TeethError::NoWorkingAngle {
            name: "sum of profile shifts",
            value: shifts,
            limit: -angle * sum / (2.0 * tan),
        })?;
        GearPair::at(gears, working, reference_distance(&gears) * ratio(&gears[0], working))
    }

    /// Two gears at a given centre distance a `[m]`: cos α_wt = a_d cos α_t/a, with a_d the sum (internal:
    /// the difference) of the reference radii. The profile shifts then leave a
    /// [`backlash`](GearPair::backlash).
    ///
    /// # Errors
    /// As [`new`](GearPair::new), and a centre distance at which the base circles have no common tangent or
    /// the teeth jam.
    pub fn at_centre_distance(
        driver: &InvoluteGear,
        driven: &InvoluteGear,
        distance: f64,
    ) -> Result<Self, TeethError> {
        let gears = [*driver, *driven];
        checks::match_gears(&gears)?;
        let distance = within("centre distance", distance, [1e-6, 100.0], "[1e-6, 100] m")?;
        let least = reference_distance(&gears) * libm::cos(driver.transverse_pressure_angle());
        if distance <= least {
            return Err(TeethError::NoWorkingAngle {
                name: "centre distance",
                value: distance,
                limit: least,
            });
        }
        GearPair::at(gears, libm::acos(least / distance), distance)
    }

    /// Two external gears at the centre distance of their profile shifts, both shortened by the same length
    /// so that the tip clearance is that of the basic rack: k m_n = a - a_d - (x_0 + x_1) m_n.
    ///
    /// ```
    /// use gear_dynamics::teeth::{InvoluteGear, GearPair};
    /// let gear = InvoluteGear::external(30, 0.004)?.with_profile_shift(0.5047)?;
    /// let pair = GearPair::shortened(&gear, &gear)?;
    /// assert!((pair.contact_ratio() - 1.39426737703706).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`new`](GearPair::new); an internal gear.
    pub fn shortened(driver: &InvoluteGear, driven: &InvoluteGear) -> Result<Self, TeethError> {
        if driver.is_internal() || driven.is_internal() {
            return Err(TeethError::NotApplicable {
                method: "the same shortening of both tips",
                teeth: "internal",
            });
        }
        // The centre distance does not depend on the tips, which may be too long before they are shortened.
        let (a, b) = (driver.allow_undercut(), driven.allow_undercut());
        checks::match_gears(&[a, b])?;
        let shifts = driver.profile_shift() + driven.profile_shift();
        let sum = signed_sum(&[a, b]);
        let tan = libm::tan(driver.pressure_angle());
        let working = inverse(involute(a.transverse_pressure_angle()) + 2.0 * tan * shifts / sum);
        let reference = reference_distance(&[a, b]);
        let alteration = working.map_or(0.0, |working| {
            (reference * ratio(&a, working) - reference - shifts * driver.module()).min(0.0)
        });
        GearPair::new(&driver.with_tip_alteration(alteration)?, &driven.with_tip_alteration(alteration)?)
    }

    fn at(gears: [InvoluteGear; 2], working_angle: f64, centre_distance: f64) -> Result<Self, TeethError> {
        checks::teeth(&gears)?;
        let tangents = gears.map(|gear| {
            let (tip, base) = (gear.tip_radius(), gear.base_radius());
            libm::sqrt(((tip - base) * (tip + base)).max(0.0))
        });
        // Distance between the points of tangency, negative for an internal pair as in DIN 3960.
        let internal = gears[0].is_internal() || gears[1].is_internal();
        let between = centre_distance * libm::sin(working_angle) * if internal { -1.0 } else { 1.0 };
        // Written for an external gear p with its mate o: contact extends from the tip of o to that of p.
        let (p, o) = if gears[0].is_internal() { (1, 0) } else { (0, 1) };
        let sign = gears[o].sign();
        let own = [between - sign * tangents[o], tangents[p]];
        let other = own.map(|reach| sign * (between - reach));
        let mut reach = [own, other];
        if p == 1 {
            // The internal gear drives: contact runs from the tip of the pinion to that of the ring.
            reach = [[other[1], other[0]], [own[1], own[0]]];
        }
        let length = own[1] - own[0];
        let contact_ratio = length / gears[0].base_pitch();
        let pair = GearPair { gears, working_angle, centre_distance, reach, contact_ratio };
        pair.check()?;
        Ok(pair)
    }

    /// The two gears.
    pub fn gears(&self) -> &[InvoluteGear; 2] {
        &self.gears
    }
    /// Whether one of the gears is internal.
    pub fn is_internal(&self) -> bool {
        self.gears.iter().any(InvoluteGear::is_internal)
    }
    /// Working transverse pressure angle α_wt `[rad]`.
    pub fn working_pressure_angle(&self) -> f64 {
        self.working_angle
    }
    /// Centre distance a `[m]`, positive for an internal pair as well.
    pub fn centre_distance(&self) -> f64 {
        self.centre_distance
    }
    /// Radii of the working pitch circles r_b/cos α_wt `[m]`.
    pub fn working_radii(&self) -> [f64; 2] {
        self.gears.map(|gear| gear.base_radius() / libm::cos(self.working_angle))
    }
    /// Circumferential backlash at the working circles `[m]`, transverse: the pitch less both thicknesses.
    /// 0 to rounding for a pair at the centre distance of its shifts.
    pub fn backlash(&self) -> f64 {
        let [a, b] = &self.gears;
        let sum = signed_sum(&self.gears);
        let shifts = 2.0 * libm::tan(a.pressure_angle()) * (a.profile_shift() + b.profile_shift());
        let play = sum * (involute(self.working_angle) - involute(a.transverse_pressure_angle())) - shifts;
        2.0 * self.working_radii()[0] / f64::from(a.teeth()) * play
    }
    /// Transverse base pitch p_bt `[m]`: the distance between neighbouring pairs on the line of contact.
    pub fn base_pitch(&self) -> f64 {
        self.gears[0].base_pitch()
    }
    /// Length of the line of contact g_α `[m]`.
    pub fn length_of_contact(&self) -> f64 {
        self.contact_ratio * self.base_pitch()
    }
    /// Start and end of contact `[m]`, as distances from the point at which the line of contact touches the
    /// base circle of a gear (0 or 1; any other number counts as 1).
    pub fn line_of_contact(&self, gear: usize) -> [f64; 2] {
        self.reach[gear.min(1)]
    }
    /// Radii of a gear between which its flank is in contact `[m]`: nearest to the root first (start of the
    /// active profile), then the tip. For an internal gear the second is the smaller one.
    pub fn active_profile(&self, gear: usize) -> [f64; 2] {
        let i = gear.min(1);
        let base = self.gears[i].base_radius();
        let radii = self.reach[i].map(|reach| libm::hypot(base, reach));
        let far = if self.gears[i].is_internal() { radii[0].max(radii[1]) } else { radii[0].min(radii[1]) };
        [far, self.gears[i].tip_radius()]
    }
    /// Tangent of the pressure angle of a gear at the place `s` of a pair on its path of contact, in base
    /// pitches from the start of contact: tan α = ρ/r_b.
    pub(crate) fn tangent_at(&self, gear: usize, s: f64) -> f64 {
        let [start, end] = self.reach[gear];
        (start + (end - start) * s / self.contact_ratio) / self.gears[gear].base_radius()
    }

    /// Transverse contact ratio ε_α `[1]`: g_α/p_bt.
    pub fn contact_ratio(&self) -> f64 {
        self.contact_ratio
    }
    /// Overlap ratio ε_β = b sin β/(π m_n) `[1]`, with the common face width.
    pub fn overlap_ratio(&self) -> f64 {
        self.face_width() * libm::sin(self.gears[0].helix_angle()) / (PI * self.gears[0].module())
    }
    /// Total contact ratio ε_γ = ε_α + ε_β `[1]`.
    pub fn total_contact_ratio(&self) -> f64 {
        self.contact_ratio() + self.overlap_ratio()
    }
    /// Common face width `[m]`: the smaller one.
    pub fn face_width(&self) -> f64 {
        self.gears[0].face_width().min(self.gears[1].face_width())
    }
    /// Part of the mesh cycle with one pair more in contact than otherwise `[rad]`: it extends from φ = 0,
    /// where a pair enters contact, to 2π (ε_α - ⌊ε_α⌋), where the preceding one leaves it. For ε_α between 1
    /// and 2 these are two pairs, and one pair is in contact during the rest of the cycle.
    ///
    /// It counts pairs in one transverse section; helical gears have more along their width.
    pub fn end_of_double_contact(&self) -> f64 {
        TAU * self.contact_ratio.fract()
    }
    /// Angle of the mesh cycle at which a pair is at the pitch point `[rad]`, in [0, 2π). It aligns the mesh
    /// cycles of several meshes.
    pub fn pitch_point(&self) -> f64 {
        let pitch = self.gears[0].base_radius() * libm::tan(self.working_angle);
        let [start, end] = self.reach[0];
        let s = (pitch - start) / (end - start) * self.contact_ratio;
        TAU * (s - s.floor())
    }
    /// Places of the pairs in contact at an angle φ in [0, 2π] of the mesh cycle, in base pitches from the
    /// start of contact, the latest pair first. `more`: whether the larger number of pairs is in contact.
    pub(crate) fn places(&self, phi: f64, more: bool) -> impl Iterator<Item = f64> + use<> {
        let pairs = self.contact_ratio.floor() as usize + usize::from(more);
        (0..pairs).map(move |k| phi / TAU + k as f64)
    }

    /// Rotations of both gears after which the same teeth meet again (hunting teeth): z_1/g and z_0/g with
    /// the greatest common divisor g of the tooth numbers. Errors of single teeth have this period.
    pub fn turns_until_repeat(&self) -> [u32; 2] {
        let z = self.gears.map(|gear| gear.teeth());
        let g = gcd(z[0], z[1]).max(1);
        [z[1] / g, z[0] / g]
    }
    /// The rectangular wave of the contact ratio with the stiffness of the smaller and of the larger number
    /// of pairs `[N/m]`. Its high part is centred on φ = 0, not on the contact of this pair:
    /// [`Wave::with_phase`](crate::Wave::with_phase) with -π (ε_α - ⌊ε_α⌋) lets it start there.
    ///
    /// # Errors
    /// [`TeethError::Helical`] for helical teeth, whose stiffness is not that of one section; a level beyond
    /// ±1e50.
    pub fn rectangular(&self, low: f64, high: f64) -> Result<RectangularWave, TeethError> {
        check_spur(self.gears[0].helix_angle())?;
        Ok(RectangularWave::of_contact_ratio(self.contact_ratio, low, high)?)
    }
}

/// z_0 + z_1, an internal gear counted negative.
fn signed_sum(gears: &[InvoluteGear; 2]) -> f64 {
    gears.iter().map(|gear| gear.sign() * f64::from(gear.teeth())).sum()
}

/// Reference centre distance |m_t (z_0 + z_1)/2| `[m]`.
fn reference_distance(gears: &[InvoluteGear; 2]) -> f64 {
    (0.5 * gears[0].transverse_module() * signed_sum(gears)).abs()
}

/// cos α_t/cos α_wt.
fn ratio(gear: &InvoluteGear, working: f64) -> f64 {
    libm::cos(gear.transverse_pressure_angle()) / libm::cos(working)
}
