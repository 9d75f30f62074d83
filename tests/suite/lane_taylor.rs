//! Taylor series in lanes: rows of the engine `LaneTaylor` against those of single runs and closed forms, the same bits
//! for any way of running, difficult edges, runs that fail, refusals.

use crate::api::*;
use crate::benchmarks::{Pair, Rattling, ring};
use crate::common::planets::ring_locked;
use crate::common::random::Random;
use gear_dynamics::sweep::Watch;
use gear_dynamics::trains::{Planetary, Train};
use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

const TOLERANCE: f64 = 1e-10;

pub(crate) fn tolerant() -> Taylor {
    Taylor::new().rtol(TOLERANCE).atol(1e-15)
}

pub(crate) fn axis(name: &str, from: f64, to: f64, count: usize) -> Points {
    Points::from(Axis::linear(name, from, to, count).unwrap())
}

/// The rows of a sweep over one constant of a machine.
pub(crate) fn rows<G: Shape + Send + Sync>(
    sweep: &Sweep,
    engine: &impl SweepEngine<Machine<G>>,
    machine: &Machine<G>,
    start: &State,
) -> Rows {
    let name = sweep.points().names()[0].clone();
    let family = |p: &Point<'_>| machine.with(&name, p[&*name]);
    sweep.of(engine, family).start(|_, _| start.clone()).run().unwrap()
}

/// Compares all figures of two rows: those of channels within `within` of their size, and states at an instant, which
/// all steps before have changed, within ten times of it.
fn agree(what: &str, a: &Row<'_>, b: &Row<'_>, channels: &[&str], contacts: usize, within: f64) {
    for name in channels {
        let (x, y) = (a.channel(name).unwrap(), b.channel(name).unwrap());
        let size = y.max.abs().max(y.min.abs());
        for (x, y) in
            [(x.mean, y.mean), (x.rms, y.rms), (x.min, y.min), (x.max, y.max), (x.deviation, y.deviation)]
        {
            assert!((x - y).abs() <= within * size, "{what}, {name}: {x:e} {y:e}");
        }
        for (x, y) in
            a.extremes(name).unwrap().iter().flatten().zip(b.extremes(name).unwrap().iter().flatten())
        {
            assert!((x - y).abs() <= within * size, "{what}, extremes of {name}: {x:e} {y:e}");
        }
    }
    for (x, y) in a.strobes().zip(b.strobes()) {
        let size = y.iter().fold(0.0, |size: f64, y| size.max(y.abs()));
        let close = |x: &f64, y: &f64| (x - y).abs() <= 10.0 * within * size;
        x.iter().zip(y).for_each(|(x, y)| assert!(close(x, y), "{what}: {x:e} {y:e}"));
    }
    for i in 0..contacts {
        let (x, y) = (a.contacts()[i], b.contacts()[i]);
        assert_eq!(x.impacts, y.impacts, "{what}, contact {i}");
        assert_eq!(a.contacts()[i].rattle_state(), b.contacts()[i].rattle_state(), "{what}, contact {i}");
        x.time.iter().zip(y.time).for_each(|(x, y)| {
            assert!((x - y).abs() <= within, "{what}, contact {i}: {x:e} {y:e}");
        });
    }
    assert_eq!(a.period_multiple(), b.period_multiple(), "{what}");
}

/// Rows in lanes are those of single runs, at all points whose motion repeats: its errors do not grow. Where a single
/// run with a thousandth of the tolerance differs by far more, a motion is sensitive and is no point of these tests.
fn rows_agree<G: Shape + Send + Sync>(
    machine: &Machine<G>,
    start: &State,
    points: Points,
    channels: &[&str],
    [settle, measure, strobes]: [usize; 3],
    least: usize,
) {
    let sweep =
        Sweep::new(points).settle(settle).measure(measure).channels(channels).rattle().strobe(strobes);
    let sweep = sweep.periodic_tolerance(1e-7);
    let lanes = rows(&sweep, &LaneTaylor::new(tolerant()), machine, start);
    let single = rows(&sweep, &Located(tolerant()), machine, start);
    assert!(lanes.errors().is_empty() && single.errors().is_empty(), "{:?}", lanes.errors());
    let contacts = machine.contacts();
    let mut compared = 0;
    for (i, (a, b)) in lanes.iter().zip(single.iter()).enumerate() {
        if b.period_multiple().is_some() {
            compared += 1;
            agree(&format!("point {i}"), &a, &b, channels, contacts, 10.0 * TOLERANCE);
        }
    }
    assert!(compared >= least, "{compared} of {} motions repeat", single.iter().count());
}

