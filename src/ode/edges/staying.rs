//! Motions that stay on a jump, and steps that stay short.
//!
//! - [`Undeclared`]: jumps of the accelerations that the model does not declare, on which the motion stays;
//!   times so late that their rounding exceeds the tolerance.
//! - [`Sliding`]: motions that slide along an edge whose deflection depends on velocities. The rate of such a
//!   deflection contains accelerations and may jump at the edge. If it points to the edge on both sides, no
//!   motion leaves the edge: it slides (Filippov), and runs that go on would cross the edge without end. A
//!   deflection of coordinates and time alone has one rate on both sides.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::Model;
use crate::model::structure::slopes::accelerate;
use crate::numeric::spread::sign_patterns;
use crate::ode::edges::exit::Exit;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::step::Crossing;
use crate::ode::stepping::ends::{Ends, halves};
use crate::ode::stepping::engine::Engine;
use crate::ode::stepping::vector::Vector;

/// Number of rejected steps that are observed together.
const WINDOW: u32 = 128;

/// The second half of these steps is searched for jumps. With this number of jumps of one acceleration the
/// run ends.
const JUMPS: u32 = 32;

/// The steps are short if all of them together are shorter than this share of the longest attempt `[1]`.
const SHORT: f64 = 0.1;

/// A jump is searched over this number of steps ahead. Where the motion stays on a jump, it lies within one.
const AHEAD: f64 = 4.0;

/// Number of bisections: as many as a difference of two states has digits.
const BISECTIONS: usize = 60;

/// Share of a change that remains at a jump `[1]`. A sign has a third value, at 0, and keeps half of its
/// change.
const KEPT: f64 = 0.25;

/// Smallest jump, as a share of the largest acceleration `[1]`.
const LEAST: f64 = 1e-6;

/// A time is too late if its rounding changes a velocity by more than the tolerance in a step of this many
/// times the shortest length.
const FEW: f64 = 32.0;

/// Least change of an acceleration by the rounding of the time, as a share of the largest acceleration `[1]`:
/// well above the rounding of the accelerations themselves.
const OF_TIME: f64 = 1e5 * f64::EPSILON;

/// Number of neighbouring times at which the accelerations are compared.
const NEIGHBOURS: u32 = 4;

/// Rejected steps of an adaptive run. At a jump of an acceleration, steps are rejected until one is so short
/// that the jump stays within the tolerance. A motion that passes the jump leaves it with longer steps; a
/// motion that stays on it needs such short steps for ever.
pub(crate) struct Undeclared {
    /// Longest attempt.
    longest: f64,
    /// Time of the first rejection in the window.
    since: f64,
    /// Number of rejections in the window.
    count: u32,
    /// Number of jumps found in the window.
    jumps: u32,
    /// The acceleration that jumps.
    acceleration: usize,
    /// Scratch: drives, a state, and the accelerations at three states.
    u: Vec<f64>,
    look: Vec<f64>,
    a: [Vec<f64>; 3],
}

impl Undeclared {
    /// `u`: the drives at the start `t`; `components`: length of the state; `first`: length of the first
    /// attempt.
    pub(crate) fn new(u: &[f64], components: usize, first: f64, t: f64) -> Self {
        let accelerations = || vec![0.0; components / 2];
        Undeclared {
            longest: first,
            since: t,
            count: 0,
            jumps: 0,
            acceleration: 0,
            u: u.to_vec(),
            look: vec![0.0; components],
            a: [accelerations(), accelerations(), accelerations()],
        }
    }

    /// The current step was rejected because of its error.
    ///
    /// # Errors
    /// [`IntegrateError::Discontinuity`] if many short steps in a row met a jump of an acceleration: the
    /// error names the last one.
    #[cold]
    pub(crate) fn rejected<M: Model + ?Sized, V: Vector>(
        &mut self,
        e: &Engine<'_, M, V>,
    ) -> Result<(), IntegrateError> {
        let (t, h) = (e.ends.t, e.ends.h());
        self.longest = self.longest.max(h);
        if self.count == 0 || self.count >= WINDOW || t - self.since > SHORT * self.longest {
            (self.since, self.count, self.jumps) = (t, 0, 0);
        }
        self.count += 1;
        if self.count <= WINDOW / 2 {
            return Ok(());
        }
        if let Some(acceleration) = self.jump(e) {
            self.jumps += 1;
            self.acceleration = acceleration;
        }
        if self.jumps < JUMPS {
            Ok(())
        } else {
            Err(IntegrateError::Discontinuity { t, acceleration: self.acceleration })
        }
    }

    /// The error for a step `h` below the resolution of the time.
    #[cold]
    pub(crate) fn underflow<M: Model + ?Sized, V: Vector>(
        &mut self,
        e: &Engine<'_, M, V>,
        h: f64,
    ) -> IntegrateError {
        let t = e.ends.t;
        let resolution = f64::EPSILON * t.abs();
        let change = self.change_by_rounding(e, FEW * h.max(resolution));
        if change > 1.0 {
            IntegrateError::LateTime { t, resolution, change }
        } else {
            IntegrateError::StepUnderflow { t, h }
        }
    }

