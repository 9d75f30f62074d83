//! Twelve pictures: one for each chapter of the course, a Campbell diagram and a mode of a planetary set.
//! `cargo run --release -p examples --example gallery`, with `-- --coarse` for fewer points. The SVG files are written to
//! `target/gallery/gallery/`; `docs/pictures/` has copies.

#[path = "gallery/course.rs"]
mod course;
#[path = "gallery/gearbox.rs"]
mod gearbox;
#[path = "gallery/pair.rs"]
mod pair;

use gear_dynamics_plots::Figure;
use std::error::Error;
use std::path::Path;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Name of the file, what the picture shows, and what draws it. The argument: whether fewer points are enough.
type Picture = (&'static str, &'static str, fn(bool) -> Outcome<Figure>);

const PICTURES: [Picture; 12] = [
    ("01-excitation", "mesh stiffness and transmission error", course::excitation),
    ("02-response", "linear response and the response with contact loss", course::response),
    ("03-contact-loss", "deflection over time with the gap shaded", course::contact_loss),
    ("04-orbit", "an orbit in the phase plane", course::orbit),
    ("05-jumps", "a branch with its folds, sweeps up and down", course::jumps),
    ("06-map", "rattle map with the located onset of contact loss", course::map),
    ("07-random", "band of the mesh force under a random torque", course::random),
    ("08-law", "folds for smooth and rough flanks", course::law),
    ("09-orders", "orders of the mesh forces of a gearbox", gearbox::orders),
    ("10-solvers", "error over work of the four solvers", course::solvers),
    ("11-campbell", "Campbell diagram of a gearbox", gearbox::campbell),
    ("12-modes", "modes of a planetary set", gearbox::modes),
];

fn main() {
    let coarse = std::env::args().any(|arg| arg == "--coarse");
    let folder = Path::new("target/gallery/gallery");
    let mut failed = 0;
    if let Err(error) = std::fs::create_dir_all(folder) {
        println!("{}: {error}", folder.display());
    }
    for (name, what, draw) in PICTURES {
        let path = folder.join(name).with_extension("svg");
        // A picture that fails does not stop the others.
        match draw(coarse).and_then(|figure| Ok(figure.save(&path)?)) {
            Ok(()) => println!("{:44} {what}", path.display()),
            Err(error) => {
                failed += 1;
                println!("{:44} {what}: {error}", path.display());
            }
        }
    }
    if failed > 0 {
        println!("{failed} pictures were not drawn");
        std::process::exit(1);
    }
}
