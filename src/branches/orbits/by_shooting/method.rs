//! Shooting as the method of a continuation: figures, orbits with multipliers, shifts of the nodes.

use crate::branches::curve::equations::CurveError;
use crate::branches::curve::point::CurvePoint;
use crate::branches::family::Family;
use crate::branches::orbits::by_shooting::measure::measure;
use crate::branches::orbits::by_shooting::nodes::clear;
use crate::branches::orbits::by_shooting::orbit_curve::{OrbitCurve, Passage};
use crate::branches::orbits::measured::Measured;
use crate::branches::orbits::orbit_method::{OrbitMethod, Orbits};
use crate::branches::stability_method::StabilityMethod;
use crate::model::{Channel, State};
use crate::ode::Budget;
use crate::periodic::flow::variation::unscaled;
use crate::periodic::shooting::segments::{Purpose, drift};
use crate::periodic::shooting::shooting_orbit::OrbitParts;
use crate::periodic::{Multipliers, ShootingOrbit};
use nalgebra::DVector;

/// A state whose negative repeats half a period later within this share of its range belongs to a symmetric
/// orbit.
const REVERSED: f64 = 1e-6;

impl Orbits for OrbitCurve<'_> {
    type Orbit = ShootingOrbit;

    fn multipliers(&self, point: &CurvePoint<Passage>) -> Option<Multipliers> {
        (self.stability == StabilityMethod::Multipliers).then(|| point.solution.multipliers.clone()).flatten()
    }

    fn first_state(&self, point: &CurvePoint<Passage>) -> Option<(usize, State)> {
        Some((self.multiple, point.solution.states[0].clone()))
    }

    fn measure(&self, point: &CurvePoint<Passage>, channels: &[Channel]) -> Result<Measured, CurveError> {
        measure(self, point.p, &point.solution, channels)
    }

    fn accept(&mut self, point: &CurvePoint<Passage>, measured: &Measured) {
        let Passage { slack, scale, states, end, .. } = &point.solution;
        [self.drift, _] = drift(&self.drifts.basis(scale), slack, scale);
        self.widths.accept(&self.drifts.widened(&measured.ranges, &self.drift, end - states[0].t));
        self.scale.clone_from(&measured.units);
        self.range.clone_from(&measured.ranges);
    }

    fn clear_of(&self, impacts: &[f64]) -> Option<f64> {
        let since: Vec<f64> = self.phases.iter().map(|phase| phase - self.phases[0]).collect();
        clear(&since, impacts)
    }

    fn shifted(&self, point: &CurvePoint<Passage>, shift: f64) -> Result<DVector<f64>, CurveError> {
        let (orbit, _) = self.orbit(point)?;
        let model = self.model(point.p)?;
        let mut later = orbit.clone();
        for state in &mut later.parts.states {
            let at = orbit.at(&*model, state.t + shift * orbit.period());
            *state = at.map_err(|error| CurveError::Integrate { segment: 0, error })?;
        }
        later.parts.end += shift * orbit.period();
        Ok(self.unknowns_of(&later))
    }

    fn shift_nodes(&mut self, shift: f64, x: &DVector<f64>) {
        self.phases.iter_mut().for_each(|phase| *phase += shift);
        let m = self.scale.len();
        self.reference = State::new(0.0, &x.as_slice()[..m / 2], &x.as_slice()[m / 2..m]);
    }

    /// The error of the multipliers is their distance from those of the run for
    /// [comparison](Purpose::Comparison).
    fn orbit(&self, point: &CurvePoint<Passage>) -> Result<(ShootingOrbit, Multipliers), CurveError> {
        let CurvePoint { x, p, solution: passage, corrections, .. } = point;
        let none = || CurveError::NotConverged { corrections: corrections.to_vec() };
        let multipliers = passage.multipliers.clone().ok_or_else(none)?;
        let model = self.model(*p)?;
        let looser = match self.stability {
            StabilityMethod::Skipped => None,
            StabilityMethod::Multipliers => Some(self.round(&*model, x, Vec::new(), Purpose::Comparison)),
        };
        if let Some(Err(CurveError::Exhausted(exhausted))) = looser {
            return Err(exhausted.into());
        }
        let other = looser
            .and_then(Result::ok)
            .and_then(|at| Multipliers::without(&at.round.monodromy(), &at.rigid, 0.0).ok());
        let multipliers = multipliers.compared_with(other);
        let parts = OrbitParts {
            states: passage.states.clone(),
            end: passage.end,
            multiple: self.multiple,
            least: self.multiple,
            scale: passage.scale.clone(),
            range: self.range.clone(),
            drift: drift(&self.drifts.basis(&passage.scale), &passage.slack, &passage.scale),
            monodromy: unscaled(&passage.monodromy, &passage.scale),
            multipliers: multipliers.clone(),
            first: corrections.first().copied().unwrap_or(0.0),
            corrections: corrections.clone(),
            crossings: passage.crossings,
            flow: self.flow_tolerance,
            method: passage.method,
        };
        let orbit = ShootingOrbit { parts, budget: Budget::new() };
        Ok((orbit, multipliers))
    }
}

impl OrbitMethod for OrbitCurve<'_> {
    fn family(&self) -> &Family<'_> {
        &self.family
    }

    fn is_symmetric(&self, point: &CurvePoint<Passage>) -> bool {
        let (start, half) =
            (&point.solution.states[0], 0.5 * (point.solution.end - point.solution.states[0].t));
        let later = self.model(point.p).ok().zip(self.orbit(point).ok());
        let later = later.and_then(|(model, (orbit, _))| orbit.at(&*model, start.t + half).ok());
        later.is_some_and(|later| {
            let sums = later.q.iter().chain(&later.v).zip(start.q.iter().chain(&start.v));
            sums.zip(&self.range).all(|((a, b), range)| (a + b).abs() <= REVERSED * range)
        })
    }

    fn unknowns(&self, orbit: &ShootingOrbit) -> DVector<f64> {
        self.unknowns_of(orbit)
    }
}
