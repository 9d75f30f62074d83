//! Poincaré sections: states at which a channel crosses a level.

use crate::analysis::seven_points::{CELLS, NODES, OFF, POINTS, on_grid, sixth};
use crate::error::{ParameterError, check};
use crate::model::{Model, State};
use crate::numeric::spread::GOLDEN;
use crate::ode::probe::Probe;
use crate::ode::{Observer, Step};
use std::fmt;
use std::ops::ControlFlow;

/// The direction in which a channel crosses the level of a [`Section`].
///
/// ```
/// use gear_dynamics::{analysis::{Direction, Section}, Dop853, Integrator, State, model::from_fn};
/// let spring = from_fn(1, |_, q, _, a| a[0] = -q[0])?;
/// let count = |direction| -> Result<usize, Box<dyn std::error::Error>> {
///     let mut section = Section::new(&spring, "q0", 0.0, direction)?;
///     Dop853::new().run(&spring, &State::new(0.0, &[1.0], &[0.0]), 10.0, &mut section)?;
///     Ok(section.states().len())
/// };
/// // cos t is zero at π/2, 3π/2 and 5π/2 in 0 .. 10.
/// assert_eq!(count(Direction::Rising)?, 1);
/// assert_eq!(count(Direction::Falling)?, 2);
/// assert_eq!(count(Direction::Both)?, 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From below the level to above it.
    Rising,
    /// From above the level to below it.
    Falling,
    /// Both directions.
    Both,
}

/// How often a part of a step is halved until the polynomial through seven points resolves the channel.
const HALVINGS: usize = 6;

/// Largest sixth divided difference over a stretch, as a share of the range of the channel in it: a sine
/// turns by at most some 3 rad in a stretch.
const SWING: f64 = 0.02;

/// Points of the grid, far from the seven points, at which the polynomial is compared with the channel.
const CONTROLS: [usize; 2] = [6, 11];

/// Number of golden sections towards the level where the channel turns back near it.
const SECTIONS: usize = 40;

/// Observer that keeps the states at which a channel crosses a level. Crossings are located on the dense
/// output, also two of them between which the channel comes to the level and turns back. A stretch in which
/// the channel swings is divided, down to 1/64 of what resolves the motion.
///
/// A channel may jump over the level at the end of a step, where a drive jumps or a contact reaches an edge.
/// The state at this instant is kept as well. The same holds between two runs if the second starts at the end
/// time of the first.
///
/// ```
/// use gear_dynamics::{analysis::{Direction, Section}, Dop853, Integrator, State, model::from_fn};
/// let spring = from_fn(1, |_, q, _, a| a[0] = -q[0])?;
/// let mut section = Section::new(&spring, "q0", 0.0, Direction::Rising)?;
/// Dop853::new().run(&spring, &State::new(0.0, &[1.0], &[0.0]), 10.0, &mut section)?;
/// assert_eq!(section.states().len(), 1);
/// assert!((section.states()[0].t - 1.5 * std::f64::consts::PI).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use = "an observer records during a run"]
pub struct Section<'m> {
    probe: Probe<'m>,
    channel: usize,
    level: f64,
    direction: Direction,
    states: Vec<State>,
    y: Vec<f64>,
    /// End time of the last step, and channel less level there.
    last: Option<(f64, f64)>,
    /// Scratch: the points of a stretch between which crossings are looked for.
    places: Vec<(f64, f64)>,
}

impl fmt::Debug for Section<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Section")
            .field("channel", &self.channel)
            .field("level", &self.level)
            .field("states", &self.states)
            .finish_non_exhaustive()
    }
}

impl<'m> Section<'m> {
    /// Observes where `channel` (see [`Probe`]) crosses `level`, which has the unit of the channel.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`] for a channel that the model does not have; a level beyond ±1e50.
    pub fn new(
        model: &'m dyn Model,
        channel: &str,
        level: f64,
        direction: Direction,
    ) -> Result<Self, ParameterError> {
        let probe = Probe::new(model);
        let channel = probe.index(channel)?;
        check::quantity("level", level)?;
        Ok(Section {
            probe,
            channel,
            level,
            direction,
            states: Vec::new(),
            y: vec![0.0; 2 * model.dof()],
            last: None,
            places: Vec::new(),
        })
    }

    /// The states at the crossings, in order of time.
    pub fn states(&self) -> &[State] {
        &self.states
    }

    /// Channel less level at `t` of a step.
    fn height(&mut self, step: &mut Step<'_>, t: f64) -> f64 {
        self.probe.read_step(step, t, &mut self.y)[self.channel] - self.level
    }

    /// Whether a change between two heights crosses the level in the chosen direction.
    fn wanted(&self, from: f64, to: f64) -> bool {
        let (rising, falling) = (from < 0.0 && to >= 0.0, from > 0.0 && to <= 0.0);
        match self.direction {
            Direction::Rising => rising,
            Direction::Falling => falling,
            Direction::Both => rising || falling,
        }
    }

