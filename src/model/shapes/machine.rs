//! Machines: shapes with the values of their constants.

use crate::contact::{ByDeflection, Contact, FixedPieces, Piece};
use crate::error::{ParameterError, check};
use crate::excitation::{Angle, Side};
use crate::model::channel::{Channel, index_of};
use crate::model::equations::{Model, Offers, Periodic, each_row};
use crate::model::jacobian::Jacobian;
use crate::model::shapes::dual_jacobian::dual_jacobian;
use crate::model::shapes::shape::{Drives, Shape, Size};
use crate::model::shapes::waves::fourier_waves::FourierWaves;
use crate::scalar::Scalar;
use std::f64::consts::TAU;
use std::fmt;
use std::sync::{Arc, OnceLock};

/// A model that consists of a [`Shape`] and the values of its constants. Copies share the shape and are
/// cheap.
///
/// It implements [`Model`], with fixed pieces, contacts and an exact Jacobian, and [`Periodic`]. The angle of
/// its waves is φ = φ' t. Two machines run in lanes of one drive table if and only if their shapes are equal.
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
    /// Values of the named constants.
    constants: Vec<f64>,
    /// Constants as the algebra reads them; the first one is φ'.
    prepared: Vec<f64>,
}

/// The part that all copies of a machine share.
struct Fixed<G> {
    shape: G,
    names: Vec<Channel>,
    /// The waves, if they are finite Fourier series.
    waves: Option<FourierWaves>,
    /// The waves as Fourier series from samples, made when they are first needed.
    sampled: OnceLock<Option<FourierWaves>>,
}

impl<G> fmt::Debug for Machine<G> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = self.fixed.names.iter().map(|channel| &channel.name).zip(&self.constants);
        f.write_str("Machine ")?;
        f.debug_map().entries(named).finish()
    }
}

impl<G> Clone for Machine<G> {
    fn clone(&self) -> Self {
        Machine {
            fixed: self.fixed.clone(),
            constants: self.constants.clone(),
            prepared: self.prepared.clone(),
        }
    }
}

/// Maximum number of edges that are searched past an edge at t whose angle or time is rounded.
const ROUNDED: usize = 8;

impl<G: Shape> Machine<G> {
    /// The machine of a shape. Every constant is given once, by its name.
    ///
    /// # Errors
    /// A name that the shape does not have, that is missing or that is given twice; a value out of range; a
    /// shape that contradicts its [`size`](Shape::size), whose waves do not repeat, or whose contacts lack
    /// edges; an acceleration that is not finite at rest.
    pub fn of_constants(shape: G, given: &[(&str, f64)]) -> Result<Self, ParameterError> {
        let fixed = Fixed::new(shape);
        let names = &fixed.names;
        if let Some(twice) =
            (1..names.len()).find(|&i| names[..i].iter().any(|channel| channel.name == names[i].name))
        {
            return Err(ParameterError::Twice { name: names[twice].name.clone() });
        }
        let mut constants = vec![f64::NAN; names.len()];
        for &(name, value) in given {
            let index = fixed.index(name)?;
            if !constants[index].is_nan() {
                return Err(ParameterError::Twice { name: name.into() });
            }
            constants[index] = check::quantity(name, value)?;
        }
        if let Some(index) = constants.iter().position(|value| value.is_nan()) {
            return Err(ParameterError::MissingConstant { name: fixed.names[index].name.clone() });
        }
        let machine = Machine { fixed, constants, prepared: Vec::new() }.prepared()?;
        machine.check_shape()?;
        machine.check_at_rest()?;
        Ok(machine)
    }

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
    /// As there.
    pub fn with_all(&self, values: &[(&str, f64)]) -> Result<Self, ParameterError> {
        let indices = values.iter().map(|(name, value)| Ok((self.fixed.index(name)?, *value)));
        self.with_indexed(&indices.collect::<Result<Vec<_>, _>>()?)
    }
    /// [`with_all`](Machine::with_all) by the indices of the constants.
    pub(crate) fn with_indexed(&self, values: &[(usize, f64)]) -> Result<Self, ParameterError> {
        let mut constants = self.constants.clone();
        for &(index, value) in values {
            constants[index] = check::quantity(self.fixed.names[index].name.as_str(), value)?;
        }
        let machine = Machine { fixed: self.fixed.clone(), constants, prepared: Vec::new() }.prepared()?;
        machine.check_at_rest()?;
        Ok(machine)
    }

