//! Workloads B3 and B16 with G gears and N = 4 G + 2 components. The other crates integrate the equations
//! written by hand, `gear-dynamics` its own ring.

use super::common::{RING_END, hand_ring, ring_with_load};
use super::{ATOL, Nothing, ROUNDS, RTOL};
use differential_equations::interpolate::Interpolation;
use differential_equations::methods::ExplicitRungeKutta;
use differential_equations::ode::{ODE, OrdinaryNumericalMethod, solve_ode};
use gear_dynamics::ode::{Finish, Step};
use gear_dynamics::{Dop853, Integrator, Ring, Rk4, State};
use ode_solvers::{OutputType, SVector, System};
use std::hint::black_box;
use std::ops::ControlFlow;

/// Step of RK4 `[s]`.
const H: f64 = 2e-6;
const STEPS: usize = 100_000;
/// Errors of the angles are shares of this number, those of the speeds of 1 rad/s.
const SCALE: f64 = 1e-4;

struct End<const N: usize> {
    y: [f64; N],
    evaluations: usize,
}

struct Rates<const G: usize>;

impl<const G: usize, const N: usize> System<f64, SVector<f64, N>> for Rates<G> {
    #[inline(always)]
    fn system(&self, t: f64, y: &SVector<f64, N>, dy: &mut SVector<f64, N>) {
        *dy = hand_ring::plain::<G, N>(hand_ring::drives(t), &y.data.0[0]).into();
    }
}

impl<const G: usize, const N: usize> ODE<f64, [f64; N]> for Rates<G> {
    #[inline(always)]
    fn diff(&self, t: f64, y: &[f64; N], dydt: &mut [f64; N]) {
        *dydt = hand_ring::plain::<G, N>(hand_ring::drives(t), y);
    }
}

