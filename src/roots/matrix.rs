//! Matrices for Jacobians: dense, or in blocks of which only some are stored.

use crate::error::{ParameterError, check};
use crate::roots::blocks::{Block, Pairs};
use nalgebra::DMatrix;

/// A square matrix in blocks. A dense matrix is a single block. Inside each block the entries are stored
/// column by column; blocks that are not stored are zero.
///
/// [`Newton`](crate::roots::Newton) and [`Broyden`](crate::roots::Broyden) eliminate block by block, with
/// pivots inside the diagonal blocks only. This is cheap, and accurate if the diagonal blocks outweigh the
/// others. If a test system shows that it is inaccurate, the matrix is factored as one dense matrix.
///
/// ```
/// use gear_dynamics::roots::Matrix;
/// // A chain of three pairs of unknowns: the first and the last pair are not coupled.
/// let mut chain = Matrix::blocks(&[2, 2, 2], &[(0, 0), (1, 1), (2, 2), (0, 1), (1, 0), (1, 2), (2, 1)])?;
/// chain.block_mut(0, 1).copy_from_slice(&[1.0, 0.0, 0.0, 4.0]);
/// assert_eq!(chain.size(), 6);
/// assert_eq!(chain.times(&[0.0, 0.0, 1.0, 1.0, 0.0, 0.0]), [1.0, 4.0, 0.0, 0.0, 0.0, 0.0]);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Matrix {
    /// First row of each block row; the last entry is the size.
    starts: Vec<usize>,
    parts: Vec<MatrixPart>,
    /// The block row that is eliminated last; `None`: the elimination chooses it.
    last: Option<usize>,
}

/// Maximum size of a dense matrix: 34 GB.
const MAX_DENSE: usize = 1 << 16;

/// Maximum number of stored entries of a matrix in blocks and of a Jacobian: 2 GB.
pub(crate) const MAX_ENTRIES: usize = 1 << 28;

/// One stored block.
#[derive(Clone, Debug)]
pub(crate) struct MatrixPart {
    pub(crate) i: usize,
    pub(crate) j: usize,
    /// Whether only pairs of rows on the diagonal are stored, two entries per column.
    pub(crate) pairs: bool,
    pub(crate) values: Vec<f64>,
}

impl Matrix {
    /// A dense matrix of zeros.
    ///
    /// # Panics
    /// If `size` is larger than 65 536.
    pub fn dense(size: usize) -> Self {
        assert!(size <= MAX_DENSE, "the size of a dense matrix is {size}: it must be at most {MAX_DENSE}");
        Matrix {
            starts: vec![0, size],
            parts: vec![MatrixPart { i: 0, j: 0, pairs: false, values: vec![0.0; size * size] }],
            last: None,
        }
    }

    /// A matrix of zeros with block rows of the given heights. `pattern` lists the stored blocks as (block
    /// row, block column).
    ///
    /// # Errors
    /// A block outside the matrix or listed twice; a sum of the heights above 2²⁸; more than 2²⁸ stored
    /// entries.
    pub fn blocks(heights: &[usize], pattern: &[(usize, usize)]) -> Result<Self, ParameterError> {
        let size = heights.iter().fold(0usize, |size, &height| size.saturating_add(height));
        check::count("sum of the heights", &[size], MAX_ENTRIES)?;
        let mut matrix = Matrix::of_heights(heights);
        let mut entries = 0usize;
        for (k, &(i, j)) in pattern.iter().enumerate() {
            let wrong = |what: &str, value: usize, must: String| {
                let name = format!("{what} of block {k} of the pattern");
                Err(ParameterError::Wrong { name, value: value as f64, must })
            };
            let count = heights.len();
            for (what, value) in [("row", i), ("column", j)] {
                if value >= count {
                    return wrong(what, value, format!("be below {count}, the number of block rows"));
                }
            }
            if pattern[..k].contains(&(i, j)) {
                return wrong("column", j, format!("stand once in row {i} of the pattern"));
            }
            entries = entries.saturating_add(heights[i].saturating_mul(heights[j]));
            check::count("stored entries", &[entries], MAX_ENTRIES)?;
            matrix.add_part(i, j, false);
        }
        Ok(matrix)
    }

    /// A matrix without stored blocks.
    pub(crate) fn of_heights(heights: &[usize]) -> Self {
        let mut starts = vec![0];
        for height in heights {
            starts.push(starts[starts.len() - 1] + height);
        }
        Matrix { starts, parts: Vec::new(), last: None }
    }

    /// Stores block (i, j) as zeros. `pairs`: only pairs of rows on the diagonal.
    pub(crate) fn add_part(&mut self, i: usize, j: usize, pairs: bool) {
        let entries = self.height(j) * if pairs { 2 } else { self.height(i) };
        self.parts.push(MatrixPart { i, j, pairs, values: vec![0.0; entries] });
    }

