//! The equations of an invariant circle and their Jacobian.

use crate::analysis::motion_size::MotionSize;
use crate::model::structure::drifts::Drifts;
use crate::model::{Model, State};
use crate::ode::IntegrateError;
use crate::ode::budget::Meter;
use crate::periodic::FlowMethod;
use crate::periodic::flow::flow_method::{Chosen, Expansion};
use crate::periodic::flow::tangent::Tangent;
use crate::periodic::flow::variation::{metered, transition};
use crate::periodic::flow::walk::SegmentError;
use crate::roots::{Matrix, Residual};
use crate::tori::circle::closed_curve::{ClosedCurve, weight_rates, weights};
use crate::tori::circle::growth::Perturbations;
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
        let mut motion = MotionSize::new(width / 2, &Drifts::default());
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
    /// map, and an estimate of its error ([`Perturbations::growth`]). `middle` has the transitions midway
    /// between the nodes: their distance from the interpolated ones is part of the error.
    pub(crate) fn growth(&mut self, curve: &ClosedCurve, rotation: f64, middle: &[DMatrix<f64>]) -> [f64; 2] {
        let m = self.nodes;
        let x = self.unknowns(curve, rotation);
        if !self.evaluate(&x) {
            return [f64::NAN; 2];
        }
        let in_units = |state: State| -> Vec<f64> {
            state.q.iter().chain(&state.v).zip(&self.units).map(|(y, unit)| y / unit).collect()
        };
        let along = if self.rotation.is_none() { m } else { 0 };
        let rates = (0..along).map(|j| in_units(curve.derivative(TAU * j as f64 / m as f64))).collect();
        let transitions = &self.transitions;
        let [growth, error] = Perturbations { transitions, rates, rotation, meter: self.meter }.growth();
        let off = |(j, exact): (usize, &DMatrix<f64>)| {
            let at = weights(m, TAU * (j as f64 + 0.5) / m as f64);
            let add = |sum: DMatrix<f64>, (w, a): (&f64, &DMatrix<f64>)| sum - a * *w;
            at.iter().zip(transitions).fold(exact.clone(), add).norm()
        };
        let off = middle.iter().enumerate().map(off).sum::<f64>() / middle.len() as f64;
        // No growth is known to less than the share of these differences in it.
        [growth, if growth.is_finite() { error + off * (-growth).exp() } else { error }]
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
