//! The closed-loop gear ring of a braiding machine: Figs. 5-13 of Yao 2020. Parameters that the paper leaves out: sets A and E
//! of docs/models.md.
//!
//! `cargo run --release --example braiding_ring`

mod support;

use gear_dynamics::{
    Dop853, Frame, Held, HeldProcess, Integrator, Model, Ring, RingSet, Spectrum, State, Statistics, Step, Summary, Window, uniform_times,
};
use rand_distr::Uniform;
use rayon::prelude::*;
use std::ops::ControlFlow;
use support::{Csv, Mark, Outcome, Panel, envelope, figure, gallery, progress};

/// The ring as the paper prints it, three gears, in the frame of its rigid motion: 44 N m against 3 x 2 N m do not balance.
fn ring(set: &RingSet) -> Outcome<Ring> {
    Ok(Ring::as_printed(&set.params()?)?.in_frame(Frame::Rigid))
}

/// Angles of 1e-3 rad carry deflections of 1e-5 m: tolerances by component.
fn solver<M: Model>(model: &M) -> Dop853 {
    let n = model.dof();
    Dop853::new().rtol(1e-8).atol_each(&[vec![1e-11; n], vec![1e-7; n]].concat())
}

/// Times, and the values of some channels at them.
type History = (Vec<f64>, Vec<Vec<f64>>);

/// Channels of a run from rest, every `spacing` seconds.
fn history<M: Model>(model: &M, channels: &[&str], end: f64, spacing: f64) -> Outcome<History> {
    let times = uniform_times(0.0, end, (end / spacing).round() as usize)?;
    let run = solver(model).sample(model, &State::at_rest(model.dof()), &times)?;
    let values = channels.iter().map(|name| run.channel(model, name)).collect::<Result<_, _>>()?;
    Ok((times, values))
}

struct Point {
    dte: Summary,
    force: Summary,
}

/// From rest, measured over [5, 5.5) s.
fn at_speed(set: &RingSet) -> Outcome<Point> {
    let ring = ring(set)?;
    let solver = solver(&ring);
    let settled = solver.end(&ring, &State::at_rest(ring.dof()), 5.0)?;
    let mut statistics = Statistics::new(&ring, &["deflection 1", "mesh force 1"])?;
    solver.run(&ring, &settled, 5.5, &mut statistics)?;
    Ok(Point { dte: statistics.summary("deflection 1")?, force: statistics.summary("mesh force 1")? })
}