    pub(crate) fn eliminate_last(&mut self, block: usize) {
        self.last = Some(block);
    }
    pub(crate) fn last(&self) -> Option<usize> {
        self.last
    }

    pub(crate) fn height(&self, i: usize) -> usize {
        self.starts[i + 1] - self.starts[i]
    }
    pub(crate) fn start(&self, i: usize) -> usize {
        self.starts[i]
    }
    pub(crate) fn block_rows(&self) -> usize {
        self.starts.len() - 1
    }
    pub(crate) fn parts(&self) -> &[MatrixPart] {
        &self.parts
    }
    pub(crate) fn parts_mut(&mut self) -> &mut [MatrixPart] {
        &mut self.parts
    }
    /// The entries of a dense matrix; `None` for a matrix in blocks.
    pub(crate) fn single(&self) -> Option<&[f64]> {
        self.parts.first().filter(|part| self.block_rows() == 1 && !part.pairs).map(|part| &part.values[..])
    }

    /// Number of rows, equal to the number of columns.
    pub fn size(&self) -> usize {
        self.starts[self.starts.len() - 1]
    }

    /// Number of stored entries.
    pub fn stored(&self) -> usize {
        self.parts.iter().map(|part| part.values.len()).sum()
    }

    /// The entries of block (i, j), column by column.
    ///
    /// # Panics
    /// If the block is not stored.
    pub fn block_mut(&mut self, i: usize, j: usize) -> &mut [f64] {
        let found = self.parts.iter_mut().find(|part| part.i == i && part.j == j && !part.pairs);
        assert!(found.is_some(), "block ({i}, {j}) is not stored");
        found.map_or(&mut [], |part| &mut part.values[..])
    }

    /// Column j of a dense matrix.
    ///
    /// # Panics
    /// If the matrix has more than one block, or no column j.
    pub fn column_mut(&mut self, j: usize) -> &mut [f64] {
        assert_eq!(self.block_rows(), 1, "only a dense matrix has whole columns");
        let n = self.size();
        &mut self.parts[0].values[j * n..(j + 1) * n]
    }

    /// Column j of a dense matrix.
    ///
    /// # Panics
    /// If the matrix has more than one block, or no column j.
    pub fn column(&self, j: usize) -> &[f64] {
        assert_eq!(self.block_rows(), 1, "only a dense matrix has whole columns");
        let n = self.size();
        &self.parts[0].values[j * n..(j + 1) * n]
    }

    /// Sets every stored entry of column j to `value(row)`.
    pub fn set_column(&mut self, j: usize, value: impl Fn(usize) -> f64) {
        let starts = &self.starts;
        for part in &mut self.parts {
            let (first, height) = (starts[part.i], starts[part.i + 1] - starts[part.i]);
            let Some(column) =
                j.checked_sub(starts[part.j]).filter(|c| *c < starts[part.j + 1] - starts[part.j])
            else {
                continue;
            };
            let (rows, stored) =
                if part.pairs { (Pairs::rows(height, column), 2) } else { (0..height, height) };
            part.values[column * stored..(column + 1) * stored]
                .iter_mut()
                .zip(rows)
                .for_each(|(x, row)| *x = value(first + row));
        }
    }

    /// The product A x.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; self.size()];
        self.each(|row, column, value| product[row] += value * x[column]);
        product
    }

    /// Visits every stored entry: row, column, value.
    pub fn each(&self, mut visit: impl FnMut(usize, usize, f64)) {
        for part in &self.parts {
            let height = self.height(part.i);
            let stored = if part.pairs { 2 } else { height };
            for (column, values) in part.values.chunks_exact(stored.max(1)).enumerate() {
                let rows = if part.pairs { Pairs::rows(height, column) } else { 0..height };
                rows.zip(values).for_each(|(row, value)| {
                    visit(self.starts[part.i] + row, self.starts[part.j] + column, *value)
                });
            }
        }
    }

    /// The first entry that is not finite: row, column, value.
    pub(crate) fn not_finite(&self) -> Option<(usize, usize, f64)> {
        let mut found = None;
        self.each(|row, column, value| {
            if !value.is_finite() {
                found = found.or(Some((row, column, value)));
            }
        });
        found
    }

    /// A stored block in the form for the elimination.
    pub(crate) fn block(&self, part: &MatrixPart) -> Block {
        let (height, width) = (self.height(part.i), self.height(part.j));
        if part.pairs {
            Block::Pairs(Pairs::new(&part.values, width))
        } else {
            Block::dense(&part.values, height, width)
        }
    }
}

impl From<&Matrix> for DMatrix<f64> {
    /// The dense matrix. Entries that are not stored are zero.
    fn from(a: &Matrix) -> Self {
        let mut full = DMatrix::zeros(a.size(), a.size());
        a.each(|row, column, value| full[(row, column)] += value);
        full
    }
}
