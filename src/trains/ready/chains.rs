//! Idler, two-stage train, geared rotor and robot joint.

use crate::error::{ParameterError, check};
use crate::excitation::Wave;
use crate::trains::parts::body::{Bearing, Body};
use crate::trains::parts::collection::Parts;
use crate::trains::parts::coordinates::Coordinates;
use crate::trains::parts::mesh_part::MeshPart;
use crate::trains::parts::shaft_part::ShaftPart;
use crate::trains::train_error::Warning;

/// An idler train: `driver`, `idler` and `driven` of the moments of inertia J [kg m²], with the meshes
/// `first mesh` and `second mesh`. The phases of the meshes are those of their [`MeshPart`]s, 0 if
/// none is stated.
///
/// J_1 q_1'' + r_1 W_1 = T_1,   J_2 q_2'' - r_2 W_1 + r_2 W_2 = T_2,   J_3 q_3'' - r_3 W_2 = T_3.   Source:
/// Al-Shyyab and Kahraman 2005, J. Sound Vib. 284, 151.
///
/// ```
/// use gear_dynamics::trains::{MeshPart, idler};
/// use gear_dynamics::{Model, Wave};
/// let mesh = |teeth, radii| Wave::constant(2e8).map(|k| MeshPart::external(teeth, radii, k));
/// let meshes = [mesh([20, 30], [0.02, 0.03])?, mesh([30, 40], [0.03, 0.04])?];
/// let train = idler([1e-3, 3e-3, 8e-3], meshes).build("driver", 100.0)?;
/// assert_eq!((train.dof(), train.contacts()), (3, 2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn idler(inertias: [f64; 3], [first, second]: [MeshPart; 2]) -> Parts {
    let mut parts = Parts::new();
    for (name, inertia) in ["driver", "idler", "driven"].into_iter().zip(inertias) {
        parts.body(name, Body::new(inertia));
    }
    parts.mesh("first mesh", "driver", "idler", first.phase_or_zero()).mesh(
        "second mesh",
        "idler",
        "driven",
        second.phase_or_zero(),
    );
    parts
}

/// A two-stage train of moments of inertia [kg m²] in the order of the power: `pinion 1` drives `wheel 1`, a
/// shaft of stiffness [N m/rad] and damping [N m s/rad] turns `pinion 2`, which drives `wheel 2`. Meshes:
/// `stage 1` and `stage 2`; shaft: `shaft`.
///
/// ```
/// use gear_dynamics::trains::{MeshPart, ShaftPart, two_stage};
/// use gear_dynamics::{Periodic, Wave, excitation::Fourier};
/// let k = || Ok::<_, gear_dynamics::ParameterError>(Wave::new(Fourier::new(3e8, &[[6e7, 0.0]])?));
/// let meshes = [
///     MeshPart::external([20, 50], [0.02, 0.05], k()?),
///     MeshPart::external([18, 45], [0.027, 0.0675], k()?),
/// ];
/// let train = two_stage([1e-3, 2e-2, 1e-3, 6e-2], ShaftPart::new(1e5).damping(1.0), meshes).build("pinion 1", 100.0)?;
/// // Mesh frequencies 20 and 18 x 20/50 = 7.2 times the speed: both repeat after 0.8 of it.
/// assert!((train.shape().ratio() - 0.8).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn two_stage(inertias: [f64; 4], shaft: ShaftPart, [first, second]: [MeshPart; 2]) -> Parts {
    let mut parts = Parts::new();
    for (name, inertia) in ["pinion 1", "wheel 1", "pinion 2", "wheel 2"].into_iter().zip(inertias) {
        parts.body(name, Body::new(inertia));
    }
    parts.shaft("shaft", "wheel 1", "pinion 2", shaft);
    parts.mesh("stage 1", "pinion 1", "wheel 1", first).mesh("stage 2", "pinion 2", "wheel 2", second);
    parts
}

