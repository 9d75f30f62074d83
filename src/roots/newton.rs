//! Newton's method, damped by the natural monotonicity test.

use crate::error::check;
use crate::numeric::norms::{dot, largest};
use crate::roots::factors::{Factors, Floating};
use crate::roots::matrix::Matrix;
use crate::roots::residual::{Residual, is_root};
use crate::roots::root::{Root, RootError};
use crate::roots::root_finder::RootFinder;

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
/// use gear_dynamics::roots::{Equations, Newton, RootFinder};
/// // Without damping the iteration diverges from this guess.
/// let root = Newton::new().solve(&mut Equations::new(1, |x, r| r[0] = x[0].atan()), &[3.0])?;
/// assert!(root.x[0].abs() < 1e-9);
/// # Ok::<(), gear_dynamics::roots::RootError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct Newton {
    pub(crate) tolerance: f64,
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
}

impl RootFinder for Newton {
    fn is_of_crate(&self) -> bool {
        true
    }
    fn solve(&self, equations: &mut dyn Residual, guess: &[f64]) -> Result<Root, RootError> {
        check::share("tolerance", self.tolerance)?;
        let mut at = Iterate::start(equations, guess)?;
        let first = largest(guess);
        // Factors of an earlier iterate: their updates gave the correction at this one.
        let mut earlier: Option<Factors> = None;
        // `None`: the natural monotonicity test decides on the damping.
        let mut descent: Option<Descent> = None;
        let mut crawled = 0;
        while at.root.iterations < self.max_iterations {
            let stale = earlier.is_some();
            let factors = match at.correct(earlier.take()) {
                Ok(factors) => factors,
                Err(floating) => return Err(at.root.singular(floating, &at.matrix)),
            };
            let bound = self.tolerance * first.max(largest(&at.root.x));
            if let Some(descent) = descent.as_mut().filter(|_| largest(&at.step) > bound) {
                if !descent.step(&mut at) {
                    return Err(at.root.stuck(&at.trial));
                }
                at.accept();
                continue;
            }
            let (damping, contraction) = match at.damped(&factors, stale, bound) {
                Damped::Root => return Ok(at.root),
                // New factors are computed at the same iterate.
                Damped::Inaccurate => continue,
                Damped::By { damping, contraction } => (damping, contraction),
            };
            crawled = if damping < CRAWL { crawled + 1 } else { 0 };
            if contraction == f64::INFINITY || crawled == CRAWLS {
                // The linearisation is valid over tiny steps only, perhaps since the guess. The descent
                // therefore begins at the guess.
                if descent.is_some() {
                    return Err(at.root.stuck(&at.trial));
                }
                descent = Some(Descent::default());
                at.restart(guess);
                continue;
            }
            at.accept();
            if damping == 1.0 {
                match at.update(contraction, bound) {
                    Updated::Root => return Ok(at.root),
                    Updated::Serves => earlier = Some(factors),
                    Updated::Fails => {}
                }
            }
        }
        Err(at.root.not_converged())
    }
}

/// An iterate, the correction there, and the point that is tried next.
struct Iterate<'e> {
    equations: &'e mut dyn Residual,
    matrix: Matrix,
    root: Root,
    /// r at the iterate.
    r: Vec<f64>,
    /// The correction s = -J⁻¹ r at the iterate.
    step: Vec<f64>,
    /// The point that is tried, x + λ s.
    x: Vec<f64>,
    /// r there.
    trial: Vec<f64>,
    /// -J⁻¹ r there, with J at the iterate.
    next: Vec<f64>,
    taken: Taken,
}

/// How far to go along a correction.
enum Damped {
    /// The point at λ = 1 is a root.
    Root,
    /// The kept factors are too inaccurate to decide.
    Inaccurate,
    /// The step goes from x to x + λ s, λ the `damping`. `contraction` is |J⁻¹ r(x + λ s)|/|s|; it is
    /// infinite if no λ is accepted.
    By { damping: f64, contraction: f64 },
}

/// What an update of the factors achieves.
enum Updated {
    /// The next correction is within the tolerance, and the iterate is a root.
    Root,
    /// The next correction is known.
    Serves,
    /// New factors are needed.
    Fails,
}

impl<'e> Iterate<'e> {
    fn start(equations: &'e mut dyn Residual, guess: &[f64]) -> Result<Self, RootError> {
        let zeros = vec![0.0; equations.size()];
        let mut r = zeros.clone();
        let root = Root::start(equations, guess, &mut r)?;
        let [step, x, trial, next] = std::array::from_fn(|_| zeros.clone());
        let (matrix, taken) = (equations.matrix(), Taken::default());
        Ok(Iterate { equations, matrix, root, r, step, x, trial, next, taken })
    }

