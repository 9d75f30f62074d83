//! Whether the polynomials of a step solve the equation throughout the step.

use crate::contact::Piece;
use crate::model::expansion::expand::Expand;
use crate::numeric::norms::largest;
use crate::ode::taylor::course::are_steep;
use crate::ode::taylor::distances::Distances;
use crate::ode::taylor::expansion::coefficients::Coefficients;
use crate::ode::taylor::expansion::plan::EdgeColumn;
use crate::ode::taylor::pace::{FINEST, size_of_distance};
use crate::series::Series;
use crate::steepness::JETS;
use crate::tape::operations::Tape;

/// The polynomials of a motion over a step.
pub(crate) trait MotionPolynomials: Distances {
    /// Writes coordinates and velocities at the time `s` after the start of the step.
    fn state(&self, s: f64, y: &mut [f64]);
    /// Writes the accelerations.
    fn acceleration(&self, s: f64, a: &mut [f64]);
}

/// A step whose polynomials are checked.
pub(crate) struct Checked<'s> {
    /// Start and length.
    pub(crate) t: f64,
    pub(crate) h: f64,
    pub(crate) pieces: &'s [Piece],
    pub(crate) rtol: f64,
    /// Absolute tolerance of each coordinate and velocity.
    pub(crate) atol: &'s [f64],
    /// Whether functions of the tape or of the drives may be steep.
    pub(crate) is_steep: bool,
    /// Whether a sum that varies with the time alone may be steep.
    pub(crate) hides_a_sum: bool,
}

/// The defect of a motion x(s) in a step: x'' - a(u, x, x'), at instants that no function on the tape or in a
/// drive passes unseen. From one instant to the next the exponent of each exponential, and the logarithm
/// of each divisor and of each base of a power, move by their [`steepness`](crate::steepness) at most.
pub(crate) struct Defect {
    /// Whether the tape has functions that a step may pass unseen.
    pub(crate) of_tape: bool,
    /// The expansion at an instant.
    c: Coefficients,
    series: Vec<Series>,
    /// Coordinates and velocities, at the start and at an instant.
    start: Vec<f64>,
    y: Vec<f64>,
    /// 1/tolerance of each coordinate and velocity.
    per: Vec<f64>,
    /// The accelerations of the polynomials.
    held: Vec<f64>,
    /// What rounding of coordinates, velocities and drives changes: accelerations, then distances.
    noise: Vec<f64>,
    /// Number of orders evaluated.
    pub(crate) evaluations: u64,
}

/// What the instants of a step show.
enum Walked {
    /// The polynomials solve the equation.
    Solved,
    /// They do not, unless rounding explains it, which has been estimated.
    Rounded,
    /// They solve it up to the time `s`, and do not at the instant `failed`.
    Until { s: f64, failed: Option<f64> },
}

/// Largest number of instants in a step. A step that needs more ends at the last one.
const INSTANTS: usize = 64;

/// The last instant lies before the end of the step by this share of it: drives may jump at the end `[1]`.
const BEFORE_END: f64 = 1.0 / 1024.0;

/// Allowed integral of the defect, in tolerances `[1]`: the terms after the last ones of the series are of
/// the size of the tolerance.
const ALLOWED: f64 = 4.0;

/// Whether a sum of defects is above what is allowed, or not a number.
fn exceeds(sum: f64) -> bool {
    sum.is_nan() || sum > ALLOWED
}

/// The time `s` after `t`, as far as the instant t + s has digits: drives and polynomials at one instant.
fn after(t: f64, s: f64) -> f64 {
    (t + s) - t
}

/// From this share of a step on, the defect of a series grows like a high power of the time `[1]`.
const LATE: f64 = 0.75;

/// Relative size of the changes with which rounding is estimated, and safety factor `[1]`.
const SHAKE: f64 = 4.0 * f64::EPSILON;
const SAFETY: f64 = 8.0;

