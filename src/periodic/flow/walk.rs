//! The motion along an orbit, integrated from node to node.

use crate::model::{Model, State};
use crate::ode::budget::Meter;
use crate::ode::{Finish, IntegrateError, Observer, Stats, Step, Taylor};
use crate::periodic::flow::continued::Continued;
use crate::periodic::flow::flow_method::{Accuracy, Chosen, Expansion, FlowMethod};
use std::ops::ControlFlow;

/// Relative tolerance so small that only the absolute tolerances have an effect.
pub(crate) const NONE: f64 = 1e-300;

/// An absolute tolerance, at least four rounding errors of the value.
pub(crate) fn finest(tolerance: f64, value: f64) -> f64 {
    tolerance.max(4.0 * f64::EPSILON * value.abs())
}

/// The segments of an orbit: index, node, time of the next node or of the end.
pub(crate) fn segments(states: &[State], end: f64) -> impl Iterator<Item = (usize, &State, f64)> {
    let until = states.iter().skip(1).map(|next| next.t).chain([end]);
    states.iter().zip(until).enumerate().map(|(i, (node, until))| (i, node, until))
}

/// The integration over a segment failed.
#[derive(Debug)]
pub(crate) struct SegmentError {
    /// Index of the segment, from 0.
    pub(crate) segment: usize,
    pub(crate) error: IntegrateError,
}

/// Integrates the motion along an orbit. Each segment starts from its node, so that the motion also stays on
/// an unstable orbit.
pub(crate) struct Walk<'m> {
    continued: Continued<'m>,
    /// Units of coordinates and velocities.
    scale: &'m [f64],
    /// Local error in these units.
    tolerance: f64,
    expansion: Expansion,
}

impl<'m> Walk<'m> {
    pub(crate) fn new(
        model: &'m (dyn Model + 'm),
        scale: &'m [f64],
        tolerance: f64,
        method: FlowMethod,
    ) -> Self {
        let continued = Continued::new(model, scale);
        let expansion = Expansion::of_motion(&continued, &Chosen::Method(method));
        Walk { continued, scale, tolerance, expansion }
    }

    /// Integrates from a state to a time.
    pub(crate) fn run(
        &self,
        from: &State,
        until: f64,
        observer: &mut dyn Observer,
        meter: &Meter<'_>,
    ) -> Result<Finish, IntegrateError> {
        let values = from.q.iter().chain(&from.v);
        let atol: Vec<f64> =
            self.scale.iter().zip(values).map(|(s, y)| finest(self.tolerance * s, *y)).collect();
        let mut spend = meter;
        let mut watch = |step: &mut Step<'_>| {
            if observer.step(step).is_break() { ControlFlow::Break(()) } else { spend.step(step) }
        };
        let order = Taylor::order_for(self.tolerance);
        let accuracy = Accuracy { rtol: NONE, atol: &atol, order, first: 0.0 };
        let finish = self.expansion.run(&accuracy, &self.continued, from, until, &mut watch)?;
        meter.left().map_err(|exhausted| IntegrateError::Exhausted { t: finish.state.t, exhausted })?;
        Ok(finish)
    }

    /// Integrates over all segments, until the observer stops. `closes`: the check of the end of a segment,
    /// given by its index and the state there.
    pub(crate) fn follow(
        &self,
        states: &[State],
        end: f64,
        observer: &mut dyn Observer,
        meter: &Meter<'_>,
        closes: &dyn Fn(usize, &State) -> Result<(), IntegrateError>,
    ) -> Result<Stats, SegmentError> {
        let mut all = Stats::default();
        for (segment, node, until) in segments(states, end) {
            let of_segment = |error| SegmentError { segment, error };
            let finish = self.run(node, until, observer, meter).map_err(of_segment)?;
            all.add(&finish.stats);
            if finish.stopped {
                break;
            }
            closes(segment, &finish.state).map_err(of_segment)?;
        }
        Ok(all)
    }
}
