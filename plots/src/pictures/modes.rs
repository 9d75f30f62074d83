//! Shapes of modes.

use crate::draw::colours::Ink;
use crate::draw::layers::{Layer, Swatch};
use crate::error::{PlotError, finite};
use crate::panel::Panel;
use crate::svg::writer::Anchor;
use gear_dynamics::contact::Nonlinearity;
use gear_dynamics::trains::{Drawing, Train};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The largest displacement that is drawn, as a share of the mean pitch radius.
const SHARE: f64 = 0.35;

/// Corners of a drawn circle.
const CORNERS: usize = 72;

/// A mode of a train: its gears as pitch circles at their places, grey at rest and coloured as they turn and move.
///
/// The spoke of a gear points upwards at rest. Turns and displacements have one scale, so that the largest displacement of
/// a rim or a centre is a third of the mean pitch radius. A body without stated place stands beside the one that it meshes
/// with, at the centre distance of the mesh.
///
/// `shape`: coordinates of the train, for example [`Mode::shape`](gear_dynamics::linear::Mode::shape).
///
/// ```
/// use gear_dynamics::trains::SpurPair;
/// use gear_dynamics_plots::{Figure, mode};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[0.2], &[])?.parts()?.build("driver", 1.0)?;
/// let svg = Figure::from(mode(&pair, &[1.0])?.title("1 Hz")).to_svg();
/// assert!(svg.contains("at rest") && svg.contains("driven"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PlotError::Parameter`] for another number of coordinates, [`PlotError::NotFinite`], [`PlotError::Empty`] for a train
/// without gears and for a shape that is zero.
pub fn mode<N: Nonlinearity>(train: &Train<N>, shape: &[f64]) -> Result<Panel, PlotError> {
    finite("shape of the mode", shape)?;
    let motion = train.motion(shape)?;
    let drawing = train.shape().drawing();
    let radii: Vec<f64> = drawing.bodies.iter().map(|body| body.radius).filter(|r| *r > 0.0).collect();
    let rim = |(body, moved): (&gear_dynamics::trains::DrawnBody, &[f64; 3])| {
        (moved[0].abs() * body.radius).max(moved[1].hypot(moved[2]))
    };
    let largest = drawing.bodies.iter().zip(&motion).map(rim).fold(0.0, f64::max);
    if radii.is_empty() || largest == 0.0 {
        return Err(PlotError::Empty { what: "gears that move in the mode".into() });
    }
    let mean = radii.iter().sum::<f64>() / radii.len() as f64;
    let scale = SHARE * mean / largest;
    let mut panel = Panel::new("", "x [m]", "y [m]")?;
    panel.equal = true;
    panel.entry("at rest", Swatch::Line { ink: Ink::Grey, style: 0, width: 1.0, cased: false });
    panel.entry("in the mode", Swatch::Line { ink: Ink::Series(0), style: 0, width: 1.6, cased: false });
    let places = places(drawing, mean);
    for ((body, moved), place) in drawing.bodies.iter().zip(&motion).zip(&places) {
        // A body without teeth is a small hub.
        let radius = if body.radius > 0.0 { body.radius } else { 0.2 * mean };
        let [turn, x, y] = moved.map(|part| scale * part);
        let shown =
            [(0.0, *place, Ink::Grey, 1.0), (turn, [place[0] + x, place[1] + y], Ink::Series(0), 1.6)];
        for (turn, [x, y], ink, width) in shown {
            let at = |angle: f64, r: f64| [x + r * angle.cos(), y + r * angle.sin()];
            let circle: Vec<[f64; 2]> =
                (0..=CORNERS).map(|i| at(TAU * i as f64 / CORNERS as f64, radius)).collect();
            let from = if body.internal { 0.85 } else { 0.0 };
            let spoke = vec![at(FRAC_PI_2 + turn, from * radius), at(FRAC_PI_2 + turn, radius)];
            if ink == Ink::Grey && !body.internal && body.radius > 0.0 {
                let lines = vec![Vec::clone(&circle)];
                panel.layers.push(Layer::Outline { lines, fill: Some((Ink::Solid, 1.0)), stroke: None });
            }
            panel.layers.push(Layer::Outline {
                lines: vec![circle, spoke],
                fill: None,
                stroke: Some((ink, width)),
            });
        }
        // The name of a hub stands above it: a carrier has the centre of its sun.
        let foot = if body.radius == 0.0 {
            1.6
        } else if body.internal {
            -0.93
        } else {
            -0.6
        } * radius;
        let (at, text) = ([place[0], place[1] + foot], body.name.clone());
        panel.layers.push(Layer::Note { at, text, anchor: Anchor::Middle, ink: Ink::Text });
    }
    Ok(panel)
}

/// The centres of the bodies. Those that are not stated stand to the right of a body that they mesh with, then below one
/// that a shaft joins them to.
fn places(drawing: &Drawing, mean: f64) -> Vec<[f64; 2]> {
    let mut places: Vec<Option<[f64; 2]>> = drawing.bodies.iter().map(|body| body.centre).collect();
    let mut free = 0.0;
    while let Some(next) = places.iter().position(Option::is_none) {
        let mut grown = false;
        for link in &drawing.links {
            for [from, to] in [link.ends, [link.ends[1], link.ends[0]]] {
                if let (Some([x, y]), None) = (places[from], places[to]) {
                    places[to] = Some(match link.distance {
                        Some(distance) => [x + distance, y],
                        None => {
                            [x, y - 2.2 * (drawing.bodies[from].radius + drawing.bodies[to].radius).max(mean)]
                        }
                    });
                    grown = true;
                }
            }
        }
        if !grown {
            places[next] = Some([free, 0.0]);
            free += 4.0 * mean;
        }
    }
    places.into_iter().map(Option::unwrap_or_default).collect()
}
