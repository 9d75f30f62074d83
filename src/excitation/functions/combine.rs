//! Excitations composed of waves.

use crate::error::{ParameterError, check};
use crate::excitation::angle::Angle;
use crate::excitation::excitation_trait::Excitation;
use crate::excitation::fourier::Fourier;
use crate::excitation::jet::Jet;
use crate::excitation::side::Side;
use crate::excitation::wave::Wave;

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

/// Edges of all parts.
fn edges(parts: &[Wave]) -> Vec<f64> {
    parts.iter().flat_map(Wave::edges_of_a_turn).collect()
}

/// Knots of all parts.
fn knots(parts: &[Wave]) -> Vec<f64> {
    parts.iter().flat_map(Wave::knots_of_a_turn).collect()
}

impl Excitation for Sum {
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
        match &self.expanded {
            Some(expanded) if angle.turns_evenly() => expanded.jet(angle),
            _ => {
                let first = Jet::constant(0.0.into());
                self.terms.iter().fold(first, |sum, f| sum + f.jet(angle, Side::After))
            }
        }
    }
    fn value<A: Angle>(&self, angle: A) -> A::Number {
        match &self.expanded {
            Some(expanded) if angle.turns_evenly() => expanded.value(angle),
            _ => self.terms.iter().fold(0.0.into(), |sum, f| sum + f.value(angle, Side::After)),
        }
    }
    fn fourier(&self) -> Option<(f64, Vec<[f64; 2]>)> {
        self.expanded.as_ref()?.fourier()
    }
    fn edges(&self) -> Vec<f64> {
        edges(&self.terms)
    }
    fn knots(&self) -> Vec<f64> {
        knots(&self.terms)
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
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
        match &self.expanded {
            Some(expanded) if angle.turns_evenly() => expanded.jet(angle),
            _ => {
                let first = Jet::constant(1.0.into());
                self.factors.iter().fold(first, |product, f| product * f.jet(angle, Side::After))
            }
        }
    }
    fn value<A: Angle>(&self, angle: A) -> A::Number {
        match &self.expanded {
            Some(expanded) if angle.turns_evenly() => expanded.value(angle),
            _ => self.factors.iter().fold(1.0.into(), |product, f| product * f.value(angle, Side::After)),
        }
    }
    fn fourier(&self) -> Option<(f64, Vec<[f64; 2]>)> {
        self.expanded.as_ref()?.fourier()
    }
    fn edges(&self) -> Vec<f64> {
        edges(&self.factors)
    }
    fn knots(&self) -> Vec<f64> {
        knots(&self.factors)
    }
}

/// The quotient f(φ)/g(φ) of two waves, of which g is nowhere 0.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Quotient(pub(crate) [Wave; 2]);

impl Excitation for Quotient {
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
        let [f, g] = self.0.each_ref().map(|wave| wave.jet(angle, Side::After));
        f / g
    }
    fn edges(&self) -> Vec<f64> {
        edges(&self.0)
    }
    fn knots(&self) -> Vec<f64> {
        knots(&self.0)
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
    /// Multiplies the wave `inner` by a factor within ±1e50.
    ///
    /// # Errors
    /// A factor beyond ±1e50.
    pub fn new(factor: f64, inner: Wave) -> Result<Self, ParameterError> {
        Ok(Scaled { factor: check::quantity("factor", factor)?, inner })
    }
}

impl Excitation for Scaled {
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
        self.inner.jet(angle, Side::After) * self.factor
    }
    fn value<A: Angle>(&self, angle: A) -> A::Number {
        self.inner.value(angle, Side::After) * self.factor
    }
    fn fourier(&self) -> Option<(f64, Vec<[f64; 2]>)> {
        Fourier::new(self.factor, &[]).ok()?.times(&self.inner.fourier()?)?.fourier()
    }
    fn edges(&self) -> Vec<f64> {
        self.inner.edges_of_a_turn()
    }
    fn knots(&self) -> Vec<f64> {
        self.inner.knots_of_a_turn()
    }
}
