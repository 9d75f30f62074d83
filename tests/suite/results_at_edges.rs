//! Statistics, sections and rattle at instants at which something jumps: peaks at edges, jumps across a
//! level, gaps without width.

use crate::api::*;
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// x'' = -W with W = k (x - 1) + c x' for x > 1: a mass hits a stop with damping in contact. From x = 0 with
/// x' = 1 the force jumps from 0 to c when the contact begins. If c² > k this is its maximum. It returns to 0
/// before the contact ends.
struct Stop {
    stiffness: f64,
    damping: f64,
    offers_pieces: bool,
}

impl Stop {
    fn force(&self, piece: Piece, q: f64, v: f64) -> f64 {
        if piece == Piece::Upper { self.stiffness * (q - 1.0) + self.damping * v } else { 0.0 }
    }
}

impl Model for Stop {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = -self.force(if q[0] > 1.0 { Piece::Upper } else { Piece::Gap }, q[0], v[0]);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: self.offers_pieces, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let free = Contact { deflection: q[0], rate: v[0], lower: -5.0, upper: 1.0, ..Contact::default() };
        out[0] = Contact { force: self.force(free.piece(), q[0], v[0]), ..free };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = -self.force(pieces[0], q[0], v[0]);
    }
    fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("twice the force", "")]
    }
    fn write_channels(&self, _: &[f64], _: &[f64], _: &[f64], contacts: &[Contact], out: &mut [f64]) {
        out[0] = 2.0 * contacts[0].force;
    }
}

/// The maximum of the force is c x' at the edge itself, with its value on the flank.
#[test]
fn a_force_that_jumps_at_its_edge_is_read_on_its_pieces() {
    for offers_pieces in [true, false] {
        // Without fixed pieces an edge is located to 1e-10 of the gap. Within this distance the force falls
        // by c times as much.
        let met = if offers_pieces { 1e-8 } else { 1e-6 };
        for (stiffness, damping) in [(100.0, 30.0), (4.0, 5.0), (1e4, 300.0)] {
            for speed in [1.0, 0.7, 1.3, 2.1] {
                let model = Stop { stiffness, damping, offers_pieces };
                let mut statistics = Statistics::new(&model, &["mesh force", "twice the force"]).unwrap();
                let start = State::new(0.0, &[0.0], &[speed]);
                Dop853::new().run(&model, &start, 3.0, &mut statistics).unwrap();
                let force = statistics.summary("mesh force").unwrap();
                assert!(
                    (force.max / (damping * speed) - 1.0).abs() < met,
                    "{offers_pieces} {stiffness} {damping} {speed}: {force:?}"
                );
                assert!(
                    (statistics.summary("twice the force").unwrap().max / (2.0 * damping * speed) - 1.0)
                        .abs()
                        < met
                );
            }
        }
    }
}

/// q'' = P cos t - g(q), g the dead zone of half backlash b.
struct Oscillator {
    half_backlash: f64,
    load: f64,
}

impl Model for Oscillator {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
        let b = self.half_backlash;
        a[0] = self.load * u[0].cos() - (q[0] - b).max(0.0) + (-b - q[0]).max(0.0);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let b = self.half_backlash;
        let force = (q[0] - b).max(0.0) - (-b - q[0]).max(0.0);
        out[0] = Contact { deflection: q[0], rate: v[0], lower: -b, upper: b, force, ..Contact::default() };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = self.load * u[0].cos()
            - match pieces[0] {
                Piece::Lower => q[0] + self.half_backlash,
                Piece::Gap => 0.0,
                Piece::Upper => q[0] - self.half_backlash,
            };
    }
}

/// q'' = u with a square wave u whose drive edges are the multiples of 1/2.
struct Switched;

impl Model for Switched {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = u[0];
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        let half = match side {
            Side::Before => (2.0 * t).ceil() - 1.0,
            Side::After => (2.0 * t).floor(),
        };
        u[0] = if half.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        Some(((2.0 * t).floor() + 1.0) / 2.0)
    }
    fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("switch", "1")]
    }
    fn write_channels(&self, u: &[f64], _: &[f64], _: &[f64], _: &[Contact], out: &mut [f64]) {
        out[0] = u[0];
    }
}

fn times<M: Model>(
    model: &M,
    channel: &str,
    level: f64,
    direction: Direction,
    start: &State,
    ends: &[f64],
) -> Vec<f64> {
    let mut section = Section::new(model, channel, level, direction).unwrap();
    let mut state = start.clone();
    for &end in ends {
        state = Dop853::new().rtol(1e-10).atol(1e-12).run(model, &state, end, &mut section).unwrap().state;
    }
    section.states().iter().map(|s| s.t).collect()
}

