//! The main loop of the Taylor integrator.

use crate::model::expansion::expand::Expand;
use crate::model::structure::slopes::accelerate;
use crate::model::{Model, State};
use crate::ode::integrate_error::IntegrateError;
use crate::ode::integrator::{Integrator, Runs};
use crate::ode::outcome::Finish;
use crate::ode::step::{Observer, Step};
use crate::ode::stepping::control::RESOLUTION;
use crate::ode::taylor::course::{COLLAPSE, Course, are_steep, valid_until};
use crate::ode::taylor::defect::{Checked, Defect};
use crate::ode::taylor::expansion::coefficients::Coefficients;
use crate::ode::taylor::expansion::degrees::{may_have_gaps, may_hide};
use crate::ode::taylor::pace::SeriesPace;
use crate::ode::taylor::polynomials::Polynomials;
use crate::ode::taylor::settings::Taylor;
use crate::series::Series;
use crate::tape::operations::Tape;

/// The tape of a model, ready to run.
pub(crate) struct Prepared {
    c: Coefficients,
    series: Vec<Series>,
    tape: Tape,
    /// Drives that vary between drive edges.
    moving: Vec<bool>,
    /// Drives that the algebra reads.
    needed: Vec<bool>,
    /// Whether the distances of each contact read velocities.
    by_velocities: Vec<bool>,
    /// Whether the tape has a function that a step may pass unseen, whether its series may have gaps, and the
    /// check of steps, once made.
    hides: bool,
    has_gaps: bool,
    defect: Option<Defect>,
}

/// Whether each drive varies between drive edges.
fn moving(series: &[Series]) -> impl Iterator<Item = bool> + '_ {
    series.iter().map(|series| series.coefficients().len() > 1)
}

/// Number of coefficients of a drive: two suffice to see whether it varies.
const DRIVE_COEFFICIENTS: usize = 2;

impl Prepared {
    /// # Errors
    /// [`IntegrateError::NoSeries`], [`IntegrateError::DriveWithoutSeries`].
    pub(crate) fn new(model: &dyn Model) -> Result<Self, IntegrateError> {
        Prepared::with(model, &|_| false, |tape| tape)
    }

    /// The tape that `change` makes of the one of the model. `moving`: drives that are slots of the tape
    /// although they are constants of the model.
    ///
    /// # Errors
    /// Those of [`new`](Prepared::new).
    pub(crate) fn with(
        model: &dyn Model,
        moving: &dyn Fn(usize) -> bool,
        change: impl FnOnce(Tape) -> Tape,
    ) -> Result<Self, IntegrateError> {
        let expanded = expanded(model)?;
        let recorded = expanded.record(moving);
        if let Some((output, what)) = recorded.0.kink() {
            return Err(IntegrateError::NoSeries { place: output.to_string(), what });
        }
        if model.contacts() > 0 && !model.offers().pieces {
            return Err(no_series("a model without `accel_on_pieces`"));
        }
        let Tape { dof, drives, distances, .. } = &recorded.0;
        let sizes = [model.dof(), model.drives(), model.contacts()];
        if [*dof, *drives, distances.len()] != sizes || recorded.0.contacts_read() > sizes[2] {
            return Err(no_series("a recording with another number of coordinates, drives or contacts"));
        }
        let mut series = vec![Series::from(0.0); model.drives()];
        expanded.drive_series(0.0, DRIVE_COEFFICIENTS, &mut series);
        let (tape, moving) = (change(recorded.0), self::moving(&series).collect::<Vec<bool>>());
        let needed = tape.needed()[2 * tape.dof..tape.inputs()].to_vec();
        let c = Coefficients::new(&tape, |d| !moving[d]);
        valid_until(&series, &c.plan.drives)?;
        let hides = may_hide(&tape);
        let by_velocities = tape.contacts_of_velocities();
        let has_gaps = may_have_gaps(&tape);
        Ok(Prepared { c, series, tape, moving, needed, by_velocities, hides, has_gaps, defect: None })
    }

