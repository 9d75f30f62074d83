//! No allocation in a step, an observer, a member, a variational equation or a residual: a run with ten times
//! the steps makes the same number of allocations.

use gear_dynamics::contact::{Contact, Piece};
use gear_dynamics::drives::Noisy;
use gear_dynamics::model::Offers;
use gear_dynamics::models::nfg::NfgPair2;
use gear_dynamics::models::ring::{Frame, RingSet};
use gear_dynamics::ode::{Rodas, Stats, Step};
use gear_dynamics::periodic::{FlowMethod, FourierOrbit, Integrals, Variation};
use gear_dynamics::processes::HeldProcess;
use gear_dynamics::roots::Residual;
use gear_dynamics::sweep::{Axis, Ensemble, LaneRk4, Point, Points, Rows};
use gear_dynamics::{
    Balance, Dop853, Harmonics, Integrator, Model, NfgPair, NfgParams, ParameterError, Periodic, Rattle,
    Ring, Rk4, Rk45, State, Statistics, Sweep, Taylor,
};
use std::ops::ControlFlow;

fn allocations(run: impl FnOnce()) -> u64 {
    allocation_counter::measure(run).count_total
}

fn steps_allocate_nothing<I: Integrator, M: Model>(
    name: &str,
    solver: &I,
    model: &M,
    start: &State,
    span: f64,
) {
    let mut y = vec![0.0; 2 * model.dof()];
    let mut run = |end: f64| {
        let mut stats = Stats::default();
        let count = allocations(|| {
            let mut look = |step: &mut Step<'_>| {
                step.at(0.5 * (step.t0() + step.t1()), &mut y);
                ControlFlow::Continue(())
            };
            stats = solver.run(model, start, end, &mut look).unwrap().stats;
        });
        (count, stats)
    };
    run(start.t + 0.1 * span); // the first run of a model may prepare its waves
    let ((short, few), (long, many)) = (run(start.t + 0.1 * span), run(start.t + span));
    println!(
        "{name}: {short} allocations for {} steps, {long} for {} with {} crossings",
        few.steps, many.steps, many.crossings
    );
    assert!(many.steps > 5 * few.steps && many.crossings > 2 * few.crossings.max(1));
    assert_eq!(short, long, "{name}");
}

/// A ball on a rigid floor, with elastic impacts.
struct Ball;

impl Model for Ball {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = -1.0;
    }
    fn offers(&self) -> Offers<'_> {
        Offers { stops: &[[true, false]], ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        out[0] = Contact { deflection: q[0], rate: v[0], lower: 0.0, ..Contact::default() };
    }
    fn impact(&self, _: usize, _: Piece, _: &[f64], _: &[f64], v: &mut [f64]) {
        v[0] = -v[0];
    }
}

#[test]
fn steps_do_not_allocate() {
    let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() }).unwrap();
    let start = pair.on_drive_flank().unwrap();
    steps_allocate_nothing("pair, rk4", &Rk4::new(0.5), &pair, &start, pair.period());
    steps_allocate_nothing("pair, rk45", &Rk45::new(), &pair, &start, pair.period());
    steps_allocate_nothing("pair, dop853", &Dop853::new(), &pair, &start, pair.period());
    steps_allocate_nothing("pair, rodas", &Rodas::new().rtol(1e-6), &pair, &start, pair.period());
    steps_allocate_nothing("pair, taylor", &Taylor::new(), &pair, &start, pair.period());
    steps_allocate_nothing("ball, dop853", &Dop853::new(), &Ball, &State::new(0.0, &[1.0], &[0.0]), 200.0);
    let two = NfgPair2::new(&NfgParams { speed: 180.0, ..NfgParams::table1() }, 0.01).unwrap();
    steps_allocate_nothing(
        "pair of two",
        &Dop853::new().atol(1e-14),
        &two,
        &two.on_drive_flank().unwrap(),
        two.period(),
    );
    let ring = Ring::new(&RingSet { error: 1e-5, ..RingSet::set_a(6, 5000.0) }.params().unwrap())
        .unwrap()
        .with_frame(Frame::Rigid);
    steps_allocate_nothing("ring, dop853", &Dop853::new(), &ring, &State::at_rest(13), 0.1);
    steps_allocate_nothing("ring, rodas", &Rodas::new().rtol(1e-6), &ring, &State::at_rest(13), 0.1);
    steps_allocate_nothing("ring, taylor", &Taylor::new(), &ring, &State::at_rest(13), 0.1);
    let process = HeldProcess::new(1e-4, rand_distr::Uniform::new(0.0, 1.0).unwrap()).unwrap();
    let slot = |i: usize| ring.slot(&format!("mesh damping {i}")).unwrap();
    let noisy =
        (0..6).fold(Noisy::new(ring.clone()), |noisy, i| noisy.add(&[(slot(i), 500.0)], &process).unwrap());
    steps_allocate_nothing("noisy ring", &Dop853::new(), &noisy, &State::at_rest(13), 0.1);
    steps_allocate_nothing("noisy ring, taylor", &Taylor::new(), &noisy, &State::at_rest(13), 0.1);
}

/// Statistics and rattle do not allocate in a step.
#[test]
fn analysis_does_not_allocate() {
    let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() }).unwrap();
    let start = pair.on_drive_flank().unwrap();
    let mut statistics = Statistics::new(&pair, &["q0", "deflection", "mesh force"]).unwrap();
    let mut rattle = Rattle::new(&pair);
    let mut run = |share: f64| {
        allocations(|| {
            let mut both = (&mut statistics, &mut rattle);
            Dop853::new().run(&pair, &start, share * pair.period(), &mut both).unwrap();
        })
    };
    assert_eq!(run(0.1), run(1.0));
}

