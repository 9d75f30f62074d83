//! Settings of a continuation.

use crate::branches::branch_error::BranchError;
use crate::branches::stability_method::StabilityMethod;
use crate::error::{ParameterError, check};
use crate::ode::Budget;
use crate::periodic::{Balance, FourierOrbit, Shooting};

/// Follows periodic orbits along a parameter, and boundaries over two parameters, by pseudo-arclength.
///
/// Each point solves the equations of multiple shooting together with a condition on the distance from the
/// point before: the branch turns at folds and continues as unstable orbits. Tooth edges are located in every
/// integration, so that the sequence of contacts is found anew at every point and no orbit violates a stop.
///
/// Folds, period doublings, Neimark-Sacker points, branch points and grazings between two points are located
/// to the tolerance of the shooting. A step over which the branch turns by more than 0.5 rad, or over which
/// the multipliers change in a way that the located points do not explain, is halved.   Source: Keller,
/// Numerical Solution of Bifurcation and Nonlinear Eigenvalue Problems, 1977; Govaerts, Numerical Methods for
/// Bifurcations of Dynamical Equilibria, Ch. 2.
///
/// A [`Start`](crate::branches::Start) says what is followed: orbits by shooting or by harmonic balance, the
/// branch that crosses at a located point or comes back from infinity, the boundary of a located point in a
/// plane. The default solver of the first orbit is [`Shooting`] with its default settings.
///
/// | setting | branch by shooting | branch by balance | boundary |
/// |---|---|---|---|
/// | [`shooting`](Continuation::shooting) | yes | | yes |
/// | [`balance`](Continuation::balance) | | yes | |
/// | [`stability`](Continuation::stability), [`channels`](Continuation::channels) | yes | yes | |
/// | [`bounds_across`](Continuation::bounds_across) | | | yes |
///
/// All starts read the other settings. A setting that a start does not read is an error
/// ([`ParameterError::Unread`]).
///
/// ```
/// use gear_dynamics::branches::{Continuation, Family, PointKind};
/// use gear_dynamics::{State, model::from_fn};
/// // q'' + 0.05 q' + q + 0.1 q³ = 0.18 cos Ω t, example 1 of NLvib
/// let family = Family::of([("speed", "1")], |[omega]| {
///     let force = move |t: f64| 0.18 * (omega * t).cos();
///     let duffing = from_fn(1, move |t, q, v, a| a[0] = force(t) - 0.05 * v[0] - q[0] - 0.1 * q[0].powi(3))?;
///     duffing.with_period(std::f64::consts::TAU / omega)
/// });
/// let branch = Continuation::new(1.0, 1.6).run(&family, &State::at_rest(1))?;
/// let folds: Vec<f64> = branch.of_kind(PointKind::Fold).iter().map(|point| point.parameter).collect();
/// assert!((folds[0] - 1.269_601_955_5).abs() < 1e-9 && (folds[1] - 1.115_700_251_8).abs() < 1e-9);
/// # Ok::<(), gear_dynamics::branches::BranchError>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct Continuation {
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) bounds: Option<[f64; 2]>,
    across: Option<[f64; 2]>,
    pub(crate) both_ways: bool,
    pub(crate) first_step: f64,
    pub(crate) max_step: f64,
    pub(crate) min_step: f64,
    pub(crate) max_points: usize,
    pub(crate) max_motion: f64,
    pub(crate) channels: Option<Vec<String>>,
    shooting: Option<Shooting>,
    balance: Option<Balance>,
    stability: Option<StabilityMethod>,
    pub(crate) budget: Budget,
}

/// Name of the parameter in errors.
const PARAMETER: &str = "parameter of the continuation";

/// Minimum length of a step if none is set.
const MIN_STEP: f64 = 1e-9;

