//! Newton and Broyden on equations with, near and without roots; block matrices.

use crate::case::{Case, Run, all_finite, finite, holds};
use gear_dynamics::roots::{Broyden, Equations, FirstJacobian, Matrix, Newton, RootFinder};

/// Newton's method with any setting.
pub fn newton(case: &mut Case, tolerance: f64) -> Newton {
    Newton::new().max_iterations(case.effort(20)).tolerance(tolerance)
}

/// Broyden's method with any setting.
pub fn broyden(case: &mut Case, tolerance: f64) -> Broyden {
    let mut broyden = Broyden::new().max_iterations(case.effort(30)).tolerance(tolerance);
    if case.chance(0.2) {
        broyden = broyden.bad();
    }
    if case.chance(0.3) {
        broyden = broyden.restart(case.count(5));
    }
    match case.below(3) {
        0 => broyden.first(FirstJacobian::Own),
        1 => {
            broyden.first(FirstJacobian::Given(Matrix::dense(if case.hostile() { case.below(4) } else { 1 })))
        }
        _ => broyden,
    }
}

/// A root that is found has a small residual; an error contains the last iterate.
pub fn solve(case: &mut Case) -> Run {
    let kind = case.below(5);
    let (a, b) = (case.number(1.0), case.number(2.0));
    let n = if case.hostile() { case.below(4) } else { 1 + case.below(3) };
    let residual = move |x: &[f64], r: &mut [f64]| {
        for i in 0..x.len() {
            let next = x[(i + 1) % x.len()];
            r[i] = match kind {
                0 => a * x[i] + b + 0.1 * next,
                1 => a * x[i] * x[i] - b,
                2 => (a * x[i]).exp() - b * x[i],
                3 => (a * x[i]).sqrt() - b,
                _ => x[i].abs() - a * next.max(0.0) - b,
            };
        }
    };
    let guess = case.list(n, 1.0);
    case.note(|| format!("kind {kind}, a {a:e}, b {b:e}, {n} unknowns, guess {guess:?}"));
    let mut equations = Equations::new(n, residual);
    let tolerance = case.number(1e-9);
    let solved = if case.chance(0.5) {
        let newton = newton(case, tolerance);
        case.note(|| format!("{newton:?}"));
        newton.solve(&mut equations, &guess)
    } else {
        let broyden = broyden(case, tolerance);
        case.note(|| format!("{broyden:?}"));
        broyden.solve(&mut equations, &guess)
    };
    match solved {
        Ok(root) => {
            all_finite("root", &root.x)?;
            finite("residual", root.residual)?;
            let mut r = vec![0.0; n];
            residual(&root.x, &mut r);
            let largest = r.iter().fold(0.0, |m: f64, r| m.max(r.abs()));
            holds((largest - root.residual).abs() <= 1e-9 * (1.0 + largest.abs()), || {
                format!("residual {largest:e}, reported {:e}", root.residual)
            })?;
            // The tolerance is a share of the largest unknown of guess and root.
            let scale = a.abs() + b.abs() + guess.iter().chain(&root.x).fold(0.0, |m: f64, x| m.max(x.abs()));
            let sensible = scale < 1e3 && n > 0 && tolerance < 1e-3;
            holds(!sensible || largest < 0.1 * scale.max(1e-3), || {
                format!("a root of residual {largest:e}: {:?}", root.x)
            })
        }
        Err(error) => {
            if let Some(last) = error.last() {
                holds(last.x.len() == n, || format!("{} unknowns of {n}", last.x.len()))?;
            }
            Err(error.into())
        }
    }
}

/// Matrices of blocks of any height and pattern.
pub fn matrices(case: &mut Case) -> Run {
    let heights: Vec<usize> = (0..case.below(5)).map(|_| case.count(3)).collect();
    let pattern: Vec<(usize, usize)> = (0..case.below(10)).map(|_| (case.count(2), case.count(2))).collect();
    case.note(|| format!("heights {heights:?}, pattern {pattern:?}"));
    let mut matrix = Matrix::blocks(&heights, &pattern)?;
    holds(
        heights.iter().try_fold(0usize, |sum, height| sum.checked_add(*height)) == Some(matrix.size()),
        || format!("heights {heights:?} make a size of {}", matrix.size()),
    )?;
    for &(i, j) in pattern.iter().take(3) {
        for x in matrix.block_mut(i, j).iter_mut().take(100) {
            *x = 1.0;
        }
    }
    if matrix.size() < 1000 {
        all_finite("product", &matrix.times(&vec![1.0; matrix.size()]))?;
    }
    Ok(())
}
