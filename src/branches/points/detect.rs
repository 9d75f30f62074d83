//! What changes between two neighbouring points of a branch.

use crate::branches::curve::point::CurvePoint;
use crate::branches::orbits::contact_trace::{ContactTrace, Extremum};
use crate::branches::points::change::{Change, VERTICAL};
use crate::branches::points::test_functions::{below, outside, pairs_outside};
use crate::periodic::multipliers::Multipliers;

/// The changes between two points.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Changes {
    pub(crate) all: Vec<Change>,
    /// What the changes do not explain.
    pub(crate) unexplained: Option<&'static str>,
}

/// Distance of two phases up to which extremes of neighbouring orbits are the same one.
const NEAR: f64 = 0.1;

/// The change that a located point with a multiplier on the unit circle explains.
pub(crate) const OUTSIDE: &str = "the number of multipliers outside the unit circle changed";

/// What is compared of a point.
pub(crate) struct Compared<'p, S> {
    pub(crate) point: &'p CurvePoint<S>,
    pub(crate) multipliers: Option<&'p Multipliers>,
    pub(crate) trace: &'p ContactTrace,
}

pub(crate) fn changes<S>(a: Compared<'_, S>, b: Compared<'_, S>) -> Changes {
    let mut all = Vec::new();
    let (from, to) = (a.point.slope(), b.point.slope());
    if from * to < 0.0 && from.abs().min(to.abs()) > VERTICAL {
        all.push(Change::Fold);
    }
    if a.point.sign != b.point.sign {
        all.push(Change::Branch);
    }
    let mut unexplained = None;
    if let (Some(ma), Some(mb)) = (a.multipliers, b.multipliers) {
        let doublings = below(ma).abs_diff(below(mb));
        if doublings == 1 {
            all.push(Change::PeriodDoubling);
        } else if doublings > 1 {
            unexplained = Some("several multipliers passed -1");
        }
        let single = all.len();
        if pairs_outside(ma) != pairs_outside(mb) && outside(ma) != outside(mb) {
            all.push(Change::NeimarkSacker);
        }
        let double = all.len() - single;
        let change = outside(ma).abs_diff(outside(mb));
        if change > single + 2 * double {
            unexplained = Some(OUTSIDE);
        }
    }
    let grazings = grazings(a.trace, b.trace);
    let crossed = |trace: &ContactTrace| trace.crossings.clone();
    if crossed(a.trace) != crossed(b.trace) && grazings.is_empty() {
        unexplained = Some("the contact sequence changed");
    }
    if !grazings.is_empty() {
        // At a grazing the multipliers may jump.
        unexplained = unexplained.filter(|what| *what == "the contact sequence changed");
    }
    all.extend(grazings.into_iter().map(Change::Grazing));
    Changes { all, unexplained }
}

/// Extremes of the second orbit that lie on the other side of their edge in the first.
fn grazings(a: &ContactTrace, b: &ContactTrace) -> Vec<Extremum> {
    let mut found = Vec::new();
    for (contact, (from, to)) in a.crossings.iter().zip(&b.crossings).enumerate() {
        for edge in 0..2 {
            if from[edge] == to[edge] {
                continue;
            }
            let of = |extremum: &&Extremum| extremum.contact == contact && extremum.lower == (edge == 0);
            for after in b.extremes.iter().filter(of) {
                let before = a.nearest(after).filter(|before| before.apart(after.phase) < NEAR);
                if before.is_some_and(|before| before.distance * after.distance < 0.0) {
                    found.push(*after);
                }
            }
        }
    }
    found
}
