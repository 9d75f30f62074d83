//! Inner kinks of contact laws in pairs, rings and trains: every method locates them, the analysis leaves them
//! out.

use crate::api::*;
use gear_dynamics::branches::{Continuation, Family};
use gear_dynamics::trains::{Body, MeshPart, Parts, Warning};
use std::ops::ControlFlow;

/// A model without contacts: solvers locate nothing.
struct Unlocated<'m>(&'m dyn Model);

impl Model for Unlocated<'_> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn drives(&self) -> usize {
        self.0.drives()
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.0.drive(t, side, u);
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.0.next_edge(t)
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.0.accel(u, q, v, a);
    }
}

/// Contact and instant of each crossing of a run, and its end.
fn located(
    solver: &impl Integrator,
    model: &dyn Model,
    start: &State,
    end: f64,
) -> (Vec<(usize, f64)>, State) {
    let mut seen = Vec::new();
    let mut watch = |step: &mut Step<'_>| {
        seen.extend(step.crossings().iter().map(|c| (c.contact, step.t1())));
        ControlFlow::Continue(())
    };
    let finish = solver.run(&model, start, end, &mut watch).unwrap();
    (seen, finish.state)
}

/// The same from a run with tiny steps that locates nothing: bisection on the dense output wherever a contact
/// stands on different pieces at the ends of a step.
fn sampled(model: &dyn Model, start: &State, end: f64, longest: f64) -> (Vec<(usize, f64)>, State) {
    let (mut seen, mut y) = (Vec::new(), vec![0.0; 2 * model.dof()]);
    let (mut u, mut contacts) = (vec![0.0; model.drives()], vec![Contact::default(); model.contacts()]);
    let mut watch = |step: &mut Step<'_>| {
        let mut pieces = |t: f64, step: &mut Step<'_>| -> Vec<Piece> {
            step.at(t, &mut y);
            let (q, v) = y.split_at(y.len() / 2);
            model.drive(t, Side::After, &mut u);
            model.contact(&u, q, v, &mut contacts);
            contacts.iter().map(Contact::piece).collect()
        };
        let (first, last) = (pieces(step.t0(), step), pieces(step.t1(), step));
        for i in (0..first.len()).filter(|&i| first[i] != last[i]) {
            let (mut lo, mut hi) = (step.t0(), step.t1());
            for _ in 0..45 {
                let middle = 0.5 * (lo + hi);
                if pieces(middle, step)[i] == first[i] { lo = middle } else { hi = middle }
            }
            seen.push((i, hi));
        }
        ControlFlow::Continue(())
    };
    let solver = Dop853::new().rtol(1e-13).atol(1e-16).max_step(longest);
    let finish = solver.run(&Unlocated(model), start, end, &mut watch).unwrap();
    (seen, finish.state)
}

/// Dop853, Rk45 and Taylor locate the crossings that a run with tiny steps passes, each kind at least `least`
/// times. `close`: allowed difference of an instant, as a share of the run.
fn agrees(model: &dyn Model, touching: usize, start: &State, end: f64, least: usize) {
    let (mut expected, last) = sampled(model, start, end, 1e-3 * end);
    expected.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let inner = expected.iter().filter(|(i, _)| *i >= touching).count();
    assert!(inner >= least && expected.len() - inner >= least, "{inner} of {}", expected.len());
    let size = last.q.iter().fold(0.0f64, |m, q| m.max(q.abs()));
    let compare = |name: &str, (mut found, end_state): (Vec<(usize, f64)>, State), close: f64| {
        found.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        assert_eq!(found.len(), expected.len(), "{name}: {found:?} {expected:?}");
        for (found, expected) in found.iter().zip(&expected) {
            assert!(
                found.0 == expected.0 && (found.1 - expected.1).abs() < close * end,
                "{found:?} {expected:?}"
            );
        }
        for (q, expected) in end_state.q.iter().zip(&last.q) {
            assert!((q - expected).abs() < 10.0 * close * size, "{name}: {q} {expected}");
        }
    };
    let atol = 1e-12 * size;
    compare("Dop853", located(&Dop853::new().rtol(1e-12).atol(atol), model, start, end), 1e-8);
    compare("Rk45", located(&Rk45::new().rtol(1e-9).atol(1e3 * atol), model, start, end), 1e-5);
    compare("Taylor", located(&Taylor::new(), model, start, end), 1e-8);
}

