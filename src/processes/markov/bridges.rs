//! Gaussian Markov processes at the nodes of a grid.

use crate::error::{ParameterError, check};
use crate::numeric::split_mix::CounterRng;
use crate::processes::markov::grid::Grid;
use crate::processes::process::FORGOTTEN;
use nalgebra::SMatrix;
use rand_distr::{Distribution, StandardNormal};

/// The states of a stationary Gaussian Markov process of D components at the nodes k h of a grid.
///
/// The nodes are divided into blocks of 2^m cells that are so long that the states at their ends are
/// independent to rounding. Inside a block the state in the middle of an interval is drawn given those at
/// both its ends (the bridge), then those in the middle of both halves, and so on:
///
/// ```text
/// z(s) = Φ z0 + K (z1 - Φ² z0) + w,   K = Q Φᵀ (Φ Q Φᵀ + Q)⁻¹,   Cov w = Q - K Φ Q
/// ```
///
/// with the half interval s, its transition Φ = exp(A s) and the covariance Q of what enters in it. The
/// states are exact at all nodes, a state takes m draws, and a grid of half the spacing contains those of
/// this one.
#[derive(Debug)]
pub(crate) struct Bridges<const D: usize> {
    pub(crate) grid: Grid,
    /// From the whole block to two cells.
    levels: Vec<Level<D>>,
}

/// Weights of both ends in the mean of the middle state, and a root of its covariance.
#[derive(Debug)]
struct Level<const D: usize> {
    left: [[f64; D]; D],
    right: [[f64; D]; D],
    scatter: [[f64; D]; D],
}

/// The transition Φ over a time, and the covariance Q of what enters in it.
pub(crate) type Flow<const D: usize> = (SMatrix<f64, D, D>, SMatrix<f64, D, D>);

impl<const D: usize> Bridges<D> {
    /// A grid for a process with the correlation time `longest`, whose spacing lies between bounds that are
    /// not below 1e-12 of it: a block has less than 2^46 cells. `flow`: Φ and Q over a time.
    pub(crate) fn new(
        spacing: f64,
        bounds: [f64; 2],
        longest: f64,
        flow: impl Fn(f64) -> Flow<D>,
    ) -> Result<Self, ParameterError> {
        check::between("spacing of the grid", spacing, bounds)?;
        let grid = Grid { spacing };
        let depth = (0..).find(|m| spacing * (1u64 << m) as f64 >= FORGOTTEN * longest).unwrap_or(0);
        let halves = (0..depth).rev().map(|m| spacing * (1u64 << m) as f64);
        Ok(Bridges { grid, levels: halves.map(|s| Level::of_half(flow(s))).collect() })
    }

    /// The block of a cell.
    #[inline]
    pub(crate) fn block(&self, cell: i64) -> i64 {
        cell >> self.levels.len()
    }
    /// Length of a block.
    pub(crate) fn block_length(&self) -> f64 {
        self.grid.spacing * (1u64 << self.levels.len()) as f64
    }

    /// The states at both ends of a cell, from those at the ends of its block.
    #[inline]
    pub(crate) fn at_ends(&self, cell: i64, block: &CounterRng, ends: [[f64; D]; 2]) -> [[f64; D]; 2] {
        let [mut left, mut right] = ends;
        // Numbers of the middle states: 1 in the block, 2 and 3 in its halves, and so on.
        let mut number = 1;
        for (i, level) in self.levels.iter().enumerate() {
            let middle = level.middle(&left, &right, normals(&mut block.child(number)));
            let later = cell >> (self.levels.len() - 1 - i) & 1;
            *(if later == 1 { &mut left } else { &mut right }) = middle;
            number = 2 * number + later as u64;
        }
        [left, right]
    }
}

/// D standard normal numbers.
#[inline]
pub(crate) fn normals<const D: usize>(rng: &mut CounterRng) -> [f64; D] {
    std::array::from_fn(|_| StandardNormal.sample(rng))
}

impl<const D: usize> Level<D> {
    fn of_half((phi, q): Flow<D>) -> Self {
        let forward = phi * q * phi.transpose();
        // With covariances that underflow nothing is left to draw.
        let inverse = (forward + q).try_inverse().unwrap_or_else(SMatrix::zeros);
        let gain = q * phi.transpose() * inverse;
        Level {
            left: rows(phi - gain * phi * phi),
            right: rows(gain),
            scatter: rows(lower_root(q - gain * phi * q)),
        }
    }

    #[inline]
    fn middle(&self, left: &[f64; D], right: &[f64; D], normals: [f64; D]) -> [f64; D] {
        std::array::from_fn(|i| {
            let mut sum = 0.0;
            for j in 0..D {
                sum +=
                    self.left[i][j] * left[j] + self.right[i][j] * right[j] + self.scatter[i][j] * normals[j];
            }
            sum
        })
    }
}

fn rows<const D: usize>(matrix: SMatrix<f64, D, D>) -> [[f64; D]; D] {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))
}

/// The lower triangle L with L Lᵀ = C.
pub(crate) fn lower_root<const D: usize>(c: SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    let mut l = SMatrix::<f64, D, D>::zeros();
    for j in 0..D {
        let rest = c[(j, j)] - (0..j).map(|k| l[(j, k)] * l[(j, k)]).sum::<f64>();
        l[(j, j)] = rest.max(0.0).sqrt();
        for i in j + 1..D {
            let rest = c[(i, j)] - (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum::<f64>();
            l[(i, j)] = if l[(j, j)] > 0.0 { rest / l[(j, j)] } else { 0.0 };
        }
    }
    l
}
