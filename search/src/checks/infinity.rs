//! Branches that run to infinity end at the border of parametric instability, and come back from there.

use crate::checks::branches::{Case, settled};
use crate::draw::Draw;
use crate::models::pair::Pair;
use crate::{Check, Outcome, agree};
use gear_dynamics::branches::{
    Beyond, Branch, BranchEnd, BranchError, BranchPoint, Continuation, Family, PointKind,
};
use gear_dynamics::nalgebra::DMatrix;
use gear_dynamics::{Dop853, Integrator, Model, Periodic, Shooting, State};

/// The checks of this file.
pub const CHECKS: [Check; 2] =
    [Check { name: "infinity-of-pairs", run: infinity }, Check { name: "infinity-of-lines", run: lines }];

/// The linear system that a model tends to at large motions, from its accelerations at two such motions.
struct Large<'m>(&'m dyn Periodic);

/// A large motion.
const LARGE: f64 = 1e9;

impl Model for Large<'_> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let scaled = |x: &[f64], by: f64| x.iter().map(|x| by * x).collect::<Vec<f64>>();
        let mut opposite = vec![0.0; a.len()];
        self.0.accel(u, &scaled(q, LARGE), &scaled(v, LARGE), a);
        self.0.accel(u, &scaled(q, -LARGE), &scaled(v, -LARGE), &mut opposite);
        a.iter_mut().zip(&opposite).for_each(|(a, b)| *a = (*a - b) / (2.0 * LARGE));
    }
    fn base(&self) -> Option<&dyn Model> {
        Some(self.0)
    }
    fn contacts(&self) -> usize {
        0
    }
}

/// det(Mᵐ - 1) over m periods, in units of the frequency of the period.
fn determinant(family: &Family<'_>, p: f64, multiple: usize) -> Option<f64> {
    let model = family.at([p]).ok()?;
    let (n, period) = (model.dof(), model.period());
    let unit = |i: usize| if i < n { 1.0 } else { std::f64::consts::TAU / period };
    let mut matrix = DMatrix::zeros(2 * n, 2 * n);
    let method = Dop853::new().rtol(1e-13).atol(1e-15);
    for j in 0..2 * n {
        let mut y = vec![0.0; 2 * n];
        y[j] = unit(j);
        let start = State::new(0.0, &y[..n], &y[n..]);
        let end = method.end(&Large(&*model), &start, period).ok()?;
        for (i, x) in end.q.iter().chain(&end.v).enumerate() {
            matrix[(i, j)] = x / unit(i);
        }
    }
    let power = (0..multiple).fold(DMatrix::identity(2 * n, 2 * n), |power, _| power * &matrix);
    Some((power - DMatrix::identity(2 * n, 2 * n)).determinant())
}

/// The root of the determinant near a border, by secants.
fn independent(family: &Family<'_>, border: f64, multiple: usize) -> Option<f64> {
    let (mut a, mut b) = (border * (1.0 + 1e-5), border * (1.0 - 1e-5));
    let mut at_a = determinant(family, a, multiple)?;
    for _ in 0..20 {
        let at_b = determinant(family, b, multiple)?;
        if at_b == at_a || (a - b).abs() < 1e-13 * border.abs() {
            break;
        }
        let next = b - at_b * (b - a) / (at_b - at_a);
        (a, at_a, b) = (b, at_b, next);
    }
    Some(b)
}

/// Whether the determinant has the same sign on both sides of a border.
fn outside_the_tongue(family: &Family<'_>, border: f64, multiple: usize) -> Option<bool> {
    let at = |by: f64| determinant(family, border * (1.0 + by), multiple);
    Some(at(-1e-4)? * at(1e-4)? > 0.0 && at(-1e-6)? * at(1e-6)? > 0.0)
}

/// Whether the determinant changes its sign within the accuracy of a border: secants may find another one, 1e-5
/// beside it.
fn changes_sign(family: &Family<'_>, border: f64, multiple: usize) -> Option<bool> {
    let at = |by: f64| determinant(family, border * (1.0 + by), multiple);
    Some(at(-CLOSE_AT_TIP)? * at(CLOSE_AT_TIP)? < 0.0)
}

/// The place near a border where the determinant is least, if it touches 0 there.
fn tip(family: &Family<'_>, border: f64, multiple: usize) -> Option<f64> {
    let h = 3e-5 * border;
    let [before, at, after] = [border - h, border, border + h].map(|p| determinant(family, p, multiple));
    let (bend, slope) = (before? + after? - 2.0 * at?, 0.5 * (after? - before?));
    let least = at? - 0.5 * slope * slope / bend;
    (bend * at? > 0.0 && least.abs() < 1e-6).then_some(border - h * slope / bend)
}

/// Accuracy of the border, as a share of the parameter.
const CLOSE: f64 = 1e-8;

/// The same on a line of folds, which runs to the tip of a tongue of instability: there the root is double.
const CLOSE_AT_TIP: f64 = 1e-7;

/// Most points of a branch between motions of 20 times the reference and its end.
const FEW: usize = 40;

/// Speeds of the branches: the pairs are parametrically unstable near 1.
const SPEEDS: [f64; 2] = [0.6, 1.4];

fn infinity(draw: &mut Draw) -> Outcome {
    let pair = Pair::draw_unstable(draw);
    draw.note(|| format!("{pair:?}"));
    let case = match pair.at(SPEEDS[0]) {
        Ok(train) => Case { text: format!("{pair:?}"), train, speeds: SPEEDS },
        Err(error) => return Outcome::Fails(error.to_string()),
    };
    let Some(start) = settled(&case) else { return Outcome::Skipped("does not settle") };
    match run(draw, &case, &start) {
        Ok(outcome) => outcome,
        Err(error) => Outcome::Fails(format!("{error}; {}", case.text)),
    }
}

