//! Step sizes: settings of the solvers, the first step, PI controller.

use crate::error::{ParameterError, check};
use crate::model::{Model, State};
use crate::ode::step::Observer;
use crate::ode::stepping::engine::{Engine, Tableau};
use crate::ode::stepping::one_step::OneStep;
use crate::ode::stepping::vector::Vector;
use std::fmt;

/// A run: from where to where, by which steps.
pub struct Task<'a> {
    pub(crate) rule: StepRule<'a>,
    pub(crate) limits: Limits,
    pub(crate) model: &'a dyn Model,
    pub(crate) start: &'a State,
    pub(crate) t_end: f64,
    pub(crate) observer: &'a mut dyn Observer,
    /// The steps, if they are those of a method of one's own.
    pub(crate) own: Option<&'a dyn OneStep>,
}

impl fmt::Debug for Task<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Task").field("start", self.start).field("t_end", &self.t_end).finish_non_exhaustive()
    }
}

/// Settings of all solvers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limits {
    /// Whether edges of the gaps are located. Default: true.
    pub(crate) locate: bool,
    /// Maximum number of steps, rejected ones included. Default: 10⁸.
    pub(crate) max_steps: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Limits { locate: true, max_steps: 100_000_000 }
    }
}

/// Further settings of the adaptive solvers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tolerances {
    /// Relative tolerance.
    pub(crate) rtol: f64,
    /// Absolute tolerances: one, or one per component.
    pub(crate) atol: Vec<f64>,
    /// First step; `None`: estimated by [`starting_step`].
    pub(crate) first: Option<f64>,
    /// Maximum step.
    pub(crate) max: f64,
    /// β of the PI controller.
    pub(crate) beta: f64,
}

/// The step sizes of a run: one fixed step, or steps controlled by tolerances.
#[derive(Clone, Copy)]
pub(crate) enum StepRule<'a> {
    Fixed(f64),
    Adaptive(&'a Tolerances),
}

impl StepRule<'_> {
    /// Checks the settings and returns the absolute tolerance of every component; empty for a fixed step.
    ///
    /// # Errors
    /// A setting outside its range.
    pub(crate) fn check(&self, components: usize) -> Result<Vec<f64>, ParameterError> {
        match self {
            StepRule::Fixed(step) => {
                check::above_zero("step", *step)?;
                Ok(Vec::new())
            }
            StepRule::Adaptive(Tolerances { rtol, atol, first, max, beta, .. }) => {
                check::above_zero("rtol", *rtol).and_then(|rtol| check::share("rtol", rtol))?;
                if *max != f64::INFINITY {
                    check::above_zero("max_step", *max)?;
                }
                first.map_or(Ok(0.0), |step| check::above_zero("first_step", step))?;
                atol.iter().try_for_each(|&atol| check::above_zero("atol", atol).map(drop))?;
                if !(0.0..0.2).contains(beta) {
                    let (name, value) = ("pi_beta".into(), *beta);
                    return Err(ParameterError::OutOfRange { name, value, allowed: "[0, 0.2)" });
                }
                if let [one] = atol[..] {
                    return Ok(vec![one; components]);
                }
                check::length("atol", atol.len(), components)?;
                Ok(atol.clone())
            }
        }
    }
}

/// Resolution of the time, as a share of |t| `[1]`: shorter steps are lost in rounding.
pub(crate) const RESOLUTION: f64 = 4.0 * f64::EPSILON;

/// Length of a step from `t` that serves only to report a crossing at its start. `h`: the length attempted.
pub(crate) fn shortest(t: f64, h: f64) -> f64 {
    2.0 * RESOLUTION * t.abs().max(h)
}

/// The end of the next step: a point of the grid start + count h for a fixed step, t + h for an adaptive one.
pub(crate) struct StepEnds {
    /// The fixed step, or the proposed length of the next adaptive step.
    pub(crate) h: f64,
    /// Fixed step: the next point of the grid. Adaptive step: the proposed length of the step after the next.
    pub(crate) next: f64,
    /// Start of the grid.
    start: f64,
    /// Number of `next` on the grid; the start is 0.
    count: f64,
    /// Maximum step.
    max: f64,
    pub(crate) controller: Controller,
}

impl StepEnds {
    /// `exponent`: of the step size control.
    pub(crate) fn new<T: Tableau>(
        start: f64,
        h: f64,
        tolerances: Option<&Tolerances>,
        exponent: f64,
    ) -> Self {
        let next = if T::ADAPTIVE { h } else { start + h };
        let (max, beta) = tolerances.map_or((h, 0.0), |tolerances| (tolerances.max, tolerances.beta));
        StepEnds { h, next, start, count: 1.0, max, controller: Controller::new::<T>(exponent, beta) }
    }

