//! Shooting for invariant circles: settings and solution.

use crate::error::{ParameterError, check};
use crate::model::{Periodic, State};
use crate::ode::Budget;
use crate::periodic::FlowMethod;
use crate::periodic::flow::flow_method::Chosen;
use crate::periodic::flow::walk::SegmentError;
use crate::periodic::metered::RootFailure;
use crate::roots::matrix::MAX_ENTRIES;
use crate::roots::{Newton, Root, RootFinder};
use crate::tori::circle::circle_equations::CircleEquations;
use crate::tori::circle::circle_error::CircleError;
use crate::tori::circle::closed_curve::{ClosedCurve, checked_nodes};
use crate::tori::circle::invariant_circle::InvariantCircle;
use crate::tori::circle::strobed::Strobed;
use crate::tori::quasi_periodic::{QuasiPeriodic, checked_frequencies};
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// P(x(θ)) = x(θ + ρ): invariant circles of the stroboscopic map P by shooting from nodes on the circle.
///
/// The circle is a trigonometric polynomial through nodes at equidistant θ. The equation holds at the nodes;
/// Newton's method solves it with the exact derivative of the flow, tooth edges located. After the solution
/// the equation is evaluated midway between the nodes. A circle whose residual there exceeds
/// [`between`](CircleShooting::between) is an error, [`CircleError::Between`], that holds the circle.
///
/// Newton's method finds stable and unstable circles alike: [`InvariantCircle::growth`] tells them apart.
/// Where it is above 0, runs settle elsewhere, for example on a torus that is doubled in one drive
/// ([`period_multiple`](CircleShooting::period_multiple)).
///
/// - [`solve`](CircleShooting::solve): two base frequencies ω_1, ω_2. P is the flow over 2π/ω_1, θ the second
///   angle, and ρ = 2π ω_2/ω_1 is known.
/// - [`solve_free`](CircleShooting::solve_free): a model with one period, whose circle arises at a
///   Neimark-Sacker point. ρ is an unknown, and the phase condition Σ_j (x_j - g_j)·g'_j = 0 with the guess g
///   fixes the origin of θ.
///
/// Where teeth lose contact the circle is continuous but not smooth at grazing points, and the residual
/// between the nodes decreases with a power of their number.   Source: Kaas-Petersen, Physica D 25 (1987)
/// 288; Schilder, Osinga and Vogt, SIAM J. Appl. Dyn. Syst. 4 (2005) 459.
///
/// ```
/// use gear_dynamics::{Model, excitation::Side, tori::*};
/// struct Duffing; // q'' + 0.1 q' + q + 0.2 q³ = 0.3 cos 0.7t + 0.2 cos 0.7√3t
/// impl Model for Duffing {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
///         a[0] = u[0] - 0.1 * v[0] - q[0] - 0.2 * q[0].powi(3);
///     }
///     fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
///         self.drive_at(&[0.7 * t, 0.7 * 3f64.sqrt() * t], side, u);
///     }
/// }
/// impl QuasiPeriodic for Duffing {
///     fn frequencies(&self) -> Vec<f64> { vec![0.7, 0.7 * 3f64.sqrt()] }
///     fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
///         u[0] = 0.3 * angles[0].cos() + 0.2 * angles[1].cos();
///     }
/// }
/// let balance = TorusBalance::new(WaveVectors::within(&[5, 5])?);
/// let coarse = balance.solve(&Duffing, &balance.at_rest(&Duffing, &[0.0])?)?;
/// let circle = CircleShooting::new().solve(&Duffing, &coarse.section(0, 31)?)?;
/// assert!((circle.at(0.0).q[0] + 0.004_735_427_589).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct CircleShooting {
    nodes: Option<usize>,
    strobe: usize,
    multiple: usize,
    between: f64,
    flow_tolerance: f64,
    method: Chosen,
    newton: Option<Newton>,
    budget: Budget,
}

impl Default for CircleShooting {
    fn default() -> Self {
        CircleShooting::new()
    }
}

/// Tolerance of Newton's method over that of the flow `[1]`.
const NOISE: f64 = 1e3;

/// Smallest default tolerance of Newton's method, that of [`Newton::new`] `[1]`.
const NEWTON: f64 = 1e-10;

/// Maximum number of periods of the drives in one period of the map.
const MAX_MULTIPLE: usize = 1_000_000;

/// A circle of less than this share of the guess is a fixed point `[1]`.
const COLLAPSED: f64 = 1e-6;

