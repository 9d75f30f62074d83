//! A gear mesh: what rings and trains are made of.

use crate::error::{ParameterError, check};
use crate::excitation::{Excitation, Repeats, Shared, earlier};
use crate::model::Law;
use crate::nonlinearity::{Backlash, Nonlinearity};
use crate::scalar::Scalar;

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

/// What a [`Ring`](crate::Ring) is made of: W = C d' + K(t) f(d), d the deflection less the error e(t).   Source: Yao 2020, Eq. (1), with the dots it lacks.
///
/// ```
/// use gear_dynamics::{Backlash, Constant, Fourier, Mesh, shared};
/// let stiffness = shared(Constant::new(2e8)?); // [N/m]
/// let error = shared(Fourier::new(0.0, &[[0.0, 1e-6]], 3000.0)?); // 1 μm sin ωt [m]
/// let mesh = Mesh::new(stiffness, error, 1000.0, Backlash::new(2.65e-5)?)?;
/// assert_eq!(mesh.damping(), 1000.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Mesh<N = Backlash> {
    pub(crate) stiffness: Shared,
    pub(crate) error: Shared,
    pub(crate) damping: f64,
    pub(crate) law: N,
    pub(crate) contact_damping: ContactDamping,
}

impl<N: Nonlinearity> Mesh<N> {
    /// Stiffness K(t) [N/m], transmission error e(t) `[m]`, damping C [N s/m] (not negative), contact law.
    ///
    /// # Errors
    /// A damping that is negative or above 1e50.
    pub fn new(stiffness: Shared, error: Shared, damping: f64, law: N) -> Result<Self, ParameterError> {
        let damping = check::not_negative("mesh damping", damping)?;
        Ok(Mesh { stiffness, error, damping, law, contact_damping: ContactDamping::Always })
    }

    /// The same mesh with damping that acts always or only in contact.
    pub fn with_contact_damping(self, contact_damping: ContactDamping) -> Self {
        Mesh { contact_damping, ..self }
    }

    /// C [N s/m].
    pub fn damping(&self) -> f64 {
        self.damping
    }
    /// K(t).
    pub fn stiffness(&self) -> &dyn Excitation {
        &*self.stiffness
    }
    /// e(t).
    pub fn error(&self) -> &dyn Excitation {
        &*self.error
    }
    /// The contact law.
    pub fn law(&self) -> &N {
        &self.law
    }

    pub(crate) fn next_edge(&self, t: f64) -> Option<f64> {
        earlier(earlier(self.stiffness.next_edge(t), self.error.next_edge(t)), self.law.next_edge(t))
    }
    pub(crate) fn repeats(&self) -> Repeats {
        self.stiffness.repeats().with(self.error.repeats()).with(self.law.repeats())
    }

    /// W from the deflection, its rate and what the drives say.
    #[inline(always)]
    pub(crate) fn force<S: Scalar, L: Law<S>>(&self, law: &L, i: usize, x: S, rate: S, at: MeshDrives<S>) -> S {
        let elastic = at.stiffness * law.force(i, &self.law, x, rate, at.lower, at.upper);
        let viscous = at.damping * rate;
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
