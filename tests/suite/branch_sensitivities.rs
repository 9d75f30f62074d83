//! Derivatives of orbits, figures and located points with respect to constants, against differences.

use crate::common::family::oscillator;
use gear_dynamics::branches::{
    BranchError, BranchPoint, Continuation, CurveError, DesignError, Family, Figure, Fit, Least, PointKind,
    Sensitivity,
};
use gear_dynamics::contact::{Contact, ContactDamping, Piece, PieceChoice, Restitution};
use gear_dynamics::excitation::{Angle, Fourier, Side, Wave};
use gear_dynamics::model::{Channel, Drives, Machine, Periodic, Scalar, Shape, Size, State};
use gear_dynamics::models::Oscillator;
use gear_dynamics::ode::Exhausted;
use gear_dynamics::periodic::ShootingOrbit;
use gear_dynamics::trains::{Body, MeshPart, Parts};
use gear_dynamics::{Budget, Dop853, NfgPair, NfgParams, ParameterError, Settle, Shooting, Statistics};
use std::f64::consts::PI;

/// Central difference of fourth order.
fn difference(f: &dyn Fn(f64) -> f64, at: f64, h: f64) -> f64 {
    (8.0 * (f(at + h) - f(at - h)) - (f(at + 2.0 * h) - f(at - 2.0 * h))) / (12.0 * h)
}

fn figures<M: Periodic>(model: &M, orbit: &ShootingOrbit, channel: &str) -> [f64; 4] {
    let mut statistics = Statistics::new(model, &[channel]).unwrap();
    orbit.observe(model, &mut statistics).unwrap();
    let s = statistics.summary(channel).unwrap();
    [s.mean, s.rms, s.peak_to_peak(), orbit.multipliers().largest()]
}

/// All derivatives of one orbit against differences, in units of figure over constant.
fn check(model: &Oscillator, start: &State, channel: &str, worst: f64) {
    let orbit = Shooting::new().solve(model, start).unwrap();
    let slopes = Sensitivity::of(model, &orbit, &[channel]).unwrap();
    let multiplier = Sensitivity::of_largest_multiplier(model, &orbit).unwrap();
    let reference = figures(model, &orbit, channel);
    for (k, constant) in model.names().iter().enumerate() {
        let value = model.constant(&constant.name).unwrap();
        if value == 0.0 {
            continue;
        }
        let figure = |which: usize| {
            move |c: f64| {
                let moved = model.with(&constant.name, c).unwrap();
                let orbit = Shooting::new().solve(&moved, start).unwrap();
                figures(&moved, &orbit, channel)[which]
            }
        };
        assert_eq!(multiplier[k][0], multiplier[k][1], "no contact grazes");
        let ours = [
            slopes.slopes(Figure::Mean, channel).unwrap()[k],
            slopes.slopes(Figure::Rms, channel).unwrap()[k],
            slopes.slopes(Figure::PeakToPeak, channel).unwrap()[k],
            multiplier[k][0],
        ];
        for (which, ours) in ours.into_iter().enumerate() {
            let theirs = difference(&figure(which), value, 2e-4 * value.abs());
            // The mean of a symmetric orbit is 0: errors are shares of the peak-to-peak value.
            let size = if which == 3 { 1.0 } else { reference[2] };
            let off = (ours - theirs).abs() * value.abs() / size;
            println!("{:>15} {which} {ours:>14.8} {theirs:>14.8} {off:.1e}", constant.name);
            assert!(off < worst, "{} {which}: {ours} {theirs}", constant.name);
        }
    }
}

fn pair() -> Oscillator {
    oscillator(&[
        ("speed", 0.8),
        ("mesh stiffness", 1.0),
        ("stiffness variation", 0.1),
        ("mean force", 0.1),
        ("inertia force", 0.05),
        ("damping", 0.1),
    ])
}

#[test]
fn figures_of_a_pair_that_loses_contact() {
    let start = State::new(0.0, &[1.0], &[0.25]);
    let orbit = Shooting::new().solve(&pair(), &start).unwrap();
    assert!(orbit.crossing_count() > 0);
    check(&pair(), &start, "deflection", 1e-7);
    check(&pair(), &start, "mesh force", 1e-7);
}

