//! Statistics of channels over a run.

use crate::analysis::seven_points::{CELLS, NODES, OFF, POINTS, on_grid, sixth};
use crate::analysis::summary::Summary;
use crate::error::{ParameterError, check};
use crate::model::Model;
use crate::numeric::gauss::FIVE;
use crate::numeric::moments::Moments;
use crate::numeric::search::parabola::{maximum, peak, vertex};
use crate::ode::probe::Probe;
use crate::ode::{Observer, Step};
use std::fmt;
use std::ops::ControlFlow;

/// Observer that computes the [`Summary`] of chosen channels from the dense output.
///
/// Integrals use Gauss quadrature with five points in every step. A step in which a channel swings is
/// divided, down to 1/64 of what resolves the motion: the mean square is then off by some 1e-7 of the range
/// of the channel. Extremes are located inside the steps. No samples are stored.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, State, Statistics, model::from_fn};
/// let spring = from_fn(1, |_, q, _, a| a[0] = -q[0])?;
/// let mut statistics = Statistics::new(&spring, &["q0"])?;
/// let start = State::new(0.0, &[1.0], &[0.0]);
/// Dop853::new().rtol(1e-11).run(&spring, &start, std::f64::consts::TAU, &mut statistics)?;
/// let q = statistics.summary("q0")?;
/// assert!((q.max - 1.0).abs() < 1e-9 && (q.min + 1.0).abs() < 1e-9);
/// assert!((q.rms - 0.5f64.sqrt()).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use = "an observer records during a run"]
pub struct Statistics<'m> {
    probe: Probe<'m>,
    chosen: Vec<usize>,
    running: Vec<Running>,
    duration: f64,
    /// Coordinates, then velocities, of the last evaluation.
    y: Vec<f64>,
    /// The chosen channels at the points of one step.
    points: Vec<[f64; POINTS]>,
}

impl fmt::Debug for Statistics<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Statistics")
            .field("channels", &self.chosen)
            .field("duration", &self.duration)
            .finish_non_exhaustive()
    }
}

/// Figures of one channel so far.
#[derive(Clone, Copy)]
struct Running {
    min: f64,
    max: f64,
    /// First value f0; NaN before the first step.
    origin: f64,
    /// ∫ (f - f0) dt.
    off: f64,
    /// ∫ (f - f0)² dt.
    off_square: f64,
}

impl Running {
    const NONE: Running =
        Running { min: f64::INFINITY, max: f64::NEG_INFINITY, origin: f64::NAN, off: 0.0, off_square: 0.0 };

    /// Returns the largest distance from the first value if five Gauss points are too few for the mean square
    /// over a stretch with these values at its points, `None` if they suffice.
    fn swings(&self, points: &[f64; POINTS]) -> Option<f64> {
        let origin = if self.origin.is_nan() { points[0] } else { self.origin };
        let off = |value: f64| (value - origin).abs();
        let before = if self.min <= self.max { off(self.min).max(off(self.max)) } else { 0.0 };
        let largest = points.iter().fold(before, |m, f| m.max(off(*f)));
        let squares = sixth(points.iter().map(|f| off(*f) * off(*f))) / (largest * largest);
        let values = sixth(points.iter().map(|f| f - origin)) / largest;
        (squares.abs() > SWING[0] || values.abs() > SWING[1]).then_some(largest)
    }
}

/// Largest number of halvings of a part of a step.
const HALVINGS: usize = 6;

/// Largest sixth divided differences over a stretch, of the squares as a share of the largest one and of the
/// values as a share of the largest one. For a sine the mean square is then off by 1e-9 of the square, over a
/// fifth of its period. Of a channel that swings many times one of them may be small by chance.
const SWING: [f64; 2] = [2e-3, 5e-4];