impl Defect {
    pub(crate) fn new(tape: &Tape, of_tape: bool) -> Self {
        let (c, n) = (Coefficients::new(tape, |_| false), tape.dof);
        let edges = c.plan.edges.len();
        Defect {
            of_tape,
            c,
            series: vec![Series::from(0.0); tape.drives],
            start: vec![0.0; 2 * n],
            y: vec![0.0; 2 * n],
            per: vec![0.0; 2 * n],
            held: vec![0.0; n],
            noise: vec![0.0; n + edges],
            evaluations: 0,
        }
    }

    /// The length of the step up to which the polynomials solve the equation within the tolerances.
    pub(crate) fn length(
        &mut self,
        step: &Checked<'_>,
        expanded: &dyn Expand,
        motion: &impl MotionPolynomials,
    ) -> f64 {
        self.c.set_pieces(step.pieces);
        let mut h = step.h;
        motion.state(0.0, &mut self.start);
        let known = self.look(step, 0.0, expanded, motion);
        let is_unknown = self.may_hide_a_product();
        for ((per, atol), i) in self.per.iter_mut().zip(step.atol).zip(0..) {
            let n = self.held.len();
            let rate = if i < n { self.c.q(1)[i] } else { self.c.v(1)[i - n] };
            *per = 1.0 / (atol + step.rtol * (self.start[i].abs() + h * rate.abs()) + f64::MIN_POSITIVE);
        }
        loop {
            let first = if is_unknown { known.max(INSTANTS as f64 / h) } else { known };
            let end = after(step.t, h * (1.0 - BEFORE_END));
            if step.t + end >= step.t + h {
                return h;
            }
            let mut verdict = self.walk(step, [h, end, first], false, expanded, motion);
            if let Walked::Rounded = verdict {
                verdict = self.walk(step, [h, end, first], true, expanded, motion);
            }
            match verdict {
                Walked::Solved => return h,
                Walked::Until { s, .. } if s > 0.0 => return s,
                Walked::Until { failed: Some(next), .. } => h = 0.5 * next,
                _ => return 0.0,
            }
        }
    }

    /// Walks over the instants of a step of length `h`, from the steepness `first` at its start to `end`.
    /// `noisy`: whether rounding has been estimated.
    fn walk(
        &mut self,
        step: &Checked<'_>,
        [h, end, first]: [f64; 3],
        noisy: bool,
        expanded: &dyn Expand,
        motion: &impl MotionPolynomials,
    ) -> Walked {
        let (mut s, mut steepness, mut before, mut sum) = (0.0, first, 0.0, 0.0);
        for _ in 0..INSTANTS {
            let apart = if steepness.is_finite() { 1.0 / steepness } else { h / INSTANTS as f64 };
            let next = after(step.t, s + apart.min(0.5 * h));
            let next = if next > s { next } else { (step.t + s).next_up() - step.t }.min(end);
            steepness = self.look(step, next, expanded, motion);
            let mut rate = self.rate(h, step, motion, next, noisy);
            let weight = |s: f64, apart: f64| match s > LATE * h {
                true => (0.5 * apart).min(h / (motion.degree() + 1) as f64),
                false => 0.5 * apart,
            };
            let added = |rate: f64| weight(s, next - s) * before + weight(next, next - s) * rate;
            if exceeds(sum + added(rate)) {
                self.shake(step.t + next);
                if !noisy {
                    return Walked::Rounded;
                }
                rate = self.rate(h, step, motion, next, true);
            }
            sum += added(rate);
            if exceeds(sum) {
                return Walked::Until { s, failed: Some(next) };
            }
            (s, before) = (next, rate);
            if s == end {
                return Walked::Solved;
            }
        }
        Walked::Until { s, failed: None }
    }

