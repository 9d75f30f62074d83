//! Deviations from tooth to tooth, confidence intervals of shares and quantiles.

use gear_dynamics::excitation::Excitation;
use gear_dynamics::processes::HeldProcess;
use gear_dynamics::sweep::{Distribution, Proportion};
use gear_dynamics::teeth::{InvoluteGear, QualityGrade, ToothDeviations};
use gear_dynamics::{ParameterError, teeth::TeethError};
use rand_distr::Uniform;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// 1000 gears of each of 4 tooth numbers: no deviation exceeds its tolerance. The cumulative deviation exceeds that
/// of the next finer grade unless the single pitch deviation has reached its limit.
#[test]
fn drawn_gears_satisfy_their_grade() {
    let grade = QualityGrade::new(6).unwrap();
    for teeth in [17, 20, 50, 101] {
        let gear = InvoluteGear::external(teeth, 0.003).unwrap();
        let limits = grade.tolerances(&gear).unwrap();
        for member in 0..1000 {
            let drawn = ToothDeviations::draw(&gear, grade, 3, member, 0).unwrap();
            let shares = [
                drawn.single_pitch() / limits.single_pitch,
                drawn.cumulative_pitch() / limits.cumulative_pitch,
                drawn.profile_slope() / limits.profile_slope,
            ];
            assert!(
                shares.iter().all(|share| *share <= 1.0 + 1e-12),
                "{teeth} teeth, gear {member}: {shares:?}"
            );
            assert!(shares[2] >= FRAC_1_SQRT_2 - 1e-12);
            let bound = shares[0] > 1.0 - 1e-12 || shares[1] >= FRAC_1_SQRT_2 - 1e-12;
            assert!(bound, "{teeth} teeth, gear {member}: {shares:?}");
        }
    }
}

/// The wave passes through the pitch deviations in the middle of the mesh cycles, and a quarter of a tooth later
/// through those of the profile: e = P + ½ H sin zφ.
#[test]
fn the_wave_of_measured_deviations() {
    for z in [3_usize, 4, 7, 24] {
        let pitch: Vec<f64> = (0..z).map(|k| 1e-6 * ((k * k) % 5) as f64).collect();
        let wave = ToothDeviations::measured(&pitch, &vec![8e-6; z]).unwrap().wave().unwrap();
        let bare = ToothDeviations::measured(&pitch, &vec![0.0; z]).unwrap().wave().unwrap();
        for (k, p) in pitch.iter().enumerate() {
            let middle = TAU * (k as f64 + 0.5) / z as f64;
            assert!((wave.value(middle) - p).abs() < 1e-19);
            let profile = wave.value(middle + 0.1 / z as f64) - bare.value(middle + 0.1 / z as f64);
            assert!((profile - 4e-6 * (std::f64::consts::PI + 0.1).sin()).abs() < 1e-18);
        }
        // One tooth alone with a profile deviation: its own slope in its own mesh cycle, none in the middles of others.
        let mut one = vec![0.0; z];
        one[1] = 1e-5;
        let single = ToothDeviations::measured(&vec![0.0; z], &one).unwrap().wave().unwrap();
        let slope = |k: usize| single.jet(TAU * (k as f64 + 0.5) / z as f64).rate / z as f64;
        for k in 0..z {
            let expected = if k == 1 { -0.5e-5 } else { 0.0 };
            assert!((slope(k) - expected).abs() < 1e-18, "z = {z}, tooth {k}: {}", slope(k));
        }
    }
}

#[test]
fn gears_differ_and_can_be_drawn_again() {
    let gear = InvoluteGear::external(24, 0.003).unwrap();
    let draw = |seed, member, place| {
        ToothDeviations::draw(&gear, QualityGrade::new(7).unwrap(), seed, member, place).unwrap()
    };
    assert_eq!(draw(1, 2, 0), draw(1, 2, 0));
    for other in [draw(2, 2, 0), draw(1, 3, 0), draw(1, 2, 1)] {
        assert!(other.pitch().iter().zip(draw(1, 2, 0).pitch()).all(|(a, b)| a != b));
    }
    let large = InvoluteGear::external(1001, 0.003).unwrap();
    let refused = ToothDeviations::draw(&large, QualityGrade::new(6).unwrap(), 0, 0, 0);
    assert!(matches!(refused, Err(TeethError::OutsideMethod { .. })), "{refused:?}");
    let refused = ToothDeviations::measured(&[0.0; 5], &[0.0; 4]);
    assert!(matches!(refused, Err(ParameterError::Length { expected: 5, found: 4, .. })), "{refused:?}");
    assert!(matches!(ToothDeviations::measured(&[0.0; 2], &[0.0; 2]), Err(ParameterError::TooFew { .. })));
}

