//! Floquet multipliers, and the stability that follows from them.

use crate::error::{ParameterError, check};
use crate::ode::Exhausted;
use nalgebra::DMatrix;
use num_complex::Complex64;
use thiserror::Error;

/// Stability of an orbit, from its Floquet multipliers and their error.
///
/// ```
/// use gear_dynamics::periodic::{Multipliers, Stability};
/// use num_complex::Complex64;
/// let with_error = |error| Multipliers::new(vec![Complex64::new(-0.9, 0.0)], error);
/// assert_eq!(with_error(0.01).largest(), 0.9);
/// assert_eq!(with_error(0.01).stability(), Stability::Stable);
/// assert_eq!(with_error(0.2).stability(), Stability::Undecided);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Stability {
    /// The largest |μ| is less than 1 by more than its error.
    Stable,
    /// The largest |μ| is greater than 1 by more than its error.
    Unstable,
    /// The largest |μ| differs from 1 by no more than its error.
    Undecided,
}

impl std::fmt::Display for Stability {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Stability::Stable => "stable",
            Stability::Unstable => "unstable",
            Stability::Undecided => "undecided",
        })
    }
}

/// The reasons why [`Balance::multipliers`](crate::Balance::multipliers) fails.
///
/// ```
/// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, Periodic};
/// use gear_dynamics::periodic::FourierOrbit;
/// let (pair, orders) = (NfgPair::new(&NfgParams::table1())?, Harmonics::up_to(0));
/// let two = FourierOrbit::new(&orders, pair.period(), &[vec![0.0], vec![0.0]])?;
/// let error = Balance::new(orders).multipliers(&pair, &two).unwrap_err();
/// assert_eq!(error.to_string(), "coordinates of the orbit has 2 entries: 1 are needed");
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MultiplierError {
    /// The orbit is one of another model, or the monodromy matrix has no finite eigenvalues.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The model has a rigid stop, at which the linearised motion jumps. [`Shooting`](crate::Shooting)
    /// computes that jump.
    #[error("contact {contact} has a rigid stop, at which the linearised motion jumps: use Shooting")]
    RigidStop {
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// A contact rests on an edge of its gap where the slope of the accelerations jumps.
    #[error(
        "contact {contact} rests on an edge of its gap, where the slope of the accelerations jumps: the motion has two \
         one-sided derivatives and no multipliers"
    )]
    RestsOnEdge {
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// The orbit has too many crossings and drive edges.
    #[error("the orbit has {count} crossings and drive edges: at most {max} are allowed")]
    Breaks {
        /// Number of crossings and drive edges.
        count: usize,
        /// Maximum number.
        max: usize,
    },
    /// A slope of the model is not finite along the orbit.
    #[error("a derivative of the accelerations is not finite after t = {t:?}")]
    Slope {
        /// Start time of the step.
        t: f64,
    },
    /// The equations of a step are singular.
    #[error("the equations of the step from t = {t:?} are singular")]
    Singular {
        /// Start time of the step.
        t: f64,
    },
    /// The [`Budget`](crate::Budget) is spent, or the call was cancelled.
    #[error("the multipliers were not computed: {0}")]
    Exhausted(#[from] Exhausted),
}

/// Floquet multipliers μ of an orbit, the eigenvalues of its monodromy matrix: a small difference grows by μ
/// in one period of the orbit. They are sorted by |μ|, the largest first, and have an estimate of their
/// error.
///
/// ```
/// use gear_dynamics::periodic::{Multipliers, Stability};
/// let turn = nalgebra::DMatrix::from_row_slice(2, 2, &[0.0, 0.5, -0.5, 0.0]);
/// let multipliers = Multipliers::of_monodromy(&turn, 1e-9)?;
/// assert!((multipliers.values()[0].im.abs() - 0.5).abs() < 1e-15);
/// assert_eq!(multipliers.stability(), Stability::Stable);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Multipliers {
    values: Vec<Complex64>,
    error: f64,
}

/// 2^511: squares of entries up to this value, and sums of a few squares, do not overflow.
const LARGE: f64 = 6.703_903_964_971_299e153;

impl Multipliers {
    /// Multipliers from given values and their error, of which the absolute value is taken.
    pub fn new(mut values: Vec<Complex64>, error: f64) -> Self {
        // Conjugates stay adjacent, the one with positive imaginary part first.
        values.sort_by(|a, b| b.norm().total_cmp(&a.norm()).then(b.im.total_cmp(&a.im)));
        Multipliers { values, error: error.abs() }
    }

    /// Eigenvalues of a monodromy matrix, with a given error.
    ///
    /// # Errors
    /// A matrix that is not square; an entry that is not finite; an error that is NaN; eigenvalues that
    /// overflow.
    pub fn of_monodromy(monodromy: &DMatrix<f64>, error: f64) -> Result<Self, ParameterError> {
        check::length("columns of the monodromy matrix", monodromy.ncols(), monodromy.nrows())?;
        check::all_finite("monodromy matrix", monodromy.as_slice())?;
        if error.is_nan() {
            return Err(ParameterError::NotFinite { name: "error of the multipliers".into(), value: error });
        }
        Multipliers::eigenvalues(monodromy, error).ok_or_else(|| ParameterError::Overflow {
            name: "eigenvalues of the monodromy matrix".into(),
            value: monodromy.amax(),
        })
    }

