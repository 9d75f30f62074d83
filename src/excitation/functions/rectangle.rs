//! Rectangular waves: the mesh stiffness of a contact ratio.

use crate::error::{ParameterError, check};
use crate::excitation::angle::Angle;
use crate::excitation::excitation_trait::Excitation;
use crate::excitation::fourier::Fourier;
use crate::excitation::jet::Jet;
use std::f64::consts::PI;
use std::f64::consts::TAU;

/// A rectangular wave with two levels: `high` while one more tooth pair is in engagement, `low` otherwise.
///
/// The high part is centred on φ = 0; its share of the period is `duty`. Its edges are exact: solvers end
/// their steps on them. [`series`](RectangularWave::series) returns the truncated Fourier series that most
/// papers use instead.   Source: Lin & Parker 2002; ISO 6336-1 for the levels.
///
/// ```
/// use gear_dynamics::{excitation::{Excitation, RectangularWave, Side}, Wave};
/// use std::f64::consts::{FRAC_PI_2, PI};
/// let rectangle = RectangularWave::of_contact_ratio(1.5, 0.8, 1.2)?;
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

/// Largest contact ratio `[1]`.
const MOST_PAIRS: f64 = 100.0;

impl RectangularWave {
    /// A wave of two levels with a duty `[1]` in [0, 1).
    ///
    /// # Errors
    /// A level beyond ±1e50; a duty outside [0, 1).
    pub fn new(low: f64, high: f64, duty: f64) -> Result<Self, ParameterError> {
        let (low, high) = (check::quantity("low level", low)?, check::quantity("high level", high)?);
        Ok(RectangularWave { low, high, duty: check::fraction("duty", duty)? })
    }

    /// The wave of a contact ratio `[1]`. The duty is the fractional part of the contact ratio: for 1.52 two
    /// tooth pairs are in engagement during 0.52 of the period.
    ///
    /// `low` is the stiffness of the smaller number of pairs, the whole part of the contact ratio; `high` is
    /// that of one pair more. A contact ratio of 2 gives the constant `low`, the stiffness of two pairs.
    ///
    /// # Errors
    /// A contact ratio below 1 or above 100, as one in per cent; levels as in [`new`](RectangularWave::new).
    pub fn of_contact_ratio(contact_ratio: f64, low: f64, high: f64) -> Result<Self, ParameterError> {
        let name = "contact ratio";
        if !(1.0..=MOST_PAIRS).contains(&check::quantity(name, contact_ratio)?) {
            return Err(ParameterError::OutOfRange {
                name: name.into(),
                value: contact_ratio,
                allowed: "[1, 100]",
            });
        }
        RectangularWave::new(low, high, contact_ratio.fract())
    }

    /// The sign of tooth friction, which reverses at the pitch point: 1 within a quarter turn of φ = 0, -1
    /// elsewhere. The phase of the [`Wave`](crate::Wave) determines the angle of the pitch point.
    pub fn sign() -> Self {
        RectangularWave { low: -1.0, high: 1.0, duty: 0.5 }
    }

    /// Mean low + duty (high - low).
    pub fn mean(&self) -> f64 {
        self.low + self.duty * (self.high - self.low)
    }

    /// The Fourier series up to `order`, with the cosine amplitudes 2 (high - low)/(j π) sin(j π duty) of
    /// the orders j.
    ///
    /// # Errors
    /// An order above 10 000; a mean or an amplitude beyond ±1e50.
    pub fn series(&self, order: usize) -> Result<Fourier, ParameterError> {
        check::count("order of the series", &[order], check::ORDERS)?;
        let amplitude =
            |j: usize| 2.0 * (self.high - self.low) / (j as f64 * PI) * libm::sin(j as f64 * PI * self.duty);
        let pairs: Vec<_> = (1..=order).map(|j| [amplitude(j), 0.0]).collect();
        Fourier::new(self.mean(), &pairs)
    }

    fn level(&self, angle: f64) -> f64 {
        let from_middle = angle.min(TAU - angle);
        if from_middle < self.half() { self.high } else { self.low }
    }

    /// Angle at which the high part ends `[rad]`.
    fn half(&self) -> f64 {
        PI * self.duty
    }
}

impl Excitation for RectangularWave {
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
        angle.by_pieces(|inside, _| Jet::constant(self.level(inside).into()))
    }
    fn edges(&self) -> Vec<f64> {
        if self.duty > 0.0 && self.low != self.high {
            vec![self.half(), TAU - self.half()]
        } else {
            Vec::new()
        }
    }
}
