//! Orbits along a branch, proved to exist: the pair of Kahraman and Singh (1990) from contact to contact loss.
//!
//! The table has every twentieth orbit, and those left open, with what is proved: the half width of its boxes,
//! its crossings, its stability. Next to a grazing a crossing is too slow for the width of the boxes, and the proof says so.
//! `certified.csv` contains all orbits.
//!
//! `cargo run --release -p examples --example certified`, with `-- --coarse` for every fourth orbit; everything is
//! written to target/gallery/certified/.

mod support;

use gear_dynamics::branches::{Continuation, Family};
use gear_dynamics::models::Oscillator;
use gear_dynamics::periodic::Stability;
use gear_dynamics_plots::{Mark, Panel, Picture};
use support::{Outcome, coarse, csv_file, gallery};

pub(crate) fn main() -> Outcome<()> {
    let folder = gallery("certified")?;
    let mut csv = csv_file(folder.join("certified.csv"), "omega,peak_to_peak,radius,crossings,stability")?;
    // x'' + 0.1 x' + g(x) = 0.1 + 0.05 Ω² cos Ωt near Ω = 0.75, g the dead zone of half width 1.
    let pair = Oscillator::new(&[
        ("speed", 0.6),
        ("damping", 0.1),
        ("mesh stiffness", 1.0),
        ("mean force", 0.1),
        ("force", 0.03),
        ("half backlash", 1.0),
    ])?;
    let branch = Continuation::new(0.6, 1.1).run(&Family::over(&pair, ["speed"])?, None)?;
    let every = if coarse() { 4 } else { 1 };
    let (mut stable, mut unstable, mut open, mut radii) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (i, point) in branch.points().iter().enumerate().step_by(every) {
        let (omega, swing) = (point.parameter, point.peak_to_peak());
        let proved = point.orbit.certify(&pair.with("speed", omega)?);
        let line = match &proved {
            Ok(certificate) => {
                match certificate.stability() {
                    Stability::Stable => stable.push((omega, swing)),
                    Stability::Unstable => unstable.push((omega, swing)),
                    Stability::Undecided => open.push((omega, swing)),
                }
                let (radius, crossings) = (certificate.radius(), certificate.crossings().len());
                radii.push((omega, radius));
                csv.row(&[&omega, &swing, &radius, &crossings, &certificate.stability()])?;
                format!("proved to {radius:.1e}, {crossings} crossings, {}", certificate.stability())
            }
            Err(unproved) => {
                open.push((omega, swing));
                csv.row(&[&omega, &swing, &f64::NAN, &"", &"unproved"])?;
                unproved.to_string()
            }
        };
        if i % 20 == 0 || proved.is_err() {
            println!("Ω = {omega:.4}: {line}");
        }
    }
    println!("{} orbits proved stable, {} unstable, {} left open", stable.len(), unstable.len(), open.len());
    let mut orbits = Panel::new("what is proved", "frequency Ω [1]", "peak-to-peak deflection [1]")?;
    for (name, points) in [("proved stable", stable), ("proved unstable", unstable), ("not proved", open)] {
        // A panel has no empty series.
        orbits = if points.is_empty() { orbits } else { orbits.series(name, Mark::Dots, points)? };
    }
    let widths = Panel::new("half width of the largest box", "frequency Ω [1]", "half width [1]")?
        .series("proved", Mark::Dots, radii)?
        .logarithmic_y()?;
    Picture::new(vec![orbits, widths]).columns(1).save(folder.join("certified.svg"))?;
    Ok(())
}
