//! Shot noise: pulses at random instants.

use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::excitation::earliest::earlier;
use crate::numeric::split_mix::CounterRng;
use crate::processes::amplitudes::{Amplitudes, KnownMoments};
use crate::processes::draws::Draws;
use crate::processes::markov::grid::Grid;
use crate::processes::process::{FORGOTTEN, Path, Process};
use crate::series::Series;
use rand::RngExt;
use rand_distr::Distribution;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Shot noise: pulses of random size that begin at random instants and decay exponentially.
///
/// ```text
/// x(t) = Σ a_i exp(-(t - t_i)/τ) over all t_i <= t
/// mean λ τ ⟨a⟩,   variance λ τ ⟨a²⟩/2,   correlation exp(-|lag|/τ),
/// S(f) = 2 λ τ² ⟨a²⟩/(1 + (2π f τ)²)
/// ```
///
/// with λ pulses per time unit (a Poisson process), the sizes a_i and the decay time τ. The mean m and the
/// standard deviation s of the sizes, ⟨a⟩ = m and ⟨a²⟩ = m² + s², are known if
/// [`moments`](ShotNoise::moments) states them. Far below the frequency 1/(2πτ) it is white noise of the
/// two-sided intensity D = λ τ² ⟨a²⟩.
///
/// The path jumps at t_i, which are drive edges. Pulses are forgotten after 37 decay times, when e^-37 <
/// 2^-53 of them is left. An evaluation sums all pulses of this time, 37 λ τ in the mean.
///
/// Source: Campbell, Proc. Cambridge Phil. Soc. 15 (1909) 117; Rice, Bell Syst. Tech. J. 23 (1944) 282.
///
/// ```
/// use gear_dynamics::{excitation::Side, processes::{Process, ShotNoise}};
/// use rand_distr::Exp;
/// // 20 shocks per second of 3 N m in the mean, exponentially distributed, that decay in 10 ms.
/// let process = ShotNoise::new(20.0, 0.01, Exp::new(1.0 / 3.0)?)?.moments(3.0, 3.0)?;
/// assert!((process.mean().expect("stated moments") - 0.6).abs() < 1e-15);
/// let path = process.path(0);
/// let shock = path.next_edge(0.0).expect("there is always a next shock");
/// assert!(path.at(shock, Side::After) > path.at(shock, Side::Before));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct ShotNoise {
    rate: f64,
    decay: f64,
    sizes: Amplitudes,
    draws: Draws,
}

/// Maximum number of pulses in a decay time.
const OVERLAP: f64 = 1e4;

impl ShotNoise {
    /// Shot noise with `rate` pulses per time unit of the model, the decay time of a pulse and the
    /// distribution of its size. Defaults: seed 0, member 0, moments not stated.
    ///
    /// # Errors
    /// A rate or a decay time outside 1e-50 .. 1e50; a decay time below 1e-9, for which Taylor coefficients
    /// overflow; more than 10⁴ pulses in a decay time.
    pub fn new<D>(rate: f64, decay: f64, sizes: D) -> Result<Self, ParameterError>
    where
        D: Distribution<f64> + Send + Sync + 'static,
    {
        let (rate, decay) = (check::scale("rate of pulses", rate)?, check::scale("decay time", decay)?);
        check::frequency("1/decay time", 1.0 / decay)?;
        if rate * decay > OVERLAP {
            let (name, value) = ("pulses in a decay time".into(), rate * decay);
            return Err(ParameterError::OutOfRange { name, value, allowed: "[0, 1e4]" });
        }
        Ok(ShotNoise { rate, decay, sizes: Amplitudes::new(sizes), draws: Draws::default() })
    }
    /// Mean m and standard deviation s of the sizes, for the statistics. Default: not stated.
    ///
    /// # Errors
    /// A mean beyond ±1e50; a standard deviation that is negative or beyond 1e50.
    pub fn moments(self, mean: f64, deviation: f64) -> Result<Self, ParameterError> {
        Ok(ShotNoise { sizes: self.sizes.with_moments(mean, deviation)?, ..self })
    }
    /// The same process with another seed, for an independent experiment. Default: 0.
    pub fn seed(self, seed: u64) -> Self {
        ShotNoise { draws: Draws { seed, ..self.draws }, ..self }
    }
    /// The same process for another member of an ensemble with the same seed. Default: 0.
    pub fn member(self, member: u64) -> Self {
        ShotNoise { draws: Draws { member, ..self.draws }, ..self }
    }
}

