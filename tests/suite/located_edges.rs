//! Location of edges: grazing, simultaneous crossings, damping in contact, models without fixed pieces,
//! stalls, moving edges, times and angles far from zero.

use crate::api::*;
use crate::common::{FreeDeadZone, Impact};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// The same model without fixed pieces: edges are found by stepping again.
struct Unheld<M>(M);

impl<M: Model> Model for Unheld<M> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.0.accel(u, q, v, a);
    }
    fn base(&self) -> Option<&dyn Model> {
        Some(&self.0)
    }
}

#[test]
fn without_pieces_edges_are_found_by_re_stepping() {
    let truth = Dop853::new().rtol(1e-13).atol(1e-15).end(&Impact, &Impact::start(), 60.0).unwrap();
    let solver = Dop853::new().rtol(1e-9).atol(1e-11);
    let error = |state: &State| (state.q[0] - truth.q[0]).abs();
    let held = solver.trajectory(&Impact, &Impact::start(), 60.0).unwrap();
    let unheld = solver.trajectory(&Unheld(Impact), &Impact::start(), 60.0).unwrap();
    let plain = solver.clone().plain().trajectory(&Impact, &Impact::start(), 60.0).unwrap();
    let [a, b, c] =
        [&held, &unheld, &plain].map(|run| (error(&run.last().unwrap()), run.stats().evaluations));
    println!("fixed pieces {a:?}, stepped again {b:?}, not located {c:?}");
    assert_eq!(held.stats().crossings, unheld.stats().crossings);
    assert!(a.0 < 1e-8 && b.0 < 1e-8);
    assert!(a.1 < c.1);
}

/// q'' = -1 from q = 0 with the velocity v, below a spring at q = 1. The highest point is v²/2, just below or
/// just above the spring.
struct Thrown;

impl Model for Thrown {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = -1.0 - 1e4 * (q[0] - 1.0).max(0.0);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        out[0] = Contact { deflection: q[0], rate: v[0], lower: -1e3, upper: 1.0, ..Contact::default() };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = if pieces[0] == Piece::Upper { -1.0 - 1e4 * (q[0] - 1.0) } else { -1.0 };
    }
}

/// The whole flight takes one step of a method that is exact for parabolas. The contact is found only by
/// checks inside the step.
#[test]
fn grazing_inside_a_step_is_seen() {
    let crossings = |apex: f64| {
        let start = State::new(0.0, &[0.0], &[(2.0 * apex).sqrt()]);
        let run = Dop853::new().first_step(2.5).trajectory(&Thrown, &start, 2.5).unwrap();
        run.stats().crossings
    };
    assert_eq!(crossings(1.0 - 1e-6), 0);
    assert_eq!(crossings(1.0 + 1e-6), 2);
    assert_eq!(crossings(1.0 + 1e-3), 2);
}

/// A bounce in closed form: the duration of the contact follows from the spring with gravity, and the speed
/// is kept.
#[test]
fn a_short_contact_inside_a_long_step() {
    let (v0, k) = (1.6f64, 1e4f64);
    let start = State::new(0.0, &[0.0], &[v0]);
    // The mass reaches the spring with speed v at t1. In contact x'' = -1 - k x from x = 0.
    let v = (v0 * v0 - 2.0).sqrt();
    let t1 = v0 - v;
    let w = k.sqrt();
    let phase = (v * w).atan2(1.0); // x = -(1/k) + A cos(wt - φ), symmetric about its peak
    let contact = 2.0 * phase / w;
    let mut times = Vec::new();
    Dop853::new()
        .rtol(1e-12)
        .atol(1e-14)
        .first_step(2.0)
        .run(&Thrown, &start, 2.0, &mut |step: &mut Step<'_>| {
            times.extend(step.crossings().iter().map(|_| step.t1()));
            ControlFlow::Continue(())
        })
        .unwrap();
    assert_eq!(times.len(), 2);
    assert!((times[0] - t1).abs() < 1e-11, "{} {t1}", times[0]);
    // The phase of the shifted spring has two branches; the duration is that of one of them.
    let expected = [contact, 2.0 * (std::f64::consts::PI - phase) / w];
    assert!(
        expected.iter().any(|e| (times[1] - times[0] - e).abs() < 1e-10),
        "{} {expected:?}",
        times[1] - times[0]
    );
}

