//! Fourier series.

use crate::error::{ParameterError, check};
use crate::excitation::enclosed_angle::EnclosedAngle;
use crate::excitation::jet::Jet;
use crate::excitation::wave_weights::{Sizes, WaveWeights};
use crate::interval::number::Interval;
use crate::numeric::sine::{sin_cos_of_multiples, turned};
use crate::scalar::Scalar;
use crate::series::{BLOCKS, EIGHT, PowerSeries, Series};
use std::cell::Cell;
use std::f64::consts::TAU;

/// Fourier series f(φ) = mean + Σ_n c_n cos(n φ) + s_n sin(n φ), n = 1, 2, ...   Source: Liu 2021, Eqs. (6),
/// (7).
///
/// ```
/// use gear_dynamics::excitation::{Excitation, Fourier};
/// let stiffness = Fourier::new(3.1e8, &[[0.9e8, 0.0]])?; // k0 + k_r cos φ [N/m]
/// assert_eq!(stiffness.value(0.0), 4.0e8);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Fourier {
    mean: f64,
    pairs: Vec<[f64; 2]>,
    /// The orders of the pairs that are not 0, with the weights of their Taylor coefficients.
    weights: Vec<(usize, WaveWeights)>,
    /// What the sums of many of them may hide.
    sizes: Option<Box<Sizes>>,
}

impl Fourier {
    /// The series with a mean and pairs (c_n, s_n) of cosine and sine coefficients, by order from 1.
    ///
    /// # Errors
    /// A mean or coefficient beyond ±1e50; more than 10 000 orders.
    pub fn new(mean: f64, pairs: &[[f64; 2]]) -> Result<Self, ParameterError> {
        check::quantity("mean", mean)?;
        check::count("orders of the series", &[pairs.len()], check::ORDERS)?;
        for (i, pair) in pairs.iter().enumerate() {
            check::quantity(format!("cosine coefficient of order {}", i + 1), pair[0])?;
            check::quantity(format!("sine coefficient of order {}", i + 1), pair[1])?;
        }
        Ok(Fourier::unchecked(mean, pairs.to_vec()))
    }

    /// The series f(φ) = mean + Σ_n A_n cos(n φ + φ_n) from pairs (A_n, φ_n `[rad]`), by order from 1.
    ///
    /// # Errors
    /// A mean, amplitude or phase beyond ±1e50; more than 10 000 orders.
    pub fn of_amplitudes(mean: f64, amplitudes: &[[f64; 2]]) -> Result<Self, ParameterError> {
        for (i, pair) in amplitudes.iter().enumerate() {
            check::quantity(format!("amplitude of order {}", i + 1), pair[0])?;
            check::quantity(format!("phase of order {}", i + 1), pair[1])?;
        }
        let pairs: Vec<_> =
            amplitudes.iter().map(|&[a, phi]| [a * libm::cos(phi), -a * libm::sin(phi)]).collect();
        Fourier::new(mean, &pairs)
    }

    /// The series up to `order` of M uniform samples x_i of one period, the first at φ = 0.
    ///
    /// mean = 1/M Σ_i x_i, c_n = 2/M Σ_i x_i cos(2π n i/M), s_n = 2/M Σ_i x_i sin(2π n i/M). Liu 2021 (below
    /// Eq. 19) obtains the mean stiffness and its amplitudes in this way from a computed stiffness curve.
    ///
    /// # Errors
    /// Fewer than `2 order + 1` samples, which do not determine all orders; a sample or a coefficient beyond
    /// ±1e50; an order above 10 000.
    pub fn fit(samples: &[f64], order: usize) -> Result<Self, ParameterError> {
        let least = order.saturating_mul(2).saturating_add(1);
        if samples.len() < least {
            return Err(ParameterError::TooFew { name: "samples".into(), value: samples.len(), min: least });
        }
        check::quantities("samples", samples)?;
        check::count("order", &[order], check::ORDERS)?;
        let m = samples.len();
        let mean = samples.iter().sum::<f64>() / m as f64;
        let pairs: Vec<_> = (1..=order)
            .map(|n| {
                let mut pair = [0.0; 2];
                for (i, x) in samples.iter().enumerate() {
                    // The angle is reduced in integers, so that high orders lose no digits.
                    let (s, c) = libm::sincos(TAU * ((n * i) % m) as f64 / m as f64);
                    pair[0] += 2.0 / m as f64 * x * c;
                    pair[1] += 2.0 / m as f64 * x * s;
                }
                pair
            })
            .collect();
        Fourier::new(mean, &pairs)
    }

