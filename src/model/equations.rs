//! Traits of a gear model: drives, algebra and contacts, and what it offers besides.

use crate::contact::{Contact, Piece};
use crate::error::ParameterError;
use crate::excitation::Side;
use crate::model::channel::{Channel, index_of};
use crate::model::drive_slope::DriveSlope;
use crate::model::expansion::expand::Expand;
use crate::model::jacobian::Jacobian;
use crate::model::laws::Laws;
use crate::model::terms::Terms;
use std::fmt;

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
/// [`from_fn`](crate::model::from_fn) makes such a model of a closure. The other methods provide located
/// edges, exact Jacobians and rattle analysis. [`check_model`](crate::check::check_model) finds
/// contradictions between the methods. `accel`, `drive` and `contact` must be pure functions.
pub trait Model {
    /// Number of degrees of freedom.
    fn dof(&self) -> usize;
    /// Writes the accelerations q'' to `a`, from drives `u`, coordinates `q` and velocities `v`.
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]);

    /// The model whose drives, contacts and channels this model has, for a model that wraps another one.
    /// Default: `None`.
    ///
    /// It answers [`drives`](Model::drives) to [`next_knot`](Model::next_knot),
    /// [`contacts`](Model::contacts), [`contact`](Model::contact), [`impact`](Model::impact),
    /// [`channels`](Model::channels) and [`write_channels`](Model::write_channels), as far as the
    /// wrapper does not implement them. Three things remain to be decided:
    ///
    /// - The algebra is the wrapper's own. Of `offers`, `accel_on_pieces` and `jacobian` it has what it
    ///   implements, since an answer of the base holds for other accelerations.
    /// - A wrapper that changes [`drive`](Model::drive) also implements `redrive`, `next_edge` and
    ///   `next_knot`.
    /// - A wrapper with further coordinates or fewer contacts also implements what reads them: `contact`,
    ///   `impact`, `channels` and `write_channels`.
    ///
    /// [`check_model`](crate::check::check_model) compares these methods with one another.
    ///
    /// ```
    /// use gear_dynamics::{excitation::Side, Model, NfgPair, NfgParams};
    /// struct Braked<M>(M, f64); // a further damping
    /// impl<M: Model> Model for Braked<M> {
    ///     fn dof(&self) -> usize { self.0.dof() }
    ///     fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
    ///         self.0.accel(u, q, v, a);
    ///         a.iter_mut().zip(v).for_each(|(a, v)| *a -= self.1 * v);
    ///     }
    ///     fn base(&self) -> Option<&dyn Model> { Some(&self.0) }
    /// }
    /// let pair = NfgPair::new(&NfgParams::table1())?;
    /// let (mut u, mut w) = (vec![0.0; pair.drives()], vec![0.0; pair.drives()]);
    /// pair.drive(1.0, Side::After, &mut u);
    /// Braked(pair, 0.1).drive(1.0, Side::After, &mut w);
    /// assert_eq!(u, w);
    /// # Ok::<(), gear_dynamics::ParameterError>(())
    /// ```
    fn base(&self) -> Option<&dyn Model> {
        None
    }

    /// Number of drives. Default: 1.
    fn drives(&self) -> usize {
        self.base().map_or(1, |base| base.drives())
    }
    /// Writes the drives at `t` to `u`. `side`: before or after a jump at `t`. Default: time is the only
    /// drive, any further one is NaN.
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        match self.base() {
            Some(base) => base.drive(t, side, u),
            None => {
                u.fill(f64::NAN);
                u.iter_mut().take(1).for_each(|time| *time = t);
            }
        }
    }
    /// Updates drives of other instants: row i of `u`, of length [`drives`](Model::drives), to `times[i]`.
    /// `side` states whether a time on a jump lies before or after it. The implementation may skip drives
    /// that never change. Solvers call it for the nodes of one or of several steps at once, and for single
    /// instants. Default: [`drive`](Model::drive) for each row.
    fn redrive(&self, times: &[f64], side: Side, u: &mut [f64]) {
        match self.base() {
            Some(base) => base.redrive(times, side, u),
            None => each_row(self.drives(), times, u, |t, u| self.drive(t, side, u)),
        }
    }
    /// Returns the first instant after `t` at which a drive jumps or has a kink. Solvers end a step there.
    /// Default: `None`.
    ///
    /// If `t` lies on an edge within rounding, the result must be the next edge, and [`drive`](Model::drive)
    /// must give the values of the requested side. [`Wave::next_edge`](crate::Wave::next_edge) and
    /// [`Wave::value`](crate::Wave::value) allow for the rounding.
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.base()?.next_edge(t)
    }
    /// Returns the first instant after `t` at which a wave has a [knot](crate::Wave::next_knot), for example
    /// a sample of a [`Table`](crate::excitation::Table). Adaptive Runge-Kutta methods end a step there.
    /// Default: `None`.
    fn next_knot(&self, t: f64) -> Option<f64> {
        self.base()?.next_knot(t)
    }

    /// Number of contacts. Default: 0.
    fn contacts(&self) -> usize {
        self.base().map_or(0, |base| base.contacts())
    }
    /// Writes deflection, rate, edges and force of every contact to `out`.
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        if let Some(base) = self.base() {
            base.contact(u, q, v, out);
        }
    }
    /// Applies the impact of contact `contact` on a rigid stop at the edge of flank `on`: replaces the
    /// velocities `v` before the impact by those after it. The contact stays in its gap. It is called for the
    /// stops that [`Offers::stops`] declares; a contact crosses any other edge. Default: NaN. See
    /// [`Restitution`](crate::contact::Restitution).
    ///
    /// The deflection at a stop must depend on drives and coordinates, not on velocities. `accel` must
    /// continue smoothly past the stop, as far as the stages of one step reach.
    fn impact(&self, contact: usize, on: Piece, u: &[f64], q: &[f64], v: &mut [f64]) {
        match self.base() {
            Some(base) => base.impact(contact, on, u, q, v),
            None => v.fill(f64::NAN),
        }
    }

    /// Declares what the model has besides its accelerations: which of the two following methods it
    /// implements, rigid stops, named constants, a Taylor series and others. The answer must always be the
    /// same. Default: none.
    fn offers(&self) -> Offers<'_> {
        Offers::default()
    }
    /// Writes q'' with every contact on a given piece, continued smoothly past its edges. It is called if
    /// [`Offers::pieces`] declares it. Default: NaN.
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let _ = (pieces, u, q, v);
        a.fill(f64::NAN);
    }
    /// Returns the acceleration of a model with one degree of freedom: that of `accel_on_pieces` if `pieces`
    /// are given, else that of `accel`. Solvers call it at every stage, because numbers that are passed by
    /// value stay in registers. Only a pointer to a model implements it, to pass the call on.
    #[doc(hidden)]
    fn accel_of_one(&self, pieces: Option<&[Piece]>, u: &[f64], q: f64, v: f64) -> f64 {
        let mut a = [f64::NAN];
        match pieces {
            Some(pieces) => self.accel_on_pieces(pieces, u, &[q], &[v], &mut a),
            None => self.accel(u, &[q], &[v], &mut a),
        }
        a[0]
    }
    /// The model itself. A pointer to a model passes the call on, so that loops that are given a pointer to a
    /// pointer call the model at once. Default: `None`.
    #[doc(hidden)]
    fn itself(&self) -> Option<&dyn Model> {
        None
    }
    /// Writes ∂a/∂q and ∂a/∂v to `out`, which contains zeros or an earlier Jacobian of the model. It is
    /// called if [`Offers::jacobian`] declares it. `pieces`: evaluation by deflection for `None`; otherwise
    /// with every contact on a given piece, for a model that also offers `pieces`. Default: NaN.
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        let _ = (pieces, u, q, v);
        out.q.fill(f64::NAN);
        out.v.fill(f64::NAN);
    }

    /// Channels of this model in addition to those that every model has (see
    /// [`Probe`](crate::ode::Probe)). Default: none.
    fn channels(&self) -> Vec<Channel> {
        self.base().map_or_else(Vec::new, |base| base.channels())
    }
    /// Writes the values of the [`channels`](Model::channels) to `out`.
    fn write_channels(&self, u: &[f64], q: &[f64], v: &[f64], contacts: &[Contact], out: &mut [f64]) {
        if let Some(base) = self.base() {
            base.write_channels(u, q, v, contacts, out);
        }
    }
}