#[test]
fn figures_of_a_duffing_oscillator() {
    let given = [
        ("speed", 1.2),
        ("cubic stiffness", 0.1),
        ("linear stiffness", 1.0),
        ("force", 0.18),
        ("damping", 0.05),
    ];
    let model = oscillator(&[&given[..], &[("half backlash", 9.0)]].concat());
    check(&model, &State::at_rest(1), "q0", 1e-7);
}

/// A fold and a grazing, moved by a small change of two constants.
#[test]
fn a_fold_and_a_grazing() {
    let model = pair();
    let family = Family::over(&model, ["speed"]).unwrap();
    let start = State::new(0.0, &[1.1], &[0.0]);
    let branch = Continuation::new(0.6, 0.95).run(&family, &start).unwrap();
    for kind in [PointKind::Fold, PointKind::Grazing] {
        let point = branch.of_kind(kind)[0];
        let slopes = Sensitivity::of_point(&model, "speed", point).unwrap();
        for name in ["damping", "inertia force"] {
            let value = model.constant(name).unwrap();
            let place = model.names().iter().position(|channel| channel.name == name).unwrap();
            let at = |c: f64| moved_point(&model, name, c, point);
            let theirs = difference(&at, value, 1e-4 * value);
            println!("{kind} {name}: {} {theirs}", slopes[place]);
            assert!((slopes[place] - theirs).abs() * value < 1e-7 * point.parameter);
        }
        assert_eq!(slopes[0], 0.0);
    }
}

/// Every kind of located point, moved by a small change of each constant.
#[test]
fn located_points_of_a_pair() {
    let model =
        oscillator(&[("mesh stiffness", 1.0), ("mean force", 0.25), ("force", 0.25), ("damping", 0.1)]);
    let family = Family::over(&model, ["speed"]).unwrap();
    let range = Continuation::new(2.5, 0.4).bounds(0.35, 2.6);
    let branch = range.run(&family, &State::new(0.0, &[1.0], &[0.0])).unwrap();
    for (kind, point) in branch.located() {
        let slopes = Sensitivity::of_point(&model, "speed", point).unwrap();
        for name in ["damping", "mean force", "force", "mesh stiffness"] {
            let value = model.constant(name).unwrap();
            let place = model.names().iter().position(|channel| channel.name == name).unwrap();
            let at = |c: f64| moved_point(&model, name, c, point);
            let theirs = difference(&at, value, 2e-5 * value);
            let off = (slopes[place] - theirs).abs() * value / point.parameter;
            println!(
                "{kind:>16} {:.6} {name:>14} {:>13.8} {theirs:>13.8} {off:.1e}",
                point.parameter, slopes[place]
            );
            // The doubling at 0.39937 lies 1.6e-4 from a grazing, where second derivatives are unbounded.
            let near = kind.kind() == PointKind::PeriodDoubling && (point.parameter - 0.3993).abs() < 2e-4;
            let bound = if near { 1e-6 } else { 1e-7 };
            assert!(off < bound, "{kind} {name}: {} {theirs}", slopes[place]);
        }
    }
}

