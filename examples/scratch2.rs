//! scratch
#[path = "../benches/common/mod.rs"]
mod common;
use common::*;
use gear_dynamics::*;
use std::ops::ControlFlow;
fn count<M: Model>(m: &M, s: &impl Integrator, st: &State, e: f64) -> (State, Stats) {
    let t0 = std::time::Instant::now();
    let f = s.run(m, st, e, &mut |_: &mut Step<'_>| ControlFlow::Continue(())).unwrap();
    println!("{:?} {:?}", f.stats, t0.elapsed());
    (f.state, f.stats)
}
fn main() {
    for (n, t) in [(3, 2.0), (16, 2.0),(3, 20.0), (16, 20.0)] {
        let r = ring(n, t);
        let s = State::at_rest(2 * n + 1);
        let (x, _) = count(&r, &Dop853::new().rtol(1e-13).atol_each(&[vec![1e-19; 2*n+1], vec![1e-15; 2*n+1]].concat()), &s, 0.2);
        let err = |y: &State| y.q.iter().zip(&x.q).fold(0.0, |m: f64, (a, b)| m.max((a-b).abs()/1e-4)).max(y.v.iter().zip(&x.v).fold(0.0, |m: f64, (a, b)| m.max((a-b).abs())));
        let (y, _) = count(&r, &Dop853::new().rtol(3e-13).atol_each(&[vec![1e-18; 2*n+1], vec![1e-14; 2*n+1]].concat()), &s, 0.2);
        println!("ref {n} {:e}", err(&y));
        let (y, _) = count(&r, &Dop853::new().rtol(1e-8).atol(1e-12), &s, 0.2);
        println!("{n} {:e}", err(&y));
        let (y, _) = count(&r, &Dop853::new().rtol(1e-8).atol(1e-12).pi_beta(0.04), &s, 0.2);
        println!("{n} pi {:e}", err(&y));
        let (y, _) = count(&r, &Dop853::new().rtol(1e-8).atol(1e-12).plain(), &s, 0.2);
        println!("{n} plain {:e}", err(&y));
        let (y, _) = count(&r, &Rk4::new(2e-6).plain(), &s, 0.2);
        println!("{n} rk4 {:e}", err(&y));
    }
    let p = Pair::new();
    for b in [0.0, 0.02, 0.04, 0.06, 0.08] {
        let (y, _) = count(&p, &Dop853::new().rtol(1e-8).atol(1e-12).pi_beta(b), &Pair::start(), p.end());
        println!("A beta {b} {:e}", y.q[0]);
    }
}
