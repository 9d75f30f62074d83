//! Gear meshes: the components of rings and trains.

use crate::contact::deflection::Deflection;
use crate::contact::laws::backlash::Backlash;
use crate::contact::laws::nonlinearity::{Edges, Nonlinearity};
use crate::contact::piece_choice::{PieceChoice, Place};
use crate::contact::tooth::Contact;
use crate::error::{ParameterError, check};
use crate::excitation::earliest::earlier;
use crate::excitation::wave::gcd;
use crate::excitation::{Angle, Scaled, Side, Wave};
use crate::scalar::Scalar;

/// Range of deflections in which the mesh damping C acts. Default: `Always`.
///
/// Damping that follows the stiffness or the depth belongs to the contact law:
/// [`Damped`](crate::contact::Damped), [`NoPullBacklash`](crate::contact::NoPullBacklash).
///
/// ```
/// use gear_dynamics::contact::{ByDeflection, ContactDamping};
/// use gear_dynamics::{excitation::Side, Backlash, Mesh, Wave};
/// let always = Mesh::new(Wave::constant(2e8)?, Wave::constant(0.0)?, Backlash::new(1e-5)?);
/// let in_contact = always.clone().with_contact_damping(ContactDamping::InContact);
/// let mut waves = [0.0; 7];
/// always.waves(0.0, Side::After, &mut waves);
/// // In the middle of the gap, d = 0 and d' = 0.5 m/s, with C = 100 N s/m:
/// let force = |mesh: &Mesh| mesh.contact(&ByDeflection, 0, &waves, 1e3, 100.0, 0.0, 0.5).force;
/// assert_eq!((force(&always), force(&in_contact)), (50.0, 0.0)); // [N]
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactDamping {
    /// The damping acts on the flanks and in the gap. It represents an oil film, as in Liu 2021 and Yao 2020.
    #[default]
    Always,
    /// The damping acts only while the teeth touch. The force then jumps at the edge.
    InContact,
}

// Places of the drives of a mesh.
pub(crate) const STIFFNESS: usize = 0; // K [N/m]
pub(crate) const ERROR: usize = 1; // e [m]
pub(crate) const ERROR_RATE: usize = 2; // de/dφ [m]
pub(crate) const LOWER: usize = 3; // lower edge of the law [m]
pub(crate) const UPPER: usize = 4; // upper edge of the law [m]
pub(crate) const LOWER_RATE: usize = 5; // rate of the lower edge over φ [m]
pub(crate) const UPPER_RATE: usize = 6; // rate of the upper edge over φ [m]

/// A gear mesh: W = C d' + K(φ) f(d), with the deflection d = x - e(φ).
///
/// x is the displacement of the two gears relative to each other along the line of action, e(φ) the static
/// transmission error, K(φ) the mesh stiffness, f the contact law and C the damping.   Source: Yao 2020,
/// Eq. (1), with the time derivatives that the printed W_d lacks ([errata](crate::guide::errata)).
///
/// A [`Ring`](crate::Ring) consists of meshes, and a user-defined [`Shape`](crate::Shape) may contain them:
/// [`waves`](Mesh::waves) computes the drives, and [`contact`](Mesh::contact) computes deflection and force
/// from them.
///
/// ```
/// use gear_dynamics::{contact::ByDeflection, Backlash, Mesh, Wave, excitation::{Fourier, Side}};
/// let stiffness = Wave::constant(2e8)?; // [N/m]
/// let error = Wave::new(Fourier::new(0.0, &[[0.0, 1e-6]])?); // 1 μm sin φ [m]
/// let mesh = Mesh::new(stiffness, error, Backlash::new(2.65e-5)?);
/// let mut waves = [0.0; 7];
/// mesh.waves(0.0, Side::After, &mut waves);
/// // φ' = 1000 rad/s, C = 0, x = 30 μm, x' = 0
/// let contact = mesh.contact(&ByDeflection, 0, &waves, 1e3, 0.0, 3e-5, 0.0);
/// assert!((contact.force - 2e8 * (3e-5 - 2.65e-5)).abs() < 1e-9);
/// assert_eq!(contact.rate, -1e-3);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct Mesh<N = Backlash> {
    stiffness: Wave,
    error: Wave,
    law: N,
    /// Turns of the mesh angle in one turn of the shaft. The edges of the law are functions of the mesh
    /// angle.
    teeth: u32,
    contact_damping: ContactDamping,
    /// Whether the damping depends on the contact: [`ContactDamping::InContact`] and a law with edges.
    released: bool,
}