/// At a grazing the multipliers change with the root of the penetration: their derivative is bounded on one side.
#[test]
fn multipliers_at_a_grazing_have_one_sided_derivatives() {
    let model =
        oscillator(&[("mesh stiffness", 1.0), ("mean force", 0.25), ("force", 0.25), ("damping", 0.1)]);
    let family = Family::over(&model, ["speed"]).unwrap();
    let range = Continuation::new(2.5, 0.4).bounds(0.35, 2.6);
    let branch = range.run(&family, &State::new(0.0, &[1.0], &[0.0])).unwrap();
    // The multipliers of this grazing are real; those of complex pairs have an absolute value that depends on the
    // damping and the period only.
    let [.., point, _] = branch.of_kind(PointKind::Grazing)[..] else { panic!("four grazings") };
    let at = model.with("speed", point.parameter).unwrap();
    let sides = Sensitivity::of_largest_multiplier(&at, &point.orbit).unwrap();
    for name in ["speed", "damping", "mean force", "force", "mesh stiffness"] {
        let (value, k) =
            (at.constant(name).unwrap(), at.names().iter().position(|c| c.name == name).unwrap());
        let way = if sides[k][0].is_finite() { -1.0 } else { 1.0 };
        let [finite, unbounded] = if way < 0.0 { sides[k] } else { [sides[k][1], sides[k][0]] };
        // A difference of third order on the side where it is bounded.
        let h = 1e-5 * value * way;
        let largest = |c: f64| {
            let orbit = Shooting::new().solve_from(&at.with(name, c).unwrap(), &point.orbit).unwrap();
            orbit.multipliers().largest()
        };
        let weights = [-11.0 / 6.0, 3.0, -1.5, 1.0 / 3.0];
        let theirs: f64 =
            weights.iter().enumerate().map(|(i, w)| w * largest(value + i as f64 * h)).sum::<f64>() / h;
        println!("{name} {sides:?} {theirs}", sides = sides[k]);
        assert!(finite.is_finite() && unbounded.is_infinite(), "{name}");
        assert!((finite - theirs).abs() < 1e-5 * finite.abs(), "{name} {finite} {theirs}");
    }
}

/// The parameter to which the point moves with a constant, along its boundary.
fn moved_point(model: &Oscillator, name: &str, value: f64, point: &BranchPoint) -> f64 {
    let from = model.constant(name).unwrap();
    if value == from {
        return point.parameter;
    }
    let plane = Family::over(model, ["speed", name]).unwrap();
    let line = Continuation::new(from, value).first_step(1.0).max_step(1.0).run(&plane, point).unwrap();
    let [parameter, reached] = line.points().last().unwrap().parameters;
    assert_eq!(reached, value);
    parameter
}

#[test]
#[ignore = "half a minute without optimisation: cargo test --release --test suite -- --ignored"]
fn the_face_gear_pair() {
    let pair = NfgPair::new(&NfgParams { speed: 110.0, ..NfgParams::table1() }).unwrap();
    let orbit = Shooting::new().solve(&pair, &[pair.on_drive_flank().unwrap()]).unwrap();
    let slopes = Sensitivity::of(&pair, &orbit, &["deflection"]).unwrap();
    let ours = slopes.slopes(Figure::PeakToPeak, "deflection").unwrap();
    for (k, constant) in pair.names().iter().enumerate() {
        let value = pair.constant(&constant.name).unwrap();
        let unit = if value == 0.0 { continue } else { value.abs() };
        let figure = |c: f64| {
            let moved = pair.with(&constant.name, c).unwrap();
            figures(&moved, &Shooting::new().solve_from(&moved, &orbit).unwrap(), "deflection")[2]
        };
        let theirs = difference(&figure, value, 1e-5 * unit);
        let off = (ours[k] - theirs).abs() * unit / figures(&pair, &orbit, "deflection")[2];
        println!("{:>20} {:>14.6e} {theirs:>14.6e} {off:.1e}", constant.name, ours[k]);
        assert!(off < 1e-7);
    }
}

/// Damping and cubic stiffness of a Duffing oscillator from its amplitudes at five speeds.
#[test]
fn constants_are_fitted_to_a_response() {
    let given = [("speed", 0.7), ("linear stiffness", 1.0), ("force", 0.18), ("half backlash", 9.0)];
    let truth = oscillator(&[&given[..], &[("cubic stiffness", 0.1), ("damping", 0.05)]].concat());
    let start = oscillator(&[&given[..], &[("cubic stiffness", 0.05), ("damping", 0.15)]].concat());
    let fit = Fit::new("speed", "q0", Figure::PeakToPeak).over("damping", 0.02, 0.3).over(
        "cubic stiffness",
        0.01,
        0.3,
    );
    let speeds: Vec<f64> = (0..5).map(|i| 0.7 + 0.1 * f64::from(i)).collect();
    let measured = fit.response(&truth, &speeds, &State::at_rest(1)).unwrap();
    let pairs: Vec<(f64, f64)> = speeds.into_iter().zip(measured).collect();
    let found = fit.run(&start, &pairs, &State::at_rest(1)).unwrap();
    println!("{:?} {} after {} evaluations", found.constants, found.value, found.evaluations);
    assert!((found.constants[0].1 - 0.05).abs() < 1e-6 && (found.constants[1].1 - 0.1).abs() < 1e-6);
}

