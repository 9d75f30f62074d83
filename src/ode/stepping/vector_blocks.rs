//! Coordinates and velocities of models with more than two degrees of freedom, in blocks of sixteen numbers.
//!
//! Sums over them use the widest vector instructions of the processor. The code does not depend on the model
//! and is compiled once.

use crate::ode::stepping::tableau_row::{SLOTS, TableauRow};
use pulp::Arch;
use pulp::Simd;
use pulp::WithSimd;

/// Numbers per block: four registers of AVX2. A sum over blocks is then four independent sums, which run in
/// parallel.
const WIDTH: usize = 16;

type Sixteen = [f64; WIDTH];

/// A vector in whole blocks. Numbers beyond its length have no meaning.
///
/// The layout of a derivative is q | v | a: the stage (q, v) of its evaluation, then its accelerations.
/// The derivative (v, a) begins at the velocities of the stage, so that the velocities are not copied.
#[derive(Clone)]
pub struct Blocks {
    blocks: Vec<Sixteen>,
    /// Index of the block at which the vector begins.
    first: usize,
    len: usize,
    arch: Arch,
}

impl Blocks {
    /// A vector of `len` zeros that begins at block `first`.
    fn new(first: usize, len: usize) -> Self {
        Blocks { blocks: vec![[0.0; WIDTH]; first + len.div_ceil(WIDTH)], first, len, arch: Arch::new() }
    }
    /// A vector of zeros.
    pub(crate) fn zeros(len: usize) -> Self {
        Blocks::new(0, len)
    }
    /// A derivative of zeros, with room for the coordinates of its stage in front of it.
    pub(crate) fn slot(len: usize) -> Self {
        Blocks::new((len / 2).div_ceil(WIDTH), len)
    }
    /// The numbers of the vector.
    #[inline(always)]
    pub(crate) fn slice(&self) -> &[f64] {
        &self.blocks.as_flattened()[WIDTH * self.first..][..self.len]
    }
    /// The numbers of the vector, mutable.
    #[inline(always)]
    pub(crate) fn slice_mut(&mut self) -> &mut [f64] {
        &mut self.blocks.as_flattened_mut()[WIDTH * self.first..][..self.len]
    }
    /// Copies the velocities of the state vector `from`, its second half, into the first half.
    #[inline(always)]
    pub(crate) fn take_velocities(&mut self, from: &Self) {
        let n = self.len / 2;
        self.slice_mut()[..n].copy_from_slice(&from.slice()[n..]);
    }

    /// Writes the stage y + Σ (h a_l) k_l in front of this derivative.
    #[inline(always)]
    pub(crate) fn stage<const L: usize>(&mut self, y: &Self, k: &[Self], h: f64, row: &TableauRow<L>) {
        let stage = &mut self.blocks.as_flattened_mut()[WIDTH * self.first - self.len / 2..];
        combine(self.arch, Combine { out: stage, y, k, h, row });
    }

    /// Returns the coordinates and the velocities at which this derivative is evaluated, and the place of its
    /// accelerations.
    #[inline(always)]
    pub(crate) fn parts(&mut self) -> (&[f64], &[f64], &mut [f64]) {
        let n = self.len / 2;
        let stage = &mut self.blocks.as_flattened_mut()[WIDTH * self.first - n..][..3 * n];
        let (q, rest) = stage.split_at_mut(n);
        let (v, a) = rest.split_at_mut(n);
        (q, v, a)
    }

    /// out = y + Σ (h a_l) k_l.
    #[inline(always)]
    pub(crate) fn combine<const L: usize>(
        out: &mut Self,
        y: &Self,
        k: &[Self; SLOTS],
        h: f64,
        row: &TableauRow<L>,
    ) {
        combine(out.arch, Combine { out: out.blocks.as_flattened_mut(), y, k, h, row });
    }

    /// out = h Σ d_l k_l.
    #[inline(always)]
    pub(crate) fn weigh(out: &mut Self, k: &[Self; SLOTS], h: f64, row: &[(usize, f64)]) {
        weigh(out, k, h, row);
    }

    /// Σ (e/size)², e = Σ e_l k_l, size = atol + rtol max(|y|, |y1|), as sixteen partial sums, for each row
    /// e.
    #[inline(always)]
    pub(crate) fn squares<const L: usize, const R: usize>(
        ends: [&Self; 2],
        k: &[Self; SLOTS],
        atol: &Self,
        rtol: f64,
        rows: [&TableauRow<L>; R],
    ) -> [f64; R] {
        squares(ends, k, atol, rtol, rows.map(|row| &row[..]))
    }

    /// Σ |y|, as four partial sums that run in parallel.
    #[inline(always)]
    pub(crate) fn size(&self) -> f64 {
        let mut sum = [0.0; 4];
        let (fours, rest) = self.slice().as_chunks::<4>();
        for four in fours {
            for i in 0..4 {
                sum[i] += four[i].abs();
            }
        }
        let rest: f64 = rest.iter().map(|y| y.abs()).sum();
        (sum[0] + sum[1]) + (sum[2] + sum[3]) + rest
    }
}

#[inline(never)]
fn weigh(out: &mut Blocks, k: &[Blocks; SLOTS], h: f64, row: &[(usize, f64)]) {
    out.arch.dispatch(Weigh { out: &mut out.blocks, k, h, row });
}

