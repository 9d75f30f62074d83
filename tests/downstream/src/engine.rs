//! A sweep engine of one's own.

use gear_dynamics::ode::Step;
use gear_dynamics::sweep::{EnginePeriod, PeriodEngine, PointError};
use gear_dynamics::{Dop853, Integrator, Periodic, Rattle, State, Statistics};
use std::ops::ControlFlow;

/// An engine that integrates each period with [`Dop853`] and observes it: what [`Located`](gear_dynamics::sweep::Located) does
/// for models without rigid stops.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Straightforward(pub Dop853);

impl<M: Periodic> PeriodEngine<M> for Straightforward {
    fn period(&self, model: &M, state: &mut State, period: &mut EnginePeriod<'_>) -> Result<(), PointError> {
        let names: Vec<&str> = period.channels().iter().map(|channel| channel.name.as_str()).collect();
        let mut statistics = Statistics::new(model, &names).map_err(PointError::of_engine)?;
        let (mut rattle, end) = (Rattle::new(model), period.end());
        let mut look = |step: &mut Step<'_>| {
            period.see(step.y1());
            if period.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let finish = self.0.run(model, state, end, &mut (&mut look, &mut (&mut statistics, &mut rattle)))?;
        period.steps(finish.stats.steps);
        *state = finish.state;
        if period.is_measured() && !finish.stopped {
            for i in 0..period.channels().len() {
                let name = period.channels()[i].name.clone();
                period.channel(i, &statistics.summary(&name).map_err(PointError::of_engine)?);
            }
            for (i, counted) in rattle.contacts().iter().enumerate() {
                period.contact(i, counted);
            }
        }
        Ok(())
    }
}
