//! Crossings at the ends of steps are reported once, and a motion that stays on an undeclared jump is refused.

use crate::api::*;
use crate::common::random::Random;
use gear_dynamics::contact::{Deflection, PieceChoice};
use gear_dynamics::excitation::RectangularWave;
use gear_dynamics::model::{Drives, Scalar, Size};
use gear_dynamics::models::Oscillator;
use gear_dynamics::trains::{Body, MeshPart, Parts};
use gear_dynamics::{Machine, Shape, Wave};
use std::ops::ControlFlow;

/// A contact with the deflection (t - a)(t - b) above the lower edge 0, on a motion q'' = q that it does not touch.
struct Window([f64; 2]);

impl Model for Window {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = q[0];
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], _: &[f64], _: &[f64], out: &mut [Contact]) {
        let ([a, b], t) = (self.0, u[0]);
        let (deflection, rate) = ((t - a) * (t - b), 2.0 * t - a - b);
        out[0] = Contact { deflection, rate, lower: 0.0, upper: f64::INFINITY, ..Contact::default() };
    }
}

/// A ball on a damped floor, whose force jumps at the edge, or a pair with damping in contact alone.
struct Damped {
    pull: [f64; 2],
    stiffness: f64,
    damping: f64,
    edges: [f64; 2],
}

impl Model for Damped {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let [lower, upper] = self.edges;
        let depth = (q[0] - upper).max(0.0) + (q[0] - lower).min(0.0);
        let drag = if depth == 0.0 { 0.0 } else { self.damping * v[0] };
        a[0] = self.pull[0] + self.pull[1] * (0.75 * u[0]).cos() - self.stiffness * depth - drag;
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let [lower, upper] = self.edges;
        out[0] = Contact { deflection: q[0], rate: v[0], lower, upper, ..Contact::default() };
    }
}

/// The times of all crossings. Each leaves the piece that the one before entered.
fn crossings(
    solver: &impl Integrator,
    model: &impl Model,
    start: &State,
    end: f64,
) -> Result<Vec<f64>, IntegrateError> {
    let (mut times, mut last) = (Vec::new(), None);
    let mut watch = |step: &mut Step<'_>| {
        for crossing in step.crossings() {
            assert!(last.is_none_or(|piece| piece == crossing.from), "{:?} {last:?}", step.t1());
            last = Some(crossing.to);
            times.push(step.t1());
        }
        ControlFlow::Continue(())
    };
    let finish = solver.run(model, start, end, &mut watch)?;
    assert_eq!(finish.stats.crossings as usize, times.len());
    Ok(times)
}

/// A step that begins at a crossing takes its first derivative behind the edge. With a force that jumps there, and without
/// pieces, the state of the crossing may lie before the edge; the error of one step was then 75 times its estimate.
#[test]
fn steps_that_begin_on_a_jump_follow_the_tolerance() -> Result<(), IntegrateError> {
    let pair = Damped { pull: [0.44, 0.3], stiffness: 4.0, damping: 0.5, edges: [-1.9, 1.9] };
    let start = State::new(0.0, &[0.11], &[0.4]);
    let exact = Dop853::new().rtol(1e-13).atol(1e-15).end(&pair, &start, 3.6)?;
    for k in 0..100 {
        let rtol = 1e-6 * 0.88f64.powi(k);
        for end in [
            Rk45::new().rtol(rtol).atol(1e-2 * rtol).end(&pair, &start, 3.6)?,
            Dop853::new().rtol(rtol).atol(1e-2 * rtol).end(&pair, &start, 3.6)?,
        ] {
            let off = (end.q[0] - exact.q[0]).abs().max((end.v[0] - exact.v[0]).abs());
            println!("{rtol:e} {:.1}", off / rtol);
            assert!(off < 40.0 * rtol + 1e-11, "{rtol:e}: {off:e}");
        }
    }
    Ok(())
}

/// Crossings of the pair of the next test by 200 000 steps of RK4, each crossing by bisection.
const CROSSINGS: usize = 47;

/// Steps at a kink become shorter than the slack when the tolerance is tight: the crossing is still reported.
#[test]
fn tight_tolerances_lose_no_crossing() -> Result<(), IntegrateError> {
    let ball = Damped { pull: [-9.81, 0.0], stiffness: 1e6, damping: 20.0, edges: [0.0, 1.0] };
    let pair = Damped { pull: [0.1, 0.12], stiffness: 1.0, damping: 0.5, edges: [-1.0, 1.0] };
    for rtol in [1e-8, 1e-9, 1e-10, 1e-11, 1e-12] {
        let high = Dop853::new().rtol(rtol).atol(rtol / 100.0);
        let low = Rk45::new().rtol(rtol).atol(rtol / 100.0);
        let start = State::new(0.0, &[0.5], &[0.0]);
        assert_eq!(crossings(&high, &ball, &start, 2.0)?.len(), 6, "{rtol}");
        assert_eq!(crossings(&low, &ball, &start, 2.0)?.len(), 6, "{rtol}");
        // The first fall takes √(2 0.5/9.81).
        let first = crossings(&high, &ball, &start, 2.0)?[0];
        assert!((first - (1f64 / 9.81).sqrt()).abs() < 1e-8, "{first}");
        let start = State::new(0.0, &[1.2], &[0.0]);
        let all = crossings(&high, &pair, &start, 200.0)?;
        assert_eq!([all.len(), crossings(&low, &pair, &start, 200.0)?.len()], [CROSSINGS; 2], "{rtol}");
    }
    Ok(())
}

/// Edges of time alone, on step ends and beside them: both roots are found, once.
#[test]
fn roots_on_step_ends_are_found_once() -> Result<(), IntegrateError> {
    let start = State::new(0.0, &[1.0], &[0.0]);
    let mut random = Random(7);
    for case in 0..300 {
        let h = [0.1, 0.05, 0.025, 0.2][case % 4];
        let i = 1.0 + ((0.5 * random.next()) / h).floor();
        let j = i + 1.0 + ((0.3 * random.next()) / h).floor();
        let shift = |k: usize| [0.0, 0.0, 1e-15, -1e-15, 1e-12, -1e-12, 1e-9, -1e-9, 1e-6, -1e-6][k % 10];
        let roots = [i * h + shift(case / 4), j * h + shift(case / 3)];
        let model = Window(roots);
        let end = roots[1] + 0.37 * h;
        let found = [
            crossings(&Dop853::new().first_step(h).max_step(h), &model, &start, end)?,
            crossings(&Rk45::new().first_step(h).max_step(h), &model, &start, end)?,
            crossings(&Rk4::new(h), &model, &start, end)?,
        ];
        for (solver, found) in found.iter().enumerate() {
            assert_eq!(found.len(), 2, "solver {solver}: {roots:?} with h = {h}: {found:?}");
            // The slack 1e-10 of the deflection, which is at most 1, over the rate at a root.
            let close = 1e-10 / (roots[1] - roots[0]) + 1e-12;
            assert!(found.iter().zip(roots).all(|(a, b)| (a - b).abs() < close), "{roots:?} {found:?}");
        }
    }
    Ok(())
}

