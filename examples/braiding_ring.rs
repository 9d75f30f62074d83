//! The closed-loop gear ring of a braiding machine: Figs. 5-13 of Yao 2020, with sets A and E of
//! docs/models.md for the parameters that Yao 2020 does not state.
//!
//! The tables and pictures show natural frequencies, the transmission error over time, its spectrum and its
//! statistics over speed, and the mesh force with constant and random mesh damping, torque and clearance;
//! `speed_sweep.csv` and `mesh_force.csv` contain the numbers.
//!
//! `cargo run --release -p examples --example braiding_ring`; everything is written to
//! target/gallery/braiding_ring/.

mod support;

use gear_dynamics::analysis::{ContactStatistics, Spectrum, Summary, Window};
use gear_dynamics::drives::{Held, HeldProcess};
use gear_dynamics::linear::Modes;
use gear_dynamics::models::ring::{Frame, RingSet};
use gear_dynamics::ode::{Step, uniform_times};
use gear_dynamics::{Dop853, Integrator, Model, ParameterError, Periodic, Rattle, Ring, State, Statistics};
use rand_distr::Uniform;
use rayon::prelude::*;
use std::ops::ControlFlow;
use support::{Mark, Outcome, Panel, csv_file, envelope, figure, gallery, progress};

/// The ring of three gears as Yao 2020 prints it, in the frame of its rigid motion, since 44 N m and 3 x 2 N
/// m do not balance.
fn ring(set: &RingSet) -> Outcome<Ring> {
    Ok(Ring::as_printed(&set.params()?)?.in_frame(Frame::Rigid))
}

/// The slots of the damping of each mesh.
fn damping_slots(ring: &Ring) -> Result<Vec<usize>, ParameterError> {
    (1..=3).map(|mesh| ring.slot(&format!("mesh damping {mesh}"))).collect()
}

/// Tolerances by component: angles of 1e-3 rad contain deflections of 1e-5 m.
fn solver<M: Model>(model: &M) -> Dop853 {
    let n = model.dof();
    Dop853::new().rtol(1e-8).atol_each(&[vec![1e-11; n], vec![1e-7; n]].concat())
}

/// Times, and the values of channels at them.
type History = (Vec<f64>, Vec<Vec<f64>>);

/// Channels of a run from rest, every `spacing` seconds.
fn history<M: Model>(model: &M, channels: &[&str], end: f64, spacing: f64) -> Outcome<History> {
    let times = uniform_times(0.0, end, (end / spacing).round() as usize)?;
    let run = solver(model).sample(model, &State::at_rest(model.dof()), &times)?;
    let values = channels.iter().map(|name| run.channel(model, name)).collect::<Result<_, _>>()?;
    Ok((times, values))
}

/// Results at one speed.
struct Point {
    /// Deflection of the first mesh.
    dte: Summary,
    force: Summary,
    /// Contact statistics of the first mesh.
    contact: ContactStatistics,
}

/// Runs from rest to 5 s and measures until 5.5 s.
fn at_speed(set: &RingSet) -> Outcome<Point> {
    let ring = ring(set)?;
    let solver = solver(&ring);
    let settled = solver.end(&ring, &State::at_rest(ring.dof()), 5.0)?;
    let (mut rattle, mut statistics) =
        (Rattle::new(&ring), Statistics::new(&ring, &["deflection 1", "mesh force 1"])?);
    solver.run(&ring, &settled, 5.5, &mut (&mut rattle, &mut statistics))?;
    let (dte, force) = (statistics.summary("deflection 1")?, statistics.summary("mesh force 1")?);
    Ok(Point { dte, force, contact: rattle.contact(0) })
}

/// The mesh force of the first mesh in a run from rest: extremes inside the steps, before and after 7 s.
struct Force {
    /// Maximum |W| before and after 7 s [N].
    peak: [f64; 2],
    /// Maximum |K d| without the dead zone [N].
    spring: [f64; 2],
    /// Peak-to-peak value of W after 7 s [N].
    steady: f64,
}

fn force<M: Model>(model: &M) -> Outcome<Force> {
    let channels = ["mesh force 1", "stiffness times deflection 1"];
    let (mut early, mut late) = (Statistics::new(model, &channels)?, Statistics::new(model, &channels)?);
    let solver = solver(model);
    let at_seven = solver.run(model, &State::at_rest(model.dof()), 7.0, &mut early)?.state;
    solver.run(model, &at_seven, 8.0, &mut late)?;
    let of =
        |channel: &str| -> Outcome<[Summary; 2]> { Ok([early.summary(channel)?, late.summary(channel)?]) };
    let size = |x: Summary| x.max.abs().max(x.min.abs());
    let (w, kd) = (of(channels[0])?, of(channels[1])?);
    Ok(Force { peak: w.map(size), spring: kd.map(size), steady: w[1].peak_to_peak() })
}

