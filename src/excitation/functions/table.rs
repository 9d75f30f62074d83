//! Excitations from samples.

use crate::error::{ParameterError, check};
use crate::excitation::angle::Angle;
use crate::excitation::excitation_trait::Excitation;
use crate::excitation::jet::Jet;
use crate::scalar::Scalar;
use std::f64::consts::TAU;

/// The periodic cubic spline through uniform samples of one turn, the first at φ = 0. It is twice
/// continuously differentiable.
///
/// The third derivative jumps at the samples. `Taylor` ends a step at each sample. The adaptive Runge-Kutta
/// methods do so, too, unless a step is longer than two spacings of the samples: its error may then exceed a
/// tight tolerance. A `max_step` of two spacings prevents this.
///
/// ```
/// use gear_dynamics::excitation::{Excitation, Table};
/// let samples: Vec<f64> = (0..64).map(|i| (i as f64 / 64.0 * std::f64::consts::TAU).cos()).collect();
/// let table = Table::new(&samples)?;
/// assert!((table.value(0.3) - 0.3f64.cos()).abs() < 1e-6);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    samples: Vec<f64>,
    /// Second derivatives at the knots, times the square of the spacing of the samples.
    moments: Vec<f64>,
}

impl Table {
    /// The spline through at least 3 samples.
    ///
    /// # Errors
    /// Fewer than 3 samples; one beyond ±1e50.
    pub fn new(samples: &[f64]) -> Result<Self, ParameterError> {
        if samples.len() < 3 {
            return Err(ParameterError::TooFew { name: "samples".into(), value: samples.len(), min: 3 });
        }
        check::quantities("samples", samples)?;
        let moments = periodic_moments(samples);
        Ok(Table { moments, samples: samples.to_vec() })
    }
}

/// Solves M_{i-1} + 4 M_i + M_{i+1} = 6 (y_{i-1} - 2 y_i + y_{i+1}) with cyclic indices, by the Thomas
/// algorithm with a Sherman-Morrison correction.   Source: de Boor, A Practical Guide to Splines, ch. IV.
fn periodic_moments(y: &[f64]) -> Vec<f64> {
    let n = y.len();
    let rhs: Vec<f64> = (0..n).map(|i| 6.0 * (y[(i + n - 1) % n] - 2.0 * y[i] + y[(i + 1) % n])).collect();
    // The cyclic matrix is T + c cᵀ with T tridiagonal and c = (1, 0, .., 0, 1). With T x = y and T z = c the
    // solution is x - z (cᵀx)/(1 + cᵀz).
    let mut diagonal = vec![4.0; n];
    diagonal[0] -= 1.0;
    diagonal[n - 1] -= 1.0;
    let mut corner = vec![0.0; n];
    corner[0] = 1.0;
    corner[n - 1] = 1.0;
    let x = thomas(&diagonal, &rhs);
    let z = thomas(&diagonal, &corner);
    let factor = (x[0] + x[n - 1]) / (1.0 + z[0] + z[n - 1]);
    x.iter().zip(&z).map(|(x, z)| x - factor * z).collect()
}

/// Solves a tridiagonal system with ones beside the diagonal.
fn thomas(diagonal: &[f64], rhs: &[f64]) -> Vec<f64> {
    let n = rhs.len();
    let (mut d, mut x) = (diagonal.to_vec(), rhs.to_vec());
    for i in 1..n {
        let w = 1.0 / d[i - 1];
        d[i] -= w;
        x[i] -= w * x[i - 1];
    }
    x[n - 1] /= d[n - 1];
    for i in (0..n - 1).rev() {
        x[i] = (x[i] - x[i + 1]) / d[i];
    }
    x
}

impl Table {
    /// The piece of the spline after knot i, at the share s of the spacing, for every number type.
    #[inline(always)]
    fn piece<S: Scalar>(&self, i: usize, s: S) -> Jet<S> {
        let n = self.samples.len();
        let (j, per, one) = ((i + 1) % n, n as f64 / TAU, S::from(1.0));
        let (y0, y1, m0, m1) = (self.samples[i], self.samples[j], self.moments[i], self.moments[j]);
        let r = one - s;
        let sixth = |x: S| x / S::from(6.0);
        Jet::new(
            r * y0 + s * y1 + sixth((r * r * r - r) * m0 + (s * s * s - s) * m1),
            (S::from(y1 - y0) + sixth((s * 3.0 * s - one) * m1 - (r * 3.0 * r - one) * m0)) * per,
            (r * m0 + s * m1) * (per * per),
        )
    }
}

impl Excitation for Table {
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
        // The third derivative jumps at the knots.
        angle.by_parts(self.samples.len(), |i, s| self.piece(i, s))
    }
    fn knots(&self) -> Vec<f64> {
        let per = TAU / self.samples.len() as f64;
        (0..self.samples.len()).map(|i| i as f64 * per).collect()
    }
}
