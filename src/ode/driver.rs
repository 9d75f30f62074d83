//! The loop that every solver runs: step, look for edges, tell the observer, go on.

use super::control::{Controller, Limits, StepRule, starting_step};
use super::engine::{Engine, Tableau, Vector};
use super::locate::{Exit, Found, Locator};
use super::step::{Crossing, Observer, Step, StepView};
use super::{Finish, IntegrateError, Stats};
use crate::model::{Model, Piece, Side, State};
use std::marker::PhantomData;

/// Integrates with tableau `T`; one and two degrees of freedom are compiled for their size.
pub(crate) fn drive<T: Tableau, M: Model + ?Sized, O: Observer>(
    rule: StepRule<'_>,
    limits: Limits,
    model: &M,
    start: &State,
    t_end: f64,
    observer: &mut O,
) -> Result<Finish, IntegrateError> {
    match model.dof() {
        1 => integrate::<T, M, O, [f64; 2]>(rule, limits, model, start, t_end, observer),
        2 => integrate::<T, M, O, [f64; 4]>(rule, limits, model, start, t_end, observer),
        _ => integrate::<T, M, O, Vec<f64>>(rule, limits, model, start, t_end, observer),
    }
}

/// An edge located by re-stepping is met within this share of the gap when the pieces cannot be held.
const MET: f64 = 1e-10;
/// Re-steps to one edge before it counts as a stall.
const RESTEPS: usize = 40;
/// Steps below this share of the time itself are lost in rounding.
const RESOLUTION: f64 = 4.0 * f64::EPSILON;
/// Steps without numbers in a row before the model is blamed.
const RETREATS: u32 = 15;

fn integrate<T: Tableau, M: Model + ?Sized, O: Observer, V: Vector>(
    rule: StepRule<'_>,
    limits: Limits,
    model: &M,
    start: &State,
    t_end: f64,
    observer: &mut O,
) -> Result<Finish, IntegrateError> {
    start.check(model.dof())?;
    if !(t_end.is_finite() && t_end > start.t) {
        return Err(IntegrateError::TimeSpan { start: start.t, end: t_end });
    }
    let atol = rule.check(2 * model.dof())?;
    let mut e = Engine::<M, V>::new::<T>(model, start);
    let mut stats = Stats::default();
    model.drive(e.t, Side::After, &mut e.u);

    let mut locator = Locator::new(if limits.locate { model.contacts() } else { 0 });
    let locating = limits.locate && model.contacts() > 0;
    let mut crossings: Vec<Crossing> = Vec::with_capacity(model.contacts());
    if locating {
        locator.classify(&mut e, true);
        e.frozen = can_freeze(&mut e);
    }
    e.derivative_at_start();
    if let Some(index) = e.k[0].slice().iter().position(|x| !x.is_finite()) {
        return Err(IntegrateError::NotFinite { t: e.t, component: index });
    }

    let longest = t_end - e.t;
    let (mut control, mut h) = match rule {
        StepRule::Fixed(step) => (None, step),
        StepRule::Adaptive(tolerances) => {
            e.rtol = tolerances.rtol;
            e.atol.slice_mut().copy_from_slice(&atol);
            let h = match tolerances.first {
                Some(h) => h,
                None => starting_step::<T, M, V>(&mut e, longest),
            };
            (Some((Controller::new::<T>(tolerances.beta), tolerances.max)), h)
        }
    };
    let mut edge = model.next_edge(e.t);
    let mut grid = 1u64;
    let mut retreats = 0;

    loop {
        if stats.steps + stats.rejected >= limits.max_steps as u64 {
            return Err(IntegrateError::TooManySteps { t: e.t, limit: limits.max_steps });
        }
        // Where this step should end: the grid or the proposed step, then the next jump of a drive, then the end.
        let mut aim = match &control {
            None => start.t + grid as f64 * h,
            Some((_, max)) => e.t + h.min(*max),
        };
        let stop = edge.map_or(t_end, |edge| edge.min(t_end));
        if aim + 1e-10 * (aim - e.t) >= stop {
            aim = stop;
        } else if control.is_some() && aim + 0.5 * (aim - e.t) > stop {
            aim = e.t + 0.5 * (stop - e.t); // two even steps rather than one and a crumb
        }
        if aim - e.t <= RESOLUTION * e.t.abs() && aim < stop {
            // Steps that shrink towards something that is not a number blame the model, not the tolerance.
            return Err(if retreats > 0 { not_finite(&e) } else { IntegrateError::StepUnderflow { t: e.t, h: aim - e.t } });
        }

        e.aim(aim);
        T::attempt(&mut e);
        let mut proposed = h;
        if let Some((controller, _)) = &mut control {
            let error = T::error(&e);
            if !(error.is_finite() && e.finite()) {
                stats.rejected += 1;
                retreats += 1;
                h = controller.retreat(e.h());
                if retreats > RETREATS {
                    return Err(not_finite(&e));
                }
                continue;
            }
            let (next, stands) = controller.next(e.h(), error);
            if !stands {
                stats.rejected += 1;
                h = next;
                continue;
            }
            // A step cut short says nothing against the longer one proposed before it.
            proposed = if e.h() < 0.99 * h { next.max(h) } else { next };
        } else if !e.finite() {
            return Err(not_finite(&e));
        }
        retreats = 0;

        crossings.clear();
        if locating {
            e.contacts_at_end();
            match locator.find::<T, M, V>(&mut e) {
                Found::Nothing => {}
                Found::At(theta, exit) if e.t + theta * e.h() > e.t + RESOLUTION * e.t.abs() => {
                    if theta < 1.0 && !step_to_edge::<T, M, V>(&mut e, &locator, theta, exit) {
                        return Err(IntegrateError::EdgeStall { t: e.t, contact: exit.contact });
                    }
                    crossings.push(Crossing { contact: exit.contact, from: e.pieces[exit.contact], to: exit.to });
                    let others = locator.together(&e.pieces, &e.contacts, exit);
                    crossings.extend(others.map(|o| Crossing { contact: o.contact, from: e.pieces[o.contact], to: o.to }));
                }
                Found::At(_, exit) | Found::AtOnce(exit) => {
                    stats.rejected += 1;
                    if !locator.change(&mut e.pieces, exit) {
                        return Err(IntegrateError::EdgeStall { t: e.t, contact: exit.contact });
                    }
                    e.derivative_at_start();
                    continue;
                }
            }
        }

        stats.steps += 1;
        stats.crossings += crossings.len() as u64;
        let at_edge = edge == Some(e.t1);
        let flow = {
            let mut made = Made::<T, M, V> { engine: &mut e, tracked: locating, tableau: PhantomData };
            observer.step(&mut Step::new(&mut made, at_edge, &crossings))
        };
        let done = e.t1 >= t_end;
        if done || flow.is_break() {
            stats.evaluations = e.evaluations;
            let (q, v) = e.y1.slice().split_at(model.dof());
            return Ok(Finish { state: State::new(e.t1, q, v), stopped: flow.is_break(), stats });
        }

        if crossings.is_empty() && !at_edge {
            e.derivative_at_end_of::<T>();
            e.accept::<T>();
            if locating {
                locator.accept(&e);
            }
        } else {
            let unknown = crossings.iter().any(|c| locator.jumps[c.contact].is_none());
            if unknown {
                e.derivative_at_end_of::<T>();
            }
            e.accept::<T>();
            if locating {
                locator.accept(&e);
            }
            for crossing in &crossings {
                e.pieces[crossing.contact] = crossing.to;
            }
            if at_edge {
                model.drive(e.t, Side::After, &mut e.u);
                if locating {
                    locator.classify(&mut e, false);
                }
                stats.drive_edges += 1;
                edge = model.next_edge(e.t);
            }
            if unknown && !at_edge {
                note_jumps(&mut e, &mut locator, &crossings);
            } else {
                e.derivative_at_start();
            }
        }
        match control {
            None => {
                while start.t + grid as f64 * h <= e.t + 1e-10 * h + 2.0 * RESOLUTION * e.t.abs() {
                    grid += 1;
                }
            }
            Some(_) => h = proposed,
        }
    }
}

