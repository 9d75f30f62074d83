//! The types of this crate in all parts of the library.

use downstream::{Four, Heun, HeunStep, Kick, Knock, Marquardt, MeshedPair, Ros2, SoftStop, Straightforward};
use gear_dynamics::analysis::{ContactStatistics, Summary};
use gear_dynamics::branches::{BranchEnd, Continuation, Family};
use gear_dynamics::check::check_periodic;
use gear_dynamics::contact::{
    AsymmetricBacklash, ByDeflection, Contact, Damped, MixedLaw, Nonlinearity, Piece, PowerLaw,
    VaryingBacklash,
};
use gear_dynamics::drives::{Driven, Noisy, SpeedLaw, VaryingSpeed};
use gear_dynamics::excitation::{Fourier, RectangularWave, Scaled, Side};
use gear_dynamics::model::{Drives, Offers, from_fn};
use gear_dynamics::models::Oscillator;
use gear_dynamics::models::ring::{Frame, RingParams, RingSet};
use gear_dynamics::ode::{
    Adaptive, Finish, IntegrateError, Observer, OneStep, Probe, Rodas, Slope, Step, Stepped,
};
use gear_dynamics::periodic::{BalanceError, FlowMethod, FourierOrbit, Stability};
use gear_dynamics::processes::HeldProcess;
use gear_dynamics::roots::{Residual, Root, RootError, RootFinder};
use gear_dynamics::sweep::{
    Axis, ByPeriods, EnginePeriod, Ensemble, LaneRk4, Located, PeriodEngine, Point, PointError, Points,
    TableRk4,
};
use gear_dynamics::trains::SpurPair;
use gear_dynamics::{
    Backlash, Balance, Budget, Dop853, Harmonics, Integrator, Lyapunov, Machine, Mesh, Model, ParameterError,
    Periodic, Rattle, RattleState, Ring, Rk4, Rk45, Settle, Shape, Shooting, State, Statistics, Sweep, Wave,
};
use std::fmt::Debug;
use std::sync::{Arc, Mutex};

fn knock(stiffness: f64) -> Machine<Knock> {
    let shape = Knock { stop: SoftStop { touch: 0.4, loss: 0.3 }, kick: Wave::new(Kick) };
    Machine::of_constants(shape, &[("speed", 0.9), ("stiffness", stiffness)]).unwrap()
}

fn start() -> State {
    State::new(0.0, &[0.0, 0.0], &[0.0, 0.0])
}

/// A pair with the natural frequency 2e4 rad/s, the damping ratio 0.05 and a rectangular stiffness.
fn pair<N: Nonlinearity>(law: N) -> Machine<MeshedPair<N>> {
    let stiffness = Wave::new(RectangularWave::of_contact_ratio(1.5, 1.6e8, 2.4e8).unwrap());
    let error = Wave::new(Fourier::new(0.0, &[[0.0, 2e-6]]).unwrap());
    let shape = MeshedPair(Mesh::new(stiffness, error, law));
    Machine::of_constants(
        shape,
        &[("mesh frequency", 1.6e4), ("load", 500.0), ("damping", 1000.0), ("mass", 0.5)],
    )
    .unwrap()
}

fn rattling() -> Machine<MeshedPair<Backlash>> {
    pair(Backlash::new(2e-5).unwrap())
}

fn loaded() -> State {
    State::new(0.0, &[2.25e-5], &[0.0])
}

fn accurate() -> Dop853 {
    Dop853::new().rtol(1e-10).atol_each(&[1e-16, 1e-12])
}

/// The pair with any law, of which it knows the edges only.
#[test]
fn the_pair_takes_any_law() {
    fn check<N: Nonlinearity>(law: N) {
        let pair = pair(law);
        for q in [1e-6, 3e-5, -4e-5] {
            assert_eq!(check_periodic(&pair, &State::new(1e-5, &[q], &[0.02])), []);
        }
    }
    let gap = Backlash::new(2e-5).unwrap();
    check(gap);
    check(Damped::by_force(gap, 10.0).unwrap());
    check(PowerLaw::new(2e-5, 1.5, 1e-5).unwrap());
    check(VaryingBacklash::new(Wave::new(Fourier::new(2e-5, &[[2e-6, 0.0]]).unwrap())));
    // With edges on one side only the other edge is infinite.
    let stop = pair(AsymmetricBacklash::stop_above(2e-5).unwrap());
    let (one, two) = (
        accurate().end(&stop, &loaded(), 2e-3).unwrap(),
        accurate().end(&rattling(), &loaded(), 2e-3).unwrap(),
    );
    approx::assert_relative_eq!(one.q[0], two.q[0], max_relative = 1e-9); // the lower flank is never reached
    accurate().end(&pair(SoftStop { touch: 2e-5, loss: 10.0 }), &loaded(), 2e-3).unwrap();
}

