//! Branches of periodic orbits: located points against the reference, and against closed forms.

use crate::common::family::oscillator;
use crate::common::oscillators::{CubicChain, Idler};
use crate::common::stored;
use crate::data::read;
use gear_dynamics::branches::{
    Branch, BranchEnd, BranchError, BranchPoint, Continuation, CurveError, Family, PointKind, Sensitivity,
    Switch,
};
use gear_dynamics::model::State;
use gear_dynamics::models::Oscillator;
use gear_dynamics::ode::Exhausted;
use gear_dynamics::periodic::Stability;
use gear_dynamics::{Budget, ParameterError, Shooting};

/// Bifurcations of a case in periodic_orbits.json: kind and parameter.
fn reference(case: &str) -> Vec<(String, f64)> {
    let file = read("periodic_orbits.json");
    let list = file["time_domain"][case]["bifurcations"].as_array().unwrap();
    let kind = |kind: &str| match kind {
        "LP" => "fold",
        "PD" => "period-doubling",
        _ => "neimark-sacker",
    };
    list.iter().map(|b| (kind(b["type"].as_str().unwrap()).into(), b["Omega"].as_f64().unwrap())).collect()
}

/// Every reference point is found once to `accuracy`, and no other of these kinds.
fn compare(branch: &Branch, reference: &[(String, f64)], accuracy: f64) {
    println!("{branch}");
    let mut found: Vec<(String, f64)> = branch
        .located()
        .filter(|(kind, _)| kind.kind() != PointKind::Grazing && kind.kind() != PointKind::Branch)
        .map(|(kind, point)| (kind.kind().to_string(), point.parameter))
        .collect();
    for (kind, at) in reference {
        let nearest = (0..found.len())
            .filter(|&i| found[i].0 == *kind)
            .min_by(|&i, &j| (found[i].1 - at).abs().total_cmp(&(found[j].1 - at).abs()));
        let nearest = nearest.unwrap_or_else(|| panic!("no {kind} at {at}"));
        let (_, parameter) = found.swap_remove(nearest);
        println!("{kind:>16} {at:.12} {:.1e}", parameter - at);
        assert!((parameter - at).abs() < accuracy, "{kind} {parameter} {at}");
    }
    assert!(found.is_empty(), "not in the reference: {found:?}");
}

fn follow(model: &Oscillator, continuation: &Continuation) -> Branch {
    let family = Family::over(model, ["speed"]).unwrap();
    let start = State::new(0.0, &[model.constant("mean force").unwrap() + 1.0], &[0.0]);
    continuation.run(&family, &[start]).unwrap()
}

#[test]
fn duffing() {
    let model = oscillator(&[
        ("cubic stiffness", 0.1),
        ("linear stiffness", 1.0),
        ("force", 0.18),
        ("damping", 0.05),
    ]);
    let branch = follow(&model, &Continuation::new(0.5, 1.6));
    compare(&branch, &reference("duffing_nlvib01"), 1e-10);
    assert_eq!(branch.end(), &BranchEnd::Bound);
}

#[test]
fn spur_pair_of_kahraman_and_singh() {
    let model = oscillator(&[
        ("mesh stiffness", 1.0),
        ("mean force", 0.1),
        ("inertia force", 0.05),
        ("damping", 0.1),
    ]);
    let branch = follow(&model, &Continuation::new(0.5, 1.1).bounds(0.2, 1.2));
    compare(&branch, &reference("deadzone_KS90"), 1e-10);
}

#[test]
fn dead_zone_under_a_strong_force() {
    let model =
        oscillator(&[("mesh stiffness", 1.0), ("mean force", 0.25), ("force", 0.25), ("damping", 0.1)]);
    let branch = follow(&model, &Continuation::new(2.5, 0.4).bounds(0.35, 2.6));
    compare(&branch, &reference("deadzone_Fm25_Fp25"), 1e-10);
}

/// A model without named constants: the derivative with respect to the parameter is computed by differences.
#[test]
fn chain_with_cubic_springs() {
    let family = Family::of([("speed", "1")], |[omega]| Ok(CubicChain { omega }));
    let branch = Continuation::new(0.9, 1.4).bounds(0.6, 1.5).run(&family, &State::at_rest(2)).unwrap();
    compare(&branch, &reference("nlvib02_2dof_cubic"), 1e-10);
}

