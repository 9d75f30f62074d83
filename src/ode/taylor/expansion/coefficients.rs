//! The Taylor coefficients of a motion, order by order.

use crate::contact::piece::Piece;
use crate::ode::taylor::expansion::plan::{Plan, SMALL, Small};
use crate::ode::taylor::expansion::rows::{EIGHT, Eight};
use crate::series::Series;
use crate::tape::operations::Tape;
use pulp::Arch;

/// Maximum number of orders, 0 included.
pub(crate) const ORDERS: usize = Series::CAPACITY;

/// 1/n; 0 for n = 0.
pub(crate) const PER: [f64; ORDERS] = {
    let (mut per, mut n) = ([0.0; ORDERS], 1);
    while n < ORDERS {
        per[n] = 1.0 / n as f64;
        n += 1;
    }
    per
};

/// The coefficients of all numbers of a plan: one row for each order.
pub(crate) struct Coefficients {
    pub(crate) plan: Plan,
    x: Aligned,
    arch: Arch,
    /// Highest order.
    pub(crate) degree: usize,
    /// Whether roots and powers keep their values, without further orders.
    frozen: bool,
}

impl Coefficients {
    /// `still`: whether a drive is constant between two drive edges.
    pub(crate) fn new(tape: &Tape, still: impl Fn(usize) -> bool) -> Self {
        let plan = Plan::new(tape, still);
        let mut x = Aligned::new(ORDERS * plan.width);
        x.as_flattened_mut()[plan.one] = 1.0;
        Coefficients { plan, x, arch: Arch::new(), degree: 0, frozen: false }
    }

    /// The numbers of order n from block `first` on.
    #[inline(always)]
    fn block_on(&self, n: usize, first: usize) -> &[f64] {
        self.x[n * self.plan.width + first..].as_flattened()
    }
    /// Coordinates of order n.
    #[inline(always)]
    pub(crate) fn q(&self, n: usize) -> &[f64] {
        &self.block_on(n, 0)[..self.plan.dof]
    }
    /// Velocities of order n.
    #[inline(always)]
    pub(crate) fn v(&self, n: usize) -> &[f64] {
        &self.block_on(n, self.plan.half)[..self.plan.dof]
    }
    /// The blocks of coordinates and velocities of order n.
    #[inline(always)]
    pub(crate) fn motion(&self, n: usize) -> &[Eight] {
        &self.x[n * self.plan.width..][..2 * self.plan.half]
    }
    /// The columns of the distances in order n. See [`Edge`](crate::ode::taylor::expansion::plan::Edge).
    #[inline(always)]
    pub(crate) fn distances(&self, n: usize) -> &[f64] {
        &self.block_on(n, self.plan.distances)[..self.plan.distance_blocks * EIGHT]
    }

    pub(crate) fn set_pieces(&mut self, pieces: &[Piece]) {
        self.plan.set_pieces(pieces);
    }

    /// Computes all coefficients from the state at the start of a step and the series of the drives there.
    /// `degree`: the highest order.
    pub(crate) fn expand(&mut self, y: &[f64], drives: &[Series], degree: usize, frozen: bool) {
        let Plan { width, half, dof, .. } = self.plan;
        (self.degree, self.frozen) = (degree, frozen);
        let (q, v) = y.split_at(dof);
        let x = self.x.as_flattened_mut();
        x[..dof].copy_from_slice(q);
        x[half * EIGHT..][..dof].copy_from_slice(v);
        let (moving, still) = self.plan.drives.split_at(self.plan.moving);
        for &(d, column) in still {
            x[column] = drives[d].first();
        }
        self.arch.dispatch(Drives { x, stride: width * EIGHT, drives, moving, degree });
        self.arch.dispatch(Orders(self));
    }

