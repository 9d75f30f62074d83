//! `check_model` and `check_periodic`: the models of the crate have no findings, and each flaw of a model has
//! its own.

use crate::api::*;

fn on_flank(pair: &NfgPair, t: f64) -> State {
    let start = pair.on_drive_flank().unwrap();
    State::new(t, &[1.3 * start.q[0]], &[1e-6])
}

#[test]
fn every_reading_of_the_pair() {
    for radius in [Radius::Pitch, Radius::Base] {
        for half_backlash in [HalfBacklash::Mean, HalfBacklash::Instant] {
            for error_forcing in [ErrorForcing::MeanRadius, ErrorForcing::Frozen, ErrorForcing::Exact] {
                for centre_forcing in
                    [CentreForcing::Series(2), CentreForcing::Series(5), CentreForcing::Exact]
                {
                    for damping in [Damping::ConstantRatio, Damping::ConstantCoefficient] {
                        let reading =
                            NfgReading { radius, half_backlash, error_forcing, centre_forcing, damping };
                        let pair =
                            NfgPair::of_reading(&NfgParams { error: 2e-6, ..NfgParams::table1() }, reading)
                                .unwrap();
                        for t in [3.0, 700.0, 1500.0] {
                            assert_eq!(check_periodic(&pair, &on_flank(&pair, t)), [], "{reading:?}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn the_other_models() {
    let two = NfgPair2::new(&NfgParams::table1(), 0.01).unwrap();
    let mut state = two.on_drive_flank().unwrap();
    state.q[1] *= 1.4;
    state.v[0] = 0.3;
    assert_eq!(check_periodic(&two, &state), []);
    for frame in [Frame::Inertial, Frame::Rigid] {
        let set = RingSet { phases: vec![0.0, 0.4, 1.1, 2.2], ..RingSet::set_a(4, 1000.0) };
        let ring = Ring::new(&set.params().unwrap()).unwrap().with_frame(frame);
        let q: Vec<f64> = (0..9).map(|i| 2e-3 * (1.3 * f64::from(i)).sin()).collect();
        let v: Vec<f64> = (0..9).map(|i| 0.5 * (0.7 * f64::from(i)).cos()).collect();
        assert_eq!(check_periodic(&ring, &State::new(1.234e-4, &q, &v)), []);
    }
}

/// The centre forcing by a series: 60 orders agree with the exact forcing, and order 3 adds its term.
#[test]
fn two_terms_are_the_series_of_order_two() {
    let params = NfgParams::table1();
    let force = |pair: &NfgPair, t: f64| {
        let (mut u, mut a) = (vec![0.0; pair.drives()], [0.0]);
        pair.drive(t, Side::After, &mut u);
        pair.accel(&u, &[0.0], &[0.0], &mut a);
        a[0]
    };
    let with = |order| {
        let reading = NfgReading { centre_forcing: CentreForcing::Series(order), ..NfgReading::exact() };
        NfgPair::of_reading(&params, reading).unwrap()
    };
    let exact = NfgPair::new(&params).unwrap();
    for t in [10.0, 500.0, 1234.0] {
        assert!((force(&with(60), t) - force(&exact, t)).abs() < 1e-18);
        let third = force(&with(3), t) - force(&with(2), t);
        let x = exact.speed() * t;
        let expected = 2.0 * exact.speed().powi(2) * 3.0 * (-0.2f64).powi(3) * (3.0 * x).sin();
        assert!((third - expected).abs() < 1e-18);
    }
}

/// The flaws, one at a time.
#[derive(Clone, Copy, PartialEq)]
enum Wrong {
    Nothing,
    Period,
    Rate,
    EdgeRate,
    Edge,
    Pieces,
    Jump,
    Nan,
}

/// x'' = cos t - 0.1 x' - g(x), the gap from -b to b with b = 1 + 0.2 sin t, with one flaw.
struct Flawed(Wrong);

impl Model for Flawed {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = u[0] - 0.1 * v[0] - (q[0] - u[1]).max(0.0) + (-u[1] - q[0]).max(0.0);
        if self.0 == Wrong::Nan {
            a[0] = f64::NAN;
        }
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn drives(&self) -> usize {
        3
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        let w = if self.0 == Wrong::Period { 1.1 } else { 1.0 };
        u[0] = (w * t).cos() + if self.0 == Wrong::Jump && side == Side::Before { 1.0 } else { 0.0 };
        u[1] = 1.0 + 0.2 * t.sin();
        u[2] = 0.2 * t.cos();
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let b = if self.0 == Wrong::Edge { 0.7 * u[1] } else { u[1] };
        let scale = if self.0 == Wrong::Edge { 0.7 } else { 1.0 };
        let edge_rate = if self.0 == Wrong::EdgeRate { 0.0 } else { scale * u[2] };
        let rate = if self.0 == Wrong::Rate { -v[0] } else { v[0] };
        let force = (q[0] - b).max(0.0) - (-b - q[0]).max(0.0);
        out[0] = Contact {
            deflection: q[0],
            rate,
            lower: -b,
            upper: b,
            lower_rate: -edge_rate,
            upper_rate: edge_rate,
            force,
        };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let f = match pieces[0] {
            Piece::Lower => q[0] + u[1],
            Piece::Gap => 0.0,
            Piece::Upper => q[0] - u[1],
        };
        a[0] = u[0] - 0.1 * v[0] - if self.0 == Wrong::Pieces { 1.1 * f } else { f };
    }
}

impl Periodic for Flawed {
    fn period(&self) -> f64 {
        std::f64::consts::TAU
    }
}

/// The same model in another unit of time, τ = unit t.
struct InUnit {
    model: Flawed,
    unit: f64,
}

impl Model for InUnit {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.model.accel(u, q, &[v[0] * self.unit], a);
        a[0] /= self.unit * self.unit;
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn drives(&self) -> usize {
        3
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.model.drive(t / self.unit, side, u);
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.model.contact(u, q, v, out);
        out[0].lower_rate /= self.unit;
        out[0].upper_rate /= self.unit;
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.model.accel_on_pieces(pieces, u, q, &[v[0] * self.unit], a);
        a[0] /= self.unit * self.unit;
    }
}

impl Periodic for InUnit {
    fn period(&self) -> f64 {
        self.unit * self.model.period()
    }
}

fn findings(wrong: Wrong, unit: f64) -> Vec<Inconsistency> {
    check_periodic(&InUnit { model: Flawed(wrong), unit }, &State::new(0.4 * unit, &[1.7], &[0.5 / unit]))
}

#[test]
fn each_flaw_is_named() {
    for unit in [1.0, 1e-9, 1e9] {
        let findings = |wrong| findings(wrong, unit);
        assert_eq!(findings(Wrong::Nothing), []);
        assert!(matches!(
            findings(Wrong::Period)[..],
            [Inconsistency::Period { what: "acceleration", index: 0, .. }]
        ));
        assert!(matches!(
            findings(Wrong::Edge)[..],
            [Inconsistency::Kink { contact: 0, .. }, Inconsistency::Kink { contact: 0, .. }]
        ));
        assert!(matches!(findings(Wrong::Pieces)[..], [Inconsistency::Pieces { component: 0, .. }]));
        assert!(matches!(findings(Wrong::Jump)[0], Inconsistency::UnannouncedJump { drive: 0, .. }));
        assert!(matches!(
            findings(Wrong::Nan)[0],
            Inconsistency::NotFinite { what: "acceleration", index: 0, .. }
        ));
    }
}

/// Rates are compared over parts of the period, so that the unit of time does not matter.
#[test]
fn wrong_rates_are_named() {
    for unit in [1.0, 1e-9, 1e9] {
        assert!(matches!(findings(Wrong::Rate, unit)[..], [Inconsistency::ContactRate { contact: 0, .. }]));
        assert!(matches!(findings(Wrong::EdgeRate, unit)[0], Inconsistency::EdgeRate { contact: 0, .. }));
    }
}

/// The rate of an error of transmission e cos t is left out: at t = 0 nothing shows it.
#[test]
fn wrong_rates_are_named_where_a_cosine_hides_them() {
    struct Hidden;
    impl Model for Hidden {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = 0.1 - (q[0] - u[0] - 1.0).max(0.0) + (-q[0] + u[0] - 1.0).max(0.0);
        }
        fn drives(&self) -> usize {
            1
        }
        fn drive(&self, t: f64, _: Side, u: &mut [f64]) {
            u[0] = 0.3 * t.cos();
        }
        fn contacts(&self) -> usize {
            1
        }
        fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            let x = q[0] - u[0];
            let force = (x - 1.0).max(0.0) - (-x - 1.0).max(0.0);
            let (lower, upper) = (-1.0, 1.0);
            out[0] = Contact { deflection: x, rate: v[0], lower, upper, force, ..Contact::default() };
        }
    }
    impl Periodic for Hidden {
        fn period(&self) -> f64 {
            std::f64::consts::TAU
        }
    }
    for start in [State::new(0.0, &[1.4], &[0.0]), State::new(0.0, &[1.4], &[0.3])] {
        for findings in [check_periodic(&Hidden, &start), check_model(&Hidden, &start)] {
            assert!(matches!(findings[..], [Inconsistency::ContactRate { contact: 0, .. }]), "{findings:?}");
        }
    }
}

/// One contact between two masses: the check compares its force with one of the two accelerations, the same
/// at both edges.
#[test]
fn two_masses_on_one_contact_are_consistent() {
    struct Two([f64; 2]);
    impl Two {
        fn force(q: &[f64], piece: Option<Piece>) -> f64 {
            let (x, b) = (q[0] - q[1], 2e-5);
            let piece = piece.unwrap_or(if x > b {
                Piece::Upper
            } else if x < -b {
                Piece::Lower
            } else {
                Piece::Gap
            });
            3e8 * match piece {
                Piece::Lower => x + b,
                Piece::Gap => 0.0,
                Piece::Upper => x - b,
            }
        }
        fn turn(&self, w: f64, a: &mut [f64]) {
            (a[0], a[1]) = ((1200.0 - w) / self.0[0], (w - 1200.0) / self.0[1]);
        }
    }
    impl Model for Two {
        fn dof(&self) -> usize {
            2
        }
        fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            self.turn(Two::force(q, None), a);
        }
        fn offers(&self) -> Offers<'_> {
            Offers { pieces: true, ..Offers::default() }
        }
        fn accel_on_pieces(&self, pieces: &[Piece], _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            self.turn(Two::force(q, Some(pieces[0])), a);
        }
        fn contacts(&self) -> usize {
            1
        }
        fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            let (lower, upper, force) = (-2e-5, 2e-5, Two::force(q, None));
            out[0] = Contact {
                deflection: q[0] - q[1],
                rate: v[0] - v[1],
                lower,
                upper,
                force,
                ..Contact::default()
            };
        }
    }
    for masses in [[0.6, 1.24444], [0.6, 0.9], [1.3, 0.7], [0.5, 2.0], [1.0, 1.0]] {
        for k in 0..40 {
            let start = State::new(0.0, &[2.3e-5 + 1e-7 * f64::from(k), 0.0], &[0.0, 0.0]);
            assert_eq!(check_model(&Two(masses), &start), [], "{masses:?} {k}");
        }
    }
}
