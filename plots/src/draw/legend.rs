//! Legends: rows of entries above the panel, where they cover nothing.

use crate::draw::colours::{Ink, Theme};
use crate::draw::curve::{RING, head, marker};
use crate::draw::layers::{Entry, Swatch, dash};
use crate::svg::text::width;
use crate::svg::writer::{Anchor, Stroke, Svg, path};

const SIZE: f64 = 11.0;
/// Width of a sample of a line, and of one of a dot.
const SWATCH: f64 = 24.0;
const DOT: f64 = 10.0;
const GAP: f64 = 12.0;
pub(crate) const ROW: f64 = 15.0;
/// Ground of the samples of what is drawn over a map.
const MAP: Ink = Ink::Map(0.67);

/// The entries in rows of at most a width, each with its place along the row.
pub(crate) fn rows(entries: &[Entry], most: f64) -> Vec<Vec<(f64, &Entry)>> {
    let mut rows: Vec<Vec<(f64, &Entry)>> = Vec::new();
    let mut end = f64::INFINITY;
    for entry in entries {
        let own = wide(entry.swatch) + 4.0 + width(&entry.label, SIZE);
        if end + own > most {
            rows.push(Vec::new());
            end = 0.0;
        }
        if let Some(row) = rows.last_mut() {
            row.push((end, entry));
        }
        end += own + GAP;
    }
    rows
}

fn wide(swatch: Swatch) -> f64 {
    if matches!(swatch, Swatch::Dot { .. } | Swatch::Ring { .. } | Swatch::Speck { .. }) {
        DOT
    } else {
        SWATCH
    }
}

/// Draws rows whose upper left corner is given.
pub(crate) fn draw(svg: &mut Svg, theme: Theme, rows: &[Vec<(f64, &Entry)>], [x0, y0]: [f64; 2]) {
    let ink = theme.colour(Ink::Text);
    for (k, row) in rows.iter().enumerate() {
        let y = y0 + ROW * (k as f64 + 0.5);
        for (x, entry) in row {
            let x = x0 + x;
            sample(svg, theme, entry.swatch, [x, y]);
            svg.text([x + wide(entry.swatch) + 4.0, y + 3.5], &entry.label, SIZE, Anchor::Start, &ink, false);
        }
    }
}

/// A rectangle of a width, its left side at a point.
fn field([x, y]: [f64; 2], wide: f64) -> String {
    path(&[[x, y - 5.0], [x + wide, y - 5.0], [x + wide, y + 5.0], [x, y + 5.0]], true)
}

fn sample(svg: &mut Svg, theme: Theme, swatch: Swatch, [x, y]: [f64; 2]) {
    let centre = [x + 0.5 * wide(swatch), y];
    match swatch {
        Swatch::Line { ink, style, width, cased } => {
            let d = path(&[[x, y], [x + SWATCH, y]], false);
            let colour = theme.colour(ink);
            let stroke = Stroke { colour: &colour, width, dash: dash(style) };
            if cased {
                svg.fill(&field([x, y], SWATCH), &theme.colour(MAP), 1.0);
                svg.stroke(&d, Stroke { colour: "#ffffff", width: width + 2.2, dash: "" });
                svg.stroke(&d, Stroke { colour: "#000000", ..stroke });
            } else {
                svg.stroke(&d, stroke);
            }
        }
        Swatch::Directed { ink } => {
            let colour = theme.colour(ink);
            let stroke = Stroke { colour: &colour, width: 1.5, dash: "" };
            svg.stroke(&path(&[[x, y], [x + SWATCH, y]], false), stroke);
            svg.fill(&head(centre, 0.0), &colour, 1.0);
        }
        Swatch::Joined { ink, style } => {
            let colour = theme.colour(ink);
            let stroke = Stroke { colour: &colour, width: 1.2, dash: "" };
            svg.stroke(&path(&[[x, y], [x + SWATCH, y]], false), stroke);
            svg.fill(&marker(centre, style, 3.7), &theme.colour(Ink::Paper), 1.0);
            svg.fill(&marker(centre, style, 3.0), &colour, 1.0);
        }
        Swatch::Dot { ink, style } => svg.fill(&marker(centre, style, 3.4), &theme.colour(ink), 1.0),
        Swatch::Ring { ink, style } => {
            let colour = theme.colour(ink);
            svg.stroke(&marker(centre, style, RING), Stroke { colour: &colour, width: 1.3, dash: "" });
        }
        Swatch::Speck { ink, cased } => {
            if cased {
                svg.fill(&field([x, y], DOT), &theme.colour(MAP), 1.0);
                svg.fill(&marker(centre, 0, 1.8), "#ffffff", 1.0);
                svg.fill(&marker(centre, 0, 0.9), "#000000", 1.0);
            } else {
                svg.fill(&marker(centre, 0, 2.0), &theme.colour(ink), 1.0);
            }
        }
        Swatch::Field { ink, opacity } => {
            let d = field([x, y], SWATCH);
            svg.fill(&d, &theme.colour(ink), opacity);
            let colour = theme.colour(Ink::Grey);
            svg.stroke(&d, Stroke { colour: &colour, width: 0.5, dash: "" });
        }
    }
}
