//! A root finder of one's own.

use gear_dynamics::nalgebra::{DMatrix, DVector};
use gear_dynamics::roots::{Residual, Root, RootError, RootFinder};

/// The method of Levenberg and Marquardt: (JᵀJ + λ diag JᵀJ) Δx = -Jᵀ r, λ ten times smaller after each step that reduces
/// |r| and ten times larger after each one that does not.
///
/// Source: Marquardt, J. Soc. Indust. Appl. Math. 11 (1963) 431.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marquardt {
    /// Largest last correction, as a share of the largest unknown.
    pub tolerance: f64,
}

impl RootFinder for Marquardt {
    fn solve(&self, equations: &mut dyn Residual, guess: &[f64]) -> Result<Root, RootError> {
        let n = equations.size();
        let (mut r, mut trial) = (vec![0.0; n], vec![0.0; n]);
        let mut root = Root::start(equations, guess, &mut r)?;
        let (mut matrix, mut weight) = (equations.matrix(), 1e-3);
        while root.iterations < 200 {
            equations.jacobian(&root.x, &mut matrix);
            let mut jacobian = DMatrix::zeros(n, n);
            matrix.each(|row, column, slope| jacobian[(row, column)] = slope);
            let (normal, down) =
                (jacobian.tr_mul(&jacobian), -jacobian.tr_mul(&DVector::from_column_slice(&r)));
            let largest = |x: &[f64]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            loop {
                let mut damped = normal.clone();
                (0..n).for_each(|i| damped[(i, i)] *= 1.0 + weight);
                let step = damped.lu().solve(&down);
                let Some(step) = step.filter(|_| weight < 1e12) else {
                    return Err(RootError::NotConverged { last: Box::new(root) });
                };
                let x: Vec<f64> = root.x.iter().zip(step.iter()).map(|(x, s)| x + s).collect();
                equations.residual(&x, &mut trial);
                let size = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
                let near = largest(step.as_slice()) <= self.tolerance * largest(&x);
                if near || size(&trial) < size(&r) {
                    root.step_to(equations, &x, &mut r);
                    weight *= 0.1;
                    if near {
                        return Ok(root);
                    }
                    break;
                }
                weight *= 10.0;
            }
        }
        Err(RootError::NotConverged { last: Box::new(root) })
    }
}