/// Two equal oscillators cross their edges at the same instant.
#[test]
fn contacts_that_cross_together() {
    struct Twins;
    impl Model for Twins {
        fn dof(&self) -> usize {
            2
        }
        fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            let (left, right) = a.split_at_mut(1);
            FreeDeadZone { b: 1.0 }.accel(u, &q[..1], &v[..1], left);
            FreeDeadZone { b: 1.0 }.accel(u, &q[1..], &v[1..], right);
        }
        fn offers(&self) -> Offers<'_> {
            Offers { pieces: true, ..Offers::default() }
        }
        fn contacts(&self) -> usize {
            2
        }
        fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            for i in 0..2 {
                FreeDeadZone { b: 1.0 }.contact(u, &q[i..=i], &v[i..=i], &mut out[i..=i]);
            }
        }
        fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            for i in 0..2 {
                FreeDeadZone { b: 1.0 }.accel_on_pieces(
                    &pieces[i..=i],
                    u,
                    &q[i..=i],
                    &v[i..=i],
                    &mut a[i..=i],
                );
            }
        }
    }
    let start = State::new(0.0, &[3.0, -3.0], &[0.0, 0.0]);
    let mut together = 0;
    let finish = Dop853::new()
        .run(&Twins, &start, 40.0, &mut |step: &mut Step<'_>| {
            assert!(step.crossings().is_empty() || step.crossings().len() == 2);
            together += step.crossings().len() / 2;
            ControlFlow::Continue(())
        })
        .unwrap();
    assert_eq!(finish.stats.crossings, 2 * together as u64);
    assert_eq!(together, 20);
    assert_eq!(finish.state.q[0], -finish.state.q[1]);
}

/// With damping in contact only the force jumps at the edges. The result is accurate and differs from that
/// with permanent damping.
#[test]
fn damping_that_acts_only_in_contact() {
    let mesh = |damping| {
        let set = RingSet { half_backlash: 1e-5, motor_torque: 8.0, ..RingSet::set_a(4, 3000.0) };
        let mut params = set.params().unwrap();
        params.meshes = params.meshes.into_iter().map(|mesh| mesh.with_contact_damping(damping)).collect();
        Ring::new(&params).unwrap().with_frame(Frame::Rigid)
    };
    let in_contact = mesh(ContactDamping::InContact);
    let loose = Dop853::new().rtol(1e-9).atol(1e-13).end(&in_contact, &State::at_rest(9), 0.005).unwrap();
    let tight = Dop853::new().rtol(1e-12).atol_each(&[vec![1e-17; 9], vec![1e-13; 9]].concat());
    let truth = tight.end(&in_contact, &State::at_rest(9), 0.005).unwrap();
    let largest = truth.v.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let error = loose.v.iter().zip(&truth.v).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / largest;
    let always = tight.end(&mesh(ContactDamping::Always), &State::at_rest(9), 0.005).unwrap();
    let change = always.v.iter().zip(&truth.v).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / largest;
    println!("error {error:.1e}, in contact against always {change:.1e}");
    // The run has 27 crossings; later the jumps make the motion sensitive.
    assert!(error < 1e-6 && change > 1e-3);
}

/// Without backlash, b = 0, the contact is a linear spring.
#[test]
fn no_backlash_is_a_linear_spring() {
    let run = Dop853::new()
        .rtol(1e-12)
        .atol(1e-14)
        .trajectory(&FreeDeadZone { b: 0.0 }, &State::new(0.0, &[1.0], &[0.0]), 10.0)
        .unwrap();
    assert!((run.last().unwrap().q[0] - 10f64.cos()).abs() < 1e-11);
}

/// A model whose rate has the wrong sign: the solvers begin behind the edge all the same.
#[test]
fn a_wrong_rate_does_not_stall() {
    struct Stuck;
    impl Model for Stuck {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = if q[0] > 0.0 { -1.0 } else { 1.0 };
        }
        fn offers(&self) -> Offers<'_> {
            Offers { pieces: true, ..Offers::default() }
        }
        fn contacts(&self) -> usize {
            1
        }
        // The rate has the wrong sign on purpose: the deflection always seems to leave its piece.
        fn contact(&self, _: &[f64], q: &[f64], _: &[f64], out: &mut [Contact]) {
            let rate = if q[0] > 0.0 { -1.0 } else { 1.0 };
            out[0] = Contact { deflection: q[0], rate, lower: 0.0, upper: 0.0, ..Contact::default() };
        }
        fn accel_on_pieces(&self, pieces: &[Piece], _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = if pieces[0] == Piece::Upper { -1.0 } else { 1.0 };
        }
    }
    let start = State::new(0.0, &[0.5], &[0.0]);
    // q falls from 1/2, meets the edge at t = 1, 3, 5 .. with the rates -1 and 1 in turn.
    for (t, v) in [(1.0, -1.0), (3.0, 1.0), (5.0, -1.0)] {
        for end in [Rk4::new(0.01).end(&Stuck, &start, t), Dop853::new().end(&Stuck, &start, t)] {
            let end = end.unwrap();
            assert!(end.q[0].abs() < 1e-6 && (end.v[0] - v).abs() < 1e-6, "{end:?}");
        }
    }
}

