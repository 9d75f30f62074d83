//! Trains with equal members.

use crate::draw::Draw;
use gear_dynamics::Wave;
use gear_dynamics::excitation::Fourier;
use gear_dynamics::models::ring::RingSet;
use gear_dynamics::trains::{
    Body, Coordinates, Members, MeshPart, Parts, Planetary, ShaftPart, Train, idler, ring_parts, split_torque,
};

/// A train with equal members that have the same motion, or one that is shifted in phase.
#[derive(Clone, Debug)]
pub struct Symmetric {
    kind: Kind,
    /// Mean mesh stiffnesses [N/m] and their first order `[1]`.
    stiffness: [[f64; 2]; 2],
    /// Mesh damping [N s/m].
    damping: f64,
    /// Half backlash `[m]`; 0: the meshes never separate.
    half_backlash: f64,
    /// Input torque [N m].
    torque: f64,
    /// Speed of the input [rad/s].
    speed: f64,
}

/// Parts without torques, the input, and the bodies that take torques with their ratios to the input torque.
type Loaded = (Parts, &'static str, [(&'static str, f64); 2]);

#[derive(Clone, Debug)]
enum Kind {
    /// Teeth of sun, planet and ring, and the number of equal planets.
    Planetary([u32; 3], u32),
    /// The number of equal paths.
    Split(usize),
    /// An idler between equal gears, each of which takes half of its torque.
    Idler,
    /// The number of equal gears of a closed ring, driven at one gear and loaded at the opposite one.
    Ring(usize),
}

impl Symmetric {
    /// Draws a train.
    pub fn draw(draw: &mut Draw) -> Self {
        match draw.below(7) {
            0..=2 => Symmetric::planetary(draw),
            3 => {
                let kind = Kind::Split(2 + draw.below(2));
                Symmetric::of(kind, draw)
            }
            4 => Symmetric::of(Kind::Idler, draw),
            n => {
                let kind = Kind::Ring([4, 6][n - 5]);
                let ring = Symmetric::of(kind, draw);
                // Without torque and backlash the ring rests: all differences and all deflections are 0.
                if draw.unit() < 0.5 { Symmetric { torque: 0.0, half_backlash: 0.0, ..ring } } else { ring }
            }
        }
    }
    /// Draws a planetary set. Its planets are in phase if the teeth of the sun are a multiple of their number.
    pub fn planetary(draw: &mut Draw) -> Self {
        let teeth = draw.one_of(&[[30, 30, 90], [24, 36, 96], [36, 24, 84], [26, 34, 94], [29, 31, 91]]);
        let kind = Kind::Planetary(teeth, draw.one_of(&[2, 3, 4]));
        Symmetric::of(kind, draw)
    }
    fn of(kind: Kind, draw: &mut Draw) -> Self {
        let mut mesh = || [draw.scale(1e8, 4e8), draw.within(0.05, 0.3)];
        let stiffness = [mesh(), mesh()];
        let damping = draw.scale(500.0, 5000.0);
        let half_backlash = if draw.unit() < 0.3 { 0.0 } else { draw.scale(1e-6, 4e-5) };
        let (torque, speed) = (draw.scale(5.0, 200.0), draw.scale(30.0, 400.0));
        Symmetric { kind, stiffness, damping, half_backlash, torque, speed }
    }

    fn wave(&self, mesh: usize) -> Result<Wave, String> {
        let [mean, share] = self.stiffness[mesh];
        Fourier::new(mean, &[[share * mean, 0.0]]).map(Wave::new).map_err(|error| error.to_string())
    }
    fn mesh(&self, mesh: usize, teeth: [u32; 2], radii: [f64; 2]) -> Result<MeshPart, String> {
        let part = MeshPart::external(teeth, radii, self.wave(mesh)?).damping(self.damping);
        Ok(part.half_backlash(self.half_backlash))
    }

    /// Its parts without torques, the input, the output and the ratio of the output torque to the input torque.
    fn parts(&self) -> Result<Loaded, String> {
        let said = |error: gear_dynamics::ParameterError| error.to_string();
        Ok(match self.kind {
            Kind::Planetary(teeth, planets) => {
                let waves = [self.wave(0)?, self.wave(1)?];
                let members = Members {
                    sun: (teeth[0], Body::new(1e-3)),
                    planet: (teeth[1], Body::new(1e-3)),
                    ring: (teeth[2], Body::new(5e-2).locked()),
                    carrier: Body::new(3e-2),
                };
                let set = Planetary::new(planets, 0.03, members, waves);
                let set = set.map_err(said)?.damping(self.damping).half_backlash(self.half_backlash);
                let ratio = 1.0 + f64::from(teeth[2]) / f64::from(teeth[0]);
                (set.parts(), "sun", [("sun", 1.0), ("carrier", -ratio)])
            }
            Kind::Split(paths) => {
                let meshes = [self.mesh(0, [20, 60], [0.02, 0.06])?, self.mesh(1, [20, 80], [0.02, 0.08])?];
                let parts =
                    split_torque([1e-3, 2e-2, 1e-3, 8e-2], paths, ShaftPart::new(1e5).damping(5.0), meshes)
                        .map_err(said)?;
                (parts, "input", [("input", 1.0), ("output", -12.0)])
            }
            Kind::Idler => {
                let mesh = || self.mesh(0, [30, 40], [0.03, 0.04]);
                let [first, second] = [mesh()?, self.mesh(0, [40, 30], [0.04, 0.03])?];
                // Both outer gears are alike: each drives the idler, whose load takes both torques.
                let mut parts = idler([1e-3, 4e-3, 1e-3], [first, second]);
                parts.torque("second drive", "driven", self.torque);
                (parts, "driver", [("driver", 1.0), ("idler", -8.0 / 3.0)])
            }
            Kind::Ring(gears) => {
                let set = RingSet {
                    mesh_stiffness: self.stiffness[0][0],
                    stiffness_harmonics: vec![self.stiffness[0][1]],
                    mesh_damping: self.damping,
                    half_backlash: self.half_backlash,
                    error: 0.0,
                    motor_torque: 0.0,
                    load_torque: 0.0,
                    ..RingSet::set_a(gears, 1000.0)
                };
                let parts = ring_parts(&set.params().map_err(said)?, set.teeth);
                let parts = parts.map_err(|error| error.to_string())?;
                let load = if gears == 4 { "load 3" } else { "load 4" };
                (parts, "gear 1", [("motor", 1.0), (load, -1.0)])
            }
        })
    }

    /// The train in the given coordinates.
    pub fn train(&self, coordinates: Coordinates) -> Result<Train, String> {
        let (mut parts, input, torques) = self.parts()?;
        for (name, (body, share)) in ["drive", "load"].into_iter().zip(torques) {
            parts.torque(name, body, share * self.torque);
        }
        parts.coordinates(coordinates).build(input, self.speed).map_err(|error| error.to_string())
    }
}
