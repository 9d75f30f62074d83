//! The main loop of the Taylor integrator.

use crate::model::expansion::expand::Expand;
use crate::model::structure::slopes::accelerate;
use crate::model::{Model, State};
use crate::ode::edges::exit::Found;
use crate::ode::edges::passage::Passage;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::integrator::Integrator;
use crate::ode::outcome::Finish;
use crate::ode::step::{Observer, Step};
use crate::ode::stepping::control::RESOLUTION;
use crate::ode::stepping::ends::{Ends, LARGEST};
use crate::ode::stepping::vector_blocks::Blocks;
use crate::ode::taylor::distances::first_exit;
use crate::ode::taylor::expansion::coefficients::Coefficients;
use crate::ode::taylor::pace::Pace;
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
        let prepared = Prepared { c: Coefficients::new(&tape, |d| !moving[d]), series, tape, moving, needed };
        let refused = prepared.c.plan.drives.iter().find_map(|&(drive, _)| {
            let what = prepared.series[drive].refusal()?;
            Some(IntegrateError::DriveWithoutSeries { drive, what })
        });
        refused.map_or(Ok(prepared), Err)
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
        let mut run = Run::new(self, settings, model, start, t_end)?;
        for _ in 0..settings.limits.max_steps {
            run.expand()?;
            match run.make_step()? {
                Made::Again => {
                    run.passage.stats.rejected += 1;
                    continue;
                }
                Made::Step { at_edge, full } => {
                    run.passage.stats.steps += 1;
                    let stopped = run.report(at_edge, full, observer);
                    if stopped || run.e.t1 >= t_end {
                        let (state, mut stats) = (run.e.state_at_end(), run.passage.stats);
                        stats.evaluations += run.e.evaluations();
                        return Ok(Finish { state, stopped, stats });
                    }
                    run.pass(at_edge)?;
                }
            }
        }
        Err(IntegrateError::TooManySteps { t: run.e.t, limit: settings.limits.max_steps })
    }
}

impl Integrator for Taylor {
    fn run<M: Model + ?Sized, O: Observer>(
        &self,
        model: &M,
        start: &State,
        t_end: f64,
        observer: &mut O,
    ) -> Result<Finish, IntegrateError> {
        self.check_rtol()?;
        Prepared::new(&model)?.run(self, &model, start, t_end, observer)
    }
}

/// The model as one that can be expanded.
fn expanded(model: &dyn Model) -> Result<&dyn Expand, IntegrateError> {
    let what = "a model that cannot be expanded (`Model::expand`), for example one in plain numbers";
    model.expand().ok_or_else(|| no_series(what))
}

fn no_series(what: &'static str) -> IntegrateError {
    IntegrateError::NoSeries { place: "the model".into(), what }
}

/// Safety factor on the steps while a root or a power is evaluated `[1]`.
const POWERS: f64 = 0.7;

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
struct Run<'r> {
    prepared: &'r mut Prepared,
    expanded: &'r dyn Expand,
    /// State, contacts and drives at both ends of the step.
    e: Ends<'r, dyn Model + 'r, Blocks>,
    passage: Passage,
    pace: Pace,
    degree: usize,
    /// The time after the start of the step up to which the series of the drives are valid.
    valid: f64,
    /// Scratch: two accelerations.
    accelerations: [Vec<f64>; 2],
}

impl<'r> Run<'r> {
    fn new(
        prepared: &'r mut Prepared,
        settings: &Taylor,
        model: &'r dyn Model,
        start: &State,
        t_end: f64,
    ) -> Result<Self, IntegrateError> {
        let n = 2 * model.dof();
        let (degree, atol) = settings.check(n)?;
        let mut e = Ends::<dyn Model, Blocks>::new(model, start, 1, 1);
        let passage = Passage::begin(&mut e, t_end, true)?;
        prepared.c.set_pieces(&e.pieces);
        let expanded = expanded(model)?;
        expanded.drive_series(start.t, degree + 1, &mut prepared.series);
        Ok(Run {
            pace: Pace::new(settings.tolerances.rtol, &atol, settings.tolerances.max, &prepared.c.plan),
            expanded,
            prepared,
            e,
            passage,
            degree,
            valid: f64::INFINITY,
            accelerations: [vec![0.0; n / 2], vec![0.0; n / 2]],
        })
    }

    /// Expands drives and motion at the start of the step.
    fn expand(&mut self) -> Result<(), IntegrateError> {
        let Prepared { series, needed, .. } = &mut *self.prepared;
        self.expanded.redrive_series(self.e.t, self.degree + 1, needed, series);
        self.valid = f64::INFINITY;
        let Prepared { c, series, moving, .. } = &*self.prepared;
        let mut woken = false;
        for &(drive, _) in &c.plan.drives {
            let series = &series[drive];
            if let Some(what) = series.refusal() {
                return Err(IntegrateError::DriveWithoutSeries { drive, what });
            }
            woken |= series.coefficients().len() > 1 && !moving[drive];
            self.valid = self.valid.min(series.until());
        }
        if woken {
            self.prepared.plan_anew();
            self.prepared.c.set_pieces(&self.e.pieces);
        }
        let Prepared { c, series, .. } = &mut *self.prepared;
        c.expand(self.e.y.slice(), series, self.degree, false);
        self.passage.stats.evaluations += self.degree as u64;
        Ok(())
    }