/// A ring without torques and with equal meshes stays at rest. The meshes are loaded against each other, with
/// the forces W_i = -C e' + K g(-e).
#[test]
fn a_symmetric_ring_stays_at_rest() {
    for (n, half_backlash, error) in [(4, 2.65e-5, 2e-6), (6, 2.65e-6, 1e-5), (3, 1e-5, 1.5e-5)] {
        let set = RingSet {
            motor_torque: 0.0,
            load_torque: 0.0,
            half_backlash,
            error,
            ..RingSet::set_a(n, 2000.0)
        };
        let ring = Ring::as_printed(&set.params().unwrap()).unwrap();
        let times = uniform_times(0.0, 0.01, 200).unwrap();
        let run =
            Dop853::new().rtol(1e-10).atol(1e-16).sample(&ring, &State::at_rest(2 * n + 1), &times).unwrap();
        let (mesh, damping, omega) =
            (&ring.shape().meshes()[0], ring.constant("mesh damping 0").unwrap(), ring.speed());
        for (i, &t) in times.iter().enumerate() {
            assert!(run.q(i).iter().all(|q| q.abs() < 1e-15), "n = {n}, t = {t}: {:?}", run.q(i));
            let e = mesh.error().jet(omega * t, Side::Before);
            let expected = -damping * omega * e.rate
                + mesh.stiffness().value(omega * t, Side::Before) * mesh.law().at(-e.value);
            for contact in 0..n {
                let w = run.channel(&ring, &format!("mesh force {contact}")).unwrap()[i];
                assert!((w - expected).abs() < 1e-6, "n = {n}, t = {t}: {w} {expected}");
            }
        }
    }
}

/// An edge that was just left is not crossed again: free motion crosses after π in contact and after 2b/(A -
/// b) in the gap, alternately, and at no other time.
#[test]
fn an_edge_just_left_is_not_crossed_again() {
    fn crossings(solver: &impl Integrator, model: &impl Model) -> Vec<(f64, Crossing)> {
        let mut seen = Vec::new();
        let start = State::new(0.0, &[1.5], &[0.0]);
        solver
            .run(model, &start, 145.0, &mut |step: &mut Step<'_>| {
                seen.extend(step.crossings().iter().map(|crossing| (step.t1(), *crossing)));
                ControlFlow::Continue(())
            })
            .unwrap();
        seen
    }
    let free = FreeDeadZone { b: 1.0 };
    let (dop853, rk45) = (Dop853::new().rtol(1e-12).atol(1e-14), Rk45::new().rtol(1e-12).atol(1e-14));
    for seen in [
        crossings(&dop853, &free),
        crossings(&dop853, &Unheld(FreeDeadZone { b: 1.0 })),
        crossings(&rk45, &free),
        crossings(&rk45, &Unheld(FreeDeadZone { b: 1.0 })),
        crossings(&Rk4::new(1e-3), &free),
    ] {
        assert_eq!(seen.len(), 41); // π/2, then 4 and π alternately: 20 pairs
        for (i, pair) in seen.windows(2).enumerate() {
            let expected = if i % 2 == 0 { 4.0 } else { std::f64::consts::PI };
            assert!((pair[1].0 - pair[0].0 - expected).abs() < 1e-8, "{i} {pair:?}");
            assert_eq!(pair[0].1.to, pair[1].1.from);
        }
    }
}

