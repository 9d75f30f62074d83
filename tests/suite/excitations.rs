//! Derivatives against differences, edges, fits, combinations.

use approx::assert_relative_eq;
use gear_dynamics::*;
use std::f64::consts::{PI, TAU};

fn all() -> Vec<(&'static str, Wave)> {
    let centre = InstantCentre::new(0.2, 3.0).unwrap();
    let fourier = Fourier::new(2.0, &[[0.5, -0.3], [0.0, 0.2], [0.1, 0.1]], 5.0).unwrap();
    let samples: Vec<f64> = (0..400).map(|i| fourier.value(TAU / 5.0 * f64::from(i) / 400.0, Side::After)).collect();
    vec![
        ("fourier", Wave::new(fourier.clone())),
        ("amplitudes", Wave::new(Fourier::from_amplitudes(1.0, &[[0.4, 0.7], [0.2, -1.0]], 2.0).unwrap())),
        ("shifted", Wave::new(fourier.clone().with_phase(0.9).unwrap())),
        ("radius", Wave::new(centre.radius(0.08).unwrap())),
        ("ratio", Wave::new(centre.ratio(3.5).unwrap())),
        ("forcing", Wave::new(centre.forcing())),
        ("forcing series", Wave::new(centre.forcing_series(7).unwrap())),
        ("table", Wave::new(Table::new(&samples, TAU / 5.0).unwrap())),
        ("sum", Wave::new(Sum::new(vec![Wave::new(fourier.clone()), Wave::new(centre.forcing())]))),
        (
            "product",
            Wave::new(Product::new(vec![
                Wave::new(fourier.clone()),
                Wave::new(centre.ratio(2.0).unwrap()),
                Wave::new(Constant::new(3.0).unwrap()),
            ])),
        ),
        ("scaled", Wave::new(Scaled::new(-2.5, Wave::new(fourier)).unwrap())),
        ("function", Wave::new(Function::new(|t: Jet| (t * 0.3).exp() / ((t * t + 2.0).sqrt() + 1.0) - t.cos()))),
    ]
}

#[test]
fn derivatives_against_differences() {
    for (name, f) in all() {
        let scale = (0..50)
            .map(|i| f.jet(0.1 * f64::from(i), Side::After))
            .fold([0.0f64; 3], |m, j| [m[0].max(j.value.abs()), m[1].max(j.rate.abs()), m[2].max(j.second.abs())]);
        for i in 0..40 {
            let t = 0.017 + 0.083 * f64::from(i);
            let jet = f.jet(t, Side::After);
            let h = 1e-4;
            let at = |k: f64| f.value(t + k * h, Side::After);
            let rate = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h);
            // h² of the fourth derivative and rounding over h².
            let second = (at(1.0) - 2.0 * at(0.0) + at(-1.0)) / (h * h);
            assert!((rate - jet.rate).abs() < 1e-7 * scale[1].max(scale[0]), "{name} at {t}: rate {} against {rate}", jet.rate);
            assert!((second - jet.second).abs() < 2e-4 * scale[2].max(scale[0]), "{name} at {t}: second {} against {second}", jet.second);
            assert_eq!(f.value(t, Side::Before), jet.value);
            assert_eq!(f.rate(t, Side::Before), jet.rate);
        }
    }
}

#[test]
fn periods_are_what_they_say() {
    for (name, f) in all() {
        match f.repeats() {
            Repeats::Every(period) => {
                for t in [0.1, 0.77, 2.3] {
                    assert_relative_eq!(f.value(t, Side::After), f.value(t + period, Side::After), max_relative = 1e-9);
                }
            }
            Repeats::Never => assert_eq!(name, "function"),
            Repeats::Always => panic!("{name} is not constant"),
        }
    }
}

