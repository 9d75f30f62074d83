//! Functions of the mesh cycle that are smooth between jumps.

use crate::error::{ParameterError, check};
use crate::excitation::{Angle, Excitation, Fourier, Jet};
use crate::numeric::gauss::ten;
use crate::scalar::Scalar;
use std::f64::consts::{PI, TAU};

/// An excitation with smooth pieces between jumps: a polynomial in Chebyshev form on each piece.
///
/// Its edges are announced, so that steps end at them; derivatives are those of the polynomials.
/// [`fourier_series`](Piecewise::fourier_series) returns its truncated Fourier series.
///
/// ```
/// use gear_dynamics::{excitation::{Excitation, Side}, teeth::Piecewise, ParameterError, Wave};
/// // cos φ up to φ = 1, 2 cos φ beyond it.
/// let step = Piecewise::fit(&[0.0, 1.0], 1e-12, |middle, x: f64| {
///     Ok::<f64, ParameterError>(if middle < 1.0 { x.cos() } else { 2.0 * x.cos() })
/// })?;
/// assert!(step.error() < 1e-11 && (step.jet(2.0).second + 2.0 * 2f64.cos()).abs() < 1e-8);
/// assert_eq!(step.edges(), [0.0, 1.0]);
/// let wave = Wave::new(step);
/// assert!((wave.value(1.0, Side::Before) - 1f64.cos()).abs() < 1e-11);
/// # Ok::<(), ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Piecewise {
    pieces: Vec<Stretch>,
    error: f64,
}

#[derive(Clone, Debug, PartialEq)]
struct Stretch {
    from: f64,
    to: f64,
    /// Coefficients of the Chebyshev polynomials T_0, T_1, ...
    coefficients: Vec<f64>,
}

/// Most Chebyshev coefficients of a piece.
const LONGEST: usize = 128;

/// Shortest piece `[rad]`. A shorter one is left out: waves do not separate edges that are closer.
const SHORTEST: f64 = 1e-9;

impl Stretch {
    /// The interpolation of a function at n Chebyshev points.
    fn interpolate<E>(from: f64, to: f64, n: usize, f: &impl Fn(f64) -> Result<f64, E>) -> Result<Self, E> {
        let at = |k: usize| libm::cos(PI * (k as f64 + 0.5) / n as f64);
        let values: Result<Vec<f64>, E> =
            (0..n).map(|k| f(0.5 * (from + to) + 0.5 * (to - from) * at(k))).collect();
        let values = values?;
        let coefficient = |j: usize| {
            let sum: f64 = (0..n)
                .map(|k| values[k] * libm::cos(PI * ((j * (2 * k + 1)) % (4 * n)) as f64 / (2 * n) as f64))
                .sum();
            sum * if j == 0 { 1.0 } else { 2.0 } / n as f64
        };
        Ok(Stretch { from, to, coefficients: (0..n).map(coefficient).collect() })
    }

    /// The polynomial by Clenshaw's algorithm, for every number type.
    fn jet<S: Scalar>(&self, angle: S) -> Jet<S> {
        let half = 0.5 * (self.to - self.from);
        let x = (Jet::variable(angle) + (-0.5 * (self.from + self.to))) * (1.0 / half);
        let zero = Jet::constant(S::from(0.0));
        let (mut b1, mut b2) = (zero, zero);
        for c in self.coefficients.iter().skip(1).rev() {
            (b1, b2) = (x * b1 * 2.0 - b2 + *c, b1);
        }
        x * b1 - b2 + self.coefficients.first().copied().unwrap_or(0.0)
    }
    fn value<S: Scalar>(&self, angle: S) -> S {
        let (middle, half) = (0.5 * (self.from + self.to), 0.5 * (self.to - self.from));
        let x = (angle - S::from(middle)) / S::from(half);
        let (mut b1, mut b2) = (S::from(0.0), S::from(0.0));
        for c in self.coefficients.iter().skip(1).rev() {
            (b1, b2) = (x * 2.0 * b1 - b2 + S::from(*c), b1);
        }
        x * b1 - b2 + S::from(self.coefficients.first().copied().unwrap_or(0.0))
    }
    /// ∫ of the piece: ∫ T_j = 2/(1 - j²) from -1 to 1 for even j.
    fn integral(&self) -> f64 {
        let terms = self.coefficients.iter().enumerate().step_by(2);
        terms.map(|(j, c)| c * 2.0 / (1.0 - (j * j) as f64)).sum::<f64>() * 0.5 * (self.to - self.from)
    }
}

