//! Growth of perturbations across an invariant circle.

use crate::numeric::norms::{dot, remove, right_vectors};
use crate::ode::budget::Meter;
use crate::periodic::Multipliers;
use crate::tori::circle::closed_curve::{weights, write_weights};
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// y(θ + ρ) = A(θ) y(θ): perturbations of a circle, with A interpolated between the nodes.
///
/// The growth is that of a subspace that A maps into itself. One perturbation within it may turn: its growth
/// then depends on its direction, and its mean needs many turns. The growth of an area or a volume does not
/// depend on directions.
///
/// After q periods with q ρ near a whole number of turns the product of all A has nearly the eigenvalues of a
/// monodromy matrix. Those beside the largest one span the subspace.   Source: Jorba, Nonlinearity 14, 943
/// (2001), for the linear equations and what reduces them.
pub(crate) struct Perturbations<'a> {
    /// A at the nodes, in units.
    pub(crate) transitions: &'a [DMatrix<f64>],
    /// The tangent dx/dθ of a free circle at the nodes, in the units of the state. A perturbation along a
    /// free circle stays along it and is left out. Empty for a circle whose rotation the drives prescribe.
    pub(crate) rates: Vec<Vec<f64>>,
    pub(crate) rotation: f64,
    pub(crate) meter: &'a Meter<'a>,
}

/// Least and largest number of map periods over which the growth is measured.
const MEASURED: [usize; 2] = [1 << 12, 1 << 18];

/// Number of turns round the circle over which the growth is measured.
const ROUNDS: f64 = 16.0;

/// Error of the mean over these turns, as a share of the variation of the growth along the circle.
const SHARE: f64 = 4e-6;

/// Error of the mean growth that comes from the errors of the transitions.
const ROUNDING: f64 = 1e-9;

/// Largest denominator q of the ratios p/q that the rotation, as a share of a turn, is compared with. Near
/// such a ratio every q-th point of the map moves slowly along the circle.
const DENOMINATORS: usize = 8;

/// Eigenvalues within this share of the largest one, or of its conjugate, count as one: their directions
/// depend on small errors, the subspace of all of them does not.
const TOGETHER: f64 = 0.25;

/// Number of map periods between two questions to the budget.
const UNASKED: usize = 1024;

/// Distance of a number of turns from the nearest whole number.
fn from_whole(turns: f64) -> f64 {
    (turns - turns.round()).abs()
}

/// Number of map periods that make [`ROUNDS`] turns round the circle, or `None` if it is too large.
fn rounds(rotation: f64) -> Option<usize> {
    let slow = |q: usize| from_whole(q as f64 * rotation / TAU);
    let slowest = (1..=DENOMINATORS).map(slow).fold(f64::INFINITY, f64::min);
    let [least, most] = MEASURED;
    let periods = (ROUNDS / slowest).ceil();
    (periods <= most as f64).then_some((periods as usize).max(least))
}

/// The product of all A over a number of periods, divided by e^logarithm.
struct Product {
    matrix: DMatrix<f64>,
    logarithm: f64,
    periods: usize,
}

/// The subspace that grows most.
struct Leading {
    basis: Vec<Vec<f64>>,
    /// Mean logarithms, over one period, of the largest eigenvalue and of all those of the subspace.
    largest: f64,
    mean: f64,
}

