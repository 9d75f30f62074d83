//! The Newton operator on the cyclic system of all legs.

use crate::certify::square::Square;
use crate::interval::number::Interval;
use nalgebra::DMatrix;

/// Bounds of the Newton operator for the equations F_j(x_j) - x_(j+1) = 0 around a closed chain of boxes.
///
/// K(X) - m = G P(m) + (1 + G P'(X)) (X - m), with the defects P_j(m) = F_j(m_j) - m_(j+1) and an approximate
/// inverse G of -P'. If K(X) lies inside X, there is exactly one solution in X.   Source: Krawczyk 1969;
/// Rump, Acta Numerica 19, 287 (2010), Sect. 13.
pub(super) struct Newton<'a> {
    defects: &'a [Vec<Interval>],
    slopes: &'a [Square],
    /// Slopes in plain numbers, by rows.
    middles: Vec<Vec<f64>>,
    /// Number of components of a node.
    d: usize,
}

impl<'a> Newton<'a> {
    pub(super) fn new(defects: &'a [Vec<Interval>], slopes: &'a [Square]) -> Self {
        let middles = slopes.iter().map(|slope| slope.entries.iter().map(|x| x.middle()).collect()).collect();
        Newton { defects, slopes, middles, d: slopes.first().map_or(0, |slope| slope.size) }
    }

    /// The derivative of the motion over one turn from a node, in plain numbers.
    pub(super) fn turn_from(&self, node: usize) -> DMatrix<f64> {
        let (count, d) = (self.middles.len(), self.d);
        let mut turn: Vec<f64> = (0..d * d).map(|i| if i / d == i % d { 1.0 } else { 0.0 }).collect();
        let mut product = vec![0.0; d * d];
        for k in 0..count {
            times(&self.middles[(node + k) % count], &turn, d, &mut product);
            std::mem::swap(&mut turn, &mut product);
        }
        DMatrix::from_row_slice(d, d, &turn)
    }
    /// (1 - turn)⁻¹ from a node, by rows; `None` if a turn has the multiplier 1.
    fn closing(&self, node: usize) -> Option<Vec<f64>> {
        let inverse = (DMatrix::identity(self.d, self.d) - self.turn_from(node)).try_inverse()?;
        inverse.iter().all(|x| x.is_finite()).then(|| inverse.transpose().as_slice().to_vec())
    }

    /// The Newton corrections of all nodes, in plain numbers.
    pub(super) fn corrections(&self) -> Option<Vec<Vec<f64>>> {
        let (count, d) = (self.middles.len(), self.d);
        let closing = self.closing(0)?;
        let forward = |j: usize, x: &[f64]| -> Vec<f64> {
            let row = |i: usize| (0..d).map(|k| self.middles[j][i * d + k] * x[k]).sum::<f64>();
            (0..d).map(|i| row(i) + self.defects[j][i].middle()).collect()
        };
        let around = (0..count).fold(vec![0.0; d], |x, j| forward(j, &x));
        let first = (0..d).map(|i| (0..d).map(|k| closing[i * d + k] * around[k]).sum()).collect();
        let mut all: Vec<Vec<f64>> = vec![first];
        for j in 0..count - 1 {
            all.push(forward(j, &all[j]));
        }
        Some(all)
    }

    /// An upper bound of |K(X) - m| for each component of a node, for boxes with the half widths `radii`.
    /// Blocks G_j of the row of the node follow from one another: G_(j-1) = G_j A_j with the slopes A in
    /// plain numbers.
    pub(super) fn bound(&self, node: usize, radii: &[Vec<f64>]) -> Option<Vec<f64>> {
        let (count, d) = (self.middles.len(), self.d);
        let mut own = self.closing(node)?;
        // The block before the first one closes the chain.
        let mut before = own.clone();
        let mut sums = vec![Interval::ZERO; d];
        let mut next = vec![0.0; d * d];
        let first = own.clone();
        for back in 1..=count {
            let j = (node + count - back) % count;
            match back == count {
                // G before the node itself is the first block.
                true => next.copy_from_slice(&first),
                false => times(&own, &self.middles[j], d, &mut next),
            }
            std::mem::swap(&mut before, &mut next);
            for (i, sum) in sums.iter_mut().enumerate() {
                for (k, defect) in self.defects[j].iter().enumerate() {
                    *sum = *sum + *defect * own[i * d + k];
                }
                for column in 0..d {
                    // (1 + G P')_j = δ + G_j Φ_j - G_(j-1)
                    let unit = if j == node && i == column { Interval::ONE } else { Interval::ZERO };
                    let start = unit - Interval::from(before[i * d + column]);
                    let entry =
                        (0..d).fold(start, |sum, l| sum + self.slopes[j].at(l, column) * own[i * d + l]);
                    *sum = *sum
                        + Interval::symmetric((Interval::from(entry.magnitude()) * radii[j][column]).high());
                }
            }
            own.copy_from_slice(&before);
        }
        Some(sums.into_iter().map(Interval::magnitude).collect())
    }
}

/// The product of two square matrices by rows.
fn times(a: &[f64], b: &[f64], d: usize, out: &mut [f64]) {
    for i in 0..d {
        for j in 0..d {
            out[i * d + j] = (0..d).map(|k| a[i * d + k] * b[k * d + j]).sum();
        }
    }
}
