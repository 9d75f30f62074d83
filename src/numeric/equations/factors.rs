//! Factors of sparse matrices.

use crate::numeric::equations::entries::Entries;
use faer::Mat;
use faer::linalg::solvers::{PartialPivLu, Solve};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Number of rows up to which a matrix counts as full.
const SMALL: usize = 127;

/// Number of unknowns that each unknown is coupled to, from which what is left of a larger matrix counts as
/// full.
const FULL: usize = 48;

/// A pivot below this share of the diagonal of its row counts as 0.
const ZERO: f64 = 1e-15;

/// Factors L U of a square matrix. Unknowns that are coupled to few others are eliminated first, with pivots
/// on the diagonal; what is then left is factorised as a full matrix with partial pivoting. Without pivoting
/// the elimination is stable for M⁻¹ K with a diagonal inertia M and a symmetric positive K. Source: Golub
/// and Van Loan, Matrix Computations, Sect. 11.1.
pub(crate) struct Factors {
    pivots: Vec<Pivot>,
    /// The unknowns of the full rest, and its factors.
    rest: Option<(Vec<usize>, PartialPivLu<f64>)>,
}

/// An unknown that is eliminated.
struct Pivot {
    at: usize,
    value: f64,
    /// Column of L: rows and factors.
    left: Vec<(usize, f64)>,
    /// Row of U without its diagonal.
    right: Vec<(usize, f64)>,
}

impl Factors {
    /// The factors of a matrix with `shift` added to its diagonal. `None`: a pivot is 0.
    pub(crate) fn of(entries: &Entries, shift: &[f64]) -> Option<Self> {
        // Rows with a symmetric pattern: row i has an entry j if row j has an entry i.
        let mut rows: Vec<BTreeMap<usize, f64>> = shift.iter().map(|_| BTreeMap::new()).collect();
        for &(i, j, x) in &entries.list {
            *rows[i].entry(j).or_default() += x;
            rows[j].entry(i).or_default();
        }
        shift.iter().enumerate().for_each(|(i, shift)| *rows[i].entry(i).or_default() += shift);
        let least: Vec<f64> = (0..rows.len()).map(|i| ZERO * rows[i][&i].abs()).collect();
        let mut left_over: BinaryHeap<_> = (0..rows.len()).map(|i| Reverse((rows[i].len(), i))).collect();
        let (mut pivots, mut is_left) = (Vec::with_capacity(rows.len()), vec![true; rows.len()]);
        while let Some(Reverse((degree, at))) = left_over.pop() {
            if !is_left[at] {
                continue;
            }
            if degree != rows[at].len() {
                left_over.push(Reverse((rows[at].len(), at)));
                continue;
            }
            if degree > FULL || rows.len() <= SMALL {
                break;
            }
            is_left[at] = false;
            let mut row = std::mem::take(&mut rows[at]);
            let value = row.remove(&at)?;
            if !(value.is_finite() && value.abs() > least[at]) {
                return None;
            }
            let right: Vec<(usize, f64)> = row.into_iter().collect();
            let mut left = Vec::with_capacity(right.len());
            for &(i, _) in &right {
                let factor = rows[i].remove(&at).unwrap_or_default() / value;
                left.push((i, factor));
                right.iter().for_each(|(j, x)| *rows[i].entry(*j).or_default() -= factor * x);
            }
            pivots.push(Pivot { at, value, left, right });
        }
        let unknowns: Vec<usize> = (0..rows.len()).filter(|&i| is_left[i]).collect();
        let rest = (!unknowns.is_empty()).then(|| {
            let entry = |i: usize, j: usize| rows[unknowns[i]].get(&unknowns[j]).copied().unwrap_or_default();
            let full = Mat::from_fn(unknowns.len(), unknowns.len(), entry);
            (unknowns.clone(), full.partial_piv_lu())
        });
        Some(Factors { pivots, rest })
    }

    /// Replaces the right side by the solution.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        for Pivot { at, left, .. } in &self.pivots {
            let known = x[*at];
            left.iter().for_each(|(i, factor)| x[*i] -= factor * known);
        }
        if let Some((unknowns, factors)) = &self.rest {
            let mut right = Mat::from_fn(unknowns.len(), 1, |i, _| x[unknowns[i]]);
            factors.solve_in_place(&mut right);
            unknowns.iter().enumerate().for_each(|(i, &at)| x[at] = right[(i, 0)]);
        }
        for Pivot { at, value, right, .. } in self.pivots.iter().rev() {
            let known: f64 = right.iter().map(|(j, u)| u * x[*j]).sum();
            x[*at] = (x[*at] - known) / value;
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::numeric::equations::entries::Entries;
    use crate::numeric::equations::factors::Factors;
    use crate::numeric::spread::golden;

    /// M⁻¹ K of springs between random pairs of coordinates, from a chain to a full matrix, with inertias
    /// over four orders: A x - b is rounding.
    #[test]
    fn factors_solve() {
        for (n, springs) in [(1, 0), (20, 15), (200, 0), (200, 60), (300, 4000)] {
            let random = |k: usize| golden((k + 7 * n) as f64);
            let node = |k: usize| (random(k) * n as f64) as usize;
            let inertia: Vec<f64> = (0..n).map(|i| 10f64.powf(4.0 * random(i) - 2.0)).collect();
            let chain = (1..n).map(|i| (i - 1, i));
            let mut list: Vec<(usize, usize, f64)> = (0..n).map(|i| (i, i, 0.1 / inertia[i])).collect();
            for (k, (i, j)) in chain.chain((0..springs).map(|k| (node(3 * k), node(3 * k + 1)))).enumerate() {
                let stiffness = 0.5 + random(5 * k);
                for (a, b) in [(i, j), (j, i)] {
                    list.push((a, a, stiffness / inertia[a]));
                    list.push((a, b, -stiffness / inertia[a]));
                }
            }
            let (a, shift) = (Entries { n, list }, vec![1e-3; n]);
            let factors = Factors::of(&a, &shift).unwrap();
            let right: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
            let mut x = right.clone();
            factors.solve(&mut x);
            let mut left: Vec<f64> = right.iter().zip(&x).map(|(b, x)| b - 1e-3 * x).collect();
            let mut size = vec![0.0; n];
            for &(i, j, value) in &a.list {
                left[i] -= value * x[j];
                size[i] += (value * x[j]).abs();
            }
            for (i, (left, size)) in left.iter().zip(&size).enumerate() {
                assert!(left.abs() <= 1e-12 * size, "{n} {springs}, row {i}: {left:e} of {size:e}");
            }
        }
    }

    #[test]
    fn a_matrix_without_a_pivot_has_no_factors() {
        let n = 200;
        let list = (0..n).map(|i| (i, i, if i == 100 { 0.0 } else { 1.0 })).collect();
        assert!(Factors::of(&Entries { n, list }, &vec![0.0; n]).is_none());
    }
}
