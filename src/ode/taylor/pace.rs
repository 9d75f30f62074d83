//! Lengths of steps, from the last coefficients.

use crate::numeric::norms::largest;
use crate::ode::taylor::expansion::coefficients::{Coefficients, PER};
use crate::ode::taylor::expansion::plan::{EdgeColumn, Plan};
use crate::ode::taylor::expansion::rows::{EIGHT, Eight};
use pulp::Arch;

/// Maximum ratio of the lengths that the tolerances allow for a step and for the one before `[1]`.
pub(crate) const MAX_GROWTH: f64 = 2.0;

/// Smallest tolerance of the distances, as a share of the gap `[1]`.
pub(crate) const FINEST: f64 = 1e-13;

/// A gap wider than this number of times what a contact moves near one of its edges, and than the
/// coordinates, counts as so wide `[1]`: a motion near one edge does not know of the other one.
const APART: f64 = 100.0;

/// The size to which the tolerance of a distance from an edge is relative: the gap behind it, or the distance
/// and its move in the step, `moves`. `extent`: the largest coordinate.
#[inline(always)]
pub(crate) fn size_of_distance(gap: f64, moves: f64, extent: f64) -> f64 {
    let most = if APART * moves > extent { APART * moves } else { extent };
    let gap = if gap < most { gap } else { most };
    if gap > moves { gap } else { moves }
}

/// The tolerances of all numbers and distances.
pub(super) struct SeriesPace {
    rtol: f64,
    /// Absolute tolerance of each coordinate and velocity, in their blocks of columns.
    atol: Vec<Eight>,
    /// 1/tolerance of each coordinate and velocity.
    per: Vec<Eight>,
    arch: Arch,
    /// The edge on the other side of the gap, for each edge.
    opposite: Vec<Option<EdgeColumn>>,
    /// How far each distance moves in the step, at most.
    pub(super) ranges: Vec<Eight>,
}

/// log2 x, with an error below 0.1: enough for the length of a step.
#[inline(always)]
fn log2(x: f64) -> f64 {
    x.to_bits() as i64 as f64 * (1.0 / (1u64 << 52) as f64) - 1023.0
}
/// 2^x, with a relative error below 0.1.
#[inline(always)]
fn exp2(x: f64) -> f64 {
    f64::from_bits(((x.clamp(-1022.0, 1023.0) + 1023.0) * (1u64 << 52) as f64) as u64)
}

/// The length at which a term of the given order, measured in tolerances, reaches 1.
#[inline(always)]
pub(crate) fn reach(term: f64, order: usize) -> f64 {
    if term == 0.0 { f64::INFINITY } else { exp2(-log2(term) * PER[order]) }
}

impl SeriesPace {
    pub(super) fn new(rtol: f64, atol: &[f64], plan: &Plan) -> Self {
        let opposite =
            plan.edges.iter().map(|edge| plan.edges.iter().copied().find(|other| other.is_opposite(edge)));
        // No number of a column without a coordinate reaches its tolerance.
        let mut blocks = vec![[f64::INFINITY; EIGHT]; 2 * plan.half];
        for (blocks, atol) in blocks.chunks_mut(plan.half.max(1)).zip(atol.chunks(plan.dof.max(1))) {
            blocks.as_flattened_mut()[..atol.len()].copy_from_slice(atol);
        }
        SeriesPace {
            rtol,
            per: vec![[0.0; EIGHT]; blocks.len()],
            atol: blocks,
            arch: Arch::new(),
            opposite: opposite.collect(),
            ranges: vec![[0.0; EIGHT]; plan.distance_blocks],
        }
    }

