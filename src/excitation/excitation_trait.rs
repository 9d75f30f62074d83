//! Functions of an angle.

use crate::excitation::angle::Angle;
use crate::excitation::any_excitation::AnyExcitation;
use crate::excitation::enclosed_angle::EnclosedAngle;
use crate::excitation::fourier::Fourier;
use crate::excitation::jet::Jet;
use crate::excitation::wave::Wave;
use crate::interval::number::Interval;
use crate::series::{PowerSeries, Series};
use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

/// A function f(φ) of an angle φ `[rad]` with period 2π and its first two derivatives over the angle, exact
/// where they exist.
///
/// One formula serves numbers, Taylor series over time ([`Taylor`](crate::Taylor)) and enclosures
/// ([certificates](crate::certify)): the arithmetic of [`Jet`] gives the derivatives. The formula knows the
/// angle alone. The speed of the angle belongs to the model, the number of repetitions in a turn of a shaft
/// is the order of a [`Wave`].
///
/// Two excitations are the same function if they are equal: models with either of them may share a drive
/// table.
///
/// ```
/// use gear_dynamics::{excitation::{Angle, Excitation, Jet, Side}, Wave};
/// /// sin φ + sin³ φ/2.
/// #[derive(Debug, PartialEq)]
/// struct Ripple;
/// impl Excitation for Ripple {
///     fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
///         let wave = Jet::variable(angle.number()).sin();
///         wave + wave * wave * wave * 0.5
///     }
/// }
/// let wave = Wave::new(Ripple).per_turn(20)?;
/// assert_eq!(wave.jet(0.0, Side::After).rate, 20.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub trait Excitation: Any + Debug + PartialEq + Send + Sync {
    /// Returns f, f' and f'' at an angle in [0, 2π). A [`Wave`] never evaluates it at one of its
    /// [`edges`](Excitation::edges).
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number>;
    /// Returns f alone. Default: from [`jet`](Excitation::jet).
    fn value<A: Angle>(&self, angle: A) -> A::Number {
        self.jet(angle).value
    }
    /// Returns mean and pairs (c_n, s_n) of f as a finite Fourier series, if it is one with at most 64 waves.
    /// Products of such excitations are expanded once. Default: `None`.
    fn fourier(&self) -> Option<(f64, Vec<[f64; 2]>)> {
        None
    }
    /// Angles in [0, 2π) at which f or a derivative jumps, in any order. Default: none.
    fn edges(&self) -> Vec<f64> {
        Vec::new()
    }
    /// The knots in one period. A knot is an angle in [0, 2π) at which f, f' and f'' are continuous and a
    /// higher derivative jumps.
    /// Adaptive Runge-Kutta methods end a step there. Nothing else depends on the knots. Default: none.
    fn knots(&self) -> Vec<f64> {
        Vec::new()
    }
}

impl<E: Excitation> AnyExcitation for E {
    fn value_at(&self, angle: f64) -> f64 {
        self.value(angle)
    }
    fn jet_at(&self, angle: f64) -> Jet {
        self.jet(angle)
    }
    fn value_series(&self, angle: Series) -> Series {
        self.value(angle)
    }
    fn jet_series(&self, angle: Series) -> Jet<Series> {
        self.jet(angle)
    }
    fn jet_enclosure(&self, angle: EnclosedAngle) -> Jet<PowerSeries<Interval>> {
        self.jet(angle)
    }
    fn pairs(&self) -> Option<(f64, Vec<[f64; 2]>)> {
        self.fourier()
    }
    fn equals(&self, other: &dyn AnyExcitation) -> bool {
        let other: &dyn Any = other;
        other.downcast_ref::<E>() == Some(self)
    }
}

impl Wave {
    /// The wave f(φ): order 1, phase 0.
    pub fn new(excitation: impl Excitation) -> Self {
        let [edges, knots] = [excitation.edges(), excitation.knots()];
        Wave::of_any(Arc::new(excitation), &edges, &knots)
    }
}

impl Excitation for Fourier {
    #[inline]
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
        angle.jet_of_fourier(self)
    }
    #[inline]
    fn value<A: Angle>(&self, angle: A) -> A::Number {
        angle.value_of_fourier(self)
    }
    fn fourier(&self) -> Option<(f64, Vec<[f64; 2]>)> {
        self.clone().if_short().map(|short| (short.mean(), short.pairs().to_vec()))
    }
}
