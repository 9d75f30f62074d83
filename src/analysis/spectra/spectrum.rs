//! Amplitude spectra.

use crate::analysis::spectra::window::Window;
use crate::error::{ParameterError, check};
use crate::export::ResultTable;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;

/// Number of lines of a two-sided spectrum of n samples that the line k of a one-sided one stands for.
pub(crate) fn sided(k: usize, n: usize) -> f64 {
    if k == 0 || 2 * k == n { 1.0 } else { 2.0 }
}

/// A one-sided amplitude spectrum. A sine of amplitude A on a line reads A with every window; a constant
/// reads its absolute value at frequency 0.
///
/// A_k = s |Σ_m w_m x_m exp(-2πi k m/n)|/Σ_m w_m, with s = 1 at k = 0 and k = n/2 and s = 2 otherwise.
///
/// ```
/// use gear_dynamics::analysis::{Spectrum, Window};
/// let sine: Vec<f64> = (0..64).map(|i| (i as f64 * std::f64::consts::TAU * 5.0 / 64.0).sin()).collect();
/// let spectrum = Spectrum::new(&sine, 1.0 / 64.0, Window::Hann)?;
/// assert!((spectrum.amplitudes()[5] - 1.0).abs() < 1e-14);
/// assert_eq!(spectrum.frequencies()[5], 5.0);
/// assert_eq!(spectrum.orders(2.5)?[5], 2.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    frequencies: Vec<f64>,
    amplitudes: Vec<f64>,
    phases: Vec<f64>,
}

impl Spectrum {
    /// The spectrum of n uniform samples at the distance `spacing` `[s]`. The lines are at k/(n spacing) with
    /// k = 0 .. n/2.
    ///
    /// The spectrum of a channel that jumps, for example a mesh force with rectangular stiffness, contains
    /// aliases. For such a channel sample finely and take the mean from [`Statistics`](crate::Statistics).
    ///
    /// # Errors
    /// Fewer than 2 or more than 2²⁶ samples; a sample that is NaN or infinite; a spacing outside 1e-50 ..
    /// 1e50; an amplitude that overflows.
    pub fn new(samples: &[f64], spacing: f64, window: Window) -> Result<Self, ParameterError> {
        let n = samples.len();
        check::at_least("samples", n, 2)?;
        check::all_finite("samples", samples)?;
        check::scale("spacing", spacing)?;
        let w = window.coefficients(n)?;
        let gain: f64 = w.iter().sum();
        let mut line: Vec<Complex64> =
            samples.iter().zip(&w).map(|(x, w)| Complex64::new(x * w, 0.0)).collect();
        FftPlanner::new().plan_fft_forward(n).process(&mut line);
        line.truncate(n / 2 + 1);
        let amplitudes: Vec<f64> =
            line.iter().enumerate().map(|(k, x)| sided(k, n) * x.norm() / gain).collect();
        for (k, amplitude) in amplitudes.iter().enumerate() {
            check::representable(format!("amplitude of line {k}"), *amplitude, samples)?;
        }
        Ok(Spectrum {
            frequencies: (0..line.len()).map(|k| k as f64 / (n as f64 * spacing)).collect(),
            amplitudes,
            phases: line.iter().map(|x| x.arg()).collect(),
        })
    }

    /// Frequencies `[Hz]`.
    pub fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }
    /// Amplitudes A, in the unit of the samples.
    pub fn amplitudes(&self) -> &[f64] {
        &self.amplitudes
    }
    /// Phases φ of A cos(2π f t + φ) `[rad]`.
    pub fn phases(&self) -> &[f64] {
        &self.phases
    }
    /// Levels 20 log10(A/A0) `[dB]` with the reference amplitude A0, in the unit of the samples; -∞ for an
    /// amplitude of 0.
    ///
    /// # Errors
    /// A reference outside 1e-50 .. 1e50.
    pub fn decibels(&self, reference: f64) -> Result<Vec<f64>, ParameterError> {
        let reference = check::scale("reference", reference)?;
        Ok(self.amplitudes.iter().map(|a| 20.0 * (libm::log10(*a) - libm::log10(reference))).collect())
    }
    /// The frequencies as orders of a base frequency `[Hz]`, for example that of a shaft or of a mesh.
    ///
    /// # Errors
    /// A base frequency outside 1e-50 .. 1e50.
    pub fn orders(&self, base: f64) -> Result<Vec<f64>, ParameterError> {
        orders(&self.frequencies, base)
    }
    /// A table of frequency `[Hz]`, amplitude and phase `[rad]`.
    pub fn table(&self) -> ResultTable {
        let rows = self.frequencies.iter().zip(&self.amplitudes).zip(&self.phases);
        let columns = [("frequency", "Hz"), ("amplitude", ""), ("phase", "rad")];
        ResultTable::of_rows(columns, rows.map(|((f, a), phase)| [*f, *a, *phase]))
    }
}

/// Frequencies over a base frequency.
pub(crate) fn orders(frequencies: &[f64], base: f64) -> Result<Vec<f64>, ParameterError> {
    let base = check::scale("base frequency", base)?;
    Ok(frequencies.iter().map(|f| f / base).collect())
}
