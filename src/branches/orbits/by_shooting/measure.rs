//! Figures of an orbit by one integration along it.

use crate::analysis::motion_size::MotionSize;
use crate::analysis::{Rattle, Statistics};
use crate::branches::curve::equations::CurveError;
use crate::branches::orbits::by_shooting::orbit_curve::{OrbitCurve, Passage};
use crate::branches::orbits::contact_trace::Tracer;
use crate::branches::orbits::measured::Measured;
use crate::branches::orbits::symmetries::Symmetries;
use crate::model::{Channel, Model};
use crate::periodic::flow::walk::Walk;

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
    let mut motion = MotionSize::new(plain.dof(), curve.drifts());
    {
        let mut first = (&mut statistics, &mut rattle);
        let mut along = motion.along(plain);
        let mut second = (&mut tracer, &mut along);
        let mut third = (&mut second, &mut symmetries);
        Walk::new(plain, curve.scale(), curve.flow_tolerance(), passage.method())
            .follow(
                &passage.states,
                passage.end,
                &mut (&mut first, &mut third),
                curve.meter(),
                &|_, _| Ok(()),
            )
            .map_err(OrbitCurve::failed)?;
    }
    let summaries = names.iter().filter_map(|name| statistics.summary(name).ok()).collect();
    let rattle = rattle.contacts().iter().map(|contact| contact.rattle_state()).collect();
    let (ranges, units) = (motion.ranges(), motion.units(curve.flow_tolerance()));
    let symmetries = symmetries.distances(&units);
    Ok(Measured { summaries, rattle, trace: tracer.trace, ranges, units, symmetries })
}
