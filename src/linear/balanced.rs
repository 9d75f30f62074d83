//! Positions in which the mean accelerations of a model vanish, except along its rigid motions.

use crate::contact::{Contact, Piece};
use crate::linear::instants::{Instants, Mean};
use crate::linear::modes::LinearError;
use crate::model::Periodic;
use crate::model::structure::slopes::Slopes;
use crate::numeric::equations::bordered::Bordered;
use crate::numeric::equations::entries::Entries;
use crate::numeric::equations::least::least_solution;
use crate::numeric::norms::largest;
use nalgebra::{DMatrix, DVector};

/// Accelerations that are left in balance, as a share of the load of the coordinate.
const BALANCED: f64 = 1e-9;

/// Rounding of an acceleration, as a share of the terms whose sum it is.
const ROUNDED: f64 = 1e-13;

/// Maximum number of Newton steps on fixed pieces.
const TRIES: usize = 200;

/// Maximum number of Newton steps for one step of implicit Euler.
const NEWTON_STEPS: usize = 60;

/// Steps with the same stiffness go on while each one leaves at most this share of the accelerations.
const FAST: f64 = 0.1;

/// Shortest share of a step that is tried where the accelerations grow.
const SHORTEST: f64 = 0.02;

/// An acceleration below this share of the largest load counts as none. If no part is loaded, it is a share
/// of the largest acceleration that the preload k b of a fixed flank gives. It is the tolerance of a part
/// that carries nothing: the accelerations of such a part are sums of rounding errors.
const NOTHING: f64 = 1e-20;

/// Number of coordinates from which equations are sparse.
const SPARSE_FROM: usize = 128;

/// Stiffness that holds directions without stiffness in sparse equations, as a share of each coordinate's
/// own: with it they have a solution. Further steps with the same factors remove its effect.
const HELD: f64 = 1e-11;

/// A step with the same factors, after which more than this share of the accelerations is left, is the last.
const SLOW: f64 = 0.5;

/// Where a model balances.
pub(super) struct AtRest<'m> {
    pub(super) t: f64,
    /// Whether the drives are those of one instant, and not their means over a period.
    pub(super) of_instant: bool,
    pub(super) mean: Mean<'m>,
    /// Directions that no stiffness resists, one in each column: rigid motions, and those that only a drag
    /// resists.
    pub(super) rigid: &'m DMatrix<f64>,
    /// The flank of each contact that is tried first.
    pub(super) flanks: Vec<Piece>,
    /// The load of each coordinate: the mean size of its acceleration at q = 0 with all contacts in their
    /// gaps.
    loads: Vec<f64>,
    /// What may be left in a coordinate that carries nothing.
    least: f64,
}

/// A position and the accelerations that are left in it.
pub(super) type Balanced = (Vec<f64>, Vec<f64>);

/// A change of the coordinates, and the accelerations α along the rigid motions.
type Change = (Vec<f64>, DVector<f64>);

/// The piece on which a contact is tried first. It is the upper flank. A contact without an upper edge takes
/// its lower flank, and a contact without edges its gap.
fn first_flank(contact: &Contact) -> Piece {
    match contact {
        Contact { upper, .. } if upper.is_finite() => Piece::Upper,
        Contact { lower, .. } if lower.is_finite() => Piece::Lower,
        _ => Piece::Gap,
    }
}

/// The piece on which the deflection of a contact lies.
pub(super) fn piece_at(contact: &Contact) -> Piece {
    match contact {
        Contact { deflection, upper, .. } if deflection >= upper => Piece::Upper,
        Contact { deflection, lower, .. } if deflection <= lower => Piece::Lower,
        _ => Piece::Gap,
    }
}

