//! One accepted step of a run, as an observer receives it.

use crate::contact::Piece;
use crate::error::ParameterError;
use std::fmt;
use std::ops::ControlFlow;

/// A crossing: a contact reaches an edge of its gap at the end of a step, at the time [`Step::t1`].
///
/// At an ordinary edge the contact changes its piece. At a rigid stop it stays in its gap and the velocities
/// jump: the step ends with the velocities before the impact, the next step starts with those after it.
///
/// ```
/// use gear_dynamics::{ode::Crossing, contact::Piece};
/// let crossing = Crossing { contact: 0, from: Piece::Gap, to: Piece::Lower, rebounds: false };
/// assert!(crossing.is_impact());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// Index of the contact, from 0.
    pub contact: usize,
    /// The piece that the contact leaves.
    pub from: Piece,
    /// The piece that the contact enters; at a rigid stop, the flank of the stop.
    pub to: Piece,
    /// Whether the edge is a rigid stop: the contact stays in its gap and the velocities jump.
    pub rebounds: bool,
}

impl Crossing {
    /// Whether the crossing is an impact: the contact leaves the gap for an elastic flank or rebounds from a
    /// rigid stop.
    pub fn is_impact(&self) -> bool {
        self.from == Piece::Gap && self.to != Piece::Gap
    }
}

/// The data of one step that a solver provides. Implement it to write your own
/// [`Integrator`](crate::Integrator).
pub trait StepView {
    /// Start time and end time.
    fn times(&self) -> (f64, f64);
    /// Coordinates, then velocities, at the start: 2 dof values.
    fn start(&self) -> &[f64];
    /// Coordinates, then velocities, at the end: 2 dof values.
    fn end(&self) -> &[f64];
    /// The piece of each contact during the step; `None` if edges were not located.
    fn pieces(&self) -> Option<&[Piece]>;
    /// Dense output: writes coordinates, then velocities, at the time `t` within the step into `y`.
    fn at(&mut self, t: f64, y: &mut [f64]);
    /// Number of equal parts of the step in each of which a few samples resolve the motion. Default: 1, for
    /// a Runge-Kutta method.
    fn parts(&self) -> usize {
        1
    }
}

/// One accepted step.
///
/// ```
/// use gear_dynamics::{Integrator, Rk45, State, ode::Step, model::from_fn};
/// use std::ops::ControlFlow;
/// let fall = from_fn(1, |_, _, _, a| a[0] = -1.0)?;
/// // Stops the run after the first step that ends below zero.
/// let mut watch = |step: &mut Step<'_>| {
///     if step.q1()[0] < 0.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
/// };
/// let finish = Rk45::new().max_step(0.1).run(&fall, &State::new(0.0, &[0.5], &[0.0]), 9.0, &mut watch)?;
/// assert!(finish.stopped && finish.state.t < 1.2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Step<'a> {
    view: &'a mut dyn StepView,
    at_drive_edge: bool,
    crossings: &'a [Crossing],
}

impl fmt::Debug for Step<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Step")
            .field("t0", &self.t0())
            .field("t1", &self.t1())
            .field("crossings", &self.crossings)
            .finish_non_exhaustive()
    }
}

impl<'a> Step<'a> {
    /// A step for the observer. `at_drive_edge`: the step ends on a drive edge; `crossings`: the crossings at
    /// its end.
    #[inline(always)]
    pub fn new(view: &'a mut dyn StepView, at_drive_edge: bool, crossings: &'a [Crossing]) -> Self {
        Step { view, at_drive_edge, crossings }
    }
    /// Start time.
    pub fn t0(&self) -> f64 {
        self.view.times().0
    }
    /// End time.
    pub fn t1(&self) -> f64 {
        self.view.times().1
    }
    /// Coordinates at the start.
    pub fn q0(&self) -> &[f64] {
        halves(self.view.start()).0
    }
    /// Velocities at the start.
    pub fn v0(&self) -> &[f64] {
        halves(self.view.start()).1
    }
    /// Coordinates at the end.
    pub fn q1(&self) -> &[f64] {
        halves(self.view.end()).0
    }
    /// Velocities at the end.
    pub fn v1(&self) -> &[f64] {
        halves(self.view.end()).1
    }
    /// Coordinates, then velocities, at the end.
    pub fn y1(&self) -> &[f64] {
        self.view.end()
    }
    /// Dense output at `t` within the step: coordinates, then velocities, 2 dof values. At the ends of the
    /// step it returns the computed values themselves.
    pub fn at(&mut self, t: f64, y: &mut [f64]) {
        let (t0, t1) = self.view.times();
        if t == t1 {
            y.copy_from_slice(self.view.end());
        } else if t == t0 {
            y.copy_from_slice(self.view.start());
        } else {
            self.view.at(t, y);
        }
    }
    /// Passes the states at the first of the times `left`, up to the end of the step, to `take` and removes
    /// these times. The states are written to `y`: coordinates, then velocities.
    pub(crate) fn sample(&mut self, left: &mut &[f64], y: &mut [f64], mut take: impl FnMut(f64, &[f64])) {
        while let [t, rest @ ..] = *left
            && *t <= self.t1()
        {
            self.at(*t, y);
            take(*t, y);
            *left = rest;
        }
    }
    /// Number of equal parts of the step in each of which a few samples resolve the motion: 1 for a
    /// Runge-Kutta method, more for a step of high order. An observer that samples the dense output samples
    /// each part.
    pub fn parts(&self) -> usize {
        self.view.parts()
    }
    /// Start and end of part `k` of [`parts`](Step::parts), counted from 0.
    pub fn part(&self, k: usize) -> (f64, f64) {
        let ((t0, t1), parts) = (self.view.times(), self.view.parts());
        let border = |k: usize| match k {
            0 => t0,
            _ if k == parts => t1,
            _ => t0 + (t1 - t0) * (k as f64 / parts as f64),
        };
        (border(k), border(k + 1))
    }
    /// The piece of each contact during the step; `None` if edges are not located.
    pub fn pieces(&self) -> Option<&[Piece]> {
        self.view.pieces()
    }
    /// The crossings at the end of the step.
    pub fn crossings(&self) -> &[Crossing] {
        self.crossings
    }
    /// Whether the step ends on a drive edge.
    pub fn at_drive_edge(&self) -> bool {
        self.at_drive_edge
    }
}

