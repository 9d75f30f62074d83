//! When a motion counts as repeating: distances are shares of its own range, and the rigid motion is left
//! out.

use crate::api::*;
use gear_dynamics::models::Oscillator;
use gear_dynamics::trains::SpurPair;
use std::f64::consts::TAU;

fn one_point() -> Sweep {
    Sweep::new(Axis::of_values("only", &[0.0]).unwrap())
}

/// Period multiple and last return (`Row::change`) of one model, with tables and with located edges.
fn rows<M: Periodic + Clone + Sync>(model: &M, start: &State, settle: usize) -> [(Option<usize>, f64); 2] {
    let sweep = one_point().settle(settle).measure(6);
    let family = |_: &Point<'_>| Ok::<_, ParameterError>(model.clone());
    let begin = |_: &Point<'_>, _: &M| Ok::<_, ParameterError>(start.clone());
    let of = |rows: Rows| {
        let row = rows.get(0).unwrap();
        (row.period_multiple(), row.change())
    };
    let located = Located(Dop853::new().rtol(1e-10).atol(1e-12));
    [
        of(sweep.of(&TableRk4::new(256), family).start(begin).run().unwrap()),
        of(sweep.of(&located, family).start(begin).run().unwrap()),
    ]
}

/// x'' + c x' + x = cos(w t - φ) with φ the lag of the motion, so that it is strobed at its maximum, where
/// its velocity is zero.
#[derive(Clone)]
struct AtItsCrest {
    damping: f64,
    frequency: f64,
}

impl Model for AtItsCrest {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let lag = (-self.damping * self.frequency).atan2(1.0 - self.frequency * self.frequency);
        a[0] = (self.frequency * u[0] - lag).cos() - self.damping * v[0] - q[0];
    }
}

impl Periodic for AtItsCrest {
    fn period(&self) -> f64 {
        TAU / self.frequency
    }
}

#[test]
fn a_motion_strobed_at_its_crest_has_a_period() {
    let model = AtItsCrest { damping: 0.5, frequency: 0.38 };
    for (period, change) in rows(&model, &State::at_rest(1), 20) {
        assert!(period == Some(1) && change < 1e-8, "{period:?} {change:e}");
    }
    // There the velocity is zero up to rounding.
    let settled =
        Settle::new().run(&Dop853::new().rtol(1e-10).atol(1e-12), &model, &State::at_rest(1)).unwrap();
    assert!(settled.state.v[0].abs() < 1e-8 && settled.period_multiple == 1);
}

/// A motor and a load that turn at a mean speed. The twist x = q1 - q2 is excited: x'' + 0.4 x' + 3 x + x³ =
/// 2 cos t.
#[derive(Clone)]
struct Turning;

impl Model for Turning {
    fn dof(&self) -> usize {
        2
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let (x, rate) = (q[0] - q[1], v[0] - v[1]);
        let shaft = 0.2 * rate + 1.5 * x + 0.5 * x.powi(3) - u[0].cos();
        (a[0], a[1]) = (-shaft, shaft);
    }
}

impl Periodic for Turning {
    fn period(&self) -> f64 {
        TAU
    }
}

#[test]
fn a_model_that_turns_settles_in_its_relative_motion() {
    let start = State::new(0.0, &[30.0, 29.9], &[80.0, 80.0]);
    let solver = Dop853::new().rtol(1e-12).atol(1e-12);
    let steady = Settle::new().tolerance(1e-7).run(&solver, &Turning, &start).unwrap();
    assert_eq!(steady.period_multiple, 1);
    // The steady state contains the rigid motion.
    assert!((steady.state.q[0] - 30.0 - 80.0 * steady.state.t).abs() < 1.0);
    let twist = |state: &State| state.q[0] - state.q[1];
    let later = solver.end(&Turning, &steady.state, steady.state.t + TAU).unwrap();
    assert!((twist(&later) - twist(&steady.state)).abs() < 1e-6 && later.q[0] > steady.state.q[0] + 400.0);
    for (period, change) in rows(&Turning, &start, 30) {
        assert!(period == Some(1) && change < 1e-6, "{period:?} {change:e}");
    }
}

