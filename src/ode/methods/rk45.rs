//! The Dormand-Prince method of order 5.

use crate::ode::driver::drive;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::methods::adaptive::{Adaptive, Method};
use crate::ode::outcome::Finish;
use crate::ode::stepping::control::Task;
use crate::ode::stepping::engine::{Engine, Tableau};
use crate::ode::stepping::vector::Vector;

/// Runge-Kutta method 5(4) of Dormand and Prince, adaptive.
///
/// Order 5 with an error estimate of order 4, dense output of order 4. Source: Hairer, Nørsett & Wanner I,
/// Table II.5.2.
///
/// ```
/// use gear_dynamics::{Integrator, Rk45, State, model::from_fn};
/// let spring = from_fn(1, |_, q, _, a| a[0] = -q[0])?;
/// let end = Rk45::new().rtol(1e-9).atol(1e-12).end(&spring, &State::new(0.0, &[1.0], &[0.0]), 1.0)?;
/// assert!((end.q[0] - 1f64.cos()).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Rk45 = Adaptive<DormandPrince5>;

/// The tableau of [`Rk45`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DormandPrince5;

#[rustfmt::skip]
mod table {
    use crate::ode::stepping::tableau_row::TableauRow;
    pub const A2: TableauRow<1> = [(0, 1.0/5.0)];
    pub const A3: TableauRow<2> = [(0, 3.0/40.0), (1, 9.0/40.0)];
    pub const A4: TableauRow<3> = [(0, 44.0/45.0), (1, -56.0/15.0), (2, 32.0/9.0)];
    pub const A5: TableauRow<4> = [(0, 19372.0/6561.0), (1, -25360.0/2187.0), (2, 64448.0/6561.0), (3, -212.0/729.0)];
    pub const A6: TableauRow<5> = [(0, 9017.0/3168.0), (1, -355.0/33.0), (2, 46732.0/5247.0), (3, 49.0/176.0), (4, -5103.0/18656.0)];
    pub const B: TableauRow<5> = [(0, 35.0/384.0), (2, 500.0/1113.0), (3, 125.0/192.0), (4, -2187.0/6784.0), (5, 11.0/84.0)];
    pub const E: TableauRow<6> = [(0, 71.0/57600.0), (2, -71.0/16695.0), (3, 71.0/1920.0), (4, -17253.0/339200.0), (5, 22.0/525.0), (6, -1.0/40.0)];
    /// Coefficients of the dense output.   Source: Shampine (1986).
    pub const D: TableauRow<6> = [
        (0, -12715105075.0/11282082432.0), (2, 87487479700.0/32700410799.0), (3, -10690763975.0/1880347072.0),
        (4, 701980252875.0/199316789632.0), (5, -1453857185.0/822651844.0), (6, 69997945.0/29380423.0),
    ];
}

impl Method for DormandPrince5 {
    fn run(task: Task<'_>) -> Result<Finish, IntegrateError> {
        drive::<DormandPrince5>(task)
    }
}

impl Tableau for DormandPrince5 {
    const ADAPTIVE: bool = true;
    const SLOTS: usize = 7;
    const EVALUATIONS: u64 = 5;
    const END: usize = 6;
    const DENSE: usize = 4;
    const DENSE_EVALUATIONS: u64 = 0;
    const EXPONENT: f64 = 1.0 / 5.0;
    const FACTORS: [f64; 2] = [0.2, 10.0];
    const BETA: f64 = 0.04;
    const NODES: &'static [f64] = &[1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0];
    const PROBE: usize = 1;

    #[inline(always)]
    fn attempt<V: Vector, const FIXED: bool>(e: &mut Engine<'_, V>) {
        e.drive_nodes::<DormandPrince5>();
        e.stage_at::<FIXED, _>(0, 1, &table::A2);
        e.stage_at::<FIXED, _>(1, 2, &table::A3);
        e.stage_at::<FIXED, _>(2, 3, &table::A4);
        e.stage_at::<FIXED, _>(3, 4, &table::A5);
        e.stage_at::<FIXED, _>(4, 5, &table::A6);
        e.advance(&table::B);
        e.derivative_at_end_of::<DormandPrince5>();
    }
    #[inline(always)]
    fn error<V: Vector>(e: &mut Engine<'_, V>) -> f64 {
        e.norms([&table::E])[0]
    }
    fn dense<V: Vector, const FIXED: bool>(e: &mut Engine<'_, V>) {
        e.dense_row(3, &table::D);
    }
}
