//! White noise in lanes against closed forms, and what its results promise.

use gear_dynamics::contact::{Contact, Deflection, PieceChoice};
use gear_dynamics::model::{Channel, Drives, Scalar, Size};
use gear_dynamics::models::Oscillator;
use gear_dynamics::ode::Exhausted;
use gear_dynamics::random::{Estimate, LongRun, NoiseError, NoiseStatistics, NoisySteps, WhiteNoise};
use gear_dynamics::sweep::InstructionSet;
use gear_dynamics::sweep::Watch;
use gear_dynamics::{Backlash, Machine, ParameterError, Shape, State};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Stiffness 1, half backlash b, no damping of its own.
fn dead_zone(b: f64, damping: f64) -> Oscillator {
    let given = [("speed", 1.0), ("mesh stiffness", 1.0), ("half backlash", b), ("damping", damping)];
    Oscillator::new(&given).unwrap()
}

fn bath(damping: f64, intensity: f64) -> WhiteNoise {
    WhiteNoise::bath(0, damping, intensity).unwrap()
}

/// Estimates with their closed forms: P(gap), rate at each edge, mean squares of v and x, mean impact speed.
///
/// p(x, v) ∝ exp(-β (v²/2 + G(x))), β = 2c/D; Z = 2b + √(2π/β). On a flank the depth has half a normal
/// distribution of variance 1/β: ∫(b + y)² e^{-βy²/2} dy over y > 0 is s (b² + 2b √(2/(πβ)) + 1/β), s =
/// √(π/(2β)).
fn closed_forms(seen: &NoiseStatistics, b: f64, beta: f64) -> Vec<(&'static str, Estimate, f64)> {
    let contact = seen.contact(0).unwrap();
    let z = 2.0 * b + (TAU / beta).sqrt();
    let rate = 1.0 / ((TAU * beta).sqrt() * z);
    let flank = (PI / (2.0 * beta)).sqrt() * (b * b + 2.0 * b * (2.0 / (PI * beta)).sqrt() + 1.0 / beta);
    let square = (2.0 * b * b * b / 3.0 + 2.0 * flank) / z;
    vec![
        ("gap", contact.gap, 2.0 * b / z),
        ("lower impacts", contact.impacts[0], rate),
        ("upper impacts", contact.impacts[1], rate),
        ("velocity", seen.mean_square("v0").unwrap(), 1.0 / beta),
        ("coordinate", seen.mean_square("q0").unwrap(), square),
        ("speed", contact.speed[1], (PI / (2.0 * beta)).sqrt()),
        ("flight", contact.flight, 2.0 * b / z / (2.0 * rate)),
    ]
}

/// Long runs of dead zones in a bath: every closed form lies within the interval of 99.99 %, whose half width
/// over the value is at most `width`, for impact speeds and flights too.
fn dead_zones_in_baths(members: usize, periods: f64, steps: usize, width: f64, cases: &[(f64, f64)]) {
    for &(c, b) in cases {
        let (solver, pair) = (NoisySteps::new(steps, &[bath(c, c)]).seed(7), dead_zone(b, 0.0));
        let long = LongRun::new(4.0 / c, periods).unwrap().members(members);
        let seen = long.channels(&["q0", "v0"]).run(&solver, &pair, &State::at_rest(1)).unwrap();
        for (name, estimate, exact) in closed_forms(&seen, b, 2.0) {
            let [low, high] = estimate.confidence(0.9999).unwrap();
            assert!(low < exact && exact < high, "{c} {b} {name}: {low} {exact} {high}");
            let [low, high] = estimate.confidence(0.95).unwrap();
            assert!(high - low < 2.0 * width * exact, "{c} {b} {name}: {}", (high - low) / exact);
        }
    }
}

#[test]
fn dead_zone_in_a_bath() {
    dead_zones_in_baths(16, 120.0, 20, 0.15, &[(1.0, 0.5)]);
}

