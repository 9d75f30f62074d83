//! Branches over the speed: every change of stability is a located point or a note, and short steps find no more.

use crate::draw::Draw;
use crate::models::pair::Pair;
use crate::models::symmetric::Symmetric;
use crate::models::two_stage::TwoStage;
use crate::{Check, Outcome};
use gear_dynamics::branches::{Branch, BranchEnd, BranchPoint, Continuation, Family, PointKind};
use gear_dynamics::num_complex::Complex64;
use gear_dynamics::trains::{Coordinates, Train};
use gear_dynamics::{Dop853, Model, Settle, Shooting, State};

/// The checks of this file.
pub const CHECKS: [Check; 6] = [
    Check { name: "stability-of-pairs", run: |draw| stability(draw, pair) },
    Check { name: "stability-of-sets", run: |draw| stability(draw, set) },
    Check { name: "stability-of-stages", run: |draw| stability(draw, stages) },
    Check { name: "short-steps-of-pairs", run: |draw| short_steps(draw, pair) },
    Check { name: "short-steps-of-sets", run: |draw| short_steps(draw, set) },
    Check { name: "short-steps-of-stages", run: |draw| short_steps(draw, stages) },
];

/// A train, its description and the range of its speed.
pub struct Case {
    /// The description.
    pub text: String,
    /// The train.
    pub train: Train,
    /// The range.
    pub speeds: [f64; 2],
}

/// Draws a train.
pub type Drawn = fn(&mut Draw) -> Result<Case, String>;

/// A dimensionless spur pair.
pub fn pair(draw: &mut Draw) -> Result<Case, String> {
    let pair = Pair::draw(draw);
    let train = pair.at(0.5).map_err(|error| error.to_string())?;
    Ok(Case { text: format!("{pair:?}"), train, speeds: [0.5, 2.4] })
}

/// A planetary set.
pub fn set(draw: &mut Draw) -> Result<Case, String> {
    let set = Symmetric::planetary(draw);
    let train = set.train(Coordinates::Relative)?;
    let speed = train.constant("speed").map_err(|error| error.to_string())?;
    Ok(Case { text: format!("{set:?}"), train, speeds: [speed, 2.0 * speed] })
}

/// A train of two stages.
pub fn stages(draw: &mut Draw) -> Result<Case, String> {
    let (model, speed) = (TwoStage::draw(draw), draw.scale(100.0, 600.0));
    let train = model.at(speed)?;
    Ok(Case { text: format!("{model:?} {speed}"), train, speeds: [speed, 2.0 * speed] })
}

/// The branch from a settled orbit.
fn follow(case: &Case, start: &(State, usize), continuation: Continuation) -> Result<Branch, String> {
    let family = Family::over(&case.train, ["speed"]).map_err(|error| error.to_string())?;
    let continuation = continuation.shooting(Shooting::new().period_multiple(start.1));
    continuation.run(&family, &start.0).map_err(|error| error.to_string())
}

/// A settled orbit at the first speed, and its period multiple.
pub fn settled(case: &Case) -> Option<(State, usize)> {
    let settle = Settle::new().tolerance(1e-8).max_periods(600);
    let rest = State::at_rest(case.train.dof());
    let steady = settle.run(&Dop853::new().rtol(1e-10).atol(1e-16), &case.train, &rest).ok()?;
    Some((steady.state, steady.period_multiple))
}

/// Numbers of multipliers: outside the unit circle, real above 1, real below -1.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Outside {
    all: usize,
    above: usize,
    below: usize,
}

/// What a point passes on to its neighbours: its critical multipliers count as inside or as outside. Those of a pair
/// pass together; of several at 1 or -1 some may leave the circle and others enter it.
fn outside(point: &BranchPoint) -> Vec<Outside> {
    let values = point.multipliers.values();
    let near = |to: &dyn Fn(&Complex64) -> f64, count: usize| {
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&i, &j| to(&values[i]).total_cmp(&to(&values[j])));
        // Those of equal members pass at the same place.
        let together = order.iter().filter(|&&i| to(&values[i]) < 1e-6).count();
        order.truncate(count.max(together));
        order
    };
    let (critical, at_once) = match point.kind() {
        Some(PointKind::PeriodDoubling) => (near(&|m| (m + 1.0).norm(), 1), 1),
        Some(PointKind::NeimarkSacker) => {
            (near(&|m| if m.im == 0.0 { f64::INFINITY } else { (m.norm() - 1.0).abs() }, 2), 2)
        }
        Some(PointKind::Grazing) | None => (Vec::new(), 1),
        Some(_) => (near(&|m| (m - 1.0).norm(), 1), 1),
    };
    let mut found = Outside { all: 0, above: 0, below: 0 };
    let add = |found: &mut Outside, m: &Complex64| {
        found.all += 1;
        found.above += usize::from(m.im == 0.0 && m.re > 0.0);
        found.below += usize::from(m.im == 0.0 && m.re < 0.0);
    };
    let others = values.iter().enumerate().filter(|(i, m)| !critical.contains(i) && m.norm() > 1.0);
    others.for_each(|(_, m)| add(&mut found, m));
    let mut all = vec![found];
    for pass in critical.chunks(at_once) {
        pass.iter().for_each(|&i| add(&mut found, &values[i]));
        all.push(found);
    }
    all
}

