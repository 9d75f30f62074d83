//! Parameters and readings of the noncircular face gear pair.

use crate::error::{ParameterError, check};
use crate::excitation::InstantCentre;

/// SI parameters of the noncircular face gear pair.
///
/// Source: Liu 2021, Table 1 and Eqs. (6), (7), (19).
///
/// ```
/// use gear_dynamics::NfgParams;
/// let params = NfgParams { speed: 140.0, ..NfgParams::table1() };
/// assert_eq!(params.mesh_frequency(), 18.0 * 140.0); // rad/s
/// assert!((params.beta() - 2.0 * 0.2 / 1.04).abs() < 1e-15);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct NfgParams {
    /// Module m `[m]`.
    pub module: f64,
    /// Number of teeth of the pinion Z1 `[1]`.
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
    /// Cosine and sine amplitudes of the static transmission error `[m]`, by order of the mesh frequency
    /// from 1.
    pub error_harmonics: Vec<[f64; 2]>,
    /// Half backlash b `[m]`, half of the backlash of the teeth.
    pub half_backlash: f64,
    /// Speed of the pinion ω1 [rad/s].
    pub speed: f64,
}

impl NfgParams {
    /// The values of Liu 2021, Table 1.
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

    /// Checks every value against its range.
    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check::scale("module", self.module)?;
        check::at_least("pinion_teeth", self.pinion_teeth as usize, 1)?;
        check::scale("ratio", self.ratio)?;
        let teeth = self.face_gear_teeth();
        // Beyond a million teeth rounding of the mesh phase over a turn is too large for the excitations.
        if (teeth - teeth.round()).abs() > 1e-9 * teeth || !(1.0..=1e6).contains(&teeth.round()) {
            let must = "be a whole number from 1 to 1000000: pinion_teeth times ratio".into();
            return Err(ParameterError::Wrong { name: "face gear teeth".into(), value: teeth, must });
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

    /// Checks the quantities that follow from several values and from the reading. Returns the natural
    /// frequency ω_n [rad/s] for the mean radius `radius` `[m]`.
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
        // Bounds of the drives over a turn; the smallest radius is 1 - β times the mean radius.
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
        // With two degrees of freedom the mesh force depends on the error e itself, not on its derivatives
        // only.
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

    /// Number of teeth of the face gear Z2 = i_j Z1 `[1]`, equal to the mesh frequency over the frequency of
    /// the instantaneous centre.
    pub(crate) fn face_gear_teeth(&self) -> f64 {
        self.ratio * f64::from(self.pinion_teeth)
    }
    /// Pitch radius of the pinion r1 = m Z1/2 `[m]`.
    pub(crate) fn pinion_pitch_radius(&self) -> f64 {
        0.5 * self.module * f64::from(self.pinion_teeth)
    }
    /// β = 2 ε/(1 + ε²) `[1]`, the relative variation of the base radius: r_b2 = L (1 + β cos x).
    pub fn beta(&self) -> f64 {
        2.0 * self.eccentric_ratio / (1.0 + self.eccentric_ratio * self.eccentric_ratio)
    }
    /// Mean base radius L = r1 i_j cos α (1 + ε²)/(1 - ε²) `[m]`.   Source: Liu 2021, Eq. (8).
    pub(crate) fn mean_base_radius(&self) -> f64 {
        self.mean_pitch_radius() * libm::cos(self.pressure_angle)
    }
    /// Mean pitch radius r1 i_j (1 + ε²)/(1 - ε²) `[m]`, L without cos α. It fits the figures of Liu 2021
    /// best.
    pub(crate) fn mean_pitch_radius(&self) -> f64 {
        let eps2 = self.eccentric_ratio * self.eccentric_ratio;
        self.pinion_pitch_radius() * self.ratio * (1.0 + eps2) / (1.0 - eps2)
    }
    /// Frequency of the instantaneous centre ω_c = ω1/i_j [rad/s].
    pub(crate) fn centre_frequency(&self) -> f64 {
        self.speed / self.ratio
    }
    /// Mesh frequency ω_e = Z1 ω1 [rad/s].
    pub fn mesh_frequency(&self) -> f64 {
        self.speed * f64::from(self.pinion_teeth)
    }
}

/// The radius in L. Default: the base radius.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, models::nfg::{NfgReading, Radius}};
/// let params = NfgParams::table1();
/// let base = NfgPair::of_reading(&params, NfgReading { radius: Radius::Base, ..NfgReading::exact() })?;
/// let pitch = NfgPair::of_reading(&params, NfgReading { radius: Radius::Pitch, ..NfgReading::exact() })?;
/// assert!((base.mean_radius() / pitch.mean_radius() - 20f64.to_radians().cos()).abs() < 1e-12); // cos α
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Radius {
    /// Pitch radius: L without cos α.
    Pitch,
    /// Base radius, as Liu 2021, Eq. (2) requires.
    #[default]
    Base,
}

/// The half backlash b̄ `[rad]` of the dead zone of q; b is half of the backlash. Default: b/r_b2(t).
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, ParameterError, ode::Probe, excitation::Side};
/// use gear_dynamics::models::nfg::{HalfBacklash, NfgReading};
/// let params = NfgParams::table1();
/// let edge = |half_backlash| -> Result<f64, ParameterError> {
///     let pair = NfgPair::of_reading(&params, NfgReading { half_backlash, ..NfgReading::exact() })?;
///     let mut probe = Probe::new(&pair);
///     Ok(probe.read_contacts(0.0, Side::After, &[0.0], &[0.0])[0].upper) // r_b2 b̄ [m] at x = 0
/// };
/// let b = params.half_backlash;
/// assert!((edge(HalfBacklash::Instant)? / b - 1.0).abs() < 1e-12);
/// assert!((edge(HalfBacklash::Mean)? / b - (1.0 + 0.4 / 1.04)).abs() < 1e-12); // r_b2(0)/L = 1 + β
/// # Ok::<(), ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum HalfBacklash {
    /// b/L.
    Mean,
    /// b/r_b2(t): Liu 2021, Eq. (12), with the missing bar.
    #[default]
    Instant,
}

