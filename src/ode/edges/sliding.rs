//! Motions that slide along an edge whose deflection depends on velocities.
//!
//! The rate of such a deflection contains accelerations and may jump at the edge. If it points to the edge on
//! both sides, no motion leaves the edge: it slides (Filippov), and runs that go on would cross the edge
//! without end. A deflection of coordinates and time alone has one rate on both sides.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::numeric::spread::sign_patterns;
use crate::ode::edges::exit::Exit;
use crate::ode::step::Crossing;
use crate::ode::stepping::ends::{Ends, halves};
use crate::ode::stepping::vector::Vector;

/// Time over which rates are differences, as a share of the step before the crossing `[1]`.
const SPAN: f64 = 1e-6;

/// The time grows by this factor until the differences exceed [`ABOVE`] times their rounding.
const GROWTH: f64 = 100.0;
const ABOVE: f64 = 100.0;

/// A rate away from the edge, as a share of the rate towards it on the other side, that counts as 0 `[1]`.
const NEUTRAL: f64 = 1e-6;

/// Change of the velocities that shows whether a deflection depends on them, as a share of 1 + |v| `[1]`.
const SHAKE: f64 = 1e-3;

/// The check of crossings. Its lists are empty until it is prepared.
#[derive(Default)]
pub(crate) struct Sliding {
    /// Whether the deflection of each contact depends on velocities; `None`: not known.
    by_velocities: Vec<Option<bool>>,
    /// The pieces before and after the crossings.
    pieces: [Vec<Piece>; 2],
    /// Scratch: drives, a state before or after, contacts, accelerations.
    u: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    contacts: Vec<Contact>,
}

impl Sliding {
    /// Takes note of the contacts whose deflection does not depend on velocities; of the others it is not
    /// known.
    pub(crate) fn know(&mut self, by_velocities: &[bool]) {
        self.by_velocities.clear();
        self.by_velocities.extend(by_velocities.iter().map(|by| if *by { None } else { Some(false) }));
    }

    /// Makes the lists as long as a model needs them, unless it is known that none is needed. Steps then do
    /// not allocate.
    pub(crate) fn prepare<V: Vector>(&mut self, e: &Ends<'_, V>) {
        let known = |by: &Option<bool>| *by == Some(false);
        let all = !self.by_velocities.is_empty() && self.by_velocities.iter().all(known);
        if !all && !e.contacts.is_empty() {
            self.make_room(e);
        }
    }

    fn make_room<V: Vector>(&mut self, e: &Ends<'_, V>) {
        let (contacts, n) = (e.contacts.len(), e.model.dof());
        self.by_velocities.resize(contacts, None);
        self.pieces.iter_mut().for_each(|pieces| pieces.resize(contacts, Piece::Gap));
        self.contacts.resize(contacts, Contact::default());
        self.u.clone_from(&e.u_stage);
        [&mut self.q, &mut self.v, &mut self.a].into_iter().for_each(|list| list.resize(n, 0.0));
    }

    /// The contact, if any, on whose edge the motion slides after the `crossings` at the end of the step.
    /// `until`: the next drive edge; `noise`: the effect of rounding on each deflection.
    pub(crate) fn find<V: Vector>(
        &mut self,
        e: &Ends<'_, V>,
        crossings: &[Crossing],
        until: f64,
        noise: &[f64],
    ) -> Option<usize> {
        let known = |c: &Crossing| self.by_velocities.get(c.contact) == Some(&Some(false));
        if crossings.iter().any(|c| c.rebounds) || crossings.iter().all(known) {
            return None;
        }
        self.make_room(e);
        let [before, after] = &mut self.pieces;
        before.copy_from_slice(&e.pieces);
        after.copy_from_slice(&e.pieces);
        for crossing in crossings {
            let Contact { lower, upper, .. } = e.contacts[crossing.contact];
            // The other side of a gap without width is the other flank.
            after[crossing.contact] = match crossing.from {
                Piece::Upper if upper <= lower => Piece::Lower,
                Piece::Lower if upper <= lower => Piece::Upper,
                _ => crossing.to,
            };
        }
        let mut all = crossings.iter();
        all.find(|c| self.depends(e, c.contact) && self.slides(e, c, until, noise[c.contact]))
            .map(|c| c.contact)
    }

