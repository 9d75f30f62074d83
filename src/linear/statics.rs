//! Static deflection under load.

use crate::contact::{Contact, Piece};
use crate::error::check;
use crate::linear::instants::{Instants, Mean, mean_contacts, smooth_intervals};
use crate::linear::least::least_solution;
use crate::linear::modes::LinearError;
use crate::model::structure::rigid::rigid_modes;
use crate::model::structure::slopes::Slopes;
use crate::model::{Periodic, State};
use faer::Mat;
use faer::linalg::solvers::Solve;
use nalgebra::{DMatrix, DVector};

/// A static state: deflections under the mean load, or under that at one instant, without motion.
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
/// let rest = static_state(&parts.build("pinion", 100.0)?, None)?;
/// let contact = rest.contacts[0]; // 30 N m/0.03 m = 1000 N on 2e8 N/m past half the backlash
/// assert!((contact.force - 1000.0).abs() < 1e-9);
/// assert!((contact.deflection - 5.5e-5).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct StaticState {
    /// The time whose loads and drives the state balances; `None`: their means over a period.
    pub instant: Option<f64>,
    /// The state at rest at the time t: a start of integrations and solvers. A rigid motion of the model is
    /// left at rest.
    pub state: State,
    /// Contacts with their deflections, edges and forces: means over the period, or those at the instant.
    /// Forces are by deflection: their mean exceeds the mean load where the teeth part in some instants of
    /// the period. Their sum is then refined until two sums agree to 1e-6, up to some 80 000 points.
    pub contacts: Vec<Contact>,
    /// The piece of each contact.
    pub pieces: Vec<Piece>,
    /// Accelerations that are left: those of a rigid motion, if the load does not balance.
    pub acceleration: Vec<f64>,
}

/// Accelerations that are left in balance, as a share of the load.
const BALANCED: f64 = 1e-9;

/// Maximum number of contact states that are tried, and of Newton steps in each.
const TRIES: usize = 64;

/// Maximum number of Newton steps for one step of implicit Euler.
const NEWTON_STEPS: usize = 30;

/// Maximum number of intervals between two edges of the drives in the mean over a period.
const INTERVALS: usize = 16_384;

/// Number of evenly spaced instants in a period with more edges: a prime number, which no order divides.
const SPREAD: usize = 65_537;

/// Number of Gauss panels in a period, first and at most.
const PANELS: [usize; 2] = [8, 1024];

/// Largest change of a mean contact force by the halves of a panel that agrees with them, as a share of the
/// largest mean force `[1]`. A few panels have kinks.
const SAME_FORCE: f64 = 1e-7;

/// Number of Gauss panels in the sum that confirms a state. This sum sees smooth pulses down to a width of
/// 1/750 of the period.
const CONFIRMED: usize = 128;

