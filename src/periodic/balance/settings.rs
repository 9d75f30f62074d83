//! Settings of a harmonic balance.

use crate::ode::Budget;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::roots::{Newton, RootFinder};
use std::sync::Arc;

/// q(t) = Σ_k c_k cos kωt + s_k sin kωt: harmonic balance of a periodic model.
///
/// It finds the coefficients c_k, s_k for which q'' - a(u(t), q, q') has no component at the kept orders.
/// Source: Liu 2021, Eqs. (13)-(17), corrected. With exact integrals the series converges to the orbit of the
/// equation as orders are added.
///
/// A solve evaluates the drives at a finite number of instants: the nodes of its integrals, and some
/// beforehand to choose their number. A pulse that contains none of them is missed unless
/// [`next_edge`](crate::Model::next_edge) reports it as drive edges and the integrals are
/// [`Integrals::Exact`] or [`Integrals::Panels`]. `Panels` and [`error_estimate`](Balance::error_estimate)
/// also search for pulses of the drives, down to a duration of 1e-5 of the period.
///
/// ```
/// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams { speed: 120.0, ..NfgParams::table1() })?;
/// let balance = Balance::new(Harmonics::up_to(200));
/// let orbit = balance.solve(&pair, None)?; // from the motion on the flank of the static state
/// assert!(orbit.residual() < 1e-9);
/// assert!(orbit.is_doubtful()); // 200 orders do not resolve the fastest local natural frequency
/// # Ok::<(), gear_dynamics::periodic::BalanceError>(())
/// ```
///
/// The model must be periodic: the compiler rejects any other.
///
/// ```compile_fail,E0277
/// use gear_dynamics::{Balance, Harmonics, periodic::FourierOrbit, model::from_fn};
/// fn solve(guess: &FourierOrbit) -> Result<(), Box<dyn std::error::Error>> {
///     let pendulum = from_fn(1, |_, q, _, a| a[0] = -q[0].sin())?;
///     Balance::new(Harmonics::up_to(3)).solve(&pendulum, guess)?; // `pendulum` has no period
///     Ok(())
/// }
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct Balance {
    pub(crate) harmonics: Harmonics,
    pub(crate) integrals: Integrals,
    pub(crate) truncated_forces: bool,
    pub(crate) root_finder: Arc<dyn RootFinder>,
    pub(crate) budget: Budget,
}

impl Balance {
    /// Defaults: [`Integrals::Exact`], Newton's method with its default settings, the default [`Budget`].
    pub fn new(harmonics: Harmonics) -> Self {
        Balance {
            harmonics,
            integrals: Integrals::Exact,
            truncated_forces: false,
            root_finder: Arc::new(Newton::new()),
            budget: Budget::new(),
        }
    }

    /// Maximum number of steps and maximum time of one call. A step is a residual that the root finder
    /// evaluates, or a step of the shooting in [`error_estimate`](Balance::error_estimate) and
    /// [`solve_to`](Balance::solve_to). The time is asked at each residual: the Jacobian and its factors are
    /// not interrupted. A call with 1500 orders took 2.4 s in an unoptimised build for a limit of 0.1 s.
    pub fn budget(self, budget: Budget) -> Self {
        Balance { budget, ..self }
    }

    /// Way of integration. Default: [`Integrals::Exact`].
    pub fn integrals(self, integrals: Integrals) -> Self {
        Balance { integrals, ..self }
    }

    /// Truncates the value of each contact law to the kept orders before it is multiplied by the stiffness.
    /// Source: Liu 2021. Default: values are not truncated. Such a balance is not one of the equation.
    ///
    /// With [`Integrals::Sampled`] the values are sampled, as in Liu 2021; with [`Integrals::Exact`],
    /// [`Integrals::Closed`] or [`Integrals::Kinks`] their crossings are exact: the sums over the samples are
    /// corrected around every crossing. Panels, drive edges and models that do not evaluate their laws
    /// ([`Offers::laws`](crate::model::Offers::laws)) are refused. The Jacobian leaves out the motion of
    /// crossings at which the value of a law jumps, for example of damping that acts in contact only.
    ///
    /// An [`ErrorEstimate`](crate::periodic::ErrorEstimate) compares with truncated forces, too: `truncation`
    /// is the distance from the limit of this balance for many orders, `shooting` the distance from the orbit
    /// of the equation. Along a branch folds, branch points and grazings are located; the multipliers of the
    /// points are those of the equation along the series, and changes of them are not located.
    ///
    /// ```
    /// use gear_dynamics::branches::{Continuation, Family, PointKind};
    /// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, contact::Piece, models::nfg::NfgReading};
    /// let params = |speed| NfgParams { speed, ..NfgParams::table1() };
    /// let at = |speed| NfgPair::of_reading(&params(speed), NfgReading::published());
    /// // The 15 unknowns of Liu 2021.
    /// let balance = Balance::new(Harmonics::bands(63, 1, 2)?).truncated_forces();
    /// let guess = balance.linearised(&at(179.0)?, Piece::Lower)?;
    /// let range = Continuation::new(179.0, 190.0).max_points(20).balance(balance);
    /// let branch = range.run(&Family::of([("speed", "rad/s")], |[p]| at(p)), &guess)?;
    /// assert!((branch.of_kind(PointKind::Fold)[0].parameter - 179.9259).abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn truncated_forces(self) -> Self {
        Balance { truncated_forces: true, ..self }
    }

    /// The method that solves the equations: [`Newton`], [`Broyden`](crate::roots::Broyden), or one of one's
    /// own. Default: [`Newton`] with its default settings. Branches of a balance correct their points by a
    /// method of their own.
    ///
    /// ```
    /// use gear_dynamics::models::nfg::NfgReading;
    /// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, periodic::Integrals, roots::Broyden};
    /// let params = NfgParams { speed: 140.0, ..NfgParams::table1() };
    /// let pair = NfgPair::of_reading(&params, NfgReading::published())?;
    /// let sampled = Integrals::Sampled { samples: 1024 };
    /// let balance = Balance::new(Harmonics::bands(63, 1, 2)?).integrals(sampled).truncated_forces();
    /// let by_newton = balance.solve(&pair, None)?;
    /// let by_broyden = balance.root_finder(Broyden::new()).solve(&pair, None)?;
    /// assert!(by_newton.distance(&by_broyden) < 1e-6);
    /// # Ok::<(), gear_dynamics::periodic::BalanceError>(())
    /// ```
    pub fn root_finder(self, root_finder: impl RootFinder + 'static) -> Self {
        Balance { root_finder: Arc::new(root_finder), ..self }
    }

    /// Orders that the balance keeps.
    pub fn harmonics(&self) -> &Harmonics {
        &self.harmonics
    }

    /// The same balance with other orders. If Broyden's method starts from a given Jacobian, the Jacobian of
    /// the equations replaces it, since its size no longer fits.
    pub fn with_harmonics(self, harmonics: Harmonics) -> Self {
        let resized = if harmonics == self.harmonics { None } else { self.root_finder.resized() };
        Balance { harmonics, root_finder: resized.unwrap_or(self.root_finder), ..self }
    }
}
