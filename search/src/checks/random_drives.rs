//! A mass under the paths of random processes, on its force and its damping, against the reference.

use crate::draw::Draw;
use crate::models::curve::Curve;
use crate::models::driven::Driven;
use crate::reference::{Plain, next_of};
use crate::{Check, Outcome};
use gear_dynamics::drives::Noisy;
use gear_dynamics::excitation::Side;
use gear_dynamics::processes::{
    FilteredNoise, HeldProcess, JitteredOrder, OrnsteinUhlenbeck, Process, ShotNoise, SpectralProcess,
};
use gear_dynamics::{Dop853, Integrator, State, Taylor};
use rand_distr::Normal;
use std::f64::consts::TAU;

/// The checks of this file.
pub const CHECKS: [Check; 1] =
    [Check { name: "reference-of-processes", run: |draw| drives(draw).unwrap_or_else(Outcome::Fails) }];

/// Accuracy of `Dop853`, whose steps pass over knots of a spline that lie close together, and of `Taylor`, whose
/// steps end at all of them.
const OF_KNOTS: f64 = 1e-8;
const OF_SERIES: f64 = 1e-8;

/// Length of the run.
const END: f64 = 15.0;

/// Least number of steps of the reference.
const STEPS: f64 = 2000.0;

fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// A random process of a size of some 0.5, and what it was made of.
fn process(draw: &mut Draw) -> Result<(Box<dyn Process>, String), String> {
    let (size, tau, share) = (draw.within(0.1, 0.5), draw.within(0.2, 3.0), draw.within(0.2, 0.9));
    let (seed, member) = (draw.below(1 << 40) as u64, draw.below(1000) as u64);
    let zeta = draw.within(0.05, 0.9);
    let h = share * tau;
    let kind = draw.below(6);
    let made: Box<dyn Process> = match kind {
        0 => Box::new(OrnsteinUhlenbeck::new(size, tau, h).map_err(told)?.seed(seed).member(member)),
        1 => Box::new(FilteredNoise::new(size, 1.0 / tau, zeta, h).map_err(told)?.seed(seed).member(member)),
        2 => {
            let values = Normal::new(0.0, size).map_err(told)?;
            Box::new(HeldProcess::new(h, values).map_err(told)?.seed(seed).member(member))
        }
        3 => {
            let sizes = Normal::new(size, size).map_err(told)?;
            Box::new(ShotNoise::new(1.0 / h, tau, sizes).map_err(told)?.seed(seed).member(member))
        }
        4 => Box::new(JitteredOrder::new(size, 2.0, 1.0 / tau, h).map_err(told)?.seed(seed).member(member)),
        _ => {
            let made = SpectralProcess::new(|_| size * size, [0.0, zeta], 3 + draw.below(20));
            Box::new(made.map_err(told)?.seed(seed).member(member))
        }
    };
    Ok((made, format!("process {kind} {size:?} {tau:?} {share:?} {zeta:?} {seed} {member}")))
}

fn drives(draw: &mut Draw) -> Result<Outcome, String> {
    let push = Curve::draw(draw, 0.0, 0.5);
    let mean = draw.within(0.5, 3.0);
    let stiffness = Curve::draw(draw, mean, 0.3 * mean);
    let (speed, damping) = (draw.within(0.4, 2.0), draw.within(0.05, 0.3));
    let start = [draw.within(-0.5, 0.5), draw.within(-0.5, 0.5)];
    let ((first, one), (second, two)) = (process(draw)?, process(draw)?);
    // The first process acts on the force, the second one on force and damping.
    let gains = [draw.within(-1.0, 1.0), draw.within(-0.5, 0.5), draw.within(-0.2, 0.2)];
    let text = format!("{push:?} {stiffness:?} {speed:?} {damping:?} {start:?} {one} {two} {gains:?}");
    draw.note(|| text.clone());
    let waves = [push.wave().map_err(told)?, stiffness.wave().map_err(told)?];
    let machine = Driven { waves }.at(speed, 0.0, damping).map_err(told)?;
    let [force, friction] = ["force", "damping"].map(|name| machine.slot(name).map_err(told));
    let (force, friction) = (force?, friction?);
    let noisy = Noisy::new(machine).add(&[(force, gains[0])], &*first).map_err(told)?;
    let noisy = noisy.add(&[(force, gains[1]), (friction, gains[2])], &*second).map_err(told)?;
    // The process that is added as number k has stream k.
    let paths = [first.path(0), second.path(1)];
    let curves = [push.plain(), stiffness.plain()];
    let places: Vec<f64> =
        [&push, &stiffness].into_iter().flat_map(Curve::places).map(|angle| angle / speed).collect();
    let plain = Plain {
        dof: 1,
        contacts: 0,
        accel: &|at, _, a| {
            let [x, y] = [0, 1].map(|i| paths[i].at(at.t, Side::After));
            let [push, stiffness] = [0, 1].map(|i| curves[i](speed * at.t));
            let c = damping + gains[2] * y;
            a[0] = push + gains[0] * x + gains[1] * y - c * at.v[0] - stiffness * at.q[0];
        },
        distances: &|_, _| [0.0; 2],
        jump: &|t| {
            let jumps = paths.iter().filter_map(|path| path.next_edge(t));
            jumps.fold(next_of(&places, TAU / speed, t), f64::min)
        },
        impact: None,
    };
    let [coarse, fine] = [STEPS, 2.0 * STEPS].map(|n| plain.run(0.0, &start, END, END / n, &mut |_| {}).0);
    let begin = State::new(0.0, &[start[0]], &[start[1]]);
    let ends = [
        ("Dop853", Dop853::new().rtol(1e-12).atol(1e-14).end(&noisy, &begin, END), OF_KNOTS),
        ("Taylor", Taylor::new().end(&noisy, &begin, END), OF_SERIES),
    ];
    for (name, end, own) in ends {
        let end = end.map_err(|error| format!("{name}: {error}; {text}"))?;
        for (i, found) in [end.q[0], end.v[0]].into_iter().enumerate() {
            let allowed = 2.0 * (fine[i] - coarse[i]).abs() + own;
            let off = (found - fine[i]).abs();
            draw.note(|| format!("{name}: end {i} off by {off:e}, allowed {allowed:e}"));
            if off.is_nan() || off > allowed {
                return Err(format!("{name}: end {i} off by {off:e}, allowed {allowed:e}; {text}"));
            }
        }
    }
    Ok(Outcome::Agrees)
}