/// Settling, harmonic balance and shooting give the same steady motion.
#[test]
fn the_pair_has_one_orbit() {
    let pair = rattling();
    let steady = Settle::new().tolerance(1e-9).run(&accurate(), &pair, &loaded()).unwrap();
    let mut rattle = Rattle::new(&pair);
    accurate().run(&pair, &steady.state, steady.state.t + pair.period(), &mut rattle).unwrap();
    assert_eq!((steady.period_multiple, rattle.contacts()[0].rattle_state()), (1, RattleState::Unilateral));

    let cycle = Shooting::new().solve(&pair, &steady.state).unwrap();
    let at = cycle.at(&pair, steady.state.t).unwrap();
    assert!((at.q[0] - steady.state.q[0]).abs() < 1e-8 * 3e-5, "{} {}", at.q[0], steady.state.q[0]);
    assert_eq!(cycle.multipliers().stability(), Stability::Stable);

    let balance = Balance::new(Harmonics::up_to(60));
    let guess = FourierOrbit::project(&accurate(), &pair, &steady.state, balance.harmonics()).unwrap();
    let orbit = balance.solve(&pair, &guess).unwrap();
    // Since the stiffness jumps, the coefficients of the series fall with the cube of the order.
    let apart = (orbit.at(at.t).q[0] - at.q[0]).abs();
    assert!(apart < 1e-4 * orbit.peak_to_peak(0), "{apart:e} of {:e}", orbit.peak_to_peak(0));
}

/// Speed and load in lanes over one drive table, with the bits of other lane widths and the results of the
/// other engines.
#[test]
fn the_pair_is_swept() {
    let pair = rattling();
    let axes = vec![
        Axis::linear("mesh frequency", 1.0e4, 2.2e4, 4).unwrap(),
        Axis::linear("load", 300.0, 700.0, 3).unwrap(),
    ];
    let names = ["deflection", "mesh force"];
    let sweep = Sweep::new(Points::grid(axes).unwrap()).settle(40).measure(2).channels(&names).rattle();
    let family = |p: &Point<'_>| pair.with("mesh frequency", p["mesh frequency"])?.with("load", p["load"]);
    let start = |_: &Point<'_>, _: &_| Ok::<_, ParameterError>(loaded());
    let lanes = sweep.of(&LaneRk4::new(256).lanes::<8>(), family).start(start).run().unwrap();
    let two = sweep.of(&LaneRk4::new(256).lanes::<2>(), family).start(start).run().unwrap();
    let table = sweep.of(&TableRk4::new(256), family).start(start).run().unwrap();
    let located = sweep.of(&Located(accurate()), family).start(start).run().unwrap();
    assert_eq!((lanes.alone(), lanes.errors().len()), (0, 0));
    assert_eq!(lanes.fingerprint(), two.fingerprint());
    for ((row, one), truth) in lanes.iter().zip(table.iter()).zip(located.iter()) {
        let [fast, one, exact] = [row, one, truth].map(|row| row.channel("mesh force").unwrap().max);
        approx::assert_relative_eq!(fast, one, max_relative = 1e-11);
        approx::assert_relative_eq!(fast, exact, max_relative = 5e-3); // steps extend over edges
        assert_eq!(row.contacts()[0].rattle_state(), truth.contacts()[0].rattle_state());
    }
}

