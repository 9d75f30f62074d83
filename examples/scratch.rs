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
    let p = Pair::new();
    let s = Pair::start();
    let e = p.end();
    let (r, _) = count(&p, &Dop853::new().rtol(1e-13).atol(1e-18), &s, e);
    let (r2, _) = count(&p, &Dop853::new().rtol(1e-13).atol(1e-18).max_step(0.1), &s, e);
    println!("{r:?} {:e}", (r.q[0] - r2.q[0]) / 1e-5);
    let r = r2;
    for m in [1e-7, 1e-8, 1e-9] {
        let (x, _) = count(&p, &Dop853::new().rtol(m).atol(m * 1e-4), &s, e);
        println!("dop {m} {:e}", (x.q[0] - r.q[0]) / 1e-5);
    }
    let (x, _) = count(&Unheld(Pair::new()), &Dop853::new().rtol(1e-8).atol(1e-12), &s, e);
    println!("unheld {:e}", (x.q[0] - r.q[0]) / 1e-5);
    let (x, _) = count(&p, &Rk45::new().rtol(1e-8).atol(1e-12), &s, e);
    println!("rk45 {:e}", (x.q[0] - r.q[0]) / 1e-5);
    let (x, _) = count(&p, &Rk45::new().rtol(1e-8).atol(1e-12).plain(), &s, e);
    println!("rk45 plain {:e}", (x.q[0] - r.q[0]) / 1e-5);
    let (x, _) = count(&p, &Rk4::new(p.step()).plain(), &s, e);
    println!("rk4 plain {:e}", (x.q[0] - r.q[0]) / 1e-5);
    let (x, _) = count(&p, &Rk4::new(p.step()), &s, e);
    println!("rk4 located {:e}", (x.q[0] - r.q[0]) / 1e-5);
    let (x, _) = count(&p, &Rk4::new(p.step() / 2.0), &s, e);
    println!("rk4 located {:e}", (x.q[0] - r.q[0]) / 1e-5);
}
