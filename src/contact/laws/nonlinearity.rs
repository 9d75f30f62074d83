//! The trait of all contact laws.

use crate::contact::deflection::Deflection;
use crate::contact::piece::Piece;
use crate::dual::Dual;
use crate::excitation::{Angle, Side};
use crate::scalar::Scalar;

/// The edges of a gap, in the unit of the deflection, and their rates.
///
/// ```
/// use gear_dynamics::contact::{Nonlinearity, VaryingBacklash};
/// use gear_dynamics::{excitation::{Fourier, Side}, Wave};
/// let law = VaryingBacklash::new(Wave::new(Fourier::new(1.0, &[[0.0, 0.25]])?)); // b = 1 + 0.25 sin φ
/// let edges = law.edges(0.0, Side::After);
/// assert_eq!((edges.lower, edges.upper), (-1.0, 1.0));
/// assert_eq!((edges.lower_rate, edges.upper_rate), (-0.25, 0.25)); // over φ
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edges<S = f64> {
    /// Lower edge.
    pub lower: S,
    /// Upper edge.
    pub upper: S,
    /// Rate of the lower edge.
    pub lower_rate: S,
    /// Rate of the upper edge.
    pub upper_rate: S,
}

impl<S: Scalar> Edges<S> {
    /// No edges: the law is a single piece.
    pub fn none() -> Self {
        Edges::at_rest(f64::NEG_INFINITY, f64::INFINITY)
    }
    /// Edges that do not move.
    pub fn at_rest(lower: f64, upper: f64) -> Self {
        let zero = S::from(0.0);
        Edges { lower: lower.into(), upper: upper.into(), lower_rate: zero, upper_rate: zero }
    }
    /// Edges ∓b with the rates ∓b'; b is half the backlash.
    pub fn symmetric(half_backlash: S, rate: S) -> Self {
        Edges { lower: -half_backlash, upper: half_backlash, lower_rate: -rate, upper_rate: rate }
    }
    /// The deflection d with the rate d' between these edges.
    #[inline(always)]
    pub fn at(&self, d: S, rate: S) -> Deflection<S> {
        Deflection { d, rate, lower: self.lower, upper: self.upper }
    }
}

/// Where steps in lanes are compiled. Only this crate can name the type, so that no other one claims that its
/// code is here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LanesOf {
    pub(crate) is_library: bool,
}

impl LanesOf {
    pub(crate) const USER: LanesOf = LanesOf { is_library: false };
    pub(crate) const LIBRARY: LanesOf = LanesOf { is_library: true };
}

