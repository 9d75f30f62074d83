//! The settings of a sweep: points, settling and measured periods, requested results.

use crate::error::{ParameterError, check};
use crate::ode::Budget;
use crate::periodic::{Lyapunov, Shooting};
use crate::sweep::settings::points::Points;

/// The start of a run: the start of its own point, or the state in which the neighbouring point ended.
///
/// The state from a neighbouring speed is nearly settled. In this example a warm start without settling gives
/// the same peak-to-peak value, within 0.1 %, as a start of its own with one settling period:
///
/// ```
/// use gear_dynamics::{sweep::{Axis, LaneRk4, WarmStart}, NfgPair, NfgParams, Sweep};
/// let speeds = Axis::linear("speed", 120.0, 120.4, 3)?;
/// let ppv = |warm_start, settle| -> Result<f64, Box<dyn std::error::Error>> {
///     let sweep = Sweep::new(speeds.clone()).settle(settle).measure(1).channels(&["q0"]);
///     let rows = sweep.warm_start(warm_start).of(
///         &LaneRk4::new(63 * 16),
///         |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
///     ).run()?;
///     Ok(rows.get(2)?.channel("q0")?.peak_to_peak())
/// };
/// let settled = ppv(WarmStart::No, 1)?;
/// assert!((ppv(WarmStart::Up, 0)? / settled - 1.0).abs() < 1e-3);
/// assert!((ppv(WarmStart::No, 0)? / settled - 1.0).abs() > 1e-2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum WarmStart {
    /// The start of its own point. Default.
    #[default]
    No,
    /// The state in which the neighbour of lower index ended, along the last axis of a grid or along the
    /// list. The first point of a line uses its own start.
    Up,
    /// The state in which the neighbour of higher index ended. The last point of a line uses its own start.
    Down,
}

/// Many runs of one family of models.
///
/// Points, settling and measured periods, requested results. Only the row of a run is stored, no trajectory.
///
/// Example, a map of the rattle state over speed and load:
///
/// ```
/// use gear_dynamics::{sweep::{Axis, LaneRk4, Points}, NfgPair, NfgParams, RattleState, Sweep};
/// let axes = vec![Axis::linear("speed", 120.0, 180.0, 4)?, Axis::linear("load", 20.0, 40.0, 4)?];
/// let map = Sweep::new(Points::grid(axes)?)
///     .settle(4)
///     .measure(1)
///     .channels(&["q0"])
///     .rattle()
///     .of(
///         &LaneRk4::new(63 * 32),
///         |p| NfgPair::new(&NfgParams { speed: p["speed"], load_torque: p["load"], ..NfgParams::table1() }),
///     ).run()?;
/// assert_eq!(map.iter().filter(|row| row.contacts()[0].rattle_state() == RattleState::Bilateral).count(), 7);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[must_use = "a setting returns a new value"]
pub struct Sweep {
    pub(crate) points: Points,
    pub(crate) settle: usize,
    pub(crate) measure: usize,
    pub(crate) repeat: Option<f64>,
    pub(crate) tolerance: f64,
    pub(crate) channels: Vec<String>,
    pub(crate) rattle: bool,
    pub(crate) strobes: usize,
    pub(crate) lyapunov: Option<Lyapunov>,
    #[cfg_attr(feature = "serde", serde(default))]
    pub(crate) multipliers: Option<Shooting>,
    pub(crate) warm_start: WarmStart,
    pub(crate) check_every: usize,
}

impl Sweep {
    /// A sweep over these points: an [`Axis`](crate::sweep::Axis) or [`Points`].
    ///
    /// Defaults: 60 settling periods, 40 measured periods, tolerance 1e-6 of a periodic motion, no early end
    /// of settling, no channels, no rattle, no strobed states, no Lyapunov exponent, no multipliers, no
    /// warm start, no checks.
    pub fn new(points: impl Into<Points>) -> Self {
        Sweep {
            points: points.into(),
            settle: 60,
            measure: 40,
            repeat: None,
            tolerance: 1e-6,
            channels: Vec::new(),
            rattle: false,
            strobes: 0,
            lyapunov: None,
            multipliers: None,
            warm_start: WarmStart::No,
            check_every: 0,
        }
    }

    /// Number of settling periods. Default: 60.
    pub fn settle(self, periods: usize) -> Self {
        Sweep { settle: periods, ..self }
    }

    /// Ends settling as soon as the strobed state repeats within `tolerance`, after a period multiple p up to
    /// 16 and at p + 1 periods in a row, and its distance from the orbit is within it, too. This distance is
    /// an estimate from the last changes after p periods and the factor by which they shrink. A p above 1
    /// counts only if the state returns at least 1000 times closer after p periods than after every proper
    /// divisor of p. Then p + 1 of the measured periods are run at most, and the last p of them count again,
    /// in turn, for the others. Default: all periods are run.
    ///
    /// The tolerance is the maximum difference of a coordinate or velocity as a share of its range (maximum
    /// less minimum) in the last period of the drives `[1]`, positive and finite; otherwise the sweep returns
    /// an error. If the state as a whole does not repeat, it is compared without its rigid motion and without
    /// places of which only the velocity acts.
    ///
    /// Within a period a fast vibration may be off by more than at its end, and a channel that is a small
    /// part of a coordinate by more of its own range.
    pub fn repeat_tolerance(self, tolerance: f64) -> Self {
        Sweep { repeat: Some(tolerance), ..self }
    }