fn wave(mean: f64, amplitude: f64) -> Wave {
    Wave::new(Fourier::new(mean, &[[amplitude, 0.0]]).unwrap())
}

fn no_pull() -> NoPullBacklash {
    NoPullBacklash::new(2e-5, 1.5e-5).unwrap()
}

/// A wheel that drives two pinions, the second one with another law.
fn train() -> gear_dynamics::trains::Train<MixedLaw> {
    let mut parts = Parts::default();
    for (name, inertia) in [("wheel", 8e-3), ("left", 1e-3), ("right", 2e-3)] {
        parts.body(name, Body::new(inertia));
    }
    let mesh = |teeth: [u32; 2], law: MixedLaw| {
        let radii = teeth.map(|teeth| 1.5e-3 * f64::from(teeth));
        MeshPart::external(teeth, radii, wave(2e8, 3e7)).error(wave(0.0, 1e-5)).phase(0.0).law(law)
    };
    parts.mesh("plain", "wheel", "left", mesh([60, 20], MixedLaw::Backlash(Backlash::new(2e-5).unwrap())));
    parts.mesh("damped", "wheel", "right", mesh([60, 30], MixedLaw::NoPull(no_pull())));
    parts.torque("drive", "wheel", 30.0).torque("one", "left", -5.0).torque("other", "right", -7.5);
    parts.build_with_laws("wheel", 90.0).unwrap()
}

#[test]
fn a_train_of_two_laws_locates_all_kinks() {
    let train = train();
    assert_eq!((train.contacts(), train.offers().kinks), (4, 2));
    let names = Probe::new(&train).channels().iter().filter(|c| c.name.starts_with("deflection")).count();
    assert_eq!(names, 2);
    let start = State::at_rest(train.dof());
    agrees(&train, 2, &start, 5e-3, 10);
    let mut rattle = Rattle::new(&train);
    Dop853::new().run(&train, &start, 5e-3, &mut rattle).unwrap();
    assert_eq!(rattle.contacts().len(), 2);
}

#[test]
fn a_ring_locates_all_kinks() {
    let set = RingSet::set_a(4, 1000.0).params().unwrap();
    let mesh = |mesh: &Mesh| Mesh::new(mesh.stiffness().clone(), mesh.error().clone(), no_pull());
    let RingParams { motor, gears, meshes, omega, teeth, .. } = set;
    let meshes = meshes.iter().map(mesh).collect();
    let params = RingParams { motor, gears, meshes, mesh_damping: vec![0.0; 4], omega, teeth };
    let ring = Ring::of_laws(&params, Frame::Rigid).unwrap();
    assert_eq!((ring.contacts(), ring.offers().kinks), (12, 8));
    let mut start = State::at_rest(ring.dof());
    start.q[1] = 1e-3; // gear 1 presses on both its neighbours
    agrees(&ring, 4, &start, 1e-3, 10);
}

#[test]
fn face_gear_pairs_locate_all_kinks() {
    let params = NfgParams::table1();
    let mesh = || {
        let law = NoPullBacklash::new(params.half_backlash, 1e-5).unwrap();
        Mesh::new(wave(params.stiffness, 0.1 * params.stiffness).per_turn(63).unwrap(), wave(0.0, 1e-5), law)
    };
    for reading in [NfgReading::default(), NfgReading::exact()] {
        let pair = NfgPair::of_mesh(&params, reading, mesh()).unwrap();
        agrees(&pair, 1, &State::at_rest(1), 60.0, 6);
    }
    let pair = NfgPair2::of_mesh(&params, 0.01, NfgReading::exact(), mesh()).unwrap();
    agrees(&pair, 1, &State::at_rest(2), 0.01, 6);
}

