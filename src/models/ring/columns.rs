//! The gears of a ring, list by list.

use super::params::Gear;

/// What the algebra reads of the gears, in lists: lanes then multiply by one number at a time, and divide by none.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    /// R_i.
    pub(super) radius: Vec<f64>,
    /// K_si and C_si.
    pub(super) stiffness: Vec<f64>,
    pub(super) damping: Vec<f64>,
    /// 1/J_i and 1/J_Li.
    pub(super) per_gear: Vec<f64>,
    pub(super) per_load: Vec<f64>,
}

impl Columns {
    pub(super) fn of(gears: &[Gear]) -> Self {
        let column = |of: fn(&Gear) -> f64| gears.iter().map(of).collect();
        Columns {
            radius: column(|gear| gear.base_radius),
            stiffness: column(|gear| gear.load.shaft.stiffness),
            damping: column(|gear| gear.load.shaft.damping),
            per_gear: column(|gear| 1.0 / gear.inertia),
            per_load: column(|gear| 1.0 / gear.load.inertia),
        }
    }
}