/// Of 2000 experiments each: intervals of shares and quantiles contain the truth at least as often as they state, up
/// to three standard errors of that count; those of means as often.
#[test]
fn intervals_cover() {
    const EXPERIMENTS: usize = 2000;
    let numbers = HeldProcess::new(1.0, Uniform::new(0.0, 1.0).unwrap()).unwrap().seed(5);
    for level in [0.9, 0.95] {
        let [mut shares, mut quantiles, mut means] = [0, 0, 0];
        for experiment in 0..EXPERIMENTS {
            let n = 30 + experiment % 100;
            let x: Vec<f64> = (0..n as u64).map(|i| numbers.held(experiment as u64, i)).collect();
            let within = |[low, high]: [f64; 2], truth: f64| usize::from(low <= truth && truth <= high);
            let hits = x.iter().filter(|x| **x < 0.13).count() as u64;
            shares += within(Proportion::new(hits, n as u64).unwrap().confidence(level).unwrap(), 0.13);
            let all = Distribution::of_samples(x);
            quantiles += within(all.quantile_confidence(0.4, level).unwrap(), 0.4);
            means += within(all.confidence(level).unwrap(), 0.5);
        }
        let scatter = 3.0 * (EXPERIMENTS as f64 * level * (1.0 - level)).sqrt();
        let least = EXPERIMENTS as f64 * level - scatter;
        for count in [shares, quantiles] {
            assert!(count as f64 >= least && count < EXPERIMENTS, "{level}: {count}");
        }
        // The normal distribution in place of Student's: 30 values cover half a per cent less.
        assert!((means as f64 - EXPERIMENTS as f64 * (level - 0.005)).abs() < scatter, "{level}: {means}");
    }
}

/// Of many values in bins, the interval encloses that of the sorted values.
#[test]
fn quantile_intervals_of_many_values() {
    let n = 20_000_u64;
    let values = (0..n).map(|i| (i * 7919 % n) as f64);
    let [low, high] = Distribution::of_samples(values).quantile_confidence(0.05, 0.95).unwrap();
    // 1000 ± 1.96 √(20000 · 0.05 · 0.95) = 60.4 ranks, and up to two bins of 128.
    assert!((640.0..=940.0).contains(&low) && (1060.0..=1360.0).contains(&high), "{low} {high}");
}

#[test]
fn shares_and_levels_are_checked() {
    assert!(matches!(Proportion::new(0, 0), Err(ParameterError::TooFew { .. })));
    assert!(matches!(Proportion::new(3, 2), Err(ParameterError::TooMany { .. })));
    assert!(matches!(Proportion::new(3, (1 << 32) + 1), Err(ParameterError::TooMany { .. })));
    let many = Proportion::new(1 << 31, 1 << 32).unwrap().confidence(0.95).unwrap();
    for end in many {
        // Half of 2³² trials: ±1.96 standard deviations of 1/2¹⁷.
        assert!(((end - 0.5).abs() * 131_072.0 - 1.96).abs() < 1e-3, "{many:?}");
    }
    let none = Proportion::new(0, 59).unwrap().confidence(0.9).unwrap();
    assert_eq!(none[0], 0.0);
    assert!((none[1] - (1.0 - 0.05f64.powf(1.0 / 59.0))).abs() < 1e-12); // (1 - p)^59 = 0.05
    for level in [0.0, 1.0, -1.0, f64::NAN] {
        let refused = Proportion::new(1, 2).unwrap().confidence(level);
        assert!(
            matches!(refused, Err(ParameterError::OutOfRange { .. } | ParameterError::NotFinite { .. })),
            "{level}: {refused:?}"
        );
        let samples = Distribution::of_samples([1.0, 2.0]);
        assert!(samples.confidence(level).is_err() && samples.quantile_confidence(0.5, level).is_err());
    }
}
