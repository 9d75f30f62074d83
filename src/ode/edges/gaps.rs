//! Whether a step resolves its gaps.
//!
//! In free flight no force depends on the deflection: the error estimate sees neither the error excitation nor a moving edge, and steps
//! grow over many of their periods. So the distance of every contact from its edges is compared, inside each step, with the cubic
//! through the ends of the step. The coordinates are taken on their own cubic, so that only what moves with the drives is left of the
//! difference.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::model::equations::Model;
use crate::ode::edges::exit::{Exit, scale};
use crate::ode::edges::hermite::Hermite;
use crate::ode::stepping::engine::{Engine, Tableau};
use crate::ode::stepping::vector::Vector;

/// The cubic may miss the distance by this share of its range over the step ...
const SHARE: f64 = 0.005;

/// ... or by this share of the gap.
const FLOOR: f64 = 1e-6;

/// ... or by this many times what rounding moves it by.
const ROUNDINGS: f64 = 16.0;

/// A step this much longer than any found resolved at many places is looked at there, others at one node.
const GROWTH: f64 = 1.25;

/// Those places: multiples of the golden ratio, modulo 1, in step with no period.
const PLACES: [f64; 8] = [
    0.618_033_988_749_895,
    0.236_067_977_499_79,
    0.854_101_966_249_684,
    0.472_135_954_999_579,
    0.090_169_943_749_474,
    0.708_203_932_499_369,
    0.326_237_921_249_264,
    0.944_271_909_999_159,
];

/// Two of them, through which a cubic is laid that needs no rates.
const INNER: [usize; 2] = [1, 5];

/// What was missed in earlier steps counts by this much less with each step: where a wave bends the other way, its cubic is met by chance.
const FADING: f64 = 0.8;

/// It grows with the fourth power of the step, up to this factor.
const FOURTH: f64 = 256.0;

/// Steps made again in a row before a jump that no drive announced is taken as it is.
const RETRIES: u8 = 8;

/// Both ways out of a gap, or the one out of a flank.
type Distances = [f64; 2];

/// The gaps of one run, seen inside its steps.
pub(crate) struct Gaps {
    /// Distances at `PLACES`.
    places: Vec<[Distances; PLACES.len()]>,
    /// By how much the cubic of each exit was missed in the step, at the least.
    off: Vec<Distances>,
    /// The same of the steps before, fading, and the length of the step in which it was seen.
    known: Vec<[(f64, f64); 2]>,
    /// The longest step found resolved.
    longest: f64,
    /// A fixed step is too long for its edges: every step is looked at in many places.
    coarse: bool,
    retries: u8,
}

/// What a look into a step said.
pub(crate) enum Resolved {
    /// The next step may be this many times as long.
    Yes(f64),
    /// The step is to be made again, this many times as long.
    No(f64),
}

impl Gaps {
    pub(crate) fn new(contacts: usize) -> Self {
        Gaps {
            places: vec![[[0.0; 2]; PLACES.len()]; contacts],
            off: vec![[0.0; 2]; contacts],
            known: vec![[(0.0, 1.0); 2]; contacts],
            longest: 0.0,
            coarse: false,
            retries: 0,
        }
    }

    /// By how much the cubic of an exit was missed.
    #[inline]
    pub(crate) fn off(&self, contact: usize, way: usize) -> f64 {
        self.off[contact][way]
    }

