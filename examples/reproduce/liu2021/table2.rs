//! Table 2, Fig. 17 and Fig. 18 of Liu 2021: amplitudes at the frequencies of the centre and of the mesh.

use super::super::report::{Kind, Report};
use super::super::support::Outcome;
use super::motions::{ELASTIC, MESH, pair, paper, shooting, solver};
use super::sweeps::READINGS;
use gear_dynamics::contact::Piece;
use gear_dynamics::excitation::Fourier;
use gear_dynamics::models::nfg::NfgReading;
use gear_dynamics::ode::uniform_times;
use gear_dynamics::periodic::FourierOrbit;
use gear_dynamics::{Harmonics, Integrator, NfgPair, NfgParams, Periodic};
use gear_dynamics_plots::{Mark, Panel};
use std::f64::consts::TAU;

/// Motor speed [r/min]; theory: f_c [Hz], A_c, f_e [Hz], A_e, ξ; experiment: f_c [Hz], A_c [m/s²], f_e [Hz], A_e
/// [m/s²], ξ. The printed headers of A_c and A_e are swapped.   Source: Liu 2021, Table 2.
#[rustfmt::skip]
const TABLE2: [[f64; 11]; 9] = [
    [ 280.0, 1.0, 0.53,  64.0,  25.91, 48.6, 1.0, 0.016,  65.4, 0.547, 34.2],
    [ 392.0, 1.4, 0.75,  89.6,  36.43, 48.8, 1.5, 0.027,  91.7, 1.073, 39.7],
    [ 504.0, 1.8, 0.96, 115.2,  47.18, 49.1, 1.9, 0.031, 116.2, 2.364, 76.3],
    [ 616.0, 2.2, 1.18, 140.8,  58.38, 49.7, 2.3, 0.045, 141.2, 2.431, 54.0],
    [ 728.0, 2.6, 1.39, 166.4,  70.33, 50.5, 2.7, 0.020, 170.1, 1.005, 50.3],
    [ 840.0, 3.0, 1.61, 192.0,  83.45, 51.8, 3.2, 0.013, 194.0, 0.685, 52.7],
    [ 952.0, 3.4, 1.83, 217.6,  98.27, 53.6, 3.6, 0.032, 215.2, 1.963, 61.3],
    [1064.0, 3.8, 2.06, 243.2, 115.4,  56.0, 4.0, 0.039, 241.0, 1.978, 50.7],
    [1176.0, 4.2, 2.29, 268.8, 135.5,  59.1, 4.4, 0.032, 267.9, 2.094, 65.4],
];
/// Load torque of Table 1 [N m]; the text of the experiment states 3 N m.
const LOAD: f64 = 30.0;
/// Ratio of the belt from the motor to the pinion. With Z1 = 18 and Z2 = 63 it gives all nine printed f_e exactly and
/// all nine printed f_c, which are cut after one decimal. The text rounds it to 1.3.
const BELT: f64 = 21.0 / 16.0;

/// Table 2 at one speed: the orbits of P and of the published equations; amplitudes of f(q) at the centre and
/// the mesh order for P, published and exact.
struct Lines {
    hertz: f64,
    orbits: [FourierOrbit; 2],
    amplitudes: [[f64; 2]; 3],
}

fn table2_lines(rpm: f64, belt: f64, load_torque: f64) -> Outcome<Lines> {
    const SAMPLES: usize = 8192;
    let params = NfgParams { speed: rpm * TAU / 60.0 / belt, load_torque, ..NfgParams::table1() };
    let pair = pair(&params)?;
    let balance = paper()?;
    let p = balance.solve(&pair, &balance.linearised(&pair, Piece::Lower)?)?;
    let orbit_of = |pair: &NfgPair| -> Outcome<(FourierOrbit, [f64; 2])> {
        let cycle = shooting().max_iterations(30).solve(pair, &[pair.on_drive_flank()?])?;
        let start = &cycle.states()[0];
        let turn = solver().sample(pair, start, &uniform_times(0.0, pair.period(), SAMPLES)?)?;
        let series = Fourier::fit(&turn.channel(pair, ELASTIC)?, MESH)?;
        let amplitude = |order: usize| series.pairs()[order - 1][0].hypot(series.pairs()[order - 1][1]);
        Ok((
            FourierOrbit::project(&solver(), pair, start, &Harmonics::up_to(260))?,
            [amplitude(1), amplitude(MESH)],
        ))
    };
    let (published, of_published) = orbit_of(&pair)?;
    let (_, of_exact) = orbit_of(&NfgPair::of_reading(&params, NfgReading::exact())?)?;
    // Without rattle and with a constant half width q and f(q) differ by a constant only.
    let amplitudes = [[p.amplitude(0, 1), p.amplitude(0, MESH)], of_published, of_exact];
    Ok(Lines { hertz: rpm / 60.0 / belt / params.ratio, orbits: [p, published], amplitudes })
}

