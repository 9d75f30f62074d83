//! Orbits of pairs and trains against a second method, differences or a conserved quantity.

use crate::checks::branches::{Case, Drawn, pair, set, settled, stages};
use crate::draw::Draw;
use crate::models::pair::Pair;
use crate::{Check, Outcome, agree};
use gear_dynamics::analysis::Summary;
use gear_dynamics::branches::{
    Branch, BranchEnd, BranchError, Continuation, Family, Figure, PointKind, Sensitivity,
};
use gear_dynamics::contact::Piece;
use gear_dynamics::excitation::Side;
use gear_dynamics::nalgebra::DMatrix;
use gear_dynamics::ode::Probe;
use gear_dynamics::periodic::{FlowMethod, Integrals, ShootingOrbit};
use gear_dynamics::trains::{Body, Coordinates, MeshPart, Parts, Train};
use gear_dynamics::{
    Balance, Dop853, Harmonics, Integrator, Model, Periodic, Shooting, State, Statistics, Taylor, Wave,
};

/// The checks of this file.
pub const CHECKS: [Check; 9] = [
    Check { name: "integrators-of-pairs", run: |draw| integrators(draw, pair) },
    Check { name: "integrators-of-stages", run: |draw| integrators(draw, stages) },
    Check { name: "closing-of-pairs", run: |draw| closing(draw, pair) },
    Check { name: "closing-of-sets", run: |draw| closing(draw, set) },
    Check { name: "derivatives-of-pairs", run: |draw| derivatives(draw, pair) },
    Check { name: "derivatives-of-stages", run: |draw| derivatives(draw, stages) },
    Check { name: "balance-of-pairs", run: balance },
    Check { name: "conserved", run: conserved },
    Check { name: "cuts-of-lines", run: cuts },
];

fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// A drawn case, or why there is none.
fn drawn(draw: &mut Draw, of: Drawn) -> Result<Case, Outcome> {
    let case = of(draw).map_err(Outcome::Fails)?;
    draw.note(|| case.text.clone());
    Ok(case)
}

/// The outcome of a check that may fail early.
fn outcome(result: Result<Outcome, String>, text: &str) -> Outcome {
    result.unwrap_or_else(|error| Outcome::Fails(format!("{error}; {text}")))
}

fn shot(train: &Train, guess: &State, multiple: usize) -> Result<ShootingOrbit, String> {
    Shooting::new().period_multiple(multiple).solve(train, guess).map_err(told)
}

/// Largest distance of two states, as a share of ranges of motion.
fn distance(a: &State, b: &State, range: &[f64]) -> f64 {
    let both = a.q.iter().chain(&a.v).zip(b.q.iter().chain(&b.v)).zip(range);
    let share =
        |((a, b), range): ((&f64, &f64), &f64)| if *range > 0.0 { (a - b).abs() / range } else { 0.0 };
    both.map(share).fold(0.0, f64::max)
}

/// `Taylor` and `Dop853` over 20 periods from a settled state; a stable orbit damps their errors.
fn integrators(draw: &mut Draw, of: Drawn) -> Outcome {
    let case = match drawn(draw, of) {
        Ok(case) => case,
        Err(outcome) => return outcome,
    };
    let Some((start, multiple)) = settled(&case) else { return Outcome::Skipped("does not settle") };
    let compare = || {
        let orbit = shot(&case.train, &start, multiple)?;
        if orbit.multipliers().largest() > 0.99 {
            return Ok(Outcome::Skipped("hardly stable"));
        }
        let end = start.t + 20.0 * case.train.period();
        let by_taylor = Taylor::new().rtol(1e-11).atol(1e-16).end(&case.train, &start, end).map_err(told)?;
        let by_dop853 = Dop853::new().rtol(1e-11).atol(1e-16).end(&case.train, &start, end).map_err(told)?;
        let apart = distance(&by_taylor, &by_dop853, orbit.range());
        Ok(agree(apart < 1e-7, || format!("the integrators differ by {apart:.1e}; {}", case.text)))
    };
    outcome(compare(), &case.text)
}