/// Three dampings, two gaps, 0.3 %.
#[test]
#[ignore = "6 × 10⁸ steps: cargo test --release --test suite dead_zones_to_three_per_mille -- --ignored"]
fn dead_zones_to_three_per_mille() {
    let cases = [(0.1, 0.5), (0.3, 0.5), (1.0, 0.5), (0.1, 1.0), (0.3, 1.0), (1.0, 1.0)];
    dead_zones_in_baths(1024, 3000.0, 32, 0.003, &cases);
}

/// Impact speeds have a Rayleigh distribution: its quantile p is √(-2 ln(1 - p)/β).
#[test]
fn impact_speeds_are_rayleigh() {
    let long = LongRun::new(3.0, 150.0).unwrap().members(16);
    let seen =
        long.run(&NoisySteps::new(20, &[bath(1.0, 1.0)]), &dead_zone(0.25, 0.0), &State::at_rest(1)).unwrap();
    let speeds = &seen.contact(0).unwrap().speeds[0];
    for p in [0.25, 0.5, 0.75] {
        let (x, exact) = (speeds.quantile(p).unwrap(), (-(1.0f64 - p).ln()).sqrt());
        // Standard error √(p (1 - p)/n)/density, density 2 x (1 - p); impacts count as independent.
        let error = (p * (1.0 - p) / speeds.count() as f64).sqrt() / (2.0 * exact * (1.0 - p));
        assert!(
            (x - exact).abs() < 4.0 * error + speeds.resolution() && error < 0.05,
            "{p} {x} {exact} {error}"
        );
    }
}

/// The bias over the step, without chance: the step of a linear oscillator is an affine map y → A y + noise,
/// whose matrix R is measured with intensity 0. Its stationary mean square of v follows from P = A P Aᵀ + Q.
/// Damping in the algebra, kicks before and after.
#[test]
fn bias_of_a_linear_oscillator_has_order_two() {
    let free =
        |c: f64| Oscillator::new(&[("speed", 1.0), ("linear stiffness", 1.0), ("damping", c)]).unwrap();
    let bias = |steps: usize, c: f64| {
        let solver = NoisySteps::new(steps, &[bath(0.0, 0.0)]).lanes::<1>();
        let column = |q: f64, v: f64| {
            let end = &solver.ends(&free(c), &State::new(0.0, &[q], &[v]), 1.0 / steps as f64, 1).unwrap()[0];
            [end.q[0], end.v[0]]
        };
        let (a, kick) = ([column(1.0, 0.0), column(0.0, 1.0)], 0.5 * TAU / steps as f64 * 2.0 * c); // D = 2 c
        let mut p = [1.0, 0.0, 1.0]; // P_qq, P_qv, P_vv
        for _ in 0..4000 {
            let [qq, qv, vv] = [p[0], p[1], p[2] + kick];
            let of = |i: usize, j: usize| {
                a[0][i] * (a[0][j] * qq + a[1][j] * qv) + a[1][i] * (a[0][j] * qv + a[1][j] * vv)
            };
            p = [of(0, 0), of(0, 1), of(1, 1) + kick];
        }
        [p[0] - 1.0, p[2] - 1.0]
    };
    for i in [0, 1] {
        let [coarse, fine] = [bias(20, 0.5)[i], bias(40, 0.5)[i]];
        let slope = (coarse / fine).abs().log2();
        assert!(slope > 1.95 && coarse.abs() < 0.02, "{i}: {coarse} {fine} {slope}"); // 3.9 and 2.0
    }
}

