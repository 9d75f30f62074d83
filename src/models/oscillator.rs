//! The oscillator with one degree of freedom.

use crate::contact::{Backlash, Contact, Deflection, PieceChoice};
use crate::error::{ParameterError, check};
use crate::excitation::{Angle, Fourier, Side, Wave};
use crate::model::{Channel, Drives, Machine, Shape, Size};
use crate::scalar::Scalar;

/// An oscillator with a cubic spring and a dead zone g of half backlash b, dimensionless:
///
/// q'' + c q' + k q + γ q³ + s (1 + a cos φ) g(q) = F + (P + A φ'²) cos φ
///
/// Duffing's equation, and a spur gear pair under a pulsating torque or, with A, under a transmission error.
/// Source: Kahraman and Singh 1990 (J. Sound Vib. 142, 49).
///
/// Constants: `speed` φ', `damping` c, `linear stiffness` k, `cubic stiffness` γ, `mesh stiffness` s,
/// `stiffness variation` a, `mean force` F, `force` P, `inertia force` A, `half backlash` b.
///
/// Its contact has the deflection q. An oscillator made without a mesh stiffness has no contact.
///
/// ```
/// use gear_dynamics::models::Oscillator;
/// use gear_dynamics::{Dop853, Integrator, Model, State};
/// let free = Oscillator::new(&[("speed", 1.0), ("linear stiffness", 4.0)])?; // q = cos 2t
/// let end = Dop853::new().rtol(1e-10).end(&free, &State::new(0.0, &[1.0], &[0.0]), 1.0)?;
/// assert!((end.q[0] - 2f64.cos()).abs() < 1e-8);
/// let pair = [("speed", 0.7), ("mesh stiffness", 1.0), ("mean force", 0.1), ("half backlash", 1.0)];
/// assert_eq!((free.contacts(), Oscillator::new(&pair)?.contacts()), (0, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Oscillator = Machine<OscillatorShape>;

/// The shape of an [`Oscillator`].
///
/// ```
/// use gear_dynamics::{Shape, models::Oscillator};
/// assert_eq!(Oscillator::new(&[("speed", 1.0)])?.shape().size().contacts, 0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct OscillatorShape {
    cos: Wave,
    /// The dead zone, whose edges follow from a constant.
    law: Option<Backlash>,
}

const NAMES: [&str; 10] = [
    "speed",
    "damping",
    "linear stiffness",
    "cubic stiffness",
    "mesh stiffness",
    "stiffness variation",
    "mean force",
    "force",
    "inertia force",
    "half backlash",
];

impl Oscillator {
    /// The oscillator with these constants; those that are not given are 0.
    ///
    /// # Errors
    /// A name that does not exist or is given twice; a speed or half backlash out of range.
    pub fn new(given: &[(&str, f64)]) -> Result<Self, ParameterError> {
        let is_given = |name: &str| given.iter().any(|(other, _)| *other == name);
        let rest = NAMES.into_iter().filter(|name| !is_given(name)).map(|name| (name, 0.0));
        let constants: Vec<(&str, f64)> = given.iter().copied().chain(rest).collect();
        let cos = Wave::new(Fourier::new(0.0, &[[1.0, 0.0]])?);
        let law = is_given("mesh stiffness").then(Backlash::none);
        Machine::of_constants(OscillatorShape { cos, law }, &constants)
    }
}

impl Shape for OscillatorShape {
    #[inline(always)]
    fn size(&self) -> Size {
        Size {
            dof: 1,
            waves: 1,
            contacts: usize::from(self.law.is_some()),
            constants: NAMES.len(),
            ..Size::default()
        }
    }
    fn names(&self) -> Vec<Channel> {
        NAMES.map(|name| Channel::new(name, "1")).into()
    }
    fn check(&self, constants: &[f64]) -> Result<(), ParameterError> {
        check::not_negative("half backlash", constants[9]).map(drop)
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.cos.value(angle, side);
    }
    #[inline(always)]
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let Some(dead_zone) = &self.law else { return Contact::default() };
        let ([cos], [_, _, _, stiffness, variation, _, _, _, b]) = (u.waves(), u.constants());
        let at = Deflection { d: q[0], rate: v[0], lower: -b, upper: b };
        let force = (stiffness + stiffness * variation * cos) * law.force(i, dead_zone, at);
        Contact { deflection: q[0], rate: v[0], lower: -b, upper: b, force, ..Contact::default() }
    }
    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let ([cos], [damping, linear, cubic, _, _, mean, force, inertia]) = (u.waves(), u.constants());
        let (x, speed) = (q[0], u.speed());
        let springs = linear * x + cubic * x * x * x + self.contact(law, 0, u, q, v).force;
        a[0] = mean + (force + inertia * speed * speed) * cos - damping * v[0] - springs;
    }
}
