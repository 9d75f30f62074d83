//! The trait of a fast model: algebra on any number, written by what all lanes share.

use crate::contact::choice::PieceChoice;
use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::error::ParameterError;
use crate::excitation::side::Side;
use crate::model::equations::Channel;
use crate::scalar::Scalar;

/// How large a [`Shape`] is.
///
/// ```
/// let size = gear_dynamics::model::Size { dof: 1, waves: 1, contacts: 1, constants: 4 };
/// assert_eq!(size.drives(), 6); // waves, φ', φ'' and the other constants
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    /// Degrees of freedom.
    pub dof: usize,
    /// Drives that are functions of the angle.
    pub waves: usize,
    /// Contacts.
    pub contacts: usize,
    /// Constants that the algebra reads, the speed φ' among them: as many as [`Shape::prepare`] gives.
    pub constants: usize,
}

impl Size {
    /// Number of drives: waves, φ', φ'', the other constants.
    #[inline(always)]
    pub fn drives(self) -> usize {
        self.waves + 1 + self.constants
    }
}

/// The drives at one instant: functions of the angle φ, its speed φ' and acceleration φ'', and the constants.
///
/// ```
/// use gear_dynamics::model::Drives;
/// let drives = Drives::new(1, &[1.2, 100.0, 0.0, 20.0, 0.05]);
/// let [stiffness] = drives.waves();
/// let [load, damping] = drives.constants();
/// assert_eq!((stiffness, drives.speed(), load, damping), (1.2, 100.0, 20.0, 0.05));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Drives<'u, S> {
    waves: &'u [S],
    /// φ', φ'', the other constants.
    rest: &'u [S],
}

impl<'u, S: Scalar> Drives<'u, S> {
    /// From all drives of a model, of which the first ones are waves.
    ///
    /// # Panics
    /// If there are fewer drives than waves, φ' and φ''.
    #[inline(always)]
    pub fn new(waves: usize, all: &'u [S]) -> Self {
        let (waves, rest) = all.split_at(waves);
        debug_assert!(rest.len() >= 2, "{} drives beside the waves", rest.len());
        Drives { waves, rest }
    }
    /// The waves, as many as are asked for: `let [stiffness, error] = u.waves();`. Those that the shape does not have are not numbers.
    #[inline(always)]
    pub fn waves<const N: usize>(&self) -> [S; N] {
        leading(self.waves)
    }
    /// N waves from place `first` on: those of one mesh among several.
    ///
    /// # Panics
    /// If there are fewer.
    #[inline(always)]
    pub fn waves_from<const N: usize>(&self, first: usize) -> [S; N] {
        let waves = &self.waves[first..first + N];
        std::array::from_fn(|i| waves[i])
    }
    /// All waves.
    #[inline(always)]
    pub fn all_waves(&self) -> &'u [S] {
        self.waves
    }
    /// φ': rates over time are rates over the angle times it.
    #[inline(always)]
    pub fn speed(&self) -> S {
        self.rest[0]
    }
    /// φ'': zero at constant speed. A second derivative over time is f'' φ'² + f' φ''.
    #[inline(always)]
    pub fn acceleration(&self) -> S {
        self.rest[1]
    }
    /// The constants without the speed, as many as are asked for: `let [load, damping] = u.constants();`. Those that the shape does not have
    /// are not numbers.
    #[inline(always)]
    pub fn constants<const N: usize>(&self) -> [S; N] {
        leading(self.all_constants())
    }
    /// All constants without the speed.
    #[inline(always)]
    pub fn all_constants(&self) -> &'u [S] {
        &self.rest[2..]
    }
}

/// The first N numbers; those that are not there are not numbers.
#[inline(always)]
fn leading<S: Scalar, const N: usize>(numbers: &[S]) -> [S; N] {
    match numbers.first_chunk() {
        Some(first) => *first,
        None => std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(S::from(f64::NAN))),
    }
}

