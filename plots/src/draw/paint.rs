//! Draws a panel: layers, axes, texts.

use crate::draw::colours::{Ink, Theme};
use crate::draw::curve;
use crate::draw::frame::{BAR, Frame, LABEL, Margins, TITLE, TITLE_LINE, count};
use crate::draw::layers::{Layer, Mark, Raster, THIN, dash};
use crate::draw::legend;
use crate::draw::notes::{self, Taken};
use crate::draw::shown::{Shown, TICK};
use crate::svg::png::data_address;
use crate::svg::writer::{Anchor, Stroke, Svg, path};

/// Draws a panel in a rectangle of the picture.
pub(crate) fn draw(
    svg: &mut Svg,
    theme: Theme,
    frame: Frame<'_>,
    margins: Margins,
    corner: [f64; 2],
    size: [f64; 2],
) {
    let inner = margins.inner(corner, size);
    let frame = frame.fitted(inner[2], inner[3]);
    let painter = Painter { theme, inner, frame: &frame };
    let is_ground = |layer: &&Layer| matches!(layer, Layer::Shade { .. } | Layer::Raster(_));
    let cased = frame.panel.layers.iter().any(|layer| matches!(layer, Layer::Raster(_)));
    svg.clipped(inner, |svg| {
        frame.panel.layers.iter().filter(is_ground).for_each(|layer| painter.layer(svg, layer, cased));
        if !cased {
            painter.grid(svg);
        }
        painter.names(svg);
        for raised in [false, true] {
            let rest = frame.panel.layers.iter().filter(|layer| !is_ground(layer));
            rest.filter(|layer| layer.is_raised() == raised)
                .for_each(|layer| painter.layer(svg, layer, cased));
        }
        painter.notes(svg);
    });
    painter.axes(svg);
    painter.around(svg, corner, size);
    painter.head(svg, corner, margins);
}

/// Number of colours of a map.
const SHADES: u8 = 255;

struct Painter<'f, 'p> {
    theme: Theme,
    inner: [f64; 4],
    frame: &'f Frame<'p>,
}

impl Painter<'_, '_> {
    fn place(&self, point: [f64; 2]) -> [f64; 2] {
        self.frame.place(point, self.inner)
    }
    fn colour(&self, ink: Ink) -> String {
        self.theme.colour(ink)
    }
    fn line(&self, svg: &mut Svg, points: &[[f64; 2]], ink: Ink, width: f64, dash: &str) {
        svg.stroke(&path(points, false), Stroke { colour: &self.colour(ink), width, dash });
    }

    fn layer(&self, svg: &mut Svg, layer: &Layer, cased: bool) {
        let [_, y0, _, h] = self.inner;
        match layer {
            Layer::Curve(curve) => {
                let points: Vec<_> = curve.points.iter().map(|p| self.place(*p)).collect();
                let zero = self.frame.axes[1].range[0].max(0.0);
                let foot = if self.frame.axes[1].logarithmic { y0 + h } else { self.place([1.0, zero])[1] };
                curve::draw(svg, self.theme, curve, &points, foot, cased);
            }
            Layer::Shade { ink, spans } => {
                let mut d = String::new();
                for [from, to] in spans {
                    let [a, b] = [*from, *to].map(|x| self.place([x, self.frame.axes[1].range[0]])[0]);
                    d += &path(&[[a, y0], [b, y0], [b, y0 + h], [a, y0 + h]], true);
                }
                svg.fill(&d, &self.colour(*ink), 1.0);
            }
            Layer::Raster(raster) => self.raster(svg, raster),
            Layer::Outline { lines, fill, stroke } => {
                let mut d = String::new();
                for line in lines {
                    let points: Vec<_> = line.iter().map(|p| self.place(*p)).collect();
                    d += &path(&curve::simplified(&points), fill.is_some());
                }
                if let Some((ink, opacity)) = fill {
                    svg.fill(&d, &self.colour(*ink), *opacity);
                }
                if let Some((ink, width)) = stroke {
                    svg.stroke(&d, Stroke { colour: &self.colour(*ink), width: *width, dash: "" });
                }
            }
            Layer::Exit { from, to, ink, .. } => {
                self.line(svg, &[self.place(*from), self.place(*to)], *ink, 1.0, dash(THIN));
            }
            Layer::Note { .. } | Layer::Height { .. } => {}
        }
    }