/// q'' = 0.5 cos t - 0.3 q - μ s(v), s the sign or tanh(v/width).
fn friction(mu: f64, width: f64) -> impl Model {
    let law = move |v: f64| match width {
        0.0 if v == 0.0 => 0.0,
        0.0 => v.signum(),
        _ => (v / width).tanh(),
    };
    gear_dynamics::model::from_fn(1, move |t, q, v, a| a[0] = 0.5 * t.cos() - 0.3 * q[0] - mu * law(v[0]))
        .expect("one degree of freedom")
}

/// Friction that sticks is refused by name within few steps; friction that slides, and steep friction, are not.
#[test]
fn an_undeclared_sign_that_sticks_is_named() -> Result<(), IntegrateError> {
    let start = State::new(0.0, &[1.0], &[0.3]);
    for rtol in [1e-5, 1e-7, 1e-9, 1e-11] {
        let high = Dop853::new().rtol(rtol).atol(rtol / 100.0).max_steps(20_000);
        let low = Rk45::new().rtol(rtol).atol(rtol / 100.0).max_steps(20_000);
        for failed in
            [high.end(&friction(1.0, 0.0), &start, 30.0), low.end(&friction(1.0, 0.0), &start, 30.0)]
        {
            match failed {
                // 0.3 - 0.55 t about: it sticks before t = 1.
                Err(IntegrateError::Discontinuity { t, acceleration: 0 }) => assert!(t < 1.0, "{t}"),
                other => panic!("{rtol}: {other:?}"),
            }
        }
        high.end(&friction(0.2, 0.0), &start, 30.0)?;
        low.end(&friction(0.2, 0.0), &start, 30.0)?;
        high.end(&friction(0.2, 1e-6), &start, 30.0)?;
        for width in [1e-2, 1e-6] {
            high.clone().max_steps(2_000_000).end(&friction(1.0, width), &start, 0.5)?;
        }
    }
    Ok(())
}

/// Motions that stick where short steps are accepted, not rejected: a friction whose steps a Rosenbrock method
/// accepts, a stiff spring beside it, and a stiff body that changes its acceleration as much as the jump does.
#[test]
fn a_sign_that_sticks_in_accepted_steps_is_named() -> Result<(), Box<dyn std::error::Error>> {
    use gear_dynamics::model::from_fn;
    let stribeck = from_fn(1, |_, q, v, a| {
        let slip = v[0] - 0.5;
        a[0] = -q[0] - slip.signum() * (0.6 + 0.4 / (1.0 + slip.abs()));
    })?;
    let stiff = from_fn(1, |t, q, v, a| {
        a[0] = (20.0 * (300.0 * t).cos() - 1e6 * q[0] - 50.0 * v[0].signum()) / 0.5;
    })?;
    let beside = from_fn(2, |t, q, v, a| {
        a[0] = 0.5 * t.cos() - v[0].signum();
        a[1] = -1e4 * (q[1] - 1000.0 * t);
    })?;
    let [rest, pushed] = [State::at_rest(1), State::new(0.0, &[1e-5], &[1e-3])];
    let carried = State::new(0.0, &[0.0; 2], &[0.0, 1000.0]);
    let cases: [(&dyn Model, &State, f64); 3] =
        [(&stribeck, &rest, 10.0), (&stiff, &pushed, 0.01), (&beside, &carried, 1.0)];
    for rtol in [1e-4, 1e-6, 1e-8, 1e-10] {
        let high = Dop853::new().rtol(rtol).atol(rtol / 100.0).max_steps(100_000);
        let low = Rk45::new().rtol(rtol).atol(rtol / 100.0).max_steps(100_000);
        let implicit = gear_dynamics::ode::Rodas::new().rtol(rtol).atol(rtol / 100.0).max_steps(100_000);
        let solvers: [&dyn Integrator; 3] = [&high, &low, &implicit];
        for (number, (model, start, end)) in cases.iter().enumerate() {
            for (solver, integrator) in solvers.iter().enumerate() {
                match integrator.end(*model, start, *end) {
                    Err(IntegrateError::Discontinuity { acceleration: 0, .. }) => {}
                    other => panic!("case {number}, solver {solver}, {rtol}: {other:?}"),
                }
            }
        }
    }
    Ok(())
}

/// A motion that crosses an undeclared jump again and again, with many short steps each time, is not said to stick:
/// contacts with damping in contact only, as formulas, at tight tolerances. The end of the first one is that of RK4 with
/// bisected edges (n and 2n steps).
#[test]
fn a_motion_that_crosses_undeclared_jumps_is_not_named() -> Result<(), Box<dyn std::error::Error>> {
    let contact = |speed: f64, stiffness: f64, b: f64, loss: f64| {
        gear_dynamics::model::from_fn(1, move |t, q, v, a| {
            let cos = (speed * t).cos();
            let free = 0.416978321463606 + 0.21496367262289723 * cos - 0.15718149408850177 * v[0];
            let depth = q[0] - q[0].clamp(-b, b);
            let flank = stiffness * (1.0 + 0.1928117651704931 * cos) * depth;
            a[0] = free - 0.1 * q[0].powi(3) - if depth == 0.0 { 0.0 } else { flank + loss * v[0] };
        })
    };
    let start = State::new(0.0, &[-0.1574238474611632], &[0.20355689243560626]);
    let first = contact(1.7459805461221394, 4417.880751517769, 0.10764438115092063, 0.5)?;
    let tight = Dop853::new().rtol(3.1663645197569105e-12).atol(3.1663645197569105e-14);
    let end = tight.end(&first, &start, 22.29878814027579)?;
    assert!((end.q[0] + 0.019048376515655).abs() < 1e-8, "{end:?}");
    let mut random = Random(11);
    for _ in 0..40 {
        let model = contact(
            0.5 + 2.0 * random.next(),
            10f64.powf(2.0 + 3.0 * random.next()),
            0.02 + 0.2 * random.next(),
            2.0 * random.next(),
        )?;
        let rtol = 10f64.powf(-5.0 - 7.0 * random.next());
        Dop853::new().rtol(rtol).atol(rtol / 100.0).end(&model, &start, 20.0)?;
        Rk45::new().rtol(rtol.max(1e-10)).atol(rtol.max(1e-10) / 100.0).end(&model, &start, 20.0)?;
    }
    Ok(())
}

