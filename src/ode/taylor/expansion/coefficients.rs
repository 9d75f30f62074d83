//! The Taylor coefficients of a motion, order by order.

use crate::contact::piece::Piece;
use crate::ode::taylor::expansion::plan::Plan;
use crate::ode::taylor::expansion::rows::{EIGHT, Eight};
use crate::series::Series;
use crate::tape::operations::Tape;
use pulp::Arch;

/// Maximum number of orders, 0 included.
pub(crate) const ORDERS: usize = Series::CAPACITY;

/// 1/n; 0 for n = 0.
const PER: [f64; ORDERS] = {
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
    x: Vec<Eight>,
    /// Number of coefficients of each drive in `x` that are not 0.
    written: Vec<usize>,
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
        let mut x = vec![[0.0; EIGHT]; ORDERS * plan.width];
        x.as_flattened_mut()[plan.one] = 1.0;
        Coefficients {
            written: vec![0; plan.drives.len()],
            plan,
            x,
            arch: Arch::new(),
            degree: 0,
            frozen: false,
        }
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
        for (&(d, column), written) in self.plan.drives.iter().zip(&mut self.written) {
            let coefficients = drives[d].coefficients();
            let coefficients = &coefficients[..coefficients.len().min(degree + 1)];
            let mut places = x[column..].iter_mut().step_by(width * EIGHT);
            for (place, c) in places.by_ref().zip(coefficients) {
                *place = *c;
            }
            if coefficients.len() < *written {
                let old = x[column..].iter_mut().step_by(width * EIGHT);
                old.take(*written).skip(coefficients.len()).for_each(|x| *x = 0.0);
            }
            *written = coefficients.len();
        }
        self.arch.dispatch(Orders(self));
    }

    #[inline(always)]
    fn orders(&mut self) {
        let Coefficients { plan, x, degree, frozen, .. } = self;
        let (degree, frozen) = (*degree, *frozen);
        let Plan { width, half, accelerations, .. } = *plan;
        for n in 0..degree {
            for level in &mut plan.levels {
                level.order(n, x, width, frozen);
            }
            let (done, open) = x.split_at_mut((n + 1) * width);
            let row = &mut done[n * width..];
            plan.outputs.apply(n, row);
            let (next, after) = open.split_at_mut(width);
            let (q, v) = next.split_at_mut(half);
            if n == 0 {
                q.copy_from_slice(&row[half..2 * half]);
            }
            let [per_v, per_q] = [PER[n + 1], PER[n + 2]];
            for ((v, a), q) in v[..half].iter_mut().zip(&row[accelerations..]).zip(after) {
                for l in 0..EIGHT {
                    v[l] = a[l] * per_v;
                    q[l] = v[l] * per_q;
                }
            }
        }
        // The distances have one order more than the accelerations.
        for level in plan.levels.iter_mut().take(plan.levels_of_distances) {
            level.order(degree, x, width, frozen);
        }
        plan.outputs.apply(degree, &mut x[degree * width..][..width]);
    }

    /// Writes coordinates and velocities at the time `s` after the start of the step to `y`.
    pub(crate) fn at(&self, s: f64, y: &mut [f64]) {
        let half = self.plan.half;
        let (q, v) = y.split_at_mut(self.plan.dof);
        self.arch.dispatch(Values::<false> { c: self, first: 0, s, out: q });
        self.arch.dispatch(Values::<false> { c: self, first: half, s, out: v });
    }

    /// The accelerations of the polynomials at the time `s` after the start of the step.
    pub(crate) fn acceleration(&self, s: f64, a: &mut [f64]) {
        a.fill(0.0);
        for n in (1..=self.degree).rev() {
            a.iter_mut().zip(self.v(n)).for_each(|(a, c)| *a = *a * s + n as f64 * c);
        }
    }

    /// Σ_(n>=1) |d_n| hⁿ of every distance: how far it moves at most.
    pub(crate) fn ranges(&self, h: f64, ranges: &mut [f64]) {
        self.arch.dispatch(Values::<true> { c: self, first: self.plan.distances, s: h, out: ranges });
    }
}

/// Σ c_n sⁿ of the columns from block `first` on; with `RANGE` Σ_(n>=1) |c_n| sⁿ.
struct Values<'v, const RANGE: bool> {
    c: &'v Coefficients,
    first: usize,
    s: f64,
    out: &'v mut [f64],
}

impl<const RANGE: bool> pulp::WithSimd for Values<'_, RANGE> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Values { c, first, s, out } = self;
        let (width, square, lowest) = (c.plan.width, s * s, usize::from(RANGE));
        for (k, out) in out.chunks_mut(EIGHT).enumerate() {
            // Even and odd orders apart: two sums that do not wait for one another.
            let (mut even, mut odd) = ([0.0; EIGHT], [0.0; EIGHT]);
            let mut n = c.degree + 1;
            if (n - lowest) % 2 == 1 {
                n -= 1;
                add_order::<RANGE>(&mut even, square, &c.x[n * width + first + k]);
            }
            while n > lowest {
                add_order::<RANGE>(&mut odd, square, &c.x[(n - 1) * width + first + k]);
                add_order::<RANGE>(&mut even, square, &c.x[(n - 2) * width + first + k]);
                n -= 2;
            }
            for (l, out) in out.iter_mut().enumerate() {
                let value = even[l] + s * odd[l];
                *out = if RANGE { s * value } else { value };
            }
        }
    }
}

/// sum <- sum factor + c, or + |c|.
#[inline(always)]
fn add_order<const RANGE: bool>(sum: &mut Eight, factor: f64, c: &Eight) {
    for l in 0..EIGHT {
        sum[l] = sum[l] * factor + if RANGE { c[l].abs() } else { c[l] };
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
