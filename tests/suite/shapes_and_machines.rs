//! Shapes, named constants and machines: names, derivatives, lanes, varying speed, models with laws and waves
//! of one's own, invalid shapes.

use crate::api::*;
use std::f64::consts::TAU;

fn pair() -> NfgPair {
    NfgPair::new(&NfgParams { error: 2e-5, ..NfgParams::table1() }).unwrap()
}

fn ring() -> Ring {
    Ring::new(&RingSet { phases: vec![0.0, 0.4, 1.1, 2.0], ..RingSet::set_a(4, 2000.0) }.params().unwrap())
        .unwrap()
}

#[test]
fn names_that_do_not_exist_are_refused() {
    let error = pair().with("lod torque", 20.0).unwrap_err();
    assert_eq!(
        error.to_string(),
        "no constant \"lod torque\"; there are: speed, load torque, inertia, stiffness, damping ratio, \
         half backlash"
    );
    assert!(matches!(pair().constant("b").unwrap_err(), ParameterError::NoSuchConstant { .. }));
    assert!(matches!(ring().slot("mesh damping x").unwrap_err(), ParameterError::NoSuchConstant { .. }));
    assert!(matches!(
        ring().slope("load", &[], &[], &[]).unwrap_err(),
        ParameterError::NoSuchConstant { .. }
    ));
    // A constant that the shape converts is not a drive.
    assert_eq!(
        pair().slot("half backlash").unwrap_err(),
        ParameterError::NotADrive { name: "half backlash".into() }
    );
    assert_eq!(pair().slot("inertia").unwrap_err(), ParameterError::NotADrive { name: "inertia".into() });
    let ring = ring();
    let mut u = vec![0.0; ring.drives()];
    ring.drive(0.0, Side::After, &mut u);
    // The speed stands among the drives, but an addition to it would not change the angle.
    assert!(matches!(ring.slot("mesh frequency").unwrap_err(), ParameterError::NotADrive { .. }));
    for (i, channel) in ring.names().iter().enumerate().skip(1) {
        assert_eq!(u[ring.slot(&channel.name).unwrap()], ring.values()[i], "{channel}");
    }
}

#[test]
fn values_out_of_range_are_refused_by_name() {
    for (name, bad) in
        [("speed", 0.0), ("speed", -1.0), ("inertia", 0.0), ("load torque", -1.0), ("half backlash", -1e-5)]
    {
        let error = pair().with(name, bad).unwrap_err();
        assert!(error.to_string().starts_with(name), "{error}");
    }
    for bad in [f64::NAN, f64::INFINITY, 1e51] {
        assert!(pair().with("load torque", bad).is_err() && ring().with("motor torque", bad).is_err());
    }
    assert!(matches!(
        ring().with("mesh damping 1", -1.0),
        Err(ParameterError::Negative { name, .. }) if name == "mesh damping 1"
    ));
}

/// ∂a/∂c for every constant of every model, against differences between models with changed constants.
#[test]
fn derivatives_by_constants() {
    fn check<G: Shape>(model: &Machine<G>, q: &[f64], v: &[f64]) {
        let n = q.len();
        let at = |model: &Machine<G>| {
            // At equal angles.
            let (mut u, mut a) = (vec![0.0; model.drives()], vec![0.0; n]);
            model.drive(0.9 / model.speed(), Side::After, &mut u);
            model.accel(&u, q, v, &mut a);
            (u, a)
        };
        let (u, a) = at(model);
        let size = a.iter().fold(0.0, |m: f64, a| m.max(a.abs()));
        let mut moved = 0;
        for (channel, &value) in model.names().iter().zip(model.values()) {
            let h = 1e-5 * value.abs().max(1e-3);
            let exact = model.slope(&channel.name, &u, q, v).unwrap();
            let [above, below] =
                [1.0, -1.0].map(|side| at(&model.with(&channel.name, value + side * h).unwrap()).1);
            for i in 0..n {
                let differences = (above[i] - below[i]) / (2.0 * h);
                let scale = exact[i].abs().max(size / value.abs().max(1e-3));
                assert!(
                    (exact[i] - differences).abs() < 1e-6 * scale,
                    "{channel}: {} {differences}",
                    exact[i]
                );
            }
            moved += usize::from(exact.iter().any(|x| *x != 0.0));
        }
        assert_eq!(moved, model.names().len());
    }
    check(&pair(), &[-8e-4], &[1e-4]);
    check(
        &NfgPair2::new(&NfgParams { error: 2e-5, ..NfgParams::table1() }, 0.01).unwrap(),
        &[1e-3, -2e-3],
        &[0.3, -0.2],
    );
    let q: Vec<f64> = (0..9).map(|i| 1e-3 * (f64::from(i) * 0.7).sin()).collect();
    let v: Vec<f64> = (0..9).map(|i| 0.1 * (f64::from(i) * 1.3).cos()).collect();
    check(&ring(), &q, &v);
}

