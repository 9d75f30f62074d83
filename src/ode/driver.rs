//! The main loop of the Runge-Kutta methods: make a step, locate edges in it, call the observer, prepare the
//! next step.

use crate::contact::Piece;
use crate::model::{Model, State};
use crate::ode::edges::arrival::{note_jumps, step_on_edge, step_to_edge};
use crate::ode::edges::exit::{Found, Share};
use crate::ode::edges::passage::Passage;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::outcome::{Finish, Stats};
use crate::ode::rejections::Rejections;
use crate::ode::step::{Step, StepView};
use crate::ode::stepping::control::{Knots, RESOLUTION, StepEnds, StepRule, Task, starting_step};
use crate::ode::stepping::engine::{Engine, Tableau};
use crate::ode::stepping::one_step::OwnStep;
use crate::ode::stepping::vector::Vector;
use crate::ode::stepping::vector_blocks::Blocks;
use std::marker::PhantomData;

/// Integrates `model` from `start` to `t_end` with tableau `T`.
///
/// Models with one and with two degrees of freedom are compiled for their size. Runs that do not locate edges
/// are compiled without that code. Model and observer are trait objects: these loops are compiled once.
pub(crate) fn drive<T: Tableau>(task: Task<'_>) -> Result<Finish, IntegrateError> {
    let model = task.model.itself().unwrap_or(task.model);
    let (task, locate) = (Task { model, ..task }, task.limits.locate);
    task.observer.fits(model.dof(), model.contacts())?;
    if !locate {
        model.offers().refuse_stops(|contact| IntegrateError::StopNotLocated { contact })?;
        task.start.check(model.dof())?;
        IntegrateError::of_start(model, task.start)?;
    }
    match (model.dof(), locate && model.contacts() > 0) {
        (1, false) => integrate::<T, [f64; 2], false>(task),
        (1, true) => integrate::<T, [f64; 2], true>(task),
        (2, false) => integrate::<T, [f64; 4], false>(task),
        (2, true) => integrate::<T, [f64; 4], true>(task),
        (_, false) => integrate::<T, Blocks, false>(task),
        (_, true) => integrate::<T, Blocks, true>(task),
    }
}

/// Maximum number of consecutive steps with a result that is not finite. One more, and the run fails with
/// [`IntegrateError::NotFinite`].
const RETREATS: u32 = 15;

fn integrate<T: Tableau, V: Vector, const LOCATE: bool>(task: Task<'_>) -> Result<Finish, IntegrateError> {
    let Task { rule, limits, model, start, t_end, observer, own } = task;
    start.check(model.dof())?;
    let own = own.map(|method| OwnStep::new(method, 2 * model.dof()));
    let mut run = Run::<V>::new::<T, LOCATE>((rule, own), model, start, t_end)?;
    run.passage.fits(model, start.t, limits.max_steps)?;
    for attempt in 0..limits.max_steps as u64 {
        let (t, stop) = (run.e.ends.t, run.passage.stop);
        let aim = run.pace.aim::<T>(t, run.knots.stop(t, run.pace.length::<T>(), stop));
        if T::ADAPTIVE && aim - t <= RESOLUTION * t.abs() && aim < stop {
            // If the last attempts gave no finite result, the cause is the model and not the tolerance.
            return Err(match run.retreats {
                0 => run.rejections.underflow(&run.e, aim - t),
                _ => not_finite::<T, V>(&run.e),
            });
        }
        run.e.aim(aim);
        if !T::ADAPTIVE {
            run.e.drive_ahead::<T>(|step| run.pace.grid(step), stop);
        }
        run.e.attempt::<T, LOCATE>();
        if T::ADAPTIVE {
            run.rejections.attempted(&run.e, attempt)?;
        }
        if run.judge::<T>()? == Verdict::Repeat || (LOCATE && run.locate_edges::<T>()? == Verdict::Repeat) {
            run.passage.stats.rejected += 1;
            continue;
        }
        // The frequent case: the step ends on no edge and before the end of the run.
        let ordinary = run.e.ends.t1 < stop && (!LOCATE || run.passage.crossings.is_empty());
        let at_edge = !ordinary && run.passage.is_drive_edge(run.e.ends.t1);
        let flow = {
            let mut made = MadeStep::<T, V> { engine: &mut run.e, tracked: LOCATE, tableau: PhantomData };
            observer.step(&mut Step::new(&mut made, at_edge, &run.passage.crossings))
        };
        if ordinary && flow.is_continue() {
            run.pace.arrive::<T>();
            run.e.accept::<T, LOCATE>();
            if LOCATE {
                run.passage.locator.accept(&mut run.e.ends);
            }
            continue;
        }
        if flow.is_break() || run.e.ends.t1 >= t_end {
            // Attempts = accepted + rejected steps. `e.evaluations` does not count those of attempts.
            let (attempts, stats) = (attempt + 1, run.passage.stats);
            let evaluations = attempts * T::EVALUATIONS + run.e.evaluations + run.e.ends.evaluations();
            let stats = Stats { steps: attempts - stats.rejected, evaluations, ..stats };
            let state = run.passage.finish(&mut run.e.ends)?;
            return Ok(Finish { state, stopped: flow.is_break(), stats });
        }
        run.pace.pass::<T>(run.e.ends.t1);
        run.pass_edges::<T, LOCATE>(at_edge)?;
    }
    Err(IntegrateError::TooManySteps { t: run.e.ends.t, limit: limits.max_steps })
}

