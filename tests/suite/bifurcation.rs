//! Bifurcation diagrams and basins of a pair with a dead zone and two coexisting motions.

use crate::api::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

/// x'' + 0.1 x' + g(x) = 0.25 + a cos(Ω t), g the dead zone of half width 1.
#[derive(PartialEq)]
struct Spur {
    law: Backlash,
}

type SpurPair = Machine<Spur>;

fn pair(omega: f64, amplitude: f64) -> Result<SpurPair, ParameterError> {
    Machine::of_constants(Spur { law: Backlash::new(1.0)? }, &[("omega", omega), ("amplitude", amplitude)])
}

impl Shape for Spur {
    #[inline(always)]
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, constants: 2, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("omega", "1"), Channel::new("amplitude", "1")]
    }
    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let ([wave], [amplitude], b) = (u.waves(), u.constants(), S::from(self.law.half_backlash()));
        a[0] = S::from(0.25) + amplitude * wave
            - v[0] * 0.1
            - self.law.force(Edges::symmetric(b, b).at(q[0], v[0]));
    }
    fn waves<A: Angle>(&self, angle: A, _: Side, u: &mut [A::Number]) {
        u[0] = angle.number().cos();
    }
}

fn engine() -> LaneRk4<8> {
    LaneRk4::new(256).lanes()
}

fn gentle(p: &Point<'_>) -> Result<SpurPair, ParameterError> {
    pair(p["omega"], 0.1)
}

fn in_contact(_: &Point<'_>, _: &SpurPair) -> Result<State, ParameterError> {
    Ok(State::new(0.0, &[1.25], &[0.0]))
}

fn over(omegas: &[f64]) -> Sweep {
    Sweep::new(Axis::of_values("omega", omegas).unwrap())
}

/// x at phase 0 of the motion that never leaves the flank: 1.25 + Re z with z = 0.1/(1 - Ω² + 0.1 i Ω). The
/// second value states whether it exists: |z| < 0.25.
fn linear(omega: f64) -> (f64, bool) {
    let (re, im) = (1.0 - omega * omega, 0.1 * omega);
    let square = re * re + im * im;
    (1.25 + 0.1 * re / square, 0.1 / square.sqrt() < 0.25)
}

/// The resonance curve bends to the left. Upwards the motion stays in contact until |z| = 0.25, at Ω =
/// 0.7795, and jumps soon after. Downwards it rattles far below this frequency.
#[test]
fn a_fold_is_crossed_both_ways() {
    let omegas: Vec<f64> = (0..=13).map(|i| 0.46 + 0.03 * f64::from(i)).collect();
    let sweep = over(&omegas).settle(200).measure(16);
    let diagram = Bifurcation::strobed("q0").run(&sweep.of(&engine(), gentle).start(in_contact)).unwrap();
    let hysteresis = diagram.hysteresis(1e-3).unwrap();
    println!("{hysteresis:?}, undecided {:?}", diagram.undecided());
    for (up, down) in diagram.up().iter().zip(diagram.down()) {
        let (x, exists) = linear(up.parameter);
        let on = |point: &DiagramPoint| point.values.iter().all(|q| (q - x).abs() < 1e-6);
        println!(
            "{:.3}: {x:.6} {:?} {:.6} | {:?} {:.6}",
            up.parameter, up.period_multiple, up.values[0], down.period_multiple, down.values[0]
        );
        // Upwards the motion is the linear one exactly where that exists.
        assert_eq!(on(up), exists, "{up:?}");
        assert_eq!(
            hysteresis.contains(&up.parameter),
            (exists && !on(down)) || (up.values[0] - down.values[0]).abs() > 0.1,
            "{down:?}"
        );
    }
    // Hysteresis occurs in one interval, from the fold to the jump after the loss of contact.
    let place = |omega: &f64| omegas.iter().position(|x| x == omega).unwrap();
    let (first, last) = (place(&hysteresis[0]), place(&hysteresis[hysteresis.len() - 1]));
    assert_eq!(last + 1 - first, hysteresis.len());
    assert!(first > 2 && omegas[last + 1] > 0.7795 && last + 1 < omegas.len());

    // A grid of starts finds two motions in the interval and one below it.
    let motions = |omega: f64| {
        let starts = Points::grid(vec![
            Axis::linear("q", -3.0, 3.0, 4).unwrap(),
            Axis::linear("v", -2.0, 2.0, 4).unwrap(),
        ])
        .unwrap();
        let start =
            |p: &Point<'_>, _: &SpurPair| Ok::<_, ParameterError>(State::new(0.0, &[p["q"]], &[p["v"]]));
        let rows = Sweep::new(starts)
            .settle(200)
            .measure(16)
            .strobe(16)
            .of(&engine(), |_| pair(omega, 0.1))
            .start(start)
            .run()
            .unwrap();
        let attractors = Attractors::find(&rows, 1e-4).unwrap();
        attractors.all().iter().map(|one| one.states[0][0]).collect::<Vec<_>>()
    };
    let middle = (first + last) / 2;
    let mut both = [diagram.up()[middle].values[0], diagram.down()[middle].values[0]];
    let mut found = motions(omegas[middle]);
    both.sort_by(f64::total_cmp);
    found.sort_by(f64::total_cmp);
    assert!(
        found.len() == 2 && found.iter().zip(both).all(|(a, b)| (a - b).abs() < 1e-5),
        "{found:?} {both:?}"
    );
    assert_eq!(motions(omegas[first - 2]).len(), 1);
}

