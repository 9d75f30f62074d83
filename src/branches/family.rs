//! Families of models over one or several parameters.

use crate::error::{ParameterError, check};
use crate::model::equations::Constants;
use crate::model::{Channel, Model, Periodic};
use std::fmt;
use std::sync::Arc;

/// A family of models over N parameters: one for a branch p, two for a boundary (p, λ).
///
/// [`over`](Family::over) varies named constants of a model; [`of`](Family::of) makes the models by a
/// closure.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, Periodic, branches::Family};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let family = Family::over(&pair, ["speed"])?;
/// assert_eq!(family.parameters()[0].to_string(), "speed [rad/s]");
/// assert_eq!(family.at([200.0])?.period(), 0.5 * pair.period());
/// let plane = Family::over(&pair, ["speed", "load torque"])?;
/// assert_eq!(plane.at([200.0, 20.0])?.period(), 0.5 * pair.period());
/// let error = Family::over(&pair, ["speed", "lod"]).err().ok_or("an error")?;
/// assert!(error.to_string().starts_with("no constant \"lod\""));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Family<'m, const N: usize = 1> {
    pub(crate) parameters: [Channel; N],
    /// Indices of the parameters among the named constants of every model, if the derivatives of orbits with
    /// respect to them are exact.
    pub(crate) constants: Option<[usize; N]>,
    pub(crate) models: Arc<dyn Models<N> + 'm>,
}

/// The models of a family.
pub(crate) trait Models<const N: usize>: Send + Sync {
    fn at(&self, values: [f64; N]) -> Result<Box<dyn Periodic + '_>, ParameterError>;
}

impl<'m, const N: usize> Family<'m, N> {
    /// The family of `model` over the constants of these names.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchConstant`], which lists the constants; a model without named constants has
    /// none. [`ParameterError::Twice`] for the same constant twice.
    pub fn over(model: &'m dyn Model, names: [&str; N]) -> Result<Self, ParameterError> {
        let mut indices = [0; N];
        let mut constants: Option<&dyn Constants> = None;
        for (k, name) in names.into_iter().enumerate() {
            let known = model.offers().named()?;
            indices[k] = known.index(name)?;
            if indices[..k].contains(&indices[k]) {
                return Err(ParameterError::Twice { name: name.into() });
            }
            constants = Some(known);
        }
        let none = || ParameterError::Empty { name: "parameters of the family".into(), min: 1 };
        let constants = constants.ok_or_else(none)?;
        let parameters = indices.map(|index| constants.names()[index].clone());
        Ok(Family {
            parameters,
            constants: Some(indices),
            models: Arc::new(OfConstants { constants, indices }),
        })
    }

    /// The family of the models that `make` returns for the values of the parameters, with names and units of
    /// these.
    ///
    /// Derivatives with respect to the parameters are computed by differences. They affect the number of
    /// corrections, not the points that are found.
    ///
    /// ```
    /// use gear_dynamics::{Model, NfgPair, NfgParams, branches::Family};
    /// let family = Family::of([("speed", "rad/s")], |[speed]| {
    ///     NfgPair::new(&NfgParams { speed, ..NfgParams::table1() })
    /// });
    /// assert_eq!(family.at([100.0])?.dof(), 1);
    /// assert!(family.at([f64::NAN]).err().ok_or("an error")?.to_string().starts_with("speed"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of<M: Periodic + 'static>(
        parameters: [(&str, &str); N],
        make: impl Fn([f64; N]) -> Result<M, ParameterError> + Send + Sync + 'm,
    ) -> Self {
        let parameters = parameters.map(|(name, unit)| Channel::new(name, unit));
        Family { parameters, constants: None, models: Arc::new(OfFunction(make)) }
    }

    /// Names and units of the parameters.
    pub fn parameters(&self) -> &[Channel; N] {
        &self.parameters
    }

    /// The model with these values of the parameters.
    ///
    /// # Errors
    /// Values for which there is no model.
    pub fn at(&self, values: [f64; N]) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        for (parameter, value) in self.parameters.iter().zip(values) {
            check::finite(parameter.name.as_str(), value)?;
        }
        self.models.at(values)
    }
}

impl<const N: usize> fmt::Debug for Family<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.parameters.each_ref().map(Channel::to_string);
        f.debug_struct("Family").field("parameters", &names).finish_non_exhaustive()
    }
}

/// A model with other values of some constants.
struct OfConstants<'m, const N: usize> {
    constants: &'m dyn Constants,
    indices: [usize; N],
}

impl<const N: usize> Models<N> for OfConstants<'_, N> {
    fn at(&self, values: [f64; N]) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        let mut indices = [(0, 0.0); N];
        indices.iter_mut().zip(self.indices.into_iter().zip(values)).for_each(|(to, value)| *to = value);
        self.constants.with_values(&indices)
    }
}

/// The models of a closure.
struct OfFunction<F>(F);

impl<M, F, const N: usize> Models<N> for OfFunction<F>
where
    M: Periodic + 'static,
    F: Fn([f64; N]) -> Result<M, ParameterError> + Send + Sync,
{
    fn at(&self, values: [f64; N]) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        Ok(Box::new((self.0)(values)?))
    }
}