/// Motions that cross a jump ever more often while they decay are not said to stick: a ball on floors with damping in
/// contact only, as formulas, up to a share of the time sqrt(2/g) (1 + e)/(1 - e) at which rigid impacts would end; and a
/// relay with damping, q'' = -sign(q) - c q', whose energy decays as exp(-2 c t/3).
#[test]
fn a_decaying_motion_that_crosses_a_jump_is_not_named() -> Result<(), Box<dyn std::error::Error>> {
    use gear_dynamics::{model::from_fn, ode::Rodas};
    let run = |model: &dyn Model, q: f64, end: f64, rtol: f64| -> Result<(), IntegrateError> {
        let (atol, start) = (1e-3 * rtol, State::new(0.0, &[q], &[0.0]));
        Dop853::new().rtol(rtol).atol(atol).end(model, &start, end)?;
        if rtol > 1e-10 {
            Rk45::new().rtol(rtol).atol(atol).end(model, &start, end)?;
            Rodas::new().rtol(rtol).atol(atol).end(model, &start, end)?;
        }
        Ok(())
    };
    let floor = |k: f64, c: f64| {
        from_fn(1, move |_, q, v, a| a[0] = -9.81 - if q[0] < 0.0 { k * q[0] + c * v[0] } else { 0.0 })
    };
    let mut random = Random(5);
    for rtol in [1e-3, 1e-5, 1e-7, 1e-9, 1e-11] {
        run(&floor(1e5, 30.0)?, 1.0, 6.0, rtol)?;
        run(&from_fn(1, |_, q, v, a| a[0] = -q[0].signum() - 0.3 * v[0])?, 1.0, 50.0, rtol)?;
        for _ in 0..8 {
            let (k, ratio) = (10f64.powf(3.0 + 4.0 * random.next()), 0.01 + 0.15 * random.next());
            let e = (-std::f64::consts::PI * ratio / (1.0 - ratio * ratio).sqrt()).exp();
            let end = (2.0 / 9.81f64).sqrt() * (1.0 + e) / (1.0 - e) * (0.5 + 0.4 * random.next());
            run(&floor(k, 2.0 * ratio * k.sqrt())?, 1.0, end, rtol)?;
        }
    }
    Ok(())
}

/// A block on an incline and a body that slides on q + λ v = 0 are named within few steps, with accelerations on the
/// two sides of the jump that differ by up to 10⁵.
#[test]
fn a_motion_with_unequal_sides_of_a_jump_is_named() -> Result<(), Box<dyn std::error::Error>> {
    use gear_dynamics::{model::from_fn, ode::Rodas};
    for case in 0..12 {
        let weak = 10f64.powf(-5.0 * f64::from(case) / 11.0);
        let incline = from_fn(1, move |_, _, v, a| a[0] = if v[0] > 0.0 { -1.0 } else { weak })?;
        let surface = from_fn(1, move |_, q, v, a| a[0] = -(q[0] + (0.3 + weak) * v[0]).signum())?;
        for rtol in [1e-6, 1e-8, 1e-10] {
            let solvers: [&dyn Integrator; 3] = [
                &Dop853::new().rtol(rtol).atol(rtol / 100.0).max_steps(10_000),
                &Rk45::new().rtol(rtol).atol(rtol / 100.0).max_steps(10_000),
                &Rodas::new().rtol(rtol).atol(rtol / 100.0).max_steps(10_000),
            ];
            for solver in solvers {
                for (model, start) in [
                    (&incline as &dyn Model, State::new(0.0, &[0.0], &[0.7])),
                    (&surface, State::new(0.0, &[0.03], &[0.0])),
                ] {
                    let end = solver.end(model, &start, 10.0);
                    let named = matches!(end, Err(IntegrateError::Discontinuity { acceleration: 0, .. }));
                    assert!(named, "{weak:e} {rtol:e} {end:?}");
                }
            }
        }
    }
    Ok(())
}

/// Sticking beside a body whose acceleration is larger by 8 orders is named within few steps.
#[test]
fn a_sign_that_sticks_beside_a_fast_body_is_named() -> Result<(), Box<dyn std::error::Error>> {
    let model = gear_dynamics::model::from_fn(2, |t, q, v, a| {
        a[0] = 0.5 * t.cos() - v[0].signum();
        a[1] = -1e8 * q[1];
    })?;
    let start = State::new(0.0, &[0.0, 1.0], &[0.2, 0.0]);
    for rtol in [1e-7, 1e-9, 1e-11] {
        let high = Dop853::new().rtol(rtol).atol(rtol / 100.0).max_steps(100_000);
        match high.end(&model, &start, 0.5) {
            // 0.5 sin t - t = -0.2 at t = 0.39018.
            Err(IntegrateError::Discontinuity { t, acceleration: 0 }) => {
                assert!((t - 0.3902).abs() < 1e-3, "{t}");
            }
            other => panic!("{rtol}: {other:?}"),
        }
    }
    Ok(())
}

/// Two bodies that stick in turns are named, too.
#[test]
fn two_bodies_that_stick_are_named() {
    let both = gear_dynamics::model::from_fn(2, |t, q, v, a| {
        for i in 0..2 {
            a[i] = 0.5 * (t + i as f64).cos() - 0.3 * q[i] - [1.0, 1.2][i] * v[i].signum();
        }
    });
    let both = both.expect("two degrees of freedom");
    let start = State::new(0.0, &[1.0, 0.9], &[0.3, 0.28]);
    for rtol in [1e-5, 1e-7, 1e-9, 1e-11] {
        let high = Dop853::new().rtol(rtol).atol(rtol / 100.0).max_steps(20_000);
        let low = Rk45::new().rtol(rtol).atol(rtol / 100.0).max_steps(20_000);
        for failed in [high.end(&both, &start, 30.0), low.end(&both, &start, 30.0)] {
            match failed {
                Err(IntegrateError::Discontinuity { t, .. }) => assert!(t < 1.0, "{t}"),
                other => panic!("{rtol}: {other:?}"),
            }
        }
    }
}

