//! Meters of contacts: times on the flanks, impacts and penetrations.

use crate::analysis::ContactStatistics;
use crate::sweep::lanes::number::Number;

/// Contact times, impacts and penetrations of one contact, sampled at the start of every step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactMeter {
    /// Samples on the lower and on the upper flank: their number, or the time if edges are located.
    pub(crate) samples: [f64; 2],
    /// Number of impacts on each flank. If the gap has a width, the first sample on a flank after a sample
    /// off it is an impact.
    pub(crate) impacts: [f64; 2],
    /// Maximum penetration of each flank, in the unit of the deflection; negative without contact.
    pub(crate) deepest: [f64; 2],
    /// Minimum over the samples of the larger of both penetrations; negative if the contact was in the gap.
    pub(crate) loosest: f64,
    /// Whether a sample lies on both flanks at once: the lower edge above the upper edge.
    pub(crate) overlaps: bool,
}

/// Running values of a [`ContactMeter`]. Samples and entries of a flank are counted in one number: the first
/// sample on the flank after a sample off it also adds an entry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flanks<S> {
    /// Number of samples + [`ENTRY`] × number of entries, for each flank.
    pub(crate) visits: [S; 2],
    /// Addend of the next sample on the flank: 1, or 1 + [`ENTRY`] after a sample off it.
    pub(crate) next: [S; 2],
    pub(crate) deepest: [S; 2],
    pub(crate) loosest: S,
    /// Negative width of the gap (the sum of both penetrations): its minimum over the last sample of every
    /// block of the buffer, at most 0. It is 0 without backlash: then no impacts are counted.
    pub(crate) overlap: S,
    /// Maximum of the same sums, at least 0. A positive value shows a negative gap. Rounding does not make it
    /// positive: a gap of positive width has a rounded sum of at most 0.
    pub(crate) largest_overlap: S,
}

/// Weight of an entry. It exceeds the number of samples between two readings, so that the 53 bits of an `f64`
/// hold both counts exactly.
const ENTRY: f64 = (1 << 26) as f64;

impl ContactMeter {
    /// Given contact times and impacts, without penetrations.
    pub(crate) fn counted(samples: [f64; 2], impacts: [f64; 2]) -> Self {
        ContactMeter {
            samples,
            impacts,
            deepest: [f64::NEG_INFINITY; 2],
            loosest: f64::INFINITY,
            overlaps: false,
        }
    }
    /// Contact times and impacts from `before` to `now`, and the whole time. `before` becomes `now`.
    pub(crate) fn since(now: ContactStatistics, before: &mut ContactStatistics) -> (Self, f64) {
        let time: [f64; 3] = std::array::from_fn(|k| now.time[k] - before.time[k]);
        let impacts = std::array::from_fn(|k| (now.impacts[k] - before.impacts[k]) as f64);
        *before = now;
        (ContactMeter::counted([time[0], time[2]], impacts), time[0] + time[1] + time[2])
    }
}

impl<S: Number> Flanks<S> {
    #[inline(always)]
    pub(crate) fn sample(&mut self, below: S, above: S) {
        self.deepest[0] = self.deepest[0].max(below);
        self.deepest[1] = self.deepest[1].max(above);
        self.loosest = self.loosest.min(below.max(above));
        self.visit::<0>(below);
        self.visit::<1>(above);
    }

    /// As [`sample`](Flanks::sample), for a share of a step.
    #[inline(always)]
    pub(crate) fn sample_share(&mut self, below: S, above: S, share: f64) {
        self.next = self.next.map(|next| next - S::from(1.0 - share));
        self.sample(below, above);
    }

    #[inline(always)]
    pub(crate) fn see_width(&mut self, below: S, above: S) {
        self.overlap = self.overlap.min(below + above);
        self.largest_overlap = self.largest_overlap.max(below + above);
    }

    #[inline(always)]
    fn visit<const FLANK: usize>(&mut self, depth: S) {
        let (zero, visits) = (S::from(0.0), self.visits[FLANK]);
        self.visits[FLANK] = S::if_above(depth, zero, visits + self.next[FLANK], visits);
        self.next[FLANK] = S::if_above(depth, zero, S::from(1.0), S::from(1.0 + ENTRY));
    }

    pub(crate) fn lane(&self, lane: usize) -> ContactMeter {
        let visits = self.visits.map(|x| x.lane(lane));
        let entries = visits.map(|x| (x / ENTRY).floor());
        // Without backlash a change of flank is not an impact.
        let open = self.overlap.lane(lane) < 0.0;
        ContactMeter {
            samples: [visits[0] - ENTRY * entries[0], visits[1] - ENTRY * entries[1]],
            impacts: if open { entries } else { [0.0; 2] },
            deepest: self.deepest.map(|x| x.lane(lane)),
            loosest: self.loosest.lane(lane),
            overlaps: self.largest_overlap.lane(lane) > 0.0,
        }
    }
}
