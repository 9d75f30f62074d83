//! Path integration: settings and calls.

use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::model::{Model, Periodic};
use crate::ode::budget::{Budget, Meter};
use crate::random::density::density_error::DensityError;
use crate::random::density::edges::edges_at_start;
use crate::random::density::fixed_point::Iteration;
use crate::random::density::grid::Grid;
use crate::random::density::panels::Panels;
use crate::random::density::periodic_density::PeriodicDensity;
use crate::random::density::run::{FixedPoint, LARGEST_OUTSIDE, Problem};
use crate::random::density::state_density::{Errors, Fine, StateDensity};
use crate::random::density::steps::schedule::Schedule;
use std::fmt::{self, Debug, Formatter};
use std::sync::Arc;

/// Densities of x'' = a(u(t), x, v) + √D ξ(t), ξ white noise, without sampling. D is the **intensity**: the
/// velocity gains the variance D h in a short time h.
///
/// A step of length h takes the density through half of a random step of the velocity, the motion of the
/// model without noise, and the other half. The random step is exact and contains the mean damping κ of the
/// model; what remains of a(u, x, v) + κ v is followed backwards in time from each node of a grid, edges
/// located. The grid has borders at the edges, so that the kinks of the density lie between polynomials.
/// Repetition, accelerated, gives the density that no longer changes. Two steps are extrapolated
/// (Richardson), and a second grid gives the error.   Source: Naess and Moe 2000, Strang 1968.
///
/// ```
/// use gear_dynamics::models::Oscillator;
/// use gear_dynamics::random::PathIntegration;
/// use std::f64::consts::PI;
/// // x'' + 0.5 x' + g(x) = ξ(t): ξ is white noise, g(x) the force of a dead zone of half backlash 1;
/// // β = 2c/D = 1.
/// let pair = [("speed", 1.0), ("damping", 0.5), ("mesh stiffness", 1.0), ("half backlash", 1.0)];
/// let method = PathIntegration::new(1.0, [-6.0, 6.0], [-5.0, 5.0])?.panels(5);
/// let density = method.stationary(&Oscillator::new(&pair)?)?;
/// let gap = 2.0 / (2.0 + (2.0 * PI).sqrt()); // the exact share of time in the gap
/// assert!((density.share(-1.0, 1.0) - gap).abs() < 0.01 && density.total_error() < 0.05);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
#[must_use = "a setting returns a new value"]
pub struct PathIntegration<'w> {
    intensity: f64,
    deflections: [f64; 2],
    velocities: [f64; 2],
    panels: usize,
    time_step: Option<f64>,
    tolerance: f64,
    budget: Budget,
    progress: Option<Arc<dyn Fn(usize, f64) + Send + Sync + 'w>>,
}

impl Debug for PathIntegration<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.debug_struct("PathIntegration")
            .field("intensity", &self.intensity)
            .field("deflections", &self.deflections)
            .field("velocities", &self.velocities)
            .field("panels", &self.panels)
            .field("time_step", &self.time_step)
            .finish_non_exhaustive()
    }
}

impl<'w> PathIntegration<'w> {
    /// Intensity D [v²/time] and the ranges of deflections and velocities outside of which the density is
    /// negligible: six standard deviations on both sides are enough.
    ///
    /// Defaults: 12 panels, a step that follows from the ranges, the tolerance 1e-9, the default [`Budget`].
    ///
    /// # Errors
    /// An intensity that is not positive; ranges that are reversed or do not contain the velocity 0.
    pub fn new(intensity: f64, deflections: [f64; 2], velocities: [f64; 2]) -> Result<Self, ParameterError> {
        check::scale("intensity", intensity)?;
        check::quantities("range of deflections", &deflections)?;
        check::quantities("range of velocities", &velocities)?;
        check::scale("length of the range of deflections", deflections[1] - deflections[0])?;
        check::scale("length of the range of velocities", velocities[1] - velocities[0])?;
        check::between("velocity", 0.0, velocities)?;
        let (panels, time_step, tolerance) = (12, None, 1e-9);
        let budget = Budget::new();
        Ok(PathIntegration {
            intensity,
            deflections,
            velocities,
            panels,
            time_step,
            tolerance,
            budget,
            progress: None,
        })
    }
    /// Number of panels over each range, 2 to 200; each has polynomials of degree 8. Default: 12. Intervals
    /// between edges have at least one panel each.
    pub fn panels(self, panels: usize) -> Self {
        PathIntegration { panels, ..self }
    }
    /// The longer of the two time steps. Default: a fifth of the range of deflections over that of
    /// velocities.
    pub fn time_step(self, time_step: f64) -> Self {
        PathIntegration { time_step: Some(time_step), ..self }
    }
    /// The change ∫∫ |p_{k+1} - p_k| dx dv at which the repetition ends. Default: 1e-9.
    pub fn tolerance(self, tolerance: f64) -> Self {
        PathIntegration { tolerance, ..self }
    }
    /// Limits of one call, with the flag that cancels it. A step of the density counts as a step.
    pub fn budget(self, budget: Budget) -> Self {
        PathIntegration { budget, ..self }
    }
    /// Function that is called after every repetition with the number of repetitions and the last change of
    /// the density. There are three runs; the numbers start again in each.
    pub fn repetition_callback(mut self, progress: impl Fn(usize, f64) + Send + Sync + 'w) -> Self {
        self.progress = Some(Arc::new(progress));
        self
    }

