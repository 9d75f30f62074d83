//! Random processes with a correlation.

use crate::case::{Case, Run, Stop, finite, holds};
use gear_dynamics::excitation::Side;
use gear_dynamics::processes::{
    FilteredNoise, JitteredOrder, OrnsteinUhlenbeck, Process, ShotNoise, SpectralProcess,
};

/// Any process but the held one. A value of shot noise sums some 37 times as many pulses as fall into its
/// decay time: at most `pulses`.
pub fn process(case: &mut Case, pulses: f64) -> Result<Box<dyn Process>, Stop> {
    let (seed, member) = (case.seed(), case.seed());
    let (size, time, spacing) = (case.number(1.0), case.number(1.0), case.number(0.1));
    let turn = case.number(1.0);
    case.note(|| format!("size {size:e}, time {time:e}, spacing {spacing:e}, turn {turn:e}"));
    Ok(match case.below(5) {
        0 => Box::new(OrnsteinUhlenbeck::new(size, time, spacing)?.seed(seed).member(member)),
        1 => {
            let damping = case.number(0.1);
            Box::new(FilteredNoise::new(size, turn, damping, spacing)?.seed(seed).member(member))
        }
        2 => Box::new(JitteredOrder::new(size, turn, time, spacing)?.seed(seed).member(member)),
        3 => {
            let sizes = rand_distr::Normal::new(0.0, case.quantity(1.0))?;
            let rate = if turn * time > pulses { pulses / time } else { turn };
            Box::new(ShotNoise::new(rate, time, sizes)?.moments(0.0, size)?.seed(seed).member(member))
        }
        _ => {
            let harmonics = case.count(50);
            let band = [case.number(1.0) - 1.0, turn];
            let process = SpectralProcess::new(|f| size / (1.0 + f * f), band, harmonics)?;
            Box::new(process.seed(seed).member(member))
        }
    })
}

/// Paths, series, edges and statistics.
pub fn processes(case: &mut Case) -> Run {
    let process = process(case, f64::INFINITY)?;
    let path = process.path(case.seed());
    for _ in 0..5 {
        let (t, lag) = (case.number(1.0) * case.signed(), case.number(1.0));
        case.note(|| format!("t {t:e}, lag {lag:e}"));
        // Beyond, angles overflow.
        if !(t.abs() <= 1e50 && lag.abs() <= 1e50) {
            continue;
        }
        finite(format_args!("value at {t:e}"), path.at(t, Side::Before))?;
        let (value, first) = (path.at(t, Side::After), path.series(t, 12).at(0.0));
        finite(format_args!("value at {t:e}"), value)?;
        holds((first - value).abs() <= 1e-9 * value.abs(), || format!("{value:e}, series {first:e}"))?;
        holds(path.next_edge(t).is_none_or(|edge| edge > t), || format!("an edge not after {t:e}"))?;
        let statistics = [process.mean(), process.variance(), process.correlation(lag), process.density(lag)];
        statistics.into_iter().flatten().try_for_each(|x| finite("statistic", x))?;
    }
    Ok(())
}