/// A random load, a load as a function of time, a constant speed law, exact derivatives by constants, errors
/// by name.
#[test]
fn the_pair_is_wrapped() {
    let pair = rattling();
    let load = pair.slot("load").unwrap();
    let ensemble = Ensemble::new(8, 20.0 * pair.period(), 20).unwrap().channels(&["dynamic factor"]).rattle();
    let process = HeldProcess::of_values(1e-4, &[-100.0, 100.0]).unwrap();
    let member = |member: u64| {
        Noisy::new(rattling())
            .add(&[(load, 1.0)], &process.clone().member(member))
            .map(|held| (held, loaded()))
    };
    let bands = ensemble.run(&accurate(), member).unwrap();
    assert_eq!(bands.at("dynamic factor", 20).unwrap().count(), 8);

    let end = 10.0 * pair.period();
    let stepped =
        Driven::new(pair.clone()).add(load, |t| if t < 1e-3 { 0.0 } else { 500.0 }, &[1e-3]).unwrap();
    let until = accurate().end(&stepped, &loaded(), end).unwrap();
    let before = accurate().end(&pair, &loaded(), 1e-3).unwrap();
    let after = accurate().end(&pair.with("load", 1000.0).unwrap(), &before, end).unwrap();
    approx::assert_relative_eq!(until.q[0], after.q[0], max_relative = 1e-6);

    let steady = VaryingSpeed::new(pair.clone(), SpeedLaw::constant(1.6e4).unwrap());
    let (a, b) =
        (accurate().end(&steady, &loaded(), end).unwrap(), accurate().end(&pair, &loaded(), end).unwrap());
    approx::assert_relative_eq!(a.q[0], b.q[0], max_relative = 1e-6);

    let mut u = vec![0.0; pair.drives()];
    pair.drive(0.0, Side::After, &mut u);
    assert_eq!(pair.slope("load", &u, &[3e-5], &[0.0]).unwrap(), [2.0]);
    assert!(matches!(pair.with("lode", 1.0), Err(ParameterError::NoSuchConstant { .. })));
}

#[test]
fn the_model_is_consistent() {
    for q in [[0.1, 0.0], [0.9, 0.1]] {
        assert_eq!(check_periodic(&knock(1.0), &State::new(0.7, &q, &[0.3, -0.2])), []);
    }
}

#[test]
fn every_solver_agrees() {
    let truth = Dop853::new().rtol(1e-12).atol(1e-14).end(&knock(1.0), &start(), 50.0).unwrap();
    let error = |state: State| (state.q[0] - truth.q[0]).abs();
    assert!(error(Rk45::new().rtol(1e-10).end(&knock(1.0), &start(), 50.0).unwrap()) < 1e-7);
    assert!(error(Rk4::new(0.01).end(&knock(1.0), &start(), 50.0).unwrap()) < 1e-7);
    // The error of Heun's method falls with its order 2: by a factor of 16 for a quarter of the step.
    let ratio = error(Heun(0.004).end(&knock(1.0), &start(), 50.0).unwrap())
        / error(Heun(0.001).end(&knock(1.0), &start(), 50.0).unwrap());
    assert!((8.0..32.0).contains(&ratio), "{ratio}");
}

/// Every solver gives the same channels, with those of the model.
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
    assert_eq!(names, ["q0", "q1", "v0", "v1", "deflection", "mesh force", "contact", "power of the kick"]);
}

#[test]
fn settling_rattle_and_sections() {
    fn steady<I: Integrator>(solver: &I) -> (usize, RattleState, u64) {
        let model = knock(1.0);
        let steady = Settle::new().tolerance(1e-6).run(solver, &model, &start()).unwrap();
        let mut rattle = Rattle::new(&model);
        solver.run(&model, &steady.state, steady.state.t + 4.0 * model.period(), &mut rattle).unwrap();
        (steady.period_multiple, rattle.contacts()[0].rattle_state(), rattle.contacts()[0].impact_count())
    }
    let ours = steady(&Dop853::new());
    assert_eq!(ours, steady(&Heun(0.002)));
    assert_eq!(ours.1, RattleState::Unilateral);
    assert_eq!(Heun(0.01).sample(&knock(1.0), &start(), &[0.5, 1.0]).unwrap().len(), 2);
}

/// The algebra on four runs at once gives the bits of four single runs.
#[test]
fn lanes_of_ones_own() {
    let models = [0.8, 1.0, 1.2, 1.4].map(knock);
    let (mut u, mut a) = ([Four::from(0.0); 4], [Four::from(0.0); 2]);
    for (lane, model) in models.iter().enumerate() {
        assert!(model.shares_lanes_with(&models[0]));
        let mut one = [0.0; 4];
        model.drive(0.3, Side::After, &mut one);
        u.iter_mut().zip(one).for_each(|(u, one)| u.0[lane] = one);
    }
    let (q, v) = ([Four([0.1, 0.5, 0.9, 1.3]), Four::from(0.05)], [Four::from(0.2), Four::from(-0.1)]);
    models[0].shape().accel(&ByDeflection, Drives::new(1, &u), &q, &v, &mut a);
    for (lane, model) in models.iter().enumerate() {
        let pick = |x: &[Four]| x.iter().map(|x| x.0[lane]).collect::<Vec<_>>();
        let mut single = [0.0; 2];
        model.accel(&pick(&u), &pick(&q), &pick(&v), &mut single);
        assert_eq!(single[..], pick(&a));
    }
}

