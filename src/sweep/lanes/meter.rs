//! Meters: statistics of channels and contacts, measured while lanes run.
#![allow(
    clippy::needless_range_loop,
    reason = "index loops over arrays become vector instructions, iterators do not"
)]

use crate::analysis::Summary;
use crate::contact::Contact;
use crate::contact::edge::Edge;
use crate::numeric::moments::Moments;
use crate::ode::probe::ChannelKind;
use crate::sweep::lanes::flanks::{ContactMeter, Flanks};
use crate::sweep::lanes::number::Number;
use std::ops::Range;

/// Sums and extremes of one channel, sampled at the start of every step, and on both sides of a jump of the
/// drives, where each sample counts half.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChannelMeter<S> {
    pub(crate) sum: S,
    pub(crate) square: S,
    pub(crate) min: S,
    pub(crate) max: S,
    /// The first sample x_0.
    pub(crate) origin: S,
    /// Σ (x - x_0).
    pub(crate) off: S,
    /// Σ (x - x_0)².
    pub(crate) off_square: S,
    /// 1 before the first sample, then 0.
    fresh: S,
}

/// The values of one meter in one lane since the last reading, with the index of the channel or contact.
pub(crate) enum MeterReading {
    Channel(usize, ChannelMeter<f64>),
    Contact(usize, ContactMeter),
}

/// Number of samples that are buffered before they are added. Sums and extremes are then loaded and stored
/// once per block instead of once per step.
const BLOCK: usize = 8;

/// All meters of all lanes.
#[derive(Clone, Debug)]
pub(crate) struct Meters<S: Number> {
    kinds: Vec<ChannelKind>,
    /// The contacts that must be evaluated.
    read: Range<usize>,
    /// The buffered samples of a block: a row for each channel, then two rows for each contact with the
    /// penetrations of its lower and upper flank. Empty between two ranges of steps.
    buffer: Vec<[S; BLOCK]>,
    /// The share of a step for which each buffered sample counts.
    shares: [f64; BLOCK],
    /// Whether all of these shares are 1.
    whole: bool,
    /// Number of buffered samples.
    filled: usize,
    /// The parts of the first channel, then those of the next channel.
    channels: Vec<ChannelMeter<S::Part>>,
    /// The same for the contacts.
    contacts: Vec<Flanks<S::Part>>,
}

impl<S: Number> Meters<S> {
    pub(crate) fn new(kinds: &[ChannelKind], contacts: usize) -> Self {
        let zero = S::Part::from(0.0);
        let channel = ChannelMeter::all(zero);
        let contact = Flanks {
            visits: [zero; 2],
            next: [S::Part::from(1.0); 2],
            deepest: [zero; 2],
            loosest: zero,
            overlap: zero,
            largest_overlap: zero,
        };
        let read = kinds.iter().fold(0..contacts, |read, kind| match *kind {
            ChannelKind::Deflection(i) | ChannelKind::Force(i) if read.is_empty() => i..i + 1,
            ChannelKind::Deflection(i) | ChannelKind::Force(i) => read.start.min(i)..read.end.max(i + 1),
            _ => read,
        });
        Meters {
            kinds: kinds.to_vec(),
            read,
            buffer: vec![[S::from(0.0); BLOCK]; kinds.len() + 2 * contacts],
            shares: [1.0; BLOCK],
            whole: true,
            filled: 0,
            channels: vec![channel; kinds.len() * S::PARTS],
            contacts: vec![contact; contacts * S::PARTS],
        }
    }

    /// The contacts that must be evaluated.
    pub(crate) fn contacts(&self) -> Range<usize> {
        self.read.clone()
    }

    /// The next sample counts for half a step: it lies on one side of a jump.
    #[inline(always)]
    pub(crate) fn halve_next(&mut self) {
        self.shares[self.filled % BLOCK] = 0.5;
        self.whole = false;
    }

    /// Buffers a sample of all channels and contacts.
    #[inline(always)]
    pub(crate) fn sample(&mut self, q: &[S], v: &[S], contacts: &[Contact<S>]) {
        let at = self.filled % BLOCK;
        let (kinds, buffer) = (&self.kinds[..], &mut self.buffer[..]);
        let (channels, flanks) = buffer.split_at_mut(kinds.len());
        for c in 0..kinds.len() {
            channels[c][at] = match kinds[c] {
                ChannelKind::Coordinate(i) => pick(q, i),
                ChannelKind::Velocity(i) => pick(v, i),
                ChannelKind::Deflection(i) => pick(contacts, i).deflection,
                ChannelKind::Force(i) => pick(contacts, i).force,
            };
        }
        if !flanks.is_empty() {
            for c in 0..contacts.len().min(flanks.len() / 2) {
                flanks[2 * c][at] = Edge::Lower.depth(&contacts[c]);
                flanks[2 * c + 1][at] = Edge::Upper.depth(&contacts[c]);
            }
        }
        self.filled = at + 1;
        if self.filled == BLOCK {
            self.gather(BLOCK);
        }
    }

