//! The rectangular stiffness wave of a contact ratio.

use crate::error::{ParameterError, check};
use crate::excitation::angle::{Excitation, same};
use crate::excitation::fourier::Fourier;
use crate::excitation::jet::Jet;
use std::f64::consts::PI;
use std::f64::consts::TAU;

/// High while one pair of teeth more is in mesh, low otherwise; the high part lasts a share `duty` of the turn and is centred on φ = 0.
///
/// The edges are exact: solvers end their steps on them. [`series`](RectangularWave::series) is the truncated series
/// that most papers use instead.   Source: Lin & Parker 2002; ISO 6336-1 for the levels.
///
/// ```
/// use gear_dynamics::{excitation::{Excitation, RectangularWave, Side}, Wave};
/// use std::f64::consts::{FRAC_PI_2, PI};
/// let rectangle = RectangularWave::from_contact_ratio(1.5, 0.8, 1.2)?;
/// assert!((rectangle.series(1)?.pairs()[0][0] - 0.8 / PI).abs() < 1e-15);
/// let wave = Wave::new(rectangle);
/// assert_eq!(wave.next_edge(0.0), Some(FRAC_PI_2));
/// assert_eq!((wave.value(FRAC_PI_2, Side::Before), wave.value(FRAC_PI_2, Side::After)), (1.2, 0.8));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectangularWave {
    low: f64,
    high: f64,
    duty: f64,
}

impl RectangularWave {
    /// Two levels and a duty in [0, 1).
    ///
    /// # Errors
    /// A level beyond ±1e50; a duty outside [0, 1).
    pub fn new(low: f64, high: f64, duty: f64) -> Result<Self, ParameterError> {
        let (low, high) = (check::quantity("low level", low)?, check::quantity("high level", high)?);
        Ok(RectangularWave { low, high, duty: check::fraction("duty", duty)? })
    }

    /// The duty is the contact ratio less its whole part: 0.52 of the turn with two pairs for a contact ratio of 1.52. `low` is the stiffness
    /// of the whole part of the ratio, so a contact ratio of 2 is constant at `low`, that of two pairs.
    ///
    /// # Errors
    /// A contact ratio below 1 or above 1e50; levels as in [`new`](RectangularWave::new).
    pub fn from_contact_ratio(contact_ratio: f64, low: f64, high: f64) -> Result<Self, ParameterError> {
        let name = "contact ratio";
        if check::quantity(name, contact_ratio)? < 1.0 {
            return Err(ParameterError::OutOfRange {
                name: name.into(),
                value: contact_ratio,
                allowed: "[1, ∞)",
            });
        }
        RectangularWave::new(low, high, contact_ratio.fract())
    }

    /// 1 for the quarter turn on either side of φ = 0 and -1 elsewhere: the sign of tooth friction, which reverses at the pitch point. A phase
    /// of the [`Wave`](crate::Wave) puts the pitch point where it is.
    pub fn sign() -> Self {
        RectangularWave { low: -1.0, high: 1.0, duty: 0.5 }
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
        let amplitude =
            |j: usize| 2.0 * (self.high - self.low) / (j as f64 * PI) * libm::sin(j as f64 * PI * self.duty);
        let pairs: Vec<_> = (1..=order).map(|j| [amplitude(j), 0.0]).collect();
        Fourier::new(self.mean(), &pairs)
    }

    /// Where the high part ends.
    fn half(&self) -> f64 {
        PI * self.duty
    }
}

impl Excitation for RectangularWave {
    fn jet(&self, angle: f64) -> Jet {
        let from_middle = angle.min(TAU - angle);
        Jet::constant(if from_middle < self.half() { self.high } else { self.low })
    }
    fn edges(&self) -> Vec<f64> {
        if self.duty > 0.0 && self.low != self.high {
            vec![self.half(), TAU - self.half()]
        } else {
            Vec::new()
        }
    }
    fn same_as(&self, other: &dyn Excitation) -> bool {
        same(self, other)
    }
}