    /// Expands the motion at the time `s` of the step. Returns how steep functions are there `[1/s]`, if they
    /// may be steep.
    fn look(
        &mut self,
        step: &Checked<'_>,
        s: f64,
        expanded: &dyn Expand,
        motion: &impl MotionPolynomials,
    ) -> f64 {
        let orders = match (step.is_steep, step.hides_a_sum) {
            (false, _) => 1,
            (true, false) => JETS,
            (true, true) => JETS + 1,
        };
        motion.state(s, &mut self.y);
        motion.acceleration(s, &mut self.held);
        expanded.drive_series(step.t + s, orders + 1, &mut self.series);
        self.c.expand(&self.y, &self.series, orders, false);
        self.evaluations += orders as u64;
        if orders < JETS {
            return 0.0;
        }
        let of_drives = self.c.plan.drives.iter().map(|(drive, _)| self.series[*drive].steepness());
        let of_tape = if self.of_tape { self.c.steepness() } else { 0.0 };
        let of_sums = if step.hides_a_sum { self.c.steepness_of_sums() } else { 0.0 };
        of_drives.fold(of_tape.max(of_sums), f64::max)
    }

    /// Whether a product of high degree is 0 at the start of the step, or may be: a drive tells only that it
    /// is steep. What the product becomes shows in the first of all instants.
    fn may_hide_a_product(&self) -> bool {
        self.of_tape && self.c.has_unknown_product() || are_steep(&self.series, &self.c.plan.drives)
    }

    /// How fast the defect at the instant changes coordinates, velocities and distances, in tolerances
    /// `[1/s]`, beyond what rounding explains.
    fn rate(&self, h: f64, step: &Checked<'_>, motion: &impl MotionPolynomials, s: f64, noisy: bool) -> f64 {
        let n = self.held.len();
        let noise = |i: usize| if noisy { SAFETY * self.noise[i] } else { 0.0 };
        let mut rate: f64 = 0.0;
        let mut take = |x: f64| rate = if x > rate || x.is_nan() { x } else { rate };
        for (i, (a, held)) in self.c.v(1).iter().zip(&self.held).enumerate() {
            take(((a - held).abs() - noise(i)) * self.per[n + i].max(h * self.per[i]));
        }
        if !step.is_steep {
            return rate; // the last terms of distances show what their drives do
        }
        let (actual, extent) = (self.c.distances(0), largest(&self.start[..n]));
        let distance = |edge: &EdgeColumn| edge.sign * actual[edge.column];
        for (i, (own, edge)) in self.c.plan.edges.iter().zip(motion.edges()).enumerate() {
            let held = edge.sign
                * (0..=motion.degree())
                    .rev()
                    .fold(0.0, |sum, k| sum * s + motion.coefficient(k, edge.column));
            let opposite = self.c.plan.edges.iter().find(|other| other.is_opposite(own));
            let gap = opposite.map_or(0.0, |other| distance(own) + distance(other));
            let moves = distance(own).abs() + held.abs() + h * motion.coefficient(1, edge.column).abs();
            let size = step.rtol.max(FINEST) * size_of_distance(gap, moves, extent);
            let off = (distance(own) - held).abs() - noise(n + i);
            if off > 0.0 && size > f64::MIN_POSITIVE {
                take(off / (size * h));
            }
        }
        rate
    }

    /// Estimates what rounding changes at the instant `t`, from numbers that differ by a few roundings, and
    /// drives that do or are at times that do.
    fn shake(&mut self, t: f64) {
        let n = self.held.len();
        let by = |i: usize| if i.is_multiple_of(2) { SHAKE } else { -SHAKE };
        self.noise[..n].copy_from_slice(self.c.v(1));
        for (noise, edge) in self.noise[n..].iter_mut().zip(&self.c.plan.edges) {
            *noise = self.c.distances(0)[edge.column];
        }
        self.y.iter_mut().enumerate().for_each(|(i, y)| *y *= 1.0 + by(i));
        for (i, series) in self.series.iter_mut().enumerate() {
            let rate = series.coefficients().get(1).copied().unwrap_or(0.0);
            let noise = (series.first().abs() + (t * rate).abs()).max(series.noise() / f64::EPSILON);
            *series = series.moved_to(series.first() + by(i) * noise);
        }
        self.c.expand(&self.y, &self.series, JETS, false);
        self.noise[..n].iter_mut().zip(self.c.v(1)).for_each(|(noise, a)| *noise = (*noise - a).abs());
        for (noise, edge) in self.noise[n..].iter_mut().zip(&self.c.plan.edges) {
            *noise = (*noise - self.c.distances(0)[edge.column]).abs();
        }
    }
}
