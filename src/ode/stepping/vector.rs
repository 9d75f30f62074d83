//! Storage for coordinates and velocities, and the sums over derivatives that a step consists of.

use crate::contact::Piece;
use crate::model::Model;
use crate::ode::stepping::tableau_row::{SLOTS, TableauRow};
use crate::ode::stepping::vector_blocks::Blocks;
use std::fmt;

/// The algebra of a model at one instant.
#[derive(Clone, Copy)]
pub struct Algebra<'a> {
    pub(super) model: &'a dyn Model,
    /// The piece of every contact; `None`: by deflection.
    pub(super) pieces: Option<&'a [Piece]>,
    /// The drives.
    pub(super) u: &'a [f64],
}

impl fmt::Debug for Algebra<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Algebra").field("pieces", &self.pieces).field("u", &self.u).finish_non_exhaustive()
    }
}

impl<'a> Algebra<'a> {
    /// On the given pieces if `FIXED`, else by deflection.
    #[inline(always)]
    pub(super) fn of<const FIXED: bool>(model: &'a dyn Model, pieces: &'a [Piece], u: &'a [f64]) -> Self {
        Algebra { model, pieces: if FIXED { Some(pieces) } else { None }, u }
    }
    /// Writes the accelerations at these coordinates and velocities.
    #[inline(always)]
    fn write(self, q: &[f64], v: &[f64], a: &mut [f64]) {
        match self.pieces {
            Some(pieces) => self.model.accel_on_pieces(pieces, self.u, q, v, a),
            None => self.model.accel(self.u, q, v, a),
        }
    }
}

/// Storage for coordinates and velocities: an array for one and two degrees of freedom, so that a step is
/// computed in registers, and [`Blocks`] for more.
pub trait Vector: Clone {
    /// Number of fixed steps, at most 4, whose drives are evaluated at once. Steps of one and two degrees of
    /// freedom are so short that the processor evaluates the next drives while it waits for the stages.
    const AHEAD: usize;

    /// A vector of zeros.
    fn zeros(len: usize) -> Self;
    /// A derivative of zeros.
    fn slot(len: usize) -> Self {
        Self::zeros(len)
    }
    /// The components.
    fn slice(&self) -> &[f64];
    /// The components, mutable.
    fn slice_mut(&mut self) -> &mut [f64];
    /// Copies or swaps `from` into `to`, whichever costs less. The content of `from` is not defined
    /// afterwards.
    fn hand_over(from: &mut Self, to: &mut Self);

    /// out = (v, a) at y = (q, v).
    fn derivative(out: &mut Self, y: &Self, of: Algebra<'_>);
    /// k_s = (v, a) at the stage y + Σ (h a_l) k_l, a sum over earlier slots.
    fn stage<const L: usize>(
        k: &mut [Self; SLOTS],
        s: usize,
        y: &Self,
        h: f64,
        row: &TableauRow<L>,
        of: Algebra<'_>,
    );
    /// out = y + Σ (h a_l) k_l. The products h a_l do not depend on k, so that only few operations follow the
    /// computation of the last k.
    fn combine<const L: usize>(out: &mut Self, y: &Self, k: &[Self; SLOTS], h: f64, row: &TableauRow<L>);
    /// out = h Σ d_l k_l.
    fn weigh<const L: usize>(out: &mut Self, k: &[Self; SLOTS], h: f64, row: &TableauRow<L>);
    /// Σ_j (e_j/size_j)² with e_j = Σ_l e_l k_lj and size_j = atol_j + rtol max(|y_j|, |y1_j|), for each row.
    fn squares<const L: usize, const R: usize>(
        ends: [&Self; 2],
        k: &[Self; SLOTS],
        atol: &Self,
        rtol: f64,
        rows: [&TableauRow<L>; R],
    ) -> [f64; R];
    /// Σ |y_j|, in any order.
    fn size(&self) -> f64;
}

impl<const M: usize> Vector for [f64; M] {
    const AHEAD: usize = 1;

