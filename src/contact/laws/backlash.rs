//! Dead zones: contact laws of a backlash.

use crate::contact::deflection::Deflection;
use crate::contact::laws::nonlinearity::{Edges, LanesOf, Nonlinearity};
use crate::contact::piece::Piece;
use crate::error::{ParameterError, check};
use crate::excitation::{Angle, Side, Wave};
use crate::scalar::Scalar;

/// Checks the edges of a gap. The lower edge may be -∞ or the upper edge ∞, if the other one is finite.
pub(crate) fn gap(lower: f64, upper: f64) -> Result<[f64; 2], ParameterError> {
    check::quantity("lower edge", if lower == f64::NEG_INFINITY && upper.is_finite() { 0.0 } else { lower })?;
    check::quantity("upper edge", if upper == f64::INFINITY { 0.0 } else { upper })?;
    if lower > upper {
        let (name, value) = ("gap between lower and upper edge".into(), upper - lower);
        return Err(ParameterError::Negative { name, value });
    }
    Ok([lower, upper])
}

/// Dead zone f(d) = max(d - b, 0) - max(-d - b, 0).
///
/// b is half of the backlash.   Source: Liu 2021, Eq. (12); Yao 2020, Eq. (1).
///
/// ```
/// use gear_dynamics::{Backlash, contact::Nonlinearity};
/// let law = Backlash::new(2.65e-5)?; // half the backlash [m]
/// assert_eq!(law.at(1e-5), 0.0);
/// assert!((law.at(-4e-5) + 1.35e-5).abs() < 1e-20);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Backlash {
    half_backlash: f64,
}

impl Backlash {
    /// Half backlash b, not negative, in the unit of the deflection.
    ///
    /// # Errors
    /// A half backlash that is negative or above 1e50.
    pub fn new(half_backlash: f64) -> Result<Self, ParameterError> {
        Ok(Backlash { half_backlash: check::not_negative("half backlash b", half_backlash)? })
    }

    /// No backlash: b = 0.
    pub(crate) fn none() -> Self {
        Backlash { half_backlash: 0.0 }
    }
    /// Half backlash b: half of the play 2b.
    pub fn half_backlash(&self) -> f64 {
        self.half_backlash
    }
}

impl Nonlinearity for Backlash {
    const HALF_BACKLASH: bool = true;
    const LANES: LanesOf = LanesOf::LIBRARY;

    #[inline(always)]
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
        at.outside()
    }
    #[inline(always)]
    fn force_on<S: Scalar>(&self, piece: Piece, _: &[Piece], at: Deflection<S>) -> S {
        at.outside_on(piece)
    }
    fn moves(&self) -> bool {
        false
    }
    fn edges<A: Angle>(&self, _: A, _: Side) -> Edges<A::Number> {
        Edges::at_rest(-self.half_backlash, self.half_backlash)
    }
}

/// Dead zone with edges at `lower` and `upper` and flanks of relative stiffness s_l and s_u `[1]`:
/// f(d) = s_u max(d - upper, 0) - s_l max(lower - d, 0).
///
/// ```
/// use gear_dynamics::contact::{AsymmetricBacklash, Nonlinearity};
/// let law = AsymmetricBacklash::new(-1.0, 2.0)?.with_slopes(0.5, 1.0)?;
/// assert_eq!((law.at(-3.0), law.at(0.0), law.at(3.0)), (-1.0, 0.0, 1.0));
/// let stop = AsymmetricBacklash::stop_above(2.0)?;
/// assert_eq!((stop.at(-1e9), stop.at(3.0)), (0.0, 1.0));
/// assert_eq!(AsymmetricBacklash::stop_below(2.0)?.at(-1.0), -3.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AsymmetricBacklash {
    lower: f64,
    upper: f64,
    slopes: [f64; 2],
}

impl AsymmetricBacklash {
    /// Edges with lower <= upper, in the unit of the deflection. One edge may be infinite; the law then has
    /// only the other flank. Default: both flanks have the relative stiffness 1.
    ///
    /// # Errors
    /// A finite edge beyond ±1e50, or no finite edge at all; a lower edge above the upper one.
    pub fn new(lower: f64, upper: f64) -> Result<Self, ParameterError> {
        let [lower, upper] = gap(lower, upper)?;
        Ok(AsymmetricBacklash { lower, upper, slopes: [1.0; 2] })
    }

