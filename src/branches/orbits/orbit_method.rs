//! What a continuation asks of the method by which orbits are computed.

use crate::branches::curve::equations::{Curve, CurveError};
use crate::branches::curve::point::CurvePoint;
use crate::branches::family::Family;
use crate::branches::orbits::measured::Measured;
use crate::model::{Channel, State};
use crate::periodic::Multipliers;
use nalgebra::DVector;

/// A curve whose points are periodic orbits.
pub(crate) trait Orbits: Curve {
    /// The orbit that is kept for each point.
    type Orbit: Clone;

    /// Floquet multipliers at a point; `None` if they were not found. Default: they are not compared.
    fn multipliers(&self, point: &CurvePoint<Self::Solution>) -> Option<Multipliers> {
        let _ = point;
        None
    }
    /// Whether the next point is predicted from the last two points rather than along the tangent. Default:
    /// no.
    fn predicts_from_two_points(&self) -> bool {
        false
    }
    /// The orbit of a point, and its multipliers with their error.
    fn orbit(&self, point: &CurvePoint<Self::Solution>) -> Result<(Self::Orbit, Multipliers), CurveError>;
    /// Number of periods of the model in the orbit of a point, and its first state; `None` if it was not
    /// found.
    fn first_state(&self, point: &CurvePoint<Self::Solution>) -> Option<(usize, State)>;
    /// Figures of the orbit of a point.
    fn measure(
        &self,
        point: &CurvePoint<Self::Solution>,
        channels: &[Channel],
    ) -> Result<Measured, CurveError>;
    /// A shift of the nodes, in periods, that keeps them clear of impacts at these phases; `None` if they are
    /// clear. Default: `None`.
    fn clear_of(&self, impacts: &[f64]) -> Option<f64> {
        let _ = impacts;
        None
    }
    /// The unknowns of a point on nodes that lie later by `shift` periods. Default: those of the point.
    fn shifted(&self, point: &CurvePoint<Self::Solution>, shift: f64) -> Result<DVector<f64>, CurveError> {
        let _ = shift;
        Ok(point.x.clone())
    }
    /// Moves the nodes by `shift` periods. `x`: the unknowns of an orbit on them.
    fn shift_nodes(&mut self, shift: f64, x: &DVector<f64>) {
        let _ = (shift, x);
    }
    /// Takes over the units of an accepted point.
    fn accept(&mut self, point: &CurvePoint<Self::Solution>, measured: &Measured);
}

/// A method by which the orbits of a branch are computed: shooting or balance.
pub(crate) trait OrbitMethod: Orbits {
    /// The family of models.
    fn family(&self) -> &Family<'_>;
    /// The unknowns of an orbit.
    fn unknowns(&self, orbit: &Self::Orbit) -> DVector<f64>;
    /// Whether a multiplier passes 1 at every fold, to rounding. Default: yes.
    fn multipliers_pass_at_folds(&self) -> bool {
        true
    }
    /// Whether x(t + T/2) = -x(t) along the orbit of a point.
    fn is_symmetric(&self, point: &CurvePoint<Self::Solution>) -> bool;
}
