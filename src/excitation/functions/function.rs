//! Excitations given by closures.

use crate::error::ParameterError;
use crate::excitation::angle::Angle;
use crate::excitation::excitation_trait::Excitation;
use crate::excitation::jet::Jet;
use std::fmt;

/// A function of the angle that a closure computes from a [`Jet`]. The arithmetic of the jets gives its
/// derivatives.
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

/// Two closures are never known to be equal. Copies of a wave share theirs.
impl<F> PartialEq for Function<F> {
    fn eq(&self, _: &Self) -> bool {
        false
    }
}

impl<F: Fn(Jet) -> Jet + Send + Sync + 'static> Excitation for Function<F> {
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
        let [value, rate, second] = angle.by_function(|angle| {
            let Jet { value, rate, second } = (self.function)(Jet::variable(angle));
            [value, rate, second]
        });
        Jet { value, rate, second }
    }
    fn edges(&self) -> Vec<f64> {
        self.edges.clone()
    }
}
