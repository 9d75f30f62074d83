//! The Taylor coefficients of all lanes, order by order.
#![allow(
    clippy::needless_range_loop,
    reason = "index loops over arrays become vector instructions, iterators do not"
)]

use crate::contact::Piece;
use crate::ode::taylor::expansion::coefficients::{ORDERS, PER};
use crate::ode::taylor::expansion::plan::alternative;
use crate::scalar::Scalar;
use crate::sweep::lanes::number::Lanes;
use crate::sweep::taylor::program::{Place, Program, Rule};

/// The factors of a product so far: those of the first one, and in reversed order those of the second one.
struct Factors<const W: usize>([[Lanes<W>; ORDERS]; 2]);

impl<const W: usize> Factors<W> {
    /// Σ a_j b_(n-j), after the coefficients of order n are added.
    #[inline(always)]
    fn product(&mut self, n: usize, newest: [Lanes<W>; 2]) -> Lanes<W> {
        let [a, b] = &mut self.0;
        let first = ORDERS - 1 - n;
        (a[n], b[first]) = (newest[0], newest[1]);
        weighted_sum(&a[..=n], &b[first..], |a, b, l| a.0[l] * b.0[l])
    }
}

/// The numbers of all columns in all lanes.
pub(crate) struct Columns<const W: usize> {
    /// Order by order, column by column.
    x: Vec<Lanes<W>>,
    /// From one order to the next.
    stride: usize,
    factors: Vec<Factors<W>>,
    stills: Vec<Lanes<W>>,
    /// For each selector and each of its alternatives all bits in the lanes that stand on it.
    masks: Vec<Vec<[u64; W]>>,
    /// Highest order.
    pub(super) degree: usize,
    /// Scratch: the still numbers of one lane.
    of_lane: Vec<f64>,
}

impl<const W: usize> Columns<W> {
    pub(super) fn new(program: &Program, degree: usize) -> Self {
        let zero = Lanes::from(0.0);
        let masks = program.selectors.iter().map(|(_, count)| vec![[0; W]; 3usize.pow(*count as u32)]);
        // An odd stride: the orders of a column do not compete for the same lines of the cache.
        let stride = program.columns | 1;
        Columns {
            x: vec![zero; stride * ORDERS],
            stride,
            factors: (0..program.products).map(|_| Factors([[zero; ORDERS]; 2])).collect(),
            stills: vec![zero; program.stills.len()],
            masks: masks.collect(),
            degree,
            of_lane: vec![0.0; program.stills.len()],
        }
    }

