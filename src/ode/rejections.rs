//! Rejected steps of an adaptive run: motions that stay on a jump, and steps that stay short.
//!
//! The accelerations may jump where the model does not declare it, the time may be so late that its rounding
//! exceeds the tolerance, or the tolerance may lie below the rounding of the state.

use crate::excitation::Side;
use crate::model::structure::slopes::accelerate;
use crate::numeric::norms::largest;
use crate::numeric::search::jump::jump;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::stepping::ends::halves;
use crate::ode::stepping::engine::Engine;
use crate::ode::stepping::vector::Vector;

/// Number of rejected steps that are observed together.
const WINDOW: u32 = 128;

/// The second half of these steps is searched for jumps. With this number of jumps of one acceleration the
/// run ends.
const JUMPS: u32 = 32;

/// The steps are short if all of them together are shorter than this share of the longest attempt `[1]`.
const SHORT: f64 = 0.1;

/// The run measures its progress each time after this number of attempts. A solver can stay on a jump with
/// short steps that it accepts. Rejected steps do not show such a stay.
const PERIOD: u64 = 4096;

/// A run is slow if its mean step since the last measurement is below this share of its longest attempt
/// `[1]`.
const SLOW: f64 = 1.0 / 64.0;

/// A run is slow, too, if it needs more than this number of mean steps up to its end.
const FAR: f64 = 1e6;

/// After a measurement that finds the run slow, this number of steps is searched for jumps. [`JUMPS`] of them
/// end the run.
const OBSERVED: u32 = 64;

/// A jump is searched over this number of steps ahead. Where the motion stays on a jump, it lies within one.
const AHEAD: f64 = 4.0;

/// The motion is followed from this distance beyond a jump, to see whether it turns back, as a share of the
/// distance that is searched for the jump `[1]`.
const BEYOND: f64 = 0.01;

/// Number of accelerations that are searched for a jump in one step.
const SEARCHED: usize = 4;

/// Smallest jump, as a share of the acceleration that jumps `[1]`.
const LEAST: f64 = 1e-6;

/// Least effect of a jump on its velocity over the distance searched, as a share of the tolerance `[1]`.
const EFFECT: f64 = 1e-3;

/// A time is too late if its rounding changes a velocity by more than the tolerance in a step of this many
/// times the shortest length.
const FEW: f64 = 32.0;

/// Least change of an acceleration by the rounding of the time, as a share of the largest acceleration `[1]`:
/// well above the rounding of the accelerations themselves.
const OF_TIME: f64 = 1e5 * f64::EPSILON;

/// Number of neighbouring times at which the accelerations are compared. The shortest step contains fewer
/// times. A jump inside it, which no edge announces, therefore changes one of these accelerations.
const NEIGHBOURS: u32 = 64;

/// One rejected step of this many is checked for rounding.
const CHECKED: u32 = 32;

/// The run may end if rounding rejected this many more of the checked steps than other errors did.
const ROUNDED: u32 = 8;

/// It ends if it would need more than this number of rejections up to its end, as far as they came so far.
const MANY: f64 = 65_536.0;

/// Rounding rejects only steps below this share of the longest attempt `[1]`, while the run advances by less
/// than one longest attempt for each rejection.
const OF_LONGEST: f64 = 0.01;

/// Rounding rejects a step if it changes a velocity by more than this share of the tolerance `[1]`.
const OF_TOLERANCE: f64 = 0.5;

/// A coordinate is moved by this many roundings to see what its rounding changes.
const MOVED: f64 = 16.0;

/// Rejected steps of an adaptive run. At a jump of an acceleration, steps are rejected until one is so short
/// that the jump stays within the tolerance. A motion that passes the jump leaves it with longer steps; a
/// motion that stays on it needs such short steps for ever.
pub(crate) struct Rejections {
    /// Longest attempt.
    longest: f64,
    /// Time of the first rejection in the window.
    since: f64,
    /// Number of rejections in the window.
    count: u32,
    /// Number of jumps found in the window.
    jumps: u32,
    /// Time of the last look at the progress of the run.
    looked: f64,
    /// Number of steps that remain to be observed, and of jumps found in the observed ones.
    observed: [u32; 2],
    /// The acceleration that jumps.
    acceleration: usize,
    /// Number of rejections in the run.
    all: u32,
    /// The steps that rounding rejected, less the other checked ones; at least 0.
    rounded: u32,
    /// Start and end of the run.
    run: [f64; 2],
    /// Time of the last check for rounding.
    checked: f64,
    /// Scratch: drives, a state, and the accelerations at three states.
    u: Vec<f64>,
    look: Vec<f64>,
    a: [Vec<f64>; 3],
}

