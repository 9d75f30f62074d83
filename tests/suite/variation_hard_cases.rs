//! The derivative of the flow in difficult cases: columns that grow, coordinates that almost stand still,
//! forces that jump, edges that depend on velocities. Also limits on work and counts.

use crate::api::*;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// x'' + 0.1 x' + x = cos 2t and y'' + 0.1 y' + y = 1 + e cos 2t, without coupling.
struct Still(f64);

impl Model for Still {
    fn dof(&self) -> usize {
        2
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let c = (2.0 * u[0]).cos();
        a[0] = c - 0.1 * v[0] - q[0];
        a[1] = 1.0 + self.0 * c - 0.1 * v[1] - q[1];
    }
    fn offers(&self) -> Offers<'_> {
        Offers { jacobian: true, ..Offers::default() }
    }
    fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], _: &[f64], _: &[f64], out: &mut Jacobian) {
        out.q.fill_with_identity();
        out.v.fill_with_identity();
        out.q.neg_mut();
        out.v *= -0.1;
    }
}

impl Periodic for Still {
    fn period(&self) -> f64 {
        PI
    }
}

impl Still {
    /// The state at t = 0 of the orbit x = c cos 2t + s sin 2t, y = 1 + e x.
    fn orbit(&self) -> State {
        let (c, s) = (-3.0 / 9.04, 0.2 / 9.04);
        State::new(0.0, &[c, 1.0 + self.0 * c], &[2.0 * s, 2.0 * self.0 * s])
    }
}

/// The smallest budget of steps, to a factor of two, with which a call succeeds.
fn least_budget(mut serves: impl FnMut(Budget) -> bool) -> u64 {
    let mut steps = 4;
    while !serves(Budget::new().steps(steps)) && steps < 1 << 20 {
        steps *= 2;
    }
    steps
}

#[test]
fn a_coordinate_that_nearly_stands_still_costs_no_more_than_one_that_moves() {
    for tolerance in [1e-12, 1e-13] {
        let steps = [1.0, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 0.0].map(|e| {
            least_budget(|budget| {
                Variation::new()
                    .flow_tolerance(tolerance)
                    .budget(budget)
                    .run(&Still(e), &Still(e).orbit(), PI)
                    .is_ok()
            })
        });
        let (least, most) = (steps.iter().min().unwrap(), steps.iter().max().unwrap());
        assert!(most <= &(2 * least), "{tolerance}: {steps:?}");
    }
    // For x'' + 0.1 x' + x = 0 the first column of the matrix is e^(-t/20) (cos νt + sin νt/(20 ν)).
    let nu = (1.0f64 - 0.0025).sqrt();
    let exact = (-0.05 * PI).exp() * ((nu * PI).cos() + 0.05 / nu * (nu * PI).sin());
    for e in [1e-8, 1e-12] {
        let through = Variation::new().run(&Still(e), &Still(e).orbit(), PI).unwrap();
        assert!(
            (through.matrix[(0, 0)] - exact).abs() < 1e-9 && (through.matrix[(1, 1)] - exact).abs() < 1e-9
        );
        let cycle = Shooting::new()
            .budget(Budget::new().steps(20_000))
            .solve(&Still(e), &[Still(e).orbit()])
            .unwrap();
        assert!((cycle.states()[0].q[1] - Still(e).orbit().q[1]).abs() < 1e-13);
    }
}

#[test]
fn columns_that_grow_by_millions_end_in_time() {
    let pair = NfgPair::new(&NfgParams { speed: 150.0, ..NfgParams::table1() }).unwrap();
    let start = pair.on_drive_flank().unwrap();
    let budget = Budget::new().steps(60_000);
    let through = Variation::new().budget(budget).run(&pair, &start, 2.0 * pair.period()).unwrap();
    assert!(through.matrix.amax() > 1e6, "{}", through.matrix);
}

/// x'' = 0.3 + 0.5 cos 0.9 t - W: a dead zone of half width 1 with damping in contact, so that the force
/// jumps. With or without fixed pieces.
struct Jumping {
    pieces: bool,
}

