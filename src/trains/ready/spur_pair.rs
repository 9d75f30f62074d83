//! The spur gear pair with one degree of freedom.

use crate::error::{ParameterError, check};
use crate::excitation::{Fourier, Scaled, Wave};
use crate::trains::parts::body::Body;
use crate::trains::parts::collection::{Coordinates, Parts};
use crate::trains::parts::mesh_part::MeshPart;

/// The spur gear pair of Kahraman and Singh 1990 (J. Sound Vib. 142, 49), in SI units or dimensionless.
///
/// m_e x'' + c x' + k(φ) f(x) = F_m - m_e e''(φ),   x = r_1 q_1 - r_2 q_2 - e,
/// m_e = 1/(r_1²/I_1 + r_2²/I_2)
///
/// with the lengths in units of half the backlash b and times in 1/ω_n = √(m_e/k_m):
///
/// x'' + 2 ζ x' + k/k_m f(x) = F_m/(b k_m) - (e/b)''.
///
/// Bodies: `driver` and `driven`; mesh: `mesh`; torques: `drive torque` and `load torque`. The coordinate is
/// θ_1 - θ_2 z_2/z_1: the deviation of the driver relative to the driven gear.
///
/// ```
/// use gear_dynamics::trains::SpurPair;
/// use gear_dynamics::{Model, Wave, excitation::Fourier};
/// let stiffness = Wave::new(Fourier::new(3e8, &[[6e7, 0.0]])?);
/// let pair = SpurPair::new([1e-3, 1e-3], [50, 50], [0.07, 0.07], stiffness)?
///     .damping_ratio(0.05)
///     .half_backlash(5e-5)
///     .load(150.0);
/// let numbers = pair.dimensionless();
/// assert!((numbers.mean_force - 150.0 / 0.07 / (3e8 * 5e-5)).abs() < 1e-12);
/// assert_eq!(pair.parts()?.build("driver", 100.0)?.dof(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SpurPair {
    inertias: [f64; 2],
    teeth: [u32; 2],
    radii: [f64; 2],
    stiffness: Wave,
    mean_stiffness: f64,
    error: Wave,
    damping_ratio: f64,
    half_backlash: f64,
    load: f64,
    dimensionless: bool,
}

/// The dimensionless numbers of a [`SpurPair`].
///
/// ```
/// # use gear_dynamics::trains::SpurPair;
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[0.2], &[0.05])?;
/// let numbers = pair.dimensionless();
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
    /// over the mesh angle. Defaults: no error, damping, backlash and load.
    ///
    /// # Errors
    /// An inertia or radius out of range; a mean stiffness that is not positive.
    pub fn new(
        inertias: [f64; 2],
        teeth: [u32; 2],
        base_radii: [f64; 2],
        stiffness: Wave,
    ) -> Result<Self, ParameterError> {
        for i in [0, 1] {
            check::scale(format!("inertia [{i}]"), inertias[i])?;
            check::scale(format!("base radius [{i}]"), base_radii[i])?;
        }
        let mean_stiffness = check::scale("mean mesh stiffness", stiffness.mean())?;
        Ok(SpurPair {
            inertias,
            teeth,
            radii: base_radii,
            stiffness,
            mean_stiffness,
            error: Wave::constant(0.0)?,
            damping_ratio: 0.0,
            half_backlash: 0.0,
            load: 0.0,
            dimensionless: false,
        })
    }

    /// The dimensionless pair x'' + 2 ζ x' + (1 + Σ a_j cos jφ) f(x) = F_m + W² Σ j² e_j cos jφ with half the
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
        let pair = pair.damping_ratio(damping_ratio).half_backlash(1.0).load(mean_force);
        Ok(SpurPair { dimensionless: true, ..pair })
    }

    /// The same pair with a static transmission error `[m]` over the mesh angle.
    pub fn error(self, error: Wave) -> Self {
        SpurPair { error, ..self }
    }
    /// The same pair with a damping ratio ζ.
    pub fn damping_ratio(self, damping_ratio: f64) -> Self {
        SpurPair { damping_ratio, ..self }
    }
    /// The same pair with half a backlash b `[m]` along the line of action.
    pub fn half_backlash(self, half_backlash: f64) -> Self {
        SpurPair { half_backlash, ..self }
    }
    /// The same pair with a torque on the driver [N m], which the load balances.
    pub fn load(self, torque: f64) -> Self {
        SpurPair { load: torque, ..self }
    }

    /// Its dimensionless numbers. Without backlash the mean force is infinite.
    pub fn dimensionless(&self) -> Dimensionless {
        let mass = 1.0 / (0..2).map(|i| self.radii[i] * self.radii[i] / self.inertias[i]).sum::<f64>();
        Dimensionless {
            damping_ratio: self.damping_ratio,
            mean_force: self.load / self.radii[0] / (self.half_backlash * self.mean_stiffness),
            natural_frequency: (self.mean_stiffness / mass).sqrt(),
            half_backlash: self.half_backlash,
            mass,
        }
    }

    /// The same pair in dimensionless form: lengths over b, times over 1/ω_n.
    ///
    /// # Errors
    /// No backlash, or one outside 1e-50 .. 1e50.
    pub fn scaled(&self) -> Result<Self, ParameterError> {
        let numbers = self.dimensionless();
        let b = check::scale("half backlash", self.half_backlash)?;
        let by =
            |factor: f64, wave: &Wave| Ok::<_, ParameterError>(Wave::new(Scaled::new(factor, wave.clone())?));
        let (stiffness, error) = (by(1.0 / self.mean_stiffness, &self.stiffness)?, by(1.0 / b, &self.error)?);
        SpurPair::unit(stiffness, error, self.damping_ratio, numbers.mean_force)
    }

    /// Its parts in relative coordinates, with both torques.
    ///
    /// # Errors
    /// A damping ratio that is not a number.
    pub fn parts(&self) -> Result<Parts, ParameterError> {
        let mut parts = Parts::new();
        let numbers = self.dimensionless();
        check::not_negative("damping ratio", self.damping_ratio)?;
        let damping = 2.0 * self.damping_ratio * (self.mean_stiffness * numbers.mass).sqrt();
        parts.body("driver", Body::new(self.inertias[0])).body("driven", Body::new(self.inertias[1]));
        let mesh = MeshPart::external(self.teeth, self.radii, self.stiffness.clone());
        let mesh = mesh.error(self.error.clone()).damping(damping).half_backlash(self.half_backlash);
        parts.mesh("mesh", "driver", "driven", mesh).coordinates(Coordinates::Relative);
        parts.torque("drive torque", "driver", self.load);
        parts.torque("load torque", "driven", -self.load * self.radii[1] / self.radii[0]);
        if self.dimensionless {
            parts.without_units();
        }
        Ok(parts)
    }
}
