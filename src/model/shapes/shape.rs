//! Shapes: models whose algebra is written once for every number type.

use crate::contact::laws::nonlinearity::LanesOf;
use crate::contact::{Contact, Piece, PieceChoice};
use crate::error::ParameterError;
use crate::excitation::{Angle, Side};
use crate::model::channel::Channel;
use crate::scalar::Scalar;

/// The size of a [`Shape`]: numbers of degrees of freedom, waves, contacts, inner kinks and constants.
///
/// ```
/// let size = gear_dynamics::model::Size { dof: 1, waves: 1, contacts: 1, constants: 4, ..Default::default() };
/// assert_eq!(size.drives(), 6); // waves, φ', φ'' and the other constants
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    /// Number of degrees of freedom.
    pub dof: usize,
    /// Number of waves: drives that are functions of the angle.
    pub waves: usize,
    /// Number of contacts, inner kinks of the laws included.
    pub contacts: usize,
    /// Number of contacts that are inner kinks of contact laws ([`Nonlinearity::kinks`]): the last ones. See
    /// [`Offers::kinks`](crate::model::Offers::kinks).
    ///
    /// [`Nonlinearity::kinks`]: crate::contact::Nonlinearity::kinks
    pub kinks: usize,
    /// Number of constants that the algebra reads, including the speed φ': the length of the list from
    /// [`Shape::prepare`].
    pub constants: usize,
}

impl Size {
    /// Number of drives: waves, φ', φ'' and the other constants.
    #[inline(always)]
    pub fn drives(self) -> usize {
        self.waves + 1 + self.constants
    }
}

/// The drives at one instant: waves, the speed φ' and the acceleration φ'' of their angle, and the other
/// constants.
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
    /// The drives from the list `all` of a model, whose first entries are the waves.
    ///
    /// # Panics
    /// If `all` is shorter than `waves`. In debug builds also if φ' or φ'' is missing.
    #[inline(always)]
    pub fn new(waves: usize, all: &'u [S]) -> Self {
        let (waves, rest) = all.split_at(waves);
        debug_assert!(rest.len() >= 2, "{} drives after the waves: 2 (φ' and φ'') are needed", rest.len());
        Drives { waves, rest }
    }
    /// The first N waves: `let [stiffness, error] = u.waves();`. Waves that the shape does not have are NaN.
    #[inline(always)]
    pub fn waves<const N: usize>(&self) -> [S; N] {
        leading(self.waves)
    }
    /// N waves from index `first` on, for example those of one mesh among several.
    ///
    /// # Panics
    /// If the shape has fewer than `first + N` waves.
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
    /// Speed φ'. A rate over time is the rate over the angle times φ'.
    #[inline(always)]
    pub fn speed(&self) -> S {
        self.rest[0]
    }
    /// Acceleration φ'': 0 at constant speed. A second derivative over time is f'' φ'² + f' φ''.
    #[inline(always)]
    pub fn acceleration(&self) -> S {
        self.rest[1]
    }
    /// The first N constants after the speed: `let [load, damping] = u.constants();`. Constants that the
    /// shape does not have are NaN.
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

/// The first N numbers of a list; missing numbers are NaN.
#[inline(always)]
fn leading<S: Scalar, const N: usize>(numbers: &[S]) -> [S; N] {
    match numbers.first_chunk() {
        Some(first) => *first,
        None => std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(S::from(f64::NAN))),
    }
}

