//! Roots of nonlinear equations.

mod blocks;
mod broyden;
mod factors;
mod matrix;
mod newton;

pub use broyden::{Broyden, FirstJacobian};
pub(crate) use factors::{Factors, Floating};
pub use matrix::Matrix;
pub use newton::Newton;

use thiserror::Error;

/// Equations r(x) = 0, as many as unknowns. Working arrays may live in `self`.
///
/// ```
/// use gear_dynamics::{Matrix, Newton, Residual};
/// struct Circle; // x² + y² = 1, x = y
/// impl Residual for Circle {
///     fn size(&self) -> usize { 2 }
///     fn residual(&mut self, x: &[f64], r: &mut [f64]) {
///         r.copy_from_slice(&[x[0] * x[0] + x[1] * x[1] - 1.0, x[0] - x[1]]);
///     }
///     fn jacobian(&mut self, x: &[f64], out: &mut Matrix) -> bool {
///         out.column_mut(0).copy_from_slice(&[2.0 * x[0], 1.0]);
///         out.column_mut(1).copy_from_slice(&[2.0 * x[1], -1.0]);
///         true
///     }
/// }
/// let root = Newton::new().solve(&mut Circle, &[1.0, 0.5])?;
/// assert!((root.x[0] - 0.5f64.sqrt()).abs() < 1e-9);
/// # Ok::<(), gear_dynamics::RootError>(())
/// ```
pub trait Residual {
    /// Number of unknowns.
    fn size(&self) -> usize;
    /// r(x).
    fn residual(&mut self, x: &[f64], r: &mut [f64]);
    /// An empty Jacobian of the right pattern; dense unless said otherwise.
    ///
    /// # Panics
    /// As it stands for more than 65 536 unknowns, see [`Matrix::dense`]: equations as large as that have a pattern of their own.
    fn matrix(&self) -> Matrix {
        Matrix::dense(self.size())
    }
    /// ∂r_i/∂x_j into every stored entry. `false`: not offered, differences are used.
    fn jacobian(&mut self, x: &[f64], out: &mut Matrix) -> bool {
        let _ = (x, out);
        false
    }
}

/// Equations given by a closure, with differences for a Jacobian.
///
/// ```
/// use gear_dynamics::{Broyden, Equations};
/// let root = Broyden::new().solve(&mut Equations::new(1, |x, r| r[0] = x[0] - x[0].cos()), &[0.5])?;
/// assert!((root.x[0] - 0.739_085_133_215).abs() < 1e-10);
/// # Ok::<(), gear_dynamics::RootError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Equations<F> {
    size: usize,
    residual: F,
}

