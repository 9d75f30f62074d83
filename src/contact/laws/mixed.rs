//! Contact laws chosen at run time.

use crate::contact::deflection::Deflection;
use crate::contact::laws::backlash::{AsymmetricBacklash, Backlash, VaryingBacklash};
use crate::contact::laws::no_pull::NoPullBacklash;
use crate::contact::laws::nonlinearity::{Edges, Nonlinearity};
use crate::contact::laws::power::PowerLaw;
use crate::contact::laws::smooth::{Cubic, Linear, SmoothedBacklash};
use crate::contact::piece::Piece;
use crate::excitation::{Angle, Side};
use crate::scalar::Scalar;

/// One of the built-in laws or a user-defined law, for a model whose meshes have different laws.
///
/// ```
/// use gear_dynamics::{contact::{Cubic, MixedLaw, Nonlinearity}, Backlash};
/// let laws: [MixedLaw; 2] =
///     [MixedLaw::Backlash(Backlash::new(1.0)?), MixedLaw::Cubic(Cubic::new(1.0, 0.5)?)];
/// assert_eq!(laws.map(|law| law.at(2.0)), [1.0, 6.0]);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum MixedLaw<N = Linear> {
    /// f(d) = d.
    Linear(Linear),
    /// f(d) = s d + κ d³.
    Cubic(Cubic),
    /// Symmetric dead zone.
    Backlash(Backlash),
    /// Asymmetric dead zone.
    Asymmetric(AsymmetricBacklash),
    /// Dead zone with a half backlash that varies.
    Varying(VaryingBacklash),
    /// Dead zone with rounded corners.
    Smoothed(SmoothedBacklash),
    /// Flanks with a power of the depth.
    Power(PowerLaw),
    /// Damped dead zone that never pulls.
    NoPull(NoPullBacklash),
    /// A user-defined law.
    Other(N),
}

/// Evaluates an expression on the law of the variant.
macro_rules! each_law {
    ($self:ident, $law:ident => $body:expr) => {
        match $self {
            MixedLaw::Linear($law) => $body,
            MixedLaw::Cubic($law) => $body,
            MixedLaw::Backlash($law) => $body,
            MixedLaw::Asymmetric($law) => $body,
            MixedLaw::Varying($law) => $body,
            MixedLaw::Smoothed($law) => $body,
            MixedLaw::Power($law) => $body,
            MixedLaw::NoPull($law) => $body,
            MixedLaw::Other($law) => $body,
        }
    };
}

impl<N: Nonlinearity> Nonlinearity for MixedLaw<N> {
    #[inline(always)]
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
        each_law!(self, law => law.force(at))
    }
    #[inline(always)]
    fn force_on<S: Scalar>(&self, piece: Piece, kinks: &[Piece], at: Deflection<S>) -> S {
        each_law!(self, law => law.force_on(piece, kinks, at))
    }
    fn kinks(&self) -> usize {
        each_law!(self, law => law.kinks())
    }
    #[inline(always)]
    fn kink<S: Scalar>(&self, k: usize, d: S, rate: S) -> S {
        each_law!(self, law => law.kink(k, d, rate))
    }
    fn edges<A: Angle>(&self, angle: A, side: Side) -> Edges<A::Number> {
        each_law!(self, law => law.edges(angle, side))
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        each_law!(self, law => law.next_edge(angle))
    }
    fn next_knot(&self, angle: f64) -> Option<f64> {
        each_law!(self, law => law.next_knot(angle))
    }
    fn moves(&self) -> bool {
        each_law!(self, law => law.moves())
    }
}
