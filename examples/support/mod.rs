//! Shared by the examples: output folder, CSV files, SVG figures of panels and maps, progress bar.
#![allow(dead_code, reason = "each example uses some of these")]

use indicatif::{ProgressBar, ProgressStyle};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use std::error::Error;
use std::fs::{File, create_dir_all};
use std::io::BufWriter;
use std::path::PathBuf;

pub type Outcome<T> = Result<T, Box<dyn Error>>;

/// The folder `target/gallery/<example>/`, which is created.
pub fn gallery(example: &str) -> Outcome<PathBuf> {
    let folder = PathBuf::from("target/gallery").join(example);
    create_dir_all(&folder)?;
    Ok(folder)
}

/// Whether a short run is requested by `-- --coarse`: fewer points, the same steps.
#[allow(dead_code, reason = "only long examples have a short run")]
pub fn coarse() -> bool {
    std::env::args().any(|arg| arg == "--coarse")
}

pub type Csv = gear_dynamics::export::Csv<BufWriter<File>>;

/// A file of comma-separated values; `header` are the names of its columns, with commas.
pub fn csv_file(path: PathBuf, header: &str) -> Outcome<Csv> {
    Ok(Csv::new(BufWriter::new(File::create(path)?), &header.split(',').collect::<Vec<_>>())?)
}

pub fn progress(what: &str, count: usize) -> ProgressBar {
    let style =
        ProgressStyle::with_template("{msg:28} {bar:40} {pos}/{len} {eta}").expect("the template is fixed");
    ProgressBar::new(count as u64).with_style(style).with_message(what.to_owned())
}

pub enum Mark {
    Line,
    /// A solid curve in pieces, which values that are not finite separate.
    Solid,
    /// A dashed curve in pieces.
    Dashed,
    Dots,
    /// Dots with a white rim, over curves.
    Points,
    /// Dots of one pixel, for many points.
    Specks,
    /// Vertical bars from the bottom of the panel, as in a spectrum.
    Bars,
    /// The area within a closed outline.
    Area,
}

pub struct Series {
    pub label: String,
    pub mark: Mark,
    pub points: Vec<(f64, f64)>,
}

pub struct Panel {
    title: String,
    x: String,
    y: String,
    logarithmic: bool,
    labels: SeriesLabelPosition,
    /// Empty space above, as a share of the range.
    headroom: f64,
    series: Vec<Series>,
}

impl Panel {
    pub fn new(title: impl Into<String>, x: &str, y: &str) -> Self {
        Panel {
            title: title.into(),
            x: x.into(),
            y: y.into(),
            logarithmic: false,
            labels: SeriesLabelPosition::UpperLeft,
            headroom: 0.0,
            series: Vec::new(),
        }
    }
    /// A logarithmic ordinate; the points contain log10 of the values.
    pub fn decades(self) -> Self {
        Panel { logarithmic: true, ..self }
    }
    /// Places the labels in a corner.
    pub fn labels_at(self, labels: SeriesLabelPosition) -> Self {
        Panel { labels, ..self }
    }
    /// Adds space for the labels above the curves, as a share of the range.
    pub fn headroom(self, headroom: f64) -> Self {
        Panel { headroom, ..self }
    }
    pub fn with(mut self, label: impl Into<String>, mark: Mark, points: Vec<(f64, f64)>) -> Self {
        self.series.push(Series { label: label.into(), mark, points });
        self
    }

    fn range(&self, of: impl Fn(&(f64, f64)) -> f64, margin: f64) -> std::ops::Range<f64> {
        let all = self.series.iter().flat_map(|s| &s.points).map(of).filter(|x| x.is_finite());
        let (lo, hi) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)));
        let width = if hi > lo { hi - lo } else { lo.abs().max(1e-12) };
        lo - margin * width..hi + margin * width
    }
}

/// Colours that everybody can distinguish.   Source: Okabe & Ito, Color Universal Design, 2008.
const PALETTE: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
];

