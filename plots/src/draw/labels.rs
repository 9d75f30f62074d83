//! Names above and beside a panel: of values of an axis, and of lines that leave the panel.

use crate::draw::colours::Ink;
use crate::draw::layers::Layer;
use crate::draw::shown::{Shown, TICK};
use crate::panel::Panel;
use crate::svg::text::width;

/// Names around a panel, placed so that they do not overlap.
pub(crate) struct Labels {
    /// Above: the value's place, place of the middle of the text, row from below, text, ink.
    pub(crate) above: Vec<(f64, f64, usize, String, Ink)>,
    /// Number of rows above.
    pub(crate) rows: usize,
    /// Beside: place along y, text, ink.
    pub(crate) beside: Vec<(f64, String, Ink)>,
}

const SPACING: f64 = 12.5;

pub(crate) fn labels(panel: &Panel, axes: &[Shown; 2], inner: [f64; 4]) -> Labels {
    let [x0, y0, w, h] = inner;
    let within = |share: f64| (-1e-9..=1.0 + 1e-9).contains(&share);
    let mut above: Vec<(f64, String, Ink)> = Vec::new();
    let mut beside: Vec<(f64, String, Ink)> = Vec::new();
    for (value, name) in &panel.x.named {
        let share = axes[0].share(*value);
        if within(share) {
            above.push((x0 + w * share, name.clone(), Ink::Grey));
        }
    }
    for (value, name) in &panel.y.named {
        let share = axes[1].share(*value);
        if within(share) {
            beside.push((y0 + h * (1.0 - share), name.clone(), Ink::Grey));
        }
    }
    for layer in &panel.layers {
        let Layer::Exit { from, to, text, ink } = layer else { continue };
        let [a, b] = [from, to].map(|p| [axes[0].share(p[0]), axes[1].share(p[1])]);
        let Some([x, y]) = exit(a, b) else { continue };
        if y > 1.0 - 1e-6 && x < 1.0 - 1e-6 {
            above.push((x0 + w * x, text.clone(), *ink));
        } else {
            beside.push((y0 + h * (1.0 - y), text.clone(), *ink));
        }
    }
    beside.sort_by(|a, b| a.0.total_cmp(&b.0));
    apart(&mut beside, y0 + 4.0, y0 + h + 4.0);
    above.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut placed = Vec::new();
    let mut rows = 0;
    for group in groups(above) {
        rows = rows.max(group.len());
        place(group, [x0, x0 + w], &mut placed);
    }
    Labels { above: placed, rows, beside }
}

type Named = (f64, String, Ink);

/// Groups of sorted names that would overlap in one row.
fn groups(names: Vec<Named>) -> Vec<Vec<Named>> {
    let mut groups: Vec<Vec<Named>> = Vec::new();
    let mut end = f64::NEG_INFINITY;
    for name in names {
        let wide = width(&name.1, TICK);
        match groups.last_mut() {
            Some(group) if name.0 - 0.5 * wide < end + 5.0 => {
                end = group.iter().map(|(at, text, _)| at + width(text, TICK)).fold(name.0 + wide, f64::max);
                group.push(name);
            }
            _ => {
                end = name.0 + 0.5 * wide;
                groups.push(vec![name]);
            }
        }
    }
    groups
}

/// Places a group: a single name above its value; several as flags, each at its own height, so that no text lies on the
/// line to another.
fn place(group: Vec<Named>, [low, high]: [f64; 2], placed: &mut Vec<(f64, f64, usize, String, Ink)>) {
    let count = group.len();
    let reach = |(at, text, _): &Named| at + width(text, TICK);
    let leftwards = group.iter().any(|name| reach(name) > high + 10.0);
    for (i, (at, text, ink)) in group.into_iter().enumerate() {
        let half = 0.5 * width(&text, TICK);
        let (middle, row) = match (count, leftwards) {
            (1, _) => (at.min(high - half + 10.0).max(low + half - 10.0), 0),
            (_, false) => (at + half - 2.0, count - 1 - i),
            (_, true) => (at - half + 2.0, i),
        };
        placed.push((at, middle, row, text, ink));
    }
}

/// Moves sorted labels apart within a range.
fn apart(labels: &mut [(f64, String, Ink)], low: f64, high: f64) {
    for i in 1..labels.len() {
        labels[i].0 = labels[i].0.max(labels[i - 1].0 + SPACING);
    }
    let mut limit = high;
    for label in labels.iter_mut().rev() {
        label.0 = label.0.min(limit);
        limit = label.0 - SPACING;
    }
    let mut limit = low;
    for label in labels.iter_mut() {
        label.0 = label.0.max(limit);
        limit = label.0 + SPACING;
    }
}

/// The last point of a line within the unit square.
fn exit(a: [f64; 2], b: [f64; 2]) -> Option<[f64; 2]> {
    inside(a, b).map(|[_, last]| [0, 1].map(|k| a[k] + last * (b[k] - a[k])))
}

/// The shares of a line between which it lies within the unit square.   Source: Liang and Barsky 1984.
pub(crate) fn inside([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> Option<[f64; 2]> {
    let (mut first, mut last) = (0.0f64, 1.0f64);
    for (a, d) in [(ax, bx - ax), (ay, by - ay)] {
        if d == 0.0 {
            if !(0.0..=1.0).contains(&a) {
                return None;
            }
            continue;
        }
        let [one, other] = [-a / d, (1.0 - a) / d];
        first = first.max(one.min(other));
        last = last.min(one.max(other));
    }
    (first <= last).then_some([first, last])
}
