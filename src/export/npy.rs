//! The array format of NumPy.

use crate::export::table::ResultTable;
use npyz::WriterBuilder;
use std::io::{Result, Write};

impl ResultTable {
    /// Writes the numbers as an NPY array of 64-bit floats, one line for each row: the shape is (rows,
    /// columns). NumPy reads it with `numpy.load`. The format has no names; [`columns`](ResultTable::columns)
    /// has them.
    ///
    /// Requires the feature `npy`.
    ///
    /// ```
    /// use gear_dynamics::{export::ResultTable, model::Channel};
    /// let mut table = ResultTable::new(vec![Channel::new("t", "s"), Channel::new("force", "N")])?;
    /// table.push(&[0.5, 1e300])?;
    /// let mut npy = Vec::new();
    /// table.write_npy(&mut npy)?;
    /// assert_eq!(npy[1..6], *b"NUMPY");
    /// assert_eq!(npy[npy.len() - 8..], 1e300f64.to_le_bytes());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn write_npy<W: Write>(&self, writer: W) -> Result<()> {
        let shape = [self.len() as u64, self.columns().len() as u64];
        let options = npyz::WriteOptions::new().default_dtype().shape(&shape).writer(writer);
        let mut array = options.begin_nd()?;
        array.extend(self.numbers().iter().copied())?;
        array.finish()
    }
}
