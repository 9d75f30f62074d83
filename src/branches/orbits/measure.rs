//! What is measured along an orbit: statistics of channels, rattle states, extremes, ranges of motion.

use crate::analysis::contacts::rattle::{Rattle, RattleState};
use crate::analysis::motion_size::MotionSize;
use crate::analysis::statistics::{Statistics, Summary};
use crate::branches::curve::equations::CurveError;
use crate::branches::orbits::by_shooting::orbit_curve::{OrbitCurve, Passage};
use crate::branches::orbits::contact_trace::{ContactTrace, Tracer};
use crate::branches::orbits::symmetries::Symmetries;
use crate::error::ParameterError;
use crate::model::equations::{Channel, Model};
use crate::ode::integrate_error::IntegrateError;
use crate::ode::integrator::Integrator;
use crate::ode::methods::dop853::Dop853;
use crate::ode::probe::Probe;
use crate::ode::step::{Observer, Step};
use crate::ode::taylor::integrate::Prepared;
use crate::ode::taylor::settings::Taylor;
use crate::periodic::flow::continued::Continued;
use crate::periodic::flow::flow_method::FlowMethod;
use crate::periodic::flow::tangent::{NONE, finest};
use std::ops::ControlFlow;

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
        pass(curve, plain, passage, &mut (&mut first, &mut third))?;
    }
    let summaries = names.iter().filter_map(|name| statistics.summary(name).ok()).collect();
    let rattle = rattle.contacts().iter().map(|contact| contact.rattle_state()).collect();
    let (ranges, units) = (motion.ranges(), motion.units(curve.flow_tolerance()));
    let symmetries = symmetries.held(&units);
    Ok(Measured { summaries, rattle, trace: tracer.trace, ranges, units, symmetries })
}

/// Integrates over all segments of an orbit.
fn pass(
    curve: &OrbitCurve<'_>,
    model: &dyn Model,
    passage: &Passage,
    observer: &mut dyn Observer,
) -> Result<(), CurveError> {
    let (scale, tolerance, meter) = (curve.scale(), curve.flow_tolerance(), curve.meter());
    let continued = Continued::new(model, scale);
    let mut prepared = match passage.method() {
        FlowMethod::Taylor => Prepared::new(&continued).ok(),
        FlowMethod::Dop853 => None,
    };
    let mut spend = meter;
    let mut watch = |step: &mut Step<'_>| {
        if observer.step(step).is_break() { ControlFlow::Break(()) } else { spend.step(step) }
    };
    for (i, state) in passage.states.iter().enumerate() {
        let until = passage.states.get(i + 1).map_or(passage.end, |next| next.t);
        let values = state.q.iter().chain(&state.v);
        let atol: Vec<f64> = scale.iter().zip(values).map(|(s, y)| finest(tolerance * s, *y)).collect();
        let run = match &mut prepared {
            Some(prepared) => {
                let settings = Taylor::new().rtol(NONE).atol_each(&atol).order(Taylor::order_for(tolerance));
                prepared.run(&settings, &continued, state, until, &mut watch)
            }
            None => Dop853::new().rtol(NONE).atol_each(&atol).run(&continued, state, until, &mut watch),
        };
        run.map_err(|error: IntegrateError| CurveError::Flow { segment: i, error })?;
        meter.left()?;
    }
    Ok(())
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
    Ok(vec![found.cloned().map_or_else(|| Ok(probe.channels()[probe.index("q1")?].clone()), Ok)?])
}