/// q'' on a floor with k = 10⁶ and c = 2000, unloaded: after its one impact the contact creeps back to its edge and
/// does not rebound, x = -τ exp(-1000 τ).
#[test]
fn a_contact_that_creeps_back_to_its_edge_does_not_stall() -> Result<(), IntegrateError> {
    let floor = Damped { pull: [0.0; 2], stiffness: 1e6, damping: 2000.0, edges: [0.0, f64::INFINITY] };
    for rtol in [1e-6, 1e-9, 1e-12] {
        let atol = rtol / 100.0;
        let start = State::new(0.0, &[1.0], &[-1.0]);
        let high = Dop853::new().rtol(rtol).atol(atol).max_steps(20_000).end(&floor, &start, 2.0)?;
        let low = Rk45::new().rtol(rtol).atol(atol).max_steps(20_000).end(&floor, &start, 2.0)?;
        for end in [high, low] {
            // Errors of the size of the tolerances remain, also in the velocity with which it may leave.
            assert!(end.q[0].abs() < 100.0 * rtol && end.v[0].abs() < 100.0 * rtol, "{rtol} {end:?}");
        }
    }
    // Fixed steps, also with more damping: decays of 1000/s and of 4791/s and 209/s.
    for damping in [2000.0, 5000.0] {
        let floor = Damped { damping, ..floor };
        for h in [4e-4, 1e-4, 3e-5] {
            let start = State::new(0.0, &[1.0], &[-1.0]);
            let end = Rk4::new(h).max_steps(100_000).end(&floor, &start, 2.0)?;
            assert!(end.q[0].abs() < 1e-15 && end.v[0].abs() < 1e-15, "{damping} {h} {end:?}");
        }
    }
    Ok(())
}

/// v0' = v0 > v1 ? -2 : 2 and v1' = v1 > v0 ? -3 : 1.5 push each other back: from (1.5, 1) the motion slides
/// from t = 0.5/3.5 on.
struct Sliding {
    pieces: bool,
}

impl Model for Sliding {
    fn dof(&self) -> usize {
        2
    }
    fn accel(&self, _: &[f64], _: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = if v[0] > v[1] { -2.0 } else { 2.0 };
        a[1] = if v[1] > v[0] { -3.0 } else { 1.5 };
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: self.pieces, ..Offers::default() }
    }
    fn accel_on_pieces(&self, pieces: &[Piece], _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = if pieces[0] == Piece::Upper { -2.0 } else { 2.0 };
        a[1] = if pieces[1] == Piece::Upper { -3.0 } else { 1.5 };
    }
    fn contacts(&self) -> usize {
        2
    }
    fn contact(&self, _: &[f64], _: &[f64], v: &[f64], out: &mut [Contact]) {
        let mut a = [0.0; 2];
        self.accel(&[], &[], v, &mut a);
        let (lower, upper, rate) = (f64::NEG_INFINITY, 0.0, a[0] - a[1]);
        out[0] = Contact { deflection: v[0] - v[1], rate, lower, upper, ..Contact::default() };
        out[1] = Contact { deflection: v[1] - v[0], rate: -rate, lower, upper, ..Contact::default() };
    }
}

/// [`Sliding`] as a shape, for Taylor series.
#[derive(PartialEq)]
struct SlidingShape;

impl Shape for SlidingShape {
    fn size(&self) -> Size {
        Size { dof: 2, contacts: 2, constants: 1, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1")]
    }
    fn waves<A: Angle>(&self, _: A, _: Side, _: &mut [A::Number]) {}
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> gear_dynamics::contact::Contact<S> {
        let mut a = [S::from(0.0); 2];
        self.accel(law, u, q, v, &mut a);
        gear_dynamics::contact::Contact {
            deflection: v[i] - v[1 - i],
            rate: a[i] - a[1 - i],
            lower: f64::NEG_INFINITY.into(),
            upper: 0.0.into(),
            ..gear_dynamics::contact::Contact::default()
        }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, _: Drives<'_, S>, _: &[S], v: &[S], a: &mut [S]) {
        let touch = |i: usize| {
            let (lower, upper) = (f64::NEG_INFINITY.into(), 0.0.into());
            law.touch(i, Deflection { d: v[i] - v[1 - i], rate: 0.0.into(), lower, upper })
        };
        a[0] = S::from(2.0) - touch(0) * 4.0;
        a[1] = S::from(1.5) - touch(1) * 4.5;
    }
}

/// Sliding along an edge is refused by name, by every solver at every tolerance: with fixed pieces at the crossing after
/// which it begins. Without them a step may mix both sides of the edge within its error, and the next crossing counts.
#[test]
fn sliding_along_an_edge_is_refused() {
    let start = State::new(0.0, &[0.0; 2], &[1.5, 1.0]);
    fn refused(solver: &impl Integrator, model: &Sliding, start: &State, within: f64) {
        let mut crossed = 0;
        let mut count = |step: &mut Step<'_>| {
            crossed += step.crossings().len();
            ControlFlow::Continue(())
        };
        match solver.run(model, start, 30.0, &mut count) {
            Err(IntegrateError::EdgeStall { t, .. } | IntegrateError::Discontinuity { t, .. }) => {
                assert!(t > 1.0 / 7.0 - within, "{t}");
                assert!(!model.pieces || t < 1.0 / 7.0 + within, "{t} {within:e}");
            }
            other => panic!("{within:e}: {other:?}"),
        }
        // Two contacts have this edge.
        assert!(crossed <= if model.pieces { 0 } else { 16 }, "{crossed}");
    }
    for pieces in [false, true] {
        let model = Sliding { pieces };
        for i in 0..24 {
            let rtol = 10f64.powf(-2.0 - 0.45 * f64::from(i));
            let within = 3.0 * rtol + 1e-9;
            refused(&Dop853::new().rtol(rtol).atol(rtol / 100.0).max_steps(4000), &model, &start, within);
            refused(&Rk45::new().rtol(rtol).atol(rtol / 100.0).max_steps(4000), &model, &start, within);
        }
        for h in [0.05, 0.02, 0.01, 1e-3, 1.0 / 700.0, 1.0 / 7.0] {
            refused(&Rk4::new(h).max_steps(100_000), &model, &start, if pieces { 1e-9 } else { h });
        }
    }
    for rtol in [1e-3, 1e-6, 1e-9, 1e-12] {
        let machine = Machine::of_constants(SlidingShape, &[("speed", 1.0)]).unwrap();
        match Taylor::new().rtol(rtol).max_steps(4000).end(&machine, &start, 30.0) {
            Err(IntegrateError::EdgeStall { t, .. }) => {
                assert!((t - 1.0 / 7.0).abs() < 1e-9, "{rtol:e}: {t}");
            }
            other => panic!("{rtol:e}: {other:?}"),
        }
    }
}

