//! Parameters of the ring.

use crate::contact::{Backlash, Mesh, Nonlinearity};
use crate::error::{ParameterError, check};
use crate::excitation::{Fourier, Wave};
use std::f64::consts::TAU;

/// Maximum number of gears n. The matrices of 2n + 1 rows then have at most 2²⁶ entries.
const MAX_GEARS: usize = 4095;

/// Stiffness and damping of a torsional shaft.
///
/// ```
/// use gear_dynamics::{Ring, models::ring::{RingSet, Shaft}};
/// let motor_shaft = Shaft { stiffness: 973.0, damping: 0.0257 };
/// let ring = Ring::new(&RingSet { motor_shaft, ..RingSet::set_a(4, 1000.0) }.params()?)?;
/// let k = ring.stiffness_matrix(&ring.mean_mesh_stiffness())?;
/// assert!((k[(0, 0)] - 973.0).abs() < 1e-9); // only the motor shaft acts on the motor
/// assert!((ring.damping_matrix()[(0, 1)] + 0.0257).abs() < 1e-12);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Shaft {
    /// Torsional stiffness [N m/rad], not negative.
    pub stiffness: f64,
    /// Torsional damping [N m s/rad], not negative.
    pub damping: f64,
}

impl Shaft {
    fn check(self, place: &str) -> Result<(), ParameterError> {
        check::not_negative(format!("{place}.stiffness"), self.stiffness)?;
        check::not_negative(format!("{place}.damping"), self.damping)?;
        Ok(())
    }
}

/// The motor and its shaft to gear 1.
///
/// ```
/// use gear_dynamics::{Ring, models::ring::{Motor, RingSet, Shaft}};
/// let mut params = RingSet::set_a(4, 1000.0).params()?;
/// let shaft = Shaft { stiffness: 973.0, damping: 0.0257 };
/// params.motor = Motor { inertia: 0.03, torque: 8.0, shaft };
/// assert!(Ring::new(&params)?.torque_imbalance().abs() < 1e-12); // 8 N m drive four loads of 2 N m
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Motor {
    /// Moment of inertia of the motor J_M [kg m²].
    pub inertia: f64,
    /// Motor torque T_M [N m].
    pub torque: f64,
    /// Shaft between motor and gear 1.
    pub shaft: Shaft,
}

/// The load of a gear and the output shaft between them.
///
/// ```
/// use gear_dynamics::{Ring, models::ring::{Load, RingSet, Shaft}};
/// let mut params = RingSet::set_a(4, 1000.0).params()?;
/// let shaft = Shaft { stiffness: 24_913.0, damping: 0.117 };
/// params.gears[1].load = Load { inertia: 5.97e-3, torque: 5.0, shaft };
/// assert!((Ring::new(&params)?.torque_imbalance() - 33.0).abs() < 1e-12); // 44 - 3 x 2 - 5 [N m]
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Load {
    /// Moment of inertia of the load J_L [kg m²].
    pub inertia: f64,
    /// Load torque T_L [N m]; a positive value acts against the rotation.
    pub torque: f64,
    /// Output shaft between gear and load.
    pub shaft: Shaft,
}

/// A gear of the ring with its load.
///
/// ```
/// use gear_dynamics::{Ring, models::ring::{Gear, RingSet}};
/// let mut params = RingSet::set_a(4, 1000.0).params()?;
/// let first = params.gears[0];
/// params.gears[2] = Gear { base_radius: 0.5 * first.base_radius, ..first };
/// let ring = Ring::new(&params)?;
/// assert_eq!(ring.rigid_motion()[5], 2.0); // θ_3 turns twice as fast as θ_1
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Gear {
    /// Moment of inertia of the gear J_i [kg m²].
    pub inertia: f64,
    /// Base radius R_i `[m]`.
    pub base_radius: f64,
    /// Load of the gear.
    pub load: Load,
}

/// Parameters of a ring, separate for every element. Mesh i joins gear i and gear i + 1; the last mesh joins
/// gear n and gear 1.
///
/// ```
/// use gear_dynamics::{Ring, models::ring::RingSet};
/// let mut params = RingSet::set_a(4, 1000.0).params()?;
/// params.gears[2].load.torque = 3.0;
/// assert_eq!(Ring::new(&params)?.gears(), 4);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RingParams<N = Backlash> {
    /// Motor, joined to gear 1.
    pub motor: Motor,
    /// Gears in order, 3 to 4095.
    pub gears: Vec<Gear>,
    /// Meshes in order, one per gear. Their waves are functions of the mesh angle φ = ω t
    /// `[rad]`, with the mesh frequency ω.
    pub meshes: Vec<Mesh<N>>,
    /// Mesh dampings C_i [N s/m], one per mesh, not negative.
    pub mesh_damping: Vec<f64>,
    /// Mesh frequency ω [rad/s].
    pub omega: f64,
    /// Number of teeth of gear 1, whose mean speed is ω/`teeth`. It matters at a varying speed only.
    pub teeth: u32,
}

