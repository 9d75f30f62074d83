//! Fourier series.

use crate::error::{ParameterError, check};
use crate::excitation::angle::{Excitation, same};
use crate::excitation::jet::Jet;
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
        Ok(Fourier { mean, pairs: pairs.to_vec() })
    }

    /// The series f(φ) = mean + Σ_n A_n cos(n φ + φ_n) from pairs (A_n, φ_n `[rad]`), by order from 1.
    ///
    /// # Errors
    /// A mean, amplitude or phase beyond ±1e50; more than 10 000 orders.
    pub fn from_amplitudes(mean: f64, amplitudes: &[[f64; 2]]) -> Result<Self, ParameterError> {
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
    pub(crate) fn jet_of(&self, (s1, c1): (f64, f64), times: f64) -> Jet {
        let (mut s, mut c, mut w) = (s1, c1, 0.0);
        let mut jet = Jet::constant(self.mean);
        for (n, &[cos, sin]) in self.pairs.iter().enumerate() {
            if n > 0 {
                (s, c) = (s * c1 + c * s1, c * c1 - s * s1);
            }
            w += times;
            let wave = cos * c + sin * s;
            jet.value += wave;
            jet.rate += w * (sin * c - cos * s);
            jet.second -= w * w * wave;
        }
        jet
    }
}

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

impl Excitation for Fourier {
    #[inline]
    fn jet(&self, angle: f64) -> Jet {
        self.jet_of(sincos(angle), 1.0)
    }
    #[inline]
    fn value(&self, angle: f64) -> f64 {
        let (s1, c1) = sincos(angle);
        let (mut s, mut c, mut value) = (s1, c1, self.mean);
        for (n, &[cos, sin]) in self.pairs.iter().enumerate() {
            if n > 0 {
                (s, c) = (s * c1 + c * s1, c * c1 - s * s1);
            }
            value += cos * c + sin * s;
        }
        value
    }
    fn same_as(&self, other: &dyn Excitation) -> bool {
        same(self, other)
    }
}
