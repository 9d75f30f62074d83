//! Tooth edges: which contact leaves its piece first, and when.

use super::engine::{Engine, Tableau};
use super::step::Crossing;
use super::vector::Vector;
use crate::model::{Contact, Model};
use crate::piece::Piece;

/// How far a deflection may lie past its edge before it counts: this share of the gap. Less changes the force by less than
/// the stiffness times it, far below the tolerance of any step.
const SLACK: f64 = 1e-10;
/// How closely an edge is met: this share of the gap.
const CLOSE: f64 = 1e-13;
/// Contacts this close to their edges, in shares of the gap, may cross together with the one located.
const WITH: f64 = 1e-6;
/// An extremum this close to an edge, measured by its own rise, is looked at closely.
const NEAR: f64 = 0.25;
/// Refinements of one root; bisection alone would need about 50.
const MOST: usize = 60;

/// The distance of a contact from one edge of its piece, positive inside, with its rate per unit of θ.
#[derive(Clone, Copy, Debug, Default)]
struct Distance {
    value: f64,
    rate: f64,
}

/// One way for a contact to leave its piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Exit {
    pub(crate) contact: usize,
    pub(crate) to: Piece,
}

impl Exit {
    /// The ways out of a piece.
    fn of(contact: usize, piece: Piece) -> [Option<Exit>; 2] {
        let exit = |to| Some(Exit { contact, to });
        match piece {
            Piece::Lower | Piece::Upper => [exit(Piece::Gap), None],
            Piece::Gap => [exit(Piece::Lower), exit(Piece::Upper)],
        }
    }

    /// Its distance, when standing on `from`.
    #[inline]
    fn distance(self, from: Piece, c: &Contact, h: f64) -> Distance {
        let lower = |sign: f64| Distance { value: sign * (c.deflection - c.lower), rate: h * sign * (c.rate - c.lower_rate) };
        let upper = |sign: f64| Distance { value: sign * (c.upper - c.deflection), rate: h * sign * (c.upper_rate - c.rate) };
        match (from, self.to) {
            (Piece::Lower, _) => lower(-1.0),
            (Piece::Upper, _) => upper(-1.0),
            (Piece::Gap, Piece::Lower) => lower(1.0),
            (Piece::Gap, _) => upper(1.0),
        }
    }
}

/// The length that slack is measured by: the gap, or the deflection where there is none.
#[inline]
fn scale(c: &Contact) -> f64 {
    let gap = c.upper - c.lower;
    if gap > 0.0 && gap.is_finite() { gap } else { c.deflection.abs().max(f64::MIN_POSITIVE / SLACK) }
}

/// The contacts of one run: where they stood at the start of the step, and on which piece.
pub(crate) struct Locator {
    start: Vec<Contact>,
    end: Vec<Contact>,
    /// Which contacts are known to jump in force at their edges.
    pub(crate) jumps: Vec<Option<bool>>,
    /// Changes of piece since time last moved.
    still: Vec<u8>,
}

/// What was found in a step.
pub(crate) enum Found {
    /// No contact leaves its piece.
    Nothing,
    /// This one does, at θ.
    At(f64, Exit),
    /// This one left already when the step began.
    AtOnce(Exit),
}

impl Locator {
    /// How often a contact may change its piece without time moving: once through the gap and back would be two.
    const STILL: u8 = 4;

    pub(crate) fn new(contacts: usize) -> Self {
        Locator {
            start: vec![Contact::default(); contacts],
            end: vec![Contact::default(); contacts],
            jumps: vec![None; contacts],
            still: vec![0; contacts],
        }
    }

    /// Reads off the pieces at the start: by the deflection, on an edge by the rate. A contact that still lies on its own
    /// piece within the slack stays there.
    pub(crate) fn classify<M: Model + ?Sized, V: Vector>(&mut self, e: &mut Engine<'_, M, V>, afresh: bool) {
        e.contacts_at_start();
        self.start.copy_from_slice(&e.contacts);
        for (piece, c) in e.pieces.iter_mut().zip(&self.start) {
            let slack = SLACK * scale(c);
            let (above, below) = (c.deflection - c.upper, c.lower - c.deflection);
            let inside = match *piece {
                Piece::Lower => below >= -slack,
                Piece::Gap => above <= slack && below <= slack,
                Piece::Upper => above >= -slack,
            };
            if inside && !afresh {
                continue;
            }
            *piece = if above > slack || (above >= -slack && c.rate > c.upper_rate) {
                Piece::Upper
            } else if below > slack || (below >= -slack && c.rate < c.lower_rate) {
                Piece::Lower
            } else {
                Piece::Gap
            };
        }
    }

    /// The end of the step becomes the start of the next.
    #[inline(always)]
    pub(crate) fn accept<M: Model + ?Sized, V: Vector>(&mut self, e: &Engine<'_, M, V>) {
        self.start.copy_from_slice(&e.contacts);
        self.still.fill(0);
    }

