//! Excitations composed of waves, and excitations given by closures.

use crate::error::{ParameterError, check};
use crate::excitation::enclosed_angle::EnclosedAngle;
use crate::excitation::excitation_trait::{Excitation, same};
use crate::excitation::functions::fourier::Fourier;
use crate::excitation::jet::Jet;
use crate::excitation::side::Side;
use crate::excitation::wave::Wave;
use crate::interval::number::Interval;
use crate::series::{PowerSeries, Series};
use std::fmt;

/// The sum f(φ) + g(φ) + ... of waves.
///
/// ```
/// use gear_dynamics::{excitation::{Excitation, Fourier, Sum}, Wave};
/// let cosine = Wave::new(Fourier::new(0.0, &[[2.0, 0.0]])?).per_turn(3)?;
/// let sum = Sum::new(vec![Wave::constant(1.0)?, cosine]); // 1 + 2 cos 3 φ
/// assert_eq!(sum.jet(0.0).value, 3.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Sum {
    terms: Vec<Wave>,
    /// The sum as a Fourier series, if its terms have finite ones.
    expanded: Option<Fourier>,
}

impl Sum {
    /// The sum of these terms; 0 if there are none.
    pub fn new(terms: Vec<Wave>) -> Self {
        let zero = Fourier::new(0.0, &[]).ok();
        let expanded = terms.iter().fold(zero, |sum, term| sum?.plus(&term.fourier()?));
        Sum { terms, expanded }
    }
}

/// Whether an angle grows at a constant speed: the expanded series is then faster than its parts.
fn turns_evenly(angle: &Series) -> bool {
    angle.coefficients().len() <= 2
}

/// Edges of all parts.
fn edges(parts: &[Wave]) -> Vec<f64> {
    parts.iter().flat_map(Wave::edges_of_a_turn).collect()
}

impl Excitation for Sum {
    fn jet(&self, angle: f64) -> Jet {
        self.terms.iter().fold(Jet::constant(0.0), |sum, f| sum + f.jet(angle, Side::After))
    }
    fn series(&self, angle: &Series) -> Jet<Series> {
        match &self.expanded {
            Some(expanded) if turns_evenly(angle) => expanded.series(angle),
            _ => {
                let zero = Jet::constant(0.0.into());
                self.terms.iter().fold(zero, |sum, f| sum + f.jet(*angle, Side::After))
            }
        }
    }
    fn enclosure(&self, angle: EnclosedAngle) -> Jet<PowerSeries<Interval>> {
        let zero = Jet::constant(0.0.into());
        self.terms.iter().fold(zero, |sum, f| sum + f.jet(angle, Side::After))
    }
    fn value_series(&self, angle: &Series) -> Series {
        match &self.expanded {
            Some(expanded) if turns_evenly(angle) => expanded.value_series(angle),
            _ => self.terms.iter().fold(0.0.into(), |sum, f| sum + f.value(*angle, Side::After)),
        }
    }
    fn fourier(&self) -> Option<(f64, Vec<[f64; 2]>)> {
        self.expanded.as_ref()?.fourier()
    }
    fn edges(&self) -> Vec<f64> {
        edges(&self.terms)
    }
    fn same_as(&self, other: &dyn Excitation) -> bool {
        same(self, other)
    }
}

/// The product f(φ) g(φ) ... of waves.
///
/// ```
/// use gear_dynamics::{excitation::{Excitation, Fourier, Product}, Wave};
/// let product = Product::new(vec![Wave::constant(5.0)?, Wave::new(Fourier::new(0.0, &[[0.0, 2.0]])?)]);
/// assert_eq!(product.jet(0.0).rate, 10.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Product {
    factors: Vec<Wave>,
    /// The product as a Fourier series, if its factors have finite ones.
    expanded: Option<Fourier>,
}

impl Product {
    /// The product of these factors; 1 if there are none.
    pub fn new(factors: Vec<Wave>) -> Self {
        let one = Fourier::new(1.0, &[]).ok();
        let expanded = factors.iter().fold(one, |product, factor| product?.times(&factor.fourier()?));
        Product { factors, expanded }
    }
}

impl Excitation for Product {
    fn jet(&self, angle: f64) -> Jet {
        self.factors.iter().fold(Jet::constant(1.0), |product, f| product * f.jet(angle, Side::After))
    }
    fn series(&self, angle: &Series) -> Jet<Series> {
        match &self.expanded {
            Some(expanded) if turns_evenly(angle) => expanded.series(angle),
            _ => {
                let one = Jet::constant(1.0.into());
                self.factors.iter().fold(one, |product, f| product * f.jet(*angle, Side::After))
            }
        }
    }
    fn enclosure(&self, angle: EnclosedAngle) -> Jet<PowerSeries<Interval>> {
        let one = Jet::constant(1.0.into());
        self.factors.iter().fold(one, |product, f| product * f.jet(angle, Side::After))
    }
    fn value_series(&self, angle: &Series) -> Series {
        match &self.expanded {
            Some(expanded) if turns_evenly(angle) => expanded.value_series(angle),
            _ => self.factors.iter().fold(1.0.into(), |product, f| product * f.value(*angle, Side::After)),
        }
    }
    fn fourier(&self) -> Option<(f64, Vec<[f64; 2]>)> {
        self.expanded.as_ref()?.fourier()
    }
    fn edges(&self) -> Vec<f64> {
        edges(&self.factors)
    }
    fn same_as(&self, other: &dyn Excitation) -> bool {
        same(self, other)
    }
}

