//! Where a run keeps coordinates and velocities.

/// Storage for coordinates and velocities: an array where the model is small, so that a step lives in registers.
pub trait Vector: Clone {
    /// All zero.
    fn zeros(len: usize) -> Self;
    /// Its components.
    fn slice(&self) -> &[f64];
    /// Its components, to be written.
    fn slice_mut(&mut self) -> &mut [f64];
    /// Something to write its new components to: an array is a local, which stays in registers; a vector is itself.
    fn lend(&mut self) -> Self;
    /// Takes back scratch that was lent: a local is forgotten.
    fn take_back(&mut self, lent: Self);
    /// Makes `to` what `from` is, the cheapest way; `from` may be anything afterwards.
    fn hand_over(from: &mut Self, to: &mut Self);
}

impl<const L: usize> Vector for [f64; L] {
    fn zeros(_: usize) -> Self {
        [0.0; L]
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
    fn lend(&mut self) -> Self {
        [0.0; L]
    }
    #[inline(always)]
    fn take_back(&mut self, _: Self) {}
    #[inline(always)]
    fn hand_over(from: &mut Self, to: &mut Self) {
        *to = *from;
    }
}

impl Vector for Vec<f64> {
    fn zeros(len: usize) -> Self {
        vec![0.0; len]
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
    fn lend(&mut self) -> Self {
        std::mem::take(self)
    }
    #[inline(always)]
    fn take_back(&mut self, lent: Self) {
        *self = lent;
    }
    #[inline(always)]
    fn hand_over(from: &mut Self, to: &mut Self) {
        std::mem::swap(from, to);
    }
}
