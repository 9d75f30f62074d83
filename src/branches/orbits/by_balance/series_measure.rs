//! What is measured along the series of a balance.

use crate::analysis::Summary;
use crate::branches::orbits::contact_trace::{ContactTrace, Extremum};
use crate::branches::orbits::measured::Measured;
use crate::contact::Piece;
use crate::contact::edge::Edge;
use crate::excitation::Side;
use crate::model::Periodic;
use crate::numeric::search::parabola::maximum;
use crate::ode::probe::{ChannelKind, Probe};
use crate::periodic::balance::crossings::instants::Crossings;
use crate::periodic::balance::crossings::stencil::NODES;
use crate::periodic::{BalanceEquations, ContactHistory, FourierOrbit};

/// Fewest samples for the statistics of a channel.
const FEWEST_SAMPLES: usize = 64;

/// Measures the orbit at which the equations were evaluated last. `channels`: indices in the order of
/// [`Probe`](crate::ode::Probe).
///
/// Mean and RMS are sums over uniform samples: exact for coordinates and velocities, of second order in the
/// distance of the samples for what has kinks or jumps. Extremes contain both sides of a jump.
pub(crate) fn measure_series(
    equations: &mut BalanceEquations<'_>,
    orbit: &FourierOrbit,
    channels: &[usize],
) -> Measured {
    let model = equations.grid.model;
    let contacts = model.offers().touching(model.contacts());
    if !equations.work.integration.follows_crossings() && contacts > 0 && equations.grid.samples() >= NODES {
        equations.work.crossings.locate(&mut equations.grid);
    }
    let (grid, crossings) = (&equations.grid, &equations.work.crossings);
    let (n, span) = (grid.dof(), grid.span());
    let rattle = |c: usize| ContactHistory::new(crossings, c, span).statistics.rattle_state();
    let range = |part: fn(&num_complex::Complex64) -> f64| {
        grid.z.iter().map(move |z| {
            let ends = z
                .iter()
                .map(part)
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
            ends[1] - ends[0]
        })
    };
    let ranges: Vec<f64> = range(|z| z.re).chain(range(|z| z.im)).collect();
    let mut reader = Reader { probe: Probe::new(model), orbit, q: vec![0.0; n], v: vec![0.0; n] };
    let breaks = breaks(model, crossings, span);
    let (m, highest) = (grid.samples(), grid.harmonics().highest());
    let summarise = |&channel: &usize| {
        let is_motion = reader.probe.kind(channel).is_some_and(|kind| !matches!(kind, ChannelKind::Force(_)));
        let enough = FEWEST_SAMPLES.max(4 * highest);
        let stride = if is_motion { (m / enough.next_power_of_two()).max(1) } else { 1 };
        let values = (0..m).step_by(stride).map(|s| {
            grid.state(s, &mut reader.q, &mut reader.v);
            reader.probe.drives.copy_from_slice(grid.drives(s));
            reader.value(channel)
        });
        let values: Vec<f64> = values.collect();
        reader.summary(channel, &values, &breaks)
    };
    Measured {
        summaries: channels.iter().map(summarise).collect(),
        rattle: (0..contacts).map(rattle).collect(),
        trace: trace(crossings, contacts),
        units: ranges.clone(),
        ranges,
        symmetries: Vec::new(),
    }
}

/// An instant at which channels may jump, over the span: a drive edge, or a crossing with its contact and the
/// pieces before and after it.
struct Break {
    share: f64,
    crossing: Option<(usize, [Piece; 2])>,
}

/// Distance from a sample up to which an instant lies on it, in samples.
const ON_SAMPLE: f64 = 1e-7;

/// Nearest and farthest distance from a crossing of the samples for a limit there, as shares of the span.
const NEAREST: f64 = 1e-9;
const FARTHEST: f64 = 1e-3;

/// The drive edges and the crossings in a span.
fn breaks(model: &dyn Periodic, crossings: &Crossings, span: f64) -> Vec<Break> {
    let mut found: Vec<Break> = crossings
        .list()
        .iter()
        .map(|c| {
            let share = (c.time(1.0) / crossings.samples() as f64).rem_euclid(1.0);
            Break { share, crossing: Some((c.contact, [c.from, c.to])) }
        })
        .collect();
    // An edge at the start counts there, not at the end.
    let mut t = -ON_SAMPLE * span / crossings.samples().max(FEWEST_SAMPLES) as f64;
    let end = span + t;
    while let Some(edge) = model.next_edge(t).filter(|edge| *edge > t && *edge < end) {
        found.push(Break { share: (edge / span).max(0.0), crossing: None });
        t = edge;
    }
    found
}

/// The extremes of all contacts, and how often their edges are crossed.
fn trace(crossings: &Crossings, contacts: usize) -> ContactTrace {
    let mut trace = ContactTrace::new(contacts);
    for contact in 0..contacts {
        for edge in Edge::BOTH {
            let extremes = crossings.extremes(contact, edge);
            trace.extremes.extend(extremes.map(|(phase, distance, maximum)| Extremum {
                contact,
                edge,
                maximum,
                phase,
                distance,
            }));
        }
    }
    for crossing in crossings.list().iter().filter(|crossing| crossing.contact < contacts) {
        let edge = Edge::between(crossing.from, crossing.to);
        trace.crossings[crossing.contact][edge as usize] += 1;
    }
    trace
}

