//! Newton's method of multiple shooting.

use crate::model::{Model, Periodic, State};
use crate::ode::IntegrateError;
use crate::ode::budget::Meter;
use crate::periodic::flow::flow_method::Expansion;
use crate::periodic::flow::variation::unscaled;
use crate::periodic::flow::walk::SegmentError;
use crate::periodic::multipliers::Multipliers;
use crate::periodic::shooting::cyclic::Cyclic;
use crate::periodic::shooting::failure::{Iterate, ShootingError};
use crate::periodic::shooting::guess::Guess;
use crate::periodic::shooting::multiple::Shooting;
use crate::periodic::shooting::segments::{Purpose, Round, Segments, drift};
use crate::periodic::shooting::shooting_orbit::{OrbitParts, ShootingOrbit};
use crate::roots::newton::is_monotone;

/// Minimum damping factor; the iteration fails below it.
const MIN_DAMPING: f64 = 1.0 / 1024.0;

/// Correction above which the motion of the orbit is compared with that of the guess, as a share of the
/// latter `[1]`.
const MOVED: f64 = 0.1;

/// Ratio of these motions above which the orbit is corrected in its own units `[1]`.
const SHRUNK: f64 = 10.0;

/// Maximum number of times that an orbit is corrected in its own units. A motion that comes to rest at 0
/// becomes smaller each time.
const UNITS: usize = 3;

/// A correction below this that no longer decreases is noise of the flow: rounding and the error of located
/// edges.
const NOISE: f64 = 1e-9;

/// An iterate is an orbit only if its last correction is at most this share of its range `[1]`. Far from the
/// origin the units of the tolerance are larger than the range.
const OPEN: f64 = 1e-3;

impl Shooting {
    /// [`solve`](Shooting::solve) with the rest of a budget.
    pub(crate) fn find(
        &self,
        model: &dyn Periodic,
        guess: &[State],
        meter: &Meter<'_>,
    ) -> Result<ShootingOrbit, ShootingError> {
        self.check(model.dof())?;
        let mut guess = Guess::of(model, &self.plan(), guess, meter)?;
        let (mut first, mut corrections, mut times) = (None, Vec::new(), 0);
        loop {
            let range = guess.scales[1].clone();
            let mut orbit = self.newton(model, guess, meter)?;
            let has_moved = orbit.corrections().iter().any(|correction| *correction > MOVED);
            first = first.or(Some(orbit.parts.first));
            corrections.append(&mut orbit.parts.corrections);
            // A correction far below the motion of the guess may be larger than that of the orbit.
            if has_moved && times < UNITS {
                let found = Guess::of(model, &self.plan(), orbit.states(), meter)?;
                if range.iter().zip(&found.scales[1]).any(|(of_guess, own)| *of_guess > SHRUNK * own) {
                    (guess, times) = (found, times + 1);
                    continue;
                }
            }
            orbit.parts.first = first.unwrap_or(orbit.parts.first);
            orbit.parts.corrections = corrections;
            return Ok(orbit);
        }
    }

    /// Whether the iteration may end with a correction of this `size`. It ends if the correction is within
    /// the tolerance. It also ends if the correction is noise of the flow: below [`NOISE`], and more than
    /// half of the correction `before`. `of_range`: the correction as a share of the ranges of motion. A
    /// motion far smaller than its distance from the origin takes one more correction. No orbit has a
    /// correction above [`OPEN`].
    pub(crate) fn accepts(&self, [before, size]: [f64; 2], of_range: f64) -> bool {
        let is_fine = of_range <= NOISE.max(self.tolerance) || before <= self.tolerance;
        let is_noise = size > 0.5 * before && size <= NOISE;
        of_range <= OPEN.max(self.tolerance) && ((size <= self.tolerance && is_fine) || is_noise)
    }

