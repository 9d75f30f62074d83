//! Mesh stiffness by ISO 6336-1, method B.

use crate::error::{ParameterError, check};
use crate::excitation::RectangularWave;
use crate::teeth::error::{TeethError, check_spur, method_range, within};
use crate::teeth::geometry::gear::InvoluteGear;
use crate::teeth::geometry::pair::GearPair;

const METHOD: &str = "ISO 6336-1, method B,";

/// Mesh stiffness by ISO 6336-1:2006, method B, for steel gears with solid discs unless stated otherwise.
///
/// q' = 0.04723 + 0.15551/z_n1 + 0.25791/z_n2 - 0.00635 x_1 - 0.11654 x_1/z_n1 - 0.00193 x_2
///      - 0.24188 x_2/z_n2 + 0.00529 x_1² + 0.00182 x_2² `[mm μm/N]`,
///
/// c'_th = 1/q', c' = c'_th C_M C_R C_B cos β, c_γα = c' (0.75 ε_α + 0.25), c_γβ = 0.85 c_γα. Index 1 is the
/// pinion: the gear with fewer teeth, in whatever order the gears are stated. In an internal mesh the terms
/// with z_n2 vanish. z_n is the virtual tooth number z/(cos² β_b cos β); its approximation z/cos³ β changes
/// c' by a few parts in 1e4 at β = 10°.
///
/// **c_γα times the face width is the mean mesh stiffness.** c_γβ serves the load distribution along the
/// width and is not added to it: their sum is nearly twice the mesh stiffness.
///
/// ```
/// use gear_dynamics::teeth::{InvoluteGear, GearPair, MethodB};
/// let gear = InvoluteGear::external(30, 0.004)?.with_profile_shift(0.5047)?.with_face_width(0.01)?;
/// let pair = GearPair::shortened(&gear, &gear)?;
/// let stiffness = MethodB::new().stiffness(&pair)?;
/// assert!((stiffness.single / 14.82523173130252e9 - 1.0).abs() < 1e-12); // c' [N/m²]
/// assert!((stiffness.mean_stiffness / 192090606.52802944 - 1.0).abs() < 1e-12); // c_γα b [N/m]
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodB {
    web: Option<[f64; 2]>,
    material: f64,
    line_load: Option<f64>,
}

/// What deserves attention in a result of [`MethodB`].
///
/// ```
/// use gear_dynamics::teeth::{InvoluteGear, GearPair, MethodB, MethodBNote};
/// let gear = |z, x| InvoluteGear::external(z, 0.004)?.with_profile_shift(x);
/// let pair = GearPair::new(&gear(20, 0.0)?, &gear(40, 0.3)?)?;
/// assert_eq!(MethodB::new().stiffness(&pair)?.notes, [MethodBNote::ShiftOrder]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MethodBNote {
    /// x_1 < x_2: the formula is stated for x_1 >= x_2.
    ShiftOrder,
    /// ε_α < 1.2 for spur gears: the standard states that c_γα may be up to 10 % smaller.
    LowContactRatio,
    /// The rim or the web is thinner or thicker than the range of C_R; its limit was used, as the standard
    /// prescribes.
    RimLimited,
}

/// Result of [`MethodB`].
///
/// ```
/// use gear_dynamics::teeth::{InvoluteGear, GearPair, MethodB};
/// let gear = InvoluteGear::external(30, 0.004)?;
/// let stiffness = MethodB::new().stiffness(&GearPair::new(&gear, &gear)?)?;
/// assert_eq!((stiffness.pinion, stiffness.correction, stiffness.blank), (0, 0.8, 1.0));
/// assert!((stiffness.rack - 0.975).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MethodBStiffness {
    /// Place of the pinion, 0 or 1.
    pub pinion: usize,
    /// Theoretical stiffness of one pair c'_th `[N/m²]`; 1 N/(mm μm) = 1e9 N/m².
    pub theoretical: f64,
    /// Correction factor C_M = 0.8 `[1]`.
    pub correction: f64,
    /// Gear blank factor C_R `[1]`.
    pub blank: f64,
    /// Basic rack factor C_B `[1]`.
    pub rack: f64,
    /// Stiffness of one pair c' per face width `[N/m²]`.
    pub single: f64,
    /// Mean mesh stiffness per face width c_γα `[N/m²]`.
    pub mesh: f64,
    /// Stiffness for the load distribution along the width c_γβ = 0.85 c_γα `[N/m²]`. It is not part of the
    /// mesh stiffness.
    pub width_distribution: f64,
    /// Mean mesh stiffness c_γα b `[N/m]` with the common face width.
    pub mean_stiffness: f64,
    /// What deserves attention.
    pub notes: Vec<MethodBNote>,
    contact_ratio: f64,
    helix_angle: f64,
    width: f64,
}