pub(crate) fn pair() -> Machine<Rattling> {
    Pair::new().machine_of_waves()
}

#[test]
fn rows_of_the_pair_are_those_of_single_runs() {
    rows_of_pairs([6, 4], [3, 2]);
}

/// Needs 30 s of processor time: `cargo test --test suite more_rows_of_the_pair -- --ignored`.
#[test]
#[ignore = "30 s of processor time"]
fn more_rows_of_the_pair_are_those_of_single_runs() {
    rows_of_pairs([12, 8], [6, 4]);
}

/// `points` of the pair and of the face gear pair, of which at least as many as `periodic` are compared.
fn rows_of_pairs([points, faces]: [usize; 2], periodic: [usize; 2]) {
    let points = axis("wc", 0.15 / 63.0, 0.36 / 63.0, points);
    // The error of v1 is that of q1 times a frequency, far above the tolerance of v1 itself. The fourth motion passes for
    // periodic after 25 turns, although a single run is off by 2e-7; after 50 turns it does not repeat.
    rows_agree(&pair(), &Pair::start(), points, &["q0", "mesh force", "deflection"], [50, 2, 2], periodic[0]);
    let nfg = NfgPair::new(&NfgParams::table1()).unwrap();
    let start = nfg.on_drive_flank().unwrap();
    rows_agree(
        &nfg,
        &start,
        axis("speed", 80.0, 150.0, faces),
        &["q0", "mesh force"],
        [12, 1, 1],
        periodic[1],
    );
}

#[test]
fn rows_of_a_ring_are_those_of_single_runs() {
    let ring = ring(3, 2.0);
    let omega = ring.speed();
    let points = axis("mesh frequency", 0.5 * omega, omega, 3);
    rows_agree(&ring, &State::at_rest(ring.dof()), points, &["deflection 0", "mesh force 1"], [400, 3, 2], 2);
}

pub(crate) fn planetary() -> Train {
    let wave = |mean: f64| Wave::new(Fourier::new(mean, &[[0.2 * mean, 0.0]]).unwrap());
    let members = ring_locked([30, 30, 90], [1e-3, 1e-3, 5e-2, 3e-2]);
    let set = Planetary::new(3, 0.03, members, [wave(2e8), wave(2.5e8)]).unwrap();
    let error = || Wave::new(Fourier::new(0.0, &[[1e-6, 0.0]]).unwrap());
    let mut parts = set.error([error(), error()]).damping(1000.0).half_backlash(2e-5).parts();
    parts.torque("drive", "sun", 40.0).torque("load", "carrier", -160.0);
    parts.build("sun", 100.0).unwrap()
}

#[test]
fn rows_of_a_planetary_set_are_those_of_single_runs() {
    let train = planetary();
    let points = axis("speed", 200.0, 600.0, 5);
    let start = State::at_rest(train.dof());
    // No states: the set turns as a whole, and nothing damps the error of that motion.
    rows_agree(&train, &start, points, &["deflection 0", "mesh force 3"], [400, 3, 0], 2);
}

