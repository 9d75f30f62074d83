//! Models whose drives are changed by a rule: the base of all wrappers.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::equations::each_row;
use crate::model::expansion::expand::{Expand, Recorded};
use crate::model::{Jacobian, Model, Offers};
use crate::series::Series;
use crate::tape::recording::Recording;

/// A rule that changes the drives of a model. Algebra, contacts and channels remain those of the model.
pub trait DriveRule<M: Model + ?Sized> {
    /// Writes all drives at `t` to `u`. `side`: before or after a jump at `t`.
    fn drive(&self, model: &M, t: f64, side: Side, u: &mut [f64]);
    /// The first instant after `t` at which a drive jumps or has a kink; `None` if there is none.
    fn next_edge(&self, model: &M, t: f64) -> Option<f64>;
    /// The first instant after `t` at which a wave has a knot. See [`Model::next_knot`]. Default: that of
    /// the model. A rule that changes the speed or adds waves implements it.
    fn next_knot(&self, model: &M, t: f64) -> Option<f64> {
        model.next_knot(t)
    }
    /// Whether the rule changes a drive. Default: `true` for all.
    fn changes(&self, model: &M, drive: usize) -> bool {
        let _ = (model, drive);
        true
    }
    /// Writes all drives after `t` to `u` as series, for [`Taylor`](crate::Taylor). See
    /// [`Expand::drive_series`]. Default: refused.
    fn series(&self, model: &M, t: f64, coefficients: usize, u: &mut [Series]) {
        let _ = (model, t, coefficients);
        u.fill(Series::refused("a drive rule without `DriveRule::series`"));
    }
}

/// A model with its drives changed by a rule.
///
/// [`Noisy`](crate::drives::Noisy) adds random processes, [`Driven`](crate::drives::Driven) adds functions of
/// time, and [`VaryingSpeed`](crate::drives::VaryingSpeed) replaces the constant speed by a speed law. The
/// result is not [`Periodic`](crate::Periodic), even if the model is.
///
/// ```
/// use gear_dynamics::{drives::{rules::DriveRule, rules::Wrapped}, Model, NfgPair, NfgParams, excitation::Side};
/// struct Doubled; // doubles the first drive
/// impl<M: Model> DriveRule<M> for Doubled {
///     fn drive(&self, model: &M, t: f64, side: Side, u: &mut [f64]) {
///         model.drive(t, side, u);
///         u[0] *= 2.0;
///     }
///     fn next_edge(&self, model: &M, t: f64) -> Option<f64> { model.next_edge(t) }
/// }
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let (mut u, mut w) = (vec![0.0; pair.drives()], vec![0.0; pair.drives()]);
/// pair.drive(1.0, Side::After, &mut u);
/// Wrapped::by_rule(pair, Doubled).drive(1.0, Side::After, &mut w);
/// assert_eq!(w[0], 2.0 * u[0]);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Wrapped<M, R> {
    model: M,
    rule: R,
}

impl<M, R> Wrapped<M, R> {
    /// A model and a rule for its drives.
    pub fn by_rule(model: M, rule: R) -> Self
    where
        M: Model,
        R: DriveRule<M>,
    {
        Wrapped { model, rule }
    }
    /// The wrapped model, without the rule.
    pub fn bare(&self) -> &M {
        &self.model
    }
    /// The rule.
    pub fn rule(&self) -> &R {
        &self.rule
    }
    pub(crate) fn map_rule<E>(self, change: impl FnOnce(&M, R) -> Result<R, E>) -> Result<Self, E> {
        let rule = change(&self.model, self.rule)?;
        Ok(Wrapped { model: self.model, rule })
    }
}

/// Writes the series of the model's own drives to `u`, for rules that add to them.
pub(crate) fn own_series(model: &impl Model, t: f64, coefficients: usize, u: &mut [Series]) {
    if let Some(expanded) = model.offers().expansion {
        expanded.drive_series(t, coefficients, u);
    }
}

/// It has no named constants: [`Constants::with_values`](crate::model::recording::Constants::with_values)
/// would return a model without the rule.
impl<M: Model, R: DriveRule<M>> Model for Wrapped<M, R> {
    fn dof(&self) -> usize {
        self.model.dof()
    }
    #[inline]
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.model.accel(u, q, v, a);
    }
    fn base(&self) -> Option<&dyn Model> {
        Some(&self.model)
    }
    /// Constants act through drives, which the rule changes.
    fn offers(&self) -> Offers<'_> {
        let own = self.model.offers();
        Offers { constants: None, expansion: own.expansion.and(Some(self)), ..own }
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.rule.drive(&self.model, t, side, u);
    }
    fn redrive(&self, times: &[f64], side: Side, u: &mut [f64]) {
        each_row(self.drives(), times, u, |t, u| self.drive(t, side, u));
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.rule.next_edge(&self.model, t)
    }
    fn next_knot(&self, t: f64) -> Option<f64> {
        self.rule.next_knot(&self.model, t)
    }
    #[inline]
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.model.contact(u, q, v, out);
    }
    #[inline]
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.model.accel_on_pieces(pieces, u, q, v, a);
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        self.model.jacobian(pieces, u, q, v, out);
    }
}

impl<M: Model, R: DriveRule<M>> Expand for Wrapped<M, R> {
    fn record(&self, moving: &dyn Fn(usize) -> bool) -> Recorded {
        match self.model.offers().expansion {
            Some(expanded) => {
                expanded.record(&|drive| moving(drive) || self.rule.changes(&self.model, drive))
            }
            None => Recorded(Recording::new(self.dof(), self.drives()).finish(Vec::new(), Vec::new())),
        }
    }
    fn entries(
        &self,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        entry: &mut dyn FnMut(usize, usize, f64),
    ) -> bool {
        self.model.offers().expansion.is_some_and(|expanded| expanded.entries(pieces, u, q, v, entry))
    }
    fn drive_series(&self, t: f64, coefficients: usize, u: &mut [Series]) {
        self.rule.series(&self.model, t, coefficients, u);
    }
}
