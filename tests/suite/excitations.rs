//! Excitations and waves: derivatives against differences, edges, fits, sums and products; contact laws at
//! their edges.

use crate::api::*;
use crate::common::random::Random;
use approx::assert_relative_eq;
use std::f64::consts::{PI, TAU};

fn all() -> Vec<(&'static str, Wave)> {
    let centre = InstantCentre::new(0.2).unwrap();
    let fourier = Fourier::new(2.0, &[[0.5, -0.3], [0.0, 0.2], [0.1, 0.1]]).unwrap();
    let samples: Vec<f64> = (0..400).map(|i| fourier.value(TAU * f64::from(i) / 400.0)).collect();
    let wave = Wave::new(fourier.clone());
    vec![
        ("fourier", wave.clone()),
        ("amplitudes", Wave::new(Fourier::of_amplitudes(1.0, &[[0.4, 0.7], [0.2, -1.0]]).unwrap())),
        ("ahead", wave.clone().per_turn(3).unwrap().with_phase(0.9).unwrap()),
        ("radius", Wave::new(centre.radius(0.08).unwrap())),
        ("ratio", Wave::new(centre.ratio(3.5).unwrap())),
        ("rotation", Wave::new(centre.rotation())),
        ("rotation series", Wave::new(centre.rotation_series(7).unwrap())),
        ("table", Wave::new(Table::new(&samples).unwrap())),
        ("sum", Wave::new(Sum::new(vec![wave.clone().per_turn(2).unwrap(), Wave::new(centre.rotation())]))),
        (
            "product",
            Wave::new(Product::new(vec![
                wave.clone(),
                Wave::new(centre.ratio(2.0).unwrap()),
                Wave::constant(3.0).unwrap(),
            ])),
        ),
        ("scaled", Wave::new(Scaled::new(-2.5, wave).unwrap())),
        (
            "function",
            Wave::new(Function::new(|x: Jet| {
                (x.sin() * 0.3).exp() / ((x.cos() * x.cos() + 2.0).sqrt() + 1.0) - x.cos()
            })),
        ),
    ]
}

#[test]
fn derivatives_against_differences() {
    for (name, f) in all() {
        let scale = (0..50).map(|i| f.jet(0.1 * f64::from(i), Side::After)).fold([0.0f64; 3], |m, j| {
            [m[0].max(j.value.abs()), m[1].max(j.rate.abs()), m[2].max(j.second.abs())]
        });
        for i in 0..40 {
            let x = 0.017 + 0.083 * f64::from(i);
            let jet = f.jet(x, Side::After);
            let h = 1e-4;
            let at = |k: f64| f.value(x + k * h, Side::After);
            let rate = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h);
            // The error is h² times the fourth derivative, and rounding over h².
            let second = (at(1.0) - 2.0 * at(0.0) + at(-1.0)) / (h * h);
            assert!(
                (rate - jet.rate).abs() < 1e-7 * scale[1].max(scale[0]),
                "{name} at {x}: rate {} against {rate}",
                jet.rate
            );
            assert!(
                (second - jet.second).abs() < 2e-4 * scale[2].max(scale[0]),
                "{name} at {x}: second {} against {second}",
                jet.second
            );
            assert_eq!(f.jet(x, Side::Before), jet);
        }
    }
}

/// A wave of order n has the period 2π/n, also after a thousand periods.
#[test]
fn waves_repeat() {
    for (name, f) in all() {
        for x in [0.1, 0.77, 2.3, 6.0] {
            for turns in [-1e3, -1.0, 1.0, 1e3] {
                let later = f.value(x + turns * TAU / f64::from(f.order()), Side::After);
                assert_relative_eq!(f.value(x, Side::After), later, max_relative = 1e-9, epsilon = 1e-10);
            }
        }
        assert!(f.next_edge(0.3).is_none(), "{name} is smooth");
    }
}

/// Waves of equal functions are equal. Another order, phase or number makes them unequal. A closure equals
/// only its own copies.
#[test]
fn waves_are_compared_by_their_functions() {
    for (name, f) in all() {
        assert_eq!(f, f.clone(), "{name}");
        assert_ne!(f, f.clone().per_turn(2).unwrap(), "{name}");
        assert_ne!(f, f.clone().with_phase(0.1).unwrap(), "{name}");
        let again = all().into_iter().find(|(other, _)| *other == name).unwrap().1;
        assert_eq!(f == again, name != "function", "{name}");
        for (other, g) in all() {
            assert!(other == name || f != g, "{name} {other}");
        }
    }
}