/// A law and an excitation of this crate in the ring of the library.
#[test]
fn in_the_ring() {
    let preset = RingSet { motor_torque: 8.0, ..RingSet::set_a(4, 1000.0) }.params().unwrap();
    let law = |i: usize| {
        if i == 2 {
            MixedLaw::Other(SoftStop { touch: 1e-5, loss: 10.0 })
        } else {
            MixedLaw::Backlash(*preset.meshes[i].law())
        }
    };
    let kick = Wave::new(Scaled::new(1e-6, Wave::new(Kick)).unwrap());
    let stiffness = Wave::constant(2e8).unwrap();
    let meshes = (0..4).map(|i| Mesh::new(stiffness.clone(), kick.clone(), law(i))).collect();
    let (motor, gears, omega) = (preset.motor, preset.gears.clone(), preset.omega);
    let params =
        RingParams { motor, gears, meshes, mesh_damping: vec![1000.0; 4], omega, teeth: preset.teeth };
    let ring = Ring::of_laws(&params, Frame::Rigid).unwrap();
    assert_eq!(ring.next_edge(0.0), Some(ring.period()));
    let run = |rtol: f64| {
        let solver =
            Dop853::new().rtol(rtol).atol_each(&[vec![1e-6 * rtol; 9], vec![1e-2 * rtol; 9]].concat());
        solver.end(&ring, &State::at_rest(9), 0.01).unwrap()
    };
    let (a, b) = (run(1e-9), run(1e-11));
    let size = b.v.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    assert!(a.v.iter().zip(&b.v).all(|(a, b)| (a - b).abs() < 1e-6 * size));
}

/// A balance by a root finder of this crate is that of Newton's method, and its failure is one of the balance.
#[test]
fn a_balance_takes_any_root_finder() {
    let given = [
        ("speed", 1.7),
        ("damping", 0.2),
        ("mesh stiffness", 1.0),
        ("mean force", 0.5),
        ("force", 0.2),
        ("cubic stiffness", 0.3),
        ("half backlash", 0.2),
    ];
    let pair = Oscillator::new(&given).unwrap();
    let balance = Balance::new(Harmonics::up_to(12));
    let by_newton = balance.solve(&pair, None).unwrap();
    let by_marquardt =
        balance.clone().root_finder(Marquardt { tolerance: 1e-10 }).solve(&pair, None).unwrap();
    assert!(by_newton.distance(&by_marquardt) < 1e-8, "{}", by_newton.distance(&by_marquardt));
    assert!(by_marquardt.residual() < 1e-8, "{}", by_marquardt.residual());
    let spent = balance.root_finder(Marquardt { tolerance: 1e-10 }).budget(Budget::new().steps(1));
    assert!(matches!(spent.solve(&pair, None), Err(BalanceError::Exhausted { .. })));
}

/// What a root finder returns is checked: the guess as a root, NaN, too few and too many unknowns.
#[test]
fn what_is_not_a_root_is_refused() {
    #[derive(Clone, Copy, Debug)]
    enum Careless {
        Guess,
        NotANumber,
        Short,
        Long,
        ShortError,
    }
    impl RootFinder for Careless {
        fn solve(&self, equations: &mut dyn Residual, guess: &[f64]) -> Result<Root, RootError> {
            let mut r = vec![0.0; equations.size()];
            let mut root = Root::start(equations, guess, &mut r)?;
            match self {
                Careless::Guess => root.residual = 0.0,
                Careless::NotANumber => root.x.fill(f64::NAN),
                Careless::Short => root.x.clear(),
                Careless::Long => root.x.push(7.0),
                Careless::ShortError => {
                    root.x.clear();
                    return Err(RootError::NotConverged { last: Box::new(root) });
                }
            }
            Ok(root)
        }
    }
    let pair = SpurPair::of_numbers(0.05, 0.1, &[0.2], &[0.05]).unwrap();
    let pair = pair.parts().unwrap().build("driver", 1.1).unwrap();
    let by = |finder: Careless| {
        let error = Balance::new(Harmonics::up_to(40)).root_finder(finder).solve(&pair, None).unwrap_err();
        format!("{error:?} {error}")
    };
    assert!(by(Careless::Guess).starts_with("NotConverged"), "{}", by(Careless::Guess));
    assert!(by(Careless::NotANumber).starts_with("NotFinite"), "{}", by(Careless::NotANumber));
    for finder in [Careless::Short, Careless::Long, Careless::ShortError] {
        assert!(by(finder).contains("unknowns of the root finder"), "{}", by(finder));
    }
}

