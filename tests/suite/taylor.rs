//! The Taylor integrator: algebra with known solutions, contact laws, drives as series, refusals, singular
//! points, dense output, derivatives of the flow.

use crate::api::*;
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

/// The accelerations of a small system for every number type.
trait Algebra {
    fn accelerate<S: Scalar>(&self, q: &[S], v: &[S], a: &mut [S]);
}

/// A shape without drives.
#[derive(PartialEq)]
struct Bare<A>(usize, A);

impl<A: Algebra + PartialEq + Send + Sync + 'static> Shape for Bare<A> {
    fn size(&self) -> Size {
        Size { dof: self.0, constants: 1, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1")]
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, _: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        self.1.accelerate(q, v, a);
    }
}

fn bare<A: Algebra + PartialEq + Send + Sync + 'static>(dof: usize, algebra: A) -> Machine<Bare<A>> {
    Machine::of_constants(Bare(dof, algebra), &[("speed", 1.0)]).unwrap()
}

fn end<M: Model>(model: &M, q: &[f64], v: &[f64], t: f64) -> State {
    Taylor::new().rtol(1e-15).end(model, &State::new(0.0, q, v), t).unwrap()
}

macro_rules! algebra {
    ($name:ident, |$q:ident, $v:ident, $a:ident| $body:block) => {
        #[derive(PartialEq)]
        struct $name;
        impl Algebra for $name {
            fn accelerate<S: Scalar>(&self, $q: &[S], $v: &[S], $a: &mut [S]) $body
        }
    };
}

// q = tan t: products. q = √(1 + t) - 1: quotient and whole power. q = ln(1 + t): exponential.
// q = 2 asin(tanh t), the separatrix of the pendulum: sine. x = 1 + t with q'' = ln x, x^1.3, √x, cos x, 1/x.
algebra!(Tangent, |q, v, a| { a[0] = q[0] * v[0] * 2.0 });
algebra!(Root, |q, _v, a| { a[0] = S::from(-0.25) / (q[0] + S::from(1.0)).powf(3.0) });
algebra!(Logarithm, |q, _v, a| { a[0] = -(q[0] * -2.0).exp() });
algebra!(Pendulum, |q, _v, a| { a[0] = -q[0].sin() });
algebra!(Functions, |q, _v, a| {
    let x = q[0] + S::from(1.0);
    a[0] = S::from(0.0);
    a[1] = x.ln();
    a[2] = x.powf(1.3);
    a[3] = x.sqrt();
    a[4] = x.cos();
    a[5] = S::from(1.0) / x;
    a[6] = x.abs_powf(1.3);
    a[7] = x.powf(-2.0);
});

fn close(name: &str, found: f64, exact: f64, within: f64) {
    let error = (found - exact).abs() / exact.abs().max(1e-300);
    println!("{name}: {found:.16e}, error {error:.1e}");
    assert!(error <= within, "{name}: {found} instead of {exact}, error {error:e}");
}

#[test]
fn solutions_in_closed_form() {
    let t: f64 = 1.25;
    close("tan t", end(&bare(1, Tangent), &[0.0], &[1.0], t).q[0], t.tan(), 1e-13);
    close("√(1 + t) - 1", end(&bare(1, Root), &[0.0], &[0.5], 8.0).q[0], 2.0, 1e-13);
    close("ln(1 + t)", end(&bare(1, Logarithm), &[0.0], &[1.0], 8.0).q[0], 9f64.ln(), 1e-13);
    let pendulum = end(&bare(1, Pendulum), &[0.0], &[2.0], 1.5);
    close("2 asin(tanh t)", pendulum.q[0], 2.0 * 1.5f64.tanh().asin(), 1e-13);
    let x: f64 = 4.0;
    let mut v = [0.0; 8];
    v[0] = 1.0;
    let found = end(&bare(8, Functions), &[0.0; 8], &v, x - 1.0).q;
    // Twice integrated from x = 1, with value and slope 0 there.
    let twice = |p: f64| (x.powf(p + 2.0) - 1.0) / ((p + 1.0) * (p + 2.0)) - (x - 1.0) / (p + 1.0);
    let exact = [
        0.5 * x * x * x.ln() - 0.75 * x * x + x - 0.25,
        twice(1.3),
        twice(0.5),
        -x.cos() + 1f64.cos() - 1f64.sin() * (x - 1.0),
        x * x.ln() - x + 1.0,
        twice(1.3),
        -x.ln() + x - 1.0,
    ];
    for (name, (found, exact)) in
        ["ln", "x^1.3", "√x", "cos", "1/x", "|x|^1.3", "x^-2"].iter().zip(found[1..].iter().zip(exact))
    {
        close(name, *found, exact, 1e-13);
    }
}

