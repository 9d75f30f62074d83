//! Parameters of the ring.

use crate::contact::laws::backlash::Backlash;
use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::mesh::Mesh;
use crate::error::{ParameterError, check};
use crate::excitation::fourier::Fourier;
use crate::excitation::side::Side;
use crate::excitation::wave::Wave;
use std::f64::consts::TAU;

/// Most gears of a ring: its matrices, of 2n + 1 rows, then have at most 2²⁶ numbers.
const MOST_GEARS: usize = 4095;

/// A torsional shaft.
///
/// ```
/// let shaft = gear_dynamics::models::ring::Shaft { stiffness: 973.0, damping: 0.0257 };
/// assert_eq!(shaft.stiffness, 973.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
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
/// use gear_dynamics::models::ring::{Motor, Shaft};
/// let motor = Motor { inertia: 0.03, torque: 44.0, shaft: Shaft { stiffness: 973.0, damping: 0.0257 } };
/// assert_eq!(motor.torque, 44.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// J_M [kg m²].
    pub inertia: f64,
    /// T_M [N m].
    pub torque: f64,
    /// Motor shaft.
    pub shaft: Shaft,
}

/// A load and its shaft from the gear.
///
/// ```
/// use gear_dynamics::models::ring::{Load, Shaft};
/// let load = Load { inertia: 5.97e-3, torque: 2.0, shaft: Shaft { stiffness: 24_913.0, damping: 0.117 } };
/// assert_eq!(load.inertia, 5.97e-3);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// J_L [kg m²].
    pub inertia: f64,
    /// T_L [N m], against the rotation.
    pub torque: f64,
    /// Output shaft.
    pub shaft: Shaft,
}

/// A gear of the ring with what hangs on it.
///
/// ```
/// use gear_dynamics::models::ring::{Gear, Load, Shaft};
/// let load = Load { inertia: 5.97e-3, torque: 2.0, shaft: Shaft { stiffness: 24_913.0, damping: 0.117 } };
/// assert_eq!(Gear { inertia: 1.8e-3, base_radius: 0.0564, load }.base_radius, 0.0564);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gear {
    /// J_i [kg m²].
    pub inertia: f64,
    /// Base radius R_i `[m]`.
    pub base_radius: f64,
    /// Its load.
    pub load: Load,
}

/// A ring in full generality: every parameter its own per element. Mesh i joins gear i and gear i+1, the last one closes the ring.
///
/// ```
/// use gear_dynamics::{Ring, models::ring::RingSet};
/// let mut params = RingSet::a(4, 1000.0).params()?;
/// params.gears[2].load.torque = 3.0;
/// assert_eq!(Ring::new(&params)?.gears(), 4);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RingParams<N = Backlash> {
    /// The motor on gear 1.
    pub motor: Motor,
    /// The gears in order.
    pub gears: Vec<Gear>,
    /// The meshes in order, as many as gears. Their waves are of the mesh angle φ = ω t.
    pub meshes: Vec<Mesh<N>>,
    /// Damping of each mesh C_i [N s/m], not negative.
    pub mesh_damping: Vec<f64>,
    /// Mesh frequency ω [rad/s].
    pub omega: f64,
}

impl<N: Nonlinearity> RingParams<N> {
    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check::scale("motor.inertia", self.motor.inertia)?;
        check::quantity("motor.torque", self.motor.torque)?;
        self.motor.shaft.check("motor.shaft")?;
        if self.gears.len() < 3 {
            return Err(ParameterError::TooFew {
                name: "gears of a closed ring".into(),
                value: self.gears.len(),
                least: 3,
            });
        }
        check::count("gears of a closed ring", &[self.gears.len()], MOST_GEARS)?;
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
        for (i, mesh) in self.meshes.iter().enumerate() {
            let jumps = format!("jumps of meshes[{i}].stiffness in a mesh period");
            check::count(jumps, &[mesh.stiffness().edges_per_turn()], MOST_JUMPS)?;
            check::positive(format!("meshes[{i}]: mean stiffness"), mean(mesh.stiffness()))?;
        }
        Ok(())
    }
}

