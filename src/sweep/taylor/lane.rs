//! The motion that occupies a lane.

use crate::contact::Piece;
use crate::model::expansion::expand::Expand;
use crate::model::{Model, State};
use crate::ode::edges::exit::{Elapsed, Found};
use crate::ode::step::StepView;
use crate::ode::stepping::control::RESOLUTION;
use crate::ode::taylor::course::Course;
use crate::ode::taylor::distances::first_exit;
use crate::ode::taylor::pace::COLLAPSE;
use crate::ode::{IntegrateError, Step};
use crate::series::Series;
use crate::sweep::taylor::view::LaneView;

/// A motion to run, whose model stays where it is.
pub(crate) struct Motion<'m> {
    pub(crate) model: &'m (dyn Model + 'm),
    pub(crate) expanded: &'m dyn Expand,
    /// Speed φ' of the angle.
    pub(crate) speed: f64,
    pub(crate) start: State,
    /// The time to which it runs first.
    pub(crate) until: f64,
}

/// A motion in progress.
pub(crate) struct Lane<'m> {
    pub(super) course: Course<'m>,
    expanded: &'m dyn Expand,
    pub(super) speed: f64,
    /// The drives at the start: of them, the constants are read.
    pub(super) drives: Vec<f64>,
    /// The drives as series, where the waves are no Fourier series.
    series: Vec<Series>,
    /// The time after the start of the step up to which they are valid.
    valid: f64,
    /// The lengths that the tolerances allowed: of the last step, and the longest so far.
    pub(super) last: f64,
    longest: f64,
    /// Limit of the next step alone, after an impact.
    limit: f64,
    aim: [f64; 2],
    found: Found<Elapsed>,
    /// Attempts to make a step since the task of the lane last set them to 0.
    pub(super) attempts: usize,
    /// Whether pieces may have changed since the last step.
    pub(super) changed: bool,
}

impl<'m> Lane<'m> {
    /// # Errors
    /// Those of [`Course::begin`].
    pub(super) fn new(motion: &Motion<'m>) -> Result<Self, IntegrateError> {
        let &Motion { model, expanded, speed, ref start, until } = motion;
        let course = Course::begin(model, start, until)?;
        Ok(Lane {
            expanded,
            speed,
            drives: course.e.u_stage.clone(),
            series: vec![Series::from(0.0); model.drives()],
            valid: f64::INFINITY,
            course,
            last: 0.0,
            longest: 0.0,
            limit: f64::INFINITY,
            aim: [0.0; 2],
            found: Found::Nothing,
            attempts: 0,
            changed: false,
        })
    }

    /// Goes back to a state before.
    ///
    /// # Errors
    /// Those of [`Course::begin`].
    pub(super) fn go_back(&mut self, to: &State, until: f64) -> Result<(), IntegrateError> {
        self.course = Course::begin(self.course.e.model, to, until)?;
        (self.last, self.limit, self.changed) = (0.0, f64::INFINITY, true);
        Ok(())
    }

    /// The drives after the start of the step as series.
    ///
    /// # Errors
    /// [`IntegrateError::DriveWithoutSeries`].
    pub(super) fn drive_series(
        &mut self,
        coefficients: usize,
        needed: &[(usize, usize)],
    ) -> Result<&[Series], IntegrateError> {
        self.expanded.drive_series(self.course.e.t, coefficients, &mut self.series);
        self.valid = f64::INFINITY;
        for &(drive, _) in needed {
            let series = &self.series[drive];
            if let Some(what) = series.refusal() {
                return Err(IntegrateError::DriveWithoutSeries { drive, what });
            }
            self.valid = self.valid.min(series.until());
        }
        Ok(&self.series)
    }

