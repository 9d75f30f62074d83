//! Random mesh damping in the closed-loop ring of Yao 2020: an ensemble of 1000 members, with values that are
//! held for one mesh period as in Fig. 11.
//!
//! The table states the distribution of the maximum mesh force, the impacts, and the convergence of the mean
//! with the number of members. The pictures show mean and 5 % to 95 % band of the mesh force and of the
//! transmission error over time, the held values of one member, and the histogram of the maximum force;
//! `bands.csv` contains the bands of the force.
//!
//! `cargo run --release -p examples --example random_damping`; everything is written to
//! target/gallery/random_damping/.

mod support;

use gear_dynamics::drives::{Held, HeldProcess};
use gear_dynamics::excitation::Side;
use gear_dynamics::models::ring::RingSet;
use gear_dynamics::sweep::Ensemble;
use gear_dynamics::{Dop853, Model, Ring, State};
use rand_distr::Uniform;
use support::{Mark, Outcome, Panel, csv_file, figure, gallery};

const MEMBERS: u64 = 1000;
/// End of the runs in seconds, and number of equal spans between the times of the bands.
const END: f64 = 0.02;
const SPANS: usize = 400;
/// Maximum random damping [N s/m], added to 1070 N s/m of the meshes. Its values are held for one mesh
/// period.
const SCALE: f64 = 1000.0;

fn process(set: &RingSet, member: u64) -> Result<HeldProcess, Box<dyn std::error::Error>> {
    let hold = std::f64::consts::TAU / set.omega();
    Ok(HeldProcess::new(hold, Uniform::new(0.0, 1.0)?)?.seed(2020).member(member))
}

fn main() -> Outcome<()> {
    let folder = gallery("random_damping")?;
    let set = RingSet { motor_torque: 6.0, ..RingSet::set_a(3, 3000.0) };
    let ring = Ring::as_printed(&set.params()?)?;
    let slots =
        (0..3).map(|mesh| ring.slot(&format!("mesh damping {mesh}"))).collect::<Result<Vec<_>, _>>()?;
    let family = |member: u64| -> Result<(Held<Ring>, State), String> {
        let noisy = Held::new(ring.clone()).per_slot(
            &slots,
            SCALE,
            process(&set, member).map_err(|e| e.to_string())?,
        );
        Ok((noisy.map_err(|e| e.to_string())?, State::at_rest(ring.dof())))
    };
    let (force, error) = ("mesh force 0", "transmission error 0");
    let ensemble = Ensemble::new(MEMBERS, END, SPANS)?.channels(&[force, error]).peaks(&[force]).rattle();
    let bands = ensemble.run(&Dop853::new().rtol(1e-7).atol(1e-11), family)?;

    let peak = bands.peak(force)?;
    let [low, high] = peak.confidence(1.96);
    println!("{} members, {} failed", bands.members(), bands.failed().0);
    println!(
        "maximum mesh force: mean {:.2} N ({low:.2} .. {high:.2}), 5% .. 95% {:.1} .. {:.1} N",
        peak.mean(),
        peak.quantile(0.05)?,
        peak.quantile(0.95)?
    );
    if let Some(impacts) = bands.impacts(0) {
        println!("impacts of mesh 1: mean {:.2}, {} .. {}", impacts.mean(), impacts.min(), impacts.max());
    }
    for (members, mean, error) in bands.convergence(force)? {
        println!("  after {members:4} members: {mean:8.3} +- {error:.3} N");
    }

    let times: Vec<f64> = bands.times().iter().map(|t| 1e3 * t).collect();
    let curve = |values: Vec<f64>| times.iter().copied().zip(values).collect::<Vec<_>>();
    let mut csv = csv_file(folder.join("bands.csv"), "t,mean,q05,q50,q95,min,max")?;
    for (i, t) in bands.times().iter().enumerate() {
        let at = bands.at(force, i)?;
        csv.row(&[
            t,
            &at.mean(),
            &at.quantile(0.05)?,
            &at.quantile(0.5)?,
            &at.quantile(0.95)?,
            &at.min(),
            &at.max(),
        ])?;
    }
    let banded = |title: &str, channel: &str, unit: &str| -> Outcome<Panel> {
        let (mut outline, mut back) = (curve(bands.band(channel, 0.05)?), curve(bands.band(channel, 0.95)?));
        back.reverse();
        outline.append(&mut back);
        let mean = curve(bands.mean(channel)?);
        Ok(Panel::new(title, "t [ms]", unit).headroom(0.15).with("mean", Mark::Line, mean).with(
            "5% .. 95%",
            Mark::Area,
            outline,
        ))
    };
    let held = process(&set, 0)?;
    let values = (0..3).map(|mesh| {
        let samples = 2000;
        let at = |i: usize| END * i as f64 / samples as f64;
        (
            mesh,
            (0..samples)
                .map(|i| (1e3 * at(i), SCALE * held.value(at(i), Side::After, mesh)))
                .collect::<Vec<_>>(),
        )
    });
    let mut values_panel =
        Panel::new("random damping of member 0, by mesh", "t [ms]", "[N s/m]").headroom(0.35);
    for (mesh, points) in values {
        values_panel = values_panel.with(format!("mesh {mesh}"), Mark::Line, points);
    }
    let counts = peak.histogram(40)?.into_iter().map(|(x, n)| (x, n as f64)).collect();
    let panels = [
        banded(&format!("mesh force 0 over {MEMBERS} members"), force, "[N]")?,
        banded("transmission error of mesh 0", error, "[m]")?,
        values_panel,
        Panel::new("maximum mesh force of a run", "[N]", "members").with("", Mark::Bars, counts),
    ];
    figure(folder.join("random_damping.svg"), 2, &panels)?;
    println!("pictures and tables: {}", folder.display());
    Ok(())
}
