//! Rows and results that are kept after an error; standard deviations beside a large mean; contact laws with
//! a stop on one side.

use crate::api::*;
use crate::common::stored;

/// x'' + 0.3 x' + k x = cos t. With `no_slope` the Jacobian is NaN, so that the variational equations fail.
struct Swing {
    stiffness: f64,
    no_slope: bool,
}

impl Model for Swing {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = u[0].cos() - 0.3 * v[0] - self.stiffness * q[0];
    }
    fn offers(&self) -> Offers<'_> {
        Offers { jacobian: true, ..Offers::default() }
    }
    fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], _: &[f64], _: &[f64], out: &mut Jacobian) {
        out.q[0] = if self.no_slope { f64::NAN } else { -self.stiffness };
        out.v[0] = -0.3;
    }
}

impl Periodic for Swing {
    fn period(&self) -> f64 {
        std::f64::consts::TAU
    }
}

fn family(p: &Point<'_>) -> Result<Swing, ParameterError> {
    Ok(Swing { stiffness: p["k"], no_slope: p.index() == 1 })
}
fn rest(_: &Point<'_>, _: &Swing) -> Result<State, ParameterError> {
    Ok(State::at_rest(1))
}
fn points() -> Points {
    Points::from(Axis::of_values("k", &[2.0, 3.0, 4.0]).unwrap())
}
fn sweep() -> Sweep {
    Sweep::new(points()).settle(3).measure(2).channels(&["q0"])
}

#[test]
fn a_row_without_an_exponent_keeps_its_other_figures() {
    let asked = sweep().lyapunov(Lyapunov::new().align(1).measure(2).flow_tolerance(1e-6));
    let rows = asked.of(&TableRk4::new(128), family).start(rest).run().unwrap();
    let plain = sweep().of(&TableRk4::new(128), family).start(rest).run().unwrap();
    assert!(rows.is_complete() && rows.errors().is_empty() && rows == rows.clone());
    assert_eq!(rows.exponent_errors().keys().copied().collect::<Vec<_>>(), [1]);
    for (row, other) in rows.iter().zip(plain.iter()) {
        assert_eq!(row.channel("q0"), other.channel("q0"));
        assert_eq!(
            (row.lyapunov().is_none(), row.lyapunov_standard_error().is_none()),
            (row.index() == 1, row.index() == 1)
        );
        assert_eq!(rows.exponent_errors().contains_key(&row.index()), row.index() == 1);
    }
    assert!(matches!(rows.exponent_errors()[&1], PointError::Lyapunov(_)), "{:?}", rows.exponent_errors());
    // The same after storing, in chunks and resumed.
    let back = stored(&rows);
    assert_eq!(back.fingerprint(), rows.fingerprint());
    assert_eq!(back.exponent_errors()[&1].to_string(), rows.exponent_errors()[&1].to_string());
    let parts = (0..3).map(|i| asked.of(&TableRk4::new(128), family).start(rest).chunk(i, 3).unwrap());
    let merged = Rows::merge(parts.collect()).unwrap();
    assert_eq!((&merged, merged.fingerprint()), (&rows, rows.fingerprint()));
    assert_eq!(asked.of(&TableRk4::new(128), family).start(rest).resume(merged).unwrap(), rows);
}

#[test]
fn rows_that_are_refused_come_back() {
    let engine = TableRk4::new(64);
    let part = |i| sweep().of(&engine, family).start(rest).chunk(i, 3).unwrap();
    let refused = Rows::merge(vec![part(2), part(0)]).unwrap_err();
    assert_eq!(refused.error, SweepError::Parts { row: 1 });
    let mut parts = refused.rows;
    parts.push(part(1));
    let whole = Rows::merge(parts).unwrap();
    assert_eq!(whole, sweep().of(&engine, family).start(rest).run().unwrap());
    // Rows of another sweep, and an engine that cannot be used.
    let other = sweep().measure(3).of(&engine, family).start(rest).resume(whole.clone()).unwrap_err();
    assert_eq!((other.error, &other.rows[..]), (SweepError::Parts { row: 0 }, &[whole.clone()][..]));
    let none = sweep().of(&TableRk4::new(0), family).start(rest).resume(part(1)).unwrap_err();
    assert!(matches!(none.error, SweepError::Table(TableError::Size { steps: 0, .. })), "{}", none.error);
    assert_eq!(none.rows, [part(1)]);
    // `?` converts the error to a `SweepError`.
    let merged = || -> Result<Rows, SweepError> { Ok(Rows::merge(vec![part(0)])?) };
    assert_eq!(merged(), Err(SweepError::Parts { row: 1 }));
}

