//! What the algebra of the ring reads of its gears, in lists.

use crate::models::ring::params::Gear;

/// Waves of a mesh; the constants are T_M, C_1..n and T_L1..n.
pub(crate) const STRIDE: usize = 7;

/// What the algebra reads of the gears and their loads, in lists: lanes then multiply by one number at a time, and divide by none. Side by
/// side, numbers of one gear would be bundled by the compiler where it should bundle lanes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Columns(Vec<f64>);

impl Columns {
    pub(crate) fn of(gears: &[Gear]) -> Self {
        let of: [fn(&Gear) -> f64; 5] = [
            |gear| gear.base_radius,
            |gear| gear.load.shaft.stiffness,
            |gear| gear.load.shaft.damping,
            |gear| 1.0 / gear.inertia,
            |gear| 1.0 / gear.load.inertia,
        ];
        Columns(of.iter().flat_map(|of| gears.iter().map(of)).collect())
    }

    /// R_i, K_si, C_si, 1/J_i and 1/J_Li.
    #[inline(always)]
    pub(crate) fn cut(&self, n: usize) -> [&[f64]; 5] {
        let all = &self.0[..5 * n];
        [&all[..n], &all[n..2 * n], &all[2 * n..3 * n], &all[3 * n..4 * n], &all[4 * n..5 * n]]
    }
}