fn halves(y: &[f64]) -> (&[f64], &[f64]) {
    y.split_at(y.len() / 2)
}

/// Receives every accepted step and may stop the run. Closures `|step: &mut Step| ControlFlow` are
/// observers.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not an observer",
    note = "observers are closures `|step: &mut Step<'_>| ControlFlow`, pairs and triples of references such as \
            `(&mut statistics, &mut rattle)`, and arrays, slices and `Vec`s of `&mut dyn Observer`"
)]
pub trait Observer {
    /// Called after each accepted step, in order of time. `Break` stops the run.
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()>;

    /// Whether the observer can follow a model with `dof` coordinates and `contacts` contacts. A run calls
    /// this method before its first step. The default accepts every model.
    ///
    /// # Errors
    /// [`ParameterError::OtherModel`] from an observer that was made for a model of another shape.
    fn fits(&self, dof: usize, contacts: usize) -> Result<(), ParameterError> {
        let _ = (dof, contacts);
        Ok(())
    }
}

impl<F: FnMut(&mut Step<'_>) -> ControlFlow<()>> Observer for F {
    #[inline(always)]
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        self(step)
    }
}

/// Two observers of one run: both receive every step, and each can stop the run.
impl<A: Observer + ?Sized, B: Observer + ?Sized> Observer for (&mut A, &mut B) {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        let first = self.0.step(step);
        if self.1.step(step).is_break() { ControlFlow::Break(()) } else { first }
    }
    fn fits(&self, dof: usize, contacts: usize) -> Result<(), ParameterError> {
        self.0.fits(dof, contacts).and_then(|()| self.1.fits(dof, contacts))
    }
}

/// Three observers of one run.
impl<A: Observer + ?Sized, B: Observer + ?Sized, C: Observer + ?Sized> Observer for (&mut A, &mut B, &mut C) {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        (&mut (&mut *self.0, &mut *self.1), &mut *self.2).step(step)
    }
    fn fits(&self, dof: usize, contacts: usize) -> Result<(), ParameterError> {
        self.0.fits(dof, contacts)?;
        self.1.fits(dof, contacts).and_then(|()| self.2.fits(dof, contacts))
    }
}

/// Several observers of one run. Each one receives every step, and each one can stop the run.
impl<O: Observer + ?Sized> Observer for &mut [&mut O] {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        let mut flow = ControlFlow::Continue(());
        for observer in &mut **self {
            if observer.step(step).is_break() {
                flow = ControlFlow::Break(());
            }
        }
        flow
    }
    fn fits(&self, dof: usize, contacts: usize) -> Result<(), ParameterError> {
        self.iter().try_for_each(|observer| observer.fits(dof, contacts))
    }
}

/// Any number of observers of one run.
impl<O: Observer + ?Sized, const N: usize> Observer for [&mut O; N] {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        (&mut self[..]).step(step)
    }
    fn fits(&self, dof: usize, contacts: usize) -> Result<(), ParameterError> {
        self.iter().try_for_each(|observer| observer.fits(dof, contacts))
    }
}

/// Any number of observers of one run.
impl<O: Observer + ?Sized> Observer for Vec<&mut O> {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        (&mut self[..]).step(step)
    }
    fn fits(&self, dof: usize, contacts: usize) -> Result<(), ParameterError> {
        self.iter().try_for_each(|observer| observer.fits(dof, contacts))
    }
}
