//! Spectra over frequency and order, maps and cascades of them.

use crate::draw::colours::Ink;
use crate::draw::layers::{Bar, Curve, Layer, Mark, Raster};
use crate::error::{PlotError, finite};
use crate::panel::{Panel, name_and_unit};
use gear_dynamics::analysis::{Spectrum, WaterfallLine};

/// Amplitudes over the frequency as a line, without the mean. `amplitude`: text with unit.
///
/// ```
/// use gear_dynamics::analysis::{Spectrum, Window};
/// use gear_dynamics_plots::{Picture, spectrum};
/// let samples: Vec<f64> = (0..64).map(|k| (0.5 * f64::from(k)).sin()).collect();
/// let panel = spectrum(&Spectrum::new(&samples, 1e-3, Window::Hann)?, "amplitude [m]")?.logarithmic_y()?;
/// assert!(Picture::from(panel).to_svg().contains("frequency f [Hz]"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PlotError::Empty`], [`PlotError::NotFinite`], [`PlotError::NoUnit`].
pub fn spectrum(spectrum: &Spectrum, amplitude: &str) -> Result<Panel, PlotError> {
    let panel = Panel::new("", "frequency f [Hz]", amplitude)?;
    amplitudes(panel, Mark::Line, spectrum.frequencies(), spectrum.amplitudes())
}

/// Amplitudes over the order of a base frequency as bars, without the mean, with orders named.
///
/// ```
/// use gear_dynamics::analysis::{Spectrum, Window};
/// use gear_dynamics_plots::{Picture, order_spectrum};
/// let samples: Vec<f64> = (0..64).map(|k| (0.5 * f64::from(k)).sin()).collect();
/// let lines = Spectrum::new(&samples, 1e-3, Window::Rectangular)?;
/// let panel = order_spectrum(&lines, 10.0, "amplitude [m]", &[(8.0, "mesh")])?;
/// assert!(Picture::from(panel).to_svg().contains(">mesh</text>"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`spectrum`], and those of [`Spectrum::orders`].
pub fn order_spectrum(
    spectrum: &Spectrum,
    base: f64,
    amplitude: &str,
    names: &[(f64, &str)],
) -> Result<Panel, PlotError> {
    let panel = Panel::new("", "order [1]", amplitude)?.name_x(names)?;
    amplitudes(panel, Mark::Bars, &spectrum.orders(base)?, spectrum.amplitudes())
}

/// A spectrum without its mean.
fn amplitudes(mut panel: Panel, mark: Mark, across: &[f64], values: &[f64]) -> Result<Panel, PlotError> {
    let points = across.iter().zip(values).skip(1).map(|(x, a)| [*x, *a]).collect();
    let width = if mark == Mark::Bars { 2.0 } else { 1.2 };
    panel.curve("", Curve { mark, ink: Ink::Series(0), style: 0, width, points })?;
    Ok(panel)
}

/// Amplitudes of a run of varying speed as colours over order and speed, on a logarithmic scale of four decades.
/// `highest`: the last order that is drawn. Lines of a speed that turns back stand over the time `[s]`; of a model
/// without dimensions, [`Panel::y`] names the axis.
///
/// ```
/// use gear_dynamics::analysis::WaterfallLine;
/// use gear_dynamics_plots::{Picture, order_map};
/// let line = |speed: f64| WaterfallLine { t: speed, speed, orders: vec![0.0, 1.0, 2.0], amplitudes: vec![0.0, 1e-6, 3e-5] };
/// let panel = order_map(&[line(10.0), line(12.0)], "amplitude [m]", 2.0, &[(2.0, "mesh")])?;
/// assert!(Picture::from(panel).to_svg().contains("speed [rad/s]"));
/// # Ok::<(), gear_dynamics_plots::PlotError>(())
/// ```
///
/// # Errors
/// [`PlotError::Empty`] without lines or without orders up to `highest`, [`PlotError::NotFinite`],
/// [`PlotError::NoUnit`].
pub fn order_map(
    lines: &[WaterfallLine],
    amplitude: &str,
    highest: f64,
    names: &[(f64, &str)],
) -> Result<Panel, PlotError> {
    let cascade = Cascade::of(lines, highest)?;
    let mut panel = Panel::new("", "order [1]", cascade.axis)?.name_x(names)?;
    let [name, unit] = name_and_unit(amplitude)?;
    let borders = [borders(cascade.orders), borders(&cascade.heights)];
    let count = cascade.orders.len();
    let at = |k: usize, i: usize| cascade.lines[i].amplitudes[k];
    let values = (0..count).flat_map(|k| (0..cascade.lines.len()).map(move |i| (k, i)));
    let values: Vec<f64> = values.map(|(k, i)| at(k, i)).collect();
    let most = cascade.most;
    panel.bar = Some(Bar { name, unit, range: [1e-4 * most, most], logarithmic: true });
    panel.layers.push(Layer::Raster(Raster { borders, values, inks: Vec::new() }));
    Ok(panel)
}

