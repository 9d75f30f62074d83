//! Contacts: grazing, several at once, in-contact damping, edges without pieces, stalls.

use crate::api::*;
use crate::common::{FreeDeadZone, Impact};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Hides the pieces of a model, so that edges are found by re-stepping.
struct Unheld<M>(M);

impl<M: Model> Model for Unheld<M> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.0.accel(u, q, v, a);
    }
    fn contacts(&self) -> usize {
        self.0.contacts()
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.0.contact(u, q, v, out);
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
    println!("held {a:?}, re-stepped {b:?}, plain {c:?}");
    assert_eq!(held.stats().crossings, unheld.stats().crossings);
    assert!(a.0 < 1e-8 && b.0 < 1e-8);
    assert!(a.1 < c.1);
}

/// A ball thrown up that just does, or just does not, reach a ceiling: q'' = -1 from q = 0 with v, apex v²/2, spring above 1.
struct Thrown;

impl Model for Thrown {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = -1.0 - 1e4 * (q[0] - 1.0).max(0.0);
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        out[0] = Contact { deflection: q[0], rate: v[0], lower: -1e3, upper: 1.0, ..Contact::default() };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) -> bool {
        a[0] = if pieces[0] == Piece::Upper { -1.0 - 1e4 * (q[0] - 1.0) } else { -1.0 };
        true
    }
}

/// The whole flight fits in one step of a method that is exact for parabolas: only a look inside finds the touch.
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

/// Bounce in closed form: contact lasts half a period of the spring with gravity, speed is kept.
#[test]
fn a_short_contact_inside_a_long_step() {
    let (v0, k) = (1.6f64, 1e4f64);
    let start = State::new(0.0, &[0.0], &[v0]);
    // Reaches the ceiling with speed v at t1; in contact x'' = -1 - k x from x = 0.
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
    // From the upper turning point of the shifted spring the contact lasts 2 (π - φ') with φ' on the far side.
    let expected = [contact, 2.0 * (std::f64::consts::PI - phase) / w];
    assert!(
        expected.iter().any(|e| (times[1] - times[0] - e).abs() < 1e-10),
        "{} {expected:?}",
        times[1] - times[0]
    );
}

/// Two equal oscillators cross at the same instant, exactly.
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
        fn contacts(&self) -> usize {
            2
        }
        fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            for i in 0..2 {
                FreeDeadZone { b: 1.0 }.contact(u, &q[i..=i], &v[i..=i], &mut out[i..=i]);
            }
        }
        fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) -> bool {
            for i in 0..2 {
                FreeDeadZone { b: 1.0 }.accel_on_pieces(
                    &pieces[i..=i],
                    u,
                    &q[i..=i],
                    &v[i..=i],
                    &mut a[i..=i],
                );
            }
            true
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

/// Damping only in contact makes the force jump: energy is then lost only there, and the edge is met closely.
#[test]
fn damping_that_acts_only_in_contact() {
    let mesh = |damping| {
        let set = RingSet { half_backlash: 1e-5, motor_torque: 8.0, ..RingSet::set_a(4, 3000.0) };
        let mut params = set.params().unwrap();
        params.meshes = params.meshes.into_iter().map(|mesh| mesh.with_contact_damping(damping)).collect();
        Ring::new(&params).unwrap().in_frame(Frame::Rigid)
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
    assert!(error < 1e-6 && change > 1e-3); // 27 crossings; later on the jumps make the motion sensitive
}

/// Without backlash the two flanks meet: b = 0 is an ordinary linear spring, and the gap is passed in no time.
#[test]
fn no_backlash_is_a_linear_spring() {
    let run = Dop853::new()
        .rtol(1e-12)
        .atol(1e-14)
        .trajectory(&FreeDeadZone { b: 0.0 }, &State::new(0.0, &[1.0], &[0.0]), 10.0)
        .unwrap();
    assert!((run.last().unwrap().q[0] - 10f64.cos()).abs() < 1e-11);
}

/// A contact whose two sides both push across the edge cannot go on: it is named, not looped over.
#[test]
fn a_stall_is_a_typed_error() {
    struct Stuck;
    impl Model for Stuck {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = if q[0] > 0.0 { -1.0 } else { 1.0 };
        }
        fn contacts(&self) -> usize {
            1
        }
        // The rate is wrong on purpose: it says that the deflection always leaves its piece.
        fn contact(&self, _: &[f64], q: &[f64], _: &[f64], out: &mut [Contact]) {
            let rate = if q[0] > 0.0 { -1.0 } else { 1.0 };
            out[0] = Contact { deflection: q[0], rate, lower: 0.0, upper: 0.0, ..Contact::default() };
        }
        fn accel_on_pieces(&self, pieces: &[Piece], _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) -> bool {
            a[0] = if pieces[0] == Piece::Upper { -1.0 } else { 1.0 };
            true
        }
    }
    let failed = Dop853::new().trajectory(&Stuck, &State::new(0.0, &[0.5], &[0.0]), 10.0).unwrap_err();
    assert!(matches!(failed.error, IntegrateError::EdgeStall { contact: 0, .. }), "{}", failed.error);
    assert!(failed.trajectory.len() > 1);
}

/// A ring without torque and all meshes identical stays at rest: the loop is only loaded, W_i = -C e' + K g(-e).
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
            (&ring.shape().meshes()[0], ring.mesh_dampings()[0], ring.mesh_frequency());
        for (i, &t) in times.iter().enumerate() {
            assert!(run.q(i).iter().all(|q| q.abs() < 1e-15), "n = {n}, t = {t}: {:?}", run.q(i));
            let e = mesh.error().jet(omega * t, Side::Before);
            let expected = -damping * omega * e.rate
                + mesh.stiffness().value(omega * t, Side::Before) * mesh.law().at(-e.value);
            for contact in 1..=n {
                let w = run.channel(&ring, &format!("mesh force {contact}")).unwrap()[i];
                assert!((w - expected).abs() < 1e-6, "n = {n}, t = {t}: {w} {expected}");
            }
        }
    }
}

