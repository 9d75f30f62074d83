//! A damped contact law that never pulls.

use crate::contact::deflection::Deflection;
use crate::contact::laws::nonlinearity::{Edges, Nonlinearity};
use crate::contact::piece::Piece;
use crate::error::{ParameterError, check};
use crate::excitation::{Angle, Side};
use crate::scalar::Scalar;

/// Damped dead zone f(d, d') = max(0, min(2 y, y + τ y')), with the depth y past an edge and its rate y'.
/// Source: Modelica Standard Library, `ElastoBacklash`.
///
/// It is a spring with the damping C = τ K. The total force never pulls, and the damping force is at most as
/// large as the spring force. The force is therefore continuous.
///
/// The law has three kinks on each flank:
/// - y = 0, where the teeth begin or cease to touch;
/// - y + τ y' = 0, where the force vanishes before the teeth separate;
/// - y = τ y', where the damping force reaches its limit.
///
/// The last two are [inner kinks](Nonlinearity::kinks): d + τ d' and d - τ d' are compared with the edges ∓b.
///
/// ```
/// use gear_dynamics::contact::{Edges, NoPullBacklash, Nonlinearity};
/// let law = NoPullBacklash::new(1.0, 0.5)?; // half backlash, τ [s]
/// let at_depth_one = |rate: f64| law.force(Edges::at_rest(-1.0, 1.0).at(2.0, rate));
/// assert_eq!([9.0, 1.0, 0.0, -1.0, -9.0].map(at_depth_one), [2.0, 1.5, 1.0, 0.5, 0.0]);
/// assert_eq!((law.at(-3.0), law.kinks(), law.kink(0, 2.0, -1.0)), (-2.0, 2, 1.5));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoPullBacklash {
    half_backlash: f64,
    time: f64,
}

impl NoPullBacklash {
    /// Half backlash b, not negative, and damping time τ = C/K `[s]`, positive. For τ = 0 use
    /// [`Backlash`](crate::Backlash).
    ///
    /// # Errors
    /// A half backlash that is negative or above 1e50; a τ that is not positive or is above 1e50.
    pub fn new(half_backlash: f64, time: f64) -> Result<Self, ParameterError> {
        let (half_backlash, time) =
            (check::not_negative("half backlash b", half_backlash)?, check::positive("damping time", time)?);
        Ok(NoPullBacklash { half_backlash, time })
    }
}

/// Index of the inner kink d + τ d': the force vanishes.
const ENDS: usize = 0;

/// Index of the inner kink d - τ d': the damping force reaches its limit.
const LIMITED: usize = 1;

impl Nonlinearity for NoPullBacklash {
    #[inline(always)]
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
        let flank = |y: S, viscous: S| (y * 2.0).min(y + viscous).max(S::from(0.0));
        let viscous = at.rate * self.time;
        flank(at.d - at.upper, viscous) - flank(at.lower - at.d, -viscous)
    }
    #[inline(always)]
    fn force_on<S: Scalar>(&self, flank: Piece, kinks: &[Piece], at: Deflection<S>) -> S {
        let depth = at.outside_on(flank);
        if flank == Piece::Gap || kinks[ENDS] != flank {
            S::from(0.0)
        } else if kinks[LIMITED] != flank {
            depth * 2.0
        } else {
            depth + at.rate * self.time
        }
    }
    fn kinks(&self) -> usize {
        2
    }
    #[inline(always)]
    fn kink<S: Scalar>(&self, k: usize, d: S, rate: S) -> S {
        if k == ENDS { d + rate * self.time } else { d - rate * self.time }
    }
    fn moves(&self) -> bool {
        false
    }
    fn edges<A: Angle>(&self, _: A, _: Side) -> Edges<A::Number> {
        Edges::at_rest(-self.half_backlash, self.half_backlash)
    }
}
