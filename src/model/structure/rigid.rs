//! Rigid motions: directions in which a model moves without deforming a contact or a shaft.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::equations::Model;
use crate::model::structure::level_rows::{Sparse, level, sparse, sparse_rows};
use crate::model::structure::singular::{LARGE, orthonormal, singular};
use crate::model::structure::slopes::{Slopes, accelerate, offered};
use crate::numeric::norms;
use crate::numeric::spread::golden;
use faer::Mat;
use nalgebra::DMatrix;

/// Rigid motions of a model.
pub(crate) struct Rigid {
    /// Directions, orthonormal.
    pub(crate) modes: Vec<Vec<f64>>,
    /// A singular value that differences cannot distinguish from zero, relative to those of the coordinates;
    /// `None` if there is none.
    pub(crate) doubtful: Option<f64>,
}

/// The directions of rigid motion. Doubtful directions do not count as rigid.
pub(crate) fn rigid_modes(model: &dyn Model, span: f64) -> Vec<Vec<f64>> {
    rigid_motions(model, span).modes
}

/// Orthonormal directions r of the coordinates with ∂a/∂q r = 0 and ∂a/∂v r = 0 at all times, in all states
/// and on both flanks.
///
/// The Jacobians are evaluated at up to eleven instants in (0, `span`) and states of as many sizes, with all
/// contacts on their lower and then on their upper flanks. A direction that a Jacobian resists is excluded.
/// Contacts in their gaps are not evaluated, because they resist no motion. A direction that changes
/// the deflection of a rigid stop is not a rigid motion: ∂d/∂q of these contacts counts as a Jacobian.
pub(crate) fn rigid_motions(model: &dyn Model, span: f64) -> Rigid {
    unresisted(model, span, &[false, true])
}

/// The same for ∂a/∂q (`velocity` false), ∂a/∂v (true) or both.
pub(super) fn unresisted(model: &dyn Model, span: f64, velocities: &[bool]) -> Rigid {
    let n = model.dof();
    let mut slopes = Slopes::new(model, vec![1.0; 2 * n], 0.0);
    let mut u = vec![0.0; model.drives()];
    let flanks = [vec![Piece::Lower; model.contacts()], vec![Piece::Upper; model.contacts()]];
    let (exact, mut a, rest) = (model.offers().jacobian, vec![0.0; n], vec![0.0; n]);
    // Jacobians, each divided by its largest entry; exact ones by that of each row.
    let mut jacobians = Vec::new();
    let mut free = Free::whole(n);
    let sizes = &SIZES[..if exact { SIZES_OF_PIECES } else { SIZES.len() }];
    for (instant, size) in sizes.iter().enumerate() {
        if exact && free.values.is_empty() {
            break;
        }
        model.drive(span * golden((instant + 1) as f64), Side::After, &mut u);
        let part = |i: usize| size * (golden((7 * instant + 3 * i + 2) as f64) - 0.5);
        let (q, v): (Vec<f64>, Vec<f64>) = (0..n).map(|i| (part(i), part(n + i))).unzip();
        jacobians.push(directions_of_stops(model, &u, &q));
        // A large model with one direction left: only the entries that are not 0 are made.
        if n >= LARGE && exact && free.values.len() == 1 {
            let rows = flanks.iter().map(|flank| sparse_rows(model, flank, velocities, [&u, &q, &v]));
            if let Some(rows) = rows.collect::<Option<Vec<_>>>() {
                let stops = sparse(&jacobians.pop().unwrap_or_default());
                free.one_resisted(&[vec![stops], rows.concat()].concat(), EXACT[1]);
                continue;
            }
        }
        slopes.scale.fill(*size);
        for flank in &flanks {
            if exact {
                model.jacobian(offered(model, Some(flank)), &u, &q, &v, &mut slopes.jacobian);
            }
            for &velocity in velocities {
                let mut rounding = 0.0;
                if !exact {
                    // In differences the rounding of spring forces hides weak dampers. Without an exact
                    // Jacobian ∂a/∂q is therefore evaluated at v = 0 and ∂a/∂v at q = 0.
                    let (q, v) = if velocity { (&rest, &v) } else { (&q, &rest) };
                    slopes.at(Some(flank), &u, q, v);
                    accelerate(model, Some(flank), &u, q, v, &mut a);
                    rounding = f64::EPSILON * norms::dot(&a, &a).sqrt() / (STEP * size);
                }
                let half = if velocity { &slopes.jacobian.v } else { &slopes.jacobian.q };
                let largest = half.iter().filter(|x| x.is_finite()).fold(0.0, |m: f64, x| m.max(x.abs()));
                if largest > 0.0 && rounding <= DIFFERENCE_ROUNDING * largest {
                    let mut rows = half.map(|x| if x.is_finite() { x / largest } else { 0.0 });
                    if exact {
                        level(&mut rows);
                    }
                    jacobians.push(rows);
                }
            }
        }
        // Differences have errors of their own: the directions then follow from all Jacobians at once.
        if exact {
            if instant == 0 && n >= LARGE {
                free.narrow(&jacobians);
            }
            free.resisted(&std::mem::take(&mut jacobians), EXACT);
        }
    }
    let limits = if exact { EXACT } else { DIFFERENCES };
    free.resisted(&jacobians, limits);
    free.motions(limits)
}

