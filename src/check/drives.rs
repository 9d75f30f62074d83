//! Comparison of the drives with the drive edges that the model announces by `next_edge`.

use crate::check::inconsistency::Inconsistency;
use crate::excitation::Side;
use crate::model::equations::each_row;
use crate::model::{Model, State};
use crate::numeric::spread::golden;

/// Number of intervals into which a span is divided in the search for jumps.
const INTERVALS: u32 = 256;

/// Maximum number of parts of an interval, divided at announced edges, that are checked. The rest of the
/// interval is not checked.
const EDGES: usize = 8;

/// Number of edges along which `next_edge` is followed. Rounding may return an edge again only after many of
/// them.
const FOLLOWED: usize = 4096;

/// Share of a change that one half of its interval must contain if the change is a jump. A smooth change
/// leaves one half in each half interval; a jump leaves all of it in one.
const KEPT: f64 = 0.75;

/// Times beside an edge, as shares of the time to the next edge on either side `[1]`. Several times, since a
/// random process may by chance change by the same amount in two of them.
const BESIDE: [f64; 4] = [1e-7, 1e-6, 1e-5, 1e-4];

/// Number of instants at which the methods that update drives are compared with `drive`.
const UPDATES: usize = 11;

/// Allowed difference between drives that are updated and new ones, as a share of the largest value `[1]`.
const UPDATED: f64 = 1e-9;

/// Checks that `next_edge` returns later instants, for 4096 edges, that the drives do not jump between them,
/// that they have the values of the requested side at the first eight, and that `redrive` writes the values
/// of `drive`.
///
/// The second and the third check cover the time up to the eighth edge and the period. If the period is not
/// known, they cover the spans 1, 1e-3, 1e3, 1e-6 and max|q|/max|v| in its place.
pub(crate) fn check(
    model: &dyn Model,
    typical: &State,
    period: Option<f64>,
    findings: &mut Vec<Inconsistency>,
) {
    let start = typical.t;
    let (mut t, mut eighth) = (start, start);
    for i in 0..FOLLOWED {
        let Some(edge) = model.next_edge(t).filter(|edge| *edge < f64::INFINITY || edge.is_nan()) else {
            break;
        };
        if edge <= t || edge.is_nan() {
            findings.push(Inconsistency::DriveEdgeBehind { t, edge });
            return;
        }
        t = edge;
        if i < 8 {
            eighth = edge;
        }
    }
    let largest = |x: &[f64]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let turn = largest(&typical.q) / largest(&typical.v);
    let mut spans = vec![eighth - start];
    match period {
        Some(period) => spans.push(period),
        None => spans.extend([1.0, 1e-3, 1e3, 1e-6, turn]),
    }
    for span in spans {
        let resolved = start + span / f64::from(INTERVALS) > start;
        if span > 0.0
            && span.is_finite()
            && resolved
            && let Some(finding) = sides(model, start, span)
                .or_else(|| jump(model, start, span))
                .or_else(|| ignored_sides(model, start))
                .or_else(|| updates(model, start, span))
        {
            findings.push(finding);
            return;
        }
    }
}

/// Compares the drives by `redrive`, at single instants and at several, with those by `drive`.
fn updates(model: &dyn Model, start: f64, span: f64) -> Option<Inconsistency> {
    let drives = model.drives();
    let times: [f64; UPDATES] = std::array::from_fn(|i| start + span * (i as f64 + 0.6) / UPDATES as f64);
    let mut first = vec![0.0; drives];
    model.drive(start, Side::After, &mut first);
    let (mut fresh, mut nodes, mut again) = (first.repeat(UPDATES), first.repeat(UPDATES), first);
    let mut one_by_one = fresh.clone();
    each_row(drives, &times, &mut fresh, |t, u| model.drive(t, Side::Before, u));
    each_row(drives, &times, &mut one_by_one, |t, u| {
        model.redrive(&[t], Side::Before, &mut again);
        u.copy_from_slice(&again);
    });
    model.redrive(&times, Side::Before, &mut nodes);
    let largest = |d: usize| (0..UPDATES).fold(0.0f64, |m, i| m.max(fresh[drives * i + d].abs()));
    let wrong = |found: &[f64]| {
        (0..drives * UPDATES).find_map(|i| {
            let (drive, close) = (i % drives, UPDATED * largest(i % drives));
            let (found, expected) = (found[i], fresh[i]);
            let same = (found - expected).abs() <= close || found.to_bits() == expected.to_bits();
            let t = times[i / drives];
            (!same).then_some(Inconsistency::Redrive { drive, t, found, expected })
        })
    };
    wrong(&one_by_one).or_else(|| wrong(&nodes))
}

