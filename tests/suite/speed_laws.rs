//! Speed laws: models at varying speed, drive edges at the right phase, sharp orders in a waterfall.

use crate::api::*;
use std::f64::consts::TAU;

fn pair() -> NfgPair {
    NfgPair::new(&NfgParams { speed: 120.0, ..NfgParams::table1() }).unwrap()
}

#[test]
fn constant_speed_is_the_bare_model() {
    let (bare, start) = (pair(), pair().on_drive_flank().unwrap());
    let solver = Dop853::new().rtol(1e-11).atol(1e-17);
    let varying = VaryingSpeed::new(bare.clone(), SpeedLaw::constant(bare.speed()).unwrap());
    let (a, b) = (solver.end(&bare, &start, 1000.0).unwrap(), solver.end(&varying, &start, 1000.0).unwrap());
    assert!((a.q[0] - b.q[0]).abs() < 1e-12, "{a:?} {b:?}");
}

/// A ring with a rectangular stiffness during a run-up: the phases of its drive edges are those of the ring
/// at constant speed.
#[test]
fn edges_keep_their_phase() {
    let set = RingSet::set_a(4, 1000.0);
    let mut params = set.params().unwrap();
    let period = std::f64::consts::TAU / params.omega;
    let stiffness = Wave::new(RectangularWave::new(1.5e8, 2.5e8, 0.4).unwrap());
    for mesh in &mut params.meshes {
        *mesh = Mesh::new(stiffness.clone(), mesh_error(), Backlash::new(2.65e-5).unwrap());
    }
    params.mesh_damping.fill(1000.0);
    let ring = Ring::new(&params).unwrap();
    let law = SpeedLaw::ramp(params.omega, 2.0 * params.omega, 10.0 * period).unwrap();
    let run_up = VaryingSpeed::new(ring, law.clone());
    let (mut t, mut u) = (0.0, vec![0.0; run_up.drives()]);
    for k in 0..12 {
        t = run_up.next_edge(t).unwrap();
        let turn = law.angle(t) / std::f64::consts::TAU;
        assert!((turn.fract() - if k % 2 == 0 { 0.2 } else { 0.8 }).abs() < 1e-8, "{k}: {turn}");
        run_up.drive(t, Side::Before, &mut u);
        let before = u[0];
        run_up.drive(t, Side::After, &mut u);
        assert_eq!((before, u[0]), if k % 2 == 0 { (2.5e8, 1.5e8) } else { (1.5e8, 2.5e8) }, "{k}");
    }
    // Two solvers whose steps end at these edges agree.
    let start = State::at_rest(9);
    let one = Dop853::new().rtol(1e-10).atol(1e-16).end(&run_up, &start, 5.0 * period).unwrap();
    let other = Rk45::new().rtol(1e-10).atol(1e-16).end(&run_up, &start, 5.0 * period).unwrap();
    let largest = one.q.iter().fold(0.0, |m: f64, q| m.max(q.abs()));
    assert!(
        largest > 1e-6 && one.q.iter().zip(&other.q).all(|(a, b)| (a - b).abs() < 1e-7 * largest),
        "{one:?} {other:?}"
    );
}

fn mesh_error() -> Wave {
    Wave::new(Fourier::new(0.0, &[[0.0, 1e-6]]).unwrap())
}

#[test]
fn phase_speed_and_time_belong_together() {
    let laws = [
        SpeedLaw::constant(3.0).unwrap(),
        SpeedLaw::ramp(5.0, 1.0, 2.0).unwrap(),
        SpeedLaw::fluctuation(4.0, 0.3, 7.0).unwrap(),
        SpeedLaw::table(&[0.0, 1.0, 1.5, 4.0], &[1.0, 3.0, 2.0, 6.0]).unwrap(),
    ];
    for law in &laws {
        assert_eq!(law.angle(0.0), 0.0);
        for k in 1..60 {
            let t = 0.1 * f64::from(k) + 0.013;
            let differences = (law.angle(t + 1e-6) - law.angle(t - 1e-6)) / 2e-6;
            assert!((law.speed(t) - differences).abs() < 1e-6, "{law:?} at {t}");
            assert!((law.time(law.angle(t)) - t).abs() < 1e-12 * t.max(1.0), "{law:?} at {t}");
        }
    }
}

/// Speed, amplitude of the mesh order and amplitude of order 55, window by window, on a ramp from one speed
/// to another within `turns` turns.
fn mesh_order(from: f64, to: f64, turns: f64) -> Vec<[f64; 3]> {
    let pair = NfgPair::new(&NfgParams { speed: from, ..NfgParams::table1() }).unwrap();
    let (start, end) = (pair.on_drive_flank().unwrap(), turns * pair.period());
    let law = SpeedLaw::ramp(pair.speed(), pair.speed() * to / from, end).unwrap();
    let solver = Dop853::new().rtol(1e-8).atol(1e-14);
    let lines = Waterfall::new(2, 512)
        .unwrap()
        .run(&solver, &VaryingSpeed::new(pair, law), &start, end, "deflection")
        .unwrap();
    lines.iter().map(|line| [line.speed, line.order(63.0), line.order(55.0)]).collect()
}

