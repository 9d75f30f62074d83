//! White noise by steps against closed forms: moments of a linear oscillator, long runs in a dead zone.

use crate::draw::Draw;
use crate::reference::exceeds;
use crate::{Check, Outcome};
use gear_dynamics::models::Oscillator;
use gear_dynamics::random::{Estimate, LongRun, NoisySteps, WhiteNoise};
use gear_dynamics::{Machine, Shape, State};
use std::f64::consts::{PI, TAU};

/// The checks of this file.
pub const CHECKS: [Check; 2] = [
    Check { name: "closed-noisy-ends", run: |draw| ends(draw).unwrap_or_else(Outcome::Fails) },
    Check { name: "closed-noisy-runs", run: |draw| runs(draw).unwrap_or_else(Outcome::Fails) },
];

/// Exponent of the probability e^-x with which a correct answer lies outside of one bound: 2e-9, 6 standard
/// errors of a normal mean.
pub const RARE: f64 = 20.0;

/// Members of an ensemble of ends: 2 bounds of the mean, 2 of the mean square.
const MEMBERS: usize = 1024;

fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// Compares numbers that should be independent and normal of mean 0 and variance 1.
///
/// P(|mean| √n > √(2x)) < 2 e^-x. A sum of n squares exceeds n + 2 √(n x) + 2x, or is less than n - 2 √(n x),
/// each with a probability of at most e^-x.   Source: Laurent and Massart, Ann. Statist. 28 (2000) 1302,
/// Lemma 1.
///
/// `bias`: relative error of the variance that the method has beside.
///
/// # Errors
/// What lies outside of its bound.
pub fn is_normal(what: &str, numbers: impl Iterator<Item = f64>, bias: f64) -> Result<(), String> {
    let (count, sum, squares) = numbers.fold((0.0, 0.0, 0.0), |(n, s, q), z| (n + 1.0, s + z, q + z * z));
    let n: f64 = count;
    let mean: f64 = sum / n.sqrt();
    if exceeds(mean.abs(), (1.0 + bias) * (2.0 * RARE).sqrt()) {
        return Err(format!("{what}: the mean is {mean:.2} standard errors off"));
    }
    let half = 2.0 * (n * RARE).sqrt();
    let (low, high) = ((1.0 - bias) * (n - half), (1.0 + bias) * (n + half + 2.0 * RARE));
    if exceeds(squares, high) || squares < low {
        return Err(format!("{what}: a variance of {:.4}, expected 1, {n} values", squares / n));
    }
    Ok(())
}

