//! Prototype: Taylor series of workload A in lanes, written by hand. Each lane has its own time, step, piece and edges;
//! a lane that reaches its end takes the next point. `cargo bench --bench series_lanes` compares it with `Taylor`, run
//! by run, over 64 speeds on one thread. Measured: 2.5 times as fast in 4 lanes of AVX2, 3.0 times in 8 lanes of
//! AVX-512, with the same bits for any number of lanes; a third of that time goes into the coefficients, most of the rest into
//! the search for edges, which two steps of three need.

#![allow(clippy::needless_range_loop, reason = "loops over lanes are compiled to vector instructions")]

mod common;

use common::Pair;
use gear_dynamics::{Integrator, Rattle, State, Taylor};
use pulp::{Simd, WithSimd};
use std::time::Instant;

/// Order of the series; the integrator takes 24 or 25 at these tolerances.
const N: usize = 24;
const RTOL: f64 = 3e-10;
const ATOL: f64 = 3e-15;
const B: f64 = Pair::HALF_WIDTH;
const DAMPING: f64 = 0.02;

/// Orders of the waves, with the amplitudes of the cosine in the stiffness and of the sine in the forcing.
const ORDERS: [usize; 7] = [1, 2, 61, 62, 63, 64, 65];
const R: f64 = 0.3846;
const NORM: f64 = 1.0 / (1.0 + R * R / 2.0);
const MEAN: f64 = NORM * (1.0 + R * R / 2.0);
const STIFFNESS: [f64; 7] = [
    2.0 * R * NORM,
    0.5 * R * R * NORM,
    0.29 * 0.25 * R * R * NORM,
    0.29 * R * NORM,
    0.29 * (1.0 + 0.5 * R * R) * NORM,
    0.29 * R * NORM,
    0.29 * 0.25 * R * R * NORM,
];
const FORCING: [f64; 7] = [-5.5e-6, 2.2e-6, 0.0, 0.0, 6.8e-6, 0.0, 0.0];
const FORCE: f64 = -1.4e-5;

/// A number of each lane.
type Each<const W: usize> = [f64; W];

/// The end of a run.
#[derive(Clone, Copy, Default)]
struct End {
    x: f64,
    crossings: u32,
    mean: f64,
}

/// The edge that a lane leaves its piece by, or none.
#[derive(Clone, Copy, PartialEq)]
enum Piece {
    Lower,
    Gap,
    Upper,
}

/// What the steps of all lanes read and write. Arrays of lanes, order by order.
struct Lanes<'a, const W: usize> {
    speeds: &'a [f64],
    ends: &'a mut [End],
    next: usize,
    point: [Option<usize>; W],
    t: Each<W>,
    t_end: Each<W>,
    wc: Each<W>,
    last: Each<W>,
    /// 1 on a flank, 0 in the gap; the edge of that flank.
    closed: Each<W>,
    edge: Each<W>,
    piece: [Piece; W],
    /// The edge on which the step starts: its value, or NaN.
    on: Each<W>,
    crossings: [u32; W],
    integral: Each<W>,
    /// wc^k.
    powers: [Each<W>; N + 1],
    stiffness: [Each<W>; N + 1],
    x: [Each<W>; N + 2],
    looks: u64,
    roots: u64,
    steps: u64,
}

/// n^k/k! of each order.
fn weights() -> [[f64; 7]; N + 1] {
    let mut all = [[1.0; 7]; N + 1];
    for k in 1..=N {
        for (i, n) in ORDERS.iter().enumerate() {
            all[k][i] = all[k - 1][i] * *n as f64 / k as f64;
        }
    }
    all
}

impl<'a, const W: usize> Lanes<'a, W> {
    fn new(speeds: &'a [f64], ends: &'a mut [End]) -> Self {
        let zero = [0.0; W];
        let mut lanes = Lanes {
            speeds,
            ends,
            next: 0,
            point: [None; W],
            t: zero,
            t_end: zero,
            wc: [1e-3; W],
            last: zero,
            closed: zero,
            edge: zero,
            piece: [Piece::Gap; W],
            on: [f64::NAN; W],
            crossings: [0; W],
            integral: zero,
            powers: [[1.0; W]; N + 1],
            stiffness: [zero; N + 1],
            x: [zero; N + 2],
            looks: 0,
            roots: 0,
            steps: 0,
        };
        (0..W).for_each(|l| lanes.refill(l));
        lanes
    }

