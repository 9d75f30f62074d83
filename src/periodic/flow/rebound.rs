//! Jump of small differences at an impact on a rigid stop.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::State;
use crate::numeric::differences::CENTRAL;
use crate::numeric::norms::{dot, largest_share};
use crate::ode::IntegrateError;
use crate::ode::edges::collisions::{Next, speed};
use crate::ode::edges::exit::Exit;
use crate::periodic::flow::saltation::{ImpactScratch, Saltation, share_of_drives};

/// Step of the differences of the velocities after an impact, as a share of the size of the motion `[1]`.
const PROBE_STEP: f64 = 3e-4;

/// A start at this distance from a stop, as a share of the deflection, is on the stop `[1]`.
const ON_STOP: f64 = 1e-12;

/// Differences between two impacts below this share do not count `[1]`.
const SAME: f64 = 1e-7;

/// Maximum number of divisions of the step by 4, until no drive edge lies between its instants.
const QUARTERINGS: usize = 8;

impl Saltation<'_> {
    /// Applies impacts at once to a start on rigid stops that moves into them.
    pub(crate) fn begin(&mut self, state: &mut State) {
        if self.rigid.iter().flatten().all(|rigid| !rigid) {
            return;
        }
        self.q.copy_from_slice(&state.q);
        self.v.copy_from_slice(&state.v);
        self.contact_at(0, state.t);
        let pieces = self.pieces.iter_mut().zip(&self.contacts).zip(&self.rigid);
        pieces.for_each(|((piece, c), rigid)| {
            *piece = if rigid.contains(&true) { Piece::Gap } else { c.piece() };
        });
        self.collide(state.t, |exit, c| {
            exit.distance(Piece::Gap, c, 1.0).value <= ON_STOP * c.deflection.abs()
        });
        state.q.copy_from_slice(&self.q);
        state.v.copy_from_slice(&self.v);
    }

    /// Applies all impacts of an instant in the order of [`collisions`](crate::ode::edges::collisions).
    /// `touches`: whether a contact is on its stop.
    ///
    /// Neighbours of the motion reach the stops one after another, in an order of their own. The derivative
    /// exists if the order does not matter: impacts that do not change the approach of one another, or stops
    /// that all neighbours reach together. A contact that only earlier impacts set in motion strikes after
    /// them in all neighbours. `refused` is set where the derivative does not exist and where contacts come
    /// to rest.
    pub(crate) fn collide(&mut self, t: f64, touches: impl Fn(Exit, &Contact) -> bool) {
        self.collisions.begin();
        loop {
            self.contact_at(0, t);
            let next = self.collisions.next(&self.contacts, &touches);
            let Some(first) = self.collisions.chosen().next() else { return };
            if next == Next::Apart {
                return;
            }
            if next == Next::Rest {
                self.refused = Some(IntegrateError::RestsOnStop { t, contact: first.contact });
                return;
            }
            if let Some(limit) = self.collisions.exceeded() {
                self.refused = Some(IntegrateError::TooManyImpacts { t, contact: first.contact, limit });
                return;
            }
            let others: Vec<Exit> = self.collisions.approached().filter(|exit| *exit != first).collect();
            if let Some(other) = others.into_iter().find(|other| self.depend(first, *other, t)) {
                let (contact, other) = (first.contact, other.contact);
                self.refused = Some(IntegrateError::SimultaneousImpacts { t, contact, other });
                return;
            }
            self.rebound(first, t);
        }
    }

    /// Whether the motion after impacts on two stops depends on their order.
    fn depend(&mut self, a: Exit, b: Exit, t: f64) -> bool {
        let speeds = |contacts: &[Contact]| [a, b].map(|exit| speed(exit, &contacts[exit.contact]));
        let before = speeds(&self.contacts);
        let changes = [a, b].map(|exit| {
            let (q, v) = (&self.q[..self.n], &self.v[..self.n]);
            self.impact.after.copy_from_slice(v);
            self.model.impact(exit.contact, exit.edge.flank(), &self.u, q, &mut self.impact.after);
            self.model.contact(&self.u, q, &self.impact.after, &mut self.contacts);
            speeds(&self.contacts)
        });
        let moved = |by: usize, of: usize| (changes[by][of] - before[of]).abs();
        if moved(0, 1) <= SAME * moved(0, 0) && moved(1, 0) <= SAME * moved(1, 1) {
            return false;
        }
        // ∇h/h' of both stops: the times by which neighbours arrive earlier.
        let [of_a, of_b] = [a, b].map(|exit| {
            self.contact_at(exit.contact, t);
            self.slope(exit.contact, exit.edge);
            self.gradient[..self.n].to_vec()
        });
        let times = of_a.iter().zip(&of_b).map(|(a, b)| (a * before[1], b * before[0]));
        let sign = a.edge.sign_on(Piece::Gap) * b.edge.sign_on(Piece::Gap);
        let largest = times.clone().fold(0.0f64, |m, (a, b)| m.max(a.abs()).max(b.abs()));
        times.into_iter().any(|(a, b)| (a - sign * b).abs() > SAME * largest)
    }

    /// δq⁺ = δq - v σ + v⁺ σ, δv⁺ = ∂V (-σ, δq - v σ, δv - a σ) + a⁺ σ: the differences after an impact.
    ///
    /// The impact is q⁺ = q, v⁺ = V(t, q, v) at h(t, q) = 0. σ = ∇h·δq/h' is the time by which a neighbour
    /// arrives earlier. The direction of the derivative of V is tangent to the stop. `refused` is set if the
    /// contact comes to rest on the stop.   Source: Leine & Nijmeijer, Sect. 7.4; Müller, Chaos Solitons
    /// Fractals 5, 1671 (1995).
    ///
    /// For a difference with respect to a parameter, ∇h·δq contains ∂h/∂u u', and the direction contains u'.
    ///
    /// For one coordinate and a stop at rest the saltation matrix is [[-e, 0], [(a⁺ + e a)/v, -e]].
    fn rebound(&mut self, exit: Exit, t: f64) {
        let (n, Exit { contact, edge }) = (self.n, exit);
        let (c, on) = (self.contact_at(contact, t), edge.flank());
        self.slope(contact, edge);
        self.move_onto(edge.distance(&c));
        let rate = edge.rate(&c);
        let (q, v) = (&self.on_edge[..n], &self.v[..n]);
        self.model.accel_on_pieces(&self.pieces, &self.u, q, v, &mut self.before);
        self.impact.after.copy_from_slice(v);
        self.model.impact(contact, on, &self.u, q, &mut self.impact.after);
        self.model.accel_on_pieces(&self.pieces, &self.u, q, &self.impact.after, &mut self.jump);
        self.along_drives(contact, edge);
        let first = self.q.len() / n - self.forced.len();
        for k in (n..self.q.len()).step_by(n) {
            let parameter = (k / n).checked_sub(first);
            let speed = parameter.map_or(0.0, |p| self.forced[p].speed);
            let by_drives = parameter.map_or(0.0, |p| self.by_drives[p]);
            let sooner = (dot(&self.gradient[..n], &self.q[k..k + n]) + by_drives) / rate;
            for i in 0..n {
                self.v[k + i] += speed * self.v[i];
                self.q[k + i] -= sooner * self.v[i];
                self.v[k + i] -= sooner * self.before[i];
                self.impact.direction[0][i] = self.q[k + i];
                self.impact.direction[1][i] = self.v[k + i];
            }
            self.along(contact, on, t, -sooner, parameter);
            for i in 0..n {
                self.q[k + i] += sooner * self.impact.after[i];
                self.v[k + i] = self.impact.slope[i] + sooner * self.jump[i] - speed * self.impact.after[i];
            }
        }
        self.v[..n].copy_from_slice(&self.impact.after);
        let c = self.contact_at(contact, t);
        let (speed, flight) = (edge.rate(&c).abs(), &mut self.impact.flights[contact]);
        if !self.collisions.arrives(exit) {
            flight.leaves(t, speed);
        } else if flight.lands(t, speed, ON_STOP * c.deflection.abs()) {
            self.refused = Some(IntegrateError::RestsOnStop { t, contact });
        }
    }

    /// Derivative of the velocities after an impact along (dt, direction), and along the change of the drives
    /// by a parameter; stored in `impact.slope`.
    fn along(&mut self, contact: usize, on: Piece, t: f64, dt: f64, parameter: Option<usize>) {
        let forced = self.forced;
        let along = parameter.map_or(&[][..], |p| &forced[p].drives);
        let (model, n, ImpactScratch { u, q, v, slope, direction: [dq, dv], .. }) =
            (self.model, self.n, &mut self.impact);
        let (of_q, of_v) = self.scale.split_at(n);
        // Size of dt: the motion during dt, as a share of the size of the coordinates.
        let by_time = of_v.iter().zip(of_q).fold(0.0, |m: f64, (v, q)| m.max(dt.abs() * v / q));
        let by_drives = share_of_drives(&self.u, along);
        let length = largest_share(dq, of_q).max(largest_share(dv, of_v)).max(by_time).max(by_drives);
        slope.fill(0.0);
        if length == 0.0 {
            return;
        }
        let mut step = PROBE_STEP / length;
        for _ in 0..QUARTERINGS {
            let reach = 2.0 * step * dt.abs();
            if model.next_edge(t - reach).is_none_or(|edge| edge > t + reach) {
                break;
            }
            step *= 0.25;
        }
        for (place, weight) in CENTRAL {
            model.drive(t + place * step * dt, Side::Before, u);
            u.iter_mut().zip(along).for_each(|(u, w)| *u += place * step * w);
            for i in 0..n {
                q[i] = self.on_edge[i] + place * step * dq[i];
                v[i] = self.on_edge[n + i] + place * step * dv[i];
            }
            model.impact(contact, on, u, q, v);
            slope.iter_mut().zip(&*v).for_each(|(slope, v)| *slope += weight * v / step);
        }
    }
}
