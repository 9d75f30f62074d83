//! Tooth edges: which contact leaves its piece first, and when.

use super::engine::{Engine, Tableau};
use super::gaps::{Gaps, Resolved};
use super::hermite::{Distance, Hermite};
use super::stops::Stops;
use super::vector::Vector;
use crate::model::{Contact, Model};
use crate::piece::Piece;

/// How far a deflection may lie past its edge before it counts: this share of the gap. Less changes the force by less than
/// the stiffness times it, far below the tolerance of any step.
const SLACK: f64 = 1e-10;
/// The same of a rigid stop, where velocities jump.
const STOP: f64 = 1e-14;
/// How closely an edge is met: this share of the gap.
const CLOSE: f64 = 1e-13;
/// Slack, in units of what rounding of the coordinates moves the deflection by.
const NOISE: f64 = 4.0;
/// Accepted steps between two measurements of what rounding moves the deflections by.
const LOOKS: u8 = 31;
/// Contacts this close to their edges, in shares of the gap, may cross together with the one located.
const WITH: f64 = 1e-6;
/// An edge within the slack at the end of a step is met there when the distance falls by this many slacks in a step as long.
const PLAIN: f64 = 1e3;
/// A distance may miss its cubic by this many times what it was seen to miss it by.
const DOUBT: f64 = 4.0;
/// A stretch whose middle misses its cubic by less than this share of its range is searched along the cubic; others are halved.
const RESOLVED: f64 = 0.05;
/// Halvings of a step in search of a first root, and the stretch that is left.
const HALVINGS: usize = 10;
const SHORTEST: f64 = 1.0 / 1024.0;
/// Where a stretch is divided: a multiple of the golden ratio modulo 1, so that no wave has a whole number of periods on both sides.
const MIDDLE: f64 = 0.472_135_954_999_579;
/// Refinements of one root; bisection alone would need about 50.
const MOST: usize = 60;

/// One way for a contact to leave its piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Exit {
    pub(crate) contact: usize,
    pub(crate) to: Piece,
}

impl Exit {
    /// The ways out of a piece.
    #[inline]
    pub(super) fn of(contact: usize, piece: Piece) -> [Option<Exit>; 2] {
        let exit = |to| Some(Exit { contact, to });
        match piece {
            Piece::Lower | Piece::Upper => [exit(Piece::Gap), None],
            Piece::Gap => [exit(Piece::Lower), exit(Piece::Upper)],
        }
    }

    /// Its distance, when standing on `from`.
    #[inline(always)]
    pub(super) fn distance(self, from: Piece, c: &Contact, h: f64) -> Distance {
        // Outwards from a flank and inwards from the gap: the side of the edge, and the sign that makes the distance positive inside.
        let lower = if from == Piece::Gap { self.to == Piece::Lower } else { from == Piece::Lower };
        let (edge, edge_rate) = if lower { (c.lower, c.lower_rate) } else { (c.upper, c.upper_rate) };
        let sign = if lower == (from == Piece::Gap) { 1.0 } else { -1.0 };
        Distance { value: sign * (c.deflection - edge), rate: h * sign * (c.rate - edge_rate) }
    }
}

/// The length that slack is measured by: the gap, or the deflection where there is none.
#[inline]
pub(super) fn scale(c: &Contact) -> f64 {
    let gap = c.upper - c.lower;
    if gap > 0.0 && gap.is_finite() { gap } else { c.deflection.abs().max(f64::MIN_POSITIVE / SLACK) }
}

/// The contacts of one run: where they stood at the start of the step, and on which piece.
pub(crate) struct Locator {
    pub(super) start: Vec<Contact>,
    end: Vec<Contact>,
    pub(super) stops: Stops,
    /// Which contacts are known to jump in force at their edges.
    pub(crate) jumps: Vec<Option<bool>>,
    /// Changes of piece since time last moved.
    pub(super) still: Vec<u8>,
    gaps: Gaps,
    /// What rounding of large coordinates moves each deflection by.
    noise: Vec<f64>,
    /// Steps until it is measured again.
    countdown: u8,
    /// How many times as long as this step the next may be.
    pub(crate) growth: f64,
}

