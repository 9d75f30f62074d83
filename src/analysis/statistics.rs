//! Mean, RMS and extremes of channels over a run.

use crate::error::{ParameterError, check};
use crate::model::equations::Model;
use crate::numeric::gauss::FIVE;
use crate::ode::probe::Probe;
use crate::ode::step::{Observer, Step};
use std::ops::ControlFlow;

/// What a channel did over a window of time.
///
/// ```
/// let summary = gear_dynamics::analysis::Summary::of(&[1.0, 3.0])?;
/// assert_eq!((summary.mean, summary.peak_to_peak()), (2.0, 2.0));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// 1/T ∫ f dt.
    pub mean: f64,
    /// √(1/T ∫ f² dt).
    pub rms: f64,
    /// Least value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// √(1/T ∫ (f - mean)² dt), by moments about a value that the channel has had: it does not cancel where the mean is large.
    pub deviation: f64,
}

impl Summary {
    /// Of equally spaced samples.
    ///
    /// # Errors
    /// No samples; one that is not finite; [`ParameterError::Overflow`] for samples whose sum or mean square is beyond the largest number.
    pub fn of(samples: &[f64]) -> Result<Self, ParameterError> {
        if samples.is_empty() {
            return Err(ParameterError::Empty { name: "samples".into(), least: 1 });
        }
        check::all_finite("samples", samples)?;
        let n = samples.len() as f64;
        let mean = check::representable("mean", samples.iter().sum::<f64>() / n, samples)?;
        Ok(Summary {
            mean,
            rms: check::representable(
                "mean square",
                (samples.iter().map(|x| x * x).sum::<f64>() / n).sqrt(),
                samples,
            )?,
            deviation: (samples.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n).sqrt(),
            min: samples.iter().copied().fold(f64::INFINITY, f64::min),
            max: samples.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        })
    }

    /// max - min: the ppv of Liu 2021.
    pub fn peak_to_peak(&self) -> f64 {
        self.max - self.min
    }
    /// RMS about the mean.
    pub fn standard_deviation(&self) -> f64 {
        self.deviation
    }
}

/// Observes a run and keeps mean, RMS and extremes of chosen channels, from the dense output: integrals by Gauss points in every step,
/// extremes located inside the step. Nothing is stored but the figures.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, Model, State, Statistics};
/// struct Spring;
/// impl Model for Spring {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) { a[0] = -q[0]; }
/// }
/// let mut statistics = Statistics::new(&Spring, &["q1"])?;
/// Dop853::new().rtol(1e-11).run(&Spring, &State::new(0.0, &[1.0], &[0.0]), std::f64::consts::TAU, &mut statistics)?;
/// let q = statistics.summary("q1")?;
/// assert!((q.max - 1.0).abs() < 1e-9 && (q.min + 1.0).abs() < 1e-9);
/// assert!((q.rms - 0.5f64.sqrt()).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Statistics<'m, M: ?Sized> {
    probe: Probe<'m, M>,
    names: Vec<String>,
    chosen: Vec<usize>,
    running: Vec<Running>,
    duration: f64,
    /// State, and the channels at the points of one step.
    y: Vec<f64>,
    points: Vec<[f64; POINTS]>,
}

#[derive(Clone, Copy)]
struct Running {
    sum: f64,
    square: f64,
    min: f64,
    max: f64,
    /// The first value, and the integrals of what the channel is off it and of the square of that.
    origin: f64,
    off: f64,
    off_square: f64,
}

impl Running {
    const NONE: Running = Running {
        sum: 0.0,
        square: 0.0,
        min: f64::INFINITY,
        max: f64::NEG_INFINITY,
        origin: f64::NAN,
        off: 0.0,
        off_square: 0.0,
    };
}

/// Start, Gauss points, end.
const POINTS: usize = 7;

/// Rounds of parabolic refinement of an extremum.
const ROUNDS: usize = 12;

