//! The pictures of the page on random loads.

use super::Outcome;
use gear_dynamics::State;
use gear_dynamics::excitation::Side;
use gear_dynamics::models::Oscillator;
use gear_dynamics::processes::{HeldProcess, OrnsteinUhlenbeck, Process};
use gear_dynamics::random::{Event, FirstPassage, NoisySteps, PathIntegration, Splitting, WhiteNoise};
use gear_dynamics::sweep::{Distribution, Proportion};
use gear_dynamics_plots::{Mark, Panel, Picture};

/// Standard deviation of the torques [N m].
const SIGMA: f64 = 60.0;

/// The laws of docs/random.md: held for 1 ms, and two correlation times.
fn laws() -> Outcome<[(&'static str, Box<dyn Process>); 3]> {
    let held = HeldProcess::new(1e-3, rand_distr::Normal::new(0.0, SIGMA)?)?;
    let slow = OrnsteinUhlenbeck::new(SIGMA, 2e-3, 4e-5)?;
    let fast = OrnsteinUhlenbeck::new(SIGMA, 1e-4, 1e-5)?;
    Ok([
        ("held for 1 ms", Box::new(held)),
        ("correlation time 2 ms", Box::new(slow)),
        ("correlation time 0.1 ms", Box::new(fast)),
    ])
}

pub fn paths(_: bool) -> Outcome<Picture> {
    let mut panels = Vec::new();
    let mut power = Panel::new("power density", "frequency [Hz]", "density [(N m)²/Hz]")?;
    for (name, process) in laws()? {
        let path = process.path(0);
        let points = (0..=400).map(|i| 2e-5 * f64::from(i)).map(|t| (t, path.at(t, Side::After)));
        let panel = Panel::new(name, "time t [s]", "torque added [N m]")?.series("", Mark::Line, points)?;
        panels.push(panel.y_range(-200.0, 200.0)?.name_y(&[(-SIGMA, "−σ"), (SIGMA, "σ")])?);
        // The held values do not state their moments, so that their density is not known.
        let at = |f: f64| Some((f, process.density(f)?));
        let points: Vec<_> = (0..=60).filter_map(|i| at(10.0 * 10f64.powf(f64::from(i) / 20.0))).collect();
        if !points.is_empty() {
            power = power.series(name, Mark::Line, points)?;
        }
    }
    let power = power.logarithmic_x()?.logarithmic_y()?.y_range(1e-3, 100.0)?;
    panels.push(power.name_x(&[(3150.0, "natural frequency")])?);
    Ok(Picture::new(panels).columns(2).panel_size(380.0, 240.0))
}

/// x'' + 0.2 x' + g(x) = F + √D ξ with the dead zone g of half width 0.5 and slope 1.
fn dead_zone(force: f64) -> Outcome<Oscillator> {
    let constants = [("speed", 1.0), ("mesh stiffness", 1.0), ("half backlash", 0.5), ("mean force", force)];
    Ok(Oscillator::new(&constants)?)
}

pub fn chances(coarse: bool) -> Outcome<Picture> {
    Ok(Picture::new([density(coarse)?, rare(coarse)?]).columns(2).panel_size(400.0, 320.0))
}

/// Density of the deflection in the dead zone: path integration, and members that were counted.
fn density(coarse: bool) -> Outcome<Panel> {
    let members = if coarse { 2000 } else { 20_000 };
    let solver = NoisySteps::new(40, &[WhiteNoise::bath(0, 0.2, 0.2)?]);
    let ends = solver.ends(&dead_zone(0.0)?, &State::at_rest(1), 20.0, members)?;
    let seen = Distribution::of_samples(ends.iter().map(|end| end.q[0]));
    let spans = seen.histogram(40)?;
    let width = spans[1].middle - spans[0].middle;
    let bars = spans.iter().map(|span| (span.middle, span.count as f64 / (members as f64 * width)));
    let damped = dead_zone(0.0)?.with("damping", 0.2)?;
    let exact = PathIntegration::new(0.2, [-5.0, 5.0], [-4.5, 4.5])?.panels(6).stationary(&damped)?;
    let line = (-200..=200).map(|i| 0.02 * f64::from(i)).map(|x| (x, exact.deflection_density(x)));
    Ok(Panel::new("density of the deflection", "deflection x [1]", "density [1]")?
        .series(&format!("{members} members counted"), Mark::Dots, bars)?
        .series("path integration", Mark::Line, line)?
        .x_range(-4.0, 4.0)?
        .name_x(&[(-0.5, "−b"), (0.5, "b")])?)
}

/// Probability that the amplitude reaches a level within ten periods: counted, and by splitting.
fn rare(coarse: bool) -> Outcome<Panel> {
    let members: u64 = if coarse { 1000 } else { 10_000 };
    let solver = NoisySteps::new(40, &[WhiteNoise::bath(0, 0.2, 0.4)?]);
    let (pair, start) = (dead_zone(5.0)?, State::new(0.0, &[5.5], &[0.0]));
    let mut panel =
        Panel::new("an amplitude is reached within ten periods", "amplitude A [1]", "probability [1]")?;
    let (mut counted, mut split, mut bars) = (Vec::new(), Vec::new(), Vec::new());
    for level in [3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 6.5, 7.0] {
        let event = Event::new(level, |at| (at.q[0] - 5.5).hypot(at.v[0]));
        let passage =
            FirstPassage::new(10.0)?.members(members as usize).run(&solver, &pair, &start, &event)?;
        let share = Proportion::new(passage.reached(), members)?;
        let particles = if coarse { 100 } else { 500 };
        let seen = Splitting::new(10.0)?.particles(particles).run(&solver, &pair, &start, &event)?;
        let probability = seen.probability();
        bars.push((true, level + 0.04, share.confidence(0.95)?));
        bars.push((false, level, probability.confidence(0.95)?));
        if share.hits() > 0 {
            counted.push((level + 0.04, share.share()));
        }
        split.push((level, probability.mean()));
    }
    let name = format!("{members} members counted");
    panel = panel.series(&name, Mark::Rings, counted)?.series("splitting", Mark::Dots, split)?;
    for (is_counted, at, [low, high]) in bars {
        let name = if is_counted { &name } else { "splitting" };
        panel = panel.series(name, Mark::Line, [(at, low.max(1e-9)), (at, high)])?;
    }
    Ok(panel.logarithmic_y()?.y_range(1e-9, 1.0)?)
}
