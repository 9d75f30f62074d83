//! The Taylor coefficients of all lanes, order by order.
#![allow(
    clippy::needless_range_loop,
    reason = "index loops over arrays become vector instructions, iterators do not"
)]

use crate::contact::Piece;
use crate::contact::piece::alternative;
use crate::ode::taylor::expansion::coefficients::{ORDERS, PER};
use crate::scalar::Scalar;
use crate::sweep::lanes::number::Lanes;
use crate::sweep::taylor::program::{Place, Program, Rule};

/// Number of runs side by side: that of the doubles in the widest vector registers.
pub(crate) const W: usize = 8;

/// Room for the coefficients of a column. An odd number: the same order of several columns does not compete
/// for the same lines of the cache.
const ROOM: usize = ORDERS + 1;

/// The numbers of all columns in all lanes.
pub(crate) struct Columns {
    /// Column by column, order by order.
    x: Vec<Lanes<W>>,
    /// For each product what is known of its next coefficient, which is an odd one.
    begun: Vec<Lanes<W>>,
    stills: Vec<Lanes<W>>,
    /// For each selector and each of its alternatives all bits in the lanes that stand on it.
    masks: Vec<Vec<[u64; W]>>,
    /// Highest order.
    pub(super) degree: usize,
    /// Scratch: the still numbers of one lane.
    of_lane: Vec<f64>,
}

impl Columns {
    pub(super) fn new(program: &Program, degree: usize) -> Self {
        let zero = Lanes::from(0.0);
        let masks = program.selectors.iter().map(|(_, count)| vec![[0; W]; 3usize.pow(*count as u32)]);
        Columns {
            x: vec![zero; ROOM * program.columns],
            begun: vec![zero; program.products],
            stills: vec![zero; program.stills.len()],
            masks: masks.collect(),
            degree,
            of_lane: vec![0.0; program.stills.len()],
        }
    }

    /// Coefficient n of a column.
    #[inline(always)]
    pub(super) fn at(&self, column: usize, n: usize) -> &Lanes<W> {
        &self.x[column * ROOM + n]
    }
    #[inline(always)]
    pub(super) fn at_mut(&mut self, column: usize, n: usize) -> &mut Lanes<W> {
        &mut self.x[column * ROOM + n]
    }

    /// Takes the pieces of a lane, and the numbers that follow from them and from the drives of its model.
    pub(super) fn set_lane(&mut self, program: &Program, lane: usize, drives: &[f64], pieces: &[Piece]) {
        for (masks, (contact, count)) in self.masks.iter_mut().zip(&program.selectors) {
            let chosen = alternative(pieces, *contact, *count);
            masks.iter_mut().enumerate().for_each(|(i, mask)| mask[lane] = if i == chosen { !0 } else { 0 });
        }
        program.stills.write(drives, pieces, &program.selectors, &mut self.of_lane);
        self.stills.iter_mut().zip(&self.of_lane).for_each(|(still, value)| still.0[lane] = *value);
    }

    /// Computes all orders from coordinates and velocities of order 0 and the waves of all orders.
    #[inline(always)]
    pub(super) fn expand(&mut self, program: &Program) {
        for i in 0..program.dof {
            *self.at_mut(i, 1) = *self.at(program.dof + i, 0);
        }
        self.order::<true, false>(program, 0);
        for n in 1..self.degree {
            self.order::<false, false>(program, n);
        }
        // Distances and channels have one order more than the accelerations.
        self.order::<false, true>(program, self.degree);
    }

