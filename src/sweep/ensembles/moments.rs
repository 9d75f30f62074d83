//! What is kept of a random number that is seen many times.

use crate::error::{ParameterError, check};
use std::collections::VecDeque;

/// Values kept as they are, before they are sorted into bins.
const PILOT: usize = 512;

/// Bins at the most, and over the range of the pilot at the least.
const BINS: usize = 1024;

const LEAST: usize = 256;

/// Values beyond this size are squared in a unit of their own, a power of two.
const LARGE: f64 = 1e140;

const LARGE_UNIT: f64 = f64::from_bits((1023 - 600) << 52);

/// Count, mean, variance, extremes and quantiles of a number that is seen once for every member, in a memory that does not grow with their
/// number: up to 512 values are kept; from then on they are counted in at most 1024 bins, whose width doubles as often as a value asks for it,
/// so that a quantile is off by a bin at the most ([`resolution`](Distribution::resolution)), 1/256 of the range of all values. Values that are
/// not finite are [counted apart](Distribution::not_finite).
///
/// ```
/// use gear_dynamics::sweep::Distribution;
/// let mut x = Distribution::new();
/// (0..10_000).for_each(|i| x.add(f64::from(i % 100)));
/// assert_eq!((x.count(), x.min(), x.max()), (10_000, 0.0, 99.0));
/// assert!((x.mean() - 49.5).abs() < 1e-9);
/// assert!((x.quantile(0.5)? - 49.5).abs() < 1.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    count: u64,
    not_finite: u64,
    mean: f64,
    /// Σ ((x - mean) unit)².
    square: f64,
    /// 1 unless a value is so large that its square overflows.
    unit: f64,
    min: f64,
    max: f64,
    pilot: Vec<f64>,
    /// Bin i holds the x with floor(x/width) = first + i.
    bins: VecDeque<u64>,
    first: f64,
    /// A power of two, so that two bins are one of twice the width, to the bit; 0 while all values are kept.
    width: f64,
}

impl Default for Distribution {
    fn default() -> Self {
        Distribution::new()
    }
}

impl Distribution {
    /// Nothing seen yet.
    pub fn new() -> Self {
        Distribution {
            count: 0,
            not_finite: 0,
            mean: 0.0,
            square: 0.0,
            unit: 1.0,
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
            pilot: Vec::new(),
            bins: VecDeque::new(),
            first: 0.0,
            width: 0.0,
        }
    }

