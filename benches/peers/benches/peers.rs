//! RK4 and DOP853 of other crates and loops by hand, compared with those of `gear-dynamics`: on workloads A,
//! B3 and B16, and for an ensemble of runs, workload C. `cargo bench -p peers`. The last lines are errors and
//! ratios of times.

#[path = "../../common/mod.rs"]
mod common;
mod ring;
mod series;

use common::{Pair, Rattling, hand_dop853, ratio};
use criterion::{Criterion, criterion_group};
use differential_equations::interpolate::Interpolation;
use differential_equations::methods::ExplicitRungeKutta;
use differential_equations::ode::{ODE, OrdinaryNumericalMethod, solve_ode};
use differential_equations::prelude::{ControlFlag, Solout, Solution};
use gear_dynamics::ode::{Finish, Step};
use gear_dynamics::sweep::{Axis, InstructionSet, LaneRk4, Points, Rows, TableRk4, bounds::SweepEngine};
use gear_dynamics::{Dop853, Integrator, Machine, Rk4, Sweep};
use ode_solvers::{OutputType, System, Vector2, Vector3};
use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::Duration;

const Q0: f64 = -6.4e-4;
const RTOL: f64 = 1e-8;
const ATOL: f64 = 1e-12;
/// Errors of the mesh deflection are shares of this number.
const SCALE: f64 = 1e-5;
const ROUNDS: usize = 15;

/// q at the end, and the number of evaluations of the right-hand side.
#[derive(Clone, Copy)]
struct End {
    q: f64,
    evaluations: usize,
}

/// The pair as a system of first order.
struct Rates<'a>(&'a Pair);

impl Rates<'_> {
    #[inline(always)]
    fn at(&self, t: f64, q: f64, v: f64) -> [f64; 2] {
        let b = Pair::HALF_BACKLASH;
        let [stiffness, forcing] = self.0.drives(t);
        let force = if q > b { q - b } else { 0.0 } - if q < -b { -q - b } else { 0.0 };
        [v, forcing - 0.02 * v - stiffness * force]
    }
}

impl System<f64, Vector2<f64>> for Rates<'_> {
    #[inline(always)]
    fn system(&self, t: f64, y: &Vector2<f64>, dy: &mut Vector2<f64>) {
        *dy = self.at(t, y[0], y[1]).into();
    }
}

impl ODE<f64, [f64; 2]> for Rates<'_> {
    #[inline(always)]
    fn diff(&self, t: f64, y: &[f64; 2], dydt: &mut [f64; 2]) {
        *dydt = self.at(t, y[0], y[1]);
    }
}

fn steps(pair: &Pair) -> usize {
    (pair.end() / pair.step()).round() as usize
}

fn ours<I: Integrator>(solver: &I, pair: &Pair) -> End {
    let finish: Finish = solver
        .run(pair, &Pair::start(), pair.end(), &mut |_: &mut Step<'_>| ControlFlow::Continue(()))
        .expect("the workload runs");
    End { q: finish.state.q[0], evaluations: finish.stats.evaluations as usize }
}

fn our_rk4(pair: &Pair) -> End {
    ours(&Rk4::new(pair.step()).plain(), pair)
}

fn our_dop853(pair: &Pair) -> End {
    ours(&Dop853::new().rtol(RTOL).atol(ATOL), pair)
}

/// This solver stores every step. It rounds the number of steps up, so that the end is given half a step
/// early.
fn ode_solvers_rk4(pair: &Pair) -> End {
    let (h, steps) = (pair.step(), steps(pair));
    let mut solver =
        ode_solvers::Rk4::new(Rates(pair), 0.0, Vector2::new(Q0, 0.0), (steps as f64 - 0.5) * h, h);
    let stats = solver.integrate().expect("the workload runs");
    assert_eq!(stats.accepted_steps as usize, steps);
    End { q: solver.y_out().last().expect("the start is kept")[0], evaluations: stats.num_eval as usize }
}

/// The pair with the time as third component. The twelfth node of this DOP853 is 0 instead of 1 (ode_solvers
/// 0.6.2, pull request 42), so that a right-hand side that uses the given time is integrated with order 1.
/// The third component has no error and reduces the norm of the error by sqrt(2/3).
struct WithClock<'a>(Rates<'a>);

impl System<f64, Vector3<f64>> for WithClock<'_> {
    #[inline(always)]
    fn system(&self, _: f64, y: &Vector3<f64>, dy: &mut Vector3<f64>) {
        let [dq, dv] = self.0.at(y[2], y[0], y[1]);
        *dy = Vector3::new(dq, dv, 1.0);
    }
}

/// Sparse output stores the steps and skips the stages of the dense output.
fn ode_solvers_dop853(pair: &Pair) -> End {
    let (start, end) = (Vector3::new(Q0, 0.0, 0.0), pair.end());
    let mut solver = ode_solvers::Dop853::new(WithClock(Rates(pair)), 0.0, end, end, start, RTOL, ATOL);
    solver.set_output(OutputType::Sparse);
    let stats = solver.integrate().expect("the workload runs");
    End { q: solver.y_out().last().expect("the start is kept")[0], evaluations: stats.num_eval as usize }
}

