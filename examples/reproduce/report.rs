//! The report: tables in Markdown, CSV files and pictures, and what became of them.

use super::support::{Csv, Outcome, coarse, csv_file};
use gear_dynamics_plots::{Panel, Picture};
use std::path::{Path, PathBuf};

/// The page that contains the tables.
const PAGE: &str = "docs/reproduction.md";

/// Whether the rows of a table depend on the number of points, which a short run reduces, or on motions that do not
/// repeat, whose figures depend on the last digits of a sine.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    /// The same in every run. A short run may compute some of the rows.
    Fixed,
    /// Of a full run only.
    Full,
}

/// Writes the files of one run. A file that cannot be written is named, and the run goes on.
pub struct Report {
    folder: PathBuf,
    page: Option<String>,
    /// Files that could not be written, with the reason.
    unwritten: Vec<String>,
    /// Parts of the report that could not be computed, with the reason.
    failed: Vec<String>,
    /// Tables that the page does not contain as they were computed. A short run compares what it computes in full.
    differing: Vec<String>,
    tables: usize,
}

impl Report {
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        let mut report = Report {
            folder: folder.into(),
            page: None,
            unwritten: Vec::new(),
            failed: Vec::new(),
            differing: Vec::new(),
            tables: 0,
        };
        let folder = report.folder.clone();
        report.note(&folder, std::fs::create_dir_all(&folder).map_err(Into::into));
        match std::fs::read_to_string(PAGE) {
            Ok(page) => report.page = Some(page),
            Err(error) => println!("{PAGE} is not compared: {error}"),
        }
        report
    }

    fn note(&mut self, path: &Path, written: Outcome<()>) {
        if let Err(error) = written {
            let line = format!("{}: {error}", path.display());
            println!("could not write {line}");
            self.unwritten.push(line);
        }
    }

    /// Runs one part of the report; if it fails, its name and the reason are kept. With `-- --only WORDS` parts whose
    /// names do not contain the words are left out.
    pub fn part(&mut self, name: &str, compute: impl FnOnce(&mut Report) -> Outcome<()>) {
        let mut args = std::env::args().skip_while(|arg| arg != "--only").skip(1);
        if args.next().is_some_and(|words| !name.contains(&words)) {
            return;
        }
        println!("\n== {name}");
        if let Err(error) = compute(self) {
            println!("{name} failed: {error}");
            self.failed.push(format!("{name}: {error}"));
        }
    }

    /// A CSV file; `header` are the names of its columns, with commas.
    pub fn csv(&mut self, file: &str, header: &str, rows: impl FnOnce(&mut Csv) -> Outcome<()>) {
        let path = self.folder.join(file);
        let written = csv_file(path.clone(), header).and_then(|mut csv| rows(&mut csv));
        self.note(&path, written);
    }

    /// A picture of panels in rows of `columns`.
    pub fn picture(&mut self, file: &str, columns: usize, panels: impl IntoIterator<Item = Panel>) {
        let path = self.folder.join(file);
        let drawn = Picture::new(panels).columns(columns).panel_size(420.0, 290.0).save(&path);
        self.note(&path, drawn.map_err(Into::into));
    }

    /// A Markdown table. It is printed, written to `NAME.md` and looked for on the page.
    pub fn table(&mut self, name: &str, kind: Kind, header: &[&str], rows: &[Vec<String>]) {
        // Brackets of units are no links.
        let line =
            |cells: &[String]| format!("| {} |\n", cells.join(" | ")).replace('[', "\\[").replace(']', "\\]");
        let mut text = line(&header.iter().map(|cell| (*cell).to_owned()).collect::<Vec<_>>());
        text += &format!("|{}\n", "---|".repeat(header.len()));
        rows.iter().for_each(|row| text += &line(row));
        println!("\n{name}:\n\n{text}");
        let path = self.folder.join(format!("{name}.md"));
        let written = std::fs::write(&path, &text).map_err(Into::into);
        self.note(&path, written);
        self.tables += 1;
        let Some(page) = &self.page else { return };
        let found = match (coarse(), kind) {
            (false, _) => page.contains(&text),
            (true, Kind::Fixed) => text.lines().all(|line| page.lines().any(|other| other == line)),
            (true, Kind::Full) => true,
        };
        if !found {
            self.differing.push(name.to_owned());
        }
    }

    /// States what could not be computed or written, and which tables differ from the page.
    ///
    /// # Errors
    /// If a part failed, a file is missing, or a table differs: in a short run, a row of a table of fixed rows.
    pub fn close(self) -> Outcome<()> {
        println!("\n{} tables; everything is in {}", self.tables, self.folder.display());
        self.failed.iter().for_each(|line| println!("not computed: {line}"));
        self.unwritten.iter().for_each(|line| println!("not written: {line}"));
        self.differing.iter().for_each(|name| println!("{PAGE} does not contain this table: {name}"));
        if self.page.is_some() && self.differing.is_empty() {
            let what = if coarse() { "rows that do not depend on the number of points" } else { "tables" };
            println!("{PAGE} contains the {what}");
        }
        match self.failed.len() + self.unwritten.len() + self.differing.len() {
            0 => Ok(()),
            faults => Err(format!("{faults} faults, listed above").into()),
        }
    }
}
