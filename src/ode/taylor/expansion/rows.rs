//! Sparse matrices of weighted sums, in blocks of eight rows.

use crate::tape::form::Form;
use std::ops::Range;

/// Numbers that are computed side by side: two registers of AVX2, one of AVX-512.
pub(crate) type Eight = [f64; EIGHT];
pub(crate) const EIGHT: usize = 8;

/// Where the numbers of a sum stand.
pub(crate) struct Places<'p> {
    /// The column of each slot.
    pub(crate) of_slot: &'p [u32],
    /// The column of the number 1.
    pub(crate) one: u32,
    /// Columns of numbers that are 0 in all orders above 0.
    pub(crate) still: &'p Range<u32>,
    /// Columns of choices, which are read from other columns.
    pub(crate) choices: &'p [u32],
}

/// A column with its weights in eight rows.
#[derive(Debug)]
struct Entry {
    /// The column on the present pieces.
    column: usize,
    source: usize,
    weights: Eight,
}

/// Neighbouring columns with their weights.
#[derive(Debug)]
struct Run {
    column: usize,
    weights: Vec<Eight>,
}

/// Neighbouring columns of at least this number are read as a run.
const LONG: usize = 4;

/// Eight rows.
#[derive(Debug)]
struct Block {
    /// Block of the results.
    out: usize,
    /// Columns that vary.
    runs: Vec<Run>,
    entries: Vec<Entry>,
    /// Columns that are 0 in all orders above 0.
    still: Vec<Entry>,
}

/// out = W x. Each block lists the columns in which any of its eight rows has a weight.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    blocks: Vec<Block>,
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
    pub(crate) fn new(forms: &[Option<&Form>], places: &Places<'_>, out: usize) -> Self {
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
            let entries = entries(&terms);
            let (still, moving) =
                entries.into_iter().partition(|e| places.still.contains(&(e.column as u32)));
            let (runs, entries) = runs(moving, places);
            rows.blocks.push(Block { out: out + b, runs, entries, still });
        }
        rows
    }

    /// Reads each column from the one that `actual` gives for it.
    pub(crate) fn redirect(&mut self, actual: &[u32]) {
        // Runs contain no choices.
        for entry in self.blocks.iter_mut().flat_map(|block| &mut block.entries) {
            entry.column = actual[entry.source] as usize;
        }
    }

    /// Writes the results of order n into its row of numbers `x`.
    #[inline(always)]
    pub(crate) fn apply(&self, n: usize, x: &mut [Eight]) {
        for block in &self.blocks {
            let numbers = x.as_flattened();
            let (mut even, mut odd) = ([0.0; EIGHT], [0.0; EIGHT]);
            for run in &block.runs {
                let (pairs, last) = run.weights.as_chunks::<2>();
                let numbers = &numbers[run.column..][..run.weights.len()];
                for ([w, z], [y, u]) in pairs.iter().zip(numbers.as_chunks::<2>().0) {
                    add(&mut even, w, *y);
                    add(&mut odd, z, *u);
                }
                if let ([w], Some(y)) = (last, numbers.last()) {
                    add(&mut even, w, *y);
                }
            }
            for entry in &block.entries {
                add(&mut odd, &entry.weights, numbers[entry.column]);
            }
            if n == 0 {
                for entry in &block.still {
                    add(&mut even, &entry.weights, numbers[entry.column]);
                }
            }
            let result = &mut x[block.out];
            for l in 0..EIGHT {
                result[l] = even[l] + odd[l];
            }
        }
    }
}

/// The columns of terms (column, row, weight), which are sorted, with their weights.
fn entries(terms: &[(u32, usize, f64)]) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    for &(column, row, weight) in terms {
        let column = column as usize;
        if entries.last().is_none_or(|last| last.column != column) {
            entries.push(Entry { column, source: column, weights: [0.0; EIGHT] });
        }
        if let Some(last) = entries.last_mut() {
            last.weights[row] += weight;
        }
    }
    entries
}

/// Long runs of neighbouring columns, and the other columns.
fn runs(entries: Vec<Entry>, places: &Places<'_>) -> (Vec<Run>, Vec<Entry>) {
    let (mut runs, mut rest) = (Vec::new(), Vec::new());
    let is_choice = |entry: &Entry| places.choices.contains(&(entry.column as u32));
    let together = |a: &Entry, b: &Entry| a.column + 1 == b.column && !is_choice(a) && !is_choice(b);
    let lengths: Vec<usize> = entries.chunk_by(together).map(<[Entry]>::len).collect();
    let mut entries = entries.into_iter();
    for length in lengths {
        let run: Vec<Entry> = entries.by_ref().take(length).collect();
        if length >= LONG {
            runs.push(Run { column: run[0].column, weights: run.iter().map(|e| e.weights).collect() });
        } else {
            rest.extend(run);
        }
    }
    (runs, rest)
}
