//! One step of a method of one's own.

use crate::contact::Piece;
use crate::model::Model;
use crate::ode::stepping::ends::side_of;
use crate::ode::stepping::nodes::Nodes;
use std::fmt;

/// One step of a method of one's own. [`Stepped`](crate::ode::Stepped) makes a solver with fixed steps of it,
/// [`Adaptive::of_steps`](crate::ode::Adaptive::of_steps) one that controls the steps. The crate ends steps
/// at drive edges, locates the edges of the contacts, strikes rigid stops, keeps the pieces and interpolates.
///
/// The step goes from y(t) to y(t + h) for y' = f(t, y), y = (q, q'). All slices have 2 dof entries: the
/// coordinates, then the velocities.
///
/// ```
/// use gear_dynamics::ode::{OneStep, Slope, Stepped};
/// use gear_dynamics::{Integrator, State, model::from_fn};
/// /// Heun's method of order 2.
/// struct Heun;
/// impl OneStep for Heun {
///     fn work(&self, components: usize) -> usize {
///         components
///     }
///     fn step(&self, f: &mut Slope<'_>, end: &mut [f64], _: &mut [f64], second: &mut [f64]) {
///         let h = f.h();
///         end.iter_mut().zip(f.start().iter().zip(f.first())).for_each(|(y1, (y, k))| *y1 = y + h * k);
///         f.at(1.0, end, second);
///         for j in 0..end.len() {
///             end[j] = f.start()[j] + 0.5 * h * (f.first()[j] + second[j]);
///         }
///     }
/// }
/// let ball = from_fn(1, |_, q, _, a| a[0] = -9.81 - 1e4 * q[0].min(0.0))?;
/// let end = Stepped::new(Heun, 1e-3).end(&ball, &State::new(0.0, &[0.5], &[0.0]), 0.3)?;
/// assert!((end.q[0] - (0.5 - 0.5 * 9.81 * 0.09)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait OneStep {
    /// Order q of the estimate that [`step`](OneStep::step) writes: its error is that of a method of order q,
    /// h^(q+1). Default: 0, for a method without an estimate, whose steps are fixed.
    fn estimate_order(&self) -> u32 {
        0
    }
    /// Number of entries of the scratch that a step takes, for a model with this number of components, 2 dof.
    /// Default: 0.
    fn work(&self, components: usize) -> usize {
        let _ = components;
        0
    }
    /// Makes a step. `end`: receives y(t + h). `error`: receives the error of each component of `end`; a
    /// method without an estimate leaves it. Both hold NaN before. `work`: scratch, whose values are those of
    /// the step before.
    fn step(&self, f: &mut Slope<'_>, end: &mut [f64], error: &mut [f64], work: &mut [f64]);
}

/// The right-hand side f(t, y) = (q', a) during one step: on the pieces of the step if the model offers them,
/// with the drives on the side of the edges that belongs to the step.
///
/// [`OneStep`] has an example.
pub struct Slope<'a> {
    pub(crate) model: &'a dyn Model,
    pub(crate) t: f64,
    pub(crate) h: f64,
    pub(crate) edges: [f64; 2],
    pub(crate) start: &'a [f64],
    pub(crate) first: &'a [f64],
    /// `None`: by deflection.
    pub(crate) pieces: Option<&'a [Piece]>,
    pub(crate) u: &'a mut [f64],
    /// Drives at the middle and at the end of the step.
    pub(crate) nodes: &'a Nodes,
    pub(crate) evaluations: u64,
}

impl fmt::Debug for Slope<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Slope")
            .field("t", &self.t)
            .field("h", &self.h)
            .field("start", &self.start)
            .finish_non_exhaustive()
    }
}

impl Slope<'_> {
    /// Time t at the start of the step.
    pub fn t(&self) -> f64 {
        self.t
    }
    /// Length h of the step, in the time unit of the model.
    pub fn h(&self) -> f64 {
        self.h
    }
    /// The state y(t), 2 dof values.
    pub fn start(&self) -> &[f64] {
        self.start
    }
    /// f(t, y(t)), 2 dof values.
    pub fn first(&self) -> &[f64] {
        self.first
    }
    /// Writes f(t + c h, y) to `out`, 0 <= c <= 1. NaN for another c or slices that have not 2 dof entries:
    /// the run then ends with [`IntegrateError::NotFinite`](crate::ode::IntegrateError::NotFinite).
    pub fn at(&mut self, c: f64, y: &[f64], out: &mut [f64]) {
        let (m, n) = (self.start.len(), self.start.len() / 2);
        if !(0.0..=1.0).contains(&c) || y.len() != m || out.len() != m {
            out.fill(f64::NAN);
            return;
        }
        let u: &[f64] = if c == 0.5 {
            self.nodes.at(0)
        } else if c == 1.0 {
            self.nodes.end()
        } else {
            let t = self.t + c * self.h;
            self.model.redrive(&[t], side_of(t, self.edges), self.u);
            self.u
        };
        let ((q, v), (rates, a)) = (y.split_at(n), out.split_at_mut(n));
        rates.copy_from_slice(v);
        match self.pieces {
            Some(pieces) => self.model.accel_on_pieces(pieces, u, q, v, a),
            None => self.model.accel(u, q, v, a),
        }
        self.evaluations += 1;
    }
}

/// A method of one's own with its scratch, in one run.
pub(crate) struct OwnStep<'m> {
    pub(crate) method: &'m dyn OneStep,
    pub(crate) error: Vec<f64>,
    pub(crate) work: Vec<f64>,
}

impl<'m> OwnStep<'m> {
    pub(crate) fn new(method: &'m dyn OneStep, components: usize) -> Self {
        OwnStep { method, error: vec![0.0; components], work: vec![0.0; method.work(components)] }
    }
    /// 1/(q + 1), the exponent of the step size control.
    pub(crate) fn exponent(&self) -> f64 {
        1.0 / f64::from(self.method.estimate_order().saturating_add(1))
    }
}
