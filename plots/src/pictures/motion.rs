//! Time histories and phase portraits with the states of a contact.

use crate::draw::colours::Ink;
use crate::draw::layers::{Curve, Layer, Mark, Swatch, THIN};
use crate::error::PlotError;
use crate::panel::{Panel, name_and_unit};
use gear_dynamics::Model;
use gear_dynamics::contact::{Contact, Piece};
use gear_dynamics::excitation::Side;
use gear_dynamics::ode::Probe;
use gear_dynamics::ode::Trajectory;

/// A channel over the time, with the states of a contact shaded: times in the gap grey, those on the back (lower) flank
/// in a pale colour. Of the deflection of this contact the edges of the gap are drawn, too, named ±b where they rest.
///
/// `channel`: the name of a [channel](gear_dynamics::ode::Probe) of the model with its unit. `contact`: its
/// number from 0, or `None`. The time axis is `t [s]`; [`Panel::x`] names another unit.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, NfgPair, NfgParams, Periodic};
/// use gear_dynamics_plots::{Picture, history};
/// let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() })?;
/// let run = Dop853::new().trajectory(&pair, &pair.on_drive_flank()?, 0.2 * pair.period())?;
/// let panel = history(&pair, &run, "deflection [m]", 0)?.x("τ = ω_n t [1]")?.title("180 rad/s");
/// let svg = Picture::from(panel).to_svg();
/// assert!(svg.contains("deflection [μm]") && svg.contains("gap"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PlotError::Empty`] for a run of fewer than two states, [`PlotError::NotFinite`], [`PlotError::NoUnit`],
/// [`PlotError::NoSuch`] for a contact that the model does not have, and the errors of
/// [`Trajectory::channel`].
pub fn history(
    model: &dyn Model,
    run: &Trajectory,
    channel: &str,
    contact: impl Into<Option<usize>>,
) -> Result<Panel, PlotError> {
    let mut panel = Panel::new("", "time t [s]", channel)?;
    let [name, _] = name_and_unit(channel)?;
    let points: Vec<[f64; 2]> =
        run.times().iter().zip(run.channel(model, &name)?).map(|(t, x)| [*t, x]).collect();
    if points.len() < 2 {
        return Err(PlotError::Empty { what: format!("time history of {name}") });
    }
    if let Some(contact) = contact.into() {
        let contacts = contacts(model, run, contact)?;
        shade(&mut panel, run.times(), &contacts, &format!("in the {}", gap(model, contact)));
        if name == "deflection" || name == format!("deflection {contact}") {
            panel = edges(panel, run.times(), &contacts, &points)?;
        }
    }
    panel.curve("", Curve { mark: Mark::Line, ink: Ink::Series(0), style: 0, width: 1.5, points })?;
    Ok(panel)
}

/// The edges of the gap over the time: named where they rest, as curves where they move.
fn edges(
    mut panel: Panel,
    times: &[f64],
    contacts: &[Contact],
    motion: &[[f64; 2]],
) -> Result<Panel, PlotError> {
    let named = resting(contacts).filter(|edges| edges.iter().all(|(edge, _)| edge.is_finite()));
    if let Some(edges) = named {
        let all = edges.iter().map(|(edge, _)| *edge).chain(motion.iter().map(|point| point[1]));
        let [low, high] =
            all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
        let space = 0.06 * (high - low);
        panel.y.range = Some([low - space, high + space]).filter(|r| r[0] < r[1] && r[0].is_finite());
        return panel.name_y(&edges);
    }
    for edge in [|c: &Contact| c.lower, |c: &Contact| c.upper] {
        let points: Vec<_> = times.iter().zip(contacts).map(|(t, contact)| [*t, edge(contact)]).collect();
        if points.iter().all(|point| point[1].is_finite()) {
            let curve = Curve { mark: Mark::Dashed, ink: Ink::Text, style: THIN, width: 0.9, points };
            panel.curve("edges of the gap", curve)?;
        }
    }
    Ok(panel)
}

