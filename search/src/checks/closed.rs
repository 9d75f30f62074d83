//! Closed forms: a settled motion on one flank, modes of stiff chains, rows of equal balls, late times, tori, run-ups.

use crate::draw::Draw;
use crate::models::bodies::Bodies;
use crate::models::flanks::Flanks;
use crate::models::pair::Pair;
use crate::models::tones::{Forced, Tones};
use crate::{Check, Outcome, agree};
use gear_dynamics::drives::{SpeedLaw, VaryingSpeed};
use gear_dynamics::linear::Modes;
use gear_dynamics::model::{Machine, from_fn};
use gear_dynamics::num_complex::Complex64;
use gear_dynamics::tori::{CircleShooting, ClosedCurve, TorusBalance, WaveVectors};
use gear_dynamics::trains::{Body, MeshPart, Parts, Warning};
use gear_dynamics::{Dop853, Integrator, Model, Periodic, Rk45, Settle, State, Taylor, Wave};
use std::f64::consts::TAU;

/// The checks of this file.
pub const CHECKS: [Check; 6] = [
    Check { name: "closed-far-flanks", run: |draw| flatten(far_flanks(draw)) },
    Check { name: "closed-stiffness", run: |draw| flatten(stiffness(draw)) },
    Check { name: "closed-rows-of-balls", run: |draw| flatten(balls(draw)) },
    Check { name: "closed-late-times", run: |draw| flatten(late_times(draw)) },
    Check { name: "closed-tori", run: |draw| flatten(tori(draw)) },
    Check { name: "closed-run-ups", run: |draw| flatten(run_ups(draw)) },
];

fn flatten(outcome: Result<Outcome, String>) -> Outcome {
    outcome.unwrap_or_else(Outcome::Fails)
}

fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// The smallest difference between 1 and another number.
const ROUNDING: f64 = f64::EPSILON;

/// A motion that stays on the upper flank is linear: x = b + F/k + Re (P/(k - Ω² + i c Ω) e^{iΩt}). The law of the other
/// flank is large, or the gap is.
fn far_flanks(draw: &mut Draw) -> Result<Outcome, String> {
    let model = Flanks::draw(draw);
    let (tolerance, offset) = (draw.scale(1e-10, 1e-6), draw.within(-0.5, 0.5));
    draw.note(|| format!("{model:?} {tolerance:e} {offset}"));
    let text = format!("{model:?} {tolerance:e} {offset}");
    // An offset that the flank bears: the free motion is not larger than the forced one.
    let response = model.response();
    let start = State::new(0.0, &[model.rest() + offset * response.norm()], &[0.0]);
    let settle = Settle::new().tolerance(tolerance).max_periods(20_000).max_period_multiple(1);
    let atol = 1e-14 * response.norm();
    let [dop853, rk45] = [1e-13, 1e-12];
    let solvers: [(&str, f64, Box<dyn Integrator>); 2] = [
        ("Dop853", dop853, Box::new(Dop853::new().rtol(dop853).atol(atol))),
        ("Rk45", rk45, Box::new(Rk45::new().rtol(rk45).atol(atol))),
    ];
    // The error is the change of the last period, and what the solver errs in a period, over that of all further ones.
    let contraction = (-0.5 * model.damping * model.period()).exp();
    let gap = model.rest() / response.norm();
    let off = |state: &State| {
        let turn = response * Complex64::cis(model.speed * state.t);
        let off = [state.q[0] - model.rest() - turn.re, (state.v[0] + model.speed * turn.im) / model.speed];
        off[0].abs().max(off[1].abs()) / (2.0 * response.norm())
    };
    for (name, rtol, solver) in solvers {
        let state = settle.run(&*solver, &model, &start).map(|steady| steady.state).map_err(told);
        // Relative to the coordinate a step errs by rtol; a period has some fifty steps.
        let exact = State::new(0.0, &[model.rest() + response.re], &[-model.speed * response.im]);
        let own = solver.end(&model, &exact, model.period()).map_err(told);
        let is_rounding = |error: &String| error.contains("the rounding of the coordinates");
        let refused = [&state, &own].into_iter().any(|run| run.as_ref().is_err_and(is_rounding));
        if refused && atol < ROUNDING * model.rest() {
            return Ok(Outcome::Skipped("the tolerance is below the rounding of the coordinate"));
        }
        let state = state.map_err(|error| format!("{name}: {error}; {text}"))?;
        let own = off(&own?);
        if own > 50.0 * rtol * gap + 1e-10 {
            return Err(format!("{name}: off by {own:e} of the range in a period; {text}"));
        }
        let allowed = 10.0 * tolerance * contraction / (1.0 - contraction)
            + (1e3 * ROUNDING * gap + 2.0 * own + 1e-10) / (1.0 - contraction);
        let off = off(&state);
        draw.note(|| {
            format!(
                "{name}: off {off:e}, allowed {allowed:e}, in a period {own:e}, after {} periods",
                state.t / model.period()
            )
        });
        if off.is_nan() || off > allowed {
            return Err(format!("{name}: off by {off:e} of the range, allowed {allowed:e}; {text}"));
        }
    }
    Ok(Outcome::Agrees)
}