/// An orbit of one flow closes under the integrator of the other one.
fn closing(draw: &mut Draw, of: Drawn) -> Outcome {
    let case = match drawn(draw, of) {
        Ok(case) => case,
        Err(outcome) => return outcome,
    };
    let Some((start, multiple)) = settled(&case) else { return Outcome::Skipped("does not settle") };
    let compare = || {
        let shooting = Shooting::new().period_multiple(multiple).flow_method(FlowMethod::Taylor);
        let orbit = shooting.solve(&case.train, &start).map_err(told)?;
        let (first, period) = (&orbit.states()[0], orbit.period());
        let method = Dop853::new().rtol(1e-12).atol(1e-18);
        let end = method.end(&case.train, first, first.t + period).map_err(told)?;
        let apart = distance(&end, first, orbit.range());
        // A coordinate that hardly moves beside its rounding errors has a stated accuracy of its own.
        let within = 2.0 * orbit.accuracy();
        Ok(agree(apart < within.max(1e-7), || format!("the orbit is open by {apart:.1e}; {}", case.text)))
    };
    outcome(compare(), &case.text)
}

/// Statistics of the deflection along an orbit, and its crossings.
fn figures(train: &Train, orbit: &ShootingOrbit) -> Result<([f64; 3], u64), String> {
    let mut statistics =
        Statistics::new(train, &["deflection 0"]).or_else(|_| Statistics::new(train, &["deflection"]));
    let statistics = statistics.as_mut().map_err(|error| told(&*error))?;
    orbit.observe(train, statistics).map_err(told)?;
    let name = if statistics.summary("deflection 0").is_ok() { "deflection 0" } else { "deflection" };
    let s: Summary = statistics.summary(name).map_err(told)?;
    Ok(([s.mean, s.rms, s.peak_to_peak()], orbit.crossing_count()))
}

/// Steps of the differences, as shares of the constant.
const STEPS: [f64; 2] = [2e-4, 1e-4];

/// Derivatives of mean, RMS and peak-to-peak deflection against differences of fourth order.
fn derivatives(draw: &mut Draw, of: Drawn) -> Outcome {
    let case = match drawn(draw, of) {
        Ok(case) => case,
        Err(outcome) => return outcome,
    };
    let Some((start, multiple)) = settled(&case) else { return Outcome::Skipped("does not settle") };
    let constants = case.train.values().len();
    let place = draw.below(constants);
    outcome(compare_derivatives(draw, &case, &start, multiple, place), &case.text)
}

fn compare_derivatives(
    draw: &mut Draw,
    case: &Case,
    start: &State,
    multiple: usize,
    place: usize,
) -> Result<Outcome, String> {
    let train = &case.train;
    let orbit = shot(train, start, multiple)?;
    let value = train.values()[place];
    if value == 0.0 {
        return Ok(Outcome::Skipped("the constant is 0"));
    }
    let named = train.offers().constants.ok_or("no constants")?;
    let name = named.names()[place].name.clone();
    draw.note(|| format!("{name} = {value}"));
    let channel = if train.contacts() > 1 { "deflection 0" } else { "deflection" };
    let exact = Sensitivity::of(train, &orbit, &[channel]).map_err(told)?;
    let slopes = [Figure::Mean, Figure::Rms, Figure::PeakToPeak].map(|figure| exact.slopes(figure, channel));
    let at = |h: f64| -> Result<([f64; 3], u64), String> {
        let moved = train.with(&name, value * (1.0 + h)).map_err(told)?;
        let orbit = Shooting::new().period_multiple(multiple).solve(&moved, orbit.states()).map_err(told)?;
        figures(&moved, &orbit)
    };
    let (middle, crossings) = figures(train, &orbit)?;
    let (mut by_step, mut one_sided) = ([[0.0; 3]; 2], [[0.0; 2]; 2]);
    for ((difference, sides), h) in by_step.iter_mut().zip(&mut one_sided).zip(STEPS) {
        let mut values = [[0.0; 3]; 4];
        for (value, times) in values.iter_mut().zip([-2.0, -1.0, 1.0, 2.0]) {
            let Ok((found, count)) = at(times * h) else { return Ok(Outcome::Skipped("no orbit beside it")) };
            if count != crossings {
                return Ok(Outcome::Skipped("the contact sequence changes"));
            }
            *value = found;
        }
        let [a, b, c, d] = values;
        for k in 0..3 {
            difference[k] = (a[k] - 8.0 * b[k] + 8.0 * c[k] - d[k]) / (12.0 * h * value);
        }
        let m = middle[2];
        *sides =
            [a[2] - 4.0 * b[2] + 3.0 * m, -3.0 * m + 4.0 * c[2] - d[2]].map(|sum| sum / (2.0 * h * value));
    }
    for (k, what) in ["mean", "rms", "peak-to-peak"].into_iter().enumerate() {
        let slope = slopes[k].as_ref().map_err(told)?[place];
        let [coarse, fine] = [by_step[0][k], by_step[1][k]];
        // What the differences leave open: their change with the step, and rounding.
        let open = (coarse - fine).abs() + 1e-8 * middle[k].abs() / (STEPS[1] * value.abs());
        draw.note(|| format!("{what} {slope:e}, differences {coarse:e} {fine:e}"));
        // The largest of several maxima may be another one beside the constant: the slope is that of one side.
        let of_a_side = (0..2).any(|side| {
            let [coarse, fine] = [one_sided[0][side], one_sided[1][side]];
            (slope - fine).abs() <= 3.0 * (coarse - fine).abs() + 1e-7 * slope.abs()
        });
        if (slope - fine).abs() > 3.0 * open + 1e-7 * slope.abs() && !(k == 2 && of_a_side) {
            return Err(format!("d {what}/d {name} is {slope:e}, by differences {coarse:e} and {fine:e}"));
        }
    }
    Ok(Outcome::Agrees)
}

