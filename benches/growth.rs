//! How the time of every default path grows with the number of gears in a ring.
//!
//! `cargo bench --bench growth` prints, for each path, the times at 16, 32, 64, .. gears and the line
//! `ratio growth PATH p`: time ~ gears^p, fitted to the last three sizes. A path ends at 1024 gears, or once one
//! call exceeds three seconds. An argument selects the paths whose names contain it.

mod common;

use gear_dynamics::check::check_model;
use gear_dynamics::linear::{Campbell, Modes, static_state};
use gear_dynamics::models::ring::RingParams;
use gear_dynamics::ode::Rodas;
use gear_dynamics::sweep::{Axis, LaneRk4, Point, Points};
use gear_dynamics::trains::{Train, Warning, ring_parts};
use gear_dynamics::{
    Balance, Dop853, Harmonics, Integrator, ParameterError, Periodic, Ring, Rk4, Rk45, Settle, Shooting,
    State, Sweep, Taylor,
};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Sizes of the ring.
const SMALLEST: usize = 16;
const LARGEST: usize = 1024;
/// A path ends once one call takes longer.
const LONGEST: Duration = Duration::from_secs(3);
/// Calls are repeated until they have taken this time together; the shortest counts.
const REPEATED: Duration = Duration::from_millis(60);

/// A ring with its default start.
struct Sized {
    params: RingParams,
    ring: Ring,
    start: State,
}

impl Sized {
    fn new(gears: usize) -> Self {
        let params = common::ring_params(gears, 1.5e-3, 2.0);
        let ring = Ring::as_printed(&params).expect("the parameters are in range");
        let start = static_state(&ring, None).expect("the ring has a static state").state;
        Sized { params, ring, start }
    }
    fn period_by(&self, solver: &dyn Integrator) {
        black_box(solver.end(&self.ring, &self.start, self.ring.period()).expect("it runs"));
    }
    /// The ring from parts.
    fn train(&self) -> Train {
        let mut parts = ring_parts(&self.params, 20).expect("all gears are equal");
        parts.accept(Warning::Unbalanced).build("gear 1", self.params.omega / 20.0).expect("it is a ring")
    }
}

/// Two points of a sweep in lanes.
fn sweep(sized: &Sized) {
    let points = Points::from(Axis::linear("speed", 900.0, 1000.0, 2).expect("the range is in order"));
    let family = |p: &Point<'_>| sized.ring.with(&sized.ring.names()[0].name, p["speed"]);
    let rows = Sweep::new(points)
        .settle(0)
        .measure(1)
        .of(&LaneRk4::new(64), family)
        .start(|_, _| Ok::<_, ParameterError>(sized.start.clone()))
        .run()
        .expect("the ring runs");
    black_box(rows);
}

/// A default path by its name.
type Path = (&'static str, fn(&Sized));

/// The paths. The time of a call that ends without convergence counts, too.
fn paths() -> Vec<Path> {
    vec![
        ("build", |s| drop(black_box(Ring::as_printed(&s.params)))),
        ("build from parts", |s| drop(black_box(s.train()))),
        ("static state", |s| drop(black_box(static_state(&s.ring, None)))),
        ("modes", |s| drop(black_box(Modes::mean_in_contact(&s.ring)))),
        ("Campbell diagram, two speeds", |s| {
            drop(black_box(Campbell::of(&s.ring, &[500.0, 1000.0], &[1.0])))
        }),
        ("check", |s| drop(black_box(check_model(&s.ring, &s.start)))),
        ("RK4", |s| s.period_by(&Rk4::new(s.ring.period() / 64.0))),
        ("RK45", |s| s.period_by(&Rk45::new())),
        ("DOP853", |s| s.period_by(&Dop853::new())),
        ("Taylor", |s| s.period_by(&Taylor::new())),
        ("Rodas", |s| s.period_by(&Rodas::new())),
        ("lanes", sweep),
        ("settling, eight periods", |s| {
            drop(black_box(Settle::new().max_periods(8).run(&Dop853::new(), &s.ring, &s.start)))
        }),
        ("shooting, one correction", |s| {
            drop(black_box(Shooting::new().max_iterations(1).solve(&s.ring, &s.start)))
        }),
        ("balance on one flank, five orders", |s| {
            let balance = Balance::new(Harmonics::up_to(5));
            drop(black_box(balance.linearised(&s.ring, gear_dynamics::contact::Piece::Upper)));
        }),
    ]
}

/// The shortest time of a call.
fn time(path: fn(&Sized), sized: &Sized) -> Duration {
    let (begun, mut shortest) = (Instant::now(), Duration::MAX);
    loop {
        let call = Instant::now();
        path(sized);
        shortest = shortest.min(call.elapsed());
        if begun.elapsed() > REPEATED {
            return shortest;
        }
    }
}

/// The slope of the logarithms over the last three sizes, which double: half the logarithm of the last time over
/// the first.
fn exponent(times: &[f64]) -> Option<f64> {
    let &[.., first, _, last] = times else { return None };
    Some(0.5 * (last / first).log2())
}

fn main() {
    let chosen: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let all = paths();
    let mut times = vec![Vec::new(); all.len()];
    let mut gears = SMALLEST;
    while gears <= LARGEST {
        let sized = Sized::new(gears);
        for ((name, path), times) in all.iter().zip(&mut times) {
            let ended = times.last().is_some_and(|last| *last > LONGEST.as_secs_f64());
            if !ended && (chosen.is_empty() || chosen.iter().any(|part| name.contains(part.as_str()))) {
                times.push(time(*path, &sized).as_secs_f64());
                println!("{name}, {gears} gears: {:.6} s", times[times.len() - 1]);
            }
        }
        gears *= 2;
    }
    for ((name, _), times) in all.iter().zip(&times) {
        if let Some(exponent) = exponent(times) {
            println!("ratio growth {name} {exponent:.2}");
        }
    }
}