/// Within the gap q'' = ē'' - θ2'' - B0 with θ2 = 2 atan((1 - ε)/(1 + ε) tan(x/2)) and ē = e/r_b2. For an
/// angle x with fluctuating speed the acceleration agrees with second differences. The part of x'' is as
/// large as that of the centre forcing.
#[test]
fn second_derivatives_hold_the_acceleration_of_the_angle() {
    let eps = 0.2;
    for error_harmonics in [vec![], vec![[0.0, 1e-5]]] {
        let params = NfgParams { damping_ratio: 0.0, error: 3e-5, error_harmonics, ..NfgParams::table1() };
        let bare = NfgPair::new(&params).unwrap();
        let (speed, radius) = (bare.speed(), bare.mean_radius());
        let law = SpeedLaw::fluctuation(speed, 0.02, 20.0 * speed).unwrap();
        let pair = VaryingSpeed::new(bare.clone(), law.clone());
        let (mut u, mut a, mut steady) = (vec![0.0; pair.drives()], [0.0], [0.0]);
        let load = bare.prepared_constants()[2]; // B0
        let (mut by_acceleration, mut by_centre) = (0.0f64, 0.0f64);
        for k in 0..20 {
            let t = 40.0 + 77.0 * f64::from(k);
            // Within the gap there is no mesh force.
            pair.drive(t, Side::After, &mut u);
            pair.accel(&u, &[0.0], &[0.0], &mut a);
            let motion = |t: f64| {
                let x = law.angle(t);
                let turns = ((x + 0.5 * TAU) / TAU).floor();
                let rigid = 2.0 * ((1.0 - eps) / (1.0 + eps) * (0.5 * x).tan()).atan() + TAU * turns;
                let error: f64 = params.error
                    + params.error_harmonics.iter().map(|[_, s]| s * (63.0 * x).sin()).sum::<f64>();
                error / (radius * (1.0 + params.beta() * x.cos())) - rigid
            };
            let h = 0.25;
            let second = |h: f64| (motion(t + h) - 2.0 * motion(t) + motion(t - h)) / (h * h);
            let differences = (4.0 * second(h) - second(2.0 * h)) / 3.0 - load;
            assert!((a[0] - differences).abs() < 2e-6 * load + 1e-10, "{t}: {} {differences}", a[0]);
            bare.shape().waves(law.angle(t), Side::After, &mut u[..6]);
            (u[6], u[7]) = (law.speed(t), 0.0);
            bare.accel(&u, &[0.0], &[0.0], &mut steady);
            by_acceleration = by_acceleration.max((a[0] - steady[0]).abs());
            by_centre = by_centre.max((steady[0] + load).abs());
        }
        println!("{by_acceleration:.2e} from the angle, {by_centre:.2e} from the centre and the error");
        assert!(by_acceleration > 0.5 * by_centre || !params.error_harmonics.is_empty());
    }
}

/// Rings of different speeds share one drive table, although their waves were made separately. Each gives the
/// row of its single run.
#[test]
fn rings_of_any_speed_share_lanes() {
    let family = |p: &Point<'_>| {
        let set = RingSet {
            motor_torque: 4.0,
            load_torque: 1.0,
            half_backlash: 1e-5,
            error: 5e-6,
            ..RingSet::set_a(3, p["rpm"])
        };
        Ring::as_printed(&set.params()?)
    };
    let start = |_: &Point<'_>, ring: &Ring| Ok::<_, ParameterError>(State::at_rest(ring.dof()));
    let sweep = |speeds: &[f64]| {
        let points = Points::from(Axis::of_values("rpm", speeds).unwrap());
        let sweep =
            Sweep::new(points).settle(1).measure(2).channels(&["deflection 0", "mesh force 1"]).rattle();
        sweep.of(&LaneRk4::new(200).lanes::<4>(), family).start(start).run().unwrap()
    };
    let speeds = [2000.0, 2500.0, 3000.0, 4000.0];
    let together = sweep(&speeds);
    assert_eq!(together.alone(), 0);
    for (row, speed) in together.iter().zip(speeds) {
        let alone = sweep(&[speed]);
        assert_eq!(row.channel("mesh force 1"), alone.get(0).unwrap().channel("mesh force 1"));
    }
    let forces: Vec<f64> = together.iter().map(|row| row.channel("mesh force 1").unwrap().max).collect();
    assert!(forces.windows(2).all(|two| two[0] != two[1]), "{forces:?}");
}

