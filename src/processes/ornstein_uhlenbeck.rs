//! The Ornstein-Uhlenbeck process: noise with a correlation time.

use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::numeric::split_mix::CounterRng;
use crate::processes::draws::Draws;
use crate::processes::markov::bridges::{Bridges, normals};
use crate::processes::markov::last_cell::LastCell;
use crate::processes::process::{Path, Process};
use crate::series::Series;
use nalgebra::SMatrix;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The Ornstein-Uhlenbeck process: the Gaussian process whose correlation decays exponentially.
///
/// ```text
/// τ x' + x = σ √(2τ) ξ(t)
/// mean 0,   variance σ²,   correlation exp(-|lag|/τ),   S(f) = 4 σ² τ/(1 + (2π f τ)²)
/// ```
///
/// with white noise ξ of intensity 1. Far below the frequency 1/(2πτ) it is white noise of the two-sided
/// intensity D = 2 σ² τ.
///
/// The values at the nodes k h of a grid are exact, and a grid with half the spacing contains them. Between
/// nodes the path is a straight line, so that nodes are drive edges. This multiplies the density of the
/// values at the nodes by (sin(π f h)/(π f h))⁴ and leaves (2 + e^(-h/τ))/3 of the variance as a mean over
/// time: 97 % with h = τ/10.
///
/// Source: Uhlenbeck and Ornstein, Phys. Rev. 36 (1930) 823; Gillespie, Phys. Rev. E 54 (1996) 2084.
///
/// ```
/// use gear_dynamics::{excitation::Side, processes::{OrnsteinUhlenbeck, Process}};
/// let coarse = OrnsteinUhlenbeck::new(1.5, 0.02, 0.002)?; // 1.5 N m, 20 ms, a grid of 2 ms
/// let fine = OrnsteinUhlenbeck::new(1.5, 0.02, 0.0005)?;
/// assert_eq!(coarse.path(3).at(0.008, Side::After), fine.path(3).at(0.008, Side::After));
/// assert_eq!(coarse.path(3).next_edge(0.0081), Some(0.01));
/// assert_eq!(coarse.density(0.0), Some(4.0 * 1.5 * 1.5 * 0.02));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct OrnsteinUhlenbeck {
    deviation: f64,
    correlation_time: f64,
    draws: Draws,
    /// For the variance 1.
    bridges: Arc<Bridges<1>>,
}

impl OrnsteinUhlenbeck {
    /// A process with the standard deviation σ, the correlation time τ and the grid spacing h, in the time
    /// unit of the model. Defaults: seed 0, member 0.
    ///
    /// # Errors
    /// A standard deviation that is negative or beyond 1e50; a correlation time outside 1e-50 .. 1e50; a
    /// spacing above the correlation time, which the grid then does not resolve, or below 1e-12 of it.
    pub fn new(deviation: f64, correlation_time: f64, spacing: f64) -> Result<Self, ParameterError> {
        let deviation = check::not_negative("standard deviation", deviation)?;
        let tau = check::scale("correlation time", correlation_time)?;
        let bridges = Bridges::new(spacing, [1e-12 * tau, tau], tau, |time| {
            let (phi, q) = (libm::exp(-time / tau), -libm::expm1(-2.0 * time / tau));
            (SMatrix::from([[phi]]), SMatrix::from([[q]]))
        })?;
        let draws = Draws::default();
        Ok(OrnsteinUhlenbeck { deviation, correlation_time, draws, bridges: Arc::new(bridges) })
    }
    /// The same process with another seed, for an independent experiment. Default: 0.
    pub fn seed(self, seed: u64) -> Self {
        OrnsteinUhlenbeck { draws: Draws { seed, ..self.draws }, ..self }
    }
    /// The same process for another member of an ensemble with the same seed. Default: 0.
    pub fn member(self, member: u64) -> Self {
        OrnsteinUhlenbeck { draws: Draws { member, ..self.draws }, ..self }
    }
}

impl Process for OrnsteinUhlenbeck {
    fn path(&self, stream: u64) -> Arc<dyn Path> {
        let (deviation, bridges) = (self.deviation, self.bridges.clone());
        Arc::new(Lines { deviation, bridges, stream: self.draws.stream(stream), last: LastCell::new() })
    }
    fn mean(&self) -> Option<f64> {
        Some(0.0)
    }
    fn variance(&self) -> Option<f64> {
        Some(self.deviation.powi(2))
    }
    fn correlation(&self, lag: f64) -> Option<f64> {
        Some(libm::exp(-lag.abs() / self.correlation_time))
    }
    fn density(&self, frequency: f64) -> Option<f64> {
        let turn = TAU * frequency * self.correlation_time;
        Some(4.0 * self.deviation.powi(2) * self.correlation_time / (1.0 + turn * turn))
    }
}

/// The value at a share of a cell.
#[inline]
pub(crate) fn line([left, right]: &[f64; 2], share: f64) -> f64 {
    (1.0 - share) * left + share * right
}

/// A path: straight lines between the nodes.
struct Lines {
    deviation: f64,
    bridges: Arc<Bridges<1>>,
    stream: CounterRng,
    last: LastCell<[f64; 2]>,
}

impl Lines {
    /// The values at both ends of a cell.
    #[inline]
    fn ends(&self, cell: i64) -> [f64; 2] {
        self.last.of(cell, || self.draw(cell))
    }
    fn draw(&self, cell: i64) -> [f64; 2] {
        let block = self.bridges.block(cell);
        let draws = [block, block + 1].map(|b| self.stream.child(b as u64));
        let ends = [&draws[0], &draws[1]].map(|draws| normals(&mut draws.child(0)));
        self.bridges.at_ends(cell, &draws[0], ends).map(|[z]| self.deviation * z)
    }
}

impl Path for Lines {
    fn at(&self, t: f64, _: Side) -> f64 {
        let cell = self.bridges.grid.cell(t);
        line(&self.ends(cell), self.bridges.grid.share(cell, t))
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.bridges.grid.next_node(t)
    }
    fn series(&self, t: f64, coefficients: usize) -> Series {
        let [left, right] = self.ends(self.bridges.grid.cell(t));
        Series::variable(self.at(t, Side::After), (right - left) / self.bridges.grid.spacing, coefficients)
    }
}