    /// The length at which each of the last two terms reaches its tolerance; infinite if both are 0 and NaN
    /// if one is not finite. `last`: the length of the last step, 0 before the first; `room`: the longest
    /// step possible.
    pub(super) fn length(&mut self, c: &Coefficients, last: f64, room: f64) -> f64 {
        let before = if last.is_finite() { last } else { 0.0 };
        let (arch, degree) = (self.arch, c.degree);
        let terms = arch.dispatch(LastTerms { pace: self, c, before });
        if !(terms[0].is_finite() && terms[1].is_finite()) {
            return f64::NAN;
        }
        let mut h = reach(terms[0], degree).min(reach(terms[1], degree - 1));
        if last > 0.0 {
            h = h.min(MAX_GROWTH * last);
        }
        // Moving edges and transmission errors act on the distances alone while teeth are apart.
        let span = h.min(room);
        let share = self.rtol.max(FINEST);
        let (start, rate) = (c.distances(0), c.distances(1));
        let [highest, below] = [degree, degree - 1].map(|n| c.distances(n));
        let extent = largest(c.q(0));
        let mut terms = [0.0_f64; 2];
        for (edge, opposite) in c.plan.edges.iter().zip(&self.opposite) {
            let (i, at_start) = (edge.column, |edge: &EdgeColumn| edge.sign * start[edge.column]);
            let gap = opposite.map_or(0.0, |other| at_start(edge) + at_start(&other));
            let size = size_of_distance(gap, start[i].abs() + span * rate[i].abs(), extent);
            if share * size > f64::MIN_POSITIVE {
                let per = 1.0 / (share * size);
                terms = [max(terms[0], (highest[i] * per).abs()), max(terms[1], (below[i] * per).abs())];
            }
        }
        if terms[0].is_nan() || terms[1].is_nan() {
            return f64::NAN;
        }
        h.min(reach(terms[0], degree)).min(reach(terms[1], degree - 1))
    }

    /// Whether the difference of two accelerations at the end of a step of length `h` changes coordinates and
    /// velocities by less than their tolerances.
    pub(super) fn tolerates(&self, h: f64, a: &[f64], b: &[f64]) -> bool {
        let (of_q, of_v) = self.per.split_at(self.per.len() / 2);
        a.iter().zip(b).zip(of_q.as_flattened().iter().zip(of_v.as_flattened())).all(|((a, b), (q, v))| {
            let off = (a - b).abs() * h;
            off * v <= 1.0 && off * h * q <= 1.0
        })
    }
}

/// The largest of the terms of the highest order and of the one below it, measured in tolerances; NaN if one
/// is not a number.
struct LastTerms<'p> {
    pace: &'p mut SeriesPace,
    c: &'p Coefficients,
    /// The length of the last step.
    before: f64,
}

impl pulp::WithSimd for LastTerms<'_> {
    type Output = [f64; 2];
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> [f64; 2] {
        let LastTerms { pace: SeriesPace { per, atol, rtol, .. }, c, before } = self;
        let rows = [0, 1, c.degree, c.degree - 1].map(|order| c.motion(order));
        let mut largest = [[0.0; EIGHT]; 2];
        for (k, (per, atol)) in per.iter_mut().zip(atol).enumerate() {
            let [value, rate, last, below] = rows.map(|row| row[k]);
            for l in 0..EIGHT {
                per[l] = 1.0 / (atol[l] + *rtol * (value[l].abs() + before * rate[l].abs()));
                largest[0][l] = max(largest[0][l], (last[l] * per[l]).abs());
                largest[1][l] = max(largest[1][l], (below[l] * per[l]).abs());
            }
        }
        [largest_of(largest[0]), largest_of(largest[1])]
    }
}

/// The largest of eight numbers; NaN if one of them is NaN.
#[inline(always)]
fn largest_of([a, b, c, d, e, f, g, h]: Eight) -> f64 {
    max(max(max(a, e), max(c, g)), max(max(b, f), max(d, h)))
}

/// The larger of two numbers that are not negative; NaN if one of them is NaN: its bits without the sign are
/// those of the largest integer.
#[inline(always)]
pub(crate) fn max(a: f64, b: f64) -> f64 {
    f64::from_bits(a.to_bits().max(b.to_bits()))
}
