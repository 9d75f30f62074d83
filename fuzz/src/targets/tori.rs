//! Tori: balance in several angles, invariant circles.

use crate::any;
use crate::case::{Case, Run, Stop, all_finite, holds};
use crate::models;
use gear_dynamics::contact::Piece;
use gear_dynamics::excitation::Fourier;
use gear_dynamics::tori::{
    CircleShooting, ClosedCurve, InvariantCircle, Torus, TorusBalance, WaveVectors, WithShafts,
    rotation_number,
};
use gear_dynamics::{Budget, Model, Periodic, State, Wave};
use std::f64::consts::TAU;

/// The budget of circles, in steps, and that of balances, in evaluations: they keep cases short.
fn budget(steps: u64) -> Budget {
    Budget::new().steps(steps)
}

/// A model with a wave of another shaft, and a state.
fn model(case: &mut Case) -> Result<(WithShafts<models::Erased>, State), Stop> {
    let (model, start) = any::any(case)?;
    let base = if model.period() > 0.0 && model.period().is_finite() { TAU / model.period() } else { 1.0 };
    let wave = Wave::new(Fourier::new(case.number(0.0), &case.pairs(3, 0.1))?);
    let (slot, omega) = (case.below(model.drives() + 1), case.number(0.618 * base));
    Ok((WithShafts::new(model).add(slot, omega, wave)?, start))
}

fn measures(torus: &Torus) -> Run {
    for j in 0..torus.dof() {
        all_finite("mean and rms", &[torus.mean(j), torus.rms(j)])?;
        all_finite("extremes", &torus.extremes(j, 7)?)?;
    }
    all_finite("q on a torus", &torus.at(0.7).q)?;
    let _ = (torus.outermost_share(), torus.smallest_rate(), torus.aliasing(), torus.residual_between());
    Ok(())
}

/// Balance from a constant, from a flank, and from a fit.
pub fn torus(case: &mut Case) -> Run {
    let (model, start) = model(case)?;
    let highest: Vec<usize> = if case.hostile() {
        (0..case.below(4)).map(|_| case.effort(3)).collect()
    } else {
        vec![1 + case.below(4), 1 + case.below(3)]
    };
    let vectors =
        if case.chance(0.5) { WaveVectors::within(&highest)? } else { WaveVectors::in_box(&highest)? };
    let mut balance = TorusBalance::new(vectors.clone()).budget(budget(40));
    if case.chance(0.5) {
        balance = balance.oversampling(case.count(2)).separation(case.number(1e-6));
    }
    case.note(|| format!("{balance:?} from {start:?}"));
    let guess = match case.below(3) {
        0 => balance.linearised(&model, case.pick(&[Piece::Lower, Piece::Gap, Piece::Upper])),
        1 => {
            let states: Vec<State> = (0..case.below(120))
                .map(|k| State { t: start.t + k as f64 * case.number(1.3), ..start.clone() })
                .collect();
            Torus::fit(&vectors, &gear_dynamics::tori::QuasiPeriodic::frequencies(&model), &states)
        }
        _ => balance.at_rest(&model, &start.q).and_then(|guess| balance.solve(&model, &guess)),
    };
    let found = match guess {
        Ok(guess) => {
            measures(&guess)?;
            balance.solve(&model, &guess)
        }
        failed => failed,
    };
    match found {
        Ok(torus) => measures(&torus),
        Err(error) => {
            if let Some(last) = error.last() {
                all_finite("q of the last iterate", &last.at(0.0).q)?;
            }
            Err(error.into())
        }
    }
}

fn read(circle: &InvariantCircle) -> Run {
    all_finite("q on a circle", &circle.at(0.3).q)?;
    all_finite("rotation", &[circle.rotation()])?;
    holds(circle.curve().nodes() % 2 == 1, || "an even number of nodes".into())?;
    let _ = circle.curve().highest_share();
    Ok(())
}

/// Circles of known and unknown rotation from any curve.
pub fn circle(case: &mut Case) -> Run {
    let (model, start) = model(case)?;
    let count = if case.hostile() { case.below(12) } else { 3 + 2 * case.below(3) };
    let points: Vec<State> = (0..count).map(|_| models::state(case, start.clone())).collect();
    let rotation = case.number(1.0);
    let guess = if case.chance(0.3) {
        let nodes = case.count(3);
        ClosedCurve::fit(&points, rotation, case.number(0.0), nodes)?
    } else {
        ClosedCurve::new(&points)?
    };
    if case.chance(0.2) {
        let _ = rotation_number(&points);
    }
    let mut shooting = CircleShooting::new().budget(budget(2_000)).between(case.number(1.0));
    if case.chance(0.3) {
        shooting = shooting.nodes(case.count(5)).strobed_frequency(case.below(3));
    }
    if case.chance(0.3) {
        shooting = shooting.flow_tolerance(case.number(1e-9));
    }
    case.note(|| format!("{shooting:?} from {guess:?}"));
    let found = if case.chance(0.5) {
        shooting.solve(&model, &guess)
    } else {
        shooting.solve_free(model.bare(), &guess, rotation)
    };
    match found {
        Ok(circle) => read(&circle),
        Err(error) => {
            error.last().map_or(Ok(()), read)?;
            Err(error.into())
        }
    }
}