/// Compares the drives on both sides of 64 instants. They may differ only at announced edges.
fn sides(model: &dyn Model, start: f64, span: f64) -> Option<Inconsistency> {
    let (mut u, mut w) = (vec![0.0; model.drives()], vec![0.0; model.drives()]);
    (0..64).find_map(|i| {
        let t = start + span * golden(f64::from(i));
        model.drive(t, Side::Before, &mut u);
        model.drive(t, Side::After, &mut w);
        let drive = (0..u.len()).find(|&d| u[d] != w[d])?;
        (!announced(model, t, t, span)).then_some(Inconsistency::UnannouncedJump { drive, t })
    })
}

/// Compares the drives of each side of the first edges with those a short time away on this side. A drive
/// that ignores the side jumps between them: the difference does not decrease with the time.
fn ignored_sides(model: &dyn Model, start: f64) -> Option<Inconsistency> {
    let drives = model.drives();
    let [mut at, mut beside, mut least, mut most] = std::array::from_fn(|_| vec![0.0; drives]);
    let mut last = start;
    for _ in 0..EDGES {
        let edge = model.next_edge(last).filter(|edge| edge.is_finite())?;
        let apart = (model.next_edge(edge).unwrap_or(f64::INFINITY) - edge).min(edge - last);
        last = edge;
        if BESIDE[0] * apart <= 64.0 * f64::EPSILON * edge.abs() {
            continue; // rounding of the time would count
        }
        for side in [Side::Before, Side::After] {
            let away = if side == Side::Before { -apart } else { apart };
            model.drive(edge, side, &mut at);
            least.fill(f64::INFINITY);
            most.fill(0.0);
            for share in BESIDE {
                model.drive(edge + share * away, Side::After, &mut beside);
                for d in 0..drives {
                    let change = (beside[d] - at[d]).abs();
                    (least[d], most[d]) = (least[d].min(change), most[d].max(change));
                }
            }
            let jumps = |d: usize| least[d] > (KEPT * most[d]).max(1e-9 * at[d].abs());
            if let Some(drive) = (0..drives).find(|&d| jumps(d)) {
                return Some(Inconsistency::SideIgnored { drive, t: edge, side });
            }
        }
    }
    None
}

/// Whether `next_edge` announces an edge between two instants, with an allowance for rounding.
fn announced(model: &dyn Model, lo: f64, hi: f64, span: f64) -> bool {
    let close = 1e-9 * span + 8.0 * f64::EPSILON * hi.abs();
    model.next_edge(lo - close).is_some_and(|edge| edge <= hi + close)
}

/// Searches for a jump: a change that does not decrease with the length of its interval.
fn jump(model: &dyn Model, start: f64, span: f64) -> Option<Inconsistency> {
    let drives = model.drives();
    let [mut first, mut last, mut middle, mut scratch] = std::array::from_fn(|_| vec![0.0; drives]);
    let at = |i: u32| start + span * f64::from(i) / f64::from(INTERVALS);
    for i in 0..INTERVALS {
        let (mut a, end) = (at(i), at(i + 1));
        for _ in 0..EDGES {
            let edge = model.next_edge(a).filter(|edge| *edge < end && *edge > a);
            let b = edge.unwrap_or(end);
            let middle_time = 0.5 * (a + b);
            model.drive(a, Side::After, &mut first);
            model.drive(b, Side::Before, &mut last);
            model.drive(middle_time, Side::After, &mut middle);
            for d in 0..drives {
                let change = (last[d] - first[d]).abs();
                let rounding = 1e-9 * first[d].abs().max(last[d].abs());
                let halves = (middle[d] - first[d]).abs().max((last[d] - middle[d]).abs());
                if change > rounding
                    && halves > KEPT * change
                    && let Some((lo, hi)) = narrow(model, d, (a, first[d]), (b, last[d]), &mut scratch)
                    && !announced(model, lo, hi, span)
                {
                    return Some(Inconsistency::UnannouncedJump { drive: d, t: hi });
                }
            }
            if edge.is_none() {
                break;
            }
            a = b;
        }
    }
    None
}

/// Bisects the interval of a change down to neighbouring floating-point times. Returns `None` as soon as the
/// change in the chosen half is less than [`KEPT`] times the largest change so far: it is then not a jump.
fn narrow(
    model: &dyn Model,
    drive: usize,
    mut lo: (f64, f64),
    mut hi: (f64, f64),
    u: &mut [f64],
) -> Option<(f64, f64)> {
    let mut least = KEPT * (hi.1 - lo.1).abs();
    loop {
        let t = 0.5 * (lo.0 + hi.0);
        if t <= lo.0 || t >= hi.0 {
            return Some((lo.0, hi.0));
        }
        model.drive(t, Side::After, u);
        let middle = (t, u[drive]);
        if (middle.1 - lo.1).abs() > (hi.1 - middle.1).abs() {
            hi = middle
        } else {
            lo = middle
        }
        let change = (hi.1 - lo.1).abs();
        if change < least {
            return None;
        }
        least = least.max(KEPT * change);
    }
}
