//! Evaluation of runs: statistics, rattle, Poincaré sections, spectra, settling to the steady state.

pub(crate) mod rattle;
pub(crate) mod returns;
pub(crate) mod section;
pub(crate) mod settle;
pub(crate) mod spectrum;
pub(crate) mod statistics;
pub(crate) mod waterfall;

pub use crate::analysis::rattle::{ContactStatistics, Rattle, RattleState};
pub use crate::analysis::section::{Direction, Section, strobe};
pub use crate::analysis::settle::{Settle, Steady, Unsettled};
pub use crate::analysis::spectrum::{Spectrum, Window};
pub use crate::analysis::statistics::{Statistics, Summary};
pub use crate::analysis::waterfall::{Waterfall, WaterfallError, WaterfallLine};
pub use crate::ode::probe::Probe;
