//! Between coefficients and samples: the discrete Fourier transform of pairs of real signals.

use num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

/// Plans once made serve every balance.
static PLANNER: LazyLock<Mutex<FftPlanner<f64>>> = LazyLock::new(|| Mutex::new(FftPlanner::new()));

/// Transforms of length M, with their working array.
pub(super) struct Transform {
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    scratch: Vec<Complex64>,
}

impl Transform {
    pub(super) fn new(samples: usize) -> Self {
        let mut planner = PLANNER.lock().unwrap_or_else(PoisonError::into_inner);
        let (forward, inverse) = (planner.plan_fft_forward(samples), planner.plan_fft_inverse(samples));
        let scratch = vec![Complex64::ZERO; forward.get_inplace_scratch_len().max(inverse.get_inplace_scratch_len())];
        Transform { forward, inverse, scratch }
    }

    /// Spectra to samples: Σ_k Z_k e^{+i k ω t}.
    pub(super) fn synthesise(&mut self, buffer: &mut [Complex64]) {
        self.inverse.process_with_scratch(buffer, &mut self.scratch);
    }

    /// Samples of x + i y to M Z_k.
    pub(super) fn analyse(&mut self, buffer: &mut [Complex64]) {
        self.forward.process_with_scratch(buffer, &mut self.scratch);
    }
}

/// The complex coefficients X_k and Y_k of the two real signals x and y whose x + i y was analysed.
#[inline]
pub(super) fn unpack(buffer: &[Complex64], k: usize) -> (Complex64, Complex64) {
    let m = buffer.len();
    let (z, mirror) = (buffer[k % m], buffer[(m - k % m) % m].conj());
    let per = 0.5 / m as f64;
    let y = (z - mirror) * per;
    ((z + mirror) * per, Complex64::new(y.im, -y.re))
}
