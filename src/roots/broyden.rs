//! Broyden's methods.

use crate::error::{ParameterError, check};
use crate::numeric::norms::{dot, largest};
use crate::roots::factors::Factors;
use crate::roots::matrix::Matrix;
use crate::roots::residual::{Residual, is_root};
use crate::roots::root::{Root, RootError};
use crate::roots::root_finder::RootFinder;
use std::sync::Arc;

/// First Jacobian of [`Broyden`].
///
/// ```
/// use gear_dynamics::roots::{Broyden, Equations, FirstJacobian, RootFinder};
/// let mut equations = Equations::new(1, |x: &[f64], r: &mut [f64]| r[0] = 5.0 * x[0].sin() - 1.0);
/// let plain = Broyden::new().solve(&mut equations, &[0.3])?;
/// let informed = Broyden::new().first(FirstJacobian::Own).solve(&mut equations, &[0.3])?;
/// assert!(informed.iterations < plain.iterations);
/// # Ok::<(), gear_dynamics::roots::RootError>(())
/// ```
#[derive(Clone, Debug)]
pub enum FirstJacobian {
    /// The identity.
    Identity,
    /// The Jacobian of the equations at the guess, by differences if they provide none.
    Own,
    /// A given matrix, for example the Jacobian of a linearised problem.
    Given(Matrix),
}

/// Broyden's method: x ← x - B r, where B approximates J⁻¹ and receives a rank-one update after every step.
///
/// good: B ← B + (s - B y) sᵀB/(sᵀB y),   bad: B ← B + (s - B y) yᵀ/(yᵀy),   s = Δx, y = Δr
///
/// After either update B y = s.   Source: Broyden, Mathematics of Computation 19 (1965) 577; Kelley,
/// Iterative Methods for Linear and Nonlinear Equations, ch. 7. Liu 2021 uses this method.
///
/// A small step alone does not show that x is a root, because a B that has become too small makes every step
/// small. The last iterate is therefore tested with the Jacobian of the equations at that place, or with
/// differences. If this Jacobian requires a larger correction, the iteration continues with it in place of B.
///
/// ```
/// use gear_dynamics::roots::{Broyden, Equations, RootFinder};
/// let mut equations = Equations::new(2, |x, r| {
///     r[0] = x[0] + 0.1 * x[1] * x[1] - 1.0;
///     r[1] = x[1] - 0.2 * x[0];
/// });
/// let root = Broyden::new().solve(&mut equations, &[0.0, 0.0])?;
/// assert!((root.x[0] - 5.0 * root.x[1]).abs() < 1e-11);
/// # Ok::<(), gear_dynamics::roots::RootError>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct Broyden {
    tolerance: f64,
    max_iterations: usize,
    restart: usize,
    bad: bool,
    first: FirstJacobian,
}

impl Default for Broyden {
    fn default() -> Self {
        Broyden::new()
    }
}

impl Broyden {
    /// Defaults: the good method, the identity as first Jacobian, tolerance 1e-10, at most 300 iterations, no
    /// restart.
    pub fn new() -> Self {
        Broyden {
            tolerance: 1e-10,
            max_iterations: 300,
            restart: usize::MAX,
            bad: false,
            first: FirstJacobian::Identity,
        }
    }
    /// Uses the bad method. Default: the good method.
    pub fn bad(self) -> Self {
        Broyden { bad: true, ..self }
    }
    /// First Jacobian. Default: the identity.
    pub fn first(self, first: FirstJacobian) -> Self {
        Broyden { first, ..self }
    }
    /// Number of updates after which all updates are discarded, at least 1. Default: never.
    pub fn restart(self, restart: usize) -> Self {
        Broyden { restart, ..self }
    }
    /// Maximum of the last correction, as a share of the largest unknown of the guess or the iterate `[1]`,
    /// above 0 and below 1. It is also the maximum of the correction by the Jacobian of the equations at the
    /// root. Default: 1e-10.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Broyden { tolerance, ..self }
    }
    /// Maximum number of iterations. Default: 300.
    pub fn max_iterations(self, max_iterations: usize) -> Self {
        Broyden { max_iterations, ..self }
    }
}

impl RootFinder for Broyden {
    fn is_of_crate(&self) -> bool {
        true
    }
    /// A given first Jacobian does not fit another number of equations. Their own one replaces it.
    fn resized(&self) -> Option<Arc<dyn RootFinder>> {
        match self.first {
            FirstJacobian::Given(_) => Some(Arc::new(self.clone().first(FirstJacobian::Own))),
            FirstJacobian::Identity | FirstJacobian::Own => None,
        }
    }

