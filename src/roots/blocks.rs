//! Blocks of a matrix: dense ones, and pairs of rows along the diagonal.

use faer::{Mat, MatMut, MatRef};
use std::ops::Range;

/// A block of 2 x 2 matrices along the diagonal: the product of a constant coefficient with the cosine and
/// sine of every order. A block of odd width begins with a single row, that of the mean.
#[derive(Clone, Debug)]
pub(crate) struct Pairs {
    width: usize,
    /// Entries a, b, c, d of the matrices [a, b; c, d]; a, 0, 0, 1 for the single row.
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

    /// Reads two entries per column. Of a single row the second entry is not used.
    pub(crate) fn new(values: &[f64], width: usize) -> Self {
        let odd = width % 2;
        let mut list = Vec::with_capacity(width.div_ceil(2));
        if odd == 1 {
            list.push([values[0], 0.0, 0.0, 1.0]);
        }
        list.extend(values[2 * odd..].chunks_exact(4).map(|v| [v[0], v[2], v[1], v[3]]));
        Pairs { width, list }
    }

    /// All pairs with their rows.
    pub(crate) fn each(&self) -> impl Iterator<Item = (Range<usize>, &[f64; 4])> {
        let odd = self.width % 2;
        self.list.iter().enumerate().map(move |(p, m)| match p {
            0 if odd == 1 => (0..1, m),
            _ => (2 * p - odd..2 * p - odd + 2, m),
        })
    }

    /// The inverse. Error: the first row of a pair that is singular to rounding.
    pub(crate) fn inverse(&self) -> Result<Self, usize> {
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

    pub(crate) fn times_pairs(&self, other: &Self) -> Self {
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

    /// x ← A x, with A this block.
    pub(crate) fn on_rows(&self, mut x: MatMut<'_, f64>) {
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

    /// x ← x A, with A this block.
    pub(crate) fn on_columns(&self, x: &mut Mat<f64>) {
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

/// A block of a matrix.
#[derive(Clone, Debug)]
pub(crate) enum Block {
    Dense(Mat<f64>),
    Pairs(Pairs),
}

impl Block {
    pub(crate) fn dense(values: &[f64], height: usize, width: usize) -> Self {
        Block::Dense(MatRef::from_column_major_slice(values, height, width).to_owned())
    }

    pub(crate) fn times(&self, other: &Block) -> Block {
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

    pub(crate) fn into_dense(self) -> Mat<f64> {
        match self {
            Block::Dense(a) => a,
            Block::Pairs(pairs) => {
                let mut a = Mat::identity(pairs.width, pairs.width);
                pairs.on_rows(a.as_mut());
                a
            }
        }
    }

    /// x - y; `None` stands for zero.
    pub(crate) fn less(x: Option<Block>, y: Block) -> Block {
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

    /// y ← y - A x.
    pub(crate) fn subtract_product(&self, x: &[f64], y: &mut [f64]) {
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
