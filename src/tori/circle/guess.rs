//! Guesses for invariant circles: from points of a run, and from an orbit at a Neimark-Sacker point.

use crate::error::{ParameterError, check};
use crate::model::State;
use crate::periodic::ShootingOrbit;
use crate::tori::circle::circle_error::CircleError;
use crate::tori::circle::closed_curve::{ClosedCurve, checked_nodes};
use crate::tori::least_squares::fit;
use nalgebra::DMatrix;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Largest root mean square distance of the points of a fit from the curve, as a share of their range `[1]`.
const SCATTERED: f64 = 0.1;

/// Number of inverse iterations for an eigenvector.
const INVERSE_ITERATIONS: usize = 3;

impl ClosedCurve {
    /// The curve that passes closest to points x_k at θ = θ_0 + k ρ, in the sense of least squares. The
    /// points are states of a settled run at the instants of the stroboscope, and ρ is the
    /// [rotation](crate::tori::rotation_number) from one to the next. The curve gets the time of the first
    /// point: for points of a model with two base frequencies set their times to 0, since θ_0 already
    /// contains the angle at the first.
    ///
    /// # Errors
    /// [`CircleError::Unspread`]; [`CircleError::Scattered`] if the points do not lie on one closed curve;
    /// [`CircleError::Parameter`] for nodes, points and angles that are not valid.
    pub fn fit(points: &[State], rotation: f64, first: f64, nodes: usize) -> Result<Self, CircleError> {
        checked_nodes(nodes)?;
        check::count("coefficients of the normal equations", &[nodes, nodes], check::NUMBERS)?;
        check::quantity("rotation", rotation)?;
        check::quantity("first angle", first)?;
        let Some(start) = points.first() else {
            return Err(ParameterError::Empty { name: "points".into(), min: nodes }.into());
        };
        let n = start.q.len();
        check::at_least("coordinates", n, 1)?;
        points.iter().try_for_each(|point| point.check(n))?;
        // 1, then cos kθ and sin kθ.
        let basis = |theta: f64, at: usize| {
            let angle = at.div_ceil(2) as f64 * theta;
            if at.is_multiple_of(2) && at > 0 { angle.sin() } else { angle.cos() }
        };
        let coefficients = fit(points.len(), [nodes, 2 * n], |k, row, y| {
            let theta = first + (k as f64 * rotation).rem_euclid(TAU);
            row.iter_mut().enumerate().for_each(|(at, x)| *x = basis(theta, at));
            y[..n].copy_from_slice(&points[k].q);
            y[n..].copy_from_slice(&points[k].v);
        });
        let Some(coefficients) = coefficients else {
            return Err(CircleError::Unspread { points: points.len(), rotation, nodes });
        };
        let distance = (0..2 * n).fold(0.0f64, |most, c| {
            let of = |point: &State| if c < n { point.q[c] } else { point.v[c - n] };
            let apart = |k: usize| {
                let theta = first + (k as f64 * rotation).rem_euclid(TAU);
                (0..nodes).map(|at| basis(theta, at) * coefficients[(at, c)]).sum::<f64>() - of(&points[k])
            };
            let squares: f64 = (0..points.len()).map(|k| apart(k).powi(2)).sum();
            let (low, high) =
                points.iter().map(of).fold((f64::MAX, f64::MIN), |(l, h), y| (l.min(y), h.max(y)));
            if high > low { most.max((squares / points.len() as f64).sqrt() / (high - low)) } else { most }
        });
        if distance > SCATTERED {
            return Err(CircleError::Scattered { distance, allowed: SCATTERED });
        }
        let values = (0..nodes).flat_map(|j| {
            let row: Vec<f64> = (0..nodes).map(|at| basis(TAU * j as f64 / nodes as f64, at)).collect();
            (0..2 * n)
                .map(|c| row.iter().enumerate().map(|(i, x)| x * coefficients[(i, c)]).sum())
                .collect::<Vec<f64>>()
        });
        Ok(ClosedCurve::of(start.t, 2 * n, values.collect()))
    }

    /// x(θ) = x* + ε Re(w e^{iθ}), and ρ = arg μ: the circle about an orbit near a Neimark-Sacker point, to
    /// first order.
    ///
    /// x* is the first state of the orbit, μ the multiplier with Im μ > 0 whose modulus is closest to 1, w
    /// its eigenvector. ε is the amplitude as a share of the range of the orbit, for the component with the
    /// largest share `[1]`.
    ///
    /// The map of [`CircleShooting::solve_free`](crate::tori::CircleShooting::solve_free) has the period of
    /// the drives: the orbit must have that period, too.
    ///
    /// # Errors
    /// [`CircleError::NoPair`], and [`CircleError::Parameter`] for an amplitude or nodes that are not valid.
    pub fn about(orbit: &ShootingOrbit, amplitude: f64, nodes: usize) -> Result<(Self, f64), CircleError> {
        checked_nodes(nodes)?;
        check::positive("amplitude", amplitude)?;
        let multipliers = orbit.multipliers();
        let pair = multipliers.values().iter().filter(|mu| mu.im > 1e-12 * mu.norm());
        let nearest = pair.min_by(|a, b| (a.norm() - 1.0).abs().total_cmp(&(b.norm() - 1.0).abs()));
        let no_pair = CircleError::NoPair { largest: multipliers.largest() };
        let Some(&mu) = nearest else { return Err(no_pair) };
        let (start, range) = (&orbit.states()[0], orbit.range());
        let m = range.len();
        // In units of the ranges, with a shift just off the eigenvalue.
        let shift = mu * (1.0 + 1e-9);
        let matrix = DMatrix::from_fn(m, m, |i, j| {
            let entry = Complex64::new(orbit.monodromy()[(i, j)] * range[j] / range[i], 0.0);
            if i == j { entry - shift } else { entry }
        });
        let factors = matrix.lu();
        let mut w = DMatrix::from_fn(m, 1, |i, _| Complex64::new(1.0, 0.1 * i as f64));
        for _ in 0..INVERSE_ITERATIONS {
            let Some(next) = factors.solve(&w) else { return Err(no_pair) };
            let largest = next.iter().fold(0.0f64, |m, z| m.max(z.norm()));
            w = next / Complex64::new(largest, 0.0);
        }
        let centre: Vec<f64> = start.q.iter().chain(&start.v).copied().collect();
        let values = (0..nodes).flat_map(|j| {
            let turn = Complex64::cis(TAU * j as f64 / nodes as f64);
            let at = |c: usize| centre[c] + amplitude * range[c] * (w[(c, 0)] * turn).re;
            (0..m).map(at).collect::<Vec<f64>>()
        });
        Ok((ClosedCurve::of(start.t, m, values.collect()), mu.arg()))
    }
}