/// Folds and period doublings of the classics, and the grazings in closed form.
#[test]
fn spur_pairs_of_the_classics() {
    let file = read("classic_orbits.json");
    for (name, case) in file["sdof_spur_pair"].as_object().unwrap() {
        let number = |key: &str| case["equation"][key].as_f64().unwrap();
        let depth = case["equation"]["a"][0].as_f64().unwrap_or(0.0);
        let model = oscillator(&[
            ("mesh stiffness", 1.0),
            ("stiffness variation", depth),
            ("mean force", number("Fm")),
            ("inertia force", number("Fah")),
            ("damping", 2.0 * number("zeta")),
        ]);
        let branch = follow(&model, &Continuation::new(0.5, 2.2));
        let of = |key: &str, kind: &str| -> Vec<(String, f64)> {
            let mut list: Vec<f64> =
                case[key].as_array().unwrap().iter().map(|point| point["W"].as_f64().unwrap()).collect();
            list.sort_by(f64::total_cmp);
            list.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
            list.into_iter().map(|w| (kind.to_owned(), w)).collect()
        };
        println!("{name}");
        let mut all = [of("folds", "fold"), of("period_doublings", "period-doubling")].concat();
        if depth != 0.0 {
            // The reference holds one end of the window of instability near speed 2. The other end is checked
            // by orbits on both of its sides.
            let window = branch.of_kind(PointKind::PeriodDoubling);
            let other = window[0].parameter;
            let stability = |speed: f64| {
                let model = model.with("speed", speed).unwrap();
                Shooting::new().solve(&model, window[0].orbit.states()).unwrap().stability()
            };
            let sides = [stability(other - 1e-5), stability(other + 1e-5)];
            assert_eq!(sides, [Stability::Stable, Stability::Unstable]);
            all.push(("period-doubling".into(), other));
        }
        compare(&branch, &all, 1e-10);
        if let Some(exact) = case["exact_grazing_W"].as_array() {
            for exact in exact {
                let exact = exact.as_f64().unwrap();
                let found = branch.of_kind(PointKind::Grazing);
                let nearest = found.iter().map(|p| (p.parameter - exact).abs()).fold(f64::INFINITY, f64::min);
                println!("grazing {exact} {nearest:.1e}");
                assert!(nearest < 1e-10);
            }
        }
    }
}

/// While the teeth stay in contact the pair is linear: the doubled orbits exist at the parameter of the
/// doubling alone, with any amplitude up to the contact loss.
#[test]
fn doubled_orbits_branch_off_at_a_period_doubling() {
    let model = oscillator(&[
        ("mesh stiffness", 0.8),
        ("stiffness variation", 0.5),
        ("mean force", 0.5),
        ("damping", 0.05),
    ]);
    let continuation = Continuation::new(2.4, 1.5).bounds(1.2, 2.6);
    let branch = follow(&model, &continuation.clone().both_ways());
    println!("{branch}");
    let family = Family::over(&model, ["speed"]).unwrap();
    let doublings = branch.of_kind(PointKind::PeriodDoubling);
    assert!(!doublings.is_empty());
    for point in doublings {
        let doubled = continuation.clone().max_points(30).run(&family, Switch::of_point(point)).unwrap();
        println!("{doubled}");
        let first = &doubled.points()[0];
        assert_eq!(first.orbit.period_multiple(), 2);
        assert!((first.parameter - point.parameter).abs() < 1e-10);
        assert!(doubled.of_kind(PointKind::Fold).is_empty());
        let state = &first.orbit.states()[0];
        let half = first.orbit.at(&model.with("speed", first.parameter).unwrap(), 0.5 * first.orbit.period());
        assert!((half.unwrap().q[0] - state.q[0]).abs() > 1e-3);
    }
}

