//! The code of a machine: a shape with the values of its constants, for every number type.

use crate::contact::{ByDeflection, Contact, FixedPieces, Piece};
use crate::error::{ParameterError, check};
use crate::excitation::{Angle, Side};
use crate::model::channel::{Channel, index_of};
use crate::model::equations::{Constants, Model, Offers, Periodic, each_row};
use crate::model::expansion::expand::{Expand, Recorded};
use crate::model::jacobian::Jacobian;
use crate::model::shapes::dual_jacobian::{GROUPED_FROM, dual_jacobian};
use crate::model::shapes::shape::{Drives, Shape, Size};
use crate::model::shapes::waves::fourier_waves::FourierWaves;
use crate::scalar::Scalar;
use crate::series::Series;
use crate::tape::columns::Columns;
use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};

/// The code of a [`Machine`](crate::Machine) for every number type, whatever its [`Shape`] is. It is compiled
/// where the machine is made from its shape: the code of the machines of this crate is in this crate. Only
/// this crate implements the trait.
pub trait Code: Periodic + Constants + Expand + Send + Sync {
    /// The same shape with other values of some constants: pairs of index and value.
    #[doc(hidden)]
    fn rebound(&self, values: &[(usize, f64)]) -> Result<Arc<dyn Code>, ParameterError>;
    /// Numbers of degrees of freedom, waves, contacts and constants.
    fn size(&self) -> Size;
    /// Constants as the algebra reads them, from [`Shape::prepare`]; the first one is φ'.
    fn prepared_constants(&self) -> &[f64];
    /// Records the algebra of the shape: waves that vary and all constants are drives, since they differ from
    /// run to run. φ'' is 0.
    #[doc(hidden)]
    fn record_shape(&self) -> Recorded;
    /// The waves as Fourier series that can be expanded; `None` if the shape has edges or waves whose
    /// harmonics do not decay.
    #[doc(hidden)]
    fn wave_series(&self) -> Option<&FourierWaves>;
    /// Writes the drives at an angle that turns with the given speed and acceleration.
    #[doc(hidden)]
    fn drives_at(&self, angle: f64, side: Side, motion: [f64; 2], u: &mut [f64]);
    /// As [`drives_at`](Code::drives_at), for angle, speed and acceleration that are series over time.
    #[doc(hidden)]
    fn drive_series_at(&self, motion: [Series; 3], u: &mut [Series]);
    /// [`Shape::next_edge`].
    #[doc(hidden)]
    fn edge_after(&self, angle: f64) -> Option<f64>;
    /// [`Shape::next_knot`].
    #[doc(hidden)]
    fn knot_after(&self, angle: f64) -> Option<f64>;
    /// [`Shape::repeats`].
    #[doc(hidden)]
    fn repeats_in_turn(&self) -> u32;
    /// [`Shape::waves`].
    #[doc(hidden)]
    fn waves_at(&self, angle: f64, side: Side, waves: &mut [f64]);
}

/// A shape with the values of its constants.
pub(crate) struct Compiled<G> {
    pub(crate) fixed: Arc<Fixed<G>>,
    /// Values of the named constants.
    pub(crate) constants: Vec<f64>,
    /// Constants as the algebra reads them; the first one is φ'.
    prepared: Vec<f64>,
}

/// The part that all copies of a machine share.
pub(crate) struct Fixed<G> {
    pub(crate) shape: G,
    pub(crate) names: Vec<Channel>,
    /// The waves, if they are finite Fourier series.
    waves: Option<FourierWaves>,
    /// The waves as Fourier series from samples, made when they are first needed.
    sampled: OnceLock<Option<FourierWaves>>,
    /// Columns of the Jacobian that are made together, found when they are first needed.
    columns: OnceLock<Option<Columns>>,
}

/// Maximum number of edges that are searched past an edge at t whose angle or time is rounded.
const ROUNDED: usize = 8;

impl<G: Shape> Compiled<G> {
    /// The code of a shape. Every constant is given once, by its name.
    ///
    /// # Errors
    /// As [`Machine::of_constants`](crate::Machine::of_constants).
    pub(crate) fn of_constants(shape: G, given: &[(&str, f64)]) -> Result<Self, ParameterError> {
        let fixed = Fixed::new(shape);
        let constants = in_order(&fixed.names, given)?;
        let machine = Compiled { fixed, constants, prepared: Vec::new() }.prepared()?;
        machine.check_shape()?;
        machine.check_at_rest()?;
        Ok(machine)
    }
    /// The same shape with other values of some constants: pairs of index and value.
    pub(crate) fn with_indexed(&self, values: &[(usize, f64)]) -> Result<Self, ParameterError> {
        let mut constants = self.constants.clone();
        for &(index, value) in values {
            constants[index] = check::quantity(self.fixed.names[index].name.as_str(), value)?;
        }
        let machine = Compiled { fixed: self.fixed.clone(), constants, prepared: Vec::new() }.prepared()?;
        machine.check_at_rest()?;
        Ok(machine)
    }
    /// Another shape with the constants of `code`, which are not prepared again.
    pub(crate) fn reshaped(shape: G, code: &dyn Code) -> Self {
        let (constants, prepared) = (code.values().to_vec(), code.prepared_constants().to_vec());
        Compiled { fixed: Fixed::new(shape), constants, prepared }
    }