/// Liu 2021, Eq. (20) and its series: the coefficients of Eq. (22) are 2 ε and -4 ε².
#[test]
fn the_forcing_of_the_centre() {
    let eps = 0.2;
    let centre = InstantCentre::new(eps).unwrap();
    let samples: Vec<f64> =
        (0..256).map(|i| centre.rotation().jet(TAU * f64::from(i) / 256.0).rate).collect();
    let series = Fourier::fit(&samples, 3).unwrap();
    assert_relative_eq!(series.pairs()[0][1], 2.0 * eps, max_relative = 1e-13);
    assert_relative_eq!(series.pairs()[1][1], -4.0 * eps * eps, max_relative = 1e-12);
    // The forcing is the derivative of ω2 = ω1/i12 with ω1 = i_j ω_c.
    let ratio = centre.ratio(1.0).unwrap();
    for x in [0.1, 0.9, 1.7] {
        let speed = Jet::constant(1.0) / ratio.jet(x);
        assert_relative_eq!(speed.value, centre.rotation().value(x), max_relative = 1e-14);
        assert_relative_eq!(speed.rate, centre.rotation().jet(x).rate, max_relative = 1e-13);
    }
}

#[test]
fn rectangular_wave_and_its_series() {
    let data = crate::data::read("classics.json");
    let example = &data["rect_fourier"]["example"];
    let number = |key: &str| example[key].as_f64().unwrap();
    let rectangle = RectangularWave::of_contact_ratio(number("eps"), number("kmin"), number("kmax")).unwrap();
    assert_eq!(rectangle.mean(), number("a0"));
    let series = rectangle.series(5).unwrap();
    for (pair, a) in series.pairs().iter().zip(example["a"].as_array().unwrap()) {
        assert!((pair[0] - a.as_f64().unwrap()).abs() < 1e-15 && pair[1] == 0.0);
    }
    // The series approximates the wave away from its edges, at any phase.
    let shifted = Wave::new(rectangle).with_phase(1.1).unwrap();
    let long = Wave::new(rectangle.series(2001).unwrap()).with_phase(1.1).unwrap();
    for x in [-20.2, 0.3, 2.5, 48.4] {
        assert!((long.value(x, Side::After) - shifted.value(x, Side::After)).abs() < 1e-2, "{x}");
    }
    // At each edge the wave has two sides, and `next_edge` finds the next edge from any angle.
    let (mut x, mut edges) = (-12.0, Vec::new());
    for _ in 0..20 {
        let edge = shifted.next_edge(x).unwrap();
        assert!(edge > x);
        assert_ne!(shifted.value(edge, Side::Before), shifted.value(edge, Side::After));
        assert_eq!(
            shifted.value(edge, Side::Before),
            shifted.value(0.5 * (edge + x.max(edge - 0.6)), Side::After)
        );
        edges.push(edge);
        x = edge;
    }
    assert!((edges[19] - edges[17] - TAU).abs() < 1e-12);
    assert_eq!(Wave::new(RectangularWave::new(1.0, 2.0, 0.0).unwrap()).next_edge(0.0), None);
}

/// The sign wave of tooth friction reverses at the pitch point and half a mesh period later.
#[test]
fn friction_reverses_at_the_pitch_point() {
    let pitch_point = 0.4;
    let sign = Wave::new(RectangularWave::sign()).with_phase(0.5 * PI - pitch_point).unwrap();
    assert!((sign.next_edge(0.0).unwrap() - pitch_point).abs() < 1e-15);
    let at = sign.next_edge(0.0).unwrap();
    assert_eq!((sign.value(at, Side::Before), sign.value(at, Side::After)), (1.0, -1.0));
    assert!((sign.next_edge(at).unwrap() - at - PI).abs() < 1e-15);
}

/// A fit to samples of a series returns its coefficients, with any number of samples above twice the highest
/// order.
#[test]
fn fit_inverts_sampling() {
    let truth = Fourier::new(3.1, &[[0.9, -0.2], [0.05, 0.0], [0.0, 0.3]]).unwrap();
    for m in [7, 8, 64, 1001] {
        let samples: Vec<f64> = (0..m).map(|i| truth.value(TAU * i as f64 / m as f64)).collect();
        let fit = Fourier::fit(&samples, 3).unwrap();
        assert!((fit.mean() - 3.1).abs() < 1e-13);
        for (a, b) in fit.pairs().iter().flatten().zip(truth.pairs().iter().flatten()) {
            assert!((a - b).abs() < 1e-13, "{m}");
        }
    }
}

/// Sums and products have the edges of their parts, with both sides, at any order.
#[test]
fn combined_edges() {
    let square = Wave::new(RectangularWave::new(0.0, 1.0, 0.5).unwrap()).per_turn(3).unwrap();
    let wave = Wave::new(Fourier::new(0.0, &[[1.0, 0.0]]).unwrap()).per_turn(2).unwrap();
    assert_eq!(Wave::common_order([&square, &wave]), 1);
    let product = Wave::new(Product::new(vec![square.clone(), wave.clone()])).per_turn(2).unwrap();
    let sum = Wave::new(Sum::new(vec![square, wave])).per_turn(2).unwrap();
    for f in [&sum, &product] {
        let edge = f.next_edge(0.0).unwrap();
        assert!((edge - PI / 12.0).abs() < 1e-15);
        // The square wave is 1 before and 0 after its edge; the smooth wave is cos π/3 = 1/2 there.
        let jump = f.value(edge, Side::Before) - f.value(edge, Side::After);
        assert!((jump - if f == &sum { 1.0 } else { 0.5 }).abs() < 1e-11, "{jump}");
        let count = std::iter::successors(Some(0.0), |x| f.next_edge(*x))
            .skip(1)
            .take_while(|x| *x < 10.0 * TAU)
            .count();
        assert_eq!(count, 120);
    }
}

