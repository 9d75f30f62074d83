//! Equations and their Jacobians.

use crate::numeric::norms::largest;
use crate::roots::factors::Factors;
use crate::roots::matrix::Matrix;

/// Equations r(x) = 0, as many as unknowns. `self` may contain working arrays.
///
/// ```
/// use gear_dynamics::roots::{Matrix, Newton, Residual, RootFinder};
/// struct Circle; // x² + y² = 1, x = y
/// impl Residual for Circle {
///     fn size(&self) -> usize { 2 }
///     fn residual(&mut self, x: &[f64], r: &mut [f64]) {
///         r.copy_from_slice(&[x[0] * x[0] + x[1] * x[1] - 1.0, x[0] - x[1]]);
///     }
///     fn jacobian(&mut self, x: &[f64], out: &mut Matrix) {
///         out.column_mut(0).copy_from_slice(&[2.0 * x[0], 1.0]);
///         out.column_mut(1).copy_from_slice(&[2.0 * x[1], -1.0]);
///     }
/// }
/// let root = Newton::new().solve(&mut Circle, &[1.0, 0.5])?;
/// assert!((root.x[0] - 0.5f64.sqrt()).abs() < 1e-9);
/// # Ok::<(), gear_dynamics::roots::RootError>(())
/// ```
pub trait Residual {
    /// Number of unknowns.
    fn size(&self) -> usize;
    /// Writes r(x) to `r`.
    fn residual(&mut self, x: &[f64], r: &mut [f64]);
    /// An empty Jacobian with the blocks that are not zero. Default: dense.
    ///
    /// # Panics
    /// The default panics for more than 65 536 unknowns, see [`Matrix::dense`]. Implement the method for
    /// larger equations.
    fn matrix(&self) -> Matrix {
        Matrix::dense(self.size())
    }
    /// Writes ∂r_i/∂x_j to every stored entry. Default: [`differences`].
    fn jacobian(&mut self, x: &[f64], out: &mut Matrix) {
        differences(self, x, out);
    }
}

/// Equations given by a closure. Their Jacobian is computed by differences.
///
/// ```
/// use gear_dynamics::roots::{Broyden, Equations, RootFinder};
/// let root = Broyden::new().solve(&mut Equations::new(1, |x, r| r[0] = x[0] - x[0].cos()), &[0.5])?;
/// assert!((root.x[0] - 0.739_085_133_215).abs() < 1e-10);
/// # Ok::<(), gear_dynamics::roots::RootError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Equations<F> {
    size: usize,
    residual: F,
}

impl<F: FnMut(&[f64], &mut [f64])> Equations<F> {
    /// Equations in `size` unknowns; `residual(x, r)` writes r(x) to `r`.
    pub fn new(size: usize, residual: F) -> Self {
        Equations { size, residual }
    }
}

impl<F: FnMut(&[f64], &mut [f64])> Residual for Equations<F> {
    fn size(&self) -> usize {
        self.size
    }
    fn residual(&mut self, x: &[f64], r: &mut [f64]) {
        (self.residual)(x, r);
    }
}

/// Writes the Jacobian of any equations by central differences to every stored entry.
///
/// It costs two residuals per unknown, and its relative error is about 1e-10 for residuals that are exact to
/// rounding: Newton's method then converges linearly with that factor. A root at which the Jacobian is nearly
/// singular is found less accurately.
///
/// ```
/// use gear_dynamics::roots::{Equations, Matrix, differences};
/// let mut jacobian = Matrix::dense(1);
/// differences(&mut Equations::new(1, |x, r| r[0] = x[0].exp()), &[0.0], &mut jacobian);
/// assert!((jacobian.column(0)[0] - 1.0).abs() < 1e-9);
/// ```
pub fn differences<R: Residual + ?Sized>(equations: &mut R, x: &[f64], out: &mut Matrix) {
    let n = equations.size();
    let size = Some(largest(x)).filter(|&size| size > 0.0).unwrap_or(1.0);
    let (mut moved, mut plus, mut minus) = (x.to_vec(), vec![0.0; n], vec![0.0; n]);
    for j in 0..n {
        // ε^(1/3) balances truncation and rounding of a central difference.
        let h = 6e-6 * x[j].abs().max(1e-2 * size);
        moved[j] = x[j] + h;
        equations.residual(&moved, &mut plus);
        moved[j] = x[j] - h;
        equations.residual(&moved, &mut minus);
        moved[j] = x[j];
        out.set_column(j, |i| (plus[i] - minus[i]) / (2.0 * h));
    }
}

/// Whether x is a root: |r_i| <= `bound` Σ_j |J_ij| for all i and, if J is not singular, |J⁻¹ r| <= `bound`.
///
/// J is the Jacobian at x and is written to `jacobian`. A Jacobian at another place may be so much larger
/// that every correction by it is small.
pub(crate) fn is_root(
    equations: &mut dyn Residual,
    x: &[f64],
    r: &[f64],
    bound: f64,
    jacobian: &mut Matrix,
) -> bool {
    equations.jacobian(x, jacobian);
    let mut reach = vec![0.0; r.len()];
    jacobian.each(|row, _, slope| reach[row] += slope.abs());
    // A comparison with NaN is false.
    if !r.iter().zip(&reach).all(|(r, reach)| r.abs() <= bound * reach) {
        return false;
    }
    let Ok(factors) = Factors::new(jacobian) else {
        return true;
    };
    let mut correction = r.to_vec();
    factors.solve(&mut correction);
    largest(&correction) <= bound
}