/// A channel that jumps across the level at a drive edge crosses it there, in one run or in several
/// consecutive runs.
#[test]
fn sections_see_jumps_of_drives() {
    let start = State::at_rest(1);
    for ends in [&[10.25][..], &[0.5, 1.0, 3.2, 10.25]] {
        let both = times(&Switched, "switch", 0.1, Direction::Both, &start, ends);
        assert_eq!(both, (1..=20).map(|i| 0.5 * f64::from(i)).collect::<Vec<_>>());
        assert_eq!(
            times(&Switched, "switch", 0.1, Direction::Rising, &start, ends),
            (1..=10).map(f64::from).collect::<Vec<_>>()
        );
        assert_eq!(times(&Switched, "switch", 0.1, Direction::Falling, &start, ends).len(), 10);
    }
    // A run with another start is a new run: nothing was crossed between the two.
    let mut section = Section::new(&Switched, "switch", 0.1, Direction::Both).unwrap();
    Dop853::new().run(&Switched, &start, 0.25, &mut section).unwrap();
    Dop853::new().run(&Switched, &State::new(0.75, &[0.0], &[0.0]), 0.9, &mut section).unwrap();
    assert!(section.states().is_empty());
}

/// The channel `contact` crosses the level 1/2 at the edges, and a mesh force that jumps crosses any level
/// below its peak.
#[test]
fn sections_see_jumps_at_tooth_edges() {
    let model = Oscillator { half_backlash: 1.0, load: 0.0 };
    // From x = 1.5: π/2 on the first flank, then alternately 4 in the gap and π on a flank.
    let times_of =
        |direction| times(&model, "contact", 0.5, direction, &State::new(0.0, &[1.5], &[0.0]), &[71.0]);
    let lost: Vec<f64> = (0..10).map(|i| 0.5 * PI + f64::from(i) * (PI + 4.0)).collect();
    let made: Vec<f64> = lost.iter().map(|t| t + 4.0).filter(|t| *t < 71.0).collect();
    for (found, expected) in [(times_of(Direction::Falling), &lost), (times_of(Direction::Rising), &made)] {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-7), "{found:?}");
    }
    let stop = Stop { stiffness: 100.0, damping: 30.0, offers_pieces: true };
    for level in [1.0, 20.0, 29.999] {
        let found =
            times(&stop, "mesh force", level, Direction::Rising, &State::new(0.0, &[0.0], &[1.0]), &[3.0]);
        assert!(found.len() == 1 && (found[0] - 1.0).abs() < 1e-9, "{level}: {found:?}");
    }
}

/// Without backlash the teeth never separate, even if the load reverses. The flanks alternate in contact, and
/// there is no impact.
#[test]
fn zero_backlash_does_not_rattle() {
    let solver = Dop853::new().rtol(1e-10).atol(1e-12);
    for load in [0.0, 0.4, 0.9] {
        let model = Oscillator { half_backlash: 0.0, load };
        let mut rattle = Rattle::new(&model);
        solver.run(&model, &State::new(0.3, &[1.0], &[0.2]), 60.0, &mut rattle).unwrap();
        let contact = rattle.contacts()[0];
        assert_eq!(
            (contact.rattle_state(), contact.impact_count(), contact.loss_fraction()),
            (RattleState::None, 0, 0.0),
            "{load}: {contact:?}"
        );
        assert!(contact.time[0] > 10.0 && contact.time[2] > 10.0);
        let mut sampled = Rattle::new(&model);
        solver.clone().plain().run(&model, &State::new(0.3, &[1.0], &[0.2]), 60.0, &mut sampled).unwrap();
        assert_eq!(
            (sampled.contacts()[0].rattle_state(), sampled.contacts()[0].impact_count()),
            (RattleState::None, 0)
        );
    }
    // With the smallest backlash each passage through the gap ends with an impact.
    let model = Oscillator { half_backlash: 1e-6, load: 0.0 };
    let mut rattle = Rattle::new(&model);
    let run = solver.run(&model, &State::new(0.0, &[1.0], &[0.0]), 60.0, &mut rattle).unwrap();
    assert_eq!(
        (rattle.contacts()[0].rattle_state(), rattle.contacts()[0].impact_count()),
        (RattleState::Bilateral, 19)
    );
    assert_eq!(run.stats.crossings, 38);
}