/// Three gears in a row are three masses m_i = J_i/r_i² with two springs: ω² are the roots of
/// λ² - λ (k_1 (1/m_1 + 1/m_2) + k_2 (1/m_2 + 1/m_3)) + k_1 k_2 (m_1 + m_2 + m_3)/(m_1 m_2 m_3), and 0.
fn stiffness(draw: &mut Draw) -> Result<Outcome, String> {
    let teeth = [0, 1, 2].map(|_| 18 + draw.below(40) as u32);
    let radii = teeth.map(|z| 1e-3 * f64::from(z));
    let inertias = [0, 1, 2].map(|_| draw.scale(1e-6, 1e6));
    let springs = [0, 1].map(|_| draw.scale(1e0, 1e12));
    let text = format!("teeth {teeth:?}, inertias {inertias:?}, stiffness {springs:?}");
    draw.note(|| text.clone());
    let mut parts = Parts::new();
    for (name, inertia) in ["first", "idler", "last"].into_iter().zip(inertias) {
        parts.body(name, Body::new(inertia));
    }
    let mesh = |i: usize| -> Result<MeshPart, String> {
        let stiffness = Wave::constant(springs[i]).map_err(told)?;
        Ok(MeshPart::external([teeth[i], teeth[i + 1]], [radii[i], radii[i + 1]], stiffness))
    };
    parts.mesh("one", "first", "idler", mesh(0)?).mesh("two", "idler", "last", mesh(1)?);
    parts.torque("drive", "first", 1.0).load("last").accept(Warning::UnusualValue);
    let train = parts.build("first", 1.0).map_err(|error| format!("{error}; {text}"))?;
    let modes = Modes::mean_in_contact(&train).map_err(|error| format!("{error}; {text}"))?;
    let [m1, m2, m3] = [0, 1, 2].map(|i| inertias[i] / radii[i].powi(2));
    let [k1, k2] = springs;
    let half = 0.5 * (k1 * (1.0 / m1 + 1.0 / m2) + k2 * (1.0 / m2 + 1.0 / m3));
    let product = (k1 / m1) * (k2 / m2) * (m1 + m2 + m3) / m3;
    // half² - product without cancellation: a sum of squares.
    let difference = 0.5 * (k1 * (1.0 / m1 + 1.0 / m2) - k2 * (1.0 / m2 + 1.0 / m3));
    let high = half + difference.hypot((k1 * k2).sqrt() / m2);
    let exact = [product / high, high];
    // The accelerations are sums: a rate of 1e-16 of the highest one is not in them.
    if exact[0] < 16.0 * ROUNDING * exact[1] {
        return Ok(Outcome::Skipped("the soft mode is below the rounding of the accelerations"));
    }
    let found = modes.all();
    draw.note(|| format!("exact {exact:?}, found {found:?}"));
    // Relative coordinates leave the rigid motion out.
    if !(2..=3).contains(&found.len()) || modes.unstable_count() > 0 {
        return Err(format!("{} modes, {} unstable; {text}", found.len(), modes.unstable_count()));
    }
    for exact in exact {
        let near = |mode: &&gear_dynamics::linear::Mode| {
            let off = (mode.square() / exact - 1.0).abs();
            off <= 1e-9 + 10.0 * mode.rounding()
        };
        if !found.iter().any(|mode| near(&mode) && mode.square() != 0.0) {
            let all: Vec<[f64; 2]> = found.iter().map(|mode| [mode.square(), mode.rounding()]).collect();
            return Err(format!("no mode of {exact:e}: squares and rounding {all:?}; {text}"));
        }
    }
    Ok(agree(modes.rigid_count() + 2 == found.len(), || {
        format!("{} rigid motions; {text}", modes.rigid_count())
    }))
}