/// Eq. (20) and its series: the coefficients of Eq. (22) are 2 ε and -4 ε².
#[test]
fn the_forcing_of_the_centre() {
    let (eps, w) = (0.2, 3.0);
    let centre = InstantCentre::new(eps, w).unwrap();
    let samples: Vec<f64> = (0..256).map(|i| centre.forcing().value(TAU / w * f64::from(i) / 256.0, Side::After)).collect();
    let series = Fourier::fit(&samples, 3, w).unwrap();
    assert_relative_eq!(series.pairs()[0][1], 2.0 * eps * w * w, max_relative = 1e-13);
    assert_relative_eq!(series.pairs()[1][1], -4.0 * eps * eps * w * w, max_relative = 1e-12);
    // It is the derivative of ω2 = ω1/i12 with ω1 = i_j ω_c.
    let ratio = centre.ratio(1.0).unwrap();
    for t in [0.1, 0.9, 1.7] {
        let speed = Jet::constant(w) / ratio.jet(t, Side::After);
        assert_relative_eq!(speed.rate, centre.forcing().value(t, Side::After), max_relative = 1e-13);
    }
}

#[test]
fn rectangular_wave_and_its_series() {
    let data = crate::data::read("classics.json");
    let example = &data["rect_fourier"]["example"];
    let number = |key: &str| example[key].as_f64().unwrap();
    let wave = RectangularWave::from_contact_ratio(number("eps"), number("kmin"), number("kmax"), 1.0).unwrap();
    assert_eq!(wave.mean(), number("a0"));
    let series = wave.series(5).unwrap();
    for (pair, a) in series.pairs().iter().zip(example["a"].as_array().unwrap()) {
        assert!((pair[0] - a.as_f64().unwrap()).abs() < 1e-15 && pair[1] == 0.0);
    }
    // The series of a shifted wave is the shifted series, and both come close to the wave away from its edges.
    let shifted = wave.with_phase(1.1).unwrap();
    let long = shifted.series(2001).unwrap();
    for t in [-3.21, 0.05, 0.4, 7.7] {
        assert!((long.value(t, Side::After) - shifted.value(t, Side::After)).abs() < 1e-2, "{t}");
    }
    // Edges are exact: each is seen from both sides, and the next one is found from any instant.
    let (mut t, mut levels) = (-2.0, Vec::new());
    for _ in 0..20 {
        let edge = shifted.next_edge(t).unwrap();
        assert!(edge > t);
        assert_ne!(shifted.value(edge, Side::Before), shifted.value(edge, Side::After));
        assert_eq!(shifted.value(edge, Side::Before), shifted.value(0.5 * (edge + t.max(edge - 0.1)), Side::After));
        levels.push(edge);
        t = edge;
    }
    assert!((levels[19] - levels[17] - 1.0).abs() < 1e-12);
    assert_eq!(RectangularWave::new(1.0, 2.0, 0.0, 1.0).unwrap().next_edge(0.0), None);
}

/// A fit returns the coefficients it was sampled from, at any number of samples that can tell the orders apart.
#[test]
fn fit_inverts_sampling() {
    let truth = Fourier::new(3.1, &[[0.9, -0.2], [0.05, 0.0], [0.0, 0.3]], 2.0).unwrap();
    for m in [7, 8, 64, 1001] {
        let samples: Vec<f64> = (0..m).map(|i| truth.value(PI * i as f64 / m as f64, Side::After)).collect();
        let fit = Fourier::fit(&samples, 3, 2.0).unwrap();
        assert!((fit.mean() - 3.1).abs() < 1e-13);
        for (a, b) in fit.pairs().iter().flatten().zip(truth.pairs().iter().flatten()) {
            assert!((a - b).abs() < 1e-13, "{m}");
        }
    }
}

#[test]
fn combined_edges_and_periods() {
    let square = Wave::new(RectangularWave::new(0.0, 1.0, 0.5, 2.0).unwrap());
    let wave = Wave::new(Fourier::new(0.0, &[[1.0, 0.0]], TAU / 3.0).unwrap());
    let sum = Sum::new(vec![square.clone(), wave.clone()]);
    assert_eq!(sum.next_edge(0.0), Some(0.5));
    assert_eq!(sum.repeats(), Repeats::Every(6.0));
    let product = Product::new(vec![square, wave]);
    assert_eq!(product.next_edge(0.6), Some(1.5));
    assert_eq!(product.value(0.5, Side::After), 0.0);
}