/// What was found in a step.
pub(crate) enum Found {
    /// No contact leaves its piece.
    Nothing,
    /// This one does, at θ.
    At(f64, Exit),
    /// This one left already when the step began.
    AtOnce(Exit),
    /// The gaps move too fast for the step: it is to be made again, this many times as long.
    TooLong(f64),
}

impl Locator {
    /// How often a contact may change its piece without time moving: once through the gap and back would be two.
    pub(super) const STILL: u8 = 4;

    pub(crate) fn new(contacts: usize, stops: Stops) -> Self {
        Locator {
            stops,
            start: vec![Contact::default(); contacts],
            end: vec![Contact::default(); contacts],
            jumps: vec![None; contacts],
            still: vec![0; contacts],
            gaps: Gaps::new(contacts),
            noise: vec![0.0; contacts],
            countdown: 0,
            growth: f64::INFINITY,
        }
    }

    /// Reads off the pieces at the start: by the deflection, on an edge by the rate. A contact that still lies on its own
    /// piece within the slack stays there.
    pub(crate) fn classify<M: Model + ?Sized, V: Vector>(&mut self, e: &mut Engine<'_, M, V>, afresh: bool) {
        e.contacts_at_start();
        self.start.copy_from_slice(&e.contacts);
        for (i, (piece, c)) in e.pieces.iter_mut().zip(&self.start).enumerate() {
            let slack = self.slack(i, c);
            let (above, below) = (c.deflection - c.upper, c.lower - c.deflection);
            let inside = match *piece {
                Piece::Lower => below >= -slack,
                Piece::Gap => above <= slack && below <= slack,
                Piece::Upper => above >= -slack,
            };
            if inside && !afresh {
                continue;
            }
            let [lower, upper] = [Piece::Lower, Piece::Upper].map(|on| !self.stops.rigid(i, on));
            *piece = if upper && (above > slack || (above >= -slack && c.rate > c.upper_rate)) {
                Piece::Upper
            } else if lower && (below > slack || (below >= -slack && c.rate < c.lower_rate)) {
                Piece::Lower
            } else {
                Piece::Gap
            };
        }
    }

    /// The end of the step becomes the start of the next.
    #[inline(always)]
    pub(crate) fn accept<M: Model + ?Sized, V: Vector>(&mut self, e: &mut Engine<'_, M, V>) {
        self.start.copy_from_slice(&e.contacts);
        self.still.fill(0);
        if self.countdown == 0 {
            self.measure_noise(e);
        } else {
            self.countdown -= 1;
        }
    }

    /// Measures what rounding moves the deflections by: coordinates may have grown.
    #[cold]
    pub(crate) fn measure_noise<M: Model + ?Sized, V: Vector>(&mut self, e: &mut Engine<'_, M, V>) {
        self.countdown = LOOKS;
        e.rounding_of_contacts(&mut self.noise);
    }

    /// How far contact `i` may lie past its edge before it counts.
    #[inline]
    pub(super) fn slack(&self, i: usize, c: &Contact) -> f64 {
        (self.share(i, SLACK) * scale(c)).max(NOISE * self.noise[i])
    }