/// Whether a model has contacts and does not evaluate their laws on fixed pieces.
pub(crate) fn lacks_pieces(model: &(impl Model + ?Sized)) -> bool {
    model.contacts() > 0 && !model.offers().pieces
}

/// Checks that a model has a drive.
pub(crate) fn check_slot(model: &(impl Model + ?Sized), slot: usize) -> Result<(), ParameterError> {
    let drives = model.drives();
    if slot < drives { Ok(()) } else { Err(ParameterError::NoSuchSlot { slot, drives }) }
}

/// Writes the rows of drives of [`Model::redrive`] one by one.
#[inline(always)]
pub(crate) fn each_row(drives: usize, times: &[f64], u: &mut [f64], mut write: impl FnMut(f64, &mut [f64])) {
    for (i, &t) in times.iter().enumerate() {
        write(t, &mut u[drives * i..][..drives]);
    }
}

/// A model whose drives repeat. Poincaré sections, harmonic balance and drive tables require it.
///
/// A model with held processes ([`Noisy`](crate::drives::Noisy)) is not periodic and does not implement this
/// trait.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no period",
    note = "implement `Periodic` for a model whose drives repeat; a model with held processes or with a speed law \
            (`VaryingSpeed`) has no period: use the model without them, or integrate in time"
)]
pub trait Periodic: Model {
    /// Period of the drives, in the time unit of the model.
    fn period(&self) -> f64;
}