    /// Moves a contact to another piece; `false` when it has done so too often at this instant.
    pub(crate) fn change(&mut self, pieces: &mut [Piece], exit: Exit) -> bool {
        pieces[exit.contact] = exit.to;
        self.still[exit.contact] += 1;
        self.still[exit.contact] <= Self::STILL
    }

    /// Every other contact that reaches its edge together with the located one: within the slack, or within the time by which that
    /// one's edge was missed.
    pub(crate) fn together<'a>(&'a self, pieces: &'a [Piece], contacts: &'a [Contact], located: Exit) -> impl Iterator<Item = Exit> + 'a {
        let (value, rate, _) = self.miss(pieces, contacts, located);
        let time = if rate == 0.0 { 0.0 } else { 2.0 * (value / rate).abs() };
        let others = (0..contacts.len()).filter(move |&i| i != located.contact);
        others.flat_map(move |i| {
            Exit::of(i, pieces[i]).into_iter().flatten().filter(move |exit| {
                let d = exit.distance(pieces[i], &contacts[i], 1.0);
                let length = scale(&contacts[i]);
                d.rate < 0.0 && d.value <= (SLACK * length).max((time * d.rate.abs()).min(WITH * length))
            })
        })
    }

    /// Every contact that lies on an edge of its piece, within the slack, and is on its way out.
    pub(crate) fn on_edges<'a>(pieces: &'a [Piece], contacts: &'a [Contact]) -> impl Iterator<Item = Crossing> + 'a {
        (0..contacts.len()).flat_map(move |i| {
            let out = Exit::of(i, pieces[i]).into_iter().flatten().find(move |exit| {
                let d = exit.distance(pieces[i], &contacts[i], 1.0);
                d.rate < 0.0 && d.value <= SLACK * scale(&contacts[i])
            });
            out.map(|exit| Crossing { contact: i, from: pieces[i], to: exit.to })
        })
    }

    /// The first exit inside the step just made; its end contacts are in `e.contacts`.
    pub(crate) fn find<T: Tableau, M: Model + ?Sized, V: Vector>(&mut self, e: &mut Engine<'_, M, V>) -> Found {
        let h = e.h();
        let mut limit = 1.0;
        let mut first = Found::Nothing;
        self.end.copy_from_slice(&e.contacts);
        for (i, (start, end)) in self.start.iter().zip(&self.end).enumerate() {
            for exit in Exit::of(i, e.pieces[i]).into_iter().flatten() {
                let (d0, d1) = (exit.distance(e.pieces[i], start, h), exit.distance(e.pieces[i], end, h));
                let slack = SLACK * scale(end);
                let hermite = Hermite::new(d0, d1);
                if d1.value == f64::INFINITY || (d1.value >= -slack && !hermite.may_dip(d0, d1)) {
                    continue;
                }
                match first_root::<T, M, V>(e, exit, d0, d1, &hermite, limit, slack) {
                    Some(0.0) => return Found::AtOnce(exit),
                    Some(theta) => {
                        limit = theta;
                        first = Found::At(theta, exit);
                    }
                    None => {}
                }
            }
        }
        // Looking inside the step overwrote these.
        e.contacts.copy_from_slice(&self.end);
        first
    }

    /// Distance of an exit's contact from its edge, its rate in time, and the length to measure it by.
    pub(crate) fn miss(&self, pieces: &[Piece], contacts: &[Contact], exit: Exit) -> (f64, f64, f64) {
        let c = &contacts[exit.contact];
        let d = exit.distance(pieces[exit.contact], c, 1.0);
        (d.value, d.rate, scale(c))
    }
}

