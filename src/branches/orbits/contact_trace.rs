//! Extremes of the distance of contacts from their edges: what touches an edge at a grazing.

use crate::contact::Contact;
use crate::contact::edge::Edge;
use crate::excitation::Side;
use crate::model::Model;
use crate::numeric::search::brent::Brent;
use crate::numeric::search::parabola::{beyond_zero, may_dip};
use crate::ode::probe::Probe;
use crate::ode::{Observer, Step};
use std::ops::ControlFlow;

/// A local extremum of the distance of a contact from one of its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extremum {
    pub(crate) contact: usize,
    pub(crate) edge: Edge,
    pub(crate) maximum: bool,
    /// Time of the extremum over the period of the orbit, from its start.
    pub(crate) phase: f64,
    /// Deflection minus edge. At a rebound from a rigid stop: the square of the impact speed, with the sign
    /// of a motion past the stop.
    pub(crate) distance: f64,
}

impl Extremum {
    /// Whether both extremes belong to the same edge and are of the same kind.
    pub(crate) fn is_like(&self, other: &Extremum) -> bool {
        self.is_at(other.contact, other.edge) && self.maximum == other.maximum
    }
    /// Whether it belongs to this edge of a contact.
    pub(crate) fn is_at(&self, contact: usize, edge: Edge) -> bool {
        (self.contact, self.edge) == (contact, edge)
    }
    /// Distance past the edge; negative on the side of the gap.
    pub(crate) fn depth(&self) -> f64 {
        self.edge.outward() * self.distance
    }
    /// Whether the contact turns back here from its way out of the gap: a maximum at the upper edge, or a
    /// minimum at the lower one.
    pub(crate) fn is_outermost(&self) -> bool {
        self.maximum == (self.edge == Edge::Upper)
    }
    /// Distance of two phases on the circle.
    pub(crate) fn apart(&self, phase: f64) -> f64 {
        let d = (self.phase - phase).rem_euclid(1.0);
        d.min(1.0 - d)
    }
}

/// Extremes of neighbouring orbits whose phases differ by more than this share of the period are different
/// ones `[1]`.
pub(crate) const NEAR: f64 = 0.1;

/// Which edges of each contact are rigid stops; empty if none is.
pub(crate) type Rigid = Vec<[bool; 2]>;

/// The extremes of one orbit, and how often each edge of each contact was crossed or struck.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ContactTrace {
    pub(crate) extremes: Vec<Extremum>,
    /// Where a contact nearly turns: its rate comes close to 0 and does not change its sign. In a
    /// neighbouring orbit two extremes may stand there.
    pub(crate) flats: Vec<Extremum>,
    /// For each contact the number of crossings of its lower and its upper edge.
    pub(crate) crossings: Vec<[u32; 2]>,
    /// For each contact the largest rate of its deflection; 0 where it is not measured.
    pub(crate) fastest: Vec<f64>,
    /// For each contact the largest distances from its lower and its upper edge; 0 where they are not
    /// measured.
    pub(crate) reach: Vec<[f64; 2]>,
}

impl ContactTrace {
    /// The largest distance of a contact from its edges.
    pub(crate) fn farthest(&self, contact: usize) -> f64 {
        let of = self.extremes.iter().filter(|e| e.contact == contact);
        of.map(|e| e.distance.abs()).fold(0.0, f64::max)
    }

    pub(crate) fn new(contacts: usize) -> Self {
        ContactTrace {
            extremes: Vec::new(),
            flats: Vec::new(),
            crossings: vec![[0; 2]; contacts],
            fastest: vec![0.0; contacts],
            reach: vec![[0.0; 2]; contacts],
        }
    }
    /// The extremes at rigid stops that are impacts (`past`), or those that do not reach their stop.
    pub(crate) fn at_stops<'t>(&'t self, rigid: &'t Rigid, past: bool) -> impl Iterator<Item = &'t Extremum> {
        self.extremes.iter().filter(move |e| {
            e.edge.is_stop(rigid, e.contact) && (e.depth() > 0.0) == past && e.is_outermost()
        })
    }
    /// The extremum that is closest to this edge of a contact.
    pub(crate) fn closest(&self, contact: usize, edge: Edge) -> Option<&Extremum> {
        let of = self.extremes.iter().filter(|e| e.is_at(contact, edge));
        of.min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()))
    }
    /// The extremum like `near` with the nearest phase.
    pub(crate) fn nearest(&self, near: &Extremum) -> Option<&Extremum> {
        let like = self.extremes.iter().filter(|other| other.is_like(near));
        like.min_by(|a, b| a.apart(near.phase).total_cmp(&b.apart(near.phase)))
    }
}

/// Observer that finds the extremes along an orbit.
pub(crate) struct Tracer<'m> {
    probe: Probe<'m>,
    start: f64,
    period: f64,
    y: Vec<f64>,
    /// Rates relative to the edges at the end of the last step; NaN before the first step.
    last: Vec<[f64; 2]>,
    /// Times of a step, and the rates there.
    samples: Vec<(f64, [f64; 2])>,
    pub(crate) trace: ContactTrace,
}

/// Number of samples in each part of a step.
const SAMPLES_PER_PART: usize = 3;

/// Accuracy of the time of an extremum, as a share of the step `[1]`.
const EXTREMUM_ACCURACY: f64 = 1e-12;

