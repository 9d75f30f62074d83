//! What is measured along an orbit: statistics of channels, rattle states, extremes, ranges of motion.

use crate::analysis::motion_size::MotionSize;
use crate::analysis::{Rattle, RattleState, Statistics, Summary};
use crate::branches::curve::equations::CurveError;
use crate::branches::orbits::by_shooting::orbit_curve::{OrbitCurve, Passage};
use crate::branches::orbits::contact_trace::{ContactTrace, Tracer};
use crate::branches::orbits::symmetries::Symmetries;
use crate::error::ParameterError;
use crate::model::{Channel, Model};
use crate::ode::probe::Probe;
use crate::periodic::flow::walk::Walk;

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
    /// Whether the orbit has each of its possible symmetries in time; empty where they are not compared.
    pub(crate) symmetries: Vec<bool>,
}

/// Integrates once along an orbit, from node to node, and measures it.
pub(crate) fn measure(
    curve: &OrbitCurve<'_>,
    p: f64,
    passage: &Passage,
    channels: &[Channel],
) -> Result<Measured, CurveError> {
    let model = curve.model(p)?;
    let plain: &dyn Model = &*model;
    let (start, period) = (passage.states[0].t, passage.end - passage.states[0].t);
    let names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
    let mut statistics =
        Statistics::new(plain, &names).map_err(|error| CurveError::Model { parameter: p, error })?;
    let mut rattle = Rattle::new(plain);
    let mut tracer = Tracer::new(plain, start, period);
    let mut symmetries = Symmetries::new(plain.dof(), start, period, curve.multiple());
    let mut motion = MotionSize::new(plain.dof(), curve.modes());
    {
        let mut first = (&mut statistics, &mut rattle);
        let mut along = motion.along(plain);
        let mut second = (&mut tracer, &mut along);
        let mut third = (&mut second, &mut symmetries);
        Walk::new(plain, curve.scale(), curve.flow_tolerance(), passage.method())
            .follow(&passage.states, passage.end, &mut (&mut first, &mut third), curve.meter())
            .map_err(OrbitCurve::failed)?;
    }
    let summaries = names.iter().filter_map(|name| statistics.summary(name).ok()).collect();
    let rattle = rattle.contacts().iter().map(|contact| contact.rattle_state()).collect();
    let (ranges, units) = (motion.ranges(), motion.units(curve.flow_tolerance()));
    let symmetries = symmetries.kept(&units);
    Ok(Measured { summaries, rattle, trace: tracer.trace, ranges, units, symmetries })
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
        return wanted.iter().map(|name| Ok(probe.channels()[probe.index(name)?].clone())).collect();
    }
    let found = probe.channels().iter().find(|channel| channel.name.starts_with("deflection"));
    Ok(vec![found.cloned().map_or_else(|| Ok(probe.channels()[probe.index("q0")?].clone()), Ok)?])
}
