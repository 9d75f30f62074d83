//! A motion and its directions, part by part.

use crate::model::State;
use crate::periodic::lyapunov::directions::Directions;
use crate::periodic::lyapunov::exponents::Exponents;
use crate::periodic::pursuit::{Pursuit, PursuitError};

/// Minimum length of a direction after a part of a period, without its components along the directions before
/// it `[1]`. The directions start with length 1. The error of the integration is relative to that length, so
/// that a shorter direction is too inaccurate.
const SHORTEST_DIRECTION: f64 = 1e-3;

/// Maximum number of halvings of a part of a period.
const HALVINGS: u32 = 40;

/// The exponents of one motion while they are computed.
///
/// A part of a period is halved, and the directions are made orthonormal after each interval, until no
/// direction shrinks below [`SHORTEST_DIRECTION`].
pub(crate) struct Progress<'s> {
    pub(crate) exponents: Exponents,
    directions: Directions<'s>,
    /// Motion and directions at the start of the interval.
    state: State,
    /// Start of the first period.
    from: f64,
    /// Parts of a period.
    renormalisations: usize,
    /// Alignment periods, measured periods.
    periods: [usize; 2],
    /// Completed parts.
    parts: usize,
    /// Local error of the flow.
    tolerance: f64,
    /// Share of the current part that is done, a multiple of 2^-halvings.
    done: f64,
    /// Current number of halvings of a part.
    halvings: u32,
}

impl<'s> Progress<'s> {
    /// `state`: the motion with room for its directions, which are drawn from `start`. `periods`: alignment
    /// and measured periods.
    pub(crate) fn new(
        exponents: Exponents,
        mut state: State,
        start: &State,
        scale: &'s [f64],
        renormalisations: usize,
        periods: [usize; 2],
        tolerance: f64,
    ) -> Self {
        let mut directions = Directions::new(exponents.grown.len(), scale);
        directions.draw(start, &mut state);
        let from = state.t;
        Progress {
            exponents,
            directions,
            state,
            from,
            renormalisations,
            periods,
            parts: 0,
            tolerance,
            done: 0.0,
            halvings: 0,
        }
    }

    /// The share of the interval in its part.
    fn share(&self) -> f64 {
        (-f64::from(self.halvings)).exp2()
    }

    /// The time at which this number of parts is complete.
    fn end_of(&self, parts: usize) -> f64 {
        let (period, part) = (parts / self.renormalisations, parts % self.renormalisations);
        self.from + self.exponents.span * (period as f64 + part as f64 / self.renormalisations as f64)
    }

    /// Adds the growth over a complete part.
    fn end_part(&mut self) {
        let [align, _] = self.periods;
        let period = self.parts / self.renormalisations;
        self.parts += 1;
        for (k, all) in self.exponents.grown.iter_mut().enumerate().filter(|_| period >= align) {
            all.turn(self.directions.turned(k, 0));
        }
        self.directions.mark(0);
        for (all, grown) in self.exponents.grown.iter_mut().zip(&mut self.directions.growth) {
            match period >= align {
                true => all.measure(*grown),
                false if period >= align / 2 => all.align(*grown),
                false => {}
            }
            *grown = 0.0;
        }
        if self.parts.is_multiple_of(self.renormalisations) {
            if period >= align {
                let all = self.exponents.grown.iter_mut().enumerate();
                all.for_each(|(k, growth)| growth.period(self.directions.turned(k, 1)));
            }
            self.directions.mark(1);
            let (State { t, q, v }, n) = (&self.state, self.exponents.state.q.len());
            self.exponents.state = State::new(*t, &q[..n], &v[..n]);
        }
        self.done = 0.0;
        self.halvings = self.halvings.saturating_sub(1);
    }
}

impl Pursuit for Progress<'_> {
    fn state(&self) -> &State {
        &self.state
    }
    fn tolerance(&self) -> f64 {
        self.tolerance
    }
    fn target(&self) -> Option<f64> {
        let periods = self.periods[0].saturating_add(self.periods[1]);
        if self.parts / self.renormalisations >= periods {
            return None;
        }
        let next = self.done + self.share();
        let end = self.end_of(self.parts + 1);
        let begin = self.end_of(self.parts);
        Some(if next < 1.0 { begin + (end - begin) * next } else { end })
    }
    fn arrive(&mut self, ahead: &State) -> Result<bool, PursuitError> {
        let (shortest, length) = self.directions.measure(ahead);
        if length >= SHORTEST_DIRECTION || (length > 0.0 && self.halvings == HALVINGS) {
            self.state.clone_from(ahead);
            self.directions.accept(&mut self.state);
            self.done += self.share();
            if self.done >= 1.0 {
                self.end_part();
            }
            return Ok(true);
        }
        if self.halvings == HALVINGS {
            return Err(PursuitError::Vanished { direction: shortest, t: self.state.t });
        }
        self.halvings += 1;
        Ok(false)
    }
}