/// Two harmonics of a force: the least peak-to-peak value against a grid. Each error by name.
#[test]
fn least_peak_to_peak_value() {
    let model = oscillator(&[
        ("speed", 1.3),
        ("mesh stiffness", 1.0),
        ("mean force", 0.3),
        ("force", 0.2),
        ("inertia force", 0.02),
        ("damping", 0.1),
        ("stiffness variation", 0.05),
    ]);
    let least = Least::new("deflection", Figure::PeakToPeak).over("inertia force", -0.2, 0.1).over(
        "stiffness variation",
        0.0,
        0.3,
    );
    let guess = [State::new(0.0, &[1.3], &[0.0])];
    let best = least.run(&model, &guess).unwrap();
    println!("{:?} {} after {}", best.constants, best.value, best.evaluations);
    let mut grid = (f64::INFINITY, [0.0; 2]);
    for i in 0..=40 {
        for j in 0..=20 {
            let [a, d] = [-0.2 + 0.3 * f64::from(i) / 40.0, 0.3 * f64::from(j) / 20.0];
            let moved = model.with("inertia force", a).unwrap().with("stiffness variation", d).unwrap();
            let orbit = Shooting::new().solve(&moved, &guess).unwrap();
            let value = figures(&moved, &orbit, "deflection")[2];
            if value < grid.0 {
                grid = (value, [a, d]);
            }
        }
    }
    println!("{grid:?}");
    assert!(best.value < 1.0001 * grid.0);
    let none = Least::new("deflection", Figure::Rms).run(&model, &guess);
    assert!(matches!(none, Err(DesignError::Parameter(_))));
    let few = least.clone().max_evaluations(2).run(&model, &guess);
    assert!(matches!(few, Err(DesignError::NotConverged { evaluations: 1..=2, .. })), "{few:?}");
    let bounds =
        Least::new("deflection", Figure::Rms).over("stiffness variation", 0.1, 0.3).run(&model, &guess);
    assert!(matches!(bounds, Err(DesignError::Parameter(ParameterError::Bounds { value: 0.05, .. }))));
}

/// A spent budget keeps the best constants found; a cancelled search has none.
#[test]
fn a_search_ends_with_its_budget() {
    let model = oscillator(&[
        ("speed", 0.7),
        ("mesh stiffness", 1.0),
        ("mean force", 0.3),
        ("force", 0.1),
        ("damping", 0.1),
    ]);
    let least =
        Least::new("deflection", Figure::PeakToPeak).over("damping", 0.05, 0.3).over("force", 0.05, 0.2);
    let guess = [State::new(0.0, &[1.3], &[0.0])];
    let spent = least.clone().budget(Budget::new().steps(30)).run(&model, &guess);
    let Err(DesignError::NotConverged { reason, constants, .. }) = spent else { panic!("{spent:?}") };
    assert_eq!((reason.as_str(), constants.len()), ("design: the budget of 30 steps is spent", 2));
    let stop = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(true));
    let cancelled = least.budget(Budget::new().cancel(stop)).run(&model, &guess);
    assert!(matches!(cancelled, Err(DesignError::Exhausted(Exhausted::Cancelled))), "{cancelled:?}");
}