/// The term ē'' on the right-hand side of Liu 2021, Eq. (9), with ē = e/r_b2. Default: (e/r_b2)''.
///
/// ```
/// use gear_dynamics::{Model, NfgPair, NfgParams, ParameterError, excitation::Side};
/// use gear_dynamics::models::nfg::{ErrorForcing, NfgReading};
/// // Without load, and with e = 10 μm cos(Z2 x), the acceleration at x = 0 in the gap is ē''.
/// let params = NfgParams { load_torque: 0.0, error_harmonics: vec![[1e-5, 0.0]], ..NfgParams::table1() };
/// let forcing = |error_forcing| -> Result<f64, ParameterError> {
///     let pair = NfgPair::of_reading(&params, NfgReading { error_forcing, ..NfgReading::exact() })?;
///     let mut u = vec![0.0; pair.drives()];
///     let mut a = [0.0];
///     pair.drive(0.0, Side::After, &mut u);
///     pair.accel(&u, &[0.0], &[0.0], &mut a);
///     Ok(a[0])
/// };
/// let ratio = forcing(ErrorForcing::Frozen)? / forcing(ErrorForcing::MeanRadius)?;
/// assert!((ratio - 1.04 / 1.44).abs() < 1e-12); // L/r_b2(0) = 1/(1 + β), β = 0.4/1.04
/// # Ok::<(), ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ErrorForcing {
    /// e''/L.
    MeanRadius,
    /// e''/r_b2(t), with r_b2 treated as constant in the derivatives: Liu 2021, Eq. (21).
    Frozen,
    /// (e/r_b2)''.
    #[default]
    Exact,
}

/// The term θ2'' on the right-hand side of Liu 2021, Eq. (9). Default: the exact expression.
///
/// ```
/// use gear_dynamics::{Model, NfgPair, NfgParams, ParameterError, Periodic, excitation::Side};
/// use gear_dynamics::models::nfg::{CentreForcing, NfgReading};
/// // Without load and error the acceleration in the gap is -θ2''.
/// let params = NfgParams { load_torque: 0.0, error_harmonics: vec![], ..NfgParams::table1() };
/// let forcing = |centre_forcing| -> Result<f64, ParameterError> {
///     let pair = NfgPair::of_reading(&params, NfgReading { centre_forcing, ..NfgReading::exact() })?;
///     let mut u = vec![0.0; pair.drives()];
///     let mut a = [0.0];
///     pair.drive(0.25 * pair.period(), Side::After, &mut u); // x = π/2
///     pair.accel(&u, &[0.0], &[0.0], &mut a);
///     Ok(-a[0])
/// };
/// // 2 ε for order 2, 2 ε (1 - ε²)/(1 + ε²)² exactly, times (ω_c/ω_n)²; ε = 0.2.
/// let ratio = forcing(CentreForcing::Series(2))? / forcing(CentreForcing::Exact)?;
/// assert!((ratio - 1.04 * 1.04 / 0.96).abs() < 1e-12);
/// # Ok::<(), ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum CentreForcing {
    /// The Fourier series up to an order, at most 10 000; `Series(2)` is Liu 2021, Eq. (22).
    Series(u32),
    /// Liu 2021, Eq. (20), with the missing squares.
    #[default]
    Exact,
}

