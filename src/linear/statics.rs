//! Static deflection under load.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::excitation::side::Side;
use crate::linear::modes::LinearError;
use crate::model::equations::{Model, Periodic};
use crate::model::rigid::rigid_modes;
use crate::model::slopes::{Slopes, accelerate};
use nalgebra::{DMatrix, DVector};

/// A static state: deflections under the load at one instant, without motion.
///
/// ```
/// use gear_dynamics::linear::static_state;
/// use gear_dynamics::trains::{Body, MeshPart, Parts};
/// use gear_dynamics::Wave;
/// let mut parts = Parts::new();
/// parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(4e-3));
/// let mesh = MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(2e8)?).half_backlash(5e-5);
/// parts.mesh("mesh", "pinion", "wheel", mesh);
/// parts.torque("drive", "pinion", 30.0).torque("load", "wheel", -60.0);
/// let state = static_state(&parts.build("pinion", 100.0)?, 0.0)?;
/// let contact = state.contacts[0]; // 30 N m/0.03 m = 1000 N on 2e8 N/m past half the backlash
/// assert!((contact.force - 1000.0).abs() < 1e-9);
/// assert!((contact.deflection - 5.5e-5).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct StaticState {
    /// Coordinates. A rigid motion of the model is left at rest.
    pub q: Vec<f64>,
    /// Contacts with their deflections and forces.
    pub contacts: Vec<Contact>,
    /// The piece of each contact.
    pub pieces: Vec<Piece>,
    /// Accelerations that are left: those of a rigid motion, if the load does not balance.
    pub acceleration: Vec<f64>,
}

/// Maximum number of contact states that are tried, and of Newton steps in each.
const TRIES: usize = 64;

/// The static state of a model under the loads and drives at time t: accelerations are 0, except those of a rigid
/// motion. Every contact that can carry load is on its upper flank at first; it changes its flank if its force pulls.
///
/// # Errors
/// A Jacobian that is not finite; no consistent contact state; a load that moves bodies freely, as in a gap.
pub fn static_state<M: Periodic + ?Sized>(model: &M, t: f64) -> Result<StaticState, LinearError> {
    let n = model.dof();
    crate::error::check::finite("time", t)?;
    let mut u = vec![0.0; model.drives()];
    model.drive(t, Side::After, &mut u);
    let rest = vec![0.0; n];
    let rigid = rigid_modes(model, model.period());
    let rigid = DMatrix::from_fn(n, rigid.len(), |i, j| rigid[j][i]);
    let mut pieces = vec![Piece::Upper; model.contacts()];
    let mut contacts = vec![Contact::default(); pieces.len()];
    let (mut tried, mut seen) = (0, Vec::new());
    loop {
        tried += 1;
        let (q, acceleration) = balanced(model, t, &u, &pieces, &rest, &rigid)?;
        model.contact(&u, &q, &rest, &mut contacts);
        let found: Vec<Piece> = contacts.iter().map(resting).collect();
        if found == pieces {
            return Ok(StaticState { q, contacts, pieces, acceleration });
        }
        if tried == TRIES || seen.contains(&found) {
            return Err(LinearError::NoContactState { tried });
        }
        seen.push(std::mem::replace(&mut pieces, found));
    }
}

/// The piece of a deflection. One on its edge within rounding touches.
fn resting(contact: &Contact) -> Piece {
    let near = 16.0 * f64::EPSILON * contact.deflection.abs();
    if contact.deflection >= contact.upper - near {
        Piece::Upper
    } else if contact.deflection <= contact.lower + near {
        Piece::Lower
    } else {
        Piece::Gap
    }
}

/// Coordinates whose accelerations on fixed pieces are those of a rigid motion, by Newton's method with the least
/// change of coordinates.
fn balanced<M: Model + ?Sized>(
    model: &M,
    t: f64,
    u: &[f64],
    pieces: &[Piece],
    rest: &[f64],
    rigid: &DMatrix<f64>,
) -> Result<(Vec<f64>, Vec<f64>), LinearError> {
    let n = rest.len();
    let (mut q, mut a) = (rest.to_vec(), rest.to_vec());
    accelerate(model, Some(pieces), u, &q, rest, &mut a);
    let load = a.iter().fold(0.0f64, |most, a| most.max(a.abs()));
    let mut slopes = Slopes::new(model, vec![1.0; 2 * n], 0.0);
    let mut left = f64::INFINITY;
    for _ in 0..TRIES {
        slopes.at(Some(pieces), u, &q, rest);
        let jacobian = &slopes.jacobian.q;
        if jacobian.iter().chain(&a).any(|x| !x.is_finite()) {
            return Err(LinearError::NotFinite { t });
        }
        // J dq - r α = -a: α are the accelerations along the rigid motions. Rows are scaled by their size.
        let scale: Vec<f64> = (0..n).map(|i| 1.0 / jacobian.row(i).amax().max(f64::MIN_POSITIVE)).collect();
        let size = 1.0 / scale.iter().fold(f64::INFINITY, |least, s| least.min(*s));
        let matrix = DMatrix::from_fn(n, n + rigid.ncols(), |i, j| {
            scale[i] * if j < n { jacobian[(i, j)] } else { -rigid[(i, j - n)] * size }
        });
        let right = DVector::from_fn(n, |i, _| -a[i] * scale[i]);
        let solved = matrix.svd(true, true).solve(&right, 1e-13);
        let Ok(step) = solved else { return Err(LinearError::NoConvergence { rows: n }) };
        let stepped = q.iter().zip(step.iter()).map(|(q, step)| q + step).collect();
        let change = (0..n).fold(0.0f64, |most, i| most.max(step[i].abs()));
        q = stepped;
        accelerate(model, Some(pieces), u, &q, rest, &mut a);
        let alpha = DVector::from_fn(rigid.ncols(), |j, _| step[n + j] * size);
        let drift = rigid * &alpha;
        left = a.iter().zip(drift.iter()).fold(0.0f64, |most, (a, d)| most.max((a - d).abs()));
        let most = q.iter().fold(0.0f64, |most, q| most.max(q.abs()));
        if left <= 1e-9 * load && change <= 1e-12 * most.max(f64::MIN_POSITIVE) || left == 0.0 {
            break;
        }
    }
    if left > 1e-6 * load {
        return Err(LinearError::Free { residual: left / load });
    }
    Ok((q, a))
}