/// A cancelled fit ends before its first orbit; a spent time ends it between orbits.
#[test]
fn a_fit_ends_with_its_budget() {
    let model = oscillator(&[("speed", 0.7), ("linear stiffness", 1.0), ("force", 0.18), ("damping", 0.1)]);
    let points: Vec<(f64, f64)> = (0..50).map(|i| (0.7 + 0.01 * f64::from(i), 1.0)).collect();
    let speeds: Vec<f64> = points.iter().map(|(speed, _)| *speed).collect();
    let fit = Fit::new("speed", "q0", Figure::PeakToPeak).over("damping", 0.02, 0.3);
    let stop = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(true));
    let cancelled = fit.clone().budget(Budget::new().cancel(stop));
    let short = fit.budget(Budget::new().time(std::time::Duration::from_micros(1)));
    for (of, ends) in [(cancelled, "cancelled"), (short, "the budget of 1µs is spent")] {
        let run = of.run(&model, &points, &State::at_rest(1)).map(|_| ());
        let response = of.response(&model, &speeds, &State::at_rest(1)).map(|_| ());
        for ended in [run, response] {
            assert!(matches!(ended, Err(DesignError::Exhausted(_))), "{ended:?}");
            assert_eq!(ended.unwrap_err().to_string(), format!("design: {ends}"));
        }
    }
}

/// Constants whose value is 0 or small in its unit; orbits of another model.
#[test]
fn derivatives_by_constants_without_a_size() {
    let given =
        [("speed", 0.7), ("mesh stiffness", 1.0), ("mean force", 0.3), ("force", 0.1), ("damping", 0.1)];
    let guess = [State::new(0.0, &[1.3], &[0.0])];
    let by_cubic = |cubic: f64| {
        let model = oscillator(&[&given[..], &[("cubic stiffness", cubic)]].concat());
        let orbit = Shooting::new().solve(&model, &guess).unwrap();
        let slopes = Sensitivity::of(&model, &orbit, &["deflection"]).unwrap();
        slopes.slopes(Figure::Mean, "deflection").unwrap()
            [model.names().iter().position(|c| c.name == "cubic stiffness").unwrap()]
    };
    let mean = |cubic: f64| {
        let model = oscillator(&[&given[..], &[("cubic stiffness", cubic)]].concat());
        figures(&model, &Shooting::new().solve(&model, &guess).unwrap(), "deflection")[0]
    };
    let theirs = difference(&mean, 0.0, 1e-3);
    for cubic in [0.0, 1e-14, 1e-9] {
        let ours = by_cubic(cubic);
        println!("{cubic:e} {ours} {theirs}");
        assert!((ours / theirs - 1.0).abs() < 1e-7);
    }
    let model = oscillator(&given);
    let orbit = Shooting::new().solve(&model, &guess).unwrap();
    let other = Sensitivity::of(&model.with("speed", 0.75).unwrap(), &orbit, &["deflection"]);
    assert!(matches!(other, Err(BranchError::Curve(CurveError::NoSolution { .. }))), "{other:?}");
}

/// A loose gear that strikes a swinging flank once a turn. Between impacts it flies with the drag g: v falls from g T/2 to
/// -g T/2, so that its mean is 0, and the lowest place A sin φ is that of the impact, with
/// cos φ = g T (1 - e)/(1 + e)/(2 A). The velocity jumps, and q has a corner.
#[derive(PartialEq)]
struct LooseGear {
    flank: Wave,
    restitution: Restitution,
}

impl Shape for LooseGear {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 2, contacts: 1, constants: 2, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "rad/s"), Channel::new("drag", "m/s²")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        let flank = self.flank.jet(angle, side);
        (u[0], u[1]) = (flank.value, flank.rate);
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        _: &L,
        _: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let [lower, slope] = u.waves();
        Contact { deflection: q[0], rate: v[0], lower, lower_rate: slope * u.speed(), ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, _: &[S], _: &[S], a: &mut [S]) {
        let [drag] = u.constants();
        a[0] = -drag;
    }
    fn stops(&self) -> &[[bool; 2]] {
        &[[true, false]]
    }
    fn impact<S: Scalar>(&self, _: usize, _: Piece, u: Drives<'_, S>, _: &[S], v: &mut [S]) {
        let [_, slope] = u.waves();
        v[0] = self.restitution.rebound(v[0], slope * u.speed());
    }
}

