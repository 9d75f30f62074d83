//! Models of one formula.

use crate::error::{ParameterError, check};
use crate::model::equations::{Model, Periodic};

/// q'' = f(t, q, q'): the model of one formula, with `dof` coordinates. `accel(t, q, v, a)` writes q'' to
/// `a`, which holds NaN before: a coordinate that is forgotten, or added to, is an error of the run.
///
/// Contacts, jumps and exact derivatives need a [`Model`] or a [`Shape`](crate::Shape) of your own.
///
/// # Errors
/// No coordinate, or more than 2²⁵.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, State, model::from_fn};
/// let fall = from_fn(1, |_, _, v, a| a[0] = 1.0 - v[0])?; // q'' = 1 - q'
/// let end = Dop853::new().end(&fall, &State::at_rest(1), 2.0)?;
/// assert!((end.v[0] - (1.0 - (-2f64).exp())).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn from_fn<F>(dof: usize, accel: F) -> Result<Formula<F>, ParameterError>
where
    F: Fn(f64, &[f64], &[f64], &mut [f64]),
{
    let name = "degrees of freedom";
    if dof == 0 {
        return Err(ParameterError::TooFew { name: name.into(), value: 0, min: 1 });
    }
    check::count(name, &[dof], check::NUMBERS / 2)?;
    Ok(Formula { dof, accel, period: () })
}

/// A model of one formula; see [`from_fn`]. `P`: `f64` with a period, `()` without one.
///
/// ```
/// use gear_dynamics::{Periodic, Shooting, State, model::from_fn};
/// // q'' + 0.1 q' + q = cos 2t
/// let swing = from_fn(1, |t, q, v, a| a[0] = (2.0 * t).cos() - 0.1 * v[0] - q[0])?;
/// let swing = swing.with_period(std::f64::consts::PI)?;
/// let cycle = Shooting::new().solve(&swing, &State::at_rest(1))?;
/// assert!((cycle.states()[0].q[0] + 3.0 / 9.04).abs() < 1e-10); // (1 - Ω²)/((1 - Ω²)² + (0.1 Ω)²)
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Formula<F, P = ()> {
    dof: usize,
    accel: F,
    period: P,
}

impl<F, P> Formula<F, P> {
    /// The formula as a [`Periodic`] model: it repeats in t after the period T.
    ///
    /// # Errors
    /// A period outside 1e-50 .. 1e50.
    pub fn with_period(self, period: f64) -> Result<Formula<F, f64>, ParameterError> {
        Ok(Formula { dof: self.dof, accel: self.accel, period: check::scale("period", period)? })
    }
}

impl<F: Fn(f64, &[f64], &[f64], &mut [f64]), P> Model for Formula<F, P> {
    fn dof(&self) -> usize {
        self.dof
    }
    #[inline]
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a.fill(f64::NAN);
        (self.accel)(u[0], q, v, a);
    }
}

impl<F: Fn(f64, &[f64], &[f64], &mut [f64])> Periodic for Formula<F, f64> {
    fn period(&self) -> f64 {
        self.period
    }
}
