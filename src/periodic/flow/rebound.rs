//! Jump of small differences at an impact on a rigid stop.

use crate::contact::Piece;
use crate::contact::edge::Edge;
use crate::excitation::Side;
use crate::model::{Model, State};
use crate::numeric::differences::CENTRAL;
use crate::numeric::norms::{dot, largest_share};
use crate::periodic::flow::impact::ImpactScratch;
use crate::periodic::flow::saltation::{Saltation, share_of_drives};

/// Step of the differences of the velocities after an impact, as a share of the size of the motion `[1]`.
const PROBE_STEP: f64 = 3e-4;

/// A start at this distance from a stop, as a share of the deflection, is on the stop `[1]`.
const ON_STOP: f64 = 1e-12;

/// Maximum number of divisions of the step by 4, until no drive edge lies between its instants.
const QUARTERINGS: usize = 8;

impl<M: Model + ?Sized> Saltation<'_, M> {
    /// Applies the impact at once to a start on a rigid stop that moves into the stop.
    pub(crate) fn begin(&mut self, state: &mut State) {
        for k in 0..2 * self.rigid.len() {
            let (contact, edge) = (k / 2, Edge::BOTH[k % 2]);
            if !edge.is_stop(&self.rigid, contact) {
                continue;
            }
            self.q.copy_from_slice(&state.q);
            self.v.copy_from_slice(&state.v);
            let (c, inward) = (self.contact_at(contact, state.t), edge.sign_on(Piece::Gap));
            self.pieces.iter_mut().zip(&self.contacts).for_each(|(piece, c)| *piece = c.piece());
            self.pieces[contact] = Piece::Gap;
            let [above, rate] = [edge.distance(&c), edge.rate(&c)].map(|d| inward * d);
            if above <= ON_STOP * c.deflection.abs() && rate < 0.0 {
                self.rebound(contact, edge.flank(), state.t);
                state.q.copy_from_slice(&self.q);
                state.v.copy_from_slice(&self.v);
            }
        }
    }

    /// δq⁺ = δq - v σ + v⁺ σ, δv⁺ = ∂V (-σ, δq - v σ, δv - a σ) + a⁺ σ: the differences after an impact.
    ///
    /// The impact is q⁺ = q, v⁺ = V(t, q, v) at h(t, q) = 0. σ = ∇h·δq/h' is the time by which a neighbour
    /// arrives earlier. The direction of the derivative of V is tangent to the stop. `rests` is set if the
    /// contact comes to rest on the stop.   Source: Leine & Nijmeijer, Sect. 7.4; Müller, Chaos Solitons
    /// Fractals 5, 1671 (1995).
    ///
    /// For a difference with respect to a parameter, ∇h·δq contains ∂h/∂u u', and the direction contains u'.
    ///
    /// For one coordinate and a stop at rest the saltation matrix is [[-e, 0], [(a⁺ + e a)/v, -e]].
    pub(crate) fn rebound(&mut self, contact: usize, on: Piece, t: f64) {
        let n = self.n;
        let (c, edge) = (self.contact_at(contact, t), Edge::between(Piece::Gap, on));
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
        let speed = edge.rate(&c).abs();
        if self.impact.flights[contact].lands(t, speed, ON_STOP * c.deflection.abs()) {
            self.rests = Some(contact);
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