/// The damping term of Liu 2021, Eq. (9). Default: constant damping coefficient.
///
/// ```
/// use gear_dynamics::{Model, NfgPair, NfgParams, ParameterError, excitation::Side};
/// use gear_dynamics::models::nfg::{Damping, NfgReading};
/// // Without load and error the acceleration at x = 0, q = 0, q' = 1 is the damping term alone.
/// let params = NfgParams { load_torque: 0.0, error_harmonics: vec![], ..NfgParams::table1() };
/// let term = |damping| -> Result<f64, ParameterError> {
///     let pair = NfgPair::of_reading(&params, NfgReading { damping, ..NfgReading::exact() })?;
///     let mut u = vec![0.0; pair.drives()];
///     let mut a = [0.0];
///     pair.drive(0.0, Side::After, &mut u);
///     pair.accel(&u, &[0.0], &[1.0], &mut a);
///     Ok(-a[0])
/// };
/// assert!((term(Damping::ConstantRatio)? - 0.02).abs() < 1e-12); // 2 ζ
/// let beta = 0.4 / 1.04;
/// let factor: f64 = (1.0 + beta) * (1.0 + beta) / (1.0 + 0.5 * beta * beta);
/// assert!((term(Damping::ConstantCoefficient)? - 0.02 * factor).abs() < 1e-12);
/// # Ok::<(), ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Damping {
    /// Constant damping ratio ζ, as printed: 2 ζ q'.
    ConstantRatio,
    /// Constant damping coefficient c_m: 2 ζ (1 + β cos x)²/(1 + β²/2) (q' + (r_b2'/r_b2) q).
    #[default]
    ConstantCoefficient,
}

/// An interpretation of Liu 2021, Eq. (9). Default: [`exact`](NfgReading::exact).
/// [models](crate::guide::models), "Readings", compares the options.
///
/// The error forcing has the sign that follows from the derivation. Eqs. (21) and (22) print the opposite
/// sign, which is that of an error shifted by half a mesh period. To obtain it, reverse the signs of
/// `error_harmonics`.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, models::nfg::NfgReading};
/// let params = NfgParams::table1();
/// let exact = NfgPair::of_reading(&params, NfgReading::exact())?;
/// let published = NfgPair::of_reading(&params, NfgReading::published())?; // on the pitch radius
/// let ratio = exact.natural_frequency() / published.natural_frequency();
/// assert!((ratio - 20f64.to_radians().cos()).abs() < 1e-12); // cos α
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct NfgReading {
    /// Radius in L.
    pub radius: Radius,
    /// Half backlash of the dead zone.
    pub half_backlash: HalfBacklash,
    /// Forcing by the transmission error.
    pub error_forcing: ErrorForcing,
    /// Forcing by the instantaneous centre.
    pub centre_forcing: CentreForcing,
    /// Damping term.
    pub damping: Damping,
}

impl NfgReading {
    /// The reading that fits the figures of Liu 2021 best.
    ///
    /// It is not the equations letter by letter. It corrects Eqs. (8) (ω_c for ω_e), (19) (t is missing),
    /// (20) (both squares are missing; of its series two terms are kept) and (21), (22) (sign of the error),
    /// and takes the bars of Eqs. (11), (12) as b̄ = b/L. It keeps what Eq. (9) approximates: the constant ζ
    /// in place of a constant c_m, without the term r_b2' q2 that is missing in (4) and (5), and e over a
    /// frozen r_b2. [Errata](crate::guide::errata) has all of them.
    pub fn published() -> Self {
        NfgReading {
            radius: Radius::Pitch,
            half_backlash: HalfBacklash::Mean,
            error_forcing: ErrorForcing::Frozen,
            centre_forcing: CentreForcing::Series(2),
            damping: Damping::ConstantRatio,
        }
    }
    /// The reading [`published`](NfgReading::published) with the base radius in L; called reading A in
    /// [models](crate::guide::models).
    pub fn published_on_base_radius() -> Self {
        NfgReading { radius: Radius::Base, ..NfgReading::published() }
    }
    /// The reading without approximations, which follows from Newton's law.
    pub fn exact() -> Self {
        NfgReading::default()
    }
}