impl Process for ShotNoise {
    fn path(&self, stream: u64) -> Arc<dyn Path> {
        Arc::new(Pulses {
            decay: self.decay,
            sizes: self.sizes.clone(),
            cells: Grid { spacing: 1.0 / self.rate },
            stream: self.draws.stream(stream),
        })
    }
    fn mean(&self) -> Option<f64> {
        Some(self.rate * self.decay * self.sizes.moments?.mean)
    }
    fn variance(&self) -> Option<f64> {
        let KnownMoments { mean, deviation } = self.sizes.moments?;
        Some(0.5 * self.rate * self.decay * (mean * mean + deviation * deviation))
    }
    fn correlation(&self, lag: f64) -> Option<f64> {
        self.sizes.moments.map(|_| libm::exp(-lag.abs() / self.decay))
    }
    fn density(&self, frequency: f64) -> Option<f64> {
        let turn = TAU * frequency * self.decay;
        Some(4.0 * self.variance()? * self.decay / (1.0 + turn * turn))
    }
}

/// A path. The instants of its pulses are drawn for cells of the length 1/λ, one pulse in the mean.
struct Pulses {
    decay: f64,
    sizes: Amplitudes,
    cells: Grid,
    stream: CounterRng,
}

/// Number of cells in which the next pulse is sought. That all are empty has the probability e^-64.
const SOUGHT: i64 = 64;

impl Pulses {
    /// Calls `f` with the instant of each pulse of a cell and the generator of its size.
    #[inline]
    fn each(&self, cell: i64, mut f: impl FnMut(f64, &mut CounterRng)) {
        let draws = self.stream.child(cell as u64);
        let mut left = 1.0 - draws.child(0).random::<f64>();
        // A Poisson number of mean 1: the probability of n pulses is e^-1/n!.
        let (mut n, mut probability) = (0, libm::exp(-1.0));
        while left > probability && n < 18 {
            left -= probability;
            n += 1;
            probability /= f64::from(n);
            let mut rng = draws.child(n as u64);
            let share: f64 = rng.random();
            f(self.cells.node(cell) + share * self.cells.spacing, &mut rng);
        }
    }
}

impl Path for Pulses {
    fn at(&self, t: f64, side: Side) -> f64 {
        let (last, mut sum) = (self.cells.cell(t), 0.0);
        let first = self.cells.cell(t - FORGOTTEN * self.decay);
        for cell in first..=last {
            self.each(cell, |instant, rng| {
                let age = t - instant;
                if age > 0.0 || age == 0.0 && side == Side::After {
                    sum += self.sizes.draw(rng) * libm::exp(-age / self.decay);
                }
            });
        }
        sum
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        let cell = self.cells.cell(t);
        for cell in cell..cell + SOUGHT {
            let mut first = None;
            self.each(cell, |instant, _| first = earlier(first, (instant > t).then_some(instant)));
            if first.is_some() {
                return first;
            }
        }
        let end = self.cells.node(cell + SOUGHT);
        (end > t).then_some(end)
    }
    fn series(&self, t: f64, coefficients: usize) -> Series {
        let value = self.at(t, Side::After);
        let decay = Series::variable(1.0, -1.0 / self.decay, coefficients);
        Series::from_coefficients(&decay, {
            let mut next = value;
            move |n| {
                let now = next;
                next *= -1.0 / (self.decay * (n + 1) as f64);
                now
            }
        })
    }
}
