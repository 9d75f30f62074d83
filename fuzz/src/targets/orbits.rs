//! Periodic orbits, Lyapunov exponents, variational equations, harmonic balance.

use crate::any;
use crate::case::{Case, Run, all_finite, finite, holds};
use crate::models::{self, Erased};
use crate::solvers::Solver;
use gear_dynamics::contact::Piece;
use gear_dynamics::periodic::{
    FourierOrbit, Integrals, MultiplierError, Multipliers, ShootingOrbit, Variation,
};
use gear_dynamics::{
    Balance, Budget, Harmonics, Lyapunov, Model, NfgPair, ParameterError, Periodic, Rattle, Rk4, Shooting,
    State,
};
use std::f64::consts::TAU;
use std::time::Duration;

/// The budget, which keeps cases short.
fn budget() -> Budget {
    Budget::new().steps(20_000)
}

/// A smaller budget for the derivatives of a flow: their steps take longer.
fn budget_of_derivatives() -> Budget {
    Budget::new().steps(4_000)
}

fn multipliers(all: &Multipliers) -> Run {
    all.values().iter().try_for_each(|value| all_finite("multiplier", &[value.re, value.im]))?;
    all_finite("largest multiplier", &[all.largest()])?;
    holds(!all.value_error().is_nan(), || "the error of the multipliers is NaN".into())?;
    holds(all.growth(1.0).iter().all(|growth| !growth.is_nan()), || format!("growth {:?}", all.growth(1.0)))?;
    let _ = all.stability().to_string();
    Ok(())
}

fn cycle(model: &Erased, cycle: &ShootingOrbit, phase: f64) -> Run {
    for state in cycle.states() {
        all_finite("q of a cycle", &state.q)?;
        all_finite("v of a cycle", &state.v)?;
    }
    all_finite("monodromy", cycle.monodromy().as_slice())?;
    all_finite(
        "period, accuracy, first correction",
        &[cycle.period(), cycle.accuracy(), cycle.first_correction()],
    )?;
    all_finite("corrections", cycle.corrections())?;
    all_finite("range", cycle.range())?;
    all_finite("mean acceleration", &cycle.mean_acceleration())?;
    multipliers(cycle.multipliers())?;
    if model.dof() > 0 {
        all_finite("q between nodes", &cycle.at(model, phase * cycle.period())?.q)?;
    }
    let mut rattle = Rattle::new(model);
    cycle.observe(model, &mut rattle)?;
    Ok(())
}

/// Shooting, and again from the orbit found.
pub fn shooting(case: &mut Case) -> Run {
    let (model, start) = any::any(case)?;
    let guess: Vec<State> = if case.hostile() {
        (0..case.below(4))
            .map(|i| State { t: start.t + case.number(0.2) * i as f64, ..models::state(case, start.clone()) })
            .collect()
    } else {
        vec![start]
    };
    let mut shooting = Shooting::new()
        .period_multiple(case.count(1))
        .max_iterations(case.effort(6))
        .budget(budget_of_derivatives());
    if case.chance(0.3) {
        shooting = shooting.segments(case.count(4));
    }
    if case.chance(0.5) {
        shooting = shooting.tolerance(case.number(1e-9)).flow_tolerance(case.number(1e-10));
    }
    case.note(|| format!("{shooting:?}, guess {guess:?}"));
    match shooting.solve(&model, &guess) {
        Ok(found) => {
            cycle(&model, &found, case.unit())?;
            let again = shooting.solve_from(&model, &found)?;
            cycle(&model, &again, case.unit())
        }
        Err(error) => {
            if let Some(last) = error.last() {
                last.states.iter().try_for_each(|state| all_finite("q of the last iterate", &state.q))?;
            }
            Err(error.into())
        }
    }
}

