//! The distribution of a random number, in constant memory.

use crate::error::{ParameterError, check};
use crate::numeric::moments::Moments;
use crate::sweep::ensembles::confidence::{deviations_of, quantile_ranks};
use std::collections::VecDeque;

/// Up to this number of values each value is kept. Then all are counted in bins, whose first width follows
/// from their range.
const PILOT: usize = 512;

/// Maximum number of bins.
const BINS: usize = 1024;

/// Minimum number of bins over the range of the first [`PILOT`] values.
const LEAST: usize = 256;

/// Count, mean, variance, extremes and quantiles of a random number. Values are added one by one. The memory
/// does not grow with the number of values.
///
/// The first 511 values are kept. From the 512th on, all values are counted in at most 1024 bins. The bin
/// width doubles whenever a value needs more bins. A quantile is then accurate to one bin width
/// ([`resolution`](Distribution::resolution)), which is at most 1/256 of the range of all values. Values that
/// are not finite are [counted separately](Distribution::not_finite).
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
    moments: Moments,
    min: f64,
    max: f64,
    pilot: Vec<f64>,
    /// Bin i counts the values x with floor(x/width) = first + i.
    bins: VecDeque<u64>,
    first: f64,
    /// A power of two, so that two bins merge into one of twice the width without rounding; 0 while all
    /// values are kept.
    width: f64,
}

impl Default for Distribution {
    fn default() -> Self {
        Distribution::new()
    }
}

impl Distribution {
    /// A distribution without values.
    pub fn new() -> Self {
        Distribution {
            count: 0,
            not_finite: 0,
            moments: Moments::NONE,
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
            pilot: Vec::new(),
            bins: VecDeque::new(),
            first: 0.0,
            width: 0.0,
        }
    }

    /// The distribution of given values.
    pub fn of_samples(values: impl IntoIterator<Item = f64>) -> Self {
        let mut all = Distribution::new();
        values.into_iter().for_each(|x| all.add(x));
        all
    }

