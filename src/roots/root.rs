//! Roots, and why there is none.

use crate::numeric::norms::largest;
use crate::roots::factors::Floating;
use crate::roots::matrix::Matrix;
use crate::roots::residual::Residual;
use thiserror::Error;

/// A root, with what it took.
///
/// ```
/// use gear_dynamics::roots::{Equations, Newton};
/// let root = Newton::new().solve(&mut Equations::new(1, |x, r| r[0] = x[0] * x[0] - 2.0), &[1.0])?;
/// assert!((root.x[0] - 2f64.sqrt()).abs() < 1e-9 && root.iterations < 10);
/// # Ok::<(), gear_dynamics::roots::RootError>(())
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
/// use gear_dynamics::roots::{Equations, Newton, RootError};
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
    pub(crate) fn start<R: Residual + ?Sized>(
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

    pub(crate) fn step_to(&mut self, x: &[f64], residual: f64) {
        self.x.copy_from_slice(x);
        self.residual = residual;
        self.history.push(residual);
        self.iterations += 1;
    }

    /// Why a Jacobian has no factors: a slope that is no number, or a free unknown.
    pub(crate) fn singular(self, Floating(unknown): Floating, jacobian: &Matrix) -> RootError {
        let last = Box::new(self);
        match jacobian.not_finite() {
            Some((equation, unknown, value)) => RootError::Slope { equation, unknown, value, last },
            None => RootError::Singular { unknown, last },
        }
    }

    /// No share of a correction helps; the last was tried with these residuals.
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

/// A share of the unknowns or of a correction.
pub(crate) fn check_share(name: &'static str, value: f64) -> Result<(), RootError> {
    if value > 0.0 && value < 1.0 {
        Ok(())
    } else {
        Err(RootError::Setting { name, value, allowed: "above 0 and below 1" })
    }
}
