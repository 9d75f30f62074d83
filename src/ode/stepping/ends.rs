//! The ends of a step: states, drives, contacts and pieces there.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::structure::gaps::{contacts_at, is_in_order};
use crate::model::{Model, State};
use crate::numeric::spread::sign_patterns;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::stepping::kink_rates::KinkRates;
use crate::ode::stepping::nodes::Nodes;
use crate::ode::stepping::vector::Vector;

/// A component above this size grows without bound where steps shrink to nothing.
const UNBOUNDED: f64 = 1e12;

/// The current step of a run, seen from its ends. The method that computes the end adds its own arrays.
pub struct Ends<'m, V: Vector> {
    pub(crate) model: &'m dyn Model,
    /// Start of the step.
    pub(crate) t: f64,
    /// End of the step.
    pub(crate) t1: f64,
    /// t1 - t.
    pub(super) h: f64,
    /// Absolute tolerance of each component; 0 with fixed steps and with Taylor series.
    pub(crate) atol: V,
    /// Coordinates, then velocities, at the start.
    pub(crate) y: V,
    /// Coordinates, then velocities, at the end.
    pub(crate) y1: V,
    /// Two instants. The first one is the last drive edge, or the start of the run if there was none. The
    /// second one is the next drive edge, infinite if there is none.
    pub(crate) edges: [f64; 2],
    /// Drives at an instant that is no node.
    pub(crate) u_stage: Vec<f64>,
    /// Drives at the nodes of the step; the last node is its end.
    pub(crate) nodes: Nodes,
    /// The piece of every contact during the step.
    pub(crate) pieces: Vec<Piece>,
    /// The contacts of the last evaluation.
    pub(crate) contacts: Vec<Contact>,
    kink_rates: KinkRates,
    /// Scratch: a state inside the step.
    pub(crate) look: V,
    /// Scratch: the contacts at a state changed by rounding.
    shaken: Vec<Contact>,
}

impl<'m, V: Vector> Ends<'m, V> {
    /// A run from `start`. Drives are kept at `nodes` instants of a step, for `steps` steps at once.
    pub(crate) fn new(model: &'m dyn Model, start: &State, nodes: usize, steps: usize) -> Self {
        let (drives, contacts, m) = (model.drives(), model.contacts(), 2 * model.dof());
        let mut y = V::zeros(m);
        let (q, v) = y.slice_mut().split_at_mut(m / 2);
        q.copy_from_slice(&start.q);
        v.copy_from_slice(&start.v);
        // `drive` fills all drives once; `redrive` updates only those that change.
        let mut u = vec![0.0; drives];
        model.drive(start.t, Side::After, &mut u);
        Ends {
            model,
            t: start.t,
            t1: start.t,
            h: 0.0,
            edges: [start.t, f64::INFINITY],
            atol: V::zeros(y.slice().len()),
            y1: y.clone(),
            nodes: Nodes::new(&u, nodes, steps),
            kink_rates: KinkRates::new(model, &u),
            u_stage: u,
            pieces: vec![Piece::Gap; contacts],
            contacts: vec![Contact::default(); contacts],
            look: V::zeros(m),
            shaken: vec![Contact::default(); contacts],
            y,
        }
    }

    /// Sets the end of the step.
    #[inline(always)]
    pub(crate) fn aim(&mut self, t1: f64) {
        self.t1 = t1;
        self.h = t1 - self.t;
    }

    /// Length of the step.
    #[inline(always)]
    pub(crate) fn h(&self) -> f64 {
        self.h
    }

    /// Makes the end of the step the start of the next one.
    #[inline(always)]
    pub(crate) fn move_on(&mut self) {
        self.t = self.t1;
        V::hand_over(&mut self.y1, &mut self.y);
    }

    /// Ends the step in the state in which it starts.
    pub(crate) fn stand_still(&mut self) {
        self.y1.slice_mut().copy_from_slice(self.y.slice());
    }