    /// The next point of the queue.
    fn refill(&mut self, l: usize) {
        self.point[l] = (self.next < self.speeds.len()).then_some(self.next);
        let Some(point) = self.point[l] else {
            self.t_end[l] = self.t[l];
            return;
        };
        self.next += 1;
        let pair = Pair::at(self.speeds[point]);
        let start = Pair::start();
        (self.t[l], self.t_end[l], self.wc[l], self.last[l]) = (0.0, pair.end(), pair.wc, 0.0);
        (self.x[0][l], self.x[1][l]) = (start.q[0], start.v[0]);
        (self.crossings[l], self.integral[l], self.on[l]) = (0, 0.0, f64::NAN);
        let piece = if start.q[0] > B {
            Piece::Upper
        } else if start.q[0] < -B {
            Piece::Lower
        } else {
            Piece::Gap
        };
        self.set_piece(l, piece);
        let mut power = 1.0;
        for k in 0..=N {
            self.powers[k][l] = power;
            power *= pair.wc;
        }
    }

    fn set_piece(&mut self, l: usize, piece: Piece) {
        self.piece[l] = piece;
        (self.closed[l], self.edge[l]) = match piece {
            Piece::Lower => (1.0, -B),
            Piece::Gap => (0.0, 0.0),
            Piece::Upper => (1.0, B),
        };
    }
}

/// All runs.
struct Run<'a, 'b, const W: usize>(&'b mut Lanes<'a, W>);

impl<const W: usize> WithSimd for Run<'_, '_, W> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let weights = weights();
        let lanes = self.0;
        while lanes.point.iter().any(Option::is_some) {
            lanes.step(&weights);
        }
    }
}

#[inline(always)]
fn log2(x: f64) -> f64 {
    x.to_bits() as i64 as f64 * (1.0 / (1u64 << 52) as f64) - 1023.0
}
#[inline(always)]
fn exp2(x: f64) -> f64 {
    f64::from_bits(((x.clamp(-1022.0, 1023.0) + 1023.0) * (1u64 << 52) as f64) as u64)
}

/// Sine and cosine by sums and products, for |x| below 1e6.
#[inline(always)]
fn sin_cos(x: f64) -> [f64; 2] {
    const WHOLE: f64 = 6_755_399_441_055_744.0;
    let shifted = x * std::f64::consts::FRAC_2_PI + WHOLE;
    let (turns, quadrant) = (shifted - WHOLE, shifted.to_bits());
    let x = ((x - turns * 1.570_796_326_734_125_6) - turns * 6.077_100_506_303_966e-11)
        - turns * 2.022_266_248_795_950_6e-21;
    let (z, w) = (x * x, x * x * x * x);
    let s = (-0.166_666_666_666_666_32 + z * 8.333_333_333_322_49e-3)
        + w * ((-1.984_126_982_985_795e-4 + z * 2.755_731_370_707_006_8e-6)
            + w * (-2.505_076_025_340_686_3e-8 + z * 1.589_690_995_211_55e-10));
    let c = (4.166_666_666_666_66e-2 - z * 1.388_888_888_887_411e-3)
        + w * ((2.480_158_728_947_673e-5 - z * 2.755_731_435_139_066_3e-7)
            + w * (2.087_572_321_298_175e-9 - z * 1.135_964_755_778_819_5e-11));
    let (s, c) = ((x + x * (z * s)).to_bits(), ((1.0 - 0.5 * z) + w * c).to_bits());
    let swap = (s ^ c) & (quadrant & 1).wrapping_neg();
    let sign = |quadrant: u64| (quadrant & 2) << 62;
    [f64::from_bits(s ^ swap ^ sign(quadrant)), f64::from_bits(c ^ swap ^ sign(quadrant.wrapping_add(1)))]
}

