//! Branches and boundaries of an oscillator with a rigid stop, in closed form.

use crate::api::*;
use crate::data::read;
use crate::impacts::Oscillator;
use gear_dynamics::branches::{Branch, BranchEnd, Continuation, Family, PointKind, Sensitivity};
use gear_dynamics::contact::PieceChoice;
use gear_dynamics::excitation::{Angle, Fourier};
use gear_dynamics::model::{Drives, Size};

/// x'' + c x' + x + γ x³ = A (cos φ + a cos (2 φ + ψ)) with rigid stops at r x = d above and r x = -e below. The deflection
/// is r x.
#[derive(PartialEq)]
struct Stop {
    cos: Wave,
    sin: Wave,
    restitution: Restitution,
}

const NAMES: [&str; 9] =
    ["speed", "amplitude", "damping", "stop", "lower stop", "cubic", "second", "shift", "radius"];

impl Shape for Stop {
    #[inline(always)]
    fn size(&self) -> Size {
        Size { dof: 1, waves: 2, contacts: 1, constants: NAMES.len(), ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        NAMES.map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.cos.value(angle, side);
        u[1] = self.sin.value(angle, side);
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        _: &L,
        _: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let [_, _, upper, lower, _, _, _, r] = u.constants();
        Contact { deflection: r * q[0], rate: r * v[0], lower: -lower, upper, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let ([cos, sin], [amplitude, damping, _, _, cubic, second, shift, _]) = (u.waves(), u.constants());
        let (double, sine) = (cos * cos - sin * sin, sin * cos * 2.0);
        let force = cos + second * (double * shift.cos() - sine * shift.sin());
        a[0] = amplitude * force - damping * v[0] - q[0] - cubic * q[0] * q[0] * q[0];
    }
    fn stops(&self) -> &[[bool; 2]] {
        &[[true, true]]
    }
    fn impact<S: Scalar>(&self, _: usize, _: Piece, _: Drives<'_, S>, _: &[S], v: &mut [S]) {
        v[0] = self.restitution.rebound(v[0], S::from(0.0));
    }
}

const DAMPING: f64 = 0.1;

/// A stop at 1 above; other constants by name.
fn oscillator(given: &[(&str, f64)]) -> Machine<Stop> {
    let wave = |pair: [f64; 2]| Wave::new(Fourier::new(0.0, &[pair]).unwrap());
    let restitution = Restitution::new(0.8).unwrap();
    let shape = Stop { cos: wave([1.0, 0.0]), sin: wave([0.0, 1.0]), restitution };
    let default = |name: &str| match name {
        "damping" => DAMPING,
        "stop" | "radius" => 1.0,
        "lower stop" => 50.0,
        _ => 0.0,
    };
    let of = |name: &str| given.iter().find(|(other, _)| *other == name).map_or(default(name), |(_, c)| *c);
    let constants: Vec<(&str, f64)> = NAMES.iter().map(|name| (*name, of(name))).collect();
    Machine::of_constants(shape, &constants).unwrap()
}

fn stop(speed: f64, amplitude: f64) -> Machine<Stop> {
    oscillator(&[("speed", speed), ("amplitude", amplitude)])
}

/// The amplitude at which orbits without impacts graze the stop.
fn grazing(speed: f64) -> f64 {
    (1.0 - speed * speed).hypot(DAMPING * speed)
}

/// The branch of orbits with one impact, from the amplitude 1 downwards. `v`: velocity after the impact there.
fn impacting(speed: f64, v: f64) -> Branch {
    let model = stop(speed, 1.0);
    let family = Family::over(&model, ["amplitude"]).unwrap();
    let start = Oscillator::new(DAMPING, speed, 1.0).guess(1, v);
    Continuation::new(1.0, 0.1).bounds(0.05, 1.1).run(&family, &[start]).unwrap()
}

/// The amplitude 0.3 with stops at 0.9 above and 1.1 below: without impacts the orbit reaches 0.9 where
/// (1 - ω²)² + (c ω)² = 1/9. The orbit that strikes the upper stop ends where it touches the lower one.
#[test]
fn an_orbit_ends_at_the_stop_that_it_reaches_next() {
    let two = [("amplitude", 0.3), ("stop", 0.9), ("lower stop", 1.1)];
    let model = |speed: f64| oscillator(&[two[0], two[1], two[2], ("speed", speed)]);
    let family = model(1.0);
    let family = Family::over(&family, ["speed"]).unwrap();
    let half = 1.0 - 0.5 * DAMPING * DAMPING;
    let root = (half * half - 1.0 + 1.0 / 9.0).sqrt();
    let [low, high] = [(half - root).sqrt(), (half + root).sqrt()];
    for (from, to, exact) in [(0.3, 2.0, low), (2.0, 0.3, high), (1.2, 0.3, high)] {
        let branch = Continuation::new(from, to).run(&family, None).unwrap();
        let at = branch.of_kind(PointKind::Grazing)[0].parameter;
        assert!((at - exact).abs() < 1e-13 * exact, "{from}: {at:?} {exact:?}");
    }
    for from in [0.95, 1.1] {
        let started = State::new(0.0, &[0.0], &[-1.5]);
        let settled = Settle::new().max_periods(2000).run(&Dop853::new(), &model(from), &started).unwrap();
        let branch = Continuation::new(from, 2.0).run(&family, &settled.state).unwrap();
        assert_eq!(branch.end(), &BranchEnd::Stop { contact: 0 });
        let last = branch.points().last().unwrap();
        assert_eq!(last.crossings, [[0, 1]]);
        assert!((last.peak_to_peak() - 2.0).abs() < 1e-9, "{:?}", last.peak_to_peak());
    }
}

/// Both branches end at the grazing, from the side with impacts as well: on a smooth side of the stop, and where the
/// orbits with impacts turn back. On the way the impact passes the phase of the first node.
#[test]
fn branches_with_impacts_end_at_the_grazing() {
    let data = read("impacts.json");
    for case in data["impact_oscillator"]["values"].as_array().unwrap() {
        let number = |key: &str| case[key].as_f64();
        let branch = impacting(number("w").unwrap(), number("v_at_A_1").unwrap());
        println!("{branch}");
        assert_eq!(branch.end(), &BranchEnd::Stop { contact: 0 });
        assert!(branch.notes().is_empty() && branch.points().len() < 100);
        for (kind, key) in [
            (PointKind::PeriodDoubling, "A_period_doubling"),
            (PointKind::Fold, "A_fold"),
            (PointKind::Grazing, "A_graze"),
        ] {
            let found = branch.of_kind(kind);
            assert_eq!(found.len(), usize::from(number(key).is_some()), "{kind}");
            if let Some(exact) = number(key) {
                println!("{kind} {:.1e}", found[0].parameter - exact);
                assert!((found[0].parameter - exact).abs() < 1e-11);
            }
        }
    }
}

/// The grazing over speed and amplitude, through the resonance at the speed 1.
#[test]
fn the_grazing_of_a_stop_passes_its_resonances() {
    let model = stop(0.6, 0.05);
    let family = Family::over(&model, ["amplitude"]).unwrap();
    let branch = Continuation::new(0.05, 1.0).run(&family, &State::at_rest(1)).unwrap();
    let plane = Family::over(&model, ["amplitude", "speed"]).unwrap();
    let range = Continuation::new(0.6, 2.2).bounds_across(0.0, 5.0);
    let line = range.run(&plane, branch.of_kind(PointKind::Grazing)[0]).unwrap();
    println!("{line}");
    assert_eq!(line.end(), &BranchEnd::Bound);
    for point in line.points() {
        let [amplitude, speed] = point.parameters;
        assert!((amplitude - grazing(speed)).abs() < 1e-11, "{speed} {amplitude}");
    }
    assert!(line.points().len() > 50);
}

/// The folds of orbits with one impact lie between two resonant grazings, at which the speed of the impact vanishes.
/// Closed form: the least amplitude A(v) of the orbits with the velocity v after the impact.
#[test]
fn folds_with_impacts_lie_between_resonant_grazings() {
    let branch = impacting(1.2, -1.618_119_618_100_248_4);
    let model = stop(1.2, 1.0);
    let plane = Family::over(&model, ["amplitude", "speed"]).unwrap();
    for end in [0.9, 2.6] {
        let range = Continuation::new(1.2, end).max_step(0.1).bounds_across(0.0, 5.0);
        let line = range.run(&plane, branch.of_kind(PointKind::Fold)[0]).unwrap();
        println!("{line}");
        assert_eq!(line.end(), &BranchEnd::SoftImpact { contact: 0 });
        for point in line.points() {
            let [amplitude, speed] = point.parameters;
            let closed = Oscillator::new(DAMPING, speed, amplitude);
            let mut v = [-6.0, -1e-6];
            for _ in 0..60 {
                let inner = [0.381_966_011_25, 0.618_033_988_75].map(|share| v[0] + share * (v[1] - v[0]));
                let [a, b] = inner.map(|v| closed.closed(1, v).1);
                v = if a < b { [v[0], inner[1]] } else { [inner[0], v[1]] };
            }
            let exact = closed.closed(1, 0.5 * (v[0] + v[1])).1;
            assert!((amplitude - exact).abs() < 1e-11, "{speed} {amplitude} {exact}");
        }
        let [amplitude, speed] = line.points().last().unwrap().parameters;
        assert!((amplitude - grazing(speed)).abs() < 1e-5);
    }
}

/// With many segments the nodes stand close: they keep clear of the impact as well.
#[test]
fn branches_with_impacts_on_many_segments() {
    impacts_on_segments(40);
}

#[test]
#[ignore = "half a minute without optimisation: cargo test --release --test suite branch_impacts -- --ignored"]
fn branches_with_impacts_on_more_segments() {
    impacts_on_segments(64);
}

fn impacts_on_segments(segments: i32) {
    let model = stop(1.2, 1.0);
    let family = Family::over(&model, ["amplitude"]).unwrap();
    let start = Oscillator::new(DAMPING, 1.2, 1.0).guess(1, -1.618_119_618_100_248_4);
    let orbit = Shooting::new().solve(&model, &[start]).unwrap();
    let times: Vec<f64> = (0..segments)
        .map(|i| orbit.states()[0].t + orbit.period() * f64::from(i) / f64::from(segments))
        .collect();
    let nodes: Vec<State> = times.iter().map(|t| orbit.at(&model, *t).unwrap()).collect();
    let branch = Continuation::new(1.0, 0.1).bounds(0.05, 1.1).run(&family, &nodes).unwrap();
    println!("{branch}");
    assert_eq!(branch.end(), &BranchEnd::Stop { contact: 0 });
    assert!((branch.of_kind(PointKind::Fold)[0].parameter - 0.151_682_351_638_280_78).abs() < 1e-10);
    assert!((branch.of_kind(PointKind::Grazing)[0].parameter - grazing(1.2)).abs() < 1e-10);
}

/// A deflection in another unit, and a lower stop that is never reached.
#[test]
fn stops_in_other_units() {
    for radius in [0.02, 50.0] {
        let model = oscillator(&[
            ("speed", 1.2),
            ("amplitude", 1.0),
            ("radius", radius),
            ("stop", radius),
            ("lower stop", 1e6 * radius),
        ]);
        let family = Family::over(&model, ["amplitude"]).unwrap();
        let start = Oscillator::new(DAMPING, 1.2, 1.0).guess(1, -1.618_119_618_100_248_4);
        let branch = Continuation::new(1.0, 0.1).bounds(0.05, 1.1).run(&family, &[start]).unwrap();
        println!("{branch}");
        assert!((branch.of_kind(PointKind::Grazing)[0].parameter - grazing(1.2)).abs() < 1e-11);
        let plane = Family::over(&model, ["amplitude", "speed"]).unwrap();
        let range = Continuation::new(1.2, 0.9).max_step(0.1).bounds_across(0.0, 5.0);
        let line = range.run(&plane, branch.of_kind(PointKind::Fold)[0]).unwrap();
        println!("{line}");
        assert_eq!(line.end(), &BranchEnd::SoftImpact { contact: 0 });
        let [amplitude, speed] = line.points().last().unwrap().parameters;
        assert!((amplitude - grazing(speed)).abs() < 1e-5);
    }
}

/// The amplitude of a softening spring grows through the fold up to the stop: both lie within one step.
#[test]
fn a_fold_before_a_stop_is_located() {
    let given = [("speed", 0.5), ("amplitude", 0.1), ("damping", 0.05), ("cubic", -0.05), ("stop", 40.0)];
    let model = oscillator(&given);
    let up_to = |stop: f64| {
        let model = model.with("stop", stop).unwrap();
        let family = Family::over(&model, ["speed"]).unwrap();
        Continuation::new(0.5, 1.1).run(&family, &State::at_rest(1)).unwrap()
    };
    let whole = up_to(40.0);
    let fold = whole.of_kind(PointKind::Fold)[0];
    let beyond = whole.points().iter().find(|point| point.arclength > fold.arclength).unwrap();
    println!("{whole}\n{} {}", fold.summaries[0].max, beyond.summaries[0].max);
    let branch = up_to(0.5 * (fold.summaries[0].max + beyond.summaries[0].max));
    println!("{branch}");
    assert_eq!(branch.end(), &BranchEnd::Stop { contact: 0 });
    assert!((branch.of_kind(PointKind::Fold)[0].parameter - fold.parameter).abs() < 1e-11);
    assert!(branch.of_kind(PointKind::Grazing)[0].arclength > branch.of_kind(PointKind::Fold)[0].arclength);
}

/// Where the second maximum of a motion with two harmonics reaches the stop, its grazing ends: no orbit passes a stop.
#[test]
fn a_grazing_ends_where_another_maximum_reaches_the_stop() {
    let model = oscillator(&[("speed", 0.45), ("amplitude", 0.05), ("second", 1.5), ("shift", 0.3)]);
    let family = Family::over(&model, ["amplitude"]).unwrap();
    let branch = Continuation::new(0.05, 3.0).run(&family, &State::at_rest(1)).unwrap();
    println!("{branch}");
    let plane = Family::over(&model, ["amplitude", "shift"]).unwrap();
    let range = Continuation::new(0.3, 7.0).both_ways().bounds(-7.0, 7.0);
    let line = range.run(&plane, branch.of_kind(PointKind::Grazing)[0]).unwrap();
    println!("{line}");
    assert_eq!(
        (line.first_end(), line.end()),
        (Some(&BranchEnd::Stop { contact: 0 }), &BranchEnd::Stop { contact: 0 })
    );
    for point in line.points() {
        let [amplitude, shift] = point.parameters;
        let at = model.with("amplitude", amplitude).unwrap().with("shift", shift).unwrap();
        let mut statistics = Statistics::new(&at, &["q0"]).unwrap();
        point.orbit.observe(&at, &mut statistics).unwrap();
        let top = statistics.summary("q0").unwrap().max;
        assert!(top < 1.0 + 1e-8, "{shift} {top}");
    }
}

/// Symmetric stops: both are grazed at once; orbits that strike both end at the same grazing.
#[test]
fn symmetric_stops() {
    let model = oscillator(&[("speed", 1.2), ("amplitude", 0.05), ("lower stop", 1.0)]);
    let family = Family::over(&model, ["amplitude"]).unwrap();
    let branch = Continuation::new(0.05, 2.0).run(&family, &State::at_rest(1)).unwrap();
    println!("{branch}");
    assert_eq!(branch.end(), &BranchEnd::Stop { contact: 0 });
    assert!((branch.of_kind(PointKind::Grazing)[0].parameter - grazing(1.2)).abs() < 1e-11);
    let plane = Family::over(&model, ["amplitude", "speed"]).unwrap();
    let range = Continuation::new(1.2, 2.0).bounds_across(0.0, 5.0);
    let line = range.run(&plane, branch.of_kind(PointKind::Grazing)[0]).unwrap();
    println!("{line}");
    assert_eq!(line.end(), &BranchEnd::Bound);
    assert!(
        line.points().iter().all(|point| (point.parameters[0] - grazing(point.parameters[1])).abs() < 1e-11)
    );
    let model = model.with("speed", 0.8).unwrap();
    let family = Family::over(&model, ["amplitude"]).unwrap();
    let strong = model.with("amplitude", 1.5).unwrap();
    let settled = Settle::new().run(&Dop853::new(), &strong, &State::at_rest(1)).unwrap();
    // A segment for each impact.
    let start = State { t: 0.0, ..settled.state };
    let orbit = Shooting::new().solve(&strong, &[start]).unwrap();
    let nodes: Vec<State> = [0.0, 0.5].map(|share| orbit.at(&strong, share * orbit.period()).unwrap()).into();
    let striking = Continuation::new(1.5, 0.1).bounds(0.05, 1.6).run(&family, &nodes).unwrap();
    println!("{striking}");
    assert_eq!(striking.points()[0].crossings, [[1, 1]]);
    assert_eq!(striking.end(), &BranchEnd::Stop { contact: 0 });
    let last = striking.of_kind(PointKind::Grazing).last().unwrap().parameter;
    assert!((last - grazing(0.8)).abs() < 1e-10, "{last}");
}

/// The onset of impacts moves with all constants as in closed form: A = d √((1 - Ω²)² + (c Ω)²).
#[test]
fn onset_of_impacts_by_its_derivatives() {
    let model = stop(0.8, 0.05);
    let family = Family::over(&model, ["amplitude"]).unwrap();
    let branch = Continuation::new(0.05, 1.0).run(&family, &State::at_rest(1)).unwrap();
    let slopes = Sensitivity::of_point(&model, "amplitude", branch.of_kind(PointKind::Grazing)[0]).unwrap();
    let place = |name: &str| NAMES.iter().position(|other| *other == name).unwrap();
    let (w, onset) = (0.8f64, grazing(0.8));
    let by_speed = (-2.0 * w * (1.0 - w * w) + DAMPING * DAMPING * w) / onset;
    for (name, exact) in
        [("stop", onset), ("speed", by_speed), ("damping", DAMPING * w * w / onset), ("lower stop", 0.0)]
    {
        println!("{name} {} {exact}", slopes[place(name)]);
        assert!((slopes[place(name)] - exact).abs() < 1e-9);
    }
}

/// A continuation to the end of the range of a constant, beyond which there is no model, ends there.
#[test]
fn branches_end_at_the_end_of_the_models() {
    let family = Family::of([("damping", "1")], |[damping]| {
        if damping < 0.0 {
            let (name, allowed) = ("damping".into(), "at least 0");
            return Err(ParameterError::OutOfRange { name, value: damping, allowed });
        }
        stop(0.7, 0.1).with("damping", damping)
    });
    let branch = Continuation::new(0.1, 0.0).run(&family, &State::at_rest(1)).unwrap();
    println!("{branch}");
    let last = branch.points().last().unwrap();
    assert_eq!((branch.end(), last.parameter), (&BranchEnd::Bound, 0.0));
    assert!((last.peak_to_peak() - 0.2 / 0.51).abs() < 1e-9);
}
