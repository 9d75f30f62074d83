//! Tori as Fourier series in several angles.

use crate::error::{ParameterError, check};
use crate::model::State;
use crate::tori::balance::angle_grid::AngleGrid;
use crate::tori::balance::wave_vectors::WaveVectors;
use crate::tori::circle::closed_curve::ClosedCurve;
use std::f64::consts::TAU;

/// q_j(θ) = c_j0 + Σ_k a_jk cos(k·θ) + b_jk sin(k·θ), θ = ω t: a quasi-periodic motion.
///
/// ```
/// use gear_dynamics::{Model, excitation::Side, tori::{QuasiPeriodic, TorusBalance, WaveVectors}};
/// struct TwoTones; // q'' + 0.1 q' + q = cos t√2 + cos t√3
/// impl Model for TwoTones {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) { a[0] = u[0] - 0.1 * v[0] - q[0]; }
///     fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
///         self.drive_at(&[2f64.sqrt() * t, 3f64.sqrt() * t], side, u);
///     }
/// }
/// impl QuasiPeriodic for TwoTones {
///     fn frequencies(&self) -> Vec<f64> { vec![2f64.sqrt(), 3f64.sqrt()] }
///     fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
///         u[0] = angles[0].cos() + angles[1].cos();
///     }
/// }
/// let balance = TorusBalance::new(WaveVectors::within(&[1, 1])?);
/// let torus = balance.solve(&TwoTones, &balance.at_rest(&TwoTones, &[0.0])?)?;
/// assert!((torus.amplitude(0, &[1, 0]) - 1.0 / 1.02f64.sqrt()).abs() < 1e-12); // 1/√((1 - 2)² + 0.01·2)
/// assert!((torus.amplitude(0, &[0, 1]) - 1.0 / 4.03f64.sqrt()).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Torus {
    vectors: WaveVectors,
    frequencies: Vec<f64>,
    /// Coordinate by coordinate: mean, then cosine and sine of each vector.
    coefficients: Vec<f64>,
    pub(crate) quality: TorusQuality,
}

/// What is known about the error of a torus; NaN where nothing was measured.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TorusQuality {
    pub(crate) residual: f64,
    pub(crate) between: f64,
    pub(crate) aliasing: f64,
    pub(crate) iterations: usize,
    pub(crate) evaluations: usize,
    pub(crate) residuals: Vec<f64>,
}

impl Default for TorusQuality {
    fn default() -> Self {
        TorusQuality {
            residual: f64::NAN,
            between: f64::NAN,
            aliasing: f64::NAN,
            iterations: 0,
            evaluations: 0,
            residuals: Vec::new(),
        }
    }
}

/// k·ω.
pub(crate) fn rate(k: &[i32], frequencies: &[f64]) -> f64 {
    k.iter().zip(frequencies).map(|(k, omega)| f64::from(*k) * omega).sum()
}

impl Torus {
    pub(crate) fn of(vectors: WaveVectors, frequencies: Vec<f64>, coefficients: Vec<f64>) -> Self {
        Torus { vectors, frequencies, coefficients, quality: TorusQuality::default() }
    }

    /// A motion at rest, `q` constant: a guess for [`TorusBalance::solve`](crate::tori::TorusBalance::solve).
    ///
    /// # Errors
    /// A number of frequencies other than that of the angles; a frequency outside 1e-50 .. 1e50; a coordinate
    /// beyond ±1e50; no coordinate; more than 2²⁶ coefficients.
    pub fn constant(vectors: &WaveVectors, frequencies: &[f64], q: &[f64]) -> Result<Self, ParameterError> {
        check::length("frequencies", frequencies.len(), vectors.angles())?;
        for (d, omega) in frequencies.iter().enumerate() {
            check::scale(format!("frequencies[{d}]"), *omega)?;
        }
        if q.is_empty() {
            return Err(ParameterError::Empty { name: "q".into(), min: 1 });
        }
        check::quantities("q", q)?;
        let width = vectors.unknowns();
        check::count("coefficients", &[q.len(), width], check::NUMBERS)?;
        let mut coefficients = vec![0.0; q.len() * width];
        coefficients.chunks_exact_mut(width).zip(q).for_each(|(c, q)| c[0] = *q);
        Ok(Torus::of(vectors.clone(), frequencies.to_vec(), coefficients))
    }

