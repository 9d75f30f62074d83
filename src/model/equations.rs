//! Traits of a gear model: drives, algebra and contacts.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::error::{ParameterError, check};
use crate::excitation::side::Side;
use crate::model::constants::Constants;
use crate::model::expansion::expand::Expand;
use crate::model::offers::Offers;
use crate::model::terms::Terms;
use nalgebra::DMatrix;

/// The Jacobian of the accelerations: ∂a/∂q and ∂a/∂v, each `dof` x `dof`. Each row belongs to an
/// acceleration.
///
/// ```
/// use gear_dynamics::{contact::Piece, model::{Jacobian, Offers}, Model};
/// struct Oscillator; // q'' = -4 q - 0.5 q'
/// impl Model for Oscillator {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) { a[0] = -4.0 * q[0] - 0.5 * v[0]; }
///     fn offers(&self) -> Offers<'_> { Offers { jacobian: true, ..Offers::default() } }
///     fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], _: &[f64], _: &[f64], out: &mut Jacobian) {
///         out.q[(0, 0)] = -4.0;
///         out.v[(0, 0)] = -0.5;
///     }
/// }
/// let mut jacobian = Jacobian::new(1);
/// Oscillator.jacobian(None, &[0.0], &[1.0], &[0.0], &mut jacobian);
/// assert_eq!((-jacobian.q[(0, 0)]).sqrt(), 2.0); // undamped natural frequency
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Jacobian {
    /// ∂a_i/∂q_j.
    pub q: DMatrix<f64>,
    /// ∂a_i/∂v_j.
    pub v: DMatrix<f64>,
}

impl Jacobian {
    /// A Jacobian of zeros for `dof` degrees of freedom.
    pub fn new(dof: usize) -> Self {
        Jacobian { q: DMatrix::zeros(dof, dof), v: DMatrix::zeros(dof, dof) }
    }

    /// The first entry that is not finite: the index of the acceleration, the index of the coordinate, and
    /// `true` for an entry of ∂a/∂v.
    pub(crate) fn not_finite(&self) -> Option<(usize, usize, bool)> {
        let first = |half: &DMatrix<f64>| {
            half.iter().position(|x| !x.is_finite()).map(|k| (k % half.nrows(), k / half.nrows()))
        };
        let of_q = first(&self.q).map(|(i, j)| (i, j, false));
        of_q.or_else(|| first(&self.v).map(|(i, j)| (i, j, true)))
    }
}