/// The ring of Yao 2020 in plain numbers, equal in all its elements but for the mesh phases:
/// K_i = k (1 + Σ_h a_h cos h(ωt + φ_i)), e_i = e sin(ωt + φ_i), ω = 2π z n/60.
///
/// The paper leaves many of them out; sets [`a`](RingSet::a) and [`e`](RingSet::e) fill the gaps as docs/models.md says.
///
/// ```
/// use gear_dynamics::{Ring, models::ring::RingSet};
/// let set = RingSet { error: 10e-6, half_backlash: 2.65e-6, ..RingSet::a(3, 1000.0) };
/// let ring = Ring::as_printed(&set.params()?)?;
/// assert!((ring.rigid_acceleration() - 712.736_411_9).abs() < 1e-6); // [rad/s²]: the torques do not balance
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct RingSet {
    /// Number of gears n.
    pub gears: usize,
    /// Speed of the gears [r/min].
    pub rpm: f64,
    /// Teeth of each gear z.
    pub teeth: u32,
    /// J_M [kg m²].
    pub motor_inertia: f64,
    /// J [kg m²].
    pub gear_inertia: f64,
    /// J_L [kg m²].
    pub load_inertia: f64,
    /// R `[m]`.
    pub base_radius: f64,
    /// Motor shaft.
    pub motor_shaft: Shaft,
    /// Output shafts.
    pub output_shaft: Shaft,
    /// Mean mesh stiffness k [N/m].
    pub mesh_stiffness: f64,
    /// a_h `[1]`, from h = 1.
    pub stiffness_harmonics: Vec<f64>,
    /// Mesh damping C_g [N s/m].
    pub mesh_damping: f64,
    /// Half backlash b `[m]`.
    pub half_backlash: f64,
    /// Amplitude of the transmission error e `[m]`.
    pub error: f64,
    /// Mesh phases φ_i `[rad]`.
    pub phases: Vec<f64>,
    /// T_M [N m].
    pub motor_torque: f64,
    /// T_L [N m] on each output.
    pub load_torque: f64,
}

impl RingSet {
    /// Set A: geometry and stiffness by ISO 6336-1 method B, error 1 μm, shafts with 1 % damping.
    pub fn a(gears: usize, rpm: f64) -> Self {
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
            // A ring beyond all bounds is refused by `params`.
            phases: vec![0.0; gears.min(MOST_GEARS)],
            motor_torque: 44.0,
            load_torque: 2.0,
        }
    }

    /// Set E: constant stiffness, a stiffer motor shaft, lighter loads, error 0.2 μm: it has the 325 Hz of the paper.
    pub fn e(gears: usize, rpm: f64) -> Self {
        RingSet {
            load_inertia: 5.932_955_461_252_78e-4,
            motor_shaft: Shaft { stiffness: 24_912.829_742_967_06, damping: 0.026_029_677_824_478_948 },
            output_shaft: Shaft { stiffness: 24_912.829_742_967_06, damping: 0.013_338_326_741_706_2 },
            stiffness_harmonics: Vec::new(),
            error: 2e-7,
            ..RingSet::a(gears, rpm)
        }
    }

    /// Mesh frequency ω = 2π z n/60 [rad/s].
    pub fn omega(&self) -> f64 {
        TAU * f64::from(self.teeth) * self.rpm / 60.0
    }

    /// The ring as full parameters.
    ///
    /// # Errors
    /// No teeth; more than 4095 gears; a speed or mean stiffness that is not positive; phases not as many as gears; a number beyond ±1e50.
    pub fn params(&self) -> Result<RingParams, ParameterError> {
        if self.teeth == 0 {
            return Err(ParameterError::TooFew { name: "teeth".into(), value: 0, least: 1 });
        }
        check::count("gears", &[self.gears], MOST_GEARS)?;
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
        let mesh =
            |phase: &f64| Ok(Mesh::new(stiffness.clone().ahead(*phase)?, error.clone().ahead(*phase)?, law));
        let meshes = self.phases.iter().map(mesh).collect::<Result<Vec<_>, ParameterError>>()?;
        let load = Load { inertia: self.load_inertia, torque: self.load_torque, shaft: self.output_shaft };
        let gear = Gear { inertia: self.gear_inertia, base_radius: self.base_radius, load };
        let motor = Motor { inertia: self.motor_inertia, torque: self.motor_torque, shaft: self.motor_shaft };
        let mesh_damping = vec![check::not_negative("mesh_damping", self.mesh_damping)?; self.gears];
        Ok(RingParams { motor, gears: vec![gear; self.gears], meshes, mesh_damping, omega })
    }
}

/// Most jumps of a stiffness in a mesh period: a solver ends a step on each.
pub(crate) const MOST_JUMPS: usize = 10_000;

/// The mean of a wave over its own period, between its edges by Gauss panels.
pub(crate) fn mean(wave: &Wave) -> f64 {
    const PANELS: usize = 64;
    let period = TAU / f64::from(wave.order());
    let (mut sum, mut angle) = (0.0, 0.0);
    while angle < period {
        let end = wave.next_edge(angle).map_or(period, |edge| edge.min(period));
        for i in 0..PANELS {
            let h = (end - angle) / PANELS as f64;
            let middle = angle + (i as f64 + 0.5) * h;
            sum += crate::analysis::quadrature::gauss(middle - 0.5 * h, middle + 0.5 * h, |x| {
                wave.value(x, Side::After)
            });
        }
        angle = end;
    }
    sum / period
}
