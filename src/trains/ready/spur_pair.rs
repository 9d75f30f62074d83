//! The spur gear pair with one degree of freedom.

use crate::contact::Nonlinearity;
use crate::error::{ParameterError, check};
use crate::excitation::{Fourier, Scaled, Wave};
use crate::teeth::{GearPair, PotentialEnergy, QualityGrade, TeethError, TransmissionError};
use crate::trains::parts::body::Body;
use crate::trains::parts::collection::Parts;
use crate::trains::parts::coordinates::Coordinates;
use crate::trains::parts::mesh_part::MeshPart;

/// The spur gear pair of Kahraman and Singh 1990 (J. Sound Vib. 142, 49), in SI units or dimensionless.
///
/// m_e d'' + c d' + k(φ) f(d) = F_m - m_e e''(φ),   d = r_1 q_1 - r_2 q_2 - e,
/// m_e = 1/(r_1²/I_1 + r_2²/I_2)
///
/// with the lengths in units of half the backlash b and times in 1/ω_n = √(m_e/k_m):
///
/// d'' + 2 ζ d' + k/k_m f(d) = F_m/(b k_m) - (e/b)''.
///
/// Bodies: `driver` and `driven`; mesh: `mesh`; torque: `drive torque` on the driver, which the load on the
/// driven gear balances ([`Parts::load`]). The coordinate is θ_1 - θ_2 z_2/z_1: the deviation of the driver
/// relative to the driven gear.
///
/// ```
/// use gear_dynamics::teeth::{GearPair, InvoluteGear};
/// use gear_dynamics::trains::SpurPair;
/// use gear_dynamics::Model;
/// let gear = InvoluteGear::external(50, 0.003)?.with_face_width(0.02)?; // teeth, module [m], width [m]
/// // Bores [m], grades of ISO 1328-1, harmonics of the mesh stiffness.
/// let pair = SpurPair::of_teeth(&GearPair::new(&gear, &gear)?, [0.03; 2], [6; 2], 3)?
///     .damping(2000.0) // N s/m
///     .half_backlash(4e-5) // m
///     .drive_torque(300.0); // N m
/// let numbers = pair.dimensionless()?;
/// assert!((numbers.damping_ratio - 0.0644).abs() < 5e-5 && (numbers.mean_force - 0.3458).abs() < 5e-5);
/// assert_eq!(pair.parts()?.build("driver", 300.0)?.dof(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct SpurPair {
    inertias: [f64; 2],
    /// Without its damping.
    mesh: MeshPart,
    mean_stiffness: f64,
    damping: Damping,
    /// `None`: no torques.
    drive_torque: Option<f64>,
    dimensionless: bool,
}

/// The damping of the mesh, as it is stated.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Damping {
    /// ζ `[1]`.
    Ratio(f64),
    /// c `[N s/m]`.
    Coefficient(f64),
}

/// Density of steel [kg/m³].
const STEEL: f64 = 7850.0;

/// The dimensionless numbers of a [`SpurPair`].
///
/// ```
/// # use gear_dynamics::trains::SpurPair;
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[0.2], &[0.05])?;
/// let numbers = pair.dimensionless()?;
/// assert!(numbers.damping_ratio == 0.05 && (numbers.mean_force - 0.1).abs() < 1e-15);
/// let train = pair.parts()?.build("driver", 0.8)?;
/// assert_eq!(train.names()[0].to_string(), "speed [1]"); // the mesh frequency W
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimensionless {
    /// ζ = c/(2 √(m_e k_m)).
    pub damping_ratio: f64,
    /// F_m/(b k_m): mean force over half the backlash.
    pub mean_force: f64,
    /// Unit of frequency ω_n [rad/s]: the mesh frequency of the dimensionless pair is z_1 ω_1/ω_n.
    pub natural_frequency: f64,
    /// Unit of length b `[m]`.
    pub half_backlash: f64,
    /// m_e `[kg]`.
    pub mass: f64,
}

impl SpurPair {
    /// The pair of the given moments of inertia [kg m²], teeth, base radii `[m]` and mesh stiffness [N/m]
    /// over the mesh angle. Defaults: no error, damping, backlash and torque.
    ///
    /// # Errors
    /// An inertia or radius out of range; a mean stiffness that is not positive.
    pub fn new(
        inertias: [f64; 2],
        teeth: [u32; 2],
        base_radii: [f64; 2],
        stiffness: Wave,
    ) -> Result<Self, ParameterError> {
        SpurPair::of_mesh(inertias, MeshPart::external(teeth, base_radii, stiffness))
    }