impl<'m> Tracer<'m> {
    pub(crate) fn new(model: &'m dyn Model, start: f64, period: f64) -> Self {
        let contacts = model.offers().touching(model.contacts());
        Tracer {
            probe: Probe::new(model),
            start,
            period,
            y: vec![0.0; 2 * model.dof()],
            last: vec![[f64::NAN; 2]; contacts],
            samples: Vec::new(),
            trace: ContactTrace::new(contacts),
        }
    }

    fn keep(&mut self, contact: usize, edge: Edge, maximum: bool, t: f64, distance: f64) {
        if distance.is_finite() {
            let phase = (t - self.start) / self.period;
            self.trace.extremes.push(Extremum { contact, edge, maximum, phase, distance });
        }
    }

    /// The contact at the time `t` of a step.
    fn at(&mut self, step: &mut Step<'_>, contact: usize, t: f64) -> Contact {
        let side = if t == step.t1() { Side::Before } else { Side::After };
        step.at(t, &mut self.y);
        let (q, v) = self.y.split_at(self.y.len() / 2);
        self.probe.read_contacts(t, side, q, v)[contact]
    }

    /// Locates the extremum between two times at which the rate has different signs.
    fn refine(&mut self, step: &mut Step<'_>, contact: usize, edge: Edge, from: [f64; 2], to: [f64; 2]) {
        let mut brent = Brent::new(from, to, EXTREMUM_ACCURACY * (step.t1() - step.t0()));
        while let Some(t) = brent.next() {
            let c = self.at(step, contact, t);
            brent.take(t, edge.rate(&c));
        }
        let c = self.at(step, contact, brent.best());
        self.keep(contact, edge, from[1] > 0.0, brent.best(), edge.distance(&c));
    }

    /// Samples the rates of a contact over a step. A rate that jumps between two steps, at a kink of an edge,
    /// is an extremum.
    fn sample(&mut self, step: &mut Step<'_>, contact: usize) {
        let parts = step.parts() * SAMPLES_PER_PART;
        self.samples.clear();
        for k in 0..=parts {
            let t = if k == parts {
                step.t1()
            } else {
                step.t0() + (step.t1() - step.t0()) * (k as f64 / parts as f64)
            };
            let c = self.at(step, contact, t);
            let rates = Edge::BOTH.map(|edge| edge.rate(&c));
            self.samples.push((t, rates));
            if k > 0 {
                let fastest = &mut self.trace.fastest[contact];
                *fastest = fastest.max(c.rate.abs());
                for edge in Edge::BOTH {
                    let reach = &mut self.trace.reach[contact][edge as usize];
                    *reach = reach.max(edge.distance(&c).abs());
                }
                continue;
            }
            for edge in Edge::BOTH {
                let last = self.last[contact][edge as usize];
                if last * rates[edge as usize] < 0.0 {
                    self.keep(contact, edge, last > 0.0, t, edge.distance(&c));
                }
            }
        }
        self.last[contact] = self.samples[parts].1;
    }

    /// Locates the extremes between the samples of a step: one where the rate changes its sign, two where it
    /// passes 0 and comes back.
    fn turns(&mut self, step: &mut Step<'_>, contact: usize, edge: Edge) {
        let parts = self.samples.len() - 1;
        let sample = |samples: &[(f64, [f64; 2])], k: usize| [samples[k].0, samples[k].1[edge as usize]];
        for k in 0..parts {
            let [from, to] = [k, k + 1].map(|k| sample(&self.samples, k));
            if from[1] * to[1] < 0.0 {
                self.refine(step, contact, edge, from, to);
                continue;
            }
            let beside = [k.checked_sub(1), (k + 2 <= parts).then_some(k + 2)];
            let [before, after] = beside.map(|k| k.map(|k| sample(&self.samples, k)[1]));
            let dips = before.is_some_and(|before| may_dip([before, from[1], to[1]], [1.0; 2]))
                || after.is_some_and(|after| may_dip([after, to[1], from[1]], [1.0; 2]));
            if !dips {
                continue;
            }
            let rate = |t: f64| edge.rate(&self.at(step, contact, t));
            if let Some(inside) = beyond_zero(from, to, rate) {
                self.refine(step, contact, edge, from, inside);
                self.refine(step, contact, edge, inside, to);
            } else {
                let distance = edge.distance(&self.at(step, contact, to[0]));
                let phase = (to[0] - self.start) / self.period;
                let maximum = from[1] > 0.0;
                self.trace.flats.push(Extremum { contact, edge, maximum, phase, distance });
            }
        }
    }
}

impl Observer for Tracer<'_> {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        for contact in 0..self.last.len() {
            self.sample(step, contact);
            for edge in Edge::BOTH {
                self.turns(step, contact, edge);
            }
        }
        let touching = self.last.len();
        for crossing in step.crossings().iter().filter(|crossing| crossing.contact < touching) {
            let contact = crossing.contact;
            let edge = Edge::between(crossing.from, crossing.to);
            self.trace.crossings[contact][edge as usize] += 1;
            if crossing.rebounds {
                let speed = self.last[contact][edge as usize];
                self.keep(contact, edge, edge == Edge::Upper, step.t1(), edge.outward() * speed * speed);
                self.last[contact] = [f64::NAN; 2];
            }
        }
        ControlFlow::Continue(())
    }
}
