//! Held processes: random processes that are constant on intervals of equal length.

use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::numeric::split_mix::CounterRng;
use crate::processes::amplitudes::{Amplitudes, KnownMoments};
use crate::processes::draws::Draws;
use crate::processes::markov::grid::Grid;
use crate::processes::process::{Path, Process};
use crate::series::Series;
use rand_distr::Distribution;
use std::f64::consts::PI;
use std::sync::Arc;

/// A held process: x(t) = x_k for k h <= t < (k + 1) h, with random or given values x_k and the hold time h.
///
/// With numbers drawn at every evaluation of the acceleration the result depends on the step size. With held
/// values it converges as the step size decreases, and the hold time h is a physical parameter. Source:
/// [theory](crate::guide::theory), "Random damping".
///
/// With the mean m and the standard deviation s of the values, which [`moments`](HeldProcess::moments)
/// states, and as a mean over all positions of the grid:
///
/// ```text
/// mean m,   σ² = s²,   correlation 1 - |lag|/h up to h, then 0,   S(f) = 2 s² h (sin(π f h)/(π f h))²
/// ```
///
/// Far below the frequency 1/h it is white noise of the two-sided intensity D = s² h. If h decreases at
/// constant s², the noise vanishes. At constant s² h it tends to white noise. The mean square of a linear
/// oscillator then tends to its value under white noise; the relative error is (ω h)²/12 ([random
/// loads](crate::guide::random)).
///
/// ```
/// use gear_dynamics::{excitation::Side, processes::{HeldProcess, Process}};
/// use rand_distr::Uniform;
/// let process = HeldProcess::new(0.5, Uniform::new(0.0, 1.0)?)?.moments(0.5, 12f64.powf(-0.5))?.seed(7);
/// let path = process.path(0);
/// assert_eq!(path.at(0.1, Side::After), path.at(0.4, Side::After));
/// assert_ne!(path.at(0.5, Side::Before), path.at(0.5, Side::After));
/// assert!((process.density(0.0).expect("stated moments") - 1.0 / 12.0).abs() < 1e-15); // 2 s² h
/// let given = HeldProcess::of_values(0.5, &[3.0, 5.0])?;
/// assert_eq!(given.path(0).at(0.7, Side::After), 5.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct HeldProcess {
    grid: Grid,
    draws: Draws,
    source: ValueSource,
}

#[derive(Clone, Debug)]
enum ValueSource {
    /// Draws from a distribution.
    Drawn(Amplitudes),
    /// A list of values.
    Given(Arc<[f64]>),
}

impl HeldProcess {
    /// A process with a new value of `distribution` after every hold time h > 0, in the time unit of the
    /// model. Defaults: seed 0, member 0, moments not stated.
    ///
    /// # Errors
    /// A hold time outside 1e-50 .. 1e50.
    pub fn new<D>(hold: f64, distribution: D) -> Result<Self, ParameterError>
    where
        D: Distribution<f64> + Send + Sync + 'static,
    {
        let grid = Grid { spacing: check::scale("hold time", hold)? };
        let source = ValueSource::Drawn(Amplitudes::new(distribution));
        Ok(HeldProcess { grid, draws: Draws::default(), source })
    }

    /// A process with given values, one for each hold time h. The last value applies after the end of the
    /// list. All streams have the same values.
    ///
    /// # Errors
    /// A hold time outside 1e-50 .. 1e50; an empty list; a value beyond ±1e50.
    pub fn of_values(hold: f64, values: &[f64]) -> Result<Self, ParameterError> {
        let grid = Grid { spacing: check::scale("hold time", hold)? };
        if values.is_empty() {
            return Err(ParameterError::Empty { name: "held values".into(), min: 1 });
        }
        check::quantities("held values", values)?;
        Ok(HeldProcess { grid, draws: Draws::default(), source: ValueSource::Given(values.into()) })
    }

    /// Mean m and standard deviation s of the distribution, for the statistics. Default: not stated. Given
    /// values have none.
    ///
    /// # Errors
    /// A mean beyond ±1e50; a standard deviation that is negative or beyond 1e50.
    pub fn moments(self, mean: f64, deviation: f64) -> Result<Self, ParameterError> {
        let source = match self.source {
            ValueSource::Drawn(drawn) => ValueSource::Drawn(drawn.with_moments(mean, deviation)?),
            given => given,
        };
        Ok(HeldProcess { source, ..self })
    }
    /// The same process with another seed, for an independent experiment. Default: 0.
    pub fn seed(self, seed: u64) -> Self {
        HeldProcess { draws: Draws { seed, ..self.draws }, ..self }
    }
    /// The same process for another member of an ensemble with the same seed. Default: 0.
    pub fn member(self, member: u64) -> Self {
        HeldProcess { draws: Draws { member, ..self.draws }, ..self }
    }

    /// Value x_k of a stream. Different streams are independent: each mesh may have its own one, or all
    /// meshes share one.
    pub fn held(&self, stream: u64, k: u64) -> f64 {
        self.source.value(&self.draws.stream(stream), k)
    }

    fn known(&self) -> Option<KnownMoments> {
        match &self.source {
            ValueSource::Drawn(drawn) => drawn.moments,
            ValueSource::Given(_) => None,
        }
    }
}

impl ValueSource {
    fn value(&self, stream: &CounterRng, k: u64) -> f64 {
        match self {
            ValueSource::Drawn(drawn) => drawn.draw(&mut stream.child(k)),
            ValueSource::Given(values) => values[(k as usize).min(values.len() - 1)],
        }
    }
}

impl Process for HeldProcess {
    fn path(&self, stream: u64) -> Arc<dyn Path> {
        Arc::new(HeldPath { grid: self.grid, stream: self.draws.stream(stream), source: self.source.clone() })
    }
    fn mean(&self) -> Option<f64> {
        Some(self.known()?.mean)
    }
    fn variance(&self) -> Option<f64> {
        Some(self.known()?.deviation.powi(2))
    }
    fn correlation(&self, lag: f64) -> Option<f64> {
        self.known().map(|_| (1.0 - lag.abs() / self.grid.spacing).max(0.0))
    }
    fn density(&self, frequency: f64) -> Option<f64> {
        let (variance, h) = (self.variance()?, self.grid.spacing);
        Some(2.0 * variance * h * sinc(PI * frequency * h).powi(2))
    }
}

/// sin(x)/x; 1 at 0.
fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { libm::sin(x) / x }
}

/// A path of a held process; x_0 for t < 0.
struct HeldPath {
    grid: Grid,
    stream: CounterRng,
    source: ValueSource,
}

impl HeldPath {
    fn index(&self, t: f64) -> i64 {
        self.grid.cell(t).max(0)
    }
}

impl Path for HeldPath {
    fn at(&self, t: f64, side: Side) -> f64 {
        let k = self.index(t);
        let before = side == Side::Before && k > 0 && self.grid.node(k) == t;
        self.source.value(&self.stream, (if before { k - 1 } else { k }) as u64)
    }
    /// The first instant k h after `t`, with k >= 1.
    fn next_edge(&self, t: f64) -> Option<f64> {
        if t < 0.0 { Some(self.grid.node(1)) } else { self.grid.next_node(t) }
    }
    fn series(&self, t: f64, _: usize) -> Series {
        self.at(t, Side::After).into()
    }
}
