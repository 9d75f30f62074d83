//! The pictures of the course.

use super::Outcome;
use super::pair::{bench_pair, tooth_stiffness, waves, with_brake, with_law};
use gear_dynamics::branches::{Branch, BranchPoint, Continuation, Family, PointKind};
use gear_dynamics::contact::{Deflection, Edges, Nonlinearity, Piece};
use gear_dynamics::drives::Noisy;
use gear_dynamics::excitation::{Angle, Side};
use gear_dynamics::linear::{Modes, static_state};
use gear_dynamics::model::Scalar;
use gear_dynamics::ode::Probe;
use gear_dynamics::ode::{Step, uniform_times};
use gear_dynamics::periodic::ShootingOrbit;
use gear_dynamics::processes::HeldProcess;
use gear_dynamics::sweep::{Axis, Bifurcation, Ensemble, LaneRk4, Points};
use gear_dynamics::trains::Train;
use gear_dynamics::{
    Dop853, Integrator, ParameterError, Periodic, Rk4, Rk45, Settle, State, Statistics, Sweep, Taylor, Wave,
};
use gear_dynamics_plots::{
    Mark, Panel, Picture, band, branch, history, phase_portrait, rattle_map, stiffness,
};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

pub fn excitation(_: bool) -> Outcome<Picture> {
    let ([k, e], uncut) = (waves()?, Wave::new(tooth_stiffness()?));
    let lines = [("model: cut after 3 harmonics", &k), ("uncut, Ma et al. 2014", &uncut)];
    let first = stiffness(&lines, "mesh stiffness k(φ) [N/m]", 1.0)?.below();
    let first = first.title(format!("mesh stiffness, mean {:.0}·10⁶ N/m", 1e-6 * k.mean()));
    let first = first.y_range(0.0, 4e8)?.name_y(&[(k.mean(), "mean")])?;
    let first = first.note((0.25, 6e7), "two pairs of teeth")?.note((0.99, 6e7), "one pair")?;
    let second = stiffness(&[("", &e)], "static error e(φ) [m]", 1.0)?;
    let amplitude = (0..1000).map(|i| e.value(TAU * f64::from(i) / 1000.0, Side::After)).fold(0.0, f64::max);
    let names = [-1.0, 1.0]
        .map(|sign| (sign * amplitude, format!("{:+.1} μm", sign * 1e6 * amplitude).replace('-', "−")));
    let second = second.name_y(&names.each_ref().map(|(at, name)| (*at, name.as_str())))?;
    Ok(Picture::new([first, second.title("static transmission error, limit of grade 6")])
        .columns(2)
        .panel_size(350.0, 290.0))
}

/// The branch of the pair over its speed.
fn branch_of<N: Nonlinearity>(pair: &Train<N>, [from, to]: [f64; 2]) -> Outcome<Branch<ShootingOrbit>> {
    let start = static_state(pair, None)?.state;
    Ok(Continuation::new(from, to).max_step(0.002).run(&Family::over(pair, ["speed"])?, &[start])?)
}

const SPEED: &str = "speed of the driver [rad/s]";
const SWING: &str = "peak-to-peak value of d [m]";

/// Peak-to-peak value of the deflection over the speed.
fn curve(line: &Branch<ShootingOrbit>) -> Vec<(f64, f64)> {
    line.points().iter().map(|point| (point.parameter, point.peak_to_peak())).collect()
}