/// With a cubic spring the amplitude of the half order grows like the root of the distance from the doubling.
#[test]
fn amplitude_of_doubled_orbits() {
    let given = [
        ("mesh stiffness", 0.8),
        ("stiffness variation", 0.5),
        ("mean force", 0.5),
        ("damping", 0.05),
        ("cubic stiffness", 0.3),
    ];
    let model = oscillator(&given);
    let family = Family::over(&model, ["speed"]).unwrap();
    let continuation = Continuation::new(3.4, 2.0);
    let single = follow(&model.with("speed", 3.4).unwrap(), &continuation);
    println!("{single}");
    let point = single.of_kind(PointKind::PeriodDoubling)[0];
    let doubled =
        continuation.clone().max_step(0.01).max_points(12).run(&family, Switch::of_point(point)).unwrap();
    println!("{doubled}");
    let share = |at: &BranchPoint| {
        let model = model.with("speed", at.parameter).unwrap();
        let half = at.orbit.at(&model, 0.5 * at.orbit.period()).unwrap().q[0] - at.orbit.states()[0].q[0];
        (at.parameter - point.parameter) / half.powi(2)
    };
    let shares: Vec<f64> = doubled.points()[..4].iter().map(share).collect();
    println!("{shares:?}");
    assert!(shares.iter().all(|s| (s / shares[0] - 1.0).abs() < 0.02));
}

/// Multipliers do not depend on the number of segments: they agree within the sum of their stated errors, and
/// the located points agree.
#[test]
fn multipliers_and_points_for_any_number_of_segments() {
    any_number_of_segments(&[1, 2, 5, 30]);
}

#[test]
#[ignore = "half a minute without optimisation: cargo test --release --test suite branches -- --ignored"]
fn multipliers_and_points_for_more_numbers_of_segments() {
    any_number_of_segments(&[16, 64]);
}

fn any_number_of_segments(numbers: &[usize]) {
    let model = oscillator(&[
        ("mesh stiffness", 1.0),
        ("mean force", 0.1),
        ("inertia force", 0.05),
        ("damping", 0.1),
    ]);
    let mut first: Option<Branch> = None;
    for &segments in numbers {
        let shooting = Shooting::new().segments(segments);
        let range = Continuation::new(0.6, 1.0).max_step(0.1).shooting(shooting);
        let branch = follow(&model, &range);
        assert_eq!(branch.points()[0].orbit.states().len(), segments);
        let first = first.get_or_insert_with(|| branch.clone());
        for (kind, point) in branch.located() {
            let other = first.of_kind(kind.kind());
            let near = other.iter().min_by(|a, b| {
                (a.parameter - point.parameter).abs().total_cmp(&(b.parameter - point.parameter).abs())
            });
            let near = near.unwrap();
            let apart = |k: usize| (near.multipliers.values()[k] - point.multipliers.values()[k]).norm();
            let (largest, bound) =
                (apart(0).max(apart(1)), near.multipliers.value_error() + point.multipliers.value_error());
            println!("{segments} {kind}: {:.1e} {largest:.1e} {bound:.1e}", near.parameter - point.parameter);
            assert!((near.parameter - point.parameter).abs() < 1e-11);
            assert!(largest <= bound + 1e-11, "{largest} {bound}");
        }
    }
}

/// A branch is stopped, stored, read and resumed: the points are those of one run.
#[test]
fn a_branch_is_stored_and_resumed() {
    let model = oscillator(&[
        ("mesh stiffness", 1.0),
        ("mean force", 0.1),
        ("inertia force", 0.05),
        ("damping", 0.1),
    ]);
    let family = Family::over(&model, ["speed"]).unwrap();
    let range = Continuation::new(0.5, 1.1).bounds(0.2, 1.2);
    let start = [State::new(0.0, &[1.1], &[0.0])];
    let whole = range.run(&family, &start).unwrap();
    let mut following = range.begin(&family, &start).unwrap();
    following.by_ref().take(30).for_each(drop);
    assert_eq!(following.line().points().len(), 30);
    let stored: Branch = stored(&following.into_line());
    let taken = stored.points().len();
    assert_eq!(stored.end(), &BranchEnd::Open);
    let rest = range.resume(&family, &stored).unwrap().finish();
    // The end of a finished branch is stored; an error as its text.
    let read: Branch = crate::common::stored(&rest);
    assert_eq!(read, rest);
    let coarse = range.clone().min_step(0.3).max_step(0.3).first_step(0.3).run(&family, &start).unwrap();
    let read: Branch = crate::common::stored(&coarse);
    assert!(
        matches!(read.end(), BranchEnd::Stored { .. }) && read.end().to_string() == coarse.end().to_string()
    );
    assert_eq!(rest.points()[0].arclength, stored.points()[taken - 1].arclength);
    let joined = stored.clone().joined(rest.clone()).unwrap();
    assert_eq!(joined.points().len(), taken + rest.points().len() - 1);
    assert_eq!(rest.clone().joined(stored.clone()), Err(BranchError::NotItsRest));
    let all: Vec<f64> = [stored.of_kind(PointKind::Fold), rest.of_kind(PointKind::Fold)]
        .concat()
        .iter()
        .map(|p| p.parameter)
        .collect();
    for (ours, theirs) in all.iter().zip(whole.of_kind(PointKind::Fold)) {
        assert!((ours - theirs.parameter).abs() < 1e-11);
    }
    assert_eq!(all.len(), 2);
    assert_eq!(rest.end(), &BranchEnd::Bound);
}

