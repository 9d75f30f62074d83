//! The noncircular face gear pair with one degree of freedom.   Source: Liu 2021, Eq. (9).

use crate::contact::{Backlash, Mesh, Nonlinearity};
use crate::error::{ParameterError, check};
use crate::excitation::{Fourier, Side};
use crate::model::{Drives, Machine, Model, State};
use crate::models::nfg::face_gear::{FaceGear, mesh_of};
use crate::models::nfg::nfg_params::{NfgParams, NfgReading};
use crate::models::nfg::nfg_shape::{CONSTANTS, NfgShape, STIFFNESS};

/// The noncircular face gear pair with one degree of freedom.
///
/// The speed of the pinion is prescribed.
///
/// q'' + 2 ζ D (q' + (r'/r) q) + F f(q) = -B0 - θ2'' + ē''.   Source: Liu 2021, Eq. (9), corrected.
///
/// - The time is τ = ω_n t `[1]`; a prime is a derivative over τ.
/// - The coordinate is q = q2 + e/r_b2 `[rad]`, with the elastic angle q2 of the face gear.
/// - x = (ω_c/ω_n) τ is the phase of the instantaneous centre; ē = e/r_b2 `[rad]`; r is r_b2.
/// - F = (k_m/k0) (1 + β cos x)²/(1 + β²/2) and B0 = T2/(I2 ω_n²).
/// - f is the contact law, by default the dead zone of half backlash b̄ `[rad]`.
/// - [`NfgReading`] selects the forms of b̄, D, r'/r, θ2'' and ē''.
///
/// If the speed varies ([`VaryingSpeed`](crate::drives::VaryingSpeed)), θ2'' and ē'' contain a term in x'' in
/// addition to the term in x'².
///
/// Constants: `speed` ω1 [rad/s], `load torque` T2 [N m], `inertia` I2 [kg m²], `stiffness` k0 [N/m],
/// `damping ratio` ζ `[1]` and, if the law is a [`Backlash`], `half backlash` b `[m]`, half of the backlash.
/// The shape stores k_m/k0, so k_m is proportional to the constant k0.
///
/// The contact has the deflection r_b2 q `[m]`, the edges ∓r_b2 b̄ `[m]` and a mesh force `[N]`. Under
/// positive load the drive flank is the lower flank. Own channels: `base radius` r_b2 `[m]` and
/// `elastic part` f(q) `[rad]`, q less the gap.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, ode::Probe, excitation::Side};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// assert!((pair.natural_frequency() - 12_362.613_066_76).abs() < 1e-7);
/// assert!((pair.half_backlash_angle() - 6.236_939_33e-4).abs() < 1e-12);
///
/// let start = pair.on_drive_flank()?; // q = -b̄ - B0/F
/// let mut probe = Probe::new(&pair);
/// let elastic = probe.index("elastic part")?;
/// let f = probe.read(start.t, Side::After, &start.q, &start.v)[elastic];
/// assert!((f + 6.0871e-6).abs() < 1e-9); // B0/F(0)
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub type NfgPair<N = Backlash> = Machine<NfgShape<N>>;

impl NfgPair {
    /// The pair of the [exact reading](NfgReading::exact).
    ///
    /// # Errors
    /// A [`ParameterError`] that names the first field outside its range, or a derived quantity that is
    /// outside its range or overflows.
    pub fn new(params: &NfgParams) -> Result<Self, ParameterError> {
        NfgPair::of_reading(params, NfgReading::exact())
    }

    /// The pair of a given reading.
    ///
    /// # Errors
    /// As [`new`](NfgPair::new).
    pub fn of_reading(params: &NfgParams, reading: NfgReading) -> Result<Self, ParameterError> {
        params.check()?;
        let series = params.series(params.stiffness)?;
        let mesh = mesh_of(series.clone())?;
        NfgPair::made(params, reading, mesh, params.half_backlash, Some(series))
    }
}

impl NfgPair {
    /// b/L `[rad]`, the half backlash of the dead zone at the mean radius; b is half of the backlash.
    pub fn half_backlash_angle(&self) -> f64 {
        self.prepared_constants()[5]
    }
}

impl<N: Nonlinearity> NfgPair<N> {
    /// The pair with a given mesh stiffness k_m [N/m], transmission error e `[m]` and contact law, in place
    /// of those of the parameters.
    ///
    /// Stiffness and error are waves of the mesh phase; 2π is one tooth. The law receives deflections in
    /// metres and rates in metres per second. The half backlash of a [`Backlash`] becomes the constant
    /// `half backlash`. ω_n and the constant `stiffness` still follow from k0 of the parameters.
    ///
    /// # Errors
    /// As [`new`](NfgPair::new).
    pub fn of_mesh(params: &NfgParams, reading: NfgReading, mesh: Mesh<N>) -> Result<Self, ParameterError> {
        params.check()?;
        let half_backlash = mesh.law().edges(0.0, Side::After).upper;
        NfgPair::made(params, reading, mesh.scaled(1.0 / params.stiffness)?, half_backlash, None)
    }

    fn made(
        params: &NfgParams,
        reading: NfgReading,
        mesh: Mesh<N>,
        half_backlash: f64,
        series: Option<[Fourier; 2]>,
    ) -> Result<Self, ParameterError> {
        let (gear, _) = FaceGear::of(params, reading)?;
        let edges = mesh.law().edges(0.0, Side::After);
        let missing = [edges.lower == f64::NEG_INFINITY, edges.upper == f64::INFINITY];
        let shape = NfgShape { reading, mesh: mesh.per_turn(gear.teeth)?, gear, missing, series };
        let NfgParams { speed, load_torque, inertia, stiffness, damping_ratio, .. } = *params;
        CONSTANTS.machine(shape, [speed, load_torque, inertia, stiffness, damping_ratio, half_backlash])
    }

    /// The reading of the equations.
    pub fn reading(&self) -> NfgReading {
        self.shape().reading
    }
    /// Mean radius L `[m]`: base or pitch radius, as the reading selects.
    pub fn mean_radius(&self) -> f64 {
        self.shape().gear.radius
    }
    /// Natural frequency ω_n = L √(k0 (1 + β²/2)/I2) [rad/s]; τ = ω_n t.   Source: Liu 2021, Eq. (10).
    pub fn natural_frequency(&self) -> f64 {
        let values = self.values();
        self.shape().natural(values[2], values[3])
    }

    /// The state at rest on the drive flank at τ = 0: q = -b̄ - B0/F, q' = 0. The formula assumes a law of
    /// slope 1 on its lower flank. For a law without edges it is q = -B0/F.
    ///
    /// # Errors
    /// A mesh stiffness at τ = 0 that is not positive. [`ParameterError::NoFlank`] if the law has an upper
    /// flank only, because a positive load acts on the lower flank.
    pub fn on_drive_flank(&self) -> Result<State, ParameterError> {
        if self.shape().missing == [true, false] {
            return Err(ParameterError::NoFlank { flank: "lower" });
        }
        let mut u = vec![0.0; self.drives()];
        self.drive(0.0, Side::After, &mut u);
        let u = Drives::new(self.size().waves, &u);
        let at = self.shape().at(u);
        let [_, load] = u.constants();
        let load = load / check::positive("mesh stiffness at the start", u.all_waves()[STIFFNESS])?;
        let start = State::new(
            0.0,
            &[if self.shape().missing[0] { 0.0 } else { at.lower * at.per_unit } - load],
            &[0.0],
        );
        start.check(1)?;
        Ok(start)
    }
}
