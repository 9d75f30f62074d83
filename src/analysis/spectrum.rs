//! Amplitude spectra.

use crate::error::{ParameterError, check};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use std::f64::consts::TAU;

/// A window by its usual name. All windows are in the periodic form, for spectra, not in the symmetric form
/// for filters. Default: rectangular.
///
/// Source: Harris, Proc. IEEE 66 (1978) 51; flat top: D'Antona and Ferrero, Digital Signal Processing for
/// Measurement Systems, 2006, p. 70.
///
/// ```
/// let hann = gear_dynamics::analysis::Window::Hann.coefficients(4)?;
/// assert!((hann[1] - 0.5).abs() < 1e-15 && hann[2] == 1.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Window {
    /// Rectangular: no weighting. The amplitudes are exact if the samples fill whole periods.
    #[default]
    Rectangular,
    /// Hann window.
    Hann,
    /// Hamming window.
    Hamming,
    /// Blackman window.
    Blackman,
    /// Flat-top window. The amplitude of a sine between two lines is accurate to 0.1 %.
    FlatTop,
}

impl Window {
    /// The n weights w_i = Σ_k (-1)^k a_k cos(2π k i/n), i = 0 .. n - 1.
    ///
    /// # Errors
    /// More than 2²⁶ coefficients.
    pub fn coefficients(self, n: usize) -> Result<Vec<f64>, ParameterError> {
        check::count("coefficients of the window", &[n], check::NUMBERS)?;
        let a: &[f64] = match self {
            Window::Rectangular => &[1.0],
            Window::Hann => &[0.5, 0.5],
            Window::Hamming => &[0.54, 0.46],
            Window::Blackman => &[0.42, 0.5, 0.08],
            Window::FlatTop => &[0.215_578_95, 0.416_631_58, 0.277_263_158, 0.083_578_947, 0.006_947_368],
        };
        let at = |i: usize| {
            let x = TAU * i as f64 / n as f64;
            a.iter()
                .enumerate()
                .map(|(k, a)| if k % 2 == 0 { *a } else { -a } * libm::cos(k as f64 * x))
                .sum()
        };
        Ok((0..n).map(at).collect())
    }
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
        if n < 2 {
            return Err(ParameterError::TooFew { name: "samples".into(), value: n, min: 2 });
        }
        check::all_finite("samples", samples)?;
        check::scale("spacing", spacing)?;
        let w = window.coefficients(n)?;
        let gain: f64 = w.iter().sum();
        let mut line: Vec<Complex64> =
            samples.iter().zip(&w).map(|(x, w)| Complex64::new(x * w, 0.0)).collect();
        FftPlanner::new().plan_fft_forward(n).process(&mut line);
        line.truncate(n / 2 + 1);
        let sided = |k: usize| if k == 0 || 2 * k == n { 1.0 } else { 2.0 };
        let amplitudes: Vec<f64> = line.iter().enumerate().map(|(k, x)| sided(k) * x.norm() / gain).collect();
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
    /// The frequencies as orders of a base frequency `[Hz]`, for example that of a shaft or of a mesh.
    ///
    /// # Errors
    /// A base frequency outside 1e-50 .. 1e50.
    pub fn orders(&self, base: f64) -> Result<Vec<f64>, ParameterError> {
        let base = check::scale("base frequency", base)?;
        Ok(self.frequencies.iter().map(|f| f / base).collect())
    }
}
