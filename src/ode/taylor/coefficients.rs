//! The Taylor coefficients of a motion, order by order.

use crate::contact::piece::Piece;
use crate::ode::taylor::functions::Grid;
use crate::ode::taylor::plan::Plan;
use crate::series::Series;
use crate::tape::tape::Tape;
use pulp::Arch;

/// Maximum number of orders, 0 included.
pub(super) const ORDERS: usize = Series::CAPACITY;

/// The coefficients of all numbers of a plan: one row for each order.
pub(super) struct Coefficients {
    pub(super) plan: Plan,
    x: Vec<f64>,
    /// Number of coefficients of each drive in `x` that are not 0.
    written: Vec<usize>,
    arch: Arch,
    /// Highest order.
    pub(super) degree: usize,
    /// Whether roots and powers keep their values, without further orders.
    frozen: bool,
}

impl Coefficients {
    pub(super) fn new(tape: &Tape) -> Self {
        let plan = Plan::new(tape);
        let mut x = vec![0.0; ORDERS * plan.width];
        x[plan.one] = 1.0;
        Coefficients {
            written: vec![0; plan.drives.len()],
            plan,
            x,
            arch: Arch::new(),
            degree: 0,
            frozen: false,
        }
    }

    /// Row of order n.
    #[inline(always)]
    pub(super) fn row(&self, n: usize) -> &[f64] {
        &self.x[n * self.plan.width..][..self.plan.width]
    }
    /// Coordinates and velocities of order n.
    #[inline(always)]
    pub(super) fn motion(&self, n: usize) -> &[f64] {
        &self.row(n)[..2 * self.plan.dof]
    }
    /// Distances of order n, in the order of [`Plan::edges`].
    #[inline(always)]
    pub(super) fn distances(&self, n: usize) -> &[f64] {
        &self.row(n)[self.plan.first_distance..][..self.plan.edges.len()]
    }

    pub(super) fn set_pieces(&mut self, pieces: &[Piece]) {
        self.plan.set_pieces(pieces);
    }

    /// Computes all coefficients from the state at the start of a step and the series of the drives there.
    /// `degree`: the highest order.
    pub(super) fn expand(&mut self, y: &[f64], drives: &[Series], degree: usize, frozen: bool) {
        let width = self.plan.width;
        (self.degree, self.frozen) = (degree, frozen);
        self.x[..y.len()].copy_from_slice(y);
        for (&(d, column), written) in self.plan.drives.iter().zip(&mut self.written) {
            let coefficients = &drives[d].coefficients()[..];
            let coefficients = &coefficients[..coefficients.len().min(degree + 1)];
            let column = &mut self.x[column..];
            for (x, c) in column.iter_mut().step_by(width).zip(coefficients) {
                *x = *c;
            }
            if coefficients.len() < *written {
                let old = column.iter_mut().step_by(width).take(*written).skip(coefficients.len());
                old.for_each(|x| *x = 0.0);
            }
            *written = coefficients.len();
        }
        self.arch.dispatch(Orders(self));
    }

    #[inline(always)]
    fn orders(&mut self) {
        let (width, dof, degree) = (self.plan.width, self.plan.dof, self.degree);
        for n in 0..=degree {
            if n < degree || self.plan.distances_need_levels {
                self.levels(n);
            }
            let (done, open) = self.x.split_at_mut((n + 1) * width);
            let row = &mut done[n * width..];
            self.plan.outputs.apply(row);
            if n == degree {
                break;
            }
            let (next, after) = open.split_at_mut(width);
            let per = 1.0 / (n + 1) as f64;
            let a = &row[self.plan.first_acceleration..][..dof];
            let v = &mut next[dof..2 * dof];
            v.iter_mut().zip(a).for_each(|(v, a)| *v = a * per);
            if n == 0 {
                let (q, v) = (&mut next[..dof], &row[dof..2 * dof]);
                q.copy_from_slice(v);
            }
            if n + 2 <= degree {
                let per = 1.0 / (n + 2) as f64;
                let (q, v) = (&mut after[..dof], &next[dof..2 * dof]);
                q.iter_mut().zip(v).for_each(|(q, v)| *q = v * per);
            }
        }
    }

    /// Evaluates all operations of order n.
    #[inline(always)]
    fn levels(&mut self, n: usize) {
        let width = self.plan.width;
        for level in &mut self.plan.levels {
            let row = &mut self.x[n * width..][..width];
            level.rows.apply(row);
            for products in &mut level.products {
                products.order(n, row);
            }
            for function in &level.functions {
                function.order(n, &mut Grid { x: &mut self.x, width }, self.frozen);
            }
        }
    }

    /// Writes coordinates and velocities at the time `s` after the start of the step to `y`.
    pub(super) fn at(&self, s: f64, y: &mut [f64]) {
        self.arch.dispatch(|| {
            y.copy_from_slice(self.motion(self.degree));
            for n in (0..self.degree).rev() {
                y.iter_mut().zip(self.motion(n)).for_each(|(y, c)| *y = *y * s + c);
            }
        });
    }

    /// The accelerations of the polynomials at the time `s` after the start of the step.
    pub(super) fn acceleration(&self, s: f64, a: &mut [f64]) {
        a.fill(0.0);
        for n in (1..=self.degree).rev() {
            let v = &self.motion(n)[self.plan.dof..];
            a.iter_mut().zip(v).for_each(|(a, c)| *a = *a * s + n as f64 * c);
        }
    }

    /// Σ_(n>=1) |d_n| hⁿ of every distance: how far it moves at most.
    pub(super) fn ranges(&self, h: f64, ranges: &mut [f64]) {
        self.arch.dispatch(|| {
            ranges.fill(0.0);
            for n in (1..=self.degree).rev() {
                let row = self.distances(n);
                ranges.iter_mut().zip(row).for_each(|(range, d)| *range = (*range + d.abs()) * h);
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