    /// Adds the samples that are still buffered.
    #[inline(always)]
    pub(crate) fn finish(&mut self) {
        self.gather(self.filled);
    }

    /// Adds the first `count` buffered samples to the meters, one part of the lanes after the other. If the
    /// compiler knows `count`, a part stays in registers from one sample to the next.
    #[inline(always)]
    fn gather(&mut self, count: usize) {
        let (channels, flanks) = self.buffer.split_at(self.kinds.len());
        let (shares, whole) = (&self.shares[..count], self.whole);
        for (meters, row) in self.channels.chunks_exact_mut(S::PARTS).zip(channels) {
            for part in 0..S::PARTS {
                let mut meter = meters[part];
                meter.begin(row[0].part(part));
                if whole {
                    for sample in &row[..count] {
                        meter.sample(sample.part(part));
                    }
                } else {
                    for (sample, share) in row.iter().zip(shares) {
                        meter.sample_share(sample.part(part), *share);
                    }
                }
                meters[part] = meter;
            }
        }
        for (meters, rows) in self.contacts.chunks_exact_mut(S::PARTS).zip(flanks.chunks_exact(2)) {
            for part in 0..S::PARTS {
                let mut meter = meters[part];
                if whole {
                    for k in 0..count {
                        meter.sample(rows[0][k].part(part), rows[1][k].part(part));
                    }
                } else {
                    for (k, share) in shares.iter().enumerate() {
                        meter.sample_share(rows[0][k].part(part), rows[1][k].part(part), *share);
                    }
                }
                if let Some(last) = count.checked_sub(1) {
                    meter.see_width(rows[0][last].part(part), rows[1][last].part(part));
                }
                meters[part] = meter;
            }
        }
        if !whole {
            self.shares = [1.0; BLOCK];
            self.whole = true;
        }
        self.filled = 0;
    }

    /// Resets a lane for a new run.
    pub(crate) fn restart(&mut self, lane: usize) {
        let (part, within) = (lane / S::Part::WIDTH, lane % S::Part::WIDTH);
        for contact in self.contacts.iter_mut().skip(part).step_by(S::PARTS) {
            // A sample on a flank counts as an impact only after a sample off that flank.
            contact.next.iter_mut().for_each(|x| x.set_lane(within, 1.0));
        }
        self.clear(lane);
    }

    /// Resets the counts, sums and extremes of a lane. The current flank of each contact is kept.
    pub(crate) fn clear(&mut self, lane: usize) {
        debug_assert_eq!(self.filled, 0, "buffered samples were not added");
        let (part, lane) = (lane / S::Part::WIDTH, lane % S::Part::WIDTH);
        for channel in self.channels.iter_mut().skip(part).step_by(S::PARTS) {
            channel.sum.set_lane(lane, 0.0);
            channel.square.set_lane(lane, 0.0);
            channel.min.set_lane(lane, f64::INFINITY);
            channel.max.set_lane(lane, f64::NEG_INFINITY);
            channel.off.set_lane(lane, 0.0);
            channel.off_square.set_lane(lane, 0.0);
            channel.fresh.set_lane(lane, 1.0);
        }
        for contact in self.contacts.iter_mut().skip(part).step_by(S::PARTS) {
            contact.visits.iter_mut().for_each(|x| x.set_lane(lane, 0.0));
            contact.deepest.iter_mut().for_each(|x| x.set_lane(lane, f64::NEG_INFINITY));
            contact.loosest.set_lane(lane, f64::INFINITY);
            contact.overlap.set_lane(lane, 0.0);
            contact.largest_overlap.set_lane(lane, 0.0);
        }
    }

    /// Passes the values of a lane since the last reading to `show`, then clears the lane.
    pub(crate) fn read(&mut self, lane: usize, mut show: impl FnMut(MeterReading)) {
        debug_assert_eq!(self.filled, 0, "buffered samples were not added");
        let (part, within) = (lane / S::Part::WIDTH, lane % S::Part::WIDTH);
        for (i, meter) in self.channels.iter().skip(part).step_by(S::PARTS).enumerate() {
            show(MeterReading::Channel(i, meter.lane(within)));
        }
        for (i, meter) in self.contacts.iter().skip(part).step_by(S::PARTS).enumerate() {
            show(MeterReading::Contact(i, meter.lane(within)));
        }
        self.clear(lane);
    }
}