pub fn response(_: bool) -> Outcome<Picture> {
    let pair = bench_pair(120.0)?;
    let linear = branch_of(&pair.with("mesh half backlash", 0.0)?, [120.0, 600.0])?;
    let loss = branch_of(&pair, [120.0, 600.0])?;
    let deformation = 300.0 / 0.070_477 / waves()?[0].mean(); // F/k [m]
    let natural = Modes::mean_in_contact(&pair)?.frequencies()[0]; // [rad/s]
    let orders = [50.0, 100.0, 150.0].map(|order| (natural / order, format!("order {order}")));
    let orders = orders.each_ref().map(|(at, name)| (*at, name.as_str()));
    let panel = || -> Outcome<Panel> {
        let panel = branch(&[&loss], [SPEED, SWING], BranchPoint::peak_to_peak)?;
        let panel =
            panel.series("linear, without gap", Mark::Line, curve(&linear))?.below().logarithmic_y()?;
        Ok(panel.name_y(&[(2.0 * deformation, "2F/k")])?.name_x(&orders)?)
    };
    let ([left, right], [low, high]) = ([172.0, 212.0], [2e-5, 6e-5]);
    let frame = [(left, low), (right, low), (right, high), (left, high), (left, low)];
    let most = there(&loss, 460.0).into_iter().fold(0.0, f64::max);
    let whole = panel()?.x_range(100.0, 605.0)?.note((460.0, most), "with contact loss")?;
    let whole = whole.series("part (b)", Mark::Dashed, frame)?.grey();
    let whole =
        whole.title("response, 300 N m, b = 40 μm; dotted upright: an order meets the natural frequency");
    let part = panel()?.x_range(left, right)?.y_range(low, high)?;
    let part = part.title("the same near the speed at which order 100 meets the natural frequency");
    Ok(Picture::new([whole, part]).panel_size(640.0, 340.0))
}

/// Some mesh periods of the pair after it has settled, from the time 0.
fn settled(speed: f64, periods: f64) -> Outcome<(Train, gear_dynamics::ode::Trajectory)> {
    let pair = bench_pair(speed)?;
    let steady = Settle::new().tolerance(1e-8).run(&Taylor::new(), &pair, None)?.state;
    let start = State { t: 0.0, ..steady };
    let times = uniform_times(0.0, periods * pair.period(), (200.0 * periods) as usize)?;
    let run = Taylor::new().sample(&pair, &start, &times)?;
    Ok((pair, run))
}

pub fn contact_loss(_: bool) -> Outcome<Picture> {
    let (pair, run) = settled(380.0, 5.0)?;
    let deflection = history(&pair, &run, "deflection [m]", 0)?.y("deflection d [m]")?;
    let force = history(&pair, &run, "mesh force [N]", 0)?
        .y("mesh force W [N]")?
        .name_y(&[(0.0, "0"), (300.0 / 0.070_477, "F")])?
        .title("mesh force of the same motion");
    let deflection = deflection.title("deflection at 380 rad/s, 300 N m, b = 40 μm");
    Ok(Picture::new([deflection, force]).panel_size(560.0, 260.0))
}

pub fn orbit(_: bool) -> Outcome<Picture> {
    let (pair, run) = settled(380.0, 1.01)?;
    let axes = ["deflection d [m]", "rate of deflection d′ [m/s]"];
    let contact = Probe::new(&pair).read_contacts(0.0, Side::After, run.q(0), run.v(0))[0];
    let section = [(contact.deflection, contact.rate)];
    let panel =
        phase_portrait(&pair, &run, axes, 0)?.series("Poincaré section, φ = 0", Mark::Dots, section)?;
    Ok(panel.name_y(&[(0.0, "d′ = 0")])?.title("one mesh period at 380 rad/s, 300 N m, b = 40 μm").into())
}

/// Peak-to-peak values of a branch at a speed, by straight lines between its points.
fn there(line: &Branch<ShootingOrbit>, speed: f64) -> Vec<f64> {
    let crossed = |two: &[(f64, f64)]| {
        let [(a, from), (b, to)] = [two[0], two[1]];
        let share = (speed - a) / (b - a);
        (0.0..=1.0).contains(&share).then_some(from + share * (to - from))
    };
    curve(line).windows(2).filter_map(crossed).collect()
}