impl Jumping {
    fn on(piece: Piece, t: f64, q: f64, v: f64) -> f64 {
        let tooth = |x: f64| 4.0 * x + 0.6 * v;
        let force = match piece {
            Piece::Lower => tooth(q + 1.0),
            Piece::Gap => 0.0,
            Piece::Upper => tooth(q - 1.0),
        };
        0.3 + 0.5 * (0.9 * t).cos() - force
    }
}

impl Model for Jumping {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let mut out = [Contact::default()];
        self.contact(u, q, v, &mut out);
        a[0] = Jumping::on(out[0].piece(), u[0], q[0], v[0]);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: self.pieces, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        out[0] = Contact { deflection: q[0], rate: v[0], lower: -1.0, upper: 1.0, ..Contact::default() };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = Jumping::on(pieces[0], u[0], q[0], v[0]);
    }
}

impl Periodic for Jumping {
    fn period(&self) -> f64 {
        TAU / 0.9
    }
}

#[test]
fn a_force_that_jumps_needs_no_held_pieces() {
    let start = State::new(0.0, &[1.4], &[0.3]);
    let [held, bare] =
        [true, false].map(|pieces| Variation::new().run(&Jumping { pieces }, &start, 40.0).unwrap());
    assert_eq!(held.crossings, bare.crossings);
    assert!((&held.matrix - &bare.matrix).amax() < 1e-10, "{} {}", held.matrix, bare.matrix);
    let settled = Dop853::new().end(&Jumping { pieces: true }, &start, 40.0 * TAU / 0.9).unwrap();
    let guess = [State { t: 0.0, ..settled }];
    let [held, bare] =
        [true, false].map(|pieces| Shooting::new().solve(&Jumping { pieces }, &guess).unwrap());
    assert!((held.states()[0].q[0] - bare.states()[0].q[0]).abs() < 1e-10);
    assert!((held.monodromy() - bare.monodromy()).amax() < 1e-9);
}

/// x'' + 0.05 x' + x + 0.3 (1 + 0.2 x') sgn(s) = 2 cos 1.3 t with s = x' - belt cos t - slope x: dry
/// friction. The sliding speed s is the deflection of the contact.
struct Friction {
    slope: f64,
    belt: f64,
}

impl Friction {
    fn sliding(&self, t: f64, q: f64, v: f64) -> f64 {
        v - self.belt * t.cos() - self.slope * q
    }
    fn on(sign: f64, t: f64, q: f64, v: f64) -> f64 {
        2.0 * (1.3 * t).cos() - 0.05 * v - q - 0.3 * sign * (1.0 + 0.2 * v)
    }
}

impl Model for Friction {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let s = self.sliding(u[0], q[0], v[0]);
        a[0] = Friction::on(if s == 0.0 { 0.0 } else { s.signum() }, u[0], q[0], v[0]);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let mut a = [0.0];
        self.accel(u, q, v, &mut a);
        let rate = a[0] + self.belt * u[0].sin() - self.slope * v[0];
        out[0] = Contact {
            deflection: self.sliding(u[0], q[0], v[0]),
            rate,
            lower: 0.0,
            upper: 0.0,
            ..Contact::default()
        };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let sign = match pieces[0] {
            Piece::Lower => -1.0,
            Piece::Gap => 0.0,
            Piece::Upper => 1.0,
        };
        a[0] = Friction::on(sign, u[0], q[0], v[0]);
    }
}

/// The derivative of the flow of one coordinate agrees with differences of the flow.
fn derivative_is_that_of_differences(model: &impl Model, start: &State, end: f64) {
    let ours = Variation::new().run(model, start, end).unwrap();
    assert!(ours.crossings >= 3);
    let solver = Dop853::new().rtol(1e-13).atol(1e-13);
    for j in 0..2 {
        let moved = |h: f64| {
            let mut from = start.clone();
            *if j == 0 { &mut from.q[0] } else { &mut from.v[0] } += h;
            let end = solver.end(model, &from, end).unwrap();
            [end.q[0], end.v[0]]
        };
        // Richardson extrapolation of two central differences.
        let h = 1e-4;
        let (far, near) = ([moved(h), moved(-h)], [moved(0.5 * h), moved(-0.5 * h)]);
        for i in 0..2 {
            let slope = (4.0 * (near[0][i] - near[1][i]) / h - (far[0][i] - far[1][i]) / (2.0 * h)) / 3.0;
            assert!((slope - ours.matrix[(i, j)]).abs() < 1e-8, "{i} {j}: {slope} {}", ours.matrix);
        }
    }
}