/// An edge just left is not met again: free motion crosses after π in contact and 2b/(A-b) in the gap, in turn, and at no other time.
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
        assert_eq!(seen.len(), 41); // π/2, then 4 and π in turn: 20 whole pairs
        for (i, pair) in seen.windows(2).enumerate() {
            let expected = if i % 2 == 0 { 4.0 } else { std::f64::consts::PI };
            assert!((pair[1].0 - pair[0].0 - expected).abs() < 1e-8, "{i} {pair:?}");
            assert_eq!(pair[0].1.to, pair[1].1.from);
        }
    }
}

/// A clock that has run for thousands of periods is too coarse to meet edges to 1e-10 of the gap: motions are the same all the same, to what
/// a time rounded to t ε moves them by.
#[test]
fn edges_are_met_far_from_time_zero() {
    let params = NfgParams { speed: 180.0, ..NfgParams::table1() };
    let pair = NfgPair::with_reading(&params, NfgReading::published_on_base_radius()).unwrap();
    let solver = Dop853::new().rtol(1e-9).atol_each(&[1e-14, 1e-15]);
    let settled = solver.end(&pair, &pair.static_start().unwrap(), 40.0 * pair.period()).unwrap();
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
    Ring::new(&params).unwrap().in_frame(Frame::Rigid)
}

/// In free flight no force depends on the error excitation: steps grow over many of its periods unless the gap itself limits them. With
/// default settings every edge is met that is met with forty steps to each period of the mesh.
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

/// A mesh that floats in its gap reads the error excitation: RMS 5 µm/√2, peak-to-peak 10 µm.
#[test]
fn a_floating_mesh_reads_its_error_excitation() {
    let ring = loose_ring_of_four(|set| (set.motor_torque, set.load_torque) = (0.0, 0.0));
    let mut statistics = Statistics::new(&ring, &["deflection 2"]).unwrap();
    Dop853::new().run(&ring, &State::at_rest(9), 40.0 * ring.period(), &mut statistics).unwrap();
    let seen = statistics.summary("deflection 2").unwrap();
    println!("{seen:?}");
    assert!((seen.rms - 5e-6 / 2f64.sqrt()).abs() < 1e-9 && (seen.peak_to_peak() - 1e-5).abs() < 1e-9);
}

/// Angles of many radians round the deflections to more than the slack of an edge: motions are the same to that rounding, and no contact
/// stalls.
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
    // A million radians leave 1e-10 rad of the angles: the motion is coarse, and goes on.
    assert!(run(1e6).stats.crossings > 3);
}

/// Two masses whose distance has a gap, far from the origin: R(q1 - q2) = ±b, opened by cos t.
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
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let (deflection, rate) = (0.05 * (q[0] - q[1]), 0.05 * (v[0] - v[1]));
        out[0] = Contact { deflection, rate, lower: -1e-5, upper: 1e-5, ..Contact::default() };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) -> bool {
        let d = 0.05 * (q[0] - q[1]);
        let force = match pieces[0] {
            Piece::Lower => d + 1e-5,
            Piece::Gap => 0.0,
            Piece::Upper => d - 1e-5,
        };
        let force =
            1e3 * force + 5.0 * (v[0] - v[1]) * f64::from(pieces[0] != Piece::Gap) + 1e-2 * u[0].cos();
        a.copy_from_slice(&[-force, force]);
        true
    }
}

/// Rounding of 10⁴ rad moves the deflection of neighbouring coordinates by 1e-13 m, a thousand slacks of the gap: no contact stalls, and as many
/// edges are met as near the origin.
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
        // Fast rotation from the origin comes as far.
        assert_eq!(crossings(0.0, 250.0, apart), near, "{k}");
    }
}

/// A fixed step holds whole periods of the edge and ends at its crests: ends and middle agree with a straight line, and the edge is met all
/// the same.
#[test]
fn an_edge_in_step_with_fixed_steps_is_met() {
    for periods in [1.0, 2.0, 4.0, 6.0, 10.0] {
        let h = 0.01;
        let omega = periods * TAU / h;
        let model = Crest { omega };
        // The gap closes to -E between crests while 1 + E cos ωt - t falls below 1 + E - t.
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
        assert!((touched - t).abs() < 2.0 * step, "{periods} periods a step: {touched} in place of {t}");
    }
}

/// A mass in free flight below an edge at 1 + .05 cos ωt.
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
    fn accel_on_pieces(&self, _: &[Piece], _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) -> bool {
        a[0] = 0.0;
        true
    }
}