    /// Evaluates order n of the instructions, and from the accelerations order n + 1 of the velocities and
    /// order n + 2 of the coordinates; with LATE only the instructions that distances and channels need.
    #[inline(always)]
    fn order<const FIRST: bool, const LATE: bool>(&mut self, program: &Program, n: usize) {
        let Columns { x, begun, stills, masks, .. } = self;
        for instruction in &program.instructions {
            if LATE && !instruction.late {
                continue;
            }
            let at = |column: usize, n: usize| x[column * ROOM + n];
            let out = instruction.out;
            let value = match &instruction.rule {
                Rule::Sum { like: Some((column, factor)), .. } if !FIRST => at(*column, n) * *factor,
                Rule::Sum { columns, stills: constants, constant, .. } => {
                    // Two sums that do not wait for one another.
                    let constant = if FIRST { *constant } else { 0.0 };
                    let [mut sum, mut other] = [Lanes::from(constant), Lanes::from(0.0)];
                    if FIRST {
                        for (still, weight) in constants {
                            sum = sum + stills[*still] * *weight;
                        }
                    }
                    let (pairs, last) = columns.as_chunks::<2>();
                    for [(a, w), (b, z)] in pairs {
                        sum = sum + at(*a, n) * *w;
                        other = other + at(*b, n) * *z;
                    }
                    if let [(a, w)] = last {
                        sum = sum + at(*a, n) * *w;
                    }
                    sum + other
                }
                Rule::Product { a, b, place } => {
                    let [a, b] = [a, b].map(|column| &x[column * ROOM..][..=n]);
                    if n.is_multiple_of(2) {
                        let [sum, next] = sums(&a[1..], &b[..n], b[n]);
                        begun[*place] = next;
                        sum + a[0] * b[n]
                    } else {
                        begun[*place] + (a[0] * b[n] + a[n] * b[0])
                    }
                }
                Rule::Scaled(still, a) => stills[*still] * at(*a, n),
                Rule::Choice { selector, among } => {
                    let mut bits = [0; W];
                    for (mask, place) in masks[*selector].iter().zip(among) {
                        let value = match place {
                            Place::Column(column) => at(*column, n),
                            Place::Still(still) if FIRST => stills[*still],
                            Place::Still(_) => continue,
                        };
                        for l in 0..W {
                            bits[l] |= value.0[l].to_bits() & mask[l];
                        }
                    }
                    Lanes(bits.map(f64::from_bits))
                }
                Rule::Quotient(a, b) => {
                    let mut rest = order_of::<FIRST>(*a, n, x, stills);
                    for j in 0..n {
                        rest = rest - at(out, j) * at(*b, n - j);
                    }
                    rest / at(*b, 0)
                }
                Rule::Exp(a) if FIRST => at(*a, 0).exp(),
                Rule::Exp(a) => {
                    let mut sum = at(*a, n) * n as f64 * at(out, 0);
                    for j in 1..n {
                        sum = sum + at(*a, j) * j as f64 * at(out, n - j);
                    }
                    sum * PER[n]
                }
                Rule::Ln(a) if FIRST => at(*a, 0).ln(),
                Rule::Ln(a) => {
                    let mut sum = Lanes::from(0.0);
                    for j in 1..n {
                        sum = sum + at(out, j) * j as f64 * at(*a, n - j);
                    }
                    (at(*a, n) - sum * PER[n]) / at(*a, 0)
                }
                Rule::SinCos(a) => {
                    let (sine, cosine) = if FIRST {
                        at(*a, 0).sin_cos()
                    } else {
                        let newest = at(*a, n) * n as f64;
                        let mut sums = [1, 0].map(|k| newest * at(out + k, 0));
                        for j in 1..n {
                            let a = at(*a, j) * j as f64;
                            sums[0] = sums[0] + a * at(out + 1, n - j);
                            sums[1] = sums[1] + a * at(out, n - j);
                        }
                        (sums[0] * PER[n], sums[1] * -PER[n])
                    };
                    x[(out + 1) * ROOM + n] = cosine;
                    sine
                }
            };
            x[out * ROOM + n] = value;
        }
        if LATE {
            return;
        }
        for (i, place) in program.accelerations.iter().enumerate() {
            let v = order_of::<FIRST>(*place, n, x, stills) * PER[n + 1];
            x[(program.dof + i) * ROOM + n + 1] = v;
            x[i * ROOM + n + 2] = v * PER[n + 2];
        }
    }

    /// Value of a column at the time `s` of each lane.
    #[inline(always)]
    pub(super) fn value(&self, column: usize, s: &Lanes<W>) -> Lanes<W> {
        let c = &self.x[column * ROOM..][..ROOM];
        // Even and odd orders apart: the sums do not wait for one another. Order `degree + 1` is not used.
        let (square, [mut even, mut odd]) = (*s * *s, [Lanes::from(0.0); 2]);
        let mut n = self.degree - self.degree % 2;
        if n < self.degree {
            odd = c[n + 1];
        }
        while n > 0 {
            even = even * square + c[n];
            odd = odd * square + c[n - 1];
            n -= 2;
        }
        // The value at the start is added last: one rounding error of its size.
        c[0] + (even * square + odd * *s)
    }