    #[inline(always)]
    fn orders(&mut self) {
        let Coefficients { plan, x, degree, frozen, .. } = self;
        let (x, degree, frozen) = (&mut x[..], *degree, *frozen);
        if let (false, Some(mut small)) = (frozen, plan.small()) {
            let x = x.as_chunks_mut::<SMALL>().0;
            small.order::<true>(0, x);
            for n in 1..degree {
                small.order::<false>(n, x);
            }
            return small.operands::<false>(degree, &mut x[degree]);
        }
        order::<true>(plan, x, 0, frozen);
        for n in 1..degree {
            order::<false>(plan, x, n, frozen);
        }
        // The distances have one order more than the accelerations.
        for level in plan.levels.iter_mut().take(plan.levels_of_distances) {
            level.order::<false>(degree, x, plan.width, frozen);
        }
        plan.own_distances.apply::<false>(&mut x[degree * plan.width..][..plan.width]);
    }

    /// Writes coordinates and velocities at the time `s` after the start of the step to `y`.
    pub(crate) fn at(&self, s: f64, y: &mut [f64]) {
        self.arch.dispatch(Values { c: self, s, y });
    }

    /// The accelerations of the polynomials at the time `s` after the start of the step.
    pub(crate) fn acceleration(&self, s: f64, a: &mut [f64]) {
        a.fill(0.0);
        for n in (1..=self.degree).rev() {
            a.iter_mut().zip(self.v(n)).for_each(|(a, c)| *a = *a * s + n as f64 * c);
        }
    }

    /// Σ_(n>=1) |d_n| hⁿ of every distance: how far it moves at most.
    pub(crate) fn ranges(&self, h: f64, ranges: &mut [Eight]) {
        self.arch.dispatch(Ranges { c: self, h, ranges });
    }

    /// A time in [0, h] up to which the distance d in this column, times `sign`, is above `least` for certain.
    /// It starts above it.
    pub(crate) fn above_until(&self, column: usize, sign: f64, least: f64, h: f64) -> f64 {
        self.samples::<0>(column, h).above_until(sign, least, h)
    }
    /// A time in [0, h] up to which the distance d in this column, times `sign`, is above its value at the start
    /// for certain.
    pub(crate) fn risen_until(&self, column: usize, sign: f64, h: f64) -> f64 {
        self.samples::<1>(column, h).above_until(sign, 0.0, h)
    }
    fn samples<const SHIFT: usize>(&self, column: usize, h: f64) -> Samples {
        self.arch.dispatch(Sampling::<SHIFT> { c: self, column, h })
    }
}

/// Computes order n of all numbers, order n + 1 of the velocities and order n + 2 of the coordinates.
#[inline(always)]
fn order<const FIRST: bool>(plan: &mut Plan, x: &mut [Eight], n: usize, frozen: bool) {
    let Plan { width, half, .. } = *plan;
    for level in &mut plan.levels {
        level.order::<FIRST>(n, x, width, frozen);
    }
    let (done, open) = x.split_at_mut((n + 1) * width);
    let row = &mut done[n * width..];
    plan.own_distances.apply::<FIRST>(row);
    let (next, after) = open.split_at_mut(width);
    let (q, v) = next.split_at_mut(half);
    if FIRST {
        q.copy_from_slice(&row[half..2 * half]);
    }
    for ((block, v), q) in plan.accelerations.blocks().iter().zip(v).zip(after) {
        (*v, *q) = integrals(n, block.sum::<FIRST>(row.as_flattened()));
    }
}

/// Order n + 1 of velocities and order n + 2 of coordinates from order n of their accelerations.
#[inline(always)]
fn integrals(n: usize, a: Eight) -> (Eight, Eight) {
    let ([per_v, per_q], mut v, mut q) = ([PER[n + 1], PER[n + 2]], a, a);
    for l in 0..EIGHT {
        v[l] = a[l] * per_v;
        q[l] = v[l] * per_q;
    }
    (v, q)
}