impl<const W: usize> Lanes<'_, W> {
    /// Coefficients of the stiffness and of the motion.
    #[inline(always)]
    fn expand(&mut self, weights: &[[f64; 7]; N + 1]) {
        let mut s = [[0.0; W]; 7];
        let mut c = [[0.0; W]; 7];
        for l in 0..W {
            let angle = self.wc[l] * self.t[l];
            let [s1, c1] = sin_cos(angle);
            let [s63, c63] = sin_cos(63.0 * angle);
            let (s2, c2) = (2.0 * s1 * c1, 1.0 - 2.0 * s1 * s1);
            (s[0][l], c[0][l], s[1][l], c[1][l], s[4][l], c[4][l]) = (s1, c1, s2, c2, s63, c63);
            (s[2][l], c[2][l]) = (s63 * c2 - c63 * s2, c63 * c2 + s63 * s2);
            (s[3][l], c[3][l]) = (s63 * c1 - c63 * s1, c63 * c1 + s63 * s1);
            (s[5][l], c[5][l]) = (s63 * c1 + c63 * s1, c63 * c1 - s63 * s1);
            (s[6][l], c[6][l]) = (s63 * c2 + c63 * s2, c63 * c2 - s63 * s2);
        }
        let mut y = [[0.0; W]; N + 2];
        for l in 0..W {
            y[0][l] = (self.x[0][l] - self.edge[l]) * self.closed[l];
            y[1][l] = self.x[1][l] * self.closed[l];
        }
        for k in 0..N {
            // The derivatives of cosine and sine of order k.
            let (cosine, of_cosine, sine, of_sine) = match k % 4 {
                0 => (&c, 1.0, &s, 1.0),
                1 => (&s, -1.0, &c, 1.0),
                2 => (&c, -1.0, &s, -1.0),
                _ => (&s, 1.0, &c, -1.0),
            };
            let (mut stiff, mut forcing) = ([0.0; W], [0.0; W]);
            for i in 0..7 {
                let a = of_cosine * STIFFNESS[i] * weights[k][i];
                for l in 0..W {
                    stiff[l] += a * cosine[i][l];
                }
            }
            for i in [0, 1, 4] {
                let b = of_sine * FORCING[i] * weights[k][i];
                for l in 0..W {
                    forcing[l] += b * sine[i][l];
                }
            }
            for l in 0..W {
                stiff[l] *= self.powers[k][l];
                forcing[l] *= self.powers[k][l];
            }
            if k == 0 {
                for l in 0..W {
                    stiff[l] += MEAN;
                    forcing[l] += FORCE;
                }
            }
            self.stiffness[k] = stiff;
            let (mut even, mut odd) = ([0.0; W], [0.0; W]);
            let mut j = 0;
            while j < k {
                for l in 0..W {
                    even[l] += self.stiffness[j][l] * y[k - j][l];
                    odd[l] += self.stiffness[j + 1][l] * y[k - j - 1][l];
                }
                j += 2;
            }
            if k % 2 == 0 {
                for l in 0..W {
                    even[l] += self.stiffness[k][l] * y[0][l];
                }
            }
            let per = 1.0 / ((k + 1) * (k + 2)) as f64;
            let damping = DAMPING * (k + 1) as f64;
            for l in 0..W {
                let a = forcing[l] - damping * self.x[k + 1][l] - (even[l] + odd[l]);
                self.x[k + 2][l] = a * per;
                y[k + 2][l] = self.x[k + 2][l] * self.closed[l];
            }
        }
    }

    /// Lengths of the steps.
    #[inline(always)]
    fn lengths(&self) -> Each<W> {
        let mut h = [0.0; W];
        for l in 0..W {
            let [x, v] = [self.x[0][l], self.x[1][l]];
            let a = 2.0 * self.x[2][l];
            let of_x = 1.0 / (ATOL + RTOL * (x.abs() + self.last[l] * v.abs()));
            let of_v = 1.0 / (ATOL + RTOL * (v.abs() + self.last[l] * a.abs()));
            let term = |n: usize| {
                let x = (self.x[n][l] * of_x).abs();
                let v = ((n + 1) as f64 * self.x[n + 1][l] * of_v).abs();
                if x > v { x } else { v }
            };
            let (last, before) = (term(N), term(N - 1));
            let reach = |term: f64, n: usize| exp2(-log2(term) * (1.0 / n as f64));
            let (a, b) = (reach(last, N), reach(before, N - 1));
            let mut full = if a < b { a } else { b };
            let grown = 2.0 * self.last[l];
            full = if grown > 0.0 && grown < full { grown } else { full };
            h[l] = full;
        }
        h
    }

    /// For each lane, whether it may reach the lower and the upper edge of its piece in its step: the motion differs from
    /// a parabola by at most Σ |x_n| hⁿ from n = 3 on.
    #[inline(always)]
    fn near(&self, h: &Each<W>) -> [[bool; W]; 2] {
        let mut rest = [0.0; W];
        for n in (3..=N).rev() {
            for l in 0..W {
                rest[l] = rest[l] * h[l] + self.x[n][l].abs();
            }
        }
        let mut near = [[false; W]; 2];
        for l in 0..W {
            let ([x, v, a], h) = ([self.x[0][l], self.x[1][l], self.x[2][l]], h[l]);
            let end = x + h * (v + h * a);
            let vertex = -0.5 * v / a;
            let turn = if vertex > 0.0 && vertex < h { x + 0.5 * vertex * v } else { x };
            let (low, high) = (min(min(x, end), turn), max(max(x, end), turn));
            let by_step = rest[l] * h * h;
            let wide = by_step * h;
            // The distances upwards from an edge and downwards to one, over the time where the step starts on it.
            let up = |edge: f64| {
                if self.on[l] == edge { min(v, v + h * a) - by_step } else { low - wide - edge }
            };
            let down = |edge: f64| {
                if self.on[l] == edge { -max(v, v + h * a) - by_step } else { edge - high - wide }
            };
            let closed = self.closed[l] > 0.5;
            let flank = if self.edge[l] > 0.0 { up(B) } else { down(-B) };
            near[0][l] = if closed { flank } else { up(-B) } <= 0.0;
            near[1][l] = !closed && down(B) <= 0.0;
        }
        near
    }

    /// The first time in (0, h] at which each of the chosen lanes leaves through an edge; infinite if it does not.
    /// `upper`: the upper edge of the gap, else the only edge of a flank or the lower edge of the gap.
    #[inline(always)]
    fn roots(&mut self, chosen: &[bool; W], upper: bool, h: &Each<W>) -> Each<W> {
        let mut p = [[0.0; W]; N + 1];
        let (mut sign, mut edge) = ([0.0; W], [0.0; W]);
        for l in 0..W {
            let closed = self.closed[l] > 0.5;
            edge[l] = if closed {
                self.edge[l]
            } else if upper {
                B
            } else {
                -B
            };
            sign[l] = if closed == (edge[l] > 0.0) { 1.0 } else { -1.0 };
        }
        for n in 0..=N {
            for l in 0..W {
                let c = if self.on[l] == edge[l] {
                    self.x[n + 1][l]
                } else if n == 0 {
                    self.x[n][l] - edge[l]
                } else {
                    self.x[n][l]
                };
                p[n][l] = sign[l] * c;
            }
        }
        first_roots(&p, chosen, h)
    }

    #[inline(always)]
    fn step(&mut self, weights: &[[f64; 7]; N + 1]) {
        self.expand(weights);
        let full = self.lengths();
        let mut h = [0.0; W];
        for l in 0..W {
            let left = self.t_end[l] - self.t[l];
            h[l] = if full[l] * (1.0 + 1e-10) < left { full[l] } else { left };
        }
        let near = self.near(&h);
        let mut exits = [None; W];
        for (upper, near) in near.iter().enumerate() {
            if near.iter().any(|near| *near) {
                let roots = self.roots(near, upper == 1, &h);
                for l in 0..W {
                    self.looks += u64::from(near[l]);
                    if roots[l] <= h[l] {
                        self.roots += 1;
                        h[l] = roots[l];
                        exits[l] = Some(match self.piece[l] {
                            Piece::Gap if upper == 1 => (Piece::Upper, B),
                            Piece::Gap => (Piece::Lower, -B),
                            _ => (Piece::Gap, self.edge[l]),
                        });
                    }
                }
            }
        }
        let (mut x, mut v, mut sum) = ([0.0; W], [0.0; W], [0.0; W]);
        for n in (0..=N).rev() {
            let per = 1.0 / (n + 1) as f64;
            for l in 0..W {
                v[l] = v[l] * h[l] + x[l];
                x[l] = x[l] * h[l] + self.x[n][l];
                sum[l] = sum[l] * h[l] + per * self.x[n][l];
            }
        }
        for l in 0..W {
            self.integral[l] += sum[l] * h[l];
            (self.x[0][l], self.x[1][l]) = (x[l], v[l]);
            self.on[l] = f64::NAN;
            self.last[l] = full[l];
            self.t[l] += h[l];
        }
        for l in 0..W {
            let Some(point) = self.point[l] else { continue };
            self.steps += 1;
            if let Some((to, edge)) = exits[l] {
                self.crossings[l] += 1;
                (self.x[0][l], self.on[l]) = (edge, edge);
                self.set_piece(l, to);
            } else if h[l] < full[l] || self.t[l] >= self.t_end[l] {
                let x = self.x[0][l];
                let mean = self.integral[l] / self.t_end[l];
                self.ends[point] = End { x, crossings: self.crossings[l], mean };
                self.refill(l);
            }
        }
    }
}