impl Perturbations<'_> {
    /// Mean logarithm of the growth of the perturbation that grows most, over one period of the map, and an
    /// estimate of its error. NaN if the points of the map move too slowly along the circle, or if the budget
    /// is spent.
    ///
    /// It is the mean over the subspace plus what the largest eigenvalue has above the mean of the
    /// eigenvalues. The error counts this difference, which may come from errors, and the distance from the
    /// growth of the largest eigenvalue, which is another estimate of the same growth.
    pub(crate) fn growth(&self) -> [f64; 2] {
        let Some(periods) = rounds(self.rotation) else { return [f64::NAN; 2] };
        let Some(product) = self.product(periods) else { return [f64::NAN; 2] };
        if product.matrix.amax() == 0.0 {
            return [f64::NEG_INFINITY, 0.0];
        }
        let found =
            leading(&product).and_then(|leading| Some((self.mean(periods, &leading.basis)?, leading)));
        let Some(([mean, variation], leading)) = found else { return [f64::NAN; 2] };
        let above = leading.largest - leading.mean;
        let growth = mean + above;
        [growth, (growth - leading.largest).abs() + above + SHARE * variation + ROUNDING]
    }

    /// Walks along the circle from θ = 0 and calls `step` with the index of a period and A, without what it
    /// has along the circle at its end. `None`: the budget is spent.
    fn walk(&self, periods: usize, mut step: impl FnMut(usize, &DMatrix<f64>)) -> Option<()> {
        let (m, width) = (self.transitions.len(), self.transitions.first()?.nrows());
        let (mut at, mut theta) = (weights(m, 0.0), 0.0);
        let (mut matrix, mut along) = (DMatrix::zeros(width, width), vec![0.0; width]);
        for k in 0..periods {
            if k % UNASKED == 0 && self.meter.exhausted().is_some() {
                return None;
            }
            matrix.fill(0.0);
            for (weight, transition) in at.iter().zip(self.transitions) {
                matrix.iter_mut().zip(transition.iter()).for_each(|(out, a)| *out += weight * a);
            }
            theta = (theta + self.rotation).rem_euclid(TAU);
            write_weights(theta, &mut at);
            if !self.rates.is_empty() {
                let rate_of = |i: usize| at.iter().zip(&self.rates).map(|(w, rate)| w * rate[i]).sum::<f64>();
                along.iter_mut().enumerate().for_each(|(i, out)| *out = rate_of(i));
                let length = dot(&along, &along).sqrt();
                along.iter_mut().for_each(|x| *x /= length);
                matrix.as_mut_slice().chunks_exact_mut(width).for_each(|column| remove(&along, column));
            }
            step(k, &matrix);
        }
        Some(())
    }

    /// The product over that number of periods, from once to twice the given one, after which the circle has
    /// turned most nearly by whole turns. It stops at a product of 0.
    fn product(&self, least: usize) -> Option<Product> {
        let width = self.transitions.first()?.nrows();
        let (mut matrix, mut next) = (DMatrix::identity(width, width), DMatrix::zeros(width, width));
        let (mut logarithm, mut nearest) = (0.0, f64::INFINITY);
        let mut product = None;
        self.walk(2 * least, |k, a| {
            a.mul_to(&matrix, &mut next);
            let size = next.amax();
            if size > 0.0 {
                next /= size;
                logarithm += size.ln();
            }
            std::mem::swap(&mut matrix, &mut next);
            let periods = k + 1;
            let off = from_whole(periods as f64 * (self.rotation / TAU));
            if periods >= least && off < nearest {
                nearest = off;
                product = Some(Product { matrix: matrix.clone(), logarithm, periods });
            }
        })?;
        product
    }

    /// Weighted mean of the logarithm of the growth of a subspace in each of its directions, and its
    /// variation. The weights are those of [`rotation_number`](crate::tori::rotation_number).
    fn mean(&self, periods: usize, basis: &[Vec<f64>]) -> Option<[f64; 2]> {
        let mut columns = basis.to_vec();
        let count = columns.len() as f64;
        let mut next = vec![0.0; columns.first()?.len()];
        let (mut sum, mut total) = (0.0, 0.0);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        self.walk(periods, |k, a| {
            let mut growth = 0.0;
            for c in 0..columns.len() {
                let (before, from) = columns.split_at_mut(c);
                next.fill(0.0);
                for (x, column) in from[0].iter().zip(a.column_iter()) {
                    next.iter_mut().zip(column.iter()).for_each(|(out, a)| *out += a * x);
                }
                before.iter().for_each(|b| remove(b, &mut next));
                let length = dot(&next, &next).sqrt();
                from[0].iter_mut().zip(&next).for_each(|(out, x)| *out = x / length);
                growth += length.ln() / count;
            }
            let s = (k + 1) as f64 / (periods + 1) as f64;
            let weight = (-1.0 / (s * (1.0 - s))).exp();
            (least, most) = (growth.min(least), growth.max(most));
            sum += weight * growth;
            total += weight;
        })?;
        Some([sum / total, most - least])
    }
}

/// The subspace of the largest eigenvalue of a product, and of those beside it: the null space of
/// Π_j (P - μ_j) over these eigenvalues. `None` if there are no finite eigenvalues.
fn leading(product: &Product) -> Option<Leading> {
    let multipliers = Multipliers::of_monodromy(&product.matrix, 0.0).ok()?;
    let first = *multipliers.values().first()?;
    let size = first.norm();
    if size == 0.0 {
        return None;
    }
    let is_beside = |m: f64| m <= TOGETHER * size;
    let together = multipliers
        .values()
        .iter()
        .filter(|m| is_beside((**m - first).norm()) || is_beside((**m - first.conj()).norm()));
    let (scaled, width) = (&product.matrix / size, product.matrix.nrows());
    let one = DMatrix::identity(width, width);
    let mut annihilator = one.clone();
    let (mut count, mut sum) = (0, 0.0);
    for m in together {
        let m = m / size;
        (count, sum) = (count + 1, sum + m.norm().ln());
        if m.im == 0.0 {
            annihilator *= &scaled - &one * m.re;
        } else if m.im > 0.0 {
            annihilator *= &scaled * &scaled - &scaled * (2.0 * m.re) + &one * m.norm_sqr();
        }
    }
    let vectors = right_vectors(annihilator)?;
    let basis = (width - count..width).map(|i| vectors.row(i).iter().copied().collect()).collect();
    let periods = product.periods as f64;
    let largest = (product.logarithm + size.ln()) / periods;
    Some(Leading { basis, largest, mean: largest + sum / count as f64 / periods })
}
