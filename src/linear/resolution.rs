//! Which motions are rigid, and which modes the rounding of the Jacobian hides.

use crate::contact::Piece;
use crate::doubled::Doubled;
use crate::linear::doubled_modes;
use crate::linear::rank::Known;
use crate::linear::spectrum::{self, Found, Spectrum};
use crate::linear::symmetric::inertias;
use crate::model::Model;
use crate::model::structure::slopes::{Slopes, offered};
use faer::{Mat, Side};
use nalgebra::DMatrix;

/// Error of ω², as a share of it, above which modes are computed with twice the digits.
const ACCURATE: f64 = 1e-9;

/// The spectrum of ∂a/∂q and ∂a/∂v. `error`: bound of the error of each entry of ∂a/∂q. `exact`: ∂a/∂q of
/// twice the digits, for one instant (`false`) or as `q` is (`true`); `None` if the model does not know it.
/// The result is `None` if eigenvalues do not converge.
pub(crate) fn spectrum(
    [q, v]: [&DMatrix<f64>; 2],
    error: DMatrix<f64>,
    exact: &dyn Fn(bool) -> Option<Known>,
) -> Option<Spectrum> {
    let (n, rounding) = (q.nrows(), largest_share(q, &error));
    let mut plain = spectrum::of(q, v, rounding)?;
    let free = plain.modes.iter().filter(|mode| mode.rigid).count();
    let coarse = plain.modes.iter().any(|mode| mode.error > ACCURATE * mode.square.abs());
    if free == 0 && !coarse {
        return Some(plain);
    }
    let unresisted = |known: &Known| (n - known.proven_rank()).min(free);
    let m = inertias(&-q);
    let at_once = if free > 0 || m.is_some() { exact(false) } else { None };
    let has_exact = at_once.is_some();
    let rounded = || Known { high: q.clone(), low: DMatrix::zeros(n, n), error: error.clone() };
    let known = at_once.unwrap_or_else(rounded);
    let rigid = unresisted(&known);
    if let (Some(m), true, true) = (&m, has_exact, coarse || rigid < free)
        && let Some(whole) = exact(true)
        && let Some([still, found]) = doubled_modes::modes(&whole, m, unresisted(&whole))
    {
        let still = still.into_iter().map(|mode| mode.shape).collect();
        return spectrum::assembled(found, still, m, v, rounding);
    }
    if rigid < free {
        let motions: Vec<Vec<f64>> = plain.modes.drain(..free).map(|mode| mode.shape).collect();
        let told = match &m {
            Some(m) => told_apart(q, m, &motions, rigid, &error)?,
            None => {
                let error = rounding * n as f64 * q.amax();
                let of = |(i, shape)| match i < rigid {
                    true => Found::rigid(shape),
                    false => Found { square: 0.0, shape, error, rigid: false },
                };
                motions.into_iter().enumerate().map(of).collect()
            }
        };
        plain.modes.splice(..0, told);
    }
    Some(plain)
}

/// The weighted sum of ∂a/∂q of twice the digits over the drives of `count` instants at most; `None` if the
/// model does not know it, or an entry is not finite.
pub(crate) fn known<'u>(
    model: &dyn Model,
    pieces: Option<&[Piece]>,
    state: [&[f64]; 2],
    count: usize,
    instants: impl Iterator<Item = (f64, &'u [f64])>,
) -> Option<Known> {
    let (terms, n) = (model.offers().terms?, model.dof());
    let mut sum = DMatrix::from_element(n, n, Doubled::ZERO);
    let [mut high, mut low] = [DMatrix::zeros(n, n), DMatrix::zeros(n, n)];
    for (weight, u) in instants.take(count) {
        if !terms.exact_slopes(offered(model, pieces), u, state, [&mut high, &mut low]) {
            return None;
        }
        for (sum, (high, low)) in sum.iter_mut().zip(high.iter().zip(&low)) {
            *sum = *sum + (Doubled::from(*high) + Doubled::from(*low)) * Doubled::from(weight);
        }
    }
    let finite = sum.iter().all(|x| x.high.is_finite() && x.low.is_finite());
    finite.then(|| Known::exactly(sum.map(|x| x.high), sum.map(|x| x.low)))
}

/// Bounds of the errors of ∂a/∂q where `slopes` was evaluated last: `roundings` ε of each entry, and for a
/// Jacobian by differences, four times what two other steps change.
pub(crate) fn errors(
    slopes: &mut Slopes<'_>,
    roundings: f64,
    pieces: Option<&[Piece]>,
    u: &[f64],
    [q, v]: [&[f64]; 2],
) -> DMatrix<f64> {
    let mut errors = slopes.jacobian.q.map(|x| roundings * f64::EPSILON * x.abs());
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

/// Steps of the differences that show the errors of a Jacobian, over the usual step. They are not powers of
/// 2, so that sums round in other ways.
const STEPS: [f64; 2] = [1.37, 1.91];

/// Error of a Jacobian by differences over its changes with the step. The error of a cubic term is 1.1 times
/// the first one.
const OF_STEPS: f64 = 4.0;

/// The largest error of an entry, as a share of the largest entry of its row.
fn largest_share(a: &DMatrix<f64>, error: &DMatrix<f64>) -> f64 {
    let share =
        |i: usize| Some(a.row(i).amax()).filter(|most| *most > 0.0).map(|most| error.row(i).amax() / most);
    (0..a.nrows()).filter_map(share).fold(f64::EPSILON, f64::max)
}

/// Motions whose stiffness is within the errors of ∂a/∂q, by that stiffness: the softest ones are `rigid` in
/// number, the others modes that are not resolved, unless the error along them is small.
fn told_apart(
    q: &DMatrix<f64>,
    m: &[f64],
    motions: &[Vec<f64>],
    rigid: usize,
    error: &DMatrix<f64>,
) -> Option<Vec<Found>> {
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
    let pairs = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let stiffness = |x: &[f64], y: &[f64]| pairs().map(|(i, j)| -x[i] * m[i] * q[(i, j)] * y[j]).sum::<f64>();
    let hidden = |x: &Vec<f64>| pairs().map(|(i, j)| (x[i] * m[i] * error[(i, j)] * x[j]).abs()).sum::<f64>();
    let reduced =
        Mat::from_fn(k, k, |i, j| 0.5 * (stiffness(&unit[i], &unit[j]) + stiffness(&unit[j], &unit[i])));
    let found = reduced.self_adjoint_eigen(Side::Lower).ok()?;
    let (values, turned) = (found.S().column_vector(), found.U());
    let mut order: Vec<usize> = (0..k).collect();
    order.sort_by(|&i, &j| values[i].abs().total_cmp(&values[j].abs()));
    let bound: f64 = unit.iter().map(hidden).sum();
    let of = |(place, &c): (usize, &usize)| {
        let shape = (0..n).map(|i| (0..k).map(|j| unit[j][i] * turned[(j, c)]).sum()).collect();
        match place < rigid {
            true => Found::rigid(shape),
            false => Found { square: values[c], shape, error: bound, rigid: false },
        }
    };
    Some(order.iter().enumerate().map(of).collect())
}
