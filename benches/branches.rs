//! Time of whole frequency responses by continuation, with the multipliers of every point: the workloads D
//! of the comparison with other programs. `cargo bench --bench branches`.
//!
//! - Duffing: q'' + 0.05 q' + q + 0.1 q³ = 0.18 cos Ω t, Ω = 0.5 .. 1.6 (example 1 of NLvib);
//! - dead zone: q'' + 0.1 q' + g(q) = 0.25 + 0.25 cos Ω t with the half width 1, Ω = 2.5 .. 0.4.
//!
//! By harmonic balance with the orders 0 .. 10 and exact switching, and by shooting.

use gear_dynamics::branches::{Branch, ByConstant, Continuation};
use gear_dynamics::contact::{Contact, Deflection, PieceChoice};
use gear_dynamics::excitation::{Angle, Fourier, Side};
use gear_dynamics::model::{Channel, Drives, Scalar, Size};
use gear_dynamics::periodic::FourierOrbit;
use gear_dynamics::{Backlash, Balance, Harmonics, Machine, Periodic, Shape, State, Wave};
use std::time::Instant;

#[derive(PartialEq)]
struct Duffing(Wave);

impl Shape for Duffing {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, contacts: 0, constants: 1 }
    }
    fn constants(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.0.value(angle, side);
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        _: &L,
        _: usize,
        _: Drives<'_, S>,
        _: &[S],
        _: &[S],
    ) -> Contact<S> {
        Contact::default()
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [cos] = u.waves();
        a[0] = cos * 0.18 - v[0] * 0.05 - q[0] - q[0] * q[0] * q[0] * 0.1;
    }
}

#[derive(PartialEq)]
struct DeadZone(Wave, Backlash);

impl Shape for DeadZone {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, contacts: 1, constants: 1 }
    }
    fn constants(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.0.value(angle, side);
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        _: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let (lower, upper) = (S::from(-1.0), S::from(1.0));
        let force = law.force(i, &self.1, Deflection { x: q[0], rate: v[0], lower, upper });
        Contact { deflection: q[0], rate: v[0], lower, upper, force, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [cos] = u.waves();
        a[0] = S::from(0.25) + cos * 0.25 - v[0] * 0.1 - self.contact(law, 0, u, q, v).force;
    }
}

fn cosine() -> Wave {
    Wave::new(Fourier::new(0.0, &[[1.0, 0.0]]).expect("finite"))
}

fn report(
    name: &str,
    model: &Machine<impl Shape>,
    continuation: &Continuation,
    others: &[(&str, f64)],
    start: f64,
) {
    let family = ByConstant::new(model, "speed").expect("a constant");
    let continuation = continuation.clone().balance(Balance::new(Harmonics::up_to(10)));
    let guess =
        FourierOrbit::new(&Harmonics::up_to(1), model.period(), &[vec![start, 0.1, 0.1]]).expect("finite");
    // The default steps, then shorter ones, with about as many points as the others compute.
    let short = continuation.clone().first_step(0.004).max_step(0.018);
    for (steps, continuation) in [("default steps", &continuation), ("short steps", &short)] {
        let by_balance = || continuation.run(&family, &guess).expect("an orbit");
        let branch = by_balance();
        if !std::ptr::eq(continuation, &short) {
            println!("{name}: {branch}");
        }
        let milliseconds = least(50, || drop(by_balance()));
        println!("  balance, {steps}: {} points in {milliseconds:.2} ms", branch.points().len());
        for (other, theirs) in others {
            println!("    {other}: {theirs} ms, {:.1} times as long", theirs / milliseconds);
        }
    }
    let by_shooting = || continuation.run(&family, &[State::new(0.0, &[start], &[0.0])]).expect("an orbit");
    let branch: Branch = by_shooting();
    let milliseconds = least(5, || drop(by_shooting()));
    println!("  shooting: {} points in {milliseconds:.2} ms\n", branch.points().len());
}

/// Least time of several runs in milliseconds.
fn least(runs: usize, mut run: impl FnMut()) -> f64 {
    let time = |run: &mut dyn FnMut()| {
        let begun = Instant::now();
        run();
        1e3 * begun.elapsed().as_secs_f64()
    };
    (0..runs).map(|_| time(&mut run)).fold(f64::INFINITY, f64::min)
}

fn main() {
    // `cargo test --benches` runs each bench with this argument: it does not measure.
    if std::env::args().any(|arg| arg == "--test") {
        return;
    }
    // Times of the others: CPU time of another machine, release builds, with about 200 .. 260 points.
    let duffing = Machine::with_constants(Duffing(cosine()), &[("speed", 0.5)]).expect("valid");
    let others = [("AUTO-07p, with stability", 50.0), ("pyHarm 1.2.2, without stability", 380.0)];
    report("Duffing", &duffing, &Continuation::new(0.5, 1.6), &others, 0.0);
    let law = Backlash::new(1.0).expect("a width");
    let dead_zone = Machine::with_constants(DeadZone(cosine(), law), &[("speed", 2.5)]).expect("valid");
    let others = [("AUTO-07p, with stability", 145.0), ("pyHarm 1.2.2, without stability", 590.0)];
    report("dead zone", &dead_zone, &Continuation::new(2.5, 0.4), &others, 1.2);
}
