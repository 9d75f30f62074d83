//! Elementary functions of intervals, with proven bounds.
//!
//! Nothing rests on the accuracy of a library function: each value is a finite sum in interval arithmetic
//! with a bound of what is left out, or is checked by one (the logarithm).

use crate::interval::number::Interval;
use crate::scalar::{Scalar, is_product};

/// π/2 = the sum of these and at most [`QUARTER_REST`]. The first two have 33 bits, so that whole multiples
/// up to 2^20 of them are exact.
const QUARTER: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11];
const QUARTER_REST: Interval = Interval::of_ends(2.022_266_248_795_950_6e-21, 2.022_266_248_795_951e-21);

/// ln 2 = this, which has 33 bits, and the rest.
const LN_2: f64 = 0.693_147_180_485_539_1;
const LN_2_REST: Interval = Interval::of_ends(7.440_617_110_012_396e-11, 7.440_617_110_012_398e-11);

/// Largest whole multiple of π/2 whose parts are exact.
const MOST_QUARTERS: f64 = (1u32 << 20) as f64;

/// Terms of the series of sine and cosine for |x| <= 0.8, and of the exponential for |x| <= 0.35.
const TERMS: u32 = 10;
const EXP_TERMS: u32 = 16;

/// Sine and cosine of an interval of width below 0.1 with |x| <= 0.8, by their series. The series alternate
/// with falling terms: what is left out is smaller than its first term.
fn small_sin_cos(x: Interval) -> [Interval; 2] {
    let square = x.square();
    let [mut sin, mut cos] = [Interval::ONE; 2];
    let rest = |order: u32| {
        let mut term = Interval::ONE;
        for k in 1..=order {
            term = term * Interval::from(x.magnitude()) / Interval::from(f64::from(k));
        }
        Interval::symmetric(term.high())
    };
    for k in (1..TERMS).rev() {
        let k = f64::from(k);
        sin = Interval::ONE - sin * square / Interval::from(2.0 * k * (2.0 * k + 1.0));
        cos = Interval::ONE - cos * square / Interval::from(2.0 * k * (2.0 * k - 1.0));
    }
    [sin * x + rest(2 * TERMS + 1), cos + rest(2 * TERMS)].map(within_one)
}

fn within_one(x: Interval) -> Interval {
    x.common(Interval::of_ends(-1.0, 1.0)).unwrap_or(Interval::of_ends(-1.0, 1.0))
}

/// Sine and cosine of one number; [-1, 1] if it is too large.
fn sin_cos_at(x: f64) -> [Interval; 2] {
    let quarters = (x * std::f64::consts::FRAC_2_PI).round();
    if quarters.is_nan() || quarters.abs() > MOST_QUARTERS {
        return [Interval::of_ends(-1.0, 1.0); 2];
    }
    let parts = QUARTER.map(|part| Interval::from(quarters * part));
    let reduced = Interval::from(x) - parts[0] - parts[1] - QUARTER_REST * quarters;
    let [sin, cos] = small_sin_cos(reduced);
    match (quarters as i64).rem_euclid(4) {
        0 => [sin, cos],
        1 => [cos, -sin],
        2 => [-sin, -cos],
        _ => [-cos, sin],
    }
}

/// Whether an interval may contain `place` + a whole multiple of 2π, both in quarter turns.
fn may_reach(x: Interval, place: f64) -> bool {
    let turns = (x / (Interval::PI * 0.5) - Interval::from(place)) * 0.25;
    turns.low().ceil() <= turns.high().floor()
}

/// e^x of one number.
fn exp_at(x: f64) -> Interval {
    if x > 709.0 {
        return Interval::of_ends(8.2e307, f64::INFINITY); // e^709 = 8.218e307
    }
    if x < -700.0 {
        return Interval::of_ends(0.0, 1e-300);
    }
    let twos = (x / std::f64::consts::LN_2).round();
    let reduced = Interval::from(x) - Interval::from(twos * LN_2) - LN_2_REST * twos;
    let mut sum = Interval::ONE;
    for k in (1..EXP_TERMS).rev() {
        sum = Interval::ONE + sum * reduced / Interval::from(f64::from(k));
    }
    // What is left out is at most twice its first term, since |x| <= 0.35.
    let mut term = 2.0;
    for k in 1..=EXP_TERMS {
        term = (term * reduced.magnitude() / f64::from(k)).next_up();
    }
    (sum + Interval::symmetric(term)) * 2f64.powi(twos as i32)
}

