//! An order whose phase walks.

use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::numeric::split_mix::CounterRng;
use crate::processes::draws::Draws;
use crate::processes::markov::bridges::Bridges;
use crate::processes::markov::last_cell::LastCell;
use crate::processes::ornstein_uhlenbeck::line;
use crate::processes::process::{Path, Process};
use crate::scalar::Scalar;
use crate::series::Series;
use nalgebra::SMatrix;
use rand::RngExt;
use std::f64::consts::TAU;
use std::sync::Arc;

/// A jittered order: an order of a shaft whose phase walks at random.
///
/// ```text
/// x(t) = a cos(ω t + φ(t)),   φ' = √(2D) ξ(t),   φ(0) uniform
/// mean 0,   variance a²/2,   correlation exp(-D |lag|) cos(ω lag)
/// S(f) = a² (L(2π f - ω) + L(2π f + ω)),   L(φ) = D/(D² + φ²)
/// ```
///
/// with white noise ξ of intensity 1 and ω = n Ω for order n of a shaft of speed Ω. The line at ω/(2π) has
/// the width D/π `[Hz]` at half its height: firing of an engine that does not fire evenly.
///
/// The phases at the nodes k h of a grid are exact, and a grid with half the spacing contains them. Between
/// nodes the phase is a straight line, so that nodes are drive edges.
///
/// Source: Lin and Cai, Probabilistic Structural Dynamics, 1995.
///
/// ```
/// use gear_dynamics::{excitation::Side, processes::{JitteredOrder, Process}};
/// // Order 2 of a shaft of 100 rad/s, 5 N m, with a phase that walks by 0.6 rad in 0.1 s; a grid of 10 ms.
/// let process = JitteredOrder::new(5.0, 2.0 * 100.0, 1.8, 0.01)?;
/// assert_eq!(process.variance(), Some(12.5));
/// let path = process.path(0);
/// assert!(path.at(0.034, Side::After).abs() <= 5.0);
/// assert!((path.series(0.034, 20).at(5e-3) - path.at(0.039, Side::After)).abs() < 1e-12);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct JitteredOrder {
    amplitude: f64,
    frequency: f64,
    diffusion: f64,
    draws: Draws,
    bridges: Arc<Bridges<1>>,
}

impl JitteredOrder {
    /// An order with the amplitude a, the angular frequency ω `[rad/s]`, the diffusion D of its phase
    /// `[rad²/s]` and the grid spacing h `[s]`, or in the time unit of the model. Defaults: seed 0, member 0.
    ///
    /// # Errors
    /// An amplitude beyond ±1e50; an angular frequency, with ten standard deviations √(2 D/h) of the walk,
    /// beyond 1e9, above which Taylor coefficients overflow; a diffusion outside 1e-50 .. 1e50; a spacing
    /// above 1/D, the correlation time, which the grid then does not resolve, or below 1e-12 of it.
    pub fn new(
        amplitude: f64,
        angular_frequency: f64,
        diffusion: f64,
        spacing: f64,
    ) -> Result<Self, ParameterError> {
        let amplitude = check::quantity("amplitude", amplitude)?;
        let frequency = check::frequency("angular frequency", angular_frequency)?;
        let diffusion = check::scale("diffusion", diffusion)?;
        let walk = |time: f64| (SMatrix::from([[1.0]]), SMatrix::from([[2.0 * diffusion * time]]));
        let time = 1.0 / diffusion;
        let bridges = Arc::new(Bridges::new(spacing, [1e-12 * time, time], time, walk)?);
        let fastest = frequency.abs() + 10.0 * (2.0 * diffusion / spacing).sqrt();
        check::frequency(
            "angular frequency with ten standard deviations of the walk over a spacing",
            fastest,
        )?;
        Ok(JitteredOrder { amplitude, frequency, diffusion, draws: Draws::default(), bridges })
    }
    /// The same process with another seed, for an independent experiment. Default: 0.
    pub fn seed(self, seed: u64) -> Self {
        JitteredOrder { draws: Draws { seed, ..self.draws }, ..self }
    }
    /// The same process for another member of an ensemble with the same seed. Default: 0.
    pub fn member(self, member: u64) -> Self {
        JitteredOrder { draws: Draws { member, ..self.draws }, ..self }
    }
}