/// x = mean + √2 sin t: the standard deviation is 1 with lanes, tables, located edges and samples, also for a
/// mean of 10⁹.
#[test]
fn a_deviation_is_not_lost_in_a_large_mean() {
    #[derive(PartialEq)]
    struct Far;
    impl Shape for Far {
        fn size(&self) -> Size {
            Size { dof: 1, waves: 1, constants: 1, ..Size::default() }
        }
        fn names(&self) -> Vec<Channel> {
            vec![Channel::new("speed", "1")]
        }
        fn accel<S: Scalar, L: PieceChoice<S>>(
            &self,
            _: &L,
            u: Drives<'_, S>,
            _: &[S],
            _: &[S],
            a: &mut [S],
        ) {
            a[0] = u.all_waves()[0];
        }
        fn waves<A: Angle>(&self, angle: A, _: Side, u: &mut [A::Number]) {
            u[0] = angle.number().sin() * -2f64.sqrt();
        }
    }
    let root = 2f64.sqrt();
    for mean in [0.0, 1e3, 1e9] {
        let sweep = Sweep::new(Axis::of_values("mean", &[mean, mean, mean]).unwrap())
            .settle(1)
            .measure(3)
            .channels(&["q0"]);
        let family = |_: &Point<'_>| Machine::of_constants(Far, &[("speed", 1.0)]);
        let start =
            |p: &Point<'_>, _: &Machine<Far>| Ok::<_, ParameterError>(State::new(0.0, &[p["mean"]], &[root]));
        let lanes = sweep.of(&LaneRk4::new(256).lanes::<4>(), family).start(start).run().unwrap();
        let alone = sweep.of(&TableRk4::new(256), family).start(start).run().unwrap();
        let located = sweep.of(&Located(Dop853::new()), family).start(start).run().unwrap();
        let found = |rows: &Rows| rows.iter().next().unwrap().channel("q0").unwrap();
        assert_eq!(found(&lanes), found(&alone), "{mean}");
        for rows in [&lanes, &alone, &located] {
            let summary = found(rows);
            assert!((summary.deviation - 1.0).abs() < 1e-6, "{mean}: {summary:?}");
        }
    }
    let samples: Vec<f64> =
        (0..1000).map(|i| 1e9 + root * (f64::from(i) * std::f64::consts::TAU / 1000.0).sin()).collect();
    assert!((Summary::of_samples(&samples).unwrap().deviation - 1.0).abs() < 1e-7);
}

