//! What is kept of a random number that is seen many times.

use crate::error::{ParameterError, check};

/// Values kept as they are, before they are sorted into bins.
const PILOT: usize = 512;
/// Bins over the range of the pilot, and as many again on either side.
const BINS: usize = 512;

/// Count, mean, variance, extremes and quantiles of a number that is seen once for every member, in a memory that does not grow with their
/// number: up to 512 values are kept; from then on they are counted in 1536 bins over three times the range of the first 512, so that a
/// quantile is off by a bin at the most ([`resolution`](Distribution::resolution)).
///
/// ```
/// use gear_dynamics::Distribution;
/// let mut x = Distribution::new();
/// (0..10_000).for_each(|i| x.add(f64::from(i % 100)));
/// assert_eq!((x.count(), x.min(), x.max()), (10_000, 0.0, 99.0));
/// assert!((x.mean() - 49.5).abs() < 1e-9);
/// assert!((x.quantile(0.5)? - 49.5).abs() < 1.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Distribution {
    count: u64,
    mean: f64,
    /// Σ (x - mean)².
    square: f64,
    min: f64,
    max: f64,
    pilot: Vec<f64>,
    bins: Vec<u32>,
    start: f64,
    width: f64,
}

impl Distribution {
    /// Nothing seen yet.
    pub fn new() -> Self {
        Distribution { min: f64::INFINITY, max: f64::NEG_INFINITY, ..Distribution::default() }
    }

    /// Of given values.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut all = Distribution::new();
        values.into_iter().for_each(|x| all.add(x));
        all
    }

    /// Sees a value. Mean and variance by Welford's recurrence.
    pub fn add(&mut self, x: f64) {
        self.count += 1;
        let off = x - self.mean;
        self.mean += off / self.count as f64;
        self.square += off * (x - self.mean);
        self.min = self.min.min(x);
        self.max = self.max.max(x);
        if self.bins.is_empty() {
            self.pilot.push(x);
            if self.pilot.len() == PILOT {
                self.sort_in();
            }
        } else {
            self.bin(x);
        }
    }

    fn sort_in(&mut self) {
        let range = (self.max - self.min).max(1e-12 * self.max.abs().max(self.min.abs())).max(f64::MIN_POSITIVE);
        self.start = self.min - range;
        self.width = range / BINS as f64;
        self.bins = vec![0; 3 * BINS];
        for x in std::mem::take(&mut self.pilot) {
            self.bin(x);
        }
    }

    fn bin(&mut self, x: f64) {
        let place = ((x - self.start) / self.width).clamp(0.0, (3 * BINS - 1) as f64);
        self.bins[place as usize] += 1;
    }

    /// Values seen.
    pub fn count(&self) -> u64 {
        self.count
    }
    /// Mean.
    pub fn mean(&self) -> f64 {
        self.mean
    }
    /// Σ (x - mean)²/(n - 1).
    pub fn variance(&self) -> f64 {
        if self.count > 1 { self.square / (self.count - 1) as f64 } else { 0.0 }
    }
    /// Standard error of the mean; infinite with fewer than two values.
    pub fn standard_error(&self) -> f64 {
        if self.count > 1 { (self.variance() / self.count as f64).sqrt() } else { f64::INFINITY }
    }
    /// The mean with `z` standard errors either side: z = 1.96 holds the true mean 19 times in 20.
    pub fn confidence(&self, z: f64) -> [f64; 2] {
        [self.mean - z * self.standard_error(), self.mean + z * self.standard_error()]
    }
    /// Least value.
    pub fn min(&self) -> f64 {
        self.min
    }
    /// Largest value.
    pub fn max(&self) -> f64 {
        self.max
    }
    /// How far a quantile may be off: 0 while all values are kept.
    pub fn resolution(&self) -> f64 {
        self.width
    }

    /// The value below which a share `p` of all lies.
    ///
    /// # Errors
    /// A share outside [0, 1], and no values.
    pub fn quantile(&self, p: f64) -> Result<f64, ParameterError> {
        if !(0.0..=1.0).contains(&check::finite("share of a quantile", p)?) {
            return Err(ParameterError::OutOfRange { name: "share of a quantile".into(), value: p, allowed: "[0, 1]" });
        }
        if self.count == 0 {
            return Err(ParameterError::Empty { name: "values of the distribution".into(), least: 1 });
        }
        if self.bins.is_empty() {
            let mut sorted = self.pilot.clone();
            sorted.sort_by(f64::total_cmp);
            let at = p * (sorted.len() - 1) as f64;
            let (below, above) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
            return Ok(below + (above - below) * at.fract());
        }
        let wanted = p * self.count as f64;
        let mut below = 0.0;
        for (i, &count) in self.bins.iter().enumerate() {
            let count = f64::from(count);
            if count > 0.0 && below + count >= wanted {
                let within = ((wanted - below) / count).clamp(0.0, 1.0);
                return Ok((self.start + (i as f64 + within) * self.width).clamp(self.min, self.max));
            }
            below += count;
        }
        Ok(self.max)
    }

    /// Counts over so many equal spans between the extremes, by the middle of each span: to a bin's width.
    pub fn histogram(&self, spans: usize) -> Vec<(f64, u64)> {
        let mut whole = self.clone();
        if whole.bins.is_empty() && whole.count > 0 {
            whole.sort_in();
        }
        let width = (self.max - self.min) / spans as f64;
        let mut counts: Vec<(f64, u64)> = (0..spans).map(|i| (self.min + (i as f64 + 0.5) * width, 0)).collect();
        for (i, &count) in whole.bins.iter().enumerate().filter(|(_, count)| **count > 0) {
            let middle = whole.start + (i as f64 + 0.5) * whole.width;
            let place = ((middle - self.min) / width).clamp(0.0, spans.saturating_sub(1) as f64);
            if let Some(span) = counts.get_mut(place as usize) {
                span.1 += u64::from(count);
            }
        }
        counts
    }
}