#[test]
fn the_same_bits_however_it_is_run() {
    let sweep = Sweep::new(axis("wc", 0.15 / 63.0, 0.36 / 63.0, 11)).settle(0).measure(2);
    let sweep = sweep.channels(&["q0", "v0", "mesh force"]).rattle().strobe(2);
    let (machine, start, engine) = (pair(), Pair::start(), LaneTaylor::new(tolerant()));
    let expected = rows(&sweep, &engine, &machine, &start).fingerprint();
    for set in InstructionSet::available() {
        let rows = rows(&sweep, &engine.clone().instructions(set), &machine, &start);
        assert_eq!(expected, rows.fingerprint(), "{set:?}");
    }
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let rows = pool.install(|| rows(&sweep, &engine, &machine, &start));
        assert_eq!(expected, rows.fingerprint(), "{threads} threads");
    }
    let family = |p: &Point<'_>| machine.with("wc", p["wc"]);
    let runner = sweep.of(&engine, family).start(|_, _| start.clone());
    let parts = [2, 0, 1].map(|i| runner.chunk(i, 3).unwrap());
    assert_eq!(expected, Rows::merge(parts.into()).unwrap().fingerprint());
    // Every point alone, without neighbours.
    let alone = (0..11).map(|i| runner.chunk(i, 11).unwrap()).collect();
    assert_eq!(expected, Rows::merge(alone).unwrap().fingerprint());
    // A run that is cancelled and resumed.
    let (made, cancel) = (AtomicUsize::new(0), Arc::new(AtomicBool::new(false)));
    let stop = |_: &Row<'_>| {
        if made.fetch_add(1, Ordering::Relaxed) == 4 {
            cancel.store(true, Ordering::Relaxed);
        }
    };
    let partial = sweep
        .of(&engine, family)
        .start(|_, _| start.clone())
        .row_callback(stop)
        .watch(Watch::new().cancel(cancel.clone()));
    let partial = partial.run().unwrap();
    assert!(partial.iter().count() < 11);
    assert_eq!(expected, runner.resume(partial).unwrap().fingerprint());
    // The points in another order, and neighbours of another shape.
    let reversed: Vec<Vec<f64>> = (0..11).rev().map(|i| sweep.points().point(i).values().to_vec()).collect();
    let other = Sweep::new(Points::of_rows(&["wc"], &reversed).unwrap()).settle(0).measure(2);
    let other = other.channels(&["q0", "v0", "mesh force"]).rattle().strobe(2);
    let (there, here) = (rows(&other, &engine, &machine, &start), rows(&sweep, &engine, &machine, &start));
    for i in 0..11 {
        let (a, b) = (here.get(i).unwrap(), there.get(10 - i).unwrap());
        agree(&format!("point {i}"), &a, &b, &["q0", "v0", "mesh force"], 1, 0.0);
    }
}

#[test]
fn warm_starts_follow_their_line() {
    let sweep = Sweep::new(axis("wc", 0.15 / 63.0, 0.16 / 63.0, 7)).settle(1).measure(1).channels(&["q0"]);
    let sweep = sweep.warm_start(WarmStart::Up).repeat_tolerance(1e-6);
    let (machine, start) = (pair(), Pair::start());
    let wide = rows(&sweep, &LaneTaylor::new(tolerant()), &machine, &start);
    let single = rows(&sweep, &Located(tolerant()), &machine, &start);
    for (a, b) in wide.iter().zip(single.iter()) {
        agree("warm", &a, &b, &["q0"], 0, 1e-8);
    }
}

/// q'' = pull - Σ (k ξ_i + c ξ_i'): a mass between stops whose edges are waves. ξ_i is the penetration of stop i.
#[derive(Clone, PartialEq)]
pub(crate) struct Stops {
    /// Whether each stop is below the mass; the wave of its edge.
    all: Vec<(bool, Wave)>,
    stiffness: f64,
    damping: f64,
    /// The stops are rigid, with this restitution.
    rigid: Option<Restitution>,
    both: Vec<[bool; 2]>,
}