/// A run that ends elsewhere, or in a state that is none of the model, is refused by all that call a solver.
#[test]
fn runs_that_end_elsewhere_are_refused() {
    /// Steps of 0.3, the last one too; or an end without coordinates, with too many, or with NaN.
    #[derive(Clone, Copy, Debug)]
    enum Careless {
        Beyond,
        Early,
        Empty,
        Long,
        NotANumber,
    }
    impl Integrator for Careless {
        fn run(
            &self,
            model: &dyn Model,
            start: &State,
            t_end: f64,
            observer: &mut dyn Observer,
        ) -> Result<Finish, IntegrateError> {
            let span = t_end - start.t;
            let t_end = match self {
                Careless::Beyond => start.t + 0.3 * (span / 0.3).ceil(),
                Careless::Early => start.t + 0.5 * span,
                _ => t_end,
            };
            let mut finish =
                Dop853::new().run(model, start, t_end, &mut |step: &mut Step<'_>| observer.step(step))?;
            match self {
                Careless::Empty => (finish.state.q, finish.state.v) = (Vec::new(), Vec::new()),
                Careless::Long => finish.state.q.push(0.0),
                Careless::NotANumber => finish.state.v[0] = f64::NAN,
                Careless::Beyond | Careless::Early => {}
            }
            Ok(finish)
        }
    }
    let model = from_fn(1, |t, q, v, a| a[0] = (2.0 * t).cos() - 0.1 * v[0] - q[0]).unwrap();
    let model = model.with_period(std::f64::consts::PI).unwrap();
    let rest = State::at_rest(1);
    for solver in [Careless::Beyond, Careless::Early, Careless::Empty, Careless::Long, Careless::NotANumber] {
        let errors = [
            solver.end(&model, &rest, 1.0).unwrap_err().to_string(),
            solver.sample(&model, &rest, &[0.5, 1.0]).unwrap_err().to_string(),
            solver.trajectory(&model, &rest, 1.0).unwrap_err().to_string(),
            Settle::new().run(&solver, &model, &rest).unwrap_err().to_string(),
            Shooting::new().integrator(solver).solve(&model, &rest).unwrap_err().to_string(),
            Lyapunov::new().integrator(solver).run(&model, &rest).unwrap_err().to_string(),
        ];
        let says = match solver {
            Careless::Beyond | Careless::Early => "time at which the integrator ends is ",
            Careless::Empty | Careless::Long => "coordinates of the state in which the integrator ends",
            Careless::NotANumber => "of (coordinates, velocities) exceeds 1e100, or its derivative",
        };
        for error in errors {
            assert!(error.contains(says), "{solver:?}: {error}");
        }
    }
}

/// Orbits, branches and exponents by an integrator and by steps of this crate: the error falls with the order 2.
#[test]
fn an_integrator_makes_orbits_branches_and_exponents() {
    orbits_branches_and_exponents(Heun);
}

#[test]
fn a_rosenbrock_step_of_ones_own_makes_orbits_branches_and_exponents() {
    orbits_branches_and_exponents(|h| Stepped::new(Ros2, h));
}

fn orbits_branches_and_exponents<I: Integrator + Clone + Debug + Send + Sync + 'static>(
    solver: impl Fn(f64) -> I,
) {
    let given = [
        ("speed", 0.7),
        ("damping", 0.2),
        ("mesh stiffness", 1.0),
        ("mean force", 0.1),
        ("force", 0.3),
        ("cubic stiffness", 0.3),
        ("half backlash", 0.2),
    ];
    let pair = Oscillator::new(&given).unwrap();
    let rest = State::new(0.0, &[0.3], &[0.0]);
    let steady = Settle::new().run(&Dop853::new(), &pair, &rest).unwrap().state;
    let shooting = Shooting::new();
    let exact = shooting.solve(&pair, &steady).unwrap();
    assert!(exact.crossing_count() > 0);
    let by = |h: f64| {
        let orbit = shooting.clone().integrator(solver(h)).solve(&pair, &steady).unwrap();
        assert_eq!(orbit.flow_method(), FlowMethod::Own);
        let again = shooting.clone().integrator(solver(h)).flow_method(FlowMethod::Own).solve(&pair, &steady);
        assert_eq!(again.unwrap().states(), orbit.states());
        let [a, b] = [&orbit, &exact].map(|orbit| orbit.states()[0].clone());
        let state = (a.q[0] - b.q[0]).hypot(a.v[0] - b.v[0]);
        let multiplier = (orbit.multipliers().largest() - exact.multipliers().largest()).abs();
        // The stated error is the distance from DOP853 on the same states.
        assert!(
            orbit.multipliers().value_error() > 1e-7 && multiplier < 10.0 * orbit.multipliers().value_error()
        );
        [state, multiplier]
    };
    let [coarse, fine] = [by(0.008), by(0.002)];
    for (coarse, fine) in coarse.into_iter().zip(fine) {
        assert!((4.0..64.0).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
    }
    assert!(fine[0] < 1e-4 && fine[1] < 1e-3, "{fine:?}");

    let family = Family::over(&pair, ["speed"]).unwrap();
    let along = |shooting: Shooting| {
        let branch = Continuation::new(0.7, 0.75).shooting(shooting).run(&family, &steady).unwrap();
        assert_eq!(branch.end(), &BranchEnd::Bound);
        branch.points().last().unwrap().peak_to_peak()
    };
    let [a, b] = [shooting.clone(), shooting.integrator(solver(0.002))].map(along);
    approx::assert_relative_eq!(a, b, max_relative = 1e-4);

    let exponents = Lyapunov::new().count(1).measure(40);
    let a = exponents.run(&pair, &steady).unwrap();
    let b = exponents.integrator(solver(0.002)).run(&pair, &steady).unwrap();
    assert_eq!(b.flow_method(), FlowMethod::Own);
    approx::assert_relative_eq!(a.values()[0], b.values()[0], max_relative = 1e-2);
}

/// An integrator that counts the time it is asked for.
#[derive(Clone, Debug)]
struct Counting(Rk4, Arc<Mutex<f64>>);

impl Integrator for Counting {
    fn run(
        &self,
        model: &dyn Model,
        start: &State,
        t_end: f64,
        observer: &mut dyn Observer,
    ) -> Result<Finish, IntegrateError> {
        *self.1.lock().unwrap() += t_end - start.t;
        self.0.run(model, start, t_end, observer)
    }
}

/// A stiff model is left to its integrator from the first period on.
#[test]
fn exponents_settle_by_the_integrator_that_is_set() {
    let (model, asked) = (knock(1.0), Arc::new(Mutex::new(0.0)));
    let exponents = Lyapunov::new().align(5).measure(20).integrator(Counting(Rk4::new(0.01), asked.clone()));
    let times = [0, 100].map(|settle| {
        *asked.lock().unwrap() = 0.0;
        exponents.clone().settle(settle).run(&model, &start()).unwrap();
        *asked.lock().unwrap()
    });
    assert!(times[1] - times[0] > 98.5 * model.period(), "{times:?}");
}

/// The largest error of a solver over the knocking pair of this crate, and the number of its crossings.
fn error_and_crossings(solver: &dyn Integrator) -> (f64, u64) {
    let (model, times) = (knock(1.0), [5.0, 10.0, 15.0, 20.0]);
    let exact = Dop853::new().rtol(1e-11).atol(1e-13).sample(&model, &start(), &times).unwrap();
    let found = solver.sample(&model, &start(), &times).unwrap();
    let worst = (0..times.len()).map(|k| (found.q(k)[0] - exact.q(k)[0]).abs()).fold(0.0, f64::max);
    (worst, found.stats().crossings)
}

/// The crate locates the edges for a step of one's own: its error has order 2, and no crossing is lost.
#[test]
fn steps_of_ones_own_have_located_edges() {
    let (_, crossings) = error_and_crossings(&Dop853::new());
    assert!(crossings > 0);
    let heun = [0.016, 0.004].map(|h| error_and_crossings(&Stepped::new(HeunStep, h)));
    let ros2 = [0.016, 0.004].map(|h| error_and_crossings(&Stepped::new(Ros2, h)));
    for [(coarse, of_coarse), (fine, of_fine)] in [heun, ros2] {
        assert!((8.0..32.0).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
        assert_eq!((of_coarse, of_fine), (crossings, crossings));
    }
    // By the estimate: the error follows the tolerance.
    let [loose, tight] = [1e-4, 1e-7]
        .map(|rtol| error_and_crossings(&Adaptive::of_steps(Ros2).rtol(rtol).atol(rtol * 1e-2)).0);
    assert!(tight < 1e-2 * loose && loose < 1e-2, "{loose:e} {tight:e}");
    let error = Adaptive::of_steps(HeunStep).end(&knock(1.0), &start(), 1.0).unwrap_err();
    assert_eq!(error.to_string(), "estimate_order is 0: at least 1 are needed");
}

/// q'' = -g above a rigid floor, e = 0.7: the closed form, by steps of Heun's method, which is exact for it.
#[test]
fn steps_of_ones_own_strike_rigid_stops() {
    struct Floor;
    impl Model for Floor {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = -9.81;
        }
        fn contacts(&self) -> usize {
            1
        }
        fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            out[0] = Contact {
                deflection: q[0],
                rate: v[0],
                lower: 0.0,
                upper: f64::INFINITY,
                ..Contact::default()
            };
        }
        fn impact(&self, _: usize, _: Piece, _: &[f64], _: &[f64], v: &mut [f64]) {
            v[0] *= -0.7;
        }
        fn offers(&self) -> Offers<'_> {
            Offers { stops: &[[true, false]], ..Offers::default() }
        }
    }
    let run = Stepped::new(HeunStep, 0.01).trajectory(&Floor, &State::new(0.0, &[1.0], &[0.0]), 1.0).unwrap();
    let fall = (2.0f64 / 9.81).sqrt();
    let (speed, since) = (0.7 * 9.81 * fall, 1.0 - fall);
    let exact = speed * since - 0.5 * 9.81 * since * since;
    assert_eq!(run.stats().crossings, 1);
    assert!((run.q(run.len() - 1)[0] - exact).abs() < 1e-9, "{}", run.q(run.len() - 1)[0] - exact);
    assert!(matches!(
        Stepped::new(HeunStep, 0.01).plain().end(&Floor, &State::new(0.0, &[1.0], &[0.0]), 1.0),
        Err(IntegrateError::StopNotLocated { contact: 0 })
    ));
}