/// Laws: pieces meet at the edges, slopes are those of the pieces, and the time-varying width moves both edges.
#[test]
fn contact_laws() {
    let laws: Vec<(AnyLaw, f64)> = vec![
        (AnyLaw::Backlash(Backlash::new(0.7).unwrap()), 0.0),
        (AnyLaw::Asymmetric(AsymmetricBacklash::new(-0.4, 0.9).unwrap().with_slopes(2.0, 0.5).unwrap()), 0.0),
        (AnyLaw::Varying(VaryingBacklash::new(Wave::new(Constant::new(0.3).unwrap()))), 0.0),
        (AnyLaw::Smoothed(SmoothedBacklash::new(0.7, 1e-3).unwrap()), 1e-3),
    ];
    for (law, slack) in &laws {
        let e = law.edges(0.0, Side::After);
        for (piece, x) in [(Piece::Lower, e.lower - 0.3), (Piece::Gap, 0.5 * (e.lower + e.upper)), (Piece::Upper, e.upper + 0.2)] {
            let held: f64 = law.force_on(piece, x, 0.0, e.lower, e.upper);
            assert!((held - law.at(x)).abs() < 1e-15, "{law:?}");
            let h = 1e-6;
            let slope = (law.at(x + h) - law.at(x - h)) / (2.0 * h);
            assert!((slope - law.slope(x)).abs() < 1e-6, "{law:?} at {x}");
        }
        assert!(law.at(e.lower).abs() <= *slack && law.at(e.upper).abs() <= *slack);
    }
    let moving = VaryingBacklash::new(Wave::new(Fourier::new(1.0, &[[0.0, 0.1]], 2.0).unwrap()));
    let e = moving.edges(0.0, Side::After);
    assert_eq!((e.lower, e.upper, e.lower_rate, e.upper_rate), (-1.0, 1.0, -0.2, 0.2));
    // As the rounding shrinks the smoothed law tends to the dead zone, from above on the upper flank.
    for s in [1e-1, 1e-2, 1e-3] {
        let gap = SmoothedBacklash::new(1.0, s).unwrap().at(1.0) - Backlash::new(1.0).unwrap().at(1.0);
        assert!((gap / (0.5 * s) - 1.0).abs() < s);
    }
}

/// A thousand million periods out, the edges of a wave still come one by one, two to a period, and part its levels.
#[test]
fn a_wave_far_out() {
    for period in [1e-3, 0.1, 7.3] {
        let wave = RectangularWave::new(1.0, 2.0, 0.3, period).unwrap().with_phase(0.7).unwrap();
        let begin = 1e9 * period;
        let mut t = begin;
        for count in 0..1000 {
            let edge = wave.next_edge(t).unwrap();
            assert!(edge > t && (count == 0 || edge - t < 0.7 * period * (1.0 + 1e-5)), "{t} {edge}");
            let [before, after] = [Side::Before, Side::After].map(|side| wave.value(edge, side));
            assert!(before != after && wave.value(0.5 * (t + edge), Side::After) == before, "{edge}");
            t = edge;
        }
        assert!(((t - begin) / period - 500.0).abs() < 1.0);
    }
}

/// The common period does not hang on the order, and a ratio whose whole part is lost in its rounding is none.
#[test]
fn common_periods_are_the_same_in_either_order() {
    let every = Repeats::Every;
    assert_eq!((every(1.0).with(every(2e4)), every(2e4).with(every(1.0))), (every(2e4), every(2e4)));
    for (a, b) in
        [(2.0, 3.0), (1.0, 1.0), (0.3, 0.1), (1.0, 12_345.0), (7.0, 9_999.5), (1.0, std::f64::consts::PI), (1e-3, 1e3), (5.0, 1e9)]
    {
        assert_eq!(every(a).with(every(b)), every(b).with(every(a)), "{a} {b}");
    }
    assert_eq!(every(1.0).with(every(std::f64::consts::PI)), Repeats::Never);
    assert!(every(1.0).fits(1e9) && !every(1.0).fits(1e9 + 0.4));
}
