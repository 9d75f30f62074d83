//! An axis as it is shown: range, scale of the numbers, text.

use crate::draw::layers::share;
use crate::draw::ticks::{Scale, Tick, linear, logarithmic, scale};
use crate::panel::Axis;
use crate::svg::text::width;

/// Size of the labels of ticks.
pub(crate) const TICK: f64 = 11.0;

/// The range of an axis with the scale of its numbers.
#[derive(Clone, Debug)]
pub(crate) struct Shown {
    pub(crate) range: [f64; 2],
    pub(crate) logarithmic: bool,
    pub(crate) scale: Scale,
    /// Name and unit.
    pub(crate) text: String,
}

impl Shown {
    pub(crate) fn of(axis: &Axis, range: [f64; 2]) -> Self {
        Shown::new(&axis.name, &axis.unit, range, axis.logarithmic)
    }
    pub(crate) fn new(name: &str, unit: &str, range: [f64; 2], logarithmic: bool) -> Self {
        let largest = range[0].abs().max(range[1].abs());
        // Counts, and numbers over many decades, stand as they are on a logarithmic axis.
        let scale = match logarithmic && (unit == "1" || range[1] > 1e3 * range[0]) {
            true => Scale { factor: 1.0, unit: unit.to_owned() },
            false => scale(unit, largest),
        };
        let text = format!("{name} [{}]", scale.unit);
        Shown { range, logarithmic, scale, text }
    }
    pub(crate) fn share(&self, value: f64) -> f64 {
        share(value, self.range, self.logarithmic)
    }
    /// Ticks, their values on the axis of the panel.
    pub(crate) fn ticks(&self, count: f64) -> Vec<Tick> {
        let factor = self.scale.factor;
        let range = self.range.map(|x| x * factor);
        let ticks = if self.logarithmic { logarithmic(range, count) } else { linear(range, count) };
        ticks.into_iter().map(|(value, label)| (value / factor, label)).collect()
    }
    /// The width of the widest label.
    pub(crate) fn widest(&self, count: f64) -> f64 {
        let labels = self.ticks(count).into_iter().filter_map(|tick| tick.1);
        labels.map(|label| width(&label, TICK)).fold(0.0, f64::max)
    }
}
