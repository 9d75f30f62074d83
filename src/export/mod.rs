//! Results as tables of numbers.
//!
//! A [`ResultTable`] has named columns with units: of rows, branches, trajectories, spectra and others.
//! [`Csv`] writes it as text, the feature `npy` in the array format of NumPy.

pub(crate) mod csv;
#[cfg(feature = "npy")]
mod npy;
pub(crate) mod table;

pub use crate::export::csv::Csv;
pub use crate::export::table::ResultTable;
