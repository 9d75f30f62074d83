//! Windows of spectra.

use crate::error::{ParameterError, check};
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