/// Variational equations over part of a period.
pub fn variation(case: &mut Case) -> Run {
    let (model, start) = any::any(case)?;
    let period = if model.period().is_finite() && model.period() > 0.0 { model.period() } else { 1.0 };
    let end = start.t + case.number(0.3) * period;
    let variation = Variation::new().flow_tolerance(case.number(1e-9)).budget(budget_of_derivatives());
    case.note(|| format!("{variation:?} to {end:e}"));
    let transition = variation.run(&model, &start, end)?;
    all_finite("q", &transition.state.q)?;
    all_finite("matrix", transition.matrix.as_slice())?;
    let error = case.number(1e-9);
    match case.accept(Multipliers::of_monodromy(&transition.matrix, error)) {
        Some(all) => multipliers(&all),
        None => Ok(()),
    }
}

/// Lyapunov exponents with any settings.
pub fn lyapunov(case: &mut Case) -> Run {
    let (model, start) = any::any(case)?;
    let mut lyapunov = Lyapunov::new()
        .settle(case.effort(2))
        .align(case.effort(1))
        .measure(case.effort(3))
        .renormalisations(case.count(8))
        .flow_tolerance(case.number(1e-6))
        .budget(budget_of_derivatives());
    if case.chance(0.5) {
        lyapunov = lyapunov.count(case.count(1));
    }
    if case.hostile() {
        lyapunov = lyapunov.align(case.count(1));
    }
    case.note(|| format!("{lyapunov:?}"));
    let exponents = if case.chance(0.8) {
        lyapunov.run(&model, &start)?
    } else {
        lyapunov.run_over(&model, &start, case.number(1.0) * model.period())?
    };
    all_finite("exponents", &exponents.values())?;
    all_finite("exponents per period", &exponents.per_period())?;
    holds(exponents.standard_error().iter().all(|bar| !bar.is_nan()), || {
        format!("standard errors {:?}", exponents.standard_error())
    })?;
    for i in 0..exponents.values().len() {
        all_finite("running means", &exponents.running(i))?;
    }
    all_finite("last q", &exponents.state().q)
}

fn harmonics(case: &mut Case) -> Result<Harmonics, ParameterError> {
    let harmonics = match case.below(6) {
        0 => Harmonics::bands(case.count(7), case.count(2), case.count(2))?,
        1 => {
            let orders: Vec<usize> =
                (0..case.below(8)).map(|i| if case.hostile() { case.count(5) } else { i }).collect();
            Harmonics::of_orders(&orders)?
        }
        _ => Harmonics::up_to(if case.hostile() { case.below(3) } else { 2 + case.below(30) }),
    };
    if case.chance(0.2) { harmonics.with_period_multiple(case.count(2)) } else { Ok(harmonics) }
}

/// Sets of orders with any counts, and series on them.
pub fn orders(case: &mut Case) -> Run {
    let kept = if case.chance(0.2) { Harmonics::up_to(case.count(10)) } else { harmonics(case)? };
    case.note(|| format!("{kept:?}"));
    let orders = kept.orders();
    holds(orders.is_sorted_by(|a, b| a < b), || format!("orders {:?} ...", &orders[..orders.len().min(20)]))?;
    holds(kept.highest() == orders.last().copied().unwrap_or(0) && kept.period_multiple() > 0, || {
        format!("highest {}", kept.highest())
    })?;
    holds(kept.unknowns() + usize::from(kept.has_mean()) == 2 * orders.len(), || {
        format!("{} unknowns", kept.unknowns())
    })?;
    if kept.unknowns() > 1 << 16 {
        return Ok(());
    }
    let (dof, span, size) = (case.below(3), case.number(1.0), case.number(1.0));
    let coefficients: Vec<Vec<f64>> = (0..dof).map(|_| case.list(kept.unknowns(), size)).collect();
    let orbit = FourierOrbit::new(&kept, span, &coefficients)?;
    all_finite("period, frequency", &[orbit.period(), orbit.frequency()])?;
    for state in orbit.states(case.effort(10))? {
        all_finite("q of an orbit", &state.q)?;
        all_finite("v of an orbit", &state.v)?;
    }
    for j in 0..orbit.dof() {
        let order = case.count(4);
        all_finite("peak-to-peak, mean", &[orbit.peak_to_peak(j), orbit.mean(j)])?;
        all_finite("amplitude, phase", &[orbit.amplitude(j, order), orbit.phase(j, order)])?;
    }
    let t = case.number(1.0);
    if t.abs() <= 1e50 {
        all_finite("q at any time", &orbit.at(t).q)?;
    }
    let other = orbit.on(&harmonics(case)?);
    holds(!orbit.distance(&other).is_nan(), || "distance is NaN".into())
}

