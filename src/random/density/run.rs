//! The fixed point on one grid with one step.

use crate::error::check;
use crate::model::Model;
use crate::ode::budget::Meter;
use crate::random::density::density_error::DensityError;
use crate::random::density::fixed_point::{Arrived, Iteration};
use crate::random::density::grid::Grid;
use crate::random::density::steps::arrivals::Arrivals;
use crate::random::density::steps::kick::Kick;
use crate::random::density::steps::schedule::Schedule;

/// What all runs of a call share.
pub(crate) struct Problem<'p> {
    pub(crate) model: &'p (dyn Model + Sync),
    pub(crate) intensity: f64,
    /// Mean damping, which the random part of the step contains.
    pub(crate) damping: f64,
    pub(crate) iteration: Iteration,
    pub(crate) meter: &'p Meter<'p>,
    pub(crate) progress: &'p dyn Fn(usize, f64),
}

/// A fixed point: the density at the start of the repetition and after each step, and its mean over the
/// repetition.
pub(crate) struct FixedPoint {
    pub(crate) instants: Vec<Vec<f64>>,
    pub(crate) mean: Vec<f64>,
    pub(crate) arrived: Arrived,
    /// The share of the mass that one repetition loses; negative if it gains.
    pub(crate) lost: f64,
}

/// One repetition on a grid: K½ A K A ... A K½ with the kicks K and the arrivals A, the splitting of Strang
/// 1968 of second order in the step.
struct Repetition<'g, const N: usize> {
    grid: &'g Grid<N>,
    arrivals: Vec<Arrivals>,
    /// The kick before each step and after the last one; see `halves`.
    kicks: Vec<usize>,
    /// The kick of half of each step.
    halves: Vec<usize>,
    distinct: Vec<Kick>,
}

impl<'g, const N: usize> Repetition<'g, N> {
    fn new(problem: &Problem<'_>, grid: &'g Grid<N>, schedule: &Schedule) -> Result<Self, DensityError> {
        let kinds = if schedule.constant { 1 } else { schedule.steps.len() };
        check::count("nodes of the grid times steps of a period", &[grid.len(), kinds, 3], check::NUMBERS)?;
        let mut arrivals = Vec::with_capacity(kinds);
        for (end, step) in schedule.ends().into_iter().zip(&schedule.steps).take(kinds) {
            problem.meter.spend_slowly()?;
            arrivals.push(Arrivals::new(grid, problem.model, problem.damping, end, *step)?);
        }
        let (mut durations, mut distinct): (Vec<f64>, Vec<Kick>) = (Vec::new(), Vec::new());
        let mut kick = |duration: f64| {
            let known = durations.iter().position(|d| (d - duration).abs() < 1e-12 * duration);
            known.unwrap_or_else(|| {
                durations.push(duration);
                distinct.push(Kick::new(&grid.v, problem.damping, problem.intensity, duration));
                distinct.len() - 1
            })
        };
        let steps = &schedule.steps;
        let length = |i: usize| steps.get(i).copied().unwrap_or(0.0);
        let kicks = (0..=steps.len())
            .map(|i| kick(0.5 * (length(i) + if i > 0 { length(i - 1) } else { 0.0 })))
            .collect();
        let halves = steps.iter().map(|h| kick(0.5 * h)).collect();
        Ok(Repetition { grid, arrivals, kicks, halves, distinct })
    }

    /// The density after one repetition. `observe` receives the number of each step, from 0, and the density
    /// after it without the last half of its kick.
    fn repeat(
        &self,
        p: &[f64],
        meter: &Meter<'_>,
        mut observe: impl FnMut(usize, &[f64]),
    ) -> Result<Vec<f64>, DensityError> {
        let (mut p, mut next) = (p.to_vec(), vec![0.0; p.len()]);
        for step in 0..self.halves.len() {
            meter.spend_slowly()?;
            self.distinct[self.kicks[step]].apply(&p, &mut next);
            self.arrivals[step % self.arrivals.len()].apply(self.grid, &next, &mut p);
            observe(step, &p);
        }
        self.distinct[self.kicks[self.halves.len()]].apply(&p, &mut next);
        Ok(next)
    }
}

impl Problem<'_> {
    /// The fixed point of the repetition, from a first density. The density is stored after every `every`-th
    /// step.
    pub(crate) fn run<const N: usize>(
        &self,
        grid: &Grid<N>,
        schedule: &Schedule,
        every: usize,
        mut p: Vec<f64>,
    ) -> Result<FixedPoint, DensityError> {
        let steps = Repetition::new(self, grid, schedule)?;
        let mut kept = 1.0;
        let map = |from: &[f64]| {
            let mut to = steps.repeat(from, self.meter, |_, _| ())?;
            kept = grid.integral(&to, |_| 1.0);
            if kept.is_nan() || kept < 1e-6 {
                return Err(DensityError::Leaves { share: 1.0, limit: LARGEST_OUTSIDE });
            }
            to.iter_mut().for_each(|p| *p /= kept);
            Ok(to)
        };
        let size = |change: &[f64]| grid.size(change);
        let arrived = self.iteration.run(&mut p, map, size, |done, change| (self.progress)(done, change))?;
        if !arrived.converged {
            return Err(DensityError::NotConverged {
                repetitions: arrived.repetitions,
                change: arrived.change,
                tolerance: self.iteration.tolerance,
            });
        }
        let mut point =
            FixedPoint { instants: vec![p.clone()], mean: vec![0.0; p.len()], arrived, lost: 1.0 - kept };
        if schedule.constant {
            point.mean.clone_from(&p);
            return Ok(point);
        }
        let duration = schedule.duration();
        let mut add = |p: &[f64], share: f64| point.mean.iter_mut().zip(p).for_each(|(m, p)| *m += share * p);
        add(&p, 0.5 * schedule.steps[0] / duration);
        let mut whole = vec![0.0; p.len()];
        let last = schedule.steps.len() - 1;
        steps.repeat(&p, self.meter, |step, after| {
            steps.distinct[steps.halves[step]].apply(after, &mut whole);
            let next = schedule.steps.get(step + 1).copied().unwrap_or(0.0);
            add(&whole, 0.5 * (schedule.steps[step] + next) / duration);
            if (step + 1) % every == 0 && step < last {
                point.instants.push(whole.clone());
            }
        })?;
        Ok(point)
    }
}

/// Largest share of the probability outside of the ranges.
pub(crate) const LARGEST_OUTSIDE: f64 = 0.01;