/// The same solver with the given time.
fn ode_solvers_dop853_without_clock(pair: &Pair) -> String {
    let (start, end) = (Vector2::new(Q0, 0.0), pair.end());
    let mut solver = ode_solvers::Dop853::new(Rates(pair), 0.0, end, end, start, RTOL, ATOL);
    solver.set_output(OutputType::Sparse);
    match solver.integrate() {
        Ok(stats) => format!("{} evaluations", stats.num_eval),
        Err(error) => error.to_string(),
    }
}

/// An output that stores no step.
struct Nothing;

impl<const N: usize> Solout<f64, [f64; N]> for Nothing {
    #[inline(always)]
    fn solout<I>(
        &mut self,
        _: f64,
        _: f64,
        _: &[f64; N],
        _: &[f64; N],
        _: &mut I,
        _: &mut Solution<f64, [f64; N]>,
    ) -> ControlFlag<f64, [f64; N]>
    where
        I: Interpolation<f64, [f64; N]> + ?Sized,
    {
        ControlFlag::Continue
    }
}

fn differential_equations<S>(mut solver: S, pair: &Pair) -> End
where
    S: OrdinaryNumericalMethod<f64, [f64; 2]> + Interpolation<f64, [f64; 2]>,
{
    let solution = solve_ode(&mut solver, &Rates(pair), 0.0, pair.end(), &[Q0, 0.0], &mut Nothing)
        .expect("the workload runs");
    End { q: solver.y()[0], evaluations: solution.evals.function }
}

fn differential_equations_rk4(pair: &Pair) -> End {
    differential_equations(ExplicitRungeKutta::rk4(pair.step()).max_steps(usize::MAX), pair)
}

fn differential_equations_dop853(pair: &Pair) -> End {
    differential_equations(ExplicitRungeKutta::dop853().rtol(RTOL).atol(ATOL).max_steps(usize::MAX), pair)
}

type Entrant = (&'static str, fn(&Pair) -> End);

/// The entrants; `gear-dynamics` is the first.
const RK4: [Entrant; 3] = [
    ("gear-dynamics, plain steps", our_rk4),
    ("ode_solvers", ode_solvers_rk4),
    ("differential-equations", differential_equations_rk4),
];
const DOP853: [Entrant; 3] = [
    ("gear-dynamics, located edges", our_dop853),
    ("ode_solvers, time as state", ode_solvers_dop853),
    ("differential-equations", differential_equations_dop853),
];

fn group(c: &mut Criterion, name: &str, entrants: &[Entrant]) {
    let pair = Pair::new();
    let mut group = c.benchmark_group(name);
    group.sample_size(20).warm_up_time(Duration::from_secs(1));
    for (entrant, run) in entrants {
        group.bench_function(*entrant, |b| b.iter(|| run(black_box(&pair))));
    }
    group.finish();
}

fn rk4(c: &mut Criterion) {
    group(c, "A, RK4", &RK4);
}

fn dop853(c: &mut Criterion) {
    group(c, "A, DOP853", &DOP853);
}

fn errors_and_ratios(title: &str, truth: f64, entrants: &[Entrant]) {
    let pair = Pair::new();
    println!("\n{title}");
    let our_run = entrants[0].1;
    for (k, (entrant, run)) in entrants.iter().enumerate() {
        let End { q, evaluations } = run(&pair);
        print!("{entrant:28} {evaluations:8} evaluations, error {:.1e}", (q - truth).abs() / SCALE);
        if k > 0 {
            let [median, least, most] = ratio(
                ROUNDS,
                || _ = black_box(run(black_box(&pair))),
                || _ = black_box(our_run(black_box(&pair))),
            );
            print!(", time / gear-dynamics {median:.2} ({least:.2} .. {most:.2})");
        }
        println!();
    }
}

/// RK4 on f(t, y) without further care.
fn hand_written_rk4(pair: &Pair) -> End {
    let (h, steps, f) = (pair.step(), steps(pair), Rates(pair));
    let (mut q, mut v) = (Q0, 0.0);
    for k in 0..steps {
        let t = k as f64 * h;
        let [a1, b1] = f.at(t, q, v);
        let [a2, b2] = f.at(t + 0.5 * h, q + 0.5 * h * a1, v + 0.5 * h * b1);
        let [a3, b3] = f.at(t + 0.5 * h, q + 0.5 * h * a2, v + 0.5 * h * b2);
        let [a4, b4] = f.at(t + h, q + h * a3, v + h * b3);
        q += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        v += h / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4);
    }
    End { q, evaluations: 4 * steps }
}