/// The same over the kink of a dead zone, by long runs: at 12 steps a quarter of the bias at 6 steps.
#[test]
#[ignore = "10⁸ steps: cargo test --release --test suite bias_over_a_kink -- --ignored"]
fn bias_over_a_kink_has_order_two() {
    let run = |steps: usize| {
        let solver = NoisySteps::new(steps, &[bath(0.0, 1.0)]);
        let long = LongRun::new(10.0, 8000.0).unwrap().members(1024);
        let seen =
            long.channels(&["q0", "v0"]).run(&solver, &dead_zone(0.5, 0.5), &State::at_rest(1)).unwrap();
        closed_forms(&seen, 0.5, 1.0)
    };
    let (coarse, fine) = (run(6), run(12));
    for ((name, x, exact), (_, y, _)) in coarse.iter().zip(&fine) {
        let [bias, finer] = [x, y].map(|estimate| (estimate.mean() / exact - 1.0, estimate.relative_error()));
        println!(
            "{name}: {:+.3}% ± {:.3}%, {:+.3}% ± {:.3}%",
            100.0 * bias.0,
            100.0 * bias.1,
            100.0 * finer.0,
            100.0 * finer.1
        );
        // Order 2 or better, within four standard errors.
        assert!(finer.0.abs() < 0.27 * bias.0.abs() + 4.0 * (finer.1 + 0.27 * bias.1), "{name}");
    }
}

/// Intervals of 90 and 95 % contain the closed form in such a share of `repeats` runs, within 3.3 standard
/// errors.
fn intervals_cover(repeats: u64) {
    let (pair, z) = (dead_zone(0.5, 0.0), 1.0 + PI.sqrt());
    let mut inside = [[0.0; 2]; 2];
    for seed in 0..repeats {
        let solver = NoisySteps::new(12, &[bath(1.0, 1.0)]).lanes::<8>().seed(seed);
        let long = LongRun::new(1.5, 14.0).unwrap().members(8).spans(2);
        let seen = long.channels(&["v0"]).run(&solver, &pair, &State::new(0.0, &[0.7], &[0.5])).unwrap();
        let estimates = [(seen.contact(0).unwrap().gap, 1.0 / z), (seen.mean_square("v0").unwrap(), 0.5)];
        for (inside, (estimate, exact)) in inside.iter_mut().zip(estimates) {
            for (inside, level) in inside.iter_mut().zip([0.9, 0.95]) {
                let [low, high] = estimate.confidence(level).unwrap();
                *inside += if low < exact && exact < high { 1.0 } else { 0.0 };
            }
        }
    }
    println!("{inside:?} of {repeats}");
    for share in inside {
        for (share, level) in share.iter().zip([0.9, 0.95f64]) {
            let (share, error) = (share / repeats as f64, (level * (1.0 - level) / repeats as f64).sqrt());
            assert!((share - level).abs() < 3.3 * error, "{level}: {share}");
        }
    }
}

#[test]
fn intervals_cover_in_small_runs() {
    intervals_cover(200);
}

#[test]
#[ignore = "4000 runs: cargo test --release --test suite intervals_cover_in_many_runs -- --ignored"]
fn intervals_cover_in_many_runs() {
    intervals_cover(2000);
}

/// Growth rate of the mean square of q'' + c q' + q = 0 with noise on one constant: the logarithm of the
/// largest eigenvalue of the map of (q², qv, v²) over a turn. The motion is linear in its start: two starts
/// with the same numbers give the whole map.
fn growth(constant: &str, c: f64, intensity: f64, members: usize, seed: u64) -> f64 {
    let given = [("speed", 1.0), ("linear stiffness", 1.0), ("damping", c)];
    let free = Oscillator::new(&given).unwrap();
    let noise = WhiteNoise::drives(&[(free.slot(constant).unwrap(), 1.0)], intensity).unwrap();
    let solver = NoisySteps::new(32, &[noise]).seed(seed);
    let ends = |q: f64, v: f64| solver.ends(&free, &State::new(0.0, &[q], &[v]), 1.0, members).unwrap();
    let mut map = [[0.0; 3]; 3];
    for (x, y) in ends(1.0, 0.0).iter().zip(&ends(0.0, 1.0)) {
        let [(a, b), (c, d)] = [x, y].map(|end| (end.q[0], end.v[0]));
        let one = [[a * a, 2.0 * a * c, c * c], [a * b, a * d + b * c, c * d], [b * b, 2.0 * b * d, d * d]];
        map.iter_mut().flatten().zip(one.iter().flatten()).for_each(|(sum, x)| *sum += x / members as f64);
    }
    let mut moments = [1.0, 0.0, 1.0];
    let mut factor = 1.0;
    for _ in 0..200 {
        moments = map.map(|row| row.iter().zip(moments).map(|(a, x)| a * x).sum::<f64>());
        factor = moments[0] + moments[2];
        moments = moments.map(|x| x / factor);
    }
    factor.ln() / TAU
}