/// Equal balls between two walls, e = 1, exchange their velocities: the places are those of balls that pass through one
/// another.
fn balls(draw: &mut Draw) -> Result<Outcome, String> {
    let n = 2 + draw.below(5);
    let wall = draw.within(1.0, 4.0);
    let (mut q, v): (Vec<f64>, Vec<f64>) =
        (0..n).map(|_| (draw.within(0.02, 0.98) * wall, draw.within(-2.0, 2.0))).unzip();
    q.sort_by(f64::total_cmp);
    let end = draw.within(1.0, 20.0);
    let text = format!("{q:?} {v:?} {wall} {end}");
    draw.note(|| text.clone());
    // One ball alone: its way folded between the walls.
    let alone = |q: f64, v: f64| {
        let way = (q + v * end).rem_euclid(2.0 * wall);
        if way > wall { [2.0 * wall - way, -v] } else { [way, v] }
    };
    let mut exact: Vec<[f64; 2]> = q.iter().zip(&v).map(|(q, v)| alone(*q, *v)).collect();
    exact.sort_by(|a, b| a[0].total_cmp(&b[0]));
    // At the end no two balls touch.
    let places = || [0.0].into_iter().chain(exact.iter().map(|x| x[0])).chain([wall]);
    if places().zip(places().skip(1)).any(|(a, b)| b - a < 1e-6) {
        return Ok(Outcome::Skipped("two balls touch at the end"));
    }
    let balls = Bodies {
        masses: vec![1.0; n],
        squares: vec![0.0; n],
        places: vec![0.0; n],
        ceiling: wall,
        restitution: vec![1.0; n + 1],
        twice: false,
    };
    let machine = Machine::of_constants(balls, &[("speed", 1.0)]).map_err(told)?;
    let start = State::new(0.0, &q, &v);
    let runs = [
        ("Dop853", Dop853::new().rtol(1e-11).atol(1e-13).end(&machine, &start, end).map_err(told)),
        ("Rk45", Rk45::new().rtol(1e-11).atol(1e-13).end(&machine, &start, end).map_err(told)),
        ("Taylor", Taylor::new().end(&machine, &start, end).map_err(told)),
    ];
    for (name, state) in runs {
        let state = state.map_err(|error| format!("{name}: {error}; {text}"))?;
        let off = exact
            .iter()
            .enumerate()
            .fold(0.0f64, |m, (i, x)| m.max((state.q[i] - x[0]).abs()).max((state.v[i] - x[1]).abs()));
        draw.note(|| format!("{name} {:?} {:?}, exact {exact:?}, off {off:e}", state.q, state.v));
        if off.is_nan() || off > 1e-9 {
            return Err(format!("{name}: off by {off:e}; {text}"));
        }
    }
    Ok(Outcome::Agrees)
}