    /// A share of the gap, or that for rigid stops.
    #[inline]
    fn share(&self, i: usize, share: f64) -> f64 {
        if self.stops.any(i) { STOP } else { share }
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
                d.rate < 0.0 && d.value <= self.slack(i, &contacts[i]).max((time * d.rate.abs()).min(WITH * length))
            })
        })
    }

    /// The first exit inside the step just made; its end contacts are in `e.contacts`.
    pub(crate) fn find<T: Tableau, M: Model + ?Sized, V: Vector>(&mut self, e: &mut Engine<'_, M, V>) -> Found {
        let h = e.h();
        let mut limit = 1.0;
        let mut first = Found::Nothing;
        self.end.copy_from_slice(&e.contacts);
        match self.gaps.look::<T, M, V>(e, &self.start, &self.end, &self.noise) {
            Resolved::Yes(growth) => self.growth = growth,
            Resolved::No(share) => return Found::TooLong(share),
        }
        for (i, (start, end)) in self.start.iter().zip(&self.end).enumerate() {
            for way in 0..2 {
                let Some(exit) = Exit::of(i, e.pieces[i])[way] else { break };
                let (d0, d1) = (exit.distance(e.pieces[i], start, h), exit.distance(e.pieces[i], end, h));
                let doubt = DOUBT * self.gaps.off(i, way);
                if Hermite::is_clear(d0, d1, doubt) {
                    continue;
                }
                let slack = self.slack(i, end);
                let hermite = Hermite::new(d0, d1);
                // Met just where the step ends: the next one would begin behind it and never tell of it.
                let met = d0.value > slack && d1.value.abs() <= slack && d1.rate < -PLAIN * slack;
                if met && matches!(first, Found::Nothing) {
                    first = Found::At(1.0, exit);
                }
                let clear = d1.value >= -slack && !hermite.may_dip(d0, d1) && (doubt <= slack || hermite.stays_above(doubt));
                if d1.value == f64::INFINITY || clear {
                    continue;
                }
                let close = (self.share(i, CLOSE) * scale(end)).max(self.noise[i]);
                match first_root::<T, M, V>(e, exit, [d0, d1], &hermite, limit, [slack, close]) {
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

    /// Distance of an exit's contact from its edge, its rate in time, and the distance that counts as none.
    pub(crate) fn miss(&self, pieces: &[Piece], contacts: &[Contact], exit: Exit) -> (f64, f64, f64) {
        let c = &contacts[exit.contact];
        let d = exit.distance(pieces[exit.contact], c, 1.0);
        (d.value, d.rate, self.slack(exit.contact, c))
    }
}

/// The first θ in (0, limit] at which the distance changes sign, on the dense output. 0.0: it was past its edge from the start.
fn first_root<T: Tableau, M: Model + ?Sized, V: Vector>(
    e: &mut Engine<'_, M, V>,
    exit: Exit,
    [d0, d1]: [Distance; 2],
    hermite: &Hermite,
    limit: f64,
    [slack, close]: [f64; 2],
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
    if on_edge && d0.rate <= 0.0 && (d1.value < -slack || look(hermite.lowest().unwrap_or(0.5)).value < -slack) {
        return Some(0.0);
    }
    // If locating left the contact outside its edge by δ, δ is tolerated for this step.
    let slack = if on_edge { slack.max(-d0.value) } else { slack };
    // Divide the step until every stretch is clear of the edge or follows its cubic; search those from left to right.
    let right = if limit == 1.0 { d1 } else { look(limit) };
    let mut ends = [(limit, right); HALVINGS + 1];
    let mut open = 1;
    while open > 0 {
        let (b, db) = ends[open - 1];
        let cubic = Hermite::over(b - a, da, db);
        let m = a + MIDDLE * (b - a);
        let dm = look(m);
        // A slope that is off tells of a wave that the middle meets by chance.
        let off = (dm.value - cubic.at(MIDDLE)).abs().max(0.25 * (dm.rate * (b - a) - cubic.slope(MIDDLE)).abs());
        let (least, most) = (cubic.least(), da.value.max(db.value).max(dm.value));
        let clear = least > DOUBT * off && least > slack && !cubic.may_dip(da, db);
        if dm.value < -slack && db.value >= -slack && m > a {
            ends[open - 1] = (m, dm); // the first root lies before
            continue;
        }
        if !clear && off > slack.max(RESOLVED * (most - least)) && b - a > SHORTEST && open < ends.len() {
            ends[open] = (m, dm);
            open += 1;
            continue;
        }
        if !clear && let Some(theta) = walk(&mut look, (a, da), (b, db), &cubic, (a == 0.0 && on_edge).then_some(d0.value), slack, close) {
            return Some(theta);
        }
        (a, da) = (b, db);
        open -= 1;
    }
    None
}

/// The first root on a stretch that follows its cubic: walks over the extrema that the cubic suggests. `entered`: the distance at the
/// start, when the contact came in over this edge there.
fn walk(
    look: &mut impl FnMut(f64) -> Distance,
    (mut a, mut da): (f64, Distance),
    (end, d_end): (f64, Distance),
    cubic: &Hermite,
    entered: Option<f64>,
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
            // Came in over this edge: divide its root at zero out.
            let f = |theta: f64, d: Distance| (d.value - d0) / theta;
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
            return Some(root(look, (a, da), (b, db), close));
        }
        // A dip between two safe ends: find its bottom.
        if da.rate < 0.0 && db.rate > 0.0 {
            let (mut lo, mut hi) = ((a, da), (b, db));
            for _ in 0..MOST {
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
