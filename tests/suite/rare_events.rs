//! First passages and rare events against closed integrals.

use gear_dynamics::State;
use gear_dynamics::models::Oscillator;
use gear_dynamics::ode::Exhausted;
use gear_dynamics::random::{Event, FirstPassage, NoiseError, NoisySteps, Splitting, WhiteNoise};
use gear_dynamics::sweep::Watch;
use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// An overdamped particle x' = -x + √2 ξ, as the velocity of a coordinate without a spring: U = x²/2, β = 1.
fn particle(steps: usize) -> (Oscillator, NoisySteps) {
    let free = Oscillator::new(&[("speed", 1.0)]).unwrap();
    (free, NoisySteps::new(steps, &[WhiteNoise::bath(0, 1.0, 2.0).unwrap()]))
}

/// The state of the particle at x.
fn at(x: f64) -> State {
    State::new(0.0, &[0.0], &[x])
}

/// The steps see the particle at their ends only: a level lies 0.5826 √(D h) farther away, in first order.
/// Source: Broadie, Glasserman and Kou 1997 (Math. Finance 7, 325).
fn shift(steps: usize) -> f64 {
    0.5826 * (2.0 * TAU / steps as f64).sqrt()
}

/// ∫ f over [a, b] by the midpoint rule.
fn integral(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let h = (b - a) / 2000.0;
    (0..2000).map(|i| f(a + (f64::from(i) + 0.5) * h) * h).sum()
}

/// P(b before a from x) = ∫_a^x e^{βU}/∫_a^b e^{βU}.
fn exact(a: f64, x: f64, b: f64) -> f64 {
    integral(a, x, |y| (0.5 * y * y).exp()) / integral(a, b, |y| (0.5 * y * y).exp())
}

fn barrier(b: f64, steps: usize, particles: usize, repeats: usize) -> (f64, f64) {
    let (free, solver) = particle(steps);
    let splitting = Splitting::new(1e4).unwrap().floor(-0.5).particles(particles).repeats(repeats);
    let seen = splitting.run(&solver, &free, &at(0.5), &Event::new(b, |at| at.v[0])).unwrap();
    let (found, off) = (seen.probability(), shift(steps));
    let ratio = found.mean() / exact(-0.5 - off, 0.5, b + off);
    println!(
        "b {b}: P {:.3e}, ratio {ratio:.4} ± {:.4}, {} levels, {:.1e} steps",
        found.mean(),
        found.relative_error(),
        seen.levels().len(),
        seen.steps() as f64
    );
    (ratio, found.relative_error())
}

#[test]
fn barrier_by_splitting() {
    let (ratio, error) = barrier(3.0, 200, 40, 8); // P = 0.04
    assert!((ratio - 1.0).abs() < 4.0 * error && error < 0.25, "{ratio} {error}");
}

/// 1 % at probabilities from 1e-2 to 1e-6.
#[test]
#[ignore = "5 × 10⁹ steps: cargo test --release --test suite barriers_to_one_per_cent -- --ignored"]
fn barriers_to_one_per_cent() {
    for b in [3.5, 4.2, 4.8, 5.4] {
        let (ratio, error) = barrier(b, 628, 4000, 400);
        assert!((ratio - 1.0).abs() < 0.01 && error < 0.006, "{b}: {ratio} {error}");
    }
}

/// Mean first passage from 0 to b: ∫_0^b e^{y²/2} ∫_{-∞}^y e^{-z²/2} dz dy.
#[test]
fn mean_first_passage() {
    let (steps, b) = (300, 1.0);
    let (free, solver) = particle(steps);
    let event = Event::new(b, |at| at.v[0]);
    let seen = FirstPassage::new(100.0).unwrap().members(256).run(&solver, &free, &at(0.0), &event).unwrap();
    let inner = |y: f64| integral(-9.0, y, |z| (-0.5 * z * z).exp());
    let top = b + shift(steps);
    let exact = (0..100).map(|i| (f64::from(i) + 0.5) * top / 100.0).map(|y| (0.5 * y * y).exp() * inner(y));
    let exact = exact.sum::<f64>() * top / 100.0;
    let (mean, error) = (seen.times().mean(), seen.times().standard_error());
    assert!(
        (mean - exact).abs() < 4.0 * error && error < 0.1 * exact && seen.reached() == 256,
        "{mean} {exact} {error}"
    );
}

