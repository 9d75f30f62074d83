//! Random processes against their closed forms: distributions of exact values, pulses, powers of harmonics.

use crate::checks::noise::{RARE, is_normal};
use crate::draw::Draw;
use crate::reference::exceeds;
use crate::{Check, Outcome};
use gear_dynamics::excitation::Side;
use gear_dynamics::processes::{
    FilteredNoise, HeldProcess, JitteredOrder, OrnsteinUhlenbeck, Process, ShotNoise, SpectralProcess,
};
use rand_distr::Normal;
use std::f64::consts::{PI, TAU};

/// The checks of this file.
pub const CHECKS: [Check; 4] = [
    Check { name: "closed-normal-processes", run: |draw| normal(draw).unwrap_or_else(Outcome::Fails) },
    Check { name: "closed-jittered-orders", run: |draw| jittered(draw).unwrap_or_else(Outcome::Fails) },
    Check { name: "closed-shot-noise", run: |draw| shots(draw).unwrap_or_else(Outcome::Fails) },
    Check { name: "closed-spectra", run: |draw| spectra(draw).unwrap_or_else(Outcome::Fails) },
];

/// Members of an ensemble.
const MEMBERS: u64 = 1024;

fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn close(what: &str, found: Option<f64>, exact: f64, size: f64) -> Result<(), String> {
    match found {
        Some(found) if (found - exact).abs() <= 1e-12 * size => Ok(()),
        _ => Err(format!("the {what} is {found:?}, {exact:?}")),
    }
}

/// A member of a process.
type MemberOf = Box<dyn Fn(u64) -> Box<dyn Process>>;

/// Values at two nodes of the grid, in units of the deviation: normal, with the correlation of the formula.
fn normal(draw: &mut Draw) -> Result<Outcome, String> {
    let (sigma, mean) = (draw.scale(1e-3, 1e3), draw.within(-1.0, 1.0));
    let tau = draw.scale(0.01, 100.0);
    let (zeta, spacing) = (draw.scale(0.02, 4.0), draw.within(0.05, 0.9));
    let (first, apart) = (draw.below(5000), 1 + draw.below(12));
    let (seed, stream) = (draw.below(1 << 40) as u64, draw.below(4) as u64);
    let kind = draw.below(3);
    let text =
        format!("{kind} {sigma:?} {mean:?} {tau:?} {zeta:?} {spacing:?} {first} {apart} {seed} {stream}");
    draw.note(|| text.clone());
    // (member, spacing, mean, correlation, density at the frequency 1/(2π τ))
    let (member, h, mean, correlation, density): (MemberOf, f64, f64, f64, f64) = match kind {
        0 => {
            let h = spacing * tau;
            let process = OrnsteinUhlenbeck::new(sigma, tau, h).map_err(told)?.seed(seed);
            let correlation = (-(apart as f64) * spacing).exp();
            (Box::new(move |i| Box::new(process.clone().member(i))), h, 0.0, correlation, 2.0 * tau)
        }
        1 => {
            let fastest = if zeta > 1.0 { zeta + (zeta * zeta - 1.0f64).sqrt() } else { 1.0 };
            let h = spacing * tau / fastest;
            let process = FilteredNoise::new(sigma, 1.0 / tau, zeta, h).map_err(told)?.seed(seed);
            let s = apart as f64 * h / tau;
            let turn = (1.0 - zeta * zeta).abs().sqrt();
            let (sine, cosine) = if zeta < 1.0 {
                ((turn * s).sin() / turn, (turn * s).cos())
            } else {
                ((turn * s).sinh() / turn, (turn * s).cosh())
            };
            let correlation = (-zeta * s).exp() * (cosine + zeta * sine);
            // 2 D/(2 ζ ω²)² with D = 4 ζ ω³.
            (Box::new(move |i| Box::new(process.clone().member(i))), h, 0.0, correlation, 2.0 * tau / zeta)
        }
        _ => {
            let values = Normal::new(mean, sigma).map_err(told)?;
            let process = HeldProcess::new(tau, values).map_err(told)?;
            let process = process.moments(mean, sigma).map_err(told)?.seed(seed);
            let part = (0.5f64).sin() / 0.5;
            (Box::new(move |i| Box::new(process.clone().member(i))), tau, mean, 0.0, 2.0 * tau * part * part)
        }
    };
    let process = member(0);
    close("mean", process.mean(), mean, 1.0)?;
    close("variance", process.variance(), sigma * sigma, sigma * sigma)?;
    close("correlation", process.correlation(apart as f64 * h), correlation, 1.0)?;
    close(
        "density",
        process.density(1.0 / (TAU * tau)),
        density * sigma * sigma,
        10.0 * density * sigma * sigma,
    )?;
    let times = [first, first + apart].map(|k| k as f64 * h);
    let mut values = Vec::new();
    for i in 0..MEMBERS {
        let process = member(i);
        let (path, other) = (process.path(stream), process.path(stream + 1));
        let [x, y] = times.map(|t| (path.at(t, Side::After) - mean) / sigma);
        values.push([x, y, (other.at(times[0], Side::After) - mean) / sigma]);
        if i < 4 {
            between_nodes(&*process, stream, times[0], h, kind, sigma + mean.abs())
                .map_err(|error| format!("{error}; {text}"))?;
        }
    }
    let rest = (1.0 - correlation * correlation).sqrt();
    let half = 0.5f64.sqrt();
    is_normal("values", values.iter().map(|[x, ..]| *x), 1e-9)
        .and_then(|()| {
            is_normal("later values", values.iter().map(|[x, y, _]| (y - correlation * x) / rest), 1e-6)
        })
        .and_then(|()| is_normal("other streams", values.iter().map(|[x, _, z]| half * (x + z)), 1e-9))
        .and_then(|()| {
            is_normal("next members", values.windows(2).step_by(2).map(|w| half * (w[0][0] + w[1][0])), 1e-9)
        })
        .map_err(|error| format!("{error}; {text}"))?;
    Ok(Outcome::Agrees)
}

