//! The main loop of all solvers: make a step, locate edges in it, call the observer, prepare the next step.

use crate::contact::piece::Piece;
use crate::model::equations::{Model, State};
use crate::ode::edges::arrival::{note_jumps, step_to_edge};
use crate::ode::edges::exit::Exit;
use crate::ode::edges::locate::{Found, Locator};
use crate::ode::edges::stops::Stops;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::outcome::{Finish, Stats};
use crate::ode::step::{Crossing, Observer, Step, StepView};
use crate::ode::stepping::control::{Limits, Pace, RESOLUTION, StepRule, starting_step};
use crate::ode::stepping::engine::{Engine, LARGEST, Tableau};
use crate::ode::stepping::vector::Vector;
use crate::ode::stepping::vector_blocks::Blocks;
use std::marker::PhantomData;

/// Integrates `model` from `start` to `t_end` with tableau `T`.
///
/// Models with one and with two degrees of freedom are compiled for their size. Runs that do not locate edges
/// are compiled without that code. The observer is a trait object: runs that differ only in the type of their
/// observer are compiled once.
pub(crate) fn drive<T: Tableau, M: Model + ?Sized>(
    rule: StepRule<'_>,
    limits: Limits,
    model: &M,
    start: &State,
    t_end: f64,
    observer: &mut dyn Observer,
) -> Result<Finish, IntegrateError> {
    if !limits.locate
        && let Some(contact) = model.offers().first_stop()
    {
        return Err(IntegrateError::StopNotLocated { contact });
    }
    // A build without optimisation compiles the loop once for all models, to save build time.
    #[cfg(debug_assertions)]
    let model: &dyn Model = &model;
    match (model.dof(), limits.locate && model.contacts() > 0) {
        (1, false) => integrate::<T, _, [f64; 2], false>(rule, limits, model, start, t_end, observer),
        (1, true) => integrate::<T, _, [f64; 2], true>(rule, limits, model, start, t_end, observer),
        (2, false) => integrate::<T, _, [f64; 4], false>(rule, limits, model, start, t_end, observer),
        (2, true) => integrate::<T, _, [f64; 4], true>(rule, limits, model, start, t_end, observer),
        (_, false) => integrate::<T, _, Blocks, false>(rule, limits, model, start, t_end, observer),
        (_, true) => integrate::<T, _, Blocks, true>(rule, limits, model, start, t_end, observer),
    }
}

/// Largest magnitude of the end time of a run. Beyond it, products of steps and rates overflow.
pub(crate) const LAST_TIME: f64 = 1e50;

/// Maximum number of consecutive steps with a result that is not finite. One more, and the run fails with
/// [`IntegrateError::NotFinite`].
const RETREATS: u32 = 15;

fn integrate<T: Tableau, M: Model + ?Sized, V: Vector, const LOCATE: bool>(
    rule: StepRule<'_>,
    limits: Limits,
    model: &M,
    start: &State,
    t_end: f64,
    observer: &mut dyn Observer,
) -> Result<Finish, IntegrateError> {
    start.check(model.dof())?;
    if !(t_end.abs() <= LAST_TIME && t_end > start.t) {
        return Err(IntegrateError::TimeSpan { start: start.t, end: t_end });
    }
    let mut run = Run::<M, V>::new::<T, LOCATE>(rule, model, start, t_end)?;
    for attempt in 0..limits.max_steps as u64 {
        let aim = run.pace.aim::<T>(run.e.t, run.stop);
        if T::ADAPTIVE && aim - run.e.t <= RESOLUTION * run.e.t.abs() && aim < run.stop {
            // If the last attempts gave no finite result, the cause is the model and not the tolerance.
            let underflow = IntegrateError::StepUnderflow { t: run.e.t, h: aim - run.e.t };
            return Err(if run.retreats > 0 { not_finite::<T, M, V>(&run.e) } else { underflow });
        }
        run.e.aim(aim);
        if !T::ADAPTIVE {
            run.e.drive_ahead::<T>(&run.pace, run.stop);
        }
        run.e.attempt::<T, LOCATE>();
        if run.judge::<T>()? == Verdict::Repeat || (LOCATE && run.locate_edges::<T>()? == Verdict::Repeat) {
            run.stats.rejected += 1;
            continue;
        }
        // The frequent case: the step ends on no edge and before the end of the run.
        let ordinary = run.e.t1 < run.stop && (!LOCATE || run.crossings.is_empty());
        let at_edge = !ordinary && run.edge == run.e.t1;
        let flow = {
            let mut made = MadeStep::<T, M, V> { engine: &mut run.e, tracked: LOCATE, tableau: PhantomData };
            observer.step(&mut Step::new(&mut made, at_edge, &run.crossings))
        };
        if ordinary && flow.is_continue() {
            run.pace.arrive::<T>();
            run.e.accept::<T, LOCATE>();
            if LOCATE {
                run.locator.accept(&mut run.e);
            }
            continue;
        }
        if flow.is_break() || run.e.t1 >= t_end {
            let (q, v) = run.e.y1.slice().split_at(model.dof());
            // Attempts = accepted + rejected steps. `e.evaluations` does not count those of attempts.
            let attempts = attempt + 1;
            let evaluations = attempts * T::EVALUATIONS + run.e.evaluations;
            let stats = Stats { steps: attempts - run.stats.rejected, evaluations, ..run.stats };
            return Ok(Finish { state: State::new(run.e.t1, q, v), stopped: flow.is_break(), stats });
        }
        run.pace.pass::<T>(run.e.t1);
        run.pass_edges::<T, LOCATE>(at_edge, t_end)?;
    }
    Err(IntegrateError::TooManySteps { t: run.e.t, limit: limits.max_steps })
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
struct Run<'m, M: Model + ?Sized, V: Vector> {
    e: Engine<'m, M, V>,
    pace: Pace,
    locator: Locator,
    /// Crossings at the end of the current step.
    crossings: Vec<Crossing>,
    /// Next drive edge; infinite if there is none.
    edge: f64,
    /// Latest end of the next step: the next drive edge or the end of the run.
    stop: f64,
    /// Number of consecutive steps with a result that is not finite.
    retreats: u32,
    stats: Stats,
}