/// A clutch with a damping of 0.2 x' alone slips: no force depends on its twist, and the velocities repeat. The mean
/// slip is 1/0.2.
#[test]
fn a_slipping_clutch_settles_but_for_its_twist() {
    #[derive(Clone)]
    struct Slipping;
    impl Model for Slipping {
        fn dof(&self) -> usize {
            2
        }
        fn accel(&self, u: &[f64], _: &[f64], v: &[f64], a: &mut [f64]) {
            let clutch = 0.2 * (v[0] - v[1]);
            (a[0], a[1]) = (1.0 + u[0].cos() - clutch, clutch - 1.0);
        }
    }
    impl Periodic for Slipping {
        fn period(&self) -> f64 {
            TAU
        }
    }
    let steady = Settle::new().max_periods(40).run(&Dop853::new(), &Slipping, &State::at_rest(2)).unwrap();
    // x'' = 2 + cos t - 0.4 x' of the twist x.
    let slip = steady.state.v[0] - steady.state.v[1];
    assert!((slip - 5.0 - 0.4 / 1.16).abs() < 1e-7, "{slip}");
    for (period, change) in rows(&Slipping, &State::at_rest(2), 30) {
        assert!(period == Some(1) && change < 1e-6, "{period:?} {change:e}");
    }
}

/// The face gear pair at speeds at which a small difference shrinks by a factor of 1e9 in a turn, as in
/// examples/bifurcation.rs.
#[test]
fn the_pair_repeats_where_its_exponents_are_far_below_zero() {
    let sweep = Sweep::new(Axis::of_values("speed", &[103.0, 106.0, 130.0]).unwrap()).settle(20).measure(6);
    let rows = sweep
        .of(&Located(Dop853::new().rtol(1e-8).atol_each(&[1e-13, 1e-14])), |p| {
            NfgPair::of_reading(
                &NfgParams { speed: p["speed"], ..NfgParams::table1() },
                NfgReading::published_on_base_radius(),
            )
        })
        .start(|_, pair| pair.on_drive_flank())
        .run()
        .unwrap();
    for row in rows.iter() {
        println!("{}: {:?}, {:e}", row.point()["speed"], row.period_multiple(), row.change());
    }
    assert!(rows.iter().all(|row| row.period_multiple() == Some(1)));
    assert_eq!(rows.iter().count(), 3);
}

/// Three equal oscillators around a body whose forces on it cancel: only rounding moves the body.
struct Balanced;

impl Model for Balanced {
    fn dof(&self) -> usize {
        4
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let mut push = 0.0;
        for k in 0..3 {
            let toward = (std::f64::consts::TAU / 3.0 * k as f64).cos();
            let d = q[k] - 0.3 * q[3] * toward;
            let force = d + 0.2 * d * d * d;
            a[k] = (0.8 * u[0]).cos() - 0.1 * v[k] - force;
            push += force * toward;
        }
        a[3] = push - 0.02 * v[3] - 5.0 * q[3];
    }
}

impl Periodic for Balanced {
    fn period(&self) -> f64 {
        std::f64::consts::TAU / 0.8
    }
}

#[test]
fn a_body_that_rounding_alone_moves_does_not_hide_the_period() {
    let steady = Settle::new().run(&Dop853::new(), &Balanced, &State::at_rest(4)).unwrap();
    assert_eq!(steady.period_multiple, 1);
    assert!(steady.state.q[3].abs() < 1e-13 && steady.state.q[0] > 1.4, "{:?}", steady.state);
    let points = Points::from(Axis::of_values("x", &[0.0]).unwrap());
    let sweep = Sweep::new(points).settle(80).measure(4);
    let family = |_: &Point<'_>| Ok::<_, ParameterError>(Balanced);
    let rows = sweep.of(&TableRk4::new(400), family).start(|_, _| State::at_rest(4)).run().unwrap();
    assert_eq!(rows.get(0).unwrap().period_multiple(), Some(1));
}

/// If the tolerance is below rounding, the motion settles when its states agree to rounding.
#[test]
fn returns_to_rounding_settle_at_any_tolerance() {
    let settle = |tolerance: f64| {
        Settle::new().tolerance(tolerance).max_periods(400).run(&Dop853::new(), &Balanced, &State::at_rest(4))
    };
    let coarse = settle(1e-9).unwrap();
    assert!(coarse.change > 1e-12 && coarse.change <= 1e-9, "{}", coarse.change);
    let fine = settle(1e-300).unwrap();
    // Rounding replaces the tolerance, and the change says so.
    assert!(fine.change > 1e-300 && fine.change < 1e-10, "{}", fine.change);
    for bad in [0.0, 1.0, f64::INFINITY, f64::NAN] {
        let error = settle(bad).unwrap_err().to_string();
        let allowed = if bad.is_finite() { "in (0, 1)" } else { "a finite number" };
        assert!(error.contains("tolerance is") && error.contains(allowed), "{error}");
    }
}

