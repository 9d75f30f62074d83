//! Static deflection under load.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::linear::modes::LinearError;
use crate::model::structure::rigid::rigid_modes;
use crate::model::structure::slopes::{Slopes, accelerate};
use crate::model::{Model, Periodic, State};
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
/// let rest = static_state(&parts.build("pinion", 100.0)?, 0.0)?;
/// let contact = rest.contacts[0]; // 30 N m/0.03 m = 1000 N on 2e8 N/m past half the backlash
/// assert!((contact.force - 1000.0).abs() < 1e-9);
/// assert!((contact.deflection - 5.5e-5).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct StaticState {
    /// The state at rest at the time t: a start of integrations and solvers. A rigid motion of the model is
    /// left at rest.
    pub state: State,
    /// Contacts with their deflections and forces.
    pub contacts: Vec<Contact>,
    /// The piece of each contact.
    pub pieces: Vec<Piece>,
    /// Accelerations that are left: those of a rigid motion, if the load does not balance.
    pub acceleration: Vec<f64>,
}

/// Maximum number of contact states that are tried, and of Newton steps in each.
const TRIES: usize = 64;

/// Maximum number of iterations of a singular value decomposition.
const SWEEPS: usize = 10_000;

/// The static state of a model under the loads and drives at time t: accelerations are 0, except those of a
/// rigid motion. Every contact is on its upper flank at first; it changes to the lower flank if it pulls
/// there, and to the gap if both flanks pull. The search starts at q = 0: a bearing with radial clearance has
/// no direction there, and its static state is not found.
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
    // Flanks that a contact has left because it pulled.
    let mut left = vec![[false; 2]; pieces.len()];
    for _ in 0..TRIES {
        let (q, acceleration) = balanced(model, t, &u, &pieces, &rest, &rigid)?;
        model.contact(&u, &q, &rest, &mut contacts);
        let found: Vec<Piece> =
            (0..pieces.len()).map(|i| next_piece(pieces[i], &contacts[i], &mut left[i])).collect();
        if found == pieces {
            let state = State { t, q, v: rest };
            return Ok(StaticState { state, contacts, pieces, acceleration });
        }
        pieces = found;
    }
    Err(LinearError::NoContactState { tried: TRIES })
}

/// The piece to try after `piece`: the same if the deflection lies on it, within rounding. A flank that pulls
/// gives way to the other flank, and to the gap if that has pulled before.
fn next_piece(piece: Piece, contact: &Contact, left: &mut [bool; 2]) -> Piece {
    let near = 16.0 * f64::EPSILON * contact.deflection.abs();
    let upper = contact.deflection >= contact.upper - near;
    let lower = contact.deflection <= contact.lower + near;
    match piece {
        Piece::Upper if upper => Piece::Upper,
        Piece::Lower if lower => Piece::Lower,
        Piece::Gap if upper => Piece::Upper,
        Piece::Gap if lower => Piece::Lower,
        Piece::Gap => Piece::Gap,
        Piece::Upper => {
            left[1] = true;
            if contact.lower.is_finite() && !left[0] { Piece::Lower } else { Piece::Gap }
        }
        Piece::Lower => {
            left[0] = true;
            if contact.upper.is_finite() && !left[1] { Piece::Upper } else { Piece::Gap }
        }
    }
}

/// Coordinates whose accelerations on fixed pieces are those of a rigid motion, by Newton's method with the
/// least change of coordinates.
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
        // J dq - r α = -a: α are the accelerations along the rigid motions. Rows and columns are scaled to 1.
        let unit = |largest: f64| if largest > 0.0 { 1.0 / largest } else { 1.0 };
        let scale: Vec<f64> = (0..n).map(|i| unit(jacobian.row(i).amax())).collect();
        let mut matrix = DMatrix::from_fn(n, n + rigid.ncols(), |i, j| {
            scale[i] * if j < n { jacobian[(i, j)] } else { -rigid[(i, j - n)] }
        });
        let columns: Vec<f64> = matrix.column_iter().map(|column| unit(column.amax())).collect();
        for (mut column, scale) in matrix.column_iter_mut().zip(&columns) {
            column *= *scale;
        }
        let right = DVector::from_fn(n, |i, _| -a[i] * scale[i]);
        if matrix.iter().chain(right.iter()).any(|x| !x.is_finite()) {
            return Err(LinearError::NotFinite { t });
        }
        let failed = || LinearError::NoConvergence { rows: n };
        let svd = matrix.try_svd(true, true, f64::EPSILON, SWEEPS).ok_or_else(failed)?;
        let mut step = svd.solve(&right, 1e-13).map_err(|_| failed())?;
        step.iter_mut().zip(&columns).for_each(|(step, scale)| *step *= scale);
        let stepped = q.iter().zip(step.iter()).map(|(q, step)| q + step).collect();
        let change = (0..n).fold(0.0f64, |most, i| most.max(step[i].abs()));
        q = stepped;
        accelerate(model, Some(pieces), u, &q, rest, &mut a);
        let alpha = DVector::from_fn(rigid.ncols(), |j, _| step[n + j]);
        let drift = rigid * &alpha;
        left = a.iter().zip(drift.iter()).fold(0.0f64, |most, (a, d)| most.max((a - d).abs()));
        if q.iter().any(|q| !q.is_finite()) || !left.is_finite() {
            return Err(LinearError::NotFinite { t });
        }
        let most = q.iter().fold(0.0f64, |most, q| most.max(q.abs()));
        if left <= 1e-9 * load && change <= 1e-12 * most.max(f64::MIN_POSITIVE) || left == 0.0 {
            break;
        }
    }
    if left.is_nan() || load.is_nan() || q.iter().any(|q| !q.is_finite()) {
        return Err(LinearError::NotFinite { t });
    }
    if left > 1e-6 * load {
        return Err(LinearError::Free { residual: left / load });
    }
    Ok((q, a))
}