impl<'m, M: Model + ?Sized, V: Vector> Run<'m, M, V> {
    fn new<T: Tableau, const LOCATE: bool>(
        rule: StepRule<'_>,
        model: &'m M,
        start: &State,
        t_end: f64,
    ) -> Result<Self, IntegrateError> {
        let atol = rule.check(2 * model.dof())?;
        let mut e = Engine::<M, V>::new::<T>(model, start);
        let mut locator =
            Locator::new(if LOCATE { model.contacts() } else { 0 }, Stops::new::<M, LOCATE>(model));
        if LOCATE {
            locator.measure_noise(&mut e);
            locator.classify(&mut e, true);
            e.check_gaps(e.t)?;
            locator.check_stops(e.t)?;
            e.on_fixed_pieces = model.offers().pieces;
        }
        e.derivative_at_start();
        if let Some(component) = e.k[0].slice().iter().position(|x| !x.is_finite()) {
            return Err(IntegrateError::NotFinite { t: e.t, component });
        }
        let pace = match rule {
            StepRule::Fixed(h) if h <= RESOLUTION * e.t.abs().max(t_end.abs()) => {
                return Err(IntegrateError::StepUnderflow { t: e.t, h });
            }
            StepRule::Fixed(h) => Pace::new::<T>(e.t, h, None),
            StepRule::Adaptive(tolerances) => {
                e.rtol = tolerances.rtol;
                e.atol.slice_mut().copy_from_slice(&atol);
                let h = tolerances.first.unwrap_or_else(|| starting_step::<T, M, V>(&mut e, t_end - start.t));
                Pace::new::<T>(e.t, h, Some(tolerances))
            }
        };
        let edge = edge_after(model, e.t)?;
        let crossings = Vec::with_capacity(2 * model.contacts() + locator.stops.room());
        Ok(Run {
            e,
            pace,
            locator,
            crossings,
            edge,
            stop: edge.min(t_end),
            retreats: 0,
            stats: Stats::default(),
        })
    }

    /// Judges the current step by its error. For a repetition the pace holds a shorter step.
    ///
    /// # Errors
    /// [`IntegrateError::NotFinite`] if the result of a fixed step, or of more than `RETREATS` consecutive
    /// adaptive steps, is not finite.
    #[inline(always)]
    fn judge<T: Tableau>(&mut self) -> Result<Verdict, IntegrateError> {
        if !T::ADAPTIVE {
            return if self.e.finite() { Ok(Verdict::Accept) } else { Err(not_finite::<T, M, V>(&self.e)) };
        }
        let (error, made, pace) = (T::error(&self.e), self.e.h(), &mut self.pace);
        if !(error.is_finite() && self.e.finite()) {
            self.retreats += 1;
            pace.h = pace.controller.retreat(made);
            return if self.retreats > RETREATS {
                Err(not_finite::<T, M, V>(&self.e))
            } else {
                Ok(Verdict::Repeat)
            };
        }
        self.retreats = 0;
        let (proposed, accepted) = pace.controller.next(made, error);
        if accepted {
            // If the step was shorter than the pace proposed, the earlier, longer proposal remains valid.
            pace.next = if made < 0.99 * pace.h { proposed.max(pace.h) } else { proposed };
            Ok(Verdict::Accept)
        } else {
            pace.h = proposed;
            Ok(Verdict::Repeat)
        }
    }

