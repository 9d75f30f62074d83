//! Newton's method, damped by the natural monotonicity test.

use crate::error::check;
use crate::numeric::norms::{dot, largest};
use crate::roots::factors::Factors;
use crate::roots::matrix::Matrix;
use crate::roots::residual::{Residual, is_root, jacobian_of};
use crate::roots::root::{Root, RootError};

/// Newton's method with damping: x ← x + λ Δx, J Δx = -r(x).
///
/// The damping λ satisfies the natural monotonicity test |J⁻¹ r(x + λ Δx)| <= (1 - λ/4) |Δx|. The test does
/// not depend on the scaling of the equations.
///
/// While each correction is at most half of the last one, the factors of J are kept and receive rank-one
/// updates from the last steps. The convergence with updates is superlinear.
///
/// If λ becomes very small, because J jumps, the iteration restarts from the guess. Corrections are then
/// halved until |r|₂ falls.
///
/// Source: Deuflhard, Newton Methods for Nonlinear Problems, Sects. 2.1.2, 2.1.4 and 3.3.
///
/// ```
/// use gear_dynamics::roots::{Equations, Newton};
/// // Without damping the iteration diverges from this guess.
/// let root = Newton::new().solve(&mut Equations::new(1, |x, r| r[0] = x[0].atan()), &[3.0])?;
/// assert!(root.x[0].abs() < 1e-9);
/// # Ok::<(), gear_dynamics::roots::RootError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Newton {
    tolerance: f64,
    max_iterations: usize,
}

impl Default for Newton {
    fn default() -> Self {
        Newton::new()
    }
}

/// Maximum ratio of a correction to the last one with which the factors are kept `[1]`.
const FAST: f64 = 0.5;

/// Minimum damping λ `[1]`.
const MIN_DAMPING: f64 = 1e-4;

