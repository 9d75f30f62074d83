//! White noise behind a filter of second order.

use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::numeric::gauss;
use crate::numeric::split_mix::CounterRng;
use crate::processes::draws::Draws;
use crate::processes::markov::bridges::{Bridges, Flow, normals};
use crate::processes::markov::last_cell::LastCell;
use crate::processes::process::{Path, Process};
use crate::series::Series;
use nalgebra::Matrix2;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Filtered noise: the response of an oscillator to white noise, a Gaussian process with a resonance.
///
/// ```text
/// x'' + 2 ζ ω x' + ω² x = √D ξ(t),   D = 4 ζ ω³ σ²
/// mean 0,   variance σ²,   S(f) = 2 D/((ω² - φ²)² + (2 ζ ω φ)²) with φ = 2π f
/// correlation e^(-ζωs) (cos ω_d s + (ζω/ω_d) sin ω_d s) with s = |lag|, ω_d = ω √(1 - ζ²)
/// ```
///
/// with white noise ξ of intensity 1; sines of imaginary ω_d, ζ > 1, are hyperbolic ones. A road profile, a
/// torque ripple or a vibration of the foundation has such a density. Far below ω it is white noise of the
/// two-sided intensity D/ω⁴.
///
/// The values of x and x' at the nodes k h of a grid are exact, and a grid with half the spacing contains
/// them. Between nodes the path is the cubic with these values at both ends (Hermite). x'' jumps
/// at the nodes, so that they are drive edges.
///
/// Source: Chandrasekhar, Rev. Mod. Phys. 15 (1943) 1, Sec. II.3.
///
/// ```
/// use gear_dynamics::{excitation::Side, processes::{FilteredNoise, Process}};
/// let process = FilteredNoise::new(0.5, 200.0, 0.1, 1e-3)?; // 0.5 mm, 200 rad/s, ζ = 0.1, a grid of 1 ms
/// let path = process.path(0);
/// assert_eq!(path.series(0.0105, 8).coefficients().len(), 4);
/// assert!((path.series(0.0105, 8).at(2e-4) - path.at(0.0107, Side::After)).abs() < 1e-14);
/// assert!((process.correlation(0.0).expect("closed form") - 1.0).abs() < 1e-15);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct FilteredNoise {
    deviation: f64,
    filter: Filter,
    draws: Draws,
    /// For the state x/σ, x'/(σω).
    bridges: Arc<Bridges<2>>,
}

/// Natural frequency ω [rad per time unit] and damping ratio ζ.
#[derive(Clone, Copy, Debug)]
struct Filter {
    omega: f64,
    zeta: f64,
}

impl Filter {
    /// Decay rates of both exponentials over ω; their real parts if they are complex.
    fn rates(&self) -> [f64; 2] {
        if self.zeta > 1.0 {
            let sum = self.zeta + (self.zeta * self.zeta - 1.0).sqrt();
            [1.0 / sum, sum]
        } else {
            [self.zeta; 2]
        }
    }

    /// Φ over the phase p = ω s, in the state x, x'/ω.
    fn transition(&self, p: f64) -> Matrix2<f64> {
        let [slow, fast] = self.rates();
        // Response g to a unit step of x'/ω, and its slope.
        let (g, slope) = if self.zeta > 1.0 {
            let (decay, apart) = (libm::exp(-slow * p), fast - slow);
            let g = -libm::expm1(-apart * p) / apart;
            (decay * g, decay * (1.0 - fast * g))
        } else {
            let (decay, turn) = (libm::exp(-self.zeta * p), (1.0 - self.zeta * self.zeta).sqrt());
            let (sine, cosine) = libm::sincos(turn * p);
            let g = if turn > 0.0 { sine / turn } else { p };
            (decay * g, decay * (cosine - self.zeta * g))
        };
        Matrix2::new(slope + 2.0 * self.zeta * g, g, -g, slope)
    }

    /// Φ and Q = 4ζ ∫ (g, g')ᵀ (g, g') dp over a time, in the state x/σ, x'/(σω).
    fn flow(&self, time: f64) -> Flow<2> {
        let p = self.omega * time;
        // Short enough for the rule of ten points; then Q over two such times is Q + Φ Q Φᵀ.
        let fastest = p * self.rates()[1].max(1.0);
        let doublings = (0..).find(|n| fastest * 0.5f64.powi(*n) <= 0.5).unwrap_or(0);
        let short = p * 0.5f64.powi(doublings);
        let mut q = Matrix2::zeros();
        for (x, weight) in gauss::ten() {
            let response = self.transition(0.5 * short * (1.0 + x)).column(1).into_owned();
            q += response * response.transpose() * (2.0 * self.zeta * short * weight);
        }
        for n in (0..doublings).rev() {
            let phi = self.transition(p * 0.5f64.powi(n + 1));
            q += phi * q * phi.transpose();
        }
        (self.transition(p), q)
    }
}

