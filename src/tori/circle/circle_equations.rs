//! The equations of an invariant circle and their Jacobian.

use crate::analysis::motion_size::MotionSize;
use crate::model::{Model, State};
use crate::numeric::norms::{dot, remove};
use crate::numeric::spread::golden;
use crate::ode::IntegrateError;
use crate::ode::budget::Meter;
use crate::periodic::FlowMethod;
use crate::periodic::flow::flow_method::{Chosen, Expansion};
use crate::periodic::flow::tangent::Tangent;
use crate::periodic::flow::variation::{metered, transition};
use crate::periodic::flow::walk::SegmentError;
use crate::roots::{Matrix, Residual};
use crate::tori::circle::closed_curve::{ClosedCurve, weight_rates, weights, write_weights};
use crate::tori::circle::strobed::Strobed;
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// P(x(θ_j)) - x(θ_j + ρ) = 0 at the nodes; if ρ is an unknown, also Σ_j (x_j - g_j)·g'_j = 0 with the guess
/// g, which fixes the origin of θ.
///
/// The unknowns are coordinates and velocities of every node over their units, then ρ.
pub(crate) struct CircleEquations<'m> {
    strobed: &'m Strobed<'m>,
    meter: &'m Meter<'m>,
    expansion: Expansion,
    flow_tolerance: f64,
    t: f64,
    nodes: usize,
    /// Units of coordinates and velocities.
    pub(crate) units: Vec<f64>,
    /// Ranges of motion over one period of the map.
    pub(crate) ranges: Vec<f64>,
    /// ρ if the drives determine it.
    rotation: Option<f64>,
    /// The guess and its derivative over θ, in units; empty if ρ is known.
    guess: [Vec<f64>; 2],
    /// Unknowns of the last evaluation; empty before the first.
    evaluated: Vec<f64>,
    /// Ends of the flow, in units, and its derivatives.
    ends: Vec<f64>,
    transitions: Vec<DMatrix<f64>>,
    pub(crate) crossings: u64,
    /// The last integration that failed; the segment of a node has its index.
    pub(crate) failure: Option<SegmentError>,
}

/// Number of map periods before the measurement. In them a perturbation turns into the one that grows most.
const ALIGNED: usize = 256;

/// Least and largest number of map periods over which the growth is measured.
const MEASURED_GROWTH: [usize; 2] = [1 << 10, 1 << 18];

/// Number of turns round the circle over which the growth is measured.
const ROUNDS: f64 = 16.0;

/// Error of the mean over these turns, as a share of the variation of the growth along the circle.
const SHARE: f64 = 4e-6;

/// Error of the mean growth that comes from the errors of the transitions.
const ROUNDING: f64 = 1e-9;

/// Largest denominator q of the ratios p/q that the rotation, as a share of a turn, is compared with. Near
/// such a ratio every q-th point of the map moves slowly along the circle.
const DENOMINATORS: usize = 8;

/// Number of map periods that make [`ROUNDS`] turns round the circle, or `None` if it is too large.
fn rounds(rotation: f64) -> Option<usize> {
    let slow = |q: usize| {
        let turns = q as f64 * rotation / TAU;
        (turns - turns.round()).abs()
    };
    let slowest = (1..=DENOMINATORS).map(slow).fold(f64::INFINITY, f64::min);
    let [least, most] = MEASURED_GROWTH;
    let periods = (ROUNDS / slowest).ceil();
    (periods <= most as f64).then_some((periods as usize).max(least))
}

/// Number of nodes from which the ranges of motion are measured.
const MEASURED: usize = 16;

impl<'m> CircleEquations<'m> {
    /// The segment of an error is the node at which a first integration fails.
    pub(crate) fn new(
        strobed: &'m Strobed<'m>,
        guess: &ClosedCurve,
        flow_tolerance: f64,
        method: &Chosen,
        meter: &'m Meter<'m>,
    ) -> Result<Self, SegmentError> {
        let (nodes, width, t) = (guess.nodes(), guess.width(), guess.time());
        let mut motion = MotionSize::new(width / 2, &[]);
        let states = guess.states();
        for j in (0..nodes).step_by(nodes.div_ceil(MEASURED)) {
            let (state, theta) = (&states[j], TAU * j as f64 / nodes as f64);
            motion.see(t, &state.q, &state.v);
            strobed
                .with(theta, t, |model| {
                    let until = t + strobed.period();
                    metered(state, method, model, state, until, &mut motion.along(model), meter).map(drop)
                })
                .map_err(|error| SegmentError { segment: j, error })?;
        }
        let (ranges, units) = (motion.ranges(), motion.units(flow_tolerance));
        let expansion = strobed
            .with(0.0, t, |model| Expansion::new(model, width, &[], method))
            .map_err(|error| SegmentError { segment: 0, error })?;
        let rotation = strobed.rotation();
        let guess = if rotation.is_some() {
            [Vec::new(), Vec::new()]
        } else {
            let in_units =
                |y: &[f64]| -> Vec<f64> { y.iter().zip(&units).map(|(y, unit)| y / unit).collect() };
            let rates = (0..nodes).flat_map(|j| {
                let rate = guess.derivative(TAU * j as f64 / nodes as f64);
                in_units(&[rate.q, rate.v].concat())
            });
            [guess.values().chunks_exact(width).flat_map(in_units).collect(), rates.collect()]
        };
        Ok(CircleEquations {
            strobed,
            meter,
            expansion,
            flow_tolerance,
            t,
            nodes,
            rotation,
            guess,
            evaluated: Vec::new(),
            ends: vec![0.0; nodes * width],
            transitions: Vec::with_capacity(nodes),
            crossings: 0,
            failure: None,
            units,
            ranges,
        })
    }