/// After thousands of periods the rounding of the time t exceeds the tolerance of locating, 1e-10 of the gap.
/// The motion changes only by the effect of that rounding.
#[test]
fn edges_are_met_far_from_time_zero() {
    let params = NfgParams { speed: 180.0, ..NfgParams::table1() };
    let pair = NfgPair::of_reading(&params, NfgReading::published_on_base_radius()).unwrap();
    let solver = Dop853::new().rtol(1e-9).atol_each(&[1e-14, 1e-15]);
    let settled = solver.end(&pair, &pair.on_drive_flank().unwrap(), 40.0 * pair.period()).unwrap();
    let turn = |k: f64| {
        let start = State { t: k * pair.period(), ..settled.clone() };
        solver.end(&pair, &start, start.t + pair.period()).unwrap().q[0]
    };
    let near = turn(0.0);
    for k in [6_000.0, 20_000.0, 1e6] {
        let off = (turn(k) - near).abs() / near.abs();
        println!("{k}: {off:.1e}");
        assert!(off < 1e-6, "{k}: {off}");
    }
}

/// A ring of four gears with a small torque, phased meshes and damping in contact only.
fn loose_ring_of_four(change: impl FnOnce(&mut RingSet)) -> Ring {
    let mut set = RingSet {
        error: 5e-6,
        motor_torque: 8.0,
        phases: vec![0.0, 1.0, 2.0, 3.0],
        ..RingSet::set_a(4, 12_000.0)
    };
    change(&mut set);
    let mut params = set.params().unwrap();
    params.meshes =
        params.meshes.into_iter().map(|mesh| mesh.with_contact_damping(ContactDamping::InContact)).collect();
    Ring::new(&params).unwrap().with_frame(Frame::Rigid)
}

/// In the gap no force depends on the transmission error. Steps would grow over many of its periods if the
/// moving edges did not limit them. With default settings the solvers find all edges that are found with
/// forty steps a mesh period.
#[test]
fn edges_that_move_faster_than_the_error_estimate_sees() {
    let ring = loose_ring_of_four(|set| set.mesh_damping = 1000.0);
    let mut start = State::at_rest(9);
    start.q[1] = 4e-4;
    let end = 30.0 * ring.period();
    let quiet = || |_: &mut Step<'_>| ControlFlow::Continue(());
    let fine = Dop853::new()
        .rtol(1e-12)
        .atol(1e-15)
        .max_step(ring.period() / 40.0)
        .run(&ring, &start, end, &mut quiet())
        .unwrap();
    assert_eq!(fine.stats.crossings, 24);
    for (name, run) in [
        ("dop853", Dop853::new().run(&ring, &start, end, &mut quiet()).unwrap()),
        ("rk45", Rk45::new().run(&ring, &start, end, &mut quiet()).unwrap()),
        ("rk4", Rk4::new(ring.period() / 100.0).run(&ring, &start, end, &mut quiet()).unwrap()),
    ] {
        let off = (run.state.v[1] - fine.state.v[1]).abs();
        println!(
            "{name}: {} crossings, {} evaluations, v[1] off by {off:.1e}",
            run.stats.crossings, run.stats.evaluations
        );
        assert_eq!(run.stats.crossings, 24, "{name}");
        assert!(off < 1e-5 * fine.state.v[1].abs(), "{name}: {off}");
    }
}

/// The deflection of a mesh that floats in its gap is the transmission error: RMS 5 µm/√2, peak-to-peak value
/// 10 µm.
#[test]
fn a_floating_mesh_reads_its_error_excitation() {
    let ring = loose_ring_of_four(|set| (set.motor_torque, set.load_torque) = (0.0, 0.0));
    let mut statistics = Statistics::new(&ring, &["deflection 1"]).unwrap();
    Dop853::new().run(&ring, &State::at_rest(9), 40.0 * ring.period(), &mut statistics).unwrap();
    let seen = statistics.summary("deflection 1").unwrap();
    println!("{seen:?}");
    assert!((seen.rms - 5e-6 / 2f64.sqrt()).abs() < 1e-9 && (seen.peak_to_peak() - 1e-5).abs() < 1e-9);
}

