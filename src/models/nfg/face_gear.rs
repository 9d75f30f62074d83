//! What every pair takes from its parameters: the face gear and the waves of the mesh.

use crate::contact::{Backlash, Mesh};
use crate::error::ParameterError;
use crate::excitation::{Fourier, InstantCentre, Wave};
use crate::models::nfg::nfg_params::{CentreForcing, NfgParams, NfgReading, Radius};

/// The face gear: its base radius r_b2 = L (1 + β cos x) and its rotation θ2 over the phase x of the
/// instantaneous centre.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FaceGear {
    /// Mean radius L `[m]`.
    pub(crate) radius: f64,
    /// β = 2 ε/(1 + ε²) `[1]`.
    pub(crate) beta: f64,
    /// Reduction ratio i_j `[1]`.
    pub(crate) ratio: f64,
    /// Number of teeth Z2.
    pub(crate) teeth: u32,
    /// dθ2/dx.
    pub(crate) rotation: Wave,
}

impl FaceGear {
    /// The face gear of checked parameters, and the natural frequency ω_n [rad/s].
    ///
    /// # Errors
    /// A derived quantity that is outside its range or overflows.
    pub(crate) fn of(params: &NfgParams, reading: NfgReading) -> Result<(Self, f64), ParameterError> {
        let radius = match reading.radius {
            Radius::Base => params.mean_base_radius(),
            Radius::Pitch => params.mean_pitch_radius(),
        };
        let natural = params.check_derived(radius, reading)?;
        let centre = InstantCentre::new(params.eccentric_ratio)?;
        let rotation = match reading.centre_forcing {
            CentreForcing::Exact => Wave::new(centre.rotation()),
            CentreForcing::Series(order) => Wave::new(centre.rotation_series(order as usize)?),
        };
        let teeth = params.face_gear_teeth().round() as u32;
        Ok((FaceGear { radius, beta: params.beta(), ratio: params.ratio, teeth, rotation }, natural))
    }

    /// Mean of (r_b2/L)²: 1 + β²/2.
    pub(crate) fn mean_square(&self) -> f64 {
        1.0 + 0.5 * self.beta * self.beta
    }
}

impl NfgParams {
    /// The series of the mesh stiffness k_m over `unit` [N/m] and of the transmission error e `[m]`.
    pub(crate) fn series(&self, unit: f64) -> Result<[Fourier; 2], ParameterError> {
        let over_unit: Vec<_> = self.stiffness_harmonics.iter().map(|pair| pair.map(|x| x / unit)).collect();
        let stiffness = Fourier::new(self.stiffness / unit, &over_unit)?;
        Ok([stiffness, Fourier::new(self.error, &self.error_harmonics)?])
    }
}

/// A mesh with these series of stiffness and error. The half backlash is a constant of the machine: with 0 in
/// the shape, pairs of different half backlash have equal shapes.
pub(crate) fn mesh_of([stiffness, error]: [Fourier; 2]) -> Result<Mesh, ParameterError> {
    Ok(Mesh::new(Wave::new(stiffness), Wave::new(error), Backlash::new(0.0)?))
}
