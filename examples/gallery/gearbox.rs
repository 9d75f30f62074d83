//! Pictures of a two-stage gearbox and of a planetary set.

use super::Outcome;
use gear_dynamics::analysis::{Spectrum, Window};
use gear_dynamics::linear::{Campbell, Mode, Modes};
use gear_dynamics::ode::uniform_times;
use gear_dynamics::teeth::{GearPair, InvoluteGear, MethodB, QualityGrade, TransmissionError};
use gear_dynamics::trains::{
    Bearing, Body, Members, MeshPart, ModeKind, OfMesh, Parts, Planetary, ShaftPart, Train,
};
use gear_dynamics::{Integrator, Periodic, Settle, Taylor, Wave};
use gear_dynamics_plots::{Mark, Panel, Picture, mode};
use std::f64::consts::TAU;

/// A stage of steel gears of grade 6: teeth, profile shifts, bores [m]; module, width and centre distance [m].
fn stage(
    z: [u32; 2],
    x: [f64; 2],
    bores: [f64; 2],
    [module, width, distance]: [f64; 3],
) -> Outcome<(MeshPart, [Body; 2])> {
    let gear =
        |i: usize| InvoluteGear::external(z[i], module)?.with_profile_shift(x[i])?.with_face_width(width);
    let pair = GearPair::at_centre_distance(&gear(0)?, &gear(1)?, distance)?;
    let one = MethodB::new().stiffness(&pair)?.single * width; // one pair of teeth [N/m]
    let stiffness = Wave::new(pair.rectangular(one, 1.75 * one)?.series(6)?);
    let error = TransmissionError::of_grade(&pair, [QualityGrade::new(6)?; 2])?;
    let mesh = MeshPart::of_pair(&pair, stiffness).error(Wave::new(error.tooth().clone())).damping(2000.0);
    let mesh = mesh.error_of_turn(OfMesh::Driver, Wave::new(error.shaft(0).clone()));
    let body = |i: usize| pair.gears()[i].blank(bores[i], 7850.0).map(|blank| Body::new(blank.polar_inertia));
    Ok((mesh, [body(0)?, body(1)?]))
}

/// Least amplitude that is drawn [N].
const LEAST: f64 = 3e-3;

/// The gearbox of the ninth chapter.
fn gearbox() -> Outcome<Train> {
    let (first, [b1, b2]) = stage([25, 50], [0.2, 0.0], [0.02, 0.03], [0.002, 0.02, 0.0755])?;
    let (second, [b3, b4]) = stage([20, 60], [0.3, -0.1], [0.03, 0.04], [0.003, 0.03, 0.12065])?;
    let mut parts = Parts::new();
    parts.body("motor", Body::new(5e-3)).body("pinion 1", b1).body("wheel 1", b2);
    parts.body("pinion 2", b3).body("wheel 2", b4);
    parts.shaft("input", "motor", "pinion 1", ShaftPart::new(1e4).damping(1.0)).shaft(
        "middle",
        "wheel 1",
        "pinion 2",
        ShaftPart::new(5e4).damping(1.0),
    );
    parts.mesh("first", "pinion 1", "wheel 1", first).mesh("second", "pinion 2", "wheel 2", second);
    Ok(parts.torque("drive", "motor", 50.0).load("wheel 2").build("motor", 150.0)?)
}

pub fn orders(_: bool) -> Outcome<Picture> {
    let train = gearbox()?;
    let state = Settle::new().tolerance(1e-5).run(&Taylor::new(), &train, None)?.state;
    let (count, end) = (2048, state.t + train.period());
    let run = Taylor::new().sample(&train, &state, &uniform_times(state.t, end, count)?)?;
    // Which sources have an order; the first that fits.
    let is_of = |order: f64, of: f64| (order / of).fract() == 0.0;
    let sources: [(&str, &dyn Fn(f64) -> bool); 5] = [
        ("both meshes: 50", &|order| is_of(order, 50.0)),
        ("first mesh: 25", &|order| is_of(order, 25.0)),
        ("second mesh: 10, 20, ...", &|order| is_of(order, 10.0)),
        ("products of both: 5, 15, 35, 45, ...", &|order| is_of(order, 5.0)),
        ("run-out and its sidebands: ½, 1, 24, 26, ...", &|_| true),
    ];
    let panel = |title: &str, channel: &str| -> Outcome<_> {
        let force = run.channel(&train, channel)?;
        let spectrum = Spectrum::new(&force, train.period() / count as f64, Window::Rectangular)?;
        let orders = spectrum.orders(150.0 / std::f64::consts::TAU)?; // turns of the motor [Hz]
        let lines = orders.iter().map(|order| (2.0 * order).round() / 2.0).zip(spectrum.amplitudes());
        let lines: Vec<(f64, f64)> = lines.map(|(order, amplitude)| (order, *amplitude)).collect();
        let shown = |line: &&(f64, f64)| line.0 > 0.0 && line.0 <= 62.0 && line.1 >= LEAST;
        let mut panel = Panel::new(title, "order of the motor [1]", "amplitude of W [N]")?;
        for (i, (name, _)) in sources.iter().enumerate() {
            let own = |line: &&(f64, f64)| sources.iter().position(|(_, is)| is(line.0)) == Some(i);
            let own: Vec<_> = lines.iter().filter(shown).filter(own).copied().collect();
            panel = panel.series(name, Mark::Dots, own.clone())?.series(name, Mark::Bars, own)?;
        }
        let panel = panel.logarithmic_y()?.x_range(-0.5, 62.0)?;
        let names = [(10.0, "second mesh"), (25.0, "first mesh"), (50.0, "both meshes")];
        Ok(panel.y_range(0.5 * LEAST, 1000.0)?.name_x(&names)?)
    };
    let panels = [
        panel("mesh force W of the first mesh, 25/50 teeth; motor at 150 rad/s, 50 N m", "mesh force 0")?,
        panel("mesh force W of the second mesh, 20/60 teeth", "mesh force 1")?,
    ];
    Ok(Picture::new(panels).panel_size(640.0, 300.0))
}