/// What becomes of the step just made.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Accept,
    /// Repeat from the same start: with the length that the pace now holds, on other pieces, or with the
    /// velocities after an impact there.
    Repeat,
}

/// Variables of the main loop in one run.
struct Run<'m, V: Vector> {
    e: Engine<'m, V>,
    pace: StepEnds,
    knots: Knots<'m>,
    passage: Passage,
    /// Number of consecutive steps with a result that is not finite.
    retreats: u32,
    stalls: Stalls,
    rejections: Rejections,
}

/// Steps shortened because a contact stalled on its edge.
#[derive(Default)]
struct Stalls {
    count: u32,
    /// Length of the first of these steps.
    first: f64,
}

/// A step is shortened by this factor if a contact stalls on its edge at the start of the step, or if the
/// error of a step that ends on an edge exceeds the tolerance `[1]`.
const STALLED: f64 = 0.25;

/// Largest error of a step on fixed pieces that ends on an edge, in units of the tolerance `[1]`. The error
/// of the longer step that passed the edge is at most 1; rounding of a late time may raise it.
const AT_EDGE: f64 = 10.0;

/// Maximum number of such steps before one succeeds that is as long as the first of them.
const STALLS: u32 = 32;

impl Stalls {
    /// A contact stalls at the start of a step `h`. Whether the step may be shortened.
    fn shortens(&mut self, h: f64) -> bool {
        if self.count == 0 {
            self.first = h;
        }
        self.count += 1;
        self.count <= STALLS
    }
    /// A step `h` succeeds.
    #[inline(always)]
    fn ends(&mut self, h: f64) {
        if h >= self.first {
            *self = Stalls::default();
        }
    }
}

impl<'m, V: Vector> Run<'m, V> {
    fn new<T: Tableau, const LOCATE: bool>(
        (rule, own): (StepRule<'_>, Option<OwnStep<'m>>),
        model: &'m dyn Model,
        start: &State,
        t_end: f64,
    ) -> Result<Self, IntegrateError> {
        let atol = rule.check(2 * model.dof())?;
        let mut e = Engine::<V>::new::<T>(model, start);
        let exponent = own.as_ref().map_or(T::EXPONENT, OwnStep::exponent);
        e.own = own;
        if !atol.is_empty() {
            e.ends.atol.slice_mut().copy_from_slice(&atol);
        }
        let mut passage = Passage::begin(&mut e.ends, t_end, LOCATE)?;
        if LOCATE {
            passage.sliding.prepare(&e.ends);
        }
        e.on_fixed_pieces = LOCATE && model.offers().pieces;
        // What the model does not write is not a number.
        e.k[0].slice_mut().fill(f64::NAN);
        e.derivative_at_start();
        if let Some(component) = e.k[0].slice().iter().position(|x| !x.is_finite()) {
            let acceleration = component.saturating_sub(model.dof());
            if e.k[0].slice()[component].is_nan() {
                return Err(IntegrateError::NotANumber { t: start.t, acceleration });
            }
            return Err(IntegrateError::NotFinite { t: start.t, component });
        }
        let pace = match rule {
            StepRule::Fixed(h) if h <= RESOLUTION * start.t.abs().max(t_end.abs()) => {
                return Err(e.ends.underflow(h));
            }
            StepRule::Fixed(h) => StepEnds::new::<T>(start.t, h, None, exponent),
            StepRule::Adaptive(tolerances) => {
                e.rtol = tolerances.rtol;
                let h = tolerances.first.unwrap_or_else(|| starting_step(&mut e, t_end - start.t, exponent));
                StepEnds::new::<T>(start.t, h, Some(tolerances), exponent)
            }
        };
        let rejections = Rejections::new(&e.ends.u_stage, 2 * model.dof(), pace.h, [start.t, t_end]);
        let knots = Knots::of::<T>(model, start.t);
        Ok(Run { e, pace, knots, passage, retreats: 0, stalls: Stalls::default(), rejections })
    }