/// q'' + d q' + q = cos wt: the distance from the orbit is change μ/(1 - μ), μ = e^(-d T/2).
///
/// The pair of multipliers turns, and the change beats: for some of the frequencies the last one is near a node.
#[test]
fn the_error_of_settling_is_estimated_by_the_contraction() {
    for k in 0..60 {
        let (omega, damping) = (0.9 + 0.011 * f64::from(k), [0.5, 0.1, 0.02][k as usize % 3]);
        let swing = gear_dynamics::model::from_fn(1, move |t, q, v, a| {
            a[0] = (omega * t).cos() - damping * v[0] - q[0];
        });
        let swing = swing.unwrap().with_period(std::f64::consts::TAU / omega).unwrap();
        let settle = Settle::new().tolerance(1e-6).max_periods(2000);
        let steady = settle.run(&Dop853::new().rtol(1e-11).atol(1e-12), &swing, &State::at_rest(1)).unwrap();
        let bottom = (1.0 - omega * omega).powi(2) + (damping * omega).powi(2);
        let amplitude = 1.0 / bottom.sqrt();
        let away = [
            (steady.state.q[0] - (1.0 - omega * omega) / bottom) / (2.0 * amplitude),
            (steady.state.v[0] - damping * omega * omega / bottom) / (2.0 * amplitude * omega),
        ];
        let away = away[0].abs().max(away[1].abs());
        // The changes λ^k c of a multiplier λ add up to cλ/(1 - λ), which the estimate bounds by c|λ|/(1 - |λ|).
        // One component holds the norm to a factor of a few.
        let period = std::f64::consts::TAU / omega;
        let (size, angle) =
            ((-0.5 * damping * period).exp(), (1.0 - 0.25 * damping * damping).sqrt() * period);
        let more = (1.0 - size * angle.cos()).hypot(size * angle.sin()) / (1.0 - size);
        assert!(away < 4.0 * steady.error(), "{omega} {damping}: {away} {steady:?}");
        assert!(steady.error() < 20.0 * more * away, "{omega} {damping}: {more} {away} {steady:?}");
        assert!(steady.error() > 0.2 * steady.change || damping > 0.3);
    }
}

/// x'' = F + P cos w t - c x' - f(x) with f(d) = (1 - e^{-r y})/r past each edge ±1, y the depth.
///
/// On the flank that the motion does not touch, the law is -(e^{r (x + 1)} - 1)/r at x = 1: of the size 4400.
#[derive(Clone)]
struct FarFlank {
    rate: f64,
    load: f64,
    /// Linear flanks instead: stiffness of the lower one; the upper one has 1.
    lower: Option<f64>,
}

impl FarFlank {
    fn on(&self, piece: Piece, x: f64) -> f64 {
        match (piece, self.lower) {
            (Piece::Lower, Some(stiffness)) => return stiffness * (x + 1.0),
            (Piece::Upper, Some(_)) => return x - 1.0,
            _ => {}
        }
        match piece {
            Piece::Lower => ((self.rate * (x + 1.0)).exp() - 1.0) / self.rate,
            Piece::Gap => 0.0,
            Piece::Upper => (1.0 - (-self.rate * (x - 1.0)).exp()) / self.rate,
        }
    }
    fn piece(x: f64) -> Piece {
        if x < -1.0 {
            Piece::Lower
        } else if x > 1.0 {
            Piece::Upper
        } else {
            Piece::Gap
        }
    }
}

impl Model for FarFlank {
    fn dof(&self) -> usize {
        1
    }
    fn drives(&self) -> usize {
        1
    }
    fn drive(&self, t: f64, _: Side, u: &mut [f64]) {
        u[0] = self.load + 0.02 * (0.5 * t).cos();
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = u[0] - 0.05 * v[0] - self.on(FarFlank::piece(q[0]), q[0]);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let force = self.on(FarFlank::piece(q[0]), q[0]);
        out[0] =
            Contact { deflection: q[0], rate: v[0], lower: -1.0, upper: 1.0, force, ..Contact::default() };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = u[0] - 0.05 * v[0] - self.on(pieces[0], q[0]);
    }
}