algebra!(Abs, |q, _v, a| { a[0] = -q[0].abs() });
algebra!(Min, |q, v, a| { a[0] = -q[0].min(v[0]) });
algebra!(Max, |q, v, a| { a[0] = -q[0].max(v[0]) });
algebra!(Drag, |_q, v, a| { a[0] = -v[0] * v[0].abs_powf(1.0) });
algebra!(Jump, |q, _v, a| { a[0] = -q[0].step() });
// A kink of a constant is none, and a kink that nothing reads neither.
algebra!(Constants, |q, v, a| {
    let unused = q[0].abs();
    let two = S::from(-2.0).abs().min(S::from(5.0)).max(S::from(1.0)) * S::from(3.0).step();
    a[0] = -q[0] * two + unused * v[0] * 0.0;
});

#[test]
fn kinks_are_refused_by_name() {
    fn refusal<A: Algebra + PartialEq + Send + Sync + 'static>(algebra: A) -> IntegrateError {
        let model = bare(1, algebra);
        Taylor::new().end(&model, &State::new(0.0, &[1.0], &[0.0]), 1.0).unwrap_err()
    }
    for (error, what) in [
        (refusal(Abs), "the absolute value of something that varies"),
        (refusal(Min), "the smaller of two numbers that vary"),
        (refusal(Max), "the larger of two numbers that vary"),
        (refusal(Jump), "the step of something that varies"),
        (refusal(Drag), "an odd power of an absolute value that varies"),
    ] {
        let place = "the acceleration of coordinate 0".to_owned();
        assert_eq!(error, IntegrateError::NoSeries { place, what });
        assert!(error.to_string().ends_with(&format!("because of {what}: use Dop853")), "{error}");
    }
    let end = end(&bare(1, Constants), &[1.0], &[0.0], 1.0);
    assert!((end.q[0] - 2f64.sqrt().cos()).abs() < 1e-14);
}

#[test]
fn models_without_series_are_refused() {
    struct Plain;
    impl Model for Plain {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = 0.0;
        }
    }
    let error = Taylor::new().end(&Plain, &State::at_rest(1), 1.0).unwrap_err();
    assert!(error.to_string().contains("one in plain numbers: use Dop853"), "{error}");

    let pair = NfgPair::new(&NfgParams::table1()).unwrap();
    let (start, slot) = (pair.on_drive_flank().unwrap(), pair.slot("load torque"));
    assert!(slot.is_err(), "the torque is prepared, so that it has no slot");
    let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params().unwrap()).unwrap();
    let torque = ring.slot("motor torque").unwrap();
    let driven = Driven::new(ring).add(torque, |t| t.sin(), &[]).unwrap();
    let error = Taylor::new().end(&driven, &State::at_rest(7), 1e-3).unwrap_err();
    assert!(matches!(error, IntegrateError::DriveWithoutSeries { drive, .. } if drive == torque), "{error}");
    for (name, solver) in [
        ("order", Taylor::new().order(3)),
        ("order", Taylor::new().order(29)),
        ("rtol", Taylor::new().rtol(0.0)),
        ("rtol", Taylor::new().rtol(f64::NAN)),
        ("rtol", Taylor::new().rtol(1e-300)),
        ("rtol", Taylor::new().rtol(1e300)),
        ("atol", Taylor::new().atol(-1.0)),
        ("max_step", Taylor::new().max_step(0.0)),
    ] {
        let error = solver.end(&pair, &start, 1.0).unwrap_err();
        assert!(matches!(error, IntegrateError::Parameter(_)), "{name}: {error}");
        assert!(error.to_string().starts_with(&format!("{name} is ")), "{name}: {error}");
    }
    let error = Taylor::new().atol_each(&[1e-9; 3]).end(&pair, &start, 1.0).unwrap_err();
    assert_eq!(error, ParameterError::Length { name: "atol".into(), expected: 2, found: 3 }.into());
    let error = Taylor::new().max_steps(3).end(&pair, &start, 1000.0).unwrap_err();
    assert!(matches!(error, IntegrateError::TooManySteps { limit: 3, .. }), "{error}");
}

