//! A motion that is reduced to a row.

use crate::analysis::{ContactStatistics, Rattle, Summary};
use crate::model::Periodic;
use crate::ode::Observer;
use crate::sweep::engines::track::{Next, Plan, Track};
use crate::sweep::lanes::flanks::ContactMeter;
use crate::sweep::lanes::meter::ChannelMeter;
use crate::sweep::sweep_error::PointError;
use crate::sweep::taylor::lane::{Lane, Motion};
use crate::sweep::taylor::tasks::task::{Ended, Task};

/// The row of a motion, period by period.
pub(crate) struct RowTask<'m> {
    track: Track,
    model: &'m (dyn Periodic + 'm),
    period: f64,
    atol: &'m [f64],
    rattle: Rattle<'m>,
    counted: Vec<ContactStatistics>,
    /// Numbers of channels and contacts of a row.
    measured: [usize; 2],
    /// Steps in the current period.
    steps: u64,
}

impl<'m> RowTask<'m> {
    /// `atol`: absolute tolerance of each coordinate and velocity.
    pub(crate) fn new(
        plan: &Plan,
        model: &'m (dyn Periodic + 'm),
        motion: &Motion<'m>,
        atol: &'m [f64],
    ) -> Self {
        let rattle = Rattle::new(motion.model);
        RowTask {
            track: Track::new(plan, &motion.start.q, &motion.start.v),
            model,
            period: model.period(),
            atol,
            counted: rattle.contacts().to_vec(),
            rattle,
            measured: [plan.layout.channels, plan.layout.contacts],
            steps: 0,
        }
    }

    /// The row and the last state (coordinates, then velocities).
    pub(crate) fn finish(self) -> (Vec<f64>, Vec<f64>) {
        let model = self.model;
        self.track.finish(&|read: &mut dyn FnMut(&dyn Periodic)| read(model))
    }

    fn period_end(&self) -> f64 {
        (self.track.periods + 1) as f64 * self.period
    }

    /// Ends a period. Returns whether the run is over.
    fn end_period(&mut self, lane: &mut Lane<'m>, ended: &mut Ended<'_>) -> Result<bool, PointError> {
        let (period, place) = (self.period, ended.view.lane);
        if self.track.measuring() {
            for i in 0..self.measured[0] {
                let summary: Summary = ended.meters.summary(i, place, period);
                self.track.add_channel(i, &ChannelMeter::of(&summary, period), period);
            }
            self.count_contacts();
            ended.meters.clear(place);
        }
        let steps = std::mem::take(&mut self.steps);
        lane.attempts = 0;
        let (state, model) = (lane.course.e.y1.slice().to_vec(), self.model);
        let with_model = &|read: &mut dyn FnMut(&dyn Periodic)| read(model);
        match self.track.period(steps, period, state.into_iter(), with_model) {
            Next::Done => Ok(true),
            Next::Diverged => Err(lane.not_finite().into()),
            Next::StartMeasuring => {
                ended.meters.clear(place);
                Ok(false)
            }
            Next::Settle | Next::Measure => Ok(false),
        }
    }

    /// Adds times and impacts of the contacts in the period that ends.
    fn count_contacts(&mut self) {
        for (i, counted) in self.counted.iter_mut().enumerate().take(self.measured[1]) {
            let (meter, time) = ContactMeter::since(self.rattle.contacts()[i], counted);
            self.track.add_contact(i, &meter, time);
        }
    }
}

impl<'m> Task<'m> for RowTask<'m> {
    type Error = PointError;

    fn tolerances(&self) -> &[f64] {
        self.atol
    }
    fn measures(&self) -> bool {
        self.track.measuring()
    }
    fn end(&mut self, lane: &mut Lane<'m>, mut ended: Ended<'_>) -> Result<bool, PointError> {
        self.steps += 1;
        if self.track.measuring() {
            let rattle = &mut self.rattle;
            let _ = lane.show(&ended.view, ended.at_edge, |step| rattle.step(step));
        }
        let e = &lane.course.e;
        if self.track.ranging() {
            self.track.see_state(e.y1.slice().iter().copied());
        }
        if e.t1 >= self.period_end() && self.end_period(lane, &mut ended)? {
            return Ok(true);
        }
        lane.course.passage.extend(self.period_end());
        let rebounds = lane.course.passage.crossings.iter().any(|crossing| crossing.rebounds);
        lane.pass(ended.at_edge)?;
        if rebounds && self.track.ranging() {
            self.track.see_state(lane.course.e.y.slice().iter().copied());
        }
        Ok(false)
    }
}
