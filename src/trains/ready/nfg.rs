//! The noncircular face gear pair from parts.

use crate::excitation::{Fourier, InstantCentre, Wave};
use crate::models::nfg::nfg_params::NfgParams;
use crate::models::nfg::pair2::NfgPair2;
use crate::trains::parts::body::Body;
use crate::trains::parts::collection::Parts;
use crate::trains::parts::mesh_part::{MeshPart, OfMesh};
use crate::trains::train_error::TrainError;

/// The parts of [`NfgPair2`](crate::models::nfg::NfgPair2) in its exact reading with the constant torque
/// T2/i_j on the pinion: at a constant speed the same coordinates, contact and accelerations.   Source:
/// Liu 2021, Eq. (4), corrected.
///
/// Nothing holds the pinion to its even rotation. Deviations of both gears together grow, the less the larger
/// I1 is: accept [`Warning::Drifts`](crate::trains::Warning::Drifts).
///
/// `pinion_inertia`: I1 [kg m²]. Build it with the speed of the `pinion`. Bodies: `pinion`, `face gear`;
/// mesh: `mesh`; torques: `drive torque` T2/i_j, `load torque` -T2.
///
/// # Errors
/// Parameters that [`NfgPair2::new`](crate::models::nfg::NfgPair2::new) refuses.
///
/// ```
/// use gear_dynamics::{Model, NfgParams, trains::{Warning, nfg_parts}};
/// let params = NfgParams::table1();
/// let train = nfg_parts(&params, 10.0)?.accept(Warning::Drifts).build("pinion", params.speed)?;
/// assert_eq!((train.dof(), train.constant("drive torque")?), (2, 30.0 / 3.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn nfg_parts(params: &NfgParams, pinion_inertia: f64) -> Result<Parts, TrainError> {
    let pair = NfgPair2::new(params, pinion_inertia)?;
    let stiffness = Wave::new(Fourier::new(params.stiffness, &params.stiffness_harmonics)?);
    let error = Wave::new(Fourier::new(params.error, &params.error_harmonics)?);
    let teeth = [params.pinion_teeth, params.face_gear_teeth().round() as u32];
    let radii = [pair.shape().pinion_radius(), params.mean_base_radius()];
    let radius = InstantCentre::new(params.eccentric_ratio)?.radius(1.0)?;
    let mesh = MeshPart::external(teeth, radii, stiffness)
        .radius_of_turn(OfMesh::Driven, Wave::new(radius))
        .pressure_angle(params.pressure_angle)
        .error(error)
        .damping(pair.damping())
        .half_backlash(params.half_backlash);
    let mut parts = Parts::new();
    parts.body("pinion", Body::new(pinion_inertia)).body("face gear", Body::new(params.inertia));
    parts.mesh("mesh", "pinion", "face gear", mesh);
    parts.torque("drive torque", "pinion", params.load_torque / params.ratio);
    parts.torque("load torque", "face gear", -params.load_torque);
    Ok(parts)
}
