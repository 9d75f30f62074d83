//! One gear with involute teeth.

use crate::error::{ParameterError, check};
use crate::teeth::error::within;
use crate::teeth::geometry::blank::Blank;
use crate::teeth::geometry::involute::involute;
use std::f64::consts::PI;

/// An involute gear, external or internal, spur or helical.
///
/// Defaults: normal pressure angle 20°, helix angle 0, profile shift 0, basic rack with addendum 1 and
/// dedendum 1.25 modules, face width of 10 modules, no tip alteration. Signs follow ISO 21771: the tooth
/// number of an internal gear is counted negative there, so that a positive profile shift moves the teeth of
/// an internal gear towards its axis. Here the tooth number is stated positive in both cases; all radii
/// returned are positive.
///
/// ```
/// use gear_dynamics::teeth::InvoluteGear;
/// let sun = InvoluteGear::external(19, 0.045)?.with_profile_shift(0.617)?;
/// assert!((2e3 * sun.base_radius() - 803.437).abs() < 1e-3); // mm
/// let ring = InvoluteGear::internal(56, 0.045)?.with_profile_shift(-0.5013)?;
/// assert!((2e3 * ring.tip_radius() - 2475.117).abs() < 1e-3);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
///
/// Source: ISO 21771:2007; ISO 53:1998 for the basic rack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvoluteGear {
    teeth: u32,
    internal: bool,
    module: f64,
    pressure_angle: f64,
    helix_angle: f64,
    profile_shift: f64,
    addendum: f64,
    dedendum: f64,
    fillet_radius: Option<f64>,
    tip_alteration: f64,
    face_width: f64,
    undercut_allowed: bool,
}

/// Fewest and most teeth of a gear.
const TEETH: [u32; 2] = [5, 100_000];

impl InvoluteGear {
    /// An external gear with a number of teeth and the normal module m_n `[m]`.
    ///
    /// # Errors
    /// Fewer than 5 or more than 100 000 teeth; a module outside 1e-5 .. 0.2 m.
    pub fn external(teeth: u32, module: f64) -> Result<Self, ParameterError> {
        InvoluteGear::new(teeth, module, false)
    }

    /// An internal gear, as [`external`](InvoluteGear::external).
    ///
    /// # Errors
    /// As [`external`](InvoluteGear::external).
    pub fn internal(teeth: u32, module: f64) -> Result<Self, ParameterError> {
        InvoluteGear::new(teeth, module, true)
    }

    fn new(teeth: u32, module: f64, internal: bool) -> Result<Self, ParameterError> {
        check::at_least("teeth", teeth as usize, TEETH[0] as usize)?;
        check::count("teeth", &[teeth as usize], TEETH[1] as usize)?;
        let module = within("module", module, [1e-5, 0.2], "[1e-5, 0.2] m")?;
        Ok(InvoluteGear {
            teeth,
            internal,
            module,
            pressure_angle: 20f64.to_radians(),
            helix_angle: 0.0,
            profile_shift: 0.0,
            addendum: 1.0,
            dedendum: 1.25,
            fillet_radius: None,
            tip_alteration: 0.0,
            face_width: 10.0 * module,
            undercut_allowed: false,
        })
    }

