//! The least figure of an orbit over constants of its model.

use crate::branches::design::objective::{DesignError, Figure};
use crate::branches::design::reach::reach;
use crate::branches::sensitivity::sensitivity_of_orbit::{Sensitivity, constants_of};
use crate::error::check;
use crate::model::constants::Constants;
use crate::model::equations::{Periodic, State};
use crate::periodic::shooting::multiple::Shooting;
use crate::periodic::shooting::shooting_orbit::ShootingOrbit;
use slsqp::{FailStatus, StopTols, SuccessStatus};
use std::cell::RefCell;

/// Minimises a figure of a periodic orbit over named constants within bounds.
///
/// Gradients are those of [`Sensitivity`], exact along the orbit. The optimiser is SLSQP. A local minimum is
/// found; at a change of the contact sequence the figure has a kink.   Source: Kraft (1988), as in NLopt.
///
/// ```
/// use gear_dynamics::{State, branches::{Figure, Least}, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[], &[0.02])?.parts()?.build("driver", 0.7)?;
/// let least = Least::new("deflection", Figure::PeakToPeak).over("mesh damping", 0.02, 0.3);
/// let best = least.run(&pair, &[State::new(0.0, &[1.1], &[0.0])])?;
/// assert!((best.constants[0].1 - 0.3).abs() < 1e-9); // the largest damping moves the teeth least
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Least {
    channel: String,
    figure: Figure,
    over: Vec<(String, [f64; 2])>,
    tolerance: f64,
    max_evaluations: usize,
    shooting: Shooting,
}

/// The result of [`Least`] or [`Fit`](crate::branches::Fit).
///
/// ```
/// # use gear_dynamics::{State, branches::{Figure, Least}, trains::SpurPair};
/// # let pair = SpurPair::of_numbers(0.05, 0.1, &[], &[0.02])?.parts()?.build("driver", 0.7)?;
/// # let least = Least::new("deflection", Figure::Max).over("mesh damping", 0.02, 0.3);
/// let best = least.run(&pair, &[State::new(0.0, &[1.1], &[0.0])])?;
/// assert!(best.value > 0.0 && best.evaluations < 20);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Optimum {
    /// Names and values of the constants.
    pub constants: Vec<(String, f64)>,
    /// The figure; for a fit the sum of the squares of the relative deviations.
    pub value: f64,
    /// Number of orbits that were measured with their derivatives.
    pub evaluations: usize,
    /// The orbit of the optimum; for a fit that of the last measured point.
    pub orbit: ShootingOrbit,
}

impl Least {
    /// The least `figure` of a channel (see [`Probe`](crate::analysis::Probe)).
    ///
    /// Defaults: a tolerance of 1e-8, 200 evaluations, default [`Shooting`].
    pub fn new(channel: &str, figure: Figure) -> Self {
        let (over, shooting) = (Vec::new(), Shooting::new());
        Least { channel: channel.into(), figure, over, tolerance: 1e-8, max_evaluations: 200, shooting }
    }
    /// Adds a constant and its bounds.
    pub fn over(mut self, name: &str, low: f64, high: f64) -> Self {
        self.over.push((name.into(), [low, high]));
        self
    }
    /// Change of the constants, as a share of their bounds, below which the search ends `[1]`. Default: 1e-8.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Least { tolerance, ..self }
    }
    /// Maximum number of evaluations. Default: 200.
    pub fn max_evaluations(self, max_evaluations: usize) -> Self {
        Least { max_evaluations, ..self }
    }
    /// The solver of the orbits.
    pub fn shooting(self, shooting: Shooting) -> Self {
        Least { shooting, ..self }
    }

    /// Searches from the constants of `model` and the orbit near a guess.
    ///
    /// # Errors
    /// [`DesignError`]; if the optimiser does not converge, the error holds the best constants.
    pub fn run<M: Periodic>(&self, model: &M, guess: &[State]) -> Result<Optimum, DesignError> {
        let (constants, model) = (constants_of(model)?, model as &dyn Periodic);
        let (space, start) = Space::new(constants, &self.over)?;
        let orbit = self.shooting.run(model, guess)?;
        let last = RefCell::new((space.values(&start), orbit));
        let best: RefCell<Option<(f64, ShootingOrbit)>> = RefCell::new(None);
        let evaluate = |x: &[f64]| -> Result<(f64, Vec<f64>), DesignError> {
            let values = space.values(x);
            let mut last = last.borrow_mut();
            let orbit = reach(constants, &self.shooting, &last.1, &last.0, &values)?;
            let model = constants.with_values(&values)?;
            let value = self.figure.value(&*model, &orbit, &self.channel)?;
            let sensitivity = Sensitivity::of(&&*model, &orbit, &[&self.channel])?;
            let all = self.figure.slopes(&sensitivity, &self.channel)?;
            let mut best = best.borrow_mut();
            if best.as_ref().is_none_or(|(least, _)| value < *least) {
                *best = Some((value, orbit.clone()));
            }
            *last = (values, orbit);
            Ok((value, space.gradient(&all)))
        };
        let found = minimise(&space, &start, self.tolerance, self.max_evaluations, &evaluate)?;
        let orbit = best.into_inner().map_or_else(|| last.into_inner().1, |(_, orbit)| orbit);
        let constants = space.named(&found.x);
        Ok(Optimum { constants, value: found.value, evaluations: found.evaluations, orbit })
    }
}