impl Small<'_> {
    /// [`order`] for a small plan.
    #[inline(always)]
    fn order<const FIRST: bool>(&mut self, n: usize, x: &mut [[Eight; SMALL]]) {
        let Some([row, next, after]) = x.get_mut(n..n + 3) else { return };
        self.operands::<FIRST>(n, row);
        if FIRST {
            next[0] = row[1];
        }
        (next[1], after[0]) = integrals(n, self.accelerations.sum::<FIRST>(row.as_flattened()));
    }

    /// The operands and their products.
    #[inline(always)]
    fn operands<const FIRST: bool>(&mut self, n: usize, row: &mut [Eight; SMALL]) {
        row[self.operands.out] = self.operands.sum::<FIRST>(row.as_flattened());
        self.products.order::<FIRST>(n, row.as_flattened_mut());
    }
}

/// Blocks of eight numbers, each in one line of the cache.
#[derive(Debug, Default)]
pub(crate) struct Aligned {
    numbers: Vec<f64>,
    first: usize,
    count: usize,
}

impl Aligned {
    /// This number of blocks of zeros.
    pub(crate) fn new(count: usize) -> Self {
        let numbers = vec![0.0; EIGHT * (count + 1)];
        let first = numbers.as_ptr().align_offset(64).min(EIGHT);
        Aligned { numbers, first, count }
    }
}

impl std::ops::Deref for Aligned {
    type Target = [Eight];
    #[inline(always)]
    fn deref(&self) -> &[Eight] {
        self.numbers[self.first..][..EIGHT * self.count].as_chunks().0
    }
}

impl std::ops::DerefMut for Aligned {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [Eight] {
        self.numbers[self.first..][..EIGHT * self.count].as_chunks_mut().0
    }
}

/// n (n - 1).
pub(crate) const SECOND: [f64; ORDERS] = {
    let (mut second, mut n) = ([0.0; ORDERS], 0);
    while n < ORDERS {
        second[n] = (n * n - n) as f64;
        n += 1;
    }
    second
};

/// Σ_(n>=1) |d_n| hⁿ of all distances.
struct Ranges<'v> {
    c: &'v Coefficients,
    h: f64,
    ranges: &'v mut [Eight],
}

impl pulp::WithSimd for Ranges<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Ranges { c, h, ranges } = self;
        let (first, square) = (c.plan.distances, h * h);
        for (k, range) in ranges.iter_mut().enumerate() {
            // Even and odd orders apart: sums that do not wait for one another.
            let mut sums = [[0.0; EIGHT]; 2];
            for n in (1..=c.degree).rev() {
                add_order(&mut sums[n % 2], square, &c.x[n * c.plan.width + first + k].map(f64::abs));
            }
            let [even, odd] = sums;
            for l in 0..EIGHT {
                range[l] = h * (even[l] * h + odd[l]);
            }
        }
    }
}

/// A polynomial p at the end s of each eighth of a step, and Σ n (n - 1) |c_n| sⁿ there, which is the largest
/// |p''| s² in [0, s] at most.
struct Samples {
    at_start: f64,
    values: Eight,
    bends: Eight,
}

impl Samples {
    /// A time in [0, h] up to which the polynomial, times `sign`, is above `least` for certain.
    fn above_until(&self, sign: f64, least: f64, h: f64) -> f64 {
        let mut before = sign * self.at_start;
        for l in 0..EIGHT {
            let (value, end) = (sign * self.values[l], (l + 1) as f64);
            // Between two samples at the distance w a function lies above the smaller one less w²/8 max |p''|.
            let is_above = before.min(value) - least > self.bends[l] / (8.0 * end * end);
            if !is_above {
                return h * (l as f64 / EIGHT as f64);
            }
            before = value;
        }
        h
    }
}

/// Samples of a distance d; with SHIFT 1 those of (d(s) - d(0))/s.
struct Sampling<'v, const SHIFT: usize> {
    c: &'v Coefficients,
    column: usize,
    h: f64,
}