impl Newton {
    /// Defaults: tolerance 1e-10, at most 50 iterations.
    pub fn new() -> Self {
        Newton { tolerance: 1e-10, max_iterations: 50 }
    }
    /// Maximum of the last correction, as a share of the largest unknown of the guess or the iterate `[1]`,
    /// above 0 and below 1. Default: 1e-10.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Newton { tolerance, ..self }
    }
    /// Maximum number of iterations. Default: 50.
    pub fn max_iterations(self, max_iterations: usize) -> Self {
        Newton { max_iterations, ..self }
    }

    /// Solves r(x) = 0 from a guess.
    ///
    /// # Errors
    /// [`RootError`]; [`RootError::last`] returns the last iterate.
    pub fn solve<R: Residual + ?Sized>(&self, equations: &mut R, guess: &[f64]) -> Result<Root, RootError> {
        check::share("tolerance", self.tolerance)?;
        let n = equations.size();
        let mut r = vec![0.0; n];
        let mut root = Root::start(equations, guess, &mut r)?;
        let mut matrix = equations.matrix();
        let first = largest(guess);
        let (mut x, mut step, mut next, mut trial) = (vec![0.0; n], vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let mut factors: Option<Factors> = None;
        let mut taken = Taken::default();
        // `None`: the natural monotonicity test decides on the damping.
        let mut descent: Option<Descent> = None;
        let mut crawled = 0;
        while root.iterations < self.max_iterations {
            let (kept, stale) = match factors.take() {
                // `step` is already the next correction, by the kept factors and their updates.
                Some(kept) => (kept, true),
                None => {
                    jacobian_of(equations, &root.x, &mut matrix);
                    let fresh = match Factors::new(&matrix) {
                        Ok(fresh) => fresh,
                        Err(floating) => return Err(root.singular(floating, &matrix)),
                    };
                    step.iter_mut().zip(&r).for_each(|(s, r)| *s = -r);
                    fresh.solve(&mut step);
                    taken.clear();
                    (fresh, false)
                }
            };
            let size = largest(&step);
            if !size.is_finite() {
                let unknown = step.iter().position(|s| !s.is_finite()).unwrap_or(0);
                return Err(root.singular(crate::roots::factors::Floating(unknown), &matrix));
            }
            let bound = self.tolerance * first.max(largest(&root.x));
            if let Some(descent) = descent.as_mut().filter(|_| size > bound) {
                if !descent.step(equations, &mut root, &r, &step, (&mut x, &mut trial)) {
                    return Err(root.stuck(&trial));
                }
                root.step_to(&x, largest(&trial));
                std::mem::swap(&mut r, &mut trial);
                continue;
            }
            let mut damping = 1.0;
            let contraction = loop {
                x.iter_mut().zip(&root.x).zip(&step).for_each(|((x, x0), s)| *x = x0 + damping * s);
                equations.residual(&x, &mut trial);
                root.evaluations += 1;
                let residual = largest(&trial);
                if residual.is_finite() {
                    // A correction within the tolerance needs no test of monotonicity.
                    if damping == 1.0
                        && size <= bound
                        && is_met(equations, &x, &trial, &step, bound, &mut matrix)
                    {
                        root.step_to(&x, residual);
                        return Ok(root);
                    }
                    next.iter_mut().zip(&trial).for_each(|(n, r)| *n = -r);
                    kept.solve(&mut next);
                    let contraction = largest(&next) / size;
                    if is_monotone(contraction, damping) {
                        break Some(contraction);
                    }
                    let bent = next
                        .iter()
                        .zip(&step)
                        .fold(0.0, |m: f64, (n, s)| m.max((n - (1.0 - damping) * s).abs()));
                    damping = (0.5 * damping).min(0.5 * damping * damping * size / bent);
                } else {
                    damping *= 0.5;
                }
                if stale {
                    break None;
                }
                if damping.is_nan() || damping < MIN_DAMPING {
                    break Some(f64::INFINITY);
                }
            };
            // The kept factors are too inaccurate: new ones are computed at the same iterate.
            let Some(contraction) = contraction else { continue };
            crawled = if damping < CRAWL { crawled + 1 } else { 0 };
            if contraction == f64::INFINITY || crawled == CRAWLS {
                // The linearisation is valid over tiny steps only, perhaps since the guess. The descent
                // therefore begins at the guess.
                if descent.is_some() {
                    return Err(root.stuck(&trial));
                }
                descent = Some(Descent::default());
                equations.residual(guess, &mut r);
                root.evaluations += 1;
                root.step_to(guess, largest(&r));
                continue;
            }
            root.step_to(&x, largest(&trial));
            std::mem::swap(&mut r, &mut trial);
            if damping == 1.0 {
                taken.push(&step);
                let serves = contraction <= FAST && taken.update(&mut next);
                // The next correction is an estimate of the remaining error.
                let near = largest(&next) <= bound;
                // If `size` is within the tolerance, the test was already made above.
                if near && size > bound && is_met(equations, &x, &r, &step, bound, &mut matrix) {
                    return Ok(root);
                }
                factors = (serves && !near).then_some(kept);
                std::mem::swap(&mut step, &mut next);
            }
        }
        Err(root.not_converged())
    }
}

/// Whether x is a root to `bound`. This is so if every |r_i| is at most half of Σ_j |J_ij s_j|, with the last
/// Jacobian J and the correction s that led to x, or if x satisfies [`is_root`] with the Jacobian at x.
fn is_met<R: Residual + ?Sized>(
    equations: &mut R,
    x: &[f64],
    r: &[f64],
    step: &[f64],
    bound: f64,
    jacobian: &mut Matrix,
) -> bool {
    let mut foreseen = vec![0.0; r.len()];
    jacobian.each(|row, column, slope| foreseen[row] += (slope * step[column]).abs());
    r.iter().zip(&foreseen).all(|(r, foreseen)| r.abs() <= FAST * foreseen)
        || is_root(equations, x, r, bound, jacobian)
}

