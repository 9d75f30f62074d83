//! The Rosenbrock method on stiff models: closed forms, orders of step and dense output, located edges and rigid stops
//! against an explicit method, orbits.

use crate::api::*;
use crate::impact_lists::Ball;
use gear_dynamics::models::Oscillator;
use gear_dynamics::num_complex::Complex64;
use gear_dynamics::ode::Rodas;
use std::ops::ControlFlow;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn quiet(_: &mut Step<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// A pair that loses contact, with a Jacobian and pieces.
fn rattling_pair() -> Oscillator {
    Oscillator::new(&[
        ("speed", 0.7),
        ("damping", 0.2),
        ("mesh stiffness", 1.0),
        ("stiffness variation", 0.2),
        ("mean force", 0.1),
        ("force", 0.3),
        ("half backlash", 0.2),
    ])
    .expect("constants in range")
}

/// q'' = -ω² (q - cos t) - c q': q = Re(ω²/(ω² - 1 + i c) e^{it}) after the decay. The number of steps is that of the slow
/// motion; explicit methods follow the fast decay.
#[test]
fn a_slow_motion_on_a_stiff_spring_takes_few_steps() -> Result<()> {
    for (square, damping) in [(1e8, 2e4), (1e10, 1e3), (1e4, 1e6)] {
        let model = from_fn(1, |t, q, v, a| a[0] = -square * (q[0] - t.cos()) - damping * v[0])?;
        let response = Complex64::from(square) / Complex64::new(square - 1.0, damping);
        let at = |t: f64| (response * Complex64::cis(t)).re;
        let rate = -(response * Complex64::cis(0.0)).im;
        let start = State::new(0.0, &[at(0.0)], &[rate]);
        for rtol in [1e-4, 1e-6, 1e-8] {
            let solver = Rodas::new().rtol(rtol).atol(1e-3 * rtol);
            let run = solver.run(&model, &start, 3.0, &mut quiet)?;
            let off = (run.state.q[0] - at(3.0)).abs();
            assert!(off < 10.0 * rtol, "{square:e} {damping:e} at {rtol:e}: {off:e}");
            // Of the fast decay, 3 s are 1e4 to 3e6 times.
            assert!(run.stats.steps < 1000, "{square:e} {damping:e} {rtol:e}: {:?}", run.stats);
        }
    }
    let model = from_fn(1, |t, q, v, a| a[0] = -1e8 * (q[0] - t.cos()) - 2e4 * v[0])?;
    let start = State::new(0.0, &[1.0], &[0.0]);
    let steps = |run: Finish| run.stats.steps;
    let explicit = steps(Dop853::new().rtol(1e-6).atol(1e-9).run(&model, &start, 3.0, &mut quiet)?);
    let implicit = steps(Rodas::new().rtol(1e-6).atol(1e-9).run(&model, &start, 3.0, &mut quiet)?);
    assert!(explicit > 10_000 && implicit < 150, "{explicit} {implicit}");
    Ok(())
}

/// Order 4 of the steps and order 3 of the dense output, of a nonlinear forced model with Jacobian by differences.
#[test]
fn orders_of_steps_and_of_the_dense_output() -> Result<()> {
    let model = from_fn(1, |t, q, v, a| {
        a[0] = (0.7 * t).cos() - q[0] - 0.3 * q[0].powi(3) - 0.2 * v[0].powi(3);
    })?;
    let start = State::new(0.0, &[0.5], &[0.2]);
    let exact = Dop853::new().rtol(1e-13).atol(1e-15);
    let truth = exact.end(&model, &start, 10.0)?;
    let inside = exact.sample(&model, &start, &[5.03])?;
    let errors = |h: f64| -> Result<[f64; 2]> {
        let mut within = f64::NAN;
        let mut watch = |step: &mut Step<'_>| {
            if step.t0() <= 5.03 && step.t1() > 5.03 {
                let mut y = [0.0; 2];
                step.at(5.03, &mut y);
                within = (y[0] - inside.q(0)[0]).hypot(y[1] - inside.v(0)[0]);
            }
            ControlFlow::Continue(())
        };
        let fixed = Rodas::new().rtol(0.9).atol(1e9).first_step(h).max_step(h);
        let end = fixed.run(&model, &start, 10.0, &mut watch)?.state;
        Ok([(end.q[0] - truth.q[0]).hypot(end.v[0] - truth.v[0]), within])
    };
    // 5.03 lies at 0.3 of a step of 0.1 and at 0.2 of one of 0.025.
    let [coarse, fine] = [errors(0.1)?, errors(0.025)?];
    assert!((128.0..1024.0).contains(&(coarse[0] / fine[0])), "{coarse:?} {fine:?}");
    assert!(coarse[1] / fine[1] > 64.0 && fine[1] < 1e-7, "{coarse:?} {fine:?}");
    Ok(())
}