impl Continuation {
    /// A continuation from the parameter `from` towards `to`.
    ///
    /// Defaults: bounds `from` and `to`, first step 0.01, steps of 1e-9 to 0.05, at most 2000 points, motions
    /// of up to 5000 times the gap, the static deflection or the first orbit, the first deflection as the
    /// measured channel (`q0` for a model without contacts), default [`Shooting`], default [`Budget`].
    pub fn new(from: f64, to: f64) -> Self {
        Continuation {
            from,
            to,
            bounds: None,
            across: None,
            both_ways: false,
            first_step: 0.01,
            max_step: 0.05,
            min_step: MIN_STEP,
            max_points: 2000,
            max_motion: 5000.0,
            channels: None,
            shooting: None,
            balance: None,
            stability: None,
            budget: Budget::new(),
        }
    }
    /// Bounds of the parameter at which the branch ends. Default: the two ends of the continuation.
    pub fn bounds(self, low: f64, high: f64) -> Self {
        Continuation { bounds: Some([low, high]), ..self }
    }
    /// Bounds of the first parameter along a boundary, whose second parameter has the
    /// [`bounds`](Continuation::bounds). They set the unit of this parameter near 0. Default: a tenth and ten
    /// times its value at the start, which must then be far from 0.
    pub fn bounds_across(self, low: f64, high: f64) -> Self {
        Continuation { across: Some([low, high]), ..self }
    }
    /// Follows the branch from its start in both directions. The points are in order along the branch. A
    /// [`Switch`](crate::branches::Switch) and [`Beyond`](crate::branches::Beyond) go one way and refuse
    /// it; a continuation point by point ([`begin`](Continuation::begin)) goes the first way.
    pub fn both_ways(self) -> Self {
        Continuation { both_ways: true, ..self }
    }
    /// Length of the first step `[1]`. The length is √(Σ (Δx_i/range_i)²/n + (Δp/(to - from))²), with the n
    /// coordinates and velocities x_i at the nodes. Default: 0.01.
    pub fn first_step(self, first_step: f64) -> Self {
        Continuation { first_step, ..self }
    }
    /// Maximum length of a step `[1]`; at large motions it is longer
    /// ([`max_motion`](Continuation::max_motion)). Default: 0.05.
    pub fn max_step(self, max_step: f64) -> Self {
        Continuation { max_step, ..self }
    }
    /// Minimum length of a step `[1]`. Default: 1e-9.
    pub fn min_step(self, min_step: f64) -> Self {
        Continuation { min_step, ..self }
    }
    /// Maximum number of points in each direction; the located points of the last step may exceed it.
    /// Default: 2000.
    pub fn max_points(self, max_points: usize) -> Self {
        Continuation { max_points, ..self }
    }
    /// Maximum size of the motion of a contact, as a multiple of the largest of its gap, its static
    /// deflection and its motion along the first orbit `[1]`. A boundary and a branch that is resumed, whose
    /// first orbit may be large, leave that motion out. A branch whose motion grows beyond the limit ends: it
    /// runs to infinity ([`BranchEnd::Unbounded`](crate::branches::BranchEnd::Unbounded)). Default: 5000.
    ///
    /// Without contacts the size is a multiple of the largest range of a coordinate along the first orbit,
    /// and a branch ends only if the border is located. Steps at more than 20 times the reference are up to
    /// 20 times longer than [`max_step`](Continuation::max_step).
    pub fn max_motion(self, max_motion: f64) -> Self {
        Continuation { max_motion, ..self }
    }
    /// Channels whose statistics are kept for every point (see [`Probe`](crate::ode::Probe)). Default:
    /// the deflection of the first contact, or `q0` without contacts.
    pub fn channels(self, channels: &[&str]) -> Self {
        Continuation { channels: Some(channels.iter().map(|name| (*name).to_owned()).collect()), ..self }
    }
    /// The solver of the first orbit. Its period multiple, segments, tolerances and flow method are those of
    /// the whole branch.
    pub fn shooting(self, shooting: Shooting) -> Self {
        Continuation { shooting: Some(shooting), ..self }
    }
    /// The solver of a branch by harmonic balance, which starts at a
    /// [`FourierOrbit`](crate::periodic::FourierOrbit) and follows the equations of this balance. Default:
    /// [`Balance`] with the harmonics of that orbit. The budget counts one step for each evaluation of the
    /// equations and each step of the multipliers.
    ///
    /// Folds and branch points are those of the balance. With few orders the balance may have folds that the
    /// equation has not; with sampled integrals of contacts it has spurious ones, so that exact integrals
    /// should be used. Period doublings, Neimark-Sacker points and the stability are those of the equation
    /// linearised along the series ([`Balance::multipliers`](crate::Balance::multipliers)).
    ///
    /// The derivative of the residual with respect to a named constant is exact. With respect to the
    /// parameter of a closure, and if accelerations jump at crossings, it is computed by one-sided
    /// differences; they affect the number of corrections, not the points that are found. The number of
    /// samples of the integrals is that of the first point.
    ///
    /// ```
    /// use gear_dynamics::branches::{Continuation, Family};
    /// use gear_dynamics::{Balance, Harmonics, contact::Piece, trains::SpurPair};
    /// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
    /// let family = Family::over(&pair, ["speed"])?;
    /// let balance = Balance::new(Harmonics::up_to(12));
    /// let guess = balance.linearised(&pair, Piece::Upper)?;
    /// let branch = Continuation::new(0.6, 0.7).channels(&["q0"]).balance(balance).run(&family, &guess)?;
    /// let last = branch.points().last().ok_or("a point")?;
    /// assert_eq!(last.parameter, 0.7);
    /// assert!((last.peak_to_peak() - last.orbit.peak_to_peak(0)).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn balance(self, balance: Balance) -> Self {
        Continuation { balance: Some(balance), ..self }
    }
    /// How the stability of the points of a branch is computed. Default: Floquet multipliers.
    pub fn stability(self, stability: StabilityMethod) -> Self {
        Continuation { stability: Some(stability), ..self }
    }
    /// Maximum number of integration steps and maximum time of each direction. The first orbit has the budget
    /// of its [`Shooting`].
    pub fn budget(self, budget: Budget) -> Self {
        Continuation { budget, ..self }
    }

    /// The solver of a branch by shooting.
    pub(crate) fn shooting_of_branch(&self) -> Result<Shooting, ParameterError> {
        self.check_read("a branch by shooting", &["shooting", "stability", "channels"])?;
        Ok(self.shooting.clone().unwrap_or_default())
    }

    /// The solver of a boundary.
    pub(crate) fn shooting_of_boundary(&self) -> Result<Shooting, ParameterError> {
        self.check_read("a boundary", &["shooting", "bounds_across"])?;
        Ok(self.shooting.clone().unwrap_or_default())
    }

    /// The balance whose orbits are followed from this one.
    pub(crate) fn balance_of(&self, orbit: &FourierOrbit) -> Result<Balance, ParameterError> {
        self.check_read("a branch by balance", &["balance", "stability", "channels"])?;
        Ok(self.balance.clone().unwrap_or_else(|| Balance::new(orbit.harmonics().clone())))
    }

    pub(crate) fn stability_or_default(&self) -> StabilityMethod {
        self.stability.unwrap_or_default()
    }

    /// Refuses the settings that a line of this kind does not read.
    fn check_read(&self, by: &'static str, read: &[&str]) -> Result<(), ParameterError> {
        // All fields have names here, so that a new setting is not forgotten.
        let Continuation {
            shooting,
            balance,
            stability,
            channels,
            across,
            // `begin` asks the start whether it goes both ways. All lines read the others.
            both_ways: _,
            from: _,
            to: _,
            bounds: _,
            first_step: _,
            max_step: _,
            min_step: _,
            max_points: _,
            max_motion: _,
            budget: _,
        } = self;
        let given = [
            ("shooting", shooting.is_some()),
            ("balance", balance.is_some()),
            ("stability", stability.is_some()),
            ("channels", channels.is_some()),
            ("bounds_across", across.is_some()),
        ];
        match given.iter().find(|(name, given)| *given && !read.contains(name)) {
            Some((name, _)) => Err(ParameterError::Unread { name, by }),
            None => Ok(()),
        }
    }

    pub(crate) fn is_bounded_across(&self) -> bool {
        self.across.is_some()
    }

    /// Sign of the first change of the parameter.
    pub(crate) fn heading(&self) -> f64 {
        (self.to - self.from).signum()
    }

    pub(crate) fn low_and_high(&self) -> [f64; 2] {
        self.bounds.unwrap_or([self.from.min(self.to), self.from.max(self.to)])
    }

    /// Bounds of the first parameter along a boundary that starts at `p`.
    pub(crate) fn across(&self, p: f64) -> Result<[f64; 2], BranchError> {
        let wide = [0.1 * p, 10.0 * p];
        let [low, high] = self.across.unwrap_or([wide[0].min(wide[1]), wide[0].max(wide[1])]);
        check::between("first parameter of the boundary", p, [low, high])?;
        Ok([low, high])
    }

    /// Unit of the parameter in the length of a step.
    pub(crate) fn unit(&self) -> f64 {
        (self.to - self.from).abs()
    }

    pub(crate) fn check(&self) -> Result<(), BranchError> {
        check::all_finite("ends of the continuation", &[self.from, self.to])?;
        if self.from == self.to {
            return Ok(check::between(PARAMETER, self.from, [self.from, self.to])?);
        }
        self.check_start(self.from)?;
        self.check_steps()
    }

    /// Checks that a continuation starts within the bounds of the parameter.
    pub(crate) fn check_start(&self, start: f64) -> Result<(), BranchError> {
        Ok(check::between(PARAMETER, start, self.low_and_high())?)
    }

    pub(crate) fn check_steps(&self) -> Result<(), BranchError> {
        check::positive("first_step", self.first_step)?;
        check::positive("max_step", self.max_step)?;
        check::positive("min_step", self.min_step)?;
        check::positive("max_motion", self.max_motion)?;
        if self.max_step < MIN_STEP && self.min_step == MIN_STEP {
            let (name, value) = ("max_step".into(), self.max_step);
            let must = format!("be at least {MIN_STEP:?}, the default min_step");
            return Err(ParameterError::Wrong { name, value, must }.into());
        }
        if self.min_step > self.max_step {
            let (name, value) = ("min_step".into(), self.min_step);
            let must = format!("be at most {:?}, the max_step", self.max_step);
            return Err(ParameterError::Wrong { name, value, must }.into());
        }
        check::at_least("max_points", self.max_points, 1)?;
        Ok(())
    }
}
