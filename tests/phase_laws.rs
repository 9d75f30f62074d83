//! Phase laws: at constant speed the bare model, edges at the right phase, orders that stay sharp.

use gear_dynamics::*;

fn pair() -> NfgPair {
    NfgPair::new(&NfgParams { speed: 120.0, ..NfgParams::table1() }).unwrap()
}

#[test]
fn constant_speed_is_the_bare_model() {
    let (bare, start) = (pair(), pair().static_start().unwrap());
    let solver = Dop853::new().rtol(1e-11).atol(1e-17);
    let varying = Varying::new(bare.clone(), PhaseLaw::constant(bare.centre_frequency()).unwrap());
    let (a, b) = (solver.end(&bare, &start, 1000.0).unwrap(), solver.end(&varying, &start, 1000.0).unwrap());
    assert!((a.q[0] - b.q[0]).abs() < 1e-12, "{a:?} {b:?}");
}

/// A ring with a rectangular stiffness, speeding up: the phase of every edge is a phase at which the bare ring has one.
#[test]
fn edges_keep_their_phase() {
    let set = RingSet::a(4, 1000.0);
    let mut params = set.params().unwrap();
    let period = std::f64::consts::TAU / params.omega;
    let stiffness = shared(RectangularWave::new(1.5e8, 2.5e8, 0.4, period).unwrap());
    for mesh in &mut params.meshes {
        *mesh = Mesh::new(stiffness.clone(), mesh_error(params.omega), 1000.0, Backlash::new(2.65e-5).unwrap()).unwrap();
    }
    let ring = Ring::new(&params).unwrap();
    let law = PhaseLaw::ramp(params.omega, 2.0 * params.omega, 10.0 * period).unwrap();
    let run_up = Varying::new(ring, law.clone());
    let (mut t, mut u) = (0.0, vec![0.0; run_up.drives()]);
    for k in 0..12 {
        t = run_up.next_edge(t).unwrap();
        let turn = law.phase(t) / std::f64::consts::TAU;
        assert!((turn.fract() - if k % 2 == 0 { 0.2 } else { 0.8 }).abs() < 1e-8, "{k}: {turn}");
        run_up.drive(t, Side::Before, &mut u);
        let before = u[0];
        run_up.drive(t, Side::After, &mut u);
        assert_eq!((before, u[0]), if k % 2 == 0 { (2.5e8, 1.5e8) } else { (1.5e8, 2.5e8) }, "{k}");
    }
    let end = Dop853::new().rtol(1e-7).end(&run_up, &State::at_rest(9), 5.0 * period).unwrap();
    assert!(end.q.iter().all(|q| q.is_finite()));
}

fn mesh_error(omega: f64) -> Shared {
    shared(Fourier::new(0.0, &[[0.0, 1e-6]], omega).unwrap())
}

#[test]
fn phase_speed_and_time_belong_together() {
    let laws = [
        PhaseLaw::constant(3.0).unwrap(),
        PhaseLaw::ramp(5.0, 1.0, 2.0).unwrap(),
        PhaseLaw::fluctuation(4.0, 0.3, 7.0).unwrap(),
        PhaseLaw::table(&[0.0, 1.0, 1.5, 4.0], &[1.0, 3.0, 2.0, 6.0]).unwrap(),
    ];
    for law in &laws {
        assert_eq!(law.phase(0.0), 0.0);
        for k in 1..60 {
            let t = 0.1 * f64::from(k) + 0.013;
            let differences = (law.phase(t + 1e-6) - law.phase(t - 1e-6)) / 2e-6;
            assert!((law.speed(t) - differences).abs() < 1e-6, "{law:?} at {t}");
            assert!((law.time(law.phase(t)) - t).abs() < 1e-12 * t.max(1.0), "{law:?} at {t}");
        }
    }
}

/// On a run-up the mesh order of the static deflection stays one line of the waterfall.
#[test]
fn orders_stay_sharp_on_a_run_up() {
    let slow = NfgPair::new(&NfgParams { speed: 60.0, ..NfgParams::table1() }).unwrap();
    let (start, speed) = (slow.static_start().unwrap(), slow.centre_frequency());
    let end = 10.0 * slow.period();
    let run_up = Varying::new(slow, PhaseLaw::ramp(speed, 1.3 * speed, end).unwrap());
    let lines = Waterfall::new(2, 512).unwrap().run(&Dop853::new().rtol(1e-8).atol(1e-14), &run_up, &start, end, "deflection").unwrap();
    assert_eq!(lines.len(), 5);
    for (i, line) in lines.iter().enumerate().skip(1) {
        let mesh = line.order(63.0);
        assert!(mesh > 20.0 * line.order(55.0), "{i}: {mesh} {}", line.order(55.0));
        assert!(line.speed > lines[i - 1].speed);
    }
}

#[test]
fn bad_phase_laws() {
    assert!(matches!(PhaseLaw::constant(0.0), Err(ParameterError::NotPositive { .. })));
    assert!(matches!(PhaseLaw::ramp(1.0, f64::NAN, 1.0), Err(ParameterError::NotFinite { .. })));
    assert!(matches!(PhaseLaw::ramp(1.0, 2.0, 0.0), Err(ParameterError::NotPositive { .. })));
    assert!(matches!(PhaseLaw::fluctuation(1.0, 1.0, 1.0), Err(ParameterError::OutOfRange { .. })));
    assert!(matches!(PhaseLaw::table(&[], &[]), Err(ParameterError::Empty { .. })));
    assert!(matches!(PhaseLaw::table(&[0.0, 0.0], &[1.0, 1.0]), Err(ParameterError::NotPositive { .. })));
    assert!(matches!(PhaseLaw::table(&[1.0], &[1.0]), Err(ParameterError::OutOfRange { .. })));
    assert!(matches!(PhaseLaw::table(&[0.0], &[1.0, 2.0]), Err(ParameterError::Length { .. })));
    assert!(Waterfall::new(0, 8).is_err() && Waterfall::new(1, 2).is_err());
}
