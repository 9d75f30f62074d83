//! Gaussian elimination by blocks.

use crate::numeric::norms::{floating, largest};
use crate::numeric::spread::golden;
use crate::roots::blocks::{Block, Pairs};
use crate::roots::matrix::Matrix;
use faer::MatMut;
use faer::linalg::solvers::{PartialPivLu, Solve};
use std::collections::BTreeMap;
use std::ops::Range;

/// Factors of a matrix in blocks, by Gaussian elimination with pivots inside the diagonal blocks.
///
/// Diagonal blocks that are pairs are eliminated first, and among equals those with the fewest neighbours.
/// The leaves of a chain or a ring then add no blocks, and the cost is linear in their number.
///
/// There is no pivoting between blocks. This is safe if every diagonal block outweighs the blocks beside it
/// and continues to do so during the elimination; inertia and own stiffness of a gear have this effect. A
/// nearly singular diagonal block makes other blocks grow, and [`is_sound`](Elimination::is_sound) returns
/// `false`.
pub(crate) struct Elimination(Vec<PivotStep>);

impl Elimination {
    /// The factors. Error: a row of a diagonal block that is missing or singular to rounding.
    pub(crate) fn new(a: &Matrix) -> Result<Self, usize> {
        let n = a.block_rows();
        let range = |i: usize| a.start(i)..a.start(i) + a.height(i);
        let mut rows: Vec<BTreeMap<usize, Block>> = vec![BTreeMap::new(); n];
        for part in a.parts() {
            rows[part.i].insert(part.j, a.block(part));
        }
        let mut left: Vec<usize> = (0..n).collect();
        let mut steps = Vec::with_capacity(n);
        while !left.is_empty() {
            let cost = |&p: &usize| {
                let dense = matches!(rows[p].get(&p), Some(Block::Dense(_)));
                let below = left.iter().filter(|&&i| rows[i].contains_key(&p)).count();
                (a.last() == Some(p), dense, rows[p].len().max(below))
            };
            let Some(at) = (0..left.len()).min_by_key(|&k| cost(&left[k])) else {
                break;
            };
            let p = left.remove(at);
            let mut row = std::mem::take(&mut rows[p]);
            let divisor = row
                .remove(&p)
                .ok_or(a.start(p))
                .and_then(|d| Divisor::new(d).map_err(|local| a.start(p) + local))?;
            let right: Vec<(usize, Block)> =
                row.into_iter().map(|(j, block)| (j, divisor.divide(block))).collect();
            let below: Vec<(usize, Block)> =
                left.iter().filter_map(|&i| rows[i].remove(&p).map(|block| (i, block))).collect();
            for (i, lower) in &below {
                for (j, upper) in &right {
                    let product = lower.times(upper);
                    let before = rows[*i].remove(j);
                    rows[*i].insert(*j, Block::less(before, product));
                }
            }
            let named =
                |list: Vec<(usize, Block)>| list.into_iter().map(|(i, block)| (range(i), block)).collect();
            steps.push(PivotStep { rows: range(p), divisor, left: named(below), right: named(right) });
        }
        Ok(Elimination(steps))
    }

    /// Whether the solution x of a test system A x = b has a backward error of at most 1e-10:
    /// |A x - b|_i <= 1e-10 (Σ_j |A_ij| max |x_j| + |b_i|) in every row i.
    pub(crate) fn is_sound(&self, a: &Matrix) -> bool {
        let x: Vec<f64> = (0..a.size()).map(|i| 1.5 - golden(i as f64)).collect();
        let b = a.times(&x);
        let mut found = b.clone();
        self.solve(&mut found);
        let again = a.times(&found);
        let mut size = vec![0.0; b.len()];
        a.each(|row, _, value| size[row] += value.abs());
        let most = largest(&found);
        let close =
            |((again, b), size): ((&f64, &f64), &f64)| (again - b).abs() <= SOUND * (size * most + b.abs());
        again.iter().zip(&b).zip(&size).all(close)
    }

    /// x ← A⁻¹ x.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        for step in &self.0 {
            step.divisor.divide_vector(&mut x[step.rows.clone()]);
            for (rows, block) in &step.left {
                let (own, other) = apart(x, &step.rows, rows);
                block.subtract_product(own, other);
            }
        }
        for step in self.0.iter().rev() {
            for (columns, block) in &step.right {
                let (other, own) = apart(x, columns, &step.rows);
                block.subtract_product(other, own);
            }
        }
    }
}

/// Factors of a diagonal block.
pub(crate) enum Divisor {
    Dense(PartialPivLu<f64>),
    Pairs(Pairs),
}

impl Divisor {
    fn new(block: Block) -> Result<Self, usize> {
        match block {
            Block::Pairs(pairs) => pairs.inverse().map(Divisor::Pairs),
            Block::Dense(a) => {
                let lu = a.partial_piv_lu();
                let u = lu.U();
                match floating(a.nrows(), |i, j| u[(i, j)]) {
                    Some(row) => Err(row),
                    None => Ok(Divisor::Dense(lu)),
                }
            }
        }
    }

    fn divide(&self, block: Block) -> Block {
        match (self, block) {
            (Divisor::Pairs(inverse), block) => Block::Pairs(inverse.clone()).times(&block),
            (Divisor::Dense(lu), block) => Block::Dense(lu.solve(block.into_dense())),
        }
    }

    fn divide_vector(&self, x: &mut [f64]) {
        let x = MatMut::from_column_major_slice_mut(x, x.len(), 1);
        match self {
            Divisor::Pairs(inverse) => inverse.on_rows(x),
            Divisor::Dense(lu) => lu.solve_in_place(x),
        }
    }
}

/// One eliminated block row.
pub(crate) struct PivotStep {
    rows: Range<usize>,
    divisor: Divisor,
    /// Blocks below the diagonal block, with their rows.
    left: Vec<(Range<usize>, Block)>,
    /// Blocks to the right of the diagonal block, divided by it, with their columns.
    right: Vec<(Range<usize>, Block)>,
}

/// Maximum backward error of factors that are used `[1]`.
pub(crate) const SOUND: f64 = 1e-10;

/// Splits the vector `x`: the entries of `read`, and those of `write` to be changed. The ranges must not
/// overlap; either may come first.
pub(crate) fn apart<'a>(
    x: &'a mut [f64],
    read: &Range<usize>,
    write: &Range<usize>,
) -> (&'a [f64], &'a mut [f64]) {
    if read.start < write.start {
        let (low, high) = x.split_at_mut(write.start);
        (&low[read.clone()], &mut high[..write.len()])
    } else {
        let (low, high) = x.split_at_mut(read.start);
        (&high[..read.len()], &mut low[write.clone()])
    }
}
