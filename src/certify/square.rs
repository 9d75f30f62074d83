//! Square matrices of intervals.

use crate::interval::number::Interval;

/// A square matrix of intervals, by rows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Square {
    pub(crate) size: usize,
    pub(crate) entries: Vec<Interval>,
}

impl Square {
    pub(crate) fn from_fn(size: usize, entry: impl Fn(usize, usize) -> Interval) -> Self {
        let entries = (0..size * size).map(|i| entry(i / size, i % size)).collect();
        Square { size, entries }
    }
    pub(crate) fn identity(size: usize) -> Self {
        Square::from_fn(size, |i, j| if i == j { Interval::ONE } else { Interval::ZERO })
    }
    pub(crate) fn at(&self, i: usize, j: usize) -> Interval {
        self.entries[i * self.size + j]
    }
    pub(crate) fn times(&self, other: &Square) -> Square {
        Square::from_fn(self.size, |i, j| {
            (0..self.size).fold(Interval::ZERO, |sum, k| sum + self.at(i, k) * other.at(k, j))
        })
    }
    pub(crate) fn middle(&self) -> nalgebra::DMatrix<f64> {
        nalgebra::DMatrix::from_fn(self.size, self.size, |i, j| self.at(i, j).middle())
    }
}
