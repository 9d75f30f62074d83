//! Parameters and readings of the noncircular face gear pair.

use crate::error::{ParameterError, check};
use crate::excitation::centre::InstantCentre;

/// SI parameters of the noncircular face gear pair.   Source: Liu 2021, Table 1 and Eqs. (6), (7), (19).
///
/// ```
/// use gear_dynamics::NfgParams;
/// let params = NfgParams { speed: 140.0, ..NfgParams::table1() };
/// assert_eq!(params.face_gear_teeth(), 63.0);
/// assert!((params.mean_base_radius() - 0.080_167_526_71).abs() < 1e-11);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct NfgParams {
    /// Module of the pinion m `[m]`.
    pub module: f64,
    /// Teeth of the pinion Z1 `[1]`.
    pub pinion_teeth: u32,
    /// Reduction ratio i_j = Z2/Z1 `[1]`; Z1 i_j must be a whole number of teeth.
    pub ratio: f64,
    /// Eccentric ratio ε `[1]`, in [0, 1).
    pub eccentric_ratio: f64,
    /// Pressure angle α `[rad]`.
    pub pressure_angle: f64,
    /// Load torque T2 [N m].
    pub load_torque: f64,
    /// Moment of inertia of the face gear I2 [kg m²].
    pub inertia: f64,
    /// Mean mesh stiffness k0 [N/m].
    pub stiffness: f64,
    /// Cosine and sine amplitudes of the mesh stiffness [N/m], by order of the mesh frequency from 1.
    pub stiffness_harmonics: Vec<[f64; 2]>,
    /// Damping ratio ζ `[1]`.
    pub damping_ratio: f64,
    /// Mean static transmission error e0 `[m]`.
    pub error: f64,
    /// Cosine and sine amplitudes of the static transmission error `[m]`, by order of the mesh frequency from 1.
    pub error_harmonics: Vec<[f64; 2]>,
    /// Half of the tooth backlash b `[m]`.
    pub half_backlash: f64,
    /// Rotational velocity of the pinion ω1 [rad/s].
    pub speed: f64,
}

impl NfgParams {
    /// Table 1 of the paper.
    pub fn table1() -> Self {
        NfgParams {
            module: 2.5e-3,
            pinion_teeth: 18,
            ratio: 3.5,
            eccentric_ratio: 0.2,
            pressure_angle: 20f64.to_radians(),
            load_torque: 30.0,
            inertia: 0.014,
            stiffness: 3.1e8,
            stiffness_harmonics: vec![[0.9e8, 0.0]],
            damping_ratio: 0.01,
            error: 0.0,
            error_harmonics: vec![[0.0, 1e-5]],
            half_backlash: 5e-5,
            speed: 160.0,
        }
    }