/// Number of periods from which on a time is late: its rounding exceeds 1e-14 of the period, in which drives
/// may make many cycles.
const LATE: f64 = 64.0;

/// The instant in the first period at which the drives are those of a late time `t`; `t` itself if it is not
/// late, or if the period is not positive. The remainder is exact, and steps from it are not lost in the
/// rounding of `t`.
pub(crate) fn early(t: f64, period: f64) -> f64 {
    if period > 0.0 && t.is_finite() && t.abs() > LATE * period { t.rem_euclid(period) } else { t }
}

/// The optional parts that a model implements. Default: none.
///
/// Solvers call [`accel_on_pieces`](crate::Model::accel_on_pieces), [`jacobian`](crate::Model::jacobian) and
/// [`impact`](crate::Model::impact) only where they are declared.
/// [`check_model`](crate::check::check_model) reports a part that is declared and not implemented, or
/// implemented and not declared.
///
/// ```
/// use gear_dynamics::{model::Offers, Model, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams::table1())?; // a machine offers all but rigid stops
/// assert_eq!(pair.offers().constants.ok_or("constants")?.values()[0], 160.0); // the speed
/// assert!(pair.offers().pieces && pair.offers().stops.is_empty());
/// let floor = Offers { stops: &[[true, false]], ..Offers::default() };
/// assert!(!floor.pieces && floor.stops[0] == [true, false]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Default)]
pub struct Offers<'m> {
    /// The accelerations on fixed pieces: [`Model::accel_on_pieces`](crate::Model::accel_on_pieces). Without
    /// them solvers locate edges by repeating steps.
    pub pieces: bool,
    /// The Jacobian: [`Model::jacobian`](crate::Model::jacobian). Without it differences are used.
    pub jacobian: bool,
    /// Whether the lower and the upper edge of each contact are rigid stops:
    /// [`Model::impact`](crate::Model::impact). Contacts past the end of the list have no stop.
    pub stops: &'m [[bool; 2]],
    /// Number of contacts that are inner kinks of contact laws
    /// ([`Nonlinearity::kinks`](crate::contact::Nonlinearity::kinks)): the last ones. Their deflection is the
    /// value of the kink; their rate and force are not read. Solvers locate them like edges, and analysis
    /// leaves them out.
    pub kinks: usize,
    /// The model as one with named constants, for exact derivatives with respect to them.
    pub constants: Option<&'m dyn Constants>,
    /// The model as one that can be expanded into Taylor series, for [`Taylor`](crate::Taylor).
    pub expansion: Option<&'m dyn Expand>,
    /// The model as one that knows the terms of its accelerations, and with them its rounding errors. Without
    /// it they are estimated from slopes, in which terms may have cancelled.
    pub terms: Option<&'m dyn Terms>,
    /// The model as one that evaluates its contact laws apart from its accelerations, for
    /// [`Balance::truncated_forces`](crate::Balance::truncated_forces).
    pub laws: Option<&'m dyn Laws>,
}

