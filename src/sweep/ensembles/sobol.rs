//! Random parameters and their Sobol indices.

use crate::error::{ParameterError, check};
use crate::numeric::split_mix::CounterRng;
use crate::sweep::settings::points::Points;
use rand_distr::Distribution as Draw;
use std::sync::Arc;

type Drawn = Arc<dyn Fn(&mut CounterRng) -> f64 + Send + Sync>;

/// Independent random parameters with given distributions. A sample is a pure function of the seed and its
/// number k: samples can be drawn in any order.
///
/// ```
/// use gear_dynamics::sweep::RandomParameters;
/// use rand_distr::{Normal, Uniform};
/// let tolerances = RandomParameters::new(7)
///     .with("half_backlash", Uniform::new(4e-5, 6e-5)?)
///     .with("stiffness", Normal::new(3.1e8, 1e7)?);
/// let points = tolerances.points(100)?;
/// assert!((4e-5..6e-5).contains(&points.point(42)["half_backlash"]));
/// assert_eq!(tolerances.sample(42), points.point(42).values());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
#[must_use = "a setting returns a new value"]
pub struct RandomParameters {
    seed: u64,
    names: Vec<String>,
    draws: Vec<Drawn>,
}

impl std::fmt::Debug for RandomParameters {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RandomParameters")
            .field("seed", &self.seed)
            .field("names", &self.names)
            .finish_non_exhaustive()
    }
}

impl RandomParameters {
    /// A list without parameters; add them by [`with`](RandomParameters::with).
    pub fn new(seed: u64) -> Self {
        RandomParameters { seed, names: Vec::new(), draws: Vec::new() }
    }
    /// Adds a parameter that is statistically independent of the others.
    pub fn with<D: Draw<f64> + Send + Sync + 'static>(mut self, name: &str, distribution: D) -> Self {
        self.names.push(name.into());
        self.draws.push(Arc::new(move |rng: &mut CounterRng| distribution.sample(rng)));
        self
    }
    /// The parameter values of sample `k`, in the order in which the parameters were added.
    pub fn sample(&self, k: u64) -> Vec<f64> {
        self.draw(0, k)
    }
    /// Sample `k` of matrix 0 (A) or 1 (B).
    fn draw(&self, matrix: u64, k: u64) -> Vec<f64> {
        // Parameter i draws from stream 2³² + i; the streams of held processes count from 0.
        const BESIDE: u64 = 1 << 32;
        let number =
            |(i, draw): (usize, &Drawn)| draw(&mut CounterRng::new(self.seed, k, BESIDE + i as u64, matrix));
        self.draws.iter().enumerate().map(number).collect()
    }
    /// Samples 0 to `count - 1` as the points of a sweep.
    ///
    /// # Errors
    /// No samples; no parameters; more than 2²⁶ numbers; a distribution that draws a value that is not
    /// finite.
    pub fn points(&self, count: usize) -> Result<Points, ParameterError> {
        check::count("numbers of the samples", &[count, self.names.len()], check::NUMBERS)?;
        Points::flat(&self.names, (0..count as u64).flat_map(|k| self.sample(k)).collect())
    }
    /// The points needed for Sobol indices from `samples` samples: `samples` × (number of parameters + 2).
    ///
    /// # Errors
    /// As [`points`](RandomParameters::points); fewer than 2 samples.
    pub fn sobol(&self, samples: usize) -> Result<SobolDesign, ParameterError> {
        check::at_least("samples", samples, 2)?;
        let (width, count) = (self.names.len(), self.names.len().saturating_add(2));
        let mut rows = Vec::with_capacity(check::count(
            "numbers of the samples",
            &[samples, count, width],
            check::NUMBERS,
        )?);
        for k in 0..samples as u64 {
            let (a, b) = (self.draw(0, k), self.draw(1, k));
            for i in 0..self.names.len() {
                let mut mixed = a.clone();
                mixed[i] = b[i];
                rows.extend(mixed);
            }
            rows.extend(a);
            rows.extend(b);
        }
        Ok(SobolDesign { points: Points::flat(&self.names, rows)?, parameters: width })
    }
}

/// The points at which a measure must be evaluated for its Sobol indices.
///
/// Each sample has two independent draws A and B, and for every parameter i the draw A_i: A with parameter i
/// taken from B.   Source: Saltelli et al., Comput. Phys. Commun. 181 (2010) 259.
///
/// ```
/// use gear_dynamics::sweep::RandomParameters;
/// use rand_distr::StandardNormal;
/// let design = RandomParameters::new(1).with("x", StandardNormal).with("y", StandardNormal).sobol(4000)?;
/// let points = design.points();
/// let measure: Vec<f64> =
///     (0..points.len()).map(|i| 2.0 * points.point(i)["x"] + points.point(i)["y"]).collect();
/// let indices = design.indices(&measure)?;
/// assert!((indices[0].first - 0.8).abs() < 3.0 * indices[0].first_error);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SobolDesign {
    points: Points,
    parameters: usize,
}

