//! Trains with equal members, whose differences rest at 0 in relative coordinates, and symmetries that break.

use crate::common::planets::ring_locked;
use gear_dynamics::branches::{BranchEnd, BranchPoint, Continuation, Family, PointKind, Switch};
use gear_dynamics::excitation::{Fourier, Side};
use gear_dynamics::linear::static_state;
use gear_dynamics::models::ring::RingSet;
use gear_dynamics::periodic::{FlowMethod, Lyapunov, Variation};
use gear_dynamics::sweep::{Axis, LaneRk4, Located, Rows};
use gear_dynamics::tori::{CircleShooting, QuasiPeriodic, Torus, TorusBalance, WaveVectors, WithShafts};
use gear_dynamics::trains::{Coordinates, Planetary, Train, ring_parts};
use gear_dynamics::{
    Balance, Dop853, Harmonics, Integrator, Model, Periodic, Settle, Shape, Shooting, State, Sweep, Taylor,
    Wave,
};

fn wave(mean: f64, share: f64) -> Wave {
    Wave::new(Fourier::new(mean, &[[share * mean, 0.0]]).unwrap())
}

/// A set of equal planets in phase, loaded by 40 N m on the sun.
fn set(planets: u32, half_backlash: f64, coordinates: Coordinates) -> Train {
    let waves = [wave(2e8, 0.2), wave(2.5e8, 0.2)];
    let members = ring_locked([30, 30, 90], [1e-3, 1e-3, 5e-2, 3e-2]);
    let set = Planetary::new(planets, 0.03, members, waves).unwrap();
    let mut parts = set.damping(1000.0).half_backlash(half_backlash).parts();
    parts.torque("drive", "sun", 40.0).torque("load", "carrier", -160.0).coordinates(coordinates);
    parts.build("sun", 100.0).unwrap()
}

/// |μ| of all multipliers, in decreasing order.
fn sizes(train: &Train, guess: &State, method: FlowMethod) -> Vec<f64> {
    let orbit = Shooting::new().flow_method(method).solve(train, guess).unwrap();
    orbit.multipliers().values().iter().map(|m| m.norm()).collect()
}

#[test]
fn equal_planets_have_the_same_orbits_in_relative_coordinates() {
    for (planets, half_backlash) in [(2, 2e-5), (3, 2e-5), (3, 0.0)] {
        let [inertial, relative] =
            [Coordinates::Inertial, Coordinates::Relative].map(|frame| set(planets, half_backlash, frame));
        let settle = Settle::new().tolerance(1e-9);
        let steady = settle.clone().run(
            &Dop853::new().rtol(1e-11).atol(1e-16),
            &inertial,
            &State::at_rest(inertial.dof()),
        );
        let expected = sizes(&inertial, &steady.unwrap().state, FlowMethod::Taylor);
        let rest = State::at_rest(relative.dof());
        let by_taylor = settle.run(&Taylor::new().rtol(1e-11).atol(1e-16), &relative, &rest).unwrap();
        let by_dop853 = settle.run(&Dop853::new().rtol(1e-11).atol(1e-16), &relative, &rest).unwrap();
        assert_eq!((by_taylor.period_multiple, by_dop853.period_multiple), (1, 1));
        for guess in [&by_taylor.state, &by_dop853.state] {
            for method in [FlowMethod::Taylor, FlowMethod::Dop853] {
                let found = sizes(&relative, guess, method);
                assert_eq!(found.len(), expected.len());
                for (a, b) in found.iter().zip(&expected) {
                    assert!((a - b).abs() < 1e-9, "{planets} planets: {found:?} {expected:?}");
                }
            }
        }
    }
}

