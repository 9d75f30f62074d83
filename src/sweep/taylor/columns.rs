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

/// Places of a column. It is no multiple of a page, so that columns do not compete for the same lines of the
/// cache.
const STRIDE: usize = ORDERS + 1;

/// The numbers of all columns in all lanes.
pub(super) struct Columns<const W: usize> {
    /// Column by column, order by order.
    x: Vec<Lanes<W>>,
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
        Columns {
            x: vec![zero; program.columns * STRIDE],
            stills: vec![zero; program.stills.len()],
            masks: masks.collect(),
            degree,
            of_lane: vec![0.0; program.stills.len()],
        }
    }

    /// The coefficients of a column.
    #[inline(always)]
    pub(super) fn column(&self, column: usize) -> &[Lanes<W>; STRIDE] {
        self.x[column * STRIDE..].first_chunk().unwrap_or_else(|| unreachable!("whole columns"))
    }
    #[inline(always)]
    pub(super) fn column_mut(&mut self, column: usize) -> &mut [Lanes<W>; STRIDE] {
        self.x[column * STRIDE..].first_chunk_mut().unwrap_or_else(|| unreachable!("whole columns"))
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
            self.x[i * STRIDE + 1] = self.x[(program.dof + i) * STRIDE];
        }
        self.order::<true, false>(program, 0);
        self.integrate(program, 0);
        for n in 1..self.degree {
            self.order::<false, false>(program, n);
            self.integrate(program, n);
        }
        // Distances and channels have one order more than the accelerations.
        self.order::<false, true>(program, self.degree);
    }

    /// Order n + 1 of velocities and order n + 2 of coordinates from order n of their accelerations.
    #[inline(always)]
    fn integrate(&mut self, program: &Program, n: usize) {
        for (i, place) in program.accelerations.iter().enumerate() {
            let a = self.at(*place, n);
            let v = a * PER[n + 1];
            self.x[(program.dof + i) * STRIDE + n + 1] = v;
            self.x[i * STRIDE + n + 2] = v * PER[n + 2];
        }
    }

    /// Order n of a number.
    #[inline(always)]
    fn at(&self, place: Place, n: usize) -> Lanes<W> {
        match place {
            Place::Column(column) => self.x[column * STRIDE + n],
            Place::Still(still) if n == 0 => self.stills[still],
            Place::Still(_) => Lanes::from(0.0),
        }
    }

    /// Evaluates order n of the instructions; with LATE of those that distances and channels need.
    #[inline(always)]
    fn order<const FIRST: bool, const LATE: bool>(&mut self, program: &Program, n: usize) {
        for instruction in &program.instructions {
            if LATE && !instruction.late {
                continue;
            }
            let value = match &instruction.rule {
                Rule::Sum { like: Some((column, factor)), .. } if !FIRST => {
                    self.x[column * STRIDE + n] * *factor
                }
                Rule::Sum { columns, stills, constant, .. } => {
                    // Two sums that do not wait for one another.
                    let [mut sum, mut other] = [Lanes::from(if FIRST { *constant } else { 0.0 }), Lanes::from(0.0)];
                    if FIRST {
                        for (still, weight) in stills {
                            sum = sum + self.stills[*still] * *weight;
                        }
                    }
                    let (pairs, last) = columns.as_chunks::<2>();
                    for [(a, w), (b, z)] in pairs {
                        sum = sum + self.x[a * STRIDE + n] * *w;
                        other = other + self.x[b * STRIDE + n] * *z;
                    }
                    if let [(a, w)] = last {
                        sum = sum + self.x[a * STRIDE + n] * *w;
                    }
                    sum + other
                }
                Rule::Product(a, b) => convolution(&self.column(*a)[..=n], &self.column(*b)[..=n]),
                Rule::Scaled(still, a) => self.stills[*still] * self.x[a * STRIDE + n],
                Rule::Choice { selector, among } => {
                    let mut bits = [0; W];
                    for (mask, place) in self.masks[*selector].iter().zip(among) {
                        if let (false, Place::Still(_)) = (FIRST, place) {
                            continue;
                        }
                        let value = self.at(*place, n);
                        for l in 0..W {
                            bits[l] |= value.0[l].to_bits() & mask[l];
                        }
                    }
                    Lanes(bits.map(f64::from_bits))
                }
                Rule::Quotient(a, b) => {
                    let (a, b) = (self.at(*a, n), self.column(*b));
                    let before = convolution(&self.column(instruction.out)[..n], &b[1..=n]);
                    (a - before) / b[0]
                }
                Rule::Exp(a) if FIRST => self.x[a * STRIDE].exp(),
                Rule::Exp(a) => self.weighted(*a, instruction.out, n) * PER[n],
                Rule::Ln(a) if FIRST => self.x[a * STRIDE].ln(),
                Rule::Ln(a) => {
                    let (a, out) = (self.column(*a), self.column(instruction.out));
                    let mut sum = Lanes::from(0.0);
                    for j in 1..n {
                        sum = sum + out[j] * j as f64 * a[n - j];
                    }
                    (a[n] - sum * PER[n]) / a[0]
                }
                Rule::SinCos(a) => {
                    let (sine, cosine) = if FIRST {
                        self.x[a * STRIDE].sin_cos()
                    } else {
                        let cosine = self.weighted(*a, instruction.out, n) * -PER[n];
                        (self.weighted(*a, instruction.out + 1, n) * PER[n], cosine)
                    };
                    self.x[(instruction.out + 1) * STRIDE + n] = cosine;
                    sine
                }
            };
            self.x[instruction.out * STRIDE + n] = value;
        }
    }

    /// Σ_(j=1..n) j a_j b_(n-j).
    #[inline(always)]
    fn weighted(&self, a: usize, b: usize, n: usize) -> Lanes<W> {
        let (a, b) = (self.column(a), self.column(b));
        let mut sum = Lanes::from(0.0);
        for j in 1..=n {
            sum = sum + a[j] * j as f64 * b[n - j];
        }
        sum
    }

    /// Value of a column at the time `s` of each lane.
    #[inline(always)]
    pub(super) fn value(&self, column: usize, s: &Lanes<W>) -> Lanes<W> {
        // The value at the start is added last: one rounding error of its size.
        let c = &self.column(column)[..=self.degree];
        c[0] + later(c, s, |c| c)
    }
    /// Σ_(n>=1) |c_n| sⁿ: how far a column moves up to the time `s` of each lane, at most.
    #[inline(always)]
    pub(super) fn range(&self, column: usize, s: &Lanes<W>) -> Lanes<W> {
        later(&self.column(column)[..=self.degree], s, Lanes::abs)
    }
}

