//! Families of models over two parameters.

use crate::branches::family::Family;
use crate::branches::orbits::without_stops::WithoutStops;
use crate::contact::Piece;
use crate::error::{ParameterError, check};
use crate::model::equations::Constants;
use crate::model::{Channel, Model, Periodic};
use std::cell::{Cell, RefCell};
use std::rc::Rc;

/// A family of models over two parameters (p, λ). The boundary of a bifurcation in p is followed along λ.
///
/// [`ByConstants`] varies two named constants; [`ByFunctionOfTwo`] makes the models by a closure.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, branches::{ByConstants, Plane}};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let plane = ByConstants::new(&pair, ["speed", "load torque"])?;
/// assert_eq!(plane.parameters()[1].name, "load torque");
/// assert_eq!(plane.at([100.0, 20.0])?.dof(), 1);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub trait Plane {
    /// Names and units of p and λ.
    fn parameters(&self) -> [Channel; 2];
    /// The model with the parameters p and λ.
    ///
    /// # Errors
    /// Values for which there is no model.
    fn at(&self, values: [f64; 2]) -> Result<Box<dyn Periodic + '_>, ParameterError>;
    /// Indices of the parameters among the [named constants](crate::model::Offers::constants) of every model, for
    /// exact derivatives. Default: `None`.
    fn constants(&self) -> Option<[usize; 2]> {
        None
    }
}

/// The family of a model over two of its named constants.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, branches::{ByConstants, Plane}};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let error = ByConstants::new(&pair, ["speed", "lod"]).err().ok_or("an error")?;
/// assert!(error.to_string().starts_with("no constant \"lod\""));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy)]
pub struct ByConstants<'m> {
    constants: &'m dyn Constants,
    places: [usize; 2],
}

impl<'m> ByConstants<'m> {
    /// The family of `model` over the constants p and λ of these names.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchConstant`], which lists the constants; [`ParameterError::Twice`] for the same
    /// constant twice.
    pub fn new(model: &'m dyn Model, names: [&str; 2]) -> Result<Self, ParameterError> {
        let none = || ParameterError::NoSuchConstant { name: names[0].into(), known: "none".into() };
        let constants = model.offers().constants.ok_or_else(none)?;
        if names[0] == names[1] {
            return Err(ParameterError::Twice { name: names[0].into() });
        }
        Ok(ByConstants { constants, places: [constants.place(names[0])?, constants.place(names[1])?] })
    }
}

impl Plane for ByConstants<'_> {
    fn parameters(&self) -> [Channel; 2] {
        self.places.map(|place| self.constants.names()[place].clone())
    }
    fn at(&self, values: [f64; 2]) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        self.constants.with_values(&[(self.places[0], values[0]), (self.places[1], values[1])])
    }
    fn constants(&self) -> Option<[usize; 2]> {
        Some(self.places)
    }
}

/// The family of the models that a closure of (p, λ) makes. Derivatives with respect to both are differences.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, branches::{ByFunctionOfTwo, Plane}};
/// let plane = ByFunctionOfTwo::new([("speed", "rad/s"), ("load", "N m")], |[speed, load]: [f64; 2]| {
///     NfgPair::new(&NfgParams { speed, ..NfgParams::table1() })?.with("load torque", load)
/// });
/// assert_eq!(plane.at([100.0, 20.0])?.dof(), 1);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ByFunctionOfTwo<F> {
    parameters: [Channel; 2],
    make: F,
}

impl<F> ByFunctionOfTwo<F> {
    /// The family of the models `make([p, λ])`, with names and units of the parameters.
    pub fn new(parameters: [(&str, &str); 2], make: F) -> Self {
        ByFunctionOfTwo { parameters: parameters.map(|(name, unit)| Channel::new(name, unit)), make }
    }
}

impl<M: Periodic + 'static, F: Fn([f64; 2]) -> Result<M, ParameterError>> Plane for ByFunctionOfTwo<F> {
    fn parameters(&self) -> [Channel; 2] {
        self.parameters.clone()
    }
    fn at(&self, values: [f64; 2]) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        check::all_finite("parameters", &values)?;
        Ok(Box::new((self.make)(values)?))
    }
}

/// The family over p at a value of λ that changes from point to point.
pub(crate) struct Slice<'p> {
    pub(crate) plane: &'p dyn Plane,
    pub(crate) other: Cell<f64>,
    /// The rigid stops that the orbits of the boundary graze: they are left out.
    pub(crate) left_out: RefCell<Rc<[(usize, Piece)]>>,
}

impl Slice<'_> {
    /// The model at a place of the plane.
    pub(crate) fn model(&self, values: [f64; 2]) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        let model = self.plane.at(values)?;
        let stops = self.left_out.borrow().clone();
        Ok(if stops.is_empty() { model } else { Box::new(WithoutStops::new(model, &stops)) })
    }
}

impl Family for Slice<'_> {
    fn parameter(&self) -> Channel {
        let [p, _] = self.plane.parameters();
        p
    }
    fn at(&self, value: f64) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        self.model([value, self.other.get()])
    }
    fn constant(&self) -> Option<usize> {
        self.plane.constants().map(|places| places[0])
    }
}
