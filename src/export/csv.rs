//! Comma-separated values.

use std::fmt::{self, Display};
use std::io::{Error, ErrorKind, Result, Write};

/// A writer of comma-separated values after RFC 4180, with lines that end in `\n`.
///
/// Fields with a comma, a quotation mark or a line break are put in quotation marks. Numbers have the fewest
/// digits that give every bit back when they are read. Each field is passed on at once: wrap a file in a
/// [`BufWriter`](std::io::BufWriter).
///
/// ```
/// let mut csv = gear_dynamics::export::Csv::new(Vec::new(), &["solver", "error, relative"])?;
/// csv.row(&[&"Dop853", &0.1])?;
/// csv.numbers(&[f64::NAN, 2.5e-300])?;
/// let text = String::from_utf8(csv.finish()?)?;
/// assert_eq!(text, "solver,\"error, relative\"\nDop853,0.1\nNaN,2.5e-300\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Csv<W> {
    writer: W,
    columns: usize,
}

impl<W> fmt::Debug for Csv<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Csv").field("columns", &self.columns).finish_non_exhaustive()
    }
}

impl<W: Write> Csv<W> {
    /// Writes the line of the names.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`] without names; errors of the writer.
    pub fn new<N: Display>(writer: W, names: &[N]) -> Result<Self> {
        let mut csv = Csv { writer, columns: names.len() };
        if names.is_empty() {
            return Err(Error::new(ErrorKind::InvalidInput, "a table needs at least one column"));
        }
        csv.line(names.len(), names.iter().map(|name| quoted(name.to_string(), names.len() == 1)))?;
        Ok(csv)
    }

    /// Writes a line of any fields.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`] unless there is a field for each name; errors of the writer.
    pub fn row(&mut self, fields: &[&dyn Display]) -> Result<()> {
        let alone = fields.len() == 1;
        self.line(fields.len(), fields.iter().map(|field| quoted(field.to_string(), alone)))
    }

    /// Writes a line of numbers, with an exponent if they are small or large.
    ///
    /// # Errors
    /// As [`row`](Csv::row).
    pub fn numbers(&mut self, numbers: &[f64]) -> Result<()> {
        // The format `{:?}` has the digits of `{}`, and an exponent below 1e-5 and from 1e16.
        self.line(numbers.len(), numbers.iter().map(|number| format!("{number:?}")))
    }

    /// Flushes the writer and returns it.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn finish(mut self) -> Result<W> {
        self.writer.flush()?;
        Ok(self.writer)
    }

    fn line(&mut self, count: usize, fields: impl Iterator<Item = String>) -> Result<()> {
        if count != self.columns {
            let text = format!("a row of {count} fields in a table of {} columns", self.columns);
            return Err(Error::new(ErrorKind::InvalidInput, text));
        }
        for (i, field) in fields.enumerate() {
            let comma = if i == 0 { "" } else { "," };
            write!(self.writer, "{comma}{field}")?;
        }
        writeln!(self.writer)
    }
}

/// A field, in quotation marks if it needs them. `alone`: the line has no other field; an empty one would be
/// an empty line.
fn quoted(field: String, alone: bool) -> String {
    if field.contains([',', '"', '\n', '\r']) || (alone && field.is_empty()) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field
    }
}
