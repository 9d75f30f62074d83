//! Whether a step resolves its gaps.
//!
//! In free flight no force depends on the deflection. The error estimate then contains neither the
//! transmission error nor the motion of an edge, and steps grow over many periods of these. Therefore each
//! step compares the distance of every contact from its edges with the cubic through the values and rates at
//! the ends of the step. The coordinates inside the step are taken from their own cubics, so that only terms
//! that depend on the drives contribute to the difference.

use crate::contact::edge::Edge;
use crate::contact::{Contact, Piece};
use crate::numeric::lagrange::cubic;
use crate::numeric::search::extremes::{larger, smaller};
use crate::numeric::search::hermite::{Distance, Hermite};
use crate::numeric::spread::GOLDEN_POINTS;
use crate::ode::edges::exit::{distances, scale};
use crate::ode::stepping::control::RESOLUTION;
use crate::ode::stepping::ends::Ends;
use crate::ode::stepping::engine::{Engine, Tableau};
use crate::ode::stepping::vector::Vector;

/// Allowed deviation of a distance from its cubic, as a share of the range of the distance in the step `[1]`.
const DEVIATION: f64 = 0.005;

/// Additional allowed deviation, as a share of the distance from the edge, at most of the gap `[1]`.
const FLOOR: f64 = 1e-6;

/// Deviations below this share of the additional allowed one count as rounding `[1]`.
const UNSEEN: f64 = 1e-3;

/// Minimum of the allowed deviation, in units of the effect of rounding on the deflection.
const ROUNDINGS: f64 = 16.0;

/// A step is sampled at all `GOLDEN_POINTS` if it is longer than this factor times the longest step that was
/// found resolved there. Other steps are sampled at one node.
const UNSAMPLED_GROWTH: f64 = 1.25;

/// Indices of two `GOLDEN_POINTS`. They and the ends of the step define a cubic that needs no rates.
const INNER: [usize; 2] = [1, 5];

/// Factor by which the deviation of earlier steps decreases with each step. It is kept for some steps because
/// a wave may coincide with its cubic near an inflection.
const FADING: f64 = 0.8;

/// The kept deviation grows with the fourth power of the step, up to this factor.
const FOURTH: f64 = 256.0;

/// Maximum number of consecutive repetitions of a step. Then the step is accepted as it is: the cause may be
/// a jump that the model does not report as a drive edge.
const RETRIES: u8 = 8;

/// A step of at most this number of resolutions of the time is accepted without a check. In such a step the
/// rounding of the time makes moving edges deviate from their cubics.
const ROUNDED: f64 = 64.0;

/// The distance of a contact from the edge of one exit in the current step; rates per unit of θ.
#[derive(Clone, Copy, Default)]
pub(crate) struct Seen {
    pub(crate) start: Distance,
    pub(crate) end: Distance,
    /// Deviation from its cubic: the larger of the one measured in this step and the one kept from earlier
    /// steps, scaled to the length of this step.
    pub(crate) off: f64,
}

/// Check of the gaps inside the steps of one run.
pub(crate) struct Gaps {
    /// Distances at `GOLDEN_POINTS`, for each contact and exit.
    places: Vec<[[f64; 2]; GOLDEN_POINTS.len()]>,
    /// The distances in the current step, for each contact and exit.
    pub(crate) seen: Vec<[Seen; 2]>,
    /// Deviation kept from the steps before.
    known: Vec<[f64; 2]>,
    /// Length of the last of these steps.
    length: f64,
    /// Longest step that was found resolved at all `GOLDEN_POINTS`.
    longest: f64,
    /// The fixed step is too long to resolve the gaps: every step is sampled at all `GOLDEN_POINTS`.
    coarse: bool,
    /// Number of consecutive repetitions of the current step.
    retries: u8,
}

/// Result of the check of one step.
pub(crate) enum Resolved {
    /// The step is accepted. The length of the next step is at most this factor times the length of this one.
    Yes(f64),
    /// The step must be repeated with this factor times its length.
    No(f64),
}

impl Gaps {
    pub(crate) fn new(contacts: usize) -> Self {
        Gaps {
            places: vec![[[0.0; 2]; GOLDEN_POINTS.len()]; contacts],
            seen: vec![[Seen::default(); 2]; contacts],
            known: vec![[0.0; 2]; contacts],
            length: 1.0,
            longest: 0.0,
            coarse: false,
            retries: 0,
        }
    }

