//! The first step of an adaptive run.

use crate::ode::stepping::control::RESOLUTION;
use crate::ode::stepping::engine::{Engine, Tableau};
use crate::ode::stepping::vector::Vector;

/// The least guess, in units of the resolution of the time.
const LEAST: f64 = 64.0;

/// First step from the norms d0, d1, d2 of the solution and its first and second derivative, in units of the
/// tolerances.   Source: Hairer, Nørsett & Wanner I, Sect. II.4, p. 169.
///
/// h0 = 0.01 d0/d1,   h1 = (0.01/max(d1, d2))^(1/k),   h = min(100 h0, h1, longest)
///
/// It is a guess: at late times it is no shorter than [`LEAST`] times the resolution of the time, and the
/// errors of the steps decide.
pub(crate) fn starting_step<T: Tableau, V: Vector>(e: &mut Engine<'_, V>, longest: f64) -> f64 {
    let rms = |v: &mut dyn Iterator<Item = f64>| {
        let (count, sum) = v.fold((0.0, 0.0), |(c, s), x| (c + 1.0, s + x * x));
        f64::sqrt(sum / f64::max(count, 1.0))
    };
    let size: Vec<f64> =
        e.ends.y.slice().iter().zip(e.ends.atol.slice()).map(|(y, atol)| atol + e.rtol * y.abs()).collect();
    let slope: Vec<f64> = e.k[0].slice().to_vec();
    let d0 = rms(&mut e.ends.y.slice().iter().zip(&size).map(|(y, s)| y / s));
    let d1 = rms(&mut slope.iter().zip(&size).map(|(f, s)| f / s));
    let h0 = if d0 < 1e-5 || d1 < 1e-5 { 1e-6 } else { 0.01 * d0 / d1 };
    let least = LEAST * RESOLUTION * e.ends.t.abs();
    let h0 = h0.max(least).min(longest);
    e.aim(e.ends.t + h0);
    e.euler();
    let d2 = rms(&mut e.k[1].slice().iter().zip(&slope).zip(&size).map(|((f1, f0), s)| (f1 - f0) / s)) / h0;
    let d = d1.max(d2);
    let h1 = if d <= 1e-15 { (h0 * 1e-3).max(1e-6) } else { (0.01 / d).powf(T::EXPONENT) };
    let h = (100.0 * h0).min(h1).max(least).min(longest);
    if h.is_finite() && h > 0.0 { h } else { h0 }
}