    fn unchecked(mean: f64, pairs: Vec<[f64; 2]>) -> Self {
        let orders = (1..).zip(&pairs).filter(|(_, pair)| **pair != [0.0; 2]);
        let weights: Vec<_> = orders.map(|(n, _)| (n, WaveWeights::new(n as f64))).collect();
        let terms = weights.iter().map(|(n, w)| (*n as f64, pairs[n - 1][0].hypot(pairs[n - 1][1]), w));
        let sizes = Sizes::of(terms).map(Box::new);
        Fourier { mean, pairs, weights, sizes }
    }

    /// Mean of the series.
    pub fn mean(&self) -> f64 {
        self.mean
    }
    /// Pairs of cosine and sine coefficients, by order from 1.
    pub fn pairs(&self) -> &[[f64; 2]] {
        &self.pairs
    }
}

impl Fourier {
    /// f(φ) and its derivatives over φ/times, from sin φ and cos φ.
    #[inline]
    pub(crate) fn jet_of<S: Scalar>(&self, first: (S, S), times: f64) -> Jet<S> {
        let ((mut s, mut c), mut w) = (first, 0.0);
        let mut jet = Jet::constant(S::from(self.mean));
        for (n, &[cos, sin]) in self.pairs.iter().enumerate() {
            if n > 0 {
                (s, c) = S::turned((s, c), first);
            }
            w += times;
            let wave = c * cos + s * sin;
            jet.value = jet.value + wave;
            jet.rate = jet.rate + (c * sin - s * cos) * w;
            jet.second = jet.second - wave * (w * w);
        }
        jet
    }

    /// The series of f(φ) over time at a constant speed φ' = w, and those of f' and f'' if `jet` is set.
    ///
    /// Coefficient k of a cos nφ + b sin nφ over φ is n^k/k! times a cos nφ + b sin nφ, b cos nφ - a sin nφ
    /// and their negatives in turn.
    fn turning(&self, angle: &Series, w: f64, jet: bool) -> Jet<Series> {
        let mut sums = [[0.0; EIGHT]; BLOCKS];
        sums[0][0] = self.mean;
        let first = libm::sincos(angle.at(0.0));
        let ((mut s, mut c), mut at) = (first, 1);
        for (n, weights) in &self.weights {
            (s, c) = match n - at {
                0 => (s, c),
                1 => turned((s, c), first),
                _ => {
                    let [[s], [c]] = sin_cos_of_multiples(*n as f64, [angle.at(0.0)]);
                    (s, c)
                }
            };
            at = *n;
            let [cos, sin] = self.pairs[n - 1];
            weights.add([cos * c + sin * s, sin * c - cos * s], &mut sums);
        }
        let (sums, highest) = (sums.as_flattened(), self.weights.last().map_or(0.0, |(n, _)| *n as f64));
        let series = |derivative: usize| {
            let mut power = 1.0;
            let derived = |k: usize, coefficient: f64| match derivative {
                0 => coefficient,
                1 => (k + 1) as f64 * coefficient,
                _ => ((k + 1) * (k + 2)) as f64 * coefficient,
            };
            let mut last = [0.0; 2];
            let series = Series::from_coefficients(angle, |k| {
                let size = self.sizes.as_ref().map_or(0.0, |sizes| sizes.at(k + derivative));
                last = [derived(k, power.abs() * size), last[0]];
                let coefficient = power * sums.get(k + derivative).copied().unwrap_or(0.0);
                power *= w;
                derived(k, coefficient)
            });
            let noise =
                self.sizes.as_ref().map_or(0.0, |sizes| derived(0, f64::EPSILON * sizes.at(derivative)));
            let last = self.sizes.is_some().then_some(last);
            series.as_waves(self.weights.len(), highest * w.abs(), last, noise)
        };
        let mut of = Jet::constant(series(0));
        if jet {
            (of.rate, of.second) = (series(1), series(2));
        }
        of
    }