    /// Keeps the state of the last evaluation.
    fn keep(&mut self, t: f64) {
        let (q, v) = self.y.split_at(self.y.len() / 2);
        self.states.push(State::new(t, q, v));
    }

    /// Keeps the crossings of a stretch from the last point to `end`. Returns the point at its end. The
    /// stretch is halved while the polynomial through seven of its points does not resolve the channel.
    fn scan(&mut self, step: &mut Step<'_>, from: (f64, f64), end: f64, halvings: usize) -> (f64, f64) {
        let (middle, half) = (0.5 * (from.0 + end), 0.5 * (end - from.0));
        let mut points = [from; POINTS];
        for (point, x) in points.iter_mut().zip(NODES).skip(1) {
            point.0 = if x < 1.0 { middle + half * x } else { end };
            point.1 = self.height(step, point.0);
        }
        let values = points.map(|(_, height)| height);
        let [low, high] = [f64::min, f64::max].map(|of: fn(f64, f64) -> f64| values.into_iter().reduce(of));
        let range = high.unwrap_or_default() - low.unwrap_or_default();
        let grid = on_grid(&values);
        let time =
            |k: usize| if k == CELLS { end } else { from.0 + (end - from.0) * (k as f64 / CELLS as f64) };
        // Of a channel that swings many times the difference may be small by chance.
        let mut is_off = |k: usize| (self.height(step, time(k)) - grid[k]).abs() > OFF * range;
        let swings = sixth(values).abs() > SWING * range || CONTROLS.into_iter().any(&mut is_off);
        if swings && halvings > 0 && self.probe.resolves(step, middle, (self.channel, range), &mut self.y) {
            let middle = self.scan(step, from, middle, halvings - 1);
            return self.scan(step, middle, end, halvings - 1);
        }
        // Between two points the channel may come to the level and turn back. A polynomial that does not
        // resolve the channel does not show where.
        let mut all = std::mem::take(&mut self.places);
        all.clear();
        all.extend(points);
        for k in 0..=CELLS {
            let (before, after) = (grid[k.saturating_sub(1)], grid[(k + 1).min(CELLS)]);
            let sign = grid[k].signum();
            if grid[k] * before < 0.0 || grid[k] * after < 0.0 {
                let place = time(k);
                all.push((place, self.height(step, place)));
            }
            let turns = sign * grid[k] <= sign * before && sign * grid[k] <= sign * after;
            if !swings && turns && grid[k].abs() < OFF * range {
                let bracket = [time(k.saturating_sub(1)), time((k + 1).min(CELLS))];
                all.extend(self.beyond(step, sign, bracket));
            }
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        for two in all.windows(2) {
            self.cross(step, two[0], two[1]);
        }
        self.places = all;
        points[POINTS - 1]
    }

    /// A point in the bracket at which the height does not have the sign `sign`, by golden sections.
    fn beyond(&mut self, step: &mut Step<'_>, sign: f64, mut bracket: [f64; 2]) -> Option<(f64, f64)> {
        let place = |[a, b]: [f64; 2], share: f64| a + share * (b - a);
        let mut at = |t: f64| (t, self.height(step, t));
        let (mut left, mut right) = (at(place(bracket, 1.0 - GOLDEN)), at(place(bracket, GOLDEN)));
        for _ in 0..SECTIONS {
            if let Some(found) = [left, right].into_iter().find(|(_, height)| sign * height <= 0.0) {
                return Some(found);
            }
            if sign * left.1 <= sign * right.1 {
                (bracket[1], right) = (right.0, left);
                left = at(place(bracket, 1.0 - GOLDEN));
            } else {
                (bracket[0], left) = (left.0, right);
                right = at(place(bracket, GOLDEN));
            }
        }
        None
    }

    /// Locates the crossing between two points, if there is a wanted one.
    fn cross(&mut self, step: &mut Step<'_>, (from, a): (f64, f64), (to, b): (f64, f64)) {
        if !self.wanted(a, b) {
            return;
        }
        let (mut low, mut high) = (from, to);
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if (self.height(step, middle) < 0.0) == (a < 0.0) { low = middle } else { high = middle }
        }
        self.height(step, high);
        self.keep(high);
    }
}

impl Observer for Section<'_> {
    fn fits(&self, dof: usize, contacts: usize) -> Result<(), ParameterError> {
        self.probe.fits(dof, contacts)
    }
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        let t0 = step.t0();
        let (mut from, mut a) = (t0, self.height(step, t0));
        if let Some((t, before)) = self.last
            && t == t0
            && self.wanted(before, a)
        {
            self.keep(t0);
        }
        for part in 0..step.parts() {
            let (_, end) = step.part(part);
            (from, a) = self.scan(step, (from, a), end, HALVINGS);
        }
        self.last = Some((from, a));
        ControlFlow::Continue(())
    }
}
