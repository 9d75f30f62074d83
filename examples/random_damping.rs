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

use gear_dynamics::drives::Noisy;
use gear_dynamics::excitation::Side;
use gear_dynamics::models::ring::RingSet;
use gear_dynamics::processes::{HeldProcess, Process};
use gear_dynamics::sweep::{Ensemble, MeanAfter};
use gear_dynamics::{Dop853, Model, ParameterError, Ring, State};
use gear_dynamics_plots::{Mark, Panel, Picture, band};
use rand_distr::Uniform;
use support::{Outcome, csv_file, gallery};

const MEMBERS: u64 = 1000;
/// End of the runs in seconds, and number of equal spans between the times of the bands.
const END: f64 = 0.02;
const SPANS: usize = 1000;
/// Maximum random damping [N s/m], added to 1070 N s/m of the meshes. Its values are held for one mesh
/// period.
const SCALE: f64 = 1000.0;

fn process(set: &RingSet, member: u64) -> Result<HeldProcess, ParameterError> {
    let hold = std::f64::consts::TAU / set.omega();
    Ok(HeldProcess::new(hold, Uniform::new(0.0, 1.0).expect("0 < 1"))?.seed(2020).member(member))
}

pub(crate) fn main() -> Outcome<()> {
    let folder = gallery("random_damping")?;
    let set = RingSet { motor_torque: 6.0, ..RingSet::set_a(3, 3000.0) };
    let ring = Ring::as_printed(&set.params()?)?;
    let family = |member: u64| -> Result<(Noisy<Ring>, State), ParameterError> {
        let (mut noisy, process) = (Noisy::new(ring.clone()), process(&set, member)?);
        for mesh in 0..3 {
            let slot = ring.slot(&format!("mesh damping {mesh}"))?;
            noisy = noisy.add(&[(slot, SCALE)], &process)?;
        }
        Ok((noisy, State::at_rest(ring.dof())))
    };
    let (force, error) = ("mesh force 0", "transmission error 0");
    let ensemble = Ensemble::new(MEMBERS, END, SPANS)?.channels(&[force, error]).peaks(&[force]).rattle();
    let bands = ensemble.run(&Dop853::new().rtol(1e-7).atol(1e-11), family)?;

    let peak = bands.peak(force)?;
    let [low, high] = peak.confidence(0.95)?;
    println!("{} members, {} failed", bands.members(), bands.failed());
    println!(
        "maximum mesh force: mean {:.2} N ({low:.2} .. {high:.2}), 5% .. 95% {:.1} .. {:.1} N",
        peak.mean(),
        peak.quantile(0.05)?,
        peak.quantile(0.95)?
    );
    if let Some(impacts) = bands.impacts(0) {
        println!("impacts of mesh 1: mean {:.2}, {} .. {}", impacts.mean(), impacts.min(), impacts.max());
    }
    for MeanAfter { members, mean, standard_error: error } in bands.convergence(force)? {
        println!("  after {members:4} members: {mean:8.3} +- {error:.3} N");
    }

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
    let held = process(&set, 0)?;
    let mut damping = Panel::new("held values of member 0", "time t [s]", "random mesh damping [N s/m]")?;
    for mesh in 0..3 {
        let path = held.path(mesh);
        let value = |i: u32| {
            let t = END * f64::from(i) / 4000.0;
            (t, SCALE * path.at(t, Side::After))
        };
        damping = damping.series(&format!("mesh {mesh}"), Mark::Line, (0..=4000).map(value))?;
    }
    let counts = peak.histogram(40)?.into_iter().map(|span| (span.middle, span.count as f64));
    let panels = [
        band(&bands, "mesh force 0 [N]", [0.05, 0.95])?.title("mesh force 0"),
        band(&bands, "transmission error 0 [m]", [0.05, 0.95])?.title("transmission error 0"),
        damping,
        Panel::new("members by their maximum", "maximum mesh force 0 [N]", "members [1]")?.series(
            "",
            Mark::Bars,
            counts,
        )?,
    ];
    Picture::new(panels).columns(2).save(folder.join("random_damping.svg"))?;
    println!("pictures and tables: {}", folder.display());
    Ok(())
}
