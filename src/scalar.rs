//! The number types with which the algebra of a model is computed.

use crate::numeric::sine::turned;
use std::fmt::Debug;
use std::ops::Add;
use std::ops::Div;
use std::ops::Mul;
use std::ops::Neg;
use std::ops::Sub;

/// The operations of a number type in the algebra of a model. The types are `f64`,
/// [`Dual`](crate::model::Dual), [`Lanes`](crate::sweep::bounds::Lanes), [`Series`](crate::model::Series) and
/// [`Node`](crate::model::recording::Node).
///
/// - There are no comparisons, since the lanes of one number may differ in their result.
///   [`step`](Scalar::step) gives 1 in contact and 0 in the gap without a branch.
/// - There is no fused multiply-add, so that all processors compute the same bits.
/// - Powers, exponentials, logarithms, sines and cosines are those of [`libm`] for all types, for the same
///   reason. For an `f64` outside of generic code, `x.exp()` is the method of `f64` instead, whose bits
///   depend on the platform.
///
/// ```
/// use gear_dynamics::model::{Dual, Scalar};
/// fn cubic<S: Scalar>(x: S) -> S { x + x * x * x * 0.5 }
/// assert_eq!(cubic(2.0), 6.0);
/// assert_eq!(cubic(Dual::variable(2.0)).slope, [7.0]);
/// fn hertz<S: Scalar>(depth: S) -> S { depth.powf(1.5) }
/// assert_eq!((hertz(4.0), hertz(Dual::variable(4.0)).slope), (8.0, [3.0]));
/// ```
pub trait Scalar:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
    + From<f64>
{
    /// √x.
    fn sqrt(self) -> Self;
    /// |x|.
    fn abs(self) -> Self;
    /// The smaller of two numbers.
    fn min(self, other: Self) -> Self;
    /// The larger of two numbers.
    fn max(self, other: Self) -> Self;
    /// 1 if x > 0, 0 otherwise.
    fn step(self) -> Self;
    /// x^p; NaN if x is negative and p is not a whole number.
    ///
    /// At x = 0, its slope is 0 for p > 1 and 1 for p = 1.
    fn powf(self, p: f64) -> Self;
    /// |x|^p. Unlike `x.abs().powf(p)`, it has a Taylor series wherever x keeps its sign, for example on the
    /// flank of a contact: [`Taylor`](crate::Taylor) accepts it there.
    #[inline(always)]
    fn abs_powf(self, p: f64) -> Self {
        let size = self.abs();
        // For p = 1/2 (Hertz) a square root is much faster than a power.
        if p == 0.5 { size.sqrt() } else { size.powf(p) }
    }
    /// |x|^p with the sign of x. As one power it has derivatives at 0 that the product x |x|^(p-1) lacks in a
    /// Taylor series.
    #[inline(always)]
    fn signed_powf(self, p: f64) -> Self {
        self * self.abs_powf(p - 1.0)
    }
    /// (sin (x + y), cos (x + y)) from the sines and cosines of x and y.
    #[doc(hidden)]
    #[inline(always)]
    fn turned(of: (Self, Self), by: (Self, Self)) -> (Self, Self) {
        turned(of, by)
    }
    /// e^x.
    fn exp(self) -> Self;
    /// The natural logarithm of x.
    fn ln(self) -> Self;
    /// sin x, x in radians.
    fn sin(self) -> Self;
    /// cos x, x in radians.
    fn cos(self) -> Self;
    /// (sin x, cos x), with the same bits as [`sin`](Scalar::sin) and [`cos`](Scalar::cos).
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
    #[doc(hidden)]
    /// The value of a plain number. Default: `None`.
    fn plain(self) -> Option<f64> {
        None
    }
}

/// Returns `index` unchanged, for loops over the elements of a model in algebra on
/// [`Lanes`](crate::sweep::bounds::Lanes).
///
/// The call prevents the compiler from making vector instructions across the elements instead of across the
/// lanes. Those load their numbers from distant places in memory and are five times slower. Results and
/// bounds checks do not change.
///
/// ```
/// use gear_dynamics::model::{Scalar, keep_rolled};
/// fn sum<S: Scalar>(x: &[S]) -> S {
///     let mut sum = S::from(0.0);
///     for i in 0..x.len() {
///         sum = sum + x[keep_rolled(i)];
///     }
///     sum
/// }
/// assert_eq!(sum(&[1.0, 2.0]), 3.0);
/// ```
#[inline(always)]
pub fn keep_rolled(index: usize) -> usize {
    std::hint::black_box(());
    index
}

/// Whether x^p is computed as products, so that it has a series at x = 0: a whole power up to 64.
pub(crate) fn is_product(p: f64) -> bool {
    p.fract() == 0.0 && p.abs() <= 64.0
}

impl Scalar for f64 {
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn step(self) -> Self {
        if self > 0.0 { 1.0 } else { 0.0 }
    }
    #[inline(always)]
    fn powf(self, p: f64) -> Self {
        libm::pow(self, p)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        libm::exp(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        libm::log(self)
    }
    #[inline(always)]
    fn sin(self) -> Self {
        libm::sin(self)
    }
    #[inline(always)]
    fn cos(self) -> Self {
        libm::cos(self)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }
    fn plain(self) -> Option<f64> {
        Some(self)
    }
}