/// Intensity at which the mean square neither grows nor decays, over the closed form `exact`, with its
/// standard error from 8 seeds. `damping`: the constant c that belongs to an intensity.
fn boundary(constant: &str, exact: f64, damping: impl Fn(f64) -> f64, members: usize) -> Estimate {
    let one = |seed: u64| {
        let [low, high] = [0.9, 1.1].map(|x| growth(constant, damping(x * exact), x * exact, members, seed));
        0.9 + 0.2 * low / (low - high)
    };
    Estimate::of(&(0..8).map(one).collect::<Vec<f64>>()).unwrap()
}

/// Random damping (Ito): the mean square is bounded for D < 2c. E[v²]' = -2c E[v²] - 2 E[qv] + D E[v²] with
/// E[qv] = 0 and E[v²] = E[q²] at the boundary. The solver takes the equation in the sense of Stratonovich:
/// its damping is c + D/2. Random stiffness: D < 2 c ω² in both senses, since the noise multiplies q.
fn boundaries_of_mean_squares(members: usize, width: f64) {
    let c = 0.1;
    for (constant, ito) in [("damping", 0.5), ("linear stiffness", 0.0)] {
        let found = boundary(constant, 2.0 * c, |d| c + ito * d, members);
        println!("{constant}: {} ± {}", found.mean(), found.standard_error());
        let off = (found.mean() - 1.0).abs();
        assert!(off < width && off < 5.0 * found.standard_error(), "{constant}: {found:?}");
    }
}

#[test]
fn mean_squares_are_bounded_as_the_closed_form_says() {
    boundaries_of_mean_squares(96, 0.3);
}

#[test]
#[ignore = "10⁸ steps: cargo test --release --test suite mean_squares_to_one_per_cent -- --ignored"]
fn mean_squares_to_one_per_cent() {
    boundaries_of_mean_squares(100_000, 0.01);
}

/// The same bits for any lanes, instructions and threads.
#[test]
fn lanes_and_threads_change_no_bit() {
    let pair = dead_zone(0.5, 0.1);
    let noise = [
        bath(0.2, 0.3),
        WhiteNoise::drives(&[(pair.slot("damping").unwrap(), 1.0)], 0.02).unwrap(),
        WhiteNoise::drives(&[(pair.slot("mean force").unwrap(), 2.0)], 0.02).unwrap(),
    ];
    let long = LongRun::new(1.0, 3.0).unwrap().members(10).channels(&["q0", "mesh force"]);
    let rest = State::at_rest(1);
    let solver = NoisySteps::new(24, &noise).seed(3);
    let expected = long.run(&solver, &pair, &rest).unwrap();
    assert_eq!(long.run(&solver.clone().lanes::<1>(), &pair, &rest).unwrap(), expected);
    assert_eq!(long.run(&solver.clone().lanes::<4>(), &pair, &rest).unwrap(), expected);
    for set in InstructionSet::available() {
        assert_eq!(long.run(&solver.clone().instructions(set), &pair, &rest).unwrap(), expected);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(|| long.run(&solver, &pair, &rest)).unwrap(), expected);
    assert_ne!(long.run(&solver.seed(4), &pair, &rest).unwrap(), expected);
}

