//! Newton's method within a bracket.

/// Maximum number of steps of [`Bracket::solve`].
const MAX_STEPS: usize = 200;

/// Number of bisections after which a bracket is as short as rounding allows.
const BISECTIONS: usize = 60;

/// Two rounding errors of x: the usual end of [`Bracket::solve`].
#[inline]
pub(crate) fn rounding(x: f64) -> f64 {
    2.0 * f64::EPSILON * x.abs()
}

/// An interval that contains a root: the root lies between `lo` and `hi`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bracket {
    pub(crate) lo: f64,
    pub(crate) hi: f64,
}

impl Bracket {
    /// Moves one end to `x`: the lower end if the root lies above `x`.
    #[inline]
    pub(crate) fn narrow(&mut self, x: f64, root_above: bool) {
        if root_above { self.lo = x } else { self.hi = x }
    }

    /// x - f/f', if it lies inside the bracket.
    #[inline]
    pub(crate) fn newton(&self, x: f64, f: f64, slope: f64) -> Option<f64> {
        let next = x - f / slope;
        (next > self.lo && next < self.hi).then_some(next)
    }

    /// x - f/f', or the middle of the bracket if that lies outside it.
    ///
    /// Repeated, with the bracket narrowed each time, the steps converge quadratically near a simple root.
    /// Far from the root, or near a multiple root, they may be slower than bisection.
    ///
    /// Source: after Press et al., Numerical Recipes, 3rd ed., Sect. 9.4 (`rtsafe`), without its second test,
    /// which also bisects if |f| decreases too slowly.
    #[inline]
    pub(crate) fn newton_or_middle(&self, x: f64, f: f64, slope: f64) -> f64 {
        self.newton(x, f, slope).unwrap_or(self.middle())
    }

    /// The root of a function from a guess inside the bracket.
    ///
    /// `f` returns value and slope; the value is positive above the root if `rises`, otherwise below it. The
    /// iteration ends at a value of 0, or after a step of at most `close(x)` to x.
    #[inline]
    pub(crate) fn solve(
        mut self,
        guess: f64,
        rises: bool,
        close: impl Fn(f64) -> f64,
        mut f: impl FnMut(f64) -> (f64, f64),
    ) -> f64 {
        let mut x = guess;
        for _ in 0..MAX_STEPS {
            let (value, slope) = f(x);
            if value == 0.0 {
                break;
            }
            self.narrow(x, (value < 0.0) == rises);
            let next = self.newton_or_middle(x, value, slope);
            let step = (next - x).abs();
            x = next;
            if step <= close(x) {
                break;
            }
        }
        x
    }

    /// The bracket after bisections, until it is shorter than `close` or as short as rounding allows.
    /// `above`: whether the root lies above x.
    pub(crate) fn bisect(mut self, close: f64, mut above: impl FnMut(f64) -> bool) -> Self {
        for _ in 0..BISECTIONS {
            let x = self.middle();
            self.narrow(x, above(x));
            if self.hi - self.lo < close {
                break;
            }
        }
        self
    }

    #[inline]
    pub(crate) fn middle(&self) -> f64 {
        0.5 * (self.lo + self.hi)
    }
}

#[cfg(test)]
mod tests {
    use super::{Bracket, rounding};

    /// f = x³ - 2 x - 5, the example of Wallis (1685), and atan, for which Newton's method alone diverges
    /// from 2.
    #[test]
    fn iterates_stay_inside_and_converge() {
        type WithSlope = fn(f64) -> (f64, f64);
        let cubic: WithSlope = |x| (x * x * x - 2.0 * x - 5.0, 3.0 * x * x - 2.0);
        let atan: WithSlope = |x| (x.atan(), 1.0 / (1.0 + x * x));
        for (f, lo, hi, root) in [(cubic, 0.0, 10.0, 2.094_551_481_542_326_5), (atan, -3.0, 7.0, 0.0)] {
            let inside = |x: f64| {
                assert!(x >= lo && x <= hi);
                f(x)
            };
            let x = Bracket { lo, hi }.solve(2.0, true, rounding, inside);
            assert!((x - root).abs() < 1e-15, "{x} {root}");
            let falls = |x: f64| (-f(x).0, -f(x).1);
            assert_eq!(Bracket { lo, hi }.solve(2.0, false, rounding, falls), x);
            let Bracket { lo, hi } = Bracket { lo, hi }.bisect(1e-14, |x| f(x).0 < 0.0);
            assert!(lo <= x && x <= hi && hi - lo < 1e-14, "{lo} {x} {hi}");
        }
    }

    #[test]
    fn a_slope_of_zero_gives_the_middle() {
        let bracket = Bracket { lo: 1.0, hi: 3.0 };
        assert_eq!(bracket.newton(1.5, 1.0, 0.0), None);
        assert_eq!(bracket.newton_or_middle(1.5, 0.0, 0.0), 2.0);
    }
}
