//! Averages over segments of a signal.

use crate::analysis::spectra::density::Density;
use crate::analysis::spectra::spectrum::sided;
use crate::analysis::spectra::window::Window;
use crate::error::{ParameterError, check};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;

/// Averaged power density by Welch's method: segments that overlap, each with a window, are transformed, and
/// the squares of their magnitudes averaged.
///
/// Defaults: half overlap, Hann window, mean values kept.   Source: Welch, IEEE Trans. Audio Electroacoust.
/// 15 (1967) 70.
///
/// ```
/// use gear_dynamics::analysis::Welch;
/// // A sine of amplitude 2 has the mean square 2.
/// let angle = |i: u32| f64::from(i) * std::f64::consts::TAU / 16.0;
/// let sine: Vec<f64> = (0..640).map(|i| 2.0 * angle(i).sin()).collect();
/// let density = Welch::new(128).density(&sine, 0.01)?;
/// assert_eq!(density.segments(), 9);
/// assert!((density.mean_square() - 2.0).abs() < 1e-12);
/// assert!((density.amplitudes()[8] - 2.0).abs() < 1e-12); // 6.25 Hz, the eighth line
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct Welch {
    segment: usize,
    overlap: f64,
    window: Window,
    centred: bool,
}

impl Welch {
    /// Averages over segments of `segment` samples.
    pub fn new(segment: usize) -> Self {
        Welch { segment, overlap: 0.5, window: Window::Hann, centred: false }
    }
    /// Share of a segment that it has in common with the next one `[1]`, in [0, 1). Default: 0.5.
    pub fn overlap(self, overlap: f64) -> Self {
        Welch { overlap, ..self }
    }
    /// The window of every segment. Default: [`Window::Hann`].
    pub fn window(self, window: Window) -> Self {
        Welch { window, ..self }
    }
    /// Subtracts from each segment its mean value. A window spreads the mean value over the lowest lines.
    pub fn centred(self) -> Self {
        Welch { centred: true, ..self }
    }

    /// The density of n uniform samples at the distance `spacing` `[s]`, with lines at k/(m spacing), k = 0
    /// .. m/2, for segments of m samples. Samples after the last complete segment are ignored.
    ///
    /// # Errors
    /// A segment of fewer than 2 or more than 2²⁶ samples; fewer samples than a segment; an overlap outside
    /// [0, 1); a sample that is NaN or infinite; a spacing outside 1e-50 .. 1e50; a density that overflows.
    pub fn density(&self, samples: &[f64], spacing: f64) -> Result<Density, ParameterError> {
        let n = self.segment;
        check::at_least("samples in a segment", n, 2)?;
        check::at_least("samples", samples.len(), n)?;
        let w = self.window.coefficients(n)?;
        let overlap = check::fraction("overlap", self.overlap)?;
        check::all_finite("samples", samples)?;
        check::scale("spacing", spacing)?;
        let square: f64 = w.iter().map(|w| w * w).sum();
        let stride = ((n as f64 * (1.0 - overlap)).round() as usize).max(1);
        let transform = FftPlanner::new().plan_fft_forward(n);
        let mut line = vec![Complex64::ZERO; n];
        let mut scratch = vec![Complex64::ZERO; transform.get_inplace_scratch_len()];
        let mut sums = vec![0.0; n / 2 + 1];
        let mut segments = 0usize;
        for segment in samples.windows(n).step_by(stride) {
            let mean = if self.centred { segment.iter().map(|x| x / n as f64).sum() } else { 0.0 };
            for ((z, x), w) in line.iter_mut().zip(segment).zip(&w) {
                *z = Complex64::new((x - mean) * w, 0.0);
            }
            transform.process_with_scratch(&mut line, &mut scratch);
            sums.iter_mut().zip(&line).for_each(|(sum, z)| *sum += z.norm_sqr());
            segments += 1;
        }
        let factor = spacing / (square * segments as f64);
        let values: Vec<f64> = sums.iter().enumerate().map(|(k, sum)| sided(k, n) * sum * factor).collect();
        for (k, value) in values.iter().enumerate() {
            check::representable(format!("density of line {k}"), *value, samples)?;
        }
        let gain: f64 = w.iter().sum();
        Ok(Density {
            frequencies: (0..values.len()).map(|k| k as f64 / (n as f64 * spacing)).collect(),
            values,
            samples: n,
            bandwidth: square / (gain * gain * spacing),
            segments,
            degrees: degrees_of_freedom(&w, stride, segments),
        })
    }
}

/// Degrees of freedom of an average over windowed segments.
fn degrees_of_freedom(w: &[f64], stride: usize, segments: usize) -> f64 {
    let square: f64 = w.iter().map(|w| w * w).sum();
    let count = segments as f64;
    let common = |j: usize| {
        let product: f64 = w.iter().zip(&w[j * stride..]).map(|(a, b)| a * b).sum();
        (1.0 - j as f64 / count) * (product / square).powi(2)
    };
    let overlaps = (1..segments).take_while(|j| j * stride < w.len()).map(common).sum::<f64>();
    2.0 * count / (1.0 + 2.0 * overlaps)
}
