//! Solvers with any setting.

use crate::case::Case;
use gear_dynamics::ode::{Finish, IntegrateError, Observer};
use gear_dynamics::{Dop853, Integrator, Model, Rk4, Rk45, State};

/// Maximum number of steps of a run, which keeps cases short.
const STEPS: usize = 4_000;

/// A solver behind one type.
#[derive(Clone, Debug)]
pub enum Solver {
    Rk4(Rk4),
    Rk45(Rk45),
    Dop853(Dop853),
}

impl Integrator for Solver {
    fn run(
        &self,
        model: &dyn Model,
        start: &State,
        t_end: f64,
        observer: &mut dyn Observer,
    ) -> Result<Finish, IntegrateError> {
        let solver: &dyn Integrator = match self {
            Solver::Rk4(solver) => solver,
            Solver::Rk45(solver) => solver,
            Solver::Dop853(solver) => solver,
        };
        solver.run(model, start, t_end, observer)
    }
}

/// Any settings of an adaptive solver. A macro, since the type of the method has no public name.
macro_rules! adaptive {
    ($case:ident, $solver:expr, $period:expr, $components:expr) => {{
        let mut solver = $solver.rtol($case.number(1e-7)).atol($case.number(1e-10)).max_steps(STEPS);
        if $case.chance(0.2) {
            let each: Vec<f64> = $case.list($components, 1e-10).into_iter().map(f64::abs).collect();
            solver = solver.atol_each(&each);
        }
        if $case.chance(0.2) {
            solver = solver.first_step($case.number(0.01 * $period));
        }
        if $case.chance(0.2) {
            solver = solver.max_step($case.number(0.1 * $period));
        }
        if $case.chance(0.1) {
            solver = solver.pi_beta($case.number(0.04));
        }
        if $case.chance(0.1) { solver.plain() } else { solver }
    }};
}

/// Any solver with any settings, for a model with this period.
pub fn solver(case: &mut Case, period: f64, components: usize) -> Solver {
    let period = if period.is_finite() && period > 0.0 { period } else { 1.0 };
    let solver = match case.below(3) {
        0 => {
            let rk4 = Rk4::new(case.number(2e-3 * period)).max_steps(STEPS);
            Solver::Rk4(if case.chance(0.2) { rk4.plain() } else { rk4 })
        }
        1 => Solver::Rk45(adaptive!(case, Rk45::new(), period, components)),
        _ => Solver::Dop853(adaptive!(case, Dop853::new(), period, components)),
    };
    case.note(|| format!("{solver:?}"));
    solver
}