/// The pair with the waves of its parameters as a mesh, and with laws that equal the dead zone: the same
/// accelerations and contacts in every reading.
#[test]
fn the_pair_takes_any_law_and_any_wave() {
    let params = NfgParams { error: 2e-5, ..NfgParams::table1() };
    let waves = || {
        let stiffness = Wave::new(Fourier::new(3.1e8, &[[0.9e8, 0.0]]).unwrap());
        (stiffness, Wave::new(Fourier::new(params.error, &[[0.0, 1e-5]]).unwrap()))
    };
    fn compare<G: Shape, H: Shape>(one: &Machine<G>, other: &Machine<H>, tolerance: f64, what: &str) {
        let read = |model: &dyn Model, t: f64, q: f64| {
            let (mut u, mut a, mut c) = (vec![0.0; model.drives()], [0.0], [Contact::default()]);
            model.drive(t, Side::After, &mut u);
            model.accel(&u, &[q], &[2e-5], &mut a);
            model.contact(&u, &[q], &[2e-5], &mut c);
            let c = c[0];
            [a[0], c.deflection, c.rate, c.lower, c.upper, c.lower_rate, c.upper_rate, c.force]
        };
        for k in 0..40 {
            let (t, q) = (13.7 * f64::from(k), 1.1e-3 * (f64::from(k) * 0.9).sin());
            let (x, y) = (read(one, t, q), read(other, t, q));
            for i in 0..8 {
                let size = [1e-4, 1e-4, 1e-6, 1e-4, 1e-4, 1e-6, 1e-6, 1e3][i];
                assert!(
                    (x[i] - y[i]).abs() < tolerance * size.max(x[i].abs()),
                    "{what} {i}: {} {}",
                    x[i],
                    y[i]
                );
            }
        }
    }
    for reading in [NfgReading::exact(), NfgReading::published(), NfgReading::published_on_base_radius()] {
        let own = NfgPair::of_reading(&params, reading).unwrap();
        let mesh = |law| {
            let (stiffness, error) = waves();
            Mesh::new(stiffness, error, law)
        };
        let backlash = NfgPair::of_mesh(&params, reading, mesh(Backlash::new(5e-5).unwrap())).unwrap();
        compare(&own, &backlash, 1e-12, "backlash");
        let asymmetric = {
            let (stiffness, error) = waves();
            Mesh::new(stiffness, error, AsymmetricBacklash::new(-5e-5, 5e-5).unwrap())
        };
        compare(&own, &NfgPair::of_mesh(&params, reading, asymmetric).unwrap(), 1e-11, "asymmetric");
        let varying = {
            let (stiffness, error) = waves();
            Mesh::new(stiffness, error, VaryingBacklash::new(Wave::constant(5e-5).unwrap()))
        };
        compare(&own, &NfgPair::of_mesh(&params, reading, varying).unwrap(), 1e-11, "varying");
        let power = {
            let (stiffness, error) = waves();
            Mesh::new(stiffness, error, PowerLaw::new(5e-5, 1.0, 1.0).unwrap())
        };
        compare(&own, &NfgPair::of_mesh(&params, reading, power).unwrap(), 1e-11, "power law of exponent 1");
    }
}

/// A half width that varies with the mesh: its edges and their rates agree with differences, and the model
/// has no findings.
#[test]
fn moving_edges_of_the_pair() {
    let params = NfgParams::table1();
    let width = Wave::new(Fourier::new(5e-5, &[[1e-5, 5e-6]]).unwrap());
    let stiffness = Wave::new(RectangularWave::of_contact_ratio(1.6, 2.4e8, 3.6e8).unwrap());
    let mesh = Mesh::new(stiffness, Wave::constant(1e-5).unwrap(), VaryingBacklash::new(width));
    let one = NfgPair::of_mesh(&params, NfgReading::exact(), mesh.clone()).unwrap();
    assert_eq!(check_periodic(&one, &State::new(3.0, &[-8e-4], &[1e-4])), []);
    let edges = std::iter::successors(Some(0.0), |t| one.next_edge(*t))
        .skip(1)
        .take_while(|t| *t < 0.999 * one.period())
        .count();
    assert_eq!(edges, 2 * 63);
    let absolute = Mesh::new(Wave::constant(3e8).unwrap(), Wave::constant(1e-5).unwrap(), mesh.law().clone());
    let two = NfgPair2::of_mesh(&params, 0.01, NfgReading::exact(), absolute).unwrap();
    assert_eq!(check_periodic(&two, &State::new(3e-4, &[1e-3, -2e-3], &[0.1, 0.2])), []);
    let solver = Dop853::new().rtol(1e-10).atol(1e-15);
    let (tight, loose) = (Dop853::new().rtol(1e-12).atol(1e-17), solver);
    let start = one.on_drive_flank().unwrap();
    let (a, b) = (tight.end(&one, &start, 300.0).unwrap(), loose.end(&one, &start, 300.0).unwrap());
    assert!((a.q[0] - b.q[0]).abs() < 1e-9, "{} {}", a.q[0], b.q[0]);
}