#[test]
fn edges_that_depend_on_velocities_have_their_saltation() {
    for (slope, belt) in [(0.0, 0.0), (0.0, 0.2), (0.3, 0.2)] {
        derivative_is_that_of_differences(&Friction { slope, belt }, &State::new(0.0, &[0.7], &[0.4]), 9.0);
    }
}

/// x'' + 0.05 x' + x + 0.3 sgn(x + lean x - 0.1) = 2 cos 1.3 t. A part of the distance from the edge, lean x,
/// belongs to the edge and not to the deflection.
struct Leaning {
    lean: f64,
}

impl Model for Leaning {
    fn dof(&self) -> usize {
        1
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
        let (edge, rate) = (0.1 - self.lean * q[0], -self.lean * v[0]);
        out[0] = Contact {
            deflection: q[0],
            rate: v[0],
            lower: edge,
            upper: edge,
            lower_rate: rate,
            upper_rate: rate,
            force: 0.0,
        };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let sign = match pieces[0] {
            Piece::Lower => -1.0,
            Piece::Gap => 0.0,
            Piece::Upper => 1.0,
        };
        a[0] = 2.0 * (1.3 * u[0]).cos() - 0.05 * v[0] - q[0] - 0.3 * sign;
    }
}

#[test]
fn edges_that_depend_on_coordinates_have_their_saltation() {
    for lean in [0.0, 0.5, 2.0] {
        derivative_is_that_of_differences(&Leaning { lean }, &State::new(0.0, &[0.7], &[0.4]), 9.0);
    }
}

#[test]
fn one_budget_ends_flows_shooting_settling_and_balance() {
    let pair = NfgPair::new(&NfgParams { speed: 150.0, ..NfgParams::table1() }).unwrap();
    let start = pair.on_drive_flank().unwrap();
    let stop = Arc::new(AtomicBool::new(true));
    let spent = [Budget::new().steps(3), Budget::new().time(Duration::ZERO), Budget::new().cancel(stop)];
    for budget in spent {
        let flow = Variation::new().budget(budget.clone()).run(&pair, &start, pair.period());
        assert!(matches!(flow, Err(IntegrateError::Exhausted { .. })));
        let shot = Shooting::new().budget(budget.clone()).solve(&pair, &start);
        assert!(matches!(shot, Err(ShootingError::Exhausted { .. })));
        let settled = Settle::new().budget(budget.clone()).run(&Dop853::new(), &pair, &start);
        assert!(matches!(settled, Err(SettleError::Exhausted { .. })));
        let balance = Balance::new(Harmonics::up_to(70));
        let guess = balance.linearised(&pair, Piece::Lower).unwrap();
        let solved = balance.clone().budget(budget.clone()).solve(&pair, &guess);
        assert!(matches!(solved, Err(BalanceError::Exhausted { .. })), "{solved:?}");
        let multipliers = balance.budget(budget.clone()).multipliers(&pair, &guess);
        assert!(matches!(multipliers, Err(MultiplierError::Exhausted(_))), "{multipliers:?}");
        assert!(Shooting::new().budget(budget.clone()).solve_from(&pair, &guess).is_err());
        let calm = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() }).unwrap();
        let orbit = Shooting::new().solve(&calm, &[calm.on_drive_flank().unwrap()]).unwrap();
        let orbit = orbit.budget(budget);
        let far = orbit.states()[0].t + 0.999 * orbit.period();
        assert!(matches!(orbit.at(&calm, far), Err(IntegrateError::Exhausted { .. })));
        assert!(matches!(orbit.record(&calm), Err(IntegrateError::Exhausted { .. })));
    }
}

