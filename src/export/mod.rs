//! Results as tables of numbers, written as CSV and, with the feature `npy`, as NPY.

pub(crate) mod csv;
#[cfg(feature = "npy")]
mod npy;
pub(crate) mod table;

pub use crate::export::csv::Csv;
pub use crate::export::table::ResultTable;