/// x'' = T(t): a torque that is a function of time, a ramp followed by a jump.
#[test]
fn functions_of_time_by_a_wrapper() {
    #[derive(PartialEq)]
    struct Free;
    impl Shape for Free {
        fn size(&self) -> Size {
            Size { dof: 1, constants: 2, ..Size::default() }
        }
        fn names(&self) -> Vec<Channel> {
            vec![Channel::new("speed", "1"), Channel::new("torque", "1")]
        }
        fn accel<S: Scalar, L: PieceChoice<S>>(
            &self,
            _: &L,
            u: Drives<'_, S>,
            _: &[S],
            _: &[S],
            a: &mut [S],
        ) {
            [a[0]] = u.constants();
        }
    }
    let free = Machine::of_constants(Free, &[("speed", 1.0), ("torque", 0.5)]).unwrap();
    let slot = free.slot("torque").unwrap();
    let driven = Driven::new(free).add(slot, |t| if t < 2.0 { t } else { -1.0 }, &[2.0]).unwrap();
    let end = Rk45::new().end(&driven, &State::at_rest(1), 3.0).unwrap();
    // v = 0.5 t + t²/2 up to t = 2; then the constant 0.5 and the function -1 add up to -0.5.
    assert!((end.v[0] - (1.5 + 2.0 - 1.0)).abs() < 1e-12, "{end:?}");
    assert_eq!(driven.next_edge(0.0), Some(2.0));
    assert!(matches!(driven.clone().add(99, |t| t, &[]), Err(ParameterError::NoSuchSlot { slot: 99, .. })));
    assert!(matches!(driven.add(slot, |t| t, &[f64::NAN]), Err(ParameterError::NotFinite { .. })));
}

/// A shape that may have any flaw.
#[derive(Clone, PartialEq)]
#[allow(unpredictable_function_pointer_comparisons, reason = "the test does not depend on the result")]
struct Flawed {
    size: Size,
    names: Vec<&'static str>,
    wave: fn(f64) -> f64,
    repeats: u32,
    prepared: usize,
    reads: usize,
}

impl Flawed {
    fn right() -> Self {
        let size = Size { dof: 1, waves: 1, constants: 2, ..Size::default() };
        Flawed { size, names: vec!["speed", "load"], wave: f64::cos, repeats: 1, prepared: 2, reads: 1 }
    }
    fn machine_of(self) -> Result<Machine<Self>, ParameterError> {
        Machine::of_constants(self, &[("speed", 1.0), ("load", 2.0)])
    }
}

impl Shape for Flawed {
    fn size(&self) -> Size {
        self.size
    }
    fn names(&self) -> Vec<Channel> {
        self.names.iter().map(|name| Channel::new(*name, "1")).collect()
    }
    fn prepare<S: Scalar>(&self, constants: &[S]) -> Vec<S> {
        constants.iter().copied().take(self.prepared).collect()
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, _: &[S], _: &[S], a: &mut [S]) {
        let [one, two]: [S; 2] = u.constants();
        a[0] = if self.reads == 1 { one } else { two };
    }
    fn waves<A: Angle>(&self, angle: A, _: Side, u: &mut [A::Number]) {
        if let Some(u) = u.first_mut() {
            [*u] = angle.by_function(|angle| [(self.wave)(angle)]);
        }
    }
    fn repeats(&self) -> u32 {
        self.repeats
    }
}

#[test]
fn shapes_that_disagree_with_their_drives_are_refused() {
    use ParameterError as P;
    let of = |change: fn(&mut Flawed)| {
        let mut shape = Flawed::right();
        change(&mut shape);
        shape.machine_of().map(|_| ())
    };
    assert_eq!(of(|_| ()), Ok(()));
    assert!(matches!(
        of(|s| s.size.dof = 0),
        Err(P::TooFew { name, .. }) if name == "degrees of freedom of the shape"
    ));
    assert!(matches!(
        of(|s| s.size.kinks = 5),
        Err(P::TooMany { name, value: 5, max: 0 }) if name == "kinks of the shape"
    ));
    assert!(matches!(of(|s| s.size.constants = 3), Err(P::Length { expected: 3, found: 2, .. })));
    assert!(matches!(of(|s| s.prepared = 1), Err(P::Length { expected: 2, found: 1, .. })));
    assert!(
        matches!(of(|s| s.size.waves = 2), Err(P::NotFinite { name, .. }) if name == "wave 1 of the shape")
    );
    assert!(matches!(
        of(|s| s.reads = 2),
        Err(P::NotFinite { name, .. }) if name == "acceleration 0 of the shape at rest"
    ));
    assert!(matches!(
        of(|s| s.wave = |x| (0.5 * x).sin()),
        Err(P::NotPeriodic { name, .. }) if name == "wave 0 of the shape"
    ));
    assert!(matches!(of(|s| s.repeats = 2), Err(P::NotPeriodic { .. })));
    assert!(matches!(of(|s| s.repeats = 0), Err(P::TooFew { .. })));
    assert_eq!(of(|s| (s.repeats, s.wave) = (2, |x: f64| (2.0 * x).sin())), Ok(()));
    assert!(matches!(of(|s| s.names = vec!["speed", "speed"]), Err(P::Twice { .. })));
    let shape = Flawed::right();
    assert_eq!(
        Machine::of_constants(shape.clone(), &[("speed", 1.0)]).unwrap_err(),
        P::MissingConstant { name: "load".into() }
    );
    assert_eq!(
        Machine::of_constants(shape.clone(), &[("speed", 1.0), ("speed", 2.0), ("load", 1.0)]).unwrap_err(),
        P::Twice { name: "speed".into() }
    );
    assert!(matches!(
        Machine::of_constants(shape.clone(), &[("speed", 0.0), ("load", 1.0)]),
        Err(P::NotPositive { name, .. }) if name == "speed of the angle"
    ));
    assert!(matches!(
        Machine::of_constants(shape, &[("speed", 1.0), ("load", f64::NAN)]),
        Err(P::NotFinite { name, .. }) if name == "load"
    ));
    assert!(matches!(
        Wave::constant(1.0).unwrap().per_turn(0),
        Err(P::TooFew { name, min: 1, .. }) if name == "order of a wave"
    ));
}

