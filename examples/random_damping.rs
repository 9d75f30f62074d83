//! Random mesh damping in the closed-loop ring of Yao 2020: values that are held for one mesh period, as in
//! Fig. 11, and what they tend to if they change faster.
//!
//! First the paper: the distribution of the maximum mesh force over 1000 members, the impacts, and the
//! convergence of the mean. The pictures show mean and 5 % to 95 % band of the mesh force and of the
//! transmission error over time, the held values of one member, and the histogram of the maximum force;
//! `bands.csv` contains the bands of the force.
//!
//! Then a table, `laws.csv`, of other laws with the same intensity D = s² h (variance s², hold time h): an
//! Ornstein-Uhlenbeck process of the correlation time τ with D = 2 σ² τ, and its limit, white noise. C + √D ξ
//! multiplies a velocity: the limit is the equation of Stratonovich. In the sense of Ito the same numbers
//! mean a damping that is larger by D/2m, m the reduced mass of the mesh. The mean square stays finite for D
//! < C m (Stratonovich) or D < 2 C m (Ito), a mesh by itself.
//!
//! A reader learns: the law of a random damping takes a correlation time, not a distribution alone. And:
//! white noise on a damping needs a statement, since both senses differ by a mean damping.
//!
//! `cargo run --release -p examples --example random_damping`, with `-- --coarse` for fewer members;
//! everything is written to target/gallery/random_damping/.

mod support;

use gear_dynamics::drives::Noisy;
use gear_dynamics::excitation::Side;
use gear_dynamics::models::ring::RingSet;
use gear_dynamics::processes::{HeldProcess, OrnsteinUhlenbeck, Process};
use gear_dynamics::random::{LongRun, NoisySteps, WhiteNoise};
use gear_dynamics::sweep::{Bands, Distribution, Ensemble, MeanAfter};
use gear_dynamics::{Dop853, Model, ParameterError, Periodic, Ring, State};
use gear_dynamics_plots::{Mark, Panel, Picture, band};
use rand_distr::Uniform;
use support::{Csv, Outcome, coarse, csv_file, gallery};

/// End of the runs in seconds, and number of equal spans between the times of the bands.
const END: f64 = 0.02;
const SPANS: usize = 1000;
/// Maximum random damping [N s/m], added to 1070 N s/m of the meshes.
const SCALE: f64 = 1000.0;
const DEFLECTION: &str = "deflection 0";
/// Half backlash b of the ring [m].
const HALF_BACKLASH: f64 = 2.65e-5;
const SEED: u64 = 2020;
/// Steps of the white noise in a mesh period: 40 in a free vibration of a mesh.
const STEPS: usize = 120;

/// Values that are uniform on (0, 1) and held for one mesh period.
fn held(set: &RingSet, member: u64) -> Result<HeldProcess, ParameterError> {
    let uniform = Uniform::new(0.0, 1.0).expect("0 < 1");
    Ok(HeldProcess::new(std::f64::consts::TAU / set.omega(), uniform)?.seed(SEED).member(member))
}

/// The ring with SCALE × a path of its own on the damping of each mesh, at rest.
fn noisy(ring: &Ring, process: &dyn Process) -> Result<(Noisy<Ring>, State), ParameterError> {
    let add = |noisy: Noisy<Ring>, mesh| {
        noisy.add(&[(ring.slot(&format!("mesh damping {mesh}"))?, SCALE)], process)
    };
    Ok(((0..3).try_fold(Noisy::new(ring.clone()), add)?, State::at_rest(ring.dof())))
}

/// A row of the table: how deep the teeth press at most, d - b with d the largest deflection of a run, and the
/// impacts.
fn print_law(csv: &mut Csv, name: &str, largest: &Distribution, impacts: f64) -> Outcome<()> {
    let depths = [largest.mean(), largest.quantile(0.05)?, largest.quantile(0.95)?];
    let [mean, low, high] = depths.map(|d| 1e6 * (d - HALF_BACKLASH));
    let error = 1e6 * largest.standard_error();
    println!("{name:34} {mean:.3} ± {error:.3}   {low:.2} .. {high:.2}   {impacts:.1}");
    Ok(csv.row(&[&name, &mean, &error, &low, &high, &impacts])?)
}

