//! Tables of numbers with named columns.

use crate::error::{ParameterError, check};
use crate::export::csv::Csv;
use crate::model::Channel;
use std::collections::HashSet;
use std::io::{Result as Written, Write};

/// Numbers in rows and named columns. A number that does not exist is NaN, for example the results of a point
/// without a row.
///
/// [`Trajectory::table`](crate::ode::Trajectory::table), [`Rows::table`](crate::sweep::Rows::table),
/// [`Spectrum::table`](crate::analysis::Spectrum::table), [`Density::table`](crate::analysis::Density::table)
/// and [`Impacts::table`](crate::analysis::Impacts::table) make tables of results.
///
/// ```
/// use gear_dynamics::{export::ResultTable, model::Channel};
/// let mut table = ResultTable::new(vec![Channel::new("t", "s"), Channel::new("force", "N")])?;
/// table.push(&[0.5, 1e300])?;
/// let mut csv = Vec::new();
/// table.write_csv(&mut csv)?;
/// assert_eq!(String::from_utf8(csv)?, "t [s],force [N]\n0.5,1e300\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ResultTable {
    columns: Vec<Channel>,
    /// The rows, one after the other.
    numbers: Vec<f64>,
}

impl ResultTable {
    /// A table without rows.
    ///
    /// # Errors
    /// No columns; two columns of the same name.
    pub fn new(columns: Vec<Channel>) -> Result<Self, ParameterError> {
        if columns.is_empty() {
            return Err(ParameterError::Empty { name: "columns of the table".into(), min: 1 });
        }
        let mut names = HashSet::new();
        if let Some(twice) = columns.iter().find(|column| !names.insert(column.name.as_str())) {
            return Err(ParameterError::Twice { name: twice.name.clone() });
        }
        Ok(ResultTable { columns, numbers: Vec::new() })
    }

    /// A table of rows of known length. The columns, names and units, have different names.
    pub(crate) fn of_rows<const N: usize>(
        columns: [(&str, &str); N],
        rows: impl Iterator<Item = [f64; N]>,
    ) -> Self {
        let columns = columns.map(|(name, unit)| Channel::new(name, unit)).to_vec();
        ResultTable { columns, numbers: rows.flatten().collect() }
    }

    /// Adds a row.
    ///
    /// # Errors
    /// [`ParameterError::Length`] unless there is a number for each column.
    pub fn push(&mut self, row: &[f64]) -> Result<(), ParameterError> {
        check::length("row of the table", row.len(), self.columns.len())?;
        self.numbers.extend_from_slice(row);
        Ok(())
    }

    /// The columns: names and units.
    pub fn columns(&self) -> &[Channel] {
        &self.columns
    }
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.numbers.len() / self.columns.len()
    }
    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }
    /// The rows, in order.
    pub fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.numbers.chunks_exact(self.columns.len())
    }
    /// All numbers, row after row.
    pub fn numbers(&self) -> &[f64] {
        &self.numbers
    }
    /// The numbers of a column.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`], which lists the names of the columns.
    pub fn column(&self, name: &str) -> Result<Vec<f64>, ParameterError> {
        let names: Vec<&str> = self.columns.iter().map(|column| column.name.as_str()).collect();
        let i = check::channel_index(&names, name)?;
        Ok(self.rows().map(|row| row[i]).collect())
    }

    /// Writes the table as CSV (see [`Csv`]). The first line contains names and units.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn write_csv<W: Write>(&self, writer: W) -> Written<()> {
        let mut csv = Csv::new(writer, &self.columns)?;
        self.rows().try_for_each(|row| csv.numbers(row))?;
        csv.finish().map(drop)
    }
}
