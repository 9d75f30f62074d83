//! The traits of random processes and of their paths.

use crate::excitation::Side;
use crate::series::Series;
use std::sync::Arc;

/// An exponential memory is rounding, e^-37 < 2^-53, after this number of correlation or decay times.
pub(crate) const FORGOTTEN: f64 = 37.0;

/// A random process x(t): a law, from which paths are drawn.
///
/// [`Noisy`](crate::drives::Noisy) adds paths to the drives of a model. A path is a pure function of the
/// process, of its seed and member, and of the number of the stream; it may be read in any order.
///
/// The statistics of a process are those over all its paths. They are `None` where they have no closed form
/// or where the process does not know the moments of its distribution.
///
/// ```
/// use gear_dynamics::{excitation::Side, processes::{OrnsteinUhlenbeck, Process}};
/// let process = OrnsteinUhlenbeck::new(2.0, 0.1, 0.01)?; // 2 N m, 0.1 s, a grid of 0.01 s
/// let path = process.path(0);
/// assert_eq!(path.at(0.123, Side::After), process.path(0).at(0.123, Side::After));
/// assert_ne!(path.at(0.123, Side::After), process.path(1).at(0.123, Side::After));
/// assert_eq!(process.variance(), Some(4.0));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub trait Process: Send + Sync {
    /// The path of a stream. Paths of different streams are independent.
    fn path(&self, stream: u64) -> Arc<dyn Path>;
    /// Mean ⟨x⟩, in the unit of x.
    fn mean(&self) -> Option<f64> {
        None
    }
    /// Variance σ² = ⟨(x - ⟨x⟩)²⟩, in the square of the unit of x.
    fn variance(&self) -> Option<f64> {
        None
    }
    /// Correlation ⟨(x(t) - ⟨x⟩) (x(t + lag) - ⟨x⟩)⟩/σ² `[1]`; 1 at lag 0.
    fn correlation(&self, lag: f64) -> Option<f64> {
        let _ = lag;
        None
    }
    /// One-sided power density S(f) of x - ⟨x⟩ at a frequency f >= 0 `[Hz]`, in the square of the unit of x
    /// per hertz, as [`Welch`](crate::analysis::Welch) estimates it: ∫ S df = σ². Noise that is white up to
    /// the frequencies of a model has S = 2D; D is its two-sided intensity.
    fn density(&self, frequency: f64) -> Option<f64> {
        let _ = frequency;
        None
    }
}

/// One path of a [`Process`]: a function of time.
///
/// ```
/// use gear_dynamics::{excitation::Side, processes::{HeldProcess, Process}};
/// let path = HeldProcess::of_values(0.5, &[3.0, 5.0])?.path(0);
/// assert_eq!(path.at(0.5, Side::Before), 3.0);
/// assert_eq!(path.at(0.5, Side::After), 5.0);
/// assert_eq!(path.next_edge(0.2), Some(0.5));
/// assert_eq!(path.series(0.7, 8).coefficients(), [5.0]);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub trait Path: Send + Sync {
    /// The value x(t). `side`: before or after a jump at `t`.
    fn at(&self, t: f64, side: Side) -> f64;
    /// The first instant after `t` at which x or one of its derivatives jumps; `None` if there is none.
    fn next_edge(&self, t: f64) -> Option<f64>;
    /// x after `t` as a series over the time after `t`, for [`Taylor`](crate::Taylor), with at most this
    /// number of coefficients. Default: refused.
    fn series(&self, t: f64, coefficients: usize) -> Series {
        let _ = (t, coefficients);
        Series::refused("a random path without `Path::series`")
    }
}
