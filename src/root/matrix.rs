//! Jacobians, dense or sparse, and their factors.

use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{MatMut, MatRef};
use nalgebra::{DMatrix, DVectorViewMut, Dyn};

/// A square matrix, filled column by column: all rows of a dense one, the rows of its pattern of a sparse one.
///
/// ```
/// use gear_dynamics::Matrix;
/// let mut sparse = Matrix::sparse(&[vec![0], vec![0, 1]])?;
/// sparse.column_mut(1).copy_from_slice(&[2.0, 5.0]);
/// assert_eq!(sparse.rows(1), Some(&[0, 1][..]));
/// assert_eq!(sparse.times(&[1.0, 1.0]), [2.0, 5.0]);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Matrix {
    size: usize,
    values: Vec<f64>,
    pattern: Option<Pattern>,
}

/// Where a sparse matrix has entries, with the order of elimination that suits it.
#[derive(Clone, Debug)]
struct Pattern {
    columns: SymbolicSparseColMat<usize>,
    elimination: SymbolicLu<usize>,
}

impl Matrix {
    /// A dense matrix of zeros.
    pub fn dense(size: usize) -> Self {
        Matrix { size, values: vec![0.0; size * size], pattern: None }
    }

    /// A sparse matrix of zeros; `rows[j]` lists the rows of column j in increasing order.
    ///
    /// # Errors
    /// A row outside the matrix, or out of order.
    pub fn sparse(rows: &[Vec<usize>]) -> Result<Self, crate::ParameterError> {
        let size = rows.len();
        for (j, column) in rows.iter().enumerate() {
            let out_of_order = column.windows(2).find(|w| w[0] >= w[1]).map(|w| w[1]);
            if let Some(row) = out_of_order.or_else(|| column.iter().copied().find(|&i| i >= size)) {
                let allowed = "increasing rows inside the matrix";
                return Err(crate::ParameterError::OutOfRange { name: format!("row of column {j}"), value: row as f64, allowed });
            }
        }
        let mut starts = vec![0];
        for column in rows {
            starts.push(starts[starts.len() - 1] + column.len());
        }
        let entries = rows.concat();
        let values = vec![0.0; entries.len()];
        let columns = SymbolicSparseColMat::new_checked(size, size, starts, None, entries);
        let elimination = SymbolicLu::try_new(columns.as_ref()).map_err(|_| crate::ParameterError::TooFew {
            name: "memory for the sparse pattern".into(),
            value: size,
            least: size,
        })?;
        Ok(Matrix { size, values, pattern: Some(Pattern { columns, elimination }) })
    }

    /// Rows, equal to columns.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The rows that column j stores; `None`: all.
    pub fn rows(&self, j: usize) -> Option<&[usize]> {
        self.pattern.as_ref().map(|p| &p.columns.row_idx()[p.columns.col_range(j)])
    }

    /// The stored entries of column j.
    pub fn column(&self, j: usize) -> &[f64] {
        &self.values[self.range(j)]
    }

    /// The stored entries of column j, to be written.
    pub fn column_mut(&mut self, j: usize) -> &mut [f64] {
        let range = self.range(j);
        &mut self.values[range]
    }

    #[inline]
    fn range(&self, j: usize) -> std::ops::Range<usize> {
        match &self.pattern {
            None => j * self.size..(j + 1) * self.size,
            Some(p) => p.columns.col_range(j),
        }
    }

    /// A x.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; self.size];
        for (j, x) in x.iter().enumerate() {
            match self.rows(j) {
                None => y.iter_mut().zip(self.column(j)).for_each(|(y, a)| *y += a * x),
                Some(rows) => rows.iter().zip(self.column(j)).for_each(|(&i, a)| y[i] += a * x),
            }
        }
        y
    }
}

/// LU factors of a [`Matrix`].
pub(crate) enum Factors {
    Small(nalgebra::LU<f64, Dyn, Dyn>),
    Dense(PartialPivLu<f64>),
    Sparse(Lu<usize, f64>),
}

/// The unknown that the equations leave free.
pub(crate) struct Floating(pub(crate) usize);

/// Up to this size plain elimination beats blocks.
const SMALL: usize = 40;

impl Factors {
    pub(crate) fn new(a: &Matrix) -> Result<Self, Floating> {
        if let Some(p) = &a.pattern {
            let matrix = SparseColMatRef::new(p.columns.as_ref(), &a.values[..]);
            return Lu::try_new_with_symbolic(p.elimination.clone(), matrix).map(Factors::Sparse).map_err(|_| Floating(0));
        }
        if a.size <= SMALL {
            let lu = nalgebra::LU::new(DMatrix::from_column_slice(a.size, a.size, &a.values));
            let u = lu.lu_internal();
            return match floating(a.size, |i, j| u[(i, j)]) {
                Some(unknown) => Err(Floating(unknown)),
                None => Ok(Factors::Small(lu)),
            };
        }
        let lu = MatRef::from_column_major_slice(&a.values, a.size, a.size).partial_piv_lu();
        let u = lu.U();
        match floating(a.size, |i, j| u[(i, j)]) {
            Some(unknown) => Err(Floating(unknown)),
            None => Ok(Factors::Dense(lu)),
        }
    }

    /// x becomes A⁻¹ x.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        let n = x.len();
        match self {
            Factors::Small(lu) => {
                lu.solve_mut(&mut DVectorViewMut::from_slice(x, n));
            }
            Factors::Dense(lu) => lu.solve_in_place(MatMut::from_column_major_slice_mut(x, n, 1)),
            Factors::Sparse(lu) => lu.solve_in_place(MatMut::from_column_major_slice_mut(x, n, 1)),
        }
    }
}

/// If U is singular to rounding, the largest entry of its null vector.
fn floating(n: usize, u: impl Fn(usize, usize) -> f64) -> Option<usize> {
    let largest = (0..n).fold(0.0, |m: f64, i| m.max(u(i, i).abs()));
    let column = (0..n).find(|&i| u(i, i).abs() <= n as f64 * f64::EPSILON * largest || u(i, i).is_nan())?;
    let mut null = vec![0.0; column + 1];
    null[column] = 1.0;
    for i in (0..column).rev() {
        let sum: f64 = (i + 1..=column).map(|j| u(i, j) * null[j]).sum();
        null[i] = -sum / u(i, i);
    }
    (0..=column).max_by(|&a, &b| null[a].abs().total_cmp(&null[b].abs()))
}

impl From<&Matrix> for DMatrix<f64> {
    /// All entries, the zeros of a sparse matrix included.
    fn from(a: &Matrix) -> Self {
        let mut full = DMatrix::zeros(a.size, a.size);
        for j in 0..a.size {
            match a.rows(j) {
                None => full.column_mut(j).copy_from_slice(a.column(j)),
                Some(rows) => rows.iter().zip(a.column(j)).for_each(|(&i, x)| full[(i, j)] = *x),
            }
        }
        full
    }
}