    /// Locates the first edge of a contact inside the current step and ends the step there. The step must be
    /// repeated if it is too long to resolve the gaps, or if a contact leaves its piece at the start of the
    /// step.
    #[inline(always)]
    fn locate_edges<T: Tableau>(&mut self) -> Result<Verdict, IntegrateError> {
        self.crossings.clear();
        let e = &mut self.e;
        let made = e.h();
        e.contacts_at_end();
        e.check_gaps(e.t1)?;
        let stall = |t: f64, exit: Exit| Err(IntegrateError::EdgeStall { t, contact: exit.contact });
        match self.locator.find::<T, M, V>(e) {
            Found::Nothing => {}
            Found::TooLong(share) => {
                self.pace.h = share * made;
                return Ok(Verdict::Repeat);
            }
            Found::At(theta, exit) if e.t + theta * e.h() > e.t + RESOLUTION * e.t.abs() => {
                if theta < 1.0 && !step_to_edge::<T, M, V>(e, &self.locator, theta, exit) {
                    return stall(e.t, exit);
                }
                let (pieces, stops) = (&e.pieces, &self.locator.stops);
                let crossing = |Exit { contact, to }| Crossing {
                    contact,
                    from: pieces[contact],
                    to,
                    rebounds: stops.rigid(contact, to),
                };
                self.crossings.push(crossing(exit));
                self.crossings.extend(self.locator.together(pieces, &e.contacts, exit).map(crossing));
                self.locator.strike_at_end(e, &mut self.crossings)?;
                self.stats.crossings += self.crossings.len() as u64;
            }
            Found::At(_, exit) | Found::AtOnce(exit) => {
                if self.locator.stops.rigid(exit.contact, exit.to) {
                    self.locator.strike_at_start(e, exit, &mut self.crossings)?;
                } else if !self.locator.change(&mut e.pieces, exit) {
                    return stall(e.t, exit);
                }
                e.derivative_at_start();
                return Ok(Verdict::Repeat);
            }
        }
        if T::ADAPTIVE {
            self.pace.next = self.pace.next.min(self.locator.growth * made);
        }
        Ok(Verdict::Accept)
    }

    /// Prepares the next step after crossings, impacts and drive edges: velocities, pieces, accelerations and
    /// the next drive edge.
    #[inline(always)]
    fn pass_edges<T: Tableau, const LOCATE: bool>(
        &mut self,
        at_edge: bool,
        t_end: f64,
    ) -> Result<(), IntegrateError> {
        let e = &mut self.e;
        let unknown = LOCATE
            && !at_edge
            && self.crossings.iter().any(|c| !c.rebounds && self.locator.jumps[c.contact].is_none());
        if unknown {
            e.accept::<T, LOCATE>(); // with the derivative on the old pieces, for `note_jumps`
        } else {
            e.move_on();
        }
        if LOCATE {
            self.locator.accept(e);
            let longest = self.locator.rebound(e);
            if T::ADAPTIVE {
                self.pace.h = self.pace.h.min(longest);
            }
            for crossing in self.crossings.iter().filter(|c| !c.rebounds) {
                e.pieces[crossing.contact] = crossing.to;
            }
        }
        if at_edge {
            if LOCATE {
                self.locator.classify(e, false);
                e.check_gaps(e.t)?;
                self.locator.check_stops(e.t)?;
            }
            self.stats.drive_edges += 1;
            self.edge = edge_after(e.model, e.t)?;
            self.stop = self.edge.min(t_end);
        }
        if unknown {
            note_jumps(e, &mut self.locator, &self.crossings);
        } else {
            e.derivative_at_start();
        }
        Ok(())
    }
}

/// The next drive edge after `t`; infinite if there is none.
pub(crate) fn edge_after<M: Model + ?Sized>(model: &M, t: f64) -> Result<f64, IntegrateError> {
    match model.next_edge(t) {
        None => Ok(f64::INFINITY),
        Some(edge) if edge > t => Ok(edge),
        Some(edge) => Err(IntegrateError::DriveEdge { t, edge }),
    }
}

/// The error for a step without a finite result. It names the first acceleration that is not finite, in the
/// order of the stages; if there is none, the first component of the result that is not finite or exceeds
/// `LARGEST`.
fn not_finite<T: Tableau, M: Model + ?Sized, V: Vector>(e: &Engine<'_, M, V>) -> IntegrateError {
    let n = e.model.dof();
    let stages = e.k[..T::SLOTS]
        .iter()
        .flat_map(|k| k.slice()[n..].iter().position(|a| !a.is_finite()).map(|i| n + i));
    let component = stages
        .chain(e.y1.slice().iter().position(|y| !y.is_finite() || y.abs() > LARGEST))
        .next()
        .unwrap_or(0);
    IntegrateError::NotFinite { t: e.t, component }
}

/// The current step as a view for the observer.
struct MadeStep<'e, 'm, T, M: Model + ?Sized, V: Vector> {
    engine: &'e mut Engine<'m, M, V>,
    tracked: bool,
    tableau: PhantomData<T>,
}

impl<T: Tableau, M: Model + ?Sized, V: Vector> StepView for MadeStep<'_, '_, T, M, V> {
    fn times(&self) -> (f64, f64) {
        (self.engine.t, self.engine.t1)
    }
    fn start(&self) -> &[f64] {
        self.engine.y.slice()
    }
    fn end(&self) -> &[f64] {
        self.engine.y1.slice()
    }
    fn pieces(&self) -> Option<&[Piece]> {
        self.tracked.then_some(&self.engine.pieces[..])
    }
    fn at(&mut self, t: f64, y: &mut [f64]) {
        self.engine.prepare_dense::<T>();
        let theta = (t - self.engine.t) / self.engine.h();
        self.engine.interpolate::<T>(theta, y);
    }
}
