//! Ranges, ticks and margins of a panel.

use crate::draw::labels::{Labels, labels};
use crate::draw::layers::{Layer, Mark};
use crate::draw::legend;
use crate::draw::shown::{Shown, TICK};
use crate::panel::Panel;
use crate::svg::text::{width, wrap};

pub(crate) const TITLE: f64 = 12.5;
pub(crate) const LABEL: f64 = 12.0;
/// Width of a bar of colours.
pub(crate) const BAR: f64 = 12.0;
/// Height of a line of titles.
pub(crate) const TITLE_LINE: f64 = 16.0;

/// Space around the axes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Margins {
    pub(crate) left: f64,
    pub(crate) right: f64,
    pub(crate) top: f64,
    pub(crate) bottom: f64,
}

impl Margins {
    pub(crate) fn larger(self, other: Self) -> Self {
        Margins {
            left: self.left.max(other.left),
            right: self.right.max(other.right),
            top: self.top.max(other.top),
            bottom: self.bottom.max(other.bottom),
        }
    }
    /// The rectangle of the axes in a panel.
    pub(crate) fn inner(self, [x, y]: [f64; 2], [w, h]: [f64; 2]) -> [f64; 4] {
        [x + self.left, y + self.top, w - self.left - self.right, h - self.top - self.bottom]
    }
}

/// A panel with its ranges.
pub(crate) struct Frame<'p> {
    pub(crate) panel: &'p Panel,
    pub(crate) axes: [Shown; 2],
    pub(crate) title: Vec<String>,
    pub(crate) bar: Option<Shown>,
}

/// Number of labels along an axis of a length.
pub(crate) fn count(length: f64, each: f64) -> f64 {
    (length / each).clamp(2.0, 10.0)
}

/// The width of the widest label along an axis of a panel, whatever height title and legend leave.
fn widest(axis: &Shown, height: f64) -> f64 {
    let heights = [120.0, 100.0, 80.0, 60.0].map(|around| height - around);
    heights.into_iter().map(|height| axis.widest(count(height, 27.0))).fold(0.0, f64::max)
}

impl<'p> Frame<'p> {
    pub(crate) fn of(panel: &'p Panel, letter: String, size: [f64; 2]) -> Self {
        let title = wrap(&format!("{letter}{}", panel.title), 1.09 * TITLE, size[0] - 20.0);
        let axes = [(&panel.x, 0), (&panel.y, 1)];
        let axes = axes.map(|(axis, at)| Shown::of(axis, axis.range.unwrap_or_else(|| extent(panel, at))));
        let bar = panel.bar.as_ref().map(|bar| Shown::new(&bar.name, &bar.unit, bar.range, bar.logarithmic));
        let frame = Frame { panel, axes, title, bar };
        frame.fitted(size[0] - 90.0, size[1] - 90.0)
    }
    /// The frame with one scale along both axes, if the panel asks for it.
    pub(crate) fn fitted(mut self, width: f64, height: f64) -> Self {
        if self.panel.equal {
            let axes = [&self.panel.x, &self.panel.y];
            let [x, y] = [0, 1].map(|i| axes[i].range.unwrap_or_else(|| extent(self.panel, i)));
            let per_point = ((x[1] - x[0]) / width).max((y[1] - y[0]) / height);
            let wide = |[low, high]: [f64; 2], length: f64| {
                let (middle, half) = (0.5 * (low + high), 0.5 * length * per_point);
                [middle - half, middle + half]
            };
            let ranges = [wide(x, width), wide(y, height)];
            self.axes = [0, 1].map(|i| Shown::of(axes[i], ranges[i]));
        }
        self
    }
    /// Left and right margins.
    pub(crate) fn sides(&self, height: f64) -> Margins {
        let inner = [0.0, 0.0, 300.0, height - 90.0];
        let mut right = 14.0f64;
        let beside = self.labels(inner).beside;
        let names = beside.iter().map(|(_, text, _)| width(text, TICK)).fold(0.0, f64::max);
        if names > 0.0 {
            right = names + 14.0;
        }
        if let Some(bar) = &self.bar {
            let labels = if names > 0.0 { names + 6.0 } else { 0.0 };
            right = labels + 10.0 + BAR + 6.0 + widest(bar, height) + 20.0;
        }
        if self.panel.layers.iter().any(|layer| matches!(layer, Layer::Height { .. })) {
            right = right.max(34.0);
        }
        let left = 22.0 + 6.0 + widest(&self.axes[1], height);
        Margins { left, right, ..Margins::default() }
    }
    /// Upper and lower margins, for given sides.
    pub(crate) fn heads(&self, sides: Margins, size: [f64; 2]) -> Margins {
        let inner = [0.0, 0.0, size[0] - sides.left - sides.right, size[1] - 90.0];
        let rows = legend::rows(&self.panel.legend, inner[2] + sides.right - 8.0).len() as f64;
        let above = self.labels(inner).rows as f64;
        let top = 8.0 + TITLE_LINE * self.title.len() as f64 + legend::ROW * rows + 12.0 * above + 5.0;
        Margins { top, bottom: 42.0, ..Margins::default() }
    }
    pub(crate) fn labels(&self, inner: [f64; 4]) -> Labels {
        labels(self.panel, &self.axes, inner)
    }
    /// The point of the picture for a point of the panel.
    pub(crate) fn place(&self, [x, y]: [f64; 2], [x0, y0, w, h]: [f64; 4]) -> [f64; 2] {
        [x0 + w * self.axes[0].share(x), y0 + h * (1.0 - self.axes[1].share(y))]
    }
}

