//! Gear trains from teeth to rattle: a two-stage train, and planetary sets with sequential and in-phase planets.
//!
//! Geometry and mesh stiffness of involute pairs, natural frequencies and modes with their kinds, the Campbell diagram,
//! and maps of rattle over speed and load in lanes. `modes.csv` lists the modes of these trains and of the published
//! planetary sets of Lin and Parker 1999, Cooley and Parker 2012 and Kahraman 1994.
//!
//! `cargo run --release -p examples --example gear_train`; everything is written to
//! target/gallery/gear_train/.

#[path = "gear_train/published.rs"]
mod published;
mod support;

use gear_dynamics::linear::{Campbell, Modes};
use gear_dynamics::sweep::{Axis, LaneRk4, Points, Row, Watch};
use gear_dynamics::teeth::{GearPair, InvoluteGear, MethodB, PotentialEnergy, TransmissionError};
use gear_dynamics::trains::{
    Body, Members, MeshPart, ModeKind, Parts, Planetary, ShaftPart, Train, two_stage,
};
use gear_dynamics::{Model, ParameterError, Periodic, Sweep, Wave};
use gear_dynamics_plots::{Panel, Picture, campbell, map, mode};
use std::f64::consts::TAU;
use std::time::Instant;
use support::{Csv, Outcome, coarse, csv_file, gallery, progress};

/// The involute pairs of both stages: spur gears of 20 mm width.
fn stages() -> Outcome<[GearPair; 2]> {
    let pair = |teeth: [u32; 2], module: f64| -> Outcome<GearPair> {
        let [a, b] = teeth.map(|z| InvoluteGear::external(z, module)?.with_face_width(0.02));
        Ok(GearPair::new(&a?, &b?)?)
    };
    Ok([pair([25, 50], 2.5e-3)?, pair([24, 60], 3e-3)?])
}

/// The stiffness of a pair over the mesh cycle, as a series of six harmonics.
fn stiffness(pair: &GearPair) -> Outcome<Wave> {
    Ok(Wave::new(PotentialEnergy::tian_2004().wave(pair)?.fourier_series(6)?))
}

/// Motor, two stages and load.
fn two_stages(pairs: &[GearPair; 2]) -> Outcome<Parts> {
    let inertia = |stage: usize, gear: usize| {
        pairs[stage].gears()[gear].blank(0.0, 7850.0).map(|blank| blank.polar_inertia)
    };
    let inertias = [inertia(0, 0)?, inertia(0, 1)?, inertia(1, 0)?, inertia(1, 1)?];
    let mesh = |i: usize| -> Outcome<MeshPart> {
        let error = TransmissionError::of_harmonics(&[[1e-6, 0.0]])?.tooth().clone();
        let mesh = MeshPart::of_pair(&pairs[i], stiffness(&pairs[i])?).error(Wave::new(error));
        Ok(mesh.damping(1500.0).half_backlash(4e-5))
    };
    let mut parts = two_stage(inertias, ShaftPart::new(2e4).damping(1.0), [mesh(0)?, mesh(1)?]);
    parts.body("motor", Body::new(5e-3)).body("load", Body::new(0.1));
    parts.shaft("input shaft", "motor", "pinion 1", ShaftPart::new(2e4).damping(1.0)).shaft(
        "output shaft",
        "wheel 2",
        "load",
        ShaftPart::new(8e4).damping(5.0),
    );
    parts.torque("drive torque", "motor", 10.0).load("load");
    Ok(parts)
}

/// A planetary set whose ring is locked. Sequential planets: 31 teeth on three planets; in phase: 30 teeth.
fn planetary(teeth: [u32; 3]) -> Outcome<Parts> {
    let wave = |a: f64| -> Result<Wave, ParameterError> {
        Ok(Wave::new(gear_dynamics::excitation::Fourier::new(3e8, &[[a, 0.0], [0.3 * a, 0.0]])?))
    };
    let [sun, planet, ring] = teeth;
    let members = Members {
        sun: (sun, Body::new(8e-4)),
        planet: (planet, Body::new(7e-4)),
        ring: (ring, Body::new(5e-2).locked()),
        carrier: Body::new(6e-2),
    };
    let set = Planetary::new(3, 0.04, members, [wave(6e7)?, wave(4e7)?])?;
    let error =
        || Ok::<_, ParameterError>(Wave::new(gear_dynamics::excitation::Fourier::new(0.0, &[[0.0, 1e-6]])?));
    let set = set.error([error()?, error()?]).damping(700.0).half_backlash(3e-5);
    let mut parts = set.parts();
    parts.torque("drive torque", "sun", 80.0).load("carrier");
    Ok(parts)
}

