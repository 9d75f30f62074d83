//! The motion that occupies a lane.

use crate::contact::Piece;
use crate::model::expansion::expand::Expand;
use crate::model::{Model, State};
use crate::ode::step::StepView;
use crate::ode::taylor::course::{Course, valid_until};
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
    pub(super) expanded: &'m dyn Expand,
    pub(super) speed: f64,
    /// The drives at the start: of them, the constants are read.
    pub(super) drives: Vec<f64>,
    /// The drives as series, where the waves are no Fourier series.
    pub(super) series: Vec<Series>,
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
        let mut course = Course::begin(model, start, until)?;
        course.passage.sliding.prepare(&course.e);
        Ok(Lane {
            expanded,
            speed,
            drives: course.e.u_stage.clone(),
            series: vec![Series::from(0.0); model.drives()],
            course,
            attempts: 0,
            changed: false,
        })
    }

    /// Goes back to a state before.
    ///
    /// # Errors
    /// Those of [`Course::go_back`].
    pub(super) fn go_back(&mut self, to: &State, until: f64) -> Result<(), IntegrateError> {
        self.course.go_back(to, until)?;
        self.changed = true;
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
        self.course.valid = valid_until(&self.series, needed)?;
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
        if !self.course.advances(full) {
            return Err(self.shrunk(full, view));
        }
        self.course.aim(full, longest)
    }

    /// Ends the step at the state that `course.e.y1` contains. `full`: the length that the tolerances
    /// allowed. Returns whether it ends on a drive edge.
    ///
    /// # Errors
    /// A state that is not finite; those of [`Course::cross`].
    pub(super) fn end_step(&mut self, full: f64, view: &LaneView<'_>) -> Result<bool, IntegrateError> {
        if !self.course.e.finite() {
            let shrunk = self.course.has_shrunk(full);
            return Err(if shrunk { self.shrunk(self.course.e.h(), view) } else { self.not_finite() });
        }
        self.course.cross(full)
    }

    /// Ends the step already after the time `h`. Returns its length.
    ///
    /// # Errors
    /// A step below the resolution of the time.
    pub(super) fn shorten(&mut self, h: f64, view: &LaneView<'_>) -> Result<f64, IntegrateError> {
        if !self.course.advances(h) {
            return Err(self.shrunk(h, view));
        }
        self.course.shorten(h);
        Ok(self.course.e.h())
    }

    /// Shows the step that has ended.
    pub(super) fn show<T>(
        &self,
        view: &LaneView<'_>,
        at_edge: bool,
        f: impl FnOnce(&mut Step<'_>) -> T,
    ) -> T {
        let Course { e, passage, .. } = &self.course;
        let ends = [e.y.slice(), e.y1.slice()];
        let mut step = LaneStep { view, times: [e.t, e.t1], ends, pieces: &e.pieces };
        f(&mut Step::new(&mut step, at_edge, &passage.crossings))
    }

    /// Prepares the next step.
    ///
    /// # Errors
    /// Those of [`Course::pass`].
    pub(super) fn pass(&mut self, at_edge: bool) -> Result<(), IntegrateError> {
        self.changed = self.course.pass(at_edge)?;
        Ok(())
    }

    /// The error for a step below the resolution of the time.
    fn shrunk(&self, h: f64, view: &LaneView<'_>) -> IntegrateError {
        let e = &self.course.e;
        match view.singular {
            Some(what) => IntegrateError::NoSeriesAt { t: e.t, what },
            None if h.is_nan() => e.diverged(),
            None => e.underflow(h),
        }
    }

    pub(super) fn not_finite(&self) -> IntegrateError {
        self.course.e.diverged()
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
