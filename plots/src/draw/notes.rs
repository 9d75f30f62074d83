//! Places of texts inside a panel: where they cover least.

use crate::draw::labels::inside;
use crate::draw::shown::TICK;
use crate::svg::text::width;
use crate::svg::writer::Anchor;

/// What a text should not cover, in points of the picture.
#[derive(Default)]
pub(crate) struct Taken {
    lines: Vec<[[f64; 2]; 2]>,
    /// Left, top, right, bottom.
    boxes: Vec<[f64; 4]>,
}

/// Half of the space of a marker.
const MARKER: f64 = 4.0;
/// What it costs to cover a marker or another text, and to leave the panel, in points of covered line.
const COVERS: f64 = 60.0;
const LEAVES: f64 = 1e4;
/// What the last place costs more than the first one.
const LATER: f64 = 4.0;

impl Taken {
    pub(crate) fn line(&mut self, points: &[[f64; 2]]) {
        self.lines.extend(points.windows(2).map(|two| [two[0], two[1]]));
    }
    pub(crate) fn marker(&mut self, [x, y]: [f64; 2]) {
        self.boxes.push([x - MARKER, y - MARKER, x + MARKER, y + MARKER]);
    }

    /// The baseline and the anchor of a text, of several `places` the one where it covers least. `inner`: the
    /// rectangle of the axes. Later texts do not cover this one.
    pub(crate) fn place(
        &mut self,
        text: &str,
        places: &[([f64; 2], Anchor)],
        inner: [f64; 4],
    ) -> Option<([f64; 2], Anchor)> {
        let cost = |place: &([f64; 2], Anchor)| self.cost(rectangle(text, *place), inner);
        let later = |i: usize| LATER * i as f64 / places.len() as f64;
        let costs = places.iter().map(cost).enumerate().map(|(i, cost)| cost + later(i));
        let best = costs.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| places[i])?;
        self.boxes.push(rectangle(text, best));
        Some(best)
    }

    fn cost(&self, own: [f64; 4], [x, y, w, h]: [f64; 4]) -> f64 {
        let [left, top, right, bottom] = own;
        let leaves = left < x || right > x + w || top < y || bottom > y + h;
        let covers =
            |other: &&[f64; 4]| left < other[2] && other[0] < right && top < other[3] && other[1] < bottom;
        let covered = self.boxes.iter().filter(covers).count();
        let length = |[a, b]: &[[f64; 2]; 2]| {
            let unit = |p: &[f64; 2]| [(p[0] - left) / (right - left), (p[1] - top) / (bottom - top)];
            let share = inside(unit(a), unit(b)).map_or(0.0, |[first, last]| last - first);
            share * (b[0] - a[0]).hypot(b[1] - a[1])
        };
        let lines: f64 = self.lines.iter().map(length).sum();
        lines + COVERS * covered as f64 + if leaves { LEAVES } else { 0.0 }
    }
}

/// The places beside a point: right, left, above and below, then at the corners.
pub(crate) fn beside([x, y]: [f64; 2]) -> [([f64; 2], Anchor); 8] {
    let (above, below) = (y - 8.0, y + 16.0);
    [
        ([x + 7.0, y + 3.5], Anchor::Start),
        ([x - 7.0, y + 3.5], Anchor::End),
        ([x, above], Anchor::Middle),
        ([x, below], Anchor::Middle),
        ([x + 5.0, above], Anchor::Start),
        ([x - 5.0, above], Anchor::End),
        ([x + 5.0, below], Anchor::Start),
        ([x - 5.0, below], Anchor::End),
    ]
}

/// The rectangle of a text.
fn rectangle(text: &str, ([x, y], anchor): ([f64; 2], Anchor)) -> [f64; 4] {
    let wide = width(text, TICK);
    let left = match anchor {
        Anchor::Start => x,
        Anchor::Middle => x - 0.5 * wide,
        Anchor::End => x - wide,
    };
    [left - 1.0, y - 10.0, left + wide + 1.0, y + 3.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_evades_lines_and_the_border() {
        let mut taken = Taken::default();
        let inner = [0.0, 0.0, 200.0, 100.0];
        let at = [100.0, 50.0];
        taken.marker(at);
        taken.line(&[at, [200.0, 50.0]]);
        let left = taken.place("peak", &beside(at), inner);
        assert_eq!(left, Some(beside(at)[1])); // the line lies on the right
        assert_eq!(taken.place("peak", &beside(at), inner), Some(beside(at)[4])); // off the first text, too
        let corner = taken.place("peak", &beside([195.0, 4.0]), inner);
        assert_eq!(corner, Some(beside([195.0, 4.0])[7]));
        assert_eq!(taken.place("peak", &[], inner), None);
    }
}
