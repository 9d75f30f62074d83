//! ns per evaluation of each entrant, least of several interleaved rounds.
#[path = "../../common/mod.rs"]
mod common;
use common::{Pair, hand_dop853, hand_ring, hand_rk4, ring_with_load};
use gear_dynamics::*;
use std::hint::black_box;
use std::ops::ControlFlow;

fn ours<I: Integrator, M: Model>(solver: &I, model: &M, start: &State, end: f64) -> (f64, u64, u64) {
    let f: Finish = solver.run(model, start, end, &mut |_: &mut Step<'_>| ControlFlow::Continue(())).expect("runs");
    (f.state.q[0], f.stats.evaluations, f.stats.crossings)
}

fn main() {
    let rounds: usize = std::env::args().nth(1).map_or(7, |s| s.parse().unwrap());
    let only = std::env::args().nth(2).unwrap_or_default();
    let pair = Pair::new();
    let (b3, b16) = (ring_with_load(3, 1e-2, 20.0), ring_with_load(16, 1e-2, 20.0));
    let dop = Dop853::new().rtol(1e-8).atol(1e-12);
    let steps = (pair.end() / pair.step()).round() as usize;
    let (s3, s16) = (State::at_rest(7), State::at_rest(33));
    const H: f64 = 2e-6;
    type E<'a> = (&'static str, Box<dyn Fn() -> (f64, u64, u64) + 'a>);
    let entrants: Vec<E> = vec![
        ("A rk4 hand shared", Box::new(|| (hand_rk4(&pair, -6.4e-4, 0.0, pair.step(), steps)[0], 4 * steps as u64, 0))),
        ("A rk4 ours", Box::new(|| ours(&Rk4::new(pair.step()).plain(), &pair, &Pair::start(), pair.end()))),
        (
            "A dop hand",
            Box::new(|| {
                let (y, e, c) = hand_dop853::run(&pair, -6.4e-4, 0.0, pair.end(), 1e-8, 1e-12);
                (y[0], e, c)
            }),
        ),
        ("A dop ours", Box::new(|| ours(&dop, &pair, &Pair::start(), pair.end()))),
        ("B3 rk4 hand", Box::new(|| (hand_ring::rk4::<3, 14>(H, 100_000)[0], 400_000, 0))),
        ("B3 rk4 hand shared", Box::new(|| (hand_ring::rk4_shared::<3, 14>(H, 100_000)[0], 400_000, 0))),
        ("B3 rk4 ours", Box::new(|| ours(&Rk4::new(H).plain(), &b3, &s3, 0.2))),
        (
            "B3 dop hand",
            Box::new(|| {
                let (y, e, c) = hand_ring::dop853::<3, 14>(0.2, 1e-8, 1e-12);
                (y[0], e, c)
            }),
        ),
        ("B3 dop ours", Box::new(|| ours(&dop, &b3, &s3, 0.2))),
        ("B16 rk4 hand", Box::new(|| (hand_ring::rk4::<16, 66>(H, 100_000)[0], 400_000, 0))),
        ("B16 rk4 hand shared", Box::new(|| (hand_ring::rk4_shared::<16, 66>(H, 100_000)[0], 400_000, 0))),
        ("B16 rk4 ours", Box::new(|| ours(&Rk4::new(H).plain(), &b16, &s16, 0.2))),
        (
            "B16 dop hand",
            Box::new(|| {
                let (y, e, c) = hand_ring::dop853::<16, 66>(0.2, 1e-8, 1e-12);
                (y[0], e, c)
            }),
        ),
        ("B16 dop ours", Box::new(|| ours(&dop, &b16, &s16, 0.2))),
    ];
    let mut least = vec![f64::INFINITY; entrants.len()];
    for _ in 0..rounds {
        for ((name, f), least) in entrants.iter().zip(&mut least) {
            if !name.contains(&only) {
                continue;
            }
            let t = std::time::Instant::now();
            black_box(f());
            *least = least.min(t.elapsed().as_secs_f64());
        }
    }
    for ((name, f), least) in entrants.iter().zip(&least) {
        if !name.contains(&only) {
            continue;
        }
        let (q, e, c) = f();
        println!("{name:22} {:8.2} ms {:7.1} ns/eval {e:8} evals {c:5} edges q0 {q:.15e}", least * 1e3, least * 1e9 / e as f64);
    }
}