    /// Computes factors and correction, unless both are kept. The error: an unknown without a correction.
    fn correct(&mut self, kept: Option<Factors>) -> Result<Factors, Floating> {
        let factors = match kept {
            Some(kept) => kept,
            None => {
                self.equations.jacobian(&self.root.x, &mut self.matrix);
                let fresh = Factors::new(&self.matrix)?;
                self.step.iter_mut().zip(&self.r).for_each(|(s, r)| *s = -r);
                fresh.solve(&mut self.step);
                self.taken.clear();
                fresh
            }
        };
        match self.step.iter().position(|s| !s.is_finite()) {
            Some(unknown) => Err(Floating(unknown)),
            None => Ok(factors),
        }
    }

    /// Evaluates r at x + λ s.
    fn try_at(&mut self, damping: f64) {
        let here = self.root.x.iter().zip(&self.step);
        self.x.iter_mut().zip(here).for_each(|(x, (x0, s))| *x = x0 + damping * s);
        self.equations.residual(&self.x, &mut self.trial);
        self.root.evaluations += 1;
    }

    /// Halves λ, or reduces it by the curvature of r, until the natural monotonicity test is met. `stale`
    /// factors are tried once.
    fn damped(&mut self, factors: &Factors, stale: bool, bound: f64) -> Damped {
        let (size, mut damping) = (largest(&self.step), 1.0);
        loop {
            self.try_at(damping);
            let residual = largest(&self.trial);
            if residual.is_finite() {
                // A correction within the tolerance needs no test of monotonicity.
                let Iterate { equations, x, trial, step, matrix, .. } = self;
                if damping == 1.0 && size <= bound && is_met(*equations, x, trial, step, bound, matrix) {
                    self.root.accept(&self.x, residual);
                    return Damped::Root;
                }
                self.next.iter_mut().zip(&self.trial).for_each(|(n, r)| *n = -r);
                factors.solve(&mut self.next);
                let contraction = largest(&self.next) / size;
                if is_monotone(contraction, damping) {
                    return Damped::By { damping, contraction };
                }
                let bent = self
                    .next
                    .iter()
                    .zip(&self.step)
                    .fold(0.0, |m: f64, (n, s)| m.max((n - (1.0 - damping) * s).abs()));
                damping = (0.5 * damping).min(0.5 * damping * damping * size / bent);
            } else {
                damping *= 0.5;
            }
            if stale {
                return Damped::Inaccurate;
            }
            if damping.is_nan() || damping < MIN_DAMPING {
                return Damped::By { damping, contraction: f64::INFINITY };
            }
        }
    }

    /// Goes to the point that was tried.
    fn accept(&mut self) {
        self.root.accept(&self.x, largest(&self.trial));
        std::mem::swap(&mut self.r, &mut self.trial);
    }

    /// Goes back to the guess.
    fn restart(&mut self, guess: &[f64]) {
        self.equations.residual(guess, &mut self.r);
        self.root.evaluations += 1;
        self.root.accept(guess, largest(&self.r));
    }

    /// After a whole step: the next correction by the factors of the last one and their updates.
    fn update(&mut self, contraction: f64, bound: f64) -> Updated {
        self.taken.push(&self.step);
        let serves = contraction <= FAST && self.taken.update(&mut self.next);
        // The next correction is an estimate of the remaining error.
        let near = largest(&self.next) <= bound;
        // With a step within the tolerance the test was made before.
        let Iterate { equations, x, r, step, matrix, .. } = self;
        if near && largest(step) > bound && is_met(*equations, x, r, step, bound, matrix) {
            return Updated::Root;
        }
        std::mem::swap(&mut self.step, &mut self.next);
        if serves && !near { Updated::Serves } else { Updated::Fails }
    }
}

/// Whether x is a root to `bound`. This is so if every |r_i| is at most half of Σ_j |J_ij s_j|, with the last
/// Jacobian J and the correction s that led to x, or if x satisfies [`is_root`] with the Jacobian at x.
fn is_met(
    equations: &mut dyn Residual,
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
    /// Finds the next iterate. `false`: no λ of at least [`MIN_DAMPING`] is accepted.
    fn step(&mut self, at: &mut Iterate<'_>) -> bool {
        let here = dot(&at.r, &at.r);
        self.last[self.steps % WINDOW] = here;
        self.steps += 1;
        let most = self.last.iter().fold(0.0, |m: f64, x| m.max(*x));
        for (longest, below) in [(1.0, here), (SHORT, most)] {
            let mut share = longest;
            while share >= MIN_DAMPING {
                at.try_at(share);
                if dot(&at.trial, &at.trial) < below {
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
