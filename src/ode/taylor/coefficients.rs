//! The Taylor coefficients of a motion, order by order.

use crate::contact::piece::Piece;
use crate::ode::taylor::functions::Grid;
use crate::ode::taylor::plan::Plan;
use crate::ode::taylor::rows::{EIGHT, Eight};
use crate::series::Series;
use crate::tape::tape::Tape;
use pulp::Arch;

/// Maximum number of orders, 0 included.
pub(super) const ORDERS: usize = Series::CAPACITY;

/// The coefficients of all numbers of a plan: one row for each order.
pub(super) struct Coefficients {
    pub(super) plan: Plan,
    x: Vec<Eight>,
    /// Number of coefficients of each drive in `x` that are not 0.
    written: Vec<usize>,
    arch: Arch,
    /// Highest order.
    pub(super) degree: usize,
    /// Whether roots and powers keep their values, without further orders.
    frozen: bool,
}

impl Coefficients {
    /// `still`: whether a drive is constant between two drive edges.
    pub(super) fn new(tape: &Tape, still: impl Fn(usize) -> bool) -> Self {
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
    fn from_block(&self, n: usize, first: usize) -> &[f64] {
        self.x[n * self.plan.width + first..].as_flattened()
    }
    /// Coordinates of order n.
    #[inline(always)]
    pub(super) fn q(&self, n: usize) -> &[f64] {
        &self.from_block(n, 0)[..self.plan.dof]
    }
    /// Velocities of order n.
    #[inline(always)]
    pub(super) fn v(&self, n: usize) -> &[f64] {
        &self.from_block(n, self.plan.half)[..self.plan.dof]
    }
    /// The columns of the distances in order n. See [`Edge`](crate::ode::taylor::plan::Edge).
    #[inline(always)]
    pub(super) fn distances(&self, n: usize) -> &[f64] {
        &self.from_block(n, self.plan.distances)[..self.plan.distance_blocks * EIGHT]
    }

    pub(super) fn set_pieces(&mut self, pieces: &[Piece]) {
        self.plan.set_pieces(pieces);
    }

    /// Computes all coefficients from the state at the start of a step and the series of the drives there.
    /// `degree`: the highest order.
    pub(super) fn expand(&mut self, y: &[f64], drives: &[Series], degree: usize, frozen: bool) {
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
        let Plan { width, half, accelerations, .. } = self.plan;
        let degree = self.degree;
        for n in 0..=degree {
            let levels = if n < degree { usize::MAX } else { self.plan.levels_of_distances };
            self.levels(n, levels);
            let (done, open) = self.x.split_at_mut((n + 1) * width);
            let row = &mut done[n * width..];
            self.plan.outputs.apply(n, row);
            if n == degree {
                break;
            }
            let (next, after) = open.split_at_mut(width);
            let (q, v) = next.split_at_mut(half);
            if n == 0 {
                q.copy_from_slice(&row[half..2 * half]);
            }
            let [per_v, per_q] = [1.0 / (n + 1) as f64, 1.0 / (n + 2) as f64];
            for ((v, a), q) in v[..half].iter_mut().zip(&row[accelerations..]).zip(after) {
                for l in 0..EIGHT {
                    v[l] = a[l] * per_v;
                    q[l] = v[l] * per_q;
                }
            }
        }
    }

    /// Evaluates the operations of order n on the first `count` levels.
    #[inline(always)]
    fn levels(&mut self, n: usize, count: usize) {
        let width = self.plan.width;
        for level in self.plan.levels.iter_mut().take(count) {
            let row = &mut self.x[n * width..][..width];
            level.rows.apply(n, row);
            for products in &mut level.products {
                products.order(n, row.as_flattened_mut());
            }
            for function in &level.functions {
                let x = self.x.as_flattened_mut();
                function.order(n, &mut Grid { x, width: width * EIGHT }, self.frozen);
            }
        }
    }

    /// Writes coordinates and velocities at the time `s` after the start of the step to `y`.
    pub(super) fn at(&self, s: f64, y: &mut [f64]) {
        let (q, v) = y.split_at_mut(self.plan.dof);
        self.arch.dispatch(|| {
            for (part, first) in [(q, 0), (v, self.plan.half)] {
                for (k, out) in part.chunks_mut(EIGHT).enumerate() {
                    let values = self.sum(0, first + k, s, |c| c);
                    out.copy_from_slice(&values[..out.len()]);
                }
            }
        });
    }

    /// Σ_(n>=first) term(c_n) sⁿ⁻ᶠⁱʳˢᵗ of a block of columns.
    #[inline(always)]
    fn sum(&self, first: usize, block: usize, s: f64, term: impl Fn(f64) -> f64) -> Eight {
        let (width, square) = (self.plan.width, s * s);
        // Even and odd orders apart: two sums that do not wait for one another.
        let mut sums = [[0.0; EIGHT]; 2];
        for n in (first..=self.degree).rev() {
            let (sum, c) = (&mut sums[(n - first) % 2], &self.x[n * width + block]);
            for l in 0..EIGHT {
                sum[l] = sum[l] * square + term(c[l]);
            }
        }
        let [even, odd] = sums;
        std::array::from_fn(|l| even[l] + s * odd[l])
    }

    /// The accelerations of the polynomials at the time `s` after the start of the step.
    pub(super) fn acceleration(&self, s: f64, a: &mut [f64]) {
        a.fill(0.0);
        for n in (1..=self.degree).rev() {
            a.iter_mut().zip(self.v(n)).for_each(|(a, c)| *a = *a * s + n as f64 * c);
        }
    }

    /// Σ_(n>=1) |d_n| hⁿ of every distance: how far it moves at most.
    pub(super) fn ranges(&self, h: f64, ranges: &mut [f64]) {
        self.arch.dispatch(|| {
            for (k, out) in ranges.chunks_mut(EIGHT).enumerate() {
                let values = self.sum(1, self.plan.distances + k, h, f64::abs);
                out.iter_mut().zip(values).for_each(|(out, value)| *out = h * value);
            }
        });
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
