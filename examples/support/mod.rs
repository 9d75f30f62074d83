//! Shared by the examples: the folder of their results, CSV files, the short run, the progress bar.
#![allow(dead_code, reason = "each example uses some of these")]

use indicatif::{ProgressBar, ProgressStyle};
use std::error::Error;
use std::fs::{File, create_dir_all};
use std::io::BufWriter;
use std::path::PathBuf;

pub type Outcome<T> = Result<T, Box<dyn Error>>;

/// The folder `target/gallery/<example>/`, which is created.
pub fn gallery(example: &str) -> Outcome<PathBuf> {
    let folder = PathBuf::from("target/gallery").join(example);
    create_dir_all(&folder)?;
    Ok(folder)
}

/// Whether a short run is requested by `-- --coarse`: fewer points, the same steps.
pub fn coarse() -> bool {
    std::env::args().any(|arg| arg == "--coarse")
}

pub type Csv = gear_dynamics::export::Csv<BufWriter<File>>;

/// A file of comma-separated values; `header` are the names of its columns, with commas.
pub fn csv_file(path: PathBuf, header: &str) -> Outcome<Csv> {
    Ok(Csv::new(BufWriter::new(File::create(path)?), &header.split(',').collect::<Vec<_>>())?)
}

pub fn progress(what: &str, count: usize) -> ProgressBar {
    let style =
        ProgressStyle::with_template("{msg:28} {bar:40} {pos}/{len} {eta}").expect("the template is fixed");
    ProgressBar::new(count as u64).with_style(style).with_message(what.to_owned())
}