    /// Every value in its range.
    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check::scale("module", self.module)?;
        if self.pinion_teeth < 1 {
            return Err(ParameterError::TooFew { name: "pinion_teeth".into(), value: 0, least: 1 });
        }
        check::scale("ratio", self.ratio)?;
        let teeth = self.face_gear_teeth();
        // Beyond a million teeth the phase of the mesh over a turn loses digits that the excitations need.
        if (teeth - teeth.round()).abs() > 1e-9 * teeth || !(1.0..=1e6).contains(&teeth.round()) {
            let allowed = "whole numbers of teeth Z2 = ratio Z1, at most 1000000";
            return Err(ParameterError::OutOfRange { name: "face gear teeth".into(), value: teeth, allowed });
        }
        InstantCentre::check_ratio("eccentric_ratio", self.eccentric_ratio)?;
        check::quantity("pressure_angle", self.pressure_angle)?;
        if !(0.0..std::f64::consts::FRAC_PI_2).contains(&self.pressure_angle) {
            let (name, value) = ("pressure_angle".into(), self.pressure_angle);
            return Err(ParameterError::OutOfRange { name, value, allowed: "[0, π/2)" });
        }
        check::not_negative("load_torque", self.load_torque)?;
        check::scale("inertia", self.inertia)?;
        check::scale("stiffness", self.stiffness)?;
        check::count("stiffness_harmonics", &[self.stiffness_harmonics.len()], check::ORDERS)?;
        check::count("error_harmonics", &[self.error_harmonics.len()], check::ORDERS)?;
        for (i, pair) in self.stiffness_harmonics.iter().enumerate() {
            check::quantities(&format!("stiffness_harmonics[{i}]"), pair)?;
        }
        check::not_negative("damping_ratio", self.damping_ratio)?;
        check::quantity("error", self.error)?;
        for (i, pair) in self.error_harmonics.iter().enumerate() {
            check::quantities(&format!("error_harmonics[{i}]"), pair)?;
        }
        check::not_negative("half_backlash", self.half_backlash)?;
        check::scale("speed", self.speed)?;
        Ok(())
    }

    /// What a reading derives from values that are each in their range: the natural frequency ω_n [rad/s] of the mean radius `radius`.
    pub(crate) fn check_derived(&self, radius: f64, reading: NfgReading) -> Result<f64, ParameterError> {
        if let CentreForcing::Series(order) = reading.centre_forcing {
            check::count("order of the centre forcing", &[order as usize], check::ORDERS)?;
        }
        let (inertia, beta) = (self.inertia, self.beta());
        let natural = (self.stiffness * radius * radius * (1.0 + 0.5 * beta * beta) / inertia).sqrt();
        check::scale("mean radius L", radius)?;
        check::scale("natural frequency", natural)?;
        check::scale("frequency of the centre", self.centre_frequency())?;
        let omega = check::scale(
            "frequency of the centre over the natural frequency",
            self.centre_frequency() / natural,
        )?;
        // Bounds of the drives over a turn; the smallest radius is 1 - β of the mean one.
        let thinnest = (1.0 / (1.0 - beta)).powi(4);
        let wave = |pairs: &[[f64; 2]], powers: i32| {
            let order = |i: usize| ((i + 1) as f64 * self.face_gear_teeth()).powi(powers);
            pairs.iter().enumerate().map(|(i, [c, s])| (c.abs() + s.abs()) * order(i)).sum::<f64>()
        };
        let error = (self.error.abs() + wave(&self.error_harmonics, 2)) * thinnest;
        let within =
            |name: &str, figure: f64, values: &[f64]| check::representable(name, figure, values).map(|_| ());
        let amplitudes = |pairs: &[[f64; 2]]| pairs.concat();
        within(
            "mesh stiffness over its mean",
            8.0 * wave(&self.stiffness_harmonics, 0) / self.stiffness,
            &amplitudes(&self.stiffness_harmonics),
        )?;
        within(
            "acceleration by the transmission error",
            8.0 * error * (1.0 + omega * omega / radius),
            &[&[self.error][..], &amplitudes(&self.error_harmonics)].concat(),
        )?;
        within(
            "load torque over inertia and natural frequency squared",
            self.load_torque / (inertia * natural * natural),
            &[self.load_torque],
        )?;
        within(
            "mesh force of a unit deflection",
            inertia * natural * natural / radius * thinnest,
            &[self.stiffness, radius],
        )?;
        within(
            "mesh damping",
            2.0 * self.damping_ratio * inertia * natural / (radius * radius),
            &[self.damping_ratio, inertia, natural],
        )?;
        // The force of two degrees of freedom holds the error itself.
        let damping = 2.0 * self.damping_ratio * inertia * natural / (radius * radius);
        let rates = (self.stiffness + wave(&self.stiffness_harmonics, 0)) + damping * self.centre_frequency();
        let force = 8.0 * rates * (error + self.half_backlash) * radius.max(1.0) / inertia.min(1.0);
        within(
            "acceleration by the mesh force",
            force,
            &[&[self.error][..], &amplitudes(&self.stiffness_harmonics)].concat(),
        )?;
        Ok(natural)
    }

    /// Teeth of the face gear Z2 = i_j Z1 `[1]`: the mesh frequency over the frequency of the centre.
    pub fn face_gear_teeth(&self) -> f64 {
        self.ratio * f64::from(self.pinion_teeth)
    }
    /// Pitch radius of the pinion r1 = m Z1/2 `[m]`.
    pub fn pinion_pitch_radius(&self) -> f64 {
        0.5 * self.module * f64::from(self.pinion_teeth)
    }
    /// β = 2 ε/(1 + ε²) `[1]`.
    pub fn beta(&self) -> f64 {
        2.0 * self.eccentric_ratio / (1.0 + self.eccentric_ratio * self.eccentric_ratio)
    }
    /// L = r1 i_j cos α (1 + ε²)/(1 - ε²) `[m]`.   Liu 2021, Eq. (8).
    pub fn mean_base_radius(&self) -> f64 {
        self.mean_pitch_radius() * libm::cos(self.pressure_angle)
    }
    /// L without cos α `[m]`: fits the paper's own figures best.
    pub fn mean_pitch_radius(&self) -> f64 {
        let eps2 = self.eccentric_ratio * self.eccentric_ratio;
        self.pinion_pitch_radius() * self.ratio * (1.0 + eps2) / (1.0 - eps2)
    }
    /// Frequency of the instantaneous centre ω_c = ω1/i_j [rad/s].
    pub fn centre_frequency(&self) -> f64 {
        self.speed / self.ratio
    }
    /// Mesh frequency ω_e = Z1 ω1 [rad/s].
    pub fn mesh_frequency(&self) -> f64 {
        self.speed * f64::from(self.pinion_teeth)
    }
}

