//! Colours of both themes.

/// Light or dark background.
///
/// ```
/// use gear_dynamics_plots::{Picture, Mark, Panel, Theme};
/// let panel = Panel::new("", "time [s]", "force [N]")?.series("", Mark::Line, [(0.0, 1.0), (1.0, 2.0)])?;
/// let picture = Picture::from(panel).theme(Theme::Dark);
/// assert!(picture.to_svg().contains("#15181d"));
/// # Ok::<(), gear_dynamics_plots::PlotError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Theme {
    /// Dark ink on white.
    #[default]
    Light,
    /// Light ink on nearly black.
    Dark,
}

/// What a colour is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ink {
    /// Background.
    Paper,
    /// Text and axes.
    Text,
    /// Secondary lines.
    Grey,
    /// Grid lines.
    Faint,
    /// Bodies at rest.
    Solid,
    /// The gap of a contact.
    Gap,
    /// The lower flank of a contact.
    Flank,
    /// Series by number.
    Series(usize),
    /// The map of colours, from 0 to 1.
    Map(f64),
    /// A place without result; lines at rest.
    Missing,
}

/// Colours that everybody can distinguish, in an order of alternating lightness.   Source: Okabe & Ito, Color
/// Universal Design, 2008.
const ON_LIGHT: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#a64d84", "#b07c00", "#2f9bd6"];
const ON_DARK: [&str; 6] = ["#56b4e9", "#f08a3c", "#2fc797", "#e59ecb", "#f0e442", "#9ad0f5"];

impl Theme {
    pub(crate) fn colour(self, ink: Ink) -> String {
        let by = |light: &str, dark: &str| if self == Theme::Light { light } else { dark }.to_owned();
        match ink {
            Ink::Paper => by("#ffffff", "#15181d"),
            Ink::Text => by("#1c1c1c", "#e8e8e8"),
            Ink::Grey => by("#6a6a6a", "#a2a7af"),
            Ink::Faint => by("#e4e4e4", "#2c3138"),
            Ink::Solid => by("#dcdfe3", "#39404a"),
            Ink::Gap => by("#cfd2d6", "#474e59"),
            Ink::Flank => by("#fbe3cd", "#3b2a1c"),
            Ink::Missing => by("#b9b9b9", "#5a5a5a"),
            Ink::Series(i) => by(ON_LIGHT[i % 6], ON_DARK[i % 6]),
            Ink::Map(share) => {
                let [r, g, b] = viridis(share);
                format!("#{r:02x}{g:02x}{b:02x}")
            }
        }
    }
    pub(crate) fn rgb(self, ink: Ink) -> [u8; 3] {
        let colour = self.colour(ink);
        [1, 3, 5].map(|i| u8::from_str_radix(&colour[i..i + 2], 16).unwrap_or(0))
    }
}

/// Perceptually uniform colours, whose lightness increases with the share.   Source: viridis, van der Walt and
/// Smith 2015; ten of its colours, linear between them.
fn viridis(share: f64) -> [u8; 3] {
    #[rustfmt::skip]
    const STOPS: [[f64; 3]; 10] = [
        [68.0, 1.0, 84.0], [72.0, 40.0, 120.0], [62.0, 73.0, 137.0], [49.0, 104.0, 142.0], [38.0, 130.0, 142.0],
        [31.0, 158.0, 137.0], [53.0, 183.0, 121.0], [110.0, 206.0, 88.0], [181.0, 222.0, 43.0], [253.0, 231.0, 37.0],
    ];
    let at = share.clamp(0.0, 1.0) * 9.0;
    let i = (at as usize).min(8);
    let part = at - i as f64;
    std::array::from_fn(|k| (STOPS[i][k] + (STOPS[i + 1][k] - STOPS[i][k]) * part).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance of sRGB.   Source: IEC 61966-2-1.
    fn luminance(rgb: [u8; 3]) -> f64 {
        let linear = |c: u8| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(rgb[0]) + 0.7152 * linear(rgb[1]) + 0.0722 * linear(rgb[2])
    }

    #[test]
    fn map_of_colours_can_be_read_in_grey() {
        let all: Vec<f64> = (0..=100).map(|i| luminance(viridis(f64::from(i) / 100.0))).collect();
        assert!(all.windows(2).all(|two| two[1] > two[0]));
    }

    /// Contrast of at least 3, the limit for graphics.   Source: WCAG 2.1, 1.4.11.
    #[test]
    fn series_stand_out_from_the_background() {
        for theme in [Theme::Light, Theme::Dark] {
            let paper = luminance(theme.rgb(Ink::Paper));
            for i in 0..6 {
                let ink = luminance(theme.rgb(Ink::Series(i)));
                let contrast = (paper.max(ink) + 0.05) / (paper.min(ink) + 0.05);
                assert!(contrast >= 3.0, "{theme:?} {i}: {contrast}");
            }
        }
    }
}
