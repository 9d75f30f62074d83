//! Planetary sets.

use crate::error::{ParameterError, check};
use crate::excitation::angle::Constant;
use crate::excitation::wave::Wave;
use crate::trains::kinds::equally_spaced;
use crate::trains::parts::body::{Bearing, Body};
use crate::trains::parts::collection::Parts;
use crate::trains::parts::mesh_part::{MeshPart, Phase};

/// A central member of a planetary set.
///
/// ```
/// use gear_dynamics::trains::Central;
/// assert_eq!(Central::Carrier as usize, 2);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Central {
    /// The sun.
    Sun = 0,
    /// The ring.
    Ring = 1,
    /// The carrier.
    Carrier = 2,
}

/// A planetary set of a sun, N planets on a carrier and a ring.
///
/// Without bearings it is torsional (Kahraman 1994, J. Sound Vib. 173, 125). With bearings it has three coordinates a
/// body (Lin and Parker 1999, J. Vib. Acoust. 121, 316); nonlinear with a half backlash.
///
/// Bodies: `sun`, `ring`, `carrier`, `planet 1` to `planet N`. Meshes: `sun 1`, `ring 1` and so on. The sun drives
/// the planets, and the planets drive the ring. Base radii follow from the tooth numbers; the centres lie at (r_s +
/// r_p)/cos α.
///
/// ```
/// use gear_dynamics::trains::Planetary;
/// use gear_dynamics::{Model, Wave};
/// let stiffness = [Wave::constant(2e8)?, Wave::constant(2.5e8)?];
/// let set = Planetary::torsional([30, 30, 90], 3, 0.03, [1e-3, 1e-3, 5e-2, 3e-2], stiffness)?;
/// let parts = set.supports([0.0, 1e9, 0.0]).parts();
/// assert_eq!(parts.build("sun", 100.0)?.dof(), 6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Planetary {
    teeth: [u32; 3],
    angles: Vec<f64>,
    sun_radius: f64,
    inertias: [f64; 4],
    stiffness: [Wave; 2],
    error: [Wave; 2],
    bearings: Option<[Bearing; 4]>,
    supports: [f64; 3],
    at_rest: Option<Central>,
    pressure_angle: f64,
    ring_phase: Phase,
    damping: f64,
    half_backlash: f64,
}

