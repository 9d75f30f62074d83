//! Directions in which small differences grow, carried along a motion and kept orthonormal.

use crate::model::equations::{Model, State};
use crate::ode::budget::{Exhausted, Meter};
use crate::ode::error::IntegrateError;
use crate::periodic::flow::tangent::Tangent;
use crate::periodic::lyapunov::exponents::{Exponents, LyapunovError};
use crate::roots::norms::dot;

/// A direction that has shrunk to less than this, or is so near the ones before it, is known too badly: the flow holds it to a share of 1.
const LEAST: f64 = 1e-3;

/// Most halvings of a part of a period.
const HALVINGS: u32 = 40;

/// Why a run ends before its end.
pub(crate) enum Failure {
    Flow(IntegrateError),
    Exhausted(Exhausted),
    Vanished { direction: usize, t: f64 },
}

impl From<IntegrateError> for Failure {
    fn from(error: IntegrateError) -> Self {
        Failure::Flow(error)
    }
}

impl From<Exhausted> for Failure {
    fn from(exhausted: Exhausted) -> Self {
        Failure::Exhausted(exhausted)
    }
}

impl Failure {
    pub(crate) fn with(self, so_far: Exponents) -> LyapunovError {
        let so_far = Box::new(so_far);
        match self {
            Failure::Flow(error) => LyapunovError::Flow { error, so_far },
            Failure::Exhausted(exhausted) => LyapunovError::Exhausted { exhausted, so_far },
            Failure::Vanished { direction, t } => LyapunovError::Vanished { direction, t, so_far },
        }
    }
}

/// The motion and its directions, part by part.
pub(crate) struct Flow<'f, 'm> {
    pub(crate) tangent: &'f Tangent<'m, dyn Model + 'm>,
    /// Local error of the flow.
    pub(crate) tolerance: f64,
    pub(crate) meter: &'f Meter<'f>,
    pub(crate) directions: Directions<'f>,
    /// How often parts are halved at present.
    pub(crate) halvings: u32,
}

impl Flow<'_, '_> {
    /// Runs to `until`; the growth is that of the whole part. Directions are made orthonormal as often as they need it.
    pub(crate) fn part(&mut self, all: &mut State, until: f64) -> Result<(), Failure> {
        self.directions.growth.fill(0.0);
        let (from, mut done) = (all.t, 0.0);
        // One part in 2^halvings, the share done a whole number of them.
        self.halvings = self.halvings.saturating_sub(1);
        while done < 1.0 {
            let share = (-f64::from(self.halvings)).exp2();
            let next = done + share;
            let end = if next < 1.0 { from + (until - from) * next } else { until };
            // The tolerance is no finer than the rounding of the motion, which may have grown.
            let solver = self.tangent.solver(self.tolerance, all);
            let ahead = self.tangent.run_metered(&solver, all.clone(), end, Some(self.meter))?.0;
            self.meter.left()?;
            let least = self.directions.measure(&ahead);
            if least.1 >= LEAST || (least.1 > 0.0 && self.halvings == HALVINGS) {
                *all = ahead;
                self.directions.accept(all);
                done = next;
            } else if self.halvings < HALVINGS {
                self.halvings += 1;
            } else {
                return Err(Failure::Vanished { direction: least.0 + 1, t: all.t });
            }
        }
        Ok(())
    }
}

/// The directions of one run.
pub(crate) struct Directions<'s> {
    columns: Vec<f64>,
    lengths: Vec<f64>,
    /// ln of what has been divided out.
    pub(crate) growth: Vec<f64>,
    scale: &'s [f64],
}

impl<'s> Directions<'s> {
    pub(crate) fn new(count: usize, scale: &'s [f64]) -> Self {
        Directions {
            columns: vec![0.0; count * scale.len()],
            lengths: vec![0.0; count],
            growth: vec![0.0; count],
            scale,
        }
    }

    /// Directions at random, orthonormal; the same for the same start.   Source: splitmix64 of Steele, Lea & Flood, OOPSLA 2014.
    pub(crate) fn draw(&mut self, start: &State, all: &mut State) {
        let numbers = start.q.iter().chain(&start.v).chain([&start.t]);
        let mut seed = numbers.fold(0_u64, |seed, x| mixed(seed.wrapping_add(x.to_bits())));
        let n = self.scale.len() / 2;
        let (of_q, of_v) = self.scale.split_at(n);
        for (half, scale) in [(&mut all.q, of_q), (&mut all.v, of_v)] {
            for (x, size) in half[n..].iter_mut().zip(scale.iter().cycle()) {
                seed = mixed(seed);
                *x = size * ((seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0);
            }
        }
        self.measure(all);
        self.accept(all);
        self.growth.fill(0.0);
    }

    /// Gram-Schmidt in units of size: the columns of R on the diagonal are the growth. The direction that is shortest, or not a number, and its
    /// length.
    fn measure(&mut self, all: &State) -> (usize, f64) {
        let (m, count) = (self.scale.len(), self.growth.len());
        let n = m / 2;
        let (of_q, of_v) = self.scale.split_at(n);
        let mut least = (0, f64::INFINITY);
        for k in 0..count {
            let (before, rest) = self.columns.split_at_mut(k * m);
            let column = &mut rest[..m];
            let (q, v) = (&all.q[n * (1 + k)..][..n], &all.v[n * (1 + k)..][..n]);
            for (x, (y, s)) in column.iter_mut().zip(q.iter().zip(of_q).chain(v.iter().zip(of_v))) {
                *x = y / s;
            }
            before.chunks_exact(m).for_each(|other| crate::roots::norms::remove(other, column));
            let length = dot(column, column).sqrt();
            self.lengths[k] = length;
            let length = if length.is_finite() { length } else { 0.0 };
            if length < least.1 {
                least = (k, length);
            }
            column.iter_mut().for_each(|x| *x /= length);
        }
        least
    }

    /// Goes on with what was measured.
    fn accept(&mut self, all: &mut State) {
        let m = self.scale.len();
        let n = m / 2;
        let (of_q, of_v) = self.scale.split_at(n);
        for (k, column) in self.columns.chunks_exact(m).enumerate() {
            self.growth[k] += self.lengths[k].ln();
            let (q, v) = (&mut all.q[n * (1 + k)..][..n], &mut all.v[n * (1 + k)..][..n]);
            for (x, (y, s)) in column.iter().zip(q.iter_mut().zip(of_q).chain(v.iter_mut().zip(of_v))) {
                *y = x * s;
            }
        }
    }
}

/// The next number of splitmix64.
fn mixed(seed: u64) -> u64 {
    let z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