/// A motion that starts N periods later is the same one later, up to the rounding of the time. A tolerance below that
/// rounding cannot be met, and a solver may say so.
fn late_times(draw: &mut Draw) -> Result<Outcome, String> {
    let (pair, speed) = (Pair::draw(draw), draw.within(0.4, 2.4));
    let periods = draw.scale(1.0, 1e9).round();
    let (q, v) = (draw.within(0.0, 1.5), draw.within(-0.2, 0.2));
    let text = format!("{pair:?} {speed} {periods:e} {q} {v}");
    draw.note(|| text.clone());
    let train = pair.at(speed).map_err(told)?;
    let period = train.period();
    let n = train.dof();
    let at = |t: f64, more: f64| {
        let mut state = State::at_rest(n);
        (state.t, state.q[0], state.v[0]) = (t, q + more, v);
        state
    };
    let late = periods * period;
    let cycles = 3.0 * period;
    // What the rounding of the time and a small difference become.
    let slip = 4.0 * ROUNDING * late;
    let exact =
        |start: &State| Dop853::new().rtol(1e-12).atol(1e-14).end(&train, start, cycles).map_err(told);
    let (first, beside) = (exact(&at(0.0, 0.0))?, exact(&at(0.0, 1e-7))?);
    let apart = |a: &State, b: &State| {
        let off = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        off(&a.q, &b.q).max(off(&a.v, &b.v))
    };
    let growth = (apart(&first, &beside) / 1e-7).max(1.0);
    let allowed = growth * (1e-8 + 200.0 * slip);
    let rtol = slip.max(1e-11);
    let (dop853, rk45) =
        (Dop853::new().rtol(rtol).atol(1e-2 * rtol), Rk45::new().rtol(rtol).atol(1e-2 * rtol));
    let runs = [
        ("Dop853", dop853.end(&train, &at(late, 0.0), late + cycles).map_err(told)),
        ("Rk45", rk45.end(&train, &at(late, 0.0), late + cycles).map_err(told)),
        ("Taylor", Taylor::new().end(&train, &at(late, 0.0), late + cycles).map_err(told)),
    ];
    for (name, state) in runs {
        let state = state.map_err(|error| format!("{name}: {error}; {text}"))?;
        let off = apart(&state, &first);
        draw.note(|| format!("{name}: off {off:e}, allowed {allowed:e}, growth {growth}"));
        if off.is_nan() || off > allowed {
            return Err(format!("{name}: off by {off:e}, allowed {allowed:e}; {text}"));
        }
    }
    Ok(Outcome::Agrees)
}

/// x'' + c x' + k x = P cos θ_1 + R cos θ_2: x = Re Σ P_i/(k - ω_i² + i c ω_i) e^{iθ_i}; perturbations grow by e^{-cT/2}.
fn tori(draw: &mut Draw) -> Result<Outcome, String> {
    let model = Tones::draw(draw);
    let multiples = [1 + draw.below(3), 1 + draw.below(3)];
    let text = format!("{model:?} {multiples:?}");
    draw.note(|| text.clone());
    let exact = |angles: [f64; 2]| {
        let turns = [0, 1].map(|i| model.response(i) * Complex64::cis(angles[i]));
        let rates = [0, 1].map(|i| turns[i] * Complex64::i() * model.frequencies[i]);
        [turns[0].re + turns[1].re, rates[0].re + rates[1].re]
    };
    let size = [0, 1].map(|i| model.response(i).norm() * model.frequencies[i].max(1.0)).iter().sum::<f64>();
    let check = |name: &str, angles: [f64; 2], state: &State| {
        let [q, v] = exact(angles);
        let off = (state.q[0] - q).abs().max((state.v[0] - v).abs()) / size;
        draw.note(|| format!("{name} at {angles:?}: off {off:e}"));
        if off.is_nan() || off > 1e-7 { Err(format!("{name}: off by {off:e}; {text}")) } else { Ok(()) }
    };
    let balance = TorusBalance::new(WaveVectors::within(&[2, 2]).map_err(told)?);
    let start = balance.at_rest(&model, &[0.0]).map_err(told)?;
    let torus = balance.solve(&model, &start).map_err(|error| format!("balance: {error}; {text}"))?;
    let places = [[0.3, 1.7], [4.0, 2.0], [5.5, 6.0]];
    for angles in places {
        check("TorusBalance", angles, &torus.at_angles(&angles))?;
    }
    for strobe in [0, 1] {
        let flat = (0..5).map(|j| State::new(0.0, &[size * (TAU * f64::from(j) / 5.0).cos()], &[0.1 * size]));
        let guess = ClosedCurve::new(&flat.collect::<Vec<_>>()).map_err(told)?;
        let shooting = CircleShooting::new().strobed_frequency(strobe).period_multiple(multiples[strobe]);
        let circle =
            shooting.solve(&model, &guess).map_err(|error| format!("circle {strobe}: {error}; {text}"))?;
        for [_, theta] in places {
            let mut angles = [0.0; 2];
            angles[1 - strobe] = theta;
            check("CircleShooting", angles, &circle.at(theta))?;
        }
        let growth = -0.5 * model.damping * circle.period();
        let (found, allowed) = (circle.growth(), circle.growth_error());
        let off = (found - growth).abs();
        draw.note(|| format!("growth {found} ± {allowed:e} exact {growth}"));
        if off.is_nan() || off > allowed {
            return Err(format!("growth {found} ± {allowed:e} of the circle, exact {growth}; {text}"));
        }
    }
    Ok(Outcome::Agrees)
}