/// Steps of fixed length that start on the edge cross it again and again, in parts that do not shrink.
#[test]
fn sliding_from_the_edge_in_fixed_steps_is_refused() {
    let start = State::new(0.0, &[0.0; 2], &[0.3; 2]);
    for pieces in [false, true] {
        for h in [0.1, 0.05, 0.02, 0.01, 3e-3, 1e-3] {
            let error = Rk4::new(h).end(&Sliding { pieces }, &start, 2.0).unwrap_err();
            assert!(
                matches!(error, IntegrateError::EdgeStall { t, .. } if t <= 2.0 * h),
                "{h} {pieces}: {error}"
            );
        }
    }
}

/// A rate s = v - b with b' = β, driven by a force that jumps at s = 0: v' = f₊ above and f₋ below. The edge is
/// crossed if f - β has one sign, passed tangentially or left for ever otherwise.
struct Switch {
    above: f64,
    below: f64,
    belt: f64,
}

impl Model for Switch {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], _: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = if v[0] > self.belt * u[0] { self.above } else { self.below };
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn accel_on_pieces(&self, pieces: &[Piece], _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = if pieces[0] == Piece::Upper { self.above } else { self.below };
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], _: &[f64], v: &[f64], out: &mut [Contact]) {
        let deflection = v[0] - self.belt * u[0];
        let rate = if deflection > 0.0 { self.above } else { self.below } - self.belt;
        let (lower, upper) = (f64::NEG_INFINITY, 0.0);
        out[0] = Contact { deflection, rate, lower, upper, ..Contact::default() };
    }
}

/// Random jumps at an edge of a velocity, from above and from below: the motion crosses once and ends where the closed
/// form says, or slides and is refused.
#[test]
fn an_edge_of_a_velocity_is_crossed_or_slid_along() -> Result<(), IntegrateError> {
    let mut random = Random(29);
    let (mut crossed, mut slid) = (0, 0);
    for case in 0..600 {
        let mut draw = |size: f64| size * (2.0 * random.next() - 1.0);
        let model = Switch { above: draw(3.0), below: draw(3.0), belt: draw(1.0) };
        let start = if case % 4 < 2 { 0.5 } else { -0.5 };
        // Rates of s above and below.
        let [above, below] = [model.above, model.below].map(|f| f - model.belt);
        let (before, after) = if start > 0.0 { (above, below) } else { (below, above) };
        if before * start > -0.05 || after.abs() < 0.05 {
            continue;
        }
        let meets = -start / before;
        let end = meets + 1.0;
        let slides = after * before < 0.0;
        let expected = model.belt * end + after * 1.0;
        let rtol = 10f64.powf(-4.0 - 7.0 * random.next());
        let from = State::new(0.0, &[0.0], &[start]);
        let found = [
            crossings(&Dop853::new().rtol(rtol).atol(rtol / 100.0).max_steps(4000), &model, &from, end),
            crossings(&Rk45::new().rtol(rtol).atol(rtol / 100.0).max_steps(4000), &model, &from, end),
            crossings(&Rk4::new(0.013).max_steps(4000), &model, &from, end),
        ];
        for found in found {
            match found {
                Err(IntegrateError::EdgeStall { t, .. }) if slides => {
                    assert!((t - meets).abs() < 1e-9 + 10.0 * rtol, "{case}: {t} for {meets}");
                    slid += 1;
                }
                Ok(times) if !slides => {
                    assert_eq!(times.len(), 1, "{case}: {times:?}");
                    assert!((times[0] - meets).abs() < 1e-9 + 10.0 * rtol, "{case}: {times:?} for {meets}");
                    crossed += 1;
                }
                other => panic!("{case}, slides {slides}: {other:?}"),
            }
        }
        let state = Dop853::new().rtol(rtol).atol(rtol / 100.0).max_steps(4000).end(&model, &from, end);
        if !slides {
            let v = state?.v[0];
            assert!((v - expected).abs() < 1e-9 + 100.0 * rtol, "{case}: {v} for {expected}");
        }
    }
    assert!(crossed > 300 && slid > 300, "{crossed} {slid}");
    Ok(())
}

/// q'' + 0.1 q' + q = cos 2t: from a start 10⁹ periods late, settling and shooting find the orbit in closed form.
#[test]
fn late_starts_settle_and_close() -> Result<(), Box<dyn std::error::Error>> {
    let period = std::f64::consts::PI;
    let swing = gear_dynamics::model::from_fn(1, |t, q, v, a| a[0] = (2.0 * t).cos() - 0.1 * v[0] - q[0])?;
    let swing = swing.with_period(period)?;
    for periods in [1e7, 1e8, 1e9] {
        let start = State::new(periods * period, &[0.3], &[0.1]);
        let orbit = Shooting::new().solve(&swing, &start)?;
        let steady = Settle::new().run(&Dop853::new().max_steps(100_000), &swing, &start)?;
        for state in [&orbit.states()[0], &steady.state] {
            // q = A cos 2t + B sin 2t with A = -3/9.04 and B = 0.2/9.04.
            let (sin, cos) = (2.0 * state.t).sin_cos();
            let q = (-3.0 * cos + 0.2 * sin) / 9.04;
            assert!((state.q[0] - q).abs() < 1e-7, "{periods:e}: {state:?} {q}");
        }
    }
    Ok(())
}

/// A pair that loses contact, for late times.
fn swinging_pair() -> Oscillator {
    Oscillator::new(&[
        ("speed", 0.7),
        ("damping", 0.05),
        ("mesh stiffness", 1.0),
        ("stiffness variation", 0.2),
        ("mean force", 0.1),
        ("force", 0.3),
        ("half backlash", 0.2),
    ])
    .expect("constants in range")
}