/// The constant C that minimises the mean square of C ours/theirs - 1, and the maximum remaining deviation
/// [%].
fn fit(ours: impl Iterator<Item = f64>, theirs: impl Iterator<Item = f64>) -> (f64, f64) {
    let shares: Vec<f64> = ours.zip(theirs).map(|(x, y)| x / y).collect();
    let c = shares.iter().sum::<f64>() / shares.iter().map(|s| s * s).sum::<f64>();
    (c, 100.0 * shares.iter().fold(0.0f64, |worst, s| worst.max((c * s - 1.0).abs())))
}

/// Table 2, Fig. 17 and Fig. 18.
pub fn figures(report: &mut Report) -> Outcome<()> {
    let lines = TABLE2.iter().map(|row| table2_lines(row[0], BELT, LOAD)).collect::<Outcome<Vec<_>>>()?;
    let ratio = |l: &Lines, r: usize| MESH as f64 * l.amplitudes[r][1] / l.amplitudes[r][0];
    let centre = |l: &Lines, r: usize| TAU * l.hertz * l.amplitudes[r][0];
    let mesh = |l: &Lines, r: usize| TAU * MESH as f64 * l.hertz * l.amplitudes[r][1];
    // One constant for a column and a reading.
    let column = |of: &dyn Fn(&Lines, usize) -> f64, printed: usize| -> Vec<(f64, f64)> {
        (0..READINGS.len())
            .map(|r| fit(lines.iter().map(|l| of(l, r)), TABLE2.iter().map(|row| row[printed])))
            .collect()
    };
    let (c_centre, c_mesh, c_ratio) = (column(&centre, 2), column(&mesh, 4), column(&ratio, 5));
    let mut theory = Vec::new();
    let mut measured = Vec::new();
    for (row, l) in TABLE2.iter().zip(&lines) {
        let with = |c: &[(f64, f64)], of: &dyn Fn(&Lines, usize) -> f64, digits: usize| -> Vec<String> {
            (0..READINGS.len()).map(|r| format!("{:.digits$}", c[r].0 * of(l, r))).collect()
        };
        let mut cells = vec![row[0].to_string(), format!("{:.2}", row[2])];
        cells.extend(with(&c_centre, &centre, 3));
        cells.push(row[4].to_string());
        cells.extend(with(&c_mesh, &mesh, 2));
        cells.push(format!("{:.1}", row[5]));
        cells.extend(with(&c_ratio, &ratio, 2));
        theory.push(cells);
        let mesh_hertz = MESH as f64 * l.hertz;
        measured.push(vec![
            row[0].to_string(),
            format!("{:.1}", row[1]),
            format!("{:.3}", l.hertz),
            format!("{:.1}", row[6]),
            format!("{:.1}", row[3]),
            format!("{mesh_hertz:.2}"),
            format!("{:.1}", row[8]),
            format!("{:+.1} %", 100.0 * (row[8] / mesh_hertz - 1.0)),
            format!("{:.3}", row[7]),
            format!("{:.3}", row[9]),
            format!("{:.1}", row[9] / row[7]),
            format!("{:.1}", row[10]),
            format!("{:+.0} %", 100.0 * (row[10] / row[5] - 1.0)),
        ]);
    }
    #[rustfmt::skip]
    let header = ["r/min", "A_c printed", "P", "published", "exact", "A_e printed", "P", "published", "exact",
        "ξ printed", "P", "published", "exact"];
    report.table("table2_theory", Kind::Fixed, &header, &theory);
    #[rustfmt::skip]
    let header = ["r/min", "f_c printed", "f_c [Hz]", "f_c measured", "f_e printed", "f_e [Hz]", "f_e measured",
        "measured off", "A_c measured [m/s²]", "A_e measured [m/s²]", "A_e/A_c", "ξ measured", "ξ measured against theory"];
    report.table("table2_experiment", Kind::Fixed, &header, &measured);
    let rows: Vec<Vec<String>> = (0..READINGS.len())
        .map(|r| {
            let with = |c: (f64, f64)| {
                if c.0 < 100.0 {
                    format!("{:.4}, {:.2} %", c.0, c.1)
                } else {
                    format!("{:.4e}, {:.2} %", c.0, c.1)
                }
            };
            let quotient = format!("{:.4}", c_mesh[r].0 / c_centre[r].0);
            vec![READINGS[r].into(), with(c_centre[r]), with(c_mesh[r]), with(c_ratio[r]), quotient]
        })
        .collect();
    let header =
        ["reading", "C of A_c, worst row", "C of A_e, worst row", "C of ξ, worst row", "C of A_e/C of A_c"];
    report.table("table2_constants", Kind::Fixed, &header, &rows);
    let mut rows = Vec::new();
    for (belt, load) in [(BELT, LOAD), (1.3, LOAD), (BELT, 3.0)] {
        let lines: Outcome<Vec<Lines>> = TABLE2.iter().map(|row| table2_lines(row[0], belt, load)).collect();
        let mut cells = vec![belt.to_string(), load.to_string()];
        match lines {
            Ok(lines) => cells.extend((0..READINGS.len()).map(|r| {
                let (c, worst) = fit(lines.iter().map(|l| ratio(l, r)), TABLE2.iter().map(|row| row[5]));
                format!("C = {c:.4}, {worst:.2} %")
            })),
            Err(error) => {
                println!("belt {belt}, {load} N m: {error}");
                cells.extend(vec!["no orbit".to_owned(); READINGS.len()]);
            }
        }
        rows.push(cells);
    }
    let header = ["belt ratio", "T2 [N m]", "P", "published", "exact"];
    report.table("table2_conditions", Kind::Fixed, &header, &rows);
    let off = TABLE2.iter().fold(0.0f64, |m, row| m.max((row[4] / row[2] / row[5] - 1.0).abs()));
    println!("the printed A_e/A_c differ from the printed ξ by up to {:.1} %", 100.0 * off);
    let natural = NfgPair::of_reading(&NfgParams::table1(), NfgReading::published())?.natural_frequency();
    println!("ω_n of the published equations is {natural:.1} rad/s");

    let curve = |of: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        TABLE2.iter().enumerate().map(|(i, row)| (row[0], of(i))).collect()
    };
    let mut fig18 = Panel::new("Fig. 18: ratio of amplitudes", "speed of the motor [r/min]", "ξ [1]")?
        .series("Liu 2021, theory", Mark::Dots, curve(&|i| TABLE2[i][5]))?
        .series("Liu 2021, experiment", Mark::Dots, curve(&|i| TABLE2[i][10]))?;
    for (r, name) in READINGS.iter().enumerate() {
        fig18 = fig18.series(name, Mark::Line, curve(&|i| c_ratio[r].0 * ratio(&lines[i], r)))?;
    }
    // The text of Liu 2021 states 864 r/min, but its frequencies are those of the row at 840 r/min.
    let (row, Lines { hertz, orbits: [p, truth], .. }) = (&TABLE2[5], &lines[5]);
    let spectrum = |orbit: &FourierOrbit| -> Vec<(f64, f64)> {
        let orders = orbit.harmonics().orders().iter().filter(|&&k| k > 0 && k < 130);
        orders.map(|&k| (k as f64 * hertz, orbit.amplitude(0, k))).collect()
    };
    let named: Vec<Vec<String>> = [1, 2, MESH - 1, MESH, MESH + 1]
        .iter()
        .map(|&k| {
            let amplitude = |orbit: &FourierOrbit| format!("{:.3}", 1e6 * orbit.amplitude(0, k));
            vec![k.to_string(), format!("{:.2}", k as f64 * hertz), amplitude(p), amplitude(truth)]
        })
        .collect();
    report.table("figure_17", Kind::Fixed, &["order", "f [Hz]", "P [μrad]", "published [μrad]"], &named);
    let fig17 =
        Panel::new(format!("Fig. 17: spectrum at {} r/min", row[0]), "f [Hz]", "amplitude of q [rad]")?
            .name_x(&[(row[6], "measured f_c"), (row[8], "measured f_e")])?
            .series("published", Mark::Bars, spectrum(truth))?
            .series("P", Mark::Dots, spectrum(p))?;
    report.picture("fig17_18.svg", 2, [fig17, fig18]);
    Ok(())
}
