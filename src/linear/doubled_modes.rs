//! Modes with twice the digits: what a soft spring beside a stiff one does.

use crate::doubled::Doubled;
use crate::linear::rank::Known;
use crate::linear::spectrum::Found;
use nalgebra::DMatrix;

/// Number of coordinates up to which modes are computed with twice the digits: it takes a second.
const LARGEST: usize = 128;

/// Off-diagonal entries that count as 0, as a share of the largest ω².
const ZERO: f64 = 1e-32;

/// Sweeps over all pairs of coordinates. Some ten are needed.
const SWEEPS: usize = 40;

/// Largest entry of a transformation of two coordinates. A rotation has at most 1.
const TURN: f64 = 2.0;

/// Rounding of a frequency that is returned, and of the stiffnesses and inertias as doubles.
const PARAMETERS: f64 = 8.0 * f64::EPSILON;

/// The rigid motions, `rigid` in number, and the elastic modes of -A with these inertias. `None` if there are
/// too many coordinates, or the iteration does not converge.
///
/// The method of Jacobi for S = M^(1/2) A M^(-1/2). S is symmetric but for the rounding of the weights in the
/// model. The mean of S and its transpose would resist rigid motions by ε of the stiffest spring. Each pair
/// of coordinates is therefore transformed by the eigenvectors of its own two rows and columns, which are a
/// rotation if these are symmetric.
pub(crate) fn modes(known: &Known, m: &[f64], rigid: usize) -> Option<[Vec<Found>; 2]> {
    let n = m.len();
    if n > LARGEST {
        return None;
    }
    let root: Vec<Doubled> = m.iter().map(|m| Doubled::from(m.sqrt())).collect();
    let mut s = DMatrix::from_fn(n, n, |i, j| -(known.entry(i, j) * root[i] / root[j]));
    let mut vectors = DMatrix::<f64>::identity(n, n);
    let most = |s: &DMatrix<Doubled>| (0..n).fold(0.0f64, |most, i| most.max(s[(i, i)].size()));
    let mut turned = true;
    for _ in 0..SWEEPS {
        if !turned {
            break;
        }
        turned = false;
        let zero = ZERO * most(&s);
        for j in 1..n {
            for i in 0..j {
                if s[(i, j)].size().max(s[(j, i)].size()) > zero {
                    turned |= turn(&mut s, &mut vectors, [i, j]);
                }
            }
        }
    }
    if turned || s.iter().any(|x| !x.high.is_finite()) {
        return None;
    }
    let most = most(&s);
    let of = |c: usize| {
        let left = |j: usize| if j == c { 0.0 } else { s[(c, j)].size().max(s[(j, c)].size()) };
        let square = s[(c, c)].high;
        let error = (0..n).map(left).sum::<f64>() + n as f64 * ZERO * most * 8.0 + PARAMETERS * square.abs();
        let shape = (0..n).map(|i| vectors[(i, c)] / root[i].high).collect();
        Found { square, shape, error, rigid: false }
    };
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| s[(i, i)].size().total_cmp(&s[(j, j)].size()));
    let free = order[..rigid].iter().map(|&c| Found::rigid(of(c).shape)).collect();
    let mut elastic: Vec<Found> = order[rigid..].iter().map(|&c| of(c)).collect();
    elastic.sort_by(|a, b| a.square.total_cmp(&b.square));
    Some([free, elastic])
}

/// Transforms two coordinates so that they no longer couple. `false` if they stay as they are: two equal
/// eigenvalues but for rounding.
fn turn(s: &mut DMatrix<Doubled>, vectors: &mut DMatrix<f64>, [i, j]: [usize; 2]) -> bool {
    let n = s.nrows();
    let (b, c) = (s[(i, j)], s[(j, i)]);
    let half = (s[(i, i)] - s[(j, j)]) * Doubled::from(0.5);
    let square = half * half + b * c;
    if square.high.is_nan() || square.high <= 0.0 {
        return false;
    }
    let root = square.root();
    let sum = half + if half.high < 0.0 { -root } else { root };
    // Eigenvectors (1, x) and (y, 1).
    let (x, y) = (c / sum, -(b / sum));
    if x.size().max(y.size()) > TURN {
        return false;
    }
    let unit = (Doubled::from(1.0) - x * y).root();
    let (unit, x, y) = (Doubled::from(1.0) / unit, x / unit, y / unit);
    for k in 0..n {
        let [left, right] = [s[(k, i)], s[(k, j)]];
        (s[(k, i)], s[(k, j)]) = (left * unit + right * x, left * y + right * unit);
        let [left, right] = [vectors[(k, i)], vectors[(k, j)]];
        vectors[(k, i)] = left * unit.high + right * x.high;
        vectors[(k, j)] = left * y.high + right * unit.high;
    }
    for k in 0..n {
        let [above, below] = [s[(i, k)], s[(j, k)]];
        (s[(i, k)], s[(j, k)]) = (above * unit - below * y, below * unit - above * x);
    }
    (s[(i, j)], s[(j, i)]) = (Doubled::ZERO, Doubled::ZERO);
    true
}