#[test]
fn lanes_change_no_bit() {
    let (free, solver) = particle(100);
    let event = Event::new(2.0, |at| at.v[0]);
    let splitting = Splitting::new(10.0).unwrap().floor(-1.0).particles(20).repeats(8);
    let expected = splitting.run(&solver, &free, &at(0.0), &event).unwrap();
    assert_eq!(splitting.run(&solver.clone().lanes::<4>(), &free, &at(0.0), &event).unwrap(), expected);
    let passage = FirstPassage::new(2.0).unwrap().members(40);
    let expected = passage.run(&solver, &free, &at(0.0), &event).unwrap();
    assert_eq!(passage.run(&solver.lanes::<1>(), &free, &at(0.0), &event).unwrap(), expected);
    assert!(expected.reached() > 0 && expected.members() == 40);
}

#[test]
fn bad_input_is_refused() {
    let (free, solver) = particle(50);
    let run = |splitting: Splitting<'_>, event: Event| splitting.run(&solver, &free, &at(0.0), &event);
    let (plain, up) = (Splitting::new(1.0).unwrap(), Event::new(2.0, |at| at.v[0]));
    assert!(Splitting::new(0.0).is_err() && FirstPassage::new(f64::NAN).is_err());
    assert!(run(plain.clone().particles(5), up.clone()).is_err());
    assert!(run(plain.clone().repeats(7), up.clone()).is_err());
    assert!(run(plain.clone().floor(2.0), up.clone()).is_err());
    assert!(run(plain.clone(), Event::new(f64::NAN, |at| at.v[0])).is_err());
    // A score that stands still, and one that is not a number.
    let stuck = run(plain.clone(), Event::new(1.0, |_| 0.0)).unwrap_err();
    assert!(matches!(stuck, NoiseError::Extinct { stage: 1, .. }), "{stuck}");
    let nan = run(plain.clone(), Event::new(1.0, |_| f64::NAN)).unwrap_err();
    assert!(matches!(nan, NoiseError::Diverged { .. }), "{nan}");
    assert!(FirstPassage::new(1.0).unwrap().members(0).run(&solver, &free, &at(0.0), &up).is_err());
}

/// A cancelled run keeps the members so far, in blocks of 256, and the repeats so far, if they are 8.
#[test]
fn cancelled_runs_keep_what_was_complete() {
    let ((free, solver), stop) = (particle(50), Arc::new(AtomicBool::new(false)));
    let (start, event) = (at(0.0), Event::new(2.0, |at| at.v[0]));
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let until = |number: usize| {
        let stop = stop.clone();
        stop.store(false, Ordering::Relaxed);
        move |done: usize, _: usize| stop.store(done >= number, Ordering::Relaxed)
    };

    let passage = FirstPassage::new(2.0).unwrap().members(700);
    let whole = passage.run(&solver, &free, &start, &event).unwrap();
    let watched = passage.clone().watch(Watch::new().progress(until(700)).cancel(stop.clone()));
    assert_eq!(watched.run(&solver, &free, &start, &event).unwrap(), whole);
    let watched = passage.watch(Watch::new().progress(until(256)).cancel(stop.clone()));
    let some = one.install(|| watched.run(&solver, &free, &start, &event)).unwrap();
    assert_eq!((some.members(), whole.members()), (256, 700));
    assert!(some.reached() > 0 && some.reached() < whole.reached());
    let none = watched.run(&solver, &free, &start, &event).unwrap_err();
    assert_eq!(none, NoiseError::Exhausted { exhausted: Exhausted::Cancelled, done: 0, all: 700 });

    let splitting = Splitting::new(10.0).unwrap().floor(-1.0).particles(20).repeats(30);
    let run = |splitting: Splitting<'_>| one.install(|| splitting.run(&solver, &free, &start, &event));
    let some = run(splitting.clone().watch(Watch::new().progress(until(9)).cancel(stop.clone()))).unwrap();
    assert_eq!(some.probability().batches(), 9);
    let few = run(splitting.clone().watch(Watch::new().progress(until(7)).cancel(stop.clone()))).unwrap_err();
    assert_eq!(few, NoiseError::Exhausted { exhausted: Exhausted::Cancelled, done: 7, all: 30 });
    let none = run(splitting.watch(Watch::new().cancel(stop.clone()))).unwrap_err();
    assert_eq!(none, NoiseError::Exhausted { exhausted: Exhausted::Cancelled, done: 0, all: 30 });
}
