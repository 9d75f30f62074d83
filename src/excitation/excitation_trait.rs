//! Functions of an angle.

use crate::excitation::enclosed_angle::EnclosedAngle;
use crate::excitation::jet::Jet;
use crate::interval::number::Interval;
use crate::series::{PowerSeries, Series};
use std::any::Any;
use std::fmt::Debug;

/// A function f(φ) of an angle φ `[rad]` with period 2π and its first two derivatives over the angle, exact
/// where they exist.
///
/// It contains neither the speed of the angle nor the number of repetitions in one turn of a shaft. The
/// latter is the order of a [`Wave`](crate::Wave).
///
/// ```
/// use gear_dynamics::excitation::{Excitation, Fourier};
/// let error = Fourier::new(0.0, &[[0.0, 1e-5]])?; // 10 μm sin φ
/// assert_eq!(error.jet(0.0).rate, 1e-5);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub trait Excitation: Any + Debug + Send + Sync {
    /// Returns f, f' and f'' at an angle in [0, 2π). A [`Wave`](crate::Wave) never evaluates it at one of
    /// its [`edges`](Excitation::edges).
    fn jet(&self, angle: f64) -> Jet;
    /// Returns f alone. Default: from [`jet`](Excitation::jet).
    fn value(&self, angle: f64) -> f64 {
        self.jet(angle).value
    }
    /// Returns f, f' and f'' as Taylor series over time, from the series of the angle. [`Taylor`] requires
    /// it. Default: refused.
    ///
    /// A formula in a generic [`Scalar`] serves this method and [`jet`](Excitation::jet): the arithmetic of
    /// `Jet<S>` gives the derivatives.
    ///
    /// [`Taylor`]: crate::Taylor
    /// [`Scalar`]: crate::model::Scalar
    fn series(&self, angle: &Series) -> Jet<Series> {
        let _ = angle;
        Jet::constant(Series::refused("an excitation without `Excitation::series`"))
    }
    /// Returns the series of f alone. Default: from [`series`](Excitation::series).
    fn value_series(&self, angle: &Series) -> Series {
        self.series(angle).value
    }
    /// Returns enclosures of f, f' and f'' as Taylor series over a stretch of time, from the enclosed angle.
    /// A [certificate](crate::certify) requires it. Default: refused.
    fn enclosure(&self, angle: EnclosedAngle) -> Jet<PowerSeries<Interval>> {
        let _ = angle;
        Jet::constant(PowerSeries::refused("an excitation without `Excitation::enclosure`"))
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
    /// Whether another excitation is the same function, so that models with either of them may share a drive
    /// table. Default: `false`. A type with `PartialEq` implements it as
    /// `gear_dynamics::excitation::same(self, other)`.
    fn same_as(&self, other: &dyn Excitation) -> bool {
        let _ = other;
        false
    }
}

/// Whether two excitations have the same type and are equal. It implements [`Excitation::same_as`] for a
/// type with `PartialEq`.
///
/// ```
/// use gear_dynamics::excitation::{Constant, Fourier, same};
/// let (two, also) = (Constant::new(2.0)?, Constant::new(2.0)?);
/// assert!(same(&two, &also) && !same(&two, &Fourier::new(2.0, &[])?));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub fn same<E: Excitation + PartialEq>(one: &E, other: &dyn Excitation) -> bool {
    let other: &dyn Any = other;
    other.downcast_ref::<E>() == Some(one)
}