/// The period is the one in which all waves repeat: 30 teeth and 12 blades repeat 6 times a turn.
#[test]
fn common_periods_are_exact() {
    let mut shape = Flawed::right();
    (shape.wave, shape.repeats) = (|x: f64| (30.0 * x).cos() + (12.0 * x).sin(), 6);
    let machine = shape.machine_of().unwrap();
    assert_eq!(machine.period(), TAU / 6.0);
    assert_eq!(check_periodic(&machine, &State::at_rest(1)), []);
}

/// The engines with fixed steps do not locate edges: they refuse a shape with a rigid stop, and `Located`
/// runs it.
#[test]
fn lanes_refuse_rigid_stops() {
    #[derive(PartialEq)]
    struct Bouncer;
    impl Shape for Bouncer {
        fn size(&self) -> Size {
            Size { dof: 1, contacts: 1, constants: 2, ..Size::default() }
        }
        fn names(&self) -> Vec<Channel> {
            vec![Channel::new("speed", "1"), Channel::new("weight", "1")]
        }
        fn accel<S: Scalar, L: PieceChoice<S>>(
            &self,
            _: &L,
            u: Drives<'_, S>,
            _: &[S],
            _: &[S],
            a: &mut [S],
        ) {
            let [weight] = u.constants();
            a[0] = -weight;
        }
        fn stops(&self) -> &[[bool; 2]] {
            &[[true, false]]
        }
        fn contact<S: Scalar, L: PieceChoice<S>>(
            &self,
            _: &L,
            _: usize,
            _: Drives<'_, S>,
            q: &[S],
            v: &[S],
        ) -> Contact<S> {
            Contact { deflection: q[0], rate: v[0], lower: S::from(0.0), ..Contact::default() }
        }
        fn impact<S: Scalar>(&self, _: usize, _: Piece, _: Drives<'_, S>, _: &[S], v: &mut [S]) {
            v[0] = -v[0];
        }
    }
    let family = |p: &Point<'_>| Machine::of_constants(Bouncer, &[("speed", TAU), ("weight", p["weight"])]);
    let start =
        |_: &Point<'_>, _: &Machine<Bouncer>| Ok::<_, ParameterError>(State::new(0.0, &[0.5], &[0.0]));
    let sweep = Sweep::new(Axis::of_values("weight", &[1.0]).unwrap()).settle(0).measure(2).channels(&["q0"]);
    let refused = PointError::from(IntegrateError::StopNotLocated { contact: 0 });
    for rows in [
        sweep.of(&LaneRk4::new(64).lanes::<4>(), family).start(start).run(),
        sweep.of(&TableRk4::new(64), family).start(start).run(),
    ] {
        assert_eq!(rows.unwrap().get(0).unwrap_err(), refused);
    }
    // From a height of 1/2 it falls for 1 s and is back at the top after 2 s.
    let rows = sweep.of(&Located(Dop853::new()), family).start(start).run().unwrap();
    assert!((rows.get(0).unwrap().channel("q0").unwrap().max - 0.5).abs() < 1e-9);
}

/// A contact that the algebra uses must be counted in the size, and it must have edges if its law has.
/// Otherwise it would never touch, and the shape is refused.
#[test]
fn contacts_that_are_forgotten_are_refused() {
    #[derive(PartialEq)]
    struct Forgets {
        contacts: usize,
        told: bool,
        law: Backlash,
    }
    impl Shape for Forgets {
        fn size(&self) -> Size {
            Size { dof: 1, contacts: self.contacts, constants: 1, ..Size::default() }
        }
        fn names(&self) -> Vec<Channel> {
            vec![Channel::new("speed", "1")]
        }
        fn accel<S: Scalar, L: PieceChoice<S>>(
            &self,
            law: &L,
            _: Drives<'_, S>,
            q: &[S],
            v: &[S],
            a: &mut [S],
        ) {
            let b = S::from(1.0);
            a[0] = S::from(0.2)
                - law.force(0, &self.law, Deflection { d: q[0], rate: v[0], lower: -b, upper: b });
        }
        fn contact<S: Scalar, L: PieceChoice<S>>(
            &self,
            _: &L,
            _: usize,
            _: Drives<'_, S>,
            q: &[S],
            v: &[S],
        ) -> Contact<S> {
            let b = S::from(1.0);
            let none = Contact { deflection: q[0], rate: v[0], ..Contact::default() };
            if self.told { Contact { lower: -b, upper: b, ..none } } else { none }
        }
    }
    let of = |contacts: usize, told: bool| {
        let shape = Forgets { contacts, told, law: Backlash::new(1.0).unwrap() };
        Machine::of_constants(shape, &[("speed", 1.0)]).map(|_| ())
    };
    assert_eq!(of(1, true), Ok(()));
    assert_eq!(of(0, true), Err(ParameterError::NoSuchContact { contact: 0, contacts: 0 }));
    assert_eq!(of(1, false), Err(ParameterError::NoEdges { contact: 0 }));
}

