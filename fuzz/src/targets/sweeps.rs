//! Points, sweeps with every engine, diagrams, attractors, ensembles, Sobol indices.

use crate::case::{Case, Run, Stop, all_finite, finite, holds};
use crate::models::{self, Erased, User};
use crate::solvers::{self, Solver};
use gear_dynamics::sweep::{
    Attractors, Axis, Bifurcation, Ensemble, InstructionSet, LaneRk4, Located, Point, Points,
    RandomParameters, Rows, TableRk4, WarmStart,
};
use gear_dynamics::{
    Budget, Lyapunov, Machine, Model, NfgPair, NfgParams, ParameterError, Shape, Shooting, State, Sweep,
};
use std::f64::consts::TAU;

fn axis(case: &mut Case, name: &str, from: f64, to: f64, count: usize) -> Result<Axis, ParameterError> {
    if case.chance(0.5) {
        Axis::linear(name, case.number(from), case.number(to), count)
    } else {
        let values = case.list(count.min(20), from);
        Axis::of_values(name, &values)
    }
}

/// Axes, grids and lists with any counts.
pub fn points(case: &mut Case) -> Run {
    let axes = (0..case.below(3)).map(|i| {
        let (count, same) = (case.count(5), case.chance(0.1));
        axis(case, if same { "same" } else { ["x", "y", "z"][i] }, 1.0, 20.0, count)
    });
    let points = Points::grid(axes.collect::<Result<_, _>>()?)?;
    case.note(|| format!("{} points", points.len()));
    for index in [0, points.len() / 2, points.len().saturating_sub(1)] {
        if index < points.len() {
            all_finite("point", points.point(index).values())?;
        }
    }
    let rows: Vec<Vec<f64>> = (0..case.below(4)).map(|_| case.list(2, 1.0)).collect();
    let list = Points::of_rows(&["x", "y"], &rows)?;
    holds(list.len() == rows.len() && !list.is_empty(), || format!("{} points of {}", list.len(), rows.len()))
}

/// Settings of a sweep with moderate work.
fn sweep(case: &mut Case, points: Points) -> Sweep {
    let mut sweep = Sweep::new(points).settle(case.effort(2)).measure(case.effort(2));
    if case.chance(0.3) {
        sweep = sweep.repeat_tolerance(case.number(1e-6));
    }
    if case.chance(0.3) {
        sweep = sweep.periodic_tolerance(case.number(1e-6));
    }
    if case.chance(0.7) {
        sweep = sweep.channels(if case.hostile() { &["q0", "q8"] } else { &["q0", "v0"] });
    }
    if case.chance(0.5) {
        sweep = sweep.rattle();
    }
    if case.chance(0.5) {
        sweep = sweep.strobe(case.count(2));
    }
    if case.chance(0.2) {
        sweep = sweep.lyapunov(
            Lyapunov::new()
                .measure(case.effort(2))
                .flow_tolerance(case.number(1e-6))
                .budget(Budget::new().steps(4_000)),
        );
    }
    if case.chance(0.2) {
        let budget = Budget::new().steps(4_000);
        let shooting = Shooting::new().flow_tolerance(case.number(1e-10)).max_iterations(case.effort(6));
        sweep = sweep.multipliers(shooting.segments(case.count(1)).budget(budget));
    }
    if case.chance(0.2) {
        sweep = sweep.check_every(case.count(2));
    }
    sweep.warm_start(case.pick(&[WarmStart::No, WarmStart::No, WarmStart::Up, WarmStart::Down]))
}

/// Checks that rows are finite and that they are equal after storing.
fn judge(case: &mut Case, rows: Rows) -> Run {
    for row in rows.iter() {
        holds(
            row.channel("q0").map_or(true, |s| s.mean.is_finite() && s.rms.is_finite() && s.max.is_finite()),
            || format!("row {}: {:?}", row.index(), row.channel("q0")),
        )?;
        holds(row.lyapunov().is_none_or(f64::is_finite), || {
            format!("row {}: exponent {:?}", row.index(), row.lyapunov())
        })?;
        holds(!row.change().is_nan() && !row.scatter().is_nan(), || {
            format!("row {}: {} {}", row.index(), row.change(), row.scatter())
        })?;
        row.strobes().try_for_each(|state| all_finite("strobed state", state))?;
        let _ = (
            row.grazes(),
            row.is_sensitive(),
            row.checked().is_some(),
            row.step_error("q0"),
            row.period_multiple(),
            row.settled_after(),
        );
    }
    let bytes =
        postcard::to_stdvec(&rows).map_err(|error| Stop::Broken(format!("rows are not stored: {error}")))?;
    let back: Rows =
        postcard::from_bytes(&bytes).map_err(|error| Stop::Broken(format!("rows are not read: {error}")))?;
    holds(back.fingerprint() == rows.fingerprint(), || "stored rows differ".into())?;
    if case.chance(0.5) {
        let mut broken = bytes;
        let at = case.below(broken.len());
        broken[at] ^= 1 << case.below(8);
        if case.chance(0.3) {
            broken.truncate(at);
        }
        // Changed values are other rows; everything else is an error.
        let read: Option<Rows> = postcard::from_bytes(&broken).ok();
        for row in read.iter().flat_map(Rows::iter) {
            let _ = (row.is_sensitive(), row.strobes().count());
        }
    }
    let found = Attractors::find(&rows, case.number(1e-3))?;
    holds(found.all().iter().all(|one| one.rows > 0), || "an attractor without rows".into())
}

