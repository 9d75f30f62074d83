//! Bifurcation diagrams, up and down.

use super::engine::SweepEngine;
use super::error::SweepError;
use super::points::{Axis, Point, Points};
use super::row::Row;
use super::rows::Rows;
use super::run::{Carry, Sweep};
use super::watch::Watch;
use crate::error::ParameterError;
use crate::model::{Periodic, State};
use crate::orbit::Lyapunov;
use std::fmt::Display;

/// What is drawn of each run of a bifurcation diagram.
///
/// ```
/// assert_ne!(gear_dynamics::Marks::Strobed, gear_dynamics::Marks::Extremes);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marks {
    /// A coordinate or velocity (`q1`, `v1`, ...) once in every period.
    Strobed,
    /// The least and the largest value of a channel in every period.
    Extremes,
}

/// A bifurcation diagram: one parameter up and down, each run starting from where the one before it ended.
///
/// ```
/// use gear_dynamics::{Axis, Bifurcation, LaneRk4, Marks, NfgPair, NfgParams};
/// let diagram = Bifurcation::over(Axis::linear("speed", 100.0, 120.0, 3)?, "q1", Marks::Strobed).settle(4).measure(2).run(
///     &LaneRk4::<4>::new(63 * 32),
///     |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
///     |_, pair| pair.static_start(),
/// )?;
/// assert!(diagram.hysteresis(1e-3).is_empty());
/// assert_eq!(diagram.up().len(), 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Bifurcation {
    axis: Axis,
    channel: String,
    marks: Marks,
    settle: usize,
    measure: usize,
    lyapunov: Option<Lyapunov>,
}

impl Bifurcation {
    /// Of a channel along an axis; 60 periods to settle and 40 to draw at every value.
    pub fn over(axis: Axis, channel: &str, marks: Marks) -> Self {
        Bifurcation { axis, channel: channel.into(), marks, settle: 60, measure: 40, lyapunov: None }
    }
    /// Periods to settle at every value.
    pub fn settle(self, periods: usize) -> Self {
        Bifurcation { settle: periods, ..self }
    }
    /// Periods to draw at every value.
    pub fn measure(self, periods: usize) -> Self {
        Bifurcation { measure: periods, ..self }
    }
    /// The largest Lyapunov exponent at every value as well, as in [`Sweep::lyapunov`]: [`Row::lyapunov`] of the [rows](Diagram::rows).
    pub fn lyapunov(self, lyapunov: Lyapunov) -> Self {
        Bifurcation { lyapunov: Some(lyapunov), ..self }
    }

