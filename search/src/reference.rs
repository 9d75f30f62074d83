//! The reference: motions of plain closures by small fixed steps. It uses nothing of the library.
//!
//! A step is the classical Runge-Kutta step of order 4 on fixed zones of all contacts. Where a contact leaves its zone
//! within a step, the length of the step is bisected. Steps end at the jumps of the drives. Every answer comes from two
//! runs, with steps of the lengths h and h/2; their difference says what is left open.

use std::f64::consts::TAU;

/// An instant: time, coordinates, velocities.
pub struct At<'a> {
    /// Time. At a jump it lies a little inside the step, on the side of the step.
    pub t: f64,
    /// Coordinates.
    pub q: &'a [f64],
    /// Velocities.
    pub v: &'a [f64],
}

/// Writes the accelerations on given zones.
pub type Acceleration<'a> = dyn Fn(&At<'_>, &[i8], &mut [f64]) + 'a;

/// Replaces the velocities at the impact of a contact.
pub type Impact<'a> = dyn Fn(usize, &mut [f64]) + 'a;

/// Distances d - lower edge and d - upper edge of a contact.
pub type Distances<'a> = dyn Fn(&At<'_>, usize) -> [f64; 2] + 'a;

/// q'' = a(t, q, q') with contacts and jumps.
pub struct Plain<'a> {
    /// Number of coordinates.
    pub dof: usize,
    /// Number of contacts.
    pub contacts: usize,
    /// Writes the accelerations. The zone of each contact is -1 below its lower edge, 0 in its gap, 1 above its upper one.
    pub accel: &'a Acceleration<'a>,
    /// The distances of each contact from its edges.
    pub distances: &'a Distances<'a>,
    /// The first jump of a drive after an instant; infinite without one.
    pub jump: &'a dyn Fn(f64) -> f64,
    /// Replaces the velocities at the impact of a contact on a rigid edge. Without it every edge is crossed.
    pub impact: Option<&'a Impact<'a>>,
}

/// A part of a motion without an event: both ends, and the zones between them.
pub struct Part<'a> {
    /// Its start.
    pub start: At<'a>,
    /// Its end.
    pub end: At<'a>,
    /// The zones of all contacts.
    pub zones: &'a [i8],
    /// Whether each contact has come to its zone at the start of the part.
    pub entered: &'a [bool],
}

/// The time by which the ends of a step from `t` are moved inside, so that a drive that jumps there is on the step's side.
fn inside(t: f64, h: f64) -> f64 {
    (1e-10 * h).max(16.0 * f64::EPSILON * t.abs()).min(0.25 * h)
}

/// A run ends after this number of events.
const MOST: u64 = 2_000;

