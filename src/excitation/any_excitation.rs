//! Excitations of any type, as waves hold them.

use crate::excitation::enclosed_angle::EnclosedAngle;
use crate::excitation::jet::Jet;
use crate::interval::number::Interval;
use crate::series::{PowerSeries, Series};
use std::any::Any;
use std::fmt::Debug;

/// What an excitation is asked for, with its type erased. Each type of angle has methods of its own.
pub(crate) trait AnyExcitation: Any + Debug + Send + Sync {
    fn value_at(&self, angle: f64) -> f64;
    fn jet_at(&self, angle: f64) -> Jet;
    fn value_series(&self, angle: Series) -> Series;
    fn jet_series(&self, angle: Series) -> Jet<Series>;
    fn jet_enclosure(&self, angle: EnclosedAngle) -> Jet<PowerSeries<Interval>>;
    /// Mean and pairs of a finite Fourier series.
    fn pairs(&self) -> Option<(f64, Vec<[f64; 2]>)>;
    /// Whether another excitation has the same type and is equal.
    fn equals(&self, other: &dyn AnyExcitation) -> bool;
}
