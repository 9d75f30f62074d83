//! Bifurcation diagrams along the axis (up) and back (down).

use crate::error::{ParameterError, check};
use crate::model::Periodic;
use crate::sweep::engines::sweep_engine::SweepEngine;
use crate::sweep::rows::collection::Rows;
use crate::sweep::rows::row::Row;
use crate::sweep::schedule::runner::Runner;
use crate::sweep::settings::sweep::WarmStart;
use crate::sweep::sweep_error::SweepError;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A bifurcation diagram: a sweep over one parameter along the axis (up) and back (down). Each run starts
/// from the state in which the previous one ended.
///
/// Settling periods, measured periods, the tolerance of a periodic motion and Lyapunov exponents are settings
/// of the [`Sweep`](crate::Sweep).
///
/// ```
/// use gear_dynamics::{sweep::{Axis, Bifurcation, LaneRk4}, NfgPair, NfgParams, Sweep};
/// let speeds = Axis::linear("speed", 100.0, 120.0, 3)?;
/// let (sweep, engine) = (Sweep::new(speeds).settle(20).measure(4), LaneRk4::new(63 * 32));
/// let diagram = Bifurcation::strobed("q0").run(&sweep.of(
///     &engine,
///     |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
/// ))?;
/// assert_eq!(diagram.up().iter().map(|p| p.parameter).collect::<Vec<_>>(), [100.0, 110.0, 120.0]);
/// assert!(diagram.hysteresis(1e-3)?.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Bifurcation {
    channel: String,
    strobed: bool,
}

impl Bifurcation {
    /// Samples a coordinate or velocity (`q0`, `v0`, ...) once per measured period.
    pub fn strobed(channel: &str) -> Self {
        Bifurcation { channel: channel.into(), strobed: true }
    }
    /// Takes the minimum and the maximum of a channel in every measured period.
    pub fn extremes(channel: &str) -> Self {
        Bifurcation { channel: channel.into(), strobed: false }
    }

    /// Runs a sweep up and down. The first run of each pass starts from the start state of the runner.
    /// [`watch`](Runner::watch) counts both passes together, the
    /// [row callback](Runner::row_callback) gets the rows of both. After cancelling,
    /// the diagram holds the points done so far.
    ///
    /// # Errors
    /// As [`Runner::run`]; a sweep over more than one parameter; for strobed values a channel that is not a
    /// coordinate or velocity.
    pub fn run<M: Periodic, E: SweepEngine<M>>(
        &self,
        runner: &Runner<'_, M, E>,
    ) -> Result<Diagram, SweepError> {
        let (points, watch) = (runner.sweep.points(), &runner.watch);
        check::length("parameters of a bifurcation diagram", points.names().len(), 1)?;
        let model = (0..points.len())
            .take_while(|_| !watch.is_cancelled())
            .find_map(|i| (runner.family)(&points.point(i)).ok());
        let component = match model {
            Some(model) if self.strobed => component(&self.channel, model.dof())?,
            _ => 0,
        };
        let mut names: Vec<&str> = runner.sweep.names().iter().map(String::as_str).collect();
        if !names.contains(&self.channel.as_str()) {
            names.push(&self.channel);
        }
        // Strobed states of all measured periods: the sweep reduces the count to their number.
        let sweep = runner.sweep.clone().channels(&names).strobe(usize::MAX);
        let done = [const { AtomicUsize::new(0) }; 2];
        let way = |way: usize, warm_start: WarmStart| {
            let show = |now: usize, total: usize| {
                let now = done[way].fetch_max(now, Ordering::Relaxed).max(now);
                watch.show(now + done[1 - way].load(Ordering::Relaxed), 2 * total);
            };
            let sweep = sweep.clone().warm_start(warm_start);
            let way = Runner {
                sweep: &sweep,
                engine: runner.engine,
                family: Box::new(|point| (runner.family)(point)),
                start: Box::new(|point, model| (runner.start)(point, model)),
                watch: watch.clone().progress(show),
                rows: runner.rows.clone(),
            };
            way.run()
        };
        let (up, down) = rayon::join(|| way(0, WarmStart::Up), || way(1, WarmStart::Down));
        let (up_rows, down_rows) = (up?, down?);
        let pass = |rows: &Rows| {
            rows.iter().map(|row| self.point(&row, component)).collect::<Result<Vec<_>, ParameterError>>()
        };
        Ok(Diagram { up: pass(&up_rows)?, down: pass(&down_rows)?, up_rows, down_rows })
    }

    /// The values of one row; `component`: index of the channel in a state, for strobed values.
    fn point(&self, row: &Row<'_>, component: usize) -> Result<DiagramPoint, ParameterError> {
        let values = match self.strobed {
            true => row.strobes().map(|state| state[component]).collect(),
            false => row.extremes(&self.channel)?.concat(),
        };
        Ok(DiagramPoint {
            index: row.index(),
            parameter: row.point().values()[0],
            values,
            period_multiple: row.period_multiple(),
        })
    }
}

/// The index of `q0`, `v0`, ... in a state.
fn component(name: &str, dof: usize) -> Result<usize, ParameterError> {
    let names: Vec<String> =
        ["q", "v"].iter().flat_map(|x| (0..dof).map(move |i| format!("{x}{i}"))).collect();
    check::channel_index(&names, name)
}

