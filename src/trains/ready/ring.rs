//! The closed-loop ring of gears from parts.

use crate::contact::Backlash;
use crate::models::ring::ring_params::RingParams;
use crate::trains::parts::body::Body;
use crate::trains::parts::collection::Parts;
use crate::trains::parts::mesh_part::MeshPart;
use crate::trains::parts::shaft_part::ShaftPart;
use crate::trains::train_error::TrainError;

/// The parts of a [`Ring`](crate::Ring) by [`Ring::as_printed`](crate::Ring::as_printed): the same
/// coordinates, contacts and accelerations. `teeth`: number of teeth of gear 1; those of the others follow
/// from the base radii.
///
/// The last mesh of an odd ring is internal, so that it does not reverse the rotation. Build it with the
/// speed ω/teeth of `motor`, on which the torque acts that accelerates the ring at a varying speed; another
/// reference body takes this torque. Bodies: `motor`, `gear i`, `load i`; meshes: `mesh i`.
///
/// # Errors
/// Parameters that [`Ring::as_printed`](crate::Ring::as_printed) refuses;
/// [`TrainError::RadiiContradictTeeth`] if the base radii do not give whole tooth numbers.
///
/// ```
/// use gear_dynamics::models::ring::RingSet;
/// use gear_dynamics::{Model, trains::{Warning, ring_parts}};
/// let params = RingSet::set_a(4, 1000.0).params()?; // its torques accelerate it
/// let mut parts = ring_parts(&params, 20)?;
/// let train = parts.accept(Warning::Unbalanced).build("motor", params.omega / 20.0)?;
/// assert_eq!((train.dof(), train.contacts()), (9, 4));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn ring_parts(params: &RingParams<Backlash>, teeth: u32) -> Result<Parts, TrainError> {
    params.check()?;
    let mut parts = Parts::new();
    let n = params.gears.len();
    let shaft = params.motor.shaft;
    parts.body("motor", Body::new(params.motor.inertia));
    parts.shaft("motor shaft", "motor", "gear 1", ShaftPart::new(shaft.stiffness).damping(shaft.damping));
    parts.torque("motor torque", "motor", params.motor.torque);
    let radius = |i: usize| params.gears[i].base_radius;
    let whole = |i: usize| f64::from(teeth) * radius(i) / radius(0);
    for (i, gear) in params.gears.iter().enumerate() {
        let [own, load] = ["gear", "load"].map(|name| format!("{name} {}", i + 1));
        parts.body(&own, Body::new(gear.inertia)).body(&load, Body::new(gear.load.inertia));
        let shaft = gear.load.shaft;
        parts.shaft(
            &format!("output shaft {}", i + 1),
            &own,
            &load,
            ShaftPart::new(shaft.stiffness).damping(shaft.damping),
        );
        parts.torque(&format!("load torque {}", i + 1), &load, -gear.load.torque);
    }
    for (i, mesh) in params.meshes.iter().enumerate() {
        let next = (i + 1) % n;
        let name = format!("mesh {}", i + 1);
        let numbers = [i, next].map(|i| whole(i).round() as u32);
        if (whole(i) - whole(i).round()).abs() > 1e-6 * whole(i) {
            let teeth = f64::from(numbers[0]) / f64::from(numbers[1]);
            return Err(TrainError::RadiiContradictTeeth {
                mesh: name,
                radii: radius(i) / radius(next),
                teeth,
            });
        }
        let new = if n % 2 == 1 && next == 0 { MeshPart::internal } else { MeshPart::external };
        let part = new(numbers, [radius(i), radius(next)], mesh.stiffness().clone())
            .error(mesh.error().clone())
            .damping(params.mesh_damping.get(i).copied().unwrap_or(f64::NAN))
            .contact_damping(mesh.contact_damping())
            .half_backlash(mesh.law().half_backlash())
            .phase_or_zero();
        parts.mesh(&name, &format!("gear {}", i + 1), &format!("gear {}", next + 1), part);
    }
    Ok(parts)
}