    /// The same series with other coefficients a cos(k·θ) + b sin(k·θ) of one coordinate at k; for k = 0, a
    /// is the mean and b has no effect.
    ///
    /// # Errors
    /// A coordinate or a wave vector that the series does not have; a coefficient beyond ±1e50.
    pub fn with(mut self, coordinate: usize, k: &[i32], [a, b]: [f64; 2]) -> Result<Self, ParameterError> {
        check::quantities("coefficients", &[a, b])?;
        if coordinate >= self.dof() {
            let (name, value, max) = ("coordinate".into(), coordinate, self.dof() - 1);
            return Err(ParameterError::TooMany { name, value, max });
        }
        let Some((index, mirrored)) = self.vectors.place(k) else {
            let value =
                k.iter().map(|k| f64::from(*k)).fold(0.0, |m: f64, k| if k.abs() > m.abs() { k } else { m });
            let name = format!("largest component of the wave vector {k:?}");
            let must = "belong to a wave vector that the series keeps (WaveVectors)".into();
            return Err(ParameterError::Wrong { name, value, must });
        };
        let start = coordinate * self.vectors.unknowns();
        if index == 0 {
            self.coefficients[start] = a;
        } else {
            let pair = [a, if mirrored { -b } else { b }];
            self.coefficients[start + 2 * index - 1..][..2].copy_from_slice(&pair);
        }
        self.quality = TorusQuality::default();
        Ok(self)
    }