    /// Length of the next step if nothing lies in its way.
    #[inline(always)]
    pub(crate) fn length<T: Tableau>(&self) -> f64 {
        if T::ADAPTIVE { self.h.min(self.max) } else { self.h }
    }

    /// End of the step from `t`; at the latest `stop`.
    #[inline(always)]
    pub(crate) fn aim<T: Tableau>(&self, t: f64, stop: f64) -> f64 {
        let h = self.length::<T>();
        let aim = if T::ADAPTIVE { t + h } else { self.next };
        if aim + 1e-10 * h >= stop {
            seldom();
            stop
        } else if T::ADAPTIVE && aim + 0.5 * h > stop {
            t + 0.5 * (stop - t) // two equal steps instead of a full and a very short one
        } else {
            aim
        }
    }

    /// Moves on after an accepted step that ended as planned.
    #[inline(always)]
    pub(crate) fn arrive<T: Tableau>(&mut self) {
        if T::ADAPTIVE {
            self.h = self.next;
        } else {
            self.count += 1.0;
            self.next = self.grid(0);
        }
    }

    /// Point `ahead` of the grid, counted from the next one.
    #[inline(always)]
    pub(crate) fn grid(&self, ahead: usize) -> f64 {
        self.start + (self.count + ahead as f64) * self.h
    }

    /// Moves on after an accepted step that may have been shortened and ended at `t`. A grid point after `t`
    /// remains the next one.
    pub(crate) fn pass<T: Tableau>(&mut self, t: f64) {
        if T::ADAPTIVE || self.next <= t + 1e-10 * self.h {
            self.arrive::<T>();
        }
    }
}

/// The ends of adaptive steps at knots of the drives ([`Model::next_knot`]). The error estimate assumes
/// smooth drives, so a step ends at the next knot. A step that contains more than two knots does not.
pub(crate) struct Knots<'m> {
    /// The model whose drives have knots; `None` without them.
    model: Option<&'m dyn Model>,
    /// The next instant at which a step ends; infinite if steps pass over the next knots.
    next: f64,
    /// Time from which the model is asked again.
    asked: f64,
    /// Length of the step for which the model was asked. The model is asked again if the step becomes shorter
    /// than half of it.
    length: f64,
}

impl<'m> Knots<'m> {
    /// Maximum number of knots within a step at which steps end at the next knot.
    const SPANNED: usize = 2;

    /// Number of steps that pass over knots before the model is asked again.
    const PASSED: f64 = 8.0;

    /// A step does not end at a knot whose distance is below this share of its length.
    const BESIDE: f64 = 1e-3;

    /// The knots after `t`; none for fixed steps.
    pub(crate) fn of<T: Tableau>(model: &'m dyn Model, t: f64) -> Self {
        let model = Some(model).filter(|model| T::ADAPTIVE && model.next_knot(t).is_some());
        Knots { model, next: f64::INFINITY, asked: t, length: 0.0 }
    }

    /// Latest end of a step `h` from `t`: a knot, or `stop` if no knot lies before it.
    #[inline(always)]
    pub(crate) fn stop(&mut self, t: f64, h: f64, stop: f64) -> f64 {
        let Some(model) = self.model else { return stop };
        let passes = self.next == f64::INFINITY;
        if t + Self::BESIDE * h >= self.asked || (passes && h < 0.5 * self.length) {
            self.ask(model, t, h);
        }
        if self.next + Self::BESIDE * h < stop { self.next } else { stop }
    }

    fn ask(&mut self, model: &dyn Model, t: f64, h: f64) {
        let after = |t: f64| model.next_knot(t + Self::BESIDE * h).filter(|knot| *knot > t);
        let in_step = |knot: f64| after(knot).filter(|next| *next <= t + h);
        let first = after(t);
        let many = (0..Self::SPANNED).try_fold(first, |knot, _| knot.and_then(in_step).map(Some)).is_some();
        self.length = h;
        (self.next, self.asked) = match first {
            Some(first) if !many => (first, first),
            _ => (f64::INFINITY, t + Self::PASSED * h),
        };
    }
}

/// h_new = 0.9 h err^(-α) err_old^β, α = 1/k - 0.75 β, 1/k = `exponent` of the tableau: PI control of the
/// step size.   Source: Hairer, Nørsett & Wanner I, Eq. (4.13), and II, Sect. IV.2.
///
/// err_old is the error of the last accepted step. The ratio h_new/h stays within `factors`. The step does
/// not grow after a rejection.
pub(crate) struct Controller {
    /// α.
    exponent: f64,
    beta: f64,
    /// Minimum and maximum of h_new/h.
    factors: [f64; 2],
    /// ln max(err_old, 1e-4).
    old: f64,
    /// Whether the last attempt was rejected.
    rejected: bool,
}