/// q'' + 3 q' + 2 q = cos 2t and a pair with backlash from starts up to 10⁹ periods late: exponents, and the
/// coefficients of a projected orbit, are those of a start at t = 0. Times of 2²⁷ and 2³⁰ periods are reduced
/// to 0 exactly, so that all bits agree.
#[test]
fn late_starts_have_exponents_and_series_of_early_ones() -> Result<(), Box<dyn std::error::Error>> {
    let period = std::f64::consts::PI;
    let swing =
        gear_dynamics::model::from_fn(1, |t, q, v, a| a[0] = (2.0 * t).cos() - 3.0 * v[0] - 2.0 * q[0])?;
    let swing = swing.with_period(period)?;
    let pair = swinging_pair();
    fn found<M: Periodic>(model: &M, t: f64) -> Result<(Vec<f64>, Vec<f64>), Box<dyn std::error::Error>> {
        let start = State::new(t, &[0.3], &[0.1]);
        let exponents = Lyapunov::new().settle(20).measure(20).run(model, &start)?;
        let orbit = FourierOrbit::project(&Dop853::new(), model, &start, &Harmonics::up_to(5))?;
        Ok((exponents.values(), orbit.coefficients(0).to_vec()))
    }
    for periods in [(1u64 << 27) as f64, (1u64 << 30) as f64] {
        assert_eq!(found(&swing, periods * period)?, found(&swing, 0.0)?, "{periods:e}");
        assert_eq!(found(&pair, periods * pair.period())?, found(&pair, 0.0)?, "{periods:e}");
    }
    for periods in [1e8, 1e9] {
        let (values, _) = found(&swing, periods * period)?;
        assert!((values[0] + 1.0).abs() < 1e-7 && (values[1] + 2.0).abs() < 1e-7, "{periods:e}: {values:?}");
        // q = A cos 2t + B sin 2t with A = -1/20 and B = 3/20; the remainder of the late time is exact.
        let t = periods * period;
        let (sin, cos) = (2.0 * t.rem_euclid(period)).sin_cos();
        let start = State::new(t, &[0.15 * sin - 0.05 * cos], &[0.3 * cos + 0.1 * sin]);
        let solver = Dop853::new().rtol(1e-12).atol(1e-14);
        let orbit = FourierOrbit::project(&solver, &swing, &start, &Harmonics::up_to(3))?;
        let samples = orbit.history(8)?;
        for s in 0..8 {
            let (sin, cos) = (2.0 * samples.times()[s]).sin_cos();
            let q = 0.15 * sin - 0.05 * cos;
            assert!((samples.q(s)[0] - q).abs() < 1e-10, "{periods:e}: {} for {q}", samples.q(s)[0]);
        }
    }
    Ok(())
}

/// A contact with the deflection ±(1 - cos φ - c) above the lower edge 0, on a motion q'' = -q that it does not touch.
#[derive(Clone, PartialEq, Debug)]
struct Tangent {
    waves: [Wave; 2],
    sign: f64,
}

impl Tangent {
    fn machine(sign: f64, depth: f64, speed: f64) -> Machine<Tangent> {
        let wave = |row: [f64; 2]| Wave::new(Fourier::new(0.0, &[row]).unwrap());
        let shape = Tangent { waves: [wave([1.0, 0.0]), wave([0.0, 1.0])], sign };
        Machine::of_constants(shape, &[("speed", speed), ("depth", depth)]).unwrap()
    }
}

impl Shape for Tangent {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 2, contacts: 1, constants: 2, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1"), Channel::new("depth", "1")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        self.waves.iter().zip(u).for_each(|(wave, u)| *u = wave.value(angle, side));
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        _: &L,
        _: usize,
        u: Drives<'_, S>,
        _: &[S],
        _: &[S],
    ) -> gear_dynamics::contact::Contact<S> {
        let ([cos, sin], [depth]) = (u.waves(), u.constants());
        gear_dynamics::contact::Contact {
            deflection: (S::from(1.0) - cos - depth) * self.sign,
            rate: sin * u.speed() * self.sign,
            lower: 0.0.into(),
            upper: f64::INFINITY.into(),
            ..gear_dynamics::contact::Contact::default()
        }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, _: Drives<'_, S>, q: &[S], _: &[S], a: &mut [S]) {
        a[0] = q[0] * -1.0;
    }
}

/// Edges of time alone that are touched, φ = 2π k: no crossing. Passed by `depth`: two crossings a turn, at
/// ± arccos(1 - depth).
#[test]
fn touched_edges_are_not_crossed_and_shallow_dips_are() -> Result<(), IntegrateError> {
    let mut random = Random(11);
    for case in 0..400 {
        let sign = if case % 2 == 0 { 1.0 } else { -1.0 };
        let touches = case % 4 < 2;
        // Above the slack, 1e-10 of the deflection, and the tolerance of no method matters: the motion is not touched.
        let depth = if touches { 0.0 } else { 1e-9 * 1e8f64.powf(random.next()) };
        let speed = 0.3 + 3.0 * random.next();
        let machine = Tangent::machine(sign, depth, speed);
        let start = State::new(0.5 / speed, &[1.0], &[0.0]);
        let end = (3.2 * std::f64::consts::TAU + random.next()) / speed;
        let h = 0.02 + 0.1 * random.next();
        let half = 2.0 * (0.5 * depth).sqrt().asin();
        let mut expected: Vec<f64> = Vec::new();
        for turn in 1..=3 {
            let middle = std::f64::consts::TAU * f64::from(turn);
            if !touches {
                expected.extend([(middle - half) / speed, (middle + half) / speed]);
            }
        }
        let found = [
            ("Taylor", crossings(&Taylor::new(), &machine, &start, end)?),
            ("Dop853", crossings(&Dop853::new(), &machine, &start, end)?),
            ("Rk45", crossings(&Rk45::new(), &machine, &start, end)?),
            ("Rk4", crossings(&Rk4::new(h), &machine, &start, end)?),
            // The edge at the end of a step.
            ("steps", crossings(&Dop853::new().max_step(0.05 / speed), &machine, &start, end)?),
            ("series", crossings(&Taylor::new().max_step(0.05 / speed), &machine, &start, end)?),
        ];
        for (name, found) in found {
            assert_eq!(
                found.len(),
                expected.len(),
                "{case} {name}: {found:?} for {expected:?}, depth {depth:e}"
            );
            // The slack over the rate at a root, √(2 depth).
            let close = (1e-10 / (2.0 * depth).sqrt()).max(1e-12) * 10.0 / speed;
            let near = |(a, b): (&f64, &f64)| (a - b).abs() < close;
            assert!(found.iter().zip(&expected).all(near), "{case} {name}: {found:?} for {expected:?}");
        }
    }
    Ok(())
}

