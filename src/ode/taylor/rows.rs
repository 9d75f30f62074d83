//! Sparse matrices of weighted sums, in blocks of eight rows.

use crate::tape::form::Form;
use std::ops::Range;

/// Numbers that are computed side by side: two registers of AVX2, one of AVX-512.
pub(super) type Eight = [f64; EIGHT];
pub(super) const EIGHT: usize = 8;

/// Where the numbers of a sum stand.
pub(super) struct Places<'p> {
    /// The column of each slot.
    pub(super) of_slot: &'p [u32],
    /// The column of the number 1.
    pub(super) one: u32,
    /// Columns of numbers that are 0 in all orders above 0.
    pub(super) still: &'p Range<u32>,
    /// Columns of choices, which are read from other columns.
    pub(super) choices: &'p [u32],
}

/// Neighbouring columns with their weights.
#[derive(Debug)]
struct Run {
    /// First column on the present pieces.
    column: u32,
    /// First column.
    source: u32,
    weights: Range<usize>,
}

/// Eight rows.
#[derive(Debug)]
struct Block {
    /// Block of the results.
    out: usize,
    /// Runs of columns that vary.
    moving: Range<usize>,
    /// Runs of columns that are 0 in all orders above 0.
    still: Range<usize>,
}

/// out = W x. Each block lists the columns in which any of its eight rows has a weight.
#[derive(Debug, Default)]
pub(super) struct Rows {
    blocks: Vec<Block>,
    runs: Vec<Run>,
    /// The weights of a column in the eight rows.
    weights: Vec<Eight>,
}

/// sum += weights y.
#[inline(always)]
fn add(sum: &mut Eight, weights: &Eight, y: f64) {
    for l in 0..EIGHT {
        sum[l] += weights[l] * y;
    }
}

impl Rows {
    /// The rows of `forms`, whose results begin at block `out`.
    pub(super) fn new(forms: &[Option<&Form>], places: &Places<'_>, out: usize) -> Self {
        let mut rows = Rows::default();
        for (b, block) in forms.chunks(EIGHT).enumerate() {
            let mut terms: Vec<(u32, usize, f64)> = Vec::new();
            for (row, form) in block.iter().enumerate() {
                let Some(form) = form else { continue };
                let columns =
                    form.terms.iter().map(|&(slot, weight)| (places.of_slot[slot as usize], weight));
                terms.extend(columns.map(|(column, weight)| (column, row, weight)));
                if form.constant != 0.0 {
                    terms.push((places.one, row, form.constant));
                }
            }
            terms.sort_by_key(|&(column, row, _)| (column, row));
            let (still, moving): (Vec<_>, Vec<_>) =
                terms.into_iter().partition(|(column, ..)| places.still.contains(column));
            let moving = rows.add_runs(&moving, places);
            let still = rows.add_runs(&still, places);
            rows.blocks.push(Block { out: out + b, moving, still });
        }
        rows
    }

    fn add_runs(&mut self, terms: &[(u32, usize, f64)], places: &Places<'_>) -> Range<usize> {
        let first = self.runs.len();
        let mut last = None;
        for &(column, row, weight) in terms {
            if last != Some(column) {
                let next = last.is_some_and(|last: u32| last + 1 == column)
                    && !places.choices.contains(&column)
                    && !places.choices.contains(&(column - 1));
                match self.runs.last_mut() {
                    Some(run) if next => run.weights.end += 1,
                    _ => {
                        let at = self.weights.len();
                        self.runs.push(Run { column, source: column, weights: at..at + 1 });
                    }
                }
                self.weights.push([0.0; EIGHT]);
                last = Some(column);
            }
            if let Some(weights) = self.weights.last_mut() {
                weights[row] += weight;
            }
        }
        first..self.runs.len()
    }

    /// Reads each column from the one that `actual` gives for it.
    pub(super) fn redirect(&mut self, actual: &[u32]) {
        for run in &mut self.runs {
            run.column = actual[run.source as usize];
        }
    }

    /// Writes the results of order n into its row of numbers `x`.
    #[inline(always)]
    pub(super) fn apply(&self, n: usize, x: &mut [Eight]) {
        for block in &self.blocks {
            let mut sums = [[0.0; EIGHT]; 2];
            self.add_to(&mut sums, &block.moving, x.as_flattened());
            if n == 0 {
                self.add_to(&mut sums, &block.still, x.as_flattened());
            }
            let ([even, odd], result) = (&sums, &mut x[block.out]);
            for l in 0..EIGHT {
                result[l] = even[l] + odd[l];
            }
        }
    }

    #[inline(always)]
    fn add_to(&self, [even, odd]: &mut [Eight; 2], runs: &Range<usize>, numbers: &[f64]) {
        for run in &self.runs[runs.clone()] {
            let (pairs, last) = self.weights[run.weights.clone()].as_chunks::<2>();
            let numbers = &numbers[run.column as usize..][..run.weights.len()];
            for ([w, z], [y, u]) in pairs.iter().zip(numbers.as_chunks::<2>().0) {
                add(even, w, *y);
                add(odd, z, *u);
            }
            if let ([w], Some(y)) = (last, numbers.last()) {
                add(even, w, *y);
            }
        }
    }
}