/// x'' = F - c x' - k x + √D ξ from a given start, with damping and noise in the model, in the bath, or in
/// both.
///
/// With the deviation y from F/k: ⟨y⟩ = e^(At) y0, and the covariance is S - e^(At) S e^(At)ᵀ, S = D/(2c)
/// diag(1/k, 1).
fn ends(draw: &mut Draw) -> Result<Outcome, String> {
    let (k, force) = (draw.scale(0.3, 3.0), draw.within(-1.0, 1.0));
    let own = [0.0, draw.within(0.05, 0.6)][draw.below(2)];
    let bath = if own == 0.0 { draw.within(0.05, 0.6) } else { [0.0, draw.within(0.05, 0.6)][draw.below(2)] };
    let intensities = match draw.below(3) {
        0 => [draw.scale(0.01, 1.0), 0.0],
        1 => [0.0, draw.scale(0.01, 1.0)],
        _ => [draw.scale(0.01, 1.0), draw.scale(0.01, 1.0)],
    };
    let speed = draw.within(0.5, 2.0);
    let start = [draw.within(-1.0, 1.0), draw.within(-1.0, 1.0)];
    let (steps, number) = (draw.one_of(&[240, 300, 360]), 20 + draw.below(600));
    let seed = draw.below(1 << 40) as u64;
    let text = format!(
        "k {k:?} F {force:?} c {own:?} + {bath:?} D {intensities:?} speed {speed:?} {start:?} {steps} {number} {seed}"
    );
    draw.note(|| text.clone());
    let constants = [("speed", speed), ("damping", own), ("linear stiffness", k), ("mean force", force)];
    let model = Oscillator::new(&constants).map_err(told)?;
    let slot = model.slot("mean force").map_err(told)?;
    // The gain -2 on the force multiplies the intensity by 4.
    let noise = [
        WhiteNoise::bath(0, bath, intensities[0]).map_err(told)?,
        WhiteNoise::drives(&[(slot, -2.0)], 0.25 * intensities[1]).map_err(told)?,
    ];
    let solver = NoisySteps::new(steps, &noise).seed(seed);
    let (h, at) = (TAU / speed / steps as f64, State::new(0.0, &[start[0]], &[start[1]]));
    let periods = number as f64 / steps as f64;
    let found = solver.ends(&model, &at, periods, MEMBERS).map_err(told)?;
    let few = solver.clone().lanes::<4>().ends(&model, &at, periods, 9).map_err(told)?;
    if few[..] != found[..9] {
        return Err(format!("the members differ with the number of lanes; {text}"));
    }
    let (c, t) = (own + bath, number as f64 * h);
    let flow = exponential(c, k, t);
    let [x0, v0] = [start[0] - force / k, start[1]];
    let mean = [flow[0][0] * x0 + flow[0][1] * v0 + force / k, flow[1][0] * x0 + flow[1][1] * v0];
    let level = 0.5 * (intensities[0] + intensities[1]) / c;
    let s = [level / k, level];
    let entry = |i: usize, j: usize| {
        let own = if i == j { s[i] } else { 0.0 };
        own - flow[i][0] * s[0] * flow[j][0] - flow[i][1] * s[1] * flow[j][1]
    };
    let deviations = [entry(0, 0).sqrt(), entry(1, 1).sqrt()];
    let correlation = entry(0, 1) / (deviations[0] * deviations[1]);
    draw.note(|| format!("mean {mean:?}, deviations {deviations:?}, correlation {correlation:?}"));
    // Splitting shifts coordinates by half a step of the noise: the variance of 20 steps changes by less than
    // 1/20² of it.
    let bias = 1.0 / (number * number) as f64 + (k + c * c) * h * h;
    let z = |end: &State| [(end.q[0] - mean[0]) / deviations[0], (end.v[0] - mean[1]) / deviations[1]];
    let free = |end: &State| {
        let [x, v] = z(end);
        (v - correlation * x) / (1.0 - correlation * correlation).sqrt()
    };
    let checked = is_normal("coordinates", found.iter().map(|end| z(end)[0]), bias)
        .and_then(|()| is_normal("velocities", found.iter().map(|end| z(end)[1]), bias))
        .and_then(|()| is_normal("velocities freed of coordinates", found.iter().map(free), 4.0 * bias));
    checked.map_err(|error| format!("{error}; {text}"))?;
    if found.iter().any(|end| (end.t - t).abs() > 1e-9 * t) {
        return Err(format!("the members end at {:?}, expected {t:?}; {text}", found[0].t));
    }
    Ok(Outcome::Agrees)
}

/// e^(At) of x'' = -c x' - k x for c² < 4k or c² > 4k.
fn exponential(c: f64, k: f64, t: f64) -> [[f64; 2]; 2] {
    let square = k - 0.25 * c * c;
    let turn = square.abs().sqrt();
    let (sine, cosine) = if square > 0.0 {
        ((turn * t).sin() / turn, (turn * t).cos())
    } else {
        ((turn * t).sinh() / turn, (turn * t).cosh())
    };
    let decay = (-0.5 * c * t).exp();
    [
        [decay * (cosine + 0.5 * c * sine), decay * sine],
        [-decay * k * sine, decay * (cosine - 0.5 * c * sine)],
    ]
}

/// Members of a long run, each one batch.
const BATCHES: usize = 192;

/// Standard errors between an estimate and its closed form: Student's t with 191 degrees of freedom exceeds 7
/// in 5e-11.
const ERRORS: f64 = 7.0;

/// x'' = F - c x' - g(x) + √D ξ with the dead zone g: p ∝ exp(-β (v²/2 + U(x))), β = 2c/D, normal beyond both
/// edges.
fn runs(draw: &mut Draw) -> Result<Outcome, String> {
    let (damping, intensity) = (draw.within(0.3, 1.2), draw.scale(0.05, 1.0));
    let beta = 2.0 * damping / intensity;
    let sigma = 1.0 / beta.sqrt();
    let (mesh, b) = (draw.scale(0.4, 2.0), sigma * draw.scale(0.1, 1.5));
    // Both flanks are met often.
    let load = draw.within(-0.5, 0.5) * sigma * mesh.sqrt();
    let seed = draw.below(1 << 40) as u64;
    let text = format!("c {damping:?} D {intensity:?} k {mesh:?} F {load:?} b {b:?} seed {seed}");
    draw.note(|| text.clone());
    let constants = [("speed", 1.0), ("mesh stiffness", mesh), ("mean force", load), ("half backlash", b)];
    let model = Oscillator::new(&constants).map_err(told)?;
    let noise = [WhiteNoise::bath(0, damping, intensity).map_err(told)?];
    let solver = NoisySteps::new(160, &noise).seed(seed);
    let exact = Exact::of(beta, [mesh, load, b]);
    draw.note(|| format!("{exact:?}"));
    // The slowest rate is no less than some 0.15: e^-9 of the start is left.
    let long = LongRun::new(10.0, 12.0).map_err(told)?.members(BATCHES).channels(&["q0", "v0"]);
    compare(draw, &long, &solver, &model, &exact).map_err(|error| format!("{error}; {text}"))
}