/// No edge of a wave is passed over, wherever in a turn it lies: edge by edge over many turns, beside all edges
/// in order.
#[test]
fn every_edge_of_every_turn_is_announced() {
    let mut random = Random(11);
    for case in 0..2000 {
        let (order, phase) = (1 + (40.0 * random.next()) as u32, [0.0, 0.3, TAU * random.next()][case % 3]);
        let count = 1 + (5.0 * random.next()) as usize;
        let mut edges: Vec<f64> = (0..count).map(|_| TAU * random.next()).collect();
        edges[0] = [0.0, edges[0], TAU.next_down()][case / 3 % 3];
        let function = Function::new(|_| Jet::constant(1.0)).with_edges(&edges).unwrap();
        let wave = Wave::new(function).per_turn(order).unwrap().with_phase(phase).unwrap();
        edges.sort_by(f64::total_cmp);
        let n = f64::from(order);
        let turns = -300..300;
        let all: Vec<f64> = turns
            .flat_map(|k| edges.iter().map(move |edge| (TAU * f64::from(k) + edge - phase) / n))
            .filter(|at| *at > -200.0 * TAU / n)
            .take(300)
            .collect();
        // From beside the first edge.
        let mut at = all[0] - 1e-6;
        for (k, edge) in all.iter().enumerate() {
            let next = wave.next_edge(at).unwrap();
            assert!(
                (next - edge).abs() < 1e-10,
                "{order} {phase} {edges:?}: edge {k} at {edge}, after {at}: {next}"
            );
            at = next;
        }
    }
}

/// Contact laws: the pieces agree at the edges, slopes are those of the pieces, and both edges of a varying
/// backlash move.
#[test]
fn contact_laws() {
    let laws: Vec<(MixedLaw, f64)> = vec![
        (MixedLaw::Backlash(Backlash::new(0.7).unwrap()), 0.0),
        (
            MixedLaw::Asymmetric(AsymmetricBacklash::new(-0.4, 0.9).unwrap().with_slopes(2.0, 0.5).unwrap()),
            0.0,
        ),
        (MixedLaw::Varying(VaryingBacklash::new(Wave::constant(0.3).unwrap())), 0.0),
        (MixedLaw::Smoothed(SmoothedBacklash::new(0.7, 1e-3).unwrap()), 1e-3),
    ];
    for (law, slack) in &laws {
        let e = law.edges(0.0, Side::After);
        for (piece, x) in [
            (Piece::Lower, e.lower - 0.3),
            (Piece::Gap, 0.5 * (e.lower + e.upper)),
            (Piece::Upper, e.upper + 0.2),
        ] {
            let held: f64 = law.force_on(piece, &[], e.at(x, 0.0));
            assert!((held - law.at(x)).abs() < 1e-15, "{law:?}");
            let h = 1e-6;
            let slope = (law.at(x + h) - law.at(x - h)) / (2.0 * h);
            assert!((slope - law.slope(x)).abs() < 1e-6, "{law:?} at {x}");
        }
        assert!(law.at(e.lower).abs() <= *slack && law.at(e.upper).abs() <= *slack);
    }
    let moving = VaryingBacklash::new(Wave::new(Fourier::new(1.0, &[[0.0, 0.1]]).unwrap()));
    let e = moving.edges(0.0, Side::After);
    assert_eq!((e.lower, e.upper, e.lower_rate, e.upper_rate), (-1.0, 1.0, -0.1, 0.1));
    // With a small rounding s the smoothed law tends to the dead zone; at the edge the difference is s/2.
    for s in [1e-1, 1e-2, 1e-3] {
        let gap = SmoothedBacklash::new(1.0, s).unwrap().at(1.0) - Backlash::new(1.0).unwrap().at(1.0);
        assert!((gap / (0.5 * s) - 1.0).abs() < s);
    }
}

/// After a million turns `next_edge` still returns two edges a period, and they separate the two levels.
#[test]
fn a_wave_far_out() {
    for order in [1, 7, 63] {
        let wave = Wave::new(RectangularWave::new(1.0, 2.0, 0.3).unwrap())
            .with_phase(0.7)
            .unwrap()
            .per_turn(order)
            .unwrap();
        let (begin, period) = (1e6 * TAU, TAU / f64::from(order));
        let mut x = begin;
        for count in 0..1000 {
            let edge = wave.next_edge(x).unwrap();
            assert!(edge > x && (count == 0 || edge - x < 0.7 * period * (1.0 + 1e-5)), "{x} {edge}");
            let [before, after] = [Side::Before, Side::After].map(|side| wave.value(edge, side));
            assert!(before != after && wave.value(0.5 * (x + edge), Side::After) == before, "{edge}");
            x = edge;
        }
        assert!(((x - begin) / period - 500.0).abs() < 1.0);
    }
}
