//! `check_model` and `check_periodic` find likely mistakes in a model, have no findings for correct models,
//! and describe each finding in a sentence.

use crate::api::*;
use crate::common::trains::{planetary, planetary_static_start, two_stage, two_stage_turned};
use std::f64::consts::TAU;

/// In static equilibrium the accelerations are zero up to rounding, and the three sun meshes have equal
/// deflections.
#[test]
fn a_planetary_set_at_its_static_start_is_right() {
    let (set, start) = (planetary(), planetary_static_start());
    let mut a = [0.0; 5];
    set.accel(&[0.0, 1.0], &start.q, &start.v, &mut a);
    assert!(a.iter().all(|a| a.abs() < 1e-3), "{a:?}"); // its terms are of the order of 1e8
    assert_eq!(check_periodic(&set, &start), []);
    for (i, share) in [0.3, -0.4, 1.2].into_iter().enumerate() {
        let mut state = start.clone();
        state.q[i] *= 1.0 + 1e-3 * share;
        state.v[i] = share;
        assert_eq!(check_periodic(&set, &state), []);
    }
}

/// A difference by a fraction of 600 rad would cross the gap, and so would rounding of 1e-9 of the terms of
/// the deflection.
#[test]
fn a_train_that_has_turned_far_is_right() {
    for angle in [0.0, 1.0, 600.0, -600.0, 1e4] {
        for pressed in [[2e-6, 4e-6], [-1e-5, 3e-6], [-7e-5, -8e-5]] {
            assert_eq!(
                check_periodic(&two_stage(), &two_stage_turned(angle, pressed)),
                [],
                "{angle} {pressed:?}"
            );
        }
    }
}

/// An acceleration that a closure never writes is no rest.
#[test]
fn an_acceleration_that_is_not_written_is_found() {
    let half = from_fn(2, |_, q, _, a| a[0] = -q[0]).unwrap();
    let state = State::new(0.0, &[0.1, 0.2], &[0.3, 0.4]);
    let found = check_model(&half, &state);
    assert_eq!(found, [Inconsistency::NotFinite { what: "acceleration", index: 1, t: 0.0 }]);
}

/// A model that offers more kinks than it has contacts would lose all of them in its results.
#[test]
fn more_kinks_than_contacts_are_refused() {
    struct Kinked;
    impl Model for Kinked {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = -q[0];
        }
        fn offers(&self) -> Offers<'_> {
            Offers { kinks: 2, ..Offers::default() }
        }
    }
    let error = Dop853::new().end(&Kinked, &State::new(0.0, &[1.0], &[0.0]), 1.0).unwrap_err();
    assert_eq!(error.to_string(), "kinks that the model offers is 2: at most 0 are allowed");
}

/// The mistakes, one at a time, in a pair with damping in contact, a moving gap and a stiffness that jumps.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Slip {
    None,
    /// `next_edge` is missing.
    UnannouncedJump,
    /// The stiffness at a jump is always the one after it.
    SideIgnored,
    /// `redrive` leaves a drive out that changes.
    DriveLeftOut,
    /// `redrive` takes one instant for all rows.
    OneInstant,
    PiecesIgnored,
    NoContacts,
    ForceAtDefault,
    /// The force is K x, without the dead zone.
    ForceWithoutGap,
    /// The force on the lower flank has the wrong sign.
    ForceOfOneSign,
    /// The force does not contain the damping, which jumps at the edge.
    ForceWithoutDamping,
    RateOfWrongSign,
    /// The rates of the edges are zero.
    EdgesAtRest,
    /// The rate of the upper edge is that of the lower one.
    EdgesTogether,
    Period,
}

struct Pair {
    slip: Slip,
    /// Unit of time.
    unit: f64,
}

impl Pair {
    fn law(&self, piece: Piece, u: &[f64], x: f64, rate: f64) -> f64 {
        let edge = match piece {
            Piece::Lower => -u[1],
            Piece::Gap => return 0.0,
            Piece::Upper => u[1],
        };
        u[0] * (x - edge) + 0.3 * rate * self.unit
    }
    fn piece(&self, u: &[f64], x: f64) -> Piece {
        Contact { deflection: x, lower: -u[1], upper: u[1], ..Contact::default() }.piece()
    }
    fn turn(&self, force: f64, u: &[f64], v: &[f64], a: &mut [f64]) {
        (a[0], a[1]) = ((u[3] - force) / 0.7, (force - 0.2 * v[1] * self.unit) / 1.9);
        a.iter_mut().for_each(|a| *a /= self.unit * self.unit);
    }
}

