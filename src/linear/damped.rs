//! Eigenvalues of the damped model, with their rounding errors.

use crate::linear::spectrum::{Found, completed, left_vectors};
use faer::Mat;
use nalgebra::DMatrix;
use num_complex::Complex64;

/// An eigenvalue λ with Im λ > 0.
pub(crate) struct Damped {
    pub(crate) value: Complex64,
    /// Estimate of its error by rounding, as a share of |λ| `[1]`.
    pub(crate) rounding: f64,
}

/// The equations p'' = -A p + V p' in coordinates along the modes.
struct Equations {
    /// A without its columns of zeros, those of the rigid motions, which are the last ones.
    a: DMatrix<f64>,
    v: DMatrix<f64>,
    /// Errors of the entries of A and V.
    errors: [DMatrix<f64>; 2],
    /// Units of the coordinates p, without the rigid motions, in the unit of p' `[1/time]`.
    weights: Vec<f64>,
}

/// The eigenvalues λ with Im λ > 0 of x'' = ∂a/∂q x + ∂a/∂v x', in the order of |λ|.
///
/// `modes` are those of ∂a/∂q, and `inertias` those of a symmetric stiffness. `rounding` is the relative
/// error of the entries of both matrices. The result is `None` if the eigenvalues do not converge.
pub(crate) fn of(
    [q, v]: [&DMatrix<f64>; 2],
    modes: &[Found],
    inertias: Option<&[f64]>,
    rounding: f64,
) -> Option<Vec<Damped>> {
    match inertias {
        Some(m) => along_modes(v, modes, m, rounding),
        None => along_any(q, v, modes, rounding),
    }
    .eigenvalues(rounding)
}

/// The equations in coordinates along the modes, of unit inertia. A is diagonal.
fn along_modes(v: &DMatrix<f64>, modes: &[Found], m: &[f64], rounding: f64) -> Equations {
    let n = m.len();
    let product = |x: &[f64], y: &[f64]| -> f64 { (0..n).map(|j| x[j] * m[j] * y[j]).sum() };
    let (rigid, elastic): (Vec<&Found>, Vec<&Found>) = modes.iter().partition(|mode| mode.rigid);
    let mut basis: Vec<Vec<f64>> = elastic.iter().chain(&rigid).map(|mode| mode.shape.clone()).collect();
    for i in 0..n {
        for other in elastic.len()..i {
            let along = product(&basis[other], &basis[i]);
            let (before, rest) = basis.split_at_mut(i);
            rest[0].iter_mut().zip(&before[other]).for_each(|(x, y)| *x -= along * y);
        }
        let size = product(&basis[i], &basis[i]).sqrt();
        basis[i].iter_mut().for_each(|x| *x /= size);
    }
    let shapes = DMatrix::from_fn(n, n, |i, j| basis[j][i]);
    let inverse = DMatrix::from_fn(n, n, |i, j| basis[i][j] * m[j]);
    let error = |i: usize| elastic.get(i).map_or(0.0, |mode| mode.error);
    let of_a = |i: usize, j: usize| (error(i) * error(j)).sqrt();
    let unit = |mode: &&Found| mode.square.abs().max(mode.error).max(f64::MIN_POSITIVE).sqrt();
    Equations {
        a: DMatrix::from_fn(n, elastic.len(), |i, j| if i == j { elastic[j].square } else { 0.0 }),
        v: &inverse * v * &shapes,
        errors: [DMatrix::from_fn(n, elastic.len(), of_a), inverse.abs() * v.abs() * shapes.abs() * rounding],
        weights: elastic.iter().map(unit).collect(),
    }
}

/// The equations in orthonormal coordinates.
fn along_any(q: &DMatrix<f64>, v: &DMatrix<f64>, modes: &[Found], rounding: f64) -> Equations {
    let n = q.nrows();
    let rigid: Vec<Vec<f64>> =
        modes.iter().filter(|mode| mode.rigid).map(|mode| mode.shape.clone()).collect();
    let basis = completed(&rigid, n);
    let (inverse, elastic) = (basis.transpose(), n - rigid.len());
    let weight = [q.amax().sqrt(), v.amax(), 1.0].into_iter().find(|w| *w > 0.0).unwrap_or(1.0);
    let sizes = |x: &DMatrix<f64>| inverse.abs() * x.abs() * basis.abs() * rounding;
    Equations {
        a: -(&inverse * q * &basis).columns(0, elastic).into_owned(),
        v: &inverse * v * &basis,
        errors: [sizes(q).columns(0, elastic).into_owned(), sizes(v)],
        weights: vec![weight; elastic],
    }
}

impl Equations {
    /// The state is (w p) without the rigid motions, and all p'. Rigid motions would give double eigenvalues
    /// 0, which rounding splits into ±√ε.
    ///
    /// The error of λ with M x = λ x and yᵀ M = λ yᵀ is |y|ᵀ E |x|/|yᵀ x|, to first order. E: errors of the
    /// entries of M, and the error of the QR algorithm.
    fn eigenvalues(&self, rounding: f64) -> Option<Vec<Damped>> {
        let Equations { a, v, errors: [of_a, of_v], weights } = self;
        let (n, k) = (a.nrows(), a.ncols());
        let size = n + k;
        if size == 0 {
            return Some(Vec::new());
        }
        let matrix = Mat::from_fn(size, size, |i, j| match (i < k, j < k) {
            (true, true) => 0.0,
            (true, false) => weights[i] * f64::from(u8::from(i == j - k)),
            (false, true) => -a[(i - k, j)] / weights[j],
            (false, false) => v[(i - k, j - k)],
        });
        let error = |i: usize, j: usize| match (i < k, j < k) {
            (true, _) => 0.0,
            (false, true) => of_a[(i - k, j)] / weights[j],
            (false, false) => of_v[(i - k, j - k)],
        };
        let found = matrix.eigen().ok()?;
        let (values, right) = (found.S().column_vector(), found.U());
        // None if an eigenvector was not found: the errors are then not known.
        let left = left_vectors(right);
        let most = values.iter().map(|value| value.norm()).fold(0.0, f64::max);
        let of_algorithm = f64::EPSILON * matrix.norm_l2();
        let share = |c: usize| -> f64 {
            let Some(left) = &left else { return f64::INFINITY };
            let row = |i: usize| -> f64 {
                (0..size).map(|j| (error(i, j) + of_algorithm) * right[(j, c)].norm()).sum()
            };
            let sum: f64 = (0..size).map(|i| left[(c, i)].norm() * row(i)).sum();
            // Two equal eigenvalues have one vector.
            if sum.is_nan() { f64::INFINITY } else { sum / values[c].norm() }
        };
        // Rounding splits a double real eigenvalue λ by √(error |λ|) at most.
        let oscillates = |value: &faer::c64| {
            value.im > 0.0 && value.im * value.im > 8.0 * size as f64 * rounding * most * value.norm()
        };
        let mut list: Vec<Damped> = (0..size)
            .filter(|&c| oscillates(&values[c]))
            .map(|c| Damped { value: Complex64::new(values[c].re, values[c].im), rounding: share(c) })
            .collect();
        list.sort_by(|a, b| a.value.norm().total_cmp(&b.value.norm()));
        Some(list)
    }
}
