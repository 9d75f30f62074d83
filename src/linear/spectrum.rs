//! Undamped modes: eigenvalues and eigenvectors of ∂a/∂q, with their rounding errors.

use crate::linear::rank::units;
use faer::{Mat, MatRef, Side, c64};
use nalgebra::DMatrix;

/// One eigenvalue ω² with its mode.
pub(crate) struct Found {
    /// 0 exactly for a rigid motion.
    pub(crate) square: f64,
    pub(crate) shape: Vec<f64>,
    /// Bound of the error of ω² by rounding, in the unit of ω². For a rigid motion, the largest ω² that the
    /// errors of ∂a/∂q may hide.
    pub(crate) error: f64,
    /// Whether it is a rigid motion.
    pub(crate) rigid: bool,
}

/// Ratio of the largest to the smallest ω² from which the smaller ones come from the inverse problem: below
/// it one problem gives all of them to 1e-10.
const GRADED: f64 = 1e6;

/// The modes of ∂a/∂q whose entries have this relative rounding error, the rigid motions first. `inertias`:
/// those of a symmetric stiffness. `None` if eigenvalues do not converge.
pub(crate) fn of(q: &DMatrix<f64>, inertias: Option<&[f64]>, rounding: f64) -> Option<Vec<Found>> {
    let (a, rigid) = (-q, unresisted(q, rounding)?);
    let found = match inertias {
        Some(m) => symmetric(&a, m, &rigid, rounding)?,
        None => general(&a, &rigid, rounding)?,
    };
    Some(rigid.into_iter().map(Found::rigid).chain(found).collect())
}

impl Found {
    pub(crate) fn rigid(shape: Vec<f64>) -> Self {
        Found { square: 0.0, shape, error: 0.0, rigid: true }
    }
}

/// Directions r with A r = 0 within the rounding of A.
///
/// Each row of A is divided by its largest entry, then each column: inertias leave the rows, units of the
/// coordinates the columns. The rank is that of the singular value decomposition.
fn unresisted(a: &DMatrix<f64>, rounding: f64) -> Option<Vec<Vec<f64>>> {
    let n = a.nrows();
    let (rows, columns) = units(a);
    let scaled = Mat::from_fn(n, n, |i, j| a[(i, j)] * rows[i] * columns[j]);
    let svd = scaled.svd().ok()?;
    let limit = rounding * n as f64 * svd.S()[0];
    let zero = (0..n).filter(|&k| svd.S()[k] <= limit);
    Some(zero.map(|k| (0..n).map(|j| svd.V()[(j, k)] * columns[j]).collect()).collect())
}

/// An orthonormal basis of n coordinates whose last columns span the given directions.
pub(crate) fn completed(directions: &[Vec<f64>], n: usize) -> DMatrix<f64> {
    let k = directions.len();
    if k == 0 {
        return DMatrix::identity(n, n);
    }
    let q = Mat::from_fn(n, k, |i, j| directions[j][i]).qr().compute_Q();
    DMatrix::from_fn(n, n, |i, j| q[(i, (j + k) % n)])
}

/// Elastic modes of A = M⁻¹ K with diagonal M and symmetric K.
///
/// The eigenvalues of M^(1/2) A M^(-1/2) have errors of ε of the largest one. If the smallest ones are far
/// below it, for example beside a body of small inertia, those below the middle are 1/μ of the largest
/// eigenvalues μ of the inverse problem N y = μ S y, S = D K D with 1 on its diagonal, N = D M D, q = D y,
/// without the rigid motions. Their errors are of ε of the largest μ.
fn symmetric(a: &DMatrix<f64>, m: &[f64], rigid: &[Vec<f64>], rounding: f64) -> Option<Vec<Found>> {
    let (n, k) = (a.nrows(), rigid.len());
    let stiffness = DMatrix::from_fn(n, n, |i, j| 0.5 * (a[(i, j)] * m[i] + a[(j, i)] * m[j]));
    let root: Vec<f64> = m.iter().map(|m| m.sqrt()).collect();
    let matrix = Mat::from_fn(n, n, |i, j| stiffness[(i, j)] / (root[i] * root[j]));
    let found = matrix.self_adjoint_eigen(Side::Lower).ok()?;
    let (values, vectors) = (found.S().column_vector(), found.U());
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| values[i].abs().total_cmp(&values[j].abs()));
    // Those next to zero are the rigid motions.
    let mut order = order.split_off(k);
    order.sort_by(|&i, &j| values[i].total_cmp(&values[j]));
    let most = order.iter().fold(0.0f64, |most, &i| most.max(values[i].abs()));
    let mut pairs: Vec<(f64, Vec<f64>, f64)> = order
        .iter()
        .map(|&c| (values[c], (0..n).map(|i| vectors[(i, c)] / root[i]).collect(), f64::EPSILON * most))
        .collect();
    if let Some(soft) = graded(&pairs).then(|| soft_modes(&stiffness, m, rigid)).flatten() {
        let (least, weakest) = (soft.modes[0].0, soft.weakest);
        let soft = soft.modes;
        let direct = |j: usize| most / pairs[j].0.abs().max(f64::EPSILON * most);
        let split = (1..pairs.len()).min_by(|&i, &j| {
            let worst = |j: usize| direct(j).max(soft[j - 1].0 / least);
            worst(i).total_cmp(&worst(j))
        });
        let split = split.unwrap_or(0);
        for (pair, soft) in pairs.iter_mut().zip(soft).take(split) {
            let error = f64::EPSILON * (soft.0 / least + 1.0 / weakest);
            *pair = (soft.0, soft.1, error * soft.0);
        }
    }
    let of = |(square, shape, error): (f64, Vec<f64>, f64)| {
        // First order: φᵀ δK φ/φᵀ M φ, |δK| <= rounding |K|.
        let size = |i: usize| (0..n).map(|j| (stiffness[(i, j)] * shape[i] * shape[j]).abs()).sum::<f64>();
        let inertia: f64 = shape.iter().zip(m).map(|(x, m)| m * x * x).sum();
        let first_order = rounding * (0..n).map(size).sum::<f64>() / inertia;
        Found { square, shape, error: first_order.max(n as f64 * error), rigid: false }
    };
    Some(pairs.into_iter().map(of).collect())
}