/// The other methods on the set with three planets in relative coordinates.
#[test]
fn equal_planets_pass_every_method_in_relative_coordinates() {
    let train = set(3, 2e-5, Coordinates::Relative);
    let steady =
        Settle::new().run(&Taylor::new().rtol(1e-11).atol(1e-16), &train, &State::at_rest(train.dof()));
    let start = State { t: 0.0, ..steady.unwrap().state };
    let orbit = Shooting::new().solve(&train, &start).unwrap();
    let first = &orbit.states()[0];
    let through = Variation::new().run(&train, first, first.t + train.period()).unwrap();
    let range = orbit.range();
    for i in 0..range.len() {
        for j in 0..range.len() {
            let off = (through.matrix[(i, j)] - orbit.monodromy()[(i, j)]) * range[j] / range[i];
            assert!(off.abs() < 1e-9, "{i} {j} {off:e}");
        }
    }
    let exact = orbit.multipliers().largest().ln() / train.period();
    let exponents = Lyapunov::new().settle(0).align(30).measure(30).count(1).run(&train, first).unwrap();
    assert!((exponents.values()[0] / exact - 1.0).abs() < 0.05, "{} {exact}", exponents.values()[0]);

    let balance = Balance::new(Harmonics::up_to(8));
    let series = balance.linearised(&train, gear_dynamics::contact::Piece::Upper).unwrap();
    let polished = Shooting::new().solve_from(&train, &balance.solve(&train, &series).unwrap()).unwrap();
    assert!((polished.multipliers().largest() - orbit.multipliers().largest()).abs() < 1e-9);

    let row = |rows: &Rows| rows.iter().next().unwrap().period_multiple();
    let sweep = Sweep::new(Axis::of_values("speed", &[100.0]).unwrap()).settle(40).measure(8);
    let located = sweep
        .of(&Located(Dop853::new().rtol(1e-10).atol(1e-16)), |p| train.with("speed", p["speed"]))
        .start(|_, _| start.clone())
        .run()
        .unwrap();
    let steps = 512 * train.shape().cycles_in_a_period() as usize;
    let lanes = sweep
        .of(&LaneRk4::new(steps).lanes::<4>(), |p| train.with("speed", p["speed"]))
        .start(|_, _| start.clone())
        .run()
        .unwrap();
    assert_eq!((row(&located), row(&lanes)), (Some(1), Some(1)));
    assert_eq!(gear_dynamics::check::check_periodic(&train, &start), []);
}

/// Two equal planets move against each other: δ'' + (2 c r² δ' + (k_s + k_r) r² δ)/J = 0, a Hill equation. Its largest
/// multiplier is -1 where the symmetric orbit doubles into the antisymmetric coordinate.
struct Against {
    speed: f64,
}

/// Damping of each mesh [N s/m], radius `[m]` and inertia [kg m²] of a planet.
const DAMPING: f64 = 100.0;
const RADIUS: f64 = 0.03;
const INERTIA: f64 = 1e-3;

impl Model for Against {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let stiffness = 4.5e8 * (1.0 + 0.2 * (std::f64::consts::TAU * u[0] / self.period()).cos());
        a[0] = -(2.0 * DAMPING * v[0] + stiffness * q[0]) * RADIUS * RADIUS / INERTIA;
    }
}

impl Periodic for Against {
    /// The sun turns by 3/4 of its speed against the carrier and has 30 teeth.
    fn period(&self) -> f64 {
        std::f64::consts::TAU / (30.0 * 0.75 * self.speed)
    }
}

/// Trace of the monodromy matrix of the antisymmetric motion plus 1 + det: 0 where a multiplier is -1.
fn doubling(speed: f64) -> f64 {
    let model = Against { speed };
    let matrix =
        Variation::new().run(&model, &State::new(0.0, &[1e-6], &[0.0]), model.period()).unwrap().matrix;
    1.0 + matrix[(0, 0)] + matrix[(1, 1)] + matrix[(0, 0)] * matrix[(1, 1)] - matrix[(0, 1)] * matrix[(1, 0)]
}

/// The root of `doubling` between two speeds, by bisection.
fn border(mut low: f64, mut high: f64) -> f64 {
    let sign = doubling(low) > 0.0;
    assert_ne!(sign, doubling(high) > 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if (doubling(middle) > 0.0) == sign { &mut low } else { &mut high }) = middle;
    }
    low
}

/// A set with little damping at a speed below its doublings, and its state at rest under load.
fn lightly_damped(planets: u32) -> (Train, State) {
    let waves = [wave(2e8, 0.2), wave(2.5e8, 0.2)];
    let members = ring_locked([30, 30, 90], [1e-3, INERTIA, 5e-2, 3e-2]);
    let set = Planetary::new(planets, RADIUS, members, waves).unwrap();
    let mut parts = set.damping(DAMPING).half_backlash(2e-5).parts();
    parts.torque("drive", "sun", 400.0).torque("load", "carrier", -1600.0);
    let train = parts.coordinates(Coordinates::Relative).build("sun", 1400.0).unwrap();
    let rest = static_state(&train, 0.0).unwrap();
    (train, rest.state)
}

/// The speeds at which the antisymmetric motion doubles. It has ω² = 4.5e8 r²/J: twice ω is the mesh frequency near
/// 1790 rad/s.
fn borders() -> [f64; 2] {
    [border(1600.0, 1780.0), border(1800.0, 1980.0)]
}

/// The distance of a border from the nearest of some speeds, as a share.
fn nearest(speeds: &[f64], border: f64) -> f64 {
    speeds.iter().map(|p| (p / border - 1.0).abs()).fold(f64::INFINITY, f64::min)
}

