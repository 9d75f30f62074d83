//! The search of the best constants within a box.

use crate::branches::design::objective::DesignError;
use crate::error::{ParameterError, check};
use crate::model::equations::Constants;
use crate::ode::Budget;
use crate::periodic::Shooting;
use slsqp::{FailStatus, StopTols, SuccessStatus};
use std::cell::RefCell;

/// Settings of a search of the best constants: [`Least`](crate::branches::Least) or
/// [`Fit`](crate::branches::Fit).
///
/// ```
/// use gear_dynamics::branches::{Figure, Least};
/// let least = Least::new("deflection", Figure::Rms).over("mesh damping", 0.02, 0.3).tolerance(1e-6);
/// assert_eq!(least, Least::new("deflection", Figure::Rms).tolerance(1e-6).over("mesh damping", 0.02, 0.3));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Search<T> {
    /// What is minimised.
    pub(crate) objective: T,
    /// Names and bounds of the constants.
    pub(crate) over: Vec<(String, [f64; 2])>,
    pub(crate) tolerance: f64,
    pub(crate) max_evaluations: usize,
    pub(crate) shooting: Shooting,
    pub(crate) budget: Budget,
    /// Least size of the objective.
    least_unit: f64,
}

/// The box of the constants, scaled to 0 .. 1.
pub(crate) struct Space {
    names: Vec<String>,
    indices: Vec<usize>,
    bounds: Vec<[f64; 2]>,
}

impl Space {
    /// The box and the place of the model in it.
    pub(crate) fn new(
        constants: &dyn Constants,
        over: &[(String, [f64; 2])],
    ) -> Result<(Self, Vec<f64>), DesignError> {
        if over.is_empty() {
            let name = "constants of the design".into();
            return Err(ParameterError::Empty { name, min: 1 }.into());
        }
        let mut space = Space { names: Vec::new(), indices: Vec::new(), bounds: Vec::new() };
        let mut start = Vec::new();
        for (name, [low, high]) in over {
            let index = constants.index(name)?;
            if space.indices.contains(&index) {
                return Err(ParameterError::Twice { name: name.clone() }.into());
            }
            let value = constants.values()[index];
            check::between(name, value, [*low, *high])?;
            start.push((value - low) / (high - low));
            space.names.push(name.clone());
            space.indices.push(index);
            space.bounds.push([*low, *high]);
        }
        Ok((space, start))
    }
    /// The values of the constants at a place in the box.
    pub(crate) fn values(&self, x: &[f64]) -> Vec<(usize, f64)> {
        let value = |(k, x): (usize, &f64)| {
            let [low, high] = self.bounds[k];
            // At the ends of the box the bounds themselves.
            let inside = low + x.clamp(0.0, 1.0) * (high - low);
            (self.indices[k], if *x >= 1.0 { high } else { inside })
        };
        x.iter().enumerate().map(value).collect()
    }
    /// The derivatives with respect to the place, from those with respect to all constants.
    pub(crate) fn gradient(&self, all: &[f64]) -> Vec<f64> {
        let slope = |(index, [low, high]): (&usize, &[f64; 2])| all[*index] * (high - low);
        self.indices.iter().zip(&self.bounds).map(slope).collect()
    }
    pub(crate) fn named(&self, x: &[f64]) -> Vec<(String, f64)> {
        self.names.iter().cloned().zip(self.values(x).into_iter().map(|(_, value)| value)).collect()
    }
}

/// Returns the value of an objective and its gradient at a place in the box.
pub(crate) type Evaluate<'e> = dyn Fn(&[f64]) -> Result<(f64, Vec<f64>), DesignError> + 'e;

/// A place and the value of the objective there.
pub(crate) struct Minimum {
    pub(crate) x: Vec<f64>,
    pub(crate) value: f64,
    pub(crate) evaluations: usize,
}