    /// Looks into the step just made, from `start` to `end`.
    #[inline]
    pub(crate) fn look<T: Tableau, M: Model + ?Sized, V: Vector>(
        &mut self,
        e: &mut Engine<'_, M, V>,
        start: &[Contact],
        end: &[Contact],
        noise: &[f64],
    ) -> Resolved {
        let h = e.h();
        e.contacts_on_cubic::<T>(T::PROBE);
        let mut ratio = 0.0f64;
        for i in 0..start.len() {
            for way in 0..2 {
                let Some(exit) = Exit::of(i, e.pieces[i])[way] else { break };
                let from = e.pieces[i];
                let (d0, d, d1) = (
                    exit.distance(from, &start[i], h),
                    exit.distance(from, &e.contacts[i], h),
                    exit.distance(from, &end[i], h),
                );
                if !d.value.is_finite() {
                    self.off[i][way] = 0.0;
                    continue;
                }
                let seen = (d.value - Hermite::new(d0, d1).at(T::PROBE)).abs();
                let (missed, length) = self.known[i][way];
                let off =
                    seen.max(if missed > 0.0 { missed * (h / length).powi(4).min(FOURTH) } else { 0.0 });
                self.off[i][way] = off;
                if e.pieces[i] == Piece::Gap {
                    ratio = ratio.max(off / allowed(&end[i], noise[i], [d0.value, d.value, d1.value]));
                }
            }
        }
        let closely = (ratio > 1.0 && T::ADAPTIVE) || self.coarse || h > GROWTH * self.longest;
        if closely {
            ratio = self.look_closely::<T, M, V>(e, start, end, noise, ratio);
        }
        if ratio <= 1.0 || !T::ADAPTIVE || self.retries >= RETRIES {
            self.coarse |= ratio > 1.0 && !T::ADAPTIVE;
            for ((off, known), c) in self.off.iter().zip(&mut self.known).zip(end) {
                // What rounding leaves does not grow with the step.
                let least = 1e-3 * FLOOR * scale(c);
                for way in 0..2 {
                    known[way] = (if off[way] > least { FADING * off[way] } else { 0.0 }, h);
                }
            }
            if closely {
                self.longest = self.longest.max(h);
            }
            self.retries = 0;
            return Resolved::Yes(if ratio > 0.0 { 0.9 / ratio.sqrt().sqrt() } else { f64::INFINITY });
        }
        self.retries += 1;
        self.longest = self.longest.min(0.5 * h);
        Resolved::No((0.9 / ratio.sqrt().sqrt()).clamp(0.2, 0.7))
    }

    /// The same at many places, by the cubic through the ends with their rates and by one through values alone, should the model not
    /// give its rates: the better of the two counts.
    #[cold]
    fn look_closely<T: Tableau, M: Model + ?Sized, V: Vector>(
        &mut self,
        e: &mut Engine<'_, M, V>,
        start: &[Contact],
        end: &[Contact],
        noise: &[f64],
        ratio: f64,
    ) -> f64 {
        let h = e.h();
        for (p, &theta) in PLACES.iter().enumerate() {
            e.contacts_on_cubic::<T>(theta);
            for (i, places) in self.places.iter_mut().enumerate() {
                for (way, exit) in Exit::of(i, e.pieces[i]).into_iter().enumerate() {
                    places[p][way] = exit
                        .map_or(f64::INFINITY, |exit| exit.distance(e.pieces[i], &e.contacts[i], h).value);
                }
            }
        }
        let mut by_values = 0.0f64;
        let mut by_rates = ratio;
        for i in 0..start.len() {
            for (way, exit) in Exit::of(i, e.pieces[i]).into_iter().enumerate() {
                let Some(exit) = exit else { continue };
                let [d0, d1] = [&start[i], &end[i]].map(|c| exit.distance(e.pieces[i], c, h));
                let value = |p: usize| self.places[i][p][way];
                if !(0..PLACES.len()).all(|p| value(p).is_finite()) {
                    continue;
                }
                let hermite = Hermite::new(d0, d1);
                let nodes = [0.0, PLACES[INNER[0]], PLACES[INNER[1]], 1.0];
                let values = [d0.value, value(INNER[0]), value(INNER[1]), d1.value];
                let mut range = [d0.value.min(d1.value), d0.value, d0.value.max(d1.value)];
                let (mut off, mut off_values) = (self.off[i][way], 0.0f64);
                for (p, &theta) in PLACES.iter().enumerate() {
                    range = [range[0].min(value(p)), range[1], range[2].max(value(p))];
                    off = off.max((value(p) - hermite.at(theta)).abs());
                    off_values = off_values.max((value(p) - lagrange(nodes, values, theta)).abs());
                }
                self.off[i][way] = off;
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

/// How far the cubic may miss a distance with these values in the step, which rounding moves by `noise`.
#[inline]
fn allowed(c: &Contact, noise: f64, values: [f64; 3]) -> f64 {
    let [a, b, c_] = values;
    let range = a.max(b).max(c_) - a.min(b).min(c_);
    (SHARE * range + FLOOR * scale(c)).max(ROUNDINGS * noise).max(f64::MIN_POSITIVE)
}

/// The cubic through four points.
fn lagrange(x: [f64; 4], f: [f64; 4], at: f64) -> f64 {
    (0..4)
        .map(|i| f[i] * (0..4).filter(|&j| j != i).map(|j| (at - x[j]) / (x[i] - x[j])).product::<f64>())
        .sum()
}
