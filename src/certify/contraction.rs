//! The Newton operator on the cyclic system of all legs.

use crate::certify::square::Square;
use crate::interval::number::Interval;
use nalgebra::DMatrix;

/// Bounds of the Newton operator for the equations F_j(x_j) - x_(j+1) = 0 around a closed chain of boxes.
///
/// K(X) - m = G P(m) + (1 + G P'(X)) (X - m), with the defects P_j(m) = F_j(m_j) - m_(j+1) and an approximate
/// inverse G of -P'. If K(X) lies inside X, there is exactly one solution in X.   Source: Krawczyk 1969;
/// Rump, Acta Numerica 19, 287 (2010), Sect. 13.
pub(crate) struct Newton<'a> {
    defects: &'a [Vec<Interval>],
    slopes: &'a [Square],
    /// Slopes A in plain numbers, by rows.
    middles: Vec<Vec<f64>>,
    /// Number of components of a node.
    d: usize,
}

/// What of a defect a bound contains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Defect {
    /// All of it.
    Whole,
    /// Its width alone, as if the middle were 0.
    Width,
}

impl<'a> Newton<'a> {
    pub(crate) fn new(defects: &'a [Vec<Interval>], slopes: &'a [Square]) -> Self {
        let middles = slopes.iter().map(|slope| slope.entries.iter().map(|x| x.middle()).collect()).collect();
        Newton { defects, slopes, middles, d: slopes.first().map_or(0, |slope| slope.size) }
    }

    /// The derivative of the state one turn later with respect to that at each node, in plain numbers.
    fn turns(&self) -> Vec<Vec<f64>> {
        let (count, d) = (self.middles.len(), self.d);
        let unit: Vec<f64> = (0..d * d).map(|i| if i / d == i % d { 1.0 } else { 0.0 }).collect();
        // From the first node to each, then from each to the end.
        let mut turns = vec![unit.clone()];
        for j in 0..count - 1 {
            let mut next = vec![0.0; d * d];
            times(&self.middles[j], &turns[j], d, &mut next);
            turns.push(next);
        }
        let (mut rest, mut next) = (unit.clone(), unit);
        for j in (0..count).rev() {
            times(&rest, &self.middles[j], d, &mut next);
            std::mem::swap(&mut rest, &mut next);
            times(&turns[j].clone(), &rest, d, &mut turns[j]);
        }
        turns
    }
    /// The derivative of the motion over one turn from the first node, in plain numbers.
    pub(crate) fn turn(&self) -> DMatrix<f64> {
        let d = self.d;
        let mut turn = DMatrix::identity(d, d);
        for middle in &self.middles {
            turn = DMatrix::from_row_slice(d, d, middle) * turn;
        }
        turn
    }
    /// (1 - turn)⁻¹ by rows; `None` if a turn has the multiplier 1.
    fn closing(&self, turn: &[f64]) -> Option<Vec<f64>> {
        let turn = DMatrix::from_row_slice(self.d, self.d, turn);
        let inverse = (DMatrix::identity(self.d, self.d) - turn).try_inverse()?;
        inverse.iter().all(|x| x.is_finite()).then(|| inverse.transpose().as_slice().to_vec())
    }

    /// The Newton corrections of all nodes, in plain numbers.
    pub(crate) fn corrections(&self) -> Option<Vec<Vec<f64>>> {
        let (count, d) = (self.middles.len(), self.d);
        let closing = self.closing(self.turn().transpose().as_slice())?;
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

    /// Upper bounds of |K(X) - m| for each component of each node, for boxes with the half widths `radii`;
    /// the number of a node without a bound as an error.
    ///
    /// G has the block G_(i,j) in the row of node i and the column of leg j, with G_(i,j-1) = G_(i,j) A_j up
    /// to rounding. A row therefore sums |G_(i,j)| (|P_j(m)| + |F_j' - A_j| |X_j - m_j|), and the block of
    /// its own node adds what does not close.
    pub(crate) fn bounds(&self, radii: &[Vec<f64>], defect: Defect) -> Result<Vec<Vec<f64>>, usize> {
        let (count, d) = (self.middles.len(), self.d);
        let spreads: Vec<Vec<f64>> = (0..count).map(|j| self.spread(j, &radii[j], defect)).collect();
        // Sums of positive terms in plain numbers, each with some `count` d roundings, and products that are
        // rounded to 0.
        let rounding = 1.0 + 4.0 * f64::EPSILON * (count * d + 8) as f64;
        let largest = radii.iter().flatten().fold(1.0, |most: f64, r| most.max(*r));
        let mut before = vec![0.0; d * d];
        let row = |(node, turn): (usize, &Vec<f64>)| {
            let first = self.closing(turn).ok_or(node)?;
            let (mut own, mut sums) = (first.clone(), vec![0.0; d]);
            for back in 1..=count {
                let j = (node + count - back) % count;
                for (i, sum) in sums.iter_mut().enumerate() {
                    *sum += (0..d).map(|l| own[i * d + l].abs() * spreads[j][l]).sum::<f64>();
                }
                if back < count {
                    times(&own, &self.middles[j], d, &mut before);
                    std::mem::swap(&mut own, &mut before);
                }
            }
            // |1 + G_i A_i - G_(i-1)| with the first block as G_(i-1).
            let (middles, share) = (&self.middles[node], f64::EPSILON * (d + 4) as f64);
            for (place, first) in first.iter().enumerate() {
                let (i, k) = (place / d, place % d);
                let unit = if i == k { 1.0 } else { 0.0 };
                let terms = || (0..d).map(|l| own[i * d + l] * middles[l * d + k]);
                let size = unit + first.abs() + terms().map(f64::abs).sum::<f64>();
                sums[i] += ((unit + terms().sum::<f64>() - first).abs() + share * size) * radii[node][k];
            }
            Ok(sums.into_iter().map(|sum| sum * rounding + f64::MIN_POSITIVE * largest).collect())
        };
        self.turns().iter().enumerate().map(row).collect()
    }

    /// Upper bounds of |P_j(m)| + (|F_j' - A_j| + ε d |A_j|) |X_j - m_j|, where ε d |A_j| bounds the rounding
    /// of a product with A_j.
    fn spread(&self, j: usize, radii: &[f64], defect: Defect) -> Vec<f64> {
        let d = self.d;
        let share = Interval::from(f64::EPSILON * d as f64);
        let row = |i: usize| {
            let of = self.defects[j][i];
            let start = match defect {
                Defect::Whole => of.magnitude(),
                Defect::Width => 0.5 * of.width(),
            };
            let sum = (0..d).fold(Interval::from(start), |sum, k| {
                let middle = Interval::from(self.middles[j][i * d + k]);
                let beside = (self.slopes[j].at(i, k) - middle).magnitude();
                let whole = Interval::from(beside) + share * middle.magnitude();
                sum + whole * radii[k]
            });
            sum.high()
        };
        (0..d).map(row).collect()
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