algebra!(Fall, |q, _v, a| {
    let x = q[0] + S::from(1.0);
    a[0] = S::from(-1.0) / (x * x);
});
algebra!(Dive, |q, _v, a| { a[0] = q[0].sqrt() - S::from(1.0) });
algebra!(Sink, |q, _v, a| { a[0] = (q[0] + S::from(1.0)).ln() });

/// Steps towards a division by 0, a root and a logarithm of a negative number end in an error that names them.
#[test]
fn singular_points_are_named() {
    let run = |error: Result<State, IntegrateError>| match error.unwrap_err() {
        IntegrateError::NoSeriesAt { t, what } => (t, what),
        other => panic!("{other}"),
    };
    // x'' = -1/x² from rest at 1 reaches 0 at π/(2√2).
    let (t, what) = run(Taylor::new().end(&bare(1, Fall), &State::at_rest(1), 2.0));
    assert!((t - PI / 8f64.sqrt()).abs() < 1e-9 && what == "a division by 0", "{t} {what}");
    let (t, what) = run(Taylor::new().end(&bare(1, Dive), &State::new(0.0, &[0.25], &[-1.0]), 2.0));
    assert!(t > 0.2 && t < 0.26 && what == "the square root of 0", "{t} {what}");
    let (t, what) = run(Taylor::new().end(&bare(1, Sink), &State::new(0.0, &[-0.5], &[-1.0]), 2.0));
    assert!(t > 0.3 && t < 0.5 && what == "the logarithm of 0", "{t} {what}");
    // The part up to the singular point is kept.
    let failed = Taylor::new().trajectory(&bare(1, Fall), &State::at_rest(1), 2.0).unwrap_err();
    assert!(failed.trajectory.len() > 10);
}

/// A mass on a one-sided stop: q'' = -f(q), f a power of the depth; beside it free oscillators q'' = -q.
#[derive(PartialEq)]
struct Bounce(PowerLaw, usize);