impl<F: FnMut(&[f64], &mut [f64])> Equations<F> {
    /// `residual(x, r)` in `size` unknowns.
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

/// The Jacobian of any equations: their own, or central differences.
pub(crate) fn jacobian_of<R: Residual + ?Sized>(equations: &mut R, x: &[f64], out: &mut Matrix) {
    if equations.jacobian(x, out) {
        return;
    }
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

/// Whether x is a root: |J⁻¹ r| <= `bound` with the Jacobian of this very place, which `jacobian` then holds. A Jacobian taken elsewhere may be
/// so much larger that every correction looks small. Where J is singular, |r_i| <= `bound` Σ_j |J_ij| decides alone.
pub(crate) fn is_root<R: Residual + ?Sized>(
    equations: &mut R,
    x: &[f64],
    r: &[f64],
    bound: f64,
    jacobian: &mut Matrix,
) -> bool {
    jacobian_of(equations, x, jacobian);
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

/// aᵀ b.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// max |x_i|; NaN if one of them is.
pub(crate) fn largest(x: &[f64]) -> f64 {
    let any_nan = x.iter().any(|x| x.is_nan());
    if any_nan { f64::NAN } else { x.iter().map(|x| x.abs()).fold(0.0, |m, x| if x > m { x } else { m }) }
}

/// A root, with what it took.
///
/// ```
/// use gear_dynamics::{Equations, Newton};
/// let root = Newton::new().solve(&mut Equations::new(1, |x, r| r[0] = x[0] * x[0] - 2.0), &[1.0])?;
/// assert!((root.x[0] - 2f64.sqrt()).abs() < 1e-9 && root.iterations < 10);
/// # Ok::<(), gear_dynamics::RootError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Root {
    /// The root.
    pub x: Vec<f64>,
    /// max |r_i| there.
    pub residual: f64,
    /// Corrections made.
    pub iterations: usize,
    /// Residuals evaluated, those of differences not counted.
    pub evaluations: usize,
    /// max |r_i| at every iterate, the guess first.
    pub history: Vec<f64>,
}

/// Why no root is returned. The last iterate is handed back.
///
/// ```
/// use gear_dynamics::{Equations, Newton, RootError};
/// let error = Newton::new().solve(&mut Equations::new(1, |x, r| r[0] = x[0].exp()), &[0.0]).unwrap_err();
/// assert!(matches!(error, RootError::NotConverged { .. }));
/// assert!(error.last().is_some_and(|last| last.history[0] == 1.0 && last.iterations == 50 && last.x[0] < -39.0));
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RootError {
    /// A guess of the wrong length.
    #[error("the guess has {found} unknowns: the equations have {expected}")]
    Length {
        /// Unknowns of the equations.
        expected: usize,
        /// Entries of the guess.
        found: usize,
    },
    /// No equations.
    #[error("there are no equations: at least one is needed")]
    Empty,
    /// A setting that cannot be used.
    #[error("{name} is {value}: it must be {allowed}")]
    Setting {
        /// Which one.
        name: &'static str,
        /// What it was.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A residual that is not a number at the guess, or so far out that no shorter step helped.
    #[error("equation {equation} is not finite after {} iterations", last.iterations)]
    NotFinite {
        /// Which equation.
        equation: usize,
        /// The last iterate that was good, or the guess.
        last: Box<Root>,
    },
    /// A slope that is not a number.
    #[error("the slope of equation {equation} in unknown {unknown} is {value} after {} iterations", last.iterations)]
    Slope {
        /// Which equation.
        equation: usize,
        /// Which unknown.
        unknown: usize,
        /// NaN or an infinity.
        value: f64,
        /// The iterate.
        last: Box<Root>,
    },
    /// A Jacobian that leaves an unknown free.
    #[error("the Jacobian is singular after {} iterations: nothing holds unknown {unknown}", last.iterations)]
    Singular {
        /// The unknown that takes the largest part in the free motion.
        unknown: usize,
        /// The iterate.
        last: Box<Root>,
    },
    /// The limit on iterations, or no descent.
    #[error("no convergence: the largest residual is {} after {} iterations, {} at the guess", last.residual, last.iterations, last.history[0])]
    NotConverged {
        /// The last iterate.
        last: Box<Root>,
    },
}

impl RootError {
    /// The last iterate, with the history of residuals.
    pub fn last(&self) -> Option<&Root> {
        match self {
            RootError::NotFinite { last, .. }
            | RootError::Slope { last, .. }
            | RootError::Singular { last, .. }
            | RootError::NotConverged { last } => Some(last),
            _ => None,
        }
    }
}

impl Root {
    /// The guess, checked.
    fn start<R: Residual + ?Sized>(
        equations: &mut R,
        guess: &[f64],
        r: &mut [f64],
    ) -> Result<Self, RootError> {
        if guess.len() != equations.size() {
            return Err(RootError::Length { expected: equations.size(), found: guess.len() });
        }
        if guess.is_empty() {
            return Err(RootError::Empty);
        }
        equations.residual(guess, r);
        let residual = largest(r);
        let root =
            Root { x: guess.to_vec(), residual, iterations: 0, evaluations: 1, history: vec![residual] };
        match r.iter().position(|r| !r.is_finite()) {
            Some(equation) => Err(RootError::NotFinite { equation, last: Box::new(root) }),
            None => Ok(root),
        }
    }

    fn step_to(&mut self, x: &[f64], residual: f64) {
        self.x.copy_from_slice(x);
        self.residual = residual;
        self.history.push(residual);
        self.iterations += 1;
    }

    /// Why a Jacobian has no factors: a slope that is no number, or a free unknown.
    fn singular(self, Floating(unknown): Floating, jacobian: &Matrix) -> RootError {
        let last = Box::new(self);
        match jacobian.not_finite() {
            Some((equation, unknown, value)) => RootError::Slope { equation, unknown, value, last },
            None => RootError::Singular { unknown, last },
        }
    }

    /// No share of a correction helps; the last was tried with these residuals.
    fn stuck(self, tried: &[f64]) -> RootError {
        match tried.iter().position(|r| !r.is_finite()) {
            Some(equation) => RootError::NotFinite { equation, last: Box::new(self) },
            None => self.not_converged(),
        }
    }

    fn not_converged(self) -> RootError {
        RootError::NotConverged { last: Box::new(self) }
    }
}

/// A share of the unknowns or of a correction.
fn check_share(name: &'static str, value: f64) -> Result<(), RootError> {
    if value > 0.0 && value < 1.0 {
        Ok(())
    } else {
        Err(RootError::Setting { name, value, allowed: "above 0 and below 1" })
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_number_that_is_none_is_the_largest_wherever_it_stands() {
        for at in 0..3 {
            let mut x = [1.0, -2.0, 0.5];
            assert_eq!(super::largest(&x), 2.0);
            x[at] = f64::NAN;
            assert!(super::largest(&x).is_nan());
        }
    }
}
