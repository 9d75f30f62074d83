//! Coordinates without any connection that a mean acceleration moves.

use crate::model::structure::drifts::unconnected;
use crate::periodic::balance::equations::balance_equations::BalanceEquations;
use crate::periodic::balance::fourier_orbit::FourierOrbit;

/// Largest mean acceleration that is an error of the root, as a share of the largest acceleration of the
/// coordinate `[1]`.
const MEAN: f64 = 1e-8;

impl BalanceEquations<'_> {
    /// The coordinate with the largest mean acceleration among those without any connection, and its gain of
    /// velocity in one period of the orbit, if it is no error of the root.
    pub(crate) fn accelerating(&mut self, orbit: &FourierOrbit) -> Option<(usize, f64)> {
        let layout = &self.work.layout;
        let alone = unconnected(&layout.drifts[..layout.rigid]);
        if alone.is_empty() {
            return None;
        }
        let x = self.unknowns(orbit);
        self.evaluate(&x, false);
        let (grid, n) = (&self.grid, self.work.layout.dof);
        let (mut q, mut v, mut a) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let mut largest = vec![0.0f64; n];
        for s in 0..grid.samples() {
            grid.state(s, &mut q, &mut v);
            grid.model.accel(grid.drives(s), &q, &v, &mut a);
            largest.iter_mut().zip(&a).for_each(|(largest, a)| *largest = largest.max(a.abs()));
        }
        let mean = |i: usize| orbit.mean_acceleration()[i];
        let most = alone
            .into_iter()
            .filter(|&i| mean(i).abs() > MEAN * largest[i])
            .max_by(|&i, &j| mean(i).abs().total_cmp(&mean(j).abs()))?;
        Some((most, mean(most) * orbit.period()))
    }
}