/// The static state of a model: the position at rest in which no coordinate accelerates, except along a rigid
/// motion. `t`: under the loads and drives at this time. `None`: under their means over a period.
///
/// With `None` the mean acceleration over the period T is 0: (1/T) ∫ a(u(t), q, 0) dt = 0. This mean takes
/// each contact on one flank, or in its gap, for the whole period. The teeth therefore carry the mean load
/// even if the transmission error exceeds the static deflection. A wave that acts alone, such as a load, a
/// stiffness or a transmission error, enters with its mean. A product of two waves, such as stiffness times
/// transmission error, enters with the mean of the product. The integral is a Gauss sum between the edges of
/// the drives. It begins with some 40 points; their number is doubled until the balance holds to 1e-9 of the
/// load, up to some 5000, and confirmed with 640: a smooth pulse narrower than 1/750 of the period may be
/// missed. In a period with more than 16 384 edges the mean is that of 65 537 evenly spaced instants.
///
/// Every contact is on its upper flank at first; it changes to the lower flank if it pulls there, and to
/// the gap if both flanks pull. The load may be shared by contacts for which this search does not end. The
/// bodies then move from their position on all upper flanks until they rest. Their velocity is q' = a(q), the
/// mean acceleration of bodies that rest in q. Implicit Euler steps follow this motion. The steps grow while
/// Newton's method converges. The potential energy falls in the motion if no stiffness is negative.
///
/// If no pieces carry the mean load for the whole period, as with a lever that varies over the period, the
/// state is that at t = 0 and says so ([`StaticState::instant`]).
///
/// The first search starts at q = 0: a bearing with radial clearance has no direction there, and its static
/// state is not found.
///
/// # Errors
/// A Jacobian that is not finite; no consistent contact state; a load that moves bodies freely, as in a gap;
/// a period out of its range, if `t` is `None`.
pub fn static_state(model: &dyn Periodic, t: impl Into<Option<f64>>) -> Result<StaticState, LinearError> {
    let rigid = || {
        let rigid = rigid_modes(model, model.period());
        DMatrix::from_fn(model.dof(), rigid.len(), |i, j| rigid[j][i])
    };
    if let Some(t) = t.into() {
        check::finite("time", t)?;
        return Search::new(model, t, Instants::at(model, t), &rigid()).find();
    }
    check::scale("period of the model", model.period())?;
    let (rigid, bounds) = (rigid(), smooth_intervals(model, INTERVALS + 1));
    let intervals = bounds.len() - 1;
    let at_first = || Search::new(model, 0.0, Instants::at(model, 0.0), &rigid).find();
    if intervals > INTERVALS {
        let search = Search::new(model, 0.0, Instants::spread(model, SPREAD), &rigid);
        return search.find().or_else(|error| match error {
            LinearError::Free { .. } | LinearError::NoContactState { .. } => at_first(),
            error => Err(error),
        });
    }
    let mut panels = PANELS[0].div_ceil(intervals);
    let mut search = Search::new(model, 0.0, Instants::of(model, &bounds, panels), &rigid);
    loop {
        let found = match search.find() {
            Err(LinearError::Free { .. } | LinearError::NoContactState { .. }) => return at_first(),
            found => found?,
        };
        panels *= 2;
        if panels * intervals > PANELS[1] {
            return Ok(found);
        }
        search = Search::new(model, 0.0, Instants::of(model, &bounds, panels), &rigid);
        if search.confirms(&found) {
            if panels * intervals >= CONFIRMED {
                return Ok(with_contacts(found, model, &bounds, panels));
            }
            // Two coarse sums agree also if both miss a narrow pulse.
            panels = CONFIRMED.div_ceil(intervals);
            search = Search::new(model, 0.0, Instants::of(model, &bounds, panels), &rigid);
            if search.confirms(&found) {
                return Ok(with_contacts(found, model, &bounds, panels));
            }
        }
    }
}

/// The state with mean contacts that hold the kinks where teeth part, which the balance on fixed pieces does
/// not see.
fn with_contacts(found: StaticState, model: &dyn Periodic, bounds: &[f64], panels: usize) -> StaticState {
    let largest = found.contacts.iter().fold(0.0, |most: f64, c| most.max(c.force.abs()));
    let contacts = mean_contacts(model, &found.state.q, (bounds, panels), SAME_FORCE * largest);
    StaticState { contacts, ..found }
}

/// The search for a static state.
struct Search<'m> {
    t: f64,
    mean: Mean<'m>,
    /// Directions of rigid motions, one in each column.
    rigid: &'m DMatrix<f64>,
}

impl<'m> Search<'m> {
    fn new(model: &'m dyn Periodic, t: f64, instants: Instants, rigid: &'m DMatrix<f64>) -> Self {
        Search { t, mean: Mean::new(model, instants), rigid }
    }

    fn find(&self) -> Result<StaticState, LinearError> {
        match self.by_flanks() {
            Err(error @ (LinearError::Free { .. } | LinearError::NoContactState { .. })) => {
                self.by_descent()?.ok_or(error)
            }
            found => found,
        }
    }

    /// Whether a state that was found with fewer instants balances.
    fn confirms(&self, found: &StaticState) -> bool {
        let pieces = &found.pieces[..];
        let (a, load) = (self.mean.acceleration(Some(pieces), &found.state.q), self.mean.load(pieces));
        a.iter().zip(&found.acceleration).all(|(a, before)| (a - before).abs() <= BALANCED * load)
    }

