//! Transforms between coefficients and samples: the discrete Fourier transform of pairs of real signals, and
//! the places of the kept orders in it.

use crate::periodic::balance::series::harmonics::Harmonics;
use num_complex::Complex64;
use rustfft::Fft;
use rustfft::FftPlanner;
use std::sync::Arc;
use std::sync::LazyLock;
use std::sync::Mutex;
use std::sync::PoisonError;

/// Plans of the transforms, shared by all balances.
static PLANNER: LazyLock<Mutex<FftPlanner<f64>>> = LazyLock::new(|| Mutex::new(FftPlanner::new()));

/// Transforms of length M, with their scratch array.
pub(crate) struct Transform {
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    scratch: Vec<Complex64>,
}

impl Transform {
    pub(crate) fn new(samples: usize) -> Self {
        let mut planner = PLANNER.lock().unwrap_or_else(PoisonError::into_inner);
        let (forward, inverse) = (planner.plan_fft_forward(samples), planner.plan_fft_inverse(samples));
        let scratch =
            vec![Complex64::ZERO; forward.get_inplace_scratch_len().max(inverse.get_inplace_scratch_len())];
        Transform { forward, inverse, scratch }
    }

    /// Z_k to samples Σ_k Z_k e^{i k ω t}, in place.
    pub(crate) fn synthesise(&mut self, buffer: &mut [Complex64]) {
        self.inverse.process_with_scratch(buffer, &mut self.scratch);
    }

    /// Samples to M Z_k, in place.
    pub(crate) fn analyse(&mut self, buffer: &mut [Complex64]) {
        self.forward.process_with_scratch(buffer, &mut self.scratch);
    }
}

/// Indices of orders k and -k in a spectrum of length m.
#[inline]
fn places(k: usize, m: usize) -> (usize, usize) {
    // Usually k < m: this needs no division.
    let here = if k < m { k } else { k % m };
    (here, if here == 0 { 0 } else { m - here })
}

/// Complex coefficients X_k and Y_k of the real signals x and y, from the transform of x + i y.
#[inline]
pub(crate) fn unpack(buffer: &[Complex64], k: usize) -> (Complex64, Complex64) {
    let (here, mirror) = places(k, buffer.len());
    let (z, mirror) = (buffer[here], buffer[mirror].conj());
    let per = 0.5 / buffer.len() as f64;
    let y = (z - mirror) * per;
    ((z + mirror) * per, Complex64::new(y.im, -y.re))
}

/// Number of samples: at least 32 in one cycle of the highest order, so that local polynomials of degree 15
/// are exact to rounding. At least 256, a power of two.
pub(crate) fn samples_for(highest: usize) -> usize {
    (32 * highest).next_power_of_two().max(256)
}

/// Q_k of Σ_k Q_k e^{i k ω t}, from the coefficients of one coordinate; 0 for an order that is not kept.
pub(crate) fn read(part: &[f64], harmonics: &Harmonics, order: usize) -> Complex64 {
    match harmonics.place_of(order) {
        None => Complex64::ZERO,
        Some(at) if order == 0 => part[at].into(),
        Some(at) => Complex64::new(0.5 * part[at], -0.5 * part[at + 1]),
    }
}

/// Writes the cosine and sine coefficients of X_k, or the mean for order 0.
#[inline]
pub(crate) fn write(out: &mut [f64], order: usize, x: Complex64) {
    if order == 0 {
        out[0] = x.re;
    } else {
        (out[0], out[1]) = (2.0 * x.re, -2.0 * x.im);
    }
}

/// Computes the spectrum of q + i q' of one coordinate.
pub(crate) fn spread(part: &[f64], harmonics: &Harmonics, omega: f64, z: &mut [Complex64]) {
    z.fill(Complex64::ZERO);
    for (i, &order) in harmonics.orders().iter().enumerate() {
        let at = harmonics.place(i);
        if order == 0 {
            z[0] += part[at];
        } else {
            // At k: Q + i V with V = i k ω Q. At -k: the same with the conjugates of Q and V.
            let (q, rate) = (Complex64::new(0.5 * part[at], -0.5 * part[at + 1]), omega * order as f64);
            let (here, mirror) = places(order, z.len());
            z[here] += q * (1.0 - rate);
            z[mirror] += q.conj() * (1.0 + rate);
        }
    }
}
