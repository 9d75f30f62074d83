//! Which motions are rigid, and which modes the rounding of the Jacobian hides.

use crate::contact::Piece;
use crate::linear::damped::{self, Damped};
use crate::linear::rank::proven_rank;
use crate::linear::spectrum::{self, Found};
use crate::linear::symmetric::inertias;
use crate::model::structure::slopes::{Slopes, offered};
use crate::model::terms::TermsScratch;
use crate::numeric::equations::balancing::balancing;
use faer::{Mat, Side};
use nalgebra::DMatrix;

/// Roundings of a Jacobian in ε = 2.2e-16 of the terms that an entry is made of: of one that the model
/// provides, and of one by differences.
const ROUNDINGS: [f64; 2] = [8.0, 16.0];

/// Steps of the differences that show the errors of a Jacobian, over the usual step. They are not powers of
/// 2, so that sums round in other ways.
const STEPS: [f64; 2] = [1.37, 1.91];

/// The error of a Jacobian by differences is at most this factor times its change with the length of the
/// step. For a cubic term the error is 1.1 times the change at the first other length.
const OF_STEPS: f64 = 4.0;

/// The modes of a model without damping, rigid motions included, and its eigenvalues with damping.
pub(crate) struct Spectrum {
    pub(crate) modes: Vec<Found>,
    pub(crate) damped: Vec<Damped>,
    /// Whether the stiffness is symmetric.
    pub(crate) symmetric: bool,
}

/// The spectrum of ∂a/∂q and ∂a/∂v. `error`: bound of the error of each entry of ∂a/∂q. `None` if eigenvalues
/// do not converge.
///
/// A symmetric stiffness has units of its own, its inertias. Any other one is taken in balanced units: a
/// model of lengths and angles has the same modes in metres and in micrometres.
pub(crate) fn spectrum([q, v]: [&DMatrix<f64>; 2], error: &DMatrix<f64>) -> Option<Spectrum> {
    let inertias = inertias(&-q);
    if inertias.is_some() {
        return in_units([q, v], error, inertias);
    }
    let units = balancing(q);
    let scaled =
        |b: &DMatrix<f64>| DMatrix::from_fn(b.nrows(), b.ncols(), |i, j| b[(i, j)] * (units[j] / units[i]));
    let mut spectrum = in_units([&scaled(q), &scaled(v)], &scaled(error), None)?;
    for mode in &mut spectrum.modes {
        mode.shape.iter_mut().zip(&units).for_each(|(x, unit)| *x *= unit);
    }
    Some(spectrum)
}

/// The spectrum in the units of the coordinates as they are.
fn in_units(
    [q, v]: [&DMatrix<f64>; 2],
    error: &DMatrix<f64>,
    inertias: Option<Vec<f64>>,
) -> Option<Spectrum> {
    let n = q.nrows();
    let share = |i: usize| error.row(i).amax() / q.row(i).amax();
    let rounding = (0..n).map(share).filter(|share| share.is_finite()).fold(f64::EPSILON, f64::max);
    let mut modes = spectrum::of(q, inertias.as_deref(), rounding)?;
    let soft = modes.iter().filter(|mode| mode.rigid).count();
    let rigid = if soft > 0 { n - proven_rank(q, error) } else { 0 };
    if rigid < soft {
        let motions: Vec<Vec<f64>> = modes.drain(..soft).map(|mode| mode.shape).collect();
        // The stiffness is not symmetric: nothing but the size of the errors is known.
        let error_of_any = rounding * n as f64 * q.amax();
        let told = match &inertias {
            Some(m) => told_apart(q, m, &motions, error)?,
            None => motions.into_iter().map(|shape| (0.0, shape, error_of_any)).collect(),
        };
        let of = |(place, (square, shape, error))| match place < rigid {
            true => Found::rigid(shape),
            false => Found { square, shape, error, rigid: false },
        };
        modes.splice(..0, told.into_iter().enumerate().map(of));
    }
    for mode in modes.iter_mut().filter(|mode| mode.rigid) {
        mode.error = hidden(error, inertias.as_deref(), &mode.shape);
    }
    let damped = damped::of([q, v], &modes, inertias.as_deref(), rounding)?;
    Some(Spectrum { modes, damped, symmetric: inertias.is_some() })
}