/// Number of places along an orbit at which a series is compared.
const PLACES: usize = 64;

/// The balance of pairs against shooting: the error decreases at least with the square of the number of orders.
fn balance(draw: &mut Draw) -> Outcome {
    let pair = Pair::draw(draw);
    let speed = draw.within(0.5, 2.4);
    draw.note(|| format!("{pair:?} {speed}"));
    let compare = || {
        let train = pair.at(speed).map_err(told)?;
        // The largest distance from the orbit by shooting, or why there is none.
        let off = |orders: usize| -> Result<Result<f64, &'static str>, String> {
            let method = Balance::new(Harmonics::up_to(orders)).integrals(Integrals::Exact);
            let start = method.linearised(&train, Piece::Upper).map_err(told)?;
            let Ok(found) = method.solve(&train, &start) else {
                return Ok(Err("the balance does not converge from its linearised start"));
            };
            let Ok(orbit) = shot(&train, &found.at(0.0), 1) else {
                return Ok(Err("shooting does not converge from the series"));
            };
            let mut worst: f64 = 0.0;
            for k in 0..PLACES {
                let t = orbit.states()[0].t + orbit.period() * k as f64 / PLACES as f64;
                let exact = orbit.at(&train, t).map_err(told)?;
                worst = worst.max(distance(&found.at(t), &exact, orbit.range()));
            }
            Ok(Ok(worst))
        };
        let [few, many] = match [off(16)?, off(48)?] {
            [Ok(few), Ok(many)] => [few, many],
            [Err(why), _] | [_, Err(why)] => return Ok(Outcome::Skipped(why)),
        };
        draw.note(|| format!("distances {few:?} {many:?}"));
        if few > 0.1 {
            return Ok(Outcome::Skipped("shooting finds another orbit"));
        }
        if many < 0.5 * few || many < 1e-8 {
            return Ok(Outcome::Agrees);
        }
        // A loss of contact that lasts a hundredth of the period is resolved by more orders only.
        let most = match off(192)? {
            Ok(most) => most,
            Err(why) => return Ok(Outcome::Skipped(why)),
        };
        Ok(agree(most < 0.125 * many, || {
            format!("16 orders are off by {few:.1e}, 48 by {many:.1e}, 192 by {most:.1e}; {pair:?} {speed}")
        }))
    };
    outcome(compare(), &format!("{pair:?} {speed}"))
}