impl Shape for Bounce {
    fn size(&self) -> Size {
        Size { dof: 1 + self.1, contacts: 1, constants: 1, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1")]
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        _: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let (lower, upper) = (S::from(f64::NEG_INFINITY), S::from(1.0));
        let force = law.force(i, &self.0, Deflection { d: q[0], rate: v[0], lower, upper });
        Contact { deflection: q[0], rate: v[0], lower, upper, force, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        a[0] = -self.contact(law, 0, u, q, v).force;
        a[1..].iter_mut().zip(&q[1..]).for_each(|(a, q)| *a = -*q);
    }
}

/// A Hertz contact with a series nowhere on its edge. The contact time is 2 y/v √π Γ(1 + 1/n)/Γ(1/2 + 1/n)
/// with n = p + 1 and the largest depth y = (n v²/2)^(1/n).
#[test]
fn hertz_contacts_in_closed_form() {
    for (p, gammas) in [(1.5, 0.887_263_817_503_075_3 / 1.068_628_702_119_319_4), (3.0, 1.0)] {
        let law = PowerLaw::new(0.0, p, 1.0).unwrap().with_edges(f64::NEG_INFINITY, 1.0).unwrap();
        let model = Machine::of_constants(Bounce(law, 0), &[("speed", 1.0)]).unwrap();
        let (v, n) = (2.0f64, p + 1.0);
        let depth = (0.5 * n * v * v).powf(1.0 / n);
        // Γ(5/4)/Γ(3/4) for p = 3.
        let gammas = if p == 3.0 { 0.906_402_477_055_477 / 1.225_416_702_465_178 } else { gammas };
        let time = 2.0 * depth / v * PI.sqrt() * gammas;
        let (mut events, mut deepest) = (Vec::new(), 0.0f64);
        let mut statistics = Statistics::new(&model, &["deflection"]).unwrap();
        let mut watch = |step: &mut Step<'_>| {
            events.extend(step.crossings().iter().map(|_| (step.t1(), step.v1()[0])));
            ControlFlow::Continue(())
        };
        let start = State::new(0.0, &[0.0], &[v]);
        let mut both = (&mut watch, &mut statistics);
        let finish = Taylor::new().rtol(1e-14).run(&model, &start, 5.0, &mut both).unwrap();
        deepest = deepest.max(statistics.summary("deflection").unwrap().max - 1.0);
        println!("p = {p}: {} steps, {events:?}, depth {deepest}", finish.stats.steps);
        assert_eq!(events.len(), 2);
        close("entry", events[0].0, 0.5, 1e-15);
        close("contact time", events[1].0 - events[0].0, time, 1e-12);
        close("speed of separation", -events[1].1, v, 1e-12);
        close("depth", deepest, depth, 1e-12);
        close("end", finish.state.q[0], 1.0 - v * (5.0 - 0.5 - time), 1e-11);
    }
}

/// The derivative of the flow through a contact of a power of the depth, whose second derivatives are infinite on the
/// edge. With the contact time τ of the test above, which is proportional to v^(2/n - 1), the mass is at
/// 1 - v (t - (1 - q)/v - τ(v)) at the end.
#[test]
fn derivatives_through_contacts_of_a_power() {
    for (p, gammas) in [(1.2, 0.8611925590456704), (1.6, 0.8213823427602973)] {
        let law = PowerLaw::new(0.0, p, 1.0).unwrap().with_edges(f64::NEG_INFINITY, 1.0).unwrap();
        let model = Machine::of_constants(Bounce(law, 2), &[("speed", 1.0)]).unwrap();
        let (v, n, t) = (2.0f64, p + 1.0, 5.0);
        let time = 2.0 * (0.5 * n * v * v).powf(1.0 / n) / v * PI.sqrt() * gammas;
        let start = State::new(0.0, &[0.0, 0.1, 0.2], &[v, 0.0, 0.0]);
        let matrix = Variation::new().flow_tolerance(1e-13).run(&model, &start, t).unwrap().matrix;
        close("position by position", matrix[(0, 0)], -1.0, 1e-11);
        close("position by velocity", matrix[(0, 3)], 2.0 / n * time - t, 1e-10);
        close("velocity by position", 1.0 + matrix[(3, 0)], 1.0, 1e-11);
        close("velocity by velocity", matrix[(3, 3)], -1.0, 1e-11);
    }
}

/// A run that starts on the edge of a Hertz contact, with further coordinates that have a series there.
#[test]
fn starts_on_the_edge_of_a_hertz_contact() {
    let law = PowerLaw::new(0.0, 3.0, 1.0).unwrap().with_edges(f64::NEG_INFINITY, 1.0).unwrap();
    let (v, depth) = (2.0f64, 8f64.powf(0.25));
    let time = 2.0 * depth / v * PI.sqrt() * 0.906_402_477_055_477 / 1.225_416_702_465_178;
    for free in [0, 6, 7, 8, 9, 20] {
        let model = Machine::of_constants(Bounce(law, free), &[("speed", 1.0)]).unwrap();
        let (q, mut rates) = (vec![1.0; 1 + free], vec![0.0; 1 + free]);
        rates[0] = v;
        let last = end(&model, &q, &rates, 5.0);
        close("the mass", last.q[0], 1.0 - v * (5.0 - time), 1e-11);
        last.q[1..].iter().for_each(|q| close("a free coordinate", *q, 5f64.cos(), 1e-13));
    }
}

#[test]
fn series_of_waves_are_the_waves() {
    let fourier = || Wave::new(Fourier::new(1.0, &[[0.2, -0.1], [0.0, 0.05]]).unwrap());
    let teeth = fourier().per_turn(7).unwrap().with_phase(0.4).unwrap();
    let centre = InstantCentre::new(0.2).unwrap();
    let samples: Vec<f64> = (0..12).map(|i| (i as f64 / 12.0 * TAU).cos().exp()).collect();
    let waves = [
        ("Fourier", fourier()),
        ("Fourier per turn", teeth.clone()),
        ("Sum", Wave::new(Sum::new(vec![fourier(), teeth.clone()]))),
        ("Product", Wave::new(Product::new(vec![fourier(), teeth.clone(), fourier()]))),
        ("Product with a curve", Wave::new(Product::new(vec![teeth.clone(), Wave::new(centre.rotation())]))),
        ("Scaled", Wave::new(Scaled::new(3.0, teeth).unwrap()).per_turn(2).unwrap()),
        ("radius", Wave::new(centre.radius(2.0).unwrap())),
        ("ratio", Wave::new(centre.ratio(3.5).unwrap())),
        ("rotation", Wave::new(centre.rotation())),
        ("rotation series", Wave::new(centre.rotation_series(3).unwrap())),
        ("Table", Wave::new(Table::new(&samples).unwrap())),
        ("rectangle", Wave::new(RectangularWave::new(1.0, 2.0, 0.4).unwrap())),
        ("constant", Wave::constant(4.0).unwrap()),
    ];
    let (speed, dt) = (3.0, 0.004);
    for (name, wave) in &waves {
        for i in 0..50 {
            let angle = 0.37 + 1.7 * f64::from(i);
            let series = Series::variable(angle, speed, 12);
            let (value, jet) = (wave.value(series, Side::After), wave.jet(series, Side::After));
            if value.until() < dt || wave.next_edge(angle).is_some_and(|edge| edge < angle + speed * dt) {
                continue;
            }
            let exact = wave.jet(angle + speed * dt, Side::After);
            for (part, found, exact) in [
                ("value", value.at(dt), exact.value),
                ("jet", jet.value.at(dt), exact.value),
                ("rate", jet.rate.at(dt), exact.rate),
                ("second", jet.second.at(dt), exact.second),
            ] {
                let scale = 1.0 + exact.abs();
                assert!((found - exact).abs() < 1e-12 * scale, "{name} {part} at {angle}: {found} {exact}");
            }
        }
    }
    let bump = Wave::new(Function::new(|angle: Jet| angle.cos()));
    let refused = bump.value(Series::variable(0.0, 1.0, 8), Side::After);
    assert!(refused.refusal().unwrap().contains("a closure"), "{refused:?}");
}

/// The face gear pair through a run-up, with a fluctuating speed and with held loads: against DOP853.
#[test]
fn varying_speed_and_held_processes() {
    let agree = |name: &str, model: &dyn Model, start: &State, until: f64, within: f64| {
        let dop853 = Dop853::new().rtol(1e-13).atol(1e-19).end(&model, start, until).unwrap();
        let finish = Taylor::new()
            .run(&model, start, until, &mut |_: &mut Step<'_>| ControlFlow::Continue(()))
            .unwrap();
        let size = dop853.q.iter().fold(0.0, |m: f64, q| m.max(q.abs()));
        let off = dop853.q.iter().zip(&finish.state.q).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        println!("{name}: {:?}, difference {:.1e}", finish.stats, off / size);
        assert!(off < within * size, "{name}: {off:e} of {size:e}");
    };
    let pair = NfgPair::new(&NfgParams::table1()).unwrap();
    let start = pair.on_drive_flank().unwrap();
    let slow = pair.speed();
    let law = SpeedLaw::ramp(slow, 1.2 * slow, 150.0).unwrap();
    agree("ramp", &VaryingSpeed::new(pair.clone(), law), &start, 200.0, 1e-9);
    let law = SpeedLaw::fluctuation(slow, 0.1, 0.05).unwrap();
    agree("fluctuation", &VaryingSpeed::new(pair, law), &start, 100.0, 1e-9);
    let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params().unwrap()).unwrap();
    let (slot, dof) = (ring.slot("mesh damping 1").unwrap(), ring.dof());
    let process = HeldProcess::of_values(1e-4, &[0.0, 300.0, 100.0, 500.0]).unwrap();
    let noisy = Noisy::new(ring).add(&[(slot, 1.0)], &process).unwrap();
    agree("held", &noisy, &State::at_rest(dof), 3e-3, 1e-9);
}

/// A spur pair with a given mesh.
#[derive(PartialEq)]
struct Spur<N>(Mesh<N>);

impl<N: Nonlinearity> Shape for Spur<N> {
    fn size(&self) -> Size {
        let kinks = self.0.law().kinks();
        Size { dof: 1, waves: Mesh::<N>::WAVES, contacts: 1 + kinks, kinks, constants: 2 }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1"), Channel::new("load", "1")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        self.0.waves(angle, side, u);
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        self.0.next_edge(angle)
    }
    fn next_knot(&self, angle: f64) -> Option<f64> {
        self.0.next_knot(angle)
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let [k, error, error_rate, lower, upper, lower_rate, upper_rate] = u.waves();
        let (deflection, rate) = (q[0] - error, v[0] - error_rate * u.speed());
        let force =
            k * law.force(0, self.0.law(), Deflection { d: deflection, rate, lower, upper }) + rate * 0.1;
        let (lower_rate, upper_rate) = (lower_rate * u.speed(), upper_rate * u.speed());
        let contact = Contact { deflection, rate, lower, upper, lower_rate, upper_rate, force };
        let Some(k) = i.checked_sub(1) else { return contact };
        Contact { deflection: self.0.law().kink(k, deflection, rate), ..contact }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [load] = u.constants();
        a[0] = load - self.contact(law, 0, u, q, v).force;
    }
}

/// Crossings and end of a run.
fn run<I: Integrator, M: Model>(solver: &I, model: &M, start: &State, end: f64) -> (Vec<f64>, State) {
    let mut times = Vec::new();
    let mut watch = |step: &mut Step<'_>| {
        times.extend(step.crossings().iter().map(|_| step.t1()));
        ControlFlow::Continue(())
    };
    let finish = solver.run(model, start, end, &mut watch).unwrap();
    (times, finish.state)
}