/// A jump ahead of the start of a step.
struct Jump {
    acceleration: usize,
    /// Its place, as a share of the distance that was searched.
    place: f64,
    /// The acceleration on this side of it and beyond.
    sides: [f64; 2],
}

impl Rejections {
    /// `u`: the drives at the start `t`; `components`: length of the state; `first`: length of the first
    /// attempt; `run`: start and end of the run.
    pub(crate) fn new(u: &[f64], components: usize, first: f64, run: [f64; 2]) -> Self {
        let t = run[0];
        let accelerations = || vec![0.0; components / 2];
        Rejections {
            longest: first,
            since: t,
            count: 0,
            jumps: 0,
            looked: t,
            observed: [0; 2],
            acceleration: 0,
            all: 0,
            rounded: 0,
            run,
            checked: t,
            u: u.to_vec(),
            look: vec![0.0; components],
            a: [accelerations(), accelerations(), accelerations()],
        }
    }

    /// One attempt more, accepted or rejected.
    ///
    /// # Errors
    /// [`IntegrateError::Discontinuity`] if the run is slow and most of its steps meet a jump of an
    /// acceleration beyond which the motion turns back.
    #[inline(always)]
    pub(crate) fn attempted<V: Vector>(
        &mut self,
        e: &Engine<'_, V>,
        attempt: u64,
    ) -> Result<(), IntegrateError> {
        if attempt % PERIOD == PERIOD - 1 {
            self.look_at_progress(e.ends.t);
        }
        if self.observed[0] > 0 { self.observe(e) } else { Ok(()) }
    }

    #[cold]
    fn look_at_progress(&mut self, t: f64) {
        let mean = (t - std::mem::replace(&mut self.looked, t)) / PERIOD as f64;
        self.longest = self.longest.max(mean);
        let is_slow = mean < SLOW * self.longest || self.run[1] - t > FAR * mean;
        self.observed = [if is_slow { OBSERVED } else { 0 }, 0];
    }

    #[cold]
    fn observe<V: Vector>(&mut self, e: &Engine<'_, V>) -> Result<(), IntegrateError> {
        self.observed[0] -= 1;
        if let Some(jump) = self.jump(e)
            && self.turns_back(e, &jump)
        {
            self.observed[1] += 1;
            if self.observed[1] == JUMPS {
                return Err(IntegrateError::Discontinuity { t: e.ends.t, acceleration: jump.acceleration });
            }
        }
        Ok(())
    }

    /// The current step was rejected because of its error.
    ///
    /// # Errors
    /// [`IntegrateError::Discontinuity`] if many short steps in a row met a jump of an acceleration beyond
    /// which the motion turns back; [`IntegrateError::BelowRounding`] if rounding rejected most of the steps.
    #[cold]
    pub(crate) fn rejected<V: Vector>(&mut self, e: &Engine<'_, V>) -> Result<(), IntegrateError> {
        let (t, h) = (e.ends.t, e.ends.h());
        self.longest = self.longest.max(h);
        self.all = self.all.wrapping_add(1);
        if self.all.is_multiple_of(CHECKED) {
            self.check_rounding(e)?;
        }
        if self.count == 0 || self.count >= WINDOW || t - self.since > SHORT * self.longest {
            (self.since, self.count, self.jumps) = (t, 0, 0);
        }
        self.count += 1;
        if self.count <= WINDOW / 2 {
            return Ok(());
        }
        if let Some(jump) = self.jump(e)
            && self.turns_back(e, &jump)
        {
            self.jumps += 1;
            self.acceleration = jump.acceleration;
        }
        if self.jumps == JUMPS {
            return Err(IntegrateError::Discontinuity { t, acceleration: self.acceleration });
        }
        Ok(())
    }

    /// The error for a step `h` below the resolution of the time.
    #[cold]
    pub(crate) fn underflow<V: Vector>(&mut self, e: &Engine<'_, V>, h: f64) -> IntegrateError {
        let t = e.ends.t;
        let resolution = f64::EPSILON * t.abs();
        let change = self.change_by_rounding(e, FEW * h.max(resolution));
        if change > 1.0 { IntegrateError::LateTime { t, resolution, change } } else { e.ends.underflow(h) }
    }

