//! Equations whose solutions form a curve.

use crate::error::ParameterError;
use crate::ode::{Exhausted, IntegrateError};
use crate::periodic::BalanceError;
use nalgebra::{DMatrix, DVector};
use thiserror::Error;

/// Step of one-sided differences with respect to the parameter, as a share of its unit.
pub(crate) const PARAMETER_STEP: f64 = 1e-6;

/// G(x, p) = 0 with as many equations as unknowns x.
pub(crate) trait Curve {
    /// What an evaluation computes besides G: for orbits, the states and transition matrices.
    type Solution: Clone;

    /// Evaluates G and its derivatives.
    fn linearise(&mut self, x: &DVector<f64>, p: f64) -> Result<Linear<Self::Solution>, CurveError>;
    /// Size of each unknown, over the square root of the number of unknowns: the unit in which steps are
    /// measured.
    fn units(&self) -> DVector<f64>;
    /// A correction up to this size `[1]` is made and is the last one, since the corrections converge
    /// quadratically. Default: 0, corrections end by the tolerance alone.
    fn last_correction(&self) -> f64 {
        0.0
    }
    /// Whether the curve is piecewise smooth, so that its tangent turns at corners: a branch of a sampled
    /// balance with contacts. Default: no.
    fn has_corners(&self) -> bool {
        false
    }
}

/// G and its derivatives at one place.
#[derive(Clone, Debug)]
pub(crate) struct Linear<S> {
    /// G, in units of the size of each equation.
    pub(crate) residual: DVector<f64>,
    /// ∂G/∂x.
    pub(crate) by_x: DMatrix<f64>,
    /// ∂G/∂p.
    pub(crate) by_p: DVector<f64>,
    pub(crate) solution: S,
}

/// Reasons for which a point of a curve was not found.
///
/// ```
/// use gear_dynamics::branches::CurveError;
/// let error = CurveError::NotConverged { corrections: vec![0.1, 0.2] };
/// let text = "2 corrections did not converge; the last one is 2e-1 of the size of the orbit";
/// assert_eq!(error.to_string(), text);
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CurveError {
    /// There is no model with this parameter.
    #[error("no model with the parameter {parameter:?}: {error}")]
    Model {
        /// The parameter.
        parameter: f64,
        /// The reason.
        error: ParameterError,
    },
    /// The equations of the balance cannot be set up for this parameter.
    #[error("no equations of a balance with the parameter {parameter:?}: {error}")]
    Balance {
        /// The parameter.
        parameter: f64,
        /// The reason.
        error: Box<BalanceError>,
    },
    /// An integration along the orbit failed.
    #[error("the integration over segment {segment} failed: {error}")]
    Integrate {
        /// Index of the segment, from 0.
        segment: usize,
        /// The reason.
        error: IntegrateError,
    },
    /// The equations do not determine the point: more than one direction is free.
    #[error("the equations with the arclength condition are singular: the point is a branch point")]
    Singular,
    /// The equations are not satisfied: the orbit is that of another model or parameter, or the start does
    /// not lie on the boundary.
    #[error(
        "this is no orbit of the model with these constants: the residual is {residual:e} of the size of the motion"
    )]
    NoSolution {
        /// The largest residual `[1]`.
        residual: f64,
    },
    /// The corrections do not become small.
    #[error(
        "{} corrections did not converge; the last one is {:e} of the size of the orbit",
        corrections.len(), corrections.last().copied().unwrap_or(f64::NAN)
    )]
    NotConverged {
        /// Size of each correction, as a share of the range of motion `[1]`.
        corrections: Vec<f64>,
    },
    /// The curve turned by too large an angle over the step: another branch was reached, or the step is too
    /// long.
    #[error("the tangent turned by {angle:?} rad over a step of {step:e}")]
    Turned {
        /// The angle `[rad]`.
        angle: f64,
        /// Length of the step `[1]`.
        step: f64,
    },
    /// A change over the step was not located.
    #[error(
        "between the last point and the next one {what}, and the search did not find at which parameter: follow \
         the branch with a smaller max_step, or start beyond this place"
    )]
    Unexplained {
        /// What happened.
        what: &'static str,
    },
    /// What vanishes along a boundary no longer exists: the extremum of a contact, or a pair of complex
    /// multipliers.
    #[error("the boundary ends: its extremum or its pair of multipliers is gone")]
    BoundaryEnds,
    /// The orbits of a boundary would pass through a rigid stop that was left out because they graze it
    /// elsewhere.
    #[error("contact {contact} would pass its rigid stop at another time than that of the grazing")]
    Strikes {
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// The derivatives of a multiplier differ on both sides: the orbit grazes an edge.
    #[error("the derivative differs for increasing and decreasing constants: the orbit grazes an edge")]
    OneSided,
    /// A limit of the budget was reached.
    #[error("{0}")]
    Exhausted(#[from] Exhausted),
}
