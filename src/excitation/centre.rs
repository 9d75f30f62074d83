//! The instantaneous centre of a noncircular gear.

use super::{Excitation, Jet, Repeats};
use crate::error::{ParameterError, check};
use crate::piece::Side;
use std::f64::consts::TAU;

/// The moving instantaneous centre of an eccentric gear: ε its eccentric ratio, x = ω_c t its phase.
///
/// All curves carry exact first and second derivatives.   Source: Liu 2021, Eqs. (8), (18), (20), corrected.
///
/// ```
/// use gear_dynamics::{Excitation, InstantCentre, Side};
/// let centre = InstantCentre::new(0.2, 1.0)?;
/// assert!((centre.radius(1.0)?.value(0.0, Side::After) - (1.0 + 0.4 / 1.04)).abs() < 1e-15);
/// assert!((centre.ratio(3.5)?.value(0.0, Side::After) - 5.25).abs() < 1e-14);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstantCentre {
    eccentric: f64,
    omega: f64,
}

impl InstantCentre {
    /// Eccentric ratio ε in [0, 1) and frequency ω_c [rad/s].
    ///
    /// # Errors
    /// An eccentric ratio outside [0, 0.999999]; a frequency outside 1e-50 .. 1e50.
    pub fn new(eccentric: f64, omega: f64) -> Result<Self, ParameterError> {
        // The second derivative of the forcing holds ω_c⁴ and (1 - ε)⁻⁸.
        Ok(InstantCentre {
            eccentric: Self::check_ratio("eccentric ratio", eccentric)?,
            omega: check::scale("frequency of the centre", omega)?,
        })
    }

    /// An eccentric ratio so far from 1 that 1 - 2 ε + ε² is not lost in rounding.
    pub(crate) fn check_ratio(name: &str, eccentric: f64) -> Result<f64, ParameterError> {
        match check::fraction(name, eccentric)? {
            value if value > 0.999_999 => Err(ParameterError::OutOfRange { name: name.into(), value, allowed: "[0, 0.999999]" }),
            value => Ok(value),
        }
    }

    /// β = 2 ε/(1 + ε²): the change rate of the base radius.
    pub fn beta(&self) -> f64 {
        2.0 * self.eccentric / (1.0 + self.eccentric * self.eccentric)
    }

    fn curve(self, kind: Kind) -> CentreCurve {
        CentreCurve { centre: self, kind }
    }

    /// r(t) = L (1 + β cos x), L its mean.   Liu 2021, Eq. (8) with ω_c for ω_e.
    ///
    /// # Errors
    /// A mean radius outside 1e-50 .. 1e50.
    pub fn radius(self, mean: f64) -> Result<CentreCurve, ParameterError> {
        Ok(self.curve(Kind::Radius(check::scale("mean radius", mean)?)))
    }
    /// i(t) = i_j (1 + 2 ε cos x + ε²)/(1 - ε²), i_j the reduction ratio.   Liu 2021, Eq. (18).
    ///
    /// # Errors
    /// A reduction ratio outside 1e-50 .. 1e50.
    pub fn ratio(self, reduction: f64) -> Result<CentreCurve, ParameterError> {
        Ok(self.curve(Kind::Ratio(check::scale("reduction ratio", reduction)?)))
    }
    /// θ'' = 2 ω_c² ε (1 - ε²) sin x/(1 + 2 ε cos x + ε²)²: the acceleration of the rigid motion.
    // Erratum (docs/errata.md): Eq. (20) as printed lacks both squares.
    pub fn forcing(self) -> CentreCurve {
        self.curve(Kind::Forcing)
    }
    /// The Fourier series of [`forcing`](InstantCentre::forcing): -2 ω_c² Σ_{n=1}^{order} n (-ε)^n sin n x. Order 2 is Eq. (22).
    ///
    /// # Errors
    /// An order above 10 000: every one of them is summed at every evaluation.
    pub fn forcing_series(self, order: usize) -> Result<CentreCurve, ParameterError> {
        Ok(self.curve(Kind::Series(check::count("order of the forcing series", &[order], check::ORDERS)?)))
    }
}

/// One curve of an [`InstantCentre`].
///
/// ```
/// use gear_dynamics::{Excitation, InstantCentre, Side};
/// let centre = InstantCentre::new(0.2, 2.0)?;
/// let (exact, series) = (centre.forcing(), centre.forcing_series(40)?);
/// assert!((exact.value(0.3, Side::After) - series.value(0.3, Side::After)).abs() < 1e-14);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentreCurve {
    centre: InstantCentre,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Radius(f64),
    Ratio(f64),
    Forcing,
    Series(usize),
}

impl Excitation for CentreCurve {
    fn jet(&self, t: f64, _: Side) -> Jet {
        let InstantCentre { eccentric: eps, omega } = self.centre;
        let (sin, cos) = Jet::new(omega * t, omega, 0.0).sin_cos();
        let swing = || cos * (2.0 * eps) + (1.0 + eps * eps);
        match self.kind {
            Kind::Radius(mean) => (cos * self.centre.beta() + 1.0) * mean,
            Kind::Ratio(reduction) => swing() * (reduction / (1.0 - eps * eps)),
            Kind::Forcing => sin * (2.0 * omega * omega * eps * (1.0 - eps * eps)) / (swing() * swing()),
            Kind::Series(order) => {
                let mut sum = Jet::constant(0.0);
                let (mut s, mut c) = (sin, cos);
                let mut power = -eps;
                for n in 1..=order {
                    sum = sum + s * (-2.0 * omega * omega * n as f64 * power);
                    power *= -eps;
                    (s, c) = (s * cos + c * sin, c * cos - s * sin);
                }
                sum
            }
        }
    }
    fn repeats(&self) -> Repeats {
        Repeats::Every(TAU / self.centre.omega)
    }
}