impl Default for MethodB {
    fn default() -> Self {
        MethodB::new()
    }
}

impl MethodB {
    /// Steel gears with solid discs under a line load of at least 100 N/mm.
    pub fn new() -> Self {
        MethodB { web: None, material: 1.0, line_load: None }
    }

    /// Gears with webs: C_R = 1 + ln(b_s/b)/(5 exp(s_R/(5 m_n))), from the web thickness over the face width
    /// and the rim thickness over the module `[1]`. Beyond 0.2 <= b_s/b <= 1.2 and below s_R/m_n = 1 the
    /// limits are used, as the standard prescribes.
    ///
    /// # Errors
    /// A web outside 0.01 .. 10; a rim outside 0.01 .. 1000.
    pub fn web(self, web_over_width: f64, rim_over_module: f64) -> Result<Self, ParameterError> {
        let web = within("web thickness b_s/b", web_over_width, [0.01, 10.0], "[0.01, 10]")?;
        let rim = within("rim thickness s_R/m_n", rim_over_module, [0.01, 1e3], "[0.01, 1000]")?;
        Ok(MethodB { web: Some([web, rim]), ..self })
    }
    /// Gears of other materials: c' is multiplied by E/206 GPa, with E = 2 E_1 E_2/(E_1 + E_2) `[N/m²]`.
    ///
    /// # Errors
    /// A modulus outside 1e6 .. 1e13 N/m².
    pub fn young(self, moduli: [f64; 2]) -> Result<Self, ParameterError> {
        for modulus in moduli {
            within("Young's modulus", modulus, [1e6, 1e13], "[1e6, 1e13] N/m²")?;
        }
        let [a, b] = moduli;
        Ok(MethodB { material: 2.0 * a * b / (a + b) / 206e9, ..self })
    }
    /// A line load F_t K_A/b `[N/m]`. Below 1e5 N/m (100 N/mm) c' is reduced in proportion to it.
    ///
    /// # Errors
    /// A load outside 1 .. 1e9 N/m.
    pub fn line_load(self, load: f64) -> Result<Self, ParameterError> {
        Ok(MethodB { line_load: Some(within("line load", load, [1.0, 1e9], "[1, 1e9] N/m")?), ..self })
    }