/// Between two nodes the path is a line (0), a cubic (1) or constant (2), and the next edge is the next node.
fn between_nodes(p: &dyn Process, stream: u64, t: f64, h: f64, kind: usize, size: f64) -> Result<(), String> {
    let path = p.path(stream);
    let x = |share: f64, side: Side| path.at(t + share * h, side);
    let inside = [0.125, 0.25, 0.375, 0.5, 0.625].map(|share| x(share, Side::After));
    // Differences of the order 2, 4 and 1 vanish.
    let [a, b, c, d, e] = inside;
    let bend = match kind {
        0 => (a - 2.0 * b + c).abs().max((x(0.0, Side::After) - 2.0 * c + x(0.75, Side::After)).abs()),
        1 => (a - 4.0 * b + 6.0 * c - 4.0 * d + e).abs(),
        _ => (b - a).abs().max((x(0.0, Side::After) - e).abs()),
    };
    let jump = (x(0.0, Side::After) - x(0.0, Side::Before)).abs();
    // The resolution of t over that of the path.
    let open = 1e-11 * size * (1.0 + 1e-3 * t / h);
    if exceeds(bend, open) || (kind < 2 && exceeds(jump, open)) {
        return Err(format!("a path bends by {bend:e} between nodes, or jumps by {jump:e} at one"));
    }
    let edge = path.next_edge(t + 0.3 * h);
    if !edge.is_some_and(|edge| (edge - t - h).abs() <= 1e-12 * (t + h)) {
        return Err(format!("the edge after {t:?} is {edge:?}, with a spacing of {h:?}"));
    }
    let series = path.series(t + 0.3 * h, 8).at(0.4 * h);
    let value = x(0.7, Side::After);
    if exceeds((series - value).abs(), open) {
        return Err(format!("a series gives {series:?}, the path {value:?}"));
    }
    Ok(())
}

/// The mean of n values within ±1 is at most √(2x/n) off, except with the probability 2 e^-x.
/// Source: Hoeffding, J. Amer. Statist. Assoc. 58 (1963) 13, Theorem 2.
fn is_mean(what: &str, values: impl Iterator<Item = f64>, exact: f64) -> Result<(), String> {
    let (count, sum) = values.fold((0.0, 0.0), |(n, sum), x| (n + 1.0, sum + x));
    let off = (sum / count - exact).abs();
    let allowed = (2.0 * RARE / count).sqrt();
    if off <= allowed { Ok(()) } else { Err(format!("{what}: off by {off:e}, allowed {allowed:e}")) }
}