    /// The stationary density of a model with constant drives.
    ///
    /// # Errors
    /// [`DensityError`].
    pub fn stationary(&self, model: &(dyn Model + Sync)) -> Result<StateDensity, DensityError> {
        let step = self.check(model)?;
        self.check_constant(model)?;
        let duration = 6.0 * self.natural_time();
        let (_, mean) = self.solve(model, Schedule::of_constant(duration, step)?)?;
        Ok(mean)
    }

    /// The periodic density of a model with periodic drives.
    ///
    /// # Errors
    /// [`DensityError`].
    pub fn run(&self, model: &(dyn Periodic + Sync)) -> Result<PeriodicDensity, DensityError> {
        let step = self.check(model)?;
        let period = check::scale("period of the model", model.period())?;
        let schedule = Schedule::over_period(model, period, step)?;
        let times = schedule.ends().into_iter().rev().skip(1).rev();
        let times = std::iter::once(0.0).chain(times).collect();
        let (instants, mean) = self.solve(model, schedule)?;
        Ok(PeriodicDensity { times, instants, mean })
    }

    /// The time in which a motion crosses the range: of the order of 1/ω.
    fn natural_time(&self) -> f64 {
        let length = |range: [f64; 2]| range[1] - range[0];
        length(self.deflections) / length(self.velocities)
    }

    /// Checks settings and model. The step.
    fn check(&self, model: &dyn Model) -> Result<f64, DensityError> {
        check::at_least("panels", self.panels, 2)?;
        check::count("panels", &[self.panels], 200)?;
        check::tolerance("tolerance", self.tolerance)?;
        let step = check::scale("time step", self.time_step.unwrap_or(0.2 * self.natural_time()))?;
        if model.dof() != 1 {
            return Err(DensityError::Dof { dof: model.dof() });
        }
        model.offers().refuse_stops(|contact| DensityError::RigidStop { contact })?;
        Ok(step)
    }

    /// The states at the middles of a grid of 16 × 16 cells.
    fn samples(&self) -> impl Iterator<Item = [f64; 2]> {
        let at = |[low, high]: [f64; 2], k: usize| low + (high - low) * (k as f64 + 0.5) / 16.0;
        let (deflections, velocities) = (self.deflections, self.velocities);
        (0..256).map(move |k| [at(deflections, k / 16), at(velocities, k % 16)])
    }

    /// Compares the accelerations at several times.
    fn check_constant(&self, model: &dyn Model) -> Result<(), DensityError> {
        let accelerations = |t: f64| {
            let mut u = vec![0.0; model.drives()];
            model.drive(t, Side::After, &mut u);
            let at = |[x, v]: [f64; 2]| acceleration(model, &u, x, v);
            self.samples().map(at).collect::<Vec<f64>>()
        };
        let first = accelerations(0.0);
        for k in 1..=16 {
            let t = 0.618 * f64::from(k) * self.natural_time();
            if accelerations(t) != first {
                return Err(DensityError::Varies { t });
            }
        }
        Ok(())
    }

