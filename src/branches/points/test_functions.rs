//! Test functions: their signs change at bifurcations.

use crate::branches::orbits::contact_trace::{ContactTrace, Extremum};
use crate::branches::orbits::sorted_extremes::SortedExtremes;
use crate::branches::points::change::{Change, VERTICAL};
use crate::numeric::search::parabola::may_dip;
use crate::periodic::Multipliers;
use num_complex::Complex64;

/// A multiplier whose imaginary part is below this share of its absolute value counts as real.
const REAL: f64 = 1e-12;

/// Distance from the unit circle that is rounding.
const CIRCLE_ROUNDING: f64 = 1e-9;

/// Whether a multiplier is real up to its error. Equal members have equal real multipliers, which errors may
/// turn into a complex pair.
fn is_real(m: &Complex64, error: f64) -> bool {
    m.im.abs() <= (REAL * m.norm()).max(error)
}

/// The real multipliers.
fn real(multipliers: &Multipliers) -> impl Iterator<Item = f64> {
    let error = multipliers.value_error();
    multipliers.values().iter().filter(move |m| is_real(m, error)).map(|m| m.re)
}

/// The complex multipliers.
fn complex(multipliers: &Multipliers) -> impl Iterator<Item = &Complex64> {
    let error = multipliers.value_error();
    multipliers.values().iter().filter(move |m| !is_real(m, error))
}

/// Π (1 + μ_i)/√(1 + |μ_i|²): vanishes at a period doubling.
pub(crate) fn doubling(multipliers: &Multipliers) -> f64 {
    let factor = |m: &Complex64| (1.0 + m) / (1.0 + m.norm_sqr()).sqrt();
    multipliers.values().iter().map(factor).product::<Complex64>().re
}

/// Π (1 - μ_i)/√(1 + |μ_i|²): vanishes at a fold.
pub(crate) fn fold(multipliers: &Multipliers) -> f64 {
    let factor = |m: &Complex64| (1.0 - m) / (1.0 + m.norm_sqr()).sqrt();
    multipliers.values().iter().map(factor).product::<Complex64>().re
}

/// Number of real multipliers below -1.
pub(crate) fn below(multipliers: &Multipliers) -> usize {
    real(multipliers).filter(|m| *m < -1.0).count()
}

/// Number of real multipliers above 1.
pub(crate) fn above(multipliers: &Multipliers) -> usize {
    real(multipliers).filter(|m| *m > 1.0).count()
}

/// The least distance of a real multiplier from -1; infinite without real multipliers.
pub(crate) fn nearest_to_doubling(multipliers: &Multipliers) -> f64 {
    real(multipliers).map(|m| (1.0 + m).abs()).fold(f64::INFINITY, f64::min)
}

/// 1 + μ of the real multiplier number `k`, in rising order.
pub(crate) fn from_below(multipliers: &Multipliers, k: usize) -> Option<f64> {
    let mut all: Vec<f64> = real(multipliers).collect();
    all.sort_by(f64::total_cmp);
    all.get(k).map(|m| 1.0 + m)
}

/// 1 - μ of the real multiplier number `k`, in falling order.
pub(crate) fn from_above(multipliers: &Multipliers, k: usize) -> Option<f64> {
    let mut all: Vec<f64> = real(multipliers).collect();
    all.sort_by(|a, b| b.total_cmp(a));
    all.get(k).map(|m| 1.0 - m)
}

/// Multipliers with a smaller difference count as equal `[1]`.
const EQUAL: f64 = 1e-9;

/// The bifurcations at which equal real multipliers would leave the unit circle together: at 1 and at -1.
/// Beside each stands the distance of these multipliers from 1 or -1.
pub(crate) fn together(multipliers: &Multipliers) -> [Option<(Change, f64)>; 2] {
    let equal = EQUAL.max(2.0 * multipliers.value_error());
    let next = |number: fn(&Multipliers, usize) -> Option<f64>, k: usize| {
        let [one, other] = [number(multipliers, k)?, number(multipliers, k + 1)?];
        (other - one <= equal).then_some(one)
    };
    let (k, l) = (above(multipliers), below(multipliers));
    let branches = next(from_above, k).map(|distance| (Change::Branches(k), distance));
    [branches, next(from_below, l).map(|distance| (Change::PeriodDoublings(l), distance))]
}

/// Distance of a multiplier from 1 within which it is 1 at a located crossing of branches `[1]`.
const AT_ONE: f64 = 1e-6;

/// Number of multipliers that are 1 at a located crossing of branches.
pub(crate) fn at_one(multipliers: &Multipliers) -> usize {
    multipliers.values().iter().filter(|m| (**m - 1.0).norm() < AT_ONE).count()
}

/// Number of multipliers outside the unit circle by more than rounding.
pub(crate) fn outside(multipliers: &Multipliers) -> usize {
    multipliers.values().iter().filter(|m| m.norm() > 1.0 + CIRCLE_ROUNDING).count()
}

/// Number of complex multipliers outside the unit circle.
pub(crate) fn pairs_outside(multipliers: &Multipliers) -> usize {
    complex(multipliers).filter(|m| m.norm() > 1.0).count()
}

