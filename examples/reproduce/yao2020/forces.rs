//! Figs. 11-13 of Yao 2020: the mesh force with constant and random mesh damping, torque and clearance.

use super::super::report::{Kind, Report};
use super::super::support::{Outcome, coarse, progress};
use super::ring::{History, SETS, history, ring, solver, with_damping};
use gear_dynamics::analysis::Summary;
use gear_dynamics::drives::Noisy;
use gear_dynamics::models::ring::RingSet;
use gear_dynamics::processes::HeldProcess;
use gear_dynamics::{Integrator, Model, Periodic, State, Statistics};
use gear_dynamics_plots::{Mark, Panel};
use rand_distr::Uniform;
use rayon::prelude::*;

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
    let channels = ["mesh force 0", "stiffness times deflection 0"];
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

/// Draws of each random disturbance in a full run.
const DRAWS: u64 = 16;

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

    fn is_constant(&self) -> bool {
        matches!(self, Disturbance::Constant(_))
    }

    /// Number of draws: one of a constant, and one in a short run.
    fn draws(&self) -> u64 {
        if self.is_constant() || coarse() { 1 } else { DRAWS }
    }

    /// Runs the ring with the disturbance; random values are held for one mesh period.
    fn force(&self, set: &RingSet, seed: u64) -> Outcome<Force> {
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
            Disturbance::Damping(most) => force(&with_damping(bare, most, &share)?),
            Disturbance::Torque(part) => {
                let slot = bare.slot("motor torque")?;
                force(&Noisy::new(bare).add(&[(slot, part * set.motor_torque)], &both)?)
            }
            Disturbance::Clearance(part) => {
                let (mut held, gain) = (Noisy::new(bare), part * set.half_backlash);
                for mesh in 0..3 {
                    let [lower, upper] = held.bare().clearance_slots(mesh)?;
                    held = held.add(&[(lower, -gain), (upper, gain)], &both)?;
                }
                force(&held)
            }
        }
    }
}

/// Figs. 11-13 and conclusion 4.
pub fn figures(report: &mut Report) -> Outcome<()> {
    let c_g = RingSet::set_e(3, 1000.0).mesh_damping;
    let mut disturbances: Vec<Disturbance> =
        [0.0, 0.5, 1.0, 10.0, 100.0, c_g, 2.0 * c_g].map(Disturbance::Constant).into();
    disturbances.extend([1.0, c_g, 2.0 * c_g].map(Disturbance::Damping));
    disturbances.extend([
        Disturbance::Torque(0.1),
        Disturbance::Clearance(0.01),
        Disturbance::Clearance(0.1),
    ]);
    if coarse() {
        disturbances = disturbances.into_iter().step_by(5).collect();
    }
    let cases: Vec<(&str, RingSet, Disturbance)> =
        SETS.iter().flat_map(|(name, set)| disturbances.iter().map(|d| (*name, set(1000.0), *d))).collect();
    let runs: Vec<(usize, u64)> = cases
        .iter()
        .enumerate()
        .flat_map(|(i, (.., disturbance))| (0..disturbance.draws()).map(move |draw| (i, 2020 + draw)))
        .collect();
    let bar = progress("disturbances", runs.len());
    let forces: Result<Vec<Force>, String> = runs
        .par_iter()
        .map(|&(i, seed)| {
            let (name, set, disturbance) = &cases[i];
            let force = disturbance.force(set, seed);
            bar.inc(1);
            force.map_err(|e| format!("set {name}, {}, seed {seed}: {e}", disturbance.name()))
        })
        .collect();
    bar.finish_and_clear();
    let forces = forces?;
    report.csv(
        "ring_force.csv",
        "set,disturbance,seed,peak_early,peak_late,p2p_late,spring_early,spring_late",
        |csv| {
            for (&(i, seed), f) in runs.iter().zip(&forces) {
                let (name, _, disturbance) = &cases[i];
                let what = disturbance.name().replace(", ", " ");
                #[rustfmt::skip]
                csv.row(&[name, &what, &seed, &f.peak[0], &f.peak[1], &f.steady, &f.spring[0], &f.spring[1]])?;
            }
            Ok(())
        },
    );
    let rows = |constant: bool| -> Vec<Vec<String>> {
        let wanted = cases.iter().enumerate().filter(|(_, case)| case.2.is_constant() == constant);
        let row = |(i, (name, _, disturbance)): (usize, &(&str, RingSet, Disturbance))| {
            let mine = || runs.iter().zip(&forces).filter(move |(run, _)| run.0 == i).map(|(_, force)| force);
            // One value of a constant, the range of the draws of a random one.
            let cell = |of: fn(&Force) -> f64| {
                let [least, most] =
                    mine().map(of).fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
                if constant { format!("{least:.2}") } else { format!("{least:.1}..{most:.1}") }
            };
            vec![
                (*name).to_owned(),
                disturbance.name(),
                cell(|f| f.peak[0]),
                cell(|f| f.peak[1]),
                cell(|f| f.steady),
                cell(|f| f.spring[0]),
                cell(|f| f.spring[1]),
            ]
        };
        wanted.map(row).collect()
    };
    #[rustfmt::skip]
    let header = ["set", "disturbance", "largest W, t < 7 s [N]", "largest W, t > 7 s [N]",
        "peak-to-peak of W, t > 7 s [N]", "largest K d, t < 7 s [N]", "largest K d, t > 7 s [N]"];
    report.table("ring_force", Kind::Fixed, &header, &rows(true));
    report.table("ring_force_random", Kind::Full, &header, &rows(false));

    let bare = ring(&RingSet::set_e(3, 1000.0))?;
    let hold = bare.period(); // one mesh period
    let process = HeldProcess::new(hold, Uniform::new(0.0, 1.0)?)?.seed(2020);
    let noisy = |gain: f64| with_damping(bare.clone(), gain, &process);
    let (channels, end) = (["mesh force 0"], if coarse() { 1.0 } else { 8.0 });
    let drawn = |label: &str, (times, values): History| {
        let panel = Panel::new(format!("set E, {label}"), "time t [s]", "mesh force W1 [N]")?;
        panel.series("", Mark::Line, times.into_iter().zip(values[0].iter().copied()))
    };
    let constant = ring(&RingSet { mesh_damping: c_g + 0.5, ..RingSet::set_e(3, 1000.0) })?;
    let values = (0..400).map(|k| (f64::from(k), process.held(0, k as u64)));
    let held = Panel::new("Fig. 11: held values, first mesh", "number of the hold [1]", "C_D [N s/m]")?;
    let panels = [
        held.series("", Mark::Specks, values)?,
        drawn("C_D = 0", history(&bare, &channels, end, 1e-4)?)?,
        drawn("C_D = 0.5 N s/m", history(&constant, &channels, end, 1e-4)?)?,
        drawn("C_D = U(0,1) N s/m", history(&noisy(1.0)?, &channels, end, 1e-4)?)?,
        drawn("C_D = U(0,1) C_g", history(&noisy(c_g)?, &channels, end, 1e-4)?)?,
    ];
    report.picture("fig11_13_mesh_force.svg", 2, panels);
    Ok(())
}