/// Lanes with tiny steps, a run with located edges, shooting, and the harmonic balance of one motion: the pair of
/// `laws::inner_kinks_serve_flows_and_shooting`, forced by its transmission error.
#[test]
fn lanes_and_balance_of_a_pair_with_inner_kinks() {
    let law = NoPullBacklash::new(0.4, 0.15).unwrap();
    let mut parts = Parts::default();
    parts.body("driver", Body::new(2.0)).body("driven", Body::new(2.0));
    let part = MeshPart::external([1, 1], [1.0, 1.0], Wave::constant(6.0).unwrap()).law(law);
    parts.mesh("mesh", "driver", "driven", part.error(wave(0.0, 1.5 / 1.21)).damping(0.05));
    parts.torque("drive", "driver", 0.4).torque("load", "driven", -0.4).accept(Warning::UnusualValue);
    let pair = parts.build_with_laws("driver", 1.1).unwrap();
    let start = State::new(0.0, &[0.7 + 1.5 / 1.21], &[0.4]);
    let sweep = Sweep::new(Axis::of_values("load", &[0.4, 0.42]).unwrap());
    let sweep = sweep.settle(40).measure(2).channels(&["deflection"]).rattle();
    let family = |p: &Point<'_>| pair.with_all(&[("drive", p["load"]), ("load", -p["load"])]);
    let rest = |_: &Point<'_>, _: &_| Ok::<_, ParameterError>(start.clone());
    let lanes = sweep.of(&LaneRk4::new(1000).lanes::<2>(), family).start(rest).run().unwrap();
    let fine = sweep.of(&Located(Dop853::new().rtol(1e-10)), family).start(rest).run().unwrap();
    for (lanes, fine) in lanes.iter().zip(fine.iter()) {
        let [a, b] = [&lanes, &fine].map(|row| row.channel("deflection").unwrap());
        // Samples and kinks inside steps of 6e-3 give errors of some 1e-4.
        assert!((a.max - b.max).abs() < 1e-3 && (a.min - b.min).abs() < 1e-3, "{a:?} {b:?}");
        assert_eq!(lanes.contacts()[0].rattle_state(), fine.contacts()[0].rattle_state());
    }
    let settled = Dop853::new().rtol(1e-12).end(&pair, &start, 60.0 * pair.period()).unwrap();
    let orbit = Shooting::new().solve(&pair, &[State { t: 0.0, ..settled }]).unwrap();
    assert_eq!(orbit.crossing_count(), 12);
    let harmonics = Harmonics::up_to(40);
    let guess = FourierOrbit::project(&Dop853::new(), &pair, &orbit.states()[0], &harmonics).unwrap();
    let balanced = Balance::new(harmonics).solve(&pair, &guess).unwrap();
    let (found, expected) = (balanced.at(0.0).q[0], orbit.states()[0].q[0]);
    assert!((found - expected).abs() < 3e-5, "{found} {expected}");
    assert_eq!(balanced.contacts(&pair).unwrap().len(), 1);
}

/// A branch by balance measures the own channels of a model with inner kinks as a branch by shooting does.
#[test]
fn own_channels_along_a_branch_by_balance() {
    let params = NfgParams::table1();
    let law = NoPullBacklash::new(params.half_backlash, 1e-5).unwrap();
    let mesh = Mesh::new(Wave::constant(params.stiffness).unwrap(), Wave::constant(0.0).unwrap(), law);
    let pair = NfgPair::of_mesh(&params, NfgReading::default(), mesh).unwrap();
    let orbit = Shooting::new().solve(&pair, &[pair.on_drive_flank().unwrap()]).unwrap();
    let (start, harmonics) = (&orbit.states()[0], Harmonics::up_to(6));
    let guess = FourierOrbit::project(&Dop853::new(), &pair, start, &harmonics).unwrap();
    let family = Family::over(&pair, ["speed"]).unwrap();
    let range = Continuation::new(params.speed, 1.01 * params.speed).channels(&["base radius", "contact"]);
    let range = range.max_points(2);
    let balanced = range.clone().balance(Balance::new(harmonics)).run(&family, &guess).unwrap();
    let shot = range.run(&family, start).unwrap();
    let [a, b] = [balanced.points()[0].summaries[0], shot.points()[0].summaries[0]];
    let radius = b.mean;
    assert!(b.peak_to_peak() > 0.1 * radius && (a.mean - b.mean).abs() < 1e-12 * radius, "{a:?} {b:?}");
    // The extremes of a cosine from 64 samples and a parabola.
    assert!((a.max - b.max).abs() < 1e-5 * radius && (a.min - b.min).abs() < 1e-5 * radius, "{a:?} {b:?}");
    let touching = [balanced.points()[0].summaries[1].mean, shot.points()[0].summaries[1].mean];
    assert_eq!(touching, [1.0; 2]);
}