/// ln x of one number x > 0: y + ln(x e^(-y)) for an approximate y, with (t - 1)/t <= ln t <= t - 1.
fn ln_at(x: f64) -> Interval {
    let y = libm::log(x);
    let t = Interval::from(x) * exp_at(-y);
    if t.low() <= 0.0 || !t.is_bounded() {
        return Interval::LINE;
    }
    let beyond = t - Interval::ONE;
    Interval::from(y) + Interval::of_ends((beyond / t).low(), beyond.high())
}

impl Scalar for Interval {
    fn sqrt(self) -> Self {
        if self.low() < 0.0 {
            return Interval::LINE;
        }
        Interval::of_ends(self.low().sqrt().next_down().max(0.0), self.high().sqrt().next_up())
    }
    fn abs(self) -> Self {
        match self {
            _ if self.low() >= 0.0 => self,
            _ if self.high() <= 0.0 => -self,
            _ => Interval::of_ends(0.0, self.magnitude()),
        }
    }
    fn min(self, o: Self) -> Self {
        Interval::of_ends(self.low().min(o.low()), self.high().min(o.high()))
    }
    fn max(self, o: Self) -> Self {
        Interval::of_ends(self.low().max(o.low()), self.high().max(o.high()))
    }
    fn step(self) -> Self {
        match self {
            _ if self.low() > 0.0 => Interval::ONE,
            _ if self.high() <= 0.0 => Interval::ZERO,
            _ => Interval::of_ends(0.0, 1.0),
        }
    }
    fn powf(self, p: f64) -> Self {
        if is_product(p) {
            let mut power = Interval::ONE;
            let (mut factor, mut left) = (self, p.abs() as u32);
            while left > 0 {
                if left % 2 == 1 {
                    power = power * factor;
                }
                factor = factor.square();
                left /= 2;
            }
            return if p < 0.0 { Interval::ONE / power } else { power };
        }
        let at = |x: f64| if x == 0.0 { Interval::ZERO } else { (ln_at(x) * p).exp() };
        match self {
            _ if self.low() > 0.0 || (self.low() == 0.0 && p > 0.0) => at(self.low()).hull(at(self.high())),
            _ => Interval::LINE,
        }
    }
    fn exp(self) -> Self {
        Interval::of_ends(exp_at(self.low()).low(), exp_at(self.high()).high())
    }
    fn ln(self) -> Self {
        if self.low() <= 0.0 || !self.is_bounded() {
            return Interval::LINE;
        }
        Interval::of_ends(ln_at(self.low()).low(), ln_at(self.high()).high())
    }
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    fn sin_cos(self) -> (Self, Self) {
        if !self.is_bounded() {
            return (Interval::of_ends(-1.0, 1.0), Interval::of_ends(-1.0, 1.0));
        }
        let ends = [sin_cos_at(self.low()), sin_cos_at(self.high())];
        // Extremes of the sine lie at 1 and 3 quarter turns, those of the cosine at 0 and 2.
        let [sin, cos] = [[1.0, 3.0], [0.0, 2.0]].map(|[most, least]| {
            [(most, Interval::ONE), (least, -Interval::ONE)]
                .map(|(place, value)| (may_reach(self, place), value))
        });
        let join = |[a, b]: [Interval; 2], extremes: [(bool, Interval); 2]| {
            extremes
                .into_iter()
                .filter(|(reached, _)| *reached)
                .fold(a.hull(b), |all, (_, value)| all.hull(value))
        };
        if self.low() == self.high() {
            return (ends[0][0], ends[0][1]);
        }
        (join([ends[0][0], ends[1][0]], sin), join([ends[0][1], ends[1][1]], cos))
    }
}
