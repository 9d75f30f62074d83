//! Evaluation of runs: statistics, rattle, impacts, Poincaré sections, spectra, settling to the steady state.

pub(crate) mod contacts;
pub(crate) mod motion_size;
pub(crate) mod returns;
pub(crate) mod section;
pub(crate) mod settle;
pub(crate) mod spectra;
pub(crate) mod statistics;

pub use crate::analysis::contacts::impact::{Impact, ImpactSummary};
pub use crate::analysis::contacts::impacts::Impacts;
pub use crate::analysis::contacts::rattle::{ContactStatistics, Rattle, RattleState};
pub use crate::analysis::section::{Direction, Section};
pub use crate::analysis::settle::{Settle, SettleError, Steady};
pub use crate::analysis::spectra::density::Density;
pub use crate::analysis::spectra::spectrum::Spectrum;
pub use crate::analysis::spectra::waterfall::{Waterfall, WaterfallLine};
pub use crate::analysis::spectra::welch::Welch;
pub use crate::analysis::spectra::window::Window;
pub use crate::analysis::statistics::{Statistics, Summary};
