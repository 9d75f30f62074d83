//! Interruptions of a run of the tangent flow.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::model::equations::Model;
use crate::ode::budget::Meter;
use crate::ode::step::{Observer, Step};
use crate::periodic::flow::continued::Continued;
use crate::periodic::flow::impact::Impact;
use crate::periodic::flow::saltation::Saltation;
use crate::periodic::flow::tangent::Tangent;
use std::ops::ControlFlow;

/// Reason for an interruption of a run.
#[derive(Clone, Copy)]
pub(crate) enum Stop {
    /// The differences jump.
    Jump,
    /// A difference exceeds the size for which its tolerance is valid.
    Growth,
    /// The budget is spent.
    Budget,
}

/// Observer that interrupts a run for one of the reasons of [`Stop`].
pub(crate) struct Interrupter<'t, 'w, 'm, M: ?Sized> {
    pub(crate) tangent: &'t Tangent<'m, M>,
    pub(crate) watch: Option<&'w mut dyn Observer>,
    pub(crate) meter: &'t Meter<'t>,
    pub(crate) saltation: Saltation<'t, Continued<'m, M>>,
    /// Sizes of the differences up to which the tolerances are valid; empty: all sizes.
    pub(crate) serves: Vec<f64>,
    pub(crate) stop: Stop,
    /// Length of the last step.
    pub(crate) step: f64,
}

impl<M: Model + ?Sized> Observer for Interrupter<'_, '_, '_, M> {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        if let Some(watch) = &mut self.watch {
            let _ = watch.step(step);
        }
        if self.meter.spend().is_err() {
            self.stop = Stop::Budget;
            return ControlFlow::Break(());
        }
        if self.saltation.changes(step) {
            self.stop = Stop::Jump;
            return ControlFlow::Break(());
        }
        let grown = |(k, serves): (usize, &f64)| self.tangent.size(k, step.q1(), step.v1()) > *serves;
        if self.serves.iter().enumerate().any(grown) {
            (self.stop, self.step) = (Stop::Growth, step.t1() - step.t0());
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

impl<'t, 'm, M: Model + ?Sized> Saltation<'t, Continued<'m, M>> {
    pub(crate) fn new(tangent: &'t Tangent<'m, M>) -> Self {
        let (model, n) = (&tangent.model, tangent.n);
        Saltation {
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
            rigid: model.offers().rigid_edges(model.contacts()),
            rests: None,
            impact: Impact::new(model),
        }
    }
}
