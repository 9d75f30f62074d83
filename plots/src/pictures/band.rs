//! Bands of ensembles.

use crate::draw::colours::Ink;
use crate::draw::layers::{Curve, Mark};
use crate::error::PlotError;
use crate::panel::{Panel, name_and_unit};
use gear_dynamics::sweep::Bands;

/// Mean and quantiles of a channel of an ensemble over the time.
///
/// `channel`: name of the channel with its unit. The time axis is `t [s]`; [`Panel::x`] names another unit. `quantiles`: the lower and the upper border of the band, from 0 to 1.
///
/// ```
/// use gear_dynamics::{Dop853, State, models::Oscillator, sweep::Ensemble};
/// use gear_dynamics_plots::{Picture, band};
/// let family = |member: u64| {
///     let constants = [("speed", 1.0), ("damping", 0.1), ("linear stiffness", 1.0 + 0.1 * member as f64)];
///     Ok::<_, gear_dynamics::ParameterError>((Oscillator::new(&constants)?, State::new(0.0, &[1.0], &[0.0])))
/// };
/// let bands = Ensemble::new(5, 10.0, 50)?.channels(&["q0"]).run(&Dop853::new(), family)?;
/// let svg = Picture::from(band(&bands, "q0 [1]", [0.05, 0.95])?).to_svg();
/// assert!(svg.contains("5 % to 95 %") && svg.contains("mean of 5 members"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PlotError::Empty`], [`PlotError::NotFinite`], [`PlotError::NoUnit`]; those of
/// [`Bands::band`].
pub fn band(bands: &Bands, channel: &str, quantiles: [f64; 2]) -> Result<Panel, PlotError> {
    let mut panel = Panel::new("", "time t [s]", channel)?;
    let [name, _] = name_and_unit(channel)?;
    let curve = |values: Vec<f64>| bands.times().iter().zip(values).map(|(t, x)| [*t, x]).collect::<Vec<_>>();
    let mut outline = curve(bands.band(&name, quantiles[0])?);
    outline.extend(curve(bands.band(&name, quantiles[1])?).into_iter().rev());
    let percent = quantiles.map(|p| format!("{} %", (1e4 * p).round() / 100.0));
    let label = format!("{} to {} of the members", percent[0], percent[1]);
    panel.curve(
        &label,
        Curve { mark: Mark::Area, ink: Ink::Series(0), style: 0, width: 0.0, points: outline },
    )?;
    let label = format!("mean of {} members", bands.members());
    let points = curve(bands.mean(&name)?);
    panel.curve(&label, Curve { mark: Mark::Line, ink: Ink::Series(0), style: 0, width: 0.8, points })?;
    Ok(panel)
}
