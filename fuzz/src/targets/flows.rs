//! Runs in time: every solver and setting, every observer.

use super::{build, laws};
use crate::case::{Case, Run, Stop, all_finite, finite, holds};
use crate::models::{self, Erased};
use crate::{any, solvers};
use gear_dynamics::analysis::{Direction, Impacts, Section, Summary, Waterfall};
use gear_dynamics::check::{check_model, check_periodic};
use gear_dynamics::drives::VaryingSpeed;
use gear_dynamics::ode::{Probe, Step, Trajectory, uniform_times};
use gear_dynamics::{Budget, Integrator, Model, Periodic, Rattle, Settle, Statistics};
use std::ops::ControlFlow;

fn span(case: &mut Case, period: f64) -> f64 {
    case.number(2.0) * if period.is_finite() && period > 0.0 { period } else { 1.0 }
}

/// Ends of runs, samples, whole trajectories and their channels.
pub fn runs(case: &mut Case) -> Run {
    let (model, start) = any::any(case)?;
    let solver = solvers::solver(case, model.period(), 2 * model.dof());
    let end = start.t + span(case, model.period());
    case.note(|| format!("end {end:e}"));
    let trajectory = match case.below(3) {
        0 => {
            let state = solver.end(&model, &start, end)?;
            holds(state.t == end, || format!("ends at {:e} instead of {end:e}", state.t))?;
            all_finite("q", &state.q)?;
            return all_finite("v", &state.v);
        }
        1 => {
            let times = uniform_times(start.t, end, case.effort(20))?;
            solver.sample(&model, &start, &times)
        }
        _ => solver.trajectory(&model, &start, end),
    };
    let (trajectory, failed) = match trajectory {
        Ok(trajectory) => (trajectory, None),
        Err(failed) => ((*failed.trajectory).clone(), Some(failed.error)),
    };
    for i in 0..trajectory.len() {
        finite("time", trajectory.times()[i])?;
        all_finite("q of a trajectory", trajectory.q(i))?;
        all_finite("v of a trajectory", trajectory.v(i))?;
    }
    holds(trajectory.times().is_sorted(), || "times are not sorted".into())?;
    if trajectory.len() < 2000 && model.sound {
        channels(case, &model, &trajectory)?;
    }
    failed.map_or(Ok(()), |error| Err(error.into()))
}

fn channels(case: &mut Case, model: &Erased, trajectory: &Trajectory) -> Run {
    let names: Vec<String> =
        Probe::new(model).channels().iter().map(|channel| channel.name.clone()).collect();
    for name in names.iter().take(6) {
        let values = trajectory.channel(model, name)?;
        all_finite(format_args!("channel {name}"), &values)?;
        if !values.is_empty() {
            let summary = Summary::of_samples(&values)?;
            finite("standard deviation", summary.deviation)?;
        }
    }
    case.accept(trajectory.channel(model, "no such channel"));
    Ok(())
}

