//! A gear mesh: what rings and trains are made of.

use crate::error::ParameterError;
use crate::excitation::{Wave, earlier};
use crate::nonlinearity::{Backlash, Nonlinearity};
use crate::scalar::Scalar;
use crate::shape::Law;

/// When the mesh damping acts. Damping that follows the stiffness or the depth belongs to the law: [`Damped`](crate::Damped),
/// [`NoPullBacklash`](crate::NoPullBacklash).
///
/// ```
/// assert_eq!(gear_dynamics::ContactDamping::default(), gear_dynamics::ContactDamping::Always);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactDamping {
    /// Also in the gap, as both papers have it: an oil film.
    #[default]
    Always,
    /// Only while teeth touch; the force then jumps at the edge.
    InContact,
}

/// What a [`Ring`](crate::Ring) is made of: W = C d' + K(φ) f(d), d the deflection less the error e(φ).   Source: Yao 2020, Eq. (1), with the dots it lacks.
///
/// ```
/// use gear_dynamics::{Backlash, Fourier, Mesh, Wave};
/// let stiffness = Wave::constant(2e8)?; // [N/m]
/// let error = Wave::new(Fourier::new(0.0, &[[0.0, 1e-6]])?); // 1 μm sin φ [m]
/// let mesh = Mesh::new(stiffness, error, Backlash::new(2.65e-5)?);
/// assert_eq!(mesh.law().half_width(), 2.65e-5);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh<N = Backlash> {
    pub(crate) stiffness: Wave,
    pub(crate) error: Wave,
    pub(crate) law: N,
    pub(crate) contact_damping: ContactDamping,
}

impl<N: Nonlinearity> Mesh<N> {
    /// Stiffness K(φ) [N/m], transmission error e(φ) `[m]`, contact law. Its damping C is a constant of the model that it stands in.
    pub fn new(stiffness: Wave, error: Wave, law: N) -> Self {
        Mesh { stiffness, error, law, contact_damping: ContactDamping::Always }
    }

    /// The same mesh with damping that acts always or only in contact.
    pub fn with_contact_damping(self, contact_damping: ContactDamping) -> Self {
        Mesh { contact_damping, ..self }
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

    /// The next angle at which one of its waves or an edge of its gap jumps or kinks.
    pub(crate) fn next_edge(&self, angle: f64) -> Option<f64> {
        self.next_edge_of(angle, 1.0)
    }
    /// The same where the waves are of a shaft that turns once for `teeth` turns of the mesh angle, that of the law.
    pub(crate) fn next_edge_of(&self, angle: f64, teeth: f64) -> Option<f64> {
        let of_law = self.law.next_edge(teeth * angle).map(|edge| edge / teeth);
        earlier(earlier(self.stiffness.next_edge(angle), self.error.next_edge(angle)), of_law)
    }

    /// The same mesh `order` times a turn.
    pub(crate) fn per_turn(self, order: u32) -> Result<Self, ParameterError> {
        Ok(Mesh { stiffness: self.stiffness.per_turn(order)?, error: self.error.per_turn(order)?, ..self })
    }

    /// W from the deflection x, its rate, the rate `slip` that is damped and what the drives say.
    #[inline(always)]
    pub(crate) fn force<S: Scalar, L: Law<S>>(&self, law: &L, i: usize, x: S, rate: S, slip: S, at: MeshDrives<S>) -> S {
        let elastic = at.stiffness * law.force(i, &self.law, x, rate, at.lower, at.upper);
        let viscous = at.damping * slip;
        match self.contact_damping {
            ContactDamping::Always => elastic + viscous,
            ContactDamping::InContact => elastic + viscous * law.touch(i, x, at.lower, at.upper),
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
