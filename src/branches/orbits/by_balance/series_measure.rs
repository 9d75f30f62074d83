//! What is measured along the series of a balance.

use crate::analysis::Summary;
use crate::branches::orbits::contact_trace::{ContactTrace, Extremum};
use crate::branches::orbits::measured::Measured;
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
/// Mean and RMS are sums over uniform samples: exact for coordinates, velocities and deflections, of second
/// order in the distance of the samples for forces with kinks.
pub(crate) fn measure_series<M: Periodic + ?Sized>(
    equations: &mut BalanceEquations<'_, M>,
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
        reader.summary(channel, &values)
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
struct Reader<'a, M: ?Sized> {
    probe: Probe<'a, M>,
    orbit: &'a FourierOrbit,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl<M: Periodic + ?Sized> Reader<'_, M> {
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

    fn summary(&mut self, channel: usize, values: &[f64]) -> Summary {
        let [max, min] = [1.0, -1.0].map(|sign| sign * self.maximum(channel, values, sign));
        Summary { min, max, ..Summary::of_values(values) }
    }

    /// Maximum of `sign` times the channel, from the largest sample and its neighbours.
    fn maximum(&mut self, channel: usize, values: &[f64], sign: f64) -> f64 {
        let m = values.len();
        let top = (0..m).max_by(|&a, &b| (sign * values[a]).total_cmp(&(sign * values[b]))).unwrap_or(0);
        let f = [m - 1, 0, 1].map(|i| sign * values[(top + i) % m]);
        maximum([-1.0, 0.0, 1.0], f, |x| sign * self.at(channel, (top as f64 + x) / m as f64))
    }
}
