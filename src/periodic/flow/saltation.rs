//! Jump of small differences at tooth edges.

use crate::contact::edge::Edge;
use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::Model;
use crate::model::drive_slope::DriveSlope;
use crate::numeric::differences::{CENTRAL, ONE_SIDED};
use crate::numeric::norms::{dot, largest_share};
use crate::ode::edges::collisions::Collisions;
use crate::ode::edges::exit::Exit;
use crate::ode::edges::stops::Flight;
use crate::ode::{IntegrateError, Step};
use crate::periodic::flow::continued::gradient;
use crate::periodic::flow::tangent::Tangent;

/// δ⁺ = δ + (f⁺ - f⁻) (∇h·δ)/h': the jump of the differences at an edge at which the acceleration jumps.
///
/// f⁻ and f⁺ are the right-hand sides before and after the edge and h is the distance past the edge, with the
/// rate h' = ∇h·f⁻ + ∂h/∂t. ∇h holds the derivatives with respect to the coordinates and, if a deflection
/// depends on the velocities, with respect to the velocities. Without a jump of the acceleration the
/// differences do not change. For a difference with respect to a parameter, ∇h·δ contains ∂h/∂u u'.   Source:
/// Leine & Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Sect. 7.4.
pub(crate) struct Saltation<'t> {
    pub(crate) model: &'t dyn Model,
    pub(crate) n: usize,
    pub(crate) scale: &'t [f64],
    pub(crate) u: Vec<f64>,
    pub(crate) pieces: Vec<Piece>,
    pub(crate) contacts: Vec<Contact>,
    /// ∂h/∂q, then ∂h/∂v.
    pub(crate) gradient: Vec<f64>,
    /// The state moved onto the edge.
    pub(crate) on_edge: Vec<f64>,
    /// Acceleration before the edge.
    pub(crate) before: Vec<f64>,
    /// Acceleration after the edge, then its jump.
    pub(crate) jump: Vec<f64>,
    /// A state shifted for the derivatives of a deflection.
    pub(crate) moved: Vec<f64>,
    /// Coordinates and velocities of the motion and its differences after the edges.
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// Drives shifted for ∂h/∂u.
    pub(crate) moved_drives: Vec<f64>,
    /// Scratch: ∂h/∂u u' for each of the last differences.
    pub(crate) by_drives: Vec<f64>,
    /// Slopes of the drives for the last differences.
    pub(crate) forced: &'t [DriveSlope],
    /// Edges that are rigid stops; empty if there are none.
    pub(crate) rigid: Vec<[bool; 2]>,
    /// Impacts at one instant.
    pub(crate) collisions: Collisions,
    /// Why the flow has no derivative after the last impacts.
    pub(crate) refused: Option<IntegrateError>,
    /// Scratch arrays for impacts.
    pub(crate) impact: ImpactScratch,
}

/// Scratch arrays for the derivative of an impact. V are the velocities after the impact.
pub(crate) struct ImpactScratch {
    /// Drives, coordinates and velocities of a neighbouring motion at its impact.
    pub(crate) u: Vec<f64>,
    pub(crate) q: Vec<f64>,
    /// Velocities of the motion after the impact.
    pub(crate) after: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// Derivative of V along the direction (-σ, δq, δv); σ is the time by which a neighbour arrives earlier.
    pub(crate) slope: Vec<f64>,
    /// δq and δv of the direction.
    pub(crate) direction: [Vec<f64>; 2],
    /// The last impact of each contact.
    pub(crate) flights: Vec<Flight>,
}

impl ImpactScratch {
    /// `stops`: whether the model has rigid stops. The arrays of a model without rigid stops are empty.
    pub(crate) fn new(model: &dyn Model, stops: bool) -> Self {
        let [dof, drives, contacts] =
            [model.dof(), model.drives(), model.contacts()].map(|count| if stops { count } else { 0 });
        let zeros = || vec![0.0; dof];
        ImpactScratch {
            flights: vec![Flight::NONE; contacts],
            u: vec![0.0; drives],
            q: zeros(),
            after: zeros(),
            v: zeros(),
            slope: zeros(),
            direction: [zeros(), zeros()],
        }
    }
}

/// A jump of the differences by less than this share of their size does not interrupt the run `[1]`.
const NEGLIGIBLE: f64 = 1e-10;

/// Spacing of the four instants of the one-sided difference for ∂h/∂t before an edge, as a share of the
/// integration step `[1]`.
const BACK: f64 = 1e-3;

/// Minimum of this spacing, as a share of the time `[1]`.
const LEAST_SPACING: f64 = 1e-8;

/// Step of the differences with respect to the drives, as a share of the drives `[1]`.
const DRIVE_STEP: f64 = 1e-3;

/// max |w_i|/max(|u_i|, |w_i|): a change w of the drives u as a share of them.
pub(crate) fn share_of_drives(u: &[f64], w: &[f64]) -> f64 {
    let share = |(u, w): (&f64, &f64)| if *w == 0.0 { 0.0 } else { w.abs() / u.abs().max(w.abs()) };
    u.iter().zip(w).map(share).fold(0.0, f64::max)
}