pub fn campbell(coarse: bool) -> Outcome<Picture> {
    let steps: u32 = if coarse { 11 } else { 61 };
    let speeds: Vec<f64> = (0..steps).map(|i| 0.01 + 399.99 * f64::from(i) / f64::from(steps - 1)).collect();
    let diagram = Campbell::of(&gearbox()?, &speeds, &[10.0, 20.0, 25.0, 50.0])?;
    let names = [
        (10.0, "10: second mesh"),
        (20.0, "20: 2 × second"),
        (25.0, "25: first mesh"),
        (50.0, "50: 2 × first, 5 × second"),
    ];
    let panel = gear_dynamics_plots::campbell(&diagram, "speed of the motor [rad/s]", &names)?;
    let panel = panel
        .title("two-stage gearbox: natural frequencies with damping, |λ|/2π, and mesh orders")
        .y_range(0.0, 1600.0)?;
    let mut panel = panel.name_x(&[(150.0, "operating speed")])?;
    let off = |speed: f64| (speed - 150.0f64).abs();
    let orders = |order: f64| names.iter().any(|(named, _)| (named - order).abs() < 1e-9);
    let meetings = diagram.resonances().iter().filter(|meeting| orders(meeting.order));
    if let Some(nearest) = meetings.min_by(|a, b| off(a.speed).total_cmp(&off(b.speed))) {
        let at = (nearest.speed, nearest.frequency / TAU);
        panel = panel.series("crossing next to the operating speed", Mark::Dots, [at])?;
    }
    for frequency in diagram.frequencies()[1].iter().map(|frequency| frequency / TAU).filter(|f| *f < 1600.0)
    {
        panel = panel.note((speeds[1], frequency), &format!("{frequency:.0} Hz"))?;
    }
    Ok(Picture::from(panel).panel_size(640.0, 400.0))
}

pub fn modes(_: bool) -> Outcome<Picture> {
    let wave = |k: f64| Wave::constant(k);
    let members = Members {
        sun: (30, Body::new(1e-3).bearing(Bearing::new(0.4, 1e8))),
        planet: (30, Body::new(1e-3).bearing(Bearing::new(0.7, 1e8))),
        ring: (90, Body::new(5e-2).bearing(Bearing::new(2.0, 1e8)).grounded(1e9, 0.0)),
        carrier: Body::new(3e-2).bearing(Bearing::new(5.0, 1e8)),
    };
    let set =
        Planetary::new(4, 0.03, members, [wave(2e8)?, wave(2.5e8)?])?.damping(700.0).half_backlash(3e-5);
    let train = set.parts().torque("drive", "sun", 80.0).load("carrier").build("sun", 400.0)?;
    let modes = Modes::mean_in_contact(&train)?;
    let kinds = train.kinds(&modes);
    let of_kind = |kind: ModeKind| {
        let all = modes.all().iter().zip(&kinds);
        all.filter(move |(mode, found)| **found == kind && mode.hertz() > 1.0).map(|(mode, _)| mode)
    };
    let chosen = of_kind(ModeKind::Rotational).take(2).map(|mode| (mode, "rotational"));
    let chosen = chosen.chain(of_kind(ModeKind::Translational).take(1).map(|mode| (mode, "translational")));
    let chosen = chosen.chain(of_kind(ModeKind::Planet).take(1).map(|mode| (mode, "planet mode")));
    let mut chosen: Vec<(&Mode, &str)> = chosen.collect();
    chosen.sort_by(|a, b| a.0.hertz().total_cmp(&b.0.hertz()));
    let panel = |(shape, kind): (&Mode, &str)| {
        let equal = |other: &&Mode| (other.hertz() / shape.hertz() - 1.0).abs() < 1e-6;
        let times = match modes.all().iter().filter(equal).count() {
            1 => "",
            _ => ", one of two",
        };
        Ok(mode(&train, shape.shape())?.title(format!("{:.0} Hz, {kind}{times}", shape.hertz())))
    };
    let panels = chosen.into_iter().map(panel).collect::<Outcome<Vec<_>>>()?;
    Ok(Picture::new(panels).columns(2).panel_size(350.0, 360.0))
}