/// Values a cos of a jittered order: bounded, with the mean square a²/2 and the correlation of the formula.
fn jittered(draw: &mut Draw) -> Result<Outcome, String> {
    let (a, omega, diffusion) = (draw.scale(1e-3, 1e3), draw.scale(0.1, 100.0), draw.scale(0.01, 1.0));
    let h = draw.within(0.05, 0.9) / diffusion;
    let (first, apart, seed) = (draw.below(5000), 1 + draw.below(4), draw.below(1 << 40) as u64);
    let text = format!("{a:?} {omega:?} {diffusion:?} {h:?} {first} {apart} {seed}");
    draw.note(|| text.clone());
    let process = JitteredOrder::new(a, omega, diffusion, h).map_err(told)?.seed(seed);
    let lag = apart as f64 * h;
    let correlation = (-diffusion * lag).exp() * (omega * lag).cos();
    close("variance", process.variance(), 0.5 * a * a, a * a)?;
    close("correlation", process.correlation(lag), correlation, 1.0 + omega * lag)?;
    let values: Vec<[f64; 3]> = (0..4 * MEMBERS)
        .map(|i| {
            let path = process.clone().member(i).path(0);
            let times = [first, first + apart].map(|k| k as f64 * h);
            let [x, y] = times.map(|t| path.at(t, Side::After) / a);
            [x, y, process.clone().member(i).path(1).at(times[0], Side::After) / a]
        })
        .collect();
    if values.iter().flatten().any(|x| exceeds(x.abs(), 1.0 + 1e-12)) {
        return Err(format!("a value exceeds the amplitude; {text}"));
    }
    is_mean("mean", values.iter().map(|[x, ..]| *x), 0.0)
        .and_then(|()| is_mean("mean square", values.iter().map(|[x, ..]| 2.0 * x * x - 1.0), 0.0))
        .and_then(|()| is_mean("correlation", values.iter().map(|[x, y, _]| x * y), 0.5 * correlation))
        .and_then(|()| is_mean("streams", values.iter().map(|[x, _, z]| x * z), 0.0))
        .map_err(|error| format!("{error}; {text}"))?;
    Ok(Outcome::Agrees)
}

/// A path of shot noise decays from pulse to pulse; their number is that of Poisson, their sizes are normal.
fn shots(draw: &mut Draw) -> Result<Outcome, String> {
    let (rate, overlap) = (draw.scale(0.01, 100.0), draw.within(0.2, 4.0));
    let (m, s) = (draw.within(-2.0, 2.0), draw.within(0.2, 1.0));
    let (seed, begin) = (draw.below(1 << 40) as u64, draw.within(0.0, 1000.0) / rate);
    let decay = overlap / rate;
    let text = format!("rate {rate:?} decay {decay:?} sizes {m:?} {s:?} begin {begin:?} seed {seed}");
    draw.note(|| text.clone());
    let process = ShotNoise::new(rate, decay, Normal::new(m, s).map_err(told)?).map_err(told)?.seed(seed);
    let process = process.moments(m, s).map_err(told)?;
    close("mean", process.mean(), overlap * m, overlap * 2.0)?;
    close("variance", process.variance(), 0.5 * overlap * (m * m + s * s), 10.0 * overlap)?;
    close("correlation", process.correlation(decay), (-1.0f64).exp(), 1.0)?;
    let (members, span) = (48, 8.0 / rate);
    let (mut sizes, mut number) = (Vec::new(), 0.0);
    for i in 0..members {
        let path = process.clone().member(i).path(i % 3);
        let (mut t, mut x) = (begin, path.at(begin, Side::After));
        while let Some(next) = path.next_edge(t).filter(|next| *next < begin + span) {
            let [before, after] = [Side::Before, Side::After].map(|side| path.at(next, side));
            let decayed = x * (-(next - t) / decay).exp();
            let middle = path.at(0.5 * (t + next), Side::After);
            let halfway = x * (-0.5 * (next - t) / decay).exp();
            if exceeds((before - decayed).abs(), 1e-9) || exceeds((middle - halfway).abs(), 1e-9) {
                return Err(format!("before {next:?} a path is {before:?}, expected {decayed:?}; {text}"));
            }
            sizes.push((after - before - m) / s);
            (t, x, number) = (next, after, number + 1.0);
        }
    }
    // Poisson: P(|K - μ| > √(2 μ x) + x/3) < 2 e^-x.   Source: Bennett, J. Amer. Statist. Assoc. 57 (1962)
    // 33.
    let expected = rate * span * members as f64;
    if exceeds((number - expected).abs(), (2.0 * expected * RARE).sqrt() + RARE / 3.0) {
        return Err(format!("{number} pulses, expected {expected}; {text}"));
    }
    is_normal("sizes", sizes.into_iter(), 1e-6).map_err(|error| format!("{error}; {text}"))?;
    Ok(Outcome::Agrees)
}