    /// The pair of two steel gears as a drawing states them: bores `[m]`, grades of ISO 1328-1, and the
    /// number of harmonics after which the mesh stiffness is cut.
    ///
    /// - I_j: [`InvoluteGear::blank`](crate::teeth::InvoluteGear::blank) of 7850 kg/m³;
    /// - k(φ): [`PotentialEnergy::ma_2014`], its Fourier series: uncut it jumps. The fillet foundation is
    ///   stated for gears of about 26 teeth or more, and extrapolated for smaller ones
    ///   ([`extrapolated`](PotentialEnergy::extrapolated));
    /// - e(φ): [`TransmissionError::of_grade`], the term of the mesh cycle, without run-out;
    /// - b: half of the backlash of the pair along the line of action, as [`MeshPart::of_pair`]. **At the
    ///   nominal centre distance of uncorrected gears it is 0**: then teeth never part.
    ///
    /// [`error`](SpurPair::error) and [`half_backlash`](SpurPair::half_backlash) replace the last two. A pair
    /// of other inertias or of another stiffness: [`new`](SpurPair::new). Defaults: no damping and no torque.
    ///
    /// # Errors
    /// Teeth, bores or grades to which one of these methods does not apply; more than 1000 harmonics.
    pub fn of_teeth(
        pair: &GearPair,
        bores: [f64; 2],
        grades: [u32; 2],
        harmonics: usize,
    ) -> Result<Self, TeethError> {
        let stiffness =
            PotentialEnergy::ma_2014(bores)?.extrapolated().wave(pair)?.fourier_series(harmonics)?;
        let grades = [QualityGrade::new(grades[0])?, QualityGrade::new(grades[1])?];
        let error = TransmissionError::of_grade(pair, grades)?.tooth().clone();
        let inertia = |i: usize| pair.gears()[i].blank(bores[i], STEEL).map(|blank| blank.polar_inertia);
        let mesh = MeshPart::of_pair(pair, Wave::new(stiffness)).error(Wave::new(error));
        Ok(SpurPair::of_mesh([inertia(0)?, inertia(1)?], mesh)?)
    }

    fn of_mesh(inertias: [f64; 2], mesh: MeshPart) -> Result<Self, ParameterError> {
        for i in [0, 1] {
            check::scale(format!("inertia [{i}]"), inertias[i])?;
            check::scale(format!("base radius [{i}]"), mesh.gears.radii[i])?;
        }
        let mean_stiffness = check::scale("mean mesh stiffness", mesh.gears.stiffness.mean())?;
        let damping = Damping::Coefficient(0.0);
        Ok(SpurPair { inertias, mesh, mean_stiffness, damping, drive_torque: None, dimensionless: false })
    }

    /// The dimensionless pair d'' + 2 ζ d' + (1 + Σ a_j cos jφ) f(d) = F_m + W² Σ j² e_j cos jφ with half the
    /// backlash 1 and one tooth a turn: its speed is the mesh frequency W.
    ///
    /// # Errors
    /// A harmonic beyond ±1e50; more than 10 000.
    pub fn of_numbers(
        damping_ratio: f64,
        mean_force: f64,
        stiffness: &[f64],
        error: &[f64],
    ) -> Result<Self, ParameterError> {
        let wave = |mean: f64, list: &[f64]| {
            let cosines: Vec<[f64; 2]> = list.iter().map(|a| [*a, 0.0]).collect();
            Ok::<_, ParameterError>(Wave::new(Fourier::new(mean, &cosines)?))
        };
        SpurPair::unit(wave(1.0, stiffness)?, wave(0.0, error)?, damping_ratio, mean_force)
    }

    /// The dimensionless pair of the waves k/k_m and e/b.
    fn unit(
        stiffness: Wave,
        error: Wave,
        damping_ratio: f64,
        mean_force: f64,
    ) -> Result<Self, ParameterError> {
        let pair = SpurPair::new([2.0, 2.0], [1, 1], [1.0, 1.0], stiffness)?.error(error);
        let pair = pair.damping_ratio(damping_ratio).half_backlash(1.0).drive_torque(mean_force);
        Ok(SpurPair { dimensionless: true, ..pair })
    }

