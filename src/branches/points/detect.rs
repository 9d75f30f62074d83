//! What changes between two points of a branch.

use crate::branches::curve::point::CurvePoint;
use crate::branches::orbits::contact_trace::{ContactTrace, Extremum};
use crate::branches::orbits::sorted_extremes::SortedExtremes;
use crate::branches::points::change::{Change, VERTICAL};
use crate::branches::points::test_functions::{below, outside, pairs_outside};
use crate::contact::edge::Edge;
use crate::periodic::Multipliers;

/// The change that a located point with a multiplier on the unit circle explains.
pub(crate) const OUTSIDE: &str = "the number of multipliers outside the unit circle changed";

/// What grazings explain.
pub(crate) const SEQUENCE: &str = "the contact sequence changed";

/// The bifurcations between two points, crossings of branches first, and what they do not explain.
pub(crate) fn bifurcations<S>(
    a: (&CurvePoint<S>, Option<&Multipliers>),
    b: (&CurvePoint<S>, Option<&Multipliers>),
) -> (Vec<Change>, Option<&'static str>) {
    let mut all = Vec::new();
    if a.0.sign != b.0.sign {
        all.push(Change::Branch);
    }
    let (from, to) = (a.0.slope(), b.0.slope());
    if from * to < 0.0 && from.abs().min(to.abs()) > VERTICAL {
        all.push(Change::Fold);
    }
    let (Some(ma), Some(mb)) = (a.1, b.1) else { return (all, None) };
    let mut unexplained = None;
    let [least, most] = [below(ma).min(below(mb)), below(ma).max(below(mb))];
    let doublings = most - least;
    if doublings == 1 {
        all.push(Change::PeriodDoubling);
    } else if doublings > 1 {
        unexplained = Some(Change::PeriodDoublings(least).unlocated());
    }
    let single = all.len();
    if pairs_outside(ma) != pairs_outside(mb) && outside(ma) != outside(mb) {
        all.push(Change::NeimarkSacker);
    }
    let double = all.len() - single;
    if outside(ma).abs_diff(outside(mb)) > single + 2 * double {
        unexplained = Some(OUTSIDE);
    }
    (all, unexplained)
}

/// The extremes that lie on different sides of their edge in two orbits, in the first and in the second.
pub(crate) fn passed(a: &ContactTrace, b: &ContactTrace) -> Vec<[Extremum; 2]> {
    let [of_a, of_b] = [a, b].map(|trace| SortedExtremes::of(&trace.extremes));
    let both = |after: &Extremum| {
        let before = of_a.same(after, &of_b)?;
        (before.distance * after.distance < 0.0).then_some([*before, *after])
    };
    b.extremes.iter().filter_map(both).collect()
}

/// Whether grazings explain how often the edges are crossed: each one adds two crossings, or takes two away.
pub(crate) fn explain_the_sequence<'e>(
    grazings: impl Iterator<Item = &'e Extremum> + Clone,
    a: &ContactTrace,
    b: &ContactTrace,
) -> bool {
    let explained = |contact: usize, edge: Edge, from: &[u32; 2], to: &[u32; 2]| {
        let of = grazings.clone().filter(|e| e.is_at(contact, edge));
        let (count, change) = (of.count() as u32, from[edge as usize].abs_diff(to[edge as usize]));
        change % 2 == 1 || (change / 2 <= count && (count - change / 2).is_multiple_of(2))
    };
    let mut both = a.crossings.iter().zip(&b.crossings).enumerate();
    both.all(|(contact, (from, to))| Edge::BOTH.iter().all(|edge| explained(contact, *edge, from, to)))
}