    /// Whether the end of the step is finite and its size is at most `LARGEST`, so that dense output,
    /// channels and their squares do not overflow.
    #[inline(always)]
    pub(crate) fn finite(&self) -> bool {
        self.y1.size() <= LARGEST
    }

    /// The first coordinate or velocity at the end of the step that is not finite or exceeds `LARGEST`.
    pub(crate) fn not_finite(&self) -> Option<usize> {
        self.y1.slice().iter().position(|y| !y.is_finite() || y.abs() > LARGEST)
    }

    /// The acceleration that is NaN at the start of the step.
    #[cold]
    pub(crate) fn nan_acceleration(&self) -> Option<usize> {
        let ((q, v), mut u) = (halves(&self.y), self.u_stage.clone());
        let mut a = vec![0.0; q.len()];
        self.model.drive(self.t, Side::After, &mut u);
        self.model.accel(&u, q, v, &mut a);
        a.iter().position(|a| a.is_nan())
    }

    /// The error for a step whose end is not finite.
    #[cold]
    pub(crate) fn diverged(&self) -> IntegrateError {
        match self.nan_acceleration() {
            Some(acceleration) => IntegrateError::NotANumber { t: self.t, acceleration },
            None => IntegrateError::NotFinite { t: self.t, component: self.not_finite().unwrap_or(0) },
        }
    }

    /// The error for a step `h` below the resolution of the time.
    #[cold]
    pub(crate) fn underflow(&self, h: f64) -> IntegrateError {
        unbounded(self.t, &self.y).unwrap_or(IntegrateError::StepUnderflow { t: self.t, h })
    }

    /// The state at the end of the run, from which a further run can start.
    ///
    /// # Errors
    /// [`IntegrateError::Unbounded`] if a component is larger than that of a start may be.
    pub(crate) fn finish(&self) -> Result<State, IntegrateError> {
        let (q, v) = halves(&self.y1);
        let state = State::new(self.t1, q, v);
        match state.check(q.len()) {
            Ok(()) => Ok(state),
            Err(wrong) => Err(unbounded(self.t1, &self.y1).unwrap_or(wrong.into())),
        }
    }

    /// Evaluates the drives at t + θ h in `u_stage`.
    #[inline(always)]
    pub(crate) fn drive(&mut self, theta: f64) {
        let t = self.t + theta * self.h;
        let side = side_of(t, self.edges);
        self.model.redrive(&[t], side, &mut self.u_stage);
    }

    /// Evaluates the drives at the end of the step, before a jump there.
    pub(crate) fn drive_end(&mut self) {
        let side = side_of(self.t1, self.edges);
        self.model.redrive(&[self.t1], side, self.nodes.end_mut());
    }

    /// Number of evaluations of the accelerations for the rates of inner kinks.
    pub(crate) fn evaluations(&self) -> u64 {
        self.kink_rates.evaluations
    }

    /// Computes the contacts at θ of the step in `self.contacts`, with the coordinates from the cubic through
    /// the coordinates and velocities at both ends.
    ///
    /// No acceleration is evaluated. Terms that depend on the drives alone are exact.
    pub(crate) fn contacts_on_cubic(&mut self, theta: f64) {
        self.drive(theta);
        self.look_on_cubic(theta);
        self.contacts_at_look(theta);
    }

    /// Computes the contacts at the state `look` and the drives `u_stage` at θ of the step.
    #[inline(always)]
    pub(super) fn contacts_at_look(&mut self, theta: f64) {
        let ((q, v), u) = (halves(&self.look), &self.u_stage);
        self.model.contact(u, q, v, &mut self.contacts);
        let times = [self.t + theta * self.h, if theta < 0.5 { self.h } else { -self.h }];
        self.kink_rates.write(self.model, &self.pieces, times, [u, q, v], &mut self.contacts);
    }

    /// [`contacts_on_cubic`](Ends::contacts_on_cubic) at a node of the step, θ of it.
    #[inline]
    pub(crate) fn contacts_at_node(&mut self, node: usize, theta: f64) {
        self.look_on_cubic(theta);
        let ((q, v), u) = (halves(&self.look), self.nodes.at(node));
        self.model.contact(u, q, v, &mut self.contacts);
        let times = [self.t + theta * self.h, self.h];
        self.kink_rates.write(self.model, &self.pieces, times, [u, q, v], &mut self.contacts);
    }

