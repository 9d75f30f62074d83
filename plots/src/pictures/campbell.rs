//! Campbell diagrams.

use crate::draw::colours::Ink;
use crate::draw::layers::{Curve, Layer, Mark, Swatch, THIN};
use crate::error::{PlotError, finite};
use crate::panel::Panel;
use gear_dynamics::linear::Campbell;
use std::f64::consts::TAU;

/// Natural frequencies over the speed with the lines of named orders, and their crossings. Few of them are resonances: it
/// takes an excitation that moves the mode.
///
/// `speed`: text with unit, of a speed in radians per second, over which frequencies are in Hz; with the unit `[1]`
/// speed and frequencies are numbers of the model. `orders`: multiples of this speed, each with its name.
///
/// ```
/// use gear_dynamics::linear::Campbell;
/// use gear_dynamics::{NfgPair, NfgParams};
/// use gear_dynamics_plots::{Picture, campbell};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let diagram = Campbell::of(&pair, &[10.0, 300.0, 3000.0], &[18.0])?;
/// let svg = Picture::from(campbell(&diagram, "speed [rad/s]", &[(18.0, "mesh")])?).to_svg();
/// assert!(svg.contains(">frequency f [Hz]") && svg.contains("orders"));
/// let svg = Picture::from(campbell(&diagram, "speed Ω [1]", &[])?).to_svg();
/// assert!(svg.contains(">frequency f [1]"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PlotError::Empty`] without speeds or frequencies, [`PlotError::NotFinite`], [`PlotError::NoUnit`].
pub fn campbell(diagram: &Campbell, speed: &str, orders: &[(f64, &str)]) -> Result<Panel, PlotError> {
    let mut panel = Panel::new("", speed, "frequency f [Hz]")?;
    let mut per = TAU;
    if panel.x.unit == "1" {
        (per, panel.y.unit) = (1.0, "1".into());
    }
    let speeds = diagram.speeds();
    finite("speeds of the Campbell diagram", speeds)?;
    let modes = diagram.frequencies().iter().map(Vec::len).max().unwrap_or(0);
    if modes == 0 {
        return Err(PlotError::Empty { what: "natural frequencies of the Campbell diagram".into() });
    }
    for mode in 0..modes {
        // A mode that stops to oscillate ends.
        let found = speeds.iter().zip(diagram.frequencies());
        let points: Vec<_> = found.filter_map(|(s, f)| Some([*s, f.get(mode)? / per])).collect();
        let curve = Curve { mark: Mark::Line, ink: Ink::Series(0), style: 0, width: 1.6, points };
        panel.curve("natural frequencies", curve)?;
    }
    let last = speeds[speeds.len() - 1];
    for (order, name) in orders {
        finite("orders of the Campbell diagram", [order])?;
        panel.layers.push(Layer::Exit {
            from: [0.0, 0.0],
            to: [last, order * last / per],
            text: (*name).into(),
            ink: Ink::Grey,
        });
    }
    if !orders.is_empty() {
        panel.entry("orders", Swatch::Line { ink: Ink::Grey, style: THIN, width: 1.0, cased: false });
    }
    let meetings = diagram.resonances().iter();
    let meetings = meetings.filter(|r| orders.iter().any(|(order, _)| (order - r.order).abs() < 1e-9));
    let points: Vec<_> = meetings.map(|r| [r.speed, r.frequency / per]).collect();
    if !points.is_empty() {
        let curve = Curve { mark: Mark::Rings, ink: Ink::Series(1), style: 0, width: 1.2, points };
        panel.curve("crossings", curve)?;
    }
    // The lines of the orders meet at the origin.
    if last > 0.0 {
        panel.x.range = Some([speeds[0].min(0.0), last]);
    }
    let most = diagram.frequencies().iter().flatten().fold(0.0f64, |most, f| most.max(*f)) / per;
    if most > 0.0 {
        panel.y.range = Some([0.0, 1.06 * most]);
    }
    Ok(panel)
}
