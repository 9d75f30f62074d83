//! Intervals contain the truth: random expressions against numbers of twice the digits, sines of large
//! angles, waves over stretches of an angle.

use gear_dynamics::certify::Interval;
use gear_dynamics::excitation::{
    Constant, EnclosedAngle, Fourier, InstantCentre, Product, RectangularWave, Scaled, Side, Sum,
};
use gear_dynamics::model::{PowerSeries, Scalar};
use gear_dynamics::teeth::{LossShape, Piecewise, ToothLoss};
use gear_dynamics::{ParameterError, Wave};

/// A number of some 32 digits: high + low.   Source: Dekker 1971, Numerische Mathematik 18, 224.
#[derive(Clone, Copy, Debug)]
struct Twice(f64, f64);

impl Twice {
    fn sum(a: f64, b: f64) -> Self {
        let s = a + b;
        let c = s - a;
        Twice(s, (a - (s - c)) + (b - c))
    }
    fn plus(self, o: Self) -> Self {
        let (s, t) = (Twice::sum(self.0, o.0), Twice::sum(self.1, o.1));
        let s = Twice::sum(s.0, s.1 + t.0);
        Twice::sum(s.0, s.1 + t.1)
    }
    fn times(self, o: Self) -> Self {
        let p = self.0 * o.0;
        let rest = self.0.mul_add(o.0, -p) + (self.0 * o.1 + self.1 * o.0);
        Twice::sum(p, rest)
    }
    fn negative(self) -> Self {
        Twice(-self.0, -self.1)
    }
    fn over(self, o: Self) -> Self {
        // Two corrections of the quotient of the high parts.
        (0..2).fold(Twice(self.0 / o.0, 0.0), |q, _| {
            let rest = self.plus(q.times(o).negative());
            q.plus(Twice(rest.0 / o.0, 0.0))
        })
    }
    fn sqrt(self) -> Self {
        if self.0 <= 0.0 {
            return Twice(0.0, 0.0);
        }
        (0..2).fold(Twice(self.0.sqrt(), 0.0), |r, _| {
            let rest = self.plus(r.times(r).negative());
            r.plus(Twice(rest.0 / (2.0 * r.0), 0.0))
        })
    }
    /// Σ x^k/k!, of x/2^8, squared eight times.
    fn exp(self) -> Self {
        let x = Twice(self.0 / 256.0, self.1 / 256.0);
        let one = Twice(1.0, 0.0);
        let sum = (1..=16).rev().fold(one, |sum, k| one.plus(sum.times(x).over(Twice(f64::from(k), 0.0))));
        (0..8).fold(sum, |power, _| power.times(power))
    }
    /// Two Newton steps y + x e^(-y) - 1.
    fn ln(self) -> Self {
        (0..2).fold(Twice(self.0.ln(), 0.0), |y, _| {
            y.plus(self.times(y.negative().exp())).plus(Twice(-1.0, 0.0))
        })
    }
    /// Sine and cosine of |x| up to some 100: those of x/2^10 by their series, doubled ten times, after the
    /// whole turns.
    fn sin_cos(self) -> [Self; 2] {
        // 2π to 48 digits in three parts.
        const TURN: [f64; 3] =
            [std::f64::consts::TAU, 2.449_293_598_294_706_4e-16, -5.989_539_619_436_679e-33];
        let turns = (self.0 / TURN[0]).round();
        let x = TURN.iter().fold(self, |x, part| x.plus(Twice(*part, 0.0).times(Twice(-turns, 0.0))));
        let x = Twice(x.0 / 1024.0, x.1 / 1024.0);
        let square = x.times(x).negative();
        let one = Twice(1.0, 0.0);
        let series = |first: f64| {
            (1..=7).rev().fold(one, |sum, k| {
                let k = 2.0 * f64::from(k) + first;
                one.plus(sum.times(square).over(Twice(k * (k - 1.0), 0.0)))
            })
        };
        let mut sin = series(1.0).times(x);
        // 1 - cos, which keeps its digits.
        let mut rest = series(0.0).plus(one.negative()).negative();
        for _ in 0..10 {
            let cos = one.plus(rest.negative());
            (sin, rest) = (sin.times(cos).times(Twice(2.0, 0.0)), sin.times(sin).times(Twice(2.0, 0.0)));
        }
        [sin, one.plus(rest.negative())]
    }
    /// Whether the number lies in an interval, up to its own rounding `error`.
    fn lies_in(self, x: Interval, error: f64) -> bool {
        let above = self.plus(Twice(-x.low(), 0.0));
        let below = Twice(x.high(), 0.0).plus(self.negative());
        (x.low() == f64::NEG_INFINITY || above.0 >= -error)
            && (x.high() == f64::INFINITY || below.0 >= -error)
    }
}