impl<'m> AtRest<'m> {
    pub(super) fn new(model: &'m dyn Periodic, t: f64, instants: Instants, rigid: &'m DMatrix<f64>) -> Self {
        let of_instant = instants.is_one();
        let mean = Mean::new(model, instants.joined());
        let loads = mean.sizes(&vec![Piece::Gap; model.contacts()]);
        let flanks: Vec<Piece> = mean.contacts(&mean.rest).iter().map(first_flank).collect();
        // A wide gap must not hide a light load: the flanks count only where nothing is loaded.
        let on_flanks = || largest(&mean.sizes(&flanks));
        let size = Some(largest(&loads)).filter(|load| *load > 0.0).unwrap_or_else(on_flanks);
        let least = if size.is_finite() { NOTHING * size } else { 0.0 };
        AtRest { t, of_instant, mean, rigid, flanks, loads, least }
    }

    /// The largest load.
    pub(super) fn load(&self) -> f64 {
        largest(&self.loads)
    }

    /// How far the accelerations `rests` in a position exceed what may be left in balance: the largest of
    /// them over its tolerance. A coordinate may keep a share of its load, and the rounding of the terms
    /// whose sum its acceleration is. A part without a load has neither: for it a smallest acceleration
    /// counts.
    ///
    /// `drift`: the accelerations of a rigid motion, which are not part of `rests`. If the drift of every
    /// loaded coordinate is within its tolerance, the drift is rounding. A body in its gap carries nothing
    /// and does not follow the drift.
    pub(super) fn excess(&self, pieces: &[Piece], rests: &[f64], q: &[f64], drift: &[f64]) -> f64 {
        // A model that does not know its terms may hold the largest of them in any coordinate.
        let unknown = || vec![largest(&self.mean.sizes(pieces)); q.len()];
        let terms = self.mean.terms(pieces, q).unwrap_or_else(unknown);
        let tolerance = |i: usize| BALANCED * self.loads[i] + ROUNDED * terms[i] + self.least;
        let is_rounding = (0..q.len()).all(|i| self.loads[i] == 0.0 || drift[i].abs() <= tolerance(i));
        let free = |i: usize| if is_rounding { 2.0 * drift[i].abs() } else { 0.0 };
        (0..q.len()).fold(0.0, |most: f64, i| {
            let share = rests[i].abs() / (tolerance(i) + free(i)).max(f64::MIN_POSITIVE);
            if share.is_nan() { f64::INFINITY } else { most.max(share) }
        })
    }

    /// Whether another sum over the period gives the same mean accelerations at rest: with all contacts in
    /// their gaps, and with all on their first flanks.
    pub(super) fn has_loads_of(&self, other: &AtRest<'_>) -> bool {
        let rest = &self.mean.rest;
        [&vec![Piece::Gap; self.flanks.len()], &self.flanks].into_iter().all(|pieces| {
            let [own, of_other] = [self, other].map(|sum| sum.mean.acceleration(Some(pieces), rest));
            let changes: Vec<f64> = own.iter().zip(&of_other).map(|(a, b)| a - b).collect();
            self.excess(pieces, &changes, rest, rest) <= 1.0
        })
    }

    /// Coordinates whose accelerations on fixed pieces are those of a rigid motion, by Newton's method.
    pub(super) fn balanced(&self, pieces: &[Piece], from: &[f64]) -> Result<Balanced, LinearError> {
        if from.len() >= SPARSE_FROM
            && let Some(found) = self.by_sparse_equations(pieces, from)
        {
            return found;
        }
        self.by_full_equations(pieces, from)
    }

    /// Each Newton step is the least change of the scaled coordinates. Its equations may be singular.
    fn by_full_equations(&self, pieces: &[Piece], from: &[f64]) -> Result<Balanced, LinearError> {
        let mut slopes = self.slopes();
        let mut newton = NewtonOnPieces::new(self, pieces, from);
        let mut jacobian = self.mean.jacobian(&mut slopes, Some(pieces), from);
        for _ in 0..TRIES {
            if jacobian.iter().chain(&newton.a).any(|x| !x.is_finite()) {
                return Err(LinearError::NotFinite { t: self.t });
            }
            let change = self.least_change(&jacobian, &newton.a)?;
            let slow = newton.step(change);
            if newton.balances || newton.is_lost() {
                break;
            }
            // The load balances: the next step is the last one, to rounding.
            if newton.left <= 1.0 && !slow {
                continue;
            }
            let here = self.mean.jacobian(&mut slopes, Some(pieces), &newton.q);
            if slow && here == jacobian {
                break;
            }
            jacobian = here;
        }
        newton.end()
    }