/// Draws panels in rows of `columns`.
pub fn figure(path: PathBuf, columns: usize, panels: &[Panel]) -> Outcome<()> {
    const SIZE: (u32, u32) = (620, 330);
    let rows = panels.len().div_ceil(columns);
    let root = SVGBackend::new(&path, (SIZE.0 * columns as u32, SIZE.1 * rows as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    for (area, panel) in root.split_evenly((rows, columns)).iter().zip(panels) {
        let (across, mut up) = (panel.range(|p| p.0, 0.0), panel.range(|p| p.1, 0.06));
        if panel.series.iter().any(|s| matches!(s.mark, Mark::Bars)) {
            up.start = 0.0;
        }
        let foot = up.start;
        up.end += panel.headroom * (up.end - up.start);
        let smallest = 1e-9 * (up.end - up.start).min(across.end - across.start);
        let mut chart = ChartBuilder::on(area)
            .caption(&panel.title, ("sans-serif", 16))
            .margin(12)
            .x_label_area_size(38)
            .y_label_area_size(72)
            .build_cartesian_2d(across, up)?;
        let decades = |y: &f64| format!("{:.0e}", 10f64.powf(*y));
        let plain = |x: &f64| match x.abs() {
            size if size < smallest => "0".into(),
            size if (1e-2..1e5).contains(&size) => format!("{}", (x * 1e4).round() / 1e4),
            _ => format!("{x:.1e}"),
        };
        let mut mesh = chart.configure_mesh();
        mesh.light_line_style(WHITE)
            .x_desc(&panel.x)
            .y_desc(&panel.y)
            .x_labels(8)
            .y_labels(6)
            .x_label_formatter(&plain);
        if panel.logarithmic {
            mesh.y_label_formatter(&decades).draw()?
        } else {
            mesh.y_label_formatter(&plain).draw()?
        }
        for (i, series) in panel.series.iter().enumerate() {
            let color = PALETTE[i % PALETTE.len()].to_rgba();
            let points = series.points.iter().copied().filter(|p| p.1.is_finite());
            let drawn =
                match series.mark {
                    Mark::Line => chart.draw_series(LineSeries::new(points, color.stroke_width(1)))?,
                    Mark::Solid => chart.draw_series(
                        pieces(&series.points).map(|piece| PathElement::new(piece, color.stroke_width(2))),
                    )?,
                    Mark::Dashed => chart.draw_series(
                        pieces(&series.points)
                            .map(|piece| DashedPathElement::new(piece, 5, 4, color.stroke_width(1))),
                    )?,
                    Mark::Points => chart.draw_series(points.flat_map(|p| {
                        [Circle::new(p, 5, WHITE.filled()), Circle::new(p, 4, color.filled())]
                    }))?,
                    // Later dots are smaller, so that earlier ones remain visible.
                    Mark::Dots => chart.draw_series(
                        points.map(|p| Circle::new(p, if i == 0 { 4 } else { 2 }, color.filled())),
                    )?,
                    Mark::Specks => {
                        chart.draw_series(points.map(|p| Circle::new(p, 1, color.mix(0.6).filled())))?
                    }
                    Mark::Area => chart
                        .draw_series([Polygon::new(points.collect::<Vec<_>>(), color.mix(0.4).filled())])?,
                    Mark::Bars => chart.draw_series(
                        points.map(|(x, y)| PathElement::new([(x, foot), (x, y)], color.stroke_width(1))),
                    )?,
                };
            if !series.label.is_empty() {
                drawn
                    .label(&series.label)
                    .legend(move |(x, y)| Rectangle::new([(x, y - 3), (x + 12, y + 3)], color.filled()));
            }
        }
        if panel.series.iter().any(|s| !s.label.is_empty()) {
            let place = panel.labels.clone();
            chart
                .configure_series_labels()
                .position(place)
                .background_style(WHITE.mix(0.8))
                .label_font(("sans-serif", 12))
                .draw()?;
        }
    }
    root.present()?;
    Ok(())
}

/// The pieces of a curve between values that are not finite.
fn pieces(points: &[(f64, f64)]) -> impl Iterator<Item = Vec<(f64, f64)>> {
    points.split(|p| !(p.0.is_finite() && p.1.is_finite())).filter(|piece| piece.len() > 1).map(<[_]>::to_vec)
}

/// Minimum and maximum in each of `bins` equal spans of time: a line through a long oscillation.
pub fn envelope(times: &[f64], values: &[f64], bins: usize) -> Vec<(f64, f64)> {
    let size = times.len().div_ceil(bins).max(1);
    times
        .chunks(size)
        .zip(values.chunks(size))
        .flat_map(|(t, x)| {
            let (lo, hi) =
                x.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(*x), hi.max(*x)));
            [(t[0], lo), (t[0], hi)]
        })
        .collect()
}