/// The quotient f(φ)/g(φ) of two waves, of which g is nowhere 0.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Quotient(pub(crate) [Wave; 2]);

impl Excitation for Quotient {
    fn jet(&self, angle: f64) -> Jet {
        let [f, g] = self.0.each_ref().map(|wave| wave.jet(angle, Side::After));
        f / g
    }
    fn series(&self, angle: &Series) -> Jet<Series> {
        let [f, g] = self.0.each_ref().map(|wave| wave.jet(*angle, Side::After));
        f / g
    }
    fn enclosure(&self, angle: EnclosedAngle) -> Jet<PowerSeries<Interval>> {
        let [f, g] = self.0.each_ref().map(|wave| wave.jet(angle, Side::After));
        f / g
    }
    fn edges(&self) -> Vec<f64> {
        edges(&self.0)
    }
    fn same_as(&self, other: &dyn Excitation) -> bool {
        same(self, other)
    }
}

/// A wave f(φ) multiplied by a factor a: a f(φ).
///
/// ```
/// use gear_dynamics::{excitation::{Excitation, Scaled}, Wave};
/// assert_eq!(Scaled::new(2.0, Wave::constant(1.5)?)?.value(0.0), 3.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Scaled {
    factor: f64,
    inner: Wave,
}

impl Scaled {
    /// A factor within ±1e50 and the wave that it multiplies.
    ///
    /// # Errors
    /// A factor beyond ±1e50.
    pub fn new(factor: f64, inner: Wave) -> Result<Self, ParameterError> {
        Ok(Scaled { factor: check::quantity("factor", factor)?, inner })
    }
}

impl Excitation for Scaled {
    fn jet(&self, angle: f64) -> Jet {
        self.inner.jet(angle, Side::After) * self.factor
    }
    fn series(&self, angle: &Series) -> Jet<Series> {
        self.inner.jet(*angle, Side::After) * self.factor
    }
    fn enclosure(&self, angle: EnclosedAngle) -> Jet<PowerSeries<Interval>> {
        self.inner.jet(angle, Side::After) * self.factor
    }
    fn value_series(&self, angle: &Series) -> Series {
        self.inner.value(*angle, Side::After) * self.factor
    }
    fn fourier(&self) -> Option<(f64, Vec<[f64; 2]>)> {
        Fourier::new(self.factor, &[]).ok()?.times(&self.inner.fourier()?)?.fourier()
    }
    fn edges(&self) -> Vec<f64> {
        self.inner.edges_of_a_turn()
    }
    fn same_as(&self, other: &dyn Excitation) -> bool {
        same(self, other)
    }
}

/// An excitation given by a closure on [`Jet`]s of the angle. Its derivatives follow from the arithmetic of
/// the jets.
///
/// The closure should have the period 2π. Otherwise the excitation jumps at φ = 0, and 0 belongs to its
/// edges ([`with_edges`](Function::with_edges)).
///
/// ```
/// use gear_dynamics::excitation::{Excitation, Function, Jet};
/// let bump = Function::new(|angle: Jet| (angle.cos() * 2.0).exp());
/// assert_eq!(bump.jet(0.0).rate, 0.0);
/// assert_eq!(bump.jet(0.0).value, 2f64.exp());
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub struct Function<F> {
    function: F,
    edges: Vec<f64>,
}

impl<F: Fn(Jet) -> Jet + Send + Sync + 'static> Function<F> {
    /// A smooth function.
    pub fn new(function: F) -> Self {
        Function { function, edges: Vec::new() }
    }

    /// The same function with the angles in [0, 2π) at which it jumps or has a kink.
    ///
    /// # Errors
    /// An angle outside [0, 2π).
    pub fn with_edges(self, angles: &[f64]) -> Result<Self, ParameterError> {
        for (i, &value) in angles.iter().enumerate() {
            if !(0.0..std::f64::consts::TAU).contains(&value) {
                return Err(ParameterError::OutOfRange {
                    name: format!("edges[{i}] of the function"),
                    value,
                    allowed: "[0, 2π)",
                });
            }
        }
        Ok(Function { edges: angles.to_vec(), ..self })
    }
}

impl<F> fmt::Debug for Function<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Function").field("edges", &self.edges).finish_non_exhaustive()
    }
}

impl<F: Fn(Jet) -> Jet + Send + Sync + 'static> Excitation for Function<F> {
    fn jet(&self, angle: f64) -> Jet {
        (self.function)(Jet::variable(angle))
    }
    fn series(&self, _: &Series) -> Jet<Series> {
        Jet::constant(Series::refused("a `Function`, which is a closure on jets"))
    }
    fn edges(&self) -> Vec<f64> {
        self.edges.clone()
    }
}
