//! Fourteen pictures: one for each chapter of the course, a Campbell diagram, a mode of a planetary set, and
//! two of random loads. `cargo run --release -p examples --example gallery`, with `-- NAME` for the pictures
//! whose name contains NAME, with `-- --coarse` for fewer points. The SVG files are written to
//! `target/gallery/gallery/`; `docs/pictures/` has copies.

#[path = "gallery/course.rs"]
mod course;
#[path = "gallery/gearbox.rs"]
mod gearbox;
#[path = "gallery/pair.rs"]
mod pair;
#[path = "gallery/random.rs"]
mod random;

use gear_dynamics_plots::Picture;
use std::error::Error;
use std::path::Path;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Name of the file, and what draws it. The argument: whether fewer points are enough.
type Entry = (&'static str, fn(bool) -> Outcome<Picture>);

/// docs/gallery.md says what they show.
const PICTURES: [Entry; 14] = [
    ("01-excitation", course::excitation),
    ("02-response", course::response),
    ("03-contact-loss", course::contact_loss),
    ("04-orbit", course::orbit),
    ("05-jumps", course::jumps),
    ("06-map", course::map),
    ("07-random", course::random),
    ("08-law", course::law),
    ("09-orders", gearbox::orders),
    ("10-solvers", course::solvers),
    ("11-campbell", gearbox::campbell),
    ("12-modes", gearbox::modes),
    ("13-paths", random::paths),
    ("14-chances", random::chances),
];

pub(crate) fn main() -> Outcome<()> {
    let (options, names): (Vec<_>, Vec<_>) = std::env::args().skip(1).partition(|arg| arg.starts_with("--"));
    let coarse = options.iter().any(|option| option == "--coarse");
    let is_asked = |name: &str| names.is_empty() || names.iter().any(|part| name.contains(part));
    if !PICTURES.iter().any(|(name, _)| is_asked(name)) {
        let all: Vec<_> = PICTURES.iter().map(|(name, _)| *name).collect();
        return Err(
            format!("no picture is called {}; there are {}", names.join(" or "), all.join(", ")).into()
        );
    }
    let folder = Path::new("target/gallery/gallery");
    let mut failed = 0;
    if let Err(error) = std::fs::create_dir_all(folder) {
        println!("{}: {error}", folder.display());
    }
    for (name, draw) in PICTURES.into_iter().filter(|(name, _)| is_asked(name)) {
        let path = folder.join(name).with_extension("svg");
        // A picture that fails does not stop the others.
        match draw(coarse).and_then(|picture| Ok(picture.save(&path)?)) {
            Ok(()) => println!("{}", path.display()),
            Err(error) => {
                failed += 1;
                println!("{}: {error}", path.display());
            }
        }
    }
    if failed > 0 { Err(format!("{failed} pictures were not drawn").into()) } else { Ok(()) }
}