pub fn jumps(coarse: bool) -> Outcome<Picture> {
    let pair = bench_pair(270.0)?;
    let line = branch_of(&pair, [270.0, 400.0])?;
    let speeds = Axis::linear("speed", 280.0, 345.0, if coarse { 6 } else { 14 })?;
    let sweep = Sweep::new(speeds).settle(60).measure(4).channels(&["deflection"]);
    let diagram = Bifurcation::extremes("deflection").run(&sweep.over(&LaneRk4::of_model(&pair)?, &pair)?)?;
    let swings = |points: &[gear_dynamics::sweep::DiagramPoint]| -> Vec<(f64, f64)> {
        let swing = |values: &[f64]| {
            let [low, high] =
                values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(*x), h.max(*x)]);
            high - low
        };
        points.iter().map(|point| (point.parameter, swing(&point.values))).collect()
    };
    let panel = branch(&[&line], [SPEED, SWING], BranchPoint::peak_to_peak)?
        .series("sweep up", Mark::Dots, swings(diagram.up()))?
        .series("sweep down", Mark::Rings, swings(diagram.down()))?;
    // From each fold to the other stable motion at its speed.
    let jump = |panel: Panel, fold: &BranchPoint<ShootingOrbit>| {
        let (at, from) = (fold.parameter, fold.peak_to_peak());
        let off = |to: &f64| (to - from).abs();
        let to = there(&line, at).into_iter().max_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(from);
        panel.series("jump", Mark::Directed, [(at, from), (at, to)]).map(Panel::black)
    };
    let panel = line.of_kind(PointKind::Fold).into_iter().try_fold(panel, jump)?;
    let panel =
        panel.title("spur pair of 50 teeth, b = 40 μm, 300 N m: folds and sweeps").x_range(270.0, 360.0)?;
    Ok(Picture::from(panel).panel_size(640.0, 400.0))
}

pub fn map(coarse: bool) -> Outcome<Picture> {
    let (columns, rows) = if coarse { (20, 7) } else { (77, 46) };
    let pair = bench_pair(270.0)?;
    let axes = vec![
        Axis::linear("speed", 220.0, 600.0, columns)?,
        Axis::linear("drive torque", 150.0, 600.0, rows)?,
    ];
    let sweep = Sweep::new(Points::grid(axes)?).settle(60).measure(2).rattle();
    let runs = sweep.over(&LaneRk4::of_model(&pair)?, &pair)?.run()?;
    let mut panel = rattle_map(&runs, [SPEED, "torque on the driver T [N m]"], 0)?;
    let line = branch_of(&pair, [270.0, 605.0])?;
    let plane = Family::over(&pair, ["speed", "drive torque"])?;
    let mut add = |name: &str, from: f64, ends: &[f64], point: &BranchPoint<ShootingOrbit>| -> Outcome<()> {
        for to in ends {
            let boundary = Continuation::new(from, *to).run(&plane, point)?;
            panel = panel.clone().boundary(name, &boundary)?;
        }
        Ok(())
    };
    // Above 250 N m the right fold and the onset are closer than a line is wide.
    let low = branch_of(&pair.with_all(&[("drive torque", 250.0), ("speed", 250.0)])?, [250.0, 340.0])?;
    let folds = [&low, &line].map(|branch| branch.of_kind(PointKind::Fold));
    let ([right, ..], [_, left, ..]) = (&folds[0][..], &folds[1][..]) else {
        return Err("a branch without folds".into());
    };
    add("fold", 250.0, &[145.0], right)?;
    add("fold", 300.0, &[145.0, 605.0], left)?;
    for point in line.of_kind(PointKind::Grazing) {
        add("onset of contact loss (grazing)", 300.0, &[145.0, 605.0], point)?;
    }
    let panel = panel.mark_rows("sensitive run", &runs, |row| row.is_sensitive())?;
    Ok(Picture::from(panel.title("rattle state, b = 40 μm, each run from its static state"))
        .panel_size(640.0, 400.0))
}

pub fn random(coarse: bool) -> Outcome<Picture> {
    let pair = with_brake(300.0)?;
    let solver = Dop853::new().rtol(1e-6).atol_each(&[1e-11, 1e-11, 1e-7, 1e-7]);
    let steady = Settle::new().run(&solver, &pair, None)?.state;
    let start = State::new(0.0, &steady.q, &steady.v);
    let process = HeldProcess::new(1e-3, rand_distr::Uniform::new_inclusive(-100.0, 100.0)?)?;
    let ensemble = Ensemble::new(if coarse { 20 } else { 400 }, 0.006, 1200)?;
    let ensemble = ensemble.channels(&["mesh force"]).peaks(&["mesh force"]);
    let bands = ensemble.run(&solver, |member| {
        let process = process.clone().member(member);
        let held = Noisy::new(pair.clone()).add(&[(pair.slot("drive")?, 1.0)], &process)?;
        Ok::<_, ParameterError>((held, start.clone()))
    })?;
    let panel = band(&bands, "mesh force [N]", [0.05, 0.95])?.y("mesh force W [N]")?;
    let mut seen = Statistics::new(&pair, &["mesh force"])?;
    solver.run(&pair, &start, 0.006, &mut seen)?;
    let (constant, peaks) = (seen.summary("mesh force")?.max, bands.peak("mesh force")?.mean());
    let names = [("steady peak", constant), ("mean of peaks", peaks)]
        .map(|(name, force)| format!("{name} {:.2} kN", 1e-3 * force));
    let panel = panel.y_range(0.0, 1e4)?.name_y(&[(constant, &names[0]), (peaks, &names[1])])?;
    let title = "torque 300 N m ± 100 N m, uniform, held for 1 ms; 300 rad/s, b = 40 μm";
    Ok(Picture::from(panel.title(title)).panel_size(640.0, 320.0))
}