    pub(crate) fn method(&self) -> FlowMethod {
        self.expansion.method()
    }

    pub(crate) fn unknowns(&self, curve: &ClosedCurve, rotation: f64) -> Vec<f64> {
        let mut x: Vec<f64> = curve.values().to_vec();
        x.chunks_exact_mut(curve.width())
            .for_each(|y| y.iter_mut().zip(&self.units).for_each(|(y, u)| *y /= u));
        if self.rotation.is_none() {
            x.push(rotation);
        }
        x
    }

    /// The curve and the rotation of unknowns.
    pub(crate) fn curve(&self, x: &[f64]) -> (ClosedCurve, f64) {
        let width = self.units.len();
        let mut values = x[..self.nodes * width].to_vec();
        values.chunks_exact_mut(width).for_each(|y| y.iter_mut().zip(&self.units).for_each(|(y, u)| *y *= u));
        (ClosedCurve::of(self.t, width, values), self.rotation_of(x))
    }

    fn rotation_of(&self, x: &[f64]) -> f64 {
        self.rotation.unwrap_or_else(|| x[x.len() - 1])
    }

    /// End of the flow over one period from θ, its derivative in units, and the number of crossings.
    pub(crate) fn map(
        &self,
        theta: f64,
        start: &State,
    ) -> Result<(State, DMatrix<f64>, u64), IntegrateError> {
        self.strobed.with(theta, self.t, |model: &dyn Model| {
            let flow =
                Tangent::new(model, self.units.len(), &[], &self.units, self.flow_tolerance, &self.expansion);
            transition(&flow, self.flow_tolerance, start, self.t + self.strobed.period(), self.meter)
        })
    }

    /// Evaluates the map at all nodes. `false`: an integration failed.
    fn evaluate(&mut self, x: &[f64]) -> bool {
        if self.evaluated == x {
            return true;
        }
        self.evaluated.clear();
        if self.meter.exhausted().is_some() {
            return false;
        }
        self.transitions.clear();
        self.crossings = 0;
        let (n, width) = (self.units.len() / 2, self.units.len());
        for (j, y) in x[..self.nodes * width].chunks_exact(width).enumerate() {
            let y: Vec<f64> = y.iter().zip(&self.units).map(|(y, unit)| y * unit).collect();
            match self.map(TAU * j as f64 / self.nodes as f64, &State::new(self.t, &y[..n], &y[n..])) {
                Ok((end, transition, crossings)) => {
                    let ends =
                        self.ends[j * width..].iter_mut().zip(end.q.iter().chain(&end.v)).zip(&self.units);
                    ends.for_each(|((out, y), unit)| *out = y / unit);
                    self.transitions.push(transition);
                    self.crossings += crossings;
                }
                Err(error) => {
                    self.failure = Some(SegmentError { segment: j, error });
                    return false;
                }
            }
        }
        self.failure = None;
        self.evaluated.extend_from_slice(x);
        true
    }