    /// The same gear with a normal pressure angle α_n `[rad]`.
    ///
    /// # Errors
    /// An angle outside 0.1 .. 0.7 rad (6° .. 40°).
    pub fn with_pressure_angle(self, angle: f64) -> Result<Self, ParameterError> {
        let pressure_angle = within("normal pressure angle", angle, [0.1, 0.7], "[0.1, 0.7] rad")?;
        Ok(InvoluteGear { pressure_angle, ..self })
    }
    /// The same gear with a helix angle |β| `[rad]` at the reference circle. The hands of the two gears of a
    /// pair follow from its kind: opposite for two external gears, equal for an internal pair.
    ///
    /// # Errors
    /// An angle outside 0 .. 0.8 rad (45.8°).
    pub fn with_helix_angle(self, angle: f64) -> Result<Self, ParameterError> {
        Ok(InvoluteGear { helix_angle: within("helix angle", angle, [0.0, 0.8], "[0, 0.8] rad")?, ..self })
    }
    /// The same gear with a profile shift x `[1]`, in normal modules.
    ///
    /// # Errors
    /// A shift outside -3 .. 3.
    pub fn with_profile_shift(self, shift: f64) -> Result<Self, ParameterError> {
        Ok(InvoluteGear { profile_shift: within("profile shift", shift, [-3.0, 3.0], "[-3, 3]")?, ..self })
    }
    /// The same gear with an addendum h_aP of its basic rack `[1]`, in normal modules.
    ///
    /// # Errors
    /// A factor outside 0.1 .. 3.
    pub fn with_addendum(self, factor: f64) -> Result<Self, ParameterError> {
        Ok(InvoluteGear { addendum: within("addendum factor", factor, [0.1, 3.0], "[0.1, 3]")?, ..self })
    }
    /// The same gear with a dedendum h_fP of its basic rack `[1]`, in normal modules.
    ///
    /// # Errors
    /// A factor outside 0.1 .. 4.
    pub fn with_dedendum(self, factor: f64) -> Result<Self, ParameterError> {
        Ok(InvoluteGear { dedendum: within("dedendum factor", factor, [0.1, 4.0], "[0.1, 4]")?, ..self })
    }
    /// The same gear with a root fillet radius ρ_fP of its basic rack `[1]`, in normal modules.
    ///
    /// Default: (h_fP - h_aP)/(1 - sin α_n), with which the straight flank of the rack ends at the line of
    /// its addendum. ISO 53, profile A, rounds it to 0.38.
    ///
    /// # Errors
    /// A factor outside 0 .. 1.
    pub fn with_fillet_radius(self, factor: f64) -> Result<Self, ParameterError> {
        Ok(InvoluteGear {
            fillet_radius: Some(within("fillet radius factor", factor, [0.0, 1.0], "[0, 1]")?),
            ..self
        })
    }
    /// The same gear with a tip alteration k m_n `[m]`, negative if the tip is shortened.
    ///
    /// # Errors
    /// An alteration outside -1 .. 1 m.
    pub fn with_tip_alteration(self, length: f64) -> Result<Self, ParameterError> {
        Ok(InvoluteGear {
            tip_alteration: within("tip alteration", length, [-1.0, 1.0], "[-1, 1] m")?,
            ..self
        })
    }
    /// The same gear with a face width b `[m]`.
    ///
    /// # Errors
    /// A width outside 1e-6 .. 10 m.
    pub fn with_face_width(self, width: f64) -> Result<Self, ParameterError> {
        Ok(InvoluteGear { face_width: within("face width", width, [1e-6, 10.0], "[1e-6, 10] m")?, ..self })
    }
    /// The same gear, also if it is undercut by a rack or its contact extends below the involute that a rack
    /// makes, for example because another tool makes it. The involute of an undercut gear then counts from
    /// the base circle.
    pub fn allow_undercut(self) -> Self {
        InvoluteGear { undercut_allowed: true, ..self }
    }

    /// Number of teeth z, positive for an internal gear as well.
    pub fn teeth(&self) -> u32 {
        self.teeth
    }
    /// Whether the gear is internal.
    pub fn is_internal(&self) -> bool {
        self.internal
    }
    /// Normal module m_n `[m]`.
    pub fn module(&self) -> f64 {
        self.module
    }
    /// Transverse module m_t = m_n/cos β `[m]`.
    pub fn transverse_module(&self) -> f64 {
        self.module / libm::cos(self.helix_angle)
    }
    /// Normal pressure angle α_n `[rad]`.
    pub fn pressure_angle(&self) -> f64 {
        self.pressure_angle
    }
    /// Transverse pressure angle `[rad]`: tan α_t = tan α_n/cos β.
    pub fn transverse_pressure_angle(&self) -> f64 {
        if self.helix_angle == 0.0 {
            return self.pressure_angle;
        }
        libm::atan(libm::tan(self.pressure_angle) / libm::cos(self.helix_angle))
    }
    /// Helix angle β at the reference circle `[rad]`.
    pub fn helix_angle(&self) -> f64 {
        self.helix_angle
    }
    /// Helix angle at the base circle `[rad]`: sin β_b = sin β cos α_n.
    pub fn base_helix_angle(&self) -> f64 {
        libm::asin(libm::sin(self.helix_angle) * libm::cos(self.pressure_angle))
    }
    /// Profile shift x `[1]`, in normal modules.
    pub fn profile_shift(&self) -> f64 {
        self.profile_shift
    }
    /// Addendum h_aP of the basic rack `[1]`, in normal modules.
    pub fn addendum(&self) -> f64 {
        self.addendum
    }
    /// Dedendum h_fP of the basic rack `[1]`, in normal modules.
    pub fn dedendum(&self) -> f64 {
        self.dedendum
    }
    /// Root fillet radius ρ_fP of the basic rack `[1]`, in normal modules; 0 if the dedendum leaves
    /// no clearance.
    pub fn fillet_radius(&self) -> f64 {
        let of_clearance = (self.dedendum - self.addendum) / (1.0 - libm::sin(self.pressure_angle));
        self.fillet_radius.unwrap_or(of_clearance.max(0.0))
    }
    /// Tip alteration k m_n `[m]`, negative if the tip is shortened.
    pub fn tip_alteration(&self) -> f64 {
        self.tip_alteration
    }
    /// Face width b `[m]`.
    pub fn face_width(&self) -> f64 {
        self.face_width
    }
    /// Virtual number of teeth z_n = z/(cos² β_b cos β) `[1]`.
    pub fn virtual_teeth(&self) -> f64 {
        let base = libm::cos(self.base_helix_angle());
        f64::from(self.teeth) / (base * base * libm::cos(self.helix_angle))
    }