/// A preload -p, flanks of the slope r up to the depth s, then a stop of slope 1.
#[derive(Clone, PartialEq)]
struct Sprung {
    b: f64,
    p: f64,
    r: f64,
    s: f64,
}

impl Nonlinearity for Sprung {
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
        let positive = |y: S| y.max(S::from(0.0));
        let press = |y: S| positive(y) * self.r + positive(y - S::from(self.s)) * (1.0 - self.r);
        press(at.d - at.upper) - press(at.lower - at.d) - S::from(self.p)
    }
    fn force_on<S: Scalar>(&self, piece: Piece, kinks: &[Piece], at: Deflection<S>) -> S {
        let stopped = kinks.first() == Some(&piece);
        let press = |y: S| if stopped { y - S::from((1.0 - self.r) * self.s) } else { y * self.r };
        match piece {
            Piece::Upper => press(at.d - at.upper) - S::from(self.p),
            Piece::Gap => S::from(-self.p),
            Piece::Lower => -press(at.lower - at.d) - S::from(self.p),
        }
    }
    fn kinks(&self) -> usize {
        1
    }
    fn kink<S: Scalar>(&self, _: usize, x: S, _: S) -> S {
        x * (self.b / (self.b + self.s))
    }
    fn edges<A: Angle>(&self, _: A, _: Side) -> Edges<A::Number> {
        Edges::at_rest(-self.b, self.b)
    }
}

pub fn law(_: bool) -> Outcome<Picture> {
    let sprung = Sprung { b: 4e-5, p: 2e-6, r: 0.5, s: 4e-6 };
    let force =
        |x: f64| (1e-6 * x, sprung.force(Deflection { d: 1e-6 * x, rate: 0.0, lower: -4e-5, upper: 4e-5 }));
    let ideal = |x: f64| (1e-6 * x, 1e-6 * ((x - 40.0).max(0.0) - (-x - 40.0).max(0.0)));
    let kinks = [-50.0, -44.0, -40.0, 40.0, 44.0, 50.0];
    let laws = Panel::new("contact law, b = 40 μm", "deflection d [m]", "force over stiffness f(d) [m]")?
        .series("linear flanks", Mark::Line, kinks.map(ideal))?
        .black()
        .series("preload 2 μm, slope ½ up to the stop 4 μm past the edge", Mark::Joined, kinks.map(force))?
        .grey()
        .below()
        .name_x(&[(-4e-5, "−b"), (4e-5, "b")])?
        .x_range(-4.8e-5, 4.8e-5)?
        .y_range(-9e-6, 9e-6)?;
    let linear = branch_of(&bench_pair(270.0)?, [270.0, 400.0])?;
    let other = branch_of(&with_law(sprung, 270.0)?, [270.0, 400.0])?;
    let panel = |notes: [(&Branch<ShootingOrbit>, f64, &str); 2]| -> Outcome<Panel> {
        let mut lines = branch(&[&linear, &other], [SPEED, SWING], BranchPoint::peak_to_peak)?;
        for (line, at, name) in notes {
            let most = there(line, at).into_iter().fold(0.0, f64::max);
            lines = lines.note((at, most), name)?;
        }
        Ok(lines)
    };
    let whole = panel([(&linear, 360.0, "linear flanks"), (&other, 345.0, "preload, stop")])?;
    let ([left, right], [low, high]) = ([328.0, 340.0], [2.2e-5, 3.6e-5]);
    let frame = [(left, low), (right, low), (right, high), (left, high), (left, low)];
    let whole = whole.series("part (c)", Mark::Dashed, frame)?.grey();
    let whole = whole.x_range(270.0, 400.0)?.title("response, 300 N m, b = 40 μm");
    let part = branch(&[&linear, &other], [SPEED, SWING], BranchPoint::peak_to_peak)?;
    let part = part.note((333.0, 3.3e-5), "linear flanks")?.note((338.5, 3.0e-5), "preload, stop")?;
    let part =
        part.x_range(left, right)?.y_range(low, high)?.title("the same near the onset of contact loss");
    Ok(Picture::new([laws, whole, part]).panel_size(640.0, 280.0))
}