/// Three planets have two antisymmetric motions, whose multipliers pass -1 together.
#[test]
fn multipliers_of_three_planets_pass_together() {
    let (train, start) = lightly_damped(3);
    let family = Family::over(&train, ["speed"]).unwrap();
    let branch = Continuation::new(1400.0, 2000.0).run(&family, &[start]).unwrap();
    let doublings = branch.of_kind(PointKind::PeriodDoubling);
    let near: Vec<f64> = doublings.iter().map(|point| point.parameter).collect();
    for border in borders() {
        assert!(nearest(&near, border) < 1e-9, "{border} {near:?}");
        let at = doublings.iter().find(|point| (point.parameter / border - 1.0).abs() < 1e-9).unwrap();
        let critical = at.multipliers.values().iter().filter(|m| (*m + 1.0).norm() < 1e-6).count();
        assert_eq!(critical, 2, "{:?}", at.multipliers);
    }
    assert!(branch.of_kind(PointKind::NeimarkSacker).is_empty() && branch.notes().is_empty(), "{branch}");
}

/// The drive that accelerates the first coordinate alone: the torques on it.
fn torque_slot(train: &Train, rest: &[f64]) -> usize {
    let (n, still) = (train.dof(), vec![0.0; train.dof()]);
    let mut u = vec![0.0; train.drives()];
    train.drive(0.0, Side::After, &mut u);
    let at = |slot: usize, change: f64| {
        let (mut u, mut a) = (u.clone(), vec![0.0; n]);
        u[slot] += change;
        train.accel(&u, rest, &still, &mut a);
        a
    };
    let first = train.size().waves + 2;
    let alone = |slot: &usize| {
        let size = 1e-3 * u[*slot].abs();
        let [a, b] = [at(*slot, 0.0), at(*slot, size)];
        let moved: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).collect();
        size > 0.0 && moved[0] > 0.0 && moved[1..].iter().all(|other| *other < 1e-9 * moved[0])
    };
    (first..train.drives()).find(alone).unwrap()
}

/// A ripple of the torque whose frequency has no common measure with the mesh: the torus in relative coordinates
/// contains the settled motion.
#[test]
fn equal_planets_have_tori_in_relative_coordinates() {
    let train = set(3, 0.0, Coordinates::Relative);
    let rest = static_state(&train, 0.0).unwrap().state.q;
    let slot = torque_slot(&train, &rest);
    let mut u = vec![0.0; train.drives()];
    train.drive(0.0, Side::After, &mut u);
    let ripple = Wave::new(Fourier::new(0.0, &[[0.1 * u[slot], 0.0]]).unwrap());
    let frequency = std::f64::consts::SQRT_2 * 700.0;
    let model = WithShafts::new(train).add(slot, frequency, ripple).unwrap();
    let vectors = WaveVectors::in_box(&[10, 3]).unwrap();
    let guess = Torus::constant(&vectors, &model.frequencies(), &rest).unwrap();
    let torus = TorusBalance::new(vectors).solve(&model, &guess).unwrap();
    let start = torus.at(0.0);
    let end = Dop853::new().rtol(1e-11).atol(1e-18).end(&model, &start, 0.05).unwrap();
    let (expected, size) = (torus.at(0.05), torus.peak_to_peak(0, 64).unwrap());
    assert!(size > 0.0 && (end.q[0] - expected.q[0]).abs() < 1e-6 * size, "{end:?} {expected:?}");
    let circle = torus.section(0, 11).unwrap();
    let found = CircleShooting::new().solve(&model, &circle).unwrap();
    let off = found.curve().at(0.7).q[0] - circle.at(0.7).q[0];
    assert!(off.abs() < 1e-6 * size, "{off:e} {size:e}");
}

#[test]
fn a_ring_without_load_rests() {
    for coordinates in [Coordinates::Inertial, Coordinates::Relative] {
        let mut set =
            RingSet { motor_torque: 0.0, load_torque: 0.0, error: 0.0, ..RingSet::set_a(4, 1000.0) };
        set.half_backlash = 0.0;
        let parts = ring_parts(&set.params().unwrap(), set.teeth);
        let train = parts.unwrap().coordinates(coordinates).build("gear 1", 100.0).unwrap();
        let orbit = Shooting::new().solve(&train, &[State::at_rest(train.dof())]).unwrap();
        assert!(orbit.states()[0].q.iter().all(|q| *q == 0.0));
        // A mesh without gap is a spring: each free motion of the linear ring decays.
        let largest = orbit.multipliers().largest();
        assert!(largest > 0.1 && largest < 1.0, "{largest}");
    }
}

