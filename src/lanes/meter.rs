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
pub(crate) struct ContactMeter<S> {
    /// Samples on the lower and on the upper flank.
    pub(crate) samples: [S; 2],
    /// Entries into each.
    pub(crate) impacts: [S; 2],
    /// Largest penetration of each, negative off the flank.
    pub(crate) deepest: [S; 2],
    /// Least penetration of the better of the two.
    pub(crate) loosest: S,
    /// 1 where the last sample lay off the flank, 0 on it.
    off: [S; 2],
}

/// What one meter of one lane says.
pub(crate) enum Reading {
    Channel(usize, ChannelMeter<f64>),
    Contact(usize, ContactMeter<f64>),
}

/// All meters of a batch.
#[derive(Clone, Debug)]
pub(crate) struct Meters<S> {
    kinds: Vec<Kind>,
    channels: Vec<ChannelMeter<S>>,
    contacts: Vec<ContactMeter<S>>,
    /// Whether penetrations are watched.
    margins: bool,
    /// The contacts that have to be evaluated.
    read: Range<usize>,
}

impl<S: Number> Meters<S> {
    pub(crate) fn new(kinds: &[Kind], contacts: usize, margins: bool) -> Self {
        let zero = S::from(0.0);
        let channel = ChannelMeter { sum: zero, square: zero, min: zero, max: zero };
        let contact = ContactMeter { samples: [zero; 2], impacts: [zero; 2], deepest: [zero; 2], loosest: zero, off: [zero; 2] };
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
            contact.off.iter_mut().for_each(|x| x.set_lane(lane, 0.0));
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
            contact.samples.iter_mut().chain(&mut contact.impacts).for_each(|x| x.set_lane(lane, 0.0));
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

impl ContactMeter<f64> {
    /// From what was counted elsewhere, penetrations unknown.
    pub(crate) fn counted(samples: [f64; 2], impacts: [f64; 2]) -> Self {
        ContactMeter { samples, impacts, deepest: [f64::NEG_INFINITY; 2], loosest: f64::INFINITY, off: [0.0; 2] }
    }
}

impl<S: Number> ContactMeter<S> {
    #[inline(always)]
    fn sample(&mut self, contact: &Contact<S>, margins: bool) {
        let (zero, one) = (S::from(0.0), S::from(1.0));
        let depths = [contact.lower - contact.deflection, contact.deflection - contact.upper];
        for flank in 0..2 {
            let depth = depths[flank];
            // Sums of ones and zeros: a choice between two sums takes longer.
            self.samples[flank] = self.samples[flank] + S::if_above(depth, zero, one, zero);
            self.impacts[flank] = self.impacts[flank] + S::if_above(depth, zero, self.off[flank], zero);
            self.off[flank] = S::if_above(depth, zero, zero, one);
        }
        if margins {
            self.deepest = [self.deepest[0].max(depths[0]), self.deepest[1].max(depths[1])];
            self.loosest = self.loosest.min(depths[0].max(depths[1]));
        }
    }

    fn lane(&self, lane: usize) -> ContactMeter<f64> {
        let both = |x: &[S; 2]| x.map(|x| x.lane(lane));
        ContactMeter {
            samples: both(&self.samples),
            impacts: both(&self.impacts),
            deepest: both(&self.deepest),
            loosest: self.loosest.lane(lane),
            off: both(&self.off),
        }
    }
}