/// A point of a sweep needs the memory of its row: a map of a million points with two channels and rattle
/// stays below 200 MB. Merging chunks needs the memory of the whole in addition to theirs. Measured with 10
/// 000 points; the remaining memory does not grow with their number.
#[test]
fn a_million_points_fit_into_200_megabytes() {
    const POINTS: usize = 10_000;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().unwrap();
    let loads = Axis::linear("load", 20.0, 40.0, POINTS / 2).unwrap();
    let points = Points::grid(vec![Axis::of_values("speed", &[1800.0, 1801.0]).unwrap(), loads]).unwrap();
    let sweep = Sweep::new(points).settle(0).measure(1).channels(&["q0", "deflection"]).rattle();
    let family = |p: &Point<'_>| {
        NfgPair::new(&NfgParams { speed: p["speed"], load_torque: p["load"], ..NfgParams::table1() })
    };
    let chunk = |i, n| {
        sweep
            .of(&LaneRk4::new(63 * 2), family)
            .start(|_, pair: &NfgPair| pair.on_drive_flank())
            .chunk(i, n)
            .unwrap()
    };
    let most = |run: &mut dyn FnMut()| allocation_counter::measure(run).bytes_max as f64 / POINTS as f64;
    let mut count = 0;
    let whole = most(&mut || count = pool.install(|| chunk(0, 1)).iter().count());
    let merged = most(&mut || {
        count += Rows::merge((0..10).map(|i| pool.install(|| chunk(i, 10))).collect()).unwrap().iter().count()
    });
    println!("{whole:.0} bytes per point, {merged:.0} merged");
    assert_eq!(count, 2 * POINTS); // no point has failed
    assert!(whole < 200.0 && merged < 2.0 * whole, "{whole} bytes per point, {merged} merged");
}

/// An ensemble does not keep its members: ten times as many need no more memory.
#[test]
fn members_are_not_kept() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().unwrap();
    let pair = NfgPair::new(&NfgParams::table1()).unwrap();
    let family = |member: u64| -> Result<_, ParameterError> {
        Ok((pair.clone(), State::new(0.0, &[-6.4e-4 * (1.0 + 1e-6 * member as f64)], &[0.0])))
    };
    let most = |members: u64| {
        let ensemble = Ensemble::new(members, 2.0, 4).unwrap().channels(&["q0"]).rattle();
        allocation_counter::measure(|| drop(pool.install(|| ensemble.run(&Rk4::new(0.5), family)).unwrap()))
            .bytes_max
    };
    let (few, many) = (most(2_000), most(20_000));
    println!("{few} bytes for 2 000 members, {many} for 20 000");
    assert!(many < few + few / 10 && many < 1_000_000);
}

/// The variational equations do not allocate, with and without a Jacobian of the model: a longer run makes
/// the same number of allocations.
#[test]
fn differences_do_not_allocate() {
    fn check<M: Model>(name: &str, model: &M, start: &State, span: f64) {
        let run = |share: f64| {
            let mut crossings = 0;
            let count = allocations(|| {
                let variation = Variation::new().flow_method(FlowMethod::Dop853);
                crossings = variation.run(model, start, start.t + share * span).unwrap().crossings;
            });
            (count, crossings)
        };
        // A difference that has grown tenfold starts a run of its own. Both ends lie after the last of these
        // starts.
        // The first run computes the Fourier series of the waves.
        run(0.1);
        let ((short, few), (long, many)) = (run(1.3), run(2.3));
        println!("{name}: {short} allocations for {few} crossings, {long} for {many}");
        assert!(many > few);
        assert_eq!(short, long, "{name}");
    }
    let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() }).unwrap();
    check("pair", &pair, &pair.on_drive_flank().unwrap(), pair.period());
    let two = NfgPair2::new(&NfgParams { speed: 200.0, ..NfgParams::table1() }, 0.01).unwrap();
    check("pair of two", &two, &two.on_drive_flank().unwrap(), two.period());
}

/// A residual of a balance does not allocate, with any way of integration.
#[test]
fn balance_residuals_do_not_allocate() {
    let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() }).unwrap();
    let late = Dop853::new().end(&pair, &pair.on_drive_flank().unwrap(), pair.period()).unwrap();
    let harmonics = Harmonics::up_to(70);
    let orbit = FourierOrbit::project(&Dop853::new(), &pair, &State { t: 0.0, ..late }, &harmonics).unwrap();
    for integrals in
        [Integrals::Closed, Integrals::Kinks, Integrals::Panels, Integrals::Sampled { samples: 1024 }]
    {
        let mut equations =
            Balance::new(harmonics.clone()).integrals(integrals).equations(&pair, &orbit).unwrap();
        let mut x = equations.unknowns(&orbit);
        let mut r = vec![0.0; x.len()];
        equations.residual(&x, &mut r);
        assert!(orbit.contacts(&pair).unwrap()[0].intervals.len() > 10);
        let count = allocations(|| {
            for _ in 0..3 {
                x[0] *= 1.0 + f64::EPSILON; // another argument each time
                equations.residual(&x, &mut r);
            }
        });
        assert_eq!(count, 0, "{integrals:?}");
    }
}
