//! Functions of time that drive a gear: mesh stiffness, transmission error, instantaneous centre, torque.

mod centre;
mod combine;
mod fourier;
mod jet;
mod rectangle;
mod table;

pub use centre::{CentreCurve, InstantCentre};
pub use combine::{Function, Product, Scaled, Sum};
pub use fourier::Fourier;
pub use jet::Jet;
pub use rectangle::RectangularWave;
pub use table::Table;

use crate::error::{ParameterError, check};
use crate::piece::Side;
use std::fmt::Debug;
use std::sync::Arc;

/// A function of time with its first two derivatives, exact where they exist.
///
/// ```
/// use gear_dynamics::{Excitation, Fourier, Side};
/// let error = Fourier::new(0.0, &[[0.0, 1e-5]], 3.0)?; // 10 μm sin(3 t)
/// assert!((error.rate(0.0, Side::After) - 3e-5).abs() < 1e-20);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub trait Excitation: Debug + Send + Sync {
    /// Value, first and second derivative at `t`, seen from one side.
    fn jet(&self, t: f64, side: Side) -> Jet;
    /// The value alone.
    fn value(&self, t: f64, side: Side) -> f64 {
        self.jet(t, side).value
    }
    /// The first time derivative alone.
    fn rate(&self, t: f64, side: Side) -> f64 {
        self.jet(t, side).rate
    }
    /// The first instant after `t` at which the value or a derivative jumps.
    fn next_edge(&self, t: f64) -> Option<f64> {
        let _ = t;
        None
    }
    /// Whether and when it repeats.
    fn repeats(&self) -> Repeats {
        Repeats::Never
    }
}

/// An excitation that several meshes may share; a shared one is evaluated once per instant.
pub type Shared = Arc<dyn Excitation>;

/// Wraps an excitation for sharing.
pub fn shared(excitation: impl Excitation + 'static) -> Shared {
    Arc::new(excitation)
}

/// Whether and when an excitation repeats.
///
/// ```
/// use gear_dynamics::Repeats;
/// assert_eq!(Repeats::Every(2.0).with(Repeats::Every(3.0)), Repeats::Every(6.0));
/// assert!(Repeats::Every(2.0).fits(4.0) && !Repeats::Every(2.0).fits(3.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Repeats {
    /// Constant.
    Always,
    /// With this period.
    Every(f64),
    /// Not at all.
    Never,
}

impl Repeats {
    /// Largest common multiple that is looked for.
    const LARGEST: u32 = 10_000;
    /// How far a ratio of periods may be from whole numbers, as a share of itself and at the most.
    const ROUNDING: f64 = 1e-9;
    const APART: f64 = 1e-3;

    /// The common period of two, in either order; `Never` if there is none within 10 000 times the longer one.
    pub fn with(self, other: Self) -> Self {
        match (self, other) {
            (Repeats::Always, x) | (x, Repeats::Always) => x,
            (Repeats::Every(a), Repeats::Every(b)) => (1..=Self::LARGEST)
                .map(|m| f64::from(m) * a.max(b))
                .find(|&period| Repeats::Every(a.min(b)).fits(period))
                .map_or(Repeats::Never, Repeats::Every),
            _ => Repeats::Never,
        }
    }

    /// Whether `period` is a whole number of its periods.
    pub fn fits(self, period: f64) -> bool {
        match self {
            Repeats::Always => true,
            Repeats::Every(own) => {
                let ratio = period / own;
                ratio.round() >= 1.0 && (ratio - ratio.round()).abs() <= (Self::ROUNDING * ratio).min(Self::APART)
            }
            Repeats::Never => false,
        }
    }
}

/// The earlier of two instants, either of which may be missing.
pub(crate) fn earlier(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}

/// A constant.
///
/// ```
/// use gear_dynamics::{Constant, Excitation, Side};
/// assert_eq!(Constant::new(2e8)?.value(7.0, Side::After), 2e8);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant(f64);

impl Constant {
    /// A constant within ±1e50.
    ///
    /// # Errors
    /// A value beyond ±1e50.
    pub fn new(value: f64) -> Result<Self, ParameterError> {
        Ok(Constant(check::quantity("constant excitation", value)?))
    }
}

impl Excitation for Constant {
    fn jet(&self, _: f64, _: Side) -> Jet {
        Jet::constant(self.0)
    }
    fn repeats(&self) -> Repeats {
        Repeats::Always
    }
}