/// A pair without backlash under a small load that reverses: the same with lanes, tables and located edges,
/// and on an orbit of the harmonic balance.
#[test]
fn zero_backlash_does_not_rattle_in_sweeps_and_balances() {
    let make = || {
        NfgPair::new(&NfgParams { half_backlash: 0.0, load_torque: 1.0, speed: 100.0, ..NfgParams::table1() })
    };
    let sweep = Sweep::new(Axis::of_values("one", &[1.0]).unwrap()).settle(1).measure(1).rattle();
    let (family, start) = (|_: &Point<'_>| make(), |_: &Point<'_>, pair: &NfgPair| pair.on_drive_flank());
    let all = [
        sweep.of(&LaneRk4::new(4032).lanes::<4>(), family).start(start).run().unwrap(),
        sweep.of(&TableRk4::new(4032), family).start(start).run().unwrap(),
        sweep.of(&Located(Dop853::new()), family).start(start).run().unwrap(),
    ];
    for rows in &all {
        let (state, contact) =
            (rows.get(0).unwrap().contacts()[0].rattle_state(), rows.get(0).unwrap().contacts()[0]);
        assert!(contact.time[0] > 0.0 && contact.time[2] > 0.0, "the load does not reverse: {contact:?}");
        assert_eq!((state, contact.impact_count()), (RattleState::None, 0), "{contact:?}");
    }
    let (pair, balance) = (make().unwrap(), Balance::new(Harmonics::up_to(70)));
    let contact = &balance.linearised(&pair, Piece::Lower).unwrap().contacts(&pair).unwrap()[0];
    assert!(
        contact.intervals.len() > 2 && contact.intervals.iter().all(|interval| interval.piece != Piece::Gap)
    );
    assert_eq!(
        (contact.statistics.rattle_state(), contact.statistics.impact_count()),
        (RattleState::None, 0)
    );
}

/// A run in two parts counts each crossing once, if it is divided before, on or after the edge.
#[test]
fn an_edge_on_which_a_run_ends_is_counted_once() {
    let model = Oscillator { half_backlash: 1.0, load: 0.0 };
    let solver = Dop853::new().rtol(1e-10).atol(1e-12);
    let start = State::new(0.0, &[1.5], &[0.0]);
    let mut edges = Vec::new();
    let mut watch = |step: &mut Step<'_>| {
        edges.extend(step.crossings().iter().map(|_| step.t1()));
        ControlFlow::Continue(())
    };
    let whole = solver.run(&model, &start, 30.0, &mut watch).unwrap().stats.crossings;
    assert_eq!((whole, edges.len()), (8, 8));
    for &edge in &edges {
        for off in [-1e-6, -1e-10, -1e-12, 0.0, 1e-12, 1e-10, 1e-6] {
            let mut seen = 0;
            let mut watch = |step: &mut Step<'_>| {
                seen += step.crossings().len() as u64;
                ControlFlow::Continue(())
            };
            let first = solver.run(&model, &start, edge + off, &mut watch).unwrap();
            let second = solver.run(&model, &first.state, 30.0, &mut watch).unwrap();
            assert_eq!(
                (first.stats.crossings + second.stats.crossings, seen),
                (whole, whole),
                "{edge} {off}"
            );
        }
    }
}

/// A free mass, whose steps nothing limits, with a channel that swings: 0.3 q + cos 2t.
struct Swinging;

impl Model for Swinging {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = 0.0;
    }
    fn drive(&self, t: f64, _: Side, u: &mut [f64]) {
        u[0] = (2.0 * t).cos();
    }
    fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("swing", "1")]
    }
    fn write_channels(&self, u: &[f64], q: &[f64], _: &[f64], _: &[Contact], out: &mut [f64]) {
        out[0] = 0.3 * q[0] + u[0];
    }
}

