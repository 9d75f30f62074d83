//! The instantaneous centre of a noncircular gear.

use crate::error::{ParameterError, check};
use crate::excitation::angle::Angle;
use crate::excitation::excitation_trait::Excitation;
use crate::excitation::jet::Jet;
use crate::numeric::sine::turned;
use crate::scalar::Scalar;

/// The instantaneous centre of an eccentric gear with the eccentric ratio ε `[1]`, over the phase x `[rad]`.
///
/// All curves have exact first and second derivatives.   Source: Liu 2021, Eqs. (8), (18), (20), corrected
/// ([errata](crate::guide::errata)).
///
/// ```
/// use gear_dynamics::excitation::{Excitation, InstantCentre};
/// let centre = InstantCentre::new(0.2)?;
/// assert!((centre.radius(1.0)?.value(0.0) - (1.0 + 0.4 / 1.04)).abs() < 1e-15);
/// assert!((centre.ratio(3.5)?.value(0.0) - 5.25).abs() < 1e-14);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstantCentre {
    eccentric: f64,
}

impl InstantCentre {
    /// Eccentric ratio ε `[1]` in [0, 0.999999].
    ///
    /// # Errors
    /// An eccentric ratio outside [0, 0.999999].
    pub fn new(eccentric: f64) -> Result<Self, ParameterError> {
        Ok(InstantCentre { eccentric: Self::check_ratio("eccentric ratio", eccentric)? })
    }

    /// Checks that 0 <= ε <= 0.999999, so that rounding does not spoil 1 - 2 ε + ε².
    pub(crate) fn check_ratio(name: &str, eccentric: f64) -> Result<f64, ParameterError> {
        match check::fraction(name, eccentric)? {
            value if value > 0.999_999 => {
                Err(ParameterError::OutOfRange { name: name.into(), value, allowed: "[0, 0.999999]" })
            }
            value => Ok(value),
        }
    }

    /// β = 2 ε/(1 + ε²) `[1]`: relative amplitude of the base radius.
    pub fn beta(&self) -> f64 {
        2.0 * self.eccentric / (1.0 + self.eccentric * self.eccentric)
    }

    fn curve(self, kind: CurveKind) -> CentreCurve {
        CentreCurve { centre: self, kind }
    }

    /// Base radius r = L (1 + β cos x) with the mean L, in the unit of L.   Source: Liu 2021, Eq. (8) with
    /// ω_c for ω_e.
    ///
    /// # Errors
    /// A mean radius outside 1e-50 .. 1e50.
    pub fn radius(self, mean: f64) -> Result<CentreCurve, ParameterError> {
        Ok(self.curve(CurveKind::Radius(check::scale("mean radius", mean)?)))
    }
    /// Ratio i = i_j (1 + 2 ε cos x + ε²)/(1 - ε²) `[1]` with the reduction ratio i_j.   Source: Liu 2021,
    /// Eq. (18).
    ///
    /// # Errors
    /// A reduction ratio outside 1e-50 .. 1e50.
    pub fn ratio(self, reduction: f64) -> Result<CentreCurve, ParameterError> {
        Ok(self.curve(CurveKind::Ratio(check::scale("reduction ratio", reduction)?)))
    }
    /// Rotation of the driven gear in rigid motion: dθ/dx = (1 - ε²)/(1 + 2 ε cos x + ε²) `[1]`.
    ///
    /// Its derivative d²θ/dx² = 2 ε (1 - ε²) sin x/(1 + 2 ε cos x + ε²)² is the centre forcing:
    /// θ'' = (d²θ/dx²) x'² + (dθ/dx) x''.   Source: Liu 2021, Eq. (20), corrected.
    // Erratum (docs/errata.md): Eq. (20) as printed lacks both squares.
    pub fn rotation(self) -> CentreCurve {
        self.curve(CurveKind::Rotation)
    }
    /// The Fourier series of [`rotation`](InstantCentre::rotation): 1 + 2 Σ_{n=1}^{order} (-ε)^n cos n x.
    /// Order 2 gives Liu 2021, Eq. (22). Orders with ε^n < 1e-60 are left out: they change no digit, nor do
    /// their derivatives.
    ///
    /// # Errors
    /// An order above 10 000, because every evaluation sums all orders.
    pub fn rotation_series(self, order: usize) -> Result<CentreCurve, ParameterError> {
        let order = check::count("order of the forcing series", &[order], check::ORDERS)?;
        let seen = (libm::log(NEGLIGIBLE) / libm::log(self.eccentric.abs())).ceil();
        Ok(self.curve(CurveKind::Series(order.min(seen as usize))))
    }
}

/// Size of an order of the forcing series that changes no digit `[1]`.
const NEGLIGIBLE: f64 = 1e-60;

/// One curve of an [`InstantCentre`].
///
/// ```
/// use gear_dynamics::excitation::{Excitation, InstantCentre};
/// let centre = InstantCentre::new(0.2)?;
/// let (exact, series) = (centre.rotation(), centre.rotation_series(40)?);
/// assert!((exact.jet(0.3).rate - series.jet(0.3).rate).abs() < 1e-14); // the centre forcing
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentreCurve {
    centre: InstantCentre,
    kind: CurveKind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum CurveKind {
    Radius(f64),
    Ratio(f64),
    Rotation,
    Series(usize),
}

impl CentreCurve {
    /// The curve for every number type.
    #[inline(always)]
    fn curve<S: Scalar>(&self, angle: S) -> Jet<S> {
        // Constants in numbers S, so that an interval contains their rounding.
        let (eps, one) = (S::from(self.centre.eccentric), S::from(1.0));
        let times = |jet: Jet<S>, by: S| Jet::new(jet.value * by, jet.rate * by, jet.second * by);
        let plus = |jet: Jet<S>, by: S| Jet { value: jet.value + by, ..jet };
        let (sin, cos) = Jet::variable(angle).sin_cos();
        let swing = || plus(times(cos, eps * 2.0), one + eps * eps);
        match self.kind {
            CurveKind::Radius(mean) => {
                let beta = eps * 2.0 / (one + eps * eps);
                plus(times(cos, beta), one) * mean
            }
            CurveKind::Ratio(reduction) => times(swing(), S::from(reduction) / (one - eps * eps)),
            CurveKind::Rotation => Jet::constant(one - eps * eps) / swing(),
            CurveKind::Series(order) => {
                let mut sum = Jet::constant(one);
                let (mut s, mut c) = (sin, cos);
                let mut power = -eps;
                for _ in 1..=order {
                    sum = sum + times(c, power * 2.0);
                    power = power * -eps;
                    (s, c) = turned((s, c), (sin, cos));
                }
                sum
            }
        }
    }
}

impl Excitation for CentreCurve {
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
        self.curve(angle.number())
    }
}