impl<N: Nonlinearity> Mesh<N> {
    /// Number of drives that [`waves`](Mesh::waves) writes: K, e, de/dφ, lower edge and upper edge of the
    /// law, rate of the lower edge and of the upper edge over φ.
    pub const WAVES: usize = 7;

    /// A mesh with stiffness K(φ) [N/m], static transmission error e(φ) `[m]` and a contact law.
    ///
    /// The damping C is a constant of the model that contains the mesh. Default: it acts always
    /// ([`ContactDamping::Always`]).
    pub fn new(stiffness: Wave, error: Wave, law: N) -> Self {
        Mesh { stiffness, error, law, teeth: 1, contact_damping: ContactDamping::Always, released: false }
    }

    /// The law of a mesh whose stiffness and error stand elsewhere.
    pub(crate) fn of_law(law: N) -> Self {
        Mesh::new(Wave::zero(), Wave::zero(), law)
    }

    /// The same mesh with damping that acts always or only in contact. Default: always.
    pub fn with_contact_damping(self, contact_damping: ContactDamping) -> Self {
        let edgeless = self.law.edges(0.0, Side::After) == Edges::none() && !self.law.moves();
        let released = contact_damping == ContactDamping::InContact && !edgeless;
        Mesh { contact_damping, released, ..self }
    }
    /// The same mesh, repeated `teeth` times in a turn of the shaft: its waves and the moving edges of its
    /// law.
    ///
    /// # Errors
    /// The errors of [`Wave::per_turn`]; more than 1 000 000 teeth, factors of repeated calls multiplied.
    pub fn per_turn(self, teeth: u32) -> Result<Self, ParameterError> {
        let (stiffness, error) = (self.stiffness.per_turn(teeth)?, self.error.per_turn(teeth)?);
        let teeth =
            check::count("teeth of a mesh", &[self.teeth as usize, teeth as usize], check::TEETH)? as u32;
        Ok(Mesh { stiffness, error, teeth, ..self })
    }

    /// The same mesh with its stiffness multiplied by `factor`.
    pub(crate) fn scaled(self, factor: f64) -> Result<Self, ParameterError> {
        Ok(Mesh { stiffness: Wave::new(Scaled::new(factor, self.stiffness)?), ..self })
    }