impl<T> Search<T> {
    /// Defaults: a tolerance of 1e-8, 200 evaluations, default [`Shooting`] and [`Budget`]. `least_unit`:
    /// least size of the objective.
    pub(crate) fn of(objective: T, least_unit: f64) -> Self {
        Search {
            objective,
            over: Vec::new(),
            tolerance: 1e-8,
            max_evaluations: 200,
            shooting: Shooting::new(),
            budget: Budget::new(),
            least_unit,
        }
    }
    /// Adds a constant and its bounds.
    pub fn over(mut self, name: &str, low: f64, high: f64) -> Self {
        self.over.push((name.into(), [low, high]));
        self
    }
    /// Change of the constants, as a share of their bounds, below which the search ends `[1]`. Default: 1e-8.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Search { tolerance, ..self }
    }
    /// Maximum number of evaluations. Default: 200.
    pub fn max_evaluations(self, max_evaluations: usize) -> Self {
        Search { max_evaluations, ..self }
    }
    /// The solver of the orbits.
    pub fn shooting(self, shooting: Shooting) -> Self {
        Search { shooting, ..self }
    }
    /// Maximum number of integration steps of the derivatives, and maximum time of the search with all its
    /// orbits. Each orbit has the step limit of its [`Shooting`], too. Default: default [`Budget`].
    pub fn budget(self, budget: Budget) -> Self {
        Search { budget, ..self }
    }

    /// Minimises a function with its gradient over the box by SLSQP.
    pub(crate) fn minimise(
        &self,
        space: &Space,
        start: &[f64],
        evaluate: &Evaluate<'_>,
    ) -> Result<Minimum, DesignError> {
        let (tolerance, max_evaluations) = (self.tolerance, self.max_evaluations);
        check::positive("tolerance", tolerance)?;
        check::at_least("max_evaluations", max_evaluations, 1)?;
        let max_evaluations = max_evaluations.min(MOST);
        struct Progress {
            best: Option<(Vec<f64>, f64)>,
            failed: Option<DesignError>,
            evaluations: usize,
            /// Size of the objective at the start.
            unit: f64,
            /// The largest value so far, over the unit.
            largest: f64,
        }
        let progress =
            RefCell::new(Progress { best: None, failed: None, evaluations: 0, unit: 0.0, largest: 0.0 });
        let objective = |x: &[f64], gradient: Option<&mut [f64]>, (): &mut ()| -> f64 {
            let mut progress = progress.borrow_mut();
            progress.evaluations += 1;
            match evaluate(x) {
                Ok((value, slopes)) if value.is_finite() => {
                    progress.failed = None;
                    if progress.unit == 0.0 {
                        progress.unit = if value == 0.0 { 1.0 } else { value.abs().max(self.least_unit) };
                    }
                    progress.largest = progress.largest.max(value / progress.unit);
                    if progress.best.as_ref().is_none_or(|(_, best)| value < *best) {
                        progress.best = Some((x.to_vec(), value));
                    }
                    if let Some(gradient) = gradient {
                        gradient.iter_mut().zip(&slopes).for_each(|(g, s)| *g = s / progress.unit);
                    }
                    value / progress.unit
                }
                failed => {
                    // Far from the last orbit there may be none: the large value makes the line search
                    // shorten its step.
                    if let Some(gradient) = gradient {
                        gradient.fill(0.0);
                    }
                    let undefined = || ParameterError::NotFinite { name: "figure".into(), value: f64::NAN };
                    progress.failed = Some(failed.err().unwrap_or_else(|| undefined().into()));
                    NO_ORBIT.max(WORSE * progress.largest)
                }
            }
        };
        let bounds = vec![(0.0, 1.0); start.len()];
        let constraints: [&dyn slsqp::Func<()>; 0] = [];
        let stop = StopTols { xtol_abs: vec![tolerance; start.len()], ftol_rel: FLAT, ..StopTols::default() };
        let outcome =
            slsqp::minimize(objective, start, &bounds, &constraints, (), max_evaluations, Some(stop));
        let Progress { best, failed, evaluations, .. } = progress.into_inner();
        let Some((x, value)) = best else {
            let none = DesignError::Parameter(ParameterError::Empty { name: "design".into(), min: 1 });
            return Err(failed.unwrap_or(none));
        };
        if let Some(error) = failed {
            let (reason, constants) = (error.to_string(), space.named(&x));
            return Err(DesignError::NotConverged { reason, evaluations, value, constants });
        }
        let reason = match outcome {
            Ok((SuccessStatus::MaxEvalReached, ..)) => {
                "the maximum number of evaluations is reached".to_owned()
            }
            // Rounding limits the search only where it has converged.
            Ok(_) | Err((FailStatus::RoundoffLimited, ..)) => return Ok(Minimum { x, value, evaluations }),
            Err((status, ..)) => format!("{status:?}"),
        };
        let constants = space.named(&x);
        Err(DesignError::NotConverged { reason, evaluations, value, constants })
    }
}

/// Maximum number of evaluations that the optimiser can count.
const MOST: usize = i32::MAX as usize;

/// The objective, over its size at the start, where no orbit is found; at least.
const NO_ORBIT: f64 = 1e3;

/// The same over the largest value so far.
const WORSE: f64 = 10.0;

/// Relative change of the objective below which the search ends `[1]`.
const FLAT: f64 = 1e-14;
