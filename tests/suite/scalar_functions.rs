//! Powers, exponentials and sines of every `Scalar`: closed forms, derivatives against differences, lanes
//! against plain numbers.

use crate::api::*;
use approx::assert_relative_eq;

/// A function that is written once for every `Scalar`.
trait Function {
    fn of<S: Scalar>(&self, x: S) -> S;
}

struct Power(f64);
struct Exp;
struct Ln;
struct Sin;
struct Cos;
/// All functions together: ln(1 + x²) e^(-x/3) + sin(2 x) cos x / x^2.5.
struct Mixed;

impl Function for Power {
    fn of<S: Scalar>(&self, x: S) -> S {
        x.powf(self.0)
    }
}
impl Function for Exp {
    fn of<S: Scalar>(&self, x: S) -> S {
        x.exp()
    }
}
impl Function for Ln {
    fn of<S: Scalar>(&self, x: S) -> S {
        x.ln()
    }
}
impl Function for Sin {
    fn of<S: Scalar>(&self, x: S) -> S {
        x.sin()
    }
}
impl Function for Cos {
    fn of<S: Scalar>(&self, x: S) -> S {
        x.cos()
    }
}
impl Function for Mixed {
    fn of<S: Scalar>(&self, x: S) -> S {
        (x * x + S::from(1.0)).ln() * (x * (-1.0 / 3.0)).exp()
            + (x * 2.0).sin_cos().0 * x.sin_cos().1 / x.powf(2.5)
    }
}

const PLACES: [f64; 8] = [0.03, 0.4, 0.9, 1.0, 1.7, 3.0, 12.5, 170.25];

/// Checks the slope of dual numbers against central differences (Richardson extrapolation) and the closed
/// form, and the bits of lanes of several widths.
fn holds(f: &impl Function, slope: impl Fn(f64) -> f64) {
    for x in PLACES {
        let dual = f.of(Dual::variable(x));
        assert_eq!(dual.value.to_bits(), f.of(x).to_bits());
        assert_relative_eq!(dual.slope[0], slope(x), max_relative = 1e-13, epsilon = 1e-15);
        let difference = |h: f64| (f.of(x + h) - f.of(x - h)) / (2.0 * h);
        let h = 1e-3 * x.min(1.0);
        let size = f.of(x).abs().max(slope(x).abs());
        assert_relative_eq!(
            dual.slope[0],
            (4.0 * difference(0.5 * h) - difference(h)) / 3.0,
            epsilon = 1e-9 * size
        );
        let along = f.of(Dual { value: x, slope: [2.0, 0.0, -1.0] });
        assert_eq!(along.slope, [2.0 * dual.slope[0], 0.0, -dual.slope[0]]);
    }
    lanes_are_plain::<1>(f);
    lanes_are_plain::<5>(f);
    lanes_are_plain::<8>(f);
    lanes_are_plain::<16>(f);
}

fn lanes_are_plain<const W: usize>(f: &impl Function) {
    let x: [f64; W] = std::array::from_fn(|i| PLACES[i % 8] * (1.0 + 0.01 * i as f64));
    assert_eq!(f.of(Lanes(x)).0.map(f64::to_bits), x.map(|x| f.of(x).to_bits()));
}

#[test]
fn functions_and_their_slopes() {
    for p in [-1.5, -1.0, 0.0, 0.5, 1.0, 10.0 / 9.0, 1.5, 2.0, 3.7] {
        holds(&Power(p), |x| p * x.powf(p - 1.0));
    }
    holds(&Exp, f64::exp);
    holds(&Ln, |x| 1.0 / x);
    holds(&Sin, f64::cos);
    holds(&Cos, |x| -x.sin());
    holds(&Mixed, |x| {
        let (growth, decay) = ((x * x + 1.0).ln(), (-x / 3.0).exp());
        let wave =
            2.0 * (2.0 * x).cos() * x.cos() - (2.0 * x).sin() * x.sin() - 2.5 * (2.0 * x).sin() * x.cos() / x;
        (2.0 * x / (x * x + 1.0) - growth / 3.0) * decay + wave / x.powf(2.5)
    });
}

#[test]
fn values_in_closed_form() {
    // Through a function pointer, since a method call on f64 would resolve to the inherent method of f64.
    let of = |f: fn(f64) -> f64, x: f64| f(x);
    assert_eq!(of(|x| Scalar::powf(x, 1.5), 4.0), 8.0);
    assert_eq!(of(Scalar::exp, 0.0), 1.0);
    assert_eq!(of(Scalar::ln, 1.0), 0.0);
    assert_eq!(of(Scalar::sin, 0.0), 0.0);
    assert_eq!(of(Scalar::cos, 0.0), 1.0);
    assert_relative_eq!(of(Scalar::exp, 1.0), std::f64::consts::E, max_relative = 2e-16);
    assert_relative_eq!(of(Scalar::ln, 10.0), std::f64::consts::LN_10, max_relative = 2e-16);
    assert_relative_eq!(of(Scalar::sin, std::f64::consts::FRAC_PI_6), 0.5, max_relative = 3e-16);
    for x in PLACES {
        let (sin, cos) = Scalar::sin_cos(x);
        assert_eq!(
            [sin.to_bits(), cos.to_bits()],
            [of(Scalar::sin, x).to_bits(), of(Scalar::cos, x).to_bits()]
        );
    }
}

#[test]
fn slopes_at_zero_are_numbers() {
    let at_zero = |p: f64| Dual::variable(0.0).powf(p);
    for (p, slope) in [(0.0, 0.0), (1.0, 1.0), (10.0 / 9.0, 0.0), (1.5, 0.0), (2.0, 0.0), (3.0, 0.0)] {
        assert_eq!(at_zero(p).slope, [slope], "{p}");
        // A constant 0 has the slope 0.
        assert_eq!(Dual::<1>::from(0.0).powf(p).slope, [0.0]);
    }
    assert_eq!((at_zero(0.0).value, at_zero(0.5).value), (1.0, 0.0));
    assert!(at_zero(0.5).slope[0] > 1e70 && at_zero(0.5).slope[0].is_finite());
    assert_eq!((Dual::variable(0.0) * Dual::variable(0.0).powf(0.5)).slope, [0.0]);
    assert!(Dual::variable(0.0).ln().slope[0].is_finite());
    assert_eq!(Dual::<1>::from(0.0).ln().slope, [0.0]);
    assert_eq!(Dual::variable(-2.0).powf(3.0), Dual { value: -8.0, slope: [12.0] });
}
