//! Rigid motions: directions in which a model moves without deforming a contact or a shaft.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::excitation::side::Side;
use crate::model::equations::{Jacobian, Model};
use crate::model::offers::Offers;
use crate::model::slopes::{Slopes, accelerate};
use crate::numeric::spread::golden;
use nalgebra::DMatrix;

/// Rigid motions of a model.
pub(crate) struct Rigid {
    /// Directions, orthonormal.
    pub(crate) modes: Vec<Vec<f64>>,
    /// A singular value, relative to the largest one, that differences cannot distinguish from zero; `None`
    /// if there is none.
    pub(crate) doubtful: Option<f64>,
}

/// The directions of rigid motion. Doubtful directions do not count as rigid.
pub(crate) fn rigid_modes<M: Model + ?Sized>(model: &M, span: f64) -> Vec<Vec<f64>> {
    rigid_motions(model, span).modes
}

/// Orthonormal directions r of the coordinates with ∂a/∂q r = 0 and ∂a/∂v r = 0 at all times, in all states
/// and on both flanks.
///
/// The directions are the null space of a stack of Jacobians, by singular value decomposition. The Jacobians
/// are evaluated at nine instants in (0, `span`) and states of nine sizes, with all contacts on their lower
/// and then on their upper flanks. Contacts in their gaps are not evaluated, because they resist no motion.
/// A direction that changes the deflection of a rigid stop is not a rigid motion: ∂d/∂q of these contacts
/// belongs to the stack.
pub(crate) fn rigid_motions<M: Model + ?Sized>(model: &M, span: f64) -> Rigid {
    let n = model.dof();
    let mut slopes = Slopes::new(model, vec![1.0; 2 * n], 0.0);
    let mut u = vec![0.0; model.drives()];
    let flanks = [vec![Piece::Lower; model.contacts()], vec![Piece::Upper; model.contacts()]];
    // The stack of all Jacobians, each divided by its largest entry.
    let mut jacobians = DMatrix::<f64>::zeros(0, n);
    let (mut exact, mut a) = (true, vec![0.0; n]);
    for (look, size) in SIZES.iter().enumerate() {
        model.drive(span * golden((look + 1) as f64), Side::After, &mut u);
        let part = |i: usize| size * (golden((7 * look + 3 * i + 2) as f64) - 0.5);
        let (q, v): (Vec<f64>, Vec<f64>) = (0..n).map(|i| (part(i), part(n + i))).unzip();
        let rest = vec![0.0; n];
        jacobians = compressed(jacobians, &directions_of_stops(model, &u, &q));
        slopes.scale.fill(*size);
        for flank in &flanks {
            exact &= model.jacobian(Some(flank), &u, &q, &v, &mut Jacobian::new(n));
            // In differences the rounding of spring forces hides weak dampers. Without an exact Jacobian
            // ∂a/∂q is therefore evaluated at v = 0 and ∂a/∂v at q = 0.
            for velocity in [false, true] {
                let (q, v) = match (exact, velocity) {
                    (true, _) => (&q, &v),
                    (_, false) => (&q, &rest),
                    (_, true) => (&rest, &v),
                };
                slopes.at(Some(flank), &u, q, v);
                let half = if velocity { &slopes.jacobian.v } else { &slopes.jacobian.q };
                let largest = half.iter().filter(|x| x.is_finite()).fold(0.0, |m: f64, x| m.max(x.abs()));
                accelerate(model, Some(flank), &u, q, v, &mut a);
                let rounding = f64::EPSILON * crate::numeric::norms::dot(&a, &a).sqrt() / (STEP * size);
                if largest > 0.0 && (exact || rounding <= ROUNDING * largest) {
                    let scaled = half.map(|x| if x.is_finite() { x / largest } else { 0.0 });
                    jacobians = compressed(jacobians, &scaled);
                }
            }
        }
    }
    nullspace(&jacobians, n, if exact { EXACT } else { DIFFERENCES })
}