impl<'m> Statistics<'m> {
    /// Statistics of the channels of these names (see [`Probe`]).
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`] for a channel that the model does not have.
    pub fn new(model: &'m dyn Model, channels: &[&str]) -> Result<Self, ParameterError> {
        let chosen = Probe::new(model).indices(channels)?;
        Ok(Statistics::of_channels(model, &chosen))
    }

    /// Statistics of the channels of these indices.
    pub(crate) fn of_channels(model: &'m dyn Model, chosen: &[usize]) -> Self {
        Statistics {
            probe: Probe::new(model),
            running: vec![Running::NONE; chosen.len()],
            points: vec![[0.0; POINTS]; chosen.len()],
            chosen: chosen.to_vec(),
            duration: 0.0,
            y: vec![0.0; 2 * model.dof()],
        }
    }

    /// The figures of a chosen channel over all steps so far.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`] for a channel that was not chosen; [`ParameterError::Empty`] before
    /// the first step; [`ParameterError::Overflow`] if the squares of the values overflow;
    /// [`ParameterError::NotFinite`] if a value was NaN.
    pub fn summary(&self, channel: &str) -> Result<Summary, ParameterError> {
        let names: Vec<&str> = (0..self.chosen.len()).map(|i| self.name(i)).collect();
        self.summary_of(check::channel_index(&names, channel)?)
    }

    /// The name of the chosen channel `i`.
    fn name(&self, i: usize) -> &str {
        &self.probe.channels()[self.chosen[i]].name
    }

    /// The figures of the chosen channel `i`.
    ///
    /// # Errors
    /// As [`summary`](Statistics::summary).
    pub(crate) fn summary_of(&self, i: usize) -> Result<Summary, ParameterError> {
        if self.duration <= 0.0 {
            return Err(ParameterError::Empty { name: "the observed run".into(), min: 1 });
        }
        let r = self.running[i];
        let moments = Moments::about(r.origin, [r.off, r.off_square], self.duration);
        let square = moments.mean_square();
        if square.is_nan() {
            return Err(ParameterError::NotFinite { name: self.name(i).into(), value: square });
        }
        check::representable(format!("mean square of {}", self.name(i)), square, &[r.min, r.max])?;
        Ok(Summary::of_moments(&moments, [r.min, r.max]))
    }

    /// All channels at `t` of a step; at the ends of the step, the limits from inside it.
    fn read(&mut self, step: &mut Step<'_>, t: f64) -> &[f64] {
        self.probe.read_step(step, t, &mut self.y)
    }

    /// Adds part `k` of a step. Its start is the end of the part before.
    fn part(&mut self, step: &mut Step<'_>, k: usize) {
        let (t0, t1) = step.part(k);
        if k == 0 {
            self.read_point(step, t0, POINTS - 1);
        }
        self.stretch(step, t0, t1, HALVINGS);
        self.duration += t1 - t0;
    }

    /// Reads the chosen channels at `t`, point `p` of the points.
    fn read_point(&mut self, step: &mut Step<'_>, t: f64, p: usize) {
        self.read(step, t);
        let values = self.probe.values();
        for (points, &index) in self.points.iter_mut().zip(&self.chosen) {
            points[p] = values[index];
        }
    }

    /// Whether a channel swings too far in a stretch around `middle`, by more than rounding errors.
    fn swings(&mut self, step: &mut Step<'_>, middle: f64) -> bool {
        let Statistics { probe, chosen, running, y, points, .. } = self;
        chosen.iter().zip(running).zip(points).any(|((&index, running), points)| {
            let swing = running.swings(points);
            swing.is_some_and(|range| probe.resolves(step, middle, (index, range), y))
        })
    }

    /// Adds a part of a step, in halves if a channel swings too far in it. The last points are those at `t0`.
    fn stretch(&mut self, step: &mut Step<'_>, t0: f64, t1: f64, halvings: usize) {
        let (middle, half) = (0.5 * (t0 + t1), 0.5 * (t1 - t0));
        self.points.iter_mut().for_each(|points| points[0] = points[POINTS - 1]);
        for (p, x) in NODES.into_iter().enumerate().skip(1) {
            self.read_point(step, if p < POINTS - 1 { middle + half * x } else { t1 }, p);
        }
        if halvings > 0 && self.swings(step, middle) {
            self.points.iter_mut().for_each(|points| points[POINTS - 1] = points[0]);
            self.stretch(step, t0, middle, halvings - 1);
            return self.stretch(step, middle, t1, halvings - 1);
        }
        for c in 0..self.chosen.len() {
            let (points, running) = (self.points[c], &mut self.running[c]);
            if running.origin.is_nan() {
                running.origin = points[0];
            }
            for (value, [_, w]) in points[1..].iter().zip(FIVE) {
                let off = value - running.origin;
                running.off += half * w * off;
                running.off_square += half * w * off * off;
            }
            self.extremes(step, (t0, t1), c);
        }
    }

    /// Updates the extremes of channel `c` from the points of a part. The polynomial through them shows, on a
    /// grid, where an extremum may be; there the channel itself is read.
    fn extremes(&mut self, step: &mut Step<'_>, (t0, t1): (f64, f64), c: usize) {
        let (index, f, Running { min, max, .. }) = (self.chosen[c], self.points[c], self.running[c]);
        let lowest = f.iter().copied().fold(f64::INFINITY, f64::min);
        let highest = f.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let range = highest - lowest;
        if highest + range <= max && lowest - range >= min {
            return;
        }
        let grid = on_grid(&f);
        let time = |k: usize| if k == CELLS { t1 } else { t0 + (t1 - t0) * (k as f64 / CELLS as f64) };
        for sign in [1.0, -1.0] {
            let mut at = |t: f64| sign * self.read(step, t)[index];
            let mut best = if sign > 0.0 { highest.max(max) } else { -lowest.min(min) };
            for k in 1..CELLS {
                let [x, g] = [[time(k - 1), time(k), time(k + 1)], [k - 1, k, k + 1].map(|k| sign * grid[k])];
                if g[1] >= g[0] && g[1] >= g[2] && peak(x, g) + OFF * range > best {
                    let values = x.map(&mut at);
                    best = values.into_iter().fold(best, f64::max).max(maximum(x, values, &mut at));
                }
            }
            for (end, near) in [(0, 1), (CELLS, CELLS - 1)] {
                if sign * grid[end] > sign * grid[near] && sign * grid[end] + OFF * range > best {
                    best = best.max(beside_end([time(end), time(near)], sign * grid[end], &mut at));
                }
            }
            if sign > 0.0 { self.running[c].max = best } else { self.running[c].min = -best }
        }
    }
}

