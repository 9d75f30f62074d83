//! Integrals and extremes of channels over the steps of all lanes, from their polynomials.
#![allow(
    clippy::needless_range_loop,
    reason = "index loops over arrays become vector instructions, iterators do not"
)]

use crate::analysis::Summary;
use crate::numeric::parabola::maximum;
use crate::ode::taylor::expansion::coefficients::ORDERS;
use crate::ode::taylor::expansion::sums::SECOND;
use crate::ode::taylor::positive::Polynomial;
use crate::sweep::taylor::columns::Columns;

/// Number of samples of a step, at its end and between.
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

/// Figures of one channel so far, in each lane.
#[derive(Clone, Copy)]
struct Running<const W: usize> {
    /// First value x_0.
    origin: [f64; W],
    /// ∫ (x - x_0) dt.
    off: [f64; W],
    /// ∫ (x - x_0)² dt.
    square: [f64; W],
    /// Minimum, maximum.
    extremes: [[f64; W]; 2],
}

/// The channels that are measured.
pub(super) struct Meters<const W: usize> {
    /// Their columns.
    columns: Vec<usize>,
    running: Vec<Running<W>>,
    /// The lanes whose next step is the first.
    fresh: [bool; W],
    /// Channel and lane of the extremes that the samples of the last step do not decide.
    open: Vec<(usize, usize)>,
}

impl<const W: usize> Meters<W> {
    pub(super) fn new(columns: Vec<usize>) -> Self {
        let zero = [0.0; W];
        let running = Running { origin: zero, off: zero, square: zero, extremes: [zero; 2] };
        let open = Vec::with_capacity(W * columns.len());
        Meters { running: vec![running; columns.len()], fresh: [true; W], open, columns }
    }

    /// Begins anew in a lane.
    pub(super) fn clear(&mut self, lane: usize) {
        self.fresh[lane] = true;
    }

    /// The figures of channel `i` in a lane over the time `duration`.
    pub(super) fn summary(&self, i: usize, lane: usize, duration: f64) -> Summary {
        let Running { origin, off, square, extremes } = &self.running[i];
        let (origin, off, square) = (origin[lane], off[lane] / duration, square[lane] / duration);
        let mean = origin + off;
        Summary {
            mean,
            rms: (square + 2.0 * off * origin + origin * origin).max(0.0).sqrt(),
            min: extremes[0][lane],
            max: extremes[1][lane],
            deviation: (square - off * off).max(0.0).sqrt(),
        }
    }

    /// Adds a step of the length `h` in each lane; a length of 0 adds nothing.
    #[inline(always)]
    pub(super) fn add(&mut self, c: &Columns<W>, h: &[f64; W]) {
        let (degree, mut g) = (c.degree, [[0.0; W]; ORDERS]);
        self.open.clear();
        for (i, (column, running)) in self.columns.iter().zip(&mut self.running).enumerate() {
            // x(s h) = Σ g_n sⁿ with s in [0, 1].
            let (c, mut power, mut range) = (c.column(*column), [1.0; W], [0.0; W]);
            for n in 0..=degree {
                for l in 0..W {
                    g[n][l] = c[n].0[l] * power[l];
                    power[l] *= h[l];
                    range[l] += if n > 0 { g[n][l].abs() } else { 0.0 };
                }
            }
            let start = g[0];
            for l in 0..W {
                let first = self.fresh[l] & (h[l] > 0.0);
                let from = |x: f64, y: f64| if first { x } else { y };
                running.origin[l] = from(start[l], running.origin[l]);
                running.off[l] = from(0.0, running.off[l]);
                running.square[l] = from(0.0, running.square[l]);
                running.extremes[0][l] = from(start[l], running.extremes[0][l]);
                running.extremes[1][l] = from(start[l], running.extremes[1][l]);
                g[0][l] = start[l] - running.origin[l];
            }
            let [off, square] = integrals(&g[..=degree]);
            let mut exceeds = [false; W];
            for l in 0..W {
                running.off[l] += off[l] * h[l];
                running.square[l] += square[l] * h[l];
                let beyond = (start[l] + range[l] > running.extremes[1][l])
                    | (start[l] - range[l] < running.extremes[0][l]);
                exceeds[l] = beyond & (h[l] > 0.0);
            }
            if exceeds.contains(&true) {
                g[0] = start;
                let open = running.sample(&g[..=degree], &exceeds);
                self.open.extend((0..W).filter(|l| open[*l]).map(|l| (i, l)));
            }
        }
        for l in 0..W {
            self.fresh[l] &= h[l] <= 0.0;
        }
    }