/// Energy and angular momentum of two gears without damping and with a constant stiffness.
fn conserved(draw: &mut Draw) -> Outcome {
    let inertias = [draw.scale(3e-4, 3e-3), draw.scale(3e-4, 3e-3)];
    let (z, stiffness) = ([20 + draw.below(20) as u32, 30 + draw.below(20) as u32], draw.scale(1e8, 4e8));
    let radii = z.map(|z| 1e-3 * f64::from(z));
    let half_backlash = draw.scale(1e-6, 4e-5);
    let torque = draw.scale(5.0, 200.0);
    let rates = [draw.within(-1.0, 1.0), draw.within(-1.0, 1.0)];
    let text = format!("{inertias:?} {z:?} {stiffness} {half_backlash} {torque} {rates:?}");
    draw.note(|| text.clone());
    let compare = || -> Result<Outcome, String> {
        let mut parts = Parts::new();
        parts.body("pinion", Body::new(inertias[0])).body("wheel", Body::new(inertias[1]));
        let wave = Wave::constant(stiffness).map_err(told)?;
        let mesh = MeshPart::external(z, radii, wave).half_backlash(half_backlash);
        parts.mesh("mesh", "pinion", "wheel", mesh);
        let load = -torque * radii[1] / radii[0];
        parts.torque("drive", "pinion", torque).torque("load", "wheel", load);
        let train = parts.coordinates(Coordinates::Inertial).build("pinion", 100.0).map_err(told)?;
        // The velocity of the mesh is of the order of an oscillation through the whole gap.
        let frequency =
            (stiffness * (radii[0].powi(2) / inertias[0] + radii[1].powi(2) / inertias[1])).sqrt();
        let v: Vec<f64> = rates
            .iter()
            .zip(radii)
            .map(|(rate, radius)| 3.0 * rate * half_backlash * frequency / radius)
            .collect();
        let start = State::new(0.0, &[0.0, 0.0], &v);
        let mut probe = Probe::new(&train);
        let mut read = |state: &State| probe.read_contacts(state.t, Side::After, &state.q, &state.v)[0];
        let along = [[1.0, 0.0], [0.0, 1.0]].map(|v| read(&State::new(0.0, &[0.0, 0.0], &v)).rate);
        let mut quantities = |state: &State| {
            let c = read(state);
            let past = (c.deflection - c.upper).max(0.0) + (c.lower - c.deflection).max(0.0);
            let kinetic = 0.5 * (inertias[0] * state.v[0].powi(2) + inertias[1] * state.v[1].powi(2));
            let energy = kinetic + 0.5 * stiffness * past * past - torque * state.q[0] - load * state.q[1];
            let momentum = along[1] * inertias[0] * state.v[0] - along[0] * inertias[1] * state.v[1];
            let pushed = (along[1] * torque - along[0] * load) * state.t;
            [energy, momentum - pushed, kinetic]
        };
        let before = quantities(&start);
        let end = 200.0 * std::f64::consts::TAU / frequency;
        for (name, state) in [
            ("Taylor", Taylor::new().rtol(1e-12).atol(1e-18).end(&train, &start, end)),
            ("Dop853", Dop853::new().rtol(1e-12).atol(1e-18).end(&train, &start, end)),
        ] {
            let after = quantities(&state.map_err(told)?);
            let size = before[2].max(after[2]).max((torque * half_backlash / radii[0]).abs());
            let energy = (after[0] - before[0]).abs() / size;
            let turned = (inertias[0] + inertias[1]) * after[2].max(before[2]);
            let momentum = (after[1] - before[1]).abs() / (along[0].hypot(along[1]) * turned.sqrt());
            draw.note(|| format!("{name}: energy {energy:.1e}, momentum {momentum:.1e}"));
            if energy > 1e-8 || momentum > 1e-8 {
                return Err(format!("{name}: energy changes by {energy:.1e}, momentum by {momentum:.1e}"));
            }
        }
        Ok(Outcome::Agrees)
    };
    outcome(compare(), &text)
}

/// A line over the damping, cut at one of its points: the branch at that damping has the point of the line.
fn cuts(draw: &mut Draw) -> Outcome {
    let pair = Pair::draw(draw);
    draw.note(|| format!("{pair:?}"));
    let result = cut(draw, &pair);
    outcome(result, &format!("{pair:?}"))
}

fn branch_of(pair: &Pair) -> Result<Option<(Branch, usize)>, String> {
    let case = Case { text: String::new(), train: pair.at(0.5).map_err(told)?, speeds: [0.5, 2.4] };
    let Some((state, multiple)) = settled(&case) else { return Ok(None) };
    let family = Family::over(&case.train, ["speed"]).map_err(told)?;
    let continuation = Continuation::new(0.5, 2.4).shooting(Shooting::new().period_multiple(multiple));
    Ok(Some((continuation.run(&family, &[state]).map_err(told)?, multiple)))
}

