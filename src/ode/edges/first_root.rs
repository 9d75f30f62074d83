//! The first crossing of an edge inside a step, as a root on the dense output.

use crate::numeric::search::bracket::Bracket;
use crate::numeric::search::hermite::{Distance, Hermite};
use crate::numeric::spread::GOLDEN_POINTS;
use crate::ode::edges::exit::Exit;
use crate::ode::stepping::engine::{Engine, Tableau};
use crate::ode::stepping::vector::Vector;
use std::cell::Cell;

/// Safety factor on the observed deviation of a distance from its cubic.
pub(crate) const DOUBT: f64 = 4.0;

/// An interval is searched along its cubic if the deviation at its division point is below this share of the
/// range of the distance `[1]`. Otherwise it is divided.
const RESOLVED: f64 = 0.05;

/// Maximum number of nested divisions of a step.
const HALVINGS: usize = 10;

/// Intervals of θ up to this length are not divided.
const UNDIVIDED: f64 = 1.0 / 1024.0;

/// The search divides no interval after this number of evaluations of the contact. Without this limit a fixed
/// step that is far too long for the motion costs thousands of evaluations.
const LOOKS: u32 = 1024;

/// Division point of an interval, as a share of its length: a multiple of the golden ratio modulo 1. No wave
/// has a whole number of periods on both sides of it.
const MIDDLE: f64 = GOLDEN_POINTS[3];

/// Maximum number of iterations for one root. Bisection alone needs about 50.
const MAX_ITERATIONS: usize = 60;

/// The first θ in (0, limit] at which the distance from the edge of `exit` becomes negative, on the dense
/// output.
///
/// `d0`, `d1`: distances at the start and the end of the step; `hermite`: the cubic through them; `slack`:
/// distance past the edge that does not count; `close`: distance at which a root is accepted. Returns 0.0 if
/// the contact starts on its edge or past it and moves outwards, and `None` if there is no crossing.
pub(crate) fn first_root<T: Tableau, V: Vector>(
    e: &mut Engine<'_, V>,
    exit: Exit,
    [d0, d1]: [Distance; 2],
    hermite: &Hermite,
    limit: f64,
    [slack, close]: [f64; 2],
) -> Option<f64> {
    e.prepare_dense::<T>();
    let from = e.ends.pieces[exit.contact];
    let h = e.ends.h();
    let looks = Cell::new(0);
    let mut look = |theta: f64| {
        looks.set(looks.get() + 1);
        e.contacts_inside::<T>(theta);
        exit.distance(from, &e.ends.contacts[exit.contact], h)
    };
    let (mut a, mut da) = (0.0, d0);
    // A contact that starts on its edge, or just past it, either has just entered or leaves at once. It
    // leaves if it moves outwards and is past the edge where it first is off it: at an extremum of the cubic
    // or, without extrema, at the end of the step or in its middle. A contact at rest on its edge may enter
    // and leave again in one step.
    let on_edge = d0.value <= slack;
    if on_edge && d0.rate <= 0.0 {
        let leaves = match hermite.extrema() {
            [None, None] => d1.value < -slack || look(0.5).value < -slack,
            extrema => {
                let mut inside = extrema.into_iter().flatten().map(|theta| look(theta).value);
                let off = inside.find(|value| value.abs() > slack).unwrap_or(d1.value);
                off < -slack
            }
        };
        if leaves {
            return Some(0.0);
        }
    }
    // If locating left the contact outside its edge by δ, δ is tolerated for this step.
    let slack = if on_edge { slack.max(-d0.value) } else { slack };
    // Divide the step until each interval is clear of the edge or follows its cubic. Search from left to
    // right.
    let right = if limit == 1.0 { d1 } else { look(limit) };
    let mut ends = [(limit, right); HALVINGS + 1];
    let mut open = 1;
    while open > 0 {
        let (b, db) = ends[open - 1];
        let cubic = Hermite::over(b - a, da, db);
        let m = a + MIDDLE * (b - a);
        let dm = look(m);
        // The slopes are compared too, since a wave may coincide with its cubic at the division point.
        let off =
            (dm.value - cubic.at(MIDDLE)).abs().max(0.25 * (dm.rate * (b - a) - cubic.slope(MIDDLE)).abs());
        let (least, most) = (cubic.least(), da.value.max(db.value).max(dm.value));
        let clear = least > DOUBT * off && least > slack && !cubic.may_dip(da, db);
        if dm.value < -slack && db.value >= -slack && m > a {
            ends[open - 1] = (m, dm); // the first root lies before m
            continue;
        }
        let resolved = off <= slack.max(RESOLVED * (most - least));
        if !clear && !resolved && b - a > UNDIVIDED && open < ends.len() && looks.get() < LOOKS {
            ends[open] = (m, dm);
            open += 1;
            continue;
        }
        let stretch = Stretch { cubic, entered: (a == 0.0 && on_edge).then_some(d0.value), resolved };
        if !clear && let Some(theta) = walk(&mut look, (a, da), (b, db), &stretch, slack, close) {
            return Some(theta);
        }
        (a, da) = (b, db);
        open -= 1;
    }
    None
}