/// A shape: the algebra q'' = a(u, q, q') for every number type.
///
/// [`Scalar`] lists the number types. The model is written once. Exact Jacobians, fixed pieces, derivatives
/// with respect to constants, lanes and drive tables follow from it. `self` is the part of a model that all
/// runs in the same lanes share.
///
/// The drives u are functions of one angle φ ([`waves`](Shape::waves)), its speed φ' and acceleration φ'',
/// and [`names`](Shape::names) and units of constants. A number that varies from run to run must be a
/// constant. A number in a field of `self` that varies makes the shapes unequal, and models of unequal
/// shapes do not share lanes. A shape therefore derives `PartialEq`.
///
/// [`Machine::of_constants`](crate::Machine::of_constants) combines a shape with the values of its
/// constants to a [`Model`](crate::Model).
///
/// ```
/// use gear_dynamics::contact::{Backlash, Contact, Deflection, PieceChoice};
/// use gear_dynamics::excitation::{Angle, Fourier, Side, Wave};
/// use gear_dynamics::model::{Channel, Drives, Machine, Periodic, Scalar, Shape, Size, State};
/// use gear_dynamics::ode::{Dop853, Integrator};
///
/// /// q'' + 2 ζ q' + k(φ) f(q) = T: a spur pair over its mesh angle, dimensionless.
/// #[derive(PartialEq)]
/// struct OwnPair { stiffness: Wave, law: Backlash }
///
/// impl Shape for OwnPair {
///     fn size(&self) -> Size { Size { dof: 1, waves: 1, contacts: 1, constants: 4, ..Size::default() } }
///     fn names(&self) -> Vec<Channel> {
///         ["speed", "load", "damping ratio", "half backlash"].map(|name| Channel::new(name, "1")).into()
///     }
///     fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
///         u[0] = self.stiffness.value(angle, side);
///     }
///     fn next_edge(&self, angle: f64) -> Option<f64> { self.stiffness.next_edge(angle) }
///     #[inline(always)]
///     fn contact<S: Scalar, L: PieceChoice<S>>(
///         &self, law: &L, i: usize, u: Drives<'_, S>, q: &[S], v: &[S],
///     ) -> Contact<S> {
///         let [k] = u.waves();
///         let [_, _, b] = u.constants();
///         let at = Deflection { d: q[0], rate: v[0], lower: -b, upper: b };
///         let force = k * law.force(i, &self.law, at);
///         Contact { deflection: q[0], rate: v[0], lower: -b, upper: b, force, ..Contact::default() }
///     }
///     #[inline(always)]
///     fn accel<S: Scalar, L: PieceChoice<S>>(
///         &self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S],
///     ) {
///         let [load, zeta, _] = u.constants();
///         a[0] = load - zeta * v[0] * 2.0 - self.contact(law, 0, u, q, v).force;
///     }
/// }
///
/// let stiffness = Wave::new(Fourier::new(1.0, &[[0.2, 0.0]])?);
/// let shape = OwnPair { stiffness, law: Backlash::new(1.0)? };
/// let pair = Machine::of_constants(
///     shape,
///     &[("speed", 0.9), ("load", 0.1), ("damping ratio", 0.05), ("half backlash", 1.0)],
/// )?;
/// let end = Dop853::new().end(&pair, &State::new(0.0, &[1.5], &[0.0]), pair.period())?;
/// let wider = pair.with("half backlash", 1.1)?; // shares lanes with `pair`
/// assert_eq!(wider.constant("half backlash")?, 1.1);
/// assert!((end.q[0] - 0.585_194_217).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// A shape without `PartialEq` does not compile:
///
/// ```compile_fail,E0277
/// use gear_dynamics::contact::PieceChoice;
/// use gear_dynamics::model::{Channel, Drives, Scalar, Shape, Size};
/// struct Careless { damping: f64 }
/// impl Shape for Careless {
///     fn size(&self) -> Size { Size { dof: 1, constants: 1, ..Size::default() } }
///     fn names(&self) -> Vec<Channel> { vec![Channel::new("speed", "rad/s")] }
///     fn accel<S: Scalar, L: PieceChoice<S>>(
///         &self, _: &L, _: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S],
///     ) {
///         a[0] = -q[0] - v[0] * self.damping;
///     }
/// }
/// ```
pub trait Shape: PartialEq + Send + Sync + 'static {
    /// Whether the library contains the steps of the shape in lanes, so that a program does not compile them.
    #[doc(hidden)]
    const LANES: LanesOf = LanesOf::USER;
    /// Numbers of degrees of freedom, waves, contacts, inner kinks and constants. Mark the implementation
    /// `#[inline(always)]`, because lanes of small models are compiled for their size.
    fn size(&self) -> Size;
    /// Names and units of the constants. The first one is the speed φ' of the angle, unless
    /// [`prepare`](Shape::prepare) computes φ' from other constants.
    fn names(&self) -> Vec<Channel>;
    /// Writes q'' to `a`. Contact forces must be computed by `law`.
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]);

    /// Returns contact `i`: deflection, rate, edges and force, damping included. Rates are over time. The
    /// force must be computed by `law`. Default: no edges, no force.
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
    /// Writes the waves at an angle φ `[rad]`, of any kind of [`Angle`], to `u`, which has
    /// [`Size::waves`] entries. `side`: before or after a jump at this angle. Default: no waves.
    ///
    /// All waves repeat with the angle 2π/[`repeats`](Shape::repeats). Rates are over the angle. At an edge
    /// the angle has a rounding error, for which a [`Wave`](crate::Wave) allows.
    ///
    /// If all waves are weighted sums of [`Wave`](crate::Wave)s that are finite Fourier series, a machine
    /// records them once and then computes them from one sine and cosine of the angle.
    ///
    /// # Panics
    /// An implementation may panic if `u` has fewer entries than [`Size::waves`].
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        let _ = (angle, side, u);
    }
    /// Updates `u`, which contains the waves of another angle. The implementation may skip waves that never
    /// change. Default: [`waves`](Shape::waves).
    fn waves_again<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        self.waves(angle, side, u);
    }
    /// Returns the first angle after `angle` at which a wave jumps or has a kink. Default: `None`.
    fn next_edge(&self, angle: f64) -> Option<f64> {
        let _ = angle;
        None
    }
    /// Returns the first angle after `angle` at which a wave has a [knot](crate::Wave::next_knot). Adaptive
    /// Runge-Kutta methods end a step there. Default: `None`.
    fn next_knot(&self, angle: f64) -> Option<f64> {
        let _ = angle;
        None
    }
    /// Accelerations of the coordinates by φ'' = 1, one for each coordinate; empty for none. They act where
    /// the speed varies ([`VaryingSpeed`](crate::drives::VaryingSpeed)); [`Machine`](crate::Machine) adds
    /// φ'' times these numbers to q''. Default: none.
    ///
    /// Coordinates that are deviations from an ideal motion with the rates r_j over φ have -r_j here: the
    /// inertia of body j acts against r_j φ''. Rates that vary with the angle or with the state belong into
    /// [`accel`](Shape::accel), which reads φ'' from [`Drives::acceleration`].
    #[inline(always)]
    fn inertia(&self) -> &[f64] {
        &[]
    }
    /// Angle φ of the waves over the angle of the reference body, to which a
    /// [`SpeedLaw`](crate::drives::SpeedLaw) and the orders of a [`Waterfall`](crate::analysis::Waterfall)
    /// refer. Default: 1, they refer to φ itself.
    fn reference_ratio(&self) -> f64 {
        1.0
    }
    /// The names of the bodies that turn evenly, each with the angle φ of the waves over its angle. Default:
    /// the shape names no bodies.
    fn bodies(&self) -> Vec<(&str, f64)> {
        Vec::new()
    }
    /// Number of times that all waves repeat in 2π: the greatest common divisor of their orders
    /// ([`Wave::common_order`](crate::Wave::common_order)). Default: 1.
    fn repeats(&self) -> u32 {
        1
    }
    /// Number of cycles of the fastest wave in a period, for example of the mesh with the most teeth. Engines
    /// choose their steps by it ([`LaneRk4::of_model`](crate::sweep::LaneRk4::of_model)). Default: 1.
    fn cycles_in_a_period(&self) -> u32 {
        1
    }
    /// Returns the constants that the algebra reads, from the named constants in their order. The first one
    /// is φ', the speed of the angle over the time of the model. Default: the named constants.
    ///
    /// It runs once per model, for every number type, so that derivatives with respect to the named
    /// constants are exact.
    fn prepare<S: Scalar>(&self, constants: &[S]) -> Vec<S> {
        constants.to_vec()
    }
    /// Checks the ranges of the constants. The caller has checked that all are within ±1e50. Default: no
    /// further check.
    ///
    /// # Errors
    /// The first constant out of its range.
    fn check(&self, constants: &[f64]) -> Result<(), ParameterError> {
        let _ = constants;
        Ok(())
    }

    /// Whether the lower and the upper edge of each contact are rigid stops. Contacts past the end of the
    /// list have no stop. Default: none. Lanes and drive tables reject a shape with stops.
    fn stops(&self) -> &[[bool; 2]] {
        &[]
    }
    /// Applies the impact of contact `contact` on a rigid stop at the edge of flank `on`: replaces the
    /// velocities `v`. It is called for the [`stops`](Shape::stops). Default: NaN. See
    /// [`Model::impact`](crate::Model::impact) and [`Restitution`](crate::contact::Restitution).
    fn impact<S: Scalar>(&self, contact: usize, on: Piece, u: Drives<'_, S>, q: &[S], v: &mut [S]) {
        let _ = (contact, on, u, q);
        v.fill(f64::NAN.into());
    }

    /// Channels of this model in addition to those that every model has. Default: none.
    fn channels(&self) -> Vec<Channel> {
        Vec::new()
    }
    /// Writes the values of the [`channels`](Shape::channels) to `out`.
    fn write_channels(
        &self,
        u: Drives<'_, f64>,
        q: &[f64],
        v: &[f64],
        contacts: &[Contact],
        out: &mut [f64],
    ) {
        let _ = (u, q, v, contacts, out);
    }
}