/// The range of all layers along an axis, with space around curves.
fn extent(panel: &Panel, at: usize) -> [f64; 2] {
    let axis = if at == 0 { &panel.x } else { &panel.y };
    // Along y only what the range of x shows counts.
    let seen = |p: &[f64; 2]| at == 0 || panel.x.range.is_none_or(|[low, high]| p[0] >= low && p[0] <= high);
    let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
    let mut add = |value: f64| (low, high) = (low.min(value), high.max(value));
    let (mut lines, mut dots, mut cells) = (false, false, false);
    let mut bars = false;
    for layer in &panel.layers {
        match layer {
            Layer::Curve(curve) => {
                curve.points.iter().filter(|p| seen(p)).for_each(|p| add(p[at]));
                match curve.mark {
                    Mark::Dots | Mark::Rings | Mark::Joined | Mark::Specks => dots = true,
                    Mark::Bars => bars = true,
                    _ => lines = true,
                }
            }
            Layer::Raster(raster) => {
                raster.borders[at].iter().for_each(|border| add(*border));
                cells = true;
            }
            Layer::Outline { lines, .. } => {
                lines.iter().flatten().filter(|p| seen(p)).for_each(|p| add(p[at]))
            }
            Layer::Note { places, .. } => places.iter().take(1).for_each(|place| add(place[at])),
            Layer::Shade { spans, .. } if at == 0 => spans.iter().flatten().for_each(|x| add(*x)),
            Layer::Shade { .. } | Layer::Exit { .. } | Layer::Height { .. } => {}
        }
    }
    if cells {
        // Curves over a map are drawn as far as the map reaches.
        let borders = panel.layers.iter().find_map(|layer| match layer {
            Layer::Raster(raster) => Some(&raster.borders[at]),
            _ => None,
        });
        if let Some(([first, ..], [.., last])) = borders.map(|b| (&b[..], &b[..])) {
            return [*first, *last];
        }
    }
    let bars = bars && at == 1 && !axis.logarithmic && low >= 0.0;
    if bars {
        low = 0.0;
    }
    if low > high {
        return if axis.logarithmic { [0.1, 1.0] } else { [0.0, 1.0] };
    }
    if axis.logarithmic {
        let by = if high > low { (high / low).powf(0.04) } else { 2.0 };
        return [low / by, high * by];
    }
    let wide = if high > low { high - low } else { low.abs().max(1e-12) };
    let margin = match at {
        _ if panel.equal => 0.02,
        0 if lines && !dots => 0.0,
        0 => 0.02,
        _ => 0.06,
    };
    [if bars { 0.0 } else { low - margin * wide }, high + margin * wide]
}
