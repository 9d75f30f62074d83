//! Planetary sets.

use crate::error::{ParameterError, check};
use crate::excitation::Wave;
use crate::trains::parts::body::Body;
use crate::trains::parts::collection::Parts;
use crate::trains::parts::mesh_part::{MeshPart, Phase};
use crate::trains::train_error::TrainError;
use std::f64::consts::TAU;

/// The gears of a planetary set, each with its number of teeth, and the carrier, which has the masses of
/// planets without bearings. A member may be on a bearing, locked, grounded or restrained.
///
/// ```
/// use gear_dynamics::trains::{Body, Members};
/// let ring = (90, Body::new(5e-2).locked());
/// let (sun, planet) = ((30, Body::new(1e-3)), (30, Body::new(1e-3)));
/// let members = Members { sun, planet, ring, carrier: Body::new(3e-2) };
/// assert_eq!(members.planet.0, 30);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Members {
    /// Teeth and body of the sun.
    pub sun: (u32, Body),
    /// Teeth and body of each planet. Its bearing connects it to the carrier.
    pub planet: (u32, Body),
    /// Teeth and body of the ring.
    pub ring: (u32, Body),
    /// The carrier.
    pub carrier: Body,
}

/// A planetary set of a sun, N planets on a carrier and a ring.
///
/// Without bearings it is torsional (Kahraman 1994, J. Sound Vib. 173, 125). With bearings it has three
/// coordinates a body (Lin and Parker 1999, J. Vib. Acoust. 121, 316); nonlinear with a half backlash.
///
/// Bodies: `sun`, `ring`, `carrier`, `planet 1` to `planet N`. Meshes: `sun 1`, `ring 1` and so on. The sun
/// drives the planets, and the planets drive the ring. Base radii follow from the tooth numbers; the centres
/// lie at (r_s + r_p)/cos α.
///
/// ```
/// use gear_dynamics::trains::{Body, Members, Planetary};
/// use gear_dynamics::{Model, Wave};
/// let ring = (90, Body::new(5e-2).grounded(1e9, 0.0)); // by a spring to the ground
/// let (sun, planet) = ((30, Body::new(1e-3)), (30, Body::new(1e-3)));
/// let members = Members { sun, planet, ring, carrier: Body::new(3e-2) };
/// let set = Planetary::new(3, 0.03, members, [Wave::constant(2e8)?, Wave::constant(2.5e8)?])?;
/// assert_eq!(set.parts().build("sun", 100.0)?.dof(), 6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct Planetary {
    members: Members,
    angles: Vec<f64>,
    sun_radius: f64,
    stiffness: [Wave; 2],
    error: [Wave; 2],
    pressure_angle: f64,
    ring_phase: Phase,
    damping: f64,
    half_backlash: f64,
}

