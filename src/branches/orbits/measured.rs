//! What is measured along an orbit: statistics of channels, rattle states, extremes, ranges of motion.

use crate::analysis::{RattleState, Summary};
use crate::branches::orbits::contact_trace::ContactTrace;
use crate::error::ParameterError;
use crate::model::{Channel, Model};
use crate::ode::probe::Probe;

/// Figures of one orbit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Measured {
    /// One for each channel.
    pub(crate) summaries: Vec<Summary>,
    /// One for each contact.
    pub(crate) rattle: Vec<RattleState>,
    pub(crate) trace: ContactTrace,
    /// Ranges of motion of coordinates and velocities.
    pub(crate) ranges: Vec<f64>,
    /// Their units in the integration: the ranges, or larger units where rounding requires them.
    pub(crate) units: Vec<f64>,
    /// How far the orbit is from each of its possible symmetries in time; empty where they are not compared.
    pub(crate) symmetries: Vec<f64>,
}

/// The wanted channels; otherwise the first deflection, or the first coordinate of a model without contacts.
pub(crate) fn chosen_channels(
    wanted: Option<&[String]>,
    model: &dyn Model,
) -> Result<Vec<Channel>, ParameterError> {
    let probe = Probe::new(model);
    if let Some(wanted) = wanted {
        if let Some(twice) =
            wanted.iter().enumerate().find_map(|(i, name)| wanted[..i].contains(name).then_some(name))
        {
            return Err(ParameterError::Twice { name: twice.clone() });
        }
        return Ok(probe.indices(wanted)?.into_iter().map(|i| probe.channels()[i].clone()).collect());
    }
    let found = probe.channels().iter().find(|channel| channel.name.starts_with("deflection"));
    Ok(vec![found.cloned().map_or_else(|| Ok(probe.channels()[probe.index("q0")?].clone()), Ok)?])
}
