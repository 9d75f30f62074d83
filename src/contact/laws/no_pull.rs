//! A damped contact law that never pulls.

use crate::contact::laws::nonlinearity::{Edges, Nonlinearity};
use crate::contact::piece::Piece;
use crate::error::{ParameterError, check};
use crate::excitation::side::Side;
use crate::excitation::wave::Angle;
use crate::scalar::Scalar;

/// Damped dead zone f(x, x') = max(0, min(2 y, y + τ y')), with the depth y past an edge and its rate y'.
/// Source: Modelica Standard Library, `ElastoBacklash`.
///
/// It is a spring with the damping C = τ K. The total force never pulls, and the damping force is at most as
/// large as the spring force. The force is therefore continuous.
///
/// The law has three kinks on each flank and one switching function for each:
/// - y = 0, where the teeth begin or cease to touch: x;
/// - y + τ y' = 0, where the force vanishes before the teeth separate: x + τ x';
/// - y = τ y', where the damping force reaches its limit: x - τ x'.
///
/// All three are compared with the same edges ∓b. [`force_on`](Nonlinearity::force_on) knows the piece of the
/// first one alone: the other two kinks then lie inside a piece, and solvers do not locate them.
///
/// ```
/// use gear_dynamics::contact::{NoPullBacklash, Nonlinearity};
/// let law = NoPullBacklash::new(1.0, 0.5)?; // half width, τ [s]
/// let at_depth_one = |rate: f64| law.force(2.0, rate, -1.0, 1.0);
/// assert_eq!([9.0, 1.0, 0.0, -1.0, -9.0].map(at_depth_one), [2.0, 1.5, 1.0, 0.5, 0.0]);
/// assert_eq!((law.at(-3.0), law.switches(), law.switch(1, 2.0, -1.0)), (-2.0, 3, 1.5));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoPullBacklash {
    half_width: f64,
    time: f64,
}

impl NoPullBacklash {
    /// Half width b, half the backlash, not negative, and damping time τ = C/K `[s]`, positive. For τ = 0 use
    /// [`Backlash`](crate::Backlash).
    ///
    /// # Errors
    /// A half width that is negative or above 1e50; a τ that is not positive or is above 1e50.
    pub fn new(half_width: f64, time: f64) -> Result<Self, ParameterError> {
        let (half_width, time) =
            (check::not_negative("half width b", half_width)?, check::positive("damping time", time)?);
        Ok(NoPullBacklash { half_width, time })
    }
}

/// Index of the switching function x: the teeth touch.
const TOUCH: usize = 0;

/// Index of the switching function x + τ x': the force vanishes.
const ENDS: usize = 1;

/// Index of the switching function x - τ x': the damping force reaches its limit.
const LIMITED: usize = 2;

impl Nonlinearity for NoPullBacklash {
    #[inline(always)]
    fn force<S: Scalar>(&self, x: S, rate: S, lower: S, upper: S) -> S {
        let flank = |y: S, viscous: S| (y * 2.0).min(y + viscous).max(S::from(0.0));
        let viscous = rate * self.time;
        flank(x - upper, viscous) - flank(lower - x, -viscous)
    }
    #[inline(always)]
    fn force_on<S: Scalar>(&self, piece: Piece, x: S, rate: S, lower: S, upper: S) -> S {
        let (zero, viscous) = (S::from(0.0), rate * self.time);
        match piece {
            Piece::Lower => ((x - lower) * 2.0).max((x - lower + viscous).min(zero)),
            Piece::Gap => zero,
            Piece::Upper => ((x - upper) * 2.0).min((x - upper + viscous).max(zero)),
        }
    }
    #[inline(always)]
    fn force_on_all<S: Scalar>(&self, pieces: &[Piece], x: S, rate: S, lower: S, upper: S) -> S {
        let flank = pieces[TOUCH];
        let depth = match flank {
            Piece::Lower => x - lower,
            Piece::Upper => x - upper,
            Piece::Gap => return S::from(0.0),
        };
        if pieces[ENDS] != flank {
            S::from(0.0)
        } else if pieces[LIMITED] != flank {
            depth * 2.0
        } else {
            depth + rate * self.time
        }
    }
    fn switches(&self) -> usize {
        3
    }
    #[inline(always)]
    fn switch<S: Scalar>(&self, switch: usize, x: S, rate: S) -> S {
        match switch {
            ENDS => x + rate * self.time,
            LIMITED => x - rate * self.time,
            _ => x,
        }
    }
    fn moves(&self) -> bool {
        false
    }
    fn edges<A: Angle>(&self, _: A, _: Side) -> Edges<A::Number> {
        Edges::at_rest(-self.half_width, self.half_width)
    }
}
