//! Random shapes against a second integrator, differences and other engines; trains in lanes against single runs.

use crate::checks::branches::{Drawn, pair, set, stages};
use crate::draw::Draw;
use crate::models::chain::{Chain, any_law, flanks};
use crate::{Check, Outcome, agree};
use gear_dynamics::check::check_periodic;
use gear_dynamics::contact::{Contact, Nonlinearity};
use gear_dynamics::excitation::Side;
use gear_dynamics::model::{Jacobian, Machine, Shape};
use gear_dynamics::periodic::{FlowMethod, Variation};
use gear_dynamics::sweep::{
    Axis, InstructionSet, LaneRk4, Point, Points, Rows, TableRk4, bounds::SweepEngine,
};
use gear_dynamics::{Dop853, Integrator, Model, ParameterError, Periodic, Rk4, State, Sweep, Taylor};

/// The checks of this file.
pub const CHECKS: [Check; 7] = [
    Check { name: "integrators-of-chains", run: |draw| of_chain(draw, any_law, integrators) },
    Check { name: "slopes-of-chains", run: |draw| of_chain(draw, any_law, slopes) },
    Check { name: "flow-of-chains", run: |draw| of_chain(draw, any_law, flow) },
    Check {
        name: "lanes-of-chains",
        run: |draw| of_chain(draw, flanks, |draw, chain| lanes(draw, chain, 1, false)),
    },
    Check { name: "lanes-of-pairs", run: |draw| of_train(draw, pair, false) },
    Check { name: "lanes-of-sets", run: |draw| of_train(draw, set, true) },
    Check { name: "lanes-of-stages", run: |draw| of_train(draw, stages, true) },
];

type Compared = Result<Outcome, String>;

fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn of_chain<N: Nonlinearity + std::fmt::Debug>(
    draw: &mut Draw,
    law: fn(&mut Draw, f64) -> Result<N, ParameterError>,
    compare: fn(&mut Draw, &Machine<Chain<N>>) -> Compared,
) -> Outcome {
    let chain = match Chain::draw(draw, law) {
        Ok(chain) => chain,
        Err(error) => return Outcome::Fails(told(error)),
    };
    let text = Chain::describe(&chain);
    draw.note(|| text.clone());
    compare(draw, &chain).unwrap_or_else(|error| Outcome::Fails(format!("{error}; {text}")))
}

fn of_train(draw: &mut Draw, drawn: Drawn, is_in_si: bool) -> Outcome {
    let case = match drawn(draw) {
        Ok(case) => case,
        Err(error) => return Outcome::Fails(error),
    };
    draw.note(|| case.text.clone());
    let cycles = case.train.shape().cycles_in_a_period() as usize;
    let compared = lanes(draw, &case.train, cycles, is_in_si);
    compared.unwrap_or_else(|error| Outcome::Fails(format!("{error}; {}", case.text)))
}

fn random_state(draw: &mut Draw, dof: usize) -> State {
    let mut numbers = |size: f64| (0..dof).map(|_| draw.within(-size, size)).collect::<Vec<f64>>();
    let (q, v) = (numbers(2.0), numbers(1.0));
    State::new(0.0, &q, &v)
}