/// Workload C: `count` mesh frequencies, 20 periods each, with statistics of every run.
fn ensemble(count: usize, engine: &impl SweepEngine<Machine<Rattling>>) -> Rows {
    let pair = Pair::new().machine();
    let points = Points::from(Axis::linear("we", 0.15, 0.36, count).expect("the range is in order"));
    let sweep = Sweep::new(points).settle(0).measure(20).channels(&["q0"]).rattle();
    let rows = sweep.of(engine, |p| pair.with("wc", p["we"] / 63.0)).start(|_, _| Pair::start()).run();
    rows.expect("the workload runs")
}

/// Prints the minimum time of one trajectory of C in lanes and of every other entrant. The entrants
/// alternate.
fn workload_c() {
    const COUNT: usize = 96;
    const STEPS: usize = 63 * 64;
    let pair = Pair::new();
    let time = |f: &mut dyn FnMut()| {
        let start = std::time::Instant::now();
        f();
        start.elapsed().as_secs_f64()
    };
    let lanes =
        |set| move || drop(black_box(ensemble(COUNT, &LaneRk4::new(STEPS).lanes::<32>().instructions(set))));
    let (mut best, mut avx2, mut table) = (lanes(InstructionSet::Best), lanes(InstructionSet::Avx2), || {
        drop(black_box(ensemble(2, &TableRk4::new(STEPS))))
    });
    let one = |run: fn(&Pair) -> End| {
        let pair = &pair;
        move || _ = black_box(run(black_box(pair)))
    };
    let (mut scalar, mut hand) = (one(our_rk4), one(hand_written_rk4));
    let (mut peer_a, mut peer_b) = (one(ode_solvers_rk4), one(differential_equations_rk4));
    let mut entrants: [(&str, f64, &mut dyn FnMut()); 7] = [
        ("lanes, W = 32", COUNT as f64, &mut best),
        ("lanes, W = 32, AVX2 at most", COUNT as f64, &mut avx2),
        ("scalar over a table", 2.0, &mut table),
        ("gear-dynamics Rk4, plain steps, no table, no statistics", 1.0, &mut scalar),
        ("RK4 by hand on f(t, y), no statistics", 1.0, &mut hand),
        ("ode_solvers rk4, no statistics", 1.0, &mut peer_a),
        ("differential-equations rk4, no statistics", 1.0, &mut peer_b),
    ];
    let mut least = [f64::INFINITY; 7];
    for _ in 0..ROUNDS {
        for (least, (_, runs, f)) in least.iter_mut().zip(&mut entrants) {
            *least = least.min(time(*f) / *runs);
        }
    }
    println!(
        "\nC, minimum time per trajectory on one thread; its ratio to that of the lanes with the best \
         instructions and with AVX2"
    );
    for (least_of, (name, ..)) in least.iter().zip(&entrants) {
        println!(
            "{name:56} {:7.3} ms {:6.1} {:6.1}",
            1e3 * least_of,
            least_of / least[0],
            least_of / least[1]
        );
    }
}

fn hand_written_dop853(pair: &Pair) -> End {
    let (y, evaluations, _) = hand_dop853::run(pair, Q0, 0.0, pair.end(), RTOL, ATOL);
    End { q: y[0], evaluations: evaluations as usize }
}

/// Prints the ratios of times: `gear-dynamics` over loops by hand, and the fastest other crate over
/// `gear-dynamics`.
fn ratios() {
    let pair = Pair::new();
    let runs: [fn(&Pair) -> End; 6] = [
        our_rk4,
        hand_written_rk4,
        ode_solvers_rk4,
        differential_equations_rk4,
        our_dop853,
        hand_written_dop853,
    ];
    let entrants = runs.map(|run| {
        let pair = &pair;
        move || run(black_box(pair)).evaluations
    });
    let [ours, by_hand, peer_a, peer_b, our_dop853, hand_dop853] = &entrants;
    let times = ring::least_times(ROUNDS, &[ours, by_hand, peer_a, peer_b, our_dop853, hand_dop853]);
    println!("ratio A dop853 hand {:.3}", times[4] / times[5]);
    println!("ratio A rk4 hand {:.3}", times[0] / times[1]);
    println!("ratio A rk4 peer {:.3}", times[2].min(times[3]) / times[0]);
}

criterion_group!(benches, rk4, dop853);

fn main() {
    benches();
    rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread starts").install(workload_c);
    let truth = ours(&Dop853::new().rtol(1e-13).atol(1e-18), &Pair::new()).q;
    errors_and_ratios("A, RK4, 64 steps per mesh period, error against DOP853 at rtol 1e-13", truth, &RK4);
    errors_and_ratios("A, DOP853, rtol 1e-8, atol 1e-12, error against DOP853 at rtol 1e-13", truth, &DOP853);
    println!("ode_solvers, time as given: {}", ode_solvers_dop853_without_clock(&Pair::new()));
    println!();
    ratios();
    ring::ratios::<3, 14>();
    ring::ratios::<16, 66>();
    series::ratios();
}