    /// The same machine with its constants checked and prepared.
    fn prepared(self) -> Result<Self, ParameterError> {
        let shape = &self.fixed.shape;
        shape.check(&self.constants)?;
        let prepared = shape.prepare(&self.constants);
        check_prepared(&prepared, shape.size().constants)?;
        Ok(Compiled { prepared, ..self })
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
    /// The waves as Fourier series whose values are fast.
    #[inline]
    fn fast_waves(&self) -> Option<&FourierWaves> {
        self.fixed.waves.as_ref().filter(|waves| waves.is_fast)
    }
    /// Columns of the Jacobian that are made together. `None`: all are made one by one.
    pub(crate) fn columns(&self) -> Option<&Columns> {
        let grouped = 2 * self.size().dof >= GROUPED_FROM;
        let found = || grouped.then(|| Columns::of(&self.record_with(&|_| None).0)).flatten();
        self.fixed.columns.get_or_init(found).as_ref()
    }
    /// The shape.
    #[inline(always)]
    pub(crate) fn shape(&self) -> &G {
        &self.fixed.shape
    }
    /// Numbers of degrees of freedom, waves, contacts and constants.
    #[inline(always)]
    pub(crate) fn size(&self) -> Size {
        self.fixed.shape.size()
    }
    /// Speed φ' of the angle, over the time of the model.
    #[inline(always)]
    pub(crate) fn speed(&self) -> f64 {
        self.prepared[0]
    }

    /// Writes the drives at an angle that turns with the given speed and acceleration.
    #[inline]
    pub(crate) fn drive_at<A: Angle>(
        &self,
        angle: A,
        side: Side,
        [speed, acceleration]: [A::Number; 2],
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
}

/// The constants in the order of their names.
fn in_order(names: &[Channel], given: &[(&str, f64)]) -> Result<Vec<f64>, ParameterError> {
    if let Some(twice) =
        (1..names.len()).find(|&i| names[..i].iter().any(|channel| channel.name == names[i].name))
    {
        return Err(ParameterError::Twice { name: names[twice].name.clone() });
    }
    let mut constants = vec![f64::NAN; names.len()];
    for &(name, value) in given {
        let index = index_of(names, name)?;
        if !constants[index].is_nan() {
            return Err(ParameterError::Twice { name: name.into() });
        }
        constants[index] = check::quantity(name, value)?;
    }
    match constants.iter().position(|value| value.is_nan()) {
        Some(index) => Err(ParameterError::MissingConstant { name: names[index].name.clone() }),
        None => Ok(constants),
    }
}

fn check_prepared(prepared: &[f64], expected: usize) -> Result<(), ParameterError> {
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
    check::all_finite("prepared constants", prepared)
}

/// The drives after the waves: φ', φ'' = 0, the other constants.
pub(crate) fn own_drives(code: &dyn Code) -> Vec<f64> {
    let prepared = code.prepared_constants();
    [prepared[0], 0.0].into_iter().chain(prepared[1..].iter().copied()).collect()
}

impl<G: Shape> Fixed<G> {
    fn new(shape: G) -> Arc<Self> {
        let (names, waves) = (shape.names(), FourierWaves::of(&shape));
        Arc::new(Fixed { shape, names, waves, sampled: OnceLock::new(), columns: OnceLock::new() })
    }
}

impl<G: Shape> Code for Compiled<G> {
    fn rebound(&self, values: &[(usize, f64)]) -> Result<Arc<dyn Code>, ParameterError> {
        Ok(Arc::new(self.with_indexed(values)?))
    }
    fn size(&self) -> Size {
        self.size()
    }
    fn prepared_constants(&self) -> &[f64] {
        &self.prepared
    }
    fn record_shape(&self) -> Recorded {
        let (waves, series) = (self.size().waves, self.wave_series());
        self.record_with(&|d| match d {
            _ if d < waves => series.and_then(|series| series.constant(d)),
            _ => (d == waves + 1).then_some(0.0),
        })
    }
    fn wave_series(&self) -> Option<&FourierWaves> {
        let sampled = || self.fixed.sampled.get_or_init(|| FourierWaves::sampled(self.shape())).as_ref();
        self.fixed.waves.as_ref().or_else(sampled).filter(|waves| waves.weights.is_some())
    }
    fn drives_at(&self, angle: f64, side: Side, motion: [f64; 2], u: &mut [f64]) {
        self.drive_at(angle, side, motion, u);
    }
    fn drive_series_at(&self, [angle, speed, acceleration]: [Series; 3], u: &mut [Series]) {
        self.drive_at(angle, Side::After, [speed, acceleration], u);
    }
    fn edge_after(&self, angle: f64) -> Option<f64> {
        self.shape().next_edge(angle)
    }
    fn knot_after(&self, angle: f64) -> Option<f64> {
        self.shape().next_knot(angle)
    }
    fn repeats_in_turn(&self) -> u32 {
        self.shape().repeats()
    }
    fn waves_at(&self, angle: f64, side: Side, waves: &mut [f64]) {
        self.shape().waves(angle, side, waves);
    }
}

impl<G: Shape> Model for Compiled<G> {
    #[inline(always)]
    fn dof(&self) -> usize {
        self.size().dof
    }
    fn itself(&self) -> Option<&dyn Model> {
        Some(self)
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
            return self.drive_at(speed * t, side, [speed, 0.0], u);
        };
        let (waves, rest) = u.split_at_mut(self.size().waves);
        fast.write(speed * t, waves);
        self.write_rest(speed, 0.0, rest);
    }
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
        dual_jacobian(self.shape(), self.columns(), pieces, u, q, v, out);
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

impl<G: Shape> Periodic for Compiled<G> {
    /// 2π/(n φ'), with the number n of repetitions of all waves in a turn ([`Shape::repeats`]), in the time
    /// unit of the model.
    fn period(&self) -> f64 {
        TAU / (f64::from(self.shape().repeats()) * self.speed())
    }
}
