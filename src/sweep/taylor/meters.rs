//! Integrals and extremes of channels over the steps of all lanes, from their polynomials.
#![allow(
    clippy::needless_range_loop,
    reason = "index loops over arrays become vector instructions, iterators do not"
)]

use crate::analysis::Summary;
use crate::numeric::moments::Moments;
use crate::numeric::search::parabola::maximum;
use crate::ode::taylor::expansion::coefficients::ORDERS;
use crate::ode::taylor::expansion::sums::SECOND;
use crate::ode::taylor::positive::Polynomial;
use crate::scalar::Scalar;
use crate::sweep::lanes::number::Lanes;
use crate::sweep::taylor::columns::{Columns, Moved, W, sums, weighted_sum};

/// Number of instants at which a step is sampled behind its start: evenly spread in it, the last at its end.
const SAMPLES: usize = 8;

/// The powers s, s², ... of the place s of each sample in its step.
const PLACES: [[f64; ORDERS]; SAMPLES] = {
    let (mut places, mut k) = ([[1.0; ORDERS]; SAMPLES], 0);
    while k < SAMPLES {
        let mut n = 1;
        while n < ORDERS {
            places[k][n] = places[k][n - 1] * ((k + 1) as f64 / SAMPLES as f64);
            n += 1;
        }
        k += 1;
    }
    places
};

/// n (n - 1) sⁿ.
const BENDS: [[f64; ORDERS]; SAMPLES] = {
    let (mut bends, mut k) = (PLACES, 0);
    while k < SAMPLES {
        let mut n = 0;
        while n < ORDERS {
            bends[k][n] *= SECOND[n];
            n += 1;
        }
        k += 1;
    }
    bends
};

/// Figures of one channel so far, in each lane.
#[derive(Clone, Copy)]
struct Running {
    /// First value x_0.
    origin: Lanes<W>,
    /// ∫ (x - x_0) dt.
    off: Lanes<W>,
    /// ∫ (x - x_0)² dt.
    square: Lanes<W>,
    /// Minimum, maximum.
    extremes: [Lanes<W>; 2],
}

/// The channels that are measured.
pub(crate) struct SeriesMeters {
    /// Their columns.
    columns: Vec<usize>,
    running: Vec<Running>,
    /// The lanes whose next step is the first.
    fresh: [bool; W],
    /// Where the samples of the last step do not decide the extremes: channel, lane and, as bits, the
    /// intervals for the minimum and for the maximum.
    open: Vec<(usize, usize, [u8; 2])>,
}

impl SeriesMeters {
    pub(super) fn new(columns: Vec<usize>) -> Self {
        let zero = Lanes::from(0.0);
        let running = Running { origin: zero, off: zero, square: zero, extremes: [zero; 2] };
        let open = Vec::with_capacity(W * columns.len());
        SeriesMeters { running: vec![running; columns.len()], fresh: [true; W], open, columns }
    }

    /// Begins anew in a lane.
    pub(super) fn clear(&mut self, lane: usize) {
        self.fresh[lane] = true;
    }

    /// The figures of channel `i` in a lane over the time `duration`.
    pub(super) fn summary(&self, i: usize, lane: usize, duration: f64) -> Summary {
        let Running { origin, off, square, extremes } = &self.running[i];
        let moments = Moments::about(origin.0[lane], [off.0[lane], square.0[lane]], duration);
        Summary::of_moments(&moments, [extremes[0].0[lane], extremes[1].0[lane]])
    }

    /// Adds a step of the length `h` in each lane; a length of 0 adds nothing.
    #[inline(always)]
    pub(super) fn add(&mut self, c: &Columns, h: &[f64; W]) {
        let (degree, zero, h) = (c.degree, Lanes::from(0.0), Lanes(*h));
        let mut g = [zero; ORDERS];
        self.open.clear();
        for (i, (column, running)) in self.columns.iter().zip(&mut self.running).enumerate() {
            // x(s h) = Σ g_n sⁿ with s in [0, 1].
            let (mut power, mut moved, start) = (h, Moved::new(), *c.at(*column, 0));
            for n in 1..=degree {
                g[n] = *c.at(*column, n) * power;
                power = power * h;
                moved.add(g[n]);
            }
            let [least, most] = moved.bounds;
            let mut exceeds = [false; W];
            for l in 0..W {
                if self.fresh[l] & (h.0[l] > 0.0) {
                    running.origin.0[l] = start.0[l];
                    (running.off.0[l], running.square.0[l]) = (0.0, 0.0);
                    running.extremes.iter_mut().for_each(|x| x.0[l] = start.0[l]);
                }
                let beyond = (start.0[l] + most.0[l] > running.extremes[1].0[l])
                    | (start.0[l] + least.0[l] < running.extremes[0].0[l]);
                exceeds[l] = beyond & (h.0[l] > 0.0);
            }
            g[0] = start - running.origin;
            let [off, square] = integrals(&g[..=degree]);
            running.off = running.off + off * h;
            running.square = running.square + square * h;
            if exceeds.contains(&true) {
                g[0] = start;
                let open = running.sample(&g[..=degree], &exceeds);
                self.open.extend((0..W).filter(|l| open[*l] != [0; 2]).map(|l| (i, l, open[l])));
            }
        }
        for l in 0..W {
            self.fresh[l] &= h.0[l] <= 0.0;
        }
    }