    /// A machine with the same constants and another shape. The constants are not prepared again.
    pub(crate) fn reshaped(self, shape: G) -> Self {
        Machine { fixed: Fixed::new(shape), ..self }
    }

    /// The same machine with its constants checked and prepared.
    fn prepared(self) -> Result<Self, ParameterError> {
        let shape = &self.fixed.shape;
        shape.check(&self.constants)?;
        let prepared = shape.prepare(&self.constants);
        let expected = shape.size().constants;
        if prepared.len() != expected {
            return Err(ParameterError::Length {
                name: "list of constants from Shape::prepare, of length size().constants,".into(),
                expected,
                found: prepared.len(),
            });
        }
        let Some(&speed) = prepared.first() else {
            return Err(ParameterError::Empty { name: "constants of a shape".into(), min: 1 });
        };
        check::scale("speed of the angle", speed)?;
        check::all_finite("prepared constants", &prepared)?;
        Ok(Machine { prepared, ..self })
    }

    /// Number of times that the waves repeat in a turn of the angle, at least 1.
    pub(crate) fn repeats(&self) -> Result<u32, ParameterError> {
        match self.shape().repeats() {
            0 => Err(ParameterError::TooFew {
                name: "repeats of the waves in a turn".into(),
                value: 0,
                min: 1,
            }),
            repeats => Ok(repeats),
        }
    }

    /// Value of a constant.
    ///
    /// # Errors
    /// A name that the shape does not have.
    pub fn constant(&self, name: &str) -> Result<f64, ParameterError> {
        Ok(self.constants[self.fixed.index(name)?])
    }
    /// Names and units of the constants.
    pub fn names(&self) -> &[Channel] {
        &self.fixed.names
    }
    /// Values of the constants, in the same order as [`names`](Machine::names).
    pub fn values(&self) -> &[f64] {
        &self.constants
    }
    /// Constants as the algebra reads them, from [`Shape::prepare`]; the first one is φ'.
    pub fn prepared_constants(&self) -> &[f64] {
        &self.prepared
    }
    /// The waves as Fourier series whose values are fast.
    #[inline]
    fn fast_waves(&self) -> Option<&FourierWaves> {
        self.fixed.waves.as_ref().filter(|waves| waves.is_fast)
    }
    /// The waves as Fourier series that can be expanded; `None` if the shape has edges or waves whose
    /// harmonics do not decay.
    pub(crate) fn wave_series(&self) -> Option<&FourierWaves> {
        let sampled = || self.fixed.sampled.get_or_init(|| FourierWaves::sampled(self.shape())).as_ref();
        self.fixed.waves.as_ref().or_else(sampled).filter(|waves| waves.weights.is_some())
    }
    /// The shape.
    #[inline(always)]
    pub fn shape(&self) -> &G {
        &self.fixed.shape
    }
    /// Numbers of degrees of freedom, waves, contacts and constants.
    #[inline(always)]
    pub fn size(&self) -> Size {
        self.fixed.shape.size()
    }
    /// Speed φ' of the angle, over the time of the model.
    #[inline(always)]
    pub fn speed(&self) -> f64 {
        self.prepared[0]
    }
    /// Whether both machines may run in lanes of one drive table: whether their shapes are equal.
    pub fn shares_lanes_with(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.fixed, &other.fixed) || self.fixed.shape == other.fixed.shape
    }

    /// Writes the drives at an angle that turns with the given speed and acceleration.
    #[inline]
    pub(crate) fn drive_at<A: Angle>(
        &self,
        angle: A,
        side: Side,
        speed: A::Number,
        acceleration: A::Number,
        u: &mut [A::Number],
    ) {
        let (waves, rest) = u.split_at_mut(self.size().waves);
        self.shape().waves(angle, side, waves);
        self.write_rest(speed, acceleration, rest);
    }
    /// Writes the drives after the waves: φ', φ'', the other constants.
    pub(crate) fn write_rest<S: Scalar>(&self, speed: S, acceleration: S, rest: &mut [S]) {
        (rest[0], rest[1]) = (speed, acceleration);
        rest[2..].iter_mut().zip(&self.prepared[1..]).for_each(|(u, constant)| *u = (*constant).into());
    }
    /// Adds φ'' times the accelerations of [`Shape::inertia`]. At constant speed nothing is added.
    #[inline(always)]
    pub(crate) fn add_inertia(&self, u: &[f64], a: &mut [f64]) {
        let inertia = self.shape().inertia();
        if inertia.is_empty() {
            return;
        }
        let acceleration = u[self.size().waves + 1];
        if acceleration != 0.0 {
            a.iter_mut().zip(inertia).for_each(|(a, by)| *a += acceleration * by);
        }
    }
    /// The drives after the waves: φ', φ'' = 0, the other constants.
    pub(crate) fn own_drives(&self) -> Vec<f64> {
        [self.prepared[0], 0.0].into_iter().chain(self.prepared[1..].iter().copied()).collect()
    }
}