    /// Plans anew because a drive varies that did not vary before.
    fn plan_anew(&mut self) {
        self.moving.iter_mut().zip(moving(&self.series)).for_each(|(all, now)| *all |= now);
        self.c = Coefficients::new(&self.tape, |d| !self.moving[d]);
    }

    /// Integrates `model`, which must be the one of [`new`](Prepared::new), from `start` to `t_end`.
    pub(crate) fn run(
        &mut self,
        settings: &Taylor,
        model: &dyn Model,
        start: &State,
        t_end: f64,
        observer: &mut dyn Observer,
    ) -> Result<Finish, IntegrateError> {
        start.check(model.dof())?;
        observer.fits(model.dof(), model.contacts())?;
        let mut run = TaylorRun::new(self, settings, model, start, t_end)?;
        run.course.passage.fits(model, start.t, settings.limits.max_steps)?;
        for _ in 0..settings.limits.max_steps {
            run.expand()?;
            match run.make_step()? {
                Made::Again => {}
                Made::Step { at_edge, full } => {
                    let stopped = run.report(at_edge, full, observer);
                    let Course { e, passage, .. } = &mut run.course;
                    if stopped || e.t1 >= t_end {
                        let mut stats = passage.stats;
                        stats.evaluations += e.evaluations();
                        return Ok(Finish { state: passage.finish(e)?, stopped, stats });
                    }
                    run.pass(at_edge)?;
                }
            }
        }
        Err(IntegrateError::TooManySteps { t: run.course.e.t, limit: settings.limits.max_steps })
    }
}

impl Integrator for Taylor {
    fn run(
        &self,
        model: &dyn Model,
        start: &State,
        t_end: f64,
        observer: &mut dyn Observer,
    ) -> Result<Finish, IntegrateError> {
        self.check_rtol()?;
        Prepared::new(model)?.run(self, model, start, t_end, observer)
    }

    fn runs<'r>(&'r self, model: &'r dyn Model) -> Box<Runs<'r>> {
        let mut kept = None;
        Box::new(move |start, t_end, observer| {
            self.check_rtol()?;
            let prepared = match &mut kept {
                Some(prepared) => prepared,
                none => none.insert(Prepared::new(model)?),
            };
            prepared.run(self, model, start, t_end, observer)
        })
    }
}

/// The model as one that can be expanded.
fn expanded(model: &dyn Model) -> Result<&dyn Expand, IntegrateError> {
    let what = "a model that cannot be expanded (`Offers::expansion`), for example one in plain numbers";
    model.offers().expansion.ok_or_else(|| no_series(what))
}

fn no_series(what: &'static str) -> IntegrateError {
    IntegrateError::NoSeries { place: "the model".into(), what }
}

/// Safety factor on the steps while a root or a power is evaluated `[1]`.
const POWERS: f64 = 0.7;

/// Shortest first step away from a root or a power of 0, in units of the resolution of the time.
const ROUNDED: f64 = 16.0;

/// What became of an attempt.
enum Made {
    /// A contact changed its piece at the start of the step.
    Again,
    Step {
        /// Whether it ends on a drive edge.
        at_edge: bool,
        /// Length of the step that the tolerances allow.
        full: f64,
    },
}

/// Variables of one run.
struct TaylorRun<'r> {
    prepared: &'r mut Prepared,
    expanded: &'r dyn Expand,
    course: Course<'r>,
    pace: SeriesPace,
    degree: usize,
    /// Longest step that the settings allow.
    longest: f64,
    rtol: f64,
    /// Absolute tolerance of each coordinate and velocity.
    atol: Vec<f64>,
    /// Scratch: two accelerations.
    accelerations: [Vec<f64>; 2],
}