#[inline(always)]
fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
#[inline(always)]
fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Value, slope and, with `BEND`, Σ n (n - 1) |c_n| sⁿ of the polynomial of each lane. Even and odd orders apart, p =
/// E(s²) + s O(s²): the sums do not wait for one another.
#[inline(always)]
fn evaluate<const W: usize, const BEND: bool>(p: &[Each<W>], s: &Each<W>) -> [Each<W>; 3] {
    let mut sums = [[[0.0; W]; 3]; 2];
    let mut square = [0.0; W];
    for l in 0..W {
        square[l] = s[l] * s[l];
    }
    for (n, c) in p.iter().enumerate().rev() {
        let factor = (n * n.saturating_sub(1)) as f64;
        let [value, slope, bend] = &mut sums[n % 2];
        for l in 0..W {
            slope[l] = slope[l] * square[l] + value[l];
            value[l] = value[l] * square[l] + c[l];
            if BEND {
                bend[l] = bend[l] * square[l] + factor * c[l].abs();
            }
        }
    }
    let [even, odd] = &sums;
    let [mut value, mut slope, mut bend] = [[0.0; W]; 3];
    for l in 0..W {
        value[l] = even[0][l] + s[l] * odd[0][l];
        slope[l] = odd[0][l] + 2.0 * s[l] * (even[1][l] + s[l] * odd[1][l]);
        bend[l] = even[2][l] + s[l] * odd[2][l];
    }
    [value, slope, bend]
}