/// Evaluates channels along an orbit.
struct Reader<'a> {
    probe: Probe<'a>,
    orbit: &'a FourierOrbit,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl Reader<'_> {
    /// The channel in the state that `q` and `v` hold, under the drives of the probe.
    fn value(&mut self, channel: usize) -> f64 {
        let (probe, q, v) = (&mut self.probe, &self.q, &self.v);
        match probe.kind(channel) {
            Some(ChannelKind::Coordinate(i)) => q[i],
            Some(ChannelKind::Velocity(i)) => v[i],
            Some(ChannelKind::Deflection(i)) => probe.evaluate_contacts(q, v)[i].deflection,
            Some(ChannelKind::Force(i)) => probe.evaluate_contacts(q, v)[i].force,
            None => probe.evaluate(q, v)[channel],
        }
    }

    /// The channel at a share of the span.
    fn at(&mut self, channel: usize, share: f64) -> f64 {
        let t = self.orbit.period() * share;
        self.orbit.motion(t, &mut self.q, &mut self.v);
        self.probe.drive(t, Side::After);
        self.value(channel)
    }

    fn summary(&mut self, channel: usize, values: &[f64], breaks: &[Break]) -> Summary {
        let [mut max, mut min] = [1.0, -1.0].map(|sign| sign * self.maximum(channel, values, sign));
        let Summary { mean, rms, deviation, .. } = Summary::of_values(values);
        // A cell between two samples with a jump from x to y at its share θ has the integral θ x + (1 - θ) y,
        // and (x + y)/2 in the sum over samples: the difference is (1/2 - θ) (y - x).
        let [mut shift, mut square, mut about] = [0.0; 3];
        for at in breaks {
            let Some([x, y]) = self.sides(channel, at) else { continue };
            (min, max) = (min.min(x.min(y)), max.max(x.max(y)));
            let place = at.share * values.len() as f64;
            // A sample at a jump is behind it.
            let weight = (0.5 - (place - (place - ON_SAMPLE).ceil() + 1.0).min(1.0)) / values.len() as f64;
            shift += weight * (y - x);
            square += weight * (y * y - x * x);
            about += weight * ((y - mean) * (y - mean) - (x - mean) * (x - mean));
        }
        let deviation = (deviation * deviation + about - shift * shift).max(0.0).sqrt();
        Summary { mean: mean + shift, rms: (rms * rms + square).max(0.0).sqrt(), min, max, deviation }
    }

    /// The channel on both sides of an instant at which it may jump; `None` for one that does not jump there.
    fn sides(&mut self, channel: usize, at: &Break) -> Option<[f64; 2]> {
        let kind = self.probe.kind(channel);
        if matches!(kind, Some(ChannelKind::Coordinate(_) | ChannelKind::Velocity(_))) {
            return None;
        }
        let Some((contact, pieces)) = at.crossing else {
            let t = self.orbit.period() * at.share;
            self.orbit.motion(t, &mut self.q, &mut self.v);
            return Some([Side::Before, Side::After].map(|side| {
                self.probe.drive(t, side);
                self.value(channel)
            }));
        };
        if matches!(kind, Some(ChannelKind::Deflection(_))) {
            return None;
        }
        let [x, y] = [-1.0, 1.0].map(|sign: f64| self.limit(channel, at.share, sign, contact, pieces));
        Some([x?, y?])
    }

    /// The limit of the channel at a crossing of `contact` from before (`sign` -1) or after it (1): from the
    /// nearest two instants at which the contact stands on its piece there.
    fn limit(
        &mut self,
        channel: usize,
        share: f64,
        sign: f64,
        contact: usize,
        pieces: [Piece; 2],
    ) -> Option<f64> {
        let piece = pieces[usize::from(sign > 0.0)];
        let mut apart = NEAREST;
        while apart < FARTHEST {
            let [near, far] = [1.0, 2.0].map(|times| {
                let value = self.at(channel, share + sign * times * apart);
                let contacts = self.probe.evaluate_contacts(&self.q, &self.v);
                (contacts[contact].piece() == piece).then_some(value)
            });
            if let (Some(near), Some(far)) = (near, far) {
                return Some(2.0 * near - far);
            }
            apart *= 4.0;
        }
        None
    }

    /// Maximum of `sign` times the channel, from the largest sample and its neighbours.
    fn maximum(&mut self, channel: usize, values: &[f64], sign: f64) -> f64 {
        let m = values.len();
        let top = (0..m).max_by(|&a, &b| (sign * values[a]).total_cmp(&(sign * values[b]))).unwrap_or(0);
        let f = [m - 1, 0, 1].map(|i| sign * values[(top + i) % m]);
        maximum([-1.0, 0.0, 1.0], f, |x| sign * self.at(channel, (top as f64 + x) / m as f64))
    }
}