    /// Judges the current step by its error. For a repetition the pace holds a shorter step.
    ///
    /// # Errors
    /// [`IntegrateError::Discontinuity`]; [`IntegrateError::NotFinite`] if the result of a fixed step, or of
    /// more than `RETREATS` consecutive adaptive steps, is not finite.
    #[inline(always)]
    fn judge<T: Tableau>(&mut self) -> Result<Verdict, IntegrateError> {
        if !T::ADAPTIVE {
            return if self.e.ends.finite() { Ok(Verdict::Accept) } else { Err(not_finite::<T, V>(&self.e)) };
        }
        let (error, made, pace) = (T::error(&mut self.e), self.e.ends.h(), &mut self.pace);
        if !(error.is_finite() && self.e.ends.finite()) {
            self.retreats += 1;
            pace.h = pace.controller.retreat(made);
            return if self.retreats > RETREATS {
                Err(not_finite::<T, V>(&self.e))
            } else {
                Ok(Verdict::Repeat)
            };
        }
        self.retreats = 0;
        let (proposed, accepted) = pace.controller.next(made, error);
        if accepted {
            // If the step was shorter than the pace proposed, the earlier, longer proposal remains valid.
            pace.next = if made < 0.99 * pace.h { proposed.max(pace.h) } else { proposed };
            self.e.before = Some(self.e.estimates);
            Ok(Verdict::Accept)
        } else {
            pace.h = proposed;
            self.rejections.rejected(&self.e)?;
            Ok(Verdict::Repeat)
        }
    }

    /// Locates the first edge of a contact inside the current step and ends the step there. The step must be
    /// repeated if it is too long to resolve the gaps, or if a contact leaves its piece at the start of the
    /// step.
    #[inline(always)]
    fn locate_edges<T: Tableau>(&mut self) -> Result<Verdict, IntegrateError> {
        let Run { e, passage, pace, .. } = self;
        passage.crossings.clear();
        let made = e.ends.h();
        e.ends.contacts_at_end();
        e.ends.check_gaps(e.ends.t1)?;
        match passage.locator.find::<T, V>(e) {
            Ok(Found::Nothing) => {}
            Err(share) => {
                pace.h = share * made;
                return Ok(Verdict::Repeat);
            }
            Ok(Found::At(Share(theta), exit))
                if e.ends.t + theta * made > e.ends.t + RESOLUTION * e.ends.t.abs() =>
            {
                if theta < 1.0 {
                    match step_to_edge::<T, V>(e, &passage.locator, theta, exit) {
                        Err(IntegrateError::EdgeStall { .. })
                            if T::ADAPTIVE && self.stalls.shortens(made) =>
                        {
                            pace.h = STALLED * made;
                            return Ok(Verdict::Repeat);
                        }
                        arrived => arrived.map_err(|stall| passage.cause(&e.ends, exit.contact, stall))?,
                    }
                    // The step that was judged is another one. Without fixed pieces a stage at the end of
                    // this one may see the jump behind the edge; on them, a force d^p whose derivatives are
                    // infinite on the edge.
                    let most = if e.on_fixed_pieces { AT_EDGE } else { 1.0 };
                    if T::ADAPTIVE && T::error(e) > most {
                        pace.h = STALLED * e.ends.h();
                        return Ok(Verdict::Repeat);
                    }
                }
                passage.cross(&mut e.ends, exit)?;
            }
            Ok(Found::At(_, exit) | Found::AtOnce(exit)) => {
                let Some(late) = passage.locator.crosses_late(&mut e.ends, exit) else {
                    match passage.leave(&mut e.ends, exit) {
                        // A step that is too long for a fast decay may overshoot the edge at which the motion
                        // ends.
                        Err(IntegrateError::EdgeStall { .. })
                            if T::ADAPTIVE && self.stalls.shortens(made) =>
                        {
                            pace.h = STALLED * made;
                            passage.locator.still.fill(0);
                            passage.locator.classify(&mut e.ends, true);
                        }
                        left => left.map_err(|stall| passage.cause(&e.ends, exit.contact, stall))?,
                    }
                    e.derivative_at_start();
                    return Ok(Verdict::Repeat);
                };
                step_on_edge::<T, V>(e, late, passage.stop);
                passage.cross(&mut e.ends, exit)?;
            }
        }
        if T::ADAPTIVE {
            self.stalls.ends(made);
            pace.next = pace.next.min(passage.locator.growth * made);
        } else if !passage.crossings.is_empty() {
            passage.count(e.ends.t1, pace.next)?;
        }
        Ok(Verdict::Accept)
    }

