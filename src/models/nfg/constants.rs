//! The named constants of a face gear pair.

use crate::contact::Nonlinearity;
use crate::error::{ParameterError, check};
use crate::model::{Channel, Machine, Shape};

/// Where the value of a constant may lie.
#[derive(Clone, Copy)]
pub(crate) enum Range {
    /// It is a divisor: 1e-50 .. 1e50.
    Scale,
    NotNegative,
}

/// The constants of a pair: name, unit and range. The last one, the half backlash, exists for a
/// [`Backlash`](crate::Backlash) alone.
pub(crate) struct Constants(pub(crate) [(&'static str, &'static str, Range); 6]);

impl Constants {
    pub(crate) fn names<N: Nonlinearity>(&self) -> Vec<Channel> {
        let count = if N::HALF_BACKLASH { 6 } else { 5 };
        self.0[..count].iter().map(|(name, unit, _)| Channel::new(*name, *unit)).collect()
    }
    pub(crate) fn check(&self, values: &[f64]) -> Result<(), ParameterError> {
        self.0.iter().zip(values).try_for_each(|((name, _, range), value)| {
            match range {
                Range::Scale => check::scale(*name, *value),
                Range::NotNegative => check::not_negative(*name, *value),
            }
            .map(drop)
        })
    }
    /// The machine of a shape with these constants.
    pub(crate) fn machine<G: Shape>(&self, shape: G, values: [f64; 6]) -> Result<Machine<G>, ParameterError> {
        let given: Vec<(&str, f64)> = self.0.iter().zip(values).map(|((name, ..), x)| (*name, x)).collect();
        let count = shape.names().len();
        Machine::of_constants(shape, &given[..count])
    }
}