/// In both directions from the middle, the points are in order along the branch.
#[test]
fn both_ways() {
    let model = oscillator(&[
        ("cubic stiffness", 0.1),
        ("linear stiffness", 1.0),
        ("force", 0.18),
        ("damping", 0.05),
        ("half backlash", 9.0),
    ]);
    let family = Family::over(&model, ["speed"]).unwrap();
    let range = Continuation::new(1.0, 1.6).bounds(0.5, 1.6).both_ways();
    let branch = range.run(&family, &State::at_rest(1)).unwrap();
    let ends = [&branch.points()[0], &branch.points()[branch.points().len() - 1]];
    assert_eq!(ends.map(|point| point.parameter), [0.5, 1.6]);
    assert_eq!((branch.first_end(), branch.end()), (Some(&BranchEnd::Bound), &BranchEnd::Bound));
    assert!(branch.points().windows(2).all(|two| two[0].arclength < two[1].arclength));
    assert_eq!(branch.of_kind(PointKind::Fold).len(), 2);
    // The table has a row per point and the figures of the points.
    let table = branch.table().unwrap();
    assert_eq!(table.len(), branch.points().len());
    assert_eq!(table.column("peak-to-peak deflection").unwrap()[0], branch.points()[0].peak_to_peak());
    let codes: Vec<f64> = table.column("kind").unwrap().iter().copied().filter(|code| *code > 0.0).collect();
    assert_eq!(codes, [1.0, 1.0]);
    let (last, m) = (branch.points().len() - 1, branch.points().last().unwrap().multipliers.values()[1]);
    let parts =
        ["real", "imaginary"].map(|part| table.column(&format!("multiplier 1 {part}")).unwrap()[last]);
    assert_eq!(parts, [m.re, m.im]);
    assert_eq!(table.column("crossings upper 0").unwrap()[last], 0.0);
    assert!(branch.to_string().contains("fold"));
}

/// The symmetric orbits of a Duffing oscillator lose their symmetry at a branch point, onto which the
/// continuation switches in both directions.
#[test]
fn symmetry_breaking() {
    let model = oscillator(&[
        ("cubic stiffness", 1.0),
        ("linear stiffness", 1.0),
        ("force", 10.0),
        ("damping", 0.2),
        ("half backlash", 99.0),
    ]);
    let family = Family::over(&model, ["speed"]).unwrap();
    let range = Continuation::new(2.2, 1.0).bounds(0.9, 2.4);
    let start =
        Shooting::new().solve(&model.with("speed", 2.2).unwrap(), &State::new(0.0, &[2.8], &[0.0])).unwrap();
    let branch = range.run(&family, start.states()).unwrap();
    println!("{branch}");
    let point = branch.of_kind(PointKind::SymmetryBreaking)[0];
    let switch = Switch::of_point(point);
    for way in [switch.clone(), switch.reversed()] {
        let other = range.clone().max_points(6).run(&family, way).unwrap();
        let last = other.points().last().unwrap();
        assert!(last.summaries[0].mean.abs() > 1e-3);
        println!("{} mean {}", last.parameter, last.summaries[0].mean);
    }
    // At the crossing the equations determine the asymmetry to the root of their accuracy only.
    assert!(point.summaries[0].mean.abs() < 1e-6);
    let finer = range.clone().max_step(0.03).run(&family, start.states()).unwrap();
    let apart = finer.of_kind(PointKind::SymmetryBreaking)[0].parameter - point.parameter;
    println!("{apart:.1e}");
    assert!(apart.abs() < 1e-10);
}