impl<const SHIFT: usize> pulp::WithSimd for Sampling<'_, SHIFT> {
    type Output = Samples;
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Samples {
        let Sampling { c, column, h } = self;
        let (mut times, mut squares) = ([0.0; EIGHT], [0.0; EIGHT]);
        for l in 0..EIGHT {
            times[l] = h * ((l + 1) as f64 / EIGHT as f64);
            squares[l] = times[l] * times[l];
        }
        let stride = EIGHT * c.plan.width;
        let numbers = &c.x.as_flattened()[SHIFT * stride + EIGHT * c.plan.distances + column..];
        // Even and odd orders apart: sums that do not wait for one another.
        let (mut values, mut bends) = ([[0.0; EIGHT]; 2], [[0.0; EIGHT]; 2]);
        for n in (0..=c.degree - SHIFT).rev() {
            let (d, odd) = (numbers[n * stride], n % 2);
            let [value, bend] = [&mut values[odd], &mut bends[odd]];
            for l in 0..EIGHT {
                value[l] = value[l] * squares[l] + d;
                bend[l] = bend[l] * squares[l] + SECOND[n] * d.abs();
            }
        }
        let (mut value, mut bend) = ([0.0; EIGHT], [0.0; EIGHT]);
        for l in 0..EIGHT {
            value[l] = values[0][l] + times[l] * values[1][l];
            bend[l] = bends[0][l] + times[l] * bends[1][l];
        }
        Samples { at_start: numbers[0], values: value, bends: bend }
    }
}

/// Σ c_n sⁿ of coordinates and velocities.
struct Values<'v> {
    c: &'v Coefficients,
    s: f64,
    y: &'v mut [f64],
}

impl pulp::WithSimd for Values<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Values { c, s, y } = self;
        let (width, half, square) = (c.plan.width, c.plan.half, s * s);
        let (q, v) = y.split_at_mut(c.plan.dof);
        let outs = q.chunks_mut(EIGHT).zip(0..).chain(v.chunks_mut(EIGHT).zip(half..));
        for (out, k) in outs {
            // Even and odd orders apart: two sums that do not wait for one another.
            let (mut even, mut odd) = ([0.0; EIGHT], [0.0; EIGHT]);
            let mut n = c.degree + 1;
            if n % 2 == 1 {
                n -= 1;
                even = c.x[n * width + k];
            }
            while n > 0 {
                add_order(&mut odd, square, &c.x[(n - 1) * width + k]);
                add_order(&mut even, square, &c.x[(n - 2) * width + k]);
                n -= 2;
            }
            let values: Eight = std::array::from_fn(|l| even[l] + s * odd[l]);
            out.copy_from_slice(&values[..out.len()]);
        }
    }
}

/// sum <- sum factor + c.
#[inline(always)]
fn add_order(sum: &mut Eight, factor: f64, c: &Eight) {
    for l in 0..EIGHT {
        sum[l] = sum[l] * factor + c[l];
    }
}

/// Writes the series of drives to their columns.
struct Drives<'c> {
    x: &'c mut [f64],
    stride: usize,
    drives: &'c [Series],
    /// Drives in neighbouring columns.
    moving: &'c [(usize, usize)],
    degree: usize,
}

impl pulp::WithSimd for Drives<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Drives { x, stride, drives, moving, degree } = self;
        let orders = degree + 1;
        let (groups, rest) = moving.as_chunks::<EIGHT>();
        for group in groups {
            let mut series = [drives[group[0].0].padded(); EIGHT];
            for l in 1..EIGHT {
                series[l] = drives[group[l].0].padded();
            }
            for (n, row) in x[group[0].1..].chunks_mut(stride).take(orders).enumerate() {
                for l in 0..EIGHT {
                    row[l] = series[l][n];
                }
            }
        }
        let (pairs, last) = rest.as_chunks::<2>();
        for [(d, column), (e, _)] in pairs {
            let mut place = *column;
            for (c, f) in drives[*d].padded()[..orders].iter().zip(&drives[*e].padded()[..orders]) {
                x[place..][..2].copy_from_slice(&[*c, *f]);
                place += stride;
            }
        }
        for (d, column) in last {
            let mut place = *column;
            for c in &drives[*d].padded()[..orders] {
                x[place] = *c;
                place += stride;
            }
        }
    }
}

/// The evaluation of all orders, compiled for the instructions of the processor.
struct Orders<'c>(&'c mut Coefficients);

impl pulp::WithSimd for Orders<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        self.0.orders();
    }
}