/// A contact law: the force per unit stiffness as a function of the deflection, with the edges of its pieces.
///
/// Only [`force`](Nonlinearity::force) is required. A law with kinks also implements
/// [`edges`](Nonlinearity::edges) and [`force_on`](Nonlinearity::force_on), which continues each piece past
/// its edges; solvers then locate the edges. Models share lanes only if their laws are equal: derive
/// `PartialEq`.
///
/// ```
/// use gear_dynamics::contact::{Deflection, Edges, Nonlinearity, Piece};
/// use gear_dynamics::{excitation::{Angle, Side}, model::Scalar};
/// #[derive(PartialEq)]
/// struct Hertz { gap: f64 } // force ~ y^1.5 past one edge, y = d - gap
/// impl Nonlinearity for Hertz {
///     #[inline(always)]
///     fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
///         (at.d - at.upper).max(S::from(0.0)).powf(1.5)
///     }
///     #[inline(always)]
///     fn force_on<S: Scalar>(&self, piece: Piece, _: &[Piece], at: Deflection<S>) -> S {
///         let y = at.d - at.upper;
///         // Continued past the edge with the sign of y, because y^1.5 is not a number for y < 0.
///         if piece == Piece::Upper { y.signed_powf(1.5) } else { S::from(0.0) }
///     }
///     fn edges<A: Angle>(&self, _angle: A, _side: Side) -> Edges<A::Number> {
///         Edges::at_rest(f64::NEG_INFINITY, self.gap)
///     }
/// }
/// assert_eq!(Hertz { gap: 1.0 }.at(5.0), 8.0);
/// ```
///
/// A law may have [inner kinks](Nonlinearity::kinks), which depend on the rate. Example:
/// [`NoPullBacklash`](crate::contact::NoPullBacklash).
pub trait Nonlinearity: PartialEq + Send + Sync + 'static {
    /// Whether the edges are ∓b with a half backlash b that a model may keep among its own constants, and the
    /// law is independent of the unit: f(c d; ∓c b) = c f(d; ∓b) for every c > 0 at every rate. Default:
    /// `false`.
    const HALF_BACKLASH: bool = false;
    /// Whether the library contains the steps in lanes of trains with this law.
    #[doc(hidden)]
    const LANES: LanesOf = LanesOf::USER;

    /// Returns f(d, d') between edges that may move. Mark the implementation `#[inline(always)]`, because it
    /// runs in lanes.
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S;

    /// Returns the force on one piece of the law, continued smoothly past its edges. The continuation stays
    /// moderate across the gap: linearisations and sizes of rounding are taken there. `kinks`: the piece of
    /// each inner kink. Default: [`force`](Nonlinearity::force), for a law of a single piece.
    #[inline(always)]
    fn force_on<S: Scalar>(&self, piece: Piece, kinks: &[Piece], at: Deflection<S>) -> S {
        let _ = (piece, kinks);
        self.force(at)
    }

    /// Number of inner kinks: functions of d and d' that are compared with the edges of the law, besides d.
    /// Each one is a contact of the model, so that solvers locate it. Default: 0.
    #[inline(always)]
    fn kinks(&self) -> usize {
        0
    }
    /// Returns the value of inner kink `k`, a smooth function of d and d' in the unit of d. Default: d.
    #[inline(always)]
    fn kink<S: Scalar>(&self, k: usize, d: S, rate: S) -> S {
        let _ = (k, rate);
        d
    }

    /// Returns the edges at an angle, with their rates over that angle. In a [`Mesh`](crate::Mesh) it is the
    /// mesh angle. `side`: before or after a jump at this angle. Default: no edges.
    fn edges<A: Angle>(&self, angle: A, side: Side) -> Edges<A::Number> {
        let _ = (angle, side);
        Edges::none()
    }
    /// Returns the next angle at which an edge of the gap jumps or its rate jumps. Default: `None`.
    fn next_edge(&self, angle: f64) -> Option<f64> {
        let _ = angle;
        None
    }
    /// Returns the next angle at which an edge of the gap has a [knot](crate::Wave::next_knot). Default:
    /// `None`.
    fn next_knot(&self, angle: f64) -> Option<f64> {
        let _ = angle;
        None
    }
    /// Whether the edges depend on the angle. Default: `true` if there are edges at the angle 0.
    fn moves(&self) -> bool {
        self.edges(0.0, Side::After) != Edges::none()
    }

    /// Returns f(d) for the rate 0 at the angle 0.
    fn at(&self, d: f64) -> f64 {
        self.force(self.edges(0.0, Side::After).at(d, 0.0))
    }
    /// Returns df/dx for the rate 0 at the angle 0, exact by dual numbers. At an edge it is the slope of one
    /// of the two pieces, depending on the law: of the flank for [`Backlash`](crate::Backlash), of the gap
    /// for [`AsymmetricBacklash`](crate::contact::AsymmetricBacklash).
    fn slope(&self, d: f64) -> f64 {
        let Edges { lower, upper, .. } = self.edges(0.0, Side::After);
        let (d, rate) = (Dual::variable(d), 0.0.into());
        self.force(Deflection { d, rate, lower: lower.into(), upper: upper.into() }).slope[0]
    }
}