impl Model for Pair {
    fn dof(&self) -> usize {
        2
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let (x, rate) = (q[0] - q[1], v[0] - v[1]);
        self.turn(self.law(self.piece(u, x), u, x, rate), u, v, a);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: self.slip != Slip::NoContacts, ..Offers::default() }
    }
    fn drives(&self) -> usize {
        4
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        let t = t / self.unit;
        let phase = t / TAU;
        // An edge within rounding counts as an edge.
        let ignored = self.slip == Slip::SideIgnored;
        let aside = if side == Side::Before && !ignored { -1e-12 } else { 1e-12 };
        u[0] = if (phase + aside).rem_euclid(1.0) < 0.37 { 1.0 } else { 1.4 };
        (u[1], u[2]) = (0.5 + 0.1 * t.sin(), 0.1 * t.cos() / self.unit);
        u[3] = (if self.slip == Slip::Period { 1.1 } else { 1.0 } * t).cos();
    }
    fn redrive(&self, times: &[f64], side: Side, u: &mut [f64]) {
        for (&t, u) in times.iter().zip(u.chunks_exact_mut(4)) {
            let load = u[3];
            self.drive(if self.slip == Slip::OneInstant { times[0] } else { t }, side, u);
            if self.slip == Slip::DriveLeftOut {
                u[3] = load;
            }
        }
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        let turns = (t / self.unit / TAU).floor();
        let edges = [turns + 0.37, turns + 1.0, turns + 1.37].map(|phase| phase * TAU * self.unit);
        edges.into_iter().find(|edge| *edge > t).filter(|_| self.slip != Slip::UnannouncedJump)
    }
    fn contacts(&self) -> usize {
        if self.slip == Slip::NoContacts { 0 } else { 1 }
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        if self.slip == Slip::NoContacts {
            return;
        }
        let (x, rate) = (q[0] - q[1], v[0] - v[1]);
        let force = self.law(self.piece(u, x), u, x, rate);
        out[0] = Contact {
            deflection: x,
            rate: if self.slip == Slip::RateOfWrongSign { -rate } else { rate },
            lower: -u[1],
            upper: u[1],
            lower_rate: match self.slip {
                Slip::EdgesAtRest => 0.0,
                _ => -u[2],
            },
            upper_rate: match self.slip {
                Slip::EdgesAtRest => 0.0,
                Slip::EdgesTogether => -u[2],
                _ => u[2],
            },
            force: match self.slip {
                Slip::ForceAtDefault => 0.0,
                Slip::ForceWithoutGap => u[0] * x,
                Slip::ForceOfOneSign => force.abs(),
                Slip::ForceWithoutDamping => u[0] * (x - x.clamp(-u[1], u[1])),
                _ => force,
            },
        };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let (x, rate) = (q[0] - q[1], v[0] - v[1]);
        let piece = if self.slip == Slip::PiecesIgnored { self.piece(u, x) } else { pieces[0] };
        self.turn(self.law(piece, u, x, rate), u, v, a);
    }
}

impl Periodic for Pair {
    fn period(&self) -> f64 {
        TAU * self.unit
    }
}