impl CircleShooting {
    /// Defaults: the nodes of the guess, the first base frequency strobed, at most 1e-6 of the range as
    /// residual between the nodes, flow tolerance 1e-13, Newton's method with its default settings, the
    /// default [`Budget`].
    pub fn new() -> Self {
        CircleShooting {
            nodes: None,
            strobe: 0,
            multiple: 1,
            between: 1e-6,
            flow_tolerance: 1e-13,
            method: Chosen::ByModel,
            newton: None,
            budget: Budget::new(),
        }
    }
    /// Number of nodes, odd, at least 3. Default: that of the guess.
    pub fn nodes(self, nodes: usize) -> Self {
        CircleShooting { nodes: Some(nodes), ..self }
    }
    /// Index of the base frequency that is strobed, 0 or 1, for [`solve`](CircleShooting::solve). Default: 0.
    /// The circle depends on the other angle: strobe the higher frequency to save time, the other one if the
    /// motion has high orders of the lower one.
    pub fn strobed_frequency(self, strobe: usize) -> Self {
        CircleShooting { strobe, ..self }
    }
    /// Number p of periods of the strobed drive in one period of the map, 1 to 10⁶. Default: 1. A torus that
    /// is doubled in the strobed drive has two circles, which the map exchanges: p = 2 finds each of them,
    /// from a guess by every second point. A torus that is doubled in the other drive needs the other
    /// [strobed frequency](CircleShooting::strobed_frequency).
    pub fn period_multiple(self, multiple: usize) -> Self {
        CircleShooting { multiple, ..self }
    }
    /// Largest accepted residual midway between the nodes, as a share of the range of motion of each
    /// coordinate and velocity `[1]`. Default: 1e-6.
    pub fn between(self, between: f64) -> Self {
        CircleShooting { between, ..self }
    }
    /// Local error of the integration, as a share of the same ranges `[1]`. Default: 1e-13. The rounding
    /// error of a component replaces it where that is larger.
    pub fn flow_tolerance(self, flow_tolerance: f64) -> Self {
        CircleShooting { flow_tolerance, ..self }
    }
    /// The method of the integration. Default: Taylor series for a model with one period that can be
    /// expanded, DOP853 for any other.
    pub fn flow_method(self, method: FlowMethod) -> Self {
        CircleShooting { method: Chosen::Method(method), ..self }
    }
    /// Settings of Newton's method. Default: those of [`Newton::new`], with a tolerance of 10³ flow
    /// tolerances if that is larger, since the flow is noisy below.
    pub fn newton(self, newton: Newton) -> Self {
        CircleShooting { newton: Some(newton), ..self }
    }
    /// Maximum number of steps and maximum time of one call, over all its integrations.
    pub fn budget(self, budget: Budget) -> Self {
        CircleShooting { budget, ..self }
    }

    /// Finds the circle of a model with two base frequencies. The strobed angle of the guess is ω t at its
    /// time t, and θ is the other angle.
    ///
    /// # Errors
    /// [`CircleError`]; [`CircleError::last`] returns the last iterate.
    pub fn solve(
        &self,
        model: &dyn QuasiPeriodic,
        guess: &ClosedCurve,
    ) -> Result<InvariantCircle, CircleError> {
        let frequencies = checked_frequencies(model)?;
        check::length("frequencies", frequencies.len(), 2)?;
        check::count("strobed_frequency", &[self.strobe], 1)?;
        let frequencies = [frequencies[0], frequencies[1]];
        self.find(
            &Strobed::TwoAngles { model, frequencies, strobe: self.strobe, multiple: self.multiple },
            guess,
            0.0,
        )
    }

    /// Finds a circle of a model with one period from a guess and its rotation `[rad]`.
    ///
    /// # Errors
    /// [`CircleError`]; [`CircleError::last`] returns the last iterate.
    pub fn solve_free(
        &self,
        model: &dyn Periodic,
        guess: &ClosedCurve,
        rotation: f64,
    ) -> Result<InvariantCircle, CircleError> {
        check::scale("period of the model", model.period())?;
        check::quantity("rotation", rotation)?;
        self.find(&Strobed::Periodic(model, self.multiple), guess, rotation)
    }