/// Bounds of the errors of ∂a/∂q where `slopes` was evaluated last: roundings of each entry, or of the terms
/// that it is made of if the model knows them, and for a Jacobian by differences four times what two other
/// steps change.
pub(crate) fn errors(
    slopes: &mut Slopes<'_>,
    pieces: Option<&[Piece]>,
    u: &[f64],
    [q, v]: [&[f64]; 2],
) -> DMatrix<f64> {
    let n = q.len();
    let mut errors = slopes.jacobian.q.abs();
    if let Some(terms) = slopes.model().offers().terms {
        // ∂/∂q of the terms: coordinates that are made of large terms, one at a time.
        const LARGE: f64 = 1e60;
        let mut sizes: Vec<f64> = q.iter().chain(v).map(|x| x.abs()).collect();
        let (mut scratch, mut sum) = (TermsScratch::default(), vec![0.0; n]);
        for j in 0..n {
            let size = std::mem::replace(&mut sizes[j], LARGE);
            terms.terms(offered(slopes.model(), pieces), u, q, v, &sizes, &mut scratch, &mut sum);
            sizes[j] = size;
            errors.column_mut(j).iter_mut().zip(&sum).for_each(|(e, sum)| *e = e.max(sum / LARGE));
        }
    }
    errors *= ROUNDINGS[usize::from(slopes.differenced)] * f64::EPSILON;
    if slopes.differenced {
        let (here, scale) = (slopes.jacobian.clone(), slopes.scale.clone());
        for factor in STEPS {
            for (size, (scale, x)) in slopes.scale.iter_mut().zip(scale.iter().zip(q.iter().chain(v))) {
                *size = factor * scale.max(1e-3 * x.abs());
            }
            slopes.at(pieces, u, q, v);
            for (error, (other, here)) in errors.iter_mut().zip(slopes.jacobian.q.iter().zip(&here.q)) {
                *error = error.max(OF_STEPS * (other - here).abs());
            }
        }
        (slopes.jacobian, slopes.scale) = (here, scale);
    }
    errors
}

/// Motions whose stiffness is within the errors of ∂a/∂q, the softest ones first: ω², the motion, and a bound
/// of the error of ω².
///
/// The stiffness of springs between the coordinates and to the ground is Σ k_ij (x_i - x_j)² + Σ g_i x_i²,
/// with k_ij, i < j, the entries beside the diagonal and g_i the sums of the rows: a soft spring between
/// groups that move as one keeps its digits. A row sum within its error counts as 0.
fn told_apart(
    q: &DMatrix<f64>,
    m: &[f64],
    motions: &[Vec<f64>],
    error: &DMatrix<f64>,
) -> Option<Vec<(f64, Vec<f64>, f64)>> {
    let (n, k) = (m.len(), motions.len());
    let along = |x: &[f64], y: &[f64]| (0..n).map(|i| x[i] * m[i] * y[i]).sum::<f64>();
    // Of unit inertia.
    let mut unit: Vec<Vec<f64>> = Vec::new();
    for motion in motions {
        let mut x = motion.clone();
        for _ in 0..2 {
            for other in &unit {
                let share = along(other, &x);
                x.iter_mut().zip(other).for_each(|(x, y)| *x -= share * y);
            }
        }
        let size = along(&x, &x).sqrt();
        x.iter_mut().for_each(|x| *x /= size);
        unit.push(x);
    }
    let ground = |i: usize| Some(-q.row(i).sum()).filter(|sum| sum.abs() > error.row(i).sum()).unwrap_or(0.0);
    let grounds: Vec<f64> = (0..n).map(ground).collect();
    let pairs = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let springs = grounds.iter().all(|g| *g >= 0.0) && pairs().all(|(i, j)| i == j || q[(i, j)] >= 0.0);
    let stiffness = |x: &[f64], y: &[f64]| -> f64 {
        let between = |(i, j): (usize, usize)| match springs {
            true if i == j => m[i] * grounds[i] * x[i] * y[i],
            true => 0.5 * m[i] * q[(i, j)] * (x[i] - x[j]) * (y[i] - y[j]),
            false => -m[i] * q[(i, j)] * x[i] * y[j],
        };
        pairs().map(between).sum()
    };
    let reduced =
        Mat::from_fn(k, k, |i, j| 0.5 * (stiffness(&unit[i], &unit[j]) + stiffness(&unit[j], &unit[i])));
    let found = reduced.self_adjoint_eigen(Side::Lower).ok()?;
    let (values, turned) = (found.S().column_vector(), found.U());
    let mut order: Vec<usize> = (0..k).collect();
    order.sort_by(|&i, &j| values[i].abs().total_cmp(&values[j].abs()));
    let bound: f64 = unit.iter().map(|x| hidden(error, Some(m), x)).sum();
    let shape = |c: usize| (0..n).map(|i| (0..k).map(|j| unit[j][i] * turned[(j, c)]).sum()).collect();
    Some(order.into_iter().map(|c| (values[c], shape(c), bound)).collect())
}

/// Largest ω² along a motion that the errors of ∂a/∂q may hide, to first order: for inertias m of a symmetric
/// stiffness Σ m_i e_ij |x_i| max(|x_i|, |x_j|)/Σ m_i x_i², otherwise |e |x||/|x|.
fn hidden(error: &DMatrix<f64>, m: Option<&[f64]>, x: &[f64]) -> f64 {
    let n = x.len();
    let sum = |of: &dyn Fn(usize) -> f64| (0..n).map(of).sum::<f64>();
    match m {
        Some(m) => {
            let row = |i: usize| sum(&|j| error[(i, j)] * x[i].abs() * x[i].abs().max(x[j].abs()));
            sum(&|i| m[i] * row(i)) / sum(&|i| m[i] * x[i] * x[i])
        }
        None => {
            let row = |i: usize| sum(&|j| error[(i, j)] * x[j].abs());
            (sum(&|i| row(i).powi(2)) / sum(&|i| x[i] * x[i])).sqrt()
        }
    }
}
