//! The polynomial through a function at seven points of a stretch of time: both ends and five Gauss points.

use crate::numeric::gauss::FIVE;

/// Number of points: start, five Gauss points, end.
pub(crate) const POINTS: usize = 7;

/// Number of cells of the grid in a stretch.
pub(crate) const CELLS: usize = 16;

/// Allowance for the error of the polynomial, as a share of the range of the values. For a sine the error is
/// 1 % over one period and 5 % over 1.25.
pub(crate) const OFF: f64 = 0.03;

/// The points of a stretch from -1 to 1.
pub(crate) const NODES: [f64; POINTS] = {
    let (mut nodes, mut p) = ([-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], 0);
    while p < 5 {
        nodes[p + 1] = FIVE[p][0];
        p += 1;
    }
    nodes
};

/// The polynomial has a value at each point of the grid: a weighted sum of the values at the seven points.
/// Row k contains the weights for grid point k.
const GRID: [[f64; POINTS]; CELLS + 1] = {
    let (nodes, mut grid, mut k) = (NODES, [[1.0; POINTS]; CELLS + 1], 0);
    while k <= CELLS {
        let (x, mut i) = (2.0 * k as f64 / CELLS as f64 - 1.0, 0);
        while i < POINTS {
            let mut j = 0;
            while j < POINTS {
                if j != i {
                    grid[k][i] *= (x - nodes[j]) / (nodes[i] - nodes[j]);
                }
                j += 1;
            }
            i += 1;
        }
        k += 1;
    }
    grid
};

/// Weights of the divided difference of order six.
const SIXTH: [f64; POINTS] = {
    let (nodes, mut weights, mut i) = (NODES, [1.0; POINTS], 0);
    while i < POINTS {
        let mut j = 0;
        while j < POINTS {
            if j != i {
                weights[i] /= nodes[i] - nodes[j];
            }
            j += 1;
        }
        i += 1;
    }
    weights
};

/// The values of the polynomial on the grid.
pub(crate) fn on_grid(values: &[f64; POINTS]) -> [f64; CELLS + 1] {
    GRID.map(|weights| weights.iter().zip(values).map(|(w, f)| w * f).sum())
}

/// The divided difference of order six over the length 2. For a sine of the amplitude 1 over a stretch of h
/// radians it is at most h⁶/46 080.
pub(crate) fn sixth(values: impl IntoIterator<Item = f64>) -> f64 {
    SIXTH.iter().zip(values).map(|(w, f)| w * f).sum()
}
