//! Trains with symmetries, in relative and in inertial coordinates.
//!
//! In relative coordinates the differences of equal members rest at 0, and only rounding is left in them.

use crate::draw::Draw;
use crate::models::symmetric::Symmetric;
use crate::{Check, Outcome, agree};
use gear_dynamics::analysis::{SettleError, Summary};
use gear_dynamics::branches::{BranchEnd, Continuation, Family, Figure, Sensitivity};
use gear_dynamics::linear::Modes;
use gear_dynamics::nalgebra::DMatrix;
use gear_dynamics::periodic::{BalanceError, FlowMethod, Lyapunov, ShootingOrbit, Variation};
use gear_dynamics::sweep::{Axis, LaneRk4, Located, Points, bounds::SweepEngine};
use gear_dynamics::trains::{Coordinates, Train};
use gear_dynamics::{
    Balance, Dop853, Harmonics, Integrator, Model, Periodic, Settle, Shape, Shooting, State, Statistics,
    Sweep, Taylor,
};

/// The checks of this file.
pub const CHECKS: [Check; 3] = [
    Check { name: "symmetric-coordinates", run: coordinates },
    Check { name: "symmetric-solvers", run: solvers },
    Check { name: "symmetric-methods", run: methods },
];

/// Largest difference of multipliers `[1]`, over max(1, |μ|).
const SAME: f64 = 1e-9;

/// Largest difference of swings, as a share of the largest one `[1]`.
const SAME_SWING: f64 = 1e-8;

/// A settled state and its period multiple.
fn settled<I: Integrator>(by: &I, train: &Train) -> Result<(State, usize), SettleError> {
    let settle = Settle::new().tolerance(1e-8).max_periods(400);
    settle.run(by, train, &State::at_rest(train.dof())).map(|steady| (steady.state, steady.period_multiple))
}

fn by_taylor() -> Taylor {
    Taylor::new().rtol(1e-11).atol(1e-16)
}

fn orbit(train: &Train, guess: &State, multiple: usize) -> Result<ShootingOrbit, String> {
    let shooting = Shooting::new().period_multiple(multiple).flow_method(FlowMethod::Taylor);
    shooting.solve(train, guess).map_err(|error| error.to_string())
}

/// The largest distance of a multiplier of either list to the other list, over max(1, |μ|).
fn apart(a: &ShootingOrbit, b: &ShootingOrbit) -> f64 {
    let [a, b] = [a, b].map(|orbit| orbit.multipliers().values().to_vec());
    let mut worst: f64 = if a.len() == b.len() { 0.0 } else { f64::INFINITY };
    let mut left = b;
    for x in a {
        let nearest = (0..left.len()).min_by(|&i, &j| (left[i] - x).norm().total_cmp(&(left[j] - x).norm()));
        let Some(i) = nearest else { return f64::INFINITY };
        worst = worst.max((left.swap_remove(i) - x).norm() / x.norm().max(1.0));
    }
    worst
}

/// Peak-to-peak deflection of each mesh.
fn swings(train: &Train, orbit: &ShootingOrbit) -> Result<Vec<f64>, String> {
    Ok(deflections(train, orbit)?.iter().map(Summary::peak_to_peak).collect())
}

