//! Rigid stops against the reference: unequal bodies between a floor and a ceiling, with losses.

use crate::draw::Draw;
use crate::models::bodies::Bodies;
use crate::reference::Plain;
use crate::{Check, Outcome};
use gear_dynamics::model::Machine;
use gear_dynamics::{Dop853, Integrator, Rk45, State, Taylor};
use std::f64::consts::TAU;

/// The checks of this file.
pub const CHECKS: [Check; 1] =
    [Check { name: "reference-of-stops", run: |draw| stops(draw).unwrap_or_else(Outcome::Fails) }];

/// Steps of the reference in the shortest period.
const STEPS: f64 = 400.0;

/// Impacts closer than this share of a step are not resolved, and a collapse between two stops has more of them
/// than this, in three runs.
const CLOSE: f64 = 1e-6;
const COLLAPSE: usize = 12;

/// A small difference.
const BESIDE: f64 = 1e-7;

fn stops(draw: &mut Draw) -> Result<Outcome, String> {
    let n = 1 + draw.below(3);
    let ceiling = draw.within(1.0, 3.0);
    let mut places: Vec<f64> = (0..n).map(|_| draw.within(0.1, 0.9) * ceiling).collect();
    places.sort_by(f64::total_cmp);
    let bodies = Bodies {
        masses: (0..n).map(|_| draw.scale(0.1, 10.0)).collect(),
        squares: (0..n).map(|_| draw.scale(0.3, 10.0)).collect(),
        places,
        ceiling,
        restitution: (0..=n).map(|_| draw.one_of(&[0.5, 0.7, 0.9, 1.0])).collect(),
        twice: draw.below(2) == 0,
    };
    let mut q: Vec<f64> = (0..n).map(|_| draw.within(0.05, 0.95) * ceiling).collect();
    q.sort_by(f64::total_cmp);
    let v: Vec<f64> = (0..n).map(|_| draw.within(-3.0, 3.0)).collect();
    let end = draw.within(1.0, 8.0);
    let text = format!("{bodies:?} {q:?} {v:?} {end}");
    draw.note(|| text.clone());

    let strike = |contact: usize, v: &mut [f64]| {
        let sides = bodies.sides(contact);
        let rate = bodies.of(contact, v, 0.0);
        let inverse: f64 = sides.iter().flatten().map(|(body, _)| 1.0 / bodies.masses[*body]).sum();
        let impulse = -(1.0 + bodies.restitution[contact]) * rate.min(0.0) / inverse;
        for (body, sign) in sides.into_iter().flatten() {
            v[body] += sign * impulse / bodies.masses[body];
        }
    };
    let reference = Plain {
        dof: n,
        contacts: n + 1,
        accel: &|at, _, a| {
            for (i, a) in a.iter_mut().enumerate() {
                *a = bodies.squares[i] * (bodies.places[i] - at.q[i]);
            }
        },
        distances: &|at, contact| [bodies.of(contact, at.q, ceiling), -1.0],
        jump: &|_| f64::INFINITY,
        impact: Some(&strike),
    };
    let fastest = TAU / bodies.squares.iter().fold(0.0f64, |m, square| m.max(square.sqrt()));
    let from = |by: f64| -> Vec<f64> { q.iter().chain(&v).map(|x| x + by).collect() };
    let mut close = 0;
    let mut run = |by: f64, steps: f64| {
        let h = fastest / steps;
        reference.run(0.0, &from(by), end, h, &mut |part| {
            close += usize::from(part.end.t - part.start.t < CLOSE * h);
        })
    };
    let ([coarse, fine], beside) = ([STEPS, 2.0 * STEPS].map(|steps| run(0.0, steps)), run(BESIDE, STEPS));
    if coarse.1 != fine.1 || beside.1 != fine.1 || fine.1 > 200 {
        return Ok(Outcome::Skipped(
            "the reference makes other impacts with half the step or beside the start",
        ));
    }
    if close > COLLAPSE {
        return Ok(Outcome::Skipped("impacts follow closer than the reference resolves"));
    }
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
    let (open, growth) = (apart(&coarse.0, &fine.0), apart(&beside.0, &coarse.0) / BESIDE);
    if growth > 1e3 {
        return Ok(Outcome::Skipped("a small difference grows a thousandfold"));
    }
    let machine =
        Machine::of_constants(bodies.clone(), &[("speed", 1.0)]).map_err(|error| error.to_string())?;
    let start = State::new(0.0, &q, &v);
    let runs = [
        ("Dop853", Dop853::new().rtol(1e-11).atol(1e-13).end(&machine, &start, end)),
        ("Rk45", Rk45::new().rtol(1e-11).atol(1e-13).end(&machine, &start, end)),
        ("Taylor", Taylor::new().end(&machine, &start, end)),
    ];
    let allowed = 3.0 * open + 1e-8 * (1.0 + growth);
    for (name, state) in runs {
        let state = state.map_err(|error| format!("{name}: {error}; {text}"))?;
        let off = apart(&[&state.q[..], &state.v].concat(), &fine.0);
        draw.note(|| {
            format!(
                "{name} {:?} {:?}, reference {fine:?}, off {off:e}, allowed {allowed:e}",
                state.q, state.v
            )
        });
        if off.is_nan() || off > allowed {
            return Err(format!("{name}: off by {off:e}, allowed {allowed:e}; {text}"));
        }
    }
    Ok(Outcome::Agrees)
}
