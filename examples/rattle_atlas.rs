//! Rattle atlas of a spur pair: teeth and quality grade in, the speed at which teeth part as a distribution over a
//! population of gearboxes out.
//!
//! Each gearbox has tooth-to-tooth deviations of its own, drawn within the grade (ISO 1328-1), and a half backlash of its
//! own. The table states, for each grade and torque, in which share of the gearboxes teeth part within the
//! range of speeds, and the median onset speed with its confidence interval. The pictures show the probability of rattle
//! over the speed and the onset over the torque with its 5 % to 95 % band; `atlas.csv` contains the onsets.
//!
//! `cargo run --release -p examples --example rattle_atlas`, with `-- --coarse` for fewer gearboxes and points; everything
//! is written to target/gallery/rattle_atlas/.

mod support;

use gear_dynamics::sweep::{Axis, Distribution, LaneRk4, Points, Proportion, RandomParameters, Row};
use gear_dynamics::teeth::{GearPair, InvoluteGear, PotentialEnergy, QualityGrade, ToothDeviations};
use gear_dynamics::trains::{Body, MeshPart, OfMesh, Parts, Train};
use gear_dynamics::{RattleState, Sweep, Wave};
use gear_dynamics_plots::{Mark, Panel, Picture};
use rand_distr::Uniform;
use support::{Outcome, coarse, csv_file, gallery, progress};

const SEED: u64 = 1328;
const GRADES: [u32; 3] = [4, 5, 6];
/// Torques [N m] and speeds [rad/s] of the atlas: between the resonances of order 100 (198 rad/s) and 50 (396 rad/s).
const TORQUES: [f64; 2] = [100.0, 600.0];
const SPEEDS: [f64; 2] = [230.0, 420.0];
/// Torque of the picture over the speed [N m].
const SHOWN: f64 = 300.0;
/// Share of the experiments in which a confidence interval contains the truth.
const LEVEL: f64 = 0.95;

/// The pair of the course, without an error of its mesh cycle: 50 teeth each, module 3 mm.
struct Teeth {
    gear: InvoluteGear,
    pair: GearPair,
    stiffness: Wave,
    backlash: RandomParameters,
}

impl Teeth {
    fn new() -> Outcome<Self> {
        let gear = InvoluteGear::external(50, 0.003)?.with_face_width(0.02)?;
        let pair = GearPair::new(&gear, &gear)?;
        let stiffness = Wave::new(PotentialEnergy::ma_2014([0.03; 2])?.wave(&pair)?.fourier_series(3)?);
        let backlash = RandomParameters::new(SEED).with("half backlash", Uniform::new(3e-5, 5e-5)?);
        Ok(Teeth { gear, pair, stiffness, backlash })
    }

    /// Gearbox `member` of the population of a grade.
    fn gearbox(&self, grade: QualityGrade, member: u64) -> Outcome<Train> {
        let deviations = |gear: u64| -> Outcome<Wave> {
            Ok(Wave::new(ToothDeviations::draw(&self.gear, grade, SEED, member, gear)?.wave()?))
        };
        let mesh = MeshPart::of_pair(&self.pair, self.stiffness.clone())
            .error_of_turn(OfMesh::Driver, deviations(0)?)
            .error_of_turn(OfMesh::Driven, deviations(1)?)
            .damping(2000.0)
            .half_backlash(self.backlash.sample(member)[0]);
        let body = || self.gear.blank(0.03, 7850.0).map(|blank| Body::new(blank.polar_inertia));
        let mut parts = Parts::new();
        parts.body("driver", body()?).body("driven", body()?);
        parts.mesh("mesh", "driver", "driven", mesh);
        Ok(parts.torque("drive", "driver", SHOWN).load("driven").build("driver", SPEEDS[0])?)
    }
}

/// The population of one grade.
struct Population {
    /// For each torque, from the least: the onset speeds of the gearboxes whose teeth part.
    onsets: Vec<Distribution>,
    /// For each speed at the torque [`SHOWN`]: the gearboxes whose teeth part.
    rattling: Vec<Proportion>,
}