/// Every refusal and every end by its name.
#[test]
fn refusals_and_ends() {
    let model = oscillator(&[
        ("cubic stiffness", 0.1),
        ("linear stiffness", 1.0),
        ("force", 0.18),
        ("damping", 0.05),
        ("half backlash", 9.0),
    ]);
    let family = Family::over(&model, ["speed"]).unwrap();
    let rest = [State::at_rest(1)];
    let refused = |range: Continuation| range.run(&family, &rest).unwrap_err();
    let out_of = |value, low, high| {
        BranchError::from(ParameterError::Bounds {
            name: "parameter of the continuation".into(),
            value,
            low,
            high,
        })
    };
    assert_eq!(refused(Continuation::new(1.0, 1.0)), out_of(1.0, 1.0, 1.0));
    let reversed = refused(Continuation::new(1.0, 1.2).bounds(2.0, 0.5));
    assert_eq!(reversed, out_of(1.0, 2.0, 0.5));
    assert_eq!(refused(Continuation::new(1.0, 1.2).bounds(1.1, 1.5)), out_of(1.0, 1.1, 1.5));
    assert!(matches!(refused(Continuation::new(f64::NAN, 1.2)), BranchError::Parameter(_)));
    assert!(matches!(refused(Continuation::new(1.0, 1.2).first_step(0.0)), BranchError::Parameter(_)));
    assert!(matches!(
        refused(Continuation::new(1.0, 1.2).channels(&["q6"])),
        BranchError::Parameter(ParameterError::NoSuchChannel { .. })
    ));
    let no_orbit =
        Continuation::new(1.0, 1.2).shooting(Shooting::new().max_iterations(1)).run(&family, &rest);
    assert!(matches!(no_orbit, Err(BranchError::Start(_))));
    // Ends: what was computed is kept.
    let range = Continuation::new(0.5, 1.6);
    let points = range.clone().max_points(7).run(&family, &rest).unwrap();
    assert_eq!((points.end(), points.points().len()), (&BranchEnd::Points { limit: 7 }, 7));
    let spent = range.clone().budget(Budget::new().steps(2000)).run(&family, &rest).unwrap();
    assert!(matches!(spent.end(), BranchEnd::Exhausted(Exhausted::Steps { limit: 2000 })));
    assert!(spent.points().len() > 3);
    let coarse = range.clone().min_step(0.3).max_step(0.3).first_step(0.3).run(&family, &rest).unwrap();
    assert!(matches!(coarse.end(), BranchEnd::StepUnderflow { .. }), "{}", coarse.end());
    assert!(matches!(refused(range.clone().min_step(0.1)), BranchError::Parameter(_)));
    assert!(matches!(refused(range.clone().max_points(0)), BranchError::Parameter(_)));
    let twice = refused(range.clone().channels(&["q0", "q0"]));
    assert!(matches!(twice, BranchError::Parameter(ParameterError::Twice { .. })));
    let elsewhere = Continuation::new(2.0, 3.0).resume(&family, &points).err();
    assert!(matches!(elsewhere, Some(BranchError::Parameter(ParameterError::Bounds { low: 2.0, .. }))));
    let stop = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(true));
    let cancelled = range.clone().budget(Budget::new().cancel(stop)).run(&family, &rest);
    assert!(matches!(cancelled, Err(BranchError::Curve(CurveError::Exhausted(Exhausted::Cancelled)))));
    // A family that fails beyond a parameter.
    let short = Family::of([("speed", "1")], |[speed]| {
        if speed > 0.8 {
            let (name, allowed) = ("speed".into(), "at most 0.8");
            return Err(ParameterError::OutOfRange { name, value: speed, allowed });
        }
        model.with("speed", speed)
    });
    let ended = range.run(&short, &rest).unwrap();
    assert!(matches!(ended.end(), BranchEnd::Model { parameter, .. } if *parameter > 0.8), "{}", ended.end());
    assert!((ended.points().last().unwrap().parameter - 0.8).abs() < 1e-6);
    // A start that is an orbit of another model; an orbit of other coordinates.
    let other = Family::of([("speed", "1")], |[speed]| model.with("speed", speed)?.with("force", 0.3));
    assert!(matches!(
        range.resume(&other, &points).err(),
        Some(BranchError::Curve(CurveError::NoSolution { .. }))
    ));
    let chain = Family::of([("speed", "1")], |[omega]| Ok(CubicChain { omega }));
    assert!(matches!(
        range.resume(&chain, &points).err(),
        Some(BranchError::Curve(CurveError::Model { .. }))
    ));
    // Switching where no branch crosses; resuming nothing.
    let fold = points.points()[0].clone();
    assert!(matches!(range.run(&family, Switch::of_point(&fold)), Err(BranchError::Kind { kind: None, .. })));
    // A switch goes one way.
    let both = range.clone().both_ways().run(&family, Switch::of_point(&fold));
    let unread = BranchError::Parameter(ParameterError::Unread {
        name: "both_ways",
        by: "a start that goes one way (Switch, Beyond)",
    });
    assert_eq!(both.unwrap_err(), unread);
    let twice = Family::over(&model, ["speed", "speed"]);
    assert!(matches!(twice.err(), Some(ParameterError::Twice { .. })));
    let plane = Family::over(&model, ["speed", "force"]).unwrap();
    assert!(matches!(
        Continuation::new(0.18, 0.2).run(&plane, &fold),
        Err(BranchError::Kind { kind: None, .. })
    ));
    let orbit = Shooting::new().solve(&CubicChain { omega: 1.0 }, &State::at_rest(2)).unwrap();
    let none = Sensitivity::of(&CubicChain { omega: 1.0 }, &orbit, &["q0"]);
    assert!(matches!(none, Err(BranchError::Parameter(ParameterError::NoConstants))));
}

