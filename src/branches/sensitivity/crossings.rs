//! Derivatives at crossings, where a quantity may jump or have a corner.

use crate::branches::sensitivity::observed::{Gather, Passed};
use crate::branches::sensitivity::quantity::Quantity;
use crate::contact::edge::Edge;
use crate::ode::Step;

/// An end of a step, as seen from inside it.
struct End {
    value: f64,
    /// Derivative by the time.
    rate: f64,
    /// Derivatives by the constants.
    slopes: Vec<f64>,
}

/// Distance of the instants from which the end of a step is extrapolated, as a share of the step `[1]`.
/// Beside an edge the values at the end itself may be those of the other side.
const INSIDE: f64 = 1e-3;

/// Weights of the values at 1, 2, .. 5 in the value and in the derivative at 0 of the polynomial through
/// them.
const OUTSIDE: [[f64; 2]; 5] =
    [[5.0, -77.0 / 12.0], [-10.0, 107.0 / 6.0], [10.0, -19.5], [-5.0, 61.0 / 6.0], [1.0, -25.0 / 12.0]];

impl Gather<'_> {
    /// Adds what the crossings at both ends of a step change. `after`: the crossing at which it begins.
    ///
    /// A mean (1/T) ∫ f dt changes by (f⁻ - f⁺) dτ/dc/T, where the crossing at τ moves at a fixed phase.
    pub(super) fn pass(&mut self, step: &mut Step<'_>, after: Option<Passed>) {
        if let Some(passed) = after {
            for j in 0..self.quantities.len() {
                let (first, before) = (self.end(step, j, false), passed.before[j]);
                let out = &mut self.out[j];
                for (k, time) in passed.times.iter().enumerate() {
                    let share = time / self.period;
                    out.by_mean[k] += (before - first.value) * share;
                    out.by_square[k] += (before * before - first.value * first.value) * share;
                }
                self.extreme_end((j, step.t0()), &first, &passed);
            }
        }
        self.passed = self.passes(step);
    }

    /// Quantity j at an end of a step, by the polynomial through five instants inside it.
    fn end(&mut self, step: &mut Step<'_>, j: usize, is_last: bool) -> End {
        let (t0, t1) = (step.t0(), step.t1());
        let (end, inwards) = if is_last { (t1, t0 - t1) } else { (t0, t1 - t0) };
        let mut found = End { value: 0.0, rate: 0.0, slopes: vec![0.0; self.speeds.len()] };
        let mut slopes = vec![0.0; self.speeds.len()];
        for (k, [of_value, of_rate]) in OUTSIDE.into_iter().enumerate() {
            let t = end + (k + 1) as f64 * INSIDE * inwards;
            let side = self.look(step, t);
            let value = self.value(j, t, side);
            found.value += of_value * value;
            found.rate += of_rate * value / (INSIDE * inwards);
            self.along(j, t, side, &mut slopes);
            found.slopes.iter_mut().zip(&slopes).for_each(|(sum, slope)| *sum += of_value * slope);
        }
        found
    }

    /// The crossing at which a step ends: the derivative of its time is -δg/g', with the distance g from the
    /// edge and its rate g' before the crossing. Of several at one instant the first one decides.
    fn passes(&mut self, step: &mut Step<'_>) -> Option<Passed> {
        let crossing = *step.crossings().first()?;
        let edge = Edge::between(crossing.from, crossing.to);
        let t = step.t1();
        let side = self.look(step, t);
        let half = self.y.len() / 2;
        let (q, v) = (&self.y[..self.n], &self.y[half..half + self.n]);
        let contact = self.base.read_contacts(t, side, q, v)[crossing.contact];
        let rate = edge.rate(&contact);
        let distance = Quantity::Distance { contact: crossing.contact, edge };
        let count = self.speeds.len();
        // The distance has no corner at its edge.
        let times = (0..count).map(|k| -self.along_one(distance, k, t, side, 0).0 / rate).collect();
        let mut passed = Passed { times, before: Vec::with_capacity(self.quantities.len()) };
        for j in 0..self.quantities.len() {
            let last = self.end(step, j, true);
            passed.before.push(last.value);
            self.extreme_end((j, t), &last, &passed);
        }
        Some(passed)
    }

    /// Updates the extremes with an end of a step. At a crossing its value follows the time of the crossing.
    fn extreme_end(&mut self, (j, t): (usize, f64), end: &End, passed: &Passed) {
        for (which, sign) in [1.0, -1.0].into_iter().enumerate() {
            if sign * end.value > sign * self.out[j].extremes[which].0 {
                let mut slopes = end.slopes.clone();
                slopes.iter_mut().zip(&passed.times).for_each(|(slope, time)| *slope += end.rate * time);
                self.out[j].extremes[which] = (end.value, t, slopes);
            }
        }
    }
}
