//! Elimination by blocks.

use crate::roots::factors::floating;
use crate::roots::matrix::Matrix;
use crate::roots::norms::largest;
use faer::Mat;
use faer::MatMut;
use faer::MatRef;
use faer::linalg::solvers::PartialPivLu;
use faer::linalg::solvers::Solve;
use std::collections::BTreeMap;
use std::ops::Range;

/// Pairs of rows along the diagonal: what a constant coefficient does to cosines and sines. An odd width begins with a single row.
#[derive(Clone, Debug)]
pub(crate) struct Pairs {
    width: usize,
    /// [a, b; c, d] row by row.
    list: Vec<[f64; 4]>,
}

impl Pairs {
    /// The rows of the pair that a column belongs to.
    #[inline]
    pub(crate) fn rows(height: usize, column: usize) -> Range<usize> {
        let odd = height % 2;
        if column < odd {
            return 0..1;
        }
        let first = odd + (column - odd) / 2 * 2;
        first..first + 2
    }

    /// From two entries for each column.
    pub(crate) fn new(values: &[f64], width: usize) -> Self {
        let odd = width % 2;
        let mut list = Vec::with_capacity(width.div_ceil(2));
        if odd == 1 {
            list.push([values[0], 0.0, 0.0, 1.0]);
        }
        list.extend(values[2 * odd..].chunks_exact(4).map(|v| [v[0], v[2], v[1], v[3]]));
        Pairs { width, list }
    }

    /// Every pair with its rows.
    fn each(&self) -> impl Iterator<Item = (Range<usize>, &[f64; 4])> {
        let odd = self.width % 2;
        self.list.iter().enumerate().map(move |(p, m)| match p {
            0 if odd == 1 => (0..1, m),
            _ => (2 * p - odd..2 * p - odd + 2, m),
        })
    }

    /// The inverse, or the row that nothing holds.
    fn inverse(&self) -> Result<Self, usize> {
        let mut list = Vec::with_capacity(self.list.len());
        for (rows, &[a, b, c, d]) in self.each() {
            let determinant = a * d - b * c;
            let size = (a * d).abs().max((b * c).abs());
            if determinant.is_nan() || determinant.abs() <= 4.0 * f64::EPSILON * size || size == 0.0 {
                return Err(rows.start);
            }
            list.push([d / determinant, -b / determinant, -c / determinant, a / determinant]);
        }
        Ok(Pairs { list, ..*self })
    }

    fn times_pairs(&self, other: &Self) -> Self {
        let product = |(x, y): (&[f64; 4], &[f64; 4])| {
            [
                x[0] * y[0] + x[1] * y[2],
                x[0] * y[1] + x[1] * y[3],
                x[2] * y[0] + x[3] * y[2],
                x[2] * y[1] + x[3] * y[3],
            ]
        };
        Pairs { width: self.width, list: self.list.iter().zip(&other.list).map(product).collect() }
    }

    /// From the left, on every column.
    fn on_rows(&self, mut x: MatMut<'_, f64>) {
        for j in 0..x.ncols() {
            for (rows, &[a, b, c, d]) in self.each() {
                let (i, u) = (rows.start, x[(rows.start, j)]);
                if rows.len() == 1 {
                    x[(i, j)] = a * u;
                } else {
                    let v = x[(i + 1, j)];
                    (x[(i, j)], x[(i + 1, j)]) = (a * u + b * v, c * u + d * v);
                }
            }
        }
    }

    /// From the right, on every row.
    fn on_columns(&self, x: &mut Mat<f64>) {
        for (columns, &[a, b, c, d]) in self.each() {
            let j = columns.start;
            for i in 0..x.nrows() {
                let u = x[(i, j)];
                if columns.len() == 1 {
                    x[(i, j)] = a * u;
                } else {
                    let v = x[(i, j + 1)];
                    (x[(i, j)], x[(i, j + 1)]) = (a * u + c * v, b * u + d * v);
                }
            }
        }
    }
}

/// A block of any kind.
#[derive(Clone, Debug)]
pub(crate) enum Block {
    Dense(Mat<f64>),
    Pairs(Pairs),
}

impl Block {
    pub(crate) fn dense(values: &[f64], height: usize, width: usize) -> Self {
        Block::Dense(MatRef::from_column_major_slice(values, height, width).to_owned())
    }