impl<N: Nonlinearity> RingParams<N> {
    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check::scale("motor.inertia", self.motor.inertia)?;
        check::quantity("motor.torque", self.motor.torque)?;
        self.motor.shaft.check("motor.shaft")?;
        check::at_least("gears of a closed ring", self.gears.len(), 3)?;
        check::count("gears of a closed ring", &[self.gears.len()], MAX_GEARS)?;
        check::length("meshes", self.meshes.len(), self.gears.len())?;
        for (i, gear) in self.gears.iter().enumerate() {
            check::scale(format!("gears[{i}].inertia"), gear.inertia)?;
            check::scale(format!("gears[{i}].base_radius"), gear.base_radius)?;
            check::scale(format!("gears[{i}].load.inertia"), gear.load.inertia)?;
            check::quantity(format!("gears[{i}].load.torque"), gear.load.torque)?;
            gear.load.shaft.check(&format!("gears[{i}].load.shaft"))?;
        }
        check::length("mesh_damping", self.mesh_damping.len(), self.gears.len())?;
        for (i, damping) in self.mesh_damping.iter().enumerate() {
            check::not_negative(format!("mesh_damping[{i}]"), *damping)?;
        }
        check::scale("omega", self.omega)?;
        check::at_least("teeth", self.teeth as usize, 1)?;
        for (i, mesh) in self.meshes.iter().enumerate() {
            let jumps = format!("jumps of meshes[{i}].stiffness in a mesh period");
            check::count(jumps, &[mesh.stiffness().edges_per_turn()], MAX_JUMPS)?;
            check::positive(format!("meshes[{i}]: mean stiffness"), mesh.stiffness().mean())?;
        }
        Ok(())
    }
}

/// Parameters of the ring of Yao 2020. All gears, loads and meshes are equal except for the mesh phases.
///
/// K_i = k (1 + Σ_h a_h cos h(ωt + φ_i)), e_i = e sin(ωt + φ_i), ω = 2π z n/60 with the speed n [r/min].
///
/// Yao 2020 omits many of the values. Sets [`a`](RingSet::set_a) and [`e`](RingSet::set_e) supply them;
/// [models](crate::guide::models) gives their origin.
///
/// ```
/// use gear_dynamics::{Ring, models::ring::RingSet};
/// let set = RingSet { error: 10e-6, half_backlash: 2.65e-6, ..RingSet::set_a(3, 1000.0) };
/// let ring = Ring::as_printed(&set.params()?)?;
/// assert!((ring.rigid_acceleration() - 712.736_411_9).abs() < 1e-6); // [rad/s²], torques not balanced
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct RingSet {
    /// Number of gears.
    pub gears: usize,
    /// Speed of the gears n [r/min].
    pub rpm: f64,
    /// Number of teeth of each gear z.
    pub teeth: u32,
    /// Moment of inertia of the motor J_M [kg m²].
    pub motor_inertia: f64,
    /// Moment of inertia of each gear J [kg m²].
    pub gear_inertia: f64,
    /// Moment of inertia of each load J_L [kg m²].
    pub load_inertia: f64,
    /// Base radius of each gear R `[m]`.
    pub base_radius: f64,
    /// Shaft between motor and gear 1.
    pub motor_shaft: Shaft,
    /// Output shaft of each gear.
    pub output_shaft: Shaft,
    /// Mean mesh stiffness k [N/m].
    pub mesh_stiffness: f64,
    /// Cosine amplitudes a_h of the mesh stiffness over its mean `[1]`, from h = 1.
    pub stiffness_harmonics: Vec<f64>,
    /// Mesh damping C_g [N s/m].
    pub mesh_damping: f64,
    /// Half backlash b `[m]`, half of the backlash of the teeth.
    pub half_backlash: f64,
    /// Amplitude of the transmission error e `[m]`.
    pub error: f64,
    /// Mesh phases φ_i `[rad]`, one per mesh.
    pub phases: Vec<f64>,
    /// Motor torque T_M [N m].
    pub motor_torque: f64,
    /// Load torque T_L of each load [N m].
    pub load_torque: f64,
}