    /// Runs up and down; the first run of each way starts from `start`.
    ///
    /// # Errors
    /// As [`Sweep::run`]; a channel that is no coordinate or velocity for strobed marks.
    pub fn run<M, E, X, Y>(
        &self,
        engine: &E,
        family: impl Fn(&Point<'_>) -> Result<M, X> + Sync,
        start: impl Fn(&Point<'_>, &M) -> Result<State, Y> + Sync,
    ) -> Result<Diagram, SweepError>
    where
        M: Periodic,
        E: SweepEngine<M>,
        X: Display,
        Y: Display,
    {
        let mut sweep = Sweep::over(Points::along(self.axis.clone()))
            .settle(self.settle)
            .measure(self.measure)
            .channels(&[&self.channel])
            .strobe(self.measure);
        if let Some(lyapunov) = self.lyapunov {
            sweep = sweep.lyapunov(lyapunov);
        }
        let way = |carry| sweep.clone().carry(carry).run_chunk(0, 1, engine, &family, &start, &Watch::new());
        let (up, down) = rayon::join(|| way(Carry::Up), || way(Carry::Down));
        let (up, down) = (up?, down?);
        let component = match self.marks {
            Marks::Extremes => 0,
            Marks::Strobed => strobed(&self.channel, up.layout.dof)?,
        };
        let branch = |rows: &Rows| rows.iter().map(|row| self.value(&row, component)).collect::<Result<Vec<_>, ParameterError>>();
        Ok(Diagram { up: branch(&up)?, down: branch(&down)?, up_rows: up, down_rows: down })
    }

    fn value(&self, row: &Row<'_>, component: usize) -> Result<Mark, ParameterError> {
        let values = match self.marks {
            Marks::Strobed => row.strobes().map(|state| state[component]).collect(),
            Marks::Extremes => row.extremes(&self.channel)?.concat(),
        };
        Ok(Mark { parameter: row.point().values()[0], values, period: row.period_multiple() })
    }
}

/// Where `q1`, `v1`, ... stand in a state.
fn strobed(name: &str, dof: usize) -> Result<usize, ParameterError> {
    let known = || (1..=dof).flat_map(|i| [format!("q{i}"), format!("v{i}")]).collect::<Vec<_>>().join(", ");
    (0..dof)
        .find_map(|i| match name {
            _ if name == format!("q{}", i + 1) => Some(i),
            _ if name == format!("v{}", i + 1) => Some(dof + i),
            _ => None,
        })
        .ok_or_else(|| ParameterError::NoSuchChannel { name: name.into(), known: known() })
}

/// The marks at one value of the parameter.
///
/// ```
/// let mark = gear_dynamics::Mark { parameter: 150.0, values: vec![1.0, 2.0], period: Some(2) };
/// assert_eq!(mark.values.len(), 2);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// The value of the parameter.
    pub parameter: f64,
    /// What is drawn.
    pub values: Vec<f64>,
    /// Periods after which the motion repeats, if it does.
    pub period: Option<usize>,
}

/// A finished diagram.
///
/// ```
/// # use gear_dynamics::{Axis, Bifurcation, LaneRk4, Marks, NfgPair, NfgParams};
/// let speeds = Axis::linear("speed", 100.0, 110.0, 2)?;
/// let diagram = Bifurcation::over(speeds, "deflection", Marks::Extremes).settle(3).measure(1).run(
///     &LaneRk4::<4>::new(63 * 32),
///     |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
///     |_, pair| pair.static_start(),
/// )?;
/// assert_eq!(diagram.down()[1].parameter, 110.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Diagram {
    up: Vec<Mark>,
    down: Vec<Mark>,
    up_rows: Rows,
    down_rows: Rows,
}

impl Diagram {
    /// The marks on the way up, by increasing parameter.
    pub fn up(&self) -> &[Mark] {
        &self.up
    }
    /// The marks on the way down, by increasing parameter.
    pub fn down(&self) -> &[Mark] {
        &self.down
    }
    /// All figures of both ways, with the errors of values that failed.
    pub fn rows(&self) -> [&Rows; 2] {
        [&self.up_rows, &self.down_rows]
    }

    /// The values of the parameter at which the two ways end on different motions: a mark of one lies farther from all marks of the other than
    /// this share of the range of the whole diagram. Where both are aperiodic no claim is made.
    pub fn hysteresis(&self, tolerance: f64) -> Vec<f64> {
        let all = self.up.iter().chain(&self.down).flat_map(|mark| &mark.values);
        let (lo, hi) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(*x), hi.max(*x)));
        let far = |a: &[f64], b: &[f64]| {
            let nearest = |x: &f64| b.iter().fold(f64::INFINITY, |m: f64, y| m.min((x - y).abs()));
            a.iter().map(nearest).fold(0.0, f64::max) > tolerance * (hi - lo)
        };
        let differ = |(a, b): (&Mark, &Mark)| match (a.period, b.period) {
            (None, None) => None,
            _ => (far(&a.values, &b.values) || far(&b.values, &a.values)).then_some(a.parameter),
        };
        let pairs = self.up.iter().filter_map(|a| self.down.iter().find(|b| b.parameter == a.parameter).map(|b| (a, b)));
        pairs.filter_map(differ).collect()
    }
}