/// Π_{i<j} (1 - μ_i μ_j)/√(1 + |μ_i μ_j|²): vanishes where a complex pair passes the unit circle, and where
/// the product of two real multipliers is 1. It is smooth where a pair becomes real. `None` for a single
/// multiplier.   Source: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, 2000, Ch. 4
/// (bialternate product).
pub(crate) fn torus(multipliers: &Multipliers) -> Option<f64> {
    let values = multipliers.values();
    let factor = |product: Complex64| (1.0 - product) / (1.0 + product.norm_sqr()).sqrt();
    let pairs = values.iter().enumerate().flat_map(|(i, a)| values[..i].iter().map(move |b| a * b));
    (values.len() > 1).then(|| pairs.map(factor).product::<Complex64>().re)
}

/// Largest distance of a complex pair from the unit circle at a Neimark-Sacker point `[1]`.
const ON_CIRCLE: f64 = 1e-6;

/// Whether a complex pair lies on the unit circle, where [`torus`] vanishes.
pub(crate) fn is_torus(multipliers: &Multipliers) -> bool {
    let near = ON_CIRCLE.max(2.0 * multipliers.value_error());
    complex(multipliers).any(|m| (m.norm() - 1.0).abs() < near)
}

/// Whether one complex pair of multipliers leaves the unit circle between two points while another pair
/// enters it. The number of multipliers outside and the sign of [`torus`] are then the same at both points.
/// Pairs are told apart by the order of their arguments.
pub(crate) fn pairs_change_places(a: &Multipliers, b: &Multipliers) -> bool {
    let near = ON_CIRCLE.max(2.0 * a.value_error().max(b.value_error()));
    let [of_a, of_b] = [a, b].map(|multipliers| {
        let mut pairs: Vec<Complex64> = complex(multipliers).filter(|m| m.im > 0.0).copied().collect();
        pairs.sort_by(|m, other| m.arg().total_cmp(&other.arg()));
        pairs
    });
    let passes = |out: &[Complex64], inside: &[Complex64]| {
        out.iter().zip(inside).any(|(out, inside)| out.norm() > 1.0 + near && inside.norm() < 1.0 - near)
    };
    of_a.len() == of_b.len() && passes(&of_a, &of_b) && passes(&of_b, &of_a)
}

/// Reads one test.
type Read = fn(&Values) -> Option<f64>;

/// The values of all test functions at a point.
#[derive(Clone, Debug, Default)]
pub(crate) struct Values {
    slope: f64,
    fold: Option<f64>,
    doubling: Option<f64>,
    torus: Option<f64>,
    together: [Option<(Change, f64)>; 2],
    pub(crate) extremes: Vec<Extremum>,
}

impl Values {
    pub(crate) fn new(slope: f64, multipliers: Option<&Multipliers>, trace: &ContactTrace) -> Self {
        Values {
            slope,
            fold: multipliers.map(fold),
            doubling: multipliers.map(doubling),
            torus: multipliers.and_then(torus),
            together: multipliers.map_or([None; 2], together),
            extremes: trace.extremes.clone(),
        }
    }
    /// The values with phases from nodes that lie later by `shift` periods.
    pub(crate) fn later(mut self, shift: f64) -> Self {
        self.extremes.iter_mut().for_each(|e| e.phase = (e.phase - shift).rem_euclid(1.0));
        self
    }
}

/// The bifurcations whose tests [may change their sign twice](may_dip) within the last of two steps, of
/// lengths `steps`.
pub(crate) fn dips(values: [&Values; 3], steps: [f64; 2]) -> Vec<Change> {
    let all = |f: Read| Some([f(values[0])?, f(values[1])?, f(values[2])?]);
    let single: [(Change, Read); 4] = [
        (Change::Fold, |v| Some(v.slope).filter(|slope| slope.abs() > VERTICAL)),
        // The determinant has the units of its step.
        (Change::Branch, |v| v.fold),
        (Change::PeriodDoubling, |v| v.doubling),
        (Change::NeimarkSacker, |v| v.torus),
    ];
    let near = single.iter().filter(|(_, of)| all(*of).is_some_and(|values| may_dip(values, steps)));
    let single = near.map(|(change, _)| *change);
    let several = (0..2).filter_map(|i| {
        let [Some((a, x)), Some((b, y)), Some((c, z))] = values.map(|v| v.together[i]) else { return None };
        (a == b && b == c && may_dip([x, y, z], steps)).then_some(a)
    });
    single.chain(several).collect()
}

/// Whether a multiplier would pass 1 in the second of two steps if it went on as in the first one, but is on
/// the same side at the end. The second step may then have jumped over a fold to another branch. `steps`: the
/// lengths of the two steps.
pub(crate) fn misses_a_fold(values: [&Values; 3], steps: [f64; 2]) -> bool {
    let [Some(before), Some(a), Some(b)] = values.map(|v| v.fold) else { return false };
    a * b > 0.0 && a * (a + (a - before) * steps[1] / steps[0]) < 0.0
}

/// The extremes of the third of three orbits that may pass their edge twice within the last of two steps.
pub(crate) fn grazing_dips([before, a, b]: [&[Extremum]; 3], steps: [f64; 2]) -> Vec<Extremum> {
    let [before, a] = [before, a].map(SortedExtremes::of);
    let near = |extremum: &&Extremum| {
        let nearest = before.nearest(extremum).zip(a.nearest(extremum));
        nearest.is_some_and(|(before, a)| may_dip([before.distance, a.distance, extremum.distance], steps))
    };
    b.iter().filter(near).copied().collect()
}
