//! Waves at an angle, which is a number or a series.

use crate::excitation::enclosed_angle::EnclosedAngle;
use crate::excitation::jet::Jet;
use crate::excitation::side::Side;
use crate::excitation::wave::Wave;
use crate::interval::number::Interval;
use crate::scalar::Scalar;
use crate::series::{PowerSeries, Series};
use std::fmt::Debug;

/// An angle `[rad]` at which waves are evaluated: an `f64`, or a [`Series`] over time.
///
/// A [`Shape`](crate::Shape) writes its waves once for both kinds.
///
/// ```
/// use gear_dynamics::{excitation::{Angle, Fourier, Side}, model::{Scalar, Series}, Wave};
/// fn radius<A: Angle>(angle: A) -> A::Number {
///     angle.number().cos() * 0.4 + A::Number::from(1.0)
/// }
/// assert_eq!(radius(0.0), 1.4);
/// // At 3 rad/s from the angle 0: 1 + 0.4 cos 3t = 1.4 - 1.8 t² + ...
/// assert_eq!(radius(Series::variable(0.0, 3.0, 4)).coefficients()[2], -1.8);
/// let wave = Wave::new(Fourier::new(1.0, &[[0.4, 0.0]])?);
/// assert_eq!(wave.value(0.0, Side::After), 1.4);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub trait Angle: Copy + Debug {
    /// The numbers that waves have at this angle.
    type Number: Scalar;
    /// The angle itself.
    fn number(self) -> Self::Number;
    /// The angle multiplied by a factor, for example by a number of teeth.
    fn times(self, factor: f64) -> Self;
    /// Returns any function of the angle in plain numbers. It has no series: at a [`Series`] the result is
    /// [refused](Series::refusal).
    fn by_function(self, f: impl Fn(f64) -> f64) -> Self::Number;
    /// Returns the value of a wave. See [`Wave::value`].
    fn value_of(self, wave: &Wave, side: Side) -> Self::Number;
    /// Returns value and derivatives of a wave over the angle. See [`Wave::jet`].
    fn jet_of(self, wave: &Wave, side: Side) -> Jet<Self::Number>;
}

impl Wave {
    /// Value, first and second derivative over the angle of the shaft, at any angle `[rad]`: `f64`, or a
    /// series over time. `side`: before or after a jump at this angle.
    #[inline]
    pub fn jet<A: Angle>(&self, angle: A, side: Side) -> Jet<A::Number> {
        angle.jet_of(self, side)
    }
    /// The value alone.
    #[inline]
    pub fn value<A: Angle>(&self, angle: A, side: Side) -> A::Number {
        angle.value_of(self, side)
    }
}

impl Angle for f64 {
    type Number = f64;
    #[inline(always)]
    fn number(self) -> f64 {
        self
    }
    #[inline(always)]
    fn times(self, factor: f64) -> f64 {
        factor * self
    }
    #[inline(always)]
    fn by_function(self, f: impl Fn(f64) -> f64) -> f64 {
        f(self)
    }
    #[inline]
    fn value_of(self, wave: &Wave, side: Side) -> f64 {
        wave.value_at(self, side)
    }
    #[inline]
    fn jet_of(self, wave: &Wave, side: Side) -> Jet {
        wave.jet_at(self, side)
    }
}

impl Angle for Series {
    type Number = Series;
    fn number(self) -> Series {
        self
    }
    fn times(self, factor: f64) -> Series {
        self * factor
    }
    fn by_function(self, _: impl Fn(f64) -> f64) -> Series {
        Series::refused("a plain function of the angle (`Angle::by_function`)")
    }
    fn value_of(self, wave: &Wave, side: Side) -> Series {
        let (excitation, own) = wave.own_series(self, side);
        excitation.value_series(&own)
    }
    fn jet_of(self, wave: &Wave, side: Side) -> Jet<Series> {
        let (excitation, own) = wave.own_series(self, side);
        let (jet, n) = (excitation.series(&own), f64::from(wave.order()));
        Jet { value: jet.value, rate: jet.rate * n, second: jet.second * (n * n) }
    }
}

impl Angle for EnclosedAngle {
    type Number = PowerSeries<Interval>;
    fn number(self) -> PowerSeries<Interval> {
        self.series()
    }
    fn times(self, factor: f64) -> Self {
        self.moved(factor, 0.0)
    }
    fn by_function(self, _: impl Fn(f64) -> f64) -> PowerSeries<Interval> {
        PowerSeries::refused("a plain function of the angle (`Angle::by_function`)")
    }
    fn value_of(self, wave: &Wave, side: Side) -> PowerSeries<Interval> {
        self.jet_of(wave, side).value
    }
    fn jet_of(self, wave: &Wave, _: Side) -> Jet<PowerSeries<Interval>> {
        let n = f64::from(wave.order());
        let jet = wave.enclosure(self.moved(n, wave.phase()));
        Jet { value: jet.value, rate: jet.rate * n, second: jet.second * n * n }
    }
}