    /// Newton's method for the cyclic system. [`Newton`](crate::roots::Newton) does not replace it: one run
    /// gives residuals and transitions together, so that no factors are kept, a run that fails halves the
    /// step, and the iteration ends where the noise of the flow begins.
    fn newton(
        &self,
        model: &dyn Model,
        guess: Guess,
        meter: &Meter<'_>,
    ) -> Result<ShootingOrbit, ShootingError> {
        let expansion = Expansion::new(model, 2 * model.dof(), &[], &self.method).map_err(|error| {
            let last = Iterate { states: guess.states.clone(), corrections: Vec::new() };
            ShootingError::of_segment(0, error, last)
        })?;
        let segments = Segments::new(model, guess.scales, &guess.drifts, guess.end, Vec::new(), expansion);
        let mut corrections: Vec<f64> = Vec::new();
        let (mut first, mut before, mut largest) = (0.0, f64::INFINITY, (0, f64::NAN));
        let fail = |states: &[State], corrections: &[f64]| Iterate {
            states: states.to_vec(),
            corrections: corrections.to_vec(),
        };
        let mut here = segments
            .round(Purpose::Orbit, &guess.states, None, self.flow_tolerance, meter)
            .map_err(|SegmentError { segment, error }| {
                ShootingError::of_segment(segment, error, fail(&guess.states, &corrections))
            })?;
        for _ in 0..self.max_iterations {
            let last = |corrections: &[f64]| fail(&here.states, corrections);
            let system = match Cyclic::factor(&here.transitions, segments.rigid()) {
                Ok(system) => system,
                Err(component) => {
                    return Err(ShootingError::Singular { component, last: last(&corrections) });
                }
            };
            let (step, slack) = system.solve(&here.defects);
            let size = segments.norm(&step);
            if corrections.is_empty() {
                first = segments.largest_change(&step, true).1;
            }
            largest = segments.largest_change(&step, false);
            let accepted = self.accepts([before, size], largest.1);
            before = size;
            corrections.push(largest.1);
            if accepted {
                return self.finish(model, &segments, here, first, corrections, meter);
            }
            let mut damping = 1.0;
            let next = loop {
                let (states, slack) = segments.moved(&here, &step, &slack, damping);
                match segments.round(Purpose::Orbit, &states, Some(&slack), self.flow_tolerance, meter) {
                    Ok(trial) => {
                        let simplified = segments.norm(&system.solve(&trial.defects).0);
                        if is_monotone(simplified / size, damping) || simplified <= self.tolerance {
                            break Some(trial);
                        }
                    }
                    Err(SegmentError { segment, error: error @ IntegrateError::Exhausted { .. } }) => {
                        return Err(ShootingError::of_segment(segment, error, last(&corrections)));
                    }
                    Err(_) => {}
                }
                damping *= 0.5;
                if damping < MIN_DAMPING || size <= NOISE {
                    break None;
                }
            };
            here = match next {
                Some(round) => round,
                None if size <= NOISE && largest.1 <= OPEN => {
                    return self.finish(model, &segments, here, first, corrections, meter);
                }
                None => return Err(segments.failure(&here, largest, last(&corrections))),
            };
        }
        Err(segments.failure(&here, largest, fail(&here.states, &corrections)))
    }

    /// The orbit of a converged round.
    fn finish(
        &self,
        model: &dyn Model,
        segments: &Segments<'_>,
        round: Round,
        first: f64,
        corrections: Vec<f64>,
        meter: &Meter<'_>,
    ) -> Result<ShootingOrbit, ShootingError> {
        let drift = drift(segments.rigid(), &round.slack, segments.scale());
        if let Some((coordinate, gain)) = segments.accelerates(&drift[1]) {
            let last = Iterate { states: round.states, corrections };
            return Err(ShootingError::Accelerates { coordinate, gain, last });
        }
        let looser = segments
            .round(Purpose::Comparison, &round.states, Some(&round.slack), self.flow_tolerance, meter)
            .ok();
        let monodromy = round.monodromy();
        let multipliers = match Multipliers::without(&monodromy, segments.rigid(), f64::INFINITY) {
            Ok(multipliers) => multipliers,
            Err(error) => {
                let last = Iterate { states: round.states, corrections };
                return Err(ShootingError::Multipliers { error, last });
            }
        };
        let other =
            looser.and_then(|looser| Multipliers::without(&looser.monodromy(), segments.rigid(), 0.0).ok());
        let parts = OrbitParts {
            end: segments.end(),
            multiple: self.period_multiple,
            least: self.period_multiple,
            scale: segments.scale().to_vec(),
            range: segments.range().to_vec(),
            drift,
            monodromy: unscaled(&monodromy, segments.scale()),
            multipliers: multipliers.compared_with(other),
            first,
            crossings: round.crossings,
            flow: self.flow_tolerance,
            states: round.states,
            corrections,
            method: segments.method(),
        };
        let mut orbit = ShootingOrbit { parts, budget: self.budget.clone() };
        orbit.parts.least = orbit.found_multiple(model, segments, meter)?;
        Ok(orbit)
    }
}
