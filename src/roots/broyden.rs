//! Broyden's methods.

use crate::numeric::norms::{dot, largest};
use crate::roots::factors::Factors;
use crate::roots::matrix::Matrix;
use crate::roots::residual::{Residual, is_root, jacobian_of};
use crate::roots::root::{Root, RootError, check_share};

/// The Jacobian that Broyden's method starts from.
///
/// ```
/// use gear_dynamics::roots::{Broyden, Equations, FirstJacobian};
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
    /// The equations' own at the guess, by differences if they offer none.
    Own,
    /// Given, as that of a linearised problem.
    Given(Matrix),
}

/// Broyden's method: J is corrected by rank one so that it explains the last step.
///
/// good: B ← B + (s - B y) sᵀB/(sᵀB y),   bad: B ← B + (s - B y) yᵀ/(yᵀy),   B = J⁻¹, s = Δx, y = Δr
///
/// Source: Broyden 1965; Kelley, Iterative Methods for Linear and Nonlinear Equations, ch. 7. The solver of Liu 2021.
///
/// A small step does not prove a root: a B that has become too small makes every step small. The last iterate is therefore judged by the
/// equations' own Jacobian there, or by differences; where that asks for a larger correction, iterations go on from it.
///
/// ```
/// use gear_dynamics::roots::{Broyden, Equations};
/// let mut equations = Equations::new(2, |x, r| { r[0] = x[0] + 0.1 * x[1] * x[1] - 1.0; r[1] = x[1] - 0.2 * x[0]; });
/// let root = Broyden::new().solve(&mut equations, &[0.0, 0.0])?;
/// assert!((root.x[0] - 5.0 * root.x[1]).abs() < 1e-11);
/// # Ok::<(), gear_dynamics::roots::RootError>(())
/// ```
#[derive(Clone, Debug)]
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
    /// The good method from the identity, to a correction of 1e-10 of the largest unknown in at most 300 iterations, never restarted.
    pub fn new() -> Self {
        Broyden {
            tolerance: 1e-10,
            max_iterations: 300,
            restart: usize::MAX,
            bad: false,
            first: FirstJacobian::Identity,
        }
    }
    /// The bad method.
    pub fn bad(self) -> Self {
        Broyden { bad: true, ..self }
    }
    /// The Jacobian to start from.
    pub fn first(self, first: FirstJacobian) -> Self {
        Broyden { first, ..self }
    }
    /// The same for equations of another size, which a given Jacobian does not fit: their own takes its place.
    pub(crate) fn resized(self) -> Self {
        let first = if let FirstJacobian::Given(_) = self.first { FirstJacobian::Own } else { self.first };
        Broyden { first, ..self }
    }
    /// Forget all updates after this many.
    pub fn restart(self, restart: usize) -> Self {
        Broyden { restart, ..self }
    }
    /// The size of the last correction, as a share of the largest unknown of the guess or the iterate. The correction that the equations' own
    /// Jacobian at the root asks for is held to the same size.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Broyden { tolerance, ..self }
    }
    /// The limit on iterations.
    pub fn max_iterations(self, max_iterations: usize) -> Self {
        Broyden { max_iterations, ..self }
    }

    /// Solves from a guess.
    ///
    /// # Errors
    /// [`RootError`], with the last iterate.
    pub fn solve<R: Residual + ?Sized>(&self, equations: &mut R, guess: &[f64]) -> Result<Root, RootError> {
        check_share("tolerance", self.tolerance)?;
        if self.restart == 0 {
            return Err(RootError::Setting { name: "restart", value: 0.0, allowed: "at least 1" });
        }
        let n = equations.size();
        let mut r = vec![0.0; n];
        let mut root = Root::start(equations, guess, &mut r)?;
        let mut jacobian = match &self.first {
            FirstJacobian::Given(matrix) if matrix.size() != n => {
                return Err(RootError::Length { expected: n, found: matrix.size() });
            }
            FirstJacobian::Given(matrix) => Some(matrix.clone()),
            FirstJacobian::Own => {
                let mut matrix = equations.matrix();
                jacobian_of(equations, guess, &mut matrix);
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
            root.step_to(&x, largest(&r));
            if size <= bound {
                let matrix = jacobian.get_or_insert_with(|| equations.matrix());
                if root.residual == 0.0 || is_root(equations, &x, &r, bound, matrix) {
                    return Ok(root);
                }
                // The updates have gone astray: they begin anew from the Jacobian here.
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

/// B = J⁻¹ as the factors of the first J and a list of rank-one updates.
struct Inverse {
    factors: Option<Factors>,
    bad: bool,
    /// good: B ← (I + a bᵀ) B;   bad: B ← B + a bᵀ.
    updates: Vec<(Vec<f64>, Vec<f64>)>,
}

impl Inverse {
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

    fn update(&mut self, s: Vec<f64>, y: &[f64]) {
        let mut by = y.to_vec();
        self.apply(&mut by);
        let denominator = if self.bad { dot(y, y) } else { dot(&s, &by) };
        if denominator == 0.0 {
            return; // nothing to be learnt from this step
        }
        let a = s.iter().zip(&by).map(|(s, b)| (s - b) / denominator).collect();
        self.updates.push((a, if self.bad { y.to_vec() } else { s }));
    }
}
