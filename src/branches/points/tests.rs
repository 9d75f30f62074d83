//! Test functions: their signs change at bifurcations.

use crate::periodic::multipliers::Multipliers;
use num_complex::Complex64;

/// A multiplier whose imaginary part is below this share of its absolute value counts as real.
const REAL: f64 = 1e-12;

fn is_real(m: &Complex64) -> bool {
    m.im.abs() <= REAL * m.norm()
}

/// Π (1 + μ_i)/√(1 + |μ_i|²): vanishes at a period doubling.
pub(crate) fn doubling(multipliers: &Multipliers) -> f64 {
    let factor = |m: &Complex64| (1.0 + m) / (1.0 + m.norm_sqr()).sqrt();
    multipliers.values().iter().map(factor).product::<Complex64>().re
}

/// Number of real multipliers below -1.
pub(crate) fn below(multipliers: &Multipliers) -> usize {
    multipliers.values().iter().filter(|m| is_real(m) && m.re < -1.0).count()
}

/// Number of multipliers outside the unit circle.
pub(crate) fn outside(multipliers: &Multipliers) -> usize {
    multipliers.values().iter().filter(|m| m.norm() > 1.0).count()
}

/// Number of complex multipliers outside the unit circle.
pub(crate) fn pairs_outside(multipliers: &Multipliers) -> usize {
    multipliers.values().iter().filter(|m| !is_real(m) && m.norm() > 1.0).count()
}

/// |μ|² - 1 of the complex pair nearest to the unit circle: vanishes at a Neimark-Sacker point. `None`
/// without a complex pair.
pub(crate) fn torus(multipliers: &Multipliers) -> Option<f64> {
    let complex = multipliers.values().iter().filter(|m| !is_real(m));
    complex.map(|m| m.norm_sqr() - 1.0).min_by(|a, b| a.abs().total_cmp(&b.abs()))
}
