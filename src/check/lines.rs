//! Search for kinks and jumps of the acceleration where no contact has an edge, along lines through the
//! typical state.

use crate::check::inconsistency::Inconsistency;
use crate::check::point::CheckPoint;
use crate::contact::edge::Edge;

/// Number of equal parts of a line.
const PARTS: usize = 32;

/// Number of equal parts of a window.
const WINDOW: usize = 8;

/// Number of lines along each coordinate. The first reaches 21 sizes of the coordinates to both sides, each
/// further one a tenth of the one before.
const REACHES: i32 = 10;

/// Share of two neighbouring second differences in the sum over a window above which a kink is suspected. The
/// share is 2/7 on a smooth curve and 1 at a kink.
const SUSPECT: f64 = 0.45;

/// Share above which a kink is certain.
const CERTAIN: f64 = 0.9;

/// Maximum number of windows, each 3/8 of the one before.
const LEVELS: usize = 14;

/// Smallest level of a window at which a kink can be certain.
const LEAST: usize = 6;

/// Smallest factor of the second difference at a kink when the window is narrowed to 3/8. The factor is 3/8
/// at a kink, (3/8)² = 0.14 on a smooth curve and (3/8)^1.5 = 0.23 at a cusp x^1.5.
const LEFT: f64 = 0.3;

/// The two neighbouring second differences of largest sum over equal parts.
struct Bend {
    /// The kink lies between this node and the third node after it.
    node: usize,
    /// Sum of the two absolute second differences.
    strength: f64,
    /// `strength` over the sum of all absolute second differences.
    share: f64,
}

impl Bend {
    /// From the values at the ends of the parts.
    fn of(f: &[f64]) -> Bend {
        let bends: Vec<f64> = f.windows(3).map(|f| (f[2] - 2.0 * f[1] + f[0]).abs()).collect();
        let total: f64 = bends.iter().sum();
        let pairs = bends.windows(2).map(|pair| pair[0] + pair[1]).enumerate();
        let (node, strength) = pairs.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
        Bend { node, strength, share: if total > 0.0 { strength / total } else { 0.0 } }
    }
}

/// Upper bound of the rounding of second differences of an acceleration with the given terms.
fn noise(terms: f64, f: &[f64]) -> f64 {
    let largest = f.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
    256.0 * f64::EPSILON * (terms + largest)
}

impl CheckPoint<'_> {
    /// Reports the first kink along the line through zero and the typical coordinates. If there is none, it
    /// searches along each coordinate, over several reaches.
    pub(crate) fn undeclared_kinks(&mut self, findings: &mut Vec<Inconsistency>) {
        let (q, n) = (self.state.q.clone(), self.model.dof());
        let ray = |s: f64| -> Vec<f64> { q.iter().map(|q| s * q).collect() };
        if q.iter().any(|q| *q != 0.0)
            && let Some(finding) = self.along(&ray, 1.7)
        {
            findings.push(finding);
            return;
        }
        for j in 0..n {
            for k in 0..REACHES {
                let line = |s: f64| {
                    let mut q = q.clone();
                    q[j] += s;
                    q
                };
                if let Some(finding) = self.along(&line, 21.0 * self.size[0] * 0.1f64.powi(k)) {
                    findings.push(finding);
                    return;
                }
            }
        }
    }

    /// Searches along a line from -`reach` to `reach`, in windows that overlap by half.
    fn along(&self, line: &dyn Fn(f64) -> Vec<f64>, reach: f64) -> Option<Inconsistency> {
        let n = self.model.dof();
        let node = |i: usize| reach * (2.0 * i as f64 / PARTS as f64 - 1.0);
        let values: Vec<Vec<f64>> = (0..=PARTS).map(|i| self.accel(&line(node(i)), &self.state.v)).collect();
        for first in (0..=PARTS - WINDOW).step_by(WINDOW / 2) {
            let terms = self.largest_terms(line, node(first), node(first + WINDOW));
            for component in 0..n {
                let f: Vec<f64> = values[first..=first + WINDOW].iter().map(|a| a[component]).collect();
                let bend = Bend::of(&f);
                if !f.iter().all(|f| f.is_finite())
                    || bend.share < SUSPECT
                    || bend.strength <= noise(terms[component], &f)
                {
                    continue;
                }
                let (lo, hi) = (node(first + bend.node), node(first + bend.node + 3));
                if self.told(line, lo, hi) {
                    continue;
                }
                if let Some(s) = self.narrow(line, component, lo, hi) {
                    return Some(Inconsistency::UndeclaredKink { component, q: line(s) });
                }
            }
        }
        None
    }

    /// The larger terms of each acceleration at two points of a line.
    fn largest_terms(&self, line: &dyn Fn(f64) -> Vec<f64>, lo: f64, hi: f64) -> Vec<f64> {
        let [a, b] = [lo, hi].map(|s| self.terms_at(&line(s), &self.state.v));
        a.iter().zip(&b).map(|(a, b)| a.max(*b)).collect()
    }

    /// Narrows the window of a kink until rounding exceeds its second difference. Returns the place of the
    /// kink; `None` if it is not a kink or if a contact has an edge there.
    fn narrow(
        &self,
        line: &dyn Fn(f64) -> Vec<f64>,
        component: usize,
        mut lo: f64,
        mut hi: f64,
    ) -> Option<f64> {
        let (mut certain, mut last) = (None, 0.0);
        for level in 0..LEVELS {
            let node = |i: usize| lo + (hi - lo) * i as f64 / WINDOW as f64;
            let f: Vec<f64> =
                (0..=WINDOW).map(|i| self.accel(&line(node(i)), &self.state.v)[component]).collect();
            let bend = Bend::of(&f);
            let seen = bend.strength > noise(self.largest_terms(line, lo, hi)[component], &f);
            if !seen {
                break;
            }
            // The first windows may contain other curvature as well.
            if level > 2 && bend.strength < LEFT * last {
                return None;
            }
            last = bend.strength;
            certain = (level >= LEAST && bend.share >= CERTAIN).then_some(0.5 * (lo + hi));
            (lo, hi) = (node(bend.node), node(bend.node + 3));
        }
        certain.filter(|_| !self.told(line, lo - (hi - lo), hi + (hi - lo)))
    }

    /// Whether a contact has an edge between two points of a line.
    fn told(&self, line: &dyn Fn(f64) -> Vec<f64>, lo: f64, hi: f64) -> bool {
        let [a, b] = [lo, hi].map(|s| self.contacts(&line(s), &self.state.v));
        a.iter()
            .zip(&b)
            .any(|(a, b)| Edge::BOTH.iter().any(|edge| edge.distance(a) * edge.distance(b) <= 0.0))
    }
}