    /// Adds a value.
    pub fn add(&mut self, x: f64) {
        if !x.is_finite() {
            self.not_finite += 1;
            return;
        }
        self.count += 1;
        self.moments.add(x);
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

    /// Adds the values of another distribution.
    pub(crate) fn merge(&mut self, other: &Distribution) {
        if other.bins.is_empty() {
            self.not_finite += other.not_finite;
            other.pilot.iter().for_each(|x| self.add(*x));
            return;
        }
        let kept = std::mem::take(&mut self.pilot);
        if self.bins.is_empty() {
            let not_finite = self.not_finite;
            *self = other.clone();
            self.not_finite += not_finite;
            kept.iter().for_each(|x| self.add(*x));
            return;
        }
        self.moments.merge(&other.moments);
        self.count += other.count;
        self.not_finite += other.not_finite;
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
        let mut other = other.clone();
        while other.width < self.width {
            other.double();
        }
        while self.width < other.width || self.span_with(&other) > BINS as f64 {
            self.double();
            if other.width < self.width {
                other.double();
            }
        }
        while self.first > other.first {
            self.bins.push_front(0);
            self.first -= 1.0;
        }
        while self.last() < other.last() {
            self.bins.push_back(0);
        }
        let offset = (other.first - self.first) as usize;
        self.bins.iter_mut().skip(offset).zip(&other.bins).for_each(|(all, count)| *all += count);
    }

    /// Number of bins over the bins of both.
    fn span_with(&self, other: &Distribution) -> f64 {
        self.last().max(other.last()) - self.first.min(other.first) + 1.0
    }

    /// Sorts the kept values into bins. The width is the largest power of two up to range/[`LEAST`].
    fn sort_in(&mut self) {
        // Bins narrower than 1e-12 of the largest magnitude would only resolve rounding.
        let resolved = 1e-12 * self.max.abs().max(self.min.abs());
        let wanted = (self.max / LEAST as f64 - self.min / LEAST as f64).max(resolved).max(f64::MIN_POSITIVE);
        // The largest power of two that is not above `wanted`: its exponent bits alone.
        self.width = f64::from_bits(wanted.to_bits() & f64::INFINITY.to_bits());
        for x in std::mem::take(&mut self.pilot) {
            self.bin(x);
        }
    }

    /// Counts a value in bin floor(x/width), after doubling the width until at most [`BINS`] bins are needed.
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

    /// Number floor(x/width) of the last bin.
    fn last(&self) -> f64 {
        self.first + self.bins.len().max(1) as f64 - 1.0
    }

    /// Merges the bins in pairs (2k, 2k + 1) and doubles the width.
    fn double(&mut self) {
        let first = (0.5 * self.first).floor();
        let odd = usize::from(self.first > 2.0 * first);
        let mut wide = VecDeque::from(vec![0; (self.bins.len() + odd).div_ceil(2)]);
        for (i, count) in self.bins.iter().enumerate() {
            wide[(i + odd) / 2] += count;
        }
        (self.bins, self.first, self.width) = (wide, first, 2.0 * self.width);
    }

    /// Number n of finite values. All other results refer to these values.
    pub fn count(&self) -> u64 {
        self.count
    }
    /// Number of values that are infinite or NaN, for example the NaN of a failed point in a
    /// [column](crate::sweep::Rows::column).
    pub fn not_finite(&self) -> u64 {
        self.not_finite
    }
    /// Mean; NaN without values.
    pub fn mean(&self) -> f64 {
        if self.count > 0 { self.moments.mean() } else { f64::NAN }
    }
    /// Variance Σ (x - mean)²/(n - 1); 0 with fewer than two values.
    ///
    /// # Errors
    /// [`ParameterError::Overflow`] for values so far apart that the variance exceeds the largest `f64`. Mean
    /// and standard error are still finite then.
    pub fn variance(&self) -> Result<f64, ParameterError> {
        check::representable("variance", self.moments.variance(), &[self.min, self.max])
    }
    /// Standard error of the mean, √(variance/n); infinite with fewer than two values.
    pub fn standard_error(&self) -> f64 {
        self.moments.standard_error()
    }
    /// The interval mean ± z standard errors that contains the true mean in the share `level` of all
    /// experiments, if the means are normally distributed, as those of many values are: z = 1.96 for 0.95.
    ///
    /// # Errors
    /// A level outside 0 .. 1, the ends excluded.
    pub fn confidence(&self, level: f64) -> Result<[f64; 2], ParameterError> {
        let half = deviations_of(level)? * self.standard_error();
        Ok([self.mean() - half, self.mean() + half])
    }
    /// Minimum; +∞ without values.
    pub fn min(&self) -> f64 {
        self.min
    }
    /// Maximum; -∞ without values.
    pub fn max(&self) -> f64 {
        self.max
    }
    /// Maximum error of a quantile: the bin width, or 0 while all values are kept.
    pub fn resolution(&self) -> f64 {
        self.width
    }

    /// Quantile: the value below which a share `p` of all values lies.
    ///
    /// While all values are kept: linear interpolation at index p (n - 1) of the sorted values (first index
    /// 0). With bins: linear interpolation within the bin in which the count reaches p n.
    ///
    /// # Errors
    /// A share outside [0, 1]; no values.
    pub fn quantile(&self, p: f64) -> Result<f64, ParameterError> {
        if !(0.0..=1.0).contains(&check::finite("share of a quantile", p)?) {
            return Err(ParameterError::OutOfRange {
                name: "share of a quantile".into(),
                value: p,
                allowed: "[0, 1]",
            });
        }
        if self.count == 0 {
            return Err(ParameterError::Empty { name: "values of the distribution".into(), min: 1 });
        }
        if self.bins.is_empty() {
            let mut sorted = self.pilot.clone();
            sorted.sort_by(f64::total_cmp);
            let at = p * (sorted.len() - 1) as f64;
            let (below, above) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
            let apart = above - below;
            // The difference of two values of opposite sign near the largest `f64` overflows.
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

    /// The interval that contains the true quantile in at least the share `level` of all experiments,
    /// whatever the distribution: two of the sorted values, chosen by their ranks. An end is infinite if
    /// there are too few values for it. With bins each end lies up to one
    /// [bin](Distribution::resolution) further out.
    ///
    /// ```
    /// use gear_dynamics::sweep::Distribution;
    /// let x = Distribution::of_samples((1..=10).map(f64::from));
    /// assert_eq!(x.quantile_confidence(0.5, 0.95)?, [2.0, 9.0]); // with 97.9 %
    /// assert_eq!(x.quantile_confidence(0.05, 0.95)?, [f64::NEG_INFINITY, 3.0]);
    /// # Ok::<(), gear_dynamics::ParameterError>(())
    /// ```
    ///
    /// # Errors
    /// As [`quantile`](Distribution::quantile); a level outside 0 .. 1, the ends excluded; more than 2³²
    /// values.
    pub fn quantile_confidence(&self, p: f64, level: f64) -> Result<[f64; 2], ParameterError> {
        self.quantile(p)?;
        let [low, high] = quantile_ranks(self.count, p, level)?;
        let ranked =
            |rank: u64| self.quantile((rank - 1) as f64 / self.count.saturating_sub(1).max(1) as f64);
        let low = if low == 0 { f64::NEG_INFINITY } else { ranked(low)? - self.width };
        Ok([low, if high > self.count { f64::INFINITY } else { ranked(high)? + self.width }])
    }

    /// Histogram over `spans` equal spans from minimum to maximum. Binned values count at the middle of their
    /// bin, so a value may be assigned to a span up to half a bin width away.
    ///
    /// # Errors
    /// No spans or more than 2²⁴; no values.
    pub fn histogram(&self, spans: usize) -> Result<Vec<HistogramSpan>, ParameterError> {
        const MAX_SPANS: usize = 1 << 24;
        check::at_least("spans of the histogram", spans, 1)?;
        check::count("spans of the histogram", &[spans], MAX_SPANS)?;
        if self.count == 0 {
            return Err(ParameterError::Empty { name: "values of the distribution".into(), min: 1 });
        }
        let width = self.max / spans as f64 - self.min / spans as f64;
        let empty = |i: usize| HistogramSpan { middle: self.min + (i as f64 + 0.5) * width, count: 0 };
        let mut counts: Vec<HistogramSpan> = (0..spans).map(empty).collect();
        let bins = self
            .bins
            .iter()
            .enumerate()
            .map(|(i, &count)| ((self.first + i as f64 + 0.5) * self.width, count));
        for (x, count) in self.pilot.iter().map(|x| (*x, 1)).chain(bins) {
            let place = ((x - self.min) / width).clamp(0.0, spans.saturating_sub(1) as f64);
            if let Some(span) = counts.get_mut(place as usize) {
                span.count += count;
            }
        }
        Ok(counts)
    }
}

/// A span of a [histogram](Distribution::histogram).
///
/// ```
/// use gear_dynamics::sweep::Distribution;
/// let last = Distribution::of_samples([0.0, 1.0, 4.0]).histogram(2)?[1];
/// assert_eq!((last.middle, last.count), (3.0, 1));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct HistogramSpan {
    /// Middle of the span.
    pub middle: f64,
    /// Number of values in it.
    pub count: u64,
}
