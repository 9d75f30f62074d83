//! The numbers that the algebra of a model runs on.

use std::fmt::Debug;
use std::ops::Add;
use std::ops::Div;
use std::ops::Mul;
use std::ops::Neg;
use std::ops::Sub;

/// A number, a dual number or a bundle of lanes: what a model's algebra needs and no more.
///
/// There is no comparison, since a branch on a lane would be a bug; [`step`](Scalar::step) is the branch-free way to say
/// "in contact". There is no fused multiply-add, so that every processor gives the same bits. Powers, exponentials and sines are those of
/// [`libm`], for every scalar and on every processor; on a plain `f64` outside of generic code, `x.exp()` is the method of `f64` itself, with
/// the bits of the platform.
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
    /// The smaller of two.
    fn min(self, other: Self) -> Self;
    /// The larger of two.
    fn max(self, other: Self) -> Self;
    /// 1 where x > 0 and 0 elsewhere.
    fn step(self) -> Self;
    /// x^p, not a number where x is negative and p is no whole number. The slope at 0 is 0 for p > 1 and 1 for p = 1.
    fn powf(self, p: f64) -> Self;
    /// e^x.
    fn exp(self) -> Self;
    /// The natural logarithm of x.
    fn ln(self) -> Self;
    /// sin x, x in radians.
    fn sin(self) -> Self;
    /// cos x, x in radians.
    fn cos(self) -> Self;
    /// Both at once, with the bits of each.
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
}

/// The index of a loop over the elements of a model, for algebra on [`Lanes`](crate::sweep::Lanes): it keeps the compiler from bundling elements
/// where it should bundle lanes, which gathers its numbers from far apart and is five times slower. It is the index itself, known to be in
/// range where it was, and changes no result.
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
}