/// A small wave that does not repeat is found beside a large one that repeats.
#[test]
fn every_wave_has_its_own_size() {
    #[derive(PartialEq)]
    struct Two;
    impl Shape for Two {
        fn size(&self) -> Size {
            Size { dof: 1, waves: 2, constants: 1, ..Size::default() }
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
            a[0] = u.all_waves()[1];
        }
        fn waves<A: Angle>(&self, angle: A, _: Side, u: &mut [A::Number]) {
            let mesh = angle.times(30.0).number().cos();
            u[0] = (mesh * 0.2 + A::Number::from(1.0)) * 2e8;
            u[1] = angle.number().sin() * 1e-6;
        }
        fn repeats(&self) -> u32 {
            30
        }
    }
    let refused = Machine::of_constants(Two, &[("speed", 1.0)]);
    assert!(
        matches!(refused, Err(ParameterError::NotPeriodic { name, .. }) if name == "wave 1 of the shape")
    );
}

/// Edges of hand-written waves are found to rounding at any speed; none is lost.
#[test]
fn no_edge_is_lost_by_rounding() {
    #[derive(PartialEq)]
    struct Saw;
    impl Shape for Saw {
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
            [u[0]] = angle.by_function(|angle| [angle.rem_euclid(TAU)]);
        }
        fn next_edge(&self, angle: f64) -> Option<f64> {
            Some(TAU * (angle / TAU).floor() + TAU)
        }
    }
    for speed in [0.7, 0.9, 1.0, 3.3, 100.0] {
        let saw = Machine::of_constants(Saw, &[("speed", speed)]).unwrap();
        let mut t = 0.0;
        for k in 1..=1000 {
            let edge = saw.next_edge(t).unwrap();
            // Each edge is announced once, at its time within the rounding of 2πk/φ'.
            let expected = f64::from(k) * saw.period();
            assert!(edge > t && (edge / expected - 1.0).abs() < 1e-15, "{speed} {k}: {t} {edge}");
            t = edge;
        }
    }
}

/// Waves of the shaft, with `teeth` periods a turn: mean stiffness, period and accelerations do not depend on
/// the choice of the angle.
#[test]
fn rings_on_shafts() {
    let params = RingSet { error: 5e-6, ..RingSet::set_a(4, 2000.0) }.params().unwrap();
    for teeth in [1, 64, 192, 256] {
        let mut on_shaft = params.clone();
        for mesh in &mut on_shaft.meshes {
            *mesh = mesh.clone().per_turn(teeth).unwrap();
        }
        on_shaft.omega = params.omega / f64::from(teeth);
        let (ring, shaft) = (Ring::new(&params).unwrap(), Ring::new(&on_shaft).unwrap());
        for (a, b) in ring.mean_mesh_stiffness().iter().zip(shaft.mean_mesh_stiffness()) {
            assert!((a / b - 1.0).abs() < 1e-13, "{teeth}: {a} {b}");
        }
        assert!((ring.period() / shaft.period() - 1.0).abs() < 1e-15);
        let (mut u, mut w) = (vec![0.0; ring.drives()], vec![0.0; ring.drives()]);
        let (mut a, mut b) = (vec![0.0; 9], vec![0.0; 9]);
        let rest = State::at_rest(9);
        ring.drive(1.7e-4, Side::After, &mut u);
        shaft.drive(1.7e-4, Side::After, &mut w);
        ring.accel(&u, &rest.q, &rest.v, &mut a);
        shaft.accel(&w, &rest.q, &rest.v, &mut b);
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-9 * a.abs().max(1.0)), "{a:?} {b:?}");
    }
}