    /// Bounds of c(t) - c(0) for a column c at the times t in [0, s]: the smallest and the largest of 0 and
    /// of the sums S_k = Σ_(n=1..k) c_n sⁿ. With θ = t/s it is Σ_(k<N) S_k (θᵏ - θᵏ⁺¹) + S_N θᴺ, a mean of
    /// these numbers.
    #[inline(always)]
    pub(super) fn bounds(&self, column: usize, s: &Lanes<W>) -> [Lanes<W>; 2] {
        let (mut moved, mut power) = (Moved::new(), *s);
        for c in &self.x[column * ROOM..][1..=self.degree] {
            moved.add(*c * power);
            power = power * *s;
        }
        moved.bounds
    }
}

/// The sum of terms so far, and the smallest and the largest of all sums before.
pub(super) struct Moved {
    sum: Lanes<W>,
    pub(super) bounds: [Lanes<W>; 2],
}

impl Moved {
    #[inline(always)]
    pub(super) fn new() -> Self {
        let zero = Lanes::from(0.0);
        Moved { sum: zero, bounds: [zero; 2] }
    }
    #[inline(always)]
    pub(super) fn add(&mut self, term: Lanes<W>) {
        let Moved { sum, bounds: [low, high] } = self;
        *sum = *sum + term;
        for l in 0..W {
            low.0[l] = if sum.0[l] < low.0[l] { sum.0[l] } else { low.0[l] };
            high.0[l] = if sum.0[l] > high.0[l] { sum.0[l] } else { high.0[l] };
        }
    }
}

/// Order n of a number. `FIRST`: whether n is 0.
#[inline(always)]
fn order_of<const FIRST: bool>(place: Place, n: usize, x: &[Lanes<W>], stills: &[Lanes<W>]) -> Lanes<W> {
    match place {
        Place::Column(column) => x[column * ROOM + n],
        Place::Still(still) if FIRST => stills[still],
        Place::Still(_) => Lanes::from(0.0),
    }
}

/// Σ a_j b_(m-j) and Σ a_j b_(m-j+1) over all j of `a`, which is as long as `b`; m is the last place of `b`
/// and `beyond` the number after it.
#[inline(always)]
pub(super) fn sums(a: &[Lanes<W>], b: &[Lanes<W>], beyond: Lanes<W>) -> [Lanes<W>; 2] {
    // Two orders together: each number is read once. Four sums that do not wait for one another.
    let ([mut sum, mut next, mut other, mut next_other], mut after) = ([Lanes::from(0.0); 4], beyond);
    let ((pairs, last), (first, reversed)) = (a.as_chunks::<2>(), b.as_rchunks::<2>());
    for ([a, c], [d, b]) in pairs.iter().zip(reversed.iter().rev()) {
        sum = sum + *a * *b;
        next = next + *a * after;
        other = other + *c * *d;
        next_other = next_other + *c * *b;
        after = *d;
    }
    if let ([a], [b]) = (last, first) {
        sum = sum + *a * *b;
        next = next + *a * after;
    }
    [sum + other, next + next_other]
}

/// Σ term(a_n, b_n, lane), in each lane.
#[inline(always)]
pub(super) fn weighted_sum<A, B>(a: &[A], b: &[B], term: impl Fn(&A, &B, usize) -> f64) -> Lanes<W> {
    // Four sums that do not wait for one another.
    let mut sums = [[0.0; W]; 4];
    let ((fours, rest), (others, last)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    for (a, b) in fours.iter().zip(others) {
        for k in 0..4 {
            for l in 0..W {
                sums[k][l] += term(&a[k], &b[k], l);
            }
        }
    }
    for (a, b) in rest.iter().zip(last) {
        for l in 0..W {
            sums[0][l] += term(a, b, l);
        }
    }
    let mut sum = [0.0; W];
    for l in 0..W {
        sum[l] = (sums[0][l] + sums[1][l]) + (sums[2][l] + sums[3][l]);
    }
    Lanes(sum)
}