    /// Number of measured periods, at least 1. Default: 40.
    pub fn measure(self, periods: usize) -> Self {
        Sweep { measure: periods, ..self }
    }

    /// Tolerance within which a motion must repeat to count as periodic, in the same unit as in
    /// [`repeat_tolerance`](Sweep::repeat_tolerance) `[1]`. Default: 1e-6. Period multiples up to 16 are
    /// recognised.
    pub fn periodic_tolerance(self, tolerance: f64) -> Self {
        Sweep { tolerance, ..self }
    }

    /// Requests mean, RMS, extremes and deviation of these channels (see [`Probe`](crate::ode::Probe)).
    /// Default: none.
    pub fn channels(self, names: &[&str]) -> Self {
        Sweep { channels: names.iter().map(|name| (*name).to_owned()).collect(), ..self }
    }

    /// Requests rattle state, contact loss and impacts of every contact. Default: not computed.
    pub fn rattle(self) -> Self {
        Sweep { rattle: true, ..self }
    }

    /// Requests the last `count` strobed states, and the extremes of the channels in the periods that they
    /// end. Default: 0. Maximum: the number of measured periods; a larger `count` is reduced to it.
    pub fn strobe(self, count: usize) -> Self {
        Sweep { strobes: count, ..self }
    }

    /// Requests the largest Lyapunov exponent. Default: not computed.
    ///
    /// With every engine it is computed from the variational equations with located edges. It starts in the
    /// last state of the run, where the motion is settled: the default of [`settle`](Lyapunov::settle) is 0
    /// here. A row contains one exponent: the default of [`count`](Lyapunov::count) is 1, and more is an
    /// error. [`LaneTaylor`](crate::sweep::LaneTaylor) computes exponents in lanes, the other engines one by
    /// one; the time per period is then about three times that of [`Located`](crate::sweep::Located).
    pub fn lyapunov(self, lyapunov: Lyapunov) -> Self {
        Sweep { lyapunov: Some(lyapunov.of_sweep()), ..self }
    }

    /// Requests the Floquet multipliers of every motion that repeats after p periods. Default: not computed.
    ///
    /// The last state of the run is the guess; the multipliers are those of the orbit that the shooting
    /// finds. p is that of the motion: a [`period_multiple`](Shooting::period_multiple) above 1 is an error.
    /// [`LaneTaylor`](crate::sweep::LaneTaylor) closes the orbits side by side, each in one segment; with
    /// more segments or another flow method it closes them one by one, as the other engines do. The runs of
    /// [checks](Sweep::check_every) have multipliers, too.
    pub fn multipliers(self, shooting: Shooting) -> Self {
        Sweep { multipliers: Some(shooting), ..self }
    }

    /// The start of the runs. Default: [`WarmStart::No`].
    pub fn warm_start(self, warm_start: WarmStart) -> Self {
        Sweep { warm_start, ..self }
    }

    /// Runs every `count`-th point a second time with a quarter of the step, or with a hundredth of the
    /// tolerances by [`LaneTaylor`](crate::sweep::LaneTaylor), to estimate the error. Default: 0, no checks.
    /// With a warm start every `count`-th line is run again as a whole. [`Located`](crate::sweep::Located)
    /// ignores this setting.
    pub fn check_every(self, count: usize) -> Self {
        Sweep { check_every: count, ..self }
    }

    /// The same sweep with the default budget: a budget does not change the results.
    pub(crate) fn without_budget(&self) -> Self {
        let lyapunov = self.lyapunov.clone().map(|lyapunov| lyapunov.budget(Budget::new()));
        let multipliers = self.multipliers.clone().map(|shooting| shooting.budget(Budget::new()));
        Sweep { lyapunov, multipliers, ..self.clone() }
    }

    pub(crate) fn names(&self) -> &[String] {
        &self.channels
    }

    /// Number of values of the Lyapunov exponent in a row.
    pub(crate) fn exponents(&self) -> usize {
        if self.lyapunov.is_some() { 2 } else { 0 }
    }

    /// Number of values of the multipliers in a row: real and imaginary part of each, and their error.
    pub(crate) fn multipliers_of(&self, dof: usize) -> usize {
        if self.multipliers.is_some() { dof.saturating_mul(4).saturating_add(1) } else { 0 }
    }

    /// The points.
    pub fn points(&self) -> &Points {
        &self.points
    }

    /// Number of points in a line: 1 without a warm start, else the values of the last axis.
    pub(crate) fn line(&self) -> usize {
        if self.warm_start == WarmStart::No { 1 } else { self.points.line() }
    }

    /// Checks the settings.
    ///
    /// # Errors
    /// A setting outside its range.
    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check::at_least("measure", self.measure, 1)?;
        check::above_zero("periodic_tolerance", self.tolerance)?;
        self.repeat.map_or(Ok(0.0), |value| check::above_zero("repeat_tolerance", value))?;
        if let Some(lyapunov) = &self.lyapunov {
            lyapunov.check_of_sweep()?;
        }
        self.multipliers.as_ref().map_or(Ok(()), Shooting::check_of_sweep)
    }
}
