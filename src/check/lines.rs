//! Bends and jumps of the acceleration that no contact tells of, looked for along lines through the typical state.

use crate::check::inconsistency::Inconsistency;
use crate::check::point::Point;
use crate::model::equations::Model;

/// Equal parts of a line, and of a window that is looked at.
const PARTS: usize = 32;

const WINDOW: usize = 8;

/// Lines reach to twenty times the size of the coordinates, and to ever smaller distances.
const REACHES: i32 = 10;

/// Share of the second differences of a window that its two largest neighbours hold: 2/7 on a smooth curve, 1 at a kink. Above the first a
/// kink is suspected, above the second it is certain.
const SUSPECT: f64 = 0.45;

const CERTAIN: f64 = 0.9;

/// Times that a window is narrowed, each to 3/8, and after how many a bend is certain.
const LEVELS: usize = 14;

const LEAST: usize = 6;

/// Narrowing a window to 3/8 leaves 3/8 of the second difference at a kink, (3/8)² = 0.14 of that of a smooth curve, (3/8)^1.5 = 0.23 of
/// that of a cusp x^1.5. Below this share it is no kink.
const LEFT: f64 = 0.3;

/// The strongest bend over equal parts: between which nodes, how strong, and its share of all.
struct Bend {
    node: usize,
    strength: f64,
    share: f64,
}

impl Bend {
    /// Of the values at the ends of the parts.
    fn of(f: &[f64]) -> Bend {
        let bends: Vec<f64> = f.windows(3).map(|f| (f[2] - 2.0 * f[1] + f[0]).abs()).collect();
        let total: f64 = bends.iter().sum();
        let pairs = bends.windows(2).map(|pair| pair[0] + pair[1]).enumerate();
        let (node, strength) = pairs.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
        Bend { node, strength, share: if total > 0.0 { strength / total } else { 0.0 } }
    }
}

impl<M: Model + ?Sized> Point<'_, M> {
    /// The first bend found along the ray through the typical coordinates, and along each coordinate over several reaches.
    pub(crate) fn untold_kinks(&mut self, findings: &mut Vec<Inconsistency>) {
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

    fn along(&self, line: &dyn Fn(f64) -> Vec<f64>, reach: f64) -> Option<Inconsistency> {
        let n = self.model.dof();
        let node = |i: usize| reach * (2.0 * i as f64 / PARTS as f64 - 1.0);
        let values: Vec<Vec<f64>> = (0..=PARTS).map(|i| self.accel(&line(node(i)), &self.state.v)).collect();
        for first in (0..=PARTS - WINDOW).step_by(WINDOW / 2) {
            for component in 0..n {
                let f: Vec<f64> = values[first..=first + WINDOW].iter().map(|a| a[component]).collect();
                let bend = Bend::of(&f);
                if !f.iter().all(|f| f.is_finite())
                    || bend.share < SUSPECT
                    || bend.strength <= self.noise(component, &f)
                {
                    continue;
                }
                let (lo, hi) = (node(first + bend.node), node(first + bend.node + 3));
                if self.told(line, lo, hi) {
                    continue;
                }
                if let Some(s) = self.narrow(line, component, lo, hi) {
                    return Some(Inconsistency::UntoldKink { component, q: line(s) });
                }
            }
        }
        None
    }

    /// What rounding may make of second differences.
    fn noise(&self, component: usize, f: &[f64]) -> f64 {
        let largest = f.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        256.0 * f64::EPSILON * (self.terms[component] + largest)
    }

    /// Follows a bend into ever shorter windows, until rounding ends it.
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
            let seen = bend.strength > self.noise(component, &f);
            if !seen {
                break;
            }
            // The first windows may hold other curves beside a bend.
            if level > 2 && bend.strength < LEFT * last {
                return None;
            }
            last = bend.strength;
            certain = (level >= LEAST && bend.share >= CERTAIN).then_some(0.5 * (lo + hi));
            (lo, hi) = (node(bend.node), node(bend.node + 3));
        }
        certain.filter(|_| !self.told(line, lo - (hi - lo), hi + (hi - lo)))
    }

    /// Whether a contact is at an edge somewhere between two points of a line.
    fn told(&self, line: &dyn Fn(f64) -> Vec<f64>, lo: f64, hi: f64) -> bool {
        let [a, b] = [lo, hi].map(|s| self.contacts(&line(s), &self.state.v));
        a.iter().zip(&b).any(|(a, b)| {
            (a.deflection - a.lower) * (b.deflection - b.lower) <= 0.0
                || (a.deflection - a.upper) * (b.deflection - b.upper) <= 0.0
        })
    }
}