impl Planetary {
    /// A torsional set: teeth of sun, planets and ring; N equally spaced planets; base radius of the sun `[m]`; moments
    /// of inertia [kg m²] of sun, each planet, ring, and the carrier (with the masses of the planets, if they have no bearings); stiffnesses of a
    /// sun mesh and of a ring mesh over the mesh angle.
    ///
    /// # Errors
    /// No planets or more than 100; a base radius out of range. Other values are checked by [`Parts::build`].
    pub fn torsional(
        teeth: [u32; 3],
        planets: u32,
        sun_base_radius: f64,
        inertias: [f64; 4],
        stiffness: [Wave; 2],
    ) -> Result<Self, ParameterError> {
        if planets == 0 {
            return Err(ParameterError::TooFew { name: "planets".into(), value: 0, min: 1 });
        }
        check::count("planets", &[planets as usize], 100)?;
        check::scale("base radius of the sun", sun_base_radius)?;
        let zero = || Wave::new(Constant::zero());
        Ok(Planetary {
            teeth,
            angles: equally_spaced(planets),
            sun_radius: sun_base_radius,
            inertias,
            stiffness,
            error: [zero(), zero()],
            bearings: None,
            supports: [0.0; 3],
            at_rest: Some(Central::Ring),
            pressure_angle: 20f64.to_radians(),
            ring_phase: Phase::Ahead(0.0),
            damping: 0.0,
            half_backlash: 0.0,
        })
    }
    /// The same set with bearings of sun, each planet, ring and carrier, in this order: three coordinates a body.
    pub fn on_bearings(self, bearings: [Bearing; 4]) -> Self {
        Planetary { bearings: Some(bearings), ..self }
    }
    /// The same set with torsional supports of sun, ring and carrier [N m/rad]. An infinite stiffness locks the
    /// member. Default: 0; the member at rest is locked then.
    pub fn supports(self, supports: [f64; 3]) -> Self {
        Planetary { supports, ..self }
    }
    /// The same set with another central member at rest. Default: the ring.
    pub fn at_rest(self, member: Central) -> Self {
        Planetary { at_rest: Some(member), ..self }
    }
    /// The same set with all three central members free to turn, to be joined with other parts.
    pub fn all_turning(self) -> Self {
        Planetary { at_rest: None, ..self }
    }
    /// The same set with planets at the given angles `[rad]`.
    pub fn at_angles(self, angles: &[f64]) -> Self {
        Planetary { angles: angles.to_vec(), ..self }
    }
    /// The same set with the working pressure angle `[rad]` of the sun meshes. Default: 20°. That of the ring meshes
    /// follows from the common centre distance: (z_s + z_p)/cos α_s = (z_r - z_p)/cos α_r.
    pub fn pressure_angle(self, pressure_angle: f64) -> Self {
        Planetary { pressure_angle, ..self }
    }
    /// The same set with the transmission errors `[m]` of a sun mesh and of a ring mesh over the mesh angle.
    pub fn error(self, error: [Wave; 2]) -> Self {
        Planetary { error, ..self }
    }
    /// The same set with the ring mesh of each planet ahead of its sun mesh by a part of the mesh cycle. Default: 0.
    pub fn ring_phase(self, cycles: f64) -> Self {
        Planetary { ring_phase: Phase::Ahead(cycles), ..self }
    }
    /// The same set with the phase between ring and sun mesh that follows from teeth as thick as their gaps: 1/2 for
    /// planets with an even number of teeth, 0 for an odd number ([`MeshPart::phase_from_teeth`]).
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
        let [zs, zp, zr] = self.teeth.map(f64::from);
        let [rs, rp, rr] = [zs, zp, zr].map(|z| self.sun_radius * z / zs);
        let outer_angle = if zr - zp == zs + zp {
            self.pressure_angle
        } else {
            libm::acos((zr - zp) / (zs + zp) * libm::cos(self.pressure_angle))
        };
        let on = |body: Body, i: usize| match self.bearings {
            Some(bearings) => body.on(bearings[i]),
            None => body,
        };
        let held = |body: Body, member: Central| match self.supports[member as usize] {
            f64::INFINITY => body.locked(),
            // At rest without a spring.
            0.0 if self.at_rest == Some(member) => body.locked(),
            stiffness if self.at_rest == Some(member) => body.held(stiffness, 0.0),
            stiffness => body.restrained(stiffness, 0.0),
        };
        parts.body("sun", held(on(Body::new(self.inertias[0]), 0), Central::Sun));
        parts.body("ring", held(on(Body::new(self.inertias[2]), 2), Central::Ring));
        parts.body("carrier", held(on(Body::new(self.inertias[3]), 3), Central::Carrier));
        for (p, angle) in (1..).zip(&self.angles) {
            let planet = format!("planet {p}");
            parts.body(&planet, on(Body::new(self.inertias[1]), 1).carried_by("carrier", *angle));
            let finish = |mesh: MeshPart, i: usize| {
                mesh.error(self.error[i].clone())
                    .damping(self.damping)
                    .half_backlash(self.half_backlash)
                    .pressure_angle([self.pressure_angle, outer_angle][i])
            };
            let [sun, planet_teeth, ring] = self.teeth;
            let inner = MeshPart::external([sun, planet_teeth], [rs, rp], self.stiffness[0].clone());
            parts.mesh(&format!("sun {p}"), "sun", &planet, finish(inner, 0));
            let outer = MeshPart::internal([planet_teeth, ring], [rp, rr], self.stiffness[1].clone());
            let outer = MeshPart { phase: self.ring_phase, ..finish(outer, 1) };
            parts.mesh(&format!("ring {p}"), &planet, "ring", outer);
        }
        parts
    }
}