impl<'r> TaylorRun<'r> {
    fn new(
        prepared: &'r mut Prepared,
        settings: &Taylor,
        model: &'r dyn Model,
        start: &State,
        t_end: f64,
    ) -> Result<Self, IntegrateError> {
        let n = 2 * model.dof();
        let (degree, atol) = settings.check(n)?;
        let mut course = Course::begin(model, start, t_end)?;
        course.passage.sliding.know(&prepared.by_velocities);
        course.passage.sliding.prepare(&course.e);
        prepared.c.set_pieces(&course.e.pieces);
        let expanded = expanded(model)?;
        expanded.drive_series(start.t, degree + 1, &mut prepared.series);
        Ok(TaylorRun {
            pace: SeriesPace::new(settings.tolerances.rtol, &atol, &prepared.c.plan),
            expanded,
            prepared,
            course,
            degree,
            rtol: settings.tolerances.rtol,
            atol,
            longest: settings.tolerances.max,
            accelerations: [vec![0.0; n / 2], vec![0.0; n / 2]],
        })
    }

    /// Expands drives and motion at the start of the step.
    fn expand(&mut self) -> Result<(), IntegrateError> {
        let Prepared { series, needed, .. } = &mut *self.prepared;
        self.expanded.redrive_series(self.course.e.t, self.degree + 1, needed, series);
        let Prepared { c, series, moving, .. } = &*self.prepared;
        self.course.valid = valid_until(series, &c.plan.drives)?;
        let woken = |&(drive, _): &(usize, usize)| series[drive].coefficients().len() > 1 && !moving[drive];
        if c.plan.drives.iter().any(woken) {
            self.prepared.plan_anew();
            self.prepared.c.set_pieces(&self.course.e.pieces);
        }
        let Prepared { c, series, .. } = &mut *self.prepared;
        c.expand(self.course.e.y.slice(), series, self.degree, false);
        self.course.passage.stats.evaluations += self.degree as u64;
        Ok(())
    }

    /// Makes the step: its length, its end and the crossings there.
    fn make_step(&mut self) -> Result<Made, IntegrateError> {
        let full = self.length()?;
        let aim = self.course.aim(full, self.longest)?;
        let c = &self.prepared.c;
        c.ranges(aim, &mut self.pace.ranges);
        let ranges = self.pace.ranges.as_flattened();
        let Some(mut h) = self.course.meet(c, |column| [-ranges[column], ranges[column]])? else {
            self.prepared.c.set_pieces(&self.course.e.pieces);
            return Ok(Made::Again);
        };
        let mut full = full;
        let solved = self.solved_until(h, full);
        if solved < h {
            if !self.course.advances(solved) {
                return Err(self.shrunk(solved));
            }
            self.course.shorten(solved);
            (h, full) = (self.course.e.h(), solved);
        }
        self.prepared.c.at(h, self.course.e.y1.slice_mut());
        if !self.course.e.finite() {
            return Err(if self.course.has_shrunk(full) { self.shrunk(h) } else { self.not_finite() });
        }
        Ok(Made::Step { at_edge: self.course.cross(full)?, full })
    }

    /// The time in the step of length `h` up to which its polynomials solve the equation. `full`: the length
    /// that the tolerances allow.
    fn solved_until(&mut self, h: f64, full: f64) -> f64 {
        let Prepared { c, series, tape, hides, has_gaps, defect, .. } = &mut *self.prepared;
        let hides_a_sum = c.hides_a_sum();
        let is_steep = *hides || hides_a_sum || are_steep(series, &c.plan.drives);
        if c.frozen || !(is_steep || *has_gaps && self.course.may_miss(full)) {
            return h;
        }
        let defect = defect.get_or_insert_with(|| Defect::new(tape, *hides));
        let e = &self.course.e;
        let (rtol, atol) = (self.rtol, &self.atol[..]);
        let step = Checked { t: e.t, h, pieces: &e.pieces, rtol, atol, is_steep, hides_a_sum };
        let solved = defect.length(&step, self.expanded, &*c);
        self.course.passage.stats.evaluations += std::mem::take(&mut defect.evaluations);
        solved
    }