#[test]
fn likely_slips_are_named() {
    for unit in [1.0, 1e-6, 1e5] {
        for (q, v) in [
            ([0.9, 0.1], [0.5, -0.2]),
            ([0.9, 0.1], [0.0, 0.0]),
            ([0.2, 0.1], [0.0, 0.0]),
            ([-0.8, 0.1], [0.1, 0.0]),
        ] {
            let state = State::new(0.4 * unit, &q, &v.map(|v| v / unit));
            let findings = |slip| check_periodic(&Pair { slip, unit }, &state);
            let one = |slip, named: fn(&Inconsistency) -> bool| {
                let found = findings(slip);
                assert!(
                    found.len() == 1 && named(&found[0]),
                    "{slip:?}, unit {unit}, {q:?} {v:?}: {found:?}"
                );
            };
            assert_eq!(findings(Slip::None), [], "unit {unit}, {q:?} {v:?}");
            one(Slip::UnannouncedJump, |f| matches!(f, Inconsistency::UnannouncedJump { drive: 0, .. }));
            one(Slip::SideIgnored, |f| matches!(f, Inconsistency::SideIgnored { drive: 0, .. }));
            one(Slip::DriveLeftOut, |f| matches!(f, Inconsistency::Redrive { drive: 3, .. }));
            one(Slip::OneInstant, |f| matches!(f, Inconsistency::Redrive { .. }));
            one(Slip::PiecesIgnored, |f| matches!(f, Inconsistency::PiecesIgnored { contact: 0, .. }));
            one(Slip::NoContacts, |f| matches!(f, Inconsistency::UndeclaredKink { .. }));
            one(Slip::ForceAtDefault, |f| matches!(f, Inconsistency::NoForce { contact: 0, .. }));
            one(Slip::ForceWithoutGap, |f| matches!(f, Inconsistency::NoForce { contact: 0, .. }));
            one(Slip::ForceOfOneSign, |f| matches!(f, Inconsistency::Force { contact: 0, .. }));
            one(Slip::ForceWithoutDamping, |f| matches!(f, Inconsistency::Force { contact: 0, .. }));
            one(Slip::RateOfWrongSign, |f| matches!(f, Inconsistency::ContactRate { contact: 0, .. }));
            let edges = findings(Slip::EdgesAtRest);
            assert!(
                matches!(
                    edges[..],
                    [Inconsistency::EdgeRate { contact: 0, .. }, Inconsistency::EdgeRate { contact: 0, .. }]
                ),
                "{edges:?}"
            );
            one(Slip::EdgesTogether, |f| matches!(f, Inconsistency::EdgeRate { contact: 0, .. }));
            one(Slip::Period, |f| matches!(f, Inconsistency::Period { what: "acceleration", index: 0, .. }));
        }
    }
}

/// Without a period the unit of time is unknown: a jump is found in any unit.
#[test]
fn unannounced_jumps_are_found_without_a_period() {
    for unit in [1.0, 1e-3, 1e-6, 1e2] {
        let state = State::new(0.4 * unit, &[0.9, 0.1], &[0.5 / unit, 0.0]);
        assert_eq!(check_model(&Pair { slip: Slip::None, unit }, &state), []);
        let found = check_model(&Pair { slip: Slip::UnannouncedJump, unit }, &state);
        assert!(matches!(found[..], [Inconsistency::UnannouncedJump { drive: 0, .. }]), "{unit}: {found:?}");
        let Inconsistency::UnannouncedJump { t, .. } = found[0] else { unreachable!() };
        let phase = (t / unit / TAU).rem_euclid(1.0);
        assert!([0.0, 0.37, 1.0].iter().any(|edge| (phase - edge).abs() < 1e-6), "{unit}: {t}");
    }
}

/// What a model declares and what it implements: each difference is named, and nothing else is reported.
#[test]
fn declared_and_implemented_parts_are_compared() {
    /// A ball over a rigid floor.
    struct Bare;
    /// The same ball with the methods of all parts.
    struct Ball<'s>(Offers<'s>);
    impl Model for Bare {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = -1.0;
        }
        fn offers(&self) -> Offers<'_> {
            all()
        }
        fn contacts(&self) -> usize {
            1
        }
        fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            out[0] = Contact { deflection: q[0], rate: v[0], lower: 0.0, ..Contact::default() };
        }
    }
    impl Model for Ball<'_> {
        fn dof(&self) -> usize {
            Bare.dof()
        }
        fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            Bare.accel(u, q, v, a);
        }
        fn offers(&self) -> Offers<'_> {
            self.0
        }
        fn contacts(&self) -> usize {
            Bare.contacts()
        }
        fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            Bare.contact(u, q, v, out);
        }
        fn accel_on_pieces(&self, _: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            Bare.accel(u, q, v, a);
        }
        fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], _: &[f64], _: &[f64], out: &mut Jacobian) {
            out.q.fill(0.0);
            out.v.fill(0.0);
        }
        fn impact(&self, _: usize, _: Piece, _: &[f64], _: &[f64], v: &mut [f64]) {
            v[0] *= -0.8;
        }
    }
    fn all() -> Offers<'static> {
        Offers { pieces: true, jacobian: true, stops: &[[true, false]], ..Offers::default() }
    }
    let state = State::new(0.0, &[1.0], &[0.0]);
    let found = |model: &dyn Model| -> Vec<String> {
        check_model(model, &state).iter().map(|found| found.to_string()).collect()
    };
    assert_eq!(found(&Ball(all())), [""; 0]);
    let missing = |method| format!("offers: it declares {method}, but the model does not implement {method}");
    assert_eq!(found(&Bare), ["accel_on_pieces", "jacobian", "impact"].map(missing));
    let hidden = [
        Offers { pieces: false, ..all() },
        Offers { jacobian: false, ..all() },
        Offers { stops: &[], ..all() },
    ];
    for (offers, method) in hidden.into_iter().zip(["accel_on_pieces", "jacobian", "impact"]) {
        let said = found(&Ball(offers));
        let expected = format!("offers: the model implements {method}, but does not declare it");
        assert!(said.len() == 1 && said[0].starts_with(&expected), "{said:?}");
    }
    assert_eq!(
        found(&Ball(Offers { stops: &[[true, false]; 3], ..all() })),
        ["offers: it declares stops of 3 contacts, but the model has 1"]
    );
    // A solver says at once that a declared part is missing.
    let failed = Dop853::new().end(&Bare, &state, 1.0).unwrap_err();
    assert!(matches!(failed, IntegrateError::NotANumber { t: 0.0, .. }), "{failed}");
}

