//! Vector numbers: one value for each of several runs.
#![allow(
    clippy::needless_range_loop,
    reason = "index loops over arrays become vector instructions, iterators do not"
)]

use crate::scalar::Scalar;
use crate::sweep::lanes::instructions::InstructionSet;
use pulp::WithSimd;
use std::ops::Add;
use std::ops::Div;
use std::ops::Mul;
use std::ops::Neg;
use std::ops::Sub;

/// W numbers side by side: one value for each of W runs. The compiler turns operations on them into vector
/// instructions. Each lane has the same bits as a computation with `f64`.
///
/// ```
/// use gear_dynamics::{model::Scalar, sweep::bounds::Lanes};
/// fn dead_zone<S: Scalar>(x: S) -> S { (x - S::from(1.0)).max(S::from(0.0)) }
/// assert_eq!(dead_zone(Lanes([0.5, 1.5, 2.0, -3.0])), Lanes([0.0, 0.5, 1.0, 0.0]));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Lanes<const W: usize>(pub [f64; W]);

impl<const W: usize> From<f64> for Lanes<W> {
    #[inline(always)]
    fn from(x: f64) -> Self {
        Lanes([x; W])
    }
}

impl<const W: usize> Add for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, o: Self) -> Self {
        for i in 0..W {
            self.0[i] += o.0[i];
        }
        self
    }
}

impl<const W: usize> Sub for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, o: Self) -> Self {
        for i in 0..W {
            self.0[i] -= o.0[i];
        }
        self
    }
}

impl<const W: usize> Mul for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, o: Self) -> Self {
        for i in 0..W {
            self.0[i] *= o.0[i];
        }
        self
    }
}

impl<const W: usize> Mul<f64> for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, o: f64) -> Self {
        for i in 0..W {
            self.0[i] *= o;
        }
        self
    }
}

impl<const W: usize> Div for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn div(mut self, o: Self) -> Self {
        for i in 0..W {
            self.0[i] /= o.0[i];
        }
        self
    }
}

impl<const W: usize> Neg for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        for i in 0..W {
            self.0[i] = -self.0[i];
        }
        self
    }
}

impl<const W: usize> Scalar for Lanes<W> {
    #[inline(always)]
    fn sqrt(mut self) -> Self {
        for i in 0..W {
            self.0[i] = self.0[i].sqrt();
        }
        self
    }
    #[inline(always)]
    fn abs(mut self) -> Self {
        for i in 0..W {
            self.0[i] = self.0[i].abs();
        }
        self
    }
    #[inline(always)]
    fn min(mut self, other: Self) -> Self {
        for i in 0..W {
            self.0[i] = Scalar::min(self.0[i], other.0[i]);
        }
        self
    }
    #[inline(always)]
    fn max(mut self, other: Self) -> Self {
        for i in 0..W {
            self.0[i] = Scalar::max(self.0[i], other.0[i]);
        }
        self
    }
    #[inline(always)]
    fn step(mut self) -> Self {
        for i in 0..W {
            self.0[i] = Scalar::step(self.0[i]);
        }
        self
    }
    #[inline(always)]
    fn powf(mut self, p: f64) -> Self {
        for i in 0..W {
            self.0[i] = Scalar::powf(self.0[i], p);
        }
        self
    }
    #[inline(always)]
    fn exp(mut self) -> Self {
        for i in 0..W {
            self.0[i] = Scalar::exp(self.0[i]);
        }
        self
    }
    #[inline(always)]
    fn ln(mut self) -> Self {
        for i in 0..W {
            self.0[i] = Scalar::ln(self.0[i]);
        }
        self
    }
    #[inline(always)]
    fn sin(mut self) -> Self {
        for i in 0..W {
            self.0[i] = Scalar::sin(self.0[i]);
        }
        self
    }
    #[inline(always)]
    fn cos(mut self) -> Self {
        for i in 0..W {
            self.0[i] = Scalar::cos(self.0[i]);
        }
        self
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (mut sin, mut cos) = (self, self);
        for i in 0..W {
            (sin.0[i], cos.0[i]) = Scalar::sin_cos(self.0[i]);
        }
        (sin, cos)
    }
}

/// A scalar with access to its single lanes: the operations that statistics need besides the algebra.
pub(crate) trait Number: Scalar {
    /// Number of lanes.
    const WIDTH: usize;
    /// A number with so few lanes that several of them fit into the vector registers.
    type Part: Number;
    /// Number of parts that together contain all lanes.
    const PARTS: usize;
    /// Part number `part` (from 0) of the lanes, as a narrower number of `Part::WIDTH` lanes. Positions past
    /// the last lane are zero.
    fn part(&self, part: usize) -> Self::Part;
    fn lane(&self, lane: usize) -> f64;
    fn set_lane(&mut self, lane: usize, value: f64);
    /// In each lane `yes` if a > b, else `no`.
    fn if_above(a: Self, b: Self, yes: Self, no: Self) -> Self;
    /// Runs an operation on these numbers that is compiled for an instruction set. Plain numbers have one.
    fn run<O: WithSimd>(set: InstructionSet, operation: O) -> O::Output;
}

impl Number for f64 {
    const WIDTH: usize = 1;
    type Part = f64;
    const PARTS: usize = 1;
    #[inline(always)]
    fn part(&self, _: usize) -> f64 {
        *self
    }
    #[inline(always)]
    fn lane(&self, _: usize) -> f64 {
        *self
    }
    #[inline(always)]
    fn set_lane(&mut self, _: usize, value: f64) {
        *self = value;
    }
    #[inline(always)]
    fn if_above(a: Self, b: Self, yes: Self, no: Self) -> Self {
        if a > b { yes } else { no }
    }
    #[inline(always)]
    fn run<O: WithSimd>(_: InstructionSet, operation: O) -> O::Output {
        operation.with_simd(pulp::Scalar::new())
    }
}

impl<const W: usize> Number for Lanes<W> {
    const WIDTH: usize = W;
    type Part = Lanes<8>;
    const PARTS: usize = W.div_ceil(8);
    #[inline(always)]
    fn part(&self, part: usize) -> Lanes<8> {
        let mut out = [0.0; 8];
        if W.is_multiple_of(8) {
            out.copy_from_slice(&self.0[8 * part..][..8]);
        } else {
            out.iter_mut().zip(&self.0[8 * part..]).for_each(|(x, lane)| *x = *lane);
        }
        Lanes(out)
    }
    #[inline(always)]
    fn lane(&self, lane: usize) -> f64 {
        self.0[lane]
    }
    #[inline(always)]
    fn set_lane(&mut self, lane: usize, value: f64) {
        self.0[lane] = value;
    }
    #[inline(always)]
    fn if_above(a: Self, b: Self, yes: Self, no: Self) -> Self {
        let mut out = [0.0; W];
        for i in 0..W {
            out[i] = if a.0[i] > b.0[i] { yes.0[i] } else { no.0[i] };
        }
        Lanes(out)
    }
    #[inline(always)]
    fn run<O: WithSimd>(set: InstructionSet, operation: O) -> O::Output {
        set.run(operation)
    }
}
