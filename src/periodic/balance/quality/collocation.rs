//! Gauss collocation.

use crate::numeric::gauss::SIX_ON_UNIT;
use crate::numeric::lagrange::lagrange;
use std::sync::LazyLock;

/// Number of stages.
pub(crate) const STAGES: usize = 6;

/// Coefficients of the collocation at the nodes of Gauss, of order 12.   Source: Hairer, Nørsett & Wanner I,
/// Sect. II.7.
pub(crate) struct Collocation {
    /// Nodes c_i on [0, 1].
    pub(crate) nodes: [f64; STAGES],
    /// Weights b_i.
    pub(crate) weights: [f64; STAGES],
    /// a_ij = ∫_0^{c_i} L_j(x) dx, with L_j the j-th Lagrange polynomial of the nodes.
    pub(crate) a: [[f64; STAGES]; STAGES],
    /// a²: Σ_k a_ik a_kj.
    pub(crate) square: [[f64; STAGES]; STAGES],
    /// bᵀa: Σ_i b_i a_ij.
    pub(crate) twice: [f64; STAGES],
}

impl Collocation {
    /// The shared instance.
    pub(crate) fn get() -> &'static Self {
        static COLLOCATION: LazyLock<Collocation> = LazyLock::new(Collocation::new);
        &COLLOCATION
    }

    fn new() -> Self {
        let (nodes, weights) = (SIX_ON_UNIT.map(|[c, _]| c), SIX_ON_UNIT.map(|[_, b]| b));
        let basis = lagrange(nodes);
        let integral = |x: f64, p: &[f64; STAGES]| {
            x * p.iter().enumerate().rev().fold(0.0, |sum, (m, c)| sum * x + c / (m + 1) as f64)
        };
        let a = nodes.map(|c| std::array::from_fn(|j| integral(c, &basis[j])));
        let times_a = |row: [f64; STAGES]| -> [f64; STAGES] {
            std::array::from_fn(|j| (0..STAGES).map(|k| row[k] * a[k][j]).sum())
        };
        Collocation { nodes, weights, a, square: a.map(times_a), twice: times_a(weights) }
    }
}
