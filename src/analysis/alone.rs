//! Coordinates that nothing connects, while a motion settles.

use crate::model::State;
use crate::model::structure::unconnected::unconnected;

/// Gain of velocity in a period that a motion at the distance δ from its orbit may have, over δ range.
const GAINS: f64 = 100.0;

/// Largest share of the range of a velocity that counts as such a gain: a constant acceleration has 1.
const MOST: f64 = 0.5;

/// Velocities of the coordinates that nothing connects: they are rigid motions and do not count in the change
/// of the state, but where they change in every period there is no orbit.
pub(crate) struct Alone {
    coordinates: Vec<usize>,
    /// Least and greatest velocity of each over the last period.
    ranges: Vec<[f64; 2]>,
}

impl Alone {
    /// `rigid`: orthonormal rigid motions.
    pub(crate) fn new(rigid: &[Vec<f64>]) -> Self {
        let coordinates = unconnected(rigid);
        Alone { ranges: vec![[0.0; 2]; coordinates.len()], coordinates }
    }

    /// Begins a period.
    pub(crate) fn begin(&mut self, start: &State) {
        self.ranges.iter_mut().zip(&self.coordinates).for_each(|(range, i)| *range = [start.v[*i]; 2]);
    }

    /// Adds velocities of the period.
    pub(crate) fn see(&mut self, v: &[f64]) {
        for ([low, high], i) in self.ranges.iter_mut().zip(&self.coordinates) {
            (*low, *high) = (low.min(v[*i]), high.max(v[*i]));
        }
    }

    /// The first coordinate whose velocity changes between two sections, and the change, if it is not due to
    /// the `distance` of the other coordinates from their orbit.
    pub(crate) fn accelerates(&self, now: &[f64], before: &[f64], distance: f64) -> Option<(usize, f64)> {
        let n = now.len() / 2;
        let gains = self.coordinates.iter().zip(&self.ranges).map(|(&i, [low, high])| {
            let (gain, size) = (now[n + i] - before[n + i], now[n + i].abs());
            (i, gain, ((GAINS * distance).min(MOST) * (high - low)).max(distance * size))
        });
        gains.into_iter().find(|(_, gain, limit)| gain.abs() > *limit).map(|(i, gain, _)| (i, gain))
    }
}
