//! States.

use std::iter::{Once, once};

use crate::error::{ParameterError, check};

/// The state of a model: coordinates and velocities at a time.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, State, model::from_fn};
/// let pulled = from_fn(1, |_, _, _, a| a[0] = -1.0)?; // q'' = -1
/// let end = Dop853::new().end(&pulled, &State::new(0.0, &[0.5], &[2.0]), 3.0)?;
/// // q = 0.5 + 2 t - t²/2 and q' = 2 - t at t = 3
/// assert!((end.q[0] - 2.0).abs() < 1e-9 && (end.v[0] + 1.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct State {
    /// Time, in the time unit of the model.
    pub t: f64,
    /// Coordinates q.
    pub q: Vec<f64>,
    /// Velocities q'.
    pub v: Vec<f64>,
}

impl State {
    /// A state from a time, coordinates and velocities.
    pub fn new(t: f64, q: &[f64], v: &[f64]) -> Self {
        State { t, q: q.to_vec(), v: v.to_vec() }
    }

    /// The state at time 0 with all coordinates and velocities 0.
    pub fn at_rest(dof: usize) -> Self {
        State { t: 0.0, q: vec![0.0; dof], v: vec![0.0; dof] }
    }

    /// Checks that the state fits a model of `dof` degrees of freedom and that all numbers are within ±1e50.
    pub(crate) fn check(&self, dof: usize) -> Result<(), ParameterError> {
        check::length("start.q", self.q.len(), dof)?;
        check::length("start.v", self.v.len(), dof)?;
        check::quantity("start.t", self.t)?;
        check::quantities("start.q", &self.q)?;
        check::quantities("start.v", &self.v)
    }

    /// As [`check`](State::check), for what starts at time 0.
    pub(crate) fn check_at_zero(&self, dof: usize) -> Result<(), ParameterError> {
        self.check(dof)?;
        if self.t != 0.0 {
            let must = "be 0, where these runs start".into();
            return Err(ParameterError::Wrong { name: "start.t".into(), value: self.t, must });
        }
        Ok(())
    }
}

/// A state is a list of one state where a start may be one state, several or none.
impl<'s> IntoIterator for &'s State {
    type Item = &'s State;
    type IntoIter = Once<&'s State>;

    fn into_iter(self) -> Once<&'s State> {
        once(self)
    }
}
