//! Any of the models of the targets.

use crate::case::{Case, Stop};
use crate::models::{self, Erased, Slip, User};
use crate::targets::shapes;
use gear_dynamics::models::nfg::NfgPair2;
use gear_dynamics::{Model, NfgPair, Periodic, State};
use std::f64::consts::TAU;

/// Any model, and a start: its static start, rest, or any state.
pub fn any(case: &mut Case) -> Result<(Erased, State), Stop> {
    let (model, start) = match case.below(9) {
        0 | 1 => {
            let user = User::any(case);
            let period = match user.slip {
                Slip::Period(period) => period,
                _ => TAU / user.omega,
            };
            let (start, sound) = (State::at_rest(user.dof), user.slip != Slip::Deflection);
            (Erased { sound, ..Erased::new(user, period) }, start)
        }
        2 | 3 => {
            let (params, reading) = (models::pair_params(case), models::reading(case));
            let pair = NfgPair::of_reading(&params, reading)?;
            let (start, period) = (pair.on_drive_flank()?, pair.period());
            (Erased::new(pair, period), start)
        }
        4 => {
            let (params, reading) = (models::pair_params(case), models::reading(case));
            let pair =
                NfgPair2::of_reading(&params, case.number(0.01), reading)?.with_torque(case.number(10.0))?;
            let (start, period) = (pair.on_drive_flank()?, pair.period());
            (Erased::new(pair, period), start)
        }
        5 => {
            let pair = models::own_pair(case)?;
            let (start, period) = (pair.on_drive_flank()?, pair.period());
            (Erased::new(pair, period), start)
        }
        6 => {
            let pair = models::own_pair2(case)?;
            let (start, period) = (pair.on_drive_flank()?, pair.period());
            (Erased::new(pair, period), start)
        }
        7 => {
            let own = shapes::machine(case)?;
            let (start, period, sound) = (State::at_rest(own.dof()), own.period(), own.shape().is_sound());
            (Erased { sound, ..Erased::new(own, period) }, start)
        }
        _ => {
            let ring = models::ring(case)?;
            let (start, period) = (State::at_rest(ring.dof()), ring.period());
            (Erased::new(ring, period), start)
        }
    };
    let start = models::state(case, start);
    case.note(|| format!("period {:e}, start {start:?}", model.period));
    Ok((model, start))
}
