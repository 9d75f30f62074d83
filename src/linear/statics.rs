//! Static deflection under load.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::linear::modes::LinearError;
use crate::model::structure::rigid::rigid_modes;
use crate::model::structure::slopes::{Slopes, accelerate};
use crate::model::{Periodic, State};
use faer::Mat;
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
pub fn static_state(model: &dyn Periodic, t: f64) -> Result<StaticState, LinearError> {
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
fn balanced(
    model: &dyn Periodic,
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
        let mut step = least_solution(matrix, &right).ok_or(LinearError::NotConverged { rows: n })?;
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

/// Number of equations from which a factorisation with pivots is tried before a singular value decomposition, which
/// takes longer.
const LARGE: usize = 128;

/// Smallest entry on the diagonal of R, as a share of the largest one, of equations that are independent.
const INDEPENDENT: f64 = 1e-10;

/// The least x with A x = b, for at least as many unknowns as equations, or with the least residual if the equations
/// depend on each other. `None`: the singular value decomposition does not converge.
fn least_solution(matrix: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let n = matrix.nrows();
    if n >= LARGE {
        // Aᵀ = Q R with the columns in another order: Rᵀ z = b and x = Q z.
        let factors = Mat::from_fn(matrix.ncols(), n, |i, j| matrix[(j, i)]).col_piv_qr();
        let (r, order) = (factors.thin_R(), factors.P().arrays().0);
        if r[(n - 1, n - 1)].abs() > INDEPENDENT * r[(0, 0)].abs() {
            let mut z = Mat::<f64>::zeros(n, 1);
            for j in 0..n {
                let known: f64 = (0..j).map(|i| r[(i, j)] * z[(i, 0)]).sum();
                z[(j, 0)] = (right[order[j]] - known) / r[(j, j)];
            }
            let x = factors.compute_thin_Q() * z;
            return Some(DVector::from_fn(matrix.ncols(), |i, _| x[(i, 0)]));
        }
    }
    matrix.try_svd(true, true, f64::EPSILON, SWEEPS)?.solve(right, 1e-13).ok()
}

#[cfg(test)]
mod tests {
    use crate::linear::statics::{LARGE, least_solution};
    use nalgebra::{DMatrix, DVector};

    /// Both ways: equations of a chain that is held at one end, with one unknown too many; the same with an equation
    /// that depends on the others.
    #[test]
    fn least_solutions_agree() {
        for n in [LARGE, LARGE - 1] {
            let entry = |i: usize, j: usize| match j.abs_diff(i) {
                0 => 2.5,
                1 => -1.0,
                _ if j == n => 0.1 * i as f64 / n as f64,
                _ => 0.0,
            };
            let mut matrix = DMatrix::from_fn(n, n + 1, entry);
            for dependent in [false, true] {
                if dependent {
                    let copy = matrix.row(3).clone_owned();
                    matrix.set_row(7, &copy);
                }
                let right = &matrix * DVector::from_fn(n + 1, |i, _| (i as f64).sin());
                let x = least_solution(matrix.clone(), &right).unwrap();
                assert!((&matrix * &x - &right).amax() < 1e-12);
                // The least solution is orthogonal to the kernel, which is one direction unless rows are equal.
                if !dependent {
                    let square = matrix.columns(0, n).clone_owned();
                    let mut k = square.lu().solve(&-matrix.columns(n, 1)).unwrap().data.as_vec().clone();
                    k.push(1.0);
                    let k = DVector::from_vec(k);
                    assert!(k.dot(&x).abs() < 1e-12 * k.norm() * x.norm());
                }
            }
        }
    }
}