    /// The largest effect of the last digit of the time on a velocity at the end of a step `h`, through the
    /// drives, in tolerances.
    fn change_by_rounding<V: Vector>(&mut self, e: &Engine<'_, V>, h: f64) -> f64 {
        let Rejections { u, a: [here, there, _], .. } = self;
        let (t, (q, v)) = (e.ends.t, halves(&e.ends.y));
        let pieces = e.on_fixed_pieces.then_some(&e.ends.pieces[..]);
        let (mut largest, mut time) = (0.0f64, t);
        for neighbour in 0..=NEIGHBOURS {
            std::mem::swap(here, there);
            e.ends.model.redrive(&[time], Side::After, u);
            accelerate(e.ends.model, pieces, u, q, v, here);
            if neighbour > 0 {
                let least = OF_TIME * here.iter().fold(0.0, |m: f64, a| m.max(a.abs()));
                let rows = here.iter().zip(&*there).map(|(a, b)| (a - b).abs()).enumerate();
                let changes = rows.filter(|(_, change)| *change > least);
                let shares = changes.map(|(i, change)| h * change / tolerance(e, i));
                largest = shares.fold(largest, f64::max);
            }
            time = time.next_up();
        }
        largest
    }

    /// Checks whether rounding of the coordinates or of the time rejected the current step.
    fn check_rounding<V: Vector>(&mut self, e: &Engine<'_, V>) -> Result<(), IntegrateError> {
        let (t, h) = (e.ends.t, e.ends.h());
        let advanced = t - std::mem::replace(&mut self.checked, t);
        let is_slow = h < OF_LONGEST * self.longest && advanced < f64::from(CHECKED) * self.longest;
        let found = if is_slow { self.rounding(e, h) } else { None };
        let change = if is_slow && found.is_none() { self.change_by_rounding(e, h) } else { 0.0 };
        let by_rounding = found.is_some() || change > OF_TOLERANCE;
        self.rounded = if by_rounding { self.rounded + 1 } else { self.rounded.saturating_sub(1) };
        let [start, end] = self.run;
        let is_long = f64::from(self.all) * (end - start) > MANY * (t - start);
        if !(by_rounding && self.rounded >= ROUNDED && is_long) {
            return Ok(());
        }
        Err(match found {
            Some((velocity, rounding, tolerance)) => {
                IntegrateError::BelowRounding { t, velocity, rounding, tolerance }
            }
            None => IntegrateError::LateTime { t, resolution: f64::EPSILON * t.abs(), change },
        })
    }

