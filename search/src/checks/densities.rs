//! Stationary densities under white noise, against their closed form.

use crate::draw::Draw;
use crate::{Check, Outcome, agree};
use gear_dynamics::models::Oscillator;
use gear_dynamics::random::PathIntegration;
use std::f64::consts::TAU;

/// The checks of this file.
pub const CHECKS: [Check; 1] =
    [Check { name: "closed-densities", run: |draw| densities(draw).unwrap_or_else(Outcome::Fails) }];

/// Deviations of the velocity, and depths of the potential in units of D/2c, up to which the grid reaches.
const REACH: f64 = 7.0;

/// What rounding and quadrature of the closed form contribute.
const ROUNDING: f64 = 1e-9;

/// x'' = F - c x' - g(x) - l x - m x³ + √D ξ, g the dead zone: p ∝ exp(-β (v²/2 + U(x))) with β = 2c/D.
fn densities(draw: &mut Draw) -> Result<Outcome, String> {
    let (damping, intensity) = (draw.within(0.1, 1.0), draw.scale(0.05, 1.0));
    let beta = 2.0 * damping / intensity;
    let sigma = 1.0 / beta.sqrt();
    let (mesh, load) = (draw.scale(0.3, 3.0), draw.within(-0.3, 0.3));
    let half_backlash = sigma * draw.scale(0.1, 2.0);
    let [linear, cubic] = [0, 1].map(|_| if draw.below(2) == 0 { 0.0 } else { draw.within(0.05, 0.5) });
    let text = format!(
        "c {damping:?} D {intensity:?} k {mesh:?} F {load:?} b {half_backlash:?} l {linear:?} m {cubic:?}"
    );
    draw.note(|| text.clone());
    let potential = |x: f64| {
        let depth = (x.abs() - half_backlash).max(0.0);
        0.5 * mesh * depth * depth + 0.5 * linear * x * x + 0.25 * cubic * x.powi(4) - load * x
    };
    // Where the density has fallen to that of `REACH` deviations.
    let least = (-4000..4000).map(|i| potential(1e-3 * f64::from(i) * sigma)).fold(f64::INFINITY, f64::min);
    let end = |way: f64| {
        let mut x = way * half_backlash;
        while beta * (potential(x) - least) < 0.5 * REACH * REACH {
            x += way * 0.01 * sigma;
        }
        x
    };
    let ranges = [end(-1.0), end(1.0)];
    // Trapezoids of 1/50 000 of the range from edge to edge.
    let integral = |from: f64, to: f64| {
        let (n, at) = (50_000, |x: f64| (-beta * (potential(x) - least)).exp());
        let h = (to - from) / f64::from(n);
        let inner: f64 = (1..n).map(|i| at(from + h * f64::from(i))).sum();
        h * (0.5 * (at(from) + at(to)) + inner)
    };
    let parts = [
        integral(ranges[0], -half_backlash),
        integral(-half_backlash, half_backlash),
        integral(half_backlash, ranges[1]),
    ];
    let total: f64 = parts.iter().sum();
    let constants = [
        ("speed", 1.0),
        ("damping", damping),
        ("mesh stiffness", mesh),
        ("mean force", load),
        ("half backlash", half_backlash),
        ("linear stiffness", linear),
        ("cubic stiffness", cubic),
    ];
    let model = Oscillator::new(&constants).map_err(|error| error.to_string())?;
    let fastest = REACH * sigma;
    let method =
        PathIntegration::new(intensity, ranges, [-fastest, fastest]).map_err(|error| error.to_string())?;
    let density = method.panels(6).stationary(&model).map_err(|error| format!("{error}; {text}"))?;
    let allowed = density.total_error() + ROUNDING;
    draw.note(|| format!("error {:.1e}", density.total_error()));
    let shares = [
        (density.share(ranges[0], -half_backlash), parts[0]),
        (density.share(-half_backlash, half_backlash), parts[1]),
        (density.share(half_backlash, ranges[1]), parts[2]),
    ];
    for (found, part) in shares {
        let exact = part / total;
        draw.note(|| format!("share {found:?}, exact {exact:?}"));
        if (found - exact).abs() > 0.5 * allowed {
            return Ok(Outcome::Fails(format!(
                "a share of {found:?} is {exact:?}, allowed {allowed:.1e}; {text}"
            )));
        }
    }
    let rate = (-beta * (potential(half_backlash) - least)).exp() / total * sigma / TAU.sqrt();
    let found = density.upward_crossing_rate(half_backlash);
    draw.note(|| format!("crossings {found:?}, exact {rate:?}"));
    // A bound of the error of the density in the mean, not at one deflection: ten times as much is allowed there.
    Ok(agree((found - rate).abs() <= 10.0 * allowed * sigma, || {
        format!("{found:?} crossings per time are {rate:?}, allowed {allowed:.1e}; {text}")
    }))
}