/// `values[i]`. For one or two values it needs no index into memory, so that they stay in registers.
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
    fn all(x: S) -> Self {
        ChannelMeter { sum: x, square: x, min: x, max: x, origin: x, off: x, off_square: x, fresh: x }
    }

    /// Sets the origin to `x` in the lanes without a sample.
    #[inline(always)]
    fn begin(&mut self, x: S) {
        let zero = S::from(0.0);
        self.origin = S::if_above(self.fresh, zero, x, self.origin);
        self.fresh = zero;
    }

    #[inline(always)]
    fn sample(&mut self, x: S) {
        let off = x - self.origin;
        self.off = self.off + off;
        self.off_square = self.off_square + off * off;
        self.sum = self.sum + x;
        self.square = self.square + x * x;
        self.min = self.min.min(x);
        self.max = self.max.max(x);
    }

    /// As [`sample`](ChannelMeter::sample), for a share of a step.
    #[inline(always)]
    fn sample_share(&mut self, x: S, share: f64) {
        let off = x - self.origin;
        let (part_off, part) = (off * share, x * share);
        self.off = self.off + part_off;
        self.off_square = self.off_square + off * part_off;
        self.sum = self.sum + part;
        self.square = self.square + x * part;
        self.min = self.min.min(x);
        self.max = self.max.max(x);
    }

    fn lane(&self, lane: usize) -> ChannelMeter<f64> {
        ChannelMeter {
            sum: self.sum.lane(lane),
            square: self.square.lane(lane),
            min: self.min.lane(lane),
            max: self.max.lane(lane),
            origin: self.origin.lane(lane),
            off: self.off.lane(lane),
            off_square: self.off_square.lane(lane),
            fresh: self.fresh.lane(lane),
        }
    }
}

impl ChannelMeter<f64> {
    /// Sums that correspond to a summary. `weight`: duration or number of samples of the summary.
    pub(crate) fn of(summary: &Summary, weight: f64) -> Self {
        let Summary { mean, rms, min, max, deviation } = *summary;
        let off_square = deviation * deviation * weight;
        ChannelMeter {
            sum: mean * weight,
            square: rms * rms * weight,
            min,
            max,
            origin: mean,
            off: 0.0,
            off_square,
            fresh: 0.0,
        }
    }
    /// `weight`: duration or number of samples.
    pub(crate) fn moments(&self, weight: f64) -> Moments {
        Moments::about(self.origin, [self.off, self.off_square], weight)
    }
}

#[cfg(test)]
mod tests {
    use crate::contact::tooth::Contact;
    use crate::ode::probe::ChannelKind;
    use crate::sweep::lanes::meter::{MeterReading, Meters};
    use crate::sweep::lanes::number::{Lanes, Number};

    /// A deflection that reaches both flanks; it differs between lanes.
    fn value(sample: usize, lane: usize) -> f64 {
        2.0 * (1.7 * sample as f64 + 0.4 * lane as f64).sin()
    }

    /// The values of a lane equal those of plain loops bit by bit, for blocks of any length.
    fn gathers_as_a_loop_does<S: Number>() {
        const SAMPLES: usize = 41;
        for stretch in 1..20 {
            let mut meters = Meters::<S>::new(&[ChannelKind::Deflection(0)], 1);
            (0..S::WIDTH).for_each(|lane| meters.restart(lane));
            for sample in 0..SAMPLES {
                let mut contact = Contact { lower: S::from(-1.0), upper: S::from(1.0), ..Contact::default() };
                (0..S::WIDTH).for_each(|lane| contact.deflection.set_lane(lane, value(sample, lane)));
                meters.sample(&[], &[], &[contact]);
                if sample % stretch == 0 {
                    meters.finish();
                }
            }
            meters.finish();
            for lane in 0..S::WIDTH {
                let x: Vec<f64> = (0..SAMPLES).map(|sample| value(sample, lane)).collect();
                let above: Vec<bool> = x.iter().map(|x| *x > 1.0).collect();
                let entries = above.windows(2).filter(|pair| !pair[0] && pair[1]).count();
                meters.read(lane, |reading| match reading {
                    MeterReading::Channel(_, meter) => {
                        assert_eq!(meter.sum, x.iter().fold(0.0, |sum, x| sum + x));
                        assert_eq!(meter.square, x.iter().fold(0.0, |sum, x| sum + x * x));
                        assert_eq!(meter.off, x.iter().fold(0.0, |sum, y| sum + (y - x[0])));
                        assert_eq!(
                            meter.off_square,
                            x.iter().fold(0.0, |sum, y| sum + (y - x[0]) * (y - x[0]))
                        );
                        assert_eq!(meter.min, x.iter().copied().fold(f64::INFINITY, f64::min));
                        assert_eq!(meter.max, x.iter().copied().fold(f64::NEG_INFINITY, f64::max));
                    }
                    MeterReading::Contact(_, meter) => {
                        assert_eq!(meter.samples[1], above.iter().filter(|above| **above).count() as f64);
                        assert_eq!(meter.impacts[1], entries as f64, "{stretch} {lane}");
                        assert_eq!(
                            meter.deepest[1],
                            x.iter().map(|x| x - 1.0).fold(f64::NEG_INFINITY, f64::max)
                        );
                        assert_eq!(
                            meter.loosest,
                            x.iter().map(|x| (-1.0 - x).max(x - 1.0)).fold(f64::INFINITY, f64::min)
                        );
                    }
                });
            }
        }
    }

    #[test]
    fn blocks_and_parts_change_no_bit() {
        gathers_as_a_loop_does::<f64>();
        gathers_as_a_loop_does::<Lanes<4>>();
        gathers_as_a_loop_does::<Lanes<12>>();
        gathers_as_a_loop_does::<Lanes<16>>();
    }
}