    /// Finds the extremes between the samples of the last step.
    pub(super) fn settle(&mut self, c: &Columns, h: &[f64; W]) {
        for &(i, lane, [of_min, of_max]) in &self.open {
            let mut p = Polynomial { c: [0.0; ORDERS], degree: c.degree };
            let mut power = 1.0;
            for (n, out) in p.c[..=c.degree].iter_mut().enumerate() {
                *out = c.at(self.columns[i], n).0[lane] * power;
                power *= h[lane];
            }
            let [min, max] = &mut self.running[i].extremes;
            max.0[lane] = highest(&p, max.0[lane], of_max);
            p.c.iter_mut().for_each(|c| *c = -*c);
            min.0[lane] = -highest(&p, -min.0[lane], of_min);
        }
    }
}

/// ∫ p ds and ∫ p² ds over [0, 1]. The terms of p² above 3/2 of the order of p are left out: they are far
/// below the last terms of p.
#[inline(always)]
fn integrals(g: &[Lanes<W>]) -> [Lanes<W>; 2] {
    let [mut first, mut second] = [Lanes::from(0.0); 2];
    let degree = g.len() - 1;
    for half in (0..=(degree + degree / 2) / 2).rev() {
        // Σ_j g_j g_(m-j) for m and for m + 1: each product twice, but for that of the middle.
        let m = 2 * half;
        let least = m.saturating_sub(degree);
        let beyond = if m < degree { g[m + 1] } else { Lanes::from(0.0) };
        let [even, odd] = sums(&g[least..half], &g[half + 1..=m - least], beyond);
        let even = even * 2.0 + g[half] * g[half];
        let odd = (odd + g[half] * g[half + 1]) * 2.0;
        let [per, per_next] = [1.0 / (m + 1) as f64, 1.0 / (m + 2) as f64];
        second = second + (odd * per_next + even * per);
        if m < degree {
            first = first + g[m + 1] * per_next;
        }
        if m <= degree {
            first = first + g[m] * per;
        }
    }
    [first, second]
}

impl Running {
    /// Updates the extremes of the chosen lanes from a value.
    #[inline(always)]
    fn reach(&mut self, value: &Lanes<W>, chosen: &[bool; W]) {
        let [min, max] = &mut self.extremes;
        for l in 0..W {
            min.0[l] = if chosen[l] & (value.0[l] < min.0[l]) { value.0[l] } else { min.0[l] };
            max.0[l] = if chosen[l] & (value.0[l] > max.0[l]) { value.0[l] } else { max.0[l] };
        }
    }

    /// Updates the extremes of the chosen lanes from samples. Returns for each lane the intervals between
    /// them, as bits, in which a value may lie below the minimum and above the maximum.
    #[inline(always)]
    fn sample(&mut self, g: &[Lanes<W>], chosen: &[bool; W]) -> [[u8; 2]; W] {
        let mut sizes = [Lanes::from(0.0); ORDERS];
        let sizes = &mut sizes[..g.len()];
        sizes.iter_mut().zip(g).for_each(|(size, g)| *size = g.abs());
        let mut before = g[0];
        // The first value is the other side of a jump at the start of the step.
        self.reach(&before, chosen);
        // Bounds of the values in each interval.
        let mut bounds = [[before; 2]; SAMPLES];
        for (k, bounds) in bounds.iter_mut().enumerate() {
            let value = weighted_sum(g, &PLACES[k][..g.len()], |g, w, l| g.0[l] * w);
            let over = weighted_sum(sizes, &BENDS[k][..g.len()], |size: &Lanes<W>, w, l| size.0[l] * w)
                * (1.0 / (8 * (k + 1) * (k + 1)) as f64);
            *bounds = [value.min(before) - over, value.max(before) + over];
            before = value;
            self.reach(&value, chosen);
        }
        let (mut open, [min, max]) = ([[0; 2]; W], &self.extremes);
        for (k, [low, high]) in bounds.iter().enumerate() {
            for l in 0..W {
                open[l][0] |= u8::from(chosen[l] & (low.0[l] < min.0[l])) << k;
                open[l][1] |= u8::from(chosen[l] & (high.0[l] > max.0[l])) << k;
            }
        }
        open
    }
}

/// The largest value of a polynomial in the given intervals of [0, 1] if it is above `record`, otherwise
/// `record`.
fn highest(p: &Polynomial, record: f64, intervals: u8) -> f64 {
    let mut best = record;
    for k in (0..SAMPLES).filter(|k| intervals >> k & 1 == 1) {
        let [a, b] = [k, k + 1].map(|k| k as f64 / SAMPLES as f64);
        let (before, after) = (p.with_slope(a), p.with_slope(b));
        if before.1 > 0.0 && after.1 < 0.0 {
            let middle = 0.5 * (a + b);
            let values = [before.0, p.with_slope(middle).0, after.0];
            best = best.max(maximum([a, middle, b], values, |s| p.with_slope(s).0));
        }
    }
    best
}