    /// Number of times that all given meshes repeat in a turn of the shaft, at least 1, for
    /// [`Shape::repeats`](crate::Shape::repeats).
    pub fn common_order<'m>(meshes: impl IntoIterator<Item = &'m Self>) -> u32
    where
        N: 'm,
    {
        meshes.into_iter().fold(0, |common, mesh| gcd(common, mesh.repeats())).max(1)
    }
    /// Number of times that the mesh repeats in a turn of the shaft: the greatest common divisor of the
    /// orders of its waves and, if its edges move, of its number of teeth. 0 if nothing varies.
    fn repeats(&self) -> u32 {
        gcd(Wave::gcd_of_orders([&self.stiffness, &self.error]), self.repeats_of_law())
    }
    /// The number of teeth if the edges of the law move, 0 otherwise.
    pub(crate) fn repeats_of_law(&self) -> u32 {
        if self.law.moves() { self.teeth } else { 0 }
    }

    /// Mesh stiffness K(φ) [N/m].
    pub fn stiffness(&self) -> &Wave {
        &self.stiffness
    }
    /// Static transmission error e(φ) `[m]`.
    pub fn error(&self) -> &Wave {
        &self.error
    }
    /// The range of deflections in which the damping acts.
    pub fn contact_damping(&self) -> ContactDamping {
        self.contact_damping
    }
    /// The contact law.
    pub fn law(&self) -> &N {
        &self.law
    }

    /// Writes the [`WAVES`](Mesh::WAVES) drives of the mesh at an angle of the shaft `[rad]` to `u`. `side`:
    /// before or after a jump at this angle.
    ///
    /// # Panics
    /// If `u` has fewer than [`WAVES`](Mesh::WAVES) entries.
    pub fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        let error = self.error.jet(angle, side);
        u[STIFFNESS] = self.stiffness.value(angle, side);
        (u[ERROR], u[ERROR_RATE]) = (error.value, error.rate);
        self.edges(angle, side, u);
    }
    /// Writes the edges of the law and their rates alone.
    pub(crate) fn edges<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        [u[LOWER], u[UPPER], u[LOWER_RATE], u[UPPER_RATE]] = self.law_edges(angle, side);
    }
    /// The edges of the law, lower and upper, and their rates over the angle.
    pub(crate) fn law_edges<A: Angle>(&self, angle: A, side: Side) -> [A::Number; 4] {
        let teeth = f64::from(self.teeth);
        let edges = self.law.edges(angle.times(teeth), side);
        [edges.lower, edges.upper, edges.lower_rate * teeth, edges.upper_rate * teeth]
    }
    /// The next angle of the shaft at which a wave or an edge of the gap jumps or has a kink.
    pub fn next_edge(&self, angle: f64) -> Option<f64> {
        let waves = earlier(self.stiffness.next_edge(angle), self.error.next_edge(angle));
        earlier(waves, self.next_edge_of_law(angle))
    }
    /// The next angle of the shaft at which a wave or an edge of the gap has a knot. See [`Wave::next_knot`].
    pub fn next_knot(&self, angle: f64) -> Option<f64> {
        let waves = earlier(self.stiffness.next_knot(angle), self.error.next_knot(angle));
        earlier(waves, self.next_knot_of_law(angle))
    }
    /// The next angle of the shaft at which an edge of the gap has a knot.
    pub(crate) fn next_knot_of_law(&self, angle: f64) -> Option<f64> {
        let teeth = f64::from(self.teeth);
        self.law.next_knot(teeth * angle).map(|knot| knot / teeth)
    }
    /// The next angle of the shaft at which an edge of the gap jumps or has a kink.
    pub(crate) fn next_edge_of_law(&self, angle: f64) -> Option<f64> {
        let teeth = f64::from(self.teeth);
        self.law.next_edge(teeth * angle).map(|edge| edge / teeth)
    }

    /// Computes the contact at which the teeth touch from the [`waves`](Mesh::waves) of the mesh, the speed
    /// φ' [rad/s], the damping C [N s/m], the displacement x `[m]` and its rate x' [m/s]. `place`: the
    /// contacts of the mesh; for a law without inner kinks the index of its contact.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "each is one letter of the equation")]
    pub fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        place: impl Into<Place>,
        waves: &[S; 7],
        speed: S,
        damping: S,
        x: S,
        rate: S,
    ) -> Contact<S> {
        let (deflection, rate) = (x - waves[ERROR], rate - speed * waves[ERROR_RATE]);
        let (lower, upper) = (waves[LOWER], waves[UPPER]);
        let at = Deflection { d: deflection, rate, lower, upper };
        let force = self.force(law, place, at, rate, waves[STIFFNESS], damping);
        let (lower_rate, upper_rate) = (speed * waves[LOWER_RATE], speed * waves[UPPER_RATE]);
        Contact { deflection, rate, lower, upper, lower_rate, upper_rate, force }
    }

    /// Computes W from the deflection d, the rate `slip` on which the damping C acts, K and C.
    #[inline(always)]
    pub(crate) fn force<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        place: impl Into<Place>,
        at: Deflection<S>,
        slip: S,
        stiffness: S,
        damping: S,
    ) -> S {
        let place = place.into();
        let elastic = stiffness * law.force(place, &self.law, at);
        let viscous = damping * slip;
        if self.released { elastic + viscous * law.touch(place.contact, at) } else { elastic + viscous }
    }
}