impl<'m, M: Model + ?Sized> Statistics<'m, M> {
    /// Of these channels (see [`Probe`]).
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`].
    pub fn new(model: &'m M, channels: &[&str]) -> Result<Self, ParameterError> {
        let probe = Probe::new(model);
        let chosen = channels.iter().map(|name| probe.index(name)).collect::<Result<Vec<_>, _>>()?;
        Ok(Statistics {
            probe,
            names: channels.iter().map(|name| (*name).to_owned()).collect(),
            running: vec![Running::NONE; chosen.len()],
            points: vec![[0.0; POINTS]; chosen.len()],
            chosen,
            duration: 0.0,
            y: vec![0.0; 2 * model.dof()],
        })
    }

    /// The figures of a channel so far.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`] for one that was not asked for; [`ParameterError::Empty`] before the first step;
    /// [`ParameterError::Overflow`] for values whose squares overflow, [`ParameterError::NotFinite`] for a channel that was not a number.
    pub fn summary(&self, channel: &str) -> Result<Summary, ParameterError> {
        let Some(i) = self.names.iter().position(|name| name == channel) else {
            return Err(ParameterError::NoSuchChannel { name: channel.into(), known: self.names.join(", ") });
        };
        if self.duration <= 0.0 {
            return Err(ParameterError::Empty { name: "the observed run".into(), least: 1 });
        }
        let r = self.running[i];
        let off = r.off / self.duration;
        let squares = r.square + r.off_square;
        if squares.is_nan() {
            return Err(ParameterError::NotFinite { name: channel.into(), value: squares });
        }
        check::representable(format!("mean square of {channel}"), squares, &[r.min, r.max])?;
        let deviation = (r.off_square / self.duration - off * off).max(0.0).sqrt();
        Ok(Summary {
            mean: r.sum / self.duration,
            rms: (r.square / self.duration).sqrt(),
            min: r.min,
            max: r.max,
            deviation,
        })
    }

    /// All channels at `t` of the step, the ends seen from inside.
    fn look(&mut self, step: &mut Step<'_>, t: f64) -> &[f64] {
        self.probe.read_step(step, t, &mut self.y)
    }

    /// The extremum (sign 1: maximum) of channel `c` inside a bracket whose middle is best.
    fn refine(&mut self, step: &mut Step<'_>, c: usize, sign: f64, mut x: [f64; 3], mut f: [f64; 3]) -> f64 {
        let mut best = f[1];
        for _ in 0..ROUNDS {
            let vertex = vertex(x, f);
            let middle = 0.5 * (x[0] + x[2]);
            let inside = vertex > x[0] && vertex < x[2] && vertex != x[1];
            let t = if inside { vertex } else { 0.5 * (x[1] + if middle > x[1] { x[2] } else { x[0] }) };
            if !(t > x[0] && t < x[2]) || t == x[1] {
                break;
            }
            let index = self.chosen[c];
            let value = sign * self.look(step, t)[index];
            let gained = value - best;
            // Keep the three points around the best.
            (x, f) = match (t > x[1], value > f[1]) {
                (true, true) => ([x[1], t, x[2]], [f[1], value, f[2]]),
                (true, false) => ([x[0], x[1], t], [f[0], f[1], value]),
                (false, true) => ([x[0], t, x[1]], [f[0], value, f[1]]),
                (false, false) => ([t, x[1], x[2]], [value, f[1], f[2]]),
            };
            best = best.max(value);
            if gained.abs() <= 1e-15 * best.abs() {
                break;
            }
        }
        best
    }

    fn extremes(&mut self, step: &mut Step<'_>, times: &[f64; POINTS], c: usize) {
        for sign in [1.0, -1.0] {
            let f = self.points[c].map(|value| sign * value);
            let record = if sign > 0.0 { self.running[c].max } else { -self.running[c].min };
            let mut best = f.iter().copied().fold(record, f64::max);
            for i in 1..POINTS - 1 {
                let (x, g) = ([times[i - 1], times[i], times[i + 1]], [f[i - 1], f[i], f[i + 1]]);
                let (top, at) = (peak(x, g), vertex(x, g));
                // A hump between the points, or just inside an end of the step.
                let hump = g[1] >= g[0] && g[1] >= g[2];
                let at_end =
                    (i == 1 && at > x[0] && at < x[1]) || (i == POINTS - 2 && at > x[1] && at < x[2]);
                if (hump || at_end) && top > best {
                    best = best.max(self.refine(step, c, sign, x, g));
                }
            }
            if sign > 0.0 { self.running[c].max = best } else { self.running[c].min = -best }
        }
    }
}

/// Where the parabola through three points has its extremum.
fn vertex(x: [f64; 3], f: [f64; 3]) -> f64 {
    let (a, b) = ((x[1] - x[0]) * (f[1] - f[2]), (x[1] - x[2]) * (f[1] - f[0]));
    x[1] - 0.5 * ((x[1] - x[0]) * a - (x[1] - x[2]) * b) / (a - b)
}

/// The value of that parabola at its extremum, for a hump; negative infinity for a bowl.
fn peak(x: [f64; 3], f: [f64; 3]) -> f64 {
    let s01 = (f[1] - f[0]) / (x[1] - x[0]);
    let s12 = (f[2] - f[1]) / (x[2] - x[1]);
    let curve = (s12 - s01) / (x[2] - x[0]);
    if curve >= 0.0 {
        return f64::NEG_INFINITY;
    }
    let slope = s01 + curve * (x[1] - x[0]);
    f[1] - slope * slope / (4.0 * curve)
}

impl<M: Model + ?Sized> Observer for Statistics<'_, M> {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        let (t0, t1) = (step.t0(), step.t1());
        let (middle, half) = (0.5 * (t0 + t1), 0.5 * (t1 - t0));
        let mut times = [t0; POINTS];
        times[POINTS - 1] = t1;
        for (time, [x, _]) in times[1..].iter_mut().zip(FIVE) {
            *time = middle + half * x;
        }
        for (p, &t) in times.iter().enumerate() {
            self.look(step, t);
            let values = self.probe.values();
            for (c, &index) in self.chosen.iter().enumerate() {
                self.points[c][p] = values[index];
            }
        }
        for c in 0..self.chosen.len() {
            let (points, running) = (self.points[c], &mut self.running[c]);
            if running.origin.is_nan() {
                running.origin = points[0];
            }
            for (value, [_, w]) in points[1..].iter().zip(FIVE) {
                running.sum += half * w * value;
                running.square += half * w * value * value;
                let off = value - running.origin;
                running.off += half * w * off;
                running.off_square += half * w * off * off;
            }
            self.extremes(step, &times, c);
        }
        self.duration += t1 - t0;
        ControlFlow::Continue(())
    }
}
