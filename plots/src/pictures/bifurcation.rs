//! Bifurcation diagrams.

use crate::draw::colours::Ink;
use crate::draw::layers::{Curve, Mark, Swatch};
use crate::error::PlotError;
use crate::panel::Panel;
use gear_dynamics::sweep::{Diagram, DiagramPoint};

/// Values of a sweep upwards and of one downwards over the parameter. Where both reach one motion, the small dots of
/// the way up lie on the large ones of the way down.
///
/// `axes`: texts with units of the parameter and the values.
///
/// ```
/// use gear_dynamics::sweep::{Axis, Bifurcation, LaneRk4};
/// use gear_dynamics::{Sweep, models::Oscillator};
/// use gear_dynamics_plots::{Picture, bifurcation};
/// let swing = Oscillator::new(&[("speed", 1.0), ("damping", 0.2), ("linear stiffness", 2.0), ("force", 0.1)])?;
/// let sweep = Sweep::new(Axis::linear("speed", 0.5, 1.0, 3)?).settle(20).measure(2);
/// let diagram = Bifurcation::strobed("q0").run(&sweep.over(&LaneRk4::new(64), &swing)?)?;
/// let svg = Picture::from(bifurcation(&diagram, ["Ω [1]", "q(2πk/Ω) [1]"])?).to_svg();
/// assert!(svg.contains("upwards") && svg.contains("Ω [1]"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PlotError::Empty`] without values, [`PlotError::NotFinite`], [`PlotError::NoUnit`].
pub fn bifurcation(diagram: &Diagram, axes: [&str; 2]) -> Result<Panel, PlotError> {
    let mut panel = Panel::new("", axes[0], axes[1])?;
    let dots = |marks: &[DiagramPoint]| -> Vec<[f64; 2]> {
        marks.iter().flat_map(|mark| mark.values.iter().map(|value| [mark.parameter, *value])).collect()
    };
    panel.entry("upwards", Swatch::Speck { ink: Ink::Series(0), cased: false });
    panel.entry("downwards", Swatch::Dot { ink: Ink::Series(1), style: 0 });
    for (marks, series, width) in [(diagram.down(), 1, 3.4), (diagram.up(), 0, 1.5)] {
        let points = dots(marks);
        let curve = Curve { mark: Mark::Specks, ink: Ink::Series(series), style: 0, width, points };
        panel.curve("", curve)?;
    }
    Ok(panel)
}
