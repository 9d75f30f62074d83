//! The rectangular stiffness wave of a contact ratio.

use super::{Excitation, Fourier, Jet, Repeats};
use crate::error::{ParameterError, check};
use crate::piece::Side;
use std::f64::consts::{PI, TAU};

/// High while one pair of teeth more is in mesh, low otherwise; the high part lasts a share `duty` of the period and is centred on t = 0.
///
/// The edges are exact: solvers end their steps on them. [`series`](RectangularWave::series) is the truncated series
/// that most papers use instead.   Source: Lin & Parker 2002; ISO 6336-1 for the levels.
///
/// ```
/// use gear_dynamics::{Excitation, RectangularWave, Side};
/// let wave = RectangularWave::from_contact_ratio(1.5, 0.8, 1.2, 1.0)?;
/// assert_eq!(wave.value(0.24, Side::After), 1.2);
/// assert_eq!(wave.value(0.26, Side::After), 0.8);
/// assert_eq!(wave.next_edge(0.0), Some(0.25));
/// assert!((wave.series(1)?.pairs()[0][0] - 0.8 / std::f64::consts::PI).abs() < 1e-15);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectangularWave {
    low: f64,
    high: f64,
    duty: f64,
    period: f64,
    /// Centre of the high part, in periods.
    centre: f64,
}

impl RectangularWave {
    /// Two levels, duty in [0, 1), period `[s]`.
    ///
    /// # Errors
    /// A level beyond ±1e50; a duty outside [0, 1); a period outside 1e-50 .. 1e50.
    pub fn new(low: f64, high: f64, duty: f64, period: f64) -> Result<Self, ParameterError> {
        let (low, high) = (check::quantity("low level", low)?, check::quantity("high level", high)?);
        Ok(RectangularWave { low, high, duty: check::fraction("duty", duty)?, period: check::scale("period", period)?, centre: 0.0 })
    }

    /// The duty is the contact ratio less its whole part: 0.52 of the period with two pairs for a contact ratio of 1.52. `low` is the stiffness
    /// of the whole part of the ratio, so a contact ratio of 2 is constant at `low`, that of two pairs.
    ///
    /// # Errors
    /// A contact ratio below 1 or above 1e50; levels and period as in [`new`](RectangularWave::new).
    pub fn from_contact_ratio(contact_ratio: f64, low: f64, high: f64, period: f64) -> Result<Self, ParameterError> {
        let name = "contact ratio";
        if check::quantity(name, contact_ratio)? < 1.0 {
            return Err(ParameterError::OutOfRange { name: name.into(), value: contact_ratio, allowed: "[1, ∞)" });
        }
        RectangularWave::new(low, high, contact_ratio.fract(), period)
    }

    /// The same wave ahead by a phase `[rad]`.
    ///
    /// # Errors
    /// A phase beyond ±1e50.
    pub fn with_phase(self, phase: f64) -> Result<Self, ParameterError> {
        Ok(RectangularWave { centre: self.centre - (check::quantity("phase", phase)? / TAU).fract(), ..self })
    }

    /// low + duty (high - low).
    pub fn mean(&self) -> f64 {
        self.low + self.duty * (self.high - self.low)
    }

    /// The Fourier series to an order: amplitudes 2 (high - low)/(j π) sin(j π duty).
    ///
    /// # Errors
    /// An order above 10 000; levels so far apart that a derivative of the series overflows.
    pub fn series(&self, order: usize) -> Result<Fourier, ParameterError> {
        check::count("order of the series", &[order], check::ORDERS)?;
        let pairs: Vec<_> = (1..=order)
            .map(|j| {
                let j = j as f64;
                let a = 2.0 * (self.high - self.low) / (j * PI) * libm::sin(j * PI * self.duty);
                let (s, c) = libm::sincos(j * TAU * self.centre);
                [a * c, a * s]
            })
            .collect();
        Fourier::new(self.mean(), &pairs, TAU / self.period)
    }

    /// Whether edges near `t` can still be told apart in floating point.
    fn resolved(&self, t: f64) -> bool {
        self.duty > 0.0 && (t / self.period).abs() < 1e12
    }

    /// Edge k: rising for even k, falling for odd.
    fn edge(&self, k: f64) -> f64 {
        let cycle = (k * 0.5).floor();
        let half = if k == 2.0 * cycle { -0.5 } else { 0.5 };
        (cycle + half * self.duty + self.centre) * self.period
    }

    /// The last edge at or before `t`.
    fn last_edge(&self, t: f64) -> f64 {
        let mut k = 2.0 * (t / self.period - self.centre).floor() + 3.0; // at most a few too far
        while self.edge(k) > t {
            k -= 1.0;
        }
        k
    }
}

impl Excitation for RectangularWave {
    fn jet(&self, t: f64, side: Side) -> Jet {
        if !self.resolved(t) {
            return Jet::constant(self.mean()); // no high part at all, or so far out that the wave is lost in rounding
        }
        let mut k = self.last_edge(t);
        if side == Side::Before && self.edge(k) == t {
            k -= 1.0;
        }
        Jet::constant(if (k * 0.5).floor() * 2.0 == k { self.high } else { self.low })
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.resolved(t).then(|| self.edge(self.last_edge(t) + 1.0)).filter(|edge| *edge > t)
    }
    fn repeats(&self) -> Repeats {
        Repeats::Every(self.period)
    }
}