/// Statistics divide steps in which a channel swings: the solver does not see the channel.
#[test]
fn statistics_of_a_channel_that_swings_within_steps() {
    for (until, first) in [(20.0, 0.1), (20.0, 1.0), (33.0, 5.0)] {
        let mut statistics = Statistics::new(&Swinging, &["swing"]).unwrap();
        let start = State::new(0.0, &[1.0], &[0.0]);
        let solver = Dop853::new().first_step(first);
        solver.run(&Swinging, &start, until, &mut statistics).unwrap();
        let summary = statistics.summary("swing").unwrap();
        let mean = 0.3 + 0.5 * (2.0 * until).sin() / until;
        // (0.3 + cos 2t)² = 0.09 + 0.6 cos 2t + (1 + cos 4t)/2
        let square = 0.59 + 0.3 * (2.0 * until).sin() / until + 0.125 * (4.0 * until).sin() / until;
        assert!((summary.mean - mean).abs() < 3e-8, "{} {mean}", summary.mean);
        assert!((summary.rms - square.sqrt()).abs() < 3e-8, "{} {}", summary.rms, square.sqrt());
        assert!((summary.max - 1.3).abs() < 1e-9 && (summary.min + 0.7).abs() < 1e-9, "{summary:?}");
    }
}

/// q = cos t, with the channel cos nq, which swings up to n times in a radian.
struct Wound {
    swing: models::Oscillator,
    n: f64,
}

impl Wound {
    fn new(n: f64) -> Self {
        Wound { swing: models::Oscillator::new(&[("speed", 1.0), ("linear stiffness", 1.0)]).unwrap(), n }
    }
}

impl Model for Wound {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.swing.accel(u, q, v, a);
    }
    fn offers(&self) -> Offers<'_> {
        self.swing.offers()
    }
    fn base(&self) -> Option<&dyn Model> {
        Some(&*self.swing)
    }
    fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("wound", "1")]
    }
    fn write_channels(&self, _: &[f64], q: &[f64], _: &[f64], _: &[Contact], out: &mut [f64]) {
        out[0] = (self.n * q[0]).cos();
    }
}

/// The reference is a sum of many samples of the closed form.
#[test]
fn statistics_and_sections_of_a_channel_that_swings_many_times_in_a_step() {
    let until = 30.0;
    for n in [5.3, 12.0, 20.0, 33.6, 44.0, 60.0] {
        let model = Wound::new(n);
        let wound = |k: u32| (n * (until * (f64::from(k) + 0.5) / 3e5).cos()).cos();
        let mean = (0..300_000).map(wound).sum::<f64>() / 3e5;
        let square = (0..300_000).map(|k| wound(k).powi(2)).sum::<f64>() / 3e5;
        let signs: Vec<bool> = (0..300_000).map(|k| wound(k) < 0.0).collect();
        let crossings = signs.windows(2).filter(|two| two[0] != two[1]).count();
        let solvers: [&dyn Integrator; 3] =
            [&Taylor::new(), &Taylor::new().rtol(1e-12), &Dop853::new().rtol(1e-12).atol(1e-12)];
        for solver in solvers {
            let mut statistics = Statistics::new(&model, &["wound"]).unwrap();
            let mut section = Section::new(&model, "wound", 0.0, Direction::Both).unwrap();
            let mut both = (&mut statistics, &mut section);
            solver.run(&model, &State::new(0.0, &[1.0], &[0.0]), until, &mut both).unwrap();
            let found = statistics.summary("wound").unwrap();
            assert!((found.mean - mean).abs() < 2e-7, "{n}: {} {mean}", found.mean);
            assert!((found.rms - square.sqrt()).abs() < 2e-7, "{n}: {} {}", found.rms, square.sqrt());
            assert!(found.max > 1.0 - 1e-8 && found.min < 1e-8 - 1.0, "{n}: {found:?}");
            assert_eq!(section.states().len(), crossings, "{n}");
        }
    }
}

/// cos t comes to a level just below 1 and turns back: two crossings that lie close together, once a turn.
#[test]
fn sections_see_crossings_close_together() {
    let spring = models::Oscillator::new(&[("speed", 1.0), ("linear stiffness", 1.0)]).unwrap();
    for level in [0.5, 0.99, 0.995, 0.999, 0.9999, -0.999] {
        let solvers: [&dyn Integrator; 5] = [
            &Taylor::new(),
            &Taylor::new().rtol(1e-12),
            &Dop853::new().rtol(1e-9).atol(1e-9),
            &Dop853::new().rtol(1e-7).atol(1e-7),
            &Rk4::new(std::f64::consts::TAU / 64.0),
        ];
        for (i, solver) in solvers.into_iter().enumerate() {
            let mut section = Section::new(&spring, "q0", level, Direction::Both).unwrap();
            let start = State::new(0.0, &[(0.5f64).cos()], &[-(0.5f64).sin()]);
            solver.run(&spring, &start, 20.0 * std::f64::consts::TAU, &mut section).unwrap();
            assert_eq!(section.states().len(), 40, "{level}, solver {i}");
        }
    }
}
