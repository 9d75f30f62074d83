//! Mean and covariance of linearised models under white noise: closed forms, long runs, path integration,
//! refusals.

use crate::api::*;
use gear_dynamics::linear::{LinearError, static_state};
use gear_dynamics::models::Oscillator;
use gear_dynamics::random::{LinearMoments, LongRun, NoisySteps, PathIntegration, WhiteNoise};
use nalgebra::DMatrix;

fn oscillator(constants: &[(&str, f64)]) -> Oscillator {
    Oscillator::new(&[&[("speed", 1.0)], constants].concat()).unwrap()
}

fn bath(coordinate: usize, damping: f64, intensity: f64) -> WhiteNoise {
    WhiteNoise::bath(coordinate, damping, intensity).unwrap()
}

fn on(model: &Oscillator, constant: &str, intensity: f64) -> WhiteNoise {
    WhiteNoise::drives(&[(model.slot(constant).unwrap(), 1.0)], intensity).unwrap()
}

/// Masses in a chain with springs to the ground, and a bath of its own damping c_i on each mass: with the
/// intensities D_i = 2 c_i T/m_i (fluctuation and dissipation) P_qq = T K⁻¹, P_vv = T M⁻¹, P_qv = 0. The
/// masses differ by 10⁴, the frequencies are some 10⁵.
#[test]
fn baths_of_one_temperature() {
    let (masses, springs) = ([1e-3, 2.0, 0.05, 10.0, 0.3], [3e8, 1e7, 5e8, 2e6, 8e7]);
    let (n, temperature) = (masses.len(), 1e-4);
    let stiffness = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => springs[i] + if i + 1 < n { springs[i + 1] } else { 1e7 },
        1 => -springs[i.max(j)],
        _ => 0.0,
    });
    let k = stiffness.clone();
    let chain = from_fn(n, move |_, q, _, a| {
        for i in 0..n {
            a[i] = -(0..n).map(|j| k[(i, j)] * q[j]).sum::<f64>() / masses[i];
        }
    });
    let damping = |i: usize| 20.0 * (1.0 + i as f64);
    let noise = (0..n).map(|i| bath(i, damping(i), 2.0 * damping(i) * temperature / masses[i]));
    let noise: Vec<WhiteNoise> = noise.collect();
    let found = LinearMoments::about(&chain.unwrap(), &State::at_rest(n), &noise).unwrap();
    assert_eq!(found.mean(), &State::at_rest(n));
    let compliance = stiffness.try_inverse().unwrap() * temperature;
    let size =
        |i: usize| if i < n { compliance[(i, i)].sqrt() } else { (temperature / masses[i - n]).sqrt() };
    for (i, j) in (0..2 * n).flat_map(|i| (0..2 * n).map(move |j| (i, j))) {
        let exact = match (i < n, j < n) {
            (true, true) => compliance[(i, j)],
            (false, false) if i == j => temperature / masses[i - n],
            _ => 0.0,
        };
        let off = (found.covariance()[(i, j)] - exact) / (size(i) * size(j));
        // The equations divide dampings of 20 by frequencies of 10⁵, and slopes by differences have 11 digits.
        assert!(off.abs() < 1e-6, "{i} {j}: {off:e}");
    }
}

/// q'' + c q' + ω² q = F + noise of intensity N, and √D ξ on the damping (Stratonovich: c' = c - D/2) or on
/// the stiffness. With m = F/ω²:
///
/// damping: E[v²] (2 c' - D) = N;   stiffness: E[v²] (2 c - D/ω²) = N + D m²;   E[q²] = m² + E[v²]/ω²
#[test]
fn noise_on_damping_and_stiffness() {
    let (c, square, force, intensity, d) = (0.3, 4.0, 2.0, 0.1, 0.05);
    let model = oscillator(&[("damping", c), ("linear stiffness", square), ("mean force", force)]);
    let mean = force / square;
    for (constant, exact) in [
        ("damping", intensity / (2.0 * c - 2.0 * d)),
        ("linear stiffness", (intensity + d * mean * mean) / (2.0 * c - d / square)),
    ] {
        let noise = [bath(0, 0.0, intensity), on(&model, constant, d)];
        let found = LinearMoments::about(&model, &State::at_rest(1), &noise).unwrap();
        assert!((found.mean().q[0] - mean).abs() < 1e-12 && found.mean().v[0].abs() < 1e-12);
        let covariance = found.covariance();
        for (value, exact) in
            [(covariance[(0, 0)], exact / square), (covariance[(0, 1)], 0.0), (covariance[(1, 1)], exact)]
        {
            assert!((value - exact).abs() < 1e-12, "{constant}: {value} {exact}");
        }
    }
    // Damping in the bath and damping of the model add up.
    let split = LinearMoments::about(
        &oscillator(&[("damping", 0.1), ("linear stiffness", square), ("mean force", force)]),
        &State::new(0.0, &[0.2], &[0.7]),
        &[bath(0, 0.2, intensity)],
    );
    let whole = LinearMoments::about(&model, &State::at_rest(1), &[bath(0, 0.0, intensity)]).unwrap();
    let apart = split.unwrap().covariance() - whole.covariance();
    assert!(apart.amax() < 1e-12);
}

