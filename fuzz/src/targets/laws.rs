//! Contact laws, speed laws, held processes.

use super::excitations::wave;
use crate::case::{Case, Run, Stop, all_finite, finite, holds};
use gear_dynamics::Backlash;
use gear_dynamics::contact::{
    AsymmetricBacklash, Cubic, Damped, Linear, MixedLaw, NoPullBacklash, Nonlinearity, Piece, PowerLaw,
    Restitution, SmoothedBacklash, VaryingBacklash,
};
use gear_dynamics::drives::SpeedLaw;
use gear_dynamics::excitation::Side;
use gear_dynamics::processes::{HeldProcess, Process};

/// Any law behind one type.
pub type Any = MixedLaw<Damped<MixedLaw>>;

/// Any contact law of the crate with a half backlash near `size`.
pub fn law(case: &mut Case, size: f64) -> Result<Any, Stop> {
    Ok(match case.below(10) {
        0 => MixedLaw::Other(match case.below(3) {
            0 => Damped::by_stiffness(plain(case, size)?, case.number(0.1))?,
            1 => Damped::by_stiffness_always(plain(case, size)?, case.number(0.1))?,
            _ => Damped::by_force(plain(case, size)?, case.number(0.1))?,
        }),
        1 => MixedLaw::NoPull(NoPullBacklash::new(case.number(size), case.number(0.1))?),
        _ => plain(case, size)?,
    })
}

/// A contact law without damping.
fn plain<N: Nonlinearity>(case: &mut Case, size: f64) -> Result<MixedLaw<N>, Stop> {
    Ok(match case.below(7) {
        0 => MixedLaw::Linear(Linear),
        1 => MixedLaw::Cubic(Cubic::new(case.number(1.0), case.number(1.0 / (size * size)))?),
        2 => MixedLaw::Backlash(Backlash::new(case.number(size))?),
        3 => {
            let one = match case.below(4) {
                0 => AsymmetricBacklash::stop_above(case.number(size))?,
                1 => AsymmetricBacklash::stop_below(case.number(size))?,
                _ => AsymmetricBacklash::new(-case.number(size), case.number(size))?,
            };
            MixedLaw::Asymmetric(one.with_slopes(case.number(1.0), case.number(1.0))?)
        }
        4 => MixedLaw::Varying(VaryingBacklash::new(wave(case, 1, size)?)),
        5 => {
            let exponent =
                if case.hostile() { case.number(1.5) } else { case.pick(&[1.0, 10.0 / 9.0, 1.5, 2.0]) };
            let (b, depth) = (case.number(size), case.number(size));
            let one = PowerLaw::new(b, exponent, depth)?;
            // Higher exponents are allowed but overflow far from the edge.
            let one = if exponent <= 3.0 { one } else { PowerLaw::new(b, 3.0, depth)? };
            MixedLaw::Power(if case.chance(0.8) {
                one
            } else {
                one.with_edges(-case.number(size), case.number(size))?
            })
        }
        _ => MixedLaw::Smoothed(SmoothedBacklash::new(case.number(size), case.number(0.1 * size))?),
    })
}

