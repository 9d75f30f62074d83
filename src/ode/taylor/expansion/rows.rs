//! Sparse matrices of weighted sums, in blocks of eight rows.

pub(crate) use crate::series::EIGHT;
use crate::tape::form::Form;
use std::ops::Range;

/// Numbers that are computed side by side: two registers of AVX2, one of AVX-512.
pub(crate) type Eight = [f64; EIGHT];

/// Where the numbers of a sum stand.
pub(crate) struct Places<'p> {
    /// The column of each slot.
    pub(crate) of_slot: &'p [u32],
    /// The column of the number 1.
    pub(crate) one: u32,
    /// Columns of numbers that are 0 in all orders above 0.
    pub(crate) still: &'p Range<u32>,
}

/// Two columns with their weights in eight rows, which stand in one line of the cache each.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Pair {
    weights: [Eight; 2],
    /// The columns on the present pieces.
    columns: [usize; 2],
    sources: [usize; 2],
}

/// Columns with their weights in eight rows. An odd number of columns is followed by one with weights of 0.
#[derive(Debug, Default)]
struct Terms {
    pairs: Vec<Pair>,
}

/// Eight rows.
#[derive(Debug)]
pub(crate) struct Block {
    /// Block of the results.
    pub(crate) out: usize,
    /// Columns that vary.
    moving: Terms,
    /// Columns that are 0 in all orders above 0.
    still: Terms,
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

impl Terms {
    /// Terms (column, row, weight), sorted by their columns.
    fn new(terms: &[(u32, usize, f64)]) -> Self {
        let mut all = Terms::default();
        for (i, of_column) in terms.chunk_by(|a, b| a.0 == b.0).enumerate() {
            let column = of_column[0].0 as usize;
            if i % 2 == 0 {
                let (columns, sources) = ([column; 2], [column; 2]);
                all.pairs.push(Pair { weights: [[0.0; EIGHT]; 2], columns, sources });
            }
            if let Some(pair) = all.pairs.last_mut() {
                (pair.columns[i % 2], pair.sources[i % 2]) = (column, column);
                of_column.iter().for_each(|&(_, row, weight)| pair.weights[i % 2][row] += weight);
            }
        }
        all
    }

    /// Adds the first column of each pair to the first sum, the second one to the second sum.
    #[inline(always)]
    fn add(&self, numbers: &[f64], sums: &mut [Eight; 2]) {
        for Pair { weights: [w, z], columns: [y, u], .. } in &self.pairs {
            add(&mut sums[0], w, numbers[*y]);
            add(&mut sums[1], z, numbers[*u]);
        }
    }
}

impl Block {
    /// Returns the eight weighted sums of the numbers of one order. `FIRST`: whether it is order 0.
    #[inline(always)]
    pub(crate) fn sum<const FIRST: bool>(&self, numbers: &[f64]) -> Eight {
        let mut sums = [[0.0; EIGHT]; 2];
        if FIRST {
            self.still.add(numbers, &mut sums);
        }
        self.moving.add(numbers, &mut sums);
        let [even, odd] = sums;
        let mut sum = [0.0; EIGHT];
        for l in 0..EIGHT {
            sum[l] = even[l] + odd[l];
        }
        sum
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
            let (still, moving): (Vec<_>, Vec<_>) =
                terms.into_iter().partition(|(column, ..)| places.still.contains(column));
            let (moving, still) = (Terms::new(&moving), Terms::new(&still));
            rows.blocks.push(Block { out: out + b, moving, still });
        }
        rows
    }

    /// Reads each column from the one that `actual` gives for it.
    pub(crate) fn redirect(&mut self, actual: &[u32]) {
        for Pair { columns, sources, .. } in self.blocks.iter_mut().flat_map(|b| &mut b.moving.pairs) {
            *columns = sources.map(|source| actual[source] as usize);
        }
    }

    /// Writes the results of an order into its row of numbers `x`. `FIRST`: whether it is order 0.
    #[inline(always)]
    pub(crate) fn apply<const FIRST: bool>(&self, x: &mut [Eight]) {
        for block in &self.blocks {
            x[block.out] = block.sum::<FIRST>(x.as_flattened());
        }
    }
    #[inline(always)]
    pub(crate) fn blocks(&self) -> &[Block] {
        &self.blocks
    }
}
