//! Recurrences of quotients, roots, powers, exponentials, logarithms, sines and cosines.
//!
//! Source: Jorba & Zou, A software package for the numerical integration of ODEs by means of high-order
//! Taylor methods, Experimental Mathematics 14 (2005), Prop. 2.1.

use crate::scalar::Scalar;
use crate::tape::operations::{Guard, Op, Parity};

/// A function with the columns that it reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Function {
    Quotient(u32, u32),
    Sqrt(u32),
    Power(u32, f64, Parity),
    Exp(u32),
    Ln(u32),
    /// The cosine is the column after the sine.
    SinCos(u32),
}

impl Function {
    /// The same function of the columns that `actual` gives for its own.
    pub(super) fn redirected(self, actual: &[u32]) -> Self {
        let to = |column: u32| actual[column as usize];
        match self {
            Function::Quotient(a, b) => Function::Quotient(to(a), to(b)),
            Function::Sqrt(a) => Function::Sqrt(to(a)),
            Function::Power(a, p, parity) => Function::Power(to(a), p, parity),
            Function::Exp(a) => Function::Exp(to(a)),
            Function::Ln(a) => Function::Ln(to(a)),
            Function::SinCos(a) => Function::SinCos(to(a)),
        }
    }
}

/// A function in a plan.
#[derive(Debug)]
pub(crate) struct Placed {
    /// The function with its columns, and with those on the present pieces.
    pub(super) source: Function,
    pub(super) function: Function,
    pub(super) guard: Option<Guard>,
    /// Whether the contacts stand on the pieces of the guard.
    pub(super) active: bool,
    /// Whether the result depends on a root or a power.
    pub(super) of_power: bool,
    /// Result column.
    pub(super) out: usize,
}

/// The smallest number whose reciprocal square is finite: it replaces 0 below a power with a negative
/// exponent.
const TINY: f64 = 1e-150;

/// The coefficients of all orders, one row for each order.
pub(super) struct Grid<'x> {
    pub(super) x: &'x mut [f64],
    pub(super) width: usize,
}

impl Grid<'_> {
    #[inline(always)]
    fn at(&self, order: usize, column: u32) -> f64 {
        self.x[order * self.width + column as usize]
    }
    /// Σ weight(j) a_j b_(n-j) over j in `orders`.
    #[inline(always)]
    fn sum(
        &self,
        orders: std::ops::RangeInclusive<usize>,
        n: usize,
        a: u32,
        b: u32,
        weight: impl Fn(f64) -> f64,
    ) -> f64 {
        orders.map(|j| weight(j as f64) * self.at(j, a) * self.at(n - j, b)).sum()
    }
}

impl Placed {
    /// Whether the function is singular where its operand is 0.
    pub(crate) fn is_singular_at_zero(&self) -> bool {
        matches!(
            self.function,
            Function::Sqrt(_) | Function::Power(..) | Function::Ln(_) | Function::Quotient(..)
        )
    }
    /// Whether the function is a root or a power: finite at 0, without a series there.
    pub(crate) fn is_power(&self) -> bool {
        matches!(self.function, Function::Sqrt(_) | Function::Power(..))
    }
    /// What happens where its operand is 0.
    pub(crate) fn name(&self) -> &'static str {
        match self.function {
            Function::Quotient(..) => Op::DIVISION,
            Function::Sqrt(_) => "the square root of 0",
            Function::Power(..) => "a power of 0",
            Function::Ln(_) => Op::LOGARITHM,
            Function::Exp(_) | Function::SinCos(_) => "a function",
        }
    }

    /// Writes order n of the result. `frozen`: what depends on roots and powers keeps its value, without
    /// further orders.
    pub(super) fn order(&self, n: usize, grid: &mut Grid<'_>, frozen: bool) {
        let out = self.out as u32;
        let nth = n as f64;
        let mut second = None;
        let value = if !self.active {
            0.0
        } else if n == 0 {
            match self.function {
                Function::Quotient(a, b) => grid.at(0, a) / grid.at(0, b),
                Function::Sqrt(a) => grid.at(0, a).sqrt(),
                Function::Power(a, p, parity) => {
                    let base = grid.at(0, a);
                    let size = if parity == Parity::Plain { base } else { base.abs() };
                    let size = if size == 0.0 && p < 0.0 { TINY } else { size };
                    let sign = if parity == Parity::Odd && base < 0.0 { -1.0 } else { 1.0 };
                    sign * if p == 0.5 { size.sqrt() } else { libm::pow(size, p) }
                }
                Function::Exp(a) => libm::exp(grid.at(0, a)),
                Function::Ln(a) => libm::log(grid.at(0, a)),
                Function::SinCos(a) => {
                    let (sin, cos) = Scalar::sin_cos(grid.at(0, a));
                    second = Some(cos);
                    sin
                }
            }
        } else if frozen && self.of_power {
            0.0
        } else {
            match self.function {
                Function::Quotient(a, b) => {
                    (grid.at(n, a) - grid.sum(0..=n - 1, n, out, b, |_| 1.0)) / grid.at(0, b)
                }
                Function::Sqrt(a) => {
                    let inner = if n > 1 { grid.sum(1..=n - 1, n, out, out, |_| 1.0) } else { 0.0 };
                    (grid.at(n, a) - inner) / (2.0 * grid.at(0, out))
                }
                Function::Power(a, p, _) => {
                    grid.sum(1..=n, n, a, out, |j| j * (p + 1.0) - nth) / (nth * grid.at(0, a))
                }
                Function::Exp(a) => grid.sum(1..=n, n, a, out, |j| j) / nth,
                Function::Ln(a) => {
                    let inner = if n > 1 { grid.sum(1..=n - 1, n, out, a, |j| j) } else { 0.0 };
                    (grid.at(n, a) - inner / nth) / grid.at(0, a)
                }
                Function::SinCos(a) => {
                    second = Some(-grid.sum(1..=n, n, a, out, |j| j) / nth);
                    grid.sum(1..=n, n, a, out + 1, |j| j) / nth
                }
            }
        };
        let row = n * grid.width + self.out;
        grid.x[row] = value;
        if let Function::SinCos(_) = self.function {
            grid.x[row + 1] = second.unwrap_or(0.0);
        }
    }
}