/// A disturbance of the ring at 1000 r/min.
#[derive(Clone, Copy)]
enum Disturbance {
    /// Constant C_D [N s/m], equal in all meshes.
    Constant(f64),
    /// C_D uniform between 0 and this value [N s/m], separately for each mesh.
    Damping(f64),
    /// Motor torque uniform within ± this share.
    Torque(f64),
    /// b uniform within ± this share, separately for each mesh.
    Clearance(f64),
}

impl Disturbance {
    fn name(&self) -> String {
        match self {
            Disturbance::Constant(c) => format!("C_D = {c:.1} N s/m, constant"),
            Disturbance::Damping(c) => format!("C_D = U(0, {c:.1}) N s/m"),
            Disturbance::Torque(share) => format!("T_M within ±{:.0} %", 100.0 * share),
            Disturbance::Clearance(share) => format!("b within ±{:.0} %", 100.0 * share),
        }
    }

    /// Runs the ring with the disturbance; random values are held for one mesh period.
    fn force(&self, set: &RingSet) -> Outcome<Force> {
        let seed = 2020;
        let bare = ring(set)?;
        let hold = std::f64::consts::TAU / set.omega();
        let (share, both) = (
            HeldProcess::new(hold, Uniform::new(0.0, 1.0)?)?,
            HeldProcess::new(hold, Uniform::new(-1.0, 1.0)?)?,
        );
        let (share, both) = (share.seed(seed), both.seed(seed));
        match *self {
            Disturbance::Constant(more) => {
                force(&ring(&RingSet { mesh_damping: set.mesh_damping + more, ..set.clone() })?)
            }
            Disturbance::Damping(most) => {
                let slots = damping_slots(&bare)?;
                force(&Held::new(bare).per_slot(&slots, most, share)?)
            }
            Disturbance::Torque(part) => {
                let slot = bare.slot("motor torque")?;
                force(&Held::new(bare).shared(&[slot], part * set.motor_torque, both)?)
            }
            Disturbance::Clearance(part) => {
                let slots = (0..3).map(|mesh| bare.clearance_slots(mesh)).collect::<Result<Vec<_>, _>>()?;
                force(&Held::new(bare).clearance(&slots, part * set.half_backlash, both)?)
            }
        }
    }
}