    /// Texts inside the panel, above all else.
    fn notes(&self, svg: &mut Svg) {
        let mut taken = self.taken();
        for layer in &self.frame.panel.layers {
            let Layer::Note { places, text } = layer else { continue };
            let places: Vec<_> = match &places[..] {
                [one] => notes::beside(self.place(*one)).to_vec(),
                all => {
                    all.iter().map(|p| self.place(*p)).map(|[x, y]| ([x, y + 3.5], Anchor::Middle)).collect()
                }
            };
            if let Some((at, anchor)) = taken.place(text, &places, self.inner) {
                svg.halo(&self.colour(Ink::Paper), |svg| {
                    svg.text(at, text, TICK, anchor, &self.colour(Ink::Text), false);
                });
            }
        }
    }

    /// Lines and markers that texts should not cover.
    fn taken(&self) -> Taken {
        let mut taken = Taken::default();
        for layer in &self.frame.panel.layers {
            match layer {
                Layer::Curve(curve) => {
                    let points: Vec<_> = curve.points.iter().map(|p| self.place(*p)).collect();
                    match curve.mark {
                        Mark::Dots | Mark::Rings | Mark::Specks => {}
                        _ => taken.line(&points),
                    }
                    if matches!(curve.mark, Mark::Dots | Mark::Rings | Mark::Joined) {
                        points.into_iter().for_each(|point| taken.marker(point));
                    }
                }
                Layer::Outline { lines, .. } => {
                    for line in lines {
                        taken.line(&line.iter().map(|p| self.place(*p)).collect::<Vec<_>>());
                    }
                }
                _ => {}
            }
        }
        let [x0, y0, w, h] = self.inner;
        let [x, y] = &self.frame.axes;
        for (value, _) in &self.frame.panel.x.named {
            let at = x0 + w * x.share(*value);
            taken.line(&[[at, y0], [at, y0 + h]]);
        }
        for (value, _) in &self.frame.panel.y.named {
            let at = y0 + h * (1.0 - y.share(*value));
            taken.line(&[[x0, at], [x0 + w, at]]);
        }
        taken
    }

    fn raster(&self, svg: &mut Svg, raster: &Raster) {
        if raster.inks.is_empty() {
            self.shades(svg, raster);
        } else {
            self.areas(svg, raster);
        }
    }

    /// Kinds as areas with sharp borders. Each area lies on those of smaller numbers, so that no line shows between
    /// them.
    fn areas(&self, svg: &mut Svg, raster: &Raster) {
        let [xs, ys] = &raster.borders;
        let rows = ys.len() - 1;
        let kind = |value: f64| if value.is_nan() { raster.inks.len() } else { value as usize };
        let inks = raster.inks.iter().copied().chain([Ink::Missing]);
        for (number, ink) in inks.enumerate() {
            let mut d = String::new();
            for (column, values) in raster.values.chunks_exact(rows).enumerate() {
                let mut row = 0;
                // Neighbours in a column are one rectangle.
                for run in values.chunk_by(|a, b| (kind(*a) >= number) == (kind(*b) >= number)) {
                    let [low, high] = [ys[row], ys[row + run.len()]];
                    row += run.len();
                    if kind(run[0]) >= number {
                        let corners = [[xs[column], low], [xs[column + 1], high]].map(|p| self.place(p));
                        let [[left, bottom], [right, top]] = corners;
                        d += &path(&[[left, bottom], [right, bottom], [right, top], [left, top]], true);
                    }
                }
            }
            if !d.is_empty() {
                svg.fill(&d, &self.colour(ink), 1.0);
            }
        }
    }