/// Folds and period doublings of an idler train with two meshes.
#[test]
fn idler_of_the_classics() {
    let file = read("classic_orbits.json");
    let case = &file["multi_dof"]["idler_inphase"];
    let family = Family::of([("speed", "1")], |[omega]| Ok(Idler { omega, phase: 0.0 }));
    let start = [State::new(0.0, &[1.1, 1.12], &[0.0; 2])];
    let branch = Continuation::new(0.5, 2.4).max_step(0.1).run(&family, &start).unwrap();
    let of = |key: &str, kind: &str| -> Vec<(String, f64)> {
        let mut list: Vec<f64> =
            case[key].as_array().unwrap().iter().map(|point| point["W"].as_f64().unwrap()).collect();
        list.sort_by(f64::total_cmp);
        list.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        list.into_iter().map(|w| (kind.to_owned(), w)).collect()
    };
    let mut all = [of("folds", "fold"), of("period_doublings", "period-doubling")].concat();
    // The reference holds one end of the window at 0.92 twice. Orbits on both sides show the other end.
    let near = |point: &&BranchPoint| (point.parameter - 0.93).abs() < 1e-3;
    let other = branch.of_kind(PointKind::PeriodDoubling).into_iter().find(near).unwrap();
    let beyond = |omega: f64| {
        let orbit = Shooting::new().solve_from(&Idler { omega, phase: 0.0 }, &other.orbit).unwrap();
        orbit.multipliers().values().iter().any(|m| m.im == 0.0 && m.re < -1.0)
    };
    assert_ne!(beyond(other.parameter - 1e-5), beyond(other.parameter + 1e-5));
    all.push(("period-doubling".into(), other.parameter));
    compare(&branch, &all, 1e-9);
}

/// Two bodies in inertial coordinates turn as a whole: their branch is that of the relative coordinate.
#[test]
fn trains_in_inertial_coordinates() {
    use gear_dynamics::excitation::Fourier;
    use gear_dynamics::trains::{Body, Coordinates, MeshPart, Parts};
    let follow = |coordinates| {
        let mut parts = Parts::new();
        parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(5e-3));
        let stiffness = gear_dynamics::Wave::new(Fourier::new(3e8, &[[6e7, 0.0]]).unwrap());
        let mesh = MeshPart::external([20, 50], [0.02, 0.05], stiffness).damping(1500.0).half_backlash(4e-5);
        parts.mesh("mesh", "pinion", "wheel", mesh);
        parts.torque("drive torque", "pinion", 20.0).torque("load torque", "wheel", -50.0);
        let train = parts.coordinates(coordinates).build("pinion", 400.0).unwrap();
        let static_state = gear_dynamics::linear::static_state(&train, 0.0).unwrap();
        let start = static_state.state;
        let family = Family::over(&train, ["speed"]).unwrap();
        Continuation::new(400.0, 900.0).run(&family, &[start]).unwrap()
    };
    let [relative, inertial] = [Coordinates::Relative, Coordinates::Inertial].map(follow);
    println!("{inertial}");
    assert!(inertial.notes().is_empty() && inertial.end() == &BranchEnd::Bound);
    let pairs = relative.located().zip(inertial.located());
    for ((kind, a), (other, b)) in pairs {
        assert_eq!(kind.kind(), other.kind());
        assert!((a.parameter / b.parameter - 1.0).abs() < 1e-11, "{} {}", a.parameter, b.parameter);
    }
    assert_eq!((relative.located().count(), inertial.located().count()), (4, 4));
}

