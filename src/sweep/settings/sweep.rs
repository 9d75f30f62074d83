//! A sweep: which points, how long to settle and to measure, and what.

use crate::periodic::lyapunov::run::Lyapunov;
use crate::sweep::error::SweepError;
use crate::sweep::settings::points::Points;

/// Where a run starts from.
///
/// A state carried from a speed close by is nearly settled: what is measured at once is what is measured after a turn.
///
/// ```
/// use gear_dynamics::{sweep::{Axis, LaneRk4, Points, WarmStart}, NfgPair, NfgParams, Sweep};
/// let speeds = Points::along(Axis::linear("speed", 120.0, 120.4, 3)?);
/// let ppv = |carry, settle| -> Result<f64, Box<dyn std::error::Error>> {
///     let rows = Sweep::over(speeds.clone()).settle(settle).measure(1).channels(&["q1"]).carry(carry).run(
///         &LaneRk4::<4>::new(63 * 16),
///         |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
///         |_, pair| pair.static_start(),
///     )?;
///     Ok(rows.get(2)?.channel("q1")?.peak_to_peak())
/// };
/// let settled = ppv(WarmStart::No, 1)?;
/// assert!((ppv(WarmStart::Up, 0)? / settled - 1.0).abs() < 1e-3);
/// assert!((ppv(WarmStart::No, 0)? / settled - 1.0).abs() > 1e-2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WarmStart {
    /// From the start of its own point.
    #[default]
    No,
    /// From where its neighbour of lower index ended: along the last axis of a grid, or along the list. The first one of a line has a start.
    Up,
    /// From where its neighbour of higher index ended.
    Down,
}

impl Sweep {
    /// Settles 60 periods and measures 40, as nothing else is said.
    pub fn over(points: Points) -> Self {
        Sweep {
            points,
            settle: 60,
            measure: 40,
            repeat: None,
            tolerance: 1e-6,
            channels: Vec::new(),
            rattle: false,
            strobes: 0,
            lyapunov: None,
            carry: WarmStart::No,
            check_every: 0,
        }
    }

    /// Periods to settle.
    pub fn settle(self, periods: usize) -> Self {
        Sweep { settle: periods, ..self }
    }

    /// Ends settling early, once the strobed state repeats this closely, as a share of the range of each coordinate and velocity over a
    /// period; rigid motion does not count.
    pub fn until_repeats(self, tolerance: f64) -> Self {
        Sweep { repeat: Some(tolerance), ..self }
    }

    /// Periods to measure over, at least one.
    pub fn measure(self, periods: usize) -> Self {
        Sweep { measure: periods, ..self }
    }

    /// How closely a motion has to return to count as periodic, in the same shares; 1e-6 if nothing is said.
    pub fn periodic_within(self, tolerance: f64) -> Self {
        Sweep { tolerance, ..self }
    }

    /// Channels of which mean, RMS and extremes are wanted (see [`Probe`](crate::analysis::Probe)).
    pub fn channels(self, names: &[&str]) -> Self {
        Sweep { channels: names.iter().map(|name| (*name).to_owned()).collect(), ..self }
    }

    /// Rattle state, contact loss and impacts of every contact are wanted.
    pub fn rattle(self) -> Self {
        Sweep { rattle: true, ..self }
    }

    /// The last `count` strobed states are wanted, at most those of the measured periods, with the extremes of the channels in each of their periods.
    pub fn strobe(self, count: usize) -> Self {
        Sweep { strobes: count, ..self }
    }

    /// The largest Lyapunov exponent is wanted. It is computed with the variational equations and located edges, whatever the engine: from where
    /// the run of the point has ended, so that nothing is left to settle, over the periods and with the tolerance of `lyapunov`; how many it
    /// settles and how many exponents it computes otherwise is of no account. It costs about as much as three times the periods with
    /// [`Located`](crate::sweep::Located).
    pub fn lyapunov(self, lyapunov: Lyapunov) -> Self {
        Sweep { lyapunov: Some(lyapunov.settle(0).count(1)), ..self }
    }

    /// Where runs start from.
    pub fn carry(self, carry: WarmStart) -> Self {
        Sweep { carry, ..self }
    }

    /// Every `count`-th point of the sweep is run once more with a quarter of the step, which says how far the step is off; 0 checks none. Lines
    /// along which states are carried are run again as a whole, for every `count`-th of them.
    pub fn check_every(self, count: usize) -> Self {
        Sweep { check_every: count, ..self }
    }

    pub(crate) fn names(&self) -> &[String] {
        &self.channels
    }

    /// Figures of a Lyapunov exponent in a row.
    pub(crate) fn exponents(&self) -> usize {
        if self.lyapunov.is_some() { 2 } else { 0 }
    }

    /// The points.
    pub fn points(&self) -> &Points {
        &self.points
    }

    /// Points that are run one after the other, the state carried from each to the next.
    pub(crate) fn line(&self) -> usize {
        if self.carry == WarmStart::No { 1 } else { self.points.line() }
    }

    pub(crate) fn check(&self) -> Result<(), SweepError> {
        if self.measure == 0 {
            return Err(SweepError::Setting { name: "measure", value: 0.0, allowed: "at least 1 period" });
        }
        for (name, value) in [("periodic_within", Some(self.tolerance)), ("until_repeats", self.repeat)] {
            if let Some(value) = value.filter(|x| !(x.is_finite() && *x > 0.0)) {
                return Err(SweepError::Setting { name, value, allowed: "positive and finite" });
            }
        }
        if let Some(lyapunov) = &self.lyapunov {
            lyapunov.check_settings()?;
        }
        Ok(())
    }
}

/// Many runs of one family of models: which points, how long to settle and to measure, and what. Nothing is stored of a run but its row.
///
/// A rattle map in ten lines:
///
/// ```
/// use gear_dynamics::{sweep::{Axis, LaneRk4, Points}, NfgPair, NfgParams, RattleState, Sweep};
/// let map = Sweep::over(Points::grid(vec![Axis::linear("speed", 120.0, 180.0, 4)?, Axis::linear("load", 20.0, 40.0, 4)?])?)
///     .settle(4)
///     .measure(1)
///     .channels(&["q1"])
///     .rattle()
///     .run(
///         &LaneRk4::<16>::new(63 * 32),
///         |p| NfgPair::new(&NfgParams { speed: p["speed"], load_torque: p["load"], ..NfgParams::table1() }),
///         |_, pair| pair.static_start(),
///     )?;
/// assert_eq!(map.iter().filter(|row| row.rattle_state(0) == RattleState::Bilateral).count(), 7);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
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
    pub(crate) carry: WarmStart,
    pub(crate) check_every: usize,
}
