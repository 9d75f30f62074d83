//! Derivatives of what is measured along an orbit.

use crate::branches::curve::equations::CurveError;
use crate::branches::sensitivity::observed::{Derivatives, Gather, STEP_ALONG_ORBIT, STEPS};
use crate::branches::sensitivity::quantity::Quantity;
use crate::branches::sensitivity::totals::Totals;
use crate::error::ParameterError;
use crate::model::equations::Constants;
use crate::model::{Model, Periodic};
use crate::numeric::differences::{CENTRAL, ONE_SIDED};
use crate::numeric::gauss::FIVE;
use crate::numeric::spread::GOLDEN;
use crate::ode::probe::Probe;
use crate::ode::{Observer, Step};
use crate::periodic::flow::flow_method::Expansion;
use crate::periodic::flow::tangent::Tangent;
use nalgebra::DMatrix;
use std::ops::ControlFlow;

/// The models with each constant moved to the places of a difference, for each of [`STEPS`].
pub(crate) struct Neighbours<'m>([Vec<Vec<Neighbour<'m>>>; STEPS.len()]);

/// A model with one constant moved.
struct Neighbour<'m> {
    place: f64,
    weight: f64,
    /// Its period over that of the model.
    ratio: f64,
    model: Box<dyn Periodic + 'm>,
}

impl<'m> Neighbours<'m> {
    pub(crate) fn new(constants: &'m dyn Constants, units: &[f64], period: f64) -> Result<Self, CurveError> {
        let mut sets = [const { Vec::new() }; STEPS.len()];
        for (all, share) in sets.iter_mut().zip(STEPS) {
            *all = Neighbours::with_step(constants, units, period, share * STEP_ALONG_ORBIT)?;
        }
        Ok(Neighbours(sets))
    }

    fn with_step(
        constants: &'m dyn Constants,
        units: &[f64],
        period: f64,
        step: f64,
    ) -> Result<Vec<Vec<Neighbour<'m>>>, CurveError> {
        let mut all = Vec::with_capacity(units.len());
        for (i, unit) in units.iter().enumerate() {
            let value = constants.values()[i];
            let moved = |places: &[(f64, f64)], way: f64| -> Result<Vec<Neighbour<'m>>, ParameterError> {
                let one = |(place, weight): &(f64, f64)| {
                    let (place, weight) = (way * place, way * weight);
                    let model = constants.with_values(&[(i, value + place * step * unit)])?;
                    Ok(Neighbour { place, weight, ratio: model.period() / period, model })
                };
                places.iter().map(one).collect()
            };
            // At the end of its range a constant moves in one direction only.
            let found = moved(&CENTRAL, 1.0).or_else(|_| moved(&ONE_SIDED, 1.0));
            let found = found.or_else(|_| moved(&ONE_SIDED, -1.0));
            all.push(found.map_err(|error| CurveError::Model { parameter: value, error })?);
        }
        Ok(all)
    }
}

/// Number of samples in a part of a step among which an extremum is looked for.
const EXTREMUM_SAMPLES: usize = 7;

/// Number of golden sections for an extremum.
const GOLDEN_SECTIONS: usize = 24;

/// Number of Newton steps for its time.
const POLISHES: usize = 3;

/// Step of the differences in time, as a share of the bracket.
const TIME_STEP: f64 = 5e-3;

impl Gather<'_> {
    /// The largest value of ± quantity j near a sample: golden sections, then Newton's method on differences
    /// of fourth order in time. Values alone show the time of a maximum to half of their digits only.
    fn refine(&mut self, step: &mut Step<'_>, j: usize, sign: f64, mut bracket: [f64; 2]) -> (f64, f64) {
        let ([low, high], width) = (bracket, bracket[1] - bracket[0]);
        let mut at = |this: &mut Self, share: f64, bracket: [f64; 2]| {
            let t = bracket[0] + share * (bracket[1] - bracket[0]);
            let side = this.look(step, t);
            (t, sign * this.value(j, t, side))
        };
        let (mut left, mut right) = (at(self, 1.0 - GOLDEN, bracket), at(self, GOLDEN, bracket));
        for _ in 0..GOLDEN_SECTIONS {
            if left.1 >= right.1 {
                bracket[1] = right.0;
                right = left;
                left = at(self, 1.0 - GOLDEN, bracket);
            } else {
                bracket[0] = left.0;
                left = right;
                right = at(self, GOLDEN, bracket);
            }
        }
        let mut best = if left.1 >= right.1 { left } else { right };
        for _ in 0..POLISHES {
            let (t, h) = (best.0, TIME_STEP * width);
            if t - 2.0 * h < low || t + 2.0 * h > high {
                break;
            }
            let mut value = |k: f64| at(self, (t + k * h - low) / width, [low, high]).1;
            let [a, b, c, d, e] = [-2.0, -1.0, 0.0, 1.0, 2.0].map(&mut value);
            let (slope, curve) = (8.0 * (d - b) - (e - a), 16.0 * (b + d) - 30.0 * c - (a + e));
            let moved = t - h * slope / curve;
            if !(moved > low && moved < high) {
                break;
            }
            best = (moved, at(self, (moved - low) / width, [low, high]).1);
        }
        best
    }

    /// Updates the extremes with a part of a step, without the ends at crossings.
    fn extremes(&mut self, step: &mut Step<'_>, (t0, t1): (f64, f64), at_crossings: &[f64]) {
        let time = |i: usize| t0 + (t1 - t0) * (i as f64 / (EXTREMUM_SAMPLES - 1) as f64);
        for j in 0..self.quantities.len() {
            let mut values = [0.0; EXTREMUM_SAMPLES];
            for (i, value) in values.iter_mut().enumerate() {
                let side = self.look(step, time(i));
                *value = self.value(j, time(i), side);
            }
            for (which, sign) in [1.0, -1.0].into_iter().enumerate() {
                let top =
                    (0..EXTREMUM_SAMPLES).max_by(|&a, &b| (sign * values[a]).total_cmp(&(sign * values[b])));
                let top = top.unwrap_or(0);
                let range = values
                    .iter()
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(*v), h.max(*v)]);
                let margin = 0.5 * (range[1] - range[0]);
                if sign * values[top] + margin < sign * self.out[j].extremes[which].0 {
                    continue;
                }
                let bracket = [time(top.saturating_sub(1)), time((top + 1).min(EXTREMUM_SAMPLES - 1))];
                let (mut t, mut best) = self.refine(step, j, sign, bracket);
                for end in [t0, t1] {
                    if at_crossings.contains(&end) {
                        continue;
                    }
                    let side = self.look(step, end);
                    let value = sign * self.value(j, end, side);
                    if value > best {
                        (t, best) = (end, value);
                    }
                }
                if best > sign * self.out[j].extremes[which].0 {
                    let side = self.look(step, t);
                    let mut slopes = vec![0.0; self.speeds.len()];
                    self.along(j, t, side, &mut slopes);
                    self.out[j].extremes[which] = (sign * best, t, slopes);
                }
            }
        }
    }
}

