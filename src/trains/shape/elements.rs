//! Elements of a train as its algebra reads them: places of coordinates, levers and pulls.
//!
//! A lever multiplies a coordinate in a deflection. A pull is the acceleration that a unit of force causes.

use crate::contact::{Backlash, Mesh};
use crate::excitation::Wave;
use crate::model::Channel;
use crate::trains::parts::characteristic::Characteristic;
use std::ops::Range;

/// What the algebra of a train reads, except its meshes. The lists refer to each other by their places.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Elements {
    /// 1/J of each coordinate, which multiplies its net torque; 1 in relative coordinates, whose torques are
    /// accelerations already.
    pub(crate) per_inertia: Vec<f64>,
    pub(crate) springs: Vec<Spring>,
    pub(crate) row_springs: Vec<RowSpring>,
    pub(crate) rotating: Vec<Rotating>,
    /// Centrifugal accelerations of the planets in a rotating frame: a_i += Ω² `by`.
    pub(crate) outward: Vec<Entry>,
    /// Ω/φ' of the rotating frame.
    pub(crate) frame_ratio: f64,
    pub(crate) varying: Vec<Lever>,
    pub(crate) uneven: Vec<Uneven>,
    pub(crate) frictions: Vec<Friction>,
    pub(crate) journals: Vec<Journal>,
    pub(crate) motors: Vec<Motor>,
    /// Torques that are waves: place of the wave among `single`, of the constant among the torques, pulls.
    pub(crate) torque_waves: Vec<(usize, usize, Range<usize>)>,
    /// The numbers of all rows of more than two coordinates.
    pub(crate) entries: Vec<Entry>,
    /// Each wave once. Stiffnesses and signs take one drive; errors, varying levers and uneven rotations take
    /// two, of which the second is the rate over φ.
    pub(crate) single: Vec<Wave>,
    pub(crate) jets: Vec<Wave>,
}

/// One number of a sparse row: a lever or a pull of the coordinate `at`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Entry {
    pub(crate) at: usize,
    pub(crate) by: f64,
}

/// A linear spring and damper between two coordinates, k (q_i - q_j) + c (v_i - v_j), or from one coordinate
/// to the ground, for which both ends are equal and the second lever is 0.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spring {
    pub(crate) name: String,
    pub(crate) ends: [u32; 2],
    pub(crate) pulls: [f64; 2],
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
    pub(crate) levers: [f64; 2],
}

impl Spring {
    /// The spring as a shaft of one of its ends, with levers of 1 and -1.
    pub(crate) fn shaft_of(&self, at: u32) -> Shaft {
        let &Spring { ends, pulls, stiffness, damping, .. } = self;
        // Seen from its other end, the shaft has the opposite deflection.
        let (end, pulls) = if ends[0] == at { (ends[1], pulls) } else { (ends[0], [-pulls[1], -pulls[0]]) };
        Shaft { end, stiffness, damping, pulls }
    }
}

/// A linear spring and damper on a row of any length.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RowSpring {
    pub(crate) name: String,
    pub(crate) levers: Range<usize>,
    pub(crate) pulls: Range<usize>,
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
}

/// Terms of a rotating frame with speed Ω = `ratio` φ': a_i -= Ω (`damping` q_j + `gyroscopic` v_j) +
/// Ω² `centripetal` q_j + Ω' `euler` q_j.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rotating {
    pub(crate) i: usize,
    pub(crate) j: usize,
    pub(crate) damping: f64,
    pub(crate) gyroscopic: f64,
    pub(crate) centripetal: f64,
    pub(crate) euler: f64,
}

/// A shaft of the first coordinate of a mesh in a plain train: its other end, and its pulls on the first
/// coordinate and on this end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shaft {
    pub(crate) end: u32,
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
    pub(crate) pulls: [f64; 2],
}

impl Shaft {
    /// No shaft.
    pub(crate) const NONE: Shaft = Shaft { end: u32::MAX, stiffness: 0.0, damping: 0.0, pulls: [0.0; 2] };
}

/// A contact: a mesh, or a clearance of a shaft. What every evaluation reads stands here, in
/// little memory; the rest in [`ToothRest`].
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tooth<N> {
    /// The first two numbers of its row.
    pub(crate) at: [u32; 2],
    /// Places of its stiffness and its error among the waves.
    pub(crate) stiffness: u32,
    pub(crate) error: u32,
    pub(crate) levers: [f64; 2],
    pub(crate) pulls: [f64; 2],
    pub(crate) shaft: Shaft,
    pub(crate) law: N,
}

/// The rest of a contact.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ToothRest<N> {
    /// Its name, and the unit of its deflection.
    pub(crate) channel: Channel,
    /// Further numbers of the row.
    pub(crate) more_levers: Range<usize>,
    pub(crate) more_pulls: Range<usize>,
    /// Levers that vary.
    pub(crate) varying: Range<usize>,
    pub(crate) mesh: Mesh<N>,
}

/// The lever of a noncircular gear: its angle `at` moves the contact by `lever` g(φ), and a unit of force
/// accelerates it by `pull` g(φ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lever {
    pub(crate) at: usize,
    pub(crate) lever: f64,
    pub(crate) pull: f64,
    /// Place of g among the waves with rates.
    pub(crate) wave: usize,
}

/// A body that turns unevenly in the kinematic motion, θ' = `ratio` φ' R(φ) and θ'' =
/// `ratio` (φ'² R'(φ) + φ'' R(φ)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Uneven {
    pub(crate) at: usize,
    pub(crate) ratio: f64,
    /// Place of R among the waves with rates.
    pub(crate) wave: usize,
    /// The reference body, and its acceleration over φ'' R² by the torque that accelerates this body.
    pub(crate) driver: Option<Entry>,
}

/// Tooth friction: the force μ s(φ) W along a second row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Friction {
    pub(crate) tooth: usize,
    /// Place of the sign s(φ) among the waves.
    pub(crate) sign: usize,
    pub(crate) pulls: Range<usize>,
}

/// A bearing with radial clearance: a contact with the deflection √(x² + y²).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Journal {
    pub(crate) name: String,
    /// The rows of x and y.
    pub(crate) levers: [Range<usize>; 2],
    pub(crate) pulls: [Range<usize>; 2],
    pub(crate) stiffness: f64,
    /// Added to r². It is below rounding where the bearing carries, and keeps the direction finite at r = 0.
    pub(crate) least: f64,
    pub(crate) law: Backlash,
}

/// A torque over the speed Ω of its body: a constant T times a characteristic.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Motor {
    pub(crate) at: usize,
    pub(crate) pulls: Range<usize>,
    /// Mean speed of the body in the kinematic rotation, divided by φ'.
    pub(crate) ratio: f64,
    /// Place of R among the waves with rates, if the body turns unevenly.
    pub(crate) rotation: Option<usize>,
    /// Place of T among the constants.
    pub(crate) torque: usize,
    pub(crate) characteristic: Characteristic,
}

/// The planets of a carrier, and the coordinates of the carrier and of the gears that mesh with them. All
/// places are those of inertial coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlanetSet {
    pub(crate) planets: Vec<PlanetPlace>,
    /// Places of the coordinates, and whether each is a displacement.
    pub(crate) central: Vec<(usize, bool)>,
}

/// A planet: places of its angle and of x, which y follows; its angle on the carrier.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlanetPlace {
    pub(crate) at: Option<usize>,
    pub(crate) centre: Option<usize>,
    pub(crate) angle: f64,
}
