//! What a panel contains.

use crate::draw::colours::Ink;

/// How a series of points is drawn.
///
/// Lines of one panel differ in colour and in dashes, dots in colour and in form: they can be told apart in grey.
///
/// ```
/// use gear_dynamics_plots::{Picture, Mark, Panel};
/// let lines = [(4.0, 2e-6), (8.0, 5e-7)];
/// let panel = Panel::new("", "order [1]", "amplitude [m]")?.series("mesh", Mark::Bars, lines)?;
/// assert!(Picture::from(panel).to_svg().contains("amplitude [μm]"));
/// # Ok::<(), gear_dynamics_plots::PlotError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A curve. The first one is solid, others have dashes of their own.
    Line,
    /// A thin dashed curve.
    Dashed,
    /// A solid curve with arrow heads in the order of its points; of two points, one head at the second.
    Directed,
    /// Dots with a rim.
    Dots,
    /// Open markers, which cover nothing.
    Rings,
    /// Dots with a rim that straight lines join: few computed values.
    Joined,
    /// Small dots, for many points.
    Specks,
    /// Bars from the foot of the panel, as in a spectrum.
    Bars,
    /// The area within a closed outline.
    Area,
}

/// One layer of a panel.
#[derive(Clone, Debug)]
pub(crate) enum Layer {
    Curve(Curve),
    /// Spans of x over the full height.
    Shade {
        ink: Ink,
        spans: Vec<[f64; 2]>,
    },
    Raster(Raster),
    /// Closed outlines.
    Outline {
        lines: Vec<Vec<[f64; 2]>>,
        fill: Option<(Ink, f64)>,
        stroke: Option<(Ink, f64)>,
    },
    /// A text inside the panel: beside a place, or on one of several.
    Note {
        places: Vec<[f64; 2]>,
        text: String,
    },
    /// A name where a straight line leaves the panel.
    Exit {
        from: [f64; 2],
        to: [f64; 2],
        text: String,
        ink: Ink,
    },
    /// A measure beside the panel: a length along y and its meaning.
    Height {
        length: f64,
        text: String,
    },
}

impl Layer {
    /// What nothing covers: located points, which are no series of the user.
    pub(crate) fn is_raised(&self) -> bool {
        match self {
            Layer::Curve(curve) => {
                matches!(curve.mark, Mark::Dots | Mark::Rings) && !matches!(curve.ink, Ink::Series(_))
            }
            _ => false,
        }
    }
}

/// A series of points.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    pub(crate) mark: Mark,
    pub(crate) ink: Ink,
    /// Number of the dash or form.
    pub(crate) style: usize,
    pub(crate) width: f64,
    pub(crate) points: Vec<[f64; 2]>,
}

/// Values in the cells of a grid.
#[derive(Clone, Debug)]
pub(crate) struct Raster {
    /// Borders of the cells along x and y, one more than cells.
    pub(crate) borders: [Vec<f64>; 2],
    /// Values, y fastest; NaN: no result.
    pub(crate) values: Vec<f64>,
    /// The colours of whole numbers, which are drawn as areas; none: the bar of the panel gives colours.
    pub(crate) inks: Vec<Ink>,
}

/// An entry of a legend.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry {
    pub(crate) label: String,
    pub(crate) swatch: Swatch,
}

/// The sample beside the text of a legend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Swatch {
    Line { ink: Ink, style: usize, width: f64, cased: bool },
    Directed { ink: Ink },
    Dot { ink: Ink, style: usize },
    Ring { ink: Ink, style: usize },
    Joined { ink: Ink, style: usize },
    Speck { ink: Ink, cased: bool },
    Field { ink: Ink, opacity: f64 },
}

impl Swatch {
    /// The same sample in another ink.
    pub(crate) fn inked(mut self, other: Ink) -> Self {
        match &mut self {
            Swatch::Line { ink, .. }
            | Swatch::Directed { ink }
            | Swatch::Dot { ink, .. }
            | Swatch::Ring { ink, .. }
            | Swatch::Joined { ink, .. }
            | Swatch::Speck { ink, .. }
            | Swatch::Field { ink, .. } => *ink = other,
        }
        self
    }
}

/// The colours of a map with their values.
#[derive(Clone, Debug)]
pub(crate) struct Bar {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) range: [f64; 2],
    pub(crate) logarithmic: bool,
}

/// The place in which a share of the range lies, from 0 to 1.
pub(crate) fn share(value: f64, [low, high]: [f64; 2], logarithmic: bool) -> f64 {
    if logarithmic { (value / low).ln() / (high / low).ln() } else { (value - low) / (high - low) }
}

/// The dashes of the series, by number.
pub(crate) const DASHES: [&str; 6] = ["", "6 3", "9 3 1.6 3", "1.6 2.4", "3 2", "12 4"];
/// The dash of [`Mark::Dashed`].
pub(crate) const THIN_DASH: &str = "4.5 3";
/// Style numbers from which on the thin dash is drawn.
pub(crate) const THIN: usize = 100;

pub(crate) fn dash(style: usize) -> &'static str {
    if style >= THIN { THIN_DASH } else { DASHES[style % DASHES.len()] }
}
