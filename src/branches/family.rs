//! Families of models over one parameter.

use crate::error::{ParameterError, check};
use crate::model::equations::Constants;
use crate::model::{Channel, Model, Periodic};

/// A family of models over one parameter p, along which orbits are continued.
///
/// [`ByConstant`] varies a named constant of a model; [`ByFunction`] makes the models by a closure.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, branches::{ByConstant, Family}};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let family = ByConstant::new(&pair, "speed")?;
/// assert_eq!(family.parameter().to_string(), "speed [rad/s]");
/// assert_eq!(family.at(200.0)?.period(), 0.5 * family.at(100.0)?.period());
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub trait Family {
    /// Name and unit of the parameter.
    fn parameter(&self) -> Channel;
    /// The model with the parameter `value`.
    ///
    /// # Errors
    /// A value for which there is no model.
    fn at(&self, value: f64) -> Result<Box<dyn Periodic + '_>, ParameterError>;
    /// Index of the parameter among the [named constants](crate::model::Offers::constants) of every model of the
    /// family. The derivative of an orbit with respect to it is then exact; otherwise it is computed by
    /// differences. Default: `None`.
    fn constant(&self) -> Option<usize> {
        None
    }
}

impl<F: Family + ?Sized> Family for &F {
    fn parameter(&self) -> Channel {
        (**self).parameter()
    }
    fn at(&self, value: f64) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        (**self).at(value)
    }
    fn constant(&self) -> Option<usize> {
        (**self).constant()
    }
}

/// The family of a model over one of its named constants.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, branches::{ByConstant, Family}};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let family = ByConstant::new(&pair, "load torque")?;
/// assert_eq!(family.constant(), Some(1));
/// let error = family.at(f64::NAN).err().ok_or("an error")?;
/// assert!(error.to_string().starts_with("load torque"), "{error}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy)]
pub struct ByConstant<'m> {
    constants: &'m dyn Constants,
    place: usize,
}

impl<'m> ByConstant<'m> {
    /// The family of `model` over the constant of this name.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchConstant`], which lists the constants; a model without named constants has
    /// none.
    pub fn new(model: &'m dyn Model, name: &str) -> Result<Self, ParameterError> {
        let none = || ParameterError::NoSuchConstant { name: name.into(), known: "none".into() };
        let constants = model.offers().constants.ok_or_else(none)?;
        Ok(ByConstant { constants, place: constants.place(name)? })
    }
    /// Value of the constant in the model itself.
    pub fn value(&self) -> f64 {
        self.constants.values()[self.place]
    }
}

impl Family for ByConstant<'_> {
    fn parameter(&self) -> Channel {
        self.constants.names()[self.place].clone()
    }
    fn at(&self, value: f64) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        self.constants.with_values(&[(self.place, value)])
    }
    fn constant(&self) -> Option<usize> {
        Some(self.place)
    }
}

/// The family of the models that a closure makes.
///
/// Derivatives with respect to the parameter are computed by differences. They affect the number of
/// corrections, not the points that are found.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, branches::{ByFunction, Family}};
/// let family = ByFunction::new("speed", "rad/s", |speed| {
///     NfgPair::new(&NfgParams { speed, ..NfgParams::table1() })
/// });
/// assert_eq!(family.at(100.0)?.dof(), 1);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ByFunction<F> {
    parameter: Channel,
    make: F,
}

impl<F> ByFunction<F> {
    /// The family of the models `make(p)`. `name`, `unit`: those of the parameter p.
    pub fn new(name: &str, unit: &str, make: F) -> Self {
        ByFunction { parameter: Channel::new(name, unit), make }
    }
}

impl<M, F: Fn(f64) -> Result<M, ParameterError>> ByFunction<F> {
    /// The model with the parameter `value`.
    pub(crate) fn make_at(&self, value: f64) -> Result<M, ParameterError> {
        check::finite(self.parameter.name.as_str(), value)?;
        (self.make)(value)
    }
}

impl<M: Periodic + 'static, F: Fn(f64) -> Result<M, ParameterError>> Family for ByFunction<F> {
    fn parameter(&self) -> Channel {
        self.parameter.clone()
    }
    fn at(&self, value: f64) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        Ok(Box::new(self.make_at(value)?))
    }
}
