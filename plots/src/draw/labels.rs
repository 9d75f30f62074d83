//! Names above and beside a panel: of values of an axis, and of lines that leave the panel.

use crate::draw::colours::Ink;
use crate::draw::frame::{Shown, TICK};
use crate::draw::layers::Layer;
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

const SPACING: f64 = 11.5;

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
    let mut ends: Vec<f64> = Vec::new();
    let above: Vec<_> = above
        .into_iter()
        .map(|(at, text, ink)| {
            let half = 0.5 * width(&text, TICK);
            let middle = at.min(x0 + w - half + 10.0).max(x0 + half - 10.0);
            let row = ends.iter().position(|end| *end + 5.0 < middle - half).unwrap_or(ends.len());
            if row == ends.len() {
                ends.push(0.0);
            }
            ends[row] = middle + half;
            (at, middle, row, text, ink)
        })
        .collect();
    Labels { above, rows: ends.len(), beside }
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

/// The last point of a line within the unit square.   Source: Liang and Barsky 1984.
fn exit([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> Option<[f64; 2]> {
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
    (first <= last).then_some([ax + last * (bx - ax), ay + last * (by - ay)])
}
