//! Functions of time: every constructor, nested; values, rates, edges.

use crate::case::{Case, Run, Stop, all_finite, finite, holds};
use gear_dynamics::*;

/// An excitation of up to so many levels, about a mean and a period.
pub fn excitation(case: &mut Case, levels: usize, mean: f64, period: f64) -> Result<Shared, Stop> {
    let omega = std::f64::consts::TAU / period;
    let kinds = if levels == 0 { 7 } else { 11 };
    Ok(match case.below(kinds) {
        0 => shared(Constant::new(case.number(mean))?),
        1 => {
            let (mean, pairs) = (case.number(mean), case.pairs(4, 0.2 * mean));
            shared(Fourier::new(mean, &pairs, case.exactly(omega))?.with_phase(case.number(1.0))?)
        }
        2 => {
            let (mean, pairs) = (case.number(mean), case.pairs(3, 0.2 * mean));
            shared(Fourier::from_amplitudes(mean, &pairs, case.exactly(omega))?)
        }
        3 => {
            let (low, high, duty) = (case.number(0.5 * mean), case.number(mean), case.number(0.4));
            shared(RectangularWave::new(low, high, duty, case.exactly(period))?.with_phase(case.number(1.0))?)
        }
        4 => {
            let (ratio, low, high) = (case.number(1.5), case.number(0.5 * mean), case.number(mean));
            let wave = RectangularWave::from_contact_ratio(ratio, low, high, case.exactly(period))?;
            finite("mean of a wave", wave.mean())?;
            if case.chance(0.5) { shared(wave) } else { shared(wave.series(case.count(5))?) }
        }
        5 => {
            let centre = InstantCentre::new(case.number(0.2), case.exactly(omega))?;
            finite("beta", centre.beta())?;
            match case.below(4) {
                0 => shared(centre.radius(case.number(mean))?),
                1 => shared(centre.ratio(case.number(mean))?),
                2 => shared(centre.forcing()),
                _ => shared(centre.forcing_series(case.count(4))?),
            }
        }
        6 => {
            let samples = case.list(12, mean);
            shared(Table::new(&samples, case.exactly(period))?)
        }
        7 => shared(Sum::new(some(case, levels, mean, period)?)),
        8 => shared(Product::new(some(case, levels, mean, period)?)),
        9 => {
            let factor = case.number(1.0);
            shared(Scaled::new(factor, excitation(case, levels - 1, mean, period)?)?)
        }
        _ => {
            let (scale, omega) = (case.quantity(mean), case.quantity(omega));
            let function = Function::new(move |t: Jet| (t * omega).sin() * scale);
            if case.chance(0.5) { shared(function.with_period(case.exactly(period))?) } else { shared(function) }
        }
    })
}

fn some(case: &mut Case, levels: usize, mean: f64, period: f64) -> Result<Vec<Shared>, Stop> {
    let count = if case.hostile() { 0 } else { 1 + case.below(3) };
    (0..count).map(|_| excitation(case, levels - 1, mean, period)).collect()
}

/// What an accepted excitation of moderate size has to give at any time.
pub fn any(case: &mut Case) -> Run {
    let scale = case.number(1.0);
    let period = case.number(1.0);
    let one = excitation(case, 2, scale, period)?;
    case.note(|| format!("{one:?}"));
    let mut t = case.number(1.0) * case.signed();
    for _ in 0..20 {
        // Past this the angle of a wave is no number of turns that could be told.
        if t.is_nan() || t.abs() > 1e12 {
            break;
        }
        for side in [Side::Before, Side::After] {
            let jet = one.jet(t, side);
            finite(format_args!("value at {t:e}"), jet.value)?;
            finite(format_args!("rate at {t:e}"), jet.rate)?;
            finite(format_args!("second derivative at {t:e}"), jet.second)?;
            let (value, rate) = (one.value(t, side), one.rate(t, side));
            holds(value.to_bits() == jet.value.to_bits() || (value - jet.value).abs() <= 1e-9 * value.abs().max(1e-300), || {
                format!("value({t:e}) is {value:e}, that of the jet {:e}", jet.value)
            })?;
            finite("rate alone", rate)?;
        }
        let edge = one.next_edge(t);
        holds(edge.is_none_or(|edge| edge > t), || format!("next_edge({t:e}) is {edge:?}"))?;
        t = match edge {
            Some(edge) if case.chance(0.5) => edge,
            _ => t + case.number(period) * case.signed(),
        };
    }
    if let Repeats::Every(period) = one.repeats() {
        finite("period", period)?;
        holds(period > 0.0, || format!("period {period}"))?;
        let _ = one.repeats().fits(case.number(period));
    }
    let other = excitation(case, 1, scale, period)?.repeats();
    let (a, b) = (one.repeats().with(other), other.with(one.repeats()));
    let same = match (a, b) {
        (Repeats::Every(a), Repeats::Every(b)) => (a - b).abs() <= 1e-6 * a,
        _ => format!("{a:?}") == format!("{b:?}"),
    };
    holds(same, || format!("{:?} with {other:?} depends on the order: {a:?}, {b:?}", one.repeats()))
}

/// Samples and their fits.
pub fn tables(case: &mut Case) -> Run {
    let (length, scale) = (4 + case.below(40), case.number(1.0));
    let samples = case.list(length, scale);
    case.note(|| format!("samples {samples:?}"));
    let period = case.number(1.0);
    if let Some(table) = case.accept(Table::new(&samples, period)) {
        for _ in 0..8 {
            let t = case.number(1.0);
            // Past this a time is no phase of the table.
            if t.abs() < 1e12 {
                let jet = table.jet(t, Side::After);
                all_finite(format_args!("table of period {period:e} at {t:e}"), &[jet.value, jet.rate, jet.second])?;
            }
        }
    }
    let (order, omega) = (case.count(3), case.number(1.0));
    let fit = Fourier::fit(&samples, order, omega)?;
    case.note(|| format!("{fit:?}"));
    finite("mean of a fit", fit.mean())?;
    fit.pairs().iter().try_for_each(|pair| all_finite("amplitudes of a fit", pair))?;
    let t = case.signed();
    finite("value of a fit", fit.value(t, Side::After))
}

/// Arithmetic of jets about sensible values.
pub fn jets(case: &mut Case) -> Run {
    let mut jet = Jet::new(1.0 + case.unit(), case.signed(), case.signed());
    for _ in 0..6 {
        let other = Jet::new(1.0 + case.unit(), case.signed(), case.signed());
        jet = match case.below(8) {
            0 => jet + other,
            1 => jet * other,
            2 => jet / other,
            3 => (jet * jet + 1.0).sqrt(),
            4 => jet.sin(),
            5 => jet.cos() * 0.5,
            6 => (-(jet * jet)).exp(),
            _ => jet - Jet::constant(case.signed()),
        };
        all_finite("jet", &[jet.value, jet.rate, jet.second])?;
    }
    let zero = (Jet::time(0.0) * Jet::time(0.0)).sqrt();
    finite("sqrt of t² at 0", zero.value)
}