    fn zeros(_: usize) -> Self {
        [0.0; M]
    }
    #[inline(always)]
    fn slice(&self) -> &[f64] {
        self
    }
    #[inline(always)]
    fn slice_mut(&mut self) -> &mut [f64] {
        self
    }
    #[inline(always)]
    fn hand_over(from: &mut Self, to: &mut Self) {
        *to = *from;
    }
    #[inline(always)]
    fn derivative(out: &mut Self, y: &Self, of: Algebra<'_>) {
        let (q, v) = y.split_at(M / 2);
        // The model writes numbers one by one. Read back one by one they are there at once; as a vector with
        // the velocities beside them they are not. One number stays in a register.
        let mut a = [f64::NAN; M];
        if let ([q], [v]) = (q, v) {
            a[0] = of.model.accel_of_one(of.pieces, of.u, *q, *v);
        } else {
            of.write(q, v, &mut a[..M / 2]);
        }
        *out = std::array::from_fn(|j| if j < M / 2 { v[j] } else { a[j - M / 2] });
    }
    #[inline(always)]
    fn stage<const L: usize>(
        k: &mut [Self; SLOTS],
        s: usize,
        y: &Self,
        h: f64,
        row: &TableauRow<L>,
        of: Algebra<'_>,
    ) {
        let mut stage = [0.0; M];
        Self::combine(&mut stage, y, k, h, row);
        Self::derivative(&mut k[s], &stage, of);
    }

    #[inline(always)]
    fn combine<const L: usize>(out: &mut Self, y: &Self, k: &[Self; SLOTS], h: f64, row: &TableauRow<L>) {
        let a: [f64; L] = std::array::from_fn(|l| h * row[l].1);
        for j in 0..M {
            let mut sum = a[0] * k[row[0].0][j];
            for l in 1..L {
                sum += a[l] * k[row[l].0][j];
            }
            out[j] = y[j] + sum;
        }
    }
    fn weigh<const L: usize>(out: &mut Self, k: &[Self; SLOTS], h: f64, row: &TableauRow<L>) {
        for j in 0..M {
            out[j] = h * row.iter().map(|&(i, d)| d * k[i][j]).sum::<f64>();
        }
    }
    #[inline(always)]
    fn squares<const L: usize, const R: usize>(
        [y, y1]: [&Self; 2],
        k: &[Self; SLOTS],
        atol: &Self,
        rtol: f64,
        rows: [&TableauRow<L>; R],
    ) -> [f64; R] {
        let mut sums = [0.0; R];
        for (sum, row) in sums.iter_mut().zip(rows) {
            for j in 0..M {
                let mut e = row[0].1 * k[row[0].0][j];
                for l in 1..L {
                    e += row[l].1 * k[row[l].0][j];
                }
                let size = atol[j] + rtol * y[j].abs().max(y1[j].abs());
                *sum += (e / size) * (e / size);
            }
        }
        sums
    }
    #[inline(always)]
    fn size(&self) -> f64 {
        self.iter().map(|y| y.abs()).sum()
    }
}

impl Vector for Blocks {
    const AHEAD: usize = 4;

    fn zeros(len: usize) -> Self {
        Blocks::zeros(len)
    }
    fn slot(len: usize) -> Self {
        Blocks::slot(len)
    }
    #[inline(always)]
    fn slice(&self) -> &[f64] {
        self.slice()
    }
    #[inline(always)]
    fn slice_mut(&mut self) -> &mut [f64] {
        self.slice_mut()
    }
    #[inline(always)]
    fn hand_over(from: &mut Self, to: &mut Self) {
        from.hand_over(to);
    }
    #[inline(always)]
    fn derivative(out: &mut Self, y: &Self, of: Algebra<'_>) {
        let n = y.slice().len() / 2;
        out.take_velocities(y);
        let (q, v) = y.slice().split_at(n);
        of.write(q, v, &mut out.slice_mut()[n..]);
    }
    #[inline(always)]
    fn stage<const L: usize>(
        k: &mut [Self; SLOTS],
        s: usize,
        y: &Self,
        h: f64,
        row: &TableauRow<L>,
        of: Algebra<'_>,
    ) {
        let (earlier, later) = k.split_at_mut(s);
        later[0].stage(y, earlier, h, row);
        let (q, v, a) = later[0].parts();
        of.write(q, v, a);
    }

    #[inline(always)]
    fn combine<const L: usize>(out: &mut Self, y: &Self, k: &[Self; SLOTS], h: f64, row: &TableauRow<L>) {
        Blocks::combine(out, y, k, h, row);
    }
    #[inline(always)]
    fn weigh<const L: usize>(out: &mut Self, k: &[Self; SLOTS], h: f64, row: &TableauRow<L>) {
        Blocks::weigh(out, k, h, row);
    }
    #[inline(always)]
    fn squares<const L: usize, const R: usize>(
        ends: [&Self; 2],
        k: &[Self; SLOTS],
        atol: &Self,
        rtol: f64,
        rows: [&TableauRow<L>; R],
    ) -> [f64; R] {
        Blocks::squares(ends, k, atol, rtol, rows)
    }
    #[inline(always)]
    fn size(&self) -> f64 {
        self.size()
    }
}
