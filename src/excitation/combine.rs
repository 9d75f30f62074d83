//! Excitations made of others.

use super::{Excitation, Jet, Repeats, Shared, earlier};
use crate::error::{ParameterError, check};
use crate::piece::Side;
use std::fmt;

/// f(t) + g(t) + ...
///
/// ```
/// use gear_dynamics::{Constant, Excitation, Fourier, Side, Sum, shared};
/// let sum = Sum::new(vec![shared(Constant::new(1.0)?), shared(Fourier::new(0.0, &[[2.0, 0.0]], 1.0)?)]);
/// assert_eq!(sum.value(0.0, Side::After), 3.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sum(Vec<Shared>);

impl Sum {
    /// The terms; none at all is zero.
    pub fn new(terms: Vec<Shared>) -> Self {
        Sum(terms)
    }
}

impl Excitation for Sum {
    fn jet(&self, t: f64, side: Side) -> Jet {
        self.0.iter().fold(Jet::constant(0.0), |sum, f| sum + f.jet(t, side))
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.0.iter().fold(None, |first, f| earlier(first, f.next_edge(t)))
    }
    fn repeats(&self) -> Repeats {
        self.0.iter().fold(Repeats::Always, |all, f| all.with(f.repeats()))
    }
}

/// f(t) g(t) ...
///
/// ```
/// use gear_dynamics::{Constant, Excitation, Fourier, Product, Side, shared};
/// let product = Product::new(vec![shared(Constant::new(5.0)?), shared(Fourier::new(0.0, &[[0.0, 1.0]], 2.0)?)]);
/// assert_eq!(product.rate(0.0, Side::After), 10.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Product(Vec<Shared>);

impl Product {
    /// The factors; none at all is one.
    pub fn new(factors: Vec<Shared>) -> Self {
        Product(factors)
    }
}

impl Excitation for Product {
    fn jet(&self, t: f64, side: Side) -> Jet {
        self.0.iter().fold(Jet::constant(1.0), |product, f| product * f.jet(t, side))
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.0.iter().fold(None, |first, f| earlier(first, f.next_edge(t)))
    }
    fn repeats(&self) -> Repeats {
        self.0.iter().fold(Repeats::Always, |all, f| all.with(f.repeats()))
    }
}

/// a f(t).
///
/// ```
/// use gear_dynamics::{Constant, Excitation, Scaled, Side, shared};
/// assert_eq!(Scaled::new(2.0, shared(Constant::new(1.5)?))?.value(0.0, Side::After), 3.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scaled {
    factor: f64,
    inner: Shared,
}

impl Scaled {
    /// A factor within ±1e50 and what it scales.
    ///
    /// # Errors
    /// A factor beyond ±1e50.
    pub fn new(factor: f64, inner: Shared) -> Result<Self, ParameterError> {
        Ok(Scaled { factor: check::quantity("factor", factor)?, inner })
    }
}

impl Excitation for Scaled {
    fn jet(&self, t: f64, side: Side) -> Jet {
        self.inner.jet(t, side) * self.factor
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.inner.next_edge(t)
    }
    fn repeats(&self) -> Repeats {
        self.inner.repeats()
    }
}

/// A closure on [`Jet`]s: derivatives come from its arithmetic.
///
/// ```
/// use gear_dynamics::{Excitation, Function, Jet, Side};
/// let ramp = Function::new(|t: Jet| t * t * 0.5);
/// assert_eq!(ramp.jet(3.0, Side::After), Jet::new(4.5, 3.0, 1.0));
/// ```
pub struct Function<F> {
    function: F,
    repeats: Repeats,
}

impl<F: Fn(Jet) -> Jet + Send + Sync> Function<F> {
    /// A smooth function that does not repeat.
    pub fn new(function: F) -> Self {
        Function { function, repeats: Repeats::Never }
    }

    /// The same, known to repeat with a period `[s]`.
    ///
    /// # Errors
    /// A period outside 1e-50 .. 1e50.
    pub fn with_period(self, period: f64) -> Result<Self, ParameterError> {
        Ok(Function { repeats: Repeats::Every(check::scale("period", period)?), ..self })
    }
}

impl<F> fmt::Debug for Function<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Function").field("repeats", &self.repeats).finish_non_exhaustive()
    }
}

impl<F: Fn(Jet) -> Jet + Send + Sync> Excitation for Function<F> {
    fn jet(&self, t: f64, _: Side) -> Jet {
        (self.function)(Jet::time(t))
    }
    fn repeats(&self) -> Repeats {
        self.repeats
    }
}
