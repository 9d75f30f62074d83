//! Poincaré sections: states at which a channel crosses a level.

use crate::error::{ParameterError, check};
use crate::model::{Model, State};
use crate::numeric::gauss::FIVE;
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

/// Observer that keeps the states at which a channel crosses a level. Crossings are located on the dense
/// output.
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
pub struct Section<'m> {
    probe: Probe<'m>,
    channel: usize,
    level: f64,
    direction: Direction,
    states: Vec<State>,
    y: Vec<f64>,
    /// End time of the last step, and channel less level there.
    last: Option<(f64, f64)>,
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
}

impl Observer for Section<'_> {
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
            // Each part is sampled at seven points, so that two crossings inside it are found.
            let (t0, t1) = step.part(part);
            let inside = FIVE.map(|[x, _]| 0.5 * (t0 + t1) + 0.5 * (t1 - t0) * x);
            for to in inside.into_iter().chain([t1]) {
                let b = self.height(step, to);
                if self.wanted(a, b) {
                    let (mut lo, mut hi) = (from, to);
                    loop {
                        let middle = 0.5 * (lo + hi);
                        if middle <= lo || middle >= hi {
                            break;
                        }
                        if (self.height(step, middle) < 0.0) == (a < 0.0) { lo = middle } else { hi = middle }
                    }
                    self.height(step, hi);
                    self.keep(hi);
                }
                (from, a) = (to, b);
            }
        }
        self.last = Some((from, a));
        ControlFlow::Continue(())
    }
}