#[inline(never)]
fn squares<const R: usize>(
    [y, y1]: [&Blocks; 2],
    k: &[Blocks; SLOTS],
    atol: &Blocks,
    rtol: f64,
    rows: [&[(usize, f64)]; R],
) -> [f64; R] {
    y.arch.dispatch(Squares { y: &y.blocks, y1: &y1.blocks, k, atol: &atol.blocks, rtol, rows, len: y.len })
}

/// Σ (times a_l) k_l in block `b`, which counts from the start of the memory.
#[inline(always)]
fn sum(k: &[Blocks], b: usize, times: f64, row: &[(usize, f64)]) -> Sixteen {
    let mut sum = [0.0; WIDTH];
    let Some((&(slot, a), rest)) = row.split_first() else { return sum };
    let (block, a) = (&k[slot].blocks[b], times * a);
    for i in 0..WIDTH {
        sum[i] = a * block[i];
    }
    for &(slot, a) in rest {
        let (block, a) = (&k[slot].blocks[b], times * a);
        for i in 0..WIDTH {
            sum[i] += a * block[i];
        }
    }
    sum
}

/// Maximum number of terms of a sum over one block that is computed in place: the call of the code for the
/// instructions of the processor takes longer than such a sum. Measured with RK4 on a ring of three gears.
const SHORT_SUM: usize = 4;

#[inline(always)]
fn combine<const L: usize>(arch: Arch, sums: Combine<'_, [(usize, f64); L]>) {
    let Combine { out, y, k, h, row } = sums;
    if y.blocks.len() > 1 {
        return arch.dispatch(Combine { out, y, k, h, row });
    }
    let one: Combine<'_, [(usize, f64)]> = Combine { out, y, k, h, row };
    if L <= SHORT_SUM { one.run() } else { arch.dispatch(one) }
}

/// y + Σ (h a_l) k_l. `R`: a row of known length for a vector of several blocks, of any length for one block.
/// Measured with Dop853 on rings of 3 and 16 gears.
struct Combine<'a, R: ?Sized> {
    out: &'a mut [f64],
    y: &'a Blocks,
    k: &'a [Blocks],
    h: f64,
    row: &'a R,
}

impl<const L: usize> WithSimd for Combine<'_, [(usize, f64); L]> {
    type Output = ();
    /// Finds the derivatives before the loop over the blocks.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let (outs, ys) = (self.out.as_chunks_mut::<WIDTH>().0, &self.y.blocks[..]);
        let count = outs.len().min(ys.len());
        let (outs, ys) = (&mut outs[..count], &ys[..count]);
        let (mut k, mut a): ([&[Sixteen]; L], _) = ([&[]; L], [0.0; L]);
        for l in 0..L {
            let (slot, factor) = self.row[l];
            let of = &self.k[slot];
            (k[l], a[l]) = (&of.blocks[of.first..][..count], self.h * factor);
        }
        for b in 0..count {
            let mut sum = [0.0; WIDTH];
            for i in 0..WIDTH {
                sum[i] = a[0] * k[0][b][i];
            }
            for l in 1..L {
                for i in 0..WIDTH {
                    sum[i] += a[l] * k[l][b][i];
                }
            }
            for i in 0..WIDTH {
                sum[i] += ys[b][i];
            }
            outs[b] = sum;
        }
    }
}

impl WithSimd for Combine<'_, [(usize, f64)]> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.run();
    }
}

impl Combine<'_, [(usize, f64)]> {
    #[inline(always)]
    fn run(self) {
        let first = self.k[0].first;
        for (b, (out, y)) in self.out.as_chunks_mut().0.iter_mut().zip(&self.y.blocks).enumerate() {
            let (mut sum, y): (Sixteen, Sixteen) = (sum(self.k, first + b, self.h, self.row), *y);
            for i in 0..WIDTH {
                sum[i] += y[i];
            }
            *out = sum;
        }
    }
}

struct Weigh<'a> {
    out: &'a mut [Sixteen],
    k: &'a [Blocks; SLOTS],
    h: f64,
    row: &'a [(usize, f64)],
}

impl WithSimd for Weigh<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (b, out) in self.out.iter_mut().enumerate() {
            let mut sum = sum(self.k, self.k[0].first + b, 1.0, self.row);
            for s in &mut sum {
                *s *= self.h;
            }
            *out = sum;
        }
    }
}

struct Squares<'a, const R: usize> {
    y: &'a [Sixteen],
    y1: &'a [Sixteen],
    k: &'a [Blocks; SLOTS],
    atol: &'a [Sixteen],
    rtol: f64,
    rows: [&'a [(usize, f64)]; R],
    len: usize,
}

impl<const R: usize> WithSimd for Squares<'_, R> {
    type Output = [f64; R];
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; R] {
        let mut totals = [[0.0; WIDTH]; R];
        for (b, ((y, y1), atol)) in self.y.iter().zip(self.y1).zip(self.atol).enumerate() {
            let left = self.len - WIDTH * b;
            for (totals, row) in totals.iter_mut().zip(self.rows) {
                let sum = sum(self.k, self.k[0].first + b, 1.0, row);
                for i in 0..WIDTH {
                    let e = sum[i] / (atol[i] + self.rtol * y[i].abs().max(y1[i].abs()));
                    // Beyond the length the quotient is 0/0.
                    totals[i] += if i < left { e * e } else { 0.0 };
                }
            }
        }
        totals.map(|totals| {
            let (mut sums, mut width) = (totals, WIDTH / 2);
            while width > 0 {
                for i in 0..width {
                    sums[i] += sums[i + width];
                }
                width /= 2;
            }
            sums[0]
        })
    }
}
