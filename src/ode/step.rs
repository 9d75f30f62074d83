//! What an observer sees of a run: one accepted step at a time.

use crate::contact::piece::Piece;
use std::ops::ControlFlow;

/// A contact that meets an edge at the end of a step: it changes its piece there or, at a rigid stop, its velocities.
///
/// A step ends with the velocities before an impact, the next one starts with those behind it.
///
/// ```
/// use gear_dynamics::{ode::Crossing, contact::Piece};
/// let crossing = Crossing { contact: 0, from: Piece::Gap, to: Piece::Lower, rebounds: false };
/// assert!(crossing.is_impact());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// Which contact.
    pub contact: usize,
    /// The piece it leaves.
    pub from: Piece,
    /// The piece it enters, or the flank of the stop that it meets.
    pub to: Piece,
    /// Whether it meets a rigid stop and stays in its gap.
    pub rebounds: bool,
}

impl Crossing {
    /// Whether teeth that were apart meet, on a rigid stop or a flank that yields.
    pub fn is_impact(&self) -> bool {
        self.from == Piece::Gap && self.to != Piece::Gap
    }
}

/// What a solver has to show of a step: for writing an [`Integrator`](crate::Integrator) of one's own.
pub trait StepView {
    /// Start and end.
    fn times(&self) -> (f64, f64);
    /// Coordinates, then velocities, at the start.
    fn start(&self) -> &[f64];
    /// Coordinates, then velocities, at the end.
    fn end(&self) -> &[f64];
    /// The pieces on which the contacts stood from start to end, when edges were located.
    fn pieces(&self) -> Option<&[Piece]>;
    /// Dense output: coordinates, then velocities, at a time within the step.
    fn at(&mut self, t: f64, y: &mut [f64]);
}

/// One accepted step.
///
/// ```
/// use gear_dynamics::{Integrator, Model, Rk45, State, ode::Step};
/// use std::ops::ControlFlow;
/// struct Fall;
/// impl Model for Fall {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) { a[0] = -1.0; }
/// }
/// // Stop the run once the body is below zero.
/// let mut watch = |step: &mut Step<'_>| if step.q1()[0] < 0.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
/// let finish = Rk45::new().max_step(0.1).run(&Fall, &State::new(0.0, &[0.5], &[0.0]), 9.0, &mut watch)?;
/// assert!(finish.stopped && finish.state.t < 1.2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Step<'a> {
    view: &'a mut dyn StepView,
    at_drive_edge: bool,
    crossings: &'a [Crossing],
}

impl<'a> Step<'a> {
    /// A step to show, whether a drive jumps at its end, and the contacts that cross an edge there.
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
    /// Dense output at `t` within the step: coordinates, then velocities. The ends themselves are exact.
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
    /// The pieces on which the contacts stand throughout, when edges are located.
    pub fn pieces(&self) -> Option<&[Piece]> {
        self.view.pieces()
    }
    /// The contacts that cross an edge at the end of the step.
    pub fn crossings(&self) -> &[Crossing] {
        self.crossings
    }
    /// Whether a drive jumps at the end of the step.
    pub fn at_drive_edge(&self) -> bool {
        self.at_drive_edge
    }
}

fn halves(y: &[f64]) -> (&[f64], &[f64]) {
    y.split_at(y.len() / 2)
}

/// Sees every accepted step and may stop the run. Closures `|step: &mut Step| ControlFlow` are observers.
pub trait Observer {
    /// Called after each accepted step, in order.
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()>;
}

impl<F: FnMut(&mut Step<'_>) -> ControlFlow<()>> Observer for F {
    #[inline(always)]
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        self(step)
    }
}

/// Two observers on one run: both see every step, either may stop it.
impl<A: Observer + ?Sized, B: Observer + ?Sized> Observer for (&mut A, &mut B) {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        let first = self.0.step(step);
        if self.1.step(step).is_break() { ControlFlow::Break(()) } else { first }
    }
}