/// The natural monotonicity test of a step with damping λ: |J⁻¹ r(x + λ s)| <= (1 - λ/4) |s|, with the
/// correction s and the Jacobian J at x. `contraction` is the ratio |J⁻¹ r(x + λ s)|/|s|.
///
/// Source: Deuflhard, Newton Methods for Nonlinear Problems, Sect. 3.3.
pub(crate) fn is_monotone(contraction: f64, damping: f64) -> bool {
    contraction <= 1.0 - 0.25 * damping
}

/// Damping by |r|₂, for a Jacobian that jumps, for example that of a sampled dead zone. The linearisation
/// ends at the jump, so that the natural monotonicity test accepts no damping or only tiny ones.
///
/// λ is halved until |r|₂ falls. If no λ achieves this, a step with λ <= 1/8 is accepted that leads to less
/// than the largest of the last five |r|₂.   Source: Grippo, Lampariello & Lucidi, SIAM J. Numer. Anal. 23
/// (1986) 707.
#[derive(Default)]
struct Descent {
    /// The last values of |r|₂²; a new one overwrites the oldest.
    last: [f64; WINDOW],
    steps: usize,
}

/// Steps with a smaller λ are counted `[1]`.
const CRAWL: f64 = 1.0 / 16.0;

/// Number of such steps in a row after which the descent begins.
const CRAWLS: usize = 4;

/// Number of the last values of |r|₂ that are kept.
const WINDOW: usize = 5;

/// Maximum λ of a step that does not reduce |r|₂ `[1]`.
const SHORT: f64 = 0.125;

impl Descent {
    /// Writes the next iterate to `x` and its residual to `trial`. `false`: no λ of at least
    /// [`MIN_DAMPING`] is accepted.
    fn step<R: Residual + ?Sized>(
        &mut self,
        equations: &mut R,
        root: &mut Root,
        r: &[f64],
        step: &[f64],
        (x, trial): (&mut [f64], &mut [f64]),
    ) -> bool {
        let here = dot(r, r);
        self.last[self.steps % WINDOW] = here;
        self.steps += 1;
        let most = self.last.iter().fold(0.0, |m: f64, x| m.max(*x));
        for (longest, below) in [(1.0, here), (SHORT, most)] {
            let mut share = longest;
            while share >= MIN_DAMPING {
                x.iter_mut().zip(&root.x).zip(step).for_each(|((x, x0), s)| *x = x0 + share * s);
                equations.residual(x, trial);
                root.evaluations += 1;
                if dot(trial, trial) < below {
                    return true;
                }
                share *= 0.5;
            }
        }
        false
    }
}

/// The steps made with the same factors.
#[derive(Default)]
struct Taken {
    /// One after the other.
    steps: Vec<f64>,
    /// Their squared lengths.
    squares: Vec<f64>,
}

impl Taken {
    fn clear(&mut self) {
        self.steps.clear();
        self.squares.clear();
    }

    fn push(&mut self, step: &[f64]) {
        self.steps.extend(step);
        self.squares.push(dot(step, step));
    }

    /// Replaces a correction by the kept factors with the correction after Broyden's good updates of the
    /// factors. `false`: it is more than half of the last one, and the factors are not kept.
    ///
    /// Source: Deuflhard, Newton Methods for Nonlinear Problems, Sect. 2.1.4, Algorithm QNERR.
    fn update(&self, correction: &mut [f64]) -> bool {
        let mut steps = self.steps.chunks_exact(correction.len()).zip(&self.squares).peekable();
        while let Some((step, square)) = steps.next() {
            let share = dot(correction, step) / square;
            match steps.peek() {
                Some((after, _)) => correction.iter_mut().zip(*after).for_each(|(c, s)| *c += share * s),
                None => {
                    // If Θ = |c|/|s| <= 1/2 before the last update, `share` is at most 1/2 and the divisor at
                    // least 1/2.
                    let serves = dot(correction, correction) <= FAST * FAST * square;
                    correction.iter_mut().for_each(|c| *c /= 1.0 - share);
                    return serves;
                }
            }
        }
        true
    }
}