pub(crate) fn main() -> Outcome<()> {
    let folder = gallery("random_damping")?;
    let members = if coarse() { 50 } else { 1000 };
    let set = RingSet { motor_torque: 6.0, half_backlash: HALF_BACKLASH, ..RingSet::set_a(3, 3000.0) };
    let ring = Ring::as_printed(&set.params()?)?;
    let solver = Dop853::new().rtol(1e-7).atol(1e-11);
    let family = |member: u64| noisy(&ring, &held(&set, member)?);
    let (force, error) = ("mesh force 0", "transmission error 0");
    let ensemble = Ensemble::new(members, END, SPANS)?.channels(&[force, error]).rattle();
    let bands = ensemble.peaks(&[force, DEFLECTION]).run(&solver, family)?;

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
    for MeanAfter { members, mean, standard_error: error, .. } in bands.convergence(force)? {
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
    let values = held(&set, 0)?;
    let mut damping = Panel::new("held values of member 0", "time t [s]", "random mesh damping [N s/m]")?;
    for mesh in 0..3 {
        let path = values.path(mesh);
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

    // The mean damping as a constant, and laws of the same intensity around it.
    let mean =
        Ring::as_printed(&RingSet { mesh_damping: set.mesh_damping + 0.5 * SCALE, ..set.clone() }.params()?)?;
    let (hold, variance) = (ring.period(), 1.0 / 12.0);
    let intensity = variance * hold; // of the process of unit range [s]
    let ensemble = || Ensemble::new(members, END, 1).map(|all| all.peaks(&[DEFLECTION]).rattle());
    let mut csv = csv_file(folder.join("laws.csv"), "law,depth_um,standard_error,q05,q95,impacts")?;
    println!("\n{:34} depth [μm]      5 % .. 95 %    impacts", "law of the damping, mesh 0");
    let constant = ensemble()?.run(&solver, |_| noisy(&mean, &OrnsteinUhlenbeck::new(0.0, hold, hold)?))?;
    let impacts = |bands: &Bands| bands.impacts(0).map_or(f64::NAN, Distribution::mean);
    print_law(&mut csv, "constant: the mean", constant.peak(DEFLECTION)?, impacts(&constant))?;
    print_law(&mut csv, "held for one mesh period", bands.peak(DEFLECTION)?, impacts(&bands))?;
    for share in [0.5, 0.05] {
        let tau = share * hold;
        let process = OrnsteinUhlenbeck::new((intensity / (2.0 * tau)).sqrt(), tau, 0.1 * tau)?.seed(SEED);
        let coloured = ensemble()?.run(&solver, |member| noisy(&mean, &process.clone().member(member)))?;
        let name = format!("Ornstein-Uhlenbeck, τ = {:.3} ms", 1e3 * tau);
        print_law(&mut csv, &name, coloured.peak(DEFLECTION)?, impacts(&coloured))?;
    }
    // Reduced mass m of a mesh [kg], and D in the equation of one mesh over its bound C m.
    let mass = set.gear_inertia / (2.0 * set.base_radius.powi(2));
    let ito = SCALE * SCALE * intensity / (2.0 * mass);
    for (name, added) in [("white noise, Stratonovich", 0.0), ("white noise, Ito", ito)] {
        let damping = set.mesh_damping + 0.5 * SCALE + added;
        let ring = Ring::as_printed(&RingSet { mesh_damping: damping, ..set.clone() }.params()?)?;
        let noise = [0, 1, 2].map(|mesh| {
            WhiteNoise::drives(&[(ring.slot(&format!("mesh damping {mesh}"))?, SCALE)], intensity)
        });
        let noise = noise.into_iter().collect::<Result<Vec<_>, _>>()?;
        let long = LongRun::new(0.0, END / ring.period())?.members(members as usize);
        let long = long.channels(&[DEFLECTION]);
        let seen =
            long.run(&NoisySteps::new(STEPS, &noise).seed(SEED), &ring, &State::at_rest(ring.dof()))?;
        let rate: f64 = seen.contact(0)?.impacts.iter().map(|rate| rate.mean()).sum();
        print_law(&mut csv, name, seen.largest(DEFLECTION)?, rate * END)?;
    }
    csv.finish()?;
    println!("mean square finite for D < C m: D/(C m) = {:.3}", 2.0 * ito / (set.mesh_damping + 0.5 * SCALE));
    println!("pictures and tables: {}", folder.display());
    Ok(())
}