    /// The largest effect of the last digits of the time on a velocity at the end of a step `h`, through the
    /// drives, in tolerances.
    fn change_by_rounding<M: Model + ?Sized, V: Vector>(&mut self, e: &Engine<'_, M, V>, h: f64) -> f64 {
        let Undeclared { u, a: [here, there, _], .. } = self;
        let (t, (q, v)) = (e.ends.t, halves(&e.ends.y));
        let pieces = e.on_fixed_pieces.then_some(&e.ends.pieces[..]);
        let (mut largest, mut time) = (0.0f64, t);
        for neighbour in 0..=NEIGHBOURS {
            e.ends.model.redrive(&[time], Side::After, u);
            let a = if neighbour == 0 { &mut *here } else { &mut *there };
            accelerate(e.ends.model, pieces, u, q, v, a);
            if neighbour > 0 {
                let least = OF_TIME * here.iter().fold(0.0, |m: f64, a| m.max(a.abs()));
                let atol = &e.ends.atol.slice()[v.len()..];
                let rows = here.iter().zip(&*there).zip(v.iter().zip(atol));
                let changes = rows.filter(|((a, b), _)| (*a - *b).abs() > least);
                let shares = changes.map(|((a, b), (v, atol))| h * (a - b).abs() / (atol + e.rtol * v.abs()));
                largest = shares.fold(largest, f64::max);
            }
            time = time.next_up();
        }
        largest
    }

    /// The acceleration that changes most ahead of the start of the step, if it jumps there: bisection keeps
    /// the larger part of the change, and [`KEPT`] of it remains between states that rounding hardly
    /// separates.
    fn jump<M: Model + ?Sized, V: Vector>(&mut self, e: &Engine<'_, M, V>) -> Option<usize> {
        let Undeclared { look, a: [low, high, middle], .. } = self;
        let (y, rates) = (e.ends.y.slice(), e.k[0].slice());
        let pieces = e.on_fixed_pieces.then_some(&e.ends.pieces[..]);
        let mut at = |share: f64, a: &mut [f64]| {
            for (look, (y, rate)) in look.iter_mut().zip(y.iter().zip(rates)) {
                *look = y + share * AHEAD * e.ends.h() * rate;
            }
            let (q, v) = look.split_at(look.len() / 2);
            accelerate(e.ends.model, pieces, e.ends.nodes.end(), q, v, a);
        };
        at(0.0, low);
        at(1.0, high);
        let changes = low.iter().zip(high.iter()).map(|(a, b)| (b - a).abs());
        let (i, change) = changes.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let size = low.iter().chain(high.iter()).fold(0.0, |m: f64, a| m.max(a.abs()));
        if !(change > LEAST * size && size.is_finite()) {
            return None;
        }
        let (mut lo, mut hi, mut from, mut to) = (0.0, 1.0, low[i], high[i]);
        for _ in 0..BISECTIONS {
            let m = 0.5 * (lo + hi);
            at(m, middle);
            if (middle[i] - from).abs() > (to - middle[i]).abs() {
                (hi, to) = (m, middle[i]);
            } else {
                (lo, from) = (m, middle[i]);
            }
        }
        ((to - from).abs() > KEPT * change).then_some(i)
    }
}

/// Time over which rates are differences, as a share of the step before the crossing `[1]`.
const SPAN: f64 = 1e-6;

/// The time grows by this factor until the differences exceed [`ABOVE`] times their rounding.
const GROWTH: f64 = 100.0;
const ABOVE: f64 = 100.0;

/// A rate away from the edge, as a share of the rate towards it on the other side, that counts as 0 `[1]`.
const NEUTRAL: f64 = 1e-6;

/// Change of the velocities that shows whether a deflection depends on them, as a share of 1 + |v| `[1]`.
const SHAKE: f64 = 1e-3;

/// The check of crossings. Its lists are empty for a model without contacts.
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
    pub(crate) fn new<M: Model + ?Sized, V: Vector>(e: &Ends<'_, M, V>, contacts: usize) -> Self {
        let n = if contacts > 0 { e.model.dof() } else { 0 };
        Sliding {
            by_velocities: vec![None; contacts],
            pieces: [vec![Piece::Gap; contacts], vec![Piece::Gap; contacts]],
            u: e.u_stage.clone(),
            q: vec![0.0; n],
            v: vec![0.0; n],
            a: vec![0.0; n],
            contacts: vec![Contact::default(); contacts],
        }
    }

    /// The contact, if any, on whose edge the motion slides after the `crossings` at the end of the step.
    /// `until`: the next drive edge; `noise`: the effect of rounding on each deflection.
    pub(crate) fn find<M: Model + ?Sized, V: Vector>(
        &mut self,
        e: &Ends<'_, M, V>,
        crossings: &[Crossing],
        until: f64,
        noise: &[f64],
    ) -> Option<usize> {
        let known = |c: &Crossing| self.by_velocities[c.contact] == Some(false);
        if crossings.iter().any(|c| c.rebounds) || crossings.iter().all(known) {
            return None;
        }
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
    fn depends<M: Model + ?Sized, V: Vector>(&mut self, e: &Ends<'_, M, V>, contact: usize) -> bool {
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
    fn slides<M: Model + ?Sized, V: Vector>(
        &mut self,
        e: &Ends<'_, M, V>,
        crossing: &Crossing,
        until: f64,
        noise: f64,
    ) -> bool {
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

    /// Rate of the distance from an edge, positive on the piece `from`, along the motion on one `side` of it:
    /// 0 before the crossing, 1 after it. `None` if states within the time `span` are not on that side.
    fn rate<M: Model + ?Sized, V: Vector>(
        &mut self,
        e: &Ends<'_, M, V>,
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