/// A closure that is smooth over a turn has a Taylor series from samples; one with a kink has none.
#[test]
fn smooth_closures_are_sampled() {
    let spur = |stiffness: Wave| {
        let mesh = Mesh::new(stiffness, Wave::constant(0.0).unwrap(), Backlash::new(1.0).unwrap());
        Machine::of_constants(Spur(mesh), &[("speed", 0.7), ("load", 0.1)]).unwrap()
    };
    let start = State::new(0.0, &[1.3], &[0.0]);
    let smooth = spur(Wave::new(Function::new(|angle: Jet| angle.cos().exp())));
    let by_dop853 = Dop853::new().rtol(1e-13).atol(1e-15);
    let [(expected, last), (found, end)] =
        [run(&by_dop853, &smooth, &start, 30.0), run(&Taylor::new(), &smooth, &start, 30.0)];
    assert!(found.len() >= 4 && found.len() == expected.len(), "{found:?} {expected:?}");
    assert!((end.q[0] - last.q[0]).abs() < 1e-11, "{end:?} {last:?}");
    let kink = |angle: Jet| if angle.value.sin() < 0.0 { -angle.sin() } else { angle.sin() };
    let kinked = spur(Wave::new(Function::new(kink)));
    let error = Taylor::new().end(&kinked, &start, 1.0).unwrap_err();
    assert!(matches!(error, IntegrateError::DriveWithoutSeries { drive: 0, .. }), "{error}");
}

