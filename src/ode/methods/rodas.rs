//! The Rosenbrock method RODASP of order 4.

use crate::ode::driver::drive;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::methods::adaptive::{Adaptive, Method};
use crate::ode::outcome::Finish;
use crate::ode::stepping::control::Task;
use crate::ode::stepping::engine::{Engine, Tableau};
use crate::ode::stepping::tableau_row::TableauRow;
use crate::ode::stepping::vector::Vector;

/// The linearly implicit method RODASP of order 4, adaptive, for stiff models: motions far slower than the
/// fastest decay or oscillation of the model, as with a stiff bearing or a strong damper.
///
/// Six stages (1 - γ h J) k_i = f_i + Σ c_ij k_j + d_i h ∂f/∂t with one factorisation in a step. The Jacobian
/// J is the one that the model offers, or differences; ∂f/∂t is interpolated in the step. The method is
/// stiffly accurate and L-stable and keeps its order where a motion follows a fast decay. Error estimate and
/// dense output have order 3. Edges are located as by the explicit methods.
///
/// Source: Steinebach, Order-reduction of ROW-methods for DAEs and method of lines applications, TH Darmstadt
/// 1995; Hairer & Wanner, Solving Ordinary Differential Equations II, Sect. IV.7.
///
/// ```
/// use gear_dynamics::ode::{Rodas, Step};
/// use gear_dynamics::{Integrator, State, model::from_fn};
/// // q follows cos t: explicit methods need thousands of steps for their stability.
/// let stiff = from_fn(1, |t, q, v, a| a[0] = -1e8 * (q[0] - t.cos()) - 2e4 * v[0])?;
/// let mut quiet = |_: &mut Step<'_>| std::ops::ControlFlow::Continue(());
/// let start = State::new(0.0, &[1.0], &[0.0]);
/// let run = Rodas::new().rtol(1e-6).atol(1e-9).run(&stiff, &start, 3.0, &mut quiet)?;
/// assert!((run.state.q[0] - (3f64.cos() + 2e-4 * 3f64.sin())).abs() < 1e-6);
/// assert!(run.stats.steps < 300);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Rodas = Adaptive<Rosenbrock4>;

/// The coefficients of [`Rodas`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rosenbrock4;

/// Rows of the stages: sums over the slots of earlier stages in the state (A) and beside it (C), and the
/// factors of h ∂f/∂t (D). Slot i holds stage i.
#[rustfmt::skip]
mod table {
    use crate::ode::stepping::tableau_row::TableauRow;
    pub const A2: TableauRow<1> = [(1, 3.0)];
    pub const A3: TableauRow<2> = [(1, 1.831036793486759), (2, 0.4955183967433795)];
    pub const A4: TableauRow<3> = [(1, 2.304376582692669), (2, -0.05249275245743001), (3, -1.176798761832782)];
    pub const A5: TableauRow<4> = [
        (1, -7.170454962423024), (2, -4.741636671481785), (3, -16.31002631330971), (4, -1.062004044111401),
    ];
    pub const A6: TableauRow<5> = [A5[0], A5[1], A5[2], A5[3], (5, 1.0)];
    pub const B: TableauRow<6> = [A5[0], A5[1], A5[2], A5[3], (5, 1.0), (6, 1.0)];
    pub const C2: TableauRow<1> = [(1, -12.0)];
    pub const C3: TableauRow<2> = [(1, -8.791795173947035), (2, -2.207865586973518)];
    pub const C4: TableauRow<3> = [(1, 10.81793056857153), (2, 6.780270611428266), (3, 19.5348594464241)];
    pub const C5: TableauRow<4> = [
        (1, 34.19095006749676), (2, 15.49671153725963), (3, 54.7476087596413), (4, 14.16005392148534),
    ];
    pub const C6: TableauRow<5> = [
        (1, 34.62605830930532), (2, 15.30084976114473), (3, 56.99955578662667), (4, 18.40807009793095),
        (5, -5.714285714285717),
    ];
    pub const D: [f64; 4] = [0.25, -0.5, -0.023504, -0.0362];
    pub const E: TableauRow<1> = [(6, 1.0)];
    pub const DENSE1: TableauRow<4> = [
        (1, 25.09876703708589), (2, 11.62013104361867), (3, 28.49148307714626), (4, -5.664021568594133),
    ];
    pub const DENSE2: TableauRow<5> = [
        (1, 1.638054557396973), (2, -0.7373619806678748), (3, 8.47791821923899), (4, 15.9925314877952),
        (5, -1.882352941176471),
    ];
}

impl Method for Rosenbrock4 {
    fn run(task: Task<'_>) -> Result<Finish, IntegrateError> {
        drive::<Rosenbrock4>(task)
    }
}

