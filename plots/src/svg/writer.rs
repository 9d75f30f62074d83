//! A writer of SVG.

use std::fmt::Write;

/// An SVG that grows element by element.
#[derive(Default)]
pub(crate) struct Svg {
    body: String,
    clips: usize,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stroke<'c> {
    pub(crate) colour: &'c str,
    pub(crate) width: f64,
    pub(crate) dash: &'c str,
}

/// Where a text stands relative to its point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// A number with two decimals at most.
pub(crate) fn number(x: f64) -> String {
    let text = format!("{x:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" || text.is_empty() { "0".into() } else { text.into() }
}

/// The points of a path: the first, then steps from point to point. Steps are taken between rounded points, so that their
/// rounding does not add up.
pub(crate) fn path(points: &[[f64; 2]], closed: bool) -> String {
    let mut d = String::with_capacity(12 * points.len());
    let mut last = [0.0; 2];
    for (i, point) in points.iter().enumerate() {
        let rounded = point.map(|x| (100.0 * x).round());
        let command = if i == 0 { "M" } else { "l" };
        let [x, y] = [0, 1].map(|k| number((rounded[k] - last[k]) / 100.0));
        let _ = write!(d, "{command}{x} {y}");
        last = rounded;
    }
    if closed {
        d.push('Z');
    }
    d
}

/// Stands for the name of the picture in names of its parts until it is known.
const NAME: char = '\u{1}';

impl Svg {
    pub(crate) fn fill(&mut self, d: &str, colour: &str, opacity: f64) {
        let opacity = if opacity < 1.0 { format!(" fill-opacity=\"{opacity}\"") } else { String::new() };
        let _ = writeln!(self.body, "<path d=\"{d}\" fill=\"{colour}\"{opacity}/>");
    }
    pub(crate) fn stroke(&mut self, d: &str, stroke: Stroke<'_>) {
        let dash = match stroke.dash {
            "" => String::new(),
            dash => format!(" stroke-dasharray=\"{dash}\""),
        };
        let _ = writeln!(
            self.body,
            "<path d=\"{d}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"{dash}/>",
            stroke.colour,
            number(stroke.width)
        );
    }
    /// Points with round ends: `d` is made of moves and lines of no length.
    pub(crate) fn specks(&mut self, d: &str, colour: &str, diameter: f64) {
        let _ = writeln!(
            self.body,
            "<path d=\"{d}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{}\" stroke-linecap=\"round\"/>",
            number(diameter)
        );
    }
    pub(crate) fn rectangle(&mut self, [x, y, w, h]: [f64; 4], colour: &str) {
        let [x, y, w, h] = [x, y, w, h].map(number);
        let _ =
            writeln!(self.body, "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"{colour}\"/>");
    }
    pub(crate) fn image(&mut self, [x, y, w, h]: [f64; 4], address: &str) {
        let [x, y, w, h] = [x, y, w, h].map(number);
        let _ = writeln!(
            self.body,
            "<image x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" preserveAspectRatio=\"none\" \
             style=\"image-rendering:pixelated\" href=\"{address}\"/>"
        );
    }
    /// A text whose baseline starts at a point; `turned`: reading upwards.
    pub(crate) fn text(
        &mut self,
        [x, y]: [f64; 2],
        text: &str,
        size: f64,
        anchor: Anchor,
        colour: &str,
        turned: bool,
    ) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (x, y) = (number(x), number(y));
        let turned = if turned { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
        let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        let size = number(size);
        let _ = writeln!(
            self.body,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{colour}\"{turned}>{text}</text>"
        );
    }
    /// A bold text.
    pub(crate) fn title(&mut self, [x, y]: [f64; 2], text: &str, size: f64, colour: &str) {
        self.body.push_str("<g font-weight=\"bold\">");
        self.text([x, y], text, size, Anchor::Start, colour, false);
        self.body.push_str("</g>\n");
    }
    /// Texts with a rim, over lines.
    pub(crate) fn halo(&mut self, rim: &str, draw: impl FnOnce(&mut Self)) {
        let _ = writeln!(
            self.body,
            "<g stroke=\"{rim}\" stroke-width=\"3\" stroke-linejoin=\"round\" paint-order=\"stroke\">"
        );
        draw(self);
        self.body.push_str("</g>\n");
    }
    /// Draws inside a rectangle only.
    pub(crate) fn clipped(&mut self, [x, y, w, h]: [f64; 4], draw: impl FnOnce(&mut Self)) {
        let [x, y, w, h] = [x, y, w, h].map(number);
        let id = self.clips;
        self.clips += 1;
        let _ = writeln!(
            self.body,
            "<clipPath id=\"{NAME}{id}\"><rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/></clipPath>\n\
             <g clip-path=\"url(#{NAME}{id})\" stroke-linejoin=\"round\">"
        );
        draw(self);
        self.body.push_str("</g>\n");
    }
    /// An upright bar of colours, the first one at its foot.
    pub(crate) fn gradient(&mut self, [x, y, w, h]: [f64; 4], colours: &[String]) {
        let id = self.clips;
        self.clips += 1;
        let _ = write!(self.body, "<linearGradient id=\"{NAME}{id}\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">");
        for (i, colour) in colours.iter().enumerate() {
            let at = number(i as f64 / (colours.len() - 1).max(1) as f64);
            let _ = write!(self.body, "<stop offset=\"{at}\" stop-color=\"{colour}\"/>");
        }
        self.body.push_str("</linearGradient>\n");
        self.rectangle([x, y, w, h], &format!("url(#{NAME}{id})"));
    }
    /// The document of a size on a background.
    pub(crate) fn document(self, [width, height]: [f64; 2], background: &str) -> String {
        let [w, h] = [width, height].map(number);
        // Names differ between pictures, so that several can stand in one page of HTML.
        let hash = self
            .body
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
        let body = self.body.replace(NAME, &format!("c{hash:x}-"));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
             font-family=\"Helvetica,Arial,'DejaVu Sans',sans-serif\">\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"{background}\"/>\n{body}</svg>\n"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 300 steps of 0.004, each shorter than the rounding: their sum ends at the last point.
    #[test]
    fn the_rounding_of_steps_does_not_add_up() {
        let points: Vec<[f64; 2]> = (0..=300).map(|i| [0.004 * f64::from(i), 5.0]).collect();
        let d = path(&points, false);
        let (start, steps) = d.split_once('l').unwrap();
        assert_eq!(start, "M0 5");
        let sum: f64 =
            steps.split('l').map(|step| step.split(' ').next().unwrap().parse::<f64>().unwrap()).sum();
        assert!((sum - 1.2).abs() < 0.005, "{sum}");
        assert!(path(&points, true).ends_with('Z'));
    }
}
