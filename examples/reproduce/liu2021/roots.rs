//! What the balance P leaves open: its roots at one speed, and its limits over the load.

use super::super::report::{Kind, Report};
use super::super::support::{Outcome, coarse};
use super::motions::{MESH, Point, broyden, pair, paper, paper_point, solver};
use gear_dynamics::contact::Piece;
use gear_dynamics::periodic::{FourierOrbit, Integrals};
use gear_dynamics::processes::HeldProcess;
use gear_dynamics::{Balance, Harmonics, Integrator, NfgPair, NfgParams, Periodic, RattleState};
use rand_distr::Uniform;
use rayon::prelude::*;

/// The roots of the balance P at some speeds.
pub fn roots(report: &mut Report, speeds: &[f64]) -> Outcome<()> {
    let rows = speeds.iter().map(|speed| roots_at(*speed)).collect::<Outcome<Vec<_>>>()?.concat();
    let header = ["speed", "starts", "roots", "state", "ppv of q", "ppv of f(q)"];
    report.table("roots_of_p", Kind::Full, &header, &rows);
    Ok(())
}

/// The roots of the balance P at one speed, found from many starts: turns of runs in time at this and higher
/// speeds projected on the 15 unknowns; random coefficients within half the gap; random motions about the drive
/// flank, whose coefficients extend over three decades; and random changes of the roots already found. A root
/// counts if Newton's method, started from it, remains there.
fn roots_at(speed: f64) -> Outcome<Vec<Vec<String>>> {
    const TURNS: usize = 6;
    let (in_gap, about_flank, shifted): (u64, u64, u64) =
        if coarse() { (10, 10, 2) } else { (600, 3000, 40) };
    let starts_drawn = in_gap + about_flank;
    let pair = pair_at(speed)?;
    let (newton, broyden) = (paper()?, broyden()?);
    let orbit_of =
        |coefficients: Vec<f64>| FourierOrbit::new(newton.harmonics(), pair.period(), &[coefficients]);
    let mut starts = Vec::new();
    for other in [0.0, 10.0, 20.0, 30.0, 40.0, 50.0].map(|more| pair_at(speed + more)) {
        let other = other?;
        let mut state = other.on_drive_flank()?;
        for _ in 0..TURNS {
            let seen = FourierOrbit::project(&solver(), &other, &state, newton.harmonics())?;
            starts.push(orbit_of(seen.coefficients(0).to_vec())?);
            state = solver().end(&other, &state, state.t + other.period())?;
        }
    }
    let draws = HeldProcess::new(1.0, Uniform::new(-1.0, 1.0)?)?.seed(2021);
    let b = pair.half_backlash_angle();
    for k in 0..starts_drawn {
        let drawn = (0..newton.harmonics().unknowns() as u64).map(|i| {
            let share = draws.held(i, k);
            match (k < in_gap, i) {
                (true, _) => b * share,
                (false, 0) => b * (-1.0 + 0.5 * share),
                (false, _) => b * share * 10f64.powf(-1.5 * (1.0 + draws.held(100 + i, k))),
            }
        });
        starts.push(orbit_of(drawn.collect())?);
    }
    let solved = |start: &FourierOrbit| {
        [&newton, &broyden].into_iter().filter_map(|way| way.solve(&pair, start).ok()).collect()
    };
    let (mut roots, mut count): (Vec<(Point, FourierOrbit)>, usize) = (Vec::new(), 0);
    // New roots give further starts, until no root is new.
    while !starts.is_empty() {
        count += starts.len();
        let found: Vec<Vec<FourierOrbit>> = starts.par_iter().map(solved).collect();
        starts.clear();
        for orbit in found.into_iter().flatten() {
            if roots.iter().any(|(_, known)| known.distance(&orbit) < 1e-3)
                || !newton.solve(&pair, &orbit).is_ok_and(|again| again.distance(&orbit) < 1e-6)
            {
                continue;
            }
            for k in 0..shifted {
                let k = starts_drawn + shifted * roots.len() as u64 + k;
                let changed = orbit
                    .coefficients(0)
                    .iter()
                    .enumerate()
                    .map(|(i, c)| c * (1.0 + 0.5 * draws.held(i as u64, k)));
                starts.push(orbit_of(changed.collect())?);
            }
            roots.push((paper_point(&pair, &orbit)?, orbit));
        }
    }
    let mut rows = Vec::new();
    for wanted in [RattleState::None, RattleState::Unilateral, RattleState::Bilateral] {
        let of = |value: fn(&Point) -> f64| {
            let values = roots.iter().filter(|r| r.0.state == wanted).map(|r| value(&r.0));
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], x| [lo.min(x), hi.max(x)])
        };
        let number = roots.iter().filter(|r| r.0.state == wanted).count();
        if number > 0 {
            let ([q0, q1], [f0, f1]) = (of(|p| p.ppv), of(|p| p.elastic));
            rows.push(vec![
                format!("{speed} rad/s"),
                count.to_string(),
                number.to_string(),
                wanted.to_string(),
                format!("{q0:.3e} .. {q1:.3e}"),
                format!("{f0:.3e} .. {f1:.3e}"),
            ]);
        }
    }
    Ok(rows)
}

fn pair_at(speed: f64) -> Outcome<NfgPair> {
    pair(&NfgParams { speed, ..NfgParams::table1() })
}

/// For several numbers of samples: at which load P first loses contact, and where the branch ends or
/// touches the back flank: from 25 N m downwards at 125 rad/s.
pub fn load_limits(report: &mut Report) -> Outcome<()> {
    const STEP: f64 = 0.01;
    let numbers = if coarse() { vec![512, 1024] } else { vec![512, 1024, 2048, 16_384] };
    let rows: Result<Vec<Vec<String>>, String> = numbers
        .par_iter()
        .map(|&samples| {
            let limits = || -> Outcome<(f64, f64, &str)> {
                let balance = Balance::new(Harmonics::bands(MESH, 1, 2)?)
                    .truncated_forces()
                    .integrals(Integrals::Sampled { samples });
                let at = |i: u32| {
                    pair(&NfgParams {
                        speed: 125.0,
                        load_torque: 25.0 - STEP * f64::from(i),
                        ..NfgParams::table1()
                    })
                };
                let mut orbit = balance.linearised(&at(0)?, Piece::Lower)?;
                let mut lost = None;
                for i in 0.. {
                    let pair = at(i)?;
                    let load = pair.constant("load torque")?;
                    let Ok(next) = balance.solve(&pair, &orbit) else {
                        return Ok((lost.unwrap_or(f64::NAN), load + STEP, "ends"));
                    };
                    match next.contacts(&pair)?[0].statistics.rattle_state() {
                        RattleState::Bilateral => {
                            return Ok((lost.unwrap_or(f64::NAN), load + STEP, "reaches the back flank"));
                        }
                        RattleState::None => {}
                        _ => lost = lost.or(Some(load)),
                    }
                    orbit = next;
                }
                Err("the branch does not end".into())
            };
            let (lost, end, how) = limits().map_err(|e| format!("{samples} samples: {e}"))?;
            Ok(vec![samples.to_string(), format!("{lost:.2}"), format!("{end:.2}: {how}")])
        })
        .collect();
    let header = ["samples M", "contact lost from [N m]", "branch ends at [N m]"];
    report.table("load_limits_of_p", Kind::Fixed, &header, &rows?);
    Ok(())
}