#[test]
fn a_symmetry_that_breaks_is_found_in_relative_coordinates() {
    let (train, start) = lightly_damped(2);
    let borders = borders();
    let family = Family::over(&train, ["speed"]).unwrap();
    let continuation = Continuation::new(1400.0, 2000.0);
    let branch = continuation.run(&family, &[start]).unwrap();
    let doublings = branch.of_kind(PointKind::PeriodDoubling);
    let near: Vec<f64> = doublings.iter().map(|point| point.parameter).collect();
    for border in borders {
        assert!(nearest(&near, border) < 1e-9, "{border} {near:?}");
    }
    // The orbits of twice the period that branch off differ between the planets. Up to the loss of contact the system
    // is linear and any multiple of the difference solves it: it grows with the steps.
    let doubled = Continuation::new(borders[0], 1700.0).bounds(1400.0, 2000.0).max_points(50);
    let at = doublings.iter().find(|point| (point.parameter / borders[0] - 1.0).abs() < 1e-9).unwrap();
    let branch = doubled.run(&family, Switch::of_point(at)).unwrap();
    let last = branch.points().last().unwrap();
    assert_eq!(last.orbit.least_period_multiple(), 2);
    let planet = train.shape().coordinates().iter().position(|c| c.name == "planet 1 angle").unwrap();
    let apart = last.orbit.states().iter().fold(0.0, |m: f64, state| m.max(state.q[planet].abs()));
    let along = last.orbit.states().iter().fold(0.0, |m: f64, state| m.max(state.q[0].abs()));
    assert!(apart > 1e-3 * along, "{apart:e} {along:e}");
}

/// On this branch one planet moves unlike the two others. It crosses the orbits with equal planets: their difference
/// passes 0 there, and two multipliers of the equal planets pass 1 together.
#[test]
fn a_branch_of_unequal_planets_crosses_that_of_equal_ones() {
    let waves =
        [wave(142574008.47091365, 0.28027976307592856), wave(355892324.82503444, 0.24847584561306574)];
    let members = ring_locked([36, 24, 84], [1e-3, 1e-3, 5e-2, 3e-2]);
    let set = Planetary::new(3, 0.03, members, waves).unwrap();
    let mut parts = set.damping(675.543257596351).half_backlash(7.435980225942522e-6).parts();
    let torque = 8.992729466856607;
    parts.torque("drive", "sun", torque).torque("load", "carrier", -torque * (1.0 + 84.0 / 36.0));
    let speeds = [399.4075942320923, 2.0 * 399.4075942320923];
    let train = parts.coordinates(Coordinates::Relative).build("sun", speeds[0]).unwrap();
    let settle = Settle::new().tolerance(1e-8).max_periods(600);
    let rest = State::at_rest(train.dof());
    let steady = settle.run(&Dop853::new().rtol(1e-10).atol(1e-16), &train, &rest).unwrap();
    let family = Family::over(&train, ["speed"]).unwrap();
    let shooting = Shooting::new().period_multiple(steady.period_multiple);
    let continuation = Continuation::new(speeds[0], speeds[1]).shooting(shooting);
    let branch = continuation.run(&family, &steady.state).unwrap();
    assert_eq!(branch.end(), &BranchEnd::Bound);
    let near_one =
        |point: &BranchPoint| point.multipliers.values().iter().filter(|m| (**m - 1.0).norm() < 1e-6).count();
    let crossings: Vec<&BranchPoint> =
        branch.of_kind(PointKind::Branch).into_iter().filter(|point| near_one(point) == 2).collect();
    assert_eq!(crossings.len(), 1);
    let crossing = crossings[0];
    let state = &crossing.orbit.states()[0];
    assert!(state.q[2..].iter().zip(&crossing.orbit.range()[..2]).all(|(q, r)| q.abs() < 1e-5 * r));

    // The orbits with equal planets on both sides.
    let outside = |by: f64| {
        let mut guess = state.clone();
        guess.q[2..].fill(0.0);
        guess.v[2..].fill(0.0);
        let train = train.with("speed", crossing.parameter * (1.0 + by)).unwrap();
        let orbit = Shooting::new().solve(&train, &guess).unwrap();
        assert!(orbit.states()[0].q[2..].iter().all(|q| q.abs() < 1e-9 * orbit.range()[0]));
        orbit.multipliers().values().iter().filter(|m| m.norm() > 1.0).count()
    };
    assert_eq!(outside(-1e-6).abs_diff(outside(1e-6)), 2);
}