/// Random numbers of [0, 1): a linear congruence modulo 2^64 (Knuth, MMIX).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
    fn below(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }
    /// A point and an interval around it, a single number in one case of three.
    fn around(&mut self) -> (Twice, Interval) {
        let x = self.between(-4.0, 4.0);
        let width = if self.below(3) == 0 { 0.0 } else { 10f64.powf(self.between(-17.0, 0.5)) };
        let (low, high) = (x - width * self.next(), x + width * self.next());
        (Twice(x, 0.0), Interval::new(low, high).unwrap())
    }
}

#[test]
fn random_expressions_lie_in_their_intervals() {
    let mut random = Random(35);
    let (mut proper, mut narrow) = (0, 0);
    for case in 0..100_000 {
        let (mut truth, mut all) = random.around();
        // The error of the truth grows with each operation: a share of 1e-28 of the sizes that occur.
        let (mut size, mut slope) = (truth.0.abs(), 1.0f64);
        let mut steps = Vec::new();
        for _ in 0..1 + random.below(4) {
            let (y, other) = random.around();
            let kind = random.below(10);
            steps.push(kind);
            let before = (truth, all);
            (truth, all) = match kind {
                0 => (truth.plus(y), all + other),
                1 => (truth.plus(y.negative()), all - other),
                2 => (truth.times(y), all * other),
                3 if y.0.abs() > 0.1 => (truth.over(y), all / other),
                4 if truth.0 > 0.01 => (truth.sqrt(), all.sqrt()),
                5 if truth.0.abs() < 50.0 => (truth.exp(), all.exp()),
                6 if truth.0 > 0.01 => (truth.ln(), all.ln()),
                7 if truth.0.abs() < 100.0 => (truth.sin_cos()[0], all.sin()),
                8 if truth.0.abs() < 100.0 => (truth.sin_cos()[1], all.cos()),
                9 if truth.0 > 0.01 && truth.0 < 1e4 => {
                    let p = random.between(-2.5, 2.5);
                    (truth.ln().times(Twice(p, 0.0)).exp(), all.powf(p))
                }
                _ => (truth.negative(), -all),
            };
            // Each derivative is at most the size of the numbers before and after it, times 100.
            slope *= 100.0 * (1.0 + before.0.0.abs() + truth.0.abs());
            size = size.max(truth.0.abs());
            let error = 1e-30 * slope.max(1.0) * size.max(1.0);
            if error.is_nan() || error >= 1e-18 * truth.0.abs() {
                break; // the truth is no longer known
            }
            assert!(
                truth.lies_in(all, error),
                "case {case}, steps {steps:?}: {truth:?} in {all:?} after {before:?}, {other:?}"
            );
            proper += usize::from(all.is_bounded());
            narrow += usize::from(all.width() < 1e-12 * truth.0.abs());
        }
    }
    // The line contains everything: it must not be what most of them give.
    assert!(proper > 150_000 && narrow > 20_000, "{proper} bounded, {narrow} narrow");
}

/// x, and sin x as the sum of two numbers, computed with 60 digits.
#[rustfmt::skip]
const SINES: [[f64; 3]; 19] = [
    [1000.0, 0.8268795405320025, 3.867581909641312e-17],
    [12345.678, -0.7040813137533816, -1.9646969196301474e-17],
    [100000.0, 0.03574879797201651, 1.5429743706109861e-18],
    [355.0, -3.014435335948845e-05, 1.3012643991046347e-21],
    [710.0, 6.0288706691585265e-05, 9.53674283505903e-22],
    [103993.0, -1.9129335778423752e-05, 1.6616884502200222e-21],
    [104348.0, -1.1015017584240557e-05, 2.99559043518607e-22],
    [208341.0, 8.114318195038078e-06, -7.3906104855746145e-22],
    [312689.0, 2.900699389332111e-06, 1.4719966862867256e-22],
    [833719.0, 2.3129194164527015e-06, 4.340396870253451e-23],
    [1146408.0, -5.877799728813812e-07, -4.956144032542636e-23],
    [1600000.0, -0.5414010921983009, -2.274244574012984e-17],
    [-99999.5, -0.5104916150747798, -1.0492647623186778e-17],
    [-1000000.0, 0.34999350217129294, 1.5952848809323968e-17],
    [-833719.0, -2.3129194164527015e-06, -4.340396870253451e-23],
    [786432.0, -0.24994119361832048, 9.761409038099527e-18],
    [1500000.1, 0.4226308933978648, 9.023666605750153e-18],
    [22.0, -0.008851309290403876, 2.8485303089220057e-19],
    [411557.9874, 0.07492793596613609, 2.7739269848196213e-18],
];

