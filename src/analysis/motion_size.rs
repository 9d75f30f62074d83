//! Ranges of motion and rounding errors of coordinates and velocities: the units of distances, corrections,
//! differences and errors.

use crate::contact::Piece;
use crate::model::structure::drifts::Drifts;
use crate::model::structure::sizing::Sizing;
use crate::model::{Model, State};
use crate::numeric::norms::remove;
use crate::ode::{Observer, Step};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Minimum, maximum and size of every coordinate and velocity over a motion, without drifts.
///
/// The unit of component i at a tolerance τ is max(range_i, k ε/τ size_i), with range_i = max - min, ε =
/// 2.2e-16 and the number k of rounding errors: a difference of τ units is then above rounding. The size is
/// the sum of the terms of which the component is made ([`Sizing`]). A component that rests because its terms
/// cancel, such as the difference of two equal planets, has no range, and its size is that of the terms.
pub(crate) struct MotionSize {
    drifts: Drifts,
    y: Vec<f64>,
    /// A state inside a step.
    inside: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    sizes: Vec<f64>,
    /// Number of steps, or of their parts.
    pub(crate) steps: usize,
    /// Whether the last step ended in a rebound.
    rebounded: bool,
    /// Steps that show each piece of each contact in this period. The first `used` count; the others are
    /// memory for the next ones.
    kept: Vec<Kept>,
    used: usize,
    /// Pieces and length of the last step.
    ended: (Vec<Piece>, f64),
    /// First and last time.
    first: f64,
    last: f64,
}

/// The end of a step, the pieces of its contacts, and its length.
struct Kept {
    pieces: Vec<Piece>,
    step: f64,
    state: State,
}

/// Number of rounding errors in an error estimate of a step, a sum over a dozen evaluations.
const OF_A_STEP: f64 = 16.0;

/// Least number of rounding errors in the distance of two states a period apart.
const OF_A_PERIOD: f64 = 64.0;

/// Number of rounding errors in that distance, over the root of the number of steps: errors of steps add up
/// at random.
const OF_STEPS: f64 = 4.0;

/// Number of steps over which errors of accelerations add up in a motion: 1/ω of its slow elastic modes,
/// which are some thirty times slower than the step follows.
const ADDED: f64 = 32.0;

/// A range below this share of the size counts as rest `[1]` beside others that are far larger: a coarse run,
/// with tolerance 1e-9, does not resolve it.
const SEEN: f64 = 1e-9;

/// Such a range is below this share of the largest range of all coordinates, or of all velocities `[1]`.
const BESIDE: f64 = 1e-6;

/// A component is at rest if its range is at most this number of rounding errors of a period. The rounding
/// errors of several periods add up in a range.
const OF_REST: f64 = 16.0;

impl MotionSize {
    /// If rigid motions leave no relative motion, no drift is removed.
    pub(crate) fn new(dof: usize, drifts: &Drifts) -> Self {
        let m = 2 * dof;
        MotionSize {
            drifts: if drifts.speeds.len() < dof { drifts.clone() } else { Drifts::default() },
            y: vec![0.0; m],
            inside: vec![0.0; m],
            low: vec![f64::INFINITY; m],
            high: vec![f64::NEG_INFINITY; m],
            sizes: vec![0.0; m],
            steps: 0,
            rebounded: false,
            kept: Vec::new(),
            used: 0,
            ended: (Vec::new(), 0.0),
            first: f64::INFINITY,
            last: f64::NEG_INFINITY,
        }
    }

    /// An observer that adds the steps of a run.
    pub(crate) fn along<'s, 'm>(&'s mut self, model: &'m dyn Model) -> Along<'s, 'm> {
        Along { motion: self, sizing: Sizing::new(model) }
    }

    /// Adds a state.
    pub(crate) fn see(&mut self, t: f64, q: &[f64], v: &[f64]) {
        (self.first, self.last) = (self.first.min(t), self.last.max(t));
        let n = q.len();
        self.y[..n].copy_from_slice(q);
        self.y[n..].copy_from_slice(v);
        self.sizes.iter_mut().zip(&self.y).for_each(|(size, y)| *size = size.max(y.abs()));
        let (of_q, of_v) = self.sizes.split_at_mut(n);
        for ((directions, half), part) in self.drifts.halves().into_iter().zip([of_q, of_v]).zip([q, v]) {
            // y - r (rᵀ y) has the terms of the sum rᵀ y as well.
            for r in directions {
                let sum: f64 = r.iter().zip(part).map(|(r, y)| (r * y).abs()).sum();
                half.iter_mut().zip(r).for_each(|(size, r)| *size = size.max(r.abs() * sum));
            }
        }
        self.relative();
        for ((y, low), high) in self.y.iter().zip(&mut self.low).zip(&mut self.high) {
            *low = low.min(*y);
            *high = high.max(*y);
        }
    }

