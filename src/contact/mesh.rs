//! A gear mesh: what rings and trains are made of.

use crate::contact::choice::PieceChoice;
use crate::contact::laws::backlash::Backlash;
use crate::contact::laws::nonlinearity::{Edges, Nonlinearity};
use crate::contact::tooth::Contact;
use crate::error::{ParameterError, check};
use crate::excitation::angle::earlier;
use crate::excitation::combine::Scaled;
use crate::excitation::side::Side;
use crate::excitation::wave::{Wave, divisor};
use crate::scalar::Scalar;

/// When the mesh damping acts. Damping that follows the stiffness or the depth belongs to the law: [`Damped`](crate::contact::Damped),
/// [`NoPullBacklash`](crate::contact::NoPullBacklash).
///
/// ```
/// assert_eq!(gear_dynamics::contact::ContactDamping::default(), gear_dynamics::contact::ContactDamping::Always);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactDamping {
    /// Also in the gap, as Liu 2021 and Yao 2020 have it: an oil film.
    #[default]
    Always,
    /// Only while teeth touch; the force then jumps at the edge.
    InContact,
}

// Waves of a mesh.
pub(crate) const STIFFNESS: usize = 0; // K [N/m]
pub(crate) const ERROR: usize = 1; // e [m]
pub(crate) const ERROR_RATE: usize = 2; // de/dφ [m]
pub(crate) const LOWER: usize = 3; // edges of the law [m]
pub(crate) const UPPER: usize = 4;
pub(crate) const LOWER_RATE: usize = 5; // over φ
pub(crate) const UPPER_RATE: usize = 6;

/// W = C d' + K(φ) f(d), d = x - e(φ): a mesh of two gears whose pitch circles have moved by x along the line of action. A
/// [`Ring`](crate::Ring) is made of meshes, and so may a [`Shape`](crate::Shape) of one's own be: [`waves`](Mesh::waves) gives the drives, from which
/// [`contact`](Mesh::contact) has its deflection and force.   Source: Yao 2020, Eq. (1), with the dots it lacks.
///
/// ```
/// use gear_dynamics::{contact::ByDeflection, Backlash, Mesh, Wave, excitation::{Fourier, Side}};
/// let stiffness = Wave::constant(2e8)?; // [N/m]
/// let error = Wave::new(Fourier::new(0.0, &[[0.0, 1e-6]])?); // 1 μm sin φ [m]
/// let mesh = Mesh::new(stiffness, error, Backlash::new(2.65e-5)?);
/// let mut waves = [0.0; 7];
/// mesh.waves(0.0, Side::After, &mut waves);
/// let contact = mesh.contact(&ByDeflection, 0, &waves, 1e3, 0.0, 3e-5, 0.0); // φ' = 1000 rad/s, C = 0, x = 30 μm at rest
/// assert!((contact.force - 2e8 * (3e-5 - 2.65e-5)).abs() < 1e-9);
/// assert_eq!(contact.rate, -1e-3);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh<N = Backlash> {
    stiffness: Wave,
    error: Wave,
    law: N,
    /// Turns of the mesh angle, that of the law, in one turn of the shaft.
    teeth: u32,
    /// Whether the law has no edges: it always touches.
    edgeless: bool,
    contact_damping: ContactDamping,
}

impl<N: Nonlinearity> Mesh<N> {
    /// How many drives [`waves`](Mesh::waves) are: K, e, de/dφ, the lower and the upper edge of the law, their rates over φ.
    pub const WAVES: usize = 7;

    /// Stiffness K(φ) [N/m], transmission error e(φ) `[m]`, contact law. Its damping C is a constant of the model that it stands in.
    pub fn new(stiffness: Wave, error: Wave, law: N) -> Self {
        let edgeless = law.edges(0.0, Side::After) == Edges::NONE && !law.moves();
        Mesh { stiffness, error, law, teeth: 1, edgeless, contact_damping: ContactDamping::Always }
    }

    /// The same mesh with damping that acts always or only in contact.
    pub fn with_contact_damping(self, contact_damping: ContactDamping) -> Self {
        Mesh { contact_damping, ..self }
    }
    /// The same mesh `teeth` times a turn of the shaft, moving edges of its law included.
    ///
    /// # Errors
    /// As [`Wave::per_turn`].
    pub fn per_turn(self, teeth: u32) -> Result<Self, ParameterError> {
        let (stiffness, error) = (self.stiffness.per_turn(teeth)?, self.error.per_turn(teeth)?);
        let teeth =
            check::count("teeth of a mesh", &[self.teeth as usize, teeth as usize], check::TEETH)? as u32;
        Ok(Mesh { stiffness, error, teeth, ..self })
    }

