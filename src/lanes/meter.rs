//! What is measured while lanes run.
#![allow(clippy::needless_range_loop, reason = "index loops over arrays become vector instructions, iterators do not")]

use super::number::Number;
use crate::model::Contact;
use std::ops::Range;

/// A channel that lanes can read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Coordinate(usize),
    Velocity(usize),
    Deflection(usize),
    Force(usize),
}

/// Sums and extremes of one channel on the grid of the steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChannelMeter<S> {
    pub(crate) sum: S,
    pub(crate) square: S,
    pub(crate) min: S,
    pub(crate) max: S,
}

/// Where one contact has been, on the grid of the steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactMeter {
    /// Samples on the lower and on the upper flank.
    pub(crate) samples: [f64; 2],
    /// Entries into each.
    pub(crate) impacts: [f64; 2],
    /// Largest penetration of each, negative off the flank.
    pub(crate) deepest: [f64; 2],
    /// Least penetration of the better of the two.
    pub(crate) loosest: f64,
}

/// A [`ContactMeter`] in the making. Samples and entries are counted in one number each: whoever was off the flank adds an entry with the
/// sample.
#[derive(Clone, Copy, Debug)]
struct Flanks<S> {
    /// Samples + ENTRY entries.
    visits: [S; 2],
    /// What the next sample on the flank adds: 1, or 1 + ENTRY after one off it.
    next: [S; 2],
    deepest: [S; 2],
    loosest: S,
}

/// Above the number of samples between two readings, so that both counts fit into the 53 bits of one number.
const ENTRY: f64 = (1 << 26) as f64;

/// What one meter of one lane says.
pub(crate) enum Reading {
    Channel(usize, ChannelMeter<f64>),
    Contact(usize, ContactMeter),
}

/// All meters of a batch.
#[derive(Clone, Debug)]
pub(crate) struct Meters<S> {
    kinds: Vec<Kind>,
    channels: Vec<ChannelMeter<S>>,
    contacts: Vec<Flanks<S>>,
    /// Whether penetrations are watched.
    margins: bool,
    /// The contacts that have to be evaluated.
    read: Range<usize>,
}

impl<S: Number> Meters<S> {
    pub(crate) fn new(kinds: &[Kind], contacts: usize, margins: bool) -> Self {
        let zero = S::from(0.0);
        let channel = ChannelMeter { sum: zero, square: zero, min: zero, max: zero };
        let contact = Flanks { visits: [zero; 2], next: [S::from(1.0); 2], deepest: [zero; 2], loosest: zero };
        let read = kinds.iter().fold(0..contacts, |read, kind| match *kind {
            Kind::Deflection(i) | Kind::Force(i) if read.is_empty() => i..i + 1,
            Kind::Deflection(i) | Kind::Force(i) => read.start.min(i)..read.end.max(i + 1),
            _ => read,
        });
        Meters { kinds: kinds.to_vec(), channels: vec![channel; kinds.len()], contacts: vec![contact; contacts], margins, read }
    }

    /// The contacts that have to be evaluated.
    pub(crate) fn contacts(&self) -> Range<usize> {
        self.read.clone()
    }

    /// One sample of everything.
    #[inline(always)]
    pub(crate) fn sample(&mut self, q: &[S], v: &[S], contacts: &[Contact<S>]) {
        let (kinds, channels) = (&self.kinds[..], &mut self.channels[..self.kinds.len()]);
        for c in 0..kinds.len() {
            let x = match kinds[c] {
                Kind::Coordinate(i) => pick(q, i),
                Kind::Velocity(i) => pick(v, i),
                Kind::Deflection(i) => contacts[i].deflection,
                Kind::Force(i) => contacts[i].force,
            };
            channels[c].sample(x);
        }
        for c in 0..self.contacts.len() {
            self.contacts[c].sample(&contacts[c], self.margins);
        }
    }