impl Stops {
    pub(crate) fn machine(
        all: &[(bool, Wave)],
        stiffness: f64,
        damping: f64,
        speed: f64,
        pull: f64,
    ) -> Machine<Stops> {
        let shape = Stops { all: all.to_vec(), stiffness, damping, rigid: None, both: Vec::new() };
        Machine::of_constants(shape, &[("speed", speed), ("pull", pull)]).unwrap()
    }
    pub(crate) fn rigid(all: &[(bool, Wave)], restitution: f64, speed: f64, pull: f64) -> Machine<Stops> {
        let both = all.iter().map(|(below, _)| [*below, !below]).collect();
        let rigid = Some(Restitution::new(restitution).unwrap());
        let shape = Stops { all: all.to_vec(), stiffness: 0.0, damping: 0.0, rigid, both };
        Machine::of_constants(shape, &[("speed", speed), ("pull", pull)]).unwrap()
    }
}

impl Shape for Stops {
    #[inline(always)]
    fn size(&self) -> Size {
        Size { dof: 1, waves: 2 * self.all.len(), contacts: self.all.len(), constants: 2, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1"), Channel::new("pull", "1")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        for ((_, wave), u) in self.all.iter().zip(u.chunks_exact_mut(2)) {
            let jet = wave.jet(angle, side);
            (u[0], u[1]) = (jet.value, jet.rate);
        }
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        self.all.iter().filter_map(|(_, wave)| wave.next_edge(angle)).reduce(f64::min)
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let ([edge, rate], (below, _)) = (u.waves_from::<2>(2 * i), &self.all[i]);
        let rate = rate * u.speed();
        let infinite = [f64::NEG_INFINITY, f64::INFINITY].map(S::from);
        let (lower, upper) = if *below { (edge, infinite[1]) } else { (infinite[0], edge) };
        let at = Deflection { d: q[0], rate: v[0], lower, upper };
        let one_sided =
            if *below { AsymmetricBacklash::stop_below(0.0) } else { AsymmetricBacklash::stop_above(0.0) };
        let elastic = law.force(i, &one_sided.unwrap(), at) * self.stiffness;
        let force = elastic + law.touch(i, at) * (v[0] - rate) * self.damping;
        let zero = S::from(0.0);
        let (lower_rate, upper_rate) = if *below { (rate, zero) } else { (zero, rate) };
        Contact { deflection: q[0], rate: v[0], lower, upper, lower_rate, upper_rate, force }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [pull] = u.constants();
        a[0] = pull;
        if self.rigid.is_none() {
            for i in 0..self.all.len() {
                a[0] = a[0] - self.contact(law, i, u, q, v).force;
            }
        }
    }
    fn stops(&self) -> &[[bool; 2]] {
        &self.both
    }
    fn impact<S: Scalar>(&self, i: usize, _: Piece, u: Drives<'_, S>, _: &[S], v: &mut [S]) {
        let [_, rate] = u.waves_from::<2>(2 * i);
        v[0] = self.rigid.as_ref().unwrap().rebound(v[0], rate * u.speed());
    }
}

pub(crate) fn wave(mean: f64, cosine: f64, sine: f64, order: usize) -> Wave {
    let mut pairs = vec![[0.0; 2]; order];
    pairs[order - 1] = [cosine, sine];
    Wave::new(Fourier::new(mean, &pairs).unwrap())
}

/// One row for each start (q, v).
fn from_starts(
    machine: &Machine<Stops>,
    starts: &[[f64; 2]],
    periods: usize,
    engine: &impl SweepEngine<Machine<Stops>>,
) -> Rows {
    let points =
        Points::of_rows(&["q", "v"], &starts.iter().map(|start| start.to_vec()).collect::<Vec<_>>()).unwrap();
    let sweep = Sweep::new(points).settle(0).measure(periods).channels(&["q0"]).rattle().strobe(1);
    let start =
        |p: &Point<'_>, _: &Machine<Stops>| Ok::<_, ParameterError>(State::new(0.0, &[p["q"]], &[p["v"]]));
    sweep.of(engine, |_| Ok::<_, ParameterError>(machine.clone())).start(start).run().unwrap()
}

