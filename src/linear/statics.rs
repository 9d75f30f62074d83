//! Static deflection under load.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::linear::modes::LinearError;
use crate::model::structure::rigid::rigid_modes;
use crate::model::structure::slopes::{Slopes, accelerate};
use crate::model::{Periodic, State};
use faer::Mat;
use faer::linalg::solvers::Solve;
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

/// Maximum number of Newton steps for one step of implicit Euler.
const NEWTON_STEPS: usize = 30;

/// Maximum number of iterations of a singular value decomposition.
const SWEEPS: usize = 10_000;

/// The static state of a model under the loads and drives at time t: accelerations are 0, except those of a
/// rigid motion.
///
/// Every contact is on its upper flank at first; it changes to the lower flank if it pulls there, and to
/// the gap if both flanks pull. Where contacts that share a load do not settle so, the state is the end of
/// the motion q' = a(u(t), q, 0) from that of all upper flanks, in steps of implicit Euler that grow as
/// long as they converge. With stiffnesses that are not negative, the potential energy falls along it.
///
/// The first search starts at q = 0: a bearing with radial clearance has no direction there, and its static
/// state is not found.
///
/// # Errors
/// A Jacobian that is not finite; no consistent contact state; a load that moves bodies freely, as in a gap.
pub fn static_state(model: &dyn Periodic, t: f64) -> Result<StaticState, LinearError> {
    crate::error::check::finite("time", t)?;
    let search = Search::new(model, t);
    match search.by_flanks() {
        Err(error @ (LinearError::Free { .. } | LinearError::NoContactState { .. })) => {
            search.by_descent()?.ok_or(error)
        }
        found => found,
    }
}

/// The search for a static state.
struct Search<'m> {
    model: &'m dyn Periodic,
    t: f64,
    /// The drives at time t.
    u: Vec<f64>,
    /// Coordinates and velocities of 0.
    rest: Vec<f64>,
    /// Directions of rigid motions, one in each column.
    rigid: DMatrix<f64>,
}

impl<'m> Search<'m> {
    fn new(model: &'m dyn Periodic, t: f64) -> Self {
        let n = model.dof();
        let mut u = vec![0.0; model.drives()];
        model.drive(t, Side::After, &mut u);
        let rigid = rigid_modes(model, model.period());
        let rigid = DMatrix::from_fn(n, rigid.len(), |i, j| rigid[j][i]);
        Search { model, t, u, rest: vec![0.0; n], rigid }
    }

    /// The contacts in a position.
    fn contacts(&self, q: &[f64]) -> Vec<Contact> {
        let mut contacts = vec![Contact::default(); self.model.contacts()];
        self.model.contact(&self.u, q, &self.rest, &mut contacts);
        contacts
    }

    /// Upper flanks first; a contact that pulls changes its piece.
    fn by_flanks(&self) -> Result<StaticState, LinearError> {
        let mut pieces = vec![Piece::Upper; self.model.contacts()];
        // Flanks that a contact has left because it pulled.
        let mut left = vec![[false; 2]; pieces.len()];
        for _ in 0..TRIES {
            let (q, acceleration) = self.balanced(&pieces, &self.rest)?;
            let contacts = self.contacts(&q);
            let found: Vec<Piece> =
                (0..pieces.len()).map(|i| next_piece(pieces[i], &contacts[i], &mut left[i])).collect();
            if found == pieces {
                let state = State { t: self.t, q, v: self.rest.clone() };
                return Ok(StaticState { state, contacts, pieces, acceleration });
            }
            pieces = found;
        }
        Err(LinearError::NoContactState { tried: TRIES })
    }

    /// The end of the motion q' = a(u, q, 0), without its rigid part. `None`: it does not come to rest.
    fn by_descent(&self) -> Result<Option<StaticState>, LinearError> {
        let (n, upper) = (self.rest.len(), vec![Piece::Upper; self.model.contacts()]);
        let mut q = self.balanced(&upper, &self.rest).map_or(self.rest.clone(), |(q, _)| q);
        let mut slopes = Slopes::new(self.model, vec![1.0; 2 * n], 0.0);
        slopes.at(Some(&upper), &self.u, &q, &self.rest);
        // The inverse of the first step is the largest stiffness.
        let mut inverse = slopes.jacobian.q.amax();
        let mut refused = None;
        for _ in 0..TRIES {
            if !(inverse.is_finite() && inverse > 0.0) {
                return Ok(None);
            }
            let Some(next) = self.step(&mut slopes, &q, inverse) else {
                inverse *= 16.0;
                continue;
            };
            q = next;
            inverse /= 8.0;
            let pieces: Vec<Piece> = self.contacts(&q).iter().map(piece_at).collect();
            if refused.as_ref() == Some(&pieces) {
                continue;
            }
            if let Ok((q, acceleration)) = self.balanced(&pieces, &q) {
                let contacts = self.contacts(&q);
                let mut left = vec![[true; 2]; pieces.len()];
                let rests = |i: usize| next_piece(pieces[i], &contacts[i], &mut left[i]) == pieces[i];
                if (0..pieces.len()).all(rests) {
                    let state = State { t: self.t, q, v: self.rest.clone() };
                    return Ok(Some(StaticState { state, contacts, pieces, acceleration }));
                }
            }
            refused = Some(pieces);
        }
        Ok(None)
    }