/// The first state of an orbit and states beside it along the direction in which the orbit is determined least:
/// at a fold, the orbits beside it lie there.
fn guesses_beside(orbit: &ShootingOrbit) -> Result<Vec<State>, String> {
    let (first, range, mut open) = (&orbit.states()[0], orbit.range(), orbit.monodromy().clone());
    let n = range.len();
    open -= DMatrix::identity(n, n);
    let scaled = DMatrix::from_fn(n, n, |i, j| open[(i, j)] * range[j] / range[i]);
    let svd = scaled.svd(false, true);
    let least = svd.v_t.ok_or("no singular vectors")?.row(svd.singular_values.imin()).transpose();
    let shares = [0.0, 1e-3, -1e-3, 3e-3, -3e-3, 1e-2, -1e-2];
    let moved = |share: f64| {
        let mut y = [&first.q[..], &first.v].concat();
        y.iter_mut().enumerate().for_each(|(i, y)| *y += share * least[i] * range[i]);
        let (q, v) = y.split_at(first.q.len());
        State::new(first.t, q, v)
    };
    Ok(shares.map(moved).to_vec())
}

fn cut(draw: &mut Draw, pair: &Pair) -> Result<Outcome, String> {
    let Some((branch, multiple)) = branch_of(pair)? else { return Ok(Outcome::Skipped("does not settle")) };
    let followed: Vec<_> = branch
        .located()
        .filter(|(kind, _)| kind.kind() != PointKind::Branch)
        .map(|(_, point)| point)
        .collect();
    if followed.is_empty() {
        return Ok(Outcome::Skipped("no located point"));
    }
    let point = followed[draw.below(followed.len())];
    let train = pair.at(0.5).map_err(told)?;
    let plane = Family::over(&train, ["speed", "mesh damping"]).map_err(told)?;
    let damping = 2.0 * pair.zeta;
    let line = Continuation::new(damping, 1.05 * damping).shooting(Shooting::new().period_multiple(multiple));
    let line = match line.run(&plane, point) {
        Ok(line) => line,
        Err(BranchError::Curve(_)) => {
            return Ok(Outcome::Skipped("too steep beside a grazing"));
        }
        Err(error) => return Err(told(error)),
    };
    draw.note(|| format!("{line}"));
    if line.end() != &BranchEnd::Bound {
        return Ok(Outcome::Skipped("the line ends: beside its end two grazings lie close together"));
    }
    if !line.notes().is_empty() {
        return Ok(Outcome::Skipped("the contact sequence changes"));
    }
    // At an extremum of the line the cut touches it: the test function does not change its sign there.
    let points: Vec<_> = line.points().iter().filter(|point| point.turn.is_none()).collect();
    let at = points[draw.below(points.len())];
    let [p, c] = at.parameters;
    if !(0.5..=2.4).contains(&p) {
        return Ok(Outcome::Skipped("the line leaves the speeds"));
    }
    let Some((cut, of)) = branch_of(&Pair { zeta: 0.5 * c, ..pair.clone() })? else {
        return Ok(Outcome::Skipped("does not settle at the cut"));
    };
    draw.note(|| format!("{cut}"));
    let first = |branch: &Branch| branch.points().first().map_or(f64::NAN, |point| point.peak_to_peak());
    let moved = (first(&cut) / first(&branch) - 1.0).abs() > 0.1;
    if of != multiple || moved {
        return Ok(Outcome::Skipped("settles on another orbit at the cut"));
    }
    let what = line.what().kind();
    let distance = |branch: &Branch| {
        let like = branch.located().filter(|(kind, _)| kind.kind() == what).map(|(_, point)| point.parameter);
        like.map(|found| (found - p).abs()).fold(f64::INFINITY, f64::min)
    };
    let mut nearest = distance(&cut);
    if nearest > 1e-7 * p {
        // The point may have left the branch from 0.5 by an isola: it lies on the branch through orbits beside it.
        let train = Pair { zeta: 0.5 * c, ..pair.clone() }.at(p).map_err(told)?;
        let family = Family::over(&train, ["speed"]).map_err(told)?;
        for start in [p * (1.0 - 1e-5), p * (1.0 + 1e-5)] {
            let beside = Continuation::new(start, 1.01 * p).bounds(0.99 * p, 1.01 * p).both_ways();
            let beside = beside.max_points(200).shooting(Shooting::new().period_multiple(multiple));
            for guess in guesses_beside(&at.orbit)? {
                match beside.run(&family, &[guess]) {
                    Ok(branch) => {
                        draw.note(|| format!("beside {branch}"));
                        nearest = nearest.min(distance(&branch));
                    }
                    Err(error) => draw.note(|| format!("beside {start}: {error}")),
                }
            }
        }
    }
    Ok(agree(nearest < 1e-7 * p, || {
        format!("{} at {p:?}, damping {c:?}, missed by {nearest:.1e}; {pair:?}", line.what())
    }))
}