    fn eigenvalues(monodromy: &DMatrix<f64>, error: f64) -> Option<Self> {
        if monodromy.iter().any(|x| x.abs() > LARGE) {
            // Division by a power of two is exact, and the squares of the quotients do not overflow.
            let scaled = Multipliers::eigenvalues(&(monodromy / LARGE), error)?;
            let values: Vec<Complex64> = scaled.values().iter().map(|value| value * LARGE).collect();
            return values.iter().all(|value| value.is_finite()).then(|| Multipliers::new(values, error));
        }
        if let &[a, c, b, d] = monodromy.as_slice() {
            // One degree of freedom: roots of λ² - (a + d) λ + (a d - b c). The smaller root is the product
            // of the roots over the larger one, which avoids cancellation.
            let (mean, bend) = (0.5 * (a + d), 0.25 * (a - d) * (a - d) + b * c);
            let values = if bend < 0.0 {
                vec![Complex64::new(mean, (-bend).sqrt()), Complex64::new(mean, -(-bend).sqrt())]
            } else {
                let larger = mean + bend.sqrt().copysign(mean);
                let smaller = if larger == 0.0 { 0.0 } else { (a * d - b * c) / larger };
                vec![larger.into(), smaller.into()]
            };
            return Some(Multipliers::new(values, error));
        }
        let matrix = faer::Mat::from_fn(monodromy.nrows(), monodromy.ncols(), |i, j| monodromy[(i, j)]);
        let values = matrix.eigenvalues().ok()?;
        Some(Multipliers::new(values.iter().map(|l| Complex64::new(l.re, l.im)).collect(), error))
    }

    /// Eigenvalues of a monodromy matrix without those of the rigid modes.
    ///
    /// The columns of `rigid` are r along the coordinates and r along the velocities. The flow maps their
    /// span into itself with multipliers 1, 1. The span is projected out.
    pub(crate) fn without(
        monodromy: &DMatrix<f64>,
        rigid: &DMatrix<f64>,
        error: f64,
    ) -> Result<Self, ParameterError> {
        if rigid.ncols() == 0 {
            return Multipliers::of_monodromy(monodromy, error);
        }
        // [R Z] is orthogonal and the span of R is invariant: Zᵀ M Z has the other eigenvalues.
        let (m, k) = rigid.shape();
        let mut basis = DMatrix::identity(m, m);
        rigid.clone().qr().q_tr_mul(&mut basis);
        let z = basis.rows(k, m - k).transpose();
        Multipliers::of_monodromy(&(z.transpose() * monodromy * z), error)
    }

    /// All multipliers, the largest |μ| first.
    pub fn values(&self) -> &[Complex64] {
        &self.values
    }
    /// Largest |μ|; 0 if there are no multipliers.
    pub fn largest(&self) -> f64 {
        self.values.first().map_or(0.0, |m| m.norm())
    }
    /// Estimated error of each value.
    pub fn value_error(&self) -> f64 {
        self.error
    }
    /// The same multipliers with another error.
    pub(crate) fn with_error(self, error: f64) -> Self {
        Multipliers { error: error.abs(), ..self }
    }

    /// The same multipliers with their distance from rougher ones as the error; infinite without these.
    pub(crate) fn compared_with(self, rougher: Option<Self>) -> Self {
        let error = rougher.map_or(f64::INFINITY, |rougher| self.distance(&rougher));
        self.with_error(error)
    }

    /// Compares the largest |μ| with 1, with regard to its error.
    pub fn stability(&self) -> Stability {
        match self.largest() {
            largest if largest + self.error < 1.0 => Stability::Stable,
            largest if largest - self.error > 1.0 => Stability::Unstable,
            _ => Stability::Undecided,
        }
    }

    /// ln|μ|/T: exponential rate of growth of each multiplier; T is the period of the orbit.
    pub fn growth(&self, period: f64) -> Vec<f64> {
        self.values.iter().map(|m| m.norm().ln() / period).collect()
    }

    /// Whether those of a point, `other`, are these of its orbit.
    pub(crate) fn check_same(&self, other: &Multipliers) -> Result<(), ParameterError> {
        /// Largest difference of two multipliers that count as equal, as a share of the largest one `[1]`: a
        /// file of decimal numbers may round them.
        const SLACK: f64 = 1e-9;
        check::length("multipliers of a point", other.values.len(), self.values.len())?;
        let (value, most) = (self.distance(other), SLACK * self.largest());
        if value > most {
            let name = "distance of a multiplier of a point from that of its orbit".into();
            return Err(ParameterError::Wrong { name, value, must: format!("be at most {most:?}") });
        }
        // Errors that were not computed are infinite, and their difference is NaN.
        let is_same =
            self.error == other.error || (self.error - other.error).abs() <= SLACK * self.error.min(f64::MAX);
        if !is_same {
            let (name, found) = ("error of the multipliers of a point".into(), other.error);
            return Err(ParameterError::Inconsistent { name, found, expected: self.error });
        }
        Ok(())
    }

    /// Largest distance of a multiplier from its partner in another set. Each multiplier is paired with the
    /// nearest one that is left. Infinite if the other set is smaller.
    pub(crate) fn distance(&self, other: &Self) -> f64 {
        let mut left = other.values.clone();
        self.values.iter().fold(0.0, |worst: f64, a| {
            let nearest =
                (0..left.len()).min_by(|&i, &j| (left[i] - a).norm().total_cmp(&(left[j] - a).norm()));
            nearest.map_or(f64::INFINITY, |i| worst.max((left.swap_remove(i) - a).norm()))
        })
    }
}