    /// The stiffness of a pair.
    ///
    /// # Errors
    /// A sum of profile shifts outside -0.5 .. 2, a helix angle above 30°, a transverse contact ratio of 2.5
    /// or more: the method is not stated for them.
    pub fn stiffness(&self, pair: &GearPair) -> Result<MethodBStiffness, TeethError> {
        let gears = pair.gears();
        let key = |gear: &InvoluteGear| (gear.is_internal(), gear.teeth());
        let first = match key(&gears[0]).cmp(&key(&gears[1])) {
            std::cmp::Ordering::Less => true,
            std::cmp::Ordering::Greater => false,
            std::cmp::Ordering::Equal => gears[0].profile_shift() >= gears[1].profile_shift(),
        };
        let pinion = usize::from(!first);
        let (one, two) = (&gears[pinion], &gears[1 - pinion]);
        let (x1, x2, helix) = (one.profile_shift(), two.profile_shift(), one.helix_angle());
        method_range(METHOD, "the sum of profile shifts", x1 + x2, [-0.5, 2.0], "[-0.5, 2]")?;
        method_range(METHOD, "the helix angle in degrees", helix.to_degrees(), [0.0, 30.0], "[0, 30]")?;
        let contact_ratio = pair.contact_ratio();
        method_range(METHOD, "the transverse contact ratio", contact_ratio, [1.0, 2.5], "[1, 2.5]")?;

        let (n1, n2) = (1.0 / one.virtual_teeth(), 1.0 / two.virtual_teeth());
        let n2 = if two.is_internal() { 0.0 } else { n2 };
        let flexibility = 0.04723 + 0.15551 * n1 + 0.25791 * n2
            - 0.00635 * x1
            - 0.11654 * x1 * n1
            - 0.00193 * x2
            - 0.24188 * x2 * n2
            + 0.00529 * x1 * x1
            + 0.00182 * x2 * x2;
        let theoretical = 1e9 / flexibility;
        let mut notes = Vec::new();
        let blank = self.web.map_or(1.0, |[web, rim]| {
            let limited = [web.clamp(0.2, 1.2), rim.max(1.0)];
            if limited != [web, rim] {
                notes.push(MethodBNote::RimLimited);
            }
            1.0 + libm::log(limited[0]) / (5.0 * libm::exp(limited[1] / 5.0))
        });
        let rack = 0.5 * (rack_factor(one) + rack_factor(two));
        let load = self.line_load.map_or(1.0, |load| (load / 1e5).min(1.0));
        let single = theoretical * CORRECTION * blank * rack * libm::cos(helix) * self.material * load;
        let mesh = single * (0.75 * contact_ratio + 0.25);
        if x1 < x2 {
            notes.push(MethodBNote::ShiftOrder);
        }
        if helix == 0.0 && contact_ratio < 1.2 {
            notes.push(MethodBNote::LowContactRatio);
        }
        let width = pair.face_width();
        Ok(MethodBStiffness {
            pinion,
            theoretical,
            correction: CORRECTION,
            blank,
            rack,
            single,
            mesh,
            width_distribution: 0.85 * mesh,
            mean_stiffness: mesh * width,
            notes,
            contact_ratio,
            helix_angle: helix,
            width,
        })
    }
}

/// C_M, which accounts for the difference between measured and theoretical stiffness of solid discs `[1]`.
const CORRECTION: f64 = 0.8;

/// C_B of one gear: (1 + 0.5 (1.2 - h_fP/m_n)) (1 - 0.02 (20° - α_n)).
fn rack_factor(gear: &InvoluteGear) -> f64 {
    let angle = gear.pressure_angle().to_degrees();
    (1.0 + 0.5 * (1.2 - gear.dedendum())) * (1.0 - 0.02 * (20.0 - angle))
}

impl MethodBStiffness {
    /// The rectangular wave whose mean is c_γα b `[N/m]` at every contact ratio: n pairs have the stiffness
    /// c' b (0.75 n + 0.25), thus c' b with one pair and 1.75 c' b with two. Its high part is centred on
    /// φ = 0.
    ///
    /// # Errors
    /// [`TeethError::Helical`] for a helical pair: its sections across the width are at different places of
    /// the cycle, so that its stiffness varies less, and by ramps. For a spur pair those of
    /// [`RectangularWave::of_contact_ratio`].
    pub fn rectangular(&self) -> Result<RectangularWave, TeethError> {
        check_spur(self.helix_angle)?;
        let level = |pairs: f64| self.single * self.width * (0.75 * pairs + 0.25);
        let pairs = self.contact_ratio.floor();
        Ok(RectangularWave::of_contact_ratio(self.contact_ratio, level(pairs), level(pairs + 1.0))?)
    }

    /// Resonance speed n_E = 1/(2π z) √(c_γα/m_red) of a gear with z teeth, in turns per second, for a
    /// reduced mass per face width on the line of action `[kg/m]`.   Source: ISO 6336-1:2006, Eq. (6).
    ///
    /// # Errors
    /// A mass outside 1e-9 .. 1e9 kg/m; 0 teeth.
    pub fn resonance_speed(&self, teeth: u32, reduced_mass: f64) -> Result<f64, ParameterError> {
        let mass = within("reduced mass", reduced_mass, [1e-9, 1e9], "[1e-9, 1e9] kg/m")?;
        check::at_least("teeth", teeth as usize, 1)?;
        Ok(libm::sqrt(self.mesh / mass) / (std::f64::consts::TAU * f64::from(teeth)))
    }
}