    /// Base frequencies ω, in rad per time unit of the model.
    pub fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }
    /// Number of coordinates.
    pub fn dof(&self) -> usize {
        self.coefficients.len() / self.vectors.unknowns()
    }
    /// The kept wave vectors.
    pub fn wave_vectors(&self) -> &WaveVectors {
        &self.vectors
    }
    pub(crate) fn all(&self) -> &[f64] {
        &self.coefficients
    }
    pub(crate) fn set(&mut self, coefficients: &[f64]) {
        self.coefficients.copy_from_slice(coefficients);
    }
    /// The coefficients of one coordinate.
    fn part(&self, coordinate: usize) -> &[f64] {
        let width = self.vectors.unknowns();
        &self.coefficients[coordinate * width..(coordinate + 1) * width]
    }

    /// Coefficients [a, b] of a cos(k·θ) + b sin(k·θ); [mean, 0] for k = 0, zeros for a vector that is not
    /// kept.
    ///
    /// # Panics
    /// If the model has no such coordinate.
    pub fn coefficient(&self, coordinate: usize, k: &[i32]) -> [f64; 2] {
        let part = self.part(coordinate);
        match self.vectors.place(k) {
            None => [0.0, 0.0],
            Some((0, _)) => [part[0], 0.0],
            Some((index, mirrored)) => {
                let b = part[2 * index];
                [part[2 * index - 1], if mirrored { -b } else { b }]
            }
        }
    }
    /// Amplitude √(a² + b²) at k.
    ///
    /// # Panics
    /// If the model has no such coordinate.
    pub fn amplitude(&self, coordinate: usize, k: &[i32]) -> f64 {
        let [a, b] = self.coefficient(coordinate, k);
        a.hypot(b)
    }
    /// Largest coefficient of a coordinate, the mean included.
    pub(crate) fn largest_coefficient(&self, coordinate: usize) -> f64 {
        crate::numeric::norms::largest(self.part(coordinate))
    }

    /// The same series on other wave vectors: vectors that are not kept are dropped, new ones get zeros.
    pub fn on(&self, vectors: &WaveVectors) -> Torus {
        let mut all = vec![0.0; self.dof() * vectors.unknowns()];
        for (j, part) in all.chunks_exact_mut(vectors.unknowns()).enumerate() {
            for (index, k) in vectors.vectors().enumerate() {
                let pair = self.coefficient(j, k);
                match index {
                    0 => part[0] = pair[0],
                    _ => part[2 * index - 1..][..2].copy_from_slice(&pair),
                }
            }
        }
        Torus::of(vectors.clone(), self.frequencies.clone(), all)
    }

    /// Coordinates, velocities and accelerations at the given angles `[rad]`, written to `q`, `v` and `a`.
    pub(crate) fn motion(&self, angles: &[f64], [q, v, a]: [&mut [f64]; 3]) {
        let width = self.vectors.unknowns();
        for (j, part) in self.coefficients.chunks_exact(width).enumerate() {
            (q[j], v[j], a[j]) = (part[0], 0.0, 0.0);
        }
        for (index, k) in self.vectors.vectors().enumerate().skip(1) {
            let omega = rate(k, &self.frequencies);
            let (sin, cos) = rate(k, angles).sin_cos();
            for (j, part) in self.coefficients.chunks_exact(width).enumerate() {
                let (of_cos, of_sin) = (part[2 * index - 1], part[2 * index]);
                let value = of_cos * cos + of_sin * sin;
                q[j] += value;
                v[j] += omega * (of_sin * cos - of_cos * sin);
                a[j] -= omega * omega * value;
            }
        }
    }

    /// Coordinates and velocities at the given angles `[rad]`. The time of the state is 0.
    ///
    /// # Panics
    /// If the number of angles is not that of the frequencies.
    pub fn at_angles(&self, angles: &[f64]) -> State {
        assert_eq!(angles.len(), self.frequencies.len(), "one angle for each base frequency is needed");
        let n = self.dof();
        let (mut q, mut v, mut a) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        self.motion(angles, [&mut q, &mut v, &mut a]);
        State { t: 0.0, q, v }
    }
    /// The state at time t, at the angles ω t.
    pub fn at(&self, t: f64) -> State {
        let angles: Vec<f64> = self.frequencies.iter().map(|omega| omega * t).collect();
        State { t, ..self.at_angles(&angles) }
    }

    /// Mean of a coordinate.
    ///
    /// # Panics
    /// If the model has no such coordinate.
    pub fn mean(&self, coordinate: usize) -> f64 {
        self.part(coordinate)[0]
    }
    /// Root mean square √(c_0² + Σ (a_k² + b_k²)/2) of a coordinate, the mean included.
    ///
    /// # Panics
    /// If the model has no such coordinate.
    pub fn rms(&self, coordinate: usize) -> f64 {
        let part = self.part(coordinate);
        (part[0] * part[0] + 0.5 * part[1..].iter().map(|c| c * c).sum::<f64>()).sqrt()
    }
    /// Minimum and maximum of a coordinate on a grid of `points` equidistant values of every angle.
    ///
    /// # Errors
    /// No point, or more than 2²⁶ points in all angles together.
    ///
    /// # Panics
    /// If the model has no such coordinate.
    pub fn extremes(&self, coordinate: usize, points: usize) -> Result<[f64; 2], ParameterError> {
        check::at_least("points", points, 1)?;
        let sizes = vec![points; self.frequencies.len()];
        check::count("points of the grid", &sizes, check::NUMBERS)?;
        let mut grid = AngleGrid::new(&sizes);
        let zero = num_complex::Complex64::new(0.0, 0.0);
        let (mut z, part) = (vec![zero; grid.len()], self.part(coordinate));
        z[0].re = part[0];
        for (k, pair) in self.vectors.vectors().skip(1).zip(part[1..].chunks_exact(2)) {
            z[grid.place(k.iter().copied())] += num_complex::Complex64::new(pair[0], -pair[1]);
        }
        grid.synthesise(&mut z); // the real part is the series
        Ok(z.iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z.re), high.max(z.re)]))
    }
    /// Maximum less minimum of a coordinate on the same grid as [`extremes`](Torus::extremes).
    ///
    /// # Errors
    /// As [`extremes`](Torus::extremes).
    ///
    /// # Panics
    /// If the model has no such coordinate.
    pub fn peak_to_peak(&self, coordinate: usize, points: usize) -> Result<f64, ParameterError> {
        self.extremes(coordinate, points).map(|[low, high]| high - low)
    }

    /// The states at angle `strobe` = 0 and at `nodes` equidistant values of the other angle: a guess for
    /// [`CircleShooting`](crate::tori::CircleShooting).
    ///
    /// # Errors
    /// A torus with a number of base frequencies other than 2; an even number of nodes or fewer than 3; an
    /// index `strobe` above 1.
    pub fn section(&self, strobe: usize, nodes: usize) -> Result<ClosedCurve, ParameterError> {
        check::length("frequencies", self.frequencies.len(), 2)?;
        if strobe > 1 {
            return Err(ParameterError::TooMany { name: "strobe".into(), value: strobe, max: 1 });
        }
        let states: Vec<State> = (0..nodes)
            .map(|i| {
                let mut angles = [TAU * i as f64 / nodes as f64; 2];
                angles[strobe] = 0.0;
                self.at_angles(&angles)
            })
            .collect();
        ClosedCurve::new(&states)
    }
}
