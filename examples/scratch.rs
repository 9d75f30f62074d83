//! scratch
#[path = "../benches/common/mod.rs"]
mod common;
use common::*;
use gear_dynamics::*;
use std::ops::ControlFlow;
fn main() {
    let p = Pair::new();
    let s = Pair::start();
    let n = (p.end() / p.step()).round() as usize;
    let hand = std::env::args().nth(1);
    match hand.as_deref() {
        Some("hand") => println!("{:?}", hand_rk4(&p, -6.4e-4, 0.0, p.step(), n)),
        Some(_) => println!("{:?}", Rk4::new(p.step()).plain().run(&p, &s, p.end(), &mut |_: &mut Step<'_>| ControlFlow::Continue(())).unwrap()),
        None => {
            for _ in 0..4 {
                let (mut a, mut b) = (f64::INFINITY, f64::INFINITY);
                for _ in 0..80 {
                    let t = std::time::Instant::now();
                    std::hint::black_box(Rk4::new(p.step()).plain().run(&p, &s, p.end(), &mut |_: &mut Step<'_>| ControlFlow::Continue(())).unwrap());
                    a = a.min(t.elapsed().as_secs_f64());
                    let t = std::time::Instant::now();
                    std::hint::black_box(hand_rk4(std::hint::black_box(&p), -6.4e-4, 0.0, p.step(), n));
                    b = b.min(t.elapsed().as_secs_f64());
                }
                println!("{a} {b} {}", a / b);
            }
        }
    }
}