    /// The length of the step that the tolerances allow; infinite if the series ends.
    fn length(&mut self) -> Result<f64, IntegrateError> {
        let (room, last) = (self.course.passage.stop - self.course.e.t, self.course.last);
        let c = &mut self.prepared.c;
        let h = self.pace.length(c, last, room);
        let powers = c.plan.functions().any(|function| function.is_power());
        // A step much shorter than the last one: the motion has no series here.
        let collapsed = last.is_finite() && h < COLLAPSE * last;
        if self.course.advances(h) && !collapsed {
            // Beyond the distance of a root or power of 0 the terms after the last one do not decay.
            return Ok(if powers { POWERS * h } else { h });
        }
        if !powers {
            return if self.course.advances(h) { Ok(h) } else { Err(self.shrunk(h)) };
        }
        // At a root or a power of 0 the motion is finite but has no series. A short step with the power held
        // at its value leaves the point.
        c.expand(self.course.e.y.slice(), &self.prepared.series, self.degree, true);
        let first = 0.01 * if last > 0.0 && last.is_finite() { last } else { room };
        // Steps towards the point shrink geometrically: a share of the last one may not advance the time.
        let first = first.max(ROUNDED * RESOLUTION * self.course.e.t.abs());
        let mut h = self.pace.length(c, last, room).min(first);
        let n = self.course.e.model.dof();
        while self.course.advances(h) && h > 0.0 {
            self.course.e.aim(self.course.e.t + h);
            self.course.e.drive_end();
            c.at(h, self.course.e.y1.slice_mut());
            let [held, real] = &mut self.accelerations;
            c.acceleration(h, held);
            let (q, v) = self.course.e.y1.slice().split_at(n);
            accelerate(
                self.course.e.model,
                Some(&self.course.e.pieces),
                self.course.e.nodes.end(),
                q,
                v,
                real,
            );
            if self.pace.tolerates(h, held, real) {
                return Ok(h);
            }
            h *= 0.25;
        }
        Err(self.shrunk(h))
    }

    /// The error for a step below the resolution of the time.
    fn shrunk(&self, h: f64) -> IntegrateError {
        let t = self.course.e.t;
        let c = &self.prepared.c;
        let finite = (0..=c.degree).all(|n| c.q(n).iter().chain(c.v(n)).all(|x| x.is_finite()));
        match c.plan.functions().find(|function| function.is_singular_at_zero()) {
            Some(function) => IntegrateError::NoSeriesAt { t, what: function.name() },
            None if !finite || h.is_nan() => self.not_finite(),
            None => self.course.e.underflow(h),
        }
    }

    fn not_finite(&self) -> IntegrateError {
        let (c, n) = (&self.prepared.c, self.course.e.model.dof());
        if let Some(acceleration) = self.course.e.nan_acceleration() {
            return IntegrateError::NotANumber { t: self.course.e.t, acceleration };
        }
        let component = c.q(1).iter().chain(c.v(1)).position(|x| !x.is_finite());
        let component = component.or_else(|| self.course.e.not_finite());
        IntegrateError::NotFinite { t: self.course.e.t, component: component.unwrap_or(0).min(2 * n - 1) }
    }

    /// Reports the step to the observer. Returns whether it stops the run.
    fn report(&mut self, at_edge: bool, full: f64, observer: &mut dyn Observer) -> bool {
        let (c, e) = (&self.prepared.c, &self.course.e);
        let mut view = Polynomials {
            c,
            times: (e.t, e.t1),
            ends: [e.y.slice(), e.y1.slice()],
            pieces: &e.pieces,
            parts: Polynomials::parts(c.degree, e.h() / full),
        };
        observer.step(&mut Step::new(&mut view, at_edge, &self.course.passage.crossings)).is_break()
    }

    /// Prepares the next step.
    fn pass(&mut self, at_edge: bool) -> Result<(), IntegrateError> {
        if self.course.pass(at_edge)? {
            self.prepared.c.set_pieces(&self.course.e.pieces);
        }
        Ok(())
    }
}