/// x'' + 2 ζ x' + x = cos nφ, φ = ω_0 t + α t²/2 (the Fresnel integral of a run-up): x = ∫ h(t - s) cos nφ(s) ds.
fn run_ups(draw: &mut Draw) -> Result<Outcome, String> {
    let (zeta, order) = (draw.within(0.005, 0.2), 1 + draw.below(4));
    let speeds = [draw.within(0.1, 2.0), draw.within(0.1, 2.0)].map(|x| x / order as f64);
    let duration = draw.scale(5.0, 200.0);
    let end = duration * draw.within(0.3, 1.3);
    let text = format!("{zeta} order {order} {speeds:?} in {duration}, to {end}");
    draw.note(|| text.clone());
    let slope = (speeds[1] - speeds[0]) / duration;
    let angle = |t: f64| {
        let in_ramp = t.min(duration);
        in_ramp * (speeds[0] + 0.5 * slope * in_ramp) + (t - in_ramp) * speeds[1]
    };
    // Duhamel's integral by the Gauss rule of order 10 on short panels; a panel ends with the ramp.
    let damped = (1.0 - zeta * zeta).sqrt();
    let kernel = |s: f64| {
        let (sin, cos) = (damped * s).sin_cos();
        let decay = (-zeta * s).exp();
        [decay * sin / damped, decay * (cos - zeta / damped * sin)]
    };
    const NODES: [f64; 5] = [
        -0.906_179_845_938_664,
        -0.538_469_310_105_683_1,
        0.0,
        0.538_469_310_105_683_1,
        0.906_179_845_938_664,
    ];
    const WEIGHTS: [f64; 5] = [
        0.236_926_885_056_189_08,
        0.478_628_670_499_366_5,
        0.568_888_888_888_888_9,
        0.478_628_670_499_366_5,
        0.236_926_885_056_189_08,
    ];
    let mut exact = [0.0; 2];
    for [from, to] in [[0.0, end.min(duration)], [end.min(duration), end]] {
        let panels = ((to - from) * 10.0).ceil();
        let h = (to - from) / panels.max(1.0);
        for k in 0..panels as usize {
            for (node, weight) in NODES.iter().zip(WEIGHTS) {
                let s = from + h * (k as f64 + 0.5 + 0.5 * node);
                let force = (order as f64 * angle(s)).cos();
                exact
                    .iter_mut()
                    .zip(kernel(end - s))
                    .for_each(|(x, h_s)| *x += 0.5 * h * weight * h_s * force);
            }
        }
    }
    let shape = Forced::of_order(order as u32).map_err(told)?;
    let machine =
        Machine::of_constants(shape, &[("speed", speeds[0]), ("damping", 2.0 * zeta)]).map_err(told)?;
    let law = SpeedLaw::ramp(speeds[0], speeds[1], duration).map_err(told)?;
    let model = VaryingSpeed::new(machine, law);
    let rest = State::at_rest(1);
    let formula = from_fn(1, |t, q, v, a| a[0] = (order as f64 * angle(t)).cos() - 2.0 * zeta * v[0] - q[0]);
    let formula = formula.map_err(told)?;
    let dop853 = Dop853::new().rtol(1e-11).atol(1e-12);
    let runs = [
        ("Dop853", dop853.end(&model, &rest, end).map_err(told)),
        ("Taylor", Taylor::new().end(&model, &rest, end).map_err(told)),
        ("Rk45", Rk45::new().rtol(1e-10).atol(1e-11).end(&model, &rest, end).map_err(told)),
        ("formula by Dop853", dop853.end(&formula, &rest, end).map_err(told)),
    ];
    for (name, state) in runs {
        let state = state.map_err(|error| format!("{name}: {error}; {text}"))?;
        let off = (state.q[0] - exact[0]).abs().max((state.v[0] - exact[1]).abs());
        draw.note(|| format!("{name}: off {off:e}"));
        if off.is_nan() || off > 1e-7 {
            return Err(format!("{name}: off by {off:e}; {text}"));
        }
    }
    Ok(Outcome::Agrees)
}