fn run(draw: &mut Draw, case: &Case, start: &(State, usize)) -> Result<Outcome, String> {
    let family = Family::over(&case.train, ["speed"]).map_err(|error| error.to_string())?;
    let [from, to] = case.speeds;
    let continuation = Continuation::new(from, to).shooting(Shooting::new().period_multiple(start.1));
    let branch = continuation.run(&family, &start.0);
    let branch = branch.map_err(|error| error.to_string())?;
    draw.note(|| format!("{branch}"));
    let BranchEnd::Unbounded { border, motion } = *branch.end() else {
        return Ok(if matches!(branch.end(), BranchEnd::StepUnderflow { .. }) {
            Outcome::Fails(format!("{}; {}", branch.end(), case.text))
        } else {
            Outcome::Skipped("no infinity")
        });
    };
    let Some(border) = border else { return Err(format!("motion {motion}, but no border")) };
    let large = |branch: &Branch| {
        let last = branch.points().last().map_or(f64::NAN, |point| point.peak_to_peak());
        branch.points().iter().filter(|point| point.peak_to_peak() > 20.0 / motion * last).count()
    };
    if large(&branch) > FEW {
        return Err(format!("{} points of large motions", large(&branch)));
    }
    let expected = independent(&family, border, start.1).ok_or("no determinant")?;
    if (border - expected).abs() > CLOSE * border.abs() {
        return Err(format!("the border {border:?} is {expected:?}"));
    }
    let wider = Continuation::new(from, to).bounds(0.5 * from, 1.5 * to).max_points(60);
    let wider = wider.shooting(Shooting::new().period_multiple(start.1));
    let back = match wider.begin(&family, Beyond(&branch)) {
        Ok(following) => following.finish(),
        Err(error) => return Err(format!("back from {border}: {error}")),
    };
    draw.note(|| format!("{back}"));
    let sizes: Vec<f64> = back.points().iter().map(|point| point.peak_to_peak()).collect();
    let least = sizes.iter().fold(f64::INFINITY, |least, size| size.min(least));
    Ok(agree(least < 0.7 * sizes[0], || {
        format!("the branch from {border} does not come back: {sizes:?}; {}", case.text)
    }))
}

/// Lines of folds of pairs over the damping.
fn lines(draw: &mut Draw) -> Outcome {
    let pair = Pair::draw_damped(draw);
    draw.note(|| format!("{pair:?}"));
    run_lines(draw, &pair).unwrap_or_else(|error| Outcome::Fails(format!("{error}; {pair:?}")))
}

fn run_lines(draw: &mut Draw, pair: &Pair) -> Result<Outcome, String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let train = pair.at(SPEEDS[0]).map_err(|error| text(&error))?;
    let case = Case { text: String::new(), train, speeds: SPEEDS };
    let Some((state, multiple)) = settled(&case) else { return Ok(Outcome::Skipped("does not settle")) };
    let family = Family::over(&case.train, ["speed"]).map_err(|error| text(&error))?;
    let shooting = Shooting::new().period_multiple(multiple);
    let branch = Continuation::new(SPEEDS[0], SPEEDS[1]).shooting(shooting.clone()).run(&family, &[state]);
    let branch = branch.map_err(|error| text(&error))?;
    let plane = Family::over(&case.train, ["speed", "mesh damping"]).map_err(|error| text(&error))?;
    let damping = 2.0 * pair.zeta;
    let mut ends = 0;
    let mut folds: Vec<&BranchPoint> = branch.of_kind(PointKind::Fold);
    folds.sort_by(|a, b| (a.parameter - 1.0).abs().total_cmp(&(b.parameter - 1.0).abs()));
    for point in folds.into_iter().take(2) {
        let line = Continuation::new(damping, 0.2 * damping).max_points(300).shooting(shooting.clone());
        let line = match line.run(&plane, point) {
            Ok(line) => line,
            // A fold too steep beside a grazing.
            Err(BranchError::Curve(_)) => continue,
            Err(error) => return Err(text(&error)),
        };
        draw.note(|| format!("{line}"));
        let BranchEnd::Unbounded { border, motion } = *line.end() else { continue };
        let last = line.points().last().ok_or("no point")?;
        let border = border.ok_or_else(|| format!("motion {motion}, but no border"))?;
        let damped = Pair { zeta: 0.5 * last.parameters[1], ..pair.clone() };
        let at = |speed: f64| match damped.at(speed) {
            Ok(train) => Ok(train),
            Err(_) => case.train.with("speed", f64::NAN),
        };
        let family = Family::of([("speed", "1")], |[p]| at(p));
        let expected = if changes_sign(&family, border, multiple).ok_or("no determinant")? {
            border
        } else if outside_the_tongue(&family, border, multiple).ok_or("no determinant")? {
            tip(&family, border, multiple).ok_or("no tip")?
        } else {
            independent(&family, border, multiple).ok_or("no determinant")?
        };
        if (border - expected).abs() > CLOSE_AT_TIP * border.abs() {
            return Err(format!("the border {border:?} is {expected:?}"));
        }
        ends += 1;
    }
    Ok(if ends > 0 { Outcome::Agrees } else { Outcome::Skipped("no infinity") })
}