    /// Adds the end of a step, and its start if the velocities have jumped there.
    pub(crate) fn see_step(&mut self, step: &Step<'_>) {
        let rebounds = step.crossings().iter().any(|crossing| crossing.rebounds);
        if std::mem::replace(&mut self.rebounded, rebounds) {
            self.see(step.t0(), step.q0(), step.v0());
        }
        self.see(step.t1(), step.q1(), step.v1());
    }

    /// The sizes of coordinates and velocities.
    pub(crate) fn sizes(&self) -> &[f64] {
        &self.sizes
    }
    /// Raises the sizes to those of another period.
    pub(crate) fn weigh(&mut self, sizes: &[f64]) {
        raise(&mut self.sizes, sizes);
    }

    /// Keeps a step for [`weigh_kept`](MotionSize::weigh_kept) if it is the first one that shows a contact on
    /// some piece. A longer step with the same pieces takes its place. `t`, `q`, `v`: end of the step;
    /// `step`: its length, or that of its parts; `pieces`: empty for a model without contacts.
    pub(crate) fn keep(&mut self, pieces: &[Piece], step: f64, t: f64, q: &[f64], v: &[f64]) {
        self.ended.0.clear();
        self.ended.0.extend(pieces);
        self.ended.1 = step;
        let used = &mut self.kept[..self.used];
        let index = match used.iter().position(|kept| kept.pieces == pieces) {
            Some(same) if used[same].step >= step => return,
            Some(same) => same,
            None => {
                let known =
                    |i: usize, piece: &Piece| used.iter().any(|kept| kept.pieces.get(i) == Some(piece));
                if self.used > 0 && pieces.iter().enumerate().all(|(i, piece)| known(i, piece)) {
                    return;
                }
                self.used += 1;
                self.used - 1
            }
        };
        if index == self.kept.len() {
            self.kept.push(Kept { pieces: pieces.to_vec(), step, state: State::new(t, q, v) });
            return;
        }
        let kept = &mut self.kept[index];
        kept.pieces.clear();
        kept.pieces.extend(pieces);
        (kept.step, kept.state.t) = (step, t);
        kept.state.q.copy_from_slice(q);
        kept.state.v.copy_from_slice(v);
    }

    /// Adds the sizes at the ends of the kept steps and at the `end` of the motion, each on the pieces of its
    /// step and over the length of this step: steps on a hard flank are far shorter than those in the gap.
    /// The last step may be cut short: the longest one on its pieces counts in its place.
    pub(crate) fn weigh_kept(&mut self, model: &dyn Model, end: &State) {
        let (mut sizing, on_pieces) = (Sizing::new(model), model.offers().pieces);
        let mut add = |pieces: &[Piece], State { t, q, v }: &State, step: f64| {
            let pieces = (on_pieces && pieces.len() == model.contacts()).then_some(pieces);
            raise(&mut self.sizes, sizing.over(pieces, *t, q, v, [step, ADDED * step]));
        };
        let (kept, (pieces, last)) = (&self.kept[..self.used], &self.ended);
        let same = kept.iter().find(|kept| !pieces.is_empty() && kept.pieces == *pieces);
        add(pieces, end, same.map_or(*last, |kept| kept.step));
        kept.iter().for_each(|Kept { pieces, step, state }| add(pieces, state, *step));
    }

    /// y ← y - Σ_r r (rᵀ y), for coordinates and velocities: removes drifts.
    fn relative(&mut self) {
        let (q, v) = self.y.split_at_mut(self.low.len() / 2);
        for (directions, half) in self.drifts.halves().into_iter().zip([q, v]) {
            directions.iter().for_each(|r| remove(r, half));
        }
    }

    /// Begins a period: halves every range about its middle, so that transients lose their weight, and
    /// forgets the sizes, because the rounding errors of earlier periods are not in this one.
    pub(crate) fn fade(&mut self) {
        self.used = 0;
        self.sizes.fill(0.0);
        for (low, high) in self.low.iter_mut().zip(&mut self.high) {
            let middle = 0.5 * (*low + *high);
            if middle.is_finite() {
                (*low, *high) = (middle - 0.25 * (*high - *low), middle + 0.25 * (*high - *low));
            }
        }
    }