    fn times(&self, other: &Block) -> Block {
        match (self, other) {
            (Block::Dense(a), Block::Dense(b)) => Block::Dense(a * b),
            (Block::Pairs(a), Block::Pairs(b)) => Block::Pairs(a.times_pairs(b)),
            (Block::Pairs(a), Block::Dense(b)) => {
                let mut product = b.clone();
                a.on_rows(product.as_mut());
                Block::Dense(product)
            }
            (Block::Dense(a), Block::Pairs(b)) => {
                let mut product = a.clone();
                b.on_columns(&mut product);
                Block::Dense(product)
            }
        }
    }

    fn into_dense(self) -> Mat<f64> {
        match self {
            Block::Dense(a) => a,
            Block::Pairs(pairs) => {
                let mut a = Mat::identity(pairs.width, pairs.width);
                pairs.on_rows(a.as_mut());
                a
            }
        }
    }

    /// x - y, where no block yet means zero.
    fn less(x: Option<Block>, y: Block) -> Block {
        match (x, y) {
            (None, Block::Dense(y)) => Block::Dense(-&y),
            (None, Block::Pairs(y)) => {
                Block::Pairs(Pairs { width: y.width, list: y.list.iter().map(|m| m.map(|x| -x)).collect() })
            }
            (Some(Block::Pairs(x)), Block::Pairs(y)) => {
                let difference = |(x, y): (&[f64; 4], &[f64; 4])| std::array::from_fn(|k| x[k] - y[k]);
                Block::Pairs(Pairs {
                    width: x.width,
                    list: x.list.iter().zip(&y.list).map(difference).collect(),
                })
            }
            (Some(x), y) => Block::Dense(&x.into_dense() - &y.into_dense()),
        }
    }

    /// y -= A x.
    fn subtract_product(&self, x: &[f64], y: &mut [f64]) {
        match self {
            Block::Dense(a) => {
                for (j, x) in x.iter().enumerate() {
                    y.iter_mut().zip(a.col(j).iter()).for_each(|(y, a)| *y -= a * x);
                }
            }
            Block::Pairs(pairs) => {
                for (rows, &[a, b, c, d]) in pairs.each() {
                    let i = rows.start;
                    y[i] -= a * x[i];
                    if rows.len() == 2 {
                        y[i] -= b * x[i + 1];
                        y[i + 1] -= c * x[i] + d * x[i + 1];
                    }
                }
            }
        }
    }
}

/// A diagonal block, ready to divide by.
enum Divisor {
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
struct Step {
    rows: Range<usize>,
    divisor: Divisor,
    /// Blocks below the diagonal one.
    left: Vec<(Range<usize>, Block)>,
    /// Blocks beside it, divided.
    right: Vec<(Range<usize>, Block)>,
}

/// Factors of a matrix in blocks: Gaussian elimination, cheap blocks and those with few neighbours first, pivots inside diagonal blocks.
/// Leaves that hang on a chain or a ring fill nothing in, so that the cost is linear in their number.
///
/// Without pivoting between blocks this is safe where every diagonal block outweighs what stands beside it, as inertia and own stiffness of
/// a gear do, and stays so during elimination. A block near to singular makes others grow: [`is_sound`](Elimination::is_sound) tells.
pub(crate) struct Elimination(Vec<Step>);

impl Elimination {
    /// The factors, or the row that nothing holds.
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
            steps.push(Step { rows: range(p), divisor, left: named(below), right: named(right) });
        }
        Ok(Elimination(steps))
    }

    /// Whether a system of known solution is solved to a backward error of 1e-10: |A x - b| against |A| |x| + |b|, row by row.
    pub(crate) fn is_sound(&self, a: &Matrix) -> bool {
        let x: Vec<f64> = (0..a.size()).map(|i| 1.5 - (0.618_033_988_749_894_9 * i as f64).fract()).collect();
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

    /// x becomes A⁻¹ x.
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

/// Largest backward error of factors that are used.
const SOUND: f64 = 1e-10;

/// Two stretches of x that do not overlap: one to read, one to write.
fn apart<'a>(x: &'a mut [f64], read: &Range<usize>, write: &Range<usize>) -> (&'a [f64], &'a mut [f64]) {
    if read.start < write.start {
        let (low, high) = x.split_at_mut(write.start);
        (&low[read.clone()], &mut high[..write.len()])
    } else {
        let (low, high) = x.split_at_mut(read.start);
        (&high[..read.len()], &mut low[write.clone()])
    }
}