impl Periodic for FarFlank {
    fn period(&self) -> f64 {
        TAU / 0.5
    }
}

/// Distance of the settled state from that of 400 more periods, as a share of the range, and the periods.
fn off(model: &FarFlank, start: &State) -> (f64, usize) {
    let solver = Dop853::new().rtol(1e-12).atol(1e-14);
    let steady = Settle::new().tolerance(1e-9).run(&solver, model, start).unwrap();
    let later = steady.state.t + 400.0 * model.period();
    let end = solver.end(model, &steady.state, later).unwrap();
    let mut statistics = Statistics::new(model, &["q0"]).unwrap();
    solver.run(model, &end, later + model.period(), &mut statistics).unwrap();
    let range = statistics.summary("q0").unwrap().peak_to_peak();
    ((steady.state.q[0] - end.q[0]).abs() / range, steady.periods)
}

/// The law of a flank that the motion does not touch weighs nothing: the settled state is that of 400 more
/// periods. Transients fall by e^{-c T/2} = 0.73 in a period, so that the error is below four times the
/// tolerance; the motion is compared to 100 times.
#[test]
fn a_flank_that_is_not_touched_does_not_settle_a_motion() {
    for (rate, load) in [(5.0, 0.06), (4.0, 0.08), (6.0, 0.05), (5.5, 0.1)] {
        let model = FarFlank { rate, load, lower: None };
        let start = State::new(0.0, &[1.0 - (1.0 - rate * load).ln() / rate], &[0.0]);
        let (apart, periods) = off(&model, &start);
        assert!(apart < 1e-7, "{rate} {load}: {apart:e} after {periods} periods");
    }
}

/// Nor does a flank that the transient touches: rounding errors of earlier periods do not count, and a hard
/// flank is weighed in the short steps that pass it. Starts that meet the far flank in the first periods, by
/// the exponential law and by a flank of 100 to 1e8 times the stiffness of the other one.
#[test]
fn a_flank_that_the_transient_touches_does_not_settle_a_motion() {
    for (rate, load, q) in [(5.0, 0.06, -1.3), (7.0, 0.05, -1.1)] {
        let (apart, periods) = off(&FarFlank { rate, load, lower: None }, &State::new(0.0, &[q], &[0.0]));
        assert!(apart < 1e-7, "{rate} {load}: {apart:e} after {periods} periods");
    }
    for lower in [1e2, 3e2, 1e3, 1e5, 1e8] {
        for v in [-3.0, 0.0] {
            let model = FarFlank { rate: 1.0, load: 0.06, lower: Some(lower) };
            let (apart, periods) = off(&model, &State::new(0.0, &[2.0], &[v]));
            assert!(apart < 1e-7, "{lower} {v}: {apart:e} after {periods} periods");
        }
    }
}

/// Flights far longer than the steps on a hard flank, and periods far longer than those of the contact: the rounding errors of
/// a step on the flank do not act over the length of a flight. What settles repeats, by another solver.
#[test]
fn long_flights_and_hard_flanks_do_not_settle_a_motion() {
    let (mut settled, mut refused) = (0, 0);
    let mut check = |model: &dyn Periodic, start: &State, of: f64, what: &str| {
        for solver in [&Dop853::new() as &dyn Integrator, &Taylor::new()] {
            match Settle::new().max_periods(60).run(solver, model, start) {
                Ok(steady) => {
                    let period = steady.period_multiple as f64 * model.period();
                    let again = Taylor::new().end(model, &steady.state, steady.state.t + period).unwrap();
                    let apart = (again.q[0] - steady.state.q[0]).abs() / of;
                    assert!(apart < 1e-5, "{what}: {apart:e} after {} periods", steady.periods);
                    settled += 1;
                }
                Err(SettleError::Aperiodic { .. }) => refused += 1,
                Err(error) => panic!("{what}: {error}"),
            }
        }
    };
    // A chaotic motion with impacts on flanks from hard to nearly rigid.
    for stiffness in [3e5, 1e6, 1e7, 6e8] {
        let given = [
            ("speed", 1.3),
            ("damping", 0.4),
            ("mesh stiffness", stiffness),
            ("mean force", -0.5),
            ("force", 0.6),
            ("half backlash", 1.0),
        ];
        let model = Oscillator::new(&given).unwrap();
        check(&model, &State::new(0.0, &[-0.99], &[0.0]), 0.1, &format!("flank {stiffness:e}"));
    }
    // A slow transmission error that lifts a light load off its flank.
    for (speed, share, zeta) in
        [(0.1, 0.3, 0.1), (0.03, 0.1, 0.1), (0.01, 0.1, 0.1), (0.003, 0.3, 0.002), (0.001, 0.1, 0.02)]
    {
        let load = share * speed * speed * 0.3;
        let pair = SpurPair::of_numbers(zeta * speed, load, &[0.2], &[0.3]).unwrap();
        let train = pair.parts().unwrap().build("driver", speed).unwrap();
        check(&train, &State::new(0.0, &[1.3], &[0.0]), 0.3, &format!("speed {speed}"));
    }
    assert!(settled >= 6 && refused >= 10, "{settled} {refused}");
}