/// max |a_i - b_i| over coordinates and velocities.
fn distance(a: &State, b: &State) -> f64 {
    let pairs = a.q.iter().chain(&a.v).zip(b.q.iter().chain(&b.v));
    pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

/// Number of periods of an integration.
const PERIODS: f64 = 3.0;

/// `Taylor` and `Dop853` from a random state. An error made at an instant grows with the derivative of the flow from
/// there to the end.
fn integrators(draw: &mut Draw, chain: &Machine<Chain>) -> Compared {
    let (start, end) = (random_state(draw, chain.dof()), PERIODS * chain.period());
    let by_taylor = Taylor::new().rtol(1e-12).atol(1e-14).end(chain, &start, end).map_err(told)?;
    let by_dop853 = Dop853::new().rtol(1e-12).atol(1e-14).end(chain, &start, end).map_err(told)?;
    let mut growth = 1.0f64;
    for part in 0..8 {
        let state = match part {
            0 => start.clone(),
            part => Taylor::new().end(chain, &start, end * f64::from(part) / 8.0).map_err(told)?,
        };
        growth = growth.max(Variation::new().run(chain, &state, end).map_err(told)?.matrix.amax());
    }
    let apart = distance(&by_taylor, &by_dop853);
    draw.note(|| format!("apart {apart:.1e}, growth {growth:.1e}"));
    let findings = check_periodic(chain, &start);
    if !findings.is_empty() {
        return Err(format!("check_periodic: {findings:?}"));
    }
    Ok(agree(apart < 1e-9 * growth, || format!("the integrators differ by {apart:.1e}, growth {growth:.1e}")))
}

/// Exact derivatives of the acceleration, by state and by constant, against differences of fourth order.
fn slopes(draw: &mut Draw, chain: &Machine<Chain>) -> Compared {
    let n = chain.dof();
    let State { q, v, .. } = random_state(draw, n);
    let t = draw.within(0.0, chain.period());
    let mut u = vec![0.0; chain.drives()];
    chain.drive(t, Side::After, &mut u);
    let mut contacts = vec![Contact::default(); chain.contacts()];
    chain.contact(&u, &q, &v, &mut contacts);
    if contacts.iter().any(|c| c.penetration().abs() < 2.0 * 2.0 * WIDE) {
        return Ok(Outcome::Skipped("a contact near an edge"));
    }
    let mut exact = Jacobian::new(n);
    chain.jacobian(None, &u, &q, &v, &mut exact);
    let at = |q: &[f64], v: &[f64]| {
        let mut a = vec![0.0; n];
        chain.accel(&u, q, v, &mut a);
        a
    };
    for j in 0..2 * n {
        let by = |h: f64| {
            let mut y = [&q[..], &v].concat();
            y[j] += h;
            at(&y[..n], &y[n..])
        };
        for (i, difference) in fourth_order(by).into_iter().enumerate() {
            let slope = if j < n { exact.q[(i, j)] } else { exact.v[(i, j - n)] };
            if !close(slope, difference) {
                return Err(format!("da_{i}/dy_{j} is {slope:e}, differences {difference:?}"));
            }
        }
    }
    let names: Vec<String> = chain.names().iter().map(|name| name.name.clone()).collect();
    for name in names.iter().skip(1) {
        let exact = chain.slope(name, &u, &q, &v).map_err(told)?;
        let value = chain.constant(name).map_err(told)?;
        let by = |h: f64| {
            let (mut u, mut a) = (u.clone(), vec![f64::NAN; n]);
            if let Ok(moved) = chain.with(name, value + h) {
                moved.drive(t, Side::After, &mut u);
                // The angle at a time is that of the first speed.
                moved.accel(&u, &q, &v, &mut a);
            }
            a
        };
        for (i, difference) in fourth_order(by).into_iter().enumerate() {
            if !close(exact[i], difference) {
                return Err(format!("da_{i}/d {name} is {:e}, differences {difference:?}", exact[i]));
            }
        }
    }
    Ok(Outcome::Agrees)
}

/// The longer step of the differences.
const WIDE: f64 = 2e-3;

/// Differences of fourth order with two steps.
fn fourth_order(by: impl Fn(f64) -> Vec<f64>) -> Vec<[f64; 2]> {
    let difference = |h: f64| {
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|times| by(times * h));
        (0..a.len()).map(|i| (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * h)).collect::<Vec<f64>>()
    };
    difference(WIDE).into_iter().zip(difference(0.5 * WIDE)).map(|(coarse, fine)| [coarse, fine]).collect()
}

/// Whether a slope agrees with differences.
fn close(slope: f64, [coarse, fine]: [f64; 2]) -> bool {
    (slope - fine).abs() < 3.0 * (coarse - fine).abs() + 1e-8 * (1.0 + slope.abs())
}

/// The derivative of the flow by both methods, and against differences of the motion.
fn flow(draw: &mut Draw, chain: &Machine<Chain>) -> Compared {
    let (start, end) = (random_state(draw, chain.dof()), chain.period());
    let by = |method| Variation::new().flow_method(method).run(chain, &start, end).map_err(told);
    let [a, b] = [by(FlowMethod::Taylor)?, by(FlowMethod::Dop853)?];
    let growth = a.matrix.amax().max(1.0);
    let apart = (&a.matrix - &b.matrix).amax();
    draw.note(|| format!("matrices apart {apart:.1e}, growth {growth:.1e}, crossings {}", a.crossings));
    // Near a grazing small errors of the motion change the saltation much: compare the differences alone there.
    let n = chain.dof();
    let solver = Taylor::new().rtol(1e-13).atol(1e-15);
    let mut open: f64 = 0.0;
    for j in 0..2 * n {
        let moved = |h: f64| -> Result<Vec<f64>, String> {
            let mut y = [&start.q[..], &start.v].concat();
            y[j] += h;
            let state = solver.end(chain, &State::new(0.0, &y[..n], &y[n..]), end).map_err(told)?;
            Ok([state.q, state.v].concat())
        };
        let mut by_step = Vec::new();
        for h in [2e-5, 1e-5] {
            let [low, high] = [moved(-h)?, moved(h)?];
            by_step.push((0..2 * n).map(|i| (high[i] - low[i]) / (2.0 * h)).collect::<Vec<f64>>());
        }
        for (i, (coarse, fine)) in by_step[0].iter().zip(&by_step[1]).enumerate() {
            let uncertain = 3.0 * (coarse - fine).abs() + 1e-7 * growth;
            open = open.max(uncertain);
            if (a.matrix[(i, j)] - fine).abs() > uncertain {
                let exact = a.matrix[(i, j)];
                return Err(format!("dy_{i}/dy_{j} is {exact:e}, differences {coarse:e} and {fine:e}"));
            }
        }
    }
    Ok(agree(apart < 1e-7 * growth + open, || format!("the matrices differ by {apart:.1e}")))
}

