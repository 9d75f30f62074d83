//! Random loads: white noise, densities, rare events.

pub(crate) mod rare;
pub(crate) mod white;

pub use crate::random::rare::passage::{FirstPassage, PassageTimes};
pub use crate::random::rare::score::{Event, Moment};
pub use crate::random::rare::splitting::{RareEvent, Splitting};
pub use crate::random::white::error::NoiseError;
pub use crate::random::white::estimate::Estimate;
pub use crate::random::white::long_run::LongRun;
pub use crate::random::white::noise::WhiteNoise;
pub use crate::random::white::solver::NoisySteps;
pub use crate::random::white::statistics::{ContactEstimates, NoiseStatistics};
