//! Jumps of the accelerations that the model does not declare, and on which the motion stays.

use crate::model::Model;
use crate::model::structure::slopes::accelerate;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::stepping::engine::Engine;
use crate::ode::stepping::vector::Vector;

/// Number of rejected steps that are observed together.
const WINDOW: u32 = 128;

/// The second half of these steps is searched for jumps. With this number of jumps of one acceleration the
/// run ends.
const JUMPS: u32 = 32;

/// The steps are short if all of them together are shorter than this share of the longest attempt `[1]`.
const SHORT: f64 = 0.1;

/// A jump is searched over this number of steps ahead. Where the motion stays on a jump, it lies within one.
const AHEAD: f64 = 4.0;

/// Number of bisections: as many as a difference of two states has digits.
const BISECTIONS: usize = 60;

/// Share of a change that remains at a jump `[1]`. A sign has a third value, at 0, and keeps half of its
/// change.
const KEPT: f64 = 0.25;

/// Smallest jump, as a share of the largest acceleration `[1]`.
const LEAST: f64 = 1e-6;

/// Rejected steps of an adaptive run. At a jump of an acceleration, steps are rejected until one is so short
/// that the jump stays within the tolerance. A motion that passes the jump leaves it with longer steps; a
/// motion that stays on it needs such short steps for ever.
pub(crate) struct Undeclared {
    /// Longest attempt.
    longest: f64,
    /// Time of the first rejection in the window.
    since: f64,
    /// Number of rejections in the window.
    count: u32,
    /// Number of jumps found in the window.
    jumps: u32,
    /// The acceleration that jumps.
    acceleration: usize,
    /// Scratch: a state, and the accelerations at three states.
    look: Vec<f64>,
    a: [Vec<f64>; 3],
}

impl Undeclared {
    /// `components`: length of the state; `first`: length of the first attempt from `t`.
    pub(crate) fn new(components: usize, first: f64, t: f64) -> Self {
        let accelerations = || vec![0.0; components / 2];
        Undeclared {
            longest: first,
            since: t,
            count: 0,
            jumps: 0,
            acceleration: 0,
            look: vec![0.0; components],
            a: [accelerations(), accelerations(), accelerations()],
        }
    }

    /// The current step was rejected because of its error.
    ///
    /// # Errors
    /// [`IntegrateError::Discontinuity`] if many short steps in a row met a jump of the same acceleration.
    #[cold]
    pub(crate) fn rejected<M: Model + ?Sized, V: Vector>(
        &mut self,
        e: &Engine<'_, M, V>,
    ) -> Result<(), IntegrateError> {
        let (t, h) = (e.ends.t, e.ends.h());
        self.longest = self.longest.max(h);
        if self.count == 0 || self.count >= WINDOW || t - self.since > SHORT * self.longest {
            (self.since, self.count, self.jumps) = (t, 0, 0);
        }
        self.count += 1;
        if self.count <= WINDOW / 2 {
            return Ok(());
        }
        if let Some(acceleration) = self.jump(e) {
            self.jumps = if self.acceleration == acceleration { self.jumps + 1 } else { 1 };
            self.acceleration = acceleration;
        }
        if self.jumps < JUMPS {
            Ok(())
        } else {
            Err(IntegrateError::Discontinuity { t, acceleration: self.acceleration })
        }
    }

    /// The acceleration that changes most ahead of the start of the step, if it jumps there: bisection keeps
    /// the larger part of the change, and [`KEPT`] of it remains between states that rounding hardly
    /// separates.
    fn jump<M: Model + ?Sized, V: Vector>(&mut self, e: &Engine<'_, M, V>) -> Option<usize> {
        let Undeclared { look, a: [low, high, middle], .. } = self;
        let (y, rates) = (e.ends.y.slice(), e.k[0].slice());
        let pieces = e.on_fixed_pieces.then_some(&e.ends.pieces[..]);
        let mut at = |share: f64, a: &mut [f64]| {
            for (look, (y, rate)) in look.iter_mut().zip(y.iter().zip(rates)) {
                *look = y + share * AHEAD * e.ends.h() * rate;
            }
            let (q, v) = look.split_at(look.len() / 2);
            accelerate(e.ends.model, pieces, e.ends.nodes.end(), q, v, a);
        };
        at(0.0, low);
        at(1.0, high);
        let changes = low.iter().zip(high.iter()).map(|(a, b)| (b - a).abs());
        let (i, change) = changes.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let size = low.iter().chain(high.iter()).fold(0.0, |m: f64, a| m.max(a.abs()));
        if !(change > LEAST * size && size.is_finite()) {
            return None;
        }
        let (mut lo, mut hi, mut from, mut to) = (0.0, 1.0, low[i], high[i]);
        for _ in 0..BISECTIONS {
            let m = 0.5 * (lo + hi);
            at(m, middle);
            if (middle[i] - from).abs() > (to - middle[i]).abs() {
                (hi, to) = (m, middle[i]);
            } else {
                (lo, from) = (m, middle[i]);
            }
        }
        ((to - from).abs() > KEPT * change).then_some(i)
    }
}
