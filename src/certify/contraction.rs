//! The Newton operator on the cyclic system of all legs.

use crate::certify::stretch::Square;
use crate::interval::number::Interval;
use nalgebra::DMatrix;

/// Bounds of the Newton operator for the equations F_j(x_j) - x_(j+1) = 0 around a closed chain of boxes.
///
/// K(X) - m = G P(m) + (1 + G P'(X)) (X - m), with the defects P_j(m) = F_j(m_j) - m_(j+1) and an approximate
/// inverse G of -P'. If K(X) lies inside X, there is exactly one solution in X.   Source: Krawczyk 1969; Rump,
/// Acta Numerica 19, 287 (2010), Sect. 13.
pub(super) struct Newton<'a> {
    pub(super) defects: &'a [Vec<Interval>],
    pub(super) slopes: &'a [Square],
    middles: Vec<DMatrix<f64>>,
}

impl<'a> Newton<'a> {
    pub(super) fn new(defects: &'a [Vec<Interval>], slopes: &'a [Square]) -> Self {
        let middles = slopes.iter().map(Square::middle).collect();
        Newton { defects, slopes, middles }
    }

    /// The derivative of the motion over one turn from each node, in plain numbers.
    pub(super) fn turn_from(&self, node: usize) -> DMatrix<f64> {
        let (count, d) = (self.middles.len(), self.middles[0].nrows());
        (0..count).fold(DMatrix::identity(d, d), |product, k| &self.middles[(node + k) % count] * product)
    }

    /// Row `node` of the approximate inverse: x_node = Σ_j G_j P_j; `None` if a turn has the multiplier 1.
    fn row(&self, node: usize) -> Option<Vec<DMatrix<f64>>> {
        let (count, d) = (self.middles.len(), self.middles[0].nrows());
        let mut row = vec![DMatrix::zeros(d, d); count];
        let mut factor = (DMatrix::identity(d, d) - self.turn_from(node)).try_inverse()?;
        for back in 1..=count {
            let j = (node + count - back) % count;
            row[j] = factor.clone();
            factor = &factor * &self.middles[j];
        }
        row.iter().all(|g| g.iter().all(|x| x.is_finite())).then_some(row)
    }

    /// The correction of a node in plain numbers.
    pub(super) fn correction(&self, node: usize) -> Option<Vec<f64>> {
        let row = self.row(node)?;
        let d = self.middles[0].nrows();
        let of = |i: usize| {
            let terms = row.iter().zip(self.defects);
            terms.map(|(g, p)| (0..d).map(|k| g[(i, k)] * p[k].middle()).sum::<f64>()).sum()
        };
        Some((0..d).map(of).collect())
    }

    /// An upper bound of |K(X) - m| for each component of a node, for boxes with the half widths `radii`.
    pub(super) fn bound(&self, node: usize, radii: &[Vec<f64>]) -> Option<Vec<f64>> {
        let row = self.row(node)?;
        let (count, d) = (row.len(), self.middles[0].nrows());
        let exact: Vec<Vec<Interval>> =
            row.iter().map(|g| (0..d * d).map(|i| Interval::from(g[(i / d, i % d)])).collect()).collect();
        let mut sums = vec![Interval::ZERO; d];
        for i in 0..d {
            for (g, defect) in exact.iter().zip(self.defects) {
                for (k, p) in defect.iter().enumerate() {
                    sums[i] = sums[i] + g[i * d + k] * *p;
                }
            }
            for k in 0..count {
                let (own, before) = (&exact[k], &exact[(k + count - 1) % count]);
                for column in 0..d {
                    // (1 + G P')_k = δ + G_k Φ_k - G_(k-1)
                    let start = if k == node && i == column { Interval::ONE } else { Interval::ZERO };
                    let product = (0..d).fold(start - before[i * d + column], |sum, l| {
                        sum + own[i * d + l] * self.slopes[k].at(l, column)
                    });
                    sums[i] = sums[i] + product * Interval::symmetric(radii[k][column]);
                }
            }
        }
        Some(sums.into_iter().map(Interval::magnitude).collect())
    }
}
