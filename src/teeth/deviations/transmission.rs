//! Transmission error of tolerances, harmonics and eccentric gears.

use crate::error::{ParameterError, check};
use crate::excitation::{Fourier, Sum, Wave};
use crate::teeth::deviations::grade::QualityGrade;
use crate::teeth::error::{TeethError, within};
use crate::teeth::geometry::pair::GearPair;

/// The transmission error of a pair without load, along the line of action `[m]`: a term of the mesh cycle
/// and one of order 1 on each shaft.
///
/// e = e_z(z_0 φ_0) + e_0(φ_0) + e_1(φ_1). Each term belongs to its own shaft. Both gears turn back to the
/// same teeth after [`GearPair::turns_until_repeat`] turns; only then does the sum repeat.
///
/// ```
/// use gear_dynamics::teeth::{InvoluteGear, GearPair, QualityGrade, TransmissionError};
/// let gear = |z| InvoluteGear::external(z, 0.004);
/// let pair = GearPair::new(&gear(20)?, &gear(50)?)?;
/// let error = TransmissionError::of_grade(&pair, [QualityGrade::new(6)?; 2])?;
/// let wheel = QualityGrade::new(6)?.tolerances(&gear(50)?)?;
/// assert_eq!(error.shaft(1).pairs()[0], [0.0, 0.5 * wheel.cumulative_pitch]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TransmissionError {
    tooth: Fourier,
    shafts: [Fourier; 2],
}

impl TransmissionError {
    /// The error of the mesh cycle as amplitudes and phases (A_n `[m]`, φ_n `[rad]`) of the mesh harmonics
    /// n = 1, 2, ..., A_n cos(n φ + φ_n). No error of the shafts.
    ///
    /// # Errors
    /// An amplitude or phase beyond ±1e50; more than 10 000 harmonics.
    pub fn of_harmonics(amplitudes: &[[f64; 2]]) -> Result<Self, ParameterError> {
        let none = Fourier::new(0.0, &[])?;
        Ok(TransmissionError {
            tooth: Fourier::of_amplitudes(0.0, amplitudes)?,
            shafts: [none.clone(), none],
        })
    }

    /// The error that quality grades of both gears permit, as sines: the mesh cycle with the peak-to-peak
    /// value √(F_α0² + F_α1²) of the total profile tolerances, each shaft with its cumulative pitch tolerance
    /// F_p.
    ///
    /// This is a convention: the standard states limits and no course. Real errors are smaller and have
    /// further harmonics.
    ///
    /// # Errors
    /// A gear to which ISO 1328-1 does not apply.
    pub fn of_grade(pair: &GearPair, grades: [QualityGrade; 2]) -> Result<Self, TeethError> {
        let [a, b] = pair.gears();
        let (a, b) = (grades[0].tolerances(a)?, grades[1].tolerances(b)?);
        Ok(TransmissionError {
            tooth: Fourier::new(0.0, &[[0.0, 0.5 * libm::hypot(a.total_profile, b.total_profile)]])?,
            shafts: [sine(0.5 * a.cumulative_pitch)?, sine(0.5 * b.cumulative_pitch)?],
        })
    }

    /// The same error with the eccentricities of both gears `[m]` and their directions `[rad]` in place of
    /// the errors of the shafts: e_i = f_i sin(φ_i + ψ_i), ψ_i counted from the line of action. The runout of
    /// an eccentric gear is F_r = 2 f.
    ///
    /// # Errors
    /// An eccentricity outside 0 .. 0.1 m; a direction beyond ±1e50.
    pub fn with_eccentricity(self, lengths: [f64; 2], directions: [f64; 2]) -> Result<Self, ParameterError> {
        let wave = |i: usize| {
            let length = within(&format!("eccentricity of gear {i}"), lengths[i], [0.0, 0.1], "[0, 0.1] m")?;
            let (sin, cos) = libm::sincos(check::quantity("direction of an eccentricity", directions[i])?);
            Fourier::new(0.0, &[[length * sin, length * cos]])
        };
        Ok(TransmissionError { shafts: [wave(0)?, wave(1)?], ..self })
    }

    /// The term of the mesh cycle: order z on the shaft of a gear with z teeth.
    pub fn tooth(&self) -> &Fourier {
        &self.tooth
    }
    /// The term of order 1 on the shaft of a gear (0 or 1; any other number counts as 1).
    pub fn shaft(&self, gear: usize) -> &Fourier {
        &self.shafts[gear.min(1)]
    }

    /// All terms over an angle whose turn is the whole period after which the same teeth meet: gear 0 then
    /// turns z_1/g times and gear 1 z_0/g times, g the greatest common divisor of the tooth numbers.
    ///
    /// # Errors
    /// More than 1 000 000 mesh cycles in the period.
    pub fn over_common_period(&self, pair: &GearPair) -> Result<Sum, ParameterError> {
        let turns = pair.turns_until_repeat();
        let tooth = Wave::new(self.tooth.clone()).per_turn(turns[0])?.per_turn(pair.gears()[0].teeth())?;
        let shaft = |i: usize| Wave::new(self.shafts[i].clone()).per_turn(turns[i]);
        Ok(Sum::new(vec![tooth, shaft(0)?, shaft(1)?]))
    }
}

/// amplitude sin φ.
fn sine(amplitude: f64) -> Result<Fourier, ParameterError> {
    Fourier::new(0.0, &[[0.0, amplitude]])
}
