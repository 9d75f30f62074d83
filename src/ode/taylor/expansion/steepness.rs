//! How steep the functions of a tape are along a motion.

use crate::ode::taylor::expansion::coefficients::Coefficients;
use crate::ode::taylor::expansion::functions::Function;
use crate::ode::taylor::expansion::rows::EIGHT;
use crate::steepness::{JETS, logarithm, steepness, steepness_of_product, steepness_of_sine};

impl Coefficients {
    /// The largest [`steepness`] of the active functions, from their arguments of the first orders `[1/s]`. A
    /// sine counts if there is a product of high degree, whose factor it may be. Elsewhere its coefficients
    /// are as large as those of its argument.
    pub(crate) fn steepness(&self) -> f64 {
        let (x, stride) = (self.x.as_flattened(), EIGHT * self.plan.width);
        let jets = |column: u32| -> [f64; JETS] { std::array::from_fn(|n| x[n * stride + column as usize]) };
        let is_high = !self.plan.high_products.is_empty();
        let power = |column: u32, p: f64| logarithm(jets(column)).map(|w| p * w);
        let all = self.plan.functions().map(|function| match function.function {
            Function::Exp(a) => steepness(jets(a)),
            Function::Quotient(_, b) => steepness(power(b, 1.0)),
            Function::Ln(a) => steepness(power(a, 1.0)),
            Function::Sqrt(a) => steepness(power(a, 0.5)),
            Function::Power(a, p, _) => steepness(power(a, p)),
            Function::SinCos(a) if is_high => steepness_of_sine(jets(a)),
            Function::SinCos(_) => 0.0,
        });
        let products = self.plan.high_products.iter().map(|&column| steepness_of_product(jets(column)));
        all.chain(products).fold(0.0, f64::max)
    }

    /// Whether the last coefficients of a sum that varies with the time alone do not show it. Few never do.
    #[inline]
    pub(crate) fn hides_a_sum(&self) -> bool {
        let (x, stride, degree) = (self.x.as_flattened(), EIGHT * self.plan.width, self.degree);
        let at = |column: u32, n: usize| x[n * stride + column as usize];
        let mut sums = self.plan.time_sums.iter();
        sums.any(|sum| degree <= JETS + 1 || sum.hides(degree - 1, at))
    }

    /// The largest steepness of the sums that vary with the time alone, from [`JETS`] + 1 orders `[1/s]`.
    pub(crate) fn steepness_of_sums(&self) -> f64 {
        let (x, stride) = (self.x.as_flattened(), EIGHT * self.plan.width);
        let at = |column: u32, n: usize| x[n * stride + column as usize];
        self.plan.time_sums.iter().map(|sum| sum.steepness(at)).fold(0.0, f64::max)
    }

    /// Whether a product of high degree is 0, so that its coefficients say nothing of what comes.
    pub(crate) fn has_unknown_product(&self) -> bool {
        let values = self.x.as_flattened();
        self.plan.high_products.iter().any(|&column| values[column as usize] == 0.0)
    }
}
