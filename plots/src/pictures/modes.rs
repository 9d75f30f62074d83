//! Shapes of modes.

use crate::draw::colours::Ink;
use crate::draw::layers::{Layer, Swatch};
use crate::error::{PlotError, finite};
use crate::panel::Panel;
use gear_dynamics::contact::Nonlinearity;
use gear_dynamics::trains::{Drawing, Train};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

/// The largest displacement that is drawn, as a share of the mean pitch radius.
const SHARE: f64 = 0.35;

/// Width of a line at rest: it shows on both sides of a line in the mode.
const REST: f64 = 3.6;

/// Corners of a drawn circle.
const CORNERS: usize = 96;

/// A mode of a train: its gears as pitch circles at their places, grey at rest and coloured as they turn and move.
///
/// The spoke of a gear points upwards at rest, that of a ring lies outside it; a carrier is the polygon of the centres of its planets. The size
/// of a mode is arbitrary: turns and displacements have one scale, so that the largest displacement of a rim or
/// a centre is a third of the mean pitch radius. A body without stated place stands beside the one that it meshes
/// with, at the centre distance of the mesh.
///
/// `shape`: coordinates of the train, for example [`Mode::shape`](gear_dynamics::linear::Mode::shape).
///
/// ```
/// use gear_dynamics::trains::SpurPair;
/// use gear_dynamics_plots::{Picture, mode};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[0.2], &[])?.parts()?.build("driver", 1.0)?;
/// let svg = Picture::from(mode(&pair, &[1.0])?.title("1 Hz")).to_svg();
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
    panel.entry("at rest", Swatch::Line { ink: Ink::Missing, style: 0, width: REST, cased: false });
    panel.entry(
        "in the mode, size arbitrary",
        Swatch::Line { ink: Ink::Series(0), style: 0, width: 1.6, cased: false },
    );
    let places = places(drawing, mean);
    let (mut rest, mut moving, mut names) = (Vec::new(), Vec::new(), Vec::new());
    for (i, ((body, moved), [x, y])) in drawing.bodies.iter().zip(&motion).zip(&places).enumerate() {
        // A body without teeth is a small hub.
        let radius = if body.radius > 0.0 { body.radius } else { 0.2 * mean };
        let solid = !body.internal && body.radius > 0.0;
        let [turn, dx, dy] = moved.map(|part| scale * part);
        let planets = drawing.bodies.iter().zip(&places).filter(|(planet, _)| planet.carrier == Some(i));
        let pins: Vec<[f64; 2]> = planets.map(|(_, place)| [place[0] - x, place[1] - y]).collect();
        let lines = |turn, centre| match pins.is_empty() {
            true => outline(centre, turn, radius, body.internal),
            false => vec![polygon(centre, turn, &pins)],
        };
        let (fill, stroke) = (solid.then_some((Ink::Solid, 1.0)), Some((Ink::Missing, REST)));
        rest.push(Layer::Outline { lines: lines(0.0, [*x, *y]), fill, stroke });
        let stroke = Some((Ink::Series(0), 1.6));
        moving.push(Layer::Outline { lines: lines(turn, [x + dx, y + dy]), fill: None, stroke });
        // Names stand inside a gear or above or below it, below or beside a planet, outside a ring, above or below a hub, beside a side of a carrier.
        let around = |share: f64, count: usize, first: f64| {
            let at = move |k: usize| first + TAU * k as f64 / count as f64;
            (0..count).map(at).map(move |a| [share * radius * a.cos(), share * radius * a.sin()])
        };
        let offs: Vec<[f64; 2]> = match body.internal {
            true => around(1.15, 4, -FRAC_PI_4).collect(),
            false if pins.len() > 1 => {
                let next = pins.iter().skip(1).chain(&pins[..1]);
                let sides = pins.iter().zip(next).map(|(a, b)| [0, 1].map(|k| 0.5 * (a[k] + b[k])));
                let sides: Vec<_> = sides.collect();
                [1.25, 0.75, 1.45, 1.1, 0.6]
                    .iter()
                    .flat_map(|share| sides.iter().map(move |s| s.map(|x| share * x)))
                    .collect()
            }
            false if body.radius == 0.0 => around(1.7, 2, FRAC_PI_2).collect(),
            // Clear of the spokes: in the lower half of a planet beside the carrier, else beside it.
            false if body.carrier.is_some() => {
                let [cx, cy] = body.carrier.map_or([0.0; 2], |carrier| places[carrier]);
                let below = (x - cx).abs() > (y - cy).abs();
                let inside = [-0.5, -0.6, -0.4].map(|y| [0.2 * radius * (x - cx).signum(), y * radius]);
                if below { inside.to_vec() } else { vec![[1.65 * radius, 0.0]] }
            }
            false => [0.55, 0.4, 0.7, 0.25, 0.85]
                .iter()
                .flat_map(|share| around(*share, 24, -FRAC_PI_2))
                .chain([0.0, 0.25, -0.25].iter().flat_map(|turn| around(1.3, 2, -FRAC_PI_2 + turn)))
                .collect(),
        };
        let places = offs.into_iter().map(|off| [x + off[0], y + off[1]]).collect();
        names.push(Layer::Note { places, text: body.name.clone() });
    }
    // All modes of a train have one range: room for the largest displacement around the train at rest.
    let reach = |at: usize| {
        let ends = drawing.bodies.iter().zip(&places).flat_map(|(b, p)| [p[at] - b.radius, p[at] + b.radius]);
        let [low, high] =
            ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
        Some([low - 1.1 * SHARE * mean, high + 1.1 * SHARE * mean])
    };
    (panel.x.range, panel.y.range) = (reach(0), reach(1));
    // Lines show above the fills of gears.
    rest.sort_by_key(|layer| matches!(layer, Layer::Outline { fill: None, .. }));
    // Gears that others carry find their places first.
    panel.layers.extend(rest.into_iter().chain(moving).chain(names.into_iter().rev()));
    Ok(panel)
}

/// A pitch circle and its spoke, which points upwards at the angle 0; that of an internal gear lies outside.
fn outline([x, y]: [f64; 2], turn: f64, radius: f64, internal: bool) -> Vec<Vec<[f64; 2]>> {
    let at = |angle: f64, r: f64| [x + r * angle.cos(), y + r * angle.sin()];
    let circle = (0..=CORNERS).map(|i| at(TAU * i as f64 / CORNERS as f64, radius)).collect();
    let [from, to] = if internal { [1.0, 1.12] } else { [0.0, 1.0] };
    vec![circle, vec![at(FRAC_PI_2 + turn, from * radius), at(FRAC_PI_2 + turn, to * radius)]]
}

/// The pins of a carrier about its centre, turned.
fn polygon([x, y]: [f64; 2], turn: f64, pins: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let (sin, cos) = turn.sin_cos();
    let at = |[a, b]: &[f64; 2]| [x + cos * a - sin * b, y + sin * a + cos * b];
    pins.iter().chain(&pins[..1]).map(at).collect()
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