/// Both edges with their names, if they do not move.
fn resting(contacts: &[Contact]) -> Option<[(f64, &'static str); 2]> {
    let Contact { lower, upper, .. } = contacts[0];
    let rests = contacts.iter().all(|c| c.lower == lower && c.upper == upper);
    let names = if lower == -upper { ["−b", "b"] } else { ["lower edge", "upper edge"] };
    rests.then_some([(lower, names[0]), (upper, names[1])])
}

/// The name of the gap of a contact. Of several contacts it states the number.
fn gap(model: &dyn Model, contact: usize) -> String {
    if model.contacts() > 1 { format!("gap of contact {contact}") } else { "gap".into() }
}

/// The contact at each state of a run.
fn contacts(model: &dyn Model, run: &Trajectory, contact: usize) -> Result<Vec<Contact>, PlotError> {
    let count = model.contacts();
    if contact >= count {
        return Err(PlotError::NoSuch { what: "contacts of the model".into(), index: contact, count });
    }
    let mut probe = Probe::new(model);
    let at = |i: usize| {
        let side = if i == 0 { Side::After } else { Side::Before };
        probe.read_contacts(run.times()[i], side, run.q(i), run.v(i))[contact]
    };
    Ok((0..run.len()).map(at).collect())
}

/// The spans of time on each piece: lower flank, gap, upper flank. Instants between two states are linear.
fn spans(times: &[f64], contacts: &[Contact]) -> [Vec<[f64; 2]>; 3] {
    let mut spans: [Vec<[f64; 2]>; 3] = Default::default();
    let mut start = times[0];
    for (t, two) in times.windows(2).zip(contacts.windows(2)) {
        let [from, to] = [two[0].piece() as usize, two[1].piece() as usize];
        let pass = |edge: fn(&Contact) -> f64| {
            let [a, b] = [0, 1].map(|i| two[i].deflection - edge(&two[i]));
            t[0] + (t[1] - t[0]) * (a / (a - b)).clamp(0.0, 1.0)
        };
        let mut at = from;
        while at != to {
            let next = if to > at { at + 1 } else { at - 1 };
            let edge: fn(&Contact) -> f64 = if at.min(next) == 0 { |c| c.lower } else { |c| c.upper };
            let end = pass(edge);
            spans[at].push([start, end]);
            (start, at) = (end, next);
        }
    }
    if let (Some(last), Some(end)) = (contacts.last(), times.last()) {
        spans[last.piece() as usize].push([start, *end]);
    }
    spans
}

/// Shades the gap and the lower (back) flank; the upper (drive) flank is the background.
fn shade(panel: &mut Panel, times: &[f64], contacts: &[Contact], gap: &str) {
    let spans = spans(times, contacts);
    for (piece, ink, label) in [
        (Piece::Upper, Ink::Paper, "on the drive flank"),
        (Piece::Gap, Ink::Gap, gap),
        (Piece::Lower, Ink::Flank, "on the back flank"),
    ] {
        let spans = spans[piece as usize].clone();
        if spans.is_empty() {
            continue;
        }
        panel.entry(label, Swatch::Field { ink, opacity: 1.0 });
        if ink != Ink::Paper {
            panel.layers.push(Layer::Shade { ink, spans });
        }
    }
}

/// Deflection and rate of a contact as a curve with its direction, with its gap shaded: its part that is free at all
/// times. Edges that do not move are named.
///
/// `axes`: texts with units. `contact`: its number from 0.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, NfgPair, NfgParams, Periodic};
/// use gear_dynamics_plots::{Picture, phase_portrait};
/// let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() })?;
/// let run = Dop853::new().trajectory(&pair, &pair.on_drive_flank()?, 0.2 * pair.period())?;
/// let panel = phase_portrait(&pair, &run, ["deflection d [m]", "rate d' [m]"], 0)?;
/// let svg = Picture::from(panel).to_svg();
/// assert!(svg.contains("rate d' [nm]"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`history`].
pub fn phase_portrait(
    model: &dyn Model,
    run: &Trajectory,
    axes: [&str; 2],
    contact: usize,
) -> Result<Panel, PlotError> {
    let mut panel = Panel::new("", axes[0], axes[1])?;
    let contacts = contacts(model, run, contact)?;
    if contacts.len() < 2 {
        return Err(PlotError::Empty { what: "phase portrait".into() });
    }
    let lower = contacts.iter().fold(f64::NEG_INFINITY, |most, c| most.max(c.lower));
    let upper = contacts.iter().fold(f64::INFINITY, |least, c| least.min(c.upper));
    let points: Vec<[f64; 2]> = contacts.iter().map(|c| [c.deflection, c.rate]).collect();
    let ends = |of: fn(f64, f64) -> f64, start: f64| points.iter().fold(start, |end, p| of(end, p[0]));
    let (least, most) = (ends(f64::min, f64::INFINITY), ends(f64::max, f64::NEG_INFINITY));
    // Gap and edges are shown up to one and a half widths of the motion beside it.
    let width = 1.5 * (most - least);
    if lower < upper {
        // Without edges the whole panel is gap.
        let span = [lower.max(least - width), upper.min(most + width)];
        panel.layers.push(Layer::Shade { ink: Ink::Gap, spans: vec![span] });
        panel.entry(&gap(model, contact), Swatch::Field { ink: Ink::Gap, opacity: 1.0 });
    }
    panel.curve("", Curve { mark: Mark::Directed, ink: Ink::Series(0), style: 0, width: 1.3, points })?;
    let seen = |edge: f64| edge > least - width && edge < most + width;
    let named = resting(&contacts).into_iter().flatten().filter(|(edge, _)| seen(*edge));
    panel = panel.name_x(&named.collect::<Vec<_>>())?;
    let edges = [lower, upper].into_iter().filter(|edge| seen(*edge));
    let [low, high] = edges.fold([least, most], |[low, high], edge| [low.min(edge), high.max(edge)]);
    let space = 0.04 * (high - low);
    panel.x.range = Some([low - space, high + space]).filter(|r| r[0] < r[1]);
    Ok(panel)
}