/// A model q'' = a(u(t), q, q'), divided into drives u, algebra a and contacts.
///
/// The drives depend on time alone. Time does not appear in the algebra. The contacts give the edges at
/// which the algebra changes. A minimal model implements [`dof`](Model::dof) and [`accel`](Model::accel);
/// time is then the only drive, `u[0] == t`:
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, Model, State};
/// struct Pendulum;
/// impl Model for Pendulum {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _u: &[f64], q: &[f64], _v: &[f64], a: &mut [f64]) { a[0] = -q[0]; }
/// }
/// let end = Dop853::new().end(&Pendulum, &State::new(0.0, &[1.0], &[0.0]), 1.0)?;
/// assert!((end.q[0] - 1f64.cos()).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// The other methods provide located edges, exact Jacobians and rattle analysis.
/// [`check_model`](crate::check::check_model) finds contradictions between the methods. `accel`, `drive` and
/// `contact` must be pure functions.
pub trait Model {
    /// Number of degrees of freedom.
    fn dof(&self) -> usize;
    /// Writes the accelerations q'' to `a`, from drives `u`, coordinates `q` and velocities `v`.
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]);

    /// Number of drives. Default: 1.
    fn drives(&self) -> usize {
        1
    }
    /// Writes the drives at `t` to `u`. `side`: before or after a jump at `t`. Default: time is the only
    /// drive.
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        let _ = side;
        u[0] = t;
    }
    /// Updates `u`, which contains the drives of another instant, to `t`. The implementation may skip drives
    /// that never change. Solvers call it at every stage. Default: [`drive`](Model::drive).
    fn redrive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.drive(t, side, u);
    }
    /// Updates the drives at the nodes of a step: row i of `u`, of length [`drives`](Model::drives), to
    /// `times[i]`. The last time is the end of the step, where the drives are those before a jump.
    /// The times may belong to several consecutive steps, if no drive jumps between them. Default:
    /// [`redrive`](Model::redrive) for each row.
    fn redrive_nodes(&self, times: &[f64], u: &mut [f64]) {
        redrive_each(self, times, u);
    }
    /// Returns the first instant after `t` at which a drive jumps or has a kink. Solvers end a step there.
    /// Default: `None`.
    ///
    /// If `t` lies on an edge within rounding, the result must be the next edge, and [`drive`](Model::drive)
    /// must give the values of the requested side. [`Wave::next_edge`](crate::Wave::next_edge) and
    /// [`Wave::value`](crate::Wave::value) allow for the rounding.
    fn next_edge(&self, t: f64) -> Option<f64> {
        let _ = t;
        None
    }

    /// Number of contacts. Default: 0.
    fn contacts(&self) -> usize {
        0
    }
    /// Writes deflection, rate, edges and force of every contact to `out`.
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let _ = (u, q, v, out);
    }

    /// Returns the model as one that can be expanded into Taylor series, for [`Taylor`](crate::Taylor).
    /// Default: `None`. A [`Machine`](crate::Machine) returns itself.
    fn expand(&self) -> Option<&dyn Expand> {
        None
    }

    /// Returns the model as one with named constants, for exact derivatives with respect to them. Default:
    /// `None`. A [`Machine`](crate::Machine) returns itself.
    fn named_constants(&self) -> Option<&dyn Constants> {
        None
    }

    /// Returns the model as one that knows the terms of its accelerations, and with them its rounding errors.
    /// Without it they are estimated from slopes, in which terms may have cancelled. Default: `None`. A
    /// [`Machine`](crate::Machine) returns itself.
    fn terms(&self) -> Option<&dyn Terms> {
        None
    }

    /// Declares which of the three following parts the model implements. The answer must always be the same.
    /// Default: none.
    fn offers(&self) -> Offers<'_> {
        Offers::default()
    }
    /// Writes q'' with every contact on a given piece, continued smoothly past its edges. It is called if
    /// [`Offers::pieces`] declares it. Default: NaN.
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let _ = (pieces, u, q, v);
        a.fill(f64::NAN);
    }
    /// Writes ∂a/∂q and ∂a/∂v to `out`, which contains zeros or an earlier Jacobian of the model. It is called
    /// if [`Offers::jacobian`] declares it. `pieces`: evaluation by deflection for `None`; otherwise with every
    /// contact on a given piece, for a model that also offers `pieces`. Default: NaN.
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        let _ = (pieces, u, q, v);
        out.q.fill(f64::NAN);
        out.v.fill(f64::NAN);
    }
    /// Applies the impact of contact `contact` on a rigid stop at the edge of flank `on`: replaces the
    /// velocities `v` before the impact by those after it. The contact stays in its gap. It is called for the
    /// stops that [`Offers::stops`] declares; a contact crosses any other edge. Default: NaN. See
    /// [`Restitution`](crate::contact::Restitution).
    ///
    /// The deflection at a stop must depend on drives and coordinates, not on velocities. `accel` must
    /// continue smoothly past the stop, as far as the stages of one step reach.
    fn impact(&self, contact: usize, on: Piece, u: &[f64], q: &[f64], v: &mut [f64]) {
        let _ = (contact, on, u, q);
        v.fill(f64::NAN);
    }

    /// Channels of this model in addition to those that every model has (see
    /// [`Probe`](crate::analysis::Probe)). Default: none.
    fn channels(&self) -> Vec<Channel> {
        Vec::new()
    }
    /// Writes the values of the [`channels`](Model::channels) to `out`.
    fn observe(&self, u: &[f64], q: &[f64], v: &[f64], contacts: &[Contact], out: &mut [f64]) {
        let _ = (u, q, v, contacts, out);
    }
}

/// The drives at the nodes of a step by [`Model::redrive`]; see [`Model::redrive_nodes`].
pub(crate) fn redrive_each<M: Model + ?Sized>(model: &M, times: &[f64], u: &mut [f64]) {
    let drives = model.drives();
    for (i, &t) in times.iter().enumerate() {
        let side = if i + 1 == times.len() { Side::Before } else { Side::After };
        model.redrive(t, side, &mut u[drives * i..][..drives]);
    }
}