    /// κ: the mean of -∂a/∂v at t = 0 over the middle halves of the ranges.
    fn mean_damping(&self, model: &dyn Model) -> Result<f64, DensityError> {
        let mut u = vec![0.0; model.drives()];
        model.drive(0.0, Side::After, &mut u);
        let middle = |[low, high]: [f64; 2], x: f64| 0.25 * (low + high) + 0.5 * x;
        let width = 1e-2 * (self.velocities[1] - self.velocities[0]);
        let slope = |[x, v]: [f64; 2]| {
            let (x, v) = (middle(self.deflections, x), middle(self.velocities, v));
            (acceleration(model, &u, x, v - width) - acceleration(model, &u, x, v + width)) / (2.0 * width)
        };
        let mean = self.samples().map(slope).sum::<f64>() / 256.0;
        Ok(check::quantity("mean damping of the model", mean)?)
    }

    fn grid<const N: usize>(&self, model: &dyn Model) -> Grid<N> {
        let edges = edges_at_start(model, self.deflections, self.velocities[1]);
        Grid {
            x: Panels::new(self.deflections, &edges, self.panels),
            v: Panels::new(self.velocities, &[0.0], self.panels),
        }
    }

    /// A normal density in the middle of the ranges, somewhat to one side: it contains all modes.
    fn first(&self, grid: &Fine) -> Vec<f64> {
        let scaled = |[low, high]: [f64; 2], x: f64, centre: f64| (x - low) / (high - low) - centre;
        let value = |[x, v]: [f64; 2]| {
            let (x, v) = (scaled(self.deflections, x, 0.55), scaled(self.velocities, v, 0.53));
            libm::exp(-40.0 * (x * x + v * v))
        };
        let p: Vec<f64> = grid.nodes().map(|(at, _)| value(at)).collect();
        let mass = grid.integral(&p, |_| 1.0);
        p.iter().map(|p| p / mass).collect()
    }

    /// Three runs: two steps on the fine grid, and one with polynomials of degree 6.
    fn solve(
        &self,
        model: &(dyn Model + Sync),
        schedule: Schedule,
    ) -> Result<(Vec<StateDensity>, StateDensity), DensityError> {
        let meter: Meter<'_> = self.budget.begin();
        let show = |done: usize, change: f64| {
            if let Some(progress) = &self.progress {
                progress(done, change);
            }
        };
        let problem = Problem {
            model,
            intensity: self.intensity,
            damping: self.mean_damping(model)?,
            iteration: Iteration { tolerance: self.tolerance, limit: 4000 },
            meter: &meter,
            progress: &show,
        };
        let (fine, low) = (self.grid::<9>(model), self.grid::<7>(model));
        let whole = problem.run(&fine, &schedule, 1, self.first(&fine))?;
        let start = low.values_of(&fine, &whole.instants[0]);
        let low_run = problem.run(&low, &schedule, 1, start)?;
        let halved = problem.run(&fine, &schedule.halved(), 2, whole.instants[0].clone())?;

        let relaxation = 1.0 / (1.0 - whole.arrived.ratio.min(1.0 - 1e-9));
        let (iteration, lost) = (relaxation * halved.arrived.change, relaxation * halved.lost.abs());
        let density = |of: &dyn Fn(&FixedPoint) -> &Vec<f64>| {
            let (whole, halved, low_run) = (of(&whole), of(&halved), of(&low_run));
            let values: Vec<f64> =
                halved.iter().zip(whole).map(|(half, whole)| half + (half - whole) / 3.0).collect();
            let outside = fine.outside(&values);
            if outside.is_nan() || outside > LARGEST_OUTSIDE {
                return Err(DensityError::Leaves { share: outside, limit: LARGEST_OUTSIDE });
            }
            let step = fine.distance(halved, whole) / 3.0;
            let grid = fine.distance(&fine.values_of(&low, low_run), whole);
            let errors = Errors { step, grid, range: outside + lost, iteration };
            Ok(StateDensity::new(fine.clone(), values, errors))
        };
        let instants =
            (0..whole.instants.len()).map(|i| density(&|run| &run.instants[i])).collect::<Result<_, _>>()?;
        Ok((instants, density(&|run| &run.mean)?))
    }
}

fn acceleration(model: &dyn Model, u: &[f64], x: f64, v: f64) -> f64 {
    let mut a = [0.0];
    model.accel(u, &[x], &[v], &mut a);
    a[0]
}