fn main() -> Outcome<()> {
    let folder = gallery("braiding_ring")?;
    type Set = (&'static str, fn(f64) -> RingSet);
    let sets: [Set; 2] = [("A", |rpm| RingSet::a(3, rpm)), ("E", |rpm| RingSet::e(3, rpm))];

    let a = ring(&RingSet::a(3, 1000.0))?;
    println!(
        "Set A, 1000 r/min: torque imbalance {} N m accelerates the ring by {:.1} rad/s²",
        a.torque_imbalance(),
        a.rigid_acceleration()
    );
    for (name, set) in sets {
        let ring = ring(&set(1000.0))?;
        let modes = ring.modes(&ring.mean_mesh_stiffness())?;
        let hertz: Vec<String> = modes.hertz().iter().map(|f| format!("{f:.1}")).collect();
        println!("natural frequencies of set {name} [Hz]: {}", hertz.join(", "));
    }

    println!("\nFigs. 5-7: dynamic transmission error of the first pair, 1000 r/min, set A");
    println!("{:>12} {:>14} {:>14} {:>18}", "b [m]", "mean [μm]", "p-p, t < 1 s", "p-p, t > 9 s [μm]");
    let bar = progress("transmission error", 3);
    let widths = [2.65e-6, 2.65e-5, 2.65e-4];
    let runs: Vec<_> = widths
        .par_iter()
        .map(|&half_backlash| {
            let set = RingSet { half_backlash, ..RingSet::a(3, 1000.0) };
            let run = ring(&set).and_then(|ring| history(&ring, &["deflection 1"], 10.0, 1e-4)).map_err(|e| e.to_string());
            bar.inc(1);
            run
        })
        .collect();
    bar.finish_and_clear();
    let mut panels = Vec::new();
    for (b, run) in widths.iter().zip(runs) {
        let (times, values) = run?;
        let (early, late) = (Summary::of(&values[0][..10_000])?, Summary::of(&values[0][90_000..])?);
        println!("{b:12.3e} {:14.4} {:14.3} {:18.4}", 1e6 * late.mean, 1e6 * early.peak_to_peak(), 1e6 * late.peak_to_peak());
        let title = format!("b = {b:.2e} m: envelope of the deflection");
        panels.push(Panel::new(title, "t [s]", "d1 [m]").with("", Mark::Line, envelope(&times, &values[0], 1000)));
    }
    figure(folder.join("fig5_7_transmission_error.svg"), 1, &panels)?;

    println!("\nFig. 8: spectrum of the transmission error, 1000 r/min, b = 2.65e-5 m, first 4 s (Hann)");
    let mut panels = Vec::new();
    for (name, set) in sets {
        let (_, values) = history(&ring(&set(1000.0))?, &["deflection 1"], 4.0, 2.5e-5)?;
        let samples = &values[0][..160_000];
        let spectrum = Spectrum::of(samples, 2.5e-5, Window::Hann)?;
        let lines: Vec<(f64, f64)> =
            spectrum.frequencies().iter().zip(spectrum.amplitudes()).map(|(f, a)| (*f, *a)).take_while(|p| p.0 <= 1500.0).collect();
        let mut peaks: Vec<(f64, f64)> =
            lines.windows(3).filter(|w| w[0].0 > 5.0 && w[1].1 > w[0].1 && w[1].1 > w[2].1).map(|w| w[1]).collect();
        peaks.sort_by(|a, b| b.1.total_cmp(&a.1));
        let named: Vec<String> = peaks.iter().take(4).map(|(f, a)| format!("{f:.1} Hz ({:.3} μm)", 1e6 * a)).collect();
        println!("set {name}: {:.2} μm at 0 Hz; largest lines {}", 1e6 * lines[0].1, named.join(", "));
        let decades = lines.iter().map(|(f, a)| (*f, a.max(1e-13).log10())).collect();
        panels.push(Panel::new(format!("set {name}"), "f [Hz]", "amplitude [m]").decades().with("", Mark::Line, decades));
    }
    figure(folder.join("fig8_spectrum.svg"), 1, &panels)?;

    println!("\nFigs. 9, 10: transmission error over speed, window 5 to 5.5 s");
    let speeds: Vec<f64> = (1..=20).map(|i| 500.0 * f64::from(i)).collect();
    let cases: Vec<(&str, RingSet)> = sets.iter().flat_map(|(name, set)| speeds.iter().map(|rpm| (*name, set(*rpm)))).collect();
    let bar = progress("speed sweep", cases.len());
    let points: Vec<Result<Point, String>> = cases
        .par_iter()
        .map(|(name, set)| {
            let point = at_speed(set).map_err(|e| format!("set {name} at {} r/min: {e}", set.rpm));
            bar.inc(1);
            point
        })
        .collect();
    bar.finish_and_clear();
    let points: Vec<Point> = points.into_iter().collect::<Result<_, _>>()?;
    let mut csv = Csv::new(folder.join("speed_sweep.csv"), "set,rpm,dte_mean,dte_rms,dte_p2p,force_min,force_max")?;
    println!(
        "{:>4} {:>8} {:>11} {:>11} {:>11} {:>11} {:>11}",
        "set", "r/min", "mean [μm]", "RMS [μm]", "p-p [μm]", "W min [N]", "W max [N]"
    );
    for ((name, set), p) in cases.iter().zip(&points) {
        csv.row(&[name, &set.rpm, &p.dte.mean, &p.dte.rms, &p.dte.peak_to_peak(), &p.force.min, &p.force.max])?;
        if set.rpm % 1000.0 == 0.0 {
            let [mean, rms, p2p] = [p.dte.mean, p.dte.rms, p.dte.peak_to_peak()].map(|x| 1e6 * x);
            println!("{name:>4} {:8} {mean:11.3} {rms:11.3} {p2p:11.4} {:11.1} {:11.1}", set.rpm, p.force.min, p.force.max);
        }
    }
    let curve = |name: &str, of: &dyn Fn(&Point) -> f64| {
        cases.iter().zip(&points).filter(|(c, _)| c.0 == name).map(|(c, p)| (c.1.rpm, of(p))).collect::<Vec<_>>()
    };
    let both = |title: &str, y: &str, of: &dyn Fn(&Point) -> f64| {
        Panel::new(title, "speed [r/min]", y).with("set A", Mark::Line, curve("A", of)).with("set E", Mark::Line, curve("E", of))
    };
    let rms = both("RMS of the transmission error", "[m]", &|p| p.dte.rms);
    let mean = both("mean of the transmission error", "[m]", &|p| p.dte.mean);
    figure(folder.join("fig9_10_speed.svg"), 1, &[rms, mean, both("peak-to-peak", "[m]", &|p| p.dte.peak_to_peak())])?;

    println!("\nFigs. 11-13: mesh force of the first pair, set E, 1000 r/min, with held random damping C_D");
    let bare = ring(&RingSet::e(3, 1000.0))?;
    let hold = 2.0 * std::f64::consts::PI / bare.params().omega; // one mesh period
    let process = HeldProcess::new(hold, Uniform::new(0.0, 1.0)?)?.with_seed(2020);
    let slots: Vec<usize> = (0..3).map(|mesh| bare.damping_slot(mesh)).collect();
    let damping = bare.params().meshes[0].damping();
    let noisy = |gain: f64| Held::new(bare.clone()).per_slot(&slots, gain, process.clone());
    let force = |label: &str, model: &dyn Fn() -> Outcome<History>| -> Outcome<Panel> {
        let (times, values) = model()?;
        let (w, kd) = (&values[0], &values[1]);
        let peak = |x: &[f64]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let split = w.len() * 7 / 8;
        println!(
            "{label:24} |W| {:6.1} N, then {:5.1} N after 7 s; K d without dead zone {:6.1} N, then {:6.1} N",
            peak(w),
            peak(&w[split..]),
            peak(kd),
            peak(&kd[split..])
        );
        Ok(Panel::new(format!("mesh force, {label}"), "t [s]", "W1 [N]").with("", Mark::Line, envelope(&times, w, 800)))
    };
    let channels = ["mesh force 1", "stiffness times deflection 1"];
    let values = (0..400).map(|k| (f64::from(k), process.held(0, k as u64))).collect();
    let mut panels = vec![Panel::new("held values of C_D (first mesh)", "hold number", "value [1]").with("", Mark::Dots, values)];
    panels.push(force("C_D = 0", &|| history(&bare, &channels, 8.0, 1e-4))?);
    panels.push(force("C_D = U(0,1) N s/m", &|| history(&noisy(1.0)?, &channels, 8.0, 1e-4))?);
    panels.push(force("C_D = U(0,1) C_g", &|| history(&noisy(damping)?, &channels, 8.0, 1e-4))?);
    figure(folder.join("fig11_13_mesh_force.svg"), 1, &panels)?;

    // Exact extremes of the force while settling, from inside the steps.
    let mut statistics = Statistics::new(&bare, &channels)?;
    let mut seen = 0u64;
    solver(&bare).run(&bare, &State::at_rest(bare.dof()), 7.0, &mut |step: &mut Step<'_>| {
        seen += step.crossings().len() as u64;
        let _ = gear_dynamics::Observer::step(&mut statistics, step);
        ControlFlow::Continue(())
    })?;
    let (w, kd) = (statistics.summary(channels[0])?, statistics.summary(channels[1])?);
    println!(
        "extremes located inside the steps, t < 7 s: W {:.2} .. {:.2} N, K d up to {:.2} N, {seen} edges crossed",
        w.min, w.max, kd.max
    );
    println!("\npictures and tables: {}", folder.display());
    Ok(())
}