/// Writes the modes of a train, one line for each distinct frequency, and prints them.
fn modes(csv: &mut Csv, name: &str, train: &Train) -> Outcome<()> {
    let modes = Modes::mean_in_contact(train)?;
    let kinds = train.kinds(&modes);
    let (hertz, mut next) = (modes.hertz(), 0);
    println!("\n{name}: {} coordinates, {} rigid", train.dof(), modes.rigid_count());
    while next < hertz.len() {
        let near = |other: f64| (other - hertz[next]).abs() <= 1e-7 * hertz[next];
        let of = |kind: ModeKind| {
            (next..hertz.len()).take_while(|&i| near(hertz[i])).filter(|&i| kinds[i] == kind).count()
        };
        let counts = [ModeKind::Rotational, ModeKind::Translational, ModeKind::Planet, ModeKind::Mixed]
            .map(|kind| (kind, of(kind)));
        for (kind, count) in counts.into_iter().filter(|(_, count)| *count > 0) {
            let kind = format!("{kind:?}").to_lowercase();
            csv.row(&[&name, &kind, &count, &hertz[next]])?;
            println!("{:16.6} Hz  {count} x {kind}", hertz[next]);
        }
        next += counts.iter().map(|count| count.1).sum::<usize>();
    }
    Ok(())
}

/// Rattle over speed and torque in lanes: the largest contact loss of all meshes, and the deflection of the first one.
fn rattle_map(
    name: &str,
    train: &Train,
    speeds: [f64; 2],
    side: usize,
    periods: usize,
) -> Outcome<[Panel; 2]> {
    let drive = train.constant("drive torque")?;
    let axes = vec![
        Axis::linear("speed", speeds[0], speeds[1], side)?,
        Axis::linear("drive torque", 0.1 * drive, 3.0 * drive, side)?,
    ];
    let engine = LaneRk4::of_model(&train.with("speed", speeds[0])?)?;
    let sweep = Sweep::new(Points::grid(axes)?)
        .periodic_tolerance(5e-3)
        .settle(periods)
        .measure(periods / 2)
        .channels(&["deflection 0"])
        .rattle();
    let bar = progress(name, side * side);
    let advance = |done: usize, _: usize| bar.set_position(done as u64);
    let began = Instant::now();
    let rows = sweep.over(&engine, train)?.watch(Watch::new().progress(advance)).run()?;
    bar.finish_and_clear();
    let loss =
        |row: &Row<'_>| row.contacts().iter().map(|contact| contact.loss_fraction()).fold(0.0, f64::max);
    let lost = rows.iter().filter(|row| loss(row) > 0.0).count();
    println!(
        "{name}: {} points in {:.1} s, {} errors; contact is lost in {:.1} % of them",
        side * side,
        began.elapsed().as_secs_f64(),
        rows.errors().len(),
        100.0 * lost as f64 / (side * side) as f64
    );
    if let Some((point, error)) = rows.errors().first_key_value() {
        println!("  point {point}: {error}");
    }
    let axes = ["speed [rad/s]", "drive torque [N m]"];
    let swing = |row: &Row<'_>| row.channel("deflection 0").map_or(f64::NAN, |x| x.peak_to_peak());
    Ok([
        map(&rows, axes, "contact loss, share of the time [1]", loss)?.title(format!("{name}, worst mesh")),
        map(&rows, axes, "peak-to-peak deflection [m]", swing)?.title(format!("{name}, first mesh")),
    ])
}

/// The stiffness of both pairs over two mesh cycles.
fn stiffness_panel(pairs: &[GearPair; 2]) -> Outcome<Panel> {
    let exact = |i: usize| PotentialEnergy::tian_2004().wave(&pairs[i]).map(Wave::new);
    let [first, second] = [exact(0)?, exact(1)?];
    let series = [stiffness(&pairs[0])?, stiffness(&pairs[1])?];
    let waves = [
        ("stage 1", &first),
        ("stage 1, six harmonics", &series[0]),
        ("stage 2", &second),
        ("stage 2, six harmonics", &series[1]),
    ];
    let panel = gear_dynamics_plots::stiffness(&waves, "mesh stiffness k [N/m]", 2.0)?;
    Ok(panel.title("mesh stiffness by potential energy"))
}

