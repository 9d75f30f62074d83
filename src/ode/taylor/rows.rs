//! Sparse matrices of weighted sums, in blocks of eight rows.

use crate::tape::form::Form;

/// Rows per block: two registers of AVX2, one of AVX-512.
pub(super) const BLOCK: usize = 8;

/// out = W x. Each block of eight rows lists the columns in which any of its rows has a weight.
#[derive(Debug, Default)]
pub(super) struct Rows {
    /// First result column and range of entries of each block.
    blocks: Vec<(usize, std::ops::Range<usize>)>,
    /// Column on the present pieces and its weights in the eight rows.
    entries: Vec<(u32, [f64; BLOCK])>,
    /// Column of each entry.
    sources: Vec<u32>,
}

impl Rows {
    /// The rows of `forms`, whose results begin at column `out`. `column`: the column of each slot; `one`:
    /// the column of the number 1.
    pub(super) fn new(forms: &[&Form], column: impl Fn(u32) -> u32, one: u32, out: usize) -> Self {
        let mut rows = Rows::default();
        for (b, block) in forms.chunks(BLOCK).enumerate() {
            let mut terms: Vec<(u32, usize, f64)> = Vec::new();
            for (row, form) in block.iter().enumerate() {
                terms.extend(form.terms.iter().map(|&(slot, weight)| (column(slot), row, weight)));
                if form.constant != 0.0 {
                    terms.push((one, row, form.constant));
                }
            }
            terms.sort_by_key(|&(column, row, _)| (column, row));
            let first = rows.entries.len();
            for (column, row, weight) in terms {
                match rows.entries[first..].last_mut() {
                    Some((last, weights)) if *last == column => weights[row] += weight,
                    _ => {
                        let mut weights = [0.0; BLOCK];
                        weights[row] = weight;
                        rows.entries.push((column, weights));
                    }
                }
            }
            rows.blocks.push((out + b * BLOCK, first..rows.entries.len()));
        }
        rows.sources = rows.entries.iter().map(|(column, _)| *column).collect();
        rows
    }

    /// Reads each column from the one that `actual` gives for it.
    pub(super) fn redirect(&mut self, actual: &[u32]) {
        for ((column, _), source) in self.entries.iter_mut().zip(&self.sources) {
            *column = actual[*source as usize];
        }
    }

    /// Writes the results of one order into its row of numbers `x`.
    #[inline(always)]
    pub(super) fn apply(&self, x: &mut [f64]) {
        for (out, range) in &self.blocks {
            let (mut even, mut odd) = ([0.0; BLOCK], [0.0; BLOCK]);
            let pairs = self.entries[range.clone()].chunks_exact(2);
            if let [(column, weights)] = pairs.remainder() {
                let y = x[*column as usize];
                for l in 0..BLOCK {
                    even[l] = weights[l] * y;
                }
            }
            for pair in pairs {
                let [(c, w), (d, z)] = pair else { continue };
                let (y, u) = (x[*c as usize], x[*d as usize]);
                for l in 0..BLOCK {
                    even[l] += w[l] * y;
                    odd[l] += z[l] * u;
                }
            }
            for (out, (even, odd)) in x[*out..][..BLOCK].iter_mut().zip(even.iter().zip(&odd)) {
                *out = even + odd;
            }
        }
    }
}
