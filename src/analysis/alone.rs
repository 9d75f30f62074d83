//! Coordinates that nothing connects, while a motion settles.

use crate::model::State;
use crate::model::structure::drifts::unconnected;

/// While the other coordinates are at the distance δ from their orbit, the velocity may change in a period by
/// this factor times δ times its range `[1]`.
const GAINS: f64 = 100.0;

/// This change is at most this share of the range of the velocity `[1]`. A constant acceleration changes the
/// velocity by its whole range.
const MOST: f64 = 0.5;

/// Velocities of the coordinates that nothing connects. Such a coordinate is a rigid motion, and the change
/// of the state leaves it out. If its velocity changes in every period, the motion has no periodic orbit.
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

    /// The first coordinate that accelerates, and the change of its velocity between two states a period
    /// apart. Changes that the `distance` of the other coordinates from their orbit can cause do not count.
    pub(crate) fn accelerates(&self, now: &[f64], before: &[f64], distance: f64) -> Option<(usize, f64)> {
        let n = now.len() / 2;
        let gains = self.coordinates.iter().zip(&self.ranges).map(|(&i, [low, high])| {
            let (gain, size) = (now[n + i] - before[n + i], now[n + i].abs());
            (i, gain, ((GAINS * distance).min(MOST) * (high - low)).max(distance * size))
        });
        gains.into_iter().find(|(_, gain, limit)| gain.abs() > *limit).map(|(i, gain, _)| (i, gain))
    }
}