/// Σ_(n>=1) f(c_n) sⁿ.
#[inline(always)]
fn later<const W: usize>(
    c: &[Lanes<W>],
    s: &Lanes<W>,
    f: impl Fn(Lanes<W>) -> Lanes<W>,
) -> Lanes<W> {
    // Even and odd orders apart: the sums do not wait for one another.
    let (square, [mut even, mut odd]) = (*s * *s, [Lanes::from(0.0); 2]);
    let (pairs, last) = c[1..].as_chunks::<2>();
    if let [last] = last {
        odd = f(*last);
    }
    for [of_odd, of_even] in pairs.iter().rev() {
        odd = odd * square + f(*of_odd);
        even = even * square + f(*of_even);
    }
    even * square + odd * *s
}

/// Σ a_j b_(n-j) over all terms of two columns of one length n + 1.
#[inline(always)]
pub(super) fn convolution<const W: usize>(a: &[Lanes<W>], b: &[Lanes<W>]) -> Lanes<W> {
    // Four sums that do not wait for one another.
    let mut sums = [[0.0; W]; 4];
    let count = a.len().min(b.len());
    let (a, b) = (&a[..count], &b[..count]);
    let whole = count - count % 4;
    let mut j = 0;
    while j < whole {
        for k in 0..4 {
            let (a, b) = (&a[j + k].0, &b[count - 1 - j - k].0);
            for l in 0..W {
                sums[k][l] += a[l] * b[l];
            }
        }
        j += 4;
    }
    while j < count {
        let (a, b) = (&a[j].0, &b[count - 1 - j].0);
        for l in 0..W {
            sums[0][l] += a[l] * b[l];
        }
        j += 1;
    }
    let mut sum = [0.0; W];
    for l in 0..W {
        sum[l] = (sums[0][l] + sums[1][l]) + (sums[2][l] + sums[3][l]);
    }
    Lanes(sum)
}

/// Σ w_n c_n.
#[inline(always)]
pub(super) fn weighted_sum<const W: usize>(c: &[Lanes<W>], w: &[f64]) -> Lanes<W> {
    // Four sums that do not wait for one another.
    let mut sums = [[0.0; W]; 4];
    let ((fours, rest), (weights, last)) = (c.as_chunks::<4>(), w[..c.len()].as_chunks::<4>());
    for (c, w) in fours.iter().zip(weights) {
        for k in 0..4 {
            for l in 0..W {
                sums[k][l] += c[k].0[l] * w[k];
            }
        }
    }
    for (c, w) in rest.iter().zip(last) {
        for l in 0..W {
            sums[0][l] += c.0[l] * w;
        }
    }
    let mut sum = [0.0; W];
    for l in 0..W {
        sum[l] = (sums[0][l] + sums[1][l]) + (sums[2][l] + sums[3][l]);
    }
    Lanes(sum)
}
