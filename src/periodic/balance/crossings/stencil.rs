//! Sixteen samples around a cell: local polynomials, and quadrature weights for a kink inside the cell.

use crate::numeric::lagrange::lagrange;
use crate::numeric::search::bracket::Bracket;
use num_complex::Complex64;
use std::sync::LazyLock;

/// Number of samples of a stencil. The nodes are y = -15/2, ..., 15/2 in units of the sampling step; the cell
/// is -1/2 < y < 1/2.
pub(crate) const NODES: usize = 16;

/// Bernoulli numbers B_2, B_4, ..., B_16.   Source: Abramowitz & Stegun, Table 23.2.
const BERNOULLI: [f64; 8] = [
    1.0 / 6.0,
    -1.0 / 30.0,
    1.0 / 42.0,
    -1.0 / 30.0,
    5.0 / 66.0,
    -691.0 / 2730.0,
    7.0 / 6.0,
    -3617.0 / 510.0,
];

/// Lagrange polynomials on the nodes.
pub(crate) struct Stencil {
    /// `basis[i][m]`: coefficient of y^m in the polynomial that is 1 at node i.
    basis: [[f64; NODES]; NODES],
}

impl Stencil {
    /// The shared instance.
    pub(crate) fn get() -> &'static Self {
        static STENCIL: LazyLock<Stencil> = LazyLock::new(Stencil::new);
        &STENCIL
    }

    fn new() -> Self {
        Stencil { basis: lagrange(std::array::from_fn(|i| i as f64 - 7.5)) }
    }

    /// Index of the sample at node i of the stencil of a cell. The samples are periodic.
    #[inline]
    pub(crate) fn index(cell: usize, i: usize, samples: usize) -> usize {
        (cell + i + samples - 7) % samples
    }

    /// Polynomial through the samples around a cell.
    pub(crate) fn polynomial(&self, cell: usize, samples: usize, value: impl Fn(usize) -> f64) -> Polynomial {
        let mut p = [0.0; NODES];
        for (i, basis) in self.basis.iter().enumerate() {
            let f = value(Self::index(cell, i, samples));
            p.iter_mut().zip(basis).for_each(|(p, b)| *p += f * b);
        }
        Polynomial(p)
    }

    /// ∫_φ^∞ g dy = Σ_{y_i > 0} g(y_i) + Σ_i w_i g(y_i): weights w_i of the Euler-Maclaurin formula with the
    /// lower limit φ, for smooth g.
    pub(crate) fn weights(&self, phi: f64) -> [f64; NODES] {
        // Σ_i w_i y_i^m = (B_{m+1}(1/2) - φ^{m+1})/(m + 1), with B_n(1/2) = (2^{1-n} - 1) B_n, which is 0 for
        // odd n.
        let mut moments = [0.0; NODES];
        let mut power = 1.0;
        for (m, moment) in moments.iter_mut().enumerate() {
            power *= phi;
            let half = if m % 2 == 1 { (0.5f64.powi(m as i32) - 1.0) * BERNOULLI[m / 2] } else { 0.0 };
            *moment = (half - power) / (m as f64 + 1.0);
        }
        std::array::from_fn(|i| self.basis[i].iter().zip(&moments).map(|(b, e)| b * e).sum())
    }
}

/// Σ_m p_m y^m.
#[derive(Clone, Copy)]
pub(crate) struct Polynomial([f64; NODES]);

impl Polynomial {
    /// Value and derivative.
    pub(crate) fn at(&self, y: f64) -> (f64, f64) {
        self.0.iter().rev().fold((0.0, 0.0), |(p, d), c| (p * y + c, d * y + p))
    }

    fn derivative(&self) -> Self {
        let mut d = [0.0; NODES];
        for m in 1..NODES {
            d[m - 1] = m as f64 * self.0[m];
        }
        Polynomial(d)
    }

    /// Root between a and b by Newton's method, with bisection where a step leaves the bracket. If the values
    /// at a and b have the same sign, the end with the smaller absolute value.
    pub(crate) fn root(&self, a: f64, b: f64) -> f64 {
        let (fa, fb) = (self.at(a).0, self.at(b).0);
        if fa * fb > 0.0 {
            return if fa.abs() < fb.abs() { a } else { b };
        }
        let guess = a + (b - a) * if fa == fb { 0.5 } else { fa / (fa - fb) };
        Bracket { lo: a, hi: b }.solve(guess, fa < 0.0, |_| 1e-16, |y| self.at(y))
    }

    /// Root of the derivative inside the cell; `None` if the derivative has the same sign at both ends.
    pub(crate) fn extreme(&self) -> Option<f64> {
        let d = self.derivative();
        (d.at(-0.5).0 * d.at(0.5).0 < 0.0).then(|| d.root(-0.5, 0.5))
    }
}

/// e^{-i k x} for k = 0, 1, ..., by repeated multiplication. The error grows like k ε.
pub(crate) struct Phasors {
    z: Complex64,
    turn: Complex64,
}

impl Phasors {
    pub(crate) fn new(x: f64) -> Self {
        let (sin, cos) = libm::sincos(x);
        Phasors { z: Complex64::ONE, turn: Complex64::new(cos, -sin) }
    }
}

impl Iterator for Phasors {
    type Item = Complex64;
    #[inline]
    fn next(&mut self) -> Option<Complex64> {
        let z = self.z;
        self.z = z * self.turn;
        Some(z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corrected sum agrees with ∫_φ^∞ of a smooth decaying function.
    #[test]
    fn sums_begin_between_nodes() {
        let stencil = Stencil::new();
        let g = |y: f64| (-(y * y) / 160.0).exp();
        // ∫_0^∞ exp(-y²/160) dy = √(160π)/2; the rest by Simpson.
        let tail = 0.5 * (160.0 * std::f64::consts::PI).sqrt();
        for phi in [-0.5, -0.31, 0.0, 0.2, 0.5] {
            let part: f64 = (0..1000)
                .map(|i| {
                    let (a, h) = (phi * i as f64 / 1000.0, phi / 1000.0);
                    h / 6.0 * (g(a) + 4.0 * g(a + 0.5 * h) + g(a + h))
                })
                .sum();
            let sum: f64 = (0..200).map(|i| g(i as f64 + 0.5)).sum();
            let w = stencil.weights(phi);
            let corrected = sum + (0..NODES).map(|i| w[i] * g(i as f64 - 7.5)).sum::<f64>();
            assert!((corrected - (tail - part)).abs() < 1e-13, "{phi}: {corrected} against {}", tail - part);
        }
    }
}
