//! Crossings of edges within the steps of noisy lanes: impacts, their speeds, flights.

use crate::contact::Contact;
use crate::model::Shape;
use crate::random::white::noisy_lanes::Look;
use crate::sweep::Distribution;
use crate::sweep::lanes::number::Lanes;

/// Impacts and flights of one contact in all lanes.
///
/// Noise does not move the coordinates, so that the deflection within a step is the smooth arc of R: a cubic
/// through both ends. Where its ends lie on different sides of an edge, its root there is the crossing. Two
/// crossings of one edge within a step are not counted: the share (a h)²/(24 ⟨v²⟩) of all.
pub(crate) struct Crossings<const W: usize> {
    contact: usize,
    /// Penetrations of the lower and the upper flank after the last step; NaN before the first one.
    depth: [Lanes<W>; 2],
    lanes: Vec<LaneCrossings>,
    drives: Vec<Lanes<W>>,
}

/// Impacts and flights of one lane.
#[derive(Clone)]
pub(crate) struct LaneCrossings {
    /// Instant of the last separation; NaN if there was none since the last impact.
    left: f64,
    /// Speeds of approach of the impacts on the lower and the upper flank.
    pub(crate) speeds: [Distribution; 2],
    pub(crate) flights: Distribution,
    /// Sums over a batch: the speeds of the impacts on each flank, the flights and their number.
    pub(crate) batch: [f64; 4],
}

impl<const W: usize> Crossings<W> {
    pub(crate) fn new(contact: usize) -> Self {
        let lane = LaneCrossings {
            left: f64::NAN,
            speeds: [Distribution::new(), Distribution::new()],
            flights: Distribution::new(),
            batch: [0.0; 4],
        };
        let depth = [Lanes([f64::NAN; W]); 2];
        Crossings { contact, depth, lanes: vec![lane; W], drives: Vec::new() }
    }

    pub(crate) fn lane(&mut self, lane: usize) -> &mut LaneCrossings {
        &mut self.lanes[lane]
    }

    /// Forgets what was counted; the contact keeps its flank, and the teeth their instant of separation.
    pub(crate) fn clear(&mut self) {
        for lane in &mut self.lanes {
            lane.speeds = [Distribution::new(), Distribution::new()];
            lane.flights = Distribution::new();
            lane.batch = [0.0; 4];
        }
    }

    /// Reads a step at whose end the contact is `now`.
    #[inline(always)]
    pub(crate) fn look<G: Shape>(&mut self, step: &Look<'_, G, W>, now: &Contact<Lanes<W>>) {
        let depth = depths(now);
        let before = self.depth;
        let mut any = false;
        for i in 0..W {
            any |= (before[0].0[i] > 0.0) != (depth[0].0[i] > 0.0);
            any |= (before[1].0[i] > 0.0) != (depth[1].0[i] > 0.0);
        }
        if any {
            self.locate(step, before, depth);
        }
        self.depth = depth;
    }

    #[inline(never)]
    fn locate<G: Shape>(&mut self, step: &Look<'_, G, W>, before: [Lanes<W>; 2], depth: [Lanes<W>; 2]) {
        let ends = step.arc(self.contact, &mut self.drives);
        for (lane, seen) in self.lanes.iter_mut().enumerate() {
            let is_in = |depth: [Lanes<W>; 2]| depth.map(|d| d.0[lane] > 0.0);
            let (was, is) = (is_in(before), is_in(depth));
            // Before the first step nothing is known.
            if was == is || before[0].0[lane].is_nan() {
                continue;
            }
            let arc = |flank: usize| arc_of(&ends, flank, lane, step.h);
            let start = (step.number[lane] - 1) as f64;
            // Separations first: a step may cross the whole gap.
            for flank in [0, 1] {
                if was[flank] && !is[flank] {
                    seen.left = (start + root(&arc(flank))) * step.h;
                }
            }
            for flank in [0, 1] {
                if !was[flank] && is[flank] {
                    let arc = arc(flank);
                    let at = root(&arc);
                    seen.impact(flank, (slope(&arc, at) / step.h).max(0.0), (start + at) * step.h);
                }
            }
        }
    }
}

impl LaneCrossings {
    fn impact(&mut self, flank: usize, speed: f64, t: f64) {
        self.speeds[flank].add(speed);
        self.batch[flank] += speed;
        if self.left.is_finite() {
            let flight = t - self.left;
            self.flights.add(flight);
            self.batch[2] += flight;
            self.batch[3] += 1.0;
        }
        self.left = f64::NAN;
    }
}

/// Penetrations of the lower and the upper flank.
#[inline(always)]
fn depths<const W: usize>(contact: &Contact<Lanes<W>>) -> [Lanes<W>; 2] {
    [contact.lower - contact.deflection, contact.deflection - contact.upper]
}

/// Penetration of a flank at both ends of an arc, and its slopes over the step.
fn arc_of<const W: usize>(ends: &[Contact<Lanes<W>>; 2], flank: usize, lane: usize, h: f64) -> [f64; 4] {
    let [start, end] = ends.each_ref().map(|contact| {
        let rates = [contact.lower_rate - contact.rate, contact.rate - contact.upper_rate];
        [depths(contact)[flank].0[lane], h * rates[flank].0[lane]]
    });
    [start[0], end[0], start[1], end[1]]
}

/// Cubic with the values d0, d1 and the slopes s0, s1 at the ends of [0, 1].
fn value([d0, d1, s0, s1]: &[f64; 4], x: f64) -> f64 {
    let y = 1.0 - x;
    y * y * (d0 * (1.0 + 2.0 * x) + s0 * x) + x * x * (d1 * (1.0 + 2.0 * y) - s1 * y)
}

fn slope([d0, d1, s0, s1]: &[f64; 4], x: f64) -> f64 {
    let y = 1.0 - x;
    6.0 * x * y * (d1 - d0) + s0 * y * (y - 2.0 * x) + s1 * x * (x - 2.0 * y)
}

/// A root of the cubic in [0, 1], by Newton's method between bounds; 0 if a jump of the drives has passed the
/// edge.
fn root(arc: &[f64; 4]) -> f64 {
    let out = arc[0] > 0.0;
    if out == (arc[1] > 0.0) {
        return 0.0;
    }
    let [mut low, mut high] = [0.0, 1.0];
    let mut x = arc[0] / (arc[0] - arc[1]);
    for _ in 0..30 {
        let y = value(arc, x);
        if (y > 0.0) == out {
            low = x;
        } else {
            high = x;
        }
        let newton = x - y / slope(arc, x);
        let next = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() < 1e-9 {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::{root, slope, value};

    /// The cubic (x - 0.3) (x + 1) (2 - x), and one that crosses at 0.9 only after a flat start.
    #[test]
    fn roots_and_slopes_of_cubics() {
        let cubic = |x: f64| (x - 0.3) * (x + 1.0) * (2.0 - x);
        let rate = |x: f64| (x + 1.0) * (2.0 - x) + (x - 0.3) * (2.0 - x) - (x - 0.3) * (x + 1.0);
        let arc = [cubic(0.0), cubic(1.0), rate(0.0), rate(1.0)];
        assert!(
            (value(&arc, 0.7) - cubic(0.7)).abs() < 1e-14 && (slope(&arc, 0.7) - rate(0.7)).abs() < 1e-14
        );
        assert!((root(&arc) - 0.3).abs() < 1e-9);
        let late = [-0.729, 0.271, 0.0, 3.0]; // x³ - 0.9³
        assert!((root(&late) - 0.9).abs() < 1e-9);
        assert_eq!(root(&[0.1, 0.2, 1.0, 1.0]), 0.0);
    }
}