/// Values over a grid; the vertical axis varies fastest.
pub struct Map {
    pub title: String,
    /// Name, start and end of the axes.
    pub across: (&'static str, f64, f64),
    pub up: (&'static str, f64, f64),
    pub columns: usize,
    pub values: Vec<f64>,
}

/// Draws maps in rows of two, each with a scale of its colours.
pub fn maps(path: PathBuf, all: &[Map]) -> Outcome<()> {
    maps_under(path, all, &[])
}

/// Draws maps as [`maps`], and over each of them the curves: in white those of even index, in red the others.
pub fn maps_under(path: PathBuf, all: &[Map], curves: &[Vec<(f64, f64)>]) -> Outcome<()> {
    const SIZE: (u32, u32) = (560, 420);
    let root =
        SVGBackend::new(&path, (2 * SIZE.0, SIZE.1 * all.len().div_ceil(2) as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    for (area, map) in root.split_evenly((all.len().div_ceil(2), 2)).iter().zip(all) {
        let finite = || map.values.iter().copied().filter(|x| x.is_finite());
        let (lo, hi) =
            finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)));
        let hi = if hi > lo { hi } else { lo + 1.0 };
        // Up to 17 whole numbers are separate boxes, other values a continuous scale.
        let whole = finite().all(|x| x.fract() == 0.0) && hi - lo < 17.0;
        let color =
            |x: f64| if x.is_finite() { shade((x - lo) / (hi - lo)).filled() } else { WHITE.filled() };
        let (picture, scale) = area.split_horizontally(SIZE.0 - 84);
        let rows = map.values.len() / map.columns;
        let mut chart = ChartBuilder::on(&picture)
            .caption(&map.title, ("sans-serif", 15))
            .margin(10)
            .x_label_area_size(36)
            .y_label_area_size(46)
            .build_cartesian_2d(map.across.1..map.across.2, map.up.1..map.up.2)?;
        chart.configure_mesh().disable_mesh().x_desc(map.across.0).y_desc(map.up.0).draw()?;
        let (dx, dy) =
            ((map.across.2 - map.across.1) / map.columns as f64, (map.up.2 - map.up.1) / rows as f64);
        // Neighbours of one colour become one rectangle.
        for column in 0..map.columns {
            let values = &map.values[column * rows..][..rows];
            let x = map.across.1 + column as f64 * dx;
            let mut from = 0;
            for to in 1..=rows {
                if to == rows || values[to].to_bits() != values[from].to_bits() {
                    let corner = |row: usize| map.up.1 + row as f64 * dy;
                    // The rectangle extends over a part of the next one, so that no line shows between them.
                    let far = (x + 1.5 * dx, corner(to) + 0.5 * dy);
                    let far = (far.0.min(map.across.2), far.1.min(map.up.2));
                    chart.draw_series([Rectangle::new([(x, corner(from)), far], color(values[from]))])?;
                    from = to;
                }
            }
        }
        for (i, curve) in curves.iter().enumerate() {
            let within = |x: f64, lo: f64, hi: f64| (lo..=hi).contains(&x);
            let gap = (f64::NAN, f64::NAN);
            let inside = |p: &(f64, f64)| {
                let seen = within(p.0, map.across.1, map.across.2) && within(p.1, map.up.1, map.up.2);
                if seen { *p } else { gap }
            };
            let curve: Vec<_> = curve.iter().map(inside).collect();
            let color = if i % 2 == 0 { WHITE } else { RED };
            chart.draw_series(pieces(&curve).map(|piece| PathElement::new(piece, color.stroke_width(2))))?;
        }
        let (foot, head) = if whole { (lo - 0.5, hi + 0.5) } else { (lo, hi) };
        let mut bar = ChartBuilder::on(&scale)
            .margin_top(44)
            .margin_bottom(46)
            .margin_right(8)
            .y_label_area_size(44)
            .build_cartesian_2d(0.0..1.0, foot..head)?;
        let mut mesh = bar.configure_mesh();
        mesh.disable_mesh().disable_x_axis().y_label_style(("sans-serif", 12));
        if whole {
            mesh.y_labels((hi - lo) as usize + 1).y_label_formatter(&|y: &f64| format!("{y:.0}")).draw()?;
        } else {
            mesh.y_labels(6).draw()?;
        }
        let boxes = if whole { (hi - lo) as u32 + 1 } else { 64 };
        let step = (head - foot) / f64::from(boxes);
        bar.draw_series((0..boxes).map(|i| {
            let y = foot + f64::from(i) * step;
            let over = if whole { 1.0 } else { 1.5 };
            Rectangle::new(
                [(0.0, y), (1.0, (y + over * step).min(head))],
                color((y + 0.5 * step).clamp(lo, hi)),
            )
        }))?;
    }
    root.present()?;
    Ok(())
}

/// Colours from dark blue through green to yellow, for shares from 0 to 1.
fn shade(share: f64) -> RGBColor {
    const STOPS: [[f64; 3]; 5] = [
        [68.0, 1.0, 84.0],
        [59.0, 82.0, 139.0],
        [33.0, 145.0, 140.0],
        [94.0, 201.0, 98.0],
        [253.0, 231.0, 37.0],
    ];
    let at = share.clamp(0.0, 1.0) * 3.999_999;
    let (a, b, f) = (STOPS[at as usize], STOPS[at as usize + 1], at.fract());
    let mix = |i: usize| (a[i] + (b[i] - a[i]) * f).round() as u8;
    RGBColor(mix(0), mix(1), mix(2))
}