/// The motions of examples/basins.rs at Ω = 0.69. A run with located edges confirms each of them. The counts
/// of their starts add up to the number of starts.
#[test]
fn two_motions_side_by_side() {
    let starts = Points::grid(vec![
        Axis::linear("q", -4.0, 4.0, 8).unwrap(),
        Axis::linear("v", -4.0, 4.0, 8).unwrap(),
    ])
    .unwrap();
    let start = |p: &Point<'_>, _: &SpurPair| Ok::<_, ParameterError>(State::new(0.0, &[p["q"]], &[p["v"]]));
    // Steps across edges keep a periodic motion from returning exactly. The distance falls with the square of
    // the step: 1.4e-4 with 256 steps, 1e-5 with 1024.
    let engine = LaneRk4::new(2048).lanes::<8>();
    let rows = Sweep::new(starts)
        .settle(60)
        .measure(16)
        .strobe(16)
        .of(&engine, |_| pair(0.69, 0.25))
        .start(start)
        .run()
        .unwrap();
    let attractors = Attractors::find(&rows, 1e-4).unwrap();
    println!("{:?}", attractors.all());
    assert_eq!(attractors.all().len(), 2);
    assert_eq!(attractors.all().iter().map(|one| one.rows).sum::<usize>(), 64);
    for (i, one) in attractors.all().iter().enumerate() {
        let of_it = (0..64).filter(|index| attractors.label(*index) == Some(i)).count();
        assert_eq!(of_it, one.rows);
        let (model, state) = (pair(0.69, 0.25).unwrap(), &one.states[0]);
        let period = one.period_multiple.unwrap() as f64 * model.period();
        let solver = Dop853::new().rtol(1e-10).atol(1e-12);
        let end = solver.end(&model, &State::new(0.0, &state[..1], &state[1..]), period).unwrap();
        assert!(
            (end.q[0] - state[0]).abs() < 1e-5 && (end.v[0] - state[1]).abs() < 1e-5,
            "{state:?} {end:?}"
        );
    }
    assert!(matches!(Attractors::find(&rows, f64::NAN), Err(ParameterError::NotFinite { .. })));
    assert!(Attractors::find(&rows, 0.0).is_err());
}

/// The settings of the sweep decide how closely a motion has to return, and thus at which points the diagram
/// is decided.
#[test]
fn a_diagram_says_where_it_cannot_decide() {
    let omegas = [0.60, 0.62, 0.64];
    let run = |sweep: Sweep| {
        Bifurcation::strobed("q0").run(&sweep.of(&engine(), gentle).start(in_contact)).unwrap()
    };
    let hasty = run(over(&omegas).settle(1).measure(4));
    assert_eq!((hasty.hysteresis(1e-3).unwrap(), hasty.undecided()), (vec![], omegas.to_vec()));
    assert!(run(over(&omegas).settle(1).measure(4).periodic_tolerance(0.5)).undecided().is_empty());
    assert!(hasty.hysteresis(f64::NAN).is_err() && hasty.hysteresis(0.0).is_err());

    // Points stay in the order of the axis, also for repeated values.
    let mixed = [0.64, 0.60, 0.64, 0.62];
    let diagram = run(over(&mixed).settle(60).measure(4));
    for way in [diagram.up(), diagram.down()] {
        assert_eq!(way.iter().map(|point| point.parameter).collect::<Vec<_>>(), mixed);
        assert_eq!(way.iter().map(|point| point.index).collect::<Vec<_>>(), [0, 1, 2, 3]);
    }
    assert_eq!((diagram.hysteresis(1e-6).unwrap(), diagram.undecided()), (vec![], vec![]));
}