/// q1'' = cos t - 4 q1 - 0.1 q1' settles. Beside it q0 is connected to nothing: it may turn at a constant mean speed, but
/// not gain speed in every period. If it follows q1, its speed is constant as soon as q1 has settled.
#[test]
fn an_unconnected_body_that_accelerates_does_not_settle() {
    let beside = |mean: f64, coupled: f64, speed: f64| {
        let model = gear_dynamics::model::from_fn(2, move |t, q, v, a| {
            a[0] = mean + (2.0 * t).cos() + coupled * q[1];
            a[1] = t.cos() - 4.0 * q[1] - 0.1 * v[1];
        });
        let start = State::new(0.0, &[0.0, 0.0], &[speed, 0.0]);
        Settle::new().run(&Dop853::new(), &model.unwrap().with_period(TAU).unwrap(), &start)
    };
    for (mean, speed) in [(1.0, 0.0), (-0.01, 50.0)] {
        let error = beside(mean, 0.0, speed).unwrap_err();
        let SettleError::Accelerates { coordinate: 0, gain, ref last, .. } = error else { panic!("{error}") };
        assert!((gain - mean * TAU).abs() < 1e-5 && error.last() == Some(last));
    }
    for (coupled, speed) in [(0.0, 50.0), (1.0, 50.0), (1.0, 0.0)] {
        assert_eq!(beside(0.0, coupled, speed).unwrap().period_multiple, 1);
    }
    // A body alone, with nothing beside it.
    let alone = gear_dynamics::model::from_fn(1, |_, _, _, a| a[0] = 1.0).unwrap().with_period(TAU).unwrap();
    let error = Settle::new().max_periods(5).run(&Dop853::new(), &alone, &State::at_rest(1)).unwrap_err();
    assert!(matches!(error, SettleError::Accelerates { coordinate: 0, periods: 5, .. }), "{error}");
}

/// q'' + d q' + k q = cos w t with a mode that makes 7.02 turns in a period, from states around the orbit: the transient
/// turns by 0.15 rad a period, and its change is below its decay for several periods in a row.
#[test]
fn the_error_of_settling_is_estimated_where_the_transient_turns_slowly() {
    let (w, damping) = (1.65, 0.0725);
    let mode: f64 = 7.023 * w;
    let stiffness = mode * mode + 0.25 * damping * damping;
    let swing = gear_dynamics::model::from_fn(1, move |t, q, v, a| {
        a[0] = (w * t).cos() - damping * v[0] - stiffness * q[0];
    });
    let swing = swing.unwrap().with_period(std::f64::consts::TAU / w).unwrap();
    let bottom = (stiffness - w * w).powi(2) + (damping * w).powi(2);
    let exact = [(stiffness - w * w) / bottom, damping * w * w / bottom];
    let range = 2.0 / bottom.sqrt();
    for k in 0..40 {
        let phase = f64::from(k) * 0.157;
        let start = State::new(
            0.0,
            &[exact[0] + 0.3 * range * phase.cos()],
            &[exact[1] + 0.3 * range * mode * phase.sin()],
        );
        let solver = Dop853::new().rtol(1e-13).atol(1e-16);
        let steady = Settle::new().tolerance(1e-9).max_periods(2000).run(&solver, &swing, &start).unwrap();
        let away = [(steady.state.q[0] - exact[0]) / range, (steady.state.v[0] - exact[1]) / (range * w)];
        let away = away[0].abs().max(away[1].abs());
        assert!(away < 6.0 * steady.error(), "{k}: {away:e} {:e} {steady:?}", steady.error());
    }
}