    /// Aims at the end of a step for which the tolerances allow the length `full`. Returns its length.
    ///
    /// # Errors
    /// A step below the resolution of the time.
    pub(super) fn aim(
        &mut self,
        full: f64,
        longest: f64,
        view: &LaneView<'_>,
    ) -> Result<f64, IntegrateError> {
        if full.is_nan() || full <= RESOLUTION * self.course.e.t.abs() {
            return Err(self.shrunk(full, view));
        }
        let valid = self.valid.max(self.course.shortest());
        self.aim = self.course.aim(full.min(self.limit).min(longest).min(valid))?;
        self.course.passage.crossings.clear();
        Ok(self.aim[1])
    }

    /// The length of the step to the first exit of a contact, or to the aim; `None` if a contact changes its
    /// piece at once.
    ///
    /// # Errors
    /// Those of [`first_exit`] and [`Course::meet`].
    pub(super) fn meet(
        &mut self,
        view: &LaneView<'_>,
        moves: impl Fn(usize) -> [f64; 2],
    ) -> Result<Option<f64>, IntegrateError> {
        let Course { e, passage } = &mut self.course;
        self.found = first_exit(view, e, &passage.locator, moves, self.aim[1])?;
        self.course.meet(self.found, self.aim)
    }

    /// Ends the step at the state that `course.e.y1` contains. `full`: the length that the tolerances
    /// allowed. Returns whether it ends on a drive edge.
    ///
    /// # Errors
    /// A state that is not finite; those of [`Course::cross`].
    pub(super) fn end_step(&mut self, full: f64, view: &LaneView<'_>) -> Result<bool, IntegrateError> {
        if !self.course.e.finite() {
            let collapsed = full < COLLAPSE * self.longest;
            return Err(if collapsed { self.shrunk(self.course.e.h(), view) } else { self.not_finite() });
        }
        let at_edge = self.course.cross(self.found)?;
        (self.last, self.limit) = (full, f64::INFINITY);
        if full.is_finite() {
            self.longest = self.longest.max(full);
        }
        Ok(at_edge)
    }

    /// Shows the step that has ended.
    pub(super) fn show<T>(
        &self,
        view: &LaneView<'_>,
        at_edge: bool,
        f: impl FnOnce(&mut Step<'_>) -> T,
    ) -> T {
        let Course { e, passage } = &self.course;
        let ends = [e.y.slice(), e.y1.slice()];
        let mut step = LaneStep { view, times: [e.t, e.t1], ends, pieces: &e.pieces };
        f(&mut Step::new(&mut step, at_edge, &passage.crossings))
    }

    /// Prepares the next step.
    ///
    /// # Errors
    /// Those of [`Course::pass`].
    pub(super) fn pass(&mut self, at_edge: bool) -> Result<(), IntegrateError> {
        let (longest, changed) = self.course.pass(at_edge)?;
        (self.limit, self.changed) = (longest, changed);
        Ok(())
    }

    /// The error for a step below the resolution of the time.
    fn shrunk(&self, h: f64, view: &LaneView<'_>) -> IntegrateError {
        let t = self.course.e.t;
        match view.singular {
            Some(what) => IntegrateError::NoSeriesAt { t, what },
            None if h.is_nan() => self.not_finite(),
            None => IntegrateError::StepUnderflow { t, h },
        }
    }

    pub(super) fn not_finite(&self) -> IntegrateError {
        let e = &self.course.e;
        IntegrateError::NotFinite { t: e.t, component: e.not_finite().unwrap_or(0) }
    }
}

/// A step of a lane, as observers receive it.
struct LaneStep<'s> {
    view: &'s LaneView<'s>,
    times: [f64; 2],
    ends: [&'s [f64]; 2],
    pieces: &'s [Piece],
}

impl StepView for LaneStep<'_> {
    fn times(&self) -> (f64, f64) {
        (self.times[0], self.times[1])
    }
    fn start(&self) -> &[f64] {
        self.ends[0]
    }
    fn end(&self) -> &[f64] {
        self.ends[1]
    }
    fn pieces(&self) -> Option<&[Piece]> {
        Some(self.pieces)
    }
    fn at(&mut self, t: f64, y: &mut [f64]) {
        self.view.at(t - self.times[0], y);
    }
}
