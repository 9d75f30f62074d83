//! Parameters of the gears as the algebra of the ring reads them: one list per parameter.

use crate::models::ring::ring_params::Gear;

/// Number of waves of a mesh. The constants after the speed are T_M, C_1..n and T_L1..n.
pub(crate) const STRIDE: usize = 7;

/// R_i, K_si, C_si, 1/J_i and 1/J_Li of a gear and its load.
pub(crate) type Parameters = [f64; 5];

/// Parameters of the gears and their loads, gear by gear and as one list per parameter.
///
/// Plain numbers read them gear by gear. With lists, lanes multiply by one number at a time and never divide:
/// if the numbers of one gear stood next to each other, the compiler would vectorise over them instead of
/// over the lanes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Columns {
    gears: Vec<Parameters>,
    lists: Vec<f64>,
}

impl Columns {
    pub(crate) fn of(gears: &[Gear]) -> Self {
        let of: [fn(&Gear) -> f64; 5] = [
            |gear| gear.base_radius,
            |gear| gear.load.shaft.stiffness,
            |gear| gear.load.shaft.damping,
            |gear| 1.0 / gear.inertia,
            |gear| 1.0 / gear.load.inertia,
        ];
        Columns {
            gears: gears.iter().map(|gear| of.map(|of| of(gear))).collect(),
            lists: of.iter().flat_map(|of| gears.iter().map(of)).collect(),
        }
    }

    /// The parameters of n gears.
    #[inline(always)]
    pub(crate) fn cut(&self, n: usize) -> (&[Parameters], [&[f64]; 5]) {
        let all = &self.lists[..5 * n];
        let lists = [&all[..n], &all[n..2 * n], &all[2 * n..3 * n], &all[3 * n..4 * n], &all[4 * n..5 * n]];
        (&self.gears[..n], lists)
    }
}
