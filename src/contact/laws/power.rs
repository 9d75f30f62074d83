//! Contact laws whose force is a power of the depth.

use crate::contact::deflection::Deflection;
use crate::contact::laws::backlash::gap;
use crate::contact::laws::nonlinearity::{Edges, Nonlinearity};
use crate::contact::piece::Piece;
use crate::error::{ParameterError, check};
use crate::excitation::{Angle, Side};
use crate::scalar::Scalar;

/// f(d) = ±y0 (y/y0)^p, with the depth y of d past an edge, the exponent p >= 1 and a reference depth y0.
/// Source: Hertz (1882), p = 3/2 for points; Palmgren (1959), p = 10/9 for rollers.
///
/// At y = y0 the force is that of a linear flank of the same stiffness, W = K y0, and its slope is p times as
/// large. With y0 = 1 and a stiffness K `[N/m^p]` the force is W = K y^p.
///
/// On a fixed piece a flank continues past its edge as the odd function y |y|^(p-1) (for y0 = 1), which is
/// real and has the same slope on both sides of the edge. For p < 2 its second derivative is unbounded at
/// the edge, so that an adaptive solver takes short steps after the beginning of a contact.
///
/// ```
/// use gear_dynamics::contact::{Nonlinearity, PowerLaw};
/// let law = PowerLaw::new(1.0, 1.5, 4.0)?; // half backlash, exponent, reference depth
/// assert_eq!((law.at(0.5), law.at(5.0), law.at(-2.0)), (0.0, 4.0, -0.5));
/// assert_eq!((law.slope(1.0), law.slope(5.0)), (0.0, 1.5));
/// let wall = PowerLaw::new(0.0, 1.5, 1.0)?.with_edges(f64::NEG_INFINITY, 2.0)?; // a one-sided stop
/// assert_eq!((wall.at(-9.0), wall.at(6.0)), (0.0, 8.0));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    lower: f64,
    upper: f64,
    exponent: f64,
    depth: f64,
}

impl PowerLaw {
    /// Half backlash b, not negative, exponent p `[1]` in [1, 100], and reference depth y0,
    /// positive. Lengths are in the unit of the deflection.
    ///
    /// # Errors
    /// A half backlash that is negative or above 1e50; an exponent outside [1, 100]; a reference
    /// depth outside 1e-50 .. 1e50.
    pub fn new(half_backlash: f64, exponent: f64, depth: f64) -> Result<Self, ParameterError> {
        let b = check::not_negative("half backlash b", half_backlash)?;
        let exponent = check::quantity("exponent", exponent)?;
        if !(1.0..=100.0).contains(&exponent) {
            return Err(ParameterError::OutOfRange {
                name: "exponent".into(),
                value: exponent,
                allowed: "[1, 100]",
            });
        }
        Ok(PowerLaw { lower: -b, upper: b, exponent, depth: check::scale("reference depth", depth)? })
    }

    /// The same flanks with given edges, lower <= upper. One edge may be infinite; the law then has only the
    /// other flank.
    ///
    /// # Errors
    /// A finite edge beyond ±1e50, or no finite edge at all; a lower edge above the upper one.
    pub fn with_edges(self, lower: f64, upper: f64) -> Result<Self, ParameterError> {
        let [lower, upper] = gap(lower, upper)?;
        Ok(PowerLaw { lower, upper, ..self })
    }

    /// y0 |y/y0|^p with the sign of the depth y.
    #[inline(always)]
    fn of_depth<S: Scalar>(&self, y: S) -> S {
        let depth = S::from(self.depth);
        depth * (y / depth).signed_powf(self.exponent)
    }
}

impl Nonlinearity for PowerLaw {
    #[inline(always)]
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
        self.of_depth(at.outside())
    }
    #[inline(always)]
    fn force_on<S: Scalar>(&self, piece: Piece, _: &[Piece], at: Deflection<S>) -> S {
        match piece {
            Piece::Lower if self.lower.is_finite() => self.of_depth(at.d - at.lower),
            Piece::Upper if self.upper.is_finite() => self.of_depth(at.d - at.upper),
            _ => S::from(0.0),
        }
    }
    fn moves(&self) -> bool {
        false
    }
    fn edges<A: Angle>(&self, _: A, _: Side) -> Edges<A::Number> {
        Edges::at_rest(self.lower, self.upper)
    }
}
