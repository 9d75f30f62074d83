//! Power densities.

use crate::analysis::spectra::spectrum::{orders, sided};
use crate::error::{ParameterError, check};
use crate::export::ResultTable;
use crate::numeric::chi_square::quantile;

/// A one-sided power density S(f), in the square of the unit of the samples per hertz.
///
/// S_k = s Δt/(Σ_m w_m²) mean |Σ_m w_m x_m exp(-2πi k m/n)|², the mean over all segments, with s = 1 at k = 0
/// and k = n/2 and s = 2 otherwise. Σ_k S_k Δf is the mean square of the samples, weighted by w²: exactly
/// that of the samples for one segment and the rectangular window.
///
/// [`Welch`](crate::analysis::Welch) computes it.
///
/// ```
/// use gear_dynamics::analysis::{Welch, Window};
/// // One segment, no window: Parseval's theorem. White noise of variance σ² has S = 2 σ² Δt.
/// let x = [0.3, -1.0, 0.7, 2.0, -0.4, 0.1];
/// let density = Welch::new(6).window(Window::Rectangular).density(&x, 0.5)?;
/// let mean_square = x.iter().map(|x| x * x).sum::<f64>() / 6.0;
/// assert!((density.mean_square() - mean_square).abs() < 1e-15);
/// assert_eq!(density.frequencies()[1], 1.0 / 3.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Density {
    pub(crate) frequencies: Vec<f64>,
    pub(crate) values: Vec<f64>,
    /// Number of samples in a segment.
    pub(crate) samples: usize,
    pub(crate) bandwidth: f64,
    pub(crate) segments: usize,
    pub(crate) degrees: f64,
}

impl Density {
    /// Frequencies `[Hz]`.
    pub fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }
    /// Densities S, in unit²/Hz.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
    /// Number of segments in the mean.
    pub fn segments(&self) -> usize {
        self.segments
    }
    /// Degrees of freedom ν of a line: twice the number of segments, less where they overlap,
    ///
    /// ν = 2 K/(1 + 2 Σ_j (1 - j/K) ρ_j²),   ρ_j = Σ_m w_m w_{m + j stride}/Σ_m w_m²
    ///
    /// for K segments. The lines k = 0 and k = n/2 have ν/2.   Source: Welch 1967.
    pub fn degrees_of_freedom(&self) -> f64 {
        self.degrees
    }
    /// The factors [ν/χ²(1 - α/2), ν/χ²(α/2)] of S, with α = 1 - level. For a stationary normal process the
    /// interval from the first to the second times S contains the expected density of a line with this
    /// probability. It holds for its line alone, not for all lines together, nor for k = 0 and k = n/2; lines
    /// of a periodic motion do not scatter so.
    ///
    /// Source: Bendat and Piersol, Random Data, 4th ed., Sect. 8.5.
    ///
    /// ```
    /// use gear_dynamics::analysis::Welch;
    /// let samples: Vec<f64> = (0..160).map(|i| f64::from(i * i % 17)).collect();
    /// let density = Welch::new(32).overlap(0.0).density(&samples, 0.1)?; // five segments: ν = 10
    /// let [low, high] = density.confidence(0.95)?;
    /// assert!((low - 10.0 / 20.483177).abs() < 1e-7 && (high - 10.0 / 3.246973).abs() < 1e-5);
    /// # Ok::<(), gear_dynamics::ParameterError>(())
    /// ```
    ///
    /// # Errors
    /// A level outside (0, 1).
    pub fn confidence(&self, level: f64) -> Result<[f64; 2], ParameterError> {
        let tail = 0.5 * (1.0 - check::share("confidence level", level)?);
        Ok([1.0 - tail, tail].map(|p| self.degrees / quantile(p, self.degrees)))
    }
    /// Equivalent noise bandwidth B = Σ w²/((Σ w)² Δt) of the window `[Hz]`: 1.5 lines for the Hann window.
    pub fn noise_bandwidth(&self) -> f64 {
        self.bandwidth
    }
    /// Averaged amplitudes A_k = √(s S_k B), in the unit of the samples, with s = 1 at k = 0 and k = n/2 and
    /// s = 2 otherwise. A sine of amplitude A on a line reads A, as in a
    /// [`Spectrum`](crate::analysis::Spectrum).
    pub fn amplitudes(&self) -> Vec<f64> {
        let n = self.samples;
        self.values.iter().enumerate().map(|(k, s)| (sided(k, n) * s * self.bandwidth).sqrt()).collect()
    }
    /// Σ_k S_k Δf, in unit²: the power of all lines.
    pub fn mean_square(&self) -> f64 {
        self.values.iter().map(|s| s * self.frequencies[1]).sum()
    }
    /// Levels 10 log10(S/S0) `[dB]` with the reference S0, in unit²/Hz; -∞ for a density of 0.
    ///
    /// # Errors
    /// A reference outside 1e-50 .. 1e50.
    pub fn decibels(&self, reference: f64) -> Result<Vec<f64>, ParameterError> {
        let reference = check::scale("reference", reference)?;
        Ok(self.values.iter().map(|s| 10.0 * (libm::log10(*s) - libm::log10(reference))).collect())
    }
    /// The frequencies as orders of a base frequency `[Hz]`, for example that of a shaft or of a mesh.
    ///
    /// # Errors
    /// A base frequency outside 1e-50 .. 1e50.
    pub fn orders(&self, base: f64) -> Result<Vec<f64>, ParameterError> {
        orders(&self.frequencies, base)
    }
    /// A table of frequency `[Hz]`, density per hertz and averaged amplitude.
    pub fn table(&self) -> ResultTable {
        let rows = self.frequencies.iter().zip(&self.values).zip(self.amplitudes());
        let columns = [("frequency", "Hz"), ("density", ""), ("amplitude", "")];
        ResultTable::of_rows(columns, rows.map(|((f, s), a)| [*f, *s, a]))
    }
}