/// The stationary figures.
#[derive(Debug)]
struct Exact {
    sigma: f64,
    /// Shares of time below, within and above the gap.
    shares: [f64; 3],
    mean: f64,
    square: f64,
    /// Rates of crossing into the lower and the upper flank.
    rates: [f64; 2],
}

impl Exact {
    fn of(beta: f64, [mesh, load, b]: [f64; 3]) -> Self {
        let sigma = 1.0 / beta.sqrt();
        let potential = |x: f64| {
            let depth = (x.abs() - b).max(0.0);
            0.5 * mesh * depth * depth - load * x
        };
        // 12 deviations beyond both edges, by Simpson's rule from edge to edge.
        let reach = 12.0 * sigma / mesh.sqrt() + load.abs() / mesh;
        let integral = |from: f64, to: f64, power: i32| {
            let n = 2000;
            let h = (to - from) / f64::from(n);
            let at = |i: i32| {
                let x = from + h * f64::from(i);
                x.powi(power) * (-beta * potential(x)).exp()
            };
            let weight = |i: i32| f64::from(if i == 0 || i == n { 1 } else { 2 + 2 * (i % 2) });
            (0..=n).map(|i| weight(i) * at(i)).sum::<f64>() * h / 3.0
        };
        let parts = |power: i32| {
            [(-b - reach, -b), (-b, b), (b, b + reach)].map(|(from, to)| integral(from, to, power))
        };
        let total: f64 = parts(0).iter().sum();
        Exact {
            sigma,
            shares: parts(0).map(|part| part / total),
            mean: parts(1).iter().sum::<f64>() / total,
            square: parts(2).iter().sum::<f64>() / total,
            rates: [-b, b].map(|edge| (-beta * potential(edge)).exp() / total * sigma / TAU.sqrt()),
        }
    }
}

fn compare<G: Shape + Send + Sync>(
    draw: &mut Draw,
    long: &LongRun<'_>,
    solver: &NoisySteps,
    model: &Machine<G>,
    exact: &Exact,
) -> Result<Outcome, String> {
    let seen = long.run(solver, model, &State::at_rest(1)).map_err(told)?;
    let contact = seen.contact(0).map_err(told)?;
    let speed = exact.sigma * (0.5 * PI).sqrt();
    let impacts = exact.rates[0] + exact.rates[1];
    let [mean, square] = ["q0", "v0"].map(|name| seen.mean(name).map_err(told));
    let [squares, energies] = ["q0", "v0"].map(|name| seen.mean_square(name).map_err(told));
    let figures: [(&str, Estimate, f64); 12] = [
        ("mean", mean?, exact.mean),
        ("mean velocity", square?, 0.0),
        ("mean square", squares?, exact.square),
        ("mean square of the velocity", energies?, exact.sigma * exact.sigma),
        ("share of the gap", contact.gap, exact.shares[1]),
        ("share of the lower flank", contact.flanks[0], exact.shares[0]),
        ("share of the upper flank", contact.flanks[1], exact.shares[2]),
        ("impacts on the lower flank", contact.impacts[0], exact.rates[0]),
        ("impacts on the upper flank", contact.impacts[1], exact.rates[1]),
        ("speed on the lower flank", contact.speed[0], speed),
        ("speed on the upper flank", contact.speed[1], speed),
        ("flight", contact.flight, exact.shares[1] / impacts),
    ];
    for (what, found, expected) in figures {
        let errors = (found.mean() - expected) / found.standard_error();
        draw.note(|| format!("{what} {:?}, {expected:?}: {errors:.2} standard errors", found.mean()));
        if errors.is_nan() || errors.abs() > ERRORS {
            return Err(format!("{what} {:?}, {expected:?}: {errors:.2} standard errors", found.mean()));
        }
    }
    Ok(Outcome::Agrees)
}