/// The share `[1]` of one parameter in the variance of a measure.
///
/// ```
/// use gear_dynamics::sweep::RandomParameters;
/// use rand_distr::StandardNormal;
/// let design = RandomParameters::new(1).with("x", StandardNormal).with("y", StandardNormal).sobol(100)?;
/// let points = design.points();
/// // The measure f = x³ does not depend on y.
/// let measure: Vec<f64> = (0..points.len()).map(|i| points.point(i)["x"].powi(3)).collect();
/// let indices = design.indices(&measure)?;
/// assert_eq!((indices[1].name.as_str(), indices[1].first, indices[1].total), ("y", 0.0, 0.0));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct SobolIndex {
    /// Name of the parameter.
    pub name: String,
    /// First-order index S_i `[1]`: the share of the parameter alone.
    pub first: f64,
    /// Standard error of S_i `[1]`; infinite if the measure varies in one sample only.
    #[cfg_attr(feature = "serde", serde(with = "crate::numeric::not_finite::number"))]
    pub first_error: f64,
    /// Total index T_i `[1]`: the share of the parameter with all its interactions.
    pub total: f64,
    /// Standard error of T_i `[1]`; infinite if the measure varies in one sample only.
    #[cfg_attr(feature = "serde", serde(with = "crate::numeric::not_finite::number"))]
    pub total_error: f64,
}

impl SobolDesign {
    /// The points to sweep, `n + 2` for each sample with n parameters: A_1 .. A_n, A, B.
    pub fn points(&self) -> &Points {
        &self.points
    }

    /// The Sobol indices of a measure f that is given at all points.
    ///
    /// S_i = E[(f(B) - m) (f(A_i) - f(A))]/V,   T_i = E[(f(A) - f(A_i))²]/(2 V)
    ///
    /// E is the mean over the samples; m and V are the mean and the variance of f over all A and B. Samples
    /// with a value that is not finite are left out.
    ///
    /// The standard errors are jackknife estimates over the samples, since numerator, mean and V depend on
    /// the same samples.   Source: Efron & Stein, Ann. Stat. 9 (1981) 586. The interval of ±2 standard errors
    /// contains the index in about 95 % of the designs. In a strongly skewed measure few samples make most of
    /// the variance, and a design without these samples has standard errors that are too small. Example: for
    /// e^(x + y/2), x and y normal, the interval contains the index in 88 to 93 % of the designs at 200
    /// samples and in 91 to 96 % at 1000.
    ///
    /// # Errors
    /// A list whose length is not the number of points; a measure that does not vary, or whose variance lies
    /// outside 1e-50 .. 1e50; fewer than 2 samples with finite values.
    pub fn indices(&self, measure: &[f64]) -> Result<Vec<SobolIndex>, ParameterError> {
        check::length("measure", measure.len(), self.points.len())?;
        let n = self.parameters;
        let samples: Vec<&[f64]> =
            measure.chunks_exact(n + 2).filter(|sample| sample.iter().all(|x| x.is_finite())).collect();
        check::at_least("good samples", samples.len(), 2)?;
        let both = crate::sweep::ensembles::distribution::Distribution::of_samples(
            samples.iter().flat_map(|s| [s[n], s[n + 1]]),
        );
        let (mean, variance) = (both.mean(), check::scale("variance of the measure", both.variance()?)?);
        Ok((0..n)
            .map(|i| {
                let average = |f: &dyn Fn(f64, f64, f64) -> f64| {
                    crate::sweep::ensembles::distribution::Distribution::of_samples(
                        samples.iter().map(|s| f(s[i], s[n], s[n + 1]) / variance),
                    )
                    .mean()
                };
                let first = average(&|mixed, a, b| (b - mean) * (mixed - a));
                let total = average(&|mixed, a, _| 0.5 * (a - mixed) * (a - mixed));
                // (f - m)/√V: subtracting the mean first avoids cancellation in the sums of squares.
                let unit = variance.sqrt();
                let sample = |s: &&[f64]| [s[i], s[n], s[n + 1]].map(|x| (x - mean) / unit);
                let [first_error, total_error] = jackknife(&samples.iter().map(sample).collect::<Vec<_>>());
                SobolIndex { name: self.points.names()[i].clone(), first, first_error, total, total_error }
            })
            .collect())
    }
}

/// Jackknife standard errors of S_i and T_i from m samples of the values at A_i, A and B:
/// √((m - 1)/m Σ (x_k - x̄)²), with x_k the index without sample k and x̄ the mean of the x_k.
fn jackknife(samples: &[[f64; 3]]) -> [f64; 2] {
    // Sums over the samples of a + b, a² + b², b (mixed - a), mixed - a, (mixed - a)²/2; mixed is the value
    // at A_i.
    let terms = |[mixed, a, b]: &[f64; 3]| {
        [a + b, a * a + b * b, b * (mixed - a), mixed - a, 0.5 * (mixed - a) * (mixed - a)]
    };
    let mut sums = [0.0; 5];
    for sample in samples {
        sums.iter_mut().zip(terms(sample)).for_each(|(sum, x)| *sum += x);
    }
    let m = samples.len() as f64;
    let mut without = [
        crate::sweep::ensembles::distribution::Distribution::new(),
        crate::sweep::ensembles::distribution::Distribution::new(),
    ];
    for sample in samples {
        let mut left = sums;
        left.iter_mut().zip(terms(sample)).for_each(|(sum, x)| *sum -= x);
        let count = 2.0 * (m - 1.0);
        let mean = left[0] / count;
        let variance = (left[1] - count * mean * mean) / (count - 1.0);
        without[0].add((left[2] - mean * left[3]) / (m - 1.0) / variance);
        without[1].add(left[4] / (m - 1.0) / variance);
    }
    // √((m - 1)/m Σ (x_k - x̄)²) is (m - 1) times the standard error of the mean of the x_k.
    without.map(|all| if all.not_finite() > 0 { f64::INFINITY } else { all.standard_error() * (m - 1.0) })
}
