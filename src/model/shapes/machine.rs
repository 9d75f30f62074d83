//! Machines: shapes with the values of their constants.

use crate::error::{ParameterError, check};
use crate::model::channel::Channel;
use crate::model::equations::{Constants, Model};
use crate::model::reference::Pointer;
use crate::model::shapes::compiled::{Code, Compiled, Fixed};
use crate::model::shapes::shape::{Shape, Size};
use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

/// A model that consists of a [`Shape`] and the values of its constants. Copies share the shape and are
/// cheap.
///
/// It implements [`Model`], with fixed pieces, contacts and an exact Jacobian, and
/// [`Periodic`](crate::Periodic). The angle of its waves is φ = φ' t. Two machines run in lanes of one drive
/// table if and only if their shapes are equal.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let loaded = pair.with("load torque", 40.0)?;
/// assert_eq!(loaded.constant("load torque")?, 40.0);
/// assert!(pair.shares_lanes_with(&loaded));
/// let error = pair.with("lod torque", 40.0).unwrap_err().to_string();
/// assert!(error.starts_with("no constant \"lod torque\"; there are: speed, load torque"), "{error}");
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub struct Machine<G> {
    fixed: Arc<Fixed<G>>,
    /// A pointer to it is a model as it is: [`Pointer`].
    code: Arc<dyn Code>,
}

impl<G> Deref for Machine<G> {
    type Target = dyn Code;
    #[inline]
    fn deref(&self) -> &(dyn Code + 'static) {
        &*self.code
    }
}
impl<G> Pointer for Machine<G> {}

impl<G> fmt::Debug for Machine<G> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = self.names().iter().map(|channel| &channel.name).zip(self.values());
        f.write_str("Machine ")?;
        f.debug_map().entries(named).finish()
    }
}

impl<G> Clone for Machine<G> {
    fn clone(&self) -> Self {
        Machine { fixed: self.fixed.clone(), code: self.code.clone() }
    }
}

/// Machines are equal if their shapes and their constants are equal.
impl<G: Shape> PartialEq for Machine<G> {
    fn eq(&self, other: &Self) -> bool {
        self.values() == other.values() && self.shares_lanes_with(other)
    }
}

impl<G: Shape> Machine<G> {
    /// The machine of a shape. Every constant is given once, by its name.
    ///
    /// # Errors
    /// A name that the shape does not have, that is missing or that is given twice; a value out of range; a
    /// shape that contradicts its [`size`](Shape::size), whose waves do not repeat, or whose contacts lack
    /// edges; an acceleration that is not finite at rest.
    pub fn of_constants(shape: G, given: &[(&str, f64)]) -> Result<Self, ParameterError> {
        Ok(Machine::of(Compiled::of_constants(shape, given)?))
    }
    /// A machine with the same constants and another shape. The constants are not prepared again.
    pub(crate) fn reshaped(self, shape: G) -> Self {
        Machine::of(Compiled::reshaped(shape, &*self.code))
    }
    fn of(compiled: Compiled<G>) -> Self {
        Machine { fixed: compiled.fixed.clone(), code: Arc::new(compiled) }
    }
}

impl<G: Shape> Machine<G> {
    /// The shape.
    #[inline(always)]
    pub fn shape(&self) -> &G {
        &self.fixed.shape
    }
    /// Whether both machines may run in lanes of one drive table: whether their shapes are equal.
    pub fn shares_lanes_with(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.fixed, &other.fixed) || self.fixed.shape == other.fixed.shape
    }
}

impl<G> Machine<G> {
    /// The same machine with another value of one constant.
    ///
    /// # Errors
    /// An unknown name; a value out of range; an acceleration not finite at rest.
    pub fn with(&self, name: &str, value: f64) -> Result<Self, ParameterError> {
        self.with_all(&[(name, value)])
    }
    /// [`with`](Machine::with) for several constants, which are checked together.
    ///
    /// # Errors
    /// As there; [`ParameterError::Twice`] for a name that is given twice.
    pub fn with_all(&self, values: &[(&str, f64)]) -> Result<Self, ParameterError> {
        if let Some(twice) = (1..values.len()).find(|&i| values[..i].iter().any(|(n, _)| *n == values[i].0)) {
            return Err(ParameterError::Twice { name: values[twice].0.into() });
        }
        let indices = values.iter().map(|(name, value)| Ok((self.code.index(name)?, *value)));
        self.with_indexed(&indices.collect::<Result<Vec<_>, _>>()?)
    }
    /// [`with_all`](Machine::with_all) by the indices of the constants.
    pub(crate) fn with_indexed(&self, values: &[(usize, f64)]) -> Result<Self, ParameterError> {
        Ok(Machine { fixed: self.fixed.clone(), code: self.code.rebound(values)? })
    }

    /// Value of a constant.
    ///
    /// # Errors
    /// A name that the shape does not have.
    pub fn constant(&self, name: &str) -> Result<f64, ParameterError> {
        Ok(self.values()[self.code.index(name)?])
    }
    /// Names and units of the constants.
    pub fn names(&self) -> &[Channel] {
        Constants::names(&*self.code)
    }
    /// Values of the constants, in the same order as [`names`](Machine::names).
    pub fn values(&self) -> &[f64] {
        Constants::values(&*self.code)
    }
    /// Constants as the algebra reads them, from [`Shape::prepare`]; the first one is φ'.
    pub fn prepared_constants(&self) -> &[f64] {
        self.code.prepared_constants()
    }
    /// Numbers of degrees of freedom, waves, contacts and constants.
    pub fn size(&self) -> Size {
        self.code.size()
    }
    /// Speed φ' of the angle, over the time of the model.
    pub fn speed(&self) -> f64 {
        self.prepared_constants()[0]
    }

    /// The slot of a constant: its index among the drives, at which [`Noisy`](crate::drives::Noisy) and
    /// [`Driven`](crate::drives::Driven) add to it.
    ///
    /// # Errors
    /// A name that the shape does not have; a constant that [`Shape::prepare`] does not return unchanged;
    /// the speed of the angle, for which [`VaryingSpeed`](crate::drives::VaryingSpeed) is used.
    pub fn slot(&self, name: &str) -> Result<usize, ParameterError> {
        let (index, after_speed) = (self.code.index(name)?, self.size().waves + 2);
        let slopes = self.code.drive_slope(index).drives;
        let reached: Vec<usize> = (0..slopes.len()).filter(|&slot| slopes[slot] != 0.0).collect();
        let unchanged =
            |slot: usize| self.prepared_constants()[slot + 1 - after_speed] == self.values()[index];
        match reached[..] {
            // Adding to the drive of the speed would not change the angle of the waves.
            [slot] if slot >= after_speed && slopes[slot] == 1.0 && unchanged(slot) => Ok(slot),
            _ => Err(ParameterError::NotADrive { name: name.into() }),
        }
    }
    /// ∂a/∂c for a constant c, at a fixed angle of the waves. It is exact, by dual numbers through
    /// [`Shape::prepare`].
    ///
    /// # Errors
    /// An unknown name; a wrong number of drives, coordinates or velocities.
    pub fn slope(&self, name: &str, u: &[f64], q: &[f64], v: &[f64]) -> Result<Vec<f64>, ParameterError> {
        let (index, dof) = (self.code.index(name)?, self.dof());
        check::length("drives", u.len(), self.drives())?;
        check::length("coordinates", q.len(), dof)?;
        check::length("velocities", v.len(), dof)?;
        let mut a = vec![0.0; dof];
        self.code.accel_along(&self.code.drive_slope(index).drives, None, u, q, v, &mut a);
        Ok(a)
    }
}
