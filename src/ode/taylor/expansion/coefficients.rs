//! The Taylor coefficients of a motion, order by order.

use crate::contact::Piece;
use crate::ode::taylor::expansion::aligned::Aligned;
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
    pub(super) x: Aligned,
    pub(super) arch: Arch,
    /// Highest order.
    pub(crate) degree: usize,
    /// Whether roots and powers keep their values, without further orders.
    pub(crate) frozen: bool,
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
    /// The columns of the distances in order n. See
    /// [`EdgeColumn`](crate::ode::taylor::expansion::plan::EdgeColumn).
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

    /// The accelerations of the polynomials at the time `s` after the start of the step.
    pub(crate) fn acceleration(&self, s: f64, a: &mut [f64]) {
        a.fill(0.0);
        for n in (1..=self.degree).rev() {
            a.iter_mut().zip(self.v(n)).for_each(|(a, c)| *a = *a * s + n as f64 * c);
        }
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