/// q'' = a(u, q, q') on any number: f64, [`Dual`](crate::model::Dual), [`Lanes`](crate::sweep::Lanes). A model is written once; exact Jacobians, contacts
/// held on pieces, derivatives by constants, lanes and tables follow from it.
///
/// `self` is the **shape**: what all runs share that run side by side in lanes. The drives u are functions of one angle φ
/// ([`waves`](Shape::waves)), its speed φ' and acceleration φ'', and [`constants`](Shape::constants) with names and units. A number that varies from run
/// to run is a constant; one that stands in `self` makes the shapes unequal, and models of unequal shapes do not share lanes. Therefore a
/// shape derives `PartialEq`.
///
/// [`Machine::with_constants`](crate::Machine::with_constants) gives the shape its constants and makes a [`Model`](crate::Model) of it.
///
/// ```
/// use gear_dynamics::contact::{Backlash, Contact, PieceChoice};
/// use gear_dynamics::excitation::{Fourier, Side, Wave};
/// use gear_dynamics::model::{Channel, Drives, Machine, Periodic, Scalar, Shape, Size, State};
/// use gear_dynamics::ode::{Dop853, Integrator};
///
/// /// q'' + 2 ζ q' + k(φ) f(q) = T: a spur pair over its mesh angle, dimensionless.
/// #[derive(PartialEq)]
/// struct SpurPair { stiffness: Wave, law: Backlash }
///
/// impl Shape for SpurPair {
///     fn size(&self) -> Size { Size { dof: 1, waves: 1, contacts: 1, constants: 4 } }
///     fn constants(&self) -> Vec<Channel> {
///         [("speed", "1"), ("load", "1"), ("damping ratio", "1"), ("half backlash", "1")].map(|(name, unit)| Channel::new(name, unit)).into()
///     }
///     fn waves(&self, angle: f64, side: Side, u: &mut [f64]) { u[0] = self.stiffness.value(angle, side); }
///     fn next_edge(&self, angle: f64) -> Option<f64> { self.stiffness.next_edge(angle) }
///     #[inline(always)]
///     fn contact<S: Scalar, L: PieceChoice<S>>(&self, law: &L, i: usize, u: Drives<'_, S>, q: &[S], v: &[S]) -> Contact<S> {
///         let ([k], [_, _, b]) = (u.waves(), u.constants());
///         Contact { deflection: q[0], rate: v[0], lower: -b, upper: b, force: k * law.force(i, &self.law, q[0], v[0], -b, b), ..Contact::default() }
///     }
///     #[inline(always)]
///     fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
///         let [load, zeta, _] = u.constants();
///         a[0] = load - zeta * v[0] * 2.0 - self.contact(law, 0, u, q, v).force;
///     }
/// }
///
/// let shape = SpurPair { stiffness: Wave::new(Fourier::new(1.0, &[[0.2, 0.0]])?), law: Backlash::new(1.0)? };
/// let pair = Machine::with_constants(shape, &[("speed", 0.9), ("load", 0.1), ("damping ratio", 0.05), ("half backlash", 1.0)])?;
/// let end = Dop853::new().end(&pair, &State::new(0.0, &[1.5], &[0.0]), pair.period())?;
/// let wider = pair.with("half backlash", 1.1)?; // shares lanes with `pair`
/// assert_eq!(wider.constant("half backlash")?, 1.1);
/// assert!((end.q[0] - 0.585_194_217).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// A shape that cannot be compared does not compile:
///
/// ```compile_fail,E0277
/// use gear_dynamics::contact::PieceChoice;
/// use gear_dynamics::model::{Channel, Drives, Scalar, Shape, Size};
/// struct Careless { damping: f64 }
/// impl Shape for Careless {
///     fn size(&self) -> Size { Size { dof: 1, constants: 1, ..Size::default() } }
///     fn constants(&self) -> Vec<Channel> { vec![Channel::new("speed", "rad/s")] }
///     fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, _: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) { a[0] = -q[0] - v[0] * self.damping; }
/// }
/// ```
pub trait Shape: PartialEq {
    /// Coordinates, waves, contacts, constants. Mark it `#[inline(always)]`: lanes of small models are compiled for their size.
    fn size(&self) -> Size;
    /// Names and units of the constants. The first one is the speed, of the shaft or of the model, unless [`prepare`](Shape::prepare) says
    /// otherwise.
    fn constants(&self) -> Vec<Channel>;
    /// q''. Contact forces come from `law`.
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]);

    /// Contact `i`: deflection, rate, edges and force, damping included; rates are over time. The force comes from `law`.
    #[inline(always)]
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let _ = (law, i, u, q, v);
        Contact::default()
    }
    /// The waves at an angle φ `[rad]`, seen from one side. They repeat with [`repeats`](Shape::repeats). Rates are over the angle. An angle lies on an
    /// edge only to rounding, which a [`Wave`](crate::Wave) allows for.
    ///
    /// # Panics
    /// `u` has room for as many as [`size`](Shape::size) says.
    fn waves(&self, angle: f64, side: Side, u: &mut [f64]) {
        let _ = (angle, side, u);
    }
    /// The same into waves of another angle: what never changes stands there already and may be left out.
    fn waves_again(&self, angle: f64, side: Side, u: &mut [f64]) {
        self.waves(angle, side, u);
    }
    /// The first angle after this one at which a wave jumps or kinks.
    fn next_edge(&self, angle: f64) -> Option<f64> {
        let _ = angle;
        None
    }
    /// How often all waves repeat in 2π: the greatest common divisor of their orders ([`Wave::common_order`](crate::Wave::common_order)). Default: once.
    fn repeats(&self) -> u32 {
        1
    }
    /// What the algebra reads, from the constants in their order; the first one is φ', the speed of the angle over the model's time.
    /// Default: the constants themselves. Runs once per model, on any number, so that derivatives by the constants are exact.
    fn prepare<S: Scalar>(&self, constants: &[S]) -> Vec<S> {
        constants.to_vec()
    }
    /// Whether the constants are in their ranges; all are within ±1e50 already.
    ///
    /// # Errors
    /// The first one that is not.
    fn check(&self, constants: &[f64]) -> Result<(), ParameterError> {
        let _ = constants;
        Ok(())
    }

    /// Velocities behind an impact on a rigid stop: contact `contact` meets its flank `on`. `false`: that flank is no stop. Lanes and tables refuse
    /// a shape with stops. See [`Model::impact`](crate::Model::impact) and [`Restitution`](crate::contact::Restitution).
    fn impact(&self, contact: usize, on: Piece, u: Drives<'_, f64>, q: &[f64], v: &mut [f64]) -> bool {
        let _ = (contact, on, u, q, v);
        false
    }

    /// Output channels of the model's own.
    fn channels(&self) -> Vec<Channel> {
        Vec::new()
    }
    /// The values of [`channels`](Shape::channels).
    fn observe(&self, u: Drives<'_, f64>, q: &[f64], v: &[f64], contacts: &[Contact], out: &mut [f64]) {
        let _ = (u, q, v, contacts, out);
    }
}