/// A stop on one side: a law with an infinite edge gives the results of a law with an edge out of reach.
#[test]
fn a_stop_on_one_side_alone() {
    let (infinite, nan) = (f64::INFINITY, f64::NAN);
    for (lower, upper) in [
        (-infinite, infinite),
        (infinite, infinite),
        (-infinite, -infinite),
        (infinite, 0.0),
        (0.0, -infinite),
        (nan, 1.0),
        (1.0, nan),
    ] {
        assert!(AsymmetricBacklash::new(lower, upper).is_err(), "{lower} {upper}");
    }
    let above = AsymmetricBacklash::new(-infinite, 1.0).unwrap().with_slopes(3.0, 2.0).unwrap();
    let below = AsymmetricBacklash::new(-1.0, infinite).unwrap().with_slopes(2.0, 3.0).unwrap();
    for x in [-1e300, -2.0, 0.0, 1.0, 1.5, 1e300] {
        assert_eq!(
            (above.at(x), below.at(-x)),
            (2.0 * f64::max(x - 1.0, 0.0), -2.0 * f64::max(x - 1.0, 0.0)),
            "{x}"
        );
        if x != 1.0 {
            assert_eq!(
                (above.slope(x), below.slope(-x)),
                ([0.0, 2.0][usize::from(x > 1.0)], [0.0, 2.0][usize::from(x > 1.0)]),
                "{x}"
            );
        }
    }
    let on =
        |law: &AsymmetricBacklash, piece, x| law.force_on(piece, &[], law.edges(0.0, Side::After).at(x, 0.0));
    assert_eq!([Piece::Lower, Piece::Gap, Piece::Upper].map(|piece| on(&above, piece, 3.0)), [0.0, 0.0, 4.0]);
    assert_eq!(
        [Piece::Lower, Piece::Gap, Piece::Upper].map(|piece| on(&below, piece, -3.0)),
        [-4.0, 0.0, 0.0]
    );
    // In a ring, with located edges and in lanes.
    let ring = |lower: f64| {
        let set =
            RingSet { half_backlash: 1e-5, error: 5e-6, motor_torque: 8.0, ..RingSet::set_a(4, 6000.0) };
        let RingParams { motor, gears, meshes, mesh_damping, omega, teeth } = set.params()?;
        let law = MixedLaw::<Linear>::Asymmetric(AsymmetricBacklash::new(lower, 1e-5)?);
        let wave = Wave::new(Fourier::new(set.mesh_stiffness, &[[0.3 * set.mesh_stiffness, 0.0]])?);
        let error = Wave::new(Fourier::new(0.0, &[[0.0, 5e-6]])?);
        let mesh = Mesh::new(wave, error, law);
        let meshes = vec![mesh; meshes.len()];
        Ring::of_laws(&RingParams { motor, gears, meshes, mesh_damping, omega, teeth }, Frame::Rigid)
    };
    let (stop, far) = (ring(-infinite).unwrap(), ring(-1e-3).unwrap());
    let mut start = State::at_rest(stop.dof());
    start.q[1] = 4e-4;
    let end = |ring: &Ring<MixedLaw>| {
        let mut rattle = Rattle::new(ring);
        let end = Dop853::new().run(ring, &start, 6.0 * ring.period(), &mut rattle).unwrap().state;
        (end, rattle.contacts().to_vec())
    };
    let ((a, one), (b, other)) = (end(&stop), end(&far));
    // The other edge enters the tolerance of locating through the width of the gap, so that the runs agree to
    // the tolerance of the solver.
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-9 * a.abs().max(1e-3));
    assert!(near(&a.q, &b.q) && near(&a.v, &b.v), "{a:?} {b:?}");
    assert!(
        one.iter().zip(&other).all(|(a, b)| a.impacts == b.impacts && near(&a.time, &b.time)),
        "{one:?} {other:?}"
    );
    assert!(
        one.iter().any(|contact| contact.impacts[1] > 0) && one.iter().all(|contact| contact.impacts[0] == 0)
    );
    let rows = |ring: &Ring<MixedLaw>, infinite| {
        let sweep = Sweep::new(Axis::of_values("none", &[0.0, 1.0, infinite]).unwrap())
            .settle(1)
            .measure(2)
            .channels(&["q0", "deflection 0"])
            .rattle();
        sweep
            .of(&LaneRk4::new(256).lanes::<4>(), |_| Ok::<_, ParameterError>(ring.clone()))
            .start(|_, _| start.clone())
            .run()
            .unwrap()
    };
    let (one, other) = (rows(&stop, 2.0), rows(&far, 2.0));
    assert!(one.errors().is_empty(), "{:?}", one.errors());
    for (a, b) in one.iter().zip(other.iter()) {
        assert_eq!((a.channel("q0"), a.contacts()[0]), (b.channel("q0"), b.contacts()[0]));
    }
}
