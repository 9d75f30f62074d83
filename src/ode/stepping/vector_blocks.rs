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
    /// A vector of one block, with the block of its stage in front of it if it is a derivative. Sums over
    /// such vectors read no list.
    short: [Sixteen; 2],
    /// The blocks of a longer vector; empty for a short one.
    long: Vec<Sixteen>,
    /// Index of the block at which the vector begins.
    first: usize,
    len: usize,
    arch: Arch,
}

impl Blocks {
    /// A vector of `len` zeros that begins at block `first`.
    fn new(first: usize, len: usize) -> Self {
        let long = if len <= WIDTH { 0 } else { first + len.div_ceil(WIDTH) };
        let zeros = [0.0; WIDTH];
        Blocks { short: [zeros; 2], long: vec![zeros; long], first, len, arch: Arch::new() }
    }
    /// A vector of zeros.
    pub(crate) fn zeros(len: usize) -> Self {
        Blocks::new(0, len)
    }
    /// A derivative of zeros, with room for the coordinates of its stage in front of it.
    pub(crate) fn slot(len: usize) -> Self {
        Blocks::new((len / 2).div_ceil(WIDTH).max(1), len)
    }
    /// All numbers, those in front of the vector included.
    #[inline(always)]
    fn all(&self) -> &[f64] {
        if self.long.is_empty() { self.short.as_flattened() } else { self.long.as_flattened() }
    }
    #[inline(always)]
    fn all_mut(&mut self) -> &mut [f64] {
        if self.long.is_empty() { self.short.as_flattened_mut() } else { self.long.as_flattened_mut() }
    }
    /// Makes `to` this vector. The content of this one is not defined afterwards.
    #[inline(always)]
    pub(crate) fn hand_over(&mut self, to: &mut Self) {
        if self.long.is_empty() {
            to.short[to.first] = self.short[self.first];
        } else {
            std::mem::swap(&mut self.long, &mut to.long);
        }
    }
    /// The numbers of the vector.
    #[inline(always)]
    pub(crate) fn slice(&self) -> &[f64] {
        &self.all()[WIDTH * self.first..][..self.len]
    }
    /// The numbers of the vector, mutable.
    #[inline(always)]
    pub(crate) fn slice_mut(&mut self) -> &mut [f64] {
        let (first, len) = (WIDTH * self.first, self.len);
        &mut self.all_mut()[first..][..len]
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
        let (arch, start) = (self.arch, WIDTH * self.first - self.len / 2);
        combine(arch, Combine { out: &mut self.all_mut()[start..], y, k, h, row });
    }

    /// Returns the coordinates and the velocities at which this derivative is evaluated, and the place of its
    /// accelerations.
    #[inline(always)]
    pub(crate) fn parts(&mut self) -> (&[f64], &[f64], &mut [f64]) {
        let (n, first) = (self.len / 2, WIDTH * self.first);
        let stage = &mut self.all_mut()[first - n..][..3 * n];
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
        combine(out.arch, Combine { out: out.all_mut(), y, k, h, row });
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
    out.arch.dispatch(Weigh { out, k, h, row });
}

#[inline(never)]
fn squares<const R: usize>(
    [y, y1]: [&Blocks; 2],
    k: &[Blocks; SLOTS],
    atol: &Blocks,
    rtol: f64,
    rows: [&[(usize, f64)]; R],
) -> [f64; R] {
    y.arch.dispatch(Squares { y, y1, k, atol, rtol, rows })
}

/// Σ (times a_l) k_l in one block of each derivative.
#[inline(always)]
fn sum<'k>(
    k: &'k [Blocks],
    block: impl Fn(&'k Blocks) -> &'k Sixteen,
    times: f64,
    row: &[(usize, f64)],
) -> Sixteen {
    let mut sum = [0.0; WIDTH];
    let Some((&(slot, a), rest)) = row.split_first() else { return sum };
    let (first, a) = (block(&k[slot]), times * a);
    for i in 0..WIDTH {
        sum[i] = a * first[i];
    }
    for &(slot, a) in rest {
        let (next, a) = (block(&k[slot]), times * a);
        for i in 0..WIDTH {
            sum[i] += a * next[i];
        }
    }
    sum
}

/// The block of a derivative of one block.
#[inline(always)]
fn only(k: &Blocks) -> &Sixteen {
    &k.short[1]
}

/// Maximum number of terms of a sum over one block that is computed in place: the call of the code for the
/// instructions of the processor takes longer than such a sum. Measured with RK4 on a ring of three gears.
const SHORT_SUM: usize = 4;

#[inline(always)]
fn combine<const L: usize>(arch: Arch, sums: Combine<'_, [(usize, f64); L]>) {
    let Combine { out, y, k, h, row } = sums;
    if !y.long.is_empty() {
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
        let (outs, ys) = (self.out.as_chunks_mut::<WIDTH>().0, &self.y.long[..]);
        let count = outs.len().min(ys.len());
        let (outs, ys) = (&mut outs[..count], &ys[..count]);
        let (mut k, mut a): ([&[Sixteen]; L], _) = ([&[]; L], [0.0; L]);
        for l in 0..L {
            let (slot, factor) = self.row[l];
            let of = &self.k[slot];
            (k[l], a[l]) = (&of.long[of.first..][..count], self.h * factor);
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
        let Some(out) = self.out.first_chunk_mut() else { return };
        let (mut sum, y) = (sum(self.k, only, self.h, self.row), &self.y.short[0]);
        for i in 0..WIDTH {
            sum[i] += y[i];
        }
        *out = sum;
    }
}

struct Weigh<'a> {
    out: &'a mut Blocks,
    k: &'a [Blocks; SLOTS],
    h: f64,
    row: &'a [(usize, f64)],
}

impl WithSimd for Weigh<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Weigh { out, k, h, row } = self;
        if out.long.is_empty() {
            out.short[0] = sum(k, only, 1.0, row).map(|sum| h * sum);
        }
        for (b, out) in out.long.iter_mut().enumerate() {
            *out = sum(k, |k| &k.long[k.first + b], 1.0, row).map(|sum| h * sum);
        }
    }
}

struct Squares<'a, const R: usize> {
    y: &'a Blocks,
    y1: &'a Blocks,
    k: &'a [Blocks; SLOTS],
    atol: &'a Blocks,
    rtol: f64,
    rows: [&'a [(usize, f64)]; R],
}

impl<const R: usize> WithSimd for Squares<'_, R> {
    type Output = [f64; R];
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; R] {
        let Squares { y, y1, k, atol, rtol, rows } = self;
        let mut totals = [[0.0; WIDTH]; R];
        // Beyond the length the quotient is 0/0.
        let add = |total: &mut Sixteen, sum: Sixteen, [y, y1, atol]: [&Sixteen; 3], left: usize| {
            for i in 0..WIDTH {
                let e = sum[i] / (atol[i] + rtol * y[i].abs().max(y1[i].abs()));
                total[i] += if i < left { e * e } else { 0.0 };
            }
        };
        if y.long.is_empty() {
            for (total, row) in totals.iter_mut().zip(rows) {
                add(total, sum(k, only, 1.0, row), [y, y1, atol].map(|x| &x.short[0]), y.len);
            }
        }
        for (b, ((of_y, y1), atol)) in y.long.iter().zip(&y1.long).zip(&atol.long).enumerate() {
            for (total, row) in totals.iter_mut().zip(rows) {
                let sum = sum(k, |k| &k.long[k.first + b], 1.0, row);
                add(total, sum, [of_y, y1, atol], y.len - WIDTH * b);
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