    /// Of given values.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut all = Distribution::new();
        values.into_iter().for_each(|x| all.add(x));
        all
    }

    /// Sees a value. Mean and variance by Welford's recurrence.
    pub fn add(&mut self, x: f64) {
        if !x.is_finite() {
            self.not_finite += 1;
            return;
        }
        self.count += 1;
        if x.abs() > LARGE && self.unit == 1.0 {
            (self.unit, self.square) = (LARGE_UNIT, self.square * LARGE_UNIT * LARGE_UNIT);
        }
        let off = x * self.unit - self.mean * self.unit;
        self.mean += off / self.count as f64 / self.unit;
        self.square += off * (x * self.unit - self.mean * self.unit);
        self.min = self.min.min(x);
        self.max = self.max.max(x);
        if !self.bins.is_empty() {
            self.bin(x);
            return;
        }
        self.pilot.push(x);
        if self.pilot.len() == PILOT {
            self.sort_in();
        }
    }

    fn sort_in(&mut self) {
        // Not below what numbers of this size can resolve.
        let resolved = 1e-12 * self.max.abs().max(self.min.abs());
        let wanted = (self.max / LEAST as f64 - self.min / LEAST as f64).max(resolved).max(f64::MIN_POSITIVE);
        // The largest power of two that is not above it.
        self.width = f64::from_bits(wanted.to_bits() & f64::INFINITY.to_bits());
        for x in std::mem::take(&mut self.pilot) {
            self.bin(x);
        }
    }

    fn bin(&mut self, x: f64) {
        let mut place = (x / self.width).floor();
        if self.bins.is_empty() {
            self.first = place;
        }
        while place.max(self.last()) - place.min(self.first) >= BINS as f64 {
            self.double();
            place = (x / self.width).floor();
        }
        while place < self.first {
            self.bins.push_front(0);
            self.first -= 1.0;
        }
        while place > self.last() || self.bins.is_empty() {
            self.bins.push_back(0);
        }
        self.bins[(place - self.first) as usize] += 1;
    }

    fn last(&self) -> f64 {
        self.first + self.bins.len().max(1) as f64 - 1.0
    }

    /// Makes one bin of every two.
    fn double(&mut self) {
        let first = (0.5 * self.first).floor();
        let odd = usize::from(self.first > 2.0 * first);
        let mut wide = VecDeque::from(vec![0; (self.bins.len() + odd).div_ceil(2)]);
        for (i, count) in self.bins.iter().enumerate() {
            wide[(i + odd) / 2] += count;
        }
        (self.bins, self.first, self.width) = (wide, first, 2.0 * self.width);
    }

    /// Finite values seen: all figures are of these.
    pub fn count(&self) -> u64 {
        self.count
    }
    /// Values seen that are infinite or not a number, such as those of a [column](crate::sweep::Rows::column) where a point failed.
    pub fn not_finite(&self) -> u64 {
        self.not_finite
    }
    /// Mean; not a number with no values.
    pub fn mean(&self) -> f64 {
        if self.count > 0 { self.mean } else { f64::NAN }
    }
    /// Σ (x - mean)²/(n - 1) in the unit of the squares.
    fn scaled_variance(&self) -> f64 {
        if self.count > 1 { self.square / (self.count - 1) as f64 } else { 0.0 }
    }
    /// Σ (x - mean)²/(n - 1).
    ///
    /// # Errors
    /// [`ParameterError::Overflow`] for values so far apart that it is beyond the largest number; their mean and its standard error are not.
    pub fn variance(&self) -> Result<f64, ParameterError> {
        check::representable(
            "variance",
            self.scaled_variance() / self.unit / self.unit,
            &[self.min, self.max],
        )
    }
    /// Standard error of the mean; infinite with fewer than two values.
    pub fn standard_error(&self) -> f64 {
        if self.count > 1 {
            (self.scaled_variance() / self.count as f64).sqrt() / self.unit
        } else {
            f64::INFINITY
        }
    }
    /// The mean with `z` standard errors either side: z = 1.96 holds the true mean 19 times in 20.
    pub fn confidence(&self, z: f64) -> [f64; 2] {
        [self.mean() - z * self.standard_error(), self.mean() + z * self.standard_error()]
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
            return Err(ParameterError::OutOfRange {
                name: "share of a quantile".into(),
                value: p,
                allowed: "[0, 1]",
            });
        }
        if self.count == 0 {
            return Err(ParameterError::Empty { name: "values of the distribution".into(), least: 1 });
        }
        if self.bins.is_empty() {
            let mut sorted = self.pilot.clone();
            sorted.sort_by(f64::total_cmp);
            let at = p * (sorted.len() - 1) as f64;
            let (below, above) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
            let apart = above - below;
            // Values of either sign near the largest number.
            let between =
                if apart.is_finite() { apart * at.fract() } else { above * at.fract() - below * at.fract() };
            return Ok(below + between);
        }
        let wanted = p * self.count as f64;
        let mut below = 0.0;
        for (i, &count) in self.bins.iter().enumerate() {
            let count = count as f64;
            if count > 0.0 && below + count >= wanted {
                let within = ((wanted - below) / count).clamp(0.0, 1.0);
                return Ok(((self.first + i as f64 + within) * self.width).clamp(self.min, self.max));
            }
            below += count;
        }
        Ok(self.max)
    }

    /// Counts over `spans` equal spans between the extremes, with the middle of each span; which span a value falls in is known to the width
    /// of a bin.
    ///
    /// # Errors
    /// No spans or more than 2²⁴; no values.
    pub fn histogram(&self, spans: usize) -> Result<Vec<(f64, u64)>, ParameterError> {
        const MOST: usize = 1 << 24;
        if spans == 0 {
            return Err(ParameterError::TooFew { name: "spans of the histogram".into(), value: 0, least: 1 });
        }
        check::count("spans of the histogram", &[spans], MOST)?;
        if self.count == 0 {
            return Err(ParameterError::Empty { name: "values of the distribution".into(), least: 1 });
        }
        let width = self.max / spans as f64 - self.min / spans as f64;
        let mut counts: Vec<(f64, u64)> =
            (0..spans).map(|i| (self.min + (i as f64 + 0.5) * width, 0)).collect();
        let bins = self
            .bins
            .iter()
            .enumerate()
            .map(|(i, &count)| ((self.first + i as f64 + 0.5) * self.width, count));
        for (x, count) in self.pilot.iter().map(|x| (*x, 1)).chain(bins) {
            let place = ((x - self.min) / width).clamp(0.0, spans.saturating_sub(1) as f64);
            if let Some(span) = counts.get_mut(place as usize) {
                span.1 += count;
            }
        }
        Ok(counts)
    }
}