    fn solve(&self, equations: &mut dyn Residual, guess: &[f64]) -> Result<Root, RootError> {
        check::share("tolerance", self.tolerance)?;
        if self.restart == 0 {
            return Err(ParameterError::TooFew { name: "restart".into(), value: 0, min: 1 }.into());
        }
        let n = equations.size();
        let mut r = vec![0.0; n];
        let mut root = Root::start(equations, guess, &mut r)?;
        let mut jacobian = match &self.first {
            FirstJacobian::Given(matrix) => {
                check::length("unknowns of the first Jacobian", matrix.size(), n)?;
                Some(matrix.clone())
            }
            FirstJacobian::Own => {
                let mut matrix = equations.matrix();
                equations.jacobian(guess, &mut matrix);
                Some(matrix)
            }
            FirstJacobian::Identity => None,
        };
        let factors = match jacobian
            .as_ref()
            .map(|matrix| Factors::new(matrix).map_err(|floating| (floating, matrix)))
            .transpose()
        {
            Ok(factors) => factors,
            Err((floating, matrix)) => return Err(root.singular(floating, matrix)),
        };
        let mut inverse = Inverse { factors, bad: self.bad, updates: Vec::new() };
        let first = largest(guess);
        let (mut x, mut next, mut change) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        while root.iterations < self.max_iterations {
            let mut step: Vec<f64> = r.iter().map(|r| -r).collect();
            inverse.apply(&mut step);
            x.iter_mut().zip(&root.x).zip(&step).for_each(|((x, x0), s)| *x = x0 + s);
            equations.residual(&x, &mut next);
            root.evaluations += 1;
            if let Some(equation) = next.iter().position(|r| !r.is_finite()) {
                return Err(RootError::NotFinite { equation, last: Box::new(root) });
            }
            change.iter_mut().zip(&next).zip(&r).for_each(|((y, n), r)| *y = n - r);
            std::mem::swap(&mut r, &mut next);
            let bound = self.tolerance * first.max(largest(&x));
            let size = largest(&step);
            root.accept(&x, largest(&r));
            if size <= bound {
                let matrix = jacobian.get_or_insert_with(|| equations.matrix());
                if root.residual == 0.0 || is_root(equations, &x, &r, bound, matrix) {
                    return Ok(root);
                }
                // B is too inaccurate: the iteration continues from the Jacobian at this iterate.
                inverse.factors = match Factors::new(matrix) {
                    Ok(factors) => Some(factors),
                    Err(floating) => return Err(root.singular(floating, matrix)),
                };
                inverse.updates.clear();
            } else if inverse.updates.len() >= self.restart {
                inverse.updates.clear();
            } else {
                inverse.update(step, &change);
            }
        }
        Err(root.not_converged())
    }
}

/// B as the factors of the first Jacobian and a list of rank-one updates.
struct Inverse {
    /// `None`: the identity.
    factors: Option<Factors>,
    bad: bool,
    /// good: B ← (I + a bᵀ) B;   bad: B ← B + a bᵀ.
    updates: Vec<(Vec<f64>, Vec<f64>)>,
}

impl Inverse {
    /// x ← B x.
    fn apply(&self, x: &mut [f64]) {
        let shares: Vec<f64> =
            if self.bad { self.updates.iter().map(|(_, b)| dot(b, x)).collect() } else { Vec::new() };
        if let Some(factors) = &self.factors {
            factors.solve(x);
        }
        for (i, (a, b)) in self.updates.iter().enumerate() {
            let share = if self.bad { shares[i] } else { dot(b, x) };
            x.iter_mut().zip(a).for_each(|(x, a)| *x += share * a);
        }
    }

    /// Adds the update for a step s and the change y of the residual.
    fn update(&mut self, s: Vec<f64>, y: &[f64]) {
        let mut by = y.to_vec();
        self.apply(&mut by);
        let denominator = if self.bad { dot(y, y) } else { dot(&s, &by) };
        if denominator == 0.0 {
            return; // the update is not defined
        }
        let a = s.iter().zip(&by).map(|(s, b)| (s - b) / denominator).collect();
        self.updates.push((a, if self.bad { y.to_vec() } else { s }));
    }
}