    fn find(
        &self,
        strobed: &Strobed<'_>,
        guess: &ClosedCurve,
        rotation: f64,
    ) -> Result<InvariantCircle, CircleError> {
        let guess = self.checked(strobed.dof(), guess)?;
        let meter = self.budget.begin();
        let failed = |failure: SegmentError, last: Option<InvariantCircle>| {
            let SegmentError { segment: node, error } = failure;
            let last = last.map(Box::new);
            match meter.exhausted() {
                Some(exhausted) => CircleError::Exhausted { exhausted, last },
                None => CircleError::Integrate { node, error, last },
            }
        };
        let mut equations = CircleEquations::new(strobed, &guess, self.flow_tolerance, &self.method, &meter)
            .map_err(|failure| failed(failure, None))?;
        let x = equations.unknowns(&guess, rotation);
        let tolerance = (NOISE * self.flow_tolerance).clamp(NEWTON, 0.1);
        let newton = self.newton.unwrap_or(Newton::new().tolerance(tolerance));
        let root = newton.solve(&mut equations, &x);
        let circle = |root: &Root, equations: &CircleEquations<'_>| {
            let (curve, rotation) = equations.curve(&root.x);
            InvariantCircle {
                curve,
                rotation,
                period: strobed.period(),
                ranges: equations.ranges.clone(),
                residual: root.residual,
                between: f64::NAN,
                growth: f64::NAN,
                growth_error: f64::NAN,
                residuals: root.residuals.clone(),
                crossings: equations.crossings,
                method: equations.method(),
            }
        };
        let mut found = match root {
            Ok(root) => circle(&root, &equations),
            Err(error) => {
                let (failure, root) = RootFailure::of(error, &meter)?;
                let last = Box::new(circle(&root, &equations));
                return Err(match (failure, equations.failure.take()) {
                    (RootFailure::Exhausted(exhausted), _) => {
                        CircleError::Exhausted { exhausted, last: Some(last) }
                    }
                    // The residual is NaN where an integration failed.
                    (RootFailure::NotFinite | RootFailure::Slope { .. }, Some(failure)) => {
                        failed(failure, Some(*last))
                    }
                    (RootFailure::Singular { unknown }, _) => CircleError::Singular { unknown, last },
                    _ => CircleError::NotConverged { last, tolerance: newton.tolerance },
                });
            }
        };
        let size = |curve: &ClosedCurve| {
            curve.ranges().iter().zip(&equations.units).fold(0.0f64, |m, (range, unit)| m.max(range / unit))
        };
        let share = size(&found.curve) / size(&guess);
        if strobed.rotation().is_none() && share < COLLAPSED {
            return Err(CircleError::Collapsed { share, last: Box::new(found) });
        }
        let middle;
        (found.between, middle) = match between(&equations, &found) {
            Ok(between) => between,
            Err(failure) => return Err(failed(failure, Some(found))),
        };
        if found.between <= self.between {
            [found.growth, found.growth_error] = equations.growth(&found.curve, found.rotation, &middle);
            // The errors of the flow are those of the transitions, too.
            found.growth_error += self.flow_tolerance;
            Ok(found)
        } else {
            Err(CircleError::Between { tolerance: self.between, last: Box::new(found) })
        }
    }

    /// The guess on the nodes of the settings, after a check of all settings.
    fn checked(&self, dof: usize, guess: &ClosedCurve) -> Result<ClosedCurve, CircleError> {
        check::positive("between", self.between)?;
        check::at_least("period_multiple", self.multiple, 1)?;
        check::count("period_multiple", &[self.multiple], MAX_MULTIPLE)?;
        check::tolerance("flow_tolerance", self.flow_tolerance)?;
        check::length("coordinates of the curve", guess.dof(), dof)?;
        let nodes = checked_nodes(self.nodes.unwrap_or(guess.nodes()))?;
        let unknowns = nodes * guess.width() + 1;
        check::count("entries of the Jacobian", &[unknowns, unknowns], MAX_ENTRIES)?;
        let guess = if nodes == guess.nodes() { guess.clone() } else { guess.with_nodes(nodes)? };
        if guess.ranges().iter().all(|range| *range == 0.0) {
            let name = "range of the guess".into();
            return Err(ParameterError::NotPositive { name, value: 0.0 }.into());
        }
        Ok(guess)
    }
}

/// Largest |P(x(θ)) - x(θ + ρ)| midway between the nodes, as a share of the range, and the derivatives of P
/// there.
fn between(
    equations: &CircleEquations<'_>,
    circle: &InvariantCircle,
) -> Result<(f64, Vec<DMatrix<f64>>), SegmentError> {
    let nodes = circle.curve.nodes();
    let all = |s: State| s.q.into_iter().chain(s.v).collect::<Vec<f64>>();
    let (mut largest, mut transitions) = (0.0f64, Vec::with_capacity(nodes));
    for j in 0..nodes {
        let theta = TAU * (j as f64 + 0.5) / nodes as f64;
        let (end, transition, _) =
            equations.map(theta, &circle.at(theta)).map_err(|error| SegmentError { segment: j, error })?;
        let (end, on_curve) = (all(end), all(circle.at(theta + circle.rotation)));
        for ((a, b), range) in end.iter().zip(&on_curve).zip(&circle.ranges) {
            largest = largest.max((a - b).abs() / range);
        }
        transitions.push(transition);
    }
    Ok((largest, transitions))
}