    /// The same pair with a static transmission error `[m]` over the mesh angle.
    pub fn error(self, error: Wave) -> Self {
        SpurPair { mesh: self.mesh.error(error), ..self }
    }
    /// The same pair with a mesh damping c [N s/m] along the line of action.
    pub fn damping(self, damping: f64) -> Self {
        SpurPair { damping: Damping::Coefficient(damping), ..self }
    }
    /// The same pair with a damping ratio ζ, that is, the mesh damping c = 2 ζ √(m_e k_m).
    pub fn damping_ratio(self, damping_ratio: f64) -> Self {
        SpurPair { damping: Damping::Ratio(damping_ratio), ..self }
    }
    /// The same pair with half a backlash b `[m]` along the line of action.
    pub fn half_backlash(self, half_backlash: f64) -> Self {
        SpurPair { mesh: self.mesh.half_backlash(half_backlash), ..self }
    }
    /// The same pair with a torque on the driver [N m], which the load balances, also if the constant
    /// `drive torque` is replaced. Default: no torques; those of one's own are added to the
    /// [`parts`](SpurPair::parts).
    pub fn drive_torque(self, torque: f64) -> Self {
        SpurPair { drive_torque: Some(torque), ..self }
    }

    /// Its dimensionless numbers. Without backlash the mean force of a torque is infinite.
    ///
    /// # Errors
    /// A damping or damping ratio that is negative or beyond 1e50; half a backlash that is negative or beyond
    /// 1e50; a torque beyond ±1e50.
    pub fn dimensionless(&self) -> Result<Dimensionless, ParameterError> {
        let gears = &self.mesh.gears;
        let half_backlash = check::not_negative("half backlash", gears.half_backlash)?;
        let mass = self.mass();
        let damping_ratio = match self.damping {
            Damping::Ratio(ratio) => check::not_negative("damping ratio", ratio)?,
            Damping::Coefficient(damping) => {
                check::not_negative("damping", damping)? / (2.0 * (self.mean_stiffness * mass).sqrt())
            }
        };
        let mean_force = match self.drive_torque {
            Some(torque) => {
                let force = check::quantity("drive torque", torque)? / gears.radii[0];
                force / (half_backlash * self.mean_stiffness)
            }
            None => 0.0,
        };
        let natural_frequency = (self.mean_stiffness / mass).sqrt();
        Ok(Dimensionless { damping_ratio, mean_force, natural_frequency, half_backlash, mass })
    }
    /// m_e `[kg]`.
    fn mass(&self) -> f64 {
        let radii = self.mesh.gears.radii;
        1.0 / (0..2).map(|i| radii[i] * radii[i] / self.inertias[i]).sum::<f64>()
    }

    /// The same pair in dimensionless form: lengths over b, times over 1/ω_n.
    ///
    /// # Errors
    /// No backlash, or one outside 1e-50 .. 1e50.
    pub fn scaled(&self) -> Result<Self, ParameterError> {
        let (numbers, gears) = (self.dimensionless()?, &self.mesh.gears);
        let b = check::scale("half backlash", gears.half_backlash)?;
        let by =
            |factor: f64, wave: &Wave| Ok::<_, ParameterError>(Wave::new(Scaled::new(factor, wave.clone())?));
        let (stiffness, error) =
            (by(1.0 / self.mean_stiffness, &gears.stiffness)?, by(1.0 / b, &gears.error)?);
        let pair = SpurPair::unit(stiffness, error, numbers.damping_ratio, numbers.mean_force)?;
        Ok(SpurPair { drive_torque: self.drive_torque.and(pair.drive_torque), ..pair })
    }

    /// Its parts in relative coordinates, with the drive torque and the load.
    ///
    /// # Errors
    /// A damping or damping ratio that is negative or not a number.
    pub fn parts(&self) -> Result<Parts, ParameterError> {
        self.parts_of(self.mesh.clone())
    }

    /// The same parts with another contact law, whose half backlash replaces that of the pair
    /// ([`MeshPart::law`]).
    ///
    /// # Errors
    /// As [`parts`](SpurPair::parts).
    pub fn parts_with_law<N: Nonlinearity>(&self, law: N) -> Result<Parts<N>, ParameterError> {
        self.parts_of(self.mesh.clone().law(law))
    }

    fn parts_of<N: Nonlinearity>(&self, mesh: MeshPart<N>) -> Result<Parts<N>, ParameterError> {
        let damping = match self.damping {
            Damping::Ratio(ratio) => {
                let root = (self.mean_stiffness * self.mass()).sqrt();
                2.0 * check::not_negative("damping ratio", ratio)? * root
            }
            Damping::Coefficient(damping) => check::not_negative("damping", damping)?,
        };
        let mut parts = Parts::default();
        parts.body("driver", Body::new(self.inertias[0])).body("driven", Body::new(self.inertias[1]));
        parts.mesh("mesh", "driver", "driven", mesh.damping(damping)).coordinates(Coordinates::Relative);
        if let Some(torque) = self.drive_torque {
            parts.torque("drive torque", "driver", torque).load("driven");
        }
        if self.dimensionless {
            parts.without_units();
        }
        Ok(parts)
    }
}
