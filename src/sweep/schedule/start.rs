//! Start states of the runs of a sweep.

use crate::model::State;
use crate::sweep::sweep_error::FamilyError;
use std::error::Error as AnyError;

/// What a function of [`Runner::start`](crate::sweep::Runner::start) returns: a [`State`], or a result with
/// an error of its own.
pub trait IntoStart {
    /// The state, or the error.
    ///
    /// # Errors
    /// That of the function.
    fn into_start(self) -> Result<State, FamilyError>;
}

impl IntoStart for State {
    fn into_start(self) -> Result<State, FamilyError> {
        Ok(self)
    }
}

impl<E: Into<Box<dyn AnyError + Send + Sync>>> IntoStart for Result<State, E> {
    fn into_start(self) -> Result<State, FamilyError> {
        self.map_err(FamilyError::new)
    }
}
