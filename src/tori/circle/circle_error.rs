//! Errors of invariant circles.

use crate::error::ParameterError;
use crate::ode::{Exhausted, IntegrateError};
use crate::tori::circle::invariant_circle::InvariantCircle;
use crate::tori::quasi_periodic::QuasiPeriodicError;
use thiserror::Error;

/// Errors of [`CircleShooting`](crate::tori::CircleShooting).
///
/// ```
/// use gear_dynamics::{State, tori::{CircleError, CircleShooting, ClosedCurve}, model::from_fn};
/// // q'' - (1 - q²) q' + q = 0: its circle needs more than 15 nodes
/// let van_der_pol = from_fn(1, |_, q, v, a| a[0] = (1.0 - q[0] * q[0]) * v[0] - q[0])?;
/// let van_der_pol = van_der_pol.with_period(2.0)?;
/// let round = |j: usize| {
///     let angle = std::f64::consts::TAU * j as f64 / 15.0;
///     State::new(0.0, &[2.0 * angle.cos()], &[-2.0 * angle.sin()])
/// };
/// let guess = ClosedCurve::new(&(0..15).map(round).collect::<Vec<_>>())?;
/// let error = CircleShooting::new().solve_free(&van_der_pol, &guess, 1.9).unwrap_err();
/// let CircleError::Between { tolerance, last } = error else { panic!("the nodes are too few") };
/// assert!(last.residual() < 1e-9 && last.residual_between() > tolerance);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CircleError {
    /// A guess or a setting is not valid.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The drives of the model are not functions of its angles.
    #[error(transparent)]
    Drives(#[from] QuasiPeriodicError),
    /// The points do not determine a curve with so many nodes: they are too few, or they repeat, as on an
    /// orbit of a few periods.
    #[error(
        "{points} points at the rotation {rotation:?} do not determine {nodes} nodes: they are too few, or the \
         motion is periodic"
    )]
    Unspread {
        /// Number of points.
        points: usize,
        /// Rotation from point to point `[rad]`.
        rotation: f64,
        /// Number of nodes.
        nodes: usize,
    },
    /// The points lie far from the closed curve that fits them best.
    #[error(
        "the points lie {distance:.2} of their range from the closest curve in the root mean square, and at most \
         {allowed} is accepted: the motion is chaotic, or the torus has several circles, as one that is doubled in \
         the strobed drive (take every second point and CircleShooting::period_multiple(2)), or is doubled in \
         the other drive (strobe that one), or the rotation is that of another angle"
    )]
    Scattered {
        /// Root mean square distance, as a share of the range, for the component with the largest one `[1]`.
        distance: f64,
        /// Largest accepted distance `[1]`.
        allowed: f64,
    },
    /// The orbit has no pair of complex multipliers from which a circle could begin.
    #[error(
        "the orbit has no pair of complex multipliers: its largest multiplier has the modulus {largest:?}"
    )]
    NoPair {
        /// Largest modulus of a multiplier `[1]`.
        largest: f64,
    },
    /// An integration over one period of the map failed.
    #[error("the integration from node {node} failed: {error}")]
    Integrate {
        /// Index of the node, from 0. The midpoint after node j counts as node j.
        node: usize,
        /// Error of the integration.
        error: IntegrateError,
        /// The last iterate; `None` before the first evaluation.
        last: Option<Box<InvariantCircle>>,
    },
    /// The equations do not determine the circle.
    #[error(
        "the equations of the circle are singular after {} iterations; unknown {unknown} of (states of the \
         nodes, rotation) is determined least: the circle is at a bifurcation, or it is locked to a periodic \
         orbit",
        last.iterations()
    )]
    Singular {
        /// Index of the unknown, from 0: node times components plus component.
        unknown: usize,
        /// The last iterate.
        last: Box<InvariantCircle>,
    },
    /// Newton's method did not converge.
    #[error(
        "the circle did not converge in {} iterations: the last residual is {:?} of the range, and no correction was \
         within {tolerance:?} of it, the tolerance; start nearer to the circle, or, if the residual is of the order of \
         flow_tolerance, raise the tolerance of newton: the motion amplifies the errors of its flow",
        last.iterations(), last.residual()
    )]
    NotConverged {
        /// The last iterate; it is not a circle of the model.
        last: Box<InvariantCircle>,
        /// Tolerance of a correction, as a share of the range `[1]`.
        tolerance: f64,
    },
    /// The iteration ended in a fixed point of the map.
    #[error(
        "the circle shrank to {share:?} of the guess, that is, to a periodic orbit: start with a larger \
         amplitude or nearer to the circle"
    )]
    Collapsed {
        /// Size of the circle over that of the guess `[1]`.
        share: f64,
        /// The circle.
        last: Box<InvariantCircle>,
    },
    /// The equations are satisfied at the nodes, but not between them.
    #[error(
        "the residual between the nodes is {:?} of the range and at most {tolerance:?} is accepted: {} nodes are \
         too few",
        last.residual_between(), last.curve().nodes()
    )]
    Between {
        /// Largest accepted residual between the nodes `[1]`.
        tolerance: f64,
        /// The circle: its equations are satisfied at the nodes.
        last: Box<InvariantCircle>,
    },
    /// The [`Budget`](crate::Budget) is spent, or the call was cancelled.
    #[error("the search for the circle stopped: {exhausted}")]
    Exhausted {
        /// The limit that was reached.
        exhausted: Exhausted,
        /// The last iterate; `None` before the first evaluation.
        last: Option<Box<InvariantCircle>>,
    },
}

impl CircleError {
    /// The last iterate, if the iteration began.
    pub fn last(&self) -> Option<&InvariantCircle> {
        match self {
            CircleError::Integrate { last, .. } | CircleError::Exhausted { last, .. } => last.as_deref(),
            CircleError::Singular { last, .. }
            | CircleError::NotConverged { last, .. }
            | CircleError::Collapsed { last, .. }
            | CircleError::Between { last, .. } => Some(last),
            _ => None,
        }
    }
}