    /// Range (max - min) of each coordinate, then of each velocity.
    ///
    /// A component is at rest if its range is some rounding errors of a period, or if it is below 1e-9 of its
    /// size and below 1e-6 of the largest range of all coordinates, or of all velocities. It gets its size,
    /// but not more than that largest range. If both are 0, a coordinate gets the value 1, a velocity 2π
    /// (range of its coordinate)/(observed time).
    pub(crate) fn ranges(&self) -> Vec<f64> {
        let (n, rounding) = (self.low.len() / 2, OF_REST * self.rounding());
        let positive = |x: f64| (x > 0.0 && x.is_finite()).then_some(x);
        let seen =
            |i: usize| Some(self.high[i] - self.low[i]).filter(|range| *range > rounding * self.sizes[i]);
        let largest = |part: std::ops::Range<usize>| positive(part.filter_map(seen).fold(0.0, f64::max));
        let most = [largest(0..n), largest(n..2 * n)];
        let range = |i: usize| {
            let beside = BESIDE * most[i / n].unwrap_or(0.0);
            seen(i).filter(|range| *range > beside || *range > SEEN * self.sizes[i]).unwrap_or(0.0)
        };
        let of = |i: usize, largest: Option<f64>, other: f64| {
            let at_rest = || match (positive(self.sizes[i]), largest) {
                (Some(size), Some(largest)) => size.min(largest),
                (size, largest) => size.or(largest).unwrap_or(other),
            };
            positive(range(i)).unwrap_or_else(at_rest)
        };
        let [of_q, of_v] = most;
        let q: Vec<f64> = (0..n).map(|i| of(i, of_q, 1.0)).collect();
        let span = self.last - self.first;
        let rate = |i: usize| if span > 0.0 { TAU * q[i] / span } else { q[i] };
        let v: Vec<f64> = (0..n).map(|i| of(n + i, of_v, rate(i))).collect();
        [q, v].concat()
    }

    /// Units of coordinates and velocities for a flow with `tolerance`.
    pub(crate) fn units(&self, tolerance: f64) -> Vec<f64> {
        let share = OF_A_STEP * f64::EPSILON / tolerance.max(f64::EPSILON);
        self.ranges().iter().zip(&self.sizes).map(|(range, size)| range.max(share * size)).collect()
    }

    /// max_i |Δy_i|/unit_i at a tolerance, with Δy = a - b without drifts. The states are coordinates,
    /// then velocities. As a share of its range a velocity is not better known than its coordinate.
    pub(crate) fn distance(&mut self, a: &[f64], b: &[f64], tolerance: f64) -> f64 {
        let (n, share) = (self.low.len() / 2, self.rounding() / tolerance);
        self.apart(a, b, |motion, i| {
            let range = |i: usize| motion.high[i] - motion.low[i];
            let rounded = |i: usize| share * motion.sizes[i];
            let of_coordinate = match i.checked_sub(n).filter(|q| range(*q) > 0.0) {
                Some(q) => rounded(q) / range(q) * range(i),
                None => 0.0,
            };
            range(i).max(rounded(i)).max(of_coordinate)
        })
    }

    /// max_i |Δy_i|/range_i with the [ranges](MotionSize::ranges), as [`distance`](MotionSize::distance).
    pub(crate) fn change(&mut self, a: &[f64], b: &[f64]) -> f64 {
        let ranges = self.ranges();
        self.apart(a, b, |_, i| ranges[i])
    }

    /// Rounding error in the distance of two states a period apart, as a share of the size.
    fn rounding(&self) -> f64 {
        f64::EPSILON * OF_A_PERIOD.max(OF_STEPS * (self.steps as f64).sqrt())
    }

    fn apart(&mut self, a: &[f64], b: &[f64], unit: impl Fn(&Self, usize) -> f64) -> f64 {
        self.y.iter_mut().zip(a.iter().zip(b)).for_each(|(y, (a, b))| *y = a - b);
        self.relative();
        self.y.iter().enumerate().fold(0.0, |worst: f64, (i, apart)| {
            // A NaN gives an infinite distance.
            let apart = if *apart == 0.0 { 0.0 } else { apart.abs() / unit(self, i) };
            if apart.is_nan() { f64::INFINITY } else { worst.max(apart) }
        })
    }
}

/// Raises sizes to others.
fn raise(sizes: &mut [f64], others: &[f64]) {
    sizes.iter_mut().zip(others).for_each(|(size, other)| *size = size.max(*other));
}

/// Observer that adds the states and sizes of every step of a run to a [`MotionSize`].
pub(crate) struct Along<'s, 'm> {
    motion: &'s mut MotionSize,
    sizing: Sizing<'m>,
}

impl Observer for Along<'_, '_> {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        let motion = &mut *self.motion;
        // Inside a step of high order the parts show the range.
        let parts = step.parts();
        motion.steps += parts;
        for part in 1..parts {
            let t = step.part(part).0;
            let mut y = std::mem::take(&mut motion.inside);
            step.at(t, &mut y);
            let (q, v) = y.split_at(y.len() / 2);
            motion.see(t, q, v);
            motion.inside = y;
        }
        motion.see_step(step);
        // At an edge the differences of a model without slopes would mix two pieces.
        if step.crossings().is_empty() {
            // A step of high order is as accurate as shorter steps, one for each of its parts.
            let (from, to) = step.part(0);
            motion.weigh(self.sizing.at(step.pieces(), step.t1(), step.q1(), step.v1(), to - from));
        }
        ControlFlow::Continue(())
    }
}