/// Statistics of the deflection of each mesh.
fn deflections(train: &Train, orbit: &ShootingOrbit) -> Result<Vec<Summary>, String> {
    let said = |error: &dyn std::fmt::Display| error.to_string();
    let names: Vec<String> = (0..train.contacts()).map(|i| format!("deflection {i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut statistics = Statistics::new(train, &names).map_err(|e| said(&e))?;
    orbit.observe(train, &mut statistics).map_err(|e| said(&e))?;
    names.iter().map(|name| statistics.summary(name).map_err(|e| said(&e))).collect()
}

/// Why swings are not compared.
const ROUNDED: &str = "the swings are within the rounding of the coordinates";

/// The rounding errors of a period are those of the coordinates, of which deflections are differences.
fn rounding(orbit: &ShootingOrbit) -> f64 {
    let coordinates = orbit.states().iter().flat_map(|state| &state.q);
    64.0 * f64::EPSILON * coordinates.fold(0.0, |m: f64, q| m.max(q.abs()))
}

/// Settles in both coordinates and compares the orbits and their multipliers.
fn coordinates(draw: &mut Draw) -> Outcome {
    let model = Symmetric::draw(draw);
    draw.note(|| format!("{model:?}"));
    let fails = |what: &str, why: String| Outcome::Fails(format!("{what}: {why}; {model:?}"));
    let trains = [Coordinates::Inertial, Coordinates::Relative].map(|frame| model.train(frame));
    let [inertial, relative] = match trains {
        [Ok(inertial), Ok(relative)] => [inertial, relative],
        [Err(error), _] | [_, Err(error)] => return fails("build", error),
    };
    let (start, multiple) = match settled(&by_taylor(), &inertial) {
        Ok(found) => found,
        Err(SettleError::Aperiodic { .. }) => match settled(&by_taylor(), &relative) {
            // A chaotic motion and an orbit may exist side by side. Other rounding errors lead to the orbit, then.
            Ok(_) => match settled(&Dop853::new().rtol(1e-11).atol(1e-16), &inertial) {
                Ok(_) => return Outcome::Skipped("the coordinates settle on different orbits"),
                Err(_) => return fails("settle", "only in relative coordinates".into()),
            },
            Err(_) => return Outcome::Skipped("the motion does not repeat"),
        },
        Err(error) => return fails("settle, inertial", error.to_string()),
    };
    let (own, found) = match settled(&by_taylor(), &relative) {
        Ok(found) => found,
        Err(error) => return fails("settle, relative", error.to_string()),
    };
    if found != multiple {
        return Outcome::Skipped("the coordinates settle on different orbits");
    }
    let orbits = [(&inertial, &start), (&relative, &own)].map(|(train, at)| orbit(train, at, multiple));
    let [a, b] = match orbits {
        [Ok(a), Ok(b)] => [a, b],
        [Err(error), _] => return fails("shooting, inertial", error),
        [_, Err(error)] => return fails("shooting, relative", error),
    };
    let swings = [(&inertial, &a), (&relative, &b)].map(|(train, orbit)| swings(train, orbit));
    let [of_a, of_b] = match swings {
        [Ok(a), Ok(b)] => [a, b],
        [Err(error), _] | [_, Err(error)] => return fails("statistics", error),
    };
    let largest = of_a.iter().fold(0.0, |m: f64, x| m.max(*x));
    let apart_by = of_a.iter().zip(&of_b).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
    if largest > 0.0 && [&a, &b].into_iter().any(|orbit| rounding(orbit) > SAME_SWING * largest) {
        return Outcome::Skipped(ROUNDED);
    }
    // A train without load rests.
    let off = if largest > 0.0 { apart_by / largest } else { apart_by };
    if off > 1e-4 {
        return Outcome::Skipped("the coordinates settle on different orbits");
    }
    let apart = apart(&a, &b);
    draw.note(|| format!("multipliers apart {apart:.1e}, swings {off:.1e}"));
    let told =
        |orbit: &ShootingOrbit| (orbit.crossing_count(), orbit.states().len(), orbit.corrections().to_vec());
    draw.note(|| format!("crossings, nodes, corrections {:?} {:?}", told(&a), told(&b)));
    draw.note(|| format!("swings {of_a:?} {of_b:?}"));
    draw.note(|| format!("ranges {:?} {:?}", a.range(), b.range()));
    draw.note(|| format!("inertial {:?}", a.multipliers()));
    draw.note(|| format!("relative {:?}", b.multipliers()));
    agree(apart <= SAME && off <= SAME_SWING, || {
        format!("multipliers differ by {apart:.1e}, swings by {off:.1e}; {model:?}")
    })
}

/// Runs every solver in relative coordinates: none refuses, all agree.
fn solvers(draw: &mut Draw) -> Outcome {
    let model = Symmetric::draw(draw);
    draw.note(|| format!("{model:?}"));
    let fails = |what: &str, why: String| Outcome::Fails(format!("{what}: {why}; {model:?}"));
    let train = match model.train(Coordinates::Relative) {
        Ok(train) => train,
        Err(error) => return fails("build", error),
    };
    let (start, multiple) = match settled(&by_taylor(), &train) {
        Ok(found) => found,
        Err(SettleError::Aperiodic { .. }) => return Outcome::Skipped("the motion does not repeat"),
        Err(error) => return fails("settle by Taylor", error.to_string()),
    };
    let solver = Dop853::new().rtol(1e-11).atol(1e-16);
    match settled(&solver, &train) {
        Ok((_, found)) if found == multiple => {}
        Ok(_) => return Outcome::Skipped("the integrators settle on different orbits"),
        Err(error) => return fails("settle by DOP853", error.to_string()),
    }
    let reference = match orbit(&train, &start, multiple) {
        Ok(orbit) => orbit,
        Err(error) => return fails("shooting", error),
    };
    let again = Shooting::new().period_multiple(multiple).flow_method(FlowMethod::Dop853);
    match again.solve(&train, &start) {
        Err(error) => return fails("shooting by DOP853", error.to_string()),
        Ok(orbit) => {
            let apart = apart(&orbit, &reference);
            draw.note(|| format!("by DOP853 {:?}", orbit.multipliers()));
            draw.note(|| format!("by Taylor {:?}", reference.multipliers()));
            if apart > SAME {
                return fails("shooting by DOP853", format!("multipliers differ by {apart:.1e}"));
            }
        }
    }
    let (first, period) = (&reference.states()[0], train.period());
    match Variation::new().run(&train, first, first.t + multiple as f64 * period) {
        Err(error) => return fails("variation", error.to_string()),
        Ok(through) => {
            // In units of the ranges of motion, beside the largest element on the way: of a damped motion those at the
            // end are small against those of the first part of a period.
            let (range, exact) = (reference.range(), reference.monodromy());
            let places = || (0..range.len()).flat_map(|i| (0..range.len()).map(move |j| (i, j)));
            let largest = |matrix: &DMatrix<f64>| {
                places().fold(1.0, |m: f64, (i, j)| m.max((matrix[(i, j)] * range[j] / range[i]).abs()))
            };
            let mut size = largest(exact);
            for part in [0.001, 0.01, 0.1] {
                match Variation::new().run(&train, first, first.t + part * multiple as f64 * period) {
                    Err(error) => return fails("variation", error.to_string()),
                    Ok(part) => size = size.max(largest(&part.matrix)),
                }
            }
            let error =
                |(i, j): (usize, usize)| (through.matrix[(i, j)] - exact[(i, j)]) * range[j] / range[i];
            let off = places().map(error).fold(0.0, |m: f64, error| m.max(error.abs())) / size;
            if off > 1e-8 {
                return fails("variation", format!("the matrix differs by {off:.1e}"));
            }
        }
    }
    // The exponents of a periodic orbit are ln|μ|/period.
    let lyapunov = Lyapunov::new().settle(0).align(20).measure(20).count(1);
    match lyapunov.run(&train, first) {
        Err(error) => return fails("Lyapunov exponents", error.to_string()),
        Ok(found) => {
            // Per period of the drives.
            let exact = reference.multipliers().largest().ln() / multiple as f64;
            let (value, error) = (found.per_period()[0], found.standard_error()[0]);
            draw.note(|| format!("exponent {value} ± {error}, exact {exact}"));
            // Slow modes beat against each other over more than the 20 periods.
            let per_orbit = 1.0 / multiple as f64;
            let decays = (-0.7..-0.05).contains(&(exact / per_orbit));
            if decays && (value - exact).abs() > 5.0 * error + 0.05 * (exact.abs() + per_orbit) {
                return fails("Lyapunov exponents", format!("{value} ± {error}, by multipliers {exact}"));
            }
        }
    }
    let findings = gear_dynamics::check::check_periodic(&train, &start);
    agree(findings.is_empty(), || format!("check_periodic: {findings:?}; {model:?}"))
}

/// Balance, sweeps, branches and sensitivities in both coordinates.
fn methods(draw: &mut Draw) -> Outcome {
    let model = Symmetric::draw(draw);
    draw.note(|| format!("{model:?}"));
    let made = [Coordinates::Inertial, Coordinates::Relative].map(|frame| {
        let train = model.train(frame)?;
        let (start, multiple) = match settled(&by_taylor(), &train) {
            Ok(found) => found,
            Err(_) => return Ok(None),
        };
        let orbit = orbit(&train, &start, multiple)?;
        Figures::of(&train, &start, &orbit).map(|figures| {
            draw.note(|| format!("{figures:?}"));
            Some(figures)
        })
    });
    match made {
        [Ok(Some(a)), Ok(Some(b))] => {
            let is_rounded = |f: &Figures| f.swing > 0.0 && f.rounding > SAME_SWING * f.swing;
            if is_rounded(&a) || is_rounded(&b) {
                return Outcome::Skipped(ROUNDED);
            }
            let apart = a.differences(&b);
            agree(apart.is_empty(), || format!("{}; {model:?}", apart.join(", ")))
        }
        [Ok(_), Ok(_)] => Outcome::Skipped("the motion does not repeat"),
        [Err(error), _] => Outcome::Fails(format!("inertial: {error}; {model:?}")),
        [_, Err(error)] => Outcome::Fails(format!("relative: {error}; {model:?}")),
    }
}

/// What does not depend on the coordinates.
#[derive(Debug)]
struct Figures {
    multiple: usize,
    /// Whether the orbit is stable. Rounding errors decide which motion a row leaves an unstable one for.
    stable: bool,
    /// Peak-to-peak deflection of the first mesh, and its rounding.
    swing: f64,
    rounding: f64,
    /// Its derivatives with respect to all constants, times the constants.
    slopes: Vec<f64>,
    /// Peak-to-peak deflection by balance; `None` if it does not converge from the linearised start.
    balance: Option<f64>,
    /// Period multiples of rows by located edges and by lanes.
    rows: [Option<usize>; 2],
    /// Their changes over a period of the motion.
    changes: [f64; 2],
    /// Kinds and speeds of the located points over speeds 3 % higher, then the swing at the highest speed.
    points: Vec<(String, f64)>,
    last: Option<f64>,
}

impl Figures {
    fn of(train: &Train, start: &State, orbit: &ShootingOrbit) -> Result<Self, String> {
        let multiple = orbit.period_multiple();
        let deflected = deflections(train, orbit)?;
        let swing = deflected[0].peak_to_peak();
        let mean: Vec<f64> = deflected.iter().map(|summary| summary.mean).collect();
        let said = |what: &str, error: &dyn std::fmt::Display| format!("{what}: {error}");
        let sensitivity =
            Sensitivity::of(train, orbit, &["deflection 0"]).map_err(|e| said("sensitivity", &e))?;
        let slopes = sensitivity.slopes(Figure::Mean, "deflection 0").map_err(|e| said("sensitivity", &e))?;
        let slopes = slopes.iter().zip(train.values()).map(|(slope, constant)| slope * constant).collect();
        // The linearised start has all contacts on one flank.
        let one_flank = mean.iter().all(|mean| *mean > 0.0);
        let balance = if multiple == 1 && one_flank { by_balance(train)? } else { None };
        let speed = train.constant("speed").map_err(|e| said("speed", &e))?;
        let [(located, change), (lanes, by_lanes)] =
            [by_rows(train, start, &Located(Dop853::new().rtol(1e-10).atol(1e-16)))?, {
                // Fixed steps are stable and accurate where they resolve the fastest mode.
                let modes = Modes::mean_in_contact(train).map_err(|e| said("modes", &e))?;
                let fastest = modes.all().iter().fold(0.0, |m: f64, mode| m.max(mode.square().sqrt()));
                let cycles = train.shape().cycles_in_a_period() as usize;
                let steps = 128.0f64.max(fastest * train.period() / cycles as f64).ceil() as usize * cycles;
                by_rows(train, start, &LaneRk4::new(steps).lanes::<4>())?
            }];
        let family = Family::over(train, ["speed"]).map_err(|e| said("family", &e))?;
        let continuation = Continuation::new(speed, 1.03 * speed).max_points(200);
        let continuation = continuation.shooting(Shooting::new().period_multiple(multiple));
        let branch = continuation.run(&family, orbit.states()).map_err(|e| said("branch", &e))?;
        let points =
            branch.located().map(|(kind, point)| (kind.kind().to_string(), point.parameter)).collect();
        let ended = matches!(branch.end(), BranchEnd::Bound | BranchEnd::Points { .. });
        if !ended {
            return Err(format!("branch: {}", branch.end()));
        }
        let at_bound = branch.points().last().filter(|_| branch.end() == &BranchEnd::Bound);
        let last = at_bound.map(|point| point.summaries[0].peak_to_peak());
        let (rows, changes) = ([located, lanes], [change, by_lanes]);
        let stable = orbit.multipliers().largest() < 1.0;
        let rounding = rounding(orbit);
        Ok(Figures { multiple, stable, swing, rounding, slopes, balance, rows, changes, points, last })
    }

    /// The names and values of what differs.
    fn differences(&self, other: &Figures) -> Vec<String> {
        let mut found = Vec::new();
        let mut compare = |name: &str, a: f64, b: f64, size: f64, tolerance: f64| {
            let off = (a - b).abs();
            if off > tolerance * size || off.is_nan() {
                found.push(format!("{name} {a:e} and {b:e}"));
            }
        };
        if self.multiple != other.multiple || (self.swing - other.swing).abs() > 1e-4 * self.swing {
            return found; // different orbits
        }
        compare("swing", self.swing, other.swing, self.swing, SAME_SWING);
        let largest = self.slopes.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        for (i, (a, b)) in self.slopes.iter().zip(&other.slopes).enumerate() {
            compare(&format!("derivative {i}"), *a, *b, largest, 1e-6);
        }
        if let [Some(a), Some(b)] = [self.balance, other.balance] {
            compare("swing by balance", a, b, self.swing, SAME_SWING);
        }
        if let [Some(a), Some(b)] = [self.last, other.last] {
            compare("last swing", a, b, a, 1e-6);
        }
        if self.points.len() == other.points.len() {
            for ((kind, a), (other, b)) in self.points.iter().zip(&other.points) {
                compare(&format!("{kind} and {other} at"), *a, *b, *a, 1e-8);
            }
        } else {
            found.push(format!("points {:?} and {:?}", self.points, other.points));
        }
        if self.stable && self.rows != other.rows {
            let told = |figures: &Figures| format!("{:?} {:?}", figures.rows, figures.changes);
            found.push(format!("period multiples {} and {}", told(self), told(other)));
        }
        found
    }
}

/// Peak-to-peak deflection of the first mesh by harmonic balance and, from its orbit, by shooting.
fn by_balance(train: &Train) -> Result<Option<f64>, String> {
    let harmonics = Harmonics::up_to(8 * train.shape().cycles_in_a_period() as usize);
    let balance = Balance::new(harmonics);
    let start = balance.linearised(train, gear_dynamics::contact::Piece::Upper);
    let start = start.map_err(|error| format!("linearised: {error}"))?;
    let found = match balance.solve(train, &start) {
        Ok(found) => found,
        Err(BalanceError::NotConverged { .. }) => return Ok(None),
        Err(error) => return Err(format!("balance: {error}")),
    };
    let polished = Shooting::new().solve_from(train, &found).map_err(|error| format!("polish: {error}"))?;
    Ok(Some(swings(train, &polished)?[0]))
}

/// Period multiple of one row that starts on the orbit.
fn by_rows<E>(train: &Train, start: &State, engine: &E) -> Result<(Option<usize>, f64), String>
where
    E: SweepEngine<Train>,
{
    let speed = train.constant("speed").map_err(|error| error.to_string())?;
    let points = Points::from(Axis::of_values("speed", &[speed]).map_err(|error| error.to_string())?);
    let start = State { t: 0.0, ..start.clone() };
    let rows = Sweep::new(points)
        .settle(100)
        .measure(8)
        .of(engine, |p| train.with("speed", p["speed"]))
        .start(|_, _| start.clone())
        .run()
        .map_err(|error| format!("sweep: {error}"))?;
    let row = rows.iter().next().ok_or("no row")?;
    Ok((row.period_multiple(), row.change()))
}