fn main() -> Outcome<()> {
    let folder = gallery("braiding_ring")?;
    type Set = (&'static str, fn(f64) -> RingSet);
    let sets: [Set; 2] = [("A", |rpm| RingSet::set_a(3, rpm)), ("E", |rpm| RingSet::set_e(3, rpm))];

    let a = ring(&RingSet::set_a(3, 1000.0))?;
    println!(
        "Set A, 1000 r/min: torque imbalance {} N m accelerates the ring by {:.1} rad/s²",
        a.torque_imbalance(),
        a.rigid_acceleration()
    );
    for (name, set) in sets {
        let ring = ring(&set(1000.0))?;
        let modes = Modes::mean_in_contact(&ring)?;
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
            let set = RingSet { half_backlash, ..RingSet::set_a(3, 1000.0) };
            let run = ring(&set)
                .and_then(|ring| history(&ring, &["deflection 1"], 10.0, 1e-4))
                .map_err(|e| e.to_string());
            bar.inc(1);
            run
        })
        .collect();
    bar.finish_and_clear();
    let mut panels = Vec::new();
    for (b, run) in widths.iter().zip(runs) {
        let (times, values) = run?;
        let (early, late) =
            (Summary::from_samples(&values[0][..10_000])?, Summary::from_samples(&values[0][90_000..])?);
        println!(
            "{b:12.3e} {:14.4} {:14.3} {:18.4}",
            1e6 * late.mean,
            1e6 * early.peak_to_peak(),
            1e6 * late.peak_to_peak()
        );
        let title = format!("b = {b:.2e} m: envelope of the deflection");
        panels.push(Panel::new(title, "t [s]", "d1 [m]").with(
            "",
            Mark::Line,
            envelope(&times, &values[0], 1000),
        ));
    }
    figure(folder.join("fig5_7_transmission_error.svg"), 1, &panels)?;

    println!("\nFig. 8: spectrum of the transmission error, 1000 r/min, b = 2.65e-5 m, first 4 s (Hann)");
    let mut panels = Vec::new();
    for (name, set) in sets {
        let (_, values) = history(&ring(&set(1000.0))?, &["deflection 1"], 4.0, 2.5e-5)?;
        let spectrum = Spectrum::new(&values[0], 2.5e-5, Window::Hann)?;
        let lines: Vec<(f64, f64)> = spectrum
            .frequencies()
            .iter()
            .zip(spectrum.amplitudes())
            .map(|(f, a)| (*f, *a))
            .take_while(|p| p.0 <= 1500.0)
            .collect();
        let mut peaks: Vec<(f64, f64)> = lines
            .windows(3)
            .filter(|w| w[0].0 > 5.0 && w[1].1 > w[0].1 && w[1].1 > w[2].1)
            .map(|w| w[1])
            .collect();
        peaks.sort_by(|a, b| b.1.total_cmp(&a.1));
        let named: Vec<String> =
            peaks.iter().take(4).map(|(f, a)| format!("{f:.1} Hz ({:.3} μm)", 1e6 * a)).collect();
        println!("set {name}: {:.2} μm at 0 Hz; largest lines {}", 1e6 * lines[0].1, named.join(", "));
        let decades = lines.iter().map(|(f, a)| (*f, a.max(1e-13).log10())).collect();
        panels.push(Panel::new(format!("set {name}"), "f [Hz]", "amplitude [m]").decades().with(
            "",
            Mark::Line,
            decades,
        ));
    }
    figure(folder.join("fig8_spectrum.svg"), 1, &panels)?;

    println!("\nFigs. 9, 10: transmission error over speed, window 5 to 5.5 s");
    let speeds: Vec<f64> = (1..=20).map(|i| 500.0 * f64::from(i)).collect();
    let cases: Vec<(&str, RingSet)> =
        sets.iter().flat_map(|(name, set)| speeds.iter().map(|rpm| (*name, set(*rpm)))).collect();
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
    let mut csv = csv_file(
        folder.join("speed_sweep.csv"),
        "set,rpm,dte_mean,dte_rms,dte_p2p,force_min,force_max,apart,back_flank",
    )?;
    println!(
        "{:>4} {:>8} {:>11} {:>11} {:>11} {:>11} {:>11} {:>7} {:>11}",
        "set", "r/min", "mean [μm]", "RMS [μm]", "p-p [μm]", "W min [N]", "W max [N]", "loss", "back flank"
    );
    let flanks =
        |c: &ContactStatistics| (100.0 * c.loss_fraction(), 100.0 * c.time[0] / c.time.iter().sum::<f64>());
    for ((name, set), p) in cases.iter().zip(&points) {
        let (apart, back) = flanks(&p.contact);
        csv.row(&[
            name,
            &set.rpm,
            &p.dte.mean,
            &p.dte.rms,
            &p.dte.peak_to_peak(),
            &p.force.min,
            &p.force.max,
            &apart,
            &back,
        ])?;
        if set.rpm % 1000.0 == 0.0 {
            let [mean, rms, p2p] = [p.dte.mean, p.dte.rms, p.dte.peak_to_peak()].map(|x| 1e6 * x);
            println!(
                "{name:>4} {:8} {mean:11.3} {rms:11.3} {p2p:11.4} {:11.1} {:11.1} {apart:6.1}% {back:10.1}%",
                set.rpm, p.force.min, p.force.max
            );
        }
    }
    for (name, _) in sets {
        for (words, slow) in [("up to 5000 r/min", true), ("above", false)] {
            let of = |value: &dyn Fn(&Point) -> f64| {
                let chosen = cases
                    .iter()
                    .zip(&points)
                    .filter(|((n, set), _)| *n == name && (set.rpm <= 5000.0) == slow);
                chosen
                    .map(|(_, p)| value(p))
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], x| [lo.min(x), hi.max(x)])
            };
            let (rms, mean) = (of(&|p| 1e6 * p.dte.rms), of(&|p| 1e6 * p.dte.mean));
            let (apart, back) = (of(&|p| flanks(&p.contact).0), of(&|p| flanks(&p.contact).1));
            println!(
                "set {name} {words}: RMS {:.2} .. {:.2} μm, mean {:.2} .. {:.2} μm, contact loss \
                 {:.1} .. {:.1} %, on the back flank {:.1} .. {:.1} %",
                rms[0], rms[1], mean[0], mean[1], apart[0], apart[1], back[0], back[1]
            );
        }
    }
    let curve = |name: &str, of: &dyn Fn(&Point) -> f64| {
        cases
            .iter()
            .zip(&points)
            .filter(|(c, _)| c.0 == name)
            .map(|(c, p)| (c.1.rpm, of(p)))
            .collect::<Vec<_>>()
    };
    let both = |title: &str, y: &str, of: &dyn Fn(&Point) -> f64| {
        Panel::new(title, "speed [r/min]", y).with("set A", Mark::Line, curve("A", of)).with(
            "set E",
            Mark::Line,
            curve("E", of),
        )
    };
    let rms = both("RMS of the transmission error", "[m]", &|p| p.dte.rms);
    let mean = both("mean of the transmission error", "[m]", &|p| p.dte.mean);
    figure(
        folder.join("fig9_10_speed.svg"),
        1,
        &[rms, mean, both("peak-to-peak", "[m]", &|p| p.dte.peak_to_peak())],
    )?;

    println!(
        "\nFigs. 11-13 and conclusion 4: mesh force of the first pair, 1000 r/min, random values held for \
         one mesh period"
    );
    println!(
        "{:>4} {:28} {:>13} {:>13} {:>13} {:>16} {:>15}",
        "set", "disturbance", "|W|, t < 7 s", "|W|, t > 7 s", "p-p, t > 7 s", "|K d|, t < 7 s", "t > 7 s [N]"
    );
    let c_g = RingSet::set_e(3, 1000.0).mesh_damping;
    let mut disturbances: Vec<Disturbance> =
        [0.0, 0.5, 1.0, 10.0, 100.0, c_g, 2.0 * c_g].map(Disturbance::Constant).into();
    disturbances.extend([1.0, c_g, 2.0 * c_g].map(Disturbance::Damping));
    disturbances.extend([
        Disturbance::Torque(0.1),
        Disturbance::Clearance(0.01),
        Disturbance::Clearance(0.1),
    ]);
    let cases: Vec<(&str, RingSet, Disturbance)> =
        sets.iter().flat_map(|(name, set)| disturbances.iter().map(|d| (*name, set(1000.0), *d))).collect();
    let bar = progress("disturbances", cases.len());
    let forces: Vec<Result<Force, String>> = cases
        .par_iter()
        .map(|(name, set, disturbance)| {
            let force =
                disturbance.force(set).map_err(|e| format!("set {name}, {}: {e}", disturbance.name()));
            bar.inc(1);
            force
        })
        .collect();
    bar.finish_and_clear();
    let mut csv = csv_file(
        folder.join("mesh_force.csv"),
        "set,disturbance,peak_early,peak_late,p2p_late,spring_early,spring_late",
    )?;
    for ((name, _, disturbance), f) in cases.iter().zip(forces) {
        let (f, what) = (f?, disturbance.name());
        csv.row(&[
            name,
            &what.replace(", ", " "),
            &f.peak[0],
            &f.peak[1],
            &f.steady,
            &f.spring[0],
            &f.spring[1],
        ])?;
        println!(
            "{name:>4} {what:28} {:13.2} {:13.3} {:13.3} {:16.1} {:15.1}",
            f.peak[0], f.peak[1], f.steady, f.spring[0], f.spring[1]
        );
    }

    let bare = ring(&RingSet::set_e(3, 1000.0))?;
    let hold = bare.period(); // one mesh period
    let process = HeldProcess::new(hold, Uniform::new(0.0, 1.0)?)?.seed(2020);
    let slots = damping_slots(&bare)?;
    let noisy = |gain: f64| Held::new(bare.clone()).per_slot(&slots, gain, process.clone());
    let channels = ["mesh force 1", "stiffness times deflection 1"];
    let drawn = |label: &str, (times, values): History| -> Panel {
        Panel::new(format!("mesh force of set E, {label}"), "t [s]", "W1 [N]").with(
            "",
            Mark::Line,
            envelope(&times, &values[0], 800),
        )
    };
    let constant = ring(&RingSet { mesh_damping: c_g + 0.5, ..RingSet::set_e(3, 1000.0) })?;
    let values = (0..400).map(|k| (f64::from(k), process.held(0, k as u64))).collect();
    let panels = [
        Panel::new("held values of C_D (first mesh)", "hold number", "value [1]").with(
            "",
            Mark::Dots,
            values,
        ),
        drawn("C_D = 0", history(&bare, &channels, 8.0, 1e-4)?),
        drawn("C_D = 0.5 N s/m", history(&constant, &channels, 8.0, 1e-4)?),
        drawn("C_D = U(0,1) N s/m", history(&noisy(1.0)?, &channels, 8.0, 1e-4)?),
        drawn("C_D = U(0,1) C_g", history(&noisy(c_g)?, &channels, 8.0, 1e-4)?),
    ];
    figure(folder.join("fig11_13_mesh_force.svg"), 1, &panels)?;

    // Extremes of the force inside the steps, during settling.
    let mut statistics = Statistics::new(&bare, &channels)?;
    let mut seen = 0u64;
    solver(&bare).run(&bare, &State::at_rest(bare.dof()), 7.0, &mut |step: &mut Step<'_>| {
        seen += step.crossings().len() as u64;
        let _ = gear_dynamics::ode::Observer::step(&mut statistics, step);
        ControlFlow::Continue(())
    })?;
    let (w, kd) = (statistics.summary(channels[0])?, statistics.summary(channels[1])?);
    println!(
        "set E, extremes inside the steps, t < 7 s: W {:.2} .. {:.2} N, K d up to {:.2} N, {seen} crossings",
        w.min, w.max, kd.max
    );
    println!("\npictures and tables: {}", folder.display());
    Ok(())
}