    /// The same mesh with its stiffness times a factor.
    pub(crate) fn scaled(self, factor: f64) -> Result<Self, ParameterError> {
        Ok(Mesh { stiffness: Wave::new(Scaled::new(factor, self.stiffness)?), ..self })
    }

    /// How often all of several meshes repeat in a turn of the shaft: what [`Shape::repeats`](crate::Shape::repeats) asks for.
    pub fn common_order<'m>(meshes: impl IntoIterator<Item = &'m Self>) -> u32
    where
        N: 'm,
    {
        meshes.into_iter().fold(0, |common, mesh| divisor(common, mesh.repeats())).max(1)
    }
    /// How often the mesh repeats in a turn of the shaft: the greatest common divisor of the orders of its waves and, if its edges move, its
    /// teeth. 0 if nothing varies.
    fn repeats(&self) -> u32 {
        let of_law = if self.law.moves() { self.teeth } else { 0 };
        divisor(Wave::divisor_of_orders([&self.stiffness, &self.error]), of_law)
    }

    /// K(φ).
    pub fn stiffness(&self) -> &Wave {
        &self.stiffness
    }
    /// e(φ).
    pub fn error(&self) -> &Wave {
        &self.error
    }
    /// The contact law.
    pub fn law(&self) -> &N {
        &self.law
    }

    /// The [`WAVES`](Mesh::WAVES) drives of the mesh at an angle of the shaft, seen from one side.
    ///
    /// # Panics
    /// If `u` has room for fewer.
    pub fn waves(&self, angle: f64, side: Side, u: &mut [f64]) {
        let error = self.error.jet(angle, side);
        u[STIFFNESS] = self.stiffness.value(angle, side);
        (u[ERROR], u[ERROR_RATE]) = (error.value, error.rate);
        self.edges(angle, side, u);
    }
    /// Those of the law's edges alone.
    pub(crate) fn edges(&self, angle: f64, side: Side, u: &mut [f64]) {
        let teeth = f64::from(self.teeth);
        let edges = self.law.edges(teeth * angle, side);
        (u[LOWER], u[UPPER]) = (edges.lower, edges.upper);
        (u[LOWER_RATE], u[UPPER_RATE]) = (teeth * edges.lower_rate, teeth * edges.upper_rate);
    }
    /// The next angle at which one of its waves or an edge of its gap jumps or kinks.
    pub fn next_edge(&self, angle: f64) -> Option<f64> {
        let teeth = f64::from(self.teeth);
        let of_law = self.law.next_edge(teeth * angle).map(|edge| edge / teeth);
        earlier(earlier(self.stiffness.next_edge(angle), self.error.next_edge(angle)), of_law)
    }

    /// Contact `i` from the [`waves`](Mesh::waves) of the mesh, φ', the damping C [N s/m], the path x `[m]` and its rate [m/s].
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "each is one letter of the equation")]
    pub fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        waves: &[S; 7],
        speed: S,
        damping: S,
        x: S,
        rate: S,
    ) -> Contact<S> {
        let force = self.pull(law, i, waves, speed, damping, x, rate);
        let (deflection, rate) = (x - waves[ERROR], rate - speed * waves[ERROR_RATE]);
        let (lower_rate, upper_rate) = (speed * waves[LOWER_RATE], speed * waves[UPPER_RATE]);
        Contact { deflection, rate, lower: waves[LOWER], upper: waves[UPPER], lower_rate, upper_rate, force }
    }

    /// The force of [`contact`](Mesh::contact) alone: what an algebra over many meshes reads.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "each is one letter of the equation")]
    pub(crate) fn pull<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        waves: &[S; 7],
        speed: S,
        damping: S,
        x: S,
        rate: S,
    ) -> S {
        let rate = rate - speed * waves[ERROR_RATE];
        let at =
            MeshDrives { stiffness: waves[STIFFNESS], damping, lower: waves[LOWER], upper: waves[UPPER] };
        self.force(law, i, x - waves[ERROR], rate, rate, at)
    }

    /// W from the deflection d, its rate, the rate `slip` that is damped and what the drives say.
    #[inline(always)]
    pub(crate) fn force<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        d: S,
        rate: S,
        slip: S,
        at: MeshDrives<S>,
    ) -> S {
        let elastic = at.stiffness * law.force(i, &self.law, d, rate, at.lower, at.upper);
        let viscous = at.damping * slip;
        match self.contact_damping {
            ContactDamping::Always => elastic + viscous,
            ContactDamping::InContact if self.edgeless => elastic + viscous,
            ContactDamping::InContact => elastic + viscous * law.touch(i, d, at.lower, at.upper),
        }
    }
}

/// What the drives say of a mesh at one instant.
pub(crate) struct MeshDrives<S> {
    pub(crate) stiffness: S,
    pub(crate) damping: S,
    pub(crate) lower: S,
    pub(crate) upper: S,
}