    /// Values as pixels.
    fn shades(&self, svg: &mut Svg, raster: &Raster) {
        let [xs, ys] = &raster.borders;
        let (columns, rows) = (xs.len() - 1, ys.len() - 1);
        let [left, bottom] = self.place([xs[0], ys[0]]);
        let [right, top] = self.place([xs[columns], ys[rows]]);
        // Cells of equal size are some pixels each, since viewers mix neighbouring pixels; others are sampled.
        let pick = |borders: &[f64], axis: &Shown| -> Vec<usize> {
            let cells = borders.len() - 1;
            let shares: Vec<f64> = borders.iter().map(|border| axis.share(*border)).collect();
            let (first, wide) = (shares[0], shares[cells] - shares[0]);
            let is_even = |(i, share): (usize, &f64)| {
                (share - first - wide * i as f64 / cells as f64).abs() < 1e-6 * wide
            };
            if shares.iter().enumerate().all(is_even) {
                let each = (240 / cells).max(1);
                return (0..cells * each).map(|pixel| pixel / each).collect();
            }
            let pixels = (8 * cells).min(600);
            let of = |pixel: usize| {
                let at = first + wide * (pixel as f64 + 0.5) / pixels as f64;
                shares.partition_point(|share| *share <= at).clamp(1, cells) - 1
            };
            (0..pixels).map(of).collect()
        };
        let across = pick(xs, &self.frame.axes[0]);
        let up = pick(ys, &self.frame.axes[1]);
        let mut cells = Vec::with_capacity(across.len() * up.len());
        for row in up.iter().rev() {
            cells.extend(across.iter().map(|column| self.index(raster.values[column * rows + row])));
        }
        let inks = (0..SHADES).map(|i| Ink::Map(f64::from(i) / f64::from(SHADES - 1)));
        let colours: Vec<[u8; 3]> = inks.chain([Ink::Missing]).map(|ink| self.theme.rgb(ink)).collect();
        let address = data_address(across.len(), &cells, &colours);
        svg.image([left, top, right - left, bottom - top], &address);
    }

    /// The index of a value among the shades; the last one stands for no result.
    fn index(&self, value: f64) -> u8 {
        match &self.frame.bar {
            Some(bar) if value.is_finite() => {
                (bar.share(value).clamp(0.0, 1.0) * f64::from(SHADES - 1)).round() as u8
            }
            _ => SHADES,
        }
    }

    /// The number of labels along x and y.
    fn counts(&self) -> [f64; 2] {
        let widest = self.frame.axes[0].widest(count(self.inner[2], 60.0));
        [count(self.inner[2], (widest + 18.0).max(52.0)), count(self.inner[3], 27.0)]
    }

    fn grid(&self, svg: &mut Svg) {
        let [x0, y0, w, h] = self.inner;
        let [across, up] = self.counts();
        for (value, label) in self.frame.axes[0].ticks(across) {
            let x = x0 + w * self.frame.axes[0].share(value);
            if label.is_some() {
                self.line(svg, &[[x, y0], [x, y0 + h]], Ink::Faint, 0.6, "");
            }
        }
        for (value, label) in self.frame.axes[1].ticks(up) {
            let y = y0 + h * (1.0 - self.frame.axes[1].share(value));
            if label.is_some() {
                self.line(svg, &[[x0, y], [x0 + w, y]], Ink::Faint, 0.6, "");
            }
        }
    }

    /// Dotted lines of named values.
    fn names(&self, svg: &mut Svg) {
        let [x0, y0, w, h] = self.inner;
        for (value, _) in &self.frame.panel.x.named {
            let x = x0 + w * self.frame.axes[0].share(*value);
            self.line(svg, &[[x, y0], [x, y0 + h]], Ink::Grey, 0.8, "1.5 3");
        }
        for (value, _) in &self.frame.panel.y.named {
            let y = y0 + h * (1.0 - self.frame.axes[1].share(*value));
            self.line(svg, &[[x0, y], [x0 + w, y]], Ink::Grey, 0.8, "1.5 3");
        }
    }

    fn axes(&self, svg: &mut Svg) {
        let [x0, y0, w, h] = self.inner;
        let ink = self.colour(Ink::Text);
        let corners = [[x0, y0], [x0 + w, y0], [x0 + w, y0 + h], [x0, y0 + h]];
        svg.stroke(&path(&corners, true), Stroke { colour: &ink, width: 0.8, dash: "" });
        let [across, up] = self.counts();
        let mut d = String::new();
        for (value, label) in self.frame.axes[0].ticks(across) {
            let x = x0 + w * self.frame.axes[0].share(value);
            let length = if label.is_some() { 4.0 } else { 2.0 };
            d += &path(&[[x, y0 + h], [x, y0 + h + length]], false);
            if let Some(label) = label {
                svg.text([x, y0 + h + 15.5], &label, TICK, Anchor::Middle, &ink, false);
            }
        }
        for (value, label) in self.frame.axes[1].ticks(up) {
            let y = y0 + h * (1.0 - self.frame.axes[1].share(value));
            let length = if label.is_some() { 4.0 } else { 2.0 };
            d += &path(&[[x0 - length, y], [x0, y]], false);
            if let Some(label) = label {
                svg.text([x0 - 6.0, y + 3.5], &label, TICK, Anchor::End, &ink, false);
            }
        }
        svg.stroke(&d, Stroke { colour: &ink, width: 0.8, dash: "" });
        let [x, y] = &self.frame.axes;
        svg.text([x0 + 0.5 * w, y0 + h + 33.0], &x.text, LABEL, Anchor::Middle, &ink, false);
        let left = x0 - 12.0 - y.widest(up);
        svg.text([left, y0 + 0.5 * h], &y.text, LABEL, Anchor::Middle, &ink, true);
    }