/// The first root in (0, h] of the polynomial of each chosen lane, which is positive at 0; infinite if there is none. A
/// lane that has ended waits; what it holds does not change.
#[inline(always)]
fn first_roots<const W: usize>(p: &[Each<W>; N + 1], chosen: &[bool; W], h: &Each<W>) -> Each<W> {
    let [mut a, mut width, mut lo, mut hi, mut s] = [[0.0; W]; 5];
    let (mut value_a, mut slope_a) = (p[0], p[1]);
    let (mut active, mut found) = (*chosen, [false; W]);
    for l in 0..W {
        let near = -2.0 * value_a[l] / slope_a[l];
        width[l] = if near > 0.0 { min(near, h[l]) } else { h[l] };
    }
    while active.iter().any(|active| *active) {
        let mut b = [0.0; W];
        for l in 0..W {
            b[l] = a[l] + width[l];
        }
        let [value_b, slope_b, bend] = evaluate::<W, true>(p, &b);
        for l in 0..W {
            let (sum, share) = (slope_a[l] + slope_b[l], width[l] / b[l]);
            let bound = bend[l] / b[l] * share;
            let (falls, rises) = (sum + bound < 0.0, sum - bound > 0.0);
            let short = width[l] < 1e-13 * h[l];
            let stays = rises | falls | (min(value_a[l], value_b[l]) > 0.125 * bend[l] * share * share);
            let passes = (value_b[l] > 0.0) & (stays | short);
            let brackets = active[l] & (value_b[l] <= 0.0) & (falls | short);
            lo[l] = if brackets { a[l] } else { lo[l] };
            hi[l] = if brackets { b[l] } else { hi[l] };
            let secant = a[l] + width[l] * value_a[l] / (value_a[l] - value_b[l]);
            s[l] = if brackets { secant } else { s[l] };
            found[l] |= brackets;
            let ends = passes & (b[l] >= h[l] * (1.0 - 1e-12));
            active[l] &= !(brackets | ends);
            let moves = active[l] & passes;
            a[l] = if moves { b[l] } else { a[l] };
            value_a[l] = if moves { value_b[l] } else { value_a[l] };
            slope_a[l] = if moves { slope_b[l] } else { slope_a[l] };
            let grown = min(2.0 * width[l], h[l] - a[l]);
            width[l] = if moves { grown } else { 0.5 * width[l] };
        }
    }
    let mut roots = [f64::INFINITY; W];
    let mut open = found;
    let mut rounds = 0;
    while open.iter().any(|open| *open) && rounds < 60 {
        rounds += 1;
        let [value, slope, _] = evaluate::<W, false>(p, &s);
        for l in 0..W {
            let positive = value[l] > 0.0;
            lo[l] = if positive { s[l] } else { lo[l] };
            hi[l] = if positive { hi[l] } else { s[l] };
            let next = s[l] - value[l] / slope[l];
            let inside = (next > lo[l]) & (next < hi[l]);
            let next = if inside { next } else { 0.5 * (lo[l] + hi[l]) };
            // Newton's step squares the error.
            let small = inside & ((next - s[l]).abs() <= 1e-7 * h[l]);
            roots[l] = if open[l] { next } else { roots[l] };
            open[l] &= !small;
            s[l] = if open[l] { next } else { s[l] };
        }
    }
    roots
}