/// Whether the model offers its pieces.
fn can_freeze<M: Model + ?Sized, V: Vector>(e: &mut Engine<'_, M, V>) -> bool {
    let (q, v) = e.y.slice().split_at(e.model.dof());
    let mut a = vec![0.0; q.len()];
    e.model.accel_on_pieces(&e.pieces, &e.u, q, v, &mut a)
}

fn not_finite<M: Model + ?Sized, V: Vector>(e: &Engine<'_, M, V>) -> IntegrateError {
    IntegrateError::NotFinite { t: e.t, component: e.y1.slice().iter().position(|y| !y.is_finite()).unwrap_or(0) }
}

/// Re-steps to an edge at θ of the step. With pieces held the trajectory is smooth past the edge and once is enough, unless the
/// force jumps there; without, the dense output was bent by the edge and the step is corrected until it meets it.
fn step_to_edge<T: Tableau, M: Model + ?Sized, V: Vector>(e: &mut Engine<'_, M, V>, locator: &Locator, theta: f64, exit: Exit) -> bool {
    let t1 = e.t + theta * e.h();
    let far = e.t1;
    if t1 <= e.t {
        return false;
    }
    e.aim(t1);
    T::attempt(e);
    e.contacts_at_end();
    if e.frozen && locator.jumps[exit.contact] != Some(true) {
        return true;
    }
    // False position on the end of the step, Illinois variant; its bracket is the start and the end of the full step.
    let (mut lo, mut hi) = ((e.t, None), (far, None));
    for _ in 0..RESTEPS {
        let (value, rate, scale) = locator.miss(&e.pieces, &e.contacts, exit);
        if value.abs() <= MET * scale {
            return true;
        }
        let here = (e.t1, Some(value));
        if value > 0.0 {
            lo = here
        } else {
            hi = here
        }
        let newton = e.t1 - value / rate;
        let t1 = match (lo.1, hi.1) {
            _ if newton > lo.0 && newton < hi.0 => newton,
            (Some(a), Some(b)) => lo.0 + (hi.0 - lo.0) * a / (a - b),
            _ => 0.5 * (lo.0 + hi.0),
        };
        if t1 <= lo.0 || t1 >= hi.0 {
            return true; // neighbouring floating-point times: as close as it gets
        }
        e.aim(t1);
        T::attempt(e);
        e.contacts_at_end();
    }
    false
}

/// Compares the acceleration on both sides of an edge: a force that jumps there asks for a closer location.
fn note_jumps<M: Model + ?Sized, V: Vector>(e: &mut Engine<'_, M, V>, locator: &mut Locator, crossings: &[Crossing]) {
    e.look.slice_mut().copy_from_slice(e.k[0].slice());
    e.derivative_at_start();
    let before = e.look.slice();
    let size = before.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let change = before.iter().zip(e.k[0].slice()).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
    for crossing in crossings {
        locator.jumps[crossing.contact] = Some(change > 1e-7 * size);
    }
}

/// The step that was just made, as the observer sees it.
struct Made<'e, 'm, T, M: Model + ?Sized, V: Vector> {
    engine: &'e mut Engine<'m, M, V>,
    tracked: bool,
    tableau: PhantomData<T>,
}

impl<T: Tableau, M: Model + ?Sized, V: Vector> StepView for Made<'_, '_, T, M, V> {
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