/// A contact law receives metres and metres per second in every pair: with a heavy pinion the damping of
/// `Damped::by_stiffness` is the same in the pairs of one and of two degrees of freedom.
#[test]
fn laws_read_the_same_units_in_both_pairs() {
    let params = NfgParams { eccentric_ratio: 0.0, damping_ratio: 0.0, ..NfgParams::table1() };
    let law = || Damped::by_stiffness(Backlash::new(5e-5).unwrap(), 2e-6).unwrap();
    let mesh = |error: f64| Mesh::new(Wave::constant(3.1e8).unwrap(), Wave::constant(error).unwrap(), law());
    let one = NfgPair::of_mesh(&params, NfgReading::exact(), mesh(0.0)).unwrap();
    let two = NfgPair2::of_mesh(&params, 1e6, NfgReading::exact(), mesh(0.0)).unwrap();
    let (natural, radius) = (one.natural_frequency(), one.mean_radius());
    let (q, speed) = (-8e-4, 0.3);
    let (mut u, mut a, mut c) = (vec![0.0; one.drives()], [0.0], [Contact::default()]);
    one.drive(0.0, Side::After, &mut u);
    one.accel(&u, &[q], &[speed / natural], &mut a);
    one.contact(&u, &[q], &[speed / natural], &mut c);
    let (mut w, mut b, mut d) = (vec![0.0; two.drives()], [0.0; 2], [Contact::default()]);
    two.drive(0.0, Side::After, &mut w);
    two.accel(&w, &[0.0, q], &[0.0, speed], &mut b);
    two.contact(&w, &[0.0, q], &[0.0, speed], &mut d);
    assert!((a[0] * natural * natural / b[1] - 1.0).abs() < 1e-9, "{} {}", a[0] * natural * natural, b[1]);
    assert!((c[0].force + d[0].force).abs() < 1e-9 * c[0].force.abs(), "{c:?} {d:?}");
    // The force is K (g + τ d').
    let force = 3.1e8 * ((radius * q + 5e-5) + 2e-6 * radius * speed);
    assert!((c[0].force / force - 1.0).abs() < 1e-12, "{} {force}", c[0].force);
}

/// Stops on one side and laws without edges in the pair: no result is NaN.
#[test]
fn laws_with_missing_edges_in_the_pair() {
    fn check<N: Nonlinearity + Clone>(law: N, what: &str) {
        for reading in [NfgReading::exact(), NfgReading::published()] {
            let mesh = Mesh::new(Wave::constant(3.1e8).unwrap(), Wave::constant(0.0).unwrap(), law.clone());
            let pair = NfgPair::of_mesh(&NfgParams::table1(), reading, mesh).unwrap();
            let (mut u, mut c) = (vec![0.0; pair.drives()], [Contact::default()]);
            for k in 0..5 {
                pair.drive(211.0 * f64::from(k), Side::After, &mut u);
                pair.contact(&u, &[-8e-4], &[1e-4], &mut c);
                assert!(
                    c[0].lower_rate.is_finite() && c[0].upper_rate.is_finite() && c[0].force.is_finite(),
                    "{what}: {c:?}"
                );
            }
            match pair.on_drive_flank() {
                Ok(start) => assert!(start.q[0] < 0.0 && what != "stop above"),
                Err(error) => assert!(
                    error == ParameterError::NoFlank { flank: "lower" } && what == "stop above",
                    "{error}"
                ),
            }
            assert_eq!(check_periodic(&pair, &State::new(3.0, &[-8e-4], &[1e-4])), [], "{what}");
        }
    }
    check(AsymmetricBacklash::stop_below(-5e-5).unwrap(), "stop below");
    check(AsymmetricBacklash::stop_above(5e-5).unwrap(), "stop above");
    check(Linear, "linear");
}

/// Away from edges a model with a constant speed law has the drives of the model without it, to the bit.
#[test]
fn a_speed_law_moves_no_wave_that_has_no_edge_there() {
    let wave = Wave::new(RectangularWave::new(1.5e8, 2.5e8, 0.4).unwrap()).per_turn(63).unwrap();
    let mut params = RingSet { error: 5e-6, ..RingSet::set_a(4, 2000.0) }.params().unwrap();
    for mesh in &mut params.meshes {
        *mesh = Mesh::new(wave.clone(), mesh.error().clone(), *mesh.law());
    }
    let ring = Ring::new(&params).unwrap();
    let varying = VaryingSpeed::new(ring.clone(), SpeedLaw::constant(ring.speed()).unwrap());
    let (mut u, mut w) = (vec![0.0; ring.drives()], vec![0.0; ring.drives()]);
    for k in 0..50 {
        let t = 1.3e-4 * f64::from(k) + 1e-6;
        ring.drive(t, Side::Before, &mut u);
        varying.drive(t, Side::Before, &mut w);
        assert_eq!(u, w, "{t}");
    }
    assert_eq!(check_model(&varying, &State::new(1.3e-4, &[1e-4; 9], &[0.01; 9])), []);
}