    /// Upper flanks first; a contact that pulls changes its piece.
    fn by_flanks(&self) -> Result<StaticState, LinearError> {
        let mut pieces = vec![Piece::Upper; self.mean.model.contacts()];
        // Flanks that a contact has left because it pulled.
        let mut left = vec![[false; 2]; pieces.len()];
        for _ in 0..TRIES {
            let (q, acceleration) = self.balanced(&pieces, &self.mean.rest)?;
            let contacts = self.mean.contacts(&q);
            let found: Vec<Piece> =
                (0..pieces.len()).map(|i| next_piece(pieces[i], &contacts[i], &mut left[i])).collect();
            if found == pieces {
                return Ok(self.state(q, contacts, pieces, acceleration));
            }
            pieces = found;
        }
        Err(LinearError::NoContactState { tried: TRIES })
    }

    /// The end of the motion q' = a(u, q, 0), without its rigid part. `None`: it does not come to rest.
    fn by_descent(&self) -> Result<Option<StaticState>, LinearError> {
        let (n, upper) = (self.mean.rest.len(), vec![Piece::Upper; self.mean.model.contacts()]);
        let mut q = self.balanced(&upper, &self.mean.rest).map_or(self.mean.rest.clone(), |(q, _)| q);
        let mut slopes = Slopes::new(self.mean.model, vec![1.0; 2 * n], 0.0);
        // The inverse of the first step is the largest stiffness.
        let mut inverse = self.mean.jacobian(&mut slopes, Some(&upper), &q).amax();
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
            let pieces: Vec<Piece> = self.mean.contacts(&q).iter().map(piece_at).collect();
            if refused.as_ref() == Some(&pieces) {
                continue;
            }
            if let Ok((q, acceleration)) = self.balanced(&pieces, &q) {
                let contacts = self.mean.contacts(&q);
                let mut left = vec![[true; 2]; pieces.len()];
                let rests = |i: usize| next_piece(pieces[i], &contacts[i], &mut left[i]) == pieces[i];
                if (0..pieces.len()).all(rests) {
                    return Ok(Some(self.state(q, contacts, pieces, acceleration)));
                }
            }
            refused = Some(pieces);
        }
        Ok(None)
    }

    fn state(
        &self,
        q: Vec<f64>,
        contacts: Vec<Contact>,
        pieces: Vec<Piece>,
        acceleration: Vec<f64>,
    ) -> StaticState {
        StaticState {
            instant: self.mean.is_of_one_instant().then_some(self.t),
            state: State { t: self.t, q, v: self.mean.rest.clone() },
            contacts,
            pieces,
            acceleration,
        }
    }

    /// Coordinates whose accelerations on fixed pieces are those of a rigid motion, by Newton's method with
    /// the least change of coordinates from `from`.
    fn balanced(&self, pieces: &[Piece], from: &[f64]) -> Result<(Vec<f64>, Vec<f64>), LinearError> {
        let Search { t, mean: Mean { model, rest, .. }, rigid } = self;
        let (t, n, load) = (*t, rest.len(), self.mean.load(pieces));
        let (mut q, mut a) = (from.to_vec(), self.mean.acceleration(Some(pieces), from));
        let mut slopes = Slopes::new(*model, vec![1.0; 2 * n], 0.0);
        let mut left = f64::INFINITY;
        for _ in 0..TRIES {
            let jacobian = self.mean.jacobian(&mut slopes, Some(pieces), &q);
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
            a = self.mean.acceleration(Some(pieces), &q);
            let alpha = DVector::from_fn(rigid.ncols(), |j, _| step[n + j]);
            let drift = *rigid * &alpha;
            left = a.iter().zip(drift.iter()).fold(0.0f64, |most, (a, d)| most.max((a - d).abs()));
            if q.iter().any(|q| !q.is_finite()) || !left.is_finite() {
                return Err(LinearError::NotFinite { t });
            }
            let most = q.iter().fold(0.0f64, |most, q| most.max(q.abs()));
            if left <= BALANCED * load && change <= 1e-12 * most.max(f64::MIN_POSITIVE) || left == 0.0 {
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
    fn step(&self, slopes: &mut Slopes<'m>, q: &[f64], inverse: f64) -> Option<Vec<f64>> {
        let (n, k) = (q.len(), self.rigid.ncols());
        let mut x = q.to_vec();
        for _ in 0..NEWTON_STEPS {
            let (a, j) = (self.mean.acceleration(None, &x), self.mean.jacobian(slopes, None, &x));
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
