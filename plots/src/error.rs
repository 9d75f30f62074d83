//! Errors.

use gear_dynamics::ParameterError;
use std::path::PathBuf;
use thiserror::Error;

/// What a picture refuses, by name.
///
/// ```
/// use gear_dynamics_plots::{Mark, Panel, PlotError};
/// let panel = Panel::new("", "time [s]", "deflection [m]")?;
/// let refused = panel.series("mesh 1", Mark::Line, [(0.0, 1e-6), (1.0, f64::NAN)]).unwrap_err();
/// assert_eq!(refused.to_string(), "mesh 1: number 1 is NaN: a finite number is needed");
/// # Ok::<(), PlotError>(())
/// ```
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PlotError {
    /// Nothing to draw.
    #[error("{what}: there are no data")]
    Empty {
        /// What is empty.
        what: String,
    },
    /// A number that is not finite.
    #[error("{what}: number {index} is {value:?}: a finite number is needed")]
    NotFinite {
        /// Which data.
        what: String,
        /// Index of the first such number, from 0.
        index: usize,
        /// The number.
        value: f64,
    },
    /// A number that a logarithmic axis cannot show.
    #[error("{what}: {value:?} cannot be drawn on a logarithmic axis: a positive number is needed")]
    NotPositive {
        /// Which data.
        what: String,
        /// The number.
        value: f64,
    },
    /// A range whose end is not above its start.
    #[error("{what} is {range:?}: finite numbers in increasing order are needed")]
    Range {
        /// Which range.
        what: String,
        /// Start and end.
        range: [f64; 2],
    },
    /// A number of mesh cycles that cannot be drawn.
    #[error("{value:?} mesh cycles: a number in (0, 1e4] is needed")]
    Cycles {
        /// The number.
        value: f64,
    },
    /// An axis or a colour bar without a unit.
    #[error("\"{axis}\" states no unit: write \"name [unit]\", and \"name [1]\" without dimension")]
    NoUnit {
        /// The text of the axis.
        axis: String,
    },
    /// Points that are not a complete grid over two parameters.
    #[error(
        "{what}: a map needs a point at each place of a grid over two parameters; {columns} x {rows} different values \
         make {} places, and there are {found} points: sweep over Points::grid",
        columns * rows
    )]
    NoGrid {
        /// Which data.
        what: String,
        /// Number of points.
        found: usize,
        /// Number of different values of the first parameter.
        columns: usize,
        /// Number of different values of the second parameter.
        rows: usize,
    },
    /// A part that does not exist.
    #[error("{what}: there is no number {index}, there are {count}")]
    NoSuch {
        /// Which list.
        what: String,
        /// The index, from 0.
        index: usize,
        /// Length of the list.
        count: usize,
    },
    /// An error of the library about the model or the data.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A file that could not be written.
    #[error("{}: {source}", path.display())]
    Write {
        /// Its path.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

/// Checks that there are numbers and all of them are finite.
pub(crate) fn finite<'n>(what: &str, numbers: impl IntoIterator<Item = &'n f64>) -> Result<(), PlotError> {
    let mut count = 0;
    for (index, &value) in numbers.into_iter().enumerate() {
        if !value.is_finite() {
            return Err(PlotError::NotFinite { what: what.into(), index, value });
        }
        count = index + 1;
    }
    if count == 0 { Err(PlotError::Empty { what: what.into() }) } else { Ok(()) }
}