    /// Mean logarithm of the growth of the perturbation of the circle that grows most, over one period of the
    /// map: that of the transitions between the nodes, interpolated at θ = k ρ. The weights are those of
    /// [`rotation_number`](crate::tori::rotation_number). NaN if the points of the map move too slowly
    /// along the circle, or if the budget is spent. The second number estimates the error of the mean.
    pub(crate) fn growth(&mut self, curve: &ClosedCurve, rotation: f64) -> (f64, f64) {
        let (m, width) = (self.nodes, self.units.len());
        let x = self.unknowns(curve, rotation);
        let Some(periods) = rounds(rotation).filter(|_| self.evaluate(&x)) else {
            return (f64::NAN, f64::NAN);
        };
        let in_units = |state: State| -> Vec<f64> {
            state.q.iter().chain(&state.v).zip(&self.units).map(|(y, unit)| y / unit).collect()
        };
        let rates: Vec<Vec<f64>> =
            (0..m).map(|j| in_units(curve.derivative(TAU * j as f64 / m as f64))).collect();
        let mut y: Vec<f64> = (0..width).map(|i| golden((i + 1) as f64) - 0.5).collect();
        let (mut next, mut theta, mut sum, mut total) = (vec![0.0; width], 0.0, 0.0, 0.0);
        let (mut at, mut along) = (weights(m, theta), vec![0.0; width]);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..ALIGNED + periods {
            if k % 1024 == 0 && self.meter.exhausted().is_some() {
                return (f64::NAN, f64::NAN);
            }
            next.fill(0.0);
            for (weight, transition) in at.iter().zip(&self.transitions) {
                for (j, y) in y.iter().enumerate() {
                    next.iter_mut().enumerate().for_each(|(i, out)| *out += weight * transition[(i, j)] * y);
                }
            }
            theta = (theta + rotation).rem_euclid(TAU);
            write_weights(theta, &mut at);
            if self.rotation.is_none() {
                // A perturbation along the circle stays along it.
                let rate_of = |i: usize| at.iter().zip(&rates).map(|(w, rate)| w * rate[i]).sum::<f64>();
                along.iter_mut().enumerate().for_each(|(i, out)| *out = rate_of(i));
                let length = dot(&along, &along).sqrt();
                along.iter_mut().for_each(|x| *x /= length);
                remove(&along, &mut next);
            }
            let length = dot(&next, &next).sqrt();
            if length == 0.0 {
                return (f64::NEG_INFINITY, 0.0);
            }
            y.iter_mut().zip(&next).for_each(|(y, next)| *y = next / length);
            if k >= ALIGNED {
                let s = (k - ALIGNED + 1) as f64 / (periods + 1) as f64;
                let weight = (-1.0 / (s * (1.0 - s))).exp();
                let growth = length.ln();
                (least, most) = (growth.min(least), growth.max(most));
                sum += weight * growth;
                total += weight;
            }
        }
        (sum / total, SHARE * (most - least) + ROUNDING)
    }

    /// Mean of g'·g' over the nodes, in units.
    fn guess_speed(&self) -> f64 {
        self.guess[1].iter().map(|rate| rate * rate).sum::<f64>()
    }
}

impl Residual for CircleEquations<'_> {
    fn size(&self) -> usize {
        self.nodes * self.units.len() + usize::from(self.rotation.is_none())
    }

    fn residual(&mut self, x: &[f64], r: &mut [f64]) {
        if !self.evaluate(x) {
            return r.fill(f64::NAN);
        }
        let (width, m) = (self.units.len(), self.nodes);
        // x(θ_j + ρ) = Σ_d D(ρ - 2πd/M) x_{j+d}
        let weights = weights(m, self.rotation_of(x));
        for j in 0..m {
            for c in 0..width {
                let sum: f64 = weights.iter().enumerate().map(|(d, w)| w * x[(j + d) % m * width + c]).sum();
                r[j * width + c] = self.ends[j * width + c] - sum;
            }
        }
        if self.rotation.is_none() {
            let [guess, rates] = &self.guess;
            let along: f64 = x.iter().zip(guess).zip(rates).map(|((x, g), rate)| (x - g) * rate).sum();
            r[m * width] = along / self.guess_speed();
        }
    }

    fn jacobian(&mut self, x: &[f64], out: &mut Matrix) {
        let (width, m) = (self.units.len(), self.nodes);
        if !self.evaluate(x) {
            for column in 0..self.size() {
                out.column_mut(column).fill(f64::NAN);
            }
            return;
        }
        let weights = weights(m, self.rotation_of(x));
        let speed = self.guess_speed();
        for i in 0..m {
            for b in 0..width {
                let column = out.column_mut(i * width + b);
                column.fill(0.0);
                for (d, weight) in weights.iter().enumerate() {
                    column[(i + m - d) % m * width + b] = -weight;
                }
                for (a, entry) in column[i * width..(i + 1) * width].iter_mut().enumerate() {
                    *entry += self.transitions[i][(a, b)];
                }
                if self.rotation.is_none() {
                    column[m * width] = self.guess[1][i * width + b] / speed;
                }
            }
        }
        if self.rotation.is_none() {
            let rates = weight_rates(m, self.rotation_of(x));
            let column = out.column_mut(m * width);
            column[m * width] = 0.0;
            for j in 0..m {
                for c in 0..width {
                    let sum: f64 =
                        rates.iter().enumerate().map(|(d, w)| w * x[(j + d) % m * width + c]).sum();
                    column[j * width + c] = -sum;
                }
            }
        }
    }
}