/// Steps per period. 2²⁴ steps are accepted but take a minute; they are replaced by 2¹².
fn steps(case: &mut Case, sensible: usize) -> usize {
    match case.count(sensible) {
        0x100_0000 => 1 << 12,
        count => count,
    }
}

fn user(case: &mut Case) -> User {
    // An edge that moves faster would be checked a thousand times a step, for many steps.
    let user = User::any(case);
    User { stop: Some([10.0, 0.5]), shake: [user.shake[0], user.shake[1].clamp(-1e3, 1e3)], ..user }
}

fn erased(user: &User, force: f64) -> Result<Erased, ParameterError> {
    Ok(Erased::new(User { force, ..user.clone() }, TAU / user.omega))
}

/// A user's model with fixed steps and with any solver.
pub fn users(case: &mut Case) -> Run {
    let user = user(case);
    let count = 1 + case.below(4);
    let points = Points::from(axis(case, "force", 0.1, 1.0, count)?);
    let sweep = sweep(case, points);
    case.note(|| format!("{sweep:?}"));
    let family = |p: &Point<'_>| erased(&user, p["force"]);
    let start = |_: &Point<'_>, model: &Erased| Ok::<_, ParameterError>(State::at_rest(model.dof()));
    let rows = if case.chance(0.5) {
        let engine = TableRk4::new(if case.hostile() { steps(case, 100) } else { 20 + case.below(200) });
        sweep.of(&engine, family).start(start).run()?
    } else {
        let engine: Located<Solver> = Located(solvers::solver(case, TAU / user.omega, 2 * user.dof));
        sweep.of(&engine, family).start(start).run()?
    };
    judge(case, rows)
}

/// Any machine in lanes over one of its constants.
pub fn machines<G: Shape + Send + Sync>(case: &mut Case, machine: &Machine<G>, name: &str) -> Run {
    let count = 2 + case.below(4);
    let value = machine.constant(name).unwrap_or(1.0);
    let points = Points::from(axis(case, name, 0.5 * value, 2.0 * value, count)?);
    let sweep = Sweep::new(points)
        .settle(case.effort(2))
        .measure(case.effort(2))
        .channels(&["q0", "deflection"])
        .rattle()
        .strobe(2);
    let engine = LaneRk4::new(if case.hostile() { steps(case, 100) } else { 60 }).lanes::<4>();
    case.note(|| format!("{sweep:?}, {engine:?}"));
    let start = |_: &Point<'_>, _: &_| Ok::<_, ParameterError>(State::at_rest(machine.dof()));
    let rows = sweep.of(&engine, |p| machine.with(name, p[name])).start(start).run()?;
    holds(rows.alone() <= 1, || format!("{} of {count} runs alone", rows.alone()))?;
    judge(case, rows)
}

/// The face gear pair in lanes and in chunks.
pub fn lanes(case: &mut Case) -> Run {
    let params = models::pair_params(case);
    let count = 1 + case.below(6);
    let points = Points::from(axis(case, "load", 20.0, 60.0, count)?);
    let sweep = sweep(case, points);
    let steps = if case.hostile() { steps(case, 200) } else { 64 + case.below(400) };
    let set = case.pick(&InstructionSet::available());
    let engine = LaneRk4::new(steps).lanes::<4>().instructions(set);
    case.note(|| format!("{sweep:?}, {engine:?}"));
    let family = |p: &Point<'_>| NfgPair::new(&NfgParams { load_torque: p["load"], ..params.clone() });
    let start = |_: &Point<'_>, pair: &NfgPair| pair.on_drive_flank();
    let (chunk, chunks) =
        if case.hostile() { (case.count(1), case.count(2)) } else { (0, 1 + case.below(2)) };
    let rows = if chunks == 1 {
        sweep.of(&engine, family).start(start).run()?
    } else {
        let first = sweep.of(&engine, family).start(start).chunk(chunk, chunks)?;
        let second = sweep.of(&engine, family).start(start).chunk(1, chunks)?;
        Rows::merge(vec![first, second])?
    };
    judge(case, rows)
}