/// The largest value of a channel between the end of a part, where the channel has `value`, and the next
/// point `near` of the grid. A parabola through points close to the end tells on which side of the end the
/// vertex lies; a parabola through points of the grid may not.
fn beside_end([end, near]: [f64; 2], value: f64, mut at: impl FnMut(f64) -> f64) -> f64 {
    let [close, next] = [1.0 / 16.0, 1.0 / 8.0].map(|share| end + share * (near - end));
    let (mut x, mut f) = ([end, close, next], [value, at(close), at(next)]);
    let behind = (vertex(x, f) - end) / (near - end);
    if f[1].max(f[2]) <= value && !(behind > 0.0 && behind < 1.0 / 8.0) {
        return value;
    }
    if f[2] > f[1] {
        (x, f) = ([end, next, near], [value, f[2], at(near)]);
    }
    if near < end {
        x.reverse();
        f.reverse();
    }
    f.into_iter().fold(value, f64::max).max(maximum(x, f, at))
}

impl Observer for Statistics<'_> {
    fn fits(&self, dof: usize, contacts: usize) -> Result<(), ParameterError> {
        self.probe.fits(dof, contacts)
    }
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        for k in 0..step.parts() {
            self.part(step, k);
        }
        ControlFlow::Continue(())
    }
}