#[test]
fn figures_that_jump_or_turn_at_an_impact() {
    let (amplitude, e) = (1.2, 0.5);
    let flank = Wave::new(Fourier::new(0.0, &[[0.0, amplitude]]).unwrap());
    let gear = LooseGear { flank, restitution: Restitution::new(e).unwrap() };
    let gear = Machine::of_constants(gear, &[("speed", 1.0), ("drag", 1.0)]).unwrap();
    let cos = PI * (1.0 - e) / (1.0 + e) / amplitude;
    for impact in [cos.acos(), -cos.acos()] {
        let height = amplitude * impact.sin() + PI * PI / 2.0;
        let orbit = Shooting::new().solve(&gear, &State::new(impact + PI, &[height], &[0.0])).unwrap();
        let slopes = Sensitivity::of(&gear, &orbit, &["v0", "q0"]).unwrap();
        let drag = slopes.index("drag").unwrap();
        let lowest = -amplitude * cos * cos / impact.sin();
        let expected = [
            (Figure::Mean, "v0", 0.0),
            (Figure::Rms, "v0", PI / 3f64.sqrt()),
            (Figure::Max, "v0", PI),
            (Figure::Min, "v0", -PI),
            (Figure::Min, "q0", lowest),
            (Figure::Max, "q0", lowest + PI * PI / 2.0),
            (Figure::Mean, "q0", lowest + PI * PI / 3.0),
        ];
        for (figure, channel, expected) in expected {
            let found = slopes.slopes(figure, channel).unwrap()[drag];
            assert!((found - expected).abs() < 1e-6, "{impact}: {figure:?} of {channel}: {found} {expected}");
        }
    }
}

/// The mean mesh force is the torque over the radius, whatever the speed, the damping and the backlash are: with damping
/// in contact only the force jumps where the teeth meet and part.
#[test]
fn the_mean_of_a_force_that_jumps_at_its_edge() {
    let mut orbits = 0;
    for (error, speed) in [(3e-6, 700.0), (3e-6, 1300.0), (2e-6, 1800.0), (2.5e-6, 2200.0)] {
        let stiffness = Wave::new(Fourier::new(2e8, &[[4e7, 0.0]]).unwrap());
        let mesh = MeshPart::external([20, 40], [0.03, 0.06], stiffness)
            .error(Wave::new(Fourier::new(0.0, &[[error, 0.5 * error]]).unwrap()))
            .damping(1000.0)
            .half_backlash(5e-5)
            .contact_damping(ContactDamping::InContact);
        let mut parts = Parts::new();
        parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(4e-3));
        parts.mesh("mesh", "pinion", "wheel", mesh).torque("drive", "pinion", 8.0).load("wheel");
        let train = parts.build("pinion", speed).unwrap();
        let solver = Dop853::new().rtol(1e-10).atol(1e-15);
        let Ok(steady) = Settle::new().max_periods(400).run(&solver, &train, None) else { continue };
        let shooting = Shooting::new().period_multiple(steady.period_multiple);
        let orbit = shooting.solve(&train, &steady.state).unwrap();
        if orbit.crossing_count() == 0 {
            continue;
        }
        orbits += 1;
        let slopes = Sensitivity::of(&train, &orbit, &["mesh force"]).unwrap();
        let by = |name: &str| slopes.slopes(Figure::Mean, "mesh force").unwrap()[slopes.index(name).unwrap()];
        assert!((by("drive") - 1.0 / 0.03).abs() < 1e-4, "{speed}: {}", by("drive"));
        // In newtons for the whole value of the constant.
        let force = 8.0 / 0.03;
        for (name, value) in [("speed", speed), ("mesh damping", 1000.0), ("mesh half backlash", 5e-5)] {
            assert!((by(name) * value).abs() < 1e-5 * force, "{speed}: {name} {:e}", by(name) * value);
        }
        // The least force is 0, that of the gap.
        let least = slopes.slopes(Figure::Min, "mesh force").unwrap();
        assert!(least.iter().all(|slope| slope.is_finite()));
    }
    assert!(orbits >= 2, "{orbits}");
}
