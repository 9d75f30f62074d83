//! Linear complementarity problems.

/// A pivot below this share of the largest entry of its column counts as zero `[1]`.
const PIVOT: f64 = 1e-11;

/// Maximum number of pivots, per unknown. Lemke's method needs about one per unknown.
const PIVOTS: usize = 16;

/// Scratch of [`solve`](Complementarity::solve).
#[derive(Default)]
pub(crate) struct Complementarity {
    tableau: Vec<f64>,
    basis: Vec<usize>,
    /// The solution z.
    pub(crate) z: Vec<f64>,
}

impl Complementarity {
    /// With room for problems of up to `n` unknowns.
    pub(crate) fn of_size(n: usize) -> Self {
        Complementarity {
            tableau: Vec::with_capacity(n * (2 * n + 2)),
            basis: Vec::with_capacity(n),
            z: Vec::with_capacity(n),
        }
    }

    /// Solves w = G z + q with w >= 0, z >= 0, zᵀw = 0 by Lemke's method. G has n × n entries, row by row.
    /// Returns whether a solution was found.
    ///
    /// The method ends for every G = A D with A positive semidefinite and symmetric and D diagonal and
    /// positive: with a solution, or if there is none. Unequal weights of the covering variable break the
    /// ties of equal rows.   Source: Cottle, Pang & Stone, The Linear Complementarity Problem, Sect. 4.4.
    pub(crate) fn solve(&mut self, g: &[f64], q: &[f64]) -> bool {
        let n = q.len();
        let (cover, right, width) = (2 * n, 2 * n + 1, 2 * n + 2);
        self.z.clear();
        self.z.resize(n, 0.0);
        self.basis.clear();
        self.basis.extend(0..n);
        self.tableau.clear();
        self.tableau.resize(n * width, 0.0);
        let weight = |i: usize| 1.0 + 0.1 * (i + 1) as f64 / n as f64;
        for (i, row) in self.tableau.chunks_exact_mut(width).enumerate() {
            row[i] = 1.0;
            row[n..cover].iter_mut().zip(&g[i * n..][..n]).for_each(|(to, g)| *to = -g);
            (row[cover], row[right]) = (-weight(i), q[i]);
        }
        let share = |i: usize| q[i] / weight(i);
        let Some(first) = (0..n).filter(|&i| q[i] < 0.0).min_by(|&i, &j| share(i).total_cmp(&share(j)))
        else {
            return true;
        };
        let mut enters = self.pivot(first, cover, width);
        for _ in 0..PIVOTS * n {
            let column = |i: usize| self.tableau[i * width + enters];
            let least = PIVOT * (0..n).map(|i| column(i).abs()).fold(0.0, f64::max);
            let ratio = |i: usize| self.tableau[i * width + right] / column(i);
            let rows = (0..n).filter(|&i| column(i) > least);
            let Some(row) = rows.min_by(|&i, &j| ratio(i).total_cmp(&ratio(j))) else { return false };
            let left = self.basis[row];
            let leaves = self.pivot(row, enters, width);
            if left == cover {
                for (i, &basic) in self.basis.iter().enumerate() {
                    if (n..cover).contains(&basic) {
                        self.z[basic - n] = self.tableau[i * width + right].max(0.0);
                    }
                }
                return true;
            }
            enters = leaves;
        }
        false
    }

    /// Makes the variable `enters` basic in a row. Returns the complement of the variable that leaves.
    fn pivot(&mut self, row: usize, enters: usize, width: usize) -> usize {
        let n = self.basis.len();
        let pivot = self.tableau[row * width + enters];
        self.tableau[row * width..][..width].iter_mut().for_each(|x| *x /= pivot);
        for i in (0..n).filter(|&i| i != row) {
            let factor = self.tableau[i * width + enters];
            for k in 0..width {
                let of_row = self.tableau[row * width + k];
                self.tableau[i * width + k] -= factor * of_row;
            }
        }
        let leaves = std::mem::replace(&mut self.basis[row], enters);
        if leaves < n { leaves + n } else { leaves.saturating_sub(n) }
    }
}
