//! Random loads: white noise, rare events, densities, moments, processes on drives.

use super::processes::process;
use super::shapes;
use crate::case::{Case, Run, Stop, all_finite, finite, holds};
use crate::{any, models, solvers};
use gear_dynamics::drives::Noisy;
use gear_dynamics::excitation::Side;
use gear_dynamics::models::Oscillator;
use gear_dynamics::random::{
    Estimate, Event, FirstPassage, LinearMoments, LongRun, NoisySteps, PathIntegration, Splitting, WhiteNoise,
};
use gear_dynamics::{Budget, Integrator, Machine, Model, NfgPair, Periodic, Shape, State};
use std::f64::consts::TAU;
use std::time::Duration;

/// An oscillator with any constants, with or without a dead zone.
fn oscillator(case: &mut Case) -> Result<Oscillator, Stop> {
    let mut constants = vec![("speed", case.number(1.0)), ("damping", case.number(0.3))];
    for (name, sensible) in [
        ("linear stiffness", 1.0),
        ("cubic stiffness", 0.3),
        ("mesh stiffness", 1.0),
        ("half backlash", 0.5),
        ("mean force", 0.3),
        ("force", 0.3),
    ] {
        if case.chance(0.6) {
            constants.push((name, case.number(sensible)));
        }
    }
    case.note(|| format!("{constants:?}"));
    Ok(Oscillator::new(&constants)?)
}

/// One or two sources of noise, on coordinates and slots that exist or not.
fn noise(case: &mut Case, model: &dyn Model) -> Result<Vec<WhiteNoise>, Stop> {
    let index = |case: &mut Case, length: usize| {
        if case.hostile() { case.count(length) } else { case.below(length.max(1)) }
    };
    let mut all = Vec::new();
    for _ in 0..1 + case.below(2) {
        let intensity = case.number(0.1);
        all.push(if case.chance(0.6) {
            WhiteNoise::bath(index(case, model.dof()), case.number(0.3), intensity)?
        } else {
            let slots: Vec<(usize, f64)> =
                (0..1 + case.below(2)).map(|_| (index(case, model.drives()), case.number(0.5))).collect();
            WhiteNoise::drives(&slots, intensity)?
        });
    }
    case.note(|| format!("{all:?}"));
    Ok(all)
}

/// Moments of any linearised model.
pub fn moments(case: &mut Case) -> Run {
    let (model, start) = any::any(case)?;
    let noise = noise(case, &model)?;
    let moments = LinearMoments::about(&model, &start, &noise)?;
    all_finite("mean q", &moments.mean().q)?;
    all_finite("mean v", &moments.mean().v)?;
    let covariance = moments.covariance();
    all_finite("covariance", covariance.as_slice())?;
    holds(*covariance == covariance.transpose(), || "the covariance is not symmetric".into())?;
    holds((0..covariance.nrows()).all(|i| covariance[(i, i)] >= -1e-6 * covariance.amax()), || {
        format!("a variance is negative: {:?}", covariance.diagonal())
    })
}

/// Runs in lanes: ends, estimates, first passages, splitting.
pub fn lanes(case: &mut Case) -> Run {
    if case.chance(0.7) {
        let model = oscillator(case)?;
        return in_lanes(case, &model);
    }
    let machine = shapes::machine(case)?;
    // The algebra of a shape with another size may index beyond it.
    if machine.shape().is_sound() { in_lanes(case, &machine) } else { Ok(()) }
}

fn in_lanes<G: Shape + Send + Sync>(case: &mut Case, machine: &Machine<G>) -> Run {
    let noise = noise(case, machine)?;
    let (steps, periods, members) = (case.count(20), case.number(2.0), case.count(8));
    let solver = NoisySteps::new(steps, &noise).lanes::<4>().seed(case.seed());
    let start = models::state(case, State::at_rest(machine.dof()));
    case.note(|| format!("{steps} steps, {periods:e} periods, {members} members, {start:?}"));
    // What is accepted and would run for long.
    let long = |periods: f64, members: usize| (periods * steps as f64).max(1.0) * members as f64 > 1e5;
    match case.below(4) {
        0 if !long(periods, members) => {
            for end in solver.ends(machine, &start, periods, members)? {
                all_finite("q", &end.q)?;
                all_finite("v", &end.v)?;
            }
            Ok(())
        }
        1 => {
            let (settle, spans) = (case.number(1.0), case.count(2));
            let run = LongRun::new(settle, periods)?.members(members).spans(spans).channels(&["q0", "v0"]);
            let start = case.chance(0.7).then_some(&start);
            if long(settle + periods + spans as f64 / steps as f64, members) {
                return Ok(());
            }
            let seen = run.run(&solver, machine, start)?;
            let mut estimates = vec![seen.mean("q0")?, seen.mean_square("q0")?, seen.mean_square("v0")?];
            for i in 0..machine.contacts() {
                let contact = seen.contact(i)?;
                estimates.push(contact.gap);
                estimates.extend(contact.flanks);
                estimates.extend(contact.impacts);
                let impacts = contact.impacts.iter().zip(contact.speed);
                estimates.extend(impacts.filter(|(rate, _)| rate.mean() > 0.0).map(|(_, speed)| speed));
            }
            estimates.iter().try_for_each(|estimate| sound(case, estimate))?;
            finite("largest", seen.largest("q0")?.mean())
        }
        2 => {
            let (run, level) = (FirstPassage::new(periods)?.members(members), case.number(0.5));
            if long(periods, members) {
                return Ok(());
            }
            let seen = run.run(&solver, machine, &start, &Event::new(level, |at| at.q[0]))?;
            holds(seen.reached() <= seen.members() && seen.members() == members as u64, || {
                format!("{} of {}", seen.reached(), seen.members())
            })?;
            if seen.reached() > 0 { finite("mean time", seen.times().mean()) } else { Ok(()) }
        }
        3 => {
            let (particles, repeats) = (case.count(10).saturating_add(19), case.count(2).saturating_add(7));
            let run = Splitting::new(periods)?.particles(particles).repeats(repeats).floor(-case.number(2.0));
            // Up to 255 stages, of which each may last until the end.
            if long(20.0 * periods, particles.saturating_mul(repeats)) {
                return Ok(());
            }
            let event = Event::new(case.number(0.5), |at| at.q[0].hypot(at.v[0]));
            let seen = run.run(&solver, machine, &start, &event)?;
            let p = seen.probability();
            holds((0.0..=1.0).contains(&p.mean()), || format!("probability {}", p.mean()))?;
            all_finite("shares", seen.shares())?;
            sound(case, &p)
        }
        _ => Ok(()),
    }
}

