//! Rotation numbers of orbits of a map.

use crate::error::{ParameterError, check};
use crate::model::State;
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// ρ = Σ_k w_k (φ_{k+1} - φ_k)/Σ_k w_k: the mean rotation `[rad]` of successive points of a stroboscopic map
/// on an invariant circle, in [0, 2π).
///
/// φ is the polar angle in the plane of the two principal components, about the mean of the points. The
/// weights w = exp(-1/(s (1 - s))), s = (k + 1)/(N + 1), make the error smaller than any power of 1/N on a
/// smooth circle.   Source: Das, Saiki, Sander and Yorke, Nonlinearity 30 (2017) 4111.
///
/// The projected circle must enclose the mean once. The sense of rotation depends on the plane: the result is
/// ρ or 2π - ρ. Both describe the circle, with θ in opposite senses.
///
/// ```
/// use gear_dynamics::{State, tori::rotation_number};
/// let points: Vec<State> =
///     (0..2000).map(|k| 0.3 * k as f64).map(|a| State::new(0.0, &[2.0 * a.cos()], &[a.sin()])).collect();
/// let rho = rotation_number(&points)?;
/// assert!((rho - 0.3).abs().min((std::f64::consts::TAU - rho - 0.3).abs()) < 1e-12);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
///
/// # Errors
/// Fewer than 16 points; points of different sizes; numbers beyond ±1e50; points that do not leave a line.
pub fn rotation_number(points: &[State]) -> Result<f64, ParameterError> {
    check::at_least("points", points.len(), 16)?;
    let dof = points[0].q.len();
    points.iter().try_for_each(|point| point.check(dof))?;
    let m = 2 * dof;
    let count = points.len() as f64;
    let all = |s: &State, c: usize| if c < dof { s.q[c] } else { s.v[c - dof] };
    let mean: Vec<f64> = (0..m).map(|c| points.iter().map(|s| all(s, c)).sum::<f64>() / count).collect();
    let spread = |c: usize| {
        let square: f64 = points.iter().map(|s| (all(s, c) - mean[c]).powi(2)).sum();
        Some((square / count).sqrt()).filter(|s| *s > 0.0).unwrap_or(1.0)
    };
    let scale: Vec<f64> = (0..m).map(spread).collect();
    let y = DMatrix::from_fn(m, points.len(), |c, k| (all(&points[k], c) - mean[c]) / scale[c]);
    let eigen = (&y * y.transpose() / count).symmetric_eigen();
    let mut order: Vec<usize> = (0..m).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let second = if m > 1 { eigen.eigenvalues[order[1]] } else { 0.0 };
    check::positive("extent of the points across their main direction", second)?;
    let along = |axis: usize| eigen.eigenvectors.column(order[axis]).transpose() * &y;
    // Division by the extents makes an ellipse a circle.
    let (a, b) = (along(0) / eigen.eigenvalues[order[0]].sqrt(), along(1) / second.sqrt());
    let angle: Vec<f64> = a.iter().zip(b.iter()).map(|(a, b)| b.atan2(*a)).collect();
    let steps: Vec<f64> = angle.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let (sin, cos) = steps.iter().map(|d| d.sin_cos()).fold((0.0, 0.0), |(s, c), d| (s + d.0, c + d.1));
    let middle = f64::atan2(sin, cos);
    let (mut sum, mut total) = (0.0, 0.0);
    for (k, step) in steps.iter().enumerate() {
        let s = (k + 1) as f64 / (steps.len() + 1) as f64;
        let weight = (-1.0 / (s * (1.0 - s))).exp();
        let unwrapped = step - TAU * ((step - middle) / TAU).round();
        sum += weight * unwrapped;
        total += weight;
    }
    Ok((sum / total).rem_euclid(TAU))
}
