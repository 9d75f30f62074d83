//! The density of deflection and velocity.

use crate::numeric::gauss;
use crate::random::density::grid::Grid;
use crate::random::density::panels::Panels;

/// The grid of results: polynomials of degree 8.
pub(crate) type Fine = Grid<9>;

/// p(x, v): the joint probability density of deflection and velocity, with ∫∫ p dx dv = 1 and p >= 0.
///
/// Errors are in the norm ∫∫ |p - exact| dx dv. The mean of a quantity that lies within ±M has at most M
/// times this error; a share has at most half of it.
///
/// ```
/// use gear_dynamics::models::Oscillator;
/// use gear_dynamics::random::PathIntegration;
/// let linear = [("speed", 1.0), ("damping", 0.5), ("linear stiffness", 1.0)];
/// let density = PathIntegration::new(1.0, [-5.0, 5.0], [-5.0, 5.0])?
///     .panels(4)
///     .stationary(&Oscillator::new(&linear)?)?;
/// let variance = density.mean(|x, _| x * x); // D/(2 c k) = 1
/// assert!((variance - 1.0).abs() < 0.01);
/// assert!((density.share(-1.0, 1.0) - 0.6827).abs() < density.total_error());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct StateDensity {
    pub(crate) grid: Fine,
    pub(crate) values: Vec<f64>,
    pub(crate) errors: Errors,
}

/// The parts of the error of a density.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Errors {
    pub(crate) step: f64,
    pub(crate) grid: f64,
    pub(crate) range: f64,
    pub(crate) iteration: f64,
}

impl StateDensity {
    /// A density from values that may be slightly negative: these become 0.
    pub(crate) fn new(grid: Fine, mut values: Vec<f64>, mut errors: Errors) -> Self {
        let negative = grid.nodes().zip(&values).map(|((_, weight), p)| weight * (-p).max(0.0)).sum::<f64>();
        values.iter_mut().for_each(|p| *p = p.max(0.0));
        let mass = grid.integral(&values, |_| 1.0);
        values.iter_mut().for_each(|p| *p /= mass);
        errors.grid += 2.0 * negative;
        StateDensity { grid, values, errors }
    }

    /// p at a deflection and a velocity, in 1/(unit of x · unit of v); 0 outside of the ranges.
    pub fn at(&self, x: f64, v: f64) -> f64 {
        self.grid.value(&self.values, x, v).max(0.0)
    }

    /// The density of the deflection, ∫ p dv.
    pub fn deflection_density(&self, x: f64) -> f64 {
        self.along_velocity(x, |_| 1.0)
    }

    /// The density of the velocity, ∫ p dx.
    pub fn velocity_density(&self, v: f64) -> f64 {
        let Some((column, values)) = self.grid.v.stencil(v) else { return 0.0 };
        let rows = self.values.chunks(self.grid.v.len()).zip(&self.grid.x.weights);
        let at = |row: &[f64]| row[column..].iter().zip(&values).map(|(p, l)| p * l).sum::<f64>();
        rows.map(|(row, weight)| weight * at(row)).sum::<f64>().max(0.0)
    }

    /// The probability of a deflection between two values, ∫∫ p dx dv over from <= x <= to.
    pub fn share(&self, from: f64, to: f64) -> f64 {
        let parts = self.grid.x.borders().windows(2).map(|panel| [panel[0].max(from), panel[1].min(to)]);
        parts
            .filter(|[low, high]| low < high)
            .map(|[low, high]| gauss::integral(low, high, |x| self.deflection_density(x)))
            .sum()
    }

    /// The mean of a function of deflection and velocity, ∫∫ f p dx dv. The function should be smooth apart
    /// from the edges of the model and the velocity 0.
    pub fn mean(&self, f: impl Fn(f64, f64) -> f64) -> f64 {
        self.grid.integral(&self.values, |[x, v]| f(x, v))
    }

    /// The mean number of upward crossings of a deflection per unit of time, ∫ v p(x, v) dv over v > 0.
    /// Source: Rice 1944.
    pub fn upward_crossing_rate(&self, x: f64) -> f64 {
        self.along_velocity(x, |v| v.max(0.0))
    }

    /// The mean number of downward crossings of a deflection per unit of time, ∫ |v| p(x, v) dv over v < 0.
    pub fn downward_crossing_rate(&self, x: f64) -> f64 {
        self.along_velocity(x, |v| (-v).max(0.0))
    }

    /// ∫ f(v) p(x, v) dv.
    fn along_velocity(&self, x: f64, f: impl Fn(f64) -> f64) -> f64 {
        let Some((row, values)) = self.grid.x.stencil(x) else { return 0.0 };
        let Panels { nodes, weights, .. } = &self.grid.v;
        let line = |row: &[f64]| {
            row.iter().zip(nodes.iter().zip(weights)).map(|(p, (v, w))| w * f(*v) * p).sum::<f64>()
        };
        let rows = self.values.chunks(nodes.len()).skip(row).zip(values);
        rows.map(|(row, l)| l * line(row)).sum::<f64>().max(0.0)
    }

    /// The deflections of the grid; the edges of the model are among them.
    pub fn deflections(&self) -> &[f64] {
        &self.grid.x.nodes
    }
    /// The velocities of the grid.
    pub fn velocities(&self) -> &[f64] {
        &self.grid.v.nodes
    }
    /// p at the nodes of the grid, all velocities of the first deflection, then those of the next.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The estimated error, the sum of the four errors below `[1]`.
    pub fn total_error(&self) -> f64 {
        let Errors { step, grid, range, iteration } = self.errors;
        step + grid + range + iteration
    }
    /// The error of the time step: the distance of the extrapolated density from that with the smaller step.
    pub fn step_error(&self) -> f64 {
        self.errors.step
    }
    /// The error of the grid: the distance from the density with polynomials of degree 6, and twice the
    /// negative part that was set to 0.
    pub fn grid_error(&self) -> f64 {
        self.errors.grid
    }
    /// The error of the ranges: the probability outside, estimated from the fall of the density in the
    /// outermost panels, and that which is lost or gained during the relaxation.
    pub fn range_error(&self) -> f64 {
        self.errors.range
    }
    /// The error of the iteration: what further repetitions would still change.
    pub fn iteration_error(&self) -> f64 {
        self.errors.iteration
    }
}