#[test]
fn absurd_counts_are_refused_or_cost_nothing() {
    let reading = NfgReading { centre_forcing: CentreForcing::Series(u32::MAX), ..NfgReading::exact() };
    let error = NfgPair::of_reading(&NfgParams::table1(), reading).unwrap_err();
    assert!(matches!(error, ParameterError::TooMany { max: 10_000, .. }));
    assert!(NfgPair2::of_reading(&NfgParams::table1(), 0.01, reading).is_err());
    for shooting in [Shooting::new().period_multiple(usize::MAX), Shooting::new().segments(usize::MAX)] {
        let error = shooting.solve(&Still(1.0), &[Still(1.0).orbit()]).unwrap_err();
        assert!(matches!(error, ShootingError::Parameter(ParameterError::TooMany { max: 1_000_000, .. })));
    }
    assert!(matches!(
        Harmonics::of_orders(&[1, usize::MAX]),
        Err(ParameterError::TooMany { max: 65_536, .. })
    ));
    let orbit =
        FourierOrbit::new(&Harmonics::of_orders(&[1, 65_536]).unwrap(), 1.0, &[vec![0.5, 0.0, 0.25, 0.0]])
            .unwrap();
    assert_eq!(orbit.at(0.0).q, [0.75]);
    assert!(orbit.at(0.3).q[0].is_finite());
}

/// q'' = 0.5 cos t - 0.3 q - f(q, v), by a formula without a Jacobian.
fn driven_by(f: fn(f64, f64) -> f64) -> impl Periodic {
    let motion = move |t: f64, q: &[f64], v: &[f64], a: &mut [f64]| {
        a[0] = 0.5 * t.cos() - 0.3 * q[0] - f(q[0], v[0]);
    };
    from_fn(1, motion).and_then(|model| model.with_period(TAU)).unwrap()
}

#[test]
fn jumps_without_an_edge_have_no_derivative() {
    let start = State::new(0.0, &[1.0], &[0.3]);
    let jumps = |error: &IntegrateError, at: f64| matches!(error, IntegrateError::JumpWithoutEdge { t, acceleration: 0 } if (t - at).abs() < 1e-6);
    // The velocity reverses at t = 1.41.. (0.2 of friction, a little damping): bisection of an RK4 run.
    let slides = driven_by(|_, v| 0.2 * v.signum() + 0.02 * v);
    let reversal = 1.419_194_66;
    let error = Variation::new().run(&slides, &start, 3.0).unwrap_err();
    assert!(jumps(&error, reversal), "{error}");
    let error = Shooting::new().solve(&slides, &start).unwrap_err();
    assert!(error.to_string().contains("where the model states no edge"), "{error}");
    let error = Lyapunov::new().run(&slides, &start).unwrap_err();
    assert!(error.to_string().contains("where the model states no edge"), "{error}");
    assert!(Dop853::new().end(&slides, &start, 3.0).is_ok());

    // A kink and a steep continuous force have a derivative: that of differences.
    for model in [driven_by(|q, v| 0.4 * q.abs() + 0.02 * v), driven_by(|_, v| 0.2 * (v / 0.01).tanh())] {
        let matrix = Variation::new().run(&model, &start, 3.0).unwrap().matrix;
        let h = 1e-5;
        let solver = Dop853::new().rtol(1e-13).atol(1e-15);
        let end = |q: f64, v: f64| solver.end(&model, &State::new(0.0, &[q], &[v]), 3.0).unwrap();
        for (j, [dq, dv]) in [[h, 0.0], [0.0, h]].into_iter().enumerate() {
            let [one, other] = [end(1.0 + dq, 0.3 + dv), end(1.0 - dq, 0.3 - dv)];
            let by = [one.q[0] - other.q[0], one.v[0] - other.v[0]].map(|d| d / (2.0 * h));
            assert!((0..2).all(|i| (matrix[(i, j)] - by[i]).abs() < 1e-6), "{matrix} {by:?}");
        }
    }
}
