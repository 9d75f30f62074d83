//! Closed curves of states, interpolated by trigonometric polynomials.

use crate::error::{ParameterError, check};
use crate::model::State;
use std::f64::consts::TAU;

/// x(θ) = Σ_j D(θ - θ_j) x_j, θ_j = 2πj/M: a closed curve of states at one time, through M nodes.
///
/// D(s) = sin(M s/2)/(M sin(s/2)) for odd M: the curve is the trigonometric polynomial of order (M - 1)/2
/// through the nodes.
///
/// ```
/// use gear_dynamics::{State, tori::ClosedCurve};
/// let on_circle = |j: f64| State::new(0.0, &[(j * 0.4 * 3.141_592_653_589_793).cos()], &[0.0]);
/// let curve = ClosedCurve::new(&[0.0, 1.0, 2.0, 3.0, 4.0].map(on_circle))?;
/// assert!((curve.at(1.0).q[0] - 1f64.cos()).abs() < 1e-15);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedCurve {
    t: f64,
    width: usize,
    /// Coordinates and velocities, node by node.
    values: Vec<f64>,
}

/// Maximum number of nodes.
pub(crate) const MAX_NODES: usize = 1 << 16;

/// An odd number of nodes, at least 3.
pub(crate) fn checked_nodes(nodes: usize) -> Result<usize, ParameterError> {
    check::at_least("nodes", nodes, 3)?;
    check::count("nodes", &[nodes], MAX_NODES)?;
    if nodes.is_multiple_of(2) {
        let (name, value) = ("nodes".into(), nodes as f64);
        return Err(ParameterError::Wrong { name, value, must: "be odd".into() });
    }
    Ok(nodes)
}

/// D(s) = sin(M s/2)/(M sin(s/2)), for odd M.
fn kernel(nodes: usize, s: f64) -> f64 {
    let s = s - TAU * (s / TAU).round();
    let (m, below) = (nodes as f64, (0.5 * s).sin());
    if below.abs() < 1e-9 { 1.0 } else { (0.5 * m * s).sin() / (m * below) }
}

/// dD/ds = -(2/M) Σ_k k sin(k s), k = 1 .. (M - 1)/2.
fn kernel_rate(nodes: usize, s: f64) -> f64 {
    let sum: f64 = (1..=nodes / 2).map(|k| k as f64 * (k as f64 * s).sin()).sum();
    -2.0 * sum / nodes as f64
}

/// D(s - 2πd/M) for d = 0 .. M-1.
pub(crate) fn weights(nodes: usize, s: f64) -> Vec<f64> {
    let mut weights = vec![0.0; nodes];
    write_weights(s, &mut weights);
    weights
}

/// Writes the [`weights`] of as many nodes as there are places in `out`.
pub(crate) fn write_weights(s: f64, out: &mut [f64]) {
    let nodes = out.len();
    out.iter_mut().enumerate().for_each(|(d, out)| *out = kernel(nodes, s - TAU * d as f64 / nodes as f64));
}

/// Derivatives of the [`weights`] with respect to s.
pub(crate) fn weight_rates(nodes: usize, s: f64) -> Vec<f64> {
    (0..nodes).map(|d| kernel_rate(nodes, s - TAU * d as f64 / nodes as f64)).collect()
}

impl ClosedCurve {
    /// The curve through states at equidistant θ, the first at θ = 0.
    ///
    /// # Errors
    /// An even number of states, fewer than 3 or more than 65 536; states of different sizes or times;
    /// numbers beyond ±1e50.
    pub fn new(states: &[State]) -> Result<Self, ParameterError> {
        checked_nodes(states.len())?;
        let (t, dof) = (states[0].t, states[0].q.len());
        for (i, state) in states.iter().enumerate() {
            state.check(dof)?;
            if state.t != t {
                let (name, found) = (format!("time of state {i}"), state.t);
                return Err(ParameterError::Inconsistent { name, found, expected: t });
            }
        }
        check::at_least("coordinates", dof, 1)?;
        let values = states.iter().flat_map(|s| s.q.iter().chain(&s.v).copied()).collect();
        Ok(ClosedCurve { t, width: 2 * dof, values })
    }