/// The box of the constants, scaled to 0 .. 1.
pub(crate) struct Space {
    names: Vec<String>,
    places: Vec<usize>,
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
            return Err(crate::error::ParameterError::Empty { name, min: 1 }.into());
        }
        let mut space = Space { names: Vec::new(), places: Vec::new(), bounds: Vec::new() };
        let mut start = Vec::new();
        for (name, [low, high]) in over {
            let place = constants.place(name)?;
            if space.places.contains(&place) {
                return Err(crate::error::ParameterError::ConstantTwice { name: name.clone() }.into());
            }
            check::all_finite("bounds of a constant", &[*low, *high])?;
            let value = constants.values()[place];
            if !(low < high && (*low..=*high).contains(&value)) {
                return Err(DesignError::Bounds { name: name.clone(), low: *low, high: *high, value });
            }
            start.push((value - low) / (high - low));
            space.names.push(name.clone());
            space.places.push(place);
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
            (self.places[k], if *x >= 1.0 { high } else { inside })
        };
        x.iter().enumerate().map(value).collect()
    }
    /// The derivatives with respect to the place, from those with respect to all constants.
    pub(crate) fn gradient(&self, all: &[f64]) -> Vec<f64> {
        let slope = |(place, [low, high]): (&usize, &[f64; 2])| all[*place] * (high - low);
        self.places.iter().zip(&self.bounds).map(slope).collect()
    }
    pub(crate) fn named(&self, x: &[f64]) -> Vec<(String, f64)> {
        self.names.iter().cloned().zip(self.values(x).into_iter().map(|(_, value)| value)).collect()
    }
}

/// Returns the value of an objective and its gradient at a place in the box.
pub(crate) type Evaluate<'e> = dyn Fn(&[f64]) -> Result<(f64, Vec<f64>), DesignError> + 'e;

/// A place and the value of the objective there.
pub(crate) struct Found {
    pub(crate) x: Vec<f64>,
    pub(crate) value: f64,
    pub(crate) evaluations: usize,
}

/// Minimises a function with its gradient over the box by SLSQP.
pub(crate) fn minimise(
    space: &Space,
    start: &[f64],
    tolerance: f64,
    max_evaluations: usize,
    evaluate: &Evaluate<'_>,
) -> Result<Found, DesignError> {
    check::positive("tolerance", tolerance)?;
    if max_evaluations == 0 {
        let name = "max_evaluations".into();
        return Err(crate::error::ParameterError::TooFew { name, value: 0, min: 1 }.into());
    }
    let max_evaluations = max_evaluations.min(MOST);
    struct Progress {
        best: Option<(Vec<f64>, f64)>,
        failed: Option<DesignError>,
        evaluations: usize,
        /// Size of the objective at the start.
        unit: f64,
    }
    let progress = RefCell::new(Progress { best: None, failed: None, evaluations: 0, unit: 0.0 });
    let objective = |x: &[f64], gradient: Option<&mut [f64]>, (): &mut ()| -> f64 {
        let mut progress = progress.borrow_mut();
        progress.evaluations += 1;
        match evaluate(x) {
            Ok((value, slopes)) => {
                progress.failed = None;
                if progress.unit == 0.0 {
                    progress.unit = if value == 0.0 { 1.0 } else { value.abs() };
                }
                if progress.best.as_ref().is_none_or(|(_, best)| value < *best) {
                    progress.best = Some((x.to_vec(), value));
                }
                if let Some(gradient) = gradient {
                    gradient.iter_mut().zip(&slopes).for_each(|(g, s)| *g = s / progress.unit);
                }
                value / progress.unit
            }
            Err(error) => {
                // Far from the last orbit there may be none: the large value makes the line search shorten its
                // step.
                if let Some(gradient) = gradient {
                    gradient.fill(0.0);
                }
                progress.failed = Some(error);
                NO_ORBIT
            }
        }
    };
    let bounds = vec![(0.0, 1.0); start.len()];
    let constraints: [&dyn slsqp::Func<()>; 0] = [];
    let stop = StopTols { xtol_abs: vec![tolerance; start.len()], ftol_rel: FLAT, ..StopTols::default() };
    let outcome = slsqp::minimize(objective, start, &bounds, &constraints, (), max_evaluations, Some(stop));
    let Progress { best, failed, evaluations, .. } = progress.into_inner();
    let Some((x, value)) = best else {
        let none =
            DesignError::Parameter(crate::error::ParameterError::Empty { name: "design".into(), min: 1 });
        return Err(failed.unwrap_or(none));
    };
    if let Some(error) = failed {
        let (reason, constants) = (error.to_string(), space.named(&x));
        return Err(DesignError::NotConverged { reason, evaluations, best: value, constants });
    }
    let reason = match outcome {
        Ok((SuccessStatus::MaxEvalReached, ..)) => "the maximum number of evaluations is reached".to_owned(),
        // Rounding limits the search only where it has converged.
        Ok(_) | Err((FailStatus::RoundoffLimited, ..)) => return Ok(Found { x, value, evaluations }),
        Err((status, ..)) => format!("{status:?}"),
    };
    let constants = space.named(&x);
    Err(DesignError::NotConverged { reason, evaluations, best: value, constants })
}

/// Maximum number of evaluations that the optimiser can count.
const MOST: usize = i32::MAX as usize;

/// The objective, over its size at the start, where no orbit is found.
const NO_ORBIT: f64 = 1e3;

/// Relative change of the objective below which the search ends `[1]`.
const FLAT: f64 = 1e-14;