impl<'t, 'm> Saltation<'t> {
    pub(crate) fn new(tangent: &'t Tangent<'m>) -> Self {
        let (model, n) = (&tangent.model, tangent.n);
        let rigid = model.offers().rigid_edges(model.contacts());
        Saltation {
            collisions: Collisions::new(&rigid, n),
            model,
            n,
            scale: tangent.scale,
            u: vec![0.0; model.drives()],
            pieces: vec![Piece::Gap; model.contacts()],
            contacts: vec![Contact::default(); model.contacts()],
            gradient: vec![0.0; 2 * n],
            on_edge: vec![0.0; 2 * n],
            before: vec![0.0; n],
            jump: vec![0.0; n],
            moved: vec![0.0; 2 * n],
            moved_drives: vec![0.0; model.drives()],
            q: vec![0.0; n * (1 + tangent.columns)],
            v: vec![0.0; n * (1 + tangent.columns)],
            forced: tangent.forced,
            by_drives: vec![0.0; tangent.forced.len()],
            refused: None,
            impact: ImpactScratch::new(model, !rigid.is_empty()),
            rigid,
        }
    }
}

impl Saltation<'_> {
    /// Coordinates of the motion and its differences directly after the most recent step that ended on edges,
    /// with the jumps applied.
    pub(crate) fn coordinates(&self) -> &[f64] {
        &self.q
    }
    /// Velocities of the motion and its differences at the same instant.
    pub(crate) fn velocities(&self) -> &[f64] {
        &self.v
    }

    /// Whether the differences jump at the end of a step. `coordinates` and `velocities` then hold their
    /// values after the jump.
    pub(crate) fn changes(&mut self, step: &mut Step<'_>) -> bool {
        let Some(pieces) = step.pieces().filter(|_| !step.crossings().is_empty()) else {
            return false;
        };
        self.pieces.copy_from_slice(pieces);
        self.q.copy_from_slice(step.q1());
        self.v.copy_from_slice(step.v1());
        let (mut changed, mut rebounds) = (false, false);
        for crossing in step.crossings() {
            if !crossing.rebounds {
                changed |= self.cross(crossing.contact, crossing.to, [step.t0(), step.t1()]);
            } else if !rebounds {
                // The stops that are struck at this instant are known; their order is found again.
                let crossings = step.crossings();
                let met = |exit: Exit| crossings.iter().any(|c| c.rebounds && Exit::of(c) == exit);
                self.collide(step.t1(), |exit, _| met(exit));
                rebounds = true;
            }
        }
        changed | rebounds
    }

    /// Computes ∇h of a contact at an edge. Returns whether h depends on the velocities.
    ///
    /// If h does not depend on them, h' is linear in the velocities and its coefficients are ∂h/∂q. Otherwise
    /// ∇h is computed by differences of h.
    pub(crate) fn slope(&mut self, contact: usize, edge: Edge) -> bool {
        let n = self.n;
        let (model, u, contacts, q) = (self.model, &self.u, &mut self.contacts, &self.q[..n]);
        self.moved[..n].copy_from_slice(q);
        self.moved[n..].copy_from_slice(&self.v[..n]);
        let mut by_velocity = false;
        for j in 0..n {
            let here = self.moved[n + j];
            let [above, below] = [1.0, -1.0].map(|side| {
                self.moved[n + j] = here + side * self.scale[n + j];
                model.contact(u, q, &self.moved[n..], contacts);
                contacts[contact]
            });
            self.moved[n + j] = here;
            let rate = (above.rate - below.rate) - (edge.position_rate(&above) - edge.position_rate(&below));
            self.gradient[j] = rate / (2.0 * self.scale[n + j]);
            self.gradient[n + j] = 0.0;
            by_velocity |= edge.distance(&above) != edge.distance(&below);
        }
        if by_velocity {
            let mut h = |q: &[f64], v: &[f64]| {
                model.contact(u, q, v, contacts);
                edge.distance(&contacts[contact])
            };
            gradient(&mut h, &mut self.moved, self.scale, &mut self.gradient);
        }
        by_velocity
    }

    /// Computes `on_edge` = y - missed S² g/|S g|², with g = ∇h and S = diag(scale): the state y moved onto
    /// the edge. `missed` is the error of the located edge. On the edge a continuous acceleration has no
    /// jump.
    pub(crate) fn move_onto(&mut self, missed: f64) {
        let square: f64 = self.gradient.iter().zip(self.scale).map(|(g, s)| (g * s) * (g * s)).sum();
        let part = if square > 0.0 { missed / square } else { 0.0 };
        let here = self.q[..self.n].iter().chain(&self.v[..self.n]);
        for ((on_edge, y), (g, s)) in
            self.on_edge.iter_mut().zip(here).zip(self.gradient.iter().zip(self.scale))
        {
            *on_edge = y - part * g * s * s;
        }
    }

    /// h' = ∂h/∂t + ∂h/∂q q' + ∂h/∂v q'' for an h that depends on the velocities; q'' is the acceleration
    /// before the edge.
    fn rate(&mut self, contact: usize, edge: Edge, [from, to]: [f64; 2]) -> f64 {
        // Far from time zero a share of a short step is below the rounding error of the time.
        let (n, back) = (self.n, (BACK * (to - from)).max(LEAST_SPACING * to.abs()));
        let mut by_time = 0.0;
        for (place, weight) in ONE_SIDED {
            self.model.drive(to - place * back, Side::Before, &mut self.u);
            self.model.contact(&self.u, &self.q[..n], &self.v[..n], &mut self.contacts);
            by_time -= weight * edge.distance(&self.contacts[contact]) / back;
        }
        self.model.drive(to, Side::Before, &mut self.u);
        let (by_q, by_v) = self.gradient.split_at(n);
        by_time + dot(by_q, &self.v[..n]) + dot(by_v, &self.before)
    }

    /// Computes ∂h/∂u u' of a contact for each parameter, by central differences of fourth order. Most
    /// deflections and edges are linear in the drives; the differences are then exact to rounding.
    pub(crate) fn along_drives(&mut self, contact: usize, edge: Edge) {
        for (by, out) in self.forced.iter().zip(&mut self.by_drives) {
            let largest = share_of_drives(&self.u, &by.drives);
            *out = 0.0;
            if largest == 0.0 {
                continue;
            }
            let step = DRIVE_STEP / largest;
            for (place, weight) in CENTRAL {
                self.moved_drives.iter_mut().zip(self.u.iter().zip(&by.drives)).for_each(
                    |(moved, (u, w))| {
                        *moved = u + place * step * w;
                    },
                );
                let (q, v) = (&self.q[..self.n], &self.v[..self.n]);
                self.model.contact(&self.moved_drives, q, v, &mut self.contacts);
                *out += weight * edge.distance(&self.contacts[contact]) / step;
            }
        }
    }

    /// Reads a contact at time `t`, before the drives jump.
    pub(crate) fn contact_at(&mut self, contact: usize, t: f64) -> Contact {
        let n = self.n;
        self.model.drive(t, Side::Before, &mut self.u);
        self.model.contact(&self.u, &self.q[..n], &self.v[..n], &mut self.contacts);
        self.contacts[contact]
    }

    /// Applies the jump at one crossing. `times`: start and end of the step. Returns whether the small
    /// differences changed by more than [`NEGLIGIBLE`].
    fn cross(&mut self, contact: usize, to: Piece, times: [f64; 2]) -> bool {
        let n = self.n;
        let c = self.contact_at(contact, times[1]);
        // If the gap has no width, the contact reaches the other flank at the same instant.
        let to = match (self.pieces[contact], to) {
            (Piece::Lower, Piece::Gap) if c.upper <= c.lower => Piece::Upper,
            (Piece::Upper, Piece::Gap) if c.upper <= c.lower => Piece::Lower,
            _ => to,
        };
        let edge = Edge::between(self.pieces[contact], to);
        let by_velocity = self.slope(contact, edge);
        self.move_onto(edge.distance(&c));
        let (on_edge, v) = self.on_edge.split_at(n);
        self.model.accel_on_pieces(&self.pieces, &self.u, on_edge, v, &mut self.before);
        self.pieces[contact] = to;
        self.model.accel_on_pieces(&self.pieces, &self.u, on_edge, v, &mut self.jump);
        let rate = match by_velocity {
            true => self.rate(contact, edge, times),
            false => edge.rate(&c),
        };
        if rate == 0.0 {
            return false;
        }
        self.jump.iter_mut().zip(&self.before).for_each(|(jump, before)| *jump -= before);
        self.along_drives(contact, edge);
        let (dq, (motion, dv), mut changed) = (&self.q[n..], self.v.split_at_mut(n), false);
        let (of_q, of_v) = self.scale.split_at(n);
        let jump = largest_share(&self.jump, of_v);
        let (by_q, by_v) = self.gradient.split_at(n);
        let free = dq.len() / n - self.forced.len();
        for (k, (dq, dv)) in dq.chunks_exact(n).zip(dv.chunks_exact_mut(n)).enumerate() {
            let mut along = dot(by_q, dq) + if by_velocity { dot(by_v, dv) } else { 0.0 };
            if let Some(by) = k.checked_sub(free).map(|k| &self.forced[k]) {
                along += self.by_drives[k - free];
                along += if by_velocity { by.speed * dot(by_v, motion) } else { 0.0 };
            }
            let share = along / rate;
            changed |=
                (share * jump).abs() > NEGLIGIBLE * largest_share(dq, of_q).max(largest_share(dv, of_v));
            dv.iter_mut().zip(&self.jump).for_each(|(dv, jump)| *dv += jump * share);
        }
        changed
    }
}
