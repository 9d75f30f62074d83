//! Sparse matrices as lists of entries.

use std::collections::BTreeMap;

/// A square matrix by its entries that may differ from 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Entries {
    /// Number of rows and of columns.
    pub(crate) n: usize,
    /// Row, column and value of each entry. Entries at the same place add up.
    pub(crate) list: Vec<(usize, usize, f64)>,
}

impl Entries {
    /// The diagonal.
    pub(crate) fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.n];
        self.list.iter().filter(|(i, j, _)| i == j).for_each(|(i, _, x)| diagonal[*i] += x);
        diagonal
    }

    /// Whether row i reads column j with the sign with which row j reads column i, as in M⁻¹ K with a
    /// positive inertia M and a symmetric K.
    pub(crate) fn is_sign_symmetric(&self) -> bool {
        let place = |i: usize, j: usize, x: f64| ((i, j), if x == 0.0 { 0.0 } else { x.signum() });
        let signs: BTreeMap<_, f64> = self.list.iter().map(|&(i, j, x)| place(i, j, x)).collect();
        signs.iter().all(|(&(i, j), x)| signs.get(&(j, i)).copied().unwrap_or(0.0) == *x)
    }

    /// The largest size of an entry.
    pub(crate) fn largest(&self) -> f64 {
        self.list.iter().fold(0.0, |most: f64, (_, _, x)| most.max(x.abs()))
    }
}
