//! Angles at which waves are evaluated: a number, a series over time, or an enclosure.

use crate::excitation::enclosed_angle::EnclosedAngle;
use crate::excitation::fourier::Fourier;
use crate::excitation::jet::Jet;
use crate::excitation::side::Side;
use crate::excitation::wave::Wave;
use crate::interval::number::Interval;
use crate::scalar::Scalar;
use crate::series::{PowerSeries, Series};
use std::f64::consts::TAU;
use std::fmt::Debug;

/// An angle `[rad]` at which waves are evaluated: an `f64`, a [`Series`] over time, or an
/// [`EnclosedAngle`](crate::excitation::EnclosedAngle).
///
/// A [`Shape`](crate::Shape) writes its waves once for all kinds, an
/// [`Excitation`](crate::excitation::Excitation) its formula.
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
    /// Returns functions of the angle in plain numbers. They have no series: at a [`Series`] the results are
    /// [refused](Series::refusal).
    fn by_function<const N: usize>(self, f: impl Fn(f64) -> [f64; N]) -> [Self::Number; N];
    /// Returns a function with one formula for each piece between two edges. `jet` receives two angles: the
    /// first one lies inside the piece and selects the formula, the second one is the argument of the
    /// formula. In an [`Excitation`](crate::excitation::Excitation) both lie in [0, 2π).
    ///
    /// ```
    /// use gear_dynamics::{excitation::{Angle, Excitation, Jet, Side}, Wave};
    /// /// A stiffness of two pairs in contact up to φ = 2, of one pair beyond.
    /// #[derive(Debug, PartialEq)]
    /// struct Pairs;
    /// impl Excitation for Pairs {
    ///     fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
    ///         angle.by_pieces(|inside, angle| {
    ///             let bend = Jet::variable(angle).cos() * 0.1;
    ///             bend + if inside < 2.0 { 1.8 } else { 1.0 }
    ///         })
    ///     }
    ///     fn edges(&self) -> Vec<f64> {
    ///         vec![0.0, 2.0]
    ///     }
    /// }
    /// let wave = Wave::new(Pairs);
    /// let jump = wave.value(2.0, Side::Before) - wave.value(2.0, Side::After);
    /// assert!((jump - 0.8).abs() < 1e-11);
    /// ```
    fn by_pieces(self, jet: impl Fn(f64, Self::Number) -> Jet<Self::Number>) -> Jet<Self::Number>;
    /// Returns a function with one formula for each of `count` equal parts of a turn. `jet` receives
    /// the index of the part and the share of it that lies before the angle.
    fn by_parts(
        self,
        count: usize,
        jet: impl Fn(usize, Self::Number) -> Jet<Self::Number>,
    ) -> Jet<Self::Number>;
    #[doc(hidden)]
    /// Returns the value of a Fourier series.
    fn value_of_fourier(self, series: &Fourier) -> Self::Number;
    #[doc(hidden)]
    /// Returns value and derivatives of a Fourier series over the angle.
    fn jet_of_fourier(self, series: &Fourier) -> Jet<Self::Number>;
    #[doc(hidden)]
    /// Whether it is a series over time at a constant speed, for which one Fourier series is faster than sums
    /// and products of several. Default: `false`.
    fn turns_evenly(self) -> bool {
        false
    }
    #[doc(hidden)]
    /// Returns the value of a wave. See [`Wave::value`].
    fn value_of(self, wave: &Wave, side: Side) -> Self::Number;
    #[doc(hidden)]
    /// Returns value and derivatives of a wave over the angle. See [`Wave::jet`].
    fn jet_of(self, wave: &Wave, side: Side) -> Jet<Self::Number>;
}

/// Why a closure has no series.
const PLAIN: &str = "a plain function of the angle: a closure (`Function`) or `Angle::by_function`";

/// A place this close to the end of a part of a turn, in parts, lies on it `[1]`.
const AT_END: f64 = 1e-9;

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
    fn by_function<const N: usize>(self, f: impl Fn(f64) -> [f64; N]) -> [f64; N] {
        f(self)
    }
    #[inline(always)]
    fn by_pieces(self, jet: impl Fn(f64, f64) -> Jet) -> Jet {
        jet(self, self)
    }
    #[inline(always)]
    fn by_parts(self, count: usize, jet: impl Fn(usize, f64) -> Jet) -> Jet {
        let place = self * (count as f64 / TAU);
        let part = (place as usize).min(count - 1);
        jet(part, place - part as f64)
    }
    #[inline]
    fn value_of_fourier(self, series: &Fourier) -> f64 {
        series.value_at(self)
    }
    #[inline]
    fn jet_of_fourier(self, series: &Fourier) -> Jet {
        series.jet_at(self)
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
    fn by_function<const N: usize>(self, _: impl Fn(f64) -> [f64; N]) -> [Series; N] {
        [Series::refused(PLAIN); N]
    }
    fn by_pieces(self, jet: impl Fn(f64, Series) -> Jet<Series>) -> Jet<Series> {
        jet(self.at(0.0), self)
    }
    /// The series is valid up to the end of the part.
    fn by_parts(self, count: usize, jet: impl Fn(usize, Series) -> Jet<Series>) -> Jet<Series> {
        let place = self * (count as f64 / TAU);
        let part = (place.at(0.0) + AT_END).floor();
        let &[from, rate] = place.coefficients() else {
            return Jet::constant(Series::refused("a table of samples over an angle of varying speed"));
        };
        let place = place.valid_until((part + 1.0 - from) / rate);
        jet(part as usize % count, place - Series::from(part))
    }
    fn value_of_fourier(self, series: &Fourier) -> Series {
        series.series_at(&self, false).value
    }
    fn jet_of_fourier(self, series: &Fourier) -> Jet<Series> {
        series.series_at(&self, true)
    }
    fn turns_evenly(self) -> bool {
        self.coefficients().len() <= 2
    }
    fn value_of(self, wave: &Wave, side: Side) -> Series {
        let (excitation, own) = wave.own_series(self, side);
        excitation.value_series(own)
    }
    fn jet_of(self, wave: &Wave, side: Side) -> Jet<Series> {
        let (excitation, own) = wave.own_series(self, side);
        let (jet, n) = (excitation.jet_series(own), f64::from(wave.order()));
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
    fn by_function<const N: usize>(self, _: impl Fn(f64) -> [f64; N]) -> [PowerSeries<Interval>; N] {
        [PowerSeries::refused(PLAIN); N]
    }
    fn by_pieces(self, jet: impl Fn(f64, Self::Number) -> Jet<Self::Number>) -> Jet<Self::Number> {
        jet(self.inside(), self.reduced())
    }
    fn by_parts(self, _: usize, _: impl Fn(usize, Self::Number) -> Jet<Self::Number>) -> Jet<Self::Number> {
        Jet::constant(PowerSeries::refused("a table of samples"))
    }
    fn value_of_fourier(self, series: &Fourier) -> PowerSeries<Interval> {
        series.enclosure_at(self).value
    }
    fn jet_of_fourier(self, series: &Fourier) -> Jet<PowerSeries<Interval>> {
        series.enclosure_at(self)
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