impl Tableau for Rosenbrock4 {
    const ADAPTIVE: bool = true;
    const IMPLICIT: Option<f64> = Some(0.25);
    const HERMITE: bool = false;
    const SLOTS: usize = 8;
    const EVALUATIONS: u64 = 5;
    const END: usize = 7;
    const DENSE: usize = 3;
    const DENSE_EVALUATIONS: u64 = 0;
    const EXPONENT: f64 = 1.0 / 4.0;
    const FACTORS: [f64; 2] = [0.2, 6.0];
    const BETA: f64 = 0.0;
    const NODES: &'static [f64] = &[0.75, 0.21, 0.63, 1.0];
    const PROBE: usize = 2;

    fn attempt<V: Vector, const FIXED: bool>(e: &mut Engine<'_, V>) {
        use table::{A2, A3, A4, A5, A6, B, C2, C3, C4, C5, C6, D};
        e.drive_nodes::<Rosenbrock4>();
        e.linearise::<FIXED>();
        e.first_solve(D[0]);
        e.solve_at::<FIXED, _>(0, 2, [&A2, &C2], D[1]);
        e.solve_at::<FIXED, _>(1, 3, [&A3, &C3], D[2]);
        e.solve_at::<FIXED, _>(2, 4, [&A4, &C4], D[3]);
        e.solve_at::<FIXED, _>(3, 5, [&A5, &C5], 0.0);
        e.solve_at::<FIXED, _>(3, 6, [&A6, &C6], 0.0);
        e.advance(&B);
    }
    fn error<V: Vector>(e: &mut Engine<'_, V>) -> f64 {
        e.norms([&table::E])[0]
    }
    fn dense<V: Vector, const FIXED: bool>(e: &mut Engine<'_, V>) {
        e.dense_row(1, &table::DENSE1);
        e.dense_row(2, &table::DENSE2);
    }
}

/// Least size of a component in differences.
const SMALLEST: f64 = 1e-100;

impl<V: Vector> Engine<'_, V> {
    /// Computes the Jacobian and ∂f/∂t at the start of the step and factorises the matrix of the stages.
    /// Slot 0 holds the derivative there.
    fn linearise<const FIXED: bool>(&mut self) {
        let Some(shifted) = &mut self.shifted else { return };
        self.ends.drive(0.0);
        let (ends, k) = (&self.ends, self.k[0].slice());
        let (y, atol) = (ends.y.slice(), ends.atol.slice());
        let pieces = FIXED.then_some(&ends.pieces[..]);
        // The largest acceleration makes a coordinate at rest move.
        let (n, h) = (y.len() / 2, ends.h());
        let a = k[n..].iter().fold(0.0, |largest: f64, a| largest.max(a.abs()));
        let sizes = |j: usize| match y[j].abs().max((h * k[j]).abs()) {
            0.0 if a == 0.0 => atol[j] / self.rtol,
            0.0 if j < n => h * h * a,
            0.0 => h * a,
            // Differences over a coordinate that decays to 0 stay far above the smallest numbers.
            size => size.max(SMALLEST),
        };
        let at = |node: usize| ends.nodes.at(node);
        let drives = [&ends.u_stage[..], at(0), at(1), at(2), at(3)];
        self.evaluations += shifted.prepare(pieces, h, y, drives, sizes);
    }

    /// The first stage: slot 1 from the derivative at the start.
    fn first_solve(&mut self, by_time: f64) {
        let (first, rest) = self.k.split_at_mut(1);
        rest[0].slice_mut().copy_from_slice(first[0].slice());
        self.solve(1, by_time);
    }

    /// Computes stage `s` at a node of the step, in slot s. `inside`: weights of the earlier stages in its
    /// state. `beside`: their weights on the right-hand side of the linear equations.
    fn solve_at<const FIXED: bool, const L: usize>(
        &mut self,
        node: usize,
        s: usize,
        [inside, beside]: [&TableauRow<L>; 2],
        by_time: f64,
    ) {
        self.stage_at::<FIXED, _>(node, s, inside);
        let (earlier, this) = self.k.split_at_mut(s);
        for (l, c) in beside {
            this[0].slice_mut().iter_mut().zip(earlier[*l].slice()).for_each(|(sum, k)| *sum += c * k);
        }
        self.solve(s, by_time);
    }

    fn solve(&mut self, s: usize, by_time: f64) {
        let Some(shifted) = &self.shifted else { return };
        let right = self.k[s].slice_mut();
        let accelerations = right.len() / 2;
        right[accelerations..].iter_mut().zip(&shifted.by_time).for_each(|(sum, a)| *sum += by_time * a);
        shifted.solve(right);
    }
}