/// The boundaries of the mean square: D < c for noise on the damping, D < 2 c ω² on the stiffness.
#[test]
fn the_mean_square_grows_beyond_the_closed_boundary() {
    let (c, square) = (0.1, 2.0);
    let model = oscillator(&[("damping", c), ("linear stiffness", square)]);
    for (constant, boundary) in [("damping", c), ("linear stiffness", 2.0 * c * square)] {
        let at = |share: f64| {
            let noise = [bath(0, 0.0, 0.1), on(&model, constant, share * boundary)];
            LinearMoments::about(&model, &State::at_rest(1), &noise)
        };
        assert!(at(1.0 - 1e-9).unwrap().covariance()[(1, 1)] > 1e6);
        assert_eq!(at(1.0 + 1e-9).unwrap_err(), LinearError::MeanSquareGrows, "{constant}");
    }
}

/// Two bodies on springs, pressed together by opposite forces over a mesh of stiffness 2 and half backlash b.
#[derive(PartialEq)]
struct Pressed;

impl Shape for Pressed {
    fn size(&self) -> Size {
        Size { dof: 2, contacts: 1, constants: 3, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "force", "spring"].map(|name| Channel::new(name, "1")).into()
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        _: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let (d, rate, b) = (q[0] - q[1], v[0] - v[1], S::from(0.5));
        let at = Deflection { d, rate, lower: -b, upper: b };
        let force = law.force(i, &Backlash::new(1.0).unwrap(), at) * 2.0;
        Contact { deflection: d, rate, lower: -b, upper: b, force, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [force, spring] = u.constants();
        let mesh = self.contact(law, 0, u, q, v).force;
        a[0] = force - spring * q[0] - v[0] * 0.1 - mesh;
        a[1] = mesh - force - spring * q[1] * 0.5 - v[1] * 0.3;
    }
}

/// Long runs under noise on force, spring and one body: means and mean squares lie within the intervals of
/// 99.99 %. The edge is six standard deviations away.
#[test]
fn long_runs_agree() {
    let given = [("speed", 1.0), ("force", 5.0), ("spring", 1.0)];
    let model = Machine::of_constants(Pressed, &given).unwrap();
    let on = |name: &str, intensity: f64| {
        WhiteNoise::drives(&[(model.slot(name).unwrap(), 1.0)], intensity).unwrap()
    };
    let noise = [bath(0, 0.2, 0.1), on("force", 0.05), on("spring", 0.005)];
    let rest = static_state(&model, 0.0).unwrap().state;
    let moments = LinearMoments::about(&model, &rest, &noise).unwrap();
    let channels = ["q0", "q1", "v0", "v1"];
    let long = LongRun::new(5.0, 60.0).unwrap().members(64).channels(&channels);
    let seen = long.run(&NoisySteps::new(48, &noise).seed(2), &model, &rest).unwrap();
    assert_eq!(seen.contact(0).unwrap().gap.mean(), 0.0);
    let means = [&moments.mean().q[..], &moments.mean().v].concat();
    for (i, channel) in channels.iter().enumerate() {
        let square = moments.covariance()[(i, i)] + means[i] * means[i];
        for (estimate, exact) in
            [(seen.mean(channel).unwrap(), means[i]), (seen.mean_square(channel).unwrap(), square)]
        {
            let [low, high] = estimate.confidence(0.9999).unwrap();
            assert!(low < exact && exact < high, "{channel}: {low} {exact} {high}");
            assert!(high - low < 0.3 * square.max(0.2), "{channel}: {}", high - low);
        }
    }
}

/// Path integration of a pair that is pressed on one flank, nine standard deviations from its edge.
#[test]
fn path_integration_agrees() {
    let given = [("damping", 0.5), ("mesh stiffness", 1.0), ("half backlash", 0.5), ("mean force", 3.0)];
    let pair = oscillator(&given);
    let rest = static_state(&pair, 0.0).unwrap().state;
    let moments = LinearMoments::about(&pair, &rest, &[bath(0, 0.0, 0.1)]).unwrap();
    let method = PathIntegration::new(0.1, [1.4, 5.6], [-2.0, 2.0]).unwrap().panels(5);
    let density = method.stationary(&pair).unwrap();
    let mean = moments.mean().q[0];
    for (value, exact) in [
        (density.mean(|x, _| x), mean),
        (density.mean(|x, _| (x - mean) * (x - mean)), moments.covariance()[(0, 0)]),
        (density.mean(|x, v| (x - mean) * v), moments.covariance()[(0, 1)]),
        (density.mean(|_, v| v * v), moments.covariance()[(1, 1)]),
    ] {
        assert!((value - exact).abs() < 1e-4, "{value} {exact}");
    }
}

#[test]
fn what_has_no_moments_is_refused() {
    let about = |model: &dyn Model, noise: &[WhiteNoise]| {
        LinearMoments::about(model, &State::at_rest(model.dof()), noise).unwrap_err()
    };
    let noise = [bath(0, 0.1, 0.1)];
    // A body without a spring diffuses, one on a spring that pushes leaves, one without damping keeps its
    // energy.
    assert!(matches!(about(&oscillator(&[]), &noise), LinearError::Grows { rate } if rate.abs() < 1e-12));
    let away = about(&oscillator(&[("linear stiffness", -9.0)]), &noise);
    assert!(matches!(away, LinearError::Grows { rate } if (rate - 2.95).abs() < 0.01), "{away}"); // √9 - c/2
    let swing = about(&oscillator(&[("linear stiffness", 1.0)]), &[]);
    assert!(matches!(swing, LinearError::Grows { rate } if rate.abs() < 1e-12), "{swing}");
    // In the gap of a dead zone nothing holds the body.
    let pair = oscillator(&[("damping", 0.1), ("mesh stiffness", 1.0), ("half backlash", 0.5)]);
    assert!(matches!(about(&pair, &noise), LinearError::Grows { .. }));

    let stable = oscillator(&[("damping", 0.1), ("linear stiffness", 1.0)]);
    let text = |noise: &[WhiteNoise]| about(&stable, noise).to_string();
    assert!(text(&[bath(1, 0.1, 0.1)]).starts_with("coordinate of the bath is 1.0"));
    let none = WhiteNoise::drives(&[(99, 1.0)], 0.1).unwrap();
    assert!(text(&[none]).starts_with("drive slot 99 does not exist"));
    assert!(LinearMoments::about(&stable, &State::at_rest(2), &noise).is_err());
    assert!(LinearMoments::about(&stable, &State::new(0.0, &[f64::NAN], &[0.0]), &noise).is_err());
    let nan = from_fn(1, |_, _, _, a| a[0] = f64::NAN).unwrap();
    assert_eq!(about(&nan, &noise), LinearError::NotFinite { t: 0.0 });
    let many = from_fn(64, |_, q, v, a| (0..64).for_each(|i| a[i] = -q[i] - v[i])).unwrap();
    assert!(matches!(about(&many, &noise), LinearError::Parameter(ParameterError::TooMany { .. })));
    // Without noise the motion stands still.
    let still = LinearMoments::about(&stable, &State::at_rest(1), &[]).unwrap();
    assert_eq!(still.covariance(), &DMatrix::zeros(2, 2));
}

/// An intensity that is no normal number gives variances of 0, none below.
#[test]
fn the_smallest_intensities_give_no_negative_variance() {
    for intensity in [5e-324, 2e-320, 1e-310] {
        for (damping, stiffness) in [(0.1, 0.8), (0.7, 0.3), (0.3, 3.0)] {
            let model = oscillator(&[("damping", damping), ("linear stiffness", stiffness)]);
            let noise = [bath(0, damping, intensity)];
            let found = LinearMoments::about(&model, &State::at_rest(1), &noise).unwrap();
            assert!(found.covariance().iter().all(|x| *x == 0.0 || *x > f64::MIN_POSITIVE), "{intensity:e}");
        }
    }
}