    /// Reference radius r = z m_t/2 `[m]`.
    pub fn reference_radius(&self) -> f64 {
        0.5 * f64::from(self.teeth) * self.transverse_module()
    }
    /// Base radius r_b = r cos α_t `[m]`.
    pub fn base_radius(&self) -> f64 {
        self.reference_radius() * libm::cos(self.transverse_pressure_angle())
    }
    /// Tip radius `[m]`: r + (h_aP + x) m_n + k m_n, with minus signs for an internal gear.
    pub fn tip_radius(&self) -> f64 {
        let height = (self.addendum + self.profile_shift) * self.module + self.tip_alteration;
        self.reference_radius() + self.sign() * height
    }
    /// Root radius `[m]`: r - (h_fP - x) m_n, with a plus sign for an internal gear.
    pub fn root_radius(&self) -> f64 {
        self.reference_radius() - self.sign() * (self.dedendum - self.profile_shift) * self.module
    }
    /// Base pitch p_bt = π m_t cos α_t `[m]`.
    pub fn base_pitch(&self) -> f64 {
        PI * self.transverse_module() * libm::cos(self.transverse_pressure_angle())
    }

    /// Transverse thickness of a tooth at a radius outside the base circle `[m]`:
    /// s = 2 r_y ((π/2 + 2 x tan α_n)/z + inv α_t - inv α_y), with the sign of z for an internal gear. It is
    /// negative beyond the point at which the flanks meet.
    ///
    /// # Errors
    /// A radius outside r_b .. 1e3 m.
    pub fn tooth_thickness(&self, radius: f64) -> Result<f64, ParameterError> {
        let base = self.base_radius();
        if !(base..=1e3).contains(&radius) {
            within("radius", radius, [base, 1e3], "[base radius, 1e3 m]")?;
        }
        let half = self.half_base_angle() - self.sign() * involute(libm::acos(base / radius));
        Ok(2.0 * radius * half)
    }
    /// Least profile shift without undercut by a rack `[1]`; none for an internal gear.
    ///
    /// x >= h_fP - ρ_fP (1 - sin α_n)/m_n - z sin² α_t/(2 cos β).
    pub fn least_shift(&self) -> Option<f64> {
        let sin = libm::sin(self.transverse_pressure_angle());
        let rise = f64::from(self.teeth) * sin * sin / (2.0 * libm::cos(self.helix_angle));
        (!self.internal).then(|| self.straight_dedendum() / self.module - rise)
    }
    /// Radius at which the involute begins that a rack makes `[m]`.
    ///
    /// r_F² = r_b² + (r sin α_t - (h_fP m_n - ρ_fP (1 - sin α_n) - x m_n)/sin α_t)². The base radius for a
    /// gear that is undercut; the root radius, an upper bound, for an internal gear.
    pub fn form_radius(&self) -> f64 {
        if self.internal {
            return self.root_radius();
        }
        let (base, sin) = (self.base_radius(), libm::sin(self.transverse_pressure_angle()));
        let below = self.straight_dedendum() - self.profile_shift * self.module;
        libm::hypot(base, (self.reference_radius() * sin - below / sin).max(0.0))
    }

    /// Mass and inertia of a disc of the reference diameter with a bore `[m]`, of a density `[kg/m³]`. For an
    /// internal gear, `bore` is the outer diameter of its rim.
    ///
    /// # Errors
    /// A bore that does not lie in 0 .. d, or a rim that does not lie in d .. 100 m; a density outside
    /// 1 .. 1e5 kg/m³.
    pub fn blank(&self, bore: f64, density: f64) -> Result<Blank, ParameterError> {
        let density = within("density", density, [1.0, 1e5], "[1, 1e5] kg/m³")?;
        let d = 2.0 * self.reference_radius();
        if self.internal {
            let rim = within("outer diameter", bore, [d, 100.0], "[reference diameter, 100 m]")?;
            return Ok(Blank::disc(d, rim, self.face_width, density));
        }
        let bore = within("bore", bore, [0.0, d], "[0, reference diameter]")?;
        Ok(Blank::disc(bore, d, self.face_width, density))
    }
}

impl InvoluteGear {
    /// 1 for an external gear, -1 for an internal one.
    pub(crate) fn sign(&self) -> f64 {
        if self.internal { -1.0 } else { 1.0 }
    }
    /// Depth at which the straight flank of the rack ends `[m]`.
    pub(crate) fn straight_dedendum(&self) -> f64 {
        self.dedendum * self.module
            - self.module * self.fillet_radius() * (1.0 - libm::sin(self.pressure_angle))
    }
    /// Half the angle of a tooth at the base circle `[rad]`: (π/2 + 2 x tan α_n)/z + inv α_t, with the signs
    /// of an internal gear.
    pub(crate) fn half_base_angle(&self) -> f64 {
        let thick = 0.5 * PI + 2.0 * self.profile_shift * libm::tan(self.pressure_angle);
        thick / f64::from(self.teeth) + self.sign() * involute(self.transverse_pressure_angle())
    }
    pub(crate) fn may_be_undercut(&self) -> bool {
        self.undercut_allowed
    }
}