/// The first θ in (0, limit] at which the distance changes sign, on the dense output. 0.0: it was past its edge from the start.
fn first_root<T: Tableau, M: Model + ?Sized, V: Vector>(
    e: &mut Engine<'_, M, V>,
    exit: Exit,
    d0: Distance,
    d1: Distance,
    hermite: &Hermite,
    limit: f64,
    slack: f64,
) -> Option<f64> {
    e.prepare_dense::<T>();
    let from = e.pieces[exit.contact];
    let h = e.h();
    let mut look = |theta: f64| {
        e.contacts_inside::<T>(theta);
        exit.distance(from, &e.contacts[exit.contact], h)
    };
    let (mut a, mut da) = (0.0, d0);
    // Just past the edge, or on it: it may have come in from there, or be on its way out.
    let on_edge = d0.value <= slack;
    if on_edge && d0.rate <= 0.0 {
        return if d1.value < -slack || look(hermite.lowest().unwrap_or(0.5)).value < -slack { Some(0.0) } else { None };
    }
    // One that came in a little past its edge, because the edge was met no closer, may be as far out for as long.
    let close = slack / SLACK * CLOSE;
    let slack = if on_edge { slack.max(-d0.value) } else { slack };
    // Walk over the extrema that the cubic through both ends suggests.
    let mut stops = [None; 3];
    for (stop, theta) in stops.iter_mut().zip(hermite.extrema().into_iter().flatten()) {
        *stop = Some(theta);
    }
    stops[2] = Some(1.0);
    for theta in stops.into_iter().flatten() {
        let b = theta.min(limit);
        if b <= a {
            continue;
        }
        let db = if b == 1.0 { d1 } else { look(b) };
        if on_edge && a == 0.0 && db.value < -slack {
            // Came in over this edge: divide its root at zero out.
            let f = |theta: f64, d: Distance| (d.value - d0.value) / theta;
            let (mut lo, mut hi) = (0.0, b);
            for _ in 0..MOST {
                let mid = 0.5 * (lo + hi);
                if f(mid, look(mid)) > 0.0 {
                    lo = mid
                } else {
                    hi = mid
                }
                if hi - lo < 1e-14 {
                    break;
                }
            }
            return Some(if lo == 0.0 { 0.0 } else { hi });
        }
        if db.value < -slack {
            return Some(root(&mut look, (a, da), (b, db), close));
        }
        // A dip between two safe ends: find its bottom.
        if da.rate < 0.0 && db.rate > 0.0 {
            let (mut lo, mut hi) = ((a, da), (b, db));
            for _ in 0..MOST {
                let m = lo.0 + (hi.0 - lo.0) * (lo.1.rate / (lo.1.rate - hi.1.rate)).clamp(0.1, 0.9);
                let dm = look(m);
                if dm.value < -slack {
                    return Some(root(&mut look, (a, da), (m, dm), close));
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
/// A sign change between `a` (inside) and `b` (outside): Newton, kept inside its bracket.
fn root(look: &mut impl FnMut(f64) -> Distance, a: (f64, Distance), b: (f64, Distance), close: f64) -> f64 {
    let (mut lo, mut hi) = (a, b);
    let mut theta = lo.0 + (hi.0 - lo.0) * lo.1.value / (lo.1.value - hi.1.value);
    for _ in 0..MOST {
        let d = look(theta);
        if d.value.abs() <= close {
            break;
        }
        if d.value > 0.0 {
            lo = (theta, d)
        } else {
            hi = (theta, d)
        }
        if hi.0 - lo.0 <= 1e-15 {
            break;
        }
        let newton = theta - d.value / d.rate;
        theta = if newton > lo.0 && newton < hi.0 { newton } else { 0.5 * (lo.0 + hi.0) };
    }
    theta
}

/// The cubic through values and rates at both ends of a step: cheap, and good enough to say where to look.
struct Hermite {
    value: f64,
    /// θ, θ², θ³.
    powers: [f64; 3],
}

impl Hermite {
    #[inline]
    fn new(d0: Distance, d1: Distance) -> Self {
        let rise = d1.value - d0.value;
        Hermite { value: d0.value, powers: [d0.rate, 3.0 * rise - 2.0 * d0.rate - d1.rate, d0.rate + d1.rate - 2.0 * rise] }
    }

    fn at(&self, theta: f64) -> f64 {
        let [a, b, c] = self.powers;
        self.value + theta * (a + theta * (b + theta * c))
    }

    /// Its extrema inside the step, in order.
    fn extrema(&self) -> [Option<f64>; 2] {
        let [a, b, c] = self.powers;
        let disc = b * b - 3.0 * a * c;
        if disc <= 0.0 {
            return [None; 2];
        }
        // a + 2 b θ + 3 c θ² = 0 without cancellation.
        let s = -(b + disc.sqrt().copysign(b));
        let (r1, r2) = (s / (3.0 * c), a / s);
        let inside = |r: f64| (r > 0.0 && r < 1.0).then_some(r);
        let (first, second) = if r1 < r2 { (r1, r2) } else { (r2, r1) };
        [inside(first), inside(second)]
    }

    /// Where it is lowest inside the step.
    fn lowest(&self) -> Option<f64> {
        self.extrema().into_iter().flatten().min_by(|x, y| self.at(*x).total_cmp(&self.at(*y)))
    }

    /// Whether it comes so close to zero inside the step that the dense output has to be asked.
    #[inline]
    fn may_dip(&self, d0: Distance, d1: Distance) -> bool {
        // With both ends moving away from a dip there is none, and a cubic dips at most 4/27 of its end rates.
        let ends = d0.value.min(d1.value);
        if (d0.rate >= 0.0 && d1.rate <= 0.0) || ends > 0.2 * (d0.rate.abs() + d1.rate.abs()) {
            return false;
        }
        self.lowest().is_some_and(|theta| {
            let bottom = self.at(theta);
            bottom < NEAR * (ends - bottom)
        })
    }
}
