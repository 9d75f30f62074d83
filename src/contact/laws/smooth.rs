//! Laws without kinks.

use crate::contact::deflection::Deflection;
use crate::contact::laws::nonlinearity::{Edges, Nonlinearity};
use crate::error::{ParameterError, check};
use crate::excitation::{Angle, Side};
use crate::scalar::Scalar;

/// f(d) = d: a contact without a gap, which never separates.
///
/// ```
/// use gear_dynamics::contact::{Linear, Nonlinearity};
/// assert_eq!(Linear.at(-2.0), -2.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Linear;

impl Nonlinearity for Linear {
    #[inline(always)]
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
        at.d
    }
}

/// f(d) = s d + κ d³: a contact without a gap.
///
/// ```
/// use gear_dynamics::contact::{Cubic, Nonlinearity};
/// let law = Cubic::new(1.0, 2.0)?;
/// assert_eq!((law.at(0.5), law.slope(0.5)), (0.75, 2.5));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic {
    linear: f64,
    cubic: f64,
}

impl Cubic {
    /// Linear slope s and cubic coefficient κ, within ±1e50.
    ///
    /// # Errors
    /// A coefficient beyond ±1e50.
    pub fn new(linear: f64, cubic: f64) -> Result<Self, ParameterError> {
        Ok(Cubic {
            linear: check::quantity("linear slope", linear)?,
            cubic: check::quantity("cubic coefficient", cubic)?,
        })
    }
}

impl Nonlinearity for Cubic {
    #[inline(always)]
    fn force<S: Scalar>(&self, Deflection { d, .. }: Deflection<S>) -> S {
        d * self.linear + d * d * d * self.cubic
    }
}

/// Dead zone with rounded corners: f(d) = p(d - b) - p(-d - b) with p(y) = (y + √(y² + s²))/2, where b is
/// half the backlash and s the rounding length.
///
/// Rounding shifts the folds of a rattling mesh. No model therefore uses this law by default; it serves for
/// comparison with programs that have no exact dead zone. It reports the same edges ∓b as
/// [`Backlash`](crate::Backlash), so that rattle analysis works.
///
/// ```
/// use gear_dynamics::contact::{Nonlinearity, SmoothedBacklash};
/// let law = SmoothedBacklash::new(1.0, 0.1)?;
/// assert!((law.at(1.0) - 0.05).abs() < 2e-3); // s/2 at the corner, where the dead zone has 0
/// assert!((law.at(9.0) - 8.0).abs() < 1e-3);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothedBacklash {
    half_backlash: f64,
    rounding: f64,
}

impl SmoothedBacklash {
    /// Half backlash b, not negative, and rounding length s, positive, in the unit of the
    /// deflection.
    ///
    /// # Errors
    /// A half backlash that is negative or above 1e50; a rounding length outside 1e-50 .. 1e50, so that s² is
    /// representable.
    pub fn new(half_backlash: f64, rounding: f64) -> Result<Self, ParameterError> {
        Ok(SmoothedBacklash {
            half_backlash: check::not_negative("half backlash b", half_backlash)?,
            rounding: check::scale("rounding length", rounding)?,
        })
    }
}

impl Nonlinearity for SmoothedBacklash {
    #[inline(always)]
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
        let s2 = S::from(self.rounding * self.rounding);
        let p = |y: S| (y + (y * y + s2).sqrt()) * 0.5;
        p(at.d - at.upper) - p(at.lower - at.d)
    }
    fn moves(&self) -> bool {
        false
    }
    fn edges<A: Angle>(&self, _: A, _: Side) -> Edges<A::Number> {
        Edges::at_rest(-self.half_backlash, self.half_backlash)
    }
}