#[test]
fn sines_of_large_angles_lie_in_their_intervals() {
    for [x, high, low] in SINES {
        let sin = Interval::from(x).sin();
        assert!(Twice(high, low).lies_in(sin, 0.0), "sin {x}: {sin:?}");
        // Roundings of the second part of the quarter turns, up to 2^20 6e-11 = 6e-5, remain near a zero.
        assert!(sin.width() < 4e-15 * high.abs() + 3e-20, "sin {x}: {sin:?}");
    }
    // sin² + cos² = 1 and the library function, whose error is below one unit of the last place.
    let mut random = Random(36);
    for _ in 0..10_000 {
        let x = random.between(-1.6e6, 1.6e6);
        let (sin, cos) = Interval::from(x).sin_cos();
        assert!((sin * sin + cos * cos).contains(1.0), "{x}: {sin:?}, {cos:?}");
        let near = Interval::around(Scalar::sin(x), 2e-16).unwrap();
        assert!(sin.common(near).is_some() && sin.width() < 4e-15, "{x}: {sin:?}");
    }
}

#[test]
fn ends_of_ranges_are_bounds() {
    // e^709.5 = 1.35498...e308 is a finite number below the largest f64.
    let large = Interval::from(709.5).exp();
    assert!(large.contains(1.354_986_319_314_632_7e308), "{large:?}");
    assert!(Interval::from(-720.0).exp().contains(0.0) && Interval::from(-720.0).exp().high() <= 1e-300);
    assert_eq!(
        Interval::from(f64::MAX) * Interval::from(2.0),
        Interval::new(f64::MAX, f64::INFINITY).unwrap()
    );
    assert!((Interval::LINE * Interval::from(0.0)).contains(1e300));
    assert_eq!(Interval::from(1.0) / Interval::new(-1.0, 1.0).unwrap(), Interval::LINE);
    assert_eq!(Interval::new(-1e-9, 1.0).unwrap().sqrt(), Interval::LINE);
    let least = Interval::from(5e-324);
    assert!(least.contains(least.middle()));
    assert!((least * least).contains(0.0) && (least * least).high() > 0.0);
}

/// Coefficients of (1 + t)^p: the binomials p (p - 1) .. (p - k + 1)/k!.
#[test]
fn weights_of_powers_are_rounded_outwards() {
    for p in [0.1, 0.3, 1.1, 1.3, 1.7, 2.3] {
        let series = PowerSeries::variable(Interval::from(1.0), Interval::from(1.0), 12).powf(p);
        let mut truth = Twice(1.0, 0.0);
        for (k, coefficient) in series.coefficients().iter().enumerate() {
            assert!(truth.lies_in(*coefficient, 1e-28), "p = {p}, {k}: {truth:?} in {coefficient:?}");
            let next = Twice::sum(p, -(k as f64));
            truth = truth.times(next).over(Twice(k as f64 + 1.0, 0.0));
        }
    }
}

/// Two polynomials with a jump between them.
fn pieces() -> Piecewise {
    let course =
        |middle: f64, x: f64| Ok::<_, ParameterError>(if middle < 2.0 { x.cos() } else { 1.0 + x.sin() });
    Piecewise::fit(&[0.5, 2.0], 1e-12, course).unwrap()
}