    pub(crate) fn of(t: f64, width: usize, values: Vec<f64>) -> Self {
        ClosedCurve { t, width, values }
    }

    /// Time of the states.
    pub fn time(&self) -> f64 {
        self.t
    }
    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.values.len() / self.width
    }
    /// Number of coordinates.
    pub fn dof(&self) -> usize {
        self.width / 2
    }
    /// The states at the nodes.
    pub fn states(&self) -> Vec<State> {
        self.values.chunks_exact(self.width).map(|y| self.state(y)).collect()
    }
    fn state(&self, y: &[f64]) -> State {
        let (q, v) = y.split_at(self.width / 2);
        State::new(self.t, q, v)
    }
    /// Coordinates and velocities, node by node.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }
    /// Number of coordinates and velocities.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// The state at θ `[rad]`.
    pub fn at(&self, theta: f64) -> State {
        self.state(&self.weighted(&weights(self.nodes(), theta)))
    }
    /// dx/dθ at θ: the derivatives of coordinates and velocities.
    pub fn derivative(&self, theta: f64) -> State {
        self.state(&self.weighted(&weight_rates(self.nodes(), theta)))
    }
    fn weighted(&self, weights: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.width];
        for (w, y) in weights.iter().zip(self.values.chunks_exact(self.width)) {
            sum.iter_mut().zip(y).for_each(|(sum, y)| *sum += w * y);
        }
        sum
    }

    /// The same trigonometric polynomial through another number of nodes. Fewer nodes alias high orders.
    ///
    /// # Errors
    /// An even number of nodes, fewer than 3 or more than 65 536.
    pub fn with_nodes(&self, nodes: usize) -> Result<Self, ParameterError> {
        checked_nodes(nodes)?;
        let angle = |j: usize| TAU * j as f64 / nodes as f64;
        let values = (0..nodes).flat_map(|j| self.weighted(&weights(self.nodes(), angle(j)))).collect();
        Ok(ClosedCurve { t: self.t, width: self.width, values })
    }

    /// Range (max - min) of each coordinate, then of each velocity, over the nodes.
    pub(crate) fn ranges(&self) -> Vec<f64> {
        let mut limits = vec![[f64::INFINITY, f64::NEG_INFINITY]; self.width];
        for y in self.values.chunks_exact(self.width) {
            limits.iter_mut().zip(y).for_each(|([low, high], y)| (*low, *high) = (low.min(*y), high.max(*y)));
        }
        limits.iter().map(|[low, high]| high - low).collect()
    }

    /// Largest amplitude among the highest tenth of the orders, over the largest amplitude of all orders from
    /// 1 `[1]`: an estimate of the error by the orders that the nodes do not resolve. The largest value among
    /// coordinates and velocities.
    pub fn highest_share(&self) -> f64 {
        let (m, orders) = (self.nodes(), self.nodes() / 2);
        let first = orders - orders / 10;
        (0..self.width).fold(0.0, |most: f64, c| {
            let amplitude = |k: usize| {
                let (mut re, mut im) = (0.0, 0.0);
                for (j, y) in self.values.chunks_exact(self.width).enumerate() {
                    // k j modulo M keeps the angle accurate.
                    let (sin, cos) = (TAU * ((k * j) % m) as f64 / m as f64).sin_cos();
                    (re, im) = (re + y[c] * cos, im - y[c] * sin);
                }
                2.0 * f64::hypot(re, im) / m as f64
            };
            let all: Vec<f64> = (1..=orders).map(amplitude).collect();
            let most_of = |part: &[f64]| part.iter().fold(0.0f64, |m, a| m.max(*a));
            let largest = most_of(&all);
            if largest > 0.0 { most.max(most_of(&all[first - 1..]) / largest) } else { most }
        })
    }
}
