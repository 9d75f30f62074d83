//! Invariant circles.

use crate::model::State;
use crate::periodic::FlowMethod;
use crate::tori::circle::closed_curve::ClosedCurve;

/// P(x(θ)) = x(θ + ρ): an invariant circle of the stroboscopic map P, a section of a torus.
///
/// ```
/// use gear_dynamics::{State, tori::{CircleShooting, ClosedCurve}, model::from_fn};
/// // q'' - 0.1 (1 - q²) q' + q = 0, strobed at the period 2
/// let van_der_pol = from_fn(1, |_, q, v, a| a[0] = 0.1 * (1.0 - q[0] * q[0]) * v[0] - q[0])?;
/// let van_der_pol = van_der_pol.with_period(2.0)?;
/// let round = |j: usize| {
///     let angle = std::f64::consts::TAU * j as f64 / 25.0;
///     State::new(0.0, &[2.0 * angle.cos()], &[-2.0 * angle.sin()])
/// };
/// let guess = ClosedCurve::new(&(0..25).map(round).collect::<Vec<_>>())?;
/// let circle = CircleShooting::new().solve_free(&van_der_pol, &guess, 2.0)?;
/// // The frequency is 1 - ε²/16 + 17 ε⁴/3072 with ε = 0.1 (Linstedt and Poincaré).
/// let frequency = 1.0 - 0.01 / 16.0 + 17e-4 / 3072.0;
/// assert!((circle.rotation() - 2.0 * frequency).abs() < 1e-7);
/// assert!(circle.residual_between() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct InvariantCircle {
    pub(crate) curve: ClosedCurve,
    pub(crate) rotation: f64,
    pub(crate) period: f64,
    pub(crate) ranges: Vec<f64>,
    pub(crate) residual: f64,
    pub(crate) between: f64,
    pub(crate) growth: f64,
    pub(crate) growth_error: f64,
    pub(crate) residuals: Vec<f64>,
    pub(crate) crossings: u64,
    pub(crate) method: FlowMethod,
}

impl InvariantCircle {
    /// The circle as a closed curve: its nodes and the interpolation between them.
    pub fn curve(&self) -> &ClosedCurve {
        &self.curve
    }
    /// The state at θ `[rad]`. With two base frequencies θ is the angle that is not strobed.
    pub fn at(&self, theta: f64) -> State {
        self.curve.at(theta)
    }
    /// Rotation ρ over one period of the map `[rad]`.
    pub fn rotation(&self) -> f64 {
        self.rotation
    }
    /// Period of the map, in the time unit of the model.
    pub fn period(&self) -> f64 {
        self.period
    }
    /// Units of the residuals: the range of motion of each coordinate, then of each velocity, over one period
    /// from the guess.
    pub fn range(&self) -> &[f64] {
        &self.ranges
    }
    /// Largest |P(x(θ_j)) - x(θ_j + ρ)| at the nodes, as a share of the range `[1]`, or of 16 rounding errors
    /// over the flow tolerance where that is larger.
    pub fn residual(&self) -> f64 {
        self.residual
    }
    /// Largest |P(x(θ)) - x(θ + ρ)| midway between the nodes, as a share of the range `[1]`: the error of the
    /// interpolation in one step of the map. NaN for an iterate that did not converge.
    pub fn residual_between(&self) -> f64 {
        self.between
    }
    /// Mean logarithm of the growth of perturbations over one period of the map, for the direction that grows
    /// most `[1]`: the largest Lyapunov exponent across the circle, times the period. Above 0 the circle
    /// repels: no run settles on it. NaN for an iterate that did not converge.
    ///
    /// It is a weighted mean of the growth of the subspace of all directions that grow alike, by the
    /// derivative of the map, interpolated between the nodes. The growth of a subspace does not depend on
    /// how slowly a perturbation turns in it. The mean is that over 4096 periods or, where that is more,
    /// over those in which the points of the map go round the circle 16 times. NaN if that takes more than
    /// 2^18 periods: the rotation is too near a whole number of turns, or a ratio p/q of one with q up to
    /// 8. NaN also if the budget is spent before.
    /// A perturbation along the circle of [`solve_free`](crate::tori::CircleShooting::solve_free), which
    /// neither grows nor decays, is left out.
    pub fn growth(&self) -> f64 {
        self.growth
    }
    /// Estimate of the error of [`growth`](InvariantCircle::growth) `[1]`: the distance from a second
    /// estimate, by the eigenvalues of the product over as many periods or up to twice as many; what the
    /// largest of these eigenvalues has above the mean of those beside it; the error of the interpolation
    /// midway between the nodes; 4e-6 of the variation of the growth along the circle, the flow tolerance and
    /// 1e-9. NaN where the growth is NaN.
    pub fn growth_error(&self) -> f64 {
        self.growth_error
    }
    /// Whether perturbations decay: [`growth`](InvariantCircle::growth) is below 0 by more than its error.
    /// `false` if it is NaN, and for a neutral circle, on which nothing grows and nothing decays.
    pub fn is_stable(&self) -> bool {
        self.growth < -self.growth_error
    }
    /// The largest residual of every iterate, the guess first. NaN where an integration failed.
    pub fn residuals(&self) -> &[f64] {
        &self.residuals
    }
    /// Number of Newton corrections.
    pub fn iterations(&self) -> usize {
        self.residuals.len().saturating_sub(1)
    }
    /// Number of tooth edges crossed in one period from all nodes together.
    pub fn crossing_count(&self) -> u64 {
        self.crossings
    }
    /// The method of the integration.
    pub fn flow_method(&self) -> FlowMethod {
        self.method
    }
}