/// A mass at rest and an edge that comes down, overlaps it by δ and leaves.
#[test]
fn an_edge_that_moves_over_a_mass_at_rest() {
    let machine = Stops::machine(&[(false, wave(1.0, 0.0, 1.0, 1))], 0.0, 0.0, 1.0, 0.0);
    let depths = [1e-2, 1e-4, 1e-6, 1e-8];
    let starts: Vec<[f64; 2]> = depths.iter().flat_map(|depth| [[*depth, 0.0], [-depth, 0.0]]).collect();
    let rows = from_starts(&machine, &starts, 5, &LaneTaylor::new(Taylor::new()));
    for (i, depth) in depths.iter().enumerate() {
        // 1 + sin t < q = depth around t = 3π/2 + 2πk, for cos(t - 3π/2) > 1 - depth.
        let half = 2.0 * (0.5 * depth).sqrt().asin();
        let [met, missed] = [2 * i, 2 * i + 1].map(|i| rows.get(i).unwrap().contacts()[0]);
        assert_eq!((met.impacts, missed.impacts), ([0, 5], [0, 0]), "{depth:e}");
        let within = 1e-10 / half + 1e-9;
        assert!((met.time[2] - 2.0 * half / TAU).abs() < within, "{depth:e}: {:e}", met.time[2]);
    }
}

/// A ball that is thrown up to a ceiling and exceeds it by δ, or misses it by δ.
#[test]
fn a_ball_that_grazes_a_ceiling() {
    let machine = Stops::machine(&[(false, Wave::constant(1.0).unwrap())], 1.0, 0.0, TAU / 2.5, -1.0);
    let depths = [1e-3, 1e-5, 1e-7, 1e-9f64];
    let speed = |apex: f64| [0.0, (2.0 * apex).sqrt()];
    let starts: Vec<[f64; 2]> = depths.iter().flat_map(|d| [speed(1.0 + d), speed(1.0 - d)]).collect();
    let rows = from_starts(&machine, &starts, 1, &LaneTaylor::new(Taylor::new()));
    for (i, depth) in depths.iter().enumerate() {
        // In contact x'' = -1 - x from x = 0 with the speed s = √(2δ); x returns to 0 after 2 atan s.
        let time = 2.0 * (2.0 * depth).sqrt().atan() / 2.5;
        let [touch, miss] = [2 * i, 2 * i + 1].map(|i| rows.get(i).unwrap().contacts()[0]);
        assert_eq!((touch.impacts, miss.impacts), ([0, 1], [0, 0]), "{depth:e}");
        assert!(
            (touch.time[2] - time).abs() < 1e-9 + 1e-12 / time,
            "{depth:e}: {:e} {time:e}",
            touch.time[2]
        );
    }
}

/// Balls above a table E sin ωt, at four frequencies: the state at the end of the run, some bounces later, is that of
/// single runs by another method. The motion of the table enters no error estimate.
#[test]
fn a_shaking_table_is_met_at_every_frequency() {
    for order in [1, 10, 100, 1000] {
        let mut random = Random(order as u64);
        let (size, phase) = (0.05, TAU * random.next());
        let table = wave(0.0, size * phase.sin(), size * phase.cos(), order);
        let machine = Stops::machine(&[(true, table)], 1e4, 5.0, 1.0, -1.0);
        let starts: Vec<[f64; 2]> =
            (0..20).map(|_| [0.1 + random.next(), 2.0 * random.next() - 1.0]).collect();
        // One bounce in most runs: an error grows with every bounce.
        let short = machine.with("speed", 1.0).unwrap();
        let lanes = from_starts(&short, &starts, 1, &LaneTaylor::new(Taylor::new()));
        let single = from_starts(&short, &starts, 1, &Located(Taylor::new()));
        let mut impacts = 0;
        for (a, b) in lanes.iter().zip(single.iter()) {
            assert_eq!(a.contacts()[0].impacts, b.contacts()[0].impacts, "{order}");
            impacts += a.contacts()[0].impacts[0];
            let (x, y) = (a.strobes().next().unwrap(), b.strobes().next().unwrap());
            assert!((x[0] - y[0]).abs() < 1e-5, "{order}: {x:?} {y:?}");
        }
        assert!(impacts >= 20, "{order}: {impacts} impacts");
    }
}

