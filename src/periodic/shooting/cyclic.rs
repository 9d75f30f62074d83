//! The cyclic block system of multiple shooting, solved by orthogonal transformations.

use crate::numeric::norms::right_vectors;
use nalgebra::DMatrix;
use nalgebra::DVector;
use nalgebra::Dyn;
use nalgebra::FullPivLU;
use nalgebra::QR;

/// X_i z_i - z_{i+1} = r_i for i = 0 .. N-1, with z_N = z_0 + B s and Bᵀ z_0 = 0.
///
/// Unknowns: corrections z_i at the N nodes and the slack s along the rigid modes B. The nodes are eliminated
/// one after the other by QR of the two block rows that contain the node. The elimination stays stable when
/// perturbations grow along the orbit. Its time is proportional to N. Source: Wright, SIAM J. Sci. Stat.
/// Comput. 13, 742 (1992).
pub(crate) struct Cyclic {
    stages: Vec<Stage>,
    close: FullPivLU<f64, Dyn, Dyn>,
    rigid: DMatrix<f64>,
}

/// R z_i + E z_0 + G z_{i+1} = p, with p the rotated right-hand side: the equation kept for the eliminated
/// node i.
struct Stage {
    qr: QR<f64, Dyn, Dyn>,
    own: DMatrix<f64>,
    first: DMatrix<f64>,
    next: DMatrix<f64>,
}

/// The closing system is singular if its smallest pivot is below this share of the largest.
const SINGULAR: f64 = 1e-13;

impl Cyclic {
    /// Factors the system for the transition matrices X_0, X_1, ... and the rigid modes B.
    ///
    /// Error: the system is singular (a fold, a branch point, or a coordinate without restoring force). The
    /// value is the component that the system determines least.
    pub(crate) fn factor(transitions: &[DMatrix<f64>], rigid: &DMatrix<f64>) -> Result<Self, usize> {
        let (head, rest) = transitions.split_first().ok_or(0usize)?;
        let (m, k) = rigid.shape();
        // Equation left over from the nodes before node i: a z_0 + c z_i = r.
        let (mut a, mut c) = (head.clone(), -DMatrix::identity(m, m));
        let mut stages = Vec::with_capacity(rest.len());
        for x in rest {
            let qr = below(&c, x).qr();
            let (mut first, mut next) =
                (below(&a, &DMatrix::zeros(m, m)), below(&DMatrix::zeros(m, m), &-DMatrix::identity(m, m)));
            qr.q_tr_mul(&mut first);
            qr.q_tr_mul(&mut next);
            (a, c) = (first.rows(m, m).into_owned(), next.rows(m, m).into_owned());
            let own = qr.r();
            stages.push(Stage {
                qr,
                own,
                first: first.rows(0, m).into_owned(),
                next: next.rows(0, m).into_owned(),
            });
        }
        let mut close = DMatrix::zeros(m + k, m + k);
        close.view_mut((0, 0), (m, m)).copy_from(&(&a + &c));
        close.view_mut((0, m), (m, k)).copy_from(&(&c * rigid));
        close.view_mut((m, 0), (k, m)).copy_from(&rigid.transpose());
        let lu = close.clone().full_piv_lu();
        let pivots = lu.u().diagonal().abs();
        if pivots.min() > SINGULAR * pivots.max() {
            return Ok(Cyclic { stages, close: lu, rigid: rigid.clone() });
        }
        let right = right_vectors(close);
        let loose = right.map(|v| v.row(m + k - 1).transpose().rows(0, m).iamax());
        Err(loose.unwrap_or(0))
    }

    /// Returns the corrections z_0, z_1, ... and the slack s for the right-hand sides r_0, r_1, ...
    pub(crate) fn solve(&self, right: &[DVector<f64>]) -> (Vec<DVector<f64>>, DVector<f64>) {
        let (m, k) = self.rigid.shape();
        let mut r = right[0].clone();
        let mut tops = Vec::with_capacity(self.stages.len());
        for (stage, right) in self.stages.iter().zip(&right[1..]) {
            let mut both = DVector::zeros(2 * m);
            both.rows_mut(0, m).copy_from(&r);
            both.rows_mut(m, m).copy_from(right);
            stage.qr.q_tr_mul(&mut both);
            tops.push(both.rows(0, m).into_owned());
            r = both.rows(m, m).into_owned();
        }
        let mut end = r.resize_vertically(m + k, 0.0);
        self.close.solve_mut(&mut end);
        let (first, slack) = (end.rows(0, m).into_owned(), end.rows(m, k).into_owned());
        // Back substitution from the last node; z_N = z_0 + B s.
        let mut following = &first + &self.rigid * &slack;
        let mut nodes = vec![first; self.stages.len() + 1];
        for (i, (stage, top)) in self.stages.iter().zip(&tops).enumerate().rev() {
            let mut right = top - &stage.first * &nodes[0] - &stage.next * &following;
            stage.own.solve_upper_triangular_mut(&mut right);
            following = right;
            nodes[i + 1].copy_from(&following);
        }
        (nodes, slack)
    }
}

/// The matrix `under` stacked below the matrix `above`.
fn below(above: &DMatrix<f64>, under: &DMatrix<f64>) -> DMatrix<f64> {
    let (m, n) = above.shape();
    let mut both = DMatrix::zeros(m + under.nrows(), n);
    both.rows_mut(0, m).copy_from(above);
    both.rows_mut(m, under.nrows()).copy_from(under);
    both
}

#[cfg(test)]
mod tests {
    use crate::periodic::shooting::cyclic::{Cyclic, DMatrix, DVector};

    /// The solution satisfies every equation of the ring and Bᵀ z_0 = 0.
    #[test]
    fn ring_of_blocks() -> Result<(), &'static str> {
        let entry =
            |i: usize, j: usize, k: usize| ((1 + i + 5 * j + 11 * k) as f64 * 0.618).fract() * 2.0 - 0.7;
        for (nodes, m, k) in [(1, 2, 0), (5, 2, 0), (4, 4, 2), (1, 4, 2)] {
            let x: Vec<_> = (0..nodes).map(|i| DMatrix::from_fn(m, m, |a, b| entry(i, a, b))).collect();
            let rigid = DMatrix::from_fn(m, k, |a, b| entry(9, a, b));
            let right: Vec<_> = (0..nodes).map(|i| DVector::from_fn(m, |a, _| entry(i, a, 3))).collect();
            let system = Cyclic::factor(&x, &rigid).map_err(|_| "singular")?;
            let (z, slack) = system.solve(&right);
            assert!((rigid.transpose() * &z[0]).amax() < 1e-12);
            for i in 0..nodes {
                let next = if i + 1 < nodes { z[i + 1].clone() } else { &z[0] + &rigid * &slack };
                assert!((&x[i] * &z[i] - next - &right[i]).amax() < 1e-11, "{nodes} {m} {k}");
            }
        }
        assert!(Cyclic::factor(&[DMatrix::identity(2, 2)], &DMatrix::zeros(2, 0)).is_err());
        Ok(())
    }
}
