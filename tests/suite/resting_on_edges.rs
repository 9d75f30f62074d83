//! Motions that rest on the edge of a gap without width: an unloaded train without backlash is a spring.

use crate::api::*;
use crate::lane_taylor::{axis, rows};
use gear_dynamics::linear::Modes;
use gear_dynamics::models::Oscillator;
use std::f64::consts::TAU;

#[test]
fn an_unloaded_contact_without_backlash_is_a_spring() {
    let (speed, damping, stiffness): (f64, f64, f64) = (0.7, 0.1, 2.0);
    let constants = [
        ("speed", speed),
        ("damping", damping),
        ("mesh stiffness", stiffness),
        ("half backlash", 0.0),
        ("force", 0.0),
    ];
    let model = Oscillator::new(&constants).unwrap();
    // λ² + cλ + s = 0.
    let frequency = (stiffness - 0.25 * damping * damping).sqrt();
    let turn = TAU / speed;
    let expected = num_complex::Complex64::from_polar((-0.5 * damping * turn).exp(), frequency * turn);
    let close = |found: &Multipliers| {
        for z in found.values() {
            let off = (z - expected).norm().min((z - expected.conj()).norm());
            assert!(off < 1e-9, "{z} for {expected}");
        }
    };
    let rest = State::at_rest(1);
    close(Shooting::new().solve(&model, &rest).unwrap().multipliers());
    let balance = Balance::new(Harmonics::up_to(5));
    let orbit = FourierOrbit::new(balance.harmonics(), model.period(), &[vec![0.0; 11]]).unwrap();
    close(&balance.multipliers(&model, &orbit).unwrap());
    let modes = Modes::about(&model, &rest, None).unwrap();
    assert!((modes.all()[0].square() - stiffness).abs() < 1e-12);
    let exponents = Lyapunov::new().settle(0).align(5).measure(20).run(&model, &rest).unwrap();
    // Their sum is the divergence, at any length of the run.
    assert!((exponents.values().iter().sum::<f64>() + damping).abs() < 1e-9);
}

/// A mass without load on one contact with the edges ±b and flanks of these stiffnesses and dampings.
struct Unloaded {
    b: f64,
    stiffness: [f64; 2],
    damping: [f64; 2],
}

impl Model for Unloaded {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let piece = if q[0] > self.b {
            Piece::Upper
        } else if q[0] < -self.b {
            Piece::Lower
        } else {
            Piece::Gap
        };
        self.accel_on_pieces(&[piece], u, q, v, a);
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        out[0] =
            Contact { deflection: q[0], rate: v[0], lower: -self.b, upper: self.b, ..Contact::default() };
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn accel_on_pieces(&self, pieces: &[Piece], _u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = match pieces[0] {
            Piece::Lower => -self.stiffness[0] * (q[0] + self.b) - self.damping[0] * v[0],
            Piece::Gap => 0.0,
            Piece::Upper => -self.stiffness[1] * (q[0] - self.b) - self.damping[1] * v[0],
        };
    }
}

impl Periodic for Unloaded {
    fn period(&self) -> f64 {
        3.0
    }
}

/// Where the slopes of both sides of the edge differ, the motion that rests there has two one-sided derivatives: a refusal by
/// name, from every method. Where they agree it has one.
#[test]
fn a_contact_that_rests_where_slopes_jump_is_refused_by_name() {
    let balance = Balance::new(Harmonics::up_to(5));
    let cases = [
        (0.0, [2.0, 2.0], [0.1, 0.1], false),
        (0.0, [1.0, 2.0], [0.1, 0.1], true),
        (0.0, [2.0, 2.0], [0.1, 0.0], true),
        (1.0, [2.0, 2.0], [0.1, 0.1], true),
    ];
    for (b, stiffness, damping, refused) in cases {
        let model = Unloaded { b, stiffness, damping };
        let rest = State::new(0.0, &[b], &[0.0]);
        let orbit =
            FourierOrbit::new(balance.harmonics(), model.period(), &[[&[b], &[0.0; 10][..]].concat()])
                .unwrap();
        let shot = Shooting::new().solve(&model, &rest);
        let exponents = Lyapunov::new().settle(0).align(5).measure(20).run(&model, &rest);
        let by_series = balance.multipliers(&model, &orbit);
        let varied = Variation::new().run(&model, &rest, 3.0);
        if refused {
            assert!(shot.unwrap_err().to_string().contains("rests on an edge of its gap"));
            assert!(exponents.unwrap_err().to_string().contains("rests on an edge of its gap"));
            assert!(matches!(by_series, Err(MultiplierError::RestsOnEdge { contact: 0 })), "{by_series:?}");
            assert!(matches!(varied, Err(IntegrateError::RestsOnEdge { t: 0.0, contact: 0 })), "{varied:?}");
        } else {
            assert!(shot.is_ok() && exponents.is_ok() && by_series.is_ok() && varied.is_ok());
        }
    }
    // A motion that only starts on the edge has a derivative.
    let model = Unloaded { b: 0.0, stiffness: [1.0, 2.0], damping: [0.1; 2] };
    assert!(Variation::new().run(&model, &State::new(0.0, &[0.0], &[0.3]), 3.0).is_ok());
}

/// A mass without load on flanks of the slopes 1 and 2, as a shape.
#[derive(PartialEq)]
struct Uneven;

impl Nonlinearity for Uneven {
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
        (at.d - at.upper).max(S::from(0.0)) * 2.0 + (at.d - at.lower).min(S::from(0.0))
    }
    fn force_on<S: Scalar>(&self, piece: Piece, _: &[Piece], at: Deflection<S>) -> S {
        match piece {
            Piece::Upper => (at.d - at.upper) * 2.0,
            Piece::Gap => S::from(0.0),
            Piece::Lower => at.d - at.lower,
        }
    }
}

#[derive(PartialEq)]
struct UnevenMass;

impl Shape for UnevenMass {
    fn size(&self) -> Size {
        Size { dof: 1, contacts: 1, constants: 2, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "damping"].map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, _: A, _: Side, _: &mut [A::Number]) {}
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        _: usize,
        _: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let zero = S::from(0.0);
        let force = law.force(0, &Uneven, Deflection { d: q[0], rate: v[0], lower: zero, upper: zero });
        Contact { deflection: q[0], rate: v[0], lower: zero, upper: zero, force, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [damping] = u.constants();
        a[0] = -self.contact(law, 0, u, q, v).force - damping * v[0];
    }
}

/// Exponents in lanes refuse the motion at rest as single runs do.
#[test]
fn lanes_refuse_a_contact_that_rests_where_slopes_jump() {
    let machine = Machine::of_constants(UnevenMass, &[("speed", 2.0), ("damping", 0.1)]).unwrap();
    let rest = State::at_rest(1);
    let settings = Lyapunov::new().settle(0).align(3).measure(5);
    let single = settings.clone().run(&machine, &rest).unwrap_err().to_string();
    assert!(single.contains("rests on an edge of its gap"), "{single}");
    let sweep =
        Sweep::new(axis("damping", 0.1, 0.2, 3)).settle(1).measure(1).channels(&["q0"]).lyapunov(settings);
    let rows = rows(&sweep, &LaneTaylor::new(Taylor::new()), &machine, &rest);
    assert_eq!(rows.exponent_errors().len(), 3);
    for error in rows.exponent_errors().values() {
        assert!(error.to_string().contains("rests on an edge of its gap"), "{error}");
    }
}