pub(crate) fn main() -> Outcome<()> {
    let folder = gallery("rattle_atlas")?;
    let (members, torques, speeds) = if coarse() { (8, 3, 10) } else { (200, 11, 77) };
    let axes = vec![
        Axis::linear("drive", TORQUES[0], TORQUES[1], torques)?,
        Axis::linear("speed", SPEEDS[0], SPEEDS[1], speeds)?,
    ];
    let (torque_at, speed_at) = (axes[0].values().to_vec(), axes[1].values().to_vec());
    // A turn lasts some 25 times as long as a free vibration takes to decay.
    let sweep = Sweep::new(Points::grid(axes)?).settle(1).measure(1).rattle();
    let shown = torque_at.iter().position(|t| *t >= SHOWN).unwrap_or(0);
    let teeth = Teeth::new()?;
    let engine = LaneRk4::of_model(&teeth.gearbox(QualityGrade::new(6)?, 0)?)?;
    let mut csv = csv_file(folder.join("atlas.csv"), "grade,member,torque,onset_speed")?;
    let mut atlas = Vec::new();
    println!("{members} gearboxes per grade, intervals of {LEVEL}");
    println!("grade  torque  teeth part in            median onset");
    for grade in GRADES {
        let bar = progress(&format!("grade {grade}"), members as usize);
        let mut onsets = vec![Distribution::new(); torques];
        let mut hits = vec![0; speeds];
        for member in 0..members {
            let train = teeth.gearbox(QualityGrade::new(grade)?, member)?;
            let rows = sweep.over(&engine, &train)?.run()?;
            let parts = |row: &Row<'_>| row.contacts()[0].rattle_state() != RattleState::None;
            let parting = rows.iter().map(|row| parts(&row)).collect::<Vec<_>>();
            for (i, line) in parting.chunks(speeds).enumerate() {
                if let Some(onset) = line.iter().position(|parts| *parts).map(|j| speed_at[j]) {
                    onsets[i].add(onset);
                    csv.row(&[&grade, &member, &torque_at[i], &onset])?;
                }
                if i == shown {
                    line.iter().zip(&mut hits).for_each(|(parts, hits)| *hits += u64::from(*parts));
                }
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        for (torque, onsets) in torque_at.iter().zip(&onsets).filter(|(_, onsets)| onsets.count() > 0) {
            let share = Proportion::new(onsets.count(), members)?;
            let [low, high] = share.confidence(LEVEL)?.map(|p| 100.0 * p);
            let [from, to] = onsets.quantile_confidence(0.5, LEVEL)?;
            println!(
                "{grade:5}  {torque:4.0} N m {:5.1} % ({low:4.1} .. {high:5.1})  {:5.1} rad/s ({from:.1} .. {to:.1})",
                100.0 * share.share(),
                onsets.quantile(0.5)?,
            );
        }
        let rattling =
            hits.into_iter().map(|hits| Proportion::new(hits, members)).collect::<Result<_, _>>()?;
        atlas.push(Population { onsets, rattling });
    }
    csv.finish()?;

    let mut risk = Panel::new(
        format!("gearboxes whose teeth part at {:.0} N m", torque_at[shown]),
        "speed [rad/s]",
        "probability [1]",
    )?;
    let mut onset = Panel::new("onset of contact loss, 5 % to 95 %", "drive torque [N m]", "speed [rad/s]")?;
    for (grade, population) in GRADES.iter().zip(&atlas) {
        let name = format!("grade {grade}");
        let shares = || speed_at.iter().copied().zip(&population.rattling);
        let ends = shares()
            .map(|(speed, share)| Ok((speed, share.confidence(LEVEL)?)))
            .collect::<Outcome<Vec<_>>>()?;
        let low = ends.iter().map(|(speed, [low, _])| (*speed, *low));
        let high = ends.iter().rev().map(|(speed, [_, high])| (*speed, *high));
        risk = risk.series(&name, Mark::Area, low.chain(high))?;
        risk = risk.series(&name, Mark::Line, shares().map(|(speed, share)| (speed, share.share())))?;
        let known = || torque_at.iter().zip(&population.onsets).filter(|(_, onsets)| onsets.count() > 0);
        for p in [0.5, 0.05, 0.95] {
            let curve: Vec<_> =
                known().map(|(t, onsets)| Ok((*t, onsets.quantile(p)?))).collect::<Outcome<_>>()?;
            let mark = if p == 0.5 { Mark::Joined } else { Mark::Dashed };
            if !curve.is_empty() {
                onset = onset.series(&name, mark, curve)?;
            }
        }
    }
    Picture::new([risk, onset]).columns(2).save(folder.join("rattle_atlas.svg"))?;
    println!("pictures and tables: {}", folder.display());
    Ok(())
}