/// Every contact law of the crate under a strong excitation: as many crossings as by DOP853, at the same
/// instants.
#[test]
fn every_contact_law_against_dop853() {
    fn check<N: Nonlinearity>(name: &str, law: N, stiffness: Wave) {
        let error = Wave::new(Fourier::new(0.0, &[[0.0, 0.4], [0.1, 0.0]]).unwrap());
        let mesh = Mesh::new(stiffness, error, law);
        let spur = Machine::of_constants(Spur(mesh), &[("speed", 0.7), ("load", 0.1)]).unwrap();
        let start = State::new(0.0, &[1.3], &[0.0]);
        // The force of a power law has no bounded second derivative on its edge, which spoils the error
        // estimate of DOP853.
        let rough = ["PowerLaw", "Palmgren"].contains(&name);
        let longest = if rough { 2e-3 } else { 10.0 };
        let by_dop853 = Dop853::new().rtol(1e-13).atol(1e-15).max_step(longest);
        let (expected, last) = run(&by_dop853, &spur, &start, 60.0);
        let (found, end) = run(&Taylor::new(), &spur, &start, 60.0);
        println!("{name}: {} crossings, end {:.1e} apart", found.len(), (end.q[0] - last.q[0]).abs());
        assert_eq!(found.len(), expected.len(), "{name}");
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-8, "{name}: {found} instead of {expected}");
        }
        assert!((end.q[0] - last.q[0]).abs() < 1e-8, "{name}: {} {}", end.q[0], last.q[0]);
    }
    let smooth = || Wave::new(Fourier::new(1.0, &[[0.3, 0.0]]).unwrap());
    let rectangle = || Wave::new(RectangularWave::new(0.7, 1.3, 0.55).unwrap());
    let table = || {
        let samples: Vec<f64> = (0..16).map(|i| 1.0 + 0.3 * (i as f64 / 16.0 * TAU).cos()).collect();
        Wave::new(Table::new(&samples).unwrap())
    };
    check("Backlash", Backlash::new(1.0).unwrap(), smooth());
    check("rectangle", Backlash::new(1.0).unwrap(), rectangle());
    check("Table", Backlash::new(1.0).unwrap(), table());
    check("zero backlash", Backlash::new(0.0).unwrap(), smooth());
    let asymmetric = AsymmetricBacklash::new(-0.7, 1.1).unwrap().with_slopes(0.5, 1.5).unwrap();
    check("AsymmetricBacklash", asymmetric, smooth());
    let width = Wave::new(Fourier::new(1.0, &[[0.2, 0.1]]).unwrap());
    check("VaryingBacklash", VaryingBacklash::new(width.clone()), smooth());
    check("VaryingBacklash, rectangle", VaryingBacklash::new(width), rectangle());
    check("PowerLaw", PowerLaw::new(1.0, 1.5, 1.0).unwrap(), smooth());
    check("Palmgren", PowerLaw::new(1.0, 10.0 / 9.0, 1.0).unwrap(), smooth());
    check("NoPullBacklash", NoPullBacklash::new(1.0, 0.2).unwrap(), smooth());
    check("Damped", Damped::by_stiffness(Backlash::new(1.0).unwrap(), 0.2).unwrap(), smooth());
    let always = Damped::by_stiffness_always(Backlash::new(1.0).unwrap(), 0.2).unwrap();
    check("Damped, always", always, smooth());
    check("Damped by force", Damped::by_force(Backlash::new(1.0).unwrap(), 0.3).unwrap(), smooth());
    check("Linear", Linear, smooth());
    check("MixedLaw", MixedLaw::<Linear>::Backlash(Backlash::new(1.0).unwrap()), smooth());
    check("Cubic", Cubic::new(1.0, 0.5).unwrap(), smooth());
    check("SmoothedBacklash", SmoothedBacklash::new(1.0, 0.1).unwrap(), smooth());
}

