//! Rigid stops: velocities jump when a contact reaches an edge.

use crate::error::{ParameterError, check};
use crate::scalar::Scalar;

/// Newton's law of restitution for a rigid stop: v⁺ - w = -e (v - w), with the velocity w of the stop and
/// 0 <= e <= 1.
///
/// It is used in [`Model::impact`](crate::Model::impact). A contact that comes to rest on its stop ends a run
/// with [`IntegrateError::RestsOnStop`](crate::ode::IntegrateError::RestsOnStop): for 0 < e < 1 after a
/// sequence of ever lower rebounds, for e = 0 at the first impact, unless the stop moves away.
///
/// ```
/// use gear_dynamics::contact::{Contact, Piece, Restitution};
/// use gear_dynamics::{model::Offers, Dop853, Integrator, Model, State};
/// struct Ball(Restitution); // q'' = -1 above a floor at q = 0
/// impl Model for Ball {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) { a[0] = -1.0; }
///     fn offers(&self) -> Offers<'_> { Offers { stops: &[[true, false]], ..Offers::default() } }
///     fn contacts(&self) -> usize { 1 }
///     fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
///         out[0] = Contact { deflection: q[0], rate: v[0], lower: 0.0, ..Contact::default() };
///     }
///     fn impact(&self, _: usize, _: Piece, _: &[f64], _: &[f64], v: &mut [f64]) {
///         v[0] = self.0.rebound(v[0], 0.0);
///     }
/// }
/// let ball = Ball(Restitution::new(0.5)?);
/// // The ball reaches the floor at t = 1 and the top of its rebound at t = 1.5.
/// let end = Dop853::new().end(&ball, &State::new(0.0, &[0.5], &[0.0]), 1.5)?;
/// assert!((end.q[0] - 0.125).abs() < 1e-12 && end.v[0].abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Restitution {
    coefficient: f64,
}

impl Restitution {
    /// Coefficient of restitution e `[1]` in [0, 1]. On a stop at rest an impact with e = 1 conserves the
    /// energy; e = 0 gives the largest loss.
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] for a coefficient outside [0, 1]; [`ParameterError::NotFinite`] for a
    /// NaN or an infinity.
    pub fn new(coefficient: f64) -> Result<Self, ParameterError> {
        let name = "restitution";
        if (0.0..=1.0).contains(&coefficient) {
            return Ok(Restitution { coefficient });
        }
        check::finite(name, coefficient)?;
        Err(ParameterError::OutOfRange { name: name.into(), value: coefficient, allowed: "[0, 1]" })
    }
    /// Coefficient of restitution e `[1]`.
    pub fn coefficient(&self) -> f64 {
        self.coefficient
    }
    /// v⁺ = w - e (v - w): the velocity after an impact on a stop that moves at the velocity w. The
    /// deflection must be a coordinate; otherwise use [`impulse`](Restitution::impulse).
    pub fn rebound<S: Scalar>(&self, v: S, w: S) -> S {
        w - (v - w) * self.coefficient
    }
    /// v⁺ = v - (1 + e) s/(bᵀm) m: the velocities after an impact of a deflection d that depends on several
    /// coordinates.
    ///
    /// s = d' - w is the rate of the deflection relative to the edge before the impact, b = ∂d/∂q and
    /// m = M⁻¹ b with the mass matrix M. Friction along the stop is neglected.   Source: Pfeiffer & Glocker,
    /// Multibody Dynamics with Unilateral Contacts, Sect. 8.1.
    ///
    /// ```
    /// use gear_dynamics::contact::Restitution;
    /// let mut v = [3.0, 0.0]; // masses 1 and 2, d = q1 - q2: momentum 3 and energy 4.5 are conserved
    /// Restitution::new(1.0)?.impulse(3.0, &[1.0, -1.0], &[1.0, -0.5], &mut v);
    /// assert_eq!(v, [-1.0, 2.0]);
    /// # Ok::<(), gear_dynamics::ParameterError>(())
    /// ```
    ///
    /// # Panics
    /// If b, m and v differ in length.
    pub fn impulse<S: Scalar>(&self, s: S, b: &[S], m: &[S], v: &mut [S]) {
        assert!(
            b.len() == m.len() && m.len() == v.len(),
            "b, m and v have {}, {} and {} entries: their lengths must be equal",
            b.len(),
            m.len(),
            v.len()
        );
        let along = b.iter().zip(m).fold(S::from(0.0), |sum, (b, m)| sum + *b * *m);
        let share = s * (1.0 + self.coefficient) / along;
        v.iter_mut().zip(m).for_each(|(v, m)| *v = *v - share * *m);
    }
}
