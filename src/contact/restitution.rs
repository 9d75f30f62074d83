//! Rigid stops: the velocities jump where a contact meets an edge.

use crate::error::{ParameterError, check};

/// Newton's law of restitution: a contact leaves a rigid stop with -e times the speed at which it met it, 0 <= e <= 1.
///
/// For [`Model::impact`](crate::Model::impact). A contact that comes to rest on its stop ends a run with
/// [`IntegrateError::RestsOnStop`](crate::ode::IntegrateError::RestsOnStop): with e < 1 after impacts without number, with e = 0 at once, unless
/// the stop moves away.
///
/// ```
/// use gear_dynamics::{contact::{Contact, Piece, Restitution}, Dop853, Integrator, Model, State};
/// struct Ball(Restitution); // q'' = -1 above a floor at q = 0
/// impl Model for Ball {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) { a[0] = -1.0; }
///     fn contacts(&self) -> usize { 1 }
///     fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
///         out[0] = Contact { deflection: q[0], rate: v[0], lower: 0.0, ..Contact::default() };
///     }
///     fn impact(&self, _: usize, _: Piece, _: &[f64], _: &[f64], v: &mut [f64]) -> bool {
///         v[0] = self.0.rebound(v[0], 0.0);
///         true
///     }
/// }
/// let ball = Ball(Restitution::new(0.5)?);
/// let end = Dop853::new().end(&ball, &State::new(0.0, &[0.5], &[0.0]), 1.5)?; // meets the floor at t = 1, is on top at t = 1.5
/// assert!((end.q[0] - 0.125).abs() < 1e-12 && end.v[0].abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Restitution {
    coefficient: f64,
}

impl Restitution {
    /// Coefficient e `[1]`: 1 keeps the energy, 0 all that the stop can take away is lost.
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] outside [0, 1].
    pub fn new(coefficient: f64) -> Result<Self, ParameterError> {
        let name = "restitution";
        if (0.0..=1.0).contains(&coefficient) {
            return Ok(Restitution { coefficient });
        }
        check::finite(name, coefficient)?;
        Err(ParameterError::OutOfRange { name: name.into(), value: coefficient, allowed: "[0, 1]" })
    }
    /// e.
    pub fn coefficient(&self) -> f64 {
        self.coefficient
    }
    /// v⁺ = w - e (v - w): the speed after an impact on a stop that moves at w, for a deflection that is a coordinate.
    pub fn rebound(&self, v: f64, w: f64) -> f64 {
        w - self.coefficient * (v - w)
    }
    /// v⁺ = v - (1 + e) s/(bᵀm) m: the velocities after an impulse along a contact of any direction.
    ///
    /// s = d' - w: the rate of the deflection over the edge before the impact; b = ∂d/∂q; m = M⁻¹ b, M the mass matrix. Friction along the
    /// stop is left out.   Source: Pfeiffer & Glocker, Multibody Dynamics with Unilateral Contacts, Sect. 8.1.
    ///
    /// ```
    /// use gear_dynamics::contact::Restitution;
    /// let mut v = [3.0, 0.0]; // masses 1 and 2, d = q1 - q2: momentum 3 and energy 4.5 stay
    /// Restitution::new(1.0)?.impulse(3.0, &[1.0, -1.0], &[1.0, -0.5], &mut v);
    /// assert_eq!(v, [-1.0, 2.0]);
    /// # Ok::<(), gear_dynamics::ParameterError>(())
    /// ```
    /// # Panics
    /// If b, m and v differ in length, or no velocity is moved by the impulse: bᵀm = 0.
    pub fn impulse(&self, s: f64, b: &[f64], m: &[f64], v: &mut [f64]) {
        assert!(
            b.len() == m.len() && m.len() == v.len(),
            "lists of {}, {} and {} numbers",
            b.len(),
            m.len(),
            v.len()
        );
        let along: f64 = b.iter().zip(m).map(|(b, m)| b * m).sum();
        assert!(along > 0.0, "bᵀm is {along}: it must be positive");
        let share = (1.0 + self.coefficient) * s / along;
        v.iter_mut().zip(m).for_each(|(v, m)| *v -= share * m);
    }
}