/// Steps of the fixed-step engines in a turn of the waves of a model without units.
const STEPS: usize = 64;

/// One sweep over the speed by lanes with the best and the plainest instructions, and each point alone: equal bits.
/// `TableRk4` and `Rk4` with the same steps give the same motions up to rounding.
fn lanes<G: Shape + Send + Sync>(
    draw: &mut Draw,
    machine: &Machine<G>,
    cycles: usize,
    is_in_si: bool,
) -> Compared {
    let speed = machine.constant("speed").map_err(told)?;
    let speeds: Vec<f64> = (0..5).map(|i| speed * (1.0 + 0.1 * f64::from(i) + 0.01 * draw.unit())).collect();
    // Mesh cycles are long at low speeds, the fastest mode of a gear is not.
    let per_cycle = if is_in_si { (128.0 * (400.0 / speed).max(1.0)) as usize } else { STEPS };
    let steps = cycles * per_cycle;
    let points = || Axis::of_values("speed", &speeds).map(Points::from).map_err(told);
    let lanes = LaneRk4::new(steps).lanes::<4>();
    let plain = InstructionSet::available().into_iter().next().ok_or("no instructions")?;
    let together = rows(machine, points()?, &lanes)?;
    let again = rows(machine, points()?, &lanes.instructions(plain))?;
    let prints = [&together, &again].map(Rows::fingerprint);
    draw.note(|| format!("{prints:x?}, errors {:?}", together.errors().first_key_value()));
    if prints[0] != prints[1] {
        return Err(format!("the rows depend on the instructions: {prints:x?}"));
    }
    let table = rows(machine, points()?, &TableRk4::new(steps))?;
    for (i, speed) in speeds.iter().enumerate() {
        let Ok(row) = together.get(i) else { continue };
        let alone = Points::from(Axis::of_values("speed", &[*speed]).map_err(told)?);
        let alone = rows(machine, alone, &lanes)?;
        let alone = alone.get(0).map_err(told)?;
        if row.channel("q0") != alone.channel("q0") || !row.strobes().eq(alone.strobes()) {
            return Err(format!("the row at {speed:?} depends on its neighbours"));
        }
        let [a, b] = [row, table.get(i).map_err(told)?].map(|row| row.channel("q0").map_err(told));
        let (a, b) = (a?, b?);
        if (a.rms - b.rms).abs() > 1e-6 * a.rms {
            return Err(format!("RMS of the row at {speed:?}: {:e} in lanes, {:e} one by one", a.rms, b.rms));
        }
        let moved = machine.with("speed", *speed).map_err(told)?;
        let method = Rk4::new(moved.period() / steps as f64).plain();
        let rest = State::at_rest(moved.dof());
        let end = method.end(&moved, &rest, 2.0 * moved.period()).map_err(told)?;
        let Some(strobed) = row.strobes().last() else { return Err("no strobed state".into()) };
        let n = moved.dof();
        let apart = distance(&end, &State::new(0.0, &strobed[..n], &strobed[n..]));
        let size = end.q.iter().chain(&end.v).fold(0.0, |most: f64, x| most.max(x.abs()));
        if apart > 1e-6 * size {
            return Err(format!("at {speed:?} the run ends {apart:.1e} from that of Rk4, size {size:.1e}"));
        }
    }
    Ok(Outcome::Agrees)
}

fn rows<G, E>(machine: &Machine<G>, points: Points, engine: &E) -> Result<Rows, String>
where
    G: Shape + Send + Sync,
    E: SweepEngine<Machine<G>>,
{
    let sweep = Sweep::new(points).settle(1).measure(1).channels(&["q0"]).rattle().strobe(1);
    let start = |_: &Point<'_>, model: &Machine<G>| Ok::<_, ParameterError>(State::at_rest(model.dof()));
    sweep.of(engine, |p| machine.with("speed", p["speed"])).start(start).run().map_err(told)
}