/// The first two elastic modes of a train as its gears turn and move.
fn modes_panels(name: &str, train: &Train) -> Outcome<Vec<Panel>> {
    let modes = Modes::mean_in_contact(train)?;
    let elastic = modes.all().iter().skip(modes.rigid_count()).take(2);
    elastic.map(|one| Ok(mode(train, one.shape())?.title(format!("{name}, {:.0} Hz", one.hertz())))).collect()
}

/// Natural frequencies over the speed, with the mesh orders; prints the resonances.
fn campbell_panel(train: &Train, orders: &[(f64, &str)], fastest: f64) -> Outcome<Panel> {
    let speeds: Vec<f64> = (1..=40).map(|i| fastest * f64::from(i) / 40.0).collect();
    let multiples: Vec<f64> = orders.iter().map(|order| order.0).collect();
    let diagram = Campbell::of(train, &speeds, &multiples)?;
    println!("\nspeeds of resonance [rad/s]");
    for meeting in diagram.resonances() {
        let hertz = meeting.frequency / TAU;
        println!("{:8.1}  order {:5.1} meets {hertz:7.0} Hz", meeting.speed, meeting.order);
    }
    Ok(campbell(&diagram, "motor speed [rad/s]", orders)?.title("two-stage train").y_range(0.0, 1500.0)?)
}

fn geometry(pairs: &[GearPair; 2]) -> Outcome<()> {
    println!("stage  teeth   a [mm]  contact ratio  mean stiffness [N/μm]  ISO 6336 method B");
    for (i, pair) in pairs.iter().enumerate() {
        let [a, b] = pair.gears();
        println!(
            "{:5}  {}/{}  {:7.2}  {:13.4}  {:21.1}  {:17.1}",
            i + 1,
            a.teeth(),
            b.teeth(),
            1e3 * pair.centre_distance(),
            pair.contact_ratio(),
            1e-6 * PotentialEnergy::tian_2004().wave(pair)?.mean(),
            1e-6 * MethodB::new().stiffness(pair)?.mean_stiffness,
        );
    }
    Ok(())
}

pub(crate) fn main() -> Outcome<()> {
    let folder = gallery("gear_train")?;
    let pairs = stages()?;
    geometry(&pairs)?;
    let two = two_stages(&pairs)?.build("motor", 200.0)?;
    let sequential = planetary([31, 29, 89])?.build("sun", 200.0)?;
    let in_phase = planetary([30, 30, 90])?.build("sun", 200.0)?;

    let mut csv = csv_file(folder.join("modes.csv"), "model,kind,multiplicity,frequency_hz")?;
    for (name, train) in published::sets()? {
        modes(&mut csv, &name, &train)?;
    }
    modes(&mut csv, "two_stage", &two)?;
    modes(&mut csv, "planetary_sequential", &sequential)?;
    modes(&mut csv, "planetary_in_phase", &in_phase)?;
    csv.finish()?;

    let orders = [(12.0, "mesh 2"), (25.0, "mesh 1"), (50.0, "2 × mesh 1")];
    let panels = [stiffness_panel(&pairs)?, campbell_panel(&two, &orders, 800.0)?];
    Picture::new(panels).columns(2).save(folder.join("train.svg"))?;
    let panels = [modes_panels("two stages", &two)?, modes_panels("sequential planets", &sequential)?];
    Picture::new(panels.concat()).columns(2).panel_size(440.0, 360.0).save(folder.join("modes.svg"))?;

    println!();
    let side = if coarse() { 12 } else { 100 };
    let trains = [
        ("two stages", two, [250.0, 2500.0], 10),
        ("sequential planets", sequential, [300.0, 2500.0], 100),
        ("planets in phase", in_phase, [300.0, 2500.0], 100),
    ];
    let mut all = Vec::new();
    for (name, train, speeds, periods) in &trains {
        println!("{name}: period {:.4} s at {} rad/s", train.period(), train.constant("speed")?);
        all.extend(rattle_map(name, train, *speeds, side, *periods)?);
    }
    Ok(Picture::new(all).columns(2).save(folder.join("rattle.svg"))?)
}
