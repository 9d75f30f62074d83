//! Contact laws.

pub(crate) mod backlash;
pub(crate) mod damped;
pub(crate) mod mixed;
pub(crate) mod no_pull;
pub(crate) mod nonlinearity;
pub(crate) mod power;
pub(crate) mod smooth;