/// Smooth laws need no contact: cubic, rounded, Hertzian.
#[test]
fn smooth_laws_are_not_kinks() {
    struct Smooth(fn(f64) -> f64);
    impl Model for Smooth {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = -(self.0)(q[0]);
        }
    }
    let laws: [fn(f64) -> f64; 6] = [
        |x| x + 0.3 * x * x * x,
        |x| SmoothedBacklash::new(1.0, 0.01).unwrap().at(x),
        |x| x.max(0.0).powf(1.5),
        |x| x * x.abs(),
        |x| (40.0 * x).sin(),
        |x| (x / (1.0 + x * x)).exp(),
    ];
    for (i, law) in laws.into_iter().enumerate() {
        for q in [1.7, -0.4, 1e-3] {
            assert_eq!(check_model(&Smooth(law), &State::new(0.0, &[q], &[0.1])), [], "{i} {q}");
        }
    }
}

/// Each sentence names the part of the model to check, with numbers.
#[test]
fn findings_are_sentences() {
    let state = State::new(0.4, &[0.9, 0.1], &[0.5, -0.2]);
    let said = |slip| check_periodic(&Pair { slip, unit: 1.0 }, &state)[0].to_string();
    for (slip, part) in [
        (Slip::UnannouncedJump, "next_edge"),
        (Slip::PiecesIgnored, "accel_on_pieces"),
        (Slip::NoContacts, "contacts()"),
        (Slip::ForceAtDefault, "default 0"),
        (Slip::ForceOfOneSign, "force"),
        (Slip::RateOfWrongSign, "rate"),
        (Slip::EdgesAtRest, "edge"),
        (Slip::Period, "period"),
    ] {
        let sentence = said(slip);
        assert!(
            sentence.contains(part) && sentence.chars().any(|c| c.is_ascii_digit()),
            "{slip:?}: {sentence}"
        );
    }
    let wrong = check_model(&Pair { slip: Slip::None, unit: 1.0 }, &State::at_rest(3));
    assert_eq!(
        wrong[0].to_string(),
        "the typical state has 3 coordinates and 3 velocities, the model 2 degrees of freedom"
    );
}

/// q'' = s(t) - q with a square wave s of period 2 P. Its edges are announced by the floor of t/P, without an
/// allowance for rounding: after some of them the quotient rounds down, and the edge itself is returned
/// again.
struct Square(f64);

impl Model for Square {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = u[0] - q[0];
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        let aside = if side == Side::Before { -1e-9 } else { 1e-9 };
        u[0] = if ((t / self.0 + aside).floor() as i64) % 2 == 0 { 1.0 } else { -1.0 };
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        Some(((t / self.0).floor() + 1.0) * self.0)
    }
}

impl Periodic for Square {
    fn period(&self) -> f64 {
        2.0 * self.0
    }
}

#[test]
fn an_edge_that_rounding_returns_again_is_found() {
    // At 0.1 the 44th edge returns itself, at 0.9 none of 4096 does.
    let start = State::at_rest(1);
    let found = check_periodic(&Square(0.1), &start);
    assert!(
        matches!(found[..], [Inconsistency::DriveEdgeBehind { t, edge }] if t == 4.3 && edge == t),
        "{found:?}"
    );
    assert_eq!(check_periodic(&Square(0.9), &start), []);
}
