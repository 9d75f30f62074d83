//! Floquet multipliers and what they say.

use nalgebra::DMatrix;
use num_complex::Complex64;

/// What the multipliers say of an orbit.
///
/// ```
/// use gear_dynamics::periodic::{Multipliers, Stability};
/// use num_complex::Complex64;
/// let with_error = |error| Multipliers::new(vec![Complex64::new(-0.9, 0.0)], error);
/// assert_eq!(with_error(0.01).largest(), 0.9);
/// assert_eq!([0.01, 0.2].map(|error| with_error(error).stability()), [Stability::Stable, Stability::Undecided]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stability {
    /// Every multiplier lies inside the unit circle by more than its error.
    Stable,
    /// One lies outside by more than its error.
    Unstable,
    /// The largest is as close to the circle as its error.
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

/// Floquet multipliers μ: over one period of an orbit a small difference grows by μ. Sorted by modulus, the largest first, with an
/// estimate of their error.
///
/// ```
/// use gear_dynamics::periodic::{Multipliers, Stability};
/// let turn = nalgebra::DMatrix::from_row_slice(2, 2, &[0.0, 0.5, -0.5, 0.0]);
/// let multipliers = Multipliers::of(&turn, 1e-9).ok_or("not finite")?;
/// assert!((multipliers.values()[0].im.abs() - 0.5).abs() < 1e-15);
/// assert_eq!(multipliers.stability(), Stability::Stable);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Multipliers {
    values: Vec<Complex64>,
    error: f64,
}

/// 2^511: squares of entries up to it, and sums of a few of them, do not overflow.
const LARGE: f64 = 6.703_903_964_971_299e153;

impl Multipliers {
    /// From the multipliers themselves, however they were found, and their error.
    pub fn new(mut values: Vec<Complex64>, error: f64) -> Self {
        // Conjugates side by side, the upper half plane first.
        values.sort_by(|a, b| b.norm().total_cmp(&a.norm()).then(b.im.total_cmp(&a.im)));
        Multipliers { values, error: error.abs() }
    }

    /// The eigenvalues of a monodromy matrix, with a given error. `None` when they cannot be found: the matrix is not square, or
    /// an entry or the error is not a number.
    pub fn of(monodromy: &DMatrix<f64>, error: f64) -> Option<Self> {
        if error.is_nan() || !monodromy.is_square() || monodromy.iter().any(|x| !x.is_finite()) {
            return None;
        }
        if monodromy.iter().any(|x| x.abs() > LARGE) {
            // A power of two changes no digit, and squares of what is left do not overflow.
            let scaled = Multipliers::of(&(monodromy / LARGE), error)?;
            let values: Vec<Complex64> = scaled.values().iter().map(|value| value * LARGE).collect();
            return values.iter().all(|value| value.is_finite()).then(|| Multipliers::new(values, error));
        }
        if let &[a, c, b, d] = monodromy.as_slice() {
            // One degree of freedom: the roots of λ² - (a + d) λ + (a d - b c), the larger first, the other from the product.
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

    /// The eigenvalues of a monodromy matrix that do not belong to rigid modes: r along the coordinates and r along the velocities, which
    /// the flow maps into each other with multipliers 1, 1, are projected out.
    pub(crate) fn without(monodromy: &DMatrix<f64>, rigid: &DMatrix<f64>, error: f64) -> Option<Self> {
        if rigid.ncols() == 0 {
            return Multipliers::of(monodromy, error);
        }
        // [R Z] orthogonal: R is invariant, so that Zᵀ M Z has the rest of the spectrum.
        let (m, k) = rigid.shape();
        let mut basis = DMatrix::identity(m, m);
        rigid.clone().qr().q_tr_mul(&mut basis);
        let z = basis.rows(k, m - k).transpose();
        Multipliers::of(&(z.transpose() * monodromy * z), error)
    }

    /// All of them, the largest modulus first.
    pub fn values(&self) -> &[Complex64] {
        &self.values
    }
    /// The largest modulus; 0 when there are none.
    pub fn largest(&self) -> f64 {
        self.values.first().map_or(0.0, |m| m.norm())
    }
    /// How far each may be off.
    pub fn error(&self) -> f64 {
        self.error
    }
    /// The same with another error.
    pub fn with_error(self, error: f64) -> Self {
        Multipliers { error: error.abs(), ..self }
    }

    /// Whether the largest lies inside the unit circle, outside, or too close to say.
    pub fn stability(&self) -> Stability {
        match self.largest() {
            largest if largest + self.error < 1.0 => Stability::Stable,
            largest if largest - self.error > 1.0 => Stability::Unstable,
            _ => Stability::Undecided,
        }
    }

    /// ln|μ|/T: the growth per time of each, T the period of the orbit.
    pub fn growth(&self, period: f64) -> Vec<f64> {
        self.values.iter().map(|m| m.norm().ln() / period).collect()
    }

    /// The largest distance of a multiplier from its partner in another set, paired greedily.
    pub(crate) fn distance(&self, other: &Self) -> f64 {
        let mut left = other.values.clone();
        self.values.iter().fold(0.0, |worst: f64, a| {
            let nearest =
                (0..left.len()).min_by(|&i, &j| (left[i] - a).norm().total_cmp(&(left[j] - a).norm()));
            nearest.map_or(f64::INFINITY, |i| worst.max((left.swap_remove(i) - a).norm()))
        })
    }
}