/// The projections of a path on its harmonics have the powers of their cells, and nothing else is in the
/// path.
fn spectra(draw: &mut Draw) -> Result<Outcome, String> {
    let (n, width) = (1 + draw.below(24), draw.scale(0.01, 100.0));
    let first = draw.below(5);
    // S = c0 + c1 r + c2 r² over the share r of the band.
    let c = [draw.within(0.0, 1.0), draw.within(0.0, 1.0), draw.within(0.0, 1.0)];
    let seed = draw.below(1 << 40) as u64;
    let text = format!("{n} {width:?} from {first} {c:?} seed {seed}");
    draw.note(|| text.clone());
    let start = first as f64 * width;
    let band = n as f64 * width;
    let density = |f: f64| {
        let r = (f - start) / band;
        c[0] + r * (c[1] + r * c[2])
    };
    let process = SpectralProcess::new(density, [start, start + band], n).map_err(told)?.seed(seed);
    let integral = |r: f64| band * r * (c[0] + r * (0.5 * c[1] + r * c[2] / 3.0));
    let power = |j: usize| integral((j + 1) as f64 / n as f64) - integral(j as f64 / n as f64);
    close("variance", process.variance(), integral(1.0), 10.0 * integral(1.0))?;
    let (repeats, count) = (2.0 / width, 4 * (first + n + 1));
    let mut phases = Vec::new();
    for member in 0..24 {
        let path = process.clone().member(member).path(member % 2);
        let offset = 0.1 * member as f64 * repeats;
        let value = |m: usize| path.at(offset + repeats * m as f64 / count as f64, Side::After);
        let values: Vec<f64> = (0..count).map(value).collect();
        let mut left = values.iter().map(|x| x * x).sum::<f64>() / count as f64;
        for j in 0..n {
            // The harmonic at (first + j + 1/2) Δf has turned 2 (first + j) + 1 times.
            let line = |m: usize| TAU * ((2 * (first + j) + 1) * m % count) as f64 / count as f64;
            let sum = |part: fn(f64) -> f64| {
                let terms = values.iter().enumerate().map(|(m, x)| x * part(line(m)));
                2.0 * terms.sum::<f64>() / count as f64
            };
            let [cosine, sine] = [sum(f64::cos), sum(f64::sin)];
            let found = 0.5 * (cosine * cosine + sine * sine);
            if exceeds((found - power(j)).abs(), 1e-10 * integral(1.0)) {
                return Err(format!("harmonic {j} has the power {found:?}, {:?}; {text}", power(j)));
            }
            left -= found;
            let turned = f64::atan2(-sine, cosine) - TAU * (start + (j as f64 + 0.5) * width) * offset;
            phases.push(turned.rem_euclid(TAU));
        }
        if exceeds(left.abs(), 1e-10 * integral(1.0)) {
            return Err(format!("a path has the power {left:e} beside its harmonics; {text}"));
        }
    }
    is_mean("phases", phases.iter().map(|phase| phase.cos()), 0.0)
        .and_then(|()| is_mean("phases", phases.iter().map(|phase| phase.sin()), 0.0))
        .and_then(|()| is_mean("phases", phases.iter().map(|phase| phase / PI - 1.0), 0.0))
        .map_err(|error| format!("{error}; {text}"))?;
    Ok(Outcome::Agrees)
}