    /// The least solution of J dq - R α = -a with rows and columns scaled to 1.
    fn least_change(&self, jacobian: &DMatrix<f64>, a: &[f64]) -> Result<Change, LinearError> {
        let (n, rigid) = (a.len(), self.rigid);
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
            return Err(LinearError::NotFinite { t: self.t });
        }
        let mut step = least_solution(matrix, &right).ok_or(LinearError::NotConverged { rows: n })?;
        step.iter_mut().zip(&columns).for_each(|(step, scale)| *step *= scale);
        Ok((step.rows(0, n).iter().copied().collect(), step.rows(n, rigid.ncols()).clone_owned()))
    }

    /// The same by sparse factors, with changes orthogonal to the rigid motions. `None`: the equations are
    /// too close to singular ones, or it does not end in balance and the stiffness is not symmetric.
    fn by_sparse_equations(&self, pieces: &[Piece], from: &[f64]) -> Option<Result<Balanced, LinearError>> {
        let mut slopes = self.slopes();
        let mut newton = NewtonOnPieces::new(self, pieces, from);
        let mut stiffness = self.mean.stiffness(&mut slopes, Some(pieces), from);
        let mut alpha = DVector::zeros(self.rigid.ncols());
        for _ in 0..TRIES {
            let stiffest = stiffness.largest();
            if !(stiffest.is_finite() && stiffest > 0.0) {
                return None;
            }
            let held = |k: f64| HELD * if k == 0.0 { stiffest } else { k.abs() };
            let shift: Vec<f64> = stiffness.diagonal().into_iter().map(held).collect();
            let equations = Bordered::of(&stiffness, &shift, self.rigid)?;
            for _ in 0..TRIES {
                let drift = self.rigid * &alpha;
                let rest = newton.a.iter().zip(drift.iter()).map(|(a, d)| a - d).collect();
                let (change, more) = equations.solve(rest)?;
                alpha += more;
                let slow = newton.step((change, alpha.clone()));
                if newton.balances {
                    return Some(newton.end());
                }
                if slow {
                    break;
                }
            }
            let here = self.mean.stiffness(&mut slopes, Some(pieces), &newton.q);
            if newton.is_lost() || here == stiffness {
                break;
            }
            stiffness = here;
        }
        (newton.left <= 1.0 || stiffness.is_sign_symmetric()).then(|| newton.end())
    }

    /// A step of implicit Euler from q, (x - q)/h = a(x) - r α with x - q orthogonal to the rigid motions r,
    /// by Newton's method. `pieces`: those on which the accelerations in a position are taken. `stiffness`:
    /// that of the step before, which is made anew where Newton's method becomes slow. `None`: it does not
    /// converge.
    pub(super) fn euler(
        &self,
        slopes: &mut Slopes<'m>,
        pieces: &dyn Fn(&[f64]) -> Option<Vec<Piece>>,
        stiffness: &mut Option<Entries>,
        q: &[f64],
        inverse: f64,
    ) -> Option<Vec<f64>> {
        let (mut x, shift) = (q.to_vec(), vec![inverse; q.len()]);
        let left = |x: &[f64]| {
            let on = pieces(x);
            let mut left = self.mean.acceleration(on.as_deref(), x);
            left.iter_mut().zip(x.iter().zip(q)).for_each(|(a, (x, q))| *a -= (x - q) * inverse);
            (left, on)
        };
        let (mut known, (mut right, mut on)) = (None, left(&x));
        // The positions in which the stiffness was made anew. If Newton's method comes back to one of
        // them, it repeats the same steps for ever.
        let mut places: Vec<Vec<f64>> = Vec::new();
        for _ in 0..NEWTON_STEPS {
            let (equations, scale) = match &known {
                Some(known) => known,
                None => {
                    if stiffness.is_none() {
                        let apart = |place: &Vec<f64>| {
                            place.iter().zip(&x).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
                        };
                        if places.iter().any(|place| apart(place) <= 1e-12 * largest(&x)) {
                            return None;
                        }
                        places.push(x.clone());
                    }
                    let stiffness =
                        stiffness.get_or_insert_with(|| self.mean.stiffness(slopes, on.as_deref(), &x));
                    let scale: Vec<f64> =
                        stiffness.diagonal().iter().map(|k| 1.0 / (inverse + k.abs())).collect();
                    known.insert((Bordered::of(stiffness, &shift, self.rigid)?, scale))
                }
            };
            let (step, alpha) = equations.solve(right.clone())?;
            if largest(&step) <= 1e-12 * largest(&x) {
                x.iter_mut().zip(&step).for_each(|(x, step)| *x += step);
                return Some(x);
            }
            // The accelerations of the rigid motion stay.
            let drift = self.rigid * alpha;
            let size = |left: &[f64]| -> f64 {
                let rest = left.iter().zip(drift.iter()).zip(scale);
                rest.map(|((a, drift), scale)| ((a - drift) * scale).powi(2)).sum()
            };
            let (before, mut share) = (size(&right), 1.0);
            let after = loop {
                let trial: Vec<f64> = x.iter().zip(&step).map(|(x, step)| x + share * step).collect();
                let (left, pieces) = left(&trial);
                let after = size(&left);
                if after <= before || share < SHORTEST {
                    (x, right, on) = (trial, left, pieces);
                    break after;
                }
                share *= 0.5;
            };
            if after > FAST * FAST * before {
                (known, *stiffness) = (None, None);
            }
        }
        None
    }

    pub(super) fn slopes(&self) -> Slopes<'m> {
        Slopes::new(self.mean.model, vec![1.0; 2 * self.mean.rest.len()], 0.0)
    }
}