impl Planetary {
    /// A set of N equally spaced planets: base radius of the sun `[m]`, members, stiffnesses of a sun mesh
    /// and of a ring mesh over the mesh angle.
    ///
    /// # Errors
    /// No planets or more than 100; a base radius out of range. Other values are checked by [`Parts::build`].
    pub fn new(
        planets: u32,
        sun_base_radius: f64,
        members: Members,
        stiffness: [Wave; 2],
    ) -> Result<Self, ParameterError> {
        check::at_least("planets", planets as usize, 1)?;
        check::count("planets", &[planets as usize], 100)?;
        check::scale("base radius of the sun", sun_base_radius)?;
        Ok(Planetary {
            members,
            angles: (0..planets).map(|p| TAU * f64::from(p) / f64::from(planets)).collect(),
            sun_radius: sun_base_radius,
            stiffness,
            error: [Wave::zero(), Wave::zero()],
            pressure_angle: 20f64.to_radians(),
            ring_phase: Phase::Ahead(0.0),
            damping: 0.0,
            half_backlash: 0.0,
        })
    }
    /// The same set with planets at the given angles `[rad]`.
    pub fn angles(self, angles: &[f64]) -> Self {
        Planetary { angles: angles.to_vec(), ..self }
    }
    /// The same set with the working pressure angle `[rad]` of the sun meshes. Default: 20°. That of the ring
    /// meshes follows from the common centre distance: (z_s + z_p)/cos α_s = (z_r - z_p)/cos α_r.
    pub fn pressure_angle(self, pressure_angle: f64) -> Self {
        Planetary { pressure_angle, ..self }
    }
    /// The same set with the transmission errors `[m]` of a sun mesh and of a ring mesh over the mesh angle.
    pub fn error(self, error: [Wave; 2]) -> Self {
        Planetary { error, ..self }
    }
    /// The same set with the ring mesh of each planet ahead of its sun mesh by a part of the cycle.
    /// Default: 0.
    pub fn ring_phase(self, cycles: f64) -> Self {
        Planetary { ring_phase: Phase::Ahead(cycles), ..self }
    }
    /// The same set with the phase between ring and sun mesh that follows from teeth as thick as their gaps:
    /// 1/2 for planets with an even number of teeth, 0 for an odd number ([`MeshPart::phase_from_teeth`]).
    pub fn ring_phase_from_teeth(self) -> Self {
        Planetary { ring_phase: Phase::FromTeeth, ..self }
    }
    /// The same set with a damping c [N s/m] in each mesh.
    pub fn damping(self, damping: f64) -> Self {
        Planetary { damping, ..self }
    }
    /// The same set with half a backlash b `[m]` in each mesh.
    pub fn half_backlash(self, half_backlash: f64) -> Self {
        Planetary { half_backlash, ..self }
    }

    /// Its parts, to which shafts, torques and other bodies can be added.
    pub fn parts(&self) -> Parts {
        let mut parts = Parts::new();
        let Members { sun, planet, ring, carrier } = &self.members;
        let [zs, zp, zr] = [sun, planet, ring].map(|gear| f64::from(gear.0));
        let [rs, rp, rr] = [zs, zp, zr].map(|z| self.sun_radius * z / zs);
        let outer_angle = if zr - zp == zs + zp {
            self.pressure_angle
        } else {
            libm::acos((zr - zp) / (zs + zp) * libm::cos(self.pressure_angle))
        };
        // Other values of the angle and of the tooth numbers are refused as such.
        let is_angle = (0.0..=1.4).contains(&self.pressure_angle);
        let has_none = zr <= zp || outer_angle.is_nan();
        if is_angle && [sun.0, planet.0, ring.0].iter().all(|z| *z > 0) && has_none {
            let [sun, planet, ring] = [sun.0, planet.0, ring.0];
            let near = u64::from(sun) + 2 * u64::from(planet);
            parts.fault = Some(TrainError::RingTeeth { sun, planet, ring, near });
        }
        parts.body("sun", sun.1.clone()).body("ring", ring.1.clone()).body("carrier", carrier.clone());
        for (p, angle) in (1..).zip(&self.angles) {
            let name = format!("planet {p}");
            parts.body(&name, planet.1.clone().carried_by("carrier", *angle));
            let finish = |mesh: MeshPart, i: usize| {
                mesh.error(self.error[i].clone())
                    .damping(self.damping)
                    .half_backlash(self.half_backlash)
                    .pressure_angle([self.pressure_angle, outer_angle][i])
            };
            let inner = MeshPart::external([sun.0, planet.0], [rs, rp], self.stiffness[0].clone());
            parts.mesh(&format!("sun {p}"), "sun", &name, finish(inner, 0).phase_or_zero());
            let outer = MeshPart::internal([planet.0, ring.0], [rp, rr], self.stiffness[1].clone());
            let mut outer = finish(outer, 1);
            outer.gears.phase = self.ring_phase;
            parts.mesh(&format!("ring {p}"), &name, "ring", outer);
        }
        parts
    }
}
