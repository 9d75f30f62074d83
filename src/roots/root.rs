//! Roots of equations, and the errors of root finders.

use crate::error::{ParameterError, check};
use crate::numeric::norms::largest;
use crate::roots::factors::Floating;
use crate::roots::matrix::Matrix;
use crate::roots::residual::Residual;
use thiserror::Error;

/// A root, with its residual and the number of iterations.
///
/// ```
/// use gear_dynamics::roots::{Equations, Newton, RootFinder};
/// let root = Newton::new().solve(&mut Equations::new(1, |x, r| r[0] = x[0] * x[0] - 2.0), &[1.0])?;
/// assert!((root.x[0] - 2f64.sqrt()).abs() < 1e-9 && root.iterations < 10);
/// # Ok::<(), gear_dynamics::roots::RootError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Root {
    /// The root; in a [`RootError`] the last iterate.
    pub x: Vec<f64>,
    /// max |r_i| at `x`.
    pub residual: f64,
    /// Number of corrections.
    pub iterations: usize,
    /// Number of evaluations of the residual, without those for differences.
    pub evaluations: usize,
    /// max |r_i| of every iterate, the guess first.
    pub residuals: Vec<f64>,
}

/// Errors of root finders: [`Newton`](crate::roots::Newton), [`Broyden`](crate::roots::Broyden) and others.
///
/// ```
/// use gear_dynamics::roots::{Equations, Newton, RootError, RootFinder};
/// let error = Newton::new().solve(&mut Equations::new(1, |x, r| r[0] = x[0].exp()), &[0.0]).unwrap_err();
/// assert!(matches!(error, RootError::NotConverged { .. }));
/// let last = error.last().unwrap();
/// assert!(last.residuals[0] == 1.0 && last.iterations == 50 && last.x[0] < -39.0);
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RootError {
    /// A setting is not valid, the guess or a given first Jacobian has the wrong size, or there are no
    /// equations.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A residual is NaN or infinite: at the guess, after a step of Broyden's method, or after a step of
    /// Newton's method with the minimum damping.
    #[error("the residual of equation {equation} is not finite after {} iterations", last.iterations)]
    NotFinite {
        /// Index of the equation, from 0.
        equation: usize,
        /// The last iterate with finite residuals, or the guess.
        last: Box<Root>,
    },
    /// An entry of the Jacobian is NaN or infinite.
    #[error(
        "the slope of equation {equation} with respect to unknown {unknown} is {value:?} after {} iterations: \
         it must be a finite number",
        last.iterations
    )]
    Slope {
        /// Index of the equation, from 0.
        equation: usize,
        /// Index of the unknown, from 0.
        unknown: usize,
        /// The entry: NaN or infinite.
        value: f64,
        /// The last iterate.
        last: Box<Root>,
    },
    /// The Jacobian is singular.
    #[error(
        "the Jacobian is singular after {} iterations, where unknown {unknown} is {:?}: a change of it, with others, \
         changes no equation; start elsewhere, or add an equation that fixes it",
        last.iterations, last.x[*unknown]
    )]
    Singular {
        /// Index of the unknown with the largest share in the undetermined direction, from 0.
        unknown: usize,
        /// The last iterate.
        last: Box<Root>,
    },
    /// The maximum number of iterations is reached, or no damping is accepted.
    #[error(
        "no convergence: the largest residual is {:?} after {} iterations and {:?} at the guess",
        last.residual, last.iterations, last.residuals[0]
    )]
    NotConverged {
        /// The last iterate.
        last: Box<Root>,
    },
}

impl RootError {
    /// The last iterate, with the residuals of all iterates; `None` for `Parameter`.
    pub fn last(&self) -> Option<&Root> {
        match self {
            RootError::NotFinite { last, .. }
            | RootError::Slope { last, .. }
            | RootError::Singular { last, .. }
            | RootError::NotConverged { last } => Some(last),
            RootError::Parameter(_) => None,
        }
    }
}

impl Root {
    /// The guess as the first iterate of a [`RootFinder`](crate::roots::RootFinder). Writes its residual to
    /// `r`.
    ///
    /// # Errors
    /// [`RootError::Parameter`] if the guess has the wrong size or there are no equations,
    /// [`RootError::NotFinite`] if a residual is not finite.
    pub fn start(equations: &mut dyn Residual, guess: &[f64], r: &mut [f64]) -> Result<Self, RootError> {
        check::length("guess", guess.len(), equations.size())?;
        if guess.is_empty() {
            return Err(
                ParameterError::TooFew { name: "number of equations".into(), value: 0, min: 1 }.into()
            );
        }
        equations.residual(guess, r);
        let residual = largest(r);
        let root =
            Root { x: guess.to_vec(), residual, iterations: 0, evaluations: 1, residuals: vec![residual] };
        match r.iter().position(|r| !r.is_finite()) {
            Some(equation) => Err(RootError::NotFinite { equation, last: Box::new(root) }),
            None => Ok(root),
        }
    }

    /// Makes `x` the next iterate. Writes its residual to `r`.
    ///
    /// # Panics
    /// If `x` has another length than the guess, or `r` than the equations.
    pub fn step_to(&mut self, equations: &mut dyn Residual, x: &[f64], r: &mut [f64]) {
        equations.residual(x, r);
        self.evaluations += 1;
        self.accept(x, largest(r));
    }

    /// Makes `x` with the largest residual `residual` the next iterate.
    pub(crate) fn accept(&mut self, x: &[f64], residual: f64) {
        self.x.copy_from_slice(x);
        self.residual = residual;
        self.residuals.push(residual);
        self.iterations += 1;
    }

    /// The error for a Jacobian without factors: an entry is not finite, or an unknown is not determined.
    pub(crate) fn singular(self, Floating(unknown): Floating, jacobian: &Matrix) -> RootError {
        let last = Box::new(self);
        match jacobian.not_finite() {
            Some((equation, unknown, value)) => RootError::Slope { equation, unknown, value, last },
            None => RootError::Singular { unknown, last },
        }
    }

    /// The error if no damping is accepted. `tried`: residuals of the last trial.
    pub(crate) fn stuck(self, tried: &[f64]) -> RootError {
        match tried.iter().position(|r| !r.is_finite()) {
            Some(equation) => RootError::NotFinite { equation, last: Box::new(self) },
            None => self.not_converged(),
        }
    }

    pub(crate) fn not_converged(self) -> RootError {
        RootError::NotConverged { last: Box::new(self) }
    }
}