impl Piecewise {
    /// Fits a function between `edges` in [0, 2π), increasing; the last piece continues to the first edge
    /// plus 2π. `f` receives the middle of the piece, which says on which side of a jump to evaluate, and an
    /// angle inside the piece, which may exceed 2π if the first edge is not 0.
    ///
    /// The number of Chebyshev points is doubled from 16 to at most 128 until the error at points between
    /// them is below `tolerance` times the largest value. [`error`](Piecewise::error) returns the error
    /// reached.
    ///
    /// # Errors
    /// No edges, edges outside [0, 2π) or decreasing; a value beyond ±1e50; errors of `f`.
    pub fn fit<E: From<ParameterError>>(
        edges: &[f64],
        tolerance: f64,
        f: impl Fn(f64, f64) -> Result<f64, E>,
    ) -> Result<Self, E> {
        let mut last = *edges.first().ok_or(ParameterError::Empty { name: "edges".into(), min: 1 })?;
        for (i, &value) in edges.iter().enumerate() {
            let name = || format!("edges[{i}]");
            if !(0.0..TAU).contains(&value) {
                return Err(ParameterError::OutOfRange { name: name(), value, allowed: "[0, 2π)" }.into());
            }
            if value < last {
                let must = format!("be at least {last:?}, the edge before it");
                return Err(ParameterError::Wrong { name: name(), value, must }.into());
            }
            last = value;
        }
        let ends = edges.iter().skip(1).copied().chain([edges[0] + TAU]);
        let (mut pieces, mut error) = (Vec::new(), 0.0f64);
        for (&from, to) in edges.iter().zip(ends).filter(|(from, to)| *to - **from > SHORTEST) {
            let middle = 0.5 * (from + to);
            let checked = |angle: f64| {
                let value = f(middle, angle)?;
                check::quantity("value of a piece", value).map_err(E::from)
            };
            let mut points = 16;
            let (piece, reached) = loop {
                let piece = Stretch::interpolate(from, to, points, &checked)?;
                let reached = piece.deviation(&checked)?;
                if reached <= tolerance || points >= LONGEST {
                    break (piece.shortened(), reached);
                }
                points *= 2;
            };
            error = error.max(reached);
            pieces.push(piece);
        }
        Ok(Piecewise { pieces, error })
    }

    /// Largest error of the pieces at points between the Chebyshev points, as a share of the largest value
    /// `[1]`.
    pub fn error(&self) -> f64 {
        self.error
    }
    /// Mean over a period.
    pub fn mean(&self) -> f64 {
        self.pieces.iter().map(Stretch::integral).sum::<f64>() / TAU
    }

    /// The Fourier series up to `order`: mean, c_n = 1/π ∫ f cos nφ dφ, s_n = 1/π ∫ f sin nφ dφ, by the rule
    /// of Gauss with 10 points on panels of at most half a period of the highest order.
    ///
    /// # Errors
    /// An order above 1000.
    pub fn fourier_series(&self, order: usize) -> Result<Fourier, ParameterError> {
        check::count("order of the series", &[order], 1000)?;
        let mut pairs = vec![[0.0; 2]; order];
        for piece in &self.pieces {
            let length = piece.to - piece.from;
            let panels = 1.0 + (length * order as f64 / PI).ceil() + piece.coefficients.len() as f64 / 8.0;
            let panels = panels as usize;
            let half = 0.5 * length / panels as f64;
            for panel in 0..panels {
                let middle = piece.from + half * (2 * panel + 1) as f64;
                for (x, weight) in ten() {
                    let angle = middle + half * x;
                    let part = piece.value(angle) * weight * half / PI;
                    for (n, pair) in pairs.iter_mut().enumerate() {
                        let (sin, cos) = libm::sincos((n + 1) as f64 * angle);
                        *pair = [pair[0] + part * cos, pair[1] + part * sin];
                    }
                }
            }
        }
        Fourier::new(self.mean(), &pairs)
    }

    /// The piece at an angle in [0, 2π), and the angle on it.
    fn piece(&self, angle: f64) -> (&Stretch, f64) {
        let next = self.pieces.partition_point(|piece| piece.from <= angle);
        match next {
            0 => (&self.pieces[self.pieces.len() - 1], TAU),
            _ => (&self.pieces[next - 1], 0.0),
        }
    }
}

impl Stretch {
    /// Largest deviation from a function at points between the Chebyshev points, over the largest value.
    fn deviation<E>(&self, f: &impl Fn(f64) -> Result<f64, E>) -> Result<f64, E> {
        let (mut deviation, mut size, n) = (0.0f64, f64::MIN_POSITIVE, self.coefficients.len());
        for k in 1..n {
            let x = libm::cos(PI * k as f64 / n as f64);
            let angle = 0.5 * (self.from + self.to) + 0.5 * (self.to - self.from) * x;
            let value = f(angle)?;
            deviation = deviation.max((value - self.value(angle)).abs());
            size = size.max(value.abs());
        }
        Ok(deviation / size)
    }
    /// The piece without its last coefficients, if they are rounding: their derivatives would not be.
    fn shortened(mut self) -> Self {
        let largest = self.coefficients.iter().fold(0.0f64, |m, c| m.max(c.abs()));
        let needed = self.coefficients.iter().rposition(|c| c.abs() > 1e-14 * largest);
        self.coefficients.truncate(needed.map_or(1, |last| last + 1));
        self
    }
}

impl Excitation for Piecewise {
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
        angle.by_pieces(|inside, angle| {
            let (piece, turn) = self.piece(inside);
            piece.jet(angle + A::Number::from(turn))
        })
    }
    fn value<A: Angle>(&self, angle: A) -> A::Number {
        let value = angle.by_pieces(|inside, angle| {
            let (piece, turn) = self.piece(inside);
            Jet::constant(piece.value(angle + A::Number::from(turn)))
        });
        value.value
    }
    fn edges(&self) -> Vec<f64> {
        self.pieces.iter().map(|piece| piece.from).collect()
    }
}
