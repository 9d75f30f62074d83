//! Evaluation of runs.
//!
//! [`Settle`] runs a model to its steady state. Observers see every step of a run: [`Statistics`] gives
//! means and extremes of channels, [`Rattle`] the shares of time in contact and the rattle state,
//! [`Impacts`] the single impacts, [`Section`] the states where a quantity has a value. [`Spectrum`] is for
//! a periodic motion, [`Welch`] for an irregular one (its [`Density`]), [`Waterfall`] for a run-up. The
//! [guide page](crate::guide::results) shows each.

pub(crate) mod alone;
mod changes;
pub(crate) mod contacts;
pub(crate) mod motion_size;
pub(crate) mod returns;
pub(crate) mod section;
pub(crate) mod settle;
mod seven_points;
pub(crate) mod spectra;
pub(crate) mod statistics;
pub(crate) mod summary;

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
pub use crate::analysis::statistics::Statistics;
pub use crate::analysis::summary::Summary;