    /// Coordinates whose accelerations on fixed pieces are those of a rigid motion, by Newton's method with
    /// the least change of coordinates from `from`.
    fn balanced(&self, pieces: &[Piece], from: &[f64]) -> Result<(Vec<f64>, Vec<f64>), LinearError> {
        let Search { model, t, u, rest, rigid } = self;
        let (model, t, n) = (*model, *t, rest.len());
        let (mut q, mut a) = (from.to_vec(), rest.clone());
        accelerate(model, Some(pieces), u, rest, rest, &mut a);
        let load = a.iter().fold(0.0f64, |most, a| most.max(a.abs()));
        accelerate(model, Some(pieces), u, &q, rest, &mut a);
        let mut slopes = Slopes::new(model, vec![1.0; 2 * n], 0.0);
        let mut left = f64::INFINITY;
        for _ in 0..TRIES {
            slopes.at(Some(pieces), u, &q, rest);
            let jacobian = &slopes.jacobian.q;
            if jacobian.iter().chain(&a).any(|x| !x.is_finite()) {
                return Err(LinearError::NotFinite { t });
            }
            // J dq - r α = -a: α are the accelerations along the rigid motions. Rows and columns are scaled
            // to 1.
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

    /// A step of implicit Euler from q, (x - q)/h = a(x) - r α with x - q orthogonal to the rigid motions
    /// r, by Newton's method. `None`: Newton's method does not converge.
    fn step(&self, slopes: &mut Slopes<'m, dyn Periodic + 'm>, q: &[f64], inverse: f64) -> Option<Vec<f64>> {
        let (n, k) = (q.len(), self.rigid.ncols());
        let (mut x, mut a) = (q.to_vec(), vec![0.0; n]);
        for _ in 0..NEWTON_STEPS {
            accelerate(self.model, None, &self.u, &x, &self.rest, &mut a);
            slopes.at(None, &self.u, &x, &self.rest);
            let j = &slopes.jacobian.q;
            let matrix = Mat::from_fn(n + k, n + k, |row, column| match (row < n, column < n) {
                (true, true) => {
                    if row == column {
                        inverse - j[(row, row)]
                    } else {
                        -j[(row, column)]
                    }
                }
                (true, false) => self.rigid[(row, column - n)],
                (false, true) => self.rigid[(column, row - n)],
                (false, false) => 0.0,
            });
            let right =
                Mat::from_fn(
                    n + k,
                    1,
                    |row, _| if row < n { a[row] - (x[row] - q[row]) * inverse } else { 0.0 },
                );
            let step = matrix.partial_piv_lu().solve(&right);
            let largest =
                |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |most: f64, x| most.max(x.abs()));
            (0..n).for_each(|i| x[i] += step[(i, 0)]);
            if !x.iter().all(|x| x.is_finite()) {
                return None;
            }
            let change = largest(&mut (0..n).map(|i| step[(i, 0)]));
            if change <= 1e-12 * largest(&mut x.iter().copied()) {
                return Some(x);
            }
        }
        None
    }
}

/// The piece on which the deflection of a contact lies.
fn piece_at(contact: &Contact) -> Piece {
    match contact {
        Contact { deflection, upper, .. } if deflection >= upper => Piece::Upper,
        Contact { deflection, lower, .. } if deflection <= lower => Piece::Lower,
        _ => Piece::Gap,
    }
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

/// Number of equations from which a factorisation with pivots is tried before a singular value
/// decomposition, which takes longer.
const PIVOTS_FROM: usize = 128;

/// Smallest entry on the diagonal of R, as a share of the largest one, of equations that are independent.
const INDEPENDENT: f64 = 1e-10;

/// The least x with A x = b, for at least as many unknowns as equations, or with the least residual if the
/// equations depend on each other. `None`: the singular value decomposition does not converge.
fn least_solution(matrix: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let n = matrix.nrows();
    if n >= PIVOTS_FROM {
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
    use crate::linear::statics::{PIVOTS_FROM, least_solution};
    use nalgebra::{DMatrix, DVector};

    /// Both ways: equations of a chain that is held at one end, with one unknown too many; the same with an
    /// equation that depends on the others.
    #[test]
    fn least_solutions_agree() {
        for n in [PIVOTS_FROM, PIVOTS_FROM - 1] {
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
                // The least solution is orthogonal to the kernel, which is one direction unless rows are
                // equal.
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