/// The spectra of a run of varying speed one behind the other: amplitudes over the order, each above its speed. The
/// measure at the right is the length of an amplitude.
///
/// ```
/// use gear_dynamics::analysis::WaterfallLine;
/// use gear_dynamics_plots::{Picture, waterfall};
/// let line = |speed: f64| WaterfallLine { t: speed, speed, orders: vec![0.0, 1.0, 2.0], amplitudes: vec![0.0, 1e-6, 3e-5] };
/// let panel = waterfall(&[line(10.0), line(12.0)], "amplitude [m]", 2.0, &[(2.0, "mesh")])?;
/// assert!(Picture::from(panel).to_svg().contains("amplitude 20 μm"));
/// # Ok::<(), gear_dynamics_plots::PlotError>(())
/// ```
///
/// # Errors
/// As [`order_map`].
pub fn waterfall(
    lines: &[WaterfallLine],
    amplitude: &str,
    highest: f64,
    names: &[(f64, &str)],
) -> Result<Panel, PlotError> {
    let cascade = Cascade::of(lines, highest)?;
    let mut panel = Panel::new("", "order [1]", cascade.axis)?.name_x(names)?;
    let [name, unit] = name_and_unit(amplitude)?;
    let heights = &cascade.heights;
    let wide = match (heights.first(), heights.last()) {
        (Some(first), Some(last)) if last > first => last - first,
        _ => 1.0,
    };
    let per = 0.22 * wide / cascade.most;
    let foot = heights[0] - 0.02 * wide;
    for (line, height) in cascade.lines.iter().zip(heights).rev() {
        let curve = || cascade.orders.iter().zip(&line.amplitudes).map(|(o, a)| [*o, height + per * a]);
        let ends = [cascade.orders[0], cascade.orders[cascade.orders.len() - 1]];
        let mut field: Vec<[f64; 2]> = curve().collect();
        field.extend([[ends[1], foot], [ends[0], foot]]);
        panel.layers.push(Layer::Outline {
            lines: vec![field],
            fill: Some((Ink::Paper, 0.85)),
            stroke: None,
        });
        let stroke = Some((Ink::Series(0), 1.0));
        panel.layers.push(Layer::Outline { lines: vec![curve().collect()], fill: None, stroke });
    }
    // A measure of a round amplitude.
    let power = 10f64.powf(cascade.most.log10().floor());
    let round = [5.0, 2.0, 1.0].map(|m| m * power).into_iter().find(|round| *round <= cascade.most);
    let round = round.unwrap_or(cascade.most);
    let scale = crate::draw::ticks::scale(&unit, round);
    let text = format!("{name} {} {}", number(round * scale.factor), scale.unit);
    panel.layers.push(Layer::Height { length: per * round, text });
    panel.y.range = Some([foot, heights[heights.len() - 1] + 0.24 * wide]);
    Ok(panel)
}

/// A number without the digits of rounding.
fn number(x: f64) -> String {
    let text = format!("{x:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Lines in the order of their speeds.
struct Cascade<'l> {
    lines: Vec<&'l WaterfallLine>,
    /// Orders up to the highest one, without 0.
    orders: &'l [f64],
    heights: Vec<f64>,
    axis: &'static str,
    /// Largest amplitude above the order 0.
    most: f64,
}

impl<'l> Cascade<'l> {
    fn of(lines: &'l [WaterfallLine], highest: f64) -> Result<Self, PlotError> {
        let empty = || PlotError::Empty { what: "orders of the waterfall".into() };
        let first = lines.first().ok_or_else(empty)?;
        let count = first.orders.iter().take_while(|order| **order <= highest).count();
        for line in lines {
            finite("speeds of the waterfall", [&line.t, &line.speed])?;
            finite("orders of the waterfall", &line.orders)?;
            finite("amplitudes of the waterfall", &line.amplitudes)?;
            if line.orders.len() < count || line.amplitudes.len() < count {
                return Err(empty());
            }
        }
        let rises =
            |of: &dyn Fn(&WaterfallLine) -> f64| lines.windows(2).all(|two| of(&two[1]) > of(&two[0]));
        let mut all: Vec<&WaterfallLine> = lines.iter().collect();
        let (by_speed, axis) = match (rises(&|line| line.speed), rises(&|line| -line.speed)) {
            (true, _) => (true, "speed [rad/s]"),
            (_, true) => {
                all.reverse();
                (true, "speed [rad/s]")
            }
            _ => (false, "time t [s]"),
        };
        let heights = all.iter().map(|line| if by_speed { line.speed } else { line.t }).collect();
        let most = lines
            .iter()
            .flat_map(|line| &line.amplitudes[1.min(count)..count])
            .fold(0.0, |m: f64, a| m.max(*a));
        if count < 2 || most <= 0.0 {
            return Err(empty());
        }
        Ok(Cascade { lines: all, orders: &first.orders[..count], heights, axis, most })
    }
}

/// Borders half way between values; a single value has a width of its own size.
pub(crate) fn borders(values: &[f64]) -> Vec<f64> {
    let count = values.len();
    if count < 2 {
        let half = if values[0] == 0.0 { 0.5 } else { 0.5 * values[0].abs() };
        return vec![values[0] - half, values[0] + half];
    }
    let mut borders = vec![values[0] - 0.5 * (values[1] - values[0])];
    borders.extend(values.windows(2).map(|two| 0.5 * (two[0] + two[1])));
    borders.push(values[count - 1] + 0.5 * (values[count - 1] - values[count - 2]));
    borders
}