/// Bifurcation diagrams.
pub fn bifurcation(case: &mut Case) -> Run {
    let user = user(case);
    let count = 2 + case.below(4);
    let points = Points::from(axis(case, "force", 0.1, 1.0, count)?);
    let sweep = sweep(case, points);
    let name = if case.hostile() { "contact force 9" } else { "q0" };
    let diagram = if case.chance(0.5) { Bifurcation::strobed(name) } else { Bifurcation::extremes(name) };
    case.note(|| format!("{sweep:?} {diagram:?}"));
    let engine = TableRk4::new(100);
    let start = |_: &Point<'_>, model: &Erased| Ok::<_, ParameterError>(State::at_rest(model.dof()));
    let drawn = diagram.run(&sweep.of(&engine, |p| erased(&user, p["force"])).start(start))?;
    for point in drawn.up().iter().chain(drawn.down()) {
        finite("parameter", point.parameter)?;
        all_finite("drawn values", &point.values)?;
    }
    all_finite("hysteresis", &drawn.hysteresis(case.number(1e-3))?)?;
    all_finite("undecided", &drawn.undecided())
}

/// Ensembles of a random family.
pub fn ensembles(case: &mut Case) -> Run {
    let user = user(case);
    let (members, spans) =
        (if case.hostile() { case.count(5) as u64 } else { 1 + case.below(8) as u64 }, case.count(5));
    let end = case.number(5.0);
    let mut ensemble = Ensemble::new(members, end, spans)?;
    // More members are accepted and would run for long.
    if members > 64 {
        return Ok(());
    }
    ensemble = ensemble.channels(&["q0"]);
    if case.chance(0.5) {
        ensemble = ensemble.peaks(&["v0"]);
    }
    if case.chance(0.5) {
        ensemble = ensemble.rattle();
    }
    let uncertain = uncertain(case)?;
    let solver = solvers::solver(case, TAU / user.omega, 2 * user.dof);
    let family = |member: u64| {
        let model = erased(&user, uncertain.sample(member)[0])?;
        let start = State::at_rest(model.dof());
        Ok::<_, ParameterError>((model, start))
    };
    let bands = ensemble.run(&solver, family)?;
    all_finite("times", bands.times())?;
    for (i, mean) in bands.mean("q0")?.into_iter().enumerate() {
        holds(mean.is_finite() || bands.at("q0", i)?.count() == 0, || format!("mean at time {i} is {mean}"))?;
    }
    all_finite("band", &bands.band("q0", case.number(0.5))?)?;
    let i = case.count(3);
    if let Some(at) = case.accept(bands.at("q0", i)) {
        holds(i < bands.times().len(), || format!("time {i} of {}", bands.times().len()))?;
        holds(at.mean().is_finite() || at.count() == 0, || format!("mean at time {i} is {}", at.mean()))?;
    }
    if let Some(peak) = case.accept(bands.peak("v0")) {
        holds(peak.mean().is_finite() || peak.count() == 0, || format!("mean peak is {}", peak.mean()))?;
    }
    Ok(())
}

fn uncertain(case: &mut Case) -> Result<RandomParameters, Stop> {
    let (mean, deviation) = (case.number(0.5), case.number(0.1));
    let (low, high) = (case.number(1.0), case.number(3.0));
    let seed = case.seed();
    Ok(RandomParameters::new(seed)
        .with("a", rand_distr::Normal::new(mean, deviation)?)
        .with("b", rand_distr::Uniform::new(low, high)?))
}

/// Samples of uncertain parameters, and Sobol indices of a result.
pub fn sobol(case: &mut Case) -> Run {
    let uncertain = uncertain(case)?;
    let count = case.count(20);
    case.note(|| format!("{uncertain:?}, {count} points"));
    if let Some(points) = case.accept(uncertain.points(count)) {
        holds(points.len() == count, || format!("{} points of {count}", points.len()))?;
        all_finite("sample", points.point(count / 2).values())?;
    }
    let samples = case.count(16);
    let design = uncertain.sobol(samples)?;
    let length = design.points().len();
    let mut measure: Vec<f64> = (0..length).map(|i| design.points().point(i).values().iter().sum()).collect();
    if case.hostile() && !measure.is_empty() {
        let at = case.below(measure.len());
        measure[at] = case.number(1.0);
    }
    if case.hostile() {
        measure.pop();
    }
    for index in design.indices(&measure)? {
        all_finite(format_args!("index of {}", index.name), &[index.first, index.total])?;
        holds(index.first_error >= 0.0 && index.total_error >= 0.0, || {
            format!("standard errors of {index:?}")
        })?;
    }
    Ok(())
}