    /// The sum of two series; `None` if it has too many waves.
    pub(crate) fn plus(&self, other: &Fourier) -> Option<Fourier> {
        let mut sum = self.clone();
        sum.mean += other.mean;
        sum.pairs.resize(self.pairs.len().max(other.pairs.len()), [0.0; 2]);
        for (pair, of) in sum.pairs.iter_mut().zip(&other.pairs) {
            *pair = [pair[0] + of[0], pair[1] + of[1]];
        }
        sum.if_short()
    }
    /// The product of two series; `None` if it has too many waves.
    pub(crate) fn times(&self, other: &Fourier) -> Option<Fourier> {
        if self.pairs.len() + other.pairs.len() > check::ORDERS {
            return None;
        }
        let mut product = Fourier::unchecked(0.0, vec![[0.0; 2]; self.pairs.len() + other.pairs.len()]);
        for (n, [a, b]) in self.waves() {
            for (m, [c, d]) in other.waves() {
                // The product of two waves is half a wave of the sum and half one of the difference.
                let half = if n == 0 || m == 0 { 1.0 } else { 0.5 };
                product.add(n + m, [half * (a * c - b * d), half * (a * d + b * c)]);
                if half == 0.5 {
                    let sign = if n >= m { 1.0 } else { -1.0 };
                    product.add(n.abs_diff(m), [0.5 * (a * c + b * d), sign * 0.5 * (b * c - a * d)]);
                }
            }
        }
        product.if_short()
    }
    /// The series of f(order φ + phase) over φ; `None` if it has too many orders.
    pub(crate) fn repeated(&self, order: u32, phase: f64) -> Option<Fourier> {
        let order = order as usize;
        let length = self.pairs.len().checked_mul(order).filter(|length| *length <= check::ORDERS)?;
        let mut repeated = Fourier::unchecked(self.mean, vec![[0.0; 2]; length]);
        for (n, [a, b]) in self.waves().skip(1) {
            let (s, c) = libm::sincos(n as f64 * phase);
            repeated.add(n * order, [a * c + b * s, b * c - a * s]);
        }
        repeated.if_short()
    }
    /// Orders with their pairs, the mean as order 0 first.
    fn waves(&self) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
        let pairs = (1..).zip(self.pairs.iter().copied()).filter(|(_, pair)| *pair != [0.0; 2]);
        std::iter::once((0, [self.mean, 0.0])).chain(pairs)
    }
    fn add(&mut self, order: usize, [cos, sin]: [f64; 2]) {
        match order {
            0 => self.mean += cos,
            _ => {
                let [c, s] = &mut self.pairs[order - 1];
                (*c, *s) = (*c + cos, *s + sin);
            }
        }
    }
    /// The series, if it has at most [`WAVES`] waves, so that its expansion is faster than that of its parts.
    pub(crate) fn if_short(self) -> Option<Fourier> {
        let short = Fourier::unchecked(self.mean, self.pairs);
        (short.weights.len() <= WAVES).then_some(short)
    }
}

/// Maximum number of waves of an expanded product.
const WAVES: usize = 64;

thread_local! {
    /// The angle of the last evaluation, its sine and its cosine.
    static LAST: Cell<[f64; 3]> = const { Cell::new([0.0, 0.0, 1.0]) };
}

/// sin x and cos x. The last result is stored, because waves of the same order and phase are evaluated one
/// after the other at the same angle.
#[inline]
fn sincos(x: f64) -> (f64, f64) {
    let [last, s, c] = LAST.get();
    if last.to_bits() == x.to_bits() {
        return (s, c);
    }
    let (s, c) = libm::sincos(x);
    LAST.set([x, s, c]);
    (s, c)
}

impl Fourier {
    /// f and its derivatives over the angle.
    #[inline]
    pub(crate) fn jet_at(&self, angle: f64) -> Jet {
        self.jet_of(sincos(angle), 1.0)
    }
    /// f alone.
    #[inline]
    pub(crate) fn value_at(&self, angle: f64) -> f64 {
        let first = sincos(angle);
        let ((mut s, mut c), mut value) = (first, self.mean);
        for (n, &[cos, sin]) in self.pairs.iter().enumerate() {
            if n > 0 {
                (s, c) = turned((s, c), first);
            }
            value += cos * c + sin * s;
        }
        value
    }
    /// f and its derivatives over the angle as series over time; f alone without `derivatives`.
    pub(crate) fn series_at(&self, angle: &Series, derivatives: bool) -> Jet<Series> {
        match *angle.coefficients() {
            [_, w] => self.turning(angle, w, derivatives),
            _ => self.jet_of(angle.sin_cos(), 1.0),
        }
    }
    /// Enclosures of f and its derivatives over the angle.
    pub(crate) fn enclosure_at(&self, angle: EnclosedAngle) -> Jet<PowerSeries<Interval>> {
        let mut jet = Jet::constant(PowerSeries::from(self.mean));
        for (n, _) in &self.weights {
            let ([sin, cos], [a, b], n) = (angle.sin_cos(*n as f64), self.pairs[n - 1], *n as f64);
            let wave = cos * a + sin * b;
            jet.value = jet.value + wave;
            jet.rate = jet.rate + (cos * b - sin * a) * n;
            jet.second = jet.second - wave * n * n;
        }
        jet
    }
}