/// The drives of a periodic model: the mean response to A cos t is that of the equation without noise.
#[test]
fn mean_of_a_forced_linear_oscillator_is_its_response() {
    let given = [("speed", 1.0), ("linear stiffness", 4.0), ("force", 3.0)];
    let forced = Oscillator::new(&given).unwrap(); // q'' + q' + 4 q = 3 cos t: q = (9 cos t + 3 sin t)/10
    let solver = NoisySteps::new(32, &[bath(1.0, 0.02)]);
    let ends = solver.ends(&forced, &State::new(0.0, &[0.9], &[0.3]), 1.25, 128).unwrap();
    let mean = |of: &dyn Fn(&State) -> f64| ends.iter().map(of).sum::<f64>() / 128.0;
    // Standard deviations √(D/(2 c k)) = 0.05 and √(D/(2 c)) = 0.1, over √128; the bias of 32 steps is below
    // 0.01.
    assert!((mean(&|end| end.q[0]) - 0.3).abs() < 0.018 + 0.01, "{}", mean(&|end| end.q[0]));
    assert!((mean(&|end| end.v[0]) + 0.9).abs() < 0.036 + 0.01, "{}", mean(&|end| end.v[0]));
}

/// A cancelled run keeps the members so far.
#[test]
fn cancelled_runs_keep_their_members() {
    let (pair, stop) = (dead_zone(0.5, 0.0), Arc::new(AtomicBool::new(false)));
    let solver = NoisySteps::new(12, &[bath(1.0, 1.0)]).lanes::<4>();
    let count = |done: usize, all: usize| stop.store(done >= 12 && all == 4000, Ordering::Relaxed);
    let long = LongRun::new(1.0, 2.0).unwrap().members(4000);
    let seen = long
        .clone()
        .watch(Watch::new().progress(count).cancel(stop.clone()))
        .run(&solver, &pair, &State::at_rest(1))
        .unwrap();
    assert!((12..400).contains(&seen.members()), "{}", seen.members());
    stop.store(true, Ordering::Relaxed);
    let error = long.watch(Watch::new().cancel(stop)).run(&solver, &pair, None).unwrap_err();
    assert_eq!(error, NoiseError::Exhausted { exhausted: Exhausted::Cancelled, done: 0, all: 4000 });
}

/// q'' = -b² q with the edges ±b: noise on b is neither affine nor on a fixed edge.
#[derive(PartialEq)]
struct Odd;

