//! Tolerances of a quality grade.

use crate::error::ParameterError;
use crate::teeth::error::{TeethError, method_range};
use crate::teeth::geometry::gear::InvoluteGear;

/// A flank tolerance class A of ISO 1328-1:2013, 1 to 11.
///
/// ```
/// use gear_dynamics::teeth::{InvoluteGear, QualityGrade};
/// let gear = InvoluteGear::external(50, 0.004)?; // d = 200 mm
/// let tolerances = QualityGrade::new(5)?.tolerances(&gear)?;
/// assert!((tolerances.single_pitch - 6.8e-6).abs() < 1e-18); // 0.001 · 200 + 0.4 · 4 + 5 μm
/// let next = QualityGrade::new(7)?.tolerances(&gear)?;
/// assert!((next.single_pitch - 13.6e-6).abs() < 1e-18); // twice as much, two classes further
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QualityGrade(u32);

/// Tolerances of a gear `[m]`, not rounded.
///
/// ```
/// use gear_dynamics::teeth::{InvoluteGear, QualityGrade, Tolerances};
/// let gear = InvoluteGear::external(50, 0.004)?;
/// let tolerances = QualityGrade::new(6)?.tolerances(&gear)?;
/// assert_eq!(tolerances.runout, 0.9 * tolerances.cumulative_pitch);
/// assert_eq!(Tolerances::rounded(7.24e-6), 7e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Tolerances {
    /// Single pitch f_pT.
    pub single_pitch: f64,
    /// Cumulative (total) pitch F_pT.
    pub cumulative_pitch: f64,
    /// Profile form f_fαT.
    pub profile_form: f64,
    /// Profile slope f_HαT.
    pub profile_slope: f64,
    /// Total profile F_αT = √(f_fαT² + f_HαT²).
    pub total_profile: f64,
    /// Runout F_rT = 0.9 F_pT.
    pub runout: f64,
}

impl QualityGrade {
    /// The class A.
    ///
    /// # Errors
    /// A class outside 1 .. 11.
    pub fn new(grade: u32) -> Result<Self, ParameterError> {
        match grade {
            0 => Err(ParameterError::TooFew { name: "quality grade".into(), value: 0, min: 1 }),
            1..=11 => Ok(QualityGrade(grade)),
            _ => {
                Err(ParameterError::TooMany { name: "quality grade".into(), value: grade as usize, max: 11 })
            }
        }
    }
    /// The class A.
    pub fn grade(&self) -> u32 {
        self.0
    }

    /// Tolerances of a gear. With d and m_n in mm, in μm for class 5, times √2 for each further class:
    ///
    /// - f_pT = 0.001 d + 0.4 m_n + 5
    /// - F_pT = 0.002 d + 0.55 √d + 0.7 m_n + 12
    /// - f_fαT = 0.55 m_n + 5
    /// - f_HαT = 0.4 m_n + 0.001 d + 4
    ///
    /// # Errors
    /// More than 1000 teeth, a diameter outside 5 .. 15 000 mm, a module outside 0.5 .. 70 mm, a helix angle
    /// above 45°: the standard does not apply.
    pub fn tolerances(&self, gear: &InvoluteGear) -> Result<Tolerances, TeethError> {
        const METHOD: &str = "ISO 1328-1";
        let slack = [1.0 - 1e-12, 1.0 + 1e-12];
        let range = |name, value: f64, low: f64, high: f64, allowed| {
            method_range(METHOD, name, value, [low * slack[0], high * slack[1]], allowed)
        };
        range("the number of teeth", f64::from(gear.teeth()), 5.0, 1000.0, "[5, 1000]")?;
        let d = range("the diameter in mm", 2e3 * gear.reference_radius(), 5.0, 15e3, "[5, 15000]")?;
        let m = range("the module in mm", 1e3 * gear.module(), 0.5, 70.0, "[0.5, 70]")?;
        range("the helix angle in degrees", gear.helix_angle().to_degrees(), 0.0, 45.0, "[0, 45]")?;
        // √2 to a whole power, with exact powers of 2.
        let steps = self.0 as i32 - 5;
        let odd = if steps.rem_euclid(2) == 1 { std::f64::consts::SQRT_2 } else { 1.0 };
        let scale = 1e-6 * odd * libm::ldexp(1.0, steps.div_euclid(2));
        let cumulative_pitch = scale * (0.002 * d + 0.55 * libm::sqrt(d) + 0.7 * m + 12.0);
        let profile_form = scale * (0.55 * m + 5.0);
        let profile_slope = scale * (0.4 * m + 0.001 * d + 4.0);
        Ok(Tolerances {
            single_pitch: scale * (0.001 * d + 0.4 * m + 5.0),
            cumulative_pitch,
            profile_form,
            profile_slope,
            total_profile: libm::hypot(profile_form, profile_slope),
            runout: 0.9 * cumulative_pitch,
        })
    }
}

impl Tolerances {
    /// A tolerance `[m]` rounded as the standard prints it: above 10 μm to 1 μm, from 5 μm to 0.5 μm, below
    /// to 0.1 μm.
    pub fn rounded(tolerance: f64) -> f64 {
        let micro = tolerance * 1e6;
        let steps = if micro > 10.0 {
            1.0
        } else if micro >= 5.0 {
            2.0
        } else {
            10.0
        };
        (micro * steps).round() / (steps * 1e6)
    }
}