/// A law whose piece is NaN past its edge is refused by the constructor, and so is a constant that makes the
/// acceleration infinite.
#[test]
fn pieces_and_values_that_give_no_numbers_are_refused() {
    #[derive(PartialEq)]
    struct Hertz;
    impl Nonlinearity for Hertz {
        fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
            (at.d - at.upper).max(S::from(0.0)).powf(1.5)
        }
        fn force_on<S: Scalar>(&self, piece: Piece, _: &[Piece], at: Deflection<S>) -> S {
            if piece == Piece::Upper { (at.d - at.upper).powf(1.5) } else { S::from(0.0) }
        }
        fn edges<A: Angle>(&self, _: A, _: Side) -> Edges<A::Number> {
            Edges::at_rest(f64::NEG_INFINITY, 1e-5)
        }
    }
    let mesh = Mesh::new(Wave::constant(3e8).unwrap(), Wave::constant(0.0).unwrap(), Hertz);
    let refused = NfgPair2::of_mesh(&NfgParams::table1(), 0.01, NfgReading::exact(), mesh).unwrap_err();
    assert!(refused.to_string().contains("contacts on their upper flanks"), "{refused}");
    #[derive(PartialEq)]
    struct Mass;
    impl Shape for Mass {
        fn size(&self) -> Size {
            Size { dof: 1, constants: 2, ..Size::default() }
        }
        fn names(&self) -> Vec<Channel> {
            vec![Channel::new("speed", "1"), Channel::new("mass", "kg")]
        }
        fn accel<S: Scalar, L: PieceChoice<S>>(
            &self,
            _: &L,
            u: Drives<'_, S>,
            _: &[S],
            _: &[S],
            a: &mut [S],
        ) {
            let [mass] = u.constants();
            a[0] = S::from(1.0) / mass;
        }
    }
    let model = Machine::of_constants(Mass, &[("speed", 1.0), ("mass", 2.0)]).unwrap();
    assert!(matches!(
        model.with("mass", 0.0),
        Err(ParameterError::NotFinite { name, .. }) if name == "acceleration 0 of the shape at rest"
    ));
}

/// Accelerations of one model, everything else from its base.
struct Bare<M>(M);

impl<M: Model> Model for Bare<M> {
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
fn a_wrapper_has_the_drives_contacts_and_channels_of_its_base() {
    let pair = NfgPair::new(&NfgParams::table1()).unwrap();
    let (bare, start) = (Bare(Bare(&pair)), pair.on_drive_flank().unwrap());
    assert_eq!(check_model(&bare, &start), []);
    let drives = pair.drives();
    let sizes =
        |model: &dyn Model| (model.drives(), model.contacts(), model.channels(), model.next_edge(0.3));
    assert_eq!(sizes(&bare), sizes(&pair));
    let values = |model: &dyn Model| {
        let (times, mut nodes) = ([0.1, 0.2, 0.4], vec![0.0; 3 * drives]);
        (0..3).for_each(|i| model.drive(0.0, Side::After, &mut nodes[i * drives..][..drives]));
        model.redrive(&times, Side::Before, &mut nodes);
        let u = &nodes[..drives];
        let (mut contacts, mut out) = ([Contact::default()], vec![0.0; model.channels().len()]);
        model.contact(u, &start.q, &start.v, &mut contacts);
        model.write_channels(u, &start.q, &start.v, &contacts, &mut out);
        (nodes, contacts, out)
    };
    assert_eq!(values(&bare), values(&pair));
    // The algebra is the wrapper's own.
    let Offers { pieces, jacobian, stops, kinks, constants, expansion, terms, laws } = bare.offers();
    assert!(!pieces && !jacobian && stops.is_empty() && kinks == 0);
    assert!(constants.is_none() && expansion.is_none() && terms.is_none() && laws.is_none());
}

/// q'' = u(φ) - q with one wave u.
#[derive(PartialEq)]
struct OneWave(Wave);

impl Shape for OneWave {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, constants: 1, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1")]
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], _: &[S], a: &mut [S]) {
        a[0] = u.all_waves()[0] - q[0];
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.0.value(angle, side);
    }
}

/// exp(-(φ - π)²/(2 s²)) = s/√(2π) (1 + 2 Σ (-1)^k exp(-k² s²/2) cos kφ), about 0 but for rounding at most angles. A pulse
/// that comes once is refused, and so is a small wave that does not repeat.
#[test]
fn a_pulse_repeats_although_rounding_errors_beside_it_do_not() {
    for width in [0.05, 0.08, 0.2] {
        let mean = width / TAU.sqrt();
        let pair =
            |k: i32| [2.0 * mean * (-1f64).powi(k) * (-0.5 * (f64::from(k) * width).powi(2)).exp(), 0.0];
        let pulse = Fourier::new(mean, &(1..=100).map(pair).collect::<Vec<_>>()).unwrap();
        let machine = Machine::of_constants(OneWave(Wave::new(pulse)), &[("speed", 1.0)]);
        assert_eq!(machine.map(|_| ()), Ok(()), "{width}");
    }
    let once = |x: f64| (-0.5 * ((x - 0.5 * TAU) / 0.08).powi(2)).exp() + 1e-15 * x;
    for wave in [once, |x: f64| 1e-15 * x.sqrt()] {
        let refused = Flawed { wave, ..Flawed::right() }.machine_of();
        assert!(matches!(refused.map(|_| ()), Err(ParameterError::NotPeriodic { .. })));
    }
}