/// Whether the orbits of two neighbouring points may have the same stability: two real multipliers outside may have
/// become a complex pair.
fn same(a: Outside, b: Outside) -> bool {
    a.all == b.all && a.above % 2 == b.above % 2 && a.below % 2 == b.below % 2
}

/// The changes of stability between neighbouring points that nothing explains.
fn unexplained(branch: &Branch) -> Vec<String> {
    let points = branch.points();
    let mut found = Vec::new();
    for two in points.windows(2) {
        let [a, b] = [outside(&two[0]), outside(&two[1])];
        let explained = a.iter().any(|a| b.iter().any(|b| same(*a, *b)));
        let [from, to] = [two[0].parameter, two[1].parameter];
        let noted = branch.notes().iter().any(|note| {
            let [low, high] =
                [note.parameters[0].min(note.parameters[1]), note.parameters[0].max(note.parameters[1])];
            from.min(to) >= low && from.max(to) <= high
        });
        // Next to the circle the number is not decided.
        let near = two.iter().any(|point| {
            let is_regular = matches!(point.kind(), None | Some(PointKind::Grazing));
            is_regular && point.multipliers.values().iter().any(|m| (m.norm() - 1.0).abs() < 1e-7)
        });
        if !explained && !noted && !near {
            found.push(format!("{from:?} {} .. {to:?} {}", told(&two[0]), told(&two[1])));
        }
    }
    found
}

fn told(point: &BranchPoint) -> String {
    let kind = point.kind().map_or(String::new(), |kind| kind.to_string());
    let values: Vec<String> =
        point.multipliers.values().iter().filter(|m| m.norm() > 0.9).map(|m| format!("{m:.5}")).collect();
    format!("{kind}[{}]", values.join(", "))
}

fn stability(draw: &mut Draw, drawn: Drawn) -> Outcome {
    let case = match drawn(draw) {
        Ok(case) => case,
        Err(error) => return Outcome::Fails(error),
    };
    draw.note(|| case.text.clone());
    let Some(start) = settled(&case) else { return Outcome::Skipped("does not settle") };
    let [from, to] = case.speeds;
    let branch = match follow(&case, &start, Continuation::new(from, to)) {
        Ok(branch) => branch,
        Err(error) => return Outcome::Fails(format!("{error}; {}", case.text)),
    };
    draw.note(|| format!("{branch}"));
    let found = unexplained(&branch);
    if found.is_empty() {
        ended(&branch, &case)
    } else {
        Outcome::Fails(format!("{}; {}", found.join("; "), case.text))
    }
}

/// The end of a branch.
fn ended(branch: &Branch, case: &Case) -> Outcome {
    match branch.end() {
        BranchEnd::StepUnderflow { .. } => Outcome::Fails(format!("{}; {}", branch.end(), case.text)),
        _ => Outcome::Agrees,
    }
}

/// Largest distance of a point found by either branch, over the parameter.
const NEAR: f64 = 1e-7;

fn short_steps(draw: &mut Draw, drawn: Drawn) -> Outcome {
    let case = match drawn(draw) {
        Ok(case) => case,
        Err(error) => return Outcome::Fails(error),
    };
    draw.note(|| case.text.clone());
    let Some(start) = settled(&case) else { return Outcome::Skipped("does not settle") };
    let [from, to] = case.speeds;
    let short = Continuation::new(from, to).first_step(0.001).max_step(0.005).max_points(20_000);
    let branches = [follow(&case, &start, Continuation::new(from, to)), follow(&case, &start, short)];
    let [coarse, fine] = match branches {
        [Ok(coarse), Ok(fine)] => [coarse, fine],
        [Err(error), _] | [_, Err(error)] => return Outcome::Fails(format!("{error}; {}", case.text)),
    };
    draw.note(|| format!("{coarse}\n{fine}"));
    let (mut missing, mut unresolved) = (Vec::new(), false);
    for [a, b] in [[&coarse, &fine], [&fine, &coarse]] {
        for (kind, point) in a.located() {
            let found = b.located().any(|(other, at)| {
                other.kind() == kind.kind() && (at.parameter / point.parameter - 1.0).abs() < NEAR
            });
            let noted = b.notes().iter().any(|note| {
                let [low, high] =
                    [note.parameters[0].min(note.parameters[1]), note.parameters[0].max(note.parameters[1])];
                (low..=high).contains(&point.parameter)
            });
            // A pair this close together brackets nothing that the other branch could be asked for.
            let pair = a.located().filter(|(other, at)| {
                other.kind() == kind.kind() && (at.parameter / point.parameter - 1.0).abs() < NEAR
            });
            if !found && !noted && pair.count() % 2 == 0 {
                unresolved = true;
            } else if !found && !noted {
                let by = if std::ptr::eq(a, &coarse) { "long" } else { "short" };
                missing.push(format!(
                    "{} at {:?} by {by} steps only {}",
                    kind.kind(),
                    point.parameter,
                    told(point)
                ));
            }
        }
    }
    if missing.is_empty() && unresolved {
        Outcome::Skipped("a pair of points is closer than the check resolves")
    } else if missing.is_empty() {
        ended(&fine, &case)
    } else {
        Outcome::Fails(format!("{}; {}", missing.join("; "), case.text))
    }
}