/// Angles of 10⁴ rad round the deflections to more than the tolerance of an edge. The motion changes only by
/// that rounding, and no contact stalls.
#[test]
fn rings_that_have_turned_far_do_not_stall() {
    let ring = loose_ring_of_four(|_| ());
    let solver = Dop853::new().rtol(1e-9).atol(1e-10);
    let run = |turned: f64| {
        let mut start = State::new(0.0, &[turned; 9], &[0.0; 9]);
        start.q[1] += 4e-4;
        solver
            .run(&ring, &start, 20.0 * ring.period(), &mut |_: &mut Step<'_>| ControlFlow::Continue(()))
            .unwrap()
    };
    let near = run(0.0);
    assert!(near.stats.crossings > 3);
    let far = run(1e4);
    let off = (far.state.q[1] - far.state.q[3] - (near.state.q[1] - near.state.q[3])).abs();
    println!("{:?}, off by {off:.1e}", far.stats);
    assert_eq!(far.stats.crossings, near.stats.crossings);
    assert!(off < 1e-8, "{off}");
    // A million radians leave a resolution of 1e-10 rad: the motion is inaccurate, but the run completes.
    assert!(run(1e6).stats.crossings > 3);
}

/// Two masses with a gap in their distance: 0.05 (q1 - q2) = ±1e-5, driven by cos t.
struct Couple;

impl Model for Couple {
    fn dof(&self) -> usize {
        2
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let mut contact = [Contact::default()];
        self.contact(u, q, v, &mut contact);
        self.accel_on_pieces(&[contact[0].piece()], u, q, v, a);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let (deflection, rate) = (0.05 * (q[0] - q[1]), 0.05 * (v[0] - v[1]));
        out[0] = Contact { deflection, rate, lower: -1e-5, upper: 1e-5, ..Contact::default() };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let d = 0.05 * (q[0] - q[1]);
        let force = match pieces[0] {
            Piece::Lower => d + 1e-5,
            Piece::Gap => 0.0,
            Piece::Upper => d - 1e-5,
        };
        let force =
            1e3 * force + 5.0 * (v[0] - v[1]) * f64::from(pieces[0] != Piece::Gap) + 1e-2 * u[0].cos();
        a.copy_from_slice(&[-force, force]);
    }
}

/// The rounding of 10⁴ rad changes the deflection between neighbouring coordinates by 1e-13 m, a thousand
/// times the tolerance of locating. No contact stalls, and the number of crossings is that near the origin.
#[test]
fn two_coordinates_that_have_turned_far_do_not_stall() {
    let solver = Dop853::new().rtol(1e-9).atol(1e-10);
    let crossings = |turned: f64, spin: f64, apart: f64| {
        let start = State::new(0.0, &[turned + apart, turned], &[spin, spin]);
        solver
            .run(&Couple, &start, 40.0, &mut |_: &mut Step<'_>| ControlFlow::Continue(()))
            .unwrap()
            .stats
            .crossings
    };
    for k in 0..20 {
        let apart = 1e-5 * f64::from(k);
        let near = crossings(0.0, 0.0, apart);
        assert!(near > 5, "{near}");
        assert_eq!(crossings(1e4, 0.0, apart), near, "{k}");
        // A fast rotation from the origin reaches the same angle.
        assert_eq!(crossings(0.0, 250.0, apart), near, "{k}");
    }
}

/// A fixed step contains whole periods of the edge and ends at its crests, so that its ends and its middle
/// agree with a straight line. The edge is located nevertheless.
#[test]
fn an_edge_in_step_with_fixed_steps_is_met() {
    for periods in [1.0, 2.0, 4.0, 6.0, 10.0] {
        let h = 0.01;
        let omega = periods * TAU / h;
        let model = Crest { omega };
        // The first zero of gap(t) = 1 + E cos ωt - t with E = 0.05 lies after t = 1 - E = 0.95.
        let mut touched = f64::NAN;
        let mut watch = |step: &mut Step<'_>| {
            if step.crossings().is_empty() {
                return ControlFlow::Continue(());
            }
            touched = step.t1();
            ControlFlow::Break(())
        };
        Rk4::new(h).run(&model, &State::new(0.0, &[0.0], &[1.0]), 1.2, &mut watch).unwrap();
        let gap = |t: f64| 1.0 + 0.05 * (omega * t).cos() - t;
        let (mut t, step) = (0.94, 1e-4 / omega);
        while gap(t) > 0.0 {
            t += step;
        }
        assert!((touched - t).abs() < 2.0 * step, "{periods} periods a step: {touched} instead of {t}");
    }
}

/// A mass in free flight below an edge at 1 + 0.05 cos ωt.
struct Crest {
    omega: f64,
}

impl Model for Crest {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = 0.0;
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let (s, c) = (self.omega * u[0]).sin_cos();
        let (upper, upper_rate) = (1.0 + 0.05 * c, -0.05 * self.omega * s);
        out[0] = Contact {
            deflection: q[0],
            rate: v[0],
            lower: f64::NEG_INFINITY,
            upper,
            upper_rate,
            ..Contact::default()
        };
    }
    fn accel_on_pieces(&self, _: &[Piece], _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = 0.0;
    }
}
