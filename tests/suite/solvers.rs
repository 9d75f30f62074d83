//! Solvers: order, dense output, tolerances, end and output times, drive edges.

use crate::api::*;
use crate::common::{Forced, Impact, fixed_error, observed_order};
use gear_dynamics::models::Oscillator;
use proptest::prelude::*;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Every tableau on a non-autonomous problem: the order of convergence.
#[test]
fn orders_on_a_non_autonomous_problem() {
    let fixed = |n: f64| fixed_error(&Rk4::new(4.0 / n).plain(), 4.0);
    assert_eq!(observed_order(&fixed, &[20.0, 40.0, 80.0]), 4);
    // Steps of a given size: the tolerance is so large that `max_step` determines the step.
    let rk45 =
        |n: f64| fixed_error(&Rk45::new().rtol(0.5).atol(1e3).first_step(4.0 / n).max_step(4.0 / n), 4.0);
    assert_eq!(observed_order(&rk45, &[20.0, 40.0, 80.0]), 5);
    let dop853 =
        |n: f64| fixed_error(&Dop853::new().rtol(0.5).atol(1e3).first_step(4.0 / n).max_step(4.0 / n), 4.0);
    assert_eq!(observed_order(&dop853, &[5.0, 10.0, 20.0]), 8);
}

/// Dense output on the same problem: order 4 for the cubic of Rk4 and for Rk45, order 7 for Dop853.
#[test]
fn orders_of_the_dense_output() {
    let error = |solver: &dyn Fn(f64) -> f64, counts: &[f64]| observed_order(solver, counts);
    let inside = |step: &mut Step<'_>, worst: &mut f64| {
        let mut y = [0.0; 2];
        for theta in [0.21, 0.5, 0.83] {
            let t = step.t0() + theta * (step.t1() - step.t0());
            step.at(t, &mut y);
            *worst = worst.max((y[0] - Forced::q(t)).abs());
        }
        ControlFlow::Continue(())
    };
    let rk4 = |n: f64| {
        let mut worst = 0.0;
        Rk4::new(4.0 / n)
            .run(&Forced, &Forced::start(), 4.0, &mut |s: &mut Step<'_>| inside(s, &mut worst))
            .unwrap();
        worst
    };
    let rk45 = |n: f64| {
        let mut worst = 0.0;
        let solver = Rk45::new().rtol(0.5).atol(1e3).first_step(4.0 / n).max_step(4.0 / n);
        solver.run(&Forced, &Forced::start(), 4.0, &mut |s: &mut Step<'_>| inside(s, &mut worst)).unwrap();
        worst
    };
    let dop853 = |n: f64| {
        let mut worst = 0.0;
        let solver = Dop853::new().rtol(0.5).atol(1e3).first_step(4.0 / n).max_step(4.0 / n);
        solver.run(&Forced, &Forced::start(), 4.0, &mut |s: &mut Step<'_>| inside(s, &mut worst)).unwrap();
        worst
    };
    assert_eq!(error(&rk4, &[20.0, 40.0, 80.0]), 4);
    assert!(error(&rk45, &[20.0, 40.0, 80.0]) >= 4);
    assert!(error(&dop853, &[5.0, 10.0, 20.0]) >= 7);
}

/// Across contacts RK4 has order 4 with located edges, and a larger error without.
#[test]
fn order_across_contacts() {
    let truth = Dop853::new().rtol(1e-13).atol(1e-15).end(&Impact, &Impact::start(), 40.0).unwrap();
    let error = |solver: &Rk4| (solver.end(&Impact, &Impact::start(), 40.0).unwrap().q[0] - truth.q[0]).abs();
    let counts = [1600.0, 3200.0, 6400.0, 12800.0];
    let located: Vec<f64> = counts.iter().map(|n| error(&Rk4::new(40.0 / n))).collect();
    let plain: Vec<f64> = counts.iter().map(|n| error(&Rk4::new(40.0 / n).plain())).collect();
    println!("located {located:?}\nplain   {plain:?}");
    let order = (located[0] / located[3]).log2() / 3.0;
    assert!((order - 4.0).abs() < 0.3, "order {order}");
    assert!(plain[3] > 100.0 * located[3]);
}

#[test]
fn rk45_and_dop853_agree_across_contacts() {
    let ends = [
        Dop853::new().rtol(1e-12).atol(1e-14).end(&Impact, &Impact::start(), 60.0).unwrap(),
        Rk45::new().rtol(1e-12).atol(1e-14).end(&Impact, &Impact::start(), 60.0).unwrap(),
    ];
    assert!((ends[0].q[0] - ends[1].q[0]).abs() < 1e-9, "{} {}", ends[0].q[0], ends[1].q[0]);
}

#[test]
fn the_end_and_the_output_times_are_exact() {
    for end in [1.0, 0.1 + 0.2, 1e-9, 12.345_678] {
        assert_eq!(Dop853::new().end(&Forced, &Forced::start(), end).unwrap().t, end);
        assert_eq!(Rk4::new(0.037).end(&Forced, &Forced::start(), end).unwrap().t, end);
    }
    let times = [0.0, 0.0, 0.3, 0.3, 1.7, 2.0];
    let run = Rk45::new().sample(&Forced, &Forced::start(), &times).unwrap();
    assert_eq!(run.times(), times);
    assert_eq!(run.q(0), Forced::start().q);
    assert!((run.q(4)[0] - Forced::q(1.7)).abs() < 1e-7);
}

#[test]
fn tolerances_per_component() {
    let loose = Dop853::new().rtol(1e-14).atol_each(&[1e-2, 1e-2]);
    let tight = Dop853::new().rtol(1e-14).atol_each(&[1e-12, 1e-12]);
    let count =
        |solver: &Dop853| solver.trajectory(&Forced, &Forced::start(), 4.0).unwrap().stats().evaluations;
    assert!(2 * count(&loose) < count(&tight));
}

#[test]
fn pi_control_rejects_less() {
    let pair = NfgPair::new(&NfgParams::table1()).unwrap();
    let run = |beta: f64| {
        let solver = Dop853::new().rtol(1e-8).atol(1e-12).pi_beta(beta);
        solver.trajectory(&pair, &pair.on_drive_flank().unwrap(), pair.period()).unwrap().stats()
    };
    assert!(run(0.03).rejected < run(0.0).rejected);
}

/// No step extends over a jump of a drive, with any solver.
#[test]
fn drive_edges_are_met() {
    struct Square(Wave);
    impl Model for Square {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = u[0];
        }
        fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
            u[0] = self.0.value(TAU * t, side);
        }
        fn next_edge(&self, t: f64) -> Option<f64> {
            self.0.next_edge(TAU * t).map(|edge| edge / TAU)
        }
    }
    // v' is 1 while the wave is high and -1 while it is low. The high part, 0.3 of the period, is centred on
    // t = 0.
    let model = Square(Wave::new(RectangularWave::new(-1.0, 1.0, 0.3).unwrap()));
    let exact = |t: f64| {
        let whole = t.floor();
        let s = t - whole;
        let high = s.min(0.15) + (s - 0.85).max(0.0);
        whole * -0.4 + high - (s - high)
    };
    let check = |solver: &dyn Fn(f64) -> (State, u64)| {
        for end in [0.1, 0.5, 0.9, 3.33] {
            let (state, edges) = solver(end);
            assert!((state.v[0] - exact(end)).abs() < 1e-12, "{end}: {} {}", state.v[0], exact(end));
            assert_eq!(edges, [0, 1, 2, 7][[0.1, 0.5, 0.9, 3.33].iter().position(|t| *t == end).unwrap()]);
        }
    };
    fn run<I: Integrator>(solver: &I, model: &Square, t: f64) -> (State, u64) {
        let finish = solver
            .run(model, &State::at_rest(1), t, &mut |_: &mut Step<'_>| ControlFlow::Continue(()))
            .unwrap();
        (finish.state, finish.stats.drive_edges)
    }
    check(&|t| run(&Rk4::new(0.07), &model, t));
    check(&|t| run(&Rk45::new(), &model, t));
    check(&|t| run(&Dop853::new(), &model, t));
}

#[test]
fn an_observer_stops_a_run() {
    let mut steps = 0;
    let finish = Rk4::new(0.1)
        .run(&Forced, &Forced::start(), 10.0, &mut |_: &mut Step<'_>| {
            steps += 1;
            if steps == 7 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .unwrap();
    assert!(finish.stopped);
    assert!((finish.state.t - 0.7).abs() < 1e-12);
}

proptest! {
    /// Free motion in a dead zone without damping keeps its energy and has the period T = 2π + 4 b/(A - b).
    #[test]
    fn free_dead_zone_motion(b in 0.01..2.0f64, over in 0.01..5.0f64) {
        let model = crate::common::FreeDeadZone { b };
        let a = b + over;
        let period = std::f64::consts::TAU + 4.0 * b / over;
        let energy = |s: &State| 0.5 * s.v[0] * s.v[0] + 0.5 * (s.q[0].abs() - b).max(0.0).powi(2);
        let start = State::new(0.0, &[a], &[0.0]);
        let run = Dop853::new().rtol(1e-12).atol(1e-14).trajectory(&model, &start, 3.0 * period).unwrap();
        for i in 0..run.len() {
            prop_assert!((energy(&run.state(i)) - 0.5 * over * over).abs() < 1e-10 * over * over);
        }
        let end = run.last().unwrap();
        prop_assert!((end.q[0] - a).abs() < 1e-9 * a && end.v[0].abs() < 1e-8 * over);
        prop_assert_eq!(run.stats().crossings, 12);
    }

    /// For any tolerance the error is within a factor of 100 of it, which covers the growth of errors.
    #[test]
    fn tolerance_is_respected(exponent in 4.0..12.0f64) {
        let rtol = 10f64.powf(-exponent);
        let error = fixed_error(&Dop853::new().rtol(rtol).atol(rtol), 4.0);
        prop_assert!(error < 100.0 * rtol, "{} for {}", error, rtol);
    }
}

/// `Dop853` across the kinks of a plain formula, 60 oscillators with backlash: the errors against the same
/// models with located edges, in tolerances. With the combined estimate alone, which assumes a smooth
/// force, the median is 8.2 and the largest error 245.
#[test]
fn errors_at_kinks_that_no_contact_declares() {
    let mut seed = 7u64;
    let mut draw = |low: f64, high: f64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut errors: Vec<f64> = (0..60)
        .map(|_| {
            let [speed, c, k] = [draw(0.4, 2.0), draw(0.02, 0.3), draw(0.5, 3.0)];
            let [mean, force, b] = [draw(-0.5, 0.5), draw(0.2, 1.0), draw(0.05, 0.8)];
            let start = State::new(0.0, &[draw(-0.5, 0.5)], &[draw(-0.5, 0.5)]);
            let plain = from_fn(1, |t, q, v, a| {
                let touching = if q[0].abs() > b { q[0] - b.copysign(q[0]) } else { 0.0 };
                a[0] = mean + force * (speed * t).cos() - c * v[0] - k * touching;
            });
            let declared = Oscillator::new(&[
                ("speed", speed),
                ("damping", c),
                ("mesh stiffness", k),
                ("mean force", mean),
                ("force", force),
                ("half backlash", b),
            ]);
            let end = Dop853::new().rtol(1e-8).atol(1e-10).end(&plain.unwrap(), &start, 18.0).unwrap();
            let truth = Dop853::new().rtol(1e-13).atol(1e-15).end(&declared.unwrap(), &start, 18.0).unwrap();
            (end.q[0] - truth.q[0]).abs().max((end.v[0] - truth.v[0]).abs()) / 1e-8
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    println!("median {:.2}, largest {:.1} tolerances", errors[30], errors[59]);
    assert!(errors[30] < 3.0 && errors[59] < 120.0, "{} {}", errors[30], errors[59]);
}

/// Solvers, models and observers as trait objects: every solver ends the same motion, boxed models are models,
/// and all of several observers receive each step.
#[test]
fn trait_objects_of_solvers_models_and_observers() {
    let spring = || from_fn(1, |_, q, _, a| a[0] = -q[0]).unwrap();
    let models: [Box<dyn Model>; 3] =
        [Box::new(spring()), Box::new(Box::new(spring())), Box::new(std::sync::Arc::new(spring()))];
    let (rk4, rk45, dop853) = (Rk4::new(0.01), Rk45::new().rtol(1e-10), Dop853::new().rtol(1e-10));
    let solvers: [&dyn Integrator; 3] = [&rk4, &rk45, &dop853];
    let start = State::new(0.0, &[1.0], &[0.0]);
    for (model, solver) in models.iter().flat_map(|model| solvers.map(|solver| (model, solver))) {
        let boxed: Box<dyn Integrator + '_> = Box::new(solver);
        let end = boxed.end(model, &start, 1.0).unwrap();
        assert!((end.q[0] - 1f64.cos()).abs() < 1e-8, "{}", end.q[0]);
        let mut counts = [0; 6];
        let [a, b, c, d, e, f] = counts.each_mut().map(|count| {
            move |_: &mut Step<'_>| {
                *count += 1;
                if *count == 4 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            }
        });
        let (mut a, mut b, mut c, mut d, mut e, mut f) = (a, b, c, d, e, f);
        let (mut one, mut two): ([&mut dyn Observer; 1], [&mut dyn Observer; 1]) = ([&mut d], [&mut e]);
        let mut slice: &mut [&mut dyn Observer] = &mut two;
        let mut list: Vec<&mut dyn Observer> = vec![&mut one, &mut slice, &mut f];
        let mut all = (&mut (&mut a, &mut b, &mut c), &mut list);
        let finish = solver.run(&**model, &start, 10.0, &mut all).unwrap();
        assert!(finish.stopped && counts == [4; 6], "{counts:?}");
    }
}