impl Controller {
    const SAFETY: f64 = 0.9;

    pub(crate) fn new<T: Tableau>(exponent: f64, beta: f64) -> Self {
        Controller {
            exponent: exponent - 0.75 * beta,
            beta,
            factors: T::FACTORS,
            old: f64::ln(1e-4),
            rejected: false,
        }
    }

    /// Length of the next step after a step `h` with this error, and whether the step `h` is accepted.
    #[inline]
    pub(crate) fn next(&mut self, h: f64, error: f64) -> (f64, bool) {
        let [least, most] = self.factors;
        // The logarithm of an error of 0 is finite as well.
        let log = error.max(f64::MIN_POSITIVE).ln();
        if error <= 1.0 {
            let shrink = (self.exponent * log - self.beta * self.old).exp() / Self::SAFETY;
            let limit = if self.rejected { 1.0 } else { most };
            self.old = log.max(f64::ln(1e-4));
            self.rejected = false;
            (h / shrink.clamp(1.0 / limit, 1.0 / least), true)
        } else {
            self.rejected = true;
            let raw = (self.exponent * log).exp() / Self::SAFETY;
            (h / raw.min(1.0 / least), false)
        }
    }

    /// Length of the next attempt after a step `h` without a finite result: h/10.
    pub(crate) fn retreat(&mut self, h: f64) -> f64 {
        self.rejected = true;
        0.1 * h
    }
}

/// Marks a branch as rarely taken. The compiler then emits a jump, and the processor continues with the
/// predicted branch; a conditional move would wait for both.
#[cold]
#[inline]
fn seldom() {}

/// The least guess, in units of the resolution of the time.
const LEAST: f64 = 64.0;

/// First step from the norms d0, d1, d2 of the solution and its first and second derivative, in units of the
/// tolerances.   Source: Hairer, Nørsett & Wanner I, Sect. II.4, p. 169.
///
/// h0 = 0.01 d0/d1,   h1 = (0.01/max(d1, d2))^(1/k),   h = min(100 h0, h1, longest)
///
/// It is a guess: at late times it is no shorter than [`LEAST`] times the resolution of the time, and the
/// errors of the steps decide.
///
/// `exponent`: 1/k.
pub(crate) fn starting_step<V: Vector>(e: &mut Engine<'_, V>, longest: f64, exponent: f64) -> f64 {
    let rms = |v: &mut dyn Iterator<Item = f64>| {
        let (count, sum) = v.fold((0.0, 0.0), |(c, s), x| (c + 1.0, s + x * x));
        f64::sqrt(sum / f64::max(count, 1.0))
    };
    let size: Vec<f64> =
        e.ends.y.slice().iter().zip(e.ends.atol.slice()).map(|(y, atol)| atol + e.rtol * y.abs()).collect();
    let slope: Vec<f64> = e.k[0].slice().to_vec();
    let d0 = rms(&mut e.ends.y.slice().iter().zip(&size).map(|(y, s)| y / s));
    let d1 = rms(&mut slope.iter().zip(&size).map(|(f, s)| f / s));
    let h0 = if d0 < 1e-5 || d1 < 1e-5 { 1e-6 } else { 0.01 * d0 / d1 };
    let least = LEAST * RESOLUTION * e.ends.t.abs();
    let h0 = h0.max(least).min(longest);
    e.aim(e.ends.t + h0);
    e.euler();
    let d2 = rms(&mut e.k[1].slice().iter().zip(&slope).zip(&size).map(|((f1, f0), s)| (f1 - f0) / s)) / h0;
    let d = d1.max(d2);
    let h1 = if d <= 1e-15 { (h0 * 1e-3).max(1e-6) } else { (0.01 / d).powf(exponent) };
    let h = (100.0 * h0).min(h1).max(least).min(longest);
    if h.is_finite() && h > 0.0 { h } else { h0 }
}

#[cfg(test)]
mod tests {
    use crate::ode::methods::dop853::DormandPrince8;
    use crate::ode::stepping::control::Controller;

    /// An error of 0 has a next step, also where the exponent of the error is exactly 0 (β = 1/6).
    #[test]
    fn steps_after_an_error_of_zero() {
        for (beta, next) in [(0.0, 6.0), (1.0 / 6.0, 0.333)] {
            let mut controller = Controller::new::<DormandPrince8>(0.125, beta);
            let (h, accepted) = controller.next(1.0, 0.0);
            assert!(accepted && (h - next).abs() < 1e-12, "{beta} {h}");
        }
    }
}