/// Sizes of the states. In any unit, one of them is well above the rounding length of a smoothed law.
const SIZES: [f64; 9] = [1.0, 1e-2, 1e2, 1e-4, 1e4, 1e-6, 3.0, 1e-3, 1e3];

/// Limits of a singular value relative to the largest one, for exact Jacobians: zero up to the first limit,
/// not zero from the second one, doubtful between them.
const EXACT: [f64; 2] = [1e-12, 1e-12];

/// The same limits for Jacobians by differences, whose relative error is about 1e-10.
const DIFFERENCES: [f64; 2] = [1e-8, 1e-6];

/// Step of the differences, as a share of the size of the state.
const STEP: f64 = 5e-6;

/// Largest rounding of a difference, as a share of the largest entry. Jacobians with a larger one are not
/// used.
const ROUNDING: f64 = 2e-10;

/// ∂d/∂q of every contact with a rigid stop, one row for each contact, divided by the largest entry of the
/// row. Because d' is linear in the velocities, ∂d/∂q follows from d' at unit velocities. Rows of other
/// contacts are 0.
fn directions_of_stops<M: Model + ?Sized>(model: &M, u: &[f64], q: &[f64]) -> DMatrix<f64> {
    let (n, rigid) = (q.len(), Offers::of(model).rigid_edges());
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

/// Stacks two matrices of n columns. More than n rows are reduced to n rows with the same null space, by QR.
fn compressed(above: DMatrix<f64>, below: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, rows) = (below.ncols(), above.nrows());
    let mut both = above.insert_rows(rows, below.nrows(), 0.0);
    both.view_mut((rows, 0), (below.nrows(), n)).copy_from(below);
    if both.nrows() <= n { both } else { both.qr().r() }
}

/// The null space of the stack of n columns, with the limits for a singular value.
fn nullspace(jacobians: &DMatrix<f64>, n: usize, [zero, clear]: [f64; 2]) -> Rigid {
    let unit = |k: usize| (0..n).map(|i| if i == k { 1.0 } else { 0.0 }).collect();
    let mut rigid = Rigid { modes: Vec::new(), doubtful: None };
    if jacobians.nrows() < n {
        rigid.modes.extend((0..n).map(unit));
        return rigid;
    }
    // Columns are divided by their norms, because coordinates may be angles and lengths.
    let size: Vec<f64> =
        jacobians.column_iter().map(|c| if c.norm() > 0.0 { c.norm() } else { 1.0 }).collect();
    let svd = DMatrix::from_fn(jacobians.nrows(), n, |i, j| jacobians[(i, j)] / size[j]).svd(false, true);
    let largest = svd.singular_values.max();
    if let Some(right) = svd.v_t {
        for (row, value) in right.row_iter().zip(svd.singular_values.iter().map(|value| value / largest)) {
            if value > zero {
                rigid.doubtful = if value < clear { Some(value) } else { rigid.doubtful };
            } else {
                let mut r: Vec<f64> = row.iter().zip(&size).map(|(x, s)| x / s).collect();
                rigid.modes.iter().for_each(|other| crate::numeric::norms::remove(other, &mut r));
                let length = crate::numeric::norms::dot(&r, &r).sqrt();
                r.iter_mut().for_each(|x| *x /= length);
                rigid.modes.push(r);
            }
        }
    }
    rigid
}

#[cfg(test)]
mod tests {
    use crate::model::rigid::{rigid_modes, rigid_motions};
    use crate::models::nfg::{NfgPair, NfgParams};
    use crate::models::ring::{Frame, Ring, RingSet};
    use crate::{Model, ParameterError, Periodic};

    #[test]
    fn the_ring_turns_freely_and_a_gap_does_not_count() -> Result<(), ParameterError> {
        for frame in [Frame::Rigid, Frame::Inertial] {
            for set in
                [RingSet::set_a(3, 1000.0), RingSet { mesh_damping: 0.0, ..RingSet::set_a(16, 5000.0) }]
            {
                let mut params = set.params()?;
                params.gears[1].base_radius *= 1.5;
                let ring = Ring::as_printed(&params)?.in_frame(frame);
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