impl Plain<'_> {
    fn zone(&self, at: &At<'_>, contact: usize) -> i8 {
        let [lower, upper] = (self.distances)(at, contact);
        if lower < 0.0 { -1 } else { i8::from(upper > 0.0) }
    }

    /// Whether a contact lies outside its zone.
    fn is_outside(&self, at: &At<'_>, zones: &[i8]) -> bool {
        (0..self.contacts).any(|i| self.zone(at, i) != zones[i])
    }

    /// The state after a step.
    fn step(&self, t: f64, y: &[f64], h: f64, zones: &[i8]) -> Vec<f64> {
        let n = self.dof;
        let slope = |t: f64, y: &[f64]| {
            let mut slope = [&y[n..], &vec![0.0; n]].concat();
            (self.accel)(&At { t, q: &y[..n], v: &y[n..] }, zones, &mut slope[n..]);
            slope
        };
        let moved =
            |by: f64, slope: &[f64]| y.iter().zip(slope).map(|(y, s)| y + by * s).collect::<Vec<f64>>();
        let k1 = slope(t + inside(t, h), y);
        let k2 = slope(t + 0.5 * h, &moved(0.5 * h, &k1));
        let k3 = slope(t + 0.5 * h, &moved(0.5 * h, &k2));
        let k4 = slope(t + h - inside(t, h), &moved(h, &k3));
        (0..2 * n).map(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i])).collect()
    }

    /// Where a distance may reach an edge inside a step and leave it again, after the start of the step: the vertex of the
    /// parabola through its start, middle and end, if this lies beyond the edge or near it. The first one.
    fn dip(&self, states: [&[f64]; 3], t: f64, h: f64) -> Option<f64> {
        let n = self.dof;
        let times = [t + inside(t, h), t + 0.5 * h, t + h - inside(t, h)];
        let at = |k: usize, i: usize| {
            let [q, v] = [&states[k][..n], &states[k][n..]];
            (self.distances)(&At { t: times[k], q, v }, i)
        };
        let vertex = |i: usize, edge: usize| {
            let [a, b, c] = [0, 1, 2].map(|k| at(k, i)[edge]);
            let (slope, bend) = (4.0 * b - 3.0 * a - c, 2.0 * (a + c) - 4.0 * b);
            let (place, depth) = (-0.5 * slope / bend, 0.25 * slope * slope / bend);
            // The parabola errs by a share of its depth.
            let reaches = a * bend > 0.0 && (a - depth) * bend < 0.1 * depth.abs() * bend.abs();
            (reaches && (0.0..1.0).contains(&place)).then_some(h * place)
        };
        let all = (0..self.contacts).flat_map(|i| [vertex(i, 0), vertex(i, 1)]);
        all.flatten().reduce(f64::min)
    }

    /// The motion from `y` (coordinates, then velocities) at `t` to `end` with steps of at most `h`. Returns the last
    /// state and the number of events of contacts; after 2 000 of them it ends early.
    pub fn run(
        &self,
        t: f64,
        y: &[f64],
        end: f64,
        h: f64,
        observe: &mut dyn FnMut(&Part<'_>),
    ) -> (Vec<f64>, u64) {
        let (mut t, mut y, n, mut events) = (t, y.to_vec(), self.dof, 0);
        let first = At { t: t + inside(t, h), q: &y[..n], v: &y[n..] };
        let mut zones: Vec<i8> = (0..self.contacts).map(|i| self.zone(&first, i)).collect();
        let mut entered = vec![false; self.contacts];
        while t < end && events < MOST {
            let mut stop = end.min((self.jump)(t));
            if stop - t < 1e-13 * h {
                stop = end.min((self.jump)(t + 1e-12 * h));
            }
            let whole = (stop - t).min(h);
            let at_end = |s: f64, y: &[f64]| {
                self.is_outside(&At { t: t + s - inside(t, s), q: &y[..n], v: &y[n..] }, &zones)
            };
            let (mut s, mut next) = (whole, self.step(t, &y, whole, &zones));
            let mut meets = at_end(s, &next);
            if !meets
                && self.impact.is_some()
                && let Some(dip) = self.dip([&y, &self.step(t, &y, 0.5 * whole, &zones), &next], t, whole)
            {
                let there = self.step(t, &y, dip, &zones);
                if at_end(dip, &there) {
                    (s, next, meets) = (dip, there, true);
                }
            }
            if meets {
                let mut low = 0.0;
                for _ in 0..60 {
                    let middle = 0.5 * (low + s);
                    let there = self.step(t, &y, middle, &zones);
                    if at_end(middle, &there) {
                        (s, next) = (middle, there);
                    } else {
                        low = middle;
                    }
                }
            }
            let [start, last] = [(t + inside(t, s), &y), (t + s - inside(t, s), &next)].map(|(t, y)| At {
                t,
                q: &y[..n],
                v: &y[n..],
            });
            let new: Vec<i8> = (0..self.contacts).map(|i| self.zone(&last, i)).collect();
            observe(&Part { start, end: last, zones: &zones, entered: &entered });
            t = if s == whole && whole < h { stop } else { t + s };
            y = next;
            entered.fill(false);
            for i in 0..self.contacts {
                if !meets || new[i] == zones[i] {
                    continue;
                }
                events += 1;
                match self.impact {
                    Some(impact) => impact(i, &mut y[n..]),
                    None => (zones[i], entered[i]) = (new[i], true),
                }
            }
        }
        (y, events)
    }
}

/// Mean, root mean square, minimum and maximum of a channel, and the time and the entries of a contact.
#[derive(Clone, Copy, Debug)]
pub struct Figures {
    /// ∫ x dt and ∫ x² dt over the time, by the trapezoidal rule.
    pub means: [f64; 2],
    /// Minimum and maximum, each side of a jump taken.
    pub extremes: [f64; 2],
}

