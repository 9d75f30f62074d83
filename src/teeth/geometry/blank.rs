//! Mass and inertia of a gear blank.

use std::f64::consts::PI;

/// Mass and moments of inertia of a disc with a bore.   Source: Friswell et al. 2010, Appendix 1.
///
/// ```
/// use gear_dynamics::teeth::InvoluteGear;
/// let gear = InvoluteGear::external(62, 0.002)?.with_face_width(0.02)?;
/// let blank = gear.blank(0.035, 7810.0)?;
/// assert!((blank.mass - 1.7360332618790646).abs() < 1e-14);
/// assert!((blank.polar_inertia - 0.0036024860225567935).abs() < 1e-16);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blank {
    /// Mass ρ π b (D² - d²)/4 `[kg]`.
    pub mass: f64,
    /// Moment of inertia about the axis, m (D² + d²)/8 `[kg m²]`.
    pub polar_inertia: f64,
    /// Moment of inertia about a diameter, I_p/2 + m b²/12 `[kg m²]`.
    pub transverse_inertia: f64,
}

impl Blank {
    /// A disc of the diameters d < D `[m]`, the width `[m]` and the density `[kg/m³]`.
    pub(crate) fn disc(inner: f64, outer: f64, width: f64, density: f64) -> Self {
        let mass = density * PI * width * (outer * outer - inner * inner) / 4.0;
        let polar = mass * (outer * outer + inner * inner) / 8.0;
        Blank { mass, polar_inertia: polar, transverse_inertia: 0.5 * polar + mass * width * width / 12.0 }
    }
}