    /// Makes the step: its length, its end and the crossings there.
    fn make_step(&mut self) -> Result<Made, IntegrateError> {
        let t = self.e.t;
        let full = self.length()?;
        let stop = self.passage.stop;
        // The last digits of the time are kept at drive edges and at the end of the run.
        let shortest = 2.0 * RESOLUTION * t.abs();
        let reach = full.min(self.pace.longest()).min(self.valid.max(shortest));
        let aim = if t + reach * (1.0 + 1e-10) >= stop { stop } else { t + reach };
        let h = aim - t;
        if aim < stop && h <= RESOLUTION * t.abs() {
            return Err(IntegrateError::StepUnderflow { t, h });
        }
        self.passage.crossings.clear();
        let c = &self.prepared.c;
        let found = first_exit(c, &mut self.e, &self.passage.locator, &mut self.pace.ranges, h)?;
        let h = match found {
            Found::Nothing => {
                self.e.aim(aim);
                h
            }
            Found::AtOnce(exit) => {
                self.passage.leave(&mut self.e, exit)?;
                self.prepared.c.set_pieces(&self.e.pieces);
                return Ok(Made::Again);
            }
            Found::At(root, _) => {
                self.e.aim(if root < h { t + root } else { aim });
                root
            }
        };
        c.at(h, self.e.y1.slice_mut());
        if !self.e.finite() {
            return Err(if self.pace.has_shrunk(full) { self.shrunk(h) } else { self.not_finite() });
        }
        if let Found::At(_, exit) = found {
            self.e.drive_end();
            self.e.contacts_at_end();
            self.passage.cross(&mut self.e, exit)?;
        }
        self.pace.keep(full);
        Ok(Made::Step { at_edge: self.passage.is_drive_edge(self.e.t1), full })
    }

    /// The length of the step that the tolerances allow; infinite if the series ends.
    fn length(&mut self) -> Result<f64, IntegrateError> {
        let room = self.passage.stop - self.e.t;
        let resolution = RESOLUTION * self.e.t.abs();
        let c = &mut self.prepared.c;
        let h = self.pace.length(c, room);
        let powers = c.plan.functions().any(|function| function.is_power());
        if h > resolution && !self.pace.collapsed(h) {
            // Beyond the distance of a root or power of 0 the terms after the last one do not decay.
            return Ok(if powers { POWERS * h } else { h });
        }
        if !powers {
            return if h > resolution { Ok(h) } else { Err(self.shrunk(h)) };
        }
        // At a root or a power of 0 the motion is finite but has no series. A short step with the power held
        // at its value leaves the point.
        c.expand(self.e.y.slice(), &self.prepared.series, self.degree, true);
        let mut h = self.pace.length(c, room).min(self.pace.start_of_power(room));
        let n = self.e.model.dof();
        while h > resolution && h > 0.0 {
            self.e.aim(self.e.t + h);
            self.e.drive_end();
            c.at(h, self.e.y1.slice_mut());
            let [held, real] = &mut self.accelerations;
            c.acceleration(h, held);
            let (q, v) = self.e.y1.slice().split_at(n);
            accelerate(self.e.model, Some(&self.e.pieces), self.e.nodes.end(), q, v, real);
            if self.pace.tolerates(h, held, real) {
                return Ok(h);
            }
            h *= 0.25;
        }
        Err(self.shrunk(h))
    }

    /// The error for a step below the resolution of the time.
    fn shrunk(&self, h: f64) -> IntegrateError {
        let t = self.e.t;
        let c = &self.prepared.c;
        let finite = (0..=c.degree).all(|n| c.q(n).iter().chain(c.v(n)).all(|x| x.is_finite()));
        match c.plan.functions().find(|function| function.is_singular_at_zero()) {
            Some(function) => IntegrateError::NoSeriesAt { t, what: function.name() },
            None if !finite || h.is_nan() => self.not_finite(),
            None => IntegrateError::StepUnderflow { t, h },
        }
    }

    fn not_finite(&self) -> IntegrateError {
        let (c, n) = (&self.prepared.c, self.e.model.dof());
        let end = self.e.y1.slice().iter();
        let component = c.q(1).iter().chain(c.v(1)).position(|x| !x.is_finite());
        let component = component.or_else(|| end.clone().position(|y| !y.is_finite() || y.abs() > LARGEST));
        IntegrateError::NotFinite { t: self.e.t, component: component.unwrap_or(0).min(2 * n - 1) }
    }

    /// Reports the step to the observer. Returns whether it stops the run.
    fn report(&mut self, at_edge: bool, full: f64, observer: &mut dyn Observer) -> bool {
        let (c, e) = (&self.prepared.c, &self.e);
        let mut view = Polynomials {
            c,
            times: (e.t, e.t1),
            ends: [e.y.slice(), e.y1.slice()],
            pieces: &e.pieces,
            parts: Polynomials::parts(c.degree, e.h() / full),
        };
        observer.step(&mut Step::new(&mut view, at_edge, &self.passage.crossings)).is_break()
    }

    /// Prepares the next step: velocities after impacts, pieces, drive edges.
    fn pass(&mut self, at_edge: bool) -> Result<(), IntegrateError> {
        let Run { e, passage, .. } = self;
        e.move_on();
        passage.locator.still.fill(0);
        if passage.crossings.is_empty() && !at_edge {
            return Ok(());
        }
        if !passage.crossings.is_empty() {
            passage.locator.accept(e);
        }
        self.pace.limit(passage.pass::<_, _, true>(e, at_edge)?);
        self.prepared.c.set_pieces(&e.pieces);
        Ok(())
    }
}