impl Observer for Gather<'_> {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        let mut slopes = std::mem::take(&mut self.slopes);
        self.pieces.clear();
        self.pieces.extend_from_slice(step.pieces().unwrap_or_default());
        let after = self.passed.take();
        let starts = after.is_some().then_some(step.t0());
        let ends = (!step.crossings().is_empty()).then_some(step.t1());
        let at_crossings: Vec<f64> = starts.into_iter().chain(ends).collect();
        if let Some(t) = self.instant.filter(|t| (step.t0()..=step.t1()).contains(t)) {
            let side = self.look(step, t);
            for j in 0..self.quantities.len() {
                self.along(j, t, side, &mut slopes);
                self.out[j].at.copy_from_slice(&slopes);
            }
        }
        for part in 0..step.parts() {
            let (t0, t1) = step.part(part);
            let (middle, half) = (0.5 * (t0 + t1), 0.5 * (t1 - t0));
            for [x, w] in FIVE {
                let t = middle + half * x;
                let side = self.look(step, t);
                let weight = half * w / self.period;
                for j in 0..self.quantities.len() {
                    let value = self.value(j, t, side);
                    self.along(j, t, side, &mut slopes);
                    let out = &mut self.out[j];
                    out.mean += weight * value;
                    out.square += weight * value * value;
                    for (k, slope) in slopes.iter().enumerate() {
                        out.by_mean[k] += weight * slope;
                        out.by_square[k] += weight * 2.0 * value * slope;
                    }
                }
            }
            self.extremes(step, (t0, t1), &at_crossings);
        }
        self.pass(step, after);
        self.slopes = slopes;
        ControlFlow::Continue(())
    }
}

/// Integrates over an orbit with its derivatives dx/dc = `slopes` and gathers the derivatives of quantities.
pub(crate) fn gather(
    totals: &Totals<'_>,
    model: &dyn Periodic,
    neighbours: &Neighbours<'_>,
    slopes: &DMatrix<f64>,
    quantities: &[Quantity],
    instant: Option<f64>,
) -> Result<Vec<Derivatives>, CurveError> {
    let plain: &dyn Model = model;
    let (scale, passage, count) = (totals.curve.scale(), &totals.passage, totals.forced.len());
    let tolerance = totals.curve.flow_tolerance();
    let failed = |segment: usize| move |error| CurveError::Integrate { segment, error };
    let expansion = Expansion::new(plain, count, &totals.forced, totals.curve.chosen()).map_err(failed(0))?;
    let flow = Tangent::new(plain, count, &totals.forced, scale, tolerance, &expansion);
    let n = plain.dof();
    let empty = |sign: f64| (sign * f64::INFINITY, f64::NAN, vec![0.0; count]);
    let probe = |one: &'_ Neighbour<'_>| [one.place, one.weight, one.ratio];
    let mut probes = Vec::with_capacity(STEPS.len());
    for set in &neighbours.0 {
        let mut of_set = Vec::with_capacity(count);
        for all in set {
            let mut of_one = Vec::with_capacity(all.len());
            for neighbour in all {
                let plain: &dyn Model = &*neighbour.model;
                of_one.push((probe(neighbour), Probe::new(plain)));
            }
            of_set.push(of_one);
        }
        probes.push(of_set);
    }
    let mut gather = Gather {
        quantities,
        base: Probe::new(plain),
        probes,
        speeds: totals.forced.iter().map(|by| by.speed).collect(),
        n,
        period: passage.end - passage.states[0].t,
        y: vec![0.0; 2 * n * (1 + count)],
        moved: vec![0.0; 2 * n],
        out: quantities
            .iter()
            .map(|_| Derivatives {
                mean: 0.0,
                square: 0.0,
                by_mean: vec![0.0; count],
                by_square: vec![0.0; count],
                extremes: [empty(-1.0), empty(1.0)],
                at: vec![0.0; count],
            })
            .collect(),
        slopes: vec![0.0; count],
        instant,
        pieces: Vec::new(),
        passed: None,
    };
    for i in 0..passage.states.len() {
        let until = passage.states.get(i + 1).map_or(passage.end, |next| next.t);
        let start = totals.start(i, slopes);
        flow.flow(tolerance, start, until, totals.curve.meter(), Some(&mut gather)).map_err(failed(i))?;
    }
    Ok(gather.out)
}
