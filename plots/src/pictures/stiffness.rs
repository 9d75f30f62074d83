//! Mesh stiffness over the angle.

use crate::draw::layers::Mark;
use crate::error::{PlotError, finite};
use crate::panel::Panel;
use gear_dynamics::Wave;
use gear_dynamics::excitation::Side;
use std::f64::consts::TAU;

/// Waves, such as the stiffness of meshes, over `cycles` cycles of their angle. Jumps are drawn as jumps.
///
/// `value`: text with unit. `waves`: each with its name.
///
/// ```
/// use gear_dynamics::{Wave, excitation::RectangularWave};
/// use gear_dynamics_plots::{Picture, stiffness};
/// let wave = Wave::new(RectangularWave::of_contact_ratio(1.6, 2e8, 3e8)?);
/// let svg = Picture::from(stiffness(&[("stage 1", &wave)], "mesh stiffness k [N/m]", 2.0)?).to_svg();
/// assert!(svg.contains("mesh stiffness k [10⁶ N/m]"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PlotError::Empty`] without waves, [`PlotError::Cycles`] for cycles outside (0, 1e4], [`PlotError::NotFinite`],
/// [`PlotError::NoUnit`].
pub fn stiffness(waves: &[(&str, &Wave)], value: &str, cycles: f64) -> Result<Panel, PlotError> {
    let mut panel = Panel::new("", "mesh cycles φ/2π [1]", value)?;
    if waves.is_empty() {
        return Err(PlotError::Empty { what: panel.y.name });
    }
    finite("cycles", [&cycles])?;
    if cycles <= 0.0 || cycles > 1e4 {
        return Err(PlotError::Cycles { value: cycles });
    }
    for (name, wave) in waves {
        panel = panel.series(name, Mark::Line, samples(wave, cycles))?;
    }
    Ok(panel)
}

/// A wave at equal angles and on both sides of its edges.
fn samples(wave: &Wave, cycles: f64) -> Vec<(f64, f64)> {
    let count = (500.0 * cycles).ceil() as usize;
    let end = TAU * cycles;
    let at = |angle: f64, side: Side| (angle / TAU, wave.value(angle, side));
    let mut points = vec![at(0.0, Side::After)];
    let mut edge = wave.next_edge(0.0);
    for i in 1..=count {
        let angle = end * i as f64 / count as f64;
        while let Some(jump) = edge.filter(|jump| *jump <= angle && *jump < end) {
            points.extend([at(jump, Side::Before), at(jump, Side::After)]);
            edge = wave.next_edge(jump).filter(|next| *next > jump);
        }
        points.push(at(angle, Side::Before));
    }
    points
}
