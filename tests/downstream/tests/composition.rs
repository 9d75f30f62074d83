//! Everything that this crate defines runs through everything that the library offers.

use downstream::{Four, Heun, Kick, Knock, SoftStop};
use gear_dynamics::*;

fn knock(stiffness: f64) -> Knock {
    Knock { stop: SoftStop { touch: 0.4, loss: 0.3 }, kick: Kick { omega: 0.9 }, stiffness }
}

fn start() -> State {
    State::new(0.0, &[0.0, 0.0], &[0.0, 0.0])
}

#[test]
fn the_model_is_consistent() {
    for q in [[0.1, 0.0], [0.9, 0.1]] {
        assert_eq!(check_generic(&knock(1.0), &State::new(0.7, &q, &[0.3, -0.2])), []);
    }
}

#[test]
fn every_solver_agrees() {
    let truth = Dop853::new().rtol(1e-12).atol(1e-14).end(&knock(1.0), &start(), 50.0).unwrap();
    let error = |state: State| (state.q[0] - truth.q[0]).abs();
    assert!(error(Rk45::new().rtol(1e-10).end(&knock(1.0), &start(), 50.0).unwrap()) < 1e-7);
    assert!(error(Rk4::new(0.01).end(&knock(1.0), &start(), 50.0).unwrap()) < 1e-7);
    // A third-party method is as good as its order.
    let ratio = error(Heun(0.004).end(&knock(1.0), &start(), 50.0).unwrap()) / error(Heun(0.001).end(&knock(1.0), &start(), 50.0).unwrap());
    assert!((8.0..32.0).contains(&ratio), "{ratio}");
}

/// Channels come through every solver the same way, one's own among them.
#[test]
fn channels() {
    fn extremes<I: Integrator>(solver: &I) -> Summary {
        let model = knock(1.0);
        let mut statistics = Statistics::new(&model, &["power of the kick", "mesh force"]).unwrap();
        solver.run(&model, &start(), 40.0, &mut statistics).unwrap();
        statistics.summary("power of the kick").unwrap()
    }
    let (a, b) = (extremes(&Dop853::new()), extremes(&Heun(0.002)));
    approx::assert_relative_eq!(a.max, b.max, max_relative = 1e-3);
    approx::assert_relative_eq!(a.mean, b.mean, max_relative = 1e-2);
    let names: Vec<String> = Probe::new(&knock(1.0)).channels().iter().map(|c| c.name.clone()).collect();
    assert_eq!(names, ["q1", "q2", "v1", "v2", "deflection", "mesh force", "contact", "power of the kick"]);
}

#[test]
fn settling_rattle_and_sections() {
    fn steady<I: Integrator>(solver: &I) -> (usize, RattleState, u64) {
        let model = knock(1.0);
        let steady = Settle::new().tolerance(1e-6).run(solver, &model, &start()).unwrap();
        let mut rattle = Rattle::new(&model);
        solver.run(&model, &steady.state, steady.state.t + 4.0 * model.period(), &mut rattle).unwrap();
        (steady.period_multiple, rattle.contact(0).state(), rattle.contact(0).impact_count())
    }
    let ours = steady(&Dop853::new());
    assert_eq!(ours, steady(&Heun(0.002)));
    assert_eq!(ours.1, RattleState::Unilateral);
    assert_eq!(strobe(&Heun(0.01), &knock(1.0), &start(), 5).unwrap().len(), 5);
}

/// The algebra on four lanes at once gives the bits of four single runs.
#[test]
fn lanes_of_ones_own() {
    let models = [0.8, 1.0, 1.2, 1.4].map(knock);
    let (mut u, mut a) = ([Four::from(0.0); 2], [Four::from(0.0); 2]);
    for (lane, model) in models.iter().enumerate() {
        assert!(model.shares_lanes_with(&models[0]));
        let mut one = [0.0; 2];
        model.drive(0.3, Side::After, &mut one);
        u[0].0[lane] = one[0];
        u[1].0[lane] = one[1];
    }
    let (q, v) = ([Four([0.1, 0.5, 0.9, 1.3]), Four::from(0.05)], [Four::from(0.2), Four::from(-0.1)]);
    models[0].accel_on(&AsIs, &u, &q, &v, &mut a);
    for (lane, model) in models.iter().enumerate() {
        let pick = |x: &[Four; 2]| [x[0].0[lane], x[1].0[lane]];
        let mut single = [0.0; 2];
        model.accel(&pick(&u), &pick(&q), &pick(&v), &mut single);
        assert_eq!(single, pick(&a));
    }
}

/// Laws and excitations of one's own inside the library's ring.
#[test]
fn in_the_ring() {
    let preset = RingSet { motor_torque: 8.0, ..RingSet::a(4, 1000.0) }.params().unwrap();
    let law =
        |i: usize| if i == 2 { AnyLaw::Other(SoftStop { touch: 1e-5, loss: 10.0 }) } else { AnyLaw::Backlash(*preset.meshes[i].law()) };
    let kick = shared(Scaled::new(1e-6, shared(Kick { omega: preset.omega })).unwrap());
    let meshes = (0..4)
        .map(|i| {
            let stiffness = shared(Constant::new(2e8).unwrap());
            Mesh::new(stiffness, kick.clone(), 1000.0, law(i)).unwrap()
        })
        .collect();
    let params = RingParams { meshes, motor: preset.motor, gears: preset.gears.clone(), omega: preset.omega };
    let ring = Ring::new(&params).unwrap().in_frame(Frame::Rigid);
    assert_eq!(ring.next_edge(0.0), Some(ring.period()));
    let run = |rtol: f64| {
        let solver = Dop853::new().rtol(rtol).atol_each(&[vec![1e-6 * rtol; 9], vec![1e-2 * rtol; 9]].concat());
        solver.end(&ring, &State::at_rest(9), 0.01).unwrap()
    };
    let (a, b) = (run(1e-9), run(1e-11));
    let size = b.v.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    assert!(a.v.iter().zip(&b.v).all(|(a, b)| (a - b).abs() < 1e-6 * size));
}