/// Points within a stretch of an angle: the series at a point lies in the enclosure over the stretch.
#[test]
fn waves_lie_in_their_enclosures() {
    let fourier = || Wave::new(Fourier::new(1.0, &[[0.3, -0.2], [0.0, 0.0], [0.1, 0.05]]).unwrap());
    let rectangle = || Wave::new(RectangularWave::new(0.8, 1.2, 0.4).unwrap());
    let centre = InstantCentre::new(0.3).unwrap();
    let waves = [
        fourier().per_turn(3).unwrap().with_phase(1.1).unwrap(),
        rectangle().per_turn(2).unwrap().with_phase(0.7).unwrap(),
        Wave::new(Product::new(vec![fourier(), rectangle(), fourier().with_phase(2.0).unwrap()])),
        Wave::new(Sum::new(vec![fourier(), Wave::new(Constant::new(0.4).unwrap()), rectangle()])),
        Wave::new(Scaled::new(-2.5, fourier()).unwrap()),
        Wave::new(centre.radius(1.7).unwrap()).per_turn(2).unwrap(),
        Wave::new(centre.ratio(3.5).unwrap()),
        Wave::new(centre.rotation()).with_phase(4.0).unwrap(),
        Wave::new(centre.rotation_series(12).unwrap()),
        Wave::new(ToothLoss::new(5, 2, 0.4).unwrap().shape(LossShape::Cosine)).with_phase(0.3).unwrap(),
        Wave::new(pieces()).per_turn(2).unwrap(),
    ];
    let mut random = Random(37);
    const ORDER: usize = 8;
    for (i, wave) in waves.iter().enumerate() {
        let mut checked = 0;
        for _ in 0..150 {
            let (start, width) = (random.between(-20.0, 20.0), random.between(1e-4, 0.05));
            if wave.next_edge(start).is_some_and(|edge| edge < start + width + 1e-9) {
                continue;
            }
            let speed = random.between(0.5, 3.0);
            let (inside, stretch) = (start + 0.5 * width, Interval::new(start, start + width).unwrap());
            let all =
                wave.jet(EnclosedAngle::new(stretch, Interval::from(speed), inside, ORDER), Side::After);
            let point = start + width * random.next();
            let series = wave.jet(PowerSeries::<f64>::variable(point, speed, ORDER), Side::After);
            let jet = wave.jet(point, Side::After);
            let value =
                wave.value(EnclosedAngle::new(stretch, Interval::from(speed), inside, ORDER), Side::After);
            for (plain, all) in [
                (jet.value, all.value),
                (jet.rate, all.rate),
                (jet.second, all.second),
                (wave.value(point, Side::After), value),
            ] {
                // Rounding of the plain number, whose terms may be larger than their sum.
                let near = Interval::around(plain, 1e-13 * (1.0 + plain.abs())).unwrap();
                assert!(
                    all.at(Interval::from(0.0)).common(near).is_some(),
                    "wave {i} at {point}: {plain} in {all:?}"
                );
            }
            for (all, plain) in
                [(all.value, series.value), (all.rate, series.rate), (all.second, series.second)]
            {
                for (k, c) in plain.coefficients().iter().enumerate() {
                    let own = all.coefficients().get(k).copied().unwrap_or(Interval::from(0.0));
                    let near = Interval::around(*c, 1e-12 * (1.0 + c.abs())).unwrap();
                    assert!(
                        own.common(near).is_some(),
                        "wave {i} at {point}, coefficient {k}: {c} in {own:?}"
                    );
                }
            }
            checked += 1;
        }
        assert!(checked > 100, "wave {i}: {checked} stretches");
    }
}

/// r = 1 + 2 ε/(1 + ε²) cos x with its constants rounded outwards: at x = 0 it is (1 + ε)²/(1 + ε²).
#[test]
fn constants_of_an_instantaneous_centre_are_rounded_outwards() {
    for eps in [0.1, 0.2, 0.3, 0.7, 0.77, 0.9] {
        let centre = InstantCentre::new(eps).unwrap();
        let angle = EnclosedAngle::new(Interval::from(0.0), Interval::from(1.0), 0.01, 4);
        let [one, eps] = [Twice(1.0, 0.0), Twice(eps, 0.0)];
        let square = one.plus(eps.times(eps));
        let sum = one.plus(eps).times(one.plus(eps));
        let rest = one.plus(eps.times(eps).negative());
        for (curve, truth) in [
            (centre.radius(1.0).unwrap(), sum.over(square)),
            (centre.ratio(1.0).unwrap(), sum.over(rest)),
            (centre.rotation(), rest.over(sum)),
        ] {
            let value = Wave::new(curve).value(angle, Side::After).coefficients()[0];
            assert!(truth.lies_in(value, 1e-29) && value.width() < 1e-13, "{truth:?} in {value:?}");
        }
    }
}
