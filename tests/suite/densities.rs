//! Averaged power densities and decibels: sines, Parseval's theorem, white noise, a second method.

use crate::api::*;
use proptest::prelude::*;
use rand_distr::StandardNormal;
use std::f64::consts::{PI, TAU};

const WINDOWS: [Window; 5] =
    [Window::Rectangular, Window::Hann, Window::Hamming, Window::Blackman, Window::FlatTop];

/// A sine of amplitude A on a line: its amplitude, and its mean square A²/2, with every window and overlap.
#[test]
fn a_sine() {
    for (n, samples) in [(64, 640), (50, 503)] {
        for window in WINDOWS {
            for overlap in [0.0, 0.5, 0.75] {
                let x: Vec<f64> =
                    (0..samples).map(|i| 3.0 * (TAU * 9.0 * f64::from(i) / n as f64 + 0.4).cos()).collect();
                let welch = Welch::new(n).window(window).overlap(overlap);
                let density = welch.density(&x, 0.01).unwrap();
                assert!((density.amplitudes()[9] - 3.0).abs() < 1e-12, "{window:?}");
                assert!((density.mean_square() - 4.5).abs() < 1e-12, "{window:?}");
                assert!((density.frequencies()[9] - 9.0 / (n as f64 * 0.01)).abs() < 1e-12);
                assert!((density.orders(density.frequencies()[3]).unwrap()[9] - 3.0).abs() < 1e-12);
                let stride = (n as f64 * (1.0 - overlap)).round() as usize;
                assert_eq!(density.segments(), (samples as usize - n) / stride + 1);
            }
        }
    }
    // The width of the Hann window is 1.5 lines, that of the flat top 3.77.   Source: Harris 1978; Heinzel 2002.
    let x = vec![1.0; 1000];
    for (window, lines) in [(Window::Rectangular, 1.0), (Window::Hann, 1.5), (Window::FlatTop, 3.77)] {
        let density = Welch::new(1000).window(window).density(&x, 0.5).unwrap();
        assert!((density.noise_bandwidth() * 500.0 - lines).abs() < 1e-3, "{}", density.noise_bandwidth());
        assert!((density.amplitudes()[0] - 1.0).abs() < 1e-12);
    }
}

/// A constant vanishes from centred segments.
#[test]
fn centred_segments() {
    let x: Vec<f64> = (0..256).map(|i| 5.0 + (TAU * f64::from(i) / 16.0).sin()).collect();
    let density = Welch::new(64).centred().density(&x, 1.0).unwrap();
    assert!((density.mean_square() - 0.5).abs() < 1e-12 && density.amplitudes()[0] < 1e-12);
    let kept = Welch::new(64).density(&x, 1.0).unwrap();
    assert!((kept.mean_square() - 25.5).abs() < 1e-12 && (kept.amplitudes()[0] - 5.0).abs() < 1e-12);
}

proptest! {
    /// Parseval: Σ S Δf is the mean of the squares weighted by w², over all segments; with one segment the
    /// averaged amplitudes are those of the spectrum.
    #[test]
    fn parseval(x in prop::collection::vec(-10.0..10.0f64, 20..60), n in 2..20usize, w in 0..5usize) {
        let window = WINDOWS[w];
        let density = Welch::new(n).window(window).overlap(0.5).density(&x, 0.25).unwrap();
        let weights = window.coefficients(n).unwrap();
        let stride = ((n as f64 * 0.5).round() as usize).max(1);
        let sum: f64 = x
            .windows(n)
            .step_by(stride)
            .map(|s| s.iter().zip(&weights).map(|(x, w)| (x * w).powi(2)).sum::<f64>())
            .sum();
        let square: f64 = weights.iter().map(|w| w * w).sum();
        let expected = sum / (square * density.segments() as f64);
        prop_assert!((density.mean_square() - expected).abs() < 1e-12 * expected.max(1.0));

        let (one, spectrum) = (
            Welch::new(n).window(window).density(&x[..n], 0.25).unwrap(),
            Spectrum::new(&x[..n], 0.25, window).unwrap(),
        );
        for (a, b) in one.amplitudes().iter().zip(spectrum.amplitudes()) {
            prop_assert!((a - b).abs() < 1e-10, "{a} {b}");
        }
        prop_assert_eq!(one.frequencies(), spectrum.frequencies());
    }
}

/// White noise of variance σ² has the one-sided density 2 σ² Δt. The mean over the inner lines has a standard
/// error of less than 1/√(number of independent samples) of it.
#[test]
fn white_noise() {
    let (sigma, spacing, count, n) = (3.0, 0.02, 1 << 16, 256);
    let normal = HeldProcess::new(1.0, StandardNormal).unwrap().seed(7);
    let x: Vec<f64> = (0..count).map(|k| sigma * normal.held(0, k)).collect();
    for window in [Window::Hann, Window::Rectangular, Window::Blackman] {
        let density = Welch::new(n).window(window).density(&x, spacing).unwrap();
        let inner = &density.values()[4..n / 2 - 4];
        let mean = inner.iter().sum::<f64>() / inner.len() as f64;
        let expected = 2.0 * sigma * sigma * spacing;
        println!("{window:?}: {}", mean / expected);
        assert!((mean / expected - 1.0).abs() < 4.0 / (0.5 * count as f64).sqrt());
        // Single lines scatter by about √(segments) less than their mean.
        let worst = inner.iter().map(|s| (s / expected - 1.0).abs()).fold(0.0, f64::max);
        assert!(worst < 6.0 / (0.5 * density.segments() as f64).sqrt(), "{worst}");
        let levels = density.decibels(expected).unwrap();
        assert!((levels[40] - 10.0 * (density.values()[40] / expected).log10()).abs() < 1e-12);
    }
}

