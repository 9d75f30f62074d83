//! Contact laws: backlash dead zones and their smooth relatives.

mod backlash;
mod smooth;

pub use backlash::{AsymmetricBacklash, Backlash, VaryingBacklash};
pub use smooth::{Cubic, Linear, SmoothedBacklash};

use crate::dual::Dual;
use crate::piece::{Piece, Side};
use crate::scalar::Scalar;

/// The edges of a gap and how fast they move.
///
/// ```
/// use gear_dynamics::Edges;
/// assert_eq!(Edges::symmetric(2e-5, 0.0).lower, -2e-5);
/// assert!(Edges::NONE.upper.is_infinite());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edges {
    /// Lower edge.
    pub lower: f64,
    /// Upper edge.
    pub upper: f64,
    /// Rate of the lower edge.
    pub lower_rate: f64,
    /// Rate of the upper edge.
    pub upper_rate: f64,
}

impl Edges {
    /// A law without pieces.
    pub const NONE: Edges = Edges { lower: f64::NEG_INFINITY, upper: f64::INFINITY, lower_rate: 0.0, upper_rate: 0.0 };

    /// ∓b with rates ∓b'.
    pub fn symmetric(half_width: f64, rate: f64) -> Self {
        Edges { lower: -half_width, upper: half_width, lower_rate: -rate, upper_rate: rate }
    }
}

/// A contact law: force per unit stiffness over the deflection, with the edges of its pieces.
///
/// Only [`force`](Nonlinearity::force) is needed; a law with kinks also says where its [`edges`](Nonlinearity::edges) are and how each
/// piece continues past them, and gains located edges from every solver. Two laws are equal if they are the very same: models with equal
/// laws may share lanes.
///
/// ```
/// use gear_dynamics::{Nonlinearity, Scalar};
/// #[derive(PartialEq)]
/// struct Hertz; // force ~ x^1.5 on one flank
/// impl Nonlinearity for Hertz {
///     fn force<S: Scalar>(&self, x: S, _rate: S, _lower: S, _upper: S) -> S {
///         let p = x.max(S::from(0.0));
///         p * p.sqrt()
///     }
/// }
/// assert_eq!(Hertz.at(4.0), 8.0);
/// ```
pub trait Nonlinearity: PartialEq {
    /// Whether its edges are ∓ a half width, which a model may hold as a constant of its own, and f(c x; ∓c b) = c f(x; ∓b) for c > 0. Default:
    /// no.
    const HALF_WIDTH: bool = false;

    /// f(x, x') between the edges `lower` and `upper`, which may move. Mark it `#[inline(always)]`: it runs inside lanes.
    fn force<S: Scalar>(&self, x: S, rate: S, lower: S, upper: S) -> S;

    /// One piece of the law, smoothly continued past its edges. By default the law is a single piece.
    #[inline(always)]
    fn force_on<S: Scalar>(&self, piece: Piece, x: S, rate: S, lower: S, upper: S) -> S {
        let _ = piece;
        self.force(x, rate, lower, upper)
    }

    /// Where the pieces meet at an angle of the shaft, the rates over that angle.
    fn edges(&self, angle: f64, side: Side) -> Edges {
        let _ = (angle, side);
        Edges::NONE
    }
    /// The next angle at which an edge of the gap itself jumps.
    fn next_edge(&self, angle: f64) -> Option<f64> {
        let _ = angle;
        None
    }

    /// f(x) at rest at the angle 0.
    fn at(&self, x: f64) -> f64 {
        let e = self.edges(0.0, Side::After);
        self.force(x, 0.0, e.lower, e.upper)
    }
    /// df/dx at rest at the angle 0, exact by dual numbers; at an edge the slope of the gap.
    fn slope(&self, x: f64) -> f64 {
        let e = self.edges(0.0, Side::After);
        self.force(Dual::variable(x), 0.0.into(), e.lower.into(), e.upper.into()).slope[0]
    }
}

/// Any of the built-in laws, or one's own as `Other`: for a model whose meshes differ.
///
/// ```
/// use gear_dynamics::{AnyLaw, Backlash, Cubic, Nonlinearity};
/// let laws: [AnyLaw; 2] = [AnyLaw::Backlash(Backlash::new(1.0)?), AnyLaw::Cubic(Cubic::new(1.0, 0.5)?)];
/// assert_eq!(laws.map(|law| law.at(2.0)), [1.0, 6.0]);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum AnyLaw<N = Linear> {
    /// f(x) = x.
    Linear(Linear),
    /// Cubic.
    Cubic(Cubic),
    /// Symmetric dead zone.
    Backlash(Backlash),
    /// Asymmetric dead zone.
    Asymmetric(AsymmetricBacklash),
    /// Dead zone whose half width moves.
    Varying(VaryingBacklash),
    /// Rounded dead zone.
    Smoothed(SmoothedBacklash),
    /// A law of one's own.
    Other(N),
}

/// Runs an expression on whichever law it is.
macro_rules! each_law {
    ($self:ident, $law:ident => $body:expr) => {
        match $self {
            AnyLaw::Linear($law) => $body,
            AnyLaw::Cubic($law) => $body,
            AnyLaw::Backlash($law) => $body,
            AnyLaw::Asymmetric($law) => $body,
            AnyLaw::Varying($law) => $body,
            AnyLaw::Smoothed($law) => $body,
            AnyLaw::Other($law) => $body,
        }
    };
}

impl<N: Nonlinearity> Nonlinearity for AnyLaw<N> {
    #[inline(always)]
    fn force<S: Scalar>(&self, x: S, rate: S, lower: S, upper: S) -> S {
        each_law!(self, law => law.force(x, rate, lower, upper))
    }
    #[inline(always)]
    fn force_on<S: Scalar>(&self, piece: Piece, x: S, rate: S, lower: S, upper: S) -> S {
        each_law!(self, law => law.force_on(piece, x, rate, lower, upper))
    }
    fn edges(&self, angle: f64, side: Side) -> Edges {
        each_law!(self, law => law.edges(angle, side))
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        each_law!(self, law => law.next_edge(angle))
    }
}
