//! Contact laws with damping.

use crate::contact::deflection::Deflection;
use crate::contact::laws::nonlinearity::{Edges, Nonlinearity};
use crate::contact::piece::Piece;
use crate::error::{ParameterError, check};
use crate::excitation::{Angle, Side};
use crate::scalar::Scalar;

/// A law g with damping. The mesh force is K(φ) f, so that the damping is proportional to the mesh stiffness:
///
/// - [`by_stiffness`](Damped::by_stiffness): f = g + τ d' in contact. The damping coefficient is C = τ K(φ).
///   Source: Kelvin-Voigt.
/// - [`by_force`](Damped::by_force): f = g + λ |g| d'. The damping coefficient C = λ K |g| grows with the
///   depth.   Source: Hunt & Crossley (1975), λ = 3/2 α.
///
/// With `by_stiffness` the force jumps by τ d' at an edge and pulls while the flanks separate. With
/// `by_force` the force is continuous. It pulls only if the flanks separate faster than 1/λ, which does not
/// occur after a free impact. A mesh with such a law needs no damping C; if it has one, both act.
///
/// ```
/// use gear_dynamics::{Backlash, contact::{Damped, Edges, Nonlinearity, PowerLaw}};
/// let at = |d, rate| Edges::at_rest(-1.0, 1.0).at(d, rate);
/// let viscous = Damped::by_stiffness(Backlash::new(1.0)?, 0.5)?; // τ [s]
/// assert_eq!(viscous.force(at(3.0, 1.0)), 2.5);
/// assert_eq!(viscous.force(at(0.0, 1.0)), 0.0);
/// let ball = Damped::by_force(PowerLaw::new(1.0, 1.5, 1.0)?, 0.25)?; // λ [s/m]
/// assert_eq!(ball.force(at(5.0, 2.0)), 12.0); // 8 (1 + 0.5)
/// assert_eq!(ball.force(at(-5.0, 2.0)), -4.0); // the flanks separate: -8 (1 - 0.5)
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damped<N> {
    law: N,
    loss: Loss,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Loss {
    /// Damping time τ, and whether it also acts in the gap.
    Time(f64, bool),
    /// Loss factor λ.
    Force(f64),
}

impl<N: Nonlinearity> Damped<N> {
    /// f = g + τ d' in contact, with the damping time τ = C/K `[s]`, not negative. A law without edges is
    /// always in contact.
    ///
    /// # Errors
    /// A τ that is negative or above 1e50.
    pub fn by_stiffness(law: N, time: f64) -> Result<Self, ParameterError> {
        let edges = law.edges(0.0, Side::After);
        let everywhere = edges.lower == f64::NEG_INFINITY && edges.upper == f64::INFINITY;
        Ok(Damped { law, loss: Loss::Time(check::not_negative("damping time", time)?, everywhere) })
    }

    /// f = g + τ d' in contact and in the gap, with the damping time τ `[s]`, not negative. It represents an
    /// oil film whose damping is proportional to the mesh stiffness.
    ///
    /// # Errors
    /// A τ that is negative or above 1e50.
    pub fn by_stiffness_always(law: N, time: f64) -> Result<Self, ParameterError> {
        Ok(Damped { law, loss: Loss::Time(check::not_negative("damping time", time)?, true) })
    }

    /// f = g + λ |g| d', with the loss factor λ [s/m], not negative. It is intended for laws with a gap. If g
    /// changes its sign outside a gap, |g| has a kink there that solvers do not locate.
    ///
    /// # Errors
    /// A λ that is negative or above 1e50.
    pub fn by_force(law: N, loss: f64) -> Result<Self, ParameterError> {
        Ok(Damped { law, loss: Loss::Force(check::not_negative("loss factor", loss)?) })
    }

    /// The law g without damping.
    pub fn law(&self) -> &N {
        &self.law
    }
}

impl<N: Nonlinearity> Nonlinearity for Damped<N> {
    #[inline(always)]
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
        let (g, rate) = (self.law.force(at), at.rate);
        match self.loss {
            Loss::Time(time, true) => g + rate * time,
            Loss::Time(time, false) => g + rate * time * at.touches(),
            Loss::Force(loss) => g + g.abs() * rate * loss,
        }
    }
    #[inline(always)]
    fn force_on<S: Scalar>(&self, piece: Piece, kinks: &[Piece], at: Deflection<S>) -> S {
        let (g, rate) = (self.law.force_on(piece, kinks, at), at.rate);
        match (self.loss, piece) {
            (Loss::Time(_, false), Piece::Gap) => g,
            (Loss::Time(time, _), _) => g + rate * time,
            (Loss::Force(loss), Piece::Lower) => g - g * rate * loss,
            (Loss::Force(loss), Piece::Gap) => g + g.abs() * rate * loss,
            (Loss::Force(loss), Piece::Upper) => g + g * rate * loss,
        }
    }
    #[inline(always)]
    fn kinks(&self) -> usize {
        self.law.kinks()
    }
    #[inline(always)]
    fn kink<S: Scalar>(&self, k: usize, d: S, rate: S) -> S {
        self.law.kink(k, d, rate)
    }
    fn edges<A: Angle>(&self, angle: A, side: Side) -> Edges<A::Number> {
        self.law.edges(angle, side)
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        self.law.next_edge(angle)
    }
    fn next_knot(&self, angle: f64) -> Option<f64> {
        self.law.next_knot(angle)
    }
    fn moves(&self) -> bool {
        self.law.moves()
    }
}