/// A stiff model: 300 steps, where an explicit step of this length diverges and DOP853 takes 11 757.
#[test]
fn a_rosenbrock_step_of_ones_own_takes_a_stiff_model() {
    let model = from_fn(1, |t, q, v, a| a[0] = -1e8 * (q[0] - t.cos()) - 2e4 * v[0]).unwrap();
    let from = State::new(0.0, &[1.0], &[0.0]);
    let exact = Rodas::new().rtol(1e-10).atol(1e-12).end(&model, &from, 3.0).unwrap();
    let run = Stepped::new(Ros2, 0.01).trajectory(&model, &from, 3.0).unwrap();
    let off = (run.q(run.len() - 1)[0] - exact.q[0]).abs();
    assert_eq!(run.stats().steps, 300);
    assert!(off < 1e-4, "{off:e}"); // h²
    assert!(matches!(
        Stepped::new(HeunStep, 0.01).end(&model, &from, 3.0),
        Err(IntegrateError::NotFinite { .. })
    ));
}

/// A step that writes NaN, and one that asks f outside of its step, end with a typed error.
#[test]
fn faulty_steps_end_with_an_error() {
    struct Faulty(f64);
    impl OneStep for Faulty {
        fn step(&self, f: &mut Slope<'_>, end: &mut [f64], _: &mut [f64], _: &mut [f64]) {
            let from = f.start().to_vec();
            f.at(self.0, &from, end);
        }
    }
    /// Writes a part of its results.
    struct Partly(bool);
    impl OneStep for Partly {
        fn estimate_order(&self) -> u32 {
            1
        }
        fn step(&self, f: &mut Slope<'_>, end: &mut [f64], error: &mut [f64], _: &mut [f64]) {
            let written = if self.0 { end.len() } else { end.len() - 1 };
            end[..written].copy_from_slice(&f.start()[..written]);
            error[..end.len() - 1].fill(0.0);
        }
    }
    for solver in [
        Box::new(Stepped::new(Partly(false), 0.1)) as Box<dyn Integrator>,
        Box::new(Adaptive::of_steps(Partly(true))),
    ] {
        let error = solver.end(&knock(1.0), &start(), 1.0).unwrap_err();
        assert!(matches!(error, IntegrateError::NotFinite { .. }), "{error}");
    }
    for c in [-0.1, 1.1, f64::NAN] {
        let error = Stepped::new(Faulty(c), 0.1).end(&knock(1.0), &start(), 1.0).unwrap_err();
        assert!(matches!(error, IntegrateError::NotFinite { component: 0, .. }), "{error}");
    }
}