#[test]
fn points_that_fail_leave_the_rest_of_the_diagram() {
    let some = |p: &Point<'_>| {
        if p["omega"] == 0.62 { Err("no pair".to_owned()) } else { gentle(p).map_err(|e| e.to_string()) }
    };
    let (bifurcation, sweep) = (Bifurcation::strobed("v0"), over(&[0.60, 0.62, 0.64]).settle(60).measure(4));
    let diagram = bifurcation.run(&sweep.of(&engine(), some).start(in_contact)).unwrap();
    assert_eq!(diagram.up().iter().map(|point| point.parameter).collect::<Vec<_>>(), [0.60, 0.64]);
    assert_eq!((diagram.hysteresis(1e-3).unwrap(), diagram.undecided()), (vec![], vec![0.62]));

    let none = |_: &Point<'_>| Err::<SpurPair, _>("no pair");
    let diagram = bifurcation.run(&sweep.of(&engine(), none).start(in_contact)).unwrap();
    assert_eq!((diagram.up().len(), diagram.undecided()), (0, vec![0.60, 0.62, 0.64]));
    assert_eq!(diagram.rows()[1].errors()[&2], PointError::Model(FamilyError::new("no pair")));
}

#[test]
fn a_diagram_that_cannot_be_drawn_is_refused_before_it_runs() {
    let started = AtomicUsize::new(0);
    let start = |p: &Point<'_>, m: &SpurPair| {
        started.fetch_add(1, Relaxed);
        in_contact(p, m)
    };
    let run = |diagram: Bifurcation, sweep: Sweep| {
        diagram.run(&sweep.of(&engine(), gentle).start(start)).unwrap_err()
    };
    let wrong = run(Bifurcation::strobed("deflection"), over(&[0.6, 0.7]));
    assert_eq!(
        wrong,
        SweepError::Parameter(ParameterError::NoSuchChannel {
            name: "deflection".into(),
            known: "q0, v0".into()
        })
    );
    let wrong = run(Bifurcation::extremes("q1"), over(&[0.6, 0.7]));
    assert!(matches!(wrong, SweepError::Parameter(ParameterError::NoSuchChannel { .. })));
    let axes = vec![Axis::of_values("omega", &[0.6, 0.7]).unwrap(), Axis::of_values("load", &[1.0]).unwrap()];
    let wrong = run(Bifurcation::strobed("q0"), Sweep::new(Points::grid(axes).unwrap()));
    assert!(matches!(wrong, SweepError::Parameter(ParameterError::Length { expected: 1, found: 2, .. })));
    assert_eq!(started.load(Relaxed), 0);
}

#[test]
fn a_diagram_is_watched_and_stopped() {
    let omegas: Vec<f64> = (0..20).map(|i| 0.60 + 0.01 * f64::from(i)).collect();
    let (bifurcation, sweep, engine) =
        (Bifurcation::strobed("q0"), over(&omegas).settle(20).measure(4), engine());
    let runner = || sweep.of(&engine, gentle).start(in_contact);
    let (most, rows) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let stop = Arc::new(AtomicBool::new(false));
    let progress = |done: usize, total: usize| {
        assert!(total == 40 && done <= total);
        most.fetch_max(done, Relaxed);
    };
    let row = |_: &Row<'_>| {
        rows.fetch_add(1, Relaxed);
    };
    let watched = runner().row_callback(row).watch(Watch::new().progress(progress).cancel(stop.clone()));
    let whole = bifurcation.run(&watched).unwrap();
    assert_eq!(
        (most.load(Relaxed), rows.load(Relaxed), whole.up().len(), whole.down().len()),
        (40, 40, 20, 20)
    );

    let stopping = |_: &Row<'_>| stop.store(rows.fetch_add(1, Relaxed) > 42, Relaxed);
    let part =
        bifurcation.run(&runner().row_callback(stopping).watch(Watch::new().cancel(stop.clone()))).unwrap();
    assert!((2..10).contains(&(part.up().len() + part.down().len())));
    assert!(!part.rows()[0].is_complete() && part.up().iter().zip(whole.up()).all(|(a, b)| a == b));
}
