//! Where a run keeps coordinates and velocities.

/// Storage for coordinates and velocities: an array where the model is small, so that a step lives in registers.
pub trait Vector: Clone {
    /// All zero.
    fn zeros(len: usize) -> Self;
    /// Its components.
    fn slice(&self) -> &[f64];
    /// Its components, to be written.
    fn slice_mut(&mut self) -> &mut [f64];
    /// Whether a local of this type stays in registers.
    const LOCAL: bool;
    /// Makes `to` what `from` is, the cheapest way; `from` may be anything afterwards.
    fn hand_over(from: &mut Self, to: &mut Self);
}

impl<const L: usize> Vector for [f64; L] {
    const LOCAL: bool = true;

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
    fn hand_over(from: &mut Self, to: &mut Self) {
        *to = *from;
    }
}

impl Vector for Vec<f64> {
    const LOCAL: bool = false;

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
    fn hand_over(from: &mut Self, to: &mut Self) {
        std::mem::swap(from, to);
    }
}