    /// A one-sided stop that touches for d > `edge`: f(d) = max(d - edge, 0).
    ///
    /// # Errors
    /// An edge that is not finite or lies beyond ±1e50.
    pub fn stop_above(edge: f64) -> Result<Self, ParameterError> {
        Self::new(f64::NEG_INFINITY, check::quantity("upper edge", edge)?)
    }

    /// A one-sided stop that touches for d < `edge`: f(d) = -max(edge - d, 0).
    ///
    /// # Errors
    /// An edge that is not finite or lies beyond ±1e50.
    pub fn stop_below(edge: f64) -> Result<Self, ParameterError> {
        Self::new(check::quantity("lower edge", edge)?, f64::INFINITY)
    }

    /// Whether the law does not have this flank: its edge is infinite.
    #[inline(always)]
    fn is_missing(&self, piece: Piece) -> bool {
        match piece {
            Piece::Lower => self.lower == f64::NEG_INFINITY,
            Piece::Gap => false,
            Piece::Upper => self.upper == f64::INFINITY,
        }
    }

    /// The same law with the relative stiffnesses `[1]` of the lower and the upper flank, both positive.
    /// Default: 1.
    ///
    /// # Errors
    /// A slope that is not positive or is above 1e50.
    pub fn with_slopes(self, lower: f64, upper: f64) -> Result<Self, ParameterError> {
        let slopes = [
            check::positive("slope of the lower flank", lower)?,
            check::positive("slope of the upper flank", upper)?,
        ];
        Ok(AsymmetricBacklash { slopes, ..self })
    }
}

impl Nonlinearity for AsymmetricBacklash {
    #[inline(always)]
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
        let zero = S::from(0.0);
        (at.d - at.upper).max(zero) * self.slopes[1] - (at.lower - at.d).max(zero) * self.slopes[0]
    }
    #[inline(always)]
    fn force_on<S: Scalar>(&self, piece: Piece, _: &[Piece], at: Deflection<S>) -> S {
        if self.is_missing(piece) {
            return S::from(0.0);
        }
        let unit = at.outside_on(piece);
        match piece {
            Piece::Lower => unit * self.slopes[0],
            Piece::Gap => unit,
            Piece::Upper => unit * self.slopes[1],
        }
    }
    fn moves(&self) -> bool {
        false
    }
    fn edges<A: Angle>(&self, _: A, _: Side) -> Edges<A::Number> {
        Edges::at_rest(self.lower, self.upper)
    }
}

/// Dead zone whose half backlash b(φ) varies with an angle: its edges are ∓b(φ).
///
/// ```
/// use gear_dynamics::{excitation::{Fourier, Side}, contact::{Nonlinearity, VaryingBacklash}, Wave};
/// let law = VaryingBacklash::new(Wave::new(Fourier::new(1.0, &[[0.25, 0.0]])?));
/// assert_eq!(law.edges(0.0, Side::After).upper, 1.25);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct VaryingBacklash {
    half_backlash: Wave,
}

impl VaryingBacklash {
    /// Half backlash b(φ) as a wave. It must not become negative: solvers that locate edges
    /// then return [`IntegrateError::NegativeGap`](crate::ode::IntegrateError::NegativeGap), and sweeps in
    /// steps of equal length [`PointError::NegativeGap`](crate::sweep::PointError::NegativeGap).
    pub fn new(half_backlash: Wave) -> Self {
        VaryingBacklash { half_backlash }
    }
}

impl Nonlinearity for VaryingBacklash {
    #[inline(always)]
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
        at.outside()
    }
    #[inline(always)]
    fn force_on<S: Scalar>(&self, piece: Piece, _: &[Piece], at: Deflection<S>) -> S {
        at.outside_on(piece)
    }
    fn edges<A: Angle>(&self, angle: A, side: Side) -> Edges<A::Number> {
        let b = self.half_backlash.jet(angle, side);
        Edges::symmetric(b.value, b.rate)
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        self.half_backlash.next_edge(angle)
    }
    fn next_knot(&self, angle: f64) -> Option<f64> {
        self.half_backlash.next_knot(angle)
    }
}