    /// Finds the extremes between the samples of the last step.
    pub(super) fn settle(&mut self, c: &Columns<W>, h: &[f64; W]) {
        for &(i, lane) in &self.open {
            let mut p = Polynomial { c: [0.0; ORDERS], degree: c.degree };
            let (column, mut power) = (c.column(self.columns[i]), 1.0);
            for (out, c) in p.c[..=c.degree].iter_mut().zip(column) {
                *out = c.0[lane] * power;
                power *= h[lane];
            }
            let [min, max] = &mut self.running[i].extremes;
            max[lane] = highest(&p, max[lane]);
            p.c.iter_mut().for_each(|c| *c = -*c);
            min[lane] = -highest(&p, -min[lane]);
        }
    }
}

/// ∫ p ds and ∫ p² ds over [0, 1]. The terms of p² above 3/2 of the order of p are left out: they are far below
/// the last terms of p.
#[inline(always)]
fn integrals<const W: usize>(g: &[[f64; W]]) -> [[f64; W]; 2] {
    let (mut first, mut second) = ([0.0; W], [0.0; W]);
    let degree = g.len() - 1;
    for m in (0..=degree + degree / 2).rev() {
        let per = 1.0 / (m + 1) as f64;
        // Σ_j g_j g_(m-j): each product twice, but for that of the middle.
        let mut twice = [[0.0; W]; 2];
        for j in m.saturating_sub(degree)..m.div_ceil(2) {
            for l in 0..W {
                twice[j % 2][l] += g[j][l] * g[m - j][l];
            }
        }
        for l in 0..W {
            let mut sum = 2.0 * (twice[0][l] + twice[1][l]);
            if m % 2 == 0 {
                sum += g[m / 2][l] * g[m / 2][l];
            }
            second[l] += per * sum;
        }
        if m <= degree {
            for l in 0..W {
                first[l] += per * g[m][l];
            }
        }
    }
    [first, second]
}

impl<const W: usize> Running<W> {
    /// Updates the extremes of the chosen lanes from samples. Returns in which lanes a value between them may
    /// lie beyond.
    #[inline(always)]
    fn sample(&mut self, g: &[[f64; W]], chosen: &[bool; W]) -> [bool; W] {
        let (mut before, mut open) = (g[0], [false; W]);
        // Bounds of the values between the samples.
        let (mut low, mut high) = (before, before);
        for (k, powers) in PLACES.iter().enumerate() {
            let (mut value, mut bend) = ([[0.0; W]; 2], [0.0; W]);
            for n in 0..g.len() {
                let (power, second) = (powers[n], powers[n] * SECOND[n]);
                for l in 0..W {
                    value[n % 2][l] += power * g[n][l];
                    bend[l] += second * g[n][l].abs();
                }
            }
            let per = 1.0 / (8 * (k + 1) * (k + 1)) as f64;
            for l in 0..W {
                let (value, over) = (value[0][l] + value[1][l], bend[l] * per);
                let [least, largest] =
                    if value < before[l] { [value, before[l]] } else { [before[l], value] };
                low[l] = if least - over < low[l] { least - over } else { low[l] };
                high[l] = if largest + over > high[l] { largest + over } else { high[l] };
                let [min, max] = &mut self.extremes;
                min[l] = if chosen[l] & (value < min[l]) { value } else { min[l] };
                max[l] = if chosen[l] & (value > max[l]) { value } else { max[l] };
                before[l] = value;
            }
        }
        for l in 0..W {
            open[l] = chosen[l] & ((high[l] > self.extremes[1][l]) | (low[l] < self.extremes[0][l]));
        }
        open
    }
}

/// The largest value of a polynomial in [0, 1] if it is above `record`, otherwise `record`.
fn highest(p: &Polynomial, record: f64) -> f64 {
    let (mut best, mut before) = (record, (p.c[0], p.c[1]));
    for k in 1..=SAMPLES {
        let [a, b] = [k - 1, k].map(|k| k as f64 / SAMPLES as f64);
        let after = p.with_slope(b);
        if before.1 > 0.0 && after.1 < 0.0 {
            let middle = 0.5 * (a + b);
            let values = [before.0, p.with_slope(middle).0, after.0];
            best = best.max(maximum([a, middle, b], values, |s| p.with_slope(s).0));
        }
        before = after;
    }
    best
}