/// An estimate is finite, and its interval contains its mean.
fn sound(case: &mut Case, estimate: &Estimate) -> Run {
    all_finite("mean and error", &[estimate.mean(), estimate.standard_error()])?;
    let level = case.number(0.5);
    if let Some([low, high]) = case.accept(estimate.confidence(level)) {
        let mean = estimate.mean();
        holds(low <= mean && mean <= high, || format!("{low} .. {high} about {mean} at {level}"))?;
    }
    Ok(())
}

/// Densities of any model by path integration.
pub fn path(case: &mut Case) -> Run {
    let [low, high] = [-case.number(5.0), case.number(5.0)];
    let [slow, fast] = [-case.number(4.0), case.number(4.0)];
    let method = PathIntegration::new(case.number(0.3), [low, high], [slow, fast])?;
    let (panels, tolerance) = (case.count(1), case.number(1e-4));
    let budget = Budget::new().steps(200).time(Duration::from_secs(2));
    let mut method = method.panels(panels.saturating_add(1)).tolerance(tolerance).budget(budget);
    if case.chance(0.3) {
        method = method.time_step(case.number(0.3));
    }
    case.note(|| format!("{method:?}"));
    if panels > 3 {
        return Ok(());
    }
    let density = if case.chance(0.5) {
        let model = oscillator(case)?;
        if case.chance(0.5) { method.stationary(&model)? } else { method.run(&model)?.mean().clone() }
    } else {
        let (model, _) = any::any(case)?;
        if case.chance(0.5) { method.stationary(&model)? } else { method.run(&model)?.mean().clone() }
    };
    all_finite("density", density.values())?;
    let (x, v) = (case.number(1.0), case.number(1.0));
    let figures = [
        density.at(x, v),
        density.deflection_density(x),
        density.velocity_density(v),
        density.share(-x, x),
        density.upward_crossing_rate(x),
        density.mean(|_, v| v * v),
        density.total_error(),
    ];
    // An argument of NaN has no density.
    if x.is_nan() || v.is_nan() { Ok(()) } else { all_finite("figures", &figures) }
}

/// Processes with a correlation on the drives of a pair: drives, edges, a short run.
pub fn noisy(case: &mut Case) -> Run {
    let pair = NfgPair::new(&models::pair_params(case))?;
    let (start, period) = (pair.on_drive_flank()?, pair.period());
    let mut noisy = Noisy::new(pair);
    for _ in 0..1 + case.below(2) {
        let process = process(case, 0.1)?;
        let slots: Vec<(usize, f64)> =
            (0..1 + case.below(2)).map(|_| (case.count(3).wrapping_sub(1), case.number(0.1))).collect();
        case.note(|| format!("slots {slots:?}"));
        noisy = noisy.add(&slots, &*process)?;
    }
    let (drives, mut t) = (noisy.drives(), 0.0);
    for _ in 0..10 {
        let (mut one, mut each) = (vec![0.0; drives], vec![0.0; 2 * drives]);
        noisy.drive(0.0, Side::After, &mut each[..drives]);
        noisy.drive(0.0, Side::After, &mut each[drives..]);
        noisy.redrive(&[t, t], Side::After, &mut each);
        noisy.drive(t, Side::After, &mut one);
        all_finite(format_args!("drives at {t:e}"), &one)?;
        holds(each == [&one[..], &one].concat(), || format!("redrive differs at {t:e}"))?;
        let edge = noisy.next_edge(t);
        holds(edge.is_none_or(|edge| edge > t), || format!("next_edge({t:e}) is {edge:?}"))?;
        t = edge.unwrap_or(t + 1.0);
    }
    let solver = solvers::solver(case, period, 2 * noisy.dof());
    let end = solver.end(&noisy, &start, case.unit() * if period < TAU { period } else { TAU })?;
    all_finite("q", &end.q)?;
    all_finite("v", &end.v)
}
