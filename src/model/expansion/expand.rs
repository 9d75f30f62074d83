//! The trait of models with a Taylor series.

use crate::series::Series;
use crate::tape::tape::Tape;

/// A model that can be expanded into Taylor series over time.
///
/// [`Machine`](crate::Machine) implements it for every [`Shape`](crate::Shape), and
/// [`Wrapped`](crate::drives::Wrapped) for its rules. [`Taylor`](crate::Taylor) asks for it through
/// [`Model::expand`](crate::Model::expand).
///
/// ```
/// use gear_dynamics::model::Series;
/// use gear_dynamics::{Model, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let expanded = pair.expand().expect("a machine can be expanded");
/// let mut u = vec![Series::from(0.0); pair.drives()];
/// expanded.drive_series(0.0, 8, &mut u);
/// assert_eq!(u[0].coefficients().len(), 8);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub trait Expand {
    /// Records the algebra. `moving(d)`: drive d is written by [`drive_series`](Expand::drive_series) at
    /// every step, although it is a constant of the model.
    fn record(&self, moving: &dyn Fn(usize) -> bool) -> Recorded;
    /// Writes the drives after `t` to `u` as series over the time after `t`, with this number of
    /// coefficients.
    fn drive_series(&self, t: f64, coefficients: usize, u: &mut [Series]);
    /// Updates `u`, which contains the series after another instant. The implementation may skip drives that
    /// never change. Default: [`drive_series`](Expand::drive_series).
    fn redrive_series(&self, t: f64, coefficients: usize, u: &mut [Series]) {
        self.drive_series(t, coefficients, u);
    }
}

/// A recorded algebra. Only [`Taylor`](crate::Taylor) reads it.
///
/// ```
/// use gear_dynamics::{Model, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let recorded = pair.expand().expect("a machine can be expanded").record(&|_| false);
/// assert_eq!(recorded.dof(), 1);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Recorded(pub(crate) Tape);

impl Recorded {
    /// Number of degrees of freedom.
    pub fn dof(&self) -> usize {
        self.0.dof
    }
}
