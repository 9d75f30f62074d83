//! Equations of a balance that are bound to another model.

use crate::model::Periodic;
use crate::model::structure::no_model::NoModel;
use crate::model::structure::slopes::Slopes;
use crate::periodic::balance::equations::balance_equations::{BalanceEquations, Workspace};
use crate::periodic::balance::series::grid::Grid;
use std::f64::consts::TAU;

/// Relative difference of two constant slopes that is rounding.
const SAME_SLOPE: f64 = 1e-13;

/// The equations of a balance without their model. With a model they are equations again.
///
/// The scales of the unknowns, the number of samples and the way of integration remain.
pub(crate) struct Unbound {
    grid: Grid<'static>,
    slopes: Slopes<'static>,
    work: Workspace,
}

impl BalanceEquations<'_> {
    pub(crate) fn unbind(self) -> Unbound {
        let BalanceEquations { grid, slopes, work } = self;
        Unbound { grid: grid.with_model(&NoModel), slopes: slopes.with_model(&NoModel), work }
    }
}

impl Unbound {
    /// The equations of the model to which they were bound last; its evaluations are kept.
    pub(crate) fn bind(self, model: &dyn Periodic) -> BalanceEquations<'_> {
        let Unbound { grid, slopes, work } = self;
        BalanceEquations { grid: grid.with_model(model), slopes: slopes.with_model(model), work }
    }

    /// The equations of a model with another parameter. `constants`: the drives differ from those of the last
    /// model by values that are the same at every phase.
    ///
    /// `None` if the model needs other equations: its slopes have another pattern, or the way of integration
    /// does not follow.
    pub(crate) fn rebind(self, model: &dyn Periodic, constants: bool) -> Option<BalanceEquations<'_>> {
        let mut equations = self.bind(model);
        let BalanceEquations { grid, slopes, work } = &mut equations;
        let Workspace { layout, couplings, integration, evaluated, .. } = work;
        evaluated.clear();
        grid.redrive(constants);
        layout.omega = TAU / grid.span();
        if integration.needs_slopes() {
            let has_fixed_pieces = model.contacts() > 0 && model.offers().pieces;
            if !couplings.reread(model, slopes, has_fixed_pieces, SAME_SLOPE) {
                return None;
            }
        }
        integration.adapt(grid, couplings, slopes).then_some(equations)
    }
}