/// Without stability the folds and grazings are the same, and no doubling is located.
#[test]
fn stability_is_a_choice_of_its_own() {
    let model =
        oscillator(&[("mesh stiffness", 1.0), ("mean force", 0.25), ("force", 0.25), ("damping", 0.1)]);
    let family = Family::over(&model, ["speed"]).unwrap();
    let range = Continuation::new(2.5, 0.45);
    let follow = |range: Continuation| range.run(&family, &State::new(0.0, &[1.0], &[0.0])).unwrap();
    let with = follow(range.clone());
    let without = follow(range.stability(gear_dynamics::branches::StabilityMethod::Skipped));
    for kind in [PointKind::Fold, PointKind::Grazing] {
        let [with, without] = [&with, &without].map(|branch| branch.of_kind(kind));
        assert_eq!(with.len(), without.len(), "{kind}");
        for (a, b) in with.iter().zip(without) {
            assert!((a.parameter - b.parameter).abs() < 1e-11, "{kind}");
        }
    }
    assert!(
        !with.of_kind(PointKind::PeriodDoubling).is_empty()
            && without.of_kind(PointKind::PeriodDoubling).is_empty()
    );
    assert!(without.points().iter().all(|point| point.stability() == Stability::Undecided));
}

/// Towards the speed 0 the period grows without bound and the steps become short: the branch ends by its budget, or where
/// there is no model.
#[test]
fn a_speed_towards_zero_ends_within_its_budget() {
    let model = oscillator(&[
        ("mesh stiffness", 1.0),
        ("mean force", 0.1),
        ("damping", 0.1),
        ("stiffness variation", 0.2),
    ]);
    let family = Family::over(&model, ["speed"]).unwrap();
    let start = State::new(0.0, &[1.1], &[0.0]);
    for to in [0.0, 1e-6] {
        let range = Continuation::new(0.6, to).budget(Budget::new().steps(20_000));
        let branch = range.run(&family, &start).unwrap();
        println!("{branch}");
        let limit = BranchEnd::Exhausted(Exhausted::Steps { limit: 20_000 });
        assert!(branch.end() == &limit || matches!(branch.end(), BranchEnd::Model { .. }), "{branch}");
        assert!(branch.points().last().unwrap().parameter < 0.3);
    }
}

/// A family in two threads gives the points of one thread; what holds a family or a branch can be sent.
#[test]
fn threads_follow_one_family() {
    fn sent<T: Send + Sync>(of: T) -> T {
        of
    }
    let model = oscillator(&[("linear stiffness", 1.0), ("cubic stiffness", 0.1), ("force", 0.18)]);
    let family = sent(Family::over(&model, ["speed"]).unwrap());
    let of_closure = sent(Family::of([("speed", "rad/s")], |[speed]| model.with("speed", speed)));
    assert_eq!(of_closure.parameters()[0].name, "speed");
    let continuation = sent(Continuation::new(0.7, 0.9));
    let start = State::new(0.0, &[1.0], &[0.0]);
    let follow = || continuation.run(&family, std::slice::from_ref(&start)).unwrap();
    let (alone, [one, two]) = std::thread::scope(|scope| {
        let threads = [scope.spawn(follow), scope.spawn(follow)];
        (sent(follow()), threads.map(|thread| thread.join().unwrap()))
    });
    let parameters = |branch: &Branch| branch.points().iter().map(|p| p.parameter).collect::<Vec<f64>>();
    assert_eq!(parameters(&alone), parameters(&one));
    assert_eq!(parameters(&alone), parameters(&two));
    assert!((parameters(&alone).last().unwrap() - 0.9).abs() < 1e-12);
}
