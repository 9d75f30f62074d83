//! The closed-loop gear ring of Yao 2020, Figs. 5-10: deflection of the first pair over time, its spectrum and its
//! statistics over speed, with sets A and E of docs/models.md for the parameters that Yao 2020 does not state.

use super::super::report::{Kind, Report};
use super::super::support::{Outcome, coarse, progress};
use gear_dynamics::analysis::{ContactStatistics, Spectrum, Summary, Window};
use gear_dynamics::drives::Noisy;
use gear_dynamics::linear::Modes;
use gear_dynamics::models::ring::{Frame, RingSet};
use gear_dynamics::ode::uniform_times;
use gear_dynamics::processes::HeldProcess;
use gear_dynamics::{Dop853, Integrator, Model, ParameterError, Rattle, Ring, State, Statistics};
use gear_dynamics_plots::{Mark, Panel};
use rayon::prelude::*;

pub type Set = (&'static str, fn(f64) -> RingSet);
pub const SETS: [Set; 2] = [("A", |rpm| RingSet::set_a(3, rpm)), ("E", |rpm| RingSet::set_e(3, rpm))];

/// The ring of three gears as Yao 2020 prints it, in the frame of its rigid motion, since 44 N m and 3 x 2 N
/// m do not balance.
pub fn ring(set: &RingSet) -> Outcome<Ring> {
    Ok(Ring::as_printed(&set.params()?)?.with_frame(Frame::Rigid))
}

/// The ring with gain × a held process added to the damping of each mesh.
pub fn with_damping(ring: Ring, gain: f64, process: &HeldProcess) -> Result<Noisy<Ring>, ParameterError> {
    let mut held = Noisy::new(ring);
    for mesh in 0..3 {
        let slot = held.bare().slot(&format!("mesh damping {mesh}"))?;
        held = held.add(&[(slot, gain)], process)?;
    }
    Ok(held)
}

/// Tolerances by component: angles of 1e-3 rad contain deflections of 1e-5 m.
pub fn solver<M: Model>(model: &M) -> Dop853 {
    let n = model.dof();
    Dop853::new().rtol(1e-8).atol_each(&[vec![1e-11; n], vec![1e-7; n]].concat())
}

/// Times, and the values of channels at them.
pub type History = (Vec<f64>, Vec<Vec<f64>>);

/// Channels of a run from rest, every `spacing` seconds.
pub fn history<M: Model>(model: &M, channels: &[&str], end: f64, spacing: f64) -> Outcome<History> {
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
        (Rattle::new(&ring), Statistics::new(&ring, &["deflection 0", "mesh force 0"])?);
    solver.run(&ring, &settled, 5.5, &mut (&mut rattle, &mut statistics))?;
    let (dte, force) = (statistics.summary("deflection 0")?, statistics.summary("mesh force 0")?);
    Ok(Point { dte, force, contact: rattle.contacts()[0] })
}

/// Natural frequencies, and the torque that accelerates the ring.
pub fn modes(report: &mut Report) -> Outcome<()> {
    let mut rows = Vec::new();
    for (name, set) in SETS {
        let ring = ring(&set(1000.0))?;
        let hertz: Vec<String> =
            Modes::mean_in_contact(&ring)?.hertz().iter().map(|f| format!("{f:.1}")).collect();
        rows.push(vec![
            name.into(),
            format!("{:.0}", ring.torque_imbalance()),
            format!("{:.1}", ring.rigid_acceleration()),
            hertz.join(", "),
        ]);
    }
    let header = ["set", "torque imbalance [N m]", "rigid acceleration [rad/s²]", "natural frequencies [Hz]"];
    report.table("ring_modes", Kind::Fixed, &header, &rows);
    Ok(())
}

/// Figs. 5-7.
pub fn transmission_error(report: &mut Report) -> Outcome<()> {
    let widths = if coarse() { vec![2.65e-5] } else { vec![2.65e-6, 2.65e-5, 2.65e-4] };
    let cases: Vec<(Set, f64)> = SETS.iter().flat_map(|set| widths.iter().map(|b| (*set, *b))).collect();
    // Extremes inside the steps, from 0 to 1 s and from 9 to 10 s.
    let run = |ring: &Ring| -> Outcome<([Summary; 2], History)> {
        let (mut early, mut late) =
            (Statistics::new(ring, &["deflection 0"])?, Statistics::new(ring, &["deflection 0"])?);
        let solver = solver(ring);
        let at_one = solver.run(ring, &State::at_rest(ring.dof()), 1.0, &mut early)?.state;
        let at_nine = solver.end(ring, &at_one, 9.0)?;
        solver.run(ring, &at_nine, 10.0, &mut late)?;
        let extremes = [early.summary("deflection 0")?, late.summary("deflection 0")?];
        Ok((extremes, history(ring, &["deflection 0"], 10.0, 1e-4)?))
    };
    let runs: Vec<Result<_, String>> = cases
        .par_iter()
        .map(|((_, set), half_backlash)| {
            let set = RingSet { half_backlash: *half_backlash, ..set(1000.0) };
            ring(&set).and_then(|ring| run(&ring)).map_err(|e| e.to_string())
        })
        .collect();
    let (mut rows, mut panels) = (Vec::new(), Vec::new());
    for (((name, _), b), run) in cases.iter().zip(runs) {
        let ([early, late], (times, values)) = run?;
        rows.push(vec![
            (*name).to_owned(),
            format!("{}", 1e6 * b),
            format!("{:.3}", 1e6 * late.mean),
            format!("{:.2}", 1e6 * early.peak_to_peak()),
            format!("{:.4}", 1e6 * late.peak_to_peak()),
        ]);
        let panel = Panel::new(format!("set {name}, b = {} μm", 1e6 * b), "time t [s]", "deflection d1 [m]")?;
        panels.push(panel.series("", Mark::Line, times.into_iter().zip(values[0].iter().copied()))?);
    }
    #[rustfmt::skip]
    let header = ["set", "b [μm]", "mean after 9 s [μm]", "peak-to-peak within 1 s [μm]",
        "peak-to-peak after 9 s [μm]"];
    report.table("ring_deflection", Kind::Fixed, &header, &rows);
    report.picture("fig5_7_transmission_error.svg", 3, panels);
    Ok(())
}

/// Fig. 8: first 4 s, Hann window.
pub fn spectrum(report: &mut Report) -> Outcome<()> {
    let (mut rows, mut panels) = (Vec::new(), Vec::new());
    for (name, set) in SETS {
        let (_, values) = history(&ring(&set(1000.0))?, &["deflection 0"], 4.0, 2.5e-5)?;
        let spectrum = Spectrum::new(&values[0], 2.5e-5, Window::Hann)?;
        let lines: Vec<(f64, f64)> =
            spectrum.frequencies().iter().zip(spectrum.amplitudes()).map(|(f, a)| (*f, *a)).collect();
        let mut peaks: Vec<(f64, f64)> = lines
            .windows(3)
            .filter(|w| w[0].0 > 5.0 && w[1].1 > w[0].1 && w[1].1 > w[2].1)
            .map(|w| w[1])
            .collect();
        peaks.sort_by(|a, b| b.1.total_cmp(&a.1));
        let named: Vec<String> =
            peaks.iter().take(4).map(|(f, a)| format!("{f:.1} Hz ({:.3} nm)", 1e9 * a)).collect();
        rows.push(vec![name.into(), format!("{:.2}", 1e6 * lines[0].1), named.join(", ")]);
        let drawn = lines.iter().take_while(|line| line.0 <= 1600.0);
        let decades = drawn.map(|(f, a)| (*f, a.max(1e-13)));
        let panel = Panel::new(format!("set {name}"), "frequency f [Hz]", "amplitude of the deflection [m]")?;
        panels.push(panel.series("", Mark::Line, decades)?.logarithmic_y()?);
    }
    report.table("ring_spectrum", Kind::Fixed, &["set", "at 0 Hz [μm]", "largest lines"], &rows);
    report.picture("fig8_spectrum.svg", 2, panels);
    Ok(())
}

/// Figs. 9 and 10.
pub fn over_speed(report: &mut Report) -> Outcome<()> {
    let step = if coarse() { 5000.0 } else { 500.0 };
    let speeds: Vec<f64> = (1..).map(|i| step * f64::from(i)).take_while(|rpm| *rpm <= 1e4).collect();
    let cases: Vec<(&str, RingSet)> =
        SETS.iter().flat_map(|(name, set)| speeds.iter().map(|rpm| (*name, set(*rpm)))).collect();
    let bar = progress("speed sweep of the ring", cases.len());
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
    let flanks =
        |c: &ContactStatistics| (100.0 * c.loss_fraction(), 100.0 * c.time[0] / c.time.iter().sum::<f64>());
    report.csv(
        "ring_speed.csv",
        "set,rpm,dte_mean,dte_rms,dte_p2p,force_min,force_max,apart,back_flank",
        |csv| {
            for ((name, set), p) in cases.iter().zip(&points) {
                let ((apart, back), d) = (flanks(&p.contact), p.dte);
                #[rustfmt::skip]
                csv.row(&[name, &set.rpm, &d.mean, &d.rms, &d.peak_to_peak(), &p.force.min, &p.force.max, &apart,
                    &back])?;
            }
            Ok(())
        },
    );
    let rows: Vec<Vec<String>> = cases
        .iter()
        .zip(&points)
        .filter(|((_, set), _)| set.rpm % 1000.0 == 0.0)
        .map(|((name, set), p)| {
            let (apart, back) = flanks(&p.contact);
            vec![
                (*name).to_owned(),
                set.rpm.to_string(),
                format!("{:.2}", 1e6 * p.dte.mean),
                format!("{:.2}", 1e6 * p.dte.rms),
                format!("{:.2}", 1e6 * p.dte.peak_to_peak()),
                format!("{:.1}", p.force.min),
                format!("{:.1}", p.force.max),
                format!("{apart:.1} %"),
                format!("{back:.1} %"),
            ]
        })
        .collect();
    #[rustfmt::skip]
    let header = ["set", "r/min", "mean [μm]", "RMS [μm]", "peak-to-peak [μm]", "W min [N]", "W max [N]",
        "contact lost", "back flank"];
    report.table("ring_over_speed", Kind::Full, &header, &rows);
    let curve = |name: &str, of: fn(&Point) -> f64| {
        let mine = cases.iter().zip(&points).filter(|(c, _)| c.0 == name);
        mine.map(|(c, p)| (c.1.rpm, of(p))).collect::<Vec<_>>()
    };
    let panel = |value: &str, of: fn(&Point) -> f64| {
        let panel = Panel::new("Figs. 9 and 10", "speed [r/min]", value)?;
        SETS.iter().try_fold(panel, |panel, (name, _)| {
            panel.series(&format!("set {name}"), Mark::Joined, curve(name, of))
        })
    };
    let panels = [
        panel("RMS of the deflection [m]", |p| p.dte.rms)?,
        panel("mean of the deflection [m]", |p| p.dte.mean)?,
        panel("peak-to-peak of the deflection [m]", |p| p.dte.peak_to_peak())?,
    ];
    report.picture("fig9_10_speed.svg", 3, panels);
    Ok(())
}