    /// The state at θ on the cubic through the coordinates and velocities at both ends, in `self.look`.
    #[inline(always)]
    fn look_on_cubic(&mut self, theta: f64) {
        let (h, n) = (self.h, self.model.dof());
        let (rest, wave) = (1.0 - theta, 6.0 * theta * (1.0 - theta) / h);
        let [a, b, c] =
            [theta * theta * (3.0 - 2.0 * theta), h * theta * rest * rest, h * theta * theta * rest];
        let [d, e] = [rest * (1.0 - 3.0 * theta), theta * (3.0 * theta - 2.0)];
        // Halves of one length, so that bounds are checked once.
        let ((q0, v0), (q1, v1)) = (self.y.slice().split_at(n), self.y1.slice().split_at(n));
        let (q, v) = self.look.slice_mut().split_at_mut(n);
        let (v0, v1, v) = (&v0[..n], &v1[..n], &mut v[..n]);
        for j in 0..n {
            let rise = q1[j] - q0[j];
            q[j] = q0[j] + a * rise + b * v0[j] - c * v1[j];
            v[j] = wave * rise + d * v0[j] + e * v1[j];
        }
    }

    /// Computes in `noise` the effect of rounding of the coordinates and velocities at the start of the step
    /// on each deflection: the largest change when every one of them changes by its last bit, up or down.
    pub(crate) fn rounding_of_contacts(&mut self, noise: &mut [f64]) {
        noise.fill(0.0);
        self.contacts_at_start();
        let Ends { model, u_stage, y, look, contacts, shaken, .. } = self;
        shake(*model, u_stage, y, look, [contacts, shaken], noise);
    }
    /// Raises `noise` to the effect of rounding at the end of the step.
    pub(crate) fn rounding_of_contacts_at_end(&mut self, noise: &mut [f64]) {
        self.contacts_at_end();
        let Ends { model, nodes, y1, look, contacts, shaken, .. } = self;
        shake(*model, nodes.end(), y1, look, [contacts, shaken], noise);
    }

    /// Computes in `tolerated` the effect of the absolute tolerances on each deflection and its rate: the
    /// largest change when every component changes by its tolerance, as in
    /// [`rounding_of_contacts`](Ends::rounding_of_contacts). `here`: scratch.
    pub(crate) fn tolerances_of_contacts(&mut self, tolerated: &mut [[f64; 2]], here: &mut [Contact]) {
        tolerated.fill([0.0; 2]);
        let (q, v) = halves(&self.y);
        self.model.contact(&self.u_stage, q, v, here);
        for sign in sign_patterns(self.atol.slice().len()) {
            let components = self.look.slice_mut().iter_mut().zip(self.y.slice()).zip(self.atol.slice());
            components.enumerate().for_each(|(j, ((out, y), atol))| *out = y + sign(j) * atol);
            let (q, v) = halves(&self.look);
            self.model.contact(&self.u_stage, q, v, &mut self.shaken);
            for (tolerated, (a, b)) in tolerated.iter_mut().zip(here.iter().zip(&self.shaken)) {
                let [d, rate] = [a.deflection - b.deflection, a.rate - b.rate].map(f64::abs);
                *tolerated = [tolerated[0].max(d), tolerated[1].max(rate)];
            }
        }
    }

    /// Computes the contacts at the end of the step in `self.contacts`, before a jump of the drives there.
    #[inline(always)]
    pub(crate) fn contacts_at_end(&mut self) {
        let ((q, v), u) = (halves(&self.y1), self.nodes.end());
        self.model.contact(u, q, v, &mut self.contacts);
        let times = [self.t1, -self.h];
        self.kink_rates.write(self.model, &self.pieces, times, [u, q, v], &mut self.contacts);
    }