impl Shape for Odd {
    fn size(&self) -> Size {
        Size { dof: 1, contacts: 1, constants: 3, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "edge", "factor"].map(|name| Channel::new(name, "1")).into()
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let [b, _] = u.constants();
        let at = Deflection { d: q[0], rate: v[0], lower: -b, upper: b };
        let force = law.force(i, &Backlash::new(1.0).unwrap(), at);
        Contact { deflection: q[0], rate: v[0], lower: -b, upper: b, force, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [_, factor] = u.constants();
        a[0] = -(factor * factor * q[0]) - self.contact(law, 0, u, q, v).force;
    }
}

#[test]
fn bad_input_is_refused() {
    let (pair, start) = (dead_zone(0.5, 0.0), State::at_rest(1));
    let ends =
        |noise: WhiteNoise| NoisySteps::new(8, &[noise]).ends(&pair, &start, 1.0, 1).unwrap_err().to_string();
    assert!(WhiteNoise::bath(0, 0.1, f64::NAN).is_err() && WhiteNoise::bath(0, 0.1, -1.0).is_err());
    assert!(WhiteNoise::drives(&[], 1.0).is_err() && WhiteNoise::drives(&[(0, 1e51)], 1.0).is_err());
    let no_coordinate = ends(WhiteNoise::bath(1, 0.1, 0.1).unwrap());
    assert!(no_coordinate.starts_with("coordinate of the bath is 1.0"), "{no_coordinate}");
    let no_slot = ends(WhiteNoise::drives(&[(99, 1.0)], 0.1).unwrap());
    assert!(no_slot.starts_with("drive slot 99 does not exist"), "{no_slot}");
    let odd = Machine::of_constants(Odd, &[("speed", 1.0), ("edge", 0.5), ("factor", 2.0)]).unwrap();
    let of = |name: &str| {
        let noise = WhiteNoise::drives(&[(odd.slot(name).unwrap(), 1.0)], 0.1).unwrap();
        NoisySteps::new(8, &[noise]).ends(&odd, &start, 1.0, 1).unwrap_err().to_string()
    };
    assert!(of("edge").contains("moves the edges or the deflection of contact 0"), "{}", of("edge"));
    assert!(of("factor").contains("not affine"), "{}", of("factor"));
    let solver = NoisySteps::new(8, &[bath(0.1, 0.1)]);
    let long = |settle: f64, measure: f64| LongRun::new(settle, measure).unwrap();
    assert!(LongRun::new(-1.0, 1.0).is_err() && LongRun::new(0.0, 0.0).is_err());
    let few = long(0.0, 1.0).members(7).run(&solver, &pair, &start).unwrap_err();
    assert_eq!(few, ParameterError::TooFew { name: "members × spans".into(), value: 7, min: 8 }.into());
    assert!(long(0.0, 1.0).channels(&["no"]).run(&solver, &pair, &start).is_err());
    assert!(long(0.0, 1e20).run(&solver, &pair, &start).is_err());
    assert!(NoisySteps::new(0, &[]).ends(&pair, &start, 1.0, 1).is_err());
    assert!(solver.ends(&pair, &State::at_rest(2), 1.0, 1).is_err());
    assert!(solver.ends(&pair, &State::new(1.0, &[0.0], &[0.0]), 1.0, 1).is_err());
    let seen = long(0.0, 1.0).run(&solver, &pair, &start).unwrap();
    assert!(seen.contact(1).is_err() && seen.mean("q0").is_err());
    for level in [0.0, 1.0, -0.5, f64::NAN] {
        assert!(seen.contact(0).unwrap().gap.confidence(level).is_err(), "{level}");
    }
    // Intensities that overflow are refused; the largest that is allowed lets the motion diverge or is finite.
    assert!(WhiteNoise::bath(0, 0.1, 1e51).is_err() && WhiteNoise::drives(&[(1, 1.0)], 1e308).is_err());
    let most = NoisySteps::new(8, &[bath(0.1, 1e50)]).ends(&pair, &start, 1.0, 1).unwrap();
    assert!(most[0].q[0].is_finite() && most[0].v[0].is_finite());
    // A spring that pushes away: the motion grows without bound.
    let away = Oscillator::new(&[("speed", 1.0), ("linear stiffness", -9.0)]).unwrap();
    let error = LongRun::new(0.0, 100.0).unwrap().run(&solver, &away, &start).unwrap_err();
    assert!(matches!(error, NoiseError::Diverged { member: 0, .. }), "{error}");
    // After 15 turns q is e^(3 · 94) = 10^122: finite, but the error of its mean square is not.
    let far = LongRun::new(0.0, 15.0).unwrap().channels(&["q0"]).run(&solver, &away, &start);
    assert!(matches!(far, Err(NoiseError::Diverged { member: 0, .. })), "{far:?}");
}

/// Two crossings of an edge within a step are not seen: the rate at which q'' = -q - c q' + √D ξ crosses 1
/// upwards is e^{-1/2}/(2π) (Rice), less the share (a h)²/(24 ⟨v²⟩) = h²/24 with a = 1 at the edge and ⟨v²⟩ = 1.
#[test]
fn rates_of_impacts_lack_what_crosses_twice_in_a_step() {
    let given = [("speed", 1.0), ("linear stiffness", 1.0), ("mesh stiffness", 0.0), ("half backlash", 1.0)];
    let free = Oscillator::new(&given).unwrap();
    let exact = (-0.5f64).exp() / TAU;
    let steps = 12;
    let solver = NoisySteps::new(steps, &[bath(0.3, 0.6)]).seed(3);
    let long = LongRun::new(10.0, 3000.0).unwrap().members(64);
    let seen = long.run(&solver, &free, &State::at_rest(1)).unwrap().contact(0).unwrap();
    let h = TAU / steps as f64;
    // The share has terms of higher order: h⁴/640 for a constant acceleration.
    let missing = h * h / 24.0;
    for rate in seen.impacts {
        let apart = rate.mean() / exact - 1.0 + missing;
        assert!(apart.abs() < 4.0 * rate.relative_error() + h.powi(4) / 640.0, "{steps}: {apart}");
        assert!(missing > 5.0 * rate.relative_error(), "{steps}: {}", rate.relative_error());
    }
}
