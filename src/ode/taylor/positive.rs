//! The first instant at which a polynomial ceases to be positive.

use crate::numeric::search::bracket::{Bracket, rounding};
use crate::ode::taylor::expansion::coefficients::ORDERS;
use crate::ode::taylor::expansion::sums::SECOND;

/// A polynomial Σ c_n sⁿ over the time s in a step.
#[derive(Clone, Copy)]
pub(crate) struct Polynomial {
    pub(crate) c: [f64; ORDERS],
    pub(crate) degree: usize,
}

/// An interval in which a polynomial ceases to be positive: time and value at both ends.
#[derive(Clone, Copy)]
pub(crate) struct Fall {
    pub(crate) before: [f64; 2],
    pub(crate) after: [f64; 2],
    /// Whether the polynomial falls throughout the interval.
    pub(crate) steady: bool,
}

/// Shortest interval of the search, as a share of the step `[1]`.
const SHORTEST_INTERVAL: f64 = 1e-13;

/// The same after this number of evaluations, for a polynomial that stays at 0 within rounding.
const COARSE: f64 = 1e-4;
const MANY: u32 = 4096;

/// A term below this share of the higher ones is rounding: a contact rests on its edge `[1]`.
const AT_REST: f64 = 1e-6;

impl Polynomial {
    /// Value and derivative.
    pub(crate) fn with_slope(&self, s: f64) -> (f64, f64) {
        // Even and odd orders apart, p = E(s²) + s O(s²): the sums do not wait for one another.
        let (square, mut even, mut odd) = (s * s, [0.0; 2], [0.0; 2]);
        let (pairs, last) = self.c[..=self.degree].as_chunks::<2>();
        if let [last] = last {
            even[0] = *last;
        }
        for [of_even, of_odd] in pairs.iter().rev() {
            even = [even[0] * square + of_even, even[1] * square + even[0]];
            odd = [odd[0] * square + of_odd, odd[1] * square + odd[0]];
        }
        (even[0] + s * odd[0], odd[0] + 2.0 * s * (even[1] + s * odd[1]))
    }
    /// Value, derivative and Σ n (n - 1) |c_n| sⁿ, an upper bound of |p''| s² in [0, s].
    fn with_bend(&self, s: f64) -> (f64, f64, f64) {
        let (square, mut even, mut odd) = (s * s, [0.0; 3], [0.0; 3]);
        let (pairs, last) = self.c[..=self.degree].as_chunks::<2>();
        if let [last] = last {
            even = [*last, 0.0, SECOND[self.degree] * last.abs()];
        }
        for ([c, d], [per_c, per_d]) in pairs.iter().zip(SECOND.as_chunks::<2>().0).rev() {
            even = [even[0] * square + c, even[1] * square + even[0], even[2] * square + per_c * c.abs()];
            odd = [odd[0] * square + d, odd[1] * square + odd[0], odd[2] * square + per_d * d.abs()];
        }
        (even[0] + s * odd[0], odd[0] + 2.0 * s * (even[1] + s * odd[1]), even[2] + s * odd[2])
    }
    /// The polynomial raised by a constant.
    pub(crate) fn raised(mut self, by: f64) -> Self {
        self.c[0] += by;
        self
    }
    /// (p(s) - p(0))/s.
    pub(crate) fn without_root_at_zero(mut self) -> Self {
        self.c.copy_within(1.., 0);
        self.c[ORDERS - 1] = 0.0;
        self.degree = self.degree.saturating_sub(1);
        self
    }

    /// The first order n >= 1 whose term is not negligible at the time `s` beside those of higher orders.
    pub(crate) fn first_term(&self, s: f64) -> usize {
        let (mut first, mut higher) = (self.degree.max(1), 0.0);
        for n in (1..=self.degree).rev() {
            let term = self.c[n].abs() * s.powi(n as i32);
            if term > AT_REST * higher {
                first = n;
            }
            higher += term;
        }
        first
    }

    /// The first root in (a, h] of a polynomial that is positive in [0, a]; 0 if a = 0 and p(0) <= 0.
    pub(crate) fn first_root_after(&self, a: f64, h: f64) -> Option<f64> {
        let fall = self.first_fall(a, h)?;
        Some(if fall.after[0] == 0.0 { 0.0 } else { self.root_in(&fall) })
    }
    /// A time at which the polynomial is not positive, close after its first root in (a, h]; `None` if there
    /// is no root. It is positive in [0, a].
    pub(crate) fn negative_after(&self, a: f64, h: f64) -> Option<f64> {
        self.first_fall(a, h).map(|fall| fall.after[0])
    }

    /// The root in an interval.
    pub(crate) fn root_in(&self, fall: &Fall) -> f64 {
        let ([a, value_a], [b, value_b]) = (fall.before, fall.after);
        self.root_between(a, b, a + (b - a) * value_a / (value_a - value_b))
    }

    /// The interval of the first root in (a, h]. The polynomial is positive in [0, a]; if a = 0 and p(0) <=
    /// 0, the numbers are 0.
    ///
    /// An interval is left out only if a bound on the second derivative rules a root out. No root is missed,
    /// apart from pairs of roots closer than [`SHORTEST_INTERVAL`], or [`COARSE`] after [`MANY`] intervals.
    pub(crate) fn first_fall(&self, mut a: f64, h: f64) -> Option<Fall> {
        if a == 0.0 && self.c[0] <= 0.0 {
            return Some(Fall { before: [0.0; 2], after: [0.0; 2], steady: false });
        }
        let (mut value_a, mut slope_a) = if a > 0.0 { self.with_slope(a) } else { (self.c[0], self.c[1]) };
        // The first interval ends at twice the distance of Newton's step, beyond a near root.
        let near = -2.0 * value_a / slope_a;
        let (mut width, mut looks) = (if near > 0.0 { near.min(h - a) } else { h - a }, 0);
        loop {
            looks += 1;
            let shortest = if looks < MANY { SHORTEST_INTERVAL } else { COARSE };
            let b = a + width;
            let (value_b, slope_b, bend) = self.with_bend(b);
            if !value_b.is_finite() {
                return None; // no polynomial: the step is judged by its end
            }
            // Over the interval |p''| <= bend/b².
            let (sum, share) = (slope_a + slope_b, width / b);
            let bound = bend / b * share;
            let (falls, rises) = (sum + bound < 0.0, sum - bound > 0.0);
            let short = width < shortest * h;
            let stays = rises || falls || value_a.min(value_b) > 0.125 * bend * share * share;
            if value_b > 0.0 && (stays || short) {
                if b >= h * (1.0 - 1e-12) {
                    return None;
                }
                (a, value_a, slope_a) = (b, value_b, slope_b);
                width = (2.0 * width).min(h - a);
            } else if value_b <= 0.0 && (falls || short) {
                return Some(Fall { before: [a, value_a], after: [b, value_b], steady: falls });
            } else {
                width *= 0.5;
            }
        }
    }

    /// The root between `lo` with p > 0 and `hi` with p <= 0, from a guess.
    fn root_between(&self, lo: f64, hi: f64, guess: f64) -> f64 {
        Bracket { lo, hi }.solve(guess, false, rounding, |s| self.with_slope(s))
    }
}