/// Which radius stands in L.
///
/// ```
/// assert_eq!(gear_dynamics::models::nfg::Radius::default(), gear_dynamics::models::nfg::Radius::Base);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Radius {
    /// Pitch radius: no cos α.
    Pitch,
    /// Base radius, as Eq. (2) asks.
    #[default]
    Base,
}

/// Half width of the dead zone of q.
///
/// ```
/// assert_eq!(gear_dynamics::models::nfg::HalfWidth::default(), gear_dynamics::models::nfg::HalfWidth::Instant);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HalfWidth {
    /// b/L.
    Mean,
    /// b/r_b2(t): what Eq. (12) says with its missing bar.
    #[default]
    Instant,
}

/// ē'' on the right-hand side of Eq. (9), ē = e/r_b2.
///
/// ```
/// assert_eq!(gear_dynamics::models::nfg::ErrorForcing::default(), gear_dynamics::models::nfg::ErrorForcing::Exact);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ErrorForcing {
    /// e''/L.
    MeanRadius,
    /// e''/r_b2(t), the radius frozen while differentiating: Eq. (21).
    Frozen,
    /// (e/r_b2)''.
    #[default]
    Exact,
}

/// θ2'' on the right-hand side of Eq. (9).
///
/// ```
/// assert_eq!(gear_dynamics::models::nfg::CentreForcing::default(), gear_dynamics::models::nfg::CentreForcing::Exact);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CentreForcing {
    /// The Fourier series to an order, at most 10 000; `Series(2)` is Eq. (22).
    Series(u32),
    /// Eq. (20) with its squares.
    #[default]
    Exact,
}

/// The damping term of Eq. (9).
///
/// ```
/// assert_eq!(gear_dynamics::models::nfg::Damping::default(), gear_dynamics::models::nfg::Damping::ConstantCoefficient);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Damping {
    /// 2 ζ q', as printed.
    ConstantRatio,
    /// c_m constant, with the rate term: 2 ζ (1 + β cos x)²/(1 + β²/2) (q' + (r_b2'/r_b2) q).
    #[default]
    ConstantCoefficient,
}

/// How Eq. (9) is read. The default is [`exact`](NfgReading::exact).   Source: docs/models.md, "Readings".
///
/// The error forcing has the sign of a consistent derivation; the sign printed in Eqs. (21), (22) is that of an error half a
/// mesh period later: give `error_harmonics` the other sign to have it.
///
/// ```
/// use gear_dynamics::models::nfg::{NfgReading, Radius};
/// let base = NfgReading { radius: Radius::Base, ..NfgReading::published() };
/// assert_eq!(base, NfgReading::published_on_base_radius());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NfgReading {
    /// Radius in L.
    pub radius: Radius,
    /// Half width of the dead zone.
    pub half_width: HalfWidth,
    /// Forcing by the transmission error.
    pub error_forcing: ErrorForcing,
    /// Forcing by the instantaneous centre.
    pub centre_forcing: CentreForcing,
    /// Damping term.
    pub damping: Damping,
}

impl NfgReading {
    /// The reading of the equations that fits the paper's own figures best.
    pub fn published() -> Self {
        NfgReading {
            radius: Radius::Pitch,
            half_width: HalfWidth::Mean,
            error_forcing: ErrorForcing::Frozen,
            centre_forcing: CentreForcing::Series(2),
            damping: Damping::ConstantRatio,
        }
    }
    /// The same on the base radius: reading A.
    pub fn published_on_base_radius() -> Self {
        NfgReading { radius: Radius::Base, ..NfgReading::published() }
    }
    /// Nothing approximated: the reading that follows from Newton's law.
    pub fn exact() -> Self {
        NfgReading::default()
    }
}