/// Harmonic balance of any model.
pub fn balance(case: &mut Case) -> Run {
    let (model, start) = any::any(case)?;
    let samples = case.count(200);
    let all = [
        Integrals::Exact,
        Integrals::Sampled { samples },
        Integrals::Panels,
        Integrals::Kinks,
        Integrals::Closed,
    ];
    // Panels of waves with high orders or many knots can take a minute: the time limit must end them.
    let mut balance = Balance::new(harmonics(case)?).integrals(case.pick(&all));
    balance = balance.budget(budget().time(Duration::from_secs(1)));
    let tolerance = case.number(1e-9);
    balance = match case.chance(0.7) {
        true => balance.root_finder(super::roots::newton(case, tolerance)),
        false => balance.root_finder(super::roots::broyden(case, tolerance)),
    };
    case.note(|| format!("{balance:?}"));
    if balance.harmonics().highest() > 512 {
        return Ok(()); // so many orders would take minutes
    }
    let guess = match case.below(4) {
        0 => FourierOrbit::project(
            &Solver::Rk4(Rk4::new(0.01 * model.period()).max_steps(10_000)),
            &model,
            &start,
            balance.harmonics(),
        )?,
        1 => {
            let width = balance.harmonics().unknowns().min(1 << 12);
            let coefficients: Vec<Vec<f64>> = (0..model.dof()).map(|_| case.list(width, 1e-4)).collect();
            FourierOrbit::new(balance.harmonics(), model.period(), &coefficients)?
        }
        _ => balance.linearised(&model, case.pick(&[Piece::Lower, Piece::Upper, Piece::Gap]))?,
    };
    let orbit = balance.solve(&model, &guess)?;
    finite("residual", orbit.residual())?;
    all_finite("mean acceleration", orbit.mean_acceleration())?;
    orbit.notes().iter().for_each(|note| drop(note.to_string()));
    for j in 0..orbit.dof() {
        all_finite("coefficients", orbit.coefficients(j))?;
    }
    for history in orbit.contacts(&model)? {
        all_finite("times of a contact", &history.statistics.time)?;
    }
    holds(!orbit.distance(&guess).is_nan(), || "distance is NaN".into())?;
    match balance.multipliers(&model, &orbit) {
        Ok(all) => multipliers(&all)?,
        Err(error @ MultiplierError::Exhausted(_)) => return Err(error.into()),
        Err(_) => {}
    }
    if case.chance(0.2) {
        let estimate = balance.error_estimate(&model, &orbit)?;
        let parts = [estimate.truncation, estimate.aliasing, estimate.shooting];
        holds(parts.iter().all(|part| !part.is_nan()), || format!("proof {parts:?}"))?;
    }
    if case.chance(0.1) {
        balance.solve_to(&model, &guess, case.number(1e-3), case.effort(60))?;
    }
    Ok(())
}

/// Forces truncated to the kept orders, for the pair.
pub fn truncated(case: &mut Case) -> Run {
    let pair = NfgPair::new(&models::pair_params(case))?;
    let samples = case.count(400).min(1 << 16);
    let balance = Balance::new(harmonics(case)?).integrals(Integrals::Sampled { samples }).budget(budget());
    let balance = balance.truncated_forces();
    case.note(|| format!("{balance:?}"));
    if balance.harmonics().highest() > 512 {
        return Ok(()); // so many orders would take minutes
    }
    let guess = balance.linearised(&Erased::new(pair.clone(), pair.period()), Piece::Lower)?;
    let orbit = balance.solve(&pair, &guess)?;
    finite("residual", orbit.residual())?;
    let period = TAU / orbit.frequency();
    finite("period", period)
}