/// Several stops whose edges move and jump, elastic and rigid: rows in lanes are those of single runs.
#[test]
fn edges_that_move_and_jump() {
    let jumps = Wave::new(RectangularWave::new(0.8, 1.1, 0.4).unwrap());
    let models = [
        Stops::machine(&[(false, jumps.clone()), (true, wave(-1.0, 0.2, 0.1, 2))], 40.0, 1.0, 1.0, -0.3),
        Stops::machine(
            &[
                (false, wave(0.5, 0.1, 0.0, 3)),
                (false, wave(0.7, 0.0, 0.2, 2)),
                (true, wave(-0.6, 0.3, 0.0, 1)),
            ],
            25.0,
            2.0,
            1.3,
            0.2,
        ),
        Stops::rigid(&[(true, wave(0.0, 0.1, 0.0, 3)), (false, wave(1.2, 0.0, 0.1, 2))], 0.95, 1.0, -0.1),
    ];
    for (k, machine) in models.iter().enumerate() {
        let mut random = Random(k as u64 + 7);
        let starts: Vec<[f64; 2]> = (0..21)
            .map(|_| [0.2 + 0.4 * random.next() - if k < 2 { 0.3 } else { 0.0 }, random.next() - 0.5])
            .collect();
        let lanes = from_starts(machine, &starts, 2, &LaneTaylor::new(Taylor::new()));
        let single = from_starts(machine, &starts, 2, &Located(Taylor::new()));
        assert!(lanes.errors().is_empty() && single.errors().is_empty(), "{k}: {:?}", lanes.errors());
        let mut impacts = 0;
        for (i, (a, b)) in lanes.iter().zip(single.iter()).enumerate() {
            agree(&format!("model {k}, start {i}"), &a, &b, &["q0"], machine.contacts(), 1e-6);
            impacts += (0..machine.contacts()).map(|c| a.contacts()[c].impact_count()).sum::<u64>();
        }
        assert!(impacts > 40, "{impacts} impacts");
    }
}

/// A lane that fails fails alone: its row holds the error, and the bits of the others remain.
#[test]
fn a_lane_that_fails_fails_alone() {
    let escape = Stops::machine(&[(false, Wave::constant(1.0).unwrap())], -50.0, 0.0, 1.0, 0.0);
    let start = |i: usize| [0.1 * i as f64, 0.05];
    let starts: Vec<[f64; 2]> = (0..10).map(start).collect();
    let engine = LaneTaylor::new(Taylor::new().max_steps(400));
    let rows = from_starts(&escape, &starts, 40, &engine);
    let failed: Vec<usize> = rows.errors().keys().copied().collect();
    assert!(!failed.is_empty() && failed.len() <= 10, "{failed:?}");
    for (i, error) in rows.errors() {
        assert!(matches!(error, PointError::Integrate(_)), "{error}");
        let alone = from_starts(&escape, &[start(*i)], 40, &engine);
        assert_eq!(alone.errors()[&0], *error);
    }
    let quiet = Stops::machine(&[(false, Wave::constant(1.0).unwrap())], 50.0, 0.0, 1.0, 0.0);
    let calm = from_starts(&quiet, &starts, 2, &LaneTaylor::new(Taylor::new()));
    // Point 3 starts where no start is allowed.
    let points =
        Points::of_rows(&["q", "v"], &starts.iter().map(|start| start.to_vec()).collect::<Vec<_>>()).unwrap();
    let sweep = Sweep::new(points).settle(0).measure(2).channels(&["q0"]).rattle().strobe(1);
    let begin = |p: &Point<'_>, _: &Machine<Stops>| {
        let q = if p.index() == 3 { f64::INFINITY } else { p["q"] };
        Ok::<_, ParameterError>(State::new(0.0, &[q], &[p["v"]]))
    };
    let engine = LaneTaylor::new(Taylor::new());
    let mixed = sweep.of(&engine, |_| Ok::<_, ParameterError>(quiet.clone())).start(begin).run().unwrap();
    assert_eq!(mixed.errors().keys().collect::<Vec<_>>(), [&3]);
    for i in (0..10).filter(|i| *i != 3) {
        agree("beside a failure", &mixed.get(i).unwrap(), &calm.get(i).unwrap(), &["q0"], 1, 0.0);
    }
}