/// Dense output, samples and sections inside long steps.
#[test]
fn results_inside_steps() {
    let oscillator = bare(1, Oscillator);
    let start = State::new(0.0, &[1.0], &[0.0]);
    let times: Vec<f64> = (0..500).map(|i| 0.1 * f64::from(i)).collect();
    let samples = Taylor::new().rtol(1e-14).sample(&oscillator, &start, &times).unwrap();
    for (i, t) in times.iter().enumerate() {
        assert!((samples.q(i)[0] - t.cos()).abs() < 1e-13 && (samples.v(i)[0] + t.sin()).abs() < 1e-13);
    }
    let mut section = Section::new(&oscillator, "q0", 0.0, Direction::Both).unwrap();
    let mut statistics = Statistics::new(&oscillator, &["q0"]).unwrap();
    let mut both = (&mut section, &mut statistics);
    let finish = Taylor::new().rtol(1e-14).run(&oscillator, &start, 20.0 * PI, &mut both).unwrap();
    assert!(finish.stats.steps < 40, "{:?}", finish.stats);
    assert_eq!(section.states().len(), 20);
    for (i, state) in section.states().iter().enumerate() {
        assert!((state.t - PI * (0.5 + i as f64)).abs() < 1e-13, "{}", state.t);
    }
    let summary = statistics.summary("q0").unwrap();
    assert!((summary.max - 1.0).abs() < 1e-13 && (summary.min + 1.0).abs() < 1e-13);
    assert!(summary.mean.abs() < 1e-12 && (summary.rms - 0.5f64.sqrt()).abs() < 1e-10, "{summary:?}");
}

algebra!(Oscillator, |q, _v, a| { a[0] = -q[0] });

/// The derivative of the flow by series and by DOP853, for every function and for jumps at edges.
#[test]
fn derivatives_of_the_flow() {
    fn check<M: Model>(name: &str, model: &M, start: &State, until: f64, within: f64) {
        let by = |method| Variation::new().flow_method(method).run(model, start, until).unwrap();
        let (taylor, dop853) = (by(FlowMethod::Taylor), by(FlowMethod::Dop853));
        let size = dop853.matrix.amax();
        let off = (&taylor.matrix - &dop853.matrix).amax() / size;
        println!("{name}: {off:.1e} of {size:.1e}, crossings {}", taylor.crossings);
        assert_eq!(taylor.crossings, dop853.crossings, "{name}");
        assert!(off < within, "{name}: {off:e}");
        assert_eq!(Variation::new().run(model, start, until).unwrap().method, FlowMethod::Taylor);
    }
    let mut v = [0.0; 8];
    v[0] = 1.0;
    check("functions", &bare(8, Functions), &State::new(0.0, &[0.5; 8], &v), 2.0, 1e-9);
    check("pendulum", &bare(1, Pendulum), &State::new(0.0, &[0.5], &[1.0]), 5.0, 1e-9);
    check("root", &bare(1, Root), &State::new(0.0, &[0.0], &[0.5]), 5.0, 1e-9);
    check("logarithm", &bare(1, Logarithm), &State::new(0.0, &[0.0], &[1.0]), 5.0, 1e-9);
    let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() }).unwrap();
    check("rattling pair", &pair, &pair.on_drive_flank().unwrap(), 300.0, 1e-8);
    let law = PowerLaw::new(0.0, 1.5, 1.0).unwrap().with_edges(f64::NEG_INFINITY, 1.0).unwrap();
    let bounce = Machine::of_constants(Bounce(law, 0), &[("speed", 1.0)]).unwrap();
    check("Hertz contact", &bounce, &State::new(0.0, &[0.0], &[2.0]), 4.0, 1e-7);
    let rectangle = Wave::new(RectangularWave::new(0.7, 1.3, 0.55).unwrap());
    let mesh = Mesh::new(rectangle, Wave::constant(0.0).unwrap(), NoPullBacklash::new(1.0, 0.2).unwrap());
    let spur = Machine::of_constants(Spur(mesh), &[("speed", 0.7), ("load", 0.1)]).unwrap();
    check("no pull, rectangle", &spur, &State::new(0.0, &[1.8], &[0.0]), 20.0, 1e-8);
}