/// A geared rotor with bearings along the line of action: y of each gear and the relative angle.
///
/// I_j q_j'' ± r_j W = T_j,   m_j y_j'' + c_j y_j' + k_j f_j(y_j) ± W = 0,
/// d = r_1 q_1 - r_2 q_2 + y_1 - y_2 - e.
///
/// f_j is a dead zone if the bearing has a clearance. Bodies: `driver` and `driven`; mesh: `mesh`. Its
/// pressure angle is set to 0, as y is the line of action.   Source: Kahraman and Singh 1991, J. Sound Vib.
/// 144, 469.
///
/// ```
/// use gear_dynamics::trains::{Bearing, MeshPart, geared_rotor};
/// use gear_dynamics::{Model, Wave};
/// let mesh = MeshPart::external([28, 28], [0.0445, 0.0445], Wave::constant(2e8)?).half_backlash(5e-5);
/// let bearing = Bearing::new(1.84, 1e8).damping(400.0).half_clearance(1e-5);
/// let train = geared_rotor([1.15e-3, 1.15e-3], [bearing; 2], mesh).build("driver", 100.0)?;
/// assert_eq!((train.dof(), train.contacts()), (3, 3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn geared_rotor(inertias: [f64; 2], bearings: [Bearing; 2], mesh: MeshPart) -> Parts {
    let mut parts = Parts::new();
    let distance = mesh.gears.radii.iter().sum();
    let centres = [[0.0, 0.0], [distance, 0.0]];
    for (i, name) in ["driver", "driven"].into_iter().enumerate() {
        parts.body(name, Body::new(inertias[i]).bearing(bearings[i].along_y()).centre(centres[i]));
    }
    parts.mesh("mesh", "driver", "driven", mesh.pressure_angle(0.0)).coordinates(Coordinates::Relative);
    parts
}

/// A robot joint: `motor`, a reducer of the whole ratio N and the `load`, with the backlash of the reducer.
///
/// J_m q_m'' + W/N = T_m,   J_l q_l'' - W = T_l,   W = c d' + k f(d),   d = q_m/N - q_l.
///
/// Angles d `[rad]` and moments W [N m] are those of the output; stiffness k [N m/rad] as a wave over a turn
/// of the motor, damping c [N m s/rad]. Mesh: `reducer`, whose half backlash is an angle `[rad]`.   Source:
/// Nordin and Gutman 2002, Automatica 38, 1633.
/// [`Parts::build`] refuses a ratio of 0.
///
/// ```
/// use gear_dynamics::trains::robot_joint;
/// use gear_dynamics::{Model, Wave};
/// let joint = robot_joint([2e-5, 1.5], 100, Wave::constant(2e4)?, 5.0, 2e-4).build("motor", 50.0)?;
/// assert_eq!(joint.constant("reducer half backlash")?, 2e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn robot_joint(
    [motor, load]: [f64; 2],
    ratio: u32,
    stiffness: Wave,
    damping: f64,
    half_backlash: f64,
) -> Parts {
    let mut parts = Parts::new();
    parts.body("motor", Body::new(motor)).body("load", Body::new(load));
    let reducer = MeshPart::external([1, ratio], [1.0 / f64::from(ratio.max(1)), 1.0], stiffness);
    parts.mesh("reducer", "motor", "load", reducer.damping(damping).half_backlash(half_backlash));
    parts.accept(Warning::UnusualValue);
    parts
}

/// A split-torque train: `input` drives `paths` intermediate gears in parallel, each with a shaft to a second
/// gear that drives `output`.
///
/// The meshes `input i` share one phase, and the meshes `output i` share another one: that of their
/// [`MeshPart`], 0 if it states none.
/// Bodies: `input`, `output`, and `first i` and `second i` of path i; meshes: `input i` and `output i`;
/// shafts: `shaft i`.
///
/// # Errors
/// No path or more than 100.
///
/// ```
/// use gear_dynamics::trains::{MeshPart, ShaftPart, split_torque};
/// use gear_dynamics::{Model, Wave};
/// let first = MeshPart::external([20, 60], [0.02, 0.06], Wave::constant(2e8)?);
/// let second = MeshPart::external([20, 80], [0.02, 0.08], Wave::constant(2e8)?);
/// let train = split_torque([1e-3, 2e-2, 1e-3, 8e-2], 2, ShaftPart::new(1e5).damping(1.0), [first, second])?.build("input", 300.0)?;
/// assert_eq!((train.dof(), train.contacts()), (6, 4));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn split_torque(
    [input, first, second, output]: [f64; 4],
    paths: usize,
    shaft: ShaftPart,
    [inner, outer]: [MeshPart; 2],
) -> Result<Parts, ParameterError> {
    check::at_least("paths", paths, 1)?;
    crate::error::check::count("paths", &[paths], 100)?;
    let [inner, outer] = [inner, outer].map(MeshPart::phase_or_zero);
    let mut parts = Parts::new();
    parts.body("input", Body::new(input)).body("output", Body::new(output));
    for i in 1..=paths {
        let [one, two] = ["first", "second"].map(|name| format!("{name} {i}"));
        parts.body(&one, Body::new(first)).body(&two, Body::new(second));
        parts.shaft(&format!("shaft {i}"), &one, &two, shaft.clone());
        parts.mesh(&format!("input {i}"), "input", &one, inner.clone());
        parts.mesh(&format!("output {i}"), &two, "output", outer.clone());
    }
    Ok(parts)
}