#[test]
fn shapes_that_lanes_do_not_run_are_refused_by_name() {
    let wave = || Wave::constant(2e8).unwrap();
    let hertz = Mesh::new(wave(), Wave::constant(0.0).unwrap(), PowerLaw::new(1e-5, 1.5, 1e-5).unwrap());
    let params = NfgParams::table1();
    let pair = NfgPair::of_mesh(&params, NfgReading::exact(), hertz).unwrap();
    let sweep = Sweep::new(axis("speed", 100.0, 120.0, 2)).settle(0).measure(1).channels(&["q0"]);
    let start = State::new(0.0, &[-1.5e-3], &[0.0]);
    let refused = rows(&sweep, &LaneTaylor::new(tolerant()), &pair, &start);
    assert_eq!(refused.errors().len(), 2);
    let expected = PointError::NotInLanes { what: "a power of something that varies" };
    assert_eq!(refused.errors()[&0], expected);
    assert!(
        expected.to_string().ends_with("use Located(Taylor::new()), or Located(Dop853::new())"),
        "{expected}"
    );
    for taylor in [Taylor::new().rtol(0.5), Taylor::new().order(3), Taylor::new().atol(0.0)] {
        let family = |p: &Point<'_>| pair.with("speed", p["speed"]);
        let run = sweep.of(&LaneTaylor::new(taylor), family).start(|_, _| start.clone()).run();
        assert!(matches!(run.unwrap_err(), SweepError::Parameter(_)));
    }
    let own = Sweep::new(axis("wc", 0.002, 0.003, 2)).settle(0).measure(1).channels(&["contact"]);
    let family = |p: &Point<'_>| super::lane_taylor::pair().with("wc", p["wc"]);
    let run = own.of(&LaneTaylor::new(tolerant()), family).start(|_, _| Pair::start()).run();
    assert_eq!(run.unwrap_err(), SweepError::Channel { name: "contact".into() });
}

/// A check with a hundredth of the tolerances estimates the error of a row.
#[test]
fn checks_estimate_the_error() {
    let points = axis("wc", 0.15 / 63.0, 0.2 / 63.0, 5);
    let sweep = Sweep::new(points).settle(0).measure(1).channels(&["q0"]).check_every(2);
    let (machine, start) = (pair(), Pair::start());
    let coarse = rows(&sweep, &LaneTaylor::new(Taylor::new().rtol(1e-6).atol(1e-11)), &machine, &start);
    let exact = rows(&sweep, &LaneTaylor::new(Taylor::new().rtol(1e-13).atol(1e-18)), &machine, &start);
    for (i, (a, b)) in coarse.iter().zip(exact.iter()).enumerate() {
        assert_eq!(a.checked().is_some(), i % 2 == 0);
        let (x, y) = (a.channel("q0").unwrap(), b.channel("q0").unwrap());
        let off = [x.mean - y.mean, x.rms - y.rms, x.min - y.min, x.max - y.max];
        let off = off.iter().fold(0.0, |off: f64, x| off.max(x.abs()));
        let estimate = a.step_error("q0").unwrap();
        assert!(off > 1e-14 && estimate < 1e-6, "point {i}: {off:e}, estimate {estimate:e}");
        assert!(
            i % 2 == 1 || (off < 2.0 * estimate && estimate < 10.0 * off),
            "point {i}: {off:e}, {estimate:e}"
        );
    }
}