/// The values of a diagram at one value of the parameter, in one pass.
///
/// ```
/// use gear_dynamics::sweep::{Axis, Bifurcation, TableRk4};
/// use gear_dynamics::{State, Sweep, model::from_fn};
/// // q'' + 3 q' + 2 q = f cos 2t
/// let swing = |f: f64| {
///     let swing = from_fn(1, move |t, q, v, a| a[0] = f * (2.0 * t).cos() - 3.0 * v[0] - 2.0 * q[0])?;
///     swing.with_period(std::f64::consts::PI)
/// };
/// let amplitudes = Axis::of_values("f", &[1.0, 4.0])?;
/// let (sweep, engine) = (Sweep::new(amplitudes).settle(20).measure(2), TableRk4::new(64));
/// let diagram = Bifurcation::strobed("q0").run(&sweep.of(
///     &engine,
///     |p| swing(p["f"]),
/// ).start(|_, _| State::at_rest(1)))?;
/// let point = &diagram.up()[1];
/// assert_eq!((point.index, point.parameter, point.period_multiple), (1, 4.0, Some(1)));
/// // Closed form: q = f (3 sin 2t - cos 2t)/20.
/// assert!(point.values.iter().all(|q| (q + 0.2).abs() < 1e-5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DiagramPoint {
    /// Index of the point on the axis, counted from 0.
    pub index: usize,
    /// The value of the parameter.
    pub parameter: f64,
    /// Strobed values, or minimum and maximum, of every measured period.
    pub values: Vec<f64>,
    /// Period multiple of the motion; `None` if it does not repeat.
    pub period_multiple: Option<usize>,
}

/// The result of a [`Bifurcation`]: the passes up and down.
///
/// ```
/// # use gear_dynamics::{sweep::{Axis, Bifurcation, LaneRk4}, NfgPair, NfgParams, Sweep};
/// let speeds = Axis::linear("speed", 100.0, 110.0, 2)?;
/// let (sweep, engine) = (Sweep::new(speeds).settle(3).measure(1), LaneRk4::new(63 * 32));
/// let diagram = Bifurcation::extremes("deflection").run(&sweep.of(
///     &engine,
///     |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
/// ))?;
/// assert_eq!((diagram.down()[1].parameter, diagram.down()[1].values.len()), (110.0, 2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Diagram {
    up: Vec<DiagramPoint>,
    down: Vec<DiagramPoint>,
    up_rows: Rows,
    down_rows: Rows,
}

impl Diagram {
    /// The pass along the axis, in its order, without the points that failed.
    pub fn up(&self) -> &[DiagramPoint] {
        &self.up
    }
    /// The pass back along the axis, also in the order of the axis, without the points that failed.
    pub fn down(&self) -> &[DiagramPoint] {
        &self.down
    }
    /// The rows of the passes up and down, with the errors of the points that failed.
    pub fn rows(&self) -> [&Rows; 2] {
        [&self.up_rows, &self.down_rows]
    }

    /// The values of the parameter at which the two passes end on different motions.
    ///
    /// The motions are different if a value x of one pass has min |x - y| > `tolerance` × (max - min) over
    /// all values y of the other. Max and min are those of the whole diagram. [Undecided](Diagram::undecided)
    /// values of the parameter are left out.
    ///
    /// # Errors
    /// A tolerance that is not positive and finite.
    pub fn hysteresis(&self, tolerance: f64) -> Result<Vec<f64>, ParameterError> {
        let tolerance = check::positive("tolerance of the hysteresis", tolerance)?;
        let all = self.up.iter().chain(&self.down).flat_map(|point| &point.values);
        let (lo, hi) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(*x), hi.max(*x)));
        let far = |a: &[f64], b: &[f64]| {
            let nearest = |x: &f64| b.iter().fold(f64::INFINITY, |m: f64, y| m.min((x - y).abs()));
            a.iter().map(nearest).fold(0.0, f64::max) > tolerance * (hi - lo)
        };
        let differ = |(a, b): (&DiagramPoint, &DiagramPoint)| {
            (far(&a.values, &b.values) || far(&b.values, &a.values)).then_some(a.parameter)
        };
        Ok(self.decided().filter_map(differ).collect())
    }

    /// The values of the parameter at which hysteresis cannot be decided: neither motion repeats (chaos, not
    /// settled, or a step too coarse for [`periodic_tolerance`](crate::Sweep::periodic_tolerance)), or a
    /// run failed.
    pub fn undecided(&self) -> Vec<f64> {
        let decided: Vec<usize> = self.decided().map(|(a, _)| a.index).collect();
        let points = self.up_rows.points();
        (0..points.len())
            .filter(|i| decided.binary_search(i).is_err())
            .map(|i| points.point(i).values()[0])
            .collect()
    }

    /// The points of both passes at which at least one motion repeats.
    fn decided(&self) -> impl Iterator<Item = (&DiagramPoint, &DiagramPoint)> {
        let down = |a: &DiagramPoint| {
            self.down.binary_search_by_key(&a.index, |b| b.index).ok().map(|i| &self.down[i])
        };
        let pairs = self.up.iter().filter_map(move |a| Some((a, down(a)?)));
        pairs.filter(|(a, b)| a.period_multiple.is_some() || b.period_multiple.is_some())
    }
}