/// Runs all points in W lanes; returns the time and prints what was done.
fn lanes<const W: usize, S: Simd>(speeds: &[f64], ends: &mut [End], arch: S) -> f64 {
    let mut least = f64::INFINITY;
    for round in 0..5 {
        let start = Instant::now();
        let mut all = Lanes::<W>::new(speeds, ends);
        arch.vectorize(Run(&mut all));
        least = least.min(start.elapsed().as_secs_f64());
        if round == 0 {
            println!("{W} lanes: {} steps, {} searches for edges, {} roots", all.steps, all.looks, all.roots);
        }
    }
    least
}

fn main() {
    let speeds: Vec<f64> = (0..64).map(|i| 0.15 + 0.0033 * f64::from(i)).collect();
    let taylor = Taylor::new().rtol(RTOL).atol(ATOL).order(N);
    let tight = Taylor::new().rtol(1e-14).atol(1e-19);
    let machines: Vec<_> = speeds.iter().map(|we| Pair::at(*we).machine_of_waves()).collect();
    let end = |solver: &Taylor, i: usize| -> State {
        solver.end(&machines[i], &Pair::start(), Pair::at(speeds[i]).end()).expect("the workload runs")
    };
    let truth: Vec<State> = (0..64).map(|i| end(&tight, i)).collect();
    let (mut plain, mut observed) = (f64::INFINITY, f64::INFINITY);
    let mut scalar = Vec::new();
    for _ in 0..3 {
        let start = Instant::now();
        scalar = (0..64).map(|i| end(&taylor, i)).collect();
        plain = plain.min(start.elapsed().as_secs_f64());
        let start = Instant::now();
        for (machine, we) in machines.iter().zip(&speeds) {
            let mut rattle = Rattle::new(machine);
            let finish = taylor.run(machine, &Pair::start(), Pair::at(*we).end(), &mut rattle);
            finish.expect("the workload runs");
        }
        observed = observed.min(start.elapsed().as_secs_f64());
    }
    let error = |all: &dyn Fn(usize) -> f64| {
        let mut errors: Vec<f64> = (0..64).map(|i| (all(i) - truth[i].q[0]).abs() / B).collect();
        errors.sort_by(f64::total_cmp);
        format!("median error {:.1e} of b, largest {:.1e}", errors[32], errors[63])
    };
    println!(
        "Taylor: {:.3} ms a run, with rattle {:.3} ms; {}",
        plain / 64e-3,
        observed / 64e-3,
        error(&|i| scalar[i].q[0])
    );
    let mut ends = vec![End::default(); 64];
    let v4 = pulp::x86::V4::try_new();
    let v3 = pulp::x86::V3::try_new();
    let line = |name: &str, time: f64, ends: &[End]| {
        println!("{name}: {:.3} ms a run; {}", time / 64e-3, error(&|i| ends[i].x));
        println!("ratio lanes-taylor scalar, {name} {:.2}", plain / time);
    };
    if let Some(arch) = v3 {
        line("4 lanes AVX2", lanes::<4, _>(&speeds, &mut ends, arch), &ends);
        line("8 lanes AVX2", lanes::<8, _>(&speeds, &mut ends, arch), &ends);
    }
    if let Some(arch) = v4 {
        line("8 lanes AVX-512", lanes::<8, _>(&speeds, &mut ends, arch), &ends);
        line("16 lanes AVX-512", lanes::<16, _>(&speeds, &mut ends, arch), &ends);
    }
    let crossings: u32 = ends.iter().map(|end| end.crossings).sum();
    println!("{crossings} crossings, mean of the first run {:.6e}", ends[0].mean);
}
