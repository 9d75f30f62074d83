//! Whether the stated period is that of a model.

use crate::error::ParameterError;
use crate::excitation::Side;
use crate::model::{Periodic, State};
use crate::numeric::spread::golden;

/// Number of instants at which the accelerations are compared with those one period later.
const COMPARED: usize = 8;

/// Difference of accelerations one period later, as a share of the largest one `[1]`. Rounding of a time
/// beside a jump may exceed it at some times; at half of them the period is not that of the model.
const DIFFERENT: f64 = 1e-3;

/// Refuses the period of a model if its accelerations in a state differ one period later.
pub(crate) fn check_period(model: &dyn Periodic, state: &State) -> Result<(), ParameterError> {
    let period = model.period();
    let at = |t: f64| {
        let (mut u, mut a) = (vec![0.0; model.drives()], vec![0.0; model.dof()]);
        model.drive(t, Side::After, &mut u);
        model.accel(&u, &state.q, &state.v, &mut a);
        a
    };
    let times = (1..=COMPARED).map(|k| state.t + period * golden(k as f64));
    let pairs: Vec<[Vec<f64>; 2]> = times.map(|t| [at(t), at(t + period)]).collect();
    // Accelerations that are 0 by the symmetry of a model consist of rounding.
    let largest = pairs.iter().flatten().flatten().fold(0.0, |m: f64, a| m.max(a.abs()));
    let differs =
        |[a, b]: &[Vec<f64>; 2]| a.iter().zip(b).map(|(a, b)| (a - b).abs() / largest).fold(0.0, f64::max);
    let mut off: Vec<f64> = pairs.iter().map(differs).collect();
    off.sort_by(f64::total_cmp);
    let value = off[COMPARED / 2];
    if value.is_nan() || value <= DIFFERENT {
        return Ok(());
    }
    let must = format!(
        "be the period of the accelerations, which differ one period later by {value:.1e} of the largest one"
    );
    Err(ParameterError::Wrong { name: "period of the model".into(), value: period, must })
}