    /// Prepares the next step after crossings, impacts and drive edges.
    #[inline(always)]
    fn pass_edges<T: Tableau, const LOCATE: bool>(&mut self, at_edge: bool) -> Result<(), IntegrateError> {
        let Run { e, passage, pace, .. } = self;
        e.before = None; // the force jumps or has a kink here
        let behind = if LOCATE && !e.on_fixed_pieces {
            passage.locator.behind(&passage.crossings, &e.ends.contacts, e.ends.t1)
        } else {
            0.0
        };
        let unknown = LOCATE && !at_edge && passage.locator.has_unknown_jump(&passage.crossings);
        if unknown {
            e.accept::<T, LOCATE>(); // with the derivative on the old pieces, for `note_jumps`
        } else {
            e.ends.move_on();
        }
        if LOCATE {
            passage.locator.accept(&mut e.ends);
        }
        let longest = passage.pass::<V, LOCATE>(&mut e.ends, at_edge)?;
        if T::ADAPTIVE {
            pace.h = pace.h.min(longest);
        }
        if unknown {
            note_jumps(e, &mut passage.locator, &passage.crossings, behind);
        } else {
            e.derivative_behind(behind);
        }
        Ok(())
    }
}

/// The error for a step without a finite result. It names the first acceleration that is not finite, in the
/// order of the stages; if there is none, the first component of the result that is not finite or exceeds
/// `LARGEST`.
fn not_finite<T: Tableau, V: Vector>(e: &Engine<'_, V>) -> IntegrateError {
    let n = e.ends.model.dof();
    let stages = e.k[..T::SLOTS]
        .iter()
        .flat_map(|k| k.slice()[n..].iter().position(|a| !a.is_finite()).map(|i| n + i));
    let component = stages.chain(e.ends.not_finite()).next().unwrap_or(0);
    IntegrateError::NotFinite { t: e.ends.t, component }
}

/// The current step as a view for the observer.
struct MadeStep<'e, 'm, T, V: Vector> {
    engine: &'e mut Engine<'m, V>,
    tracked: bool,
    tableau: PhantomData<T>,
}

impl<T: Tableau, V: Vector> StepView for MadeStep<'_, '_, T, V> {
    fn times(&self) -> (f64, f64) {
        (self.engine.ends.t, self.engine.ends.t1)
    }
    fn start(&self) -> &[f64] {
        self.engine.ends.y.slice()
    }
    fn end(&self) -> &[f64] {
        self.engine.ends.y1.slice()
    }
    fn pieces(&self) -> Option<&[Piece]> {
        self.tracked.then_some(&self.engine.ends.pieces[..])
    }
    fn at(&mut self, t: f64, y: &mut [f64]) {
        self.engine.prepare_dense::<T>();
        let theta = (t - self.engine.ends.t) / self.engine.ends.h();
        self.engine.interpolate::<T>(theta, y);
    }
}