/// Whether eigenvalues are so far apart that the smallest ones need the inverse problem.
fn graded(pairs: &[(f64, Vec<f64>, f64)]) -> bool {
    let sizes = pairs.iter().map(|pair| pair.0.abs());
    let (least, most) = sizes.fold((f64::INFINITY, 0.0f64), |(l, m), x| (l.min(x), m.max(x)));
    pairs.len() > 1 && most > GRADED * least
}

/// Modes by the inverse problem.
struct Soft {
    /// Eigenvalues ω² with their modes, in increasing order.
    modes: Vec<(f64, Vec<f64>)>,
    /// The smallest eigenvalue of S: its error is of ε.
    weakest: f64,
}

/// The modes by the inverse problem; `None` if the stiffness is not positive.
fn soft_modes(stiffness: &DMatrix<f64>, m: &[f64], rigid: &[Vec<f64>]) -> Option<Soft> {
    let (n, k) = (m.len(), rigid.len());
    let d: Vec<f64> = (0..n).map(|i| 1.0 / stiffness[(i, i)].sqrt()).collect();
    if d.iter().any(|d| !d.is_finite()) {
        return None;
    }
    let scaled: Vec<Vec<f64>> =
        rigid.iter().map(|r| r.iter().zip(&d).map(|(r, d)| r / d).collect()).collect();
    let basis = completed(&scaled, n);
    let (elastic, still) = (basis.columns(0, n - k), basis.columns(n - k, k));
    let s = DMatrix::from_fn(n, n, |i, j| stiffness[(i, j)] * d[i] * d[j]);
    let inner = elastic.transpose() * &s * elastic;
    let inner = Mat::from_fn(n - k, n - k, |i, j| inner[(i, j)]);
    let found = inner.self_adjoint_eigen(Side::Lower).ok()?;
    let values = found.S().column_vector();
    if (0..n - k).any(|i| values[i] <= 0.0) {
        return None;
    }
    let weakest = values[0];
    // Columns z of unit strain energy, made free of the rigid motions: (still)ᵀ N y = 0.
    let unit = DMatrix::from_fn(n - k, n - k, |i, j| found.U()[(i, j)] / values[j].sqrt());
    let mut y = elastic * unit;
    let inertia: Vec<f64> = (0..n).map(|i| m[i] * d[i] * d[i]).collect();
    let weighted = |x: &DMatrix<f64>| DMatrix::from_fn(n, x.ncols(), |i, j| inertia[i] * x[(i, j)]);
    if k > 0 {
        let still = still.into_owned();
        let own = still.transpose() * weighted(&still);
        y -= &still * own.lu().solve(&(still.transpose() * weighted(&y)))?;
    }
    let g = y.transpose() * weighted(&y);
    let g = Mat::from_fn(n - k, n - k, |i, j| 0.5 * (g[(i, j)] + g[(j, i)]));
    let found = g.self_adjoint_eigen(Side::Lower).ok()?;
    let values = found.S().column_vector();
    let mode = |c: usize| {
        let along = |i: usize| (0..n - k).map(|j| y[(i, j)] * found.U()[(j, c)]).sum::<f64>() * d[i];
        (1.0 / values[c], (0..n).map(along).collect())
    };
    // Those that rounding leaves at 0 or below are the largest ω², which are not read.
    Some(Soft { modes: (0..n - k).rev().map(mode).collect(), weakest })
}

