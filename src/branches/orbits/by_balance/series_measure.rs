//! What is measured along the series of a balance.

use crate::analysis::statistics::Summary;
use crate::branches::orbits::contact_trace::{ContactTrace, Extremum};
use crate::branches::orbits::measure::Measured;
use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::excitation::side::Side;
use crate::model::equations::Periodic;
use crate::periodic::balance::equations::balance_equations::BalanceEquations;
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::switching::contact_history::ContactHistory;
use crate::periodic::balance::switching::instants::Switching;
use crate::periodic::balance::switching::stencil::NODES;

/// Fewest samples for the statistics of a channel.
const SAMPLES: usize = 64;

/// Maximum number of evaluations that refine an extremum.
const ROUNDS: usize = 8;

/// Change of an extremum that is rounding, as a share of its absolute value.
const ROUNDING: f64 = 1e-15;

/// Measures the orbit at which the equations were evaluated last. `channels`: indices in the order of
/// [`Probe`](crate::analysis::Probe).
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
    if !equations.integration.follows_switches() && contacts > 0 && equations.grid.samples() >= NODES {
        equations.switching.locate(&mut equations.grid);
    }
    let (grid, switching) = (&equations.grid, &equations.switching);
    let (n, span) = (grid.dof(), grid.span());
    let rattle = |c: usize| ContactHistory::new(switching, c, span).statistics.rattle_state();
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
    let mut reader = Reader {
        model: grid.model,
        orbit,
        q: vec![0.0; n],
        v: vec![0.0; n],
        u: vec![0.0; grid.model.drives()],
        contacts: vec![Contact::default(); model.contacts()],
        own: Vec::new(),
    };
    let (m, highest) = (grid.samples(), grid.harmonics().highest());
    let summarise = |&channel: &usize| {
        let is_motion = channel < 2 * n || (channel - 2 * n < 3 * contacts && (channel - 2 * n) % 3 == 0);
        let enough = SAMPLES.max(4 * highest);
        let stride = if is_motion { (m / enough.next_power_of_two()).max(1) } else { 1 };
        let values = (0..m).step_by(stride).map(|s| {
            grid.state(s, &mut reader.q, &mut reader.v);
            reader.u.copy_from_slice(grid.drives(s));
            reader.value(channel)
        });
        let values: Vec<f64> = values.collect();
        reader.summary(channel, &values)
    };
    Measured {
        summaries: channels.iter().map(summarise).collect(),
        rattle: (0..contacts).map(rattle).collect(),
        trace: trace(switching, contacts),
        units: ranges.clone(),
        ranges,
        symmetries: Vec::new(),
    }
}

/// The extremes of all contacts, and how often their edges are crossed.
fn trace(switching: &Switching, contacts: usize) -> ContactTrace {
    let mut trace = ContactTrace::new(contacts);
    for contact in 0..contacts {
        for lower in [true, false] {
            let extremes = switching.extremes(contact, lower);
            trace.extremes.extend(extremes.map(|(phase, distance, maximum)| Extremum {
                contact,
                lower,
                maximum,
                phase,
                distance,
            }));
        }
    }
    for event in switching.events().iter().filter(|event| event.contact < contacts) {
        let lower = event.from == Piece::Lower || event.to == Piece::Lower;
        trace.crossings[event.contact][usize::from(!lower)] += 1;
    }
    trace
}

/// Evaluates channels along an orbit.
struct Reader<'a, M: ?Sized> {
    model: &'a M,
    orbit: &'a FourierOrbit,
    q: Vec<f64>,
    v: Vec<f64>,
    u: Vec<f64>,
    contacts: Vec<Contact>,
    own: Vec<f64>,
}

impl<M: Periodic + ?Sized> Reader<'_, M> {
    /// The channel in the state that `q`, `v` and `u` hold.
    fn value(&mut self, channel: usize) -> f64 {
        let n = self.q.len();
        if channel < n {
            return self.q[channel];
        }
        if channel < 2 * n {
            return self.v[channel - n];
        }
        self.model.contact(&self.u, &self.q, &self.v, &mut self.contacts);
        let of_contacts = channel - 2 * n;
        if let Some(c) = self.contacts.get(of_contacts / 3) {
            let touches = if c.penetration() > 0.0 { 1.0 } else { 0.0 };
            return [c.deflection, c.force, touches][of_contacts % 3];
        }
        if self.own.is_empty() {
            self.own = vec![0.0; self.model.channels().len()];
        }
        self.model.observe(&self.u, &self.q, &self.v, &self.contacts, &mut self.own);
        self.own[of_contacts - 3 * self.contacts.len()]
    }

    /// The channel at a share of the span.
    fn at(&mut self, channel: usize, share: f64) -> f64 {
        let t = self.orbit.span() * share;
        self.orbit.motion(t, &mut self.q, &mut self.v);
        self.model.drive(t, Side::After, &mut self.u);
        self.value(channel)
    }

    fn summary(&mut self, channel: usize, values: &[f64]) -> Summary {
        let m = values.len() as f64;
        let mean = values.iter().sum::<f64>() / m;
        let square = values.iter().map(|x| x * x).sum::<f64>() / m;
        let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / m;
        let [max, min] = [1.0, -1.0].map(|sign| sign * self.maximum(channel, values, sign));
        Summary { mean, rms: square.sqrt(), min, max, deviation: variance.sqrt() }
    }

    /// Maximum of `sign` times the channel: the parabola through the largest sample and its neighbours, then
    /// through the largest value and its neighbours.
    fn maximum(&mut self, channel: usize, values: &[f64], sign: f64) -> f64 {
        let m = values.len();
        let top = (0..m).max_by(|&a, &b| (sign * values[a]).total_cmp(&(sign * values[b]))).unwrap_or(0);
        let value = |i: usize| sign * values[(top + m + i - 1) % m];
        let (mut x, mut f) = ([-1.0, 0.0, 1.0], [value(0), value(1), value(2)]);
        let mut best = f[1];
        for _ in 0..ROUNDS {
            let (left, right) = ((x[1] - x[0]) * (f[1] - f[2]), (x[1] - x[2]) * (f[1] - f[0]));
            let at = x[1] - 0.5 * ((x[1] - x[0]) * left - (x[1] - x[2]) * right) / (left - right);
            if !(at > x[0] && at < x[2]) || at == x[1] {
                break;
            }
            let y = sign * self.at(channel, (top as f64 + at) / m as f64);
            let gained = y - best;
            (x, f) = match (at > x[1], y > f[1]) {
                (true, true) => ([x[1], at, x[2]], [f[1], y, f[2]]),
                (true, false) => ([x[0], x[1], at], [f[0], f[1], y]),
                (false, true) => ([x[0], at, x[1]], [f[0], y, f[1]]),
                (false, false) => ([at, x[1], x[2]], [y, f[1], f[2]]),
            };
            best = best.max(y);
            if gained.abs() <= ROUNDING * best.abs() {
                break;
            }
        }
        best
    }
}