    /// Coefficient n of a column.
    #[inline(always)]
    pub(super) fn at(&self, column: usize, n: usize) -> &Lanes<W> {
        &self.x[n * self.stride + column]
    }
    #[inline(always)]
    pub(super) fn at_mut(&mut self, column: usize, n: usize) -> &mut Lanes<W> {
        &mut self.x[n * self.stride + column]
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
        let Columns { x, stride, factors, stills, masks, .. } = self;
        let (before, rest) = x.split_at_mut(n * *stride);
        let (row, after) = rest.split_at_mut(*stride);
        for instruction in &program.instructions {
            if LATE && !instruction.late {
                continue;
            }
            let earlier = |column: usize, n: usize| before[n * *stride + column];
            let value = match &instruction.rule {
                Rule::Sum { like: Some((column, factor)), .. } if !FIRST => row[*column] * *factor,
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
                        sum = sum + row[*a] * *w;
                        other = other + row[*b] * *z;
                    }
                    if let [(a, w)] = last {
                        sum = sum + row[*a] * *w;
                    }
                    sum + other
                }
                Rule::Product { a, b, place } => factors[*place].product(n, [row[*a], row[*b]]),
                Rule::Scaled(still, a) => stills[*still] * row[*a],
                Rule::Choice { selector, among } => {
                    let mut bits = [0; W];
                    for (mask, place) in masks[*selector].iter().zip(among) {
                        let value = match place {
                            Place::Column(column) => row[*column],
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
                    let mut rest = order_of::<FIRST, W>(*a, row, stills);
                    for j in 0..n {
                        let of_b = if j == 0 { row[*b] } else { earlier(*b, n - j) };
                        rest = rest - earlier(instruction.out, j) * of_b;
                    }
                    rest / if FIRST { row[*b] } else { earlier(*b, 0) }
                }
                Rule::Exp(a) if FIRST => row[*a].exp(),
                Rule::Exp(a) => {
                    let mut sum = row[*a] * n as f64 * earlier(instruction.out, 0);
                    for j in 1..n {
                        sum = sum + earlier(*a, j) * j as f64 * earlier(instruction.out, n - j);
                    }
                    sum * PER[n]
                }
                Rule::Ln(a) if FIRST => row[*a].ln(),
                Rule::Ln(a) => {
                    let mut sum = Lanes::from(0.0);
                    for j in 1..n {
                        sum = sum + earlier(instruction.out, j) * j as f64 * earlier(*a, n - j);
                    }
                    (row[*a] - sum * PER[n]) / earlier(*a, 0)
                }
                Rule::SinCos(a) => {
                    let (sine, cosine) = if FIRST {
                        row[*a].sin_cos()
                    } else {
                        let newest = row[*a] * n as f64;
                        let mut sums = [1, 0].map(|k| newest * earlier(instruction.out + k, 0));
                        for j in 1..n {
                            let a = earlier(*a, j) * j as f64;
                            sums[0] = sums[0] + a * earlier(instruction.out + 1, n - j);
                            sums[1] = sums[1] + a * earlier(instruction.out, n - j);
                        }
                        (sums[0] * PER[n], sums[1] * -PER[n])
                    };
                    row[instruction.out + 1] = cosine;
                    sine
                }
            };
            row[instruction.out] = value;
        }
        if LATE {
            return;
        }
        let (next, after) = after.split_at_mut(*stride);
        for (i, place) in program.accelerations.iter().enumerate() {
            let v = order_of::<FIRST, W>(*place, row, stills) * PER[n + 1];
            next[program.dof + i] = v;
            after[i] = v * PER[n + 2];
        }
    }

    /// Value of a column at the time `s` of each lane.
    #[inline(always)]
    pub(super) fn value(&self, column: usize, s: &Lanes<W>) -> Lanes<W> {
        // The value at the start is added last: one rounding error of its size.
        *self.at(column, 0) + self.later(column, s, |c| c)
    }
    /// Σ_(n>=1) |c_n| sⁿ: how far a column moves up to the time `s` of each lane, at most.
    #[inline(always)]
    pub(super) fn range(&self, column: usize, s: &Lanes<W>) -> Lanes<W> {
        self.later(column, s, Lanes::abs)
    }

    /// Σ_(n>=1) f(c_n) sⁿ.
    #[inline(always)]
    fn later(&self, column: usize, s: &Lanes<W>, f: impl Fn(Lanes<W>) -> Lanes<W>) -> Lanes<W> {
        // Even and odd orders apart: the sums do not wait for one another. Order `degree + 1` is not used.
        let (square, [mut even, mut odd]) = (*s * *s, [Lanes::from(0.0); 2]);
        let mut n = self.degree - self.degree % 2;
        if n < self.degree {
            odd = f(*self.at(column, n + 1));
        }
        while n > 0 {
            even = even * square + f(*self.at(column, n));
            odd = odd * square + f(*self.at(column, n - 1));
            n -= 2;
        }
        even * square + odd * *s
    }
}

/// Order n of a number, whose columns of that order are `row`. `FIRST`: whether n is 0.
#[inline(always)]
fn order_of<const FIRST: bool, const W: usize>(
    place: Place,
    row: &[Lanes<W>],
    stills: &[Lanes<W>],
) -> Lanes<W> {
    match place {
        Place::Column(column) => row[column],
        Place::Still(still) if FIRST => stills[still],
        Place::Still(_) => Lanes::from(0.0),
    }
}

/// Σ term(a_n, b_n, lane), in each lane.
#[inline(always)]
pub(super) fn weighted_sum<A, B, const W: usize>(
    a: &[A],
    b: &[B],
    term: impl Fn(&A, &B, usize) -> f64,
) -> Lanes<W> {
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