/// A sweep engine of this crate gives the rows of the library's, to the bit, with warm starts, early ends and threads.
#[test]
fn an_engine_of_ones_own_sweeps() {
    let speeds = || Axis::linear("stiffness", 0.8, 1.4, 6).unwrap();
    let sweep = || {
        Sweep::new(speeds())
            .settle(40)
            .measure(3)
            .repeat_tolerance(1e-6)
            .rattle()
            .channels(&["q0", "mesh force"])
    };
    let model = |p: &Point<'_>| Ok::<_, ParameterError>(knock(p["stiffness"]));
    let [ours, theirs] = [
        sweep().of(&ByPeriods(Straightforward(Dop853::new())), model).run().unwrap(),
        sweep().of(&Located(Dop853::new()), model).run().unwrap(),
    ];
    assert_eq!((ours.errors().len(), theirs.errors().len()), (0, 0), "{:?}", ours.errors());
    for i in 0..6 {
        let [a, b] = [&ours, &theirs].map(|rows| rows.get(i).unwrap());
        assert_eq!(a.channel("mesh force").unwrap(), b.channel("mesh force").unwrap(), "{i}");
        assert_eq!(a.period_multiple(), b.period_multiple());
        assert_eq!(a.contacts(), b.contacts());
    }
    assert_eq!(ours.fingerprint(), theirs.fingerprint());
}