/// Elastic modes of any matrix with real eigenvalues.
///
/// In a basis whose last vectors are the rigid motions, these columns of A are zeros, and the eigenvalues of
/// the leading block are the others. Errors of the entries, E, change an eigenvalue with A x = μ x and
/// yᵀ A = μ yᵀ by |y|ᵀ E |x|/|yᵀ x| at most, to first order. A pair of complex eigenvalues is left out,
/// unless its imaginary part is within this error.
fn general(a: &DMatrix<f64>, rigid: &[Vec<f64>], rounding: f64) -> Option<Vec<Found>> {
    let (n, k) = (a.nrows(), a.nrows() - rigid.len());
    if k == 0 {
        return Some(Vec::new());
    }
    let basis = completed(rigid, n);
    let along = basis.transpose() * a * &basis;
    let sizes = basis.transpose().abs() * a.abs() * basis.abs() * rounding;
    let found = Mat::from_fn(k, k, |i, j| along[(i, j)]).eigen().ok()?;
    let (values, right) = (found.S().column_vector(), found.U());
    let right = with_all_vectors(&along, k, |c| values[c], right)?;
    let left = left_vectors(right.as_ref())?;
    // Of the QR algorithm and of the basis.
    let of_algorithm = f64::EPSILON * a.norm();
    let mode = |c: usize| {
        let value = values[c];
        // The whole vector: a mode has a share in the rigid motions.
        let mut parts: Vec<c64> = (0..k).map(|i| right[(i, c)]).collect();
        for r in k..n {
            parts.push((0..k).map(|j| parts[j] * along[(r, j)]).sum::<c64>() / value);
        }
        // The columns of the rigid motions are zeros up to their own error.
        let of_column = |i: usize, j: usize| if j < k { 0.0 } else { along[(i, j)].abs() };
        let row = |i: usize| -> f64 {
            (0..n).map(|j| (sizes[(i, j)] + of_algorithm + of_column(i, j)) * parts[j].norm()).sum()
        };
        let error: f64 = (0..k).map(|i| left[(c, i)].norm() * row(i)).sum();
        // Two equal eigenvalues may have one vector.
        let error = if error.is_nan() { f64::INFINITY } else { error };
        // Imaginary parts up to this share of a real eigenvalue mean nothing.
        const REAL: f64 = 1e-9;
        if value.im.abs() > error.max(REAL * value.norm()) {
            return None;
        }
        // A real eigenvector may carry a complex factor.
        let largest = parts[..k].iter().max_by(|x, y| x.norm().total_cmp(&y.norm()))?;
        let real: Vec<f64> =
            parts.iter().map(|x| (x / largest).re).map(|x| if x.is_finite() { x } else { 0.0 }).collect();
        let shape = (0..n).map(|i| (0..n).map(|j| basis[(i, j)] * real[j]).sum()).collect();
        Some(Found { square: value.re, shape, error: error.max(value.im.abs()), rigid: false })
    };
    Some((0..k).filter_map(mode).collect())
}

/// The eigenvectors of the leading k rows of a matrix, with those that an algorithm did not find: equal
/// eigenvalues may leave NaN or 0. They are the singular vectors of A - μ with the smallest singular values.
fn with_all_vectors(
    a: &DMatrix<f64>,
    k: usize,
    value: impl Fn(usize) -> c64,
    found: MatRef<'_, c64>,
) -> Option<Mat<c64>> {
    let mut all = found.to_owned();
    let size = |c: usize| (0..k).map(|i| found[(i, c)].norm()).sum::<f64>();
    let is_missing = |c: usize| !(f64::MIN_POSITIVE..f64::INFINITY).contains(&size(c));
    for c in (0..k).filter(|&c| is_missing(c)) {
        let mu = value(c);
        let apart = Mat::from_fn(k, k, |i, j| {
            c64::new(a[(i, j)], 0.0) - if i == j { mu } else { c64::new(0.0, 0.0) }
        });
        let svd = apart.svd().ok()?;
        let close = |other: usize| (value(other) - mu).norm() <= SAME * mu.norm();
        // The first of equal eigenvalues takes the smallest singular value, the next one the next.
        let place = (0..c).filter(|&other| is_missing(other) && close(other)).count();
        for i in 0..k {
            all[(i, c)] = svd.V()[(i, k - 1 - place)];
        }
    }
    Some(all)
}

/// Distance of eigenvalues that count as equal, as a share of them `[1]`.
const SAME: f64 = 1e-6;

/// The left eigenvectors of a matrix, one in each row, from its right eigenvectors, one in each column. The
/// product of a left and a right eigenvector of the same eigenvalue is 1. Right eigenvectors that nearly
/// coincide have large left ones.
pub(crate) fn left_vectors(right: MatRef<'_, c64>) -> Option<Mat<c64>> {
    let n = right.nrows();
    let svd = right.svd().ok()?;
    let (u, s, v) = (svd.U(), svd.S().column_vector(), svd.V());
    let least = f64::EPSILON * s[0].norm();
    let scaled = Mat::from_fn(n, n, |i, j| v[(i, j)] / s[j].norm().max(least));
    Some(scaled * u.adjoint())
}
