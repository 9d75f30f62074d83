//! Newton's method for an orbit of one segment, whose flow is integrated by others.

use crate::model::State;
use crate::periodic::flow::tangent::Tangent;
use crate::periodic::multipliers::Multipliers;
use crate::periodic::pursuit::{Pursuit, PursuitError};
use crate::periodic::shooting::cyclic::Cyclic;
use crate::periodic::shooting::failure::{Iterate, ShootingError};
use crate::periodic::shooting::multiple::Shooting;
use crate::periodic::shooting::segments::{LOOSER, Segments, drift};
use nalgebra::{DMatrix, DVector};

/// The orbit of one motion while it is found: single shooting from a guess that is nearly closed, so that
/// the steps of Newton's method are not damped. Tolerances, convergence and errors are those of [`Shooting`].
///
/// The orbit is integrated once more with the looser tolerance of the flow, for the error of its multipliers.
pub(crate) struct Closing<'s, 't> {
    shooting: &'s Shooting,
    segments: &'s Segments<'s>,
    tangent: &'s Tangent<'t>,
    /// The motion and its differences at the start of the orbit.
    state: State,
    slack: Option<DVector<f64>>,
    /// Sizes of the corrections, as shares of the ranges.
    corrections: Vec<f64>,
    /// Size of the last correction.
    before: f64,
    /// The multipliers, once the orbit is found; first without an error.
    outcome: Option<Result<Multipliers, ShootingError>>,
    over: bool,
}

impl<'s, 't> Closing<'s, 't> {
    pub(crate) fn new(
        shooting: &'s Shooting,
        segments: &'s Segments<'s>,
        tangent: &'s Tangent<'t>,
        guess: &State,
    ) -> Self {
        Closing {
            shooting,
            segments,
            tangent,
            state: tangent.start(guess),
            slack: None,
            corrections: Vec::new(),
            before: f64::INFINITY,
            outcome: None,
            over: false,
        }
    }

    /// The multipliers of the orbit; `failure`: why the integration ended early, if it did.
    pub(crate) fn finish(self, failure: Option<PursuitError>) -> Result<Multipliers, ShootingError> {
        let last = self.last();
        match (self.outcome, failure) {
            // The multipliers of an orbit that is found have no error estimate without the looser run.
            (Some(outcome), _) => outcome,
            (None, Some(PursuitError::Integrate(error))) => Err(ShootingError::of_segment(0, error, last)),
            (None, Some(PursuitError::Exhausted(exhausted))) => {
                Err(ShootingError::Exhausted { exhausted, last })
            }
            (None, _) => Err(self.segments.not_converged((0, f64::NAN), last)),
        }
    }

    fn last(&self) -> Iterate {
        Iterate { states: vec![self.tangent.motion(&self.state)], corrections: self.corrections.clone() }
    }

    /// Uses the end of a run with the tolerance of the flow.
    fn correct(&mut self, end: &State, monodromy: DMatrix<f64>) -> Result<(), ShootingError> {
        let start = self.tangent.motion(&self.state);
        let round = self.segments.closed(start, end, monodromy, self.slack.as_ref());
        let system = Cyclic::factor(&round.transitions, self.segments.rigid())
            .map_err(|component| ShootingError::Singular { component, last: self.last() })?;
        let (step, slack) = system.solve(&round.defects);
        let size = self.segments.norm(&step);
        let largest = self.segments.largest_change(&step, false);
        self.corrections.push(largest.1);
        if self.shooting.accepts([self.before, size], largest.1) {
            let [_, gains] = drift(self.segments.rigid(), &round.slack, self.segments.scale());
            if let Some((coordinate, gain)) = self.segments.accelerates(&gains) {
                return Err(ShootingError::Accelerates { coordinate, gain, last: self.last() });
            }
            let found = Multipliers::without(&round.monodromy(), self.segments.rigid(), f64::INFINITY)
                .map_err(|error| ShootingError::Multipliers { error, last: self.last() })?;
            self.outcome = Some(Ok(found));
            return Ok(());
        }
        let grows = size.is_nan() || size > self.before;
        if grows || self.corrections.len() == self.shooting.max_iterations {
            return Err(self.segments.failure(&round, largest, self.last()));
        }
        self.before = size;
        let (states, slack) = self.segments.moved(&round, &step, &slack, 1.0);
        self.state = self.tangent.start(&states[0]);
        self.slack = Some(slack);
        Ok(())
    }
}

impl Pursuit for Closing<'_, '_> {
    fn state(&self) -> &State {
        &self.state
    }
    fn target(&self) -> Option<f64> {
        (!self.over).then(|| self.segments.end())
    }
    fn tolerance(&self) -> f64 {
        let looser = if self.outcome.is_some() { LOOSER } else { 1.0 };
        looser * self.shooting.flow_tolerance
    }
    fn arrive(&mut self, ahead: &State) -> Result<bool, PursuitError> {
        let m = 2 * self.tangent.n;
        let monodromy = DMatrix::from_fn(m, m, |i, k| self.tangent.scaled(ahead, i, k));
        match self.outcome.take() {
            None => {
                if let Err(error) = self.correct(&self.tangent.motion(ahead), monodromy) {
                    self.outcome = Some(Err(error));
                    self.over = true;
                }
            }
            Some(found) => {
                let looser = Multipliers::without(&monodromy, self.segments.rigid(), 0.0).ok();
                self.outcome = Some(found.map(|found| found.compared_with(looser)));
                self.over = true;
            }
        }
        Ok(self.over)
    }
}