/// Forces and slopes at deflections up to a million times the half backlash.
pub fn any(case: &mut Case) -> Run {
    let size = case.number(1e-4);
    let law = law(case, size)?;
    if let Ok(stop) = Restitution::new(case.number(0.5)) {
        finite("rebound", stop.rebound(case.signed(), case.signed()))?;
    }
    case.note(|| format!("{law:?}"));
    for _ in 0..10 {
        let angle = case.signed();
        let edges = law.edges(angle, Side::After);
        // A half backlash that varies may become negative, which `check_model` reports.
        let told = matches!(law, MixedLaw::Varying(_) | MixedLaw::Other(_));
        let crossed = edges.lower > edges.upper;
        holds(told || !crossed, || format!("edges {edges:?}"))?;
        for value in [edges.lower, edges.upper] {
            holds(!value.is_nan(), || format!("edges {edges:?}"))?;
        }
        all_finite("rates of edges", &[edges.lower_rate, edges.upper_rate])?;
        let size = if edges.upper.is_finite() { edges.upper.abs().max(1e-4) } else { 1e-4 };
        let x = case.pick(&[0.0, size, -size, 1e6 * size, 1e-3 * size]) * case.pick(&[1.0, -1.0, 0.3]);
        finite(format_args!("force at {x:e}"), law.force(edges.at(x, case.signed())))?;
        finite(format_args!("force at rest at {x:e}"), law.at(x))?;
        finite(format_args!("slope at {x:e}"), law.slope(x))?;
        for piece in [Piece::Lower, Piece::Gap, Piece::Upper] {
            let force = law.force_on(piece, &vec![piece; law.kinks()], edges.at(x, 0.0));
            finite(format_args!("force on {piece:?} at {x:e}"), force)?;
        }
        for k in 0..law.kinks() {
            finite(format_args!("kink {k} at {x:e}"), law.kink(k, x, case.signed()))?;
        }
        let edge = law.next_edge(angle);
        holds(edge.is_none_or(|edge| edge > angle), || format!("next_edge({angle:e}) is {edge:?}"))?;
    }
    Ok(())
}

/// Any speed law near a speed.
pub fn speed_law(case: &mut Case, speed: f64, time: f64) -> Result<SpeedLaw, Stop> {
    Ok(match case.below(4) {
        0 => SpeedLaw::constant(case.number(speed))?,
        1 => SpeedLaw::ramp(case.number(speed), case.number(speed), case.number(time))?,
        2 => SpeedLaw::fluctuation(case.number(speed), case.number(0.3), case.number(speed))?,
        _ => {
            let speeds: Vec<f64> = case
                .list(5, speed)
                .into_iter()
                .map(|speed| if case.chance(0.1) { speed } else { speed.abs() })
                .collect();
            let mut times = vec![0.0];
            while times.len() < speeds.len() {
                times.push(times[times.len() - 1] + case.number(0.2 * time));
            }
            SpeedLaw::table(&times, &speeds)?
        }
    })
}

/// The phase increases, and `time` inverts `phase`.
pub fn phases(case: &mut Case) -> Run {
    let (speed, time) = (case.number(10.0), case.number(4.0));
    let law = speed_law(case, speed, time)?;
    case.note(|| format!("{law:?}"));
    for _ in 0..10 {
        let t = case.number(2.0) * case.signed();
        if !t.is_finite() || t.abs() > 1e6 {
            continue;
        }
        let (phase, speed) = (law.angle(t), law.speed(t));
        finite(format_args!("phase at {t:e}"), phase)?;
        finite(format_args!("speed at {t:e}"), speed)?;
        holds(speed > 0.0, || format!("speed({t:e}) is {speed:e}"))?;
        let back = law.time(phase);
        finite(format_args!("time of phase {phase:e}"), back)?;
        let again = law.angle(back);
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
        HeldProcess::of_values(hold, &values)?
    } else if case.chance(0.5) {
        HeldProcess::new(hold, rand_distr::Normal::new(0.0, case.quantity(size))?)?
    } else {
        let (a, b) = (case.quantity(size), case.quantity(2.0 * size));
        HeldProcess::new(hold, rand_distr::Uniform::new(a, b)?)?
    };
    Ok(process.seed(case.seed()).member(case.seed()))
}

/// Values of held processes at any time and of any number.
pub fn held(case: &mut Case) -> Run {
    let process = process(case, 0.1, 1.0)?;
    case.note(|| format!("{process:?}"));
    for _ in 0..10 {
        let (t, stream, k) = (case.number(1.0) * case.signed(), case.seed(), case.seed());
        finite(format_args!("held value {k}"), process.held(stream, k))?;
        if t.is_finite() {
            finite(format_args!("value at {t:e}"), process.path(stream).at(t, Side::Before))?;
            finite(format_args!("value at {t:e}"), process.path(stream).at(t, Side::After))?;
        }
    }
    Ok(())
}
