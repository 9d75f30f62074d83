//! Resonances without damping, as the reason why a balance has no root.

use crate::numeric::norms::largest;
use crate::numeric::spread::golden;
use crate::ode::budget::Meter;
use crate::periodic::balance::equations::balance_equations::BalanceEquations;
use crate::roots::Residual;
use crate::roots::factors::Factors;

/// Where a resonance without damping lies.
pub(crate) struct Resonance {
    /// The coordinate that it moves most, in units of its scale.
    pub(crate) coordinate: usize,
    pub(crate) order: usize,
}

/// Largest change of the equations along a motion without resistance, as a share of its inertia forces `[1]`:
/// above the errors of Jacobians by differences.
const RESISTED: f64 = 1e-7;

/// Shift of the diagonal, as a share of the inertia forces `[1]`: the factors of a singular matrix exist.
const SHIFT: f64 = 1e-12;

/// Maximum number of entries of the blocks of all orders.
const ENTRIES: usize = 1 << 24;

impl BalanceEquations<'_> {
    /// The order of a resonance without damping. At this order a motion v exists whose elastic forces balance
    /// its inertia forces, so that it changes no equation: R(x + s v) = R(x) for a large s. Of several orders
    /// the one with the largest residual is returned. `None`: there is none, or `meter` is exhausted.
    ///
    /// v follows by inverse iteration from the block of the order in the Jacobian at x. The comparison of
    /// the residuals excludes motions that only the derivative at x does not resist.
    pub(crate) fn resonance(&mut self, x: &[f64], meter: &Meter<'_>) -> Option<Resonance> {
        let (n, omega) = (self.work.layout.dof, self.work.layout.omega);
        let harmonics = self.work.layout.harmonics.clone();
        let (orders, width, m) = (harmonics.orders(), harmonics.unknowns(), 2 * n);
        if orders.len().saturating_mul(m * m) > ENTRIES || meter.check().is_err() {
            return None;
        }
        let (mut matrix, mut r) = (self.matrix(), vec![0.0; self.size()]);
        self.jacobian(x, &mut matrix);
        self.residual(x, &mut r);
        if matrix.not_finite().is_some() || r.iter().any(|r| !r.is_finite()) {
            return None;
        }
        let of_order = (0..orders.len()).filter(|&index| orders[index] > 0);
        let mut places = vec![None; width];
        for index in of_order.clone() {
            (0..2).for_each(|parity| places[harmonics.place(index) + parity] = Some((index, parity)));
        }
        let place = |unknown: usize| {
            let (index, parity) = places[unknown % width].filter(|_| unknown < n * width)?;
            Some((index, 2 * (unknown / width) + parity))
        };
        let mut blocks = vec![vec![0.0; m * m]; orders.len()];
        matrix.each(|row, column, value| match (place(row), place(column)) {
            (Some((order, i)), Some((other, j))) if order == other => blocks[order][j * m + i] += value,
            _ => {}
        });
        let unknown = |index: usize, i: usize| i / 2 * width + harmonics.place(index) + i % 2;
        let share = |index: usize| (0..m).fold(0.0, |most: f64, i| most.max(r[unknown(index, i)].abs()));
        let mut by_share: Vec<usize> = of_order.collect();
        by_share.sort_by(|&a, &b| share(b).total_cmp(&share(a)));
        let (size, mut moved) = (largest(x).max(1.0), r.clone());
        for index in by_share {
            let inertia = (orders[index] as f64 * omega).powi(2);
            let Some(v) = unresisted(&mut blocks[index], m, inertia) else {
                continue;
            };
            if meter.check().is_err() {
                return None;
            }
            let mut at = x.to_vec();
            v.iter().enumerate().for_each(|(i, v)| at[unknown(index, i)] += size * v);
            self.residual(&at, &mut moved);
            moved.iter_mut().zip(&r).for_each(|(moved, r)| *moved -= r);
            if largest(&moved) <= RESISTED * inertia * size {
                let most = (0..m).max_by(|&i, &j| v[i].abs().total_cmp(&v[j].abs()))?;
                return Some(Resonance { coordinate: most / 2, order: orders[index] });
            }
        }
        None
    }
}

/// The motion, of largest component 1, whose product with a block of m rows is 0 beside its `inertia` forces.
fn unresisted(block: &mut [f64], m: usize, inertia: f64) -> Option<Vec<f64>> {
    (0..m).for_each(|i| block[i * (m + 1)] -= SHIFT * inertia);
    let factors = Factors::lu(block, m);
    let mut v: Vec<f64> = (0..m).map(|i| golden((i + 1) as f64) - 0.5).collect();
    let mut growth = 0.0;
    for _ in 0..2 {
        factors.solve(&mut v);
        growth = largest(&v);
        v.iter_mut().for_each(|v| *v /= growth);
    }
    let found = growth * inertia * RESISTED >= 1.0 && v.iter().all(|v| v.is_finite());
    found.then_some(v)
}
