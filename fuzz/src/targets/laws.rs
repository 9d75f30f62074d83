//! Contact laws, laws of phase, held processes.

use super::excitations::excitation;
use crate::case::{Case, Run, Stop, all_finite, finite, holds};
use gear_dynamics::*;

/// Any built-in law, its half width about a size.
pub fn law(case: &mut Case, size: f64) -> Result<AnyLaw, Stop> {
    Ok(match case.below(6) {
        0 => AnyLaw::Linear(Linear),
        1 => AnyLaw::Cubic(Cubic::new(case.number(1.0), case.number(1.0 / (size * size)))?),
        2 => AnyLaw::Backlash(Backlash::new(case.number(size))?),
        3 => {
            let one = AsymmetricBacklash::new(-case.number(size), case.number(size))?;
            AnyLaw::Asymmetric(one.with_slopes(case.number(1.0), case.number(1.0))?)
        }
        4 => AnyLaw::Varying(VaryingBacklash::new(excitation(case, 1, size, 1.0)?)),
        _ => AnyLaw::Smoothed(SmoothedBacklash::new(case.number(size), case.number(0.1 * size))?),
    })
}

/// Forces and slopes at deflections within a million sizes.
pub fn any(case: &mut Case) -> Run {
    let size = case.number(1e-4);
    let law = law(case, size)?;
    if let Ok(stop) = Restitution::new(case.number(0.5)) {
        finite("rebound", stop.rebound(case.signed(), case.signed()))?;
    }
    case.note(|| format!("{law:?}"));
    for _ in 0..10 {
        let t = case.signed();
        let edges = law.edges(t, Side::After);
        // A half width that varies may be told below zero: `check_model` names it.
        let told = matches!(law, AnyLaw::Varying(_));
        let crossed = edges.lower > edges.upper;
        holds(told || !crossed, || format!("edges {edges:?}"))?;
        for value in [edges.lower, edges.upper] {
            holds(!value.is_nan(), || format!("edges {edges:?}"))?;
        }
        all_finite("rates of edges", &[edges.lower_rate, edges.upper_rate])?;
        let size = if edges.upper.is_finite() { edges.upper.abs().max(1e-4) } else { 1e-4 };
        let x = case.pick(&[0.0, size, -size, 1e6 * size, 1e-3 * size]) * case.pick(&[1.0, -1.0, 0.3]);
        finite(format_args!("force at {x:e}"), law.force(x, case.signed(), edges.lower, edges.upper))?;
        finite(format_args!("force at rest at {x:e}"), law.at(x))?;
        finite(format_args!("slope at {x:e}"), law.slope(x))?;
        for piece in [Piece::Lower, Piece::Gap, Piece::Upper] {
            finite(format_args!("force on {piece:?} at {x:e}"), law.force_on(piece, x, 0.0, edges.lower, edges.upper))?;
        }
        let edge = law.next_edge(t);
        holds(edge.is_none_or(|edge| edge > t), || format!("next_edge({t:e}) is {edge:?}"))?;
    }
    Ok(())
}

/// Any law of phase about a speed.
pub fn phase_law(case: &mut Case, speed: f64, time: f64) -> Result<PhaseLaw, Stop> {
    Ok(match case.below(4) {
        0 => PhaseLaw::constant(case.number(speed))?,
        1 => PhaseLaw::ramp(case.number(speed), case.number(speed), case.number(time))?,
        2 => PhaseLaw::fluctuation(case.number(speed), case.number(0.3), case.number(speed))?,
        _ => {
            let speeds: Vec<f64> =
                case.list(5, speed).into_iter().map(|speed| if case.chance(0.1) { speed } else { speed.abs() }).collect();
            let mut times = vec![0.0];
            while times.len() < speeds.len() {
                times.push(times[times.len() - 1] + case.number(0.2 * time));
            }
            PhaseLaw::table(&times, &speeds)?
        }
    })
}

/// A phase rises, and the time of a phase is when it is reached.
pub fn phases(case: &mut Case) -> Run {
    let (speed, time) = (case.number(10.0), case.number(4.0));
    let law = phase_law(case, speed, time)?;
    case.note(|| format!("{law:?}"));
    for _ in 0..10 {
        let t = case.number(2.0) * case.signed();
        if !t.is_finite() || t.abs() > 1e6 {
            continue;
        }
        let (phase, speed) = (law.phase(t), law.speed(t));
        finite(format_args!("phase at {t:e}"), phase)?;
        finite(format_args!("speed at {t:e}"), speed)?;
        holds(speed > 0.0, || format!("speed({t:e}) is {speed:e}"))?;
        let back = law.time(phase);
        finite(format_args!("time of phase {phase:e}"), back)?;
        let again = law.phase(back);
        holds((again - phase).abs() <= 1e-6 * phase.abs().max(1e-6), || {
            format!("phase {phase:e} at {t:e}: time {back:e}, phase {again:e}")
        })?;
    }
    Ok(())
}

/// Any held process.
pub fn process(case: &mut Case, hold: f64, size: f64) -> Result<HeldProcess, Stop> {
    let hold = case.number(hold);
    let process = if case.chance(0.5) {
        let values = case.list(5, size);
        HeldProcess::from_values(hold, &values)?
    } else if case.chance(0.5) {
        HeldProcess::new(hold, rand_distr::Normal::new(0.0, case.quantity(size))?)?
    } else {
        let (a, b) = (case.quantity(size), case.quantity(2.0 * size));
        HeldProcess::new(hold, rand_distr::Uniform::new(a, b)?)?
    };
    Ok(process.with_seed(case.seed()).with_member(case.seed()))
}

/// Values of held processes at any time and number.
pub fn held(case: &mut Case) -> Run {
    let process = process(case, 0.1, 1.0)?;
    case.note(|| format!("{process:?}"));
    finite("hold", process.hold())?;
    for _ in 0..10 {
        let (t, stream, k) = (case.number(1.0) * case.signed(), case.seed(), case.seed());
        finite(format_args!("held value {k}"), process.held(stream, k))?;
        if t.is_finite() {
            finite(format_args!("value at {t:e}"), process.value(t, Side::Before, stream))?;
            finite(format_args!("value at {t:e}"), process.value(t, Side::After, stream))?;
        }
    }
    Ok(())
}