/// Statistics, rattle, impacts and sections watch one run.
pub fn observers(case: &mut Case) -> Run {
    let (model, start) = any::any(case)?;
    let solver = solvers::solver(case, model.period(), 2 * model.dof());
    let end = start.t + span(case, model.period());
    let names: Vec<String> =
        Probe::new(&model).channels().iter().map(|channel| channel.name.clone()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut statistics = Statistics::new(&model, &names)?;
    let (mut rattle, mut impacts) = (Rattle::new(&model), Impacts::new(&model));
    let name = if names.is_empty() { "q0" } else { case.pick(&names) };
    let level = case.number(1e-4) * case.signed();
    let mut section = Section::new(
        &model,
        name,
        level,
        case.pick(&[Direction::Rising, Direction::Falling, Direction::Both]),
    )?;
    if !rattle.contacts().is_empty() {
        impacts = impacts.effective_mass(0, case.number(1.0))?;
    }
    let (mut figures, mut lists) = ((&mut statistics, &mut rattle), (&mut impacts, &mut section));
    let outcome = solver.run(&model, &start, end, &mut (&mut figures, &mut lists));
    let lasted = outcome.as_ref().map_or(0.0, |finish| finish.state.t - start.t);
    for state in section.states() {
        finite("time of a section", state.t)?;
        all_finite("q of a section", &state.q)?;
        all_finite("v of a section", &state.v)?;
    }
    for (i, contact) in rattle.contacts().iter().enumerate() {
        listed(case, &impacts, i, contact.impact_count())?;
        all_finite("times on pieces", &contact.time)?;
        let sum: f64 = contact.time.iter().sum();
        holds(
            outcome.is_err()
                || (sum - lasted).abs()
                    <= 1e-9 * lasted.abs().max(end.abs()).max(f64::MIN_POSITIVE / f64::EPSILON),
            || format!("{contact:?} of {lasted:e}"),
        )?;
        if sum > 0.0 {
            finite("loss fraction", contact.loss_fraction())?;
        }
    }
    let finish = outcome?;
    all_finite("end", &finish.state.q)?;
    for name in names {
        if let Some(summary) = case.accept(statistics.summary(name)) {
            all_finite(
                format_args!("summary of {name}"),
                &[summary.mean, summary.rms, summary.min, summary.max, summary.deviation],
            )?;
        }
    }
    Ok(())
}

/// The impacts of one contact, of which the rattle counted `count`.
fn listed(case: &mut Case, impacts: &Impacts<'_>, contact: usize, count: u64) -> Run {
    let summary = impacts.summaries()[contact];
    // Rebounds at one instant are one impact of the list.
    holds(summary.count <= count, || format!("{summary:?}: {count} counted"))?;
    for impact in impacts.of(contact) {
        let known = [impact.flight, impact.left, impact.separation, impact.impulse].map(|x| x.unwrap_or(0.0));
        all_finite("impact", &[impact.t, impact.speed])?;
        all_finite("parts of an impact", &known)?;
        holds(impact.flight.unwrap_or(0.0) >= 0.0 && impact.duration().unwrap_or(0.0) >= 0.0, || {
            format!("{impact:?}")
        })?;
    }
    all_finite("summary of impacts", &[summary.rms_speed, summary.max_speed, summary.rate()])?;
    let (force, period) = (case.number(100.0), case.number(1.0));
    case.accept(summary.rattle_index(force, period)).map_or(Ok(()), |index| finite("rattle index", index))
}

/// Strobing and settling.
pub fn settling(case: &mut Case) -> Run {
    let (model, start) = any::any(case)?;
    let solver = solvers::solver(case, model.period(), 2 * model.dof());
    if case.chance(0.5) {
        let times: Vec<f64> = (1..=case.effort(5)).map(|k| start.t + k as f64 * model.period()).collect();
        let points = solver.sample(&model, &start, &times)?;
        for i in 0..points.len() {
            all_finite("strobed q", points.q(i))?;
        }
        return Ok(());
    }
    let settle = Settle::new()
        .tolerance(case.number(1e-6))
        .max_periods(case.effort(20))
        .max_period_multiple(case.count(4));
    let settle = settle.budget(Budget::new().steps(20_000));
    case.note(|| format!("{settle:?}"));
    match settle.run(&solver, &model, &start) {
        Ok(steady) => {
            all_finite("steady q", &steady.state.q)?;
            finite("change", steady.change)
        }
        Err(error) => {
            // A start that is not finite is returned as it was.
            holds(
                start.q.iter().any(|q| !q.is_finite())
                    || error.last().is_none_or(|last| last.q.iter().all(|q| q.is_finite())),
                || format!("{:?}", error.last()),
            )?;
            Err(error.into())
        }
    }
}

/// Held processes, runs with a speed law, and a waterfall.
pub fn varying(case: &mut Case) -> Run {
    let (held, start) = build::held_pair(case)?;
    let period = held.bare().period();
    let held = Erased::new(held, period);
    let solver = solvers::solver(case, period, 2);
    let state = solver.end(&held, &start, span(case, 0.3 * period))?;
    all_finite("q under random drives", &state.q)?;

    let pair = models::own_pair(case)?;
    let (speed, turn, start) = (pair.speed(), pair.period(), pair.on_drive_flank()?);
    let law = laws::speed_law(case, speed, turn)?;
    case.note(|| format!("{law:?}"));
    let varying = VaryingSpeed::new(pair, law);
    let end = span(case, 0.5 * turn);
    let waterfall = Waterfall::new(case.count(1), case.count(16))?.budget(Budget::new().steps(20_000));
    let name = case.pick(&["q0", "deflection", "mesh force", "no such channel"]);
    for line in waterfall.run(&solver, &varying, &start, end, name)? {
        all_finite("time and speed of a line", &[line.t, line.speed])?;
        all_finite("orders", &line.orders)?;
        all_finite("amplitudes", &line.amplitudes)?;
        finite("order 1", line.order(case.number(1.0)))?;
    }
    Ok(())
}

/// The checks of models: they never panic.
pub fn checks(case: &mut Case) -> Run {
    let (model, start) = any::any(case)?;
    let findings =
        if case.chance(0.5) { check_model(&model, &start) } else { check_periodic(&model, &start) };
    case.note(|| format!("{findings:?}"));
    Ok(())
}

/// A run that the observer stops.
pub fn stopped(case: &mut Case) -> Result<(), Stop> {
    let (model, start) = any::any(case)?;
    let solver = solvers::solver(case, model.period(), 2 * model.dof());
    let mut left = case.effort(30);
    let end = start.t + span(case, model.period());
    let mut watch = |step: &mut Step<'_>| {
        left = left.saturating_sub(1);
        let mut y = vec![0.0; step.y1().len()];
        step.at(0.5 * (step.t0() + step.t1()), &mut y);
        // Between the steps of a diverging motion the interpolation may not be finite.
        let moderate = step.y1().iter().all(|y| y.abs() < 1e30);
        if left == 0 || (moderate && y.iter().any(|y| !y.is_finite())) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let finish = solver.run(&model, &start, end, &mut watch)?;
    holds(finish.stopped || finish.state.t == end, || format!("{finish:?}"))?;
    all_finite("q where it stopped", &finish.state.q)?;
    holds(!finish.stopped || left == 0, || "dense output is no number".into())
}
