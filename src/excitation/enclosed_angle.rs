//! Angles over a stretch of time, enclosed.

use crate::interval::number::Interval;
use crate::scalar::Scalar;
use crate::series::PowerSeries;
use std::f64::consts::TAU;

/// An angle over a stretch of time: enclosures of its Taylor coefficients, and an angle inside the stretch,
/// which says between which edges the stretch lies.
///
/// ```
/// use gear_dynamics::certify::Interval;
/// use gear_dynamics::excitation::{Angle, EnclosedAngle, Fourier, Side};
/// use gear_dynamics::Wave;
/// let wave = Wave::new(Fourier::new(1.0, &[[0.5, 0.0]])?); // 1 + 0.5 cos φ
/// let angle = EnclosedAngle::new(Interval::new(0.0, 0.1)?, Interval::from(2.0), 0.05, 4);
/// let value = wave.value(angle, Side::After);
/// assert!(value.coefficients()[0].contains(1.5) && value.coefficients()[2].contains(-1.0));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct EnclosedAngle {
    series: PowerSeries<Interval>,
    inside: f64,
}

impl EnclosedAngle {
    /// An angle that starts in `first` `[rad]` and turns at `speed` [rad/s]. `inside`: an angle within the
    /// stretch.
    pub fn new(first: Interval, speed: Interval, inside: f64, coefficients: usize) -> Self {
        EnclosedAngle { series: PowerSeries::variable(first, speed, coefficients), inside }
    }
    /// Its value and speed, if it turns at a constant speed.
    pub(crate) fn turning(&self) -> Option<[Interval; 2]> {
        self.series.coefficients().try_into().ok()
    }
    /// An angle inside the stretch, in [0, 2π).
    pub(crate) fn inside(&self) -> f64 {
        self.inside.rem_euclid(TAU) % TAU
    }
    /// The series of the angle less whole turns, so that it lies about [0, 2π).
    pub(crate) fn reduced(&self) -> PowerSeries<Interval> {
        let turns = (self.inside / TAU).floor();
        if turns == 0.0 {
            return self.series;
        }
        self.series - PowerSeries::constant(Interval::PI * (2.0 * turns))
    }
    /// Enclosures of sin nφ and cos nφ. At a constant speed w their coefficients k are (n w)^k/k! times
    /// ± sine or cosine.
    pub(crate) fn sin_cos(&self, n: f64) -> [PowerSeries<Interval>; 2] {
        let Some([first, speed]) = self.turning() else {
            let (sin, cos) = (self.series * n).sin_cos();
            return [sin, cos];
        };
        let (sin, cos) = (first * n).sin_cos();
        let weight = speed * n;
        let turned = |cycle: [Interval; 4]| {
            let mut power = Interval::from(1.0);
            PowerSeries::from_coefficients(&self.series, |k| {
                let coefficient = cycle[k % 4] * power;
                power = power * weight / Interval::from((k + 1) as f64);
                coefficient
            })
        };
        [turned([sin, cos, -sin, -cos]), turned([cos, -sin, -cos, sin])]
    }
    /// The series of the angle.
    pub(crate) fn series(&self) -> PowerSeries<Interval> {
        self.series
    }
    /// n φ + ψ.
    pub(crate) fn moved(self, n: f64, phase: f64) -> Self {
        EnclosedAngle { series: self.series * n + PowerSeries::from(phase), inside: self.inside * n + phase }
    }
}