impl RingSet {
    /// Set A: printed geometry, mesh stiffness by ISO 6336-1 method B, transmission error of amplitude 1 μm,
    /// shafts with a damping ratio of 1 %.
    pub fn set_a(gears: usize, rpm: f64) -> Self {
        RingSet {
            gears,
            rpm,
            teeth: 30,
            motor_inertia: 0.03,
            gear_inertia: 0.001_801_880_957_981_94,
            load_inertia: 5.97e-3,
            base_radius: 0.056_381_557_247_154_504,
            motor_shaft: Shaft { stiffness: 973.157_411_834_650_8, damping: 0.025_722_833_964_290_64 },
            output_shaft: Shaft { stiffness: 24_912.829_742_967_06, damping: 0.117_443_414_477_269_11 },
            mesh_stiffness: 206_025_177.896_396_16,
            stiffness_harmonics: vec![
                0.342_925_318_200_537_45,
                -0.021_092_036_341_720_31,
                -0.112_578_717_802_194_36,
            ],
            mesh_damping: 1_069.791_561_337_394_3,
            half_backlash: 2.65e-5,
            error: 1e-6,
            // The bound limits memory only: `params` returns an error for more gears.
            phases: vec![0.0; gears.min(MAX_GEARS)],
            motor_torque: 44.0,
            load_torque: 2.0,
        }
    }

    /// Set E: constant mesh stiffness, stiffer motor shaft, lighter loads, transmission error of amplitude
    /// 0.2 μm. It has the natural frequency 325 Hz of Yao 2020.
    pub fn set_e(gears: usize, rpm: f64) -> Self {
        RingSet {
            load_inertia: 5.932_955_461_252_78e-4,
            motor_shaft: Shaft { stiffness: 24_912.829_742_967_06, damping: 0.026_029_677_824_478_948 },
            output_shaft: Shaft { stiffness: 24_912.829_742_967_06, damping: 0.013_338_326_741_706_2 },
            stiffness_harmonics: Vec::new(),
            error: 2e-7,
            ..RingSet::set_a(gears, rpm)
        }
    }

    /// Mesh frequency ω = 2π z n/60 [rad/s].
    pub fn omega(&self) -> f64 {
        TAU * f64::from(self.teeth) * self.rpm / 60.0
    }

    /// Converts to parameters of every element.
    ///
    /// # Errors
    /// No teeth; more than 4095 gears; a speed or mean mesh stiffness that is not positive; a negative mesh
    /// damping or half backlash; a number of phases other than that of the gears; a value beyond ±1e50.
    /// [`Ring::new`](crate::Ring) checks the others.
    pub fn params(&self) -> Result<RingParams, ParameterError> {
        check::at_least("teeth", self.teeth as usize, 1)?;
        check::count("gears", &[self.gears], MAX_GEARS)?;
        check::positive("rpm", self.rpm)?;
        check::positive("mesh_stiffness", self.mesh_stiffness)?;
        check::quantity("error", self.error)?;
        check::quantities("stiffness_harmonics", &self.stiffness_harmonics)?;
        check::length("phases", self.phases.len(), self.gears)?;
        check::quantities("phases", &self.phases)?;
        let omega = self.omega();
        let wave: Vec<_> = self.stiffness_harmonics.iter().map(|a| [self.mesh_stiffness * a, 0.0]).collect();
        let stiffness = Wave::new(Fourier::new(self.mesh_stiffness, &wave)?);
        let error = Wave::new(Fourier::new(0.0, &[[0.0, self.error]])?);
        let law = Backlash::new(self.half_backlash)?;
        let mesh = |phase: &f64| {
            Ok(Mesh::new(stiffness.clone().with_phase(*phase)?, error.clone().with_phase(*phase)?, law))
        };
        let meshes = self.phases.iter().map(mesh).collect::<Result<Vec<_>, ParameterError>>()?;
        let load = Load { inertia: self.load_inertia, torque: self.load_torque, shaft: self.output_shaft };
        let gear = Gear { inertia: self.gear_inertia, base_radius: self.base_radius, load };
        let motor = Motor { inertia: self.motor_inertia, torque: self.motor_torque, shaft: self.motor_shaft };
        let mesh_damping = vec![check::not_negative("mesh_damping", self.mesh_damping)?; self.gears];
        Ok(RingParams {
            motor,
            gears: vec![gear; self.gears],
            meshes,
            mesh_damping,
            omega,
            teeth: self.teeth,
        })
    }
}

/// Maximum number of jumps of a mesh stiffness in a mesh period. A solver ends a step at each jump.
pub(crate) const MAX_JUMPS: usize = 10_000;