    /// Forgets what a lane has seen.
    pub(crate) fn restart(&mut self, lane: usize) {
        for contact in &mut self.contacts {
            // As if on both flanks, so that the first sample is no impact.
            contact.next.iter_mut().for_each(|x| x.set_lane(lane, 1.0));
        }
        self.clear(lane);
    }

    /// Starts the sums and extremes of a lane anew.
    pub(crate) fn clear(&mut self, lane: usize) {
        for channel in &mut self.channels {
            channel.sum.set_lane(lane, 0.0);
            channel.square.set_lane(lane, 0.0);
            channel.min.set_lane(lane, f64::INFINITY);
            channel.max.set_lane(lane, f64::NEG_INFINITY);
        }
        for contact in &mut self.contacts {
            contact.visits.iter_mut().for_each(|x| x.set_lane(lane, 0.0));
            contact.deepest.iter_mut().for_each(|x| x.set_lane(lane, f64::NEG_INFINITY));
            contact.loosest.set_lane(lane, f64::INFINITY);
        }
    }

    /// Shows what a lane has seen since it was last read, and clears it.
    pub(crate) fn read(&mut self, lane: usize, mut show: impl FnMut(Reading)) {
        for (i, meter) in self.channels.iter().enumerate() {
            show(Reading::Channel(i, meter.lane(lane)));
        }
        for (i, meter) in self.contacts.iter().enumerate() {
            show(Reading::Contact(i, meter.lane(lane)));
        }
        self.clear(lane);
    }
}

/// One of a few without an index that has to be in memory.
#[inline(always)]
fn pick<S: Copy>(values: &[S], i: usize) -> S {
    match values.len() {
        1 => values[0],
        2 if i == 0 => values[0],
        2 => values[1],
        _ => values[i],
    }
}

impl<S: Number> ChannelMeter<S> {
    #[inline(always)]
    fn sample(&mut self, x: S) {
        self.sum = self.sum + x;
        self.square = self.square + x * x;
        self.min = self.min.min(x);
        self.max = self.max.max(x);
    }

    fn lane(&self, lane: usize) -> ChannelMeter<f64> {
        ChannelMeter { sum: self.sum.lane(lane), square: self.square.lane(lane), min: self.min.lane(lane), max: self.max.lane(lane) }
    }
}

impl ContactMeter {
    /// From what was counted elsewhere, penetrations unknown.
    pub(crate) fn counted(samples: [f64; 2], impacts: [f64; 2]) -> Self {
        ContactMeter { samples, impacts, deepest: [f64::NEG_INFINITY; 2], loosest: f64::INFINITY }
    }
}

impl<S: Number> Flanks<S> {
    #[inline(always)]
    fn sample(&mut self, contact: &Contact<S>, margins: bool) {
        let (below, above) = (contact.lower - contact.deflection, contact.deflection - contact.upper);
        if margins {
            self.deepest[0] = self.deepest[0].max(below);
            self.deepest[1] = self.deepest[1].max(above);
            self.loosest = self.loosest.min(below.max(above));
        }
        self.visit::<0>(below);
        self.visit::<1>(above);
    }

    #[inline(always)]
    fn visit<const FLANK: usize>(&mut self, depth: S) {
        let (zero, visits) = (S::from(0.0), self.visits[FLANK]);
        self.visits[FLANK] = S::if_above(depth, zero, visits + self.next[FLANK], visits);
        self.next[FLANK] = S::if_above(depth, zero, S::from(1.0), S::from(1.0 + ENTRY));
    }

    fn lane(&self, lane: usize) -> ContactMeter {
        let visits = self.visits.map(|x| x.lane(lane));
        let impacts = visits.map(|x| (x / ENTRY).floor());
        ContactMeter {
            samples: [visits[0] - ENTRY * impacts[0], visits[1] - ENTRY * impacts[1]],
            impacts,
            deepest: self.deepest.map(|x| x.lane(lane)),
            loosest: self.loosest.lane(lane),
        }
    }
}
