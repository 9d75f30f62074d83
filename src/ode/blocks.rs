//! Coordinates and velocities of models with more than two degrees of freedom, in blocks of eight, and the sums over them on the widest
//! instructions of the processor. Nothing here depends on the model: it is compiled once.

use super::engine::SLOTS;
use pulp::{Arch, Simd, WithSimd};

/// Four registers of AVX2: one for each of the sums that a block is.
const WIDTH: usize = 16;
type Block = [f64; WIDTH];

/// A vector in whole blocks; what is past its length is never read.
#[derive(Clone)]
pub struct Blocks {
    blocks: Vec<Block>,
    len: usize,
    arch: Arch,
}

impl Blocks {
    pub(super) fn zeros(len: usize) -> Self {
        Blocks { blocks: vec![[0.0; WIDTH]; len.div_ceil(WIDTH)], len, arch: Arch::new() }
    }
    #[inline(always)]
    pub(super) fn slice(&self) -> &[f64] {
        &self.blocks.as_flattened()[..self.len]
    }
    #[inline(always)]
    pub(super) fn slice_mut(&mut self) -> &mut [f64] {
        &mut self.blocks.as_flattened_mut()[..self.len]
    }
    /// The first half becomes the second half of another; the second half may be anything afterwards. By fours: there is room for the last.
    #[inline(always)]
    pub(super) fn take_velocities(&mut self, from: &Self) {
        let n = self.len / 2;
        let velocities = from.blocks.as_flattened()[n..].as_chunks::<4>().0;
        let halves = self.blocks.as_flattened_mut().as_chunks_mut::<4>().0;
        for (to, from) in halves.iter_mut().zip(velocities).take(n.div_ceil(4)) {
            *to = *from;
        }
    }

    /// out = y + Σ (h a_l) k_l.
    #[inline(always)]
    pub(super) fn combine(out: &mut Self, y: &Self, k: &[Self; SLOTS], h: f64, row: &[(usize, f64)]) {
        combine(out, y, k, h, row);
    }

    /// out = h Σ d_l k_l.
    #[inline(always)]
    pub(super) fn weigh(out: &mut Self, k: &[Self; SLOTS], h: f64, row: &[(usize, f64)]) {
        weigh(out, k, h, row);
    }

    /// Σ (e/size)², e = Σ e_l k_l, size = atol + rtol max(|y|, |y1|), in the order of the components.
    #[inline(always)]
    pub(super) fn squares(ends: [&Self; 2], k: &[Self; SLOTS], atol: &Self, rtol: f64, row: &[(usize, f64)]) -> f64 {
        squares(ends, k, atol, rtol, row)
    }

    /// Σ |y|, lane by lane.
    #[inline(always)]
    pub(super) fn size(&self) -> f64 {
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

#[inline(always)]
fn combine(out: &mut Blocks, y: &Blocks, k: &[Blocks; SLOTS], h: f64, row: &[(usize, f64)]) {
    out.arch.dispatch(Combine { out, y, k, h, row });
}

#[inline(never)]
fn weigh(out: &mut Blocks, k: &[Blocks; SLOTS], h: f64, row: &[(usize, f64)]) {
    out.arch.dispatch(Weigh { out: &mut out.blocks, k, h, row });
}

#[inline(never)]
fn squares([y, y1]: [&Blocks; 2], k: &[Blocks; SLOTS], atol: &Blocks, rtol: f64, row: &[(usize, f64)]) -> f64 {
    y.arch.dispatch(Squares { y: &y.blocks, y1: &y1.blocks, k, atol: &atol.blocks, rtol, row, len: y.len })
}

/// Σ a_l k_l in block b, the coefficients taken `times`.
#[inline(always)]
fn sum(k: &[Blocks; SLOTS], b: usize, times: f64, row: &[(usize, f64)]) -> Block {
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

struct Combine<'a> {
    out: &'a mut Blocks,
    y: &'a Blocks,
    k: &'a [Blocks; SLOTS],
    h: f64,
    row: &'a [(usize, f64)],
}

impl WithSimd for Combine<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (b, (out, y)) in self.out.blocks.iter_mut().zip(&self.y.blocks).enumerate() {
            let (mut sum, y) = (sum(self.k, b, self.h, self.row), *y);
            for i in 0..WIDTH {
                sum[i] = y[i] + sum[i];
            }
            *out = sum;
        }
    }
}

struct Weigh<'a> {
    out: &'a mut [Block],
    k: &'a [Blocks; SLOTS],
    h: f64,
    row: &'a [(usize, f64)],
}

impl WithSimd for Weigh<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (b, out) in self.out.iter_mut().enumerate() {
            let mut sum = sum(self.k, b, 1.0, self.row);
            for s in &mut sum {
                *s *= self.h;
            }
            *out = sum;
        }
    }
}

struct Squares<'a> {
    y: &'a [Block],
    y1: &'a [Block],
    k: &'a [Blocks; SLOTS],
    atol: &'a [Block],
    rtol: f64,
    row: &'a [(usize, f64)],
    len: usize,
}

impl WithSimd for Squares<'_> {
    type Output = f64;
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let (mut total, mut left) = (0.0, self.len);
        for (b, ((y, y1), atol)) in self.y.iter().zip(self.y1).zip(self.atol).enumerate() {
            let mut sum = sum(self.k, b, 1.0, self.row);
            for i in 0..WIDTH {
                let e = sum[i] / (atol[i] + self.rtol * y[i].abs().max(y1[i].abs()));
                sum[i] = e * e;
            }
            // Past the length stands 0/0.
            for s in &sum[..left.min(WIDTH)] {
                total += s;
            }
            left = left.saturating_sub(WIDTH);
        }
        total
    }
}