impl Process for JitteredOrder {
    fn path(&self, stream: u64) -> Arc<dyn Path> {
        Arc::new(Walk { order: self.clone(), stream: self.draws.stream(stream), last: LastCell::new() })
    }
    fn mean(&self) -> Option<f64> {
        Some(0.0)
    }
    fn variance(&self) -> Option<f64> {
        Some(0.5 * self.amplitude.powi(2))
    }
    fn correlation(&self, lag: f64) -> Option<f64> {
        Some(libm::exp(-self.diffusion * lag.abs()) * libm::cos(self.frequency * lag))
    }
    fn density(&self, frequency: f64) -> Option<f64> {
        let line = |apart: f64| {
            let ratio = apart / self.diffusion;
            1.0 / (self.diffusion * (1.0 + ratio * ratio))
        };
        let turn = TAU * frequency;
        Some(self.amplitude.powi(2) * (line(turn - self.frequency) + line(turn + self.frequency)))
    }
}

/// A path.
struct Walk {
    order: JitteredOrder,
    stream: CounterRng,
    last: LastCell<[f64; 2]>,
}

impl Walk {
    /// The phases at both ends of a cell.
    ///
    /// The phases at the ends of blocks are uniform and independent: their distribution modulo 2π forgets as
    /// e^(-D t). The walk from one to the next is δ + 2πk, with their difference δ, and k of the probability
    /// that a normal walk of the variance 2D L of the block has.
    fn draw(&self, cell: i64) -> [f64; 2] {
        let bridges = &self.order.bridges;
        let block = bridges.block(cell);
        let draws = [block, block + 1].map(|b| self.stream.child(b as u64));
        let [from, to] = [&draws[0], &draws[1]].map(|draws| TAU * draws.child(0).random::<f64>());
        let variance = 2.0 * self.order.diffusion * bridges.block_length();
        // All probabilities sum to 1, up to e^(-D L): Poisson's sum of the normal density at distances of 2π.
        let scale = TAU / (TAU * variance).sqrt();
        let mut left: f64 = draws[0].child(u64::MAX).random();
        let (apart, mut turns, mut walk) = (to - from, 0i32, 0.0);
        for _ in 0..WALKS {
            walk = apart + TAU * f64::from(turns);
            left -= scale * libm::exp(-walk * walk / (2.0 * variance));
            if left < 0.0 {
                break;
            }
            // 0, 1, -1, 2, -2, ...
            turns = if turns > 0 { -turns } else { 1 - turns };
        }
        bridges.at_ends(cell, &draws[0], [[from], [from + walk]]).map(|[phase]| phase)
    }
}

impl Walk {
    /// ω t + φ(t) and its rate.
    fn phase(&self, t: f64) -> (f64, f64) {
        let grid = self.order.bridges.grid;
        let cell = grid.cell(t);
        let ends = self.last.of(cell, || self.draw(cell));
        let rate = self.order.frequency + (ends[1] - ends[0]) / grid.spacing;
        (self.order.frequency * t + line(&ends, grid.share(cell, t)), rate)
    }
}

/// Number of turns that are tried: ±32 turns are more than ten standard deviations of a block.
const WALKS: usize = 65;

impl Path for Walk {
    fn at(&self, t: f64, _: Side) -> f64 {
        self.order.amplitude * libm::cos(self.phase(t).0)
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.order.bridges.grid.next_node(t)
    }
    fn series(&self, t: f64, coefficients: usize) -> Series {
        let (phase, rate) = self.phase(t);
        Series::variable(phase, rate, coefficients).cos() * self.order.amplitude
    }
}