impl fmt::Debug for Offers<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Offers")
            .field("pieces", &self.pieces)
            .field("jacobian", &self.jacobian)
            .field("stops", &self.stops)
            .field("kinks", &self.kinks)
            .field("constants", &self.constants.is_some())
            .field("expansion", &self.expansion.is_some())
            .field("terms", &self.terms.is_some())
            .field("laws", &self.laws.is_some())
            .finish()
    }
}

impl<'m> Offers<'m> {
    /// The named constants.
    ///
    /// # Errors
    /// [`ParameterError::NoConstants`] if there are none.
    pub(crate) fn named(&self) -> Result<&'m dyn Constants, ParameterError> {
        self.constants.ok_or(ParameterError::NoConstants)
    }
    /// [`stops`](Offers::stops) with one entry for each of `contacts` contacts; empty without a stop.
    pub(crate) fn rigid_edges(&self, contacts: usize) -> Vec<[bool; 2]> {
        let stop = |i: usize| self.stops.get(i).copied().unwrap_or_default();
        if self.first_stop().is_some() { (0..contacts).map(stop).collect() } else { Vec::new() }
    }

    /// Number of contacts at which teeth may touch, the first ones of `contacts`.
    pub(crate) fn touching(&self, contacts: usize) -> usize {
        contacts.saturating_sub(self.kinks)
    }

    /// The first contact with a rigid stop.
    pub(crate) fn first_stop(&self) -> Option<usize> {
        self.stops.iter().position(|rigid| *rigid != [false; 2])
    }
    /// Refuses a model with a rigid stop, on behalf of a method that does not locate edges.
    ///
    /// # Errors
    /// `error` of the first contact with a stop.
    pub(crate) fn refuse_stops<E>(&self, error: impl FnOnce(usize) -> E) -> Result<(), E> {
        self.first_stop().map_or(Ok(()), |contact| Err(error(contact)))
    }
}

/// A model with named constants that act through its drives. A [`Machine`](crate::Machine) offers it.
///
/// ```
/// use gear_dynamics::{Model, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let model: &dyn Model = &pair;
/// let constants = model.offers().constants.ok_or("constants")?;
/// let load = constants.index("load torque")?;
/// assert_eq!(constants.values()[load], pair.constant("load torque")?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Constants: Send + Sync {
    /// Names and units.
    fn names(&self) -> &[Channel];
    /// Values, in the order of the names.
    fn values(&self) -> &[f64];
    /// The same model with other values of some constants: pairs of index and value.
    ///
    /// # Errors
    /// A value out of range.
    ///
    /// # Panics
    /// If a constant does not exist.
    fn with_values(&self, values: &[(usize, f64)]) -> Result<Box<dyn Periodic + '_>, ParameterError>;
    /// The derivative of the drives with respect to constant `i`, at a fixed phase.
    ///
    /// # Panics
    /// If there is no constant `i`.
    fn drive_slope(&self, i: usize) -> DriveSlope;
    /// Writes Σ_k ∂a/∂u_k w_k, the derivative of the accelerations along the change w = `along` of the
    /// drives, with every contact on a given piece, or on that of its deflection without `pieces`.
    fn accel_along(
        &self,
        along: &[f64],
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        out: &mut [f64],
    );

    /// Index of the constant of this name.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchConstant`], which lists the names.
    fn index(&self, name: &str) -> Result<usize, ParameterError> {
        index_of(self.names(), name)
    }
}

#[cfg(test)]
mod tests {
    use crate::model::equations::Offers;

    #[test]
    fn stops_are_listed_for_all_contacts_or_for_none() {
        let stops = Offers { stops: &[[false; 2], [true, false]], ..Offers::default() };
        assert_eq!(stops.rigid_edges(3), [[false; 2], [true, false], [false; 2]]);
        assert_eq!(stops.first_stop(), Some(1));
        let none = Offers { stops: &[[false; 2]; 2], ..Offers::default() };
        assert!(none.rigid_edges(2).is_empty() && none.first_stop().is_none());
    }
}