/// Crossings and states of located edges are those of the explicit method; the rebounds of a ball have a closed form.
#[test]
fn edges_are_located_as_by_explicit_methods() -> Result<()> {
    let pair = rattling_pair();
    let start = State::new(0.0, &[0.25], &[0.0]);
    let by_dop853 = Dop853::new().rtol(1e-12).atol(1e-14).run(&pair, &start, 40.0, &mut quiet)?;
    let by_rodas = Rodas::new().rtol(1e-10).atol(1e-12).run(&pair, &start, 40.0, &mut quiet)?;
    assert!(by_dop853.stats.crossings > 10);
    assert_eq!(by_rodas.stats.crossings, by_dop853.stats.crossings);
    assert!((by_rodas.state.q[0] - by_dop853.state.q[0]).abs() < 1e-7);

    // A ball on a rigid floor with e = 0.7.
    let ball = Ball::with_stop(1.0, Restitution::new(0.7)?);
    let drop = State::new(0.0, &[0.5], &[0.0]);
    let run = Rodas::new().rtol(1e-10).atol(1e-12).run(&ball, &drop, 3.0, &mut quiet)?;
    // It falls for 1 s, rises with 0.7 for 0.7 s and falls again for 0.7 s: at 3 s it has risen with 0.49 for 0.6 s.
    assert_eq!(run.stats.crossings, 2);
    assert!((run.state.q[0] - (0.49 * 0.6 - 0.5 * 0.36)).abs() < 1e-9, "{:?}", run.state);
    assert!((run.state.v[0] - (0.49 - 0.6)).abs() < 1e-9, "{:?}", run.state);
    Ok(())
}

/// A model at rest stays there, and a model without motion of one coordinate is solved.
#[test]
fn models_at_rest() -> Result<()> {
    let rest = from_fn(2, |_, q, v, a| {
        a[0] = -1e8 * q[0] - 1e4 * v[0];
        a[1] = 1.0 - q[1];
    })?;
    let end = Rodas::new().end(&rest, &State::at_rest(2), 2.0)?;
    assert!(end.q[0] == 0.0 && (end.q[1] - (1.0 - 2f64.cos())).abs() < 1e-7, "{end:?}");
    Ok(())
}

/// An orbit by the implicit method, through the variational equations.
#[test]
fn orbits_by_the_implicit_method() -> Result<()> {
    let pair = rattling_pair();
    let steady = Settle::new().run(&Dop853::new(), &pair, &State::new(0.0, &[0.3], &[0.0]))?.state;
    let exact = Shooting::new().solve(&pair, &steady)?;
    let orbit = Shooting::new().integrator(Rodas::new().rtol(1e-10).atol(1e-12)).solve(&pair, &steady)?;
    assert_eq!(orbit.crossing_count(), exact.crossing_count());
    let [a, b] = [&orbit, &exact].map(|orbit| orbit.states()[0].q[0]);
    assert!((a - b).abs() < 1e-8, "{a} {b}");
    let [a, b] = [&orbit, &exact].map(|orbit| orbit.multipliers().largest());
    assert!((a - b).abs() < 1e-6, "{a} {b}");
    Ok(())
}

/// A coordinate without a force decays to nothing beside others that move: it does not spoil the differences of a formula.
#[test]
fn a_coordinate_that_decays_to_nothing() -> Result<()> {
    for (square, damping) in [(1e4, 200.0), (1e2, 20.0), (1e8, 2e4), (1.0, 0.5)] {
        let model = from_fn(2, |_, q, v, a| {
            (a[0], a[1]) = (-q[0], -square * q[1] - damping * v[1]);
        })?;
        let end = if damping < 1.0 { 4000.0 } else { 100.0 };
        let state = Rodas::new().end(&model, &State::new(0.0, &[1.0, 1.0], &[0.0, 0.0]), end)?;
        assert!((state.q[0] - end.cos()).abs() < 1e-6 * end && state.q[1].abs() < 1e-15, "{state:?}");
    }
    Ok(())
}