/// An engine that reports too little, too much, another time or no number gives an error of the point.
#[test]
fn faulty_engines_are_refused() {
    struct Faulty(usize);
    impl PeriodEngine<Machine<Knock>> for Faulty {
        fn period(
            &self,
            _: &Machine<Knock>,
            state: &mut State,
            period: &mut EnginePeriod<'_>,
        ) -> Result<(), PointError> {
            state.t = period.end();
            let mut summary = Summary::of_figures(0.0, 0.0, [0.0, 0.0]).unwrap();
            match self.0 {
                0 => {}
                1 => period.channel(1, &summary),
                2 => state.t += 1.0,
                3 => {
                    period.channel(0, &summary);
                    period.contact(0, &ContactStatistics::default());
                    state.q[1] = f64::NAN;
                }
                4 => return Err(PointError::of_engine("the card is not there")),
                5 => {
                    summary.max = f64::NAN;
                    period.channel(0, &summary);
                }
                6 => {
                    summary.mean = 100.0;
                    period.channel(0, &summary);
                }
                7 => period.see(&[0.0; 3]),
                8 => period.see(&[f64::NAN; 4]),
                9 => state.q.push(0.0),
                _ => {
                    period.channel(0, &summary);
                    period.contact(0, &ContactStatistics::default());
                }
            }
            Ok(())
        }
    }
    let texts = [
        "channels that the engine reports has 0 entries: 1 are needed",
        "channel that the engine reports is 1.0: it must be 0",
        "time at which the engine ends a period is",
        "the motion becomes infinite or NaN in period 1",
        "the engine: the card is not there",
        "figures of channel 0",
        "mean of channel 0 is 100.0",
        "state that the engine shows has 3 entries: 4 are needed",
        "state that the engine shows is NaN",
        "coordinates of the state that the engine returns has 3 entries: 2 are needed",
        "sum of the times of contact 0 that the engine reports is 0.0",
    ];
    for (fault, text) in texts.into_iter().enumerate() {
        let axis = Axis::of_values("stiffness", &[1.0]).unwrap();
        let model = |p: &Point<'_>| Ok::<_, ParameterError>(knock(p["stiffness"]));
        let sweep = Sweep::new(axis).settle(0).measure(1).channels(&["q0"]);
        let sweep = if fault > 9 { sweep.rattle() } else { sweep };
        let rows = sweep.of(&ByPeriods(Faulty(fault)), model).run().unwrap();
        let error = rows.errors()[&0].to_string();
        assert!(error.contains(text), "{error}");
    }
}