    /// Names beside and above the axes, the bar of colours, a measure.
    fn around(&self, svg: &mut Svg, corner: [f64; 2], size: [f64; 2]) {
        let [x0, y0, w, h] = self.inner;
        let labels = self.frame.labels(self.inner);
        for (y, text, ink) in &labels.beside {
            svg.text([x0 + w + 6.0, y + 3.5], text, TICK, Anchor::Start, &self.colour(*ink), false);
        }
        for (at, middle, row, text, ink) in &labels.above {
            let y = y0 - 5.0 - 12.0 * *row as f64;
            if *row > 0 {
                self.line(svg, &[[*at, y0], [*at, y + 2.0]], Ink::Grey, 0.5, "");
            }
            svg.text([*middle, y], text, TICK, Anchor::Middle, &self.colour(*ink), false);
        }
        let ink = self.colour(Ink::Text);
        for layer in &self.frame.panel.layers {
            let Layer::Height { length, text } = layer else { continue };
            let x = x0 + w + 10.0;
            let range = self.frame.axes[1].range;
            let top = y0 + h * (1.0 - length / (range[1] - range[0]));
            let d = path(&[[x - 3.0, top], [x + 3.0, top]], false)
                + &path(&[[x, top], [x, y0 + h]], false)
                + &path(&[[x - 3.0, y0 + h], [x + 3.0, y0 + h]], false);
            svg.stroke(&d, Stroke { colour: &ink, width: 1.2, dash: "" });
            svg.text([x + 14.0, y0 + h], text, TICK, Anchor::Start, &ink, true);
        }
        let Some(bar) = &self.frame.bar else { return };
        let up = count(h, 27.0);
        // From the right border: the text, the labels, the bar.
        let right = corner[0] + size[0] - 8.0;
        let left = right - 16.0 - bar.widest(up) - 6.0 - BAR;
        let colours: Vec<String> = (0..=18).map(|i| self.colour(Ink::Map(f64::from(i) / 18.0))).collect();
        svg.gradient([left, y0, BAR, h], &colours);
        let corners = [[left, y0], [left + BAR, y0], [left + BAR, y0 + h], [left, y0 + h]];
        let stroke = Stroke { colour: &ink, width: 0.8, dash: "" };
        svg.stroke(&path(&corners, true), stroke);
        let mut d = String::new();
        for (value, label) in bar.ticks(up) {
            let y = y0 + h * (1.0 - bar.share(value));
            let length = if label.is_some() { 4.0 } else { 2.0 };
            d += &path(&[[left + BAR, y], [left + BAR + length, y]], false);
            if let Some(label) = label {
                svg.text([left + BAR + 6.0, y + 3.5], &label, TICK, Anchor::Start, &ink, false);
            }
        }
        svg.stroke(&d, stroke);
        svg.text([right, y0 + 0.5 * h], &bar.text, LABEL, Anchor::Middle, &ink, true);
    }

    /// Title and legend.
    fn head(&self, svg: &mut Svg, corner: [f64; 2], margins: Margins) {
        let ink = self.colour(Ink::Text);
        let mut y = corner[1] + 8.0;
        for line in &self.frame.title {
            svg.title([corner[0] + 10.0, y + 11.0], line, TITLE, &ink);
            y += TITLE_LINE;
        }
        let rows = legend::rows(&self.frame.panel.legend, self.inner[2] + margins.right - 8.0);
        // The legend stands directly above the names and the axes.
        let names = 12.0 * self.frame.labels(self.inner).rows as f64;
        let top = self.inner[1] - 5.0 - names - legend::ROW * rows.len() as f64;
        legend::draw(svg, self.theme, &rows, [self.inner[0], top.max(y)]);
    }
}