    /// Computes the contacts at the start of the step in `self.contacts`, after a jump of the drives there.
    pub(crate) fn contacts_at_start(&mut self) {
        let side = side_of(self.t, self.edges);
        self.model.redrive(&[self.t], side, &mut self.u_stage);
        let ((q, v), u) = (halves(&self.y), &self.u_stage);
        self.model.contact(u, q, v, &mut self.contacts);
        let times = [self.t, self.h];
        self.kink_rates.write(self.model, &self.pieces, times, [u, q, v], &mut self.contacts);
    }

    /// [`IntegrateError::of_contacts`] for the contacts of the last evaluation.
    #[inline(always)]
    pub(crate) fn check_gaps(&self, t: f64) -> Result<(), IntegrateError> {
        IntegrateError::of_contacts(t, &self.contacts)
    }
}

impl IntegrateError {
    /// Checks the contacts at a start, for steps that do not locate edges.
    ///
    /// # Errors
    /// As [`of_contacts`](Self::of_contacts).
    pub(crate) fn of_start(model: &dyn Model, start: &State) -> Result<(), Self> {
        IntegrateError::of_contacts(start.t, &contacts_at(model, start))
    }

    /// Checks the edges and the deflections of contacts at the time `t`.
    ///
    /// # Errors
    /// [`IntegrateError::NegativeGap`], [`IntegrateError::NoDeflection`].
    #[inline(always)]
    pub(crate) fn of_contacts(t: f64, contacts: &[Contact]) -> Result<(), Self> {
        for (contact, c) in contacts.iter().enumerate() {
            if !is_in_order(c) {
                return Err(IntegrateError::NegativeGap { t, contact, lower: c.lower, upper: c.upper });
            }
            if c.deflection.is_nan() {
                return Err(IntegrateError::NoDeflection { t, contact });
            }
        }
        Ok(())
    }
}

/// Raises `noise` to the largest change of each deflection when every component of `y` changes by its last
/// bit, up or down. `look`: scratch; `contacts`: those at `y`, and scratch.
fn shake<V: Vector>(
    model: &dyn Model,
    u: &[f64],
    y: &V,
    look: &mut V,
    [contacts, shaken]: [&mut Vec<Contact>; 2],
    noise: &mut [f64],
) {
    for sign in sign_patterns(y.slice().len()) {
        let components = look.slice_mut().iter_mut().zip(y.slice());
        components.enumerate().for_each(|(j, (out, y))| *out = y * (1.0 + sign(j) * f64::EPSILON));
        let (q, v) = halves(look);
        model.contact(u, q, v, shaken);
        for (noise, (a, b)) in noise.iter_mut().zip(contacts.iter().zip(&*shaken)) {
            *noise = noise.max((a.deflection - b.deflection).abs());
        }
    }
}

/// The error for a state whose largest component grows without bound; `None` if none does.
#[cold]
fn unbounded<V: Vector>(t: f64, y: &V) -> Option<IntegrateError> {
    let larger = |a: (usize, f64), (i, y): (usize, &f64)| if y.abs() > a.1.abs() { (i, *y) } else { a };
    let (component, value) = y.slice().iter().enumerate().fold((0, 0.0), larger);
    (value.abs() > UNBOUNDED).then_some(IntegrateError::Unbounded { t, component, value })
}

/// Maximum size Σ |y| of a state y = (q, v). A larger motion ends the run, since squares and products of its
/// values could overflow.
pub(crate) const LARGEST: f64 = 1e100;

/// The side of a jump on which an instant between two drive edges lies: after the last one if it is closer to
/// it, else before the next one. How close to its edge a wave takes an instant for the edge, because its
/// phase is rounded, need not be known.
#[inline(always)]
pub(super) fn side_of(t: f64, [last, next]: [f64; 2]) -> Side {
    if t - last <= next - t { Side::After } else { Side::Before }
}

/// Coordinates and velocities of a state.
#[inline(always)]
pub(crate) fn halves<V: Vector>(y: &V) -> (&[f64], &[f64]) {
    y.slice().split_at(y.slice().len() / 2)
}