/// A reference to a model is a model. Code compiled once for `dyn Model` therefore accepts every model.
impl<M: Model + ?Sized> Model for &M {
    fn dof(&self) -> usize {
        (**self).dof()
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        (**self).accel(u, q, v, a);
    }
    fn drives(&self) -> usize {
        (**self).drives()
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        (**self).drive(t, side, u);
    }
    fn redrive(&self, t: f64, side: Side, u: &mut [f64]) {
        (**self).redrive(t, side, u);
    }
    fn redrive_nodes(&self, times: &[f64], u: &mut [f64]) {
        (**self).redrive_nodes(times, u);
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        (**self).next_edge(t)
    }
    fn contacts(&self) -> usize {
        (**self).contacts()
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        (**self).contact(u, q, v, out);
    }
    fn expand(&self) -> Option<&dyn Expand> {
        (**self).expand()
    }
    fn named_constants(&self) -> Option<&dyn Constants> {
        (**self).named_constants()
    }
    fn terms(&self) -> Option<&dyn Terms> {
        (**self).terms()
    }
    fn offers(&self) -> Offers<'_> {
        (**self).offers()
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        (**self).accel_on_pieces(pieces, u, q, v, a);
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        (**self).jacobian(pieces, u, q, v, out);
    }
    fn impact(&self, contact: usize, on: Piece, u: &[f64], q: &[f64], v: &mut [f64]) {
        (**self).impact(contact, on, u, q, v);
    }
    fn channels(&self) -> Vec<Channel> {
        (**self).channels()
    }
    fn observe(&self, u: &[f64], q: &[f64], v: &[f64], contacts: &[Contact], out: &mut [f64]) {
        (**self).observe(u, q, v, contacts, out);
    }
}

impl<M: Periodic + ?Sized> Periodic for &M {
    fn period(&self) -> f64 {
        (**self).period()
    }
}

/// A quantity with a name and a unit that can be read from a model. Unit: `1` if dimensionless, empty if it
/// depends on the units of the model.
///
/// ```
/// let channel = gear_dynamics::model::Channel::new("mesh force", "N");
/// assert_eq!(channel.to_string(), "mesh force [N]");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Channel {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
}

impl Channel {
    /// A channel with the given name and unit.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Channel { name: name.into(), unit: unit.into() }
    }
}

impl std::fmt::Display for Channel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.unit.is_empty() {
            f.write_str(&self.name)
        } else {
            write!(f, "{} [{}]", self.name, self.unit)
        }
    }
}

/// A model whose drives repeat. Poincaré sections, harmonic balance and drive tables require it.
///
/// A model with held processes ([`Held`](crate::drives::Held)) is not periodic and does not implement this
/// trait.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no period",
    note = "implement `Periodic` for a model whose drives repeat; a model with held processes has no period: \
            use the model without them, or integrate in time"
)]
pub trait Periodic: Model {
    /// Period of the drives, in the time unit of the model.
    fn period(&self) -> f64;
}

/// The state of a model: coordinates and velocities at a time.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, Model, State};
/// struct Load; // q'' = -1
/// impl Model for Load {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) { a[0] = -1.0; }
/// }
/// let end = Dop853::new().end(&Load, &State::new(0.0, &[0.5], &[2.0]), 3.0)?;
/// // q = 0.5 + 2 t - t²/2 and q' = 2 - t at t = 3
/// assert!((end.q[0] - 2.0).abs() < 1e-9 && (end.v[0] + 1.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct State {
    /// Time, in the time unit of the model.
    pub t: f64,
    /// Coordinates q.
    pub q: Vec<f64>,
    /// Velocities q'.
    pub v: Vec<f64>,
}

impl State {
    /// A state from a time, coordinates and velocities.
    pub fn new(t: f64, q: &[f64], v: &[f64]) -> Self {
        State { t, q: q.to_vec(), v: v.to_vec() }
    }

    /// The state at time 0 with all coordinates and velocities 0.
    pub fn at_rest(dof: usize) -> Self {
        State { t: 0.0, q: vec![0.0; dof], v: vec![0.0; dof] }
    }

    /// Checks that the state fits a model of `dof` degrees of freedom and that all numbers are within ±1e50.
    pub(crate) fn check(&self, dof: usize) -> Result<(), ParameterError> {
        check::length("start.q", self.q.len(), dof)?;
        check::length("start.v", self.v.len(), dof)?;
        check::quantity("start.t", self.t)?;
        check::quantities("start.q", &self.q)?;
        check::quantities("start.v", &self.v)
    }
}