/// The directions of n coordinates.
fn coordinates(n: usize) -> Vec<Vec<f64>> {
    (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect()
}

/// The directions that no Jacobian so far resists.
struct Free {
    /// Norm of the first column of each coordinate that is not 0. Coordinates may be angles and lengths:
    /// they are multiplied by it. 0: no Jacobian so far depends on the coordinate.
    size: Vec<f64>,
    /// Orthonormal directions in the multiplied coordinates, one column each.
    basis: Vec<Vec<f64>>,
    /// The singular value that belongs to each direction.
    values: Vec<f64>,
}

impl Free {
    /// All directions of n coordinates.
    fn whole(n: usize) -> Self {
        Free { size: vec![0.0; n], basis: coordinates(n), values: vec![0.0; n] }
    }

    /// Narrows all directions down to few that contain every one which no Jacobian resists: those that one
    /// weighted sum C of the Jacobians does not resist, by a factorisation C = Q R with pivots. A singular
    /// value decomposition of all Jacobians takes longer.
    fn narrow(&mut self, jacobians: &[DMatrix<f64>]) {
        let n = self.size.len();
        let mut sum = DMatrix::<f64>::zeros(n, n);
        for (i, rows) in jacobians.iter().filter(|rows| rows.nrows() == n).enumerate() {
            let weight = 0.5 + golden((i + 1) as f64);
            sum.zip_apply(rows, |sum, x| *sum += x * weight);
        }
        let norms = sum.column_iter().map(|column| column.norm());
        let size: Vec<f64> = norms.map(|size| if size > 0.0 { size } else { 1.0 }).collect();
        let factors = Mat::from_fn(n, n, |i, j| sum[(i, j)] / size[j]).col_piv_qr();
        let (r, order) = (factors.R(), factors.P().arrays().0);
        let rank = (0..n).take_while(|&j| r[(j, j)].abs() > NARROW * r[(0, 0)].abs()).count();
        if n - rank > n / 8 {
            return;
        }
        self.basis = vec![vec![0.0; n]; n - rank];
        self.values = vec![0.0; n - rank];
        for c in 0..n - rank {
            // R x = 0 with one of the last unknowns 1, the others of them 0.
            let mut x = vec![0.0; rank];
            for i in (0..rank).rev() {
                let known: f64 = (i + 1..rank).map(|j| r[(i, j)] * x[j]).sum();
                x[i] = -(r[(i, rank + c)] + known) / r[(i, i)];
            }
            x.resize(n, 0.0);
            x[rank + c] = 1.0;
            x.iter().zip(order).for_each(|(x, &j)| self.basis[c][j] = x / size[j]);
        }
    }

    /// Keeps the directions that Jacobians of n columns do not resist, by singular value decomposition of
    /// the Jacobians along the directions. `clear`: value that is not zero, with 1 for a direction that is
    /// resisted like a coordinate on average.
    fn resisted(&mut self, jacobians: &[DMatrix<f64>], [_, clear]: [f64; 2]) {
        let (n, k) = (self.size.len(), self.values.len());
        if k == 0 {
            return;
        }
        for j in 0..n {
            let squares: f64 = jacobians.iter().map(|rows| rows.column(j).norm_squared()).sum();
            if self.size[j] == 0.0 && squares > 0.0 {
                self.size[j] = squares.sqrt();
                self.basis.iter_mut().for_each(|direction| direction[j] *= self.size[j]);
            }
        }
        if k == 1 && n > 1 {
            let jacobians: Vec<Sparse> = jacobians.iter().map(sparse).collect();
            return self.one_resisted(&jacobians, clear);
        }
        if k < n {
            orthonormal(&mut self.basis);
        } else {
            // All directions remain: their basis is the coordinates.
            self.basis = coordinates(n);
        }
        let size = |j: usize| if self.size[j] > 0.0 { self.size[j] } else { 1.0 };
        let scaled = |rows: &DMatrix<f64>, i: usize| -> Vec<f64> {
            rows.row(i).iter().enumerate().map(|(j, x)| x / size(j)).collect()
        };
        let places = jacobians.iter().flat_map(|rows| (0..rows.nrows()).map(move |i| (rows, i)));
        let scaled: Vec<Vec<f64>> = places.map(|(rows, i)| scaled(rows, i)).collect();
        let squares: f64 = scaled.iter().map(|row| norms::dot(row, row)).sum();
        let norm = (squares / n as f64).sqrt();
        if norm == 0.0 {
            return;
        }
        let along = |row: &Vec<f64>, c: usize| if k < n { norms::dot(row, &self.basis[c]) } else { row[c] };
        let column = |c: usize| {
            let seen = (0..k).map(|i| if i == c { self.values[c] } else { 0.0 });
            scaled.iter().map(|row| along(row, c) / norm).chain(seen).collect()
        };
        let Some(found) = singular((0..k).map(column).collect()) else {
            return;
        };
        let turned = |turn: &[f64]| -> Vec<f64> {
            (0..n)
                .map(|j| turn.iter().zip(&self.basis).map(|(x, direction)| x * direction[j]).sum())
                .collect()
        };
        let left = found.iter().filter(|(value, _)| *value <= clear);
        (self.values, self.basis) = left.map(|(value, turn)| (*value, turned(turn))).unzip();
    }

    /// The same for the one direction that is left, whose singular value is a norm.
    fn one_resisted(&mut self, jacobians: &[Sparse], clear: f64) {
        let direction = &mut self.basis[0];
        let length = norms::dot(direction, direction).sqrt();
        direction.iter_mut().for_each(|x| *x /= length);
        let (mut squares, mut along) = (0.0, 0.0);
        for rows in jacobians {
            let mut sums = vec![0.0; rows.iter().map(|(i, ..)| i + 1).max().unwrap_or(0)];
            for &(i, j, x) in rows {
                let scaled = if self.size[j] > 0.0 { x / self.size[j] } else { x };
                squares += scaled * scaled;
                sums[i] += scaled * self.basis[0][j];
            }
            along += norms::dot(&sums, &sums);
        }
        if squares == 0.0 {
            return;
        }
        // Relative to the mean square of the coordinates.
        self.values[0] = (along * self.size.len() as f64 / squares).sqrt().hypot(self.values[0]);
        if self.values[0] > clear {
            (self.basis, self.values) = (Vec::new(), Vec::new());
        }
    }

    /// The rigid motions in the coordinates of the model.
    fn motions(&self, [zero, _]: [f64; 2]) -> Rigid {
        let mut rigid = Rigid { modes: Vec::new(), doubtful: None };
        for (c, &value) in self.values.iter().enumerate() {
            if value > zero {
                rigid.doubtful = Some(value);
                continue;
            }
            let size = self.size.iter().map(|&size| if size > 0.0 { size } else { 1.0 });
            let mut r: Vec<f64> = self.basis[c].iter().zip(size).map(|(x, size)| x / size).collect();
            rigid.modes.iter().for_each(|other| norms::remove(other, &mut r));
            let length = norms::dot(&r, &r).sqrt();
            r.iter_mut().for_each(|x| *x /= length);
            rigid.modes.push(r);
        }
        rigid
    }
}

/// Sizes of the states. In any unit, one of them is well above the rounding length of a smoothed law.
const SIZES: [f64; 11] = [1.0, 1e-2, 1e2, 1e-4, 1e4, 1e-6, 3.0, 1e-3, 1e3, 1e6, 1e8];

/// Number of these sizes for a model that offers its Jacobian. Other models are probed by differences, which
/// see a contact far from 0 in large states only.
const SIZES_OF_PIECES: usize = 9;

/// Largest entry on the diagonal of R, as a share of the first one, of a direction that remains after
/// narrowing down: far above the rounding errors of directions without resistance.
const NARROW: f64 = 1e-7;

/// Limits of a singular value, for exact Jacobians: zero up to the first limit, not zero from the second one,
/// doubtful between them.
const EXACT: [f64; 2] = [1e-12, 1e-12];

/// The same limits for Jacobians by differences, whose relative error is about 1e-10.
const DIFFERENCES: [f64; 2] = [1e-8, 1e-6];

/// Step of the differences, as a share of the size of the state.
const STEP: f64 = 5e-6;

/// Largest rounding of a difference, as a share of the largest entry. Jacobians with a larger one are not
/// used.
const DIFFERENCE_ROUNDING: f64 = 2e-10;

/// ∂d/∂q of every contact with a rigid stop, one row for each contact, divided by the largest entry of the
/// row. Because d' is linear in the velocities, ∂d/∂q follows from d' at unit velocities. Rows of other
/// contacts are 0.
fn directions_of_stops(model: &dyn Model, u: &[f64], q: &[f64]) -> DMatrix<f64> {
    let (n, rigid) = (q.len(), model.offers().rigid_edges(model.contacts()));
    let mut contacts = vec![Contact::default(); rigid.len()];
    let mut rates = |v: &[f64]| -> Vec<(f64, bool)> {
        if !contacts.is_empty() {
            model.contact(u, q, v, &mut contacts);
        }
        let met = |(c, r): (&Contact, &[bool; 2])| {
            (c.rate, (r[0] && c.lower.is_finite()) || (r[1] && c.upper.is_finite()))
        };
        contacts.iter().zip(&rigid).map(met).collect()
    };
    let (mut v, mut slopes) = (vec![0.0; n], DMatrix::zeros(rigid.len(), n));
    for j in 0..n {
        v[j] = 1.0;
        let above = rates(&v);
        v[j] = -1.0;
        for (i, (above, below)) in above.iter().zip(rates(&v)).enumerate().filter(|(_, (above, _))| above.1) {
            slopes[(i, j)] = 0.5 * (above.0 - below.0);
        }
        v[j] = 0.0;
    }
    for mut row in slopes.row_iter_mut() {
        let largest = row.amax();
        if largest > 0.0 {
            row /= largest;
        }
    }
    slopes
}

#[cfg(test)]
mod tests {
    use crate::error::ParameterError;
    use crate::model::structure::rigid::{LARGE, rigid_modes, rigid_motions};
    use crate::model::{Model, Periodic};
    use crate::models::nfg::{NfgPair, NfgParams};
    use crate::models::ring::{Frame, Ring, RingSet};

    #[test]
    fn the_ring_turns_freely_and_a_gap_does_not_count() -> Result<(), ParameterError> {
        for frame in [Frame::Rigid, Frame::Inertial] {
            let undamped = RingSet { mesh_damping: 0.0, ..RingSet::set_a(16, 5000.0) };
            for set in [RingSet::set_a(3, 1000.0), undamped, RingSet::set_a(LARGE, 1000.0)] {
                let mut params = set.params()?;
                params.gears[1].base_radius *= 1.5;
                let ring = Ring::as_printed(&params)?.with_frame(frame);
                let modes = rigid_modes(&ring, ring.period());
                assert_eq!(modes.len(), 1);
                for (x, r) in modes[0].iter().zip(ring.rigid_motion()) {
                    assert!((x / modes[0][0] - r).abs() < 1e-9, "{x} {r}");
                }
            }
        }
        let pair = NfgPair::new(&NfgParams { damping_ratio: 0.0, ..NfgParams::table1() })?;
        assert!(rigid_modes(&pair, pair.period()).is_empty());
        Ok(())
    }

    /// q1'' = -g(q1 - 2 q2), q2'' = 2 g(q1 - 2 q2), without damping, Jacobian, fixed pieces or contacts.
    struct TwoMasses {
        law: fn(f64) -> f64,
    }
    impl Model for TwoMasses {
        fn dof(&self) -> usize {
            2
        }
        fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            let w = (self.law)(q[0] - 2.0 * q[1]);
            (a[0], a[1]) = (-w, 2.0 * w);
        }
    }

    #[test]
    fn plain_models() {
        let laws: [fn(f64) -> f64; 4] = [
            |x| x,
            |x| x * x * x,
            |x| (x - 1e-5).max(0.0) - (-x - 1e-5).max(0.0),
            |x| (x - 30.0).max(0.0) - (-x - 30.0).max(0.0),
        ];
        for law in laws {
            let modes = rigid_modes(&TwoMasses { law }, 1.0);
            assert_eq!(modes.len(), 1);
            assert!((modes[0][0] / modes[0][1] - 2.0).abs() < 1e-6);
            assert_eq!(rigid_motions(&TwoMasses { law }, 1.0).doubtful, None);
        }
        assert_eq!(rigid_modes(&TwoMasses { law: |_| 0.0 }, 1.0).len(), 2);
    }
    /// Two masses. The second one is connected to the ground by a spring, whose stiffness is a given share
    /// of that of the spring between the masses.
    struct Supported(f64);
    impl Model for Supported {
        fn dof(&self) -> usize {
            2
        }
        fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            (a[0], a[1]) = (q[1] - q[0], q[0] - q[1] - self.0 * q[1]);
        }
    }

    #[test]
    fn differences_say_when_they_cannot_tell() {
        let found = |share| {
            let rigid = rigid_motions(&Supported(share), 1.0);
            (rigid.modes.len(), rigid.doubtful.is_some())
        };
        assert_eq!(found(0.0), (1, false));
        assert_eq!(found(1e-3), (0, false));
        assert_eq!(found(1e-7), (0, true));
    }
}