/// An interval of θ that is searched.
struct Stretch {
    /// The cubic through the values and rates at its ends.
    cubic: Hermite,
    /// The distance at the start of the step, if the contact starts there on this edge or past it.
    entered: Option<f64>,
    /// Whether the distance follows its cubic. If not, the edge moves too fast for the samples, and dips
    /// between two samples are not searched for.
    resolved: bool,
}

/// The first root on an interval. The interval is searched part by part, between the extrema of its cubic.
fn walk(
    look: &mut impl FnMut(f64) -> Distance,
    (mut a, mut da): (f64, Distance),
    (end, d_end): (f64, Distance),
    &Stretch { ref cubic, entered, resolved }: &Stretch,
    slack: f64,
    close: f64,
) -> Option<f64> {
    let (start, width) = (a, end - a);
    let [first, second] = cubic.extrema().map(|sigma| sigma.map(|sigma| start + sigma * width));
    for b in [first, second, Some(end)].into_iter().flatten() {
        if b <= a {
            continue;
        }
        let db = if b == end { d_end } else { look(b) };
        if let Some(d0) = entered.filter(|_| a == start && db.value < -slack) {
            // The contact enters at θ = 0 and leaves again. f(θ) = (d(θ) - d0)/θ does not have the root at 0.
            let inside = |theta: f64| (look(theta).value - d0) / theta > 0.0;
            let Bracket { lo, hi } = Bracket { lo: 0.0, hi: b }.bisect(1e-14, inside);
            return Some(if lo == 0.0 { 0.0 } else { hi });
        }
        if db.value < -slack {
            return Some(root(look, (a, da), (b, db), close));
        }
        // Both ends are inside and there is a dip between them. Regula falsi on the rate finds its minimum.
        if resolved && da.rate < 0.0 && db.rate > 0.0 {
            let (mut lo, mut hi) = ((a, da), (b, db));
            for _ in 0..MAX_ITERATIONS {
                let m = lo.0 + (hi.0 - lo.0) * (lo.1.rate / (lo.1.rate - hi.1.rate)).clamp(0.1, 0.9);
                let dm = look(m);
                if dm.value < -slack {
                    return Some(root(look, (a, da), (m, dm), close));
                }
                if dm.rate < 0.0 {
                    lo = (m, dm)
                } else {
                    hi = (m, dm)
                }
                if (hi.0 - lo.0) * (dm.rate.abs()) < slack {
                    break;
                }
            }
        }
        (a, da) = (b, db);
    }
    None
}

/// θ ← θ - d/d', Newton's method for the root between `a` (d > 0) and `b` (d < 0). An iterate outside the
/// bracket is replaced by its middle.
fn root(look: &mut impl FnMut(f64) -> Distance, a: (f64, Distance), b: (f64, Distance), close: f64) -> f64 {
    let mut bracket = Bracket { lo: a.0, hi: b.0 };
    let mut theta = a.0 + (b.0 - a.0) * a.1.value / (a.1.value - b.1.value);
    for _ in 0..MAX_ITERATIONS {
        let d = look(theta);
        if d.value.abs() <= close {
            break;
        }
        bracket.narrow(theta, d.value > 0.0);
        if bracket.hi - bracket.lo <= 1e-15 {
            break;
        }
        theta = bracket.newton_or_middle(theta, d.value, d.rate);
    }
    theta
}