/// x'' = -k x - c x' below 0, unloaded, from (1, -1): with c >= 2 √k the contact never leaves its flank, otherwise once,
/// after the time π/ω, with the speed exp(-c π/2ω). A speed below 100 tolerances may be late or missed.
#[test]
fn damped_contacts_leave_as_often_as_they_should() -> Result<(), IntegrateError> {
    let (stiffness, mut random) = (1e6f64, Random(5));
    for case in 0..200 {
        let damping = match case % 4 {
            0 => [500.0, 1000.0, 1900.0, 2000.0, 3000.0, 20_000.0][case / 4 % 6],
            _ => 500.0 * 40f64.powf(random.next()),
        };
        let floor = Damped { pull: [0.0; 2], stiffness, damping, edges: [0.0, f64::INFINITY] };
        let floor = OnPieces { floor, pieces: case % 2 == 0 };
        let disc = stiffness - 0.25 * damping * damping;
        let half = if disc > 0.0 { std::f64::consts::PI / disc.sqrt() } else { f64::INFINITY };
        let speed = (-0.5 * damping * half).exp();
        let leaves = half < 1.0;
        let rtol = 10f64.powf(-4.0 - 8.0 * random.next());
        let (atol, start) = (rtol / 100.0, State::new(0.0, &[1.0], &[-1.0]));
        let [high, low] = [
            (
                crossings(&Dop853::new().rtol(rtol).atol(atol), &floor, &start, 2.0)?.len(),
                Dop853::new().rtol(rtol).atol(atol).end(&floor, &start, 2.0)?,
            ),
            (
                crossings(&Rk45::new().rtol(rtol).atol(atol), &floor, &start, 2.0)?.len(),
                Rk45::new().rtol(rtol).atol(atol).end(&floor, &start, 2.0)?,
            ),
        ];
        for (count, end) in [high, low] {
            let expected = if leaves { [(1.0 - half) * speed, speed] } else { [0.0; 2] };
            let off = (end.q[0] - expected[0]).abs().max((end.v[0] - expected[1]).abs());
            assert!(off < 100.0 * rtol, "{case}, c = {damping}, {rtol:e}: {end:?} for {expected:?}");
            if !leaves || speed > 100.0 * atol {
                assert_eq!(
                    count,
                    1 + usize::from(leaves),
                    "{case}, c = {damping}, {rtol:e}, leaves at {speed:e}"
                );
            }
        }
    }
    Ok(())
}

/// A floor, on fixed pieces or without.
struct OnPieces {
    floor: Damped,
    pieces: bool,
}

impl Model for OnPieces {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.floor.accel(u, q, v, a);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: self.pieces, ..Offers::default() }
    }
    fn accel_on_pieces(&self, pieces: &[Piece], _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let flank = pieces[0] == Piece::Lower;
        a[0] = if flank { -self.floor.stiffness * q[0] - self.floor.damping * v[0] } else { 0.0 };
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.floor.contact(u, q, v, out);
    }
}

/// The dead zone of Kahraman and Singh with all lengths in units of `length`.
fn small_pair(length: f64) -> Oscillator {
    let constants = [
        ("speed", 0.7),
        ("damping", 0.05),
        ("mesh stiffness", 1.0),
        ("mean force", 0.1 * length),
        ("force", 0.6 * length),
        ("half backlash", 0.2 * length),
    ];
    Oscillator::new(&constants).expect("constants in range")
}

/// Lengths below the absolute tolerance are refused by name by Runge-Kutta solvers; `Taylor` resolves the distances from
/// edges as shares of the gap, whatever the tolerance.
#[test]
fn lengths_below_the_tolerance_are_refused_or_resolved() -> Result<(), IntegrateError> {
    let start = |length: f64| State::new(0.0, &[0.25 * length], &[0.0]);
    let reference = Dop853::new().rtol(1e-12).atol(1e-15).end(&small_pair(1.0), &start(1.0), 40.0)?.q[0];
    for length in [1e-13, 1e-14, 1e-16, 1e-20, 1e-40, 1e-100] {
        let (model, start) = (small_pair(length), start(length));
        for failed in [Dop853::new().end(&model, &start, 40.0), Rk45::new().end(&model, &start, 40.0)] {
            match failed {
                Err(IntegrateError::BelowTolerance { t, contact: 0, atol, motion }) => {
                    assert!(t > 0.0 && atol == 1e-12 && motion < atol, "{t} {atol:e} {motion:e}");
                }
                other => panic!("{length:e}: {other:?}"),
            }
        }
        let series = Taylor::new().end(&model, &start, 40.0)?.q[0] / length;
        assert!((series - reference).abs() < 1e-8, "{length:e}: {series} for {reference}");
        let fine = Dop853::new().rtol(1e-12).atol(1e-15 * length).end(&model, &start, 40.0)?.q[0] / length;
        assert!((fine - reference).abs() < 1e-8, "{length:e}: {fine} for {reference}");
        let loose = Taylor::new().rtol(1e-9).atol(1e-6).end(&model, &start, 40.0)?.q[0] / length;
        assert!((loose - reference).abs() < 1e-4, "{length:e}: {loose} for {reference}");
    }
    // A motion that has been larger and decays below the tolerance goes on.
    let spring =
        Oscillator::new(&[("speed", 1.0), ("damping", 0.5), ("mesh stiffness", 1.0), ("half backlash", 0.0)])
            .expect("constants in range");
    let end = Dop853::new().end(&spring, &State::new(0.0, &[1.0], &[0.0]), 300.0)?;
    assert!(end.q[0].abs() < 1e-10);
    // Without backlash, too.
    let tiny = Dop853::new().end(&spring, &State::new(0.0, &[1e-14], &[0.0]), 40.0);
    assert!(matches!(tiny, Err(IntegrateError::BelowTolerance { contact: 0, .. })), "{tiny:?}");
    Ok(())
}

