//! Trains of two stages.

use crate::draw::Draw;
use gear_dynamics::Wave;
use gear_dynamics::excitation::Fourier;
use gear_dynamics::trains::{Coordinates, MeshPart, ShaftPart, Train, two_stage};

/// A train of two stages in relative coordinates.
#[derive(Clone, Debug)]
pub struct TwoStage {
    /// Teeth of pinion and wheel of each stage.
    teeth: [[u32; 2]; 2],
    /// Inertias [kg m²].
    inertias: [f64; 4],
    /// Stiffness of the shaft [N m/rad].
    shaft: f64,
    /// Mean mesh stiffnesses [N/m] and their first order `[1]`.
    stiffness: [[f64; 2]; 2],
    /// Mesh damping [N s/m].
    damping: f64,
    /// Half backlash `[m]`; 0: the meshes never separate.
    half_backlash: f64,
    /// Torque of the first pinion [N m].
    torque: f64,
}

impl TwoStage {
    /// Draws a train.
    pub fn draw(draw: &mut Draw) -> Self {
        let teeth = draw.one_of(&[[[20, 20], [20, 30]], [[20, 40], [20, 30]], [[30, 45], [30, 40]]]);
        let inertias = [(); 4].map(|()| draw.scale(3e-4, 3e-3));
        let mut mesh = || [draw.scale(1e8, 4e8), draw.within(0.05, 0.3)];
        let stiffness = [mesh(), mesh()];
        let (shaft, damping) = (draw.scale(1e4, 3e5), draw.scale(500.0, 5000.0));
        let half_backlash = if draw.unit() < 0.1 { 0.0 } else { draw.scale(1e-6, 4e-5) };
        TwoStage { teeth, inertias, shaft, stiffness, damping, half_backlash, torque: draw.scale(5.0, 200.0) }
    }

    fn stage(&self, stage: usize) -> Result<MeshPart, String> {
        let [mean, share] = self.stiffness[stage];
        let wave = Fourier::new(mean, &[[share * mean, 0.0]]).map_err(|error| error.to_string())?;
        let teeth = self.teeth[stage];
        let part = MeshPart::external(teeth, teeth.map(|z| 1e-3 * f64::from(z)), Wave::new(wave));
        Ok(part.damping(self.damping).half_backlash(self.half_backlash))
    }

    /// The train at a speed of the first pinion [rad/s].
    pub fn at(&self, speed: f64) -> Result<Train, String> {
        let mut parts = two_stage(
            self.inertias,
            ShaftPart::new(self.shaft).damping(1.0),
            [self.stage(0)?, self.stage(1)?],
        );
        let ratio: f64 = self.teeth.iter().map(|[z1, z2]| f64::from(*z2) / f64::from(*z1)).product();
        parts.torque("drive", "pinion 1", self.torque).torque("load", "wheel 2", -ratio * self.torque);
        let parts = parts.coordinates(Coordinates::Relative);
        parts.build("pinion 1", speed).map_err(|error| error.to_string())
    }
}
