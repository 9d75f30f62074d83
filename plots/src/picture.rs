//! A picture: panels in rows, as SVG.

use crate::draw::colours::{Ink, Theme};
use crate::draw::frame::{Frame, Margins};
use crate::draw::paint::draw;
use crate::error::PlotError;
use crate::panel::Panel;
use crate::svg::writer::Svg;
use std::fs;
use std::path::Path;

/// Panels in rows. Several panels are lettered (a), (b), ....
///
/// ```
/// use gear_dynamics_plots::{Picture, Mark, Panel};
/// let panel = |speed: f64| {
///     let title = format!("{speed} rad/s");
///     Panel::new(title, "time [s]", "deflection [m]")?.series("", Mark::Line, [(0.0, 1e-5), (1.0, 2e-5)])
/// };
/// let picture = Picture::new([panel(140.0)?, panel(160.0)?]).columns(2);
/// let svg = picture.to_svg();
/// assert!(svg.contains("(b) 160 rad/s") && svg.contains("[μm]"));
/// assert!(picture.save("no such folder/picture.svg").is_err());
/// # Ok::<(), gear_dynamics_plots::PlotError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Picture {
    panels: Vec<Panel>,
    columns: usize,
    theme: Theme,
    size: [f64; 2],
}

impl From<Panel> for Picture {
    fn from(panel: Panel) -> Self {
        Picture::new([panel])
    }
}

impl Picture {
    /// A picture of panels below one another.
    pub fn new(panels: impl IntoIterator<Item = Panel>) -> Self {
        let panels = panels.into_iter().collect();
        Picture { panels, columns: 1, theme: Theme::Light, size: [440.0, 300.0] }
    }
    /// The same picture with rows of several panels. Default: 1.
    pub fn columns(self, columns: usize) -> Self {
        Picture { columns: columns.max(1), ..self }
    }
    /// The same picture on another background. Default: light.
    pub fn theme(self, theme: Theme) -> Self {
        Picture { theme, ..self }
    }
    /// The same picture with another size of each panel, in points of 1/96 inch, at least 200 x 150. Default: 440 x
    /// 300.
    pub fn panel_size(self, width: f64, height: f64) -> Self {
        // A number that is not finite gives the least size.
        Picture {
            size: [width.clamp(200.0, 4000.0).max(200.0), height.clamp(150.0, 4000.0).max(150.0)],
            ..self
        }
    }

    /// The picture as text of an SVG file.
    pub fn to_svg(&self) -> String {
        let columns = self.columns.min(self.panels.len()).max(1);
        let rows = self.panels.len().div_ceil(columns);
        let letter = |i: usize| match (self.panels.len(), u8::try_from(i)) {
            (2..=26, Ok(i)) => format!("({}) ", char::from(b'a' + i)),
            _ => String::new(),
        };
        let frames: Vec<Frame<'_>> =
            self.panels.iter().enumerate().map(|(i, panel)| Frame::of(panel, letter(i), self.size)).collect();
        // Panels of a column have the same left and right border.
        let mut sides = vec![Margins::default(); columns];
        for (i, frame) in frames.iter().enumerate() {
            sides[i % columns] = sides[i % columns].larger(frame.sides(self.size[1]));
        }
        let heads: Vec<Margins> = (0..rows)
            .map(|row| {
                let of_row = frames.iter().enumerate().skip(row * columns).take(columns);
                of_row.fold(Margins::default(), |most, (i, frame)| {
                    most.larger(frame.heads(sides[i % columns], self.size))
                })
            })
            .collect();
        let mut svg = Svg::default();
        for (i, frame) in frames.into_iter().enumerate() {
            let (row, column) = (i / columns, i % columns);
            let corner = [column as f64 * self.size[0], row as f64 * self.size[1]];
            draw(&mut svg, self.theme, frame, heads[row].larger(sides[column]), corner, self.size);
        }
        let size = [self.size[0] * columns as f64, self.size[1] * rows as f64];
        svg.document(size, &self.theme.colour(Ink::Paper))
    }

    /// Writes the picture to a file.
    ///
    /// # Errors
    /// [`PlotError::Empty`] for a picture without panels, [`PlotError::Write`] with the path.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), PlotError> {
        let path = path.as_ref();
        if self.panels.is_empty() {
            return Err(PlotError::Empty { what: format!("panels of {}", path.display()) });
        }
        fs::write(path, self.to_svg()).map_err(|source| PlotError::Write { path: path.into(), source })
    }
}