    /// The velocity that rounding of the coordinates changes most in a step `h`, relative to its tolerance:
    /// its index, the change and the tolerance. `None` if the change is far below the tolerance.
    fn rounding<V: Vector>(&mut self, e: &Engine<'_, V>, h: f64) -> Option<(usize, f64, f64)> {
        let n = e.ends.y.slice().len() / 2;
        let changes = self.changes_by_rounding(e, n);
        let shares = changes.iter().enumerate().map(|(i, change)| (i, h * change / MOVED, tolerance(e, i)));
        let most = shares.max_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2)))?;
        (most.1 > OF_TOLERANCE * most.2).then_some(most)
    }

    /// The changes of the accelerations when each of the first `count` components of the state moves by
    /// [`MOVED`] roundings.
    fn changes_by_rounding<V: Vector>(&mut self, e: &Engine<'_, V>, count: usize) -> &[f64] {
        let Rejections { look, a: [here, there, changes], .. } = self;
        let pieces = e.on_fixed_pieces.then_some(&e.ends.pieces[..]);
        let (n, u) = (here.len(), e.ends.nodes.end());
        look.copy_from_slice(e.ends.y.slice());
        let at = |look: &[f64], a: &mut [f64]| {
            let (q, v) = look.split_at(n);
            accelerate(e.ends.model, pieces, u, q, v, a);
        };
        at(look, here);
        changes.fill(0.0);
        for j in 0..count {
            let y = look[j];
            look[j] = y * (1.0 + MOVED * f64::EPSILON);
            at(look, there);
            look[j] = y;
            changes.iter_mut().zip(here.iter().zip(&*there)).for_each(|(c, (a, b))| *c += (a - b).abs());
        }
        changes
    }

    /// An acceleration that jumps ahead of the start of the step. The search takes the accelerations that
    /// change most as a share of their own values.
    fn jump<V: Vector>(&mut self, e: &Engine<'_, V>) -> Option<Jump> {
        let mut most = f64::INFINITY;
        for _ in 0..SEARCHED {
            let (found, share) = self.jump_below(e, most)?;
            most = share;
            // Far from 0 the state is rounded so coarsely that accelerations move in jumps. One that is 0 by
            // the symmetry of a model consists of the rounding of the others.
            let rounding = largest(self.changes_by_rounding(e, e.ends.y.slice().len()));
            if let Some(jump) = found.filter(|j| (j.sides[1] - j.sides[0]).abs() > rounding) {
                return Some(jump);
            }
        }
        None
    }

    /// Of the accelerations that change by less than the share `most`, the one that changes most: its jump
    /// and its share.
    fn jump_below<V: Vector>(&mut self, e: &Engine<'_, V>, most: f64) -> Option<(Option<Jump>, f64)> {
        let Rejections { look, a: [low, high, middle], .. } = self;
        let (y, pieces) = (e.ends.y.slice(), e.on_fixed_pieces.then_some(&e.ends.pieces[..]));
        let ((q, v), u, ahead) = (halves(&e.ends.y), e.ends.nodes.end(), AHEAD * e.ends.h());
        accelerate(e.ends.model, pieces, u, q, v, low);
        let mut at = |share: f64, low: &[f64], a: &mut [f64]| {
            let rates = v.iter().chain(low);
            for (look, (y, rate)) in look.iter_mut().zip(y.iter().zip(rates)) {
                *look = y + share * ahead * rate;
            }
            let (q, v) = look.split_at(look.len() / 2);
            accelerate(e.ends.model, pieces, u, q, v, a);
        };
        at(1.0, low, high);
        if !low.iter().chain(high.iter()).all(|a| a.is_finite()) {
            return None;
        }
        let change = |i: usize| (high[i] - low[i]).abs();
        let share = |i: usize| change(i) / low[i].abs().max(high[i].abs());
        let shortens = |i: usize| ahead * change(i) > EFFECT * tolerance(e, i);
        let candidates = (0..low.len()).filter(|&i| share(i) > LEAST && share(i) < most && shortens(i));
        let i = candidates.max_by(|&i, &j| share(i).total_cmp(&share(j)))?;
        let found = jump([low[i], high[i]], |share| {
            at(share, low, middle);
            middle[i]
        });
        Some((found.map(|(place, sides)| Jump { acceleration: i, place, sides }), share(i)))
    }

    /// Follows the motion past a jump, over the distance searched. Returns `true` if it comes back to the
    /// side from which it came: it sticks or slides. A motion that crosses the jump stays beyond it.
    fn turns_back<V: Vector>(&mut self, e: &Engine<'_, V>, jump: &Jump) -> bool {
        let Rejections { look, a: [a, ..], .. } = self;
        let (y, pieces) = (e.ends.y.slice(), e.on_fixed_pieces.then_some(&e.ends.pieces[..]));
        let (n, u) = (a.len(), e.ends.nodes.end());
        look.copy_from_slice(y);
        for share in [jump.place + BEYOND, 1.0] {
            let (q, v) = look.split_at_mut(n);
            accelerate(e.ends.model, pieces, u, q, v, a);
            let time = share * AHEAD * e.ends.h();
            let rows = q.iter_mut().zip(v.iter().zip(&*a));
            rows.for_each(|(q, (v, a))| *q += time * (v + 0.5 * time * a));
            v.iter_mut().zip(&*a).for_each(|(v, a)| *v += time * a);
        }
        let (q, v) = look.split_at(n);
        accelerate(e.ends.model, pieces, u, q, v, a);
        let [before, after] = jump.sides.map(|side| (a[jump.acceleration] - side).abs());
        before < after
    }
}

/// The tolerance of velocity `i` in a step.
fn tolerance<V: Vector>(e: &Engine<'_, V>, i: usize) -> f64 {
    let (y, atol) = (e.ends.y.slice(), e.ends.atol.slice());
    let component = y.len() / 2 + i;
    atol[component] + e.rtol * y[component].abs()
}
