//! The traits of a gear model: drives, algebra, contacts.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::error::{ParameterError, check};
use crate::excitation::side::Side;
use nalgebra::DMatrix;

/// ∂a/∂q and ∂a/∂v, each `dof` x `dof`, row = acceleration.
///
/// ```
/// let jacobian = gear_dynamics::model::Jacobian::new(2);
/// assert_eq!(jacobian.q.shape(), (2, 2));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Jacobian {
    /// ∂a_i/∂q_j.
    pub q: DMatrix<f64>,
    /// ∂a_i/∂v_j.
    pub v: DMatrix<f64>,
}

impl Jacobian {
    /// Zeros of the right shape.
    pub fn new(dof: usize) -> Self {
        Jacobian { q: DMatrix::zeros(dof, dof), v: DMatrix::zeros(dof, dof) }
    }

    /// The first slope that is not finite: of which acceleration, in which coordinate, and whether in its velocity.
    pub(crate) fn not_finite(&self) -> Option<(usize, usize, bool)> {
        let first = |half: &DMatrix<f64>| {
            half.iter().position(|x| !x.is_finite()).map(|k| (k % half.nrows(), k / half.nrows()))
        };
        let of_q = first(&self.q).map(|(i, j)| (i, j, false));
        of_q.or_else(|| first(&self.v).map(|(i, j)| (i, j, true)))
    }
}

/// q'' = a(u(t), q, q'): drives that depend on time alone, algebra without a clock, and the contacts at which it changes.
///
/// A beginner writes [`dof`](Model::dof) and [`accel`](Model::accel); time is then the only drive, `u[0] == t`:
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
/// An expert adds the rest and gains located tooth edges, exact Jacobians and rattle analysis; [`check_model`](crate::check::check_model)
/// says where they disagree. `accel`, `drive` and `contact` are pure functions.
pub trait Model {
    /// Degrees of freedom.
    fn dof(&self) -> usize;
    /// q'' from the drives, coordinates and velocities.
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]);

    /// Number of drives.
    fn drives(&self) -> usize {
        1
    }
    /// The drives at `t`, seen from one side. By default the only drive is time.
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        let _ = side;
        u[0] = t;
    }
    /// The same into drives that hold those of another instant: what never changes stands there already and may be left out. Solvers ask
    /// for it at every stage.
    fn redrive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.drive(t, side, u);
    }
    /// The first instant after `t` at which a drive jumps or kinks.
    fn next_edge(&self, t: f64) -> Option<f64> {
        let _ = t;
        None
    }

    /// Number of tooth contacts.
    fn contacts(&self) -> usize {
        0
    }
    /// Deflection, rate, edges and force of every contact.
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let _ = (u, q, v, out);
    }

    /// A rigid stop: where contact `contact` meets the edge of its gap on flank `on`, the velocities jump to what this makes of `v`, and the
    /// contact stays in its gap. `false`: no stop, the edge is crossed.
    ///
    /// Which edges are stops is a matter of contact and flank alone. The deflection at a stop depends on drives and coordinates, not on
    /// velocities, and `accel` goes on smoothly past it, as far as the stages of one step need. See [`Restitution`](crate::contact::Restitution).
    fn impact(&self, contact: usize, on: Piece, u: &[f64], q: &[f64], v: &mut [f64]) -> bool {
        let _ = (contact, on, u, q, v);
        false
    }

    /// q'' with every contact held on a given piece. `false`: not offered, and edges are found by re-stepping.
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) -> bool {
        let _ = (pieces, u, q, v, a);
        false
    }
    /// ∂a/∂q and ∂a/∂v, of the laws as they are or with every contact held on a given piece. `false`: not offered, differences are
    /// used.
    fn jacobian(
        &self,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        out: &mut Jacobian,
    ) -> bool {
        let _ = (pieces, u, q, v, out);
        false
    }

    /// Output channels of the model's own, beside those that every model has (see [`Probe`](crate::analysis::Probe)).
    fn channels(&self) -> Vec<Channel> {
        Vec::new()
    }
    /// The values of [`channels`](Model::channels).
    fn observe(&self, u: &[f64], q: &[f64], v: &[f64], contacts: &[Contact], out: &mut [f64]) {
        let _ = (u, q, v, contacts, out);
    }
}

/// A model by reference is a model: what is compiled once for `dyn Model` serves all.
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
    fn next_edge(&self, t: f64) -> Option<f64> {
        (**self).next_edge(t)
    }
    fn contacts(&self) -> usize {
        (**self).contacts()
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        (**self).contact(u, q, v, out);
    }
    fn impact(&self, contact: usize, on: Piece, u: &[f64], q: &[f64], v: &mut [f64]) -> bool {
        (**self).impact(contact, on, u, q, v)
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) -> bool {
        (**self).accel_on_pieces(pieces, u, q, v, a)
    }
    fn jacobian(
        &self,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        out: &mut Jacobian,
    ) -> bool {
        (**self).jacobian(pieces, u, q, v, out)
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

/// A named output with its unit: `1` when dimensionless, empty when it is the model's own choice.
///
/// ```
/// let channel = gear_dynamics::model::Channel::new("mesh force", "N");
/// assert_eq!(channel.to_string(), "mesh force [N]");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// What it is called.
    pub name: String,
    /// Its unit.
    pub unit: String,
}

impl Channel {
    /// A channel of that name and unit.
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

/// Drives repeat: what Poincaré sections, harmonic balance and drive tables ask for. A model with random drives
/// ([`Held`](crate::drives::Held)) is not periodic, and the compiler says so.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no period",
    note = "a model whose drives repeat says so with `impl Periodic`; held random drives never repeat: use the bare model, or integrate in time"
)]
pub trait Periodic: Model {
    /// The period of the drives, in the model's time unit.
    fn period(&self) -> f64;
}

/// A time with coordinates and velocities.
///
/// ```
/// let state = gear_dynamics::State::new(0.0, &[1e-3], &[0.2]);
/// assert_eq!(state.v[0], 0.2);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Time, in the model's unit.
    pub t: f64,
    /// Coordinates.
    pub q: Vec<f64>,
    /// Velocities.
    pub v: Vec<f64>,
}

impl State {
    /// A state from slices.
    pub fn new(t: f64, q: &[f64], v: &[f64]) -> Self {
        State { t, q: q.to_vec(), v: v.to_vec() }
    }

    /// All coordinates and velocities zero.
    pub fn at_rest(dof: usize) -> Self {
        State { t: 0.0, q: vec![0.0; dof], v: vec![0.0; dof] }
    }

    /// Whether it fits a model of `dof` degrees of freedom and holds numbers only.
    pub(crate) fn check(&self, dof: usize) -> Result<(), ParameterError> {
        check::length("start.q", self.q.len(), dof)?;
        check::length("start.v", self.v.len(), dof)?;
        check::quantity("start.t", self.t)?;
        check::quantities("start.q", &self.q)?;
        check::quantities("start.v", &self.v)
    }
}