/// Short uncorrelated pulses of impulse P at the rate ν have the density 2 ν P² (Campbell's theorem), which is
/// the meaning of the squares in the rattle index.
#[test]
fn density_of_impulses() {
    let (impulse, spacing, count) = (0.3f64, 1e-3, 1 << 16);
    let normal = HeldProcess::new(1.0, StandardNormal).unwrap().seed(11);
    let mut hits = 0u32;
    let x: Vec<f64> = (0..count)
        .map(|k| {
            let z = normal.held(0, k);
            // About one in ten samples, with either sign.
            if z.abs() < 1.6449 {
                0.0
            } else {
                hits += 1;
                (impulse / spacing).copysign(z)
            }
        })
        .collect();
    let time = count as f64 * spacing;
    let density = Welch::new(256).density(&x, spacing).unwrap();
    let inner = &density.values()[4..124];
    let mean = inner.iter().sum::<f64>() / inner.len() as f64;
    let expected = 2.0 * f64::from(hits) * impulse * impulse / time;
    assert!((mean / expected - 1.0).abs() < 0.03, "{}", mean / expected);
    let summary = ImpactSummary {
        count: u64::from(hits),
        time,
        rms_impulse: Some(impulse),
        ..ImpactSummary::default()
    };
    let index = summary.rattle_index(1.0, 1.0).unwrap();
    assert!((2.0 * index * index / expected - 1.0).abs() < 1e-12);
}

#[test]
fn decibels() {
    let x: Vec<f64> = (0..64).map(|i| 0.02 * (TAU * 5.0 * f64::from(i) / 64.0).sin()).collect();
    let spectrum = Spectrum::new(&x, 1.0, Window::Rectangular).unwrap();
    assert!((spectrum.decibels(2e-5).unwrap()[5] - 60.0).abs() < 1e-12);
    let silent = Spectrum::new(&[0.0; 8], 1.0, Window::Hann).unwrap();
    assert_eq!(silent.decibels(1.0).unwrap()[2], f64::NEG_INFINITY);
    assert_eq!(Welch::new(4).density(&[0.0; 8], 1.0).unwrap().decibels(1.0).unwrap()[2], f64::NEG_INFINITY);
    for reference in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(spectrum.decibels(reference).is_err(), "{reference}");
    }
    assert!((PI - spectrum.decibels(0.02 / 10f64.powf(PI / 20.0)).unwrap()[5]).abs() < 1e-12);
}

#[test]
fn refused_input() {
    let x = [1.0, 2.0, 3.0, 4.0];
    let few = |name: &str, value, min| Err(ParameterError::TooFew { name: name.into(), value, min });
    assert_eq!(Welch::new(1).density(&x, 1.0), few("samples in a segment", 1, 2));
    assert_eq!(Welch::new(5).density(&x, 1.0), few("samples", 4, 5));
    assert_eq!(Welch::new(usize::MAX).density(&x, 1.0), few("samples", 4, usize::MAX));
    for overlap in [-0.1, 1.0, f64::NAN] {
        assert!(Welch::new(2).overlap(overlap).density(&x, 1.0).is_err(), "{overlap}");
    }
    assert!(Welch::new(2).overlap(1.0 - 1e-16).density(&x, 1.0).unwrap().segments() == 3);
    for spacing in [0.0, -1.0, f64::NAN, 1e60] {
        assert!(Welch::new(2).density(&x, spacing).is_err(), "{spacing}");
    }
    assert!(matches!(Welch::new(2).density(&[1.0, f64::NAN], 1.0), Err(ParameterError::NotFinite { .. })));
    assert!(matches!(Welch::new(2).density(&[1e200, 1e200], 1.0), Err(ParameterError::Overflow { .. })));
    let density = Welch::new(2).density(&x, 1.0).unwrap();
    for wrong in [0.0, -1.0, f64::NAN] {
        assert!(density.decibels(wrong).is_err() && density.orders(wrong).is_err());
    }
}

/// Independent normal values have the density 2 σ² Δt on all lines. Of the intervals of all lines of 60 records the
/// stated share contains it. Segments overlap by half; lines beside each other are correlated, so that some 2500
/// intervals count as independent.
#[test]
fn intervals_of_densities_cover() {
    let (spacing, deviation) = (0.25, 3.0);
    let normal = rand_distr::Normal::new(0.0, deviation).unwrap();
    let process = HeldProcess::new(spacing, normal).unwrap();
    let truth = 2.0 * deviation * deviation * spacing;
    let densities: Vec<_> = (0..60)
        .map(|member| {
            let path = process.clone().member(member).path(0);
            let samples: Vec<f64> =
                (0..128 * 12).map(|i| path.at((f64::from(i) + 0.5) * spacing, Side::After)).collect();
            Welch::new(128).density(&samples, spacing).unwrap()
        })
        .collect();
    // 23 segments; one in two overlaps the next: their correlation is (1/6)².
    let degrees = densities[0].degrees_of_freedom();
    assert!((degrees - 46.0 / (1.0 + 2.0 * (22.0 / 23.0) / 36.0)).abs() < 0.02, "{degrees}");
    for level in [0.9, 0.95] {
        let (mut inside, mut all) = (0, 0);
        for density in &densities {
            let [low, high] = density.confidence(level).unwrap();
            let values = density.values();
            for value in &values[2..values.len() - 2] {
                all += 1;
                inside += usize::from(low * value < truth && truth < high * value);
            }
        }
        let share = inside as f64 / all as f64;
        // Three standard deviations of a share of 2500.
        let slack = 3.0 * (level * (1.0 - level) / 2500.0).sqrt();
        assert!((share - level).abs() < slack, "{share} at {level}");
    }
    assert!(densities[0].confidence(1.0).is_err() && densities[0].confidence(f64::NAN).is_err());
}
