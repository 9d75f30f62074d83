//! The settings of a balance.

use crate::ode::budget::Budget;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::roots::broyden::Broyden;
use crate::roots::newton::Newton;

impl Balance {
    /// Exact integrals, Newton's method, the default [`Budget`].
    pub fn new(harmonics: Harmonics) -> Self {
        Balance {
            harmonics,
            integrals: Integrals::Exact,
            roots: Roots::Newton(Newton::new()),
            budget: Budget::new(),
        }
    }

    /// The most work of one call: every residual that the root finder evaluates is a step, and so is every step of the flows that
    /// [`prove`](Balance::prove) and [`solve_to`](Balance::solve_to) shoot with.
    pub fn budget(self, budget: Budget) -> Self {
        Balance { budget, ..self }
    }

    /// How the integrals are taken.
    pub fn integrals(self, integrals: Integrals) -> Self {
        Balance { integrals, ..self }
    }

    /// Solve by Newton's method with these settings.
    pub fn newton(self, newton: Newton) -> Self {
        Balance { roots: Roots::Newton(newton), ..self }
    }

    /// Solve by Broyden's method with these settings.
    pub fn broyden(self, broyden: Broyden) -> Self {
        Balance { roots: Roots::Broyden(broyden), ..self }
    }

    /// The harmonics.
    pub fn harmonics(&self) -> &Harmonics {
        &self.harmonics
    }

    /// The same balance on other harmonics. A given first Jacobian does not fit them: the equations' own takes its place.
    pub fn on(&self, harmonics: Harmonics) -> Self {
        let roots = match self.roots.clone() {
            Roots::Broyden(broyden) if harmonics != self.harmonics => Roots::Broyden(broyden.resized()),
            roots => roots,
        };
        Balance { harmonics, roots, integrals: self.integrals, budget: self.budget.clone() }
    }
}

/// Harmonic balance of a periodic model.
///
/// The coefficients z of q(t) = Σ_k c_k cos kωt + s_k sin kωt are sought for which q'' - a(u(t), q, q') has no component at the kept
/// orders.   Source: Liu 2021, Eqs. (13)-(17), corrected; with exact switching it converges to the orbits of the equation itself.
///
/// A solve looks at the drives where its integrals do. A pulse narrower than that has to be announced by [`next_edge`](crate::Model::next_edge);
/// [`Integrals::Panels`] and [`prove`](Balance::prove) seek pulses down to 1e-5 of the period by themselves.
///
/// ```
/// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, contact::Piece};
/// let pair = NfgPair::new(&NfgParams { speed: 120.0, ..NfgParams::table1() })?;
/// let balance = Balance::new(Harmonics::up_to(200));
/// let orbit = balance.solve(&pair, &balance.linearised(&pair, Piece::Lower)?)?;
/// assert!(orbit.residual() < 1e-9);
/// assert!(orbit.is_doubtful()); // 200 orders do not resolve the fastest local natural frequency, and the orbit says so
/// # Ok::<(), gear_dynamics::periodic::BalanceError>(())
/// ```
///
/// A model without period is refused by the compiler:
///
/// ```compile_fail,E0277
/// use gear_dynamics::{Balance, Harmonics, Model, periodic::FourierOrbit};
/// struct Pendulum;
/// impl Model for Pendulum {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _u: &[f64], q: &[f64], _v: &[f64], a: &mut [f64]) { a[0] = -q[0].sin(); }
/// }
/// fn solve(guess: &FourierOrbit) {
///     let _ = Balance::new(Harmonics::up_to(3)).solve(&Pendulum, guess); // `Pendulum` has no period
/// }
/// ```
#[derive(Clone, Debug)]
pub struct Balance {
    pub(crate) harmonics: Harmonics,
    pub(crate) integrals: Integrals,
    pub(crate) roots: Roots,
    pub(crate) budget: Budget,
}

#[derive(Clone, Debug)]
pub(crate) enum Roots {
    Newton(Newton),
    Broyden(Broyden),
}