    /// Whether the deflection of a contact depends on velocities.
    fn depends<V: Vector>(&mut self, e: &Ends<'_, V>, contact: usize) -> bool {
        if let Some(known) = self.by_velocities[contact] {
            return known;
        }
        let (q, v) = halves(&e.y1);
        let found = sign_patterns(v.len()).any(|sign| {
            let components = self.v.iter_mut().zip(v).enumerate();
            components.for_each(|(j, (shaken, v))| *shaken = v + sign(j) * SHAKE * (1.0 + v.abs()));
            e.model.contact(e.nodes.end(), q, &self.v, &mut self.contacts);
            let [at, here] = [&self.contacts[contact], &e.contacts[contact]];
            [at.deflection, at.lower, at.upper] != [here.deflection, here.lower, here.upper]
        });
        self.by_velocities[contact] = Some(found);
        found
    }

    /// Whether the distance of a contact from the edge that it crosses falls on both sides.
    fn slides<V: Vector>(&mut self, e: &Ends<'_, V>, crossing: &Crossing, until: f64, noise: f64) -> bool {
        let exit = Exit::of(crossing);
        let mut span = SPAN * e.h();
        while span <= e.h().min(until - e.t1) {
            let rates = [0, 1].map(|side| self.rate(e, exit, crossing.from, side, span));
            if let [Some(before), Some(after)] = rates
                && span * before.abs().min(after.abs()) > ABOVE * noise
            {
                return before < 0.0 && after > -NEUTRAL * before;
            }
            span *= GROWTH;
        }
        false
    }

    /// Rate of the distance from an edge, positive on the piece `from`, along the motion on one side of it.
    /// `side`: 0 before the crossing, 1 after it. `None` if the states within the time `span` lie on the
    /// other side.
    fn rate<V: Vector>(
        &mut self,
        e: &Ends<'_, V>,
        exit: Exit,
        from: Piece,
        side: usize,
        span: f64,
    ) -> Option<f64> {
        let (q, v) = halves(&e.y1);
        if e.model.offers().pieces {
            e.model.accel_on_pieces(&self.pieces[side], e.nodes.end(), q, v, &mut self.a);
        } else {
            // A state beside the edge, along the mean rates of the step.
            let share = if side == 0 { -span / e.h() } else { span / e.h() };
            let (q0, v0) = halves(&e.y);
            for j in 0..q.len() {
                self.q[j] = q[j] + share * (q[j] - q0[j]);
                self.v[j] = v[j] + share * (v[j] - v0[j]);
            }
            e.model.contact(e.nodes.end(), &self.q, &self.v, &mut self.contacts);
            let here = exit.distance(from, &e.contacts[exit.contact], 1.0).value;
            let beside = exit.distance(from, &self.contacts[exit.contact], 1.0).value;
            if beside * share >= 0.0 || beside.abs() < 2.0 * here.abs() {
                return None;
            }
            e.model.accel(e.nodes.end(), &self.q, &self.v, &mut self.a);
        }
        let [earlier, later] = [-span, span].map(|time| {
            for j in 0..q.len() {
                self.q[j] = q[j] + time * v[j];
                self.v[j] = v[j] + time * self.a[j];
            }
            e.model.redrive(&[e.t1 + time], Side::Before, &mut self.u);
            e.model.contact(&self.u, &self.q, &self.v, &mut self.contacts);
            exit.distance(from, &self.contacts[exit.contact], 1.0).value
        });
        Some((later - earlier) / (2.0 * span))
    }
}