impl FilteredNoise {
    /// A process with the standard deviation σ, the natural frequency ω `[rad/s]`, the damping ratio ζ `[1]`
    /// and the grid spacing h `[s]`, or in the time unit of the model. Defaults: seed 0, member 0.
    ///
    /// # Errors
    /// A standard deviation that is negative or beyond 1e50; a natural frequency outside 1e-50 .. 1e50; a
    /// damping ratio outside 1e-4 .. 100; a spacing above the shortest time of the filter, 1/ω, for ζ > 1
    /// 1/(ω (ζ + √(ζ² - 1))), which the grid then does not resolve; one below 1e-3 of it, where rounding of
    /// the covariances exceeds 1e-4.
    pub fn new(
        deviation: f64,
        natural_frequency: f64,
        damping_ratio: f64,
        spacing: f64,
    ) -> Result<Self, ParameterError> {
        let deviation = check::not_negative("standard deviation", deviation)?;
        let omega = check::scale("natural frequency", natural_frequency)?;
        check::positive("damping ratio", damping_ratio)?;
        check::between("damping ratio", damping_ratio, [1e-4, 100.0])?;
        let filter = Filter { omega, zeta: damping_ratio };
        let [slow, fast] = filter.rates();
        let (shortest, longest) = (1.0 / (omega * fast.max(1.0)), 1.0 / (omega * slow));
        let bridges = Bridges::new(spacing, [1e-3 * shortest, shortest], longest, |time| filter.flow(time))?;
        Ok(FilteredNoise { deviation, filter, draws: Draws::default(), bridges: Arc::new(bridges) })
    }
    /// The same process with another seed, for an independent experiment. Default: 0.
    pub fn seed(self, seed: u64) -> Self {
        FilteredNoise { draws: Draws { seed, ..self.draws }, ..self }
    }
    /// The same process for another member of an ensemble with the same seed. Default: 0.
    pub fn member(self, member: u64) -> Self {
        FilteredNoise { draws: Draws { member, ..self.draws }, ..self }
    }
}

impl Process for FilteredNoise {
    fn path(&self, stream: u64) -> Arc<dyn Path> {
        Arc::new(Cubics {
            deviation: self.deviation,
            omega: self.filter.omega,
            bridges: self.bridges.clone(),
            stream: self.draws.stream(stream),
            last: LastCell::new(),
        })
    }
    fn mean(&self) -> Option<f64> {
        Some(0.0)
    }
    fn variance(&self) -> Option<f64> {
        Some(self.deviation.powi(2))
    }
    fn correlation(&self, lag: f64) -> Option<f64> {
        Some(self.filter.transition(self.filter.omega * lag.abs())[(0, 0)])
    }
    fn density(&self, frequency: f64) -> Option<f64> {
        let Filter { omega, zeta } = self.filter;
        let ratio = TAU * frequency / omega;
        let (stiff, damped) = (1.0 - ratio * ratio, 2.0 * zeta * ratio);
        Some(8.0 * zeta / omega * self.deviation.powi(2) / (stiff * stiff + damped * damped))
    }
}

/// The value of a cubic at a share of its cell.
#[inline]
fn value(cubic: &[f64; 4], share: f64) -> f64 {
    cubic.iter().rev().fold(0.0, |sum, c| sum * share + c)
}

/// A path: cubics between the nodes.
struct Cubics {
    deviation: f64,
    omega: f64,
    bridges: Arc<Bridges<2>>,
    stream: CounterRng,
    last: LastCell<[f64; 4]>,
}

impl Cubics {
    /// The coefficients of the cubic of a cell over the share of it.
    #[inline]
    fn cubic(&self, cell: i64) -> [f64; 4] {
        self.last.of(cell, || self.draw(cell))
    }
    fn draw(&self, cell: i64) -> [f64; 4] {
        let block = self.bridges.block(cell);
        let draws = [block, block + 1].map(|b| self.stream.child(b as u64));
        // In the stationary state x/σ and x'/(σω) are independent, of variance 1.
        let ends = [&draws[0], &draws[1]].map(|draws| normals(&mut draws.child(0)));
        let rate = self.omega * self.bridges.grid.spacing;
        let [[x0, v0], [x1, v1]] = self
            .bridges
            .at_ends(cell, &draws[0], ends)
            .map(|[x, v]| [self.deviation * x, self.deviation * rate * v]);
        let rise = x1 - x0;
        [x0, v0, 3.0 * rise - 2.0 * v0 - v1, v0 + v1 - 2.0 * rise]
    }
}

impl Path for Cubics {
    fn at(&self, t: f64, _: Side) -> f64 {
        let cell = self.bridges.grid.cell(t);
        let share = self.bridges.grid.share(cell, t);
        value(&self.cubic(cell), share)
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.bridges.grid.next_node(t)
    }
    fn series(&self, t: f64, coefficients: usize) -> Series {
        let Bridges { grid, .. } = &*self.bridges;
        let cell = grid.cell(t);
        let share = Series::variable(grid.share(cell, t), 1.0 / grid.spacing, coefficients);
        let [value, linear, square, cube] = self.cubic(cell).map(Series::from);
        ((cube * share + square) * share + linear) * share + value
    }
}