impl<G: Shape> Fixed<G> {
    fn new(shape: G) -> Arc<Self> {
        let (names, waves) = (shape.names(), FourierWaves::of(&shape));
        Arc::new(Fixed { shape, names, waves, sampled: OnceLock::new() })
    }
}

impl<G> Fixed<G> {
    /// Index of a constant.
    fn index(&self, name: &str) -> Result<usize, ParameterError> {
        index_of(&self.names, name)
    }
}

impl<G: Shape> Model for Machine<G> {
    #[inline(always)]
    fn dof(&self) -> usize {
        self.size().dof
    }
    #[inline]
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.shape().accel(&ByDeflection, Drives::new(self.size().waves, u), q, v, a);
        self.add_inertia(u, a);
    }
    #[inline(always)]
    fn drives(&self) -> usize {
        self.size().drives()
    }
    #[inline]
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        let speed = self.speed();
        let Some(fast) = self.fast_waves() else {
            return self.drive_at(speed * t, side, speed, 0.0, u);
        };
        let (waves, rest) = u.split_at_mut(self.size().waves);
        fast.write(speed * t, waves);
        self.write_rest(speed, 0.0, rest);
    }
    #[inline]
    fn redrive(&self, times: &[f64], side: Side, u: &mut [f64]) {
        match self.fast_waves() {
            Some(fast) => fast.write_again(self.speed(), times, u, self.drives()),
            None => each_row(self.drives(), times, u, |t, u| {
                self.shape().waves_again(self.speed() * t, side, &mut u[..self.size().waves]);
            }),
        }
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        let speed = self.speed();
        let (mut angle, mut at) = (speed * t, t);
        for _ in 0..ROUNDED {
            let edge = self.shape().next_edge(angle)?;
            at = edge / speed;
            if at > t {
                break;
            }
            // A shape may see the edge at t ahead of φ' t: by rounding its time is t, or its angle.
            angle = edge.max(angle).next_up();
        }
        Some(at)
    }
    fn next_knot(&self, t: f64) -> Option<f64> {
        Some(self.shape().next_knot(self.speed() * t)? / self.speed())
    }
    #[inline(always)]
    fn contacts(&self) -> usize {
        self.size().contacts
    }
    #[inline]
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let u = Drives::new(self.size().waves, u);
        for (i, out) in out.iter_mut().enumerate() {
            *out = self.shape().contact(&ByDeflection, i, u, q, v);
        }
    }
    #[inline]
    fn offers(&self) -> Offers<'_> {
        Offers {
            pieces: true,
            jacobian: true,
            stops: self.shape().stops(),
            kinks: self.size().kinks,
            constants: Some(self),
            expansion: Some(self),
            terms: Some(self),
            laws: Some(self),
        }
    }
    #[inline]
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.shape().accel(&FixedPieces(pieces), Drives::new(self.size().waves, u), q, v, a);
        self.add_inertia(u, a);
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        dual_jacobian(self.shape(), pieces, u, q, v, out);
    }
    fn impact(&self, contact: usize, on: Piece, u: &[f64], q: &[f64], v: &mut [f64]) {
        self.shape().impact(contact, on, Drives::new(self.size().waves, u), q, v);
    }
    fn channels(&self) -> Vec<Channel> {
        self.shape().channels()
    }
    fn write_channels(&self, u: &[f64], q: &[f64], v: &[f64], contacts: &[Contact], out: &mut [f64]) {
        self.shape().write_channels(Drives::new(self.size().waves, u), q, v, contacts, out);
    }
}

impl<G: Shape> Periodic for Machine<G> {
    /// 2π/(n φ'), with the number n of repetitions of all waves in a turn ([`Shape::repeats`]), in the time
    /// unit of the model.
    fn period(&self) -> f64 {
        TAU / (f64::from(self.shape().repeats()) * self.speed())
    }
}