/// Runs at late times have the motion of the first periods within the phase error of the rounding of the time, or are
/// refused by name, within few steps.
#[test]
fn late_runs_are_right_or_refused() -> Result<(), IntegrateError> {
    let pair = swinging_pair();
    // Steps that the noise of a late phase rejects, but that stay above the limit of `LateTime`, end at the
    // limit of steps: a run does not know the period by which it could be moved.
    let (period, mut late) = (pair.period(), 0);
    for rtol in [1e-4, 1e-6, 1e-9, 1e-12] {
        let early = State::new(0.0, &[0.3], &[0.0]);
        let expected = Dop853::new().rtol(1e-12).atol(1e-14).end(&pair, &early, 3.0 * period)?.q[0];
        for periods in [1e4, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12] {
            let (from, to) = (periods * period, periods * period + 3.0 * period);
            let start = State::new(from, &[0.3], &[0.0]);
            // Few digits of the phase, 0.7 ε t, with the sensitivity of the motion.
            let within = 300.0 * f64::EPSILON * from + 100.0 * rtol;
            let found = [
                Dop853::new().rtol(rtol).atol(rtol / 1000.0).max_steps(20_000).end(&pair, &start, to),
                Rk45::new().rtol(rtol).atol(rtol / 1000.0).max_steps(20_000).end(&pair, &start, to),
                Taylor::new().max_steps(20_000).end(&pair, &start, to),
            ];
            for (solver, found) in found.into_iter().enumerate() {
                match found {
                    Ok(end) => assert!(
                        (end.q[0] - expected).abs() < within,
                        "solver {solver}, {rtol:e}, {periods:e}: {} for {expected}",
                        end.q[0]
                    ),
                    Err(IntegrateError::LateTime { t, resolution, change }) if solver < 2 => {
                        assert!(
                            t >= from && resolution > 0.0 && change > 1.0 && f64::EPSILON * t > 1e-4 * rtol
                        );
                        late += 1;
                    }
                    // Where steps stay just above the resolution: the limit of steps.
                    Err(IntegrateError::TooManySteps { .. })
                        if solver < 2 && rtol < 1e-8 && periods > 1e6 => {}
                    other => panic!("solver {solver}, {rtol:e}, {periods:e}: {other:?}"),
                }
            }
        }
    }
    assert!(late > 5, "{late}");
    Ok(())
}

/// Edges of a rectangular mesh stiffness at late times: a step from one to the next is not below the resolution of the
/// time, and the motion is that of the first periods, moved by some roundings of the time.
#[test]
fn edges_of_late_times_are_passed() {
    let mut random = Random(48);
    for case in 0..120 {
        let teeth = [10 + (50.0 * random.next()) as u32, 10 + (90.0 * random.next()) as u32];
        let radii = teeth.map(|z| 0.03 * f64::from(z) / f64::from(teeth[0]));
        let wave = RectangularWave::of_contact_ratio(1.05 + 0.9 * random.next(), 1.6e8, 2.4e8).unwrap();
        let mesh = MeshPart::external(teeth, radii, Wave::new(wave))
            .damping(2000.0 * random.next())
            .half_backlash(5e-5);
        let torque = 60.0 * random.next();
        let mut parts = Parts::new();
        parts
            .body("pinion", Body::new(1e-3))
            .body("wheel", Body::new(4e-3))
            .mesh("mesh", "pinion", "wheel", mesh);
        parts.torque("in", "pinion", torque).torque("out", "wheel", -torque * radii[1] / radii[0]);
        let train = parts.build("pinion", 20.0 + 800.0 * random.next()).unwrap();
        let (period, turns) = (train.period(), 10f64.powf(9.0 + random.next()).floor());
        let rtol = 10f64.powf(-10.0 - 3.0 * random.next());
        let start = State { t: turns * period, ..State::at_rest(train.dof()) };
        let rest = State::at_rest(train.dof());
        let early = Dop853::new().rtol(1e-12).atol(1e-16).trajectory(&train, &rest, 3.0 * period).unwrap();
        let speeds = (0..early.len()).map(|i| early.v(i)[0].abs());
        let moved = 10.0 * f64::EPSILON * start.t * speeds.fold(0.0, f64::max);
        let expected = early.q(early.len() - 1)[0];
        let ends = [
            Rk45::new().rtol(rtol).atol(1e-3 * rtol).end(&train, &start, (turns + 3.0) * period),
            Dop853::new().rtol(rtol).atol(1e-3 * rtol).end(&train, &start, (turns + 3.0) * period),
        ];
        for end in ends {
            let end = end.unwrap_or_else(|error| {
                panic!("{case}: {teeth:?}, {turns:e} periods, rtol {rtol:e}: {error}")
            });
            let off = (end.q[0] - expected).abs();
            assert!(off < moved, "{case}: {teeth:?}, {turns:e} periods, rtol {rtol:e}: {off:e} {moved:e}");
        }
    }
}

/// q'' = F + P cos Ωt - c q' - 0.1 q³ - W: the contact pushes and damps past ±b, with its piece or by deflection.
struct Pushed {
    pieces: bool,
}

impl Pushed {
    const B: f64 = 0.058_271_892_890_442_09;

    fn of_zone(t: f64, q: f64, v: f64, zone: f64) -> f64 {
        let cos = (1.080_484_378_220_550_7 * t).cos();
        let push = 1.037_738_328_016_162
            * (1.0 + 0.065_124_352_577_341_37 * cos)
            * zone.abs()
            * (q - zone * Self::B);
        let drive = 0.324_035_708_238_004_65 + 0.239_733_672_522_169_1 * cos;
        drive - 0.141_248_057_923_863_83 * v - 0.1 * q * q * q - push - 0.5 * zone.abs() * v
    }
}

impl Model for Pushed {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let zone = if q[0].abs() > Self::B { q[0].signum() } else { 0.0 };
        a[0] = Self::of_zone(u[0], q[0], v[0], zone);
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let (lower, upper) = (-Self::B, Self::B);
        out[0] = Contact { deflection: q[0], rate: v[0], lower, upper, ..Contact::default() };
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: self.pieces, ..Offers::default() }
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let zone = match pieces[0] {
            Piece::Lower => -1.0,
            Piece::Gap => 0.0,
            Piece::Upper => 1.0,
        };
        a[0] = Self::of_zone(u[0], q[0], v[0], zone);
    }
}

/// A step that ends on an edge has a stage behind it, where the force jumps. Its error counts without pieces, too.
#[test]
fn a_step_that_ends_on_a_jump_keeps_its_tolerance_without_pieces() {
    let start = State::new(0.0, &[-0.075_237_305_051_386_84], &[0.452_676_378_376_681_3]);
    let solver = Dop853::new().rtol(3e-11).atol(3e-13);
    for k in 1..=400 {
        let t_end = 0.05 * f64::from(k);
        let [a, b] = [false, true].map(|pieces| solver.end(&Pushed { pieces }, &start, t_end).unwrap());
        let off = (a.q[0] - b.q[0]).abs().max((a.v[0] - b.v[0]).abs());
        assert!(off < 2e-9, "{off:e} at {t_end}");
    }
    let end = solver.end(&Pushed { pieces: false }, &start, 10.441_219_881_444_573).unwrap();
    assert!((end.v[0] - 0.036_246_415_195).abs() < 1e-9, "{end:?}");
}
