//! The trait of all contact laws.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::dual::Dual;
use crate::excitation::side::Side;
use crate::scalar::Scalar;

/// The edges of a gap and how fast they move.
///
/// ```
/// use gear_dynamics::contact::Edges;
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
    pub const NONE: Edges =
        Edges { lower: f64::NEG_INFINITY, upper: f64::INFINITY, lower_rate: 0.0, upper_rate: 0.0 };

    /// ∓b with rates ∓b'.
    pub fn symmetric(half_width: f64, rate: f64) -> Self {
        Edges { lower: -half_width, upper: half_width, lower_rate: -rate, upper_rate: rate }
    }
}

/// A contact law: force per unit stiffness over the deflection, with the edges of its pieces.
///
/// Only [`force`](Nonlinearity::force) is needed; a law with kinks also says where its [`edges`](Nonlinearity::edges) are and how each
/// piece continues past them, and gains located edges from every solver. Models with equal laws may share lanes: derive `PartialEq`.
///
/// ```
/// use gear_dynamics::{contact::{Edges, Nonlinearity, Piece}, model::Scalar, excitation::Side};
/// #[derive(PartialEq)]
/// struct Hertz { gap: f64 } // force ~ y^1.5 past one edge, y = x - gap
/// impl Nonlinearity for Hertz {
///     #[inline(always)]
///     fn force<S: Scalar>(&self, x: S, _rate: S, _lower: S, upper: S) -> S {
///         (x - upper).max(S::from(0.0)).powf(1.5)
///     }
///     #[inline(always)]
///     fn force_on<S: Scalar>(&self, piece: Piece, x: S, _rate: S, _lower: S, upper: S) -> S {
///         let y = x - upper;
///         // A piece goes on smoothly past its edge: y √|y|, where y^1.5 would be no number.
///         if piece == Piece::Upper { y * y.abs().sqrt() } else { S::from(0.0) }
///     }
///     fn edges(&self, _angle: f64, _side: Side) -> Edges {
///         Edges { upper: self.gap, ..Edges::NONE }
///     }
/// }
/// assert_eq!(Hertz { gap: 1.0 }.at(5.0), 8.0);
/// ```
///
/// A law whose pieces also depend on the rate has more than one [switch](Nonlinearity::switches), each a contact of the model to the solvers; see
/// [`NoPullBacklash`](crate::contact::NoPullBacklash).
pub trait Nonlinearity: PartialEq {
    /// Whether its edges are ∓ a half width, which a model may hold as a constant of its own, and it is the same in any unit: f(c x; ∓c b) = c f(x; ∓b) for
    /// c > 0, whatever the rate. Default: no.
    const HALF_WIDTH: bool = false;

    /// f(x, x') between the edges `lower` and `upper`, which may move. Mark it `#[inline(always)]`: it runs inside lanes.
    fn force<S: Scalar>(&self, x: S, rate: S, lower: S, upper: S) -> S;

    /// One piece of the law, smoothly continued past its edges. By default the law is a single piece.
    #[inline(always)]
    fn force_on<S: Scalar>(&self, piece: Piece, x: S, rate: S, lower: S, upper: S) -> S {
        let _ = piece;
        self.force(x, rate, lower, upper)
    }

    /// How many switches say on which piece the law stands. One, unless said: the deflection.
    fn switches(&self) -> usize {
        1
    }
    /// What a switch holds against the [`edges`](Nonlinearity::edges), in the unit of the deflection: x for the first, a smooth function of
    /// x and x' for others.
    #[inline(always)]
    fn switch<S: Scalar>(&self, switch: usize, x: S, rate: S) -> S {
        let _ = (switch, rate);
        x
    }
    /// The rate of a switch from x, x' and x''. By default that of an affine function of x and x'.
    #[inline(always)]
    fn switch_rate<S: Scalar>(&self, switch: usize, x: S, rate: S, second: S) -> S {
        let (_, zero) = (x, S::from(0.0));
        self.switch(switch, rate, second) - self.switch(switch, zero, zero)
    }
    /// The contact of a switch from that of the mesh and x''. A model has as many contacts for a mesh as the law of the mesh has switches.
    #[inline(always)]
    fn switch_contact<S: Scalar>(&self, switch: usize, mesh: Contact<S>, second: S) -> Contact<S> {
        let (x, rate) = (mesh.deflection, mesh.rate);
        Contact {
            deflection: self.switch(switch, x, rate),
            rate: self.switch_rate(switch, x, rate, second),
            ..mesh
        }
    }
    /// The smooth law where every switch stands on a given piece: what [`force_on`](Nonlinearity::force_on) is for a single one.
    #[inline(always)]
    fn force_on_all<S: Scalar>(&self, pieces: &[Piece], x: S, rate: S, lower: S, upper: S) -> S {
        self.force_on(pieces[0], x, rate, lower, upper)
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
    /// Whether the edges depend on the angle. Default: they do, unless there are none.
    fn moves(&self) -> bool {
        self.edges(0.0, Side::After) != Edges::NONE
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
