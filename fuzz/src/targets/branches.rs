//! Branches of spur pairs over their constants, onto other branches, back from infinity, and boundaries.

use crate::case::{Case, Run, all_finite, holds};
use gear_dynamics::branches::{Beyond, Branch, BranchEnd, BranchPoint, Continuation, Family, Switch};
use gear_dynamics::trains::SpurPair;
use gear_dynamics::{Budget, Shooting, State};

/// The constants of a pair.
const NAMES: [&str; 4] = ["speed", "drive torque", "mesh damping", "mesh half backlash"];

/// Maximum number of points of a branch, which keeps cases short.
const POINTS: usize = 12;

fn continuation(case: &mut Case, [from, to]: [f64; 2]) -> Continuation {
    let mut settings = Continuation::new(from, to)
        .max_points(case.effort(POINTS))
        .shooting(Shooting::new().budget(Budget::new().steps(20_000)))
        .budget(Budget::new().steps(100_000));
    if case.chance(0.3) {
        settings = settings.bounds(case.number(0.3), case.number(2.0));
    }
    if case.chance(0.3) {
        settings = settings.max_motion(case.number(100.0));
    }
    if case.chance(0.3) {
        settings =
            settings.first_step(case.number(0.01)).max_step(case.number(0.1)).min_step(case.number(1e-9));
    }
    if case.chance(0.2) {
        let channel = if case.hostile() { "no such channel" } else { case.pick(&["q0", "deflection 0"]) };
        settings = settings.channels(&[channel]);
    }
    if case.chance(0.3) { settings.both_ways() } else { settings }
}

fn points(branch: &Branch) -> Run {
    for point in branch.points() {
        all_finite("parameter, peak to peak", &[point.parameter, point.peak_to_peak()])?;
        all_finite("q of a point", &point.orbit.states()[0].q)?;
    }
    holds(branch.end() != &BranchEnd::Open, || "a branch that has ended is open".into())?;
    branch.table()?;
    Ok(())
}

fn any_name(case: &mut Case) -> &'static str {
    if case.hostile() { "no such constant" } else { case.pick(&NAMES) }
}

/// A branch over a constant; from it the branches and boundaries that start there.
pub fn branch(case: &mut Case) -> Run {
    let numbers = [case.number(0.05), case.number(0.3)];
    let waves = [case.pairs(2, 0.2), case.pairs(2, 0.1)].map(|pairs| pairs.concat());
    case.note(|| format!("numbers {numbers:?}, waves {waves:?}"));
    let pair = SpurPair::of_numbers(numbers[0], numbers[1], &waves[0], &waves[1])?;
    let train = pair.parts()?.build("driver", case.number(0.8))?;
    let name = if case.chance(0.8) { NAMES[0] } else { any_name(case) };
    let family = Family::over(&train, [name])?;
    let range = [train.constant(name)?, case.number(1.0)];
    let settings = continuation(case, range);
    let start = State::new(0.0, &[case.number(1.0)], &[case.number(0.1)]);
    case.note(|| format!("{name}: {settings:?}, start {start:?}"));
    let branch = settings.run(&family, (!case.chance(0.7)).then_some(&start))?;
    points(&branch)?;
    if matches!(branch.end(), BranchEnd::Unbounded { .. }) {
        let beyond = case.accept(settings.run(&family, Beyond(&branch)));
        beyond.iter().try_for_each(points)?;
    }
    if case.hostile() {
        case.accept(settings.run(&family, Beyond(&branch)));
    }
    let located: Option<&BranchPoint> = branch.located().map(|(_, point)| point).next();
    let Some(point) = located.or(branch.points().first()) else { return Ok(()) };
    if case.chance(0.5) {
        let switched = case.accept(settings.run(&family, Switch::of_point(point)));
        switched.iter().try_for_each(points)?;
    }
    let plane = Family::over(&train, [name, any_name(case)])?;
    let [from, to] = [case.number(0.1), case.number(0.3)];
    let settings = continuation(case, [from, to]).max_points(case.effort(4));
    let line = case.accept(settings.run(&plane, point));
    let mut points = line.iter().flat_map(|line| line.points());
    points.try_for_each(|point| all_finite("parameters of a line", &point.parameters))
}