/// Collects the figures of one channel over parts.
pub struct Meter {
    sums: [f64; 2],
    extremes: [f64; 2],
    time: f64,
    /// The last two ends of parts without a jump or an edge between them: time and value.
    last: [Option<[f64; 2]>; 2],
}

impl Default for Meter {
    fn default() -> Self {
        Meter { sums: [0.0; 2], extremes: [f64::INFINITY, f64::NEG_INFINITY], time: 0.0, last: [None; 2] }
    }
}

impl Meter {
    /// Adds a part with the values at its ends.
    pub fn add(&mut self, part: &Part<'_>, values: [f64; 2]) {
        let (h, [a, b]) = (part.end.t - part.start.t, values);
        self.sums[0] += 0.5 * h * (a + b);
        self.sums[1] += 0.5 * h * (a * a + b * b);
        self.time += h;
        for x in values {
            self.take(x);
        }
        let size = self.extremes[1] - self.extremes[0];
        if let [Some([t0, x0]), Some([t1, x1])] = self.last {
            // A jump, or a kink at an edge: a parabola through it would overshoot.
            if (a - x1).abs() > 1e-6 * size || part.entered.contains(&true) {
                self.last = [None; 2];
            } else {
                // The vertex of the parabola through three neighbours, if it lies between them.
                let [before, after] = [t1 - t0, part.end.t - t1];
                let [left, right] = [(x1 - x0) / before, (b - x1) / after];
                let bend = (right - left) / (before + after);
                let slope = left + bend * before;
                let vertex = -0.5 * slope / bend;
                // Very unequal steps beside an event leave the bend to rounding.
                if (-before..after).contains(&vertex) && (0.2..5.0).contains(&(before / after)) {
                    self.take(x1 + 0.5 * slope * vertex);
                }
            }
        }
        self.last = [self.last[1].or(Some([part.start.t, a])), Some([part.end.t, b])];
    }
    fn take(&mut self, x: f64) {
        self.extremes = [self.extremes[0].min(x), self.extremes[1].max(x)];
    }
    /// The figures so far.
    pub fn figures(&self) -> Figures {
        Figures {
            means: [self.sums[0] / self.time, (self.sums[1] / self.time).sqrt()],
            extremes: self.extremes,
        }
    }
}

/// The first of the instants (k + place) period behind `t`.
pub fn next_of(places: &[f64], period: f64, t: f64) -> f64 {
    let after = |place: &f64| {
        let k = ((t - place) / period).floor() + 1.0;
        let at = k * period + place;
        if at > t { at } else { at + period }
    };
    places.iter().map(after).fold(f64::INFINITY, f64::min)
}

/// The remainder of an angle in [-π, π).
pub fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU + 0.5).floor()
}

/// Least and largest value on [0, h] of the cubic with these values and slopes at both ends.
pub fn extremes_of_cubic([a, b]: [f64; 2], [slope_a, slope_b]: [f64; 2], h: f64) -> [f64; 2] {
    // x(s) = a + p s + c s² + d s³ with the share s of h.
    let (p, q) = (h * slope_a, h * slope_b);
    let (c, d) = (3.0 * (b - a) - 2.0 * p - q, p + q - 2.0 * (b - a));
    let root = (c * c - 3.0 * d * p).max(0.0).sqrt();
    // The roots of p + 2 c s + 3 d s² without cancellation.
    let sum = -(c + if c < 0.0 { -root } else { root });
    let at = |s: f64| a + s * (p + s * (c + s * d));
    let inner = [sum / (3.0 * d), p / sum].into_iter().filter(|s| (0.0..1.0).contains(s)).map(at);
    inner.fold([a.min(b), a.max(b)], |[low, high], x| [low.min(x), high.max(x)])
}

/// ∫ x dt over [0, h] of the cubic with these values and slopes at both ends.
pub fn integral_of_cubic([a, b]: [f64; 2], [slope_a, slope_b]: [f64; 2], h: f64) -> f64 {
    h * (0.5 * (a + b) + h * (slope_a - slope_b) / 12.0)
}

/// Whether a number exceeds a bound or is NaN.
pub fn exceeds(x: f64, bound: f64) -> bool {
    x.is_nan() || x > bound
}