/// Newton's method on fixed pieces.
struct NewtonOnPieces<'e> {
    at_rest: &'e AtRest<'e>,
    pieces: &'e [Piece],
    q: Vec<f64>,
    a: Vec<f64>,
    /// The accelerations without those along rigid motions: the largest one over its tolerance, and the
    /// largest one itself.
    left: f64,
    largest: f64,
    balances: bool,
}

impl<'e> NewtonOnPieces<'e> {
    fn new(at_rest: &'e AtRest<'_>, pieces: &'e [Piece], from: &[f64]) -> Self {
        let (a, left) = (at_rest.mean.acceleration(Some(pieces), from), f64::INFINITY);
        NewtonOnPieces { at_rest, pieces, q: from.to_vec(), a, left, largest: left, balances: false }
    }

    /// Makes a step. Returns whether much of the accelerations is left.
    fn step(&mut self, (change, alpha): Change) -> bool {
        let AtRest { mean, rigid, .. } = self.at_rest;
        self.q.iter_mut().zip(&change).for_each(|(q, step)| *q += step);
        self.a = mean.acceleration(Some(self.pieces), &self.q);
        let drift = *rigid * alpha;
        let rest: Vec<f64> = self.a.iter().zip(drift.iter()).map(|(a, d)| a - d).collect();
        let left = self.at_rest.excess(self.pieces, &rest, &self.q, drift.as_slice());
        let moved = largest(&change) <= 1e-12 * largest(&self.q).max(f64::MIN_POSITIVE);
        self.balances = left <= 1.0 && moved || left == 0.0;
        let slow = left > SLOW * self.left;
        (self.left, self.largest) = (left, largest(&rest));
        slow
    }

    /// Whether the position is without bound.
    fn is_lost(&self) -> bool {
        self.q.iter().chain(&self.a).any(|x| !x.is_finite())
    }

    /// The position. An error if it is none of balance: the load moves the model without bound.
    fn end(self) -> Result<Balanced, LinearError> {
        if self.left > 1.0 || self.is_lost() {
            return Err(LinearError::Free { residual: self.largest / self.at_rest.load() });
        }
        Ok((self.q, self.a))
    }
}