pub fn solvers(_: bool) -> Outcome<Picture> {
    let pair = bench_pair(380.0)?;
    let start = static_state(&pair, None)?.state;
    let (end, radius) = (50.0 * pair.period(), 0.070_477);
    let exact = Dop853::new().rtol(1e-13).atol_each(&[1e-17, 1e-13]).end(&pair, &start, end)?.q[0];
    // The reference is as accurate as it agrees with a second method: no smaller error is known or drawn.
    let second = Taylor::new().rtol(1e-13).atol_each(&[1e-18, 1e-14]).end(&pair, &start, end)?.q[0];
    let floor = (radius * (second - exact)).abs();
    let work = |solver: &dyn Fn(f64) -> Outcome<(u64, f64)>, settings: &[f64]| -> Outcome<Vec<(f64, f64)>> {
        let runs = settings.iter().map(|setting| solver(*setting));
        let point = |run: Outcome<(u64, f64)>| {
            let (evaluations, q) = run?;
            Ok((evaluations as f64, (radius * (q - exact)).abs().max(floor)))
        };
        runs.map(point).collect()
    };
    let atol = |rtol: f64| [1e-5 * rtol, 1e-1 * rtol];
    let steps = [32.0, 64.0, 128.0, 256.0, 512.0];
    let tolerances = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11];
    let run = |solver: &dyn Runs| solver.ends(&pair, &start, end);
    let plain = work(&|n| run(&Rk4::new(pair.period() / n).plain()), &steps)?;
    let rk4 = work(&|n| run(&Rk4::new(pair.period() / n)), &steps)?;
    let rk45 = work(&|r| run(&Rk45::new().rtol(r).atol_each(&atol(r))), &tolerances)?;
    let dop853 = work(&|r| run(&Dop853::new().rtol(r).atol_each(&atol(r))), &tolerances)?;
    let taylor = work(&|r| run(&Taylor::new().rtol(r).atol_each(&atol(r))), &tolerances)?;
    let title = "error after 50 mesh periods at 380 rad/s, 300 N m, b = 40 μm";
    let panel = Panel::new(title, "evaluations of the accelerations [1]", "error of d at the end [m]")?;
    let mut panel = panel.logarithmic_x()?.logarithmic_y()?.name_y(&[(floor, "references differ")])?;
    // These have the colours and marks of docs/integrators.svg.
    for (name, points) in [("Rk4", rk4), ("Rk45", rk45), ("Dop853", dop853), ("Taylor", taylor)] {
        let end = *points.last().ok_or("a solver without runs")?;
        panel = panel.series(name, Mark::Joined, points)?.note(end, name)?;
    }
    let name = "Rk4, edges not located";
    let middle = plain[2];
    let panel = panel.series(name, Mark::Joined, plain)?.black().note(middle, name)?;
    Ok(Picture::from(panel).panel_size(640.0, 420.0))
}

/// Any solver.
trait Runs {
    /// Evaluations and the angle of the driver at the end.
    fn ends(&self, pair: &Train, start: &State, end: f64) -> Outcome<(u64, f64)>;
}

impl<I: Integrator> Runs for I {
    fn ends(&self, pair: &Train, start: &State, end: f64) -> Outcome<(u64, f64)> {
        let run = self.run(pair, start, end, &mut |_: &mut Step<'_>| ControlFlow::Continue(()))?;
        Ok((run.stats.evaluations, run.state.q[0]))
    }
}