/// The mesh order stays one line while the speed changes by 6 % within a window, upwards or downwards;
/// samples at equal times would spread it over four orders. Far from resonance its amplitude depends on the
/// speed and on the torque that accelerates the gears. This torque loads the teeth on the run-up and relieves
/// them on the coast-down, in proportion to the acceleration.
#[test]
fn orders_stay_sharp_on_a_run_up_and_on_a_coast_down() {
    let (up, down) = (mesh_order(60.0, 78.0, 10.0), mesh_order(78.0, 60.0, 10.0));
    assert_eq!((up.len(), down.len()), (5, 4));
    assert!(
        up.windows(2).all(|two| two[0][0] < two[1][0]) && down.windows(2).all(|two| two[0][0] > two[1][0])
    );
    for [speed, mesh, beside] in up.iter().chain(&down) {
        // At constant speed the ratio is 3500.
        assert!(*mesh > 1000.0 * beside, "{speed}: {mesh} {beside}");
    }
    // Relative difference between both directions at equal speeds.
    let apart = |up: &[[f64; 3]], down: &[[f64; 3]]| {
        let at = |speed: f64| {
            let two = up.windows(2).find(|two| (two[0][0]..two[1][0]).contains(&speed))?;
            Some(two[0][1] + (two[1][1] - two[0][1]) * (speed - two[0][0]) / (two[1][0] - two[0][0]))
        };
        let shares: Vec<f64> =
            down.iter().filter_map(|[speed, mesh, _]| at(*speed).map(|up| mesh / up - 1.0)).collect();
        (shares.len(), shares.iter().sum::<f64>() / shares.len() as f64)
    };
    let (compared, fast) = apart(&up, &down);
    let (more, slow) = apart(&mesh_order(60.0, 78.0, 20.0), &mesh_order(78.0, 60.0, 20.0));
    println!("{fast:.2e} of {compared}, {slow:.2e} of {more}");
    assert!(compared == 3 && more >= 7 && fast.abs() < 3e-3);
    assert!((slow / fast - 0.5).abs() < 0.1, "{slow} {fast}");
}

#[test]
fn bad_speed_laws() {
    assert!(matches!(SpeedLaw::constant(0.0), Err(ParameterError::NotPositive { .. })));
    assert!(matches!(SpeedLaw::ramp(1.0, f64::NAN, 1.0), Err(ParameterError::NotFinite { .. })));
    assert!(matches!(SpeedLaw::ramp(1.0, 2.0, 0.0), Err(ParameterError::NotPositive { .. })));
    assert!(matches!(SpeedLaw::fluctuation(1.0, 1.0, 1.0), Err(ParameterError::OutOfRange { .. })));
    assert!(matches!(SpeedLaw::table(&[], &[]), Err(ParameterError::Empty { .. })));
    assert!(matches!(SpeedLaw::table(&[0.0, 0.0], &[1.0, 1.0]), Err(ParameterError::NotPositive { .. })));
    assert!(matches!(SpeedLaw::table(&[1.0], &[1.0]), Err(ParameterError::Wrong { .. })));
    assert!(matches!(SpeedLaw::table(&[0.0], &[1.0, 2.0]), Err(ParameterError::Length { .. })));
    assert!(Waterfall::new(0, 8).is_err() && Waterfall::new(1, 2).is_err());
}

/// At a phase of millions of radians rounding exceeds any fixed distance from an edge. Both sides of every
/// jump are still distinguished.
#[test]
fn jumping_drives_far_along_the_phase() {
    let set = RingSet { motor_torque: 8.0, ..RingSet::set_a(4, 3_000.0) };
    let mut params = set.params().unwrap();
    let wave = RectangularWave::new(1e8, 2e8, 0.5).unwrap();
    params.meshes = (0..4)
        .map(|_| Mesh::new(Wave::new(wave), Wave::constant(0.0).unwrap(), Backlash::new(2.65e-5).unwrap()))
        .collect();
    params.mesh_damping.fill(1000.0);
    let ring = Ring::new(&params).unwrap().with_frame(Frame::Rigid);
    let (speed, solver) = (TAU / ring.period(), Dop853::new());
    let run = |phase: f64| {
        let model = VaryingSpeed::new(ring.clone(), SpeedLaw::constant(speed).unwrap());
        let start = State { t: phase / speed, ..State::at_rest(9) };
        let end = start.t + 5.1 * ring.period();
        solver.run(&model, &start, end, &mut |_: &mut Step<'_>| std::ops::ControlFlow::Continue(())).unwrap()
    };
    let near = run(0.0);
    for turns in [1e3, 1e6, 1e8] {
        let far = run(TAU * turns);
        let off = (far.state.v[0] - near.state.v[0]).abs() / near.state.v[0].abs();
        println!("{turns} turns: {:?}, off by {off:.1e}", far.stats);
        assert_eq!(far.stats.drive_edges, near.stats.drive_edges);
        assert!(off < 1e-6 + 1e3 * f64::EPSILON * turns, "{off}");
    }
}