    /// Checks the current step. `start`, `end`: the contacts at its ends; `noise`: the effect of rounding on
    /// each deflection.
    #[inline]
    pub(crate) fn look<T: Tableau, V: Vector>(
        &mut self,
        e: &mut Engine<'_, V>,
        start: &[Contact],
        end: &[Contact],
        noise: &[f64],
    ) -> Resolved {
        let (e, theta) = (&mut e.ends, T::NODES[T::PROBE]);
        let h = e.h();
        e.contacts_at_node(T::PROBE, theta);
        let mut ratio = 0.0f64;
        let growth = (h / self.length).powi(4).min(FOURTH);
        let states = start.iter().zip(&e.contacts).zip(end).zip(&e.pieces);
        let memory = self.seen.iter_mut().zip(&self.known).zip(noise);
        for ((((start, inside), end), &piece), ((seen, known), &noise)) in states.zip(memory) {
            for (k, &edge) in Edge::around(piece).iter().enumerate() {
                let (seen, known) = (&mut seen[k], known[k]);
                let [d0, d, d1] = distances(edge, piece, [start, inside, end], h);
                (seen.start, seen.end) = (d0, d1);
                if !d.value.is_finite() {
                    continue;
                }
                let off = larger((d.value - Hermite::new(d0, d1).at(theta)).abs(), growth * known);
                seen.off = off;
                if piece == Piece::Gap {
                    ratio = larger(off / allowed(end, noise, [d0.value, d.value, d1.value]), ratio);
                }
            }
        }
        let closely = (ratio > 1.0 && T::ADAPTIVE) || self.coarse || h > UNSAMPLED_GROWTH * self.longest;
        if closely {
            ratio = self.look_closely(e, end, noise, ratio);
        }
        if h <= ROUNDED * RESOLUTION * e.t.abs() {
            self.retries = 0;
            return Resolved::Yes(f64::INFINITY);
        }
        if ratio <= 1.0 || !T::ADAPTIVE || self.retries >= RETRIES {
            self.coarse |= ratio > 1.0 && !T::ADAPTIVE;
            for (((seen, known), c), noise) in self.seen.iter().zip(&mut self.known).zip(end).zip(noise) {
                // Deviations at the level of rounding do not grow with the step and are not kept.
                for (seen, known) in seen.iter().zip(known) {
                    let is_kept = seen.off > ROUNDINGS * noise
                        && seen.off > UNSEEN * FLOOR * reach(c, [seen.start.value, seen.end.value]);
                    *known = if is_kept { FADING * seen.off } else { 0.0 };
                }
            }
            self.length = h;
            if closely {
                self.longest = self.longest.max(h);
            }
            self.retries = 0;
            let limits = T::ADAPTIVE && ratio > 0.0;
            return Resolved::Yes(if limits { 0.9 / ratio.sqrt().sqrt() } else { f64::INFINITY });
        }
        self.retries += 1;
        self.longest = self.longest.min(0.5 * h);
        Resolved::No((0.9 / ratio.sqrt().sqrt()).clamp(0.2, 0.7))
    }

    /// Checks the current step at all `GOLDEN_POINTS` and returns the largest ratio of deviation to allowed
    /// deviation. `ratio` is the ratio known so far.
    ///
    /// Two cubics are compared with the distance: one through values and rates at the ends, and one through
    /// four values, for models that do not give the rates. The smaller ratio is returned.
    #[cold]
    fn look_closely<V: Vector>(
        &mut self,
        e: &mut Ends<'_, V>,
        end: &[Contact],
        noise: &[f64],
        ratio: f64,
    ) -> f64 {
        let h = e.h();
        for (p, &theta) in GOLDEN_POINTS.iter().enumerate() {
            e.contacts_on_cubic(theta);
            for ((places, &piece), c) in self.places.iter_mut().zip(&e.pieces).zip(&e.contacts) {
                for (place, &edge) in places[p].iter_mut().zip(Edge::around(piece)) {
                    let [d] = distances(edge, piece, [c], h);
                    *place = d.value;
                }
            }
        }
        let mut by_values = 0.0f64;
        let mut by_rates = ratio;
        for (i, seen) in self.seen.iter_mut().enumerate() {
            let exits = Edge::around(e.pieces[i]).len();
            for (k, seen) in seen.iter_mut().enumerate().take(exits) {
                let (d0, d1) = (seen.start, seen.end);
                let value = |p: usize| self.places[i][p][k];
                if !(0..GOLDEN_POINTS.len()).all(|p| value(p).is_finite()) {
                    continue;
                }
                let hermite = Hermite::new(d0, d1);
                let nodes = [0.0, GOLDEN_POINTS[INNER[0]], GOLDEN_POINTS[INNER[1]], 1.0];
                let values = [d0.value, value(INNER[0]), value(INNER[1]), d1.value];
                let mut range = [d0.value.min(d1.value), d0.value, d0.value.max(d1.value)];
                let (mut off, mut off_values) = (seen.off, 0.0f64);
                for (p, &theta) in GOLDEN_POINTS.iter().enumerate() {
                    range = [range[0].min(value(p)), range[1], range[2].max(value(p))];
                    off = off.max((value(p) - hermite.at(theta)).abs());
                    off_values = off_values.max((value(p) - cubic(nodes, values, theta)).abs());
                }
                seen.off = off;
                if e.pieces[i] == Piece::Gap {
                    let allowed = allowed(&end[i], noise[i], range);
                    by_rates = by_rates.max(off / allowed);
                    by_values = by_values.max(off_values / allowed);
                }
            }
        }
        by_rates.min(by_values)
    }
}

/// Allowed deviation of a distance from its cubic: max(DEVIATION range + FLOOR reach, ROUNDINGS noise).
/// `values`: values of the distance in the step; `noise`: the effect of rounding on it.
#[inline]
fn allowed(c: &Contact, noise: f64, values: [f64; 3]) -> f64 {
    let [a, b, c_] = values;
    let range = larger(larger(a, b), c_) - smaller(smaller(a, b), c_);
    larger(larger(DEVIATION * range + FLOOR * reach(c, [a, c_]), ROUNDINGS * noise), f64::MIN_POSITIVE)
}

/// Distance from an edge within a step with these values, at most the gap. The motion near one edge of a wide
/// gap does not know of the other edge.
#[inline]
fn reach(c: &Contact, [a, b]: [f64; 2]) -> f64 {
    smaller(scale(c), larger(a.abs(), b.abs()))
}