fn ours<const N: usize>(solver: &impl Integrator, ring: &Ring) -> End<N> {
    let start = State::at_rest(N / 2);
    let finish: Finish = solver
        .run(ring, &start, RING_END, &mut |_: &mut Step<'_>| ControlFlow::Continue(()))
        .expect("the workload runs");
    let mut y = [0.0; N];
    y[..N / 2].copy_from_slice(&finish.state.q);
    y[N / 2..].copy_from_slice(&finish.state.v);
    End { y, evaluations: finish.stats.evaluations as usize }
}

fn hand_dop853<const G: usize, const N: usize>() -> End<N> {
    let (y, evaluations, _) = hand_ring::dop853::<G, N>(RING_END, RTOL, ATOL);
    End { y, evaluations: evaluations as usize }
}

/// This solver rounds the number of steps up, so that the end is given half a step early.
fn ode_solvers_rk4<const G: usize, const N: usize>() -> End<N> {
    let mut solver =
        ode_solvers::Rk4::new(Rates::<G>, 0.0, SVector::<f64, N>::zeros(), (STEPS as f64 - 0.5) * H, H);
    let stats = solver.integrate().expect("the workload runs");
    assert_eq!(stats.accepted_steps as usize, STEPS);
    End {
        y: solver.y_out().last().expect("the start is kept").data.0[0],
        evaluations: stats.num_eval as usize,
    }
}

fn ode_solvers_dopri5<const G: usize, const N: usize>() -> End<N> {
    let mut solver =
        ode_solvers::Dopri5::new(Rates::<G>, 0.0, RING_END, RING_END, SVector::<f64, N>::zeros(), RTOL, ATOL);
    solver.set_output(OutputType::Sparse);
    let stats = solver.integrate().expect("the workload runs");
    End {
        y: solver.y_out().last().expect("the start is kept").data.0[0],
        evaluations: stats.num_eval as usize,
    }
}

fn differential_equations<const G: usize, const N: usize, S>(mut solver: S) -> End<N>
where
    S: OrdinaryNumericalMethod<f64, [f64; N]> + Interpolation<f64, [f64; N]>,
{
    let solution = solve_ode(&mut solver, &Rates::<G>, 0.0, RING_END, &[0.0; N], &mut Nothing)
        .expect("the workload runs");
    End { y: *solver.y(), evaluations: solution.evals.function }
}

/// Minimum time of each entrant for one evaluation `[s]`. The entrants alternate; each returns its number of
/// evaluations.
pub fn least_times(rounds: usize, entrants: &[&dyn Fn() -> usize]) -> Vec<f64> {
    let mut least = vec![f64::INFINITY; entrants.len()];
    for _ in 0..rounds {
        for (least, run) in least.iter_mut().zip(entrants) {
            let start = std::time::Instant::now();
            let evaluations = black_box(run());
            *least = least.min(start.elapsed().as_secs_f64() / evaluations as f64);
        }
    }
    least
}

/// Prints times, evaluations and errors of all entrants, and the ratios of times: `gear-dynamics` over the
/// loop by hand, the fastest other crate over `gear-dynamics`.
pub fn ratios<const G: usize, const N: usize>() {
    let ring = &ring_with_load(G, 1e-2, 20.0);
    let tight = Dop853::new().rtol(1e-13).atol_each(&[vec![1e-19; N / 2], vec![1e-15; N / 2]].concat());
    let truth = ours::<N>(&tight, ring).y;
    type Entrant<'a, const N: usize> = (&'static str, Box<dyn Fn() -> End<N> + 'a>);
    let entrants: [Entrant<'_, N>; 9] = [
        ("gear-dynamics Rk4, plain steps", Box::new(|| ours(&Rk4::new(H).plain(), ring))),
        (
            "RK4 by hand on f(t, y)",
            Box::new(|| End { y: hand_ring::rk4::<G, N>(H, STEPS), evaluations: 4 * STEPS }),
        ),
        (
            "RK4 by hand, drives shared",
            Box::new(|| End { y: hand_ring::rk4_shared::<G, N>(H, STEPS), evaluations: 4 * STEPS }),
        ),
        ("ode_solvers rk4", Box::new(ode_solvers_rk4::<G, N>)),
        (
            "differential-equations rk4",
            Box::new(|| differential_equations::<G, N, _>(ExplicitRungeKutta::rk4(H).max_steps(usize::MAX))),
        ),
        (
            "gear-dynamics Dop853, located edges",
            Box::new(|| ours(&Dop853::new().rtol(RTOL).atol(ATOL), ring)),
        ),
        ("DOP853 by hand, located edges", Box::new(hand_dop853::<G, N>)),
        ("ode_solvers dopri5", Box::new(ode_solvers_dopri5::<G, N>)),
        (
            "differential-equations dop853",
            Box::new(|| {
                differential_equations::<G, N, _>(
                    ExplicitRungeKutta::dop853().rtol(RTOL).atol(ATOL).max_steps(usize::MAX),
                )
            }),
        ),
    ];
    let counts: Vec<_> = entrants.iter().map(|(_, run)| move || run().evaluations).collect();
    let runs: Vec<&dyn Fn() -> usize> = counts.iter().map(|run| run as &dyn Fn() -> usize).collect();
    let times = least_times(ROUNDS, &runs);
    println!("\nB{G}");
    for ((name, run), time) in entrants.iter().zip(&times) {
        let End { y, evaluations } = run();
        let error = (0..N)
            .fold(0.0, |m: f64, i| m.max((y[i] - truth[i]).abs() / if i < N / 2 { SCALE } else { 1.0 }));
        println!(
            "{name:36} {evaluations:8} evaluations {:7.1} ns each {:7.2} ms, error {error:.1e}",
            1e9 * time,
            1e3 * time * evaluations as f64
        );
    }
    println!("ratio B{G} dop853 hand {:.3}", times[5] / times[6]);
    println!("ratio B{G} rk4 hand {:.3}", times[0] / times[1]);
    println!("ratio B{G} rk4 peer {:.3}", times[3].min(times[4]) / times[0]);
}