/// The same run has the same bits in every thread.
#[test]
fn the_same_bits_in_every_thread() {
    let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() }).unwrap();
    let start = pair.on_drive_flank().unwrap();
    let bits = || {
        let end = Taylor::new().end(&pair, &start, 300.0).unwrap();
        [end.q[0].to_bits(), end.v[0].to_bits()]
    };
    let alone = bits();
    let many: Vec<[u64; 2]> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(bits)).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(many.iter().all(|other| *other == alone));
}

/// The error of `Dop853` under two tables of samples follows the tolerance. Steps at tight tolerances end at
/// the samples.
#[test]
fn steps_end_at_the_samples_of_a_table() {
    let samples =
        |n: usize| (0..n).map(move |i| 1.0 + 0.3 * (i as f64 * 12.9898).sin()).collect::<Vec<f64>>();
    let stiffness = Wave::new(Table::new(&samples(20)).unwrap());
    let error = Wave::new(Scaled::new(0.2, Wave::new(Table::new(&samples(12)).unwrap())).unwrap());
    let mesh = Mesh::new(stiffness, error, Linear);
    let spur = Machine::of_constants(Spur(mesh), &[("speed", 0.7), ("load", 0.1)]).unwrap();
    let (start, end) = (State::new(0.0, &[0.3], &[0.0]), 60.0);
    let count = |solver: &Dop853, spur: &dyn Model| {
        let mut met = 0;
        let mut watch = |step: &mut Step<'_>| {
            let of_sample = 0.7 * step.t1() * 20.0 / TAU;
            met += usize::from((of_sample - of_sample.round()).abs() < 1e-9);
            ControlFlow::Continue(())
        };
        (solver.run(spur, &start, end, &mut watch).unwrap().state, met)
    };
    let exact = Taylor::new().rtol(1e-14).atol(1e-16).end(&spur, &start, end).unwrap();
    // A law whose edges follow a table has knots of its own.
    let constant = || Wave::constant(1.0).unwrap();
    let width = VaryingBacklash::new(Wave::new(Table::new(&samples(8)).unwrap()));
    let law = Damped::by_stiffness(width, 0.2).unwrap();
    assert_eq!(Mesh::new(constant(), constant(), law).next_knot(0.1), Some(TAU / 8.0));
    for tolerance in [1e-6, 1e-8, 1e-10, 1e-12] {
        let solver = Dop853::new().rtol(tolerance).atol(tolerance);
        let (found, met) = count(&solver, &spur);
        let off = (found.q[0] - exact.q[0]).abs();
        println!("{tolerance:e}: off by {:.1} tolerances, {met} samples", off / tolerance);
        assert!(off < 10.0 * tolerance, "{tolerance:e}: {off:e}");
        assert!(met >= 130 || tolerance > 1e-8, "{met}");
    }
    // A maximum step of two spacings of one table: 133 samples lie within the run.
    let one = Mesh::new(Wave::new(Table::new(&samples(20)).unwrap()), constant(), Linear);
    let spur = Machine::of_constants(Spur(one), &[("speed", 0.7), ("load", 0.1)]).unwrap();
    let coarse = Dop853::new().rtol(1e-3).atol(1e-3);
    let [all, some] =
        [coarse.clone().max_step(2.0 * TAU / 20.0 / 0.7), coarse].map(|solver| count(&solver, &spur).1);
    assert!(all == 133 && some < 133, "{all} {some}");
}
